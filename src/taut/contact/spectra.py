"""λ2 of the graphs of a team, piece after piece: many small graphs at once.

One BLAS thread is enough for small matrices, and gives the same bits everywhere. To ask for it takes as long as the
eigenvalues of fifty robots; so whoever solves many graphs asks once, by `one_thread`.
"""

from __future__ import annotations

from collections.abc import Sequence
from contextlib import AbstractContextManager

import numpy as np
from numpy.typing import NDArray
from threadpoolctl import threadpool_limits

from taut.contact._strength_kernels import parts
from taut.graph import Graph, algebraic_connectivity
from taut.scene import FloatArray

Ints = NDArray[np.int64]
Flags = NDArray[np.bool_]

_SMALL = 150
"""Robots up to which graphs are solved many at once."""

_BATCH = 2**22
"""Entries of the matrices solved at once."""


def one_thread() -> AbstractContextManager[object]:
    """Have BLAS use one thread in a ``with`` block."""
    limits: AbstractContextManager[object] = threadpool_limits(1, user_api="blas")
    return limits


def fiedler_values(present: Flags, pairs: Ints, spans: Ints) -> FloatArray:
    """(m,) λ2 of each of m graphs on the same n vertices, not all of which are always there; links weigh 1.

    0 for fewer than two vertices and where they are not connected, else positive; as exact as `fiedler_of_each`.
    Graphs that are equal are solved once.

    Parameters
    ----------
    present : (m, n) whether a vertex belongs to a graph.
    pairs : (l, 2) links.
    spans : (l, 2) the graphs that have the link: the first, and the one after the last.
    """
    out = np.zeros(len(present))
    ends, pair_of = np.unique(pairs, axis=0, return_inverse=True)
    changes = np.concatenate([spans[:, 0], spans[:, 1]])
    order = np.argsort(changes, kind="stable")
    changing = np.concatenate([pair_of, pair_of]).astype(np.int64)[order]
    border = np.searchsorted(changes[order], np.arange(len(present) + 1))
    linked = np.zeros(len(ends), dtype=np.bool_)
    same: dict[bytes, dict[bytes, list[int]]] = {}
    for piece, there in enumerate(present):
        for pair in changing[border[piece] : border[piece + 1]]:
            linked[pair] = not linked[pair]
        same.setdefault(there.tobytes(), {}).setdefault(np.packbits(linked).tobytes(), []).append(piece)
    for who, graphs in same.items():
        there = np.frombuffer(who, dtype=np.bool_)
        number = np.cumsum(there) - 1
        packed = [np.frombuffer(graph, dtype=np.uint8) for graph in graphs]
        links = [number[ends[np.unpackbits(bits, count=len(ends)).astype(np.bool_)]] for bits in packed]
        with one_thread():
            values = fiedler_of_each(int(there.sum()), links)
        for pieces, value in zip(graphs.values(), values, strict=True):
            out[pieces] = value
    return out


def fiedler_of_each(n: int, links: Sequence[Ints], weights: Sequence[FloatArray] | None = None) -> FloatArray:
    """λ2 of graphs on n vertices given by their links (m, 2), no link twice, and weights (m,), 1 by default.

    0 for fewer than two vertices and where they are not connected by links of positive weight. Within 1e-12 of the
    greatest eigenvalue. To be called with `one_thread`.

    >>> fiedler_of_each(3, [np.array([[0, 1], [1, 2]]), np.array([[0, 1]])]).round(12).tolist()
    [1.0, 0.0]
    """
    values = [np.ones(len(pairs)) for pairs in links] if weights is None else weights
    out = np.zeros(len(links))
    whole = [
        k for k, (pairs, each) in enumerate(zip(links, values, strict=True)) if not parts(n, pairs[each > 0]).any()
    ]
    if n < 2:
        return out
    if n > _SMALL:
        out[whole] = [algebraic_connectivity(Graph.from_edges(n, links[k], values[k])) for k in whole]
        return out
    size = max(1, _BATCH // n**2)
    for first in range(0, len(whole), size):
        chunk = whole[first : first + size]
        matrices = np.zeros((len(chunk), n, n))
        for matrix, k in zip(matrices, chunk, strict=True):
            i, j = links[k].T
            matrix[i, j] = matrix[j, i] = -values[k]
        matrices[:, range(n), range(n)] = -matrices.sum(axis=2)
        # With resistances along a spanning tree, λ2 ≥ 2 w / (n − 1)², w the least weight.
        least = [values[k][values[k] > 0].min() * 2.0 / (n - 1) ** 2 for k in chunk]
        out[chunk] = np.maximum(np.linalg.eigvalsh(matrices)[:, 1], least)
    return out
