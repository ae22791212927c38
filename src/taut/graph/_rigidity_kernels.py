"""Kernels of rigidity in the plane: the pebble game, and whether a graph holds together without one of its vertices."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from taut.compiling import kernel

Ints = NDArray[np.int64]
Bools = NDArray[np.bool_]


@kernel
def pebble_game(n: int, edges: Ints) -> tuple[Bools, Bools]:
    """Which edges are independent of those before them, and which lie in a circuit of the rigidity matroid.

    Every vertex owns two pebbles; an independent edge is covered by a pebble of one of its ends. A new edge is
    independent iff four pebbles can be freed at its ends. Where only three can, the vertices reached in the attempt
    span exactly the smallest rigid part that holds both ends, so its edges and the new one are a circuit.
    """
    m = edges.shape[0]
    independent = np.zeros(m, dtype=np.bool_)
    in_circuit = np.zeros(m, dtype=np.bool_)
    covered = np.full((n, 2), -1, dtype=np.int64)
    came = np.empty(n, dtype=np.int64)
    seen = np.full(n, -1, dtype=np.int64)
    queue = np.empty(n, dtype=np.int64)
    search = rank = bound = 0
    for new in range(m):
        if rank == 2 * n - 3 and bound == rank:  # all that follow are in circuits, and add no other edge to one
            in_circuit[new] = True
            continue
        u, v = edges[new]
        reached = 0
        while reached == 0 and _free(covered, u) + _free(covered, v) < 4:
            reached = _free_a_pebble(edges, covered, u, v, came, seen, queue, search)
            search += 1
        if reached == 0:
            _cover(covered, u, new)
            independent[new] = True
            rank += 1
            continue
        in_circuit[new] = True
        for x in queue[:reached]:
            for edge in covered[x]:
                if edge >= 0 and not in_circuit[edge]:
                    in_circuit[edge] = True
                    bound += 1
    return independent, in_circuit


@kernel
def _free_a_pebble(edges: Ints, covered: Ints, u: int, v: int, came: Ints, seen: Ints, queue: Ints, search: int) -> int:
    """Bring one more free pebble to u or v and return 0; else the number of vertices reached, the first in the queue.

    Edges lead from the vertex whose pebble covers them to their other end. A way from u or v to a free pebble is
    turned round edge by edge: each is then covered from its other end.
    """
    queue[0], queue[1] = u, v
    came[u], came[v] = -1, -1
    seen[u], seen[v] = search, search
    head, tail = 0, 2
    while head < tail:
        x = queue[head]
        head += 1
        for edge in covered[x]:
            if edge < 0:
                continue
            y = edges[edge, 0] + edges[edge, 1] - x
            if seen[y] == search:
                continue
            seen[y], came[y] = search, edge
            if _free(covered, y) > 0:
                while came[y] >= 0:
                    edge = came[y]
                    _cover(covered, y, edge)
                    y = edges[edge, 0] + edges[edge, 1] - y
                    covered[y, 0 if covered[y, 0] == edge else 1] = -1
                return 0
            queue[tail] = y
            tail += 1
    return tail


@kernel
def _free(covered: Ints, vertex: int) -> int:
    """Return the number of pebbles of a vertex that cover no edge."""
    return int(covered[vertex, 0] < 0) + int(covered[vertex, 1] < 0)


@kernel
def _cover(covered: Ints, vertex: int, edge: int) -> None:
    """Lay a free pebble of the vertex on the edge."""
    covered[vertex, 0 if covered[vertex, 0] < 0 else 1] = edge


@kernel
def hold(indptr: Ints, indices: Ints, without: int) -> int:
    """How a graph of two or more vertices holds together without one of them (−1: with all).

    0: not connected; 1: connected, with a cut vertex; 2: connected, without. By depth-first search with low points
    (Hopcroft and Tarjan 1973).
    """
    n = indptr.shape[0] - 1
    depth = np.full(n, -1, dtype=np.int64)
    low = np.empty(n, dtype=np.int64)
    before = np.full(n, -1, dtype=np.int64)
    following = indptr[:-1].copy()
    root = 1 if without == 0 else 0
    depth[root] = low[root] = 0
    visited, children, cut = 1, 0, False
    v = root
    while v >= 0:
        if following[v] < indptr[v + 1]:
            w = indices[following[v]]
            following[v] += 1
            if w == without or w == before[v]:
                continue
            if depth[w] >= 0:
                low[v] = min(low[v], depth[w])
                continue
            depth[w] = low[w] = depth[v] + 1
            before[w] = v
            visited += 1
            v = w
            continue
        parent = before[v]
        if parent == root:
            children += 1
        elif parent >= 0:
            cut = cut or low[v] >= depth[parent]
            low[parent] = min(low[parent], low[v])
        v = parent
    if visited < n - int(without >= 0):
        return 0
    return 1 if cut or children > 1 else 2
