"""The widest passage is as wide as the free space says, where it says so, between whom it says."""

from __future__ import annotations

import math

import numpy as np
import pytest
import shapely
from hypothesis import given, settings
from hypothesis import strategies as st

from strategies import scenes
from taut.errors import GoalBlocked, SceneError, StartBlocked
from taut.freespace import FreeSpace
from taut.generate import random_scene
from taut.route.passage import Passage, widest_passage
from taut.scene import Circle, FloatArray, Line, Obstacle, Point, Polygon, Rectangle, Scene
from zoo import ZOO, Entry, transformed

ARC = 1e-4
PLACES = st.tuples(*[st.integers(0, 16).map(lambda k: k / 2) | st.floats(0, 8).map(lambda x: round(x, 6))] * 2)


def box(x0: float, y0: float, x1: float, y1: float, name: str = "") -> Polygon:
    return Polygon([(x0, y0), (x1, y0), (x1, y1), (x0, y1)], name)


def joined(scene: Scene, growth: float, arc_error: float, a: Point, b: Point) -> bool:
    """Whether the free space for this growth joins the two."""
    one, two = FreeSpace(scene, growth, arc_error).part_of([a, b])
    return bool(one & two)


def distance_to(scene: Scene, name: str, place: FloatArray | Point) -> float:
    """Distance of a point from the surface of an obstacle or the wall."""
    here = shapely.Point(place)
    if name == "the wall":
        return float(shapely.LinearRing(scene.workspace).distance(here))
    (obstacle,) = (o for o in scene.obstacles if o.name == name)
    core = obstacle.core
    if obstacle.closed:
        return float(shapely.LinearRing(core).distance(here))
    line = shapely.LineString(core) if len(core) > 1 else shapely.Point(core[0])
    return float(abs(line.distance(here) - obstacle.own_radius))


def check_consistent(scene: Scene, a: Point, b: Point, passage: Passage) -> None:
    """The place is between those named, as far from both as the clearance, and nothing is nearer."""
    slack = 8 * scene.tol
    clearance, place, ends = passage.clearance, passage.place, passage.ends
    if passage.between[0] in ("start", "goal") and passage.between[0] not in {o.name for o in scene.obstacles}:
        assert place == (a if passage.between[0] == "start" else b)
        assert math.dist(ends[0], place) == 0
        assert abs(math.dist(ends[1], place) - clearance) <= slack
        assert abs(distance_to(scene, passage.between[1], place) - clearance) <= slack
    elif clearance > 0:
        assert np.allclose(ends.mean(axis=0), place, rtol=0, atol=slack)
        assert abs(math.dist(*ends) - 2 * clearance) <= slack
        for name, end in zip(passage.between, ends, strict=True):
            assert distance_to(scene, name, end) <= slack
            assert abs(distance_to(scene, name, place) - clearance) <= slack
    if clearance > 0:
        nearest = min(distance_to(scene, name, place) for name in [*(o.name for o in scene.obstacles), "the wall"])
        assert nearest >= clearance - slack


def check_against_free_space(scene: Scene, a: Point, b: Point, arc_error: float = ARC) -> None:
    start, goal = FreeSpace(scene, 0.0, arc_error).part_of([a, b])
    passage = passage_or_error(scene, a, b)
    if not isinstance(passage, Passage):
        assert not (start if passage is StartBlocked else goal)
        return
    if not (start and goal):  # shut in between obstacles that touch
        assert passage.clearance == 0.0
    check_consistent(scene, a, b, passage)
    clearance = passage.clearance
    widest = max((o.own_radius for o in scene.obstacles), default=0.0) + clearance
    below = clearance - arc_error * widest - 2 * scene.tol  # what rounded corners and closed hairlines cost
    if below > 0:
        assert joined(scene, below, arc_error, a, b)
    if clearance > 0 or passage.between[0] not in ("start", "goal"):
        assert not joined(scene, clearance * (1 + 1e-9) + 2 * scene.tol, arc_error, a, b)


def passage_or_error(scene: Scene, a: Point, b: Point) -> Passage | type[SceneError]:
    try:
        return widest_passage(scene, a, b)
    except (StartBlocked, GoalBlocked) as error:
        return type(error)


@settings(max_examples=120, deadline=None)
@given(scenes(max_obstacles=7, max_robots=0), PLACES, PLACES)
def test_it_is_as_wide_as_the_free_space_allows(scene: Scene, a: Point, b: Point) -> None:
    check_against_free_space(scene, a, b)


@pytest.mark.parametrize("entry", ZOO, ids=str)
def test_zoo_passages_are_as_wide_as_the_free_space_allows(entry: Entry) -> None:
    for robot in entry.scene.robots:
        check_against_free_space(entry.scene, robot.start, robot.goal)


@pytest.mark.parametrize("seed", range(16))
def test_gaps_are_as_wide_as_the_free_space_allows_between_roomy_places(seed: int) -> None:
    scene = random_scene(robots=0, obstacles=40, density=0.3, seed=seed)
    a, b = roomy_places(scene, seed)
    assert widest_passage(scene, a, b).between[0] != "goal"
    check_against_free_space(scene, a, b)


def roomy_places(scene: Scene, seed: int, candidates: int = 40) -> tuple[Point, Point]:
    """Of random places the one with most room, and one with much room far from it."""
    wide, high = scene.workspace[2]
    places = np.random.default_rng(seed).random((candidates, 2)) * (wide, high)
    names = [*(o.name for o in scene.obstacles), "the wall"]
    free = FreeSpace(scene).contains(places)
    room = np.array([min(distance_to(scene, name, p) for name in names) for p in places]) * free
    first = places[np.argmax(room)]
    second = places[np.argmax(room * (np.hypot(*(places - first).T) > wide / 3))]
    return tuple(first.tolist()), tuple(second.tolist())


def check(scene: Scene, a: Point, b: Point, clearance: float, between: set[str], place: Point | None = None) -> None:
    """Both ways round, and however the scene lies in the plane."""
    for start, goal in ((a, b), (b, a)):
        passage = widest_passage(scene, start, goal)
        assert math.isclose(passage.clearance, clearance, rel_tol=1e-14)
        assert set(passage.between) == between
        check_consistent(scene, start, goal, passage)
        if place is not None:
            assert passage.place == pytest.approx(place, rel=1e-14, abs=1e-14)
    for factor, shift in ((1e-9, 0.0), (1e6, 0.0), (1.0, 1e6)):
        moved = transformed(scene, factor, shift)
        a2, b2 = [tuple(factor * c + shift for c in p) for p in (a, b)]
        passage = widest_passage(moved, a2, b2)
        assert math.isclose(passage.clearance, factor * clearance, abs_tol=8 * moved.tol)
        assert set(passage.between) == between


HALL = (0.0, 0.0, 12.0, 12.0)


def test_two_discs_leave_half_their_free_distance() -> None:
    scene = Scene(HALL, [Circle((6, 0), 3, "low"), Circle((6, 9.5), 4, "high")])
    check(scene, (1.5, 3), (10.5, 3), 1.25, {"low", "high"}, (6, 4.25))


def test_a_door_in_a_wall_is_as_wide_as_it_is() -> None:
    scene = Scene(HALL, [box(0, 5, 7, 6, "left"), box(8.5, 5, 12, 6, "right")])
    check(scene, (4, 2), (4, 9), 0.75, {"left", "right"})


def test_the_wider_of_two_doors_counts() -> None:
    walls = [box(0, 5, 2, 6, "west"), box(3, 5, 7, 6, "middle"), box(8.5, 5, 12, 6, "east")]
    check(Scene(HALL, walls), (4, 2), (2, 9), 0.75, {"middle", "east"})


def test_a_wide_way_round_beats_a_narrow_door() -> None:
    walls = [box(0, 5, 4, 6, "west"), box(4.5, 5, 9, 6, "east")]
    check(Scene(HALL, walls), (4, 2.5), (4, 9), 1.5, {"east", "the wall"})


def test_the_mouth_of_a_cup_is_between_two_sides_of_one_obstacle() -> None:
    outer = [(6, 10), (2, 10), (2, 2), (10, 2), (10, 10), (7, 10)]
    inner = [(7, 9), (9, 9), (9, 3), (3, 3), (3, 9), (6, 9)]
    check(Scene(HALL, [Polygon(outer + inner, "cup")]), (6, 6), (1, 1), 0.5, {"cup"})


def test_the_tightest_of_nested_rooms_counts() -> None:
    outer = Line([(5, 1), (1, 1), (1, 11), (11, 11), (11, 1), (7, 1)], 0.5, "outer")
    inner = Line([(6.25, 9), (9, 9), (9, 3), (3, 3), (3, 9), (5.5, 9)], 0.25, "inner")
    check(Scene(HALL, [outer, inner]), (6, 6), (11.75, 6), 0.25, {"inner"})


def test_without_a_narrower_gap_the_ends_count() -> None:
    scene = Scene(HALL, [box(6, 4, 8, 8, "box")])
    passage = widest_passage(scene, (5.75, 6), (2, 2))
    assert (passage.clearance, passage.between, passage.place) == (0.25, ("start", "box"), (5.75, 6.0))
    passage = widest_passage(scene, (2, 2), (5.75, 6))
    assert (passage.clearance, passage.between) == (0.25, ("goal", "box"))
    assert passage.ends.tolist() == [[5.75, 6], [6, 6]]
    passage = widest_passage(scene, (4, 1), (4, 1))
    assert (passage.clearance, passage.between) == (1.0, ("start", "the wall"))


@pytest.mark.parametrize("lid", [box(6, 9, 7, 10, "lid"), box(5, 8, 7.5, 11, "lid")], ids=["touches", "overlaps"])
def test_what_is_separated_has_clearance_zero_and_names_what_shuts_it_in(lid: Obstacle) -> None:
    cup = Line([(7.5, 9.5), (9, 9.5), (9, 3), (3, 3), (3, 9.5), (5.5, 9.5)], 1.0, "cup")
    passage = widest_passage(Scene(HALL, [cup, lid]), (6, 6), (1, 1))
    assert passage.clearance == 0.0
    assert set(passage.between) == {"cup", "lid"}
    assert 5 <= passage.place[0] <= 7.5


def test_a_gap_narrower_than_the_tolerance_counts_as_closed() -> None:
    for gap, clearance in ((0.25, 0.125), (2.0**-50, 0.0)):
        scene = Scene((0, 0, 8, 8), [box(0, 3, 1, 4, "west"), box(1 + gap, 3, 8, 4, "east")])
        assert widest_passage(scene, (4, 1), (4, 7)).clearance == clearance


def test_an_obstacle_beside_or_outside_the_wall_takes_nothing() -> None:
    beside: list[Obstacle] = [box(12.5, 4, 14, 8), box(13, 13, 14, 14), Circle((-3, 6), 2)]
    gate = box(0, 5, 7.5, 6, "left")
    passage = widest_passage(Scene(HALL, [gate, *beside]), (4, 2.5), (4, 8.5))
    assert (passage.clearance, passage.between, passage.place) == (2.25, ("left", "the wall"), (9.75, 5.0))


@pytest.mark.parametrize(
    ("obstacle", "depth"),
    [
        (box(1, 1, 5, 4), "1 m"),
        (Circle((3, 3), 2), "1 m"),
        (Line([(1, 2), (5, 2)], 3), "1.5 m"),
        (Rectangle(1, 1, 4, 3), "1 m"),
    ],
    ids=["polygon", "circle", "line", "rectangle"],
)
def test_ends_inside_an_obstacle_are_refused_with_its_name_and_depth(obstacle: Obstacle, depth: str) -> None:
    scene = Scene(HALL, [obstacle])
    with pytest.raises(StartBlocked, match=rf"start \(3, 2\) lies inside obstacle O1 by {depth}"):
        widest_passage(scene, (3, 2), (9, 9))
    with pytest.raises(GoalBlocked, match=rf"goal \(3, 2\) lies inside obstacle O1 by {depth}"):
        widest_passage(scene, (9, 9), (3, 2))
    with pytest.raises(GoalBlocked, match="outside the workspace by 2 m"):
        widest_passage(scene, (9, 9), (14, 2))


@pytest.mark.parametrize("place", [(1, 2, 3), [(1, 2)], 4.0, (math.nan, 1), (math.inf, 1)])
def test_what_is_no_point_is_refused(place: object) -> None:
    with pytest.raises(ValueError, match="goal must be one point"):
        widest_passage(Scene(HALL), (1, 1), place)  # type: ignore[arg-type]


def test_crowds_far_from_the_way_are_passed_over_and_the_gap_between_them_is_found() -> None:
    """Blocks of many small obstacles with wide roads between them: what is hemmed in is left out, soundly."""
    rng = np.random.default_rng(3)
    rectangles: list[Obstacle] = []
    for left, low in ((6, 6), (40, 6), (6, 40), (40, 43)):
        for x, y, width, height, angle in rng.uniform(
            (left, low, 0.2, 0.2, 0), (left + 24, low + 24, 1, 1, 3), (300, 5)
        ):
            rectangles.append(Rectangle(x, y, width, height, angle))
    scene = Scene((0, 0, 72, 80), rectangles)
    a, b = (35.0, 35.0), (35.5, 73.0)
    passage = widest_passage(scene, a, b)
    assert not {"start", "goal", "the wall"} & set(passage.between)
    assert 4 < passage.clearance < 5
    check_against_free_space(scene, a, b, arc_error=1e-3)


def test_an_end_that_touches_something_is_the_narrowest_place() -> None:
    corners = Scene((0, 0, 10, 10), [Rectangle(2, 2, 3, 3), Rectangle(5, 5, 3, 3)])
    passage = widest_passage(corners, (5, 5), (9, 1))
    assert (passage.clearance, passage.between[0], passage.place) == (0.0, "start", (5.0, 5.0))
    assert math.copysign(1.0, passage.clearance) == 1.0
