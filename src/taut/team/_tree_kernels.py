"""Kernels of the search tree: what nodes know, in pools, and a lower bound of all plans below a node."""

from __future__ import annotations

from math import inf
from typing import NamedTuple

from taut.compiling import kernel
from taut.team._rule_kernels import Desk, Floats, Ground, Ints, Rules, Steps, Team


class Tree(NamedTuple):
    """All that the search has made, in pools that are filled from the front; ``size`` says how far.

    A node says what it changes against its parent: motions, chains of rules, and the meetings of the new motions. A
    meeting holds as long as neither robot's motion changes again. So do the prices of its two rules as lower bounds:
    the robots' rules only grow.
    """

    node: Ints  # (nodes, 7): parent, first change, changes, first meeting, meetings, meetings that hold, state
    value: Floats  # (nodes, 2): cost, least cost of a plan below it
    change: Ints  # (changes, 3): robot, motion (-1: as before), last rule
    motion: Ints  # (motions, 2): first step, steps
    arrival: Floats  # (motions,) for good
    who: Ints  # (meetings, 6): see `_meeting_kernels`
    when: Floats  # (meetings, 5)
    price: Floats  # (meetings, 2): arrival of the robot under its rule, nan while unknown
    open_key: Floats  # heap of the open nodes by bound, with entries that are out of date
    open_node: Ints
    focal_key: Floats  # heap, by their meetings, of the open nodes whose bounds are within the limit
    focal_node: Ints
    later_key: Floats  # heap of the others by bound
    later_node: Ints


class Now(NamedTuple):
    """A node unrolled: each robot's motion and last rule, the meetings that hold; and room to reckon."""

    motion: Ints  # (k,)
    rule: Ints  # (k,)
    seen: Ints  # (k,)
    group: Ints  # (k,)
    meeting: Ints  # (k²,)
    delay: Floats  # (k + k² + 1,)
    stack: Ints  # (3 k² + 2,)


class Search(NamedTuple):
    """The problem, what has been made, and room to work in."""

    ground: Ground
    team: Team
    rules: Rules
    steps: Steps
    tree: Tree
    size: Ints  # (COUNTS,)
    desk: Desk
    now: Now
    slack: float  # seconds; what overlaps by no more is no conflict
    makespan: bool  # whether the cost is the last arrival, not the sum


# Places in ``size``: how far pools and heaps are filled, the best node with a plan (-1: none), nodes expanded
NODES, CHANGES, MOTIONS, STEPS, RULES, MEETINGS, OPEN, FOCAL, LATER, BEST, EXPANDED = range(11)
COUNTS = 11

# Columns of ``node``, and the states of a node: its meetings are not all priced, they are, it has been expanded
PARENT, FIRST_CHANGE, CHANGED, FIRST_MEETING, MET, HOLDING, STATE = range(7)
FRESH, PRICED, CLOSED = range(3)

_TRIES = 2000  # steps of the search for the least delays of one group of robots


@kernel
def unroll(tree: Tree, node: int, now: Now) -> int:
    """Find each robot's motion and last rule at a node, and the meetings that hold; return their number."""
    for i in range(now.motion.shape[0]):
        now.motion[i] = now.rule[i] = now.seen[i] = -1
    count = 0
    while node >= 0:
        first = tree.node[node, FIRST_MEETING]
        for m in range(first, first + tree.node[node, MET]):
            if now.motion[tree.who[m, 0]] < 0 and now.motion[tree.who[m, 1]] < 0:
                now.meeting[count] = m
                count += 1
        first = tree.node[node, FIRST_CHANGE]
        for c in range(first, first + tree.node[node, CHANGED]):
            i = tree.change[c, 0]
            if now.seen[i] < 0:
                now.seen[i], now.rule[i] = 1, tree.change[c, 2]
            if now.motion[i] < 0:
                now.motion[i] = tree.change[c, 1]
        node = tree.node[node, PARENT]
    return count


@kernel
def cost_now(team: Team, tree: Tree, now: Now, makespan: bool) -> float:
    """Sum of arrival − start time, or the last arrival, of the motions at hand."""
    total = 0.0
    for i in range(now.motion.shape[0]):
        arrival = tree.arrival[now.motion[i]]
        if makespan:
            total = max(total, arrival)
        else:
            total += max(0.0, arrival - team.begins[i])
    return total


@kernel
def delay_under(team: Team, tree: Tree, now: Now, m: int, side: int) -> float:
    """By how much a robot's cost grows under its rule of a meeting. One that never moved has cost nothing so far."""
    i = tree.who[m, side]
    begin = team.begins[i]
    return float(max(0.0, tree.price[m, side] - begin) - max(0.0, tree.arrival[now.motion[i]] - begin))


@kernel
def least_cost(team: Team, tree: Tree, now: Now, count: int, makespan: bool) -> float:
    """Bound the cost of all plans below the node at hand by its meetings, which are priced.

    Each meeting says that robot i is delayed by at least a, or robot j by at least b. The least sum of delays that
    meets all of these is found exactly, one group of robots that meet at a time; for a group that takes too long, the
    sum over disjoint pairs is taken instead.
    """
    cost = cost_now(team, tree, now, makespan)
    if makespan:
        for k in range(count):
            m = now.meeting[k]
            cost = max(cost, min(tree.price[m, 0], tree.price[m, 1]))
        return cost
    robots = now.motion.shape[0]
    for i in range(robots):
        now.group[i] = i
    kept = 0
    for k in range(count):
        m = now.meeting[k]
        if _least_delay(team, tree, now, m) > 0.0:
            now.stack[kept] = m
            kept += 1
            a, b = now.group[tree.who[m, 0]], now.group[tree.who[m, 1]]
            for i in range(robots):
                if now.group[i] == b:
                    now.group[i] = a
    for g in range(robots):
        members = 0
        for k in range(kept):
            if now.group[tree.who[now.stack[k], 0]] == g:
                now.stack[kept + members] = now.stack[k]
                members += 1
        if members > 0:
            cost += _group_delay(team, tree, now, kept, members)
    return cost


@kernel
def _least_delay(team: Team, tree: Tree, now: Now, m: int) -> float:
    return min(delay_under(team, tree, now, m, 0), delay_under(team, tree, now, m, 1))


@kernel
def _group_delay(team: Team, tree: Tree, now: Now, first: int, members: int) -> float:
    """Least sum of delays for the meetings from ``first`` on the stack, by depth-first search.

    Behind them on the stack stands what was tried last of each meeting down to the present depth: nothing yet (-1),
    its first or second robot delayed (0, 1), or none of them, for one is delayed enough already (2).
    """
    robots, tried = now.motion.shape[0], first + members
    _sort_by_delay(team, tree, now, first, members)
    for i in range(robots):
        now.delay[i] = 0.0
    best, total = inf, 0.0
    depth = 0
    now.stack[tried] = -1
    for _ in range(_TRIES):
        if depth < 0:
            return best
        if depth == members:
            best = total
            depth -= 1
            continue
        m, side = now.stack[first + depth], now.stack[tried + depth]
        if side == -1 and _is_met(team, tree, now, m):
            now.stack[tried + depth], now.stack[tried + depth + 1] = 2, -1
            depth += 1
            continue
        if side == 0 or side == 1:  # take back what was tried last
            i, before = tree.who[m, side], now.delay[robots + depth]
            total -= now.delay[i] - before
            now.delay[i] = before
        side += 1
        while side < 2 and delay_under(team, tree, now, m, side) == inf:
            side += 1
        if side >= 2:
            depth -= 1
            continue
        i = tree.who[m, side]
        now.stack[tried + depth], now.delay[robots + depth] = side, now.delay[i]
        more = max(now.delay[i], delay_under(team, tree, now, m, side))
        total += more - now.delay[i]
        now.delay[i] = more
        if total < best:
            depth += 1
            now.stack[tried + depth] = -1
    return _disjoint_delay(team, tree, now, first, members)


@kernel
def _is_met(team: Team, tree: Tree, now: Now, m: int) -> bool:
    one, two = tree.who[m, 0], tree.who[m, 1]
    return bool(
        now.delay[one] >= delay_under(team, tree, now, m, 0) or now.delay[two] >= delay_under(team, tree, now, m, 1)
    )


@kernel
def _sort_by_delay(team: Team, tree: Tree, now: Now, first: int, members: int) -> None:
    """Largest least delay first."""
    for k in range(first + 1, first + members):
        m = now.stack[k]
        j = k - 1
        while j >= first and _least_delay(team, tree, now, now.stack[j]) < _least_delay(team, tree, now, m):
            now.stack[j + 1] = now.stack[j]
            j -= 1
        now.stack[j + 1] = m


@kernel
def _disjoint_delay(team: Team, tree: Tree, now: Now, first: int, members: int) -> float:
    total = 0.0
    for i in range(now.motion.shape[0]):
        now.seen[i] = 0
    for k in range(first, first + members):
        m = now.stack[k]
        i, j = tree.who[m, 0], tree.who[m, 1]
        if now.seen[i] == 0 and now.seen[j] == 0:
            now.seen[i] = now.seen[j] = 1
            total += _least_delay(team, tree, now, m)
    return total
