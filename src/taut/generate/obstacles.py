"""Obstacles of a random scene: forms drawn at random and thrown into the hall."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
import shapely
from numpy.typing import NDArray

from taut.errors import SceneError
from taut.generate.hall import Hall
from taut.generate.throwing import IDLE, ROUNDS, accepted, throws
from taut.scene import Circle, FloatArray, Line, Obstacle, Point, Polygon, Rectangle

_FULL = 0.7  # thrown obstacles with half their passages never fill a larger share of a hall


@dataclass(frozen=True)
class Form:
    """An obstacle about the origin, not yet placed: core points already turned, and what a Rectangle needs."""

    kind: str
    points: FloatArray
    own_radius: float
    sides: tuple[float, float] = (0.0, 0.0)
    angle: float = 0.0

    @property
    def solid(self) -> shapely.Geometry:
        """The area it covers; arcs lie a little outside the true ones."""
        if self.kind == "circle":
            return shapely.Point(0, 0).buffer(self.own_radius / math.cos(math.pi / 64), quad_segs=16)
        if self.kind == "line":
            return shapely.LineString(self.points).buffer(self.own_radius / math.cos(math.pi / 32), quad_segs=8)
        return shapely.Polygon(self.points)

    @property
    def diameter(self) -> float:
        """Of the least disc about the origin that holds the obstacle."""
        return 2 * (float(np.hypot(*self.points.T).max()) + self.own_radius)

    def scaled(self, by: float) -> Form:
        """Return the form `by` times as large."""
        width, height = self.sides
        return Form(self.kind, self.points * by, self.own_radius * by, (width * by, height * by), self.angle)

    def at(self, place: FloatArray, name: str, digits: int) -> Obstacle:
        """Return the obstacle with its origin at `place`, numbers rounded."""
        if self.kind == "circle":
            return Circle(_rounded(place, digits), max(round(self.own_radius, digits), 10.0**-digits), name)
        if self.kind == "rectangle":
            width, height = (max(round(side, digits), 10.0**-digits) for side in self.sides)
            x, y = _rounded(place - np.array([width, height]) / 2, digits)
            return Rectangle(x, y, width, height, self.angle, name)
        points = [_rounded(point + place, digits) for point in self.points]
        if self.kind == "line":
            return Line(points, max(round(2 * self.own_radius, digits), 10.0**-digits), name)
        return Polygon(points, name)


def draw_forms(rng: np.random.Generator, count: int, kinds: Sequence[str], sizes: tuple[float, float]) -> list[Form]:
    """Draw forms of these kinds with diameters (lowest, highest) in metres, from large to small."""
    forms = [DRAW[kinds[int(rng.integers(len(kinds)))]](rng, rng.uniform(*sizes)) for _ in range(count)]
    return sorted(forms, key=lambda form: -round(form.diameter, 6))  # large ones first: late ones squeeze in


def _polygon(rng: np.random.Generator, size: float) -> Form:
    corners = int(rng.integers(3, 8))
    angles = (np.arange(corners) + rng.uniform(-0.3, 0.3, corners)) * (2 * math.pi / corners)
    ellipse = np.column_stack([np.cos(angles), rng.uniform(0.5, 1.0) * np.sin(angles)]) * (size / 2)
    return Form("polygon", ellipse @ _turn(rng.uniform(0, 2 * math.pi)), 0.0)


def _rectangle(rng: np.random.Generator, size: float) -> Form:
    slope = rng.uniform(0.2, 1.37)  # of the diagonal, radians
    sides = (size * math.cos(slope), size * math.sin(slope))
    angle = round(float(rng.uniform(0, math.pi)), 3) if rng.random() < 0.5 else 0.0
    corners = np.array([[-1, -1], [1, -1], [1, 1], [-1, 1]]) * np.array(sides) / 2
    return Form("rectangle", corners @ _turn(angle), 0.0, sides, angle)


def _circle(rng: np.random.Generator, size: float) -> Form:
    return Form("circle", np.zeros((1, 2)), size / 2 * rng.uniform(0.5, 1.0))


def _line(rng: np.random.Generator, size: float) -> Form:
    points = int(rng.integers(2, 6))
    along = np.linspace(-0.5, 0.5, points)
    across = rng.uniform(0.1, 0.3, points) * np.where(np.arange(points) % 2, 1, -1)
    return Form("line", np.column_stack([along, across]) * size @ _turn(rng.uniform(0, 2 * math.pi)), size / 40)


def _nonconvex(rng: np.random.Generator, size: float) -> Form:
    pick = rng.integers(3)
    if pick == 2:
        spikes = int(rng.integers(4, 7))
        angles = np.arange(2 * spikes) * (math.pi / spikes)
        reach = np.where(np.arange(2 * spikes) % 2, rng.uniform(0.35, 0.55), rng.uniform(0.7, 1.0, 2 * spikes))
        points = np.column_stack([np.cos(angles), np.sin(angles)]) * reach[:, None] / 2
    else:
        w, h, t = rng.uniform(0.5, 0.75), rng.uniform(0.4, 0.65), rng.uniform(0.1, 0.16)
        ell = [(0, 0), (w, 0), (w, t), (t, t), (t, h), (0, h)]
        u = [(0, 0), (w, 0), (w, h), (w - t, h), (w - t, t), (t, t), (t, h), (0, h)]
        points = np.array(u if pick else ell) - np.array([w, h]) / 2
    return Form("polygon", points * size @ _turn(rng.uniform(0, 2 * math.pi)), 0.0)


DRAW: dict[str, Callable[[np.random.Generator, float], Form]] = {
    "polygon": _polygon,
    "rectangle": _rectangle,
    "circle": _circle,
    "line": _line,
    "nonconvex": _nonconvex,
}


def place_obstacles(rng: np.random.Generator, hall: Hall, forms: Sequence[Form], passage: float) -> list[Obstacle]:
    """Throw obstacles into the hall until each lies `passage` metres from the others and from the wall.

    Raises
    ------
    SceneError
        They do not fit.
    """
    solids = np.array([form.solid for form in forms], dtype=object)
    places = np.zeros((len(forms), 2))
    done = np.zeros(len(forms), dtype=bool)
    lying = np.empty(len(forms), dtype=object)
    reach = shapely.bounds(solids).reshape(-1, 4)
    low, high = passage - reach[:, :2], np.array([hall.width, hall.height]) - passage - reach[:, 2:]
    narrow = (low > high).any(axis=1)
    needed = float(shapely.area(shapely.buffer(solids, passage / 2, quad_segs=4)).sum())
    hopeless = bool(narrow.any()) or needed > _FULL * hall.shrunk(passage / 2).area
    idle = 0
    for _ in range(0 if hopeless else ROUNDS):
        if done.all() or idle == IDLE:
            break
        before = done.sum()
        missing = np.flatnonzero(~done)
        who = throws(missing[: 1 + len(missing) // 4])  # the largest: small ones find a place later
        where = np.round(low[who] + rng.random((len(who), 2)) * (high - low)[who], hall.digits)
        moved = _moved(solids[who], where)
        if done.any():
            clear = np.ones(len(who), dtype=bool)
            clear[shapely.STRtree(lying[done]).query(moved, predicate="dwithin", distance=passage)[0]] = False
            who, where, moved = who[clear], where[clear], moved[clear]
        rivals = shapely.STRtree(moved).query(moved, predicate="dwithin", distance=passage).T
        for k in accepted(who, rivals, done):
            places[who[k]], lying[who[k]], done[who[k]] = where[k], moved[k], True
        idle = idle + 1 if done.sum() == before else 0
    if not done.all():
        count = f"{len(forms)} obstacles do not" if hopeless else f"only {done.sum()} of {len(forms)} obstacles"
        raise SceneError(
            f"{count} fit into {hall.words} with passages of {passage:.3g} m: "
            "take a larger size, fewer or smaller obstacles, a lower density, or smaller robots"
        )
    return [form.at(places[k], f"O{k + 1}", hall.digits) for k, form in enumerate(forms)]


def _moved(solids: NDArray[Any], by: FloatArray) -> NDArray[Any]:
    out = solids.copy()
    corners = shapely.get_coordinates(out)
    return np.asarray(shapely.set_coordinates(out, corners + np.repeat(by, shapely.get_num_coordinates(out), axis=0)))


def _turn(angle: float) -> FloatArray:
    """Return the matrix that turns row vectors by `angle` radians."""
    c, s = math.cos(angle), math.sin(angle)
    return np.array([[c, s], [-s, c]])


def _rounded(point: FloatArray, digits: int) -> Point:
    return round(float(point[0]), digits), round(float(point[1]), digits)
