"""Slow and obvious references for the conflict intervals: exact rationals, 60-digit bisection, dense sampling.

They share one idea that the kernels do not use: for one departure the robots' difference runs along a straight segment,
so the least distance over the common time is the distance of the origin from a segment. It is convex in the departure.
"""

from __future__ import annotations

from dataclasses import astuple, dataclass
from decimal import Decimal, localcontext
from fractions import Fraction
from math import isinf
from typing import Any

import numpy as np
from numpy.typing import NDArray


@dataclass(frozen=True)
class Meeting:
    """An edge a → b driven in tau seconds, a reserved leg, and the least distance d."""

    ax: float
    ay: float
    bx: float
    by: float
    tau: float
    x0: float
    y0: float
    t0: float
    x1: float
    y1: float
    t1: float
    d: float

    @property
    def arguments(self) -> tuple[float, ...]:
        """Arguments of the kernel, in its order."""
        return astuple(self)

    @property
    def quarter_tol(self) -> Fraction:
        """A quarter of the tolerance of a scene that holds nothing else, metres."""
        places = (self.ax, self.ay, self.bx, self.by, self.x0, self.y0, self.x1, self.y1)
        return Fraction(max(abs(c) for c in places)) / 2**42

    @property
    def time_rounding(self) -> Fraction:
        """Bound on the rounding of t0 + u − s to a double, seconds."""
        leg = 0.0 if isinf(self.t1) else self.t1 - self.t0
        return Fraction(abs(self.t0) + leg + self.tau) / 2**51 + Fraction(1, 2**200)  # the ends themselves may conflict


def closest(m: Meeting, delta: Any, number: Any = Fraction) -> Any:
    """Return the least squared distance when departing at t0 + delta; None without a common instant.

    Exact for Fraction; `number` may be Decimal instead.
    """
    ax, ay, bx, by, tau, x0, y0, t0, x1, y1 = (number(c) for c in m.arguments[:10])
    begin, end = max(number(0), -delta), tau
    vax, vay = ((bx - ax) / tau, (by - ay) / tau) if tau else (number(0), number(0))
    vlx, vly = number(0), number(0)
    if not isinf(m.t1):
        span = number(m.t1) - t0
        end = min(tau, span - delta)
        vlx, vly = (x1 - x0) / span, (y1 - y0) / span
    if begin > end:
        return None
    # difference at time s along the edge: a + s va − x0 − (s + delta) vl
    cx, cy = ax - x0 - delta * vlx, ay - y0 - delta * vly
    rx, ry = vax - vlx, vay - vly
    square = rx * rx + ry * ry
    s = begin if square == 0 else min(max(-(cx * rx + cy * ry) / square, begin), end)
    return (cx + s * rx) ** 2 + (cy + s * ry) ** 2


def nearest_departure(m: Meeting) -> Fraction:
    """Return the departure (from t0) for which the robots come nearest: the closest points of edge and leg, exactly."""
    zero, one = Fraction(0), Fraction(1)
    tau, span = Fraction(m.tau), Fraction(0) if isinf(m.t1) else Fraction(m.t1) - Fraction(m.t0)
    wx, wy = Fraction(m.ax) - Fraction(m.x0), Fraction(m.ay) - Fraction(m.y0)
    ex, ey = (Fraction(m.bx) - Fraction(m.ax), Fraction(m.by) - Fraction(m.ay)) if tau else (zero, zero)
    lx, ly = (Fraction(m.x1) - Fraction(m.x0), Fraction(m.y1) - Fraction(m.y0)) if span else (zero, zero)
    ee, ll, el = ex * ex + ey * ey, lx * lx + ly * ly, ex * lx + ey * ly
    we, wl = wx * ex + wy * ey, wx * lx + wy * ly

    def clip(f: Fraction) -> Fraction:
        return min(max(f, zero), one)

    pairs = [(f, clip((wl + f * el) / ll) if ll else zero) for f in (zero, one)]
    pairs += [(clip((g * el - we) / ee) if ee else zero, g) for g in (zero, one)]
    turn = ee * ll - el * el
    if turn:
        f, g = (el * wl - ll * we) / turn, (ee * wl - el * we) / turn
        if zero <= f <= one and zero <= g <= one:
            pairs.append((f, g))

    def distance(pair: tuple[Fraction, Fraction]) -> Fraction:
        f, g = pair
        return (wx + f * ex - g * lx) ** 2 + (wy + f * ey - g * ly) ** 2

    f, g = min(pairs, key=distance)
    return g * span - f * tau


def broken_promise(m: Meeting, found: bool, lo: float, hi: float) -> str | None:
    """Say what breaks I(d − tol/4) ⊆ (lo, hi) ⊆ I(d + tol/4), up to rounding of the times; None if it holds.

    Exact. The least distance is convex in the departure, so its values at both ends and its minimum decide.
    """
    q, slack, t0 = m.quarter_tol, m.time_rounding, Fraction(m.t0)
    less, more = max(Fraction(m.d) - q, Fraction(0)) ** 2, (Fraction(m.d) + q) ** 2
    best = nearest_departure(m)
    nearest = closest(m, best)
    assert nearest is not None
    if not found:
        around = (closest(m, best - slack), closest(m, best + slack))
        if nearest >= less or all(square is None or square >= less for square in around):
            return None
        return f"missed: they come to {float(nearest) ** 0.5!r}"
    if not lo < hi:
        return "empty but found"
    first = Fraction(lo) - t0
    outside = closest(m, first - slack)
    if outside is not None and outside < less:
        return f"lo is late: {float(outside) ** 0.5!r}"
    ends = [("lo", first + slack)]
    if not isinf(hi):
        last = Fraction(hi) - t0
        outside = closest(m, last + slack)
        if outside is not None and outside < less:
            return f"hi is early: {float(outside) ** 0.5!r}"
        if nearest < less and not first - slack <= best <= last + slack:
            return "beside the conflict"
        ends.append(("hi", last - slack))
        if first + slack >= last - slack:
            ends = []
    elif not isinf(m.t1):
        return "hi is inf for a leg that ends"
    elif nearest < less and closest(m, Fraction(0)) != nearest:
        return "a rest for ever must stay in the way"
    for name, delta in ends:
        inside = closest(m, delta)
        if inside is None or inside > more:
            return f"{name} too wide: {inside if inside is None else float(inside) ** 0.5!r}"
    return None


def bisected(m: Meeting, digits: int = 60) -> tuple[Decimal, Decimal] | None:
    """Bisect for both ends of the forbidden departures (from t0); None without conflict. The leg must end."""
    best = nearest_departure(m)
    limit = Fraction(m.d) ** 2
    if closest(m, best) >= limit:
        return None
    with localcontext(prec=digits):

        def conflict(delta: Decimal) -> bool:
            square = closest(m, delta, Decimal)
            return square is not None and square < Decimal(m.d) ** 2

        ends = []
        for outer in (-Decimal(m.tau), Decimal(m.t1) - Decimal(m.t0)):
            inside, outside = Decimal(best.numerator) / Decimal(best.denominator), outer
            if conflict(outer):
                inside = outer
            for _ in range(3 * digits if inside != outer else 0):
                middle = (inside + outside) / 2
                inside, outside = (middle, outside) if conflict(middle) else (inside, middle)
            ends.append(inside)
        return ends[0], ends[1]


def sampled_conflicts(m: Meeting, departures: int = 60, instants: int = 200) -> NDArray[np.float64]:
    """Return those of many departures for which sampled positions are nearer than d − tol/4; plain arithmetic."""
    end = m.t0 + 3 * m.tau + 1 if isinf(m.t1) else m.t1
    seen = []
    for delta in np.linspace(m.t0 - 1.1 * m.tau - 1e-3, end + 0.1 * m.tau + 1e-3, departures):
        times = np.linspace(max(delta, m.t0), min(delta + m.tau, end), instants)
        if times[-1] < times[0]:
            continue
        f = np.clip((times - delta) / m.tau, 0, 1) if m.tau else np.zeros(instants)
        g = np.zeros(instants) if isinf(m.t1) else np.clip((times - m.t0) / (m.t1 - m.t0), 0, 1)
        dx = (m.ax + f * (m.bx - m.ax)) - (m.x0 + g * (m.x1 - m.x0))
        dy = (m.ay + f * (m.by - m.ay)) - (m.y0 + g * (m.y1 - m.y0))
        if np.hypot(dx, dy).min() < m.d - float(m.quarter_tol):
            seen.append(delta)
    return np.array(seen)
