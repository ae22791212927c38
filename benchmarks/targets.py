"""What building and paths should take, beside what was measured."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass

from against import Compared
from asking import Queries
from building import Build
from editing import Edits
from maps import RealMap
from measure import LEFT_OUT, Table, in_megabytes, in_words

TITLE = "Targets for building and paths"
REAL_MAP = 34_000  # corners of the map meant below, at least
TIMES = 1000.0


@dataclass(frozen=True)
class Target:
    """A figure that should not be passed; ``measured`` is None where this run did not measure it.

    Parameters
    ----------
    unit : "s", "bytes", or "×" for a ratio, which should not be *below* its limit.
    """

    what: str
    limit: float
    measured: float | None
    unit: str = "s"

    @property
    def met(self) -> bool | None:
        """Whether it is met; None where it was not measured."""
        if self.measured is None:
            return None
        return self.measured >= self.limit if self.unit == "×" else self.measured <= self.limit


def targets(
    builds: Sequence[Build],
    queries: Sequence[Queries],
    edits: Sequence[Edits],
    others: Sequence[Compared],
    real: Sequence[RealMap],
) -> tuple[Target, ...]:
    """Pick what was measured for every target."""
    build = {b.corners: b.together for b in builds}
    astar = {q.corners: q.astar.batch for q in queries}
    alone = {q.corners: q.direct.alone for q in queries}
    single = {q.corners: q.direct.single for q in queries}
    labels = {q.corners: q.labels for q in queries if q.labels is not None}
    between = {n: found.corners for n, found in labels.items()}
    places = {n: found.places.batch for n, found in labels.items()}
    size = {n: float(found.size) for n, found in labels.items()}
    change = {e.corners: e.replan for e in edits}
    real_map = max(((m.build.corners, m.build.together) for m in real), default=(0, 0.0))
    peers = [c for c in others if c.corners == 1000 and c.query is not None]
    return (
        *_each("tangent graph from a Scene", build, {1000: 7e-3, 10_000: 0.12, 100_000: 3.0}),
        Target(
            "tangent graph from a Scene, a real map of about 35,000 corners",
            2.0,
            real_map[1] if real_map[0] >= REAL_MAP else None,
        ),
        *_each("A*, a pair in a batch", astar, {1000: 10e-6, 10_000: 100e-6}),
        *_each("labels, a pair of corners", between, {10_000: 5e-6}),
        *_each("labels, a pair of free places in a batch", places, {10_000: 30e-6}),
        *_each("size of the labels", size, {10_000: 200e6}, "bytes"),
        *_each("interval search, a pair in a batch on one thread", alone, {1000: 20e-6, 10_000: 200e-6}),
        *_each("interval search, one pair a call", single, {1000: 20e-6, 10_000: 200e-6}),
        *(
            Target(f"{c.peer}, 1,000 corners: {word} ÷ taut's", TIMES, ratio, "×")
            for c in peers
            for word, ratio in (
                ("build", c.builds),
                ("query, one a call", c.singles),
                ("query, batch", c.batches),
            )
        ),
        *_each("an obstacle added, then one path", change, {10_000: 5e-3}),
    )


def table(found: Iterable[Target]) -> Table:
    """Return one row a target."""
    rows = tuple(
        (
            t.what,
            ("at least " if t.unit == "×" else "") + _said(t.limit, t.unit),
            LEFT_OUT if t.measured is None else _said(t.measured, t.unit),
            {None: "not measured", True: "yes", False: "**no**"}[t.met],
        )
        for t in found
    )
    return Table(
        TITLE,
        ("", "target", "measured", "met"),
        rows,
        "Figures of the tables above, on this machine and as busy as it was; on another they differ.",
    )


def _each(what: str, measured: Mapping[int, float], limits: Mapping[int, float], unit: str = "s") -> tuple[Target, ...]:
    return tuple(Target(f"{what}, {n:,} corners", limit, measured.get(n), unit) for n, limit in limits.items())


def _said(value: float, unit: str) -> str:
    match unit:
        case "s":
            return in_words(value)
        case "bytes":
            return in_megabytes(int(value))
        case _:
            return f"{value:,.0f} ×"
