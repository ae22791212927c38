"""Leader-follower travel: a team in formation that contracts in narrow places and recovers after them."""

from __future__ import annotations

import math
import time
from dataclasses import dataclass, replace
from itertools import groupby

import numpy as np

from taut.certificate import Certificate, certify
from taut.contact.demand import Contact
from taut.errors import NoPlanFound, SceneError
from taut.formation.linking import first_loss, moved
from taut.formation.parts import Part, parts_of
from taut.formation.shape import Shape, shape_of
from taut.motion import Plan, Trajectory
from taut.scene import FloatArray, Scene


@dataclass(frozen=True)
class Narrow:
    """A stretch of time in which the team was out of its formation.

    Parameters
    ----------
    begin, end : seconds.
    scale : the least scale; 0 in a column.
    order : names in the order in which they went through in a column; empty where the formation was only scaled.
    place : (x, y) metres, the leader's where the scale is least, or the narrow place of a column.
    """

    begin: float
    end: float
    scale: float
    order: tuple[str, ...]
    place: tuple[float, float]


@dataclass(frozen=True, eq=False)
class Formed:
    """What travel in formation gives.

    Parameters
    ----------
    plan : the timed motions; it carries its certificate.
    certificate : the proof.
    leader : name.
    times : (m,) seconds, ascending, every instant at which a leg of anybody ends.
    scales : (m,) how large the formation is, 1 for full size, 0 in a column; linear in between except into columns.
    errors : (m,) metres, greatest distance of a robot from the leader plus its offset; nowhere more in between.
    narrow : where the team was out of its formation, in the order of time.
    """

    plan: Plan
    certificate: Certificate
    leader: str
    times: FloatArray
    scales: FloatArray
    errors: FloatArray
    narrow: tuple[Narrow, ...]


def travel(
    scene: Scene, leader: str | None = None, contact: Contact | float | None = None, keep: float = 2.0
) -> Formed:
    """Lead a team in formation from its starts to its goals and certify the plan.

    The formation is that of the starts; it does not turn. It keeps its full size wherever that is worth the way, is
    scaled down about the leader where that gets it through, and else its robots go one behind the other.

    Parameters
    ----------
    scene : its starts are the leader's start plus the offsets, its goals the leader's goal plus the same; see
        `in_formation`. Nobody sets out before the last start time.
    leader : name; the first robot by default.
    contact : the demand, or metres, that the team stays connected.
    keep : how many metres of detour a metre in a column is worth; 0 takes the fastest way. At scale c it is 1 − c
        times as many.

    Raises
    ------
    SceneError
        Goals that are not the formation of the starts; a formation that has not the contact demanded; and whatever
        `taut.validation.validate` finds.
    NoPath
        A robot cannot reach its goal, even alone.
    NoPlanFound
        The team does not get through; names the narrowest place, its width and what it lies between.

    Notes
    -----
    Not optimal: scales are some levels, a column begins and ends at stations along a shortest way. What is exact is
    the way at one level, a shortest one of the formation as a rigid body. Time: a triangulation of the map for each
    level and robot that goes in a column.

    >>> from taut.formation import in_formation
    >>> from taut.scene import Robot
    >>> team = [Robot("A", (2, 2), (6, 2), radius=0.2), Robot("B", (0, 0), (0, 0), radius=0.2)]
    >>> formed = travel(in_formation(Scene((0, 0, 8, 4), robots=team), {"B": (-1, 1)}))
    >>> formed.certificate.ok, formed.plan.makespan, float(formed.errors.max())
    (True, 4.0, 0.0)
    """
    began = time.monotonic()
    if isinstance(keep, bool) or not isinstance(keep, int | float) or not 0 <= keep < math.inf:
        raise SceneError(f"keep must be a number of metres of at least 0, got {keep!r}")
    shape = shape_of(scene, leader)
    demand = _demand(shape, contact)
    for robot, space in zip(scene.robots, shape.spaces, strict=True):
        space.require(robot)
    parts = parts_of(shape, demand, float(keep))
    name = scene.robots[shape.leader].name
    planner = {
        "method": "formation",
        "leader": name,
        "offsets": {r.name: offset for r, offset in zip(scene.robots, shape.offsets.tolist(), strict=True)},
        "keep": float(keep),
        "seconds": round(time.monotonic() - began, 3),
    }
    return _formed(shape, parts, planner, demand)


def _demand(shape: Shape, contact: Contact | float | None) -> Contact | None:
    """Return the demand, if there is any that the formation meets.

    Raises
    ------
    SceneError
        It does not, or robots leave.
    """
    if contact is None:
        return None
    demand = contact if isinstance(contact, Contact) else Contact(contact)
    scene = shape.scene
    for robot in scene.robots:
        if not scene.stays(robot):
            raise SceneError(f"contact needs robots that stay, but {robot.name} leaves from its goal; let it stay")
    standing = np.array([[robot.start for robot in scene.robots]], dtype=np.float64)
    if first_loss(moved(scene, np.zeros(1), standing), demand) is not None:
        asked = ", ".join(f"{key} {value}" for key, value in demand.claim.items())
        raise SceneError(f"contact: the formation itself does not have what is demanded ({asked}); set robots nearer")
    return demand


def _formed(shape: Shape, parts: list[Part], planner: dict[str, object], demand: Contact | None) -> Formed:
    """Put parts together, make plan and certificate, and look back on them."""
    scene = shape.scene
    wait = max(robot.start_time for robot in scene.robots)
    starts, goals = (np.array([getattr(r, end) for r in scene.robots], dtype=np.float64) for end in ("start", "goal"))
    times, places, scales = [np.zeros(1)], [starts[None]], [np.ones(1)]
    if parts and wait > 0:
        times.append(np.array([wait]))
        places.append(starts[None])
        scales.append(np.ones(1))
    narrow: list[Narrow] = []
    for part in parts:
        at = times[-1][-1] + part.seconds
        narrow += _narrow(shape, part, at)
        times.append(at[1:])
        places.append(part.places[1:])
        scales.append(part.scales[1:])
    t, where, scale = np.concatenate(times), np.concatenate(places), np.concatenate(scales)
    where[-1] = goals
    error = np.hypot(*np.moveaxis(where - where[:, shape.leader, None] - shape.offsets, 2, 0)).max(axis=1)
    trajectories = tuple(
        Trajectory(robot.name, _sparse(np.column_stack([t, where[:, i]]), scene.tol / 16))
        for i, robot in enumerate(scene.robots)
    )
    claims = {} if demand is None else {"contact": demand.claim}
    bare = Plan(scene, trajectories, planner, claims)
    certificate = certify(bare)
    if not certificate.ok:
        problem = certificate.problems[0]
        raise NoPlanFound(f"travel in formation: {problem}", problem.robots, problem.time, problem.place)
    plan = replace(bare, certificate=certificate.as_dict())
    return Formed(plan, certificate, scene.robots[shape.leader].name, t, scale, error, tuple(narrow))


def _narrow(shape: Shape, part: Part, times: FloatArray) -> list[Narrow]:
    """Where a part is out of formation."""
    if part.middle is not None:
        order = tuple(shape.scene.robots[i].name for i in part.order)
        x, y = part.middle.tolist()
        return [Narrow(float(times[0]), float(times[-1]), 0.0, order, (x, y))]
    out = []
    for small, group in groupby(range(len(times)), key=lambda k: part.scales[k] < 1.0):
        own = list(group)
        if small:
            first, last = max(own[0] - 1, 0), min(own[-1] + 1, len(times) - 1)
            least = own[int(np.argmin(part.scales[own]))]
            x, y = part.places[least, shape.leader].tolist()
            out.append(Narrow(float(times[first]), float(times[last]), float(part.scales[least]), (), (x, y)))
    return out


def _sparse(stamps: FloatArray, error: float) -> FloatArray:
    """Stamps (k, 3) without those that steady motion between the others passes, but for an error in metres."""
    kept = [0]
    for k in range(2, len(stamps)):
        own = stamps[kept[-1] : k + 1]
        share = (own[:, 0] - own[0, 0]) / (own[-1, 0] - own[0, 0])
        off = own[0, 1:] + share[:, None] * (own[-1, 1:] - own[0, 1:]) - own[:, 1:]
        if np.abs(off).max() > error:
            kept.append(k - 1)
    if (stamps[kept[-1], 1:] != stamps[-1, 1:]).any():
        kept.append(len(stamps) - 1)
    return stamps[kept]
