"""What sensors look at: the pieces of obstacles, wall and robots, laid out for rays."""

from __future__ import annotations

import math
from dataclasses import dataclass
from itertools import pairwise

import numpy as np
import shapely
from numpy.typing import NDArray

from taut.certificate.report import WALL
from taut.scene import FloatArray, Obstacle, Scene
from taut.simulation._lidar_kernels import Pieces, filled_grid
from taut.validation import check_form

_PER_PIECE = 2
"""Cells of the grid for each piece."""

_MOST_CELLS = 1 << 18


@dataclass(frozen=True, eq=False)
class Surroundings:
    """Everything that a ray may meet; see `surroundings_of`.

    Parameters
    ----------
    names : of the obstacles, then "the wall", then of the n robots, in the scene's order.
    radii : (n,) metres of the robots' discs.
    tol : metres to which robots may lie within what they touch, the scene's.
    pieces : sides and discs of obstacles and wall in a grid.
    owner : to which of ``names`` each piece belongs; robots are pieces, too, behind those of the grid.
    crossings : (c, 2) metres, where pieces of obstacles and wall cross.
    """

    names: tuple[str, ...]
    radii: FloatArray
    tol: float
    pieces: Pieces
    owner: NDArray[np.int64]
    crossings: FloatArray


def surroundings_of(scene: Scene) -> Surroundings:
    """Lay out a scene for its robots' sensors: polygons as sides, circles and rounded walls as they are.

    Raises
    ------
    SceneError
        The workspace or a polygon crosses itself or has no area; numbers too large or too small.

    >>> from taut.scene import Circle
    >>> surroundings_of(Scene((0, 0, 4, 3), [Circle((1, 1), 0.5)])).names
    ('O1', 'the wall')
    """
    check_form(scene)
    rings = [(_ring(o.core), k) for k, o in enumerate(scene.obstacles) if o.closed]
    rings.append((_ring(np.array(scene.workspace, dtype=np.float64))[::-1], len(scene.obstacles)))
    bars = [(bar, k) for k, o in enumerate(scene.obstacles) for bar in _bars(o)]
    discs = [(disc, k) for k, o in enumerate(scene.obstacles) for disc in _discs(o)]
    first = np.cumsum([0, *(len(ring) for ring, _ in rings)])
    sides = [np.hstack([ring, np.roll(ring, -1, axis=0)]) for ring, _ in rings]
    before = [begin + np.roll(np.arange(len(ring)), 1) for begin, (ring, _) in zip(first, rings, strict=False)]
    all_sides = np.concatenate([*sides, *(_bar_sides(bar) for bar, _ in bars)])
    all_discs = np.array([disc for disc, _ in discs]).reshape(-1, 3)
    frame, shape = _grid(sides[-1], len(all_sides) + len(all_discs))
    start, items = filled_grid(all_sides, all_discs, frame, shape, max(2.0**-20 * frame[2], 2.0 * scene.tol))
    owner = [k for ring, k in rings for _ in ring] + [k for _, k in bars for _ in range(2)] + [k for _, k in discs]
    robots = range(len(scene.obstacles) + 1, len(scene.obstacles) + 1 + len(scene.robots))
    pieces = Pieces(
        sides=all_sides,
        before=np.concatenate([*before, np.full(2 * len(bars), -1)]).astype(np.int64),
        discs=all_discs,
        rings=first.astype(np.int64),
        boxes=np.array([[*ring.min(axis=0), *ring.max(axis=0)] for ring, _ in rings]),
        bars=np.array([bar for bar, _ in bars]).reshape(-1, 5),
        frame=frame,
        shape=shape,
        start=start,
        items=items,
    )
    return Surroundings(
        names=(*(o.name for o in scene.obstacles), WALL, *(robot.name for robot in scene.robots)),
        radii=np.array([robot.radius for robot in scene.robots], dtype=np.float64),
        tol=scene.tol,
        pieces=pieces,
        owner=np.array([*owner, *robots], dtype=np.int64),
        crossings=_crossings(all_sides, all_discs),
    )


def _ring(core: FloatArray) -> FloatArray:
    """Corners without repeats, counter-clockwise."""
    ring = core[(core != np.roll(core, 1, axis=0)).any(axis=1)]
    x, y = (ring - ring[0]).T
    doubled = (x * np.roll(y, -1) - y * np.roll(x, -1)).sum()
    return np.asarray(ring if doubled > 0 else ring[::-1], dtype=np.float64)


def _bars(obstacle: Obstacle) -> list[tuple[float, ...]]:
    """Segments of a rounded wall with the radius about them."""
    if obstacle.closed:
        return []
    return [(*a, *b, obstacle.own_radius) for a, b in pairwise(obstacle.core.tolist()) if a != b]


def _discs(obstacle: Obstacle) -> list[tuple[float, ...]]:
    if obstacle.closed:
        return []
    return [(*centre, obstacle.own_radius) for centre in dict.fromkeys(map(tuple, obstacle.core.tolist()))]


def _bar_sides(bar: tuple[float, ...]) -> FloatArray:
    """The two straight sides of what lies about a segment, (2, 4)."""
    x0, y0, x1, y1, radius = bar
    length = math.hypot(x1 - x0, y1 - y0)
    nx, ny = (y1 - y0) / length * radius, (x0 - x1) / length * radius
    return np.array([[x0 + nx, y0 + ny, x1 + nx, y1 + ny], [x1 - nx, y1 - ny, x0 - nx, y0 - ny]])


def _grid(wall: FloatArray, count: int) -> tuple[FloatArray, NDArray[np.int64]]:
    """Square cells over the workspace: the frame and the shape of the grid."""
    low, high = wall[:, :2].min(axis=0), wall[:, :2].max(axis=0)
    width, height = high - low
    cells = min(_PER_PIECE * count, _MOST_CELLS)
    cell = max(math.sqrt(width * height / cells), max(width, height) / cells)
    columns, rows = (max(1, math.ceil(extent / cell)) for extent in (width, height))
    return np.array([low[0], low[1], cell]), np.array([columns, rows], dtype=np.int64)


def _crossings(sides: FloatArray, discs: FloatArray) -> FloatArray:
    """Points in which sides and rims of discs cross each other, (c, 2)."""
    low = np.concatenate([np.minimum(sides[:, :2], sides[:, 2:]), discs[:, :2] - discs[:, 2:]])
    high = np.concatenate([np.maximum(sides[:, :2], sides[:, 2:]), discs[:, :2] + discs[:, 2:]])
    boxes = shapely.box(*low.T, *high.T)
    i, j = shapely.STRtree(boxes).query(boxes)
    i, j = i[i < j], j[i < j]
    e = len(sides)
    straight, mixed, round_ = j < e, (i < e) & (j >= e), i >= e
    with np.errstate(divide="ignore", invalid="ignore"):
        return np.concatenate(
            [
                _of_sides(sides[i[straight]], sides[j[straight]]),
                _of_side_and_rim(sides[i[mixed]], discs[j[mixed] - e]),
                _of_rims(discs[i[round_] - e], discs[j[round_] - e]),
            ]
        )


def _of_sides(p: FloatArray, q: FloatArray) -> FloatArray:
    """Where side p crosses side q; parallel ones do not."""
    along, across, apart = p[:, 2:] - p[:, :2], q[:, 2:] - q[:, :2], q[:, :2] - p[:, :2]
    area = _cross(along, across)
    s, t = _cross(apart, across) / area, _cross(apart, along) / area
    met = (s >= 0) & (s <= 1) & (t >= 0) & (t <= 1)
    return p[met, :2] + s[met, None] * along[met]


def _of_side_and_rim(p: FloatArray, disc: FloatArray) -> FloatArray:
    """Where side p crosses the rim of a disc, up to two points each."""
    along, to = p[:, 2:] - p[:, :2], disc[:, :2] - p[:, :2]
    length = np.hypot(along[:, 0], along[:, 1])
    half = np.sqrt(disc[:, 2] ** 2 - (_cross(along, to) / length) ** 2)
    middle = (along * to).sum(axis=1) / length
    s = np.concatenate([middle - half, middle + half]) / np.tile(length, 2)
    met = (s >= 0) & (s <= 1)
    points = np.tile(p[:, :2], (2, 1)) + s[:, None] * np.tile(along, (2, 1))
    return np.asarray(points[met], dtype=np.float64)


def _of_rims(p: FloatArray, q: FloatArray) -> FloatArray:
    """Where the rims of two discs cross, two points each."""
    to = q[:, :2] - p[:, :2]
    away = np.hypot(to[:, 0], to[:, 1])
    along = (away + (p[:, 2] - q[:, 2]) * (p[:, 2] + q[:, 2]) / away) / 2
    half = np.sqrt(p[:, 2] ** 2 - along**2)
    to = to / away[:, None]
    beside = np.stack([-to[:, 1], to[:, 0]], axis=1) * half[:, None]
    points = np.concatenate([p[:, :2] + along[:, None] * to + beside, p[:, :2] + along[:, None] * to - beside])
    return np.asarray(points[np.isfinite(points).all(axis=1)], dtype=np.float64)


def _cross(a: FloatArray, b: FloatArray) -> FloatArray:
    return np.asarray(a[:, 0] * b[:, 1] - a[:, 1] * b[:, 0], dtype=np.float64)
