"""Scenes that cannot be used are refused with who, where, how much and the mend; what is merely odd is a note."""

from __future__ import annotations

import math
import warnings
from collections.abc import Sequence
from itertools import pairwise
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from taut.errors import GoalBlocked, SceneError, StartBlocked
from taut.scene import Circle, Line, Obstacle, Polygon, Rectangle, Robot, Scene
from taut.validation import validate

W = (0, 0, 10, 10)
FAR = (9.0, 9.0)


def refusal(scene: Scene) -> SceneError:
    with pytest.raises(SceneError) as caught:
        validate(scene)
    assert str(caught.value).isprintable()
    return caught.value


def with_start(obstacles: Sequence[Obstacle], start: tuple[float, float], radius: float = 0.0, **more: Any) -> Scene:
    return Scene(W, obstacles, [Robot("R1", start, FAR, radius=radius)], **more)


# --- rings

RINGS = {
    "crossing": ([(1, 1), (3, 3), (3, 1), (1, 3)], "crosses itself at (2, 2) (its edges 1 and 3)"),
    "one line": ([(1, 1), (2, 2), (3, 3)], "has zero area: all its corners lie on one line, from (1, 1) to (3, 3)"),
    "two corners": ([(1, 1), (1, 1), (3, 3)], "has zero area: only 2 of its 3 corners are different"),
    "one corner": ([(1, 1), (1, 1), (1, 1)], "has zero area"),
    "spike outside": ([(1, 1), (3, 1), (3, 3), (3, 5), (3, 3), (1, 3)], "has a spike of zero width at (3, 5)"),
    "spike inside": ([(1, 1), (3, 1), (3, 3), (2, 2), (3, 3), (1, 3)], "has a spike of zero width at (2, 2)"),
    "spike along a side": ([(1, 1), (5, 1), (3, 1), (3, 3)], "has a spike of zero width at (5, 1)"),
    "corner on corner": ([(1, 1), (3, 3), (5, 1), (5, 5), (3, 3), (1, 5)], "touches itself at (3, 3)"),
    "corner on side": ([(1, 1), (5, 1), (5, 5), (3, 1), (1, 5)], "touches itself at (3, 1)"),
    "twice round": ([(1, 1), (3, 1), (3, 3), (1, 1), (3, 1), (3, 3)], "itself at"),
}


@pytest.mark.parametrize("case", RINGS)
def test_an_obstacle_ring_that_is_not_simple_is_refused_with_the_place(case: str) -> None:
    corners, message = RINGS[case]
    text = str(refusal(Scene(W, [Circle((5, 5), 1, "C"), Polygon(corners, "A")])))
    assert text.startswith("obstacle A")
    assert message in text


@pytest.mark.parametrize("case", RINGS)
def test_a_workspace_ring_that_is_not_simple_is_refused_with_the_place(case: str) -> None:
    corners, message = RINGS[case]
    text = str(refusal(Scene(corners)))
    assert text.startswith("the workspace")
    assert message in text


def test_repeated_and_collinear_corners_and_both_directions_are_fine() -> None:
    ring = [(1, 1), (1, 1), (2, 1), (3, 1), (3, 3), (3, 3), (1, 3), (1, 1)]
    assert validate(Scene(W, [Polygon(ring)])) == ()
    assert validate(Scene(W, [Polygon(ring[::-1])])) == ()
    assert validate(Scene([(0, 0), (0, 0), (5, 0), (10, 0), (10, 10), (0, 10), (0, 0)])) == ()


def test_a_crossing_by_a_hair_is_seen() -> None:
    hair = math.ulp(2.0)
    assert validate(Scene(W, [Polygon([(1, 1), (3, 1), (3, 3), (2, 1 + hair), (1, 3)])])) == ()
    assert "itself" in str(refusal(Scene(W, [Polygon([(1, 1), (3, 1), (3, 3), (2, 1 - hair), (1, 3)])])))


def test_coordinates_beyond_computing_are_refused() -> None:
    for size in (1e80, 1e-80):
        assert "use other units" in str(refusal(Scene((0, 0, size, size))))


# --- starts and goals


def test_inside_an_obstacle_says_which_and_by_how_much() -> None:
    error = refusal(with_start([Rectangle(2, 2, 2, 2, name="O1"), Rectangle(6, 2, 2, 2, name="O2")], (6.3, 3)))
    assert isinstance(error, StartBlocked)
    assert str(error) == "robot R1: start (6.3, 3) lies inside obstacle O2 by 0.3 m; move it"


def test_too_near_says_what_is_and_what_is_needed() -> None:
    scene = Scene(W, [Rectangle(2, 2, 2, 2, name="O1")], [Robot("R1", FAR, (3, 4.05), radius=0.2, clearance=0.1)])
    error = refusal(scene)
    assert isinstance(error, GoalBlocked)
    assert "goal (3, 4.05) is only 0.05 m from obstacle O1 but needs 0.3 m (radius 0.2 + clearance 0.1)" in str(error)


def test_the_scene_clearance_counts_unless_the_robot_has_its_own() -> None:
    scene = Scene(W, [Rectangle(2, 2, 2, 2)], [Robot("R1", (3, 4.25), FAR, radius=0.2)], clearance=0.1)
    assert isinstance(refusal(scene), StartBlocked)
    scene = Scene(W, scene.obstacles, [Robot("R1", (3, 4.25), FAR, radius=0.2, clearance=0)], clearance=0.1)
    assert validate(scene) == ()


def test_outside_and_at_the_wall() -> None:
    error = refusal(Scene(W, (), [Robot("R1", FAR, (11.5, 4))]))
    assert isinstance(error, GoalBlocked)
    assert "goal (11.5, 4) lies outside the workspace by 1.5 m; move it inside" in str(error)
    assert "start (1, 0.1) is only 0.1 m from the wall of the workspace but needs 0.2 m" in str(
        refusal(with_start([], (1, 0.1), 0.2))
    )
    dent = [(0, 0), (5, 4), (10, 0), (10, 10), (0, 10)]
    assert "outside the workspace by" in str(refusal(Scene(dent, (), [Robot("R1", (5, 1), FAR)])))


@pytest.mark.parametrize(
    ("obstacle", "direction"),
    [
        (Circle((5, 5), 1), (0.6, 0.8)),
        (Rectangle(4, 4, 2, 2), (1, 0)),
        (Polygon([(4, 4), (6, 4), (6, 6), (4, 6)]), (0, -1)),
        (Line([(3, 5), (5, 5), (7, 5)], 2), (0, 1)),
    ],
)
def test_the_limit_is_exact_within_the_tolerance(obstacle: Obstacle, direction: tuple[float, float]) -> None:
    for growth in (0.0, 0.25):
        tol = with_start([obstacle], (1, 1)).tol
        for margin, fits in ((0.0, True), (-0.4 * tol, True), (-4 * tol, False), (4 * tol, True)):
            reach = 1 + growth + margin
            scene = with_start([obstacle], (5 + reach * direction[0], 5 + reach * direction[1]), growth)
            if fits:
                assert validate(scene) == ()
            else:
                assert isinstance(refusal(scene), StartBlocked)


def test_numbers_that_look_alike_are_told_with_more_digits() -> None:
    text = str(refusal(with_start([Rectangle(2, 2, 2, 2)], (3, 4.2999999), 0.3)))
    assert "is only 0.2999999 m from obstacle O1 but needs 0.3 m" in text


@settings(deadline=None, max_examples=60)
@given(
    x=st.floats(0, 10),
    y=st.floats(0, 10),
    radius=st.just(0.0) | st.floats(1e-60, 1),
    angle=st.floats(-4, 4),
    size=st.floats(0.1, 3),
)
def test_obstacles_block_just_where_a_slow_reference_says(
    x: float, y: float, radius: float, angle: float, size: float
) -> None:
    shapes: list[Obstacle] = [
        Rectangle(3, 3, size, 1, angle),
        Circle((7, 3), size / 2),
        Line([(2, 7), (4, 8), (8, 7)], size / 4),
    ]
    scene = with_start(shapes, (x, y), radius)
    room = min(x, y, 10 - x, 10 - y)
    for shape in shapes:
        core = shape.core
        closing = np.vstack([core, core[:1]]) if shape.closed else core
        distance = min(
            (_to_segment((x, y), a, b) for a, b in pairwise(closing)),
            default=math.dist((x, y), core[0]),
        )
        room = min(room, (-distance if shape.closed and _inside((x, y), core) else distance) - shape.own_radius)
    if room > radius + 1e-9 and radius < 0.9:
        assert isinstance(validate(scene), tuple)
    elif room < radius - 1e-9:
        assert isinstance(refusal(scene), StartBlocked)


def _to_segment(p: tuple[float, float], a: Any, b: Any) -> float:
    t = float(np.clip(np.dot(np.subtract(p, a), b - a) / np.dot(b - a, b - a), 0, 1))
    return math.dist(p, a + t * (b - a))


def _inside(p: tuple[float, float], convex: Any) -> bool:
    d, q = np.roll(convex, -1, axis=0) - convex, np.array(p) - convex
    return bool((d[:, 0] * q[:, 1] - d[:, 1] * q[:, 0] > 0).all())


# --- gaps of zero width

LEFT, RIGHT = Rectangle(2, 2, 2, 2, name="A"), Rectangle(4, 2, 2, 2, name="B")
SHUT_IN: dict[str, tuple[list[Obstacle], tuple[float, float], float]] = {
    "on a seam": ([LEFT, RIGHT], (4, 3), 0),
    "on a seam of corners": ([LEFT, RIGHT, Rectangle(2, 4, 2, 2), Rectangle(4, 4, 2, 2)], (4, 4), 0),
    "between an obstacle and the wall": ([Rectangle(0, 2, 2, 2)], (0, 3), 0),
    "in a corridor as wide as the robot": ([LEFT, Rectangle(5, 2, 2, 2)], (4.5, 3), 0.5),
    "between lines as far apart as the robot": ([Line([(2, 2), (2, 8)], 1), Line([(4, 2), (4, 8)], 1)], (3, 4), 0.5),
    "in the slot of one obstacle": (
        [Polygon([(2, 2), (6, 2), (6, 6), (5, 6), (5, 3), (3, 3), (3, 6), (2, 6)])],
        (4, 5),
        1,
    ),
}
FREE: dict[str, tuple[list[Obstacle], tuple[float, float], float]] = {
    "at the end of a seam": ([LEFT, RIGHT], (4, 4), 0),
    "at a pinch of corners": ([LEFT, Rectangle(4, 4, 2, 2)], (4, 4), 0),
    "at a pinch of circles": ([Circle((2, 2), 1), Circle((4, 2), 1)], (3, 2), 0),
    "at a grown pinch of circles": ([Circle((2, 2), 1), Circle((4.5, 2), 1)], (3.25, 2), 0.25),
    "at the mouth of a corridor": ([LEFT, Rectangle(5, 2, 2, 2)], (4.5, 4 + 0.5), 0.5),
    "in a corridor with a little room": ([LEFT, Rectangle(5 + 1e-9, 2, 2, 2)], (4.5, 3), 0.5),
    "on a wall corner": ([Rectangle(0, 2, 2, 2)], (0, 4), 0),
    "in a corner of the workspace": ([], (0, 0), 0),
    "in the tip of a thin wedge": (
        [Polygon([(2, 2), (8, 2), (8, 1)]), Polygon([(2, 2), (8, 2.01), (8, 3)])],
        (2, 2),
        0,
    ),
}


@pytest.mark.parametrize("case", SHUT_IN)
def test_a_start_in_a_gap_of_zero_width_is_refused(case: str) -> None:
    error = refusal(with_start(*SHUT_IN[case]))
    assert isinstance(error, StartBlocked)
    assert "is shut in" in str(error)


@pytest.mark.parametrize("case", FREE)
def test_a_start_with_some_room_beside_it_is_taken(case: str) -> None:
    assert isinstance(validate(with_start(*FREE[case])), tuple)


# --- pairs


def pair(a: tuple[Any, Any], b: tuple[Any, Any], radius: float = 0.2, **more: Any) -> Scene:
    return Scene(W, (), [Robot("a", *a, radius=radius), Robot("b", *b, radius=radius)], **more)


def test_two_starts_on_each_other_or_too_close() -> None:
    assert "robots a and b start on each other at (1, 1), need 0.4 m" in str(
        refusal(pair(((1, 1), (2, 2)), ((1, 1), (4, 4))))
    )
    assert "robots a and b start only 0.1 m apart, at (1, 1) and (1.1, 1), but need 0.5 m" in str(
        refusal(pair(((1, 1), (2, 2)), ((1.1, 1), (4, 4)), gap=0.1))
    )
    assert validate(pair(((1, 1), (2, 2)), ((1.4, 1), (4, 4)))) == ()  # touching


def test_goals_may_be_shared_only_by_robots_that_leave() -> None:
    shared = ((1, 1), (4, 4)), ((3, 1), (4, 4))
    assert "robots a and b stay at goals on each other at (4, 4)" in str(refusal(pair(*shared)))
    assert validate(pair(*shared, at_goal="leave")) == ()
    one = Scene(
        W, (), [Robot("a", (1, 1), (4, 4), radius=0.2, at_goal="leave"), Robot("b", (3, 1), (4, 4), radius=0.2)]
    )
    assert validate(one) == ()


def test_a_robot_gone_from_the_first_instant_is_in_nobody_s_way() -> None:
    assert validate(pair(((1, 1), (1, 1)), ((1, 1), (4, 4)), at_goal="leave")) == ()
    assert "start on each other" in str(refusal(pair(((1, 1), (1, 1)), ((1, 1), (4, 4)))))


def test_two_point_robots_need_a_gap() -> None:
    assert "two point robots need gap > 0: a and b" in str(refusal(pair(((1, 1), (2, 2)), ((3, 3), (4, 4)), radius=0)))
    assert validate(pair(((1, 1), (2, 2)), ((3, 3), (4, 4)), radius=0, gap=0.1)) == ()
    mixed = Scene(W, (), [Robot("a", (1, 1), (2, 2)), Robot("b", (5, 5), (6, 6), radius=0.1)])
    assert validate(mixed) == ()


@settings(deadline=None, max_examples=40)
@given(st.lists(st.tuples(st.floats(0, 10), st.floats(0, 10), st.floats(0.05, 3)), max_size=8))
def test_pairs_are_refused_just_where_a_double_loop_says(places: list[tuple[float, float, float]]) -> None:
    robots = [Robot(f"R{k}", (x, y), (x, y), radius=r) for k, (x, y, r) in enumerate(places)]
    scene = Scene((-5, -5, 15, 15), (), robots, gap=0.1)
    close = [
        math.dist(a.start, b.start) - scene.separation(a, b) for k, a in enumerate(robots) for b in robots[k + 1 :]
    ]
    if min(close, default=1.0) >= 0:
        assert validate(scene) == ()
    elif min(close) < -1e-9:
        assert "apart" in str(refusal(scene)) or "on each other" in str(refusal(scene))


# --- notes


def test_what_was_united_is_noted() -> None:
    notes = validate(Scene(W, [LEFT, RIGHT, Circle((8, 8), 0.5, "C"), Line([(8.5, 8), (9, 8.2)], 0.1, "D")]))
    assert notes == ("4 obstacles overlap or touch and count as 2: A+B, C+D",)
    assert validate(Scene(W, [LEFT, Circle((5, 3), 0.5)])) == ()


def test_what_leaves_the_workspace_is_noted() -> None:
    obstacles: list[Obstacle] = [
        Rectangle(-1, 1, 2, 1, name="over"),
        Rectangle(-5, 1, 2, 1, name="outside"),
        Circle((12, 5), 1, "circle outside"),
        Circle((9.5, 8), 1, "circle over"),
        Circle((11, 2), 1, "circle touching from outside"),
        Rectangle(2, -1, 1, 1, name="touching from outside"),
        Circle((5, 9), 1, "touching from inside"),
        Rectangle(0, 4, 1, 1, name="flush"),
    ]
    assert validate(Scene(W, obstacles)) == (
        "2 obstacles lie partly outside the workspace: over, circle over",
        "4 obstacles lie outside the workspace: outside, circle outside, circle touching from outside, "
        "touching from outside",
    )


def test_what_lies_in_another_is_noted() -> None:
    obstacles: list[Obstacle] = [
        Circle((5, 5), 3, "disc"),
        Rectangle(4, 4, 2, 2, name="in the disc"),
        Circle((5, 5), 0.5, "in both"),
        Rectangle(4, 4, 2, 2, name="again"),
        Circle((8, 5), 0.5, "on the rim"),
    ]
    notes = validate(Scene(W, obstacles))
    assert "3 obstacles lie inside another: in the disc, in both, again" in notes


def test_many_names_are_cut_short() -> None:
    notes = validate(Scene((0, 0, 100, 1), [Circle((k, 0), 0.1) for k in range(1, 21)]))
    assert notes == ("20 obstacles lie partly outside the workspace: O1, O2, O3, O4, O5 and 15 more",)


def test_names_with_line_breaks_stay_on_one_line() -> None:
    scene = Scene(W, [Rectangle(2, 2, 2, 2, name="a\nb"), Rectangle(3, 3, 2, 2, name="c\td")])
    assert validate(scene) == ("2 obstacles overlap or touch and count as 1: a\\nb+c\\td",)
    assert "obstacle a\\nb" in str(refusal(Scene(W, scene.obstacles[:1], [Robot("R\n", (3, 3), (1, 1))])))


def test_an_empty_scene_and_an_empty_team_are_fine() -> None:
    assert validate(Scene(W)) == ()
    assert validate(Scene(W, [LEFT])) == ()


@pytest.mark.parametrize("value", [1e-320, 1e-71, 1e71, 1.7e308])
@pytest.mark.parametrize("field", ["radius", "speed", "clearance", "start_time"])
def test_numbers_of_a_robot_beyond_computing_are_refused(field: str, value: float) -> None:
    robot = Robot("R1", (1, 1), (2, 2), **{field: value})  # type: ignore[arg-type]
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        with pytest.raises(SceneError, match=f"^robot R1: {field} is .* use other units$"):
            validate(Scene((0, 0, 9, 9), robots=[robot]))


@pytest.mark.parametrize("value", [1e-320, 1.7e308])
@pytest.mark.parametrize("field", ["clearance", "gap", "headway"])
def test_numbers_of_a_scene_beyond_computing_are_refused(field: str, value: float) -> None:
    with pytest.raises(SceneError, match=f"^the scene: {field} is .* use other units$"):
        validate(Scene((0, 0, 9, 9), **{field: value}))  # type: ignore[arg-type]


def test_a_growth_that_overflows_is_refused() -> None:
    robot = Robot("R1", (1, 1), (2, 2), radius=1.7e308, clearance=1.7e308)
    with pytest.raises(SceneError, match="robot R1: radius"):
        validate(Scene((0, 0, 9, 9), robots=[robot]))


@pytest.mark.parametrize(
    ("obstacle", "what"), [(Circle((5, 5), 1e-320), "radius"), (Line([(4, 4), (5, 5)], 1e-300), "width")]
)
def test_obstacles_too_thin_to_compute_are_refused(obstacle: Circle | Line, what: str) -> None:
    with pytest.raises(SceneError, match=f"obstacle O1: {what} is"):
        validate(Scene((0, 0, 9, 9), [obstacle]))


def test_a_ring_whose_corners_are_all_one_has_one() -> None:
    with pytest.raises(SceneError, match="only 1 of its 3 corners are different"):
        validate(Scene((0, 0, 9, 9), [Polygon([(1, 1)] * 3)]))
