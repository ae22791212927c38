"""Kernel of the column: the earliest way for one robot to rest and go along its stops between those already timed."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from taut.compiling import kernel

Floats = NDArray[np.float64]
Ints = NDArray[np.int64]


@kernel
def earliest(stops: Floats, others: Floats, needed: Floats, reach: float) -> Ints:
    """Number of the stop at each time until the last is reached, as early as can be for good; empty if it cannot be.

    Of equally early ways the one that departs latest, so that it rests as little as possible on the way.

    Parameters
    ----------
    stops : (m, 2) metres; from one time to the next the robot rests at a stop or moves to the next.
    others : (k, t, 2) metres, where the others are at the times; they rest after the last.
    needed : (k,) metres to keep from each of them.
    reach : metres within which one of them must be at both times, if there are others; may be inf.
    """
    m, horizon = stops.shape[0], others.shape[1]
    # 1: reached by resting, 2: by moving, which counts more
    came = np.zeros((horizon, m), dtype=np.int8)
    came[0, 0] = 1
    since = _free_since(stops, others, needed, reach)
    low, high, last = 0, 0, -1
    for t in range(horizon):
        if t >= since and came[t, m - 1] > 0:
            last = t
            break
        if t == horizon - 1:
            break
        top = high
        for s in range(low, top + 1):
            if came[t, s] == 0:
                continue
            if came[t + 1, s] == 0 and _allowed(stops, s, s, others, t, needed, reach):
                came[t + 1, s] = 1
            if s + 1 < m and _allowed(stops, s, s + 1, others, t, needed, reach):
                came[t + 1, s + 1] = 2
                high = max(high, s + 1)
        while low < high and came[t + 1, low] == 0:
            low += 1
    out = np.empty(last + 1, dtype=np.int64)
    s = m - 1
    for t in range(last, -1, -1):
        out[t] = s
        if came[t, s] == 2:
            s -= 1
    return out


@kernel
def _free_since(stops: Floats, others: Floats, needed: Floats, reach: float) -> int:
    """Time from which on a rest at the last stop is possible for good."""
    end = stops.shape[0] - 1
    for t in range(others.shape[1] - 2, -1, -1):
        if not _allowed(stops, end, end, others, t, needed, reach):
            return t + 1
    return 0


@kernel
def _allowed(stops: Floats, a: int, b: int, others: Floats, t: int, needed: Floats, reach: float) -> bool:
    """Whether from time t to the next the move between two stops keeps its distance from all, and one within reach."""
    count = others.shape[0]
    linked = count == 0 or reach == math.inf
    for k in range(count):
        x0, y0 = stops[a, 0] - others[k, t, 0], stops[a, 1] - others[k, t, 1]
        x1, y1 = stops[b, 0] - others[k, t + 1, 0], stops[b, 1] - others[k, t + 1, 1]
        dx, dy = x1 - x0, y1 - y0
        square = dx * dx + dy * dy
        share = 0.0
        if square > 0.0:
            share = min(1.0, max(0.0, -(x0 * dx + y0 * dy) / square))
        if math.hypot(x0 + share * dx, y0 + share * dy) < needed[k]:
            return False
        if not linked and math.hypot(x0, y0) <= reach and math.hypot(x1, y1) <= reach:
            linked = True
    return linked
