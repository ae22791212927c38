"""Bounds on how well a graph holds together: on λ2, and on the isoperimetric number."""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass
from typing import Literal

import numpy as np
from scipy.sparse.csgraph import connected_components

from taut.graph.connectedness import components, connected, cut_edges, cut_vertices
from taut.graph.core import Graph, Ints
from taut.graph.matrices import adjacency, degrees
from taut.graph.resistance import kirchhoff_index
from taut.graph.search import breadth_first
from taut.graph.spectral import algebraic_connectivity, fiedler_vector
from taut.graph.trees import maximum_spanning_tree


@dataclass(frozen=True)
class Bound:
    """What is known of λ2 without computing it.

    Parameters
    ----------
    name : what the bound looks at, in a word or two.
    side : "lower" if λ2 ≥ value, "upper" if λ2 ≤ value, "exact" if λ2 = value.
    value : the number, in the unit of the weights.
    formula : the statement, as it may be printed.
    source : who proved it.
    """

    name: str
    side: Literal["lower", "upper", "exact"]
    value: float
    formula: str
    source: str


@dataclass(frozen=True, eq=False)
class IsoperimetricBounds:
    """Bounds on i(G), the least w(∂S) / |S| over sets S of at most half the vertices (∂S: the edges that leave S).

    Parameters
    ----------
    lower : i(G) ≥ lower, from λ2.
    upper : i(G) ≤ upper, which is w(∂S) / |S| of the set ``cut``.
    cheeger : i(G) ≤ cheeger, from λ2 and the largest degree; no better than ``upper``, rounding apart.
    cut : (k,) vertices of that set, ascending, k ≤ n / 2.
    """

    lower: float
    upper: float
    cheeger: float
    cut: Ints


def connectivity_bounds(graph: Graph) -> tuple[Bound, ...]:
    """Every bound of the literature below that holds for λ2 of this graph; none with fewer than two vertices.

    Edges of weight 0 are left out first. A disconnected graph has λ2 = 0 and nothing more to say. Graphs whose weights
    are all 1 have the exact values of complete graphs, cycles, paths and stars, and bounds by vertices, degrees,
    cut vertices and the diameter; bounds by degrees, resistances, the weakest link and the least weight hold for all.

    Raises
    ------
    ValueError
        The weights at a vertex sum to more than a float holds.

    Notes
    -----
    Lower bounds may be negative and so say nothing. No eigenvalue is computed; the dearest are `kirchhoff_index` and,
    for weights 1, the diameter (n breadth-first searches at worst, mostly a few).
    Source: Alwafi's thesis, 3.3; Fiedler 1973, "Algebraic connectivity of graphs"; Mohar 1991, "Eigenvalues, diameter
    and mean distance in graphs"; Klein and Randić 1993.

    >>> [bound.name for bound in connectivity_bounds(Graph.from_edges(3, [(0, 1), (1, 2)])) if bound.side == "exact"]
    ['path', 'star']
    """
    if graph.n < 2:
        return ()
    if not connected(graph):
        return (Bound("components", "exact", 0.0, "0: several components", "Fiedler 1973"),)
    kept = graph.lengths > 0
    links = Graph.from_edges(graph.n, graph.edges[kept], graph.lengths[kept])
    bounds = list(_of_any_weights(links))
    bounds += _of_unit_weights(links) if (links.weights == 1).all() else [_weakest_link(links)]
    return tuple(sorted(bounds, key=lambda bound: ("exact", "lower", "upper").index(bound.side)))


def isoperimetric_bounds(graph: Graph) -> IsoperimetricBounds:
    """Bounds on the isoperimetric number from λ2, and a set of vertices that is cheap to cut off.

    It is the cheapest of the sets that begin or end the vertices as sorted by the Fiedler vector. In a disconnected
    graph the smallest component costs nothing.

    Raises
    ------
    ValueError
        Fewer than two vertices, which have no set to cut off; or weights too large to sum.

    Notes
    -----
    w(∂S) ≥ λ2 |S| (n − |S|) / n gives the lower bound λ2 ⌈n/2⌉ / n, which is λ2 / 2 or a little more.
    Mohar 1989 ("Isoperimetric numbers of graphs") shows i(G) ≤ √(λ2 (2Δ − λ2)), Δ the largest degree, for simple graphs
    but K1, K2, K3. His proof serves weights as well and gives √(ρ (2Δ − ρ)) for some ρ ≤ λ2, which grows with ρ up to
    ρ = Δ; so the bound is right for every graph with min(λ2, Δ) in place of λ2, and the sweep attains it.
    Bounds from λ2 are as exact as `algebraic_connectivity`.

    >>> isoperimetric_bounds(Graph.from_edges(4, [(0, 1), (1, 2), (2, 3)])).cut
    array([0, 1])
    """
    if graph.n < 2:
        raise ValueError(f"a graph of {graph.n} vertices has no isoperimetric number; at least 2 are needed")
    labels = components(graph)
    if labels.any():
        smallest = np.flatnonzero(labels == np.bincount(labels).argmin())
        return IsoperimetricBounds(0.0, 0.0, 0.0, smallest)
    cut = _best_sweep(graph, np.argsort(fiedler_vector(graph), kind="stable"))
    upper = _boundary(graph, cut) / len(cut)
    connectivity = algebraic_connectivity(graph)
    largest = float(degrees(graph).max())
    part = min(connectivity / largest, 1.0)
    cheeger = largest * math.sqrt(part * (2 - part))
    lower = connectivity * ((graph.n + 1) // 2) / graph.n
    return IsoperimetricBounds(min(lower, upper), upper, cheeger, cut)


def _of_any_weights(graph: Graph) -> Iterator[Bound]:
    n = graph.n
    least = float(degrees(graph).min())
    yield Bound("least degree", "upper", n / (n - 1) * least, "n/(n − 1) · d_min", "Fiedler 1973")
    bridged = len(cut_edges(graph)) > 0
    lightest = float(graph.weights.min())
    yield Bound(
        "bridges" if bridged else "no bridges",
        "lower",
        (1 if bridged else 2) * lightest * _gap(math.pi / n),
        f"{'2' if bridged else '4'} w_min (1 − cos π/n)",
        "Fiedler 1973",
    )
    total = kirchhoff_index(graph)
    yield Bound("resistances", "lower", n / total, "n / Kf, Kf the Kirchhoff index", "Σ 1/λ_k = Kf/n")
    yield Bound("mean resistance", "upper", n * ((n - 1) / total), "n (n − 1) / Kf", "Σ 1/λ_k = Kf/n")


def _weakest_link(graph: Graph) -> Bound:
    """Cut along the lightest edge of the heaviest spanning tree: no partition in two has a lighter heaviest edge."""
    tree = maximum_spanning_tree(graph)
    weakest = int(np.argmin(tree.lengths))
    rest = Graph.from_edges(graph.n, np.delete(tree.edges, weakest, axis=0))
    side = np.flatnonzero(connected_components(adjacency(rest), directed=False)[1] == 0)
    value = graph.n / (len(side) * (graph.n - len(side))) * _boundary(graph, side)
    return Bound("weakest link", "upper", value, "n w(∂S) / (|S| (n − |S|)), S beyond the weakest link", "Fiedler 1973")


def _of_unit_weights(graph: Graph) -> Iterator[Bound]:
    n, m = graph.n, graph.m
    degree = np.diff(graph.indptr)
    least, most = int(degree.min()), int(degree.max())
    full = n * (n - 1) // 2
    if m == full:
        yield Bound("complete graph", "exact", float(n), "n", "Fiedler 1973")
    if m == n and most == 2:
        yield Bound("cycle", "exact", _gap(2 * math.pi / n), "2 (1 − cos 2π/n)", "Fiedler 1973")
    if m == n - 1 and most <= 2:
        yield Bound("path", "exact", _gap(math.pi / n), "2 (1 − cos π/n)", "Fiedler 1973")
    if m == n - 1 and most == n - 1 and n > 2:
        yield Bound("star", "exact", 1.0, "1", "Fiedler 1973")
    yield Bound("least degree", "lower", float(2 * least - n + 2), "2 d_min − n + 2", "Fiedler 1973")
    yield Bound("diameter", "lower", 4 / (n * _diameter(graph)), "4 / (n · diameter)", "Mohar 1991")
    if m < full:
        yield Bound("not complete", "upper", float(n - 2), "n − 2", "Fiedler 1973")
        yield Bound("least degree, not complete", "upper", float(least), "d_min", "Fiedler 1973")
    if len(cut_vertices(graph)):
        yield Bound("cut vertex", "upper", 1.0, "1: losing one vertex disconnects it", "Fiedler 1973")


def _gap(angle: float) -> float:
    """2 (1 − cos angle) without cancellation."""
    return 4 * math.sin(angle / 2) ** 2


def _diameter(graph: Graph) -> int:
    """Largest number of edges on a shortest path, searched from the vertices farthest from a busy one (iFUB)."""
    hops, _ = breadth_first(graph, int(np.argmax(np.diff(graph.indptr))))
    longest = int(hops.max())
    for v in np.argsort(-hops, kind="stable").tolist():
        if longest >= 2 * hops[v]:  # two vertices at most this far from the busy one are no farther apart
            break
        longest = max(longest, int(breadth_first(graph, v)[0].max()))
    return longest


def _best_sweep(graph: Graph, order: Ints) -> Ints:
    """Set, among those that begin or end the order, with the least w(∂S) / |S| and at most half the vertices."""
    n = graph.n
    place = np.empty(n, dtype=np.int64)
    place[order] = np.arange(n)
    first, last = np.sort(place[graph.edges], axis=1).T
    opened = np.bincount(first, graph.lengths, n) - np.bincount(last, graph.lengths, n)
    sizes = np.arange(1, n)
    cost = np.cumsum(opened)[:-1] / np.minimum(sizes, n - sizes)
    k = int(sizes[np.argmin(cost)])
    return np.sort(order[:k] if 2 * k <= n else order[k:])


def _boundary(graph: Graph, side: Ints) -> float:
    """Total weight of the edges that leave a set of vertices."""
    inside = np.zeros(graph.n, dtype=bool)
    inside[side] = True
    ends = inside[graph.edges]
    return math.fsum(graph.lengths[ends[:, 0] != ends[:, 1]].tolist())
