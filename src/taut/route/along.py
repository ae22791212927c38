"""Routes along any roadmap: starts and goals joined with what they see of it, then A*."""

from __future__ import annotations

from dataclasses import dataclass
from itertools import pairwise

import numpy as np
from numpy.typing import ArrayLike
from scipy.spatial import KDTree

from taut.chunks import over_chunks
from taut.errors import NoPath
from taut.freespace import FreeSpace
from taut.geometry.seeing import see_each_other
from taut.geometry.triangulation import Floats, Ints
from taut.graph import Graph, _kernels
from taut.roadmap.core import LocatedRoadmap
from taut.route.core import Route, in_turn, points_of, require_free
from taut.scene import FloatArray

NEAREST = 32
_CHUNK = 256
_MOST_PAIRS = 1 << 20


@dataclass(frozen=True, eq=False)
class Joined:
    """Places joined with the vertices of a roadmap.

    Parameters
    ----------
    given : (k, 2) metres, as asked for.
    points : (k, 2) the same, moved into the free space where rounding left them outside.
    triangles : (k,) a triangle of the mesh that contains each, −1 where a place is not free.
    first, vertices : CSR of the vertices that each place sees, the nearest first.
    lengths : metres to each of them.
    """

    given: FloatArray
    points: FloatArray
    triangles: Ints
    first: Ints
    vertices: Ints
    lengths: Floats

    @property
    def pairs(self) -> Ints:
        """(m, 2) place and vertex, in the order of ``lengths``."""
        places = np.repeat(np.arange(len(self.given)), np.diff(self.first))
        return np.stack([places, self.vertices], axis=1)


def routes_along(roadmap: LocatedRoadmap, starts: ArrayLike, goals: ArrayLike) -> list[Route]:
    """Find a shortest route along a roadmap from each of (k, 2) starts to the goal in the same row.

    Starts and goals are joined with those of their nearest vertices that they see, see `attached`, and with each other
    where they see each other; where that does not lead from one to the other, with all vertices that they see.

    Raises
    ------
    StartBlocked, GoalBlocked
        A start or a goal is not in free space.
    NoPath
        Obstacles separate the two, or only this roadmap does not connect them; the reason says which.
    ValueError
        They are not (k, 2) points, or not as many of one as of the other.

    >>> from taut import FreeSpace, Scene
    >>> from taut.roadmap.grid import grid_roadmap
    >>> roadmap = grid_roadmap(FreeSpace(Scene((0, 0, 4, 3))))
    >>> routes_along(roadmap, [(0, 0)], [(4, 3)])[0].length
    5.0
    """
    given = in_turn(starts, goals)
    xy, triangles = roadmap.freespace.anchor(given)
    require_free(roadmap.freespace, given, triangles)
    firsts = np.arange(0, len(given), 2, dtype=np.int64)
    direct = see_each_other(roadmap.freespace.mesh, xy, triangles, firsts, firsts + 1)
    nothing = np.empty((0, 2))
    routes = {k: through(given[2 * k], nothing, given[2 * k + 1]) for k in np.flatnonzero(direct).tolist()}
    left = np.flatnonzero(~direct)
    for nearest in (NEAREST, max(NEAREST, len(roadmap.positions))):
        places = np.stack([2 * left, 2 * left + 1], axis=1).reshape(-1)
        ends = attached(roadmap, given[places], nearest)
        lengths, start, path = paths_between(roadmap.graph, roadmap.positions, ends)
        for i, (k, (begin, end)) in enumerate(zip(left.tolist(), pairwise(start.tolist()), strict=True)):
            if np.isfinite(lengths[i]):
                routes[k] = through(given[2 * k], roadmap.positions[path[begin:end]], given[2 * k + 1])
        left = left[np.isinf(lengths)]
    if len(left):
        raise not_connected(roadmap.freespace, *given[2 * left[0] : 2 * left[0] + 2])
    return [routes[k] for k in range(len(firsts))]


def attached(roadmap: LocatedRoadmap, places: ArrayLike, nearest: int = NEAREST) -> Joined:
    """Join (k, 2) places with those of their nearest vertices that they see.

    Where a place sees none of them, four times as many are tried, and so on: it joins nothing only if it sees no vertex
    at all, or is not free.

    Parameters
    ----------
    nearest : how many vertices are tried for each place at first, at least 1.

    Raises
    ------
    ValueError
        The places are not (k, 2) points, or ``nearest`` is less than 1.

    >>> from taut import FreeSpace, Scene
    >>> from taut.roadmap.grid import grid_roadmap
    >>> roadmap = grid_roadmap(FreeSpace(Scene((0, 0, 4, 3))), spacing=1)
    >>> attached(roadmap, [(1, 1.25)], nearest=2).pairs.tolist()
    [[0, 6], [0, 11]]
    """
    if not nearest >= 1:
        raise ValueError(f"nearest must be at least 1, got {nearest!r}")
    given = points_of(places, "places")
    freespace = roadmap.freespace
    xy, triangles = freespace.anchor(given)
    n = len(roadmap.positions)
    positions = np.concatenate([roadmap.positions, xy])
    holders = np.concatenate([roadmap.triangles, triangles])
    found = [np.empty((0, 2), dtype=np.int64)]
    count = min(nearest, n)
    left = np.flatnonzero(triangles >= 0)
    tree = KDTree(roadmap.positions) if n and len(left) else None
    while tree is not None and len(left):
        lonely = []
        batch = max(_MOST_PAIRS // count, 1)
        for own in (left[i : i + batch] for i in range(0, len(left), batch)):
            near = np.asarray(tree.query(xy[own], k=np.arange(1, count + 1))[1], dtype=np.int64)
            pairs = np.stack([np.repeat(own, count), near.reshape(-1)], axis=1)
            seen = see_each_other(freespace.mesh, positions, holders, n + pairs[:, 0], pairs[:, 1].copy())
            found.append(pairs[seen])
            lonely.append(own[~seen.reshape(len(own), count).any(axis=1)])
        left = np.concatenate(lonely)
        if count == n:
            break
        count = min(4 * count, n)
    joins = np.concatenate(found)
    joins = joins[np.argsort(joins[:, 0], kind="stable")]
    first = np.append(0, np.cumsum(np.bincount(joins[:, 0], minlength=len(given)))).astype(np.int64)
    lengths = np.hypot(*(roadmap.positions[joins[:, 1]] - xy[joins[:, 0]]).T)
    return Joined(given, xy, triangles, first, joins[:, 1].copy(), lengths)


def paths_between(graph: Graph, positions: Floats, ends: Joined) -> tuple[Floats, Ints, Ints]:
    """Lengths between places 0 and 1, 2 and 3, … by way of at least one vertex, inf where nothing connects them.

    Edges of infinite weight are not used.

    Returns
    -------
    lengths : (k,) metres.
    start, path : CSR of the vertices passed.
    """
    arrays = graph.indptr, graph.indices, graph.weights, positions

    def chunk(begin: int, end: int) -> tuple[Floats, Ints, Ints]:
        own = np.arange(2 * begin, 2 * end, 2, dtype=np.int64)
        away, there = _rows(ends, own), _rows(ends, own + 1)
        return _kernels.astar(*arrays, ends.points[own], *away, ends.points[own + 1], *there)

    found = over_chunks(chunk, len(ends.given) // 2, _CHUNK)
    if not found:
        return np.empty(0), np.zeros(1, dtype=np.int64), np.empty(0, dtype=np.int64)
    lengths, starts, paths = zip(*found, strict=True)
    counts = np.concatenate([np.diff(start) for start in starts])
    return np.concatenate(lengths), np.append(0, np.cumsum(counts)), np.concatenate(paths)


def through(start: FloatArray, places: Floats, goal: FloatArray) -> Route:
    """Return the route from a start by way of (k, 2) places to a goal."""
    points = np.concatenate([start[None], places, goal[None]])
    moved = np.append(True, (points[1:] != points[:-1]).any(axis=1))
    return Route(points[moved])


def not_connected(freespace: FreeSpace, start: FloatArray, goal: FloatArray) -> NoPath:
    """Return the error for two free places between which no route was found: why there is none."""
    here, there = freespace.part_of([start, goal])
    grown = f" grown by {freespace.growth:g} m" if freespace.growth else ""
    if here & there:
        why = "this roadmap does not connect them, though the free space does; take a finer one"
    else:
        why = f"obstacles{grown} separate them"
    return NoPath("", f"no way from ({start[0]:g}, {start[1]:g}) to ({goal[0]:g}, {goal[1]:g}): {why}")


def _rows(ends: Joined, places: Ints) -> tuple[Ints, Ints]:
    """CSR of the vertices joined with some of the places."""
    counts = ends.first[places + 1] - ends.first[places]
    start = np.append(0, np.cumsum(counts))
    at = np.arange(start[-1]) + np.repeat(ends.first[places] - start[:-1], counts)
    return start, ends.vertices[at]
