"""Kernels of connectedness: the edges and vertices whose loss cuts a graph, and the edges that join it."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from taut.compiling import kernel

Bools = NDArray[np.bool_]
Ints = NDArray[np.int64]


@kernel
def cuts(indptr: Ints, indices: Ints) -> tuple[Bools, Bools]:
    """Which entries of ``indices`` are cut edges, each marked in the row nearer the root, and which vertices cut.

    Depth-first search with the earliest vertex that each subtree reaches back to (Tarjan 1972), without recursion.
    """
    n = indptr.shape[0] - 1
    cut_edge = np.zeros(indices.shape[0], dtype=np.bool_)
    cut_vertex = np.zeros(n, dtype=np.bool_)
    found = np.full(n, -1, dtype=np.int64)  # place in the order of discovery
    reach = np.empty(n, dtype=np.int64)  # earliest place that the subtree touches
    parent = np.full(n, -1, dtype=np.int64)
    following = indptr[:-1].copy()  # entry to look at next; the one before it led to the child being searched
    count = 0
    for root in range(n):
        if found[root] >= 0:
            continue
        found[root] = reach[root] = count
        count += 1
        branches = 0
        u = root
        while u >= 0:
            if following[u] < indptr[u + 1]:
                v = indices[following[u]]
                following[u] += 1
                if found[v] < 0:
                    found[v] = reach[v] = count
                    count += 1
                    parent[v] = u
                    u = v
                elif v != parent[u]:
                    reach[u] = min(reach[u], found[v])
                continue
            above = parent[u]
            if above >= 0:
                reach[above] = min(reach[above], reach[u])
                cut_edge[following[above] - 1] = reach[u] > found[above]
                if above == root:
                    branches += 1
                elif reach[u] >= found[above]:
                    cut_vertex[above] = True
            u = above
        cut_vertex[root] = branches > 1
    return cut_edge, cut_vertex


@kernel
def joining(n: int, edges: Ints) -> NDArray[np.bool_]:
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
