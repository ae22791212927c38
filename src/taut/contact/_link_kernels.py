"""When pairs of robots are in contact: closed form on each stretch of time in which both move steadily.

On such a stretch s runs from 0 to 1, and the robots from a0 to a1 and from b0 to b1. Within reach they are between two
roots of a quadratic. A side cd hides them from each other or not, and that changes only when c or d comes onto the line
ab (a quadratic) or a or b onto the line cd (linear in s); between two such instants the middle decides.
"""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from taut.arrays import higher, longer
from taut.compiling import kernel

Floats = NDArray[np.float64]
Ints = NDArray[np.int64]

GROUP = 16
"""Sides that share a box."""


@kernel
def contact_spans(
    t: Floats, x: Floats, y: Floats, first: Ints, gone: Floats, pairs: Ints, reach: float, sides: Floats,
    boxes: Floats,
) -> tuple[Ints, Floats]:  # fmt: skip
    """When each pair is in contact: the number of the pair (l,) and [begin, end] (l, 2), pair after pair, in order.

    Parameters
    ----------
    t, x, y : stamps of robot r at first[r]:first[r+1]; it rests at the last.
    gone : (n,) when a robot leaves, inf if it does not.
    pairs : (p, 2).
    sides : (E, 4) what hides robots from each other.
    boxes : (ceil(E / GROUP), 4) xmin, ymin, xmax, ymax of each GROUP of sides.
    """
    who = np.empty(16, dtype=np.int64)
    spans = np.empty((16, 2), dtype=np.float64)
    hidden = np.empty((16, 2), dtype=np.float64)
    count = 0
    for p in range(pairs.shape[0]):
        own = count
        i, j = pairs[p, 0], pairs[p, 1]
        until = min(gone[i], gone[j])
        ki, kj = first[i], first[j]
        t0, a0x, a0y, b0x, b0y = 0.0, x[ki], y[ki], x[kj], y[kj]
        while t0 < until:
            t1 = until
            if ki + 1 < first[i + 1]:
                t1 = min(t1, t[ki + 1])
            if kj + 1 < first[j + 1]:
                t1 = min(t1, t[kj + 1])
            a1x, a1y = _place(t, x, y, first[i + 1] - 1, ki, t1)
            b1x, b1y = _place(t, x, y, first[j + 1] - 1, kj, t1)
            s0, s1 = _within(a0x - b0x, a0y - b0y, a1x - b1x, a1y - b1y, reach)
            if s0 < s1:
                n = 0
                if sides.shape[0] > 0:
                    n, hidden = _hidden(a0x, a0y, b0x, b0y, a1x, a1y, b1x, b1y, s0, s1, sides, boxes, hidden)
                for h in range(n + 1):  # what is left between the hidden parts
                    end = hidden[h, 0] if h < n else s1
                    if end > s0:
                        begins, ends = _time(t0, t1, s0), _time(t0, t1, end)
                        if count > own and spans[count - 1, 1] == begins:
                            spans[count - 1, 1] = ends
                        elif ends > begins:
                            if count == spans.shape[0]:
                                who, spans = longer(who), higher(spans)
                            who[count], spans[count, 0], spans[count, 1] = p, begins, ends
                            count += 1
                    if h < n:
                        s0 = max(s0, hidden[h, 1])
            if ki + 1 < first[i + 1] and t[ki + 1] == t1:
                ki += 1
            if kj + 1 < first[j + 1] and t[kj + 1] == t1:
                kj += 1
            t0, a0x, a0y, b0x, b0y = t1, a1x, a1y, b1x, b1y
    return who[:count].copy(), spans[:count].copy()


@kernel
def distances(
    t: Floats, x: Floats, y: Floats, first: Ints, pairs: Ints, begin: float, end: float
) -> tuple[Floats, Floats]:
    """Least and greatest distance of each pair in a stretch of time, (p,) each; arguments as `contact_spans`."""
    least = np.empty(pairs.shape[0], dtype=np.float64)
    greatest = np.empty(pairs.shape[0], dtype=np.float64)
    for p in range(pairs.shape[0]):
        i, j = pairs[p, 0], pairs[p, 1]
        ki, kj = _leg(t, first[i], first[i + 1], begin), _leg(t, first[j], first[j + 1], begin)
        t0 = begin
        ax, ay = _place(t, x, y, first[i + 1] - 1, ki, begin)
        bx, by = _place(t, x, y, first[j + 1] - 1, kj, begin)
        px, py = ax - bx, ay - by
        least[p] = greatest[p] = math.hypot(px, py)
        while t0 < end:
            t1 = end
            if ki + 1 < first[i + 1]:
                t1 = min(t1, t[ki + 1])
            if kj + 1 < first[j + 1]:
                t1 = min(t1, t[kj + 1])
            ax, ay = _place(t, x, y, first[i + 1] - 1, ki, t1)
            bx, by = _place(t, x, y, first[j + 1] - 1, kj, t1)
            qx, qy = ax - bx, ay - by
            least[p] = min(least[p], _nearest(px, py, qx, qy))
            greatest[p] = max(greatest[p], math.hypot(qx, qy))
            if ki + 1 < first[i + 1] and t[ki + 1] == t1:
                ki += 1
            if kj + 1 < first[j + 1] and t[kj + 1] == t1:
                kj += 1
            t0, px, py = t1, qx, qy
    return least, greatest


@kernel
def _leg(t: Floats, first: int, end: int, time: float) -> int:
    """Stamp at which the leg begins that a time lies on."""
    low, high = first, end
    while high - low > 1:
        middle = (low + high) // 2
        if t[middle] <= time:
            low = middle
        else:
            high = middle
    return low


@kernel
def _nearest(px: float, py: float, qx: float, qy: float) -> float:
    """Distance of the origin from the segment pq."""
    vx, vy = qx - px, qy - py
    v = math.hypot(vx, vy)
    if v > 0.0 and px * vx + py * vy < 0.0 < qx * vx + qy * vy:
        return abs(px * vy - py * vx) / v
    return min(math.hypot(px, py), math.hypot(qx, qy))


@kernel
def _place(t: Floats, x: Floats, y: Floats, last: int, k: int, time: float) -> tuple[float, float]:
    """Where a robot is at a time on the leg that begins at its stamp k."""
    if k == last:
        return x[k], y[k]
    if time == t[k + 1]:
        return x[k + 1], y[k + 1]
    s = (time - t[k]) / (t[k + 1] - t[k])
    return x[k] + s * (x[k + 1] - x[k]), y[k] + s * (y[k + 1] - y[k])


@kernel
def _time(t0: float, t1: float, s: float) -> float:
    if s <= 0.0:
        return t0
    if s >= 1.0:
        return t1
    return min(t0 + s * (t1 - t0), t1)


@kernel
def _within(px: float, py: float, qx: float, qy: float, reach: float) -> tuple[float, float]:
    """Where on the way from p to q the origin is within reach, [s0, s1]; (1, 0) if nowhere."""
    if min(px, qx) > reach or max(px, qx) < -reach or min(py, qy) > reach or max(py, qy) < -reach:
        return 1.0, 0.0
    p, q = math.hypot(px, py), math.hypot(qx, qy)
    if p <= reach and q <= reach:
        return 0.0, 1.0
    vx, vy = qx - px, qy - py
    v = math.hypot(vx, vy)
    b = px * vx + py * vy
    if p > reach and (b >= 0.0 or (q > reach and qx * vx + qy * vy <= 0.0)):
        return 1.0, 0.0
    aside = abs(px * vy - py * vx)
    square = (reach * v - aside) * (reach * v + aside)
    if square < 0.0:
        if p > reach and q > reach:
            return 1.0, 0.0
        square = 0.0
    root = math.sqrt(square)
    s0, s1 = 0.0, 1.0
    if p > reach:  # then b < 0
        s0 = min(max((p - reach) * (p + reach) / (root - b), 0.0), 1.0)
    if q > reach:
        s1 = (root - b) / (v * v) if b <= 0.0 else (reach - p) * (reach + p) / (root + b)
        s1 = min(max(s1, s0), 1.0)
    return s0, s1


@kernel
def _hidden(
    a0x: float, a0y: float, b0x: float, b0y: float, a1x: float, a1y: float, b1x: float, b1y: float, s0: float,
    s1: float, sides: Floats, boxes: Floats, out: Floats,
) -> tuple[int, Floats]:  # fmt: skip
    """Where in [s0, s1] a side lies between a and b: so many parts, in order, at the beginning of the table."""
    vax, vay, vbx, vby = a1x - a0x, a1y - a0y, b1x - b0x, b1y - b0y
    left = min(a0x + s0 * vax, a0x + s1 * vax, b0x + s0 * vbx, b0x + s1 * vbx)
    right = max(a0x + s0 * vax, a0x + s1 * vax, b0x + s0 * vbx, b0x + s1 * vbx)
    low = min(a0y + s0 * vay, a0y + s1 * vay, b0y + s0 * vby, b0y + s1 * vby)
    high = max(a0y + s0 * vay, a0y + s1 * vay, b0y + s0 * vby, b0y + s1 * vby)
    at = np.empty(8, dtype=np.float64)
    count = 0
    for g in range(boxes.shape[0]):
        if boxes[g, 0] > right or boxes[g, 2] < left or boxes[g, 1] > high or boxes[g, 3] < low:
            continue
        for e in range(g * GROUP, min((g + 1) * GROUP, sides.shape[0])):
            cx, cy, dx, dy = sides[e, 0], sides[e, 1], sides[e, 2], sides[e, 3]
            if min(cx, dx) > right or max(cx, dx) < left or min(cy, dy) > high or max(cy, dy) < low:
                continue
            a0, a1 = _turn(cx, cy, dx, dy, a0x, a0y), _turn(cx, cy, dx, dy, a1x, a1y)
            b0, b1 = _turn(cx, cy, dx, dy, b0x, b0y), _turn(cx, cy, dx, dy, b1x, b1y)
            if (a0 > 0 and a1 > 0 and b0 > 0 and b1 > 0) or (a0 < 0 and a1 < 0 and b0 < 0 and b1 < 0):
                continue
            at[0], at[1] = s0, s1
            n = _insert(at, 2, a0 / (a0 - a1))
            n = _insert(at, n, b0 / (b0 - b1))
            for k in range(2):
                ex, ey = (cx, cy) if k == 0 else (dx, dy)
                r0, r1 = _on_line(a0x - ex, a0y - ey, b0x - ex, b0y - ey, vax, vay, vbx, vby)
                n = _insert(at, n, r0)
                n = _insert(at, n, r1)
            for k in range(n - 1):
                s = (at[k] + at[k + 1]) / 2
                ax, ay, bx, by = a0x + s * vax, a0y + s * vay, b0x + s * vbx, b0y + s * vby
                if at[k] < at[k + 1] and _meet(ax, ay, bx, by, cx, cy, dx, dy):
                    if count == out.shape[0]:
                        out = higher(out)
                    m = count  # by insertion: few, and nearly in order
                    while m > 0 and out[m - 1, 0] > at[k]:
                        out[m, 0], out[m, 1] = out[m - 1, 0], out[m - 1, 1]
                        m -= 1
                    out[m, 0], out[m, 1] = at[k], at[k + 1]
                    count += 1
    return count, out


@kernel
def _insert(at: Floats, n: int, s: float) -> int:
    """Put s into the first n numbers, ascending, if it lies between the first and the last of them; the new n."""
    if not at[0] < s < at[n - 1]:  # not a number, too
        return n
    k = n
    while at[k - 1] > s:
        at[k] = at[k - 1]
        k -= 1
    at[k] = s
    return n + 1


@kernel
def _turn(ax: float, ay: float, bx: float, by: float, cx: float, cy: float) -> float:
    """Twice the signed area of abc."""
    return (bx - ax) * (cy - ay) - (by - ay) * (cx - ax)


@kernel
def _on_line(
    px: float, py: float, qx: float, qy: float, vx: float, vy: float, wx: float, wy: float
) -> tuple[float, float]:
    """When the origin is on the line through p + s v and q + s w: the two roots s, not finite if there are none.

    The discriminant has two forms, equal by the identity (p×q)(v×w) = (p×v)(q×w) + (p×w)(v×q); the one whose parts
    are smaller loses less.
    """
    c, a = px * qy - py * qx, vx * wy - vy * wx
    m, n = px * wy - py * wx, vx * qy - vy * qx
    e, f = px * vy - py * vx, qx * wy - qy * wx
    b = m + n
    square = b * b - 4.0 * a * c
    if (m - n) * (m - n) + 4.0 * abs(e * f) < b * b + 4.0 * abs(a * c):
        square = (m - n) * (m - n) - 4.0 * e * f
    if not square >= 0.0:
        return np.nan, np.nan
    root = math.sqrt(square)
    half = -0.5 * (b + root if b > 0.0 else b - root)
    return half / a, c / half


@kernel
def _meet(ax: float, ay: float, bx: float, by: float, cx: float, cy: float, dx: float, dy: float) -> bool:
    """Whether the closed segments ab and cd meet."""
    if max(ax, bx) < min(cx, dx) or max(cx, dx) < min(ax, bx) or max(ay, by) < min(cy, dy) or max(cy, dy) < min(ay, by):
        return False
    c, d = _turn(ax, ay, bx, by, cx, cy), _turn(ax, ay, bx, by, dx, dy)
    if (c > 0 and d > 0) or (c < 0 and d < 0):
        return False
    a, b = _turn(cx, cy, dx, dy, ax, ay), _turn(cx, cy, dx, dy, bx, by)
    return not ((a > 0 and b > 0) or (a < 0 and b < 0))
