"""Shortest routes straight through the triangulation, where a graph is not worth building: optimal interval search.

Source: Cui, Harabor and Grastien, Compromise-free pathfinding on a navigation mesh, IJCAI 2017 (Polyanya).
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TypeAlias

import numpy as np
from numpy.typing import ArrayLike

from taut.chunks import over_chunks
from taut.freespace import FreeSpace
from taut.geometry.triangulation import Floats, Ints
from taut.route import _direct_kernels
from taut.route.core import Route, in_turn, points_of, require_found, require_free

_CHUNK = 256

_Found: TypeAlias = tuple[Floats, Ints, Ints, Floats]


@dataclass(frozen=True, eq=False)
class DirectRoute(Route):
    """A shortest route and the work it took.

    Parameters
    ----------
    points : (k, 2) metres, from start to goal; one row if they are the same place.
    expanded : triangles that the search looked through, each as often as it did; 0 if one triangle holds both ends.
    """

    expanded: int


def shortest_path(freespace: FreeSpace, a: ArrayLike, b: ArrayLike) -> DirectRoute:
    """Find a shortest allowed path between two points.

    No graph is built; see `prepare` for many paths on one map.

    Raises
    ------
    StartBlocked, GoalBlocked
        ``a`` or ``b`` is not in free space.
    NoPath
        Obstacles separate them.

    >>> from taut import FreeSpace, Scene
    >>> shortest_path(FreeSpace(Scene((0, 0, 4, 3))), (0, 0), (3, 0)).length
    3.0
    """
    for place, name in ((a, "a"), (b, "b")):
        if len(points_of(place, name)) != 1 or np.ndim(place) != 1:
            raise ValueError(f"{name} must be one point (x, y), got shape {np.shape(place)}")
    return direct_paths(freespace, a, b)[0]


def direct_paths(freespace: FreeSpace, starts: ArrayLike, goals: ArrayLike) -> list[DirectRoute]:
    """Find a shortest route from each of (k, 2) starts to the goal in the same row. Raises as `shortest_path`.

    Notes
    -----
    Nothing is prepared, so this is the way for a few pairs on a map that changes; for many pairs on one map build the
    tangent graph, see `prepare`. Sides are decided exactly and lower bounds are rounded downwards, so the
    length exceeds the least one only by the rounding of its own sum.
    """
    given, found = _found(freespace, starts, goals)
    lengths, expanded, first, points = found
    require_found(freespace, given, lengths)
    ends = first.tolist()
    return [DirectRoute(points[i:j], n) for i, j, n in zip(ends, ends[1:], expanded.tolist(), strict=False)]


def direct_lengths(freespace: FreeSpace, starts: ArrayLike, goals: ArrayLike) -> tuple[Floats, Ints]:
    """Lengths of shortest routes from each of (k, 2) starts to the goal in the same row, and the work they took.

    Returns
    -------
    lengths : (k,) metres, inf where obstacles separate the two.
    expanded : (k,) as in `DirectRoute`.

    Raises
    ------
    StartBlocked, GoalBlocked
        A start or a goal is not in free space.

    >>> from taut import FreeSpace, Scene
    >>> direct_lengths(FreeSpace(Scene((0, 0, 4, 3))), [(0, 0), (1, 1)], [(3, 0), (1, 3)])[0].tolist()
    [3.0, 2.0]
    """
    _, (lengths, expanded, _, _) = _found(freespace, starts, goals)
    return lengths, expanded


def _found(freespace: FreeSpace, starts: ArrayLike, goals: ArrayLike) -> tuple[Floats, _Found]:
    """Starts and goals in turn as given, and the kernel's results for all pairs."""
    given = in_turn(starts, goals)
    xy, triangles = freespace.anchor(given)
    require_free(freespace, given, triangles)
    mesh = freespace.mesh
    arrays = (
        mesh.vertices,
        mesh.triangles,
        mesh.neighbours,
        mesh.parts,
        mesh.wedges,
        mesh.wedge_of,
        mesh.wedge_turns,
        mesh.vertex_start,
        mesh.vertex_wedges,
        given,
        xy,
        triangles,
    )
    found = over_chunks(lambda first, last: _direct_kernels.search_pairs(*arrays, first, last), len(given) // 2, _CHUNK)
    if len(found) == 1:
        return given, found[0]
    if not found:
        return given, (np.empty(0), np.empty(0, dtype=np.int64), np.zeros(1, dtype=np.int64), np.empty((0, 2)))
    lengths, expanded, firsts, points = zip(*found, strict=True)
    counts = np.concatenate([np.diff(first) for first in firsts])
    first = np.append(0, np.cumsum(counts)).astype(np.int64)
    return given, (np.concatenate(lengths), np.concatenate(expanded), first, np.concatenate(points))
