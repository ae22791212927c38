"""Real maps: the GeoJSON scenes of a folder, built and asked like the scattered ones."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

import numpy as np

from asking import Asked, asked
from building import Build, built
from measure import Table, clocked, in_words
from scattered import free_places
from taut.formats import load_scene
from taut.freespace import FreeSpace
from taut.roadmap import visibility_graph
from taut.route import direct_lengths, distances, prepare

SEED = 1
PAIRS = 2000
TITLE = "Real maps"


@dataclass(frozen=True)
class RealMap:
    """One map: what building takes, seconds to load its file, and seconds a pair between random free places."""

    name: str
    loading: float
    build: Build
    astar: Asked
    direct: Asked
    differ: float


def real_maps(folder: Path) -> tuple[RealMap, ...]:
    """Measure all GeoJSON files of a folder, the smallest map first."""
    files = sorted(p for p in folder.iterdir() if p.suffix == ".geojson")
    if not files:
        raise SystemExit(f"no .geojson files in {folder}")
    return tuple(sorted(map(_measured, files), key=lambda m: m.build.corners))


def table(found: tuple[RealMap, ...]) -> Table:
    """Return one row a map."""
    return Table(
        TITLE,
        (
            "map",
            "corners",
            "edges",
            "free space",
            "triangulation",
            "tangent graph",
            "together",
            "on one thread",
            "A*: batch",
            "A*: one a call",
            "interval search: batch",
            "interval search: one a call",
        ),
        tuple(
            (
                m.name,
                f"{m.build.corners:,}",
                f"{m.build.edges:,}",
                *map(in_words, (m.build.region, m.build.mesh, m.build.tangents, m.build.together, m.build.alone)),
                *map(in_words, (m.astar.batch, m.astar.single, m.direct.batch, m.direct.single)),
            )
            for m in found
        ),
        "GeoJSON scenes given by `--maps FOLDER`: outer wall and obstacles, no growth; from a Scene in memory; warm, "
        "medians.",
        (
            f"A pair: {PAIRS:,} random pairs in the largest connected part, mean. corners: of the free space, reflex "
            "or not.",
            f"A* and interval search agree on all lengths to {max(m.differ for m in found):.1e} relative.",
        ),
    )


def in_short(m: RealMap) -> str:
    """Say in one line what was measured, to be printed at once."""
    return (
        f"{m.name}: {m.build.corners:,} corners, loaded in {in_words(m.loading)}, built in "
        f"{in_words(m.build.together)}; a pair by A* {in_words(m.astar.batch)}"
    )


def _measured(path: Path) -> RealMap:
    loading = clocked(lambda: load_scene(path))
    scene = load_scene(path)
    freespace = FreeSpace(scene)
    index = prepare(freespace)
    starts, goals = np.split(free_places(freespace, 2 * PAIRS, SEED), 2)
    build = built(scene, freespace, len(freespace.mesh.vertices), visibility_graph(freespace).graph.m)
    astar = asked(lambda a, b: distances(index, a, b), starts, goals)
    direct = asked(lambda a, b: direct_lengths(freespace, a, b), starts, goals)
    by_search = direct_lengths(freespace, starts, goals)[0]
    differ = float(np.abs(by_search / distances(index, starts, goals) - 1).max())
    return RealMap(path.stem, loading, build, astar, direct, differ)
