"""Which edges to add, and which matter: λ2 after each of many changes, exactly, from one eigendecomposition.

An edge u-v of weight w adds w·b·bᵀ, b = e_u − e_v, to the Laplacian. The eigenvalues of such a rank-one update are the
roots of the secular equation 1 + w Σ (q_k·b)² / (λ_k − μ) = 0 (Golub, Some modified matrix eigenvalue problems, SIAM
Review 15, 1973). By interlacing the new λ2 lies between the old λ2 and λ3, so one bracketed root a candidate decides.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from taut.graph import _secular_kernels
from taut.graph.connectedness import components, cut_edges
from taut.graph.core import Floats, Graph, Ints, vertex_pairs
from taut.graph.spectral import Eigenpairs, algebraic_connectivity, eigenpairs

#: Values of λ2 that differ by less than this share of λ_max are equal.
TIE = 1e-12
# a stronger edge holds its ends together no better, as far as doubles can tell
_ENDLESS = 1e150


@dataclass(frozen=True)
class Addition:
    """An edge chosen among candidates.

    Parameters
    ----------
    candidate : its number among the candidates.
    edge : its vertices, i < j.
    weight : what it adds.
    before, after : λ2 without and with it.
    runner_up : number of the next best candidate, None if there was no other.
    runner_up_after : λ2 if that had been chosen.
    """

    candidate: int
    edge: tuple[int, int]
    weight: float
    before: float
    after: float
    runner_up: int | None
    runner_up_after: float | None


def connectivity_with(graph: Graph, candidates: ArrayLike, weights: ArrayLike | None = None) -> Floats:
    """λ2 after adding each candidate edge alone, (m,).

    Parameters
    ----------
    candidates : (m, 2) pairs of vertices; one that is an edge already makes it stronger.
    weights : (m,) > 0, by default 1.

    Raises
    ------
    ValueError
        A vertex out of range, a loop, a weight that is not positive, or unequal counts.

    Notes
    -----
    O(n³) once, then O(n) a candidate. Within 1e-12 λ_max of a decomposition of each changed graph.

    >>> path = Graph.from_edges(5, [(3, 1), (1, 0), (0, 2), (1, 4)])
    >>> connectivity_with(path, [(1, 2)], [3.0])
    array([1.])
    """
    pairs, values = _checked(graph, candidates, weights)
    return _with(eigenpairs(graph), pairs, values)


def connectivity_without(graph: Graph) -> Floats:
    """λ2 after removing each edge alone, (m,), in the order of ``graph.edges``; 0 for edges that hold it together.

    Notes
    -----
    O(n³) once, then O(n) an edge.
    """
    edges = graph.edges
    out = np.zeros(len(edges))
    parts = components(graph)
    if len(parts) == 0 or parts.max() > 0:
        return out
    cuts = cut_edges(graph)
    stays = ~np.isin(edges[:, 0] * graph.n + edges[:, 1], cuts[:, 0] * graph.n + cuts[:, 1])
    if stays.any():
        pairs = eigenpairs(graph)
        unit = float(pairs.values[-1])
        lost = graph.lengths[stays] / unit
        found = unit * _secular_kernels.losses(pairs.values / unit, _by_vertex(pairs), edges[stays], lost)
        # what is left is connected, so that only rounding can have made it 0
        out[stays] = np.maximum(found, np.finfo(np.float64).tiny)
    return out


def best_edges(
    graph: Graph, candidates: ArrayLike, weights: ArrayLike | None = None, count: int = 1
) -> tuple[Addition, ...]:
    """Choose ``count`` edges one after another, each time the candidate that raises λ2 most.

    Among values of λ2 within 1e-12 λ_max, one that leaves fewer components wins, then smaller vertex numbers. The
    choice is greedy: no set of edges is promised to be best. Arguments and errors as `connectivity_with`; fewer
    additions come back when the candidates run out.

    >>> path = Graph.from_edges(4, [(0, 1), (1, 2), (2, 3)])
    >>> best_edges(path, [(0, 2), (0, 3)])[0].edge
    (0, 3)
    """
    if count < 0:
        raise ValueError(f"count must be at least 0, got {count}")
    pairs, values = _checked(graph, candidates, weights)
    left = np.arange(len(pairs))
    chosen: list[Addition] = []
    while len(chosen) < count and len(left):
        decomposed = eigenpairs(graph)
        after = _with(decomposed, pairs[left], values[left])
        ranked = _ranked(decomposed, pairs[left], after)
        first = int(left[ranked[0]])
        second = int(left[ranked[1]]) if len(ranked) > 1 else None
        chosen.append(
            Addition(
                first,
                _edge(pairs[first]),
                float(values[first]),
                algebraic_connectivity(graph),
                float(after[ranked[0]]),
                second,
                None if second is None else float(after[ranked[1]]),
            )
        )
        graph = with_edge(graph, chosen[-1].edge, chosen[-1].weight)
        left = np.delete(left, ranked[0])
    return tuple(chosen)


def with_edge(graph: Graph, edge: tuple[int, int], weight: float) -> Graph:
    """Return the graph with one edge more, or with a stronger one if it is there already."""
    edges, weights = graph.edges, graph.lengths
    same = (edges == sorted(edge)).all(axis=1)
    if same.any():
        return Graph.from_edges(graph.n, edges, np.where(same, weights + weight, weights))
    return Graph.from_edges(graph.n, np.concatenate([edges, [edge]]), np.append(weights, weight))


def _with(decomposed: Eigenpairs, pairs: Ints, weights: Floats) -> Floats:
    labels = decomposed.labels
    if len(pairs) == 0 or labels.max() > 1:
        return np.zeros(len(pairs))
    values, vectors = decomposed.values, _by_vertex(decomposed)
    # in units of the largest eigenvalue, or of the weights where there is none, nothing over- or underflows
    unit = float(values[-1]) if len(values) else float(weights.max())
    values = values / unit
    gained = np.minimum(weights / unit, _ENDLESS)
    if labels.max() == 0:
        return unit * _secular_kernels.gains(values, vectors, pairs, gained)
    # of two components the null space has one vector besides the constant: a on one side, −b on the other
    out = np.zeros(len(pairs))
    joins = labels[pairs[:, 0]] != labels[pairs[:, 1]]
    n, other = len(labels), int(labels.sum())
    between = np.where(labels == 0, other, other - n) / np.sqrt(n * other * (n - other))
    values = np.append(0.0, values)
    vectors = np.ascontiguousarray(np.column_stack([between, vectors]))
    found = unit * _secular_kernels.gains(values, vectors, pairs[joins], gained[joins])
    # what is joined is connected, so that only rounding can have made it 0
    out[joins] = np.maximum(found, np.finfo(np.float64).smallest_subnormal)
    return out


def _by_vertex(decomposed: Eigenpairs) -> Floats:
    """Eigenvectors so that what belongs to one vertex lies together."""
    return np.ascontiguousarray(decomposed.vectors)


def _ranked(decomposed: Eigenpairs, pairs: Ints, after: Floats) -> Ints:
    """Numbers of the best candidate and of the next."""
    largest = float(decomposed.values[-1]) if len(decomposed.values) else 0.0
    joins = decomposed.labels[pairs[:, 0]] != decomposed.labels[pairs[:, 1]]
    low, high = pairs.min(axis=1), pairs.max(axis=1)
    left = np.arange(len(after))
    out: list[int] = []
    while len(left) and len(out) < 2:
        equal = left[after[left] >= after[left].max() - TIE * largest]
        best = equal[np.lexsort((high[equal], low[equal], ~joins[equal]))[0]]
        out.append(int(best))
        left = left[left != best]
    return np.array(out, dtype=np.int64)


def _edge(pair: Ints) -> tuple[int, int]:
    low, high = sorted(pair.tolist())
    return low, high


def _checked(graph: Graph, candidates: ArrayLike, weights: ArrayLike | None) -> tuple[Ints, Floats]:
    pairs = vertex_pairs(candidates, "candidates")
    values = np.ones(len(pairs)) if weights is None else np.array(weights, dtype=np.float64).reshape(-1)
    if len(values) != len(pairs):
        raise ValueError(f"{len(pairs)} candidates but {len(values)} weights")
    if len(pairs) and (pairs.min() < 0 or pairs.max() >= graph.n):
        raise ValueError(f"candidates name vertices outside 0 … {graph.n - 1}")
    if (pairs[:, 0] == pairs[:, 1]).any():
        raise ValueError("a candidate joins a vertex with itself")
    if not (np.isfinite(values).all() and (values > 0).all()):
        raise ValueError("weights of candidates must be finite and positive")
    return pairs, values
