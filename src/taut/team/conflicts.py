"""Conflicts: whom a robot would have met on its shortest way, where, when and how, and what it did instead."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Literal, NamedTuple, TypeAlias

import numpy as np

from taut.motion import Trajectory
from taut.scene import Point
from taut.team import _asking_kernels
from taut.team._table_kernels import Table
from taut.team.prioritized import Round
from taut.team.reservations import distances_from, empty_table, legs_of, reserve
from taut.team.world import World

Kind: TypeAlias = Literal[
    "crossroads", "head-on", "catching up", "crossing in the open", "standing", "passed over", "held start"
]

#: Robots whose directions differ by less than 30° follow each other; by more than 150° they come head-on.
_ALONG = math.cos(math.radians(30))
_GOLDEN = (math.sqrt(5) - 1) / 2


@dataclass(frozen=True)
class Conflict:
    """A meeting that a robot avoided.

    Parameters
    ----------
    robot, other : names; ``robot`` was planned later and gave way.
    kind : of the two motions at ``time``. "head-on" or "catching up" within 30° of one line; else "crossroads" if both
        straight moves have an end in common, and "crossing in the open" if not. "standing" where the other one rests;
        "passed over" where the other one passes over the robot's own start or goal while it stands there; "held start"
        where a robot not planned yet stood.
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
    """A straight move or rest: from (x, y) at time t0 with velocity (vx, vy) until t1."""

    x: float
    y: float
    t0: float
    t1: float
    vx: float
    vy: float

    def at(self, time: float) -> Point:
        since = min(max(time, self.t0), self.t1) - self.t0
        return (self.x + self.vx * since, self.y + self.vy * since) if since else (self.x, self.y)


def _piece(a: Sequence[float], t0: float, b: Sequence[float], t1: float) -> _Piece:
    (x0, y0), (x1, y1) = a, b
    if math.isinf(t1) or t1 <= t0:
        return _Piece(x0, y0, t0, t1, 0.0, 0.0)
    return _Piece(x0, y0, t0, t1, (x1 - x0) / (t1 - t0), (y1 - y0) / (t1 - t0))


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
    table = empty_table(scene, world.cell, world.horizon)
    for i in done.order:
        x, y = scene.robots[i].start
        hold = np.array([[x, y, 0.0, x, y, scene.robots[i].start_time + done.hold]])
        table = reserve(table, i, scene.robots[i].radius, hold)
    met: list[tuple[Conflict, ...]] = [()] * len(scene.robots)
    planned: set[int] = set()
    for i in done.order:
        trajectory = done.trajectories[i]
        if trajectory is None:
            continue
        if _hindered(world, i, trajectory):
            met[i] = _conflicts_of(world, i, trajectory, table, planned)
        legs = legs_of(trajectory, scene.stays(scene.robots[i]))
        table = reserve(table, i, scene.robots[i].radius, legs)
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
    route, earliest = world.routes[i], float(world.soonest[i])
    return trajectory.arrival - earliest > 1e-9 * max(1.0, earliest) or trajectory.length - route.length > 1e-9 * max(
        1.0, route.length
    )


def _conflicts_of(
    world: World, i: int, trajectory: Trajectory, table: Table, planned: set[int]
) -> tuple[Conflict, ...]:
    scene = world.scene
    out = []
    for other, meetings in _meetings(world, i, table).items():
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


def _meetings(world: World, i: int, table: Table) -> dict[int, list[_Meeting]]:
    """Meetings of robot i, alone on its shortest way at top speed, with each of the robots reserved."""
    scene, robot, points = world.scene, world.scene.robots[i], world.routes[i].points
    taken = np.flatnonzero((table.robot >= 0) & (table.robot != i))
    legs, robots, radii = table.legs[taken], table.robot[taken], table.radius[taken]
    number = np.full(len(table.robot), -1)
    number[taken] = np.arange(len(taken))
    found: list[tuple[int, _Piece]] = []
    tau = np.hypot(*np.diff(points, axis=0).T) / robot.speed
    # on lanes with speed limits it is as late as these make it, spread over its way
    tau *= (world.soonest[i] - robot.start_time) / max(float(tau.sum()), 1e-300) if len(tau) else 1.0
    times = robot.start_time + np.append(0.0, np.cumsum(tau))
    edges = [
        _piece(a, t0, b, t1)
        for a, b, t0, t1 in zip(points.tolist(), points[1:].tolist(), times.tolist(), times[1:].tolist(), strict=False)
    ]
    if edges:
        radius, gap, headway = world.body(i).tolist()
        way = np.ascontiguousarray(points)
        met, along = _asking_kernels.legs_met(table, way, tau, times[:-1], i, radius + gap, headway)
        found += [(leg, edges[k]) for leg, k in zip(number[met].tolist(), along.tolist(), strict=True)]
    start, goal = points[0].tolist(), points[-1].tolist()
    rests = [_piece(start, 0.0, start, robot.start_time)] if edges else []
    if scene.stays(robot):
        rests.append(_piece(goal, float(times[-1]) if edges else 0.0, goal, math.inf))
    reach = robot.radius + radii + scene.gap - scene.tol / 2
    for rest in rests:
        near = (distances_from(legs, np.array([rest.x, rest.y])) < reach) & (legs[:, 2] <= rest.t1)
        near &= legs[:, 5] >= rest.t0
        found += [(leg, rest) for leg in np.flatnonzero(near).tolist()]
    out: dict[int, list[_Meeting]] = {}
    for leg, mine in found:
        x0, y0, t0, x1, y1, t1 = legs[leg].tolist()
        meeting = _meeting(mine, _piece((x0, y0), t0, (x1, y1), t1), float(reach[leg]), scene.headway)
        if meeting is not None:
            out.setdefault(int(robots[leg]), []).append(meeting)
    return out


def _meeting(mine: _Piece, theirs: _Piece, reach: float, headway: float) -> _Meeting | None:
    """When the first is within ``reach`` of where the second is within a headway of that time; None if never."""
    begin, end = max(mine.t0, theirs.t0 - headway), min(mine.t1, theirs.t1 + headway)
    if begin > end:
        return None
    if math.isinf(end):  # both rest at last
        end = max(begin, mine.t0, theirs.t0 + headway)

    def away(time: float) -> float:
        x, y = mine.at(time)
        (ax, ay), (bx, by) = theirs.at(time - headway), theirs.at(time + headway)
        ex, ey = bx - ax, by - ay
        square = ex * ex + ey * ey
        share = min(max(((x - ax) * ex + (y - ay) * ey) / square, 0.0), 1.0) if square > 0 else 0.0
        return math.hypot(ax + share * ex - x, ay + share * ey - y)

    if headway > 0:
        nearest = _least(away, begin, end)
    else:
        (x, y), (a, b) = mine.at(begin), theirs.at(begin)
        vx, vy = mine.vx - theirs.vx, mine.vy - theirs.vy
        square = vx * vx + vy * vy
        nearest = min(max(begin - ((x - a) * vx + (y - b) * vy) / square, begin), end) if square > 0 else begin
    least = away(nearest)
    if least >= reach:
        return None
    since, until = (_crossing(away, reach, nearest, limit) for limit in (begin, end))
    return _Meeting(since, until, _kind(mine, theirs), nearest, mine.at(nearest), least)


def _least(away: Callable[[float], float], begin: float, end: float) -> float:
    """Find where a convex function is least (golden section)."""
    low, high = begin, end
    left, right = high - _GOLDEN * (high - low), low + _GOLDEN * (high - low)
    at_left, at_right = away(left), away(right)
    while right - left > 2**-40 * max(1.0, abs(high)):
        if at_left <= at_right:
            high, right, at_right = right, left, at_left
            left = high - _GOLDEN * (high - low)
            at_left = away(left)
        else:
            low, left, at_left = left, right, at_right
            right = low + _GOLDEN * (high - low)
            at_right = away(right)
    return min((begin, (low + high) / 2, end), key=away)


def _crossing(away: Callable[[float], float], reach: float, inside: float, outside: float) -> float:
    """Find where a convex function passes ``reach`` between a time at which it is less and another."""
    if away(outside) < reach:
        return outside
    while abs(outside - inside) > 2**-40 * max(1.0, abs(outside)):
        middle = (inside + outside) / 2
        if away(middle) < reach:
            inside = middle
        else:
            outside = middle
    return inside


def _merged(meetings: list[_Meeting]) -> list[_Meeting]:
    """One meeting for those without a break between: as it is where the two are nearest."""
    out: list[_Meeting] = []
    for meeting in sorted(meetings, key=lambda m: (m.since, m.time)):
        last = out[-1] if out else None
        if last is None or meeting.since > last.until + 1e-9 * max(1.0, abs(last.until)):
            out.append(meeting)
            continue
        nearest = meeting if meeting.away < last.away else last
        out[-1] = nearest._replace(since=last.since, until=max(last.until, meeting.until))
    return out


def _kind(mine: _Piece, theirs: _Piece) -> Kind:
    speed, other = math.hypot(mine.vx, mine.vy), math.hypot(theirs.vx, theirs.vy)
    if speed == 0:
        return "passed over"
    if other == 0:
        return "standing"
    along = (mine.vx * theirs.vx + mine.vy * theirs.vy) / (speed * other)
    if along > _ALONG:
        return "catching up"
    if along < -_ALONG:
        return "head-on"
    ends = [(piece.x, piece.y) for piece in (mine, theirs)], [piece.at(piece.t1) for piece in (mine, theirs)]
    slack = 2.0**-40 * max(abs(v) for pair in ends for point in pair for v in point)
    common = any(math.dist(a[0], b[1]) <= slack for a in ends for b in ends)
    return "crossroads" if common else "crossing in the open"


def _passes(trajectory: Trajectory, place: Point, tol: float) -> float | None:
    """When the robot, on a move, is within ``tol`` metres of the place for the last time; None if never."""
    stamps = trajectory.stamps
    for (t0, *a), (t1, *b) in zip(stamps[-2::-1].tolist(), stamps[:0:-1].tolist(), strict=True):
        piece = _piece(a, t0, b, t1)
        square = piece.vx**2 + piece.vy**2
        if square == 0:
            continue
        passed: float = t0 + ((place[0] - piece.x) * piece.vx + (place[1] - piece.y) * piece.vy) / square
        passed = min(max(passed, t0), t1)
        if math.dist(piece.at(passed), place) <= tol:
            return passed
    return 0.0 if len(stamps) == 1 and math.dist(stamps[0, 1:], place) <= tol else None
