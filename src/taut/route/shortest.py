"""Shortest routes in the plane by A* on the tangent graph; start and goal are attached by one expansion each."""

from __future__ import annotations

from itertools import pairwise

import numpy as np
from numpy.typing import ArrayLike

from taut.freespace import FreeSpace
from taut.roadmap import VisibilityGraph
from taut.route.core import Route, in_turn, require_found, require_free
from taut.route.states import Attached, attach, search, taut_states


def shortest_routes(
    freespace: FreeSpace, tangents: VisibilityGraph, starts: ArrayLike, goals: ArrayLike
) -> list[Route]:
    """Find a shortest route from each of (k, 2) starts to the goal in the same row. Raises as `shortest_path`.

    ``tangents`` is the tangent graph of ``freespace`` without further points.
    """
    return routes_between(freespace, tangents, attach(freespace, tangents, in_turn(starts, goals)))


def routes_between(freespace: FreeSpace, tangents: VisibilityGraph, ends: Attached) -> list[Route]:
    """Find a shortest route between places 0 and 1, 2 and 3, … of ``ends``. Raises as `shortest_path`."""
    require_free(freespace, ends.given, ends.triangles)
    lengths, start, path = search(freespace.mesh, taut_states(freespace, tangents), ends)
    require_found(freespace, ends.given, lengths)
    corners = tangents.positions[path]
    out = []
    for q, (first, last) in enumerate(pairwise(start.tolist())):
        points = np.concatenate([ends.given[2 * q, None], corners[first:last], ends.given[2 * q + 1, None]])
        moved = np.append(True, (np.diff(points, axis=0) != 0).any(axis=1))
        out.append(Route(points[moved]))
    return out
