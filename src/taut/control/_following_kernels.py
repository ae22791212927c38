"""Kernels of the tracker: progress along the course of a plan, and the commands that keep to it.

Courses, ``params`` and ``tuning`` are those of `taut.control._course_kernels`. ``state`` is x, y, θ, v, ω, φ, a row a
robot. ``leg`` (n,) is the row at which each robot's present leg begins, ``pace`` (n,) the speed of its reference in
metres a second, ``trim`` (n,) what its speed was found to lack, as a share.
"""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from taut.control._course_kernels import (
    ACKERMANN,
    ALIGNED,
    GAIN,
    HURRY,
    INTEGRATOR,
    LEASH,
    LENGTH,
    LIMIT,
    SHARE,
    SLACK,
    SPEED,
    TIME,
    TO_X,
    TO_Y,
    TOLERANCE,
    X,
    Y,
    planned_braking,
    slow_speed,
    turning_radius,
)
from taut.team._lean import lean_kernel

Floats = NDArray[np.float64]
Ints = NDArray[np.int64]

_MOST_TRIM = 0.35
_FASTEST = 0.95  # of the top speed: who follows must be able to catch up
_STEADY = 10.0  # tolerances: a deviation by one turns the aim by at most a tenth of a radian in motion
_BACK = 10.0  # tolerances: over so many back is nearer than round
_DRIFT = 3.0  # tolerances
_STANDING = 0.02  # steps of braking: a speed that is none


@lean_kernel
def advance(
    i: int, kinds: Ints, params: Floats, tuning: Floats, state: Floats, course: Floats, first: Ints, leg: Ints,
    pace: Floats, progress: Floats, bound: float, clock: float, dt: float,
) -> None:  # fmt: skip
    """Move progress σ and pace of robot i on by dt seconds, up to ``bound`` and the ``clock`` at the end of the step.

    Progress waits at corners and at the ends of rests until the vehicle stands there and looks along the next leg.
    """
    latest = min(bound, clock)
    sigma = progress[i]
    end = first[i + 1]
    k = _leg_at(leg[i], end, course, sigma)
    left = dt
    while k + 1 < end and sigma < latest and left > 0.0:
        if sigma == course[k, TIME] and not _ready(i, kinds[i], params, tuning, state, course, k, dt):
            pace[i] = 0.0
            break
        until = min(course[k + 1, TIME], latest)
        speed = course[k, SPEED]
        if speed == 0.0:
            pace[i] = 0.0
            rate = tuning[i, HURRY]
        else:
            before = pace[i]
            pace[i] = _pace(i, params, tuning, state, course, end, k, sigma, bound, clock, before, left)
            rate = 0.5 * (before + pace[i]) / speed
            if rate <= 0.0:
                break
        needed = (until - sigma) / rate
        if needed > left:
            sigma += rate * left
            break
        left -= needed
        sigma = until
        k = _leg_at(k, end, course, sigma)
    stands = sigma == course[k, TIME] and course[k, LIMIT] == 0.0
    if stands or sigma >= bound:
        pace[i] = 0.0
    progress[i], leg[i] = sigma, k


@lean_kernel
def command(
    i: int, kinds: Ints, params: Floats, tuning: Floats, state: Floats, course: Floats, first: Ints, leg: Ints,
    pace: Floats, trim: Floats, progress: Floats, dt: float, out: Floats,
) -> None:  # fmt: skip
    """Write what robot i is to do for the next dt seconds into its row of ``out`` (n, 2), and learn its trim.

    The row is forward speed and turn rate, or the velocity of an integrator.
    """
    k, speed = leg[i], pace[i]
    x, y = _reference(course, first[i + 1], k, progress[i])
    to_x, to_y, heading = course[k, TO_X], course[k, TO_Y], state[i, 2]
    # the reference is where it will be after the step, the vehicle where it is before
    ahead_x = x - speed * dt * to_x - state[i, 0]
    ahead_y = y - speed * dt * to_y - state[i, 1]
    distance = math.hypot(ahead_x, ahead_y)
    gain, tolerance = tuning[i, GAIN], tuning[i, TOLERANCE]
    pull = _approach(distance, gain, (1.0 - SHARE) * params[i, 2]) / distance if distance > 0.0 else 0.0
    wish_x, wish_y = speed * to_x + pull * ahead_x, speed * to_y + pull * ahead_y
    forward = wish_x * math.cos(heading) + wish_y * math.sin(heading)
    _learn(i, kinds[i], params, gain, state, wish_x, wish_y, forward, speed, ahead_x * to_x + ahead_y * to_y, trim, dt)
    more = 1.0 + trim[i]
    if kinds[i] == INTEGRATOR:
        out[i, 0], out[i, 1] = more * wish_x, more * wish_y
    elif kinds[i] == ACKERMANN:
        _command_truck(
            i, params, tuning, state, course, first[i + 1], k, progress[i], speed, more, ahead_x, ahead_y, out
        )
    elif speed == 0.0 and _has_reached(i, params, tuning, state, distance, dt):
        out[i, 0] = out[i, 1] = 0.0
        # first stop, then turn; who never moves has no direction to turn to
        if abs(state[i, 3]) <= _STANDING * params[i, 2] * dt and (to_x != 0.0 or to_y != 0.0):
            out[i, 1] = _turn_rate(i, params, gain, _angle_to(heading, to_x, to_y), SHARE)
    else:
        # slow, it would turn far for a small deviation
        least = max(speed, _STEADY * gain * tolerance) if speed > 0.0 else 0.0
        aim_x, aim_y = least * to_x + pull * ahead_x, least * to_y + pull * ahead_y
        if distance > _BACK * tolerance:
            forward = max(forward, 0.0)
        elif aim_x * math.cos(heading) + aim_y * math.sin(heading) < 0.0:
            aim_x, aim_y = -aim_x, -aim_y
        off = _angle_to(heading, aim_x, aim_y)
        out[i, 0] = more * forward
        out[i, 1] = _turn_rate(i, params, gain, off, SHARE if speed == 0.0 else 1.0 - SHARE)


@lean_kernel
def _learn(
    i: int, kind: int, params: Floats, gain: float, state: Floats, wish_x: float, wish_y: float, forward: float,
    speed: float, lag: float, trim: Floats, dt: float,
) -> None:  # fmt: skip
    """Adapt the trim to the lag, critically damped at top speed, while the wheels do what is asked."""
    more = 1.0 + trim[i]
    if kind == INTEGRATOR:
        lacking = math.hypot(more * wish_x - state[i, 3], more * wish_y - state[i, 4])
    else:
        lacking = abs(more * forward - state[i, 3])
    if speed > 0.0 and lacking <= 0.5 * params[i, 2] * dt:
        top = params[i, 0]
        learnt = trim[i] + 0.25 * gain * gain * lag * speed / (top * top) * dt
        trim[i] = min(max(learnt, -_MOST_TRIM), _MOST_TRIM)


@lean_kernel
def stands_level(
    i: int, kinds: Ints, params: Floats, tuning: Floats, state: Floats, course: Floats, first: Ints, leg: Ints,
    pace: Floats, progress: Floats,
) -> bool:  # fmt: skip
    """Tell whether a truck has stopped beside its reference or beyond, and will not come nearer while that rests."""
    if kinds[i] != ACKERMANN or pace[i] != 0.0 or state[i, 3] != 0.0:
        return False
    x, y = _reference(course, first[i + 1], leg[i], progress[i])
    level, distance = _truck_to(i, state, x - state[i, 0], y - state[i, 1])
    front, _ = _truck_aims(i, params, state, course, first[i + 1], leg[i], progress[i], level)
    return _has_passed(i, params, tuning, level, distance, front)


@lean_kernel
def slowed(lag: float, slack: float, leash: float) -> float:
    """Share of its speed that the reference keeps at a lag in metres: 1 up to ``slack``, 0 from ``leash`` on."""
    if lag <= slack:
        return 1.0
    return max((leash - lag) / (leash - slack), 0.0)


@lean_kernel
def _leg_at(k: int, end: int, course: Floats, sigma: float) -> int:
    """Row of the leg that holds plan time σ, from row k on; at a stamp the leg that begins there."""
    while k + 1 < end and course[k + 1, TIME] <= sigma:
        k += 1
    return k


@lean_kernel
def _reference(course: Floats, end: int, k: int, sigma: float) -> tuple[float, float]:
    """Place planned for plan time σ on the leg of row k."""
    if k + 1 >= end or course[k, LENGTH] == 0.0:
        return course[k, X], course[k, Y]
    share = (sigma - course[k, TIME]) / (course[k + 1, TIME] - course[k, TIME])
    share = min(max(share, 0.0), 1.0)
    x = course[k, X] + share * (course[k + 1, X] - course[k, X])
    return x, course[k, Y] + share * (course[k + 1, Y] - course[k, Y])


@lean_kernel
def _ready(i: int, kind: int, params: Floats, tuning: Floats, state: Floats, course: Floats, k: int, dt: float) -> bool:
    """Tell whether the vehicle may leave the stamp of row k: it passes, or it stands there and looks along the leg."""
    if course[k, LIMIT] > 0.0 or course[k, SPEED] == 0.0 or kind in (ACKERMANN, INTEGRATOR):
        return True
    away = math.hypot(course[k, X] - state[i, 0], course[k, Y] - state[i, 1])
    off = _angle_to(state[i, 2], course[k, TO_X], course[k, TO_Y])
    return bool(abs(off) <= tuning[i, ALIGNED] and _has_reached(i, params, tuning, state, away, dt))


@lean_kernel
def _has_reached(i: int, params: Floats, tuning: Floats, state: Floats, away: float, dt: float) -> bool:
    """Tell whether a place so far away has been reached; a spin there that drifts off a little need not be undone."""
    spins = abs(state[i, 3]) <= _STANDING * params[i, 2] * dt and abs(state[i, 4]) > 1e-3 * params[i, 1]
    return bool(away <= (_DRIFT * tuning[i, TOLERANCE] if spins else tuning[i, TOLERANCE]))


@lean_kernel
def _pace(
    i: int, params: Floats, tuning: Floats, state: Floats, course: Floats, end: int, k: int, sigma: float,
    bound: float, clock: float, pace: float, dt: float,
) -> float:  # fmt: skip
    """Speed of the reference in the next dt seconds, metres a second."""
    x, y = _reference(course, end, k, sigma)
    lag = math.hypot(x - state[i, 0], y - state[i, 1])
    braking = planned_braking(i, params)
    planned = course[k, SPEED]
    # who has caught up with the clock goes at its pace
    late = planned * max(clock - dt - sigma, 0.0)
    hurried = min(tuning[i, HURRY] * planned, planned + _approach(late, tuning[i, GAIN], braking))
    wanted = min(hurried, _FASTEST * params[i, 0])
    wanted *= slowed(lag, tuning[i, SLACK], tuning[i, LEASH])
    left = course[k, LENGTH] * (course[k + 1, TIME] - sigma) / (course[k + 1, TIME] - course[k, TIME])
    # a little of a step's braking keeps the approach from never ending
    least = 0.1 * braking * dt
    wanted = min(wanted, max(_braked(pace, course[k + 1, LIMIT], left, braking, dt), least))
    # others may stop for good at any moment, so what they allow now is all that is certain
    if bound < math.inf:
        left = _metres_to(course, end, k, sigma, bound, wanted * (dt + wanted / braking))
        wanted = min(wanted, max(_braked(pace, 0.0, left, braking, dt), least))
    return float(min(pace + SHARE * params[i, 2] * dt, wanted))


@lean_kernel
def _braked(speed: float, limit: float, metres: float, braking: float, dt: float) -> float:
    """Speed after dt seconds, at the mean of old and new, from which ``limit`` is reached at this braking in time.

    So it is the positive root u of u² = limit² + 2 b (metres − (speed + u) dt / 2); 0 if there is none.
    """
    half = 0.5 * braking * dt
    squared = half * half + limit * limit + 2.0 * braking * metres - braking * speed * dt
    return max(math.sqrt(max(squared, 0.0)) - half, 0.0)


@lean_kernel
def _metres_to(course: Floats, end: int, k: int, sigma: float, until: float, enough: float) -> float:
    """Metres of the course from plan time σ on row k to plan time ``until``, counted no farther than ``enough``."""
    metres = 0.0
    while k + 1 < end and sigma < until and metres < enough:
        next_time = course[k + 1, TIME]
        metres += course[k, SPEED] * (min(next_time, until) - sigma)
        sigma = next_time
        k += 1
    return metres


@lean_kernel
def _approach(distance: float, gain: float, deceleration: float) -> float:
    """Speed towards a place so many metres away: gain · distance near it, from afar what the deceleration can stop."""
    near = deceleration / (gain * gain)
    if distance <= near:
        return gain * distance
    return math.sqrt(2.0 * deceleration * (distance - 0.5 * near))


@lean_kernel
def _angle_to(heading: float, to_x: float, to_y: float) -> float:
    """Radians from a heading to a direction, in [−π, π]."""
    c, s = math.cos(heading), math.sin(heading)
    return math.atan2(c * to_y - s * to_x, c * to_x + s * to_y)


@lean_kernel
def _turn_rate(i: int, params: Floats, gain: float, off: float, share: float) -> float:
    """Turn rate that takes a heading error of so many radians away, four times as quick as the way: critically damped.

    ``share`` is the part of the turn acceleration that driving leaves.
    """
    rate = min(_approach(abs(off), 4.0 * gain, share * params[i, 3]), params[i, 1])
    return math.copysign(rate, off)


@lean_kernel
def _command_truck(
    i: int, params: Floats, tuning: Floats, state: Floats, course: Floats, end: int, k: int, sigma: float,
    speed: float, more: float, ahead_x: float, ahead_y: float, out: Floats,
) -> None:  # fmt: skip
    """Forward on the arc to a place ahead on the course; it stops level with where the reference stands."""
    radius = turning_radius(i, params)
    level, distance = _truck_to(i, state, ahead_x, ahead_y)
    front, left = _truck_aims(i, params, state, course, end, k, sigma, level)
    if speed == 0.0 and _has_passed(i, params, tuning, level, distance, front):
        out[i, 0] = out[i, 1] = 0.0
        return
    forward = speed + math.copysign(_approach(abs(level), tuning[i, GAIN], (1.0 - SHARE) * params[i, 2]), level)
    slow = slow_speed(i, params)
    if front < 0.0:
        # what lies behind is reached by a loop
        bend, forward = math.copysign(1.0 / radius, left), slow
    else:
        bend = 2.0 * left / (front * front + left * left)
        bend = min(max(bend, -1.0 / radius), 1.0 / radius)
        sharpness = abs(bend) * radius
        forward = min(forward, (1.0 - sharpness) * params[i, 0] + sharpness * slow)
    forward = max(more * forward, 0.0)
    out[i, 0], out[i, 1] = forward, bend * forward


@lean_kernel
def _truck_to(i: int, state: Floats, x: float, y: float) -> tuple[float, float]:
    """Metres that a place (x, y) from the truck lies before it, and away from it."""
    return math.cos(state[i, 2]) * x + math.sin(state[i, 2]) * y, math.hypot(x, y)


@lean_kernel
def _truck_aims(
    i: int, params: Floats, state: Floats, course: Floats, end: int, k: int, sigma: float, level: float
) -> tuple[float, float]:
    """Metres to the front and to the left at which the place lies that a truck drives to."""
    x, y = _place_ahead(course, end, k, sigma, 1.2 * turning_radius(i, params) + max(-level, 0.0))
    x, y = x - state[i, 0], y - state[i, 1]
    c, s = math.cos(state[i, 2]), math.sin(state[i, 2])
    return c * x + s * y, c * y - s * x


@lean_kernel
def _has_passed(i: int, params: Floats, tuning: Floats, level: float, distance: float, front: float) -> bool:
    """Tell whether a truck has come as far as its reference: near it, or where its course leads on before it."""
    return bool(level <= tuning[i, TOLERANCE] and (distance <= 2.0 * turning_radius(i, params) or front >= 0.0))


@lean_kernel
def _place_ahead(course: Floats, end: int, k: int, sigma: float, metres: float) -> tuple[float, float]:
    """Place so many metres of the course ahead of plan time σ; beyond its end, straight on along the last leg."""
    x, y = _reference(course, end, k, sigma)
    while k + 1 < end:
        left = math.hypot(course[k + 1, X] - x, course[k + 1, Y] - y)
        if left >= metres:
            break
        metres -= left
        k += 1
        x, y = course[k, X], course[k, Y]
    return x + metres * course[k, TO_X], y + metres * course[k, TO_Y]
