"""Hard cases of the closed loop: rings that graze, trucks that miss, noise, deep collisions, the dead, interrupts."""

from __future__ import annotations

import json
import math
import os
import signal
import threading
from collections.abc import Mapping, Sequence
from dataclasses import replace
from itertools import pairwise
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import shapely
from hypothesis import given, settings
from hypothesis import strategies as st

from taut.certificate import certify
from taut.certificate.clearance import shapes_of
from taut.control.coordination import allowed
from taut.formats import load_scene
from taut.motion import Plan, Trajectory
from taut.scene import Circle, Line, Obstacle, Polygon, Rectangle, Robot, Scene
from taut.simulation import (
    Ackermann,
    DifferentialDrive,
    Disturbances,
    Run,
    StudyInterrupted,
    Unicycle,
    dead,
    load_margin,
    run_data,
    save_study,
    scene_from,
    simulate,
    stopped,
    study,
    study_doubts,
    with_margin,
)
from taut.simulation._nearness_kernels import deepest_inside
from taut.simulation._vehicle_kernels import move
from taut.simulation.driving import Driven, Setting, drive, ground_of
from taut.simulation.running import longest, prepared, waits_of
from taut.simulation.vehicles import tables
from taut.team import plan as plan_team

Stamps = Sequence[Sequence[float]]


def plan_of(scene: Scene, paths: Mapping[str, Stamps]) -> Plan:
    plan = Plan(scene, tuple(Trajectory(name, np.array(stamps, dtype=float)) for name, stamps in paths.items()))
    assert certify(plan).ok, certify(plan).problems
    return plan


def ring(gap: float) -> Plan:
    """Four robots change places in a square, all at once; in the middle they graze each other."""
    at = [(4, 4), (5, 4), (5, 5), (4, 5)]
    radius = (math.sqrt(0.5) - gap) / 2
    robots = [Robot(f"R{k}", at[k], at[(k + 1) % 4], radius) for k in range(4)]
    return plan_of(
        Scene((0, 0, 10, 10), robots=robots, gap=gap),
        {f"R{k}": [[0, *at[k]], [1, *at[(k + 1) % 4]]] for k in range(4)},
    )


def corner() -> Plan:
    scene = Scene((0, 0, 12, 12), robots=[Robot("A", (1, 1), (9, 9), 0.2)])
    return plan_of(scene, {"A": [[0, 1, 1], [8, 9, 1], [16, 9, 9]]})


def crossing(gap: float = 0.1, clearance: float = 0.0) -> Plan:
    robots = [Robot("A", (1, 4), (7, 4), 0.3), Robot("B", (4, 1), (4, 7), 0.3)]
    scene = Scene((0, 0, 8, 8), robots=robots, gap=gap, clearance=clearance, name="crossing")
    return plan_of(scene, {"A": [[0, 1, 4], [6, 7, 4]], "B": [[0, 4, 1], [2, 4, 1], [8, 4, 7]]})


@pytest.fixture(scope="module")
def office() -> Plan:
    return plan_team(load_scene("office-20")).plan


def test_rings_of_robots_that_graze_each_other_arrive() -> None:
    plan = ring(0.1)
    assert simulate(plan).makespan < 5.0
    met = Disturbances(speed_error=0.2, stops=0.3)
    found = study(plan, range(20), disturbances=met)
    assert found.complete == 20


@settings(max_examples=40, deadline=None)
@given(st.integers(0, 2**32))
def test_coordination_gives_up_a_twentieth_of_the_gap_and_no_more(seed: int) -> None:
    plan, rng = ring(0.1), np.random.default_rng(seed)
    progress, done = np.zeros(4), np.ones(4)
    rules = waits_of(plan)
    least = math.inf
    for _ in range(400):
        bounds, _ = allowed(rules, progress)
        progress = np.minimum(np.minimum(progress + rng.uniform(0, 0.05, 4) * rng.integers(0, 2, 4), bounds), done)
        places = np.array([path.at(s) for path, s in zip(plan.trajectories, progress, strict=True)])
        apart = np.hypot(*(places[:, None] - places[None]).transpose(2, 0, 1)) + 9.0 * np.eye(4)
        least = min(least, float(apart.min()))
        if (progress >= 1.0).all():
            break
    assert (progress >= 1.0).all()
    assert least >= math.sqrt(0.5) - 0.05 * 0.1 - 1e-9


def test_room_for_a_margin_makes_up_for_what_coordination_gives_up() -> None:
    scene = Scene((0, 0, 4, 4), gap=0.1)
    for metres in (0.0, 0.05, 1.0):
        assert 0.95 * with_margin(scene, metres).gap - 2 * metres == pytest.approx(0.1)
    assert with_margin(Scene((0, 0, 4, 4)), 0.0).gap == 0.0


@pytest.mark.parametrize("met", [Disturbances(), Disturbances(stops=0.3), Disturbances(speed_error=0.5)])
def test_trucks_wait_for_nobody_who_stands_beside_its_place(office: Plan, met: Disturbances) -> None:
    for seed in range(3):
        run = simulate(office, "ackermann", seed, met)
        assert run.arrived, stopped(run)


@pytest.mark.parametrize("kind", ["differential", "unicycle"])
@pytest.mark.parametrize("noise", [0.005, 0.01, 0.02, 0.05])
def test_what_wheels_tell_makes_up_for_noise(kind: str, noise: float) -> None:
    calm = simulate(corner(), kind)
    for seed in range(5):
        run = simulate(corner(), kind, seed, Disturbances(position_noise=noise, heading_noise=noise))
        assert run.arrived
        assert run.greatest_stray[0] < 0.03 + 1.5 * noise
        assert run.makespan < calm.makespan + 1.0
        assert run.turned[0] < 3 * math.pi


def test_the_filter_knows_its_place_better_than_a_measurement() -> None:
    plan = plan_of(Scene((0, 0, 42, 2), robots=[Robot("A", (1, 1), (41, 1), 0.2)]), {"A": [[0, 1, 1], [40, 41, 1]]})
    setting, _ = prepared(plan, "differential", True, 0.02, 0.05)
    driven = drive(setting, Disturbances(position_noise=0.05), 3, 20.0, 0)
    # the fixed point of P = (P + Q) σ² / (P + Q + σ²), with Q = ρ² v² dt / 2
    grown = 0.05**2 * driven.now.state[0, 3] ** 2 * 0.02 * 0.5
    steady = (-grown + math.sqrt(grown * grown + 4 * grown * 0.05**2)) / 2
    assert driven.now.unsure[0, 0] == pytest.approx(steady, rel=0.05)
    wrong = [
        float(np.hypot(*(now.now.seen[0, :2] - now.now.state[0, :2])))
        for now in (drive(setting, Disturbances(position_noise=0.05), seed, 20.0, 0) for seed in range(40))
    ]
    assert math.sqrt(np.mean(np.square(wrong)) / 2) == pytest.approx(math.sqrt(steady), rel=0.4)


def test_noise_of_nothing_changes_nothing() -> None:
    calm, blurred = simulate(corner()), simulate(corner(), disturbances=Disturbances(position_noise=1e-9))
    assert np.allclose(calm.arrivals, blurred.arrivals, atol=0.02 + 1e-9)
    assert np.allclose(calm.distance, blurred.distance, atol=1e-3)


@pytest.mark.parametrize("rate", [0.2, 0.15, 0.1, 0.05])
def test_who_turns_for_long_is_not_lost(rate: float) -> None:
    run = simulate(corner(), Unicycle(1.25, rate, 2.0, 4.0))
    assert run.arrived, stopped(run)


def test_who_stops_for_long_is_not_lost() -> None:
    run = simulate(corner(), seed=1, disturbances=Disturbances(stops=0.3, stop_seconds=15.0))
    assert run.arrived, stopped(run)


def test_a_run_that_comes_to_nothing_ends_soon_and_one_that_creeps_says_that_it_was_slow() -> None:
    waiting = simulate(crossing(), disturbances=Disturbances(dies={"A": 2.0}))
    assert waiting.seconds < 30.0
    slow = simulate(crossing(), disturbances=Disturbances(slow={"A": 0.01}))
    assert "was too slow" in stopped(slow)["A"]
    assert slow.seconds == pytest.approx(longest(crossing()), abs=0.05)


def driven_into(wheelbase: float) -> tuple[Run, float]:
    """A truck that cannot turn in time, and how deep its centre comes into the block."""
    block = Rectangle(12, 6, 6, 8, name="block")
    scene = Scene((0, 0, 30, 20), [block], [Robot("A", (2, 10), (28, 10), 0.1)])
    run = simulate(plan_team(scene).plan, Ackermann(wheelbase, 1.25), every=0.02)
    solid = shapely.box(12, 6, 18, 14)
    places = shapely.points(run.poses[:, 0, :2])
    deep = np.where(shapely.contains(solid, places), shapely.distance(solid.exterior, places), 0.0)
    return run, float(deep.max())


@pytest.mark.parametrize("wheelbase", [5.0, 20.0])
def test_a_collision_is_as_deep_as_it_gets_and_lasts_until_it_is_over(wheelbase: float) -> None:
    run, deep = driven_into(wheelbase)
    assert deep > 0.3
    assert [hit.other for hit in run.collisions] == ["block"]
    assert run.collisions[0].depth == pytest.approx(deep + 0.1, abs=0.02)
    assert run.clearances[0].distance == pytest.approx(-deep - 0.1, abs=0.02)


def test_two_obstacles_that_are_touched_in_turn_are_two_collisions() -> None:
    walls = [Rectangle(3, 0, 3, 1.6, name="below"), Rectangle(3, 2.4, 3, 1.6, name="above")]
    scene = Scene((0, 0, 8, 4), walls, [Robot("A", (1, 2), (7, 2), 0.4)])
    plan = plan_of(scene, {"A": [[0, 1, 2], [6, 7, 2]]})
    for seed in range(5):
        run = simulate(plan, seed=seed, disturbances=Disturbances(slip=0.3), every=0.02)
        x, y = run.poses[:, 0, 0], run.poses[:, 0, 1]
        deep = [0.4 - np.hypot(np.maximum(abs(x - 4.5) - 1.5, 0.0), away) for away in (y - 1.6, 2.4 - y)]
        for name, depths in zip(("below", "above"), deep, strict=True):
            hits = [hit for hit in run.collisions if hit.other == name]
            assert max((hit.depth for hit in hits), default=0.0) == pytest.approx(max(depths.max(), 0.0), abs=2e-3)
        touched = (np.maximum(*deep) > scene.tol).astype(int)
        episodes = int((np.diff(touched) == 1).sum())
        assert 1 <= len(run.collisions) <= 2 * episodes


places = st.floats(-1, 9, width=32)


@settings(max_examples=200, deadline=None)
@given(places, places)
def test_how_deep_a_point_lies_inside_is_what_shapely_says(x: float, y: float) -> None:
    solid: list[Obstacle] = [
        Polygon([(1, 1), (4, 1), (4, 4), (2.5, 2), (1, 4)], name="arrow"),
        Rectangle(3, 2, 4, 3, 0.5),
        Circle((6, 6), 1.5),
        Line([(1, 6), (3, 7)], 0.4),
    ]
    scene = Scene((0, 0, 8, 8), solid)
    ground, names = ground_of(scene)
    deep, shape = deepest_inside(x, y, ground.edges, ground.rings, ground.solid, ground.reach)
    point = shapely.Point(x, y)
    rings = [(o.core, o.own_radius) for o in scene.obstacles if o.closed]
    depths = [-g.exterior.distance(point) - r for core, r in rings if (g := shapely.Polygon(core)).contains(point)]
    hall = shapely.box(0, 0, 8, 8)
    if not hall.covers(point):
        depths.append(-hall.exterior.distance(point))
    if not depths:
        on_side = min(shapely.LinearRing(core).distance(point) for core, _ in rings)
        assert shape == -1 or on_side < 1e-9 or hall.exterior.distance(point) < 1e-9
    else:
        assert deep == pytest.approx(min(depths), abs=1e-9)
        assert names[shape]


def test_the_dead_are_obstacles_that_nobody_moves() -> None:
    plan = plan_team(load_scene("corridor-swap")).plan
    run = simulate(plan, disturbances=Disturbances(dies={"R2": 3.9}))
    assert dead(run) == ("R2",)
    assert run_data(run)["dead"] == ["R2"]
    scene = scene_from(run)
    assert "R2" not in [robot.name for robot in scene.robots]
    disc = scene.obstacles[-1]
    assert isinstance(disc, Circle)
    assert disc.name == "R2"
    assert disc.center == tuple(run.poses[-1, run.names.index("R2"), :2])


@pytest.mark.parametrize(("gap", "clearance"), [(0.1, 0.0), (0.1, 0.25), (0.0, 0.0), (0.05, 0.65)])
def test_others_keep_the_gap_from_the_dead_and_need_no_more(gap: float, clearance: float) -> None:
    run = simulate(crossing(gap, clearance), disturbances=Disturbances(dies={"A": 3.5}))
    scene = scene_from(run)
    disc, other = scene.obstacles[-1], scene.robots[0]
    assert isinstance(disc, Circle)
    kept = disc.radius + scene.growth(other)
    if clearance < 0.3 + gap:
        assert kept == pytest.approx(0.6 + gap, abs=0.02)
    assert math.dist(other.start, disc.center) > kept - 1e-9
    assert plan_team(scene).certificate.ok


@settings(max_examples=12, deadline=None)
@given(st.floats(0, 6.3), st.floats(0.01, 0.3), st.sampled_from([0.0, 0.01, 0.2]), st.floats(0.1, 0.4))
def test_who_stands_legally_beside_the_dead_can_go_on(
    angle: float, clearance: float, gap: float, radius: float
) -> None:
    robots = [Robot("A", (5, 5), (5, 5), 0.3), Robot("B", (1, 1), (9, 9), radius, clearance=clearance)]
    scene = Scene((0, 0, 10, 10), robots=robots, gap=gap)
    far = plan_of(scene, {"A": [[0, 5, 5]], "B": [[0, 1, 1], [0.5, 1, 1], [8.8, 1, 9], [17, 9, 9]]})
    run = simulate(far, disturbances=Disturbances(dies={"A": 0.0}), every=1.0)
    assert dead(run) == ("A",)
    away = 0.3 + radius + gap
    beside = run.poses.copy()
    beside[-1, 1, :2] = 5 + away * math.cos(angle), 5 + away * math.sin(angle)
    on = scene_from(replace(run, poses=beside))
    assert plan_team(on, rounds=1).certificate.ok
    assert on.robots[0].clearance == pytest.approx(clearance, abs=0.01)


def test_a_dead_robot_named_as_an_obstacle_gets_another_name() -> None:
    plan = crossing()
    scene = replace(plan.scene, obstacles=(Circle((1, 7), 0.2, name="A"),))
    run = simulate(replace(plan, scene=scene), disturbances=Disturbances(dies={"A": 2.0}))
    assert [o.name for o in scene_from(run).obstacles] == ["A", "A, dead"]


def test_a_step_may_be_a_whole_number_of_anything_that_is_one() -> None:
    quick = Plan(crossing().scene, crossing().trajectories)
    assert simulate(quick, dt=np.float32(0.25)).dt == 0.25  # type: ignore[arg-type]
    assert study(quick, [0], dt=0.25).dt == 0.25
    assert simulate(quick, every=1e300).arrived


def test_wheels_take_vehicles_where_they_roll_to_a_billionth_of_the_way() -> None:
    rng, (nodes, weights) = np.random.default_rng(2), np.polynomial.legendre.leggauss(40)
    for _ in range(300):
        vehicle = DifferentialDrive(0.1, rng.uniform(0.1, 0.6), rng.uniform(5, 30), rng.choice([0.5, 3.0, 50.0]))
        kinds, params = tables([vehicle])
        state = np.zeros((1, 6))
        state[0, :3] = rng.normal(size=3)
        state[0, 3:5] = rng.uniform(-0.4, 0.4, 2) * params[0, :2]
        command, dt = rng.uniform(-0.4, 0.4, (1, 2)) * params[0, :2], float(rng.choice([0.02, 0.1, 0.25]))
        half = vehicle.track / 2
        old = state[0, 3] + np.array([-half, half]) * state[0, 4]
        new = command[0, 0] + np.array([-half, half]) * command[0, 1]
        needed = np.abs(new - old) / vehicle.acceleration
        knees = sorted({0.0, dt, *np.minimum(needed, dt).tolist()})
        x, y, heading, way = float(state[0, 0]), float(state[0, 1]), float(state[0, 2]), 0.0
        for a, b in pairwise(knees):
            w0, w1 = (old + (new - old) * np.minimum(t / np.maximum(needed, 1e-300), 1.0) for t in (a, b))
            for k in range(20):
                t = (k + 0.5 + nodes / 2) / 20
                rates = w0[:, None] + (w1 - w0)[:, None] * t
                speed, turned = rates.mean(axis=0), (w1 - w0) @ [-1, 1] / 2 * t**2 + w0 @ [-1, 1] * t
                angle = heading + turned * (b - a) / vehicle.track
                x += float((weights * speed * np.cos(angle)).sum()) * (b - a) / 40
                y += float((weights * speed * np.sin(angle)).sum()) * (b - a) / 40
                way += float((weights * np.abs(rates)).sum()) * (b - a) / 40
            heading += float((w0 + w1) @ [-1, 1]) / 2 * (b - a) / vehicle.track
        move(0, kinds, params, state, command, np.ones((1, 2)), dt)
        assert math.hypot(state[0, 0] - x, state[0, 1] - y) <= 1e-9 * way + 1e-15


def test_a_study_knows_of_what_it_is(tmp_path: Path) -> None:
    path = tmp_path / "study.json"
    save_study(study(crossing(), range(3)), path)
    assert json.loads(path.read_text())["robots"] == ["A", "B"]
    assert study_doubts(path, crossing().scene) == ()
    other = replace(crossing().scene, name="elsewhere", obstacles=(Circle((1, 1), 0.1),), robots=())
    told = study_doubts(path, other)
    assert len(told) == 3
    assert "'crossing'" in told[0]
    assert load_margin(path).runs == 3


def test_an_interrupted_study_keeps_the_first_runs_that_were_made() -> None:
    def stop(done: int) -> None:
        if done == 100:
            raise KeyboardInterrupt

    met = Disturbances(speed_error=0.2, stops=0.2)
    with pytest.raises(StudyInterrupted) as told:
        study(crossing(), range(1000), disturbances=met, tell=stop)
    made = told.value.study.trials
    assert 1 <= len(made) <= 101 + (os.cpu_count() or 1)
    assert made == study(crossing(), range(len(made)), disturbances=met).trials
    with pytest.raises(KeyboardInterrupt) as nothing:
        study(crossing(), range(3), tell=lambda done: (_ for _ in ()).throw(KeyboardInterrupt) if done else None)
    assert nothing.type in (KeyboardInterrupt, StudyInterrupted)


def test_an_interrupt_ends_the_runs_of_all_threads(monkeypatch: pytest.MonkeyPatch) -> None:
    ended: list[int] = []

    def watched(setting: Setting, met: Disturbances, seed: int, *given: Any, **more: Any) -> Driven:
        driven = drive(setting, met, seed, *given, **more)
        ended.append(seed)
        return driven

    monkeypatch.setattr("taut.simulation.studies.drive", watched)
    timer = threading.Timer(1.0, signal.raise_signal, [signal.SIGINT])
    timer.start()
    with pytest.raises(KeyboardInterrupt):
        study(crossing(), range(4), dt=1e-6)
    timer.join()
    assert not ended


def test_a_run_is_given_up_long_before_its_end() -> None:
    setting, _ = prepared(crossing(), "differential", True, 1e-6)
    given_up = threading.Event()
    threading.Timer(0.5, given_up.set).start()
    with pytest.raises(KeyboardInterrupt):
        drive(setting, Disturbances(), 0, longest(crossing()), 0, given_up=given_up)


def test_shapes_keep_their_order_for_the_loop() -> None:
    scene = Scene((0, 0, 8, 8), [Circle((2, 2), 0.5), Rectangle(4, 4, 2, 1)])
    ground, names = ground_of(scene)
    assert names == shapes_of(scene).names
    assert ground.solid.tolist() == [0, 1, -1]
