"""Plans for ir-sim, a robot simulator in Python: its world files, and vehicles of its own driven along a motion.

ir-sim (Han, https://github.com/hanruihua/ir-sim, MIT) shares no code with taut: it moves its vehicles by explicit Euler
steps and finds collisions with shapely, discs being polygons of 64 corners inscribed in them. Files are for ir-sim 2.12
and later; to write them it need not be installed.
"""

from __future__ import annotations

import importlib
import math
import os
import tempfile
from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise
from pathlib import Path
from typing import Any, Literal, TypeAlias

import numpy as np
import yaml
from numpy.typing import ArrayLike

from taut.errors import SceneError, TautError
from taut.motion import Plan
from taut.scene import Circle, FloatArray, Line, Obstacle, Rectangle, Robot
from taut.writing import write_text

Kinematics: TypeAlias = Literal["omni", "diff", "acker"]
KINEMATICS: tuple[Kinematics, ...] = ("omni", "diff", "acker")

STEP = 0.02  # seconds
TURNING = 4.0  # radians a second that a "diff" may turn, by default
STEERING = 0.7  # radians that an "acker" may steer to either side
AXLES = 1.2  # radii from axle to axle, by default
SPARE = 1.5  # top speed over that of the scene: a quarter to catch up, and a speed error of 20 %
WALL = "the wall"
GAIN = 4.0  # radians of heading for a metre beside the motion


@dataclass(frozen=True, eq=False)
class Replay:
    """What ir-sim's vehicles did on their way along a motion of n robots, F instants.

    Parameters
    ----------
    times : (F,) seconds.
    poses : (F, n, 3) x, y (metres), heading (radians).
    errors : (F, n) metres from where they were to be.
    collisions : (seconds, robot, other) for every contact that began, in order; other is a robot, an obstacle (parts
        of a wall are NAME, NAME-2 …) or "the wall" of the workspace.
    """

    times: FloatArray
    poses: FloatArray
    errors: FloatArray
    collisions: tuple[tuple[float, str, str], ...]


def irsim_text(
    plan: Plan,
    kinematics: Kinematics = "diff",
    *,
    step: float = STEP,
    turning: float = TURNING,
    wheelbase: float | None = None,
) -> str:
    """Return scene and plan as a world file of ir-sim (YAML).

    Robots are discs with the turns of their motions as goals one after another, and behave as ir-sim's `dash`: straight
    to the next goal at top speed. That keeps the way but not the timing of the plan, which ir-sim does not know: stamps
    [t, x, y] stand under `custom`, which it hands to your own controllers; see also `replay_in_irsim`. The workspace is
    a wall without width, a wall of taut one rectangle a piece and one disc a joint.

    Parameters
    ----------
    plan : what to write. Where motions touch an obstacle or the wall, ir-sim may see a collision: leave a clearance.
    kinematics : "omni" moves in any direction, "diff" turns on the spot, "acker" steers its front wheels.
    step : seconds of one step.
    turning : radians a second that a "diff" turns at most.
    wheelbase : metres between the axles of an "acker", whose disc is round the rear one; by default 1.2 radii.

    Raises
    ------
    SceneError
        A robot without a radius, which ir-sim cannot draw.
    ValueError
        Unknown kinematics, numbers that are not positive.
    """
    _check(kinematics, step=step, turning=turning, wheelbase=1.0 if wheelbase is None else wheelbase)
    scene = plan.scene
    low, high = np.min(scene.workspace, axis=0), np.max(scene.workspace, axis=0)
    width, height = (high - low).tolist()
    taken = {robot.name for robot in scene.robots}
    walls = [
        {
            "name": _free_name(WALL, taken),
            "shape": _ring("linestring", [*scene.workspace, scene.workspace[0]]),
            **_at(0, 0),
        }
    ]
    for obstacle in scene.obstacles:
        walls += [{"name": _free_name(obstacle.name, taken), **part} for part in _parts(obstacle)]
    routes = [trajectory.points for trajectory in plan.trajectories]
    data = {
        "world": {"width": width, "height": height, "offset": low.tolist(), "step_time": float(step)},
        "robot": [
            _robot(robot, route, kinematics, step, turning, wheelbase)
            for robot, route in zip(scene.robots, routes, strict=True)
        ],
        "obstacle": walls,
        "custom": {"taut": {t.name: t.stamps.tolist() for t in plan.trajectories}},
    }
    return str(yaml.safe_dump(data, default_flow_style=None, sort_keys=False, allow_unicode=True, width=120))


def save_irsim(
    plan: Plan,
    path: str | os.PathLike[str],
    kinematics: Kinematics = "diff",
    *,
    step: float = STEP,
    turning: float = TURNING,
    wheelbase: float | None = None,
) -> None:
    """Write scene and plan as a world file of ir-sim, see `irsim_text`.

    Raises
    ------
    OutputError
        The file cannot be written.
    """
    write_text(path, irsim_text(plan, kinematics, step=step, turning=turning, wheelbase=wheelbase))


def replay_in_irsim(
    plan: Plan,
    times: ArrayLike,
    poses: ArrayLike,
    kinematics: Kinematics = "diff",
    *,
    turning: float = TURNING,
    wheelbase: float | None = None,
) -> Replay:
    """Drive ir-sim's own vehicles along a motion, and let ir-sim say who collided.

    At each step each vehicle is told the speed and turn that bring it to its next pose, from where it is in ir-sim;
    collisions stop nobody. Robots that leave are gone from their last instant of motion on.

    Parameters
    ----------
    plan : the scene, and the goals of the file.
    times : (F ≥ 2,) seconds, evenly spaced; their distance is ir-sim's step.
    poses : (F, n, 3) x, y, heading at these times: those of a simulated run, or of the plan (headings count for nothing
        with "omni").
    kinematics, turning, wheelbase : as in `irsim_text`.

    Raises
    ------
    ValueError
        Arrays of other shapes, not finite, times not evenly spaced.
    TautError
        ir-sim is not installed, or refuses the file.
    """
    moments, wanted = _motion(plan, times, poses)
    step = float(moments[-1] - moments[0]) / (len(moments) - 1)
    text = irsim_text(plan, kinematics, step=step, turning=turning, wheelbase=wheelbase)
    world = _made(text)
    vehicles = world.robot_list
    _place(vehicles, wanted[0].tolist(), kinematics)
    bases = [_wheelbase(robot, wheelbase) for robot in plan.scene.robots]
    lasts = _last_motions(plan, wanted)
    states = [_states(vehicles)]
    touching: set[tuple[str, str]] = set()
    collisions = []
    for k in range(1, len(moments)):
        for vehicle, last in zip(vehicles, lasts, strict=True):
            vehicle.unobstructed = k > last
        ahead = zip(vehicles, wanted[k - 1].tolist(), wanted[k].tolist(), bases, strict=True)
        commands = [_command(kinematics, vehicle, now, then, base, step) for vehicle, now, then, base in ahead]
        world.step(commands, list(range(len(commands))))
        states.append(_states(vehicles))
        before, touching = touching, _touching(vehicles)
        collisions += [(float(moments[k]), *pair) for pair in sorted(touching - before)]
    driven = np.array(states, dtype=np.float64).reshape(wanted.shape)
    errors = np.hypot(*np.moveaxis(driven[..., :2] - wanted[..., :2], -1, 0))
    return Replay(moments, driven, errors, tuple(collisions))


def _check(kinematics: Kinematics, **numbers: float) -> None:
    if kinematics not in KINEMATICS:
        raise ValueError(f'kinematics must be "omni", "diff" or "acker", got {kinematics!r}')
    for name, number in numbers.items():
        if not (math.isfinite(number) and number > 0):
            raise ValueError(f"{name} must be a positive number, got {number:g}")


def _robot(
    robot: Robot, route: FloatArray, kinematics: Kinematics, step: float, turning: float, wheelbase: float | None
) -> dict[str, Any]:
    """Return the entry of one robot, whose motion goes through the points of the route, (k ≥ 1, 2)."""
    if robot.radius == 0:
        raise SceneError(f"robot {robot.name}: ir-sim needs a radius above 0; give the robot one, and plan again")
    goals = [list(b) for a, b in pairwise(route.tolist()) if a != b] or [list(robot.goal)]
    first = np.subtract(goals[0], robot.start)
    heading = 0.0 if kinematics == "omni" else math.atan2(first[1], first[0])
    fast = SPARE * robot.speed
    second = {"omni": fast, "diff": float(turning), "acker": STEERING}[kinematics]
    slowest = 0.0 if kinematics == "acker" else -fast
    model: dict[str, Any] = {"name": kinematics}
    state = [*robot.start, heading]
    if kinematics == "acker":
        model |= {"mode": "steer", "wheelbase": _wheelbase(robot, wheelbase)}
        state.append(0.0)
    return {
        "name": robot.name,
        "kinematics": model,
        "shape": {"name": "circle", "radius": robot.radius},
        "state": state,
        "goal": goals,
        # who goes straight at top speed comes that near to each goal
        "goal_threshold": fast * step,
        "vel_max": [fast, second],
        "vel_min": [slowest, -second],
        "behavior": {"name": "dash"},
    }


def _wheelbase(robot: Robot, wheelbase: float | None) -> float:
    return AXLES * robot.radius if wheelbase is None else float(wheelbase)


def _parts(obstacle: Obstacle) -> list[dict[str, Any]]:
    """Return the shapes and places that make up an obstacle."""
    match obstacle:
        case Circle():
            return [{"shape": _disc(obstacle.radius), **_at(*obstacle.center)}]
        case Rectangle():
            x, y = obstacle.x + obstacle.width / 2, obstacle.y + obstacle.height / 2
            return [{"shape": _box(obstacle.width, obstacle.height), **_at(x, y, obstacle.angle)}]
        case Line():
            boxes = [_wall(a, b, obstacle.width) for a, b in pairwise(obstacle.points) if a != b]
            return [*boxes, *({"shape": _disc(obstacle.width / 2), **_at(*point)} for point in obstacle.points)]
        case _:
            return [{"shape": _ring("polygon", obstacle.points), **_at(0, 0)}]


def _wall(a: Sequence[float], b: Sequence[float], width: float) -> dict[str, Any]:
    along = np.subtract(b, a)
    box = _box(float(np.hypot(*along)), width)
    return {"shape": box, **_at((a[0] + b[0]) / 2, (a[1] + b[1]) / 2, math.atan2(along[1], along[0]))}


def _disc(radius: float) -> dict[str, Any]:
    return {"name": "circle", "radius": radius}


def _box(length: float, width: float) -> dict[str, Any]:
    return {"name": "rectangle", "length": length, "width": width}


def _ring(name: str, points: Sequence[Sequence[float]]) -> dict[str, Any]:
    return {"name": name, "vertices": [list(point) for point in points]}


def _at(x: float, y: float, angle: float = 0.0) -> dict[str, list[float]]:
    return {"state": [float(x), float(y), float(angle)]}


def _free_name(name: str, taken: set[str]) -> str:
    """Return the name, or the first of name-2, name-3 … that nothing has: ir-sim wants them unique among all."""
    number, free = 1, name
    while free in taken:
        number += 1
        free = f"{name}-{number}"
    taken.add(free)
    return free


def _motion(plan: Plan, times: ArrayLike, poses: ArrayLike) -> tuple[FloatArray, FloatArray]:
    moments, wanted = np.array(times, dtype=np.float64), np.array(poses, dtype=np.float64)
    n = len(plan.trajectories)
    if moments.ndim != 1 or len(moments) < 2 or wanted.shape != (len(moments), n, 3):
        raise ValueError(f"times must be (F ≥ 2,) and poses (F, {n}, 3), got {moments.shape} and {wanted.shape}")
    if not (np.isfinite(moments).all() and np.isfinite(wanted).all()):
        raise ValueError("times and poses must be finite")
    steps = np.diff(moments)
    if not (steps.min() > 0 and np.ptp(steps) <= 1e-6 * steps.mean()):
        raise ValueError(f"times must be evenly spaced, got steps from {steps.min():g} to {steps.max():g} s")
    return moments, wanted


def _last_motions(plan: Plan, wanted: FloatArray) -> list[int]:
    """Return up to which instant each robot is there: of those that leave, the last one before they rest for good."""
    out = []
    for robot, poses in zip(plan.scene.robots, np.moveaxis(wanted, 1, 0), strict=True):
        moving = np.flatnonzero((poses[:, :2] != poses[-1, :2]).any(axis=1))
        out.append(len(poses) if plan.scene.stays(robot) else int(moving[-1]) if moving.size else 0)
    return out


def _made(text: str) -> Any:
    """Return the world of such a file, without window or figure, in which collisions stop nobody."""
    try:
        irsim = importlib.import_module("irsim")
    except ImportError:
        raise TautError("ir-sim is not installed; install it with: pip install 'taut[irsim]'") from None
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "world.yaml"
        path.write_text(text, encoding="utf-8")
        try:
            world = irsim.make(str(path), headless=True, log_level="CRITICAL")
        except (KeyError, TypeError, ValueError) as error:
            raise TautError(f"this ir-sim refuses the file, 2.12 or later is needed: {error}") from None
    world.world_param.collision_mode = "unobstructed"
    return world


def _place(vehicles: Sequence[Any], poses: Sequence[Sequence[float]], kinematics: Kinematics) -> None:
    for vehicle, (x, y, heading) in zip(vehicles, poses, strict=True):
        # "omni" is told velocities along its own axes: without a heading they are those of the plane
        pose = [x, y, 0.0 if kinematics == "omni" else heading, 0.0]
        vehicle.set_state(pose[: len(vehicle.state)], init=True)


def _touching(vehicles: Sequence[Any]) -> set[tuple[str, str]]:
    """Return who touches what now, two robots once, in the order of the scene."""
    rank = {vehicle.name: k for k, vehicle in enumerate(vehicles)}
    return {
        (vehicle.name, other.name)
        for vehicle in vehicles
        for other in vehicle.collision_obj
        if not vehicle.unobstructed and rank.get(other.name, len(rank)) > rank[vehicle.name]
    }


def _states(vehicles: Sequence[Any]) -> list[list[float]]:
    return [vehicle.state[:3, 0].tolist() for vehicle in vehicles]


def _command(
    kinematics: Kinematics, vehicle: Any, now: Sequence[float], then: Sequence[float], base: float, step: float
) -> list[float]:
    """Return what brings a vehicle of ir-sim, meant to be at the pose `now`, to the pose `then` in one step."""
    x, y, heading, *_ = vehicle.state[:, 0].tolist()
    dx, dy = then[0] - x, then[1] - y
    if kinematics == "omni":
        return [dx / step, dy / step]
    c, s = math.cos(heading), math.sin(heading)
    ahead, aside = c * dx + s * dy, c * dy - s * dx
    speed = ahead / step
    if kinematics == "diff":
        # ir-sim goes along its old heading and then turns
        lean = math.atan(GAIN * aside) if ahead >= 0 else -math.atan(GAIN * aside)
        return [speed, _wrapped(then[2] - heading + lean) / step]
    way = math.hypot(then[0] - now[0], then[1] - now[1])
    bend = _wrapped(then[2] - now[2]) / way if way > 0 else 0.0
    bend += 2 / base * _wrapped(then[2] - heading) + aside / base**2
    return [speed, math.atan(base * bend)]


def _wrapped(angle: float) -> float:
    return math.remainder(angle, math.tau)
