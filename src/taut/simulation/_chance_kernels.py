"""Slip, random stops and noise, drawn by hashing; and what a robot believes of its pose."""

from __future__ import annotations

import numpy as np

from taut.simulation._loop_state import Chance, Now, Team
from taut.simulation._vehicle_kernels import DIFFERENTIAL, INTEGRATOR, move
from taut.team._lean import lean_kernel

SLIP_SECONDS = 0.5


@lean_kernel
def grip(i: int, time: float, chance: Chance, team: Team, now: Now) -> None:
    """Write what the ground makes of robot i's wheels now."""
    for wheel in range(2):
        # what is wrong with the wheels is wrong with both; other vehicles only drive faster than they believe
        now.slip[i, wheel] = team.drift[i] if wheel == 0 or team.kinds[i] == DIFFERENTIAL else 1.0
        if chance.slip > 0.0:
            now.slip[i, wheel] *= 1.0 + chance.slip * normal(chance.seed, i, int(time / SLIP_SECONDS), 8 + 2 * wheel)


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
