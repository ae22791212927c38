"""Cutting a graph in two: groups of vertices contracted, sides by the Fiedler vector, every side in one piece."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import ArrayLike, NDArray

from taut.graph.connectedness import components
from taut.graph.core import Floats, Graph, Ints
from taut.graph.spectral import fiedler_vector

Bools = NDArray[np.bool_]

_ON_THE_LINE = 1e-9


def contracted(graph: Graph, groups: ArrayLike) -> Graph:
    """Return the graph in which each group is one vertex: parallel edges are summed, edges inside groups vanish.

    Parameters
    ----------
    groups : (n,) number of each vertex' group, 0 … k − 1.

    Raises
    ------
    ValueError
        Not one group a vertex, or a negative number.

    >>> square = Graph.from_edges(4, [(0, 1), (1, 2), (2, 3), (3, 0)])
    >>> contracted(square, [0, 0, 1, 1]).lengths
    array([2.])
    """
    given = np.asarray(groups).reshape(-1)
    group = given.astype(np.int64)
    if len(group) != graph.n or not (group == given).all() or (graph.n and group.min() < 0):
        raise ValueError(f"groups must give each of the {graph.n} vertices a whole number from 0 on")
    count = int(group.max()) + 1 if graph.n else 0
    ends = np.sort(group[graph.edges], axis=1)
    between = ends[:, 0] != ends[:, 1]
    keys, where = np.unique(ends[between, 0] * count + ends[between, 1], return_inverse=True)
    sums = np.bincount(where, weights=graph.lengths[between], minlength=len(keys))
    return Graph.from_edges(count, np.stack([keys // max(count, 1), keys % max(count, 1)], axis=1), sums)


def split(graph: Graph, towards: Sequence[Floats] | None = None) -> Bools:
    """Cut a graph into two sides, (n,) False or True; of a connected graph each side is connected.

    The side of a vertex is the sign of its entry in the Fiedler vector, signed and chosen ``towards`` the arrays (see
    `fiedler_vector`): values ≥ −1e-9 are True, and pieces of a side that are not its largest go over to the other. A
    graph that is not connected is not cut: its components are gathered into two sides of like size, the largest True.

    Notes
    -----
    Source: Fiedler, A property of eigenvectors of nonnegative symmetric matrices, Czech. Math. J. 25, 1975.
    """
    if graph.n < 2:
        return np.ones(graph.n, dtype=np.bool_)
    parts = components(graph)
    if parts.max() > 0:
        return gathered(parts)
    return in_one_piece(graph, fiedler_vector(graph, towards) >= -_ON_THE_LINE)


def gathered(parts: Ints) -> Bools:
    """Gather components into two sides, the larger first and each to the side with fewer vertices, (n,).

    >>> gathered(np.array([0, 1, 1, 2])).tolist()
    [False, True, True, False]
    """
    sizes = np.bincount(parts)
    true = np.zeros(len(sizes), dtype=np.bool_)
    count = [0, 0]
    for part in np.argsort(-sizes, kind="stable").tolist():
        true[part] = count[1] <= count[0]
        count[int(true[part])] += int(sizes[part])
    return true[parts]


def in_one_piece(graph: Graph, side: Bools) -> Bools:
    """Move the pieces of each side that are not its largest to the other; of a connected graph both become connected.

    Of pieces of equal size the one with the smallest vertex stays.

    Raises
    ------
    ValueError
        Not one side a vertex.
    """
    out = np.array(side, dtype=np.bool_)
    if out.shape != (graph.n,):
        raise ValueError(f"side must tell for each of the {graph.n} vertices, got shape {out.shape}")
    for value in (True, False):
        members = np.flatnonzero(out == value)
        if len(members) == 0:
            continue
        inside = np.full(graph.n, -1, dtype=np.int64)
        inside[members] = np.arange(len(members))
        edges = graph.edges
        kept = (inside[edges] >= 0).all(axis=1)
        pieces = components(Graph.from_edges(len(members), inside[edges[kept]], graph.lengths[kept]))
        out[members[pieces != np.argmax(np.bincount(pieces))]] = not value
    return out
