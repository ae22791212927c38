"""Any-angle smoothing: a route cut short wherever two of its points see each other."""

from __future__ import annotations

import numpy as np

from taut.freespace import FreeSpace
from taut.geometry.seeing import see_each_other
from taut.geometry.triangulation import Ints
from taut.graph import Graph, dijkstra
from taut.graph.search import path_to
from taut.route.core import Route

# how many points ahead each one looks
_WINDOW = 64


def smoothed(freespace: FreeSpace, route: Route) -> Route:
    """Shorten an allowed route of this free space: the best way between its ends through its own points.

    Any two points of the route that see each other are joined, at most 64 points apart; then again on what is left,
    until it gets no shorter. The result is never longer, has the same ends and is allowed.

    Raises
    ------
    ValueError
        A point of the route is not in the free space.

    >>> from taut import FreeSpace, Scene
    >>> smoothed(FreeSpace(Scene((0, 0, 4, 3))), Route(np.array([(0, 0), (2, 3), (4, 0.0)]))).points.tolist()
    [[0.0, 0.0], [4.0, 0.0]]
    """
    while True:
        shorter = _shortcut(freespace, route)
        if not shorter.length < route.length:
            return route
        route = shorter


def _shortcut(freespace: FreeSpace, route: Route) -> Route:
    xy, triangles = freespace.anchor(route.points)
    if (triangles < 0).any():
        x, y = route.points[int(np.argmin(triangles))].tolist()
        raise ValueError(f"the route's point ({x:g}, {y:g}) is not in free space (growth {freespace.growth:g} m)")
    n = len(xy)
    if n < 3:
        return route
    pairs = _pairs_ahead(n)
    # where free space touches itself, a way that comes from elsewhere may be on the wrong side
    pinched = freespace.mesh.on_pinch(xy)
    pinched[[0, -1]] = False
    legs = pairs[:, 1] == pairs[:, 0] + 1
    pairs = pairs[legs | ~pinched[pairs].any(axis=1)]
    legs = pairs[:, 1] == pairs[:, 0] + 1
    # legs are allowed, though they need not be seen: they may touch corners
    kept = legs | see_each_other(freespace.mesh, xy, triangles, pairs[:, 0].copy(), pairs[:, 1].copy())
    edges = pairs[kept]
    lengths = np.hypot(*(route.points[edges[:, 0]] - route.points[edges[:, 1]]).T)
    _, before = dijkstra(Graph.from_edges(n, edges, lengths), 0)
    points = route.points[path_to(before, n - 1)]
    moved = np.append(True, (points[1:] != points[:-1]).any(axis=1))
    return Route(points[moved])


def _pairs_ahead(n: int) -> Ints:
    """Pairs i < j ≤ i + window of 0 … n − 1."""
    first, ahead = np.divmod(np.arange(n * _WINDOW), _WINDOW)
    pairs = np.stack([first, first + 1 + ahead], axis=1)
    return np.asarray(pairs[pairs[:, 1] < n])
