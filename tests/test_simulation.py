"""The closed loop: vehicles follow a plan, what is measured is what happened, and late robots harm nobody."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import replace
from pathlib import Path
from unittest import mock

import numpy as np
import pytest
import shapely
from hypothesis import given, settings
from hypothesis import strategies as st

from taut.certificate import certify
from taut.certificate.clearance import shapes_of
from taut.errors import OutputError, PlanError, SceneError
from taut.motion import Plan, Trajectory
from taut.scene import Circle, Line, Obstacle, Polygon, Rectangle, Robot, Scene
from taut.simulation import (
    KINDS,
    Disturbances,
    Lidar,
    Run,
    Unicycle,
    contact_kept,
    driven_plan,
    driving,
    load_margin,
    run_data,
    runs_needed,
    save_study,
    scene_from,
    simulate,
    stopped,
    study,
    tracking_margin,
    with_margin,
)
from taut.simulation._chance_kernels import hashed, normal
from taut.simulation._nearness_kernels import nearest_passing, nearest_shape, sides_of_cells
from taut.simulation.driving import grid_over
from taut.team import plan as plan_team

Stamps = Sequence[Sequence[float]]


def crossing(gap: float = 0.1, wait: float = 2.0, **more: object) -> Plan:
    """A goes east along y = 4; B waits, then goes north through A's way."""
    robots = [Robot("A", (1, 4), (7, 4), 0.3), Robot("B", (4, 1), (4, 7), 0.3)]
    paths = {"A": [[0, 1, 4], [6, 7, 4]], "B": [[0, 4, 1], [wait, 4, 1], [wait + 6, 4, 7]]}
    return plan_of(Scene((0, 0, 8, 8), robots=robots, gap=gap, **more), paths)  # type: ignore[arg-type]


def plan_of(scene: Scene, paths: Mapping[str, Stamps]) -> Plan:
    plan = Plan(scene, tuple(Trajectory(name, np.array(stamps, dtype=float)) for name, stamps in paths.items()))
    assert certify(plan).ok, certify(plan).problems
    return plan


@pytest.fixture(scope="module")
def calm() -> Run:
    return simulate(crossing(), every=0.02)


def test_an_undisturbed_team_arrives_on_time_and_keeps_to_its_paths(calm: Run) -> None:
    assert calm.arrived
    assert not calm.collisions
    assert (calm.delays < 2.0).all()
    assert (calm.greatest_stray < 0.02).all()
    assert np.allclose(calm.poses[-1, :, :2], [[7, 4], [4, 7]], atol=0.02)
    assert np.allclose(calm.distance, 6.0, atol=0.05)
    assert (calm.turned < 0.2).all()


@pytest.mark.parametrize("kind", KINDS)
def test_every_kind_of_vehicle_arrives(kind: str) -> None:
    run = simulate(crossing(), vehicle=kind, disturbances=Disturbances(speed_error=0.2, stops=0.1))
    assert run.arrived, stopped(run)


@pytest.mark.parametrize("kind", KINDS)
@pytest.mark.parametrize("noise", [0.02, 0.1])
def test_robots_that_know_their_places_badly_come_round_corners_and_arrive(kind: str, noise: float) -> None:
    corner = plan_of(
        Scene((0, 0, 8, 8), robots=[Robot("A", (1, 1), (6, 6))]), {"A": [[0, 1, 1], [5, 6, 1], [10, 6, 6]]}
    )
    blurred = Disturbances(position_noise=noise)
    run = simulate(corner, kind, 1, blurred)
    assert run.arrived
    assert run.makespan < 1.3 * corner.makespan
    assert math.dist(run.poses[-1, 0, :2], (6, 6)) < 3 * noise
    assert study(corner, range(10), kind, blurred).complete == 10


def test_the_same_seed_gives_the_same_run_and_another_seed_another() -> None:
    met = Disturbances(speed_error=0.2, stops=0.2, position_noise=0.01, heading_noise=0.01, slip=0.05)
    first, again, other = (simulate(crossing(), seed=seed, disturbances=met) for seed in (5, 5, 6))
    assert np.array_equal(first.poses, again.poses)
    assert first.collisions == again.collisions
    assert first.waits == again.waits
    assert first.poses.shape != other.poses.shape or not np.array_equal(first.poses, other.poses)


def test_looking_closer_changes_nothing() -> None:
    met = Disturbances(speed_error=0.2, stops=0.2)
    coarse = simulate(crossing(), seed=1, disturbances=met, every=0.5)
    fine = simulate(crossing(), seed=1, disturbances=met, every=0.02, lidar=Lidar(beams=3))
    assert np.array_equal(coarse.arrivals, fine.arrivals)
    assert coarse.separations == fine.separations
    assert fine.scans is not None
    assert fine.scans.ranges.shape == (len(fine.scans.times), 2, 3)
    assert np.allclose(fine.scans.times, fine.times[: len(fine.scans.times)])


@pytest.mark.parametrize("coordination", [True, False])
def test_running_out_of_room_changes_nothing(coordination: bool, monkeypatch: pytest.MonkeyPatch) -> None:
    slow = Disturbances(slow={"A": 0.45}, stops=0.2)
    roomy = simulate(crossing(), disturbances=slow, coordination=coordination)
    for name in ("_EVENTS", "_PAIRS", "_RECORDED_AT_ONCE"):
        monkeypatch.setattr(driving, name, 0)
    tight = simulate(crossing(), disturbances=slow, coordination=coordination)
    assert np.array_equal(tight.poses, roomy.poses)
    assert tight.collisions == roomy.collisions
    assert tight.waits == roomy.waits
    assert tight.waits or tight.collisions


def test_recorded_instants_begin_at_0_and_end_with_the_run(calm: Run) -> None:
    assert calm.times[0] == 0.0
    assert (np.diff(calm.times) > 0).all()
    assert calm.seconds >= calm.makespan
    assert (np.diff(calm.progress, axis=0) >= 0).all()
    assert (calm.progress <= calm.times[:, None] + 0.1).all()


def test_the_least_separation_is_that_of_the_driven_motions(calm: Run) -> None:
    apart = np.hypot(*(calm.poses[:, 0, :2] - calm.poses[:, 1, :2]).T) - 0.6
    least = calm.separations[0]
    assert apart.min() - 0.04 <= least.distance <= apart.min() + 1e-12
    assert least.other == "B"
    assert abs(least.time - calm.times[apart.argmin()]) <= 0.02 + 1e-9
    assert least.distance == calm.separations[1].distance


def test_the_least_clearance_is_that_of_the_driven_motions() -> None:
    solid: list[Obstacle] = [
        Circle((3, 1.5), 0.5),
        Polygon([(4, 2.5), (5, 2.5), (4.5, 4)]),
        Line([(6, 1), (7, 1.2)], 0.2),
    ]
    scene = Scene((0, 0, 9, 4), solid, [Robot("A", (1, 2.3), (8, 2.3), 0.1)])
    run = simulate(plan_of(scene, {"A": [[0, 1, 2.3], [7, 8, 2.3]]}), every=0.02)
    whole = shapely.union_all(
        [
            shapely.Point(3, 1.5).buffer(0.5, quad_segs=4096),
            shapely.Polygon([(4, 2.5), (5, 2.5), (4.5, 4)]),
            shapely.LineString([(6, 1), (7, 1.2)]).buffer(0.1, quad_segs=4096),
            shapely.box(0, 0, 9, 4).exterior,
        ]
    )
    least = shapely.distance(whole, shapely.points(run.poses[:, 0, :2])).min() - 0.1
    assert least - 0.03 <= run.clearances[0].distance <= least + 1e-6
    assert run.clearances[0].other == "O2"


@pytest.mark.parametrize("coordination", [True, False])
def test_late_robots_slow_those_that_pass_after_them_and_without_that_they_collide(coordination: bool) -> None:
    slow = Disturbances(slow={"A": 0.45})
    run = simulate(crossing(), disturbances=slow, coordination=coordination)
    assert run.arrived
    assert bool(run.collisions) != coordination
    if coordination:
        assert {(wait.robot, wait.holder) for wait in run.waits} == {("B", "A")}
        assert sum(wait.lost for wait in run.waits) > 0.5
        assert run.separations[0].distance > 0.05
    else:
        (hit,) = run.collisions
        assert {hit.robot, hit.other} == {"A", "B"}
        assert hit.depth == pytest.approx(-run.separations[0].distance)
        assert math.dist(hit.place, (4, 4)) < 1.0


def test_a_dead_robot_stops_those_alone_that_pass_after_it() -> None:
    robots = (*crossing().scene.robots, Robot("C", (1, 6.5), (2, 7), 0.3))
    scene = replace(crossing().scene, robots=robots)
    paths: dict[str, Stamps] = {t.name: t.stamps.tolist() for t in crossing().trajectories}
    plan = plan_of(scene, {**paths, "C": [[0, 1, 6.5], [4, 2, 7]]})
    run = simulate(plan, disturbances=Disturbances(dies={"A": 2.0}))
    assert list(stopped(run)) == ["A", "B"]
    assert stopped(run)["A"] == "died at 2 s"
    assert stopped(run)["B"] == "waits for A"
    assert not run.collisions
    assert run.seconds < 40
    report = run_data(run)
    assert report["arrived"] == 1
    assert report["robots"][1]["stopped"] == "waits for A"


def test_the_team_can_be_planned_on_from_where_it_stands() -> None:
    run = simulate(crossing(), disturbances=Disturbances(dies={"A": 2.0}))
    scene = scene_from(run)
    assert [robot.name for robot in scene.robots] == ["B"]
    assert scene.robots[0].goal == (4.0, 7.0)
    on = plan_team(scene)
    assert on.certificate.ok
    after = simulate(on.plan)
    assert after.arrived
    assert not after.collisions


def test_a_scene_to_plan_on_from_asks_for_no_more_room_than_there_is() -> None:
    scene = Scene((0, 0, 8, 2), robots=[Robot("A", (1, 0.5), (7, 0.5), 0.3)], clearance=0.2)
    run = simulate(plan_of(scene, {"A": [[0, 1, 0.5], [6, 7, 0.5]]}))
    off = replace(run, poses=run.poses - [0.0, 0.05, 0.0])
    assert scene_from(off).robots[0].clearance == pytest.approx(0.15, abs=0.02)
    assert plan_team(scene_from(off)).certificate.ok


def test_robots_that_leave_are_gone_and_hit_nobody() -> None:
    robots = [Robot("A", (1, 1), (4, 1), 0.3), Robot("B", (1, 3), (4, 1), 0.3)]
    scene = Scene((0, 0, 6, 4), robots=robots, at_goal="leave")
    plan = plan_of(scene, {"A": [[0, 1, 1], [3, 4, 1]], "B": [[0, 1, 3], [3.5, 1, 3], [3.5 + math.sqrt(13), 4, 1]]})
    run = simulate(plan)
    assert run.arrived
    assert not run.collisions
    assert [robot.name for robot in scene_from(run).robots] == []


def test_a_robot_that_hits_an_obstacle_is_told_with_its_name_and_goes_on() -> None:
    scene = Scene((0, 0, 8, 4), [Rectangle(3, 0, 1, 1.7, name="box")], [Robot("A", (1, 2), (7, 2), 0.3)])
    plan = plan_of(scene, {"A": [[0, 1, 2], [6, 7, 2]]})
    run = simulate(plan, disturbances=Disturbances(slip=0.3), seed=3)
    assert run.arrived
    assert {hit.other for hit in run.collisions} == {"box"}
    assert run.clearances[0].distance < 0
    assert 2.6 < run.collisions[0].place[0] < 4.4


def test_energy_is_what_it_takes_to_speed_up_and_to_roll() -> None:
    scene = Scene((0, 0, 12, 2), robots=[Robot("A", (1, 1), (11, 1), 0.2)])
    run = simulate(plan_of(scene, {"A": [[0, 1, 1], [10, 11, 1]]}))
    top = 1.25
    rolling = 0.02 * 9.81 * 10.0
    assert rolling + 0.45 < run.work[0] < rolling + top * top / 2 + 0.3


def test_contact_that_a_plan_claims_is_measured_on_the_driven_motions() -> None:
    robots = [Robot("A", (1, 1), (9, 1), 0.2), Robot("B", (1, 2), (9, 2), 0.2)]
    scene = Scene((0, 0, 10, 3), robots=robots, gap=0.1)
    paths = {"A": [[0, 1, 1], [8, 9, 1]], "B": [[0, 1, 2], [8, 9, 2]]}
    plan = replace(plan_of(scene, paths), claims={"contact": {"range": 1.5}})
    kept = contact_kept(simulate(plan))
    assert kept is not None
    assert kept.least == pytest.approx(2.0)
    assert kept.lost == ()
    late = contact_kept(simulate(plan, disturbances=Disturbances(slow={"B": 0.4})))
    assert late is not None
    assert late.least == 0.0
    assert late.lost
    assert contact_kept(simulate(crossing())) is None


def test_the_driven_motions_are_a_plan_that_can_be_sampled(calm: Run) -> None:
    driven = driven_plan(calm)
    assert np.allclose(driven.trajectories[0].at(calm.times), calm.poses[:, 0, :2])


def test_an_empty_team_has_arrived() -> None:
    run = simulate(Plan(Scene((0, 0, 1, 1)), ()))
    assert run.arrived
    assert run.seconds == 0.0
    assert run_data(run)["robots"] == []


def test_a_robot_that_is_at_its_goal_stays_there() -> None:
    scene = Scene((0, 0, 2, 2), robots=[Robot("A", (1, 1), (1, 1), 0.2)])
    run = simulate(plan_of(scene, {"A": [[0, 1, 1]]}))
    assert run.arrived
    assert run.distance[0] == 0.0


def test_a_start_time_is_kept() -> None:
    scene = Scene((0, 0, 4, 2), robots=[Robot("A", (1, 1), (3, 1), 0.2, start_time=20.0)])
    run = simulate(plan_of(scene, {"A": [[0, 1, 1], [20, 1, 1], [22, 3, 1]]}), every=0.02)
    before = run.times < 20.0
    assert np.allclose(run.poses[before, 0, 0], 1.0, atol=1e-9)
    assert 22.0 < run.arrivals[0] < 24.0


@pytest.mark.parametrize(
    ("words", "change"),
    [
        ("only plans that hold", {"plan": "bad"}),
        ("unknown vehicle 'boat'", {"vehicle": "boat"}),
        ("no robot Z", {"vehicle": {"Z": "unicycle"}}),
        ("seed must be a whole number", {"seed": -1}),
        ("step must be positive", {"dt": 0.0}),
        ("step must be positive", {"dt": math.nan}),
        ("step must be a number", {"dt": "soon"}),
        ("step must be from", {"dt": 1e-310}),
        ("step must be from", {"dt": 100}),
        ("too far in a workspace", {"vehicle": Unicycle(1e4, 3.0), "dt": 0.02}),
        ("a vehicle must be one of", {"vehicle": None}),
        ("a vehicle must be one of", {"vehicle": {"A": 5}}),
        ("lidar must be", {"lidar": 5}),
        ("recorded instants", {"every": 0.0}),
        ("no robot Z", {"disturbances": Disturbances(dies={"Z": 1.0})}),
    ],
)
def test_what_makes_no_sense_is_refused_in_one_line(words: str, change: dict[str, object]) -> None:
    given: dict[str, object] = {"plan": crossing(), **change}
    if given["plan"] == "bad":
        fast = Trajectory("A", np.array([[0, 1, 4], [1, 7, 4]], dtype=float))
        given["plan"] = Plan(crossing().scene, (fast, crossing().trajectories[1]))
    with pytest.raises(SceneError, match=words) as told:
        simulate(**given)  # type: ignore[arg-type]
    assert "\n" not in str(told.value)


def test_a_plan_that_does_not_hold_is_a_plan_error() -> None:
    fast = Trajectory("A", np.array([[0, 1, 4], [1, 7, 4]], dtype=float))
    with pytest.raises(PlanError):
        study(Plan(crossing().scene, (fast, crossing().trajectories[1])), [1])


@pytest.mark.parametrize(
    "wrong",
    [
        {"speed_error": -0.1}, {"speed_error": 1.0}, {"speed_error": math.nan}, {"stops": -1},
        {"stops": 0.1, "stop_seconds": 0}, {"slow": {"A": 0.0}}, {"slow": {"A": 2.0}}, {"dies": {"A": -1.0}},
        {"slip": 0.6}, {"position_noise": math.inf}, {"position_noise": 1e200}, {"heading_noise": 4.0},
        {"stops": 1e300, "stop_seconds": 1e-300}, {"stops": 0.1, "stop_seconds": 1e-9}, {"slow": [("A", 0.5)]},
        {"dies": "A"},
    ],
)  # fmt: skip
def test_disturbances_that_make_no_sense_are_refused(wrong: dict[str, object]) -> None:
    with pytest.raises(SceneError):
        Disturbances(**wrong)  # type: ignore[arg-type]


def test_hashed_numbers_look_uniform_and_independent() -> None:
    values = np.array([[hashed(7, i, k, 3) for k in range(300)] for i in range(30)])
    assert 0 < values.min() < values.max() < 1
    assert abs(values.mean() - 0.5) < 0.01
    assert np.histogram(values, 10, (0, 1))[0].min() > 780
    for a, b in ((values[:, 1:], values[:, :-1]), (values[1:], values[:-1])):
        assert abs(np.corrcoef(a.ravel(), b.ravel())[0, 1]) < 0.04
    assert hashed(7, 0, 0, 3) != hashed(8, 0, 0, 3)


def test_normal_numbers_have_the_moments_of_the_normal_distribution() -> None:
    values = np.array([normal(1, i, k, 0) for i in range(40) for k in range(400)])
    assert abs(values.mean()) < 0.03
    assert abs(values.std() - 1) < 0.02
    assert abs((values**4).mean() - 3) < 0.3


coordinates = st.floats(-3, 11, width=32)


@settings(max_examples=150)
@given(st.lists(coordinates, min_size=4, max_size=4), st.floats(0.01, 20))
def test_the_nearest_shape_to_a_motion_is_that_of_shapely(motion: list[float], within: float) -> None:
    solid: list[Obstacle] = [Circle((2, 2), 0.5), Rectangle(4, 4, 2, 1, 0.3), Line([(1, 6), (3, 7), (6, 6.5)], 0.4)]
    shapes = shapes_of(Scene((0, 0, 8, 8), solid))
    ax, ay, bx, by = motion
    edges = np.ascontiguousarray(shapes.edges)
    x0, y0, size, columns, rows = grid_over(edges, 16)
    cells, sides = sides_of_cells(edges, x0, y0, size, columns, rows)
    found, shape = nearest_shape(
        ax, ay, bx, by, within, edges, shapes.owner, shapes.radius, cells, sides, x0, y0, size, columns, rows
    )
    lines = [shapely.Point(e[:2]) if (e[:2] == e[2:]).all() else shapely.LineString(e.reshape(2, 2)) for e in edges]
    a, b = (ax, ay), (bx, by)
    way = shapely.Point(a) if a == b else shapely.LineString([a, b])
    distances = [shapely.distance(way, line) - shapes.radius[o] for line, o in zip(lines, shapes.owner, strict=True)]
    if min(distances) >= within:
        assert shape == -1 or found >= within - 1e-6
    elif min(distances) > 1e-6:
        assert found == pytest.approx(min(distances), abs=1e-6)
    else:
        assert found <= 1e-6


@given(st.lists(st.floats(-5, 5), min_size=4, max_size=4))
def test_the_least_distance_of_a_passing_is_found(ends: list[float]) -> None:
    distance, s = nearest_passing(*ends)
    a, b = np.array(ends[:2]), np.array(ends[2:])
    sampled = np.hypot(*(a + np.linspace(0, 1, 501)[:, None] * (b - a)).T).min()
    assert 0 <= s <= 1
    assert distance <= sampled + 1e-12
    assert distance == pytest.approx(np.hypot(*(a + s * (b - a))), abs=1e-12)
    assert sampled - distance <= np.hypot(*(b - a)) / 500 + 1e-12


def test_a_margin_is_the_least_order_statistic_with_the_confidence() -> None:
    strays = np.random.default_rng(0).permutation(np.arange(1, 501) / 1000)
    for p, confidence in ((0.9, 0.95), (0.95, 0.9), (0.99, 0.95)):
        below = np.cumsum([math.comb(500, k) * p**k * (1 - p) ** (500 - k) for k in range(500)])
        k = int(np.flatnonzero(below >= confidence)[0])
        assert tracking_margin(strays, p, confidence).metres == pytest.approx((k + 1) / 1000)
        assert tracking_margin(strays, p, confidence).probability == p


def test_too_few_runs_state_a_lower_probability_with_the_greatest_stray() -> None:
    margin = tracking_margin([0.01, 0.02, 0.03], 0.999)
    assert margin.metres == 0.03
    assert margin.probability == pytest.approx(0.05 ** (1 / 3))
    needed = runs_needed(0.999)
    assert tracking_margin(np.zeros(needed), 0.999).probability == 0.999
    assert tracking_margin(np.zeros(needed - 1), 0.999).probability < 0.999


def test_margins_cover_new_runs_as_often_as_they_say() -> None:
    rng = np.random.default_rng(4)
    covered = [1 - math.exp(-tracking_margin(rng.exponential(size=120), 0.9, 0.8).metres) >= 0.9 for _ in range(400)]
    assert np.mean(covered) >= 0.75


@pytest.mark.parametrize(
    "wrong", [([],), ([-1.0],), ([math.nan],), (["a"],), ([1.0], 0.0), ([1.0], 1.0), ([1.0], 0.9, 1.0)]
)
def test_margins_of_nothing_are_refused(wrong: tuple[object, ...]) -> None:
    with pytest.raises(SceneError):
        tracking_margin(*wrong)  # type: ignore[arg-type]


@pytest.mark.parametrize("wrong", [(0.0,), (1.0,), (0.9, 1.0), (math.nan,)])
def test_no_number_of_runs_is_certain(wrong: tuple[float, ...]) -> None:
    with pytest.raises(SceneError):
        runs_needed(*wrong)


def test_room_for_a_margin_is_added_to_every_distance() -> None:
    scene = Scene((0, 0, 4, 4), robots=[Robot("A", (1, 1), (3, 3), clearance=0.5), Robot("B", (1, 3), (3, 1))], gap=0.1)
    grown = with_margin(scene, 0.05)
    assert grown.gap == pytest.approx(0.2 / 0.95)
    assert [grown.growth(robot) for robot in grown.robots] == pytest.approx([0.55, 0.05])
    for wrong in (-0.1, math.nan):
        with pytest.raises(SceneError):
            with_margin(scene, wrong)


def test_a_study_is_the_same_on_one_core_and_on_many() -> None:
    met = Disturbances(speed_error=0.2, stops=0.2)
    found = study(crossing(), range(12), disturbances=met)
    with mock.patch("os.cpu_count", return_value=1):
        alone = study(crossing(), range(12), disturbances=met)
    assert found == alone
    assert [trial.seed for trial in found.trials] == list(range(12))
    single = simulate(crossing(), seed=4, disturbances=met)
    assert found.trials[4].makespan == single.makespan
    assert found.trials[4].stray == single.greatest_stray.max()
    near = single.separations[0].distance
    assert found.trials[4].separation == (near if math.isfinite(near) else None)


def test_teams_with_the_margin_of_a_study_do_not_collide_and_others_do() -> None:
    met = Disturbances(speed_error=0.2, stops=0.2)
    bare = crossing(gap=0.0, wait=1.0).scene
    margin = study(plan_team(bare).plan, range(60), disturbances=met).margin
    roomy = plan_team(with_margin(bare, margin.metres)).plan
    fresh = range(1000, 1060)
    assert study(roomy, fresh, disturbances=met).collided == 0
    assert study(roomy, fresh, disturbances=met, coordination=False).collided > 0


def test_a_study_tells_how_far_it_has_come() -> None:
    told: list[int] = []
    study(crossing(), range(5), tell=told.append)
    assert told == [1, 2, 3, 4, 5]
    with pytest.raises(SceneError, match="at least one seed"):
        study(crossing(), [])


@pytest.mark.parametrize("ending", [".json", ".jsonl"])
def test_the_margin_of_a_study_survives_its_file(ending: str, tmp_path: Path) -> None:
    found = study(crossing(), range(5))
    path = tmp_path / f"study{ending}"
    save_study(found, path)
    assert load_margin(path) == found.margin
    assert len(path.read_text().splitlines()) == (7 if ending == ".json" else 6)


SOUND = (
    '{"kind": "study", "count": 5, "complete": 5, "coordinated": true, '
    '"margin": {"metres": 0.02, "probability": 0.9, "confidence": 0.8, "runs": 5}}'
)


def test_a_margin_is_taken_from_any_file_that_holds_a_sound_one(tmp_path: Path) -> None:
    (tmp_path / "study.json").write_text(SOUND)
    assert load_margin(tmp_path / "study.json").metres == 0.02


@pytest.mark.parametrize(
    "text",
    [
        "", "{", "[1]", '{"kind": "plan"}', '{"kind": "study"}', '{"kind": "study", "margin": 3}',
        '{"kind": "study", "margin": {"metres": -1, "probability": 0.9, "confidence": 0.9, "runs": 1}}',
        *(
            SOUND.replace(sound, wrong)
            for sound, wrong in (
                ("0.02", "true"), ("0.02", '"0.02"'), ("0.02", "-1"), ("0.9,", "7,"), ("0.8", "-3"),
                ('"runs": 5', '"runs": -5'), ('"runs": 5', '"runs": 1e999'), ('"complete": 5', '"complete": 4'),
                ('"coordinated": true', '"coordinated": false'), ('"count": 5,', ""),
            )
        ),
    ],
)  # fmt: skip
def test_files_that_are_no_studies_are_refused(text: str, tmp_path: Path) -> None:
    path = tmp_path / "study.json"
    path.write_text(text)
    with pytest.raises(SceneError, match=r"study\.json"):
        load_margin(path)
    with pytest.raises(SceneError, match="cannot be read"):
        load_margin(tmp_path / "none.json")


def test_a_study_is_written_as_json_alone(tmp_path: Path) -> None:
    with pytest.raises(OutputError, match=r"\.json or \.jsonl"):
        save_study(study(crossing(), [0]), tmp_path / "study.txt")
