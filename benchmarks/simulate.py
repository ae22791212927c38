"""The suite of simulation: steps a second of large teams, and whether the margin of a study keeps teams apart.

python benchmarks/simulate.py [SCENE …] [--study N] [--runs N] makes the second table alone, as long as you like.
"""

from __future__ import annotations

import argparse
import time
from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from measure import Report, Table, in_words, machine, one_thread
from taut.formats.files import load_scene
from taut.generate import random_scene
from taut.motion import Plan
from taut.scene import Scene
from taut.simulation import Disturbances, Lidar, Study, study, with_margin
from taut.simulation.driving import Watching, drive
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
TITLES = (STEPS_TITLE, SAFE_TITLE)


def suite(quick: bool) -> Report:
    """Measure both tables."""
    return Report((speed(quick), safety(SCENES, QUICK if quick else STUDY, QUICK if quick else RUNS)))


def speed(quick: bool) -> Table:
    """Steps a second on one core: 50 robots that look around at every step, and many that do not."""
    rows = [_speed_row("warehouse-50, 181-beam lidars", plan(_stout("warehouse-50")).plan, Lidar())]
    count = 100 if quick else 1000
    rows.append(_speed_row(f"hall, {count} robots", plan(_hall(count)).plan, None))
    heads = ("team", "robots", "steps a second", "ns a robot and step")
    before = "Differential drives, steps of 0.02 s, coordination on; from start to the last arrival, on one core."
    return Table(STEPS_TITLE, heads, tuple(rows), before)


def safety(scenes: Sequence[str], learnt: int, runs: int) -> Table:
    """What a study of each scene finds, and how teams fare whose plans leave its margin, on other seeds."""
    rows = tuple(row for name in scenes for row in _safety_rows(name, learnt, runs))
    heads = ("scene and plan", "runs", "all arrived", "collided", "off the path", "apart", "makespan", "time")
    before = (
        "Differential drives of radius 0.15 m under speed errors of ±20 % and a random stop every 20 s of 2 s on "
        f"average. The margin is that of a study of {learnt} runs; the plan with the margin is driven with seeds that "
        "are not in the study."
    )
    return Table(SAFE_TITLE, heads, rows, before)


@dataclass(frozen=True)
class Case:
    """A plan and how it is driven."""

    words: str
    plan: Plan
    seeds: range
    coordination: bool


def _safety_rows(name: str, learnt: int, runs: int) -> list[tuple[str, ...]]:
    scene = _stout(name)
    bare = plan(scene).plan
    found, spent = _studied(Case("", bare, range(learnt), True))
    margin = found.margin
    roomy = plan(with_margin(scene, margin.metres)).plan
    fresh = range(learnt, learnt + runs)
    cases = (
        Case(f"margin {1000 * margin.metres:.0f} mm", roomy, fresh, True),
        Case("the same, no coordination", roomy, fresh, False),
    )
    learnt_row = _row(f"{name}: study (p = {margin.probability:.4g})", found, spent)
    return [learnt_row, *(_row(f"{name}: {case.words}", *_studied(case)) for case in cases)]


def _studied(case: Case) -> tuple[Study, float]:
    began = time.perf_counter()
    found = study(case.plan, case.seeds, disturbances=MET, coordination=case.coordination)
    return found, time.perf_counter() - began


def _row(words: str, found: Study, spent: float) -> tuple[str, ...]:
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
        in_words(spent),
    )


def _speed_row(words: str, team: Plan, lidar: Lidar | None) -> tuple[str, ...]:
    setting, _ = prepared(team, "differential", True, 0.02)
    n = len(setting.names)
    with one_thread():
        drive(setting, MET, 0, 0.1, 1, _watching(team, lidar))
        began = time.perf_counter()
        driven = drive(setting, MET, 0, longest(team), 1 if lidar else 5, _watching(team, lidar))
        spent = time.perf_counter() - began
    steps = driven.seconds / setting.dt
    return words, str(n), f"{steps / spent:,.0f}", f"{1e9 * spent / steps / n:,.0f}"


def _watching(team: Plan, lidar: Lidar | None) -> Watching | None:
    return None if lidar is None else looking(team, lidar, 0, [])


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
