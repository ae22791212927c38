"""One step of a team that steers itself: what each vehicle makes of the velocity wanted of it, and what comes of it."""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from taut.simulation._chance_kernels import grip, halted, perceive
from taut.simulation._loop_state import (
    COLLISIONS,
    EVENTS_FULL,
    GOING,
    PAIRS,
    PAIRS_FULL,
    STEP,
    Chance,
    Ground,
    Near,
    Now,
    Tally,
    Team,
)
from taut.simulation._measuring_kernels import list_near, measure_ground, measure_pairs, work
from taut.simulation._nearness_kernels import greatest
from taut.simulation._vehicle_kernels import ACKERMANN, INTEGRATOR, move
from taut.team._lean import lean_kernel

Floats = NDArray[np.float64]
Ints = NDArray[np.int64]
Flags = NDArray[np.bool_]

_WIDER = 2.0  # circles that a truck leaves before it turns back, in circles that it can drive: one shunt is enough
_AHEAD = 4.0  # turning radii beyond which a place might as well be nearer
_BENT = 0.3  # least part of the wanted speed at which a truck drives while it looks elsewhere


class Shunts(NamedTuple):
    """What trucks are at.

    gears (n,): 1 ahead, −1 back. away (n,): whether one drives away from its place to come back better. turn (1,):
    whose turn it is to do so, −1 if nobody does.
    """

    gears: Ints
    away: Flags
    turn: Ints


@lean_kernel
def steer_step(
    dt: float, tol: float, turning: float, chance: Chance, team: Team, ground: Ground, wanted: Floats, ways: Floats,
    shunts: Shunts, now: Now, tally: Tally, near: Near, collisions: Floats, counts: Ints,
) -> int:  # fmt: skip
    """Let every robot drive for dt seconds as near to its wanted velocity as it can, and measure the team.

    ``wanted`` (n, 2) metres a second; ``ways`` (n,) metres to the places where that leads, for trucks; ``turning`` 1/s,
    the turn rate for a radian of error. Returns GOING, or what is full: then nothing has been done, and Python makes
    room and calls again.
    """
    n = len(team.kinds)
    step = counts[STEP]
    time = step * dt
    if counts[COLLISIONS] + max(counts[PAIRS], 0) + n > len(collisions):
        return EVENTS_FULL
    if (counts[PAIRS] < 0 or greatest(near.moved) > 0.4 * near.skin) and not list_near(
        time, ground, team, now, near, collisions, counts
    ):
        return PAIRS_FULL
    for i in range(n):
        x, y, heading = now.state[i, 0], now.state[i, 1], now.state[i, 2]
        v, w = now.state[i, 3], now.state[i, 4]
        near.before[i, 0], near.before[i, 1] = x, y
        if time >= team.dies[i] or halted(i, time, chance, now):
            now.command[i, 0] = now.command[i, 1] = 0.0
            if shunts.turn[0] == i and time >= team.dies[i]:
                shunts.turn[0] = -1
        else:
            _command(i, turning, team, wanted, ways, shunts, now)
        grip(i, time, chance, team, now)
        move(i, team.kinds, team.params, now.state, now.command, now.slip, dt)
        moved = math.hypot(now.state[i, 0] - x, now.state[i, 1] - y)
        near.moved[i] += moved
        tally.done[i, 0] += moved
        tally.done[i, 1] += abs(now.state[i, 2] - heading)
        tally.done[i, 2] += work(team.kinds[i], team.radii[i], v, w, now.state[i, 3], now.state[i, 4], dt)
        perceive(i, step + 1, dt, chance, team, now)
        measure_ground(i, x, y, time + dt, tol, team, ground, now, tally, collisions, counts)
    measure_pairs(time, dt, tol, team, now, tally, near, collisions, counts)
    counts[STEP] = step + 1
    return GOING


@lean_kernel
def _command(i: int, turning: float, team: Team, wanted: Floats, ways: Floats, shunts: Shunts, now: Now) -> None:
    """Write what robot i is to do into its row of the commands: forward speed and turn rate, or a velocity."""
    x, y, heading = wanted[i, 0], wanted[i, 1], now.seen[i, 2]
    if team.kinds[i] == INTEGRATOR:
        now.command[i, 0], now.command[i, 1] = x, y
        return
    ahead, left = x * math.cos(heading) + y * math.sin(heading), y * math.cos(heading) - x * math.sin(heading)
    if team.kinds[i] == ACKERMANN:
        _shunt(i, ahead, left, ways[i], team.params, shunts, now.command)
        return
    # the nearer end is turned to it
    off = math.atan2(left, ahead) if ahead >= 0.0 else math.atan2(-left, -ahead)
    rate = 0.0
    if off != 0.0:
        rate = min(turning * abs(off), math.sqrt(team.params[i, 3] * abs(off)), team.params[i, 1])
    now.command[i, 0], now.command[i, 1] = ahead, math.copysign(rate, off)


@lean_kernel
def _shunt(i: int, ahead: float, left: float, way: float, params: Floats, shunts: Shunts, command: Floats) -> None:
    """Drive truck i on an arc to its place, ahead or back; away from a place within its turning circles, to come back.

    A place at distance d and angle α from the heading lies outside both turning circles if d ≥ 2 r |sin α|. One truck
    at a time drives away, and the next when it has come back: each moves the places of others. Those who wait for
    their turn drive to where they are level with their places.
    """
    gears, away, turn = shunts.gears, shunts.away, shunts.turn
    speed = math.hypot(ahead, left)
    if speed == 0.0:
        command[i, 0] = command[i, 1] = 0.0
        away[i] = False
        if turn[0] == i:
            turn[0] = -1
        return
    radius = params[i, 5] / math.tan(params[i, 6])
    distance = min(way, _AHEAD * radius)
    circle = 2.0 * radius * abs(left) / speed
    if away[i]:
        if distance >= _WIDER * circle:
            away[i], gears[i] = False, -gears[i]
    elif distance >= circle:
        if gears[i] * ahead < -0.5 * speed:
            gears[i] = -gears[i]
    elif turn[0] < 0:
        turn[0], away[i] = i, True
        gears[i] = -1 if ahead >= 0.0 else 1
    else:
        if turn[0] == i:
            turn[0] = -1
        command[i, 0], command[i, 1] = ahead, math.copysign(ahead / radius, ahead * left)
        return
    # the end that is to face the place: the one that drives there, now or later
    end = -gears[i] if away[i] else gears[i]
    off = math.atan2(end * left, end * ahead)
    bend = math.copysign(1.0 / radius, off)
    if not away[i]:
        if abs(off) < 0.5 * math.pi:
            bend = math.copysign(min(2.0 * abs(math.sin(off)) / distance, 1.0 / radius), off)
        speed *= max(math.cos(off), _BENT)
    command[i, 0], command[i, 1] = gears[i] * speed, bend * speed
