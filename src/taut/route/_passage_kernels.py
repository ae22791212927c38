"""Kernels of the widest passage: nearest sides by a sweep, and sets of sides that know how they wind round two points.

A side is a row x0, y0, x1, y1; both ends are the same for the centre of a circle. The weight of two sides is half the
free gap between them: how far both have to grow, beyond their own radii, until they meet.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from taut.arrays import longer
from taut.compiling import kernel
from taut.geometry._kernels import orient, segments_cross

Floats = NDArray[np.float64]
Ints = NDArray[np.int64]


@kernel
def shapes_round(sides: Floats, owner: Ints, count: int, x: float, y: float) -> NDArray[np.bool_]:
    """For each of ``count`` shapes whether its sides, taken as a ring, go round a point that is on none. Exact."""
    out = np.zeros(count, dtype=np.bool_)
    for i in range(sides.shape[0]):
        if (sides[i, 1] > y) != (sides[i, 3] > y):
            left = orient(sides[i, 0], sides[i, 1], sides[i, 2], sides[i, 3], x, y) > 0.0
            if left == (sides[i, 3] > sides[i, 1]):
                out[owner[i]] = not out[owner[i]]
    return out


@kernel
def feet(sides: Floats, x: float, y: float) -> tuple[Floats, Floats]:
    """Distance of a point from each side, (n,), and the nearest point on it, (n, 2)."""
    distance, at = np.empty(sides.shape[0]), np.empty((sides.shape[0], 2))
    for i in range(sides.shape[0]):
        distance[i], at[i, 0], at[i, 1] = _foot(sides, i, x, y)
    return distance, at


@kernel
def _foot(sides: Floats, i: int, x: float, y: float) -> tuple[float, float, float]:
    """Distance of a point from side i, and the nearest point on it."""
    ax, ay = sides[i, 0], sides[i, 1]
    ex, ey = sides[i, 2] - ax, sides[i, 3] - ay
    square = ex * ex + ey * ey
    f = min(max(((x - ax) * ex + (y - ay) * ey) / square, 0.0), 1.0) if square > 0.0 else 0.0
    px, py = ax + f * ex, ay + f * ey
    if f == 1.0:
        px, py = sides[i, 2], sides[i, 3]
    return np.hypot(x - px, y - py), px, py


@kernel
def nearest_points(sides: Floats, i: int, j: int) -> tuple[float, float, float, float, float]:
    """Distance of sides i and j, the nearest point on i, the nearest point on j."""
    best, px, py, qx, qy = np.inf, 0.0, 0.0, 0.0, 0.0
    for end in range(2):
        x, y = sides[i, 2 * end], sides[i, 2 * end + 1]
        d, fx, fy = _foot(sides, j, x, y)
        if d < best:
            best, px, py, qx, qy = d, x, y, fx, fy
    for end in range(2):
        x, y = sides[j, 2 * end], sides[j, 2 * end + 1]
        d, fx, fy = _foot(sides, i, x, y)
        if d < best:
            best, px, py, qx, qy = d, fx, fy, x, y
    ax, ay, bx, by = sides[i, 0], sides[i, 1], sides[i, 2], sides[i, 3]
    cx, cy, dx, dy = sides[j, 0], sides[j, 1], sides[j, 2], sides[j, 3]
    if best > 0.0 and segments_cross(ax, ay, bx, by, cx, cy, dx, dy):
        ex, ey, gx, gy = bx - ax, by - ay, dx - cx, dy - cy
        across = ex * gy - ey * gx
        if across != 0.0:
            f = min(max(((cx - ax) * gy - (cy - ay) * gx) / across, 0.0), 1.0)
            px, py = ax + f * ex, ay + f * ey
            qx, qy = px, py
        best = 0.0
    return best, px, py, qx, qy


@kernel
def _crosses(line: Floats, px: float, py: float, qx: float, qy: float) -> bool:
    """Whether p q crosses the segment ``line``; points on its line count as left of it, so closed walks add up."""
    ax, ay, bx, by = line[0], line[1], line[2], line[3]
    if (orient(ax, ay, bx, by, px, py) >= 0.0) == (orient(ax, ay, bx, by, qx, qy) >= 0.0):
        return False
    return (orient(px, py, qx, qy, ax, ay) >= 0.0) != (orient(px, py, qx, qy, bx, by) >= 0.0)


@kernel
def join_outlines(sides: Floats, following: Ints, line: Floats) -> tuple[Ints, Ints]:
    """Join every side with the one that begins at its end.

    Returns
    -------
    parent : (n,) a forest over the sides; sides of one tree are joined, roots are their own parents.
    odd : (n,) 1 if the way from the first end of a side to that of its parent crosses ``line`` an odd number of times.
    """
    n = sides.shape[0]
    parent, odd = np.arange(n), np.zeros(n, dtype=np.int64)
    for i in range(n):
        turn = _crosses(line, sides[i, 0], sides[i, 1], sides[i, 2], sides[i, 3])
        _join(parent, odd, i, following[i], 1 if turn else 0)
    return parent, odd


@kernel
def join_in_order(parent: Ints, odd: Ints, pairs: Ints, order: Ints) -> int:
    """Join pairs i, j, parity in this order; the first that closes a ring of odd parity, −1 for none."""
    for k in order:
        if not _join(parent, odd, pairs[k, 0], pairs[k, 1], pairs[k, 2]):
            return int(k)
    return -1


@kernel
def _root(parent: Ints, odd: Ints, i: int) -> tuple[int, int]:
    """The root of a side's set, and the parity of crossings on the way to it; ways are shortened."""
    root, total = i, 0
    while parent[root] != root:
        total ^= odd[root]
        root = parent[root]
    at, rest = i, total
    while parent[at] != root and at != root:
        up, step = parent[at], odd[at]
        parent[at], odd[at] = root, rest
        at, rest = up, rest ^ step
    return root, total


@kernel
def _join(parent: Ints, odd: Ints, i: int, j: int, parity: int) -> bool:
    """Join the sets of i and j; False if they are one already and the ring so closed is of odd parity."""
    a, to_a = _root(parent, odd, i)
    b, to_b = _root(parent, odd, j)
    if a == b:
        return (to_a ^ to_b ^ parity) == 0
    parent[max(a, b)] = min(a, b)
    odd[max(a, b)] = to_a ^ to_b ^ parity
    return True


@kernel
def pairs_within(
    sides: Floats,
    radius: Floats,
    order: Ints,
    line: Floats,
    least: float,
    most: float,
    tol: float,
    near: Ints,
    near_weight: Floats,
) -> tuple[Floats, Ints]:
    """Pairs of sides whose weight is above ``least`` and at most ``most``, except many that cannot matter.

    Where a third side comes nearer to the middle of a gap than its two sides, it meets both of them earlier, and when
    the gap is closed the middle belongs to all three: the pair then joins nothing and goes round nothing new.

    Parameters
    ----------
    order : (m,) the sides wanted, by their least x, own radius included.
    line : (4,) the segment whose crossings are counted.
    tol : metres by which the third side has to be nearer.
    near, near_weight : (n, 8) for each side the nearest known one in eight directions, −1 for none; changed.

    Returns
    -------
    weights : (k,) metres.
    pairs : (k, 3) sides i < j and 1 if the way from the first end of i over the gap to that of j crosses ``line``.
    """
    n = order.shape[0]
    weights = np.empty(1024, dtype=np.float64)
    flat = np.empty(4096, dtype=np.int64)
    count = 0
    low_x, high_x = np.empty(n), np.empty(n)
    low_y, high_y = np.empty(n), np.empty(n)
    for s in range(n):
        i = order[s]
        low_x[s] = min(sides[i, 0], sides[i, 2]) - radius[i]
        high_x[s] = max(sides[i, 0], sides[i, 2]) + radius[i]
        low_y[s] = min(sides[i, 1], sides[i, 3]) - radius[i]
        high_y[s] = max(sides[i, 1], sides[i, 3]) + radius[i]
    reach = 2.0 * most + tol
    for s in range(n):
        for t in range(s + 1, n):
            if low_x[t] > high_x[s] + reach:
                break
            if low_y[t] > high_y[s] + reach or high_y[t] < low_y[s] - reach:
                continue
            i, j = min(order[s], order[t]), max(order[s], order[t])
            d, px, py, qx, qy = nearest_points(sides, i, j)
            weight = (d - radius[i] - radius[j]) / 2.0
            if weight > most or weight <= least:
                continue
            if d > 0.0 and radius[i] + weight >= 0.0 and radius[j] + weight >= 0.0:
                share = (radius[i] + weight) / d
                x, y = px + share * (qx - px), py + share * (qy - py)
                if _taken(sides, radius, near, i, j, x, y, weight - tol):
                    continue
            _note(near, near_weight, i, j, qx - px, qy - py, weight)
            _note(near, near_weight, j, i, px - qx, py - qy, weight)
            turns = _crosses(line, sides[i, 0], sides[i, 1], px, py) != _crosses(line, px, py, qx, qy)
            turns = turns != _crosses(line, qx, qy, sides[j, 0], sides[j, 1])
            if count == weights.shape[0]:
                weights, flat = longer(weights), longer(flat)
            weights[count] = weight
            flat[3 * count], flat[3 * count + 1], flat[3 * count + 2] = i, j, 1 if turns else 0
            count += 1
    return weights[:count].copy(), flat[: 3 * count].copy().reshape(count, 3)


@kernel
def _taken(sides: Floats, radius: Floats, near: Ints, i: int, j: int, x: float, y: float, within: float) -> bool:
    """Whether a known neighbour of i or j, other than these, comes within so many metres of a point."""
    for m in range(16):
        k = near[i, m] if m < 8 else near[j, m - 8]
        if k >= 0 and k != i and k != j and _foot(sides, k, x, y)[0] - radius[k] < within:
            return True
    return False


@kernel
def _note(near: Ints, near_weight: Floats, i: int, j: int, dx: float, dy: float, weight: float) -> None:
    """Keep j as the neighbour of i in the direction (dx, dy) if none nearer is known; without direction it is none."""
    if dx == 0.0 and dy == 0.0:
        return
    way = (1 if dx > 0.0 else 0) + (2 if dy > 0.0 else 0) + (4 if abs(dx) > abs(dy) else 0)
    if weight < near_weight[i, way]:
        near[i, way], near_weight[i, way] = j, weight
