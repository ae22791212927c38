"""Kernels of the boundary of a triangulated region: its edges near a place, its closed walks, its rings.

Arrays mean the same as in `taut.geometry._kernels`.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from taut.arrays import head, longer
from taut.compiling import kernel

Floats = NDArray[np.float64]
Ints = NDArray[np.int64]


@kernel
def walls_in_box(xy: Floats, fan: Ints, x0: float, y0: float, x1: float, y1: float) -> Ints:
    """Wedges whose boundary edge, from vertex to first neighbour, has a bounding box that meets the box given."""
    out = np.empty(64, dtype=np.int64)
    n = 0
    for w in range(fan.shape[0]):
        ax, ay, bx, by = xy[fan[w, 0], 0], xy[fan[w, 0], 1], xy[fan[w, 1], 0], xy[fan[w, 1], 1]
        if max(ax, bx) < x0 or min(ax, bx) > x1 or max(ay, by) < y0 or min(ay, by) > y1:
            continue
        if n == out.shape[0]:
            out = longer(out)
        out[n] = w
        n += 1
    return head(out, n)


@kernel
def loops_through(fan: Ints, wedge_of: Ints, seeds: Ints) -> Ints:
    """Wedges whose boundary edges are on the closed walks along the boundary that pass through some of them."""
    seen = np.zeros(fan.shape[0], dtype=np.bool_)
    out = np.empty(64, dtype=np.int64)
    n = 0
    for seed in seeds:
        w = seed
        while not seen[w]:
            seen[w] = True
            if n == out.shape[0]:
                out = longer(out)
            out[n] = w
            n += 1
            w = wedge_of[fan[w, 3], (fan[w, 4] + 1) % 3]
    return head(out, n)


@kernel
def boundary_rings(xy: Floats, fan: Ints, wedge_of: Ints, part: Ints, parts: int) -> tuple[Ints, Ints, Ints]:
    """Cut the boundary into rings that pass through no other vertex than the first twice.

    Returns
    -------
    vertex : (k,) vertices, ring after ring, the first of each again at its end.
    ring_start : (r + 1,) where each ring begins, part after part, the shell of each before its holes.
    part_start : (p + 1,) where the rings of each part begin.
    """
    n = fan.shape[0]
    vertex = np.empty(2 * n, dtype=np.int64)
    start = np.zeros(n + 1, dtype=np.int64)
    owner = np.empty(n, dtype=np.int64)
    hole = np.zeros(n, dtype=np.bool_)
    seen = np.zeros(n, dtype=np.bool_)
    place = np.full(xy.shape[0], -1, dtype=np.int64)
    path = np.empty(n + 1, dtype=np.int64)
    filled, rings = 0, 0
    for seed in range(n):
        if seen[seed]:
            continue
        top = 0
        w = seed
        while True:
            v = fan[w, 0]
            back = 0 if seen[w] else place[v]
            if back >= 0:
                area = 0.0
                for i in range(back, top):
                    a, b = path[i], path[i + 1] if i + 1 < top else path[back]
                    area += (xy[a, 0] - xy[v, 0]) * (xy[b, 1] - xy[v, 1])
                    area -= (xy[a, 1] - xy[v, 1]) * (xy[b, 0] - xy[v, 0])
                    place[a] = -1
                # an edge that is walked forth and back is no ring
                if top - back > 2:
                    for i in range(back, top):
                        vertex[filled] = path[i]
                        filled += 1
                    vertex[filled] = path[back]
                    filled += 1
                    owner[rings], hole[rings] = part[fan[seed, 3]], area < 0.0
                    rings += 1
                    start[rings] = filled
                top = back
            if seen[w]:
                break
            seen[w] = True
            place[v], path[top] = top, v
            top += 1
            w = wedge_of[fan[w, 3], (fan[w, 4] + 1) % 3]
    part_start = np.zeros(parts + 1, dtype=np.int64)
    for r in range(rings):
        part_start[owner[r] + 1] += 1
    for p in range(parts):
        part_start[p + 1] += part_start[p]
    order = np.empty(rings, dtype=np.int64)
    put = part_start.copy()
    for holes in range(2):
        for r in range(rings):
            if hole[r] == (holes == 1):
                order[put[owner[r]]] = r
                put[owner[r]] += 1
    out = np.empty(filled, dtype=np.int64)
    ring_start = np.zeros(rings + 1, dtype=np.int64)
    filled = 0
    for k in range(rings):
        for i in range(start[order[k]], start[order[k] + 1]):
            out[filled] = vertex[i]
            filled += 1
        ring_start[k + 1] = filled
    return out, ring_start, part_start
