"""A plan for a changed map: who is not concerned keeps his motion bit for bit, the plan certifies, the reasons hold."""

from __future__ import annotations

from dataclasses import replace
from itertools import pairwise
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from strategies import team_scenes
from taut import (
    Circle,
    Contact,
    NoPath,
    NoPlanExists,
    NoPlanFound,
    Plan,
    Rectangle,
    Replanned,
    Robot,
    Scene,
    SceneError,
    TautError,
    certify,
    load_scene,
    plan,
    replan,
    with_obstacle,
    without_obstacle,
)


def check(old: Plan, new: Replanned) -> None:
    assert new.certificate.ok
    assert certify(new.plan).ok
    before = {motion.name: motion for motion in old.trajectories}
    names = [robot.name for robot in new.plan.scene.robots]
    assert set(new.kept) | set(new.changed) == set(names)
    assert not set(new.kept) & set(new.changed)
    for motion in new.plan.trajectories:
        if motion.name in new.kept:
            assert motion == before[motion.name]


@pytest.mark.parametrize("name", ["thesis-1", "thesis-2", "thesis-3", "appendix-d", "office-20"])
def test_a_far_obstacle_changes_nothing(name: str) -> None:
    scene = load_scene(name)
    old = plan(scene).plan
    tracks = np.concatenate([motion.points for motion in old.trajectories])
    low, high = np.array(scene.workspace).min(axis=0), np.array(scene.workspace).max(axis=0)
    for x, y in np.random.default_rng(0).uniform(low, high, (400, 2)):
        crate = Circle((x, y), 0.01 * float((high - low).max()), name="crate")
        legs = [motion.points for motion in old.trajectories]
        near = min(np.hypot(*(np.linspace(a, b, 50) - (x, y)).T).min() for points in legs for a, b in pairwise(points))
        if near > 0.05 * float((high - low).max()):
            break
    assert len(tracks)
    new = with_obstacle(old, crate)
    check(old, new)
    assert new.changed == {}
    assert all(a == b for a, b in zip(old.trajectories, new.plan.trajectories, strict=True))


def test_an_obstacle_across_a_path_reroutes_that_robot_only() -> None:
    hall = Scene(
        (0, 0, 12, 12), robots=[Robot(f"R{k}", (1, 2 * k), (11, 2 * k), radius=0.3) for k in range(1, 6)], gap=0.1
    )
    old = plan(hall).plan
    new = with_obstacle(old, Rectangle(5.5, 5.8, 0.5, 0.5, name="crate"))
    check(old, new)
    assert list(new.changed) == ["R3"]
    assert new.changed["R3"].startswith("R3 comes ")
    assert "nearer to crate" in new.changed["R3"]
    assert new.plan.trajectories[2].length > old.trajectories[2].length


def test_a_gap_closed_by_touching_is_noticed() -> None:
    wall = [Rectangle(4, 0, 1, 3, name="A"), Rectangle(4, 4, 1, 4, name="B")]
    scene = Scene((0, 0, 10, 10), wall, [Robot("P", (1, 3.5), (9, 3.5)), Robot("Q", (1, 9), (9, 9))], gap=0.1)
    old = plan(scene).plan
    assert old.trajectories[0].length == pytest.approx(8.0)
    new = with_obstacle(old, Rectangle(4, 3, 1, 1, name="C"))
    check(old, new)
    assert list(new.changed) == ["P"]


def test_robots_in_the_way_are_planned_anew_too() -> None:
    """A corridor with one bay: once the way round is shut, the parked robot has to use the bay."""
    left = [Rectangle(0, 0, 10, 2, name="south"), Rectangle(0, 3, 4, 1, name="a"), Rectangle(5, 3, 5, 1, name="b")]
    robots = [Robot("sits", (6.5, 2.5), (6.5, 2.5), radius=0.4), Robot("goes", (1, 2.5), (9, 2.5), radius=0.4)]
    scene = Scene((0, 0, 10, 6), left, robots, gap=0.05)
    # before, the corridor is open at the top and the other robot goes round
    open_scene = replace(scene, obstacles=(left[0], left[1]))
    old = plan(open_scene).plan
    new = replan(old, scene)
    check(old, new)
    assert "goes" in new.changed


def test_new_and_changed_robots_are_named() -> None:
    scene = load_scene("thesis-2")
    old = plan(scene).plan
    first = replace(scene.robots[0], goal=(13.0, 12.0))
    robots = (first, *scene.robots[1:], Robot("R4", (15, 1), (15, 15)))
    new = replan(old, replace(scene, robots=robots))
    check(old, new)
    assert new.changed["R4"] == "R4 is new"
    assert new.changed["R1"] == "R1 is not what it was: goal"
    stays = replan(old, replace(scene, at_goal="stay"))
    assert ["at_goal" in why for why in stays.changed.values()] == [True] * 3


def test_removing_an_obstacle_keeps_all_motions() -> None:
    old = plan(load_scene("thesis-1")).plan
    new = without_obstacle(old, "O3")
    check(old, new)
    assert new.changed == {}
    with pytest.raises(SceneError, match="no obstacle O99"):
        without_obstacle(old, "O99")


def test_bad_changes_are_refused_in_one_line() -> None:
    old = plan(load_scene("thesis-1")).plan
    with pytest.raises(SceneError, match="R1"):
        with_obstacle(old, Circle((2, 1), 0.5))
    with pytest.raises(SceneError, match="O1"):
        with_obstacle(old, Circle((2, 1), 0.5, name="O1"))
    with pytest.raises((NoPath, NoPlanExists, NoPlanFound)):
        with_obstacle(old, Rectangle(0, 14.5, 16, 0.5, name="bar"))
    with pytest.raises(SceneError, match="no robots"):
        replan(old, Scene((0, 0, 4, 4)))


@settings(max_examples=30, deadline=None)
@given(team_scenes(), st.floats(0, 1), st.floats(0, 1), st.floats(0.05, 2.0))
def test_whatever_is_added_the_result_certifies_and_keeps_what_it_says(
    scene: Scene, x: float, y: float, size: float
) -> None:
    try:
        old = plan(scene).plan
    except TautError:
        return
    low, high = np.array(scene.workspace).min(axis=0), np.array(scene.workspace).max(axis=0)
    crate = Circle(tuple(low + (high - low) * (x, y)), size / 2, name="crate")
    try:
        new = with_obstacle(old, crate)
    except TautError:
        return
    check(old, new)
    broken = {name for problem in certify(Plan(new.plan.scene, old.trajectories)).problems for name in problem.robots}
    assert broken <= set(new.changed)
    assert all("makes way for" in why for name, why in new.changed.items() if name not in broken)


def test_bad_parameters_are_refused() -> None:
    scene = load_scene("thesis-1")
    result: Any = plan(scene)
    bad: list[tuple[dict[str, Any], str]] = [
        ({"rounds": 0}, "rounds"),
        ({"seconds": -1.0}, "sec"),
        ({"seed": -1}, "seed"),
    ]
    for words, match in bad:
        with pytest.raises(SceneError, match=match):
            replan(result.plan, scene, **words)
    for call in (lambda: replan(result, scene), lambda: with_obstacle(result, Circle((1, 1), 0.1))):
        with pytest.raises(TypeError, match=r"not (to )?a Result"):
            call()


def test_a_team_in_contact_stays_in_contact() -> None:
    robots = [Robot(f"R{k}", (1, 2 + k), (17, 2 + k), 0.2) for k in range(4)]
    hall = Scene((0, 0, 18, 8), robots=robots)
    before = plan(hall, contact=1.5).plan
    same = replan(before, hall)
    assert same.kept == ("R0", "R1", "R2", "R3")
    assert same.plan.claims == before.claims
    after = replan(before, replace(hall, obstacles=(Rectangle(8, 0, 1, 3.5, name="crate"),)))
    assert after.certificate.ok
    assert after.plan.claims == before.claims
    assert after.kept == ()
    assert "stays in contact" in after.changed["R3"]
    with pytest.raises(SceneError, match="not connected within"):
        replan(before, replace(hall, robots=(*robots, Robot("R4", (1, 7.5), (17, 7.5)))))


def test_a_wall_that_hides_robots_has_them_planned_anew() -> None:
    robots = [Robot("R1", (1, 1), (12, 1), 0.2), Robot("R2", (1, 3), (12, 3), 0.2)]
    hall = Scene((0, 0, 13, 6), robots=robots)
    before = plan(hall, contact=Contact(3.0, sight=True)).plan
    assert replan(before, hall).changed == {}
    wall = Rectangle(4, 1.9, 4, 0.2, name="shelf")
    after = replan(before, replace(hall, obstacles=(wall,)))
    assert set(after.changed) == {"R1", "R2"}
    assert after.certificate.ok
