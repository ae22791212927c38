"""A plan for a map that has changed: whoever is not concerned keeps his motion, the others are planned anew."""

from __future__ import annotations

import time
from collections.abc import Mapping
from dataclasses import dataclass, replace

import numpy as np

from taut.certificate import Certificate, certify
from taut.contact import Contact, contact_of
from taut.errors import SceneError
from taut.motion import Plan, Trajectory
from taut.roadmap import Lanes
from taut.route import WAYS
from taut.scene import Robot, Scene
from taut.team.explaining import no_plan, no_plan_in_contact
from taut.team.in_contact import Together, joined, passes_in_contact, planned_together
from taut.team.methods import first_order
from taut.team.planning import certified, deadline
from taut.team.prioritized import MOST_ROUNDS, Round, plan_rounds
from taut.team.ties import Ties, ties_of
from taut.team.world import World
from taut.validation import validate

# passes over the robots concerned before those in their way are planned anew with them
_PATIENCE = 4


@dataclass(frozen=True, eq=False)
class Replanned:
    """What has become of a plan.

    Parameters
    ----------
    plan : for the changed scene; it carries its certificate.
    certificate : the proof.
    kept : names of the robots whose motions are those of the older plan, bit for bit.
    changed : the others by name, and why each could not keep its motion.
    notes : what was found remarkable in the scene.
    """

    plan: Plan
    certificate: Certificate
    kept: tuple[str, ...]
    changed: Mapping[str, str]
    notes: tuple[str, ...]


def replan(
    plan: Plan,
    scene: Scene,
    seed: int = 0,
    rounds: int | None = None,
    seconds: float | None = None,
    roadmap: str | Lanes | None = None,
) -> Replanned:
    """Keep of a plan what still holds in a changed scene and plan the other robots round that.

    Robots that are new or not what they were, and those of whom `certify` proves that their motions do not hold any
    more, are planned after the others, shortest way first. Where that fails, the robots in their way are planned anew
    with them, in the end all. A robot that would have a shorter way now keeps its motion, too. A team that stays in
    contact goes on to do so: if one robot has to be planned anew then all are, since each relies on others.

    Parameters
    ----------
    plan : the older plan.
    scene : the scene as it is now.
    seed, rounds, seconds : as in `taut.plan`; rounds are passes over the team.
    roadmap : as in `taut.plan`; None for that of the older plan, which a plan made on lanes does not hold.

    Raises
    ------
    SceneError, NoPath, NoPlanExists, NoPlanFound
        As `taut.plan`.

    >>> from dataclasses import replace
    >>> from taut import Rectangle, Robot, Scene, plan
    >>> hall = Scene((0, 0, 8, 8), robots=[Robot("R1", (1, 1), (7, 1)), Robot("R2", (1, 6), (7, 6))], gap=0.1)
    >>> replan(plan(hall).plan, replace(hall, obstacles=(Rectangle(3, 0, 1, 2, name="crate"),))).kept
    ('R2',)
    """
    began = time.monotonic()
    if not isinstance(plan, Plan):
        raise TypeError(f"replan wants a Plan and a Scene, not a {type(plan).__name__}; pass result.plan")
    until = deadline(began, seed, rounds, seconds)
    way = _way(plan, roadmap)
    notes = validate(scene)
    if not scene.robots:
        raise SceneError("no robots: nothing to plan; add at least one robot with name, start and goal")
    demand = _demand(plan)
    known, reasons = _known(plan, scene)
    reasons |= _broken(scene, known)
    if demand is not None:
        reasons |= _relying(scene, known, reasons, demand)
    ties = None if demand is None or not reasons else ties_of(scene, demand)
    world = World(scene, way, seed)
    most = MOST_ROUNDS if rounds is None else rounds
    if ties is None:
        best, done = _planned(world, known, reasons, seed, most, until)
        if best.failures:
            raise no_plan(world, best, done)
    else:
        best, done = _planned_in_contact(world, ties, seed, most, until)
    names = [robot.name for robot in scene.robots]
    kept = tuple(name for name in names if name not in reasons)
    planner = {
        "method": "replanned",
        "roadmap": way.source if isinstance(way, Lanes) else way,
        "kept": list(kept),
        "order": [names[i] for i in best.order],
        "seed": seed,
        "rounds": done,
        "seconds": round(time.monotonic() - began, 3),
    }
    claims = {} if demand is None else {"contact": demand.claim}
    final, certificate = certified(world, best, planner, claims=claims)
    return Replanned(final, certificate, kept, {name: reasons[name] for name in names if name in reasons}, notes)


def _way(plan: Plan, roadmap: str | Lanes | None) -> str | Lanes:
    """On what to plan."""
    if roadmap is None:
        known = plan.planner.get("roadmap", "visibility")
        if isinstance(known, str) and known in WAYS:
            return known
        raise SceneError(
            f"the plan was made on the roadmap {known!r}, which it does not hold; give the roadmap to replan"
        )
    if not isinstance(roadmap, Lanes) and roadmap not in WAYS:
        raise SceneError(f"roadmap {roadmap!r} is not one of {', '.join(WAYS)}, nor Lanes (see taut.load_roadmap)")
    return roadmap


def _known(plan: Plan, scene: Scene) -> tuple[dict[str, Trajectory], dict[str, str]]:
    """Motions of robots that are what they were, by name, and why the others are planned anew."""
    before = {robot.name: (robot, motion) for robot, motion in zip(plan.scene.robots, plan.trajectories, strict=True)}
    known, reasons = {}, {}
    for robot in scene.robots:
        if robot.name not in before:
            reasons[robot.name] = f"{robot.name} is new"
        elif (was := before[robot.name][0]) != robot or plan.scene.stays(was) != scene.stays(robot):
            reasons[robot.name] = f"{robot.name} is not what it was: {_differing(was, robot)}"
        else:
            known[robot.name] = before[robot.name][1]
    return known, reasons


def _demand(plan: Plan) -> Contact | None:
    claim = plan.claims.get("contact")
    if claim is None:
        return None
    if not isinstance(claim, Mapping):
        raise SceneError(f"contact: the plan's claim must be a mapping, got {claim!r}")
    return contact_of(claim)


def _relying(
    scene: Scene, known: Mapping[str, Trajectory], reasons: Mapping[str, str], demand: Contact
) -> dict[str, str]:
    """Why robots that could go on by themselves are planned anew in a team that stays in contact."""
    if not reasons:
        motions = tuple(known[robot.name] for robot in scene.robots)
        problems = [p for p in certify(Plan(scene, motions), contact=demand).problems if p.kind == "contact"]
        if not problems:
            return {}
        reasons = {}
        because = str(problems[0])
    else:
        because = f"{next(iter(reasons))} is planned anew"
    return {
        robot.name: f"{robot.name} stays in contact: {because}" for robot in scene.robots if robot.name not in reasons
    }


def _planned_in_contact(world: World, ties: Ties, seed: int, most: int, until: float) -> tuple[Round, int]:
    order = first_order(world.scene, world.shortest, "shortest")
    rng = np.random.default_rng(seed)

    def passes(part: World, here: Ties, left: float) -> Together:
        return passes_in_contact(part, here, order, rng, left, until)

    together = planned_together(world, ties, passes, most, until)
    if not together.found:
        raise no_plan_in_contact(world, together)
    return joined(world, together.stretches), together.passes


def _differing(was: Robot, robot: Robot) -> str:
    fields = [name for name in vars(robot) if getattr(was, name) != getattr(robot, name)]
    return ", ".join(fields) if fields else "at_goal"


def _broken(scene: Scene, known: Mapping[str, Trajectory]) -> dict[str, str]:
    """Robots whose motions do not hold in the scene, and what is wrong with them."""
    robots = tuple(robot for robot in scene.robots if robot.name in known)
    proof = certify(Plan(replace(scene, robots=robots), tuple(known[robot.name] for robot in robots)))
    reasons: dict[str, str] = {}
    for problem in proof.problems:
        for name in problem.robots:
            reasons.setdefault(name, str(problem))
    return reasons


def _planned(
    world: World, known: Mapping[str, Trajectory], reasons: dict[str, str], seed: int, most: int, until: float
) -> tuple[Round, int]:
    """Plan the robots that ``reasons`` names round the others; it grows by those that have to make way."""
    scene = world.scene
    numbers = {robot.name: i for i, robot in enumerate(scene.robots)}
    by_length = first_order(scene, world.shortest, "shortest")
    rng = np.random.default_rng(seed)
    done = 0
    while True:
        kept = {i: known[name] for name, i in numbers.items() if name not in reasons}
        order = [i for i in by_length if i not in kept]
        few = min(_PATIENCE, most - done) if kept else most - done
        best, passes = plan_rounds(world, order, rng, max(few, 1), until, kept=kept)
        done += passes
        if not best.failures or not kept or done >= most or time.monotonic() > until:
            return best, done
        blockers = {j: f.robot for f in best.failures for j in f.blockers if j in kept}
        if not blockers:
            failed = best.failures[0].robot
            blockers = dict.fromkeys(kept, failed)
        for j, i in blockers.items():
            reasons[scene.robots[j].name] = f"{scene.robots[j].name} makes way for {scene.robots[i].name}"
