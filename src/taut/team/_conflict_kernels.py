"""Kernels of forbidden times: when two robots on straight pieces would be too near, in closed form."""

from __future__ import annotations

from math import inf, sqrt
from typing import TypeAlias

import numpy as np
from numpy.typing import NDArray

from taut.compiling import kernel

Floats: TypeAlias = NDArray[np.float64]
Ints: TypeAlias = NDArray[np.int64]

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
