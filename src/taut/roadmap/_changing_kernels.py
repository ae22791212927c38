"""Kernels of a tangent graph in which a few vertices and edges change: what meets a change, who sees past it, new rows.

Arrays of a mesh mean the same as in `taut.geometry._kernels`, those of a graph as in `taut.graph.Graph`.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from taut.arrays import head, higher, longer
from taut.compiling import kernel
from taut.geometry._kernels import orient, segments_cross, segments_near
from taut.geometry._seeing_kernels import blind, expand, parts_line, push_cone

Floats = NDArray[np.float64]
Ints = NDArray[np.int64]
Bools = NDArray[np.bool_]


@kernel
def meeting(positions: Floats, indptr: Ints, indices: Ints, sides: Floats, margin: float) -> tuple[Ints, Ints, Bools]:
    """Edges (i, j), i < j, that come within ``margin`` of the sides (k, 4) of a polygon, and whether they cross one."""
    x0, y0, x1, y1 = np.inf, np.inf, -np.inf, -np.inf
    for k in range(sides.shape[0]):
        x0, x1 = min(x0, sides[k, 0], sides[k, 2]), max(x1, sides[k, 0], sides[k, 2])
        y0, y1 = min(y0, sides[k, 1], sides[k, 3]), max(y1, sides[k, 1], sides[k, 3])
    x0, y0, x1, y1 = x0 - margin, y0 - margin, x1 + margin, y1 + margin
    a = np.empty(64, dtype=np.int64)
    b = np.empty(64, dtype=np.int64)
    through = np.empty(64, dtype=np.int64)
    n = 0
    for i in range(positions.shape[0]):
        ax, ay = positions[i, 0], positions[i, 1]
        for e in range(indptr[i + 1] - 1, indptr[i] - 1, -1):
            j = indices[e]
            if j < i:
                break
            bx, by = positions[j, 0], positions[j, 1]
            if max(ax, bx) < x0 or min(ax, bx) > x1 or max(ay, by) < y0 or min(ay, by) > y1:
                continue
            near, crossing = False, False
            for k in range(sides.shape[0]):
                cx, cy, dx, dy = sides[k, 0], sides[k, 1], sides[k, 2], sides[k, 3]
                if not segments_near(ax, ay, bx, by, cx, cy, dx, dy, margin):
                    continue
                near = True
                if segments_cross(ax, ay, bx, by, cx, cy, dx, dy):
                    crossing = True
                    break
            if not near:
                continue
            if n == a.shape[0]:
                a, b, through = longer(a), longer(b), longer(through)
            a[n], b[n], through[n] = i, j, 1 if crossing else 0
            n += 1
    return head(a, n), head(b, n), head(through, n) > 0


@kernel
def see_past(
    xy: Floats, tri: Ints, nbr: Ints, fan: Ints, wedge_of: Ints, wanted: Bools, roots: Ints, hull: Ints
) -> tuple[Ints, Ints]:
    """Pairs (v, w) of wanted wedges, v one of ``roots``, joined by a taut segment without a vertex strictly between.

    ``hull``, if not empty, are rows of ``xy`` that are a convex polygon, counter-clockwise: every pair whose segment
    or its extension beyond w meets its inside is found, others may be left out.
    """
    va = np.empty(256, dtype=np.int64)
    vb = np.empty(256, dtype=np.int64)
    count = 0
    stack = np.empty((64, 6), dtype=np.int64)
    seen = np.empty(256, dtype=np.int64)
    h = hull.shape[0]
    for v in roots:
        vertex = fan[v, 0]
        px, py = xy[vertex, 0], xy[vertex, 1]
        first, last = fan[v, 1], fan[v, 2]
        around = True
        right, left = -1, -1
        for i in range(h):
            a, b = hull[i], hull[i + 1 if i + 1 < h else 0]
            c = hull[i - 1 if i > 0 else h - 1]
            after = orient(px, py, xy[a, 0], xy[a, 1], xy[b, 0], xy[b, 1])
            before = orient(px, py, xy[c, 0], xy[c, 1], xy[a, 0], xy[a, 1])
            if after < 0.0:
                around = False
            # the tangent points of a convex polygon are where its boundary turns round, seen from p
            if before <= 0.0 and after > 0.0:
                right = a
            if before > 0.0 and after <= 0.0:
                left = a
        around = around or right < 0 or left < 0
        if not around and blind(xy, vertex, first, last, right) and blind(xy, vertex, first, last, left):
            continue
        n = 0
        s, j = fan[v, 3], fan[v, 4]
        while s >= 0:
            a, b = tri[s, (j + 1) % 3], tri[s, (j + 2) % 3]
            if n + 2 > seen.shape[0]:
                seen = longer(seen)
            from_right, to_left = a, b
            if not around:
                rx, ry, lx, ly = xy[right, 0], xy[right, 1], xy[left, 0], xy[left, 1]
                ax, ay, bx, by = xy[a, 0], xy[a, 1], xy[b, 0], xy[b, 1]
                a_in, b_in = _within(px, py, rx, ry, lx, ly, ax, ay), _within(px, py, rx, ry, lx, ly, bx, by)
                if not a_in:
                    from_right = right if _within(px, py, ax, ay, bx, by, rx, ry) else -1
                if not b_in:
                    to_left = left if _within(px, py, ax, ay, bx, by, lx, ly) else -1
            else:
                a_in, b_in = True, True
            if a_in:
                seen[n] = wedge_of[s, (j + 1) % 3]
                n += 1
            if b_in and nbr[s, (j + 2) % 3] < 0:
                seen[n] = wedge_of[s, (j + 2) % 3]
                n += 1
            if from_right >= 0 and to_left >= 0:
                top = push_cone(xy, tri, nbr, s, (j + 1) % 3, from_right, to_left, vertex, first, last, stack)
                top, n = expand(xy, tri, nbr, wedge_of, px, py, vertex, first, last, stack, top, seen, n, np.inf)
                while top > 0:
                    stack, seen = higher(stack), longer(seen)
                    top, n = expand(xy, tri, nbr, wedge_of, px, py, vertex, first, last, stack, top, seen, n, np.inf)
            s = nbr[s, (j + 2) % 3]
            if s >= 0:
                j = 0
                while tri[s, j] != vertex:
                    j += 1
        for i in range(n):
            w = seen[i]
            if not wanted[w]:
                continue
            u = fan[w, 0]
            if parts_line(xy, px, py, u, fan[w, 1], fan[w, 2]) or parts_line(
                xy, xy[u, 0], xy[u, 1], vertex, fan[v, 1], fan[v, 2]
            ):
                continue
            if count == va.shape[0]:
                va, vb = longer(va), longer(vb)
            va[count], vb[count] = v, w
            count += 1
    return head(va, count), head(vb, count)


@kernel
def _within(px: float, py: float, ax: float, ay: float, bx: float, by: float, qx: float, qy: float) -> bool:
    """Whether q lies, seen from p, in the closed cone from a counter-clockwise to b, which is narrower than π."""
    return orient(px, py, ax, ay, qx, qy) >= 0.0 and orient(px, py, qx, qy, bx, by) >= 0.0


@kernel
def patched_rows(
    indptr: Ints, indices: Ints, weights: Floats, number: Ints, n: int, lost: Ints, pairs: Ints, lengths: Floats
) -> tuple[Ints, Ints, Floats]:
    """CSR of a graph on n vertices of which some edges are lost and some are new.

    ``number`` holds the new numbers of the old vertices, ascending, −1 for those that are gone; the others come last.
    ``lost`` (k, 2) are edges in old numbers, ``pairs`` (p, 2) in new ones, both directions of each and sorted by rows;
    pairs that are edges already are no harm.
    """
    gone = np.zeros(indices.shape[0], dtype=np.bool_)
    for k in range(lost.shape[0]):
        gone[_place(indptr, indices, lost[k, 0], lost[k, 1])] = True
        gone[_place(indptr, indices, lost[k, 1], lost[k, 0])] = True
    out_start = np.empty(n + 1, dtype=np.int64)
    out = np.empty(indices.shape[0] + pairs.shape[0], dtype=np.int64)
    out_weights = np.empty(indices.shape[0] + pairs.shape[0])
    k, filled = 0, 0
    row = 0
    for old in range(number.shape[0] + 1):
        # after the old vertices that stay come the new ones
        last = n if old == number.shape[0] else number[old] + 1
        for i in range(row, last):
            out_start[i] = filled
            e = indptr[old] if old < number.shape[0] else 0
            end = indptr[old + 1] if old < number.shape[0] else 0
            while k < pairs.shape[0] and pairs[k, 0] == i:
                while e < end and (gone[e] or number[indices[e]] < pairs[k, 1]):
                    if not gone[e] and number[indices[e]] >= 0:
                        out[filled], out_weights[filled] = number[indices[e]], weights[e]
                        filled += 1
                    e += 1
                if e < end and number[indices[e]] == pairs[k, 1]:
                    e += 1
                out[filled], out_weights[filled] = pairs[k, 1], lengths[k]
                filled += 1
                k += 1
            for f in range(e, end):
                j = number[indices[f]]
                if j >= 0 and not gone[f]:
                    out[filled], out_weights[filled] = j, weights[f]
                    filled += 1
        row = max(row, last)
    out_start[n] = filled
    return out_start, out[:filled], out_weights[:filled]


@kernel
def _place(indptr: Ints, indices: Ints, i: int, j: int) -> int:
    """Place of column j in row i."""
    lo, hi = indptr[i], indptr[i + 1]
    while lo < hi:
        middle = (lo + hi) // 2
        if indices[middle] < j:
            lo = middle + 1
        else:
            hi = middle
    return int(lo)
