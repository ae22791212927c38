"""What a run tells: facts of every robot and of the team, who was stopped, and the scene as it stands at the end."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence, Set
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from taut.certificate._kernels import signed_distances
from taut.certificate.clearance import Shapes, shapes_of
from taut.contact import contact_of, contacts
from taut.contact.connectivity import least_fiedler, losses
from taut.control.coordination import stopped_by
from taut.motion import Plan, Trajectory
from taut.scene import Circle, Robot, Scene
from taut.simulation.running import Nearest, Run, longest, waits_of

_ROOM = 1.0 - 2.0**-9  # obstacles grow by up to a thousandth too much at corners, and robots stand where they stand


@dataclass(frozen=True)
class Link:
    """How a team that follows a plan in contact kept together.

    Parameters
    ----------
    least, time : least λ2 of the driven motions, and when, seconds.
    lost : stretches of time without contact, (from, until) in seconds.
    """

    least: float
    time: float
    lost: tuple[tuple[float, float], ...]


def driven_plan(run: Run) -> Plan:
    """Return the motions as they were driven, as a plan: straight between the recorded instants.

    It claims nothing and is not certified; `taut.contacts` and figures take it as any plan.
    """
    paths = []
    for i, name in enumerate(run.names):
        stamps = np.column_stack([run.times, run.poses[:, i, :2]])
        paths.append(Trajectory(name, stamps))
    return Plan(run.plan.scene, tuple(paths), planner={"method": "simulation", "seed": run.seed})


def contact_kept(run: Run) -> Link | None:
    """Find how the driven motions kept the contact that the plan claims; None if it claims none."""
    claim = run.plan.claims.get("contact")
    if not isinstance(claim, Mapping) or not claim:
        return None
    demand = contact_of(claim)
    found = contacts(driven_plan(run), demand.reach, demand.sight)
    piece, least = least_fiedler(found)
    lost = tuple((float(begin), float(end)) for begin, end in losses(found))
    return Link(least, float(found.times[piece]), lost)


def stopped(run: Run) -> dict[str, str]:
    """Say of every robot that has not arrived why not, by name: it died, waits for another, was too slow or is lost."""
    missing = [i for i in range(len(run.names)) if math.isnan(run.arrivals[i])]
    lost = {
        run.names[i]: float(run.progress[-1, i])
        for i in missing
        if run.disturbances.dies.get(run.names[i], math.inf) <= run.seconds
    }
    held = stopped_by(waits_of(run.plan), lost) if lost and run.coordinated else {}
    holders = _holders(run)
    out = {}
    for i in missing:
        name = run.names[i]
        if name in lost:
            out[name] = f"died at {run.disturbances.dies[name]:g} s"
        elif name in held and name in holders:
            out[name] = f"waits for {holders[name]}"
        elif name in held:
            out[name] = f"has to wait for {' and '.join(lost)}"
        elif name in holders:
            out[name] = f"still waits for {holders[name]}"
        elif run.seconds >= longest(run.plan):
            out[name] = f"was too slow: on its way for {run.seconds:g} s"
        else:
            out[name] = "did not come to its goal"
    return out


def dead(run: Run) -> tuple[str, ...]:
    """Return the names of the robots that have died and are still there, in the scene's order."""
    scene, died = run.plan.scene, run.disturbances.dies
    return tuple(
        robot.name
        for i, robot in enumerate(scene.robots)
        if died.get(robot.name, math.inf) <= run.seconds and (scene.stays(robot) or math.isnan(run.arrivals[i]))
    )


def scene_from(run: Run) -> Scene:
    """Return the scene as it stands at the end of a run, to plan on from there.

    Robots start where they stand; who has arrived starts where it stopped, a little beside its goal, and who has left
    is not there. Who died is an obstacle: a circle with its name, as large as it takes to keep its radius and the gap
    from it, so that nobody plans to move it. Where a robot is nearer to an obstacle, or two robots to each other, than
    the scene asks, less is asked: of that robot alone, of the circle, and of the gap. Planning cannot go on for a robot
    that stands in another one or in an obstacle, nor for one whose goal is taken by a dead one; it says so.
    """
    scene = run.plan.scene
    places = run.poses[-1, :, :2].tolist()
    still = dead(run)
    here = [
        i
        for i, robot in enumerate(scene.robots)
        if robot.name not in still and not (math.isfinite(run.arrivals[i]) and not scene.stays(robot))
    ]
    known = {obstacle.name for obstacle in scene.obstacles}
    discs = [_disc_of(scene, places, here, run.names.index(name), known) for name in still]
    blocked = replace(scene, obstacles=(*scene.obstacles, *discs), robots=())
    shapes = shapes_of(blocked)
    robots = tuple(_from_here(scene, shapes, discs, run, i) for i in here)
    gap = scene.gap
    for a, i in enumerate(here):
        for j in here[a + 1 :]:
            apart = math.dist(places[i], places[j]) - scene.robots[i].radius - scene.robots[j].radius
            if apart < gap:
                gap = max(apart * _ROOM, 0.0)
    return replace(blocked, robots=robots, gap=gap)


def run_data(run: Run) -> dict[str, Any]:
    """Return all of a run but its motions as plain data: the team, and a list of its robots."""
    why = stopped(run)
    link = contact_kept(run)
    robots = []
    for i, name in enumerate(run.names):
        lost = {w.holder: 0.0 for w in run.waits if w.robot == name}
        for wait in run.waits:
            if wait.robot == name:
                lost[wait.holder] += wait.lost
        robots.append(
            {
                "name": name,
                "arrival": _number(run.arrivals[i]),
                "planned": run.plan.trajectories[i].arrival,
                "late": _number(run.delays[i]),
                "cross_track": float(run.greatest_stray[i]),
                "cross_track_rms": float(run.mean_stray[i]),
                "clearance": _nearest(run.clearances[i]),
                "separation": _nearest(run.separations[i]),
                "collisions": sum(name in (c.robot, c.other) for c in run.collisions),
                "distance": float(run.distance[i]),
                "turned": float(run.turned[i]),
                "energy": float(run.work[i]),
                "waited_for": lost,
                "stopped": why.get(name),
            }
        )
    return {
        "scene": run.plan.scene.name,
        "seed": run.seed,
        "dt": run.dt,
        "coordinated": run.coordinated,
        "disturbances": run.disturbances.as_dict(),
        "seconds": run.seconds,
        "planned": run.plan.makespan,
        "makespan": run.makespan if run.arrived else None,
        "arrived": int(np.isfinite(run.arrivals).sum()),
        "collisions": [vars(collision) for collision in run.collisions],
        "lost": sum(wait.lost for wait in run.waits),
        "stopped": why,
        "dead": list(dead(run)),
        "contact": None if link is None else vars(link),
        "robots": robots,
    }


def _holders(run: Run) -> dict[str, str]:
    """Whom each robot waited for last, if it still did when nobody went on."""
    last = max((wait.end for wait in run.waits), default=0.0)
    return {wait.robot: wait.holder for wait in run.waits if wait.end >= last - run.dt}


def _disc_of(scene: Scene, places: Sequence[Sequence[float]], here: Sequence[int], i: int, known: Set[str]) -> Circle:
    """Return the circle from which those that are here keep what they have to keep from robot i, where it stands."""
    robot = scene.robots[i]
    clear = min((scene.growth(scene.robots[j]) - scene.robots[j].radius for j in here), default=scene.clearance)
    radius = robot.radius + scene.gap - clear
    for j in here:
        radius = min(radius, math.dist(places[i], places[j]) * _ROOM - scene.robots[j].radius)
    # no smaller than that nobody runs into it; and no circle has no size
    radius = max(radius, robot.radius - clear, 2.0**10 * scene.tol)
    name = robot.name if robot.name not in known else f"{robot.name}, dead"
    return Circle((places[i][0], places[i][1]), radius, name)


def _from_here(scene: Scene, shapes: Shapes, discs: Sequence[Circle], run: Run, i: int) -> Robot:
    """Return robot i with the start where it stands, and the clearance that there is."""
    robot = scene.robots[i]
    x, y = run.poses[-1, i, :2].tolist()
    distances = signed_distances(x, y, shapes.edges, shapes.first, shapes.radius, shapes.kind)
    room = float(((distances + shapes.radius) * _ROOM - shapes.radius).min(initial=math.inf))
    for disc in discs:
        # a goal that the dead leave free: arcs about them must not take it
        to_goal = math.dist(robot.goal, disc.center)
        if to_goal >= disc.radius + scene.growth(robot):
            room = min(room, to_goal * _ROOM - disc.radius)
    room = max(room - robot.radius, 0.0)
    return replace(
        robot,
        start=(x, y),
        clearance=room if room < scene.growth(robot) - robot.radius else robot.clearance,
        start_time=max(robot.start_time - run.seconds, 0.0),
    )


def _nearest(nearest: Nearest) -> dict[str, Any] | None:
    return vars(nearest) if math.isfinite(nearest.distance) else None


def _number(value: float) -> float | None:
    return float(value) if math.isfinite(value) else None
