"""Planning in contact: robots one after another, each in contact with some before it at every instant.

So the team is connected at every instant, by induction. With k of those before it, it stays so when k − 1 robots fail.
"""

from __future__ import annotations

import math
import time
from collections import Counter
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import TypeAlias

import numpy as np

from taut.errors import NoPath
from taut.motion import Trajectory
from taut.team import _neighbourhood_kernels
from taut.team._conflict_kernels import Floats
from taut.team.gathering import arrangements, between
from taut.team.partners import partners_of
from taut.team.prioritized import Round
from taut.team.reservations import clear
from taut.team.safe_intervals import (
    Bench,
    Failure,
    bench_of,
    empty_desk,
    hold_start,
    plan_robot,
    take,
    with_stamps,
)
from taut.team.team_arrays import team_of
from taut.team.ties import Ties, linked_order, tied
from taut.team.world import World

MOST_ROUNDS = 48
_EXPANSIONS = 40000
_SLOWER, _SLOWEST = 0.7, 0.2
_SAME, _HOLDS = 6, 5  # passes with one hold of starts, and how often that is doubled before it begins anew
_SEQUENCES = 4  # of arrangements on the way that are tried


@dataclass(frozen=True, eq=False)
class Stretch:
    """One stretch of a team's way, from one arrangement to the next; all robots set out when the last has arrived.

    Parameters
    ----------
    world, ties : the team with these starts and goals.
    passed : the pass that was best.
    lost : the robot that the one that failed could not stay in contact with; None if none failed.
    barring : robots that rest for ever on the quickest way of the one that failed.
    slowed : robots planned slower than they can move, and to what share of their speed.
    """

    world: World
    ties: Ties
    passed: Round
    lost: int | None
    barring: tuple[int, ...]
    slowed: Mapping[int, float]

    @property
    def reached(self) -> int:
        """How many robots have a motion."""
        return sum(motion is not None for motion in self.passed.trajectories)

    @property
    def ahead(self) -> list[int]:
        """Robots planned before the one that failed that bar its way, or else that it lost or that passed there."""
        failure = self.passed.failures[0]
        before = self.passed.order[: self.passed.order.index(failure.robot)]
        barring = [j for j in before if j in self.barring]
        return barring or [j for j in before if j == self.lost or j in failure.blockers]


@dataclass(frozen=True, eq=False)
class Together:
    """What planning in contact gives.

    Parameters
    ----------
    stretches : one, or those between the places where the team gathers; the last one planned may have failed.
    passes : how many were done.
    missing : robots that no order of planning reaches, if that is why there is no plan.
    """

    stretches: tuple[Stretch, ...]
    passes: int
    missing: tuple[int, ...] = ()

    @property
    def found(self) -> bool:
        """Whether there is a plan."""
        return bool(self.stretches) and not self.missing and not self.stretches[-1].passed.failures


PlanStretch: TypeAlias = Callable[[World, Ties, float], Together]
"""Plans one stretch of a team's way, in no more passes than given."""


def planned_together(
    world: World, ties: Ties, straight_on: PlanStretch, most: float = math.inf, until: float = math.inf
) -> Together:
    """Plan a team that stays in contact: in one go if an order allows it, else gathering on the way.

    Parameters
    ----------
    straight_on : plans one stretch.
    most : passes at most, on all stretches together.
    until : no other stretch is begun after this time of the monotonic clock, seconds.

    Notes
    -----
    On lanes a team does not gather: places beside them are of no use.
    """
    first = straight_on(world, ties, most)
    if first.found or world.on_lanes:
        return first
    passes, best = first.passes, first
    for tried, places in enumerate(arrangements(world, ties)):
        if tried == _SEQUENCES or passes >= most or time.monotonic() > until:
            break
        found = _by_way_of(world, ties, places, straight_on, most - passes, until)
        passes += found.passes
        if found.found:
            return replace(found, passes=passes)
        best = found if best.missing and found.stretches else best
    return replace(best, passes=passes)


def set_out(world: World, stretches: Sequence[Stretch]) -> list[float]:
    """When the team sets out on each of these stretches, and when it would on the next, seconds."""
    latest = max(robot.start_time for robot in world.scene.robots)
    out = [0.0]
    for stretch in stretches:
        arrivals = [motion.arrival for motion in stretch.passed.trajectories if motion is not None]
        out.append(max(out[-1] + max(arrivals), latest))
    return out


def joined(world: World, stretches: Sequence[Stretch]) -> Round:
    """Return a pass over the whole way; every robot waits where the team gathers until the last is there."""
    robots = world.scene.robots
    rows = [np.array([[0.0, *robot.start]]) for robot in robots]
    for now, stretch in zip(set_out(world, stretches)[:-1], stretches, strict=True):
        motions = [motion for motion in stretch.passed.trajectories if motion is not None]
        for i, motion in enumerate(motions):
            later = motion.stamps + np.array([now, 0.0, 0.0])
            rows[i] = np.concatenate([rows[i], later[later[:, 0] > rows[i][-1, 0]]])
    last = stretches[-1].passed
    if len(stretches) == 1:
        return last
    trajectories = tuple(Trajectory(robot.name, _trimmed(some)) for robot, some in zip(robots, rows, strict=True))
    return Round(last.order, last.hold, trajectories, ())


def follow(
    world: World,
    ties: Ties,
    bench: Bench,
    order: Sequence[int],
    motions: dict[int, Trajectory],
    pace: Mapping[int, float],
    most: float = math.inf,
) -> Failure | None:
    """Plan robots in turn after those that have motions, which are reserved; add theirs.

    Parameters
    ----------
    pace : share of its speed at which a robot moves.
    most : seconds that all may cost together; who would cost more gets no motion.

    Returns
    -------
    Failure | None
        Of the first robot that got no motion; those after it have none either.
    """
    scene, team = world.scene, bench.team
    slower = team.motion.copy()
    for i, share in pace.items():
        slower[i, 0] *= share
    bench.team = team._replace(motion=slower)
    left = most - float(team.least[list(order)].sum())
    failure = None
    for i in order:
        if i in motions:
            continue
        before = [motions[j] for j in order if j in motions]
        need = min(ties.need, len(before))
        bench.partners = partners_of(scene, before, ties.contact, ties.walls, need) if before else None
        limit = scene.robots[i].start_time + float(team.least[i]) + left
        found = plan_robot(bench, i, _EXPANSIONS, limit)
        if isinstance(found, Failure):
            failure = found
            break
        motions[i] = found
        left -= max(found.arrival - scene.robots[i].start_time, 0.0) - float(team.least[i])
        take(bench, i, found)
    bench.team = team
    return failure


def _by_way_of(
    world: World, ties: Ties, places: Sequence[Floats], straight_on: PlanStretch, most: float, until: float
) -> Together:
    """Plan from each arrangement of the team to the next, as far as that gets."""
    stretches: list[Stretch] = []
    passes = 0
    for k in range(len(places) - 1):
        if passes >= most or time.monotonic() > until:
            return Together((), passes)
        scene = between(world.scene, places[k], places[k + 1])
        try:
            part = World(scene, world.way, world.seed)
        except NoPath:  # not even a robot alone gets there
            return Together((), passes)
        found = straight_on(part, tied(scene, ties.contact, ties.need, ties.walls), most - passes)
        passes += found.passes
        stretches += found.stretches
        if not found.found:
            return Together(tuple(stretches), passes, found.missing)
    return Together(tuple(stretches), passes)


def _trimmed(rows: Floats) -> Floats:
    """Stamps without those in the middle or at the end of a rest."""
    still = (rows[1:, 1:] == rows[:-1, 1:]).all(axis=1)
    dropped = np.zeros(len(rows), dtype=bool)
    dropped[1:-1] = still[:-1] & still[1:]
    if len(rows) > 1:
        dropped[-1] = still[-1]
    return np.asarray(rows[~dropped])


# --- Passes over the team ---------------------------------------------------------------------------------------------


@dataclass
class _Tries:
    """What passes have learned: whom to prefer, how often each robot failed, who goes slower."""

    preference: list[int]
    failed: Counter[int]
    pace: dict[int, float]


def passes_in_contact(
    world: World,
    ties: Ties,
    order: Sequence[int],
    rng: np.random.Generator,
    most: float = MOST_ROUNDS,
    until: float = math.inf,
    tell: Callable[[int, Round], None] | None = None,
) -> Together:
    """Passes over the team, for one stretch, until one has no failure.

    A robot that fails is planned earlier next time; or gets places along the way of the robot it lost; or that robot
    goes slower.

    Parameters
    ----------
    order : robots, those to be planned early first.
    most : passes at most.
    until : no pass but the first begins after this time of the monotonic clock, seconds.
    tell : called after each pass.
    """
    tries = _Tries(list(order), Counter(), {})
    bench = bench_of(world)
    best: Stretch | None = None
    number = 0
    while number < most and not (number and time.monotonic() > until):
        linked = linked_order(ties, tries.preference)
        if len(linked) < len(tries.preference):
            return without_order(world, ties, linked, number)
        hold = world.moment * 2.0 ** (number // _SAME % _HOLDS)
        done = pass_in_contact(world, ties, bench, linked, hold, dict(tries.pace))
        number += 1
        if tell is not None:
            tell(number, done.passed)
        if best is None or done.reached > best.reached:
            best = done
        if not done.passed.failures:
            break
        _learn(bench, done, tries, rng)
    assert best is not None
    return Together((best,), number)


def pass_in_contact(
    world: World, ties: Ties, bench: Bench, order: Sequence[int], hold: float, pace: Mapping[int, float]
) -> Stretch:
    """Plan each robot in turn until one fails; the starts of those still to come are held for ``hold`` seconds."""
    clear(bench.table)
    for i in order:
        hold_start(bench, i, world.scene.robots[i].start_time + hold)
    motions: dict[int, Trajectory] = {}
    failure = follow(world, ties, bench, order, motions, pace)
    failures = () if failure is None else (failure,)
    passed = Round(tuple(order), hold, tuple(motions.get(i) for i in range(len(order))), failures)
    if failure is None:
        return Stretch(world, ties, passed, None, (), pace)
    return Stretch(world, ties, passed, _lost(failure, motions), _barring(bench, failure.robot, motions), pace)


def without_order(world: World, ties: Ties, order: Sequence[int], passes: int) -> Together:
    """Return that no order reaches all robots; ``order`` is as far as one goes."""
    count = len(world.scene.robots)
    nothing = Round(tuple(order), 0.0, (None,) * count, ())
    missing = tuple(i for i in range(count) if i not in set(order))
    return Together((Stretch(world, ties, nothing, None, (), {}),), passes, missing)


def _lost(failure: Failure, motions: Mapping[int, Trajectory]) -> int | None:
    """The robot that was nearest when the search got no further."""
    away = {j: math.dist(motion.at(failure.time), failure.place) for j, motion in motions.items()}
    return min(away, key=lambda j: away[j], default=None)


def _barring(bench: Bench, i: int, motions: Mapping[int, Trajectory]) -> tuple[int, ...]:
    if len(bench.desk.stamp) < len(bench.table.robot):
        bench.desk = with_stamps(bench.desk, bench.table)
    met = np.empty(len(bench.scene.robots), dtype=np.int64)
    since = bench.scene.robots[i].start_time
    count = _neighbourhood_kernels.met_on_way(bench.team, i, bench.table, bench.desk, since, math.inf, met)
    return tuple(j for j in met[:count].tolist() if j in motions)


def _learn(bench: Bench, done: Stretch, tries: _Tries, rng: np.random.Generator) -> None:
    """Change what the next pass tries, for the robot that failed."""
    failure, partner = done.passed.failures[0], done.lost
    i = failure.robot
    tries.failed[i] += 1
    what = tries.failed[i] % 4
    if partner is not None:
        motion = done.passed.trajectories[partner]
        if what == 2 and motion is not None and not done.world.on_lanes:
            _add_relays(done.world, bench, i, motion)
        if what == 3:
            tries.pace[partner] = max(tries.pace.get(partner, 1.0) * _SLOWER, _SLOWEST)
    if what == 0:
        tries.preference = [int(j) for j in rng.permutation(tries.preference)]
    before = [j for j in tries.preference if j != i]
    place = min((before.index(j) for j in done.ahead), default=0)
    tries.preference = [*before[:place], i, *before[place:]]


def _add_relays(world: World, bench: Bench, i: int, partner: Trajectory) -> None:
    """Give robot i places where the robot that it lost goes, so that it can follow."""
    points = partner.points
    middles = (points[1:] + points[:-1]) / 2
    world.enrich(i, np.unique(np.concatenate([points, middles]), axis=0))
    bench.team = team_of(world)
    bench.desk = empty_desk(bench.team, len(bench.table.robot))
