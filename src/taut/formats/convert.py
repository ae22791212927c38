"""Scenes and plans as plain data (dicts, lists, strings, numbers) and back, without loss."""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping
from typing import Any

import numpy as np
from pydantic import ValidationError

from taut.errors import OutputError, PlanError, SceneError
from taut.formats import schema
from taut.formats._document import Document, Place, shown
from taut.formats._wording import fault, shorten
from taut.motion import Plan, Trajectory
from taut.scene import Circle, Line, Obstacle, Polygon, Rectangle, Robot, Scene

_NO_METRICS: Mapping[str, Any] = {}


def scene_to_dict(scene: Scene) -> dict[str, Any]:
    """Return a scene as plain data, as scene files hold it; whole numbers as int.

    >>> scene_to_dict(Scene((0, 0, 4, 3)))["bounds"]
    [0, 0, 4, 3]
    """
    return {
        "taut": 1,
        **({"name": scene.name} if scene.name else {}),
        **_outline(scene),
        "clearance": tidy(scene.clearance),
        "gap": tidy(scene.gap),
        "headway": tidy(scene.headway),
        "at_goal": scene.at_goal,
        "obstacles": [obstacle_to_dict(obstacle) for obstacle in scene.obstacles],
        "robots": [robot_to_dict(robot) for robot in scene.robots],
    }


def scene_from_dict(data: Any, file: str | None = None) -> Scene:
    """Return the scene that plain data describes.

    Parameters
    ----------
    data : as a scene file holds it: dicts, lists, strings and numbers.
    file : named in errors.

    Raises
    ------
    SceneError
        Anything missing, unknown, of the wrong type or sign; one line that names the robot or obstacle.
    """
    return scene_of(Document(data, lambda place: None, file))


def plan_to_dict(plan: Plan) -> dict[str, Any]:
    """Return a plan as plain data, as plan files hold it.

    Numbers in `planner`, `claims`, `lower_bound` and `certificate` that are not finite become None.

    Raises
    ------
    OutputError
        Those hold something else than mappings, lists, texts, numbers and None.
    """
    metrics: dict[str, Any] = {"sum_of_costs": plan.sum_of_costs, "makespan": plan.makespan, "length": plan.length}
    if plan.lower_bound is not None:
        metrics["lower_bound"] = _plain(plan.lower_bound, "lower_bound")
    return {
        "taut": 1,
        "kind": "plan",
        "scene": scene_to_dict(plan.scene),
        "planner": _plain(plan.planner, "planner"),
        "claims": _plain(plan.claims, "claims"),
        "robots": [{"name": t.name, "stamps": _tidy_points(t.stamps.tolist())} for t in plan.trajectories],
        "metrics": metrics,
        **({} if plan.certificate is None else {"certificate": _plain(plan.certificate, "certificate")}),
    }


def plan_from_dict(data: Any, file: str | None = None) -> Plan:
    """Return the plan that plain data describes; its metrics are computed anew, never believed.

    Raises
    ------
    PlanError
        Anything wrong with the plan or the scene in it.
    """
    return plan_of(Document(data, lambda place: None, file))


def scene_of(document: Document) -> Scene:
    """Return the scene of a document; SceneError with its line."""
    if isinstance(document.data, dict) and document.data.get("kind") == "plan":
        raise document.error("this is a plan, not a scene; its scene is under the key `scene`", ("kind",))
    try:
        entry = schema.SceneFile.model_validate(document.data)
    except ValidationError as error:
        raise fault(document, error) from None
    return _scene(entry, document, ())


def plan_of(document: Document) -> Plan:
    """Return the plan of a document; PlanError with its line."""
    try:
        data = document.data
        if (
            isinstance(data, dict)
            and "kind" not in data
            and "scene" not in data
            and not {"workspace", "bounds"}.isdisjoint(data)
        ):
            raise document.error("this is a scene, not a plan")
        try:
            entry = schema.PlanFile.model_validate(data)
        except ValidationError as error:
            raise fault(document, error) from None
        return _plan(entry, document)
    except PlanError:
        raise
    except SceneError as error:
        raise PlanError(error.message, error.file, error.line) from None


def obstacle_to_dict(obstacle: Obstacle) -> dict[str, Any]:
    """Return the entry of one obstacle."""
    match obstacle:
        case Polygon():
            return {"name": obstacle.name, "polygon": _tidy_points(obstacle.points)}
        case Circle():
            return {"name": obstacle.name, "circle": _tidy_list(obstacle.center), "radius": tidy(obstacle.radius)}
        case Rectangle():
            box = _tidy_list((obstacle.x, obstacle.y, obstacle.width, obstacle.height))
            angle = {} if _is_zero(obstacle.angle) else {"angle": tidy(obstacle.angle)}
            return {"name": obstacle.name, "rectangle": box, **angle}
        case Line():
            return {"name": obstacle.name, "line": _tidy_points(obstacle.points), "width": tidy(obstacle.width)}


def robot_to_dict(robot: Robot) -> dict[str, Any]:
    """Return the entry of one robot; what the scene decides is left out."""
    return {
        "name": robot.name,
        "start": _tidy_list(robot.start),
        "goal": _tidy_list(robot.goal),
        "radius": tidy(robot.radius),
        "speed": tidy(robot.speed),
        **({} if robot.clearance is None else {"clearance": tidy(robot.clearance)}),
        **({} if _is_zero(robot.start_time) else {"start_time": tidy(robot.start_time)}),
        **({} if robot.at_goal is None else {"at_goal": robot.at_goal}),
    }


def tidy(number: float) -> int | float:
    """Return a whole number as int where that loses nothing, not even the sign of zero."""
    number = float(number)
    if number.is_integer() and abs(number) < 1e15 and (number or _is_zero(number)):
        return int(number)
    return number


def _is_zero(number: float) -> bool:
    return number == 0.0 and math.copysign(1.0, number) > 0


def _tidy_list(numbers: Iterable[float]) -> list[int | float]:
    return [tidy(number) for number in numbers]


def _tidy_points(points: Iterable[Iterable[float]]) -> list[list[int | float]]:
    return [_tidy_list(point) for point in points]


def _outline(scene: Scene) -> dict[str, Any]:
    """Return `bounds` where they give back the very same corners (also the signs of zeros), else `workspace`."""
    corners = scene.workspace
    (xmin, ymin), (xmax, ymax) = corners[0], corners[2]
    if repr(corners) == repr(((xmin, ymin), (xmax, ymin), (xmax, ymax), (xmin, ymax))) and xmin < xmax and ymin < ymax:
        return {"bounds": _tidy_list((xmin, ymin, xmax, ymax))}
    return {"workspace": _tidy_points(corners)}


def _scene(entry: schema.SceneFile, document: Document, root: Place) -> Scene:
    given = document.data["scene"] if root else document.data
    for key in ("obstacles", "robots"):
        _refuse_doubles([item.name for item in getattr(entry, key)], (*root, key), document)
    obstacles = [_obstacle(item, document, (*root, "obstacles", k)) for k, item in enumerate(entry.obstacles)]
    robots = [_robot(item, document, (*root, "robots", k)) for k, item in enumerate(entry.robots)]
    outline = entry.bounds if entry.workspace is None else entry.workspace
    try:
        return Scene(
            outline or (),
            obstacles,
            robots,
            name=entry.name,
            clearance=entry.clearance,
            gap=entry.gap,
            headway=entry.headway,
            at_goal=entry.at_goal,
        )
    except SceneError as error:
        raise document.error(error.message, (*root, "bounds" if "bounds" in given else "workspace")) from None


def _refuse_doubles(names: list[str | None], place: Place, document: Document) -> None:
    seen: set[str] = set()
    for k, name in enumerate(names):
        if name is None:
            continue
        if name in seen:
            message = f"two {place[-1]} are named {shorten(name)}; every name must be unique"
            raise document.error(message, (*place, k, "name"))
        seen.add(name)


def _obstacle(entry: Any, document: Document, place: Place) -> Obstacle:
    name = entry.name or ""
    try:
        match entry:
            case schema.PolygonEntry():
                return Polygon(entry.polygon, name)
            case schema.CircleEntry():
                return Circle((entry.circle[0], entry.circle[1]), entry.radius, name)
            case schema.RectangleEntry():
                x, y, width, height = entry.rectangle
                return Rectangle(x, y, width, height, entry.angle, name)
            case _:
                return Line(entry.line, entry.width, name)
    except SceneError as error:
        raise document.error(error.message, place) from None


def _robot(entry: schema.RobotEntry, document: Document, place: Place) -> Robot:
    try:
        return Robot(
            entry.name,
            (entry.start[0], entry.start[1]),
            (entry.goal[0], entry.goal[1]),
            radius=entry.radius,
            speed=entry.speed,
            clearance=entry.clearance,
            start_time=entry.start_time,
            at_goal=entry.at_goal,
        )
    except SceneError as error:
        raise document.error(error.message, place) from None


def _plan(entry: schema.PlanFile, document: Document) -> Plan:
    scene = _scene(entry.scene, document, ("scene",))
    trajectories = []
    for k, item in enumerate(entry.robots):
        try:
            trajectories.append(Trajectory(item.name, np.array(item.stamps, dtype=np.float64)))
        except PlanError as error:
            raise document.error(error.message, ("robots", k, "stamps")) from None
    lower_bound = (entry.metrics or _NO_METRICS).get("lower_bound")
    if lower_bound is not None and not _is_bound(lower_bound):
        message = f"lower_bound must be a mapping of model (text) and value (seconds), got {shown(lower_bound)}"
        raise document.error(message, ("metrics", "lower_bound"))
    try:
        return Plan(
            scene,
            tuple(trajectories),
            planner=entry.planner or {},
            claims=document.data.get("claims") or {},  # as they are written: defaults are not filled in
            lower_bound=lower_bound,
            certificate=entry.certificate,
        )
    except PlanError as error:
        raise document.error(error.message, ("robots",)) from None


def _is_bound(value: Any) -> bool:
    if not isinstance(value, dict) or not isinstance(value.get("model"), str) or "value" not in value:
        return False
    seconds = value["value"]
    return seconds is None or (isinstance(seconds, int | float) and not isinstance(seconds, bool))


def _plain(value: Any, where: str) -> Any:
    if value is None or isinstance(value, str | bool | int):
        return value
    if isinstance(value, np.generic | np.ndarray):
        return _plain(value.tolist(), where)
    if isinstance(value, float):
        return value if math.isfinite(value) else None
    if isinstance(value, Mapping):
        return {str(key): _plain(item, f"{where}.{key}") for key, item in value.items()}
    if isinstance(value, list | tuple):
        return [_plain(item, where) for item in value]
    raise OutputError(f"{where} of the plan holds {shown(value)}, which a file cannot hold")
