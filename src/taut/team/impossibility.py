"""Proofs that two robots cannot both reach their goals, whatever the roadmap, the speeds and the other robots.

The free space of each robot is cut into triangles. A pair of triangles is a possible state if some two of their points
are as far apart as the robots must be; a robot may go on to the next triangle if a point of the side between is far
enough from a point of the triangle of the other. Every motion of the two passes possible states by possible steps, so
if no such steps lead from the starts to the goals there is no motion. Where the answer is in doubt, triangles are
halved.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping
from dataclasses import dataclass, replace
from typing import Literal, TypeAlias

import numpy as np
import shapely
from numpy.typing import NDArray
from scipy.sparse import coo_array
from scipy.sparse.csgraph import connected_components

from taut.freespace import FreeSpace
from taut.geometry.triangulation import Floats, Ints, boundary_of, filled
from taut.route import shortest_path
from taut.scene import Circle, Line, Obstacle, Point, Robot, Scene
from taut.team import _impossibility_kernels as kernels
from taut.team.diagnosis import narrowest

Kind: TypeAlias = Literal["cannot pass", "in the way", "goals too near"]

Shapes: TypeAlias = NDArray[np.object_]

MOST_STATES = 2_000_000
_ARC_ERROR = 1e-3
_FINEST = 64  # cells smaller than this part of the separation are not halved: their proofs would hang on a hair


@dataclass(frozen=True)
class Impossible:
    """A proof that two robots cannot both reach their goals.

    Parameters
    ----------
    robots : names. Of "in the way", the first is the one that cannot get by.
    kind : "cannot pass": neither lets the other through; "in the way": the second at its goal leaves no way for the
        first; "goals too near": they cannot both stay at their goals.
    place : where their ways have least room, metres.
    width : metres from wall to wall there.
    needed : metres that two abreast need, clearances and gap included.
    parked : whether the second robot stands at its goal from the start.
    states : pairs of cells that the proof looked at.
    """

    robots: tuple[str, str]
    kind: Kind
    place: Point
    width: float
    needed: float
    parked: bool
    states: int

    @property
    def sentences(self) -> tuple[str, ...]:
        """What is impossible and why, then what would help; short lines."""
        a, b = self.robots
        where = f"({self.place[0]:.2f}, {self.place[1]:.2f})"
        narrow = f"near {where} the way is {self.width:.2f} m wide, two abreast need {self.needed:.2f} m"
        if self.kind == "goals too near":
            return (
                f"No plan exists: {a} and {b} cannot both stay at their goals near {where}, which are too near.",
                f"What would help: another goal for one of them, or at_goal: leave for {a} or {b}.",
            )
        room = f"; {narrow}" if self.width < self.needed else f" near {where}"
        bay = f"a bay or passage {self.needed:.2f} m wide near {where}"
        if self.kind == "cannot pass":
            return (
                f"No plan exists: {a} and {b} cannot pass each other on the way to their goals{room}.",
                f"What would help: {bay}, or another goal for {a} or {b}.",
            )
        how = "stands at its goal and cannot make way" if self.parked else "at its goal leaves no way"
        return (
            f"No plan exists: {b} {how} for {a} to its goal{room}.",
            f"What would help: at_goal: leave for {b}, another goal for {b}, or {bay}.",
        )


def impossible_pair(scene: Scene, i: int, j: int, most_states: int = MOST_STATES) -> Impossible | None:
    """Prove that robots i and j of a valid scene cannot both reach their goals; None if that was not proved.

    A proof holds for all motions that keep the distances from obstacles and from each other less the tolerance of the
    certificate. Speeds, start times and headway are left out, which can only lose proofs; so can corridors within a few
    per cent of wide enough, and robots that need a third one out of the way. None does not mean that there is a plan.

    Parameters
    ----------
    scene : a scene that `taut.validation.validate` accepts.
    i, j : numbers of two robots.
    most_states : pairs of cells, at which the search for a proof is given up; time and memory grow with it.

    Raises
    ------
    IndexError
        No such robots, or twice the same.

    >>> robots = [Robot("A", (1, 0.5), (9, 0.5), 0.4), Robot("B", (9, 0.5), (1, 0.5), 0.4)]
    >>> print(impossible_pair(Scene((0, 0, 10, 1), robots=robots), 0, 1).kind)
    cannot pass
    """
    return first_impossible(scene, [(i, j)], most_states)


def first_impossible(
    scene: Scene, pairs: Iterable[tuple[int, int]], most_states: int = MOST_STATES
) -> Impossible | None:
    """Return the first proof found for one of the pairs of robots; parameters and errors of `impossible_pair`."""
    spaces: dict[float, FreeSpace] = {}
    grounds: dict[tuple[float, float, float], _Ground | None] = {}
    alone: dict[tuple[str, float, float], _Cells | None] = {}
    for i, j in pairs:
        if not (0 <= i < len(scene.robots) and 0 <= j < len(scene.robots) and i != j):
            raise IndexError(f"pairs are numbers of two robots from 0 to {len(scene.robots) - 1}, got {i} and {j}")
        a, b = scene.robots[i], scene.robots[j]
        least = scene.separation(a, b) - 2 * scene.tol  # once for the certificate, once for rounding
        if least <= 0 or any(r.start == r.goal and not scene.stays(r) for r in (a, b)):
            continue  # nothing to keep, or one is never there
        if scene.stays(a) and scene.stays(b) and math.dist(a.goal, b.goal) < least:
            x, y = ((p + q) / 2 for p, q in zip(a.goal, b.goal, strict=True))
            needed = scene.separation(a, b) + scene.growth(a) + scene.growth(b)
            return Impossible((a.name, b.name), "goals too near", (x, y), math.dist(a.goal, b.goal), needed, False, 0)
        cells = []
        for robot, other in ((a, b), (b, a)):
            growth, room = scene.growth(robot), least + scene.growth(other) - scene.growth(robot)
            if growth not in spaces:
                spaces[growth] = outer_space(scene, growth)
            if (growth, room, least) not in grounds:
                places = _narrow_places(spaces[growth], room)
                grounds[growth, room, least] = _ground(spaces[growth], places, least / 2, most_states)
            ground = grounds[growth, room, least]
            if (robot.name, room, least) not in alone:
                alone[robot.name, room, least] = None if ground is None else _cells(ground, robot)
            cells.append(alone[robot.name, room, least])
        known, other_known = cells
        if known is None or other_known is None:
            continue
        proof = _prove(scene, (a, b), (known, other_known), least, most_states)
        if proof is not None:
            return _told(scene, a, b, spaces, proof)
    return None


def outer_space(scene: Scene, growth: float) -> FreeSpace:
    """Return a free space that holds all places a certificate accepts for robots that need ``growth`` metres.

    Rounded corners of a `FreeSpace` lie a little outside the arcs; here everything that is round is smaller by as much.
    """
    share = 1.0 / (1.0 + _ARC_ERROR)
    less = max(growth * share - scene.tol, 0.0)
    obstacles = [_smaller(obstacle, share) for obstacle in scene.obstacles]
    return FreeSpace(scene.with_obstacles(obstacles), less if less > 1e-69 else 0.0, _ARC_ERROR)


@dataclass(frozen=True, eq=False)
class _Ground:
    """A free space in triangles.

    Parameters
    ----------
    vertices, triangles, neighbours : (n, 2) metres, (m, 3), (m, 3) with −1 for walls.
    narrow : (m,) whether two robots may be unable to pass each other there.
    slack : metres by which ends may miss them.
    """

    vertices: Floats
    triangles: Ints
    neighbours: Ints
    narrow: NDArray[np.bool_]
    slack: float


@dataclass(frozen=True, eq=False)
class _Cells:
    """Where one robot may be: triangles in narrow places, open places without a shape beside them.

    Parameters
    ----------
    vertices, triangles : (n, 2) metres, (m, 3).
    neighbours : (m, 3), −1 a wall, −2 − k open place k.
    open_places : how many there are.
    ends : start and goal.
    open_ends : the open places that hold each of them.
    slack : metres by which ends may miss the cells.
    """

    vertices: Floats
    triangles: Ints
    neighbours: Ints
    open_places: int
    ends: tuple[Point, Point]
    open_ends: tuple[Ints, Ints]
    slack: float

    def __len__(self) -> int:
        return len(self.triangles) + self.open_places

    @property
    def corners(self) -> Floats:
        """Corners of the triangles, (m, 3, 2) metres."""
        return self.vertices[self.triangles]


@dataclass(frozen=True)
class _Proof:
    """How many states it looked at, and which of the two can reach its goal while the other has not."""

    states: int
    home: tuple[bool, bool]


def _smaller(obstacle: Obstacle, share: float) -> Obstacle:
    match obstacle:
        case Circle():
            return replace(obstacle, radius=obstacle.radius * share)
        case Line():
            return Line(obstacle.points, obstacle.width * share, obstacle.name)
        case _:
            return obstacle


def _narrow_places(space: FreeSpace, room: float) -> Shapes:
    """Polygons where no disc of diameter ``room`` fits in; a disc in which two can go round each other fits elsewhere.

    They only choose which cells are looked at, so they need not be exact.
    """
    if room <= 0:
        return np.empty(0, dtype=object)
    parts: Shapes = shapely.get_parts(space.region.difference(space.region.buffer(-room / 2).buffer(room * 0.51)))
    return np.asarray(parts[shapely.area(parts) > 0], dtype=object)


def _ground(space: FreeSpace, narrow: Shapes, size: float, most_states: int) -> _Ground | None:
    """Cut a free space so that triangles in narrow places are about ``size`` metres; None if they are too many."""
    vertices, triangles, neighbours = _with_more_corners(space, shapely.STRtree(narrow), size)
    most = len(triangles) + 16 * math.isqrt(most_states)
    while True:
        shapes = shapely.polygons(vertices[triangles])
        # asked by the narrow places, which may have very many corners: the tree prepares whom it is asked by
        piece, shape = shapely.STRtree(shapes).query(narrow, predicate="intersects")
        touching = np.isin(np.arange(len(triangles)), shape)
        large = touching & (_longest(vertices[triangles]) > size)
        if not large.any():
            break
        vertices, triangles, neighbours, count = kernels.halved(vertices, triangles, neighbours, large, most)
        if count < 0:
            return None
    covered = np.bincount(
        shape, shapely.area(shapely.intersection(shapes[shape], narrow[piece])), minlength=len(triangles)
    )
    return _Ground(vertices, triangles, neighbours, covered > 0.1 * shapely.area(shapes), 2 * space.scene.tol)


def _with_more_corners(space: FreeSpace, narrow: shapely.STRtree, size: float) -> tuple[Floats, Ints, Ints]:
    """Triangulate anew with sides of ``size`` metres on the boundary of narrow places, lest there are slivers there."""
    vertices, edges = boundary_of(space.region)
    steps = np.ceil(np.hypot(*(vertices[edges[:, 1]] - vertices[edges[:, 0]]).T) / size).astype(np.int64)
    edge = np.repeat(np.arange(len(edges)), steps)
    share = (np.arange(len(edge)) - np.repeat(np.cumsum(steps) - steps, steps)) / steps[edge]
    tail, head = vertices[edges[edge, 0]], vertices[edges[edge, 1]]
    points = tail + share[:, None] * (head - tail)
    first = share == 0
    kept = first.copy()
    kept[narrow.query(shapely.points(points), predicate="dwithin", distance=size)[0]] = True
    number = np.where(first, edges[edge, 0], len(vertices) + np.cumsum(~first & kept) - 1)[kept]
    last = np.append(np.diff(edge[kept]) > 0, True)
    following = np.where(last, edges[edge[kept], 1], np.append(number[1:], 0))
    places = np.concatenate([vertices, points[kept & ~first]])
    try:
        return places, *filled(places, np.stack([number, following], axis=1))
    except ValueError:  # rounding has moved a side across a corner that touches it
        return space.mesh.vertices, space.mesh.triangles, space.mesh.neighbours


def _cells(ground: _Ground, robot: Robot) -> _Cells | None:
    """Return the cells that one robot can reach if it is alone; None if its goal is not among them."""
    corners = ground.vertices[ground.triangles]
    parts = _components(ground.neighbours, np.zeros(len(corners), dtype=np.bool_))
    start, goal = (_near(corners, end, ground.slack) for end in (robot.start, robot.goal))
    kept = np.isin(parts, parts[start])
    if not kept[goal].any():
        return None
    number = np.append(np.cumsum(kept) - 1, kernels.WALL)
    neighbours = number[ground.neighbours[kept]]
    held = number[start], number[goal[kept[goal]]]
    narrow = _dividing(neighbours, ground.narrow[kept], np.concatenate(held))
    _, place = np.unique(_components(neighbours, narrow)[~narrow], return_inverse=True)
    code = np.append(np.cumsum(narrow) - 1, kernels.WALL)
    code[np.flatnonzero(~narrow)] = -2 - place
    open_start, open_goal = (np.unique(-2 - code[h[~narrow[h]]]) for h in held)
    return _Cells(
        ground.vertices,
        ground.triangles[kept][narrow],
        code[neighbours[narrow]],
        int(place.max(initial=-1)) + 1,
        (robot.start, robot.goal),
        (open_start, open_goal),
        ground.slack,
    )


def _dividing(neighbours: Ints, narrow: NDArray[np.bool_], ends: Ints) -> NDArray[np.bool_]:
    """Of the narrow triangles, those in pieces that hold an end, or without which the ends would hang together less."""
    pieces = _components(neighbours, narrow)
    count = int(pieces.max(initial=-1)) + 1
    tail, slot = np.nonzero(neighbours >= 0)
    a, b = pieces[tail], pieces[neighbours[tail, slot]]
    between = np.unique(np.stack([a, b], axis=1)[a != b], axis=0)
    of_ends = np.unique(pieces[ends])
    divides = np.isin(np.arange(count), of_ends)
    touched = np.bincount(between[:, 0], minlength=count)
    for piece in np.setdiff1d(np.unique(pieces[narrow]), of_ends):
        if touched[piece] < 2:
            continue
        left = between[(between != piece).all(axis=1)]
        _, part = connected_components(coo_array((np.ones(len(left)), left.T), shape=(count, count)), directed=False)
        divides[piece] = len(np.unique(part[of_ends])) > 1
    return narrow & divides[pieces]


def _components(neighbours: Ints, kind: NDArray[np.bool_]) -> Ints:
    """Number of the connected piece of each triangle, among triangles of the same kind."""
    tail, slot = np.nonzero(neighbours >= 0)
    head = neighbours[tail, slot]
    same = kind[tail] == kind[head]
    n = len(neighbours)
    joined = coo_array((np.ones(int(same.sum())), (tail[same], head[same])), shape=(n, n))
    return np.asarray(connected_components(joined, directed=False)[1], dtype=np.int64)


def _prove(
    scene: Scene, robots: tuple[Robot, Robot], cells: tuple[_Cells, _Cells], least: float, most_states: int
) -> _Proof | None:
    """Halve cells in doubt until the goals cannot be reached, or it is clear that they can, or there are too many."""
    first, second = cells
    stays = scene.stays(robots[0]), scene.stays(robots[1])
    while len(first) * len(second) <= most_states:
        table = kernels.state_table(first.corners, first.open_places, second.corners, second.open_places, least)
        doors = _doors(first), _doors(second)
        held = [(_holding(c, 0), _holding(c, 1)) for c in (first, second)]
        homes = _homes(held[0][1], second, robots[0].goal, least), _homes(held[1][1], first, robots[1].goal, least)
        home_first, home_second = np.zeros((2, *table.shape), dtype=np.bool_)
        home_first[np.ix_(*homes[0])] = True
        home_second[np.ix_(*homes[1][::-1])] = True
        goals = np.zeros(table.shape, dtype=np.bool_)
        if all(stays):
            goals[np.ix_(held[0][1], held[1][1])] = True
        for stay, home in zip(stays, (home_first, home_second), strict=True):
            if not stay:
                goals |= home
        starts = (held[0][0][:, None] * table.shape[1] + held[1][0]).ravel()
        starts = starts[table.ravel()[starts] != kernels.NEVER]
        reached = kernels.reachable(table, *doors, least, starts)
        if not (reached & goals.ravel()).any():
            home = bool((reached & home_first.ravel()).any()), bool((reached & home_second.ravel()).any())
            return _Proof(table.size, home)
        outcome, *doubts = kernels.explore(table, *doors, least, starts, goals.ravel(), reached)
        if outcome == kernels.POSSIBLE:
            return None
        for c, doubt in zip((first, second), doubts, strict=True):
            doubt &= _longest(c.corners) > least / _FINEST
        if not (doubts[0].any() or doubts[1].any()):
            return None
        finer, other_finer = _halved(first, doubts[0], most_states), _halved(second, doubts[1], most_states)
        if finer is None or other_finer is None:
            return None
        first, second = finer, other_finer
    return None


def _halved(cells: _Cells, marked: NDArray[np.bool_], most_states: int) -> _Cells | None:
    vertices, triangles, neighbours, count = kernels.halved(
        cells.vertices, cells.triangles, cells.neighbours, marked, min(most_states, 8 * len(cells) + 64)
    )
    return None if count < 0 else replace(cells, vertices=vertices, triangles=triangles, neighbours=neighbours)


def _doors(cells: _Cells) -> kernels.Doors:
    corners, n = cells.corners, len(cells.triangles)
    tail, slot = np.nonzero(cells.neighbours != kernels.WALL)
    head = cells.neighbours[tail, slot]
    sides = np.concatenate([corners[tail, slot], corners[tail, (slot + 1) % 3]], axis=1)
    outward = head < 0
    head = np.where(outward, n - 2 - head, head)
    tail, head = np.append(tail, head[outward]), np.append(head, tail[outward])
    sides = np.concatenate([sides, sides[outward]])
    order = np.argsort(tail, kind="stable")
    indptr = np.searchsorted(tail[order], np.arange(len(cells) + 1)).astype(np.int64)
    return indptr, head[order].astype(np.int64), np.ascontiguousarray(sides[order]), corners


def _holding(cells: _Cells, end: int) -> Ints:
    """Cells that hold the start (0) or the goal (1)."""
    triangles = _near(cells.corners, cells.ends[end], cells.slack)
    return np.append(triangles, len(cells.triangles) + cells.open_ends[end]).astype(np.int64)


def _homes(held: Ints, others: _Cells, goal: Point, least: float) -> tuple[Ints, Ints]:
    """Cells of a robot's goal, and those where the other one can be while it is there."""
    away = np.hypot(*(others.corners - goal).transpose(2, 0, 1)).max(axis=1, initial=0.0)
    far = np.append(away >= least, np.ones(others.open_places, dtype=np.bool_))
    return held, np.flatnonzero(far)


def _near(corners: Floats, point: Point, slack: float) -> Ints:
    """Triangles (m, 3, 2), counter-clockwise, that hold a point or miss it by about the slack."""
    sides = np.roll(corners, -1, axis=1) - corners
    to = np.array(point) - corners
    left = sides[..., 0] * to[..., 1] - sides[..., 1] * to[..., 0] >= -slack * np.hypot(sides[..., 0], sides[..., 1])
    low, high = corners.min(axis=1) - slack, corners.max(axis=1) + slack
    return np.flatnonzero(left.all(axis=1) & (low <= point).all(axis=1) & (high >= point).all(axis=1))


def _longest(corners: Floats) -> Floats:
    """Longest side of each triangle, metres."""
    sides = np.roll(corners, -1, axis=1) - corners
    return np.asarray(np.hypot(sides[..., 0], sides[..., 1]).max(axis=1, initial=0.0))


def _told(scene: Scene, a: Robot, b: Robot, spaces: Mapping[float, FreeSpace], proof: _Proof) -> Impossible:
    """Say who is in whose way, and where."""
    first, second = (b, a) if a.start == a.goal or (proof.home == (True, False) and b.start != b.goal) else (a, b)
    parked = second.start == second.goal
    kind: Kind = "in the way" if parked or proof.home[0] != proof.home[1] else "cannot pass"
    way, other = (shortest_path(spaces[scene.growth(r)], r.start, r.goal).points for r in (first, second))
    needed = scene.separation(a, b) + scene.growth(a) + scene.growth(b)
    place, width = narrowest(spaces[scene.growth(first)], way, other, scene.separation(a, b))
    return Impossible((first.name, second.name), kind, place, width, needed, parked, proof.states)
