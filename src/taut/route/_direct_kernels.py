"""Kernels of the direct search: shortest paths straight through a triangulation, by intervals, without a graph.

A *cone* is what its root, the start or a corner where the path bends, sees through one edge. It is a row: the triangle
it enters, the edge by which it enters, root, right limit, left limit. A limit is the vertex whose ray from the root
bounds the cone, or `_BEND`: the ray on which the path came to the root, drawn on. So every question of sides is one of
orientation among given points and is answered exactly; rounded crossings appear in lower bounds only, and lower them.
A row with `_SWEEP` as one limit is a corner that has still to look round to that side.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from taut.arrays import higher, longer
from taut.compiling import kernel
from taut.geometry._kernels import orient
from taut.geometry._seeing_kernels import roots as roots_of
from taut.heap import drop_first, push

Floats = NDArray[np.float64]
Ints = NDArray[np.int64]

_BEND = -1
_SWEEP = -2


@kernel
def search_pairs(
    xy: Floats,
    tri: Ints,
    nbr: Ints,
    parts: Ints,
    fan: Ints,
    wedge_of: Ints,
    turns: Ints,
    vertex_start: Ints,
    vertex_wedges: Ints,
    given: Floats,
    places: Floats,
    triangles: Ints,
    first: int,
    last: int,
) -> tuple[Floats, Ints, Ints, Floats]:
    """Find shortest paths of the pairs [first, last); pair i goes from place 2i to place 2i + 1.

    ``triangles`` contain the ``places``; the paths end at ``given``, which are the same but for rounding.

    Returns
    -------
    length : (k,) inf where nothing connects the pair.
    expanded : (k,) rows taken up by the search.
    start, points : CSR of the paths' points, none where nothing connects the pair.
    """
    length = np.full(last - first, np.inf)
    expanded = np.zeros(last - first, dtype=np.int64)
    start = np.zeros(last - first + 1, dtype=np.int64)
    points = np.empty((64, 2))
    count = 0
    holds_goal = np.full(tri.shape[0], -1, dtype=np.int64)  # the latest pair whose goal is in the triangle …
    leads_there = np.full(tri.shape[0], -1, dtype=np.int64)  # … and in the part
    shortest = np.full(fan.shape[0], np.inf)  # way from the start to each wedge's corner, as far as known
    bends = np.empty((64, 2), dtype=np.int64)  # of each root: the root before it, its wedge
    at = np.empty((64, 3))  # of each root: x, y, way from the start
    rows = np.empty((256, 5), dtype=np.int64)
    keys = np.empty(256)
    items = np.empty(256, dtype=np.int64)
    holders = np.empty(16, dtype=np.int64)
    for i in range(first, last):
        sx, sy = places[2 * i, 0], places[2 * i, 1]
        qx, qy = places[2 * i + 1, 0], places[2 * i + 1, 1]
        held = roots_of(xy, tri, nbr, fan, vertex_start, vertex_wedges, triangles[2 * i + 1], qx, qy, holders)
        while held > holders.shape[0]:
            holders = longer(holders)
            held = roots_of(xy, tri, nbr, fan, vertex_start, vertex_wedges, triangles[2 * i + 1], qx, qy, holders)
        for h in range(held):
            t = holders[h]
            holds_goal[t] = i
            leads_there[parts[t]] = i
        bends[0, 0], bends[0, 1] = -1, -1
        at[0, 0], at[0, 1], at[0, 2] = sx, sy, 0.0
        size = 0
        end = -1
        held = roots_of(xy, tri, nbr, fan, vertex_start, vertex_wedges, triangles[2 * i], sx, sy, holders)
        while held > holders.shape[0]:
            holders = longer(holders)
            held = roots_of(xy, tri, nbr, fan, vertex_start, vertex_wedges, triangles[2 * i], sx, sy, holders)
        for h in range(held):
            t = holders[h]
            if holds_goal[t] == i:
                end = 0
            if leads_there[parts[t]] != i:
                continue
            if size + 3 > rows.shape[0]:
                rows, keys, items = higher(rows), longer(keys), longer(items)
            for k in range(3):
                right, left = tri[t, k], tri[t, (k + 1) % 3]
                if orient(sx, sy, xy[right, 0], xy[right, 1], xy[left, 0], xy[left, 1]) > 0.0:
                    s, j = _entered(tri, nbr, holds_goal, i, t, k)
                    if s >= 0:
                        f = _least(xy, tri, s, j, right, left, sx, sy, sx, sy, qx, qy)
                        _put(rows, keys, items, size, size, f, s, j, 0, right, left)
                        size += 1
        if end < 0 and size > 0:
            whole, roots, filled, steps, over = np.inf, 1, size, 0, False
            while not over:
                whole, end, roots, filled, size, steps, over = _search(
                    xy,
                    tri,
                    nbr,
                    fan,
                    wedge_of,
                    turns,
                    holds_goal,
                    i,
                    qx,
                    qy,
                    shortest,
                    bends,
                    at,
                    rows,
                    keys,
                    items,
                    whole,
                    end,
                    roots,
                    filled,
                    size,
                    steps,
                )
                if not over:
                    rows, keys, items = higher(rows), longer(keys), longer(items)
                    bends, at = higher(bends), higher(at)
            expanded[i - first] = steps
            for r in range(1, roots):
                shortest[bends[r, 1]] = np.inf
        if end >= 0:
            while count + bends.shape[0] + 2 > points.shape[0]:
                points = higher(points)
            length[i - first], count = _write_path(given, i, bends, at, end, points, count)
        start[i - first + 1] = count
    return length, expanded, start, points[:count].copy()


@kernel
def _search(
    xy: Floats,
    tri: Ints,
    nbr: Ints,
    fan: Ints,
    wedge_of: Ints,
    turns: Ints,
    holds_goal: Ints,
    pair: int,
    qx: float,
    qy: float,
    shortest: Floats,
    bends: Ints,
    at: Floats,
    rows: Ints,
    keys: Floats,
    items: Ints,
    whole: float,
    end: int,
    roots: int,
    filled: int,
    size: int,
    expanded: int,
) -> tuple[float, int, int, int, int, int, bool]:
    """Take up the queued rows, those of least length first, until none can beat the best path to the goal.

    Returns the length of that path, its last root (−1 if there is none), how many roots and rows there are, how many
    are queued and were taken up, and whether the search is over. If not, it wants larger arrays to go on with: here
    they stay what they are, for arrays replaced in a loop cost more than the search.
    """
    at_hand = False
    t = k = root = right = left = 0
    px = py = way = ox = oy = 0.0
    while True:
        if filled + 4 > rows.shape[0] or roots == bends.shape[0]:
            if at_hand:
                _put(rows, keys, items, filled, size, -np.inf, t, k, root, right, left)
                filled += 1
                size += 1
            return whole, end, roots, filled, size, expanded, False
        if not at_hand:
            if size == 0 or keys[0] >= whole:
                return whole, end, roots, filled, size, expanded, True
            row = items[0]
            drop_first(keys, items, size)
            size -= 1
            t, k, root, right, left = rows[row, 0], rows[row, 1], rows[row, 2], rows[row, 3], rows[row, 4]
            px, py, way = at[root, 0], at[root, 1], at[root, 2]
            if root > 0:
                if way > shortest[bends[root, 1]]:
                    continue
                ox, oy = at[bends[root, 0], 0], at[bends[root, 0], 1]
        expanded += 1
        k_right, k_left = (k + 1) % 3, (k + 2) % 3
        u = tri[t, k_left]
        ux, uy = xy[u, 0], xy[u, 1]
        sweeps = right == _SWEEP or left == _SWEEP
        if holds_goal[t] == pair and (
            sweeps
            or (_side(xy, right, px, py, ox, oy, qx, qy) >= 0.0 and _side(xy, left, px, py, ox, oy, qx, qy) <= 0.0)
        ):
            # the goal is seen from the root: nothing beyond this row can be shorter
            if way + _distance(px, py, qx, qy) < whole:
                whole, end = way + _distance(px, py, qx, qy), root
            at_hand = False
            continue
        if sweeps:
            # what is seen between the triangle's far vertex u and the limit; then on to the next triangle at the corner
            clockwise = right == _SWEEP
            seen_right, seen_left = (u, left) if clockwise else (right, u)
            s, j = _entered(tri, nbr, holds_goal, pair, t, k_left if clockwise else k_right)
            if seen_left == _BEND or seen_right == _BEND:
                turn = orient(ox, oy, px, py, ux, uy)
                if turn >= 0.0 if clockwise else turn <= 0.0:
                    s = -1
            if s >= 0:
                f = way + _least(xy, tri, s, j, seen_right, seen_left, px, py, ox, oy, qx, qy)
                if f < whole:
                    _put(rows, keys, items, filled, size, f, s, j, root, seen_right, seen_left)
                    filled += 1
                    size += 1
            t, k = _entered(tri, nbr, holds_goal, pair, t, k_right if clockwise else k_left)
            right, left = (_SWEEP, u) if clockwise else (u, _SWEEP)
            at_hand = t >= 0
            continue
        from_left = _side(xy, left, px, py, ox, oy, ux, uy)
        from_right = 1.0 if from_left >= 0.0 else _side(xy, right, px, py, ox, oy, ux, uy)
        if from_left < 0.0 and from_right > 0.0:
            s, j = _entered(tri, nbr, holds_goal, pair, t, k_right)
            s2, j2 = _entered(tri, nbr, holds_goal, pair, t, k_left)
            if s >= 0 and s2 >= 0:
                f = way + _least(xy, tri, s, j, right, u, px, py, ox, oy, qx, qy)
                f2 = way + _least(xy, tri, s2, j2, u, left, px, py, ox, oy, qx, qy)
                if f <= f2:
                    if f2 < whole:
                        _put(rows, keys, items, filled, size, f2, s2, j2, root, u, left)
                        filled += 1
                        size += 1
                    t, k, left = s, j, u
                else:
                    if f < whole:
                        _put(rows, keys, items, filled, size, f, s, j, root, right, u)
                        filled += 1
                        size += 1
                    f = f2
                    t, k, right = s2, j2, u
                at_hand = f < whole and (size == 0 or f <= keys[0])
                if not at_hand and f < whole:
                    _put(rows, keys, items, filled, size, f, t, k, root, right, left)
                    filled += 1
                    size += 1
            elif s >= 0:
                t, k, left = s, j, u
                at_hand = True
            elif s2 >= 0:
                t, k, right = s2, j2, u
                at_hand = True
            else:
                at_hand = False
            continue
        to_left = from_left >= 0.0
        slot = k if to_left else k_right
        corner = tri[t, slot]
        if corner == (left if to_left else right):
            w = wedge_of[t, slot]
            if turns[w] > 0:
                cx, cy = xy[corner, 0], xy[corner, 1]
                reached = way + _distance(px, py, cx, cy)
                f = reached + _distance(cx, cy, qx, qy)
                if (
                    reached < shortest[w]
                    and f < whole
                    and _bends(xy, corner, fan[w, 2] if to_left else fan[w, 1], px, py, 1.0 if to_left else -1.0)
                ):
                    shortest[w] = reached
                    bends[roots, 0], bends[roots, 1] = root, w
                    at[roots, 0], at[roots, 1], at[roots, 2] = cx, cy, reached
                    if to_left:
                        _put(rows, keys, items, filled, size, f, t, k, roots, _BEND, _SWEEP)
                    else:
                        _put(rows, keys, items, filled, size, f, t, k, roots, _SWEEP, _BEND)
                    roots += 1
                    filled += 1
                    size += 1
        if from_left == 0.0:
            left = u
        elif from_right == 0.0:
            right = u
        t, k = _entered(tri, nbr, holds_goal, pair, t, k_right if to_left else k_left)
        at_hand = t >= 0


# Helpers read their arrays first and branch on numbers only: then Numba drops all counting of references to arrays,
# which otherwise takes half of the time.


@kernel
def _entered(tri: Ints, nbr: Ints, holds_goal: Ints, pair: int, t: int, k: int) -> tuple[int, int]:
    """The triangle behind edge k of triangle t and the edge by which it is entered; (−1, …) if it leads nowhere."""
    s = nbr[t, k]
    v = tri[t, k]
    there = max(s, 0)
    first, second = tri[there, 0] == v, tri[there, 1] == v
    a, b, c = nbr[there, 0], nbr[there, 1], nbr[there, 2]
    goal = holds_goal[there] == pair
    j = 2 if first else (0 if second else 1)
    exits = (a >= 0) + (b >= 0) + (c >= 0)
    return (s if exits > 1 or goal else -1), j


@kernel
def _side(xy: Floats, limit: int, px: float, py: float, ox: float, oy: float, x: float, y: float) -> float:
    """Positive if (x, y) lies to the left of the limit's ray from the root p, to which the path comes from o. Exact."""
    vx, vy = xy[max(limit, 0), 0], xy[max(limit, 0), 1]
    if limit == _BEND:
        vx, vy, px, py = px, py, ox, oy
    return orient(px, py, vx, vy, x, y)


@kernel
def _bends(xy: Floats, v: int, b: int, px: float, py: float, hand: float) -> bool:
    """Whether a path from p that bends at v to the left (hand 1) or right (hand −1) has the wall from v to b there."""
    vx, vy, bx, by = xy[v, 0], xy[v, 1], xy[b, 0], xy[b, 1]
    turn = hand * orient(px, py, vx, vy, bx, by)
    return turn > 0.0 or (turn == 0.0 and (bx - vx) * (vx - px) + (by - vy) * (vy - py) < 0.0)


# ---------------------------------------------------------------------------------------------------------------------
# Lower bounds


@kernel
def _distance(ax: float, ay: float, bx: float, by: float) -> float:
    return float(np.sqrt((bx - ax) * (bx - ax) + (by - ay) * (by - ay)))


@kernel
def _least(
    xy: Floats,
    tri: Ints,
    t: int,
    k: int,
    right: int,
    left: int,
    px: float,
    py: float,
    ox: float,
    oy: float,
    qx: float,
    qy: float,
) -> float:
    """Least length from the root p through the cone's part of edge k to the goal q, never more than the exact one.

    All is taken relative to p. A goal on the root's side of the edge is mirrored in it.
    """
    a, b = tri[t, k], tri[t, (k + 1) % 3]
    ax, ay = xy[a, 0] - px, xy[a, 1] - py
    bx, by = xy[b, 0] - px, xy[b, 1] - py
    rx, ry = xy[max(right, 0), 0] - px, xy[max(right, 0), 1] - py
    lx, ly = xy[max(left, 0), 0] - px, xy[max(left, 0), 1] - py
    if right == _BEND:
        rx, ry = px - ox, py - oy
    if left == _BEND:
        lx, ly = px - ox, py - oy
    gx, gy = qx - px, qy - py
    ex, ey = bx - ax, by - ay
    reach = abs(ax) + abs(ay) + abs(bx) + abs(by) + abs(gx) + abs(gy)
    side = ex * (gy - ay) - ey * (gx - ax)
    if side < 0.0:
        f = 2.0 * side / (ex * ex + ey * ey)
        gx += f * ey
        gy -= f * ex
    f = _share(rx, ry, bx, by, ax, ay)
    rx, ry = bx - f * ex, by - f * ey
    f = _share(lx, ly, ax, ay, bx, by)
    lx, ly = ax + f * ex, ay + f * ey
    if rx * gy - ry * gx < 0.0:
        length = _distance(0.0, 0.0, rx, ry) + _distance(rx, ry, gx, gy)
    elif lx * gy - ly * gx > 0.0:
        length = _distance(0.0, 0.0, lx, ly) + _distance(lx, ly, gx, gy)
    else:
        length = _distance(0.0, 0.0, gx, gy)
    return float(length - 2.0**-48 * reach)


@kernel
def _share(dx: float, dy: float, ax: float, ay: float, bx: float, by: float) -> float:
    """How far from a to b, 0 to 1, the ray from the origin along d crosses: rounded towards a, so that cones widen."""
    ca, cb = dx * ay - dy * ax, dx * by - dy * bx
    error = 2.0**-50 * (abs(dx * ay) + abs(dy * ax) + abs(dx * by) + abs(dy * bx))
    if not abs(ca) > error:
        return 0.0
    return min((abs(ca) - error) / (abs(cb - ca) + 2.0 * error), 1.0)


# ---------------------------------------------------------------------------------------------------------------------
# Paths, rows and the queue


@kernel
def _write_path(
    given: Floats, pair: int, bends: Ints, at: Floats, end: int, points: Floats, count: int
) -> tuple[float, int]:
    """Append the path whose last root is ``end``, without repeated points: its length, how many points there are."""
    roots = 0
    r = end
    while r > 0:
        roots += 1
        r = bends[r, 0]
    r = end
    for i in range(roots, 0, -1):
        points[count + i, 0], points[count + i, 1] = at[r, 0], at[r, 1]
        r = bends[r, 0]
    points[count, 0], points[count, 1] = given[2 * pair, 0], given[2 * pair, 1]
    points[count + roots + 1, 0], points[count + roots + 1, 1] = given[2 * pair + 1, 0], given[2 * pair + 1, 1]
    length = 0.0
    last = count
    for i in range(count + 1, count + roots + 2):
        step = _distance(points[last, 0], points[last, 1], points[i, 0], points[i, 1])
        if points[last, 0] != points[i, 0] or points[last, 1] != points[i, 1]:
            last += 1
            points[last, 0], points[last, 1] = points[i, 0], points[i, 1]
            length += step
    return length, last + 1


@kernel
def _put(
    rows: Ints,
    keys: Floats,
    items: Ints,
    row: int,
    size: int,
    key: float,
    t: int,
    k: int,
    root: int,
    right: int,
    left: int,
) -> None:
    """Write a row and queue it, for which there must be room; ties are served by the smaller row."""
    rows[row, 0], rows[row, 1], rows[row, 2], rows[row, 3], rows[row, 4] = t, k, root, right, left
    push(keys, items, size, key, row)
