"""Vehicles go where closed forms and an independent integrator say, within their limits."""

from __future__ import annotations

import math
from itertools import pairwise
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from numpy.typing import NDArray
from scipy.integrate import solve_ivp

from taut import Robot
from taut.errors import SceneError
from taut.simulation._vehicle_kernels import move
from taut.simulation.vehicles import (
    KINDS,
    Ackermann,
    DifferentialDrive,
    Integrator,
    Unicycle,
    Vehicle,
    tables,
    tracking_for,
    vehicle_for,
)

Floats = NDArray[np.float64]

ROBOT = Robot("R1", (0, 0), (1, 0), radius=0.15, speed=1.0)
FREE: dict[str, Vehicle] = {
    "unicycle": Unicycle(10.0, 10.0),
    "differential": DifferentialDrive(0.05, 0.24, 1000.0),
}
VEHICLES = [
    Integrator(1.5, 2.0),
    Unicycle(1.5, 3.0, 2.0, 9.0),
    DifferentialDrive(0.06, 0.24, 20.0, 2.0, 3.0),
    Ackermann(0.3, 1.5, 0.7, 2.0, 1.5),
]
speeds = st.floats(-2, 2)
steps = st.floats(1e-4, 2.0)


def driven(
    vehicle: Vehicle,
    commands: list[tuple[float, float, float]],
    state: tuple[float, ...] = (0, 0, 0, 0, 0, 0),
    slip: tuple[float, float] = (1, 1),
) -> Floats:
    """State after commands (forward, turn, seconds)."""
    kinds, params = tables([vehicle])
    now = np.array([state], dtype=np.float64)
    for forward, turn, seconds in commands:
        move(0, kinds, params, now, np.array([[forward, turn]]), np.array([slip], dtype=np.float64), seconds)
    return np.asarray(now[0], dtype=np.float64)


def towards(old: float, new: float, rate: float, seconds: float) -> float:
    return old + float(np.clip(new - old, -rate * seconds, rate * seconds))


def integrated(
    vehicle: Vehicle, command: tuple[float, float], state: Floats, slip: tuple[float, float], seconds: float
) -> Floats:
    """Where an adaptive integrator of order 8 takes a vehicle whose wheels run to the command as fast as they can."""
    v0, w0, phi0 = state[3:]
    forward, turn = command

    def velocities(t: float, place: Floats) -> list[float]:
        heading = place[2]
        if isinstance(vehicle, Integrator):
            change = np.array([forward - v0, turn - w0])
            size = float(np.hypot(*change))
            share = 1.0 if size == 0 else min(1.0, vehicle.acceleration * t / size)
            return [slip[0] * (v0 + share * change[0]), slip[0] * (w0 + share * change[1]), 0.0]
        if isinstance(vehicle, Unicycle):
            v = slip[0] * towards(v0, forward, vehicle.acceleration, t)
            w = slip[1] * towards(w0, turn, vehicle.turn_acceleration, t)
        elif isinstance(vehicle, DifferentialDrive):
            half = vehicle.track / 2
            left = slip[0] * towards(v0 - half * w0, forward - half * turn, vehicle.acceleration, t)
            right = slip[1] * towards(v0 + half * w0, forward + half * turn, vehicle.acceleration, t)
            v, w = (left + right) / 2, (right - left) / vehicle.track
        else:
            wanted = np.clip(math.atan(vehicle.wheelbase * turn / forward), -0.7, 0.7)
            v = slip[0] * towards(v0, forward, vehicle.acceleration, t)
            w = slip[1] * v * math.tan(towards(phi0, wanted, vehicle.steering_rate, t)) / vehicle.wheelbase
        return [v * math.cos(heading), v * math.sin(heading), w]

    place = state[:3]
    for begin, end in pairwise(knees(vehicle, command, state, seconds)):
        if end > begin:
            found: Any = solve_ivp(velocities, (begin, end), place, "DOP853", rtol=1e-12, atol=1e-13)
            place = found.y[:, -1]
    return np.asarray(place, dtype=np.float64)


def knees(vehicle: Vehicle, command: tuple[float, float], state: Floats, seconds: float) -> list[float]:
    """Times at which something that changes ceases to, in order, with the ends of the step."""
    (forward, turn), (v0, w0, phi0) = command, state[3:]
    if isinstance(vehicle, Integrator):
        times = [math.hypot(forward - v0, turn - w0) / vehicle.acceleration]
    elif isinstance(vehicle, Unicycle):
        times = [abs(forward - v0) / vehicle.acceleration, abs(turn - w0) / vehicle.turn_acceleration]
    elif isinstance(vehicle, DifferentialDrive):
        half = vehicle.track / 2
        times = [abs(forward - v0 + side * half * (turn - w0)) / vehicle.acceleration for side in (-1, 1)]
    else:
        wanted = float(np.clip(math.atan(vehicle.wheelbase * turn / forward), -0.7, 0.7))
        times = [abs(forward - v0) / vehicle.acceleration, abs(wanted - phi0) / vehicle.steering_rate]
    return sorted([0.0, seconds, *(min(time, seconds) for time in times)])


@pytest.mark.parametrize("kind", FREE)
@settings(deadline=None)
@given(v=speeds, w=st.one_of(speeds, st.floats(-1e-3, 1e-3), st.sampled_from([0.0, 1e-8, -1e-300])), dt=steps)
def test_constant_speeds_give_arcs_in_closed_form(kind: str, v: float, w: float, dt: float) -> None:
    x, y, heading, *_ = driven(FREE[kind], [(v, w, dt)], (1.0, 2.0, 0.5, 0, 0, 0))
    assert heading == pytest.approx(0.5 + w * dt, abs=1e-12)
    if abs(w) > 1e-3:
        chord = (v / w * (math.sin(heading) - math.sin(0.5)), v / w * (math.cos(0.5) - math.cos(heading)))
    else:  # the first terms of the series in ω
        bend, sine, cosine = w * dt, math.sin(0.5), math.cos(0.5)
        along, across = 1 - bend**2 / 6, bend / 2 - bend**3 / 24
        chord = (v * dt * (along * cosine - across * sine), v * dt * (along * sine + across * cosine))
    assert (x - 1.0, y - 2.0) == pytest.approx(chord, abs=1e-11)


@settings(deadline=None)
@given(w=st.floats(-3, 3), dt=steps)
def test_a_spin_on_the_spot_does_not_move_the_robot(w: float, dt: float) -> None:
    vehicle = vehicle_for(ROBOT, "differential")
    x, y, heading, v, rate, _ = driven(vehicle, [(0.0, w, dt)])
    assert (x, y, v) == pytest.approx((0, 0, 0), abs=1e-15)
    gained = min(dt, abs(w) / (2 * 2.0 / 0.24))
    assert abs(heading) == pytest.approx(gained * gained * (2 * 2.0 / 0.24) / 2 + abs(w) * (dt - gained), abs=1e-12)
    assert rate == pytest.approx(math.copysign(gained * 2 * 2.0 / 0.24, w), abs=1e-12)


@pytest.mark.parametrize("kind", FREE)
@pytest.mark.parametrize("count", [1, 7, 1000])
def test_a_figure_eight_ends_where_it_began(kind: str, count: int) -> None:
    once = [(1.0, 2.0, math.pi / count)] * count
    back = [(1.0, -2.0, math.pi / count)] * count
    half = driven(FREE[kind], once)
    assert half[:3] == pytest.approx((0, 0, 2 * math.pi), abs=1e-9)
    assert driven(FREE[kind], once + back)[:3] == pytest.approx((0, 0, 0), abs=1e-9)
    quarter = driven(FREE[kind], [(1.0, 2.0, math.pi / 2)])
    assert quarter[:2] == pytest.approx((0, 1.0), abs=1e-9)  # across a circle of radius v / ω = 1/2


@settings(deadline=None, max_examples=40)
@given(data=st.data())
@pytest.mark.parametrize("vehicle", VEHICLES, ids=KINDS)
def test_motion_with_accelerations_and_slip_is_that_of_an_adaptive_integrator(
    vehicle: Vehicle, data: st.DataObject
) -> None:
    unit = st.floats(-1, 1)
    v, w, v0, w0, heading = (data.draw(unit) for _ in range(5))
    phi = 0.7 * data.draw(unit) if isinstance(vehicle, Ackermann) else 0.0
    v = v if abs(v) > 0.01 else 0.5
    slip = (data.draw(st.floats(0.5, 1.5)), data.draw(st.floats(0.5, 1.5)))
    dt = data.draw(st.floats(0.001, 1.5))
    state = np.array([3.0, -1.0, heading, v0, w0, phi])
    after = driven(vehicle, [(v, w, dt)], tuple(state), slip)
    assert after[:2] == pytest.approx(integrated(vehicle, (v, w), state, slip, dt)[:2], abs=1e-9)
    if not isinstance(vehicle, Integrator):
        assert after[2] == pytest.approx(integrated(vehicle, (v, w), state, slip, dt)[2], abs=1e-9)


@settings(deadline=None)
@given(v=speeds, w=st.floats(-4, 4), dt=st.floats(0.01, 1.0), share=st.floats(0.01, 0.99))
@pytest.mark.parametrize("vehicle", VEHICLES, ids=KINDS)
def test_one_step_is_two_that_make_it_up(vehicle: Vehicle, v: float, w: float, dt: float, share: float) -> None:
    state = (0.0, 0.0, 0.3, 0.4, 0.2, 0.1)
    whole = driven(vehicle, [(v, w, dt)], state)
    parts = driven(vehicle, [(v, w, share * dt), (v, w, (1 - share) * dt)], state)
    assert whole == pytest.approx(parts, abs=1e-9)


@settings(deadline=None)
@given(v=st.floats(-9, 9), w=st.floats(-99, 99), dt=steps)
@pytest.mark.parametrize("kind", KINDS)
def test_limits_are_kept(kind: str, v: float, w: float, dt: float) -> None:
    vehicle = vehicle_for(ROBOT, kind)
    _, params = tables([vehicle])
    top, turn = params[0, :2]
    _, _, _, speed, rate, phi = driven(vehicle, [(v, w, dt)] * 3)
    if kind == "integrator":
        assert math.hypot(speed, rate) <= top * (1 + 1e-12)
        return
    assert abs(speed) <= min(top, 3 * 2.0 * dt) * (1 + 1e-12)
    assert abs(rate) <= turn * (1 + 1e-12)
    if isinstance(vehicle, DifferentialDrive):
        fastest = abs(speed) + abs(rate) * vehicle.track / 2
        assert fastest <= vehicle.wheel_radius * vehicle.top_wheel_speed * (1 + 1e-12)
    if isinstance(vehicle, Ackermann):
        assert abs(phi) <= min(0.7, 3 * 3.0 * dt) * (1 + 1e-12)


def test_wheels_that_are_too_slow_keep_the_curvature() -> None:
    vehicle = DifferentialDrive(0.1, 0.5, 10.0)
    *_, v, w, _ = driven(vehicle, [(1.0, 2.0, 0.1)])
    assert v / w == pytest.approx(0.5)
    assert v + 0.25 * w == pytest.approx(1.0)


def test_wheels_of_different_grip_drive_a_circle() -> None:
    state = driven(FREE["differential"], [(1.0, 0.0, 0.4)], slip=(0.9, 1.1))
    turn = 0.2 / 0.24 * 0.4
    assert state[2] == pytest.approx(turn)
    assert state[:2] == pytest.approx((1.2 * math.sin(turn), 1.2 * (1 - math.cos(turn))), abs=1e-12)
    assert state[3:5] == pytest.approx((1.0, 0.0), abs=1e-12), "the wheels do what they are told"


def test_a_truck_drives_the_circle_of_its_steering_angle_and_steers_in_closed_form() -> None:
    truck = Ackermann(0.3, 2.0, 0.7, math.inf, 1.0)
    steered = driven(truck, [(1.0, 100.0, 0.7)])
    assert steered[5] == pytest.approx(0.7)
    assert steered[2] == pytest.approx(-math.log(math.cos(0.7)) / 0.3, abs=1e-10)
    radius = truck.turning_radius
    assert driven(truck, [(1.0, 9.0, 2 * math.pi * radius)], tuple(steered))[:2] == pytest.approx(steered[:2], abs=1e-9)
    half = driven(truck, [(1.0, 9.0, math.pi * radius)], tuple(steered))
    assert math.dist(half[:2], steered[:2]) == pytest.approx(2 * radius, abs=1e-9)


def test_a_truck_that_stands_steers_but_does_not_turn() -> None:
    state = driven(Ackermann(0.3, 1.0, 0.7, 2.0, 1.0), [(0.0, 1.0, 0.2)])
    assert state == pytest.approx((0, 0, 0, 0, 0, 0.2))


def test_an_integrator_looks_where_it_last_went() -> None:
    vehicle = Integrator(2.0, 4.0)
    state = driven(vehicle, [(0.0, 2.0, 1.0), (0.0, 0.0, 1.0)])
    assert state[2] == pytest.approx(math.pi / 2)
    assert state[:2] == pytest.approx((0, 2.0), abs=1e-12)
    assert state[3:5] == pytest.approx((0, 0))


@pytest.mark.parametrize("kind", KINDS)
@pytest.mark.parametrize("radius", [0.0, 0.15, 40.0])
def test_every_robot_gets_a_vehicle_as_fast_as_it_and_settings_to_go_with_it(kind: str, radius: float) -> None:
    robot = Robot("R1", (0, 0), (1, 0), radius=radius, speed=3.0)
    vehicle = vehicle_for(robot, kind)
    kinds, params = tables([vehicle, vehicle])
    assert kinds.tolist() == [KINDS.index(kind)] * 2
    assert params.shape == (2, 8)
    assert params[0, 0] == pytest.approx(3.75)
    assert driven(vehicle, [(3.0, 0.0, 0.5)])[3] == pytest.approx(3.0)
    tracking = tracking_for(robot, vehicle, 0.02)
    assert 0 < tracking.tolerance < tracking.slack < tracking.leash
    assert tracking.tolerance == pytest.approx(0.015)
    assert 4 * tracking_for(robot, vehicle, 0.5).gain * 0.5 <= 0.5


def test_no_vehicles_make_empty_tables() -> None:
    kinds, params = tables([])
    assert kinds.shape == (0,)
    assert params.shape == (0, 8)


@pytest.mark.parametrize(
    ("wrong", "words"),
    [
        (lambda: Integrator(0.0), "top_speed must be positive"),
        (lambda: Integrator(math.inf), "top_speed must be finite"),
        (lambda: Integrator(math.nan), "top_speed must be positive"),
        (lambda: Unicycle(1.0, 0.0), "top_turn_rate must be positive"),
        (lambda: Unicycle(1.0, math.inf), "top_turn_rate must be finite"),
        (lambda: Unicycle(1.0, 1.0, -1.0), "acceleration must be positive"),
        (lambda: DifferentialDrive(0.0, 0.2, 10.0), "wheel_radius must be positive"),
        (lambda: DifferentialDrive(0.1, 0.0, 10.0), "track must be positive"),
        (lambda: Ackermann(0.3, 1.0, 1.6), "top_steering must be at most 1.5"),
        (lambda: Ackermann(0.3, 1.0, 0.5, 1.0, 0.0), "steering_rate must be positive"),
        (lambda: vehicle_for(ROBOT, "hovercraft"), "unknown vehicle 'hovercraft'"),
        (lambda: vehicle_for(ROBOT, "unicycle", reserve=0.5), "at least 1"),
        (lambda: tracking_for(ROBOT, Integrator(1.0), 0.0), "time step must be positive"),
    ],
)
def test_what_cannot_drive_is_refused_in_one_line(wrong: Any, words: str) -> None:
    with pytest.raises(SceneError, match=words) as caught:
        wrong()
    assert "\n" not in str(caught.value)
