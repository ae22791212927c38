"""Where a formation goes and how large it is on the way: dynamic programming over places near the leader's route.

The formation at one scale is one rigid body that does not turn, so its shortest ways are found exactly in the plane,
see `space_at`. Scales are some levels between 1 and where robots would touch. Stations on a shortest way of the
leader, moved to the nearest place where the whole formation fits at each level, are the nodes; between them the team
moves at one level, changes the level, or leaves the formation and goes on in a column.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from itertools import pairwise
from typing import Literal

import numpy as np
import shapely

from taut.formation.shape import BoolArray, Shape, free_moves, space_at
from taut.freespace import FreeSpace
from taut.graph import Graph, dijkstra, path_to
from taut.route.direct import direct_lengths, direct_paths
from taut.scene import FloatArray

_LEVELS = 6
_SAME = 0.99  # formations that can be scaled no farther are not
_FEWEST, _MOST = 8, 40  # stations
_FINE = 4  # middles of columns between two stations
_WINDOW = 24  # how many states ahead a way is cut short
_STATES = 160  # states between which it is


@dataclass(frozen=True)
class Node:
    """A station (number) and a level."""

    station: int
    level: int


@dataclass(frozen=True)
class Step:
    """From one node to the next: in a column, or in formation."""

    begin: Node
    end: Node
    column: bool


@dataclass(frozen=True, eq=False)
class Ground:
    """Stations along one way of the leader, and what the team may do between them.

    Parameters
    ----------
    along : (k,) metres from the begin of the way to each station.
    middles : (q, 2) metres, places on the way at which there is room for every robot alone.
    middles_along : (q,) metres to each of them, ascending.
    scales : (l,) from 1 downwards.
    spaces : (l,) where the leader may be at each scale.
    places : (k, l, 2) metres, where the leader is at a node.
    fits : (k, l) whether the node exists.
    moving : (l, k, k) seconds of a move at one level, weighed; inf where there is none.
    changing : (k, l − 1) seconds of a change to the next level, weighed; inf where there is none.
    column : (k, l, k, l) seconds of leaving the formation between two nodes, weighed, guessed; inf where there is none.
    """

    along: FloatArray
    middles: FloatArray
    middles_along: FloatArray
    scales: FloatArray
    spaces: tuple[FreeSpace, ...]
    places: FloatArray
    fits: BoolArray
    moving: FloatArray
    changing: FloatArray
    column: FloatArray

    def state(self, node: Node) -> FloatArray:
        """Leader's place and scale, (3,)."""
        return np.append(self.places[node.station, node.level], self.scales[node.level])

    def middles_of(self, step: Step) -> FloatArray:
        """Those of the middles that lie between the stations of a step."""
        first, last = self.along[[step.begin.station, step.end.station]]
        return np.asarray(self.middles[(self.middles_along >= first) & (self.middles_along <= last)])


def grounds(shape: Shape, keep: float) -> Iterator[Ground]:
    """Yield the grounds along ways worth looking at: the shortest at each level, of the largest disc, of the leader.

    If in full size the formation has as short a way as the leader alone, there is only the ground along that.
    """
    leader = shape.scene.robots[shape.leader]
    ends = np.array([leader.start, leader.goal])
    full = space_at(shape, 1.0)
    least = shape.least_scale
    lengths = [_length(space, ends) for space in (full, shape.spaces[shape.leader])]
    scales = np.ones(1) if least > _SAME or lengths[0] <= lengths[1] else np.linspace(1.0, least, _LEVELS)
    spaces = (full, *(space_at(shape, float(scale)) for scale in scales[1:]))
    ways: list[FloatArray] = []
    for space in (*spaces, _largest(shape), shape.spaces[shape.leader]):
        if _length(space, ends) == math.inf:
            continue
        way = direct_paths(space, *ends)[0].points
        if not any(_alike(way, other, shape.spacing) for other in ways):
            ways.append(way)
    for way in ways:
        yield _ground(shape, way, scales, spaces, keep)


def best_way(ground: Ground) -> tuple[float, list[Step]]:
    """Return the least weighed seconds from start to goal, both in full size, and the steps of the way; inf without."""
    k, levels = ground.fits.shape
    best = np.full((k, levels), math.inf)
    before = np.full((k, levels), -1, dtype=np.int64)
    left = np.zeros((k, levels), dtype=np.bool_)
    best[0, 0] = 0.0
    for s in range(k):
        for level in np.flatnonzero(ground.fits[s]) if s else ():
            kept = best[:s, level] + ground.moving[level, :s, s]
            apart = best[:s] + ground.column[:s, :, s, level]
            i, j = int(np.argmin(kept)), int(np.argmin(apart))
            left[s, level] = apart.flat[j] < kept[i]
            best[s, level], before[s, level] = (apart.flat[j], j) if left[s, level] else (kept[i], i * levels + level)
        for a, b in [(i, i + 1) for i in range(levels - 1)] + [(i, i - 1) for i in range(levels - 1, 0, -1)]:
            changed = best[s, a] + ground.changing[s, min(a, b)]
            if changed < best[s, b]:
                best[s, b], before[s, b], left[s, b] = changed, s * levels + a, False
    if not math.isfinite(best[-1, 0]):
        return math.inf, []
    path = [(k - 1) * levels]
    while path[-1]:
        path.append(int(before.flat[path[-1]]))
    nodes = [Node(*divmod(i, levels)) for i in reversed(path)]
    return float(best[-1, 0]), [Step(a, b, bool(left[b.station, b.level])) for a, b in pairwise(nodes)]


def columns_alike(
    shape: Shape, ground: Ground, step: Step, end: Literal["begin", "end", "both"], within: float
) -> BoolArray:
    """Which columns (k, l, k, l) begin, end, or both, with the robots at most so many metres from where a step does."""
    begins, ends = (
        np.hypot(*np.moveaxis(ground.places - ground.places[node.station, node.level], 2, 0))
        + np.abs(ground.scales - ground.scales[node.level]) * np.hypot(*shape.offsets.T).max()
        <= within
        for node in (step.begin, step.end)
    )
    k, levels = ground.fits.shape
    out = np.ones((k, levels, k, levels), dtype=np.bool_)
    if end != "end":
        out &= begins[:, :, None, None]
    if end != "begin":
        out &= ends
    return out


def states_along(ground: Ground, steps: Sequence[Step]) -> FloatArray:
    """States (m, 3) along steps in formation, all bends included."""
    states = [ground.state(steps[0].begin)[None]]
    for step in steps:
        a, b = step.begin, step.end
        if a.station == b.station:
            states.append(ground.state(b)[None])
        else:
            ends = ground.places[a.station, a.level], ground.places[b.station, b.level]
            points = direct_paths(ground.spaces[a.level], *ends)[0].points[1:]
            states.append(np.column_stack([points, np.full(len(points), ground.scales[a.level])]))
    found = np.concatenate(states)
    return np.asarray(found[np.append(True, (np.diff(found, axis=0) != 0).any(axis=1))])


def pulled(shape: Shape, states: FloatArray, keep: float) -> FloatArray:
    """Cut a way through states (m, 3) short wherever all robots may move straight from one to a later one."""
    dense = _resampled(states, shape.spacing)
    m = len(dense)
    if m < 3:
        return states
    i, ahead = np.divmod(np.arange(m * _WINDOW), _WINDOW)
    pairs = np.stack([i, i + 1 + ahead], axis=1)
    pairs = pairs[pairs[:, 1] < m]
    legs = pairs[:, 1] == pairs[:, 0] + 1
    a, b = dense[pairs[:, 0]], dense[pairs[:, 1]]
    pairs = pairs[legs | free_moves(shape, a, b)]
    _, before = dijkstra(Graph.from_edges(m, pairs, weighed(shape, dense[pairs[:, 0]], dense[pairs[:, 1]], keep)), 0)
    return np.asarray(dense[path_to(before, m - 1)])


def weighed(shape: Shape, a: FloatArray, b: FloatArray, keep: float) -> FloatArray:
    """Seconds of straight moves between states, those out of size weighing more."""
    return np.asarray(shape.seconds(a, b) * (1.0 + keep * (1.0 - (a[:, 2] + b[:, 2]) / 2)))


def _largest(shape: Shape) -> FreeSpace:
    """The free space of the robot that needs most room."""
    return max(shape.spaces, key=lambda space: space.growth)


def _length(space: FreeSpace, ends: FloatArray) -> float:
    """Metres of a shortest way between two places; inf if there is none or they are not in the space."""
    return math.inf if (space.anchor(ends)[1] < 0).any() else float(direct_lengths(space, *ends)[0][0])


def _alike(a: FloatArray, b: FloatArray, spacing: float) -> bool:
    """Whether two ways are nowhere farther apart than robots keep from each other."""
    if len(a) < 2 or len(b) < 2:
        return len(a) == len(b)
    return bool(shapely.hausdorff_distance(shapely.LineString(a), shapely.LineString(b), densify=0.05) <= spacing)


def _ground(shape: Shape, way: FloatArray, scales: FloatArray, spaces: tuple[FreeSpace, ...], keep: float) -> Ground:
    along = _stations(way, shape.spacing)
    route = _on(way, along)
    route[[0, -1]] = way[[0, -1]]
    k, levels = len(route), len(scales)
    places = np.tile(route[:, None], (1, levels, 1))
    fits = np.zeros((k, levels), dtype=np.bool_)
    moving = np.full((levels, k, k), math.inf)
    slowest = float(shape.speeds.min())
    i, j = np.triu_indices(k, 1)
    for level, space in enumerate(spaces):
        places[:, level], fits[:, level] = _nearest(space, route)
        good = fits[i, level] & fits[j, level]
        a, b = i[good], j[good]
        lengths = direct_lengths(space, places[a, level], places[b, level])[0]
        moving[level, a, b] = lengths / slowest * (1.0 + keep * (1.0 - scales[level]))
    fits[[0, -1], 0] = True  # even where rounding leaves no room about them
    states = np.concatenate([places, np.broadcast_to(scales[:, None], (k, levels, 1))], axis=2)
    changing = np.full((k, levels - 1), math.inf)
    for level in range(levels - 1):
        both = np.flatnonzero(fits[:, level] & fits[:, level + 1])
        a, b = states[both, level], states[both, level + 1]
        free = free_moves(shape, a, b) & free_moves(shape, b, a)
        changing[both[free], level] = weighed(shape, a, b, keep)[free]
    queue = shape.needed.sum() / max(1, len(shape.offsets) - 1)
    aside = np.full((k, levels), math.inf)
    own = shape.spaces[shape.leader]
    for level in range(levels):
        both = np.flatnonzero(fits[:, level])
        aside[both, level] = direct_lengths(own, route[both], places[both, level])[0]
    far = aside[:, :, None, None] + aside + (along - along[:, None])[:, None, :, None]
    # a dense formation takes longer to leave and to enter
    dense = 1.5 - scales
    fine = np.linspace(0.0, along[-1], _FINE * (k - 1) + 1)
    middles = _on(way, fine)
    roomy = _largest(shape).anchor(middles)[1] >= 0
    before, until = (np.searchsorted(fine[roomy], along, side) for side in ("left", "right"))
    ahead = ((along > along[:, None]) & (until > before[:, None]))[:, None, :, None]
    column = np.where(ahead, (far * (1.0 + keep) + queue * (dense[:, None, None] + dense)) / slowest, math.inf)
    return Ground(along, middles[roomy], fine[roomy], scales, spaces, places, fits, moving, changing, column)


def _stations(way: FloatArray, spacing: float) -> FloatArray:
    """Metres to stations at equal distances along a way, both ends included, (k,)."""
    length = float(np.hypot(*np.diff(way, axis=0).T).sum())
    return np.linspace(0.0, length, int(np.clip(math.ceil(length / max(spacing, 1e-300)), _FEWEST, _MOST)))


def _on(way: FloatArray, along: FloatArray) -> FloatArray:
    """Places so many metres along a way, (k, 2)."""
    total = np.append(0.0, np.cumsum(np.hypot(*np.diff(way, axis=0).T)))
    return np.stack([np.interp(along, total, way[:, axis]) for axis in (0, 1)], axis=1)


def _nearest(space: FreeSpace, route: FloatArray) -> tuple[FloatArray, BoolArray]:
    """The nearest places of a space (the places themselves, or within rounding of them, where they lie in it)."""
    triangles = space.anchor(route)[1]
    outside = triangles < 0
    if space.region.is_empty or not outside.any():
        return route, ~outside
    lines = shapely.shortest_line(space.region, shapely.points(route[outside]))
    near = route.copy()
    near[outside] = shapely.get_coordinates(lines)[::2]
    return near, space.anchor(near)[1] >= 0


def _resampled(states: FloatArray, spacing: float) -> FloatArray:
    """States along straight moves between states, near enough to each other."""
    lengths = np.hypot(*np.diff(states[:, :2], axis=0).T)
    step = max(spacing / 2, float(lengths.sum()) / _STATES)
    out = [states[:1]]
    for a, b, length in zip(states, states[1:], lengths, strict=False):
        count = max(1, math.ceil(length / step)) if step > 0 else 1
        if a[2] != b[2]:
            count = max(count, 4)
        share = np.arange(1, count + 1)[:, None] / count
        out.append(np.where(share == 1, b, a + share * (b - a)))
    return np.concatenate(out)
