"""Why no plan was found: who is in whose way, where, in how narrow a place, and what would help."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any, Literal, TypeAlias

import numpy as np
import shapely
from scipy.sparse import coo_array
from scipy.sparse.csgraph import connected_components

from taut.freespace import FreeSpace
from taut.geometry.triangulation import Floats, Ints
from taut.scene import Obstacle, Point, Robot, Scene
from taut.team.prioritized import Round
from taut.team.world import World

Standing: TypeAlias = Literal["start", "goal"]

_MOST_ROBOTS = 24
MOST_PAIRS = 24
_TOLD = 5
_HEAD_ON = math.cos(math.radians(120))


@dataclass(frozen=True)
class Block:
    """A robot that got no further in the best round, where and when, and the names of those in its way."""

    robot: str
    others: tuple[str, ...]
    place: Point
    time: float


@dataclass(frozen=True)
class Cut:
    """A robot that, where it starts or ends, leaves no way for another one.

    Parameters
    ----------
    robot : who stands in the way.
    other : whom it cuts off from its goal.
    at : "start" if it would have to leave first, "goal" if the other would have to be through before it arrives.
    parked : whether its start is its goal.
    place : where it stands.
    """

    robot: str
    other: str
    at: Standing
    parked: bool
    place: Point


@dataclass(frozen=True)
class Narrow:
    """A stretch on which the shortest ways of two robots run against each other and two abreast do not fit.

    Parameters
    ----------
    robots : names.
    begin, end : the stretch on the way of the first.
    place : its narrowest place.
    width : metres from wall to wall there.
    needed : metres that two abreast need, clearances and gap included.
    between : what is on both sides there: names of obstacles, or "the wall".
    """

    robots: tuple[str, str]
    begin: Point
    end: Point
    place: Point
    width: float
    needed: float
    between: tuple[str, str]


@dataclass(frozen=True)
class Diagnosis:
    """What is known of why no plan was found.

    Parameters
    ----------
    blocks : one for each robot that failed in the best round, in the order in which they failed.
    cycles : groups of robots of which each waits for another one of the group.
    cuts : who leaves no way for whom.
    narrow : where two meet head-on and cannot pass.
    helps : what would help, as parts of a sentence.
    """

    blocks: tuple[Block, ...]
    cycles: tuple[tuple[str, ...], ...]
    cuts: tuple[Cut, ...]
    narrow: tuple[Narrow, ...]
    helps: tuple[str, ...]

    @property
    def sentences(self) -> tuple[str, ...]:
        """The same in words, one line each, the most telling of every kind."""
        lines = [_tell_block(block) for block in self.blocks[:_TOLD]]
        lines += [f"{_listed(cycle)} wait for each other." for cycle in self.cycles[:_TOLD]]
        lines += [_tell_cut(cut) for cut in self.cuts[:_TOLD]]
        lines += [_tell_narrow(narrow) for narrow in self.narrow[:_TOLD]]
        return (*lines, f"What may help: {'; '.join(self.helps[:_TOLD])}.")


def diagnose(world: World, best: Round) -> Diagnosis:
    """Say why the robots that failed in a round did not get through.

    Only what the round shows is looked at: the robots that failed and those in their way. In rounds in which very many
    failed these are the first two dozen.
    """
    scene = world.scene
    names = [robot.name for robot in scene.robots]
    blocks = tuple(Block(names[f.robot], tuple(names[j] for j in f.blockers), f.place, f.time) for f in best.failures)
    pairs = suspects(world, best)
    cuts = tuple(cut for pair in pairs for a, b in (pair, pair[::-1]) for cut in _cuts(world, a, b))
    narrow = tuple(found for a, b in pairs if (found := _head_on(world, a, b)) is not None)
    waits = [(f.robot, j) for f in best.failures for j in f.blockers]
    number = {name: i for i, name in enumerate(names)}
    waits += [(number[cut.other], number[cut.robot]) for cut in cuts if cut.at == "start" and not cut.parked]
    cycles = tuple(tuple(names[i] for i in group) for group in _cycles(len(names), waits))
    return Diagnosis(blocks, cycles, cuts, narrow, _helps(cuts, narrow))


def suspects(world: World, best: Round) -> tuple[tuple[int, int], ...]:
    """Pairs of robots that may be why a round failed, those first that were in each other's way in it.

    Then come robots among the same whose shortest ways run against each other or past the start or goal of the other.
    """
    scene = world.scene
    pairs = dict.fromkeys((f.robot, j) for f in best.failures for j in f.blockers)
    concerned = list(dict.fromkeys([f.robot for f in best.failures] + [j for _, j in pairs]))[:_MOST_ROBOTS]
    lines = {i: _line(world.routes[i].points) for i in concerned}
    for k, i in enumerate(concerned):
        for j in concerned[:k]:
            if shapely.dwithin(lines[i], lines[j], scene.separation(scene.robots[i], scene.robots[j])):
                pairs.setdefault((j, i))
    unordered = dict.fromkeys(pair for pair in pairs if pair[::-1] not in pairs or pair[0] < pair[1])
    return tuple(unordered)[:MOST_PAIRS]


def passage(freespace: FreeSpace, place: Point, direction: Point) -> tuple[float, Floats]:
    """Metres between the walls on both sides of a place, square to a direction, and where free space ends there (2, 2).

    >>> passage(FreeSpace(Scene((0, 0, 9, 2)), 0.5), (3, 1), (1, 0))[0]
    2.0
    """
    here = np.array(place)
    across = np.array([-direction[1], direction[0]]) / math.hypot(*direction)
    x0, y0, x1, y1 = freespace.region.bounds
    far = 2 * math.hypot(x1 - x0, y1 - y0)
    cut = shapely.linestrings([here - far * across, here + far * across])
    pieces = shapely.get_parts(shapely.intersection(cut, freespace.region))
    if len(pieces) == 0:
        return 2 * freespace.growth, np.stack([here, here])
    piece = pieces[int(np.argmin(shapely.distance(pieces, shapely.Point(place))))]
    return float(piece.length) + 2 * freespace.growth, shapely.get_coordinates(piece)[[0, -1]]


def narrowest(freespace: FreeSpace, points: Floats, near: Floats, within: float) -> tuple[Point, float]:
    """Place on a route (k, 2) where its `passage` is narrowest, and metres from wall to wall there.

    Only places less than ``within`` metres from the route ``near`` count, if there are any; of places equally narrow
    the one in the middle is taken.
    """
    places, directions = _along(points, within / 2)
    close = np.flatnonzero(shapely.distance(_line(near), shapely.points(places)) < within)
    if len(close) == 0:
        close = np.arange(len(places))
    widths = _widths(freespace, places[close], directions[close])
    narrow = close[widths <= widths.min() * (1 + 1e-6)]
    k = int(narrow[len(narrow) // 2])
    return (float(places[k, 0]), float(places[k, 1])), float(widths.min())


def _cuts(world: World, a: int, b: int) -> list[Cut]:
    """Where robot a standing at its start or its goal leaves no way for robot b."""
    scene = world.scene
    robot, other = scene.robots[a], scene.robots[b]
    if robot.start == robot.goal and not scene.stays(robot):
        return []
    ends: list[tuple[Standing, Point]] = [("goal", robot.goal)] if scene.stays(robot) else []
    if robot.start != robot.goal:
        ends.append(("start", robot.start))
    line = _line(world.routes[b].points)
    out = []
    for at, place in ends:
        least = scene.separation(robot, other) - scene.tol
        if line.dwithin(shapely.Point(place), least) and _cut_off(world.shared(b).freespace, other, place, least):
            out.append(Cut(robot.name, other.name, at, robot.start == robot.goal, place))
    return out


def _cut_off(freespace: FreeSpace, robot: Robot, place: Point, least: float) -> bool:
    """Whether no way leads to the robot's goal at least so far from a place."""
    if math.dist(robot.goal, place) < least:
        return True
    # GEOS draws circles inside the true ones, so that what is left is rather too much
    parts = shapely.get_parts(freespace.region.difference(shapely.Point(place).buffer(least, quad_segs=32)))
    ends = shapely.points([robot.start, robot.goal])
    slack = max(freespace.scene.tol, least / 1000)  # of the corners of the circle
    held = shapely.distance(parts[:, None], ends[None]) <= slack
    return bool(held.any(axis=0).all() and not held.all(axis=1).any())


def _head_on(world: World, a: int, b: int) -> Narrow | None:
    """Return the longest stretch where the ways of two run against each other and it is too narrow for both."""
    scene, freespace = world.scene, world.shared(a).freespace
    robots = scene.robots[a], scene.robots[b]
    if any(robot.start == robot.goal for robot in robots):
        return None
    apart = scene.separation(*robots)
    needed = apart + scene.growth(robots[0]) + scene.growth(robots[1])
    places, ahead = _along(world.routes[a].points, apart / 2)
    line = _line(world.routes[b].points)
    at = shapely.points(places)
    there = shapely.line_locate_point(line, at)
    step = line.length / 1000
    near = shapely.line_interpolate_point(line, np.stack([np.maximum(there - step, 0), there + step]))
    against = np.diff(shapely.get_coordinates(near).reshape(2, -1, 2), axis=0)[0]
    against /= np.maximum(np.hypot(*against.T), 1e-300)[:, None]
    meet = (shapely.distance(line, at) < apart) & ((ahead * against).sum(axis=1) < _HEAD_ON)
    widths = np.full(len(places), np.inf)
    widths[meet] = _widths(freespace, places[meet], ahead[meet])
    tight = widths < needed - scene.tol
    if not tight.any():
        return None
    edge = np.flatnonzero(np.diff(np.concatenate([[False], tight, [False]])))
    first, last = max(zip(edge[::2].tolist(), edge[1::2].tolist(), strict=True), key=lambda run: run[1] - run[0])
    middle = first + np.flatnonzero(widths[first:last] <= widths[first:last].min() * (1 + 1e-6))
    k = int(middle[len(middle) // 2])
    width, ends = passage(freespace, _point(places[k]), _point(ahead[k]))
    sides = _bounding(scene, ends)
    begin, end, place = (_point(places[m]) for m in (first, last - 1, k))
    return Narrow((robots[0].name, robots[1].name), begin, end, place, width, needed, sides)


def _along(points: Floats, step: float) -> tuple[Floats, Floats]:
    """Places on a route about ``step`` metres apart, 2 to 200, and the directions in which it goes on there."""
    line = _line(points)
    length = float(line.length)
    count = min(max(math.ceil(length / step), 2), 200)
    where = (np.arange(count) + 0.5) * length / count
    small = length / count / 100
    both = shapely.line_interpolate_point(line, np.stack([where - small, where + small]))
    before, after = shapely.get_coordinates(both).reshape(2, -1, 2)
    lengths = np.hypot(*(after - before).T)
    directions = np.where(lengths[:, None] > 0, (after - before) / np.maximum(lengths, 1e-300)[:, None], [1.0, 0.0])
    return shapely.get_coordinates(shapely.line_interpolate_point(line, where)), directions


def _widths(freespace: FreeSpace, places: Floats, directions: Floats) -> Floats:
    return np.array([passage(freespace, _point(p), _point(d))[0] for p, d in zip(places, directions, strict=True)])


def _line(points: Floats) -> Any:
    return shapely.linestrings(points if len(points) > 1 else np.repeat(points, 2, axis=0))


def _point(xy: Floats) -> Point:
    return float(xy[0]), float(xy[1])


def _bounding(scene: Scene, ends: Floats) -> tuple[str, str]:
    """Names of the obstacles, or "the wall", nearest to two places."""
    at = shapely.points(ends)
    names = ["the wall", *(obstacle.name for obstacle in scene.obstacles)]
    away = [shapely.distance(shapely.Polygon(scene.workspace).exterior, at)]
    away += [shapely.distance(_core(obstacle), at) - obstacle.own_radius for obstacle in scene.obstacles]
    first, second = np.argmin(np.array(away), axis=0)
    return names[first], names[second]


def _core(obstacle: Obstacle) -> Any:
    if obstacle.closed:
        return shapely.Polygon(obstacle.core)
    return _line(obstacle.core)


def _cycles(n: int, waits: Sequence[tuple[int, int]]) -> list[Ints]:
    """Groups of at least two robots that wait for each other, directly or by way of others."""
    if not waits:
        return []
    matrix = coo_array((np.ones(len(waits)), np.array(waits).T), shape=(n, n))
    _, group = connected_components(matrix, directed=True, connection="strong")
    return [np.flatnonzero(group == g) for g in np.flatnonzero(np.bincount(group) > 1)]


def _helps(cuts: Sequence[Cut], narrow: Sequence[Narrow]) -> tuple[str, ...]:
    helps = [f"another goal for {cut.robot}, or at_goal: leave for it" for cut in cuts if cut.at == "goal"]
    for found in narrow:
        (x, y), (a, b) = found.place, found.robots
        helps.append(f"a bay for {a} or {b} near ({x:.2f}, {y:.2f}), where the way is {found.needed:.2f} m wide")
    return tuple(dict.fromkeys(helps)) or ("more rounds or seconds, or another seed",)


def _tell_block(block: Block) -> str:
    x, y = block.place
    way = f"; in its way: {_listed(block.others)}" if block.others else ""
    return f"{block.robot} gets no further than ({x:.2f}, {y:.2f}) at t = {block.time:.2f} s{way}."


def _tell_cut(cut: Cut) -> str:
    x, y = cut.place
    if cut.parked:
        return f"{cut.robot}, parked at ({x:.2f}, {y:.2f}), leaves no way for {cut.other} unless it makes way."
    then = f"has to leave before {cut.other}" if cut.at == "start" else f"has to wait until {cut.other} is through"
    return f"{cut.robot} at its {cut.at} ({x:.2f}, {y:.2f}) leaves no way for {cut.other}: it {then}."


def _tell_narrow(narrow: Narrow) -> str:
    (a, b), (x0, y0), (x1, y1) = narrow.robots, narrow.begin, narrow.end
    sides = "the walls" if narrow.between == ("the wall", "the wall") else " and ".join(narrow.between)
    return (
        f"{a} and {b} meet head-on from ({x0:.2f}, {y0:.2f}) to ({x1:.2f}, {y1:.2f}): between {sides} there are "
        f"{narrow.width:.2f} m, two abreast need {narrow.needed:.2f} m."
    )


def _listed(names: Sequence[str]) -> str:
    shown = list(names[:_TOLD])
    if len(names) > _TOLD:
        shown.append(f"{len(names) - _TOLD} more")
    return shown[0] if len(shown) == 1 else f"{', '.join(shown[:-1])} and {shown[-1]}"
