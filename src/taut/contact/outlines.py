"""What hides robots from each other: the outlines of obstacles and wall, drawn in by a small depth."""

from __future__ import annotations

import numpy as np
import shapely
from numpy.typing import NDArray

from taut.geometry.growth import free_region
from taut.scene import FloatArray, Scene

Ints = NDArray[np.int64]

FARTHEST = 8.0
"""Depths by which a corner moves at most, however sharp it is."""


def sight_sides(scene: Scene, depth: float) -> FloatArray:
    """Return the sides that a line of sight must not meet, (k, 4) as x0, y0, x1, y1 in metres.

    They are the boundary of obstacles and outside, united, each corner drawn into them along its bisector so that
    every side lies ``depth`` deeper than before. So a line of sight may slide along a wall or graze a corner. Circles
    and rounded walls are polygons of tangents outside the arc, by a thousandth of its radius at most. Obstacles without
    width have sides on either side of them, which nothing passes.

    Parameters
    ----------
    depth : metres, ≥ 0; a sharp corner moves by 8 times as much at most.

    Raises
    ------
    SceneError
        The workspace or a polygon crosses itself or has no area.

    >>> from taut.scene import Rectangle
    >>> sight_sides(Scene((0, 0, 8, 8), [Rectangle(2, 2, 4, 4)]), 0.5)[4:].tolist()[0]
    [2.5, 2.5, 2.5, 5.5]
    """
    rings = _rings(scene)
    if not rings:
        return np.empty((0, 4))
    tail = np.concatenate([ring[:-1] for ring in rings])
    head = np.concatenate([ring[1:] for ring in rings])
    along = head - tail
    along /= np.hypot(along[:, 0], along[:, 1])[:, None]
    following = _following(tail, head, along)
    moved = head + depth * _inwards(along, along[following])
    start = np.empty_like(moved)
    start[following] = moved
    return np.hstack([start, moved])


def _rings(scene: Scene) -> list[FloatArray]:
    """Closed rings with free space on their left."""
    parts = shapely.get_parts(shapely.orient_polygons(free_region(scene, 0.0)))
    rings = shapely.get_rings(shapely.remove_repeated_points(parts))
    return [shapely.get_coordinates(ring) for ring in rings]


def _following(tail: FloatArray, head: FloatArray, along: FloatArray) -> Ints:
    """Return for each side the one that goes on from its head along the same obstacle.

    Where obstacles touch in a point several sides leave it: the right one is the first counter-clockwise from the side
    that arrives, as the obstacle lies between them.
    """
    corner = np.unique(np.concatenate([tail, head]), axis=0, return_inverse=True)[1]
    leaves, arrives = corner[: len(tail)], corner[len(tail) :]
    order = np.argsort(leaves, kind="stable")
    begin = np.searchsorted(leaves[order], arrives)
    following: Ints = order[begin].astype(np.int64)
    for k in np.flatnonzero(np.bincount(leaves)[arrives] > 1):
        out = np.flatnonzero(leaves == arrives[k])
        back = -along[k]
        sine = back[0] * along[out, 1] - back[1] * along[out, 0]
        angle = np.arctan2(sine, along[out] @ back) % (2 * np.pi)
        following[k] = out[np.argmin(angle)]
    return following


def _inwards(before: FloatArray, after: FloatArray) -> FloatArray:
    """Displacement of corners, in depths, into what lies on the right of the sides before and after them."""
    n1, n2 = (np.stack([along[:, 1], -along[:, 0]], axis=1) for along in (before, after))
    both, cosine = n1 + n2, (n1 * n2).sum(axis=1)
    sharp = (both**2).sum(axis=1) > (1 + cosine) ** 2 * FARTHEST**2
    turn = before[:, 0] * after[:, 1] - before[:, 1] * after[:, 0]
    length = np.hypot(both[:, 0], both[:, 1])
    needle = length < 2.0**-40
    out = both / np.where(sharp, length / FARTHEST, 1 + cosine + (1 + cosine == 0))[:, None]
    out[needle] = np.where(turn > 0, FARTHEST, -FARTHEST)[needle, None] * before[needle]
    return np.asarray(out, dtype=np.float64)
