"""Kernels of the grid of reservations: which cells a leg comes near, in which part of its time."""

from __future__ import annotations

from taut.team._conflict_kernels import Floats, Ints
from taut.team._lean import lean_kernel

# A frame is x0, y0, side of a cell, seconds of a span; a shape is columns, rows, spans.


@lean_kernel
def cell_of(x: float, y: float, frame: Floats, shape: Ints) -> int:
    """The cell in which a place lies."""
    row: int = cell_along(y, frame[1], frame[2], shape[1])
    return row * int(shape[0]) + cell_along(x, frame[0], frame[2], shape[0])


@lean_kernel
def cell_along(x: float, x0: float, step: float, n: int) -> int:
    """The column or row in which a coordinate lies; beyond the grid the outermost."""
    return min(max(int((x - x0) / step), 0), n - 1)


@lean_kernel
def rows_near(
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
        cell_along(min(ya, yb) - reach, frame[1], frame[2], rows),
        cell_along(max(ya, yb) + reach, frame[1], frame[2], rows),
    )


@lean_kernel
def spans_of(t0: float, t1: float, frame: Floats, shape: Ints) -> tuple[int, int]:
    """First span of a stretch of time, before the modulus, and how many it touches (all of them at most)."""
    spans = shape[2]
    if t1 - t0 >= spans * frame[3]:
        return 0, spans
    first = int(t0 / frame[3])
    return first, min(int(t1 / frame[3]) - first + 1, spans)


@lean_kernel
def _within(a: float, b: float, lo: float, hi: float) -> tuple[float, float]:
    """Fractions of the way from a to b that lie between lo and hi, as (first, last)."""
    if a == b:
        return (0.0, 1.0) if lo <= a <= hi else (1.0, 0.0)
    f, g = (lo - a) / (b - a), (hi - a) / (b - a)
    return max(min(f, g), 0.0), min(max(f, g), 1.0)


@lean_kernel
def passage(
    ax: float, ay: float, bx: float, by: float, reach: float, col: int, row: int, frame: Floats
) -> tuple[float, float]:
    """Fractions of the way from a to b within ``reach`` of a cell, as (first, last); first > last if there are none."""
    x, y = frame[0] + col * frame[2], frame[1] + row * frame[2]
    f0, f1 = _within(ax, bx, x - reach, x + frame[2] + reach)
    g0, g1 = _within(ay, by, y - reach, y + frame[2] + reach)
    return max(f0, g0), min(f1, g1)
