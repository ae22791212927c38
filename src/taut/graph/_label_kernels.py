"""Kernels of hub labels: trees that tell which vertices matter, searches that make labels, and queries that merge them.

Entries of labels are packed in 16 bytes: hubs and following vertices have 32 bits. Vertices of the searches that make
labels are ranks: 0 is the most important, and a path belongs to the least number on it.

Queries read hubs as unsigned and walk over slices: so no index can be negative, and without a test for that in every
step the loops become vector instructions.
"""

from __future__ import annotations

from typing import TypeVar

import numpy as np
from numpy.typing import NDArray

from taut.compiling import kernel
from taut.heap import drop_first, push

Floats = NDArray[np.float64]
Ints = NDArray[np.int64]
Ints32 = NDArray[np.int32]
Hubs = NDArray[np.uint32]
_Array = TypeVar("_Array", Ints, Ints32, Floats)

UNCOVERED, COVERED, SETTLED = 0, 1, 2
BLOCK = 32  # entries that are looked at together; most blocks hold nothing better


@kernel
def grow_trees(
    indptr: Ints,
    indices: Ints,
    weights: Floats,
    roots: Ints,
    parent: Ints32,
    below: Ints32,
    child: Ints32,
    sibling: Ints32,
) -> None:
    """Fill a row of the four arrays, (k, n), with the shortest-path tree of each of k roots.

    ``below`` counts the vertices of the subtree, 0 where the root does not reach; −1 in the others stands for none.
    """
    n = indptr.shape[0] - 1
    distance = np.empty(n)
    settled = np.empty(n, dtype=np.int64)
    keys = np.empty(indices.shape[0] + 1)
    items = np.empty(indices.shape[0] + 1, dtype=np.int64)
    for r in range(roots.shape[0]):
        distance[:] = np.inf
        parent[r], child[r], sibling[r] = -1, -1, -1
        below[r] = 0
        distance[roots[r]] = 0.0
        keys[0], items[0] = 0.0, roots[r]
        size, count = 1, 0
        while size > 0:
            key, u = keys[0], items[0]
            drop_first(keys, items, size)
            size -= 1
            if key > distance[u]:
                continue
            settled[count] = u
            count += 1
            for k in range(indptr[u], indptr[u + 1]):
                v = indices[k]
                through = key + weights[k]
                if through < distance[v]:
                    distance[v] = through
                    parent[r, v] = u
                    push(keys, items, size, through, v)
                    size += 1
        for i in range(count - 1, -1, -1):
            u = settled[i]
            below[r, u] += 1
            above = parent[r, u]
            if above >= 0:
                below[r, above] += below[r, u]
                sibling[r, u] = child[r, above]
                child[r, above] = u


@kernel
def cover_trees(parent: Ints32, below: Ints32, child: Ints32, sibling: Ints32) -> Ints:
    """Order the vertices: next comes always the one on the most root paths that none before it is on; uses up below.

    That number, plus one a tree, counts times the root of what it was at first: when the sampled trees are nearly used
    up, small numbers say little, and it is the first ones that tell which of the many vertices left matter.
    """
    trees, n = parent.shape
    left = np.zeros(n)
    factor = np.ones(n)
    for r in range(trees):
        for v in range(n):
            left[v] += below[r, v]
            if parent[r, v] >= 0:  # all paths of a tree pass its root, which says nothing of it
                factor[v] += below[r, v]
    factor = np.sqrt(factor)
    keys = np.empty(n)
    items = np.empty(n, dtype=np.int64)
    for v in range(n):
        push(keys, items, v, -(left[v] + trees) * factor[v], v)
    order = np.empty(n, dtype=np.int64)
    stack = np.empty(n, dtype=np.int64)
    count, size = 0, n
    while size > 0:
        key, v = keys[0], items[0]
        drop_first(keys, items, size)
        size -= 1
        now = -(left[v] + trees) * factor[v]
        if key < now:  # numbers only fall: who is still first with the new one is first
            push(keys, items, size, now, v)
            size += 1
            continue
        order[count] = v
        count += 1
        for r in range(trees):
            lost = below[r, v]
            if lost == 0:
                continue
            u = parent[r, v]
            while u >= 0:
                below[r, u] -= lost
                left[u] -= lost
                u = parent[r, u]
            stack[0] = v
            top = 1
            while top > 0:
                top -= 1
                u = stack[top]
                left[u] -= below[r, u]
                below[r, u] = 0
                u = child[r, u]
                while u >= 0:
                    if below[r, u] > 0:
                        stack[top] = u
                        top += 1
                    u = sibling[r, u]
    return order


@kernel
def search_hubs(
    indptr: Ints, indices: Ints, weights: Floats, first: int, last: int
) -> tuple[Ints, Ints32, Floats, Ints32]:
    """Entries of the hubs first … last − 1: how many each has, and vertex, distance and following vertex of each entry.

    A search from each hub settles all vertices in order of distance, and marks those as covered to which some shortest
    path passes a vertex of higher rank; the others get an entry. It ends when all vertices in the queue are covered.
    """
    n = indptr.shape[0] - 1
    distance = np.full(n, np.inf)
    state = np.empty(n, dtype=np.int8)
    before = np.empty(n, dtype=np.int32)
    touched = np.empty(n, dtype=np.int64)
    keys = np.empty(indices.shape[0] + 1)
    items = np.empty(indices.shape[0] + 1, dtype=np.int64)
    counts = np.zeros(last - first, dtype=np.int64)
    room = 1024
    vertices = np.empty(room, dtype=np.int32)
    distances = np.empty(room)
    following = np.empty(room, dtype=np.int32)
    found = 0
    for hub in range(first, last):
        distance[hub] = 0.0
        state[hub] = UNCOVERED
        before[hub] = -1
        touched[0] = hub
        reached = 1
        keys[0], items[0] = 0.0, hub
        size = 1
        waiting = 1  # uncovered vertices in the queue
        while waiting > 0:
            key, u = keys[0], items[0]
            drop_first(keys, items, size)
            size -= 1
            if key > distance[u]:
                continue
            covered = state[u] == COVERED
            state[u] = SETTLED
            if not covered:
                waiting -= 1
                if found == room:
                    room *= 2
                    vertices = _with_room(vertices, room)
                    distances = _with_room(distances, room)
                    following = _with_room(following, room)
                vertices[found], distances[found], following[found] = u, key, before[u]
                found += 1
                counts[hub - first] += 1
            for k in range(indptr[u], indptr[u + 1]):
                v = indices[k]
                through = key + weights[k]
                if through < distance[v]:
                    if distance[v] == np.inf:
                        touched[reached] = v
                        reached += 1
                    elif state[v] == UNCOVERED:
                        waiting -= 1
                    distance[v] = through
                    before[v] = u
                    if covered or v < hub:
                        state[v] = COVERED
                    else:
                        state[v] = UNCOVERED
                        waiting += 1
                    push(keys, items, size, through, v)
                    size += 1
                elif covered and through == distance[v] and state[v] == UNCOVERED:
                    state[v] = COVERED
                    waiting -= 1
        for i in range(reached):
            distance[touched[i]] = np.inf
    return counts, vertices[:found].copy(), distances[:found].copy(), following[:found].copy()


@kernel
def _with_room(values: _Array, room: int) -> _Array:
    wider = np.empty(room, dtype=values.dtype)
    wider[: values.shape[0]] = values
    return wider


@kernel
def place_entries(
    order: Ints,
    first: int,
    counts: Ints,
    vertices: Ints32,
    distances: Floats,
    following: Ints32,
    free: Ints,
    hubs_out: Ints32,
    distances_out: Floats,
    following_out: Ints32,
) -> None:
    """Append entries that `search_hubs` found to the labels, whose next free places are ``free``, as true vertices."""
    i = 0
    for k in range(counts.shape[0]):
        for _ in range(counts[k]):
            v = order[vertices[i]]
            at = free[v]
            free[v] = at + 1
            hubs_out[at] = first + k
            distances_out[at] = distances[i]
            following_out[at] = -1 if following[i] < 0 else order[following[i]]
            i += 1


@kernel
def distances_of_pairs(start: Ints, hubs: Hubs, distances: Floats, a: Ints, b: Ints) -> Floats:
    """Distance of each pair; the label of a vertex is spread out once for all pairs in a row that begin with it."""
    spread = np.full(start.shape[0] - 1, np.inf)
    out = np.empty(a.shape[0])
    for p in range(a.shape[0]):
        if p == 0 or a[p] != a[p - 1]:
            if p > 0:
                _clear(start, hubs, a[p - 1], spread)
            _spread_out(start, hubs, distances, a[p], 0.0, spread)
        out[p] = _nearest(start, hubs, distances, b[p], spread, np.inf)[0]
    return out


@kernel
def distances_of_places(
    start: Ints,
    hubs: Hubs,
    distances: Floats,
    positions: Floats,
    points: Floats,
    first: Ints,
    corners: Ints,
    offsets: Floats,
    a: Ints,
    b: Ints,
) -> tuple[Floats, Ints]:
    """Distance of each pair of places, and the vertices that are passed first and last, (k, 2), −1 if none.

    The pair of corners with the least straight estimates gives an upper bound, and only corners whose estimates are
    below it are looked at: first those of a are spread out by hub, then those of b meet them.
    """
    spread = np.full(start.shape[0] - 1, np.inf)
    most = 0
    for k in range(first.shape[0] - 1):
        most = max(most, first[k + 1] - first[k])
    near_a, near_b = np.empty(most), np.empty(most)
    out = np.full(a.shape[0], np.inf)
    passed = np.full((a.shape[0], 2), -1, dtype=np.int64)
    for p in range(a.shape[0]):
        a0, b0 = first[a[p]], first[b[p]]
        size_a, size_b = first[a[p] + 1] - a0, first[b[p] + 1] - b0
        if size_a == 0 or size_b == 0:
            continue
        best_a = _estimate(positions, corners, offsets, a0, size_a, points[b[p]], near_a)
        best_b = _estimate(positions, corners, offsets, b0, size_b, points[a[p]], near_b)
        _spread_out(start, hubs, distances, corners[a0 + best_a], offsets[a0 + best_a], spread)
        least, meeting = _nearest(start, hubs, distances, corners[b0 + best_b], spread, np.inf)
        least += offsets[b0 + best_b]
        chosen = best_b
        bound = least
        alone = True
        for i in range(size_a):
            if i != best_a and near_a[i] < bound:
                _spread_out(start, hubs, distances, corners[a0 + i], offsets[a0 + i], spread)
                alone = False
        for j in range(size_b):
            if near_b[j] < least and not (alone and j == best_b):
                extra = offsets[b0 + j]
                length, entry = _nearest(start, hubs, distances, corners[b0 + j], spread, least - extra)
                if entry >= 0 and length + extra < least:
                    least, meeting, chosen = length + extra, entry, j
        if meeting >= 0:
            out[p] = least
            hub = hubs[meeting]
            passed[p, 1] = corners[b0 + chosen]
            for i in range(size_a):
                if i == best_a or near_a[i] < bound:
                    at = _entry(start, hubs, corners[a0 + i], hub)
                    if at >= 0 and offsets[a0 + i] + distances[at] == spread[hub]:
                        passed[p, 0] = corners[a0 + i]
                        break
        for i in range(size_a):
            if i == best_a or near_a[i] < bound:
                _clear(start, hubs, corners[a0 + i], spread)
    return out, passed


@kernel
def _estimate(
    positions: Floats, corners: Ints, offsets: Floats, begin: int, size: int, towards: Floats, near: Floats
) -> int:
    """Bound the way over each corner from below, and return the number of that with the least bound."""
    best = 0
    for i in range(size):
        v = corners[begin + i]
        straight = np.hypot(positions[v, 0] - towards[0], positions[v, 1] - towards[1])  # squares would overflow
        near[i] = offsets[begin + i] + straight
        if near[i] < near[best]:
            best = i
    return best


@kernel
def _spread_out(start: Ints, hubs: Hubs, distances: Floats, v: int, offset: float, spread: Floats) -> None:
    label, lengths = hubs[start[v] : start[v + 1]], distances[start[v] : start[v + 1]]
    for i in range(label.shape[0]):
        length = offset + lengths[i]
        if length < spread[label[i]]:
            spread[label[i]] = length


@kernel
def _nearest(start: Ints, hubs: Hubs, distances: Floats, v: int, spread: Floats, below: float) -> tuple[float, int]:
    """Least sum with the label of v that is less than ``below``, and its entry; ``below`` and −1 if there is none."""
    label, lengths = hubs[start[v] : start[v + 1]], distances[start[v] : start[v + 1]]
    least, entry = below, -1
    for begin in range(0, label.shape[0], BLOCK):
        some, of_some = label[begin : begin + BLOCK], lengths[begin : begin + BLOCK]
        better = 0
        for i in range(some.shape[0]):
            better |= spread[some[i]] + of_some[i] < least
        if better:
            for i in range(some.shape[0]):
                length = spread[some[i]] + of_some[i]
                if length < least:
                    least, entry = length, start[v] + begin + i
    return least, entry


@kernel
def _clear(start: Ints, hubs: Hubs, v: int, spread: Floats) -> None:
    label = hubs[start[v] : start[v + 1]]
    for i in range(label.shape[0]):
        spread[label[i]] = np.inf


@kernel
def _entry(start: Ints, hubs: Hubs, v: int, hub: int) -> int:
    """Index of the entry of ``hub`` in the label of v, −1 if there is none."""
    low, high = start[v], start[v + 1]
    while low < high:
        middle = (low + high) >> 1
        if hubs[middle] < hub:
            low = middle + 1
        else:
            high = middle
    return low if low < start[v + 1] and hubs[low] == hub else -1


@kernel
def paths_of_pairs(
    start: Ints, hubs: Hubs, distances: Floats, following: Ints32, a: Ints, b: Ints
) -> tuple[Ints, Ints]:
    """Vertices of a shortest path of each pair as CSR; no vertices where there is no path."""
    n = start.shape[0] - 1
    spread = np.full(n, np.inf)
    there, back = np.empty(n, dtype=np.int64), np.empty(n, dtype=np.int64)
    first = np.zeros(a.shape[0] + 1, dtype=np.int64)
    room = 1024
    out = np.empty(room, dtype=np.int64)
    total = 0
    for p in range(a.shape[0]):
        _spread_out(start, hubs, distances, a[p], 0.0, spread)
        meeting = _nearest(start, hubs, distances, b[p], spread, np.inf)[1]
        _clear(start, hubs, a[p], spread)
        if meeting >= 0:
            hub = hubs[meeting]
            size = _walk(start, hubs, following, a[p], hub, there)
            size_back = _walk(start, hubs, following, b[p], hub, back)
            # over edges of no length the two ways may share their last steps to the hub: the path turns where they join
            while size > 1 and size_back > 1 and there[size - 2] == back[size_back - 2]:
                size -= 1
                size_back -= 1
            while total + size + size_back > room:
                room *= 2
                out = _with_room(out, room)
            for i in range(size):
                out[total + i] = there[i]
            total += size
            for i in range(size_back - 2, -1, -1):
                out[total] = back[i]
                total += 1
        first[p + 1] = total
    return first, out[:total].copy()


@kernel
def _walk(start: Ints, hubs: Hubs, following: Ints32, v: int, hub: int, path: Ints) -> int:
    """Write the vertices from v to the hub and return their number."""
    count = 0
    while v >= 0:
        path[count] = v
        count += 1
        v = following[_entry(start, hubs, v, hub)]
    return count
