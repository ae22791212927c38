"""One robot among others: its earliest arrival by safe-interval search, or why there is none."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from taut.motion import Trajectory
from taut.scene import Scene
from taut.team import _search_kernels
from taut.team._conflict_kernels import Floats, Ints
from taut.team._contact_kernels import Partners
from taut.team._search_kernels import EXACT, TOO_SMALL, Desk
from taut.team._table_kernels import Table
from taut.team._team_kernels import Team
from taut.team.reservations import distances_from, empty_table, legs_of, reserve
from taut.team.team_arrays import team_of
from taut.team.world import World

WITHOUT_END = 1 << 60
_STATES = 1 << 16
_WAYS = 1 << 17
_LONGEST = 1 << 12  # vertices of a motion
_STRETCHES = 1 << 10  # forbidden times of a place


@dataclass(frozen=True)
class Failure:
    """A robot that found no way, with where and when it got no further and who was in its way."""

    robot: int
    place: tuple[float, float]
    time: float
    blockers: tuple[int, ...]


@dataclass
class Bench:
    """What planning one robot after another works on; the table and the desk are replaced where they are too small.

    Parameters
    ----------
    scene, team : the robots and their roadmaps.
    table : what is reserved.
    desk : what a search writes into.
    partners : robots in contact with which the next one has to stay; None if it need not.
    """

    scene: Scene
    team: Team
    table: Table
    desk: Desk
    partners: Partners | None = None


def bench_of(world: World) -> Bench:
    """Return a bench on which nothing is reserved yet."""
    team, table = team_of(world), empty_table(world.scene, world.cell, world.horizon)
    return Bench(world.scene, team, table, empty_desk(team, len(table.robot)))


def plan_robot(bench: Bench, i: int, most: int = WITHOUT_END, limit: float = math.inf) -> Trajectory | Failure:
    """Earliest arrival of one robot among what others have reserved, on its roadmap; what it finds is not reserved.

    A robot that is at its goal already stays, or is gone at once; it moves only if it has to let somebody pass.

    Parameters
    ----------
    most : expansions after which it is given up.
    limit : seconds; it is to arrive no later.
    """
    if len(bench.desk.stamp) < len(bench.table.robot):
        bench.desk = with_stamps(bench.desk, bench.table)
    while True:
        count = _search_kernels.soonest_arrival(
            bench.team, i, bench.table, bench.partners, bench.desk, limit, most, EXACT
        )
        if count > 0:
            return Trajectory(bench.scene.robots[i].name, bench.desk.stamps[:count])
        if count != TOO_SMALL:
            x, y, when = bench.desk.stuck[:3].tolist()
            return Failure(i, (x, y), when, _in_the_way(bench, i, (x, y), when))
        bench.desk = roomier_desk(bench.team, bench.desk)


def hold_start(bench: Bench, i: int, until: float) -> None:
    """Reserve a robot's start from 0 to the given time, and nothing else of what it had."""
    x, y = bench.scene.robots[i].start
    bench.table = reserve(bench.table, i, bench.scene.robots[i].radius, np.array([[x, y, 0.0, x, y, until]]))


def take(bench: Bench, i: int, trajectory: Trajectory) -> None:
    """Reserve a robot's motion instead of what it had."""
    robot = bench.scene.robots[i]
    bench.table = reserve(bench.table, i, robot.radius, legs_of(trajectory, bench.scene.stays(robot)))


def empty_desk(team: Team, legs: int, states: int = _STATES, ways: int = _WAYS, longest: int = _LONGEST) -> Desk:
    """Return a desk for this team and a table of so many legs."""
    most = int(team.size.max() + np.diff(team.own_first).max())
    return Desk(
        xy=team.xy.copy(),
        away=np.full(most, math.inf),
        row=_nowhere(most),
        first=_nowhere(most),
        many=np.zeros(most, dtype=np.int64),
        times=np.empty((states, 5)),
        links=np.empty((states, 3), dtype=np.int64),
        ways=np.empty((ways, 3), dtype=np.int64),
        way_time=np.empty(ways),
        keys=np.empty(ways),
        items=np.empty(ways, dtype=np.int64),
        lo=np.empty(_STRETCHES * states // _STATES),
        hi=np.empty(_STRETCHES * states // _STATES),
        stamp=_nowhere(legs),
        path=np.empty(longest, dtype=np.int64),
        at=np.empty((longest, 4)),
        stamps=np.empty((2 * longest + 1, 3)),
        stuck=np.zeros(4),
        counts=np.zeros(5, dtype=np.int64),
    )


def roomier_desk(team: Team, desk: Desk) -> Desk:
    """Return a desk with twice the room for a search."""
    return empty_desk(team, len(desk.stamp), 2 * len(desk.times), 2 * len(desk.ways), 2 * len(desk.path))


def with_stamps(desk: Desk, table: Table) -> Desk:
    """Return the desk for a table that has grown."""
    return desk._replace(stamp=_nowhere(len(table.robot)))


def stamps_of(points: Floats, arrive: Floats, depart: Floats, speed: float, tol: float) -> Floats:
    """Stamps of a motion along points, without the rests and the bends that only rounding makes."""
    at = np.concatenate([arrive[:, None], depart[:, None], points], axis=1)
    rows = np.empty((2 * len(at) + 1, 3))
    return rows[: _search_kernels.stamped(at, len(at), speed, tol, rows)]


def _nowhere(n: int) -> Ints:
    return np.full(n, -1, dtype=np.int64)


def _in_the_way(bench: Bench, i: int, place: tuple[float, float], when: float) -> tuple[int, ...]:
    """Robots that hold the goal, or that pass where the search got no further, after it got there."""
    scene, robot, table = bench.scene, bench.scene.robots[i], bench.table
    taken = np.flatnonzero((table.robot >= 0) & (table.robot != i))
    legs, robots, radii = table.legs[taken], table.robot[taken], table.radius[taken]
    around = 2 * float(table.frame[2])
    near = []
    for at, since, more in ((place, when, around), (robot.goal, 0.0, 0.0)):
        close = distances_from(legs, np.array(at)) < robot.radius + radii + scene.gap + more
        near += robots[close & (legs[:, 5] >= since)].tolist()
    return tuple(sorted(set(near)))
