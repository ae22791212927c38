"""Shortest paths between free places: by A* on the prepared graph, by hub labels, and without a graph."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from measure import LEFT_OUT, Table, in_megabytes, in_words, median_time, one_thread
from taut.freespace import FreeSpace
from taut.graph import label_distances
from taut.roadmap import VisibilityGraph
from taut.route import direct_lengths, distances, distances_from, prepare
from taut.scene import FloatArray

SEED = 1
PAIRS = 4000
SINGLE = 100
MOST_LABELLED = 10_000
TITLE = "Shortest paths"
LABELS_TITLE = "Hub labels"

Ask = Callable[[FloatArray, FloatArray], object]


@dataclass(frozen=True)
class Asked:
    """Seconds a pair, on the mean: many pairs in one call, the same on one thread, and one pair a call."""

    batch: float
    alone: float
    single: float


@dataclass(frozen=True)
class Labelled:
    """Hub labels of one size: seconds to build (all threads), bytes, entries a corner, and seconds a pair.

    Parameters
    ----------
    corners : a pair of corners, in one call, which takes one thread.
    places : pairs of free places.
    """

    seconds: float
    size: int
    entries: float
    corners: float
    places: Asked


@dataclass(frozen=True)
class Queries:
    """One map: seconds a pair in each way, and a target by one-to-many; the greatest relative difference of lengths.

    Parameters
    ----------
    many : from one place to many, divided by their number.
    differ : between the ways, over all pairs.
    """

    corners: int
    astar: Asked
    direct: Asked
    many: float
    labels: Labelled | None
    differ: float


def queries(freespace: FreeSpace, corners: int, places: FloatArray, labelled: bool) -> Queries:
    """Ask for the paths from the first half of ``places`` to the second in every way."""
    index = prepare(freespace)
    starts, goals = np.split(places, 2)
    astar = asked(lambda a, b: distances(index, a, b), starts, goals)
    direct = asked(lambda a, b: direct_lengths(freespace, a, b), starts, goals)
    many = _timed(lambda: distances_from(index, starts[0], goals)) / len(goals)
    lengths = [distances(index, starts, goals), direct_lengths(freespace, starts, goals)[0]]
    labels = None
    if labelled:
        labels, by_labels = _labelled(freespace, index.tangents, starts, goals)
        lengths.append(by_labels)
    differ = max(float(np.abs(other / lengths[0] - 1).max()) for other in lengths[1:])
    return Queries(corners, astar, direct, many, labels, differ)


def asked(ask: Ask, starts: FloatArray, goals: FloatArray) -> Asked:
    """Measure one way of asking."""
    few = min(SINGLE, len(starts))

    def one_by_one() -> None:
        for k in range(few):
            ask(starts[k : k + 1], goals[k : k + 1])

    batch = _timed(lambda: ask(starts, goals)) / len(starts)
    with one_thread():
        alone = _timed(lambda: ask(starts, goals)) / len(starts)
    return Asked(batch, alone, _timed(one_by_one) / few)


def tables(found: tuple[Queries, ...]) -> tuple[Table, Table]:
    """Return the table of A* and interval search and that of labels."""
    three = ("batch", "one thread", "one a call")
    ways = Table(
        TITLE,
        ("corners", *(f"A*: {w}" for w in three), *(f"interval search: {w}" for w in three), "one to many"),
        tuple((f"{q.corners:,}", *_words(q.astar), *_words(q.direct), in_words(q.many)) for q in found),
        f"The same maps; {PAIRS:,} random pairs of free places, mean a pair; warm, medians.",
        (
            "A*: `distances` on what `prepare` gives, attaching both places included. Interval search: "
            "`direct_lengths` on the triangulation alone, without a graph.",
            f"batch: all pairs in one call, on all cores. One a call: {SINGLE} calls of one pair, which pay the fixed "
            "costs of a call each time.",
            f"one to many: `distances_from` from one place to {PAIRS:,}, a target.",
            f"All ways, hub labels too, agree on all lengths to {max(q.differ for q in found):.1e} relative.",
        ),
    )
    rows = tuple(
        (
            f"{q.corners:,}",
            in_words(q.labels.seconds),
            in_megabytes(q.labels.size),
            f"{q.labels.entries:,.0f}",
            in_words(q.labels.corners),
            *_words(q.labels.places),
        )
        for q in found
        if q.labels is not None
    )
    labels = Table(
        LABELS_TITLE,
        ("corners", "built in", "size", "entries a corner", "between corners", *(f"free places: {w}" for w in three)),
        rows,
        '`prepare(freespace, "labels")` on the same maps and pairs.',
        (
            f"Between corners: `label_distances`, {PAIRS:,} random pairs in one call, which uses one thread.",
            "built in: the labels alone, on all cores, once.",
        ),
    )
    return ways, labels


def in_short(q: Queries) -> str:
    """Say in one line what was measured, to be printed at once."""
    labels = LEFT_OUT
    if q.labels is not None:
        labels = f"{in_words(q.labels.places.batch)} (built in {in_words(q.labels.seconds)})"
    return (
        f"{q.corners:,} corners: a pair by A* {in_words(q.astar.batch)}, by interval search "
        f"{in_words(q.direct.batch)}, by labels {labels}"
    )


def _labelled(
    freespace: FreeSpace, tangents: VisibilityGraph, starts: FloatArray, goals: FloatArray
) -> tuple[Labelled, FloatArray]:
    index = prepare(freespace, "labels")
    assert index.labels is not None
    labels = index.labels
    a, b = np.random.default_rng(SEED).integers(0, tangents.graph.n, (2, PAIRS))
    corners = _timed(lambda: label_distances(labels, a, b)) / PAIRS
    places = asked(lambda s, g: distances(index, s, g), starts, goals)
    found = Labelled(labels.build_seconds, labels.bytes, labels.mean_size, corners, places)
    return found, distances(index, starts, goals)


def _words(a: Asked) -> tuple[str, str, str]:
    return in_words(a.batch), in_words(a.alone), in_words(a.single)


def _timed(work: Callable[[], object]) -> float:
    return median_time(work, most=9, budget=2.0)
