"""Kernels of proofs that two robots cannot both get through: cells halved, pairs of cells, and what joins them.

A state is a pair of cells, one for each robot. Cells are triangles, and after them open places that have no shape.
"""

from __future__ import annotations

from typing import TypeAlias

import numpy as np
from numpy.typing import NDArray

from taut.compiling import kernel

Bools = NDArray[np.bool_]
Floats = NDArray[np.float64]
Ints = NDArray[np.int64]
Bytes = NDArray[np.int8]

Doors: TypeAlias = tuple[Ints, Ints, Floats, Floats]
"""Where doors begin for each cell (n + 1,), the cells they lead to, their sides (k, 4), and the triangles (m, 3, 2)."""

NEVER, PERHAPS, SURELY = 0, 1, 2
PROVED, POSSIBLE, UNDECIDED = 0, 1, 2
WALL = -1


@kernel
def halved(
    vertices: Floats, triangles: Ints, neighbours: Ints, marked: Bools, most: int
) -> tuple[Floats, Ints, Ints, int]:
    """Cut each marked triangle through the middle of its longest side, and others so that sides stay whole.

    Neighbours below −1 are open places, which stay. The last result is the number of triangles, −1 if there would be
    more than ``most``. Longest-edge propagation (Rivara 1997).
    """
    n, count = triangles.shape[0], vertices.shape[0]
    places = np.empty((count + most + 2, 2))
    corners = np.empty((most + 2, 3), dtype=np.int64)
    across = np.empty((most + 2, 3), dtype=np.int64)
    whole = np.zeros(most + 2, dtype=np.bool_)
    places[:count] = vertices
    corners[:n] = triangles
    across[:n] = neighbours
    whole[:n] = True
    for t in range(triangles.shape[0]):
        while marked[t] and whole[t]:
            if n > most:
                return places, corners, across, -1
            p = t
            while True:
                k = longest_side(places, corners[p])
                q = across[p, k]
                if q < 0:
                    break
                kq = longest_side(places, corners[q])
                if squared(places, corners[q], kq) <= squared(places, corners[p], k):
                    break
                p = q
            a, b = corners[p, k], corners[p, (k + 1) % 3]
            places[count, 0] = 0.5 * (places[a, 0] + places[b, 0])
            places[count, 1] = 0.5 * (places[a, 1] + places[b, 1])
            whole[p] = False
            if q < 0:
                split(corners, across, p, k, n, count)
                across[p, 0] = across[n, 0] = q
                n += 1
            else:
                kq = 0
                while across[q, kq] != p:
                    kq += 1
                whole[q] = False
                split(corners, across, p, k, n, count)
                split(corners, across, q, kq, n + 1, count)
                across[p, 0], across[n, 0] = n + 1, q
                across[q, 0], across[n + 1, 0] = n, p
                n += 2
            count += 1
    return places[:count].copy(), corners[:n].copy(), across[:n].copy(), n


@kernel
def split(corners: Ints, across: Ints, p: int, k: int, new: int, middle: int) -> None:
    """Make triangle p the half at the first end of its side k, and ``new`` the other; both halves of the side first."""
    a, b, c = corners[p, k], corners[p, (k + 1) % 3], corners[p, (k + 2) % 3]
    x, y = across[p, (k + 1) % 3], across[p, (k + 2) % 3]
    corners[p, 0], corners[p, 1], corners[p, 2] = a, middle, c
    across[p, 1], across[p, 2] = new, y
    corners[new, 0], corners[new, 1], corners[new, 2] = middle, b, c
    across[new, 1], across[new, 2] = x, p
    if x >= 0:
        for m in range(3):
            if across[x, m] == p:
                across[x, m] = new


@kernel
def longest_side(places: Floats, corners: Ints) -> int:
    """The first of a triangle's longest sides."""
    best = 0
    for k in range(1, 3):
        if squared(places, corners, k) > squared(places, corners, best):
            best = k
    return best


@kernel
def squared(places: Floats, corners: Ints, k: int) -> float:
    """Square of the length of side k; the same from both of its sides."""
    a, b = corners[k], corners[(k + 1) % 3]
    square: float = (places[a, 0] - places[b, 0]) ** 2 + (places[a, 1] - places[b, 1]) ** 2
    return square


@kernel
def state_table(first: Floats, open_first: int, second: Floats, open_second: int, least: float) -> Bytes:
    """Whether two robots in triangles (m, 3, 2) can be, and surely are, ``least`` metres apart; with open places sure.

    Returns
    -------
    (m + open_first, k + open_second) of NEVER, PERHAPS, SURELY.
    """
    m, k = first.shape[0], second.shape[0]
    table = np.full((m + open_first, k + open_second), SURELY, dtype=np.int8)
    middles, radii = circles(second)
    for a in range(m):
        here, size = circles(first[a : a + 1])
        for b in range(k):
            away = np.hypot(here[0, 0] - middles[b, 0], here[0, 1] - middles[b, 1])
            if away - size[0] - radii[b] < least:
                table[a, b] = kind_of(first[a], second[b], least * least)
    return table


@kernel
def circles(triangles: Floats) -> tuple[Floats, Floats]:
    """Centroids, and the radii about them that hold all corners."""
    middles, radii = np.empty((triangles.shape[0], 2)), np.zeros(triangles.shape[0])
    for t in range(triangles.shape[0]):
        for x in range(2):
            middles[t, x] = (triangles[t, 0, x] + triangles[t, 1, x] + triangles[t, 2, x]) / 3.0
        for k in range(3):
            radii[t] = max(radii[t], np.hypot(triangles[t, k, 0] - middles[t, 0], triangles[t, k, 1] - middles[t, 1]))
    return middles, radii


@kernel
def kind_of(a: Floats, b: Floats, least: float) -> int:
    """State of two triangles, for a squared distance; the greatest is between corners, the least at a corner."""
    greatest, smallest = 0.0, np.inf
    for i in range(3):
        for j in range(3):
            greatest = max(greatest, (a[i, 0] - b[j, 0]) ** 2 + (a[i, 1] - b[j, 1]) ** 2)
            smallest = min(smallest, to_side(a[i, 0], a[i, 1], b, j), to_side(b[i, 0], b[i, 1], a, j))
    if greatest < least:
        return NEVER
    return SURELY if smallest >= least else PERHAPS


@kernel
def to_side(x: float, y: float, triangle: Floats, k: int) -> float:
    """Squared distance of a point from a side of a triangle."""
    ax, ay = triangle[k, 0], triangle[k, 1]
    ex, ey = triangle[(k + 1) % 3, 0] - ax, triangle[(k + 1) % 3, 1] - ay
    square = ex * ex + ey * ey
    share = min(max(((x - ax) * ex + (y - ay) * ey) / square, 0.0), 1.0) if square > 0 else 0.0
    away: float = (ax + share * ex - x) ** 2 + (ay + share * ey - y) ** 2
    return away


@kernel
def next_states(state: int, table: Bytes, first: Doors, second: Doors, least: float, out: Ints) -> int:
    """Fill ``out`` with the states one step on: one robot goes through a door, the other stays in its cell."""
    width = table.shape[1]
    a, b = state // width, state % width
    count = 0
    indptr, to, sides, _ = first
    for e in range(indptr[a], indptr[a + 1]):
        other = to[e]
        if can_step(table[a, b], table[other, b], sides[e], second[3], b, least):
            out[count] = other * width + b
            count += 1
    indptr, to, sides, _ = second
    for e in range(indptr[b], indptr[b + 1]):
        other = to[e]
        if can_step(table[a, b], table[a, other], sides[e], first[3], a, least):
            out[count] = a * width + other
            count += 1
    return count


@kernel
def can_step(here: int, there: int, side: Floats, triangles: Floats, cell: int, least: float) -> bool:
    """Whether a point of the side and one of the cell are as far apart as they must be."""
    if there == NEVER:
        return False
    if cell >= triangles.shape[0] or (here == SURELY and there == SURELY):
        return True
    for k in range(3):
        x, y = triangles[cell, k, 0], triangles[cell, k, 1]
        if (side[0] - x) ** 2 + (side[1] - y) ** 2 >= least * least:
            return True
        if (side[2] - x) ** 2 + (side[3] - y) ** 2 >= least * least:
            return True
    return False


@kernel
def reachable(table: Bytes, first: Doors, second: Doors, least: float, starts: Ints) -> Bools:
    """Which states can be reached from those given: (all states,)."""
    reached = np.zeros(table.size, dtype=np.bool_)
    queue = np.empty(table.size, dtype=np.int64)
    following = np.empty(first[1].shape[0] + second[1].shape[0] + 1, dtype=np.int64)
    end = 0
    for s in starts:
        if not reached[s]:
            reached[s] = True
            queue[end] = s
            end += 1
    done = 0
    while done < end:
        for i in range(next_states(queue[done], table, first, second, least, following)):
            s = following[i]
            if not reached[s]:
                reached[s] = True
                queue[end] = s
                end += 1
        done += 1
    return reached


@kernel
def explore(
    table: Bytes, first: Doors, second: Doors, least: float, starts: Ints, goals: Bools, reached: Bools
) -> tuple[int, Bools, Bools]:
    """Say whether the start states lead to a goal surely, or only perhaps and through which cells of each robot.

    States that are sure and hang together are a class; so are the starts and the goals. All other states reached
    belong to the class that is the fewest steps away. Where two classes meet, only the steps from one to the other are
    in doubt: the cells of these are worth halving.
    """
    width = table.shape[1]
    sure = table.reshape(-1)
    classes = np.zeros(table.size, dtype=np.int64)
    before = np.full(table.size, -1, dtype=np.int64)
    queue = np.empty(table.size, dtype=np.int64)
    following = np.empty(first[1].shape[0] + second[1].shape[0] + 1, dtype=np.int64)
    doubt_first = np.zeros(first[3].shape[0], dtype=np.bool_)
    doubt_second = np.zeros(second[3].shape[0], dtype=np.bool_)
    end = 0
    for s in starts:
        end = spread(s, 1, sure, classes, queue, end, following, table, first, second, least)
    for s in range(table.size):
        if goals[s] and reached[s]:
            if classes[s] == 1:
                return POSSIBLE, doubt_first, doubt_second
            end = spread(s, 2, sure, classes, queue, end, following, table, first, second, least)
    number = 3
    for s in range(table.size):
        if reached[s] and sure[s] == SURELY and classes[s] == 0:
            end = spread(s, number, sure, classes, queue, end, following, table, first, second, least)
            number += 1
    done = 0
    while done < end:
        s = queue[done]
        for i in range(next_states(s, table, first, second, least, following)):
            v = following[i]
            if classes[v] == 0:
                classes[v] = classes[s]
                before[v] = s
                queue[end] = v
                end += 1
        done += 1
    walked = np.zeros(table.size, dtype=np.bool_)
    for done in range(end):
        u = queue[done]
        if sure[u] == SURELY:
            continue
        for i in range(next_states(u, table, first, second, least, following)):
            v = following[i]
            if classes[u] == classes[v]:
                continue
            for s in (u, v):
                while s >= 0 and not walked[s]:
                    walked[s] = True
                    if sure[s] == PERHAPS:
                        a, b = s // width, s % width
                        if a < doubt_first.shape[0]:
                            doubt_first[a] = True
                        if b < doubt_second.shape[0]:
                            doubt_second[b] = True
                    s = before[s]
    return UNDECIDED, doubt_first, doubt_second


@kernel
def spread(
    source: int,
    name: int,
    sure: Bytes,
    classes: Ints,
    queue: Ints,
    end: int,
    following: Ints,
    table: Bytes,
    first: Doors,
    second: Doors,
    least: float,
) -> int:
    """Give a state, and all that sure states join with it if it is sure, a class; append them to the queue."""
    if classes[source] != 0:
        return end
    classes[source] = name
    queue[end] = source
    done = end
    end += 1
    while done < end:
        s = queue[done]
        done += 1
        if sure[s] != SURELY:
            continue
        for i in range(next_states(s, table, first, second, least, following)):
            v = following[i]
            if sure[v] == SURELY and classes[v] == 0:
                classes[v] = name
                queue[end] = v
                end += 1
    return end
