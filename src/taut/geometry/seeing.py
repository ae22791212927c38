"""Which vertices and points of a triangulated region see each other, by triangular expansion.

Complexity: a root visits the triangles that it sees, so all pairs cost O(n + visited) beyond the output.
Source: Bungiu et al., Efficient computation of visibility polygons, arXiv 1403.3905 (triangular expansion).
"""

from __future__ import annotations

import os
from concurrent.futures import ThreadPoolExecutor

import numpy as np
from numpy.typing import NDArray

from taut.geometry import _kernels
from taut.geometry.triangulation import Floats, Ints, Triangulation

_CHUNK = 256


def see_all(mesh: Triangulation, wanted: NDArray[np.bool_], *, taut: bool) -> Ints:
    """Pairs of wanted wedges that see each other with no vertex strictly between, (p, 2), i < j, sorted.

    ``taut`` keeps only pairs that are locally shortest at both ends.
    """
    n = len(mesh.wedges)
    arrays = (mesh.vertices, mesh.triangles, mesh.neighbours, mesh.wedges, mesh.wedge_of, wanted, taut)

    def chunk(first: int) -> tuple[Ints, Ints]:
        return _kernels.see_from_wedges(*arrays, first, min(first + _CHUNK, n))

    firsts = range(0, n, _CHUNK)
    if n <= _CHUNK:
        found = [chunk(first) for first in firsts]
    else:
        with ThreadPoolExecutor(os.cpu_count()) as pool:
            found = list(pool.map(chunk, firsts))
    if not found:
        return np.empty((0, 2), dtype=np.int64)
    pairs = np.stack([np.concatenate(column) for column in zip(*found, strict=True)], axis=1)
    return pairs[np.lexsort((pairs[:, 1], pairs[:, 0]))]


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
    return _kernels.see_from_points(
        mesh.vertices,
        mesh.triangles,
        mesh.neighbours,
        mesh.wedges,
        mesh.wedge_of,
        mesh.vertex_start,
        mesh.vertex_wedges,
        wanted,
        taut,
        points,
        triangles,
        reach,
    )


def see_each_other(mesh: Triangulation, points: Floats, triangles: Ints, a: Ints, b: Ints) -> NDArray[np.bool_]:
    """For pairs (a[i], b[i]) of points: whether the segment is free and has no vertex strictly between."""
    return _kernels.see_pairs(
        mesh.vertices,
        mesh.triangles,
        mesh.neighbours,
        mesh.wedges,
        mesh.vertex_start,
        mesh.vertex_wedges,
        points,
        triangles,
        a,
        b,
    )
