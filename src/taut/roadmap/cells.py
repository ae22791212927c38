"""Cell decomposition: ways through the triangles of a free space, from edge to edge."""

from __future__ import annotations

import numpy as np

from taut.freespace import FreeSpace
from taut.geometry.triangulation import Floats, Ints, Triangulation
from taut.roadmap.core import LocatedRoadmap, joined

# where on an inner edge its place may lie: the middle, or else where rounding leaves a place in the free space
_FRACTIONS = (0.5, 0.25, 0.75, 0.375, 0.625, 0.125, 0.875)


def cells_roadmap(freespace: FreeSpace) -> LocatedRoadmap:
    """Build the roadmap of a free space's triangles: one vertex on each edge between two of them.

    Vertices are the middles of the edges inside free space, and the centres of triangles that have at most one such
    edge: dead ends, and parts of a single triangle; they are sorted by x, then y. Within each triangle all are joined.

    Notes
    -----
    Complete: whatever part of the free space holds two places, `routes_along` finds a way between them. Its routes keep
    to the middle between corners of obstacles, not to short ways; see `smoothed`.
    Source: Latombe, Robot Motion Planning, 1991, chapter 5 (exact cell decomposition).

    >>> from taut import FreeSpace, Scene
    >>> roadmap = cells_roadmap(FreeSpace(Scene((0, 0, 3, 3))))
    >>> len(roadmap.positions), roadmap.edges.tolist()
    (3, [[0, 1], [1, 2]])
    """
    mesh = freespace.mesh
    doors, of_triangle = _doors(mesh)
    inner = of_triangle >= 0
    ends = np.flatnonzero(inner.sum(axis=1) <= 1)
    centres = mesh.vertices[mesh.triangles[ends]].mean(axis=1)
    alone = np.full((len(inner), 1), -1, dtype=np.int64)
    alone[ends, 0] = len(doors) + np.arange(len(ends))
    slots = np.concatenate([of_triangle, alone], axis=1)
    pairs = np.concatenate([slots[:, [i, j]] for i in range(4) for j in range(i + 1, 4)])
    # in slivers, rounding makes one place of several
    positions, place = np.unique(np.concatenate([doors, centres]), axis=0, return_inverse=True)
    triangles = mesh.locate(positions)
    kept = triangles >= 0
    kept[kept] = ~mesh.on_pinch(positions[kept])
    number = np.append(np.where(kept, np.cumsum(kept) - 1, -1)[place.reshape(-1)], -1)
    pairs = np.sort(number[pairs], axis=1)
    pairs = np.unique(pairs[(pairs[:, 0] >= 0) & (pairs[:, 0] < pairs[:, 1])], axis=0)
    return joined(freespace, positions[kept], triangles[kept], pairs)


def _doors(mesh: Triangulation) -> tuple[Floats, Ints]:
    """One place on each inner edge, (d, 2), and the number of that on each edge of each triangle, (m, 3); −1: none."""
    t, k = np.nonzero(mesh.neighbours >= 0)
    a, b = mesh.triangles[t, k], mesh.triangles[t, (k + 1) % 3]
    low, high = np.minimum(a, b), np.maximum(a, b)
    _, first, number = np.unique(low * len(mesh.vertices) + high, return_index=True, return_inverse=True)
    of_triangle = np.full(mesh.triangles.shape, -1, dtype=np.int64)
    of_triangle[t, k] = number
    low, high = mesh.vertices[low[first]], mesh.vertices[high[first]]
    doors = (low + high) / 2
    for fraction in _FRACTIONS:
        out = np.flatnonzero(mesh.locate(doors) < 0)
        doors[out] = low[out] + fraction * (high[out] - low[out])
    return doors, of_triangle
