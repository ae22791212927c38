"""The studio's timelines: the least room over time and the course of contact are those of certificate and contacts."""

from __future__ import annotations

import json
import math
from collections.abc import Callable
from dataclasses import replace
from itertools import combinations
from typing import Any

import numpy as np
import pytest
from hypothesis import assume, given, settings
from hypothesis import strategies as st

import taut
from strategies import trajectories
from taut.contact import components_at, contacts, losses
from taut.motion import Plan, Trajectory
from taut.scene import Robot, Scene
from taut.studio import timelines
from taut.studio.timelines import EVENLY, separation_of, timelines_of


@pytest.fixture(scope="module")
def plan_of() -> Callable[[str], Plan]:
    known: dict[str, Plan] = {}

    def get(name: str) -> Plan:
        if name not in known:
            known[name] = taut.plan(taut.load_scene(name)).plan
        return known[name]

    return get


def drawn(plan: Plan, *contact: Any) -> dict[str, Any]:
    """Return timelines as the page gets them."""
    return dict(json.loads(json.dumps(timelines_of(plan, *contact), allow_nan=False)))


def room_at(plan: Plan, time: float) -> float | None:
    """Return the least room between two robots that are there, one pair after another."""
    robots = plan.scene.robots
    there = [
        k
        for k, (robot, motion) in enumerate(zip(robots, plan.trajectories, strict=True))
        if plan.scene.stays(robot) or time < motion.arrival
    ]
    at = plan.at(time)
    rooms = [math.dist(at[i], at[j]) - robots[i].radius - robots[j].radius for i, j in combinations(there, 2)]
    return min(rooms, default=None)


@pytest.mark.parametrize("name", ["thesis-2", "hospital-12", "crossing-30"])
def test_the_exact_least_of_the_certificate_is_on_the_curve(plan_of: Callable[[str], Plan], name: str) -> None:
    plan = plan_of(name)
    found = drawn(plan)["separation"]
    proof = taut.certify(plan).separation
    assert proof is not None
    assert found["least"] == {"value": proof.value, "time": proof.time, "robots": list(proof.robots)}
    assert found["values"][found["times"].index(proof.time)] == proof.value
    assert min(value for value in found["values"] if value is not None) >= proof.value - plan.scene.tol
    assert EVENLY <= len(found["times"]) <= 2000
    assert found["times"] == sorted(set(found["times"]))


@settings(max_examples=40, deadline=None)
@given(st.lists(trajectories(max_legs=4), min_size=2, max_size=4), st.sampled_from(["stay", "leave"]), st.data())
def test_every_sample_is_the_room_between_the_nearest_two(
    drawn_paths: list[Trajectory], at_goal: Any, data: st.DataObject
) -> None:
    paths = [Trajectory(f"R{k}", path.stamps) for k, path in enumerate(drawn_paths)]
    robots = [
        Robot(p.name, tuple(p.points[0]), tuple(p.points[-1]), radius=data.draw(st.sampled_from([0.1, 0.5])))
        for p in paths
    ]
    plan = Plan(Scene((-11, -11, 11, 11), (), robots, at_goal=at_goal), tuple(paths))
    found = separation_of(plan)
    proof = taut.certify(plan).separation
    assume(proof is not None)
    assert proof is not None
    assert found["least"]["value"] == proof.value
    known = [value for value in found["values"] if value is not None]
    assert min(known) >= proof.value - 1e-9
    for k in range(0, len(found["times"]), 37):
        time, value = found["times"][k], found["values"][k]
        expected = room_at(plan, time)
        # at the very instant of the least, a robot may be leaving
        assert time == proof.time or (value is None) == (expected is None)
        assert value is None or expected is None or value == pytest.approx(expected, abs=1e-9)


def test_a_short_meeting_between_two_samples_is_not_missed() -> None:
    robots = [Robot("R1", (0, 0), (1000, 0), radius=0.1), Robot("R2", (500, 50), (500, -50), radius=0.1, speed=100)]
    scene = Scene((-1, -60, 1001, 60), (), robots)
    fast = Trajectory("R2", np.array([[0, 500, 50], [500.01, 500, 50], [501.01, 500, -50]]))
    plan = Plan(scene, (Trajectory("R1", np.array([[0, 0, 0], [1000, 1000, 0]])), fast))
    found = separation_of(plan)
    proof = taut.certify(plan).separation
    assert proof is not None
    assert min(found["values"]) == proof.value < 1


def test_with_headway_the_curve_is_that_of_one_instant(plan_of: Callable[[str], Plan]) -> None:
    plan = plan_of("thesis-2")
    later = Plan(replace(plan.scene, headway=0.5), plan.trajectories)
    assert separation_of(later) == separation_of(plan)


def test_where_fewer_than_two_robots_are_there_is_no_separation() -> None:
    one = Scene((0, 0, 9, 9), (), [Robot("R1", (1, 1), (8, 1), radius=0.1)])
    alone = taut.plan(one).plan
    assert drawn(alone) == {
        "until": alone.makespan,
        "separation": {"times": [], "values": [], "least": None},
        "contact": None,
        "links": [],
    }
    two = replace(one, robots=(*one.robots, Robot("R2", (1, 3), (4, 3), radius=0.1)), at_goal="leave")
    found = drawn(taut.plan(two).plan)["separation"]
    rooms = dict(zip(found["times"], found["values"], strict=True))
    assert rooms[3.0] is None
    assert all((value is None) == (time >= 3) for time, value in rooms.items())


@pytest.mark.parametrize(("name", "reach", "sight"), [("hospital-12", 9.0, True), ("crossing-30", 4.0, False)])
def test_contact_is_told_piece_by_piece(
    plan_of: Callable[[str], Plan], name: str, reach: float, sight: bool, monkeypatch: pytest.MonkeyPatch
) -> None:
    plan = plan_of(name)
    expected = contacts(plan, reach, sight)
    told = drawn(plan, reach, sight)
    assert told["contact"]["exact"]
    assert told["contact"]["times"] == expected.times.tolist()
    assert told["contact"]["lambda2"] == expected.fiedler.tolist()
    parts = [int(components_at(expected, piece).max()) + 1 for piece in range(len(expected.times))]
    assert told["contact"]["parts"] == parts
    ends = [link["end"] if link["end"] is not None else math.inf for link in told["links"]]
    assert ends == expected.ends.tolist()
    assert [link["begin"] for link in told["links"]] == expected.begins.tolist()
    assert [link["pair"] for link in told["links"]] == expected.pairs.tolist()

    monkeypatch.setattr(timelines, "FEWEST", 12)
    monkeypatch.setattr(timelines, "_CUBES", 0)
    some = drawn(plan, reach, sight)["contact"]
    assert not some["exact"]
    assert len(some["times"]) < len(told["contact"]["times"])
    full = dict(zip(expected.times.tolist(), zip(expected.fiedler.tolist(), parts, strict=True), strict=True))
    for time, value, count in zip(some["times"], some["lambda2"], some["parts"], strict=True):
        assert (value, count) == (pytest.approx(full[time][0]), full[time][1])
    changes = losses(expected).ravel()
    assert set(changes[np.isfinite(changes)].tolist()) <= set(some["times"])


def test_of_very_many_robots_lambda2_is_left_out(
    plan_of: Callable[[str], Plan], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(timelines, "MANY", 2)
    told = drawn(plan_of("thesis-2"), 8.0)["contact"]
    assert told["lambda2"] is None
    assert max(told["parts"]) >= 1
