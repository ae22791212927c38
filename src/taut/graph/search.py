"""Searches on a Graph: Dijkstra from one vertex, A* between two, breadth first and depth first."""

from __future__ import annotations

from operator import index

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
    source = check_vertex(graph, source)
    return _kernels.dijkstra(graph.indptr, graph.indices, graph.weights, np.array([source]), np.zeros(1))


def astar(graph: Graph, positions: Floats, source: int, target: int) -> tuple[float, Ints]:
    """Length and vertices of a shortest path, led by the straight-line distance to the target.

    ``positions`` is (n, 2); no weight may be less than the distance between its ends. (inf, empty) without a path.

    Raises
    ------
    IndexError
        ``source`` or ``target`` is not a vertex.
    """
    source, target = check_vertex(graph, source), check_vertex(graph, target)
    ends = np.array([source]), np.array([target])
    return astar_between(graph, positions, positions[source], ends[0], positions[target], ends[1])


def astar_between(
    graph: Graph, positions: Floats, source: Floats, first: Ints, target: Floats, last: Ints
) -> tuple[float, Ints]:
    """Length and vertices of a shortest path between two places off the graph.

    ``first`` are the vertices joined straight with the place ``source`` (2,), ``last`` those joined with ``target``;
    at least one vertex is passed. (inf, empty) without a path.
    """
    starts = np.array([0, len(first)]), np.array([0, len(last)])
    lengths, _, path = astar_many(graph, positions, source[None], starts[0], first, target[None], starts[1], last)
    return float(lengths[0]), path


def astar_many(
    graph: Graph,
    positions: Floats,
    sources: Floats,
    first_start: Ints,
    first: Ints,
    targets: Floats,
    last_start: Ints,
    last: Ints,
) -> tuple[Floats, Ints, Ints]:
    """Shortest paths between k pairs of places off the graph, as `astar_between`, without Python in the loop.

    Parameters
    ----------
    sources, targets : (k, 2) places.
    first_start, first : CSR of the vertices joined straight with each source.
    last_start, last : CSR of those joined with each target.

    Returns
    -------
    lengths : (k,), inf without a path.
    start, path : CSR of the vertices passed.
    """
    ends = sources, first_start, first, targets, last_start, last
    return _kernels.astar(graph.indptr, graph.indices, graph.weights, positions, *ends)


def breadth_first(graph: Graph, source: int) -> tuple[Ints, Ints]:
    """Fewest edges from ``source`` to each vertex, whatever their weights, and the tree of first sights.

    Vertices are visited in the order in which they were first seen, neighbours in ascending order. O(n + m).

    Returns
    -------
    hops : (n,) number of edges, −1 where there is no path.
    before : (n,) the vertex from which each was first seen; −1 for the source and unreachable vertices.

    Raises
    ------
    IndexError
        ``source`` is not a vertex.

    >>> breadth_first(Graph.from_edges(4, [(0, 1), (1, 2), (0, 2)]), 0)[0].tolist()
    [0, 1, 1, -1]
    """
    source = check_vertex(graph, source)
    return _kernels.breadth_first(graph.indptr, graph.indices, source)


def depth_first(graph: Graph, source: int) -> tuple[Ints, Ints]:
    """Vertices in the order in which a search visits them that always goes on from the latest, and its tree.

    Of the neighbours not yet visited the smallest comes next. O(n + m), at any depth.

    Returns
    -------
    order : (k,) the vertices that can be reached, ``source`` first.
    before : (n,) the vertex from which each was visited; −1 for the source and unreachable vertices.

    Raises
    ------
    IndexError
        ``source`` is not a vertex.

    >>> depth_first(Graph.from_edges(4, [(0, 1), (1, 2), (0, 2)]), 0)[0].tolist()
    [0, 1, 2]
    """
    source = check_vertex(graph, source)
    return _kernels.depth_first(graph.indptr, graph.indices, source)


def path_to(before: Ints, target: int) -> list[int]:
    """Vertices from the root of a shortest-path tree to ``target``."""
    path = [target]
    while before[path[-1]] >= 0:
        path.append(int(before[path[-1]]))
    return path[::-1]


def check_vertex(graph: Graph, vertex: int) -> int:
    """Return ``vertex`` as a plain int, so that kernels see one type.

    Raises
    ------
    IndexError
        It is not a vertex of the graph.
    """
    if graph.n == 0:
        raise IndexError(f"vertex {vertex} is not in a graph without vertices")
    if not 0 <= vertex < graph.n:
        raise IndexError(f"vertex {vertex} is not one of 0 … {graph.n - 1}")
    return index(vertex)
