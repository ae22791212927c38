"""Disturbances: what goes wrong while robots follow a plan, and what of it a run with some seed meets."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, field
from types import MappingProxyType

import numpy as np

from taut.errors import SceneError
from taut.scene import FloatArray, Scene

MOST_SPEED_ERROR = 0.9  # a robot whose speed may be wrong by all of it would not move
MOST_STOPS = 100.0  # a second: robots that stop more often never drive
LEAST_STOP = 1e-3  # seconds
_MOST_NOISE = 1e6  # metres


@dataclass(frozen=True)
class Disturbances:
    """What goes wrong. The default is nothing.

    Parameters
    ----------
    speed_error : each robot drives, for a whole run, by a factor from 1 − e to 1 + e faster than it believes, drawn
        uniformly; below 0.9.
    stops : random stops of each robot a second of driving (a Poisson process), at most 100.
    stop_seconds : mean length of a stop, exponentially distributed; at least a thousandth.
    slow : name of a robot → part of its top speed that it can reach, in (0, 1].
    dies : name of a robot → seconds at which it stops for good.
    position_noise, heading_noise : standard deviation with which a robot measures its position (each axis, metres) and
        its heading (radians), drawn anew at every step; see the notes for what it believes.
    slip : standard deviation of the relative speed error of each wheel, drawn anew every half second.

    Raises
    ------
    SceneError
        A number that is not finite, negative or too large.

    Notes
    -----
    A robot that measures with noise believes what a Kalman filter makes of its measurements and of what its wheels have
    done, in three numbers: the place, each axis alone, and the heading. It counts its way by its wheels, as if they did
    not slip, and takes them to err by a share ρ for half a second at a time, ρ² = 0.05² + slip² + speed_error² / 3: so
    the variance of the place grows by ρ² v² dt / 2 in a step, and by as much as the doubt about the heading makes of
    it. With the gain P / (P + σ²) for a variance P before a measurement it is the best linear estimate for errors like
    that. At 1 m/s and σ = 5 cm, nothing else wrong, a robot knows its place up to 1 cm, and better where it stands.

    >>> Disturbances(speed_error=0.2, stops=0.05).stop_seconds
    2.0
    """

    speed_error: float = 0.0
    stops: float = 0.0
    stop_seconds: float = 2.0
    slow: Mapping[str, float] = field(default_factory=dict)
    dies: Mapping[str, float] = field(default_factory=dict)
    position_noise: float = 0.0
    heading_noise: float = 0.0
    slip: float = 0.0

    def __post_init__(self) -> None:
        for name in ("speed_error", "stops", "stop_seconds", "position_noise", "heading_noise", "slip"):
            object.__setattr__(self, name, _not_negative(getattr(self, name), name.replace("_", " ")))
        if self.speed_error > MOST_SPEED_ERROR:
            raise SceneError(f"the speed error must be at most {MOST_SPEED_ERROR:g}, got {self.speed_error:g}")
        if self.slip > 0.5:
            raise SceneError(f"slip must be at most 0.5, got {self.slip:g}: wheels would turn backwards")
        if self.stops > MOST_STOPS:
            raise SceneError(f"there may be at most {MOST_STOPS:g} random stops a second, got {self.stops:g}")
        if self.stops and self.stop_seconds < LEAST_STOP:
            raise SceneError(f"stops need a mean length of at least {LEAST_STOP:g} s, got {self.stop_seconds:g} s")
        if self.position_noise > _MOST_NOISE or self.heading_noise > math.pi:
            raise SceneError(
                f"noise may be at most {_MOST_NOISE:g} m and π radians, got "
                f"{self.position_noise:g} m and {self.heading_noise:g} radians"
            )
        for name in ("slow", "dies"):
            if not isinstance(getattr(self, name), Mapping):
                raise SceneError(f"{name} must be numbers by name of the robot, like {{'R1': 0.5}}")
        slow = {name: _not_negative(part, f"the part of its speed of {name}") for name, part in self.slow.items()}
        for name, part in slow.items():
            if not 0 < part <= 1:
                raise SceneError(f"{name} must reach a part of its speed above 0 and up to 1, got {part:g}")
        dies = {name: _not_negative(at, f"the time at which {name} dies") for name, at in self.dies.items()}
        object.__setattr__(self, "slow", MappingProxyType(slow))
        object.__setattr__(self, "dies", MappingProxyType(dies))

    def as_dict(self) -> dict[str, object]:
        """Return them as plain data."""
        return {name: dict(value) if isinstance(value, Mapping) else value for name, value in vars(self).items()}


@dataclass(frozen=True, eq=False)
class Fate:
    """What the robots of one run meet, as far as it does not change during the run.

    Parameters
    ----------
    drift : (n,) by how many times faster each robot drives than it believes.
    reach : (n,) part of its top speed that each robot can reach.
    dies : (n,) seconds at which each robot stops for good; inf if it does not.
    """

    drift: FloatArray
    reach: FloatArray
    dies: FloatArray


def fate_of(scene: Scene, disturbances: Disturbances, seed: int) -> Fate:
    """Draw what the robots of a run with this seed meet; a robot's draw does not depend on what else goes wrong.

    Raises
    ------
    SceneError
        A robot that is to be slow or to die is not in the scene.
    """
    names = [robot.name for robot in scene.robots]
    for name in (*disturbances.slow, *disturbances.dies):
        scene.robot(name)
    error = disturbances.speed_error
    drift = np.random.default_rng([seed, 0]).uniform(-1.0, 1.0, len(names)) * error + 1.0
    reach = np.array([disturbances.slow.get(name, 1.0) for name in names], dtype=np.float64)
    dies = np.array([disturbances.dies.get(name, np.inf) for name in names], dtype=np.float64)
    return Fate(drift, reach, dies)


def _not_negative(value: float, what: str) -> float:
    try:
        number = float(value)
    except (TypeError, ValueError):
        raise SceneError(f"{what} must be a number, got {value!r}") from None
    if not (math.isfinite(number) and number >= 0):
        raise SceneError(f"{what} must be a finite number of at least 0, got {number:g}")
    return number
