"""The closed loop: all robots of a team, step by step, from what they may do to what they have done.

In a step every robot is told how far its reference may go (coordination), moves its reference, takes a command from
its controller, moves, and finds how far along its plan it has come; then all are measured. Two plan times belong to a
robot: its reference, where its controller aims, and its progress, the plan time at the nearest point of its path up to
there. Others give way to progress; so they are safe however far a robot lags, and only its distance from its path,
the stray, has to be covered by a margin.
"""

from __future__ import annotations

import numpy as np

from taut.control._coordination_kernels import Pending, Waits, bounds
from taut.control._course_kernels import LENGTH, TO_X, TO_Y, TOLERANCE, slow_speed, turning_radius, turning_seconds
from taut.control._following_kernels import advance, command, stands_level
from taut.simulation._chance_kernels import grip, halted, perceive
from taut.simulation._loop_state import (
    COLLISIONS,
    ENDED,
    EVENTS_FULL,
    GOING,
    PAIRS,
    PAIRS_FULL,
    ROWS,
    ROWS_FULL,
    STEP,
    STUCK,
    WAITS,
    Chance,
    Floats,
    Ground,
    Ints,
    Near,
    Now,
    Rows,
    Tally,
    Team,
)  # fmt: skip
from taut.simulation._measuring_kernels import list_near, measure_ground, measure_pairs, work
from taut.simulation._nearness_kernels import greatest
from taut.simulation._vehicle_kernels import ACKERMANN, move
from taut.team._lean import lean_kernel

_JOINED = 1.0  # seconds after which waiting for the same robot again is another wait
_PATIENCE = 10.0  # seconds without any progress, and time to turn once round, after which there will be none
_CREEP = 1e-6  # plan seconds a second: less is no progress


@lean_kernel
def run_steps(
    dt: float, most: int, stride: int, until: float, tol: float, chance: Chance, team: Team, ground: Ground,
    waits: Waits, pending: Pending, now: Now, tally: Tally, near: Near, rows: Rows, collisions: Floats,
    held: Floats, counts: Ints,
) -> int:  # fmt: skip
    """Let the team drive for ``most`` steps, or until it has ended or something is full; returns what of these it is.

    GOING: after so many steps. ENDED: all have arrived. STUCK: nobody will go on, or the time ``until`` is over.
    Otherwise Python makes room and calls again; calls in pieces and in one give the same run. Every ``stride``-th
    instant is recorded, none if 0.
    """
    n = len(team.kinds)
    patience = _patience(team)
    last = counts[STEP] + most
    while True:
        step = counts[STEP]
        if step == last:
            return GOING
        time = step * dt
        if stride > 0 and step % stride == 0 and counts[ROWS] == len(rows.times):
            return ROWS_FULL
        if counts[COLLISIONS] + max(counts[PAIRS], 0) + n > len(collisions) or counts[WAITS] + n > len(held):
            return EVENTS_FULL
        if (counts[PAIRS] < 0 or greatest(near.moved) > 0.4 * near.skin) and not list_near(
            time, ground, team, now, near, collisions, counts
        ):
            return PAIRS_FULL
        ended, stuck = _over(time, dt, patience, team, chance, now)
        if ended or stuck or time >= until:
            return ENDED if ended else STUCK
        if stride > 0 and step % stride == 0:
            record(time, now, team, rows, counts)
        bounds(waits, pending, now.progress, now.bound, now.held_by)
        for i in range(n):
            near.before[i, 0], near.before[i, 1] = now.state[i, 0], now.state[i, 1]
            if now.gone[i] <= time:
                continue
            _drive(i, step, time, dt, chance, team, now, tally, held, counts)
            perceive(i, step + 1, dt, chance, team, now)
            _advance_progress(i, team, now)
            moved = np.sqrt((now.state[i, 0] - near.before[i, 0]) ** 2 + (now.state[i, 1] - near.before[i, 1]) ** 2)
            near.moved[i] += moved
            tally.done[i, 0] += moved
            _measure_stray(i, time + dt, team, now, tally)
            measure_ground(
                i, near.before[i, 0], near.before[i, 1], time + dt, tol, team, ground, now, tally, collisions, counts
            )
            if now.arrived[i] == np.inf and now.progress[i] >= team.stamps[team.first[i + 1] - 1, 0]:
                now.arrived[i] = time + dt
                if team.leaves[i]:
                    now.gone[i] = time + dt
        measure_pairs(time, dt, tol, team, now, tally, near, collisions, counts)
        counts[STEP] = step + 1


@lean_kernel
def _patience(team: Team) -> float:
    """Seconds after which somebody who turns as far as there is to turn would have come on."""
    most = 0.0
    for i in range(len(team.kinds)):
        if team.kinds[i] == ACKERMANN:
            seconds = 2.0 * np.pi * turning_radius(i, team.params) / slow_speed(i, team.params)
        else:
            seconds = turning_seconds(i, team.kinds[i], team.params, team.tuning, 2.0 * np.pi)
        most = max(most, seconds / min(team.drift[i], 1.0))
    return most + _PATIENCE


@lean_kernel
def _over(time: float, dt: float, patience: float, team: Team, chance: Chance, now: Now) -> tuple[bool, bool]:
    """Whether all have arrived, and whether nobody has come on for long though nobody who could go on halts."""
    ended, halting, total = True, False, 0.0
    for i in range(len(team.kinds)):
        total += now.progress[i]
        if now.arrived[i] == np.inf:
            ended = False
            free = time < team.dies[i] and now.progress[i] < now.bound[i]
            halting = halting or (free and chance.stops > 0.0 and now.halts[i, 0] <= time < now.halts[i, 1])
    if halting or total > now.idle[1] + _CREEP * dt:
        now.idle[0], now.idle[1] = 0.0, total
    else:
        now.idle[0] += dt
    return ended, now.idle[0] > patience


@lean_kernel
def _drive(
    i: int, step: int, time: float, dt: float, chance: Chance, team: Team, now: Now, tally: Tally, held: Floats,
    counts: Ints,
) -> None:  # fmt: skip
    """Move robot i's reference, and the robot after it, by one step."""
    was = now.reference[i]
    advance(
        i, team.kinds, team.params, team.tuning, now.seen, team.course, team.first, now.leg, now.pace, now.reference,
        now.bound[i], time + dt, dt,
    )  # fmt: skip
    lost = dt - (now.reference[i] - was)
    if now.held_by[i] >= 0 and now.reference[i] >= now.bound[i] and now.bound[i] < time and lost > 0.01 * dt:
        _wait(i, now.held_by[i], time, dt, lost, now, held, counts)
    if time >= team.dies[i] or halted(i, time, chance, now):
        now.command[i, 0] = now.command[i, 1] = 0.0
    else:
        command(
            i, team.kinds, team.params, team.tuning, now.seen, team.course, team.first, now.leg, now.pace, now.trim,
            now.reference, dt, now.command,
        )  # fmt: skip
    grip(i, time, chance, team, now)
    v, turn, heading = now.state[i, 3], now.state[i, 4], now.state[i, 2]
    move(i, team.kinds, team.params, now.state, now.command, now.slip, dt)
    tally.done[i, 1] += abs(now.state[i, 2] - heading)
    tally.done[i, 2] += work(team.kinds[i], team.radii[i], v, turn, now.state[i, 3], now.state[i, 4], dt)


@lean_kernel
def _measure_stray(i: int, time: float, team: Team, now: Now, tally: Tally) -> None:
    stray = _stray(i, team, now)
    tally.done[i, 3] += stray * stray
    tally.done[i, 4] += 1.0
    if stray > tally.worst[i, 0]:
        tally.worst[i, 0], tally.worst[i, 1] = stray, time
        tally.worst[i, 2], tally.worst[i, 3] = now.state[i, 0], now.state[i, 1]


@lean_kernel
def _planned(team: Team, k: int, last: int, time: float) -> tuple[float, float]:
    """Planned position at a time on the leg that begins at stamp k; the last stamp for good."""
    stamps = team.stamps
    if k >= last:
        return stamps[last, 1], stamps[last, 2]
    s = (time - stamps[k, 0]) / (stamps[k + 1, 0] - stamps[k, 0])
    x = (1.0 - s) * stamps[k, 1] + s * stamps[k + 1, 1]
    return x, (1.0 - s) * stamps[k, 2] + s * stamps[k + 1, 2]


@lean_kernel
def _advance_progress(i: int, team: Team, now: Now) -> None:
    """Move the progress of robot i to the nearest point of its path, the latest of equals.

    The path is looked at from the progress before to the reference and, where the robot may be ahead of it, to the end
    of the reference's leg or its bound. Who is level with the reference, as near as its tracker ever comes, has reached
    it: nobody waits for the last millimetres, nor for a truck that has stopped beside.
    """
    stamps = team.stamps
    last = team.first[i + 1] - 1
    px, py = now.seen[i, 0], now.seen[i, 1]
    until = now.reference[i]
    best, at, leg, near_x, near_y, level = np.inf, now.progress[i], now.behind[i], np.inf, np.inf, np.inf
    x, y = _planned(team, now.leg[i], last, until)
    for k in range(now.behind[i], min(now.leg[i] + 1, last)):
        t0, t1 = max(stamps[k, 0], now.progress[i]), min(stamps[k + 1, 0], until)
        if k == now.leg[i] and team.course[k, LENGTH] > 0.0:
            t1 = max(t1, min(stamps[k + 1, 0], now.bound[i]))
        t1 = max(t0, t1)
        ax, ay = _planned(team, k, last, t0)
        bx, by = _planned(team, k, last, t1)
        rx, ry = bx - ax, by - ay
        whole = rx * rx + ry * ry
        s = 1.0
        if whole > 0.0:
            s = min(max(((px - ax) * rx + (py - ay) * ry) / whole, 0.0), 1.0)
        on_x, on_y = ax + s * rx, ay + s * ry
        d = (on_x - px) ** 2 + (on_y - py) ** 2
        if d <= best:
            best, at, leg, near_x, near_y = d, (1.0 - s) * t0 + s * t1, k, on_x, on_y
            level = abs((x - px) * team.course[k, TO_X] + (y - py) * team.course[k, TO_Y])
    close = 2.0 * team.tuning[i, TOLERANCE]
    reached = level <= close and (near_x - x) ** 2 + (near_y - y) ** 2 <= close * close
    if at < until and (reached or _stands_level(i, team, now)):
        at, leg = until, now.leg[i]
    now.progress[i] = max(now.progress[i], at)
    now.behind[i] = leg


@lean_kernel
def _stands_level(i: int, team: Team, now: Now) -> bool:
    return stands_level(
        i, team.kinds, team.params, team.tuning, now.seen, team.course, team.first, now.leg, now.pace, now.reference
    )


@lean_kernel
def _wait(i: int, holder: int, time: float, dt: float, lost: float, now: Now, waits: Floats, counts: Ints) -> None:
    """Note that robot i was kept back by another in this step."""
    k = now.waiting[i]
    if k < 0 or waits[k, 1] != holder or time > waits[k, 3] + _JOINED:
        k = counts[WAITS]
        counts[WAITS] = k + 1
        now.waiting[i] = k
        waits[k, 0], waits[k, 1], waits[k, 2], waits[k, 4] = i, holder, time, 0.0
    waits[k, 3] = time + dt
    waits[k, 4] += lost


@lean_kernel
def record(time: float, now: Now, team: Team, rows: Rows, counts: Ints) -> None:
    """Write this instant into the next row."""
    k = counts[ROWS]
    counts[ROWS] = k + 1
    rows.times[k] = time
    for i in range(len(team.kinds)):
        for c in range(3):
            rows.poses[k, i, c] = now.state[i, c]
        rows.progress[k, i] = now.progress[i]
        rows.reference[k, i] = now.reference[i]
        rows.stray[k, i] = _stray(i, team, now)


@lean_kernel
def _stray(i: int, team: Team, now: Now) -> float:
    """Distance of robot i from where its progress says that it is."""
    x, y = _planned(team, now.behind[i], team.first[i + 1] - 1, now.progress[i])
    return float(np.sqrt((now.state[i, 0] - x) ** 2 + (now.state[i, 1] - y) ** 2))
