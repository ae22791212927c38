"""Kernels of seeing: triangular expansion from corners and points of a triangulated region.

Inner kernels take their arrays and never grow them: they stop when one is full, and the caller grows it and goes on.
An array that a loop might replace is counted at every turn, which makes expansion several times slower.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from taut.arrays import head, higher, longer
from taut.compiling import kernel
from taut.geometry._kernels import beyond, inside, orient

Floats = NDArray[np.float64]
Ints = NDArray[np.int64]


@kernel
def roots(
    xy: Floats,
    tri: Ints,
    nbr: Ints,
    fan: Ints,
    vertex_start: Ints,
    vertex_wedges: Ints,
    t: int,
    x: float,
    y: float,
    out: Ints,
) -> int:
    """All triangles that contain the point: one, two about an edge, or every fan about a vertex.

    Writes as many as there is room for in ``out`` (at least two) and returns how many there are.
    """
    vertex, edge = -1, -1
    for k in range(3):
        v = tri[t, k]
        if xy[v, 0] == x and xy[v, 1] == y:
            vertex = v
    n = 0
    if vertex >= 0:
        for i in range(vertex_start[vertex], vertex_start[vertex + 1]):
            w = vertex_wedges[i]
            s, j = fan[w, 3], fan[w, 4]
            while s >= 0:
                if n < out.shape[0]:
                    out[n] = s
                n += 1
                s = nbr[s, (j + 2) % 3]
                if s >= 0:
                    j = 0
                    while tri[s, j] != vertex:
                        j += 1
    else:
        for k in range(3):
            a, b = tri[t, k], tri[t, (k + 1) % 3]
            if nbr[t, k] >= 0 and orient(xy[a, 0], xy[a, 1], xy[b, 0], xy[b, 1], x, y) == 0.0:
                edge = k
        out[0] = t
        n = 1
        if edge >= 0:
            out[1] = nbr[t, edge]
            n = 2
    return n


@kernel
def parts_line(xy: Floats, px: float, py: float, v: int, b: int, a: int) -> bool:
    """Whether the line from p through vertex v strictly separates v's neighbours: then no taut path bends at v."""
    vx, vy = xy[v, 0], xy[v, 1]
    ob = orient(px, py, vx, vy, xy[b, 0], xy[b, 1])
    oa = orient(px, py, vx, vy, xy[a, 0], xy[a, 1])
    return (ob > 0.0 and oa < 0.0) or (ob < 0.0 and oa > 0.0)


@kernel
def blind(xy: Floats, root: int, b: int, a: int, u: int) -> bool:
    """Whether u lies, seen from corner `root`, where no taut path can leave: both boundary edges would be cut off."""
    vx, vy, ux, uy = xy[root, 0], xy[root, 1], xy[u, 0], xy[u, 1]
    return orient(vx, vy, xy[b, 0], xy[b, 1], ux, uy) >= 0.0 and orient(vx, vy, xy[a, 0], xy[a, 1], ux, uy) <= 0.0


@kernel
def expand(
    xy: Floats,
    tri: Ints,
    nbr: Ints,
    wedge_of: Ints,
    px: float,
    py: float,
    root: int,
    first: int,
    last: int,
    stack: Ints,
    top: int,
    seen: Ints,
    n: int,
    reach: float,
) -> tuple[int, int]:
    """Triangular expansion: follow the cones on the stack and write every wedge strictly inside one to ``seen``.

    Nothing is followed through edges farther than ``reach`` metres. A stack row is triangle, edge by which it is
    entered, right and left vertex of the cone, and whether each of these two directions is blind. ``root``, ``first``
    and ``last`` are a corner whose taut directions alone matter and its boundary neighbours, or −1s. Returns how many
    rows and wedges there are; rows are left when ``stack`` or ``seen`` is full.
    """
    while top > 0 and top < stack.shape[0] and n < seen.shape[0]:
        top -= 1
        t, k, right, left = stack[top, 0], stack[top, 1], stack[top, 2], stack[top, 3]
        right_blind, left_blind = stack[top, 4], stack[top, 5]
        if reach < np.inf and beyond(xy, tri[t, k], tri[t, (k + 1) % 3], px, py, reach):
            continue
        j = (k + 2) % 3
        u = tri[t, j]
        ux, uy = xy[u, 0], xy[u, 1]
        beyond_left = orient(px, py, xy[left, 0], xy[left, 1], ux, uy) >= 0.0
        beyond_right = (not beyond_left) and orient(px, py, xy[right, 0], xy[right, 1], ux, uy) <= 0.0
        k_right, k_left = (k + 1) % 3, (k + 2) % 3
        if beyond_left or beyond_right:
            side = k_right if beyond_left else k_left
            s = nbr[t, side]
            if s >= 0:
                stack[top, 0], stack[top, 1] = s, entry(tri, nbr, t, side, s)
                top += 1
            continue
        seen[n] = wedge_of[t, j]
        n += 1
        u_blind = 1 if root >= 0 and blind(xy, root, first, last, u) else 0
        s = nbr[t, k_right]
        if s >= 0 and not (u_blind == 1 and right_blind == 1):
            stack[top, 0], stack[top, 1], stack[top, 2], stack[top, 3] = s, entry(tri, nbr, t, k_right, s), right, u
            stack[top, 4], stack[top, 5] = right_blind, u_blind
            top += 1
        s = nbr[t, k_left]
        if s >= 0 and not (u_blind == 1 and left_blind == 1):
            stack[top, 0], stack[top, 1], stack[top, 2], stack[top, 3] = s, entry(tri, nbr, t, k_left, s), u, left
            stack[top, 4], stack[top, 5] = u_blind, left_blind
            top += 1
    return top, n


@kernel
def entry(tri: Ints, nbr: Ints, t: int, side: int, s: int) -> int:
    """Edge by which triangle s is entered from triangle t across t's edge ``side``."""
    i = 0
    while nbr[s, i] != t or tri[s, (i + 1) % 3] != tri[t, side]:
        i += 1
    return i


@kernel
def push_cone(
    xy: Floats,
    tri: Ints,
    nbr: Ints,
    t: int,
    k: int,
    right: int,
    left: int,
    root: int,
    first: int,
    last: int,
    stack: Ints,
) -> int:
    """Put the cone between vertices ``right`` and ``left`` through edge k of triangle t on the empty stack of `expand`.

    Returns how many rows there are: none if the edge is closed or the cone wholly blind.
    """
    s = nbr[t, k]
    right_blind = 1 if root >= 0 and blind(xy, root, first, last, right) else 0
    left_blind = 1 if root >= 0 and blind(xy, root, first, last, left) else 0
    rows = 0
    if s >= 0 and not (right_blind == 1 and left_blind == 1):
        stack[0, 0], stack[0, 1], stack[0, 2], stack[0, 3] = s, entry(tri, nbr, t, k, s), right, left
        stack[0, 4], stack[0, 5] = right_blind, left_blind
        rows = 1
    return rows


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
    root, right, left = -1, -1, -1
    for v in range(first, last):
        if not wanted[v]:
            continue
        vertex = fan[v, 0]
        px, py = xy[vertex, 0], xy[vertex, 1]
        if taut:
            root, right, left = vertex, fan[v, 1], fan[v, 2]
        n = 0
        s, j = fan[v, 3], fan[v, 4]
        while s >= 0:
            if n + 2 > seen.shape[0]:
                seen = longer(seen)
            seen[n] = wedge_of[s, (j + 1) % 3]
            n += 1
            a, b = tri[s, (j + 1) % 3], tri[s, (j + 2) % 3]
            top = push_cone(xy, tri, nbr, s, (j + 1) % 3, a, b, root, right, left, stack)
            top, n = expand(xy, tri, nbr, wedge_of, px, py, root, right, left, stack, top, seen, n, np.inf)
            while top > 0:
                stack, seen = higher(stack), longer(seen)
                top, n = expand(xy, tri, nbr, wedge_of, px, py, root, right, left, stack, top, seen, n, np.inf)
            following = nbr[s, (j + 2) % 3]
            if following < 0:
                if n == seen.shape[0]:
                    seen = longer(seen)
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
    holders = np.empty(16, dtype=np.int64)
    met = np.full(fan.shape[0], -1, dtype=np.int64)
    for p in range(points.shape[0]):
        px, py = points[p, 0], points[p, 1]
        n = 0
        count_of = roots(xy, tri, nbr, fan, vertex_start, vertex_wedges, triangles[p], px, py, holders)
        while count_of > holders.shape[0]:
            holders = longer(holders)
            count_of = roots(xy, tri, nbr, fan, vertex_start, vertex_wedges, triangles[p], px, py, holders)
        for h in range(count_of):
            t = holders[h]
            for k in range(3):
                a, b = tri[t, k], tri[t, (k + 1) % 3]
                if n == seen.shape[0]:
                    seen = longer(seen)
                if xy[a, 0] != px or xy[a, 1] != py:
                    seen[n] = wedge_of[t, k]
                    n += 1
                if orient(px, py, xy[a, 0], xy[a, 1], xy[b, 0], xy[b, 1]) > 0.0:
                    top = push_cone(xy, tri, nbr, t, k, a, b, -1, -1, -1, stack)
                    top, n = expand(xy, tri, nbr, wedge_of, px, py, -1, -1, -1, stack, top, seen, n, reach)
                    while top > 0:
                        stack, seen = higher(stack), longer(seen)
                        top, n = expand(xy, tri, nbr, wedge_of, px, py, -1, -1, -1, stack, top, seen, n, reach)
        for i in range(n):
            w = seen[i]
            if met[w] == p or not wanted[w]:
                continue
            met[w] = p
            if taut and parts_line(xy, px, py, fan[w, 0], fan[w, 1], fan[w, 2]):
                continue
            if count == out.shape[0]:
                out = longer(out)
            out[count] = w
            count += 1
        start[p + 1] = count
    return start, head(out, count)


@kernel
def _sees(xy: Floats, tri: Ints, nbr: Ints, t: int, px: float, py: float, qx: float, qy: float, longest: int) -> bool:
    """Whether q is seen from p, which triangle t contains, starting through t: no vertex strictly between."""
    if inside(xy, tri, t, qx, qy):
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
    holders = np.empty(16, dtype=np.int64)
    for i in range(a.shape[0]):
        px, py, qx, qy = points[a[i], 0], points[a[i], 1], points[b[i], 0], points[b[i], 1]
        count = roots(xy, tri, nbr, fan, vertex_start, vertex_wedges, triangles[a[i]], px, py, holders)
        while count > holders.shape[0]:
            holders = longer(holders)
            count = roots(xy, tri, nbr, fan, vertex_start, vertex_wedges, triangles[a[i]], px, py, holders)
        for h in range(count):
            if _sees(xy, tri, nbr, holders[h], px, py, qx, qy, tri.shape[0]):
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
                        stack = longer(stack)
                    stack[top] = w
                    top += 1
                    if w > p:
                        if count == va.shape[0]:
                            va, vb = longer(va), longer(vb)
                        va[count], vb[count] = p, w
                        count += 1
    return head(va, count), head(vb, count)


@kernel
def bend_sides(xy: Floats, fan: Ints, wedges: Ints, indptr: Ints, indices: Ints) -> Ints:
    """On which side of each tangent edge the obstacle lies at its tail and at its head: 1 left, −1 right, 0 both.

    The CSR graph joins the corners whose wedges are numbered by ``wedges`` (n,).
    """
    out = np.empty((indices.shape[0], 2), dtype=np.int64)
    for u in range(wedges.shape[0]):
        p = fan[wedges[u], 0]
        for k in range(indptr[u], indptr[u + 1]):
            w = wedges[indices[k]]
            q = fan[w, 0]
            out[k, 0] = _side(xy, xy[p, 0], xy[p, 1], q, fan[wedges[u], 1], fan[wedges[u], 2])
            out[k, 1] = _side(xy, xy[p, 0], xy[p, 1], q, fan[w, 1], fan[w, 2])
    return out


@kernel
def bend_sides_from(xy: Floats, fan: Ints, points: Floats, start: Ints, wedges: Ints) -> Ints:
    """On which side of the way from each point to the wedges it is joined with (CSR) the obstacle lies there."""
    out = np.empty(wedges.shape[0], dtype=np.int64)
    for p in range(points.shape[0]):
        for k in range(start[p], start[p + 1]):
            w = wedges[k]
            out[k] = _side(xy, points[p, 0], points[p, 1], fan[w, 0], fan[w, 1], fan[w, 2])
    return out


@kernel
def _side(xy: Floats, px: float, py: float, q: int, a: int, b: int) -> int:
    """Side of the line from p through vertex q on which vertices a and b lie; 0 on both sides, or on neither."""
    oa = orient(px, py, xy[q, 0], xy[q, 1], xy[a, 0], xy[a, 1])
    ob = orient(px, py, xy[q, 0], xy[q, 1], xy[b, 0], xy[b, 1])
    left, right = oa > 0.0 or ob > 0.0, oa < 0.0 or ob < 0.0
    return int(left) - int(right)
