"""How many random teams are solved: python benchmarks/success.py [--scenes N] [--well-formed N] [--first-seed S]."""

from __future__ import annotations

import argparse
import math
import statistics
import sys
import tempfile
import time
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from measure import in_words, machine
from taut.certificate import certify
from taut.errors import TautError
from taut.formats import load_plan, save
from taut.freespace import FreeSpace
from taut.generate import random_scene
from taut.motion import Plan, Trajectory
from taut.scene import Scene
from taut.team import plan

MOST_DISCS = 0.05  # of the free area; fuller scenes are not part of the study


@dataclass(frozen=True)
class Case:
    """What became of one seed; ``fault`` is empty if it was solved, certified and survived the round trip.

    Parameters
    ----------
    solved : a certified plan was found.
    seconds : from the Scene to the plan, or to giving up.
    discs : share of the free area that the robots' discs cover.
    """

    seed: int
    robots: int
    obstacles: int
    solved: bool
    fault: str
    seconds: float
    rounds: int
    discs: float


def ordinary(seed: int) -> Scene:
    """Return 2 to 30 robots among 0 to 60 obstacles of all shapes."""
    rng = np.random.default_rng(seed)
    return random_scene(robots=int(rng.integers(2, 31)), obstacles=int(rng.integers(0, 61)), seed=seed)


def well_formed(seed: int) -> Scene:
    """Return the same, where each robot also has a way past all other starts and goals."""
    rng = np.random.default_rng(seed)
    robots, obstacles = int(rng.integers(2, 31)), int(rng.integers(0, 61))
    return random_scene(robots=robots, obstacles=obstacles, seed=seed, well_formed=True)


def tried(make: Callable[[int], Scene], seed: int, folder: Path) -> Case:
    """Make, plan, save, load and prove again one scene."""
    scene = make(seed)
    discs = sum(math.pi * robot.radius**2 for robot in scene.robots) / FreeSpace(scene).area
    began = time.perf_counter()

    def case(solved: bool, fault: str, rounds: int) -> Case:
        return Case(seed, len(scene.robots), len(scene.obstacles), solved, fault, seconds, rounds, discs)

    try:
        result = plan(scene)
    except TautError as error:
        seconds = time.perf_counter() - began
        return case(False, f"{type(error).__name__}: {error}", 0)
    seconds = time.perf_counter() - began
    rounds = int(str(result.plan.planner["rounds"]))
    if not result.certificate.ok:
        return case(False, f"not certified: {result.certificate.problems[0]}", rounds)
    return case(True, lost_on_the_way(result.plan, folder), rounds)


def lost_on_the_way(plan: Plan, folder: Path) -> str:
    """Say what a plan loses when it is saved and loaded; "" if it comes back bit for bit and is proved again."""
    first, second = folder / "first.json", folder / "second.json"
    save(plan, first)
    back = load_plan(first)
    save(back, second)
    for what, same in (
        ("scene", back.scene == plan.scene),
        ("stamps", all(map(_identical, back.trajectories, plan.trajectories))),
        ("planner", dict(back.planner) == dict(plan.planner)),
        ("certificate", back.certificate == plan.certificate),
        ("proof", certify(back).as_dict() == plan.certificate),
        ("file", first.read_bytes() == second.read_bytes()),
    ):
        if not same:
            return f"round trip: the {what} differs"
    return ""


def summary(title: str, cases: list[Case]) -> str:
    """Return the counts, and one line for each seed with a fault."""
    if not cases:
        return f"{title}: no scenes"
    n = len(cases)
    solved = [c for c in cases if c.solved]
    returned = [c for c in solved if not c.fault]
    times = [c.seconds for c in cases]
    lines = [
        f"{title}: {len(solved)} of {n} solved and certified ({100 * len(solved) / n:.1f} %), "
        f"{len(returned)} of these came back from JSON bit for bit",
        f"  seeds {cases[0].seed} to {cases[-1].seed}, {_span([c.robots for c in cases])} robots, "
        f"{_span([c.obstacles for c in cases])} obstacles, "
        f"discs {100 * statistics.median(c.discs for c in cases):.2f} % of the free area (median), "
        f"at most {100 * max(c.discs for c in cases):.2f} %",
        f"  time: median {in_words(statistics.median(times))}, longest {in_words(max(times))}; "
        f"{sum(c.rounds == 1 for c in solved)} in one round, most rounds {max((c.rounds for c in solved), default=0)}",
    ]
    fuller = [str(c.seed) for c in cases if c.discs > MOST_DISCS]
    if fuller:
        lines.append(f"  discs over {100 * MOST_DISCS:g} % of the free area: seeds {', '.join(fuller)}")
    lines += [f"  seed {c.seed} ({c.robots} robots, {c.obstacles} obstacles): {c.fault}" for c in cases if c.fault]
    return "\n".join(lines)


def main() -> None:
    """Run the study and print it; the exit code is 0 whatever comes out."""
    parser = argparse.ArgumentParser(description="Tell how many random teams are solved, and why others are not.")
    parser.add_argument("--scenes", type=int, default=200, metavar="N", help="ordinary scenes (default 200)")
    parser.add_argument("--well-formed", type=int, default=100, metavar="N", help="well-formed scenes (default 100)")
    parser.add_argument("--first-seed", type=int, default=0, metavar="S", help="the first of the seeds (default 0)")
    words = parser.parse_args()
    print(machine(), flush=True)
    with tempfile.TemporaryDirectory(prefix="taut-bench-") as folder:
        for title, make, count in (
            ("ordinary", ordinary, words.scenes),
            ("well-formed", well_formed, words.well_formed),
        ):
            cases = []
            for seed in range(words.first_seed, words.first_seed + count):
                cases.append(tried(make, seed, Path(folder)))
                if sys.stderr.isatty():
                    print(f"\r{title}: {len(cases)} of {count} ", end="", file=sys.stderr, flush=True)
            print(summary(title, cases), flush=True)


def _span(numbers: list[int]) -> str:
    return f"{min(numbers)} to {max(numbers)}"


def _identical(a: Trajectory, b: Trajectory) -> bool:
    return a.name == b.name and a.stamps.tobytes() == b.stamps.tobytes()


if __name__ == "__main__":
    main()
