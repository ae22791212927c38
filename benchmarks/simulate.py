"""The suite of simulation: steps a second of large teams, lidars, and whether the margin of a study is enough.

python benchmarks/simulate.py [SCENE …] [--study N] [--runs N] makes the last table alone, as long as you like.
"""

from __future__ import annotations

import argparse
from collections.abc import Sequence
from dataclasses import replace

import numpy as np

import lidar
from measure import LEFT_OUT, Report, Table, machine, median_time, one_thread
from taut.formats.files import load_scene
from taut.generate import random_scene
from taut.motion import Plan
from taut.scene import Scene
from taut.simulation import Disturbances, Lidar, Study, study, with_margin
from taut.simulation.driving import Driven, Watching, drive
from taut.simulation.running import longest, looking, prepared
from taut.team import plan

SCENES = ("thesis-1", "thesis-2", "appendix-d", "warehouse-50")
STUDY, RUNS = 3000, 1000
QUICK = 50
WIDENED = {"thesis-1": 1.0, "thesis-2": 1.0}
"""Metres by which the workspace is widened on every side: their robots are points that slide along the wall."""

RADIUS = 0.15
MET = Disturbances(speed_error=0.2, stops=1 / 20)
STEPS_TITLE = "Simulation: steps a second"
SAFE_TITLE = "Simulation: teams with the margin of a study"
TITLES = (STEPS_TITLE, lidar.TITLE, SAFE_TITLE)
"""Of the sections, in the order of the page."""


def suite(quick: bool) -> Report:
    """Measure all tables."""
    safe = safety(SCENES, QUICK if quick else STUDY, QUICK if quick else RUNS)
    return Report((speed(quick), lidar.looking(quick), safe))


def speed(quick: bool) -> Table:
    """Steps a second on one core: 50 robots that look around at every step, and many that do not."""
    count = 100 if quick else 1000
    rows = (
        _speed_row("warehouse-50, 181-beam lidars", plan(_stout("warehouse-50")).plan, Lidar(), "200"),
        _speed_row("warehouse-50", plan(_stout("warehouse-50")).plan, None, LEFT_OUT),
        _speed_row(f"hall, {count:,} robots", plan(_hall(count)).plan, None, LEFT_OUT if quick else "1,000"),
    )
    heads = ("team", "robots", "steps a second", "target", "ns a robot and step")
    before = (
        "Differential drives, steps of 0.02 s, coordination on, disturbances as in the table of margins; from start to "
        "the last arrival, on one core; medians of up to 3 runs. Robots with lidars look around at every step."
    )
    notes = (
        f"hall, {count:,} robots is `taut random --robots {count} --obstacles 400 --size 200 --seed 1`.",
        "target: at least.",
    )
    return Table(STEPS_TITLE, heads, rows, before, notes)


def safety(scenes: Sequence[str], learnt: int, runs: int) -> Table:
    """What a study of each scene finds, and how teams fare whose plans leave its margin, on other seeds."""
    rows = tuple(row for name in scenes for row in _safety_rows(name, learnt, runs))
    heads = ("scene and plan", "runs", "all arrived", "collided", "off the path", "apart", "makespan")
    before = (
        "Differential drives of radius 0.15 m under speed errors of ±20 % and a random stop every 20 s of 2 s on "
        f"average. The margin is that of a study of {learnt:,} runs; the plan with the margin is driven with seeds "
        "that are not in the study. The workspaces of thesis-1 and thesis-2 are widened by 1 m on every side."
    )
    notes = (
        "collided: runs with a collision, of two robots or of a robot and an obstacle; without the margin plans lead "
        "along obstacles, which they may touch.",
        "off the path: the greatest of all runs. apart: the least distance between the outlines of two robots.",
        "makespan: median, in brackets that of the plan.",
    )
    return Table(SAFE_TITLE, heads, rows, before, notes)


def _safety_rows(name: str, learnt: int, runs: int) -> list[tuple[str, ...]]:
    scene = _stout(name)
    learning = study(plan(scene).plan, range(learnt), disturbances=MET)
    margin = learning.margin
    roomy = plan(with_margin(scene, margin.metres)).plan
    fresh = range(learnt, learnt + runs)
    return [
        _row(f"{name}: study (p = {margin.probability:.4g})", learning),
        _row(f"{name}: margin {1000 * margin.metres:.0f} mm", study(roomy, fresh, disturbances=MET)),
        _row(
            f"{name}: the same, no coordination",
            study(roomy, fresh, disturbances=MET, coordination=False),
        ),
    ]


def _row(words: str, found: Study) -> tuple[str, ...]:
    apart = min((t.separation for t in found.trials if t.separation is not None), default=float("nan"))
    stray = max(trial.stray for trial in found.trials)
    median = found.makespans[1]
    return (
        words,
        f"{len(found.trials):,}",
        f"{found.complete:,}",
        f"{found.collided:,}",
        f"{1000 * stray:.1f} mm",
        f"{1000 * apart:.1f} mm",
        f"{median:.1f} s ({found.planned:.1f})",
    )


def _speed_row(words: str, team: Plan, eyes: Lidar | None, target: str) -> tuple[str, ...]:
    setting, _ = prepared(team, "differential", True, 0.02)
    n = len(setting.names)

    def driven() -> Driven:
        return drive(setting, MET, 0, longest(team), 1 if eyes else 5, _watching(team, eyes))

    with one_thread():
        steps = driven().seconds / setting.dt
        spent = median_time(driven, most=3, budget=10.0)
    return words, f"{n:,}", f"{steps / spent:,.0f}", target, f"{1e9 * spent / steps / n:,.0f}"


def _watching(team: Plan, eyes: Lidar | None) -> Watching | None:
    return None if eyes is None else looking(team, eyes, 0, [])


def _stout(name: str) -> Scene:
    """A ready scene with robots of radius 0.15 m, its workspace widened where it is too tight for them."""
    scene = load_scene(name)
    more = WIDENED.get(name, 0.0)
    if more:
        low, high = np.min(scene.workspace, axis=0) - more, np.max(scene.workspace, axis=0) + more
        scene = replace(scene, workspace=(*low.tolist(), *high.tolist()))
    return replace(scene, robots=tuple(replace(robot, radius=RADIUS) for robot in scene.robots))


def _hall(count: int) -> Scene:
    return random_scene(robots=count, obstacles=400, size=200, seed=1)


def main() -> None:
    """Print the table of the margin for the scenes asked for."""
    parser = argparse.ArgumentParser(description="Drive teams with the margin of a study; print what happens.")
    parser.add_argument("scenes", nargs="*", metavar="SCENE", help=f"{', '.join(SCENES)} (default: all)")
    parser.add_argument("--study", type=int, default=STUDY, metavar="N", help="runs of the study")
    parser.add_argument("--runs", type=int, default=RUNS, metavar="N", help="runs with its margin")
    words = parser.parse_args()
    print(machine(), safety(words.scenes or SCENES, words.study, words.runs), sep="\n\n")


if __name__ == "__main__":
    main()
