"""A roadmap made of lines drawn in free space: routes of several robots, which they may then share."""

from __future__ import annotations

from collections.abc import Iterable

import numpy as np
from numpy.typing import ArrayLike

from taut.freespace import FreeSpace
from taut.graph import Graph
from taut.roadmap.core import LocatedRoadmap


def polyline_roadmap(freespace: FreeSpace, lines: Iterable[ArrayLike]) -> LocatedRoadmap:
    """Join lines (k, 2) at the points that they have in common; each leg must be an allowed motion.

    Points where free space merely touches itself are left out with their legs: who passes from one line to another
    there might pass through it.

    >>> from taut.scene import Scene
    >>> hall = FreeSpace(Scene((0, 0, 4, 3)))
    >>> polyline_roadmap(hall, [[(0, 0), (2, 1), (4, 0)], [(0, 3), (2, 1)]]).graph.n
    4
    """
    arrays = [np.asarray(line, dtype=np.float64).reshape(-1, 2) for line in lines]
    points = np.concatenate(arrays) if arrays else np.empty((0, 2))
    line = np.repeat(np.arange(len(arrays)), [len(a) for a in arrays])
    positions, number = np.unique(points, axis=0, return_inverse=True)
    legs = np.flatnonzero(line[1:] == line[:-1]) if len(line) else np.empty(0, dtype=np.int64)
    pairs = number[np.stack([legs, legs + 1], axis=1)]
    xy, triangles = freespace.anchor(positions)
    usable = (triangles >= 0) & ~freespace.mesh.on_pinch(xy)
    pairs = pairs[usable[pairs].all(axis=1) & (pairs[:, 0] != pairs[:, 1])]
    renumbered = np.cumsum(usable) - 1
    edges = np.unique(np.sort(renumbered[pairs], axis=1), axis=0).astype(np.int64)
    xy, triangles = xy[usable], triangles[usable]
    lengths = np.hypot(*(xy[edges[:, 0]] - xy[edges[:, 1]]).T)
    return LocatedRoadmap(xy, Graph.from_edges(len(xy), edges, lengths), freespace, triangles)
