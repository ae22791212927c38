"""The certificate finds every planted fault, accepts what only touches, and agrees with slow references."""

from __future__ import annotations

import json
import math
from collections.abc import Iterable, Sequence
from dataclasses import replace
from itertools import pairwise

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from numpy.typing import ArrayLike

import naive_certificate as naive
from taut.certificate import Certificate, certify
from taut.motion import Plan, Trajectory
from taut.scene import AtGoal, Circle, FloatArray, Line, Obstacle, Polygon, Rectangle, Robot, Scene

SCALES = [1e-9, 1e-3, 1.0, 1e3, 1e6]
seeds = st.integers(0, 2**32 - 1)
scales = st.sampled_from(SCALES)


def track(name: str, stamps: Sequence[Sequence[float]]) -> Trajectory:
    return Trajectory(name, np.array(stamps, dtype=float))


def kinds(certificate: Certificate) -> list[str]:
    return [problem.kind for problem in certificate.problems]


def timed(name: str, points: ArrayLike, speed: float = 1.0) -> Trajectory:
    """Walk the points at the given speed; a point given twice is a rest of one second."""
    xy = np.array(points, dtype=float)
    steps = np.hypot(*np.diff(xy, axis=0).T) / speed
    steps = np.where(steps > 0, steps * (1 + 1e-15), 1.0)
    return Trajectory(name, np.column_stack([np.r_[0, np.cumsum(steps)], xy]))


def walk(
    points: ArrayLike,
    obstacles: Sequence[Obstacle],
    workspace: Iterable[Sequence[float]] | Sequence[float] = (0, 0, 10, 10),
) -> Plan:
    """One point robot along the points."""
    way = np.array(points, dtype=float)
    robot = Robot("R", (way[0, 0], way[0, 1]), (way[-1, 0], way[-1, 1]))
    return Plan(Scene(workspace, obstacles, [robot]), (timed("R", way),))


def random_plan(seed: int, scale: float, robots: int = 3, obstacles: int = 4, headway: float = 0.0) -> Plan:
    """Random motions anywhere in [-1, 1]² · scale, rests among them; obstacles beyond, so that nobody is in one."""
    rng = np.random.default_rng(seed)
    speed = rng.uniform(0.5, 2, robots) * scale
    team, paths = [], []
    for r in range(robots):
        points = rng.uniform(-1, 1, (rng.integers(1, 6), 2)) * scale
        points = np.repeat(points, rng.integers(1, 3, len(points)), axis=0)
        paths.append(timed(f"R{r}", points, speed[r]))
        at_goal: AtGoal = "leave" if rng.random() < 0.3 and headway == 0 else "stay"
        team.append(Robot(f"R{r}", points[0], points[-1], rng.uniform(0, 1e-3) * scale, speed[r], at_goal=at_goal))
    solid: list[Obstacle] = []
    for k in range(obstacles):
        angle, far = rng.uniform(0, 2 * np.pi), rng.uniform(2, 3) * scale
        centre = far * np.array([np.cos(angle), np.sin(angle)])
        match k % 4:
            case 0:
                solid.append(Circle(centre, rng.uniform(0.1, 0.4) * scale))  # type: ignore[arg-type]
            case 1:
                solid.append(Line(centre + rng.uniform(-0.2, 0.2, (3, 2)) * scale, 0.1 * scale))
            case 2:
                solid.append(Rectangle(centre[0], centre[1], 0.2 * scale, 0.1 * scale, angle))
            case _:
                solid.append(Polygon(centre + rng.uniform(-0.3, 0.3, (3, 2)) * scale))
    return Plan(Scene((-4 * scale, -4 * scale, 4 * scale, 4 * scale), solid, team, headway=headway), tuple(paths))


def with_scene(plan: Plan, **changes: float) -> Plan:
    return Plan(replaced(plan.scene, **changes), plan.trajectories)


def replaced(scene: Scene, **changes: object) -> Scene:
    values = {name: getattr(scene, name) for name in Scene.__dataclass_fields__} | changes
    return Scene(**values)


# ---------------------------------------------------------------------------------------------- separation


@settings(deadline=None, max_examples=60)
@given(seeds, scales)
def test_least_separation_agrees_with_forty_digits(seed: int, scale: float) -> None:
    plan = random_plan(seed, scale)
    found, exact = certify(plan).min_separation, naive.least_room(plan)
    assert (found is None) == (exact is None)
    if found is not None and exact is not None:
        assert abs(found - exact) < plan.scene.tol / 100


@settings(deadline=None, max_examples=60)
@given(seeds, scales)
def test_separation_is_held_to_tol_exactly(seed: int, scale: float) -> None:
    plan = random_plan(seed, scale, robots=2)
    exact, tol = naive.least_room(plan), plan.scene.tol
    if exact is None or exact < 0:
        return
    assert "separation" not in kinds(certify(with_scene(plan, gap=float(exact) + 0.9 * tol)))
    for fault in (1.1 * tol, max(1e-6, 1000 * tol)):
        (problem,) = certify(with_scene(plan, gap=float(exact) + fault)).problems
        assert problem.kind == "separation"
        assert problem.robots == ("R0", "R1")
        assert problem.amount == pytest.approx(fault, rel=1e-12, abs=tol / 50)
        assert problem.time is not None
        a, b = (path.at(problem.time) for path in plan.trajectories)
        assert problem.place == pytest.approx(tuple((a + b) / 2), abs=tol)
        assert np.hypot(*(a - b)) - sum(r.radius for r in plan.scene.robots) == pytest.approx(float(exact), abs=tol)


@settings(deadline=None, max_examples=40)
@given(seeds, scales, st.floats(1e-3, 1.5))
def test_headway_agrees_with_dense_sampling(seed: int, scale: float, headway: float) -> None:
    plan = random_plan(seed, scale, robots=2, headway=headway)
    count = 400
    found, sampled = certify(plan).min_separation, naive.sampled_room(plan, count)
    assert found is not None
    longest = plan.makespan + 2 * headway
    assert sampled - 8 * scale * longest / count <= found <= sampled + plan.scene.tol


def test_headway_zero_and_nearly_zero_agree() -> None:
    plan = random_plan(7, 1.0, robots=8)
    plain = certify(with_scene(plan, headway=0.0))
    nearly = certify(with_scene(plan, headway=1e-13))
    assert plain.min_separation == pytest.approx(nearly.min_separation, abs=1e-11)


def test_headway_catches_the_follower_and_tells_both_times() -> None:
    team = [Robot("A", (3, 5), (10, 5), 0.5), Robot("B", (0, 5), (7, 5), 0.5)]
    paths = track("A", [[0, 3, 5], [7, 10, 5]]), track("B", [[0, 0, 5], [7, 7, 5]])
    scene = Scene((-1, -1, 11, 11), robots=team)
    assert certify(Plan(scene, paths)).min_separation == pytest.approx(2)
    certificate = certify(Plan(replaced(scene, headway=1.0, gap=1.5), paths))
    (problem,) = certificate.problems
    assert problem.kind == "separation"
    assert problem.amount == pytest.approx(0.5)
    assert certificate.separation is not None
    assert certificate.separation.other_time - certificate.separation.time == pytest.approx(1)
    assert "B being there at" in str(problem)


def test_headway_sees_two_that_meet_at_shifted_times_within_their_legs() -> None:
    team = [Robot("A", (0, 5), (10, 5), 0.1), Robot("B", (5, 0), (5, 10), 0.1)]
    paths = track("A", [[0, 0, 5], [10, 10, 5]]), track("B", [[0, 5, 0], [1, 5, 0], [11, 5, 10]])
    crossing = certify(Plan(Scene((0, 0, 10, 10), robots=team, headway=1.0), paths))
    assert crossing.min_separation == pytest.approx(-0.2)
    apart = certify(Plan(Scene((0, 0, 10, 10), robots=team, headway=0.5), paths))
    assert apart.min_separation == pytest.approx(math.sqrt(0.5) / 2 - 0.2)


def test_discs_that_touch_exactly_are_accepted() -> None:
    team = [Robot("A", (0, 1), (4, 1), 0.5), Robot("B", (2, 2), (2, 2), 0.5)]
    plan = Plan(Scene((-1, 0, 5, 5), robots=team), (track("A", [[0, 0, 1], [4, 4, 1]]), track("B", [[0, 2, 2]])))
    certificate = certify(plan)
    assert certificate.ok
    assert certificate.min_separation == 0
    assert certificate.separation is not None
    assert certificate.separation.time == 2
    assert certificate.separation.place == (2, 1.5)


def test_who_leaves_is_gone_on_arrival_and_who_stays_is_there_for_ever() -> None:
    a = Robot("A", (0, 0), (2, 0), 0.1)
    b = Robot("B", (4, 0), (2, 0), 0.1)
    paths = (
        track("A", [[0, 0, 0], [2, 2, 0], [9, 2, 0]]),
        track("B", [[0, 4, 0], [1, 4, 0], [3, 2, 0]]),
    )
    scene = Scene((-1, -1, 5, 1), robots=[a, b])
    assert kinds(certify(Plan(scene, paths))) == ["separation"]
    gone = certify(Plan(replaced(scene, at_goal="leave"), paths))
    assert gone.ok
    assert gone.min_separation == pytest.approx(0.8)  # at t = 2, B is at x = 3
    both = Scene((-1, -1, 5, 1), robots=[replace(a, at_goal="leave"), b])
    assert certify(Plan(both, paths)).min_separation == pytest.approx(0.8)


def test_who_leaves_from_its_goal_at_once_is_never_there() -> None:
    team = [Robot("A", (2, 0), (2, 0), 0.5, at_goal="leave"), Robot("B", (0, 0), (4, 0), 0.5)]
    paths = track("A", [[0, 2, 0]]), track("B", [[0, 0, 0], [4, 4, 0]])
    certificate = certify(Plan(Scene((-1, -1, 5, 1), robots=team), paths))
    assert certificate.ok
    assert certificate.min_separation is None
    team[0] = replace(team[0], at_goal="stay")
    assert kinds(certify(Plan(Scene((-1, -1, 5, 1), robots=team), paths))) == ["separation"]


def test_who_leaves_after_a_round_trip_is_there_until_it_is_back() -> None:
    team = [Robot("A", (2, 0), (2, 0), 0.5, at_goal="leave"), Robot("B", (2, 3), (2, 3), 0.5)]
    paths = track("A", [[0, 2, 0], [2.5, 2, 2.5], [5, 2, 0]]), track("B", [[0, 2, 3]])
    assert kinds(certify(Plan(Scene((-1, -1, 5, 5), robots=team), paths))) == ["separation"]


def test_every_pair_that_is_too_near_is_listed_once() -> None:
    team = [Robot(f"R{k}", (k, 0), (k, 0), 0.6) for k in range(40)]
    paths = tuple(track(f"R{k}", [[0, k, 0], [1, k, 0]]) for k in range(40))
    certificate = certify(Plan(Scene((-1, -1, 41, 1), robots=team), paths))
    assert [p.robots for p in certificate.problems] == [(f"R{k}", f"R{k + 1}") for k in range(39)]


def test_min_separation_is_the_least_room_not_the_least_distance() -> None:
    team = [Robot("A", (0, 0), (0, 0), 0.1), Robot("B", (1, 0), (1, 0), 0.1), Robot("C", (3, 0), (3, 0), 1.5)]
    paths = tuple(track(r.name, [[0, *r.start]]) for r in team)
    certificate = certify(Plan(Scene((-5, -5, 5, 5), robots=team), paths))
    assert certificate.separation is not None
    assert certificate.separation.robots == ("B", "C")
    assert certificate.min_separation == pytest.approx(0.4)


# ---------------------------------------------------------------------------------------------- clearance


@settings(deadline=None, max_examples=60)
@given(seeds, scales)
def test_clearance_agrees_with_forty_digits_and_is_held_to_tol(seed: int, scale: float) -> None:
    plan = random_plan(seed, scale, robots=2)
    tol, exact = plan.scene.tol, naive.least_clearance(plan)
    certificate = certify(plan)
    for clearance, robot, distance in zip(certificate.clearances, plan.scene.robots, exact, strict=True):
        assert abs(clearance.value + robot.radius - distance) < tol / 100
    for r, robot in enumerate(plan.scene.robots):
        room = float(exact[r]) - robot.radius
        for fault, found in ((0.9 * tol, False), (1.1 * tol, True), (max(1e-6, 1000 * tol), True)):
            team = [replace(q, clearance=room + fault if q is robot else 0.0) for q in plan.scene.robots]
            problems = certify(Plan(replaced(plan.scene, robots=team), plan.trajectories)).problems
            mine = [p for p in problems if p.kind == "clearance"]
            assert len(mine) == int(found)
            if found:
                assert mine[0].robots == (robot.name,)
                assert mine[0].amount == pytest.approx(fault, rel=1e-12, abs=tol / 50)
                assert mine[0].obstacle == certificate.clearances[r].obstacle


def test_without_obstacles_there_is_the_wall() -> None:
    scene = Scene((0, 0, 4, 4), robots=[Robot("A", (1, 1), (3, 1), 0.5)], clearance=0.5)
    certificate = certify(Plan(scene, (track("A", [[0, 1, 1], [2, 3, 1]]),)))
    assert certificate.ok
    assert certificate.min_clearance == 0.5
    assert certificate.clearance is not None
    assert certificate.clearance.obstacle == "the wall"
    assert certificate.separation is None


@pytest.mark.parametrize("obstacle", [
    Rectangle(4, 4, 2, 2, name="X"), Circle((5, 5), 1, name="X"), Line([(4, 5), (6, 5)], 1, name="X"),
    Rectangle(4, 4, 20, 2, name="X"),
])  # fmt: skip
@pytest.mark.parametrize("radius", [0.0, 0.25])
def test_a_path_through_an_obstacle_is_found_with_its_depth(obstacle: Obstacle, radius: float) -> None:
    points = [(5, 1), (5, 9)]
    scene = Scene((0, 0, 10, 10), [obstacle], [Robot("R", points[0], points[-1], radius)])
    certificate = certify(Plan(scene, (timed("R", points),)))
    depth = 0.5 if isinstance(obstacle, Line) else 1.0
    problem = certificate.problems[0]
    assert problem.kind == "clearance"
    assert problem.obstacle == "X"
    assert problem.amount == pytest.approx(depth + radius)
    assert certificate.min_clearance == pytest.approx(-depth - radius)
    assert ("crossing" in kinds(certificate)) == (radius == 0)


@pytest.mark.parametrize("flip", [1, -1])
def test_the_deepest_of_several_obstacles_is_the_one_reported(flip: int) -> None:
    solid = [Rectangle(2, 4.5, 1, 1, name="shallow"), Rectangle(5, 4, 2, 2, name="deep")][::flip]
    for points in ([(1, 5), (9, 5)], [(9, 5), (1, 5)]):
        certificate = certify(walk(points, solid))
        assert certificate.clearance is not None
        assert certificate.clearance.obstacle == "deep"
        assert certificate.min_clearance == pytest.approx(-1)
        assert [(p.kind, p.obstacle) for p in certificate.problems] == [("clearance", "deep"), ("crossing", "deep")]


def test_a_robot_wholly_inside_an_obstacle_or_outside_the_workspace_is_found() -> None:
    inside = walk([(4.5, 4.5), (5, 5)], [Rectangle(4, 4, 2, 2, name="X")])
    assert certify(inside).min_clearance == pytest.approx(-1)
    outside = certify(walk([(12, 5), (13, 5)], []))
    assert outside.min_clearance == pytest.approx(-3)
    assert all(p.obstacle == "the wall" for p in outside.problems)
    at_rest = walk([(5, 5)], [Rectangle(4, 4, 2, 2)])
    assert certify(at_rest).min_clearance == pytest.approx(-1)
    assert kinds(certify(at_rest)) == ["clearance", "crossing"]


def test_a_nonconvex_workspace_is_not_cut_across() -> None:
    ell = [(0, 0), (10, 0), (10, 10), (8, 10), (8, 2), (0, 2)]
    found = certify(walk([(1, 1), (9, 9)], [], ell))
    assert kinds(found) == ["clearance", "crossing"]
    # along the diagonal: farthest from both arms where the notch (8, 2) is as far as the two sides are
    assert found.min_clearance == pytest.approx(-3.0)
    assert certify(walk([(1, 1), (8, 2), (9, 9)], [], ell)).ok


# ---------------------------------------------------------------------------------------------- crossing

LEFT, RIGHT = Rectangle(2, 4, 3, 2, name="L"), Rectangle(5, 4, 3, 2, name="M")
LOWER, UPPER = Rectangle(3, 3, 2, 2, name="P"), Rectangle(5, 5, 2, 2, name="Q")
DIAMOND = Polygon([(5, 0), (7, 2), (5, 4), (3, 2)], name="D")


def squares(seed: int, longest: int = 5) -> Plan:
    """Build unit squares and triangles that touch in sides and corners, and a point robot over lattice points."""
    rng = np.random.default_rng(seed)
    solid: list[Obstacle] = []
    for x, y in rng.integers(0, 6, (8, 2)).tolist():
        corners = [(x, y), (x + 1, y), (x + 1, y + 1), (x, y + 1)]
        if rng.random() < 0.4:
            corners.pop(int(rng.integers(4)))
        solid.append(Polygon(corners))
    points = rng.integers(0, 13, (rng.integers(2, longest + 1), 2)) / 2
    return walk(points.tolist(), solid, (0, 0, 6, 6))


@settings(deadline=None, max_examples=150)
@given(seeds)
def test_depth_agrees_with_dense_sampling(seed: int) -> None:
    plan = squares(seed)
    certificate = certify(plan)
    (sampled,) = naive.sampled_depth(plan, 300)
    found = max([p.amount for p in certificate.problems if p.kind == "crossing"], default=0.0)
    if sampled > plan.scene.tol:
        assert sampled * (1 - 2e-6) <= found <= sampled + 6 * math.sqrt(2) / 300
    else:
        assert found == 0.0


@settings(deadline=None, max_examples=150)
@given(seeds)
def test_a_path_is_allowed_where_a_nearby_one_keeps_its_distance(seed: int) -> None:
    plan = squares(seed, longest=3)
    assert certify(plan).ok == naive.has_room(plan, 1e-4)


@pytest.mark.parametrize(("points", "obstacles", "name"), [
    ([(5, 1), (5, 9)], [LEFT, RIGHT], "L and M"),
    ([(5, 1), (5, 4), (5, 4), (5, 6), (5, 9)], [LEFT, RIGHT], "L and M"),
    ([(3, 7), (7, 3)], [LOWER, UPPER], "P and Q"),
    ([(3, 5), (5, 5), (7, 5)], [LOWER, UPPER], "P and Q"),
    ([(4, 5), (5, 5), (5, 5), (5, 4)], [LOWER, UPPER], "P and Q"),
    ([(1, 0), (9, 0)], [DIAMOND], "D and the wall"),
    ([(1, 0), (5, 0), (5.5, 0)], [DIAMOND], "D and the wall"),
    ([(1, 0), (9, 0)], [Circle((5, 1), 1, name="C")], "C and the wall"),
    ([(1, 0), (9, 0)], [Line([(5, 1), (5, 3)], 2, name="C")], "C and the wall"),
    ([(5, 1), (5, 9)], [Circle((4, 5), 1, name="A"), Circle((6, 5), 1, name="B")], "A and B"),
    ([(1, 6.5), (5.5, 0.5)], [Circle((2, 2), 2, name="A"), Circle((5, 6), 3, name="B")], "A and B"),
    ([(5, 1), (5, 9)], [Circle((4, 5), 1, name="A"), RIGHT], "A and M"),
])  # fmt: skip
def test_no_way_along_a_seam_or_through_a_touching_point(
    points: list[tuple[float, float]], obstacles: list[Obstacle], name: str
) -> None:
    if "A and B" in name and points[0] == (1, 6.5):
        touch, along = np.array([3.2, 3.6]), np.array([-0.8, 0.6])
        points = [tuple(touch + 2 * along), tuple(touch - 2 * along)]  # the common tangent of two discs
    for way in (points, points[::-1]):
        problems = certify(walk(way, obstacles)).problems
        assert [p.kind for p in problems] == ["crossing"]
        assert problems[0].obstacle == name


@pytest.mark.parametrize(("points", "obstacles"), [
    ([(1, 4), (9, 4), (9, 6), (1, 6)], [LEFT, RIGHT]),
    ([(5, 9), (5, 6), (5, 6), (5, 9)], [LEFT, RIGHT]),
    ([(3, 5), (5, 5), (5, 7)], [LOWER, UPPER]),  # in the upper left corner, past the touching point
    ([(3, 7), (5, 5), (5, 5), (3, 7)], [LOWER, UPPER]),
    ([(5, 5), (3, 7)], [LOWER, UPPER]),  # a start on the touching point belongs to both sides
    ([(5, 5), (7, 3)], [LOWER, UPPER]),
    ([(3, 7), (5, 5)], [LOWER, UPPER]),
    ([(7, 3), (5, 5)], [LOWER, UPPER]),
    ([(5, 5)], [LOWER, UPPER]),
    ([(5, 5), (5, 5)], [LOWER, UPPER]),
    ([(1, 0), (5, 0), (1, 0)], [DIAMOND]),
    ([(1, 0), (5, 0), (3, 2), (5, 4), (7, 2), (5, 0), (9, 0)], [DIAMOND]),
    ([(1, 0), (1, 2), (9, 2), (9, 0)], [Circle((5, 1), 1)]),
    ([(0, 0), (10, 0), (10, 10), (0, 10), (0, 0)], []),
    ([(5, 1), (5, 9)], [Rectangle(2, 4, 3, 2), Rectangle(5 + 1e-9, 4, 3, 2)]),  # a narrow gap is a gap
])  # fmt: skip
def test_sliding_past_and_starting_at_a_touching_point_are_allowed(
    points: list[tuple[float, float]], obstacles: list[Obstacle]
) -> None:
    for way in (points, points[::-1]):
        assert certify(walk(way, obstacles)).problems == ()


def needle(x: float, thickness: float) -> Polygon:
    return Polygon([(x, -1), (x, 11), (x + thickness, 11), (x + thickness, -1)], "W")


TOL = 10 * 2.0**-40


@pytest.mark.parametrize("thickness", [1e-3, 0.1, 0.9, 1.1, 1.9, 2.5])
@pytest.mark.parametrize("points", [
    [(1, 5), (9, 5)],
    [(4, 3), (5, 3), (6, 3)],  # a stamp in the wall
    [(4, 2), (5 - 1e-12, 3), (5 - 1e-12, 4), (5 + 3e-11, 5), (5 + 3e-11, 6), (6, 6)],  # along it, slowly through
    [(5 - 2e-11, 1), (5 + 3e-11, 9)],
    [(5 - 2e-11, 5), (5 + 2e-11, 5)],
])  # fmt: skip
def test_no_way_through_a_thin_wall(thickness: float, points: list[tuple[float, float]]) -> None:
    for wall in (Line([(5, -1), (5, 11)], thickness * TOL, "W"), needle(5, max(thickness * TOL, 2e-15))):
        for way in (points, points[::-1]):
            problems = certify(walk(way, [wall])).problems
            assert "crossing" in [p.kind for p in problems]
            assert {p.obstacle for p in problems} == {"W"}


@pytest.mark.parametrize("thickness", [1e-3, 0.5, 1.5])
def test_ways_along_and_round_a_thin_wall_are_allowed(thickness: float) -> None:
    wall = Line([(5, -1), (5, 8)], thickness * TOL, "W")
    for points in (
        [(1, 1), (5, 1), (5, 7), (1, 7)],
        [(1, 5), (5, 8), (9, 5)],
        [(5, 4), (5, 8), (5, 4), (9, 4)],
        [(5, 4), (5, 8), (5, 9)],
        [(5, 2), (1, 2)],
        [(5, 2), (9, 2)],
    ):
        for way in (points, points[::-1]):
            assert certify(walk(way, [wall])).problems == ()


def test_a_thin_wall_is_named_with_the_place_of_crossing() -> None:
    (problem,) = certify(walk([(1, 5), (9, 5)], [Line([(5, -1), (5, 11)], 1e-12, "W")])).problems
    assert str(problem) == "R passes through W at t = 4 s near (5, 5)"


@settings(deadline=None, max_examples=80)
@given(seeds, st.floats(0, 3), st.floats(-3, 0.3))
def test_no_way_through_walls_set_end_to_end(seed: int, angle: float, thin: float) -> None:
    rng = np.random.default_rng(seed)
    cuts = [-6.0, *np.sort(rng.uniform(-5, 5, 3)).tolist(), 6.0]
    height = max(10**thin * TOL, 1e-14)
    bars = []
    for a, b in pairwise(cuts):
        bar = np.array([(a, 0), (b, 0), (b, height), (a, height)])
        bars.append(Polygon(turned(bar, angle, 1.0)))
    box = turned(np.array([(-5, -5), (5, -5), (5, 5), (-5, 5)]), angle, 1.0)
    x = rng.choice([*cuts[1:-1], *rng.uniform(-4, 4, 3)])
    across = turned(np.array([(rng.uniform(-4, 4), -3), (x, 0), (rng.uniform(-4, 4), 3)]), angle, 1.0)
    assert "crossing" in kinds(certify(walk(across, bars, box)))
    along = turned(np.array([(-4, -3), (x, 0), (cuts[1], 0), (4, -3)]), angle, 1.0)
    assert certify(walk(along, bars, box)).problems == ()


def turned(points: FloatArray, angle: float, scale: float) -> FloatArray:
    c, s = math.cos(angle), math.sin(angle)
    return np.asarray(points @ np.array([[c, s], [-s, c]]) * scale)


@settings(deadline=None, max_examples=60)
@given(seeds, scales, st.floats(0, 2 * math.pi))
def test_sliding_along_sides_with_rounding_noise_is_accepted(seed: int, scale: float, angle: float) -> None:
    rng = np.random.default_rng(seed)
    k = int(rng.integers(3, 9))
    at = np.sort(rng.uniform(0, 2 * np.pi, k))
    ring = turned(np.column_stack([np.cos(at), np.sin(at)]), angle, scale)
    if np.hypot(*(ring - np.roll(ring, 1, axis=0)).T).min() < 0.01 * scale:
        return
    cut = np.concatenate(
        [
            a + np.sort(rng.uniform(0, 1, 3))[:, None] * (b - a)
            for a, b in zip(ring, np.roll(ring, -1, axis=0), strict=True)
        ]
    )
    plan = walk(np.vstack([cut, ring[:1]])[:-1], [Polygon(ring)], (-2 * scale, -2 * scale, 2 * scale, 2 * scale))
    way = []  # along the sides, not across the corners
    for n, corner in enumerate(np.roll(ring, -1, axis=0)):
        way += [*cut[3 * n : 3 * n + 3], corner]
    plan = walk(np.array(way), [Polygon(ring)], plan.scene.workspace)
    speed = replace(plan.scene.robots[0], speed=2.0)
    assert certify(Plan(replaced(plan.scene, robots=[speed]), plan.trajectories)).problems == ()


@settings(deadline=None, max_examples=60)
@given(st.sampled_from([1.0, 1e3, 1e6]), st.floats(0, 2 * math.pi), st.booleans())
def test_a_planted_cut_through_a_side_or_corner_is_found(scale: float, angle: float, corner: bool) -> None:
    fault = max(1e-6, 1000 * 4 * scale * 2.0**-40)
    ring = np.array([[-1, -1], [1, -1], [1, 1], [-1, 1.0]])
    edge = fault / scale
    way = [[-2, 1 - edge], [2, 1 - edge]] if not corner else [[-1, 3 - 2 * 1.5 * edge], [3 - 2 * 1.5 * edge, -1]]
    plan = walk(
        turned(np.array(way), angle, scale),
        [Polygon(turned(ring, angle, scale))],
        (-4 * scale, -4 * scale, 4 * scale, 4 * scale),
    )
    found = {p.kind: p.amount for p in certify(plan).problems}
    assert set(found) == {"clearance", "crossing"}
    assert found["crossing"] == pytest.approx(1.5 * fault if corner else fault, rel=0.02)


@settings(deadline=None, max_examples=60)
@given(scales, st.floats(0, 2 * math.pi), st.integers(0, 8))
def test_corners_that_overlap_by_rounding_leave_no_way(scale: float, angle: float, steps: int) -> None:
    overlap = 0.1 * steps * 10 * 2.0**-40 / 4
    low = np.array([[-1, -1], [0, -1], [0, 0], [-1, 0.0]]) + overlap
    lower, upper = Polygon(turned(low, angle, scale), "P"), Polygon(turned(np.abs(low - overlap), angle, scale), "Q")
    plan = walk(
        turned(np.array([[-0.5, 0.5], [0.5, -0.5]]), angle, scale),
        [lower, upper],
        (-2 * scale, -2 * scale, 2 * scale, 2 * scale),
    )
    # turned squares that should just touch may be a rounding apart: then there is a way
    if steps > 0:
        assert "crossing" in kinds(certify(plan))


@settings(deadline=None, max_examples=60)
@given(scales, st.floats(0, 2 * math.pi), st.floats(0.1, 1), st.floats(0.1, 1), st.booleans())
def test_a_disc_that_touches_another_disc_or_a_side_leaves_no_way(
    scale: float, angle: float, r: float, other: float, side: bool
) -> None:
    def at(x: float, y: float) -> tuple[float, float]:
        ((u, v),) = turned(np.array([[x, y]]), angle, scale).tolist()
        return u, v

    disc = Circle(at(0, r), r * scale, "A")
    below: Obstacle = Circle(at(0, -other), other * scale, "B")
    if side:
        below = Polygon([at(-3, -1), at(3, -1), at(3, 0), at(-3, 0)], "B")
    box = (-6 * scale, -6 * scale, 6 * scale, 6 * scale)
    problems = certify(walk([at(-2, 0), at(2, 0)], [disc, below], box)).problems
    assert [(p.kind, p.obstacle) for p in problems] == [("crossing", "A and B")]
    for sign in (-1, 1):
        assert certify(walk([at(2 * sign, 0), at(0, 0), at(2 * sign, 0)], [disc, below], box)).ok


@pytest.mark.parametrize("angle", [0.0, 0.3, 0.7, 1.2])
def test_rectangles_that_touch_but_for_rounding_leave_no_way(angle: float) -> None:
    along, across = np.array([math.cos(angle), math.sin(angle)]), np.array([-math.sin(angle), math.cos(angle)])
    middles = [np.array([5.0, 5.0]) + 2 * k * along for k in (-1, 0, 1)]
    wall = [Rectangle(x - 1, y - 0.25, 2, 0.5, angle, f"W{k}") for k, (x, y) in enumerate(middles)]
    seam = middles[1] + along
    through = [tuple(seam + 2 * across), tuple(seam - 2 * across)]
    assert kinds(certify(walk(through, wall))) == ["crossing"]
    side = 0.25 * (1 + 1e-14)
    past = [tuple(seam + side * across + step * along) for step in (-0.5, 0.5)]
    assert certify(walk(past, wall)).ok


def test_where_nothing_is_free_a_point_robot_is_told() -> None:
    problems = certify(walk([(1, 1), (2, 2)], [Rectangle(-1, -1, 12, 12, name="X")])).problems
    assert [p.kind for p in problems] == ["clearance", "crossing"]


def test_a_chain_of_touching_obstacles_closes_a_pocket() -> None:
    ring: list[Obstacle] = [
        Polygon([(5, 2), (6, 3), (5, 4), (4, 3)]), Polygon([(7, 4), (8, 5), (7, 6), (6, 5)]),
        Polygon([(5, 6), (6, 7), (5, 8), (4, 7)]), Polygon([(3, 4), (4, 5), (3, 6), (2, 5)]),
        Polygon([(6, 3), (7, 3), (7, 4)]), Polygon([(7, 6), (7, 7), (6, 7)]),
        Polygon([(4, 7), (3, 7), (3, 6)]), Polygon([(3, 4), (3, 3), (4, 3)]),
    ]  # fmt: skip
    assert certify(walk([(5, 5), (5.5, 4), (6, 3.5), (5, 5)], ring)).problems == ()
    assert kinds(certify(walk([(5, 5), (6, 3), (6, 1)], ring))) == ["crossing"]


# ---------------------------------------------------------------------------------------------- ends, speed, claims


@settings(deadline=None, max_examples=40)
@given(seeds, scales, st.sampled_from(["start", "goal"]), st.floats(0, 2 * math.pi))
def test_a_displaced_start_or_goal_is_found(seed: int, scale: float, kind: str, angle: float) -> None:
    plan = random_plan(seed, scale, robots=1)
    tol, (robot,) = plan.scene.tol, plan.scene.robots
    for fault, found in ((0.9 * tol, 0), (1.1 * tol, 1), (max(1e-6, 1000 * tol), 1)):
        x, y = getattr(robot, kind)
        off = (x + fault * math.cos(angle), y + fault * math.sin(angle))
        moved = replace(robot, start=off) if kind == "start" else replace(robot, goal=off)
        problems = certify(Plan(replaced(plan.scene, robots=[moved]), plan.trajectories)).problems
        assert [p.kind for p in problems] == [kind] * found
        if found:
            assert problems[0].amount == pytest.approx(fault, rel=1e-12, abs=tol / 50)


@settings(deadline=None, max_examples=40)
@given(seeds, scales)
def test_haste_is_found(seed: int, scale: float) -> None:
    plan = random_plan(seed, scale, robots=1)
    tol, (robot,), (path,) = plan.scene.tol, plan.scene.robots, plan.trajectories
    assert "speed" not in kinds(certify(plan))
    if path.length == 0:
        return
    leg = int(np.argmax(np.hypot(*np.diff(path.points, axis=0).T)))
    for fault, found in ((0.9 * tol, False), (1.1 * tol, True), (1000 * tol, True)):
        stamps = path.stamps.copy()
        stamps[leg + 1 :, 0] -= fault / robot.speed
        certificate = certify(Plan(plan.scene, (Trajectory(path.name, stamps),)))
        mine = [p for p in certificate.problems if p.kind == "speed"]
        assert len(mine) == int(found)
        if found:
            assert mine[0].time == stamps[leg, 0]
            assert certificate.max_speed_ratio > 1


def test_a_slow_plan_has_a_speed_ratio_below_one() -> None:
    scene = Scene((0, 0, 9, 9), robots=[Robot("A", (1, 1), (3, 1), speed=2)])
    assert certify(Plan(scene, (track("A", [[0, 1, 1], [4, 3, 1]]),))).max_speed_ratio == 0.25


def test_moving_before_the_start_time_is_found() -> None:
    scene = Scene((0, 0, 9, 9), robots=[Robot("A", (1, 1), (3, 1), start_time=2)])
    assert certify(Plan(scene, (track("A", [[0, 1, 1], [2, 1, 1], [4, 3, 1]]),))).ok
    (problem,) = certify(Plan(scene, (track("A", [[0, 1, 1], [2 - 1e-6, 1, 1], [4, 3, 1]]),))).problems
    assert problem.kind == "start_time"
    assert problem.amount == pytest.approx(1e-6, rel=1e-4)
    # there and back again before the start time
    there = track("A", [[0, 1, 1], [0.5, 1.2, 1], [1, 1, 1], [2, 1, 1], [4, 3, 1]])
    (problem,) = certify(Plan(scene, (there,))).problems
    assert problem.amount == pytest.approx(0.2)
    assert problem.time == 0.5


def test_a_plan_for_another_scene_is_a_problem() -> None:
    plan = walk([(1, 1), (2, 2)], [LEFT])
    assert certify(plan, walk([(1, 1), (2, 2)], [LEFT]).scene).ok
    (problem,) = certify(plan, replaced(plan.scene, obstacles=[RIGHT], gap=1.0)).problems
    assert problem.kind == "scene"
    assert "obstacles, gap" in str(problem)


@pytest.mark.parametrize(
    ("claims", "count"),
    [({}, 0), ({"contact": None, "x": {}}, 0), ({"contact": {"range": 3}}, 0), ({"fast": True, "b": 0}, 2)],
)
def test_claims_are_not_taken_at_their_word(claims: dict[str, object], count: int) -> None:
    plan = walk([(1, 1), (2, 2)], [])
    problems = certify(replace(plan, claims=claims)).problems
    assert [p.kind for p in problems] == ["claim"] * count
    assert all("which this version cannot prove" in str(p) for p in problems)


# ---------------------------------------------------------------------------------------------- the report


def test_an_empty_team_is_proved() -> None:
    certificate = certify(Plan(Scene((0, 0, 1, 1)), ()))
    assert certificate.ok
    assert certificate.min_separation is None
    assert certificate.min_clearance is None
    assert json.loads(json.dumps(certificate.as_dict(), allow_nan=False))["ok"] is True


def test_absurd_numbers_are_refused_in_a_report_that_can_be_written() -> None:
    team = [Robot("A", (1, 1), (2, 2)), Robot("B", (3, 3), (3, 3))]
    scene = Scene((0, 0, 9, 9), [LEFT, Circle((7, 7), 1)], team, gap=0.1)
    for far in (1e12, 1e200, 1.7e308):
        wild = track("A", [[0, 1, 1], [1e-300, far, -far], [2, -far, far], [3, 2, 2]])
        certificate = certify(Plan(scene, (wild, track("B", [[0, 3, 3]]))))
        assert {"speed", "clearance", "crossing"} <= set(kinds(certificate))
        json.dumps(certificate.as_dict(), allow_nan=False)


def test_a_report_names_who_where_when_and_how_much() -> None:
    team = [Robot("A", (1, 5), (9, 5), 0.5), Robot("B", (9, 5), (1, 5), 0.5)]
    paths = track("A", [[0, 1, 5], [8, 9, 5]]), track("B", [[0, 9, 5], [8, 1, 5]])
    certificate = certify(Plan(Scene((0, 0, 10, 10), [], team, gap=0.25), paths))
    assert str(certificate.problems[0]) == (
        "A and B come 1.25 m nearer to each other than allowed at t = 4 s near (5, 5) "
        "(-1 m between the discs, 0.25 m needed)"
    )
    plain = certificate.as_dict()
    assert plain == json.loads(json.dumps(plain, allow_nan=False))
    assert plain["min_separation"] == -1
    assert plain["problems"][0]["place"] == [5, 5]
    assert certify(Plan(Scene((0, 0, 10, 10), [], team, gap=0.25), paths)).as_dict() == plain


@pytest.mark.parametrize("swap", [False, True])
def test_the_order_of_robots_does_not_change_the_numbers(swap: bool) -> None:
    plan = random_plan(11, 1.0, robots=6)
    order = [3, 1, 5, 0, 2, 4] if swap else [5, 4, 3, 2, 1, 0]
    scene = replaced(plan.scene, robots=[plan.scene.robots[k] for k in order])
    other, here = certify(Plan(scene, plan.trajectories)), certify(plan)
    assert other.min_separation == here.min_separation
    assert other.min_clearance == here.min_clearance
