"""Teams in contact: the committed instances planned, with contact and without, beside their witnesses.

Outcomes go to a CSV file as they come; the page is made from them.
"""

from __future__ import annotations

import argparse
import csv
import math
import multiprocessing
import tempfile
import time
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import asdict, dataclass, fields
from multiprocessing.connection import Connection
from pathlib import Path

import contact_page
import taut
from contact_instances import Asked, asked, witness
from measure import load, machine
from taut.contact import contact_of
from taut.errors import TautError

PAGE = Path(__file__).resolve().parents[1] / "docs" / "performance-contact.md"
SECONDS = 50.0
"""Given to the planner, which then says how far it has come …"""

LIMIT = 60.0
"""… and after which it is ended."""

_WARM = ("05-r06-hall-swarm", "05-r06-hall-chain-sight")
_ENDED = f"ended after {LIMIT:g} s"


@dataclass(frozen=True)
class Answer:
    """What planning came to: seconds, cost and bound in seconds; the cost is nan without a plan.

    Parameters
    ----------
    certified : whether the plan is proved to hold and to keep the contact, asked for or not.
    names : what of "robots", "place" and "time" an error names.
    reason : why there is no plan.
    """

    seconds: float
    cost: float = math.nan
    bound: float = math.nan
    certified: bool = False
    names: str = ""
    reason: str = ""


@dataclass(frozen=True)
class Outcome:
    """What became of one instance; costs are sums of costs in seconds, nan where there is no plan.

    Parameters
    ----------
    name, robots, reach, ground, formation, sight, mixed : which instance; reach in diameters of the robots.
    solved, certified : whether there is a plan in contact, and whether it is proved to hold and to keep it.
    seconds, cost : of planning with contact, certificate included.
    free_seconds, free_cost, free_kept : of planning without contact, and whether that plan happens to keep it.
    bound : no plan, in contact or not, costs less.
    witness_cost : of the plan that the instance was made with.
    names : what of "robots", "place" and "time" the error names where there is no plan.
    reason : why there is none.
    """

    name: str
    robots: int
    reach: int
    ground: str
    formation: str
    sight: bool
    mixed: bool
    solved: bool
    certified: bool
    seconds: float
    cost: float
    free_seconds: float
    free_cost: float
    free_kept: bool
    bound: float
    witness_cost: float
    names: str
    reason: str


def planned(name: str, in_contact: bool) -> Answer:
    """Plan an instance with the contact that its witness keeps, or without any."""
    shown = witness(name)
    demand = contact_of(shown.claims["contact"])  # type: ignore[arg-type]
    began = time.perf_counter()
    try:
        result = taut.plan(shown.scene, method="prioritized", seconds=SECONDS, contact=demand if in_contact else None)
    except TautError as error:
        seconds = time.perf_counter() - began
        told = [word for word in ("robots", "place", "time") if getattr(error, word, None) not in (None, ())]
        return Answer(seconds, names=", ".join(told), reason=" ".join(f"{type(error).__name__}: {error}".split()))
    seconds = time.perf_counter() - began
    bound = float(str((result.plan.lower_bound or {}).get("value", "nan")))
    return Answer(seconds, result.plan.sum_of_costs, bound, taut.certify(result.plan, contact=demand).ok)


def answers(tasks: Iterable[tuple[str, bool]]) -> Iterator[Answer]:
    """Plan one task after another in a process of its own, which is ended when one takes too long."""
    process, pipe = _worker()
    try:
        for task in tasks:
            pipe.send(task)
            began = time.perf_counter()
            try:
                answer = pipe.recv() if pipe.poll(LIMIT) else None
            except EOFError:
                answer = Answer(time.perf_counter() - began, reason="the process broke down")
            if isinstance(answer, Answer) and process.is_alive():
                yield answer
                continue
            process.kill()
            process.join()
            process, pipe = _worker()
            yield answer or Answer(LIMIT, reason=_ENDED)
    finally:
        process.kill()
        process.join()


def outcomes(instances: Sequence[Asked]) -> Iterator[Outcome]:
    """Plan instances with contact and without."""
    given = answers((one.name, in_contact) for one in instances for in_contact in (True, False))
    for one in instances:
        kept, free = next(given), next(given)
        yield Outcome(
            one.name,
            one.robots,
            one.reach,
            one.ground,
            one.formation,
            one.sight,
            one.mixed,
            not math.isnan(kept.cost),
            kept.certified,
            kept.seconds,
            kept.cost,
            free.seconds,
            free.cost,
            free.certified,
            free.bound,
            witness(one.name).sum_of_costs,
            kept.names,
            kept.reason,
        )


def written(path: Path, rows: Iterable[Outcome]) -> list[Outcome]:
    """Write outcomes into a CSV file as they come, and a line of each to the terminal; return them."""
    path.parent.mkdir(parents=True, exist_ok=True)
    out = []
    with path.open("w", encoding="utf-8", newline="") as file:
        table = csv.DictWriter(file, [field.name for field in fields(Outcome)], lineterminator="\n")
        table.writeheader()
        for row in rows:
            table.writerow({key: _text(value) for key, value in asdict(row).items()})
            file.flush()
            state = f"{row.cost / row.free_cost:.3f} × free" if row.solved else f"no plan: {row.reason[:200]}"
            print(f"{row.name}: {state}, {row.seconds:.2f} s", flush=True)
            out.append(row)
    return out


def main() -> None:
    """Plan the instances and write the page."""
    parser = argparse.ArgumentParser(description="Plan the committed teams in contact; write a page and a CSV file.")
    parser.add_argument("--quick", action="store_true", help="every seventh instance, to try; writes into a new folder")
    words = parser.parse_args()
    instances = list(asked())[:: 7 if words.quick else 1]
    page = Path(tempfile.mkdtemp()) / PAGE.name if words.quick else PAGE
    rows = written(page.with_suffix(".csv"), outcomes(instances))
    tables = contact_page.tables(rows)
    print("\n\n".join(map(str, tables)))
    contact_page.write(page, rows, machine(), load())
    print(f"wrote {page}")


def _worker() -> tuple[multiprocessing.process.BaseProcess, Connection]:
    """Start a process that plans what it is sent, and wait until it has compiled everything."""
    fresh = multiprocessing.get_context("spawn")
    here, there = fresh.Pipe()
    process = fresh.Process(target=_work, args=(there,), daemon=True)
    process.start()
    there.close()
    here.recv()
    return process, here


def _work(pipe: Connection) -> None:
    for name in _WARM:
        for in_contact in (True, False):
            planned(name, in_contact)
    pipe.send("ready")
    while True:
        pipe.send(planned(*pipe.recv()))


def _text(value: object) -> str:
    if isinstance(value, float):
        return "" if math.isnan(value) else repr(round(value, 6))
    return str(value)


if __name__ == "__main__":
    main()
