"""Reservations: what planned robots have taken of space and time, and the starts of those not planned yet."""

from __future__ import annotations

import math

import numpy as np

from taut.motion import Trajectory
from taut.scene import Scene
from taut.team import _reservation_kernels
from taut.team._conflict_kernels import Floats, Ints
from taut.team._reservation_kernels import Reserved

NOBODY = -1
_SPANS = 48


class Reservations:
    """The legs of planned robots in a grid over the workspace; grows as robots are planned.

    Parameters
    ----------
    scene : for the robots' radii, and what they do at their goals.
    cell : metres, side of a grid cell.
    horizon : seconds about which most motions end; time is looked up in spans of a small part of it.
    """

    def __init__(self, scene: Scene, cell: float, horizon: float) -> None:
        corners = np.array([*scene.workspace, *(r.start for r in scene.robots), *(r.goal for r in scene.robots)])
        low, high = corners.min(axis=0), corners.max(axis=0)
        radii = sorted(r.radius for r in scene.robots)[-2:]
        self._scene = scene
        self._reach = sum(radii) + scene.gap + scene.tol
        # at most about 250 × 250 cells, however small the robots are, and no larger than the workspace
        extent = float((high - low).max())
        cell = max(min(cell, extent), self._reach, extent / 250.0)
        columns, rows = (np.floor((high - low) / cell).astype(np.int64) + 1).tolist()
        self._frame: Floats = np.array([low[0], low[1], cell, horizon / _SPANS])
        self._shape: Ints = np.array([columns, rows, _SPANS], dtype=np.int64)
        self._head: Ints = np.full((columns * rows, _SPANS + 1), -1, dtype=np.int64)
        self._entry: Ints = np.empty(1024, dtype=np.int64)
        self._following: Ints = np.empty(1024, dtype=np.int64)
        self._entries = 0
        self._legs: Floats = np.empty((256, 6))
        self._robot: Ints = np.empty(256, dtype=np.int64)
        self._radius: Floats = np.empty(256)
        self._count = 0

    @property
    def arrays(self) -> Reserved:
        """The arrays that the kernels read."""
        n = self._count
        return (
            self._legs[:n],
            self._robot[:n],
            self._radius[:n],
            self._head,
            self._entry,
            self._following,
            self._frame,
            self._shape,
        )

    def hold_start(self, robot: int, until: float) -> None:
        """Reserve a robot's start from 0 until it is planned, at most until the given time."""
        x, y = self._scene.robots[robot].start
        self._enter(robot, np.array([[x, y, 0.0, x, y, until]]))

    def take(self, robot: int, trajectory: Trajectory) -> None:
        """Reserve a planned motion; it replaces the hold on the robot's start."""
        held = np.flatnonzero(self._robot[: self._count] == robot)
        self._legs[held, 5] = -1.0
        self._robot[held] = NOBODY
        stamps = trajectory.stamps
        t, x, y = stamps.T
        legs = np.stack([x[:-1], y[:-1], t[:-1], x[1:], y[1:], t[1:]], axis=1)
        if self._scene.stays(self._scene.robots[robot]):
            legs = np.concatenate([legs, [[x[-1], y[-1], t[-1], x[-1], y[-1], math.inf]]])
        else:
            legs = legs[legs[:, 2] < trajectory.arrival]
        self._enter(robot, legs)

    def _enter(self, robot: int, legs: Floats) -> None:
        first, last = self._count, self._count + len(legs)
        if last > len(self._robot):
            size = 2 * last
            self._legs = np.concatenate([self._legs[:first], np.empty((size - first, 6))])
            self._robot = np.concatenate([self._robot[:first], np.empty(size - first, dtype=np.int64)])
            self._radius = np.concatenate([self._radius[:first], np.empty(size - first)])
        self._legs[first:last] = legs
        self._robot[first:last] = robot
        self._radius[first:last] = self._scene.robots[robot].radius
        self._count = last
        self._entry, self._following, self._entries = _reservation_kernels.enter_legs(
            self._legs,
            first,
            last,
            self._reach,
            self._frame,
            self._shape,
            self._head,
            self._entry,
            self._following,
            self._entries,
        )


def distances_from(legs: Floats, place: Floats) -> Floats:
    """Metres from the nearest point of each leg (k, 6) to the place, (k,)."""
    a, b = legs[:, 0:2], legs[:, 3:5]
    e = b - a
    square = (e * e).sum(axis=1)
    f = np.clip(((place - a) * e).sum(axis=1) / np.where(square > 0, square, 1.0), 0.0, 1.0)
    return np.asarray(np.hypot(*(a + f[:, None] * e - place).T))
