"""The widest passage between two places: how much room the best way leaves, and where it is narrowest."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray
from scipy.spatial import KDTree

from taut.errors import GoalBlocked, StartBlocked
from taut.route import _passage_kernels
from taut.scene import FloatArray, Point, Scene

WALL = "the wall"

_AROUND = 16

_Ints = NDArray[np.int64]


@dataclass(frozen=True, eq=False)
class Passage:
    """The narrowest place of the widest way.

    Parameters
    ----------
    clearance : metres; some way keeps this distance from all obstacles and the wall, and none keeps more.
    between : names of the two obstacles, or "the wall", that leave so little room; ("start", name) or ("goal", name)
        where no place of the way is narrower than its end.
    place : (x, y) metres, the middle of the gap; the end itself where that is the narrowest place.
    ends : (2, 2) metres, the nearest points of the two; the end and the point nearest to it.
    """

    clearance: float
    between: tuple[str, str]
    place: Point
    ends: FloatArray


def widest_passage(scene: Scene, a: ArrayLike, b: ArrayLike) -> Passage:
    """Find the greatest distance from all obstacles and the wall that some way from a to b keeps.

    Where obstacles separate the two the clearance is 0, and ``between`` tells what shuts them in; but an end that
    touches something is narrower than anything else. Gaps narrower than the scene's tolerance count as closed.

    Parameters
    ----------
    scene : its robots and clearance do not count.
    a, b : (2,) metres.

    Raises
    ------
    StartBlocked, GoalBlocked
        ``a`` or ``b`` lies deeper than the tolerance in an obstacle or outside the workspace.
    ValueError
        ``a`` or ``b`` is not one point.

    Notes
    -----
    Exact up to rounding. Every side of an obstacle or of the wall grows; two sides at distance d, of own radii r and s,
    meet when they have grown by (d − r − s) / 2. By then a and b are separated if some closed chain of sides that have
    met winds round one of them only, that is, crosses the segment from a to b an odd number of times (grown sides are
    convex, so every ring in their union can be pulled into such a chain). Sides are joined in the order in which they
    meet, in sets that know the parity of crossings from any member to any other (Kruskal's rule); the first
    ring of odd parity is the answer. Pairs are looked for within distances that double.

    >>> from taut.scene import Circle
    >>> passage = widest_passage(Scene((0, 0, 8, 4), [Circle((4, 0), 1), Circle((4, 4), 1)]), (1, 2), (7, 2))
    >>> passage.clearance, passage.between, passage.place
    (1.0, ('O1', 'O2'), (4.0, 2.0))
    """
    sides = _sides_of(scene)
    narrower = min(_end(scene, sides, a, "start"), _end(scene, sides, b, "goal"), key=lambda end: end.clearance)
    if narrower.clearance <= scene.tol:
        return narrower
    line = np.array([a, b], dtype=np.float64).ravel()
    found = _first_closed(sides, line, narrower.clearance, scene.tol)
    return narrower if found is None else _between(sides, *found, scene.tol)


@dataclass(frozen=True, eq=False)
class _Sides:
    """Obstacles and, last, the wall as sides. Where a shape is open, a side of length 0 is its end.

    Parameters
    ----------
    names : (m,) of the shapes.
    closed : (m,) whether the shape is a ring.
    ends : (n, 4) x0, y0, x1, y1.
    owner : (n,) the shape of a side.
    following : (n,) the side that begins where this one ends.
    radius : (n,) metres by which the shape reaches beyond the side.
    """

    names: tuple[str, ...]
    closed: NDArray[np.bool_]
    ends: FloatArray
    owner: _Ints
    following: _Ints
    radius: FloatArray


def _sides_of(scene: Scene) -> _Sides:
    obstacles = scene.obstacles
    cores = [*(o.core for o in obstacles), np.array(scene.workspace, dtype=np.float64)]
    closed = np.array([*(o.closed for o in obstacles), True])
    radius = np.array([*(o.own_radius for o in obstacles), 0.0])
    count = np.array([len(core) for core in cores])
    at, owner = np.concatenate(cores), np.repeat(np.arange(len(cores)), count)
    last = np.cumsum(count) - 1
    following = np.arange(1, len(at) + 1)
    following[last] = np.where(closed, last - count + 1, last)
    ends = np.concatenate([at, at[following]], axis=1)
    return _Sides((*(o.name for o in obstacles), WALL), closed, ends, owner, following, radius[owner])


def _end(scene: Scene, sides: _Sides, place: ArrayLike, word: str) -> Passage:
    """The room about one end of the way, which no passage exceeds."""
    point = np.array(place, dtype=np.float64)
    if point.shape != (2,) or not np.isfinite(point).all():
        raise ValueError(f"the {word} must be one point (x, y) of finite numbers, got {place!r}")
    x, y = point.tolist()
    distance, feet = _passage_kernels.feet(sides.ends, x, y)
    room = np.full(len(sides.names), np.inf)
    np.minimum.at(room, sides.owner, distance - sides.radius)
    within = _passage_kernels.shapes_round(sides.ends, sides.owner, len(sides.names), x, y) & sides.closed
    within[-1] = not within[-1]
    room[within] *= -1.0
    worst = int(np.argmin(room))
    name = sides.names[worst]
    if room[worst] < -scene.tol:
        error = StartBlocked if word == "start" else GoalBlocked
        where = "outside the workspace" if name == WALL else f"inside obstacle {name}"
        raise error(f"{word} ({x:g}, {y:g}) lies {where} by {-room[worst]:.3g} m; move it to where there is room")
    k = int(np.argmin(np.where(sides.owner == worst, distance, np.inf)))
    share = min(sides.radius[k] / distance[k], 1.0) if distance[k] > 0 else 0.0
    nearest = feet[k] + share * (point - feet[k])
    clearance = float(room[worst])
    return Passage(clearance if clearance > 0 else 0.0, (word, name), (x, y), np.stack([point, nearest]))


def _first_closed(sides: _Sides, line: FloatArray, bound: float, tol: float) -> tuple[int, int] | None:
    """The two sides whose meeting separates the ends of the line, if they meet before all have grown by ``bound``."""
    ends, radius = sides.ends, sides.radius
    parent, odd = _passage_kernels.join_outlines(ends, sides.following, line)
    near, near_weight = np.full((len(ends), 8), -1), np.full((len(ends), 8), np.inf)
    open_sides = np.argsort(np.minimum(ends[:, 0], ends[:, 2]) - radius, kind="stable")
    corners = KDTree(np.unique(ends[:, :2], axis=0))
    spacing = float(np.median(np.asarray(corners.query(corners.data, k=[2])[0])))
    least, most = -np.inf, tol / 2
    while least < bound:
        weights, pairs = _passage_kernels.pairs_within(
            ends, radius, open_sides, line, least, min(most, bound), tol, near, near_weight
        )
        owner = np.sort(sides.owner[pairs[:, :2]], axis=1)
        turn = np.lexsort((owner[:, 0], owner[:, 1], np.maximum(weights, tol / 2)))  # of equal gaps the wall's last
        k = _passage_kernels.join_in_order(parent, odd, pairs, turn)
        if k >= 0:
            i, j, _ = pairs[k].tolist()
            return i, j
        least, most = most, max(2 * most, spacing / 8)
        open_sides = open_sides[~_hemmed_in(sides, open_sides, corners, least, tol)]
    return None


def _hemmed_in(sides: _Sides, members: _Ints, corners: KDTree, weight: float, tol: float) -> NDArray[np.bool_]:
    """Which of these sides surely have no gap wider than 2 ``weight`` beside them that matters: (k,).

    Beside such a gap a disc of radius ``weight`` touches the side and holds no other. All discs that touch the side are
    nearly those about a few places round its middle; if each of these holds a corner well inside, there is none.
    """
    ends, reach = sides.ends[members], weight + sides.radius[members]
    half = np.hypot(ends[:, 2] - ends[:, 0], ends[:, 3] - ends[:, 1]) / 2
    inside = weight - half - reach * math.pi / _AROUND - tol
    out = inside > 0
    angle = 2 * math.pi * np.arange(_AROUND) / _AROUND
    around = np.stack([np.cos(angle), np.sin(angle)], axis=1)
    middle = (ends[out, :2] + ends[out, 2:]) / 2
    places = middle[:, None] + reach[out, None, None] * around
    distance = np.asarray(corners.query(places.reshape(-1, 2), distance_upper_bound=weight)[0])
    out[out] = (distance.reshape(-1, _AROUND) < inside[out, None]).all(axis=1)
    return out


def _between(sides: _Sides, i: int, j: int, tol: float) -> Passage:
    """The passage between two sides."""
    distance, *nearest = _passage_kernels.nearest_points(sides.ends, i, j)
    on_core = np.array(nearest).reshape(2, 2)
    step = (on_core[1] - on_core[0]) / distance if distance > 0 else np.zeros(2)
    ends = on_core + np.outer([sides.radius[i], -sides.radius[j]], step)
    gap = distance - sides.radius[i] - sides.radius[j]
    place = ends.mean(axis=0)
    if gap < 0:  # they overlap
        ends = np.stack([place, place])
    names = (sides.names[sides.owner[i]], sides.names[sides.owner[j]])
    return Passage(float(gap) / 2 if gap > tol else 0.0, names, (float(place[0]), float(place[1])), ends)
