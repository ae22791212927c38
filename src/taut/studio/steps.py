"""The steps of an algorithm on a scene, as marks to draw and sentences to read."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from types import MappingProxyType
from typing import Any

from taut.errors import SceneError
from taut.scene import Robot, Scene
from taut.studio.steps_central import central_steps, oca_steps
from taut.studio.steps_mrppa import mrppa_steps
from taut.studio.steps_search import search_steps
from taut.validation import validate

_OF_ONE: Mapping[str, Callable[[Scene, Robot], dict[str, Any]]] = MappingProxyType(
    {
        "ca": central_steps,
        "oca": oca_steps,
        "dijkstra": lambda scene, robot: search_steps(scene, robot, "dijkstra"),
        "astar": lambda scene, robot: search_steps(scene, robot, "astar"),
    }
)
ALGORITHMS = ("mrppa", *_OF_ONE)


def steps_of(scene: Scene, kind: str, robot: str | None, settings: Mapping[str, Any]) -> dict[str, Any]:
    """Run an algorithm and return how it comes to its end.

    Parameters
    ----------
    scene : the world.
    kind : one of `ALGORITHMS`.
    robot : the name of the robot for which a path is sought; None takes the first. With "mrppa" all are planned.
    settings : with "mrppa", see `taut.studio.answers.plan_with`.

    Returns
    -------
    dict
        {"base": marks under all steps, "points": lists of places that marks refer to by number, "steps": see
        `taut.studio.marks.step`}.

    Raises
    ------
    SceneError
        A scene that cannot be used, without robots or without this one; another algorithm.
    NoPath, NoPlanExists, NoPlanFound
        As the algorithm itself.
    """
    if kind not in ALGORITHMS:
        raise SceneError(f"there are steps of {', '.join(ALGORITHMS)}, not of {kind!r}")
    validate(scene)
    if not scene.robots:
        raise SceneError("no robots: nothing to plan; add at least one robot with a start and a goal")
    if kind == "mrppa":
        return mrppa_steps(scene, settings)
    return _OF_ONE[kind](scene, scene.robots[0] if robot is None else scene.robot(robot))
