"""Kernels that ask a table of reservations: when a place is free, when an edge may be used, who is in the way."""

from __future__ import annotations

from math import inf

import numpy as np

from taut.arrays import longer
from taut.compiling import kernel
from taut.team._conflict_kernels import Floats, Ints, edge_conflict, rest_conflict
from taut.team._grid_kernels import cell_along, cell_of, passage, rows_near, spans_of
from taut.team._lean import lean_kernel
from taut.team._table_kernels import Table

_SURELY = 1.0 + 2.0**-20  # squared distances are compared with so much to spare before the closed form decides


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
    span0, spans = spans_of(begin, end, frame, shape)
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
    col0 = cell_along(min(ax, bx) - slack, frame[0], frame[2], shape[0])
    col1 = cell_along(max(ax, bx) + slack, frame[0], frame[2], shape[0])
    for col in range(col0, col1 + 1):
        row0, row1 = rows_near(ax, ay, bx, by, slack, col, frame, shape[1])
        for row in range(row0, row1 + 1):
            cell = row * shape[0] + col
            first_part, last_part = passage(ax, ay, bx, by, slack, col, row, frame)
            if first_part > last_part:
                continue
            from_time = max(depart + first_part * tau - headway, 0.0)
            until_time = depart + last_part * tau + headway
            span0, spans = spans_of(from_time, until_time, frame, shape)
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
    col0 = cell_along(min(ax, bx) - slack, frame[0], frame[2], shape[0])
    col1 = cell_along(max(ax, bx) + slack, frame[0], frame[2], shape[0])
    for col in range(col0, col1 + 1):
        row0, row1 = rows_near(ax, ay, bx, by, slack, col, frame, shape[1])
        for row in range(row0, row1 + 1):
            first_part, last_part = passage(ax, ay, bx, by, slack, col, row, frame)
            if first_part > last_part:
                continue
            from_time = max(depart + first_part * tau - headway, 0.0)
            span0, spans = spans_of(from_time, depart + last_part * tau + headway, frame, shape)
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
        col0 = cell_along(min(ax, bx) - slack, frame[0], frame[2], shape[0])
        col1 = cell_along(max(ax, bx) + slack, frame[0], frame[2], shape[0])
        for col in range(col0, col1 + 1):
            row0, row1 = rows_near(ax, ay, bx, by, slack, col, frame, shape[1])
            for row in range(row0, row1 + 1):
                first_part, last_part = passage(ax, ay, bx, by, slack, col, row, frame)
                if first_part > last_part:
                    continue
                from_time = max(depart[edge] + first_part * tau[edge] - headway, 0.0)
                span0, spans = spans_of(from_time, depart[edge] + last_part * tau[edge] + headway, frame, shape)
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
