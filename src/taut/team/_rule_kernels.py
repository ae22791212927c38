"""Kernels of rules: what a robot on a roadmap may not do and what it must do, put in order for its search."""

from __future__ import annotations

from math import inf
from typing import NamedTuple, TypeAlias

import numpy as np
from numpy.typing import NDArray

from taut.compiling import kernel

Floats: TypeAlias = NDArray[np.float64]
Ints: TypeAlias = NDArray[np.int64]


class Ground(NamedTuple):
    """A directed graph drawn in the plane; an edge is its position in ``heads``, edges of a vertex are consecutive."""

    positions: Floats  # (n, 2) metres
    indptr: Ints  # (n + 1,)
    heads: Ints  # (m,)
    tails: Ints  # (m,)
    lengths: Floats  # (m,) metres
    limits: Floats  # (m,) greatest metres a second; inf where there is no limit


class Team(NamedTuple):
    """The robots, k of them."""

    starts: Ints
    goals: Ints
    speeds: Floats
    begins: Floats  # (k,) seconds before which a robot may not leave its start
    apart: Floats  # (k, k) metres that the centres of two robots keep from each other
    remaining: Floats  # (k, n) least seconds from a vertex to the robot's goal, inf if there is no way
    leaves: Ints  # (k,) 1 for a robot that is gone from the instant of its arrival, 0 for one that stays


class Rules(NamedTuple):
    """Rules of all robots. Those of one robot are a chain: each names the one given before it."""

    what: Ints  # (rules, 4): kind, place, the rule before (-1: none), how many there are up to this one
    when: Floats  # (rules, 2): since, until


class Steps(NamedTuple):
    """Motions, one after the other: a step is at a vertex from arrive to depart, then takes an edge (-1: it stays)."""

    where: Ints  # (steps, 2): vertex, edge
    when: Floats  # (steps, 2): arrive, depart (inf: it stays)


class Desk(NamedTuple):
    """Room for the search of one robot. Entries of vertices and edges are -1 between searches."""

    first_state: Ints  # (layers n,) of each vertex; layer k is after k landmarks
    how_many: Ints  # (layers n,)
    vertex_rule: Ints  # (n,) the robot's last rule for a vertex, as its place in ``link``
    edge_rule: Ints  # (m,)
    link: Ints  # (K, 2): rule, the robot's next one for the same vertex or edge
    keep_out: Floats  # (K, 4): x, y, metres, since when
    mark: Ints  # (MARKS, 3): kind, place, the vertex where it begins
    mark_time: Floats  # (MARKS, 3): since, until, seconds that are left from that vertex at least
    opens: Floats  # (S,) of states
    closes: Floats
    arrive: Floats
    leave: Floats
    key: Floats
    state: Ints  # (S, 5): vertex, state before, edge from there (-1: the same vertex), place in the heap, layer
    heap: Ints  # (S,)


# Kinds of rules. Times are half-open: [since, until). A robot is at a vertex from its arrival there to its departure,
# both included, also if they are the same instant; at its start from 0 on.
NOT_AT = 0  # it is not at the vertex at any time of [since, until)
NOT_ALONG = 1  # it does not depart along the edge at any time of [since, until)
NOT_THROUGHOUT = 2  # it has not arrived at the vertex before `since` to depart at `until` or later
KEEP_OUT = 3  # it departs along no edge that is near the goal of robot `place` up to a time ≥ `since`, and is at no
#               vertex near that goal at a time ≥ `since`
NOT_BEFORE = 4  # it does not reach its own goal for good before `since`
NOT_AFTER = 5  # it reaches its own goal for good before `until`

# Landmarks: what a robot must do
ALONG = 6  # it departs along the edge at a time of [since, until)
AT = 7  # it is at the vertex at a time of [since, until)
THROUGHOUT = 8  # it has arrived at the vertex before `since` and departs at `until` or later

MARKS = 16  # how many landmarks a robot may have


@kernel
def duration(ground: Ground, team: Team, who: int, edge: int) -> float:
    """Seconds that a robot takes along an edge."""
    return float(ground.lengths[edge] / min(team.speeds[who], ground.limits[edge]))


@kernel
def sort_rules(
    ground: Ground, team: Team, rules: Rules, who: int, last: int, desk: Desk
) -> tuple[int, int, int, float, float]:
    """Put a robot's rules where its search looks for them.

    Returns
    -------
    links, keep_outs, marks : how many rules are linked to vertices and edges, keep-outs, and landmarks in order.
    not_before, not_after : bounds of its arrival.
    """
    links = keep_outs = marks = 0
    not_before, not_after = 0.0, inf
    r = last
    while r >= 0:
        kind, place = rules.what[r, 0], rules.what[r, 1]
        since, until = rules.when[r, 0], rules.when[r, 1]
        if kind in (NOT_AT, NOT_THROUGHOUT):
            desk.link[links, 0], desk.link[links, 1] = r, desk.vertex_rule[place]
            desk.vertex_rule[place] = links
            links += 1
        elif kind == NOT_ALONG:
            desk.link[links, 0], desk.link[links, 1] = r, desk.edge_rule[place]
            desk.edge_rule[place] = links
            links += 1
        elif kind == KEEP_OUT:
            goal = team.goals[place]
            desk.keep_out[keep_outs, 0] = ground.positions[goal, 0]
            desk.keep_out[keep_outs, 1] = ground.positions[goal, 1]
            desk.keep_out[keep_outs, 2] = team.apart[who, place]
            desk.keep_out[keep_outs, 3] = since
            keep_outs += 1
        elif kind == NOT_BEFORE:
            not_before = max(not_before, since)
        elif kind == NOT_AFTER:
            not_after = min(not_after, until)
        else:
            marks = _insert_mark(ground, team, who, kind, place, since, until, marks, desk)
        r = rules.what[r, 2]
    for k in range(marks - 1, -1, -1):
        place = desk.mark[k, 1]
        along = desk.mark[k, 0] == ALONG
        desk.mark[k, 2] = ground.tails[place] if along else place
        ahead, _ = left_from(ground, team, who, ground.heads[place] if along else place, k + 1, marks, desk)
        desk.mark_time[k, 2] = ahead + (duration(ground, team, who, place) if along else 0.0)
    return links, keep_outs, marks, not_before, not_after


@kernel
def clear_rules(rules: Rules, links: int, desk: Desk) -> None:
    """Unlink them from vertices and edges."""
    for k in range(links):
        r = desk.link[k, 0]
        if rules.what[r, 0] == NOT_ALONG:
            desk.edge_rule[rules.what[r, 1]] = -1
        else:
            desk.vertex_rule[rules.what[r, 1]] = -1


@kernel
def left_from(ground: Ground, team: Team, who: int, v: int, layer: int, marks: int, desk: Desk) -> tuple[float, float]:
    """Least seconds from a vertex to the goal past the landmarks from ``layer`` on, and before when it must be there.

    With D the seconds to the goal, u is at least D(v) − D(u) away from v, and no nearer than the straight line.
    """
    remaining = team.remaining[who, v]
    if layer == marks:
        return remaining, inf
    u = desk.mark[layer, 2]
    there = _travel(ground, team, who, v, u)
    latest = desk.mark_time[layer, 0] if desk.mark[layer, 0] == THROUGHOUT else desk.mark_time[layer, 1]
    # a hair later, since the sums are rounded: the landmark itself is tested exactly
    return max(remaining, there + desk.mark_time[layer, 2]), latest - there + 2.0**-40 * (latest + there)


@kernel
def precludes(
    ground: Ground,
    team: Team,
    who: int,
    kind: int,
    place: int,
    since: float,
    until: float,
    other: int,
    its_place: int,
    its_since: float,
    its_until: float,
) -> bool:
    """Whether a robot that begins with the first landmark is too late for the other one."""
    u = ground.heads[place] if kind == ALONG else place
    v = ground.tails[its_place] if other == ALONG else its_place
    done = until if kind == THROUGHOUT else since
    if kind == ALONG:
        done += duration(ground, team, who, place)
    latest = its_since if other == THROUGHOUT else its_until
    return bool(done + _travel(ground, team, who, u, v) >= latest)


@kernel
def certain_order(
    ground: Ground,
    team: Team,
    who: int,
    kind: int,
    place: int,
    since: float,
    until: float,
    other: int,
    its_place: int,
    its_since: float,
    its_until: float,
) -> bool:
    """Whether a search that meets two landmarks one after the other, in the order they allow, misses no motion.

    That is so if one of them precludes the other, unless one departure, or one rest, may be both at once. Departures
    along one edge are both at once for certain if each precludes the other: there is no time for a second one.
    """
    after = precludes(ground, team, who, kind, place, since, until, other, its_place, its_since, its_until)
    before = precludes(ground, team, who, other, its_place, its_since, its_until, kind, place, since, until)
    if place == its_place and kind == ALONG and other == ALONG:
        return (before and after) or until <= its_since or its_until <= since
    if place == its_place and kind != ALONG and other != ALONG and before and after:
        return False
    return before or after


@kernel
def _travel(ground: Ground, team: Team, who: int, u: int, v: int) -> float:
    """Seconds that a robot needs from u to v at least."""
    x, y = ground.positions[u, 0] - ground.positions[v, 0], ground.positions[u, 1] - ground.positions[v, 1]
    straight = np.sqrt(x * x + y * y) / team.speeds[who]
    return float(max(straight, team.remaining[who, u] - team.remaining[who, v]))


@kernel
def _insert_mark(
    ground: Ground, team: Team, who: int, kind: int, place: int, since: float, until: float, marks: int, desk: Desk
) -> int:
    """Put a landmark into the order of the others; return how many there are."""
    k = marks
    while k > 0:
        other, its_place, its_since, its_until = _mark(desk, k - 1)
        if not precludes(ground, team, who, other, its_place, its_since, its_until, kind, place, since, until):
            break
        if precludes(ground, team, who, kind, place, since, until, other, its_place, its_since, its_until):
            if kind != ALONG or other != ALONG or place != its_place:
                break  # nobody can do both
            # one departure, within both times
            since, until = max(its_since, since), min(its_until, until)
            for j in range(k, marks):
                _set_mark(desk, j, *_mark(desk, j + 1))
            k -= 1
            marks -= 1
            break
        _set_mark(desk, k, other, its_place, its_since, its_until)
        k -= 1
    _set_mark(desk, k, kind, place, since, until)
    return marks + 1


@kernel
def _mark(desk: Desk, k: int) -> tuple[int, int, float, float]:
    return desk.mark[k, 0], desk.mark[k, 1], desk.mark_time[k, 0], desk.mark_time[k, 1]


@kernel
def _set_mark(desk: Desk, k: int, kind: int, place: int, since: float, until: float) -> None:
    desk.mark[k, 0], desk.mark[k, 1], desk.mark_time[k, 0], desk.mark_time[k, 1] = kind, place, since, until
