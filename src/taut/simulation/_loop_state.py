"""What the kernels of a closed loop share: the team, the ground, chance, where robots stand, and what was measured."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]
Ints = NDArray[np.int64]

GOING, ENDED, STUCK, PAIRS_FULL, EVENTS_FULL, ROWS_FULL = range(6)  # why the kernels return
STEP, PAIRS, COLLISIONS, WAITS, ROWS = range(5)  # what the counters count


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
