"""Kernels of waiting: how far each robot may go on along its plan while others are late on theirs."""

from __future__ import annotations

from math import inf, sqrt
from typing import NamedTuple

import numpy as np

from taut.arrays import Floats, Ints, higher
from taut.compiling import kernel
from taut.team._lean import lean_kernel

# Robot A has come as far as its plan has it at time s, robot B as at time t. On a leg a of A and a leg b of B they
# differ by z = w + u E − f L: w the difference of the legs' first stamps, E and L the legs, u and f the fractions done.
# The pairs (u, f) of the unit square with |z| < d are convex: an ellipse, or a strip, cut with the square. Every end of
# such a set is one root of a quadratic; its discriminant is a product, which keeps its digits where robots touch.

_STILL = 1e-280  # m²: a displacement whose square is below counts as rest, since |e|² would lose digits to underflow


class Waits(NamedTuple):
    """Motions and who waits for whom where; K waits, those of robot i at start[i]:start[i+1] by rising ``since``.

    Wait k: its robot must not go beyond ``since[k]`` before robot ``holder[k]`` has reached ``until[k]``; from then on
    it may follow, always outside the distance kept, and from ``over[k]`` on the wait is over. All plan times, seconds.

    Parameters
    ----------
    t, x, y : (S,) stamps of robot i at first[i]:first[i+1], up to its arrival, seconds and metres.
    first : (n + 1,).
    start : (n + 1,).
    holder : (K,) who passes first.
    leg, own : (K,) stamps at which the holder's leg and the waiting robot's begin.
    since, until, over : (K,) seconds.
    apart : (K,) metres that the two keep between their centres.
    """

    t: Floats
    x: Floats
    y: Floats
    first: Ints
    start: Ints
    holder: Ints
    leg: Ints
    own: Ints
    since: Floats
    until: Floats
    over: Floats
    apart: Floats


class Pending(NamedTuple):
    """Waits that are not over yet, as linked lists: head[robot], then following[wait]; −1 ends a list."""

    head: Ints
    following: Ints


@lean_kernel
def bounds(waits: Waits, pending: Pending, progress: Floats, out: Floats, held_by: Ints) -> None:
    """Find how far each robot may go on now, and whom it waits for there; inf and −1 if for nobody.

    Parameters
    ----------
    pending : waits that are over are taken out of it, so from call to call no progress may fall.
    progress : (n,) plan time that each robot has reached, seconds.
    out : (n,) plan time to which each may go as long as nobody else moves; more when others do.
    held_by : (n,) robots.

    Notes
    -----
    The bounds hold however the robots move at the same time, each up to its own: they are found from where the others
    are, and grow as these go on. Allocates nothing; a call looks at those waits that are near, each of the others once.
    """
    for i in range(out.size):
        best, who, before = inf, -1, -1
        k = pending.head[i]
        while k >= 0 and waits.since[k] < best:
            after = pending.following[k]
            j = waits.holder[k]
            if progress[j] >= waits.over[k]:
                if before < 0:
                    pending.head[i] = after
                else:
                    pending.following[before] = after
            else:
                limit = _limit(waits, k, progress[j])
                if limit < best:
                    best, who = limit, j
                before = k
            k = after
        out[i], held_by[i] = best, who


@lean_kernel
def final_progress(waits: Waits, waiting: Ints, by_holder: Ints, held_start: Ints, limit: Floats, done: Ints) -> None:
    """Lower each robot's limit to what the limits of those it waits for leave it, for good.

    Parameters
    ----------
    waiting : (K,) whose each wait is.
    by_holder, held_start : the waits for robot i are by_holder[held_start[i]:held_start[i+1]].
    limit : (n,) plan time that each robot reaches at most by itself, seconds; changed in place.
    done : (n,) zeros, for the kernel's use.

    Notes
    -----
    Dijkstra's algorithm, n² + K steps: a bound rises with the progress of the holder and is never below it.
    """
    n = limit.size
    for _ in range(n):
        i = -1
        for j in range(n):
            if done[j] == 0 and (i < 0 or limit[j] < limit[i]):
                i = j
        done[i] = 1
        for at in range(held_start[i], held_start[i + 1]):
            k = by_holder[at]
            if limit[i] < waits.over[k]:
                limit[waiting[k]] = min(limit[waiting[k]], _limit(waits, k, limit[i]))


@lean_kernel
def _limit(waits: Waits, k: int, progress: float) -> float:
    """Plan time up to which wait k lets its robot go when the holder has reached ``progress``, before it is over."""
    if progress <= waits.until[k]:
        return float(max(progress, waits.since[k]))
    a, b = waits.leg[k], waits.own[k]
    u = (progress - waits.t[a]) / (waits.t[a + 1] - waits.t[a])
    wx = waits.x[a] + u * (waits.x[a + 1] - waits.x[a]) - waits.x[b]
    wy = waits.y[a] + u * (waits.y[a + 1] - waits.y[a]) - waits.y[b]
    lx, ly = waits.x[b + 1] - waits.x[b], waits.y[b + 1] - waits.y[b]
    square = lx * lx + ly * ly
    reach, side = waits.apart[k] * sqrt(square), abs(wx * ly - wy * lx)
    half = sqrt((reach - side) * (reach + side)) if side < reach else 0.0
    f = min(1.0, (wx * lx + wy * ly - half) / square)
    return float(max(progress, waits.since[k], waits.t[b] + f * (waits.t[b + 1] - waits.t[b])))


@kernel
def found_waits(t: Floats, x: Floats, y: Floats, legs: Ints, robot: Ints, room: Floats) -> tuple[Ints, Floats]:
    """Find who has to wait for whom, from a plan in which all keep their distance.

    Parameters
    ----------
    t, x, y : stamps, seconds and metres.
    legs : (m,) stamps at which legs begin, by rising least x less the room of their robot.
    robot : (S,) of each stamp.
    room : (n,) metres; two robots keep the sum of theirs between their centres.

    Returns
    -------
    who : (K, 4) who waits, for whom, stamps at which the holder's leg and the waiting robot's begin.
    when : (K, 4) since, until, over (seconds), and the metres that the two keep.
    """
    who, when, size = np.empty((64, 4), dtype=np.int64), np.empty((64, 4)), 0
    m = legs.size
    low, high = np.empty((m, 2)), np.empty((m, 2))
    for k in range(m):
        a, own = legs[k], room[robot[legs[k]]]
        low[k, 0], high[k, 0] = min(x[a], x[a + 1]) - own, max(x[a], x[a + 1]) + own
        low[k, 1], high[k, 1] = min(y[a], y[a + 1]) - own, max(y[a], y[a + 1]) + own
    for k in range(m):
        for h in range(k + 1, m):
            if low[h, 0] >= high[k, 0]:
                break
            if low[h, 1] >= high[k, 1] or low[k, 1] >= high[h, 1] or low[k, 0] >= high[h, 0]:
                continue
            a, b = legs[k], legs[h]
            i, j = robot[a], robot[b]
            d = room[i] + room[j]
            if i == j or not d > 0.0:
                continue
            since_j, until_i, over_i = _wait(t, x, y, a, b, d)
            if since_j == inf:
                continue
            since_i, until_j, over_j = _wait(t, x, y, b, a, d)
            if since_i == inf:
                continue
            if size == who.shape[0]:
                who, when = higher(who), higher(when)
            # the nearest sides of the set to either axis: both on the side of the robot that passes later
            if t[b] >= t[a + 1] or (t[a] < t[b + 1] and since_j + until_j > since_i + until_i):
                who[size, 0], who[size, 1], who[size, 2], who[size, 3] = j, i, a, b
                when[size, 0], when[size, 1], when[size, 2] = since_j, until_i, over_i
            else:
                who[size, 0], who[size, 1], who[size, 2], who[size, 3] = i, j, b, a
                when[size, 0], when[size, 1], when[size, 2] = since_i, until_j, over_j
            when[size, 3] = d
            size += 1
    return who[:size], when[:size]


@kernel
def needed_waits(pair: Ints, until: Floats, over: Floats) -> Ints:
    """Mark with 1 the waits that can bind: not after another of the same pair that begins no later and lasts as long.

    Parameters
    ----------
    pair : (K,) equal for waits of the same two robots, which stand together by rising ``since``.
    """
    out = np.ones(pair.size, dtype=np.int64)
    longest = -inf
    for k in range(pair.size):
        if k == 0 or pair[k] != pair[k - 1]:
            longest = -inf
        if over[k] <= longest:
            out[k] = 0
        longest = max(longest, until[k])
    return out


@kernel
def _wait(t: Floats, x: Floats, y: Floats, a: int, b: int, d: float) -> tuple[float, float, float]:
    """Times since, until and over of the wait on leg b for leg a; inf if the two are never nearer than d."""
    f, u, last = _extremes(
        x[a] - x[b], y[a] - y[b], x[a + 1] - x[a], y[a + 1] - y[a], x[b + 1] - x[b], y[b + 1] - y[b], d
    )
    if f > 1.0:
        return inf, inf, inf
    return _time(t, b, f), _time(t, a, u), _time(t, a, last)


@kernel
def _time(t: Floats, a: int, u: float) -> float:
    return float(t[a + 1] if u == 1.0 else t[a] + u * (t[a + 1] - t[a]))


@kernel
def _extremes(wx: float, wy: float, ex: float, ey: float, lx: float, ly: float, d: float) -> tuple[float, float, float]:
    """Least f with |w + u E − f L| < d for some u, the largest u there, the largest u of all; (2, 2, 2) if none.

    The least f is where the point on L comes within d of the segment E: on one of the four sides of the square, or
    with its foot inside E, and so for the largest u. A foot taken for inside or outside by rounding costs no more
    than rounding in distance.
    """
    e_square, l_square = ex * ex + ey * ey, lx * lx + ly * ly
    if e_square < _STILL and l_square < _STILL:
        return (0.0, 1.0, 1.0) if wx * wx + wy * wy < d * d else (2.0, 2.0, 2.0)
    if e_square < _STILL:
        first, last = _span(wx * ly - wy * lx, -(wx * lx + wy * ly), l_square, d)
        return (first, 1.0, 1.0) if first < last else (2.0, 2.0, 2.0)
    near_first, near_last = _span(wx * ey - wy * ex, wx * ex + wy * ey, e_square, d)  # f = 0
    if l_square < _STILL:
        return (0.0, near_last, near_last) if near_first < near_last else (2.0, 2.0, 2.0)
    vx, vy, zx, zy = wx + ex, wy + ey, wx - lx, wy - ly
    begin_first, begin_last = _span(wx * ly - wy * lx, -(wx * lx + wy * ly), l_square, d)  # u = 0
    end_first, end_last = _span(vx * ly - vy * lx, -(vx * lx + vy * ly), l_square, d)  # u = 1
    far_first, far_last = _span(zx * ey - zy * ex, zx * ex + zy * ey, e_square, d)  # f = 1

    f, u, last = 2.0, 2.0, -1.0
    if near_first < near_last:
        f, u, last = 0.0, near_last, near_last
    if begin_first < begin_last:
        last = max(last, 0.0)
        if begin_first < f:
            f, u = begin_first, 0.0
    if far_first < far_last:
        last = max(last, far_last)
    if end_first < end_last:
        last = 1.0
        if end_first < f:
            f, u = end_first, 1.0
    turn = lx * ey - ly * ex
    if turn != 0.0:
        across = (wx * ey - wy * ex) * (1.0 if turn > 0.0 else -1.0)
        enters = (across - d * sqrt(e_square)) / abs(turn)
        foot = -((wx - enters * lx) * ex + (wy - enters * ly) * ey) / e_square
        if 0.0 <= enters < f and 0.0 <= foot <= 1.0:
            f, u = enters, foot
        across = (wx * ly - wy * lx) * (1.0 if turn > 0.0 else -1.0)
        leaves = (across + d * sqrt(l_square)) / abs(turn)
        foot = ((wx + leaves * ex) * lx + (wy + leaves * ey) * ly) / l_square
        if last < leaves <= 1.0 and 0.0 <= foot <= 1.0:
            last = leaves
    if f > 1.0 or last < 0.0:
        return 2.0, 2.0, 2.0
    return f, u, max(u, last)


@kernel
def _span(cross: float, dot: float, square: float, d: float) -> tuple[float, float]:
    """Fractions g in [0, 1] with |w + g e| < d, as (first, last), from w×e, w·e and |e|²; first > last if none."""
    reach, side = d * sqrt(square), abs(cross)
    if side >= reach:
        return 2.0, -1.0
    half = sqrt((reach - side) * (reach + side))
    return max(0.0, (-dot - half) / square), min(1.0, (half - dot) / square)
