"""All problems of a scene at once, each with those it concerns and the place where it is to be shown.

Validation stops at the first problem. Here what may be bad is found by itself: entries, shapes, starts and goals, pairs
of robots. Each is then put to validation alone, with the little that is near it, and told in validation's own words. Of
each sort only so many are looked at one by one, and that there are more is told.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import replace
from itertools import islice
from typing import Any, TypeAlias, TypeVar

import numpy as np
import shapely
from scipy.spatial import KDTree

from taut.errors import SceneError, one_line
from taut.formats import scene_from_dict
from taut.route.obstacles import index_obstacles
from taut.scene import FloatArray, Obstacle, Point, Robot, Scene
from taut.validation import check_form, validate

Thing = TypeVar("Thing")
Problem: TypeAlias = dict[str, Any]

_ROOM = (-1.0, -1.0, 1.0, 1.0)
_NEAR = 4.0  # tolerances beyond what is needed: so near, validation decides
_MOST = 100  # problems of a sort that are told one by one; who has more mends these first
_NEAREST = 200  # obstacles that a place is looked at with: validation names the nearest
_BATCH = 64  # robots, or boxes, that are looked at together
_HEAP = 2_000_000  # pairs of boxes that meet: beyond, what pairs are needed for takes too long and too much room
_ALONE = "R"  # what a robot is called while it is looked at alone
_NOT_TOLD = "so many obstacles, starts and goals lie on each other that it is not told which do"


def checked(data: Any) -> dict[str, list[Any]]:
    """Return {"problems": …, "notes": …} of a scene given as plain data; see `problems`.

    Notes are what a person should know about a scene that can be used; one with problems has none.
    """
    found, scene = _read(data)
    if scene is not None and _is_heap(scene):
        found += _problems(scene)
        return {"problems": found, "notes": [] if found else [_NOT_TOLD]}
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


def _more(kind: str) -> Problem:
    """The problem that stands for all that are not told."""
    return problem(f"more {kind} have such problems: told are the first {_MOST}", "scene")


def _is_heap(scene: Scene) -> bool:
    """Whether so many obstacles, starts and goals lie on each other that not all pairs of them can be looked at."""
    low, high = [], []
    for obstacle in scene.obstacles:
        low.append(obstacle.core.min(axis=0) - obstacle.own_radius)
        high.append(obstacle.core.max(axis=0) + obstacle.own_radius)
    growths = np.array([scene.growth(robot) + scene.gap for robot in scene.robots]).reshape(-1, 1)
    for end in ("start", "goal"):
        places = np.array([getattr(robot, end) for robot in scene.robots], dtype=np.float64).reshape(-1, 2)
        low.extend(places - growths)
        high.extend(places + growths)
    if len(low) ** 2 <= _HEAP:
        return False
    boxes = shapely.box(*np.hstack([np.array(low), np.array(high)]).T)
    tree = shapely.STRtree(boxes)
    met = 0
    for first in range(0, len(boxes), _BATCH):
        met += tree.query(boxes[first : first + _BATCH]).shape[1]
        if met > _HEAP:
            return True
    return False


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
        found += list(bad.values())[:_MOST]
        if len(bad) > _MOST:  # what there would be without the others is not known
            return [*found, _more(key)], None
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
    for k, error in islice(_faulty(numbers, read), _MOST + 1):
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
    shapeless = dict(islice(_faulty(scene.obstacles, lambda some: check_form(Scene(_ROOM, some))), _MOST + 1))
    for obstacle, wrong in list(shapeless.items())[:_MOST]:
        yield problem(wrong.message, "obstacle", [obstacle.name], _middle(obstacle.core))
    unfit = dict(islice(_faulty(scene.robots, lambda some: check_form(Scene(_ROOM, (), some, gap=1.0))), _MOST + 1))
    for robot, wrong in list(unfit.items())[:_MOST]:
        yield problem(wrong.message, "robot", [robot.name], robot.start)
    for kind, faulty in (("obstacles", shapeless), ("robots", unfit)):
        if len(faulty) > _MOST:  # with those that are left nothing can be computed
            yield _more(kind)
            return
    robots = [robot for robot in scene.robots if robot not in unfit]
    try:
        check_form(_part(scene, (), robots))
    except SceneError as error:
        points = [robot for robot in robots if robot.radius == 0][:2]
        place = _middle([robot.start for robot in points]) if points else None
        yield problem(error.message, "pair" if len(points) == 2 else "scene", [r.name for r in points], place)
    sound = [obstacle for obstacle in scene.obstacles if obstacle not in shapeless]
    for end in ("start", "goal"):
        yield from _first(_places(scene, sound, robots, end), "robots")
    for end in ("start", "goal"):
        yield from _first(_pairs(scene, robots, end), "robots")


def _first(told: Iterator[Problem], kind: str) -> Iterator[Problem]:
    """The first problems, and whether there are more."""
    yield from islice(told, _MOST)
    if next(told, None) is not None:
        yield _more(kind)


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


def _places(scene: Scene, obstacles: Sequence[Obstacle], robots: Sequence[Robot], end: str) -> Iterator[Problem]:
    """Starts, or goals, too near to a wall or an obstacle, or shut in between them."""
    index = index_obstacles(scene.with_obstacles(obstacles))
    workspace = shapely.Polygon(scene.workspace)
    for first in range(0, len(robots), _BATCH):
        some = robots[first : first + _BATCH]
        growths = np.array([scene.growth(robot) for robot in some]) + _NEAR * scene.tol
        points = shapely.points(np.array([getattr(robot, end) for robot in some], dtype=np.float64))
        at, near = index.tree.query(points, predicate="dwithin", distance=growths)
        room = shapely.distance(points[at], index.cores[near]) - index.own_radius[near]
        close = room <= growths[at]
        at, near, room = at[close], near[close], room[close]
        hemmed = shapely.dwithin(points, workspace.exterior, growths) | ~shapely.covers(workspace, points)
        for k in np.union1d(at, np.flatnonzero(hemmed)).tolist():
            here = np.flatnonzero(at == k)
            nearest = np.sort(here[np.argsort(room[here], kind="stable")[:_NEAREST]])
            place = getattr(some[k], end)
            alone = replace(some[k], name=_ALONE, start=place, goal=place)
            try:
                validate(_part(scene, [obstacles[j] for j in near[nearest]], [alone]))
            except SceneError as error:
                said = error.message.removeprefix(f"robot {_ALONE}: start")
                yield problem(f"robot {some[k].name}: {end}{said}", "robot", [some[k].name], place, end)


def _pairs(scene: Scene, robots: Sequence[Robot], end: str) -> Iterator[Problem]:
    """Robots that stand too near to each other at their starts, or for good at their goals."""
    there = [r for r in robots if scene.stays(r) or (end == "start" and r.start != r.goal)]
    if len(there) < 2:
        return
    places = np.array([getattr(robot, end) for robot in there], dtype=np.float64)
    radii = np.array([robot.radius for robot in there])
    slack = scene.gap + _NEAR * scene.tol
    tree = KDTree(places)
    told = np.zeros(len(there), dtype=bool)
    for i in range(len(there)):
        if told[i]:
            continue
        reach = radii[i] + radii.max() + slack
        others = np.array(tree.query_ball_point(places[i], reach, return_sorted=True), dtype=np.int64)
        others = others[(others > i) & ~told[others]]
        near = np.hypot(*(places[others] - places[i]).T) < radii[i] + radii[others] + slack
        for j in others[near].tolist():
            try:
                validate(_standing(scene, (there[i], there[j]), end))
            except SceneError as error:
                told[j] = True
                names = [there[i].name, there[j].name]
                yield problem(error.message, "pair", names, _middle(places[[i, j]]), end)


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
