"""Kernels of reservations: who has taken which place when, looked up in a grid over space and time."""

from __future__ import annotations

from math import inf
from typing import TypeAlias

import numpy as np
from numpy.typing import NDArray

from taut.arrays import longer
from taut.compiling import kernel
from taut.team._conflict_kernels import edge_conflict, rest_conflict

Floats: TypeAlias = NDArray[np.float64]
Ints: TypeAlias = NDArray[np.int64]
Reserved: TypeAlias = tuple[Floats, Ints, Floats, Ints, Ints, Ints, Floats, Ints]

# Legs reserved by planned robots stand in every cell of a uniform grid that they come within `reach` of, so whoever
# asks about a place looks into one cell only. In a cell they are sorted into spans of time, taken modulo the number of
# spans, and one last span for rests for ever. The legs of a cell and span are a linked list: head[cell, span], then
# following[entry].
# ``reserved`` = (legs (k, 6): x0, y0, t0, x1, y1, t1; robot (k,); radius (k,); head; entry; following; frame; shape)
# with frame = (x0, y0, side of a cell, seconds of a span) and shape = (columns, rows, spans).


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
                entry, following = longer(entry), longer(following)
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
        lo, hi = longer(lo), longer(hi)
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
def edge_conflicts(
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
def first_free(lo: Floats, hi: Floats, count: int, t: float) -> float:
    """The first time ≥ t outside the intervals."""
    for i in range(count):
        if lo[i] < t < hi[i]:
            t = hi[i]
    return t


@kernel
def last_free(lo: Floats, hi: Floats, count: int, t: float) -> float:
    """The last time ≤ t outside the intervals."""
    for i in range(count - 1, -1, -1):
        if lo[i] < t < hi[i]:
            t = lo[i]
    return t


@kernel
def earliest_departure(
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
        lo, hi, count = edge_conflicts(edge, tau, ready, until, reserved, who, body, lo, hi, stamp, mark)
        mark += 1
        ready = first_free(lo, hi, count, ready)
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
