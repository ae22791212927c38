"""The matrices of a graph: adjacency, degree, incidence, Laplacian; and the densities read off them."""

from __future__ import annotations

from typing import TypeAlias

import numpy as np
from scipy import sparse

from taut.graph.core import Floats, Graph

Matrix: TypeAlias = "sparse.csr_array[np.float64, tuple[int, int]]"


def adjacency(graph: Graph) -> Matrix:
    """(n, n) matrix of the weights: symmetric, zero on the diagonal.

    >>> adjacency(Graph.from_edges(2, [(0, 1)], [3.0])).toarray().tolist()
    [[0.0, 3.0], [3.0, 0.0]]
    """
    return sparse.csr_array((graph.weights, graph.indices, graph.indptr), shape=(graph.n, graph.n), copy=True)


def degrees(graph: Graph) -> Floats:
    """(n,) weighted degrees: the sum of the weights at each vertex.

    Raises
    ------
    ValueError
        A sum is larger than a float64 holds.

    >>> degrees(Graph.from_edges(3, [(0, 1), (1, 2)], [1.0, 2.0])).tolist()
    [1.0, 3.0, 2.0]
    """
    tail = np.repeat(np.arange(graph.n), np.diff(graph.indptr))
    sums = np.asarray(np.bincount(tail, weights=graph.weights, minlength=graph.n), dtype=np.float64)
    if not np.isfinite(sums).all():
        raise ValueError(f"the weights at vertex {int(np.argmin(np.isfinite(sums)))} sum to infinity: scale them down")
    return sums


def degree(graph: Graph) -> Matrix:
    """(n, n) diagonal matrix of the weighted degrees."""
    return _diagonal(degrees(graph))


def incidence(graph: Graph) -> Matrix:
    """(n, m) matrix B of the edges, each directed from its smaller to its larger vertex.

    The column of an edge, in the order of `Graph.edges`, holds −1 at the tail and +1 at the head (thesis (8.1)). With
    the diagonal matrix W of the weights, B W Bᵀ is the Laplacian.

    >>> incidence(Graph.from_edges(3, [(0, 1), (1, 2)])).toarray().tolist()
    [[-1.0, 0.0], [1.0, -1.0], [0.0, 1.0]]
    """
    ends = graph.edges
    columns = np.repeat(np.arange(graph.m), 2)
    signs = np.tile([-1.0, 1.0], graph.m)
    return sparse.csr_array((signs, (ends.ravel(), columns)), shape=(graph.n, graph.m))


def laplacian(graph: Graph) -> Matrix:
    """(n, n) Laplacian L = D − A: symmetric, positive semidefinite, with rows that sum to zero.

    >>> laplacian(Graph.from_edges(2, [(0, 1)], [3.0])).toarray().tolist()
    [[3.0, -3.0], [-3.0, 3.0]]
    """
    return sparse.csr_array(degree(graph) - adjacency(graph))


def normalised_laplacian(graph: Graph) -> Matrix:
    """(n, n) matrix D^(−1/2) L D^(−1/2); the rows and columns of vertices of degree zero are zero."""
    sums = degrees(graph)
    joined = sums > 0
    roots = np.sqrt(np.where(joined, sums, 1.0))
    tail = np.repeat(np.arange(graph.n), np.diff(graph.indptr))
    shares = graph.weights / roots[tail] / roots[graph.indices]
    scaled = sparse.csr_array((shares, graph.indices, graph.indptr), shape=(graph.n, graph.n))
    return sparse.csr_array(_diagonal(joined.astype(np.float64)) - scaled)


def beta_index(graph: Graph) -> float:
    """Edges per vertex, m / n (thesis 8.4.1).

    Raises
    ------
    ValueError
        The graph has no vertices.

    >>> beta_index(Graph.from_edges(5, [(0, 1), (1, 2), (2, 3), (3, 4)]))
    0.8
    """
    if graph.n == 0:
        raise ValueError("a graph without vertices has no Beta index")
    return graph.m / graph.n


def _diagonal(values: Floats) -> Matrix:
    n = len(values)
    return sparse.csr_array((values, np.arange(n), np.arange(n + 1)), shape=(n, n))
