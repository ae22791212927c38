"""One robot among others: its earliest arrival by safe-interval search, or why there is none."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import TypeAlias

import numpy as np

from taut.motion import Trajectory
from taut.team import _reservation_kernels, _search_kernels
from taut.team._conflict_kernels import Floats
from taut.team.reservations import Reservations, distances_from
from taut.team.world import World

Stamp: TypeAlias = tuple[float, float, float]


@dataclass(frozen=True)
class Failure:
    """A robot that found no way, with where and when it got no further and who was in its way."""

    robot: int
    place: tuple[float, float]
    time: float
    blockers: tuple[int, ...]


def plan_robot(world: World, i: int, reservations: Reservations) -> Trajectory | Failure:
    """Earliest arrival of one robot among the reservations, on its roadmap.

    A robot that is at its goal already stays, or is gone at once; it moves only if it has to let somebody pass.
    """
    scene, robot = world.scene, world.scene.robots[i]
    if robot.start == robot.goal and (not scene.stays(robot) or not _passers(world, i, reservations)):
        return Trajectory(robot.name, np.array([[0.0, *robot.start]]))
    shared, own = world.shared(i), world.own(i)
    n = len(shared.positions)
    graph = shared.graph
    positions = np.concatenate([shared.positions, own.positions])
    found, vertices, arrive, depart, stuck, when, _ = _search_kernels.safe_interval_search(
        (graph.indptr, graph.indices, graph.weights),
        own.adjacency(n),
        positions,
        reservations.arrays,
        i,
        world.body(i),
        robot.speed,
        robot.start_time,
        scene.stays(robot),
        *own.ends,
        own.pinched,
    )
    if not found:
        place = positions[stuck]
        return Failure(
            i, (float(place[0]), float(place[1])), float(when), _in_the_way(world, i, stuck, when, reservations)
        )
    return Trajectory(robot.name, _stamps(positions[vertices], arrive, depart, robot.speed, scene.tol))


def _stamps(points: Floats, arrive: Floats, depart: Floats, speed: float, tol: float) -> Floats:
    """Stamps of a motion, without the rests and the bends that only rounding makes (below tol / 64)."""
    rows: list[tuple[float, float, float]] = [(0.0, float(points[0, 0]), float(points[0, 1]))]
    for k in range(len(points)):
        x, y = points[k].tolist()
        for t in (float(arrive[k]), float(depart[k])):
            if (t - rows[-1][0]) * speed <= tol / 64:
                continue
            while len(rows) > 1 and _on_the_way(rows[-2], rows[-1], (t, x, y), tol / 64):
                rows.pop()
            before, *place = rows[-1]
            if math.dist(place, (x, y)) > speed * (t - before):  # rounding must not make it faster than it can be
                t = math.nextafter(max(t, before + math.dist(place, (x, y)) / speed), math.inf)
            rows.append((t, x, y))
    return np.array(rows)


def _on_the_way(a: Stamp, b: Stamp, c: Stamp, slack: float) -> bool:
    """Whether a steady move from a to c is within ``slack`` metres of b at b's time."""
    f = (b[0] - a[0]) / (c[0] - a[0])
    return math.hypot(a[1] + f * (c[1] - a[1]) - b[1], a[2] + f * (c[2] - a[2]) - b[2]) <= slack


def _passers(world: World, i: int, reservations: Reservations) -> bool:
    """Whether any robot comes too near to where robot i stands, at any time."""
    reserved = reservations.arrays
    empty, stamp = np.empty(4), np.full(len(reserved[0]), -1, dtype=np.int64)
    place = world.scene.robots[i].start
    _, _, count = _reservation_kernels.place_conflicts(
        *place, reserved, i, world.body(i), empty, empty.copy(), stamp, 0
    )
    return count > 0


def _in_the_way(world: World, i: int, stuck: int, when: float, reservations: Reservations) -> tuple[int, ...]:
    """Robots that hold the goal, or that pass where the search got no further, after it got there."""
    scene, robot = world.scene, world.scene.robots[i]
    shared, own = world.shared(i), world.own(i)
    legs, robots, radii, *_ = reservations.arrays
    here = shared.positions[stuck] if stuck < len(shared.positions) else own.positions[stuck - len(shared.positions)]
    around = shared.reach if math.isfinite(shared.reach) else 0.0
    near = []
    for place, since, more in ((here, when, around), (np.array(robot.goal), 0.0, 0.0)):
        close = distances_from(legs, place) < robot.radius + radii + scene.gap + more
        near += robots[close & (legs[:, 5] >= since) & (robots != i) & (robots >= 0)].tolist()
    return tuple(sorted(set(near)))
