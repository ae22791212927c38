"""Kernels of team planning: forbidden times in closed form.

Kernels that call each other share this file, because Numba's disk cache does not notice an edit in a callee elsewhere.
"""

from __future__ import annotations

from math import inf, sqrt
from typing import TypeAlias

import numpy as np
from numpy.typing import NDArray

from taut.compiling import kernel
from taut.heap import drop_first, push

Floats: TypeAlias = NDArray[np.float64]
Ints: TypeAlias = NDArray[np.int64]
Flags: TypeAlias = NDArray[np.bool_]
Adjacency: TypeAlias = tuple[Ints, Ints, Floats]
Reserved: TypeAlias = tuple[Floats, Ints, Floats, Ints, Ints, Ints, Floats, Ints]

# --- Conflicts --------------------------------------------------------------------------------------------------------
#
# Another robot's reserved leg moves straight and evenly from (x0, y0) at t0 to (x1, y1) at t1, or rests for ever
# (t1 = inf). Lengths are metres, times seconds; "conflict" means nearer than d, so touching is none. Results are
# (found, lo, hi), the open interval lo < t < hi of forbidden times, or (False, inf, -inf).
#
# Accuracy. Write I(d) for the exact set. With tol = 2**-40 times the largest |coordinate|,
#     I(d - tol/4) is within the computed interval, which is within I(d + tol/4),
# apart from rounding t0 + u - s to a double. Every test below is backward stable: it decides correctly for robots
# displaced by a few units in the last place, and such a displacement changes every distance by as little.
#
# Division never meets zero (guarded); error_model="numpy" only saves Numba's checks and its exceptions.

_STILL = 1e-280  # m²: a displacement whose square is below counts as rest, since |e|² would lose digits to underflow
_SHAVE = 2.0**-48  # relative depth by which extremes of the ellipse stay inside; exceeds all rounding errors together


@kernel
def _span(cross: float, dot: float, square: float, reach: float) -> tuple[float, float]:
    """Find the fractions f in [0, 1] with |w + f e| < d, as (first, last); first > last if there are none.

    Roots of |e|² f² + 2 (w·e) f + |w|² − d² are f = (−w·e ± √(d²|e|² − (w×e)²)) / |e|². The arguments are w×e,
    w·e, |e|² and d|e|. The discriminant as a product keeps its digits at tangency: an error in w×e then acts like one
    in the distance of w from the line, an error in w·e like a shift of w along it.
    """
    side = abs(cross)
    if side >= reach:
        return 2.0, -1.0
    half = sqrt((reach - side) * (reach + side))
    return max(0.0, (-dot - half) / square), min(1.0, (half - dot) / square)


@kernel
def rest_conflict(
    px: float, py: float, x0: float, y0: float, t0: float, x1: float, y1: float, t1: float, d: float
) -> tuple[bool, float, float]:
    """Find the times at which the robot on a reserved leg is nearer than d to the point (px, py).

    Parameters
    ----------
    px, py : where the asking robot rests, metres.
    x0, y0, t0, x1, y1, t1 : the reserved leg, metres and seconds; nothing is found unless t1 > t0.
        With t1 = inf it rests at (x0, y0).
    d : least distance allowed, metres; nothing is found unless d > 0.

    Returns
    -------
    (found, lo, hi) : the open interval of times within [t0, t1]; hi is t1 itself, not rounded, if the leg ends inside.
        hi may be inf. (False, inf, -inf) without conflict: an empty interval or one instant is none.

    Notes
    -----
    With w = p − x0 and u = f (t1 − t0) the distance is |w − f L|, L = x1 − x0: one quadratic in f.
    Headway h: the other robot passes the same places up to h earlier or later, so the forbidden times are the union of
    (lo + s, hi + s) over |s| ≤ h, exactly (lo − h, hi + h). The caller widens the result.
    """
    if not (t1 > t0 and d > 0.0):
        return False, inf, -inf
    if px - max(x0, x1) >= d or min(x0, x1) - px >= d or py - max(y0, y1) >= d or min(y0, y1) - py >= d:
        return False, inf, -inf
    wx, wy = px - x0, py - y0
    lx, ly = x1 - x0, y1 - y0
    square = lx * lx + ly * ly
    span = t1 - t0
    if square < _STILL or span == inf:
        if wx * wx + wy * wy < d * d:
            return True, t0, t1
        return False, inf, -inf
    first, last = _span(wx * ly - wy * lx, -(wx * lx + wy * ly), square, d * sqrt(square))
    if first >= last:
        return False, inf, -inf
    lo = t0 + first * span
    hi = t1 if last == 1.0 else min(t1, t0 + last * span)
    if lo < hi:
        return True, lo, hi
    return False, inf, -inf


@kernel
def edge_conflict(
    ax: float,
    ay: float,
    bx: float,
    by: float,
    tau: float,
    x0: float,
    y0: float,
    t0: float,
    x1: float,
    y1: float,
    t1: float,
    d: float,
) -> tuple[bool, float, float]:
    """Find the departures at which a robot on the edge a → b comes nearer than d to the robot on a reserved leg.

    Parameters
    ----------
    ax, ay, bx, by : ends of the edge, metres; driven straight and evenly.
    tau : duration of the edge, seconds. Zero means an instant at a (b is ignored); a = b with tau > 0 is a rest.
    x0, y0, t0, x1, y1, t1 : the reserved leg, metres and seconds; nothing is found unless t1 > t0.
        With t1 = inf it rests at (x0, y0).
    d : least distance allowed, metres; nothing is found unless d > 0.

    Returns
    -------
    (found, lo, hi) : a departure δ is forbidden iff lo < δ < hi: at some instant of [t0, t1] ∩ [δ, δ + tau] the robots
        are nearer than d. hi may be inf. (False, inf, -inf) without conflict: an empty interval or one instant is none.
        At δ = lo or hi itself the two may share a single instant nearer than d, one setting out as the other arrives;
        their moves before and after it are what forbids that. hi ≤ t1, and t1 itself, not rounded, if the leg ends
        beside a.

    Notes
    -----
    Let s be the time along the edge and u the time along the leg, A = b − a, L = x1 − x0, T = t1 − t0, w = a − x0.
    The robots differ by z = w + (s/tau) A − (u/T) L, and z runs through a parallelogram as (s, u) runs through the
    rectangle [0, tau] × [0, T]. The pairs with |z| < d are convex, so δ − t0 = u − s takes an interval of values there,
    whose ends lie on a side of the rectangle or where a line u − s = const is tangent to the disc |z| < d:

    - On each side z moves along A or L: one quadratic (`_span`). Clipping to the side yields the corners.
    - Lines u − s = const run along the relative velocity, R = T A − tau L up to a factor. From z × R follows for the
      tangents u − s = (w × R ± d |R|) / (L × A), with L × A = (L × R)/T = (A × R)/tau; the slower robot's form is used,
      its digits survive when R is small and when the speeds differ by orders of magnitude.

    A tangent counts if it touches inside the parallelogram. For a flat ellipse rounding may decide that wrongly, and
    the wrong answer may be far off in time. So the tangents are those of the disc of radius d − shave, where the shave
    (2**-48 of the local size) exceeds all rounding errors together: if one is refused wrongly then a side passes so
    deep in the disc of radius d, at the same u − s, that it is found there; one taken wrongly has a side as near, so it
    is a conflict at d as well. For the same reason parallel velocities need no test but the one against zero.

    Headway h: for s in [−h, h] the leg's clock is shifted by s, which shifts δ = t0 + u − s' by s and changes neither
    u nor s'; the union of the shifted intervals is exactly (lo − h, hi + h). The caller widens the result.
    """
    if not (t1 > t0 and d > 0.0):
        return False, inf, -inf
    if (
        min(ax, bx) - max(x0, x1) >= d
        or min(x0, x1) - max(ax, bx) >= d
        or min(ay, by) - max(y0, y1) >= d
        or min(y0, y1) - max(ay, by) >= d
    ):
        return False, inf, -inf
    span = t1 - t0
    wx, wy = ax - x0, ay - y0
    ex, ey = bx - ax, by - ay
    lx, ly = x1 - x0, y1 - y0
    edge_square = ex * ex + ey * ey
    leg_square = lx * lx + ly * ly
    edge_rests = edge_square < _STILL or tau == 0.0
    leg_rests = leg_square < _STILL or span == inf

    if edge_rests and leg_rests:
        if wx * wx + wy * wy >= d * d:
            return False, inf, -inf
        lo, hi = -tau, span
    elif leg_rests:
        first, last = _span(wx * ey - wy * ex, wx * ex + wy * ey, edge_square, d * sqrt(edge_square))
        if first >= last:
            return False, inf, -inf
        lo, hi = -last * tau, span - first * tau
    elif edge_rests:
        first, last = _span(wx * ly - wy * lx, -(wx * lx + wy * ly), leg_square, d * sqrt(leg_square))
        if first >= last:
            return False, inf, -inf
        lo, hi = first * span - tau, last * span
    else:
        lo, hi = _crossing(wx, wy, bx - x0, by - y0, ax - x1, ay - y1, ex, ey, tau, lx, ly, span, d)
    if not lo < hi:
        return False, inf, -inf
    # t0 + (t1 - t0) may round away from t1, and the next leg starts exactly there
    end = t1 if hi >= span else min(t1, t0 + hi)
    start = t0 + lo
    if start < end:
        return True, start, end
    return False, inf, -inf


@kernel
def _crossing(
    wx: float,
    wy: float,
    vx: float,
    vy: float,
    zx: float,
    zy: float,
    ex: float,
    ey: float,
    tau: float,
    lx: float,
    ly: float,
    span: float,
    d: float,
) -> tuple[float, float]:
    """Find the least and largest u − s of `edge_conflict` for two moving robots; (inf, -inf) if there is none.

    w = a − x0, v = b − x0 and z = a − x1 are corners of the parallelogram, e and l its sides, tau and span the
    durations.
    """
    edge_square = ex * ex + ey * ey
    leg_square = lx * lx + ly * ly
    edge_length = sqrt(edge_square)
    leg_length = sqrt(leg_square)
    edge_reach = d * edge_length
    leg_reach = d * leg_length
    lo, hi = inf, -inf

    # the disc lies wholly beyond a pair of opposite sides
    near_e = wx * ey - wy * ex
    far_e = zx * ey - zy * ex
    if (near_e >= edge_reach and far_e >= edge_reach) or (near_e <= -edge_reach and far_e <= -edge_reach):
        return lo, hi
    near_l = wx * ly - wy * lx
    far_l = vx * ly - vy * lx
    if (near_l >= leg_reach and far_l >= leg_reach) or (near_l <= -leg_reach and far_l <= -leg_reach):
        return lo, hi

    first, last = _span(near_e, wx * ex + wy * ey, edge_square, edge_reach)  # u = 0
    if first < last:
        lo = min(lo, -last * tau)
        hi = max(hi, -first * tau)
    first, last = _span(far_e, zx * ex + zy * ey, edge_square, edge_reach)  # u = T
    if first < last:
        lo = min(lo, span - last * tau)
        hi = max(hi, span - first * tau)
    first, last = _span(near_l, -(wx * lx + wy * ly), leg_square, leg_reach)  # s = 0
    if first < last:
        lo = min(lo, first * span)
        hi = max(hi, last * span)
    first, last = _span(far_l, -(vx * lx + vy * ly), leg_square, leg_reach)  # s = tau
    if first < last:
        lo = min(lo, first * span - tau)
        hi = max(hi, last * span - tau)

    # the tangents
    shave = _SHAVE * (abs(wx) + abs(wy) + edge_length + leg_length + d)
    if d <= shave:
        return lo, hi
    rx, ry = span * ex - tau * lx, span * ey - tau * ly
    if edge_length * span < leg_length * tau:
        qx, qy, clock, other = ex, ey, tau, span  # c is the time along the leg, from the slower edge's point of view
    else:
        qx, qy, clock, other = lx, ly, span, tau  # c is the time along the edge
    turn = qx * ry - qy * rx
    if turn == 0.0:
        return lo, hi
    r_square = rx * rx + ry * ry
    r_length = sqrt(r_square)
    centre = wx * ry - wy * rx
    reach = (d - shave) * r_length
    for sign in (-1.0, 1.0):
        part = (centre + sign * reach) / turn
        delta = part * clock
        if not -tau <= delta <= span:
            continue
        # the line is z = (w − part q) + c R / (T tau); its point nearest to the origin is where the tangent touches
        touch = -((wx - part * qx) * rx + (wy - part * qy) * ry)
        if edge_length * span < leg_length * tau:
            begin, end = max(0.0, delta), min(span, tau + delta)
        else:
            begin, end = max(0.0, -delta), min(tau, span - delta)
        scale = r_square / (clock * other)
        if begin * scale <= touch <= end * scale:
            lo = min(lo, delta)
            hi = max(hi, delta)
    return lo, hi


# --- Reservations -----------------------------------------------------------------------------------------------------
#
# Legs reserved by planned robots stand in every cell of a uniform grid that they come within `reach` of, so whoever
# asks about a place looks into one cell only. In a cell they are sorted into spans of time, taken modulo the number of
# spans, and one last span for rests for ever. The legs of a cell and span are a linked list: head[cell, span], then
# following[entry].
# ``reserved`` = (legs (k, 6): x0, y0, t0, x1, y1, t1; robot (k,); radius (k,); head; entry; following; frame; shape)
# with frame = (x0, y0, side of a cell, seconds of a span) and shape = (columns, rows, spans).


@kernel
def _longer_floats(a: Floats) -> Floats:
    out = np.empty(2 * a.shape[0])
    for i in range(a.shape[0]):
        out[i] = a[i]
    return out


@kernel
def _longer_ints(a: Ints) -> Ints:
    out = np.empty(2 * a.shape[0], dtype=np.int64)
    for i in range(a.shape[0]):
        out[i] = a[i]
    return out


@kernel
def _cell(x: float, x0: float, step: float, n: int) -> int:
    return min(max(int((x - x0) / step), 0), n - 1)


@kernel
def _rows(
    x0: float, y0: float, x1: float, y1: float, reach: float, col: int, frame: Floats, rows: int
) -> tuple[int, int]:
    """First and last row of a column of cells within ``reach`` of the segment (last < first: none)."""
    lo = frame[0] + col * frame[2] - reach
    hi = frame[0] + (col + 1) * frame[2] + reach
    if x0 > x1:
        x0, y0, x1, y1 = x1, y1, x0, y0
    ya, yb = y0, y1
    if x1 > x0:
        slope = (y1 - y0) / (x1 - x0)
        if x0 < lo:
            ya = y0 + slope * (min(lo, x1) - x0)
        if x1 > hi:
            yb = y0 + slope * (max(hi, x0) - x0)
    return (
        _cell(min(ya, yb) - reach, frame[1], frame[2], rows),
        _cell(max(ya, yb) + reach, frame[1], frame[2], rows),
    )


@kernel
def _spans(t0: float, t1: float, frame: Floats, shape: Ints) -> tuple[int, int]:
    """First span of a stretch of time, before the modulus, and how many it touches (all of them at most)."""
    spans = shape[2]
    if t1 - t0 >= spans * frame[3]:
        return 0, spans
    first = int(t0 / frame[3])
    return first, min(int(t1 / frame[3]) - first + 1, spans)


@kernel
def _within(a: float, b: float, lo: float, hi: float) -> tuple[float, float]:
    """Fractions of the way from a to b that lie between lo and hi, as (first, last)."""
    if a == b:
        return (0.0, 1.0) if lo <= a <= hi else (1.0, 0.0)
    f, g = (lo - a) / (b - a), (hi - a) / (b - a)
    return max(min(f, g), 0.0), min(max(f, g), 1.0)


@kernel
def _passage(
    ax: float, ay: float, bx: float, by: float, reach: float, col: int, row: int, frame: Floats
) -> tuple[float, float]:
    """Fractions of the way from a to b within ``reach`` of a cell, as (first, last); first > last if there are none."""
    x, y = frame[0] + col * frame[2], frame[1] + row * frame[2]
    f0, f1 = _within(ax, bx, x - reach, x + frame[2] + reach)
    g0, g1 = _within(ay, by, y - reach, y + frame[2] + reach)
    return max(f0, g0), min(f1, g1)


@kernel
def enter_legs(
    legs: Floats,
    first: int,
    last: int,
    reach: float,
    frame: Floats,
    shape: Ints,
    head: Ints,
    entry: Ints,
    following: Ints,
    count: int,
) -> tuple[Ints, Ints, int]:
    """Enter legs first … last − 1 into the grid; returns the (perhaps longer) entry lists and their new count."""
    for i in range(first, last):
        x0, y0, x1, y1 = legs[i, 0], legs[i, 1], legs[i, 3], legs[i, 4]
        t0, t1 = legs[i, 2], legs[i, 5]
        col0 = _cell(min(x0, x1) - reach, frame[0], frame[2], shape[0])
        col1 = _cell(max(x0, x1) + reach, frame[0], frame[2], shape[0])
        for col in range(col0, col1 + 1):
            row0, row1 = _rows(x0, y0, x1, y1, reach, col, frame, shape[1])
            needed = count + (row1 - row0 + 1) * shape[2]
            while needed > entry.shape[0]:
                entry, following = _longer_ints(entry), _longer_ints(following)
            for row in range(row0, row1 + 1):
                cell = row * shape[0] + col
                span0, spans = shape[2], 1
                if t1 < inf:
                    first_part, last_part = _passage(x0, y0, x1, y1, reach, col, row, frame)
                    if first_part > last_part:
                        continue
                    span0, spans = _spans(t0 + first_part * (t1 - t0), t0 + last_part * (t1 - t0), frame, shape)
                for k in range(spans):
                    span = span0 if span0 == shape[2] else (span0 + k) % shape[2]
                    entry[count] = i
                    following[count] = head[cell, span]
                    head[cell, span] = count
                    count += 1
    return entry, following, count


@kernel
def _append(lo: Floats, hi: Floats, count: int, a: float, b: float) -> tuple[Floats, Floats, int]:
    if count == lo.shape[0]:
        lo, hi = _longer_floats(lo), _longer_floats(hi)
    lo[count], hi[count] = a, b
    return lo, hi, count + 1


@kernel
def _merge(lo: Floats, hi: Floats, count: int) -> int:
    """Sort open intervals and join those that overlap; returns how many remain."""
    for i in range(1, count):
        a, b = lo[i], hi[i]
        j = i - 1
        while j >= 0 and lo[j] > a:
            lo[j + 1], hi[j + 1] = lo[j], hi[j]
            j -= 1
        lo[j + 1], hi[j + 1] = a, b
    n = 0
    for i in range(count):
        if n > 0 and lo[i] < hi[n - 1]:
            hi[n - 1] = max(hi[n - 1], hi[i])
        else:
            lo[n], hi[n] = lo[i], hi[i]
            n += 1
    return n


@kernel
def place_conflicts(
    x: float, y: float, reserved: Reserved, who: int, body: Floats, lo: Floats, hi: Floats, stamp: Ints, mark: int
) -> tuple[Floats, Floats, int]:
    """Forbidden times of a place: merged open intervals.

    ``body`` = (radius, gap in planning, headway); ``stamp`` holds the mark of the question that last met each leg.
    """
    legs, robot, radius, head, entry, following, frame, shape = reserved
    count = 0
    cell = _cell(y, frame[1], frame[2], shape[1]) * shape[0] + _cell(x, frame[0], frame[2], shape[0])
    for span in range(shape[2] + 1):
        e = head[cell, span]
        while e >= 0:
            i = entry[e]
            e = following[e]
            if stamp[i] == mark or robot[i] == who:
                continue
            stamp[i] = mark
            d = body[0] + radius[i] + body[1]
            found, a, b = rest_conflict(x, y, legs[i, 0], legs[i, 1], legs[i, 2], legs[i, 3], legs[i, 4], legs[i, 5], d)
            if found:
                lo, hi, count = _append(lo, hi, count, a - body[2], b + body[2])
    return lo, hi, _merge(lo, hi, count)


@kernel
def _edge_conflicts(
    edge: tuple[float, float, float, float],
    tau: float,
    earliest: float,
    latest: float,
    reserved: Reserved,
    who: int,
    body: Floats,
    lo: Floats,
    hi: Floats,
    stamp: Ints,
    mark: int,
) -> tuple[Floats, Floats, int]:
    """Forbidden departures of an edge within [earliest, latest]: merged open intervals."""
    ax, ay, bx, by = edge
    legs, robot, radius, head, entry, following, frame, shape = reserved
    count = 0
    slack = 1e-6 * frame[2]
    col0 = _cell(min(ax, bx) - slack, frame[0], frame[2], shape[0])
    col1 = _cell(max(ax, bx) + slack, frame[0], frame[2], shape[0])
    for col in range(col0, col1 + 1):
        row0, row1 = _rows(ax, ay, bx, by, slack, col, frame, shape[1])
        for row in range(row0, row1 + 1):
            cell = row * shape[0] + col
            first_part, last_part = _passage(ax, ay, bx, by, slack, col, row, frame)
            if first_part > last_part:
                continue
            from_time = max(earliest + first_part * tau - body[2], 0.0)
            until_time = latest + last_part * tau + body[2]
            span0, spans = _spans(from_time, until_time, frame, shape)
            for k in range(spans + 1):
                e = head[cell, shape[2] if k == spans else (span0 + k) % shape[2]]
                while e >= 0:
                    i = entry[e]
                    e = following[e]
                    if stamp[i] == mark or robot[i] == who or legs[i, 5] < from_time or legs[i, 2] > until_time:
                        continue
                    stamp[i] = mark
                    d = body[0] + radius[i] + body[1]
                    found, a, b = edge_conflict(
                        ax, ay, bx, by, tau, legs[i, 0], legs[i, 1], legs[i, 2], legs[i, 3], legs[i, 4], legs[i, 5], d
                    )
                    if found and b + body[2] > earliest and a - body[2] < latest:
                        lo, hi, count = _append(lo, hi, count, a - body[2], b + body[2])
    return lo, hi, _merge(lo, hi, count)


@kernel
def _earliest_departure(
    edge: tuple[float, float, float, float],
    tau: float,
    ready: float,
    latest: float,
    reserved: Reserved,
    who: int,
    body: Floats,
    lo: Floats,
    hi: Floats,
    stamp: Ints,
    mark: int,
) -> tuple[float, Floats, Floats, int]:
    """The first departure in [ready, latest] without conflict, inf if none; looks no farther ahead than it must."""
    ahead = reserved[6][3]
    while ready <= latest:
        until = min(ready + ahead, latest)
        lo, hi, count = _edge_conflicts(edge, tau, ready, until, reserved, who, body, lo, hi, stamp, mark)
        mark += 1
        ready = _first_free(lo, hi, count, ready)
        if ready <= until:
            return ready, lo, hi, mark
        ahead *= 2.0
    return inf, lo, hi, mark


@kernel
def blockers(
    positions: Floats, tau: Floats, depart: Floats, reserved: Reserved, who: int, body: Floats
) -> tuple[Ints, Ints]:
    """Reserved legs in conflict with a motion along ``positions`` that leaves vertex k at depart[k]: (leg, k) pairs."""
    legs, robot, radius = reserved[0], reserved[1], reserved[2]
    found_leg = np.empty(legs.shape[0] * tau.shape[0], dtype=np.int64)
    found_edge = np.empty(legs.shape[0] * tau.shape[0], dtype=np.int64)
    count = 0
    for k in range(tau.shape[0]):
        for i in range(legs.shape[0]):
            if robot[i] == who or robot[i] < 0:
                continue
            ax, ay, bx, by = positions[k, 0], positions[k, 1], positions[k + 1, 0], positions[k + 1, 1]
            d = body[0] + radius[i] + body[1]
            found, a, b = edge_conflict(
                ax, ay, bx, by, tau[k], legs[i, 0], legs[i, 1], legs[i, 2], legs[i, 3], legs[i, 4], legs[i, 5], d
            )
            if found and a - body[2] < depart[k] < b + body[2]:
                found_leg[count], found_edge[count] = i, k
                count += 1
    return found_leg[:count], found_edge[:count]


# --- Safe-interval search ---------------------------------------------------------------------------------------------


@kernel
def _settle(
    v: int,
    base: Adjacency,
    over: Adjacency,
    positions: Floats,
    start: int,
    distance: Floats,
    settled: Flags,
    keys: Floats,
    items: Ints,
    size: int,
) -> int:
    """Continue the backward search from the goal until the distance of v is exact (or v is found to be unreachable)."""
    n_base = base[0].shape[0] - 1
    sx, sy = positions[start, 0], positions[start, 1]
    while size > 0 and not settled[v]:
        u = items[0]
        drop_first(keys, items, size)
        size -= 1
        if settled[u]:
            continue
        settled[u] = True
        for layer in range(2):
            if layer == 0 and u >= n_base:
                continue
            indptr, indices, lengths = base if layer == 0 else over
            for k in range(indptr[u], indptr[u + 1]):
                w = indices[k]
                through = distance[u] + lengths[k]
                if through < distance[w] and not settled[w]:
                    distance[w] = through
                    ahead = np.sqrt((positions[w, 0] - sx) ** 2 + (positions[w, 1] - sy) ** 2)
                    push(keys, items, size, through + ahead, w)
                    size += 1
    return size


@kernel
def _first_free(lo: Floats, hi: Floats, count: int, t: float) -> float:
    """The first time ≥ t outside the intervals."""
    for i in range(count):
        if lo[i] < t < hi[i]:
            t = hi[i]
    return t


@kernel
def _last_free(lo: Floats, hi: Floats, count: int, t: float) -> float:
    """The last time ≤ t outside the intervals."""
    for i in range(count - 1, -1, -1):
        if lo[i] < t < hi[i]:
            t = lo[i]
    return t


@kernel
def safe_interval_search(
    base: Adjacency,
    over: Adjacency,
    positions: Floats,
    reserved: Reserved,
    who: int,
    body: Floats,
    speed: float,
    leave_after: float,
    stays: bool,
    start: int,
    goal: int,
    pinched: tuple[bool, bool],
) -> tuple[bool, Ints, Floats, Floats, int, float, int]:
    """Earliest arrival by A* over (vertex, safe interval), moving at top speed or resting at vertices.

    Source: Phillips and Likhachev, SIPP: safe interval path planning for dynamic environments, ICRA 2011; here in
    continuous time with closed-form intervals, and edges examined only when their tail is expanded.

    Parameters
    ----------
    base, over : CSR (indptr, indices, lengths) of the shared roadmap and of this robot's own vertices and edges.
    positions : (n, 2) of all vertices, the shared ones first.
    who, body : the robot's number, and (radius, gap in planning, headway).
    speed, leave_after, stays : metres a second; seconds before which it may not leave; whether it stays at its goal.
    pinched : whether free space touches itself at the start, and at the goal. Such an end belongs to all sides, so
        nothing leads back to it or on from it: that would be a way from one side to another.

    Returns
    -------
    found, vertices, arrive, depart : the motion; the robot leaves vertices[k] at depart[k]; rests are put as late as
        the arrival allows at no vertex but the first that can take them.
    stuck, time, pops : the expanded vertex nearest to the goal and its arrival, and the number of expansions.
    """
    n_base = base[0].shape[0] - 1
    n = positions.shape[0]
    gx, gy = positions[goal, 0], positions[goal, 1]

    distance = np.full(n, inf)
    settled = np.zeros(n, dtype=np.bool_)
    back_size = base[1].shape[0] + over[1].shape[0] + 1
    back_keys = np.empty(back_size)
    back_items = np.empty(back_size, dtype=np.int64)
    distance[goal] = 0.0
    back_keys[0], back_items[0] = 0.0, goal
    back_size = 1

    # states: one for each safe interval of each vertex met; those of one vertex are consecutive and in order of time
    of_vertex = np.full(n, -1, dtype=np.int64)
    how_many = np.zeros(n, dtype=np.int64)
    states = 0
    vertex = np.empty(1024, dtype=np.int64)
    opens = np.empty(1024)
    closes = np.empty(1024)
    arrive = np.empty(1024)
    leave = np.empty(1024)
    parent = np.empty(1024, dtype=np.int64)
    done = np.empty(1024, dtype=np.int64)
    # ways: edges out of expanded states that have not been tested for conflicts yet
    ways = 0
    way_from = np.empty(1024, dtype=np.int64)
    way_to = np.empty(1024, dtype=np.int64)
    way_time = np.empty(1024)

    lo = np.empty(64)
    hi = np.empty(64)
    stamp = np.full(reserved[0].shape[0], -1, dtype=np.int64)
    mark = 0
    # the queue holds states by their numbers, and ways w as −1 − w with the arrival they would have without conflicts
    keys = np.empty(1024)
    items = np.empty(1024, dtype=np.int64)
    keys[0], items[0] = leave_after, -1
    size = 1
    way_from[0], way_to[0], way_time[0] = -1, start, 0.0
    ways = 1
    pops = 0
    best, best_left = -1, inf
    reached = -1

    while size > 0:
        key, item = keys[0], items[0]
        drop_first(keys, items, size)
        size -= 1
        if item < 0:
            origin, v, tau = way_from[-1 - item], way_to[-1 - item], way_time[-1 - item]
            ready = leave_after if origin < 0 else arrive[origin]
            if not settled[v]:
                back_size = _settle(
                    v, base, over, positions, start, distance, settled, back_keys, back_items, back_size
                )
                if not settled[v]:
                    continue
            left = distance[v] / speed
            if ready + tau + left > key and origin >= 0:
                push(keys, items, size, ready + tau + left, item)
                size += 1
                continue
            if of_vertex[v] < 0:
                lo, hi, count = place_conflicts(
                    positions[v, 0], positions[v, 1], reserved, who, body, lo, hi, stamp, mark
                )
                mark += 1
                while states + count + 1 > vertex.shape[0]:
                    vertex, parent, done = _longer_ints(vertex), _longer_ints(parent), _longer_ints(done)
                    opens, closes = _longer_floats(opens), _longer_floats(closes)
                    arrive, leave = _longer_floats(arrive), _longer_floats(leave)
                of_vertex[v] = states
                free_from = 0.0
                for i in range(count + 1):
                    until = lo[i] if i < count else inf
                    if until >= free_from and free_from < inf:
                        vertex[states], opens[states], closes[states] = v, free_from, until
                        arrive[states], leave[states], parent[states], done[states] = inf, inf, -1, 0
                        states += 1
                    if i < count:
                        free_from = max(free_from, hi[i])
                how_many[v] = states - of_vertex[v]
            for s in range(of_vertex[v], of_vertex[v] + how_many[v]):
                if origin < 0:
                    # at the start: only the interval in which the robot already stands there
                    if opens[s] > 0.0 or closes[s] < leave_after:
                        continue
                    arrive[s] = leave_after
                else:
                    soonest = max(ready, opens[s] - tau)
                    latest = min(closes[origin], closes[s] - tau)
                    if done[s] == 1 or soonest > latest or soonest + tau >= arrive[s]:
                        continue
                    u = vertex[origin]
                    edge = positions[u, 0], positions[u, 1], positions[v, 0], positions[v, 1]
                    delta, lo, hi, mark = _earliest_departure(
                        edge, tau, soonest, latest, reserved, who, body, lo, hi, stamp, mark
                    )
                    if delta == inf or delta + tau >= arrive[s]:
                        continue
                    arrive[s], leave[s], parent[s] = max(delta + tau, opens[s]), delta, origin
                if size == keys.shape[0]:
                    keys, items = _longer_floats(keys), _longer_ints(items)
                push(keys, items, size, arrive[s] + left, s)
                size += 1
            continue
        if done[item] == 1:
            continue
        done[item] = 1
        pops += 1
        u = vertex[item]
        if distance[u] < best_left:
            best, best_left = item, distance[u]
        if u == goal and (not stays or closes[item] == inf):
            reached = item
            break
        ready = arrive[item]
        for layer in range(2):
            if (layer == 0 and u >= n_base) or (u == goal and pinched[1]):
                continue
            indptr, indices, lengths = base if layer == 0 else over
            for k in range(indptr[u], indptr[u + 1]):
                v = indices[k]
                if v == start and pinched[0]:
                    continue
                tau = lengths[k] / speed
                useful = of_vertex[v] < 0
                for s in range(of_vertex[v], of_vertex[v] + how_many[v]):
                    if done[s] == 0 and max(ready + tau, opens[s]) < arrive[s] and closes[s] >= ready + tau:
                        useful = True
                        break
                if not useful:
                    continue
                straight = np.sqrt((positions[v, 0] - gx) ** 2 + (positions[v, 1] - gy) ** 2)
                left = distance[v] if settled[v] else straight
                if ways == way_from.shape[0]:
                    way_from, way_to, way_time = _longer_ints(way_from), _longer_ints(way_to), _longer_floats(way_time)
                way_from[ways], way_to[ways], way_time[ways] = item, v, tau
                if size == keys.shape[0]:
                    keys, items = _longer_floats(keys), _longer_ints(items)
                push(keys, items, size, ready + tau + left / speed, -1 - ways)
                size += 1
                ways += 1

    if reached < 0:
        where = vertex[best] if best >= 0 else start
        when = arrive[best] if best >= 0 else 0.0
        nothing = np.empty(0)
        return False, np.empty(0, dtype=np.int64), nothing, nothing, where, when, pops

    length = 1
    s = reached
    while parent[s] >= 0:
        s = parent[s]
        length += 1
    path = np.empty(length, dtype=np.int64)
    s = reached
    for i in range(length - 1, -1, -1):
        path[i] = s
        s = parent[s]
    out_vertex = np.empty(length, dtype=np.int64)
    out_arrive = np.empty(length)
    out_depart = np.empty(length)
    out_arrive[length - 1] = out_depart[length - 1] = arrive[reached]
    out_vertex[length - 1] = goal
    # from the goal backwards every departure is put as late as the next one allows: rests gather at the start
    for i in range(length - 2, -1, -1):
        s, after = path[i], path[i + 1]
        u, v = vertex[s], vertex[after]
        tau = _edge_time(base, over, n_base, u, v, speed)
        latest = min(out_depart[i + 1] - tau, closes[s])
        delta = leave[after]
        if latest > delta:
            edge = positions[u, 0], positions[u, 1], positions[v, 0], positions[v, 1]
            lo, hi, count = _edge_conflicts(edge, tau, delta, latest, reserved, who, body, lo, hi, stamp, mark)
            mark += 1
            delta = max(delta, _last_free(lo, hi, count, latest))
        out_vertex[i], out_depart[i] = u, delta
        out_arrive[i + 1] = max(delta + tau, opens[after])
        if out_depart[i + 1] < out_arrive[i + 1]:
            out_depart[i + 1] = out_arrive[i + 1]
    out_arrive[0] = 0.0
    return True, out_vertex, out_arrive, out_depart, goal, arrive[reached], pops


@kernel
def _edge_time(base: Adjacency, over: Adjacency, n_base: int, u: int, v: int, speed: float) -> float:
    best = inf
    if u < n_base:
        for k in range(base[0][u], base[0][u + 1]):
            if base[1][k] == v:
                best = min(best, base[2][k])
    for k in range(over[0][u], over[0][u + 1]):
        if over[1][k] == v:
            best = min(best, over[2][k])
    return best / speed
