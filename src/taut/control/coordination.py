"""Coordination: robots that are late slow those that must pass after them, so that nobody meets and nobody deadlocks.

A robot's *progress* is the plan time up to which it has come along its own motion. The plan keeps robots apart when all
have the same progress. Where two motions come too near at different progress, one passes first in the plan, and it
shall pass first whatever the delays: the other's progress is bounded by how far the first has come. Each bound is
found in closed form for a leg of the one and a leg of the other, so a robot follows another closely through a
passage instead of waiting until it is empty.

O'Donnell and Lozano-Pérez, "Deadlock-free and collision-free coordination of two robot manipulators", ICRA 1989.
Gregoire, Bonnabel and de La Fortelle, "Priority-based coordination of robots", 2014. Hönig, Kiesel, Tinka, Durham and
Ayanian, "Persistent and robust execution of MAPF schedules in warehouses", IEEE Robotics and Automation Letters 4,
2019.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from taut.certificate._kernels import least_separations
from taut.certificate.tracks import Tracks, tracks_of
from taut.control import _coordination_kernels
from taut.control._coordination_kernels import Pending, Waits
from taut.errors import PlanError
from taut.motion import Plan
from taut.scene import FloatArray

IntArray = NDArray[np.int64]


@dataclass(frozen=True, eq=False)
class Dependencies:
    """Who waits for whom, and where, whenever the plan is late; see `dependencies`.

    Parameters
    ----------
    names : of the robots, in the scene's order.
    arrivals : (n,) plan times at which they arrive, seconds.
    waits : the same for kernels: `taut.control._coordination_kernels.bounds` finds all bounds at once.
    """

    names: tuple[str, ...]
    arrivals: FloatArray
    waits: Waits

    @property
    def pairs(self) -> list[tuple[str, str]]:
        """Who may have to wait, and for whom; each pair once, in the scene's order."""
        found = np.unique(np.stack([_waiting(self.waits), self.waits.holder], axis=1), axis=0)
        return [(self.names[i], self.names[j]) for i, j in found.tolist()]


def dependencies(plan: Plan, margin: float = 0.0) -> Dependencies:
    """Find who has to wait for whom when robots are late, so that the team keeps the order of the plan.

    Parameters
    ----------
    plan : robots must keep their distance in it, gap and margin included.
    margin : metres kept between robots beyond the gap. A negative one gives up some of the gap, so that robots which
        the plan brings as near as it may can be late by different times.

    Raises
    ------
    PlanError
        Two robots come nearer in the plan itself.
    ValueError
        A margin that is not finite, or gives up more than the gap.

    Notes
    -----
    Let C be the pairs (s, t) of progress at which robots i and j are too near. The plan is the diagonal s = t, which
    does not meet C. In the part with t > s robot i passes first: j's progress is bounded by
    ``f(s) = inf {t' : (s', t') ∈ C, t' > s' ≥ s}``, s being i's progress; in the part with s > t i's by j's. Then

    - no two robots come nearer than the distance, however late each of them is;
    - f(s) ≥ s, and if the plan keeps more than the distance, by ε, then f(s) ≥ s + ε / v, v the top speed of j: who has
      come least far is held by nobody, so there is no deadlock, and a team whose delays end arrives;
    - who stops for good stops those alone that must pass after it, see `stopped_by`.

    Where the plan lets robots touch, ε is half of tol, and who is told every δ seconds how far the others are may
    lose up to δ for each robot before it in a touching train. Only where three or more graze each other in a ring, all
    at one instant, is ε all by which they may differ, and they nearly stop. Such a team needs a gap larger by what a
    robot drives in a step or two, that is given up again in ``margin``.

    The distance is r_i + r_j + gap + margin − tol, to rounding. Headway plays no part: it is kept between planned
    times. Time O(m log m + p), m the number of legs and p that of pairs of legs that overlap in x; C of two legs is an
    ellipse or a strip cut with a rectangle.

    >>> from taut import Robot, Scene, Trajectory
    >>> scene = Scene((0, 0, 9, 9), robots=[Robot("A", (1, 5), (8, 5), 0.5), Robot("B", (5, 1), (5, 8), 0.5)])
    >>> late = Trajectory("B", [[0, 5, 1], [3, 5, 1], [10, 5, 8]])
    >>> dependencies(Plan(scene, (Trajectory("A", [[0, 1, 5], [7, 8, 5]]), late))).pairs
    [('B', 'A')]
    """
    scene = plan.scene
    if not np.isfinite(margin):
        raise ValueError(f"the margin must be a finite number of metres, got {margin:g}")
    if margin < -scene.gap:
        raise ValueError(f"a margin of {margin:g} m gives up more than the gap of {scene.gap:g} m")
    tracks = tracks_of(plan)
    radius = np.array([robot.radius for robot in scene.robots])
    names = tuple(robot.name for robot in scene.robots)
    _check_distances(names, tracks, radius, scene.gap + margin, scene.tol)
    waits = _waits(tracks, radius + (scene.gap + margin - scene.tol) / 2)
    return Dependencies(names, np.append(tracks.t, 0.0)[tracks.first[1:] - 1], waits)


def pending(dependencies: Dependencies) -> Pending:
    """Return all waits, none of them over, for a team at the beginning of its plan."""
    start = dependencies.waits.start
    following = np.arange(1, start[-1] + 1)
    following[start[1:][np.diff(start) > 0] - 1] = -1
    return Pending(np.where(np.diff(start) > 0, start[:-1], -1), following)


def allowed(dependencies: Dependencies, progress: ArrayLike) -> tuple[FloatArray, IntArray]:
    """Find how far each robot may go on, and whom it waits for there.

    Parameters
    ----------
    progress : (n,) plan time that each robot has reached, seconds.

    Returns
    -------
    bounds, held_by : (n,) plan times, seconds, and robots; inf and −1 where there is nobody to wait for.

    Raises
    ------
    ValueError
        Not one number for each robot.

    Notes
    -----
    Each robot may move up to its bound whatever the others do meanwhile, as long as they keep to theirs. For many
    steps of one team the kernel `bounds` is faster, which forgets waits that are over.
    """
    n = len(dependencies.names)
    at = np.array(progress, dtype=np.float64)
    if at.shape != (n,) or np.isnan(at).any():
        raise ValueError(f"progress must be {n} numbers, one for each robot")
    out, held_by = np.empty(n), np.empty(n, dtype=np.int64)
    _coordination_kernels.bounds(dependencies.waits, pending(dependencies), at, out, held_by)
    return out, held_by


def stopped_by(dependencies: Dependencies, dead: Mapping[str, float]) -> dict[str, float]:
    """Find who never arrives because of robots that stopped for good, and where they come to stand.

    Parameters
    ----------
    dead : by name, plan time at which each of them stands, seconds.

    Returns
    -------
    The others that do not arrive, in the scene's order, and the plan time that each cannot pass, seconds: it waits for
    a dead robot, or for one that waits. All stand clear of each other there; the rest of the team arrives.

    Raises
    ------
    ValueError
        A name that no robot has, or a plan time that is not a number ≥ 0.
    """
    waits = dependencies.waits
    limit = dependencies.arrivals.copy()
    for name, progress in dead.items():
        if name not in dependencies.names:
            raise ValueError(f"the team has no robot {name}")
        if not progress >= 0:
            raise ValueError(f"robot {name} must stand at a plan time ≥ 0, got {progress}")
        limit[dependencies.names.index(name)] = progress
    n = len(limit)
    by_holder = np.argsort(waits.holder, kind="stable")
    held_start = np.searchsorted(waits.holder[by_holder], np.arange(n + 1))
    _coordination_kernels.final_progress(
        waits, _waiting(waits), by_holder, held_start, limit, np.zeros(n, dtype=np.int64)
    )
    late = np.flatnonzero(limit < dependencies.arrivals)
    return {dependencies.names[i]: float(limit[i]) for i in late if dependencies.names[i] not in dead}


def _check_distances(names: tuple[str, ...], tracks: Tracks, radius: FloatArray, gap: float, tol: float) -> None:
    if len(names) < 2:
        return
    pairs, rows = least_separations(
        tracks.t, tracks.x, tracks.y, tracks.vx, tracks.vy, tracks.first, tracks.stays, tracks.present,
        tracks.boxes, radius, gap, 0.0, tol,
    )  # fmt: skip
    if len(pairs) > 1:
        worst = 1 + int(np.argmin(rows[1:, 0]))
        one, other = (names[i] for i in pairs[worst])
        free, when = rows[worst, :2]
        raise PlanError(
            f"the plan lets {one} and {other} come within {free:.6g} m of each other at t = {when:.6g} s, "
            f"{gap:.6g} m are to be kept; plan with a larger gap"
        )


def _waits(tracks: Tracks, room: FloatArray) -> Waits:
    n, stamps = len(room), tracks.t.size
    robot = np.repeat(np.arange(n), np.diff(tracks.first))
    legs = np.setdiff1d(np.arange(stamps), tracks.first[1:] - 1)
    lowest = np.minimum(tracks.x[legs], tracks.x[legs + 1]) - room[robot[legs]] if n else np.empty(0)
    legs = legs[np.argsort(lowest, kind="stable")]
    who, when = _coordination_kernels.found_waits(tracks.t, tracks.x, tracks.y, legs, robot, room)

    order = np.lexsort((when[:, 0], who[:, 1], who[:, 0]))
    who, when = who[order], when[order]
    pair = who[:, 0] * n + who[:, 1]
    kept = _coordination_kernels.needed_waits(pair, when[:, 1].copy(), when[:, 2].copy()) == 1
    who, when = who[kept], when[kept]
    order = np.lexsort((who[:, 1], when[:, 0], who[:, 0]))
    waiting, holder, leg, own = (np.ascontiguousarray(column) for column in who[order].T)
    since, until, over, apart = (np.ascontiguousarray(column) for column in when[order].T)
    start = np.searchsorted(waiting, np.arange(n + 1))
    return Waits(tracks.t, tracks.x, tracks.y, tracks.first, start, holder, leg, own, since, until, over, apart)


def _waiting(waits: Waits) -> IntArray:
    return np.repeat(np.arange(waits.start.size - 1), np.diff(waits.start))
