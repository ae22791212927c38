"""Kernels of the plane: exact orientation, triangulation tables, point location, triangular expansion.

A triangulation is three arrays: ``xy`` (n, 2) vertices, ``tri`` (m, 3) vertex numbers counter-clockwise, ``nbr`` (m, 3)
where ``nbr[t, k]`` lies across the edge from ``tri[t, k]`` to ``tri[t, k + 1]``, −1 at the boundary of the region.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

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
def _longer(a: Ints) -> Ints:
    """Copy to twice the length; a loop, because slice assignment compiles ten times as long."""
    out = np.empty(2 * a.shape[0], dtype=np.int64)
    for i in range(a.shape[0]):
        out[i] = a[i]
    return out


@kernel
def _head(a: Ints, n: int) -> Ints:
    out = np.empty(n, dtype=np.int64)
    for i in range(n):
        out[i] = a[i]
    return out


@kernel
def _higher(stack: Ints) -> Ints:
    out = np.empty((2 * stack.shape[0], stack.shape[1]), dtype=np.int64)
    for i in range(stack.shape[0]):
        for k in range(stack.shape[1]):
            out[i, k] = stack[i, k]
    return out


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
                if _beyond(xy, tri[t, k], tri[t, (k + 1) % 3], xy[u, 0], xy[u, 1], width):
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
                        stack = _longer(stack)
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
def _row_span(xy: Floats, tri: Ints, t: int, lo: float, hi: float) -> tuple[float, float]:
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
def _cell(x: float, x0: float, step: float, n: int) -> int:
    return min(max(int((x - x0) / step), 0), n - 1)


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
            ymin = min(xy[tri[t, 0], 1], xy[tri[t, 1], 1], xy[tri[t, 2], 1])
            ymax = max(xy[tri[t, 0], 1], xy[tri[t, 1], 1], xy[tri[t, 2], 1])
            for row in range(_cell(ymin - slack, y0, step, ny), _cell(ymax + slack, y0, step, ny) + 1):
                xa, xb = _row_span(xy, tri, t, y0 + row * step - slack, y0 + (row + 1) * step + slack)
                if xb < xa:
                    continue
                for col in range(_cell(xa - slack, x0, step, nx), _cell(xb + slack, x0, step, nx) + 1):
                    c = row * nx + col
                    if fill == 1:
                        items[start[c + 1]] = t
                    start[c + 1] += 1
    return frame, shape, start, items


@kernel
def _inside(xy: Floats, tri: Ints, t: int, x: float, y: float) -> bool:
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
        col, row = _cell(x, frame[0], frame[2], nx), _cell(y, frame[1], frame[2], ny)
        c = row * nx + col
        for j in range(start[c], start[c + 1]):
            if _inside(xy, tri, items[j], x, y):
                out[i] = items[j]
                break
    return out


# ---------------------------------------------------------------------------------------------------------------------
# Seeing


@kernel
def _roots(
    xy: Floats, tri: Ints, nbr: Ints, fan: Ints, vertex_start: Ints, vertex_wedges: Ints, t: int, x: float, y: float
) -> Ints:
    """All triangles that contain the point: one, two about an edge, or every fan about a vertex."""
    for k in range(3):
        v = tri[t, k]
        if xy[v, 0] == x and xy[v, 1] == y:
            out = np.empty(16, dtype=np.int64)
            n = 0
            for i in range(vertex_start[v], vertex_start[v + 1]):
                w = vertex_wedges[i]
                s, j = fan[w, 3], fan[w, 4]
                while s >= 0:
                    if n == out.shape[0]:
                        out = _longer(out)
                    out[n] = s
                    n += 1
                    s = nbr[s, (j + 2) % 3]
                    if s >= 0:
                        j = 0
                        while tri[s, j] != v:
                            j += 1
            return _head(out, n)
    for k in range(3):
        a, b = tri[t, k], tri[t, (k + 1) % 3]
        if nbr[t, k] >= 0 and orient(xy[a, 0], xy[a, 1], xy[b, 0], xy[b, 1], x, y) == 0.0:
            both = np.empty(2, dtype=np.int64)
            both[0], both[1] = t, nbr[t, k]
            return both
    one = np.empty(1, dtype=np.int64)
    one[0] = t
    return one


@kernel
def _parts_line(xy: Floats, px: float, py: float, v: int, b: int, a: int) -> bool:
    """Whether the line from p through vertex v strictly separates v's neighbours: then no taut path bends at v."""
    vx, vy = xy[v, 0], xy[v, 1]
    ob = orient(px, py, vx, vy, xy[b, 0], xy[b, 1])
    oa = orient(px, py, vx, vy, xy[a, 0], xy[a, 1])
    return (ob > 0.0 and oa < 0.0) or (ob < 0.0 and oa > 0.0)


@kernel
def _blind(xy: Floats, root: int, b: int, a: int, u: int) -> bool:
    """Whether u lies, seen from corner `root`, where no taut path can leave: both boundary edges would be cut off."""
    vx, vy, ux, uy = xy[root, 0], xy[root, 1], xy[u, 0], xy[u, 1]
    return orient(vx, vy, xy[b, 0], xy[b, 1], ux, uy) >= 0.0 and orient(vx, vy, xy[a, 0], xy[a, 1], ux, uy) <= 0.0


@kernel
def _beyond(xy: Floats, a: int, b: int, px: float, py: float, reach: float) -> bool:
    """Whether the segment from vertex a to vertex b is farther than ``reach`` from p."""
    ax, ay = xy[a, 0] - px, xy[a, 1] - py
    ex, ey = xy[b, 0] - xy[a, 0], xy[b, 1] - xy[a, 1]
    f = min(max(-(ax * ex + ay * ey) / (ex * ex + ey * ey), 0.0), 1.0)
    dx, dy = ax + f * ex, ay + f * ey
    return bool(dx * dx + dy * dy > reach * reach)


@kernel
def _expand(
    xy: Floats,
    tri: Ints,
    nbr: Ints,
    wedge_of: Ints,
    px: float,
    py: float,
    root: Ints,
    stack: Ints,
    top: int,
    seen: Ints,
    n: int,
    reach: float,
) -> tuple[Ints, Ints, int]:
    """Triangular expansion: follow the cones on the stack and append every wedge strictly inside one to ``seen``.

    Nothing is followed through edges farther than ``reach`` metres. A stack row is triangle, edge by which it is
    entered, right and left vertex of the cone, and whether each of these two directions is blind. ``root`` is
    (vertex, first, last) of a corner whose taut directions alone matter, or −1s.
    """
    while top > 0:
        top -= 1
        t, k, right, left = stack[top, 0], stack[top, 1], stack[top, 2], stack[top, 3]
        right_blind, left_blind = stack[top, 4], stack[top, 5]
        if reach < np.inf and _beyond(xy, tri[t, k], tri[t, (k + 1) % 3], px, py, reach):
            continue
        j = (k + 2) % 3
        u = tri[t, j]
        ux, uy = xy[u, 0], xy[u, 1]
        if top + 2 > stack.shape[0]:
            stack = _higher(stack)
        beyond_left = orient(px, py, xy[left, 0], xy[left, 1], ux, uy) >= 0.0
        beyond_right = (not beyond_left) and orient(px, py, xy[right, 0], xy[right, 1], ux, uy) <= 0.0
        k_right, k_left = (k + 1) % 3, (k + 2) % 3
        if beyond_left or beyond_right:
            side = k_right if beyond_left else k_left
            s = nbr[t, side]
            if s >= 0:
                i = 0
                while nbr[s, i] != t or tri[s, (i + 1) % 3] != tri[t, side]:
                    i += 1
                stack[top, 0], stack[top, 1], stack[top, 2], stack[top, 3] = s, i, right, left
                stack[top, 4], stack[top, 5] = right_blind, left_blind
                top += 1
            continue
        if n == seen.shape[0]:
            seen = _longer(seen)
        seen[n] = wedge_of[t, j]
        n += 1
        u_blind = 0
        if root[0] >= 0 and _blind(xy, root[0], root[1], root[2], u):
            u_blind = 1
        for half in range(2):
            side = k_right if half == 0 else k_left
            s = nbr[t, side]
            if s < 0 or (u_blind == 1 and (right_blind if half == 0 else left_blind) == 1):
                continue
            i = 0
            while nbr[s, i] != t or tri[s, (i + 1) % 3] != tri[t, side]:
                i += 1
            stack[top, 0], stack[top, 1] = s, i
            stack[top, 2], stack[top, 3] = (right, u) if half == 0 else (u, left)
            stack[top, 4], stack[top, 5] = (right_blind, u_blind) if half == 0 else (u_blind, left_blind)
            top += 1
    return stack, seen, n


@kernel
def _push_root(xy: Floats, tri: Ints, nbr: Ints, t: int, k: int, root: Ints, stack: Ints, top: int) -> tuple[Ints, int]:
    """Push the cone from the root through edge k of triangle t, unless it is closed or wholly blind."""
    s = nbr[t, k]
    if s < 0:
        return stack, top
    right, left = tri[t, k], tri[t, (k + 1) % 3]
    right_blind, left_blind = 0, 0
    if root[0] >= 0:
        right_blind = 1 if _blind(xy, root[0], root[1], root[2], right) else 0
        left_blind = 1 if _blind(xy, root[0], root[1], root[2], left) else 0
        if right_blind == 1 and left_blind == 1:
            return stack, top
    if top == stack.shape[0]:
        stack = _higher(stack)
    i = 0
    while nbr[s, i] != t or tri[s, (i + 1) % 3] != right:
        i += 1
    stack[top, 0], stack[top, 1], stack[top, 2], stack[top, 3] = s, i, right, left
    stack[top, 4], stack[top, 5] = right_blind, left_blind
    return stack, top + 1


@kernel
def see_from_wedges(
    xy: Floats,
    tri: Ints,
    nbr: Ints,
    fan: Ints,
    wedge_of: Ints,
    wanted: NDArray[np.bool_],
    taut: bool,
    first: int,
    last: int,
) -> tuple[Ints, Ints]:
    """Pairs (v, w), v < w, of wanted wedges v in [first, last) that see each other with no vertex strictly between.

    ``taut`` keeps only pairs that are locally shortest at both ends. Returns the two columns.
    """
    va = np.empty(256, dtype=np.int64)
    vb = np.empty(256, dtype=np.int64)
    count = 0
    stack = np.empty((64, 6), dtype=np.int64)
    seen = np.empty(256, dtype=np.int64)
    root = np.full(3, -1, dtype=np.int64)
    for v in range(first, last):
        if not wanted[v]:
            continue
        vertex = fan[v, 0]
        px, py = xy[vertex, 0], xy[vertex, 1]
        if taut:
            root[0], root[1], root[2] = vertex, fan[v, 1], fan[v, 2]
        n = 0
        s, j = fan[v, 3], fan[v, 4]
        while s >= 0:
            if n + 2 > seen.shape[0]:
                seen = _longer(seen)
            seen[n] = wedge_of[s, (j + 1) % 3]
            n += 1
            stack, top = _push_root(xy, tri, nbr, s, (j + 1) % 3, root, stack, 0)
            stack, seen, n = _expand(xy, tri, nbr, wedge_of, px, py, root, stack, top, seen, n, np.inf)
            following = nbr[s, (j + 2) % 3]
            if following < 0:
                if n == seen.shape[0]:
                    seen = _longer(seen)
                seen[n] = wedge_of[s, (j + 2) % 3]
                n += 1
                break
            s = following
            j = 0
            while tri[s, j] != vertex:
                j += 1
        for i in range(n):
            w = seen[i]
            if w <= v or not wanted[w]:
                continue
            if taut:
                u = fan[w, 0]
                if _parts_line(xy, px, py, u, fan[w, 1], fan[w, 2]) or _parts_line(
                    xy, xy[u, 0], xy[u, 1], vertex, fan[v, 1], fan[v, 2]
                ):
                    continue
            if count == va.shape[0]:
                va, vb = _longer(va), _longer(vb)
            va[count], vb[count] = v, w
            count += 1
    return _head(va, count), _head(vb, count)


@kernel
def see_from_points(
    xy: Floats,
    tri: Ints,
    nbr: Ints,
    fan: Ints,
    wedge_of: Ints,
    vertex_start: Ints,
    vertex_wedges: Ints,
    wanted: NDArray[np.bool_],
    taut: bool,
    points: Floats,
    triangles: Ints,
    reach: float,
) -> tuple[Ints, Ints]:
    """Wanted wedges seen from each point with no vertex strictly between: CSR (start, wedge).

    ``triangles[i]`` contains point i. Wedges farther than ``reach`` metres may be left out.
    ``taut`` keeps wedges at which the arriving segment is locally shortest.
    """
    start = np.zeros(points.shape[0] + 1, dtype=np.int64)
    out = np.empty(256, dtype=np.int64)
    count = 0
    stack = np.empty((64, 6), dtype=np.int64)
    seen = np.empty(256, dtype=np.int64)
    root = np.full(3, -1, dtype=np.int64)
    met = np.full(fan.shape[0], -1, dtype=np.int64)
    for p in range(points.shape[0]):
        px, py = points[p, 0], points[p, 1]
        n = 0
        for t in _roots(xy, tri, nbr, fan, vertex_start, vertex_wedges, triangles[p], px, py):
            for k in range(3):
                a, b = tri[t, k], tri[t, (k + 1) % 3]
                if n == seen.shape[0]:
                    seen = _longer(seen)
                if xy[a, 0] != px or xy[a, 1] != py:
                    seen[n] = wedge_of[t, k]
                    n += 1
                if orient(px, py, xy[a, 0], xy[a, 1], xy[b, 0], xy[b, 1]) > 0.0:
                    stack, top = _push_root(xy, tri, nbr, t, k, root, stack, 0)
                    stack, seen, n = _expand(xy, tri, nbr, wedge_of, px, py, root, stack, top, seen, n, reach)
        for i in range(n):
            w = seen[i]
            if met[w] == p or not wanted[w]:
                continue
            met[w] = p
            if taut and _parts_line(xy, px, py, fan[w, 0], fan[w, 1], fan[w, 2]):
                continue
            if count == out.shape[0]:
                out = _longer(out)
            out[count] = w
            count += 1
        start[p + 1] = count
    return start, _head(out, count)


@kernel
def _sees(xy: Floats, tri: Ints, nbr: Ints, t: int, px: float, py: float, qx: float, qy: float, longest: int) -> bool:
    """Whether q is seen from p, which triangle t contains, starting through t: no vertex strictly between."""
    if _inside(xy, tri, t, qx, qy):
        return True
    k = -1
    for j in range(3):
        a, b = tri[t, j], tri[t, (j + 1) % 3]
        if (
            orient(px, py, xy[a, 0], xy[a, 1], xy[b, 0], xy[b, 1]) > 0.0
            and orient(px, py, xy[a, 0], xy[a, 1], qx, qy) > 0.0
            and orient(px, py, xy[b, 0], xy[b, 1], qx, qy) < 0.0
        ):
            k = j
            break
    if k < 0:
        return False
    for _ in range(longest):
        s = nbr[t, k]
        if s < 0:
            return False
        j = 0
        while nbr[s, j] != t or tri[s, (j + 1) % 3] != tri[t, k]:
            j += 1
        u = tri[s, (j + 2) % 3]
        turn = orient(px, py, qx, qy, xy[u, 0], xy[u, 1])
        k = (j + 1) % 3 if turn > 0.0 else (j + 2) % 3
        a, b = tri[s, k], tri[s, (k + 1) % 3]
        if turn == 0.0:
            if xy[u, 0] == qx and xy[u, 1] == qy:
                return True
            other = (j + 1) % 3
            c, d = tri[s, other], tri[s, (other + 1) % 3]
            return (
                orient(xy[a, 0], xy[a, 1], xy[b, 0], xy[b, 1], qx, qy) >= 0.0
                and orient(xy[c, 0], xy[c, 1], xy[d, 0], xy[d, 1], qx, qy) >= 0.0
            )
        if orient(xy[a, 0], xy[a, 1], xy[b, 0], xy[b, 1], qx, qy) >= 0.0:
            return True
        t = s
    return False


@kernel
def see_pairs(
    xy: Floats,
    tri: Ints,
    nbr: Ints,
    fan: Ints,
    vertex_start: Ints,
    vertex_wedges: Ints,
    points: Floats,
    triangles: Ints,
    a: Ints,
    b: Ints,
) -> NDArray[np.bool_]:
    """For each pair (a[i], b[i]) of points: whether they see each other with no vertex strictly between."""
    out = np.zeros(a.shape[0], dtype=np.bool_)
    for i in range(a.shape[0]):
        px, py, qx, qy = points[a[i], 0], points[a[i], 1], points[b[i], 0], points[b[i], 1]
        for t in _roots(xy, tri, nbr, fan, vertex_start, vertex_wedges, triangles[a[i]], px, py):
            if _sees(xy, tri, nbr, t, px, py, qx, qy, tri.shape[0]):
                out[i] = True
                break
    return out


@kernel
def extend_collinear(positions: Floats, through: NDArray[np.bool_], indptr: Ints, indices: Ints) -> tuple[Ints, Ints]:
    """Further pairs (v, w), v < w, that see each other along a line touching vertices marked ``through`` on the way.

    The CSR graph holds the pairs without a vertex between; a vertex is a wedge, so a line that enters and leaves it
    passes on one side of the obstacle.
    """
    va = np.empty(64, dtype=np.int64)
    vb = np.empty(64, dtype=np.int64)
    count = 0
    stack = np.empty(64, dtype=np.int64)
    for p in range(positions.shape[0]):
        px, py = positions[p, 0], positions[p, 1]
        for i in range(indptr[p], indptr[p + 1]):
            stack[0] = indices[i]
            top = 1
            while top > 0:
                top -= 1
                v = stack[top]
                if not through[v]:
                    continue
                vx, vy = positions[v, 0], positions[v, 1]
                for k in range(indptr[v], indptr[v + 1]):
                    w = indices[k]
                    wx, wy = positions[w, 0], positions[w, 1]
                    if (wx - vx) * (vx - px) + (wy - vy) * (vy - py) <= 0.0 or orient(px, py, vx, vy, wx, wy) != 0.0:
                        continue
                    if top == stack.shape[0]:
                        stack = _longer(stack)
                    stack[top] = w
                    top += 1
                    if w > p:
                        if count == va.shape[0]:
                            va, vb = _longer(va), _longer(vb)
                        va[count], vb[count] = p, w
                        count += 1
    return _head(va, count), _head(vb, count)
