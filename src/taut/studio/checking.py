"""All problems of a scene at once, each with those it concerns and the place where it is to be shown.

Validation stops at the first problem. Here what may be bad is found by itself: entries, shapes, starts and goals, pairs
of robots. Each is then put to validation alone, with the little that is near it, and told in validation's own words.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import replace
from typing import Any, TypeAlias, TypeVar

import numpy as np
import shapely
from scipy.spatial import KDTree

from taut.errors import SceneError, one_line
from taut.formats import scene_from_dict
from taut.geometry.triangulation import Ints
from taut.route.obstacles import index_obstacles
from taut.scene import FloatArray, Obstacle, Point, Robot, Scene
from taut.validation import check_form, validate

Thing = TypeVar("Thing")
Problem: TypeAlias = dict[str, Any]

_ROOM = (-1.0, -1.0, 1.0, 1.0)
_NEAR = 4.0  # tolerances beyond what is needed: so near, validation decides
_ALONE = "R"  # what a robot is called while it is looked at alone


def checked(data: Any) -> dict[str, list[Any]]:
    """Return {"problems": …, "notes": …} of a scene given as plain data; see `problems`.

    Notes are what a person should know about a scene that can be used; one with problems has none.
    """
    found, scene = _read(data)
    if scene is not None:
        try:
            notes = validate(scene)
        except SceneError as error:
            found += list(_problems(scene)) or [problem(error.message, "scene")]
        else:
            if not found:
                return {"problems": [], "notes": list(notes)}
    return {"problems": found, "notes": []}


def problems(data: Any) -> list[Problem]:
    """Return all problems of a scene given as plain data; none if and only if it can be planned in.

    Of robots that stand too near to each other, one that was told to be too near to another is left out of further
    pairs.

    Returns
    -------
    list of dict
        {"message": a sentence, "kind": "scene", "robot", "obstacle" or "pair", "names": of those concerned, "place":
        [x, y] in metres or None, "end": "start" or "goal" where it is about one, else None}.
    """
    return checked(data)["problems"]


def problem(
    message: str, kind: str, names: Sequence[str] = (), place: Sequence[float] | None = None, end: str | None = None
) -> Problem:
    """Return one problem as plain data; a place that is not finite is none."""
    at = None if place is None or not all(map(math.isfinite, place)) else [float(c) for c in place]
    return {"message": one_line(message), "kind": kind, "names": list(names), "place": at, "end": end}


def _read(data: Any) -> tuple[list[Problem], Scene | None]:
    """Problems of the entries, and the scene without those; None where the rest of the scene cannot be read either."""
    try:
        return [], scene_from_dict(data)
    except SceneError as error:
        whole = error
    found: list[Problem] = []
    kept: dict[str, list[Any]] = {}
    for key in ("obstacles", "robots"):
        entries = data.get(key) if isinstance(data, dict) else None
        if not isinstance(entries, list):
            return [problem(whole.message, "scene")], None
        bad = _bad_entries(key, entries)
        found += bad.values()
        kept[key] = [entry for k, entry in enumerate(entries) if k not in bad]
    try:
        return found, scene_from_dict({**data, **kept})
    except SceneError as error:
        return [*found, problem(error.message, "scene")], None


def _bad_entries(key: str, entries: Sequence[Any]) -> dict[int, Problem]:
    """Problems of obstacles or robots as a file holds them, by their number."""
    kind = key.removesuffix("s")
    called = [
        {"name": f"number {k + 1}", **entry} if isinstance(entry, dict) and key == "obstacles" else entry
        for k, entry in enumerate(entries)
    ]
    empty = {"taut": 1, "bounds": list(_ROOM), "obstacles": [], "robots": []}

    def read(numbers: Sequence[int]) -> None:
        scene_from_dict({**empty, key: [called[k] for k in numbers]})

    bad: dict[int, Problem] = {}
    numbers = list(range(len(entries)))
    for k, error in _faulty(numbers, read):
        bad[k] = problem(error.message, kind, _name_in(entries[k]), _place_in(entries[k]))
    seen: set[str] = set()
    for k in numbers:
        if k in bad:
            continue
        name = called[k]["name"]
        if name in seen:
            bad[k] = problem(
                f"two {key} are named {name}; every name must be unique", kind, [name], _place_in(called[k])
            )
        seen.add(name)
    return dict(sorted(bad.items()))


def _name_in(entry: Any) -> list[str]:
    name = entry.get("name") if isinstance(entry, Mapping) else None
    return [name] if isinstance(name, str) else []


def _place_in(entry: Any) -> list[float] | None:
    """The first point that an entry holds, whatever else is wrong with it."""
    if not isinstance(entry, Mapping):
        return None
    for key in ("start", "circle", "polygon", "line", "rectangle", "goal"):
        value = entry.get(key)
        while isinstance(value, list) and value and isinstance(value[0], list):
            value = value[0]
        if isinstance(value, list) and len(value) >= 2 and all(type(c) in (int, float) for c in value[:2]):
            return [float(c) for c in value[:2]]
    return None


def _problems(scene: Scene) -> Iterator[Problem]:
    """All problems of a scene that validation refuses."""
    try:
        check_form(replace(scene, obstacles=(), robots=()))
    except SceneError as error:
        yield problem(error.message, "scene")
        return
    shapeless = dict(_faulty(scene.obstacles, lambda some: check_form(Scene(_ROOM, some))))
    for obstacle, wrong in shapeless.items():
        yield problem(wrong.message, "obstacle", [obstacle.name], _middle(obstacle.core))
    unfit = dict(_faulty(scene.robots, lambda some: check_form(Scene(_ROOM, (), some, gap=1.0))))
    for robot, wrong in unfit.items():
        yield problem(wrong.message, "robot", [robot.name], robot.start)
    robots = [robot for robot in scene.robots if robot not in unfit]
    try:
        check_form(_part(scene, (), robots))
    except SceneError as error:
        points = [robot for robot in robots if robot.radius == 0][:2]
        place = _middle([robot.start for robot in points]) if points else None
        yield problem(error.message, "pair" if len(points) == 2 else "scene", [r.name for r in points], place)
    yield from _places(scene, [o for o in scene.obstacles if o not in shapeless], robots)
    yield from _pairs(scene, robots)


def _faulty(things: Sequence[Thing], check: Callable[[Sequence[Thing]], None]) -> Iterator[tuple[Thing, SceneError]]:
    """Find those that a check refuses alone, by halves: O(log n) checks for each."""
    if not things:
        return
    try:
        check(things)
    except SceneError as error:
        if len(things) == 1:
            yield things[0], error
            return
        half = len(things) // 2
        yield from _faulty(things[:half], check)
        yield from _faulty(things[half:], check)


def _part(scene: Scene, obstacles: Sequence[Obstacle], robots: Sequence[Robot]) -> Scene:
    """The scene with some of its things only; its tolerance stays."""
    out = replace(scene, obstacles=tuple(obstacles), robots=tuple(robots))
    vars(out)["tol"] = scene.tol
    return out


def _places(scene: Scene, obstacles: Sequence[Obstacle], robots: Sequence[Robot]) -> Iterator[Problem]:
    """Starts and goals too near to a wall or an obstacle, or shut in between them."""
    if not robots:
        return
    index = index_obstacles(scene.with_obstacles(obstacles))
    growths = np.array([scene.growth(robot) for robot in robots]) + _NEAR * scene.tol
    workspace = shapely.Polygon(scene.workspace)
    for end in ("start", "goal"):
        points = shapely.points(np.array([getattr(robot, end) for robot in robots], dtype=np.float64))
        at, near = index.tree.query(points, predicate="dwithin", distance=growths)
        close = shapely.distance(points[at], index.cores[near]) <= growths[at] + index.own_radius[near]
        at, near = at[close], near[close]
        hemmed = shapely.dwithin(points, workspace.exterior, growths) | ~shapely.covers(workspace, points)
        for k in np.union1d(at, np.flatnonzero(hemmed)).tolist():
            place = getattr(robots[k], end)
            alone = replace(robots[k], name=_ALONE, start=place, goal=place)
            try:
                validate(_part(scene, [obstacles[j] for j in near[at == k]], [alone]))
            except SceneError as error:
                said = error.message.removeprefix(f"robot {_ALONE}: start")
                yield problem(f"robot {robots[k].name}: {end}{said}", "robot", [robots[k].name], place, end)


def _pairs(scene: Scene, robots: Sequence[Robot]) -> Iterator[Problem]:
    """Robots that stand too near to each other at their starts, and for good at their goals."""
    for end in ("start", "goal"):
        there = [r for r in robots if scene.stays(r) or (end == "start" and r.start != r.goal)]
        places = np.array([getattr(robot, end) for robot in there], dtype=np.float64).reshape(-1, 2)
        told: set[int] = set()
        for i, j in _close(scene, there, places).tolist():
            if i in told or j in told:
                continue
            pair = _standing(scene, (there[i], there[j]), end)
            try:
                validate(pair)
            except SceneError as error:
                told.add(j)
                names = [there[i].name, there[j].name]
                yield problem(error.message, "pair", names, _middle(places[[i, j]]), end)


def _close(scene: Scene, robots: Sequence[Robot], places: FloatArray) -> Ints:
    """Pairs (k, 2) of robots in order that stand nearer than they may, or nearly so."""
    if len(robots) < 2:
        return np.empty((0, 2), dtype=np.int64)
    radii = np.array([robot.radius for robot in robots])
    slack = scene.gap + _NEAR * scene.tol
    pairs = KDTree(places).query_pairs(2 * radii.max() + slack, output_type="ndarray")
    i, j = np.sort(pairs.reshape(-1, 2), axis=1).T
    near = np.hypot(*(places[i] - places[j]).T) < radii[i] + radii[j] + slack
    order = np.lexsort((j[near], i[near]))
    return np.stack([i[near], j[near]], axis=1)[order].astype(np.int64)


def _standing(scene: Scene, pair: tuple[Robot, Robot], end: str) -> Scene:
    """A room in which nothing can be wrong but that two robots stand too near to each other at one of their ends."""
    x, y = _middle([getattr(robot, end) for robot in pair])
    size = sum(robot.radius for robot in pair) + scene.gap + math.dist(*(getattr(robot, end) for robot in pair)) + 1.0
    robots = []
    for robot, side in zip(pair, (-4 * size, 4 * size), strict=True):
        here, away = getattr(robot, end), (x + side, y)
        start, goal = (here, away) if end == "start" else (away, here)
        robots.append(Robot(robot.name, start, goal, radius=robot.radius))
    out = Scene((x - 8 * size, y - 8 * size, x + 8 * size, y + 8 * size), (), robots, gap=scene.gap)
    vars(out)["tol"] = scene.tol
    return out


def _middle(points: Sequence[Point] | FloatArray) -> Point:
    """The middle of the box round some points."""
    low, high = np.min(points, axis=0), np.max(points, axis=0)
    x, y = (low / 2 + high / 2).tolist()
    return x, y
