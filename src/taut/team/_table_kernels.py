"""Kernels of reservations: who has taken which place when, in a table that is edited in place, without copies."""

from __future__ import annotations

from math import inf
from typing import NamedTuple

from taut.team._conflict_kernels import Floats, Ints
from taut.team._grid_kernels import cell_along, passage, rows_near, spans_of
from taut.team._lean import lean_kernel


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
    columns = cell_along(max(x0, x1) + reach, frame[0], frame[2], shape[0])
    columns -= cell_along(min(x0, x1) - reach, frame[0], frame[2], shape[0]) - 1
    rows = cell_along(max(y0, y1) + reach, frame[1], frame[2], shape[1])
    rows -= cell_along(min(y0, y1) - reach, frame[1], frame[2], shape[1]) - 1
    if legs[k, 5] == inf:
        return columns * rows
    # one more, as rounding may move the end of a part
    spans = spans_of(legs[k, 2], legs[k, 5], frame, shape)[1] + 1
    return columns * rows * spans


@lean_kernel
def _enter_leg(table: Table, i: int) -> None:
    frame, shape, reach = table.frame, table.shape, table.reach[0]
    x0, y0, x1, y1 = table.legs[i, 0], table.legs[i, 1], table.legs[i, 3], table.legs[i, 4]
    t0, t1 = table.legs[i, 2], table.legs[i, 5]
    col0 = cell_along(min(x0, x1) - reach, frame[0], frame[2], shape[0])
    col1 = cell_along(max(x0, x1) + reach, frame[0], frame[2], shape[0])
    for col in range(col0, col1 + 1):
        row0, row1 = rows_near(x0, y0, x1, y1, reach, col, frame, shape[1])
        for row in range(row0, row1 + 1):
            span0, spans = shape[2], 1
            if t1 < inf:
                first_part, last_part = passage(x0, y0, x1, y1, reach, col, row, frame)
                if first_part > last_part:
                    continue
                span0, spans = spans_of(t0 + first_part * (t1 - t0), t0 + last_part * (t1 - t0), frame, shape)
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
