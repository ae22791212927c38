"""Starts and goals of a random scene: in one connected part of the free space, apart, with ways past each other."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
import shapely
from numpy.typing import NDArray
from scipy.spatial import cKDTree

from taut.errors import SceneError
from taut.generate.hall import Hall
from taut.generate.throwing import IDLE, JAM, ROUNDS, accepted, throws
from taut.scene import FloatArray, Obstacle

_SPREAD = 0.35  # share of the free part up to which starts and goals are spread out
_NEAREST, _FARTHEST = 1.1, 2.2  # distance of starts and goals as a multiple of what two robots need
_SEALED = 15  # times that robots without a way past the others are thrown again


@dataclass(frozen=True)
class Free:
    """Where the centre of the widest robot may be: the largest connected part, and what bounds it."""

    part: shapely.Polygon
    grown: NDArray[Any]
    inside: shapely.Polygon


def free_part(hall: Hall, obstacles: Sequence[Obstacle], growth: float) -> Free:
    """Return the largest connected part of the hall at least `growth` metres from wall and obstacles.

    Raises
    ------
    SceneError
        Nothing is left.
    """
    inside = hall.shrunk(growth)
    if inside.is_empty:
        raise SceneError(f"a robot that needs {2 * growth:.3g} m does not fit into {hall.words}: take a larger size")
    cores = np.array([_core(obstacle) for obstacle in obstacles], dtype=object)
    reach = np.array([obstacle.own_radius for obstacle in obstacles], dtype=np.float64) + growth
    grown = _discs(cores, reach)
    region = shapely.difference(inside, shapely.union_all(grown))
    part = max(shapely.get_parts(region), key=lambda polygon: polygon.area, default=shapely.Polygon())
    if part.is_empty:
        raise SceneError(f"no free space is left in {hall.words}: take a larger size or fewer obstacles")
    shapely.prepare(part)
    return Free(part, grown, inside)


def place_ends(
    rng: np.random.Generator, hall: Hall, free: Free, radii: FloatArray, gap: float, well_formed: bool
) -> FloatArray:
    """Throw the starts (first n) and goals (last n) of n robots into the free part, (2n, 2).

    Raises
    ------
    SceneError
        They do not fit, or (well_formed) robots are without a way past the others.
    """
    n = len(radii)
    ends = _Ends(hall, free, np.tile(radii, 2), gap)
    detour = 1.05 * (2 * float(radii.max()) + gap) + hall.margin
    stuck = 0
    for _ in range(_SEALED):
        ends.throw(rng)
        if not ends.done.all():
            break
        sealed = _sealed(ends.places, free, detour) if well_formed else np.zeros(n, dtype=bool)
        stuck = int(sealed.sum())
        if not stuck:
            return ends.places
        ends.clear(np.tile(sealed, 2))
    mend = "take a larger size, fewer or smaller robots, or fewer obstacles"
    if stuck:
        raise SceneError(f"{n} robots do not fit into {hall.words} with ways past each other: {mend}")
    fit = int((ends.done[:n] & ends.done[n:]).sum())
    raise SceneError(f"only {fit} of {n} robots fit into {hall.words} with starts and goals apart: {mend}")


class _Ends:
    """The places thrown so far: starts, then goals."""

    def __init__(self, hall: Hall, free: Free, radii: FloatArray, gap: float) -> None:
        self.hall, self.free, self.radii, self.gap = hall, free, radii, gap
        self.places = np.full((len(radii), 2), np.nan)
        self.done = np.zeros(len(radii), dtype=bool)
        widest = float(radii.max())
        room = free.part.buffer(widest + gap / 2).area  # 0 where a sliver is lost in rounding
        needed = math.pi / 4 * float(np.sum((2 * radii + gap) ** 2)) / room if room > 0 else math.inf
        self.hopeless = _NEAREST**2 * needed > JAM
        self.spread = min(_FARTHEST, max(_NEAREST, math.sqrt(_SPREAD / needed))) if needed > 0 else _FARTHEST
        self.longest = self.apart(np.array([widest]), np.array([widest]))[0]
        x0, y0, x1, y1 = free.part.bounds
        self.low, self.sides = np.array([x0, y0]), np.array([x1 - x0, y1 - y0])
        self.trip = 0.25 * float(self.sides.min())  # a robot that starts beside its goal has nothing to plan

    def apart(self, a: FloatArray, b: FloatArray) -> FloatArray:
        """Return the distance kept between starts or goals of robots of radii a and b, metres."""
        return self.spread * (a + b + self.gap) + 2 * self.hall.margin

    def clear(self, which: NDArray[np.bool_]) -> None:
        """Take places away."""
        self.done[which] = False
        self.places[which] = np.nan

    def throw(self, rng: np.random.Generator) -> None:
        """Throw until all have a place or it is plain that they do not fit."""
        idle = 0
        for _ in range(0 if self.hopeless else ROUNDS):
            if self.done.all() or idle == IDLE:
                return
            before = self.done.sum()
            who = throws(np.flatnonzero(~self.done))
            where = np.round(self.low + rng.random((len(who), 2)) * self.sides, self.hall.digits)
            keep = shapely.contains_xy(self.free.part, where[:, 0], where[:, 1])
            who, where = who[keep], where[keep]
            keep = self.free_of_standing(who, where)
            who, where = who[keep], where[keep]
            for k in accepted(who, self.rivals(who, where), self.done):
                counterpart = self.places[(who[k] + len(self.done) // 2) % len(self.done)]
                if not math.dist(where[k], counterpart) < self.trip:  # nan while it has no place
                    self.places[who[k]], self.done[who[k]] = where[k], True
            idle = idle + 1 if self.done.sum() == before else 0

    def free_of_standing(self, who: NDArray[np.intp], where: FloatArray) -> NDArray[np.bool_]:
        """Tell which throws lie apart from all that have a place, (k,)."""
        free = np.ones(len(who), dtype=bool)
        standing = np.flatnonzero(self.done)
        if len(standing) and len(who):
            near = cKDTree(where).sparse_distance_matrix(
                cKDTree(self.places[standing]), self.longest, output_type="coo_matrix"
            )
            close = near.data < self.apart(self.radii[who[near.row]], self.radii[standing[near.col]])
            free[near.row[close]] = False
        return free

    def rivals(self, who: NDArray[np.intp], where: FloatArray) -> NDArray[np.intp]:
        """Return the pairs of throws too near to each other, (p, 2)."""
        if not len(who):
            return np.zeros((0, 2), dtype=np.intp)
        pairs = cKDTree(where).query_pairs(self.longest, output_type="ndarray")
        a, b = pairs.T
        distance = np.hypot(*(where[a] - where[b]).T)
        return np.asarray(pairs[distance < self.apart(self.radii[who[a]], self.radii[who[b]])])


def _sealed(places: FloatArray, free: Free, detour: float) -> NDArray[np.bool_]:
    """Tell which robots have no path at least `detour` from all starts and goals of the others, (n,) bool.

    Open space is the free part without the discs round all starts and goals. Within its own disc a robot may move as
    well: the pieces of open space that its start's disc leads to must include one that its goal's disc leads to.
    """
    n = len(places) // 2
    points = shapely.points(places)
    discs = _discs(points, np.full(2 * n, detour))
    pieces = shapely.get_parts(shapely.difference(free.part, shapely.union_all(discs)))
    shapely.prepare(pieces)
    tree = shapely.STRtree(pieces)
    cells = _cells(points, discs, free, detour)
    cell, piece = tree.query(cells)
    touch = shapely.intersects(pieces[piece], cells[cell])
    leads: list[set[int]] = [set() for _ in points]
    for c, p in zip(cell[touch].tolist(), piece[touch].tolist(), strict=True):
        leads[c].add(p)
    return np.array([leads[k].isdisjoint(leads[n + k]) for k in range(n)], dtype=bool)


def _cells(points: NDArray[Any], discs: NDArray[Any], free: Free, detour: float) -> NDArray[Any]:
    """Return where the robot of each point may move near it: a little more than its disc, without the others'."""
    cells = np.asarray(shapely.intersection(shapely.buffer(points, 1.05 * detour, quad_segs=8), free.inside))
    blocked = np.concatenate([free.grown, discs])
    near = shapely.STRtree(blocked).query(cells, predicate="intersects")
    near = near[:, near[1] != len(free.grown) + near[0]]
    for k in np.unique(near[0]):
        rest = shapely.difference(cells[k], shapely.union_all(blocked[np.sort(near[1, near[0] == k])]))
        home = [cell for cell in shapely.get_parts(rest) if cell.covers(points[k])]
        cells[k] = home[0] if home else points[k]
    return cells


def _core(obstacle: Obstacle) -> shapely.Geometry:
    core = obstacle.core
    if obstacle.closed:
        return shapely.Polygon(core)
    return shapely.LineString(core) if len(core) > 1 else shapely.Point(core[0])


def _discs(cores: NDArray[Any], reach: FloatArray) -> NDArray[Any]:
    """Grow geometries by at least `reach` metres: the chords of the arcs lie outside."""
    return np.asarray(shapely.buffer(cores, reach / math.cos(math.pi / 32), quad_segs=8), dtype=object).reshape(-1)
