"""Spanning trees: the lightest, the heaviest, and how many there are.

In a tree weights are lengths, so every edge takes part, also one of length 0. Counting is Kirchhoff's, where only
edges of positive weight connect.
"""

from __future__ import annotations

import math
from collections.abc import Iterator

import numpy as np
from numpy.typing import NDArray

from taut.compiling import kernel
from taut.graph.components import connected
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
        rest = _pivot_product(done.start, done.columns, ones, prime)
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
    kept = np.sort(order[_joining(graph.n, edges[order])])
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


@kernel
def _joining(n: int, edges: Ints) -> NDArray[np.bool_]:
    """Mark each edge whose ends the edges before it do not join (union-find, paths halved)."""
    above = np.arange(n)
    joins = np.zeros(edges.shape[0], dtype=np.bool_)
    for e in range(edges.shape[0]):
        u, v = edges[e, 0], edges[e, 1]
        while above[u] != u:
            above[u] = above[above[u]]
            u = above[u]
        while above[v] != v:
            above[v] = above[above[v]]
            v = above[v]
        if u != v:
            above[v] = u
            joins[e] = True
    return joins


@kernel
def _pivot_product(start: Ints, columns: Ints, weights: Ints, prime: int) -> int:
    """Product of all pivots but the last one, modulo a prime; −1 if the prime divides one of them.

    The elimination of `taut.graph.resistance`, where division by a pivot is multiplication by its inverse.
    """
    n = start.shape[0] - 1
    values = weights.copy()
    row = np.zeros(n, dtype=np.int64)
    first = np.full(n, -1, dtype=np.int64)
    following = np.full(n, -1, dtype=np.int64)
    at = np.zeros(n, dtype=np.int64)
    inverses = np.zeros(n, dtype=np.int64)
    inverse = 1.0 / prime
    product = 1
    for k in range(n - 1):
        for e in range(start[k], start[k + 1]):
            row[columns[e]] = values[e]
        i = first[k]
        while i >= 0:
            after = following[i]
            a = at[i]
            factor = values[a] * inverses[i] % prime
            for b in range(a + 1, start[i + 1]):
                row[columns[b]] = _residue(row[columns[b]] + factor * values[b], prime, inverse)
            if a + 1 < start[i + 1]:
                at[i] = a + 1
                following[i] = first[columns[a + 1]]
                first[columns[a + 1]] = i
            i = after
        pivot = 0
        for e in range(start[k], start[k + 1]):
            values[e] = row[columns[e]]
            pivot = (pivot + values[e]) % prime
        if pivot == 0:
            return -1
        product = product * pivot % prime
        inverses[k] = _inverse(pivot, prime)
        at[k] = start[k]
        following[k] = first[columns[start[k]]]
        first[columns[start[k]]] = k
    return product


@kernel
def _residue(value: int, prime: int, inverse: float) -> int:
    """Value modulo a prime, for 0 ≤ value < 2⁶³: several times as fast as the processor's division."""
    rest = value - int(value * inverse) * prime  # the quotient is at most 1 off
    if rest < 0:
        return rest + prime
    return rest - prime if rest >= prime else rest


@kernel
def _inverse(value: int, prime: int) -> int:
    """value^(prime − 2), by Fermat's theorem the inverse of the value."""
    power, result, exponent = value, 1, prime - 2
    while exponent > 0:
        if exponent & 1:
            result = result * power % prime
        power = power * power % prime
        exponent >>= 1
    return result
