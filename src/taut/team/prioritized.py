"""Prioritized planning: robots one after another, each avoiding those before it; failed robots move to the front.

Complexity: one safe-interval search for each robot and round.
"""

from __future__ import annotations

import itertools
import math
import time
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from types import MappingProxyType
from typing import TypeAlias

import numpy as np

from taut.errors import NoPlanFound
from taut.motion import Trajectory
from taut.scene import Scene
from taut.team.reservations import Reservations
from taut.team.safe_intervals import Failure, plan_robot
from taut.team.world import World

MOST_ROUNDS = 24

Kept: TypeAlias = Mapping[int, Trajectory]
"""Motions of robots, by their number in the scene, that are not to be changed."""


@dataclass(frozen=True, eq=False)
class Round:
    """One pass over the team.

    Parameters
    ----------
    order : robots in the sequence in which they were planned.
    hold : seconds after their start times for which the starts of robots not planned yet were held.
    trajectories : per robot of the scene, None where it failed.
    failures : in the order in which they happened.
    """

    order: tuple[int, ...]
    hold: float
    trajectories: tuple[Trajectory | None, ...]
    failures: tuple[Failure, ...]


def plan_in_order(
    world: World, order: Sequence[int], hold: float, until: float = math.inf, kept: Kept = MappingProxyType({})
) -> Round | None:
    """Plan each robot in turn; the starts of those still to come are held for ``hold`` seconds.

    The motions ``kept``, of robots not in the order, stay as they are. With an infinite hold, a robot that fails tries
    again with a route that avoids all other starts and goals. None if the monotonic clock passes ``until`` first.
    """
    scene = world.scene
    reservations = Reservations(scene, world.cell, world.horizon)
    for i in order:
        reservations.hold_start(i, scene.robots[i].start_time + hold)
    trajectories: list[Trajectory | None] = [None] * len(scene.robots)
    failures = []
    for i, motion in kept.items():
        trajectories[i] = motion
        reservations.take(i, motion)
    for i in order:
        if time.monotonic() > until:
            return None
        found = plan_robot(world, i, reservations)
        if isinstance(found, Failure) and math.isinf(hold) and world.avoid_all_ends(i):
            found = plan_robot(world, i, reservations)
        if isinstance(found, Failure):
            failures.append(found)
        else:
            trajectories[i] = found
            reservations.take(i, found)
    return Round(tuple(order), hold, tuple(trajectories), tuple(failures))


def rounds(
    world: World,
    order: Sequence[int],
    rng: np.random.Generator,
    until: float = math.inf,
    kept: Kept = MappingProxyType({}),
) -> Iterator[Round]:
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
        result = plan_in_order(world, order, hold, math.inf if number == 0 else until, kept)
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
    kept: Kept = MappingProxyType({}),
) -> tuple[Round, int]:
    """Return the first round without failure, or the one with fewest, and the number of rounds done."""
    passes = itertools.islice(rounds(world, order, rng, until, kept), most)
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


def no_plan_found(scene: Scene, best: Round, done: int) -> NoPlanFound:
    """Return the error that says who failed in the best round, where, when and because of whom."""
    failure = best.failures[0]
    names = [scene.robots[j].name for j in failure.blockers]
    x, y = failure.place
    way = f"; in its way: {_listed(names)}" if names else ""
    others = f" ({len(best.failures)} robots failed in the best round)" if len(best.failures) > 1 else ""
    robot = scene.robots[failure.robot].name
    return NoPlanFound(
        f"no plan found in {done} round{'s' if done > 1 else ''}: robot {robot} gets no further than "
        f"({x:.2f}, {y:.2f}) at t = {failure.time:.2f} s{way}{others}",
        (robot, *names),
        failure.time,
        failure.place,
    )


def _listed(names: list[str], most: int = 5) -> str:
    shown = ", ".join(names[:most])
    return shown if len(names) <= most else f"{shown} and {len(names) - most} more"
