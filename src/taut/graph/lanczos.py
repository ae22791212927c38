"""λ2 of large graphs by Lanczos' method, in time and memory that grow with the edges.

The method runs on an operator whose largest eigenvalues belong to the smallest of the Laplacian. On maps that is an
inverse: elimination fills little and a few dozen steps are enough. Graphs that expand would fill their inverse nearly
whole, but for them c − L itself converges in some hundred steps, each a product with a sparse matrix.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from itertools import islice
from typing import TypeAlias, cast

import numpy as np
from numpy.typing import ArrayLike
from scipy import linalg, sparse
from scipy.sparse.csgraph import reverse_cuthill_mckee
from scipy.sparse.linalg import splu

from taut.graph.core import Floats, Graph
from taut.graph.matrices import Matrix, laplacian

REPEATED = 1e-12
"""Eigenvalues within this part of λ_max of λ2 count as λ2."""

ORTHOGONAL = 1e-9
"""A projection shorter than this part of its array is none."""

_VERIFIED = 1e-13  # residual, in λ_max, at which a result is accepted

_Apply: TypeAlias = Callable[[Floats], Floats]


@dataclass(frozen=True, eq=False)
class Way:
    """An operator on centred arrays whose largest eigenvalues belong to the smallest of a Laplacian.

    ``apply`` has the eigenvalue ``image(λ)`` where the Laplacian has λ. Lanczos' method stops at the residual
    ``accuracy(θ)`` if the largest eigenvalue of ``apply`` is θ, or after so many ``steps``.
    """

    apply: _Apply
    image: Callable[[float], float]
    accuracy: Callable[[float], float]
    steps: int


@dataclass(frozen=True, eq=False)
class Laplacian:
    """A Laplacian as a graph and as a matrix, with λ_max to a few parts in a hundred."""

    graph: Graph
    matrix: Matrix
    largest: float


@dataclass(frozen=True, eq=False)
class Least:
    """λ2 with a unit vector of its, and the way they were found."""

    value: float
    unit: Floats
    of: Laplacian
    way: Way


def least(graph: Graph) -> Least | None:
    """Find λ2 of a connected graph to 1e-12 λ_max, or None where no way converges.

    The weights must be near 1, so that sums and products of them neither overflow nor vanish.
    """
    matrix = laplacian(graph)
    of = Laplacian(graph, matrix, _largest(matrix))
    for make in [_inverse, _direct] if _narrow(matrix) else [_direct, _inverse]:
        way = make(of)
        found = _settled(_filtered(way, _start(graph.n), None), of, way)
        if found is not None:
            return found
    return None


def projected(found: Least, array: Floats) -> Floats | None:
    """Project a centred array onto the eigenspace of λ2: zero where they are orthogonal, None without convergence.

    Lanczos' method begins at the array itself: its vectors then hold the projection and nothing else of a repeated
    eigenvalue's space, so that it costs no more than a simple one.
    """
    if not array.any():
        return array
    floor = found.way.image(found.value + REPEATED * found.of.largest)
    nearest = _filtered(found.way, array, floor)
    length = np.linalg.norm(nearest)
    if length <= ORTHOGONAL * np.linalg.norm(array):
        return np.zeros_like(array)
    settled = _settled(nearest, found.of, found.way)
    return None if settled is None else settled.unit * length


def _settled(vector: Floats, of: Laplacian, way: Way) -> Least | None:
    """Return the vector if it is an eigenvector to the accuracy wanted, at once or when the operator has mended it.

    The Rayleigh quotient of a centred vector is at least λ2. So one that is below the error allowed needs no proof:
    where weights span so many magnitudes, eigenvectors cannot be told apart, but applying an inverse lowers it.
    """
    for _ in range(3):
        unit = vector / np.linalg.norm(vector)
        value = _rayleigh_quotient(of.graph, unit)
        residual = np.linalg.norm(of.matrix @ unit - value * unit)
        if value <= REPEATED / 2 * of.largest or residual <= _VERIFIED * of.largest:
            return Least(value, unit, of, way)
        vector = way.apply(unit)
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


def _direct(of: Laplacian) -> Way:
    """No inversion: 2 d_max − L, positive semidefinite."""
    ceiling = 2 * float(of.matrix.diagonal().max())
    return Way(
        apply=lambda x: _centred(ceiling * x - of.matrix @ x),
        image=lambda value: ceiling - value,
        accuracy=lambda top: 2.0**-50 * top,
        steps=10_000,
    )


def _inverse(of: Laplacian) -> Way:
    """(L + σ)⁻¹, with σ far below the accuracy wanted and far above rounding, so that no pivot can fail."""
    shift = 1e-13 * of.largest
    raised = sparse.csc_array(of.matrix + shift * sparse.eye_array(of.graph.n))
    factors = splu(raised, permc_spec="MMD_AT_PLUS_A", diag_pivot_thresh=0.0, options={"SymmetricMode": True})
    return Way(
        apply=lambda x: _centred(factors.solve(_centred(x))),  # what is constant would grow by 1 / σ and drown the rest
        image=lambda value: 1 / (value + shift),
        accuracy=lambda top: min(2.0**-50 * of.largest * top, 2.0**-42) * top,  # rounding grows with the condition
        steps=1000,
    )


def _largest(matrix: Matrix) -> float:
    """Return λ_max, from below, to a few parts in a hundred."""
    steps = islice(_krylov(lambda x: cast(Floats, matrix @ x), _start(matrix.shape[0])), 30)
    diagonal, beside = np.array([(along, beyond) for _, along, beyond in steps]).T
    return float(linalg.eigvalsh_tridiagonal(diagonal, beside[:-1])[-1])


def _filtered(way: Way, start: Floats, floor: float | None) -> Floats:
    """Return the part of ``start`` in the eigenspaces of the operator ≥ floor (None: of its largest eigenvalue alone).

    Lanczos' method twice: the first pass keeps the tridiagonal matrix T only, the second adds up f(T) e_0. Without
    reorthogonalisation T repeats eigenvalues that have converged, which harms neither the largest nor f(T) e_0 (f the
    indicator of what is wanted).
    """
    diagonal: list[float] = []
    beside: list[float] = []
    share = np.zeros(1)
    scale = 0.0
    due = 8
    for _, along, beyond in _krylov(way.apply, start):
        diagonal.append(along)
        count = len(diagonal)
        scale = max(scale, along)
        finished = beyond <= way.accuracy(scale) or count == way.steps  # the space is exhausted, or patience
        if finished or count >= due:
            values, vectors = _top_pairs(diagonal, beside, floor)
            weights = vectors[0]
            share = vectors @ weights
            left = beyond * np.linalg.norm(vectors[-1] * weights)
            if len(values) and left <= way.accuracy(abs(values[-1])) * np.linalg.norm(weights):
                break
            if finished:
                break
            due = count + max(8, count // 8)
        beside.append(beyond)
    total = np.zeros_like(start)
    for part, (basis, _, _) in zip(share, _krylov(way.apply, start), strict=False):
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
    return _floats(values), _floats(vectors)


def _rayleigh_quotient(graph: Graph, vector: Floats) -> float:
    """Σ w (x_i − x_j)² of a unit vector, in which nothing cancels."""
    i, j = graph.edges.T
    return float(graph.lengths @ (vector[i] - vector[j]) ** 2)


def _centred(array: Floats) -> Floats:
    return _floats(array - array.mean())


def _floats(values: ArrayLike) -> Floats:
    return np.asarray(values, dtype=np.float64)


def _start(n: int) -> Floats:
    """Return a centred array without pattern, the same every time: fractions of k² times the golden section."""
    return _centred(np.modf(np.arange(1.0, n + 1) ** 2 * ((math.sqrt(5) - 1) / 2))[0])
