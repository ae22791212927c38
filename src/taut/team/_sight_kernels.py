"""Kernels of sight: when walls lie between two robots that move steadily, from roots of quadratics."""

from __future__ import annotations

from math import sqrt
from typing import NamedTuple

from taut.team._conflict_kernels import Floats, Ints
from taut.team._lean import lean_kernel


class Walls(NamedTuple):
    """Sides of obstacles that block the sight, in a uniform grid, and what a question writes into.

    Parameters
    ----------
    sides : (s, 4) x0, y0, x1, y1; none where walls do not matter.
    frame, shape : of the grid: x0, y0, side of a cell; columns, rows.
    cell_first, cell_side : the sides near each cell.
    seen : (s,) the question that last met each side.
    mark : (1,) of the last question.
    dark : (d, 2) stretches out of sight that it found.
    """

    sides: Floats
    frame: Floats
    shape: Ints
    cell_first: Ints
    cell_side: Ints
    seen: Ints
    mark: Ints
    dark: Floats


@lean_kernel
def out_of_sight(
    walls: Walls,
    px: float,
    py: float,
    ux: float,
    uy: float,
    qx: float,
    qy: float,
    vx: float,
    vy: float,
    span: float,
) -> int:
    """Write the merged stretches of [0, span] in which a side lies between two robots; −1 if there is no room.

    A side comes between, or no longer does, when one of its ends enters or leaves the segment between the robots
    (roots of a quadratic), or a robot crosses its line; between these instants nothing changes.
    """
    x0, x1 = (
        min(min(px, px + span * ux), min(qx, qx + span * vx)),
        max(max(px, px + span * ux), max(qx, qx + span * vx)),
    )
    y0, y1 = (
        min(min(py, py + span * uy), min(qy, qy + span * vy)),
        max(max(py, py + span * uy), max(qy, qy + span * vy)),
    )
    frame, columns, rows = walls.frame, walls.shape[0], walls.shape[1]
    col0, col1 = _clamped((x0 - frame[0]) / frame[2], columns), _clamped((x1 - frame[0]) / frame[2], columns)
    row0, row1 = _clamped((y0 - frame[1]) / frame[2], rows), _clamped((y1 - frame[1]) / frame[2], rows)
    walls.mark[0] += 1
    mark = walls.mark[0]
    count = 0
    for row in range(row0, row1 + 1):
        for col in range(col0, col1 + 1):
            cell = row * columns + col
            for k in range(walls.cell_first[cell], walls.cell_first[cell + 1]):
                i = walls.cell_side[k]
                if walls.seen[i] == mark:
                    continue
                walls.seen[i] = mark
                cx, cy, dx, dy = walls.sides[i, 0], walls.sides[i, 1], walls.sides[i, 2], walls.sides[i, 3]
                if max(cx, dx) < x0 or min(cx, dx) > x1 or max(cy, dy) < y0 or min(cy, dy) > y1:
                    continue
                count = _hidden_by(walls, cx, cy, dx, dy, px, py, ux, uy, qx, qy, vx, vy, span, count)
                if count < 0:
                    return -1
    return _merged(walls.dark, count)


@lean_kernel
def _hidden_by(
    walls: Walls,
    cx: float,
    cy: float,
    dx: float,
    dy: float,
    px: float,
    py: float,
    ux: float,
    uy: float,
    qx: float,
    qy: float,
    vx: float,
    vy: float,
    span: float,
    count: int,
) -> int:
    """Add the stretches in which one side is between the robots."""
    ex, ey = dx - cx, dy - cy
    p0, p1 = ex * (py - cy) - ey * (px - cx), ex * (py + span * uy - cy) - ey * (px + span * ux - cx)
    q0, q1 = ex * (qy - cy) - ey * (qx - cx), ex * (qy + span * vy - cy) - ey * (qx + span * vx - cx)
    if (p0 > 0.0 and p1 > 0.0 and q0 > 0.0 and q1 > 0.0) or (p0 < 0.0 and p1 < 0.0 and q0 < 0.0 and q1 < 0.0):
        return count
    first = walls.dark.shape[0] - 8  # the last rows are for the instants
    times = walls.dark
    n = 0
    for k in range(2):
        at, end = (p0, p1) if k == 0 else (q0, q1)
        if (at < 0.0) != (end < 0.0) and at != end:
            times[first + n, 0] = span * (at / (at - end))
            n += 1
    wx, wy, rx, ry = qx - px, qy - py, vx - ux, vy - uy
    for k in range(2):
        gx, gy = (cx - px, cy - py) if k == 0 else (dx - px, dy - py)
        # (w + t r) × (g − t u) = A t² + B t + C
        a = -(rx * uy - ry * ux)
        b = rx * gy - ry * gx - (wx * uy - wy * ux)
        c = wx * gy - wy * gx
        disc = b * b - 4.0 * a * c
        if disc < 0.0:
            continue
        big = -0.5 * (b + (sqrt(disc) if b >= 0.0 else -sqrt(disc)))
        for j in range(2):
            bottom = a if j == 0 else big
            top = big if j == 0 else c
            if bottom != 0.0:
                t = top / bottom
                if t > 0.0 and t < span:
                    times[first + n, 0] = t
                    n += 1
    for i in range(1, n):
        value = times[first + i, 0]
        j = i - 1
        while j >= 0 and times[first + j, 0] > value:
            times[first + j + 1, 0] = times[first + j, 0]
            j -= 1
        times[first + j + 1, 0] = value
    before = 0.0
    for i in range(n + 1):
        after = span if i == n else min(max(times[first + i, 0], 0.0), span)
        if after > before or (n == 0 and span == 0.0):
            t = 0.5 * (before + after)
            if _crosses(cx, cy, dx, dy, px + t * ux, py + t * uy, qx + t * vx, qy + t * vy):
                if count >= first:
                    return -1
                times[count, 0], times[count, 1] = before, after
                count += 1
        before = max(before, after)
    return count


@lean_kernel
def _crosses(cx: float, cy: float, dx: float, dy: float, px: float, py: float, qx: float, qy: float) -> bool:
    """Whether two closed segments meet; where all four points are on one line, whether their boxes do."""
    p = (dx - cx) * (py - cy) - (dy - cy) * (px - cx)
    q = (dx - cx) * (qy - cy) - (dy - cy) * (qx - cx)
    c = (qx - px) * (cy - py) - (qy - py) * (cx - px)
    d = (qx - px) * (dy - py) - (qy - py) * (dx - px)
    if (p > 0.0 and q > 0.0) or (p < 0.0 and q < 0.0) or (c > 0.0 and d > 0.0) or (c < 0.0 and d < 0.0):
        return False
    return max(min(px, qx), min(cx, dx)) <= min(max(px, qx), max(cx, dx)) and max(min(py, qy), min(cy, dy)) <= min(
        max(py, qy), max(cy, dy)
    )


@lean_kernel
def _merged(dark: Floats, count: int) -> int:
    """Sort stretches and join those that meet."""
    for i in range(1, count):
        a, b = dark[i, 0], dark[i, 1]
        j = i - 1
        while j >= 0 and dark[j, 0] > a:
            dark[j + 1, 0], dark[j + 1, 1] = dark[j, 0], dark[j, 1]
            j -= 1
        dark[j + 1, 0], dark[j + 1, 1] = a, b
    n = 0
    for i in range(count):
        if n > 0 and dark[i, 0] <= dark[n - 1, 1]:
            dark[n - 1, 1] = max(dark[n - 1, 1], dark[i, 1])
        else:
            dark[n, 0], dark[n, 1] = dark[i, 0], dark[i, 1]
            n += 1
    return n


@lean_kernel
def _clamped(at: float, n: int) -> int:
    return min(max(int(at), 0), n - 1)
