"""From a plan to the arrays of the loop, and the loop itself with room for what happens."""

from __future__ import annotations

import math
import threading
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from taut.certificate._kernels import FILLED, OPEN, OUTSIDE
from taut.certificate.clearance import shapes_of
from taut.control._course_kernels import COLUMNS, TO_X, TO_Y, lay_courses
from taut.control.coordination import Dependencies, dependencies, pending
from taut.control.tracking import Tracking, tuning
from taut.motion import Plan
from taut.scene import FloatArray, Scene
from taut.simulation._loop_kernels import record, run_steps
from taut.simulation._loop_state import (
    COLLISIONS,
    EVENTS_FULL,
    GOING,
    PAIRS,
    PAIRS_FULL,
    ROWS,
    ROWS_FULL,
    STEP,
    WAITS,
    Chance,
    Ground,
    Near,
    Now,
    Rows,
    Tally,
    Team,
)
from taut.simulation._nearness_kernels import sides_of_cells
from taut.simulation.disturbances import Disturbances, fate_of
from taut.simulation.vehicles import Vehicle, tables

_MOST_CELLS = 256  # of a row or column of a grid
_RECORDED_AT_ONCE = 2**16  # poses
_EVENTS = 256  # for which there is room at first, and the next for pairs a robot
_PAIRS = 8
_PIECE = 2**16  # steps of single robots that the loop does at once: a tenth of a second, in which nothing stops it
_SOLID = {FILLED: 1, OPEN: 0, OUTSIDE: -1}
_UNTRUSTED = 0.05  # of its way: the least by which a robot takes its wheels to err


@dataclass(frozen=True, eq=False)
class Setting:
    """All that the runs of one plan with the same vehicles have in common.

    Parameters
    ----------
    plan, names : the plan and its robots.
    team : the robots, nothing wrong with them.
    headings : (n,) radians at the start: along the first move.
    ground : obstacles and wall.
    shapes : their names.
    waits : who waits for whom.
    dt : seconds of a step.
    tol : metres that discs may overlap without a collision: the scene's.
    reach : metres between two robots up to which they are watched.
    """

    plan: Plan
    names: tuple[str, ...]
    team: Team
    headings: FloatArray
    ground: Ground
    shapes: tuple[str, ...]
    waits: Dependencies
    dt: float
    tol: float
    reach: float


@dataclass(frozen=True, eq=False)
class Driven:
    """How a run went, in the arrays of the loop.

    Parameters
    ----------
    status : ENDED or STUCK.
    seconds : that it lasted.
    now, tally : the last state, and what was measured.
    rows : the recorded instants, one array after the other.
    collisions, held : rows as `_collide` and `_wait` of the kernels write them.
    """

    status: int
    seconds: float
    now: Now
    tally: Tally
    rows: Rows
    collisions: FloatArray
    held: FloatArray


Watching = Callable[[float, Now], None]
"""Is shown the time and the team at every recorded instant, before the robots drive on."""


def setting_of(
    plan: Plan, vehicles: Sequence[Vehicle], trackings: Sequence[Tracking], dt: float, waits: Dependencies
) -> Setting:
    """Lay out a plan for the loop; `nobody_waits` gives waits for a team that does not look after each other."""
    scene = plan.scene
    own = [path.stamps[: int(np.searchsorted(path.times, path.arrival)) + 1] for path in plan.trajectories]
    first = np.concatenate([[0], np.cumsum([len(s) for s in own])]).astype(np.int64)
    stamps = np.ascontiguousarray(np.concatenate(own)) if own else np.empty((0, 3))
    kinds, params = tables(vehicles)
    tuned = tuning(trackings)
    course = np.zeros((len(stamps), COLUMNS))
    lay_courses(stamps, first, kinds, params, tuned, course)
    n = len(own)
    radii = np.array([robot.radius for robot in scene.robots], dtype=np.float64)
    leaves = np.array([not scene.stays(robot) for robot in scene.robots], dtype=np.bool_)
    team = Team(kinds, params, tuned, course, radii, stamps, first, leaves, np.ones(n), np.full(n, np.inf))
    begin = course[first[:-1]]
    ground, shapes = ground_of(scene)
    return Setting(
        plan,
        tuple(robot.name for robot in scene.robots),
        team,
        np.arctan2(begin[:, TO_Y], begin[:, TO_X]),
        ground,
        shapes,
        waits,
        dt,
        scene.tol,
        watched_within(scene, team),
    )


def ground_of(scene: Scene) -> tuple[Ground, tuple[str, ...]]:
    """Lay out obstacles and wall for the loop; returns their names, too."""
    shapes = shapes_of(scene)
    edges = np.ascontiguousarray(shapes.edges)
    x0, y0, size, columns, rows = grid_over(edges, max(len(edges), 16))
    cells, sides = sides_of_cells(edges, x0, y0, size, columns, rows)
    solid = np.array([_SOLID[kind] for kind in shapes.kind.tolist()], dtype=np.int64)
    ground = Ground(edges, shapes.owner, shapes.radius, shapes.first, solid, cells, sides, x0, y0, size, columns, rows)
    return ground, shapes.names


def watched_within(scene: Scene, team: Team) -> float:
    """Metres between two robots up to which they are watched."""
    fastest = max((float(row[0]) for row in team.params), default=1.0)
    return max(4.0 * float(team.radii.max(initial=0.0)), 2.0 * scene.gap, 0.5 * fastest)


def nobody_waits(plan: Plan) -> Dependencies:
    """Dependencies of a team in which everybody keeps to the clock, whoever is late."""
    n = len(plan.trajectories)
    alone = Plan(replace(plan.scene, robots=()), ())
    none = dependencies(alone)
    names = tuple(robot.name for robot in plan.scene.robots)
    arrivals = np.array([path.arrival for path in plan.trajectories], dtype=np.float64)
    return Dependencies(names, arrivals, none.waits._replace(start=np.zeros(n + 1, dtype=np.int64)))


def drive(
    setting: Setting,
    disturbances: Disturbances,
    seed: int,
    until: float,
    stride: int,
    watch: Watching | None = None,
    given_up: threading.Event | None = None,
) -> Driven:
    """Let the team drive until all have arrived, nobody goes on, or the time ``until`` is over.

    Every ``stride``-th instant is recorded (none if 0) and shown to ``watch``. Safe to call on several threads. Ends
    with a KeyboardInterrupt soon after ``given_up`` is set.
    """
    n = len(setting.names)
    team, chance = disturbed(setting.plan.scene, setting.team, disturbances, seed)
    now, tally = standing(team, setting.headings), unmeasured(n)
    near = nearness(setting.team, setting.ground, setting.reach, setting.dt, 1.0 + disturbances.speed_error)
    todo = pending(setting.waits)
    counts = nothing_counted()
    collisions, held = room_for_collisions(near), np.empty((n + _EVENTS, 5))
    kept: list[Rows] = []
    many = 1 + _RECORDED_AT_ONCE // max(n, 1)
    rows = _rows(1 if watch else many if stride else 0, n)
    shown, piece = -1, 1 + _PIECE // max(n, 1)
    while True:
        if given_up is not None and given_up.is_set():
            raise KeyboardInterrupt
        if watch is not None and stride and counts[STEP] % stride == 0 and counts[STEP] > shown:
            shown = int(counts[STEP])
            watch(shown * setting.dt, now)
        status = run_steps(
            setting.dt, piece, stride, until, setting.tol, chance, team, setting.ground, setting.waits.waits, todo,
            now, tally, near, rows, collisions, held, counts,
        )  # fmt: skip
        if status == GOING:
            continue
        if status == ROWS_FULL:
            kept.append(_copied(rows, counts[ROWS]))
            counts[ROWS] = 0
        elif status == EVENTS_FULL:
            collisions, held = more_events(collisions, counts[PAIRS]), more_events(held, 0)
        elif status == PAIRS_FULL:
            near = more_pairs(near, counts)
        else:
            break
    seconds = float(counts[STEP] * setting.dt)
    if stride and (not counts[ROWS] or rows.times[counts[ROWS] - 1] < seconds):
        kept.append(_copied(rows, counts[ROWS]))
        counts[ROWS] = 0
        record(seconds, now, team, rows, counts)
    kept.append(_copied(rows, counts[ROWS]))
    recorded = Rows(*(np.concatenate(parts) for parts in zip(*kept, strict=True)))
    return Driven(status, seconds, now, tally, recorded, collisions[: counts[COLLISIONS]], held[: counts[WAITS]])


def grid_over(edges: FloatArray, cells: int) -> tuple[float, float, float, int, int]:
    """Corner, size of a cell, columns and rows of a grid over sides, with about so many cells."""
    x = np.concatenate([edges[:, 0], edges[:, 2]])
    y = np.concatenate([edges[:, 1], edges[:, 3]])
    width, height = float(np.ptp(x)), float(np.ptp(y))
    size = max(np.sqrt(width * height / cells), max(width, height) / _MOST_CELLS)
    return float(x.min()), float(y.min()), float(size), int(width / size) + 1, int(height / size) + 1


def disturbed(scene: Scene, team: Team, disturbances: Disturbances, seed: int) -> tuple[Team, Chance]:
    """Return the team that meets these disturbances, and what is left to chance in every step."""
    fate = fate_of(scene, disturbances, seed)
    params = team.params.copy()
    params[:, 0] *= fate.reach
    # what the wheels err by in a run, of which the robots know the size alone
    odometry = math.hypot(_UNTRUSTED, disturbances.slip, disturbances.speed_error / math.sqrt(3.0))
    chance = Chance(
        seed,
        odometry,
        disturbances.stops,
        disturbances.stop_seconds,
        disturbances.position_noise,
        disturbances.heading_noise,
        disturbances.slip,
    )
    return team._replace(params=params, drift=fate.drift, dies=fate.dies), chance


def nearness(team: Team, ground: Ground, reach: float, dt: float, faster: float) -> Near:
    """Room for pairs of robots that come near while none drives faster than ``faster`` times its top speed."""
    n = len(team.kinds)
    most = float(team.radii.max(initial=0.0))
    fastest = max((float(row[0]) for row in team.params), default=1.0) * faster
    skin = max(reach / 2, 20.0 * fastest * dt)
    width, height = (ground.size * count for count in (ground.columns, ground.rows))
    size = max(reach + skin + 2.0 * most, max(width, height) / _MOST_CELLS)
    columns, rows = int(width / size) + 1, int(height / size) + 1
    return Near(
        np.empty((_PAIRS * n, 3), dtype=np.int64),
        np.empty(columns * rows, dtype=np.int64),
        np.empty(n, dtype=np.int64),
        reach,
        skin,
        most,
        size,
        columns,
        rows,
        np.zeros((n, 2)),
        np.zeros(n),
    )


def standing(team: Team, headings: FloatArray) -> Now:
    """Robots at their starts, at rest."""
    n, first = len(team.kinds), team.first
    state = np.zeros((n, 6))
    state[:, :2] = team.stamps[first[:-1], 1:]
    state[:, 2] = headings
    arrived = np.where(np.diff(first) == 1, 0.0, np.inf)
    return Now(
        state=state,
        seen=state.copy(),
        unsure=np.zeros((n, 2)),
        progress=np.zeros(n),
        reference=np.zeros(n),
        leg=first[:-1].copy(),
        behind=first[:-1].copy(),
        bound=np.full(n, np.inf),
        held_by=np.full(n, -1, dtype=np.int64),
        halts=np.zeros((n, 3)),
        pace=np.zeros(n),
        trim=np.zeros(n),
        command=np.zeros((n, 2)),
        slip=np.ones((n, 2)),
        waiting=np.full(n, -1, dtype=np.int64),
        arrived=arrived,
        gone=np.where(team.leaves, arrived, np.inf),
        idle=np.zeros(2),
    )


def unmeasured(n: int) -> Tally:
    """Nothing measured yet, of n robots."""
    clear, apart = np.zeros((n, 5)), np.zeros((n, 5))
    clear[:, 0] = apart[:, 0] = np.inf
    clear[:, 4] = apart[:, 4] = -1
    return Tally(
        done=np.zeros((n, 5)),
        worst=np.zeros((n, 4)),
        clear=clear,
        apart=apart,
        measured=np.zeros((n, 2)),
        inside=np.ones(n, dtype=np.bool_),
        hitting=np.full(n, -1, dtype=np.int64),
    )


def nothing_counted() -> NDArray[np.int64]:
    """Counters at the beginning; the pairs have to be listed."""
    return np.array([0, -1, 0, 0, 0], dtype=np.int64)


def room_for_collisions(near: Near) -> FloatArray:
    """Room for so many that the loop can begin."""
    return np.empty((len(near.pairs) + len(near.moved) + _EVENTS, 6))


def more_events(events: FloatArray, more: int) -> FloatArray:
    """Twice the room for events, and ``more``."""
    return np.concatenate([events, np.empty((len(events) + max(more, 0), events.shape[1]))])


def more_pairs(near: Near, counts: NDArray[np.int64]) -> Near:
    """Twice the room for pairs, which are to be listed anew."""
    counts[PAIRS] = -1
    return near._replace(pairs=np.empty((2 * len(near.pairs) + 1, 3), dtype=np.int64))


def _rows(count: int, n: int) -> Rows:
    return Rows(
        np.empty(count), np.empty((count, n, 3)), np.empty((count, n)), np.empty((count, n)), np.empty((count, n))
    )


def _copied(rows: Rows, count: int) -> Rows:
    return Rows(*(part[:count].copy() for part in rows))
