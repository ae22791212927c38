"""A slow and obvious reference for the safe-interval search, and for what reservations forbid.

Forbidden departures are bisected, pair by pair, from the exact least distance (see naive_conflicts); nothing is looked
up in a grid or in a queue. The earliest arrivals are a fixed point: every edge out of every free stretch of every
vertex is tried again and again until nothing gets better.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from itertools import pairwise
from math import inf, isinf, nextafter

from naive_conflicts import Meeting, closest, nearest_departure
from taut.motion import Trajectory
from taut.scene import Point

Stretch = tuple[float, float]

_JOIN = 1e-9  # seconds: forbidden stretches nearer to each other than this are one


@dataclass(frozen=True)
class Leg:
    """A reserved leg and the distance that the asking robot keeps from it."""

    x0: float
    y0: float
    t0: float
    x1: float
    y1: float
    t1: float
    d: float


def legs_of(trajectory: Trajectory, stays: bool, d: float) -> list[Leg]:
    """Return the legs for as long as the robot is present."""
    rows = trajectory.stamps.tolist()
    out = [
        Leg(x0, y0, t0, x1, y1, t1, d)
        for (t0, x0, y0), (t1, x1, y1) in pairwise(rows)
        if stays or t0 < trajectory.arrival
    ]
    t, x, y = rows[-1]
    return [*out, Leg(x, y, t, x, y, inf, d)] if stays else out


def forbidden_departures(a: Point, b: Point, tau: float, legs: Iterable[Leg], headway: float) -> list[Stretch]:
    """Return the departures from a, for an even move to b in tau seconds, that conflict with a leg; joined, sorted."""
    found = [_bisected(Meeting(*a, *b, tau, g.x0, g.y0, g.t0, g.x1, g.y1, g.t1, g.d)) for g in legs]
    return joined([(lo - headway, hi + headway) for lo, hi in filter(None, found)])


def joined(stretches: Iterable[Stretch]) -> list[Stretch]:
    """Return the union of open intervals, sorted."""
    out: list[Stretch] = []
    for lo, hi in sorted(stretches):
        if out and lo < out[-1][1] + _JOIN:
            out[-1] = out[-1][0], max(out[-1][1], hi)
        else:
            out.append((lo, hi))
    return out


def earliest_arrival(
    positions: Sequence[Point],
    arcs: Iterable[tuple[int, int, float]],
    legs: Sequence[Leg],
    headway: float,
    leave_after: float,
    stays: bool,
    start: int,
    goal: int,
) -> float:
    """Return the earliest arrival at the goal, seconds; inf if there is none. Arcs are (from, to, seconds)."""
    free = [_free(forbidden_departures(p, p, 0.0, legs, headway)) for p in positions]
    reach = [[inf] * len(stretches) for stretches in free]
    for k, (lo, hi) in enumerate(free[start]):
        if lo == 0.0 and hi >= leave_after:
            reach[start][k] = leave_after
    moves = [(u, v, tau, forbidden_departures(positions[u], positions[v], tau, legs, headway)) for u, v, tau in arcs]
    better = True
    while better:
        better = False
        for u, v, tau, forbidden in moves:
            for k, ready in enumerate(reach[u]):
                for m, (lo, hi) in enumerate(free[v]):
                    departure = max(ready, lo - tau)
                    for begin, end in forbidden:
                        if begin < departure < end:
                            departure = end
                    if departure <= min(free[u][k][1], hi - tau) and departure + tau < reach[v][m]:
                        reach[v][m] = departure + tau
                        better = True
    at_goal = zip(reach[goal], free[goal], strict=True)
    return min((t for t, (_, hi) in at_goal if not stays or isinf(hi)), default=inf)


def nearest(a: Point, b: Point, departure: float, tau: float, leg: Leg, headway: float, shifts: int = 9) -> float:
    """Return by how much a move comes nearer to a leg than allowed, metres; below 0 if it keeps off."""
    worst = -inf
    for n in range(shifts if headway else 1):
        shift = headway * (2 * n / (shifts - 1) - 1) if headway else 0.0
        m = Meeting(*a, *b, tau, leg.x0, leg.y0, leg.t0, leg.x1, leg.y1, leg.t1, leg.d)
        square = closest(m, departure - shift - leg.t0, float)
        if square is not None:
            worst = max(worst, leg.d - square**0.5)
    return worst


def _free(forbidden: list[Stretch]) -> list[Stretch]:
    out, since = [], 0.0
    for lo, hi in forbidden:
        if lo >= since:
            out.append((since, lo))
        since = max(since, hi)
    return out if isinf(since) else [*out, (since, inf)]


def _bisected(m: Meeting) -> Stretch | None:
    best = min(max(float(nearest_departure(m)), -m.tau), inf if isinf(m.t1) else m.t1 - m.t0)

    def conflict(delta: float) -> bool:
        square = closest(m, delta, float)
        return square is not None and square < m.d * m.d

    if not conflict(best):
        return None
    ends = []
    for outer in (-m.tau, inf if isinf(m.t1) else m.t1 - m.t0):
        if isinf(outer):
            ends.append(inf)  # who rests for ever stays in the way
            continue
        inside, outside = best, outer
        if conflict(nextafter(outer, best)):
            inside = outer
        while inside != outer and abs(inside - outside) > 1e-12 * (1 + abs(outer)):
            middle = (inside + outside) / 2
            inside, outside = (middle, outside) if conflict(middle) else (inside, middle)
        ends.append(inside)
    return (m.t0 + ends[0], m.t0 + ends[1]) if ends[0] < ends[1] else None
