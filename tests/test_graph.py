"""Graphs are what was given, and searches on them find the shortest ways."""

from __future__ import annotations

import math
from itertools import pairwise

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from taut.graph import Graph, astar, astar_between, dijkstra, path_to
from taut.graph.core import Floats

FIGURE_8_19 = {
    (1, 2): 7, (1, 3): 9, (1, 6): 14, (2, 3): 10, (2, 4): 15, (3, 4): 11, (3, 6): 2, (4, 5): 6, (5, 6): 9,
}  # fmt: skip


def figure_8_19() -> Graph:
    return Graph.from_edges(6, [(a - 1, b - 1) for a, b in FIGURE_8_19], list(FIGURE_8_19.values()))


def all_distances(graph: Graph) -> Floats:
    """Floyd and Warshall."""
    out = np.full((graph.n, graph.n), math.inf)
    np.fill_diagonal(out, 0.0)
    for (i, j), length in zip(graph.edges.tolist(), graph.lengths.tolist(), strict=True):
        out[i, j] = out[j, i] = min(out[i, j], length)
    for k in range(graph.n):
        out = np.minimum(out, out[:, k, None] + out[None, k])
    return out


def length_of(graph: Graph, path: list[int]) -> float:
    weight = {tuple(edge): w for edge, w in zip(graph.edges.tolist(), graph.lengths.tolist(), strict=True)}
    return float(sum(weight[min(a, b), max(a, b)] for a, b in pairwise(path)))


@st.composite
def graphs(draw: st.DrawFn, most: int = 12) -> Graph:
    """Draw a graph, often disconnected, often with equal and zero weights."""
    n = draw(st.integers(1, most))
    pairs = [(i, j) for i in range(n) for j in range(i)]
    chosen = draw(st.lists(st.sampled_from(pairs), unique=True, max_size=3 * n)) if pairs else []
    weight = st.integers(0, 5).map(float) | st.floats(0, 100)
    return Graph.from_edges(n, chosen, draw(st.lists(weight, min_size=len(chosen), max_size=len(chosen))))


@st.composite
def drawn_graphs(draw: st.DrawFn, most: int = 12) -> tuple[Graph, Floats]:
    """Draw a graph in the plane whose weights are at least the distances of their ends."""
    n = draw(st.integers(2, most))
    place = st.tuples(st.integers(0, 6), st.integers(0, 6))
    positions = np.array(draw(st.lists(place, min_size=n, max_size=n)), dtype=np.float64)
    pairs = [(i, j) for i in range(n) for j in range(i)]
    chosen = np.array(draw(st.lists(st.sampled_from(pairs), unique=True, max_size=3 * n)), np.int64).reshape(-1, 2)
    longer = np.array(draw(st.lists(st.sampled_from([1.0, 1.0, 1.5]), min_size=len(chosen), max_size=len(chosen))))
    return Graph.from_edges(n, chosen, np.hypot(*(positions[chosen[:, 0]] - positions[chosen[:, 1]]).T) * longer), (
        positions
    )


def test_figure_8_19() -> None:
    graph = figure_8_19()
    distance, before = dijkstra(graph, 0)
    assert distance[4] == 20.0
    assert [v + 1 for v in path_to(before, 4)] == [1, 3, 6, 5]
    assert distance.tolist() == [0.0, 7.0, 9.0, 20.0, 20.0, 11.0]


def test_edges_come_back_sorted_with_their_lengths() -> None:
    graph = Graph.from_edges(5, [(3, 1), (0, 4), (1, 0)], [2.0, 3.0, 4.0])
    assert (graph.n, graph.m) == (5, 3)
    assert graph.edges.tolist() == [[0, 1], [0, 4], [1, 3]]
    assert graph.lengths.tolist() == [4.0, 3.0, 2.0]
    for v in range(5):
        row = graph.indices[graph.indptr[v] : graph.indptr[v + 1]].tolist()
        assert row == sorted({b for a, b in graph.edges.tolist() if a == v} | {a for a, b in graph.edges if b == v})


def test_weights_default_to_one_and_nothing_is_a_graph_too() -> None:
    assert Graph.from_edges(3, [(0, 1), (1, 2)]).lengths.tolist() == [1.0, 1.0]
    empty = Graph.from_edges(0, [])
    assert (empty.n, empty.m, empty.edges.shape) == (0, 0, (0, 2))
    lonely = Graph.from_edges(3, [])
    assert dijkstra(lonely, 1)[0].tolist() == [math.inf, 0.0, math.inf]


@pytest.mark.parametrize(
    ("n", "edges", "weights", "said"),
    [
        (2, [(0, 2)], None, "outside"),
        (2, [(-1, 0)], None, "outside"),
        (0, [(0, 1)], None, "outside"),
        (3, [(1, 1)], None, "itself"),
        (3, [(0, 1), (1, 0)], None, "twice"),
        (3, [(0, 1), (0, 1)], [1.0, 2.0], "twice"),
        (3, [(0, 1)], [-1.0], "negative"),
        (3, [(0, 1)], [math.nan], "finite"),
        (3, [(0, 1)], [math.inf], "finite"),
        (3, [(0, 1)], [1.0, 2.0], "1 edges but 2 weights"),
        (3, [(0, 1), (1, 2)], [1.0], "2 edges but 1 weights"),
    ],
)
def test_wrong_edges_are_refused(n: int, edges: list[tuple[int, int]], weights: list[float] | None, said: str) -> None:
    with pytest.raises(ValueError, match=said):
        Graph.from_edges(n, edges, weights)


@pytest.mark.parametrize("vertex", [-1, 6])
def test_searches_from_no_vertex_are_refused(vertex: int) -> None:
    graph = figure_8_19()
    with pytest.raises(IndexError, match=f"vertex {vertex} "):
        dijkstra(graph, vertex)
    for source, target in ((vertex, 0), (0, vertex)):
        with pytest.raises(IndexError, match=f"vertex {vertex} "):
            astar(graph, np.zeros((6, 2)), source, target)


@settings(deadline=None, max_examples=150)
@given(graphs(), st.data())
def test_dijkstra_equals_floyd_and_warshall(graph: Graph, data: st.DataObject) -> None:
    source = data.draw(st.integers(0, graph.n - 1))
    distance, before = dijkstra(graph, source)
    expected = all_distances(graph)[source]
    assert (np.isfinite(distance) == np.isfinite(expected)).all()
    reached = np.flatnonzero(np.isfinite(expected))
    np.testing.assert_allclose(distance[reached], expected[reached], rtol=1e-13)
    assert (before[~np.isfinite(expected)] == -1).all()
    for target in reached.tolist():
        path = path_to(before, target)
        assert path[0] == source
        assert math.isclose(length_of(graph, path), distance[target], rel_tol=1e-13, abs_tol=1e-300)


@settings(deadline=None, max_examples=150)
@given(drawn_graphs(), st.data())
def test_astar_equals_floyd_and_warshall(drawn: tuple[Graph, Floats], data: st.DataObject) -> None:
    graph, positions = drawn
    source, target = data.draw(st.integers(0, graph.n - 1)), data.draw(st.integers(0, graph.n - 1))
    length, path = astar(graph, positions, source, target)
    expected = all_distances(graph)[source, target]
    if math.isinf(expected):
        assert math.isinf(length)
        assert len(path) == 0
        return
    assert math.isclose(length, expected, rel_tol=1e-13)
    assert (path[0], path[-1]) == (source, target)
    assert math.isclose(length_of(graph, path.tolist()), expected, rel_tol=1e-13)


@settings(deadline=None, max_examples=150)
@given(drawn_graphs(), st.data())
def test_astar_between_places_equals_trying_all_ends(drawn: tuple[Graph, Floats], data: st.DataObject) -> None:
    graph, positions = drawn
    some = st.lists(st.integers(0, graph.n - 1), unique=True, max_size=4)
    first, last = (np.array(sorted(data.draw(some)), dtype=np.int64) for _ in range(2))
    a, b = np.array([-1.0, 2.5]), np.array([7.0, 3.5])
    length, path = astar_between(graph, positions, a, first, b, last)
    between = all_distances(graph)
    ways = [math.dist(a, positions[i]) + between[i, j] + math.dist(positions[j], b) for i in first for j in last]
    expected = min(ways, default=math.inf)
    if math.isinf(expected):
        assert math.isinf(length)
        assert len(path) == 0
        return
    assert path[0] in first
    assert path[-1] in last
    assert math.isclose(length, expected, rel_tol=1e-13)
    inner = length_of(graph, path.tolist())
    assert math.isclose(
        math.dist(a, positions[path[0]]) + inner + math.dist(positions[path[-1]], b), expected, rel_tol=1e-13
    )
