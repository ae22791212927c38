"""Connectedness: the components of a graph, and the edges and vertices whose loss makes more of them.

Only edges of positive weight connect.
"""

from __future__ import annotations

import numpy as np
from scipy import sparse

from taut.graph import _structure_kernels
from taut.graph.core import Graph, Ints


def components(graph: Graph) -> Ints:
    """(n,) the component of each vertex, counted from 0 in the order of their first vertices.

    >>> components(Graph.from_edges(4, [(0, 2), (1, 3)])).tolist()
    [0, 1, 0, 1]
    """
    indptr, indices = _connecting(graph)
    links = sparse.csr_array((np.ones(len(indices), np.int8), indices, indptr), shape=(graph.n, graph.n))
    labels = sparse.csgraph.connected_components(links, directed=False)[1]
    _, first, component = np.unique(labels, return_index=True, return_inverse=True)
    place = np.empty(len(first), dtype=np.int64)
    place[np.argsort(first)] = np.arange(len(first))
    return place[component]


def connected(graph: Graph) -> bool:
    """Whether there is at most one component; so are graphs of one vertex and of none.

    >>> connected(Graph.from_edges(3, [(0, 1)]))
    False
    """
    return not components(graph).any()


def cut_edges(graph: Graph) -> Ints:
    """(k, 2) edges i < j, sorted, each of which alone holds two parts of its component together (bridges).

    >>> cut_edges(Graph.from_edges(4, [(0, 1), (0, 2), (1, 2), (2, 3)])).tolist()
    [[2, 3]]
    """
    indptr, indices = _connecting(graph)
    marked, _ = _structure_kernels.cuts(indptr, indices)
    tail = np.repeat(np.arange(graph.n), np.diff(indptr))[marked]
    pairs = np.sort(np.stack([tail, indices[marked]], axis=1), axis=1)
    return pairs[np.lexsort((pairs[:, 1], pairs[:, 0]))]


def cut_vertices(graph: Graph) -> Ints:
    """(k,) vertices, ascending, each of which alone holds parts of its component together (articulation points).

    >>> cut_vertices(Graph.from_edges(4, [(0, 1), (0, 2), (1, 2), (2, 3)])).tolist()
    [2]
    """
    _, marked = _structure_kernels.cuts(*_connecting(graph))
    return np.flatnonzero(marked)


def _connecting(graph: Graph) -> tuple[Ints, Ints]:
    """Return the CSR structure of the edges of positive weight."""
    positive = graph.weights > 0
    before = np.concatenate([[0], np.cumsum(positive)])
    return before[graph.indptr], graph.indices[positive]
