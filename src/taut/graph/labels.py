"""Hub labels: distances and shortest paths between any two vertices from a few hundred numbers each.

The label of a vertex holds its distances to its hubs, chosen so that any two vertices share a hub that lies on a
shortest path between them: the distance is the least sum over common hubs. Made once, asked in microseconds.
"""

from __future__ import annotations

import os
import time
from collections.abc import Callable, Iterator
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass
from numbers import Real
from typing import TypeAlias, TypeVar

import numpy as np
from numpy.typing import ArrayLike, NDArray

from taut.errors import TautError
from taut.graph import _label_kernels
from taut.graph.core import Floats, Graph, Ints

Ints32 = NDArray[np.int32]

_ENTRY = 16  # bytes of an entry: hub, following vertex, distance
_SAMPLED = 5_000_000  # vertices in all sampled trees; 16 bytes each while the order is being found
_FEWEST = 32  # sampled trees of a large graph
_CHUNKS = 128
_Found: TypeAlias = tuple[Ints, Ints32, Floats, Ints32]
_Result = TypeVar("_Result")


@dataclass(frozen=True, eq=False)
class HubLabels:
    """Labels of the n vertices of a graph, in compressed sparse rows.

    Parameters
    ----------
    order : (n,) the vertices, the most important first; hubs are numbered by their places here.
    start : (n + 1,) where each vertex' label begins in the arrays below.
    hubs : (entries,) int32, ascending within a label.
    distances : (entries,) distance between the vertex and the hub.
    following : (entries,) int32, the next vertex on a shortest path from the vertex to the hub, −1 at the hub itself.
    build_seconds : seconds that building took, finding the order included.
    """

    order: Ints
    start: Ints
    hubs: Ints32
    distances: Floats
    following: Ints32
    build_seconds: float

    @property
    def n(self) -> int:
        """Number of vertices."""
        return len(self.start) - 1

    @property
    def bytes(self) -> int:
        """Size of all arrays in bytes."""
        return sum(a.nbytes for a in (self.order, self.start, self.hubs, self.distances, self.following))

    @property
    def mean_size(self) -> float:
        """Mean number of entries of a label; 0 without vertices."""
        return len(self.hubs) / max(self.n, 1)


def hub_labels(graph: Graph, order: ArrayLike | None = None, most_bytes: int | None = None) -> HubLabels:
    """Label every vertex with the least hubs that its order of importance allows.

    A vertex is a hub of another unless some shortest path between them passes a vertex of higher rank, so of all exact
    labels that respect the order these are the smallest (ties of rounded sums apart).

    Parameters
    ----------
    order : (n,) all vertices, the most important first; by default that of `hub_order`. It decides the size, never the
        answers.
    most_bytes : the labels' arrays may not need more. While they are built, about twice their final size is in use.

    Raises
    ------
    ValueError
        ``order`` does not hold every vertex once, or ``most_bytes`` is negative.
    TautError
        The labels need more than ``most_bytes``; says how many bytes were needed for how many of the vertices.

    Notes
    -----
    One search a hub that ends when it is covered by higher hubs, in threads; the result does not depend on their
    number. Time: for each hub, that of a Dijkstra search up to the farthest vertex that it is a hub of.
    Sources: Akiba, Iwata and Yoshida 2013 (pruned landmark labelling); Abraham, Delling, Goldberg and Werneck 2012
    (canonical labels). Here it is the paths of the search, not the labels made so far, that tell what is covered.

    >>> hub_labels(Graph.from_edges(3, [(0, 1), (1, 2)], [1.0, 2.0])).mean_size
    1.6666666666666667
    """
    began = time.perf_counter()
    if most_bytes is not None and not (isinstance(most_bytes, Real) and most_bytes >= 0):
        raise ValueError(f"most_bytes is {most_bytes!r}: give a number of bytes, 0 or more, or None for no bound")
    ranks = hub_order(graph) if order is None else _checked_order(graph, order)
    chunks = _searched(_ranked(graph, ranks), most_bytes)
    sizes = np.zeros(graph.n, dtype=np.int64)
    for _, vertices, _, _ in chunks:
        sizes[ranks] += np.bincount(vertices, minlength=graph.n)
    start = np.concatenate([[0], np.cumsum(sizes)])
    free = start[:-1].copy()
    hubs, distances = np.empty(start[-1], dtype=np.int32), np.empty(start[-1])
    following = np.empty(start[-1], dtype=np.int32)
    first = 0
    for found in chunks:
        _label_kernels.place_entries(ranks, first, *found, free, hubs, distances, following)
        first += len(found[0])
    return HubLabels(ranks, start, hubs, distances, following, time.perf_counter() - began)


def hub_order(graph: Graph) -> Ints:
    """Order the vertices by importance, the one on most shortest paths first, (n,).

    Next comes always the vertex on most paths of the sampled shortest-path trees that no earlier vertex is on. All
    vertices are roots in graphs of up to about 2,200, then fewer, so that their trees need 80 MB at most up to 150,000
    vertices; the roots are the same in every run.

    Notes
    -----
    Source: Delling, Goldberg, Pajor and Werneck 2014 (RXL), with trees sampled once, and the count of paths left times
    the root of the first count. With all roots that changes labels little; on a tangent graph of 10,000 vertices with
    500 roots it makes them 28 % smaller.

    >>> hub_order(Graph.from_edges(3, [(0, 1), (1, 2)])).tolist()
    [1, 0, 2]
    """
    n = graph.n
    count = min(n, max(_FEWEST, _SAMPLED // max(n, 1)))
    roots = np.random.default_rng(0).permutation(n)[:count].astype(np.int64)
    trees = [np.empty((count, n), dtype=np.int32) for _ in range(4)]

    def grow(first: int, last: int) -> None:
        rows = [tree[first:last] for tree in trees]
        _label_kernels.grow_trees(graph.indptr, graph.indices, graph.weights, roots[first:last], *rows)

    for _ in _in_chunks(grow, count, 16):
        pass
    parent, below, child, sibling = trees
    return _label_kernels.cover_trees(parent, below, child, sibling)


def label_distances(labels: HubLabels, a: ArrayLike, b: ArrayLike) -> Floats:
    """Distances between vertices a[i] and b[i], (k,); inf where there is no path.

    Pairs that follow each other with the same a[i] cost half. Releases the interpreter's lock.

    Raises
    ------
    IndexError
        A number is not that of a vertex.
    ValueError
        Not whole numbers, or ``a`` and ``b`` differ in length.

    >>> labels = hub_labels(Graph.from_edges(3, [(0, 1)], [2.0]))
    >>> label_distances(labels, [0, 0], [1, 2]).tolist()
    [2.0, inf]
    """
    pairs = _pairs(a, b, labels.n, "vertex")
    return _label_kernels.distances_of_pairs(labels.start, _unsigned(labels), labels.distances, *pairs)


def label_path(labels: HubLabels, a: int, b: int) -> list[int]:
    """Vertices of a shortest path from a to b, both included; empty where there is none.

    Raises
    ------
    IndexError
        ``a`` or ``b`` is not a vertex.

    >>> label_path(hub_labels(Graph.from_edges(3, [(0, 1), (1, 2)])), 0, 2)
    [0, 1, 2]
    """
    path: list[int] = label_paths(labels, [a], [b])[1].tolist()
    return path


def label_paths(labels: HubLabels, a: ArrayLike, b: ArrayLike) -> tuple[Ints, Ints]:
    """Shortest paths between vertices a[i] and b[i]. Raises as `label_distances`.

    Returns
    -------
    start : (k + 1,) where each path begins in ``vertices``; an empty path stands for none.
    vertices : those of all paths, one path after another.
    """
    pairs = _pairs(a, b, labels.n, "vertex")
    return _label_kernels.paths_of_pairs(labels.start, _unsigned(labels), labels.distances, labels.following, *pairs)


def label_distances_between(
    labels: HubLabels,
    positions: ArrayLike,
    points: ArrayLike,
    first: ArrayLike,
    corners: ArrayLike,
    offsets: ArrayLike,
    a: ArrayLike,
    b: ArrayLike,
) -> tuple[Floats, Ints]:
    """Distances between places off the graph, over at least one vertex, for pairs of places a[i] and b[i].

    No weight or offset may be less than the straight distance between its ends: straight lines tell which corners need
    no look. Where there are no such positions, zeros everywhere will do, and take longer. Releases the interpreter's
    lock.

    Parameters
    ----------
    positions : (n, 2) of the vertices.
    points : (p, 2) of the places.
    first, corners : CSR of the vertices that each place is joined with: (p + 1,) and (joins,).
    offsets : (joins,) length of each join, ≥ 0.
    a, b : (k,) numbers of places.

    Returns
    -------
    distances : (k,) inf where there is no path.
    passed : (k, 2) the vertices at which a shortest path enters and leaves the graph, −1 where there is none;
        `label_paths` has the way between them.

    Raises
    ------
    IndexError
        A number is not that of a place or a vertex.
    ValueError
        Arrays of wrong shape or length, rows that are no CSR, or numbers that are not finite or negative lengths.

    >>> labels = hub_labels(Graph.from_edges(2, [(0, 1)], [2.0]))
    >>> ends = [(-1, 0), (5, 0)], [0, 1, 2], [0, 1], [1.0, 3.0]
    >>> label_distances_between(labels, [(0, 0), (2, 0)], *ends, [0], [1])
    (array([6.]), array([[0, 1]]))
    """
    places = _coordinates(points, "points")
    at = _coordinates(positions, "positions")
    if len(at) != labels.n:
        raise ValueError(f"{labels.n} vertices but {len(at)} positions")
    begins = _whole(first, "first")
    joined = _whole(corners, "corners")
    lengths = np.ascontiguousarray(offsets, dtype=np.float64)
    if len(begins) != len(places) + 1 or begins[0] != 0 or begins[-1] != len(joined) or (np.diff(begins) < 0).any():
        raise ValueError(
            f"first must rise from 0 to {len(joined)}, the number of corners, in {len(places) + 1} numbers: "
            "one more than there are points"
        )
    _check_range(joined, labels.n, "vertex")
    if lengths.shape != joined.shape or not (np.isfinite(lengths).all() and (lengths >= 0).all()):
        raise ValueError("offsets are one length for each corner, finite and not negative")
    pairs = _pairs(a, b, len(places), "place")
    return _label_kernels.distances_of_places(
        labels.start, _unsigned(labels), labels.distances, at, places, begins, joined, lengths, *pairs
    )


def _checked_order(graph: Graph, order: ArrayLike) -> Ints:
    ranks = _whole(order, "order").copy()
    if not np.array_equal(np.sort(ranks), np.arange(graph.n)):
        raise ValueError(f"order must hold each of the vertices 0 … {graph.n - 1} once")
    return ranks


def _ranked(graph: Graph, order: Ints) -> Graph:
    """Return the graph with its vertices renumbered by rank."""
    rank = np.empty(graph.n, dtype=np.int64)
    rank[order] = np.arange(graph.n)
    return Graph.from_edges(graph.n, rank[graph.edges], graph.lengths)


def _searched(ranked: Graph, most_bytes: int | None) -> list[_Found]:
    """Entries of all hubs in chunks, as `_label_kernels.search_hubs` returns them, or a TautError."""

    def search(first: int, last: int) -> _Found:
        return _label_kernels.search_hubs(ranked.indptr, ranked.indices, ranked.weights, first, last)

    out: list[_Found] = []
    needed = 8 * ranked.n + 8 * (ranked.n + 1)
    done = 0
    if most_bytes is not None and needed > most_bytes:
        raise _too_large(needed, most_bytes, 0, ranked.n)
    for found in _in_chunks(search, ranked.n, max(64, -(-ranked.n // _CHUNKS))):
        so_far = needed + _ENTRY * np.cumsum(found[0])
        if most_bytes is not None and so_far[-1] > most_bytes:
            beyond = int(np.argmax(so_far > most_bytes))
            raise _too_large(int(so_far[beyond]), most_bytes, done + beyond + 1, ranked.n)
        needed = int(so_far[-1])
        done += len(found[0])
        out.append(found)
    return out


def _too_large(needed: int, most_bytes: int, done: int, n: int) -> TautError:
    return TautError(
        f"hub labels need more than the {most_bytes:,} bytes allowed: {needed:,} bytes with {done:,} of {n:,} vertices "
        "as hubs; allow more or search the graph instead"
    )


def _in_chunks(work: Callable[[int, int], _Result], count: int, size: int) -> Iterator[_Result]:
    """Yield work(first, last) over chunks of 0 … count − 1 in order, from several threads."""
    firsts = range(0, count, size)
    if len(firsts) <= 1:
        yield from (work(first, count) for first in firsts)
        return
    pool = ThreadPoolExecutor(os.cpu_count())
    try:
        yield from pool.map(lambda first: work(first, min(first + size, count)), firsts)
    finally:
        pool.shutdown(cancel_futures=True)  # who stops early does not wait for the rest


def _unsigned(labels: HubLabels) -> NDArray[np.uint32]:
    return labels.hubs.view(np.uint32)


def _pairs(a: ArrayLike, b: ArrayLike, count: int, what: str) -> tuple[Ints, Ints]:
    ends = _whole(a, "a"), _whole(b, "b")
    if len(ends[0]) != len(ends[1]):
        raise ValueError(f"a has {len(ends[0])} numbers but b has {len(ends[1])}: give them in pairs")
    for numbers in ends:
        _check_range(numbers, count, what)
    return ends


def _whole(values: ArrayLike, name: str) -> Ints:
    """Return whole numbers, (k,), as the kernels want them; nothing is rounded silently."""
    given = np.asarray(values)
    if given.ndim != 1 or (given.size and given.dtype.kind not in "iu"):
        raise ValueError(f"{name} must be a row of whole numbers, got shape {given.shape} of {given.dtype}")
    return np.ascontiguousarray(given, dtype=np.int64)


def _check_range(numbers: Ints, count: int, what: str) -> None:
    wrong = np.flatnonzero((numbers < 0) | (numbers >= count))
    if len(wrong):
        raise IndexError(f"{what} {numbers[wrong[0]]} is not one of the {count} there are, counted from 0")


def _coordinates(values: ArrayLike, name: str) -> Floats:
    given = np.asarray(values, dtype=np.float64)
    if given.size == 0:
        return given.reshape(0, 2)
    if given.ndim != 2 or given.shape[1] != 2 or not np.isfinite(given).all():
        raise ValueError(f"{name} must be finite, one row (x, y) each, got shape {given.shape}")
    return np.ascontiguousarray(given)
