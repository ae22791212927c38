"""Teams that steer themselves: vehicles under a control law do what the law promises, as far as they can."""

from __future__ import annotations

import math
from itertools import combinations

import numpy as np
import pytest
import shapely
from hypothesis import given, settings
from hypothesis import strategies as st

from taut.control import Field, consensus, formation, integrate, leader_follower, rendezvous
from taut.errors import SceneError
from taut.graph import Graph, contact_graph
from taut.scene import Circle, FloatArray, Robot, Scene
from taut.simulation import (
    KINDS,
    Ackermann,
    DifferentialDrive,
    Disturbances,
    Integrator,
    Steered,
    Unicycle,
    fiedler_values,
    formation_error,
    steer,
)

BOUNDLESS = Integrator(1e6)
STARTS = [(1.0, 1.0), (7.0, 2.0), (6.0, 7.0), (2.0, 5.0)]


def complete(n: int) -> Graph:
    return Graph.from_edges(n, list(combinations(range(n), 2)))


def line(n: int) -> Graph:
    return Graph.from_edges(n, [(i, i + 1) for i in range(n - 1)])


def ring(n: int, radius: float = 2.0) -> FloatArray:
    turns = 2 * np.pi * np.arange(n) / n
    return radius * np.column_stack([np.cos(turns), np.sin(turns)])


def scene_of(starts: object, radius: float = 0.0, **more: object) -> Scene:
    places = np.asarray(starts, dtype=float).reshape(-1, 2).tolist()
    robots = [Robot(f"R{i + 1}", (x, y), (x, y), radius=radius) for i, (x, y) in enumerate(places)]
    return Scene((0, 0, 10, 10), robots=robots, gap=0.1, **more)  # type: ignore[arg-type]


def scattered(seed: int, n: int) -> FloatArray:
    return np.random.default_rng(seed).uniform(1.0, 9.0, (n, 2))


def ends(run: Steered) -> FloatArray:
    return run.poses[-1, :, :2]


# --- integrators do what the law says


def test_consensus_on_the_complete_graph_decays_as_in_closed_form() -> None:
    starts = np.array(STARTS)
    middle = starts.mean(axis=0)
    errors = []
    for dt in (0.01, 0.005):
        run = steer(scene_of(starts), consensus(complete(4)), BOUNDLESS, dt=dt, every=0.05, seconds=1.0, settled=0.0)
        assert np.allclose(run.clock, run.times)  # nobody had to be slowed
        expected = middle + (starts - middle) * np.exp(-4 * run.times)[:, None, None]
        errors.append(float(np.abs(run.poses[:, :, :2] - expected).max()))
    assert errors[0] < 0.1
    assert errors[1] == pytest.approx(errors[0] / 2, rel=0.1)  # of first order: commands are held for a step


@pytest.mark.parametrize("speed_limit", [1e6, 0.7])
def test_a_slowed_team_is_where_the_law_has_it_at_the_time_of_its_clock(speed_limit: float) -> None:
    starts = scattered(3, 5)
    law = formation(Graph.from_edges(5, [(0, 1), (1, 2), (2, 3), (3, 4), (4, 0), (0, 2)]), ring(5))
    run = steer(scene_of(starts), law, Integrator(speed_limit), dt=0.002, seconds=30.0)
    assert (run.clock[-1] < 0.9 * run.seconds) == (speed_limit < 1)
    paths = integrate(law, starts, float(run.clock[-1]), error=1e-5)
    expected = np.array([path.at(time) for path in paths for time in run.clock]).reshape(5, -1, 2)
    assert np.abs(run.poses[:, :, :2] - np.moveaxis(expected, 0, 1)).max() < 0.02


@given(st.integers(0, 10**6), st.integers(2, 7))
@settings(max_examples=15, deadline=None)
def test_the_centroid_of_integrators_rests_though_some_are_too_slow(seed: int, n: int) -> None:
    starts = scattered(seed, n)
    quick = {f"R{i + 1}": Integrator(0.2 + 0.3 * i) for i in range(n)}
    run = steer(scene_of(starts), consensus(line(n)), quick, seconds=20.0)
    assert np.allclose(run.poses[:, :, :2].mean(axis=1), starts.mean(axis=0), atol=1e-9)


def test_nobody_is_driven_faster_than_the_scene_has_it() -> None:
    robots = [Robot("A", (1, 1), (1, 1), speed=0.5), Robot("B", (9, 9), (9, 9), speed=2.0)]
    for kind in KINDS:
        run = steer(Scene((0, 0, 10, 10), robots=robots, gap=0.1), consensus(complete(2)), kind, every=0.02)
        speeds = np.hypot(*np.moveaxis(np.diff(run.poses[:, :, :2], axis=0), 2, 0)) / np.diff(run.times)[:, None]
        assert (speeds.max(axis=0) <= [0.5 + 1e-9, 2.0 + 1e-9]).all()


def test_a_team_of_many_neighbours_does_not_swing_about_its_end() -> None:
    starts = scattered(0, 60)
    run = steer(scene_of(starts), consensus(complete(60)), "integrator", settled=0.001)
    away = np.hypot(*np.moveaxis(run.poses[:, :, :2] - starts.mean(axis=0), 2, 0)).max(axis=1)
    assert run.settled
    assert (np.diff(away) < 0.01).all()


# --- every kind of vehicle


@pytest.mark.parametrize("kind", ["integrator", "unicycle", "differential"])
@given(seed=st.integers(0, 10**6), n=st.integers(2, 6))
@settings(max_examples=12, deadline=None)
def test_vehicles_that_turn_on_the_spot_take_the_formation(kind: str, seed: int, n: int) -> None:
    run = steer(scene_of(scattered(seed, n), 0.2), formation(complete(n), ring(n)), kind)
    assert run.settled
    assert formation_error(ends(run), ring(n)) < 0.01


@given(seed=st.integers(0, 10**6), n=st.integers(2, 6))
@settings(max_examples=12, deadline=None)
def test_trucks_shunt_into_the_formation(seed: int, n: int) -> None:
    run = steer(scene_of(scattered(seed, n), 0.2), formation(complete(n), ring(n)), "ackermann", seconds=300.0)
    assert run.settled
    assert formation_error(ends(run), ring(n)) < 0.05


@pytest.mark.parametrize("bearing", [0.0, 1.0, math.pi / 2, 2.5, math.pi])
@pytest.mark.parametrize("distance", [0.1, 0.5, 5.0])
def test_a_truck_gets_to_a_place_at_any_bearing_also_within_its_turning_circle(distance: float, bearing: float) -> None:
    truck = Ackermann(0.3, 1.0, 0.7, 2.0, 3.0)
    target = np.array([5 + distance * math.cos(bearing), 5 + distance * math.sin(bearing)])

    def law(time: float, positions: FloatArray) -> FloatArray:
        east = [[0.05, 0.0]]  # faces east at first: that is how it begins
        return np.array(east) if time == 0 else target - positions

    run = steer(scene_of([(5, 5)]), law, truck)
    assert run.settled
    assert np.hypot(*(ends(run)[0] - target)) < 0.06
    radius = truck.turning_radius
    chord = np.hypot(*np.diff(run.poses[:, 0, :2], axis=0).T)
    assert (np.abs(np.diff(run.poses[:, 0, 2])) <= (chord + 0.03) / radius).all()  # never turned on the spot


@pytest.mark.parametrize("vehicle", [Unicycle(1.0, 3.0), DifferentialDrive(0.05, 0.2, 20.0)])
@given(seed=st.integers(0, 10**6))
@settings(max_examples=8, deadline=None)
def test_what_falls_along_the_law_falls_along_vehicles_with_headings(
    vehicle: Unicycle | DifferentialDrive, seed: int
) -> None:
    starts = scattered(seed, 5)
    graph = Graph.from_edges(5, [(0, 1), (1, 2), (2, 3), (3, 4), (4, 0)])
    run = steer(scene_of(starts), consensus(graph), vehicle, dt=0.005, seconds=10.0)
    i, j = graph.edges.T
    energy = ((run.poses[:, i, :2] - run.poses[:, j, :2]) ** 2).sum(axis=(1, 2))
    assert (np.diff(energy) <= 1e-9 * energy[0]).all()


def test_vehicles_may_be_mixed() -> None:
    kinds = dict(zip(("R1", "R2", "R3", "R4"), KINDS, strict=True))
    run = steer(scene_of(STARTS, 0.2), formation(line(4), ring(4)), kinds, seconds=120.0)
    assert run.settled
    assert formation_error(ends(run), ring(4)) < 0.2


# --- what laws promise


@given(seed=st.integers(0, 10**6), n=st.integers(2, 8))
@settings(max_examples=12, deadline=None)
def test_rendezvous_of_integrators_loses_no_link(seed: int, n: int) -> None:
    starts = scattered(seed, n)
    graph = contact_graph(starts, 4.0)
    i, j = graph.edges.T
    lengths = np.hypot(*(starts[i] - starts[j]).T)
    if (lengths > 3.9).any():
        return  # so near the reach that a step may cross it
    run = steer(scene_of(starts), rendezvous(graph, 4.0), "integrator", seconds=40.0)
    apart = np.hypot(*np.moveaxis(run.poses[:, i, :2] - run.poses[:, j, :2], 2, 0))
    assert (apart < 4.0).all()
    assert run.settled


def test_rendezvous_keeps_links_that_consensus_loses() -> None:
    # two crowds that pull the bridge between them apart
    starts = [(0.5, 4.5), (0.5, 5.5), (0.5, 5.0), (3.4, 5.0), (6.3, 5.0), (9.2, 5.0), (9.2, 4.5), (9.2, 5.5)]
    graph = contact_graph(starts, 3.0)
    bare = steer(scene_of(starts), consensus(lambda places: contact_graph(places, 3.0)), "integrator")
    kept = steer(scene_of(starts), rendezvous(graph, 3.0), "integrator")
    assert fiedler_values(bare, lambda places: contact_graph(places, 3.0))[-1] == 0
    assert (fiedler_values(kept, lambda places: contact_graph(places, 3.0)) > 0).all()


@pytest.mark.parametrize("kind", KINDS)
def test_followers_end_among_leaders_that_stand(kind: str) -> None:
    starts = [(2, 2), (8, 2), (5, 8), (1, 9), (9, 9), (9, 5)]
    law = leader_follower(complete(6), {k: lambda time: (0.0, 0.0) for k in range(3)})
    run = steer(scene_of(starts), law, kind, seconds=120.0)
    hull = shapely.MultiPoint(starts[:3]).convex_hull.buffer(0.02)
    assert run.settled
    assert np.array_equal(ends(run)[:3], np.array(starts[:3], dtype=float))
    assert shapely.covers(hull, shapely.points(ends(run)[3:])).all()


# --- what goes wrong


@pytest.mark.parametrize("kind", KINDS)
def test_who_is_dead_stands_and_the_others_gather_at_it(kind: str) -> None:
    met = Disturbances(dies={"R3": 1.0})
    run = steer(scene_of(STARTS), consensus(complete(4)), kind, disturbances=met, seconds=240.0)
    late = run.times > 3.0
    assert np.ptp(run.poses[late, 2, :2], axis=0).max() == 0
    assert run.settled
    assert np.hypot(*(ends(run) - ends(run)[2]).T).max() < 0.06


@given(seed=st.integers(0, 10**6))
@settings(max_examples=8, deadline=None)
def test_disturbed_vehicles_take_the_formation(seed: int) -> None:
    met = Disturbances(speed_error=0.2, stops=0.1, slip=0.05, heading_noise=0.01, slow={"R2": 0.5})
    run = steer(scene_of(STARTS, 0.2), formation(line(4), ring(4)), "differential", seed, met, seconds=120.0)
    assert run.settled
    assert formation_error(ends(run), ring(4)) < 0.05


def test_the_same_seed_is_the_same_run_and_another_is_another() -> None:
    met = Disturbances(speed_error=0.2, stops=0.3, position_noise=0.01, heading_noise=0.02, slip=0.1)
    law = formation(complete(4), ring(4))
    first, again, other = (
        steer(scene_of(STARTS, 0.2), law, seed=seed, disturbances=met, seconds=10.0) for seed in (5, 5, 6)
    )
    assert first.poses.tobytes() == again.poses.tobytes()
    assert first.collisions == again.collisions
    assert first.poses.shape != other.poses.shape or not np.array_equal(first.poses, other.poses)


def test_collisions_are_noted_with_robots_and_with_obstacles() -> None:
    scene = scene_of([(2, 5), (8, 5)], 0.25, obstacles=[Circle((3.5, 5), 0.5, name="pillar")])
    run = steer(scene, consensus(complete(2)), Integrator(1.0), dt=0.01)
    against, met = (next(c for c in run.collisions if c.other == other) for other in ("pillar", "R2"))
    assert against.robot == "R1"
    assert against.time == pytest.approx(0.75, abs=0.02)  # 0.75 m at 1 m/s to touch the pillar
    # discs that touch are 0.5 m apart; from 2.5 m to each side they come at 1 m/s until the law is slower
    assert met.place == pytest.approx((5.0, 5.0), abs=0.01)
    apart = np.hypot(*(run.poses[:, 0, :2] - run.poses[:, 1, :2]).T)
    assert met.time == pytest.approx(float(np.interp(-0.5, -apart, run.times)), abs=0.02)
    assert run.separations[0].distance == pytest.approx(float(apart.min()) - 0.5, abs=1e-6)


def test_robots_for_which_the_law_has_no_velocity_stand() -> None:
    starts = [(1, 1), (9, 1), (2, 1)]
    run = steer(scene_of(starts), rendezvous(Graph.from_edges(3, [(0, 1), (0, 2)]), 5.0), seconds=3.0)
    assert np.isnan(run.velocities[:, :2]).all()
    assert np.array_equal(ends(run)[:2], np.array(starts[:2], dtype=float))
    assert not run.settled


# --- values and bad input


def test_a_run_lasts_as_long_as_asked_or_until_it_has_been_settled_for_a_second() -> None:
    law = consensus(complete(4))
    settled = steer(scene_of(STARTS), law)
    assert settled.seconds == pytest.approx(settled.settled_at + 1.0, abs=0.11)
    whole = steer(scene_of(STARTS), law, seconds=7.0, settled=0.0)
    assert whole.seconds == pytest.approx(7.0)
    assert not whole.settled
    short = steer(scene_of(STARTS), law, seconds=0.0)
    assert np.array_equal(short.poses[:, :, :2], [STARTS])


@pytest.mark.parametrize("n", [0, 1])
def test_small_teams_have_nothing_to_do(n: int) -> None:
    run = steer(scene_of(STARTS[:n]), consensus(complete(n)))
    assert run.settled_at == 0
    assert run.plan.scene.robots == run.scene.robots
    assert (fiedler_values(run, complete(n)) == 0).all()
    assert formation_error(ends(run), np.zeros((n, 2))) == 0


def test_the_driven_motions_are_a_plan_to_be_drawn() -> None:
    run = steer(scene_of(STARTS), consensus(complete(4)))
    for k, path in enumerate(run.plan.trajectories):
        assert np.array_equal(path.points, run.poses[:, k, :2])
        assert run.plan.scene.robots[k].goal == tuple(ends(run)[k])


def test_a_formation_is_judged_wherever_it_stands() -> None:
    shape = ring(5)
    assert formation_error(shape + np.array([100.0, -3.0]), shape) == pytest.approx(0, abs=1e-12)
    moved = shape + np.array([100.0, -3.0])
    moved[2, 0] += 0.5
    assert formation_error(moved, shape) == pytest.approx(0.4)  # a fifth of it moves the centroid


@pytest.mark.parametrize(
    ("words", "more"),
    [
        ("step", {"dt": 0.0}),
        ("step", {"dt": math.nan}),
        ("recorded", {"every": -1.0}),
        ("longest", {"seconds": math.inf}),
        ("settled", {"settled": 1.5}),
        ("seed", {"seed": -1}),
        ("vehicle", {"vehicle": "hovercraft"}),
        ("R9", {"vehicle": {"R9": "unicycle"}}),
        ("R9", {"disturbances": Disturbances(dies={"R9": 1.0})}),
    ],
)
def test_numbers_and_names_that_make_no_sense_are_refused(words: str, more: dict[str, object]) -> None:
    with pytest.raises(SceneError, match=words):
        steer(scene_of(STARTS), consensus(complete(4)), **more)  # type: ignore[arg-type]


def test_a_law_for_another_team_is_refused() -> None:
    def crooked(time: float, positions: FloatArray) -> FloatArray:
        return np.zeros(3)

    laws: list[Field] = [crooked, consensus(complete(3))]
    for law in laws:
        with pytest.raises(ValueError, match=r"\(4, 2\)"):
            steer(scene_of(STARTS), law)
