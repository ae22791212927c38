"""Weights of edges from the distances of their ends, and graphs of who is within reach of whom."""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import TypeAlias

import numpy as np
from numpy.typing import ArrayLike
from scipy.spatial import KDTree

from taut.graph.core import Floats, Graph, Ints

Weight: TypeAlias = Callable[[Floats], Floats]
"""From distances in metres, (m,), to weights ≥ 0, (m,)."""


def one(distances: Floats) -> Floats:
    """Weigh every edge 1."""
    return np.ones_like(distances)


def distance(distances: Floats) -> Floats:
    """Weigh every edge by its length in metres."""
    return distances.copy()


WEIGHTS: dict[str, Weight] = {"one": one, "distance": distance}
"""The weights that need no parameter, by name."""


def exponential(reach: float) -> Weight:
    """Weight e^d for a distance of d metres within ``reach``, else 0 (thesis (4.4)).

    Raises
    ------
    ValueError
        ``reach`` is negative or not a number.

    >>> exponential(2.0)(np.array([0.0, 2.5])).tolist()
    [1.0, 0.0]
    """
    _check_reach(reach)

    def weight(distances: Floats) -> Floats:
        values = np.zeros_like(distances)
        near = distances <= reach
        with np.errstate(over="ignore"):  # an infinite weight is refused, with its edge, where it is used
            values[near] = np.exp(distances[near])
        return values

    return weight


def fading(f: Weight, reach: float) -> Weight:
    """Weight f(d), decreasing with the distance d from 1 at most to 0 at least, and 0 beyond ``reach`` (thesis (8.13)).

    Raises
    ------
    ValueError
        ``reach`` is negative or not a number; later, when weights are asked for, where ``f`` leaves [0, 1] or increases
        on the distances given.

    >>> fading(lambda d: 1 - d / 4, 4.0)(np.array([1.0, 5.0])).tolist()
    [0.75, 0.0]
    """
    _check_reach(reach)

    def weight(distances: Floats) -> Floats:
        values = np.zeros_like(distances)
        near = np.flatnonzero(distances <= reach)
        near = near[np.argsort(distances[near], kind="stable")]
        ascending = distances[near]
        faded = _of_shape(f(ascending), ascending)
        outside = np.flatnonzero(~((faded >= 0) & (faded <= 1)))
        if len(outside):
            k = outside[0]
            raise ValueError(f"a fading weight lies in [0, 1], but f({ascending[k]:.6g}) = {faded[k]:.6g}")
        rising = np.flatnonzero(np.diff(faded) > 0)
        if len(rising):
            k = rising[0]
            raise ValueError(
                "a fading weight does not increase with the distance, "
                f"but f({ascending[k]:.6g}) = {faded[k]:.6g} < f({ascending[k + 1]:.6g}) = {faded[k + 1]:.6g}"
            )
        values[near] = faded
        return values

    return weight


def weighted(graph: Graph, positions: ArrayLike, weight: Weight) -> Graph:
    """Weigh the edges anew by the distances of their ends; edges whose weight is 0 are left out.

    Parameters
    ----------
    positions : (n, 2) metres.
    weight : from distances to weights: `one`, `distance`, `exponential`, `fading` or any other function.

    Raises
    ------
    ValueError
        Positions of another shape or not finite; a weight that is negative or not finite.

    >>> weighted(Graph.from_edges(2, [(0, 1)]), [(0, 0), (3, 4)], distance).lengths.tolist()
    [5.0]
    """
    places = _places(positions)
    if len(places) != graph.n:
        raise ValueError(f"{graph.n} vertices but {len(places)} positions")
    edges = graph.edges
    distances = _distances(places, edges)
    values = _of_shape(weight(distances), distances)
    wrong = np.flatnonzero(~(np.isfinite(values) & (values >= 0)))
    if len(wrong):
        k = wrong[0]
        i, j = edges[k]
        raise ValueError(
            f"edge ({i}, {j}) of {distances[k]:.6g} m has weight {values[k]:.6g}: weights are finite and not negative"
        )
    kept = values > 0
    return Graph.from_edges(graph.n, edges[kept], values[kept])


def contact_graph(positions: ArrayLike, reach: float, weight: Weight = one) -> Graph:
    """Join all pairs at most ``reach`` metres apart: the communication graph of a team.

    Time and memory grow with the number of vertices and pairs within reach, not with n².

    Parameters
    ----------
    positions : (n, 2) metres.
    weight : of an edge by its length; pairs of weight 0 are not joined.

    Raises
    ------
    ValueError
        As `weighted`; or ``reach`` is negative or not a number.

    >>> contact_graph([(0, 0), (1, 0), (3, 0)], reach=1.0).edges.tolist()
    [[0, 1]]
    """
    _check_reach(reach)
    places = _places(positions)
    # The tree looks in a square, and a little further: it neither squares a coordinate nor rounds a pair away.
    pairs = KDTree(places).query_pairs(reach * (1 + 2.0**-20), p=math.inf, output_type="ndarray")
    near = pairs[_distances(places, pairs) <= reach]
    return weighted(Graph.from_edges(len(places), near), places, weight)


def _check_reach(reach: float) -> None:
    if not reach >= 0:
        raise ValueError(f"reach is {reach}: it is a distance in metres, 0 or more")


def _places(positions: ArrayLike) -> Floats:
    places = np.asarray(positions, dtype=np.float64)
    if places.size == 0:
        return places.reshape(0, 2)
    if places.ndim != 2 or places.shape[1] != 2:
        raise ValueError(f"positions have shape {places.shape}: give one row (x, y) a vertex")
    wrong = np.flatnonzero(~np.isfinite(places).all(axis=1))
    if len(wrong):
        raise ValueError(f"vertex {wrong[0]} is at {tuple(places[wrong[0]].tolist())}: coordinates must be finite")
    return places


def _distances(places: Floats, pairs: Ints) -> Floats:
    across = places[pairs[:, 0]] - places[pairs[:, 1]]
    return np.hypot(across[:, 0], across[:, 1])


def _of_shape(values: ArrayLike, distances: Floats) -> Floats:
    found = np.asarray(values, dtype=np.float64)
    if found.shape != distances.shape:
        raise ValueError(f"the weight of {len(distances)} distances has shape {found.shape}: give one value a distance")
    return found
