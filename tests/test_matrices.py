"""The matrices of a graph and the weights of its edges are those of their definitions."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from taut.graph import (
    Graph,
    adjacency,
    beta_index,
    contact_graph,
    degree,
    degrees,
    exponential,
    fading,
    incidence,
    laplacian,
    normalised_laplacian,
    weighted,
)
from taut.graph.core import Floats
from taut.graph.weights import WEIGHTS, distance, one
from thesis_graphs import EDGES_4_2, EDGES_8_1, EDGES_8_17_LARGEST, EDGES_8_17_SMALLEST, figure_4_2, graph_of

PRINTED_8_2 = [
    [-1, 0, 0, -1, -1, 0, 0],
    [1, -1, 0, 0, 0, -1, 0],
    [0, 1, -1, -1, 0, 0, 0],
    [0, 0, 0, 0, 0, 0, -1],
    [0, 0, 1, 0, 1, -1, 1],
]
PRINTED_8_4 = [[0, 1, 1, 0, 1], [1, 0, 1, 0, 1], [1, 1, 0, 0, 1], [0, 0, 0, 0, 1], [1, 1, 1, 1, 0]]
PRINTED_8_6 = [[3, 0, 0, 0, 0], [0, 3, 0, 0, 0], [0, 0, 3, 0, 0], [0, 0, 0, 1, 0], [0, 0, 0, 0, 4]]
PRINTED_8_8 = [[3, -1, -1, 0, -1], [-1, 3, -1, 0, -1], [-1, -1, 3, 0, -1], [0, 0, 0, 1, -1], [-1, -1, -1, -1, 4]]


@st.composite
def graphs(draw: st.DrawFn, most: int = 8) -> Graph:
    n = draw(st.integers(0, most))
    pairs = [(i, j) for i in range(n) for j in range(i)]
    chosen = draw(st.lists(st.sampled_from(pairs), unique=True)) if pairs else []
    weights = st.integers(0, 5).map(float) | st.floats(0, 1e3)
    return Graph.from_edges(n, chosen, draw(st.lists(weights, min_size=len(chosen), max_size=len(chosen))))


def places(n: int) -> st.SearchStrategy[Floats]:
    coordinate = st.integers(-3, 3).map(float) | st.floats(-5, 5)
    return st.lists(st.tuples(coordinate, coordinate), min_size=n, max_size=n).map(
        lambda rows: np.array(rows, dtype=np.float64).reshape(-1, 2)
    )


def test_figure_8_1_has_the_printed_adjacency_degree_and_laplacian() -> None:
    graph = graph_of(EDGES_8_1)
    assert adjacency(graph).toarray().tolist() == PRINTED_8_4
    assert degree(graph).toarray().tolist() == PRINTED_8_6
    assert laplacian(graph).toarray().tolist() == PRINTED_8_8


def test_figure_8_1_has_the_printed_incidence_but_for_directions() -> None:
    # (8.2) prints both ends of A-C and of B-E as −1, so B Bᵀ is not the printed Laplacian. Which edges the columns are
    # stands firm: the places of their entries.
    printed = np.abs(PRINTED_8_2).T.tolist()
    assert sorted(np.abs(incidence(graph_of(EDGES_8_1)).toarray()).T.tolist()) == sorted(printed)
    assert (np.sum(PRINTED_8_2, axis=0) != 0).sum() == 2


def test_figure_4_2_has_the_printed_degrees_but_one() -> None:
    # (4.6) belongs to (4.5) with its 5 at (7, 10), and prints 48 for vertex 14, whose weights sum to 28.
    printed = [41, 33, 32, 50, 43, 38, 50, 53, 35, 33, 47, 37, 32, 48, 42, 24]
    extra = Graph.from_edges(16, [*EDGES_4_2, (6, 9)], [*EDGES_4_2.values(), 5.0])
    assert [v + 1 for v in np.flatnonzero(degrees(extra) != printed)] == [14]
    assert degrees(figure_4_2())[13] == 28


def test_beta_index_of_figure_8_17() -> None:
    assert beta_index(graph_of(EDGES_8_17_SMALLEST)) == 0.8
    assert beta_index(graph_of(EDGES_8_17_LARGEST)) == 2.0
    with pytest.raises(ValueError, match="without vertices"):
        beta_index(Graph.from_edges(0, []))


@given(graphs())
@settings(deadline=None)
def test_the_matrices_follow_their_definitions(graph: Graph) -> None:
    expected = np.zeros((graph.n, graph.n))
    for (i, j), weight in zip(graph.edges.tolist(), graph.lengths.tolist(), strict=True):
        expected[i, j] = expected[j, i] = weight
    sums = np.array([math.fsum(row) for row in expected.tolist()])
    assert np.array_equal(adjacency(graph).toarray(), expected)
    np.testing.assert_allclose(degrees(graph), sums, rtol=1e-15)
    np.testing.assert_allclose(degree(graph).toarray(), np.diag(sums), rtol=1e-15)
    np.testing.assert_allclose(laplacian(graph).toarray(), np.diag(sums) - expected, rtol=1e-15)


@given(graphs())
@settings(deadline=None)
def test_incidence_runs_from_the_smaller_to_the_larger_vertex_and_makes_the_laplacian(graph: Graph) -> None:
    matrix = incidence(graph).toarray()
    assert matrix.shape == (graph.n, graph.m)
    for column, (i, j) in zip(matrix.T, graph.edges.tolist(), strict=True):
        assert (column[i], column[j], np.abs(column).sum()) == (-1.0, 1.0, 2.0)
    product = matrix @ np.diag(graph.lengths) @ matrix.T
    np.testing.assert_allclose(product, laplacian(graph).toarray(), rtol=1e-14)


@given(graphs())
@settings(deadline=None)
def test_the_normalised_laplacian_divides_by_roots_of_degrees(graph: Graph) -> None:
    sums = degrees(graph)
    expected = np.zeros((graph.n, graph.n))
    dense = laplacian(graph).toarray()
    for i in range(graph.n):
        for j in range(graph.n):
            if sums[i] > 0 and sums[j] > 0:
                expected[i, j] = dense[i, j] / math.sqrt(sums[i]) / math.sqrt(sums[j])
    np.testing.assert_allclose(normalised_laplacian(graph).toarray(), expected, rtol=1e-14, atol=1e-300)


def test_matrices_do_not_share_memory_with_the_graph() -> None:
    graph = graph_of(EDGES_8_1)
    adjacency(graph).data[:] = 7
    assert (graph.weights == 1).all()


def test_degrees_that_overflow_are_refused() -> None:
    graph = Graph.from_edges(3, [(0, 1), (1, 2)], [1e308, 1e308])
    with pytest.raises(ValueError, match="vertex 1"):
        degrees(graph)


@given(st.data())
@settings(deadline=None)
def test_contacts_are_all_pairs_within_reach(data: st.DataObject) -> None:
    positions = data.draw(places(data.draw(st.integers(0, 9))))
    reach = data.draw(st.integers(0, 5).map(float) | st.floats(0, 8))
    found = contact_graph(positions, reach)
    expected = [
        [i, j]
        for i in range(len(positions))
        for j in range(i + 1, len(positions))
        if math.hypot(*(positions[i] - positions[j])) <= reach
    ]
    assert found.n == len(positions)
    assert found.edges.tolist() == expected
    assert (found.lengths == 1).all()


@pytest.mark.parametrize("scale", [2.0**-1000, 2.0**-30, 2.0**30, 2.0**1000])
def test_contacts_do_not_depend_on_the_unit_of_length(scale: float) -> None:
    lattice = np.stack(np.meshgrid(np.arange(5.0), np.arange(4.0)), axis=-1).reshape(-1, 2)
    assert np.array_equal(contact_graph(lattice * scale, scale).edges, contact_graph(lattice, 1.0).edges)


@given(st.data())
@settings(deadline=None)
def test_weights_are_functions_of_distances_and_zero_means_no_edge(data: st.DataObject) -> None:
    graph = data.draw(graphs())
    positions = data.draw(places(graph.n))
    lengths = {(i, j): math.hypot(*(positions[i] - positions[j])) for i, j in graph.edges.tolist()}
    cases = {
        "one": (one, dict.fromkeys(lengths, 1.0)),
        "distance": (distance, {e: d for e, d in lengths.items() if d > 0}),
        "exponential": (exponential(2.0), {e: math.exp(d) for e, d in lengths.items() if d <= 2}),
        "fading": (fading(lambda d: 1 / (1 + d), 3.0), {e: 1 / (1 + d) for e, d in lengths.items() if d <= 3}),
    }
    for weight, expected in cases.values():
        found = weighted(graph, positions, weight)
        assert found.n == graph.n
        assert list(map(tuple, found.edges.tolist())) == list(expected)
        np.testing.assert_allclose(found.lengths, list(expected.values()), rtol=1e-15)


def test_the_names_of_weights_are_those_of_their_functions() -> None:
    assert {"one": one, "distance": distance} == WEIGHTS


def two_apart(metres: float) -> tuple[Graph, list[tuple[float, float]]]:
    return Graph.from_edges(2, [(0, 1)]), [(0.0, 0.0), (metres, 0.0)]


def test_weights_that_are_no_weights_are_refused_with_their_edge() -> None:
    graph, positions = two_apart(1000.0)
    for weight in (exponential(math.inf), lambda d: -d, lambda d: d * math.nan):
        with pytest.raises(ValueError, match=r"edge \(0, 1\) of 1000 m"):
            weighted(graph, positions, weight)
    with pytest.raises(ValueError, match="one value a distance"):
        weighted(graph, positions, lambda d: np.zeros(5))


@pytest.mark.parametrize("f", [lambda d: d / 10, lambda d: 2 - d, lambda d: -d, lambda d: d * math.nan])
def test_fading_refuses_what_does_not_fade_from_one_to_zero(f: object) -> None:
    with pytest.raises(ValueError, match="fading weight"):
        fading(f, 9.0)(np.array([3.0, 0.5, 20.0]))  # type: ignore[arg-type]


def test_bad_positions_and_reaches_are_named() -> None:
    graph, _ = two_apart(1.0)
    with pytest.raises(ValueError, match="2 vertices but 1 positions"):
        weighted(graph, [(0.0, 0.0)], one)
    with pytest.raises(ValueError, match=r"one row \(x, y\) a vertex"):
        weighted(graph, [1.0, 2.0], one)
    with pytest.raises(ValueError, match="vertex 1 is at"):
        contact_graph([(0.0, 0.0), (math.nan, 1.0)], 1.0)
    for reach in (-1.0, math.nan):
        for use in (exponential, lambda r: fading(one, r), lambda r: contact_graph([(0.0, 0.0)], r)):
            with pytest.raises(ValueError, match="reach is"):
                use(reach)
