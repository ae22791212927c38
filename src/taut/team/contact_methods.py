"""The ways of planning a team that stays in contact, by name."""

from __future__ import annotations

import math
import time
from collections.abc import Callable, Mapping
from dataclasses import replace
from types import MappingProxyType

import numpy as np

from taut.motion import Plan
from taut.team.explaining import no_plan_in_contact
from taut.team.in_contact import MOST_ROUNDS, Stretch, Together, joined, passes_in_contact, planned_together
from taut.team.methods import REPAIRS, Asked, Found, Progress, first_order
from taut.team.mrppa import mrppa_stages
from taut.team.prioritized import Round
from taut.team.repair_in_contact import repaired_together
from taut.team.search_in_contact import searched_in_contact
from taut.team.ties import Ties
from taut.team.world import World

_NODES = 2000  # of an order search


def _prioritized(world: World, ties: Ties, asked: Asked) -> Found:
    return _found(world, _passed(world, ties, asked, asked.rounds), asked)


def _mrppa(world: World, ties: Ties, asked: Asked) -> Found:
    order = first_order(world.scene, world.shortest, asked.order)
    stages = mrppa_stages(world.scene, order, asked.weigh, asked.split)
    return replace(_prioritized(world, ties, asked), stages=stages)


def _search(world: World, ties: Ties, asked: Asked) -> Found:
    most = math.inf if asked.rounds is None else asked.rounds

    def tell(made: int, done: Stretch) -> None:
        asked.tell(Progress("search", made, len(done.passed.failures), math.inf, 0.0))

    def search(part: World, here: Ties, left: float) -> Together:
        return searched_in_contact(part, here, asked.seed, min(_NODES, left), asked.until, tell)

    return _found(world, planned_together(world, ties, search, most, asked.until), asked)


def _repair(world: World, ties: Ties, asked: Asked) -> Found:
    together = _passed(world, ties, asked, None)
    first = _found(world, together, asked)
    history = list(first.history)
    _, bound = world.bound(asked.objective)

    def tell(done: int, cost: float) -> None:
        if cost < history[-1][1]:
            history.append((time.monotonic(), cost))
        asked.tell(Progress("repair", done, 0, cost, bound))

    rounds = REPAIRS if asked.rounds is None and math.isinf(asked.until) else asked.rounds
    better, repaired = repaired_together(world, together, asked.seed, rounds, asked.until, asked.objective, tell)
    record = {**first.record, "passes": together.passes, "rounds": repaired.rounds}
    return replace(first, plan=joined(world, better.stretches), record=record, history=tuple(history))


IN_CONTACT: Mapping[str, Callable[[World, Ties, Asked], Found]] = MappingProxyType(
    {"prioritized": _prioritized, "mrppa": _mrppa, "search": _search, "repair": _repair}
)
"""From a name to the function that plans."""


def _passed(world: World, ties: Ties, asked: Asked, rounds: int | None) -> Together:
    """Passes over the team until all robots get through in contact."""
    order = first_order(world.scene, world.shortest, asked.order)
    rng = np.random.default_rng(asked.seed)
    most = math.inf if rounds is None else rounds

    def tell(done: int, passed: Round) -> None:
        asked.tell(Progress("passes", done, len(passed.failures), math.inf, 0.0))

    def passes(part: World, here: Ties, left: float) -> Together:
        return passes_in_contact(part, here, order, rng, min(MOST_ROUNDS, left), asked.until, tell)

    return planned_together(world, ties, passes, most, asked.until)


def _found(world: World, together: Together, asked: Asked) -> Found:
    """Return a plan with what is to be told of it.

    Raises
    ------
    NoPlanFound, NoPlanExists
        There is none.
    """
    if not together.found:
        raise no_plan_in_contact(world, together)
    whole = joined(world, together.stretches)
    plan = Plan(world.scene, tuple(motion for motion in whole.trajectories if motion is not None))
    cost = plan.makespan if asked.objective == "makespan" else plan.sum_of_costs
    names = [robot.name for robot in world.scene.robots]
    slowed: dict[str, float] = {}
    for stretch in together.stretches:
        slowed |= {names[i]: share for i, share in stretch.slowed.items()}
    gathered = len(together.stretches) - 1
    record: dict[str, object] = {"rounds": together.passes, "gathered": gathered, "slowed": slowed}
    notes = [f"{name} goes at {share:.0%} of its speed for others to stay in contact" for name, share in slowed.items()]
    if gathered:
        times = "once" if gathered == 1 else f"{gathered} times"
        notes.insert(0, f"the team gathers {times} on the way, where robots change places")
    return Found(whole, record, ((time.monotonic(), cost),), notes=tuple(notes))
