"""Kernels of how strongly a team is joined: parts, and paths that share no robot."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from taut.compiling import kernel

Floats = NDArray[np.float64]
Ints = NDArray[np.int64]
Flags = NDArray[np.bool_]


@kernel
def parts(n: int, pairs: Ints) -> Ints:
    """The component of each of n vertices, (n,), counted from 0 in the order of their first vertices."""
    above = np.arange(n)
    for e in range(pairs.shape[0]):
        u, v = pairs[e, 0], pairs[e, 1]
        while above[u] != u:
            above[u] = above[above[u]]
            u = above[u]
        while above[v] != v:
            above[v] = above[above[v]]
            v = above[v]
        above[max(u, v)] = min(u, v)
    out = np.empty(n, dtype=np.int64)
    count = 0
    for v in range(n):
        if above[v] == v:
            out[v] = count
            count += 1
        else:
            out[v] = out[above[v]]  # its number is known: what stands above is smaller
    return out


@kernel
def longest_needed(n: int, pairs: Ints, lengths: Floats, order: Ints) -> float:
    """Length of the longest link of a minimum spanning tree; inf if there is none. ``order`` sorts by length."""
    above = np.arange(n)
    joined = 1
    for e in order:
        u, v = pairs[e, 0], pairs[e, 1]
        while above[u] != u:
            above[u] = above[above[u]]
            u = above[u]
        while above[v] != v:
            above[v] = above[above[v]]
            v = above[v]
        if u != v:
            above[u] = v
            joined += 1
            if joined == n:
                return float(lengths[e])
    return np.inf if n > 1 else 0.0


@kernel
def strongly_connected(indptr: Ints, indices: Ints, k: int) -> bool:
    """Whether a graph of more than k vertices stays connected without any k − 1 of them.

    Fewer than k vertices that part the others leave one of the first k in place. Either they part two of those, or all
    of those from some later vertex, which has then no k paths to different ones of them (after Even 1975, "An algorithm
    for determining whether the connectivity of a graph is at least k").
    """
    n = indptr.shape[0] - 1
    ends = np.zeros(n, dtype=np.bool_)
    for u in range(k):
        ends[u] = True
    for w in range(k, n):
        if not _fan(indptr, indices, w, ends, -1, k):
            return False
    for u in range(k):
        ends[:] = False
        for e in range(indptr[u], indptr[u + 1]):
            ends[indices[e]] = True
        for w in range(u):
            if not ends[w] and not _fan(indptr, indices, w, ends, u, k):
                return False
    return True


@kernel
def _fan(indptr: Ints, indices: Ints, source: int, ends: Flags, without: int, k: int) -> bool:
    """Whether k paths lead from a vertex to k different ends, sharing nothing but the vertex and avoiding another.

    Augmenting paths by breadth-first search. Of each vertex v there are two places: v, where paths come in, and n + v,
    where they go out. Where a path passes, a search that comes in can only go back along it.
    """
    n = indptr.shape[0] - 1
    before = np.full(n, -1, dtype=np.int64)  # of v on the path through it
    stops = np.zeros(n, dtype=np.bool_)  # a path ends here
    came = np.empty(2 * n, dtype=np.int64)
    queue = np.empty(2 * n, dtype=np.int64)
    for _ in range(k):
        came[:] = -1
        came[n + source] = came[source] = n + source
        queue[0] = n + source
        head, tail, found = 0, 1, -1
        while head < tail and found < 0:
            place = queue[head]
            head += 1
            if place < n:
                step = before[place]
                step = n + place if step < 0 else n + step
                if came[step] < 0:
                    came[step] = place
                    queue[tail] = step
                    tail += 1
                continue
            v = place - n
            if v != source:
                if ends[v] and not stops[v]:
                    found = v
                    break
                if before[v] >= 0 and came[v] < 0:
                    came[v] = place
                    queue[tail] = v
                    tail += 1
            for e in range(indptr[v], indptr[v + 1]):
                w = indices[e]
                if w != without and came[w] < 0 and before[w] != v:
                    came[w] = place
                    queue[tail] = w
                    tail += 1
        if found < 0:
            return False
        stops[found] = True
        place = n + found
        while place != n + source:
            last = came[place]
            if place < n:  # from where the path now comes in, or no path any more
                before[place] = last - n if last - n != place else -1
            place = last
    return True
