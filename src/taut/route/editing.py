"""A PathIndex after one obstacle more or less, at the cost of what is touched."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace

import numpy as np
import shapely

from taut.geometry.growth import grown
from taut.roadmap import changing
from taut.roadmap.changing import Changed
from taut.route.index import PathIndex
from taut.route.states import taut_states
from taut.scene import Obstacle


def with_obstacle(index: PathIndex, obstacle: Obstacle) -> PathIndex:
    """Add an obstacle to a prepared map.

    Triangulation and tangent graph change where the obstacle is. Labels are kept: they still answer for pairs whose old
    path the obstacle does not touch, and A* for the others; `prepare` anew when many are.

    Raises
    ------
    SceneError
        Its name is taken, or the obstacle crosses or touches itself.

    >>> from taut import FreeSpace, Rectangle, Scene, distances, prepare
    >>> index = prepare(FreeSpace(Scene((0, 0, 8, 2))))
    >>> distances(with_obstacle(index, Rectangle(3, 0, 2, 1)), [(0, 0)], [(8, 0)]).round(4)
    array([8.3246])
    """
    changed = changing.with_obstacle(index.freespace, index.tangents, obstacle)
    added = changed.freespace.scene.obstacles[-1]
    labelled = index.labelled
    if labelled is None:
        return _moved(index, changed, {}, {})
    return _moved(index, changed, {**labelled.added, added.name: _shape(index, added)}, labelled.removed)


def without_obstacle(index: PathIndex, name: str) -> PathIndex:
    """Remove the obstacle of this name from a prepared map.

    Labels are kept: they still answer for pairs whose path is no longer than the way to the obstacle and on.

    Raises
    ------
    SceneError
        There is no such obstacle.
    """
    changed = changing.without_obstacle(index.freespace, index.tangents, name)
    labelled = index.labelled
    if labelled is None:
        return _moved(index, changed, {}, {})
    if name in labelled.added:
        left = {other: shape for other, shape in labelled.added.items() if other != name}
        return _moved(index, changed, left, labelled.removed)
    gone = next(obstacle for obstacle in index.freespace.scene.obstacles if obstacle.name == name)
    # the same name may have been removed before, put back and removed again
    known = [labelled.removed[name]] if name in labelled.removed else []
    both = shapely.union_all([*known, _shape(index, gone)])
    return _moved(index, changed, labelled.added, {**labelled.removed, name: both})


def _moved(
    index: PathIndex,
    changed: Changed,
    added: Mapping[str, shapely.Geometry],
    removed: Mapping[str, shapely.Geometry],
) -> PathIndex:
    labelled = index.labelled
    if labelled is not None:
        before = changed.before
        numbers = np.full(len(before), -1, dtype=np.int64)
        numbers[before >= 0] = labelled.numbers[before[before >= 0]]
        labelled = replace(labelled, numbers=numbers, added=added, removed=removed)
    states = taut_states(changed.freespace, changed.tangents)
    return PathIndex(changed.freespace, changed.tangents, states, labelled)


def _shape(index: PathIndex, obstacle: Obstacle) -> shapely.Polygon:
    return grown(obstacle, index.freespace.growth, index.freespace.arc_error, tol=index.freespace.scene.tol)
