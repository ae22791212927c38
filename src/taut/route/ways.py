"""Every way of finding routes for single robots, under one name each: to be compared, and to plan teams on."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from types import MappingProxyType
from typing import TypeAlias, TypeVar

from taut.errors import NoPath
from taut.freespace import FreeSpace
from taut.roadmap import (
    Roadmap,
    cells_roadmap,
    grid_roadmap,
    sampled_roadmap,
    visibility_graph,
    voronoi_roadmap,
)
from taut.route.along import routes_along
from taut.route.central import central_path
from taut.route.core import Route
from taut.route.lazy import lazy_route
from taut.route.obstacles import index_obstacles
from taut.route.oca import oca_path
from taut.route.potential import potential_path
from taut.route.shortest import shortest_routes
from taut.route.smoothing import smoothed
from taut.route.widest import widest_routes
from taut.scene import Robot, Scene

_Found = TypeVar("_Found", bound=Route)


@dataclass(frozen=True, eq=False)
class Answer:
    """A route, and how much of a graph it took.

    Parameters
    ----------
    route : from the robot's start to its goal.
    obstacles : how many obstacles were looked at.
    count : counts the vertices and edges of the graph that was searched, or would be; 0 where there is none.
    """

    route: Route
    obstacles: int
    count: Callable[[], tuple[int, int]]

    @property
    def vertices(self) -> int:
        """How many vertices, start and goal included, the graph has."""
        return self.count()[0]

    @property
    def edges(self) -> int:
        """How many edges it has."""
        return self.count()[1]


@dataclass(frozen=True, eq=False)
class Prepared:
    """What a way builds once for all robots of one growth.

    Parameters
    ----------
    roadmap : the graph on which it finds routes; None where it makes one of its own for each robot, or none.
    ask : finds the route of a robot; raises StartBlocked, GoalBlocked or NoPath.
    """

    roadmap: Roadmap | None
    ask: Callable[[Robot], Answer]


Way: TypeAlias = Callable[[Scene, float, int], Prepared]
"""From a scene, the growth in metres of the robots that will ask, and a seed to what is prepared."""


def _visibility(scene: Scene, growth: float, seed: int) -> Prepared:
    freespace = FreeSpace(scene, growth)
    graph = visibility_graph(freespace)
    return _on(scene, freespace, graph, lambda r: shortest_routes(freespace, graph, [r.start], [r.goal])[0])


def _oca(scene: Scene, growth: float, seed: int) -> Prepared:
    index = index_obstacles(scene)

    def ask(robot: Robot) -> Answer:
        route = oca_path(index, robot)
        return Answer(route, len(route.used), lambda: _tangents(route.freespace, robot))

    return Prepared(None, ask)


def _ca(scene: Scene, growth: float, seed: int) -> Prepared:
    index = index_obstacles(scene)

    def ask(robot: Robot) -> Answer:
        route = central_path(index, robot)
        return Answer(route, len(route.crossed), lambda: (route.roadmap.graph.n, route.roadmap.graph.m))

    return Prepared(None, ask)


def _voronoi(scene: Scene, growth: float, seed: int) -> Prepared:
    freespace = FreeSpace(scene, growth)
    roadmap = voronoi_roadmap(freespace)
    return _on(scene, freespace, roadmap, lambda r: widest_routes(roadmap, [r.start], [r.goal])[0])


def _grid(scene: Scene, growth: float, seed: int) -> Prepared:
    freespace = FreeSpace(scene, growth)
    roadmap = grid_roadmap(freespace)
    return _on(scene, freespace, roadmap, lambda r: smoothed(freespace, routes_along(roadmap, [r.start], [r.goal])[0]))


def _prm(scene: Scene, growth: float, seed: int) -> Prepared:
    freespace = FreeSpace(scene, growth)
    roadmap = sampled_roadmap(freespace, seed=seed)
    return _on(scene, freespace, roadmap, lambda r: routes_along(roadmap, [r.start], [r.goal])[0])


def _lazy_prm(scene: Scene, growth: float, seed: int) -> Prepared:
    freespace = FreeSpace(scene, growth)

    def ask(robot: Robot) -> Answer:
        route = _of(robot, lambda r: lazy_route(freespace, r.start, r.goal, seed=seed))
        return Answer(route, len(scene.obstacles), lambda: (len(route.positions) + 2, int(route.tested.sum())))

    return Prepared(None, ask)


def _cells(scene: Scene, growth: float, seed: int) -> Prepared:
    freespace = FreeSpace(scene, growth)
    roadmap = cells_roadmap(freespace)
    return _on(scene, freespace, roadmap, lambda r: routes_along(roadmap, [r.start], [r.goal])[0])


def _potential(scene: Scene, growth: float, seed: int) -> Prepared:
    freespace = FreeSpace(scene, growth)

    def ask(robot: Robot) -> Answer:
        route = _of(robot, lambda r: potential_path(freespace, r.start, r.goal))
        if route.stuck_at is not None:
            x, y = route.stuck_at
            held = f", held by {' and '.join(route.held_by)}" if route.held_by else ""
            raise NoPath(robot.name, f"stuck in a local minimum at ({x:.4g}, {y:.4g}){held}")
        return Answer(route, len(scene.obstacles), lambda: (0, 0))

    return Prepared(None, ask)


def _tangents(freespace: FreeSpace, robot: Robot) -> tuple[int, int]:
    """Vertices and edges of the tangent graph with start and goal."""
    graph = visibility_graph(freespace, points=[robot.start, robot.goal]).graph
    return graph.n, graph.m


def _on(scene: Scene, freespace: FreeSpace, roadmap: Roadmap, find: Callable[[Robot], Route]) -> Prepared:
    """Routes on one roadmap, to which start and goal are added."""
    graph, obstacles = roadmap.graph, len(scene.obstacles)

    def ask(robot: Robot) -> Answer:
        freespace.require(robot)
        return Answer(_of(robot, find), obstacles, lambda: (graph.n + 2, graph.m))

    return Prepared(roadmap, ask)


def _of(robot: Robot, find: Callable[[Robot], _Found]) -> _Found:
    """What is found for a robot; an error that there is no path names it."""
    try:
        return find(robot)
    except NoPath as error:
        raise NoPath(robot.name, error.reason) from None


WAYS: Mapping[str, Way] = MappingProxyType(
    {
        "visibility": _visibility,
        "oca": _oca,
        "ca": _ca,
        "voronoi": _voronoi,
        "grid": _grid,
        "prm": _prm,
        "lazy-prm": _lazy_prm,
        "cells": _cells,
        "potential": _potential,
    }
)
"""By name; "visibility" and "oca" give shortest routes."""
