"""Route: the path of one robot, without time; and what is said where there is none."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from taut.errors import GoalBlocked, NoPath, StartBlocked
from taut.freespace import FreeSpace
from taut.geometry.points import points_of as points_of
from taut.geometry.triangulation import Ints
from taut.scene import FloatArray


@dataclass(frozen=True, eq=False)
class Route:
    """A polyline through free space.

    Parameters
    ----------
    points : (k, 2) metres, from start to goal; one row if they are the same place.
    """

    points: FloatArray

    @property
    def length(self) -> float:
        """Metres."""
        return float(np.hypot(*np.diff(self.points, axis=0).T).sum())


def in_turn(starts: ArrayLike, goals: ArrayLike) -> FloatArray:
    """Starts and goals in turn, (2 k, 2): start 0, goal 0, start 1 and so on.

    Raises
    ------
    ValueError
        They are not (k, 2) points, or not as many of one as of the other.
    """
    a, b = points_of(starts, "starts"), points_of(goals, "goals")
    if len(a) != len(b):
        raise ValueError(f"every start needs its goal: got {len(a)} starts and {len(b)} goals")
    both = np.empty((2 * len(a), 2))
    both[::2], both[1::2] = a, b
    return both


def require_free(freespace: FreeSpace, given: FloatArray, triangles: Ints) -> None:
    """Raise unless all starts and goals, in turn, are in free space: none has triangle −1.

    Raises
    ------
    StartBlocked, GoalBlocked
        The first that is not.
    """
    for k in (triangles < 0).nonzero()[0].tolist():
        error, word = (StartBlocked, "start") if k % 2 == 0 else (GoalBlocked, "goal")
        x, y = given[k]
        raise error(f"{word} ({x:g}, {y:g}) is not in free space (growth {freespace.growth:g} m)")


def require_found(freespace: FreeSpace, given: FloatArray, lengths: FloatArray) -> None:
    """Raise unless all lengths (k,) between starts and goals, given in turn, are finite.

    Raises
    ------
    NoPath
        The first that is not.
    """
    for k in np.isinf(lengths).nonzero()[0].tolist():
        a, b = given[2 * k], given[2 * k + 1]
        grown = f" grown by {freespace.growth:g} m" if freespace.growth else ""
        raise NoPath("", f"no way from ({a[0]:g}, {a[1]:g}) to ({b[0]:g}, {b[1]:g}): obstacles{grown} separate them")
