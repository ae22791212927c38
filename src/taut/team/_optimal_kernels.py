"""Kernels of conflict-based search in continuous time: which node comes next, and its children."""

from __future__ import annotations

from math import inf, nan

from taut.compiling import kernel
from taut.heap import drop_first, push
from taut.team._conflict_kernels import rest_conflict
from taut.team._constrained_kernels import NO_ROOM, earliest_motion
from taut.team._meeting_kernels import first_meeting
from taut.team._rule_kernels import (
    ALONG,
    AT,
    KEEP_OUT,
    MARKS,
    NOT_AFTER,
    NOT_ALONG,
    NOT_AT,
    THROUGHOUT,
    Ints,
    certain_order,
    duration,
)
from taut.team._tree_kernels import (
    BEST,
    CHANGED,
    CHANGES,
    CLOSED,
    EXPANDED,
    FIRST_CHANGE,
    FIRST_MEETING,
    FOCAL,
    FRESH,
    HOLDING,
    LATER,
    MEETINGS,
    MET,
    MOTIONS,
    NODES,
    OPEN,
    PARENT,
    PRICED,
    RULES,
    STATE,
    STEPS,
    Search,
    Tree,
    cost_now,
    delay_under,
    least_cost,
    unroll,
)

# What a search ends with: it may go on, once its pools are larger; it has a plan; there is none
MORE, ROOM, SOLVED, EXHAUSTED = range(4)


@kernel
def plant(s: Search) -> int:
    """Make the root, everybody's earliest motion; return MORE, ROOM, or EXHAUSTED if somebody has none."""
    tree, size, now = s.tree, s.size, s.now
    robots = now.motion.shape[0]
    for k in range(size.shape[0]):
        size[k] = 0
    size[BEST] = -1
    for i in range(robots):
        now.rule[i] = -1
        count, arrival = earliest_motion(s.ground, s.team, s.rules, i, now.rule[i], s.steps, size[STEPS], s.desk)
        if count == 0:
            return ROOM if arrival == NO_ROOM else EXHAUSTED
        _add_change(s, i, _add_motion(s, count, arrival), now.rule[i])
        now.motion[i] = i
    for i in range(robots):
        for j in range(i + 1, robots):
            _meet(s, i, j)
    size[NODES] = 1
    tree.node[0, PARENT], tree.node[0, STATE] = -1, FRESH
    tree.node[0, FIRST_CHANGE], tree.node[0, CHANGED] = 0, robots
    tree.node[0, FIRST_MEETING], tree.node[0, MET] = 0, size[MEETINGS]
    tree.node[0, HOLDING] = size[MEETINGS]
    tree.value[0, 0] = tree.value[0, 1] = cost_now(s.team, tree, now, s.makespan)
    if size[MEETINGS] == 0:
        size[BEST] = 0
    _put(tree, size, size[NODES] - 1, 0.0)
    return MORE


@kernel
def search(s: Search, within: float, at_most: float, visits: int) -> tuple[int, float]:
    """Visit nodes, each to price its meetings or to expand it; return why it stopped, and the bound proven by then.

    A plan that costs ``at_most`` is known already.
    """
    tree, size = s.tree, s.size
    bound = 0.0
    for _ in range(visits):
        bound, limit = _limits(tree, size, within)
        best = at_most if size[BEST] < 0 else min(at_most, tree.value[size[BEST], 0])
        if bound == inf and best == inf:
            return EXHAUSTED, inf
        if best <= limit:
            return SOLVED, bound
        if not _has_room(s):
            return ROOM, bound
        kept = size.copy()
        node = -tree.focal_node[0]
        drop_first(tree.focal_key, tree.focal_node, size[FOCAL])
        size[FOCAL] -= 1
        if not _visit(s, node, limit):
            for k in range(size.shape[0]):
                size[k] = kept[k]
            push(tree.focal_key, tree.focal_node, size[FOCAL] - 1, float(tree.node[node, HOLDING]), -node)
            return ROOM, bound
    return MORE, bound


@kernel
def _limits(tree: Tree, size: Ints, within: float) -> tuple[float, float]:
    """Least bound of the open nodes, and up to which bound nodes are visited; brings the heaps up to date."""
    while size[OPEN] > 0:
        node = -tree.open_node[0]
        if tree.node[node, STATE] != CLOSED and tree.value[node, 1] == tree.open_key[0]:
            break
        drop_first(tree.open_key, tree.open_node, size[OPEN])
        size[OPEN] -= 1
    bound = tree.open_key[0] if size[OPEN] > 0 else inf
    limit = bound * within * (1.0 + 2.0**-44)  # costs are sums with rounding errors
    while size[LATER] > 0 and tree.later_key[0] <= limit:
        node = -tree.later_node[0]
        drop_first(tree.later_key, tree.later_node, size[LATER])
        size[LATER] -= 1
        push(tree.focal_key, tree.focal_node, size[FOCAL], float(tree.node[node, HOLDING]), -node)
        size[FOCAL] += 1
    return bound, limit


@kernel
def _put(tree: Tree, size: Ints, node: int, limit: float) -> None:
    """Put a node among the open ones. Of nodes with equal keys the newest comes first."""
    bound = tree.value[node, 1]
    push(tree.open_key, tree.open_node, size[OPEN], bound, -node)
    size[OPEN] += 1
    if bound <= limit:
        push(tree.focal_key, tree.focal_node, size[FOCAL], float(tree.node[node, HOLDING]), -node)
        size[FOCAL] += 1
    else:
        push(tree.later_key, tree.later_node, size[LATER], bound, -node)
        size[LATER] += 1


@kernel
def _has_room(s: Search) -> bool:
    """Whether the pools hold what one visit may add, apart from steps."""
    tree, size = s.tree, s.size
    robots = s.now.motion.shape[0]
    return bool(
        size[NODES] + 2 <= tree.node.shape[0]
        and size[CHANGES] + 2 * robots <= tree.change.shape[0]
        and size[MOTIONS] + 2 * robots <= tree.motion.shape[0]
        and size[MEETINGS] + robots * robots <= tree.who.shape[0]
        and size[RULES] + 2 * robots + 1 <= s.rules.what.shape[0]
        and size[OPEN] + 2 <= tree.open_key.shape[0]
        and size[FOCAL] + size[LATER] + 2 <= tree.focal_key.shape[0]  # all the later ones may move there
        and size[LATER] + 2 <= tree.later_key.shape[0]
    )


@kernel
def _visit(s: Search, node: int, limit: float) -> bool:
    """Price a node's meetings and put it back if that raises its bound, else expand it; False without room."""
    tree, now = s.tree, s.now
    count = unroll(tree, node, now)
    if tree.node[node, STATE] == FRESH:
        for k in range(count):
            for side in range(2):
                if not _price(s, now.meeting[k], side):
                    return False
        tree.node[node, STATE] = PRICED
        bound = least_cost(s.team, tree, now, count, s.makespan)
        if bound == inf:
            tree.node[node, STATE] = CLOSED
            return True
        if bound > tree.value[node, 1]:
            tree.value[node, 1] = bound
            _put(tree, s.size, node, limit)
            return True
    return _expand(s, node, _choose(s, count), count, limit)


@kernel
def _price(s: Search, m: int, side: int) -> bool:
    """Find when a robot arrives under its rule of a meeting, unless that is known; False without room."""
    if s.tree.price[m, side] == s.tree.price[m, side]:
        return True
    i = s.tree.who[m, side]
    last = _write_rule(s, m, side, s.now.rule[i])  # beyond the end of the pool: for this time only
    _, arrival = earliest_motion(s.ground, s.team, s.rules, i, last, s.steps, s.size[STEPS], s.desk)
    if arrival == NO_ROOM:
        return False
    s.tree.price[m, side] = arrival
    return True


@kernel
def _choose(s: Search, count: int) -> int:
    """The meeting whose rules delay most: by the smaller delay, then the larger one, then the earliest."""
    best = int(s.now.meeting[0])
    best_low, best_high = -inf, -inf
    for k in range(count):
        m = s.now.meeting[k]
        one, two = delay_under(s.team, s.tree, s.now, m, 0), delay_under(s.team, s.tree, s.now, m, 1)
        low, high = min(one, two), max(one, two)
        sooner = low == best_low and high == best_high and s.tree.when[m, 0] < s.tree.when[best, 0]
        if low > best_low or (low == best_low and high > best_high) or sooner:
            best, best_low, best_high = m, low, high
    return best


@kernel
def _expand(s: Search, node: int, m: int, count: int, limit: float) -> bool:
    """Make a node's children, one for each rule of a meeting; False without room.

    A child that costs no more and has fewer meetings replaces its parent, without the rule: then nothing is branched
    (Boyarski et al., Don't split, try to work it out, ICAPS 2015).
    """
    tree, size = s.tree, s.size
    first, landmark = size[NODES], _landmark_side(s, m)
    for side in range(2):
        if tree.price[m, side] == inf:
            continue
        child = size[NODES]
        first_change, first_met = size[CHANGES], size[MEETINGS]
        changed = _change(s, m, side, landmark)
        if changed < 0:
            return False
        if changed == 0:
            size[CHANGES] = first_change
            continue
        cost, holding = _meet_changed(s, first_change, count)
        size[NODES] += 1
        tree.node[child, PARENT], tree.node[child, STATE] = node, FRESH
        tree.node[child, FIRST_CHANGE], tree.node[child, CHANGED] = first_change, changed
        tree.node[child, FIRST_MEETING], tree.node[child, MET] = first_met, size[MEETINGS] - first_met
        tree.node[child, HOLDING] = holding
        tree.value[child, 0], tree.value[child, 1] = cost, max(cost, tree.value[node, 1])
        free = cost <= tree.value[node, 0] and holding < tree.node[node, HOLDING]
        if free and tree.who[m, 2 + 2 * side] != KEEP_OUT:
            for c in range(first_change, size[CHANGES]):
                tree.change[c, 2] = s.now.rule[tree.change[c, 0]]
            first = child
            break
    tree.node[node, STATE] = CLOSED
    size[EXPANDED] += 1
    for child in range(first, size[NODES]):
        if tree.node[child, HOLDING] == 0 and (size[BEST] < 0 or tree.value[child, 0] < tree.value[size[BEST], 0]):
            size[BEST] = child
        _put(tree, size, child, limit)
    return True


@kernel
def _change(s: Search, m: int, side: int, landmark: int) -> int:
    """Give robots the rules of one side of a meeting, and motions that keep them.

    Returns
    -------
    changes : how many; 0 if a robot has no such motion, -1 without room.
    """
    tree, size, now = s.tree, s.size, s.now
    robot, other, kind = tree.who[m, side], tree.who[m, 1 - side], tree.who[m, 2 + 2 * side]
    first = size[CHANGES]
    for i in range(now.motion.shape[0]):
        if i == other:
            if kind == KEEP_OUT:  # that robot is at its goal for good before the others keep out
                r = _add_rule(s, m, side, i)
                s.rules.what[r, 0], s.rules.when[r, 1] = NOT_AFTER, tree.when[m, 1 + 2 * side]
                _add_change(s, i, -1, r)
            elif landmark == 1 - side:
                r = _add_rule(s, m, landmark, i)
                s.rules.what[r, 0] = _broken(s.rules.what[r, 0])
                _add_change(s, i, -1, r)
        elif i == robot or kind == KEEP_OUT:
            r = _add_rule(s, m, side, i)
            motion = -1
            if i == robot or _intrudes(s, i, other, s.rules.when[r, 0]):
                count, arrival = earliest_motion(s.ground, s.team, s.rules, i, r, s.steps, size[STEPS], s.desk)
                if count == 0:
                    return -1 if arrival == NO_ROOM else 0
                motion = _add_motion(s, count, arrival)
            _add_change(s, i, motion, r)
    return int(size[CHANGES] - first)


@kernel
def _meet_changed(s: Search, first_change: int, count: int) -> tuple[float, int]:
    """Add the meetings of new motions; return the cost of all motions with them, and how many meetings hold."""
    tree, size, now = s.tree, s.size, s.now
    robots = now.motion.shape[0]
    first = size[MEETINGS]
    for i in range(robots):
        now.seen[i] = -1
    for c in range(first_change, size[CHANGES]):
        i = tree.change[c, 0]
        if tree.change[c, 1] >= 0:
            now.seen[i] = now.motion[i]
            now.motion[i] = tree.change[c, 1]
    cost = cost_now(s.team, tree, now, s.makespan)
    for i in range(robots):
        for j in range(i + 1, robots):
            if now.seen[i] >= 0 or now.seen[j] >= 0:
                _meet(s, i, j)
    holding = size[MEETINGS] - first
    for k in range(count):
        m = now.meeting[k]
        if now.seen[tree.who[m, 0]] < 0 and now.seen[tree.who[m, 1]] < 0:
            holding += 1
    for i in range(robots):  # the other child starts from the same node
        if now.seen[i] >= 0:
            now.motion[i] = now.seen[i]
    return cost, holding


@kernel
def _meet(s: Search, i: int, j: int) -> None:
    """Add the first meeting of two robots' motions to the pool, if there is one."""
    tree, row = s.tree, s.size[MEETINGS]
    a, b = s.now.motion[i], s.now.motion[j]
    if first_meeting(
        s.ground, s.team, s.slack, s.steps, i, tree.motion[a, 0], tree.motion[a, 1],
        j, tree.motion[b, 0], tree.motion[b, 1], tree.who, tree.when, row,
    ):  # fmt: skip
        tree.price[row, 0] = tree.price[row, 1] = nan
        s.size[MEETINGS] += 1


@kernel
def _intrudes(s: Search, i: int, owner: int, since: float) -> bool:
    """Whether robot i's motion breaks the rule to keep out of the place of ``owner``'s goal from ``since`` on.

    Its last rest is none if it leaves.
    """
    ground, steps = s.ground, s.steps
    goal, d = s.team.goals[owner], s.team.apart[i, owner]
    x, y = ground.positions[goal, 0], ground.positions[goal, 1]
    first, count = s.tree.motion[s.now.motion[i], 0], s.tree.motion[s.now.motion[i], 1]
    for k in range(first, first + count):
        u, e, depart = steps.where[k, 0], steps.where[k, 1], steps.when[k, 1]
        ux, uy = ground.positions[u, 0], ground.positions[u, 1]
        near = (ux - x) * (ux - x) + (uy - y) * (uy - y) < d * d
        if near and depart >= since and (e >= 0 or s.team.leaves[i] == 0):
            return True
        if e >= 0:
            v = ground.heads[e]
            vx, vy = ground.positions[v, 0], ground.positions[v, 1]
            found, _, until = rest_conflict(x, y, ux, uy, 0.0, vx, vy, duration(ground, s.team, i, e), d)
            if found and depart + until >= since:
                return True
    return False


@kernel
def _landmark_side(s: Search, m: int) -> int:
    """Which robot is to break its rule where the other one keeps its own; -1 if neither can be told to.

    The one whose rule is for the shorter time, if it may: the shorter that is, the more a landmark says.
    """
    when = s.tree.when
    if s.tree.who[m, 2] == KEEP_OUT:
        return -1
    shorter = 0 if when[m, 2] - when[m, 1] < when[m, 4] - when[m, 3] else 1
    for side in (shorter, 1 - shorter):
        if _can_break(s, m, side):
            return side
    return -1


@kernel
def _can_break(s: Search, m: int, side: int) -> bool:
    """Whether breaking a rule can be a landmark: the robot has few, and the order among them is certain."""
    rules, tree = s.rules, s.tree
    i, place = tree.who[m, side], tree.who[m, 3 + 2 * side]
    kind, since, until = _broken(tree.who[m, 2 + 2 * side]), tree.when[m, 1 + 2 * side], tree.when[m, 2 + 2 * side]
    if kind != ALONG and place == s.team.goals[i]:
        return False  # to rest there may be to have arrived
    marks = 0
    r = s.now.rule[i]
    while r >= 0:
        other, its_place, its_since, its_until = rules.what[r, 0], rules.what[r, 1], rules.when[r, 0], rules.when[r, 1]
        if other >= ALONG:
            marks += 1
            if marks == MARKS or not certain_order(
                s.ground, s.team, i, kind, place, since, until, other, its_place, its_since, its_until
            ):
                return False
        r = rules.what[r, 2]
    return True


@kernel
def _broken(kind: int) -> int:
    """What a robot does that breaks a rule."""
    if kind == NOT_ALONG:
        return ALONG
    return AT if kind == NOT_AT else THROUGHOUT


@kernel
def _write_rule(s: Search, m: int, side: int, last: int) -> int:
    """Write a meeting's rule for one side behind the end of the pool, as the next one after ``last``."""
    r, rules = int(s.size[RULES]), s.rules
    rules.what[r, 0], rules.what[r, 1] = s.tree.who[m, 2 + 2 * side], s.tree.who[m, 3 + 2 * side]
    rules.what[r, 2], rules.what[r, 3] = last, 1 if last < 0 else rules.what[last, 3] + 1
    rules.when[r, 0], rules.when[r, 1] = s.tree.when[m, 1 + 2 * side], s.tree.when[m, 2 + 2 * side]
    return r


@kernel
def _add_rule(s: Search, m: int, side: int, robot: int) -> int:
    r = _write_rule(s, m, side, s.now.rule[robot])
    s.size[RULES] += 1
    return r


@kernel
def _add_motion(s: Search, count: int, arrival: float) -> int:
    """Keep the steps that stand behind the end of the pool."""
    motion = int(s.size[MOTIONS])
    s.tree.motion[motion, 0], s.tree.motion[motion, 1] = s.size[STEPS], count
    s.tree.arrival[motion] = arrival
    s.size[MOTIONS] += 1
    s.size[STEPS] += count
    return motion


@kernel
def _add_change(s: Search, robot: int, motion: int, rule: int) -> None:
    c = s.size[CHANGES]
    s.tree.change[c, 0], s.tree.change[c, 1], s.tree.change[c, 2] = robot, motion, rule
    s.size[CHANGES] += 1
