"""Kernels of the Voronoi roadmap: distances from the boundary, its sampling, and how wide ways through cells can be.

Arrays mean the same as in `taut.geometry._kernels`. A side is a straight piece of the boundary between two corners and
has the number of the wedge at its first end. ``side`` holds, for each vertex of a sampled boundary, the side on which
it lies, −1 for corners; corners keep the numbers that they have in the mesh.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from taut.arrays import longer
from taut.compiling import kernel

Floats = NDArray[np.float64]
Ints = NDArray[np.int64]
Bools = NDArray[np.bool_]


@kernel
def _apart(px: float, py: float, ax: float, ay: float, bx: float, by: float) -> float:
    """Square of the distance of p from the segment a b, which may be a point."""
    ex, ey, dx, dy = bx - ax, by - ay, px - ax, py - ay
    square = ex * ex + ey * ey
    f = (dx * ex + dy * ey) / square if square > 0.0 else 0.0
    if f >= 1.0:
        dx, dy = px - bx, py - by
    elif f > 0.0:
        dx, dy = dx - f * ex, dy - f * ey
    return dx * dx + dy * dy


@kernel
def _between(ax: float, ay: float, bx: float, by: float, cx: float, cy: float, dx: float, dy: float) -> float:
    """Square of the distance of the segments a b and c d."""
    ex, ey, fx, fy = bx - ax, by - ay, dx - cx, dy - cy
    one, two = ex * (cy - ay) - ey * (cx - ax), ex * (dy - ay) - ey * (dx - ax)
    three, four = fx * (ay - cy) - fy * (ax - cx), fx * (by - cy) - fy * (bx - cx)
    if ((one > 0.0 and two < 0.0) or (one < 0.0 and two > 0.0)) and (
        (three > 0.0 and four < 0.0) or (three < 0.0 and four > 0.0)
    ):
        return 0.0
    best = min(_apart(ax, ay, cx, cy, dx, dy), _apart(bx, by, cx, cy, dx, dy))
    return min(best, _apart(cx, cy, ax, ay, bx, by), _apart(dx, dy, ax, ay, bx, by))


@kernel
def boundary_distances(xy: Floats, tri: Ints, nbr: Ints, a: Floats, b: Floats, holder: Ints) -> Floats:
    """For each segment a[i] b[i] its distance from the boundary; triangle ``holder[i]`` contains a[i].

    The nearest place of the boundary is in sight, so it is found through edges nearer than the best place so far.
    """
    out = np.empty(a.shape[0])
    visit = np.full(tri.shape[0], -1, dtype=np.int64)
    stack = np.empty(64, dtype=np.int64)
    for i in range(a.shape[0]):
        ax, ay, bx, by = a[i, 0], a[i, 1], b[i, 0], b[i, 1]
        best = np.inf
        stack[0] = holder[i]
        visit[holder[i]] = i
        top = 1
        while top > 0:
            top -= 1
            t = stack[top]
            for k in range(3):
                u, v = tri[t, k], tri[t, (k + 1) % 3]
                if nbr[t, k] < 0:
                    best = min(best, _between(ax, ay, bx, by, xy[u, 0], xy[u, 1], xy[v, 0], xy[v, 1]))
                else:
                    best = min(best, _apart(xy[u, 0], xy[u, 1], ax, ay, bx, by))
            for k in range(3):
                s = nbr[t, k]
                if s < 0 or visit[s] == i:
                    continue
                u, v = tri[t, k], tri[t, (k + 1) % 3]
                if _between(ax, ay, bx, by, xy[u, 0], xy[u, 1], xy[v, 0], xy[v, 1]) < best:
                    visit[s] = i
                    if top == stack.shape[0]:
                        stack = longer(stack)
                    stack[top] = s
                    top += 1
        out[i] = np.sqrt(best)
    return out


@kernel
def circumcentres(xy: Floats, tri: Ints) -> Floats:
    """Centres of the circles through the corners of triangles; nan or inf where there is none."""
    out = np.empty((tri.shape[0], 2))
    for t in range(tri.shape[0]):
        ax, ay = xy[tri[t, 0], 0], xy[tri[t, 0], 1]
        bx, by = xy[tri[t, 1], 0] - ax, xy[tri[t, 1], 1] - ay
        cx, cy = xy[tri[t, 2], 0] - ax, xy[tri[t, 2], 1] - ay
        double = 2.0 * (bx * cy - by * cx)
        b, c = bx * bx + by * by, cx * cx + cy * cy
        out[t, 0] = ax + (cy * b - by * c) / double
        out[t, 1] = ay + (bx * c - cx * b) / double
    return out


@kernel
def refined(
    xy: Floats,
    tri: Ints,
    nbr: Ints,
    side: Ints,
    narrow: Bools,
    fan: Ints,
    vertex_start: Ints,
    vertex_wedges: Ints,
    spacing: float,
    fineness: float,
    least: float,
    thinnest: float,
) -> tuple[Ints, Floats, Ints]:
    """Cut pieces of the boundary that are too long for their surroundings in two.

    Too long is: over ``spacing``; or over ``least`` and either seen at more than a right angle by the third corner of
    the triangle at it (then no circle about such a triangle is centred beyond the boundary), or longer than
    ``fineness`` times the radius of that circle or, at a corner, than ``spacing`` / 4 or 1.5 times the piece on its
    other side. Not cut is where another side of the triangle is within ``thinnest`` of the cut.

    Parameters
    ----------
    narrow : (c,) whether free space is narrower than π about each corner.

    Returns
    -------
    edges : (e, 2) all pieces, new vertices numbered from ``len(xy)``.
    points, sides : (k, 2) and (k,) the new vertices and their sides; k = 0: nothing was too long.
    """
    count = 0
    for t in range(tri.shape[0]):
        for k in range(3):
            if nbr[t, k] < 0:
                count += 1
    edges = np.empty((2 * count, 2), dtype=np.int64)
    points = np.empty((count, 2))
    sides = np.empty(count, dtype=np.int64)
    corners = narrow.shape[0]
    n, e = 0, 0
    for t in range(tri.shape[0]):
        outer, shortest = 0, np.inf
        for k in range(3):
            if nbr[t, k] < 0:
                a, b = tri[t, k], tri[t, (k + 1) % 3]
                shortest = min(shortest, np.hypot(xy[b, 0] - xy[a, 0], xy[b, 1] - xy[a, 1]))
                outer += 1
        for k in range(3):
            if nbr[t, k] >= 0:
                continue
            a, b, c = tri[t, k], tri[t, (k + 1) % 3], tri[t, (k + 2) % 3]
            ax, ay, cx, cy = xy[a, 0], xy[a, 1], xy[c, 0], xy[c, 1]
            ex, ey = xy[b, 0] - ax, xy[b, 1] - ay
            square = ex * ex + ey * ey
            length = np.sqrt(square)
            dot = (ax - cx) * (xy[b, 0] - cx) + (ay - cy) * (xy[b, 1] - cy)
            # |a b| = 2 R sin γ, and the cross product of the two sides at c is |a c| |b c| sin γ
            cross = abs((ax - cx) * (xy[b, 1] - cy) - (ay - cy) * (xy[b, 0] - cx))
            sine = cross / np.sqrt(cross * cross + dot * dot)
            uneven = length > min(1.5 * shortest, spacing / 4.0) if outer > 1 else 2.0 * sine > fineness
            long = length > least and (dot < 0.0 or uneven)
            if not (length > spacing or long):
                edges[e, 0], edges[e, 1] = a, b
                e += 1
                continue
            f = 0.5
            foot = ((cx - ax) * ex + (cy - ay) * ey) / square
            a_narrow, b_narrow = a < corners and narrow[a], b < corners and narrow[b]
            if a_narrow != b_narrow:
                # equal distances on both sides of a narrow corner: pieces there do not cut each other for ever
                f = spacing * 2.0 ** np.round(np.log2(length / (2.0 * spacing))) / length
                if b_narrow:
                    f = 1.0 - f
            elif c < corners and 0.25 <= foot <= 0.75:
                f = foot
            x, y = ax + f * ex, ay + f * ey
            gap = (x - cx) * (x - cx) + (y - cy) * (y - cy)
            if nbr[t, (k + 1) % 3] < 0:
                gap = min(gap, _apart(x, y, xy[b, 0], xy[b, 1], cx, cy))
            if nbr[t, (k + 2) % 3] < 0:
                gap = min(gap, _apart(x, y, cx, cy, ax, ay))
            if gap <= thinnest * thinnest:
                edges[e, 0], edges[e, 1] = a, b
                e += 1
                continue
            points[n, 0], points[n, 1] = x, y
            sides[n] = side[a] if side[a] >= 0 else side[b]
            if sides[n] < 0:
                for i in range(vertex_start[a], vertex_start[a + 1]):
                    if fan[vertex_wedges[i], 1] == b:
                        sides[n] = vertex_wedges[i]
            new = xy.shape[0] + n
            edges[e, 0], edges[e, 1], edges[e + 1, 0], edges[e + 1, 1] = a, new, new, b
            n += 1
            e += 2
    return edges[:e].copy(), points[:n].copy(), sides[:n].copy()


@kernel
def _room(xy: Floats, side: Ints, fan: Ints, vertex_start: Ints, vertex_wedges: Ints, a: int, b: int, c: int) -> float:
    """Least bound of the distance from vertex a, or from a side at a, along the edge from b to c."""
    bx, by, cx, cy, ax, ay = xy[b, 0], xy[b, 1], xy[c, 0], xy[c, 1], xy[a, 0], xy[a, 1]
    best = max(_apart(bx, by, ax, ay, ax, ay), _apart(cx, cy, ax, ay, ax, ay))
    if side[a] >= 0:
        u, v = fan[side[a], 0], fan[side[a], 1]
        ux, uy, vx, vy = xy[u, 0], xy[u, 1], xy[v, 0], xy[v, 1]
        best = min(best, max(_apart(bx, by, ux, uy, vx, vy), _apart(cx, cy, ux, uy, vx, vy)))
        return float(np.sqrt(best))
    for i in range(vertex_start[a], vertex_start[a + 1]):
        for k in range(1, 3):
            ux, uy = xy[fan[vertex_wedges[i], k], 0], xy[fan[vertex_wedges[i], k], 1]
            best = min(best, max(_apart(bx, by, ax, ay, ux, uy), _apart(cx, cy, ax, ay, ux, uy)))
    return float(np.sqrt(best))


@kernel
def widths(
    xy: Floats, tri: Ints, nbr: Ints, side: Ints, fan: Ints, vertex_start: Ints, vertex_wedges: Ints
) -> tuple[Floats, Floats]:
    """Upper bounds of the distance from the boundary: on each edge of each triangle (m, 3), and within each (m,).

    The distance from a side is convex: on the edge from a to b, at fraction f, that from a side at a is at most f times
    that of b, and that from a side at b at most 1 − f times that of a. Within a triangle it is greatest at a corner.
    """
    m = tri.shape[0]
    through = np.zeros((m, 3))
    within = np.empty(m)
    for t in range(m):
        within[t] = np.inf
        gates, gate = 0, 0
        for k in range(3):
            a, b, c = tri[t, k], tri[t, (k + 1) % 3], tri[t, (k + 2) % 3]
            within[t] = min(within[t], _room(xy, side, fan, vertex_start, vertex_wedges, a, b, c))
            if nbr[t, k] >= 0:
                to_b = _room(xy, side, fan, vertex_start, vertex_wedges, a, b, b)
                to_a = _room(xy, side, fan, vertex_start, vertex_wedges, b, a, a)
                through[t, k] = to_a * to_b / (to_a + to_b) if to_a > 0.0 and to_b > 0.0 else 0.0
                gates += 1
                gate = k
        if gates == 1:
            # the distances from the other two edges grow from the corner between them towards the one that is open
            within[t] = min(within[t], through[t, gate])
    return through, within
