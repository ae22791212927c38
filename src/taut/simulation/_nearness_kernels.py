"""How near robots are to obstacles and to each other: grids, and distances of the motion of one step.

A shape is a stretch of sides x0, y0, x1, y1 (a point is a side of length 0) and reaches a radius beyond them. A robot
that is farther from all sides than it has ever been need not be measured: what it has moved since it was measured last
bounds the distance from below.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from taut.compiling import kernel
from taut.team._lean import lean_kernel

Floats = NDArray[np.float64]
Ints = NDArray[np.int64]


@kernel
def sides_of_cells(edges: Floats, x0: float, y0: float, size: float, columns: int, rows: int) -> tuple[Ints, Ints]:
    """Sides whose boxes meet each cell of a grid: first (cells + 1,) and sides, one cell after the other."""
    first = np.zeros(columns * rows + 1, dtype=np.int64)
    for k in range(edges.shape[0]):
        c0, c1, r0, r1 = _cells(edges, k, x0, y0, size, columns, rows)
        for r in range(r0, r1 + 1):
            first[r * columns + c0 + 1 : r * columns + c1 + 2] += 1
    first = np.cumsum(first)
    at = first.copy()
    sides = np.empty(first[-1], dtype=np.int64)
    for k in range(edges.shape[0]):
        c0, c1, r0, r1 = _cells(edges, k, x0, y0, size, columns, rows)
        for r in range(r0, r1 + 1):
            for c in range(r * columns + c0, r * columns + c1 + 1):
                sides[at[c]] = k
                at[c] += 1
    return first, sides


@lean_kernel
def _cells(
    edges: Floats, k: int, x0: float, y0: float, size: float, columns: int, rows: int
) -> tuple[int, int, int, int]:
    """First and last column and row of the cells that the box of a side meets."""
    c0 = _cell(min(edges[k, 0], edges[k, 2]) - x0, size, columns)
    c1 = _cell(max(edges[k, 0], edges[k, 2]) - x0, size, columns)
    r0 = _cell(min(edges[k, 1], edges[k, 3]) - y0, size, rows)
    r1 = _cell(max(edges[k, 1], edges[k, 3]) - y0, size, rows)
    return c0, c1, r0, r1


@lean_kernel
def _cell(along: float, size: float, count: int) -> int:
    """Cell at a distance from the first; what lies outside belongs to the outermost."""
    return int(min(max(np.floor(along / size), 0.0), count - 1.0))


@lean_kernel
def nearest_shape(
    ax: float, ay: float, bx: float, by: float, within: float,
    edges: Floats, owner: Ints, reach: Floats, first: Ints, sides: Ints,
    x0: float, y0: float, size: float, columns: int, rows: int,
) -> tuple[float, int]:  # fmt: skip
    """Distance from the motion a b to the nearest shape and its number, (within, −1) if none is nearer than that."""
    best, shape = within, -1
    far = max(within, 0.0) + greatest(reach)
    c0 = _cell(min(ax, bx) - far - x0, size, columns)
    c1 = _cell(max(ax, bx) + far - x0, size, columns)
    r0 = _cell(min(ay, by) - far - y0, size, rows)
    r1 = _cell(max(ay, by) + far - y0, size, rows)
    for r in range(r0, r1 + 1):
        for c in range(r * columns + c0, r * columns + c1 + 1):
            for k in range(first[c], first[c + 1]):
                e = sides[k]
                d = _between(ax, ay, bx, by, edges[e, 0], edges[e, 1], edges[e, 2], edges[e, 3]) - reach[owner[e]]
                if d < best or (d == best and shape > owner[e]):
                    best, shape = d, owner[e]
    return best, shape


@lean_kernel
def deepest_inside(px: float, py: float, edges: Floats, rings: Ints, solid: Ints, reach: Floats) -> tuple[float, int]:
    """How deep a point lies inside a shape, as a negative distance, and in which; (inf, −1) if in none.

    Shape o has the sides ``rings[o]`` to ``rings[o + 1]``; ``solid[o]`` is 1 if it fills its ring, −1 if it is all
    around it (the wall), 0 if it has no inside but what lies within its reach.
    """
    best, shape = np.inf, -1
    for o in range(len(solid)):
        if solid[o] == 0:
            continue
        odd, least = False, np.inf
        for e in range(rings[o], rings[o + 1]):
            ax, ay, bx, by = edges[e, 0], edges[e, 1], edges[e, 2], edges[e, 3]
            least = min(least, _to_segment(px, py, ax, ay, bx, by))
            # a ray to the right crosses the side
            if (ay > py) != (by > py) and ((bx - ax) * (py - ay) - (by - ay) * (px - ax) > 0.0) == (by > ay):
                odd = not odd
        if odd == (solid[o] > 0):
            depth = -float(np.sqrt(least)) - reach[o]
            if depth < best:
                best, shape = depth, o
    return best, shape


@lean_kernel
def greatest(values: Floats) -> float:
    """Return the greatest of some numbers ≥ 0; 0 of none."""
    most = 0.0
    for k in range(len(values)):
        most = max(most, values[k])
    return most


@lean_kernel
def _between(ax: float, ay: float, bx: float, by: float, cx: float, cy: float, dx: float, dy: float) -> float:
    """Distance between the motion a b and the side c d; negative, by how far b is beyond, if it crosses the side."""
    rx, ry, qx, qy = bx - ax, by - ay, dx - cx, dy - cy
    wx, wy = cx - ax, cy - ay
    cross = rx * qy - ry * qx
    if cross != 0.0:
        s, u = (wx * qy - wy * qx) / cross, (wx * ry - wy * rx) / cross
        if 0.0 <= s <= 1.0 and 0.0 <= u <= 1.0:
            return -float(np.sqrt(_to_segment(bx, by, cx, cy, dx, dy)))
    least = min(_to_segment(ax, ay, cx, cy, dx, dy), _to_segment(bx, by, cx, cy, dx, dy))
    least = min(least, min(_to_segment(cx, cy, ax, ay, bx, by), _to_segment(dx, dy, ax, ay, bx, by)))
    return float(np.sqrt(least))


@lean_kernel
def _to_segment(px: float, py: float, ax: float, ay: float, bx: float, by: float) -> float:
    """Squared distance from p to the segment a b."""
    rx, ry, qx, qy = bx - ax, by - ay, px - ax, py - ay
    along, whole = qx * rx + qy * ry, rx * rx + ry * ry
    if along > 0.0:
        if along >= whole:
            qx, qy = px - bx, py - by
        else:
            qx, qy = qx - along / whole * rx, qy - along / whole * ry
    return qx * qx + qy * qy


@lean_kernel
def nearest_passing(ax: float, ay: float, bx: float, by: float) -> tuple[float, float]:
    """Least distance from the origin of a point that moves evenly from a to b, and when (0 … 1)."""
    rx, ry = bx - ax, by - ay
    whole = rx * rx + ry * ry
    s = 0.0
    if whole > 0.0:
        s = min(max(-(ax * rx + ay * ry) / whole, 0.0), 1.0)
    x, y = ax + s * rx, ay + s * ry
    return float(np.sqrt(x * x + y * y)), s


@lean_kernel
def list_pairs(
    state: Floats, gone: Floats, now: float, radii: Floats, near: float, most_radius: float,
    x0: float, y0: float, size: float, columns: int, rows: int, heads: Ints, follows: Ints, pairs: Ints,
) -> int:  # fmt: skip
    """List the pairs i < j of present robots with less than ``near`` between their discs; −1 if there is no room."""
    n = state.shape[0]
    for c in range(columns * rows):
        heads[c] = -1
    for i in range(n - 1, -1, -1):
        if gone[i] <= now:
            continue
        c = _cell(state[i, 0] - x0, size, columns) + columns * _cell(state[i, 1] - y0, size, rows)
        follows[i] = heads[c]
        heads[c] = i
    count = 0
    for i in range(n):
        if gone[i] <= now:
            continue
        far = near + radii[i] + most_radius
        c0 = _cell(state[i, 0] - far - x0, size, columns)
        c1 = _cell(state[i, 0] + far - x0, size, columns)
        r0 = _cell(state[i, 1] - far - y0, size, rows)
        r1 = _cell(state[i, 1] + far - y0, size, rows)
        for r in range(r0, r1 + 1):
            for c in range(r * columns + c0, r * columns + c1 + 1):
                j = heads[c]
                while j >= 0:
                    if j > i:
                        dx, dy = state[j, 0] - state[i, 0], state[j, 1] - state[i, 1]
                        reach = near + radii[i] + radii[j]
                        if dx * dx + dy * dy < reach * reach:
                            if count == pairs.shape[0]:
                                return -1
                            pairs[count, 0], pairs[count, 1], pairs[count, 2] = i, j, -1
                            count += 1
                    j = follows[j]
    return count
