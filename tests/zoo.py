"""One list of awkward scenes; every function that takes a scene runs over all of it."""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, replace
from itertools import pairwise
from typing import Any, TypeAlias

import shapely

from taut.scene import Circle, Line, Obstacle, Point, Polygon, Rectangle, Robot, Scene

Traveller: TypeAlias = tuple[Point, Point, bool, float]


@dataclass(frozen=True)
class Entry:
    """A valid scene, what is awkward in it, and which goals can surely be reached (True) or surely not (False)."""

    name: str
    scene: Scene
    awkward: str
    reachable: Mapping[str, bool]

    def __str__(self) -> str:
        return self.name


def free_region_exact(scene: Scene) -> Any:
    """Return the free region of a scene of polygons and rectangles for a point robot without clearance.

    Returns
    -------
    shapely Polygon or MultiPolygon, empty if nothing is free.

    Raises
    ------
    ValueError
        If an obstacle is round: its region is no polygon.
    """
    if not grows_nothing(scene.obstacles):
        raise ValueError(f"scene {scene.name}: circles and lines have no exact polygon")
    blocked = shapely.union_all([shapely.Polygon(obstacle.core) for obstacle in scene.obstacles])
    free = shapely.Polygon(scene.workspace).difference(blocked)
    parts = [part for part in getattr(free, "geoms", [free]) if part.geom_type == "Polygon" and not part.is_empty]
    return parts[0] if len(parts) == 1 else shapely.MultiPolygon(parts)


def grows_nothing(obstacles: Iterable[Obstacle]) -> bool:
    """Whether all obstacles are plain polygons."""
    return all(obstacle.closed and obstacle.own_radius == 0 for obstacle in obstacles)


def transformed(scene: Scene, factor: float, shift: float) -> Scene:
    """Return the scene with all lengths times `factor`, then moved by `shift` in x and y; speeds stay."""

    def moved(points: Iterable[Sequence[float]]) -> list[Point]:
        return [(factor * x + shift, factor * y + shift) for x, y in points]

    def shape(obstacle: Obstacle) -> Obstacle:
        match obstacle:
            case Circle():
                return Circle(moved([obstacle.center])[0], factor * obstacle.radius, obstacle.name)
            case Line():
                return Line(moved(obstacle.points), factor * obstacle.width, obstacle.name)
            case _:
                return Polygon(moved(obstacle.core.tolist()), obstacle.name)

    robots = [
        replace(
            robot,
            start=moved([robot.start])[0],
            goal=moved([robot.goal])[0],
            radius=factor * robot.radius,
            clearance=None if robot.clearance is None else factor * robot.clearance,
        )
        for robot in scene.robots
    ]  # fmt: skip
    return Scene(
        moved(scene.workspace),
        [shape(obstacle) for obstacle in scene.obstacles],
        robots,
        scene.name,
        factor * scene.clearance,
        factor * scene.gap,
        scene.headway,
        scene.at_goal,
    )


def _to(start: Point, goal: Point, reachable: bool = True, radius: float = 0.0) -> Traveller:
    return start, goal, reachable, radius


def _entry(
    name: str,
    awkward: str,
    workspace: Iterable[Any],
    obstacles: Iterable[Obstacle],
    *travellers: Traveller,
    clearance: float = 0.0,
    gap: float = 0.1,
) -> Entry:
    robots = [Robot(f"R{k}", start, goal, radius) for k, (start, goal, _, radius) in enumerate(travellers, 1)]
    goals = [robot.goal for robot in robots]
    scene = Scene(
        workspace, obstacles, robots, name, clearance, gap, at_goal="stay" if len(set(goals)) == len(goals) else "leave"
    )
    return Entry(name, scene, awkward, {r.name: t[2] for r, t in zip(robots, travellers, strict=True)})


def _box(x0: float, y0: float, x1: float, y1: float) -> Polygon:
    return Polygon([(x0, y0), (x1, y0), (x1, y1), (x0, y1)])


def _ring(centre: Point, radii: Sequence[float], count: int) -> list[Point]:
    """Return `count` points round a centre, the radii taken in turn."""
    turns = [(radii[k % len(radii)], math.tau * k / count) for k in range(count)]
    return [(centre[0] + r * math.cos(a), centre[1] + r * math.sin(a)) for r, a in turns]


_EIGHT = (0, 0, 8, 8)
_UP = math.nextafter(1.0, 2.0)
_DOWN = math.nextafter(1.0, 0.0)


def _plain() -> list[Entry]:
    return [
        _entry("empty", "no obstacle at all", _EIGHT, [], _to((1, 1), (7, 6)), _to((1, 7), (7, 1), radius=0.5)),
        _entry("no-robot", "nobody to plan for", _EIGHT, [_box(2, 2, 4, 4)]),
        _entry("one-square", "the simplest way round", _EIGHT, [_box(2, 2, 6, 6)], _to((1, 4), (7, 4))),
        _entry("start-is-goal", "nothing to do", _EIGHT, [_box(2, 2, 6, 6)], _to((1, 1), (1, 1)), _to((7, 7), (1, 7))),
        _entry("covered", "the obstacle leaves nothing but a strip", _EIGHT, [_box(1, -1, 9, 9)],
               _to((0.5, 1), (0.5, 7))),
        _entry("triangular-workspace", "slanted walls", [(0, 0), (9, 1), (3, 8)], [], _to((1, 1), (8, 1), radius=0.1)),
    ]  # fmt: skip


def _touching() -> list[Entry]:
    left, right = _box(2, 2, 4, 6), _box(4, 2, 6, 6)
    cup = Polygon([(1, 1), (7, 1), (7, 6), (6, 6), (6, 2), (2, 2), (2, 6), (1, 6)])
    return [
        _entry("seam", "a whole edge shared: no way along it", _EIGHT, [left, right], _to((4, 1), (4, 7))),
        _entry("seam-in-part", "edges shared in part", _EIGHT, [left, _box(4, 3, 6, 7)], _to((4, 1), (3.5, 7))),
        _entry("seam-wall", "two obstacles make a wall with a seam; the only way is round its end", _EIGHT,
               [_box(0, 3, 3, 5), _box(3, 3, 6, 5)], _to((3, 1), (3, 7)), _to((1, 1), (1, 7), radius=0.5)),
        _entry("seam-wall-across", "the wall with a seam cuts the workspace in two", _EIGHT,
               [_box(0, 3, 4, 5), _box(4, 3, 8, 5)], _to((4, 1), (4, 7), False), _to((1, 1), (6, 1))),
        _entry("touching-corners", "a pinch point", _EIGHT, [_box(2, 2, 4, 4), _box(4, 4, 6, 6)], _to((3, 5), (5, 3))),
        _entry("corner-on-edge", "a corner touches the middle of an edge", _EIGHT,
               [_box(2, 1, 6, 3), Polygon([(4, 3), (6, 6), (2, 6)])], _to((3, 3.5), (5, 3.5))),
        _entry("corner-on-slanted-edge",
               "the touching point is no pair of floats, so the corner is a hair off the edge", _EIGHT,
               [Polygon([(1, 1), (4, 2), (4, 1)]), Polygon([(2, 4 / 3), (3, 4), (1, 4)])], _to((1, 2), (3.5, 3))),
        _entry("three-at-a-point", "three obstacles meet in one point: three wedges; a robot starts there", _EIGHT,
               [Polygon([(4, 4), p, q]) for p, q in (((7, 3.5), (7, 4.5)), ((2, 7), (1, 6)), ((1, 2), (2, 1)))],
               _to((4, 4), (1, 4)), _to((4.5, 7), (4.5, 1))),
        _entry("reflex-pinch", "one wedge of the pinch point is reflex: a corner and a barrier in one", _EIGHT,
               [Polygon([(4, 4), (1, 3), (1, 2)]), Polygon([(4, 4), (7, 2), (7, 3)])], _to((4, 3), (4, 5)),
               _to((1.5, 3.5), (6.5, 3.5)), _to((4, 4), (4, 1))),
        _entry("straight-pinch", "one wedge of the pinch point is exactly straight", _EIGHT,
               [_box(2, 2, 4, 4), Polygon([(4, 4), (6, 2), (6, 4)])], _to((1, 4), (7, 4)), _to((4, 4), (4.5, 2))),
        _entry("start-on-pinch", "a start belongs to both sides, a path through it does not", _EIGHT,
               [_box(0, 2, 4, 4), _box(4, 4, 8, 6)], _to((4, 4), (2, 7)), _to((2, 5), (6, 3), False),
               _to((6, 2), (4.5, 4))),
        _entry("checkerboard", "free cells that touch only in points; a start on one of them", (0, 0, 4, 4),
               [_box(i, j, i + 1, j + 1) for i in range(4) for j in range(4) if (i + j) % 2 == 0],
               _to((0.5, 1.5), (1.5, 0.5), False), _to((2, 2), (1.5, 2.5)), _to((2.25, 3.5), (2.75, 3.25))),
        _entry("ring-touching-in-points", "four obstacles touching in points enclose the goal", _EIGHT,
               [_box(3, 1, 5, 3), _box(1, 3, 3, 5), _box(3, 5, 5, 7), _box(5, 3, 7, 5)], _to((2, 2), (4, 4), False),
               _to((6, 6), (4, 4), False), _to((0.5, 7), (4, 4), False)),
        _entry("lid-touching-twice", "a lid closes a cup in two points", _EIGHT, [cup, _box(2, 6, 6, 7)],
               _to((1, 7), (3, 5), False), _to((3, 3), (5, 5))),
        _entry("lid-touching-once",
               "the straight line through the touching point is closed, the mouth beside it is open", _EIGHT,
               [cup, _box(2, 6, 5, 7)], _to((1.5, 6.5), (2.5, 5.5))),
    ]  # fmt: skip


def _shapes() -> list[Entry]:
    dented = [(2, 1), (3, _UP), (4, 1), (5, _DOWN), (6, 1), (6, 3), (2, 3)]
    repeated = [(2, 2), (4, 2), (4, 2), (5, 2), (6, 2), (6, 4), (6, 6), (6, 6), (6, 6), (4, 6), (2, 6), (2, 3), (2, 2)]
    return [
        _entry("nested", "an obstacle inside another", _EIGHT, [_box(2, 2, 6, 6), _box(3, 3, 5, 5)],
               _to((1, 4), (7, 4))),
        _entry("same-twice", "one obstacle given twice", _EIGHT, [_box(2, 2, 6, 6)] * 2, _to((1, 4), (7, 4))),
        _entry("overlapping", "a cross and a slanted bar over it", _EIGHT,
               [_box(3, 1, 5, 7), _box(1, 3, 7, 5), Polygon([(1.5, 1), (7, 6.5), (6.5, 7), (1, 1.5)])],
               _to((2, 6), (6, 2))),
        _entry("collinear-and-duplicate",
               "corners repeated and corners on straight edges, the ring closed by repetition",
               [(0, 0), (4, 0), (4, 0), (8, 0), (8, 8), (0, 8), (0, 4)], [Polygon(repeated)], _to((1, 4), (7, 4))),
        _entry("clockwise", "the workspace and one of two obstacles turn clockwise", [(0, 0), (0, 8), (8, 8), (8, 0)],
               [Polygon([(2, 2), (2, 4), (6, 4), (6, 2)]), _box(2, 5, 6, 6)], _to((4, 1), (4, 7))),
        _entry("start-on-edge", "starts and goals on edges and on the wall", _EIGHT, [_box(2, 2, 6, 6)],
               _to((3, 2), (5, 6)), _to((0, 3), (8, 5)), _to((2, 4), (2, 5))),
        _entry("start-on-slanted-edge", "the start is exactly on a slanted edge", _EIGHT,
               [Polygon([(2, 2), (6, 4), (2, 6)])], _to((4, 3), (4, 5))),
        _entry("start-on-corner", "starts and goals on corners of obstacles and of the workspace", _EIGHT,
               [_box(2, 2, 6, 6)], _to((2, 2), (6, 6)), _to((0, 0), (8, 8)), _to((6, 2), (0, 8))),
        _entry("one-ulp-dents", "corners off a line by one rounding", _EIGHT, [Polygon(dented)], _to((1, 1), (7, 1))),
        _entry("one-ulp-gap", "two squares one rounding apart", _EIGHT,
               [_box(2, 2, 4, 6), _box(math.nextafter(4, 5), 2, 6, 6)], _to((4, 1), (4, 7))),
        _entry("needles", "triangles a micrometre thick from both sides", _EIGHT,
               [Polygon([(8 * (y % 2), y), (7 - 6 * (y % 2), y), (8 * (y % 2), y + 1e-6)]) for y in range(1, 8)],
               _to((4, 0.5), (4, 7.5))),
        _entry("row-of-squares", "many corners exactly on one line, start and goal on it too", (0, 0, 26, 4),
               [_box(2 * k + 1, 1, 2 * k + 2, 2) for k in range(12)], _to((0, 1), (25.5, 1)),
               _to((0.5, 3), (25, 1.5), radius=0.25)),
        _entry("slanted-row", "many corners on a slanted line, up to rounding", (0, 0, 8, 8),
               [Polygon([(k / 10, 0.3 * k), (k / 10 + 0.2, 0.3 * k), (k / 10, 0.3 * k + 0.1)]) for k in range(2, 26)],
               _to((0.1, 0.3), (2.7, 8)), _to((3, 5), (0.5, 6))),
        _entry("pillars", "a lattice: almost everything is collinear", (0, 0, 10, 10),
               [_box(2 * i + 0.75, 2 * j + 0.75, 2 * i + 1.25, 2 * j + 1.25) for i in range(5) for j in range(5)],
               _to((0, 0), (10, 10)), _to((2, 8), (8, 2), radius=0.5)),
    ]  # fmt: skip


def _at_the_wall() -> list[Entry]:
    ell = [(0, 0), (8, 0), (8, 4), (4, 4), (4, 8), (0, 8)]
    comb = [(0, 0), (16, 0)] + [
        p for k in range(8) for p in ((16 - 2 * k, 6), (15 - 2 * k, 6), (15 - 2 * k, 2), (14 - 2 * k, 2))
    ]  # fmt: skip
    apex = Polygon([(4, 0), (6, 3), (2, 3)])
    return [
        _entry("wall-at-a-point", "an obstacle touches the wall in a point", _EIGHT, [apex], _to((2, 1), (6, 1)),
               _to((1, 2), (7, 2), radius=0.5)),
        _entry("wall-along-an-edge", "an obstacle stands at the wall", _EIGHT, [_box(3, 0, 5, 3)], _to((2, 0), (6, 0))),
        _entry("wall-corner", "obstacles fill corners of the workspace", _EIGHT, [_box(0, 0, 2, 2), _box(5, 5, 8, 8)],
               _to((0, 2), (8, 5)), _to((1, 3), (4, 7), radius=0.5)),
        _entry("wall-twice", "touching the wall in two points encloses a pocket", _EIGHT,
               [Polygon([(0, 3), (3, 0), (4, 4)])], _to((6, 6), (1, 1), False), _to((0.5, 1), (1.5, 1))),
        _entry("sticking-out", "obstacles leave the workspace or are outside it", _EIGHT,
               [_box(3, -1, 5, 4), Polygon([(7, 5), (9, 4), (9, 7)]), _box(10, 10, 12, 12)], _to((2, 1), (6, 1)),
               _to((1, 6), (6, 6), radius=0.5)),
        _entry("cut-in-two", "an obstacle from wall to wall", _EIGHT, [_box(-1, 3, 9, 5)], _to((4, 2), (4, 6), False),
               _to((1, 1), (7, 3))),
        _entry("ell", "a reflex corner of the workspace", ell, [], _to((2, 7), (7, 2)),
               _to((1, 6), (6, 1), radius=0.5)),
        _entry("ell-touched", "an obstacle touches the reflex corner of the workspace", ell, [_box(2, 2, 4, 4)],
               _to((3, 5), (5, 3))),
        _entry("comb", "a workspace of many teeth", comb, [], _to((15.5, 5.5), (1.5, 5.5)),
               _to((7.5, 5), (13.5, 5), radius=0.25)),
        _entry("star", "a star-shaped courtyard", _ring((0, 0), (8, 3), 16), [_box(-1, -1, 1, 1)], _to((6, 0), (-6, 0)),
               _to((0, 5), (0, -5), radius=0.25)),
    ]  # fmt: skip


def _mazes() -> list[Entry]:
    turns = [(2, 2), (14, 2), (14, 14), (2, 14), (2, 5), (11, 5), (11, 11), (5, 11), (5, 8), (8, 8)]
    walls = [
        _box(min(a[0], b[0]) - 0.25, min(a[1], b[1]) - 0.25, max(a[0], b[0]) + 0.25, max(a[1], b[1]) + 0.25)
        for a, b in pairwise(turns)
    ]  # fmt: skip
    frames = [_box(1, 1, 11, 2), _box(1, 10, 11, 11), _box(1, 2, 2, 10), _box(10, 2, 11, 5), _box(10, 7, 11, 10)]
    frames += [_box(3, 3, 9, 4), _box(3, 8, 9, 9), _box(8, 4, 9, 8), _box(3, 4, 4, 5), _box(3, 7, 4, 8)]
    closed = [_box(2, 2, 6, 3), _box(2, 5, 6, 6), _box(2, 3, 3, 5), _box(5, 3, 6, 5)]
    sixteen, twelve = (0, 0, 16, 16), (0, 0, 12, 12)
    return [
        _entry("spiral", "a long way inwards between walls that share edges", sixteen, walls,
               _to((0.5, 0.5), (6.5, 9.5)), _to((15, 15), (8, 9.5), radius=0.75)),
        _entry("spiral-line", "the same spiral as one thick line", sixteen, [Line(turns, 0.5)],
               _to((0.625, 0.625), (6.5, 9.5), radius=0.5), _to((15, 15), (8, 9.5))),
        _entry("courtyards", "islands in courtyards in courtyards", twelve, [*frames, _box(5, 5, 6, 7)],
               _to((0.5, 0.5), (7, 6)), _to((11.5, 6), (4.5, 6), radius=0.25)),
        _entry("enclosed-goal", "a courtyard without a door", _EIGHT, closed, _to((1, 1), (4, 4), False),
               _to((1, 7), (7, 1))),
        _entry("start-at-the-limit", "a disc that touches two walls at its start, an obstacle at its goal", _EIGHT,
               [_box(2, 2, 6, 6)], _to((0.5, 0.5), (6.5, 4), radius=0.5)),
        _entry("zero-width", "the corridor has exactly the robot's width: closed", _EIGHT,
               [_box(0, 3, 3.5, 5), _box(4.5, 3, 8, 5)], _to((4, 1), (4, 7), False, 0.5), _to((1, 1), (1, 7))),
        _entry("zero-width-clearance", "the clearance closes the corridor", _EIGHT,
               [_box(0, 3, 3.5, 5), _box(4.5, 3, 8, 5)], _to((4, 1), (4, 7), False, 0.25), clearance=0.25),
        _entry("zero-width-way-round", "a corridor of exactly the robot's width, and a way round", _EIGHT,
               [_box(2, 3, 3.5, 5), _box(4.5, 3, 8, 5)], _to((4, 1), (4, 7), True, 0.5)),
        _entry("hair-width", "the corridor is a thousandth wider than the robot", _EIGHT,
               [_box(0, 3, 3.5, 5), _box(4.5 + 2**-10, 3, 8, 5)], _to((4, 1), (4, 7), True, 0.5)),
        _entry("slots", "slots for robots of several sizes", (0, 0, 20, 12),
               [_box(0, 5, 2, 7), _box(3, 5, 8, 7), _box(10, 5, 14, 7), _box(17, 5, 20, 7)],
               _to((2, 2), (2, 10), radius=0.4), _to((7, 2), (7, 10), radius=0.9), _to((12, 2), (12, 10), radius=1.4),
               _to((17, 2), (17, 10), False, 1.6), gap=0.05),
        _entry("circles", "discs apart, touching and overlapping", twelve,
               [Circle((3, 3), 1), Circle((5, 3), 1), Circle((8, 8), 1.5), Circle((9, 9), 1), Circle((4, 9), 0.01)],
               _to((4, 1), (4, 6)), _to((11, 11), (6, 6), radius=0.25)),
        _entry("circle-of-circles", "overlapping discs enclose a goal", twelve,
               [Circle(p, 1) for p in _ring((6, 6), (4,), 16)], _to((1, 1), (6, 6), False),
               _to((6, 7), (6, 5), radius=0.5)),
        _entry("zigzags", "thick zigzag walls that cross", twelve,
               [Line([(1, 2), (4, 5), (7, 2), (10, 5)], 0.3), Line([(2, 10), (5, 3), (8, 10)], 0.2)],
               _to((4, 2), (4.5, 11)), _to((1, 8), (11, 8), radius=0.4)),
        _entry("zigzag-across", "a zigzag from wall to wall", twelve, [Line([(0, 4), (4, 8), (8, 4), (12, 8)], 0.25)],
               _to((6, 1), (6, 11), False, 0.25), _to((1, 1), (11, 4), radius=0.25)),
        _entry("turned-rectangles", "turned rectangles that touch and overlap the wall", twelve,
               [Rectangle(3, 3, 4, 1, 0.5), Rectangle(5, 5, 1, 5, -0.3), Rectangle(9, -1, 2, 4, math.pi / 4)],
               _to((2, 5), (8, 8), radius=0.2), _to((7, 1), (11, 6))),
    ]  # fmt: skip


def _thesis() -> list[Entry]:
    corners: list[list[Point]] = [
        [(4.5, 2), (7.8, 2), (7.8, 4), (4.5, 4)],
        [(2, 2.5), (3.3, 4.8), (3.3, 7), (2, 8.5)],
        [(5, 6), (7.5, 6), (9, 7.5), (7.5, 9), (5.2, 9)],
        [(1, 10), (3.2, 9.5), (2.5, 13)],
        [(6.2, 12), (10.8, 12.9), (7.2, 14), (4.5, 12.6)],
        [(10, 10), (11.5, 10), (11.5, 5), (10, 5)],
    ]  # fmt: skip
    third: list[list[Point]] = [
        [(0.5, 6), (2.004, 6), (2.004, 6.562), (0.5, 6.562)],
        [(3.429, 0), (5.501, 0), (4.958, 2.018), (3.429, 2.018)],
        [(5.52, 5.951), (7, 5.951), (7, 6.5), (5, 6.5)],
        [(4.5, 9.5), (6.8, 9.5), (6.8, 12), (6.401, 12), (6.401, 10), (4.5, 10)],
        [(10, 6), (12, 6), (12, 6.5), (10, 6.5)],
        [(10, 2.962), (12, 2.962), (12, 3.5), (10, 3.5)],
    ]  # fmt: skip
    sixteen = (0, 0, 16, 16)
    first = [Polygon(c) for c in corners]
    boxes = [(5, 3, 4, 2), (13, 5, 2, 5), (0.9, 3.7, 2, 5), (7.2, 12.7, 5, 2)]
    return [
        _entry("thesis-1", "one goal for three, on the wall", sixteen, first, _to((2, 1), (5, 16)),
               _to((8.7, 0.3), (5, 16)), _to((11, 1), (5, 16))),
        _entry("thesis-2", "a start on the wall", sixteen, first, _to((3, 1), (12, 12.7)), _to((3.4, 16), (11, 1)),
               _to((8.7, 0.3), (0.5, 9))),
        _entry("thesis-3", "obstacles at the wall in part, one of them non-convex", (0.5, 0, 12, 12),
               [Polygon(c) for c in third], _to((10.6, 4), (1.5, 10.5)), _to((9.5, 11.44), (1, 3.51)),
               _to((6.2, 1.38), (11.65, 11.29))),
        _entry("appendix-d", "rectangles and a big disc", sixteen,
               [*(Rectangle(*b) for b in boxes), Circle((2.5, 12), 2)], _to((3, 2.1), (12.7, 12)),
               _to((4.5, 15.5), (11.8, 3)), _to((10.2, 2.3), (1.2, 10))),
    ]  # fmt: skip


def _scales(bases: Iterable[Entry]) -> list[Entry]:
    sizes = [("nano", 1e-9, 0.0), ("mega", 1e6, 0.0), ("far", 1.0, 1e6), ("mega-far", 1e6, 1e6)]
    return [
        replace(
            base,
            name=f"{base.name}-{size}",
            scene=transformed(base.scene, factor, shift),
            awkward=f"{base.awkward}; {factor:g} times as large, {shift:g} m away",
        )
        for base in bases
        for size, factor, shift in sizes
    ]  # fmt: skip


_SCALED = ("one-square", "touching-corners", "seam-wall", "lid-touching-once", "start-on-edge", "hair-width", "zigzags")
_BASES = (*_plain(), *_touching(), *_shapes(), *_at_the_wall(), *_mazes(), *_thesis())

ZOO: tuple[Entry, ...] = (*_BASES, *_scales(entry for entry in _BASES if entry.name in _SCALED))
POLYGONS_ONLY: tuple[Entry, ...] = tuple(entry for entry in ZOO if grows_nothing(entry.scene.obstacles))
