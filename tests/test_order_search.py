"""Order search: priorities that make all robots get through, or the word that none do."""

from __future__ import annotations

import math
import time
from itertools import combinations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from taut.certificate import certify
from taut.formats import load_scene
from taut.generate import random_scene
from taut.motion import Plan
from taut.scene import Robot, Scene
from taut.team import _order_kernels
from taut.team.reservations import legs_of
from taut.team.safe_intervals import Failure, bench_of, plan_robot, take
from taut.team.search import searched
from taut.team.world import World


@settings(max_examples=25, deadline=None)
@given(robots=st.integers(2, 14), seed=st.integers(0, 10_000), leave=st.booleans(), headway=st.sampled_from([0.0, 0.4]))
def test_what_it_finds_is_a_plan(robots: int, seed: int, leave: bool, headway: float) -> None:
    scene = random_scene(robots, 5, seed, size=12, headway=headway, at_goal="leave" if leave else "stay")
    found = searched(World(scene), seed)
    if found.trajectories is None:
        assert found.stuck
        return
    assert certify(Plan(scene, found.trajectories)).ok
    assert sorted(found.order) == list(range(robots))


@pytest.mark.parametrize("name", ["crossing-30", "hospital-12", "warehouse-50", "office-20"])
def test_ready_scenes_are_solved(name: str) -> None:
    scene = load_scene(name)
    found = searched(World(scene))
    assert found.trajectories is not None
    assert certify(Plan(scene, found.trajectories)).ok


def test_robots_planned_again_in_the_order_found_get_through() -> None:
    world = World(random_scene(25, 4, 3, size=11))
    found = searched(world)
    bench = bench_of(world)
    for i in found.order:
        motion = plan_robot(bench, i)
        assert not isinstance(motion, Failure)
        take(bench, i, motion)


def test_the_same_seed_and_nodes_give_the_same_plan() -> None:
    world = World(random_scene(40, 4, 1, size=13))
    first, again = (searched(world, 5) for _ in range(2))
    assert first.nodes == again.nodes
    assert first.trajectories is not None
    assert again.trajectories is not None
    pairs = zip(first.trajectories, again.trajectories, strict=True)
    assert all(np.array_equal(a.stamps, b.stamps) for a, b in pairs)


def test_where_no_order_helps_it_ends_and_names_who_meets() -> None:
    face_to_face = [Robot("A", (1, 0.5), (9, 0.5), 0.4), Robot("B", (9, 0.5), (1, 0.5), 0.4)]
    found = searched(World(Scene((0, 0, 10, 1), robots=face_to_face)))
    assert found.trajectories is None
    assert [(m.first, m.second) for m in found.stuck] == [(0, 1)]
    assert found.stuck[0].time == pytest.approx(0.0, abs=9.0)


def test_nodes_and_seconds_are_limits() -> None:
    world = World(random_scene(40, 4, 1, size=13))
    assert searched(world, nodes=3).nodes <= 4
    assert searched(world, until=time.monotonic()).nodes == 1


def test_meeting_times_see_what_dense_sampling_sees() -> None:
    scene = random_scene(12, 0, 4, size=7, radius=0.4)
    world = World(scene)
    bench = bench_of(world)
    alone = []
    for i in range(12):
        motion = plan_robot(bench, i)
        assert not isinstance(motion, Failure)
        alone.append(motion)
    for i, motion in enumerate(alone):
        take(bench, i, motion)
    late = max(motion.arrival for motion in alone) + 1
    times = np.linspace(0, late, 20_001)
    places = [motion.at(times) for motion in alone]
    met = 0
    for i, j in combinations(range(12), 2):
        near = np.hypot(*(places[i] - places[j]).T) < scene.separation(scene.robots[i], scene.robots[j]) - 1e-6
        radius, gap, headway = world.body(i).tolist()
        found = _order_kernels.meeting_times(
            bench.table, i, legs_of(alone[i], True), radius + gap - scene.tol / 8, headway, 12
        )
        if near.any():
            assert found[j] <= times[near][0]
            met += 1
        elif math.isfinite(found[j]):
            apart = np.hypot(*(places[i] - places[j]).T).min()
            assert apart < scene.separation(scene.robots[i], scene.robots[j]) + 2 * late / 20_000
    assert met > 3


def test_an_order_is_returned_as_soon_as_it_is_found(monkeypatch: pytest.MonkeyPatch) -> None:
    """Also when the tree is to be begun anew just then."""
    scenes = [random_scene(12, 2, seed, size=9) for seed in range(6)]
    for scene in scenes:
        found = searched(World(scene))
        assert found.trajectories is not None
        with monkeypatch.context() as patched:
            # as many nodes as the first tree needs: patience ends on the node that solves it
            patched.setattr("taut.team.search._PATIENCE", (found.nodes - 1 - 64) / 12)
            again = searched(World(scene))
        assert again.trajectories is not None
        assert again.nodes == found.nodes
