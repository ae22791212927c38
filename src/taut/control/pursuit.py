"""Pure pursuit: a vehicle steers along the arc to a place ahead of it on its path."""

from __future__ import annotations

import math
from dataclasses import dataclass, fields

import numpy as np
from numpy.typing import ArrayLike

from taut.control._pursuit_kernels import pursue as _pursue
from taut.errors import SceneError
from taut.scene import Point


@dataclass(frozen=True)
class PurePursuit:
    """Settings of a pure pursuit; the names in MATLAB's ``controllerPurePursuit`` in brackets.

    Parameters
    ----------
    lookahead : metres to the place that is aimed at [LookaheadDistance]. Long ones cut corners, short ones swing.
    speed : metres a second [DesiredLinearVelocity].
    top_turn_rate : radians a second [MaxAngularVelocity].
    lookahead_time : seconds of travel by which the look-ahead is longer; 0 keeps it constant.

    Raises
    ------
    SceneError
        A number that is not positive and finite (the time may be 0).

    >>> PurePursuit(lookahead=0.5, speed=0.3).top_turn_rate
    1.0
    """

    lookahead: float = 1.0
    speed: float = 0.1
    top_turn_rate: float = 1.0
    lookahead_time: float = 0.0

    def __post_init__(self) -> None:
        for field in fields(self):
            value = float(getattr(self, field.name))
            object.__setattr__(self, field.name, value)
            if field.name == "lookahead_time" and value == 0:
                continue
            if not (math.isfinite(value) and value > 0):
                what = field.name.replace("_", " ")
                raise SceneError(f"pure pursuit: the {what} must be positive and finite, got {value:g}")


@dataclass(frozen=True)
class Pursuit:
    """What a pure pursuit does now.

    Parameters
    ----------
    speed, turn_rate : the command, metres and radians a second.
    target : the place aimed at.
    leg : of the path on which the vehicle is; where to look from next time.
    """

    speed: float
    turn_rate: float
    target: Point
    leg: int


def pursue(
    settings: PurePursuit, path: ArrayLike, pose: ArrayLike, leg: int = 0, moving: float | None = None
) -> Pursuit:
    """Return the command of a pure pursuit at a pose.

    The place aimed at is where the path, from its point nearest to the vehicle on, first is one look-ahead L away; if
    all of it is nearer, its end; if none is so near, the nearest point. The arc there has curvature 2 sin(α) / d, with
    α the angle from the heading to it and d its distance, not taken less than L, so that the end of the path is met
    gently. A place behind is turned to as one beside. The speed is the desired one always: the caller stops it.

    Parameters
    ----------
    settings : look-ahead and limits.
    path : (k, 2) metres, k ≥ 2.
    pose : x, y in metres and heading in radians.
    leg : of the path from which on the nearest point is sought, as far as the look-ahead can reach; give back what the
        last call returned, and paths that cross themselves are followed in order.
    moving : metres a second of the vehicle now, for an adaptive look-ahead; the desired speed if not given.

    Raises
    ------
    ValueError
        A path that is not (k ≥ 2, 2) finite numbers, a pose that is not three.
    IndexError
        A leg that the path does not have.

    Notes
    -----
    Coulter, "Implementation of the pure pursuit path tracking algorithm", CMU-RI-TR-92-01, 1992. On a line the distance
    y from it obeys y'' = −2 v y' / L − 2 v² y / L² near it: damping 1/√2, whatever the speed. A circle of radius
    R ≥ L/2 is kept to exactly.

    >>> pursue(PurePursuit(lookahead=1.0, speed=0.5), [(0, 0), (9, 0)], (2, 0, 0)).target
    (3.0, 0.0)
    """
    points = np.ascontiguousarray(path, dtype=np.float64)
    if points.ndim != 2 or len(points) < 2 or points.shape[1] != 2 or not np.isfinite(points).all():
        raise ValueError("the path must be at least two rows of two finite numbers [x, y]")
    place = np.asarray(pose, dtype=np.float64)
    if place.shape != (3,) or not np.isfinite(place).all():
        raise ValueError("the pose must be three finite numbers x, y, θ")
    if not 0 <= leg < len(points) - 1:
        raise IndexError(f"leg {leg} is not one of the legs 0 … {len(points) - 2} of the path")
    now = settings.speed if moving is None else abs(float(moving))
    if not math.isfinite(now):
        raise ValueError(f"the present speed must be finite, got {now:g}")
    lookahead = settings.lookahead + settings.lookahead_time * now
    x, y, heading = (float(value) for value in place)
    turn, to_x, to_y, found = _pursue(
        points, int(leg), x, y, heading, lookahead, settings.speed, settings.top_turn_rate
    )
    return Pursuit(settings.speed, float(turn), (float(to_x), float(to_y)), int(found))
