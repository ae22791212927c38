"""OCA: the shortest route of one robot among only the obstacles that matter, as exact as among all of them.

Leaving obstacles out only adds paths. So the route among a few obstacles is no longer than the one among all, and when
no other obstacle comes near it, it is allowed among all and is the shortest there. Otherwise those that do are taken in
too, and the search is repeated. Source of the idea: F. A. S. Alwafi, Social Graphs and Their Applications to Robotics,
section 5.7, where the obstacles are those that the straight line crosses.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import ArrayLike

from taut.errors import GoalBlocked, NoPath, SceneError, StartBlocked
from taut.freespace import FreeSpace
from taut.geometry.triangulation import Floats, Ints
from taut.route.core import Route
from taut.route.direct import shortest_path
from taut.route.obstacles import ObstacleIndex, indexed, obstacles_beside, obstacles_near, too_near
from taut.route.passage import Passage, widest_passage
from taut.scene import FloatArray, Robot, Scene

_COARSE = 0.1
"""First rounds draw arcs as coarse as this, as `FreeSpace` means it: they only find obstacles, exact rounds decide."""


@dataclass(frozen=True, eq=False)
class OcaRound:
    """One search among the obstacles taken so far.

    Parameters
    ----------
    added : names of the obstacles that were not there in the round before.
    points : (k, 2) metres, the route found.
    expanded : triangles that the search looked through.
    hit : names of the obstacles left out that the route touches once they are grown; empty in the last round.
    arc_error : how coarsely arcs were drawn, as `FreeSpace` means it; first rounds draw them more coarsely.
    """

    added: tuple[str, ...]
    points: FloatArray
    expanded: int
    hit: tuple[str, ...]
    arc_error: float


@dataclass(frozen=True, eq=False)
class OcaRoute(Route):
    """A shortest route and what was needed to find it.

    Parameters
    ----------
    points : (k, 2) metres, from start to goal; one row if they are the same place.
    growth : metres by which obstacles were grown: radius plus clearance.
    clearance : metres kept beyond the radius.
    wanted : metres of clearance asked for; more than ``clearance`` where no way keeps as much.
    used : names of the obstacles taken, in that order.
    total : how many obstacles the scene has.
    rounds : the searches, in turn.
    freespace : that of the obstacles used.
    passage : the narrowest place of the widest way, where no way keeps the clearance asked for; else None.
    """

    growth: float
    clearance: float
    wanted: float
    used: tuple[str, ...]
    total: int
    rounds: tuple[OcaRound, ...]
    freespace: FreeSpace
    passage: Passage | None = None

    @property
    def optimal(self) -> bool:
        """Whether the route is proved to be shortest in the free space of the whole scene, grown by ``growth``."""
        last = self.rounds[-1]
        return not last.hit and last.arc_error == self.freespace.arc_error


def oca_path(
    world: Scene | ObstacleIndex, robot: str | Robot, clearance: float | None = None, arc_error: float = 1e-3
) -> OcaRoute:
    """Find a shortest allowed path of one robot, looking only at the obstacles that matter.

    Parameters
    ----------
    world : the scene; or, where many paths are asked for, its index (`index_obstacles`).
    robot : a robot of the scene, or its name.
    clearance : metres to keep beyond the radius, instead of the robot's own clearance.
    arc_error : as of `FreeSpace`.

    Returns
    -------
    OcaRoute
        As short as `shortest_path` in the `FreeSpace` of the whole scene.

    Raises
    ------
    SceneError
        There is no such robot, or the clearance is negative or not finite.
    StartBlocked, GoalBlocked
        Start or goal is too near to an obstacle or the wall; says which and how much clearance would fit.
    NoPath
        Obstacles separate them.

    Notes
    -----
    A round that follows a hit has half as many obstacles again as the one before, or more, so that m obstacles take
    O(log m) rounds. The wall of the workspace is part of every round.

    >>> from taut import Rectangle
    >>> scene = Scene((0, 0, 8, 4), [Rectangle(3, 0, 2, 3), Rectangle(3, 3.5, 2, 0.5)], [Robot("R1", (1, 3), (7, 3))])
    >>> oca_path(scene, "R1").length, oca_path(scene, "R1").used
    (6.0, ('O1',))
    """
    index = indexed(world)
    own = index.scene.robot(robot)
    return _solved(index, *_with_clearance(index.scene, own, clearance), arc_error)


def oca_path_or_widest(
    world: Scene | ObstacleIndex, robot: str | Robot, clearance: float | None = None, arc_error: float = 1e-3
) -> OcaRoute:
    """Find a shortest path with the clearance asked for or, where there is none, with the most that some path keeps.

    Parameters, errors and result are those of `oca_path`, but for NoPath: it means that not even the radius fits.
    Where `OcaRoute.clearance` is less than `OcaRoute.wanted`, `OcaRoute.passage` tells where the widest way is
    narrowest. Radius and clearance are a hair less than its room, as corners are rounded outside: by the share
    ``arc_error``, or the least multiple of it by a power of two for which there is a path.

    >>> from taut import Rectangle
    >>> scene = Scene((0, 0, 8, 4), [Rectangle(3, 0, 2, 3)], [Robot("R1", (1, 1), (7, 1))])
    >>> route = oca_path_or_widest(scene, "R1", clearance=0.6)
    >>> route.wanted, round(route.clearance, 2)
    (0.6, 0.5)
    """
    index = indexed(world)
    own = index.scene.robot(robot)
    scene, wanting = _with_clearance(index.scene, own, clearance)
    try:
        return _solved(index, scene, wanting, arc_error)
    except NoPath:
        return replace(_widest(index, own, arc_error), wanted=_clearance(scene, wanting))


def oca_between(
    world: Scene | ObstacleIndex, a: ArrayLike, b: ArrayLike, growth: float = 0.0, arc_error: float = 1e-3
) -> OcaRoute:
    """Find a shortest allowed path between two points, looking only at the obstacles that matter.

    ``growth`` is in metres, a robot's radius plus its clearance. Raises and returns as `oca_path`.

    >>> oca_between(Scene((0, 0, 4, 3)), (0, 0), (3, 0)).length
    3.0
    """
    index = indexed(world)
    for place, name in ((a, "a"), (b, "b")):
        if np.shape(place) != (2,) or not np.isfinite(place).all():
            raise ValueError(f"{name} must be one point (x, y) of finite numbers, got {place!r}")
    if not (growth >= 0 and math.isfinite(growth)):
        raise SceneError(f"growth must be a number ≥ 0, got {growth!r}")
    ends = np.array([a, b], dtype=np.float64)
    try:
        return _search(index, index.scene, ends, growth, arc_error)
    except (StartBlocked, GoalBlocked) as error:
        blocked = type(error)
        raise too_near(index, blocked, tuple(ends[0 if blocked is StartBlocked else 1].tolist()), growth) from None


def _clearance(scene: Scene, robot: Robot) -> float:
    return scene.clearance if robot.clearance is None else robot.clearance


def _with_clearance(scene: Scene, robot: Robot, clearance: float | None) -> tuple[Scene, Robot]:
    """The scene, without its obstacles, in which the robot has this clearance, and that robot."""
    bare = scene.with_obstacles(())
    if clearance is None:
        return bare, robot
    changed = replace(robot, clearance=clearance)
    out = replace(bare, robots=tuple(changed if r is robot else r for r in bare.robots))
    vars(out)["tol"] = scene.tol
    return out, changed


def _solved(index: ObstacleIndex, scene: Scene, robot: Robot, arc_error: float) -> OcaRoute:
    """Find the path of a robot of ``scene``, whose obstacles are those of the index; errors name the robot."""
    ends = np.array([robot.start, robot.goal])
    growth = scene.growth(robot)
    clearance = _clearance(scene, robot)
    try:
        found = _search(index, scene, ends, growth, arc_error)
    except NoPath as error:
        raise NoPath(robot.name, error.reason) from None
    except (StartBlocked, GoalBlocked) as error:
        place = robot.start if isinstance(error, StartBlocked) else robot.goal
        raise too_near(index, type(error), place, growth, robot) from None
    return replace(found, clearance=clearance, wanted=clearance)


def _search(index: ObstacleIndex, scene: Scene, ends: Floats, growth: float, arc_error: float) -> OcaRoute:
    """Take in obstacles until the route among them touches no other; ``scene`` has the robots that count."""
    obstacles = index.scene.obstacles

    def named(numbers: Ints) -> tuple[str, ...]:
        return tuple(obstacles[k].name for k in numbers)

    used = np.empty(0, dtype=np.int64)
    hit = obstacles_near(index, ends, growth, arc_error)
    told = 0
    rounds: list[OcaRound] = []
    fine = [(growth, arc_error)]
    rounded = growth > 0 or bool(index.own_radius.any())
    # such arcs reach no farther than asked, save about round obstacles; fine arcs confirm whatever they find
    coarse = [(growth / (1 + _COARSE), _COARSE)] if rounded and arc_error < _COARSE else []
    for reach, error in coarse + fine:
        while True:
            used = np.append(used, _taken(index, used, hit))
            freespace = _among(index, scene, used, reach, error)
            try:
                route = shortest_path(freespace, *ends)
            except (NoPath, StartBlocked, GoalBlocked):
                if error == arc_error:
                    raise
                hit = hit[:0]
                break
            near = obstacles_near(index, route.points, growth, arc_error)
            hit = np.setdiff1d(near, used)
            rounds.append(OcaRound(named(used[told:]), route.points, route.expanded, named(hit), error))
            told = len(used)
            if not len(hit):
                break
    return OcaRoute(route.points, growth, growth, growth, named(used), len(obstacles), tuple(rounds), freespace)


def _taken(index: ObstacleIndex, used: Ints, hit: Ints) -> Ints:
    """What to take in next: what was hit and, if that is less than half as many as are used, what is nearest to it."""
    more = len(used) // 2 - len(hit)
    return hit if more <= 0 or not len(hit) else np.append(hit, obstacles_beside(index, hit, more, but=used))


def _among(index: ObstacleIndex, scene: Scene, used: Ints, growth: float, arc_error: float) -> FreeSpace:
    obstacles = index.scene.obstacles
    return FreeSpace(scene.with_obstacles([obstacles[k] for k in np.sort(used)]), growth, arc_error)


def _widest(index: ObstacleIndex, robot: Robot, arc_error: float) -> OcaRoute:
    """Find a shortest path that keeps nearly as much clearance as any can."""
    passage = widest_passage(index.scene, robot.start, robot.goal)
    excess = arc_error
    # rounded corners may reach too far by more than the share of the clearance: round obstacles grow from their centre
    while excess < 1 and passage.clearance > robot.radius * (1 + excess):
        kept = passage.clearance / (1 + excess) - robot.radius
        try:
            found = _solved(index, *_with_clearance(index.scene, robot, kept), arc_error)
        except NoPath:
            excess *= 2
        else:
            return replace(found, passage=passage)
    return replace(_solved(index, *_with_clearance(index.scene, robot, 0.0), arc_error), passage=passage)
