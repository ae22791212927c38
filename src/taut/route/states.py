"""The tangent graph as the paths see it: each corner passed on one side or on the other.

A taut path hugs the obstacle at a corner on one side; from there it leaves only along tangents that hug it on the same
side. Searching these states instead of corners follows half as many edges at each.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from taut.chunks import over_chunks
from taut.freespace import FreeSpace
from taut.geometry import _seeing_kernels
from taut.geometry.points import points_of
from taut.geometry.seeing import see_each_other, see_from
from taut.geometry.triangulation import Floats, Ints, Triangulation
from taut.graph import _kernels
from taut.roadmap import VisibilityGraph
from taut.scene import FloatArray

_CHUNK = 256


@dataclass(frozen=True, eq=False)
class TautStates:
    """A directed graph: state 2 v + 1 is corner v with its obstacle on the left, 2 v with it on the right.

    Parameters
    ----------
    indptr, heads, lengths : CSR of the tangents that leave each state: the states where they arrive, metres.
    positions : (2 n, 2) metres.
    """

    indptr: Ints
    heads: Ints
    lengths: Floats
    positions: Floats


@dataclass(frozen=True, eq=False)
class Attached:
    """Places joined with the tangent graph of a free space.

    Parameters
    ----------
    given : (k, 2) metres, as asked for.
    points : (k, 2) the same, moved into the free space where rounding left them outside.
    triangles : (k,) a triangle of the mesh that contains each.
    first, corners : CSR of the corners at which a taut path from the place can arrive.
    sides : on which side of the way there the obstacle lies: 1 left, −1 right, 0 both.
    """

    given: FloatArray
    points: FloatArray
    triangles: Ints
    first: Ints
    corners: Ints
    sides: Ints

    def corners_of(self, k: int) -> Ints:
        """Corners joined with place k."""
        return self.corners[self.first[k] : self.first[k + 1]]


def taut_states(freespace: FreeSpace, tangents: VisibilityGraph) -> TautStates:
    """Split the corners of the tangent graph of ``freespace`` (without further points) by side."""
    mesh, graph = freespace.mesh, tangents.graph
    sides = _seeing_kernels.bend_sides(mesh.vertices, mesh.wedges, tangents.wedges, graph.indptr, graph.indices)
    tail = np.repeat(np.arange(graph.n), np.diff(graph.indptr))
    tails, heads, lengths = [], [], []
    for leaving in (1, -1):
        for arriving in (1, -1):
            fit = (sides[:, 0] != -leaving) & (sides[:, 1] != -arriving)
            tails.append(2 * tail[fit] + (leaving > 0))
            heads.append(2 * graph.indices[fit] + (arriving > 0))
            lengths.append(graph.weights[fit])
    states = np.concatenate(tails)
    order = np.argsort(states, kind="stable")
    indptr = np.append(0, np.cumsum(np.bincount(states, minlength=2 * graph.n)))
    return TautStates(
        indptr, np.concatenate(heads)[order], np.concatenate(lengths)[order], np.repeat(tangents.positions, 2, axis=0)
    )


def attach(freespace: FreeSpace, tangents: VisibilityGraph, points: ArrayLike) -> Attached:
    """Join (k, 2) places with the tangent graph; a place that is not free has triangle −1 and joins nothing."""
    mesh = freespace.mesh
    given = points_of(points)
    xy, triangles = freespace.anchor(given)
    free = np.flatnonzero(triangles >= 0)
    first, seen = see_from(mesh, xy[free], triangles[free], mesh.wedge_turns >= 0, taut=True)
    sides = _seeing_kernels.bend_sides_from(mesh.vertices, mesh.wedges, xy[free], first, seen)
    number = np.full(len(mesh.wedges), -1, dtype=np.int64)
    number[tangents.wedges] = np.arange(len(tangents.wedges))
    counts = np.zeros(len(given), dtype=np.int64)
    counts[free] = np.diff(first)
    return Attached(given, xy, triangles, np.append(0, np.cumsum(counts)), number[seen], sides)


def picked(ends: Attached, pairs: Ints) -> Attached:
    """Return places 2 k and 2 k + 1 for each k of ``pairs``."""
    places = np.stack([2 * pairs, 2 * pairs + 1], axis=1).reshape(-1)
    counts = ends.first[places + 1] - ends.first[places]
    first = np.append(0, np.cumsum(counts))
    at = np.arange(first[-1]) + np.repeat(ends.first[places] - first[:-1], counts)
    return Attached(
        ends.given[places], ends.points[places], ends.triangles[places], first, ends.corners[at], ends.sides[at]
    )


def search(mesh: Triangulation, states: TautStates, ends: Attached) -> tuple[Floats, Ints, Ints]:
    """Lengths between places 0 and 1, 2 and 3, … (inf without a path) and the corners passed as CSR (start, corner).

    The places must be free; lengths are measured from where they were given.
    """
    starts = np.arange(0, len(ends.given), 2, dtype=np.int64)
    direct = see_each_other(mesh, ends.points, ends.triangles, starts, starts + 1)
    far = starts[~direct]
    arrays = states.indptr, states.heads, states.lengths, states.positions

    def chunk(first: int, last: int) -> tuple[Floats, Ints, Ints]:
        own = far[first:last]
        # seen from the goal, what lies on the left of the way to it lies on the right
        away, there = states_of(ends, own, 1), states_of(ends, own + 1, -1)
        return _kernels.astar(*arrays, ends.given[own], *away, ends.given[own + 1], *there)

    found = over_chunks(chunk, len(far), _CHUNK)
    lengths = np.hypot(*(ends.given[1::2] - ends.given[::2]).T)
    counts = np.zeros(len(starts), dtype=np.int64)
    path = np.empty(0, dtype=np.int64)
    if found:
        lengths[~direct] = np.concatenate([length for length, _, _ in found])
        counts[~direct] = np.concatenate([np.diff(start) for _, start, _ in found])
        path = np.concatenate([path for _, _, path in found]) // 2
    return lengths, np.append(0, np.cumsum(counts)), path


def states_of(ends: Attached, places: Ints, way: int) -> tuple[Ints, Ints]:
    """CSR of the states joined with some of the places; ``way`` is 1 for ways from them, −1 for ways to them."""
    counts = ends.first[places + 1] - ends.first[places]
    row = np.repeat(np.arange(len(places)), counts)
    at = np.arange(len(row)) + (ends.first[places] - np.append(0, np.cumsum(counts))[:-1])[row]
    corner, side = ends.corners[at], way * ends.sides[at]
    both = np.flatnonzero(side == 0)
    states = 2 * corner + (side > 0)
    if len(both):
        row, states = np.append(row, row[both]), np.append(states, 2 * corner[both] + 1)
        order = np.argsort(row, kind="stable")
        row, states = row[order], states[order]
    return np.append(0, np.cumsum(np.bincount(row, minlength=len(places)))), states
