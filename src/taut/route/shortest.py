"""Shortest routes in the plane, by A* on the tangent graph; start and goal are attached by one expansion each."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import ArrayLike

from taut.errors import GoalBlocked, NoPath, StartBlocked
from taut.freespace import FreeSpace
from taut.geometry.seeing import see_each_other, see_from
from taut.graph.search import astar_between
from taut.roadmap import VisibilityGraph, visibility_graph
from taut.route.core import Route
from taut.scene import FloatArray


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
    return shortest_routes(freespace, visibility_graph(freespace), [a], [b])[0]


def shortest_routes(
    freespace: FreeSpace, tangents: VisibilityGraph, starts: Sequence[ArrayLike], goals: Sequence[ArrayLike]
) -> list[Route]:
    """Find a shortest route from each start to the goal of the same place in the list.

    ``tangents`` is the tangent graph of ``freespace`` without further points. Raises as `shortest_path`.
    """
    mesh = freespace.mesh
    ends = np.concatenate([np.asarray(p, dtype=np.float64).reshape(-1, 2) for p in (starts, goals)])
    count = len(ends) // 2
    xy, triangles = freespace.anchor(ends)
    for i in np.flatnonzero(triangles < 0).tolist():
        error, word = (StartBlocked, "start") if i < count else (GoalBlocked, "goal")
        raise error(f"{word} ({ends[i, 0]:g}, {ends[i, 1]:g}) is not in free space (growth {freespace.growth:g} m)")
    number = np.full(len(mesh.wedges), -1, dtype=np.int64)
    number[tangents.wedges] = np.arange(len(tangents.wedges))
    first, seen = see_from(mesh, xy, triangles, mesh.wedge_turns >= 0, taut=True)
    index = np.arange(count, dtype=np.int64)
    direct = see_each_other(mesh, xy, triangles, index, index + count)
    out = []
    for i in range(count):
        a, b = xy[i], xy[i + count]
        if direct[i]:
            corners: FloatArray = np.empty((0, 2))
        else:
            from_start = number[seen[first[i] : first[i + 1]]]
            to_goal = number[seen[first[i + count] : first[i + count + 1]]]
            length, path = astar_between(tangents.graph, tangents.positions, a, from_start, b, to_goal)
            if not np.isfinite(length):
                raise NoPath("", _separated(ends[i], ends[i + count], freespace.growth))
            corners = tangents.positions[path]
        points = np.concatenate([ends[i, None], corners, ends[i + count, None]])
        moved = np.append(True, (np.diff(points, axis=0) != 0).any(axis=1))
        out.append(Route(points[moved]))
    return out


def _separated(a: FloatArray, b: FloatArray, growth: float) -> str:
    grown = f" grown by {growth:g} m" if growth else ""
    return f"no way from ({a[0]:g}, {a[1]:g}) to ({b[0]:g}, {b[1]:g}): obstacles{grown} separate them"
