"""Random scenes like a given one: as many robots and obstacles, of the same sizes and kinds."""

from __future__ import annotations

from collections.abc import Sequence
from contextlib import suppress

import shapely

from taut.errors import SceneError
from taut.generate import random_scene
from taut.geometry.growth import grown
from taut.scene import Circle, Line, Obstacle, Polygon, Rectangle, Scene
from taut.validation import check_form

_SPARSEST = 1e-6  # the least density of random scenes


def scene_like(scene: Scene, seed: int) -> Scene:
    """Make a random scene like this one.

    It has as many robots and obstacles, obstacles of the same kinds that cover the same share of the hall, radii and
    speeds from the same ranges, the same clearance, gap, headway and at_goal. The hall is as large as the bounds of the
    workspace or, where they do not fit there, as `random_scene` chooses. Clearances of single robots are not kept: all
    get the largest.

    Raises
    ------
    SceneError
        Robots and obstacles do not fit, or are of sizes too far apart.

    >>> from taut import Robot
    >>> scene_like(Scene((0, 0, 4, 3), [Circle((2, 1), 0.4)], [Robot("R1", (1, 1), (3, 1))]), 7).name
    'random-1-1-7'
    """
    check_form(scene)
    robots, obstacles = scene.robots, scene.obstacles
    workspace = shapely.Polygon(scene.workspace)
    x0, y0, x1, y1 = workspace.bounds
    bodies = [grown(obstacle, 0.0) for obstacle in obstacles]
    sizes = [2 * shapely.minimum_bounding_radius(body) for body in bodies]
    covered = shapely.union_all(bodies).intersection(workspace).area / workspace.area
    kinds = tuple(dict.fromkeys(_kind(obstacle) for obstacle in obstacles))

    def thrown(size: tuple[float, float] | None) -> Scene:
        return random_scene(
            len(robots),
            len(obstacles),
            seed,
            size=size,
            density=covered if covered >= _SPARSEST else None,
            obstacle_size=_span(sizes, 1.0),
            radius=_span([robot.radius for robot in robots], 0.0),
            speed=_span([robot.speed for robot in robots], 1.0),
            clearance=max((scene.growth(robot) - robot.radius for robot in robots), default=scene.clearance),
            gap=scene.gap,
            headway=scene.headway,
            at_goal=scene.at_goal,
            shapes=kinds or ("polygon",),
        )

    with suppress(SceneError):
        return thrown((x1 - x0, y1 - y0))
    return thrown(None)


def _kind(obstacle: Obstacle) -> str:
    """Return what `random_scene` calls such an obstacle."""
    match obstacle:
        case Circle():
            return "circle"
        case Line():
            return "line"
        case Rectangle():
            return "rectangle"
        case Polygon():
            shape = shapely.Polygon(obstacle.points)
            return "polygon" if shape.convex_hull.equals(shape) else "nonconvex"


def _span(values: Sequence[float], otherwise: float) -> tuple[float, float]:
    return (min(values), max(values)) if values else (otherwise, otherwise)
