"""Teams on every roadmap: plans certify, keep to what they say, and are the same for the same seed."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from taut import NoPath, NoPlanExists, NoPlanFound, Rectangle, Robot, Scene, SceneError, load_scene, plan
from taut.route.ways import WAYS
from taut.team.world import places_on

OTHERS = tuple(name for name in WAYS if name not in ("visibility", "ca", "potential"))


@pytest.mark.parametrize("way", OTHERS)
@pytest.mark.parametrize("name", ["thesis-1", "thesis-2", "thesis-3", "appendix-d", "hospital-12"])
def test_ready_scenes_are_planned_on_every_roadmap(name: str, way: str) -> None:
    found = plan(load_scene(name), roadmap=way)
    assert found.certificate.ok
    assert found.plan.planner["roadmap"] == way
    shortest = plan(load_scene(name)).shortest
    np.testing.assert_allclose(found.shortest, shortest, rtol=1e-12)
    lengths = [motion.length for motion in found.plan.trajectories]
    assert (np.array(lengths) >= shortest * (1 - 1e-12)).all()


@pytest.mark.parametrize("way", OTHERS)
def test_the_same_seed_gives_the_same_plan(way: str) -> None:
    scene = load_scene("appendix-d")
    first, second = (plan(scene, roadmap=way, seed=3).plan for _ in range(2))
    assert first.trajectories == second.trajectories


def test_the_voronoi_roadmap_keeps_a_lone_robot_in_the_middle() -> None:
    bend = Scene((0, 0, 10, 10), [Rectangle(0, 0, 7.5, 7.5)], [Robot("R", (1.25, 8.75), (8.75, 1.25), radius=0.1)])
    certificate = plan(bend, roadmap="voronoi").certificate
    assert certificate.clearance is not None
    assert certificate.clearance.value == pytest.approx(1.15, abs=0.02)


def test_what_a_way_cannot_do_is_told() -> None:
    trap = [Rectangle(4, 1, 1, 6), Rectangle(2, 1, 2, 1), Rectangle(2, 6, 2, 1)]
    scene = Scene((0, 0, 10, 8), trap, [Robot("R1", (3, 4), (9, 4), radius=0.2)])
    with pytest.raises(NoPath, match=r"^R1: stuck in a local minimum at .*"):
        plan(scene, roadmap="potential")
    with pytest.raises(SceneError, match="roadmap 'magic' is not one of visibility, oca"):
        plan(scene, roadmap="magic")
    with pytest.raises(SceneError, match="mrppa"):
        plan(scene, roadmap="grid", method="mrppa")


@pytest.mark.parametrize("way", OTHERS)
def test_two_robots_that_meet_let_each_other_pass(way: str) -> None:
    hall = Scene(
        (0, 0, 12, 8), robots=[Robot("A", (1, 4), (11, 4), radius=0.5), Robot("B", (11, 4), (1, 4), radius=0.5)]
    )
    try:
        found = plan(hall, roadmap=way)
    except (NoPlanExists, NoPlanFound):
        pytest.fail(f"{way}: two robots in an empty hall do not pass each other")
    assert found.certificate.ok


def test_a_central_path_that_hits_something_is_no_route() -> None:
    scene = Scene((0, 0, 10, 10), [Rectangle(3, 0, 2, 5)], [Robot("R1", (0, 0), (10, 0))])
    with pytest.raises(NoPath, match=r"R1: the Central Algorithm's path hits O1 and the wall at \("):
        plan(scene, roadmap="ca")


@pytest.mark.parametrize("name", ["thesis-2", "office-20"])
def test_a_map_planned_on_before_gives_the_plans_of_a_new_one(name: str) -> None:
    scene = load_scene(name)
    swapped = replace(scene, robots=tuple(replace(r, start=r.goal, goal=r.start) for r in scene.robots))
    worlds = (scene, swapped, swapped.with_obstacles(scene.obstacles[1:]))
    anew = []
    for world in worlds:
        places_on.cache_clear()
        anew.append(plan(world).plan.trajectories)
    places_on.cache_clear()
    assert [plan(world).plan.trajectories for world in worlds] == anew
    assert places_on.cache_info().hits > 0  # the swapped team moves on the same map
