"""What a run tells: facts of every robot and of the team, who was stopped, and the scene as it stands at the end."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from taut.certificate._kernels import signed_distances
from taut.certificate.clearance import Shapes, shapes_of
from taut.contact import contact_of, contacts
from taut.contact.connectivity import least_fiedler, losses
from taut.control.coordination import dependencies, stopped_by
from taut.motion import Plan, Trajectory
from taut.scene import Robot, Scene
from taut.simulation.running import Nearest, Run

_ROOM = 1.0 - 2.0**-7  # obstacles grow by up to a thousandth too much at corners, and robots stand where they stand


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
    """Say of every robot that has not arrived why not, by name: it died, waits for one that did, or was too slow."""
    missing = [i for i in range(len(run.names)) if math.isnan(run.arrivals[i])]
    dead = {
        run.names[i]: float(run.progress[-1, i])
        for i in missing
        if run.disturbances.dies.get(run.names[i], math.inf) <= run.seconds
    }
    held = stopped_by(dependencies(run.plan), dead) if dead and run.coordinated else {}
    holders = _holders(run)
    out = {}
    for i in missing:
        name = run.names[i]
        if name in dead:
            out[name] = f"died at {run.disturbances.dies[name]:g} s"
        elif name in held and name in holders:
            out[name] = f"waits for {holders[name]}"
        elif name in held:
            out[name] = f"has to wait for {' and '.join(dead)}"
        elif name in holders:
            out[name] = f"still waits for {holders[name]}"
        else:
            out[name] = "did not come to its goal"
    return out


def scene_from(run: Run) -> Scene:
    """Return the scene as it stands at the end of a run, to plan on from there.

    Robots start where they stand, and those that died stay there; who has arrived starts where it stopped, a little
    beside its goal, and who has left is not there. Where a robot is nearer to an obstacle, or two robots to each other,
    than the scene asks, less is asked: of that robot alone, and of the gap.
    """
    scene = run.plan.scene
    shapes = shapes_of(scene)
    places = run.poses[-1, :, :2]
    robots = []
    for i, robot in enumerate(scene.robots):
        if not (math.isfinite(run.arrivals[i]) and not scene.stays(robot)):
            robots.append(_from_here(scene, shapes, robot, run, i))
    here = [run.names.index(robot.name) for robot in robots]
    gap = scene.gap
    for a, i in enumerate(here):
        for j in here[a + 1 :]:
            apart = math.dist(places[i], places[j]) - scene.robots[i].radius - scene.robots[j].radius
            if apart < gap:
                gap = max(apart * _ROOM, 0.0)
    return replace(scene, robots=tuple(robots), gap=gap)


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
        "contact": None if link is None else vars(link),
        "robots": robots,
    }


def _holders(run: Run) -> dict[str, str]:
    """Whom each robot waited for last, if it still did when nobody went on."""
    last = max((wait.end for wait in run.waits), default=0.0)
    return {wait.robot: wait.holder for wait in run.waits if wait.end >= last - run.dt}


def _from_here(scene: Scene, shapes: Shapes, robot: Robot, run: Run, i: int) -> Robot:
    x, y = run.poses[-1, i, :2].tolist()
    distance = float(
        signed_distances(x, y, shapes.edges, shapes.first, shapes.radius, shapes.kind).min(initial=math.inf)
    )
    asked = scene.growth(robot) - robot.radius
    room = max(distance * _ROOM - robot.radius, 0.0)
    died = run.disturbances.dies.get(robot.name, math.inf) <= run.seconds and math.isnan(run.arrivals[i])
    return replace(
        robot,
        start=(x, y),
        goal=(x, y) if died else robot.goal,
        clearance=room if room < asked else robot.clearance,
        start_time=max(robot.start_time - run.seconds, 0.0),
    )


def _nearest(nearest: Nearest) -> dict[str, Any] | None:
    return vars(nearest) if math.isfinite(nearest.distance) else None


def _number(value: float) -> float | None:
    return float(value) if math.isfinite(value) else None
