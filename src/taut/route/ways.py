"""Every way of finding routes for single robots, under one name each: to be compared, and to plan teams on."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from types import MappingProxyType
from typing import TypeAlias

from taut.freespace import FreeSpace
from taut.roadmap import LocatedRoadmap, visibility_graph
from taut.route.core import Route
from taut.route.shortest import shortest_routes
from taut.scene import Robot, Scene


@dataclass(frozen=True, eq=False)
class Answer:
    """A route, and how much of a graph it took.

    Parameters
    ----------
    route : from the robot's start to its goal.
    vertices, edges : of the graph that was searched.
    obstacles : how many obstacles were looked at.
    """

    route: Route
    vertices: int
    edges: int
    obstacles: int


@dataclass(frozen=True, eq=False)
class Prepared:
    """What a way builds once for all robots of one growth.

    Parameters
    ----------
    roadmap : the graph on which it finds routes; None where it makes a graph of its own for each robot, or none.
    ask : finds the route of a robot; raises StartBlocked, GoalBlocked or NoPath.
    """

    roadmap: LocatedRoadmap | None
    ask: Callable[[Robot], Answer]


Way: TypeAlias = Callable[[Scene, float, int], Prepared]
"""Scene, growth in metres and seed to what is prepared."""


def _visibility(scene: Scene, growth: float, seed: int) -> Prepared:
    freespace = FreeSpace(scene, growth)
    graph = visibility_graph(freespace)
    located = LocatedRoadmap(graph.positions, graph.graph, freespace, freespace.mesh.wedges[graph.wedges, 3])

    def ask(robot: Robot) -> Answer:
        freespace.require(robot)
        route = shortest_routes(freespace, graph, [robot.start], [robot.goal])[0]
        return Answer(route, graph.graph.n + 2, graph.graph.m, len(scene.obstacles))

    return Prepared(located, ask)


WAYS: Mapping[str, Way] = MappingProxyType({"visibility": _visibility})
"""By name."""
