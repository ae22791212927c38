"""Point robots, which may touch: no way through united obstacles, along a seam, or through a touching point.

A path that is nowhere deeper than tol in the union of all obstacles and the outside can still change sides where
that union is thinner than 2 tol: where obstacles touch in a point, or at a thin wall. So two things are proved: the
depth of every leg, and that the path comes from one side of what is thin to the other only round it (see `passing`).
"""

from __future__ import annotations

from itertools import pairwise

import numpy as np
import shapely

from taut.certificate._kernels import deepest_legs
from taut.certificate.clearance import Shapes
from taut.certificate.passing import crossings
from taut.certificate.report import Problem
from taut.certificate.tracks import Tracks
from taut.scene import FloatArray, Obstacle, Scene

# Sides of the polygon drawn into a round obstacle. It need not be fine: the clearance check holds the true circle.
_SIDES = 32


def check_crossing(scene: Scene, tracks: Tracks, shapes: Shapes) -> list[Problem]:
    """Return the worst crossing of each robot whose growth is at most tol; others cannot cross what they keep off.

    GEOS unites the obstacles; depth and side are own arithmetic.
    """
    tol = scene.tol
    robots = np.flatnonzero([scene.growth(robot) <= tol for robot in scene.robots]).astype(np.int64)
    if not robots.size:
        return []
    free = _free_region(scene)
    edges = _boundary(free)
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
    for r, time, place in crossings(shapes, tracks, rest, tol):
        names = shapes.near(*place, 4 * tol)
        problems[r] = Problem("crossing", (scene.robots[r].name,), 0.0, time, place, names)
    return [problems[r] for r in sorted(problems)]


def _free_region(scene: Scene) -> shapely.Geometry:
    """Workspace minus all obstacles, round ones as polygons drawn into them."""
    solid = [part for obstacle in scene.obstacles for part in _polygons(obstacle)]
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


def _boundary(free: shapely.Geometry) -> FloatArray:
    """Sides (E, 4) of the rings of a region."""
    at, ring = shapely.get_coordinates(shapely.get_rings(shapely.get_parts(free)), return_index=True)
    inside = ring[1:] == ring[:-1]
    return np.hstack([at[:-1][inside], at[1:][inside]])


def _extent(scene: Scene) -> float:
    low, high = np.min(scene.workspace, axis=0), np.max(scene.workspace, axis=0)
    return float(np.hypot(*(high - low)))
