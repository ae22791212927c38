"""Effective resistance: a graph as a network of conductors, and how far apart its vertices are in it."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import scipy.sparse as sp
from numpy.typing import ArrayLike
from scipy.sparse.linalg import splu

from taut.graph import _elimination_kernels
from taut.graph.connectedness import components, connected
from taut.graph.core import Floats, Graph, Ints
from taut.graph.matrices import degrees

_PROMISE = 2.0**-40  # relative error above which a pair is computed again, alone and without any subtraction


def kirchhoff_index(graph: Graph) -> float:
    """Sum of the effective resistances of all pairs of vertices, n Σ 1/λ_k over the positive Laplacian eigenvalues.

    inf for a disconnected graph, 0 with fewer than two vertices.

    Raises
    ------
    ValueError
        The weights at a vertex sum to more than a float holds.

    Notes
    -----
    No eigenvalue is computed: one elimination and a sum of squares give it to a few ulps times n even where rounding
    would swallow small eigenvalues. Memory as the elimination's fill, time n times that at most.
    Source: Klein and Randić 1993; Gutman and Mohar 1996.

    >>> kirchhoff_index(Graph.from_edges(3, [(0, 1), (1, 2)]))
    4.0
    """
    if not connected(graph):
        return np.inf
    done = eliminate(graph)
    return float(_elimination_kernels.sum_of_resistances(done.start, done.columns, done.shares, done.pivots))


def effective_resistance(graph: Graph, pairs: ArrayLike) -> Floats:
    """Resistance between two vertices when every edge is a conductor of conductance `weight`.

    Parameters
    ----------
    pairs : (k, 2) vertices.

    Returns
    -------
    (k,) resistances in 1 / weight: 0 from a vertex to itself, inf between components.

    Raises
    ------
    IndexError
        A pair names a vertex that is not there.
    ValueError
        ``pairs`` are not pairs of whole numbers, or the weights at a vertex sum to more than a float holds.

    Notes
    -----
    One elimination serves all pairs. Pairs for which rounding may have cost more than 2⁻⁴⁰ of the result (a strong
    part behind a weak link, weights many magnitudes apart) are eliminated anew, each alone with its two vertices last:
    what remains is one edge, found without a single subtraction.
    Source: Klein and Randić, "Resistance distance", 1993.

    >>> effective_resistance(Graph.from_edges(3, [(0, 1), (1, 2), (0, 2)]), [(0, 1), (2, 2)]).round(4)
    array([0.6667, 0.    ])
    """
    ends = _checked_pairs(graph, pairs)
    labels = components(graph)
    done = eliminate(graph)
    left, right = done.rank[ends[:, 0]], done.rank[ends[:, 1]]
    out, doubt = _elimination_kernels.pair_resistances(done.start, done.columns, done.shares, done.pivots, left, right)
    apart = labels[ends[:, 0]] != labels[ends[:, 1]]
    out[apart] = np.inf
    for p in np.flatnonzero(~apart & (doubt > _PROMISE * out)):
        u, v = ends[p]
        out[p] = 1.0 / eliminate_in_order(graph, _with_last(done.order, u, v)).pivots[-2]
    return out


def resistance_matrix(graph: Graph) -> Floats:
    """Effective resistances of all pairs, (n, n): symmetric, 0 on the diagonal, inf between components.

    Raises
    ------
    ValueError
        The weights at a vertex sum to more than a float holds.

    Notes
    -----
    Vertices come back in the reverse order of an elimination: the resistances from a vertex follow from those between
    its neighbours. Time n times the fill of the elimination, at most n³/2.

    >>> resistance_matrix(Graph.from_edges(3, [(0, 1), (1, 2)], [1.0, 0.5]))[0]
    array([0., 1., 3.])
    """
    done = eliminate(graph)
    out = _elimination_kernels.all_resistances(done.start, done.columns, done.shares, done.pivots)
    return out[np.ix_(done.rank, done.rank)]


@dataclass(frozen=True, eq=False)
class Elimination:
    """A graph taken apart vertex by vertex, each replaced by edges among its neighbours (star to mesh).

    The Laplacian is Σ_k pivots[k] b_k b_kᵀ, with b_k one at the k-th vertex and minus ``shares`` at ``columns``.

    Parameters
    ----------
    order : (n,) vertices as they are eliminated.
    rank : (n,) place of each vertex in that order; ``columns`` are such places.
    start : (n + 1,) where the row of the k-th vertex begins in ``columns`` and ``shares``.
    columns : (fill,) neighbours at the time of elimination, ascending within a row, all later in the order.
    shares : (fill,) weight of that edge over the pivot; a row sums to 1.
    pivots : (n,) weighted degree at the time of elimination, 0 for the last vertex of each component.
    """

    order: Ints
    rank: Ints
    start: Ints
    columns: Ints
    shares: Floats
    pivots: Floats


def eliminate(graph: Graph) -> Elimination:
    """Eliminate all vertices in an order that keeps the fill small; edges of weight 0 are none.

    Raises
    ------
    ValueError
        The weights at a vertex sum to more than a float holds.

    Notes
    -----
    Weights are only added, multiplied and divided, and pivots are sums of weights, so every number keeps its relative
    accuracy whatever the weights (Grassmann, Taksar and Heyman 1985); a Cholesky factor loses weak links to
    cancellation.
    """
    return eliminate_in_order(graph, _filling_little(graph))


def eliminate_in_order(graph: Graph, order: Ints) -> Elimination:
    """Eliminate the vertices in the order given, a permutation of 0 … n − 1; see `eliminate`."""
    rank = np.empty(graph.n, dtype=np.int64)
    rank[order] = np.arange(graph.n)
    tail = np.repeat(np.arange(graph.n), np.diff(graph.indptr))
    degrees(graph)  # refuses weights whose sums overflow
    later = (rank[tail] < rank[graph.indices]) & (graph.weights > 0)
    tail, head, weights = rank[tail[later]], rank[graph.indices[later]], graph.weights[later]
    by_row = np.lexsort((head, tail))
    indptr = np.searchsorted(tail[by_row], np.arange(graph.n + 1)).astype(np.int64)
    return Elimination(order, rank, *_elimination_kernels.eliminate(indptr, head[by_row], weights[by_row]))


def _filling_little(graph: Graph) -> Ints:
    """Minimum-degree order of the vertices, from SuperLU (which has no way to order without factorising)."""
    if graph.m == 0:
        return np.arange(graph.n, dtype=np.int64)
    pattern = sp.csc_array((-np.ones(2 * graph.m), graph.indices, graph.indptr), shape=(graph.n, graph.n))
    regular = sp.csc_array(pattern + sp.diags_array(np.diff(graph.indptr) + 1.0))
    factor = splu(regular, "MMD_AT_PLUS_A", diag_pivot_thresh=0.0, options={"SymmetricMode": True})
    return np.argsort(factor.perm_c).astype(np.int64)


def _with_last(order: Ints, u: int, v: int) -> Ints:
    return np.append(order[(order != u) & (order != v)], [u, v])


def _checked_pairs(graph: Graph, pairs: ArrayLike) -> Ints:
    given = np.asarray(pairs)
    if given.size == 0:
        return np.empty((0, 2), dtype=np.int64)
    if given.ndim != 2 or given.shape[1] != 2 or given.dtype.kind not in "iu":
        raise ValueError(f"pairs must be (k, 2) whole numbers, got shape {given.shape} of {given.dtype}")
    wrong = np.flatnonzero(((given < 0) | (given >= graph.n)).any(axis=1))
    if len(wrong):
        u, v = given[wrong[0]]
        raise IndexError(f"pair {wrong[0]} is ({u}, {v}); the vertices are 0 … {graph.n - 1}")
    return given.astype(np.int64)
