"""Random teams that can keep contact: a team is moved without losing it, and that motion is handed out as witness."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from contextlib import suppress
from dataclasses import dataclass, replace

import numpy as np
import shapely

from taut.contact.demand import Contact
from taut.errors import GoalBlocked, NoPath, SceneError, StartBlocked
from taut.freespace import FreeSpace
from taut.generate.asked import finite, span, whole, within
from taut.generate.drifting import Drift, Slots, drifted, gathered
from taut.generate.hall import Hall
from taut.generate.obstacles import draw_forms, place_obstacles
from taut.geometry.growth import grown
from taut.motion import Plan, Trajectory
from taut.route import direct_paths
from taut.scene import FloatArray, Obstacle, Point, Rectangle, Robot, Scene
from taut.validation import validate

_MOST = 1000  # robots or obstacles
_SIZES = (0.01, 1e5)  # metres
_NARROWEST = 10  # side of a hall in units of what the widest robot needs
_WIDE = 48.0  # metres: wider halls only where the team needs them
_NEAREST = 1.5  # reach in units of what the two widest robots need
_TRIES = 12  # ways and starts that are tried
_FAR = 0.35  # mean distance from start to goal as a share of the way: a team that leaves most behind is stuck
_FORMS = ("polygon", "rectangle", "circle", "line", "nonconvex")


def random_team_in_contact(
    robots: int = 10,
    reach: float = 3.0,
    seed: int = 0,
    *,
    ground: str = "hall",
    formation: str = "swarm",
    sight: bool = False,
    obstacles: int = 12,
    size: float | None = None,
    radius: float | tuple[float, float] = 0.25,
    speed: float | tuple[float, float] = 1.0,
    clearance: float = 0.0,
    gap: float = 0.05,
    name: str | None = None,
) -> tuple[Scene, Plan]:
    """Make a scene whose team can keep contact on the way, and a plan that shows it.

    The team is thrown about a place and drifts along a way to another one in synchronous steps. Whoever steps keeps to
    the free space and apart from all others, and leaves the team connected by links that hold throughout the step;
    else it tries another step, or rests. Slots and headings are random, so the robots change their order on the way.
    Goals are where they come to rest. The plan is meant to prove that there is one, not to be short.

    Parameters
    ----------
    robots : how many, 1 to 1,000.
    reach : greatest distance of two centres in contact, metres; at least 1.5 times what the two widest robots need.
    seed : ≥ 0; the same arguments give the same scene and plan.
    ground : "hall" (obstacles in a square), "rooms" (two or three, with doors one or two robots wide) or "corner" (a
        hall like an L).
    formation : "swarm" (about as wide as long) or "chain" (it stretches along the way, neighbours a third of the reach
        apart).
    sight : whether robots in contact also see each other.
    obstacles : how many are thrown; in rooms and round a corner, those that would block the way are taken out again.
    size : side of the hall, metres, at least ten times what the widest robot needs; None takes 13 times the reach, at
        most 48 m, or more where the team needs it.
    radius : of the robots, metres, or range of it, above 0.
    speed : of the robots, metres a second, or range of it.
    clearance, gap : fields of the scene.
    name : of the scene; None names it after ground, formation, robots and seed.

    Returns
    -------
    Scene with robots R1, R2, … that stay at their goals.
    Plan of that scene which claims the contact.

    Raises
    ------
    SceneError
        A parameter out of its range, or a team that does not fit or gets stuck: the text says what and the mend.

    >>> scene, witness = random_team_in_contact(4, 2.0, seed=1)
    >>> len(scene.robots), witness.claims["contact"]["range"]
    (4, 2.0)
    """
    n, m, seed = whole(robots, "robots", _MOST), whole(obstacles, "obstacles", _MOST), whole(seed, "seed")
    if n == 0:
        raise SceneError("robots must be at least 1: an empty team keeps no contact")
    if ground not in _GROUNDS:
        raise SceneError(f"ground: {ground!r} is unknown, take {', '.join(_GROUNDS)}")
    if formation not in _FORMATIONS:
        raise SceneError(f"formation: {formation!r} is unknown, take {', '.join(_FORMATIONS)}")
    demand = Contact(reach, sight)
    radii_range, speeds_range = span(radius, "radius", positive=True), span(speed, "speed", positive=True)
    for value, what in ((clearance, "clearance"), (gap, "gap")):
        span(value, what)
    scene = Scene((0, 0, 1, 1), name=name or f"{ground}-{formation}-{n}-{seed}", clearance=clearance, gap=gap)
    within(demand.reach, _SIZES, "reach", " m")
    growth, widest = radii_range[1] + scene.clearance, 2 * radii_range[1] + scene.gap
    if demand.reach < _NEAREST * widest:
        raise SceneError(
            f"reach of {demand.reach:g} m is too short for robots that need {widest:g} m from centre to centre: "
            f"take at least {_NEAREST * widest:g} m"
        )
    rng = np.random.default_rng(seed)
    spacing = max(1.6 * widest, demand.reach / 3)
    hall = _hall(size, demand.reach, 2 * growth + scene.gap, spacing * math.sqrt(n))
    team = [
        Robot(f"R{k + 1}", (0, 0), (0, 0), radius=_drawn(rng, radii_range), speed=_drawn(rng, speeds_range))
        for k in range(n)
    ]
    step = _step(min(demand.reach / 5, 2 * widest), speeds_range)
    for _ in range(_TRIES):
        place = _GROUNDS[ground](rng, hall, m, 2.5 * growth)
        empty = replace(scene, workspace=place.workspace, obstacles=place.obstacles)
        drift = _drift(empty, demand, team, growth, step, hall)
        frames = _moved(rng, drift, place, _FORMATIONS[formation], spacing)
        if frames is not None:
            return _told(empty, team, frames, step, demand, seed, hall.digits)
    raise SceneError(
        f"{n} robots within {demand.reach:g} m of each other got stuck in {hall.words} in {_TRIES} tries: "
        "take a larger size or reach, fewer or smaller robots, or fewer obstacles"
    )


# --- Grounds ----------------------------------------------------------------------------------------------------------


@dataclass(frozen=True)
class _Place:
    """A workspace with its obstacles, and the boxes (xmin, ymin, xmax, ymax) that a way leads through."""

    workspace: tuple[Point, ...]
    obstacles: tuple[Obstacle, ...]
    stations: tuple[tuple[float, float, float, float], ...]


def _open_hall(rng: np.random.Generator, hall: Hall, obstacles: int, passage: float) -> _Place:
    side = hall.width
    stations = ((0.05, 0.1, 0.15, 0.9), (0.4, 0.15, 0.6, 0.85), (0.85, 0.1, 0.95, 0.9))
    box = ((0.0, 0.0), (side, 0.0), (side, side), (0.0, side))
    return _furnished(rng, hall, obstacles, passage, box, [], stations)


def _rooms(rng: np.random.Generator, hall: Hall, obstacles: int, passage: float) -> _Place:
    """Two or three rooms one after another; the walls leave doors wide enough for one or two robots abreast."""
    side, walls = hall.width, int(rng.integers(1, 3))
    thick = round(0.01 * side, hall.digits)
    solid = []
    for k in range(walls):
        x = round(side * (k + 1) / (walls + 1) - thick / 2, hall.digits)
        door = round(float(rng.uniform(1.0, 2.0)) * passage, hall.digits)
        low = round(float(rng.uniform(0.2, 0.8)) * side - door / 2, hall.digits)
        solid.append(Rectangle(x, 0.0, thick, low, name=f"W{k + 1} lower"))
        solid.append(
            Rectangle(x, low + door, thick, round(side - low - door, hall.digits), name=f"W{k + 1} upper"),
        )
    box = ((0.0, 0.0), (side, 0.0), (side, side), (0.0, side))
    return _furnished(rng, hall, obstacles, passage, box, solid, ((0.05, 0.1, 0.15, 0.9), (0.85, 0.1, 0.95, 0.9)))


def _corner(rng: np.random.Generator, hall: Hall, obstacles: int, passage: float) -> _Place:
    """Two arms at a right angle."""
    side = hall.width
    arm = round(float(rng.uniform(0.3, 0.45)) * side, hall.digits)
    ell = ((0.0, 0.0), (side, 0.0), (side, arm), (arm, arm), (arm, side), (0.0, side))
    broad = arm / side - 0.05
    stations = ((0.05, 0.8, broad, 0.92), (0.8, 0.05, 0.92, broad))
    return _furnished(rng, hall, obstacles, passage, ell, [], stations)


_GROUNDS: dict[str, Callable[[np.random.Generator, Hall, int, float], _Place]] = {
    "hall": _open_hall,
    "rooms": _rooms,
    "corner": _corner,
}


def _furnished(
    rng: np.random.Generator,
    hall: Hall,
    obstacles: int,
    passage: float,
    workspace: tuple[Point, ...],
    walls: Sequence[Rectangle],
    stations: Sequence[tuple[float, float, float, float]],
) -> _Place:
    """Throw obstacles; those nearer than a passage to a wall between rooms or to the outside are taken out."""
    side = hall.width
    forms = draw_forms(rng, obstacles, _FORMS, (side / 25, side / 8))
    thrown = place_obstacles(rng, hall, forms, passage)
    inside = shapely.Polygon(workspace).buffer(-0.99 * passage, join_style="mitre")
    beside = shapely.union_all([grown(wall, 0.0) for wall in walls]).buffer(passage)
    left = [o for o in thrown if inside.covers(body := grown(o, 0.0)) and not beside.intersects(body)]
    # the way may be walked either way round
    turned = stations if rng.random() < 0.5 else stations[::-1]
    boxes = tuple((side * x0, side * y0, side * x1, side * y1) for x0, y0, x1, y1 in turned)
    return _Place(workspace, (*left, *walls), boxes)


# --- Motions ----------------------------------------------------------------------------------------------------------


def _swarm(rng: np.random.Generator, count: int, spacing: float, length: float) -> tuple[FloatArray, FloatArray]:
    """Lags and offsets of a round swarm."""
    radius = 0.5 * spacing * math.sqrt(count)
    angle, far = rng.uniform(0, 2 * math.pi, count), radius * np.sqrt(rng.random(count))
    return rng.uniform(0.0, radius, count), np.stack([far * np.cos(angle), far * np.sin(angle)], axis=1)


def _chain(rng: np.random.Generator, count: int, spacing: float, length: float) -> tuple[FloatArray, FloatArray]:
    """Lags and offsets of a chain, as long as the way allows."""
    lags = min(spacing, 0.5 * length / count) * rng.permutation(count).astype(np.float64)
    return lags, rng.normal(0.0, spacing / 10, (count, 2))


_FORMATIONS: dict[str, Callable[[np.random.Generator, int, float, float], tuple[FloatArray, FloatArray]]] = {
    "swarm": _swarm,
    "chain": _chain,
}


def _drift(empty: Scene, demand: Contact, team: Sequence[Robot], growth: float, step: float, hall: Hall) -> Drift:
    free = FreeSpace(empty, 1.02 * growth + hall.margin)
    shapely.prepare(free.region)
    sight = FreeSpace(empty, hall.margin).region if demand.sight else None
    if sight is not None:
        shapely.prepare(sight)
    radii = np.array([robot.radius for robot in team])
    strides = step * np.array([robot.speed for robot in team])
    return Drift(free, sight, radii + radii[:, None] + empty.gap, strides, demand.reach, hall.digits)


def _moved(
    rng: np.random.Generator,
    drift: Drift,
    place: _Place,
    formation: Callable[[np.random.Generator, int, float, float], tuple[FloatArray, FloatArray]],
    spacing: float,
) -> FloatArray | None:
    """Draw a way through the stations and move the team along it; None if there is no room or it gets stuck."""
    way = _way(rng, drift, place, spacing)
    if way is None:
        return None
    length = float(np.hypot(*np.diff(way, axis=0).T).sum())
    slots = Slots(way, *formation(rng, len(drift.strides), spacing, length))
    starts = gathered(rng, drift, slots.way[0], spacing)
    frames = None if starts is None else drifted(rng, drift, slots, starts)
    far = frames is not None and float(np.hypot(*(frames[-1] - frames[0]).T).mean()) > _FAR * length
    return frames if far else None


def _way(rng: np.random.Generator, drift: Drift, place: _Place, spacing: float) -> FloatArray | None:
    """Draw a shortest way through the stations, (k, 2), off the obstacles where there is room; None without one."""
    for beside in (1.5 * spacing, 0.5 * spacing, 0.0):
        free = FreeSpace(drift.free.scene, drift.free.growth + beside)
        stations = [_free_place(rng, free, box, drift.digits) for box in place.stations]
        with suppress(NoPath, StartBlocked, GoalBlocked):
            return np.concatenate([route.points for route in direct_paths(free, stations[:-1], stations[1:])])
    return None


def _free_place(
    rng: np.random.Generator, free: FreeSpace, box: tuple[float, float, float, float], digits: int
) -> FloatArray:
    """Draw a place in a box, a free one if one is found."""
    thrown = np.round(rng.uniform(box[:2], box[2:], (200, 2)), digits)
    inside = shapely.contains_xy(free.region, thrown[:, 0], thrown[:, 1])
    return np.asarray(thrown[np.argmax(inside)])


def _told(
    empty: Scene, team: Sequence[Robot], frames: FloatArray, step: float, demand: Contact, seed: int, digits: int
) -> tuple[Scene, Plan]:
    """Return the scene with starts and goals, and the motion as a plan."""
    robots = [
        replace(robot, start=start, goal=goal)
        for robot, start, goal in zip(team, frames[0].tolist(), frames[-1].tolist(), strict=True)
    ]
    scene = replace(empty, robots=tuple(robots))
    validate(scene)
    paths = tuple(_trajectory(robot.name, frames[:, k], step, digits) for k, robot in enumerate(robots))
    return scene, Plan(scene, paths, {"method": "witness", "seed": seed}, {"contact": demand.claim})


def _trajectory(name: str, places: FloatArray, step: float, digits: int) -> Trajectory:
    """Return the motion of one robot, steps alike joined into one leg and the rest at the goal left out."""
    moves = np.diff(np.round(places * 10.0**digits).astype(np.int64), axis=0)
    bends = 1 + np.flatnonzero((moves[1:] != moves[:-1]).any(axis=1))
    kept = np.concatenate([[0], bends, [len(moves)] if len(moves) and moves[-1].any() else []]).astype(np.intp)
    return Trajectory(name, np.column_stack([step * kept, places[kept]]))


def _hall(size: float | None, reach: float, widest: float, team: float) -> Hall:
    """Return a square hall: as asked for, or fit for this reach, the widest robot and a team of this width, metres."""
    if size is None:
        side = float(math.ceil(max(min(13 * reach, _WIDE), 4 * team, 2 * _NARROWEST * widest)))
    else:
        side = finite(size, "size")
        within(side, (_NARROWEST * widest, _SIZES[1]), "size", " m")
    return Hall(side, side)


def _step(stride: float, speeds: tuple[float, float]) -> float:
    """Return seconds of a step: a power of two, so that all times are exact."""
    return 2.0 ** round(math.log2(2 * stride / sum(speeds)))


def _drawn(rng: np.random.Generator, ends: tuple[float, float]) -> float:
    low, high = ends
    digits = max(3, 2 - math.floor(math.log10(high)))
    return low if low == high else min(max(round(float(rng.uniform(low, high)), digits), low), high)
