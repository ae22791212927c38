"""Closed-form distances of moving and resting points: the arithmetic of the certificate.

Every distance a kernel returns is measured at a real instant and place of the motion (or is an upper bound within
rounding of it), so a fault is never invented; the case analysis makes sure that none is missed.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from taut.compiling import kernel

Floats = NDArray[np.float64]
Ints = NDArray[np.int64]
Flags = NDArray[np.bool_]


@kernel
def _to_segment(px: float, py: float, ax: float, ay: float, bx: float, by: float) -> tuple[float, float]:
    """Squared distance from p to the segment ab, and where on it (0 … 1)."""
    rx, ry = bx - ax, by - ay
    qx, qy = px - ax, py - ay
    along = qx * rx + qy * ry
    if along <= 0.0:
        return qx * qx + qy * qy, 0.0
    rr = rx * rx + ry * ry
    if along >= rr:
        qx, qy = px - bx, py - by
        return qx * qx + qy * qy, 1.0
    s = along / rr
    qx, qy = qx - s * rx, qy - s * ry
    return qx * qx + qy * qy, s


@kernel
def _between_segments(
    ax: float, ay: float, bx: float, by: float, cx: float, cy: float, dx: float, dy: float
) -> tuple[float, float]:
    """Squared distance between the segments ab and cd, and where on ab (0 … 1)."""
    best, at = _to_segment(ax, ay, cx, cy, dx, dy)[0], 0.0
    d2 = _to_segment(bx, by, cx, cy, dx, dy)[0]
    if d2 < best:
        best, at = d2, 1.0
    d2, s = _to_segment(cx, cy, ax, ay, bx, by)
    if d2 < best:
        best, at = d2, s
    d2, s = _to_segment(dx, dy, ax, ay, bx, by)
    if d2 < best:
        best, at = d2, s
    rx, ry, qx, qy = bx - ax, by - ay, dx - cx, dy - cy
    cross = rx * qy - ry * qx
    if cross != 0.0:
        s = ((cx - ax) * qy - (cy - ay) * qx) / cross
        u = ((cx - ax) * ry - (cy - ay) * rx) / cross
        if 0.0 <= s <= 1.0 and 0.0 <= u <= 1.0:
            # Measured, not taken as zero: on nearly parallel segments rounding can put s and u anywhere.
            d2 = _to_segment(ax + s * rx, ay + s * ry, cx, cy, dx, dy)[0]
            if d2 < best:
                best, at = d2, s
    return best, at


@kernel
def _inside(px: float, py: float, edges: Floats) -> bool:
    """Whether p is inside the rings made of the edges (even-odd); right unless p is within rounding of an edge."""
    inside = False
    for k in range(edges.shape[0]):
        y0, y1 = edges[k, 1], edges[k, 3]
        if (y0 > py) != (y1 > py):
            x0 = edges[k, 0]
            if px < x0 + (py - y0) / (y1 - y0) * (edges[k, 2] - x0):
                inside = not inside
    return inside


@kernel
def _to_edges(px: float, py: float, edges: Floats) -> float:
    best = np.inf
    for k in range(edges.shape[0]):
        d2 = _to_segment(px, py, edges[k, 0], edges[k, 1], edges[k, 2], edges[k, 3])[0]
        best = min(best, d2)
    return float(np.sqrt(best))


@kernel
def _within(edges: Floats, x0: float, y0: float, x1: float, y1: float) -> Floats:
    """Those edges whose bounds meet the box, (k, 4)."""
    count = 0
    for k in range(edges.shape[0]):
        cy, dy = edges[k, 1], edges[k, 3]
        if min(cy, dy) <= y1 and max(cy, dy) >= y0:
            cx, dx = edges[k, 0], edges[k, 2]
            if min(cx, dx) <= x1 and max(cx, dx) >= x0:
                count += 1
    out = np.empty((count, 4), dtype=np.float64)
    count = 0
    for k in range(edges.shape[0]):
        cx, cy, dx, dy = edges[k, 0], edges[k, 1], edges[k, 2], edges[k, 3]
        if min(cy, dy) <= y1 and max(cy, dy) >= y0 and min(cx, dx) <= x1 and max(cx, dx) >= x0:
            out[count, 0], out[count, 1], out[count, 2], out[count, 3] = cx, cy, dx, dy
            count += 1
    return out


@kernel
def _splits(ax: float, ay: float, bx: float, by: float, edges: Floats, reach: float) -> Floats:
    """Where the leg ab meets, or comes nearest to, the edges within reach of it: sorted, with 0 and 1."""
    near = np.empty(edges.shape[0], dtype=np.int64)
    count = 0
    x0 = min(ax, bx) - reach
    x1 = max(ax, bx) + reach
    for k in range(edges.shape[0]):
        cx, cy, dx, dy = edges[k, 0], edges[k, 1], edges[k, 2], edges[k, 3]
        if min(cx, dx) > x1 or max(cx, dx) < x0:
            continue
        if _between_segments(ax, ay, bx, by, cx, cy, dx, dy)[0] <= reach * reach:
            near[count] = k
            count += 1
    out = np.empty(2 + 4 * count, dtype=np.float64)
    out[0], out[1] = 0.0, 1.0
    size = 2
    rx, ry = bx - ax, by - ay
    for n in range(count):
        k = near[n]
        cx, cy, dx, dy = edges[k, 0], edges[k, 1], edges[k, 2], edges[k, 3]
        out[size] = _between_segments(ax, ay, bx, by, cx, cy, dx, dy)[1]
        out[size + 1] = _to_segment(cx, cy, ax, ay, bx, by)[1]
        out[size + 2] = _to_segment(dx, dy, ax, ay, bx, by)[1]
        size += 3
        qx, qy = dx - cx, dy - cy
        cross = rx * qy - ry * qx
        if cross != 0.0:
            s = ((cx - ax) * qy - (cy - ay) * qx) / cross
            if 0.0 < s < 1.0:
                out[size] = s
                size += 1
    for n in range(1, size):  # by insertion: few, and np.sort takes longer to compile than all the rest
        s = out[n]
        k = n
        while k > 0 and out[k - 1] > s:
            out[k] = out[k - 1]
            k -= 1
        out[k] = s
    return out[:size]


@kernel
def _deepest(
    ax: float, ay: float, bx: float, by: float, edges: Floats, forbidden: bool, tol: float,
    floor: float,
) -> tuple[float, float]:  # fmt: skip
    """Greatest depth (> floor ≥ tol) of the leg ab in a forbidden region, and where on ab; (0, 0) if nowhere so deep.

    The region is the inside (``forbidden`` true) or the outside (false) of the rings made of the edges. Depth is the
    distance to the rings. Branch and bound: on a part of the leg the depth is at most the mean of its ends plus half
    the length (it is 1-Lipschitz), and at most the larger end distance to any single edge (that is convex).
    """
    length = np.hypot(bx - ax, by - ay)
    x0, x1, y0, y1 = min(ax, bx) - tol, max(ax, bx) + tol, min(ay, by) - tol, max(ay, by) + tol
    beside = _within(edges, x0, y0, np.inf, y1)  # all that a ray to the right from the leg can meet
    splits = _splits(ax, ay, bx, by, beside, tol)
    best, at = floor, -1.0
    close = edges[:0]  # all that can be nearest to a place on the leg; gathered when first needed
    low = np.empty(256, dtype=np.float64)
    high = np.empty(256, dtype=np.float64)
    for n in range(splits.size - 1):
        s0, s1 = splits[n], splits[n + 1]
        if s1 <= s0 or ((s1 - s0) * length <= tol / 4 and splits.size > 2):
            continue
        touched = False
        for q in range(5):
            s = s0 + (s1 - s0) * q / 4
            px, py = ax + s * (bx - ax), ay + s * (by - ay)
            if (splits.size == 2 or 0 < q < 4) and _inside(px, py, beside) == forbidden:
                touched = True
                if close.shape[0] == 0:
                    reach = _to_edges(px, py, edges) + length + tol
                    close = _within(edges, x0 - reach, y0 - reach, x1 + reach, y1 + reach)
                d = _to_edges(px, py, close)
                if d > best:
                    best, at = d, s
            elif splits.size == 2:
                break  # one piece that meets no edge is on one side
            if length == 0.0:
                break
        if not touched or length == 0.0:
            continue
        low[0], high[0] = s0, s1
        size = 1
        while size > 0:
            size -= 1
            s0, s1 = low[size], high[size]
            ux, uy = ax + s0 * (bx - ax), ay + s0 * (by - ay)
            wx, wy = ax + s1 * (bx - ax), ay + s1 * (by - ay)
            d0, d1, either = np.inf, np.inf, np.inf
            for k in range(close.shape[0]):
                e0 = _to_segment(ux, uy, close[k, 0], close[k, 1], close[k, 2], close[k, 3])[0]
                e1 = _to_segment(wx, wy, close[k, 0], close[k, 1], close[k, 2], close[k, 3])[0]
                d0, d1, either = min(d0, e0), min(d1, e1), min(either, max(e0, e1))
            span = (s1 - s0) * length
            bound = min((np.sqrt(d0) + np.sqrt(d1) + span) / 2, np.sqrt(either))
            if bound <= best * (1.0 + 1e-6) + tol / 16:
                continue
            s = (s0 + s1) / 2
            px, py = ax + s * (bx - ax), ay + s * (by - ay)
            d = _to_edges(px, py, close)
            if _inside(px, py, beside) == forbidden:
                if d > best:
                    best, at = d, s
            elif d >= span / 2:
                continue  # a free ball round the middle covers the whole part
            if span > tol / 8 and size + 2 <= low.size:
                low[size], high[size] = s0, s
                low[size + 1], high[size + 1] = s, s1
                size += 2
    if at < 0.0:
        return 0.0, 0.0
    return best, at


@kernel
def deepest_legs(
    x: Floats, y: Floats, first: Ints, robots: Ints, edges: Floats, forbidden: bool, tol: float
) -> tuple[Floats, Ints, Floats]:
    """Greatest depth of each chosen robot's path in a region: depth (0 up to tol), stamp index, place on the leg.

    The region is the inside (``forbidden`` true) or the outside (false) of the rings made of ``edges`` (E, 4).
    """
    depth = np.zeros(robots.size, dtype=np.float64)
    leg = np.zeros(robots.size, dtype=np.int64)
    where = np.zeros(robots.size, dtype=np.float64)
    for n in range(robots.size):
        start, end = first[robots[n]], first[robots[n] + 1]
        for a in range(start, max(start + 1, end - 1)):
            b = min(a + 1, end - 1)
            d, s = _deepest(x[a], y[a], x[b], y[b], edges, forbidden, tol, max(tol, depth[n]))
            if d > depth[n]:
                depth[n], leg[n], where[n] = d, a, s
    return depth, leg, where


OPEN, FILLED, OUTSIDE = 0, 1, 2


@kernel
def least_clearances(
    x: Floats, y: Floats, first: Ints, edges: Floats, edge_first: Ints, boxes: Floats, own_radius: Floats,
    kind: Ints, tol: float,
) -> tuple[Floats, Ints, Ints, Floats]:  # fmt: skip
    """Least signed distance of each robot's path (its centre) to the shapes; negative is minus the depth inside.

    Parameters
    ----------
    x, y, first : stamps of robot r at first[r]:first[r+1], metres.
    edges, edge_first : (E, 4) sides x0, y0, x1, y1 of shape o at edge_first[o]:edge_first[o+1].
    boxes : (m, 4) xmin, ymin, xmax, ymax of the sides of each shape.
    own_radius : (m,) metres by which a shape reaches beyond its sides.
    kind : (m,) OPEN (chain or point), FILLED (ring with its inside) or OUTSIDE (the outside of a ring).

    Returns
    -------
    value, shape, stamp, where : (n,) metres, index of the shape, stamp the leg starts at, place on the leg (0 … 1).
    """
    n = first.size - 1
    value = np.full(n, np.inf)
    shape = np.zeros(n, dtype=np.int64)
    stamp = np.zeros(n, dtype=np.int64)
    where = np.zeros(n, dtype=np.float64)
    for r in range(n):
        start, end = first[r], first[r + 1]
        for a in range(start, max(start + 1, end - 1)):
            b = min(a + 1, end - 1)
            ax, ay, bx, by = x[a], y[a], x[b], y[b]
            x0, x1, y0, y1 = min(ax, bx), max(ax, bx), min(ay, by), max(ay, by)
            for o in range(kind.size - 1, -1, -1):
                apart = 0.0
                if kind[o] != OUTSIDE:
                    gx = max(0.0, boxes[o, 0] - x1, x0 - boxes[o, 2])
                    gy = max(0.0, boxes[o, 1] - y1, y0 - boxes[o, 3])
                    apart = gx * gx + gy * gy
                    if apart > 0.0 or kind[o] == OPEN:
                        reach = value[r] + own_radius[o]
                        if reach <= 0.0 or apart >= reach * reach:
                            continue
                lo, hi = edge_first[o], edge_first[o + 1]
                d2, at = np.inf, 0.0
                for k in range(lo, hi):
                    e2, s = _between_segments(ax, ay, bx, by, edges[k, 0], edges[k, 1], edges[k, 2], edges[k, 3])
                    if e2 < d2:
                        d2, at = e2, s
                d = np.sqrt(d2) - own_radius[o]
                if apart == 0.0 and kind[o] != OPEN:
                    forbidden = kind[o] == FILLED
                    if d <= tol or _inside(ax, ay, edges[lo:hi]) == forbidden:
                        depth, s = _deepest(ax, ay, bx, by, edges[lo:hi], forbidden, tol, max(tol, -value[r]))
                        if depth > 0.0:
                            d, at = -depth, s
                if d < value[r]:
                    value[r], shape[r], stamp[r], where[r] = d, o, a, at
    return value, shape, stamp, where


@kernel
def signed_distances(px: float, py: float, edges: Floats, edge_first: Ints, own_radius: Floats, kind: Ints) -> Floats:
    """Signed distance of one point to every shape, (m,) metres; the shapes as in `least_clearances`."""
    out = np.empty(kind.size, dtype=np.float64)
    for o in range(kind.size):
        own = edges[edge_first[o] : edge_first[o + 1]]
        d = _to_edges(px, py, own)
        if kind[o] != OPEN and _inside(px, py, own) == (kind[o] == FILLED):
            d = -d
        out[o] = d - own_radius[o]
    return out


@kernel
def _to_origin(ax: float, ay: float, bx: float, by: float) -> tuple[float, float]:
    """Squared distance from the origin to the segment ab, and where on it (0 … 1)."""
    return _to_segment(0.0, 0.0, ax, ay, bx, by)


@kernel
def _pair(
    i: int, j: int, t: Floats, x: Floats, y: Floats, vx: Floats, vy: Floats, first: Ints, stays: Flags
) -> tuple[float, float, float]:
    """Least squared distance of two robots while both are present, and when (the same instant for both)."""
    a, b = first[i], first[j]
    last_a, last_b = first[i + 1] - 1, first[j + 1] - 1
    now = 0.0
    wx, wy = x[a] - x[b], y[a] - y[b]
    best, when = wx * wx + wy * wy, 0.0
    while (a < last_a or stays[i]) and (b < last_b or stays[j]) and (a < last_a or b < last_b):
        ta = t[a + 1] if a < last_a else np.inf
        tb = t[b + 1] if b < last_b else np.inf
        then = min(ta, tb)
        if ta == then:
            a += 1
            xa, ya = x[a], y[a]
        else:
            xa, ya = x[a] + vx[a] * (then - t[a]), y[a] + vy[a] * (then - t[a])
        if tb == then:
            b += 1
            xb, yb = x[b], y[b]
        else:
            xb, yb = x[b] + vx[b] * (then - t[b]), y[b] + vy[b] * (then - t[b])
        ux, uy = xa - xb, ya - yb
        d2, s = _to_origin(wx, wy, ux, uy)
        if d2 < best:
            best, when = d2, now + s * (then - now)
        wx, wy, now = ux, uy, then
    return best, when, when


@kernel
def _pair_headway(
    i: int, j: int, t: Floats, x: Floats, y: Floats, vx: Floats, vy: Floats, first: Ints, stays: Flags, h: float
) -> tuple[float, float, float]:
    """Least squared distance of p_i(t) and p_j(u) over |t - u| ≤ h while both are present, with t and u.

    For two legs the relative position is linear in (t, u) on the rectangle of the legs cut by the strip |t - u| ≤ h:
    the least distance is at its zero, if that lies inside, or on one of the (at most six) sides of that polygon.
    Times are taken from the start of j's leg, so that late legs lose no digits.
    """
    last_a, last_b = first[i + 1] - 1, first[j + 1] - 1
    best, when, other = np.inf, 0.0, 0.0
    from_b = first[j]
    for a in range(first[i], last_a + 1):
        if a == last_a and not stays[i]:
            break
        t0 = t[a]
        t1 = t[a + 1] if a < last_a else np.inf
        while from_b < last_b and t[from_b + 1] < t0 - h:
            from_b += 1
        for b in range(from_b, last_b + 1):
            u0 = t[b]
            if (b == last_b and not stays[j]) or u0 > t1 + h:
                break
            u1 = t[b + 1] if b < last_b else np.inf
            offset = t0 - u0
            if t1 == np.inf and u1 == np.inf:
                wx, wy = x[a] - x[b], y[a] - y[b]
                d2 = wx * wx + wy * wy
                if d2 < best:
                    best, when, other = d2, max(t0, u0), max(t0, u0)
                continue
            p0, p1 = max(offset, -h), min(t1 - u0, u1 - u0 + h)
            q0, q1 = max(0.0, p0 - h), min(u1 - u0, p1 + h)
            if p0 > p1 or q0 > q1:
                continue
            ax, ay, bx, by = vx[a], vy[a], vx[b], vy[b]
            for k in range(6):
                # side k of the polygon, from (pa, qa) to (pb, qb)
                if k < 2:
                    pa = pb = p0 if k == 0 else p1
                    qa, qb = max(q0, pa - h), min(q1, pa + h)
                elif k < 4:
                    qa = qb = q0 if k == 2 else q1
                    pa, pb = max(p0, qa - h), min(p1, qa + h)
                else:
                    shift = h if k == 4 else -h
                    pa, pb = max(p0, q0 - shift), min(p1, q1 - shift)
                    qa, qb = pa + shift, pb + shift
                if pa > pb or qa > qb:
                    continue
                d2, s = _to_origin(
                    x[a] + ax * (pa - offset) - (x[b] + bx * qa), y[a] + ay * (pa - offset) - (y[b] + by * qa),
                    x[a] + ax * (pb - offset) - (x[b] + bx * qb), y[a] + ay * (pb - offset) - (y[b] + by * qb),
                )  # fmt: skip
                if d2 < best:
                    best, when, other = d2, u0 + pa + s * (pb - pa), u0 + qa + s * (qb - qa)
            cross = ax * by - ay * bx
            if cross != 0.0:
                cx, cy = x[a] - ax * offset - x[b], y[a] - ay * offset - y[b]
                p, q = -(cx * by - cy * bx) / cross, (ax * cy - ay * cx) / cross
                if p0 <= p <= p1 and q0 <= q <= q1 and abs(p - q) <= h:
                    wx = x[a] + ax * (p - offset) - (x[b] + bx * q)
                    wy = y[a] + ay * (p - offset) - (y[b] + by * q)
                    d2 = wx * wx + wy * wy
                    if d2 < best:
                        best, when, other = d2, u0 + p, u0 + q
    return best, when, other


@kernel
def least_separations(
    t: Floats, x: Floats, y: Floats, vx: Floats, vy: Floats, first: Ints, stays: Flags, present: Flags,
    boxes: Floats, radius: Floats, gap: float, headway: float, tol: float,
) -> tuple[Ints, Floats]:  # fmt: skip
    """Find the nearest pair of robots over all time, and every pair nearer than allowed.

    Parameters
    ----------
    t, x, y, vx, vy, first : stamps and velocities of robot r at first[r]:first[r+1], up to its arrival.
    stays, present : (n,) whether a robot rests at its last stamp for ever; whether it is there at all.
    boxes : (n, 4) xmin, ymin, xmax, ymax of each robot's stamps.

    Returns
    -------
    pairs : (1 + k, 2) robots of the nearest pair (-1, -1: none), then of the k pairs with less than gap - tol.
    rows : (1 + k, 3) free room between the discs in metres, time of the first robot, time of the second.
    """
    n = first.size - 1
    pairs = np.empty((16, 2), dtype=np.int64)
    rows = np.empty((16, 3), dtype=np.float64)
    size = 1
    least, least_when, least_other = np.inf, 0.0, 0.0
    least_i, least_j = -1, -1
    for i in range(n):
        if not present[i]:
            continue
        for j in range(i + 1, n):
            if not present[j]:
                continue
            both = radius[i] + radius[j]
            gx = max(0.0, boxes[i, 0] - boxes[j, 2], boxes[j, 0] - boxes[i, 2])
            gy = max(0.0, boxes[i, 1] - boxes[j, 3], boxes[j, 1] - boxes[i, 3])
            matters = both + max(least, gap)
            if gx * gx + gy * gy > matters * matters:
                continue
            if headway > 0.0:
                d2, when, other = _pair_headway(i, j, t, x, y, vx, vy, first, stays, headway)
            else:
                d2, when, other = _pair(i, j, t, x, y, vx, vy, first, stays)
            free = np.sqrt(d2) - both
            if free < least:
                least, least_when, least_other = free, when, other
                least_i, least_j = i, j
            if not free >= gap - tol:
                if size == pairs.shape[0]:
                    pairs = np.concatenate((pairs, np.empty_like(pairs)))
                    rows = np.concatenate((rows, np.empty_like(rows)))
                pairs[size, 0], pairs[size, 1] = i, j
                rows[size, 0], rows[size, 1], rows[size, 2] = free, when, other
                size += 1
    pairs[0, 0], pairs[0, 1] = least_i, least_j
    rows[0, 0], rows[0, 1], rows[0, 2] = least, least_when, least_other
    return pairs[:size], rows[:size]
