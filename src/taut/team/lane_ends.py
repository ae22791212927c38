"""A robot on lanes: the vertices that are its ends or its ways onto the lanes, and its fastest way on its own."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from scipy.spatial import KDTree

from taut.errors import NoPath
from taut.graph import Graph, components
from taut.graph.core import Floats, Ints
from taut.roadmap import Lanes, LanesRoadmap, LocatedRoadmap, closed_lanes
from taut.route import Route
from taut.route.along import Joined, attached, paths_between, through
from taut.scene import Robot
from taut.team.own_roadmap import OwnRoadmap

_JOINED = 4
_TRIED = 8 * _JOINED


@dataclass(frozen=True, eq=False)
class LaneWay:
    """A robot on lanes.

    Parameters
    ----------
    own : its ends; where one is no vertex of the lanes, also straight ways from there to the nearest that it sees.
    route : the fastest way on its own.
    seconds : how long it takes there, within all speed limits.
    """

    own: OwnRoadmap
    route: Route
    seconds: float


def lane_ways(lanes: Lanes, roadmap: LanesRoadmap, robots: Sequence[Robot]) -> list[LaneWay]:
    """Find the ends and the fastest way of each robot; all must be of the size for which the roadmap was laid.

    A start or goal within the scene's tolerance of a vertex that has lanes is that vertex. Any other is joined with up
    to four of the nearest vertices that it sees, in both directions. One A* for each robot.

    Raises
    ------
    NoPath
        A start or goal sees nothing of the lanes, or they do not lead from one to the other.
    """
    places = np.array([p for robot in robots for p in (robot.start, robot.goal)], dtype=np.float64).reshape(-1, 2)
    if len(roadmap.positions) == 0:
        raise NoPath(robots[0].name, "the roadmap has no vertices, so no lane leads anywhere")
    ends, vertices = _ends(lanes, roadmap, places)
    moving = np.array([robot.start != robot.goal for robot in robots], dtype=np.bool_)
    alone = np.diff(ends.first) == 0
    for k in np.flatnonzero(alone & np.repeat(moving, 2)).tolist():
        word, (x, y) = ("start", "goal")[k % 2], ends.given[k]
        why = f"its {word} ({x:g}, {y:g}) is on no vertex of the lanes and sees none that has a lane"
        raise NoPath(robots[k // 2].name, why + _and(closed_lanes(lanes, roadmap)))
    metres = np.zeros(len(robots))
    routes = [Route(place[None]) for place in ends.given[::2]]
    slowest = float(roadmap.arcs.limits.min(initial=np.inf))
    # robots that no limit slows down share one search graph
    paces = np.array([robot.speed if robot.speed > slowest else 0.0 for robot in robots])
    for pace in np.unique(paces[moving]).tolist():
        group = np.flatnonzero(moving & (paces == pace))
        chosen = _rows(ends, np.stack([2 * group, 2 * group + 1], axis=1).reshape(-1))
        metres[group], start, path = paths_between(_at_pace(roadmap, pace), roadmap.positions, chosen)
        for n, k in enumerate(group.tolist()):
            if not np.isfinite(metres[k]):
                raise NoPath(robots[k].name, _not_led(lanes, roadmap, _rows(ends, np.array([2 * k, 2 * k + 1]))))
            passed = roadmap.positions[path[start[n] : start[n + 1]]]
            routes[k] = through(ends.given[2 * k], passed, ends.given[2 * k + 1])
    seconds = (metres / [robot.speed for robot in robots]).tolist()
    owns = [_own(roadmap, ends, vertices, k) for k in range(len(robots))]
    return [LaneWay(*way) for way in zip(owns, routes, seconds, strict=True)]


def _ends(lanes: Lanes, roadmap: LanesRoadmap, places: Floats) -> tuple[Joined, Ints]:
    """Join places with the nearest vertices that they see and that have lanes; and which vertex each is, −1 for none.

    A place that is a vertex is joined with it alone, and moved there.
    """
    known = np.unique(lanes.arcs)
    vertices = np.full(len(places), -1, dtype=np.int64)
    if len(known) and len(places):
        away, nearest = (np.asarray(x) for x in KDTree(roadmap.positions[known]).query(places))
        there = away <= roadmap.freespace.scene.tol
        vertices[there] = known[nearest[there]]
    on, off = np.flatnonzero(vertices >= 0), np.flatnonzero(vertices < 0)
    used = np.flatnonzero(np.diff(roadmap.graph.indptr) > 0)
    bare = Graph.from_edges(len(used), np.empty((0, 2), dtype=np.int64))
    in_use = LocatedRoadmap(roadmap.positions[used], bare, roadmap.freespace, roadmap.triangles[used])
    found = attached(in_use, places[off], _TRIED)
    joins = found.pairs[np.arange(len(found.vertices)) - np.repeat(found.first[:-1], np.diff(found.first)) < _JOINED]
    place, vertex = np.append(off[joins[:, 0]], on), np.append(used[joins[:, 1]], vertices[on])
    order = np.argsort(place, kind="stable")
    place, vertex = place[order], vertex[order]
    given = places.copy()
    given[on] = roadmap.positions[vertices[on]]
    points, triangles = given.copy(), roadmap.triangles[vertices]
    points[off], triangles[off] = found.points, found.triangles
    first = np.append(0, np.cumsum(np.bincount(place, minlength=len(places)))).astype(np.int64)
    lengths = np.hypot(*(given[place] - roadmap.positions[vertex]).T)
    return Joined(given, points, triangles, first, vertex, lengths), vertices


def _rows(ends: Joined, places: Ints) -> Joined:
    """The same for some of the places."""
    spans = [np.arange(ends.first[k], ends.first[k + 1]) for k in places.tolist()]
    at = np.concatenate(spans)
    first = np.append(0, np.cumsum([len(span) for span in spans])).astype(np.int64)
    return Joined(
        ends.given[places], ends.points[places], ends.triangles[places], first, ends.vertices[at], ends.lengths[at]
    )


def _at_pace(roadmap: LanesRoadmap, pace: float) -> Graph:
    """Rows of the arcs, each weighing the metres that a robot of this top speed goes elsewhere in the same time."""
    arcs = roadmap.arcs
    return Graph(arcs.indptr, arcs.indices, arcs.lengths * np.maximum(1.0, pace / arcs.limits))


def _own(roadmap: LanesRoadmap, ends: Joined, vertices: Ints, k: int) -> OwnRoadmap:
    """What robot k has beyond the lanes; a robot that starts at its goal has one vertex at most."""
    n = len(roadmap.positions)
    start, goal = 2 * k, 2 * k + 1
    apart = bool((ends.given[start] != ends.given[goal]).any())
    off = [i for i in (start, goal) if vertices[i] < 0 and (i == start or apart)]
    number = {i: n + j for j, i in enumerate(off)}
    number |= {i: int(vertices[i]) for i in (start, goal) if vertices[i] >= 0}
    edges = [(v, number[i]) for i in off for v in ends.vertices[ends.first[i] : ends.first[i + 1]].tolist()]
    lengths = [ends.lengths[ends.first[i] : ends.first[i + 1]] for i in off]
    pinched = roadmap.freespace.mesh.on_pinch(ends.points[[start, goal]]).tolist()
    return OwnRoadmap(
        ends.given[off].reshape(-1, 2),
        (number[start], number.get(goal, number[start])),
        np.array(edges, dtype=np.int64).reshape(-1, 2),
        np.concatenate([*lengths, np.empty(0)]),
        (pinched[0], pinched[1]),
    )


def _not_led(lanes: Lanes, roadmap: LanesRoadmap, ends: Joined) -> str:
    """Why the lanes do not lead from the first place to the second."""
    (ax, ay), (bx, by) = ends.given.tolist()
    parts = components(roadmap.graph)[ends.vertices]
    against = np.isin(parts[: ends.first[1]], parts[ends.first[1] :]).any()
    why = "only against the direction of one-way lanes" if against else closed_lanes(lanes, roadmap)
    return f"the lanes do not lead from ({ax:g}, {ay:g}) to ({bx:g}, {by:g}){_and(why)}"


def _and(why: str) -> str:
    return f"; {why}" if why else ""
