"""Motions in time: Trajectory (one robot) and Plan (the team), their metrics and sampling."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from itertools import pairwise

import numpy as np
from numpy.typing import ArrayLike

from taut.errors import PlanError
from taut.scene import FloatArray, Robot, Scene


@dataclass(frozen=True, eq=False)
class Trajectory:
    """The motion of one robot: straight legs between stamps, rest after the last.

    Parameters
    ----------
    name : the robot's name.
    stamps : (k, 3) array of t (seconds, strictly increasing from 0), x, y (metres); kept read-only.

    Raises
    ------
    PlanError
        Not finite, not (k ≥ 1, 3), first time not 0 or times not strictly increasing.
    """

    name: str
    stamps: FloatArray

    def __post_init__(self) -> None:
        where = f"robot {self.name}: "
        try:
            stamps = np.array(self.stamps, dtype=np.float64)
        except (TypeError, ValueError):
            raise PlanError(where + "stamps must be a list of [t, x, y] numbers") from None
        if stamps.ndim != 2 or stamps.shape[0] == 0 or stamps.shape[1] != 3:
            raise PlanError(where + "stamps must be a non-empty list of [t, x, y]")
        bad = np.flatnonzero(~np.isfinite(stamps).all(axis=1))
        if bad.size:
            raise PlanError(where + f"stamp {bad[0] + 1} is not finite")
        if stamps[0, 0] != 0.0:
            raise PlanError(where + f"the first stamp must be at t = 0, got {stamps[0, 0]:g}")
        late = np.flatnonzero(np.diff(stamps[:, 0]) <= 0)
        if late.size:
            raise PlanError(
                where + f"times must increase strictly: stamp {late[0] + 2} is not after stamp {late[0] + 1}"
            )
        stamps.setflags(write=False)
        object.__setattr__(self, "stamps", stamps)

    def __eq__(self, other: object) -> bool:
        return isinstance(other, Trajectory) and self.name == other.name and np.array_equal(self.stamps, other.stamps)

    __hash__ = None  # type: ignore[assignment]  # holds an array

    @property
    def times(self) -> FloatArray:
        """Times of the stamps, (k,) seconds."""
        return self.stamps[:, 0]

    @property
    def points(self) -> FloatArray:
        """Positions of the stamps, (k, 2) metres."""
        return self.stamps[:, 1:]

    @property
    def length(self) -> float:
        """Metres travelled."""
        with np.errstate(over="ignore"):  # a plan file may hold any doubles; its length is then infinite
            return float(np.hypot(*np.diff(self.points, axis=0).T).sum())

    @property
    def arrival(self) -> float:
        """First instant after which the robot stays at its last position for good, seconds."""
        moved = np.flatnonzero((self.points != self.points[-1]).any(axis=1))
        return float(self.times[moved[-1] + 1]) if moved.size else 0.0

    @property
    def waits(self) -> list[tuple[float, float, float, float]]:
        """Rests before arrival as (from, until, x, y); consecutive rests are one."""
        out: list[tuple[float, float, float, float]] = []
        arrival = self.arrival
        for (t0, x0, y0), (t1, x1, y1) in pairwise(self.stamps.tolist()):
            if x0 != x1 or y0 != y1 or t0 >= arrival:
                continue
            if out and out[-1][1] == t0:
                out[-1] = (out[-1][0], t1, x0, y0)
            else:
                out.append((t0, t1, x0, y0))
        return out

    def at(self, times: ArrayLike) -> FloatArray:
        """Positions at the given times, (n, 2) for n times, (2,) for one; outside the stamps the first or last."""
        t = np.asarray(times, dtype=np.float64)
        return np.stack([np.interp(t, self.times, self.points[:, k]) for k in (0, 1)], axis=-1)


@dataclass(frozen=True, eq=False)
class Plan:
    """A timed motion for every robot of a scene, in the scene's order.

    Parameters
    ----------
    scene : the scene it was planned for; radius, speed and what happens at the goal come from there only.
    trajectories : one per robot, same order and names as ``scene.robots``.
    planner : how it was made (method, order, seed, rounds, seconds).
    claims : what the certificate has to prove beyond the scene (contact …).
    lower_bound : {"model": "plane" | "roadmap", "value": seconds} on the sum of costs, or on what "of" names, if known.
    certificate : the proof as plain data, once there is one.

    Raises
    ------
    PlanError
        Robots missing, unknown, or given twice.
    """

    scene: Scene
    trajectories: tuple[Trajectory, ...]
    planner: Mapping[str, object] = field(default_factory=dict)
    claims: Mapping[str, object] = field(default_factory=dict)
    lower_bound: Mapping[str, object] | None = None
    certificate: Mapping[str, object] | None = None

    def __post_init__(self) -> None:
        object.__setattr__(self, "trajectories", _in_scene_order(self.scene.robots, self.trajectories))

    @property
    def costs(self) -> FloatArray:
        """Arrival minus start time per robot (0 for a robot already at its goal), (n,) seconds."""
        pairs = zip(self.trajectories, self.scene.robots, strict=True)
        return np.array([max(0.0, t.arrival - r.start_time) for t, r in pairs], dtype=np.float64)

    @property
    def sum_of_costs(self) -> float:
        """Sum of arrival − start time over the robots, seconds."""
        return float(self.costs.sum())

    @property
    def makespan(self) -> float:
        """Last arrival, seconds; 0 for an empty team."""
        return max((t.arrival for t in self.trajectories), default=0.0)

    @property
    def length(self) -> float:
        """Sum of the path lengths, metres."""
        return float(sum(t.length for t in self.trajectories))

    def at(self, time: float) -> FloatArray:
        """Positions of all robots at one time, (n, 2) metres, also of those that have left."""
        return np.array([t.at(time) for t in self.trajectories], dtype=np.float64).reshape(-1, 2)


def _in_scene_order(robots: Sequence[Robot], trajectories: Sequence[Trajectory]) -> tuple[Trajectory, ...]:
    by_name: dict[str, Trajectory] = {}
    for trajectory in trajectories:
        if trajectory.name in by_name:
            raise PlanError(f"robot {trajectory.name} has two trajectories")
        by_name[trajectory.name] = trajectory
    names = {robot.name for robot in robots}
    for name in by_name:
        if name not in names:
            raise PlanError(f"robot {name} is not in the scene")
    for robot in robots:
        if robot.name not in by_name:
            raise PlanError(f"robot {robot.name} has no trajectory")
    return tuple(by_name[robot.name] for robot in robots)
