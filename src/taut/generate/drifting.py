"""A team that drifts along a way without ever losing contact: synchronous steps, each robot's accepted or refused."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import TypeAlias

import numpy as np
import shapely
from numpy.typing import NDArray
from scipy.sparse import csr_array
from scipy.sparse.csgraph import dijkstra

from taut.freespace import FreeSpace
from taut.route import direct_lengths, direct_paths
from taut.scene import FloatArray

Links: TypeAlias = NDArray[np.bool_]

_TURNS = (0.4, -0.4, 0.8, -0.8, 1.3, -1.3)  # radians off the way that a robot tries when it is blocked
_YIELDING = 0.3  # share of blocked robots that step anywhere: else they jam in doors
_HELD, _GATHERING, _STALLS = 12, 12, 12  # steps in which the head may wait, steps of gathering then, and how often
_SETTLED = 10  # steps without getting nearer to the slots after which everyone is said to have arrived


@dataclass(frozen=True, eq=False)
class Drift:
    """What moves where.

    Parameters
    ----------
    free : where centres may be; of the widest robot.
    sight : where the lines between two centres in contact have to lie; None where they may lie anywhere.
    apart : kept between two centres, metres, (n, n).
    strides : how far each robot comes in one step, metres, (n,).
    reach : greatest distance of two robots in contact, metres.
    digits : decimals of all places.
    """

    free: FreeSpace
    sight: shapely.Geometry | None
    apart: FloatArray
    strides: FloatArray
    reach: float
    digits: int


@dataclass(frozen=True, eq=False)
class Slots:
    """Where each robot belongs as the head of the team advances along its way.

    Parameters
    ----------
    way : corners of a polyline, (k, 2) metres.
    lags : metres behind the head, measured along the way, (n,).
    offsets : metres beside that, where there is room, (n, 2).
    """

    way: FloatArray
    lags: FloatArray
    offsets: FloatArray

    @property
    def length(self) -> float:
        """Metres from the beginning of the way to its end."""
        return float(np.hypot(*np.diff(self.way, axis=0).T).sum())

    def on_way(self, head: float) -> FloatArray:
        """Places of the slots on the way itself, (n, 2), when the head has come this far."""
        along = np.append(0.0, np.cumsum(np.hypot(*np.diff(self.way, axis=0).T)))
        at = np.clip(head - self.lags, 0.0, along[-1])
        return np.stack([np.interp(at, along, self.way[:, k]) for k in (0, 1)], axis=1)


def gathered(rng: np.random.Generator, drift: Drift, middle: FloatArray, spacing: float) -> FloatArray | None:
    """Throw a team in contact about a place, (n, 2); None if it does not fit there.

    Parameters
    ----------
    spacing : metres between neighbours that the throws aim at.
    """
    n = len(drift.strides)
    places = np.repeat(middle[None], n, axis=0)
    spread = 0.6 * spacing * np.sqrt(n)
    placed = 1
    for _ in range(400):
        if placed == n:
            return places
        angle, far = rng.uniform(0, 2 * np.pi, 50), spread * np.sqrt(rng.random(50))
        thrown = np.round(middle + far[:, None] * np.stack([np.cos(angle), np.sin(angle)], axis=1), drift.digits)
        for place in thrown[shapely.contains_xy(drift.free.region, thrown[:, 0], thrown[:, 1])]:
            if placed == n:
                break
            others = places[:placed]
            distance = np.hypot(*(others - place).T)
            if (distance < 1.1 * drift.apart[placed, :placed]).any():
                continue
            if in_contact(drift, place, place, others, others).any():
                places[placed] = place
                placed += 1
        spread *= 1.03
    return None


def drifted(rng: np.random.Generator, drift: Drift, slots: Slots, starts: FloatArray) -> FloatArray | None:
    """Move a team along its way, (T, n, 2) places after each step, the starts first; None if it gets stuck.

    At every instant of every step all centres lie in the free space and apart from each other, and the links that hold
    throughout the step connect the team: distance is convex in time, so a link within reach at both ends of a step is
    one, and with sight it counts only if the hull of its four ends is clear.
    """
    course, length = _Course(), slots.length
    frames, moved = [starts], np.zeros_like(starts)
    for _ in range(100 + int(8 * length / _pace(drift))):
        places = frames[-1]
        gathers = course.gathering > 0
        targets = _next_in_line(drift, places, course.foremost) if gathers else _targets(drift, slots, course.head)
        routes = direct_paths(drift.free, places, targets)
        remaining = np.array([route.length for route in routes])
        course = _advanced(rng, drift, course, length, remaining)
        if course.settled == _SETTLED:
            return np.array(frames[:-_SETTLED])
        if course.stalls > _STALLS:
            return None
        nearest_first = np.argsort(remaining + rng.normal(0.0, drift.reach / 4, len(places)))
        after = _stepped(rng, drift, places, [route.points for route in routes], moved, nearest_first)
        moved = after - places
        frames.append(after)
        if course.head < 0.8 * length and rng.random() < 0.05:
            slots = _swapped(rng, slots)
    return None


def in_contact(drift: Drift, place: FloatArray, after: FloatArray, places: FloatArray, afters: FloatArray) -> Links:
    """Tell with which of (k, 2) others a robot keeps contact throughout a step, (k,): both move straight."""
    reach = drift.reach - 10.0**-drift.digits
    links = np.hypot(*(places - place).T) <= reach
    links &= np.hypot(*(afters - after).T) <= reach
    near = np.flatnonzero(links)
    if drift.sight is not None and len(near):
        own = np.broadcast_to(np.stack([place, after]), (len(near), 2, 2))
        ends = np.concatenate([own, places[near, None], afters[near, None]], axis=1)
        links[near] = shapely.covers(drift.sight, shapely.convex_hull(shapely.multipoints(ends)))
    return np.asarray(links)


# --- Where the team as a whole is bound -------------------------------------------------------------------------------


@dataclass(frozen=True)
class _Course:
    """How far the team has come.

    Parameters
    ----------
    head : metres of the way.
    held : steps in a row in which the head has waited for the team.
    stalls : how often it has waited too long.
    gathering : steps that the robots will still go towards the foremost.
    foremost : who that is.
    nearest : least sum of all distances from their slots, metres, since the head arrived.
    settled : steps since that has fallen.
    """

    head: float = 0.0
    held: int = 0
    stalls: int = 0
    gathering: int = 0
    foremost: int = 0
    nearest: float = math.inf
    settled: int = 0


def _advanced(rng: np.random.Generator, drift: Drift, course: _Course, length: float, remaining: FloatArray) -> _Course:
    """Let the head go on if most of the team is near its slots; see to it that a team held up for long gets free."""
    if course.gathering:
        return replace(course, gathering=course.gathering - 1)
    if course.head == length:
        if remaining.sum() < 0.99 * course.nearest:
            return replace(course, nearest=float(remaining.sum()), settled=0)
        return replace(course, settled=course.settled + 1)
    crowd = 0.5 * math.sqrt(len(remaining)) * float(drift.apart.max())
    if np.median(remaining) < max(2 * float(drift.strides.max()), 0.5 * drift.reach, crowd):
        return replace(course, head=min(length, course.head + _pace(drift)), held=0)
    if course.held + 1 < _HELD:
        return replace(course, held=course.held + 1)
    stalled = replace(course, held=0, stalls=course.stalls + 1)
    if course.stalls == _STALLS or rng.random() < 0.3:
        return replace(stalled, head=min(length, course.head + drift.reach))
    # it may be wound round an obstacle: then all have to come after the foremost before they go their own ways again
    return replace(stalled, gathering=_GATHERING, foremost=int(np.argmin(remaining)))


def _pace(drift: Drift) -> float:
    """Metres that the head advances in a step."""
    return 0.9 * float(drift.strides.mean())


def _targets(drift: Drift, slots: Slots, head: float) -> FloatArray:
    """Places of the slots, (n, 2): beside the way where a straight line leads there, else as near to it as needed."""
    on_way = slots.on_way(head)
    out = on_way.copy()
    missing = np.ones(len(out), dtype=bool)
    for share in (1.0, 0.5, 0.25):
        beside = on_way + share * slots.offsets
        fits = missing & shapely.covers(drift.free.region, shapely.linestrings(np.stack([on_way, beside], axis=1)))
        out[fits] = beside[fits]
        missing &= ~fits
    return out


def _next_in_line(drift: Drift, places: FloatArray, foremost: int) -> FloatArray:
    """Places of those whom each robot follows to come to the foremost one along links, (n, 2)."""
    links = np.triu([in_contact(drift, p, p, places, places) for p in places], 1)
    a, b = np.nonzero(links)
    walks, _ = direct_lengths(drift.free, places[a], places[b])
    graph = csr_array((walks, (a, b)), shape=(len(places), len(places)))
    _, before = dijkstra(graph, directed=False, indices=[foremost], return_predecessors=True)
    return places[np.where(before[0] < 0, foremost, before[0])]


# --- One step ---------------------------------------------------------------------------------------------------------


def _stepped(
    rng: np.random.Generator,
    drift: Drift,
    places: FloatArray,
    ways: Sequence[FloatArray],
    moved: FloatArray,
    order: NDArray[np.intp],
) -> FloatArray:
    """Move each robot in turn by the first of its choices that is allowed; who is not yet due counts as resting."""
    after = places.copy()
    links = np.array([in_contact(drift, p, p, places, places) for p in places])
    for i in order.tolist():
        choices = _choices(rng, drift, ways[i], moved[i], float(drift.strides[i]))
        choices = choices[_allowed(drift, i, choices, places, after)]
        for choice in choices:
            row = in_contact(drift, places[i], choice, places, after)
            row[i] = True
            if (row >= links[i]).all() or _connected(_with_row(links, i, row)):
                links, after[i] = _with_row(links, i, row), choice
                break
    return after


def _choices(rng: np.random.Generator, drift: Drift, way: FloatArray, moved: FloatArray, stride: float) -> FloatArray:
    """Where a robot tries to go in this step, the best first, (k, 2); resting is not among them.

    It goes on as before, or nearly as its way leads, or along it; else half as far, to one side, or anywhere.
    """
    unit = 10.0**-drift.digits
    usual = stride - 2 * unit  # less than a stride also after rounding
    along = np.append(0.0, np.cumsum(np.hypot(*np.diff(way, axis=0).T)))
    if along[-1] < unit or rng.random() < 0.03:
        return np.empty((0, 2))
    ahead = np.array([np.interp(usual, along, way[:, k]) for k in (0, 1)]) - way[0]
    length = float(np.hypot(*ahead))
    steps = [ahead, min(1.0, usual / along[1]) * (way[1] - way[0]), 0.5 * ahead]
    if along[-1] > stride:
        last = float(np.hypot(*moved))
        noisy = _turned(usual / length * ahead, rng.normal(0.0, 0.15))
        steps = [*([moved] if 0 < 0.96 * last * length < float(moved @ ahead) else []), noisy, *steps]
        side = 1.0 if rng.random() < 0.5 else -1.0
        steps += [_turned(usual / length * ahead, side * turn) for turn in _TURNS]
        if rng.random() < _YIELDING:
            steps.append(_turned(0.5 * ahead, rng.uniform(0.0, 2 * np.pi)))
    return np.asarray(np.round(way[0] + np.array(steps), drift.digits))


def _allowed(drift: Drift, i: int, choices: FloatArray, places: FloatArray, after: FloatArray) -> NDArray[np.bool_]:
    """Tell which choices of robot i stay in the free space and apart from all others, (k,)."""
    lines = shapely.linestrings(np.stack([np.broadcast_to(places[i], choices.shape), choices], axis=1))
    fits = np.asarray(shapely.covers(drift.free.region, lines))
    between = places[i] - places
    change = (choices - places[i])[:, None] - (after - places)
    square = np.maximum((change**2).sum(axis=2), 1e-300)
    nearest = np.clip(-(change * between).sum(axis=2) / square, 0.0, 1.0)
    gap = np.hypot(*np.moveaxis(between + nearest[:, :, None] * change, 2, 0)) - drift.apart[i]
    gap[:, i] = np.inf
    return np.asarray(fits & (gap >= 10.0**-drift.digits).all(axis=1))


def _with_row(links: Links, i: int, row: Links) -> Links:
    out = links.copy()
    out[i], out[:, i] = row, row
    return out


def _connected(links: Links) -> bool:
    reached = links[0]
    while True:
        wider = links[reached].any(axis=0)
        if wider.sum() == reached.sum():
            return bool(wider.all())
        reached = wider


def _swapped(rng: np.random.Generator, slots: Slots) -> Slots:
    """Exchange the slots of two robots."""
    order = np.arange(len(slots.lags))
    pair = rng.integers(len(order), size=2)
    order[pair] = order[pair[::-1]]
    return Slots(slots.way, slots.lags[order], slots.offsets[order])


def _turned(vector: FloatArray, angle: float) -> FloatArray:
    c, s = np.cos(angle), np.sin(angle)
    return np.array([c * vector[0] - s * vector[1], s * vector[0] + c * vector[1]])
