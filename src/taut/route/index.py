"""PathIndex: a free space prepared for many shortest paths, asked in batches without Python in the loop."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from numbers import Integral
from typing import Literal

import numpy as np
import shapely
from numpy.typing import ArrayLike, NDArray

from taut.chunks import over_chunks
from taut.errors import StartBlocked
from taut.freespace import FreeSpace
from taut.geometry.seeing import see_each_other
from taut.geometry.triangulation import Floats, Ints
from taut.graph import HubLabels, _kernels, hub_labels, label_distances_between, label_paths
from taut.roadmap import VisibilityGraph, visibility_graph
from taut.route.core import in_turn, points_of, require_found, require_free
from taut.route.states import Attached, TautStates, attach, picked, search, states_of, taut_states

_CHUNK = 256
_NEAR = 4.0
"""Tolerances from an obstacle within which a path is looked for again; it selects work and changes no result."""

Bools = NDArray[np.bool_]


@dataclass(frozen=True, eq=False)
class Labelled:
    """Hub labels, and what has changed since they were built.

    Parameters
    ----------
    labels : of the tangent graph as it was then.
    positions : (m, 2) metres, the corners of that graph.
    numbers : (n,) number there of each corner that there is now, −1 for those that are new or have changed.
    added, removed : obstacles as grown, by name.
    """

    labels: HubLabels
    positions: Floats
    numbers: Ints
    added: Mapping[str, shapely.Geometry]
    removed: Mapping[str, shapely.Geometry]


@dataclass(frozen=True, eq=False)
class PathIndex:
    """What `prepare` gives: everything that shortest paths in one free space have in common.

    Parameters
    ----------
    freespace : where the paths lie.
    tangents : its tangent graph.
    states : the same for A*.
    labelled : hub labels, or None.
    """

    freespace: FreeSpace
    tangents: VisibilityGraph
    states: TautStates
    labelled: Labelled | None

    @property
    def labels(self) -> HubLabels | None:
        """The hub labels, if there are any."""
        return None if self.labelled is None else self.labelled.labels


@dataclass(frozen=True, eq=False)
class Paths:
    """Many shortest paths in compressed sparse rows.

    Parameters
    ----------
    lengths : (k,) metres.
    start : (k + 1,) where each path begins in ``points``.
    points : (p, 2) metres, path after path from start to goal.
    """

    lengths: Floats
    start: Ints
    points: Floats

    def __len__(self) -> int:
        """Return the number of paths."""
        return len(self.lengths)

    def __getitem__(self, k: int) -> Floats:
        """Return the points of path k, (j, 2)."""
        if not isinstance(k, Integral):
            raise TypeError(f"paths are taken one by one, by their number; got {k!r}")
        if not -len(self) <= k < len(self):
            raise IndexError(f"path {k} of {len(self)}")
        k %= len(self)
        return self.points[self.start[k] : self.start[k + 1]]


def prepare(
    freespace: FreeSpace, index: Literal["graph", "labels"] = "graph", most_bytes: int | None = None
) -> PathIndex:
    """Prepare a free space for many shortest paths.

    Parameters
    ----------
    index : "graph": the tangent graph, searched by A*. "labels": hub labels on top, which answer in microseconds but
        take long to build and much memory; see ``labels.build_seconds`` and ``labels.bytes`` of what comes back.
    most_bytes : the most that labels may take; None for no bound.

    Raises
    ------
    ValueError
        ``index`` is none of these.
    TautError
        The labels would take more than ``most_bytes``.

    >>> from taut import FreeSpace, Scene
    >>> distances(prepare(FreeSpace(Scene((0, 0, 4, 3)))), [(0, 0)], [(3, 0)])
    array([3.])
    """
    if index not in ("graph", "labels"):
        raise ValueError(f'index must be "graph" or "labels", got {index!r}')
    tangents = visibility_graph(freespace)
    labelled = None
    if index == "labels":
        labels = hub_labels(tangents.graph, most_bytes=most_bytes)
        labelled = Labelled(labels, tangents.positions, np.arange(tangents.graph.n), {}, {})
    return PathIndex(freespace, tangents, taut_states(freespace, tangents), labelled)


def distances(index: PathIndex, a: ArrayLike, b: ArrayLike) -> Floats:
    """Lengths of shortest paths from each of (k, 2) points to the one in the same row, (k,); inf where there is none.

    Raises
    ------
    StartBlocked, GoalBlocked
        A point is not in free space.
    ValueError
        Not as many points of one kind as of the other.
    """
    return _found(index, _attached(index, a, b))[0]


def paths(index: PathIndex, a: ArrayLike, b: ArrayLike) -> Paths:
    """Shortest paths from each of (k, 2) points to the one in the same row.

    Raises
    ------
    StartBlocked, GoalBlocked
        A point is not in free space.
    NoPath
        Obstacles separate two points.
    ValueError
        Not as many points of one kind as of the other.
    """
    ends = _attached(index, a, b)
    lengths, start, path = _found(index, ends)
    require_found(index.freespace, ends.given, lengths)
    k = len(lengths)
    if k == 0:
        return Paths(lengths, np.zeros(1, dtype=np.int64), np.empty((0, 2)))
    # every path is its start, its corners, its goal: corners move back by one place for each end before them
    between = start + 2 * np.arange(k + 1)
    points = np.empty((between[-1], 2))
    points[between[:-1]] = ends.given[::2]
    points[between[1:] - 1] = ends.given[1::2]
    points[np.arange(len(path)) + 2 * np.repeat(np.arange(k), np.diff(start)) + 1] = index.tangents.positions[path]
    fresh = np.append(True, (points[1:] != points[:-1]).any(axis=1))
    fresh[between[:-1]] = True
    counts = np.add.reduceat(fresh.astype(np.int64), between[:-1])
    return Paths(lengths, np.append(0, np.cumsum(counts)), points[fresh])


def distances_from(index: PathIndex, a: ArrayLike, points: ArrayLike) -> Floats:
    """Lengths of shortest paths from one point to each of (k, 2) points, (k,); inf where there is none.

    One search over the whole graph (Dijkstra); points that are not free are infinitely far.

    Raises
    ------
    StartBlocked
        ``a`` is not in free space.
    ValueError
        ``a`` is not one point.
    """
    source, places = points_of(a, "a"), points_of(points, "points")
    if len(source) != 1:
        raise ValueError(f"a must be one point (x, y), got {len(source)}")
    ends = attach(index.freespace, index.tangents, np.concatenate([source, places]))
    if ends.triangles[0] < 0:
        raise StartBlocked(f"start ({source[0, 0]:g}, {source[0, 1]:g}) is not in free space")
    states = index.states
    _, near = states_of(ends, np.zeros(1, dtype=np.int64), 1)
    offsets = np.hypot(*(states.positions[near] - ends.given[0]).T)
    known, _ = _kernels.dijkstra(states.indptr, states.heads, states.lengths, near, offsets)
    out = np.full(len(places), np.inf)
    first, there = states_of(ends, np.arange(1, len(places) + 1), -1)
    row = np.repeat(np.arange(len(places)), np.diff(first))
    np.minimum.at(out, row, known[there] + np.hypot(*(states.positions[there] - ends.given[1 + row]).T))
    free = np.flatnonzero(ends.triangles[1:] >= 0)
    seen = free[see_each_other(index.freespace.mesh, ends.points, ends.triangles, np.zeros_like(free), free + 1)]
    out[seen] = np.hypot(*(ends.given[1 + seen] - ends.given[0]).T)
    return out


def _attached(index: PathIndex, a: ArrayLike, b: ArrayLike) -> Attached:
    ends = attach(index.freespace, index.tangents, in_turn(a, b))
    require_free(index.freespace, ends.given, ends.triangles)
    return ends


def _found(index: PathIndex, ends: Attached) -> tuple[Floats, Ints, Ints]:
    """Lengths between places 0 and 1, 2 and 3, … and the corners passed as CSR (start, corner)."""
    if index.labelled is None:
        return search(index.freespace.mesh, index.states, ends)
    lengths, start, path, sure = _by_labels(index, index.labelled, ends)
    if sure.all():
        return lengths, start, path
    others = np.flatnonzero(~sure)
    found, first, corners = search(index.freespace.mesh, index.states, picked(ends, others))
    lengths[others] = found
    counts = np.diff(start)
    row = np.concatenate([np.repeat(np.arange(len(lengths)), counts), np.repeat(others, np.diff(first))])
    kept = np.concatenate([np.repeat(sure, counts), np.ones(len(corners), dtype=np.bool_)])
    order = np.argsort(row[kept], kind="stable")
    everything = np.concatenate([path, corners])[kept][order]
    return lengths, np.append(0, np.cumsum(np.bincount(row[kept], minlength=len(lengths)))), everything


def _by_labels(index: PathIndex, labelled: Labelled, ends: Attached) -> tuple[Floats, Ints, Ints, Bools]:
    """Lengths between places 0 and 1, 2 and 3, …, the corners passed as CSR, and whether that is still right.

    A path found in the labels' map is shortest now if its ends are joined with corners of that map only, no obstacle
    added since touches it, and no path by way of an obstacle removed since could be shorter.
    """
    starts = np.arange(0, len(ends.given), 2, dtype=np.int64)
    direct = see_each_other(index.freespace.mesh, ends.points, ends.triangles, starts, starts + 1)
    lengths = np.hypot(*(ends.given[1::2] - ends.given[::2]).T)
    numbers = labelled.numbers[ends.corners]
    place = np.repeat(np.arange(len(ends.points)), np.diff(ends.first))
    strange = np.zeros(len(ends.points), dtype=np.bool_)
    strange[place[numbers < 0]] = True
    sure = direct | ~(strange[::2] | strange[1::2])
    far = starts[sure & ~direct]
    offsets = np.hypot(*(index.tangents.positions[ends.corners] - ends.given[place]).T)
    joined = labelled.positions, ends.given, ends.first, np.maximum(numbers, 0), offsets

    def chunk(first: int, last: int) -> tuple[Floats, Ints]:
        return label_distances_between(labelled.labels, *joined, far[first:last], far[first:last] + 1)

    found = over_chunks(chunk, len(far), _CHUNK)
    passed = np.full((len(starts), 2), -1, dtype=np.int64)
    if found:
        lengths[far // 2] = np.concatenate([length for length, _ in found])
        passed[far // 2] = np.concatenate([corners for _, corners in found])
    through = np.flatnonzero(passed[:, 0] >= 0)
    steps, path = label_paths(labelled.labels, passed[through, 0], passed[through, 1])
    counts = np.zeros(len(starts), dtype=np.int64)
    counts[through] = np.diff(steps)
    _doubt_what_changed(labelled, ends, _NEAR * index.freespace.scene.tol, lengths, counts, path, sure)
    current = np.full(labelled.labels.n, -1, dtype=np.int64)
    known = np.flatnonzero(labelled.numbers >= 0)
    current[labelled.numbers[known]] = known
    here = current[path]
    row = np.repeat(np.arange(len(starts)), counts)
    sure[row[here < 0]] = False
    return lengths, np.append(0, np.cumsum(counts)), here, sure


def _doubt_what_changed(
    labelled: Labelled, ends: Attached, margin: float, lengths: Floats, counts: Ints, path: Ints, sure: Bools
) -> None:
    """Mark paths as not sure that an obstacle added may block, or an obstacle removed may shorten.

    Within ``margin`` metres of a path an obstacle may close a passage without touching the path.
    """
    if labelled.added:
        row = np.repeat(np.arange(len(lengths)), counts + 2)
        points = np.empty((len(row), 2))
        first = np.append(0, np.cumsum(counts + 2))
        points[first[:-1]], points[first[1:] - 1] = ends.points[::2], ends.points[1::2]
        points[np.arange(len(path)) + 2 * np.repeat(np.arange(len(lengths)), counts) + 1] = labelled.positions[path]
        lines = shapely.linestrings(points, indices=row)
        for shape in labelled.added.values():
            shapely.prepare(shape)
            sure &= ~shapely.dwithin(shape, lines, margin) | (counts == 0)
    for shape in labelled.removed.values():
        away = shapely.distance(shape, shapely.points(ends.points)).reshape(-1, 2).sum(axis=1)
        sure &= (lengths <= away - 2 * margin) | (counts == 0) & np.isfinite(lengths)
