"""Order search: priorities between pairs of robots, added where their motions meet, until none do.

Source: Ma, Harabor, Stuckey, Li and Koenig, Searching with consistent prioritization for multi-agent path finding,
AAAI 2019; here in continuous time.
"""

from __future__ import annotations

import math
import time
from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass
from itertools import count as counted

import numpy as np

from taut.motion import Trajectory
from taut.team import _order_kernels
from taut.team.reservations import legs_of, release
from taut.team.safe_intervals import Bench, Failure, bench_of, plan_robot, take
from taut.team.world import World

_PATIENCE = 4  # nodes per robot in the first tree; each later one may have half as many again


@dataclass(frozen=True)
class Meeting:
    """Two robots, by their numbers, that come too near each other, from about ``time`` on."""

    first: int
    second: int
    time: float


@dataclass(frozen=True, eq=False)
class Searched:
    """What the search gives.

    Parameters
    ----------
    trajectories : per robot of the scene; None if no order was found.
    order : robots, those that others give way to first.
    nodes : how many were made.
    stuck : what remained to be resolved in the node that had least of it; empty if there is an order.
    """

    trajectories: tuple[Trajectory, ...] | None
    order: tuple[int, ...]
    nodes: int
    stuck: tuple[Meeting, ...]


@dataclass(frozen=True, eq=False)
class _Node:
    """Robots above each robot (those that it has to avoid, all of them), motions, and when pairs of them meet."""

    above: Mapping[int, frozenset[int]]
    motions: Mapping[int, Trajectory]
    meetings: Mapping[tuple[int, int], float]

    @property
    def merit(self) -> tuple[int, float]:
        """What is less is better."""
        return len(self.meetings), sum(motion.arrival for motion in self.motions.values())


def searched(
    world: World,
    seed: int = 0,
    nodes: int = 10_000,
    until: float = math.inf,
    progress: Callable[[int, int], None] | None = None,
) -> Searched:
    """Search for priorities under which all robots get through: depth first, the better child first.

    Where a tree takes long it is begun anew, with pairs and children in another, random order.

    Parameters
    ----------
    world : the team.
    seed : of the random orders; same seed and nodes, same result.
    nodes : how many are made at most.
    until : no node is made after this time of the monotonic clock, seconds.
    progress : called after each node with how many there are and how many pairs of robots meet in it.

    Notes
    -----
    A robot whose priority is lower avoids all above it, with their motions as they are, and no others. So a plan is
    found only if it is one for some order; not every plan is. Complexity: a search for each robot below one that
    changed, and a look at all legs for each motion, in every node.
    """
    rng = np.random.default_rng(seed)
    desk = _Desk(world)
    root = desk.root()
    best, made = root, 1
    if not root.meetings:
        return _solved(root, made)
    for attempt in counted():
        stack, patience = [root], math.ceil(_PATIENCE * len(world.scene.robots) * 1.5**attempt) + 64
        while stack and patience > 0:
            node = stack.pop()
            if made >= nodes or time.monotonic() > until:
                return Searched(None, (), made, _told(best))
            children = []
            for higher, lower in desk.split(node, rng if attempt else None):
                child = desk.child(node, higher, lower)
                made, patience = made + 1, patience - 1
                if child is None:
                    continue
                if not child.meetings:
                    return _solved(child, made)
                children.append(child)
                if len(child.meetings) < len(best.meetings):
                    best = child
                if progress is not None:
                    progress(made, len(child.meetings))
            children.sort(key=lambda one: one.merit, reverse=True)
            if attempt and rng.random() < 0.2:
                children.reverse()
            stack += children
        if not stack:
            break
    return Searched(None, (), made, _told(best))


def _solved(node: _Node, made: int) -> Searched:
    order = _ranked(node.above, node.motions)
    return Searched(tuple(node.motions[i] for i in sorted(node.motions)), tuple(order), made, ())


def _told(node: _Node) -> tuple[Meeting, ...]:
    return tuple(Meeting(i, j, when) for (i, j), when in sorted(node.meetings.items(), key=lambda entry: entry[1]))


def _ranked(above: Mapping[int, frozenset[int]], robots: Iterable[int]) -> list[int]:
    """Robots so that each stands after all above it."""
    return sorted(robots, key=lambda i: (len(above.get(i, frozenset())), i))


class _Desk:
    """Where nodes are made: a table of the motions that a search has to avoid, and one of all motions of a node."""

    def __init__(self, world: World) -> None:
        self._world = world
        self._some, self._all = bench_of(world), bench_of(world)
        self._in: dict[int, dict[int, Trajectory]] = {}

    def root(self) -> _Node:
        """Every robot on its own."""
        robots = range(len(self._world.scene.robots))
        motions: dict[int, Trajectory] = {}
        for i in robots:
            found = plan_robot(self._some, i)
            if isinstance(found, Failure):
                raise ValueError(f"robot {i} has no way on its roadmap, even alone")
            motions[i] = found
        return _Node({}, motions, self._meetings({}, motions, robots))

    def split(self, node: _Node, rng: np.random.Generator | None) -> tuple[tuple[int, int], tuple[int, int]]:
        """The pair to order next, either way: the one that meets first, or any."""
        pairs = sorted(node.meetings, key=lambda pair: (node.meetings[pair], pair))
        i, j = pairs[0 if rng is None else int(rng.integers(min(4, len(pairs))))]
        return (i, j), (j, i)

    def child(self, node: _Node, higher: int, lower: int) -> _Node | None:
        """The node in which ``lower``, and all below it, avoid ``higher`` and all above that; None if one cannot."""
        over = node.above.get(higher, frozenset()) | {higher}
        if lower in over:
            return None
        below = [i for i in node.motions if i == lower or lower in node.above.get(i, frozenset())]
        above = dict(node.above) | {i: node.above.get(i, frozenset()) | over for i in below}
        motions, meetings = dict(node.motions), dict(node.meetings)
        for i in _ranked(above, below):
            if i != lower and not any((min(i, j), max(i, j)) in meetings for j in above[i]):
                continue
            self._reserve(self._some, {j: motions[j] for j in above[i]})
            found = plan_robot(self._some, i)
            if isinstance(found, Failure):
                return None
            motions[i] = found
            meetings = self._meetings(meetings, motions, [i])
        return _Node(above, motions, meetings)

    def _meetings(
        self, known: Mapping[tuple[int, int], float], motions: Mapping[int, Trajectory], changed: Iterable[int]
    ) -> dict[tuple[int, int], float]:
        """When pairs meet, after some motions have changed."""
        scene, world = self._world.scene, self._world
        self._reserve(self._all, motions)
        out = dict(known)
        for i in changed:
            radius, gap, headway = world.body(i).tolist()
            legs = legs_of(motions[i], scene.stays(scene.robots[i]))
            # motions that touch must not meet over rounding
            apart = radius + gap - scene.tol / 8
            times = _order_kernels.meeting_times(self._all.table, i, legs, apart, headway, len(scene.robots))
            for j in range(len(scene.robots)):
                if math.isfinite(times[j]):
                    out[min(i, j), max(i, j)] = float(times[j])
                else:
                    out.pop((min(i, j), max(i, j)), None)
        return out

    def _reserve(self, bench: Bench, motions: Mapping[int, Trajectory]) -> None:
        """Make these motions, and no others, those in a table."""
        held = self._in.setdefault(id(bench), {})
        for i in [i for i in held if i not in motions]:
            release(bench.table, i)
            del held[i]
        for i, motion in motions.items():
            if held.get(i) is not motion:
                take(bench, i, motion)
                held[i] = motion
