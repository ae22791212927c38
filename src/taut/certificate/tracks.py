"""Trajectories of a plan as flat arrays for the kernels."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from taut.motion import Plan
from taut.scene import FloatArray, Point

# A stamp that lies this many times farther out than the whole scene is outside the workspace whatever the rest says;
# farther ones are drawn in to here so that squares cannot overflow.
_FAR = 2.0**20


@dataclass(frozen=True, eq=False)
class Tracks:
    """Stamps of all robots up to their arrival, one after the other; robot r at first[r]:first[r+1].

    Parameters
    ----------
    t, x, y : (S,) seconds and metres.
    vx, vy : (S,) velocity from each stamp to the next, 0 at a robot's last.
    first : (n + 1,).
    stays : (n,) whether the robot rests at its last stamp for ever.
    """

    t: FloatArray
    x: FloatArray
    y: FloatArray
    vx: FloatArray
    vy: FloatArray
    first: NDArray[np.int64]
    stays: NDArray[np.bool_]

    @property
    def present(self) -> NDArray[np.bool_]:
        """Whether each robot is there at any time: one that leaves and never moves is not."""
        return np.asarray(self.stays | (np.diff(self.first) > 1), dtype=np.bool_)

    @property
    def boxes(self) -> FloatArray:
        """Bounds xmin, ymin, xmax, ymax of each robot's stamps, (n, 4)."""
        at = self.first[:-1]
        return np.stack([f.reduceat(c, at) for f in (np.minimum, np.maximum) for c in (self.x, self.y)], axis=1)

    def on_leg(self, stamp: int, where: float) -> tuple[float, Point]:
        """Time and place at a fraction (0 … 1) of the leg that begins at a stamp."""
        if where == 0.0:
            return float(self.t[stamp]), (float(self.x[stamp]), float(self.y[stamp]))
        t, x, y = ((1 - where) * a[stamp] + where * a[stamp + 1] for a in (self.t, self.x, self.y))
        return float(t), (float(x), float(y))

    def at(self, robot: int, time: float) -> Point:
        """Position of a robot at a time, metres."""
        own = slice(self.first[robot], self.first[robot + 1])
        return float(np.interp(time, self.t[own], self.x[own])), float(np.interp(time, self.t[own], self.y[own]))


def tracks_of(plan: Plan) -> Tracks:
    """Flatten a plan; trailing rests are dropped, since staying robots rest for ever and leaving ones are gone."""
    far = _FAR * 2.0**40 * plan.scene.tol
    own = [path.stamps[: int(np.searchsorted(path.times, path.arrival)) + 1] for path in plan.trajectories]
    stamps = np.concatenate(own) if own else np.empty((0, 3))
    first = np.concatenate([[0], np.cumsum([len(s) for s in own])]).astype(np.int64)
    t = np.ascontiguousarray(stamps[:, 0])
    xy = np.clip(stamps[:, 1:], -far, far)
    v = np.zeros_like(xy)
    with np.errstate(over="ignore", divide="ignore", invalid="ignore"):
        v[:-1] = np.diff(xy, axis=0) / np.diff(t)[:, None] if len(t) else 0.0
    v[first[1:] - 1] = 0.0
    stays = np.array([plan.scene.stays(robot) for robot in plan.scene.robots], dtype=np.bool_)
    x, y, vx, vy = (np.ascontiguousarray(a) for a in (xy[:, 0], xy[:, 1], v[:, 0], v[:, 1]))
    return Tracks(t, x, y, vx, vy, first, stays)
