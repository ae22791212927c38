"""Widest routes: along the Voronoi roadmap, as far from obstacles and wall as possible, then as short as possible."""

from __future__ import annotations

from dataclasses import dataclass
from itertools import pairwise
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from taut.geometry.seeing import see_each_other
from taut.geometry.triangulation import Floats, Ints
from taut.roadmap.voronoi import VoronoiRoadmap, boundary_distances
from taut.route import _widest_kernels
from taut.route.along import attached, not_connected, through
from taut.route.core import Route, in_turn, require_free

_NEAREST = 8


@dataclass(frozen=True, eq=False)
class WidestRoute(Route):
    """A route with as much room as possible.

    Parameters
    ----------
    points : (k, 2) metres, from start to goal; one row if they are the same place.
    clearance : metres from the boundary of free space that the whole route keeps.
    """

    clearance: float


def widest_routes(voronoi: VoronoiRoadmap, starts: ArrayLike, goals: ArrayLike) -> list[WidestRoute]:
    """Find a route from each of (k, 2) starts to the goal in the same row that keeps farthest from the boundary.

    Among the routes along the roadmap whose least distance is the greatest it is a shortest. No way in the plane keeps
    more than ``voronoi.error`` metres more.

    Raises
    ------
    StartBlocked, GoalBlocked
        A start or a goal is not in free space.
    NoPath
        Obstacles separate them.
    ValueError
        They are not (k, 2) points, or not as many of one as of the other.

    Notes
    -----
    An end leads straight to the centre of the circle about its cell, on which line it comes no nearer to the boundary
    than at the two, and to the vertices next to it that it sees; start and goal also to each other. The route is no
    wider than its ends: where one is at the boundary, it is a shortest route along the whole roadmap.

    >>> from taut import FreeSpace, Scene
    >>> from taut.roadmap.voronoi import voronoi_roadmap
    >>> roadmap = voronoi_roadmap(FreeSpace(Scene((0, 0, 8, 4))))
    >>> widest_routes(roadmap, [(1, 1)], [(7, 1)])[0].clearance
    1.0
    """
    given = in_turn(starts, goals)
    freespace = voronoi.freespace
    xy, triangles = freespace.anchor(given)
    require_free(freespace, given, triangles)
    firsts = np.arange(0, len(given), 2, dtype=np.int64)
    direct = see_each_other(freespace.mesh, xy, triangles, firsts, firsts + 1)
    straight = np.full(len(firsts), -1.0)
    a, b = firsts[direct], firsts[direct] + 1
    straight[direct] = boundary_distances(freespace.mesh, xy[a], xy[b], triangles[a])
    joins = _joins(voronoi, given)
    rooms = _rooms(voronoi)
    routes = []
    for k, (start, goal) in enumerate(zip(given[::2], given[1::2], strict=True)):
        least, path = _between(voronoi, rooms, joins[2 * k], joins[2 * k + 1], float(straight[k]))
        if least < 0:
            raise not_connected(freespace, start, goal)
        routes.append(WidestRoute(through(start, voronoi.positions[path], goal).points, least))
    return routes


class _Joins(NamedTuple):
    """Vertices joined straight with a place, metres to each, and metres from the boundary that the joins keep."""

    vertices: Ints
    lengths: Floats
    rooms: Floats


def _joins(voronoi: VoronoiRoadmap, given: Floats) -> list[_Joins]:
    """Joins of (k, 2) places with the vertex of their cell and with the nearest ones that they see."""
    mesh = voronoi.freespace.mesh
    near = attached(voronoi, given, _NEAREST)
    cell = voronoi.cells.locate(near.points)
    own = np.where(cell >= 0, voronoi.centres[cell], -1) if len(voronoi.centres) else cell
    place = np.flatnonzero(own >= 0)
    positions, triangles = (
        np.concatenate([voronoi.positions, near.points]),
        np.append(voronoi.triangles, near.triangles),
    )
    seen = see_each_other(mesh, positions, triangles, len(voronoi.positions) + place, own[place])
    pairs = np.unique(np.concatenate([near.pairs, np.stack([place, own[place]], axis=1)[seen]]), axis=0)
    places, vertices = pairs[:, 0].copy(), pairs[:, 1].copy()
    ends, others = near.points[places], voronoi.positions[vertices]
    lengths = np.hypot(*(others - ends).T)
    # from the vertex, which lies in one triangle, while the place may be one where free space touches itself
    rooms = boundary_distances(mesh, others, ends, voronoi.triangles[vertices])
    first = np.searchsorted(places, np.arange(len(given) + 1))
    return [_Joins(vertices[i:j], lengths[i:j], rooms[i:j]) for i, j in pairwise(first.tolist())]


def _rooms(voronoi: VoronoiRoadmap) -> Floats:
    """Clearance of each entry of the graph, (2 m,)."""
    graph, edges = voronoi.graph, voronoi.edges
    tail = np.repeat(np.arange(graph.n), np.diff(graph.indptr))
    low, high = np.minimum(tail, graph.indices), np.maximum(tail, graph.indices)
    return voronoi.clearances[np.searchsorted(edges[:, 0] * graph.n + edges[:, 1], low * graph.n + high)]


def _between(
    voronoi: VoronoiRoadmap, rooms: Floats, start: _Joins, goal: _Joins, straight: float
) -> tuple[float, Ints]:
    """Room of the widest way between two places, −1 for none, and the vertices that the shortest such way passes.

    ``straight`` is the room of the straight line between the two, −1 where they do not see each other.
    """
    graph = voronoi.graph
    ends = (start.vertices, start.rooms), (goal.vertices, goal.rooms)
    least = _widest_kernels.bottleneck(graph.indptr, graph.indices, rooms, *ends[0], *ends[1])
    if straight >= least:
        return straight, np.empty(0, dtype=np.int64)
    arrays = graph.indptr, graph.indices, graph.weights, rooms
    return least, _widest_kernels.shortest_with_room(*arrays, *start, *goal, least)[1]
