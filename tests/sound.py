"""What makes a scene usable, checked slowly and plainly with GEOS buffers (for ready and random scenes)."""

from __future__ import annotations

import math
from itertools import combinations
from typing import Any

import shapely

from taut.scene import Obstacle, Robot, Scene


def core(obstacle: Obstacle) -> shapely.Geometry:
    points = obstacle.core
    if obstacle.closed:
        return shapely.Polygon(points)
    return shapely.LineString(points) if len(points) > 1 else shapely.Point(points[0])


def distance(point: tuple[float, float], obstacle: Obstacle) -> float:
    """From the point to the obstacle, exact; negative inside round ones."""
    return float(shapely.Point(point).distance(core(obstacle))) - obstacle.own_radius


def free_space(scene: Scene, robot: Robot, factor: float, margin: float) -> Any:
    """Where the robot may be, a little narrowed: growth · factor + margin."""
    growth = scene.growth(robot) * factor + margin
    taken = [
        core(o).buffer((growth + o.own_radius) / math.cos(math.pi / 64), quad_segs=16)
        if growth + o.own_radius > 0
        else core(o)
        for o in scene.obstacles
    ]
    return shapely.Polygon(scene.workspace).buffer(-growth, join_style="mitre").difference(shapely.union_all(taken))


def joined(region: Any, robot: Robot) -> bool:
    """Tell whether one part of the region holds start and goal."""
    ends = [shapely.Point(robot.start), shapely.Point(robot.goal)]
    return any(all(part.intersects(end) for end in ends) for part in shapely.get_parts(region))


def faults(scene: Scene, factor: float = 1.0, margin: float = 0.0) -> list[str]:
    """List starts and goals too near to obstacles, wall or each other, and robots cut off from their goals.

    Distances to obstacles and wall must exceed growth · factor + margin; goals of robots that leave may coincide.
    """
    out = []
    wall = shapely.Polygon(scene.workspace)
    for robot in scene.robots:
        needed = scene.growth(robot) * factor + margin
        for what, place in (("start", robot.start), ("goal", robot.goal)):
            if not wall.covers(shapely.Point(place)) or wall.exterior.distance(shapely.Point(place)) < needed:
                out.append(f"{robot.name}: {what} at the wall")
            out += [f"{robot.name}: {what} at {o.name}" for o in scene.obstacles if distance(place, o) < needed]
        if not joined(free_space(scene, robot, factor, margin), robot):
            out.append(f"{robot.name}: goal cut off")
    for a, b in combinations(scene.robots, 2):
        if math.dist(a.start, b.start) < scene.separation(a, b) * factor + margin:
            out.append(f"starts of {a.name} and {b.name}")
        both_stay = scene.stays(a) and scene.stays(b)
        if both_stay and math.dist(a.goal, b.goal) < scene.separation(a, b) * factor + margin:
            out.append(f"goals of {a.name} and {b.name}")
    return out


def hemmed_in(scene: Scene) -> list[str]:
    """Name the robots without a path that avoids all other robots' starts and goals."""
    out = []
    for robot in scene.robots:
        others = [
            shapely.Point(place).buffer(scene.separation(robot, other) / math.cos(math.pi / 64), quad_segs=16)
            for other in scene.robots
            if other is not robot
            for place in (other.start, other.goal)
        ]
        if not joined(free_space(scene, robot, 1.0, 0.0).difference(shapely.union_all(others)), robot):
            out.append(robot.name)
    return out
