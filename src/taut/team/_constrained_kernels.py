"""Kernels of one robot under rules: its earliest motion on a roadmap that keeps to all of them."""

from __future__ import annotations

from math import inf

from taut.compiling import kernel
from taut.team._conflict_kernels import rest_conflict
from taut.team._rule_kernels import (
    ALONG,
    AT,
    NOT_AT,
    NOT_THROUGHOUT,
    Desk,
    Floats,
    Ground,
    Ints,
    Rules,
    Steps,
    Team,
    clear_rules,
    duration,
    left_from,
    sort_rules,
)

NO_ROOM = -1.0

_DONE = -2  # for a state's place in the heap: it has been expanded


@kernel
def earliest_motion(
    ground: Ground, team: Team, rules: Rules, who: int, last: int, steps: Steps, first: int, desk: Desk
) -> tuple[int, float]:
    """Earliest motion of a robot to its goal, where it stays, under the rules that end with ``last`` (-1: none).

    A* over (vertex, safe interval) as in safe-interval path planning. Rules are half-open, so what is allowed has a
    first instant: the earliest arrival exists. Arriving earlier in the same safe interval is never worse, since the
    robot may rest there until its end. NOT_THROUGHOUT makes two overlapping intervals of one: arrive at any time and
    leave before `until`, or arrive at `since` or later.

    Returns
    -------
    count, arrival : the steps written from ``first`` on and the instant of arrival for good; a robot that never moves
        has arrived at 0. (0, inf): there is no such motion. (0, NO_ROOM): an array is too short.
    """
    if last >= 0 and rules.what[last, 3] >= desk.link.shape[0]:
        return 0, NO_ROOM
    n = ground.positions.shape[0]
    links, keep_outs, marks, not_before, not_after = sort_rules(ground, team, rules, who, last, desk)
    start, goal, begin = team.starts[who], team.goals[who], team.begins[who]
    remaining, leaves = team.remaining[who], team.leaves[who] == 1
    # state 0 is the end: at the goal for good, no earlier than it may be there
    desk.state[0, 0], desk.state[0, 1], desk.state[0, 3], desk.state[0, 4] = goal, -1, -1, marks
    desk.opens[0], desk.closes[0], desk.arrive[0] = 0.0, inf, inf
    states, size = 1, 0
    never_moves = False
    if team.remaining[who, start] < inf:
        kept_out = 0 if leaves and start == goal else keep_outs
        states = _add_vertex(ground, rules, start, 0, states, kept_out, desk)
        if desk.opens[1] <= 0.0 and desk.closes[1] > begin:
            never_moves = start == goal and desk.closes[1] == inf and not_before <= 0.0 and marks == 0
            left, _ = left_from(ground, team, who, start, 0, marks, desk)
            _come(desk.state, desk.leave, desk.arrive, desk.key, 1, -1, -1, 0.0, 0.0, begin + left)
            size = _lift(desk.heap, desk.state, desk.key, desk.arrive, 1, size)

    while size > 0 and not never_moves:
        s = desk.heap[0]
        if s == 0 or desk.key[s] >= not_after:
            break
        size = _drop_first(desk.heap, desk.state, desk.key, desk.arrive, size)
        u, layer = desk.state[s, 0], desk.state[s, 4]
        if layer < marks and desk.mark[layer, 0] != ALONG and desk.mark[layer, 1] == u:
            states, size = _stay(ground, team, rules, who, s, marks, states, keep_outs, size, desk)
        ready = max(desk.arrive[s], begin)  # it is at its start from 0, but may not leave before
        # in one kernel: to hand all arrays to another one costs more than what is done for an edge
        for e in range(ground.indptr[u], ground.indptr[u + 1]):
            v = ground.heads[e]
            if remaining[v] == inf:
                continue
            tau = duration(ground, team, who, e)
            before = desk.closes[s]
            if keep_outs > 0:
                before = min(before, _shut_from(ground, e, tau, keep_outs, desk))
            passes = layer < marks and desk.mark[layer, 0] == ALONG and desk.mark[layer, 1] == e
            for after in range(layer, layer + 2 if passes else layer + 1):
                if after > layer:  # the departure that the landmark asks for
                    ready = max(ready, desk.mark_time[layer, 0])
                    before = min(before, desk.mark_time[layer, 1])
                place = after * n + v
                if desk.first_state[place] < 0:
                    # where it is gone on arrival it is in nobody's way
                    kept_out = 0 if leaves and v == goal else keep_outs
                    states = _add_vertex(ground, rules, v, after, states, kept_out, desk)
                left, latest = remaining[v], inf
                if after < marks:
                    left, latest = left_from(ground, team, who, v, after, marks, desk)
                for t in range(desk.first_state[place], desk.first_state[place] + desk.how_many[place]):
                    ends = after == marks and v == goal and desk.closes[t] == inf
                    soonest = ready + tau
                    late = soonest >= desk.arrive[t] or desk.state[t, 3] == _DONE
                    if late and not (ends and soonest < desk.arrive[0]):
                        continue
                    depart = max(ready, desk.opens[t] - tau)
                    if desk.edge_rule[e] >= 0:
                        depart = _allowed(rules.when, desk.link, desk.edge_rule[e], depart)
                    arrive = max(depart + tau, desk.opens[t])
                    if depart >= before or arrive >= desk.closes[t] or arrive >= latest:
                        continue
                    better = arrive < desk.arrive[t] and arrive + left < desk.arrive[0] and not late
                    if better and not (ends and arrive >= not_before):
                        _come(desk.state, desk.leave, desk.arrive, desk.key, t, s, e, depart, arrive, arrive + left)
                        size = _lift(desk.heap, desk.state, desk.key, desk.arrive, t, size)
                    if ends:
                        depart = max(depart, not_before - tau)
                        if desk.edge_rule[e] >= 0:
                            depart = _allowed(rules.when, desk.link, desk.edge_rule[e], depart)
                        arrive = max(depart + tau, desk.opens[t], not_before)
                        if depart < before and arrive < desk.arrive[0]:
                            _come(desk.state, desk.leave, desk.arrive, desk.key, 0, s, e, depart, arrive, arrive)
                            size = _lift(desk.heap, desk.state, desk.key, desk.arrive, 0, size)
            ready = max(desk.arrive[s], begin)

    count, arrival = 0, inf
    if never_moves or (size > 0 and desk.heap[0] == 0 and desk.arrive[0] < not_after):
        count = _write(desk, 1 if never_moves else 0, steps, first)
        arrival = NO_ROOM if count == 0 else 0.0 if never_moves else desk.arrive[0]
    clear_rules(rules, links, desk)
    for s in range(states):
        desk.first_state[desk.state[s, 4] * n + desk.state[s, 0]] = -1
    return count, arrival


@kernel
def _stay(
    ground: Ground,
    team: Team,
    rules: Rules,
    who: int,
    s: int,
    marks: int,
    states: int,
    keep_outs: int,
    size: int,
    desk: Desk,
) -> tuple[int, int]:
    """Go on to the next layer by being at the vertex of a landmark; return the numbers of states and of queued ones."""
    u, layer, came = desk.state[s, 0], desk.state[s, 4], desk.arrive[s]
    since, until = desk.mark_time[layer, 0], desk.mark_time[layer, 1]
    if desk.mark[layer, 0] == AT:
        then = max(came, since)
        possible = then < until
    else:
        then = until
        possible = came < since
    if not possible or then >= desk.closes[s]:
        return states, size
    n = ground.positions.shape[0]
    if desk.first_state[(layer + 1) * n + u] < 0:
        states = _add_vertex(ground, rules, u, layer + 1, states, keep_outs, desk)
    t = desk.first_state[(layer + 1) * n + u] + s - desk.first_state[layer * n + u]
    if then < desk.arrive[t] and desk.state[t, 3] != _DONE:
        left, _ = left_from(ground, team, who, u, layer + 1, marks, desk)
        key = max(then, team.begins[who]) + left
        _come(desk.state, desk.leave, desk.arrive, desk.key, t, s, -1, then, then, key)
        size = _lift(desk.heap, desk.state, desk.key, desk.arrive, t, size)
    return states, size


@kernel
def _add_vertex(ground: Ground, rules: Rules, v: int, layer: int, states: int, keep_outs: int, desk: Desk) -> int:
    """Make a state for each safe interval of a vertex, none contained in another; return the number of states."""
    lo, hi = desk.opens[states:], desk.closes[states:]
    lo[0], hi[0] = 0.0, inf
    for k in range(keep_outs):
        x, y = desk.keep_out[k, 0] - ground.positions[v, 0], desk.keep_out[k, 1] - ground.positions[v, 1]
        if x * x + y * y < desk.keep_out[k, 2] * desk.keep_out[k, 2]:
            hi[0] = min(hi[0], desk.keep_out[k, 3])
    count = 1
    link = desk.vertex_rule[v]
    while link >= 0:
        r = desk.link[link, 0]
        since, until = rules.when[r, 0], rules.when[r, 1]
        for k in range(count):
            a, b = lo[k], hi[k]
            if rules.what[r, 0] == NOT_AT and a < until and b > since:
                lo[k], hi[k] = until, b
                if a < since:
                    lo[count], hi[count] = a, since
                    count += 1
            elif rules.what[r, 0] == NOT_THROUGHOUT and a < since and b > until:
                lo[k], hi[k] = since, b
                lo[count], hi[count] = a, until
                count += 1
        count = _without_contained(lo, hi, count)
        link = desk.link[link, 1]
    if count == 0:  # one empty interval, so that every vertex met has a state
        lo[0], hi[0], count = 0.0, 0.0, 1
    place = layer * ground.positions.shape[0] + v
    desk.first_state[place], desk.how_many[place] = states, count
    for s in range(states, states + count):
        desk.arrive[s] = inf
        desk.state[s, 0], desk.state[s, 1], desk.state[s, 3], desk.state[s, 4] = v, -1, -1, layer
    return states + count


@kernel
def _without_contained(lo: Floats, hi: Floats, count: int) -> int:
    """Drop intervals that are empty or within another one, and sort the rest."""
    for k in range(1, count):
        a, b = lo[k], hi[k]
        j = k - 1
        while j >= 0 and (lo[j] > a or (lo[j] == a and hi[j] < b)):
            lo[j + 1], hi[j + 1] = lo[j], hi[j]
            j -= 1
        lo[j + 1], hi[j + 1] = a, b
    kept = 0
    for k in range(count):
        if lo[k] < hi[k] and (kept == 0 or hi[k] > hi[kept - 1]):
            lo[kept], hi[kept] = lo[k], hi[k]
            kept += 1
    return kept


@kernel
def _allowed(when: Floats, link: Ints, first: int, t: float) -> float:
    """First time ≥ t at which the robot may depart along an edge, by the rules linked from ``first`` on."""
    again = True
    while again:
        again = False
        k = first
        while k >= 0:
            r = link[k, 0]
            if when[r, 0] <= t < when[r, 1]:
                t = when[r, 1]
                again = True
            k = link[k, 1]
    return t


@kernel
def _shut_from(ground: Ground, edge: int, tau: float, keep_outs: int, desk: Desk) -> float:
    """Time from which keep-outs forbid to depart along the edge."""
    u, v = ground.tails[edge], ground.heads[edge]
    ux, uy = ground.positions[u, 0], ground.positions[u, 1]
    vx, vy = ground.positions[v, 0], ground.positions[v, 1]
    first = inf
    for k in range(keep_outs):
        x, y, d, since = desk.keep_out[k, 0], desk.keep_out[k, 1], desk.keep_out[k, 2], desk.keep_out[k, 3]
        found, _, until = rest_conflict(x, y, ux, uy, 0.0, vx, vy, tau, d)
        if found:
            first = min(first, since - until)
    return first


@kernel
def _come(
    state: Ints,
    leave: Floats,
    arrival: Floats,
    keys: Floats,
    t: int,
    origin: int,
    edge: int,
    depart: float,
    arrive: float,
    key: float,
) -> None:
    """Note how a state is reached best so far."""
    state[t, 1], state[t, 2] = origin, edge
    leave[t], arrival[t], keys[t] = depart, arrive, key


@kernel
def _before(key: Floats, arrive: Floats, s: int, t: int) -> bool:
    """Whether state s is expanded before t: the least key, then whoever has come farther."""
    return bool(key[s] < key[t] or (key[s] == key[t] and arrive[s] > arrive[t]))


@kernel
def _lift(heap: Ints, state: Ints, key: Floats, arrive: Floats, s: int, size: int) -> int:
    """Put a state where its key belongs, or move it up there if it is in the heap already; return the size."""
    i = state[s, 3]
    if i < 0:
        i = size
        size += 1
    while i > 0:
        parent = (i - 1) >> 1
        other = heap[parent]
        if not _before(key, arrive, s, other):
            break
        heap[i], state[other, 3] = other, i
        i = parent
    heap[i], state[s, 3] = s, i
    return size


@kernel
def _drop_first(heap: Ints, state: Ints, key: Floats, arrive: Floats, size: int) -> int:
    state[heap[0], 3] = _DONE
    size -= 1
    if size == 0:
        return size
    s = heap[size]
    i = 0
    while True:
        child = 2 * i + 1
        if child >= size:
            break
        if child + 1 < size and _before(key, arrive, heap[child + 1], heap[child]):
            child += 1
        other = heap[child]
        if not _before(key, arrive, other, s):
            break
        heap[i], state[other, 3] = other, i
        i = child
    heap[i], state[s, 3] = s, i
    return size


@kernel
def _write(desk: Desk, reached: int, steps: Steps, first: int) -> int:
    """Write the steps that lead to a state; return how many, 0 if there is no room."""
    count = 1
    s = reached
    while desk.state[s, 1] >= 0:
        if desk.state[s, 2] >= 0:
            count += 1
        s = desk.state[s, 1]
    if first + count > steps.where.shape[0]:
        return 0
    s = reached
    edge, depart = -1, inf
    k = first + count - 1
    while s >= 0:
        if desk.state[s, 2] >= 0 or desk.state[s, 1] < 0:  # else it only stays where it was, past a landmark
            steps.where[k, 0], steps.where[k, 1] = desk.state[s, 0], edge
            steps.when[k, 0], steps.when[k, 1] = desk.arrive[s], depart
            edge, depart = desk.state[s, 2], desk.leave[s]
            k -= 1
        s = desk.state[s, 1]
    steps.when[first, 0] = 0.0
    return count
