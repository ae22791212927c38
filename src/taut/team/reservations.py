"""Reservations: what planned robots have taken of space and time, and the starts of those not planned yet."""

from __future__ import annotations

import math

import numpy as np

from taut.motion import Trajectory
from taut.scene import Scene
from taut.team import _table_kernels
from taut.team._conflict_kernels import Floats, Ints
from taut.team._table_kernels import Table

_SPANS = 48
_MOST_CELLS = 250  # in a row or a column, however small the robots are


def empty_table(scene: Scene, cell: float, horizon: float, legs: int = 1 << 10, entries: int = 1 << 14) -> Table:
    """Return a table in which nothing is reserved yet.

    Parameters
    ----------
    scene : for the robots, and where they may be.
    cell : metres, side of a grid cell.
    horizon : seconds about which most motions end; time is looked up in spans of a small part of it.
    legs, entries : how many there is room for.
    """
    corners = np.array([*scene.workspace, *(r.start for r in scene.robots), *(r.goal for r in scene.robots)])
    low, high = corners.min(axis=0), corners.max(axis=0)
    reach = sum(sorted(r.radius for r in scene.robots)[-2:]) + scene.gap + scene.tol
    extent = float((high - low).max())
    cell = max(min(cell, extent), reach, extent / _MOST_CELLS)
    columns, rows = (np.floor((high - low) / cell).astype(np.int64) + 1).tolist()
    frame = np.array([low[0], low[1], cell, horizon / _SPANS])
    shape = np.array([columns, rows, _SPANS], dtype=np.int64)
    return _blank(frame, shape, np.array([reach]), len(scene.robots), legs, entries)


def reserve(table: Table, robot: int, radius: float, legs: Floats) -> Table:
    """Reserve legs (k, 6) for a robot instead of what it had; returns the table, or a roomier one with the same in it.

    >>> from taut import Robot, Scene
    >>> scene = Scene((0, 0, 9, 9), robots=[Robot("R1", (1, 1), (8, 8), 0.5)])
    >>> table = reserve(empty_table(scene, 1.0, 10.0), 0, 0.5, np.array([[1, 1, 0, 1, 1, 3.0]]))
    >>> table.legs[table.robot == 0].tolist()
    [[1.0, 1.0, 0.0, 1.0, 1.0, 3.0]]
    """
    release(table, robot)
    while not _table_kernels.enter_motion(table, robot, radius, legs, len(legs)):
        table = roomier(table)
    return table


def release(table: Table, robot: int) -> None:
    """Give up what a robot has reserved."""
    first = int(table.first_leg[robot])
    _table_kernels.take_out(table, first)
    _table_kernels.give_up(table, first)
    table.first_leg[robot] = -1


def roomier(table: Table) -> Table:
    """Return the same motions in a table with twice the room."""
    robots = len(table.first_leg)
    size = 2 * len(table.robot), 2 * len(table.entry)
    larger = _blank(table.frame, table.shape, table.reach, robots, *size)
    legs = np.empty((len(table.robot), 6))
    for i, first in enumerate(table.first_leg.tolist()):
        if first >= 0:
            count = _table_kernels.copied_legs(table, first, legs)
            _table_kernels.enter_motion(larger, i, float(table.radius[first]), legs, count)
    return larger


def clear(table: Table) -> None:
    """Make the table empty."""
    _table_kernels.clear_table(table)


def copied(table: Table) -> Table:
    """Return a table that may be edited without this one's changing."""
    return Table._make(a.copy() for a in table)


def legs_of(trajectory: Trajectory, stays: bool) -> Floats:
    """Return a motion as legs (k, 6), x0, y0, t0, x1, y1, t1; it rests at its end for ever or ends with its arrival."""
    t, x, y = trajectory.stamps.T
    legs = np.stack([x[:-1], y[:-1], t[:-1], x[1:], y[1:], t[1:]], axis=1)
    if stays:
        return np.concatenate([legs, [[x[-1], y[-1], t[-1], x[-1], y[-1], math.inf]]])
    return np.asarray(legs[legs[:, 2] < trajectory.arrival])


def distances_from(legs: Floats, place: Floats) -> Floats:
    """Metres from the nearest point of each leg (k, 6) to the place, (k,)."""
    a, b = legs[:, 0:2], legs[:, 3:5]
    e = b - a
    square = (e * e).sum(axis=1)
    f = np.clip(((place - a) * e).sum(axis=1) / np.where(square > 0, square, 1.0), 0.0, 1.0)
    return np.asarray(np.hypot(*(a + f[:, None] * e - place).T))


def _blank(frame: Floats, shape: Ints, reach: Floats, robots: int, legs: int, entries: int) -> Table:
    columns, rows, spans = shape.tolist()
    sizes = {"robot": legs, "first_entry": legs, "next_leg": legs, "first_leg": robots, "free": 4}
    sizes |= dict.fromkeys(("entry", "following", "previous", "slot", "beside"), entries)
    table = Table(
        legs=np.empty((legs, 6)),
        pace=np.empty((legs, 2)),
        radius=np.empty(legs),
        head=np.empty((columns * rows, spans + 1), dtype=np.int64),
        frame=frame,
        shape=shape,
        reach=reach,
        **{name: np.empty(size, dtype=np.int64) for name, size in sizes.items()},
    )
    _table_kernels.clear_table(table)
    return table
