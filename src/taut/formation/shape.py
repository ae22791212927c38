"""The shape of a travelling team: whose offsets from whom, how far it may be scaled down, where it may be."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from itertools import combinations

import numpy as np
import shapely
from numpy.typing import NDArray

from taut.errors import SceneError
from taut.freespace import FreeSpace
from taut.geometry.overlay import remainder
from taut.geometry.seeing import see_each_other
from taut.geometry.triangulation import meshed
from taut.scene import FloatArray, Robot, Scene
from taut.validation import validate

BoolArray = NDArray[np.bool_]


@dataclass(frozen=True, eq=False)
class Shape:
    """A team in formation: at scale c with the leader at p, robot i is at p + c · offset i; nothing turns.

    Parameters
    ----------
    scene : its starts are the formation at the leader's start, its goals the same at the leader's goal.
    leader : number of the leader in the scene.
    offsets : (n, 2) metres, start − leader's start.
    needed : (n, n) metres that two robots keep between their centres, headway included; 0 on the diagonal.
    speeds : (n,) metres a second.
    spaces : (n,) the free space of each robot.
    """

    scene: Scene
    leader: int
    offsets: FloatArray
    needed: FloatArray
    speeds: FloatArray
    spaces: tuple[FreeSpace, ...]

    @property
    def least_scale(self) -> float:
        """The scale at which the two that are nearest for their sizes touch; at most 1."""
        i, j = np.triu_indices(len(self.offsets), 1)
        apart = np.hypot(*(self.offsets[i] - self.offsets[j]).T)
        return min(1.0, float((self.needed[i, j] / apart).max(initial=0.0)))

    @property
    def spacing(self) -> float:
        """The size of the discs as a length: the least distance that two keep, or the diameter of a robot alone."""
        pairs = self.needed[np.triu_indices(len(self.offsets), 1)]
        return float(pairs.min()) if pairs.size else 2.0 * self.scene.growth(self.scene.robots[0])

    def places(self, states: FloatArray) -> FloatArray:
        """Places of all robots, (m, n, 2), in states (m, 3): x and y of the leader, scale."""
        return np.asarray(states[:, None, :2] + states[:, None, 2:] * self.offsets)

    def seconds(self, a: FloatArray, b: FloatArray) -> FloatArray:
        """How long all robots need together for straight moves from states (m, 3) to states (m, 3), (m,)."""
        moves = self.places(b) - self.places(a)
        return np.asarray((np.hypot(moves[..., 0], moves[..., 1]) / self.speeds).max(axis=1))


def in_formation(scene: Scene, offsets: Mapping[str, Sequence[float]], leader: str | None = None) -> Scene:
    """Return the scene with every follower's start and goal put at the leader's plus its offset.

    Parameters
    ----------
    scene : the starts and goals of its followers do not count.
    offsets : (dx, dy) in metres of each follower by name; the leader's, if given, is (0, 0).
    leader : name; the first robot of the scene by default.

    Raises
    ------
    SceneError
        A follower without offset, an offset of nobody, or not two numbers; and whatever `taut.validation.validate`
        finds: a place in an obstacle, two robots too near.

    >>> team = [Robot("A", (1, 2), (6, 2), radius=0.2), Robot("B", (0, 0), (0, 0), radius=0.2)]
    >>> in_formation(Scene((0, 0, 8, 4), robots=team), {"B": (-0.5, 1)}).robots[1].goal
    (5.5, 3.0)
    """
    head = leader_of(scene, leader)
    unknown = sorted(set(offsets) - {robot.name for robot in scene.robots})
    if unknown:
        raise SceneError(f"offsets: the scene has no robot {unknown[0]}")
    placed = replace(scene, robots=tuple(_placed(robot, head, offsets) for robot in scene.robots))
    validate(placed)
    return placed


def shape_of(scene: Scene, leader: str | None) -> Shape:
    """Return the formation in which a scene's robots start and end.

    Raises
    ------
    SceneError
        No robots; starts and goals that are not the same formation; robots nearer than the headway allows; and
        whatever `taut.validation.validate` finds.
    """
    validate(scene)
    head = leader_of(scene, leader)
    robots = scene.robots
    starts, goals = (np.array([getattr(r, end) for r in robots], dtype=np.float64) for end in ("start", "goal"))
    offsets = starts - head.start
    off = np.hypot(*(goals - head.goal - offsets).T)
    worst = int(np.argmax(off))
    if off[worst] > scene.tol:
        x, y = offsets[worst] + head.goal
        raise SceneError(
            f"robot {robots[worst].name}: goal {robots[worst].goal} is {off[worst]:.6g} m from its place in the "
            f"formation of the starts, which is ({x:.9g}, {y:.9g}); move it there (see in_formation)"
        )
    speeds = np.array([r.speed for r in robots])
    needed = np.zeros((len(robots), len(robots)))
    for i, j in combinations(range(len(robots)), 2):
        # whoever of two is looked at earlier or later, it is at most so much away from where it is now
        shifted = scene.headway * min(speeds[i], speeds[j])
        needed[i, j] = needed[j, i] = scene.separation(robots[i], robots[j]) + shifted
        apart = float(np.hypot(*(offsets[i] - offsets[j])))
        if apart < needed[i, j] - scene.tol:
            raise SceneError(
                f"robots {robots[i].name} and {robots[j].name} are {apart:.6g} m apart in the formation but need "
                f"{needed[i, j]:.6g} m with the headway of {scene.headway:g} s; set them farther apart"
            )
    by_growth = {scene.growth(robot): FreeSpace.of(scene, robot) for robot in robots}
    spaces = tuple(by_growth[scene.growth(robot)] for robot in robots)
    return Shape(scene, robots.index(head), offsets, needed, speeds, spaces)


def leader_of(scene: Scene, leader: str | None) -> Robot:
    """Return the robot of this name, by default the first.

    Raises
    ------
    SceneError
        There is none.
    """
    if not scene.robots:
        raise SceneError("no robots: a formation needs at least its leader; add robots with name, start and goal")
    return scene.robots[0] if leader is None else scene.robot(leader)


def space_at(shape: Shape, scale: float) -> FreeSpace:
    """Return where the leader may be with the whole formation at one scale: what is free for every robot at once.

    The formation does not turn, so the places that an obstacle denies to one robot it denies to the leader, shifted by
    that robot's offset. What two robots straddle stays free between them.
    """
    own = shape.spaces[shape.leader]
    low, high = np.min(shape.scene.workspace, axis=0), np.max(shape.scene.workspace, axis=0)
    margin = np.abs(shape.offsets).max(axis=0) + (high - low)
    frame = shapely.box(*(low - margin), *(high + margin))
    denied = {id(space): shapely.get_parts(shapely.difference(frame, space.region)) for space in shape.spaces}
    taken = [
        shapely.transform(piece, lambda xy, shift=scale * offset: xy - shift)
        for space, offset in zip(shape.spaces, shape.offsets, strict=True)
        for piece in denied[id(space)]
    ]
    room = shapely.box(*own.region.bounds)
    parts = shapely.get_parts(remainder(room, np.array(taken, dtype=object), shape.scene.tol))
    left = shapely.multipolygons(parts[shapely.get_type_id(parts) == shapely.GeometryType.POLYGON])
    return FreeSpace.with_mesh(shape.scene, own.growth, own.arc_error, *meshed(left, shape.scene.tol))


def free_moves(shape: Shape, a: FloatArray, b: FloatArray) -> BoolArray:
    """Whether all robots may move straight from states (m, 3) to states (m, 3), (m,).

    False also where a move passes a corner of somebody's free space exactly, or begins or ends where it touches itself.
    """
    m = len(a)
    out = np.ones(m, dtype=np.bool_)
    first = np.arange(m, dtype=np.int64)
    begin, end = shape.places(a), shape.places(b)
    for k, space in enumerate(shape.spaces):
        points, triangles = space.anchor(np.concatenate([begin[:, k], end[:, k]]))
        good = (triangles >= 0) & ~space.mesh.on_pinch(points)
        out &= good[:m] & good[m:]
        left = first[out]
        out[left] = see_each_other(space.mesh, points, triangles, left, left + m)
    return out


def _placed(robot: Robot, leader: Robot, offsets: Mapping[str, Sequence[float]]) -> Robot:
    given = offsets.get(robot.name, (0.0, 0.0) if robot == leader else None)
    if given is None:
        raise SceneError(f"offsets: robot {robot.name} has none; give its (dx, dy) from the leader {leader.name}")
    try:
        dx, dy = (float(value) for value in given)
    except (TypeError, ValueError):
        raise SceneError(f"offsets: robot {robot.name} needs (dx, dy) in metres, got {given!r}") from None
    if robot == leader:
        if (dx, dy) != (0.0, 0.0):
            raise SceneError(f"offsets: the leader {leader.name} is where offsets begin; its own must be (0, 0)")
        return robot
    (x0, y0), (x1, y1) = leader.start, leader.goal
    return replace(robot, start=(x0 + dx, y0 + dy), goal=(x1 + dx, y1 + dy))
