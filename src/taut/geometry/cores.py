"""Cores: the shapes of obstacles without their own radius, thousands at once."""

from __future__ import annotations

from collections.abc import Sequence
from itertools import chain
from typing import TypeAlias

import numpy as np
import shapely
from numpy.typing import NDArray

from taut.scene import FloatArray, Line, Obstacle, Polygon

Shapes: TypeAlias = NDArray[np.object_]


def cores_of(obstacles: Sequence[Obstacle]) -> Shapes:
    """Return the core of each obstacle, (m,): a Polygon where it is closed, else a LineString or a Point.

    Polygons may be invalid, as their obstacles are.

    >>> from taut.scene import Circle
    >>> cores_of([Circle((1, 2), 3)])[0].wkt
    'POINT (1 2)'
    """
    # an array for each obstacle would take longer than all shapes together
    rows = [o.points if isinstance(o, Polygon | Line) else o.core.tolist() for o in obstacles]
    count = np.array([len(row) for row in rows], dtype=np.intp)
    flat: FloatArray = np.fromiter(chain.from_iterable(chain.from_iterable(rows)), dtype=np.float64).reshape(-1, 2)
    owner = np.repeat(np.arange(len(rows)), count)
    closed = np.array([o.closed for o in obstacles], dtype=np.bool_)
    single = ~closed & (count == 1)
    walls = ~closed & ~single
    out: Shapes = np.empty(len(rows), dtype=object)
    if closed.any():
        out[closed] = shapely.polygons(shapely.linearrings(flat[closed[owner]], indices=_numbers(closed, owner)))
    if walls.any():
        out[walls] = shapely.linestrings(flat[walls[owner]], indices=_numbers(walls, owner))
    if single.any():
        out[single] = shapely.points(flat[single[owner]])
    return out


def _numbers(kind: NDArray[np.bool_], owner: NDArray[np.intp]) -> NDArray[np.intp]:
    """The number, among shapes of one kind, of the shape to which each of their points belongs."""
    found: NDArray[np.intp] = (np.cumsum(kind) - 1)[owner[kind[owner]]]
    return found
