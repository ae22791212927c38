"""From a Scene to a certified Plan."""

from __future__ import annotations

import math
import time
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import Literal

import numpy as np

from taut.certificate import Certificate, certify
from taut.errors import SceneError
from taut.graph import WEIGHTS, Weight
from taut.motion import Plan
from taut.route import WAYS
from taut.scene import Scene
from taut.team.conflicts import conflicts_met, why_later
from taut.team.mrppa import mrppa_stages
from taut.team.prioritized import MOST_ROUNDS, Round, no_plan_found, plan_rounds
from taut.team.stages import SequenceStage, Stage
from taut.team.world import World
from taut.validation import validate

Order = Literal["shortest", "longest", "given"]
ORDERS: tuple[Order, ...] = ("shortest", "longest", "given")
METHODS = ("prioritized", "mrppa")


@dataclass(frozen=True, eq=False)
class Result:
    """What planning gives.

    Parameters
    ----------
    plan : the timed motions; it carries its certificate.
    certificate : the proof.
    notes : what was found remarkable in the scene.
    shortest : (n,) metres, shortest length of each robot alone.
    detours : per robot, why it is not shorter or earlier; "" if nothing delayed it.
    stages : what was done, step by step: those of MRPPA with that method, and always the planning in sequence.
    """

    plan: Plan
    certificate: Certificate
    notes: tuple[str, ...]
    shortest: np.ndarray
    detours: tuple[str, ...]
    stages: tuple[Stage, ...]


def plan(
    scene: Scene,
    method: str = "prioritized",
    order: Order = "shortest",
    seed: int = 0,
    rounds: int | None = None,
    seconds: float | None = None,
    progress: Callable[[int, int], None] | None = None,
    weight: Weight | str | None = None,
    split: Sequence[str] | None = None,
    roadmap: str = "visibility",
) -> Result:
    """Plan the team and certify the plan.

    Parameters
    ----------
    method : "prioritized": robots one after another, failed ones moved to the front and all planned anew. "mrppa": the
        same with the stages of the thesis before it: the visibility graph cut in two and bridged by λ2.
    order : who is planned first: "shortest" or "longest" way (by time), or as "given" in the scene.
    seed : of the shuffles that break a cycle of orders; same input, seed and rounds give the same plan, bit for bit.
    rounds : greatest number of passes over the team, 24 by default.
    seconds : passes after the first are given up after this time.
    progress : called after each pass with its number and how many robots failed in it.
    weight : with "mrppa": weight in λ2 of an edge, from its length; a name of `taut.graph.WEIGHTS` or a function of
        an array of metres. By default "one": a distance would reward the longest edge.
    split : with "mrppa": names of one side of the cut ("O1", "R1 start", "R2 goal") instead of the Fiedler vector's.
    roadmap : on what the robots move, a name of `taut.route.WAYS`: "visibility" (tangents, and places to pass) or
        another roadmap, or the routes that another way of planning gives them; all with their own places to wait at
        along these routes and ways round others' starts and goals.

    Raises
    ------
    SceneError
        The scene cannot be planned as it is (see `taut.validation.validate`), or an option is unknown.
    NoPath
        Obstacles separate a robot's start and goal, or the roadmap does not join them.
    NoPlanFound
        No pass got all robots through; names the robots in the way, place and time.
    """
    began = time.monotonic()
    if method not in METHODS:
        raise SceneError(f"method {method!r} is not one of {', '.join(METHODS)}")
    if order not in ORDERS:
        raise SceneError(f"order {order!r} is not one of {', '.join(ORDERS)}")
    most, until = limits(began, seed, rounds, seconds)
    weigh = _weight(method, weight)
    if split is not None and method != "mrppa":
        raise SceneError('split belongs to the method "mrppa"')
    if roadmap not in WAYS:
        raise SceneError(f"roadmap {roadmap!r} is not one of {', '.join(WAYS)}")
    if roadmap != "visibility" and method == "mrppa":
        raise SceneError('the method "mrppa" works on the visibility graph; leave roadmap out')
    notes = validate(scene)
    if not scene.robots:
        raise SceneError("no robots: nothing to plan; add at least one robot with name, start and goal")
    world = World(scene, roadmap, seed)
    first = first_order(scene, world.shortest, order)
    graph_stages = mrppa_stages(scene, first, weigh, split) if method == "mrppa" else ()
    best, done = plan_rounds(world, first, np.random.default_rng(seed), most, until, progress)
    if best.failures:
        raise no_plan_found(scene, best, done)
    planner = {
        "method": method,
        "roadmap": roadmap,
        "order": [scene.robots[i].name for i in best.order],
        "seed": seed,
        "rounds": done,
        "seconds": round(time.monotonic() - began, 3),
    }
    final, certificate = certified(world, best, planner)
    met = conflicts_met(world, best)
    names = [robot.name for robot in scene.robots]
    sequence = SequenceStage(final, tuple(names[i] for i in best.order), dict(zip(names, met, strict=True)))
    return Result(final, certificate, notes, world.shortest, tuple(map(why_later, met)), (*graph_stages, sequence))


def limits(began: float, seed: int, rounds: int | None, seconds: float | None) -> tuple[int, float]:
    """Greatest number of rounds, and until when by the monotonic clock planning may go on.

    Raises
    ------
    SceneError
        One of them, or the seed, makes no sense.
    """
    most = MOST_ROUNDS if rounds is None else rounds
    if not isinstance(most, int) or most < 1:
        raise SceneError(f"rounds must be at least 1, got {rounds}")
    if not isinstance(seed, int) or seed < 0:
        raise SceneError(f"seed must be at least 0, got {seed}")
    if seconds is not None and not seconds > 0:
        raise SceneError(f"seconds must be positive, got {seconds}")
    return most, math.inf if seconds is None else began + seconds


def certified(world: World, done: Round, planner: Mapping[str, object]) -> tuple[Plan, Certificate]:
    """Return a round without failures as a plan that carries its certificate and bound, and the certificate."""
    speeds = np.array([robot.speed for robot in world.scene.robots])
    bound = {"model": "plane", "value": float((world.shortest / speeds).sum())}
    found = tuple(motion for motion in done.trajectories if motion is not None)
    certificate = certify(Plan(world.scene, found, planner, {}, bound))
    return Plan(world.scene, found, planner, {}, bound, certificate.as_dict()), certificate


def first_order(scene: Scene, shortest: np.ndarray, order: Order) -> list[int]:
    """Robots in the sequence in which the first round plans them; ``shortest`` (n,) are metres."""
    seconds = shortest / np.array([r.speed for r in scene.robots])
    if order == "given":
        return list(range(len(seconds)))
    ranked = np.argsort(seconds if order == "shortest" else -seconds, kind="stable")
    return [int(i) for i in ranked]


def _weight(method: str, weight: Weight | str | None) -> Weight:
    if weight is not None and method != "mrppa":
        raise SceneError('weight belongs to the method "mrppa"')
    if isinstance(weight, str):
        if weight not in WEIGHTS:
            raise SceneError(f"weight {weight!r} is not one of {', '.join(WEIGHTS)}")
        return WEIGHTS[weight]
    return WEIGHTS["one"] if weight is None else weight
