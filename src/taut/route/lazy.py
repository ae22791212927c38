"""Lazy probabilistic roadmaps: an edge is tested only once a shortest way would use it."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from taut.freespace import FreeSpace
from taut.geometry.seeing import see_each_other
from taut.geometry.triangulation import Floats, Ints
from taut.graph import Graph
from taut.roadmap.core import LocatedRoadmap
from taut.roadmap.sampled import Samples, draw_samples
from taut.route.along import NEAREST, Joined, attached, not_connected, paths_between, through
from taut.route.core import Route, in_turn, require_free


@dataclass(frozen=True, eq=False)
class LazyRoute(Route):
    """A route along a probabilistic roadmap of which little was tested.

    Parameters
    ----------
    points : (k, 2) metres, from start to goal; one row if they are the same place.
    positions : (n, 2) metres, the samples.
    candidates : (m, 2) pairs i < j of them that the roadmap would try to join.
    tested : (m,) whether it was tested that the two see each other.
    blocked : (m,) whether the test failed.
    """

    positions: Floats
    candidates: Ints
    tested: NDArray[np.bool_]
    blocked: NDArray[np.bool_]


def lazy_route(
    freespace: FreeSpace,
    a: ArrayLike,
    b: ArrayLike,
    samples: int = 1000,
    seed: int = 0,
    neighbours: int | None = None,
) -> LazyRoute:
    """Find a route as long as that along `sampled_roadmap` with the same arguments, testing few of its edges.

    A shortest way through all candidate edges is found; those on it are tested; the blocked ones are removed; and so
    on until none is blocked. Ends are joined as by `routes_along`.

    Parameters
    ----------
    a, b : start and goal, (2,) metres.
    samples, seed, neighbours : as in `sampled_roadmap`.

    Raises
    ------
    StartBlocked, GoalBlocked
        ``a`` or ``b`` is not in free space.
    NoPath
        Obstacles separate them, or only this roadmap does not connect them; the reason says which.
    ValueError
        ``a`` or ``b`` is not one point, or one of the numbers is not whole or too small.

    Notes
    -----
    Source: Bohlin and Kavraki, Path planning using lazy PRM, ICRA 2000.

    >>> from taut import FreeSpace, Scene
    >>> route = lazy_route(FreeSpace(Scene((0, 0, 4, 3))), (0, 0), (4, 3))
    >>> route.length, int(route.tested.sum())
    (5.0, 0)
    """
    given = in_turn(a, b)
    if len(given) != 2:
        raise ValueError(f"a and b must be one point (x, y) each, got {len(given) // 2}")
    drawn = draw_samples(freespace, samples, seed, neighbours)
    tested, blocked = np.zeros((2, len(drawn.pairs)), dtype=np.bool_)
    xy, triangles = freespace.anchor(given)
    require_free(freespace, given, triangles)
    if see_each_other(freespace.mesh, xy, triangles, np.zeros(1, np.int64), np.ones(1, np.int64))[0]:
        route = through(given[0], np.empty((0, 2)), given[1])
        return LazyRoute(route.points, drawn.positions, drawn.pairs, tested, blocked)
    start_parts, goal_parts = freespace.part_of(given)
    if start_parts & goal_parts:
        roadmap, edge_of = _untested(freespace, drawn)
        for nearest in (NEAREST, max(NEAREST, samples)):
            path = _way(roadmap, edge_of, drawn.pairs, attached(roadmap, given, nearest), tested, blocked)
            if path is not None:
                route = through(given[0], drawn.positions[path], given[1])
                return LazyRoute(route.points, drawn.positions, drawn.pairs, tested, blocked)
    raise not_connected(freespace, given[0], given[1])


def _untested(freespace: FreeSpace, drawn: Samples) -> tuple[LocatedRoadmap, Ints]:
    """The roadmap of all candidate edges, blocked ones among them, and the candidate that each CSR entry stands for."""
    n, (low, high) = len(drawn.positions), drawn.pairs.T
    lengths = np.hypot(*(drawn.positions[low] - drawn.positions[high]).T)
    graph = Graph.from_edges(n, drawn.pairs, lengths)
    tail = np.repeat(np.arange(n), np.diff(graph.indptr))
    keys = np.minimum(tail, graph.indices) * n + np.maximum(tail, graph.indices)
    return LocatedRoadmap(drawn.positions, graph, freespace, drawn.triangles), np.searchsorted(low * n + high, keys)


def _way(
    roadmap: LocatedRoadmap,
    edge_of: Ints,
    candidates: Ints,
    ends: Joined,
    tested: NDArray[np.bool_],
    blocked: NDArray[np.bool_],
) -> Ints | None:
    """Vertices of a shortest way between the two ends whose edges are all free, if any; marks what it tests."""
    mesh, n = roadmap.freespace.mesh, len(roadmap.positions)
    graph = Graph(roadmap.graph.indptr, roadmap.graph.indices, roadmap.graph.weights.copy())
    keys = candidates[:, 0] * n + candidates[:, 1]
    while True:
        graph.weights[blocked[edge_of]] = np.inf
        lengths, _, path = paths_between(graph, roadmap.positions, ends)
        if np.isinf(lengths[0]):
            return None
        low, high = np.minimum(path[1:], path[:-1]), np.maximum(path[1:], path[:-1])
        used = np.searchsorted(keys, low * n + high)
        fresh = used[~tested[used]]
        if len(fresh) == 0:
            return path
        tested[fresh] = True
        a, b = candidates[fresh, 0].copy(), candidates[fresh, 1].copy()
        blocked[fresh] = ~see_each_other(mesh, roadmap.positions, roadmap.triangles, a, b)
