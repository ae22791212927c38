"""Prioritized planning: robots one after another, each avoiding those before it; failed robots move to the front.

Complexity: one safe-interval search for each robot and round.
"""

from __future__ import annotations

import itertools
import math
import time
from collections import Counter, deque
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from types import MappingProxyType
from typing import TypeAlias

import numpy as np

from taut.motion import Trajectory
from taut.team import _neighbourhood_kernels
from taut.team._team_kernels import Team
from taut.team.reservations import clear
from taut.team.safe_intervals import (
    WITHOUT_END,
    Bench,
    Failure,
    bench_of,
    empty_desk,
    hold_start,
    plan_robot,
    take,
    with_stamps,
)
from taut.team.team_arrays import team_of
from taut.team.world import World

MOST_ROUNDS = 24
_EXPANSIONS = 20000  # of a search, in all passes but the well-formed way; searches that succeed take a tenth of that
# a pass with more failures is cheaper to repeat than to mend
_MENDED = 4
_ATTEMPTS = 6
_CROWD = 12
_LATER = 5.0  # seconds by which a robot sets out later, on average, to see who is in its way then

Kept: TypeAlias = Mapping[int, Trajectory]
"""Motions of robots, by their number in the scene, that are not to be changed."""


@dataclass(frozen=True, eq=False)
class Round:
    """One pass over the team.

    Parameters
    ----------
    order : robots in the sequence in which their motions were planned.
    hold : seconds after their start times for which the starts of robots not planned yet were held.
    trajectories : per robot of the scene, None where it failed.
    failures : in the order in which they happened.
    team : robots and roadmaps in the arrays on which it was planned, for who goes on from here; None if there are none.
    """

    order: tuple[int, ...]
    hold: float
    trajectories: tuple[Trajectory | None, ...]
    failures: tuple[Failure, ...]
    team: Team | None = None


@dataclass
class _Pass:
    """A pass under way.

    Parameters
    ----------
    order : robots in the sequence of planning.
    found : of each of them, its motion, which is reserved, or why there is none.
    most : expansions of a search.
    """

    bench: Bench
    order: list[int]
    hold: float
    most: int
    found: dict[int, Trajectory | Failure]


def plan_in_order(
    world: World, order: Sequence[int], hold: float, until: float = math.inf, kept: Kept = MappingProxyType({})
) -> Round | None:
    """Plan each robot in turn; the starts of those still to come are held for ``hold`` seconds.

    The motions ``kept``, of robots not in the order, stay as they are. With an infinite hold, a robot that fails tries
    again with a route that avoids all other starts and goals. None if the monotonic clock passes ``until`` first.
    """
    done = _Pass(bench_of(world), list(order), hold, WITHOUT_END, {})
    return _round(world, done, kept) if _pass(world, done, until, kept) else None


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
    well-formed scene, where all robots can, that pass cannot fail. In the others a search that takes long is given up.
    Where few robots fail, those in their way are planned anew after them. The first pass is always finished; later ones
    end when the monotonic clock passes ``until``.
    """
    order = tuple(order)
    tried = set()
    bench = bench_of(world)
    for number in itertools.count():
        well_formed = number % 8 == 7
        hold = math.inf if well_formed else world.moment * 2.0 ** (number % 8)
        if (order, hold) in tried:
            order = tuple(int(i) for i in rng.permutation(order))
        tried.add((order, hold))
        done = _Pass(bench, list(order), hold, WITHOUT_END if well_formed else _EXPANSIONS, {})
        limit = math.inf if number == 0 else until
        if not _pass(world, done, limit, kept):
            return
        _mend(done, rng, limit)
        result = _round(world, done, kept)
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
    progress: Callable[[int, Round], None] | None = None,
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
            progress(done, result)
    return best, done


# --- A pass -----------------------------------------------------------------------------------------------------------


def _pass(world: World, done: _Pass, until: float, kept: Kept) -> bool:
    """Plan each robot in turn; False if the monotonic clock passes ``until`` first."""
    bench = done.bench
    clear(bench.table)
    for i in done.order:
        _hold(done, i)
    for i, motion in kept.items():
        take(bench, i, motion)
    for i in done.order:
        if time.monotonic() > until:
            return False
        _plan(done, i)
        if isinstance(done.found[i], Failure) and math.isinf(done.hold) and world.avoid_all_ends(i):
            bench.team = team_of(world)
            bench.desk = empty_desk(bench.team, len(bench.table.robot))
            _plan(done, i)
    return True


def _round(world: World, done: _Pass, kept: Kept) -> Round:
    failures = tuple(entry for i in done.order if isinstance(entry := done.found[i], Failure))
    motions = [kept[i] if i in kept else done.found[i] for i in range(len(world.scene.robots))]
    trajectories = tuple(None if isinstance(motion, Failure) else motion for motion in motions)
    return Round(tuple(done.order), done.hold, trajectories, failures, done.bench.team)


def _hold(done: _Pass, i: int) -> None:
    hold_start(done.bench, i, done.bench.scene.robots[i].start_time + done.hold)


def _plan(done: _Pass, i: int) -> None:
    found = plan_robot(done.bench, i, done.most)
    done.found[i] = found
    if isinstance(found, Trajectory):
        take(done.bench, i, found)


def _failed(done: _Pass) -> list[int]:
    return [i for i in done.order if isinstance(done.found[i], Failure)]


# --- Few failures are mended where they are ---------------------------------------------------------------------------


def _mend(done: _Pass, rng: np.random.Generator, until: float) -> None:
    """Plan robots that failed before those in their way, as long as no more robots fail."""
    failed = deque(_failed(done))
    if len(failed) > _MENDED:
        return
    tries: Counter[int] = Counter()
    for _ in range(_ATTEMPTS * (1 + len(failed))):
        if not failed or time.monotonic() > until:
            return
        i = failed.popleft()
        if _planned_before(done, i, _in_its_way(done, i, tries[i], rng)):
            failed = deque(_failed(done))
        else:
            failed.append(i)
        tries[i] += 1


def _planned_before(done: _Pass, i: int, others: list[int]) -> bool:
    """Plan a robot that failed, then those others anew; False, and nothing done, if more robots fail than before."""
    before = {j: done.found[j] for j in (i, *others)}
    allowed = sum(isinstance(was, Failure) for was in before.values())
    for j in others:
        _hold(done, j)
    failed = 0
    for j in before:
        _plan(done, j)
        failed += isinstance(done.found[j], Failure)
        if failed > allowed or isinstance(done.found[i], Failure):
            break
    else:
        done.order = [j for j in done.order if j not in before] + list(before)
        return True
    for j, was in before.items():
        done.found[j] = was
        _hold(done, j)
        if isinstance(was, Trajectory):
            take(done.bench, j, was)
    return False


def _in_its_way(done: _Pass, i: int, tried: int, rng: np.random.Generator) -> list[int]:
    """Robots that robot i would meet on its quickest way: first only those at rest there for ever, then any."""
    bench, failure = done.bench, done.found[i]
    if len(bench.desk.stamp) < len(bench.table.robot):
        bench.desk = with_stamps(bench.desk, bench.table)
    met = np.empty(len(bench.scene.robots), dtype=np.int64)
    depart = bench.scene.robots[i].start_time + (rng.exponential(_LATER) if tried > 1 else 0.0)
    lasting = 0.0 if tried else math.inf
    count = _neighbourhood_kernels.met_on_way(bench.team, i, bench.table, bench.desk, depart, lasting, met)
    who = [j for j in met[:count].tolist() if j in done.found]
    if tried and not who and isinstance(failure, Failure):
        who = [j for j in failure.blockers if j in done.found]
    return (rng.permutation(who).tolist() if tried > 1 else who)[:_CROWD]
