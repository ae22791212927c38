"""Kernels of hits: where a straight leg passes through solids that are given by their sides.

A solid is rows x0, y0, x1, y1 of sides, ``filled`` (0 the sides enclose nothing, 1 what they go round is solid, −1 what
they do not go round is) and ``reach``, the metres by which it extends beyond its sides.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from taut.compiling import kernel
from taut.geometry._kernels import orient

Floats = NDArray[np.float64]
Ints = NDArray[np.int64]


@kernel
def depth(sides: Floats, filled: int, reach: float, x: float, y: float) -> float:
    """How deep a place is in a solid; negative outside."""
    square = np.inf
    encloses = False
    for i in range(sides.shape[0]):
        ax, ay, bx, by = sides[i, 0], sides[i, 1], sides[i, 2], sides[i, 3]
        ex, ey, dx, dy = bx - ax, by - ay, x - ax, y - ay
        long = ex * ex + ey * ey
        f = min(max((dx * ex + dy * ey) / long, 0.0), 1.0) if long > 0.0 else 0.0
        dx, dy = (dx - f * ex, dy - f * ey) if f < 1.0 else (x - bx, y - by)
        square = min(square, dx * dx + dy * dy)
        if filled != 0 and (ay > y) != (by > y) and (orient(ax, ay, bx, by, x, y) > 0.0) == (by > ay):
            encloses = not encloses
    distance = np.sqrt(square)
    if filled != 0 and encloses == (filled > 0):
        distance = -distance
    return float(reach - distance)


@kernel
def spans(sides: Floats, filled: int, reach: float, a: Floats, b: Floats, tol: float) -> Floats:
    """Shares of a-b from entry to exit, (k, 2), where it passes deeper than ``tol`` through a solid."""
    out = np.empty((2 * sides.shape[0] + 2, 2))
    wx, wy = b[0] - a[0], b[1] - a[1]
    if wx == 0.0 and wy == 0.0:
        out[0, 0], out[0, 1] = 0.0, 0.0
        return out[: 1 if depth(sides, filled, reach, a[0], a[1]) > tol else 0].copy()
    cuts = _cuts(sides, reach, a, b)
    n, count = cuts.shape[0], 0
    deep = np.empty(n, dtype=np.bool_)
    for k in range(n):
        deep[k] = depth(sides, filled, reach, a[0] + cuts[k] * wx, a[1] + cuts[k] * wy) > tol
    for k in range(n - 1):
        middle = (cuts[k] + cuts[k + 1]) / 2.0
        inside = deep[k] or deep[k + 1]
        if not inside:
            inside = depth(sides, filled, reach, a[0] + middle * wx, a[1] + middle * wy) > tol
        if inside and count > 0 and out[count - 1, 1] == cuts[k]:
            out[count - 1, 1] = cuts[k + 1]
        elif inside:
            out[count, 0], out[count, 1] = cuts[k], cuts[k + 1]
            count += 1
    return out[:count].copy()


@kernel
def _cuts(sides: Floats, reach: float, a: Floats, b: Floats) -> Floats:
    """Shares of a-b, from 0 to 1, between which it neither enters nor leaves what is within ``reach`` of a side.

    Those beside the ends of sides are always among them, as no corner may be missed, and some where nothing happens.
    """
    wx, wy = b[0] - a[0], b[1] - a[1]
    length = np.hypot(wx, wy)
    cuts = np.empty(8 * sides.shape[0] + 2)
    cuts[0], cuts[1] = 0.0, 1.0
    count = 2
    for i in range(sides.shape[0]):
        for end in range(2):
            px, py = sides[i, 2 * end] - a[0], sides[i, 2 * end + 1] - a[1]
            along, off = (px * wx + py * wy) / length, (py * wx - px * wy) / length
            half = np.sqrt(max(reach * reach - off * off, 0.0))
            for s in (along - half, along + half):
                if 0.0 < s < length:
                    cuts[count] = s / length
                    count += 1
        ex, ey = sides[i, 2] - sides[i, 0], sides[i, 3] - sides[i, 1]
        side = np.hypot(ex, ey)
        across = wx * ey - wy * ex
        if across == 0.0 or side == 0.0:
            continue
        px, py = sides[i, 0] - a[0], sides[i, 1] - a[1]
        for sign in (-1.0, 1.0):
            s = (px * ey - py * ex + sign * reach * side) / across
            on_side = ((s * wx - px) * ex + (s * wy - py) * ey) / side
            if 0.0 < s < 1.0 and 0.0 <= on_side <= side:
                cuts[count] = s
                count += 1
    return np.sort(cuts[:count])


@kernel
def free_pairs(
    places: Floats, sides: Floats, first: Ints, filled: Ints, reach: Floats, tol: float
) -> NDArray[np.bool_]:
    """For all pairs of (n, 2) places whether the leg between them is nowhere deeper than ``tol`` in a solid, (n, n).

    Solid k has the sides ``first[k]`` to ``first[k + 1]``.
    """
    n, count = places.shape[0], first.shape[0] - 1
    low_x, high_x = np.full(count, np.inf), np.full(count, -np.inf)
    low_y, high_y = np.full(count, np.inf), np.full(count, -np.inf)
    for k in range(count):
        for i in range(first[k], first[k + 1]):
            low_x[k] = min(low_x[k], sides[i, 0] - reach[k], sides[i, 2] - reach[k])
            high_x[k] = max(high_x[k], sides[i, 0] + reach[k], sides[i, 2] + reach[k])
            low_y[k] = min(low_y[k], sides[i, 1] - reach[k], sides[i, 3] - reach[k])
            high_y[k] = max(high_y[k], sides[i, 1] + reach[k], sides[i, 3] + reach[k])
    out = np.zeros((n, n), dtype=np.bool_)
    for i in range(n):
        for j in range(i + 1, n):
            ax, ay, bx, by = places[i, 0], places[i, 1], places[j, 0], places[j, 1]
            out[i, j] = True
            for k in range(count):
                apart = max(ax, bx) < low_x[k] or min(ax, bx) > high_x[k]
                apart = apart or max(ay, by) < low_y[k] or min(ay, by) > high_y[k]
                if apart and filled[k] >= 0:
                    continue
                if spans(sides[first[k] : first[k + 1]], filled[k], reach[k], places[i], places[j], tol).shape[0] > 0:
                    out[i, j] = False
                    break
    return out
