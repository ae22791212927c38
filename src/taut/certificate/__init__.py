"""Prove a plan from the scene and the plan alone, in closed form, sharing no code with the planners.

What is proved, all with the one tolerance ``tol = scene.tol`` (metres; for time ``tol / speed``): every robot begins at
its start, waits for its start time, ends at its goal and keeps its top speed; any two discs keep the gap at every
instant (and, with headway, between shifted instants); every robot keeps its clearance from obstacles and wall;
robots that may touch obstacles nowhere pass through them, their seams or their touching points; and, where that is
demanded or claimed, the team keeps in contact at every instant.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import fields

import numpy as np

from taut.certificate.clearance import check_clearance, shapes_of
from taut.certificate.crossing import check_crossing
from taut.certificate.report import KINDS, Certificate, Clearance, ContactProof, Problem, Separation
from taut.certificate.separation import check_separation
from taut.certificate.tracks import tracks_of
from taut.contact import Contact, contact_of
from taut.errors import SceneError
from taut.motion import Plan
from taut.scene import Scene
from taut.validation import check_form

__all__ = ["Certificate", "Clearance", "ContactProof", "Problem", "Separation", "certify"]


def certify(plan: Plan, scene: Scene | None = None, contact: Contact | float | None = None) -> Certificate:
    """Prove that a plan holds, or say who breaks which rule, where, when and by how much.

    Parameters
    ----------
    plan : a motion for every robot. Radius, speed, start time and what happens at the goal are the scene's.
    scene : the scene the plan has to be for, if it is not simply taken at its word; a plan for another scene is a
        problem, and the rest is then proved for the plan's own scene.
    contact : what is demanded of the team's contact; a number is a range in metres. None demands what the plan claims;
        a claim is proved in any case.

    Returns
    -------
    Certificate
        ``ok`` if there are no problems; the least separation and clearances are there in any case.

    Raises
    ------
    SceneError
        A ``contact`` that makes no sense.

    Notes
    -----
    Time O(pairs · stamps + legs · obstacles). A leaving robot is present on [0, T), T its arrival; one that never
    moves is then never present. Distances are exact to rounding, about a thousandth of tol. Contact: see `contacts`;
    a robot that has left is no more missed, and one robot is always in contact.

    Examples
    --------
    >>> from taut.motion import Trajectory
    >>> from taut.scene import Robot
    >>> scene = Scene((0, 0, 4, 4), robots=[Robot("R1", (1, 1), (3, 1), radius=0.5)])
    >>> certify(Plan(scene, (Trajectory("R1", [[0, 1, 1], [2, 3, 1]]),))).ok
    True
    >>> print(certify(Plan(scene, (Trajectory("R1", [[0, 1, 1], [1, 3, 1]]),))).problems[0])
    R1 moves 1 m farther in one leg than its top speed allows at t = 0 s near (1, 1)
    """
    own = plan.scene
    demanded = contact if contact is None or isinstance(contact, Contact) else Contact(contact)
    tracks, shapes = tracks_of(plan), shapes_of(own)
    claimed, unproved = _claims(plan)
    problems = [*_form(own), *_scene(own, scene), *unproved, *_ends(plan)]
    ratio, fast = _speed(plan)
    separation, near = check_separation(own, tracks)
    clearances, close = check_clearance(own, tracks, shapes)
    problems += [*fast, *near, *close, *check_crossing(own, tracks, shapes)]
    proof = None
    for demand in dict.fromkeys(d for d in (claimed, demanded) if d is not None):
        from taut.certificate.contact import check_contact  # here, as few plans need the eigenvalue solvers

        proof, parted = check_contact(plan, demand, shapes)
        problems += [problem for problem in parted if problem not in problems]
    problems.sort(key=lambda problem: KINDS.index(problem.kind))
    return Certificate(own.tol, separation, clearances, ratio, tuple(problems), proof)


def _form(own: Scene) -> list[Problem]:
    try:
        check_form(own)
    except SceneError as error:
        return [Problem("scene", detail=error.message)]
    return []


def _scene(own: Scene, given: Scene | None) -> list[Problem]:
    if given is None or given == own:
        return []
    differ = [f.name for f in fields(Scene) if getattr(own, f.name) != getattr(given, f.name)]
    return [Problem("scene", detail=f"the plan is for another scene: {', '.join(differ)} differ")]


def _claims(plan: Plan) -> tuple[Contact | None, list[Problem]]:
    """The contact that the plan claims, and a problem for each claim that cannot be proved."""
    claimed, problems = None, []
    for name, value in sorted(plan.claims.items()):
        if value is None or (isinstance(value, Mapping | list | tuple | str) and not value):
            continue
        if name != "contact" or not isinstance(value, Mapping):
            detail = f"the plan claims {name} = {value!r}, which this version cannot prove"
            problems.append(Problem("claim", detail=detail))
            continue
        try:
            claimed = contact_of(value)
        except SceneError as error:
            problems.append(Problem("claim", detail=f"the plan claims {name} = {value!r}: {error.message}"))
    return claimed, problems


def _ends(plan: Plan) -> list[Problem]:
    """Start, start time and goal of each robot."""
    tol = plan.scene.tol
    problems = []
    for robot, path in zip(plan.scene.robots, plan.trajectories, strict=True):
        here = (robot.name,)
        for kind, stamp, wanted in (("start", path.stamps[0], robot.start), ("goal", path.stamps[-1], robot.goal)):
            off = float(np.hypot(stamp[1] - wanted[0], stamp[2] - wanted[1]))
            if not off <= tol:
                problems.append(Problem(kind, here, off, float(stamp[0]), (float(stamp[1]), float(stamp[2]))))
        early = np.append(path.times[path.times < robot.start_time], robot.start_time)
        moved = np.hypot(*(path.at(early) - path.points[0]).T)
        worst = int(np.argmax(moved))
        if not moved[worst] <= tol:
            x, y = path.at(early[worst])
            detail = f"which is {robot.start_time:.9g} s"
            problems.append(
                Problem(
                    "start_time", here, float(moved[worst]), float(early[worst]), (float(x), float(y)), detail=detail
                )
            )
    return problems


def _speed(plan: Plan) -> tuple[float, list[Problem]]:
    """Greatest speed ratio, and the leg of each robot that is too long for its time."""
    tol = plan.scene.tol
    greatest, problems = 0.0, []
    for robot, path in zip(plan.scene.robots, plan.trajectories, strict=True):
        if len(path.times) < 2:
            continue
        with np.errstate(over="ignore", divide="ignore", invalid="ignore"):
            length = np.hypot(*np.diff(path.points, axis=0).T)
            allowed = robot.speed * np.diff(path.times)
            excess = length - allowed
            moving = length > 0
            greatest = max(greatest, float((length[moving] / allowed[moving]).max(initial=0.0)))
        k = int(np.argmax(excess))
        if not excess[k] <= tol:
            t, x, y = path.stamps[k].tolist()
            problems.append(Problem("speed", (robot.name,), float(excess[k]), t, (x, y)))
    return greatest, problems
