"""Team instances of the field's benchmarks, and what the peers achieved on them: files that are not part of taut.

A folder holds ``maps/*.map`` (MovingAI), ``teams/instances/*.json``, ``teams/roadmap_*.npz``, ``teams/stgcs_*.json``
and ``teams/results/*.csv``.
"""

from __future__ import annotations

import csv
import json
import math
from dataclasses import dataclass
from functools import cache
from pathlib import Path
from typing import Any

from taut.formats import free_cells, load_map, load_roadmap
from taut.roadmap import Lanes, grid_lanes
from taut.scene import Polygon, Robot, Scene

ROADMAPS = ("roadmap-sparse", "roadmap-dense", "roadmap-super-dense")
GRIDS = ("empty-16-16", "room-64-64-8", "warehouse-10-20-10-2-2", "den520d")
STGCS = ("complex2d", "simple2d", "empty2d")
DIRECTIONS = {"room-64-64-8": 16}
"""In which the lanes of a grid lead, where these are not 32."""


@dataclass(frozen=True)
class Instance:
    """A team to plan: ``robots`` is their number; on ``lanes`` if there are any, else anywhere."""

    family: str
    number: int
    robots: int
    scene: Scene
    lanes: Lanes | None


@dataclass(frozen=True)
class Record:
    """What a peer achieved: seconds of its planner, sum of costs in seconds, least distance between centres, metres."""

    planner: str
    family: str
    number: int
    robots: int
    solved: bool
    seconds: float
    cost: float
    distance: float


def records(folder: Path) -> list[Record]:
    """Read what all peers achieved."""
    out = []
    for path in sorted((folder / "teams" / "results").glob("*.csv")):
        with path.open(encoding="utf-8", newline="") as file:
            out += [_record(path.stem, row) for row in csv.DictReader(file)]
    return out


def _record(name: str, row: dict[str, str]) -> Record:
    def number(*heads: str) -> float:
        text = next((row[head] for head in heads if row.get(head)), "")
        return float(text) if text else math.nan

    family = row.get("map") or row.get("env") or ""
    planner = row["planner"] + (f" {row['config']}" if row.get("config") else "")
    if name.startswith("ccbs"):
        _, family, *variant = name.split("_")
        planner = " ".join([planner, *variant])
        family = family if family in GRIDS else f"roadmap-{family}"
    return Record(
        planner,
        family,
        int(row["instance"]),
        int(row["n"]),
        row["success"] == "1",
        number("planner_runtime_s", "runtime_s_authors_machine"),
        number("flowtime", "sum_cost"),
        number("min_centre_dist"),
    )


def read(folder: Path, family: str, number: int, robots: int) -> Instance:
    """Read an instance with its first robots."""
    if family in STGCS:
        return Instance(family, number, robots, _stgcs(folder, family, number, robots), None)
    asked = json.loads((folder / "teams" / "instances" / f"{family}_{number}.json").read_text(encoding="utf-8"))
    if family in ROADMAPS:
        lanes = _roadmap(folder / "teams" / f"{family.replace('-', '_', 1)}.npz")
        ends = [lanes.positions[asked[key][:robots]].tolist() for key in ("start_id", "goal_id")]
        low, high = lanes.positions.min(axis=0) - asked["radius"], lanes.positions.max(axis=0) + asked["radius"]
        ground = Scene((*low.tolist(), *high.tolist()), name=f"{family}-{number}")
    else:
        ground, lanes = _grid(folder / "maps" / f"{family}.map")
        rows = round(ground.workspace[2][1] - ground.workspace[0][1])
        ends = [[(column, rows - 1 - row) for row, column in asked[key][:robots]] for key in ("starts", "goals")]
    team = [
        Robot(f"R{k + 1}", start, goal, radius=asked["radius"], speed=asked["speed"])
        for k, (start, goal) in enumerate(zip(*ends, strict=True))
    ]
    return Instance(family, number, robots, _manned(ground, team), lanes)


def _manned(ground: Scene, team: list[Robot]) -> Scene:
    return Scene(ground.workspace, ground.obstacles, team, name=ground.name)


@cache
def _roadmap(path: Path) -> Lanes:
    return load_roadmap(path)


@cache
def _grid(path: Path) -> tuple[Scene, Lanes]:
    """The map, and lanes between its free cells' centres; planning leaves out those too near to blocked cells."""
    ground = load_map(path)
    return ground, grid_lanes(free_cells(path), DIRECTIONS.get(path.stem, 32))


def _stgcs(folder: Path, family: str, number: int, robots: int) -> Scene:
    """A scene of ST-GCS without moving discs; their bounds confine centres, so the workspace is a radius wider."""
    every: list[dict[str, Any]] = json.loads((folder / "teams" / f"stgcs_{family}.json").read_text(encoding="utf-8"))
    asked = next(entry for entry in every if (entry["n"], entry["seed"]) == (robots, number))
    radius = asked["robot_radius"]
    (left, low), (right, high) = asked["lb"], asked["ub"]
    team = [
        Robot(f"R{k + 1}", start, goal, radius=radius, speed=asked["vlimit"], start_time=since)
        for k, (start, goal, since) in enumerate(
            zip(asked["starts"], asked["goals"], asked["start_times"], strict=True)
        )
    ]
    obstacles = [Polygon(corners, name=f"O{k + 1}") for k, corners in enumerate(asked["static_polygons"])]
    bounds = left - radius, low - radius, right + radius, high + radius
    return Scene(bounds, obstacles, team, name=f"{family}-{robots}-{number}")
