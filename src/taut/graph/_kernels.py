"""Kernels of graph search on CSR arrays, with a binary heap in plain arrays."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from taut.compiling import kernel

Floats = NDArray[np.float64]
Ints = NDArray[np.int64]


@kernel
def _heap_push(keys: Floats, items: Ints, size: int, key: float, item: int) -> None:
    """Insert into the heap of the given size; ties are served by the smaller item, so that results are unique."""
    i = size
    while i > 0:
        parent = (i - 1) >> 1
        if keys[parent] < key or (keys[parent] == key and items[parent] <= item):
            break
        keys[i], items[i] = keys[parent], items[parent]
        i = parent
    keys[i], items[i] = key, item


@kernel
def _heap_drop_first(keys: Floats, items: Ints, size: int) -> None:
    """Remove the first of ``size`` entries."""
    last = size - 1
    key, item = keys[last], items[last]
    i = 0
    while True:
        child = 2 * i + 1
        if child >= last:
            break
        right = child + 1
        if right < last and (keys[right] < keys[child] or (keys[right] == keys[child] and items[right] < items[child])):
            child = right
        if key < keys[child] or (key == keys[child] and item <= items[child]):
            break
        keys[i], items[i] = keys[child], items[child]
        i = child
    keys[i], items[i] = key, item


@kernel
def dijkstra(indptr: Ints, indices: Ints, weights: Floats, source: int) -> tuple[Floats, Ints]:
    """Distances from one vertex (inf where there is no path) and the vertex before each on a shortest path (−1)."""
    n = indptr.shape[0] - 1
    distance = np.full(n, np.inf)
    before = np.full(n, -1, dtype=np.int64)
    done = np.zeros(n, dtype=np.bool_)
    keys = np.empty(indices.shape[0] + 1)
    items = np.empty(indices.shape[0] + 1, dtype=np.int64)
    distance[source] = 0.0
    keys[0], items[0] = 0.0, source
    size = 1
    while size > 0:
        u = items[0]
        _heap_drop_first(keys, items, size)
        size -= 1
        if done[u]:
            continue
        done[u] = True
        for k in range(indptr[u], indptr[u + 1]):
            v = indices[k]
            through = distance[u] + weights[k]
            if through < distance[v]:
                distance[v] = through
                before[v] = u
                _heap_push(keys, items, size, through, v)
                size += 1
    return distance, before


@kernel
def astar(
    indptr: Ints,
    indices: Ints,
    weights: Floats,
    positions: Floats,
    source: Floats,
    first: Ints,
    target: Floats,
    last: Ints,
) -> tuple[float, Ints]:
    """Length and vertices of a shortest path between two places off the graph (inf, empty if none).

    ``first`` are the vertices joined straight with the place ``source``, ``last`` those joined with ``target``. Weights
    must be at least the Euclidean distances.
    """
    n = indptr.shape[0] - 1
    distance = np.full(n + 1, np.inf)
    before = np.full(n + 1, -1, dtype=np.int64)
    done = np.zeros(n + 1, dtype=np.bool_)
    ends = np.zeros(n, dtype=np.bool_)
    for v in last:
        ends[v] = True
    keys = np.empty(first.shape[0] + indices.shape[0] + last.shape[0] + 1)
    items = np.empty(keys.shape[0], dtype=np.int64)
    size = 0
    tx, ty = target[0], target[1]
    for v in first:
        distance[v] = np.sqrt((positions[v, 0] - source[0]) ** 2 + (positions[v, 1] - source[1]) ** 2)
        estimate = np.sqrt((positions[v, 0] - tx) ** 2 + (positions[v, 1] - ty) ** 2)
        _heap_push(keys, items, size, distance[v] + estimate, v)
        size += 1
    while size > 0:
        u = items[0]
        _heap_drop_first(keys, items, size)
        size -= 1
        if u == n:
            break
        if done[u]:
            continue
        done[u] = True
        if ends[u]:
            through = distance[u] + np.sqrt((positions[u, 0] - tx) ** 2 + (positions[u, 1] - ty) ** 2)
            if through < distance[n]:
                distance[n] = through
                before[n] = u
                _heap_push(keys, items, size, through, n)
                size += 1
        for k in range(indptr[u], indptr[u + 1]):
            v = indices[k]
            through = distance[u] + weights[k]
            if through < distance[v] and not done[v]:
                distance[v] = through
                before[v] = u
                estimate = np.sqrt((positions[v, 0] - tx) ** 2 + (positions[v, 1] - ty) ** 2)
                _heap_push(keys, items, size, through + estimate, v)
                size += 1
    if not np.isfinite(distance[n]):
        return np.inf, np.empty(0, dtype=np.int64)
    count = 0
    v = before[n]
    while v >= 0:
        count += 1
        v = before[v]
    path = np.empty(count, dtype=np.int64)
    v = before[n]
    for i in range(count - 1, -1, -1):
        path[i] = v
        v = before[v]
    return distance[n], path


@kernel
def breadth_first(indptr: Ints, indices: Ints, source: int) -> tuple[Ints, Ints]:
    """Edges on a way with fewest of them (−1 where there is none) and the vertex that saw each first (−1)."""
    n = indptr.shape[0] - 1
    hops = np.full(n, -1, dtype=np.int64)
    before = np.full(n, -1, dtype=np.int64)
    queue = np.empty(n, dtype=np.int64)
    hops[source] = 0
    queue[0] = source
    visited, seen = 0, 1
    while visited < seen:
        u = queue[visited]
        visited += 1
        for k in range(indptr[u], indptr[u + 1]):
            v = indices[k]
            if hops[v] < 0:
                hops[v] = hops[u] + 1
                before[v] = u
                queue[seen] = v
                seen += 1
    return hops, before


@kernel
def depth_first(indptr: Ints, indices: Ints, source: int) -> tuple[Ints, Ints]:
    """Vertices in the order visited and the vertex from which each was visited (−1)."""
    n = indptr.shape[0] - 1
    order = np.empty(n, dtype=np.int64)
    before = np.full(n, -1, dtype=np.int64)
    visited = np.zeros(n, dtype=np.bool_)
    upcoming = indptr[:n].copy()  # where each vertex goes on looking among its neighbours
    visited[source] = True
    order[0] = source
    count = 1
    u = source
    while u >= 0:
        k = upcoming[u]
        if k == indptr[u + 1]:
            u = before[u]  # the tree itself remembers the way back: no stack is needed
            continue
        upcoming[u] = k + 1
        v = indices[k]
        if not visited[v]:
            visited[v] = True
            before[v] = u
            order[count] = v
            count += 1
            u = v
    return order[:count].copy(), before
