"""Effective resistances are those of the network, to the last digits, whatever the weights."""

from __future__ import annotations

from itertools import combinations

import mpmath
import networkx as nx
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from taut.graph import Graph
from taut.graph.connectedness import components
from taut.graph.core import Floats
from taut.graph.resistance import effective_resistance, eliminate, kirchhoff_index, resistance_matrix


def of_networkx(graph: nx.Graph) -> Graph:
    return Graph.from_edges(graph.number_of_nodes(), list(graph.edges))


def all_pairs(n: int) -> list[tuple[int, int]]:
    return list(combinations(range(n), 2))


def exact_resistances(graph: Graph) -> dict[tuple[int, int], mpmath.mpf]:
    """From the inverse of L + J/n in 600 digits, for a connected graph."""
    with mpmath.workdps(600):
        matrix = mpmath.ones(graph.n) / graph.n
        for (i, j), weight in zip(graph.edges.tolist(), graph.lengths.tolist(), strict=True):
            matrix[i, i] += mpmath.mpf(weight)
            matrix[j, j] += mpmath.mpf(weight)
            matrix[i, j] -= mpmath.mpf(weight)
            matrix[j, i] -= mpmath.mpf(weight)
        inverse = matrix**-1
        return {(i, j): inverse[i, i] + inverse[j, j] - 2 * inverse[i, j] for i, j in all_pairs(graph.n)}


def connected_graph(rng: np.random.Generator, n: int, magnitudes: float) -> Graph:
    tree = {(int(rng.integers(i)), i) for i in range(1, n)}
    edges = sorted(tree | {pair for pair in all_pairs(n) if rng.random() < 0.3})
    return Graph.from_edges(n, edges, 10.0 ** rng.uniform(-magnitudes, magnitudes, len(edges)))


@st.composite
def graphs(draw: st.DrawFn, most: int = 10) -> Graph:
    """Draw a graph, often disconnected, often with weights of 0, of weights up to nine magnitudes apart."""
    n = draw(st.integers(1, most))
    pairs = all_pairs(n)
    chosen = draw(st.lists(st.sampled_from(pairs), unique=True)) if pairs else []
    weight = st.integers(0, 3).map(float) | st.floats(1e-6, 1e3)
    return Graph.from_edges(n, chosen, draw(st.lists(weight, min_size=len(chosen), max_size=len(chosen))))


@pytest.mark.parametrize("n", [2, 3, 4, 7, 20, 60])
def test_complete_graph(n: int) -> None:
    graph = of_networkx(nx.complete_graph(n))
    np.testing.assert_allclose(effective_resistance(graph, all_pairs(n)), 2 / n, rtol=1e-14)
    assert kirchhoff_index(graph) == pytest.approx(n - 1, rel=1e-14)


@pytest.mark.parametrize("n", [3, 4, 7, 20, 61])
def test_cycle(n: int) -> None:
    graph = of_networkx(nx.cycle_graph(n))
    expected = [(j - i) * (n - j + i) / n for i, j in all_pairs(n)]
    np.testing.assert_allclose(effective_resistance(graph, all_pairs(n)), expected, rtol=1e-14)
    assert kirchhoff_index(graph) == pytest.approx((n**3 - n) / 12, rel=1e-14)


@pytest.mark.parametrize("n", [2, 3, 7, 60])
def test_path_and_star(n: int) -> None:
    path = of_networkx(nx.path_graph(n))
    np.testing.assert_allclose(effective_resistance(path, all_pairs(n)), [j - i for i, j in all_pairs(n)], rtol=1e-14)
    assert kirchhoff_index(path) == pytest.approx((n**3 - n) / 6, rel=1e-14)
    star = of_networkx(nx.star_graph(n - 1))
    np.testing.assert_allclose(effective_resistance(star, all_pairs(n)), [1 + (i > 0) for i, _ in all_pairs(n)])
    assert kirchhoff_index(star) == pytest.approx((n - 1) ** 2, rel=1e-14)


def test_conductors_in_series_and_in_parallel() -> None:
    series = Graph.from_edges(3, [(0, 1), (1, 2)], [4.0, 0.25])
    assert effective_resistance(series, [(0, 2), (2, 0), (1, 1)]).tolist() == [4.25, 4.25, 0.0]
    parallel = Graph.from_edges(3, [(0, 1), (1, 2), (0, 2)], [4.0, 4.0, 6.0])
    assert effective_resistance(parallel, [(0, 2)])[0] == pytest.approx(1 / 8, rel=1e-15)


@pytest.mark.parametrize("magnitudes", [0.0, 3.0, 12.0, 40.0, 130.0])
def test_nothing_is_lost_however_far_the_weights_lie_apart(magnitudes: float) -> None:
    rng = np.random.default_rng(int(magnitudes))
    for n in (2, 5, 8, 11):
        graph = connected_graph(rng, n, magnitudes)
        exact = exact_resistances(graph)
        expected = np.array([float(exact[pair]) for pair in all_pairs(n)])
        np.testing.assert_allclose(effective_resistance(graph, all_pairs(n)), expected, rtol=1e-13)
        np.testing.assert_allclose(resistance_matrix(graph)[np.triu_indices(n, 1)], expected, rtol=1e-13)
        assert kirchhoff_index(graph) == pytest.approx(float(mpmath.fsum(exact.values())), rel=1e-13)


def test_strong_parts_behind_a_weak_link_keep_their_resistances() -> None:
    square = [(0, 1), (1, 2), (2, 3), (0, 3)]
    edges = [*square, *((a + 4, b + 4) for a, b in square), (0, 4)]
    graph = Graph.from_edges(8, edges, [1.0] * 8 + [1e-40])
    within = effective_resistance(graph, [(0, 1), (0, 2), (4, 6), (5, 6), (1, 5)])
    np.testing.assert_allclose(within, [0.75, 1.0, 1.0, 0.75, 1e40], rtol=1e-14)
    np.testing.assert_allclose(resistance_matrix(graph)[[0, 0, 4], [1, 2, 6]], [0.75, 1.0, 1.0], rtol=1e-14)


@settings(deadline=None, max_examples=60)
@given(graphs())
def test_resistances_agree_with_each_other_and_are_a_metric(graph: Graph) -> None:
    matrix = resistance_matrix(graph)
    assert (matrix == matrix.T).all()
    assert (np.diag(matrix) == 0).all()
    labels = components(graph)
    assert (np.isinf(matrix) == (labels[:, None] != labels)).all()
    pairs = np.argwhere(np.ones_like(matrix))
    np.testing.assert_allclose(effective_resistance(graph, pairs), matrix.ravel(), rtol=1e-12)
    through = matrix[:, :, None] + matrix[None, :, :]  # i to j to k
    assert (matrix[:, None, :] <= through * (1 + 1e-12)).all()
    total = matrix[np.triu_indices(graph.n, 1)].sum()
    assert kirchhoff_index(graph) == pytest.approx(total, rel=1e-12)


@settings(deadline=None, max_examples=60)
@given(graphs())
def test_foster_weights_times_resistances_sum_to_the_edges_of_a_spanning_forest(graph: Graph) -> None:
    used = graph.lengths > 0
    shares = graph.lengths[used] * effective_resistance(graph, graph.edges[used])
    assert (shares <= 1 + 1e-12).all()
    assert shares.sum() == pytest.approx(graph.n - 1 - components(graph).max(), rel=1e-12, abs=1e-300)


@settings(deadline=None, max_examples=40)
@given(graphs(), st.data())
def test_another_edge_never_raises_a_resistance(graph: Graph, data: st.DataObject) -> None:
    missing = sorted(set(all_pairs(graph.n)) - set(map(tuple, graph.edges.tolist())))
    if not missing:
        return
    edge = data.draw(st.sampled_from(missing))
    more = Graph.from_edges(graph.n, [*graph.edges.tolist(), edge], [*graph.lengths, data.draw(st.floats(0, 10))])
    assert (resistance_matrix(more) <= resistance_matrix(graph) * (1 + 1e-12)).all()


def test_kirchhoff_index_is_the_sum_over_eigenvalues() -> None:
    graph = connected_graph(np.random.default_rng(5), 40, 1.0)
    laplacian = np.diag(np.bincount(graph.edges.ravel(), np.repeat(graph.lengths, 2)))
    laplacian[tuple(graph.edges.T)] = laplacian[tuple(graph.edges.T[::-1])] = -graph.lengths
    values: Floats = np.linalg.eigvalsh(laplacian)
    assert kirchhoff_index(graph) == pytest.approx(graph.n * (1 / values[1:]).sum(), rel=1e-10)


def test_an_elimination_is_the_laplacian() -> None:
    graph = connected_graph(np.random.default_rng(3), 30, 0.5)
    done = eliminate(graph)
    assert done.order[done.rank].tolist() == list(range(30))
    factor = np.eye(30)
    for k in range(30):
        row = slice(done.start[k], done.start[k + 1])
        factor[done.columns[row], k] = -done.shares[row]
    laplacian = factor @ np.diag(done.pivots) @ factor.T
    expected = -nx.to_numpy_array(nx.Graph([(i, j, {"weight": w}) for (i, j), w in zip(
        graph.edges.tolist(), graph.lengths.tolist(), strict=True)]), nodelist=range(30))  # fmt: skip
    np.fill_diagonal(expected, -expected.sum(axis=1))
    np.testing.assert_allclose(laplacian, expected[np.ix_(done.order, done.order)], atol=1e-13)


@pytest.mark.parametrize("n", [0, 1])
def test_graphs_without_pairs(n: int) -> None:
    graph = Graph.from_edges(n, [])
    assert kirchhoff_index(graph) == 0.0
    assert resistance_matrix(graph).tolist() == [[0.0]] * n
    assert effective_resistance(graph, []).shape == (0,)


def test_an_edge_of_weight_0_does_not_connect() -> None:
    graph = Graph.from_edges(3, [(0, 1), (1, 2)], [2.0, 0.0])
    assert effective_resistance(graph, [(0, 1), (0, 2)]).tolist() == [0.5, np.inf]
    assert kirchhoff_index(graph) == np.inf


@pytest.mark.parametrize("scale", [1e-300, 1e300])
def test_huge_and_tiny_weights(scale: float) -> None:
    graph = Graph.from_edges(3, [(0, 1), (1, 2), (0, 2)], [scale] * 3)
    np.testing.assert_allclose(resistance_matrix(graph)[0, 1] * scale, 2 / 3, rtol=1e-14)
    np.testing.assert_allclose(effective_resistance(graph, [(0, 1)]) * scale, 2 / 3, rtol=1e-14)


def test_refusals_say_what_is_wrong() -> None:
    graph = Graph.from_edges(3, [(0, 1), (1, 2)])
    with pytest.raises(IndexError, match=r"pair 1 is \(0, 3\); the vertices are 0 … 2"):
        effective_resistance(graph, [(0, 1), (0, 3)])
    with pytest.raises(IndexError, match=r"pair 0 is \(-1, 0\)"):
        effective_resistance(graph, [(-1, 0)])
    for pairs in ([0, 1], [(0, 1, 2)], [(0.0, 1.5)]):
        with pytest.raises(ValueError, match="pairs must be"):
            effective_resistance(graph, pairs)
    with pytest.raises(ValueError, match=r"vertex 1 .*scale"):
        kirchhoff_index(Graph.from_edges(3, [(0, 1), (1, 2)], [1.7e308, 1.7e308]))
