"""Optimal plans of scenes: certified, bounded, and each robot on what is its own."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from taut import load_scene
from taut.certificate import certify
from taut.errors import SceneError
from taut.motion import Plan
from taut.scene import AtGoal, Rectangle, Robot, Scene
from taut.team.optimal import Objective
from taut.team.optimal_roadmap import optimal_round, problem_of
from taut.team.world import World


def first_of(name: str, robots: int) -> Scene:
    scene = load_scene(name)
    return replace(scene, robots=scene.robots[:robots], headway=0.0)


def hall(at_goal: AtGoal = "stay") -> Scene:
    """Robots of two sizes and speeds that cross, one of which begins where it ends."""
    robots = [
        Robot("A", (1, 3), (9, 3), 0.3),
        Robot("B", (9, 3.2), (1, 2.8), 0.5, 0.8),
        Robot("C", (5, 1), (5, 5), 0.3, start_time=2.0),
        Robot("D", (5, 3), (5, 3), 0.3),
    ]
    return Scene((0, 0, 10, 6), [Rectangle(3, 3.8, 1, 1)], robots, gap=0.05, at_goal=at_goal)


def certified(
    scene: Scene, objective: Objective = "sum_of_costs", within: float = 1.0, nodes: int = 400
) -> tuple[Plan, float, bool]:
    motions, found = optimal_round(World(scene), objective, within, nodes=nodes)
    assert motions is not None
    plan = Plan(scene, motions)
    proof = certify(plan)
    assert proof.ok, proof.problems
    assert found.cost == pytest.approx(getattr(plan, objective), abs=1e-8)
    assert found.lower_bound <= found.cost
    return plan, found.lower_bound, found.proven


@pytest.mark.parametrize(
    ("name", "robots"), [("thesis-1", 2), ("thesis-3", 2), ("warehouse-50", 2), ("office-20", 6), ("hospital-12", 2)]
)
def test_ready_scenes_are_planned_at_a_proven_optimum(name: str, robots: int) -> None:
    scene = first_of(name, robots)
    plan, bound, proven = certified(scene, nodes=1500)
    assert proven
    assert plan.sum_of_costs == pytest.approx(bound, rel=1e-9)
    speeds = np.array([robot.speed for robot in scene.robots])
    assert bound >= (World(scene).shortest / speeds).sum() - 1e-9


@pytest.mark.parametrize("objective", ["sum_of_costs", "makespan"])
@pytest.mark.parametrize("at_goal", ["stay", "leave"])
def test_robots_of_all_kinds_are_planned_together(at_goal: AtGoal, objective: Objective) -> None:
    plan, _, proven = certified(hall(at_goal), objective, within=1.3, nodes=3000)
    assert proven
    if at_goal == "leave":
        assert len(plan.trajectories[3].stamps) == 1


def test_nobody_uses_what_is_anothers_own() -> None:
    scene = hall("leave")
    problem = problem_of(World(scene))
    assert problem.owners is not None
    _, found = optimal_round(World(scene), within=1.3, nodes=3000)
    assert found.motions is not None
    for i, motion in enumerate(found.motions):
        assert set(problem.owners[motion.vertices].tolist()) <= {-1, i}


def test_a_known_cost_that_cannot_be_beaten_leaves_no_motions() -> None:
    world = World(first_of("office-20", 4))
    _, least = optimal_round(world)
    motions, found = optimal_round(world, at_most=least.cost)
    assert motions is None
    assert found.proven


def test_a_headway_is_refused() -> None:
    with pytest.raises(SceneError, match="headway"):
        problem_of(World(replace(hall(), headway=0.5)))


def test_one_robot_takes_the_shortest_route() -> None:
    scene = first_of("thesis-3", 1)
    plan, bound, _ = certified(scene)
    assert bound == pytest.approx(float(World(scene).shortest[0]) / scene.robots[0].speed, rel=1e-9)
    assert plan.length == pytest.approx(float(World(scene).shortest[0]), rel=1e-9)
