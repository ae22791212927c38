"""Kernels of repair: a few robots' motions are taken out and planned anew, and kept where that is better."""

from __future__ import annotations

from math import inf

from taut.team._asking_kernels import first_departure, forbidden_times
from taut.team._conflict_kernels import Floats
from taut.team._lean import lean_kernel
from taut.team._neighbourhood_kernels import MAKESPAN, SUM_OF_COSTS, Lane, likely_kind, neighbourhood
from taut.team._search_kernels import EXACT, Desk, soonest_arrival
from taut.team._table_kernels import (
    Table,
    copied_legs,
    enter_motion,
    give_up,
    legs_from,
    put_back,
    take_out,
)
from taut.team._team_kernels import Team

_MOST_EXPANSIONS = 4000
_COST_OF_TRYING = 20  # expansions that choosing and editing take, about
_FADING = 0.98


@lean_kernel
def improve(team: Team, table: Table, desk: Desk, lane: Lane, work: int, aim: int) -> bool:
    """Try neighbourhoods until about ``work`` expansions are done; False if the table had no room for a motion."""
    done = 0
    roomy = True
    while done < work and roomy:
        before = desk.counts[2]
        kind = likely_kind(lane)
        count = neighbourhood(team, table, desk, lane, kind, aim)
        gain = 0.0
        if count > 0:
            gain, roomy = _replanned(team, table, desk, lane, count, aim)
        effort = desk.counts[2] - before + _COST_OF_TRYING
        done += effort
        lane.tally[0] += 1
        lane.merit[kind] = _FADING * lane.merit[kind] + (1.0 - _FADING) * gain / effort
    return roomy


@lean_kernel
def _replanned(team: Team, table: Table, desk: Desk, lane: Lane, count: int, aim: int) -> tuple[float, bool]:
    """Plan the chosen robots anew in their order; returns the gain and whether there was room in the table."""
    chosen = lane.chosen
    latest = _latest(team, lane, 0) if aim == MAKESPAN else inf
    old = 0.0
    rest = 0.0
    for k in range(count):
        old += lane.cost[chosen[k]]
        rest += team.least[chosen[k]]
        lane.before[k] = table.first_leg[chosen[k]]
        take_out(table, lane.before[k])
        table.first_leg[chosen[k]] = -1
    spent = 0.0
    roomy = True
    done = 0
    costs = lane.costs
    for k in range(count):
        i = chosen[k]
        rest -= team.least[i]
        since = team.motion[i, 1]
        # a little more, so that rounding does not refuse what is as good
        limit = latest if aim == MAKESPAN else since + (old - spent - rest) * (1.0 + 1e-12)
        stamps = soonest_arrival(team, i, table, None, desk, limit, _MOST_EXPANSIONS, EXACT)
        if stamps <= 0:
            break
        costs[k] = max(0.0, desk.stamps[stamps - 1, 0] - since)
        spent += costs[k]
        legs = legs_from(desk.stamps, stamps, team.rules[i, 0] == 1, lane.legs)
        roomy = enter_motion(table, i, team.body[i, 2], lane.legs, legs)
        if not roomy:
            break
        done += 1
    better = done == count
    gain = 0.0
    if better:
        gain = old - spent
        better = gain >= 0.0
        if aim == MAKESPAN:
            now = _latest(team, lane, count)
            gain = max(latest - now, 0.0)
            better = now < latest or (now == latest and spent <= old)
    for k in range(count):
        i = chosen[k]
        if better:
            give_up(table, lane.before[k])
            lane.cost[i] = costs[k]
            lane.touched[i] = 1
            lane.leader[_leader(lane, i)] = _leader(lane, chosen[0])
        else:
            take_out(table, table.first_leg[i])
            give_up(table, table.first_leg[i])
    if better:
        lane.tally[1] += 1
        return gain, roomy
    for k in range(count):
        table.first_leg[chosen[k]] = lane.before[k]
        put_back(table, lane.before[k])
    return 0.0, roomy


@lean_kernel
def _latest(team: Team, lane: Lane, count: int) -> float:
    """Latest arrival of all, the first ``count`` robots chosen at their new costs."""
    latest = 0.0
    for i in range(lane.cost.shape[0]):
        cost = lane.cost[i]
        for k in range(count):
            if lane.chosen[k] == i:
                cost = lane.costs[k]
        if cost > 0.0:
            latest = max(latest, team.motion[i, 1] + cost)
    return latest


# --- Two lanes become one ---------------------------------------------------------------------------------------------


@lean_kernel
def _leader(lane: Lane, i: int) -> int:
    while lane.leader[i] != i:
        i = lane.leader[i]
    return i


@lean_kernel
def take_over(team: Team, table: Table, desk: Desk, lane: Lane, other: Table, others: Lane, aim: int) -> bool:
    """Take over from another lane what is better there and fits; False if the table had no room for something.

    Motions changed together are taken over together.
    """
    roomy = True
    for leader in range(lane.cost.shape[0]):
        if others.touched[leader] == 1 and others.leader[leader] == leader:
            roomy = _taken_over(team, table, desk, lane, other, others, leader, aim) and roomy
    return roomy


@lean_kernel
def follow(team: Team, table: Table, lane: Lane, other: Table, others: Lane) -> bool:
    """Make a lane the same as another from which it has parted; False if its table had no room."""
    robots = lane.cost.shape[0]
    for i in range(robots):
        if lane.touched[i] == 1 or others.touched[i] == 1:
            take_out(table, table.first_leg[i])
            give_up(table, table.first_leg[i])
            table.first_leg[i] = -1
    roomy = True
    for i in range(robots):
        if lane.touched[i] == 1 or others.touched[i] == 1:
            legs = copied_legs(other, other.first_leg[i], lane.legs)
            roomy = enter_motion(table, i, team.body[i, 2], lane.legs, legs) and roomy
            lane.cost[i] = others.cost[i]
    settle(lane)
    return roomy


@lean_kernel
def settle(lane: Lane) -> None:
    """Begin anew to note which motions are changed."""
    for i in range(lane.cost.shape[0]):
        lane.touched[i] = 0
        lane.leader[i] = i


@lean_kernel
def _taken_over(
    team: Team,
    table: Table,
    desk: Desk,
    lane: Lane,
    other: Table,
    others: Lane,
    leader: int,
    aim: int,
) -> bool:
    robots = lane.cost.shape[0]
    gain = 0.0
    for i in range(robots):
        if others.touched[i] == 1 and _leader(others, i) == leader:
            gain += lane.cost[i] - others.cost[i]
    if gain <= 0.0:
        return True
    old = lane.met
    for i in range(robots):
        if others.touched[i] == 1 and _leader(others, i) == leader:
            old[i] = table.first_leg[i]
            take_out(table, old[i])
            table.first_leg[i] = -1
    latest = _latest(team, lane, 0)
    fits = roomy = True
    for i in range(robots):
        if fits and others.touched[i] == 1 and _leader(others, i) == leader:
            legs = copied_legs(other, other.first_leg[i], lane.legs)
            fits = aim == SUM_OF_COSTS or team.motion[i, 1] + others.cost[i] <= latest
            fits = fits and _fits(team, i, table, desk, lane.legs, legs)
    # they fit one another as they come from one plan
    for i in range(robots):
        if fits and others.touched[i] == 1 and _leader(others, i) == leader:
            legs = copied_legs(other, other.first_leg[i], lane.legs)
            roomy = enter_motion(table, i, team.body[i, 2], lane.legs, legs)
            fits = roomy
    for i in range(robots):
        if others.touched[i] == 1 and _leader(others, i) == leader:
            if fits:
                give_up(table, old[i])
                lane.cost[i] = others.cost[i]
                lane.touched[i] = 1
            else:
                take_out(table, table.first_leg[i])
                give_up(table, table.first_leg[i])
    if not fits:
        for i in range(robots):
            if others.touched[i] == 1 and _leader(others, i) == leader:
                table.first_leg[i] = old[i]
                put_back(table, old[i])
    return roomy


@lean_kernel
def _fits(team: Team, i: int, table: Table, desk: Desk, legs: Floats, count: int) -> bool:
    """Whether a motion of robot i keeps from all reserved ones."""
    apart = team.body[i, 0] - team.motion[i, 2] / 8  # motions that touch must not fall out over rounding
    headway = team.body[i, 1]
    for k in range(count):
        x0, y0, t0, t1 = legs[k, 0], legs[k, 1], legs[k, 2], legs[k, 5]
        if t1 == inf:
            found = forbidden_times(
                table, x0, y0, i, apart, headway, t0, inf, desk.lo, desk.hi, desk.stamp, desk.counts[0]
            )
            desk.counts[0] += 1
            if found < 0 or (found > 0 and desk.hi[found - 1] > t0):
                return False
        else:
            edge = x0, y0, legs[k, 3], legs[k, 4]
            if first_departure(table, edge, t1 - t0, t0, t0, i, apart, headway) == inf:
                return False
    return True
