"""Potential fields: the force is the gradient, descent is allowed, and what catches it is told."""

from __future__ import annotations

import math
from collections.abc import Callable
from itertools import pairwise

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from naive import ExactRegion
from strategies import grid_scenes
from taut.errors import GoalBlocked, NoPath, StartBlocked
from taut.freespace import FreeSpace
from taut.generate import random_scene
from taut.route.potential import PotentialRoute, potential_at, potential_path
from taut.scene import Circle, Polygon, Rectangle, Scene
from zoo import ZOO, Entry, transformed

CUP = Polygon([(4, 2), (6, 2), (6, 8), (4, 8), (4, 7), (5, 7), (5, 3), (4, 3)], name="cup")


def hall(*obstacles: Polygon | Circle | Rectangle, growth: float = 0.0) -> FreeSpace:
    return FreeSpace(Scene((0, 0, 10, 10), obstacles), growth)


def check_allowed(space: FreeSpace, route: PotentialRoute) -> None:
    """Each leg is an allowed motion, exactly, and no place inside the route is one where free space touches itself."""
    assert not space.mesh.on_pinch(route.points[1:-1]).any()
    points = [(x, y) for x, y in route.points.tolist()]
    exact = ExactRegion(space.region, points)
    for a, b in pairwise(points):
        assert exact.passed(exact.free(a), exact.free(b)) is not None


def test_the_potential_of_one_wall_and_one_disc_is_that_of_the_formula() -> None:
    disc = Circle((5, 5), 1, name="disc")
    space = FreeSpace(Scene((0, 0, 10, 10), [disc]), arc_error=1e-9)
    goal, influence = (9.0, 5.0), 0.5
    points = np.array([(3.8, 5.0), (5.0, 6.3), (0.2, 5.0), (8.75, 5.0), (2.0, 2.0)])
    gaps = [0.2, 0.3, 0.2, math.inf, math.inf]
    potential, _ = potential_at(space, goal, points, attraction=2.0, repulsion=3.0, influence=influence)
    for point, gap, found in zip(points.tolist(), gaps, potential.tolist(), strict=True):
        d = math.dist(point, goal)
        pull = 2.0 * (d * d / (2 * influence) if d < influence else d - influence / 2)
        push = 0.0 if gap > influence else 1.5 * influence * (influence / gap - 1) ** 2
        assert math.isclose(found, pull + push, rel_tol=1e-6)


def test_obstacles_are_added_not_only_the_nearest() -> None:
    both = hall(Rectangle(2, 0, 6, 4.8), Rectangle(2, 5.2, 6, 4.8))
    one = hall(Rectangle(2, 0, 6, 4.8))
    (far,), _ = potential_at(both, (9, 5), (1.0, 1.0), influence=0.5)
    (middle,), (force,) = potential_at(both, (9, 5), (5, 5), influence=0.5)
    (beside,), _ = potential_at(one, (9, 5), (5, 5), influence=0.5)
    pull = 4 - 0.25
    assert math.isclose(middle - pull, 2 * (beside - pull), rel_tol=1e-12)
    assert force == pytest.approx((1, 0), abs=1e-12)
    assert math.isclose(far, math.dist((1, 1), (9, 5)) - 0.25)


@pytest.mark.parametrize("seed", range(3))
def test_the_force_is_the_negative_gradient(seed: int) -> None:
    scene = random_scene(robots=1, obstacles=15, seed=seed)
    space = FreeSpace.of(scene, scene.robots[0])
    left, low, right, high = space.region.bounds
    points = np.random.default_rng(seed).uniform((left, low), (right, high), (600, 2))
    h = 1e-6
    _, force = potential_at(space, scene.robots[0].goal, points)
    around = [potential_at(space, scene.robots[0].goal, points + h * np.array(e))[0] for e in ((1, 0), (-1, 0))]
    above = [potential_at(space, scene.robots[0].goal, points + h * np.array(e))[0] for e in ((0, 1), (0, -1))]
    with np.errstate(invalid="ignore"):
        slope = np.stack([(around[0] - around[1]), (above[0] - above[1])], axis=1) / (2 * h)
    size = np.hypot(*force.T)
    smooth = np.isfinite(slope).all(axis=1) & (size > 0) & (size < 1e3)
    right = np.hypot(*(slope + force).T) < 1e-3 * (1 + size)
    # the potential jumps at a few lines; a step of h seldom crosses one
    assert smooth.sum() > 200
    assert right[smooth].mean() > 0.99


def test_what_is_not_free_has_an_infinite_potential() -> None:
    potential, force = potential_at(hall(Rectangle(4, 4, 2, 2)), (9, 9), [(5, 5), (11, 1), (1, 1)])
    assert np.isinf(potential).tolist() == [True, True, False]
    assert (force[:2] == 0).all()


def test_a_wall_does_not_repel_through_another() -> None:
    thin = hall(Rectangle(4, 0, 0.01, 10))
    (potential,), _ = potential_at(thin, (1, 1), (3.5, 5), influence=1)
    (beside,), _ = potential_at(hall(Rectangle(4, 0, 6, 10)), (1, 1), (3.5, 5), influence=1)
    assert math.isclose(potential, beside, rel_tol=1e-12)


def test_the_far_side_of_a_thin_wall_does_not_repel() -> None:
    (potential,), _ = potential_at(hall(Rectangle(4, 0, 0.01, 9.6)), (1, 9.4), (3.5, 9.4), influence=0.58)
    assert math.isclose(potential, 2.5 - 0.29 + 0.29 * (0.58 / 0.5 - 1) ** 2, rel_tol=1e-9)


@pytest.mark.parametrize("growth", [0.0, 0.3])
def test_a_single_disc_off_the_line_is_passed(growth: float) -> None:
    space = hall(Circle((5, 5.4), 1), growth=growth)
    route = potential_path(space, (1, 5), (9, 5))
    assert route.reached
    assert route.held_by == ()
    assert route.points[[0, -1]].tolist() == [[1, 5], [9, 5]]
    assert 8 < route.length < 9.5
    check_allowed(space, route)


def test_in_the_open_the_route_is_straight() -> None:
    assert math.isclose(potential_path(hall(), (1, 2), (8, 7)).length, math.dist((1, 2), (8, 7)), rel_tol=1e-12)


def test_a_bay_on_the_way_catches_it() -> None:
    route = potential_path(hall(CUP, Circle((1, 9), 0.5)), (1, 5), (9, 5))
    assert not route.reached
    assert route.held_by == ("cup",)
    x, y = route.stuck_at or (0, 0)
    assert 4.5 < x < 5
    assert y == pytest.approx(5, abs=1e-6)
    assert tuple(route.points[-1].tolist()) == (x, y)


def test_where_it_is_caught_the_force_is_none() -> None:
    space = hall(CUP)
    route = potential_path(space, (1, 5.3), (9, 5))
    assert route.stuck_at is not None
    _, (force,) = potential_at(space, (9, 5), route.stuck_at)
    assert np.hypot(*force) < 1e-3


def test_a_goal_near_an_obstacle_is_not_reached() -> None:
    space = hall(Rectangle(6, 2, 2, 6, name="shelf"))
    route = potential_path(space, (1, 5), (5.9, 5), influence=1.0, step=0.01)
    assert route.held_by == ("shelf",)
    assert route.stuck_at is not None
    assert 5 < route.stuck_at[0] < 5.85


def test_a_goal_near_the_wall_is_held_off_by_it() -> None:
    route = potential_path(hall(Circle((2, 2), 1)), (5, 5), (9.95, 5), influence=1.0, step=0.01)
    assert route.held_by == ("the wall",)


def test_the_obstacles_of_a_passage_too_narrow_are_named() -> None:
    space = hall(Rectangle(3, 0, 3, 4.9, name="below"), Rectangle(3, 5.1, 3, 4.9, name="above"))
    route = potential_path(space, (1, 5), (9, 5))
    assert sorted(route.held_by) == ["above", "below"]


def test_steps_given_end_it() -> None:
    route = potential_path(hall(), (1, 1), (9, 9), step=0.1, steps=10)
    assert len(route.points) == 11
    assert route.stuck_at == tuple(route.points[-1].tolist())
    assert route.held_by == ()


def test_a_start_on_a_wall_gets_away() -> None:
    route = potential_path(hall(Rectangle(0, 3, 2, 2)), (2, 4), (9, 6))
    assert route.reached
    assert potential_path(hall(Rectangle(0, 3, 2, 2)), (2, 5), (9, 6)).reached


def test_a_route_to_where_it_starts_is_one_point() -> None:
    route = potential_path(hall(), (3, 3), (3, 3))
    assert route.reached
    assert route.points.tolist() == [[3, 3]]


@pytest.mark.parametrize("entry", ZOO, ids=str)
def test_zoo_routes_are_allowed_and_go_down(entry: Entry) -> None:
    scene = entry.scene
    for robot in scene.robots:
        space = FreeSpace(scene, scene.growth(robot), arc_error=0.2)
        if not entry.reachable[robot.name] or len(space.mesh.vertices) > 100:
            continue
        route = potential_path(space, robot.start, robot.goal, steps=200)
        assert tuple(route.points[0].tolist()) == robot.start
        assert route.reached == (tuple(route.points[-1].tolist()) == robot.goal)
        check_allowed(space, PotentialRoute(route.points[:40], None, ()))
        potential, _ = potential_at(space, robot.goal, route.points[1 : -1 if route.reached else None])
        assert (np.diff(potential) < 0).all()


@settings(max_examples=60, deadline=None)
@given(grid_scenes(max_robots=1), st.sampled_from([0.1, 0.5, 2.0]))
def test_generated_routes_are_allowed_and_held_by_obstacles_of_the_scene(scene: Scene, influence: float) -> None:
    space = FreeSpace(scene)
    for robot in scene.robots:
        try:
            route = potential_path(space, robot.start, robot.goal, influence=influence, steps=300)
        except (StartBlocked, GoalBlocked, NoPath):
            continue
        assert set(route.held_by) <= {"the wall", *(obstacle.name for obstacle in scene.obstacles)}
        assert not (route.reached and route.held_by)
        check_allowed(space, PotentialRoute(route.points[:60], None, ()))


@pytest.mark.parametrize("factor", [2.0**-30, 2.0**20])
def test_scale_changes_nothing(factor: float) -> None:
    scene = Scene((0, 0, 10, 10), [Circle((5, 5.4), 1), CUP])
    for goal in ((3.0, 9.0), (9.0, 5.0)):
        one = potential_path(FreeSpace(scene), (1, 5), goal)
        other = potential_path(
            FreeSpace(transformed(scene, factor, 0.0)), (factor, 5 * factor), (factor * goal[0], factor * goal[1])
        )
        assert one.held_by == other.held_by
        assert math.isclose(one.length, other.length / factor, rel_tol=1e-3)


def test_the_same_question_has_the_same_answer() -> None:
    scene = random_scene(robots=1, obstacles=15, seed=3)
    space, robot = FreeSpace.of(scene, scene.robots[0]), scene.robots[0]
    one, other = (potential_path(space, robot.start, robot.goal) for _ in range(2))
    np.testing.assert_array_equal(one.points, other.points)


def test_ends_that_are_not_free_or_apart_are_told() -> None:
    space = hall(Rectangle(4, 0, 1, 10))
    with pytest.raises(StartBlocked):
        potential_path(space, (4.5, 5), (9, 5))
    with pytest.raises(GoalBlocked):
        potential_path(space, (1, 5), (11, 5))
    with pytest.raises(NoPath, match="obstacles separate them"):
        potential_path(space, (1, 5), (9, 5))
    with pytest.raises(GoalBlocked):
        potential_at(space, (4.5, 5), (1, 1))
    with pytest.raises(StartBlocked):
        potential_path(FreeSpace(Scene((0, 0, 1, 1)), 1.0), (0.5, 0.5), (0.5, 0.5))


BAD: list[tuple[Callable[[FreeSpace], object], str]] = [
    (lambda s: potential_path(s, (1, 1), (2, 2), attraction=0), "attraction"),
    (lambda s: potential_path(s, (1, 1), (2, 2), repulsion=-1), "repulsion"),
    (lambda s: potential_path(s, (1, 1), (2, 2), influence=math.nan), "influence"),
    (lambda s: potential_path(s, (1, 1), (2, 2), step=math.inf), "step"),
    (lambda s: potential_path(s, (1, 1), (2, 2), steps=0), "steps"),
    (lambda s: potential_path(s, (1, 1), (2, 2), steps=1.5), "steps"),  # type: ignore[arg-type]
    (lambda s: potential_path(s, [(1, 1), (2, 2)], [(2, 2), (3, 3)]), "one point"),
    (lambda s: potential_at(s, [(1, 1), (2, 2)], (3, 3)), "one point"),
]


@pytest.mark.parametrize(("call", "said"), BAD)
def test_bad_parameters_are_named(call: Callable[[FreeSpace], object], said: str) -> None:
    with pytest.raises(ValueError, match=said):
        call(hall())
