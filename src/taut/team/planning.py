"""From a Scene to a certified Plan."""

from __future__ import annotations

import math
import time
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from types import MappingProxyType

import numpy as np

from taut.certificate import Certificate, certify
from taut.contact import Contact
from taut.errors import NoPlanFound, SceneError
from taut.graph import WEIGHTS, Weight
from taut.motion import Plan
from taut.roadmap import Lanes
from taut.route import WAYS
from taut.scene import Scene
from taut.team.conflicts import Conflict, conflicts_met, why_later
from taut.team.contact_methods import IN_CONTACT
from taut.team.methods import METHODS, OBJECTIVES, ORDERS, Asked, Order, Progress
from taut.team.prioritized import Round
from taut.team.repair import Objective
from taut.team.stages import SequenceStage, Stage
from taut.team.ties import ties_of
from taut.team.world import World
from taut.validation import validate


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
    history : (seconds from the beginning, cost in seconds of the objective) of the first plan and of each better one.
    phases : seconds that "roadmaps", "planning" and "certificate" took.
    """

    plan: Plan
    certificate: Certificate
    notes: tuple[str, ...]
    shortest: np.ndarray
    detours: tuple[str, ...]
    stages: tuple[Stage, ...]
    history: tuple[tuple[float, float], ...]
    phases: Mapping[str, float]


def plan(
    scene: Scene,
    method: str | None = None,
    order: Order = "shortest",
    seed: int = 0,
    rounds: int | None = None,
    seconds: float | None = None,
    progress: Callable[[Progress], None] | None = None,
    weight: Weight | str | None = None,
    split: Sequence[str] | None = None,
    roadmap: str | Lanes = "visibility",
    objective: Objective = "sum_of_costs",
    within: float = 1.0,
    contact: Contact | float | None = None,
) -> Result:
    """Plan the team and certify the plan.

    Parameters
    ----------
    method : None for "repair" where rounds or seconds are given, else "prioritized".

        - "prioritized": robots one after another, failed ones moved to the front and all planned anew.
        - "mrppa": the same with the stages of the thesis before it: the visibility graph cut in two, bridged by λ2.
        - "search": priorities between pairs of robots, searched until all get through (Ma et al., AAAI 2019).
        - "repair": a plan by passes in order, then improved: a few robots that hinder each other are planned anew.
        - "optimal": conflict-based search: least cost on this roadmap, with a proven lower bound at any moment.
    order : who is planned first: "shortest" or "longest" way (by time), or as "given" in the scene.
    seed : of everything drawn at random; same input, seed and rounds give the same plan, bit for bit.
    rounds : at most so many passes over the team (by default 24, in contact 48 on each stretch of the way), rounds of
        repair (40 by default, none after the seconds if these are given), nodes of a search.
    seconds : when they are over the best plan so far is returned; the first pass over the team is always finished.
    progress : called now and then with how far it has come. Ctrl-C during repair or a proof returns the best plan.
    weight : with "mrppa": weight in λ2 of an edge, from its length; a name of `taut.graph.WEIGHTS` or a function of
        an array of metres. By default "one": a distance would reward the longest edge.
    split : with "mrppa": names of one side of the cut ("O1", "R1 start", "R2 goal") instead of the Fiedler vector's.
    roadmap : on what the robots move, a name of `taut.route.WAYS`: "visibility" (tangents, and places to pass) or
        another roadmap, or the routes that another way of planning gives them; all with their own places to wait at
        along these routes and ways round others' starts and goals. Or `Lanes`: robots then move on these alone, in
        their directions and within their speed limits; a start or goal that is no vertex is joined with the nearest.
    objective : with "repair" and "optimal": what is to be least, "sum_of_costs" or "makespan".
    within : with "optimal": the plan may cost up to so many times the bound.
    contact : at every instant each robot is within that many metres of a robot planned before it, so that the team is
        connected throughout; or a `taut.Contact`, for robots in sight of each other, teams of which some may fail, or a
        least λ2. The plan claims it, and the certificate proves it. Not with "optimal".

    Raises
    ------
    SceneError
        The scene cannot be planned as it is (see `taut.validation.validate`), or an option is unknown.
    NoPath
        Obstacles separate a robot's start and goal, or the roadmap does not join them.
    NoPlanExists
        Two robots provably cannot both reach their goals; says where, and what would help.
    NoPlanFound
        Not all robots got through; names the robots in the way, place and time, and what may help.
    """
    began = time.monotonic()
    chosen = method or ("prioritized" if rounds is None and seconds is None else "repair")
    _check(chosen, order, objective, within, split, roadmap)
    demand = contact if contact is None or isinstance(contact, Contact) else Contact(contact)
    if demand is not None and chosen not in IN_CONTACT:
        raise SceneError(f'contact belongs to the methods {", ".join(IN_CONTACT)}, not "{chosen}"')
    asked = Asked(
        order,
        seed,
        rounds,
        deadline(began, seed, rounds, seconds, least=0 if chosen == "repair" else 1),
        objective,
        within,
        _weight(chosen, weight),
        split,
        progress or _silent,
    )
    notes = validate(scene)
    if not scene.robots:
        raise SceneError("no robots: nothing to plan; add at least one robot with name, start and goal")
    ties = None if demand is None else ties_of(scene, demand)
    world = World(scene, roadmap, seed)
    ready = time.monotonic()
    found = METHODS[chosen](world, asked) if ties is None else IN_CONTACT[chosen](world, ties, asked)
    planned = time.monotonic()
    planner = {
        "method": chosen,
        "roadmap": roadmap.source if isinstance(roadmap, Lanes) else roadmap,
        "order": [scene.robots[i].name for i in found.plan.order],
        "seed": seed,
        **({} if objective == "sum_of_costs" else {"objective": objective}),
        **found.record,
        "seconds": round(planned - began, 3),
    }
    claims = {} if demand is None else {"contact": demand.claim}
    final, certificate = certified(world, found.plan, planner, objective, found.bound, claims)
    if demand is not None and demand.lambda2 > 0 and not certificate.ok:
        raise _too_weak(certificate)
    proved = time.monotonic()
    met = conflicts_met(world, found.plan)
    names = [robot.name for robot in scene.robots]
    order_of_names = tuple(names[i] for i in found.plan.order)
    sequence = SequenceStage(final, order_of_names, dict(zip(names, met, strict=True)))
    return Result(
        final,
        certificate,
        (*notes, *world.notes, *found.notes),
        world.shortest,
        tuple(map(why_later, met)) if demand is None else _in_company(world, found.plan, met),
        (*found.stages, sequence),
        tuple((at - began, cost) for at, cost in found.history),
        {"roadmaps": ready - began, "planning": planned - ready, "certificate": proved - planned},
    )


def deadline(began: float, seed: int, rounds: int | None, seconds: float | None, least: int = 1) -> float:
    """Until when by the monotonic clock planning may go on; ``least`` rounds make sense.

    Raises
    ------
    SceneError
        Rounds, seconds or seed make no sense.
    """
    if rounds is not None and (isinstance(rounds, bool) or not isinstance(rounds, int) or rounds < least):
        raise SceneError(f"rounds must be at least {least}, got {rounds}")
    if isinstance(seed, bool) or not isinstance(seed, int) or seed < 0:
        raise SceneError(f"seed must be at least 0, got {seed}")
    if seconds is not None and not seconds > 0:
        raise SceneError(f"seconds must be positive, got {seconds}")
    return math.inf if seconds is None else began + seconds


def certified(
    world: World,
    done: Round,
    planner: Mapping[str, object],
    objective: Objective = "sum_of_costs",
    proven: float | None = None,
    claims: Mapping[str, object] = MappingProxyType({}),
) -> tuple[Plan, Certificate]:
    """Return a round without failures as a plan that carries its certificate and bound, and the certificate.

    ``proven`` is a bound on this roadmap, where one was proven; without it the robots' ways on their own give one.
    """
    model, value = world.bound(objective)
    if proven is not None and proven > value:
        model, value = "roadmap", proven
    bound: dict[str, object] = {"model": model, "value": value}
    if objective != "sum_of_costs":
        bound["of"] = objective
    found = tuple(motion for motion in done.trajectories if motion is not None)
    certificate = certify(Plan(world.scene, found, planner, claims, bound))
    return Plan(world.scene, found, planner, claims, bound, certificate.as_dict()), certificate


def _in_company(world: World, done: Round, met: Sequence[tuple[Conflict, ...]]) -> tuple[str, ...]:
    """Why each robot is late in a team that stays in contact; "" if it is not."""
    late = [
        motion is not None and motion.arrival > soonest * (1 + 1e-9)
        for motion, soonest in zip(done.trajectories, world.soonest.tolist(), strict=True)
    ]
    return tuple(why_later(some) or ("stays in contact" if slow else "") for some, slow in zip(met, late, strict=True))


def _too_weak(certificate: Certificate) -> NoPlanFound:
    """Return the error for a plan that keeps contact, but not with the λ2 demanded."""
    problem = certificate.problems[0]
    return NoPlanFound(f"no plan found: {problem}", problem.robots, problem.time, problem.place)


def _silent(progress: Progress) -> None:
    """Tell nobody."""


def _check(
    method: str, order: str, objective: str, within: float, split: Sequence[str] | None, roadmap: str | Lanes
) -> None:
    for what, given, known in (
        ("method", method, METHODS),
        ("order", order, ORDERS),
        ("objective", objective, OBJECTIVES),
    ):
        if given not in known:
            raise SceneError(f"{what} {given!r} is not one of {', '.join(known)}")
    if split is not None and method != "mrppa":
        raise SceneError('split belongs to the method "mrppa"')
    if not isinstance(roadmap, Lanes) and roadmap not in WAYS:
        raise SceneError(f"roadmap {roadmap!r} is not one of {', '.join(WAYS)}, nor Lanes (see taut.load_roadmap)")
    if roadmap != "visibility" and method == "mrppa":
        raise SceneError('the method "mrppa" works on the visibility graph; leave roadmap out')
    if objective != "sum_of_costs" and method not in ("repair", "optimal"):
        raise SceneError(f'the objective {objective!r} belongs to the methods "repair" and "optimal"')
    if method == "search" and order != "shortest":
        raise SceneError('the method "search" finds an order itself; leave order out')
    if not 1.0 <= within < math.inf:
        raise SceneError(f"within must be a factor of at least 1, got {within}")
    if within != 1.0 and method != "optimal":
        raise SceneError('within belongs to the method "optimal"')


def _weight(method: str, weight: Weight | str | None) -> Weight:
    if weight is not None and method != "mrppa":
        raise SceneError('weight belongs to the method "mrppa"')
    if isinstance(weight, str):
        if weight not in WEIGHTS:
            raise SceneError(f"weight {weight!r} is not one of {', '.join(WEIGHTS)}")
        return WEIGHTS[weight]
    return WEIGHTS["one"] if weight is None else weight
