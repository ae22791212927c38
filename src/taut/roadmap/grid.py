"""Regular grids: a square lattice over a free space, its neighbours joined where they see each other."""

from __future__ import annotations

import math

import numpy as np

from taut.freespace import FreeSpace
from taut.geometry.triangulation import Floats, Ints, Triangulation
from taut.roadmap.core import LocatedRoadmap, joined

_USUAL_PLACES = 4000
_USUAL_MOST_TRIED = 400_000
_MOST_TRIED = 10_000_000

# steps in columns and rows, of each pair of opposite ones the first
_STEPS = {
    4: ((1, 0), (0, 1)),
    8: ((1, 0), (0, 1), (1, 1), (-1, 1)),
    16: ((1, 0), (0, 1), (1, 1), (-1, 1), (2, 1), (1, 2), (-1, 2), (-2, 1)),
}


def grid_roadmap(freespace: FreeSpace, spacing: float | None = None, directions: int = 8) -> LocatedRoadmap:
    """Lay a square lattice over a free space and join neighbours that see each other.

    Parameters
    ----------
    spacing : metres between places; None for about 4,000 places, fewer where the free space fills less than a
        hundredth of its bounding box.
    directions : 4 (rows and columns), 8 (and diagonals) or 16 (and knights' moves).

    Raises
    ------
    ValueError
        ``directions`` is none of these, ``spacing`` is not a positive number, or so small that over 10 million places
        would have to be tried.

    Notes
    -----
    The lattice is centred in the bounding box of the free space. Passages without a place of the lattice are lost, and
    so are edges that touch a corner strictly between their ends. Against the shortest path on an empty plane, one along
    the lattice is longer by at most 41 %, 8.2 % and 2.7 % with 4, 8 and 16 directions.

    >>> from taut import FreeSpace, Scene
    >>> roadmap = grid_roadmap(FreeSpace(Scene((0, 0, 2, 1))), spacing=1, directions=4)
    >>> len(roadmap.positions), roadmap.edges.tolist()
    (6, [[0, 1], [0, 3], [1, 2], [1, 4], [2, 5], [3, 4], [4, 5]])
    """
    if directions not in _STEPS:
        raise ValueError(f"directions must be 4, 8 or 16, got {directions!r}")
    if spacing is not None and not (spacing > 0 and math.isfinite(spacing)):
        raise ValueError(f"spacing must be a positive number of metres, got {spacing!r}")
    mesh = freespace.mesh
    if len(mesh.triangles) == 0:
        nothing = np.empty(0, dtype=np.int64)
        return joined(freespace, np.empty((0, 2)), nothing, nothing.reshape(0, 2))
    width, height = (mesh.vertices.max(axis=0) - mesh.vertices.min(axis=0)).tolist()
    if spacing is None:
        spacing = max(math.sqrt(freespace.area / _USUAL_PLACES), math.sqrt(width * height / _USUAL_MOST_TRIED))
    elif (width / spacing + 1) * (height / spacing + 1) > _MOST_TRIED:
        raise ValueError(
            f"spacing {spacing:g} m would lay over {_MOST_TRIED:,} places on {width:g} m × {height:g} m; take more"
        )
    places = lattice(mesh, spacing)
    rows, columns, _ = places.shape
    positions = places.reshape(-1, 2)
    triangles = mesh.locate(positions)
    kept = triangles >= 0
    kept[kept] = ~mesh.on_pinch(positions[kept])
    number = np.where(kept, np.cumsum(kept) - 1, -1).reshape(rows, columns)
    pairs = np.concatenate([_pairs(number, across, up) for across, up in _STEPS[directions]])
    return joined(freespace, positions[kept], triangles[kept], pairs)


def lattice(mesh: Triangulation, spacing: float) -> Floats:
    """Places of a square lattice centred in the bounding box of a mesh that is not empty: (rows, columns, 2) metres."""
    low, high = mesh.vertices.min(axis=0), mesh.vertices.max(axis=0)
    columns, rows = (np.floor((high - low) / spacing).astype(np.int64) + 1).tolist()
    first = (low + high) / 2 - spacing * (np.array([columns, rows]) - 1) / 2
    x, y = np.meshgrid(first[0] + spacing * np.arange(columns), first[1] + spacing * np.arange(rows))
    return np.stack([x, y], axis=2)


def _pairs(number: Ints, across: int, up: int) -> Ints:
    """Pairs of numbered places that lie ``across`` columns and ``up`` ≥ 0 rows apart; −1 is no place."""
    rows, columns = number.shape
    left, right = max(-across, 0), columns - max(across, 0)
    if right <= left or rows <= up:
        return np.empty((0, 2), dtype=np.int64)
    pairs = np.stack([number[: rows - up, left:right], number[up:, left + across : right + across]], axis=2)
    pairs = pairs.reshape(-1, 2)
    return np.asarray(pairs[(pairs >= 0).all(axis=1)])
