"""World: everything about a scene that does not change while orders are tried."""

from __future__ import annotations

import math

import numpy as np

from taut.errors import NoPath
from taut.freespace import FreeSpace, without_discs
from taut.roadmap import PlacesRoadmap, places_roadmap, visibility_graph
from taut.route import Route, shortest_routes
from taut.scene import Scene
from taut.team._kernels import Floats
from taut.team.own_roadmap import OwnRoadmap, close_to, own_roadmap


class World:
    """Free spaces and roadmaps, one per distinct growth, and each robot's shortest route.

    Raises
    ------
    StartBlocked, GoalBlocked, NoPath
        A robot cannot stand at its start or goal, or obstacles separate them.
    """

    def __init__(self, scene: Scene) -> None:
        self.scene = scene
        robots = scene.robots
        self._growths = [scene.growth(robot) for robot in robots]
        self._shared: dict[float, PlacesRoadmap] = {}
        routes: list[Route | None] = [None] * len(robots)
        for growth in dict.fromkeys(self._growths):
            group = [i for i, g in enumerate(self._growths) if g == growth]
            freespace = FreeSpace(scene, growth)
            for i in group:
                freespace.require(robots[i])
            radius = max(robots[i].radius for i in group)
            separation = 2 * radius + scene.gap if len(robots) > 1 else math.inf
            shared = places_roadmap(freespace, separation)
            self._shared[growth] = shared
            starts, goals = [robots[i].start for i in group], [robots[i].goal for i in group]
            for i, route in zip(group, shortest_routes(freespace, shared.tangents, starts, goals), strict=True):
                routes[i] = route
        self.routes = [route for route in routes if route is not None]
        self._detours: list[Route | None] = [None] * len(robots)
        self._own: list[OwnRoadmap | None] = [None] * len(robots)
        self._ends = np.array([p for r in robots for p in (r.start, r.goal)], dtype=np.float64).reshape(-1, 2)
        radii = np.repeat([r.radius for r in robots], 2)
        self._radii: Floats = np.asarray(radii, dtype=np.float64)

    @property
    def cell(self) -> float:
        """Side in metres of the cells in which reservations are looked up."""
        finite = [s.spacing for s in self._shared.values() if math.isfinite(s.spacing)]
        return min(finite, default=math.inf)

    @property
    def horizon(self) -> float:
        """Seconds by which all robots would have arrived if nobody waited."""
        pairs = zip(self.scene.robots, self.routes, strict=True)
        return max(robot.start_time + route.length / robot.speed for robot, route in pairs) or 1.0

    @property
    def moment(self) -> float:
        """Seconds that a slow robot takes to get out of the way: for so long starts are held at first."""
        robots = self.scene.robots
        size = 2 * max(r.radius for r in robots) + self.scene.gap
        return 4 * size / min(r.speed for r in robots)

    def shared(self, i: int) -> PlacesRoadmap:
        """Return the roadmap that robot i shares with all of its growth."""
        return self._shared[self._growths[i]]

    def own(self, i: int) -> OwnRoadmap:
        """Return what robot i has beyond it."""
        known = self._own[i]
        if known is None:
            others, distances = self._others(i)
            near = close_to(self.routes[i], others, distances)
            detour = self._detours[i]
            routes = [self.routes[i]] if detour is None else [self.routes[i], detour]
            known = own_roadmap(self.shared(i), routes, others[near], distances[near])
            self._own[i] = known
        return known

    def body(self, i: int) -> Floats:
        """Radius, gap in planning and headway of robot i, as the kernels want them."""
        scene = self.scene
        return np.array([scene.robots[i].radius, scene.gap - scene.tol / 2, scene.headway])

    def avoid_all_ends(self) -> None:
        """Give each robot, where there is one, a route that keeps clear of all other robots' starts and goals."""
        for i, robot in enumerate(self.scene.robots):
            if self._detours[i] is not None or robot.start == robot.goal:
                continue
            others, distances = self._others(i)
            apart = without_discs(self.shared(i).freespace, others, distances)
            try:
                self._detours[i] = shortest_routes(apart, visibility_graph(apart), [robot.start], [robot.goal])[0]
            except (NoPath, ValueError):
                continue
            self._own[i] = None

    def _others(self, i: int) -> tuple[Floats, Floats]:
        """Starts and goals of the other robots, and the distance that robot i keeps from each."""
        mine = np.zeros(len(self._ends), dtype=bool)
        mine[2 * i : 2 * i + 2] = True
        distances = self.scene.robots[i].radius + self._radii[~mine] + self.scene.gap
        return self._ends[~mine], distances
