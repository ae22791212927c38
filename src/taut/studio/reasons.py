"""Why something asked for could not be done, as plain data: in a sentence, and on the map where it has a place."""

from __future__ import annotations

from typing import Any

import numpy as np
import shapely

from taut.errors import (
    GoalBlocked,
    NoPath,
    NoPlanExists,
    NoPlanFound,
    OutputError,
    PlanError,
    SceneError,
    StartBlocked,
    TautError,
    one_line,
)
from taut.formats import scene_to_dict
from taut.freespace import FreeSpace
from taut.route import widest_passage
from taut.scene import Robot, Scene
from taut.studio.checking import problems

Rings = list[list[list[float]]]

_KINDS: tuple[tuple[type[TautError], str], ...] = (
    (NoPath, "no path"),
    (NoPlanFound, "no plan found"),
    (NoPlanExists, "no plan exists"),
    (StartBlocked, "robot"),
    (GoalBlocked, "robot"),
    (PlanError, "plan"),
    (SceneError, "scene"),
    (OutputError, "output"),
)


def wrong(error: TautError, scene: Scene | None = None) -> dict[str, Any]:
    """Return an error as the page is told it.

    Parameters
    ----------
    error : what was raised.
    scene : the scene that it was about, if it was about one.

    Returns
    -------
    dict
        {"message", "kind", "names", "place", "time", "line", "why"}; what is not known is None. Kinds are "no path",
        "no plan found", "no plan exists", "plan", "output", "error" and those of `taut.studio.checking.problems`.
    """
    kind = next((kind for known, kind in _KINDS if isinstance(error, known)), "error")
    out: dict[str, Any] = {
        "message": str(error),
        "kind": kind,
        "names": list(getattr(error, "robots", ())),
        "place": getattr(error, "place", None),
        "time": getattr(error, "time", None),
        "line": getattr(error, "line", None),
        "why": None if scene is None else why(scene, error),
    }
    if isinstance(error, NoPath):
        out["names"] = [error.robot] if error.robot else []
        gap = None if out["why"] is None else out["why"]["gap"]
        out["place"] = None if gap is None else gap["place"]
    elif isinstance(error, SceneError) and scene is not None:
        told = problems(scene_to_dict(scene))
        first = next((one for one in told if one["message"] == error.message), told[0] if told else None)
        out |= {} if first is None else {key: first[key] for key in ("kind", "names", "place")}
    return out


def why(scene: Scene, error: TautError) -> dict[str, Any] | None:
    """Say on the map why there is no path or no plan; None where the error says all.

    Returns
    -------
    dict
        {"from": rings, "to": rings, "gap": {…} | None, "sentences": […]}. Rings bound the area that the centre of the
        robot can reach from its start, and that from which it reaches its goal; what lies in an odd number of them
        belongs to it. The gap is the narrowest place of the widest way: {"place", "ends": its two sides, "between":
        names, "room": metres between them, "needed": metres}.
    """
    if isinstance(error, NoPlanFound | NoPlanExists):
        return {"from": [], "to": [], "gap": None, "sentences": list(error.diagnosis)}
    if not isinstance(error, NoPath) or not error.robot:
        return None
    robot = scene.robot(error.robot)
    freespace = FreeSpace.of(scene, robot)
    start, goal = freespace.part_of([robot.start, robot.goal])
    if start & goal:
        said = (
            f"{robot.name} has a way through free space; the roadmap does not join its start and goal: choose another"
        )
        return {"from": [], "to": [], "gap": None, "sentences": [one_line(said)]}
    gap = _gap(scene, robot, freespace.growth)
    return {
        "from": rings_of(freespace, start),
        "to": rings_of(freespace, goal),
        "gap": gap,
        "sentences": [one_line(_sentence(robot, freespace.growth, gap))],
    }


def rings_of(freespace: FreeSpace, parts: frozenset[int]) -> Rings:
    """Return the outlines of some parts of a free space, outer ones and those of holes, in metres."""
    mesh = freespace.mesh
    polygons = shapely.get_parts(freespace.region)
    tree = shapely.STRtree(polygons)
    out: Rings = []
    for part in sorted(parts):
        corners = mesh.vertices[mesh.triangles[mesh.parts == part]]
        a, b = corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]
        # the middle of the largest triangle is surely inside the polygon that the part is of
        inside = corners[np.argmax(np.abs(a[:, 0] * b[:, 1] - a[:, 1] * b[:, 0]))].mean(axis=0)
        polygon = polygons[tree.query_nearest(shapely.Point(inside), all_matches=False)[0]]
        out += rings_in(polygon)
    return out


def rings_in(region: shapely.Geometry) -> Rings:
    """Return the rings of polygons, each without its closing repeat, in metres."""
    rings = shapely.get_rings(shapely.get_parts(region))
    return [shapely.get_coordinates(ring)[:-1].tolist() for ring in rings]


def _gap(scene: Scene, robot: Robot, growth: float) -> dict[str, Any]:
    passage = widest_passage(scene, robot.start, robot.goal)
    return {
        "place": list(passage.place),
        "ends": passage.ends.tolist(),
        "between": list(passage.between),
        "room": 2 * passage.clearance,
        "needed": 2 * growth,
    }


def _sentence(robot: Robot, growth: float, gap: dict[str, Any]) -> str:
    x, y = gap["place"]
    where, between = f"near ({x:.2f}, {y:.2f})", " and ".join(gap["between"])
    needs = f"{robot.name} needs {gap['needed']:.4g} m (twice radius + clearance)"
    if gap["room"] == 0:
        return f"{between} leave no way at all {where}; {needs}."
    return f"The widest way is narrowest between {between} {where}: {gap['room']:.4g} m, but {needs}."
