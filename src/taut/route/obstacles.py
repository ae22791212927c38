"""ObstacleIndex: which of many obstacles come near a polyline or each other; nothing is grown to find out."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import shapely
from numpy.typing import ArrayLike, NDArray

from taut.errors import GoalBlocked, SceneError, StartBlocked, rounded_down
from taut.geometry.cores import Shapes, cores_of
from taut.geometry.triangulation import Floats, Ints
from taut.scene import Point, Robot, Scene

NEAR = 16.0
"""Things within so many tolerances of each other count as near; a little more is no harm."""

_PIECES = 64
"""Long polylines are looked up in so many pieces, whose boxes hold little else."""


@dataclass(frozen=True, eq=False)
class ObstacleIndex:
    """The obstacles of a scene in a spatial index, as they are: it serves robots of every size.

    Parameters
    ----------
    scene : the world.
    cores : (m,) shapes of the obstacles without their own radius.
    own_radius : (m,) metres by which each reaches beyond its core.
    tree : boxes round the obstacles, own radius included.
    """

    scene: Scene
    cores: Shapes
    own_radius: Floats
    tree: shapely.STRtree


def index_obstacles(scene: Scene) -> ObstacleIndex:
    """Index the obstacles of a scene.

    Raises
    ------
    SceneError
        An obstacle crosses or touches itself or has no area.

    >>> from taut import Circle
    >>> index_obstacles(Scene((0, 0, 4, 3), [Circle((1, 1), 0.5)])).own_radius
    array([0.5])
    """
    cores = cores_of(scene.obstacles)
    valid = shapely.is_valid(cores) | (shapely.get_type_id(cores) != shapely.GeometryType.POLYGON)
    if not valid.all():
        k = int(np.argmin(valid))
        raise SceneError(
            f"obstacle {scene.obstacles[k].name} is not a simple polygon ({shapely.is_valid_reason(cores[k])}); "
            "its sides must not cross or touch each other"
        )
    own_radius = np.array([o.own_radius for o in scene.obstacles], dtype=np.float64)
    boxes = shapely.bounds(cores).reshape(-1, 4) + own_radius[:, None] * [-1, -1, 1, 1]
    return ObstacleIndex(scene, cores, own_radius, shapely.STRtree(shapely.box(*boxes.T)))


def indexed(world: Scene | ObstacleIndex) -> ObstacleIndex:
    """Return the index of a scene, or the index itself."""
    return world if isinstance(world, ObstacleIndex) else index_obstacles(world)


def obstacles_near(index: ObstacleIndex, points: ArrayLike, growth: float = 0.0, arc_error: float = 1e-3) -> Ints:
    """Numbers of the obstacles, ascending, that touch a polyline once they are grown.

    Parameters
    ----------
    index : see `index_obstacles`.
    points : (k, 2) metres, k ≥ 1.
    growth : metres, as of `FreeSpace`.
    arc_error : as of `FreeSpace`.

    Returns
    -------
    (n,) : all that come within the tolerance of the polyline, and perhaps some that miss it by a little more.

    >>> from taut import Circle
    >>> index = index_obstacles(Scene((0, 0, 9, 3), [Circle((1, 1), 1), Circle((8, 2), 1)]))
    >>> obstacles_near(index, [(0, 0), (9, 0)]), obstacles_near(index, [(0, 0), (9, 0)], growth=1)
    (array([0]), array([0, 1]))
    """
    line = _polyline(np.asarray(points, dtype=np.float64))
    length = float(shapely.length(line))
    pieces = shapely.segmentize(line, length / _PIECES) if length > 0 else line
    own = float(index.own_radius.max(initial=0.0))
    margin = growth * (1 + arc_error) + own * arc_error + 2 * NEAR * index.scene.tol
    found = np.unique(index.tree.query(_sides(pieces), predicate="dwithin", distance=margin)[1])
    reach = (index.own_radius[found] + growth) * (1 + arc_error) + NEAR * index.scene.tol
    shapely.prepare(line)
    touched: NDArray[np.bool_] = shapely.dwithin(line, index.cores[found], reach)
    return found[touched].astype(np.int64)


def obstacles_beside(index: ObstacleIndex, numbers: Ints, count: int, but: Ints) -> Ints:
    """Numbers of the obstacles whose boxes are nearest to those of the given ones, nearest first, (``count``,) or all.

    Parameters
    ----------
    index : see `index_obstacles`.
    numbers : (k,) the given ones, k ≥ 1; they are not returned.
    count : how many to find, ≥ 0.
    but : others that are not returned.

    >>> from taut import Circle
    >>> index = index_obstacles(Scene((0, 0, 9, 3), [Circle((1, 1), 1), Circle((8, 2), 1), Circle((4, 2), 1)]))
    >>> obstacles_beside(index, np.array([0]), 1, but=np.array([1]))
    array([2])
    """
    boxes = index.tree.geometries
    wanted = np.ones(len(boxes), dtype=np.bool_)
    wanted[numbers] = wanted[but] = False
    count = min(count, int(np.count_nonzero(wanted)))
    within = float(shapely.length(boxes[numbers]).mean()) / 4
    while True:
        given, other = index.tree.query(boxes[numbers], predicate="dwithin", distance=within)
        given, other = given[wanted[other]], other[wanted[other]]
        found = np.unique(other)
        if len(found) >= count:
            break
        within *= 2
    distance = np.full(len(boxes), np.inf)
    np.minimum.at(distance, other, shapely.distance(boxes[numbers[given]], boxes[other]))
    return found[np.argsort(distance[found], kind="stable")[:count]].astype(np.int64)


def too_near(
    index: ObstacleIndex,
    error: type[StartBlocked] | type[GoalBlocked],
    place: Point,
    growth: float,
    robot: Robot | None = None,
) -> StartBlocked | GoalBlocked:
    """Return the error that says what a start or goal is too near to and how much clearance would fit the robot."""
    word = "start" if error is StartBlocked else "goal"
    who = "" if robot is None else f"robot {robot.name}: "
    where = f"{who}{word} ({place[0]:g}, {place[1]:g})"
    needed = f"{growth:g} m"
    if robot is not None:
        needed += f" (radius {robot.radius:g} + clearance {growth - robot.radius:g})"
    here = shapely.Point(place)
    wall = shapely.Polygon(index.scene.workspace)
    if not wall.covers(here):
        return error(f"{where} lies outside the workspace; move it inside")
    near = obstacles_near(index, [place], growth)
    cores, own_radius = index.cores[near], index.own_radius[near]
    solid = shapely.contains_properly(cores, here)
    depth = shapely.distance(shapely.boundary(cores), here)
    rooms = np.append(np.where(solid, -depth, shapely.distance(cores, here) - own_radius), wall.exterior.distance(here))
    names = [*(f"obstacle {index.scene.obstacles[k].name}" for k in near), "the wall"]
    order = [k for k in np.argsort(rooms, kind="stable") if rooms[k] < growth]
    if not order:
        return error(f"{where} has no room but a gap of zero width, or where rounded corners meet; move it")
    room = float(rooms[order[0]])
    others = f" (and too near to {', '.join(names[k] for k in order[1:4])})" if len(order) > 1 else ""
    if room < 0:
        return error(f"{where} lies inside {names[order[0]]}{others}; move it")
    short = f"{where} is only {room:.6g} m from {names[order[0]]}{others} but needs {needed}"
    if robot is None:
        return error(f"{short}; move it")
    if room - robot.radius <= index.scene.tol:
        return error(f"{short}; move it, no clearance would fit")
    fits = rounded_down(room - robot.radius + index.scene.tol / 2)
    return error(f"{short}; move it or keep a clearance of at most {fits} m")


def _polyline(points: Floats) -> shapely.Geometry:
    return shapely.LineString(points) if len(points) > 1 else shapely.Point(points[0])


def _sides(line: shapely.Geometry) -> Shapes:
    at = shapely.get_coordinates(line)
    if len(at) == 1:
        return np.array([line], dtype=object)
    sides: Shapes = shapely.linestrings(np.stack([at[:-1], at[1:]], axis=1))
    return sides
