"""Kernels of widest ways: the best bottleneck on a graph, then the shortest way among those that have it."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from taut.arrays import longer
from taut.compiling import kernel
from taut.heap import drop_first, push

Floats = NDArray[np.float64]
Ints = NDArray[np.int64]


@kernel
def bottleneck(
    indptr: Ints, indices: Ints, rooms: Floats, first: Ints, first_rooms: Floats, last: Ints, last_rooms: Floats
) -> float:
    """Greatest least room on a way between two places off a graph; −1 where there is no way.

    Parameters
    ----------
    rooms : (2 m,) room ≥ 0 of each entry of the graph.
    first, first_rooms : (k,) the vertices joined with the one place and the room of these joins.
    last, last_rooms : (l,) those of the other place.
    """
    n = indptr.shape[0] - 1
    room = np.full(n, -1.0)
    end = np.full(n, -1.0)
    for i in range(last.shape[0]):
        end[last[i]] = last_rooms[i]
    keys = np.empty(indices.shape[0] + first.shape[0])
    items = np.empty(keys.shape[0], dtype=np.int64)
    size = 0
    for i in range(first.shape[0]):
        room[first[i]] = first_rooms[i]
        push(keys, items, size, -first_rooms[i], first[i])
        size += 1
    best = -1.0
    while size > 0:
        u, key = items[0], -keys[0]
        drop_first(keys, items, size)
        size -= 1
        if key <= best:
            break
        if key < room[u]:
            continue
        best = max(best, min(key, end[u]))
        for k in range(indptr[u], indptr[u + 1]):
            v = indices[k]
            through = min(key, rooms[k])
            if through > room[v]:
                room[v] = through
                push(keys, items, size, -through, v)
                size += 1
    return best


@kernel
def shortest_with_room(
    indptr: Ints,
    indices: Ints,
    weights: Floats,
    rooms: Floats,
    first: Ints,
    first_weights: Floats,
    first_rooms: Floats,
    last: Ints,
    last_weights: Floats,
    last_rooms: Floats,
    least: float,
) -> tuple[float, Ints]:
    """Length and vertices, in turn, of a shortest way of joins and edges that have the least room; inf without one."""
    n = indptr.shape[0] - 1
    distance = np.full(n, np.inf)
    before = np.full(n, -1, dtype=np.int64)
    end = np.full(n, np.inf)
    for i in range(last.shape[0]):
        if last_rooms[i] >= least:
            end[last[i]] = last_weights[i]
    keys = np.empty(indices.shape[0] + first.shape[0])
    items = np.empty(keys.shape[0], dtype=np.int64)
    size = 0
    for i in range(first.shape[0]):
        if first_rooms[i] >= least:
            distance[first[i]] = first_weights[i]
            push(keys, items, size, first_weights[i], first[i])
            size += 1
    best, target = np.inf, -1
    while size > 0:
        u, key = items[0], keys[0]
        drop_first(keys, items, size)
        size -= 1
        if key >= best:
            break
        if key > distance[u]:
            continue
        if key + end[u] < best:
            best, target = key + end[u], u
        for k in range(indptr[u], indptr[u + 1]):
            v = indices[k]
            through = key + weights[k]
            if rooms[k] >= least and through < distance[v]:
                distance[v] = through
                before[v] = u
                push(keys, items, size, through, v)
                size += 1
    path = np.empty(64, dtype=np.int64)
    count = 0
    while target >= 0:
        if count == path.shape[0]:
            path = longer(path)
        path[count] = target
        count += 1
        target = before[target]
    return best, path[:count][::-1].copy()
