"""Kernels of the plane: exact orientation, segments, triangulation tables, point location.

A triangulation is three arrays: ``xy`` (n, 2) vertices, ``tri`` (m, 3) vertex numbers counter-clockwise, ``nbr`` (m, 3)
where ``nbr[t, k]`` lies across the edge from ``tri[t, k]`` to ``tri[t, k + 1]``, −1 at the boundary of the region.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from taut.arrays import longer
from taut.compiling import kernel

Floats = NDArray[np.float64]
Ints = NDArray[np.int64]

# Shewchuk 1997, Adaptive precision floating-point arithmetic: error bound of the plain determinant, ε = 2⁻⁵³
_ORIENT_ERROR = (3.0 + 16.0 * 2.0**-53) * 2.0**-53
_SPLITTER = 2.0**27 + 1.0


@kernel
def _two_product(a: float, b: float) -> tuple[float, float]:
    """The product a · b as an unevaluated sum high + low, without error (Dekker)."""
    p = a * b
    c = _SPLITTER * a
    ah = c - (c - a)
    al = a - ah
    c = _SPLITTER * b
    bh = c - (c - b)
    bl = b - bh
    return p, al * bl - (((p - ah * bh) - al * bh) - ah * bl)


@kernel
def _orient_exact(ax: float, ay: float, bx: float, by: float, cx: float, cy: float) -> float:
    """Sign of the determinant from its six products, each exact, summed as an expansion (Shewchuk, Grow-Expansion)."""
    e = np.empty(12)
    n = 0
    for k in range(6):
        if k == 0:
            p, q = _two_product(ax, by)
        elif k == 1:
            p, q = _two_product(-ay, bx)
        elif k == 2:
            p, q = _two_product(bx, cy)
        elif k == 3:
            p, q = _two_product(-by, cx)
        elif k == 4:
            p, q = _two_product(cx, ay)
        else:
            p, q = _two_product(-cy, ax)
        for j in range(2):
            carry = q if j == 0 else p
            for i in range(n):
                s = carry + e[i]
                v = s - carry
                e[i] = (carry - (s - v)) + (e[i] - v)
                carry = s
            e[n] = carry
            n += 1
    for i in range(n - 1, -1, -1):
        if e[i] != 0.0:
            return float(e[i])
    return 0.0


@kernel
def orient(ax: float, ay: float, bx: float, by: float, cx: float, cy: float) -> float:
    """Positive if a, b, c turn left, negative if right, zero if and only if they lie on one line. The sign is exact."""
    left = (ax - cx) * (by - cy)
    right = (ay - cy) * (bx - cx)
    det = left - right
    if not abs(det) > _ORIENT_ERROR * (abs(left) + abs(right)):
        det = _orient_exact(ax, ay, bx, by, cx, cy)
    return det


@kernel
def beyond(xy: Floats, a: int, b: int, px: float, py: float, reach: float) -> bool:
    """Whether the segment from vertex a to vertex b is farther than ``reach`` from p."""
    ax, ay = xy[a, 0] - px, xy[a, 1] - py
    ex, ey = xy[b, 0] - xy[a, 0], xy[b, 1] - xy[a, 1]
    f = min(max(-(ax * ex + ay * ey) / (ex * ex + ey * ey), 0.0), 1.0)
    dx, dy = ax + f * ex, ay + f * ey
    return bool(dx * dx + dy * dy > reach * reach)


@kernel
def segments_near(
    ax: float, ay: float, bx: float, by: float, cx: float, cy: float, dx: float, dy: float, margin: float
) -> bool:
    """Whether the segments a b and c d come within ``margin`` of each other."""
    if max(ax, bx) < min(cx, dx) - margin or min(ax, bx) > max(cx, dx) + margin:
        return False
    if max(ay, by) < min(cy, dy) - margin or min(ay, by) > max(cy, dy) + margin:
        return False
    least = min(_gap(ax, ay, bx, by, cx, cy), _gap(ax, ay, bx, by, dx, dy))
    least = min(least, _gap(cx, cy, dx, dy, ax, ay), _gap(cx, cy, dx, dy, bx, by))
    return least <= margin * margin or segments_cross(ax, ay, bx, by, cx, cy, dx, dy)


@kernel
def segments_cross(ax: float, ay: float, bx: float, by: float, cx: float, cy: float, dx: float, dy: float) -> bool:
    """Whether the segments a b and c d have exactly one point in common and it is no end of either."""
    one, two = orient(ax, ay, bx, by, cx, cy), orient(ax, ay, bx, by, dx, dy)
    if not ((one > 0.0 and two < 0.0) or (one < 0.0 and two > 0.0)):
        return False
    one, two = orient(cx, cy, dx, dy, ax, ay), orient(cx, cy, dx, dy, bx, by)
    return (one > 0.0 and two < 0.0) or (one < 0.0 and two > 0.0)


@kernel
def _gap(ax: float, ay: float, bx: float, by: float, px: float, py: float) -> float:
    """Square of the distance of p from the segment a b, which may be a point."""
    ex, ey, dx, dy = bx - ax, by - ay, px - ax, py - ay
    square = ex * ex + ey * ey
    f = min(max((dx * ex + dy * ey) / square, 0.0), 1.0) if square > 0.0 else 0.0
    dx, dy = dx - f * ex, dy - f * ey
    return dx * dx + dy * dy


@kernel
def straight_corners(xy: Floats, ring_start: Ints, shared: NDArray[np.bool_]) -> NDArray[np.bool_]:
    """Mark ring vertices that lie exactly on the line through their neighbours and on no other ring.

    Rings are given without repeating the first vertex: ring r is ``xy[ring_start[r]:ring_start[r + 1]]``.
    """
    out = np.zeros(xy.shape[0], dtype=np.bool_)
    for r in range(ring_start.shape[0] - 1):
        i0, i1 = ring_start[r], ring_start[r + 1]
        for i in range(i0, i1):
            if shared[i]:
                continue
            a = i - 1 if i > i0 else i1 - 1
            b = i + 1 if i < i1 - 1 else i0
            out[i] = orient(xy[a, 0], xy[a, 1], xy[i, 0], xy[i, 1], xy[b, 0], xy[b, 1]) == 0.0
    return out


@kernel
def close_hairlines(xy: Floats, tri: Ints, nbr: Ints, width: float) -> tuple[Ints, Ints]:
    """Close the passages narrower than ``width``: returns triangles and neighbours of what remains.

    A vertex so near to a boundary edge takes their triangle away; an edge so short becomes a wall.
    """
    m = tri.shape[0]
    gone = np.zeros(m, dtype=np.bool_)
    across = nbr.copy()
    stack = np.empty(16, dtype=np.int64)
    top = 0
    for t in range(m):
        for k in range(3):
            a, b = tri[t, k], tri[t, (k + 1) % 3]
            ex, ey = xy[b, 0] - xy[a, 0], xy[b, 1] - xy[a, 1]
            if across[t, k] >= 0 and ex * ex + ey * ey < width * width:
                across[t, k] = -1
    for seed in range(m):
        stack[0] = seed
        top = 1
        while top > 0:
            top -= 1
            t = stack[top]
            if gone[t]:
                continue
            for k in range(3):
                if across[t, k] >= 0:
                    continue
                u = tri[t, (k + 2) % 3]
                if beyond(xy, tri[t, k], tri[t, (k + 1) % 3], xy[u, 0], xy[u, 1], width):
                    continue
                gone[t] = True
                for j in range(3):
                    s = across[t, j]
                    if s < 0:
                        continue
                    for i in range(3):
                        if across[s, i] == t:
                            across[s, i] = -1
                    if top == stack.shape[0]:
                        stack = longer(stack)
                    stack[top] = s
                    top += 1
                break
    number = np.empty(m, dtype=np.int64)
    left = 0
    for t in range(m):
        number[t] = left
        if not gone[t]:
            left += 1
    out_tri = np.empty((left, 3), dtype=np.int64)
    out_nbr = np.empty((left, 3), dtype=np.int64)
    for t in range(m):
        if gone[t]:
            continue
        for k in range(3):
            out_tri[number[t], k] = tri[t, k]
            out_nbr[number[t], k] = number[across[t, k]] if across[t, k] >= 0 else -1
    return out_tri, out_nbr


@kernel
def label_parts(nbr: Ints) -> tuple[Ints, int]:
    """Number the parts of the region that hang together through edges: label of each triangle, how many."""
    m = nbr.shape[0]
    part = np.full(m, -1, dtype=np.int64)
    stack = np.empty(m, dtype=np.int64)
    count = 0
    for seed in range(m):
        if part[seed] >= 0:
            continue
        part[seed] = count
        stack[0] = seed
        top = 1
        while top > 0:
            top -= 1
            t = stack[top]
            for k in range(3):
                u = nbr[t, k]
                if u >= 0 and part[u] < 0:
                    part[u] = count
                    stack[top] = u
                    top += 1
        count += 1
    return part, count


@kernel
def wedges(tri: Ints, nbr: Ints) -> tuple[Ints, Ints]:
    """Find the wedges, the open sectors of free space about each vertex.

    Returns
    -------
    fan : (w, 5) vertex, first and last boundary neighbour counter-clockwise, first triangle and the vertex' slot in it.
    wedge_of : (m, 3) the wedge to which each corner of each triangle belongs.
    """
    m = tri.shape[0]
    count = 0
    for t in range(m):
        for k in range(3):
            if nbr[t, k] < 0:
                count += 1
    fan = np.empty((count, 5), dtype=np.int64)
    wedge_of = np.full((m, 3), -1, dtype=np.int64)
    w = 0
    for t in range(m):
        for k in range(3):
            if nbr[t, k] >= 0:
                continue
            v = tri[t, k]
            s, j = t, k
            while True:
                wedge_of[s, j] = w
                last = tri[s, (j + 2) % 3]
                u = nbr[s, (j + 2) % 3]
                if u < 0:
                    break
                j = 0
                while tri[u, j] != v:
                    j += 1
                s = u
            fan[w, 0] = v
            fan[w, 1] = tri[t, (k + 1) % 3]
            fan[w, 2] = last
            fan[w, 3] = t
            fan[w, 4] = k
            w += 1
    return fan, wedge_of


@kernel
def wedge_turns(xy: Floats, fan: Ints) -> Ints:
    """+1 for a wedge wider than π, 0 for exactly π, −1 for narrower."""
    out = np.empty(fan.shape[0], dtype=np.int64)
    for w in range(fan.shape[0]):
        v, b, a = fan[w, 0], fan[w, 1], fan[w, 2]
        o = orient(xy[v, 0], xy[v, 1], xy[b, 0], xy[b, 1], xy[a, 0], xy[a, 1])
        if o == 0.0:
            dot = (xy[a, 0] - xy[v, 0]) * (xy[b, 0] - xy[v, 0]) + (xy[a, 1] - xy[v, 1]) * (xy[b, 1] - xy[v, 1])
            out[w] = 1 if dot > 0.0 else 0
        else:
            out[w] = 1 if o < 0.0 else -1
    return out


# ---------------------------------------------------------------------------------------------------------------------
# Point location: a uniform grid; each cell lists the triangles that may reach into it


@kernel
def row_span(xy: Floats, tri: Ints, t: int, lo: float, hi: float) -> tuple[float, float]:
    """The x-range of triangle t within the strip lo ≤ y ≤ hi, widened a little; empty as (inf, -inf)."""
    x0, x1 = np.inf, -np.inf
    for k in range(3):
        a, b = tri[t, k], tri[t, (k + 1) % 3]
        ax, ay, bx, by = xy[a, 0], xy[a, 1], xy[b, 0], xy[b, 1]
        if ay > by:
            ax, ay, bx, by = bx, by, ax, ay
        if by < lo or ay > hi:
            continue
        if by > ay:
            u0 = min(max((lo - ay) / (by - ay), 0.0), 1.0)
            u1 = min(max((hi - ay) / (by - ay), 0.0), 1.0)
            xa = ax + u0 * (bx - ax)
            xb = ax + u1 * (bx - ax)
        else:
            xa, xb = ax, bx
        x0 = min(x0, xa, xb)
        x1 = max(x1, xa, xb)
    return x0, x1


@kernel
def cell_of(x: float, x0: float, step: float, n: int) -> int:
    """Number of the column or row, of n that are ``step`` wide and begin at x0, that x lies in or is nearest to."""
    return int(min(max((x - x0) / step, 0.0), n - 1.0))


@kernel
def location_grid(xy: Floats, tri: Ints) -> tuple[Floats, Ints, Ints, Ints]:
    """Build the grid: frame (x0, y0, step), shape (columns, rows), CSR of triangles per cell."""
    m = tri.shape[0]
    x0, y0, x1, y1 = xy[0, 0], xy[0, 1], xy[0, 0], xy[0, 1]
    for i in range(xy.shape[0]):
        x0, y0, x1, y1 = min(x0, xy[i, 0]), min(y0, xy[i, 1]), max(x1, xy[i, 0]), max(y1, xy[i, 1])
    wide, high = x1 - x0, y1 - y0
    step = max(np.sqrt(wide * high / m), wide / 4000.0, high / 4000.0)
    nx, ny = int(wide / step) + 1, int(high / step) + 1
    frame = np.array([x0, y0, step])
    shape = np.array([nx, ny], dtype=np.int64)
    slack = step * 1e-6
    start = np.zeros(nx * ny + 1, dtype=np.int64)
    items = np.empty(0, dtype=np.int64)
    for fill in range(2):
        if fill == 1:
            total = 0
            for c in range(nx * ny):
                k = start[c + 1]
                start[c + 1] = total
                total += k
            items = np.empty(total, dtype=np.int64)
        for t in range(m):
            xa, ya, xb, yb, xc, yc = (
                xy[tri[t, 0], 0],
                xy[tri[t, 0], 1],
                xy[tri[t, 1], 0],
                xy[tri[t, 1], 1],
                xy[tri[t, 2], 0],
                xy[tri[t, 2], 1],
            )
            low, high = cell_of(min(ya, yb, yc) - slack, y0, step, ny), cell_of(max(ya, yb, yc) + slack, y0, step, ny)
            left, right = cell_of(min(xa, xb, xc) - slack, x0, step, nx), cell_of(max(xa, xb, xc) + slack, x0, step, nx)
            few = (high - low + 1) * (right - left + 1) <= 6  # then all of them cost less than finding out which
            for row in range(low, high + 1):
                a, b = left, right
                if not few:
                    begin, end = row_span(xy, tri, t, y0 + row * step - slack, y0 + (row + 1) * step + slack)
                    if end < begin:
                        continue
                    a, b = cell_of(begin - slack, x0, step, nx), cell_of(end + slack, x0, step, nx)
                for col in range(a, b + 1):
                    c = row * nx + col
                    if fill == 1:
                        items[start[c + 1]] = t
                    start[c + 1] += 1
    return frame, shape, start, items


@kernel
def inside(xy: Floats, tri: Ints, t: int, x: float, y: float) -> bool:
    for k in range(3):
        a, b = tri[t, k], tri[t, (k + 1) % 3]
        if orient(xy[a, 0], xy[a, 1], xy[b, 0], xy[b, 1], x, y) < 0.0:
            return False
    return True


@kernel
def locate(xy: Floats, tri: Ints, frame: Floats, shape: Ints, start: Ints, items: Ints, points: Floats) -> Ints:
    """For each point the number of a triangle that contains it (boundary included), −1 outside. Exact."""
    out = np.full(points.shape[0], -1, dtype=np.int64)
    nx, ny = shape[0], shape[1]
    for i in range(points.shape[0]):
        x, y = points[i, 0], points[i, 1]
        # far outside the frame the predicates below would overflow
        if not (abs(x - frame[0]) <= (nx + 1) * frame[2] and abs(y - frame[1]) <= (ny + 1) * frame[2]):
            continue
        col, row = cell_of(x, frame[0], frame[2], nx), cell_of(y, frame[1], frame[2], ny)
        c = row * nx + col
        for j in range(start[c], start[c + 1]):
            if inside(xy, tri, items[j], x, y):
                out[i] = items[j]
                break
    return out
