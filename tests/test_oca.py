"""OCA finds the same lengths as a search of the whole free space, from the few obstacles that matter."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest
import shapely
from hypothesis import given, settings
from numpy.typing import ArrayLike

from strategies import scenes
from taut.errors import GoalBlocked, NoPath, SceneError, StartBlocked
from taut.formats import load_scene
from taut.freespace import FreeSpace
from taut.geometry.cores import cores_of
from taut.geometry.growth import grown
from taut.route.direct import shortest_path
from taut.route.obstacles import ObstacleIndex, index_obstacles, obstacles_beside, obstacles_near
from taut.route.oca import OcaRoute, oca_between, oca_path, oca_path_or_widest
from taut.scene import Circle, FloatArray, Line, Obstacle, Polygon, Rectangle, Robot, Scene
from zoo import ZOO, Entry

READY = (
    "appendix-d",
    "corridor-swap",
    "crossing-30",
    "hospital-12",
    "office-20",
    "thesis-1",
    "thesis-2",
    "thesis-3",
    "warehouse-50",
)
FAILURES = (StartBlocked, GoalBlocked, NoPath)
WORKSPACES = (
    [(0, 0), (8, 0), (8, 8), (0, 8)],
    [(0, 0), (8, 0), (8, 4), (4, 4), (4, 8), (0, 8)],
    [(0, 0), (4, 2), (8, 0), (8, 4), (8, 8), (0, 8)],
    [(0, 0), (8, 0), (8, 8), (5, 8), (5, 3), (3, 3), (3, 8), (0, 8)],
)
MIXED: tuple[Obstacle, ...] = (
    Polygon([(1, 1), (3, 1), (3, 2)], "triangle"),
    Rectangle(5, 1, 2, 1, 0.5, "turned"),
    Circle((2, 5), 1, "disc"),
    Line([(4, 4), (6, 6), (7, 4)], 0.4, "zigzag"),
)


def random_obstacle(rng: np.random.Generator) -> Obstacle:
    """On the grid or off it, non-convex or round, up to 2 m outside a square of 8 m."""
    x, y = rng.integers(-1, 8, 2).tolist() if rng.random() < 0.6 else rng.uniform(-1, 8, 2).tolist()
    w, h = rng.integers(1, 4, 2).tolist()
    match rng.integers(6):
        case 0:
            return Circle((x, y), float(rng.choice([0.5, 1.0, rng.uniform(0.1, 1.5)])))
        case 1:
            return Line([(x, y), (x + w, y), (x + w, y + h)], float(rng.choice([0.1, 0.5])))
        case 2:
            return Polygon([(x, y), (x + w, y), (x, y + h)])
        case 3:
            return Polygon(
                [(x, y), (x + w + 1, y), (x + w + 1, y + 1), (x + 1, y + 1), (x + 1, y + h + 1), (x, y + h + 1)]
            )
        case 4:
            return Rectangle(x, y, w, h, float(rng.uniform(-3, 3)))
        case _:
            return Polygon([(x, y), (x + w, y), (x + w, y + h), (x, y + h)])


def random_world(rng: np.random.Generator) -> Scene:
    obstacles = [random_obstacle(rng) for _ in range(rng.integers(0, 14))]
    return Scene(WORKSPACES[rng.integers(len(WORKSPACES))], obstacles)


def random_places(rng: np.random.Generator, whole: FreeSpace) -> FloatArray:
    """Two places, free if there are such among those drawn: anywhere, on the half-integer grid, on corners, (2, 2)."""
    corners = np.concatenate([np.array(whole.scene.workspace), *(o.core for o in whole.scene.obstacles)])
    drawn = [rng.uniform(0, 8, (12, 2)), rng.integers(0, 17, (12, 2)) / 2, rng.choice(corners, 6)]
    places: FloatArray = rng.permutation(np.concatenate(drawn))
    blocked = whole.anchor(places)[1] < 0
    # a stable sort, so that the free ones come first
    order = np.argsort(blocked, kind="stable") if rng.random() < 0.85 else np.arange(len(places))
    return places[order[:2]]


def check_as_whole(route: OcaRoute, whole: FreeSpace, a: ArrayLike, b: ArrayLike) -> None:
    expected = shortest_path(whole, a, b)
    assert route.length == pytest.approx(expected.length, rel=1e-12, abs=whole.scene.tol)
    assert (route.points[[0, -1]] == [a, b]).all()
    assert route.optimal
    assert route.total == len(whole.scene.obstacles)
    assert route.growth == whole.growth
    assert route.freespace.scene.tol == whole.scene.tol
    assert list(route.freespace.scene.obstacles) == [o for o in whole.scene.obstacles if o.name in route.used]
    check_rounds(route)


def check_rounds(route: OcaRoute) -> None:
    """Rounds add each obstacle once, whatever was hit next time, and the last one hits nothing."""
    added = [name for found in route.rounds for name in found.added]
    assert tuple(added) == route.used
    assert len(set(added)) == len(added)
    for before, after in zip(route.rounds, route.rounds[1:], strict=False):
        assert set(before.hit) <= set(after.added)
    assert route.rounds[-1].hit == ()
    assert (route.rounds[-1].points == route.points).all()


def check_between(index: ObstacleIndex, whole: FreeSpace, a: ArrayLike, b: ArrayLike) -> bool:
    """The same answer as the whole free space, an error or a length; returns whether there was a path."""
    try:
        route = oca_between(index, a, b, whole.growth, whole.arc_error)
    except FAILURES as error:
        with pytest.raises(type(error)):
            shortest_path(whole, a, b)
        return False
    check_as_whole(route, whole, a, b)
    return True


def check_robots(scene: Scene) -> None:
    index = index_obstacles(scene)
    spaces = {growth: FreeSpace(scene, growth) for growth in {scene.growth(robot) for robot in scene.robots}}
    for robot in scene.robots:
        whole = spaces[scene.growth(robot)]
        try:
            route = oca_path(index, robot)
        except FAILURES as error:
            with pytest.raises(type(error)):
                shortest_path(whole, robot.start, robot.goal)
            continue
        check_as_whole(route, whole, robot.start, robot.goal)


def turned(points: ArrayLike, angle: float) -> FloatArray:
    c, s = math.cos(angle), math.sin(angle)
    out: FloatArray = np.asarray(points, dtype=np.float64) @ np.array([[c, s], [-s, c]])
    return out


def field(side: int, seed: int) -> Scene:
    """Side² small disjoint polygons, discs and walls, one in each square metre."""
    rng = np.random.default_rng(seed)
    obstacles: list[Obstacle] = []
    for x in range(side):
        for y in range(side):
            at = np.array([x + 0.5, y + 0.5]) + rng.uniform(-0.1, 0.1, 2)
            angle = 2 * math.pi * (np.arange(5) + rng.uniform(-0.2, 0.2, 5)) / 5
            ring = at + rng.uniform(0.15, 0.35) * np.stack([np.cos(angle), np.sin(angle)], axis=1)
            obstacles.append(Circle(at.tolist(), 0.3) if rng.random() < 0.2 else Polygon(ring.tolist()))
    return Scene((0, 0, side, side), obstacles)


def maze(side: int, seed: int) -> Scene:
    """A maze with one way between any two cells of 1 m; its walls are pieces of 1 m that touch and overlap."""
    rng = np.random.default_rng(seed)
    doors, seen, stack = set(), {(0, 0)}, [(0, 0)]
    while stack:
        x, y = stack[-1]
        around = [(x + 1, y), (x - 1, y), (x, y + 1), (x, y - 1)]
        fresh = [p for p in around if min(p) >= 0 and max(p) < side and p not in seen]
        if not fresh:
            stack.pop()
            continue
        there = fresh[rng.integers(len(fresh))]
        doors.add(frozenset([(x, y), there]))
        seen.add(there)
        stack.append(there)
    pieces = []
    for x in range(side):
        for y in range(side):
            if x + 1 < side and frozenset([(x, y), (x + 1, y)]) not in doors:
                pieces.append(Rectangle(x + 0.9, y - 0.1, 0.2, 1.2))
            if y + 1 < side and frozenset([(x, y), (x, y + 1)]) not in doors:
                pieces.append(Rectangle(x - 0.1, y + 0.9, 1.2, 0.2))
    return Scene((0, 0, side, side), pieces)


@pytest.mark.parametrize("seed", range(10))
def test_a_thousand_scenes_have_the_lengths_and_errors_of_the_whole_free_space(seed: int) -> None:
    rng = np.random.default_rng(seed)
    found = 0
    for _ in range(100):
        scene = random_world(rng)
        whole = FreeSpace(scene, float(rng.choice([0.0, 0.0, 0.25, 0.5, rng.uniform(0, 0.6)])), 0.02)
        found += check_between(index_obstacles(scene), whole, *random_places(rng, whole))
    assert found > 50


@pytest.mark.parametrize("entry", ZOO, ids=str)
def test_zoo_robots_have_the_lengths_and_errors_of_the_whole_free_space(entry: Entry) -> None:
    check_robots(entry.scene)


@pytest.mark.parametrize("name", READY)
def test_robots_of_ready_scenes_have_the_lengths_of_the_whole_free_space(name: str) -> None:
    check_robots(load_scene(name))


@settings(max_examples=60, deadline=None)
@given(scenes(max_obstacles=8, max_radius=0.4))
def test_drawn_robots_have_the_lengths_and_errors_of_the_whole_free_space(scene: Scene) -> None:
    check_robots(scene)


@pytest.mark.parametrize("growth", [0.0, 0.08])
def test_a_large_map_needs_few_of_its_obstacles(growth: float) -> None:
    scene = field(20, 3)
    index = index_obstacles(scene)
    whole = FreeSpace(scene, growth, 0.02)
    near = oca_between(index, (10, 10), (12, 11), growth, 0.02)
    check_as_whole(near, whole, (10, 10), (12, 11))
    assert len(near.used) < 0.05 * near.total
    check_as_whole(oca_between(index, (0.1, 0.1), (19.9, 19.9), growth, 0.02), whole, (0.1, 0.1), (19.9, 19.9))


@pytest.mark.parametrize("growth", [0.0, 0.2])
def test_the_way_through_a_maze_of_touching_pieces_is_found(growth: float) -> None:
    scene = maze(20, 1)
    route = oca_between(scene, (0.5, 0.5), (19.5, 19.5), growth, 0.02)
    check_as_whole(route, FreeSpace(scene, growth, 0.02), (0.5, 0.5), (19.5, 19.5))


@pytest.mark.parametrize("growth", [0.0, 0.2])
def test_a_wall_of_many_touching_pieces_takes_few_rounds(growth: float) -> None:
    scene = Scene((-90, -90, 90, 90), [Rectangle(3, y, 1, 1) for y in range(-70, 60)])
    route = oca_between(scene, (0, 0), (7, 0), growth, 0.02)
    check_as_whole(route, FreeSpace(scene, growth, 0.02), (0, 0), (7, 0))
    assert len(route.rounds) <= 6 + math.log(len(scene.obstacles)) / math.log(1.5)


@pytest.mark.parametrize("growth", [0.0, 0.2])
def test_a_goal_shut_in_by_touching_pieces_is_found_out(growth: float) -> None:
    scene = maze(12, 2)
    lid = Rectangle(9, 9, 0.1, 3, name="lid 1"), Rectangle(9, 9, 3, 0.1, name="lid 2")
    with pytest.raises(NoPath, match="separate"):
        oca_between(Scene(scene.workspace, [*scene.obstacles, *lid]), (0.5, 0.5), (11.5, 11.5), growth)


@pytest.mark.parametrize("angle", np.linspace(0.1, 6.0, 60))
def test_no_way_leads_through_a_touching_point_whatever_the_rounding(angle: float) -> None:
    squares = [(2, 2), (4, 2), (4, 4), (2, 4)], [(4, 4), (6, 4), (6, 6), (4, 6)]
    world = [(-9, -9), (9, -9), (9, 9), (-9, 9)]
    scene = Scene(turned(world, angle).tolist(), [Polygon(turned(square, angle).tolist()) for square in squares])
    a, b = turned([(3, 5), (5, 3)], angle)
    assert check_between(index_obstacles(scene), FreeSpace(scene), a, b)
    assert oca_between(scene, a, b).length > 5


@pytest.mark.parametrize("angle", np.linspace(0.1, 6.0, 30))
def test_no_way_leads_along_a_gap_of_zero_width_whatever_the_rounding(angle: float) -> None:
    blocks = [(-8, -1), (-0.3, -1), (-0.3, 1), (-8, 1)], [(0.3, -1), (8, -1), (8, 1), (0.3, 1)]
    world = [(-9, -9), (9, -9), (9, 9), (-9, 9)]
    scene = Scene(turned(world, angle).tolist(), [Polygon(turned(block, angle).tolist()) for block in blocks])
    a, b = turned([(0, -3), (0, 3)], angle)
    assert check_between(index_obstacles(scene), FreeSpace(scene, 0.3), a, b)
    assert oca_between(scene, a, b, 0.3).length > 15
    assert oca_between(scene, a, b, 0.299).length == pytest.approx(6.0)


def test_a_route_met_first_by_a_touching_neighbour_goes_round_both() -> None:
    pieces = [Rectangle(3, -y - 1, 1, 1) for y in range(8)] + [Rectangle(3, y, 1, 1) for y in range(3)]
    scene = Scene((-9, -9, 9, 9), pieces, [Robot("R1", (0, 0), (7, 0))])
    route = oca_path(scene, "R1")
    assert route.length == pytest.approx(math.hypot(3, 3) * 2 + 1)
    assert route.rounds[0].points[:, 1].max() <= 1


@pytest.mark.parametrize("growth", [0.0, 0.3])
def test_obstacles_elsewhere_do_not_change_the_route_bit_for_bit(growth: float) -> None:
    scene = Scene((-20, -20, 20, 20), MIXED)
    before = oca_between(scene, (0, 0), (8, 8), growth)
    elsewhere: list[Obstacle] = [
        Circle((-15, 15), 2),
        *MIXED,
        Polygon([(-12, -12), (-10, -12), (-10, -15)]),
        Circle((14, -9), 1),
    ]
    after = oca_between(Scene((-20, -20, 20, 20), elsewhere), (0, 0), (8, 8), growth)
    assert (before.points == after.points).all()
    assert before.used == after.used


def test_an_obstacle_across_the_route_makes_it_longer_and_is_used() -> None:
    scene = Scene((-20, -20, 20, 20), MIXED)
    before = oca_between(scene, (0, 0), (8, 8), 0.1)
    middle = before.points[:2].mean(axis=0)
    across = Circle(tuple(middle.tolist()), 0.5, "across")
    after = oca_between(replace(scene, obstacles=(*MIXED, across)), (0, 0), (8, 8), 0.1)
    assert after.length > before.length
    assert "across" in after.used


def test_one_place_is_a_route_of_one_row() -> None:
    route = oca_between(Scene((0, 0, 8, 8), MIXED), (4, 3), (4, 3), 0.1)
    assert (route.points == [(4, 3)]).all()
    assert route.length == 0.0
    assert route.optimal


def test_without_obstacles_the_wall_alone_bends_the_route() -> None:
    route = oca_between(Scene(WORKSPACES[1]), (8, 2), (2, 8))
    assert route.length == pytest.approx(2 * math.hypot(4, 2))
    assert route.used == ()
    assert len(route.rounds) == 1


def test_a_clearance_asked_for_is_as_if_the_robot_had_it() -> None:
    robot = Robot("R1", (0.5, 4), (7.5, 4), radius=0.1)
    far = Circle((1e6, 0), 1)  # the largest coordinate, from which the tolerance follows
    scene = Scene(
        (0, 0, 8, 8), [far, Rectangle(3, 3, 2, 2)], [robot, Robot("R2", (1, 1), (7, 7), radius=0.2)], clearance=0.1
    )
    for clearance in (0.0, 0.1, 0.4):
        changed = replace(robot, clearance=clearance)
        whole = FreeSpace.of(replace(scene, robots=(changed, scene.robots[1])), changed)
        route = oca_path(scene, "R1", clearance)
        check_as_whole(route, whole, robot.start, robot.goal)
        assert (route.clearance, route.wanted, route.passage) == (clearance, clearance, None)
    assert oca_path(scene, robot).clearance == 0.1


def test_a_start_and_goal_at_exactly_the_clearance_are_free() -> None:
    angle = np.linspace(0.0, 6.0, 40)
    around = np.array([4, 4]) + 1.5 * np.stack([np.cos(angle), np.sin(angle)], axis=1)
    scene = Scene((0, 0, 8, 8), [Circle((4, 4), 1)])
    index = index_obstacles(scene)
    for start, goal in zip(around, np.roll(around, 7, axis=0), strict=True):
        robot = Robot("R1", start.tolist(), goal.tolist(), radius=0.2)
        peopled = replace(index, scene=replace(scene, robots=(robot,)))
        route = oca_path(peopled, "R1", clearance=0.3)
        changed = replace(robot, clearance=0.3)
        check_as_whole(route, FreeSpace.of(replace(scene, robots=(changed,)), changed), start, goal)


def test_the_widest_passage_is_taken_where_no_way_keeps_the_clearance() -> None:
    blocks = (
        Rectangle(3, 0, 2, 3, name="low"),
        Rectangle(3, 4, 2, 1.8, name="middle"),
        Rectangle(3, 7, 2, 1, name="high"),
    )
    scene = Scene((0, 0, 8, 8), blocks, [Robot("R1", (1, 3.5), (7, 3.5), radius=0.2)])
    assert oca_path_or_widest(scene, "R1", 0.3 - 1e-9).passage is None
    route = oca_path_or_widest(scene, "R1", 0.7)
    assert route.wanted == 0.7
    assert 0.4 - 2e-3 * 0.6 < route.clearance <= 0.4
    assert route.passage is not None
    assert set(route.passage.between) == {"middle", "high"}
    check_as_whole(route, FreeSpace(scene, route.growth), (1, 3.5), (7, 3.5))
    with pytest.raises(NoPath, match="R1"):
        oca_path(scene, "R1", 0.7)


def test_the_widest_passage_between_large_discs_is_found() -> None:
    scene = Scene((0, -20, 80, 30), [Circle((40, -40.0), 44), Circle((40, 50), 44)], [Robot("R1", (5, 5), (75, 5))])
    route = oca_path_or_widest(scene, "R1", 1.5)
    assert 0.8 < route.clearance <= 1.0
    with pytest.raises(NoPath, match="R1"):
        oca_path_or_widest(replace(scene, robots=(Robot("R1", (5, 5), (75, 5), radius=1.1),)), "R1")


@pytest.mark.parametrize(
    ("start", "goal", "clearance", "error", "words"),
    [
        ((2.5, 4), (7, 7), 0.4, StartBlocked, ("R1", "start (2.5, 4)", "obstacle box", "clearance of at most 0.3 m")),
        ((7, 7), (2.5, 4), 0.4, GoalBlocked, ("R1", "goal (2.5, 4)", "obstacle box", "clearance of at most 0.3 m")),
        ((4, 4), (7, 7), 0.0, StartBlocked, ("R1", "inside obstacle box")),
        ((7, 7), (2.9, 4), 0.1, GoalBlocked, ("R1", "obstacle box", "no clearance would fit")),
        ((0.3, 1), (7, 7), 0.2, StartBlocked, ("R1", "0.3 m from the wall", "clearance of at most 0.1 m")),
        ((9, 1), (7, 7), 0.2, StartBlocked, ("R1", "outside the workspace")),
    ],
)  # fmt: skip
def test_blocked_ends_name_the_obstacle_and_the_clearance_that_fits(
    start: tuple[float, float],
    goal: tuple[float, float],
    clearance: float,
    error: type[SceneError],
    words: tuple[str, ...],
) -> None:
    scene = Scene((0, 0, 8, 8), [Rectangle(3, 3, 2, 2, name="box")], [Robot("R1", start, goal, radius=0.2)])
    with pytest.raises(error) as told:
        oca_path(scene, "R1", clearance)
    for word in words:
        assert word in str(told.value)


def test_the_clearance_that_is_said_to_fit_does_fit() -> None:
    rng = np.random.default_rng(5)
    disc = Circle((4, 4), 1)
    for _ in range(20):
        at = np.array([4, 4]) + rng.uniform(1.3, 1.9) * turned((1, 0), rng.uniform(0, 6))
        scene = Scene((0, 0, 8, 8), [disc], [Robot("R1", at.tolist(), (7, 7), radius=0.1)])
        with pytest.raises(StartBlocked) as told:
            oca_path(scene, "R1", 0.9)
        fits = float(str(told.value).split()[-2])
        assert oca_path(scene, "R1", fits).optimal
        assert fits > 0.99 * (np.hypot(*(at - [4, 4])) - 1.1)


@pytest.mark.parametrize("clearance", [-1.0, math.nan, math.inf])
def test_clearances_that_are_none_are_refused_by_the_robots_name(clearance: float) -> None:
    scene = Scene((0, 0, 8, 8), (), [Robot("R1", (1, 1), (2, 2))])
    with pytest.raises(SceneError, match="robot R1: clearance"):
        oca_path(scene, "R1", clearance)


def test_bad_arguments_are_told_in_one_line() -> None:
    scene = Scene((0, 0, 8, 8), MIXED, [Robot("R1", (1, 3), (4, 3))])
    with pytest.raises(SceneError, match="no robot R2"):
        oca_path(scene, "R2")
    with pytest.raises(SceneError, match="robot R1 is not the one"):
        oca_path(scene, Robot("R1", (1, 3), (4, 4)))
    with pytest.raises(ValueError, match="b must be one point"):
        oca_between(scene, (1, 3), [(1, 1)])
    with pytest.raises(ValueError, match="a must be one point"):
        oca_between(scene, (math.nan, 3), (1, 1))
    for growth in (-0.1, math.nan, math.inf):
        with pytest.raises(SceneError, match="growth"):
            oca_between(scene, (1, 3), (4, 3), growth)
    with pytest.raises(SceneError, match="obstacle bow"):
        index_obstacles(Scene((0, 0, 8, 8), [Polygon([(0, 0), (1, 1), (1, 0), (0, 1)], "bow")]))


@pytest.mark.parametrize("seed", range(20))
def test_near_obstacles_are_all_that_the_polyline_touches_once_they_are_grown(seed: int) -> None:
    rng = np.random.default_rng(seed)
    scene = Scene((0, 0, 8, 8), [random_obstacle(rng) for _ in range(20)])
    index = index_obstacles(scene)
    points = rng.uniform(-1, 9, (rng.integers(1, 5), 2))
    line = shapely.LineString(points) if len(points) > 1 else shapely.Point(points[0])
    for growth in (0.0, 0.3):
        found = set(obstacles_near(index, points, growth, 0.1).tolist())
        least = {k for k, o in enumerate(scene.obstacles) if grown(o, growth, 0.1).distance(line) <= scene.tol}
        most = {k for k, o in enumerate(scene.obstacles) if grown(o, 1.1 * growth + 0.2, 1e-3).distance(line) == 0}
        assert least <= found <= most


def test_near_obstacles_include_walls_whose_drawn_outline_alone_is_touched() -> None:
    wall = Line([(-3, -1), (0, 0)], 2)
    corners = shapely.get_coordinates(grown(wall, 0.0, 0.3))
    touched = corners[np.argmax(corners[:, 0])]
    assert touched[0] > 1.05
    index = index_obstacles(Scene((-4, -4, 4, 4), [wall]))
    assert obstacles_near(index, [touched], 0.0, 0.3).tolist() == [0]
    assert obstacles_near(index, [touched], 0.0, 0.01).tolist() == []


@pytest.mark.parametrize("seed", range(10))
def test_obstacles_beside_others_are_the_nearest_by_their_boxes(seed: int) -> None:
    rng = np.random.default_rng(seed)
    scene = Scene((0, 0, 8, 8), [random_obstacle(rng) for _ in range(30)])
    index = index_obstacles(scene)
    numbers, but = np.split(rng.permutation(30)[:9], [4])
    distance = shapely.distance(index.tree.geometries[:, None], index.tree.geometries[numbers]).min(axis=1)
    left = np.setdiff1d(np.arange(30), np.append(numbers, but))
    for count in (0, 1, 7, 21, 50):
        found = obstacles_beside(index, numbers, count, but)
        assert (distance[found] == np.sort(distance[left])[:count]).all()
        assert len(set(found.tolist())) == min(count, 21)
        assert set(found.tolist()) <= set(left.tolist())


def test_cores_are_the_shapes_without_their_own_radius() -> None:
    shapes: list[Obstacle] = [*MIXED, Line([(0, 0), (1, 1)], 1), Circle((0, 0), 2), *MIXED]
    for core, shape in zip(cores_of(shapes), shapes, strict=True):
        assert (core.geom_type == "Polygon") == shape.closed
        corners = shapely.get_coordinates(core)
        assert (corners[: len(shape.core)] == shape.core).all()
    assert len(cores_of([])) == 0
