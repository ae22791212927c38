"""Point robots, which may touch: no way through united obstacles, along a seam, or through a touching point.

A path that is nowhere deeper than tol in the union of all obstacles and the outside can still change sides where
that union is thinner than 2 tol: where obstacles touch in a point. So two things are proved: the depth of every leg,
and, in a small box round every such neck, that a path stays in one part of the free space of that box.
"""

from __future__ import annotations

from collections.abc import Iterator
from itertools import pairwise

import numpy as np
import shapely
from numpy.typing import NDArray

from taut.certificate._kernels import deepest_legs
from taut.certificate.clearance import Shapes
from taut.certificate.report import Problem
from taut.certificate.tracks import Tracks
from taut.scene import FloatArray, Obstacle, Scene

# Half the side of the box round a neck, in tolerances: 1e-6 of the scene. Free wedges down to 4e-6 rad are told apart.
_BOX = 2.0**20
# Sides of the polygon drawn into a round obstacle. It need not be fine: the clearance check holds the true circle,
# and `_welds` joins what truly touches.
_SIDES = 32


def check_crossing(scene: Scene, tracks: Tracks, shapes: Shapes) -> list[Problem]:
    """Return the worst crossing of each robot whose growth is at most tol; others cannot cross what they keep off.

    GEOS unites the obstacles; depth and side are own arithmetic.
    """
    tol = scene.tol
    robots = np.flatnonzero([scene.growth(robot) <= tol for robot in scene.robots]).astype(np.int64)
    if not robots.size:
        return []
    free = _free_region(scene, shapes)
    edges, before, after = _boundary(free)
    if not len(edges):
        nothing = "the obstacles, which leave no free space"
        starts = [tracks.on_leg(int(tracks.first[r]), 0.0)[1] for r in robots]
        return [
            Problem("crossing", (scene.robots[r].name,), _extent(scene), 0.0, place, nothing)
            for r, place in zip(robots, starts, strict=True)
        ]
    problems: dict[int, Problem] = {}
    depth, stamp, where = deepest_legs(tracks.x, tracks.y, tracks.first, robots, edges, False, tol)
    for n, r in enumerate(robots.tolist()):
        if depth[n] > 0.0:
            time, place = tracks.on_leg(int(stamp[n]), float(where[n]))
            names = shapes.near(*place, 4 * tol)
            problems[r] = Problem("crossing", (scene.robots[r].name,), float(depth[n]), time, place, names)
    rest = np.array([r for r in robots.tolist() if r not in problems], dtype=np.int64)
    for r, neck, time in _squeezes(free, _necks(edges, before, after, tol), tracks, rest, tol):
        if r not in problems:
            x, y = neck
            names = shapes.near(x, y, 4 * tol)
            problems[r] = Problem("crossing", (scene.robots[r].name,), 0.0, time, (x, y), names)
    return [problems[r] for r in sorted(problems)]


def _free_region(scene: Scene, shapes: Shapes) -> shapely.Geometry:
    """Workspace minus all obstacles, round ones as polygons drawn into them, joined where they touch."""
    solid = [part for obstacle in scene.obstacles for part in _polygons(obstacle)]
    solid += _welds(shapes, scene.tol)
    workspace = shapely.make_valid(shapely.Polygon(scene.workspace))
    return shapely.difference(workspace, shapely.union_all(solid))


def _polygons(obstacle: Obstacle) -> list[shapely.Geometry]:
    core, radius = obstacle.core, obstacle.own_radius
    if obstacle.closed:
        return [shapely.make_valid(shapely.Polygon(core))]
    quarter = np.array([np.exp(0.5j * np.pi * k / (_SIDES // 4)) for k in range(_SIDES // 4)])
    quarter[0] = 1.0
    unit = np.concatenate([quarter, 1j * quarter, -quarter, -1j * quarter])  # exact on the axes, where shapes touch
    ring = radius * np.column_stack([unit.real, unit.imag])
    out = [shapely.Polygon(point + ring) for point in core]
    for a, b in pairwise(core):
        length = np.hypot(*(b - a))
        if length > 0:
            side = radius * np.array([-(b - a)[1], (b - a)[0]]) / length
            out.append(shapely.Polygon([a + side, a - side, b - side, b + side]))
    return out


def _welds(shapes: Shapes, tol: float) -> list[shapely.Geometry]:
    """Thin pieces across every place where shapes touch but for rounding: a room below tol / 64 counts as none.

    Round sides never touch exactly (no double lies on most circles), and the polygons drawn into them would leave
    a way; corners that were turned or computed miss each other by a rounding.
    """
    owner = shapes.owner
    radius = shapes.radius[owner]
    segments = shapely.linestrings(shapes.edges.reshape(-1, 2, 2))
    low = np.minimum(shapes.edges[:, :2], shapes.edges[:, 2:]) - radius[:, None] - tol
    high = np.maximum(shapes.edges[:, :2], shapes.edges[:, 2:]) + radius[:, None] + tol
    boxes = shapely.box(low[:, 0], low[:, 1], high[:, 0], high[:, 1])
    a, b = shapely.STRtree(boxes).query(boxes)
    same = (owner[a] == owner[b]) & ((radius[a] == 0) | (np.abs(a - b) <= 1))
    once = ~same & (a < b)
    a, b = a[once], b[once]
    room = shapely.distance(segments[a], segments[b]) - radius[a] - radius[b]
    is_round = (radius[a] > 0) | (radius[b] > 0)
    touching = (room <= tol / 64) & (room >= np.where(is_round, -2 * tol, 5e-324))
    out = []
    for i, j, gap in zip(a[touching], b[touching], room[touching], strict=True):
        (px, py), (qx, qy) = shapely.get_coordinates(shapely.shortest_line(segments[i], segments[j]))
        p, q = np.array([px, py]), np.array([qx, qy])
        length = np.hypot(*(q - p))
        if length == 0.0:
            continue
        ahead = (q - p) / length
        if radius[i] == 0 and radius[j] == 0:
            out.append(shapely.box(*((p + q) / 2 - tol / 32), *((p + q) / 2 + tol / 32)))
        for base, way, r in ((p, ahead, radius[i]), (q, -ahead, radius[j])):
            if r > 0:
                across = np.array([-way[1], way[0]]) * r / 2
                out.append(shapely.Polygon([base + across, base - across, base + way * (r + max(gap, 0) + tol / 32)]))
    return out


def _boundary(free: shapely.Geometry) -> tuple[FloatArray, NDArray[np.int64], NDArray[np.int64]]:
    """Sides (E, 4) of the rings of a region, and for each side the one before and the one after it on its ring."""
    edges, before, after, size = [], [], [], 0
    for part in shapely.get_parts(free):
        if part.geom_type != "Polygon":
            continue
        for ring in (part.exterior, *part.interiors):
            points = shapely.get_coordinates(ring)
            count = len(points) - 1
            edges.append(np.hstack([points[:-1], points[1:]]))
            index = np.arange(count)
            before.append(size + (index - 1) % count)
            after.append(size + (index + 1) % count)
            size += count
    if not edges:
        return np.empty((0, 4)), np.empty(0, dtype=np.int64), np.empty(0, dtype=np.int64)
    return np.concatenate(edges), np.concatenate(before), np.concatenate(after)


def _necks(edges: FloatArray, before: NDArray[np.int64], after: NDArray[np.int64], tol: float) -> FloatArray:
    """Corners of the boundary that another part of the boundary comes within 2 tol of, (k, 2)."""
    sides = shapely.linestrings(edges.reshape(-1, 2, 2))
    corner, side = shapely.STRtree(sides).query(shapely.points(edges[:, :2]), predicate="dwithin", distance=2 * tol)
    other = (side != corner) & (side != before[corner])
    return np.unique(edges[corner[other], :2], axis=0)


def _squeezes(
    free: shapely.Geometry, necks: FloatArray, tracks: Tracks, robots: NDArray[np.int64], tol: float
) -> Iterator[tuple[int, tuple[float, float], float]]:
    """Yield robot, neck and time wherever a path changes sides at a neck."""
    if not len(necks) or not robots.size:
        return
    stamp, owner = _legs(tracks, robots)
    then = np.minimum(stamp + 1, tracks.first[owner + 1] - 1)
    legs = np.column_stack([tracks.x[stamp], tracks.y[stamp], tracks.x[then], tracks.y[then]])
    half = _BOX * tol
    boxes = shapely.box(*(necks - half).T, *(necks + half).T)
    neck, leg = shapely.STRtree(shapely.linestrings(legs.reshape(-1, 2, 2))).query(boxes, predicate="intersects")
    order = np.lexsort((leg, neck))
    neck, leg = neck[order], leg[order]
    if not len(neck):
        return
    starts = np.flatnonzero(np.r_[True, neck[1:] != neck[:-1]])
    for lo, hi in zip(starts, [*starts[1:], len(neck)], strict=True):
        k = neck[lo]
        parts = [p for p in shapely.get_parts(shapely.intersection(free, boxes[k])) if p.geom_type == "Polygon"]
        if len(parts) < 2:
            continue
        place = (float(necks[k, 0]), float(necks[k, 1]))
        label: int | None = None
        previous, ended = -2, False
        for n in leg[lo:hi].tolist():
            r = int(owner[n])
            span = _clip(legs[n] - np.tile(necks[k], 2), half)
            if span is None:
                continue
            if n != previous + 1 or not ended or span[0] > 0.0 or int(owner[previous]) != r:
                label = None
            previous, ended = n, span[1] == 1.0
            for s in span:
                side = _part(parts, (1 - s) * legs[n, :2] + s * legs[n, 2:], tol)
                if side is None:
                    continue
                if label is not None and side != label:
                    yield r, place, _passing(tracks, int(stamp[n]), legs[n], necks[k])
                label = side


def _legs(tracks: Tracks, robots: NDArray[np.int64]) -> tuple[NDArray[np.int64], NDArray[np.int64]]:
    """First stamp and robot of every leg of the chosen robots; a robot with one stamp has one leg of length 0."""
    count = np.maximum(np.diff(tracks.first)[robots] - 1, 1)
    owner = np.repeat(robots, count)
    offset = np.arange(count.sum()) - np.repeat(np.cumsum(count) - count, count)
    return tracks.first[owner] + offset, owner


def _clip(leg: FloatArray, half: float) -> tuple[float, float] | None:
    """Fractions between which a leg (relative to the middle of a box) is in the box, or None."""
    lo, hi = 0.0, 1.0
    for start, end in ((leg[0], leg[2]), (leg[1], leg[3])):
        step = end - start
        if step == 0.0:
            if abs(start) > half:
                return None
            continue
        a, b = sorted(((-half - start) / step, (half - start) / step))
        lo, hi = max(lo, float(a)), min(hi, float(b))
    return (lo, hi) if lo <= hi else None


def _part(parts: list[shapely.Geometry], point: FloatArray, tol: float) -> int | None:
    """Free part of a box that a point belongs to; None at the neck, where it touches several."""
    near = np.flatnonzero(shapely.distance(parts, shapely.Point(point)) <= 4 * tol)
    return int(near[0]) if near.size == 1 else None


def _passing(tracks: Tracks, stamp: int, leg: FloatArray, neck: FloatArray) -> float:
    way = leg[2:] - leg[:2]
    length2 = float(way @ way)
    s = 0.0 if length2 == 0.0 else min(max(float((neck - leg[:2]) @ way) / length2, 0.0), 1.0)
    return tracks.on_leg(stamp, s)[0]


def _extent(scene: Scene) -> float:
    low, high = np.min(scene.workspace, axis=0), np.max(scene.workspace, axis=0)
    return float(np.hypot(*(high - low)))
