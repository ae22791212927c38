"""Teams against the peers: their instances planned, every plan certified, compared instance by instance.

Every family's outcomes go to a CSV file as they come; the page is made from these files alone.
"""

from __future__ import annotations

import argparse
import csv
import math
import tempfile
import time
from collections.abc import Callable, Iterable, Iterator, Sequence
from dataclasses import asdict, dataclass, fields
from pathlib import Path
from typing import Any

import contest_page
import taut
from instances import GRIDS, ROADMAPS, STGCS, Instance, Record, read, records
from large import LARGE
from measure import load, machine, peak
from taut.errors import TautError
from taut.team import Result

PAGE = Path(__file__).resolve().parents[1] / "docs" / "performance-teams.md"
FAMILIES = (*ROADMAPS, *GRIDS, *STGCS, *(large.family for large in LARGE))
HEADLINES = {"empty-16-16": (100, 30.0), "room-64-64-8": (200, 30.0), "warehouse-10-20-10-2-2": (200, 10.0)}
"""Robots of a grid for which all ten instances are planned, and the seconds for it; den520d as many as peers solved."""


@dataclass(frozen=True)
class Outcome:
    """What became of one instance; empty fields where there is nothing to tell.

    Parameters
    ----------
    family, number, robots : which instance.
    method, budget : as given to `taut.plan`; seconds.
    solved, certified, proven : whether there is a plan, `certify` accepts it, and it is proven to be optimal.
    first_seconds, first_cost : from the scene to the first plan, roadmaps included, and its sum of costs.
    roadmap_seconds : of these, until the roadmaps and shortest routes were there.
    seconds, cost : at the end, certificate included.
    bound, model : what no plan of that model can beat.
    memory : most bytes that the process has held by then.
    distance : least room between two robots beyond the gap, metres (negative: by rounding only).
    reason : why there is no plan.
    """

    family: str
    number: int
    robots: int
    method: str
    budget: float
    solved: bool
    certified: bool
    proven: bool
    first_seconds: float
    first_cost: float
    roadmap_seconds: float
    seconds: float
    cost: float
    bound: float
    model: str
    memory: int
    distance: float
    reason: str = ""


def planned(instance: Instance, budget: float) -> Outcome:
    """Plan one instance: on roadmaps optimally, else by the default method."""
    method = "optimal" if instance.family in ROADMAPS else "repair"
    words: dict[str, object] = {} if instance.lanes is None else {"roadmap": instance.lanes}
    return _outcome(instance.family, instance.number, instance.scene, method, budget, words)


def _outcome(
    family: str, number: int, scene: taut.Scene, method: str, budget: float, words: dict[str, object]
) -> Outcome:
    head = (family, number, len(scene.robots), method, budget)
    nothing = math.nan
    began = time.perf_counter()
    try:
        result: Result = taut.plan(scene, method=method, seconds=budget, **words)  # type: ignore[arg-type]
    except TautError as error:
        seconds = time.perf_counter() - began
        why = " ".join(str(error).split())
        first = (nothing, nothing, nothing)
        return Outcome(*head, False, False, False, *first, seconds, nothing, nothing, "", peak(), nothing, why)
    seconds = time.perf_counter() - began
    plan, proof = result.plan, result.certificate
    bound = plan.lower_bound or {}
    return Outcome(
        *head,
        True,
        proof.ok,
        plan.planner.get("proven") is True,
        result.history[0][0],
        result.history[0][1],
        result.phases["roadmaps"],
        seconds,
        plan.sum_of_costs,
        float(str(bound.get("value", nothing))),
        str(bound.get("model", "")),
        peak(),
        nothing if proof.min_separation is None else proof.min_separation - scene.gap,
    )


def asked(folder: Path, family: str, peers: Sequence[Record], quick: bool) -> Iterator[tuple[int, int, float]]:
    """Number, robots and seconds of each instance to plan: those on which peers were run, the fewest robots first."""
    known = {(record.robots, record.number) for record in peers if record.family == family}
    robots, seconds = HEADLINES.get(family, (0, 0.0))
    if robots:
        known |= {(robots, number) for number in range(1, 11)}
    every = sorted(known)
    if quick:
        every = every[:2]
    for n, number in every:
        budget = 30.0 if family in ROADMAPS else 1.0 if family in STGCS else seconds if n == robots else 1.0
        yield number, n, 15.0 if family == "den520d" and n == 200 else budget


def outcomes(folder: Path, family: str, peers: Sequence[Record], quick: bool) -> Iterator[Outcome]:
    """Plan the instances of a family, one after another."""
    large = next((one for one in LARGE if one.family == family), None)
    if large is not None:
        for number in large.numbers[: 1 if quick else None]:
            yield _outcome(family, number, large.scene(number), "repair", large.budget, {})
        return
    for number, robots, budget in asked(folder, family, peers, quick):
        yield planned(read(folder, family, number, robots), budget)


def write(path: Path, rows: Iterable[Outcome]) -> None:
    """Write outcomes into a CSV file as they come, and a line of each to the terminal."""
    path.parent.mkdir(parents=True, exist_ok=True)
    with path.open("w", encoding="utf-8", newline="") as file:
        table = csv.DictWriter(file, [field.name for field in fields(Outcome)], lineterminator="\n")
        table.writeheader()
        for row in rows:
            table.writerow({key: _text(value) for key, value in asdict(row).items()})
            file.flush()
            state = f"{row.cost:.3f} ≥ {row.bound:.3f}" if row.solved else f"no plan: {row.reason[:80]}"
            print(f"{row.family} {row.number}, {row.robots} robots: {state}, {row.seconds:.2f} s", flush=True)


def _text(value: object) -> str:
    if isinstance(value, float):
        return "" if math.isnan(value) else repr(round(value, 9))
    return str(value)


def read_outcomes(path: Path) -> list[Outcome]:
    """Read what was written by `write`."""
    readers: dict[str, Callable[[str], Any]] = {
        "int": int,
        "float": lambda text: float(text or "nan"),
        "bool": lambda text: text == "True",
        "str": str,
    }
    with path.open(encoding="utf-8", newline="") as file:
        return [
            Outcome(**{field.name: readers[str(field.type)](row[field.name]) for field in fields(Outcome)})
            for row in csv.DictReader(file)
        ]


def main() -> None:
    """Plan the instances of the families asked for and write the page of all that have been planned so far."""
    parser = argparse.ArgumentParser(description="Plan the field's instances; compare with the peers.")
    parser.add_argument("families", nargs="*", metavar="FAMILY", help=f"{', '.join(FAMILIES)} (default: all)")
    parser.add_argument("--data", type=Path, metavar="FOLDER", help="with maps/ and teams/, see instances.py")
    parser.add_argument("--quick", action="store_true", help="two instances a family, to try; writes into a new folder")
    words = parser.parse_args()
    unknown = [name for name in words.families if name not in FAMILIES]
    if unknown:
        parser.error(f"there is no family {unknown[0]}; the families are {', '.join(FAMILIES)}")
    own = {large.family for large in LARGE}
    families = words.families or [name for name in FAMILIES if words.data is not None or name in own]
    if words.data is None and not own.issuperset(families):
        parser.error("these instances are not part of taut: give --data FOLDER")
    if words.data is not None and not (words.data / "teams" / "results").is_dir():
        parser.error(f"{words.data} has no teams/results")
    peers = [] if words.data is None else records(words.data)
    taut.plan(taut.load_scene("thesis-2"), rounds=1)  # compiles
    folder = Path(tempfile.mkdtemp()) if words.quick else PAGE.with_suffix("")
    for family in families:
        write(folder / f"{family}.csv", outcomes(words.data or Path(), family, peers, words.quick))
    if words.data is None:
        print("no page without --data: it tells of the peers' results, too")
        return
    page = folder / PAGE.name if words.quick else PAGE
    known = {name: read_outcomes(folder / f"{name}.csv") for name in FAMILIES if (folder / f"{name}.csv").exists()}
    contest_page.write(page, known, peers, machine(), load())
    print(f"wrote {page}")


if __name__ == "__main__":
    main()
