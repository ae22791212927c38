"""Kernels of a team in arrays: every robot's roadmap, and how far each vertex near its way is from its goal."""

from __future__ import annotations

from math import inf, sqrt
from typing import NamedTuple

import numpy as np

from taut.arrays import longer
from taut.compiling import kernel
from taut.heap import drop_first, push
from taut.team._conflict_kernels import Floats, Ints
from taut.team._lean import lean_kernel

_SLACK = 1.03  # most robots are delayed less; searches of those that are not look a little farther than they must


class Team(NamedTuple):
    """Robots and their roadmaps; vertices are numbered per robot: the shared ones, then its own.

    Parameters
    ----------
    body : (r, 3) radius and gap in planning together, headway, radius; metres and seconds.
    motion : (r, 3) speed, start time, tol.
    rules : (r, 3) whether it stays at its goal, and whether free space touches itself at its start, at its goal.
    ends : (r, 2) vertices that are its start and its goal.
    shared : (r,) number of its shared roadmap.
    size : (g,) vertices of each shared roadmap.
    place : (g,) its first row in ``xy``.
    xy : (m, 2) positions of the shared roadmaps, each followed by room for a robot's own vertices.
    row : (g,) its first row in ``out`` and ``into``.
    out, heads, lengths, limits : arcs of all shared roadmaps, one after another, by their tails (CSR); metres, and
        metres a second.
    into, tails, lengths_into, limits_into : the same arcs by their heads.
    own_first, own_xy : (r + 1,), (k, 2) each robot's own vertices.
    tail_first, tail, edge_first, edge_to, edge_length : own edges of each robot, which lead both ways: edge_first[k] …
        are those out of its vertex tail[k], where k runs from tail_first[robot].
    near_first, near, away, beyond : vertices near its way, their seconds to its goal, and the least seconds of any way
        from start to goal through another vertex, (r,).
    least : (r,) least cost on its roadmap, seconds.
    """

    body: Floats
    motion: Floats
    rules: Ints
    ends: Ints
    shared: Ints
    size: Ints
    place: Ints
    xy: Floats
    row: Ints
    out: Ints
    heads: Ints
    lengths: Floats
    limits: Floats
    into: Ints
    tails: Ints
    lengths_into: Floats
    limits_into: Floats
    own_first: Ints
    own_xy: Floats
    tail_first: Ints
    tail: Ints
    edge_first: Ints
    edge_to: Ints
    edge_length: Floats
    near_first: Ints
    near: Ints
    away: Floats
    beyond: Floats
    least: Floats


@kernel
def distances(team: Team, i: int, enough: float) -> tuple[Ints, Floats, float, float]:
    """Seconds to the goal of robot i from all vertices through which a way from its start is quicker than needed.

    Needed are ``enough`` seconds, and a little more than its quickest way takes. Returns the vertices, their seconds, a
    lower bound on the ways through others, and the seconds from its start (inf if there is no way).
    """
    n = team.size[team.shared[i]]
    total = n + team.own_first[i + 1] - team.own_first[i]
    start, goal, speed = team.ends[i, 0], team.ends[i, 1], team.motion[i, 0]
    away = np.full(total, inf)
    settled = np.zeros(total, dtype=np.int64)
    row = np.full(total, -1, dtype=np.int64)
    for k in range(team.tail_first[i], team.tail_first[i + 1]):
        row[team.tail[k]] = k
    sx, sy = position(team, i, start)
    keys, items = np.empty(1024), np.empty(1024, dtype=np.int64)
    away[goal] = 0.0
    keys[0], items[0] = 0.0, goal
    size = 1
    order = np.empty(total, dtype=np.int64)
    count = 0
    beyond = inf
    while size > 0:
        key, u = keys[0], items[0]
        if key > enough and settled[start] == 1:
            beyond = key
            break
        drop_first(keys, items, size)
        size -= 1
        if settled[u] == 1:
            continue
        settled[u] = 1
        order[count] = u
        count += 1
        if u == start:
            enough = max(enough, _SLACK * away[start])
        for layer in range(2):
            begin, end = _edges_into(team, i, u, row[u], layer)
            for k in range(begin, end):
                v = team.tails[k] if layer == 0 else team.edge_to[k]
                if layer == 0:
                    through = away[u] + team.lengths_into[k] / min(speed, team.limits_into[k])
                else:
                    through = away[u] + team.edge_length[k] / speed
                if through < away[v]:
                    away[v] = through
                    x, y = position(team, i, v)
                    if size == keys.shape[0]:
                        keys, items = longer(keys), longer(items)
                    push(keys, items, size, through + sqrt((x - sx) ** 2 + (y - sy) ** 2) / speed, v)
                    size += 1
    near = np.sort(order[:count])
    return near, away[near], beyond, away[start]


@lean_kernel
def edges_out(team: Team, i: int, u: int, own_row: int, layer: int) -> tuple[int, int]:
    """First and last + 1 of the edges out of a vertex: in layer 0 the shared ones, in layer 1 those of robot i."""
    g = team.shared[i]
    if layer == 0 and u < team.size[g]:
        return team.out[team.row[g] + u], team.out[team.row[g] + u + 1]
    if layer == 1 and own_row >= 0:
        return team.edge_first[own_row], team.edge_first[own_row + 1]
    return 0, 0


@lean_kernel
def _edges_into(team: Team, i: int, u: int, own_row: int, layer: int) -> tuple[int, int]:
    g = team.shared[i]
    if layer == 0 and u < team.size[g]:
        return team.into[team.row[g] + u], team.into[team.row[g] + u + 1]
    if layer == 1 and own_row >= 0:
        return team.edge_first[own_row], team.edge_first[own_row + 1]
    return 0, 0


@lean_kernel
def position(team: Team, i: int, v: int) -> tuple[float, float]:
    """Where a vertex of robot i is."""
    g = team.shared[i]
    if v < team.size[g]:
        return team.xy[team.place[g] + v, 0], team.xy[team.place[g] + v, 1]
    k = team.own_first[i] + v - team.size[g]
    return team.own_xy[k, 0], team.own_xy[k, 1]
