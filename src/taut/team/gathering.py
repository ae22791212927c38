"""Gathering: places to meet on the way, for teams that no single order of planning leads from starts to goals.

An order in which every robot stands beside one before it, both at the starts and at the goals, need not exist when
robots change places. Then the team gathers in between in arrangements that are a little more like the goals each time.
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import replace
from itertools import pairwise

import numpy as np
from scipy.optimize import linear_sum_assignment

from taut.freespace import FreeSpace
from taut.route import Route
from taut.scene import Scene
from taut.team._conflict_kernels import Floats, Ints
from taut.team.ties import Ties, linked_order, tied
from taut.team.world import World

_MOST_PLACES = 7  # arrangements one after another
_CENTRES = 24  # places on the way that are looked at
_KEPT = 3  # of them, the most open ones
_ROOM = (1.9, 1.5, 1.2)  # distances of neighbours in separations: robots may pass between them, or hardly move


def arrangements(world: World, ties: Ties) -> Iterator[list[Floats]]:
    """Yield sequences of arrangements (n, 2) from the starts to the goals that orders of planning lead through.

    The shortest sequences come first; at the most open places first. None if even many arrangements do not help. Robots
    that are at their goals already stay there.
    """
    scene = world.scene
    starts = np.array([robot.start for robot in scene.robots])
    goals = np.array([robot.goal for robot in scene.robots])
    moving = np.flatnonzero(~ties.resting)
    if not moving.size:
        return
    slots = [(centre, some) for room in _ROOM for centre, some in _open_places(world, moving, room)]
    for count in range(1, _MOST_PLACES + 1):
        for centre, some in slots:
            found = [starts]
            for share in np.arange(1, count + 1) / (count + 1):
                places = starts.copy()
                places[moving] = _arranged(starts[moving], goals[moving], centre, some, share)
                found.append(places)
            found.append(goals)
            if all(_leads(scene, ties, a, b) for a, b in pairwise(found)):
                yield found


def between(scene: Scene, starts: Floats, goals: Floats) -> Scene:
    """Return the scene with robots that begin and end there; away from its own start a robot may set out at once."""
    robots = []
    for robot, a, b in zip(scene.robots, starts.tolist(), goals.tolist(), strict=True):
        since = robot.start_time if robot.start == (a[0], a[1]) else 0.0
        robots.append(replace(robot, start=(a[0], a[1]), goal=(b[0], b[1]), start_time=since))
    return replace(scene, robots=tuple(robots))


def _leads(scene: Scene, ties: Ties, starts: Floats, goals: Floats) -> bool:
    """Whether there is an order of planning from one arrangement to the next."""
    here = tied(between(scene, starts, goals), ties.contact, ties.need, ties.walls)
    return len(linked_order(here, range(len(starts)))) == len(starts)


def _open_places(world: World, moving: Ints, room: float) -> list[tuple[Floats, Floats]]:
    """Centres on the way of a robot, the most open first, and for each of them places for all that move nearby."""
    scene = world.scene
    n = len(moving)
    largest = max(moving.tolist(), key=lambda i: scene.growth(scene.robots[i]))
    freespace: FreeSpace = world.shared(largest).freespace
    radius = max(robot.radius for robot in scene.robots)
    spacing = room * (2 * radius + scene.gap)
    middle = int(moving[np.argsort(world.shortest[moving], kind="stable")[n // 2]])
    taken = np.array([r.start for r in scene.robots if r.start == r.goal]).reshape(-1, 2)
    out = []
    part = freespace.part_of([scene.robots[largest].start])[0]
    for centre in _along(world.routes[middle], _CENTRES):
        around = _lattice(n, spacing)
        for wider in range(4):
            places = centre + around
            inside = freespace.mesh.locate(places)
            places = places[(inside >= 0) & np.isin(freespace.mesh.parts[inside], list(part))]
            places = places[(_apart(places, taken) >= spacing).all(axis=1)]
            if len(places) >= n:
                break
            around = _lattice(n * 4 ** (wider + 1), spacing)
        if len(places) >= n:
            away = np.hypot(*(places - centre).T)
            nearest = np.argsort(away, kind="stable")[:n]
            out.append((float(away[nearest[-1]]), centre, places[nearest]))
    out.sort(key=lambda entry: entry[0])
    return [(centre, places) for _, centre, places in out[:_KEPT]]


def _apart(places: Floats, others: Floats) -> Floats:
    across = places[:, None] - others[None]
    return np.asarray(np.hypot(across[..., 0], across[..., 1]))


def _along(route: Route, count: int) -> Floats:
    points = route.points
    at = np.concatenate([[0.0], np.cumsum(np.hypot(*np.diff(points, axis=0).T))])
    where = np.linspace(0.0, at[-1], count)
    return np.stack([np.interp(where, at, points[:, k]) for k in (0, 1)], axis=1)


def _lattice(count: int, spacing: float) -> Floats:
    """At least ``count`` places of a triangular lattice about the origin, in a disc."""
    size = math.ceil(math.sqrt(count)) + 2
    i, j = np.meshgrid(np.arange(-size, size + 1), np.arange(-size, size + 1))
    xy = np.stack([i + 0.5 * j, j * math.sqrt(0.75)], axis=-1).reshape(-1, 2)
    radius = math.sqrt(count * math.sqrt(0.75) / math.pi) + 1.5
    return np.asarray(spacing * xy[np.hypot(xy[:, 0], xy[:, 1]) <= radius])


def _arranged(starts: Floats, goals: Floats, centre: Floats, places: Floats, share: float) -> Floats:
    """Give each robot one of the places: as it stood among the others at the start, more and more as at the goal."""
    wanted = (1 - share) * _shape(starts) + share * _shape(goals)
    wanted = centre + _shape(wanted) * np.sqrt(((places - centre) ** 2).sum(axis=1).mean())
    across = wanted[:, None] - places[None]
    _, chosen = linear_sum_assignment((across**2).sum(axis=-1))
    return np.asarray(places[chosen])


def _shape(places: Floats) -> Floats:
    """Places relative to their middle, in units of their spread."""
    relative = places - places.mean(axis=0)
    spread = math.sqrt((relative**2).sum(axis=1).mean())
    return np.asarray(relative / spread if spread > 0 else relative)
