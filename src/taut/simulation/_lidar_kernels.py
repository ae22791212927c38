"""Rays against sides and discs: exact first echoes of many beams, found through a uniform grid.

A side has what is solid on its left, so a ray enters through it from its right only. Whether it does is told from the
sides of the ray on which the two ends lie; sides that share a corner share that sign, so no ray slips between them.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from taut.compiling import kernel
from taut.team._lean import lean_kernel

Floats = NDArray[np.float64]
Ints = NDArray[np.int64]
Flags = NDArray[np.bool_]


class Pieces(NamedTuple):
    """What rays may hit, in a grid; a piece is the number of a side, or E plus that of a disc, or E + D plus a robot.

    Parameters
    ----------
    sides : (E, 4) x0, y0, x1, y1: of the rings, then two of each bar; solid on the left.
    before : (E,) the side that ends where this one begins; −1 where a disc rounds the end off.
    discs : (D, 3) x, y, radius, of circles and of the ends and joints of bars.
    rings : (R + 1,) ring r has the sides rings[r]:rings[r + 1]; the last is the workspace, solid outside.
    boxes : (R, 4) xmin, ymin, xmax, ymax of each ring.
    bars : (C, 5) x0, y0, x1, y1, radius of what lies about a segment.
    frame : (3,) lower left corner and width of the grid's square cells.
    shape : (2,) columns and rows of the grid.
    start, items : the pieces that meet cell (i, j) are items[start[c]:start[c + 1]], c = j · columns + i.
    """

    sides: Floats
    before: Ints
    discs: Floats
    rings: Ints
    boxes: Floats
    bars: Floats
    frame: Floats
    shape: Ints
    start: Ints
    items: Ints


@kernel
def filled_grid(sides: Floats, discs: Floats, frame: Floats, shape: Ints, pad: float) -> tuple[Ints, Ints]:
    """Return `start` and `items` of a grid; a piece counts for every cell that it comes within ``pad`` of."""
    size = shape[0] * shape[1]
    start = np.zeros(size + 1, dtype=np.int64)
    items = np.empty(0, dtype=np.int64)
    for filling in range(2):
        if filling:
            for c in range(size):
                start[c + 1] += start[c]
            items = np.empty(start[size], dtype=np.int64)
        for piece in range(sides.shape[0] + discs.shape[0]):
            low, high = _extent(sides, discs, piece)
            first, last = _cells(low - pad, high + pad, frame[1], frame[2], shape[1])
            for j in range(first, last + 1):
                y0 = frame[1] + j * frame[2] - pad
                low, high = _width(sides, discs, piece, y0, y0 + frame[2] + 2.0 * pad)
                left, right = _cells(low - pad, high + pad, frame[0], frame[2], shape[0])
                for c in range(j * shape[0] + left, j * shape[0] + right + 1):
                    if filling:
                        start[c] -= 1
                        items[start[c]] = piece
                    else:
                        start[c] += 1
    return start, items


@kernel
def cast_rays(
    pieces: Pieces, poses: Floats, radii: Floats, present: Flags, who: Ints, angles: Floats, reach: float, tol: float
) -> tuple[Floats, Ints]:
    """Distances (k, beams) at which the rays of robots ``who`` (k,) first meet something, and which piece that is.

    Parameters
    ----------
    poses : (n, 3 or more) x, y, θ of all robots.
    radii, present : (n,) of their discs, and whether they are there; a robot without radius hides nothing.
    angles : (beams,) against the heading.
    reach : metres; beyond it nothing is met: the distance is ``reach``, the piece −1.
    tol : metres to which a robot may lie within what it touches.
    """
    ranges = np.empty((who.shape[0], angles.shape[0]), dtype=np.float64)
    hits = np.empty((who.shape[0], angles.shape[0]), dtype=np.int64)
    touched = np.empty(pieces.sides.shape[0], dtype=np.int64)
    near = np.empty(poses.shape[0], dtype=np.int64)
    for k in range(who.shape[0]):
        _cast_from(pieces, poses, radii, present, who[k], angles, reach, tol, touched, near, ranges, hits, k)
    return ranges, hits


@kernel
def blur(ranges: Floats, hits: Ints, who: Ints, deviation: float, reach: float, seed: int, step: int) -> None:
    """Add normal noise to the distances that are echoes, within 0 and ``reach``; the same for the same numbers."""
    for k in range(ranges.shape[0]):
        key = _mixed(_mixed(_mixed(np.uint64(seed)) + np.uint64(step)) + np.uint64(who[k]))
        for b in range(ranges.shape[1]):
            if hits[k, b] >= 0:
                far = math.sqrt(-2.0 * math.log(1.0 - _uniform(key + np.uint64(2 * b))))
                normal = far * math.cos(2.0 * math.pi * _uniform(key + np.uint64(2 * b + 1)))
                ranges[k, b] = min(max(ranges[k, b] + deviation * normal, 0.0), reach)


@lean_kernel
def _extent(sides: Floats, discs: Floats, piece: int) -> tuple[float, float]:
    """Least and greatest y of a piece."""
    if piece < sides.shape[0]:
        return min(sides[piece, 1], sides[piece, 3]), max(sides[piece, 1], sides[piece, 3])
    d = piece - sides.shape[0]
    return discs[d, 1] - discs[d, 2], discs[d, 1] + discs[d, 2]


@lean_kernel
def _width(sides: Floats, discs: Floats, piece: int, y0: float, y1: float) -> tuple[float, float]:
    """Least and greatest x of what a piece has between two heights."""
    if piece < sides.shape[0]:
        ax, ay, bx, by = sides[piece, 0], sides[piece, 1], sides[piece, 2], sides[piece, 3]
        s0, s1 = 0.0, 1.0
        if ay != by:
            s0, s1 = (y0 - ay) / (by - ay), (y1 - ay) / (by - ay)
            s0, s1 = min(max(s0, 0.0), 1.0), min(max(s1, 0.0), 1.0)
        p, q = ax + s0 * (bx - ax), ax + s1 * (bx - ax)
        return min(p, q), max(p, q)
    d = piece - sides.shape[0]
    up = max(0.0, y0 - discs[d, 1], discs[d, 1] - y1)
    half = math.sqrt(max(0.0, discs[d, 2] * discs[d, 2] - up * up))
    return discs[d, 0] - half, discs[d, 0] + half


@lean_kernel
def _cells(low: float, high: float, origin: float, cell: float, count: int) -> tuple[int, int]:
    """First and last column (or row) that meets [low, high]; the first is the greater one if none does."""
    first, last = math.floor((low - origin) / cell), math.floor((high - origin) / cell)
    return int(min(max(first, 0.0), float(count))), int(max(min(last, count - 1.0), -1.0))


@lean_kernel
def _cast_from(
    pieces: Pieces, poses: Floats, radii: Floats, present: Flags, robot: int, angles: Floats, reach: float,
    tol: float, touched: Ints, near: Ints, ranges: Floats, hits: Ints, row: int,
) -> None:  # fmt: skip
    """Fill a row of ``ranges`` and ``hits``; ``touched`` and ``near`` are room to work in."""
    x, y, heading = poses[robot, 0], poses[robot, 1], poses[robot, 2]
    first_robot = pieces.sides.shape[0] + pieces.discs.shape[0]
    within = _within(pieces, x, y, tol)
    others = 0
    for j in range(poses.shape[0]):
        if j != robot and present[j] and radii[j] > 0.0:
            away = math.hypot(poses[j, 0] - x, poses[j, 1] - y)
            if away < radii[j] - tol and within < 0:
                within = first_robot + j
            if away - radii[j] <= reach:
                near[others] = j
                others += 1
    if within >= 0:
        for b in range(angles.shape[0]):
            ranges[row, b], hits[row, b] = 0.0, within
        return
    count = _touched(pieces, x, y, tol, touched)
    off_x, off_y = _off(pieces.sides, x, y, tol, touched, count)
    for b in range(angles.shape[0]):
        ux, uy = math.cos(heading + angles[b]), math.sin(heading + angles[b])
        best, piece = 0.0, _blocking(pieces, x, y, ux, uy, reach, tol, touched, count)
        if piece < 0:
            best, piece = _first_hit(pieces, off_x, off_y, ux, uy, reach, tol, touched, count)
        for k in range(others):
            j = near[k]
            s = _to_disc(poses[j, 0] - x, poses[j, 1] - y, radii[j], ux, uy, tol)
            if s < best:
                best, piece = s, first_robot + j
        if best <= reach:
            ranges[row, b], hits[row, b] = best, piece
        else:
            ranges[row, b], hits[row, b] = reach, -1


@lean_kernel
def _first_hit(
    pieces: Pieces, x: float, y: float, ux: float, uy: float, reach: float, tol: float, touched: Ints, count: int
) -> tuple[float, int]:
    """Where a ray from (x, y) along the unit vector u first meets a piece not touched, and which; (inf, −1) for none.

    Cell after cell (Amanatides and Woo, "A fast voxel traversal algorithm for ray tracing", Eurographics 1987).
    """
    columns, rows, cell = pieces.shape[0], pieces.shape[1], pieces.frame[2]
    x0, y0 = pieces.frame[0] - x, pieces.frame[1] - y
    i = min(max(int(-x0 / cell), 0), columns - 1)
    j = min(max(int(-y0 / cell), 0), rows - 1)
    edge_x, edge_y = (1 if ux > 0.0 else 0), (1 if uy > 0.0 else 0)
    leaves_x = (x0 + (i + edge_x) * cell) / ux if ux != 0.0 else np.inf
    leaves_y = (y0 + (j + edge_y) * cell) / uy if uy != 0.0 else np.inf
    best, piece = np.inf, -1
    sides = pieces.sides.shape[0]
    while True:
        c = j * columns + i
        for n in range(pieces.start[c], pieces.start[c + 1]):
            k = pieces.items[n]
            if k < sides:
                s = _to_side(pieces.sides, k, x, y, ux, uy)
                if s < best and not _among(touched, count, k):
                    best, piece = s, k
            else:
                d = k - sides
                s = _to_disc(pieces.discs[d, 0] - x, pieces.discs[d, 1] - y, pieces.discs[d, 2], ux, uy, tol)
                if s < best:
                    best, piece = s, k
        if min(best, reach) <= min(leaves_x, leaves_y):
            return best, piece
        if leaves_x < leaves_y:
            i += 2 * edge_x - 1
            if i < 0 or i >= columns:
                return best, piece
            leaves_x = (x0 + (i + edge_x) * cell) / ux
        else:
            j += 2 * edge_y - 1
            if j < 0 or j >= rows:
                return best, piece
            leaves_y = (y0 + (j + edge_y) * cell) / uy


@lean_kernel
def _to_side(sides: Floats, k: int, x: float, y: float, ux: float, uy: float) -> float:
    """Where a ray enters through a side or meets an end of it while it does; inf if it does not."""
    ax, ay, bx, by = sides[k, 0] - x, sides[k, 1] - y, sides[k, 2] - x, sides[k, 3] - y
    a, b = ux * ay - uy * ax, ux * by - uy * bx
    if a < 0.0 or b > 0.0 or a == b:
        return np.inf
    s = (a * (ux * bx + uy * by) - b * (ux * ax + uy * ay)) / (a - b)
    return s if s >= 0.0 else np.inf


@lean_kernel
def _to_disc(wx: float, wy: float, radius: float, ux: float, uy: float, tol: float) -> float:
    """Where a ray from the origin meets a disc about w, tangents included; inf if it does not.

    From a disc that it touches a ray goes away unless it gets deeper into it than ``tol``.
    """
    along = ux * wx + uy * wy
    if along < 0.0:
        return np.inf
    beside = abs(ux * wy - uy * wx)
    if beside > radius:
        return np.inf
    away = math.sqrt(wx * wx + wy * wy)
    if away - radius <= tol and radius - beside <= tol:
        return np.inf
    half = math.sqrt((radius - beside) * (radius + beside))
    return max(0.0, away - radius) * (away + radius) / (along + half)


@lean_kernel
def _within(pieces: Pieces, x: float, y: float, tol: float) -> int:
    """A piece of an obstacle in which (x, y) lies deeper than ``tol``, or of the wall if it is outside; else −1."""
    sides = pieces.sides.shape[0]
    for d in range(pieces.discs.shape[0]):
        if math.hypot(pieces.discs[d, 0] - x, pieces.discs[d, 1] - y) < pieces.discs[d, 2] - tol:
            return int(sides + d)
    rings = pieces.rings.shape[0] - 1
    for c in range(pieces.bars.shape[0]):
        if _to_segment(pieces.bars, c, x, y) < pieces.bars[c, 4] - tol:
            return int(pieces.rings[rings] + 2 * c)
    for r in range(rings):
        solid, boxes = r < rings - 1, pieces.boxes
        if solid and not (boxes[r, 0] < x < boxes[r, 2] and boxes[r, 1] < y < boxes[r, 3]):
            continue
        inside, least = False, np.inf
        for k in range(pieces.rings[r], pieces.rings[r + 1]):
            y0, y1 = pieces.sides[k, 1], pieces.sides[k, 3]
            if (y0 > y) != (y1 > y):
                x0 = pieces.sides[k, 0]
                if x < x0 + (y - y0) / (y1 - y0) * (pieces.sides[k, 2] - x0):
                    inside = not inside
        if inside == solid:
            for k in range(pieces.rings[r], pieces.rings[r + 1]):
                least = min(least, _to_segment(pieces.sides, k, x, y))
            if least > tol:
                return int(pieces.rings[r])
    return -1


@lean_kernel
def _touched(pieces: Pieces, x: float, y: float, tol: float, out: Ints) -> int:
    """Put the sides within ``tol`` of (x, y) into ``out``, and return their number."""
    cell = pieces.frame[2]
    i = min(max(int((x - pieces.frame[0]) / cell), 0), pieces.shape[0] - 1)
    j = min(max(int((y - pieces.frame[1]) / cell), 0), pieces.shape[1] - 1)
    c = j * pieces.shape[0] + i
    count = 0
    for n in range(pieces.start[c], pieces.start[c + 1]):
        k = pieces.items[n]
        if k < pieces.sides.shape[0] and _to_segment(pieces.sides, k, x, y) <= tol:
            out[count] = k
            count += 1
    return count


@lean_kernel
def _off(sides: Floats, x: float, y: float, tol: float, touched: Ints, count: int) -> tuple[float, float]:
    """Return (x, y) moved to ``tol`` before the sides that it touches: a ray along them then meets what ends them."""
    for n in range(count):
        k = touched[n]
        dx, dy = sides[k, 2] - sides[k, 0], sides[k, 3] - sides[k, 1]
        length = math.hypot(dx, dy)
        before = ((x - sides[k, 0]) * dy - (y - sides[k, 1]) * dx) / length
        if before < tol:
            x, y = x + (tol - before) * dy / length, y - (tol - before) * dx / length
    return x, y


@lean_kernel
def _blocking(
    pieces: Pieces, x: float, y: float, ux: float, uy: float, reach: float, tol: float, touched: Ints, count: int
) -> int:
    """A side touched at (x, y) into whose obstacle, or the wall, the ray leads; −1 if there is none."""
    for n in range(count):
        if _heads_into(pieces, touched[n], x, y, ux, uy, reach, tol):
            return int(touched[n])
    return -1


@lean_kernel
def _heads_into(pieces: Pieces, k: int, x: float, y: float, ux: float, uy: float, reach: float, tol: float) -> bool:
    """Whether a ray from a point that touches side k gets deeper than ``tol`` into what the side bounds.

    At a corner the side that begins there decides for both: into a convex one lead the directions into both sides.
    """
    sides = pieces.sides
    if math.hypot(sides[k, 2] - x, sides[k, 3] - y) <= tol:
        return False
    into = _sine(sides, k, ux, uy)
    other = pieces.before[k]
    if other >= 0 and math.hypot(sides[k, 0] - x, sides[k, 1] - y) <= tol:
        length = math.hypot(sides[k, 2] - sides[k, 0], sides[k, 3] - sides[k, 1])
        turn = _sine(sides, other, (sides[k, 2] - sides[k, 0]) / length, (sides[k, 3] - sides[k, 1]) / length)
        before = _sine(sides, other, ux, uy)
        into = min(into, before) if turn > 0.0 else max(into, before)
    return into * reach > tol


@lean_kernel
def _sine(sides: Floats, k: int, ux: float, uy: float) -> float:
    """Sine of the angle from a side to the unit vector u."""
    dx, dy = sides[k, 2] - sides[k, 0], sides[k, 3] - sides[k, 1]
    return float((dx * uy - dy * ux) / math.hypot(dx, dy))


@lean_kernel
def _to_segment(rows: Floats, k: int, x: float, y: float) -> float:
    """Distance of (x, y) from the segment in row k."""
    ax, ay, bx, by = rows[k, 0] - x, rows[k, 1] - y, rows[k, 2] - x, rows[k, 3] - y
    dx, dy = bx - ax, by - ay
    if ax * dx + ay * dy >= 0.0:
        return math.hypot(ax, ay)
    if bx * dx + by * dy <= 0.0:
        return math.hypot(bx, by)
    return float(abs(ax * dy - ay * dx) / math.hypot(dx, dy))


@lean_kernel
def _among(chosen: Ints, count: int, k: int) -> bool:
    found = False
    for n in range(count):
        found = found or chosen[n] == k
    return found


@lean_kernel
def _mixed(z: np.uint64) -> np.uint64:
    """A step of SplitMix64 (Steele, Lea and Flood, OOPSLA 2014)."""
    z += np.uint64(0x9E3779B97F4A7C15)
    z = (z ^ (z >> np.uint64(30))) * np.uint64(0xBF58476D1CE4E5B9)
    z = (z ^ (z >> np.uint64(27))) * np.uint64(0x94D049BB133111EB)
    return z ^ (z >> np.uint64(31))


@lean_kernel
def _uniform(z: np.uint64) -> float:
    """A number in [0, 1)."""
    return float(_mixed(z) >> np.uint64(11)) * 2.0**-53
