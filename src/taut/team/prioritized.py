"""Prioritized planning: robots one after another, each avoiding those before it; failed robots move to the front.

Complexity: one safe-interval search for each robot and round.
"""

from __future__ import annotations

import itertools
import math
import time
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from typing import TypeAlias

import numpy as np

from taut.motion import Trajectory
from taut.team import _kernels
from taut.team._kernels import Floats
from taut.team.reservations import Reservations
from taut.team.world import World

MOST_ROUNDS = 24

Stamp: TypeAlias = tuple[float, float, float]


@dataclass(frozen=True)
class Failure:
    """A robot that found no way, with where and when it got no further and who was in its way."""

    robot: int
    place: tuple[float, float]
    time: float
    blockers: tuple[int, ...]


@dataclass(frozen=True, eq=False)
class Round:
    """One pass over the team.

    Parameters
    ----------
    order : robots in the sequence in which they were planned.
    trajectories : per robot of the scene, None where it failed.
    failures : in the order in which they happened.
    """

    order: tuple[int, ...]
    trajectories: tuple[Trajectory | None, ...]
    failures: tuple[Failure, ...]


def plan_in_order(world: World, order: Sequence[int], hold: float, until: float = math.inf) -> Round | None:
    """Plan each robot in turn; the starts of those still to come are held for ``hold`` seconds.

    With an infinite hold, a robot that fails tries again with a route that avoids all other starts and goals. None if
    the monotonic clock passes ``until`` first.
    """
    scene = world.scene
    reservations = Reservations(scene, world.cell, world.horizon)
    for i in order:
        reservations.hold_start(i, scene.robots[i].start_time + hold)
    trajectories: list[Trajectory | None] = [None] * len(scene.robots)
    failures = []
    for i in order:
        if time.monotonic() > until:
            return None
        motion = plan_robot(world, i, reservations)
        if isinstance(motion, Failure) and math.isinf(hold) and world.avoid_all_ends(i):
            motion = plan_robot(world, i, reservations)
        if isinstance(motion, Failure):
            failures.append(motion)
        else:
            trajectories[i] = motion
            reservations.take(i, motion)
    return Round(tuple(order), tuple(trajectories), tuple(failures))


def plan_robot(world: World, i: int, reservations: Reservations) -> Trajectory | Failure:
    """Earliest arrival of one robot among the reservations, on its roadmap."""
    scene, robot = world.scene, world.scene.robots[i]
    if robot.start == robot.goal:
        return _stand(world, i, reservations)
    shared, own = world.shared(i), world.own(i)
    n = len(shared.positions)
    graph = shared.graph
    positions = np.concatenate([shared.positions, own.positions])
    found, vertices, arrive, depart, stuck, when, _ = _kernels.safe_interval_search(
        (graph.indptr, graph.indices, graph.weights),
        own.adjacency(n),
        positions,
        reservations.arrays,
        i,
        world.body(i),
        robot.speed,
        robot.start_time,
        scene.stays(robot),
        n,
        n + 1,
        own.pinched,
    )
    if not found:
        place = positions[stuck]
        return Failure(
            i, (float(place[0]), float(place[1])), float(when), _in_the_way(world, i, stuck, when, reservations)
        )
    return Trajectory(robot.name, _stamps(positions[vertices], arrive, depart, robot.speed, scene.tol))


def rounds(world: World, order: Sequence[int], rng: np.random.Generator, until: float = math.inf) -> Iterator[Round]:
    """Yield passes until one has no failure: failed robots first, starts held longer, then the well-formed way.

    Holding starts for ever fails in dense maps, not at all fails where a robot cannot leave in time: so the hold grows.
    Every eighth pass holds them for ever and lets each robot that fails avoid all other starts and goals; in a
    well-formed scene, where all robots can, that pass cannot fail. The first pass is always finished; later ones end
    when the monotonic clock passes ``until``.
    """
    order = tuple(order)
    tried = set()
    for number in itertools.count():
        hold = np.inf if number % 8 == 7 else world.moment * 2.0 ** (number % 8)
        if (order, hold) in tried:
            order = tuple(int(i) for i in rng.permutation(order))
        tried.add((order, hold))
        result = plan_in_order(world, order, hold, math.inf if number == 0 else until)
        if result is None:
            return
        yield result
        failed = [f.robot for f in result.failures]
        if not failed:
            return
        order = (*failed, *(i for i in order if i not in set(failed)))


def plan_rounds(
    world: World,
    order: Sequence[int],
    rng: np.random.Generator,
    most: int,
    until: float,
    progress: Callable[[int, int], None] | None = None,
) -> tuple[Round, int]:
    """Return the first round without failure, or the one with fewest, and the number of rounds done."""
    passes = itertools.islice(rounds(world, order, rng, until), most)
    best = next(passes)
    done = 1
    for result in itertools.chain([best], passes):
        if result is not best:
            done += 1
        if len(result.failures) < len(best.failures):
            best = result
        if progress is not None:
            progress(done, len(result.failures))
    return best, done


def _stand(world: World, i: int, reservations: Reservations) -> Trajectory | Failure:
    """A robot that is at its goal already: it stays, or is gone at once."""
    robot = world.scene.robots[i]
    rest = Trajectory(robot.name, np.array([[0.0, *robot.start]]))
    if not world.scene.stays(robot):
        return rest
    passers = _passers(world, i, robot.start, reservations)
    if len(passers):
        return Failure(i, robot.start, 0.0, tuple(passers))
    return rest


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


def _passers(world: World, i: int, place: Sequence[float], reservations: Reservations) -> list[int]:
    """Robots that come too near to a place at any time."""
    points = np.array([place, place], dtype=np.float64)
    legs, _ = _kernels.blockers(points, np.array([1e300]), np.array([0.0]), reservations.arrays, i, world.body(i))
    return sorted(set(reservations.arrays[1][legs].tolist()))


def _in_the_way(world: World, i: int, stuck: int, when: float, reservations: Reservations) -> tuple[int, ...]:
    """Robots that hold the goal, or that pass where the search got no further, after it got there."""
    scene, robot = world.scene, world.scene.robots[i]
    shared, own = world.shared(i), world.own(i)
    legs, robots, _, *_ = reservations.arrays
    here = shared.positions[stuck] if stuck < len(shared.positions) else own.positions[stuck - len(shared.positions)]
    near = []
    for place, since in ((here, when), (np.array(robot.goal), 0.0)):
        away = np.hypot(*(_closest(legs, place) - place).T)
        need = np.array([scene.separation(robot, scene.robots[j]) if j >= 0 else -1.0 for j in robots])
        reach = need + (shared.reach if place is here and np.isfinite(shared.reach) else 0.0)
        near += robots[(away < reach) & (legs[:, 5] >= since) & (robots != i) & (robots >= 0)].tolist()
    return tuple(sorted(set(near)))


def _closest(legs: Floats, place: Floats) -> Floats:
    a, b = legs[:, 0:2], legs[:, 3:5]
    e = b - a
    square = (e * e).sum(axis=1)
    f = np.clip(((place - a) * e).sum(axis=1) / np.where(square > 0, square, 1.0), 0.0, 1.0)
    return np.asarray(a + f[:, None] * e)
