"""Probabilistic roadmaps: random places of a free space, each joined with the nearest that it sees."""

from __future__ import annotations

import math
from dataclasses import dataclass
from operator import index

import numpy as np
from scipy.spatial import KDTree

from taut.freespace import FreeSpace
from taut.geometry.triangulation import Floats, Ints, Triangulation
from taut.roadmap.core import LocatedRoadmap, joined

_MOST_PAIRS = 100_000_000
# halvings of the way to the middle of the triangle, for samples that rounding took out of it: all bits of a double
_HALVINGS = 53


@dataclass(frozen=True, eq=False)
class Samples:
    """Random places and the pairs of them that a probabilistic roadmap tries to join.

    Parameters
    ----------
    positions : (n, 2) metres.
    triangles : (n,) a triangle of the mesh that contains each.
    pairs : (m, 2) i < j, ascending.
    """

    positions: Floats
    triangles: Ints
    pairs: Ints


def sampled_roadmap(
    freespace: FreeSpace, samples: int = 1000, seed: int = 0, neighbours: int | None = None
) -> LocatedRoadmap:
    """Build a probabilistic roadmap: random places, each joined with those of its nearest that it sees.

    Parameters
    ----------
    samples : how many places, at least 1; an empty free space has none.
    seed : ≥ 0; the same arguments give the same roadmap.
    neighbours : how many of the nearest places each tries to join, at least 1; None for ⌈2e ln samples⌉.

    Raises
    ------
    ValueError
        One of the numbers is not whole or too small, or over 100 million pairs would have to be tried.

    Notes
    -----
    With the usual number of neighbours this is k-PRM*: the lengths of its routes converge to the shortest, almost
    surely. In the plane any factor above e (1 + 1/2) does; 2e does in every dimension.
    Source: Karaman and Frazzoli, Sampling-based algorithms for optimal motion planning, IJRR 2011, 3.3 and theorem 35.

    >>> from taut import FreeSpace, Scene
    >>> sampled_roadmap(FreeSpace(Scene((0, 0, 4, 3))), samples=100).graph.n
    100
    """
    drawn = draw_samples(freespace, samples, seed, neighbours)
    return joined(freespace, drawn.positions, drawn.triangles, drawn.pairs)


def draw_samples(freespace: FreeSpace, samples: int = 1000, seed: int = 0, neighbours: int | None = None) -> Samples:
    """Return the places of `sampled_roadmap` and all pairs that it tries, seen or not. Raises as it does.

    The places are distributed evenly over the free space, exactly but for rounding: a triangle is drawn by its area,
    a place in it by two even numbers. None is thrown away.
    """
    count, number = _whole(samples, "samples", 1), _whole(seed, "seed", 0)
    usual = math.ceil(2 * math.e * math.log(count))
    nearest = min(usual if neighbours is None else _whole(neighbours, "neighbours", 1), count - 1)
    if count * (nearest + 1) > _MOST_PAIRS:
        raise ValueError(f"{count:,} samples with {nearest:,} neighbours are over {_MOST_PAIRS:,} pairs; take fewer")
    positions, triangles = _places(freespace.mesh, count, np.random.default_rng(number))
    return Samples(positions, triangles, _nearest_pairs(positions, nearest))


def _places(mesh: Triangulation, count: int, rng: np.random.Generator) -> tuple[Floats, Ints]:
    a, b, c = np.moveaxis(mesh.vertices[mesh.triangles], 1, 0)
    (ux, uy), (vx, vy) = (b - a).T, (c - a).T
    reached = np.cumsum(np.abs(ux * vy - uy * vx))
    if len(reached) == 0 or not reached[-1] > 0:
        return np.empty((0, 2)), np.empty(0, dtype=np.int64)
    drawn = np.searchsorted(reached, reached[-1] * rng.random(count), side="right")
    f, g = rng.random((2, count, 1))
    beyond = f + g > 1
    f, g = np.where(beyond, 1 - f, f), np.where(beyond, 1 - g, g)
    places = a[drawn] + f * (b - a)[drawn] + g * (c - a)[drawn]
    triangles = mesh.locate(places)
    for _ in range(_HALVINGS):
        out = np.flatnonzero(triangles < 0)
        if len(out) == 0:
            break
        t = drawn[out]
        places[out] = (places[out] + (a[t] + b[t] + c[t]) / 3) / 2
        triangles[out] = mesh.locate(places[out])
    kept = triangles >= 0
    kept[kept] = ~mesh.on_pinch(places[kept])
    return places[kept], triangles[kept]


def _nearest_pairs(positions: Floats, nearest: int) -> Ints:
    n = len(positions)
    count = min(nearest + 1, n)
    if count < 2:
        return np.empty((0, 2), dtype=np.int64)
    near = np.asarray(KDTree(positions).query(positions, k=count)[1], dtype=np.int64)
    own = np.repeat(np.arange(n), count)
    low, high = np.minimum(own, near.reshape(-1)), np.maximum(own, near.reshape(-1))
    keys = np.unique((low * n + high)[low < high])
    return np.stack([keys // n, keys % n], axis=1)


def _whole(value: int, what: str, least: int) -> int:
    try:
        number = index(value)
    except TypeError:
        number = least - 1
    if number < least:
        raise ValueError(f"{what} must be a whole number, at least {least}, got {value!r}")
    return number
