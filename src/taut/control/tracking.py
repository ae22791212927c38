"""The tracker that keeps a plan's timing: its settings, its courses, and how progress is tied to the vehicle."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, fields

import numpy as np

from taut.control._following_kernels import slowed
from taut.errors import SceneError
from taut.scene import FloatArray

_LEAST_HURRY = 1.0


@dataclass(frozen=True)
class Tracking:
    """How a robot is kept to its plan.

    A reference runs along the plan. Plan time σ is where it has come; it moves at most ``hurry`` times as fast as the
    clock and never passes it, brakes for sharp corners, rests, the goal and for robots that have to pass first, and
    waits at a sharp corner until the vehicle stands there and looks along the next leg. With the deviation e from the
    vehicle to the reference, which moves at w u (w its speed, u its direction), the wanted velocity is V = w u + g e;
    far from the reference the pull grows only as fast as the vehicle can brake, √(2 a |e|). A single integrator does V
    itself. Others drive at the part of V that lies ahead of them, and turn towards V at 4 g times the angle to it.

    Parameters
    ----------
    gain : g, 1/s: how fast a deviation goes. The turning is four times as fast; 4 · gain · dt should stay below 0.5.
    slack, leash : metres. The reference keeps its pace while the vehicle is within ``slack`` of it and stands still
        when it is ``leash`` away; between, its speed falls linearly. So σ of a robot that is dead comes to rest.
    tolerance : metres at which a place has been reached: ends of legs to wait at, and the goal.
    aligned : radians by which the heading may miss the next leg when a corner is left.
    hurry : how much faster than the clock σ may run while it is late, ≥ 1.
    cutting : metres by which the reference may be left at corners that are taken without a stop.

    Raises
    ------
    SceneError
        A number that is not positive and finite, a leash not longer than the slack, a hurry below 1.

    Notes
    -----
    On a straight leg the deviation along it obeys e' = −g e. Across it, y' = w sin(θ), and the wanted heading is
    −g y / w to first order, so with θ' = −4 g (θ + g y / w) it is y'' + 4 g y' + 4 g² y = 0: critically damped, both
    roots −2 g, *whatever the speed w*, except that aims are taken as if w were at least ten times g × tolerance, below
    which it is overdamped; so it converges locally, as the law of Kanayama, Kimura, Miyazaki and Noguchi
    does ("A stable tracking control method for an autonomous mobile robot", ICRA 1990), whose damping changes with w.
    Turning towards the velocity that a point without a heading would take is backstepping (Jiang and Nijmeijer,
    Automatica 33, 1997). A lasting lag is a speed that is made good only in part (worn wheels, slip): the tracker
    learns it and asks for up to 35 % more or less.

    Where bends follow each other closely, as on arcs, the reference goes slowly enough that the turning keeps up.

    A vehicle that cannot turn on the spot takes the arc to a place ahead on its course (`taut.control.pursue`), at most
    as sharp as it can, slowing for it, and stops level with its goal; places within its turning circles it may miss.
    """

    gain: float = 5.0
    slack: float = 0.05
    leash: float = 0.15
    tolerance: float = 0.005
    aligned: float = 0.05
    hurry: float = 1.25
    cutting: float = 0.01

    def __post_init__(self) -> None:
        for field in fields(self):
            value = float(getattr(self, field.name))
            object.__setattr__(self, field.name, value)
            if not (math.isfinite(value) and value > 0):
                raise SceneError(f"tracking: {field.name} must be positive and finite, got {value:g}")
        if self.leash <= self.slack:
            raise SceneError(
                f"tracking: the leash must be longer than the slack, got {self.leash:g} and {self.slack:g} m"
            )
        if self.hurry < _LEAST_HURRY:
            raise SceneError(f"tracking: hurry must be at least 1, got {self.hurry:g}: the plan would never be kept")


def tuning(trackings: Sequence[Tracking]) -> FloatArray:
    """Return the settings as the table that the kernels take, (n, 7), a row a robot.

    >>> tuning([Tracking()]).shape
    (1, 7)
    """
    rows = [[float(getattr(each, field.name)) for field in fields(Tracking)] for each in trackings]
    return np.array(rows, dtype=np.float64).reshape(-1, len(fields(Tracking)))


def progress_rate(lag: float, tracking: Tracking) -> float:
    """Return the share of its speed that a robot's reference keeps when the vehicle is ``lag`` metres from it.

    It is 1 up to ``tracking.slack``, falls linearly to 0 at ``tracking.leash`` and stays 0 beyond: a pure function of
    the lag, so a robot that stands still is waited for, for ever if need be.

    Raises
    ------
    ValueError
        A lag that is negative or not a number.

    >>> progress_rate(0.5, Tracking(slack=0.25, leash=0.75))
    0.5
    """
    if not lag >= 0:
        raise ValueError(f"the lag must be a distance in metres, not negative, got {lag:g}")
    return float(slowed(float(lag), tracking.slack, tracking.leash))
