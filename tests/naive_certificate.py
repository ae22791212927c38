"""Slow, obvious references for the certificate: 40-digit arithmetic on every leg, and dense sampling."""

from __future__ import annotations

import itertools
from collections.abc import Iterator

import numpy as np
import shapely
from mpmath import mp, mpf
from numpy.typing import NDArray

from taut.motion import Plan, Trajectory
from taut.scene import Scene

mp.dps = 40
Vector = tuple[mpf, mpf]


def position(path: Trajectory, time: mpf) -> Vector:
    """Where a robot is, to 40 digits."""
    stamps = [[mpf(float(c)) for c in stamp] for stamp in path.stamps]
    for (t0, x0, y0), (t1, x1, y1) in itertools.pairwise(stamps):
        if t0 <= time <= t1:
            s = (time - t0) / (t1 - t0)
            return x0 + s * (x1 - x0), y0 + s * (y1 - y0)
    return stamps[-1][1], stamps[-1][2]


def least_room(plan: Plan) -> mpf | None:
    """Least room between two discs over all time, without headway; None if no two are present together."""
    best = None
    for (a, p), (b, q) in itertools.combinations(zip(plan.scene.robots, plan.trajectories, strict=True), 2):
        ends = [mpf(path.arrival) for robot, path in ((a, p), (b, q)) if not plan.scene.stays(robot)]
        if 0 in ends:
            continue
        times = sorted({mpf(float(t)) for t in (*p.times, *q.times)} | set(ends))
        times = [t for t in times if not ends or t <= min(ends)]
        corners = [tuple(u - v for u, v in zip(position(p, t), position(q, t), strict=True)) for t in times]
        pairs = list(itertools.pairwise(corners)) or [(corners[0], corners[0])]
        least = min(to_segment((mpf(0), mpf(0)), u, v) for u, v in pairs)
        room = least - mpf(a.radius) - mpf(b.radius)
        best = room if best is None else min(best, room)
    return best


def to_segment(p: Vector, a: Vector, b: Vector) -> mpf:
    """Distance from a point to a segment."""
    rx, ry = b[0] - a[0], b[1] - a[1]
    rr = rx * rx + ry * ry
    s = mpf(0) if rr == 0 else ((p[0] - a[0]) * rx + (p[1] - a[1]) * ry) / rr
    s = min(max(s, mpf(0)), mpf(1))
    return mp.hypot(a[0] + s * rx - p[0], a[1] + s * ry - p[1])


def between_segments(a: Vector, b: Vector, c: Vector, d: Vector) -> mpf:
    """Distance between two segments, 0 if they cross."""

    def side(p: Vector, q: Vector, r: Vector) -> mpf:
        return (q[0] - p[0]) * (r[1] - p[1]) - (q[1] - p[1]) * (r[0] - p[0])

    if side(a, b, c) * side(a, b, d) < 0 and side(c, d, a) * side(c, d, b) < 0:
        return mpf(0)
    return min(to_segment(a, c, d), to_segment(b, c, d), to_segment(c, a, b), to_segment(d, a, b))


def least_clearance(plan: Plan) -> list[mpf]:
    """Least distance of each robot's centre to obstacles and wall, for robots that are in none of them."""
    return [
        min(between_segments(a, b, c, d) - r for a, b in _legs(path) for c, d, r in _sides(plan.scene))
        for path in plan.trajectories
    ]


def _legs(path: Trajectory) -> list[tuple[Vector, Vector]]:
    points = [(mpf(float(x)), mpf(float(y))) for x, y in path.points]
    return list(itertools.pairwise(points)) or [(points[0], points[0])]


def _sides(scene: Scene) -> Iterator[tuple[Vector, Vector, mpf]]:
    shapes = [(o.core, o.closed, o.own_radius) for o in scene.obstacles] + [(np.array(scene.workspace), True, 0.0)]
    for core, closed, radius in shapes:
        points = [(mpf(float(x)), mpf(float(y))) for x, y in core]
        ring = [*points, points[0]] if closed or len(points) == 1 else points
        for c, d in itertools.pairwise(ring):
            yield c, d, mpf(radius)


def sampled_room(plan: Plan, count: int) -> float:
    """Least room between two discs at count × count instants (t, t + s), |s| ≤ headway; all robots stay."""
    scene = plan.scene
    times = np.linspace(0, plan.makespan + scene.headway, count)
    shifts = np.linspace(-scene.headway, scene.headway, count)
    best = np.inf
    for (a, p), (b, q) in itertools.combinations(zip(scene.robots, plan.trajectories, strict=True), 2):
        apart = p.at(times)[:, None] - q.at(np.maximum(times[:, None] + shifts, 0))
        best = min(best, float(np.hypot(apart[..., 0], apart[..., 1]).min()) - a.radius - b.radius)
    return best


def sampled_depth(plan: Plan, count: int) -> NDArray[np.float64]:
    """Greatest distance of each path to the free space of polygon obstacles, at count places a leg."""
    scene = plan.scene
    solid = shapely.union_all([shapely.Polygon(o.core) for o in scene.obstacles])
    free = shapely.Polygon(scene.workspace).difference(solid)
    out = []
    for path in plan.trajectories:
        t = np.concatenate([np.linspace(a, b, count) for a, b in itertools.pairwise(path.times)])
        out.append(float(shapely.distance(free, shapely.points(path.at(t))).max()))
    return np.array(out)


def has_room(plan: Plan, spare: float) -> bool:
    """Whether the path of the one point robot is near a motion that keeps `spare` metres from polygon obstacles.

    For maps with free angles of 45° and more, features much larger than `spare`, paths that do not cross themselves.
    """
    scene, (path,) = plan.scene, plan.trajectories
    free = shapely.Polygon(scene.workspace).difference(
        shapely.union_all([shapely.Polygon(o.core) for o in scene.obstacles])
    )
    way = shapely.LineString(path.points) if len(path.points) > 1 else shapely.Point(path.points[0])
    tube = free.buffer(-spare, join_style="mitre").intersection(way.buffer(8 * spare))
    places = shapely.points(path.at(np.linspace(0, path.times[-1], 1000)))
    corners = shapely.points(path.points)
    return any(
        bool(max(shapely.distance(part, places).max(), shapely.distance(part, corners).max()) < 3 * spare)
        for part in shapely.get_parts(tube)
    )
