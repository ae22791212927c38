"""The closed loop: all robots of a team, step by step, from what they may do to what they have done.

In a step every robot is told how far its reference may go (coordination), moves its reference, takes a command from
its controller, moves, and finds how far along its plan it has come; then all are measured. Two plan times belong to a
robot: its reference, where its controller aims, and its progress, the plan time at the nearest point of its path up to
there. Others give way to progress; so they are safe however far a robot lags, and only its distance from its path,
the stray, has to be covered by a margin.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from taut.control._coordination_kernels import Pending, Waits, bounds
from taut.control._course_kernels import LENGTH, TO_X, TO_Y, TOLERANCE, slow_speed, turning_radius, turning_seconds
from taut.control._following_kernels import advance, command, stands_level
from taut.simulation._nearness_kernels import deepest_inside, greatest, list_pairs, nearest_passing, nearest_shape
from taut.simulation._vehicle_kernels import ACKERMANN, DIFFERENTIAL, INTEGRATOR, move
from taut.team._lean import lean_kernel

Floats = NDArray[np.float64]
Ints = NDArray[np.int64]

GOING, ENDED, STUCK, PAIRS_FULL, EVENTS_FULL, ROWS_FULL = range(6)
STEP, PAIRS, COLLISIONS, WAITS, ROWS = range(5)  # what the counters count

ROLLING = 0.02 * 9.81  # joules per kilogram and metre: hard wheels on a hall's floor
SLIP_SECONDS = 0.5
_JOINED = 1.0  # seconds after which waiting for the same robot again is another wait
_PATIENCE = 10.0  # seconds without any progress, and time to turn once round, after which there will be none
_CREEP = 1e-6  # plan seconds a second: less is no progress


class Team(NamedTuple):
    """What the robots are and what they plan to do; stamps of robot i are ``stamps[first[i]:first[i + 1]]``.

    kinds, params, tuning, course: see `taut.control._course_kernels`. drift (n,): ground speed as a share of what
    the wheels make of it. dies (n,): seconds.
    """

    kinds: Ints
    params: Floats
    tuning: Floats
    course: Floats
    radii: Floats
    stamps: Floats
    first: Ints
    leaves: NDArray[np.bool_]
    drift: Floats
    dies: Floats


class Ground(NamedTuple):
    """Sides of the obstacles and the wall, and a grid over them, see `nearest_shape` and `deepest_inside`."""

    edges: Floats
    owner: Ints
    reach: Floats
    rings: Ints
    solid: Ints
    first: Ints
    sides: Ints
    x0: float
    y0: float
    size: float
    columns: int
    rows: int


class Chance(NamedTuple):
    """Numbers of `taut.simulation.Disturbances`, the seed, and how much of a way robots take their wheels to err."""

    seed: int
    odometry: float
    stops: float
    stop_seconds: float
    position_noise: float
    heading_noise: float
    slip: float


class Now(NamedTuple):
    """Where the robots stand; written at every step.

    state, seen (n, 6): as it is, and as the robot believes. unsure (n, 2): variances of the believed place, each axis,
    and heading. progress, reference (n,). leg, behind (n,): stamps at which
    the legs of the reference and of the progress begin. bound, held_by (n,): how far the reference may go, and because
    of whom. halts (n, 3): begin and end of the next random stop, and how many there were. command (2,): for one robot.
    waiting (n,): open wait. arrived, gone (n,): seconds; inf if not yet. idle (2,): seconds without progress, and the
    sum of all progress when there was some.
    """

    state: Floats
    seen: Floats
    unsure: Floats
    progress: Floats
    reference: Floats
    leg: Ints
    behind: Ints
    bound: Floats
    held_by: Ints
    halts: Floats
    pace: Floats
    trim: Floats
    command: Floats
    slip: Floats
    waiting: Ints
    arrived: Floats
    gone: Floats
    idle: Floats


class Tally(NamedTuple):
    """What has been measured.

    done (n, 5): metres, radians turned, joules per kilogram, sum of squared strays, number of strays. worst (n, 4):
    greatest stray, when, where. clear, apart (n, 5): least distance from shapes and robots, when, where, from which.
    measured (n, 2): distance from the shapes at a measurement, metres moved since. inside (n,): whether the centre may
    lie inside a shape. hitting (n,): while shapes are touched the first collision of this time, else −1.
    """

    done: Floats
    worst: Floats
    clear: Floats
    apart: Floats
    measured: Floats
    inside: NDArray[np.bool_]
    hitting: Ints


class Near(NamedTuple):
    """Pairs of robots that may come near: pairs (P, 3) with the collision that lasts, and a grid to list them by."""

    pairs: Ints
    heads: Ints
    follows: Ints
    reach: float
    skin: float
    most_radius: float
    size: float
    columns: int
    rows: int
    before: Floats
    moved: Floats


class Rows(NamedTuple):
    """Records of the instants that are kept: (k,) times, (k, n, 3) poses, (k, n) progress, reference and stray."""

    times: Floats
    poses: Floats
    progress: Floats
    reference: Floats
    stray: Floats


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
def grip(i: int, time: float, chance: Chance, team: Team, now: Now) -> None:
    """Write what the ground makes of robot i's wheels now."""
    for wheel in range(2):
        # what is wrong with the wheels is wrong with both; other vehicles only drive faster than they believe
        now.slip[i, wheel] = team.drift[i] if wheel == 0 or team.kinds[i] == DIFFERENTIAL else 1.0
        if chance.slip > 0.0:
            now.slip[i, wheel] *= 1.0 + chance.slip * normal(chance.seed, i, int(time / SLIP_SECONDS), 8 + 2 * wheel)


@lean_kernel
def work(kind: int, radius: float, v0: float, w0: float, v1: float, w1: float, dt: float) -> float:
    """Joules per kilogram of a step: gain of kinetic energy, of which braking gives nothing back, and rolling."""
    if kind == INTEGRATOR:
        v0, v1 = np.sqrt(v0 * v0 + w0 * w0), np.sqrt(v1 * v1 + w1 * w1)
        w0 = w1 = 0.0
    gain = 0.5 * (v1 * v1 - v0 * v0) + 0.25 * radius * radius * (w1 * w1 - w0 * w0)
    return max(gain, 0.0) + ROLLING * 0.5 * (abs(v0) + abs(v1)) * dt


@lean_kernel
def _measure_stray(i: int, time: float, team: Team, now: Now, tally: Tally) -> None:
    stray = _stray(i, team, now)
    tally.done[i, 3] += stray * stray
    tally.done[i, 4] += 1.0
    if stray > tally.worst[i, 0]:
        tally.worst[i, 0], tally.worst[i, 1] = stray, time
        tally.worst[i, 2], tally.worst[i, 3] = now.state[i, 0], now.state[i, 1]


@lean_kernel
def hashed(seed: int, a: int, b: int, c: int) -> float:
    """A number in (0, 1) that looks random, the same for the same four numbers (SplitMix64, Steele et al. 2014)."""
    word = np.uint64(seed)
    for part in (a, b, c):
        word = (word ^ np.uint64(part)) + np.uint64(0x9E3779B97F4A7C15)
        word = (word ^ (word >> np.uint64(30))) * np.uint64(0xBF58476D1CE4E5B9)
        word = (word ^ (word >> np.uint64(27))) * np.uint64(0x94D049BB133111EB)
        word = word ^ (word >> np.uint64(31))
    return (float(word >> np.uint64(11)) + 0.5) * 2.0**-53


@lean_kernel
def normal(seed: int, a: int, b: int, c: int) -> float:
    """A standard normal number from `hashed` (Box and Muller); c and c + 1 are used."""
    size = np.sqrt(-2.0 * np.log(hashed(seed, a, b, c)))
    return float(size * np.cos(2.0 * np.pi * hashed(seed, a, b, c + 1)))


@lean_kernel
def perceive(i: int, step: int, dt: float, chance: Chance, team: Team, now: Now) -> None:
    """What robot i believes of its pose: a Kalman filter of what its wheels have done and of noisy fixes.

    Wheels count without slip. The filter takes them to err by a share ``odometry`` for `SLIP_SECONDS` at a time, which
    is a random walk with that share squared times `SLIP_SECONDS` as its variance, for a way of a metre in a second. A
    fix without noise is believed.
    """
    state, seen, unsure = now.state, now.seen, now.unsure
    place_noise, heading_noise = chance.position_noise**2, chance.heading_noise**2
    if place_noise == 0.0 and heading_noise == 0.0:
        for k in range(6):
            seen[i, k] = state[i, k]
        return
    now.slip[i, 0] = now.slip[i, 1] = 1.0
    move(i, team.kinds, team.params, seen, now.command, now.slip, dt)
    speed_squared, turn_squared = seen[i, 3] ** 2, seen[i, 4] ** 2
    if team.kinds[i] == INTEGRATOR:
        speed_squared, turn_squared = speed_squared + turn_squared, 0.0
    elif team.kinds[i] == DIFFERENTIAL:
        turn_squared += 2.0 * speed_squared / team.params[i, 5] ** 2  # wheels that err apart turn it
    if step == 1:
        unsure[i, 0], unsure[i, 1] = place_noise, heading_noise
    lasting = SLIP_SECONDS * dt
    unsure[i, 1] += lasting * chance.odometry**2 * turn_squared
    share = unsure[i, 1] / (unsure[i, 1] + heading_noise) if heading_noise > 0.0 else 1.0
    fix = state[i, 2] + chance.heading_noise * normal(chance.seed, i, step, 4)
    seen[i, 2] = (1.0 - share) * seen[i, 2] + share * fix
    unsure[i, 1] *= 1.0 - share
    # a heading that is believed leads the way that is counted astray
    unsure[i, 0] += lasting * (chance.odometry**2 + unsure[i, 1]) * speed_squared
    share = unsure[i, 0] / (unsure[i, 0] + place_noise) if place_noise > 0.0 else 1.0
    for axis in range(2):
        fix = state[i, axis] + chance.position_noise * normal(chance.seed, i, step, 2 * axis)
        seen[i, axis] = (1.0 - share) * seen[i, axis] + share * fix
    unsure[i, 0] *= 1.0 - share


@lean_kernel
def halted(i: int, time: float, chance: Chance, now: Now) -> bool:
    """Whether robot i is in a random stop; draws the next one when one is over."""
    if chance.stops <= 0.0:
        return False
    halts = now.halts
    while time >= halts[i, 1]:
        k = int(halts[i, 2])
        halts[i, 2] += 1.0
        halts[i, 0] = halts[i, 1] - np.log(hashed(chance.seed, i, k, 6)) / chance.stops
        halts[i, 1] = halts[i, 0] - np.log(hashed(chance.seed, i, k, 7)) * chance.stop_seconds
    return bool(time >= halts[i, 0])


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
def measure_ground(
    i: int, ax: float, ay: float, time: float, tol: float, team: Team, ground: Ground, now: Now, tally: Tally,
    collisions: Floats, counts: Ints,
) -> None:  # fmt: skip
    """Note how near robot i has come to the shapes while it moved from a to where it is."""
    bx, by = now.state[i, 0], now.state[i, 1]
    radius, clear, measured = team.radii[i], tally.clear, tally.measured
    measured[i, 1] += np.sqrt((bx - ax) ** 2 + (by - ay) ** 2)
    within = max(clear[i, 0] + radius, radius)
    if measured[i, 0] - measured[i, 1] > within:
        return
    found, shape = nearest_shape(
        ax, ay, bx, by, 2.0 * within, ground.edges, ground.owner, ground.reach, ground.first, ground.sides,
        ground.x0, ground.y0, ground.size, ground.columns, ground.rows,
    )  # fmt: skip
    if tally.inside[i] or found <= tol:
        deep, around = deepest_inside(bx, by, ground.edges, ground.rings, ground.solid, ground.reach)
        tally.inside[i] = around >= 0
        if deep < found:
            found, shape = deep, around
    # the distance is that of the motion; its end is as near or farther
    measured[i, 0], measured[i, 1] = found, 0.0
    distance = found - radius
    if shape >= 0 and distance < clear[i, 0]:
        clear[i, 0], clear[i, 1], clear[i, 2], clear[i, 3], clear[i, 4] = distance, time, bx, by, shape
    if shape < 0 or distance >= -tol:
        tally.hitting[i] = -1
        return
    if tally.hitting[i] < 0:
        tally.hitting[i] = counts[COLLISIONS]
    for k in range(tally.hitting[i], counts[COLLISIONS]):
        if collisions[k, 0] == i and collisions[k, 1] == -1 - shape:
            collisions[k, 5] = max(collisions[k, 5], -distance)
            return
    _collide(collisions, counts, i, -1 - shape, time, bx, by, -distance)


@lean_kernel
def _collide(
    collisions: Floats, counts: Ints, robot: int, other: int, time: float, x: float, y: float, depth: float
) -> int:
    """Note a new collision; ``other`` is a robot, or −1 − a shape."""
    k = counts[COLLISIONS]
    counts[COLLISIONS] = k + 1
    collisions[k, 0], collisions[k, 1], collisions[k, 2] = robot, other, time
    collisions[k, 3], collisions[k, 4], collisions[k, 5] = x, y, depth
    return int(k)


@lean_kernel
def measure_pairs(
    time: float, dt: float, tol: float, team: Team, now: Now, tally: Tally, near: Near, collisions: Floats, counts: Ints
) -> None:
    """Note how near robots have come to each other in the step that begins at a time, as if they moved evenly."""
    state, before, apart, pairs = now.state, near.before, tally.apart, near.pairs
    for p in range(counts[PAIRS]):
        i, j = pairs[p, 0], pairs[p, 1]
        if now.gone[i] <= time or now.gone[j] <= time:
            continue
        ax, ay = before[j, 0] - before[i, 0], before[j, 1] - before[i, 1]
        bx, by = state[j, 0] - state[i, 0], state[j, 1] - state[i, 1]
        touch = team.radii[i] + team.radii[j]
        least = max(apart[i, 0], apart[j, 0], 0.0) + touch
        longest = abs(bx - ax) + abs(by - ay)
        if bx * bx + by * by > (least + longest) ** 2:
            continue
        distance, s = nearest_passing(ax, ay, bx, by)
        distance -= touch
        xi, yi = (1.0 - s) * before[i, 0] + s * state[i, 0], (1.0 - s) * before[i, 1] + s * state[i, 1]
        xj, yj = (1.0 - s) * before[j, 0] + s * state[j, 0], (1.0 - s) * before[j, 1] + s * state[j, 1]
        when = time + s * dt
        if distance < apart[i, 0]:
            apart[i, 0], apart[i, 1], apart[i, 2], apart[i, 3], apart[i, 4] = distance, when, xi, yi, j
        if distance < apart[j, 0]:
            apart[j, 0], apart[j, 1], apart[j, 2], apart[j, 3], apart[j, 4] = distance, when, xj, yj, i
        if distance >= -tol:
            pairs[p, 2] = -1
        elif pairs[p, 2] < 0:
            pairs[p, 2] = _collide(collisions, counts, i, j, when, (xi + xj) / 2, (yi + yj) / 2, -distance)
        else:
            collisions[pairs[p, 2], 5] = max(collisions[pairs[p, 2], 5], -distance)


@lean_kernel
def list_near(time: float, ground: Ground, team: Team, now: Now, near: Near, collisions: Floats, counts: Ints) -> bool:
    """List anew who may come near whom; a collision that lasts stays the same one. False if there is no room."""
    for i in range(len(near.moved)):
        near.moved[i] = 0.0
    count = list_pairs(
        now.state, now.gone, time, team.radii, near.reach + near.skin, near.most_radius,
        ground.x0, ground.y0, near.size, near.columns, near.rows, near.heads, near.follows, near.pairs,
    )  # fmt: skip
    if count < 0:
        return False
    counts[PAIRS] = count
    for p in range(count):
        i, j = near.pairs[p, 0], near.pairs[p, 1]
        dx, dy = now.state[j, 0] - now.state[i, 0], now.state[j, 1] - now.state[i, 1]
        if dx * dx + dy * dy < (team.radii[i] + team.radii[j]) ** 2:
            for k in range(counts[COLLISIONS] - 1, -1, -1):
                if collisions[k, 0] == i and collisions[k, 1] == j:
                    near.pairs[p, 2] = k
                    break
    return True


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
