"""Graph: an undirected weighted graph as CSR arrays."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from taut.graph import _kernels

Floats = NDArray[np.float64]
Ints = NDArray[np.int64]


def vertex_pairs(values: ArrayLike, what: str) -> Ints:
    """Return pairs of vertices as an array (m, 2).

    Raises
    ------
    ValueError
        They are not pairs, or not whole numbers.
    """
    given = np.asarray(values)
    if given.size == 0:
        return np.empty((0, 2), dtype=np.int64)
    if given.ndim != 2 or given.shape[1] != 2:
        raise ValueError(f"{what} must be pairs of vertices, (m, 2), got shape {given.shape}")
    pairs = given.astype(np.int64)
    if not (pairs == given).all():
        raise ValueError(f"{what} must name vertices by whole numbers")
    return np.ascontiguousarray(pairs)


@dataclass(frozen=True, eq=False)
class Graph:
    """An undirected graph without loops or parallel edges, in compressed sparse rows.

    Parameters
    ----------
    indptr : (n + 1,) where each vertex' neighbours begin in ``indices``.
    indices : (2 m,) neighbours, ascending within a row; every edge stands in both rows.
    weights : (2 m,) weight of each entry, ≥ 0.

    >>> Graph.from_edges(3, [(0, 1), (1, 2)], [1.0, 2.0]).m
    2
    """

    indptr: Ints
    indices: Ints
    weights: Floats

    @classmethod
    def from_edges(cls, n: int, edges: ArrayLike, weights: ArrayLike | None = None) -> Graph:
        """Build from n vertices and (m, 2) pairs in any order; weights default to 1.

        Raises
        ------
        ValueError
            Not pairs of whole numbers, a vertex out of range, a loop, an edge given twice, a negative or non-finite
            weight, or unequal counts.
        """
        pairs = vertex_pairs(edges, "edges")
        if n != int(n) or n < 0:
            raise ValueError(f"a graph has a whole number of vertices, at least 0, not {n}")
        values = np.ones(len(pairs)) if weights is None else np.asarray(weights, dtype=np.float64).reshape(-1)
        if len(values) != len(pairs):
            raise ValueError(f"{len(pairs)} edges but {len(values)} weights")
        if len(pairs) and (pairs.min() < 0 or pairs.max() >= n):
            raise ValueError(f"edges name vertices outside 0 … {n - 1}")
        if (pairs[:, 0] == pairs[:, 1]).any():
            raise ValueError("an edge joins a vertex with itself")
        if not (np.isfinite(values).all() and (values >= 0).all()):
            raise ValueError("weights must be finite and not negative")
        indptr, indices, both, twice = _kernels.compressed(int(n), pairs, values)
        if twice >= 0:
            raise ValueError("an edge is given twice")
        return cls(indptr, indices, both)

    @property
    def n(self) -> int:
        """Number of vertices."""
        return len(self.indptr) - 1

    @property
    def m(self) -> int:
        """Number of edges."""
        return len(self.indices) // 2

    @property
    def edges(self) -> Ints:
        """(m, 2) pairs i < j, sorted."""
        tail = np.repeat(np.arange(self.n), np.diff(self.indptr))
        upper = tail < self.indices
        return np.stack([tail[upper], self.indices[upper]], axis=1)

    @property
    def lengths(self) -> Floats:
        """Weights in the order of `edges`, (m,)."""
        tail = np.repeat(np.arange(self.n), np.diff(self.indptr))
        return self.weights[tail < self.indices]
