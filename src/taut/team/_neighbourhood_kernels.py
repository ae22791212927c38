"""Kernels of neighbourhoods: which robots to plan anew together, as they hinder each other."""

from __future__ import annotations

from math import inf
from typing import NamedTuple, TypeAlias

import numpy as np
from numpy.typing import NDArray

from taut.team._asking_kernels import noted, robots_met
from taut.team._conflict_kernels import Floats, Ints, rest_conflict
from taut.team._grid_kernels import cell_of
from taut.team._lean import lean_kernel
from taut.team._search_kernels import Desk, clear_away, lay_out
from taut.team._table_kernels import Table
from taut.team._team_kernels import Team, edges_out, position

Seeds: TypeAlias = NDArray[np.uint64]

SUM_OF_COSTS, MAKESPAN = 0, 1
LARGEST = 8
KINDS = 4
_PASSERS, _HINDERERS, _NEARBY, _ANYBODY = range(KINDS)
_LEAST_CHANCE = 0.06


class Lane(NamedTuple):
    """One of the plans that are improved side by side, beside its table and its desk.

    Parameters
    ----------
    cost : (r,) arrival − start time of each robot, seconds.
    merit : gain for the work done of each kind of neighbourhood, fading.
    touched : (r,) whether a robot's motion was changed since the lanes last were the same.
    leader : (r,) robots whose motions were changed together since then have the same leader (union-find).
    chosen, before, costs : robots of a neighbourhood, the first legs of the motions they had, their new costs.
    met : (r,) robots found, as candidates.
    late : (r,) until when each of them is in the way.
    legs : (n, 6) legs of one motion.
    random : (1,) state of the generator.
    tally : neighbourhoods tried, taken.
    """

    cost: Floats
    merit: Floats
    touched: Ints
    leader: Ints
    chosen: Ints
    before: Ints
    costs: Floats
    met: Ints
    late: Floats
    legs: Floats
    random: Seeds
    tally: Ints


@lean_kernel
def likely_kind(lane: Lane) -> int:
    """A kind of neighbourhood: the better it did, the likelier."""
    total = 0.0
    for k in range(KINDS):
        total += lane.merit[k]
    u = _uniform(lane.random)
    for k in range(KINDS):
        share = lane.merit[k] / total if total > 0.0 else 1.0 / KINDS
        u -= _LEAST_CHANCE + (1.0 - KINDS * _LEAST_CHANCE) * share
        if u < 0.0:
            return k
    return 0


@lean_kernel
def neighbourhood(team: Team, table: Table, desk: Desk, lane: Lane, kind: int, aim: int) -> int:
    """Choose robots to plan anew, in a random order; returns how many."""
    i = _one_delayed(team, lane, aim)
    if i < 0:
        return 0
    size = 2 + _below(lane.random, LARGEST - 1)
    met = 0
    if kind == _PASSERS:
        met = _passers(team, i, table, desk, lane)
        lane.chosen[0] = i
        count = 1
        while count < size and count <= met:
            lane.chosen[count] = lane.met[count - 1]
            count += 1
    else:
        if kind == _HINDERERS:
            met = _hinderers(team, i, table, desk, lane)
        elif kind == _NEARBY:
            met = _nearby(team, i, table, desk, lane)
        else:
            met = min(lane.cost.shape[0] - 1, LARGEST)
            for k in range(met):
                lane.met[k] = _below(lane.random, lane.cost.shape[0])
        lane.chosen[0] = i
        count = 1
        while count < size and met > 0:
            k = _below(lane.random, met)
            j = lane.met[k]
            met -= 1
            lane.met[k] = lane.met[met]
            known = False
            for c in range(count):
                known = known or lane.chosen[c] == j
            if not known:
                lane.chosen[count] = j
                count += 1
    for k in range(count - 1, 0, -1):
        other = _below(lane.random, k + 1)
        lane.chosen[k], lane.chosen[other] = lane.chosen[other], lane.chosen[k]
    return count


@lean_kernel
def _uniform(random: Seeds) -> float:
    """A number in [0, 1), by SplitMix64 (Steele, Lea and Flood, OOPSLA 2014)."""
    random[0] += np.uint64(0x9E3779B97F4A7C15)
    z = random[0]
    z = (z ^ (z >> np.uint64(30))) * np.uint64(0xBF58476D1CE4E5B9)
    z = (z ^ (z >> np.uint64(27))) * np.uint64(0x94D049BB133111EB)
    return float((z ^ (z >> np.uint64(31))) >> np.uint64(11)) * 2.0**-53


@lean_kernel
def _below(random: Seeds, n: int) -> int:
    """A whole number in [0, n)."""
    return min(int(_uniform(random) * n), n - 1)


@lean_kernel
def _one_delayed(team: Team, lane: Lane, aim: int) -> int:
    """A robot, the likelier the more delayed it is; −1 if none is. For the makespan mostly the last one."""
    robots = lane.cost.shape[0]
    if aim == MAKESPAN and _uniform(lane.random) < 0.7:
        best, last = -1, 0.0
        for i in range(robots):
            if lane.cost[i] > team.least[i] and team.motion[i, 1] + lane.cost[i] > last:
                best, last = i, team.motion[i, 1] + lane.cost[i]
        return best
    total = 0.0
    for i in range(robots):
        total += max(lane.cost[i] - team.least[i], 0.0)
    u = _uniform(lane.random) * total
    last_delayed = -1
    for i in range(robots):
        delay = lane.cost[i] - team.least[i]
        if delay > 1e-9 * lane.cost[i]:
            u -= delay
            last_delayed = i
            if u < 0.0:
                return i
    return last_delayed


@lean_kernel
def _passers(team: Team, i: int, table: Table, desk: Desk, lane: Lane) -> int:
    """Robots that pass over the goal of robot i after it could be there, the last first."""
    legs, robot, radius, head, entry, following = (
        table.legs,
        table.robot,
        table.radius,
        table.head,
        table.entry,
        table.following,
    )
    frame, shape = table.frame, table.shape
    x, y = position(team, i, team.ends[i, 1])
    soonest = team.motion[i, 1] + team.least[i]
    cell = cell_of(x, y, frame, shape)
    mark = desk.counts[0]
    desk.counts[0] += 1
    met = 0
    for span in range(shape[2] + 1):
        e = head[cell, span]
        while e >= 0:
            a = entry[e]
            e = following[e]
            if desk.stamp[a] == mark or robot[a] == i or legs[a, 5] < soonest:
                continue
            desk.stamp[a] = mark
            d = team.body[i, 0] + radius[a]
            found, _, until = rest_conflict(
                x, y, legs[a, 0], legs[a, 1], legs[a, 2], legs[a, 3], legs[a, 4], legs[a, 5], d
            )
            if not found or until <= soonest:
                continue
            k = 0
            while k < met and lane.met[k] != robot[a]:
                k += 1
            if k == met:
                lane.met[k], lane.late[k] = robot[a], until
                met += 1
            else:
                lane.late[k] = max(lane.late[k], until)
    for k in range(1, met):
        j = k
        while j > 0 and (
            lane.late[j] > lane.late[j - 1] or (lane.late[j] == lane.late[j - 1] and lane.met[j] < lane.met[j - 1])
        ):
            lane.late[j], lane.late[j - 1] = lane.late[j - 1], lane.late[j]
            lane.met[j], lane.met[j - 1] = lane.met[j - 1], lane.met[j]
            j -= 1
    return met


@lean_kernel
def _hinderers(team: Team, i: int, table: Table, desk: Desk, lane: Lane) -> int:
    """Robots in the way of robot i if it went its quickest way, setting out between its start time and its delay."""
    delay = lane.cost[i] - team.least[i]
    depart = team.motion[i, 1] + max(0.0, _uniform(lane.random) * 1.5 - 0.5) * delay
    return met_on_way(team, i, table, desk, depart, 0.0, lane.met)


@lean_kernel
def met_on_way(team: Team, i: int, table: Table, desk: Desk, depart: float, lasting: float, met: Ints) -> int:
    """Write the robots that robot i would meet on its quickest way if it set out at a time; returns how many.

    Their legs that end before ``lasting`` do not count: with inf only rests for ever do.
    """
    lay_out(team, i, desk)
    xy = desk.xy[team.place[team.shared[i]] :]
    goal, speed = team.ends[i, 1], team.motion[i, 0]
    apart, headway = team.body[i, 0], team.body[i, 1]
    u = team.ends[i, 0]
    t = depart
    count = 0
    for _ in range(desk.path.shape[0]):
        if u == goal or desk.away[u] == inf:
            break
        best, tau, through = -1, 0.0, inf
        for layer in range(2):
            begin, end = edges_out(team, i, u, desk.row[u], layer)
            for k in range(begin, end):
                v = team.heads[k] if layer == 0 else team.edge_to[k]
                if desk.away[v] < desk.away[u]:
                    step = team.lengths[k] / min(speed, team.limits[k]) if layer == 0 else team.edge_length[k] / speed
                    if step + desk.away[v] < through:
                        best, tau, through = v, step, step + desk.away[v]
        if best < 0:
            break
        edge = xy[u, 0], xy[u, 1], xy[best, 0], xy[best, 1]
        count = robots_met(table, edge, tau, t, i, apart, headway, lasting, met, count)
        t += tau
        u = best
    clear_away(team, i, desk)
    return count


@lean_kernel
def _nearby(team: Team, i: int, table: Table, desk: Desk, lane: Lane) -> int:
    """Robots that come near a place of the motion of robot i at about the time when it is there."""
    legs = 0
    a = table.first_leg[i]
    while a >= 0:
        legs += 1
        a = table.next_leg[a]
    if legs == 0:
        return 0
    a = table.first_leg[i]
    for _ in range(_below(lane.random, legs)):
        a = table.next_leg[a]
    cell = cell_of(table.legs[a, 0], table.legs[a, 1], table.frame, table.shape)
    middle = int(table.legs[a, 2] / table.frame[3])
    met = 0
    for k in range(-1, 3):
        span = table.shape[2] if k == 2 else (middle + k) % table.shape[2]
        e = table.head[cell, span]
        while e >= 0:
            if table.robot[table.entry[e]] != i:
                met = noted(lane.met, met, table.robot[table.entry[e]])
            e = table.following[e]
    return met
