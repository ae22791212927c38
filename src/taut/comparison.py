"""Every way of finding routes side by side on one scene: length, clearance, turns, size and time, each route proved."""

from __future__ import annotations

import math
import time
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from operator import index

import numpy as np
import shapely

from taut.certificate import Problem, certify
from taut.errors import GoalBlocked, NoPath, SceneError, StartBlocked
from taut.freespace import FreeSpace
from taut.generate.likeness import scene_like
from taut.motion import Plan, Trajectory
from taut.roadmap import Roadmap
from taut.route import WAYS, Answer, oca_path, shortest_path
from taut.scene import Circle, FloatArray, Line, Obstacle, Rectangle, Robot, Scene
from taut.validation import check_form

Tell = Callable[[str], None]


@dataclass(frozen=True, eq=False)
class Trial:
    """What one way found for one robot.

    Parameters
    ----------
    robot : its name.
    solved : whether the route is proved to be allowed, from start to goal.
    reason : why it is not solved, in words; empty if it is.
    points : (k, 2) metres, the route found, allowed or not; None if there is none.
    length : metres, of that route.
    ratio : length over that of the shortest route; None unless solved, or if there is no shortest route.
    clearance : least distance of the disc from obstacles and wall, metres beyond its radius.
    turns : how many bends the route has.
    turning : radians, all its turns added up.
    vertices, edges, obstacles : what was searched and looked at, see `taut.route.ways.Answer`.
    seconds : a question took: the median of several, after one that is not counted.
    """

    robot: str
    solved: bool
    reason: str
    points: FloatArray | None
    length: float | None
    ratio: float | None
    clearance: float | None
    turns: int | None
    turning: float | None
    vertices: int | None
    edges: int | None
    obstacles: int | None
    seconds: float


@dataclass(frozen=True, eq=False)
class Entry:
    """One way and what it found for each robot.

    Parameters
    ----------
    way : its name in `taut.route.ways.WAYS`.
    build_seconds : to prepare it, once for all robots of one growth, summed over the growths.
    trials : one a robot, in the scene's order.
    roadmaps : by growth in metres, if the way has any.
    """

    way: str
    build_seconds: float
    trials: tuple[Trial, ...]
    roadmaps: Mapping[float, Roadmap]


@dataclass(frozen=True, eq=False)
class Comparison:
    """All ways on one scene.

    Parameters
    ----------
    scene : the scene.
    seed : of everything random.
    shortest : (n,) metres, the shortest route of each robot; nan where there is none.
    blocked : of each robot whose start or goal is not free, by name: what it is too near to and what would fit.
    entries : one a way.
    """

    scene: Scene
    seed: int
    shortest: FloatArray
    blocked: Mapping[str, str]
    entries: tuple[Entry, ...]


@dataclass(frozen=True)
class Summary:
    """One way over all its robots; means and totals are over the solved ones, None if there are none.

    Parameters
    ----------
    way : its name.
    solved, robots : how many of how many.
    mean_ratio, worst_ratio : length over that of the shortest route.
    length : metres, total.
    mean_clearance, least_clearance : metres beyond the radius.
    mean_turns, mean_turning : bends, and radians.
    vertices, edges, obstacles : means over the robots that got a route, allowed or not.
    build_seconds : total.
    query_seconds : median over all robots.
    """

    way: str
    solved: int
    robots: int
    mean_ratio: float | None
    worst_ratio: float | None
    length: float | None
    mean_clearance: float | None
    least_clearance: float | None
    mean_turns: float | None
    mean_turning: float | None
    vertices: float | None
    edges: float | None
    obstacles: float | None
    build_seconds: float
    query_seconds: float | None


def compare(
    scene: Scene, ways: Sequence[str] | None = None, seed: int = 0, repeats: int = 1, tell: Tell | None = None
) -> Comparison:
    """Let every way find a route for every robot, and prove each route.

    Robots are taken one by one, as if each were alone. A route counts as solved only if `certify` proves it, driven at
    top speed in the scene as it is, so no way is taken at its word.

    Parameters
    ----------
    ways : names in `taut.route.ways.WAYS`; None takes all.
    seed : of the ways that throw dice, ≥ 0.
    repeats : questions that are timed, each robot and way, after one that is not.
    tell : is told how far it is, in words.

    Raises
    ------
    ValueError
        An unknown way, a negative seed, no repeats.
    SceneError
        A ring that is none, numbers out of range. That a start or goal is not free is none: nobody solves that robot.

    Notes
    -----
    Compiling is not timed: each way is first tried on a small scene. The shortest route is that of `shortest_path` in
    the `FreeSpace`. A way that does not keep to that may have a ratio below 1, or solve a robot that has no shortest
    route: corners are rounded outside by `FreeSpace.arc_error`, and gaps just as wide as the robot are closed, while
    the proof is of distances and allows its tolerance.

    >>> from taut import Rectangle
    >>> scene = Scene((0, 0, 8, 4), [Rectangle(3, 0, 2, 3)], [Robot("R1", (1, 1), (7, 1))])
    >>> trial = compare(scene, ["visibility"]).entries[0].trials[0]
    >>> trial.solved, trial.turns, round(trial.length, 4), trial.clearance
    (True, 2, 7.6569, 0.0)
    """
    names, seed, repeats = _names(ways), _whole(seed, "seed", 0), _whole(repeats, "repeats", 1)
    _warm_up(names)
    return _compared(scene, names, seed, repeats, tell or _silent)


def compare_random(
    scene: Scene,
    count: int,
    ways: Sequence[str] | None = None,
    seed: int = 0,
    repeats: int = 1,
    tell: Tell | None = None,
) -> tuple[Comparison, ...]:
    """Compare on ``count`` ≥ 1 random scenes like this one (see `scene_like`), of seed, seed + 1 and so on.

    The seed of a scene is also that of its ways. Roadmaps are not kept. Else as `compare`.

    Raises
    ------
    ValueError
        As `compare`; or ``count`` is below 1.
    SceneError
        As `compare`; or as many robots and obstacles do not fit.
    """
    names, seed, repeats = _names(ways), _whole(seed, "seed", 0), _whole(repeats, "repeats", 1)
    count, tell = _whole(count, "count", 1), tell or _silent
    _warm_up(names)
    out = []
    for k in range(count):
        tell(f"scene {k + 1} of {count}")
        found = _compared(scene_like(scene, seed + k), names, seed + k, repeats, _silent)
        out.append(replace(found, entries=tuple(replace(entry, roadmaps={}) for entry in found.entries)))
    return tuple(out)


def compare_clearances(
    scene: Scene,
    clearances: Sequence[float],
    ways: Sequence[str] | None = None,
    seed: int = 0,
    repeats: int = 1,
    tell: Tell | None = None,
) -> tuple[Comparison, ...]:
    """Compare on this scene with the clearance of all robots (the thesis' D_s) set to each of these, in metres.

    A clearance that swallows a start or goal is no error: nobody solves that robot. Roadmaps are not kept. Else as
    `compare`.

    Raises
    ------
    ValueError
        As `compare`.
    SceneError
        As `compare`; or a clearance is negative or not finite.
    """
    names, seed, repeats = _names(ways), _whole(seed, "seed", 0), _whole(repeats, "repeats", 1)
    scenes, tell = [with_clearance(scene, clearance) for clearance in clearances], tell or _silent
    _warm_up(names)
    out = []
    for k, changed in enumerate(scenes):
        tell(f"{changed.clearance:g} m, {k + 1} of {len(scenes)}")
        found = _compared(changed, names, seed, repeats, _silent)
        out.append(replace(found, entries=tuple(replace(entry, roadmaps={}) for entry in found.entries)))
    return tuple(out)


def summary(entry: Entry) -> Summary:
    """Sum up what one way found."""
    trials = entry.trials
    solved = [trial for trial in trials if trial.solved]
    ratios = [trial.ratio for trial in solved if trial.ratio is not None]
    clearances = [trial.clearance for trial in solved if trial.clearance is not None]
    return Summary(
        way=entry.way,
        solved=len(solved),
        robots=len(trials),
        mean_ratio=_mean(ratios),
        worst_ratio=max(ratios, default=None),
        length=sum(trial.length or 0.0 for trial in solved) if solved else None,
        mean_clearance=_mean(clearances),
        least_clearance=min(clearances, default=None),
        mean_turns=_mean([trial.turns for trial in solved]),
        mean_turning=_mean([trial.turning for trial in solved]),
        vertices=_mean([trial.vertices for trial in trials]),
        edges=_mean([trial.edges for trial in trials]),
        obstacles=_mean([trial.obstacles for trial in trials]),
        build_seconds=entry.build_seconds,
        query_seconds=float(np.median([trial.seconds for trial in trials])) if trials else None,
    )


def with_clearance(scene: Scene, clearance: float) -> Scene:
    """Return the scene with this clearance, in metres, for all of its robots.

    >>> scene = Scene((0, 0, 4, 3), robots=[Robot("R1", (1, 1), (3, 1), clearance=0.5)])
    >>> with_clearance(scene, 0.2).robots[0].clearance
    0.2
    """
    robots = tuple(replace(robot, clearance=clearance) for robot in scene.robots)
    return replace(scene, clearance=clearance, robots=robots)


def _compared(scene: Scene, names: Sequence[str], seed: int, repeats: int, tell: Tell) -> Comparison:
    check_form(scene)
    shortest, blocked = _shortest(scene)
    entries = []
    for name in names:
        tell(name)
        entries.append(_entry(scene, name, seed, repeats, shortest, blocked))
    return Comparison(scene, seed, shortest, blocked, tuple(entries))


def _shortest(scene: Scene) -> tuple[FloatArray, dict[str, str]]:
    """Return the shortest lengths, (n,) metres or nan, and the robots that are blocked, with the reason."""
    lengths = np.full(len(scene.robots), np.nan)
    blocked = {}
    for growth, team in _teams(scene).items():
        freespace = FreeSpace(scene, growth)
        for k in team:
            robot = scene.robots[k]
            try:
                freespace.require(robot)
                lengths[k] = shortest_path(freespace, robot.start, robot.goal).length
            except NoPath:
                continue
            except (StartBlocked, GoalBlocked) as error:
                blocked[robot.name] = _why_blocked(scene, robot, error)
    return lengths, blocked


def _why_blocked(scene: Scene, robot: Robot, error: SceneError) -> str:
    """Return which obstacle is too near and how much clearance would fit, or what the error says."""
    try:
        oca_path(scene, robot)
    except (StartBlocked, GoalBlocked) as closer:
        return _without_name(closer, robot)
    except NoPath:
        pass
    return _without_name(error, robot)


def _without_name(error: SceneError, robot: Robot) -> str:
    return error.message.removeprefix(f"robot {robot.name}: ")


def _entry(scene: Scene, name: str, seed: int, repeats: int, shortest: FloatArray, blocked: Mapping[str, str]) -> Entry:
    trials: dict[int, Trial] = {}
    roadmaps: dict[float, Roadmap] = {}
    build = 0.0
    for growth, team in _teams(scene).items():
        began = time.perf_counter()
        prepared = WAYS[name](scene, growth, seed)
        build += time.perf_counter() - began
        if prepared.roadmap is not None:
            roadmaps[growth] = prepared.roadmap
        for k in team:
            robot = scene.robots[k]
            found, seconds = _asked(prepared.ask, robot, repeats)
            if isinstance(found, str):
                found = blocked.get(robot.name, found)
            trials[k] = _judged(scene, robot, found, float(shortest[k]), seconds)
    return Entry(name, build, tuple(trials[k] for k in range(len(scene.robots))), roadmaps)


def _teams(scene: Scene) -> Mapping[float, list[int]]:
    """Group the robots by growth, in metres, ascending."""
    out: dict[float, list[int]] = {}
    for k in sorted(range(len(scene.robots)), key=lambda k: scene.growth(scene.robots[k])):
        out.setdefault(scene.growth(scene.robots[k]), []).append(k)
    return out


def _asked(ask: Callable[[Robot], Answer], robot: Robot, repeats: int) -> tuple[Answer | str, float]:
    """Return the answer, or why there is none, and how many seconds it took."""
    seconds = []
    found: Answer | str = ""
    for _ in range(1 + repeats):
        began = time.perf_counter()
        try:
            found = ask(robot)
        except NoPath as error:
            found = error.reason
        except (StartBlocked, GoalBlocked) as error:
            found = _without_name(error, robot)
        seconds.append(time.perf_counter() - began)
    return found, float(np.median(seconds[1:]))


def _judged(scene: Scene, robot: Robot, found: Answer | str, shortest: float, seconds: float) -> Trial:
    """Prove a route and measure it."""
    if isinstance(found, str):
        return Trial(robot.name, False, found, None, None, None, None, None, None, None, None, None, seconds)
    points = found.route.points
    length = found.route.length
    vertices, edges = found.count()
    certificate = certify(_alone(scene, robot, points))
    turns, turning = _turns(points, scene.tol)
    return Trial(
        robot=robot.name,
        solved=certificate.ok,
        reason=_reason(certificate.problems),
        points=points,
        length=length,
        ratio=_ratio(length, shortest) if certificate.ok else None,
        clearance=certificate.clearances[0].value,
        turns=turns,
        turning=turning,
        vertices=vertices,
        edges=edges,
        obstacles=found.obstacles,
        seconds=seconds,
    )


def _alone(scene: Scene, robot: Robot, points: FloatArray) -> Plan:
    """Return the plan in which this robot is alone and drives the route at top speed, from the first instant on."""
    world = replace(scene, robots=(replace(robot, start_time=0.0),))
    vars(world)["tol"] = scene.tol
    times = np.append(0.0, np.hypot(*np.diff(points, axis=0).T).cumsum()) / robot.speed
    for k in range(1, len(times)):  # steps may be too short to be told apart in time
        times[k] = max(times[k], math.nextafter(times[k - 1], math.inf))
    return Plan(world, (Trajectory(robot.name, np.column_stack([times, points])),))


def _turns(points: FloatArray, tol: float) -> tuple[int, float]:
    """Return how often a route bends, and by how many radians in all; within ``tol`` of straight is no bend."""
    steps = np.diff(points, axis=0)
    moved = (steps != 0).any(axis=1)
    steps, places = steps[moved], np.concatenate([points[:1], points[1:][moved]])
    if len(steps) < 2:
        return 0, 0.0
    a, b = steps[:-1], steps[1:]
    angles = np.arctan2(a[:, 0] * b[:, 1] - a[:, 1] * b[:, 0], (a * b).sum(axis=1))
    chords = shapely.linestrings(np.stack([places[:-2], places[2:]], axis=1))
    bends = shapely.distance(chords, shapely.points(places[1:-1])) > tol
    return int(bends.sum()), float(np.abs(angles).sum())


def _reason(problems: Sequence[Problem]) -> str:
    """Say what is wrong; who passes through an obstacle is not told that it is near."""
    crossed = {problem.obstacle for problem in problems if problem.kind == "crossing"}
    return "; ".join(_told(p) for p in problems if p.kind != "clearance" or p.obstacle not in crossed)


def _told(problem: Problem) -> str:
    at = "" if problem.place is None else f" at ({problem.place[0]:.4g}, {problem.place[1]:.4g})"
    match problem.kind:
        case "clearance":
            return f"{problem.amount:.4g} m too near to {problem.obstacle}{at}"
        case "crossing" if problem.amount > 0:
            return f"passes {problem.amount:.4g} m deep through {problem.obstacle}{at}"
        case "crossing":
            return f"squeezes through where {problem.obstacle} leave no room{at}"
        case "goal":
            return f"ends {problem.amount:.4g} m from its goal{at}"
        case _:
            return str(problem)


def _ratio(length: float, shortest: float) -> float | None:
    if math.isnan(shortest):
        return None
    if shortest == 0:
        return 1.0 if length == 0 else math.inf
    return length / shortest


def _mean(values: Sequence[float | None]) -> float | None:
    known = [value for value in values if value is not None]
    return float(np.mean(known)) if known else None


def _names(ways: Sequence[str] | None) -> tuple[str, ...]:
    names = tuple(WAYS) if ways is None else (ways,) if isinstance(ways, str) else tuple(dict.fromkeys(ways))
    for name in names:
        if name not in WAYS:
            raise ValueError(f"ways: {name!r} is unknown, take from {', '.join(WAYS)}")
    if not names:
        raise ValueError(f"ways must not be empty, take from {', '.join(WAYS)}")
    return names


def _whole(value: int, what: str, least: int) -> int:
    try:
        number = index(value)
    except TypeError:
        number = least - 1
    if number < least:
        raise ValueError(f"{what} must be a whole number, at least {least}, got {value!r}")
    return number


def _silent(_: str) -> None:
    pass


def _warm_up(names: Sequence[str]) -> None:
    """Have all kernels compiled and loaded."""
    shapes: list[Obstacle] = [Rectangle(4, 2, 2, 3), Circle((5, 7), 0.8), Line([(7.5, 4), (8, 6)], 0.2)]
    tiny = Scene((0, 0, 10, 10), shapes, [Robot("R1", (1, 4), (9, 5), radius=0.2)])
    _compared(tiny, names, 0, 1, _silent)
