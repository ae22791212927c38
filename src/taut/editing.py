"""One obstacle more or less on what was made for a map: shortest paths prepared, or a plan."""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING, overload

from taut.errors import SceneError
from taut.route import PathIndex, editing
from taut.scene import Obstacle

if TYPE_CHECKING:
    from taut.motion import Plan
    from taut.team import Replanned


@overload
def with_obstacle(made: PathIndex, obstacle: Obstacle) -> PathIndex: ...
@overload
def with_obstacle(made: Plan, obstacle: Obstacle) -> Replanned: ...
def with_obstacle(made: PathIndex | Plan, obstacle: Obstacle) -> PathIndex | Replanned:
    """Add an obstacle to a prepared map, or to the map of a plan.

    A prepared map changes where the obstacle is (see `taut.route.with_obstacle`). Of a plan all robots that are not
    concerned keep their motions, and it is said who does not and why (see `taut.replan`).

    Raises
    ------
    SceneError
        Its name is taken, or the obstacle crosses or touches itself; with a plan, it stands on a start or goal.
    NoPath, NoPlanFound
        With a plan: a robot does not get through any more.

    >>> from taut import FreeSpace, Rectangle, Scene, distances, prepare
    >>> index = prepare(FreeSpace(Scene((0, 0, 8, 2))))
    >>> distances(with_obstacle(index, Rectangle(3, 0, 2, 1)), [(0, 0)], [(8, 0)]).round(4)
    array([8.3246])
    """
    if isinstance(made, PathIndex):
        return editing.with_obstacle(made, obstacle)
    _require_plan(made)
    from taut.team import replan

    return replan(made, replace(made.scene, obstacles=(*made.scene.obstacles, obstacle)))


@overload
def without_obstacle(made: PathIndex, name: str) -> PathIndex: ...
@overload
def without_obstacle(made: Plan, name: str) -> Replanned: ...
def without_obstacle(made: PathIndex | Plan, name: str) -> PathIndex | Replanned:
    """Remove the obstacle of this name from a prepared map, or from the map of a plan.

    All motions of a plan are kept, though some robots might find a shorter way now.

    Raises
    ------
    SceneError
        There is no such obstacle.
    """
    if isinstance(made, PathIndex):
        return editing.without_obstacle(made, name)
    _require_plan(made)
    from taut.team import replan

    left = tuple(obstacle for obstacle in made.scene.obstacles if obstacle.name != name)
    if len(left) == len(made.scene.obstacles):
        raise SceneError(f"there is no obstacle {name}; name one of the scene")
    return replan(made, replace(made.scene, obstacles=left))


def _require_plan(made: object) -> None:
    from taut.motion import Plan

    if not isinstance(made, Plan):
        raise TypeError(f"obstacles are added to a PathIndex or a Plan, not to a {type(made).__name__}")
