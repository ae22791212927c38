"""Kernels of the safe-interval search: a robot's earliest arrival among reservations."""

from __future__ import annotations

from math import inf
from typing import TypeAlias

import numpy as np
from numpy.typing import NDArray

from taut.arrays import longer
from taut.compiling import kernel
from taut.heap import drop_first, push
from taut.team._reservation_kernels import (
    Reserved,
    earliest_departure,
    edge_conflicts,
    last_free,
    place_conflicts,
)

Floats: TypeAlias = NDArray[np.float64]
Ints: TypeAlias = NDArray[np.int64]
Flags: TypeAlias = NDArray[np.bool_]
Adjacency: TypeAlias = tuple[Ints, Ints, Floats]


@kernel
def _settle(
    v: int,
    base: Adjacency,
    over: Adjacency,
    positions: Floats,
    start: int,
    distance: Floats,
    settled: Flags,
    keys: Floats,
    items: Ints,
    size: int,
) -> int:
    """Continue the backward search from the goal until the distance of v is exact (or v is found to be unreachable)."""
    n_base = base[0].shape[0] - 1
    sx, sy = positions[start, 0], positions[start, 1]
    while size > 0 and not settled[v]:
        u = items[0]
        drop_first(keys, items, size)
        size -= 1
        if settled[u]:
            continue
        settled[u] = True
        for layer in range(2):
            if layer == 0 and u >= n_base:
                continue
            indptr, indices, lengths = base if layer == 0 else over
            for k in range(indptr[u], indptr[u + 1]):
                w = indices[k]
                through = distance[u] + lengths[k]
                if through < distance[w] and not settled[w]:
                    distance[w] = through
                    ahead = np.sqrt((positions[w, 0] - sx) ** 2 + (positions[w, 1] - sy) ** 2)
                    push(keys, items, size, through + ahead, w)
                    size += 1
    return size


@kernel
def safe_interval_search(
    base: Adjacency,
    over: Adjacency,
    positions: Floats,
    reserved: Reserved,
    who: int,
    body: Floats,
    speed: float,
    leave_after: float,
    stays: bool,
    start: int,
    goal: int,
    pinched: tuple[bool, bool],
) -> tuple[bool, Ints, Floats, Floats, int, float, int]:
    """Earliest arrival by A* over (vertex, safe interval), moving at top speed or resting at vertices.

    Source: Phillips and Likhachev, SIPP: safe interval path planning for dynamic environments, ICRA 2011; here in
    continuous time with closed-form intervals, and edges examined only when their tail is expanded.

    Parameters
    ----------
    base, over : CSR (indptr, indices, lengths) of the shared roadmap and of this robot's own vertices and edges.
    positions : (n, 2) of all vertices, the shared ones first.
    who, body : the robot's number, and (radius, gap in planning, headway).
    speed, leave_after, stays : metres a second; seconds before which it may not leave; whether it stays at its goal.
    pinched : whether free space touches itself at the start, and at the goal. Such an end belongs to all sides, so
        nothing leads back to it or on from it: that would be a way from one side to another.

    Returns
    -------
    found, vertices, arrive, depart : the motion; the robot leaves vertices[k] at depart[k]; rests are put as late as
        the arrival allows at no vertex but the first that can take them.
    stuck, time, pops : the expanded vertex nearest to the goal and its arrival, and the number of expansions.
    """
    n_base = base[0].shape[0] - 1
    n = positions.shape[0]
    gx, gy = positions[goal, 0], positions[goal, 1]

    distance = np.full(n, inf)
    settled = np.zeros(n, dtype=np.bool_)
    back_size = base[1].shape[0] + over[1].shape[0] + 1
    back_keys = np.empty(back_size)
    back_items = np.empty(back_size, dtype=np.int64)
    distance[goal] = 0.0
    back_keys[0], back_items[0] = 0.0, goal
    back_size = 1

    # states: one for each safe interval of each vertex met; those of one vertex are consecutive and in order of time
    of_vertex = np.full(n, -1, dtype=np.int64)
    how_many = np.zeros(n, dtype=np.int64)
    states = 0
    vertex = np.empty(1024, dtype=np.int64)
    opens = np.empty(1024)
    closes = np.empty(1024)
    arrive = np.empty(1024)
    leave = np.empty(1024)
    parent = np.empty(1024, dtype=np.int64)
    done = np.empty(1024, dtype=np.int64)
    # ways: edges out of expanded states that have not been tested for conflicts yet
    ways = 0
    way_from = np.empty(1024, dtype=np.int64)
    way_to = np.empty(1024, dtype=np.int64)
    way_time = np.empty(1024)

    lo = np.empty(64)
    hi = np.empty(64)
    stamp = np.full(reserved[0].shape[0], -1, dtype=np.int64)
    mark = 0
    # the queue holds states by their numbers, and ways w as −1 − w with the arrival they would have without conflicts
    keys = np.empty(1024)
    items = np.empty(1024, dtype=np.int64)
    keys[0], items[0] = leave_after, -1
    size = 1
    way_from[0], way_to[0], way_time[0] = -1, start, 0.0
    ways = 1
    pops = 0
    best, best_left = -1, inf
    reached = -1

    while size > 0:
        key, item = keys[0], items[0]
        drop_first(keys, items, size)
        size -= 1
        if item < 0:
            origin, v, tau = way_from[-1 - item], way_to[-1 - item], way_time[-1 - item]
            ready = leave_after if origin < 0 else arrive[origin]
            if not settled[v]:
                back_size = _settle(
                    v, base, over, positions, start, distance, settled, back_keys, back_items, back_size
                )
                if not settled[v]:
                    continue
            left = distance[v] / speed
            if ready + tau + left > key and origin >= 0:
                push(keys, items, size, ready + tau + left, item)
                size += 1
                continue
            if of_vertex[v] < 0:
                lo, hi, count = place_conflicts(
                    positions[v, 0], positions[v, 1], reserved, who, body, lo, hi, stamp, mark
                )
                mark += 1
                while states + count + 1 > vertex.shape[0]:
                    vertex, parent, done = longer(vertex), longer(parent), longer(done)
                    opens, closes = longer(opens), longer(closes)
                    arrive, leave = longer(arrive), longer(leave)
                of_vertex[v] = states
                free_from = 0.0
                for i in range(count + 1):
                    until = lo[i] if i < count else inf
                    if until >= free_from and free_from < inf:
                        vertex[states], opens[states], closes[states] = v, free_from, until
                        arrive[states], leave[states], parent[states], done[states] = inf, inf, -1, 0
                        states += 1
                    if i < count:
                        free_from = max(free_from, hi[i])
                how_many[v] = states - of_vertex[v]
            for s in range(of_vertex[v], of_vertex[v] + how_many[v]):
                if origin < 0:
                    # at the start: only the interval in which the robot already stands there
                    if opens[s] > 0.0 or closes[s] < leave_after:
                        continue
                    arrive[s] = leave_after
                else:
                    soonest = max(ready, opens[s] - tau)
                    latest = min(closes[origin], closes[s] - tau)
                    if done[s] == 1 or soonest > latest or soonest + tau >= arrive[s]:
                        continue
                    u = vertex[origin]
                    edge = positions[u, 0], positions[u, 1], positions[v, 0], positions[v, 1]
                    delta, lo, hi, mark = earliest_departure(
                        edge, tau, soonest, latest, reserved, who, body, lo, hi, stamp, mark
                    )
                    if delta == inf or delta + tau >= arrive[s]:
                        continue
                    arrive[s], leave[s], parent[s] = max(delta + tau, opens[s]), delta, origin
                if size == keys.shape[0]:
                    keys, items = longer(keys), longer(items)
                push(keys, items, size, arrive[s] + left, s)
                size += 1
            continue
        if done[item] == 1:
            continue
        done[item] = 1
        pops += 1
        u = vertex[item]
        if distance[u] < best_left:
            best, best_left = item, distance[u]
        if u == goal and (not stays or closes[item] == inf):
            reached = item
            break
        ready = arrive[item]
        for layer in range(2):
            if (layer == 0 and u >= n_base) or (u == goal and pinched[1]):
                continue
            indptr, indices, lengths = base if layer == 0 else over
            for k in range(indptr[u], indptr[u + 1]):
                v = indices[k]
                if v == start and pinched[0]:
                    continue
                tau = lengths[k] / speed
                useful = of_vertex[v] < 0
                for s in range(of_vertex[v], of_vertex[v] + how_many[v]):
                    if done[s] == 0 and max(ready + tau, opens[s]) < arrive[s] and closes[s] >= ready + tau:
                        useful = True
                        break
                if not useful:
                    continue
                straight = np.sqrt((positions[v, 0] - gx) ** 2 + (positions[v, 1] - gy) ** 2)
                left = distance[v] if settled[v] else straight
                if ways == way_from.shape[0]:
                    way_from, way_to, way_time = longer(way_from), longer(way_to), longer(way_time)
                way_from[ways], way_to[ways], way_time[ways] = item, v, tau
                if size == keys.shape[0]:
                    keys, items = longer(keys), longer(items)
                push(keys, items, size, ready + tau + left / speed, -1 - ways)
                size += 1
                ways += 1

    if reached < 0:
        where = vertex[best] if best >= 0 else start
        when = arrive[best] if best >= 0 else 0.0
        nothing = np.empty(0)
        return False, np.empty(0, dtype=np.int64), nothing, nothing, where, when, pops

    length = 1
    s = reached
    while parent[s] >= 0:
        s = parent[s]
        length += 1
    path = np.empty(length, dtype=np.int64)
    s = reached
    for i in range(length - 1, -1, -1):
        path[i] = s
        s = parent[s]
    out_vertex = np.empty(length, dtype=np.int64)
    out_arrive = np.empty(length)
    out_depart = np.empty(length)
    out_arrive[length - 1] = out_depart[length - 1] = arrive[reached]
    out_vertex[length - 1] = goal
    # from the goal backwards every departure is put as late as the next one allows: rests gather at the start
    for i in range(length - 2, -1, -1):
        s, after = path[i], path[i + 1]
        u, v = vertex[s], vertex[after]
        tau = _edge_time(base, over, n_base, u, v, speed)
        latest = min(out_depart[i + 1] - tau, closes[s])
        delta = leave[after]
        if latest > delta:
            edge = positions[u, 0], positions[u, 1], positions[v, 0], positions[v, 1]
            lo, hi, count = edge_conflicts(edge, tau, delta, latest, reserved, who, body, lo, hi, stamp, mark)
            mark += 1
            delta = max(delta, last_free(lo, hi, count, latest))
        out_vertex[i], out_depart[i] = u, delta
        out_arrive[i + 1] = max(delta + tau, opens[after])
        if out_depart[i + 1] < out_arrive[i + 1]:
            out_depart[i + 1] = out_arrive[i + 1]
    out_arrive[0] = 0.0
    return True, out_vertex, out_arrive, out_depart, goal, arrive[reached], pops


@kernel
def _edge_time(base: Adjacency, over: Adjacency, n_base: int, u: int, v: int, speed: float) -> float:
    best = inf
    if u < n_base:
        for k in range(base[0][u], base[0][u + 1]):
            if base[1][k] == v:
                best = min(best, base[2][k])
    for k in range(over[0][u], over[0][u + 1]):
        if over[1][k] == v:
            best = min(best, over[2][k])
    return best / speed
