"""Kernels of safe-interval searches for many robots in turn: their roadmaps and distances are kept, work is bounded."""

from __future__ import annotations

from math import hypot, inf, nextafter, sqrt
from typing import NamedTuple

from taut.heap import drop_first, push
from taut.team._asking_kernels import first_departure, forbidden_times, last_departure, merge
from taut.team._conflict_kernels import Floats, Ints
from taut.team._contact_kernels import Partners, in_contact, lonely_times, next_chance
from taut.team._lean import lean_kernel
from taut.team._table_kernels import Table
from taut.team._team_kernels import Team, edges_out

# Among equal keys the queue prefers states, the latest first, then edges, the latest first: straight to the goal where
# many ways are equally short. A hair's weight on the way left does the same where only rounding tells them apart.
_WAYS = 1 << 40
EXACT = 1.0 + 2.0**-30
TOO_LONG, TOO_SMALL = -1, -2
_FEW = 256  # most departures along one edge that are looked at for contact; each rules out all before it


class Desk(NamedTuple):
    """What searches write into, one for each thread; between searches ``away``, ``row`` and ``first`` are blank.

    Parameters
    ----------
    xy : those of the team, with a robot's own after the shared ones while it is planned.
    away, row, first, many : per vertex: seconds to the goal, row of own edges, first state and number of states.
    times : per state: opens, closes, arrive, leave the one before, seconds of the edge from there.
    links : per state: vertex, parent, whether it is expanded.
    ways : per edge out of an expanded state: from state, to vertex, to state next, −1 as long as it has none.
    way_time : its seconds.
    keys, items : the queue.
    lo, hi : forbidden times.
    stamp : per leg, the question that last met it.
    path : vertices of the motion found.
    at : (n, 4) when it arrives there and leaves, x, y.
    stamps : its stamps.
    stuck : (4,) of the last search: x, y of the expanded vertex nearest to the goal, when it was reached, seconds left.
    counts : (5,) mark of the next question, states in use, expansions and departures asked for so far, vertices of
        the motion found.
    """

    xy: Floats
    away: Floats
    row: Ints
    first: Ints
    many: Ints
    times: Floats
    links: Ints
    ways: Ints
    way_time: Floats
    keys: Floats
    items: Ints
    lo: Floats
    hi: Floats
    stamp: Ints
    path: Ints
    at: Floats
    stamps: Floats
    stuck: Floats
    counts: Ints


@lean_kernel
def lay_out(team: Team, i: int, desk: Desk) -> None:
    """Lay what belongs to robot i on the desk."""
    g = team.shared[i]
    n = team.size[g]
    first, last = team.own_first[i], team.own_first[i + 1]
    for k in range(last - first):
        desk.xy[team.place[g] + n + k, 0] = team.own_xy[first + k, 0]
        desk.xy[team.place[g] + n + k, 1] = team.own_xy[first + k, 1]
    for k in range(team.tail_first[i], team.tail_first[i + 1]):
        desk.row[team.tail[k]] = k
    for k in range(team.near_first[i], team.near_first[i + 1]):
        desk.away[team.near[k]] = team.away[k]


@lean_kernel
def clear_away(team: Team, i: int, desk: Desk) -> None:
    """Undo `lay_out`, and forget the states of the search."""
    for k in range(team.tail_first[i], team.tail_first[i + 1]):
        desk.row[team.tail[k]] = -1
    for k in range(team.near_first[i], team.near_first[i + 1]):
        desk.away[team.near[k]] = inf
    for s in range(desk.counts[1]):
        desk.first[desk.links[s, 0]] = -1
    desk.counts[1] = 0


@lean_kernel
def soonest_arrival(
    team: Team,
    i: int,
    table: Table,
    partners: Partners | None,
    desk: Desk,
    limit: float,
    most: int,
    eager: float,
) -> int:
    """Find the motion of robot i that arrives first among the reservations, and no later than ``limit``.

    With ``partners`` it is in contact with enough of them at every instant.

    A* over (vertex, safe interval), moving at top speed or resting at vertices. Source: Phillips and Likhachev, SIPP:
    safe interval path planning for dynamic environments, ICRA 2011; here in continuous time with closed-form
    intervals; edges are compared with reserved legs only when no other way could be better. Earliest up to 1e-9 of its
    duration, as ``eager``, a little more than 1, prefers states near the goal.

    Its stamps are left on the desk; returns how many there are: 0 if there is no such motion, −1 if it takes more than
    ``most`` expansions to find one, −2 if the desk is too small to tell.
    """
    lay_out(team, i, desk)
    xy = desk.xy[team.place[team.shared[i]] :]
    start, goal = team.ends[i, 0], team.ends[i, 1]
    x, y = xy[start, 0], xy[start, 1]
    if x == xy[goal, 0] and y == xy[goal, 1] and _alone(team, i, x, y, table, partners, desk):
        desk.stamps[0, 0], desk.stamps[0, 1], desk.stamps[0, 2] = 0.0, x, y
        count = 1
    else:
        count = _search(team, i, xy, table, partners, desk, limit, most, eager)
        if count > 0:
            count = _traced(team, i, xy, table, partners, desk, count - 1)
        if count > 0:
            count = stamped(desk.at, count, team.motion[i, 0], team.motion[i, 2], desk.stamps)
    clear_away(team, i, desk)
    return count


@lean_kernel
def _alone(team: Team, i: int, x: float, y: float, table: Table, partners: Partners | None, desk: Desk) -> bool:
    """Whether robot i may stay at its start for ever, or need not."""
    count = forbidden_times(
        table, x, y, i, team.body[i, 0], team.body[i, 1], 0.0, inf, desk.lo, desk.hi, desk.stamp, desk.counts[0]
    )
    desk.counts[0] += 1
    if partners is not None and count == 0:
        count = lonely_times(partners, x, y, 0.0, inf, desk.lo, desk.hi, 0)
    return count == 0 or team.rules[i, 0] == 0


@lean_kernel
def _open(
    v: int,
    xy: Floats,
    table: Table,
    partners: Partners | None,
    who: int,
    apart: float,
    headway: float,
    begin: float,
    end: float,
    desk: Desk,
) -> bool:
    """Make the states of a vertex, one for each safe interval between two times; False if there is no room for them."""
    lo, hi = desk.lo, desk.hi
    count = forbidden_times(
        table, xy[v, 0], xy[v, 1], who, apart, headway, begin, end, lo, hi, desk.stamp, desk.counts[0]
    )
    desk.counts[0] += 1
    if partners is not None and count >= 0:
        count = lonely_times(partners, xy[v, 0], xy[v, 1], begin, end, lo, hi, count)
        if count > 0:
            count = merge(lo, hi, count)
    states = desk.counts[1]
    if count < 0 or states + count + 1 > desk.times.shape[0]:
        return False
    desk.first[v] = states
    free_from = 0.0
    for k in range(count + 1):
        until = lo[k] if k < count else inf
        if until >= free_from and free_from < inf:
            desk.times[states, 0], desk.times[states, 1], desk.times[states, 2] = free_from, until, inf
            desk.links[states, 0], desk.links[states, 1], desk.links[states, 2] = v, -1, 0
            states += 1
        if k < count:
            free_from = max(free_from, hi[k])
    desk.many[v] = states - desk.first[v]
    if states == desk.first[v]:
        # taken for ever: one state that nobody can reach keeps the vertex from being asked about again
        desk.times[states, 0], desk.times[states, 1], desk.times[states, 2] = inf, -inf, -inf
        desk.links[states, 0], desk.links[states, 1], desk.links[states, 2] = v, -1, 1
        desk.many[v] = 1
        states += 1
    desk.counts[1] = states
    return True


@lean_kernel
def _search(
    team: Team,
    i: int,
    xy: Floats,
    table: Table,
    partners: Partners | None,
    desk: Desk,
    limit: float,
    most: int,
    eager: float,
) -> int:
    """Find the state in which robot i reaches its goal; 1 more than its number, else as in `soonest_arrival`."""
    start, goal = team.ends[i, 0], team.ends[i, 1]
    apart, headway = team.body[i, 0], team.body[i, 1]
    speed, since = team.motion[i, 0], team.motion[i, 1]
    stays, pinched_start, pinched_goal = team.rules[i, 0], team.rules[i, 1], team.rules[i, 2]
    beyond = team.beyond[i]
    sx, sy, gx, gy = xy[start, 0], xy[start, 1], xy[goal, 0], xy[goal, 1]
    times, links, ways, way_time = desk.times, desk.links, desk.ways, desk.way_time
    keys, items, away, row = desk.keys, desk.items, desk.away, desk.row
    first, many, counts, stuck = desk.first, desk.many, desk.counts, desk.stuck
    room = min(keys.shape[0], way_time.shape[0]) - 1

    stuck[0], stuck[1], stuck[2], stuck[3] = sx, sy, since, inf
    if not _open(goal, xy, table, partners, i, apart, headway, 0.0 if start == goal else since, inf, desk):
        return TOO_SMALL
    last = counts[1] - 1
    if stays == 1 and not (times[last, 1] == inf and times[last, 0] <= limit):
        return 0
    if start != goal and not _open(start, xy, table, partners, i, apart, headway, 0.0, limit, desk):
        return TOO_SMALL
    size = 0
    for s in range(first[start], first[start] + many[start]):
        # only the interval in which the robot already stands there
        if times[s, 0] <= 0.0 and times[s, 1] >= since:
            times[s, 2] = since
            keys[0], items[0] = since, -1 - s
            size = 1
    count = 0
    pops = 0
    reached = 0
    while size > 0:
        if pops >= most:
            reached = TOO_LONG
            break
        item = items[0]
        drop_first(keys, items, size)
        size -= 1
        if item >= 0:
            w = _WAYS - item
            origin, v, s = ways[w, 0], ways[w, 1], ways[w, 2]
            tau = way_time[w]
            ready = times[origin, 2]
            left = _left(v, xy, away[v], beyond, speed, sx, sy, gx, gy)
            if s < 0:
                # whoever comes later comes no sooner, and nobody stays longer
                begin = (1.0 - 2.0**-20) * (ready + tau)
                if first[v] < 0 and not _open(v, xy, table, partners, i, apart, headway, begin, limit - left, desk):
                    reached = TOO_SMALL
                    break
                s = first[v] - 1
            elif links[s, 2] == 0:
                soonest = max(ready, times[s, 0] - tau)
                latest = min(min(times[origin, 1], times[s, 1] - tau), limit - left - tau)
                if soonest <= latest and soonest + tau < times[s, 2]:
                    u = links[origin, 0]
                    edge = xy[u, 0], xy[u, 1], xy[v, 0], xy[v, 1]
                    delta = first_departure(table, edge, tau, soonest, latest, i, apart, headway)
                    if partners is not None:
                        tries = 0
                        while delta < inf:
                            chance = next_chance(partners, edge, tau, delta, latest)
                            if chance == delta:
                                break
                            tries += 1
                            if tries == _FEW or not chance <= latest:
                                delta = inf
                            else:
                                delta = first_departure(table, edge, tau, chance, latest, i, apart, headway)
                    counts[3] += 1
                    when = max(delta + tau, times[s, 0])
                    if when < times[s, 2]:
                        times[s, 2], times[s, 3], times[s, 4] = when, delta, tau
                        links[s, 1] = origin
                        if size == room:
                            reached = TOO_SMALL
                            break
                        push(keys, items, size, when + eager * left, -1 - s)
                        size += 1
            ways[w, 2], soonest = _next_interval(times, links, s + 1, first[v] + many[v], origin, tau, limit - left)
            if soonest < inf:
                if size == room:
                    reached = TOO_SMALL
                    break
                push(keys, items, size, soonest + eager * left, _WAYS - w)
                size += 1
            continue
        item = -1 - item
        if links[item, 2] == 1:
            continue
        links[item, 2] = 1
        pops += 1
        u = links[item, 0]
        if u == goal and (stays == 0 or times[item, 1] == inf):
            reached = item + 1
            break
        if u == goal and pinched_goal == 1:
            continue
        ready = times[item, 2]
        left = _left(u, xy, away[u], beyond, speed, sx, sy, gx, gy)
        if left < stuck[3]:
            stuck[0], stuck[1], stuck[2], stuck[3] = xy[u, 0], xy[u, 1], ready, left
        for layer in range(2):
            begin_edge, end_edge = edges_out(team, i, u, row[u], layer)
            if size + end_edge - begin_edge > room or count + end_edge - begin_edge > room:
                reached = TOO_SMALL
                break
            for k in range(begin_edge, end_edge):
                v = team.heads[k] if layer == 0 else team.edge_to[k]
                if v == start and pinched_start == 1:
                    continue
                tau = team.lengths[k] / min(speed, team.limits[k]) if layer == 0 else team.edge_length[k] / speed
                left = _left(v, xy, away[v], beyond, speed, sx, sy, gx, gy)
                s, soonest = -1, ready + tau
                if first[v] >= 0:
                    s, soonest = _next_interval(times, links, first[v], first[v] + many[v], item, tau, limit - left)
                if soonest + left <= limit and soonest < inf:
                    count += 1
                    ways[count, 0], ways[count, 1], ways[count, 2] = item, v, s
                    way_time[count] = tau
                    push(keys, items, size, soonest + eager * left, _WAYS - count)
                    size += 1
        if reached == TOO_SMALL:
            break
    counts[2] += pops
    return reached


@lean_kernel
def _next_interval(
    times: Floats, links: Ints, s: int, end: int, origin: int, tau: float, limit: float
) -> tuple[int, float]:
    """First of the states s … end − 1 that may be reached sooner than it is, and the soonest; inf if there is none.

    So only one interval of a vertex waits in the queue for each edge: those after it come no sooner.
    """
    ready, closes = times[origin, 2], times[origin, 1]
    while s < end:
        soonest = max(ready + tau, times[s, 0])
        if soonest - tau > closes or soonest > limit:
            break
        if links[s, 2] == 0 and soonest < times[s, 2] and times[s, 1] >= soonest:
            return s, soonest
        s += 1
    return end, inf


@lean_kernel
def _left(
    v: int, xy: Floats, away: float, beyond: float, speed: float, sx: float, sy: float, gx: float, gy: float
) -> float:
    """Seconds to the goal, or no more than that: exact near the robot's way, consistent beyond."""
    if away < inf:
        return away
    straight = sqrt((xy[v, 0] - gx) ** 2 + (xy[v, 1] - gy) ** 2) / speed
    return max(straight, beyond - sqrt((xy[v, 0] - sx) ** 2 + (xy[v, 1] - sy) ** 2) / speed)


@lean_kernel
def _traced(team: Team, i: int, xy: Floats, table: Table, partners: Partners | None, desk: Desk, reached: int) -> int:
    """Write the vertices of a motion with arrivals and departures; rests are put as late as the arrival allows."""
    apart, headway = team.body[i, 0], team.body[i, 1]
    times, links, path, at = desk.times, desk.links, desk.path, desk.at
    length = 1
    s = reached
    while links[s, 1] >= 0:
        s = links[s, 1]
        length += 1
    if length > path.shape[0]:
        return TOO_SMALL
    desk.counts[4] = length
    path[length - 1] = links[reached, 0]
    at[length - 1, 0] = at[length - 1, 1] = times[reached, 2]
    after = reached
    for k in range(length - 2, -1, -1):
        s = links[after, 1]
        u, v = links[s, 0], links[after, 0]
        delta, tau = times[after, 3], times[after, 4]
        latest = min(at[k + 1, 1] - tau, times[s, 1])
        if latest > delta:
            edge = xy[u, 0], xy[u, 1], xy[v, 0], xy[v, 1]
            later = last_departure(table, edge, tau, delta, latest, i, apart, headway)
            if partners is None:
                delta = max(delta, later)
            elif later > delta and in_contact(partners, edge, tau, later):
                delta = later
        path[k], at[k, 1] = u, delta
        at[k + 1, 0] = max(delta + tau, times[after, 0])
        at[k + 1, 1] = max(at[k + 1, 0], at[k + 1, 1])
        after = s
    at[0, 0] = 0.0
    for k in range(length):
        at[k, 2], at[k, 3] = xy[path[k], 0], xy[path[k], 1]
    return length


@lean_kernel
def stamped(at: Floats, length: int, speed: float, tol: float, rows: Floats) -> int:
    """Write the stamps of a motion, without the rests and the bends that only rounding makes (below tol / 64).

    ``at`` (n, 4) are its vertices: when it arrives and leaves, x, y. Returns how many stamps there are.
    """
    rows[0, 0], rows[0, 1], rows[0, 2] = 0.0, at[0, 2], at[0, 3]
    count = 1
    for k in range(length):
        x, y = at[k, 2], at[k, 3]
        for side in range(2):
            t = at[k, side]
            if (t - rows[count - 1, 0]) * speed <= tol / 64:
                continue
            while count > 1 and _on_the_way(rows, count, t, x, y, tol / 64):
                count -= 1
            before = rows[count - 1, 0]
            way = hypot(x - rows[count - 1, 1], y - rows[count - 1, 2])
            if way > speed * (t - before):  # rounding must not make it faster than it can be
                t = nextafter(max(t, before + way / speed), inf)
            rows[count, 0], rows[count, 1], rows[count, 2] = t, x, y
            count += 1
    return count


@lean_kernel
def _on_the_way(rows: Floats, count: int, t: float, x: float, y: float, slack: float) -> bool:
    """Whether a steady move from the last stamp but one to (x, y) at t is within ``slack`` metres of the last."""
    f = (rows[count - 1, 0] - rows[count - 2, 0]) / (t - rows[count - 2, 0])
    ex = rows[count - 2, 1] + f * (x - rows[count - 2, 1]) - rows[count - 1, 1]
    ey = rows[count - 2, 2] + f * (y - rows[count - 2, 2]) - rows[count - 1, 2]
    return hypot(ex, ey) <= slack
