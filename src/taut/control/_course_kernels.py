"""Kernels of courses: the way of a plan as its tracker takes it, with the speeds that bends and braking allow.

Tables have a row a robot. ``params`` is top speed, top turn rate, acceleration, turn acceleration, wheel radius, track
or wheelbase, top wheel speed or top steering angle, steering rate. ``tuning`` is gain, slack, leash, tolerance,
aligned, hurry, cutting, see `taut.control.tracking.Tracking`. A course has a row a stamp, the columns below; robot i
owns rows ``first[i]`` to ``first[i + 1]``.
"""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from taut.team._lean import lean_kernel

Floats = NDArray[np.float64]
Ints = NDArray[np.int64]

INTEGRATOR, UNICYCLE, DIFFERENTIAL, ACKERMANN = 0, 1, 2, 3

TIME, X, Y, TO_X, TO_Y, SPEED, LIMIT, LENGTH = range(8)
"""Columns: when and where, direction of the leg that begins here (a rest: of the next move), its speed in the plan,
the greatest speed of the reference here, metres of the leg."""
COLUMNS = 8

GAIN, SLACK, LEASH, TOLERANCE, ALIGNED, HURRY, CUTTING = range(7)
"""Columns of the tuning."""

SHARE = 0.7  # of the acceleration is planned with; the rest is for feedback and turning
_CREEPING = 0.1  # of its speed: a reference that would pass a corner slower stops there
_STRAIGHT = 1e-12  # radians that are rounding
_SLIGHT = 0.2  # radians that a truck takes at full speed
_HARDEST = 100.0  # 1/s: braking from top speed in a hundredth of a second is as good as at once


@lean_kernel
def lay_courses(stamps: Floats, first: Ints, kinds: Ints, params: Floats, tuning: Floats, course: Floats) -> None:
    """Write the course of every robot from the stamps (S, 3) of all."""
    for i in range(len(first) - 1):
        begin, end = first[i], first[i + 1]
        for k in range(begin, end):
            course[k, TIME], course[k, X], course[k, Y] = stamps[k, 0], stamps[k, 1], stamps[k, 2]
        _measure_legs(begin, end, course)
        _limit_speeds(i, begin, end, kinds[i], params, tuning, course)


@lean_kernel
def planned_braking(i: int, params: Floats) -> float:
    """Deceleration that the reference is planned with."""
    return float(min(SHARE * params[i, 2], _HARDEST * params[i, 0]))


@lean_kernel
def slow_speed(i: int, params: Floats) -> float:
    """Speed at which a truck steers fully in half the way of its turning radius."""
    return float(min(0.5 * turning_radius(i, params) * params[i, 7] / params[i, 6], params[i, 0]))


@lean_kernel
def turning_radius(i: int, params: Floats) -> float:
    return float(params[i, 5] / math.tan(params[i, 6]))


@lean_kernel
def _measure_legs(begin: int, end: int, course: Floats) -> None:
    to_x, to_y = 0.0, 0.0
    for k in range(begin, end - 1):
        to_x, to_y = course[k + 1, X] - course[k, X], course[k + 1, Y] - course[k, Y]
        length = math.hypot(to_x, to_y)
        course[k, LENGTH] = length
        course[k, SPEED] = length / (course[k + 1, TIME] - course[k, TIME])
        if length > 0.0:
            course[k, TO_X], course[k, TO_Y] = to_x / length, to_y / length
        else:
            course[k, TO_X], course[k, TO_Y] = 0.0, 0.0
    last = end - 1
    course[last, LENGTH] = course[last, SPEED] = 0.0
    course[last, TO_X] = course[last, TO_Y] = 0.0
    for k in range(end - 2, begin - 1, -1):
        if course[k, LENGTH] == 0.0:
            course[k, TO_X], course[k, TO_Y] = course[k + 1, TO_X], course[k + 1, TO_Y]
    for k in range(begin + 1, end):
        if course[k, TO_X] == 0.0 and course[k, TO_Y] == 0.0:
            course[k, TO_X], course[k, TO_Y] = course[k - 1, TO_X], course[k - 1, TO_Y]


@lean_kernel
def _limit_speeds(i: int, begin: int, end: int, kind: int, params: Floats, tuning: Floats, course: Floats) -> None:
    """Speed at every stamp: what its bend and those soon after it allow, and what can be braked before the next."""
    for k in range(begin, end):
        inside = begin < k < end - 1 and course[k, SPEED] > 0.0 and course[k - 1, SPEED] > 0.0
        course[k, LIMIT] = 0.0
        if inside:
            course[k, LIMIT] = _bend_speed(i, kind, params, tuning, abs(_bend_at(course, k)), 0.0)
            slow = course[k, LIMIT] < _CREEPING * min(course[k - 1, SPEED], course[k, SPEED])
            if slow and kind != ACKERMANN:
                course[k, LIMIT] = 0.0
    reach = params[i, 0] * turning_seconds(i, kind, params, tuning, math.pi)
    for a in range(begin + 1, end - 1):
        if course[a, LIMIT] > 0.0 and abs(_bend_at(course, a)) > _STRAIGHT:
            _limit_window(i, a, end, kind, params, tuning, reach, course)
    for k in range(end - 2, begin - 1, -1):
        after = course[k + 1, LIMIT]
        braked = math.sqrt(after * after + 2.0 * planned_braking(i, params) * course[k, LENGTH])
        course[k, LIMIT] = min(course[k, LIMIT], braked)


@lean_kernel
def _limit_window(
    i: int, a: int, end: int, kind: int, params: Floats, tuning: Floats, reach: float, course: Floats
) -> None:
    """Limit the speed where bends from row a on follow so soon on each other that they are one turn to the vehicle."""
    bend, metres = abs(_bend_at(course, a)), 0.0
    for m in range(a + 1, end - 1):
        metres += course[m - 1, LENGTH]
        if metres > reach or course[m, LIMIT] == 0.0:
            break
        bend += abs(_bend_at(course, m))
        speed = _bend_speed(i, kind, params, tuning, bend, metres)
        for k in range(a, m + 1):
            course[k, LIMIT] = min(course[k, LIMIT], speed)


@lean_kernel
def _bend_at(course: Floats, k: int) -> float:
    """Radians by which the leg of row k turns from the one before."""
    cross = course[k - 1, TO_X] * course[k, TO_Y] - course[k - 1, TO_Y] * course[k, TO_X]
    return math.atan2(cross, course[k - 1, TO_X] * course[k, TO_X] + course[k - 1, TO_Y] * course[k, TO_Y])


@lean_kernel
def _bend_speed(i: int, kind: int, params: Floats, tuning: Floats, bend: float, metres: float) -> float:
    """Greatest speed at which bends of so many radians, over so many metres, are taken within ``cutting`` of them."""
    if bend <= _STRAIGHT:
        return math.inf
    cutting = tuning[i, CUTTING]
    if kind == INTEGRATOR:
        # a corner changes the velocity by 2 v sin(β/2), and half of what passes meanwhile is cut; an arc needs v² β / ℓ
        half = math.sin(0.5 * min(bend, math.pi))
        return math.sqrt(params[i, 2] * (0.5 * cutting / (half * half) + SHARE * metres / bend))
    if kind == ACKERMANN:
        radius = turning_radius(i, params)
        return math.inf if bend < _SLIGHT or metres > radius * bend else slow_speed(i, params)
    corner = 2.0 * cutting / (bend * turning_seconds(i, kind, params, tuning, bend))
    if metres == 0.0:
        return float(corner)
    # an arc of radius R is left by v² / (4 g² R), as the heading lags by v / (4 g R), and where it begins by about
    # v (v / R)² / (2 g α), as the turning needs v / (R α) seconds to begin
    radius, gain, quickening = metres / bend, tuning[i, GAIN], (1.0 - SHARE) * params[i, 3]
    steady = 2.0 * gain * math.sqrt(cutting * radius)
    begun = (2.0 * gain * quickening * cutting * radius * radius) ** (1.0 / 3.0)
    return math.hypot(corner, min(steady, begun, SHARE * params[i, 1] * radius))


@lean_kernel
def turning_seconds(i: int, kind: int, params: Floats, tuning: Floats, bend: float) -> float:
    """Seconds that a turn by so many radians takes, the delay of the control included."""
    if kind == INTEGRATOR:
        return float(bend * params[i, 0] / params[i, 2])
    if kind == ACKERMANN:
        return float(bend * turning_radius(i, params) / params[i, 0])
    rate, quickening = params[i, 1], (1.0 - SHARE) * params[i, 3]
    # up to the top turn rate and down again, or not as far as to it
    seconds = bend / rate + rate / quickening
    if bend < rate * rate / quickening:
        seconds = 2.0 * math.sqrt(bend / quickening)
    return float(seconds + 0.5 / tuning[i, GAIN])
