"""Prioritized planning: robots one after another, each avoiding those before it; failed robots move to the front.

Complexity: one safe-interval search for each robot and round.
"""

from __future__ import annotations

import itertools
import math
import time
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass

import numpy as np

from taut.motion import Trajectory
from taut.team.reservations import Reservations
from taut.team.safe_intervals import Failure, plan_robot
from taut.team.world import World

MOST_ROUNDS = 24


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
    return Round(tuple(order), hold, tuple(trajectories), tuple(failures))


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
