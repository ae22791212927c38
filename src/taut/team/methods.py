"""The ways of planning a team, by name: each from a World and what is asked to motions that keep apart."""

from __future__ import annotations

import math
import time
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import partial
from itertools import count as counted
from types import MappingProxyType
from typing import Literal, NamedTuple, TypeAlias, get_args

import numpy as np

from taut.errors import NoPlanFound
from taut.graph import Weight
from taut.interrupts import held_back
from taut.motion import Plan, Trajectory
from taut.scene import Scene
from taut.team.explaining import no_order, no_plan, refuse_impossible
from taut.team.mrppa import mrppa_stages
from taut.team.optimal import OptimalPlan
from taut.team.optimal_roadmap import optimal_round
from taut.team.prioritized import MOST_ROUNDS, Round, plan_rounds
from taut.team.repair import Objective, repaired
from taut.team.search import searched
from taut.team.stages import Stage
from taut.team.world import World

Order: TypeAlias = Literal["shortest", "longest", "given"]
ORDERS: tuple[Order, ...] = get_args(Order)
OBJECTIVES: tuple[Objective, ...] = get_args(Objective)

_SUSPICIOUS = 2  # passes that failed, before a proof is sought that all will
_NODES = 10_000  # of an order search
_BETWEEN = 8  # rounds of repair until roadmaps grow for the first time; then twice as many each time
_ABOUT = np.stack([np.cos(np.arange(6) * np.pi / 3), np.sin(np.arange(6) * np.pi / 3)], axis=1)
REPAIRS = 40  # rounds where neither these nor seconds are given: about a second's work


class Progress(NamedTuple):
    """How far planning has come.

    Parameters
    ----------
    doing : "passes" over the team, "search" for an order, "repair", or "proof" of an optimum.
    done : rounds of it, or nodes of a search tree.
    failed : robots that got no motion in the last pass; pairs that meet in the last node of a search for an order.
    cost, bound : of the best plan yet, inf if there is none, and what no plan can beat; seconds.
    """

    doing: str
    done: int
    failed: int
    cost: float
    bound: float


@dataclass(frozen=True)
class Asked:
    """What is asked of a method, see `taut.plan`; ``until`` is a time of the monotonic clock, seconds."""

    order: Order
    seed: int
    rounds: int | None
    until: float
    objective: Objective
    within: float
    weigh: Weight
    split: Sequence[str] | None
    tell: Callable[[Progress], None]


@dataclass(frozen=True, eq=False)
class Found:
    """What a method has found.

    Parameters
    ----------
    plan : a pass without failures.
    record : what the plan's file tells of how it was planned.
    history : (time of the monotonic clock, cost in seconds) of the first plan and of each better one.
    bound : seconds that no plan on this roadmap can beat; None if it is known of the shortest routes only.
    stages : what was done before the team was planned.
    notes : what is remarkable about the plan, in sentences.
    """

    plan: Round
    record: Mapping[str, object]
    history: tuple[tuple[float, float], ...]
    bound: float | None = None
    stages: tuple[Stage, ...] = ()
    notes: tuple[str, ...] = ()


def first_order(scene: Scene, shortest: np.ndarray, order: Order) -> list[int]:
    """Robots in the sequence in which the first round plans them; ``shortest`` (n,) are metres."""
    seconds = shortest / np.array([r.speed for r in scene.robots])
    if order == "given":
        return list(range(len(seconds)))
    ranked = np.argsort(seconds if order == "shortest" else -seconds, kind="stable")
    return [int(i) for i in ranked]


def _prioritized(world: World, asked: Asked) -> Found:
    return _passed(world, asked, asked.rounds)


def _mrppa(world: World, asked: Asked) -> Found:
    order = first_order(world.scene, world.shortest, asked.order)
    stages = mrppa_stages(world.scene, order, asked.weigh, asked.split)
    return replace(_passed(world, asked, asked.rounds), stages=stages)


def _search(world: World, asked: Asked) -> Found:
    def tell(nodes: int, meetings: int) -> None:
        asked.tell(Progress("search", nodes, meetings, math.inf, 0.0))

    found = searched(world, asked.seed, _NODES if asked.rounds is None else asked.rounds, asked.until, tell)
    if found.trajectories is None:
        raise no_order(world, found)
    plan = Round(found.order, 0.0, found.trajectories, ())
    return Found(plan, {"rounds": found.nodes}, ((time.monotonic(), _cost(world.scene, _all(plan), asked.objective)),))


def _repair(world: World, asked: Asked) -> Found:
    first = _passed(world, asked, None)
    history = list(first.history)

    def tell(before: int, done: int, cost: float) -> None:
        if cost < history[-1][1]:
            history.append((time.monotonic(), cost))
        asked.tell(Progress("repair", before + done, 0, cost, bound))

    _, bound = world.bound(asked.objective)
    rounds = REPAIRS if asked.rounds is None and math.isinf(asked.until) else asked.rounds
    plan, done = first.plan, 0
    with held_back() as interrupted:  # there is a plan now: it must not be lost
        for stage in counted():
            few = _BETWEEN << stage if rounds is None else min(_BETWEEN << stage, rounds - done)
            better = repaired(world, plan, (asked.seed, stage), few, asked.until, asked.objective, partial(tell, done))
            done += better.rounds
            plan = _in_order_of_delay(world, better.trajectories)
            if better.rounds < few or done == rounds or better.interrupted or interrupted():
                break
            _enrich(world, plan)
    return Found(plan, {"passes": first.record["rounds"], "rounds": done}, tuple(history))


def _enrich(world: World, plan: Round) -> None:
    """Let the roadmaps of delayed robots grow where these go and wait now.

    Straight ways between all bends and waits of its motion let a robot skip what it went round before, and places
    about its waits let it wait elsewhere.
    """
    for i, motion in enumerate(_all(plan)):
        if motion.arrival > world.soonest[i] * (1 + 1e-9):
            robot = world.scene.robots[i]
            resting = motion.points[:-1][(np.diff(motion.points, axis=0) == 0).all(axis=1)]
            about = resting[:, None] + world.scene.separation(robot, robot) * _ABOUT
            world.enrich(i, np.unique(np.concatenate([motion.points, about.reshape(-1, 2)]), axis=0))


def _optimal(world: World, asked: Asked) -> Found:
    try:
        known: Found | None = _passed(world, asked, None)
        failed = None
    except NoPlanFound as error:
        known, failed = None, error
    best = math.inf if known is None else known.history[0][1]

    def tell(done: int, bound: float, cost: float) -> None:
        asked.tell(Progress("proof", done, 0, min(cost, best), bound))

    seconds = None if math.isinf(asked.until) else max(asked.until - time.monotonic(), 0.0)
    try:
        motions, proof = optimal_round(world, asked.objective, asked.within, seconds, asked.rounds, best, tell)
    except KeyboardInterrupt:  # before the search knew anything
        if known is None:
            raise
        motions, proof = None, OptimalPlan(None, math.inf, 0.0, 0, False)
    record = {"rounds": proof.expanded, "within": asked.within, "proven": proof.proven}
    history = () if known is None else known.history
    if motions is not None:
        plan = _in_order_of_delay(world, motions)
        return Found(plan, record, (*history, (time.monotonic(), proof.cost)), proof.lower_bound)
    if known is None:
        assert failed is not None
        raise _without_plan(failed, proof)
    return Found(_in_order_of_delay(world, _all(known.plan)), record, history, proof.lower_bound)


def _without_plan(failed: NoPlanFound, proof: OptimalPlan) -> NoPlanFound:
    """Return what is known when neither passes nor the proof found a plan."""
    what = f"no plan found in {proof.expanded} nodes; any on this roadmap costs at least {proof.lower_bound:.4f} s"
    if proof.proven:
        what = f"there is no plan on this roadmap, as {proof.expanded} nodes prove; another roadmap may have one"
    return NoPlanFound(what, failed.robots, failed.time, failed.place, failed.diagnosis)


METHODS: Mapping[str, Callable[[World, Asked], Found]] = MappingProxyType(
    {"prioritized": _prioritized, "mrppa": _mrppa, "search": _search, "repair": _repair, "optimal": _optimal}
)
"""From a name to the function that plans."""


def _passed(world: World, asked: Asked, rounds: int | None) -> Found:
    """Passes over the team until all robots get through."""
    order = first_order(world.scene, world.shortest, asked.order)

    def tell(done: int, passed: Round) -> None:
        asked.tell(Progress("passes", done, len(passed.failures), math.inf, 0.0))
        if passed.failures and done == _SUSPICIOUS:
            refuse_impossible(world, passed)

    best, done = plan_rounds(
        world, order, np.random.default_rng(asked.seed), MOST_ROUNDS if rounds is None else rounds, asked.until, tell
    )
    if best.failures:
        raise no_plan(world, best, done)
    return Found(best, {"rounds": done}, ((time.monotonic(), _cost(world.scene, _all(best), asked.objective)),))


def _cost(scene: Scene, motions: Sequence[Trajectory], objective: Objective) -> float:
    plan = Plan(scene, tuple(motions))
    return plan.makespan if objective == "makespan" else plan.sum_of_costs


def _all(done: Round) -> tuple[Trajectory, ...]:
    return tuple(motion for motion in done.trajectories if motion is not None)


def _in_order_of_delay(world: World, motions: Sequence[Trajectory]) -> Round:
    """Return motions as a pass in which those went first that are delayed least."""
    delays = np.array([motion.arrival for motion in motions]) - world.soonest
    return Round(tuple(np.argsort(delays, kind="stable").tolist()), 0.0, tuple(motions), ())
