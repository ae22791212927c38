"""Which vertices and points of a triangulated region see each other, by triangular expansion.

Complexity: a root visits the triangles that it sees, so all pairs cost O(n + visited) beyond the output.
Source: Bungiu et al., Efficient computation of visibility polygons, arXiv 1403.3905 (triangular expansion).
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from taut.chunks import over_chunks
from taut.geometry import _seeing_kernels
from taut.geometry.triangulation import Floats, Ints, Triangulation

_CHUNK = 128


def see_all(mesh: Triangulation, wanted: NDArray[np.bool_], *, taut: bool) -> Ints:
    """Pairs of wanted wedges that see each other with no vertex strictly between, (p, 2), i < j, ascending in i.

    ``taut`` keeps only pairs that are locally shortest at both ends.
    """
    arrays = (mesh.vertices, mesh.triangles, mesh.neighbours, mesh.wedges, mesh.wedge_of, wanted, taut)
    found = over_chunks(
        lambda first, last: _seeing_kernels.see_from_wedges(*arrays, first, last), len(mesh.wedges), _CHUNK
    )
    if not found:
        return np.empty((0, 2), dtype=np.int64)
    return np.stack([np.concatenate(column) for column in zip(*found, strict=True)], axis=1)


def see_from(
    mesh: Triangulation,
    points: Floats,
    triangles: Ints,
    wanted: NDArray[np.bool_],
    *,
    taut: bool,
    reach: float = np.inf,
) -> tuple[Ints, Ints]:
    """Wanted wedges that each point sees with no vertex strictly between, as CSR (start, wedge).

    ``triangles`` holds each point's triangle (see `Triangulation.locate`); on a vertex it sees from all its wedges.
    Wedges farther than ``reach`` metres may be left out.
    """
    arrays = (
        mesh.vertices,
        mesh.triangles,
        mesh.neighbours,
        mesh.wedges,
        mesh.wedge_of,
        mesh.vertex_start,
        mesh.vertex_wedges,
        wanted,
        taut,
    )

    def chunk(first: int, last: int) -> tuple[Ints, Ints]:
        return _seeing_kernels.see_from_points(*arrays, points[first:last], triangles[first:last], reach)

    found = over_chunks(chunk, len(points), _CHUNK)
    counts = [np.diff(start) for start, _ in found]
    start = np.append(0, np.cumsum(np.concatenate(counts))) if counts else np.zeros(1, dtype=np.int64)
    return start, np.concatenate([seen for _, seen in found]) if found else np.empty(0, dtype=np.int64)


def see_each_other(mesh: Triangulation, points: Floats, triangles: Ints, a: Ints, b: Ints) -> NDArray[np.bool_]:
    """For pairs (a[i], b[i]) of points: whether the segment is free and has no vertex strictly between."""
    arrays = (
        mesh.vertices,
        mesh.triangles,
        mesh.neighbours,
        mesh.wedges,
        mesh.vertex_start,
        mesh.vertex_wedges,
        points,
        triangles,
    )
    found = over_chunks(
        lambda first, last: _seeing_kernels.see_pairs(*arrays, a[first:last], b[first:last]), len(a), 16 * _CHUNK
    )
    return np.concatenate(found) if found else np.zeros(0, dtype=np.bool_)
