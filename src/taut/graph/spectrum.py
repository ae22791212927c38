"""The spectrum of a graph: eigenvalues of its Laplacian, λ2 and the Fiedler vector.

Whether an eigenvalue is zero is decided by components, never by its size. Small graphs go through dense LAPACK, larger
ones through Lanczos' method in a few vectors of memory. All run on one BLAS thread: no slower on a busy machine, and
the same bits with any number of threads.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Iterator
from dataclasses import dataclass
from itertools import chain
from typing import TypeAlias

import numpy as np
from numpy.typing import ArrayLike
from scipy import linalg, sparse
from scipy.sparse.csgraph import minimum_spanning_tree, reverse_cuthill_mckee
from scipy.sparse.linalg import splu
from threadpoolctl import threadpool_limits

from taut.graph.components import components
from taut.graph.core import Floats, Graph, Ints
from taut.graph.matrices import Matrix, degrees, laplacian

_DENSE = 1000  # most vertices for which λ2 and the Fiedler vector come from dense LAPACK
_REPEATED = 1e-12  # in λ_max: eigenvalues so near λ2 count as λ2
_ORTHOGONAL = 1e-9  # a projection shorter than this part of its array is none

Projector: TypeAlias = Callable[[Floats], Floats]


@dataclass(frozen=True, eq=False)
class Eigenpairs:
    """The positive eigenvalues of a Laplacian with their eigenvectors; c is the number of components.

    Parameters
    ----------
    values : (n − c,) ascending, all > 0.
    vectors : (n, n − c) orthonormal columns; each lives on one component and sums to zero there.
    labels : (n,) component of each vertex, as `components`.
    """

    values: Floats
    vectors: Floats
    labels: Ints


def spectrum(graph: Graph) -> Floats:
    """(n,) all eigenvalues of the Laplacian, ascending.

    As many are exactly zero as there are components; all others are positive. Errors are near n·eps·λ_max. Takes
    O(k³) time and O(k²) memory for components of k vertices.

    Raises
    ------
    ValueError
        The weights are so large that eigenvalues could overflow.

    >>> spectrum(Graph.from_edges(3, [(0, 1), (0, 2), (1, 2)])).round(12).tolist()
    [0.0, 3.0, 3.0]
    """
    scaled, exponent = _scaled(graph)
    values = np.zeros(graph.n)
    begin = 0
    with threadpool_limits(1, user_api="blas"):
        for members in _parts(components(graph)):
            end = begin + len(members) - 1
            if end > begin:
                found = linalg.eigvalsh(_without_constant(_dense_laplacian(scaled, members)))
                values[begin:end] = _positive(found, exponent, graph, members)
            begin = end
    return np.sort(values)


def eigenpairs(graph: Graph) -> Eigenpairs:
    """Positive eigenvalues and orthonormal eigenvectors of the Laplacian, component by component.

    The constant vector of each component is known exactly: a reflection takes it out of the matrix before LAPACK sees
    it, so that small eigenvalues are not mixed with zero. Residuals and loss of orthogonality are a few eps (times
    λ_max). Takes O(k³) time for components of k vertices, and O(n²) memory.

    Raises
    ------
    ValueError
        The weights are so large that eigenvalues could overflow.

    >>> eigenpairs(Graph.from_edges(3, [(0, 1), (0, 2), (1, 2)])).values.round(12).tolist()
    [3.0, 3.0]
    """
    scaled, exponent = _scaled(graph)
    labels = components(graph)
    parts = _parts(labels)
    values = np.zeros(graph.n - len(parts))
    vectors = np.zeros((graph.n, graph.n - len(parts)))
    begin = 0
    with threadpool_limits(1, user_api="blas"):
        for members in parts:
            end = begin + len(members) - 1
            if end > begin:
                found, vectors[members, begin:end] = _dense_pairs(_dense_laplacian(scaled, members))
                values[begin:end] = _positive(found, exponent, graph, members)
            begin = end
    order = np.argsort(values, kind="stable")
    return Eigenpairs(values[order], vectors[:, order], labels)


def algebraic_connectivity(graph: Graph) -> float:
    """λ2, the second smallest eigenvalue of the Laplacian (Fiedler 1973): how well the graph holds together.

    Exactly 0.0 for graphs of several components, and of fewer than two vertices, which have no second eigenvalue; else
    positive. The error is at most 1e-12 λ_max.

    Raises
    ------
    ValueError
        The weights are so large that eigenvalues could overflow.

    Notes
    -----
    Up to 1,000 vertices dense LAPACK, beyond Lanczos' method: on an inverse where elimination fills little, as on maps,
    else on the Laplacian itself, which suits graphs that expand. The residual is verified, and the other way is the
    fallback. On one core, 10,000 vertices and 80,000 edges take 0.2 s where neighbours are joined, 0.3 s in a random
    16-regular graph (whose elimination would take minutes and a gigabyte).

    Where rounding hides a small λ2 it is raised to 2 / ((n − 1) Σ 1/w), the sum over a maximum-weight spanning tree:
    with the effective resistances R_ij ≤ Σ 1/w, λ2 ≥ n / Σ_{i<j} R_ij.

    >>> round(algebraic_connectivity(Graph.from_edges(3, [(0, 1), (1, 2)])), 12)
    1.0
    """
    if graph.n < 2 or components(graph).any():
        return 0.0
    scaled, exponent = _scaled(graph)
    with threadpool_limits(1, user_api="blas"):
        value = _dense_least(scaled) if graph.n <= _DENSE else _sparse_least(scaled)
    return float(_positive(np.array([value]), exponent, graph, np.arange(graph.n))[0])


def fiedler_vector(graph: Graph, towards: Iterable[ArrayLike] | None = None) -> Floats:
    """(n,) the unit eigenvector of λ2 nearest a given array: made definite, also where λ2 is repeated.

    Eigenvalues within 1e-12 λ_max of λ2 count as λ2. The vector is the projection onto their space of the first array
    that is not orthogonal to it (1e-9 of its length), so its product with that array is positive. A disconnected graph
    has λ2 = 0: the vector is constant on each component.

    Parameters
    ----------
    towards : arrays (n,), such as the x and then the y coordinates of the vertices; by default the vertex numbers. The
        unit vectors of vertex 0, 1, … follow them.

    Raises
    ------
    ValueError
        Fewer than two vertices; an array of another shape or not finite; weights so large that eigenvalues could
        overflow.

    >>> fiedler_vector(Graph.from_edges(3, [(0, 1), (1, 2)])).round(3).tolist()
    [-0.707, -0.0, 0.707]
    """
    if graph.n < 2:
        raise ValueError(f"a graph of {graph.n} vertices has no Fiedler vector: it takes two")
    given = [np.arange(graph.n)] if towards is None else list(towards)
    arrays = [_towards(array, k, graph.n) for k, array in enumerate(given)]
    scaled, _ = _scaled(graph)
    with threadpool_limits(1, user_api="blas"):
        project = _projector(scaled, components(graph))
        for array in chain(arrays, _units(graph.n)):
            nearest = project(array - array.mean())
            length = float(np.linalg.norm(nearest))
            if length > _ORTHOGONAL * np.linalg.norm(array):
                return nearest / length
    raise AssertionError("the unit vectors span every space")


def _towards(array: ArrayLike, k: int, n: int) -> Floats:
    """Return the array scaled to entries of at most 1."""
    values = np.asarray(array, dtype=np.float64)
    if values.shape != (n,):
        raise ValueError(f"towards[{k}] has shape {values.shape}: give {n} numbers, as in towards=positions.T")
    if not np.isfinite(values).all():
        raise ValueError(f"towards[{k}] is not finite at vertex {int(np.argmin(np.isfinite(values)))}")
    largest = np.abs(values).max()
    return values / largest if largest > 0 else values


def _units(n: int) -> Iterator[Floats]:
    for k in range(n):
        unit = np.zeros(n)
        unit[k] = 1.0
        yield unit


def _parts(labels: Ints) -> list[Ints]:
    """Return the vertices of each component, ascending."""
    order = np.argsort(labels, kind="stable")
    return np.split(order, np.flatnonzero(np.diff(labels[order])) + 1) if len(order) else []


def _scaled(graph: Graph) -> tuple[Graph, int]:
    """Return the graph with weights near 1, and the power of two they were divided by."""
    if not (degrees(graph) <= np.finfo(np.float64).max / 4).all():
        raise ValueError("weights near the largest float64: the eigenvalues could overflow, so scale the weights down")
    exponent = math.frexp(graph.weights.max(initial=0.0))[1]
    return Graph(graph.indptr, graph.indices, np.ldexp(graph.weights, -exponent)), exponent


def _positive(values: Floats, exponent: int, graph: Graph, members: Ints) -> Floats:
    """Undo the scaling; raise what rounding made too small to the lower bound of a connected graph's λ2."""
    before = np.full(graph.n, -1)
    before[members] = np.arange(len(members))
    edges = before[graph.edges]
    inside = (edges[:, 0] >= 0) & (graph.lengths > 0)
    ends, weights = edges[inside], graph.lengths[inside]
    # SciPy takes an entry of zero for no edge; negative weights also make its minimum the maximum.
    links = sparse.csr_array((-weights, (ends[:, 0], ends[:, 1])), shape=(len(members), len(members)))
    tree = -minimum_spanning_tree(links).data
    least = tree.min()
    bound = 2 * least / ((len(members) - 1) * (least / tree).sum())
    return np.maximum(np.ldexp(values, exponent), max(bound, np.finfo(np.float64).smallest_subnormal))


def _projector(graph: Graph, labels: Ints) -> Projector:
    """Return the projection of centred arrays onto the eigenspace of λ2."""
    if labels.any():
        sizes = np.bincount(labels)
        return lambda array: (np.bincount(labels, weights=array) / sizes)[labels]
    if graph.n <= _DENSE:
        return _dense_projector(graph)
    return _sparse_projector(graph)


# ---- dense ----


def _dense_laplacian(graph: Graph, members: Ints) -> Floats:
    matrix = laplacian(graph)
    if len(members) < graph.n:
        matrix = matrix[members][:, members]
    return matrix.toarray()


def _without_constant(matrix: Floats) -> Floats:
    """Return the Laplacian on the space orthogonal to the constant vector, (n − 1, n − 1).

    The Householder reflection H that takes the constant unit vector to −e_0 makes H L H zero in its first row and
    column. L kills the constant, so the rest is L less t (L_i0 + L_0j) plus t² L_00, with t = 1 / (√n + 1).
    """
    t = 1 / (math.sqrt(len(matrix)) + 1)
    first = t * matrix[0, 1:]
    return matrix[1:, 1:] - (first[:, None] + first) + t * t * matrix[0, 0]


def _with_constant(vectors: Floats) -> Floats:
    """Reflect vectors on the space of `_without_constant`, (n − 1, k), back to all vertices, (n, k)."""
    n = len(vectors) + 1
    sums = vectors.sum(axis=0)
    return np.concatenate([-sums[None] / math.sqrt(n), vectors - sums / (n + math.sqrt(n))])


def _dense_pairs(matrix: Floats) -> tuple[Floats, Floats]:
    """Return the positive eigenvalues and the eigenvectors of a connected graph's Laplacian."""
    # Divide and conquer keeps vectors orthogonal to some 10 eps; the default driver only to thousands of eps.
    values, vectors = linalg.eigh(_without_constant(matrix), driver="evd")
    return values, _with_constant(vectors)


def _dense_least(graph: Graph) -> float:
    matrix = _without_constant(_dense_laplacian(graph, np.arange(graph.n)))
    return float(linalg.eigh(matrix, eigvals_only=True, subset_by_index=[0, 0])[0])


def _dense_projector(graph: Graph) -> Projector:
    values, vectors = _dense_pairs(_dense_laplacian(graph, np.arange(graph.n)))
    space = vectors[:, values <= values[0] + _REPEATED * values[-1]]
    return lambda array: space @ (space.T @ array)


# ---- sparse ----

_Apply: TypeAlias = Callable[[Floats], Floats]

_ACCURACY = 2.0**-50  # residual, in the operator's largest eigenvalue, at which Lanczos' method stops
_VERIFIED = 1e-13  # residual, in λ_max, at which a result is accepted
_DIRECT_STEPS = 2000
_INVERSE_STEPS = 300


@dataclass(frozen=True, eq=False)
class _Way:
    """An operator on centred arrays whose largest eigenvalues belong to the smallest of a Laplacian.

    ``apply`` has the eigenvalue ``image(λ)`` where the Laplacian has λ; ``steps`` is how many Lanczos steps are tried.
    """

    apply: _Apply
    image: Callable[[float], float]
    steps: int


@dataclass(frozen=True, eq=False)
class _Least:
    """λ2 of a large graph, a vector of it, and the way they were found."""

    value: float
    vector: Floats
    way: _Way


def _sparse_least(graph: Graph) -> float:
    matrix = laplacian(graph)
    found = _least(graph, matrix, _largest(matrix))
    return _dense_least(graph) if found is None else found.value


def _sparse_projector(graph: Graph) -> Projector:
    """Project by Lanczos' method begun at the array itself, for which a repeated eigenvalue is a simple one."""
    matrix = laplacian(graph)
    largest = _largest(matrix)
    found = _least(graph, matrix, largest)
    if found is None:
        return _dense_projector(graph)
    floor = found.way.image(found.value + _REPEATED * largest)

    def project(array: Floats) -> Floats:
        if not array.any():
            return array
        nearest = _filtered(found.way.apply, array, floor, found.way.steps)
        if np.linalg.norm(nearest) <= _ORTHOGONAL * np.linalg.norm(array):
            return np.zeros_like(array)
        unit = nearest / np.linalg.norm(nearest)
        if np.linalg.norm(matrix @ unit - found.value * unit) > 2 * _REPEATED * largest:
            return _dense_projector(graph)(array)
        return nearest

    return project


def _least(graph: Graph, matrix: Matrix, largest: float) -> _Least | None:
    """Find λ2 of a connected graph, or None where no way reached the accuracy."""
    ways = [_inverse, _direct] if _narrow(matrix) else [_direct, _inverse]
    for make in ways:
        way = make(matrix, largest)
        vector = _filtered(way.apply, _start(graph.n), None, way.steps)
        vector = vector / np.linalg.norm(vector)
        value = _rayleigh_quotient(graph, vector)
        if np.linalg.norm(matrix @ vector - value * vector) <= _VERIFIED * largest:
            return _Least(value, vector, way)
    return None


def _narrow(matrix: Matrix) -> bool:
    """Whether elimination fills little: some order has a mean bandwidth like that of a planar graph, of order √n."""
    n = matrix.shape[0]
    place = np.empty(n, dtype=np.int64)
    place[reverse_cuthill_mckee(matrix, symmetric_mode=True)] = np.arange(n)
    entries = matrix.tocoo()
    first = np.arange(n)
    np.minimum.at(first, place[entries.row], place[entries.col])
    return bool((np.arange(n) - first).mean() <= 10 * math.sqrt(n))


def _direct(matrix: Matrix, largest: float) -> _Way:
    """No inversion: 2 d_max − L, positive definite."""
    ceiling = 2 * matrix.diagonal().max()
    return _Way(lambda x: _centred(ceiling * x - matrix @ x), lambda value: ceiling - value, _DIRECT_STEPS)


def _inverse(matrix: Matrix, largest: float) -> _Way:
    """(L + σ)⁻¹, with σ far below the accuracy wanted and far above rounding, so that no pivot can fail."""
    shift = 1e-13 * largest
    raised = sparse.csc_array(matrix + shift * sparse.eye_array(matrix.shape[0]))
    factors = splu(raised, permc_spec="MMD_AT_PLUS_A", diag_pivot_thresh=0.0, options={"SymmetricMode": True})
    return _Way(lambda x: _centred(factors.solve(x)), lambda value: 1 / (value + shift), _INVERSE_STEPS)


def _largest(matrix: Matrix) -> float:
    """λ_max, from below, to a few parts in a hundred."""
    diagonal, beside = [], []
    for _, (_, along, beyond) in zip(range(30), _krylov(lambda x: matrix @ x, _start(matrix.shape[0])), strict=False):
        diagonal.append(along)
        beside.append(beyond)
    return float(linalg.eigvalsh_tridiagonal(diagonal, beside[:-1])[-1])


def _filtered(apply: _Apply, start: Floats, floor: float | None, steps: int) -> Floats:
    """Return the part of ``start`` in the eigenspaces of ``apply`` of eigenvalues ≥ floor (None: the largest alone).

    Lanczos' method twice: the first pass keeps the tridiagonal matrix T only, the second adds up f(T) e_0. Without
    reorthogonalisation T repeats eigenvalues that have converged, which harms neither the largest nor f(T) e_0 (f the
    indicator of what is wanted).
    """
    diagonal: list[float] = []
    beside: list[float] = []
    share = np.zeros(1)
    due = 8
    for _, along, beyond in _krylov(apply, start):
        diagonal.append(along)
        count = len(diagonal)
        if count >= due or beyond == 0 or count == steps:
            values, vectors = _top_pairs(diagonal, beside, floor)
            weights = vectors[0]
            share = vectors @ weights
            left = beyond * np.linalg.norm(vectors[-1] * weights)
            if len(values) and left <= _ACCURACY * abs(values[-1]) * np.linalg.norm(weights):
                break
            if count == steps:
                break
            due = count + max(8, count // 8)
        beside.append(beyond)
    total = np.zeros_like(start)
    for part, (basis, _, _) in zip(share, _krylov(apply, start), strict=False):
        total += part * basis
    return total * np.linalg.norm(start)


def _krylov(apply: _Apply, start: Floats) -> Iterator[tuple[Floats, float, float]]:
    """Yield Lanczos' basis vectors with the entries of T on and beside the diagonal, until the space is exhausted."""
    basis = start / np.linalg.norm(start)
    before = np.zeros_like(basis)
    beyond = 0.0
    while True:
        image = apply(basis) - beyond * before
        along = float(image @ basis)
        image -= along * basis
        beyond = float(np.linalg.norm(image))
        yield basis, along, beyond
        if beyond == 0:
            return
        before, basis = basis, image / beyond


def _top_pairs(diagonal: list[float], beside: list[float], floor: float | None) -> tuple[Floats, Floats]:
    """Eigenvalues ≥ floor of the tridiagonal matrix, ascending, with eigenvectors; the largest alone for None."""
    last = len(diagonal) - 1
    if floor is None:
        values, vectors = linalg.eigh_tridiagonal(diagonal, beside, select="i", select_range=(last, last))
    else:
        ceiling = 2 * max(abs(floor), np.abs(diagonal).max() + 2 * np.abs(beside).max(initial=0.0))
        values, vectors = linalg.eigh_tridiagonal(diagonal, beside, select="v", select_range=(floor, ceiling))
    return values, vectors


def _rayleigh_quotient(graph: Graph, vector: Floats) -> float:
    """Σ w (x_i − x_j)² of a unit vector, in which nothing cancels."""
    i, j = graph.edges.T
    return float(graph.lengths @ (vector[i] - vector[j]) ** 2)


def _centred(array: Floats) -> Floats:
    return array - array.mean()


def _start(n: int) -> Floats:
    """Return a centred array without pattern, the same every time: fractions of k² times the golden section."""
    return _centred(np.modf(np.arange(1.0, n + 1) ** 2 * ((math.sqrt(5) - 1) / 2))[0])
