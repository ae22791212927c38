"""The Central Algorithm (CA): waypoints beside the obstacles that the straight line crosses, and no other obstacle.

It is not complete, and its path may hit obstacles that the line does not cross; which and where is reported.
Source: F. A. S. Alwafi, Social Graphs and Their Applications to Robotics, section 5.5.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from taut.errors import GoalBlocked, NoPath, SceneError, StartBlocked
from taut.freespace import FreeSpace
from taut.graph import Graph, dijkstra
from taut.roadmap import Roadmap
from taut.route import _hit_kernels
from taut.route.core import Route
from taut.route.hits import Hit, Solid, depth_in, hits_of, solid_of, spans_in, wall_of
from taut.route.obstacles import ObstacleIndex, indexed, obstacles_near, too_near
from taut.scene import FloatArray, Point, Robot, Scene


@dataclass(frozen=True, eq=False)
class Crossed:
    """An obstacle that the baseline crosses.

    Parameters
    ----------
    name : of the obstacle.
    crossings : (c, 2) metres, the points u: entry and exit in turn, from the start on.
    reach : metres, m: the greatest distance of any point of the grown obstacle from the line of the baseline.
    """

    name: str
    crossings: FloatArray
    reach: float


@dataclass(frozen=True)
class Waypoint:
    """A point u' = u ± (m + δ) n beside the baseline.

    Parameters
    ----------
    place : (x, y) metres.
    obstacle : name of the crossed obstacle.
    crossing : number of u among that obstacle's crossings.
    side : +1 left of the baseline, −1 right of it.
    """

    place: Point
    obstacle: str
    crossing: int
    side: int


@dataclass(frozen=True, eq=False)
class CentralRoute(Route):
    """A path by the Central Algorithm and all it was made of.

    Parameters
    ----------
    points : (k, 2) metres, from start to goal; one row if they are the same place.
    baseline : (2, 2) metres, start and goal.
    crossed : the obstacles that the baseline crosses, in the scene's order.
    waypoints : those used, in the order of the roadmap's vertices 2, 3, …
    dropped : those that were not, and why.
    roadmap : the partial visibility graph; vertex 0 is the start, 1 the goal.
    hits : what the path comes nearer to than the robot needs, in the order of the path.
    """

    baseline: FloatArray
    crossed: tuple[Crossed, ...]
    waypoints: tuple[Waypoint, ...]
    dropped: tuple[tuple[Waypoint, str], ...]
    roadmap: Roadmap
    hits: tuple[Hit, ...]

    @property
    def free(self) -> bool:
        """Whether the path is allowed in the whole scene."""
        return not self.hits


class NoCentralPath(NoPath):
    """The waypoints of the Central Algorithm offer no way; ``crossed`` are the obstacles it had to pass."""

    def __init__(self, robot: str, crossed: tuple[Crossed, ...]) -> None:
        self.crossed = crossed
        names = ", ".join(obstacle.name for obstacle in crossed[:5]) + f" and {len(crossed) - 5} more" * (
            len(crossed) > 5
        )
        what = f"past {names}" if crossed else "inside the workspace, which its straight line leaves"
        super().__init__(
            robot, f"the Central Algorithm finds no way {what}; it is not complete, so there may be one all the same"
        )


def central_path(world: Scene | ObstacleIndex, robot: Robot | str, delta: float = 0.5) -> CentralRoute:
    """Plan for one robot with the obstacles that the straight line from its start to its goal crosses.

    Obstacles grow by the robot's radius and clearance. Where the line enters or leaves the inside of one, at u, two
    waypoints are set beside the line. Start, goal and waypoints are joined by all straight ways past the crossed
    obstacles inside the workspace, and searched by Dijkstra's algorithm.

    Parameters
    ----------
    world : the scene; or, where many paths are asked for, its index (`index_obstacles`).
    robot : a robot of the scene, or its name.
    delta : metres, δ ≥ 0, by which waypoints are farther from the line than any point of their obstacle.

    Raises
    ------
    StartBlocked, GoalBlocked
        The place is not free.
    NoCentralPath
        The waypoints offer no way. There may be one all the same.
    SceneError
        There is no such robot, or ``delta`` is negative or not finite.

    Notes
    -----
    Source, section 5.5.2: u' = u ± (m + δ) n with n the unit normal of the line and m = max |(g − s) × (s − v)| /
    |g − s| over the vertices v of the obstacle. The source counts one entry and one exit an obstacle; here a line that
    crosses an obstacle more often has as many.

    >>> from taut.scene import Rectangle
    >>> robot = Robot("R1", (1, 4), (9, 4))
    >>> route = central_path(Scene((0, 0, 10, 9), [Rectangle(4, 3, 2, 2, name="box")], [robot]), robot)
    >>> route.points.tolist(), [c.name for c in route.crossed], route.free
    ([[1.0, 4.0], [4.0, 5.5], [6.0, 5.5], [9.0, 4.0]], ['box'], True)
    """
    index = indexed(world)
    scene = index.scene
    traveller = scene.robot(robot)
    if not (math.isfinite(delta) and delta >= 0):
        raise SceneError(f"robot {traveller.name}: delta must be a number of metres ≥ 0, got {delta!r}")
    growth, tol = scene.growth(traveller), scene.tol
    baseline = np.array([traveller.start, traveller.goal], dtype=np.float64)
    _require_free_ends(index, traveller, growth)
    wall = wall_of(scene)
    near = [solid_of(scene.obstacles[k]) for k in obstacles_near(index, baseline, growth)]
    met = [(solid, _crossed(solid, baseline, growth, tol)) for solid in near]
    solids = [solid for solid, crossed in met if crossed is not None]
    crossed = tuple(crossed for _, crossed in met if crossed is not None)
    kept: list[Waypoint] = []
    dropped: list[tuple[Waypoint, str]] = []
    for waypoint in _waypoints(baseline, crossed, delta):
        reason = _refused(waypoint, solids, wall, growth, tol)
        if reason:
            dropped.append((waypoint, reason))
        else:
            kept.append(waypoint)
    roadmap = _joined(np.array([*baseline.tolist(), *(w.place for w in kept)]), [*solids, wall], growth, tol)
    points = _shortest(traveller, roadmap, crossed, tol)
    return CentralRoute(points, baseline, crossed, tuple(kept), tuple(dropped), roadmap, hits_of(index, points, growth))


def _require_free_ends(index: ObstacleIndex, robot: Robot, growth: float) -> None:
    """Raise as `FreeSpace.require` if start or goal is blocked; only what is near them is looked at."""
    ends = (obstacles_near(index, [end], growth) for end in (robot.start, robot.goal))
    near = np.unique(np.concatenate([*ends]))
    scene = index.scene.with_obstacles([index.scene.obstacles[k] for k in near])
    try:
        FreeSpace(scene, growth).require(robot)
    except (StartBlocked, GoalBlocked) as error:
        place = robot.start if isinstance(error, StartBlocked) else robot.goal
        raise too_near(index, type(error), place, growth, robot) from None
    except NoPath:
        pass


def _crossed(solid: Solid, baseline: FloatArray, growth: float, tol: float) -> Crossed | None:
    a, b = baseline
    spans = spans_in(solid, a, b, growth, tol)
    if not len(spans) or (a == b).all():
        return None
    crossings = a + spans.reshape(-1, 1) * (b - a)
    normal = _normal(baseline)
    reach = float(np.abs((solid.sides.reshape(-1, 2) - a) @ normal).max()) + solid.radius + growth
    return Crossed(solid.name, crossings, reach)


def _normal(baseline: FloatArray) -> FloatArray:
    """Unit vector to the left of the baseline."""
    x, y = baseline[1] - baseline[0]
    return np.array([-y, x]) / math.hypot(x, y)


def _waypoints(baseline: FloatArray, crossed: tuple[Crossed, ...], delta: float) -> list[Waypoint]:
    out = []
    for obstacle in crossed:
        step = (obstacle.reach + delta) * _normal(baseline)
        for k, u in enumerate(obstacle.crossings):
            for side in (1, -1):
                x, y = (u + side * step).tolist()
                out.append(Waypoint((x, y), obstacle.name, k, side))
    return out


def _refused(waypoint: Waypoint, solids: list[Solid], wall: Solid, growth: float, tol: float) -> str:
    """Why a waypoint cannot be used, in words; nothing if it can."""
    place = waypoint.place
    grown = f" grown by {growth:g} m" if growth else ""
    if depth_in(wall, place, 0.0) > tol:
        return "outside the workspace"
    if depth_in(wall, place, growth) > tol:
        return f"nearer than {growth:g} m to the wall"
    inside = [solid.name for solid in solids if depth_in(solid, place, growth) > tol]
    return f"inside {' and '.join(inside)}{grown}" if inside else ""


def _joined(positions: FloatArray, solids: list[Solid], growth: float, tol: float) -> Roadmap:
    """All pairs of places whose straight way passes through none of the solids."""
    sides = np.concatenate([solid.sides for solid in solids])
    first = np.cumsum([0, *(len(solid.sides) for solid in solids)])
    reach = np.array([solid.radius + growth for solid in solids])
    filled = np.array([solid.filled for solid in solids])
    pairs = np.argwhere(_hit_kernels.free_pairs(positions, sides, first, filled, reach, tol))
    lengths = np.hypot(*(positions[pairs[:, 1]] - positions[pairs[:, 0]]).T)
    return Roadmap(positions, Graph.from_edges(len(positions), pairs, lengths))


def _shortest(robot: Robot, roadmap: Roadmap, crossed: tuple[Crossed, ...], tol: float) -> FloatArray:
    graph = roadmap.graph
    # left and right of the baseline are mirror images: rounding must not decide between them
    unit = 2.0 ** math.floor(math.log2(tol))
    distance, before = dijkstra(Graph(graph.indptr, graph.indices, np.round(graph.weights / unit) * unit), 0)
    if not math.isfinite(distance[1]):
        raise NoCentralPath(robot.name, crossed)
    path = [1]
    while path[-1] != 0:
        path.append(int(before[path[-1]]))
    points: FloatArray = roadmap.positions[path[::-1]]
    moved = np.append(True, (np.diff(points, axis=0) != 0).any(axis=1))
    return np.asarray(points[moved])
