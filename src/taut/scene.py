"""What the world is: workspace, obstacles, robots. Plain frozen values in metres, seconds and radians."""

from __future__ import annotations

import math
from collections.abc import Iterable, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from typing import Any, Literal, TypeAlias

import numpy as np
from numpy.typing import NDArray

from taut.errors import SceneError

Point: TypeAlias = tuple[float, float]
AtGoal: TypeAlias = Literal["stay", "leave"]
FloatArray: TypeAlias = NDArray[np.float64]


@dataclass(frozen=True)
class Polygon:
    """A simple polygon, convex or not, corners in either direction, not closed by repetition.

    >>> Polygon([(0, 0), (2, 0), (1, 1)], name="O1").points
    ((0.0, 0.0), (2.0, 0.0), (1.0, 1.0))
    """

    points: tuple[Point, ...]
    name: str = ""

    def __init__(self, points: Iterable[Sequence[float]], name: str = "") -> None:
        object.__setattr__(self, "points", _points(points, f"obstacle {name or 'polygon'}"))
        object.__setattr__(self, "name", name)
        if len(self.points) < 3:
            raise SceneError(
                f"obstacle {name or 'polygon'}: a polygon needs at least 3 corners, got {len(self.points)}"
            )

    @property
    def core(self) -> FloatArray:
        """Corners of the shape without its own radius, (n, 2): n ≥ 3 a ring (see `closed`), else a chain or point."""
        return np.array(self.points, dtype=np.float64)

    @property
    def closed(self) -> bool:
        """Whether `core` is a ring whose inside belongs to the obstacle."""
        return True

    @property
    def own_radius(self) -> float:
        """Metres by which the obstacle reaches beyond `core`, in every direction."""
        return 0.0


@dataclass(frozen=True)
class Rectangle:
    """A rectangle with lower left corner (x, y), turned by `angle` radians about its centre."""

    x: float
    y: float
    width: float
    height: float
    angle: float = 0.0
    name: str = ""

    def __post_init__(self) -> None:
        where = f"obstacle {self.name or 'rectangle'}"
        for field in ("x", "y", "width", "height", "angle"):
            object.__setattr__(self, field, _number(getattr(self, field), f"{where}: {field}"))
        if self.width <= 0 or self.height <= 0:
            raise SceneError(f"{where}: width and height must be positive, got {self.width:g} × {self.height:g}")

    @property
    def core(self) -> FloatArray:
        """The four corners, counter-clockwise, (4, 2)."""
        x0, y0, x1, y1 = self.x, self.y, self.x + self.width, self.y + self.height
        corners = np.array([[x0, y0], [x1, y0], [x1, y1], [x0, y1]])
        if self.angle == 0.0:
            return corners
        centre = np.array([self.x + self.width / 2, self.y + self.height / 2])
        c, s = math.cos(self.angle), math.sin(self.angle)
        return np.asarray(centre + (corners - centre) @ np.array([[c, s], [-s, c]]), dtype=np.float64)

    @property
    def closed(self) -> bool:
        """A rectangle is a ring."""
        return True

    @property
    def own_radius(self) -> float:
        """A rectangle reaches no farther than its corners."""
        return 0.0


@dataclass(frozen=True)
class Circle:
    """A disc."""

    center: Point
    radius: float
    name: str = ""

    def __post_init__(self) -> None:
        where = f"obstacle {self.name or 'circle'}"
        object.__setattr__(self, "center", _point(self.center, f"{where}: circle"))
        object.__setattr__(self, "radius", _number(self.radius, f"{where}: radius"))
        if self.radius <= 0:
            raise SceneError(f"{where}: radius must be positive, got {self.radius:g}")

    @property
    def core(self) -> FloatArray:
        """The centre, (1, 2)."""
        return np.array([self.center], dtype=np.float64)

    @property
    def closed(self) -> bool:
        """The core is a point."""
        return False

    @property
    def own_radius(self) -> float:
        """The radius of the disc."""
        return self.radius


@dataclass(frozen=True)
class Line:
    """A wall: every point within width / 2 of a polyline (rounded ends and joints)."""

    points: tuple[Point, ...]
    width: float
    name: str = ""

    def __init__(self, points: Iterable[Sequence[float]], width: float, name: str = "") -> None:
        where = f"obstacle {name or 'line'}"
        object.__setattr__(self, "points", _points(points, where))
        object.__setattr__(self, "width", _number(width, f"{where}: width"))
        object.__setattr__(self, "name", name)
        if len(self.points) < 2:
            raise SceneError(f"{where}: a line needs at least 2 points, got {len(self.points)}")
        if self.width <= 0:
            raise SceneError(f"{where}: width must be positive, got {self.width:g}")

    @property
    def core(self) -> FloatArray:
        """The points of the polyline, (n, 2)."""
        return np.array(self.points, dtype=np.float64)

    @property
    def closed(self) -> bool:
        """The core is a chain."""
        return False

    @property
    def own_radius(self) -> float:
        """Half the width."""
        return self.width / 2


Obstacle: TypeAlias = Polygon | Rectangle | Circle | Line


@dataclass(frozen=True)
class Robot:
    """A closed disc that moves in any direction at its top speed, or rests.

    Parameters
    ----------
    name : unique in the scene.
    start, goal : centre of the disc in metres.
    radius : metres, ≥ 0.
    speed : metres a second, > 0.
    clearance : metres kept free from obstacles and wall beyond the radius; None takes the scene's.
    start_time : seconds; the robot stands at its start from 0 and may leave from then.
    at_goal : "stay" or "leave" (gone from the instant of arrival); None takes the scene's.
    """

    name: str
    start: Point
    goal: Point
    radius: float = 0.0
    speed: float = 1.0
    clearance: float | None = None
    start_time: float = 0.0
    at_goal: AtGoal | None = None

    def __post_init__(self) -> None:
        if not isinstance(self.name, str) or not self.name:
            raise SceneError(f"a robot needs a name in letters, got {self.name!r}")
        where = f"robot {self.name}"
        object.__setattr__(self, "start", _point(self.start, f"{where}: start"))
        object.__setattr__(self, "goal", _point(self.goal, f"{where}: goal"))
        for field in ("radius", "speed", "start_time"):
            object.__setattr__(self, field, _number(getattr(self, field), f"{where}: {field}"))
        if self.speed <= 0:
            raise SceneError(f"{where}: speed must be positive, got {self.speed:g}")
        _not_negative(self.radius, f"{where}: radius")
        _not_negative(self.start_time, f"{where}: start_time")
        if self.clearance is not None:
            object.__setattr__(self, "clearance", _number(self.clearance, f"{where}: clearance"))
            _not_negative(self.clearance, f"{where}: clearance")
        if self.at_goal is not None:
            _at_goal(self.at_goal, f"{where}: at_goal")


@dataclass(frozen=True)
class Scene:
    """A map and a team. Lengths in metres, times in seconds.

    Parameters
    ----------
    workspace : corners of a simple polygon, or the four numbers (xmin, ymin, xmax, ymax).
    obstacles : they may touch, overlap, nest and leave the workspace.
    robots : may be empty.
    clearance : kept free between every robot and every obstacle or wall, beyond the radius.
    gap : kept free between robots, beyond their radii.
    headway : seconds by which the separation must also hold between shifted times.
    at_goal : whether robots stay at their goals or leave.

    Raises
    ------
    SceneError
        A number that is not finite or has the wrong sign, a name used twice.

    >>> Scene((0, 0, 4, 3)).workspace
    ((0.0, 0.0), (4.0, 0.0), (4.0, 3.0), (0.0, 3.0))
    """

    workspace: tuple[Point, ...]
    obstacles: tuple[Obstacle, ...] = ()
    robots: tuple[Robot, ...] = ()
    name: str = ""
    clearance: float = 0.0
    gap: float = 0.0
    headway: float = 0.0
    at_goal: AtGoal = "stay"

    def __init__(
        self,
        workspace: Iterable[Sequence[float]] | Sequence[float],
        obstacles: Iterable[Obstacle] = (),
        robots: Iterable[Robot] = (),
        name: str = "",
        clearance: float = 0.0,
        gap: float = 0.0,
        headway: float = 0.0,
        at_goal: AtGoal = "stay",
    ) -> None:
        def put(field: str, value: object) -> None:
            object.__setattr__(self, field, value)

        put("workspace", _workspace(workspace))
        put("obstacles", _named(obstacles))
        put("robots", tuple(robots))
        put("name", name)
        for field, value in (("clearance", clearance), ("gap", gap), ("headway", headway)):
            put(field, _number(value, field))
            _not_negative(getattr(self, field), field)
        put("at_goal", at_goal)
        _at_goal(at_goal, "at_goal")
        _unique([o.name for o in self.obstacles], "obstacles")
        _unique([r.name for r in self.robots], "robots")

    @cached_property
    def tol(self) -> float:
        """The one tolerance, metres: 2⁻⁴⁰ times the largest |coordinate| of the scene."""
        largest = max((abs(c) for p in self.workspace for c in p), default=0.0)
        for obstacle in self.obstacles:
            largest = max(largest, float(np.abs(obstacle.core).max()) + obstacle.own_radius)
        for robot in self.robots:
            largest = max(largest, *(abs(c) for c in (*robot.start, *robot.goal)))
        return 2.0**-40 * largest

    def with_obstacles(self, obstacles: Iterable[Obstacle]) -> Scene:
        """Return the same world with some of its obstacles only; its tolerance stays.

        >>> Scene((0, 0, 4, 3), [Circle((1, 1), 0.5), Circle((3, 1), 0.5)]).with_obstacles([]).obstacles
        ()
        """
        out = replace(self, obstacles=tuple(obstacles))
        vars(out)["tol"] = self.tol
        return out

    def robot(self, robot: Robot | str) -> Robot:
        """Return a robot of the scene by its name, or itself.

        Raises
        ------
        SceneError
            There is none of this name, or it is not this one.
        """
        name = robot.name if isinstance(robot, Robot) else robot
        own = next((r for r in self.robots if r.name == name), None)
        if own is None:
            names = ", ".join(r.name for r in self.robots[:5]) + ", …" * (len(self.robots) > 5)
            raise SceneError(f"the scene has no robot {name}; it has {names or 'none'}")
        if isinstance(robot, Robot) and robot != own:
            raise SceneError(f"robot {name} is not the one of that name in the scene")
        return own

    def growth(self, robot: Robot) -> float:
        """Metres by which obstacles grow for this robot: its radius plus its clearance."""
        return robot.radius + (self.clearance if robot.clearance is None else robot.clearance)

    def stays(self, robot: Robot) -> bool:
        """Whether this robot stays at its goal for good."""
        return (self.at_goal if robot.at_goal is None else robot.at_goal) == "stay"

    def separation(self, a: Robot, b: Robot) -> float:
        """Least allowed distance between the centres of two robots, metres."""
        return a.radius + b.radius + self.gap


def _number(value: Any, where: str) -> float:
    try:
        number = float(value)
    except (TypeError, ValueError, OverflowError):
        raise SceneError(f"{where} must be a number, got {value!r}") from None
    if not math.isfinite(number):
        raise SceneError(f"{where} must be a finite number, got {value!r}")
    return number


def _not_negative(value: float, where: str) -> None:
    if value < 0:
        raise SceneError(f"{where} must not be negative, got {value:g}")


def _point(value: Sequence[float], where: str) -> Point:
    if np.ndim(value) != 1 or len(value) != 2:
        raise SceneError(f"{where} must be a point [x, y], got {value!r}")
    return _number(value[0], where), _number(value[1], where)


def _points(values: Iterable[Sequence[float]], where: str) -> tuple[Point, ...]:
    return tuple(_point(value, f"{where}: point {k + 1}") for k, value in enumerate(values))


def _workspace(value: Iterable[Sequence[float]] | Sequence[float]) -> tuple[Point, ...]:
    items: list[Any] = list(value)
    if len(items) == 4 and all(np.ndim(item) == 0 for item in items):
        xmin, ymin, xmax, ymax = (_number(item, "workspace bounds") for item in items)
        if xmin >= xmax or ymin >= ymax:
            raise SceneError(
                f"workspace bounds must be xmin, ymin, xmax, ymax, xmin < xmax and ymin < ymax; got {items}"
            )
        return (xmin, ymin), (xmax, ymin), (xmax, ymax), (xmin, ymax)
    points = _points(items, "workspace")
    if len(points) < 3:
        raise SceneError(f"workspace: a polygon needs at least 3 corners, got {len(points)}")
    return points


def _named(obstacles: Iterable[Obstacle]) -> tuple[Obstacle, ...]:
    """Give nameless obstacles the first free name O1, O2, … of their position."""
    given = tuple(obstacles)
    taken = {o.name for o in given}
    out = []
    for k, obstacle in enumerate(given):
        if not obstacle.name:
            name = f"O{k + 1}"
            while name in taken:
                name += "'"
            taken.add(name)
            obstacle = _renamed(obstacle, name)
        out.append(obstacle)
    return tuple(out)


def _renamed(obstacle: Obstacle, name: str) -> Obstacle:
    match obstacle:
        case Polygon():
            return Polygon(obstacle.points, name)
        case Rectangle():
            return Rectangle(obstacle.x, obstacle.y, obstacle.width, obstacle.height, obstacle.angle, name)
        case Circle():
            return Circle(obstacle.center, obstacle.radius, name)
        case Line():
            return Line(obstacle.points, obstacle.width, name)


def _at_goal(value: object, where: str) -> None:
    if value not in ("stay", "leave"):
        raise SceneError(f'{where} must be "stay" or "leave", got {value!r}')


def _unique(names: Sequence[str], what: str) -> None:
    seen: set[str] = set()
    for name in names:
        if name in seen:
            raise SceneError(f"two {what} are named {name}; every name must be unique")
        seen.add(name)
