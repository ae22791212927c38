"""Vehicles: how a robot moves, what limits it, and sensible defaults for a robot of some size and speed."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, fields
from typing import TypeAlias

import numpy as np
from numpy.typing import NDArray

from taut.control.tracking import Tracking
from taut.errors import SceneError
from taut.scene import FloatArray, Robot

_STEEPEST = 1.5  # radians; at π/2 a vehicle would turn on the spot


@dataclass(frozen=True)
class Integrator:
    """A single integrator: moves in any direction, whatever its heading; (x', y') is commanded.

    Parameters
    ----------
    top_speed : metres a second.
    acceleration : metres a second², of the velocity vector; ``inf`` follows commands at once.
    """

    top_speed: float
    acceleration: float = math.inf

    def __post_init__(self) -> None:
        _check(self)


@dataclass(frozen=True)
class Unicycle:
    """Drives along its heading and turns, on the spot if need be: x' = v cos θ, y' = v sin θ, θ' = ω.

    Parameters
    ----------
    top_speed, acceleration : metres a second, metres a second².
    top_turn_rate, turn_acceleration : radians a second, radians a second².
    """

    top_speed: float
    top_turn_rate: float
    acceleration: float = math.inf
    turn_acceleration: float = math.inf

    def __post_init__(self) -> None:
        _check(self)


@dataclass(frozen=True)
class DifferentialDrive:
    """Two driven wheels on one axle: v = r (ω_R + ω_L) / 2 and θ' = r (ω_R − ω_L) / track.

    Parameters
    ----------
    wheel_radius, track : metres; the track is the distance between the wheels.
    top_wheel_speed : radians a second.
    acceleration : metres a second², of the rim of each wheel.
    top_turn_rate : radians a second; by default what the wheels allow.
    """

    wheel_radius: float
    track: float
    top_wheel_speed: float
    acceleration: float = math.inf
    top_turn_rate: float = math.inf

    def __post_init__(self) -> None:
        _check(self)


@dataclass(frozen=True)
class Ackermann:
    """A truck that steers its front axle: θ' = v tan φ / wheelbase.

    It follows a plan driving ahead only; in a team that steers itself it also drives back. The point that moves, and
    the centre of the robot's disc, is the middle of the rear axle.

    Parameters
    ----------
    wheelbase : metres between the axles.
    top_speed, acceleration : metres a second, metres a second².
    top_steering : radians, below 1.5; the smallest turning circle has radius wheelbase / tan(top_steering).
    steering_rate : radians a second.
    """

    wheelbase: float
    top_speed: float
    top_steering: float = 0.7
    acceleration: float = math.inf
    steering_rate: float = math.inf

    def __post_init__(self) -> None:
        _check(self)
        if self.top_steering > _STEEPEST:
            raise SceneError(
                f"ackermann: top_steering must be at most {_STEEPEST:g} radians, got {self.top_steering:g}"
            )

    @property
    def turning_radius(self) -> float:
        """Radius of the smallest circle, metres."""
        return self.wheelbase / math.tan(self.top_steering)


Vehicle: TypeAlias = Integrator | Unicycle | DifferentialDrive | Ackermann

KINDS = ("integrator", "unicycle", "differential", "ackermann")
"""Names of the kinds of vehicles, in the order of the kernels' numbers."""

_CLASSES: tuple[type, ...] = (Integrator, Unicycle, DifferentialDrive, Ackermann)


def vehicle_for(robot: Robot, kind: str, reserve: float = 1.25) -> Vehicle:
    """Return a vehicle fit for a robot of a scene.

    Its top speed is ``reserve`` times the robot's, so that it can make up for a delay; it reaches the robot's speed in
    half a second, turns at up to π radians a second (not the truck) and has this rate in a quarter of a second. The
    differential drive has wheels of 0.4 and a track of 1.6 radii; the truck has a wheelbase of 1.2 radii, steers up to
    0.7 radians at 3 radians a second. For a robot without a radius 0.15 seconds of its travel are taken instead.

    Raises
    ------
    SceneError
        An unknown kind, a reserve below 1.

    >>> from taut import Robot
    >>> vehicle_for(Robot("R1", (0, 0), (1, 0), radius=0.15), "differential").track
    0.24
    """
    if kind not in KINDS:
        raise SceneError(f"unknown vehicle {kind!r}; there are {', '.join(KINDS)}")
    if not (math.isfinite(reserve) and reserve >= 1):
        raise SceneError(f"the reserve of speed must be at least 1, got {reserve:g}")
    top, acceleration = reserve * robot.speed, 2.0 * robot.speed
    size = robot.radius or 0.15 * robot.speed
    if kind == "integrator":
        return Integrator(top, acceleration)
    if kind == "unicycle":
        return Unicycle(top, math.pi, acceleration, 4 * math.pi)
    if kind == "differential":
        wheel = 0.4 * size
        return DifferentialDrive(wheel, 1.6 * size, top / wheel, acceleration, math.pi)
    return Ackermann(1.2 * size, top, 0.7, acceleration, 3.0)


def tracking_for(robot: Robot, vehicle: Vehicle, dt: float, noise: float = 0.0) -> Tracking:
    """Return the settings of the tracker for a robot in some vehicle that gets a command every dt seconds.

    Distances are ways at the robot's speed: slack 0.045 seconds, leash 0.15, tolerance 0.005, cutting 0.01, longer in
    proportion where dt is above 0.05; the truck has slack and leash of 1 and 4 turning radii on top. The gain is 5/s,
    or 0.1/dt if that is less. A robot that knows its place up to ``noise`` metres (σ of each axis) has a tolerance of
    at least noise, and 1.5 and 3 noise on top of slack and leash: else it would seek a corner for long that it cannot
    see so sharply, and its reference would wait for errors that are none.

    Raises
    ------
    SceneError
        A time step that is not positive and finite.
    """
    if not (math.isfinite(dt) and dt > 0):
        raise SceneError(f"the time step must be positive and finite, got {dt:g} s")
    way = robot.speed * max(0.15, 3 * dt)
    more = vehicle.turning_radius if isinstance(vehicle, Ackermann) else 0.0
    return Tracking(
        gain=min(5.0, 0.1 / dt),
        slack=0.3 * way + more + 1.5 * noise,
        leash=way + 4.0 * more + 3.0 * noise,
        tolerance=max(way / 30, noise),
        cutting=way / 15,
    )


def tables(vehicles: Sequence[Vehicle]) -> tuple[NDArray[np.int64], FloatArray]:
    """Return the kinds (n,) and parameters (n, 8) of vehicles as the kernels take them.

    The columns are top speed, top turn rate, acceleration, turn acceleration, wheel radius, track or wheelbase, top
    wheel speed or top steering angle, steering rate.
    """
    kinds = np.array([_CLASSES.index(type(vehicle)) for vehicle in vehicles], dtype=np.int64)
    return kinds, np.array([_row(vehicle) for vehicle in vehicles], dtype=np.float64).reshape(-1, 8)


def _row(vehicle: Vehicle) -> list[float]:
    if isinstance(vehicle, Integrator):
        return [vehicle.top_speed, math.inf, vehicle.acceleration, math.inf, 0, 0, 0, 0]
    if isinstance(vehicle, Unicycle):
        return [vehicle.top_speed, vehicle.top_turn_rate, vehicle.acceleration, vehicle.turn_acceleration, 0, 0, 0, 0]
    if isinstance(vehicle, DifferentialDrive):
        top = vehicle.wheel_radius * vehicle.top_wheel_speed
        turn = min(vehicle.top_turn_rate, 2 * top / vehicle.track)
        quickening = 2 * vehicle.acceleration / vehicle.track
        rest = [vehicle.wheel_radius, vehicle.track, vehicle.top_wheel_speed, 0]
        return [top, turn, vehicle.acceleration, quickening, *rest]
    turn = vehicle.top_speed / vehicle.turning_radius
    rest = [0, vehicle.wheelbase, vehicle.top_steering, vehicle.steering_rate]
    return [vehicle.top_speed, turn, vehicle.acceleration, math.inf, *rest]


def _check(vehicle: Vehicle) -> None:
    """Refuse numbers that are not positive; accelerations may be infinite, and what other limits bound."""
    unbounded = ["acceleration", "turn_acceleration", "steering_rate"]
    if isinstance(vehicle, DifferentialDrive):
        unbounded.append("top_turn_rate")
    kind = KINDS[_CLASSES.index(type(vehicle))]
    for field in fields(vehicle):
        value = float(getattr(vehicle, field.name))
        object.__setattr__(vehicle, field.name, value)
        if not value > 0:
            raise SceneError(f"{kind}: {field.name} must be positive, got {value:g}")
        if math.isinf(value) and field.name not in unbounded:
            raise SceneError(f"{kind}: {field.name} must be finite")
