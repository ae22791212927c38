"""Repair: a plan improved by large-neighbourhood search, a few robots planned anew at a time.

Source: Li, Chen, Harabor, Stuckey and Koenig, Anytime multi-agent path finding via large neighborhood search,
IJCAI 2021; here in continuous time, for discs, each robot on a roadmap of its own.
"""

from __future__ import annotations

import math
import time
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Literal, NamedTuple, get_args

import numpy as np

from taut.chunks import over_chunks
from taut.interrupts import held_back
from taut.motion import Trajectory
from taut.team import _repair_kernels, _table_kernels
from taut.team._conflict_kernels import Floats
from taut.team._neighbourhood_kernels import KINDS, LARGEST, SUM_OF_COSTS, Lane, Seeds
from taut.team._search_kernels import Desk
from taut.team._table_kernels import Table
from taut.team._team_kernels import Team
from taut.team.prioritized import Round
from taut.team.reservations import copied, empty_table, legs_of, reserve, roomier
from taut.team.safe_intervals import empty_desk, with_stamps
from taut.team.team_arrays import team_of, with_distances
from taut.team.world import World

Objective = Literal["sum_of_costs", "makespan"]

_LANES = 2
_WORK = 20000  # expansions of each lane in a round, some hundredths of a second
_STATES = 1 << 17
_WAYS = 1 << 18


@dataclass(frozen=True, eq=False)
class Repaired:
    """What repair gives.

    Parameters
    ----------
    trajectories : per robot of the scene; those that were not changed are the ones given.
    cost : seconds, of the objective.
    rounds : how many were done.
    history : (rounds + 1,) cost before the first round and after each; never rises.
    interrupted : whether Ctrl-C ended it.
    """

    trajectories: tuple[Trajectory, ...]
    cost: float
    rounds: int
    history: Floats
    interrupted: bool


def repaired(
    world: World,
    first: Round,
    seed: int | Sequence[int] = 0,
    rounds: int | None = None,
    until: float = math.inf,
    objective: Objective = "sum_of_costs",
    progress: Callable[[int, float], None] | None = None,
) -> Repaired:
    """Improve a plan: take out a few robots that hinder each other, plan them anew, keep what is better.

    Two copies of the plan are improved side by side, on a core each where there are two, and become one after each
    round. So the same seed and rounds give the same motions, bit for bit, whatever the machine has.

    Parameters
    ----------
    world, first : the team, and a pass without failures.
    seed : of the choice of robots, one number or several.
    rounds : how many at most, each a fixed amount of search; None for as many as ``until`` allows.
    until : no round begins after this time of the monotonic clock, seconds.
    objective : what is to become less: the sum of costs, or the makespan and, where that stays, the sum.
    progress : called after each round with its number and the cost.

    Raises
    ------
    ValueError
        The pass has failures, the objective is unknown, seed or rounds are negative, or nothing bounds the search.

    Notes
    -----
    Ends early when no robot could arrive sooner on its roadmap even if it were alone; Ctrl-C ends it after a round.
    Memory: besides the roadmaps, for each robot the part of it near its way, and twice the reservations.
    """
    check_repair(first, seed, rounds, until, objective)
    motions = [motion for motion in first.trajectories if motion is not None]
    costs = costs_of(world, motions)
    history = [total_cost(world, costs, objective)]
    most = math.inf if rounds is None else rounds
    if not motions or most == 0 or time.monotonic() > until:
        return Repaired(tuple(motions), history[0], 0, np.array(history), False)
    team = with_distances(team_of(world) if first.team is None else first.team, costs)
    strands = _strands(world, team, motions, costs, seed)
    aim = get_args(Objective).index(objective)
    done = 0
    with held_back() as interrupted:
        while done < most and time.monotonic() <= until and (strands[0].lane.cost > team.least * (1 + 1e-9)).any():
            strands = _next_round(team, strands, aim)
            done += 1
            history.append(min(total_cost(world, strands[0].lane.cost, objective), history[-1]))
            if progress is not None:
                progress(done, history[-1])
            if interrupted():
                break
        stopped = interrupted()
    return Repaired(_trajectories(motions, strands[0].table), history[-1], done, np.array(history), stopped)


def check_repair(first: Round, seed: int | Sequence[int], rounds: int | None, until: float, objective: str) -> None:
    """Raise ValueError if that cannot be repaired."""
    if first.failures or any(motion is None for motion in first.trajectories):
        raise ValueError("only a pass without failures can be repaired: plan until all robots get through")
    if objective not in get_args(Objective):
        raise ValueError(f"objective {objective!r} is not one of {', '.join(get_args(Objective))}")
    if np.min(seed) < 0:
        raise ValueError(f"seed must be at least 0, got {seed}")
    if rounds is not None and rounds < 0:
        raise ValueError(f"rounds must be at least 0, got {rounds}")
    if rounds is None and until == math.inf:
        raise ValueError("repair needs a bound: give rounds, or until")


def costs_of(world: World, motions: Sequence[Trajectory], robots: Sequence[int] | None = None) -> Floats:
    """Seconds that motions of all robots cost, or of some."""
    chosen = range(len(motions)) if robots is None else robots
    since = np.array([world.scene.robots[i].start_time for i in chosen])
    return np.asarray(np.maximum(np.array([motion.arrival for motion in motions]) - since, 0.0))


def total_cost(world: World, costs: Floats, objective: Objective) -> float:
    """Seconds of the objective for the costs of all robots."""
    if objective == "sum_of_costs":
        return math.fsum(costs.tolist())
    since = np.array([robot.start_time for robot in world.scene.robots])
    return float(np.where(costs > 0, since + costs, 0.0).max(initial=0.0))


# --- Plans improved side by side -------------------------------------------------------------------------------------


class _Strand(NamedTuple):
    """A plan that is improved beside others, with what that takes."""

    table: Table
    desk: Desk
    lane: Lane


def _strands(
    world: World, team: Team, motions: Sequence[Trajectory], costs: Floats, seed: int | Sequence[int]
) -> list[_Strand]:
    table = empty_table(world.scene, world.cell, world.horizon)
    longest = 0
    for i, motion in enumerate(motions):
        legs = legs_of(motion, bool(team.rules[i, 0]))
        table = reserve(table, i, world.scene.robots[i].radius, legs)
        longest = max(longest, len(legs))
    table = _with_room(table)
    seeds = np.random.SeedSequence(seed).generate_state(_LANES, np.uint64).astype(np.uint64)
    strands = []
    for k in range(_LANES):
        desk = empty_desk(team, len(table.robot), _STATES, _WAYS)
        lane = _lane(costs, max(longest, len(desk.stamps)) + 1, seeds[k : k + 1])
        strands.append(_Strand(copied(table), desk, lane))
    return strands


def _next_round(team: Team, strands: list[_Strand], aim: int) -> list[_Strand]:
    """Improve each plan by itself, then make them one: the best, with what else fits of the others."""

    def improve(first: int, last: int) -> list[bool]:
        return [_repair_kernels.improve(team, *strands[k], _WORK, aim) for k in range(first, last)]

    roomy = [fits for chunk in over_chunks(improve, len(strands), 1) for fits in chunk]
    best = min(range(len(strands)), key=lambda k: (_aimed(team, strands[k].lane.cost, aim), k))
    first, *others = strands[best], *strands[:best], *strands[best + 1 :]
    for table, _, lane in others:
        roomy.append(_repair_kernels.take_over(team, *first, table, lane, aim))
    for table, _, lane in others:
        roomy.append(_repair_kernels.follow(team, table, lane, first.table, first.lane))
    _repair_kernels.settle(first.lane)
    return [first, *others] if all(roomy) else _roomier(team, [first, *others])


def _aimed(team: Team, costs: Floats, aim: int) -> tuple[float, float]:
    total = math.fsum(costs.tolist())
    latest = float(np.where(costs > 0, team.motion[:, 1] + costs, 0.0).max())
    return (total, latest) if aim == SUM_OF_COSTS else (latest, total)


def _roomier(team: Team, strands: list[_Strand]) -> list[_Strand]:
    """Return the first plan in larger tables, one for each strand."""
    table = _with_room(roomier(strands[0].table))
    for other in strands[1:]:
        other.lane.cost[:] = strands[0].lane.cost
    return [_Strand(copied(table), with_stamps(desk, table), lane) for _, desk, lane in strands]


def _with_room(table: Table) -> Table:
    """Return the table, or one with the same motions in it and as much room again."""
    while 2 * table.free[2] < len(table.robot) or 2 * table.free[3] < len(table.entry):
        table = roomier(table)
    return table


def _lane(costs: Floats, longest: int, seed: Seeds) -> Lane:
    count = len(costs)
    return Lane(
        cost=costs.copy(),
        merit=np.zeros(KINDS),
        touched=np.zeros(count, dtype=np.int64),
        leader=np.arange(count),
        chosen=np.zeros(LARGEST, dtype=np.int64),
        before=np.zeros(LARGEST, dtype=np.int64),
        costs=np.zeros(LARGEST),
        met=np.zeros(count + LARGEST, dtype=np.int64),
        late=np.zeros(count + LARGEST),
        legs=np.empty((longest, 6)),
        random=seed.copy(),
        tally=np.zeros(2, dtype=np.int64),
    )


def _trajectories(motions: Sequence[Trajectory], table: Table) -> tuple[Trajectory, ...]:
    """Motions as they stand in the table."""
    legs = np.empty((len(table.robot), 6))
    out = []
    for i, motion in enumerate(motions):
        rows = legs[: _table_kernels.copied_legs(table, int(table.first_leg[i]), legs)]
        moves = rows[np.isfinite(rows[:, 5])]
        end = moves[-1:, [5, 3, 4]] if len(moves) else rows[:1, [2, 0, 1]]
        stamps = np.concatenate([moves[:, [2, 0, 1]], end])
        out.append(
            motion if not len(rows) or np.array_equal(stamps, motion.stamps) else Trajectory(motion.name, stamps)
        )
    return tuple(out)
