"""One obstacle more or less on a finished map, and a path at once, beside building everything anew."""

from __future__ import annotations

import math
import statistics
from dataclasses import dataclass
from functools import partial

import numpy as np

from measure import Table, clocked, in_words, one_thread
from scattered import free_places
from taut.freespace import FreeSpace
from taut.roadmap import VisibilityGraph, visibility_graph
from taut.roadmap.changing import with_obstacle, without_obstacle
from taut.route import shortest_path
from taut.scene import FloatArray, Polygon

SEED = 2
EDITS = 25
CHECKED = 3
TITLE = "One obstacle more or less"


@dataclass(frozen=True)
class Edits:
    """One map: median seconds to add an obstacle, that with one path thereafter, and to remove one; one thread.

    Parameters
    ----------
    fresh : seconds to build the tangent graph of the changed scene anew, on one thread, too.
    rebuilt : of all edits, how many built everything anew.
    same : of the edits compared with a fresh build (as many as are ``checked``), how many have the same edges.
    """

    corners: int
    add: float
    replan: float
    remove: float
    fresh: float
    rebuilt: int
    same: int
    checked: int


def edits(freespace: FreeSpace, tangents: VisibilityGraph, corners: int, fresh: float) -> Edits:
    """Add obstacles and remove others, each time from the same map."""
    added = _hexagons(freespace)
    names = np.random.default_rng(SEED).permutation([o.name for o in freespace.scene.obstacles])[:EDITS].tolist()
    with one_thread():
        with_obstacle(freespace, tangents, added[0])
        without_obstacle(freespace, tangents, names[0])
        adds = [clocked(partial(with_obstacle, freespace, tangents, o)) for o in added]
        removes = [clocked(partial(without_obstacle, freespace, tangents, n)) for n in names]
        changes = [with_obstacle(freespace, tangents, o) for o in added]
        pairs = []
        for o, changed in zip(added, changes, strict=True):
            a, b = free_places(changed.freespace, 2, SEED)

            def replan(o: Polygon = o, a: FloatArray = a, b: FloatArray = b) -> None:
                shortest_path(with_obstacle(freespace, tangents, o).freespace, a, b)

            pairs.append(clocked(replan))
    changes += [without_obstacle(freespace, tangents, n) for n in names]
    few = changes[:CHECKED] + changes[-CHECKED:]
    same = sum(
        _edge_set(c.tangents) == _edge_set(visibility_graph(FreeSpace(c.freespace.scene, c.freespace.growth)))
        for c in few
    )
    return Edits(
        corners,
        statistics.median(adds),
        statistics.median(pairs),
        statistics.median(removes),
        fresh,
        sum(c.rebuilt for c in changes),
        same,
        len(few),
    )


def table(found: tuple[Edits, ...]) -> Table:
    """Return one row a size."""
    return Table(
        TITLE,
        ("corners", "add", "add, then one path", "remove", "fresh build", "÷ add", "same edges", "built anew"),
        tuple(
            (
                f"{e.corners:,}",
                *map(in_words, (e.add, e.replan, e.remove, e.fresh)),
                f"{e.fresh / e.add:,.1f}",
                f"{e.same} of {e.checked}",
                str(e.rebuilt),
            )
            for e in found
        ),
        "`with_obstacle` and `without_obstacle` on the same maps: free space and tangent graph brought up to date; "
        "medians, all on one thread.",
        (
            f"Added: hexagons as wide as half the obstacles' mean spacing, at {EDITS} random free places, "
            "where they may overlap others. Removed: as many random obstacles. Each from the same map.",
            "one path: `shortest_path` on the changed map, between two random free places.",
            "same edges: changed maps whose tangent graph has the edges of a fresh build, compared by places, to "
            "1e-6 m. Built anew: changes that could not be made locally.",
        ),
    )


def in_short(e: Edits) -> str:
    """Say in one line what was measured, to be printed at once."""
    return (
        f"{e.corners:,} corners: an obstacle added in {in_words(e.add)}, and a path {in_words(e.replan)}, removed in "
        f"{in_words(e.remove)}; same edges {e.same} of {e.checked}"
    )


def _hexagons(freespace: FreeSpace) -> list[Polygon]:
    scene = freespace.scene
    radius = 0.25 * math.sqrt(freespace.area / len(scene.obstacles))
    angle = math.pi / 3 * np.arange(6) + 0.1
    shape = radius * np.stack([np.cos(angle), np.sin(angle)], axis=1)
    return [Polygon(centre + shape, name=f"added {k}") for k, centre in enumerate(free_places(freespace, EDITS, SEED))]


def _edge_set(tangents: VisibilityGraph) -> set[tuple[tuple[int, int], ...]]:
    """Edges as pairs of places in units of 1e-6 m, so that numbering does not matter."""
    places = [(x, y) for x, y in np.rint(tangents.positions * 1e6).astype(np.int64).tolist()]
    return {tuple(sorted((places[a], places[b]))) for a, b in tangents.edges.tolist()}
