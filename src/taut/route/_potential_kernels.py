"""Kernels of the artificial potential: its value and force at a place, descent to the goal.

The arrays of the mesh mean the same as in `taut.geometry._kernels`; ``law`` is attraction, repulsion, influence.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from taut.arrays import higher
from taut.compiling import kernel
from taut.geometry._kernels import beyond, locate, orient
from taut.geometry._seeing_kernels import see_pairs

Floats = NDArray[np.float64]
Ints = NDArray[np.int64]

# nearer than this fraction of the influence the force grows no further: a start may lie on a wall
_NEAREST = 2.0**-10
# a step must lower the potential by this share of what a constant force would: less than half, so that one step may
# reach the bottom of a parabola; not much less, so that few overshoot it
_ENOUGH = 0.25
_HALVINGS = 20


@kernel
def potential_and_force(
    xy: Floats,
    tri: Ints,
    nbr: Ints,
    fan: Ints,
    wedge_of: Ints,
    turns: Ints,
    t: int,
    px: float,
    py: float,
    gx: float,
    gy: float,
    law: Floats,
    met: Ints,
    stamp: int,
    queue: Ints,
    places: Floats,
) -> tuple[float, float, float, int]:
    """Potential at p, which triangle t contains, for the goal g; the force (x, y); by how many places it is repelled.

    Those are the places of the boundary within the influence to which p is nearer than to their neighbours on either
    side. They are looked for from t on, through edges within the influence. As many as there is room for are written to
    ``places``: x, y, distance. ``met`` (m,) holds no ``stamp`` yet and gets it where a triangle was looked at;
    ``queue`` (m,) is scratch.
    """
    influence = law[2]
    dx, dy = gx - px, gy - py
    away = np.sqrt(dx * dx + dy * dy)
    potential = law[0] * (0.5 * away * (away / influence) if away <= influence else away - 0.5 * influence)
    fx, fy = law[0] * dx / max(away, influence), law[0] * dy / max(away, influence)
    n = 0
    queue[0] = t
    met[t] = stamp
    taken, size = 0, 1
    while taken < size:
        s = queue[taken]
        taken += 1
        for k in range(3):
            a, b = tri[s, k], tri[s, (k + 1) % 3]
            ax, ay = xy[a, 0], xy[a, 1]
            dx, dy = px - ax, py - ay
            following = nbr[s, k]
            if following >= 0:
                if met[following] != stamp and not beyond(xy, a, b, px, py, influence):
                    met[following] = stamp
                    queue[size] = following
                    size += 1
            else:
                ex, ey = xy[b, 0] - ax, xy[b, 1] - ay
                length = np.sqrt(ex * ex + ey * ey)
                f = (dx * (ex / length) + dy * (ey / length)) / length
                turn = orient(ax, ay, xy[b, 0], xy[b, 1], px, py)
                away = turn / length
                if turn >= 0.0 and 0.0 <= f <= 1.0 and away < influence:
                    value, force = _repulsion(away, law)
                    potential += value
                    fx -= force * (ey / length)
                    fy += force * (ex / length)
                    if n < places.shape[0]:
                        places[n, 0], places[n, 1], places[n, 2] = ax + f * ex, ay + f * ey, away
                    n += 1
            w = wedge_of[s, k]
            if turns[w] > 0 and fan[w, 3] == s and fan[w, 4] == k:
                first, last = fan[w, 1], fan[w, 2]
                away = np.sqrt(dx * dx + dy * dy)
                if (
                    0.0 < away < influence
                    and dx * (xy[first, 0] - ax) + dy * (xy[first, 1] - ay) < 0.0
                    and dx * (xy[last, 0] - ax) + dy * (xy[last, 1] - ay) < 0.0
                ):
                    value, force = _repulsion(away, law)
                    potential += value
                    fx += force * (dx / away)
                    fy += force * (dy / away)
                    if n < places.shape[0]:
                        places[n, 0], places[n, 1], places[n, 2] = ax, ay, away
                    n += 1
    return potential, fx, fy, n


@kernel
def _repulsion(away: float, law: Floats) -> tuple[float, float]:
    """Potential and force of a place ``away`` metres off."""
    nearest = _NEAREST * law[2]
    ratio = law[2] / max(away, nearest)
    force = law[1] * (ratio - 1.0) * ratio * ratio
    return 0.5 * law[1] * law[2] * (ratio - 1.0) * (ratio - 1.0) + force * max(nearest - away, 0.0), force


@kernel
def potentials(
    xy: Floats,
    tri: Ints,
    nbr: Ints,
    fan: Ints,
    wedge_of: Ints,
    turns: Ints,
    points: Floats,
    triangles: Ints,
    gx: float,
    gy: float,
    law: Floats,
) -> Floats:
    """Potential and force (x, y) at each of (k, 2) points, (k, 3); inf and no force where the triangle is −1."""
    out = np.zeros((points.shape[0], 3))
    met = np.full(tri.shape[0], -1, dtype=np.int64)
    queue = np.empty(tri.shape[0], dtype=np.int64)
    places = np.empty((0, 3))
    for i in range(points.shape[0]):
        out[i, 0] = np.inf
        if triangles[i] >= 0:
            x, y, t = points[i, 0], points[i, 1], triangles[i]
            out[i, 0], out[i, 1], out[i, 2], _ = potential_and_force(
                xy, tri, nbr, fan, wedge_of, turns, t, x, y, gx, gy, law, met, i, queue, places
            )
    return out


@kernel
def repelling_places(
    xy: Floats, tri: Ints, nbr: Ints, fan: Ints, wedge_of: Ints, turns: Ints, t: int, px: float, py: float, law: Floats
) -> Floats:
    """Places of the boundary that repel at p, which triangle t contains: x, y, distance, (n, 3)."""
    met = np.full(tri.shape[0], -1, dtype=np.int64)
    queue = np.empty(tri.shape[0], dtype=np.int64)
    places = np.empty((0, 3))
    _, _, _, n = potential_and_force(xy, tri, nbr, fan, wedge_of, turns, t, px, py, px, py, law, met, 0, queue, places)
    places = np.empty((n, 3))
    potential_and_force(xy, tri, nbr, fan, wedge_of, turns, t, px, py, px, py, law, met, 1, queue, places)
    return places


@kernel
def descend(
    xy: Floats,
    tri: Ints,
    nbr: Ints,
    fan: Ints,
    wedge_of: Ints,
    turns: Ints,
    vertex_start: Ints,
    vertex_wedges: Ints,
    frame: Floats,
    shape: Ints,
    grid_start: Ints,
    grid_items: Ints,
    ends: Floats,
    holders: Ints,
    law: Floats,
    step: float,
    steps: int,
) -> tuple[Floats, bool]:
    """Follow the force from the first of two places to the second: the places passed, and whether it got there.

    No step is longer than ``step`` metres, none leaves the free space, each lowers the potential. It ends where the
    goal is seen within a step, where no step of at least step / 2²⁰ lowers the potential enough, or after ``steps``.
    """
    gx, gy = ends[1, 0], ends[1, 1]
    out = np.empty((256, 2))
    out[0, 0], out[0, 1] = ends[0, 0], ends[0, 1]
    n = 1
    met = np.full(tri.shape[0], -1, dtype=np.int64)
    queue = np.empty(tri.shape[0], dtype=np.int64)
    places = np.empty((0, 3))
    stamp = 0
    # the place at hand, the one tried next, the goal
    trio = np.empty((3, 2))
    trio[0, 0], trio[0, 1], trio[2, 0], trio[2, 1] = ends[0, 0], ends[0, 1], gx, gy
    triangles = np.array([holders[0], -1, holders[1]])
    here, there, goal = np.array([0]), np.array([1]), np.array([2])
    potential, fx, fy, _ = potential_and_force(
        xy, tri, nbr, fan, wedge_of, turns, holders[0], ends[0, 0], ends[0, 1], gx, gy, law, met, stamp, queue, places
    )
    longest = step
    while n <= steps:
        if n == out.shape[0]:
            out = higher(out)
        away = np.sqrt((gx - trio[0, 0]) ** 2 + (gy - trio[0, 1]) ** 2)
        if away <= step and see_pairs(xy, tri, nbr, fan, vertex_start, vertex_wedges, trio, triangles, here, goal)[0]:
            out[n, 0], out[n, 1] = gx, gy
            return out[: n + 1].copy(), True
        force = np.sqrt(fx * fx + fy * fy)
        length, halvings, moved = min(longest, away), 0, False
        while force > 0.0 and halvings <= _HALVINGS and not moved:
            x, y = trio[0, 0] + length * (fx / force), trio[0, 1] + length * (fy / force)
            trio[1, 0], trio[1, 1] = x, y
            t = locate(xy, tri, frame, shape, grid_start, grid_items, trio[1:2])[0]
            triangles[1] = t
            if t >= 0 and see_pairs(xy, tri, nbr, fan, vertex_start, vertex_wedges, trio, triangles, here, there)[0]:
                stamp += 1
                value, gain_x, gain_y, _ = potential_and_force(
                    xy, tri, nbr, fan, wedge_of, turns, t, x, y, gx, gy, law, met, stamp, queue, places
                )
                if value < potential - _ENOUGH * length * force:
                    potential, fx, fy, moved = value, gain_x, gain_y, True
            if not moved:
                length /= 2
                halvings += 1
        if not moved:
            break
        trio[0, 0], trio[0, 1], triangles[0] = trio[1, 0], trio[1, 1], triangles[1]
        out[n, 0], out[n, 1] = trio[0, 0], trio[0, 1]
        n += 1
        longest = min(2 * length, step)
    return out[:n].copy(), False
