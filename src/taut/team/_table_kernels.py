"""Kernels of reservations: who has taken which place when, in a table that is edited in place, without copies."""

from __future__ import annotations

from math import inf
from typing import NamedTuple

import numpy as np

from taut.arrays import longer
from taut.compiling import kernel
from taut.team._conflict_kernels import Floats, Ints, edge_conflict, rest_conflict
from taut.team._lean import lean_kernel

_SURELY = 1.0 + 2.0**-20  # squared distances are compared with so much to spare before the closed form decides


class Table(NamedTuple):
    """Motions, as legs that stand in every cell of a uniform grid that they come within ``reach`` of.

    So whoever asks about a place looks into one cell only. In a cell legs are sorted into spans of time, taken modulo
    the number of spans, and one last span for rests for ever. Those of a cell and span are a linked list of entries:
    head[cell, span], then following[entry].

    Parameters
    ----------
    legs : (k, 6) x0, y0, t0, x1, y1, t1.
    robot, radius : (k,) of each leg; no robot, −1, where it is free.
    head : (cells, spans + 1) first entry of each list, −1 where it is empty.
    entry, following : (e,) leg of each entry, and the entry after it.
    frame : x0, y0, side of a cell, seconds of a span.
    shape : columns, rows, spans.
    pace : (k, 2) velocity on each leg, metres a second.
    previous : entry before each in its list, −1 at its head.
    slot : cell · (spans + 1) + span of each entry.
    beside : next entry of the same leg; free entries form a list, too.
    first_entry : of each leg.
    next_leg : after each leg in its motion; free legs form a list, too.
    first_leg : of each robot's motion, −1 if there is none.
    reach : (1,) metres from a leg within which it stands in a cell.
    free : first free leg, first free entry, how many free legs, how many free entries.
    """

    legs: Floats
    robot: Ints
    radius: Floats
    head: Ints
    entry: Ints
    following: Ints
    frame: Floats
    shape: Ints
    pace: Floats
    previous: Ints
    slot: Ints
    beside: Ints
    first_entry: Ints
    next_leg: Ints
    first_leg: Ints
    reach: Floats
    free: Ints


@lean_kernel
def clear_table(table: Table) -> None:
    """Make all legs and entries free."""
    table.head[:] = -1
    table.first_leg[:] = -1
    legs, entries = table.robot.shape[0], table.entry.shape[0]
    for i in range(legs):
        table.robot[i] = -1
        table.next_leg[i] = i + 1 if i + 1 < legs else -1
    for e in range(entries):
        table.beside[e] = e + 1 if e + 1 < entries else -1
    table.free[0], table.free[1], table.free[2], table.free[3] = 0, 0, legs, entries


@lean_kernel
def take_out(table: Table, first: int) -> None:
    """Take a motion, given by its first leg, out of the grid; it stays in the arrays, to be put back or given up."""
    i = first
    while i >= 0:
        e = table.first_entry[i]
        while e >= 0:
            before, after = table.previous[e], table.following[e]
            if before >= 0:
                table.following[before] = after
            else:
                span = table.slot[e] % table.head.shape[1]
                table.head[table.slot[e] // table.head.shape[1], span] = after
            if after >= 0:
                table.previous[after] = before
            e = table.beside[e]
        i = table.next_leg[i]


@lean_kernel
def put_back(table: Table, first: int) -> None:
    """Put a motion that was taken out into the grid again."""
    i = first
    while i >= 0:
        e = table.first_entry[i]
        while e >= 0:
            _link(table, e)
            e = table.beside[e]
        i = table.next_leg[i]


@lean_kernel
def give_up(table: Table, first: int) -> None:
    """Free the legs and entries of a motion that was taken out."""
    i = first
    while i >= 0:
        e = table.first_entry[i]
        while e >= 0:
            after = table.beside[e]
            table.beside[e] = table.free[1]
            table.free[1] = e
            table.free[3] += 1
            e = after
        following = table.next_leg[i]
        table.robot[i] = -1
        table.next_leg[i] = table.free[0]
        table.free[0] = i
        table.free[2] += 1
        i = following


@lean_kernel
def enter_motion(table: Table, robot: int, radius: float, legs: Floats, count: int) -> bool:
    """Reserve the first ``count`` legs for a robot that has none; False, and nothing done, where there is no room."""
    if table.free[2] < count:
        return False
    last = -1
    table.first_leg[robot] = -1
    for k in range(count):
        if table.free[3] < _most_entries(legs, k, table.reach[0], table.frame, table.shape):
            take_out(table, table.first_leg[robot])
            give_up(table, table.first_leg[robot])
            table.first_leg[robot] = -1
            return False
        i = table.free[0]
        table.free[0] = table.next_leg[i]
        table.free[2] -= 1
        for c in range(6):
            table.legs[i, c] = legs[k, c]
        table.robot[i], table.radius[i] = robot, radius
        table.pace[i, 0] = (legs[k, 3] - legs[k, 0]) / (legs[k, 5] - legs[k, 2])
        table.pace[i, 1] = (legs[k, 4] - legs[k, 1]) / (legs[k, 5] - legs[k, 2])
        table.first_entry[i], table.next_leg[i] = -1, -1
        if last < 0:
            table.first_leg[robot] = i
        else:
            table.next_leg[last] = i
        last = i
        _enter_leg(table, i)
    return True


@lean_kernel
def legs_from(stamps: Floats, count: int, stays: bool, legs: Floats) -> int:
    """Write the legs of a motion; with ``stays`` it rests at its end for ever."""
    for k in range(count - 1):
        legs[k, 0], legs[k, 1], legs[k, 2] = stamps[k, 1], stamps[k, 2], stamps[k, 0]
        legs[k, 3], legs[k, 4], legs[k, 5] = stamps[k + 1, 1], stamps[k + 1, 2], stamps[k + 1, 0]
    if not stays:
        return count - 1
    k = count - 1
    legs[k, 0], legs[k, 1], legs[k, 2] = stamps[k, 1], stamps[k, 2], stamps[k, 0]
    legs[k, 3], legs[k, 4], legs[k, 5] = stamps[k, 1], stamps[k, 2], inf
    return count


@lean_kernel
def copied_legs(table: Table, first: int, legs: Floats) -> int:
    """Write the legs of a motion, given by its first one."""
    count = 0
    while first >= 0:
        for c in range(6):
            legs[count, c] = table.legs[first, c]
        count += 1
        first = table.next_leg[first]
    return count


@lean_kernel
def _most_entries(legs: Floats, k: int, reach: float, frame: Floats, shape: Ints) -> int:
    """No fewer entries than leg k needs."""
    x0, y0, x1, y1 = legs[k, 0], legs[k, 1], legs[k, 3], legs[k, 4]
    columns = _cell(max(x0, x1) + reach, frame[0], frame[2], shape[0])
    columns -= _cell(min(x0, x1) - reach, frame[0], frame[2], shape[0]) - 1
    rows = _cell(max(y0, y1) + reach, frame[1], frame[2], shape[1])
    rows -= _cell(min(y0, y1) - reach, frame[1], frame[2], shape[1]) - 1
    spans = 1 if legs[k, 5] == inf else _spans(legs[k, 2], legs[k, 5], frame, shape)[1] + 1  # rounding of a part's end
    return columns * rows * spans


@lean_kernel
def _enter_leg(table: Table, i: int) -> None:
    frame, shape, reach = table.frame, table.shape, table.reach[0]
    x0, y0, x1, y1 = table.legs[i, 0], table.legs[i, 1], table.legs[i, 3], table.legs[i, 4]
    t0, t1 = table.legs[i, 2], table.legs[i, 5]
    col0 = _cell(min(x0, x1) - reach, frame[0], frame[2], shape[0])
    col1 = _cell(max(x0, x1) + reach, frame[0], frame[2], shape[0])
    for col in range(col0, col1 + 1):
        row0, row1 = _rows(x0, y0, x1, y1, reach, col, frame, shape[1])
        for row in range(row0, row1 + 1):
            span0, spans = shape[2], 1
            if t1 < inf:
                first_part, last_part = _passage(x0, y0, x1, y1, reach, col, row, frame)
                if first_part > last_part:
                    continue
                span0, spans = _spans(t0 + first_part * (t1 - t0), t0 + last_part * (t1 - t0), frame, shape)
            for k in range(spans):
                span = span0 if span0 == shape[2] else (span0 + k) % shape[2]
                e = table.free[1]
                table.free[1] = table.beside[e]
                table.free[3] -= 1
                table.entry[e] = i
                table.slot[e] = (row * shape[0] + col) * (shape[2] + 1) + span
                table.beside[e] = table.first_entry[i]
                table.first_entry[i] = e
                _link(table, e)


@lean_kernel
def _link(table: Table, e: int) -> None:
    """Put an entry at the head of its list."""
    cell, span = table.slot[e] // table.head.shape[1], table.slot[e] % table.head.shape[1]
    after = table.head[cell, span]
    table.previous[e], table.following[e] = -1, after
    if after >= 0:
        table.previous[after] = e
    table.head[cell, span] = e


@lean_kernel
def cell_of(x: float, y: float, frame: Floats, shape: Ints) -> int:
    """The cell in which a place lies."""
    row: int = _cell(y, frame[1], frame[2], shape[1])
    return row * int(shape[0]) + _cell(x, frame[0], frame[2], shape[0])


# --- The grid ---------------------------------------------------------------------------------------------------------


@lean_kernel
def _cell(x: float, x0: float, step: float, n: int) -> int:
    return min(max(int((x - x0) / step), 0), n - 1)


@lean_kernel
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


@lean_kernel
def _spans(t0: float, t1: float, frame: Floats, shape: Ints) -> tuple[int, int]:
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
def _passage(
    ax: float, ay: float, bx: float, by: float, reach: float, col: int, row: int, frame: Floats
) -> tuple[float, float]:
    """Fractions of the way from a to b within ``reach`` of a cell, as (first, last); first > last if there are none."""
    x, y = frame[0] + col * frame[2], frame[1] + row * frame[2]
    f0, f1 = _within(ax, bx, x - reach, x + frame[2] + reach)
    g0, g1 = _within(ay, by, y - reach, y + frame[2] + reach)
    return max(f0, g0), min(f1, g1)


# --- Questions --------------------------------------------------------------------------------------------------------


@lean_kernel
def forbidden_times(
    table: Table,
    x: float,
    y: float,
    who: int,
    apart: float,
    headway: float,
    begin: float,
    end: float,
    lo: Floats,
    hi: Floats,
    stamp: Ints,
    mark: int,
) -> int:
    """Write forbidden times of a place, as far as they matter between ``begin`` and ``end``: merged open intervals.

    Returns how many there are, −1 if ``lo`` and ``hi`` are too short.
    """
    legs, robot, frame, shape = table.legs, table.robot, table.frame, table.shape
    begin, end = max(begin - headway, 0.0), end + headway
    cell = cell_of(x, y, frame, shape)
    span0, spans = _spans(begin, end, frame, shape)
    count = 0
    for k in range(spans + 1):
        e = table.head[cell, shape[2] if k == spans else (span0 + k) % shape[2]]
        while e >= 0:
            i = table.entry[e]
            e = table.following[e]
            if stamp[i] == mark or robot[i] == who or legs[i, 5] < begin or legs[i, 2] > end:
                continue
            stamp[i] = mark
            d = apart + table.radius[i]
            found, a, b = rest_conflict(x, y, legs[i, 0], legs[i, 1], legs[i, 2], legs[i, 3], legs[i, 4], legs[i, 5], d)
            if found:
                if count == lo.shape[0]:
                    return -1
                lo[count], hi[count] = a - headway, b + headway
                count += 1
    return merge(lo, hi, count)


@lean_kernel
def merge(lo: Floats, hi: Floats, count: int) -> int:
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


@lean_kernel
def first_departure(
    table: Table,
    edge: tuple[float, float, float, float],
    tau: float,
    earliest: float,
    latest: float,
    who: int,
    apart: float,
    headway: float,
) -> float:
    """Find the first departure in [earliest, latest] without conflict, inf if there is none."""
    depart = earliest
    while depart <= latest and depart < inf:
        later = _put_off(table, edge, tau, depart, latest, 1, who, apart, headway)
        if later == depart:
            return depart
        depart = later
    return inf


@lean_kernel
def last_departure(
    table: Table,
    edge: tuple[float, float, float, float],
    tau: float,
    earliest: float,
    latest: float,
    who: int,
    apart: float,
    headway: float,
) -> float:
    """Find the last departure in [earliest, latest] without conflict, −inf if there is none."""
    depart = latest
    while depart >= earliest:
        sooner = _put_off(table, edge, tau, depart, earliest, -1, who, apart, headway)
        if sooner == depart:
            return depart
        depart = sooner
    return -inf


@lean_kernel
def _put_off(
    table: Table,
    edge: tuple[float, float, float, float],
    tau: float,
    depart: float,
    limit: float,
    way: int,
    who: int,
    apart: float,
    headway: float,
) -> float:
    """Go once through the legs near an edge; past each in conflict put the departure off, or forward if way is −1.

    Legs are compared with this one departure first, which takes no root; only where that is too near are the forbidden
    departures worked out.
    """
    ax, ay, bx, by = edge
    legs, pace, robot, frame, shape = table.legs, table.pace, table.robot, table.frame, table.shape
    ux, uy = (bx - ax) / tau, (by - ay) / tau
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
            from_time = max(depart + first_part * tau - headway, 0.0)
            until_time = depart + last_part * tau + headway
            span0, spans = _spans(from_time, until_time, frame, shape)
            for k in range(spans + 1):
                e = table.head[cell, shape[2] if k == spans else (span0 + k) % shape[2]]
                while e >= 0:
                    i = table.entry[e]
                    e = table.following[e]
                    begin, end = max(depart - headway, legs[i, 2]), min(depart + tau + headway, legs[i, 5])
                    if begin >= end or robot[i] == who:
                        continue
                    d = apart + table.radius[i]
                    if headway == 0.0:
                        # least distance of two steady motions in the time that both have
                        wx = ax - legs[i, 0] + (begin - depart) * ux - (begin - legs[i, 2]) * pace[i, 0]
                        wy = ay - legs[i, 1] + (begin - depart) * uy - (begin - legs[i, 2]) * pace[i, 1]
                        rx, ry = ux - pace[i, 0], uy - pace[i, 1]
                        square = rx * rx + ry * ry
                        dot = wx * rx + wy * ry
                        since = 0.0
                        if dot < 0.0:
                            since = min(-dot / square, end - begin) if square > 0.0 else 0.0
                        wx, wy = wx + since * rx, wy + since * ry
                        if wx * wx + wy * wy >= _SURELY * d * d:
                            continue
                    found, lo, hi = edge_conflict(
                        ax, ay, bx, by, tau, legs[i, 0], legs[i, 1], legs[i, 2], legs[i, 3], legs[i, 4], legs[i, 5], d
                    )
                    if found and lo - headway < depart < hi + headway:
                        depart = hi + headway if way > 0 else lo - headway
                        if not (depart - limit) * way <= 0.0:  # beyond, or never
                            return depart
    return depart


@lean_kernel
def robots_met(
    table: Table,
    edge: tuple[float, float, float, float],
    tau: float,
    depart: float,
    who: int,
    apart: float,
    headway: float,
    lasting: float,
    met: Ints,
    count: int,
) -> int:
    """Add the robots that a move along an edge comes too near to, each once; returns how many there are then.

    Legs that end before ``lasting`` do not count.
    """
    ax, ay, bx, by = edge
    legs, robot, frame, shape = table.legs, table.robot, table.frame, table.shape
    slack = 1e-6 * frame[2]
    col0 = _cell(min(ax, bx) - slack, frame[0], frame[2], shape[0])
    col1 = _cell(max(ax, bx) + slack, frame[0], frame[2], shape[0])
    for col in range(col0, col1 + 1):
        row0, row1 = _rows(ax, ay, bx, by, slack, col, frame, shape[1])
        for row in range(row0, row1 + 1):
            first_part, last_part = _passage(ax, ay, bx, by, slack, col, row, frame)
            if first_part > last_part:
                continue
            from_time = max(depart + first_part * tau - headway, 0.0)
            span0, spans = _spans(from_time, depart + last_part * tau + headway, frame, shape)
            for k in range(spans + 1):
                e = table.head[row * shape[0] + col, shape[2] if k == spans else (span0 + k) % shape[2]]
                while e >= 0:
                    i = table.entry[e]
                    e = table.following[e]
                    if robot[i] == who or legs[i, 5] < max(depart - headway, lasting):
                        continue
                    d = apart + table.radius[i]
                    found, lo, hi = edge_conflict(
                        ax, ay, bx, by, tau, legs[i, 0], legs[i, 1], legs[i, 2], legs[i, 3], legs[i, 4], legs[i, 5], d
                    )
                    if found and lo - headway < depart < hi + headway:
                        count = noted(met, count, robot[i])
    return count


@lean_kernel
def noted(met: Ints, count: int, j: int) -> int:
    """Add a robot that is not there yet; returns how many there are then."""
    for k in range(count):
        if met[k] == j:
            return count
    met[count] = j
    return count + 1


@kernel
def legs_met(
    table: Table, positions: Floats, tau: Floats, depart: Floats, who: int, apart: float, headway: float
) -> tuple[Ints, Ints]:
    """Reserved legs in conflict with a motion along ``positions`` that leaves vertex k at depart[k]: (leg, k) pairs."""
    legs, frame, shape = table.legs, table.frame, table.shape
    asked = np.full(legs.shape[0], -1, dtype=np.int64)
    slack = 1e-6 * frame[2]
    count = 0
    found_leg = np.empty(64, dtype=np.int64)
    found_edge = np.empty(64, dtype=np.int64)
    for edge in range(tau.shape[0]):
        ax, ay, bx, by = positions[edge, 0], positions[edge, 1], positions[edge + 1, 0], positions[edge + 1, 1]
        col0 = _cell(min(ax, bx) - slack, frame[0], frame[2], shape[0])
        col1 = _cell(max(ax, bx) + slack, frame[0], frame[2], shape[0])
        for col in range(col0, col1 + 1):
            row0, row1 = _rows(ax, ay, bx, by, slack, col, frame, shape[1])
            for row in range(row0, row1 + 1):
                first_part, last_part = _passage(ax, ay, bx, by, slack, col, row, frame)
                if first_part > last_part:
                    continue
                from_time = max(depart[edge] + first_part * tau[edge] - headway, 0.0)
                span0, spans = _spans(from_time, depart[edge] + last_part * tau[edge] + headway, frame, shape)
                for k in range(spans + 1):
                    e = table.head[row * shape[0] + col, shape[2] if k == spans else (span0 + k) % shape[2]]
                    while e >= 0:
                        i = table.entry[e]
                        e = table.following[e]
                        if asked[i] == edge or table.robot[i] == who:
                            continue
                        asked[i] = edge
                        x0, y0, t0, x1, y1, t1 = legs[i]
                        d = apart + table.radius[i]
                        found, lo, hi = edge_conflict(ax, ay, bx, by, tau[edge], x0, y0, t0, x1, y1, t1, d)
                        if found and lo - headway < depart[edge] < hi + headway:
                            if count == found_leg.shape[0]:
                                found_leg, found_edge = longer(found_leg), longer(found_edge)
                            found_leg[count], found_edge[count] = i, edge
                            count += 1
    return found_leg[:count], found_edge[:count]
