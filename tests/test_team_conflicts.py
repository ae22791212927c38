"""What robots met when they were planned, checked against the motions themselves."""

from __future__ import annotations

import math

import numpy as np
import pytest

import taut
from taut.scene import Circle, Rectangle, Robot, Scene
from taut.team import Result
from taut.team.conflicts import Conflict
from taut.team.stages import SequenceStage


def met(result: Result) -> dict[str, tuple[Conflict, ...]]:
    stage = result.stages[-1]
    assert isinstance(stage, SequenceStage)
    return dict(stage.conflicts)


def planned(robots: list[Robot], obstacles: list[Rectangle] | None = None, **options: object) -> Result:
    scene = Scene((0, 0, 20, 10), obstacles or [], robots, **{"gap": 0.1, **options})  # type: ignore[arg-type]
    return taut.plan(scene, order="given")


def test_ways_that_cross_away_from_vertices_cross_in_the_open() -> None:
    result = planned(
        [Robot("A", (2, 5), (18, 5), radius=0.3), Robot("B", (10, 0.5), (10, 9.5), radius=0.3, start_time=3.5)]
    )
    (conflict,) = met(result)["B"]
    assert (conflict.other, conflict.kind) == ("A", "crossing in the open")
    assert math.dist(conflict.place, (10, 5)) < 0.8
    assert met(result)["A"] == ()


def test_ways_through_one_corner_meet_at_crossroads() -> None:
    wall = [Rectangle(8, 0, 1, 5)]
    robots = [Robot("A", (4, 1), (13, 1), radius=0.3), Robot("B", (5, 9), (12, 0.5), radius=0.3)]
    scene = Scene((0, 0, 20, 10), wall, robots, gap=0.1)
    shared = taut.plan(scene, order="given")
    kinds = {c.kind for c in met(shared)["B"]}
    assert kinds <= {"crossroads", "catching up", "crossing in the open", "standing"}


def test_robots_that_come_towards_each_other_meet_head_on() -> None:
    result = planned([Robot("A", (2, 5), (18, 5), radius=0.3), Robot("B", (18, 5.1), (2, 5.1), radius=0.3)])
    (conflict, *_) = met(result)["B"]
    assert (conflict.kind, conflict.resolution) == ("head-on", "another way")
    assert conflict.time == pytest.approx(8.0, abs=1e-9)


def test_a_faster_robot_catches_up_with_a_slower_one() -> None:
    robots = [Robot("A", (2, 5), (18, 5), radius=0.3, speed=0.5), Robot("B", (0.5, 5), (16, 5), radius=0.3, speed=2.0)]
    result = planned(robots, at_goal="leave")
    assert met(result)["B"][0].kind == "catching up"
    assert met(result)["B"][0].other == "A"


def test_a_robot_parked_on_the_way_is_standing() -> None:
    robots = [Robot("A", (8, 5), (10, 5), radius=0.3), Robot("B", (1, 5), (19, 5), radius=0.3)]
    conflicts = met(planned(robots))["B"]
    assert conflicts[0].kind == "standing"
    assert conflicts[0].resolution == "another way"
    assert math.dist(conflicts[0].place, (10, 5)) < 0.8


def test_whoever_passes_over_my_goal_later_is_told() -> None:
    robots = [Robot("A", (1, 5), (19, 5), radius=0.3, start_time=8.0), Robot("B", (10, 8), (10, 5), radius=0.3)]
    conflicts = met(planned(robots))["B"]
    assert [(c.kind, c.resolution) for c in conflicts] == [("passed over", "wait")]
    assert 0 < conflicts[0].delay < 2


def test_a_robot_at_its_goal_that_steps_aside_says_for_whom() -> None:
    robots = [Robot("A", (1, 5), (19, 5), radius=0.3), Robot("B", (10, 5), (10, 5), radius=0.3)]
    conflicts = met(planned(robots))["B"]
    assert [(c.other, c.kind) for c in conflicts] == [("A", "passed over")]


def test_a_start_still_held_is_told_apart() -> None:
    robots = [Robot("A", (1, 5), (19, 5), radius=0.3), Robot("B", (2.5, 5), (2.5, 9), radius=0.3)]
    conflicts = met(planned(robots))["A"]
    assert [(c.other, c.kind) for c in conflicts] == [("B", "held start")]


def test_with_a_headway_only_those_nearby_in_time_are_met() -> None:
    robots = [
        Robot("B", (-4, 5), (9.5, 5), radius=0.2, speed=0.5),
        Robot("C", (2, 8), (9, 8), radius=0.2, start_time=5),
        Robot("A", (5, 5), (5, 9.5), radius=0.2, start_time=5),
    ]
    result = taut.plan(Scene((-6, 0, 10, 10), [], robots, gap=0.05, headway=0.1), order="given")
    assert {c.other for c in met(result)["A"]} == {"C"}


def test_with_a_headway_one_encounter_is_told_once() -> None:
    robots = [Robot("A", (1, 2), (19, 2), radius=0.3), Robot("B", (2, 1.3), (19, 1), radius=0.3)]
    scene = Scene((0, 0, 20, 10), [Circle((10, 1), 3, "O")], robots, gap=0.05, headway=0.25)
    result = taut.plan(scene, order="given")
    (conflict,) = met(result)["B"]
    route = taut.shortest_path(taut.FreeSpace.of(scene, robots[1]), (2, 1.3), (19, 1))
    assert math.dist(_alone(route.points, robots[1], conflict.time), conflict.place) < 1e-6


def test_kind_time_and_place_are_of_one_instant() -> None:
    robots = [
        Robot("B", (6, 3), (6.5, 5.5), radius=0.3, speed=0.3, start_time=4.5),
        Robot("A", (1, 3), (11, 3), radius=0.3),
    ]
    result = taut.plan(Scene((0, 0, 12, 6), [], robots, gap=0.05))
    (conflict,) = met(result)["A"]
    assert conflict.time > 4.5
    assert conflict.kind == "crossing in the open"


@pytest.mark.parametrize("seed", range(12))
def test_every_conflict_told_would_have_happened(seed: int) -> None:
    scene = taut.random_scene(robots=14, obstacles=8, seed=seed, size=18.0)
    result = taut.plan(scene)
    conflicts = met(result)
    index = {robot.name: k for k, robot in enumerate(scene.robots)}
    order = next(s for s in result.stages if isinstance(s, SequenceStage)).order
    for name, those in conflicts.items():
        k = index[name]
        robot, trajectory = scene.robots[k], result.plan.trajectories[k]
        route = taut.shortest_path(taut.FreeSpace.of(scene, robot), robot.start, robot.goal)
        late = trajectory.arrival - (robot.start_time + route.length / robot.speed) > 1e-6
        assert bool(those) == late or (those and trajectory.length > route.length + 1e-9)
        for conflict in those:
            other = index[conflict.other]
            reach = robot.radius + scene.robots[other].radius + scene.gap
            assert math.dist(_alone(route.points, robot, conflict.time), conflict.place) < 1e-6
            there = np.array(scene.robots[other].start)
            if conflict.kind != "held start":
                assert order.index(conflict.other) < order.index(name)
                there = result.plan.trajectories[other].at(conflict.time)
            assert math.dist(there, conflict.place) < reach
            passes = trajectory.at(conflict.time + conflict.delay)
            if conflict.resolution == "wait":
                assert math.dist(passes, conflict.place) < 1e-6


def _alone(points: np.ndarray, robot: Robot, time: float) -> np.ndarray:
    """Where the robot would be at that time on its shortest way at top speed."""
    times = robot.start_time + np.append(0.0, np.cumsum(np.hypot(*np.diff(points, axis=0).T))) / robot.speed
    return np.array([np.interp(time, times, points[:, k]) for k in (0, 1)])
