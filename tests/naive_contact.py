"""Slow, obvious references for contact: bisection in extended precision, sampling, and graphs by NumPy and networkx."""

from __future__ import annotations

import networkx as nx
import numpy as np
import shapely
from numpy.typing import NDArray

from taut.contact import sight_sides
from taut.motion import Plan
from taut.scene import FloatArray

Ints = NDArray[np.int64]
Flags = NDArray[np.bool_]
Long = np.longdouble


class Pairs:
    """Positions of many pairs of robots, each pair at a time of its own, in extended precision.

    All trajectories must have the same number of stamps (repeat rests at will).
    """

    def __init__(self, plan: Plan, pairs: Ints) -> None:
        stamps = np.array([path.stamps for path in plan.trajectories], dtype=Long)
        self.pairs = stamps[pairs[:, 0]], stamps[pairs[:, 1]]

    def at(self, times: NDArray[np.longdouble]) -> tuple[NDArray[np.longdouble], NDArray[np.longdouble]]:
        """Positions (p, 2) of the first and the second robot of each pair at its time."""
        return _on(self.pairs[0], times), _on(self.pairs[1], times)

    def apart(self, times: NDArray[np.longdouble]) -> NDArray[np.longdouble]:
        """Distance (p,) of each pair at its time."""
        a, b = self.at(times)
        return np.asarray(np.hypot(*(a - b).T), dtype=Long)


def _on(stamps: NDArray[np.longdouble], times: NDArray[np.longdouble]) -> NDArray[np.longdouble]:
    out = stamps[:, -1, 1:].copy()
    for k in range(stamps.shape[1] - 1):
        a, b = stamps[:, k], stamps[:, k + 1]
        s = (times - a[:, 0]) / (b[:, 0] - a[:, 0])
        on = (a[:, 0] <= times) & (times < b[:, 0])
        out[on] = (a + s[:, None] * (b - a))[on, 1:]
    return out


def range_crossings(
    plan: Plan, pairs: Ints, reach: float
) -> tuple[NDArray[np.longdouble], NDArray[np.longdouble], Ints]:
    """Instants at which the distance of a pair passes ``reach``, its least distance near there, and the pair's number.

    On each piece of time in which both move steadily the distance is convex: its least value is found by ternary
    search, and to either side of it the crossing by bisection.
    """
    times = np.array([path.times for path in plan.trajectories], dtype=Long)
    borders = np.sort(np.concatenate([times[pairs[:, 0]], times[pairs[:, 1]]], axis=1), axis=1)
    found, least, who = [], [], []
    for k in range(borders.shape[1] - 1):
        own = np.flatnonzero(borders[:, k + 1] > borders[:, k])
        of = Pairs(plan, pairs[own])
        low, high = borders[own, k], borders[own, k + 1]
        ends = low, high
        for _ in range(60):
            one, two = low + (high - low) / 3, high - (high - low) / 3
            left = of.apart(one) < of.apart(two)
            high, low = np.where(left, two, high), np.where(left, low, one)
        lowest = (low + high) / 2
        nearest = of.apart(lowest)
        for edge in ends:
            crossing = (nearest <= reach) & (of.apart(edge) > reach)
            those = Pairs(plan, pairs[own[crossing]])
            inner, outer = lowest[crossing], edge[crossing]
            for _ in range(60):
                middle = (inner + outer) / 2
                within = those.apart(middle) <= reach
                inner, outer = np.where(within, middle, inner), np.where(within, outer, middle)
            found.append(inner)
            least.append(nearest[crossing])
            who.append(own[crossing])
    return np.concatenate(found), np.concatenate(least), np.concatenate(who)


def hidden(plan: Plan, pairs: Ints, times: NDArray[np.longdouble]) -> Flags:
    """Whether a side lies between the robots of each pair at its time (p,)."""
    sides = sight_sides(plan.scene, plan.scene.tol).astype(Long)
    a, b = (place[:, None] for place in Pairs(plan, pairs).at(times))
    c, d = sides[None, :, :2], sides[None, :, 2:]

    def turn(p: NDArray[np.longdouble], q: NDArray[np.longdouble], r: NDArray[np.longdouble]) -> FloatArray:
        area = (q - p)[..., 0] * (r - p)[..., 1] - (q - p)[..., 1] * (r - p)[..., 0]
        return np.asarray(np.sign(area), dtype=np.float64)

    met = (turn(a, b, c) * turn(a, b, d) <= 0) & (turn(c, d, a) * turn(c, d, b) <= 0)
    return np.asarray(met.any(axis=1))


def flips(plan: Plan, pairs: Ints, before: FloatArray, after: FloatArray) -> tuple[Flags, NDArray[np.longdouble]]:
    """Whether sight changes between two times, for each pair, and when, by bisection."""
    low, high = np.asarray(before, dtype=Long), np.asarray(after, dtype=Long)
    first = hidden(plan, pairs, low)
    changed = np.asarray(first != hidden(plan, pairs, high))
    for _ in range(25):
        middle = np.asarray((low + high) / 2, dtype=Long)
        same = hidden(plan, pairs, middle) == first
        low, high = (np.asarray(np.where(same, *ends), dtype=Long) for ends in ((middle, low), (high, middle)))
    return changed, np.asarray((low + high) / 2, dtype=Long)


def graph_at(plan: Plan, time: float, reach: float, sight: bool = False) -> nx.Graph:
    """Communication graph at one instant, of the robots that are there."""
    there = [
        k
        for k, (robot, path) in enumerate(zip(plan.scene.robots, plan.trajectories, strict=True))
        if plan.scene.stays(robot) or time < path.arrival
    ]
    place = plan.at(time)
    walls = shapely.multilinestrings([shapely.linestrings(sight_sides(plan.scene, plan.scene.tol).reshape(-1, 2, 2))])
    graph = nx.Graph()
    graph.add_nodes_from(there)
    for i in there:
        for j in there:
            if i < j and np.hypot(*(place[i] - place[j])) <= reach + plan.scene.tol:
                line = shapely.linestrings([place[i], place[j]])
                if not (sight and shapely.intersects(line, walls)[0]):
                    graph.add_edge(i, j)
    return graph


def fiedler(graph: nx.Graph, weight: str | None = None) -> float:
    """λ2 by NumPy; 0 for fewer than two vertices."""
    if len(graph) < 2:
        return 0.0
    return float(np.linalg.eigvalsh(nx.laplacian_matrix(graph, weight=weight).toarray().astype(float))[1])
