"""Running a plan with real vehicles: `simulate`, and the `Run` that comes of it."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from taut.certificate import certify
from taut.control.coordination import Dependencies, dependencies
from taut.errors import PlanError, SceneError
from taut.motion import Plan
from taut.scene import FloatArray, Point, Robot, Scene
from taut.simulation._loop_state import Now
from taut.simulation.disturbances import Disturbances
from taut.simulation.driving import Driven, Setting, Watching, drive, nobody_waits, setting_of
from taut.simulation.margin import SLACK
from taut.simulation.sensors import Lidar, scan
from taut.simulation.surroundings import surroundings_of
from taut.simulation.vehicles import KINDS, Vehicle, tables, tracking_for, vehicle_for

LONGEST = 10.0  # a run may last so many times as long as its plan, and a minute more
LEAST_STEP, MOST_STEP = 1e-9, 0.25  # seconds: controllers need a few steps while their vehicle reaches its speed
_FARTHEST = 0.05  # of the workspace: what a robot may cross in a step


@dataclass(frozen=True)
class Collision:
    """Two discs, or a disc and an obstacle, that overlapped for a while.

    Parameters
    ----------
    time : seconds at which it began.
    place : metres, between the two robots, or of the robot that hit an obstacle.
    robot, other : names; the other is a robot, an obstacle or "the wall".
    depth : metres, the greatest.
    """

    time: float
    place: Point
    robot: str
    other: str
    depth: float


@dataclass(frozen=True)
class Wait:
    """A stretch of time in which a robot was kept back so that another could pass first.

    Parameters
    ----------
    robot, holder : names.
    begin, end : seconds.
    lost : seconds of its plan that the robot lost.
    """

    robot: str
    holder: str
    begin: float
    end: float
    lost: float


@dataclass(frozen=True)
class Nearest:
    """How near a robot has come, between the outlines; negative if they overlapped.

    Parameters
    ----------
    distance : metres; inf if it never came near enough to be measured.
    time, place : seconds and metres, of the robot.
    other : name of the robot or obstacle, "the wall" or, if it is inf, "".
    """

    distance: float
    time: float
    place: Point
    other: str


@dataclass(frozen=True, eq=False)
class Scans:
    """What the lidars saw.

    Parameters
    ----------
    times : (k,) seconds.
    angles : (b,) radians from the heading.
    ranges : (k, n, b) metres; where nothing is in reach, ``reach``.
    reach : metres.
    """

    times: FloatArray
    angles: FloatArray
    ranges: FloatArray
    reach: float


@dataclass(frozen=True, eq=False)
class Run:
    """What became of a plan.

    Parameters
    ----------
    plan : that the team followed.
    vehicles : of the n robots, in the scene's order.
    seed, dt : of everything random; seconds of a step.
    disturbances : that it met.
    coordinated : whether late robots slowed those that pass after them.
    times : (k,) seconds of the recorded instants, the first 0 and the last the end.
    poses : (k, n, 3) x and y in metres, heading in radians, not wrapped; a robot that has left stays where it left.
    progress : (k, n) plan time that each robot has reached, seconds.
    strays : (k, n) metres from the place that is planned for this plan time.
    arrivals : (n,) seconds; nan if a robot has not arrived.
    greatest_stray, mean_stray : (n,) metres, over all steps: the greatest and the root of the mean square.
    strayed_at : (n,) seconds, of the greatest.
    clearances, separations : per robot, the nearest obstacle and the nearest robot of all steps.
    collisions, waits : by time.
    distance, turned, work : (n,) metres driven, radians turned, joules per kilogram: kinetic energy gained, of which
        braking gives nothing back, and rolling (2 % of the weight).
    scans : of the lidars, if there were any.
    """

    plan: Plan
    vehicles: tuple[Vehicle, ...]
    seed: int
    dt: float
    disturbances: Disturbances
    coordinated: bool
    times: FloatArray
    poses: FloatArray
    progress: FloatArray
    strays: FloatArray
    arrivals: FloatArray
    greatest_stray: FloatArray
    mean_stray: FloatArray
    strayed_at: FloatArray
    clearances: tuple[Nearest, ...]
    separations: tuple[Nearest, ...]
    collisions: tuple[Collision, ...]
    waits: tuple[Wait, ...]
    distance: FloatArray
    turned: FloatArray
    work: FloatArray
    scans: Scans | None = None

    @property
    def names(self) -> tuple[str, ...]:
        """Of the robots."""
        return tuple(robot.name for robot in self.plan.scene.robots)

    @property
    def seconds(self) -> float:
        """How long it lasted."""
        return float(self.times[-1])

    @property
    def arrived(self) -> bool:
        """Whether all robots have arrived."""
        return not np.isnan(self.arrivals).any()

    @property
    def makespan(self) -> float:
        """Last arrival, seconds; nan if a robot has not arrived."""
        return float(self.arrivals.max(initial=0.0))

    @property
    def delays(self) -> FloatArray:
        """(n,) seconds by which each robot arrived later than planned; nan if it has not."""
        return np.asarray(self.arrivals - np.array([path.arrival for path in self.plan.trajectories], dtype=np.float64))


def simulate(
    plan: Plan,
    vehicle: str | Vehicle | Mapping[str, str | Vehicle] = "differential",
    seed: int = 0,
    disturbances: Disturbances | None = None,
    coordination: bool = True,
    lidar: Lidar | None = None,
    dt: float = 0.02,
    every: float = 0.1,
) -> Run:
    """Let real vehicles follow a plan, in a closed loop, until all have arrived or nobody goes on.

    At every step each robot is told how far it may go (those that are late slow those that pass after them), its
    tracker takes a command from where the robot believes to be, and the vehicle moves as its limits and what goes wrong
    let it. Collisions are noted; they stop nobody.

    Parameters
    ----------
    plan : certified; robots begin at rest and face their first move.
    vehicle : for all robots, or by name (those not named get a differential drive): a name of
        `taut.simulation.KINDS`, see `vehicle_for`, or a vehicle.
    seed : of everything random: the same seed gives the same run, bit for bit.
    disturbances : what goes wrong; nothing by default.
    coordination : whether late robots slow those that pass after them; without, each keeps to the clock.
    lidar : carried by every robot, read at every recorded instant.
    dt : seconds of a step, at most 0.25, in which no robot may cross more than a twentieth of the workspace.
    every : seconds between recorded instants, rounded to steps.

    Raises
    ------
    PlanError
        The plan does not hold.
    SceneError
        No such vehicle or robot, a number that makes no sense.

    Notes
    -----
    Time O(robots) a step and a little more where they are close. The run ends after ten times the plan and a minute.

    Examples
    --------
    >>> from taut import Robot, Scene, plan
    >>> run = simulate(plan(Scene((0, 0, 4, 4), robots=[Robot("R1", (1, 1), (3, 1), radius=0.2)])).plan)
    >>> run.arrived, len(run.collisions)
    (True, 0)
    """
    met = disturbances or Disturbances()
    setting, vehicles = prepared(plan, vehicle, coordination, dt, met.position_noise)
    if not (math.isfinite(every) and every > 0):
        raise SceneError(f"the time between recorded instants must be positive and finite, got {every:g} s")
    if lidar is not None and not isinstance(lidar, Lidar):
        raise SceneError(f"lidar must be a Lidar or None, got {lidar!r}")
    seen: list[tuple[float, FloatArray]] = []
    watch = None if lidar is None else looking(plan, lidar, checked_seed(seed), seen)
    driven = drive(setting, met, checked_seed(seed), longest(plan), max(round(min(every / dt, 2.0**62)), 1), watch)
    return _run(setting, vehicles, driven, met, seed, coordination, None if lidar is None else _scans(lidar, seen))


def prepared(
    plan: Plan, vehicle: str | Vehicle | Mapping[str, str | Vehicle], coordination: bool, dt: float, noise: float = 0.0
) -> tuple[Setting, tuple[Vehicle, ...]]:
    """Lay out a plan for any number of runs of robots that know their places up to ``noise``; raises as `simulate`."""
    dt = checked_step(dt)
    certificate = certify(plan)
    if not certificate.ok:
        raise PlanError(f"only plans that hold are simulated; {certificate.problems[0]}")
    robots = plan.scene.robots
    vehicles = vehicles_of(plan.scene, vehicle)
    _check_hops(plan.scene, vehicles, dt)
    trackings = [tracking_for(robot, own, dt, noise) for robot, own in zip(robots, vehicles, strict=True)]
    waits = waits_of(plan) if coordination else nobody_waits(plan)
    return setting_of(plan, vehicles, trackings, dt, waits), vehicles


def waits_of(plan: Plan) -> Dependencies:
    """Who waits for whom in a run of a plan: its gap is kept but for `SLACK`."""
    return dependencies(plan, -SLACK * plan.scene.gap)


def longest(plan: Plan) -> float:
    """Seconds after which a run is given up."""
    return LONGEST * plan.makespan + 60.0


def checked_step(dt: float) -> float:
    """Return the seconds of a step.

    Raises
    ------
    SceneError
        They are no number, not positive, or too small or large to follow anything.
    """
    try:
        step = float(dt)
    except (TypeError, ValueError, OverflowError):
        raise SceneError(f"the step must be a number of seconds, got {dt!r}") from None
    if not (math.isfinite(step) and step > 0):
        raise SceneError(f"the step must be positive and finite, got {step:g} s")
    if not LEAST_STEP <= step <= MOST_STEP:
        raise SceneError(f"the step must be from {LEAST_STEP:g} to {MOST_STEP:g} s, got {step:g} s")
    return step


def checked_seed(seed: int) -> int:
    """Return the seed.

    Raises
    ------
    SceneError
        It is no whole number from 0 to 2⁶² − 1.
    """
    if not isinstance(seed, int | np.integer) or not 0 <= seed < 2**62:
        raise SceneError(f"the seed must be a whole number of at least 0, got {seed!r}")
    return int(seed)


def vehicles_of(
    scene: Scene, vehicle: str | Vehicle | Mapping[str, str | Vehicle], reserve: float = 1.25
) -> tuple[Vehicle, ...]:
    """Return the vehicle of every robot, as `simulate` takes them; ``reserve`` as for `vehicle_for`."""
    if isinstance(vehicle, Mapping):
        for name in vehicle:
            scene.robot(name)
        return tuple(_vehicle(robot, vehicle.get(robot.name, "differential"), reserve) for robot in scene.robots)
    return tuple(_vehicle(robot, vehicle, reserve) for robot in scene.robots)


def _vehicle(robot: Robot, vehicle: str | Vehicle, reserve: float) -> Vehicle:
    if isinstance(vehicle, str):
        return vehicle_for(robot, vehicle, reserve)
    if not isinstance(vehicle, Vehicle):
        raise SceneError(f"a vehicle must be one of {', '.join(KINDS)}, or made by their classes, got {vehicle!r}")
    return vehicle


def _check_hops(scene: Scene, vehicles: tuple[Vehicle, ...], dt: float) -> None:
    """Refuse a step in which robots jump across the world."""
    fastest = float(tables(vehicles)[1][:, 0].max(initial=0.0))
    x, y = np.array(scene.workspace, dtype=np.float64).T
    width = math.hypot(np.ptp(x), np.ptp(y))
    if fastest * dt > _FARTHEST * width:
        raise SceneError(
            f"in a step of {dt:g} s a vehicle drives {fastest * dt:.4g} m, too far in a workspace of {width:.4g} m "
            f"from corner to corner; take a step of at most {_FARTHEST * width / fastest:.1g} s"
        )


def collisions_of(rows: FloatArray, names: tuple[str, ...], shapes: tuple[str, ...]) -> tuple[Collision, ...]:
    """Return the collisions that the loop has noted, by time, with the names of robots and shapes."""
    noted = [
        Collision(when, (x, y), names[int(i)], names[int(j)] if j >= 0 else shapes[-1 - int(j)], depth)
        for i, j, when, x, y, depth in rows.tolist()
    ]
    return tuple(sorted(noted, key=lambda c: c.time))


def nearest_of(rows: FloatArray, names: tuple[str, ...]) -> tuple[Nearest, ...]:
    """Return for every robot what it came nearest to, as the loop has measured it."""
    return tuple(
        Nearest(distance, time, (x, y), names[int(other)] if other >= 0 else "")
        for distance, time, x, y, other in rows.tolist()
    )


def looking(plan: Plan, lidar: Lidar, seed: int, seen: list[tuple[float, FloatArray]]) -> Watching:
    """Return what lets all robots look around whenever it is shown the team: times and ranges (n, b) go to ``seen``."""
    surroundings = surroundings_of(plan.scene)

    def watch(time: float, now: Now) -> None:
        poses, present = now.state[:, :3], now.gone > time
        seen.append((time, scan(lidar, surroundings, poses, present=present, seed=seed, step=len(seen)).ranges))

    return watch


def _scans(lidar: Lidar, seen: list[tuple[float, FloatArray]]) -> Scans:
    times, ranges = zip(*seen, strict=True)
    return Scans(np.array(times), np.array(lidar.angles), np.array(ranges), lidar.reach)


def _run(
    setting: Setting,
    vehicles: tuple[Vehicle, ...],
    driven: Driven,
    met: Disturbances,
    seed: int,
    coordinated: bool,
    scans: Scans | None,
) -> Run:
    names, tally = setting.names, driven.tally
    waits = [Wait(names[int(i)], names[int(j)], begin, end, lost) for i, j, begin, end, lost in driven.held.tolist()]
    with np.errstate(invalid="ignore", divide="ignore"):
        mean = np.nan_to_num(np.sqrt(tally.done[:, 3] / tally.done[:, 4]))
    return Run(
        plan=setting.plan,
        vehicles=vehicles,
        seed=seed,
        dt=setting.dt,
        disturbances=met,
        coordinated=coordinated,
        times=driven.rows.times,
        poses=driven.rows.poses,
        progress=driven.rows.progress,
        strays=driven.rows.stray,
        arrivals=np.where(np.isinf(driven.now.arrived), np.nan, driven.now.arrived),
        greatest_stray=tally.worst[:, 0].copy(),
        mean_stray=mean,
        strayed_at=tally.worst[:, 1].copy(),
        clearances=nearest_of(tally.clear, setting.shapes),
        separations=nearest_of(tally.apart, names),
        collisions=collisions_of(driven.collisions, names, setting.shapes),
        waits=tuple(sorted(waits, key=lambda w: w.begin)),
        distance=tally.done[:, 0].copy(),
        turned=tally.done[:, 1].copy(),
        work=tally.done[:, 2].copy(),
        scans=scans,
    )
