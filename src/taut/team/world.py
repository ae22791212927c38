"""World: everything about a scene that does not change while orders are tried."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from functools import lru_cache

import numpy as np
import shapely

from taut.errors import GoalBlocked, NoPath, StartBlocked
from taut.freespace import FreeSpace, without_discs
from taut.roadmap import (
    Lanes,
    LocatedRoadmap,
    PlacesRoadmap,
    SharedRoadmap,
    closed_lanes,
    lanes_roadmap,
    places_roadmap,
    polyline_roadmap,
    shared_roadmap,
    visibility_graph,
)
from taut.route import WAYS, CentralRoute, Route, attach, direct_lengths, routes_between, shortest_routes
from taut.scene import Robot, Scene
from taut.team._conflict_kernels import Floats, Ints
from taut.team.lane_ends import lane_ways
from taut.team.own_roadmap import OwnRoadmap, own_roadmap

_REMEMBERED = 4
"""Roadmaps kept for the next worlds: a team whose robots move, but not its obstacles, needs the same ones."""


class World:
    """Free spaces and roadmaps, one per distinct growth, and each robot's route on its own.

    Parameters
    ----------
    scene : the map and the team.
    way : on what they move: a name of `taut.route.WAYS`. With "visibility" these are tangents and places to pass, and
        routes are shortest; else only that roadmap, or that way's routes, and the robots' own additions. Or lanes: then
        these alone, in their directions and within their speed limits, and straight ways onto them.
    seed : of roadmaps made at random.

    Raises
    ------
    StartBlocked, GoalBlocked, NoPath
        A robot cannot stand at its start or goal, or that way finds no route between them.
    """

    def __init__(self, scene: Scene, way: str | Lanes = "visibility", seed: int = 0) -> None:
        self.scene, self.way, self.seed = scene, way, seed
        self._stations: dict[int, Floats] = {}
        robots = scene.robots
        self._growths = [scene.growth(robot) for robot in robots]
        self._shared: dict[float, SharedRoadmap] = {}
        self._joined: list[tuple[Ints, Ints]] = [(np.empty(0, dtype=np.int64),) * 2] * len(robots)
        routes: list[Route | None] = [None] * len(robots)
        shortest: Floats = np.empty(len(robots))
        self._own: list[OwnRoadmap | None] = [None] * len(robots)
        self.on_lanes = isinstance(way, Lanes)
        self._seconds: Floats = np.empty(len(robots))
        notes: list[str] = []
        for growth in dict.fromkeys(self._growths):
            group = [i for i, g in enumerate(self._growths) if g == growth]
            freespace = FreeSpace(scene, growth)
            for i in group:
                freespace.require(robots[i])
            radius = max(robots[i].radius for i in group)
            separation = 2 * radius + scene.gap if len(robots) > 1 else math.inf
            if isinstance(way, Lanes):
                lanes = lanes_roadmap(way, freespace, separation)
                ways = lane_ways(way, lanes, [robots[i] for i in group])
                found = [on_lanes.route for on_lanes in ways]
                shortest[group] = _straightest(freespace, [robots[i] for i in group])
                self._shared[growth] = lanes
                for i, on_lanes in zip(group, ways, strict=True):
                    self._own[i], self._seconds[i] = on_lanes.own, on_lanes.seconds
                notes.append(closed_lanes(way, lanes))
            elif way == "visibility":
                places = _places_of(freespace, separation)
                ends = attach(freespace, places.tangents, [p for i in group for p in (robots[i].start, robots[i].goal)])
                found = routes_between(freespace, places.tangents, ends)
                shortest[group] = [route.length for route in found]
                self._shared[growth] = places
                for k, i in enumerate(group):
                    self._joined[i] = ends.corners_of(2 * k), ends.corners_of(2 * k + 1)
            else:
                prepared = WAYS[way](scene, growth, seed)
                found = [_allowed(prepared.ask(robots[i]).route, robots[i]) for i in group]
                shortest[group] = _straightest(freespace, [robots[i] for i in group])
                roadmap = prepared.roadmap
                if not isinstance(roadmap, LocatedRoadmap):
                    roadmap = polyline_roadmap(freespace, [route.points for route in found])
                self._shared[growth] = shared_roadmap(roadmap, separation)
            for i, route in zip(group, found, strict=True):
                routes[i] = route
        self.routes = [route for route in routes if route is not None]
        self.shortest = shortest
        self.notes = tuple(note for note in notes if note)
        if not self.on_lanes:
            self._seconds = np.array([r.length / robot.speed for r, robot in zip(self.routes, robots, strict=True)])
        self._detours: list[Route | None] = [None] * len(robots)
        self._ends: Floats = np.array([p for r in robots for p in (r.start, r.goal)], dtype=np.float64).reshape(-1, 2)
        self._radii: Floats = np.repeat(np.array([r.radius for r in robots], dtype=np.float64), 2)
        self._nearby = shapely.STRtree(shapely.points(self._ends))

    @property
    def cell(self) -> float:
        """Side in metres of the cells in which reservations are looked up."""
        finite = [s.spacing for s in self._shared.values() if math.isfinite(s.spacing)]
        return min(finite, default=math.inf)

    def bound(self, objective: str) -> tuple[str, float]:
        """What no plan can beat as every robot needs so long alone: the model, and seconds of the objective.

        The model is "plane": no way is shorter than the shortest in free space; on lanes it is "roadmap".
        """
        speeds = np.array([robot.speed for robot in self.scene.robots])
        alone = self._seconds if self.on_lanes else self.shortest / speeds
        model = "roadmap" if self.on_lanes else "plane"
        if objective == "makespan":
            since = np.array([robot.start_time for robot in self.scene.robots])
            return model, float(np.where(alone > 0, since + alone, 0.0).max(initial=0.0))
        return model, float(alone.sum())

    @property
    def soonest(self) -> Floats:
        """When each robot would arrive if it were alone, (n,) seconds."""
        since = np.array([robot.start_time for robot in self.scene.robots])
        return np.asarray(np.where(self._seconds > 0, since + self._seconds, 0.0))

    @property
    def horizon(self) -> float:
        """Seconds by which all robots would have arrived if nobody waited."""
        return float(self.soonest.max()) or 1.0

    @property
    def moment(self) -> float:
        """Seconds that a slow robot takes to get out of the way: for so long starts are held at first."""
        robots = self.scene.robots
        size = 2 * max(r.radius for r in robots) + self.scene.gap
        return 4 * size / min(r.speed for r in robots)

    def shared(self, i: int) -> SharedRoadmap:
        """Return the roadmap that robot i shares with all of its growth."""
        return self._shared[self._growths[i]]

    def own(self, i: int) -> OwnRoadmap:
        """Return what robot i has beyond it."""
        known = self._own[i]
        if known is None:
            detour = self._detours[i]
            routes = [self.routes[i]] if detour is None else [self.routes[i], detour]
            near = self._in_the_way(i)
            growth = self._growths[i]
            known = own_roadmap(
                self._shared[growth],
                self.scene.robots[i],
                self._joined[i],
                routes,
                self._ends[near],
                self._keeps_from(i)[near],
                self._stations.get(i, np.empty((0, 2))),
            )
            self._own[i] = known
        return known

    def enrich(self, i: int, places: Floats) -> None:
        """Give robot i stations of its own at those of (k, 2) places that are free; on lanes there are none."""
        if not self.on_lanes:
            self._stations[i] = places[self.shared(i).freespace.mesh.locate(places) >= 0]
            self._own[i] = None

    def body(self, i: int) -> Floats:
        """Radius, gap in planning and headway of robot i, as the kernels want them."""
        scene = self.scene
        return np.array([scene.robots[i].radius, scene.gap - scene.tol / 2, scene.headway])

    def avoid_all_ends(self, i: int) -> bool:
        """Give robot i a route that keeps clear of all other robots' starts and goals; False if there is no new one.

        On lanes there is never a new one: every way that they lead is known already.
        """
        robot = self.scene.robots[i]
        if self.on_lanes or self._detours[i] is not None or robot.start == robot.goal:
            return False
        others = np.flatnonzero(np.arange(len(self._ends)) // 2 != i)
        apart = without_discs(self.shared(i).freespace, self._ends[others], self._keeps_from(i)[others])
        tangents = visibility_graph(apart)
        try:
            self._detours[i] = shortest_routes(apart, tangents, [robot.start], [robot.goal])[0]
        except (NoPath, StartBlocked, GoalBlocked):
            return False
        self._own[i] = None
        return True

    def _keeps_from(self, i: int) -> Floats:
        """Metres that robot i keeps from the robot that starts or ends at each of the ends."""
        return np.asarray(self.scene.robots[i].radius + self._radii + self.scene.gap)

    def _in_the_way(self, i: int) -> Ints:
        """Ends of other robots that robot i cannot pass on its shortest route while a robot stands there."""
        points = self.routes[i].points
        line = shapely.linestrings(points if len(points) > 1 else np.repeat(points, 2, axis=0))
        keeps = self._keeps_from(i)
        near = np.sort(self._nearby.query(line, predicate="dwithin", distance=float(keeps.max())))
        near = near[near // 2 != i]
        return np.asarray(near[shapely.distance(line, shapely.points(self._ends[near])) < keeps[near]])


def _straightest(freespace: FreeSpace, robots: Sequence[Robot]) -> Floats:
    """Shortest lengths in the plane from start to goal, metres."""
    return direct_lengths(freespace, [robot.start for robot in robots], [robot.goal for robot in robots])[0]


def _allowed(route: Route, robot: Robot) -> Route:
    if isinstance(route, CentralRoute) and not route.free:
        hit = route.hits[0]
        what, (x, y) = " and ".join(hit.obstacles), hit.place
        raise NoPath(robot.name, f"the Central Algorithm's path hits {what} at ({x:.4g}, {y:.4g})")
    return route


@dataclass(frozen=True)
class _Ground:
    """All that a roadmap of places depends on, and the free space to build it from."""

    vertices: bytes
    triangles: bytes
    neighbours: bytes
    area: float
    tol: float
    separation: float
    freespace: FreeSpace = field(compare=False, repr=False)


def _places_of(freespace: FreeSpace, separation: float) -> PlacesRoadmap:
    mesh = freespace.mesh
    parts = (mesh.vertices.tobytes(), mesh.triangles.tobytes(), mesh.neighbours.tobytes())
    ground = _Ground(*parts, freespace.area, freespace.scene.tol, separation, freespace)
    return replace(places_on(ground), freespace=freespace)


@lru_cache(_REMEMBERED)
def places_on(ground: _Ground) -> PlacesRoadmap:
    """Build the roadmap of a ground, or find it among the last ones."""
    return places_roadmap(ground.freespace, ground.separation)
