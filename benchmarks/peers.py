"""The same task with other libraries: each makes a query function from a scene of disjoint convex polygons."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from importlib import import_module
from importlib.util import find_spec
from typing import Any, TypeAlias

import numpy as np
import shapely

from taut.scene import Point, Scene

Query: TypeAlias = Callable[[Point, Point], float]
"""From start and goal to the length of the shortest path, metres."""


@dataclass(frozen=True)
class Peer:
    """A library, the packages it needs, and how it prepares a scene for queries."""

    name: str
    packages: tuple[str, ...]
    prepare: Callable[[Scene], Query]

    @property
    def missing(self) -> tuple[str, ...]:
        """Packages that are not installed."""
        return tuple(name for name in self.packages if find_spec(name) is None)


def _pyvisgraph(scene: Scene) -> Query:
    vg: Any = import_module("pyvisgraph")
    graph = vg.VisGraph()
    graph.build([[vg.Point(x, y) for x, y in o.core.tolist()] for o in scene.obstacles], workers=1, status=False)

    def query(start: Point, goal: Point) -> float:
        path = graph.shortest_path(vg.Point(*start), vg.Point(*goal))
        return _length(np.array([(p.x, p.y) for p in path]))

    return query


def _extremitypathfinder(scene: Scene) -> Query:
    environment = import_module("extremitypathfinder").PolygonEnvironment()
    environment.store(list(scene.workspace), [o.core[::-1] for o in scene.obstacles], validate=False)

    def query(start: Point, goal: Point) -> float:
        return float(environment.find_shortest_path(start, goal, verify=False)[1])

    return query


def _shapely_networkx(scene: Scene) -> Query:
    nx: Any = import_module("networkx")
    free = shapely.difference(
        shapely.Polygon(scene.workspace), shapely.union_all([shapely.Polygon(o.core) for o in scene.obstacles])
    )
    shapely.prepare(free)
    corners = np.concatenate([o.core for o in scene.obstacles])
    n = len(corners)

    def seen(i: Any, j: Any, positions: Any) -> list[tuple[int, int, float]]:
        lines = shapely.linestrings(np.stack([positions[i], positions[j]], axis=1))
        clear = shapely.covers(free, lines)
        weights = np.hypot(*(positions[i] - positions[j])[clear].T)
        return list(zip(i[clear].tolist(), j[clear].tolist(), weights.tolist(), strict=True))

    graph = nx.Graph()
    graph.add_nodes_from(range(n))
    for k in range(n - 1):
        graph.add_weighted_edges_from(seen(np.full(n - 1 - k, k), np.arange(k + 1, n), corners))

    def query(start: Point, goal: Point) -> float:
        positions = np.concatenate([corners, [start, goal]])
        every = np.arange(n)
        graph.add_weighted_edges_from(seen(np.append(every, n), np.full(n + 1, n + 1), positions))
        graph.add_weighted_edges_from(seen(every, np.full(n, n), positions))
        length = nx.dijkstra_path_length(graph, n, n + 1)
        graph.remove_nodes_from([n, n + 1])
        return float(length)

    return query


def _length(points: Any) -> float:
    return math.fsum(np.hypot(*np.diff(points, axis=0).T).tolist())


PEERS = (
    Peer("shapely + networkx", ("shapely", "networkx"), _shapely_networkx),
    Peer("pyvisgraph", ("pyvisgraph",), _pyvisgraph),
    Peer("extremitypathfinder", ("extremitypathfinder",), _extremitypathfinder),
)
