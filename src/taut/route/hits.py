"""Hits: which obstacles a given path comes too near to, and where first. No free space is built to find out."""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass
from itertools import pairwise

import numpy as np
from numpy.typing import ArrayLike

from taut.route import _hit_kernels
from taut.route._passage_kernels import feet
from taut.route.core import points_of
from taut.route.obstacles import ObstacleIndex, indexed, obstacles_near
from taut.route.passage import WALL
from taut.scene import FloatArray, Obstacle, Point, Scene

# radians: sides that meet a path at less lie along it
_ALONG = 2.0**-20


@dataclass(frozen=True)
class Hit:
    """One thing that a path comes too near to, or two and more between which there is no way.

    Parameters
    ----------
    obstacles : their names, or "the wall", in the scene's order.
    place : (x, y) metres, where the path first comes too near, or where it squeezes through.
    leg : number of the leg, from 0.
    """

    obstacles: tuple[str, ...]
    place: Point
    leg: int


@dataclass(frozen=True, eq=False)
class Solid:
    """An obstacle, or all that is outside the workspace, as straight sides.

    Parameters
    ----------
    name : of the obstacle, or "the wall".
    sides : (n, 4) x0, y0, x1, y1; the centre of a circle is one side of length 0.
    radius : metres by which it reaches beyond its sides.
    filled : 1 if what the sides go round is solid, −1 if all else is, 0 if the sides enclose nothing.
    left : +1 if what is left of a side is solid, −1 if what is right of it, 0 if neither is.
    """

    name: str
    sides: FloatArray
    radius: float
    filled: int
    left: int


def hits_of(world: Scene | ObstacleIndex, points: ArrayLike, growth: float) -> tuple[Hit, ...]:
    """Find all obstacles that a path comes nearer to than ``growth``, and those between which it squeezes.

    Parameters
    ----------
    world : the scene, or its index (`index_obstacles`); robots and clearance do not count.
    points : (k, 2) metres, k ≥ 1, the corners of the path.
    growth : metres that the path must keep from obstacles and from the outside of the workspace, less the tolerance.
        Where that is nothing the path may touch but not pass between things that touch each other.

    Returns
    -------
    tuple of Hit
        In the order of the path, each obstacle once.

    Raises
    ------
    ValueError
        ``points`` are not finite (k ≥ 1, 2), or ``growth`` is negative or not finite.

    >>> from taut.scene import Circle
    >>> hits_of(Scene((0, 0, 8, 4), [Circle((4, 2), 1, "pillar")]), [(1, 2), (7, 2)], growth=0.5)
    (Hit(obstacles=('pillar',), place=(2.5, 2.0), leg=0),)
    """
    path = points_of(points, "points")
    if not len(path) or not np.isfinite(path).all():
        raise ValueError("a path has at least one point, and all of its coordinates are finite")
    if not (growth >= 0 and math.isfinite(growth)):
        raise ValueError(f"growth must be a finite number of metres ≥ 0, got {growth!r}")
    index = indexed(world)
    scene = index.scene
    near = obstacles_near(index, path, growth)
    solids = [*(solid_of(scene.obstacles[k]) for k in near), wall_of(scene)]
    found: list[tuple[int, float, Hit]] = []
    for solid in solids:
        first = first_hit(solid, path, growth, scene.tol)
        if first is not None:
            leg, share = first
            found.append((leg, share, Hit((solid.name,), _along(path, leg, share), leg)))
    if growth <= scene.tol:
        hit = {name for *_, hit in found for name in hit.obstacles}
        for squeeze in _squeezes(solids, path, scene.tol):
            if not hit.issuperset(squeeze[2].obstacles):
                hit.update(squeeze[2].obstacles)
                found.append(squeeze)
    return tuple(hit for *_, hit in sorted(found, key=lambda item: item[:2]))


def solid_of(obstacle: Obstacle) -> Solid:
    """Return an obstacle as a solid."""
    core = obstacle.core
    if obstacle.closed:
        return Solid(obstacle.name, _ring(core), 0.0, 1, _turning(core))
    ends = core if len(core) > 1 else np.repeat(core, 2, axis=0)
    return Solid(obstacle.name, np.hstack([ends[:-1], ends[1:]]), obstacle.own_radius, 0, 0)


def wall_of(scene: Scene) -> Solid:
    """Return the outside of the workspace as a solid."""
    ring = np.array(scene.workspace, dtype=np.float64)
    return Solid(WALL, _ring(ring), 0.0, -1, -_turning(ring))


def depth_in(solid: Solid, place: Point, growth: float) -> float:
    """Return how deep a place is in a solid grown by ``growth`` metres; negative outside."""
    return _hit_kernels.depth(solid.sides, solid.filled, solid.radius + growth, *place)


def spans_in(solid: Solid, a: FloatArray, b: FloatArray, growth: float, tol: float) -> FloatArray:
    """Return the shares of a-b, (k, 2) from entry to exit, where it is deeper than ``tol`` in a grown solid."""
    return _hit_kernels.spans(solid.sides, solid.filled, solid.radius + growth, a, b, tol)


def first_hit(solid: Solid, path: FloatArray, growth: float, tol: float) -> tuple[int, float] | None:
    """Leg and share of it at which a path first enters a grown solid, if it gets deeper than ``tol`` there."""
    ends = path if len(path) > 1 else np.repeat(path, 2, axis=0)
    for leg, (a, b) in enumerate(pairwise(ends)):
        spans = spans_in(solid, a, b, growth, tol)
        if len(spans):
            return leg, float(spans[0, 0])
    return None


def _along(path: FloatArray, leg: int, share: float) -> Point:
    a, b = path[leg], path[min(leg + 1, len(path) - 1)]
    x, y = (1 - share) * a + share * b
    return float(x), float(y)


def _ring(corners: FloatArray) -> FloatArray:
    return np.hstack([corners, np.roll(corners, -1, axis=0)])


def _turning(corners: FloatArray) -> int:
    """+1 for a ring that turns counter-clockwise, −1 for one that turns clockwise."""
    x, y = (corners - corners[0]).T
    return 1 if np.sum(x * np.roll(y, -1) - y * np.roll(x, -1)) > 0 else -1


# ---------------------------------------------------------------------------------------------------------------------
# Squeezing: something touches the path from the left and something from the right at one place


def _squeezes(solids: list[Solid], path: FloatArray, tol: float) -> Iterator[tuple[int, float, Hit]]:
    """Places where a path that may touch passes between things that leave no way."""
    near = [solid for solid in solids if first_hit(solid, path, 2 * tol, tol) is not None]
    for leg in range(len(path) - 1):
        way = path[leg + 1] - path[leg]
        for share in _suspects(near, path[leg], way, tol):
            after = way if share < 1 else _way_on(path[leg + 1 :])
            place = _along(path, leg, share)
            touched = {solid.name: _touched(solid, place, way, after, tol) for solid in near}
            if after.any() and {-1, 1} <= set().union(*touched.values()):
                yield leg, share, Hit(tuple(name for name, which in touched.items() if which), place, leg)


def _way_on(rest: FloatArray) -> FloatArray:
    """Step from the first point to the next that differs, (0, 0) if none does."""
    steps = rest - rest[0]
    return np.asarray(steps[np.argmax((steps != 0).any(axis=1))])


def _suspects(near: list[Solid], start: FloatArray, way: FloatArray, tol: float) -> list[float]:
    """Shares of a leg at which it may be touched from both sides: beside corners, else in the middle; and its end."""
    length = math.hypot(*way)
    if length <= tol:  # it passes nothing
        return []
    shares = [0.5, 1.0]
    for solid in near:
        corners = solid.sides[:, :2] - start
        along, off = corners @ way / length, (corners[:, 1] * way[0] - corners[:, 0] * way[1]) / length
        beside = (np.abs(off) <= solid.radius + tol) & (along > tol) & (along < length - tol)
        shares += (along[beside] / length).tolist()
    return sorted(set(shares))


def _touched(solid: Solid, place: Point, before: FloatArray, after: FloatArray, tol: float) -> set[int]:
    """Sides of a path, +1 left and −1 right, on which a solid touches it at a place where it may bend."""
    distance, at = feet(solid.sides, *place)
    out = set()
    back = _angle(after, -before)
    for k in np.flatnonzero(distance <= solid.radius + tol / 2).tolist():
        if solid.radius > 0:
            directions = [(at[k] - place, 0)]
        else:
            # a side stands for what is solid beside it, also where the path runs along it
            directions = [(solid.sides[k, 2:] - place, solid.left), (solid.sides[k, :2] - place, -solid.left)]
        for direction, turn in directions:
            if math.hypot(*direction) > tol:
                angle = (_angle(after, direction) + turn * _ALONG) % (2 * math.pi)
                out.add(1 if 0 < angle < back else -1)
    return out


def _angle(a: FloatArray, b: FloatArray) -> float:
    """From direction a counter-clockwise to direction b, radians in [0, 2π)."""
    return math.atan2(a[0] * b[1] - a[1] * b[0], a[0] * b[0] + a[1] * b[1]) % (2 * math.pi)
