"""Spanning trees: the lightest, the heaviest, and how many there are.

In a tree weights are lengths, so every edge takes part, also one of length 0. Counting is Kirchhoff's, where only
edges of positive weight connect.
"""

from __future__ import annotations

import math
from collections.abc import Iterator

import numpy as np

from taut.graph import _elimination_kernels, _structure_kernels
from taut.graph.connectedness import connected
from taut.graph.core import Graph, Ints
from taut.graph.resistance import Elimination, eliminate


def spanning_tree(graph: Graph) -> Graph:
    """Spanning tree of least total weight; of a disconnected graph, such a tree of each component.

    Among equal weights the edge that comes first in `Graph.edges` is preferred, so there is one answer.

    Notes
    -----
    Kruskal 1956: time m log m.

    >>> spanning_tree(Graph.from_edges(3, [(0, 1), (1, 2), (0, 2)], [3.0, 0.0, 1.0])).edges.tolist()
    [[0, 2], [1, 2]]
    """
    return _grown(graph, np.argsort(graph.lengths, kind="stable"))


def maximum_spanning_tree(graph: Graph) -> Graph:
    """Spanning tree of greatest total weight; otherwise as `spanning_tree`.

    Its lightest edge on the way between two vertices is the best that any path between them has to offer.

    >>> maximum_spanning_tree(Graph.from_edges(3, [(0, 1), (1, 2), (0, 2)], [3.0, 0.0, 1.0])).edges.tolist()
    [[0, 1], [0, 2]]
    """
    return _grown(graph, np.argsort(-graph.lengths, kind="stable"))


def spanning_tree_count(graph: Graph) -> int:
    """Exact number of different spanning trees made of edges of positive weight; weights otherwise do not matter.

    0 for a disconnected graph and for one without vertices, 1 for a single vertex.

    Notes
    -----
    Kirchhoff 1847: the product of the pivots of the Laplacian, found modulo as many primes as it takes to tell it from
    every number up to the product of the degrees. Time: number of digits times that of a sparse elimination, a few
    tenths of a second for a map of 1,000 vertices; see `log_spanning_tree_count` for more.

    >>> spanning_tree_count(Graph.from_edges(4, [(0, 1), (1, 2), (2, 3), (0, 3)]))
    4
    """
    if graph.n == 0 or not connected(graph):
        return 0
    joined = _unweighted(graph)
    done = eliminate(joined)
    ones = _on_pattern(joined, done)
    # Hadamard: no minor of a positive definite matrix exceeds the product of its diagonal
    most = math.prod(np.diff(joined.indptr)[done.order[:-1]].tolist())
    count, modulus, primes = 0, 1, _primes()
    while modulus <= most:
        prime = next(primes)
        rest = _elimination_kernels.pivot_product(done.start, done.columns, ones, prime)
        if rest >= 0:
            count += modulus * ((rest - count) * pow(modulus, -1, prime) % prime)
            modulus *= prime
    return count


def log_spanning_tree_count(graph: Graph) -> float:
    """Natural logarithm of `spanning_tree_count`, also of very large graphs; −inf where there is none.

    Notes
    -----
    A sparse elimination without cancellation: error a few ulps of n log n.

    >>> round(log_spanning_tree_count(Graph.from_edges(4, [(0, 1), (1, 2), (2, 3), (0, 3)])) / math.log(2), 12)
    2.0
    """
    if graph.n == 0 or not connected(graph):
        return -math.inf
    pivots = eliminate(_unweighted(graph)).pivots
    return math.fsum(np.log(pivots[:-1]).tolist())


def _unweighted(graph: Graph) -> Graph:
    """Return the edges of positive weight with weight 1."""
    return Graph.from_edges(graph.n, graph.edges[graph.lengths > 0])


def _grown(graph: Graph, order: Ints) -> Graph:
    """Forest of the edges, taken in this order, that close no cycle."""
    edges = graph.edges
    kept = np.sort(order[_structure_kernels.joining(graph.n, edges[order])])
    return Graph.from_edges(graph.n, edges[kept], graph.lengths[kept])


def _on_pattern(graph: Graph, done: Elimination) -> Ints:
    """1 where an entry of the elimination is an edge of the graph, 0 where it is fill, (fill,)."""
    row = np.repeat(np.arange(graph.n), np.diff(done.start))
    first, second = np.sort(done.rank[graph.edges], axis=1).T
    return np.isin(row * graph.n + done.columns, first * graph.n + second).astype(np.int64)


def _primes() -> Iterator[int]:
    """Primes below 2³¹, the largest first."""
    small = [q for q in range(3, 46341, 2) if all(q % d for d in range(3, math.isqrt(q) + 1, 2))]
    divisors = np.array(small)
    for candidate in range(2**31 - 1, 46341, -2):
        if (candidate % divisors).all():
            yield candidate
