"""Kernels of graph search on CSR arrays, with a binary heap in plain arrays."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from taut.arrays import longer
from taut.compiling import kernel
from taut.heap import drop_first, push

Floats = NDArray[np.float64]
Ints = NDArray[np.int64]


@kernel
def compressed(n: int, pairs: Ints, values: Floats) -> tuple[Ints, Ints, Floats, int]:
    """CSR of undirected edges (m, 2) with rows ascending; last, a vertex with a neighbour given twice, or −1.

    Two stable counting sorts: by the far end, then by the near one.
    """
    m = pairs.shape[0]
    indptr = np.zeros(n + 1, dtype=np.int64)
    for e in range(m):
        indptr[pairs[e, 0] + 1] += 1
        indptr[pairs[e, 1] + 1] += 1
    for v in range(n):
        indptr[v + 1] += indptr[v]
    place = indptr.copy()
    tails = np.empty(2 * m, dtype=np.int64)
    edges = np.empty(2 * m, dtype=np.int64)
    for e in range(m):
        for side in range(2):
            head = pairs[e, 1 - side]
            tails[place[head]], edges[place[head]] = pairs[e, side], e
            place[head] += 1
    for v in range(n):
        place[v] = indptr[v]
    indices = np.empty(2 * m, dtype=np.int64)
    weights = np.empty(2 * m)
    twice = -1
    for head in range(n):
        for k in range(indptr[head], indptr[head + 1]):
            tail = tails[k]
            at = place[tail]
            if at > indptr[tail] and indices[at - 1] == head:
                twice = tail
            indices[at], weights[at] = head, values[edges[k]]
            place[tail] += 1
    return indptr, indices, weights, twice


@kernel
def dijkstra(indptr: Ints, indices: Ints, weights: Floats, sources: Ints, offsets: Floats) -> tuple[Floats, Ints]:
    """Distances from the nearest of some vertices, each begun with an offset ≥ 0, and the vertex before each (−1).

    inf where there is no path.
    """
    n = indptr.shape[0] - 1
    distance = np.full(n, np.inf)
    before = np.full(n, -1, dtype=np.int64)
    done = np.zeros(n, dtype=np.bool_)
    keys = np.empty(indices.shape[0] + sources.shape[0])
    items = np.empty(keys.shape[0], dtype=np.int64)
    size = 0
    for i in range(sources.shape[0]):
        if offsets[i] < distance[sources[i]]:
            distance[sources[i]] = offsets[i]
            push(keys, items, size, offsets[i], sources[i])
            size += 1
    while size > 0:
        u = items[0]
        drop_first(keys, items, size)
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
                push(keys, items, size, through, v)
                size += 1
    return distance, before


@kernel
def astar(
    indptr: Ints,
    indices: Ints,
    weights: Floats,
    positions: Floats,
    sources: Floats,
    first_start: Ints,
    first: Ints,
    targets: Floats,
    last_start: Ints,
    last: Ints,
) -> tuple[Floats, Ints, Ints]:
    """Shortest paths between places off the graph, k queries: lengths, and the vertices passed as CSR (start, path).

    ``first[first_start[q]:first_start[q + 1]]`` are the vertices joined straight with the place ``sources[q]``, and
    ``last`` those joined with ``targets[q]``. Weights must be at least the Euclidean distances. Without a path inf.
    """
    n = indptr.shape[0] - 1
    count = sources.shape[0]
    lengths = np.full(count, np.inf)
    path_start = np.zeros(count + 1, dtype=np.int64)
    path = np.empty(16 * count + 1, dtype=np.int64)
    filled = 0
    distance = np.empty(n + 1)
    before = np.empty(n + 1, dtype=np.int64)
    # what belongs to the query at hand: 2 q + 1 once a vertex is seen, 2 q + 2 once it is done
    state = np.zeros(n + 1, dtype=np.int64)
    ends = np.full(n, -1, dtype=np.int64)
    keys = np.empty(256)
    items = np.empty(256, dtype=np.int64)
    for q in range(count):
        seen, done = 2 * q + 1, 2 * q + 2
        tx, ty = targets[q, 0], targets[q, 1]
        for k in range(last_start[q], last_start[q + 1]):
            ends[last[k]] = q
        size = 0
        for k in range(first_start[q], first_start[q + 1]):
            v = first[k]
            x, y = positions[v, 0], positions[v, 1]
            distance[v] = np.sqrt((x - sources[q, 0]) ** 2 + (y - sources[q, 1]) ** 2)
            before[v] = -1
            state[v] = seen
            if size == keys.shape[0]:
                keys, items = longer(keys), longer(items)
            push(keys, items, size, distance[v] + np.sqrt((x - tx) ** 2 + (y - ty) ** 2), v)
            size += 1
        while size > 0:
            u = items[0]
            drop_first(keys, items, size)
            size -= 1
            if state[u] == done:
                continue
            state[u] = done
            if u == n:
                break
            if ends[u] == q:
                through = distance[u] + np.sqrt((positions[u, 0] - tx) ** 2 + (positions[u, 1] - ty) ** 2)
                if state[n] < seen or through < distance[n]:
                    distance[n], before[n], state[n] = through, u, seen
                    if size == keys.shape[0]:
                        keys, items = longer(keys), longer(items)
                    push(keys, items, size, through, n)
                    size += 1
            # what cannot beat the way to the target known so far is not followed
            bound = distance[n] if state[n] == seen else np.inf
            for k in range(indptr[u], indptr[u + 1]):
                v = indices[k]
                if state[v] == done:
                    continue
                through = distance[u] + weights[k]
                if state[v] < seen or through < distance[v]:
                    estimate = np.sqrt((positions[v, 0] - tx) ** 2 + (positions[v, 1] - ty) ** 2)
                    if through + estimate >= bound:
                        continue
                    distance[v], before[v], state[v] = through, u, seen
                    if size == keys.shape[0]:
                        keys, items = longer(keys), longer(items)
                    push(keys, items, size, through + estimate, v)
                    size += 1
        if state[n] == done:
            lengths[q] = distance[n]
            steps = 0
            v = before[n]
            while v >= 0:
                steps += 1
                v = before[v]
            while filled + steps > path.shape[0]:
                path = longer(path)
            v = before[n]
            for i in range(filled + steps - 1, filled - 1, -1):
                path[i] = v
                v = before[v]
            filled += steps
        path_start[q + 1] = filled
    return lengths, path_start, path[:filled].copy()


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
