"""Rigidity in the plane: of graphs (generic, by the pebble game) and of frameworks (infinitesimal, by rank).

Every edge is a bar of fixed length between two hinges, whatever its weight, also 0. What is *generic* holds for almost
all positions and depends on the graph alone; a framework, a graph with positions, may be worse in special positions.
"""

from __future__ import annotations

from typing import Literal, TypeAlias

import numpy as np
from numpy.typing import ArrayLike, NDArray
from scipy.linalg import null_space
from scipy.sparse import csr_array
from threadpoolctl import threadpool_limits

from taut.graph import _rigidity_kernels as _kernels
from taut.graph.core import Floats, Graph

Bools: TypeAlias = NDArray[np.bool_]


def generic_rank(graph: Graph) -> int:
    """Rank of the rigidity matroid: the number of bars that count, at most 2 n − 3 (0 for n < 2).

    It is the rank of the rigidity matrix at almost all positions. O(n m), see `independent_edges`.

    >>> generic_rank(Graph.from_edges(4, [(0, 1), (0, 2), (0, 3), (1, 2), (1, 3), (2, 3)]))
    5
    """
    return int(independent_edges(graph).sum())


def independent_edges(graph: Graph) -> Bools:
    """Which edges the pebble game keeps, (m,) in the order of ``graph.edges``.

    An edge is kept iff its length is not already determined, generically, by the edges before it. The kept edges are
    a basis of the rigidity matroid: each k of their vertices span at most 2 k − 3 of them (Laman 1970).

    Notes
    -----
    O(n m). Jacobs and Hendrickson, "An algorithm for two-dimensional rigidity percolation: the pebble game", Journal
    of Computational Physics 137, 1997.
    """
    return _kernels.pebble_game(graph.n, graph.edges)[0]


def redundant_edges(graph: Graph) -> Bools:
    """Which edges can be removed, one at a time, without loss of generic rank, (m,) in the order of ``graph.edges``.

    These are the edges that lie in some circuit of the rigidity matroid. The circuits of the edges that the pebble
    game rejects, each with the kept edges, cover all of them, so one game decides for every edge. O(n m).
    """
    return _kernels.pebble_game(graph.n, graph.edges)[1]


def generic_rigid(graph: Graph) -> bool:
    """Whether the graph is rigid at almost all positions: generic rank 2 n − 3.

    No vertex or one is rigid; two are iff they are joined.

    >>> generic_rigid(Graph.from_edges(4, [(0, 1), (1, 2), (2, 3), (3, 0)]))
    False
    """
    return generic_rank(graph) == _full_rank(graph.n)


def generic_minimally_rigid(graph: Graph) -> bool:
    """Whether the graph is rigid and no edge can be spared (a Laman graph: rigid with exactly 2 n − 3 edges).

    No vertex or one is minimally rigid.
    """
    return graph.m == _full_rank(graph.n) and bool(independent_edges(graph).all())


def generic_redundantly_rigid(graph: Graph) -> bool:
    """Whether the graph is rigid and stays so without any one of its edges.

    No vertex or one has no edge to lose and is redundantly rigid; two or three vertices never are. O(n m), by one
    pebble game: see `redundant_edges`.
    """
    independent, in_circuit = _kernels.pebble_game(graph.n, graph.edges)
    return int(independent.sum()) == _full_rank(graph.n) and bool(in_circuit.all())


def generic_globally_rigid(graph: Graph) -> bool:
    """Whether, at almost all positions, the lengths of the edges determine all distances.

    Up to three vertices: complete graphs. From four on: 3-connected and redundantly rigid. O(n (n + m)).

    Notes
    -----
    Jackson and Jordán, "Connected rigidity matroids and unique realizations of graphs", Journal of Combinatorial
    Theory B 94, 2005.
    """
    if graph.n <= 3:
        return graph.m == graph.n * (graph.n - 1) // 2
    return generic_redundantly_rigid(graph) and vertex_connected(graph, 3)


def vertex_connected(graph: Graph, k: Literal[1, 2, 3]) -> bool:
    """Whether the graph has more than k vertices and stays connected without any k − 1 of them.

    Every edge counts, also of weight 0. O(n + m) for k = 1 and 2, O(n (n + m)) for 3.

    Raises
    ------
    ValueError
        ``k`` is not 1, 2 or 3.
    """
    if k not in (1, 2, 3):
        raise ValueError(f"vertex connectivity is decided for k = 1, 2 or 3, not {k}")
    if graph.n <= k:
        return False
    if k < 3:
        return _kernels.hold(graph.indptr, graph.indices, -1) >= k
    return all(_kernels.hold(graph.indptr, graph.indices, v) == 2 for v in range(graph.n))


def rigidity_matrix(graph: Graph, positions: ArrayLike) -> csr_array[np.float64]:
    """The rigidity matrix of a framework, m × 2 n, with columns x0, y0, x1, y1 and so on.

    The row of edge (i, j) holds p_i − p_j at i and p_j − p_i at j, metres: times the velocities of the vertices it is
    half the rate of change of the squared length of the edge. ``positions`` is (n, 2).

    Raises
    ------
    ValueError
        Positions that are not (n, 2) finite numbers.
    """
    points = _checked(graph, positions)
    i, j = graph.edges.T
    across = points[i] - points[j]
    columns = np.stack([2 * i, 2 * i + 1, 2 * j, 2 * j + 1], axis=1)
    entries = np.concatenate([across, -across], axis=1)
    rows = 4 * np.arange(graph.m + 1)
    return csr_array((entries.ravel(), columns.ravel(), rows), shape=(graph.m, 2 * graph.n))


def infinitesimally_rigid(graph: Graph, positions: ArrayLike) -> bool:
    """Whether every motion that keeps all edge lengths to first order is a translation or rotation of the whole.

    True iff the rigidity matrix has rank 2 n − 3 (no vertex or one: always). It implies that the framework is rigid;
    the converse fails in special positions only.

    Raises
    ------
    ValueError
        Positions that are not (n, 2) finite numbers.

    Notes
    -----
    The rank is numerical: the singular values above max(m, 2 n)·ε·σ_max of the matrix whose rows are scaled to unit
    length (ε = 2⁻⁵²; a row of coinciding ends is 0). So size and place of the framework do not matter, and frameworks
    nearer to a special position than rounding can tell count as flexible. Dense: O(m n²).

    >>> square = Graph.from_edges(4, [(0, 1), (1, 2), (2, 3), (3, 0), (0, 2)])
    >>> infinitesimally_rigid(square, [(0, 0), (1, 0), (1, 1), (0, 1)])
    True
    """
    rows = _unit_rows(graph, _checked(graph, positions))
    with threadpool_limits(1, user_api="blas"):
        rank = int(np.linalg.matrix_rank(rows))
    return rank == _full_rank(graph.n)


def infinitesimal_motions(graph: Graph, positions: ArrayLike) -> Floats:
    """Orthonormal basis of the velocities that keep all edge lengths to first order and move the shape, (2 n, k).

    Rows are x0, y0, x1, y1, …; ``motions[:, k].reshape(-1, 2)`` are the velocities of the vertices in motion k. All
    are orthogonal to translations and rotations of the whole. k = 0 iff `infinitesimally_rigid`. The signs, and for
    k > 1 the choice of basis, have no meaning.

    Raises
    ------
    ValueError
        Positions that are not (n, 2) finite numbers.
    """
    points = _checked(graph, positions)
    if graph.n < 2:
        return np.empty((2 * graph.n, 0))
    with threadpool_limits(1, user_api="blas"):
        flexes = null_space(_unit_rows(graph, points))
    whole = _motions_of_the_whole(points)
    basis, _ = np.linalg.qr(flexes.T @ whole, mode="complete")
    motions: Floats = flexes @ basis[:, whole.shape[1] :]
    return motions


def _full_rank(n: int) -> int:
    return max(2 * n - 3, 0)


def _checked(graph: Graph, positions: ArrayLike) -> Floats:
    points = np.asarray(positions, dtype=np.float64)
    if graph.n == 0 and points.size == 0:
        return np.empty((0, 2))
    if points.shape != (graph.n, 2):
        raise ValueError(f"positions must be one row [x, y] for each of {graph.n} vertices, got shape {points.shape}")
    bad = np.flatnonzero(~np.isfinite(points).all(axis=1))
    if bad.size:
        raise ValueError(f"the position of vertex {bad[0]} is not finite")
    return points


def _unit_rows(graph: Graph, points: Floats) -> Floats:
    """Rigidity matrix with rows of unit length, dense; a row of coinciding ends is 0."""
    i, j = graph.edges.T
    near = _scaled(points)
    across = near[i] - near[j]
    length = np.hypot(*across.T)
    unit = across / np.where(length > 0, length, 1.0)[:, None] / np.sqrt(2.0)
    rows = np.zeros((graph.m, graph.n, 2))
    bars = np.arange(graph.m)
    rows[bars, i], rows[bars, j] = unit, -unit
    return rows.reshape(graph.m, 2 * graph.n)


def _motions_of_the_whole(points: Floats) -> Floats:
    """Orthonormal translations and, unless all points coincide, the rotation about their centre, (2 n, 2 or 3)."""
    n = len(points)
    shape = _scaled(points)
    shape = _scaled(shape - shape[0])
    shape = shape - shape.mean(axis=0)
    turn = np.stack([-shape[:, 1], shape[:, 0]], axis=1).ravel()
    moves = np.kron(np.full((n, 1), 1 / np.sqrt(n)), np.eye(2))
    return np.column_stack([moves, turn / np.linalg.norm(turn)]) if turn.any() else moves


def _scaled(points: Floats) -> Floats:
    """Bring the largest coordinate below 1 by a power of two, which rounds nothing and lets nothing overflow."""
    _, exponent = np.frexp(np.abs(points).max(initial=0.0))
    near: Floats = np.ldexp(points, -exponent)
    return near
