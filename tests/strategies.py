"""Hypothesis strategies: scenes, team scenes, legs and trajectories.

Small integer coordinates come often on purpose: touching, pinching and collinear corners are then the rule. Starts and
goals are picked from drawn candidates, the first that are free and far enough from those already picked.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import replace
from itertools import accumulate
from typing import Any

import numpy as np
import shapely
from hypothesis import assume
from hypothesis import strategies as st

from taut.motion import Trajectory
from taut.scene import Circle, FloatArray, Line, Obstacle, Point, Polygon, Rectangle, Robot, Scene
from zoo import free_region_exact, grows_nothing

_ROUNDING = 1e-6  # metres by which picked places keep away from the limit, far above every tolerance at these sizes

_STEPS: list[Point] = [(2.0, 0.0), (0.0, 2.0), (-1.5, 0.5), (1.5, 1.5), (1.0, -2.0)]


@st.composite
def scenes(
    draw: st.DrawFn, max_obstacles: int = 5, grid: int = 8, max_robots: int = 2, max_radius: float = 0.0
) -> Scene:
    """Draw a valid scene of any kind: on the grid, in floats, or of rectangles, circles and lines.

    Parameters
    ----------
    max_obstacles, max_robots : both counts start at 0.
    grid : side of the workspace's bounding square, metres; integer coordinates run from 0 to here.
    max_radius : largest radius of a robot; 0 gives points, which also stand on edges, corners and pinch points.
    """
    make = draw(st.sampled_from([grid_obstacles, float_obstacles, shaped_obstacles]))
    workspace = draw(workspaces(grid))
    obstacles = draw(st.lists(make(grid), max_size=max_obstacles))
    radii = draw(st.lists(_radii(max_radius), max_size=max_robots))
    return _populated(draw, Scene(workspace, obstacles, gap=0.1), radii, _half_grid(grid) | _floats_within(grid))


@st.composite
def grid_scenes(draw: st.DrawFn, max_obstacles: int = 5, grid: int = 8, max_robots: int = 2) -> Scene:
    """Draw a scene of polygons with integer corners and of point robots, starts and goals on the half-integer grid."""
    workspace = draw(workspaces(grid))
    obstacles = draw(st.lists(grid_obstacles(grid), max_size=max_obstacles))
    count = draw(st.integers(0, max_robots))
    return _populated(draw, Scene(workspace, obstacles, gap=0.1), [0.0] * count, _half_grid(grid))


@st.composite
def team_scenes(
    draw: st.DrawFn,
    min_robots: int = 2,
    max_robots: int = 6,
    max_obstacles: int = 6,
    grid: int = 12,
    max_radius: float = 0.4,
) -> Scene:
    """Draw a valid scene of disc robots with gap, headway, clearance and goals that are kept or left.

    Scenes whose obstacles leave no room for `min_robots` are discarded.
    """
    make = draw(st.sampled_from([grid_obstacles, float_obstacles, shaped_obstacles]))
    world = Scene(
        draw(workspaces(grid)),
        draw(st.lists(make(grid), max_size=max_obstacles)),
        clearance=draw(st.sampled_from([0.0, 0.05, 0.1])),
        gap=draw(st.sampled_from([0.0, 0.05, 0.2])),
        headway=draw(st.sampled_from([0.0, 0.0, 0.5])),
        at_goal=draw(st.sampled_from(["stay", "leave"])),
    )
    radii = draw(st.lists(st.floats(0.05, max_radius), min_size=min_robots, max_size=max_robots))
    scene = _populated(draw, world, radii, _half_grid(grid) | _floats_within(grid))
    assume(len(scene.robots) >= min_robots)
    return scene


def workspaces(grid: int = 8) -> st.SearchStrategy[list[Point]]:
    """Draw a workspace inside the square from 0 to `grid`: the square (mostly), turned round, dented or notched."""
    g, h = float(grid), float(grid // 2)
    square = [(0.0, 0.0), (g, 0.0), (g, g), (0.0, g)]
    ell = [(0.0, 0.0), (g, 0.0), (g, h), (h, h), (h, g), (0.0, g)]
    dented = [(0.0, 0.0), (h, h / 2), (g, 0.0), (g, h), (g, g), (0.0, g)]
    return st.sampled_from([square, square, square[::-1], ell, dented])


@st.composite
def grid_obstacles(draw: st.DrawFn, grid: int = 8) -> Obstacle:
    """Draw a box, a triangle, a quadrangle or a six-cornered ell with integer corners, up to 1 m outside."""
    along = st.integers(-1, grid + 1)
    x, y = draw(st.integers(-1, grid - 1)), draw(st.integers(-1, grid - 1))
    w, h = draw(st.integers(1, 4)), draw(st.integers(1, 4))
    box = [(x, y), (x + w, y), (x + w, y + h), (x, y + h)]
    match draw(st.sampled_from(["box", "box", "free", "free", "ell"])):
        case "box":
            corners = box
        case "ell":
            corners = [(x, y), (x + w + 1, y), (x + w + 1, y + 1), (x + 1, y + 1), (x + 1, y + h + 1), (x, y + h + 1)]
        case _:
            drawn = draw(st.lists(st.tuples(along, along), min_size=3, max_size=4, unique=True))
            corners = drawn if _is_simple(drawn) else box
    return Polygon(corners[::-1] if draw(st.booleans()) else corners)


@st.composite
def float_obstacles(draw: st.DrawFn, grid: int = 8) -> Obstacle:
    """Draw a polygon, star-shaped round a centre, with corners at arbitrary floats."""
    x, y = draw(_floats(0, grid)), draw(_floats(0, grid))
    count = draw(st.integers(3, 8))
    # Shifts below a quarter of a step keep every angle between neighbours below π, so the ring cannot cross itself.
    shifts = draw(st.lists(_floats(-0.24, 0.24), min_size=count, max_size=count))
    radii = draw(st.lists(_floats(0.1, 3), min_size=count, max_size=count))
    turns = [math.tau * (k + shift) / count for k, shift in enumerate(shifts)]
    return Polygon([(x + r * math.cos(a), y + r * math.sin(a)) for r, a in zip(radii, turns, strict=True)])


@st.composite
def shaped_obstacles(draw: st.DrawFn, grid: int = 8) -> Obstacle:
    """Draw a turned rectangle, a circle or a thick line."""
    places = _floats_within(grid)
    match draw(st.sampled_from(["rectangle", "circle", "line"])):
        case "rectangle":
            (x, y), angle = draw(places), draw(_floats(-math.pi, math.pi))
            return Rectangle(x, y, draw(_floats(0.1, 4)), draw(_floats(0.1, 4)), angle)
        case "circle":
            return Circle(draw(places), draw(_floats(0.05, 2)))
        case _:
            steps = draw(st.lists(st.sampled_from(_STEPS), min_size=1, max_size=4))
            points = accumulate(steps, lambda p, step: (p[0] + step[0], p[1] + step[1]), initial=draw(places))
            return Line(points, draw(_floats(0.05, 0.5)))


def legs(extent: float = 10.0, duration: float = 10.0) -> st.SearchStrategy[FloatArray]:
    """Draw a leg: two stamps (t, x, y), shape (2, 3), the second later; often integer, often a rest.

    Parameters
    ----------
    extent : metres; coordinates lie within ± extent.
    duration : seconds; both times lie in [0, 2 duration], the leg takes at most `duration`.
    """

    def leg(start: float, lasting: float, points: Sequence[Point]) -> FloatArray:
        (t0, (x0, y0)), (t1, (x1, y1)) = (start, points[0]), (start + lasting, points[-1])
        return np.array([[t0, x0, y0], [t1, x1, y1]])

    starts = st.integers(0, int(duration)).map(float) | _floats(0, duration)
    lastings = st.integers(1, max(1, int(duration))).map(float) | _floats(min(1e-3, duration), duration)
    # One point drawn for two is a rest.
    return st.builds(leg, starts, lastings, st.lists(_places(extent), min_size=1, max_size=2))


@st.composite
def trajectories(
    draw: st.DrawFn, name: str = "R", max_legs: int = 6, extent: float = 10.0, speed: float | None = None
) -> Trajectory:
    """Draw a trajectory of moves and rests within ± extent metres.

    Parameters
    ----------
    speed : metres a second of every move; None draws the duration of each leg from 1 ms to 5 s.
    """
    stamps = [(0.0, *draw(_places(extent)))]
    for _ in range(draw(st.integers(0, max_legs))):
        time, *here = stamps[-1]
        there = tuple(here) if draw(st.booleans()) else draw(_places(extent))
        lasting = draw(st.integers(1, 5).map(float) | _floats(1e-3, 5))
        if speed is not None and tuple(here) != there:
            lasting = math.dist(here, there) / speed
        if time + lasting > time:
            stamps.append((time + lasting, there[0], there[1]))
    return Trajectory(name, np.array(stamps))


def _floats(low: float, high: float) -> st.SearchStrategy[float]:
    """Numbers of a sane size: those below 1e-60 are refused by validation, so they are drawn as 0."""
    return st.floats(low, high).map(lambda x: 0.0 if abs(x) < 1e-60 and low <= 0.0 <= high else x)


def _places(extent: float) -> st.SearchStrategy[Point]:
    whole = st.integers(-int(extent), int(extent)).map(float)
    return st.tuples(whole, whole) | st.tuples(_floats(-extent, extent), _floats(-extent, extent))


def _half_grid(grid: int) -> st.SearchStrategy[Point]:
    half = st.integers(0, 2 * grid).map(lambda k: k / 2)
    return st.tuples(half, half)


def _floats_within(grid: int) -> st.SearchStrategy[Point]:
    return st.tuples(_floats(0, grid), _floats(0, grid))


def _radii(largest: float) -> st.SearchStrategy[float]:
    return st.just(0.0) if largest == 0 else st.sampled_from([0.0, largest / 2, largest]) | _floats(0, largest)


def _is_simple(corners: Sequence[Sequence[int]]) -> bool:
    polygon = shapely.Polygon(corners)
    return bool(polygon.is_valid) and polygon.area > 0


def _populated(draw: st.DrawFn, world: Scene, radii: Sequence[float], candidates: st.SearchStrategy[Point]) -> Scene:
    """Add robots of these radii while there is room among the drawn candidates."""
    free = _freedom(world)
    robots: list[Robot] = []
    for radius in radii:
        drawn = draw(st.lists(candidates, min_size=8, max_size=8))
        growth = radius + world.clearance
        starts = [p for p in drawn if free(p, growth) and _apart(world, robots, radius, p, [r.start for r in robots])]
        goals = [
            p for p in drawn[::-1] if free(p, growth) and _apart(world, robots, radius, p, [r.goal for r in robots])
        ]
        if starts and goals:
            speed = draw(st.sampled_from([1.0, 1.0, 0.5, 2.0]))
            robots.append(Robot(f"R{len(robots) + 1}", starts[0], goals[0], radius, speed))
    return replace(world, robots=tuple(robots))


def _freedom(world: Scene) -> Callable[[Point, float], bool]:
    """Return the test whether a disc of some growth is free at a point; growth 0 allows the boundary itself."""
    outline = shapely.Polygon(world.workspace)
    cores = [(_core(obstacle), obstacle.own_radius) for obstacle in world.obstacles]
    exact = free_region_exact(world) if grows_nothing(world.obstacles) else None

    def free(point: Point, growth: float) -> bool:
        here = shapely.Point(point)
        if exact is not None and growth == 0:
            return bool(exact.intersects(here))
        room = outline.exterior.distance(here) if outline.contains(here) else -1.0
        room = min([room, *(core.distance(here) - own for core, own in cores)])
        return bool(room >= growth + _ROUNDING)

    return free


def _core(obstacle: Obstacle) -> Any:
    if obstacle.closed:
        return shapely.Polygon(obstacle.core)
    return shapely.Point(obstacle.core[0]) if len(obstacle.core) == 1 else shapely.LineString(obstacle.core)


def _apart(world: Scene, robots: Sequence[Robot], radius: float, point: Point, others: Sequence[Point]) -> bool:
    return all(
        math.dist(point, other) >= radius + robot.radius + world.gap + _ROUNDING
        for robot, other in zip(robots, others, strict=True)
    )
