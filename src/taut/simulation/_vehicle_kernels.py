"""Kernels that move vehicles: what their limits make of a command, and where it takes them."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from taut.control._course_kernels import ACKERMANN, DIFFERENTIAL, INTEGRATOR, UNICYCLE
from taut.team._lean import lean_kernel

Floats = NDArray[np.float64]
Ints = NDArray[np.int64]

__all__ = ["ACKERMANN", "DIFFERENTIAL", "INTEGRATOR", "UNICYCLE", "move"]

_ROOT = math.sqrt(15.0)
_STEP = 0.02
_STEERING_STEP = 0.02


@lean_kernel
def move(i: int, kinds: Ints, params: Floats, state: Floats, command: Floats, slip: Floats, dt: float) -> None:
    """Move robot i for dt seconds under its command; its row of ``state`` is changed in place.

    Arrays have a row a robot: ``kinds`` (n,), ``params`` (n, 8), ``state`` (n, 6) and ``command`` (n, 2) as in
    `taut.control._following_kernels`; ``slip`` (n, 2) is the motion over the ground as a share of what the wheels make,
    1 without slip: of the left and right wheel ("differential"), of the speed and the turn rate (others; an integrator
    has no turn rate). State holds what the wheels do, so slip shows in the places only.

    Commands are cut to the limits, then followed as quickly as the accelerations allow. Constant speeds are followed in
    closed form; linear ones by Gauss-Legendre collocation of order 6 in steps that turn by at most 1/50 radian, with an
    error below 1e-9 of the way that the wheels roll.
    """
    kind, forward, turn = kinds[i], command[i, 0], command[i, 1]
    if kind == INTEGRATOR:
        _glide(i, params, state, forward, turn, slip[i, 0], dt)
    elif kind == UNICYCLE:
        _spin(i, params, state, forward, turn, slip[i, 0], slip[i, 1], dt)
    elif kind == DIFFERENTIAL:
        _roll(i, params, state, forward, turn, slip[i, 0], slip[i, 1], dt)
    else:
        _steer(i, params, state, forward, turn, slip[i, 0], slip[i, 1], dt)


@lean_kernel
def _glide(i: int, params: Floats, state: Floats, vx: float, vy: float, grip: float, dt: float) -> None:
    """Move a single integrator: its velocity runs straight to the wanted one at the acceleration."""
    wanted = math.hypot(vx, vy)
    if wanted > params[i, 0]:
        vx, vy = vx * params[i, 0] / wanted, vy * params[i, 0] / wanted
    ux, uy = state[i, 3], state[i, 4]
    seconds = math.hypot(vx - ux, vy - uy) / params[i, 2]
    if seconds > dt:
        vx, vy = ux + (vx - ux) * (dt / seconds), uy + (vy - uy) * (dt / seconds)
        seconds = dt
    # while it changes, the mean of both counts
    state[i, 0] += grip * (0.5 * (ux + vx) * seconds + vx * (dt - seconds))
    state[i, 1] += grip * (0.5 * (uy + vy) * seconds + vy * (dt - seconds))
    state[i, 3], state[i, 4] = vx, vy
    if vx != 0.0 or vy != 0.0:
        state[i, 2] = math.atan2(vy, vx)
    elif ux != 0.0 or uy != 0.0:
        state[i, 2] = math.atan2(uy, ux)


@lean_kernel
def _spin(
    i: int, params: Floats, state: Floats, forward: float, turn: float, grip: float, turn_grip: float, dt: float,
) -> None:  # fmt: skip
    """Move a unicycle: speed and turn rate run to the wanted ones, each at its acceleration."""
    forward, turn = _cut(forward, params[i, 0]), _cut(turn, params[i, 1])
    v, w = state[i, 3], state[i, 4]
    _ramp(i, state, v, forward, params[i, 2], w, turn, params[i, 3], grip, 0.0, 0.0, turn_grip, dt)
    state[i, 3] = _reached(v, forward, params[i, 2], dt)
    state[i, 4] = _reached(w, turn, params[i, 3], dt)


@lean_kernel
def _roll(
    i: int, params: Floats, state: Floats, forward: float, turn: float, grip_left: float, grip_right: float,
    dt: float,
) -> None:  # fmt: skip
    """Move a differential drive: each wheel runs to its speed; where one cannot, both are cut to keep the curvature."""
    half = 0.5 * params[i, 5]
    forward, turn = _cut(forward, params[i, 0]), _cut(turn, params[i, 1])
    left, right = forward - half * turn, forward + half * turn
    top = params[i, 4] * params[i, 6]
    fastest = max(abs(left), abs(right))
    if fastest > top:
        left, right = left * (top / fastest), right * (top / fastest)
    was_left, was_right = state[i, 3] - half * state[i, 4], state[i, 3] + half * state[i, 4]
    rate = params[i, 2]
    a, b = 0.5 * grip_left, 0.5 * grip_right
    _ramp(i, state, was_left, left, rate, was_right, right, rate, a, b, -a / half, b / half, dt)
    left, right = _reached(was_left, left, rate, dt), _reached(was_right, right, rate, dt)
    state[i, 3], state[i, 4] = 0.5 * (left + right), 0.5 * (right - left) / half


@lean_kernel
def _steer(
    i: int, params: Floats, state: Floats, forward: float, turn: float, grip: float, turn_grip: float, dt: float,
) -> None:  # fmt: skip
    """Move an Ackermann vehicle: θ' = v tan(φ) / wheelbase, the point that moves is the middle of the rear axle."""
    forward, turn = _cut(forward, params[i, 0]), _cut(turn, params[i, 1])
    base, sharpest = params[i, 5], params[i, 6]
    angle = state[i, 5]
    if forward != 0.0:
        angle = _cut(math.atan(base * turn / forward), sharpest)
    elif turn != 0.0:
        angle = math.copysign(sharpest, turn)
    v, phi = state[i, 3], state[i, 5]
    quickening, steering = params[i, 2], params[i, 7]
    first, second = _knees(v, forward, quickening, phi, angle, steering, dt)
    at = 0.0
    for until in (first, second, dt):
        if until > at:
            va, vb = _reached(v, forward, quickening, at), _reached(v, forward, quickening, until)
            a, b = _reached(phi, angle, steering, at), _reached(phi, angle, steering, until)
            _steered(i, state, grip * va, grip * vb, a, b, base / turn_grip, until - at)
            at = until
    state[i, 3] = _reached(v, forward, quickening, dt)
    state[i, 5] = _reached(phi, angle, steering, dt)
    state[i, 4] = state[i, 3] * math.tan(state[i, 5]) / base


@lean_kernel
def _ramp(
    i: int, state: Floats, p0: float, p1: float, p_rate: float, q0: float, q1: float, q_rate: float, vp: float,
    vq: float, wp: float, wq: float, dt: float,
) -> None:  # fmt: skip
    """Drive while p and q run from their first to their last values; v = vp p + vq q, ω = wp p + wq q."""
    first, second = _knees(p0, p1, p_rate, q0, q1, q_rate, dt)
    at = 0.0
    for until in (first, second, dt):
        if until > at:
            pa, pb = _reached(p0, p1, p_rate, at), _reached(p0, p1, p_rate, until)
            qa, qb = _reached(q0, q1, q_rate, at), _reached(q0, q1, q_rate, until)
            va, vb = vp * pa + vq * qa, vp * pb + vq * qb
            wa, wb = wp * pa + wq * qa, wp * pb + wq * qb
            if pa == pb and qa == qb:
                _arc(i, state, va * (until - at), wa * (until - at))
            else:
                _quadrature(i, state, va, vb, wa, wb, until - at)
            at = until


@lean_kernel
def _knees(p0: float, p1: float, p_rate: float, q0: float, q1: float, q_rate: float, dt: float) -> tuple[float, float]:
    """The two times, at most dt, at which p and q reach their last values, in order."""
    p_time, q_time = abs(p1 - p0) / p_rate, abs(q1 - q0) / q_rate
    return min(p_time, q_time, dt), min(max(p_time, q_time), dt)


@lean_kernel
def _reached(old: float, new: float, rate: float, seconds: float) -> float:
    """Value on its way from old to new after so many seconds."""
    needed = abs(new - old) / rate
    return new if seconds >= needed else old + (new - old) * (seconds / needed)


@lean_kernel
def _cut(value: float, most: float) -> float:
    return min(max(value, -most), most)


@lean_kernel
def _arc(i: int, state: Floats, length: float, turn: float) -> None:
    """Drive an arc of this length in metres that turns by so many radians: its chord points along half the turn."""
    half = 0.5 * turn
    chord = length * (1.0 - half * half / 6.0 if abs(half) < 1e-4 else math.sin(half) / half)
    state[i, 0] += chord * math.cos(state[i, 2] + half)
    state[i, 1] += chord * math.sin(state[i, 2] + half)
    state[i, 2] += turn


@lean_kernel
def _quadrature(i: int, state: Floats, v0: float, v1: float, w0: float, w1: float, seconds: float) -> None:
    """Drive with speed and turn rate linear in time: θ is a parabola, the place a three point Gauss quadrature."""
    steps = 1 + int(max(abs(w0), abs(w1)) * seconds / _STEP)
    h = seconds / steps
    heading = state[i, 2]
    slope = (w1 - w0) / seconds
    quickening = (v1 - v0) / seconds
    x, y = 0.0, 0.0
    for step in range(steps):
        for node in range(3):
            t = h * (step + 0.5 + 0.1 * _ROOT * (node - 1))
            weight = h * (4.0 / 9.0 if node == 1 else 5.0 / 18.0)
            angle = heading + t * (w0 + 0.5 * slope * t)
            speed = weight * (v0 + quickening * t)
            x += speed * math.cos(angle)
            y += speed * math.sin(angle)
    state[i, 0] += x
    state[i, 1] += y
    state[i, 2] = heading + 0.5 * (w0 + w1) * seconds


@lean_kernel
def _steered(
    i: int, state: Floats, v0: float, v1: float, phi0: float, phi1: float, base: float, seconds: float,
) -> None:  # fmt: skip
    """Drive with speed and steering angle linear in time; a steering angle that rests gives an arc."""
    if phi0 == phi1:
        length = 0.5 * (v0 + v1) * seconds
        _arc(i, state, length, length * math.tan(phi0) / base)
        return
    fastest = max(abs(v0), abs(v1)) * max(abs(math.tan(phi0)), abs(math.tan(phi1))) * seconds / base
    steps = 1 + int(max(fastest / _STEP, abs(phi1 - phi0) / _STEERING_STEP))
    h = seconds / steps
    x, y = 0.0, 0.0
    for step in range(steps):
        s0, s1, s2 = step + 0.5 - 0.1 * _ROOT, step + 0.5, step + 0.5 + 0.1 * _ROOT
        a0 = v0 + (v1 - v0) * s0 / steps
        a1 = v0 + (v1 - v0) * s1 / steps
        a2 = v0 + (v1 - v0) * s2 / steps
        w0 = h / base * a0 * math.tan(phi0 + (phi1 - phi0) * s0 / steps)
        w1 = h / base * a1 * math.tan(phi0 + (phi1 - phi0) * s1 / steps)
        w2 = h / base * a2 * math.tan(phi0 + (phi1 - phi0) * s2 / steps)
        heading = state[i, 2]
        # the headings at the nodes, from the parabola through the turn rates there
        t0 = heading + w0 * 5 / 36 + w1 * (2 / 9 - _ROOT / 15) + w2 * (5 / 36 - _ROOT / 30)
        t1 = heading + w0 * (5 / 36 + _ROOT / 24) + w1 * 2 / 9 + w2 * (5 / 36 - _ROOT / 24)
        t2 = heading + w0 * (5 / 36 + _ROOT / 30) + w1 * (2 / 9 + _ROOT / 15) + w2 * 5 / 36
        x += h * (5 * a0 * math.cos(t0) + 8 * a1 * math.cos(t1) + 5 * a2 * math.cos(t2)) / 18
        y += h * (5 * a0 * math.sin(t0) + 8 * a1 * math.sin(t1) + 5 * a2 * math.sin(t2)) / 18
        state[i, 2] = heading + (5 * w0 + 8 * w1 + 5 * w2) / 18
    state[i, 0] += x
    state[i, 1] += y
