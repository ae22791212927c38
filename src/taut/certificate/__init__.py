"""Prove a plan from the scene and the plan alone, in closed form, sharing no code with the planners.

What is proved, all with the one tolerance ``tol = scene.tol`` (metres; for time ``tol / speed``): every robot begins at
its start, waits for its start time, ends at its goal and keeps its top speed; any two discs keep the gap at every
instant (and, with headway, between shifted instants); every robot keeps its clearance from obstacles and wall; and
robots that may touch obstacles nowhere pass through them, their seams or their touching points.
"""

from __future__ import annotations

from dataclasses import fields

import numpy as np

from taut.certificate.clearance import check_clearance, shapes_of
from taut.certificate.crossing import check_crossing
from taut.certificate.report import KINDS, Certificate, Clearance, Problem, Separation
from taut.certificate.separation import check_separation
from taut.certificate.tracks import tracks_of
from taut.errors import SceneError
from taut.motion import Plan
from taut.scene import Scene
from taut.validation import check_form

__all__ = ["Certificate", "Clearance", "Problem", "Separation", "certify"]


def certify(plan: Plan, scene: Scene | None = None) -> Certificate:
    """Prove that a plan holds, or say who breaks which rule, where, when and by how much.

    Parameters
    ----------
    plan : a motion for every robot. Radius, speed, start time and what happens at the goal are the scene's.
    scene : the scene the plan has to be for, if it is not simply taken at its word; a plan for another scene is a
        problem, and the rest is then proved for the plan's own scene.

    Returns
    -------
    Certificate
        ``ok`` if there are no problems; the least separation and clearances are there in any case.

    Notes
    -----
    Time O(pairs · stamps + legs · obstacles). A leaving robot is present on [0, T), T its arrival; one that never
    moves is then never present. Distances are exact to rounding, about a thousandth of tol.

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
    tracks, shapes = tracks_of(plan), shapes_of(own)
    problems = [*_form(own), *_scene(own, scene), *_claims(plan), *_ends(plan)]
    ratio, fast = _speed(plan)
    separation, near = check_separation(own, tracks)
    clearances, close = check_clearance(own, tracks, shapes)
    problems += [*fast, *near, *close, *check_crossing(own, tracks, shapes)]
    problems.sort(key=lambda problem: KINDS.index(problem.kind))
    return Certificate(own.tol, separation, clearances, ratio, tuple(problems))


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


def _claims(plan: Plan) -> list[Problem]:
    return [
        Problem("claim", detail=f"the plan claims {name} = {value!r}, which this version cannot prove")
        for name, value in sorted(plan.claims.items())
        if not (value is None or (isinstance(value, dict | list | tuple | str) and not value))
    ]


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
