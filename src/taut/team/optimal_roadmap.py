"""Optimal plans of a scene: its robots' roadmaps as one problem, and the plan as motions with stamps."""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from taut.errors import SceneError
from taut.motion import Trajectory
from taut.roadmap import SharedRoadmap
from taut.team._rule_kernels import Floats, Ints
from taut.team.optimal import Motion, Objective, OptimalPlan, Progress, RoadmapProblem, optimal_plan
from taut.team.own_roadmap import OwnRoadmap
from taut.team.safe_intervals import stamps_of
from taut.team.world import World


def optimal_round(
    world: World,
    objective: Objective = "sum_of_costs",
    within: float = 1.0,
    seconds: float | None = None,
    nodes: int | None = None,
    at_most: float = math.inf,
    progress: Progress | None = None,
) -> tuple[tuple[Trajectory, ...] | None, OptimalPlan]:
    """Plan all robots at once on their roadmaps, at least cost or within a factor of it.

    Parameters are those of `taut.team.optimal.optimal_plan`.

    Returns
    -------
    trajectories : one for each robot of the scene; None if no plan was found, or none cheaper than ``at_most``.
    plan : the motions over the vertices of `problem_of`, cost and proven bound; the bound's model is this roadmap.

    Raises
    ------
    SceneError
        The scene asks for a headway, or its numbers are too far apart for a proof within its tolerance.
    """
    try:
        problem = problem_of(world)
        found = optimal_plan(problem, objective, within, seconds, nodes, at_most, progress)
    except ValueError as error:
        raise SceneError(f"no optimal plan can be sought: {error}; choose another method") from None
    if found.motions is None:
        return None, found
    pairs = zip(world.scene.robots, found.motions, strict=True)
    tol = world.scene.tol
    return tuple(Trajectory(r.name, _stamped(problem.positions, m, r.speed, tol)) for r, m in pairs), found


def problem_of(world: World) -> RoadmapProblem:
    """Join the roadmaps of all robots: each shared one once, and what is a robot's own for that robot alone.

    The vertices are those of the shared roadmaps in the order of the robots that have them, then each robot's own, and
    at last, for a robot that leaves, a vertex at its goal's place from which nothing leads on. A robot whose goal is
    its start begins at the vertex of its goal.

    Raises
    ------
    SceneError
        The scene asks for a headway.
    """
    scene, robots = world.scene, world.scene.robots
    if scene.headway > 0 and len(robots) > 1:
        raise SceneError(
            f"optimal plans keep no headway, the scene asks for {scene.headway:g} s: leave it out, "
            "or choose another method"
        )
    roads = list({id(road): road for road in (world.shared(i) for i in range(len(robots)))}.values())
    place, count = {}, 0
    for road in roads:
        place[id(road)] = count
        count += len(road.positions)
    positions = [road.positions for road in roads]
    owners = [np.full(count, -1)]
    lanes = [_arcs(road, place[id(road)]) for road in roads]
    ends = np.empty((len(robots), 2), dtype=np.int64)
    for i, robot in enumerate(robots):
        road, own = world.shared(i), world.own(i)
        numbers = np.append(place[id(road)] + np.arange(len(road.positions)), count + np.arange(len(own.positions)))
        lanes.append(_own_lanes(own, numbers))
        start, goal = (int(numbers[v]) for v in own.ends)
        positions.append(own.positions)
        if not scene.stays(robot):
            exit_ = count + len(own.positions)
            mine = _joined([_arcs(road, place[id(road)]), lanes[-1]])
            lanes.append(_led_to(mine, goal, exit_))
            positions.append(np.array([robot.goal]))
            goal = exit_
        ends[i] = goal if robot.start == robot.goal else start, goal
        added = len(own.positions) + (not scene.stays(robot))
        owners.append(np.full(added, i))
        count += added
    edges, lengths, limits = _joined(lanes)
    order = np.lexsort((edges[:, 1], edges[:, 0]))
    return RoadmapProblem(
        positions=np.concatenate([*positions, np.empty((0, 2))]),
        indptr=np.searchsorted(edges[order, 0], np.arange(count + 1)).astype(np.int64),
        indices=np.ascontiguousarray(edges[order, 1]),
        lengths=lengths[order],
        starts=ends[:, 0].copy(),
        goals=ends[:, 1].copy(),
        radii=np.array([robot.radius for robot in robots], dtype=np.float64),
        speeds=np.array([robot.speed for robot in robots], dtype=np.float64),
        start_times=np.array([robot.start_time for robot in robots], dtype=np.float64),
        gap=scene.gap,
        tol=scene.tol,
        limits=limits[order],
        owners=np.concatenate(owners).astype(np.int64),
        leaves=np.array([not scene.stays(robot) for robot in robots], dtype=np.bool_),
    )


class _Lanes(NamedTuple):
    """Directed edges (e, 2), their lengths in metres and speed limits in metres a second, (e,) each."""

    edges: Ints
    lengths: Floats
    limits: Floats


def _arcs(road: SharedRoadmap, first: int) -> _Lanes:
    """Arcs of a shared roadmap whose vertices are numbered from ``first`` on."""
    arcs = road.arcs
    tails = np.repeat(np.arange(len(road.positions)), np.diff(arcs.indptr))
    return _Lanes(first + np.stack([tails, arcs.indices], axis=1), arcs.lengths, arcs.limits)


def _own_lanes(own: OwnRoadmap, numbers: Ints) -> _Lanes:
    """A robot's own edges both ways, its vertices numbered anew; none to a pinched start, none from a pinched goal.

    Such an end belongs to all sides: a way through it would be one from one side to another.
    """
    edges = np.concatenate([own.edges, own.edges[:, ::-1]])
    lengths = np.concatenate([own.lengths, own.lengths])
    (start, goal), (at_start, at_goal) = own.ends, own.pinched
    kept = ~((edges[:, 1] == start) & at_start | (edges[:, 0] == goal) & at_goal)
    return _Lanes(numbers[edges[kept]], lengths[kept], np.full(int(kept.sum()), np.inf))


def _led_to(lanes: _Lanes, goal: int, exit_: int) -> _Lanes:
    """Copies of the lanes to the goal that lead to the exit."""
    to_goal = np.flatnonzero(lanes.edges[:, 1] == goal)
    edges = np.stack([lanes.edges[to_goal, 0], np.full(len(to_goal), exit_)], axis=1)
    return _Lanes(edges, lanes.lengths[to_goal], lanes.limits[to_goal])


def _joined(parts: list[_Lanes]) -> _Lanes:
    if not parts:
        return _Lanes(np.empty((0, 2), dtype=np.int64), np.empty(0), np.empty(0))
    edges, lengths, limits = zip(*parts, strict=True)
    return _Lanes(np.concatenate(edges), np.concatenate(lengths), np.concatenate(limits))


def _stamped(positions: Floats, motion: Motion, speed: float, tol: float) -> Floats:
    depart = motion.depart.copy()
    depart[-1] = motion.arrive[-1]
    return stamps_of(positions[motion.vertices], motion.arrive, depart, speed, tol)
