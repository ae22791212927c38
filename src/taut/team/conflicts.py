"""Conflicts: whom a robot would have met on its shortest way, where, when and how, and what it did instead."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Literal, NamedTuple, TypeAlias

import numpy as np

from taut.motion import Trajectory
from taut.scene import Point
from taut.team import _kernels
from taut.team._kernels import Floats
from taut.team.prioritized import Round
from taut.team.reservations import Reservations, distances_from
from taut.team.world import World

Kind: TypeAlias = Literal[
    "crossroads", "head-on", "catching up", "crossing in the open", "standing", "passed over", "held start"
]

#: Robots whose directions differ by less than 30° follow each other; by more than 150° they come head-on.
_ALONG = math.cos(math.radians(30))


@dataclass(frozen=True)
class Conflict:
    """A meeting that a robot avoided.

    Parameters
    ----------
    robot, other : names; ``robot`` was planned later and gave way.
    kind : "head-on" or "catching up" within 30° of one line; else "crossroads" if both ways have a vertex there, and
        "crossing in the open" if not; "standing" where the other one rests; "passed over" where the other one passes
        over the robot's own start or goal while it stands there; "held start" where a robot not planned yet stood.
    time, place : when and where ``robot`` would have been when the two were nearest, seconds and metres.
    resolution : "wait" if it still passes that place, later; "another way" if it does not.
    delay : seconds by which it passes there later; 0 with another way.
    """

    robot: str
    other: str
    kind: Kind
    time: float
    place: Point
    resolution: Literal["wait", "another way"]
    delay: float


class _Piece(NamedTuple):
    """A straight move or rest: from a at time t0 to b at time t1."""

    a: Floats
    b: Floats
    t0: float
    t1: float

    @property
    def velocity(self) -> Floats:
        rests = math.isinf(self.t1) or (self.a == self.b).all()
        return np.zeros(2) if rests else np.asarray((self.b - self.a) / (self.t1 - self.t0))

    def at(self, time: float) -> Floats:
        return np.asarray(self.a + self.velocity * (min(max(time, self.t0), self.t1) - self.t0))


class _Meeting(NamedTuple):
    """Two robots too near each other from ``since`` to ``until``; ``away`` metres apart when nearest."""

    since: float
    until: float
    kind: Kind
    time: float
    place: Point
    away: float


def conflicts_met(world: World, done: Round) -> tuple[tuple[Conflict, ...], ...]:
    """Per robot of the scene, what it met when it was planned, in the order of time.

    The pass is gone through again: each robot's shortest way at top speed against those planned before it and the
    starts that were still held. Robots that got that way unhindered met nobody.
    """
    scene = world.scene
    reservations = Reservations(scene, world.cell, world.horizon)
    for i in done.order:
        reservations.hold_start(i, scene.robots[i].start_time + done.hold)
    met: list[tuple[Conflict, ...]] = [()] * len(scene.robots)
    planned: set[int] = set()
    for i in done.order:
        trajectory = done.trajectories[i]
        if trajectory is None:
            continue
        if _hindered(world, i, trajectory):
            met[i] = _conflicts_of(world, i, trajectory, reservations, planned)
        reservations.take(i, trajectory)
        planned.add(i)
    return tuple(met)


def why_later(conflicts: tuple[Conflict, ...]) -> str:
    """Say in a few words to whom a robot gave way; "" if to nobody."""
    known = [c for c in conflicts if c.kind != "held start"]
    if not conflicts:
        return ""
    if not known:
        return "gives way to starts held for robots planned later"
    first, others = known[0], {c.other for c in known} - {known[0].other}
    x, y = first.place
    more = f" and {len(others)} more" if others else ""
    return f"gives way to {first.other} near ({x:.2f}, {y:.2f}) at {first.time:.2f} s{more}"


def _hindered(world: World, i: int, trajectory: Trajectory) -> bool:
    robot, route = world.scene.robots[i], world.routes[i]
    earliest = robot.start_time + route.length / robot.speed if len(route.points) > 1 else 0.0
    return trajectory.arrival - earliest > 1e-9 * max(1.0, earliest) or trajectory.length - route.length > 1e-9 * max(
        1.0, route.length
    )


def _conflicts_of(
    world: World, i: int, trajectory: Trajectory, reservations: Reservations, planned: set[int]
) -> tuple[Conflict, ...]:
    scene = world.scene
    out = []
    for other, meetings in _meetings(world, i, reservations).items():
        for meeting in _merged(meetings):
            passes = _passes(trajectory, meeting.place, scene.tol)
            out.append(
                Conflict(
                    scene.robots[i].name,
                    scene.robots[other].name,
                    meeting.kind if other in planned else "held start",
                    meeting.time,
                    meeting.place,
                    "another way" if passes is None else "wait",
                    0.0 if passes is None else max(0.0, passes - meeting.time),
                )
            )
    return tuple(sorted(out, key=lambda c: (c.time, c.other)))


def _meetings(world: World, i: int, reservations: Reservations) -> dict[int, list[_Meeting]]:
    """Meetings of robot i, alone on its shortest way at top speed, with each of the robots reserved."""
    scene, robot, points = world.scene, world.scene.robots[i], world.routes[i].points
    legs, robots, radii, *_ = arrays = reservations.arrays
    found: list[tuple[int, _Piece]] = []
    tau = np.hypot(*np.diff(points, axis=0).T) / robot.speed
    times = robot.start_time + np.append(0.0, np.cumsum(tau))
    edges = [
        _Piece(a, b, t0, t1)
        for a, b, t0, t1 in zip(points, points[1:], times.tolist(), times[1:].tolist(), strict=False)
    ]
    if edges:
        kernel = _kernels.blockers(np.ascontiguousarray(points), tau, times[:-1], arrays, i, world.body(i))
        found += [(leg, edges[k]) for leg, k in zip(*(x.tolist() for x in kernel), strict=True)]
    rests = [_Piece(points[0], points[0], 0.0, robot.start_time)] if edges else []
    if scene.stays(robot):
        rests.append(_Piece(points[-1], points[-1], float(times[-1]) if edges else 0.0, math.inf))
    reach = robot.radius + radii + scene.gap - scene.tol / 2
    for rest in rests:
        near = (distances_from(legs, rest.a) < reach) & (legs[:, 2] <= rest.t1) & (legs[:, 5] >= rest.t0)
        found += [(leg, rest) for leg in np.flatnonzero(near & (robots != i) & (robots >= 0)).tolist()]
    out: dict[int, list[_Meeting]] = {}
    for leg, mine in found:
        x0, y0, t0, x1, y1, t1 = legs[leg].tolist()
        theirs = _Piece(np.array([x0, y0]), np.array([x1, y1]), t0, t1)
        meeting = _meeting(mine, theirs, float(reach[leg]), scene.headway)
        if meeting is not None:
            out.setdefault(int(robots[leg]), []).append(meeting)
    return out


def _meeting(mine: _Piece, theirs: _Piece, reach: float, headway: float) -> _Meeting | None:
    """When the two are within ``reach``, and nearest; None if never while both pieces last, give or take a headway."""
    begin, end = max(mine.t0, theirs.t0), min(mine.t1, theirs.t1)
    if begin > end + headway:
        return None
    end = max(begin, end)
    velocity = mine.velocity - theirs.velocity
    apart = mine.at(begin) - theirs.at(begin)
    square, dot = float(velocity @ velocity), float(apart @ velocity)
    least = begin - dot / square if square > 0 else begin
    time = min(max(least, begin), end)
    away = math.hypot(*(mine.at(time) - theirs.at(time)))
    if away >= reach and headway == 0:
        return None
    since, until = begin, end
    if square > 0:
        missed = apart + velocity * (least - begin)
        half = math.sqrt(max(0.0, reach * reach - float(missed @ missed)) / square)
        since, until = max(begin, least - half), min(end, least + half)
    x, y = mine.at(time).tolist()
    return _Meeting(since, until, _kind(mine, theirs), time, (x, y), away)


def _merged(meetings: list[_Meeting]) -> list[_Meeting]:
    """One meeting for those without a break between: of the kind of the first, at the nearest approach."""
    out: list[_Meeting] = []
    for meeting in sorted(meetings, key=lambda m: (m.since, m.time)):
        last = out[-1] if out else None
        if last is None or meeting.since > last.until + 1e-9 * max(1.0, abs(last.until)):
            out.append(meeting)
            continue
        nearest = meeting if meeting.away < last.away else last
        out[-1] = nearest._replace(since=last.since, until=max(last.until, meeting.until), kind=last.kind)
    return out


def _kind(mine: _Piece, theirs: _Piece) -> Kind:
    v, w = mine.velocity, theirs.velocity
    if not v.any():
        return "passed over"
    if not w.any():
        return "standing"
    speeds = math.hypot(*v) * math.hypot(*w)
    along = float(v @ w) / speeds
    if along > _ALONG:
        return "catching up"
    if along < -_ALONG:
        return "head-on"
    common = any((p == q).all() for p in (mine.a, mine.b) for q in (theirs.a, theirs.b))
    return "crossroads" if common else "crossing in the open"


def _passes(trajectory: Trajectory, place: Point, tol: float) -> float | None:
    """When the robot, on a move, is within ``tol`` metres of the place for the last time; None if never."""
    stamps = trajectory.stamps
    here = np.array(place)
    for (t0, *a), (t1, *b) in zip(stamps[-2::-1].tolist(), stamps[:0:-1].tolist(), strict=True):
        piece = _Piece(np.array(a), np.array(b), t0, t1)
        v = piece.velocity
        square = float(v @ v)
        if square == 0:
            continue
        t: float = min(max(t0 + float((here - piece.a) @ v) / square, t0), t1)
        if math.hypot(*(piece.at(t) - here)) <= tol:
            return t
    return 0.0 if len(stamps) == 1 and math.dist(stamps[0, 1:], place) <= tol else None
