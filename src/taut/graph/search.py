"""Shortest paths on a Graph: Dijkstra from one vertex, A* between two."""

from __future__ import annotations

import numpy as np

from taut.graph import _kernels
from taut.graph.core import Floats, Graph, Ints


def dijkstra(graph: Graph, source: int) -> tuple[Floats, Ints]:
    """Distances from ``source`` and shortest-path tree.

    Returns
    -------
    distance : (n,) sum of weights, inf where there is no path.
    before : (n,) the vertex before each on its shortest path; −1 for the source and unreachable vertices.

    Raises
    ------
    IndexError
        ``source`` is not a vertex.
    """
    _check(graph, source)
    return _kernels.dijkstra(graph.indptr, graph.indices, graph.weights, source)


def astar(graph: Graph, positions: Floats, source: int, target: int) -> tuple[float, Ints]:
    """Length and vertices of a shortest path, led by the straight-line distance to the target.

    ``positions`` is (n, 2); no weight may be less than the distance between its ends. (inf, empty) without a path.

    Raises
    ------
    IndexError
        ``source`` or ``target`` is not a vertex.
    """
    _check(graph, source)
    _check(graph, target)
    ends = np.array([source]), np.array([target])
    return astar_between(graph, positions, positions[source], ends[0], positions[target], ends[1])


def astar_between(
    graph: Graph, positions: Floats, source: Floats, first: Ints, target: Floats, last: Ints
) -> tuple[float, Ints]:
    """Length and vertices of a shortest path between two places off the graph.

    ``first`` are the vertices joined straight with the place ``source`` (2,), ``last`` those joined with ``target``;
    at least one vertex is passed. (inf, empty) without a path.
    """
    return _kernels.astar(graph.indptr, graph.indices, graph.weights, positions, source, first, target, last)


def path_to(before: Ints, target: int) -> list[int]:
    """Vertices from the root of a shortest-path tree to ``target``."""
    path = [target]
    while before[path[-1]] >= 0:
        path.append(int(before[path[-1]]))
    return path[::-1]


def _check(graph: Graph, vertex: int) -> None:
    if not 0 <= vertex < graph.n:
        raise IndexError(f"vertex {vertex} is not one of 0 … {graph.n - 1}")
