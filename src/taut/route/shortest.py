"""Shortest routes in the plane, by A* on the tangent graph; start and goal are attached by one expansion each."""

from __future__ import annotations

from dataclasses import dataclass
from itertools import pairwise

import numpy as np
from numpy.typing import ArrayLike

from taut.chunks import over_chunks
from taut.errors import GoalBlocked, NoPath, StartBlocked
from taut.freespace import FreeSpace
from taut.geometry.seeing import see_each_other, see_from
from taut.graph import astar_many
from taut.graph.core import Floats, Ints
from taut.roadmap import VisibilityGraph, visibility_graph
from taut.route.core import Route
from taut.scene import FloatArray

_CHUNK = 64


@dataclass(frozen=True, eq=False)
class Attached:
    """Places joined with the tangent graph of a free space.

    Parameters
    ----------
    given : (k, 2) metres, as asked for.
    points : (k, 2) the same, moved into the free space where rounding left them outside.
    triangles : (k,) a triangle of the mesh that contains each.
    first, corners : CSR of the tangent graph's vertices at which a taut path from the place can arrive.
    """

    given: FloatArray
    points: FloatArray
    triangles: Ints
    first: Ints
    corners: Ints

    def corners_of(self, k: int) -> Ints:
        """Vertices of the tangent graph joined with place k."""
        return self.corners[self.first[k] : self.first[k + 1]]

    def of(self, places: Ints) -> tuple[Ints, Ints]:
        """CSR of the vertices joined with some of the places: start, corners."""
        counts = self.first[places + 1] - self.first[places]
        start = np.append(0, np.cumsum(counts))
        return start, self.corners[np.arange(start[-1]) + np.repeat(self.first[places] - start[:-1], counts)]


def attach(freespace: FreeSpace, tangents: VisibilityGraph, points: ArrayLike) -> Attached:
    """Join (k, 2) places with the tangent graph; a place that is not free has triangle −1 and joins nothing."""
    mesh = freespace.mesh
    given = np.asarray(points, dtype=np.float64).reshape(-1, 2)
    xy, triangles = freespace.anchor(given)
    free = np.flatnonzero(triangles >= 0)
    number = np.full(len(mesh.wedges), -1, dtype=np.int64)
    number[tangents.wedges] = np.arange(len(tangents.wedges))
    first, seen = see_from(mesh, xy[free], triangles[free], mesh.wedge_turns >= 0, taut=True)
    counts = np.zeros(len(given), dtype=np.int64)
    counts[free] = np.diff(first)
    return Attached(given, xy, triangles, np.append(0, np.cumsum(counts)), number[seen])


def shortest_path(freespace: FreeSpace, a: ArrayLike, b: ArrayLike) -> Route:
    """Find a shortest allowed path between two points.

    Raises
    ------
    StartBlocked, GoalBlocked
        ``a`` or ``b`` is not in free space.
    NoPath
        Obstacles separate them.

    >>> from taut import FreeSpace, Scene
    >>> shortest_path(FreeSpace(Scene((0, 0, 4, 3))), (0, 0), (3, 0)).length
    3.0
    """
    start, goal = np.asarray(a, dtype=np.float64), np.asarray(b, dtype=np.float64)
    return shortest_routes(freespace, visibility_graph(freespace), start, goal)[0]


def shortest_routes(
    freespace: FreeSpace, tangents: VisibilityGraph, starts: ArrayLike, goals: ArrayLike
) -> list[Route]:
    """Find a shortest route from each of (k, 2) starts to the goal in the same row. Raises as `shortest_path`.

    ``tangents`` is the tangent graph of ``freespace`` without further points.
    """
    pairs = np.stack([np.asarray(p, dtype=np.float64).reshape(-1, 2) for p in (starts, goals)], axis=1)
    return routes_between(freespace, tangents, attach(freespace, tangents, pairs))


def routes_between(freespace: FreeSpace, tangents: VisibilityGraph, ends: Attached) -> list[Route]:
    """Find a shortest route between places 0 and 1, 2 and 3, … of ``ends``. Raises as `shortest_path`."""
    for k in np.flatnonzero(ends.triangles < 0).tolist():
        error, word = (StartBlocked, "start") if k % 2 == 0 else (GoalBlocked, "goal")
        x, y = ends.given[k]
        raise error(f"{word} ({x:g}, {y:g}) is not in free space (growth {freespace.growth:g} m)")
    lengths, path_start, path = _searched(freespace, tangents, ends)
    lost = np.flatnonzero(np.isinf(lengths))
    if len(lost):
        k = 2 * int(lost[0])
        raise NoPath("", _separated(ends.given[k], ends.given[k + 1], freespace.growth))
    corners = tangents.positions[path]
    out = []
    for q, (first, last) in enumerate(pairwise(path_start.tolist())):
        points = np.concatenate([ends.given[2 * q, None], corners[first:last], ends.given[2 * q + 1, None]])
        moved = np.append(True, (np.diff(points, axis=0) != 0).any(axis=1))
        out.append(Route(points[moved]))
    return out


def _searched(freespace: FreeSpace, tangents: VisibilityGraph, ends: Attached) -> tuple[Floats, Ints, Ints]:
    """Lengths between places 0 and 1, 2 and 3, … (inf without a path) and the corners passed as CSR (start, corner).

    Places must be free.
    """
    starts = np.arange(0, len(ends.given), 2, dtype=np.int64)
    direct = see_each_other(freespace.mesh, ends.points, ends.triangles, starts, starts + 1)
    far = starts[~direct]
    graph = tangents.graph

    def chunk(first: int, last: int) -> tuple[Floats, Ints, Ints]:
        own = far[first:last]
        return astar_many(
            graph, tangents.positions, ends.points[own], *ends.of(own), ends.points[own + 1], *ends.of(own + 1)
        )

    found = over_chunks(chunk, len(far), _CHUNK)
    lengths = np.hypot(*(ends.points[1::2] - ends.points[::2]).T)
    counts = np.zeros(len(starts), dtype=np.int64)
    paths = np.empty(0, dtype=np.int64)
    if found:
        lengths[~direct] = np.concatenate([length for length, _, _ in found])
        counts[~direct] = np.concatenate([np.diff(start) for _, start, _ in found])
        paths = np.concatenate([path for _, _, path in found])
    return lengths, np.append(0, np.cumsum(counts)), paths


def _separated(a: FloatArray, b: FloatArray, growth: float) -> str:
    grown = f" grown by {growth:g} m" if growth else ""
    return f"no way from ({a[0]:g}, {a[1]:g}) to ({b[0]:g}, {b[1]:g}): obstacles{grown} separate them"
