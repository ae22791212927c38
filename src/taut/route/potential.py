"""Artificial potential fields as generators of paths: quick, local, and caught in minima; this one says where."""

from __future__ import annotations

import math
from dataclasses import dataclass
from operator import index

import numpy as np
import shapely
from numpy.typing import ArrayLike

from taut.errors import GoalBlocked
from taut.freespace import FreeSpace
from taut.geometry.growth import grown
from taut.geometry.triangulation import Floats, Ints, Triangulation
from taut.route import _potential_kernels
from taut.route.along import not_connected
from taut.route.core import Route, in_turn, points_of, require_free
from taut.scene import Point

_WALL = "the wall"


@dataclass(frozen=True, eq=False)
class PotentialRoute(Route):
    """The way down an artificial potential, to the goal or to where it is caught.

    Parameters
    ----------
    points : (k, 2) metres, from the start to the goal, or to ``stuck_at``.
    stuck_at : where no step lowers the potential or the steps given were over; None if the goal was reached.
    held_by : names of the obstacles that repel there, the nearest first; "the wall" stands for the workspace.
    """

    points: Floats
    stuck_at: Point | None
    held_by: tuple[str, ...]

    @property
    def reached(self) -> bool:
        """Whether the route ends at the goal."""
        return self.stuck_at is None


def potential_path(
    freespace: FreeSpace,
    a: ArrayLike,
    b: ArrayLike,
    attraction: float = 1.0,
    repulsion: float = 1.0,
    influence: float | None = None,
    step: float | None = None,
    steps: int = 20_000,
) -> PotentialRoute:
    """Go from a to b down the artificial potential of `potential_at`.

    Each step follows the force, is halved until it stays in the free space and lowers the potential enough, and may be
    twice as long as the one before. Where the goal is seen within a step, the route goes straight there.

    Parameters
    ----------
    a, b : start and goal, (2,) metres.
    attraction, repulsion : weights > 0 of goal and obstacles, without unit.
    influence : metres within which obstacles repel; None for a fortieth of the side of a square as large as the free
        space.
    step : metres of the longest step; None for an eighth of the influence.
    steps : the most steps, at least 1.

    Returns
    -------
    The route: see `PotentialRoute.reached`. Being caught is usual, so it is no error.

    Raises
    ------
    StartBlocked, GoalBlocked
        ``a`` or ``b`` is not in free space.
    NoPath
        Obstacles separate them.
    ValueError
        ``a`` or ``b`` is not one point, or one of the numbers is not finite and positive.

    Notes
    -----
    Known to be caught: in front of flat obstacles and in bays on the way; between obstacles nearer to each other than
    the influence; short of goals that are near an obstacle; right behind an obstacle in line with the goal.

    >>> from taut import FreeSpace, Scene
    >>> potential_path(FreeSpace(Scene((0, 0, 4, 3))), (1, 1), (3, 2)).reached
    True
    """
    given = in_turn(a, b)
    if len(given) != 2:
        raise ValueError(f"a and b must be one point (x, y) each, got {len(given) // 2}")
    law = _law(freespace, attraction, repulsion, influence)
    longest = law[2] / 8 if step is None else _positive(step, "step", " in metres")
    most = _steps(steps)
    ends, triangles = freespace.anchor(given)
    require_free(freespace, given, triangles)
    start_parts, goal_parts = freespace.part_of(given)
    if not start_parts & goal_parts:
        raise not_connected(freespace, given[0], given[1])
    mesh = freespace.mesh
    around = mesh.vertex_start, mesh.vertex_wedges, *mesh.grid
    points, reached = _potential_kernels.descend(*_shape(mesh), *around, ends, triangles, law, longest, most)
    points[0] = given[0]
    if reached:
        points[-1] = given[1]
        moved = np.append(True, (points[1:] != points[:-1]).any(axis=1))
        return PotentialRoute(points[moved], None, ())
    x, y = points[-1].tolist()
    return PotentialRoute(points, (x, y), _holding(freespace, x, y, law))


def potential_at(
    freespace: FreeSpace,
    goal: ArrayLike,
    points: ArrayLike,
    attraction: float = 1.0,
    repulsion: float = 1.0,
    influence: float | None = None,
) -> tuple[Floats, Floats]:
    """Artificial potential and its force at (k, 2) points, for a goal (2,).

    With ρ₀ the influence, the goal at distance d contributes attraction · (d − ρ₀ / 2), and within ρ₀ of it
    attraction · d² / (2 ρ₀). Each place of the boundary of free space, at a distance ρ < ρ₀, that is nearer than its
    neighbours on either side contributes repulsion · ρ₀ (ρ₀ / ρ − 1)² / 2: one of each convex obstacle and of each
    straight wall. They are added; the force is the negative gradient. Nearer than ρ₀ / 1,024 the force grows no
    further. What lies behind obstacles does not repel, unless the free space leads there within the influence.

    Parameters
    ----------
    attraction, repulsion, influence : as in `potential_path`.

    Returns
    -------
    potential : (k,) metres; inf where a point is not free.
    force : (k, 2) without unit.

    Raises
    ------
    GoalBlocked
        ``goal`` is not in free space.
    ValueError
        ``goal`` is not one point, or one of the numbers is not finite and positive.

    Notes
    -----
    The sum jumps where a nearest place comes or goes at the end of a wall.
    Source: Khatib, Real-time obstacle avoidance for manipulators and mobile robots, IJRR 1986 (the FIRAS function);
    Latombe, Robot Motion Planning, 1991, chapter 7 (the conic potential far from the goal).

    >>> from taut import FreeSpace, Scene
    >>> potential, force = potential_at(FreeSpace(Scene((0, 0, 4, 4))), (3, 2), [(1, 2)], influence=1)
    >>> potential.tolist(), force.tolist()
    ([1.5], [[1.0, 0.0]])
    """
    target = points_of(goal, "goal")
    if len(target) != 1:
        raise ValueError(f"goal must be one point (x, y), got {len(target)}")
    law = _law(freespace, attraction, repulsion, influence)
    xy, triangles = freespace.anchor(np.concatenate([target, points_of(points, "points")]))
    (x, y), others = xy[0].tolist(), (xy[1:], triangles[1:])
    if triangles[0] < 0:
        raise GoalBlocked(f"goal ({x:g}, {y:g}) is not in free space (growth {freespace.growth:g} m)")
    found = _potential_kernels.potentials(*_shape(freespace.mesh), *others, x, y, law)
    return found[:, 0].copy(), found[:, 1:].copy()


def _shape(mesh: Triangulation) -> tuple[Floats, Ints, Ints, Ints, Ints, Ints]:
    return mesh.vertices, mesh.triangles, mesh.neighbours, mesh.wedges, mesh.wedge_of, mesh.wedge_turns


def _law(freespace: FreeSpace, attraction: float, repulsion: float, influence: float | None) -> Floats:
    """Attraction, repulsion and influence, checked."""
    reach = math.sqrt(freespace.area) / 40 if influence is None else _positive(influence, "influence", " in metres")
    return np.array([_positive(attraction, "attraction"), _positive(repulsion, "repulsion"), reach])


def _positive(value: float, what: str, unit: str = "") -> float:
    if not (value > 0 and math.isfinite(value)):
        raise ValueError(f"{what} must be a positive number{unit}, got {value!r}")
    return float(value)


def _steps(value: int) -> int:
    try:
        steps = index(value)
    except TypeError:
        steps = 0
    if steps < 1:
        raise ValueError(f"steps must be a whole number, at least 1, got {value!r}")
    return steps


def _holding(freespace: FreeSpace, x: float, y: float, law: Floats) -> tuple[str, ...]:
    """Names of the obstacles that repel at a free place, the nearest first."""
    triangle = freespace.mesh.locate(np.array([[x, y]]))[0]
    places = _potential_kernels.repelling_places(*_shape(freespace.mesh), triangle, x, y, law)
    places = places[np.argsort(places[:, 2], kind="stable")]
    reach = freespace.growth * (1 + freespace.arc_error) + law[2] + freespace.scene.tol
    spots = shapely.points(places[:, :2])
    owned = np.zeros(len(places), dtype=np.bool_)
    found: list[tuple[int, str]] = []
    for obstacle in freespace.scene.obstacles:
        own = reach + obstacle.own_radius * (1 + freespace.arc_error)
        (left, low), (right, high) = obstacle.core.min(axis=0) - own, obstacle.core.max(axis=0) + own
        if left <= x <= right and low <= y <= high:
            touched = shapely.dwithin(
                spots, grown(obstacle, freespace.growth, freespace.arc_error), freespace.scene.tol
            )
            found += [(int(i), obstacle.name) for i in np.flatnonzero(touched)[:1]]
            owned |= touched
    found += [(int(i), _WALL) for i in np.flatnonzero(~owned)[:1]]
    return tuple(name for _, name in sorted(found))
