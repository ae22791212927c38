"""Teams that steer themselves: real vehicles under a control law, `steer`, and the `Steered` that comes of it."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, fields, replace
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

from taut.control._course_kernels import COLUMNS
from taut.control.laws import Field, Links
from taut.control.tracking import Tracking
from taut.errors import SceneError
from taut.graph import Graph, algebraic_connectivity
from taut.motion import Plan, Trajectory
from taut.scene import FloatArray, Scene
from taut.simulation._loop_state import (
    COLLISIONS,
    EVENTS_FULL,
    GOING,
    PAIRS,
    STEP,
    Chance,
    Ground,
    Near,
    Now,
    Tally,
    Team,
)
from taut.simulation._steering_kernels import Shunts, steer_step
from taut.simulation.disturbances import Disturbances
from taut.simulation.driving import (
    disturbed,
    ground_of,
    more_events,
    more_pairs,
    nearness,
    nothing_counted,
    room_for_collisions,
    standing,
    unmeasured,
    watched_within,
)
from taut.simulation.running import (
    Collision,
    Nearest,
    checked_seed,
    checked_step,
    collisions_of,
    nearest_of,
    vehicles_of,
)
from taut.simulation.vehicles import KINDS, Ackermann, Vehicle, tables
from taut.validation import check_form

HOLD = 1.0  # seconds for which a team has to stay settled
_SETTLED, _TRUCKS_SETTLED = 0.01, 0.05  # of its speed
_QUICKEST = 5.0  # 1/s: the quickest change of a law that vehicles with a heading follow; they turn four times as quick
_STEADY = 0.1  # of a law's velocities: the most that one step may change
_GLIMPSE = 2.0**-10  # of a step: how far ahead the change of the law is looked for


@dataclass(frozen=True, eq=False)
class Steered:
    """What became of a team that steered itself.

    Parameters
    ----------
    scene : in which it moved.
    vehicles : of the n robots, in the scene's order.
    seed, dt : of everything random; seconds of a step.
    disturbances : that it met.
    times : (k,) seconds of the recorded instants, the first 0 and the last the end.
    poses : (k, n, 3) x and y in metres, heading in radians, not wrapped.
    velocities : (k, n, 2) metres a second that the law asks for where the robots truly are, before the team is slowed;
        nan where it has none.
    clock : (k,) the law's time, seconds: it runs slower where the team is slowed.
    settled_at : seconds from which on the law asked for nearly nothing; nan if the team has not settled.
    clearances, separations : per robot, the nearest obstacle and the nearest robot of all steps.
    collisions : by time.
    distance, turned, work : (n,) as of a `Run`.
    """

    scene: Scene
    vehicles: tuple[Vehicle, ...]
    seed: int
    dt: float
    disturbances: Disturbances
    times: FloatArray
    poses: FloatArray
    velocities: FloatArray
    clock: FloatArray
    settled_at: float
    clearances: tuple[Nearest, ...]
    separations: tuple[Nearest, ...]
    collisions: tuple[Collision, ...]
    distance: FloatArray
    turned: FloatArray
    work: FloatArray

    @property
    def names(self) -> tuple[str, ...]:
        """Of the robots."""
        return tuple(robot.name for robot in self.scene.robots)

    @property
    def seconds(self) -> float:
        """How long it lasted."""
        return float(self.times[-1])

    @property
    def settled(self) -> bool:
        """Whether the team has settled."""
        return math.isfinite(self.settled_at)

    @property
    def plan(self) -> Plan:
        """The motions as they were driven, to be drawn or animated: straight between the recorded instants.

        It claims nothing and is not certified; its goals are where the robots ended.
        """
        ends = self.poses[-1, :, :2].tolist()
        robots = [replace(robot, goal=(x, y)) for robot, (x, y) in zip(self.scene.robots, ends, strict=True)]
        paths = [
            Trajectory(name, np.column_stack([self.times, self.poses[:, i, :2]])) for i, name in enumerate(self.names)
        ]
        return Plan(replace(self.scene, robots=tuple(robots)), tuple(paths), planner={"method": "steering"})


def steer(
    scene: Scene,
    law: Field,
    vehicle: str | Vehicle | Mapping[str, str | Vehicle] = "differential",
    seed: int = 0,
    disturbances: Disturbances | None = None,
    dt: float = 0.02,
    every: float = 0.1,
    seconds: float = 60.0,
    settled: float | None = None,
) -> Steered:
    """Let real vehicles do what a control law asks of the team, in a closed loop, until it has settled.

    At every step the law is asked for the velocity of each robot where the robots believe to be. Where a vehicle cannot
    be so fast, brake so hard or turn so quickly, all velocities are scaled down by one factor, and the law's clock with
    them: the team stays on the ways of the law and only takes longer. Then each vehicle does what it can. Obstacles are
    not avoided; collisions are noted and stop nobody.

    Parameters
    ----------
    scene : robots begin at their starts, at rest, and face their first move; goals and start times play no part.
    law : from the time in seconds and positions (n, 2) in metres to velocities (n, 2), such as
        `taut.control.consensus`; robot i is vertex i of its graph. Robots for which it gives nan stand.
    vehicle : as for `simulate`, but no faster than the scene has the robots: here nobody has to catch up.
    seed, disturbances : as for `simulate`. Who halts or is dead stays a neighbour of the others.
    dt : seconds of a step.
    every : seconds between recorded instants, rounded to steps.
    seconds : how long at most.
    settled : the team has settled when the law has asked of all that live for less than this share of the robot's speed
        for a second; with 0 the run lasts to its end. By default 0.01, and 0.05 where there is a truck. Robots that
        have to turn stand where half of it is asked for.

    Raises
    ------
    SceneError
        No such vehicle or robot, a number that makes no sense.
    ValueError
        A law that does not give (n, 2) velocities, or is for another number of robots.

    Notes
    -----
    Scaled together, p' = s u(τ, p) and τ' = s with 0 < s ≤ 1: p(t) = q(τ(t)) for a motion q of the law. So what a law
    promises of places holds for integrators up to the length of a step: links are kept, the centroid rests, functions
    that fall along the law (Lyapunov's) fall. Robots slowed one by one would promise nothing. s is the greatest number
    for which nobody is asked for more than its top speed, or to gain more speed in a step or to change its velocity by
    more, s² |du/dτ|, than its acceleration allows, and for which the quickest s |du/dτ| is at most a tenth of the
    greatest |u| a step, and 5/s of it if vehicles have to turn.

    A unicycle or differential drive turns its nearer end towards its velocity and drives at the part of it along its
    heading h, ahead or back: p' = h hᵀ u. In a field u = −∇Φ, as consensus, formation and rendezvous are on a fixed
    graph, Φ' = −Σ (hᵀ∇Φ)² ≤ 0: it falls, whatever the headings, as long as wheels gain their speeds at once (Lin,
    Francis and Maggiore, "Necessary and sufficient graphical conditions for formation control of unicycles", IEEE
    Transactions on Automatic Control 50, 2005). The centroid does not rest then, and a link may be lost. A truck drives
    on an arc to its place, ahead or back, and away from places within its turning circles, to come back to them: it
    gets there, but on its way Φ may rise.

    Examples
    --------
    >>> from taut import Robot, Scene
    >>> from taut.control import consensus
    >>> from taut.graph import Graph
    >>> scene = Scene((0, 0, 8, 4), robots=[Robot("A", (1, 2), (1, 2)), Robot("B", (7, 2), (7, 2))], gap=0.1)
    >>> met = steer(scene, consensus(Graph.from_edges(2, [(0, 1)])), "integrator")
    >>> met.settled, met.poses[-1, 0, :2].round(1).tolist()
    (True, [4.0, 2.0])
    """
    vehicles = vehicles_of(scene, vehicle, reserve=1.0)
    if settled is None:
        settled = _TRUCKS_SETTLED if any(isinstance(each, Ackermann) for each in vehicles) else _SETTLED
    dt = checked_step(dt)
    _check_numbers(every, seconds, settled)
    check_form(scene)
    met = disturbances or Disturbances()
    loop, shapes = _begun(scene, vehicles, law, met, checked_seed(seed), dt)
    limits = _limits(loop.team, dt)
    calm = settled * np.array([robot.speed for robot in scene.robots], dtype=np.float64)
    steps, stride = round(seconds / dt), max(round(every / dt), 1)
    rows: list[tuple[float, FloatArray, FloatArray, float]] = []
    clock, pace, since = 0.0, 0.0, math.inf
    while True:
        step = int(loop.counts[STEP])
        if step % stride == 0 or step == steps:
            time, asked = step * dt, _asked(law, clock, loop.now.state[:, :2])
            rows.append((time, loop.now.state[:, :3].copy(), asked, clock))
            still = (np.hypot(*asked.T) < calm) | (loop.team.dies <= time)
            since = min(since, time) if still.all() else math.inf
            if step == steps or time >= since + HOLD:
                break
        wanted, ways, pace = _paced(law, clock, loop.now.seen[:, :2], limits, calm, pace, dt)
        loop = _stepped(loop, wanted, ways, dt, scene.tol)
        clock += pace * dt
    times, poses, velocities, clocks = zip(*rows, strict=True)
    names, tally = tuple(robot.name for robot in scene.robots), loop.tally
    return Steered(
        scene=scene,
        vehicles=vehicles,
        seed=seed,
        dt=dt,
        disturbances=met,
        times=np.array(times),
        poses=np.array(poses),
        velocities=np.array(velocities),
        clock=np.array(clocks),
        settled_at=since if times[-1] >= since + HOLD else math.nan,
        clearances=nearest_of(tally.clear, shapes),
        separations=nearest_of(tally.apart, names),
        collisions=collisions_of(loop.collisions[: loop.counts[COLLISIONS]], names, shapes),
        distance=tally.done[:, 0].copy(),
        turned=tally.done[:, 1].copy(),
        work=tally.done[:, 2].copy(),
    )


def fiedler_values(run: Steered, links: Links) -> FloatArray:
    """(k,) λ2 of the team's graph at the recorded instants, with the weights of its links.

    Parameters
    ----------
    links : the graph, or a function from positions (n, 2) to the graph there, as for `taut.control.consensus`.
    """
    if isinstance(links, Graph):
        return np.full(len(run.times), algebraic_connectivity(links))
    return np.array([algebraic_connectivity(links(places)) for places in run.poses[:, :, :2]])


def formation_error(positions: ArrayLike, offsets: ArrayLike) -> float:
    """Return how far the robot stands that is farthest from its place, in the formation laid about the team's centroid.

    Parameters
    ----------
    positions, offsets : (n, 2) metres; the formation anywhere in the plane, not turned.

    >>> formation_error([(5, 5), (7, 5)], [(0, 0), (1, 0)])
    0.5
    """
    here, there = (np.asarray(each, dtype=np.float64).reshape(-1, 2) for each in (positions, offsets))
    apart = here - there
    return float(np.hypot(*(apart - apart.mean(axis=0)).T).max()) if len(apart) else 0.0


class _Limits(NamedTuple):
    """What the team can do: (n,) metres a second and metres a second²; the rate of a law that it follows, 1/s.

    ``turns`` (n,): who has to turn to its velocity.
    """

    speeds: FloatArray
    accelerations: FloatArray
    rate: float
    turns: NDArray[np.bool_]


class _Loop(NamedTuple):
    """All that a step needs and changes, see `taut.simulation._loop_state` and `steer_step`."""

    team: Team
    chance: Chance
    ground: Ground
    shunts: Shunts
    now: Now
    tally: Tally
    near: Near
    collisions: FloatArray
    counts: NDArray[np.int64]


def _check_numbers(every: float, seconds: float, settled: float) -> None:
    if not (math.isfinite(every) and every > 0):
        raise SceneError(f"the time between recorded instants must be positive and finite, got {every:g} s")
    if not (math.isfinite(seconds) and seconds >= 0):
        raise SceneError(f"the longest time must be finite and not negative, got {seconds:g} s")
    if not 0 <= settled < 1:
        raise SceneError(f"the speed of a settled team must be a share of its own from 0 to below 1, got {settled:g}")


def _begun(
    scene: Scene, vehicles: Sequence[Vehicle], law: Field, met: Disturbances, seed: int, dt: float
) -> tuple[_Loop, tuple[str, ...]]:
    """Lay out the beginning of a run; returns the names of the shapes, too."""
    healthy = _team(scene, vehicles)
    team, chance = disturbed(scene, healthy, met, seed)
    ground, shapes = ground_of(scene)
    near = nearness(healthy, ground, watched_within(scene, healthy), dt, 1.0 + met.speed_error)
    first = _asked(law, 0.0, healthy.stamps[:, 1:])
    n = len(vehicles)
    now = standing(team, np.nan_to_num(np.arctan2(first[:, 1], first[:, 0])))
    shunts = Shunts(np.ones(n, dtype=np.int64), np.zeros(n, dtype=np.bool_), np.full(1, -1, dtype=np.int64))
    room = room_for_collisions(near)
    return _Loop(team, chance, ground, shunts, now, unmeasured(n), near, room, nothing_counted()), shapes


def _team(scene: Scene, vehicles: Sequence[Vehicle]) -> Team:
    """Lay out the robots for the loop, with the plan to stay where they start."""
    n = len(vehicles)
    kinds, params = tables(vehicles)
    starts = np.array([robot.start for robot in scene.robots], dtype=np.float64).reshape(n, 2)
    return Team(
        kinds=kinds,
        params=params,
        tuning=np.zeros((n, len(fields(Tracking)))),
        course=np.zeros((n, COLUMNS)),
        radii=np.array([robot.radius for robot in scene.robots], dtype=np.float64),
        stamps=np.column_stack([np.zeros(n), starts]),
        first=np.arange(n + 1, dtype=np.int64),
        leaves=np.zeros(n, dtype=np.bool_),
        drift=np.ones(n),
        dies=np.full(n, np.inf),
    )


def _limits(team: Team, dt: float) -> _Limits:
    turns = team.kinds != KINDS.index("integrator")
    rate = min(_QUICKEST, _STEADY / dt) if turns.any() else _STEADY / dt
    return _Limits(team.params[:, 0], team.params[:, 2], rate, turns)


def _stepped(loop: _Loop, wanted: FloatArray, ways: FloatArray, dt: float, tol: float) -> _Loop:
    """Let the team drive one step; arrays change in place, and where they are full there is more room afterwards."""
    turning = 4.0 * min(_QUICKEST, _STEADY / dt)
    while True:
        status = steer_step(
            dt, tol, turning, loop.chance, loop.team, loop.ground, wanted, ways, loop.shunts, loop.now, loop.tally,
            loop.near, loop.collisions, loop.counts,
        )  # fmt: skip
        if status == GOING:
            return loop
        if status == EVENTS_FULL:
            loop = loop._replace(collisions=more_events(loop.collisions, loop.counts[PAIRS]))
        else:
            loop = loop._replace(near=more_pairs(loop.near, loop.counts))


def _asked(law: Field, time: float, places: FloatArray) -> FloatArray:
    """Velocities that the law asks for, (n, 2)."""
    velocities = np.array(law(time, places.copy()), dtype=np.float64)
    if velocities.shape != places.shape:
        raise ValueError(f"the law must give velocities {places.shape}, got shape {velocities.shape}")
    return velocities


def _paced(
    law: Field, clock: float, places: FloatArray, limits: _Limits, calm: FloatArray, before: float, dt: float
) -> tuple[FloatArray, FloatArray, float]:
    """Velocities of the whole team at a pace that its vehicles can go.

    Returns
    -------
    wanted : (n, 2) metres a second; 0 for those that would have to turn for next to nothing.
    ways : (n,) half the metres that each robot would still go, were the law linear: a place guessed too far is missed
        by a truck, one guessed too near costs it a detour.
    pace : of the law's clock, in (0, 1].
    """
    asked = np.nan_to_num(_asked(law, clock, places), nan=0.0, posinf=0.0, neginf=0.0)
    speeds = np.hypot(*asked.T)
    with np.errstate(divide="ignore", invalid="ignore"):
        pace = float((limits.speeds / speeds).min(initial=1.0))
        gained = float((limits.accelerations * dt / speeds).min(initial=np.inf))
        glimpse = _GLIMPSE * dt * pace
        change = (_asked(law, clock + glimpse, places + glimpse * asked) - asked) / glimpse
        # who has no velocity, here or there, is left out
        changes = np.nan_to_num(np.hypot(*change.T), nan=0.0, posinf=0.0)
        rate = changes.max(initial=0.0) / speeds.max(initial=0.0)
        hardest = np.sqrt((limits.accelerations / changes).min(initial=np.inf))
        pace = float(np.fmin(min(pace, before + gained), np.fmin(hardest, limits.rate / rate)))
        ways = 0.5 * speeds / np.fmax(changes / speeds, rate)
    wanted = pace * asked
    wanted[limits.turns & (speeds < 0.5 * calm)] = 0.0
    return wanted, ways, pace
