"""Eigenvalues, λ2 and Fiedler vectors are those of theory, to rounding, on graphs of every kind and size."""

from __future__ import annotations

import importlib
import math

import mpmath
import networkx as nx
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from taut.graph import (
    Graph,
    algebraic_connectivity,
    components,
    eigenpairs,
    fiedler_vector,
    lanczos,
    laplacian,
    spectrum,
)
from taut.graph.core import Floats, Ints
from thesis_graphs import SPECTRUM_4_2, figure_4_2


def complete(n: int) -> Graph:
    return Graph.from_edges(n, np.stack(np.triu_indices(n, 1), axis=1))


def path(n: int) -> Graph:
    return Graph.from_edges(n, np.stack([np.arange(n - 1), np.arange(1, n)], axis=1))


def cycle(n: int) -> Graph:
    return Graph.from_edges(n, np.stack([np.arange(n), (np.arange(n) + 1) % n], axis=1))


def star(n: int) -> Graph:
    return Graph.from_edges(n, np.stack([np.zeros(n - 1, np.int64), np.arange(1, n)], axis=1))


def lattice(*sides: int) -> tuple[Graph, Floats]:
    grid = nx.grid_graph(sides[::-1])
    graph = nx.convert_node_labels_to_integers(grid)
    return Graph.from_edges(len(grid), list(graph.edges)), np.array(list(grid), dtype=np.float64)


def regular(n: int, degree: int) -> Graph:
    return Graph.from_edges(n, list(nx.random_regular_graph(degree, n, seed=1).edges))


def closed_forms(n: int) -> dict[str, tuple[Graph, Floats]]:
    k = np.arange(n)
    return {
        "complete": (complete(n), np.where(k == 0, 0.0, n)),
        "path": (path(n), 4 * np.sin(np.pi * k / (2 * n)) ** 2),
        "cycle": (cycle(n), np.sort(4 * np.sin(np.pi * k / n) ** 2)),
        "star": (star(n), np.where(k == 0, 0.0, np.where(k == n - 1, n, 1.0))),
    }


def random_graph(seed: int, largest: int = 40) -> Graph:
    """Return a weighted graph, every third of several components, weights spread over many magnitudes now and then."""
    rng = np.random.default_rng(seed)
    n = int(rng.integers(2, largest))
    pairs = np.stack(np.triu_indices(n, 1), axis=1)
    kept = rng.random(len(pairs)) < rng.choice([0.05, 0.3, 0.9])
    if seed % 3:
        kept |= pairs[:, 1] == pairs[:, 0] + 1
    edges = rng.permutation(n)[pairs[kept]]
    spread = [0.0, 1.0, 6.0, 15.0][seed % 4]
    return Graph.from_edges(n, edges, 10.0 ** rng.uniform(-spread, spread, len(edges)))


def random_connected(seed: int, largest: int = 40) -> Graph:
    return random_graph(3 * seed + 1, largest)


def dense(graph: Graph) -> Floats:
    """Build the Laplacian edge by edge."""
    out = np.zeros((graph.n, graph.n))
    for (i, j), weight in zip(graph.edges.tolist(), graph.lengths.tolist(), strict=True):
        out[i, i] += weight
        out[j, j] += weight
        out[i, j] -= weight
        out[j, i] -= weight
    return out


def relabelled(graph: Graph, order: Ints) -> Graph:
    """Give vertex v the number order[v]."""
    return Graph.from_edges(graph.n, order[graph.edges], graph.lengths)


def quotient(graph: Graph, vector: Floats) -> float:
    i, j = graph.edges.T
    return float(graph.lengths @ (vector[i] - vector[j]) ** 2)


@pytest.fixture
def always_sparse(monkeypatch: pytest.MonkeyPatch) -> None:
    """Send all graphs the way of large ones."""
    monkeypatch.setattr(importlib.import_module("taut.graph.spectral"), "_DENSE", 1)


# ---- the thesis ----


def test_figure_4_2_has_the_eigenvalues_of_table_4_2() -> None:
    np.testing.assert_allclose(spectrum(figure_4_2()), SPECTRUM_4_2, atol=5.1e-5)


def test_figure_4_2_without_four_edges_and_without_the_fifth() -> None:
    # The thesis prints 4.5747, which its own edges do not give.
    four = ("e41", "e44", "e46", "e49")
    assert algebraic_connectivity(figure_4_2(four)) == pytest.approx(4.4519, abs=5e-5)
    assert algebraic_connectivity(figure_4_2((*four, "e48"))) == 0.0


# ---- closed forms ----


@pytest.mark.parametrize("n", [3, 4, 5, 10, 37, 64, 199, 200])
@pytest.mark.parametrize("kind", ["complete", "path", "cycle", "star"])
def test_closed_forms(kind: str, n: int) -> None:
    graph, expected = closed_forms(n)[kind]
    np.testing.assert_allclose(spectrum(graph), expected, atol=1e-12 * expected[-1])
    assert algebraic_connectivity(graph) == pytest.approx(expected[1], abs=1e-12 * expected[-1])


def test_lambda2_of_every_size_to_200() -> None:
    for n in range(3, 201):
        assert algebraic_connectivity(path(n)) == pytest.approx(4 * math.sin(math.pi / (2 * n)) ** 2, abs=4e-12)
        assert algebraic_connectivity(cycle(n)) == pytest.approx(4 * math.sin(math.pi / n) ** 2, abs=4e-12)
        assert algebraic_connectivity(star(n)) == pytest.approx(1.0, abs=1e-12 * n)
        if n % 10 == 0:
            assert algebraic_connectivity(complete(n)) == pytest.approx(n, abs=1e-12 * n)


@pytest.mark.parametrize("kind", ["path", "cycle", "star"])
def test_closed_forms_of_large_graphs(kind: str) -> None:
    graph, values = closed_forms(3000)[kind]
    slack = 1e-12 * values[-1]
    assert algebraic_connectivity(graph) == pytest.approx(values[1], abs=slack)
    vector = fiedler_vector(graph)
    assert np.linalg.norm(laplacian(graph) @ vector - values[1] * vector) <= slack


# ---- oracles ----


@pytest.mark.parametrize("start", range(0, 300, 50))
def test_spectrum_and_lambda2_against_the_dense_matrix(start: int) -> None:
    for seed in range(start, start + 50):
        graph = random_graph(seed)
        expected = np.linalg.eigvalsh(dense(graph))
        values = spectrum(graph)
        parts = components(graph).max() + 1
        np.testing.assert_allclose(values, expected, atol=1e-12 * expected[-1])
        assert (values[:parts] == 0).all()
        assert (values[parts:] > 0).all()
        assert (np.diff(values) >= 0).all()
        assert algebraic_connectivity(graph) == pytest.approx(expected[1], abs=1e-12 * expected[-1])
        assert (algebraic_connectivity(graph) == 0) == (parts > 1)


@pytest.mark.parametrize("seed", range(8))
def test_spectrum_against_sixty_digits(seed: int) -> None:
    graph = random_graph(seed, largest=10)
    with mpmath.workdps(60):
        exact = mpmath.zeros(graph.n)
        for (i, j), weight in zip(graph.edges.tolist(), graph.lengths.tolist(), strict=True):
            for row, column, sign in ((i, i, 1), (j, j, 1), (i, j, -1), (j, i, -1)):
                exact[row, column] += sign * mpmath.mpf(weight)
        expected = [float(value) for value in mpmath.eigsy(exact, eigvals_only=True)]
    np.testing.assert_allclose(spectrum(graph), expected, atol=1e-14 * max(expected))


def test_lambda2_against_networkx() -> None:
    for seed in range(10):
        graph = random_connected(4 * seed)  # moderate weights
        other = nx.Graph()
        other.add_weighted_edges_from(
            (*edge, weight) for edge, weight in zip(graph.edges.tolist(), graph.lengths.tolist(), strict=True)
        )
        expected = nx.algebraic_connectivity(other, method="tracemin_lu", tol=1e-12)
        assert algebraic_connectivity(graph) == pytest.approx(expected, rel=1e-7)


@pytest.mark.usefixtures("always_sparse")
@pytest.mark.parametrize("start", range(0, 100, 25))
def test_the_way_of_large_graphs_agrees_on_small_ones(start: int) -> None:
    for seed in range(start, start + 25):
        graph = random_graph(seed)
        expected = np.linalg.eigvalsh(dense(graph))
        assert algebraic_connectivity(graph) == pytest.approx(expected[1], abs=1e-12 * expected[-1])


@pytest.mark.usefixtures("always_sparse")
@pytest.mark.parametrize(
    "graph",
    [lattice(20, 20)[0], lattice(100, 4)[0], regular(400, 3), regular(400, 16)],
    ids=["square", "corridor", "cubic", "16-regular"],
)
def test_both_ways_of_large_graphs_agree_with_lapack(graph: Graph) -> None:
    expected = np.linalg.eigvalsh(dense(graph))
    assert algebraic_connectivity(graph) == pytest.approx(expected[1], abs=1e-12 * expected[-1])
    of = lanczos.Laplacian(graph, laplacian(graph), float(expected[-1]))
    for make in (lanczos._direct, lanczos._inverse):
        way = make(of)
        found = lanczos._settled(lanczos._filtered(way, lanczos._start(graph.n), None), of, way)
        assert found is not None
        assert found.value == pytest.approx(expected[1], abs=1e-12 * expected[-1])


@pytest.mark.usefixtures("always_sparse")
def test_large_graphs_with_weights_of_thirty_magnitudes() -> None:
    rng = np.random.default_rng(3)
    tree = Graph.from_edges(300, list(nx.random_labeled_tree(300, seed=1).edges))
    for graph in (lattice(18, 18)[0], tree):
        wild = Graph.from_edges(graph.n, graph.edges, 10.0 ** rng.uniform(-15, 15, graph.m))
        assert lanczos.least(Graph.from_edges(graph.n, graph.edges, wild.lengths / wild.lengths.max())) is not None
        expected = np.linalg.eigvalsh(dense(wild))
        value = algebraic_connectivity(wild)
        assert value > 0
        assert value == pytest.approx(max(expected[1], 0), abs=1e-12 * expected[-1])
        vector = fiedler_vector(wild)
        assert quotient(wild, vector) <= value + 3e-12 * expected[-1]


def test_a_vector_is_accepted_when_its_quotient_or_its_residual_is_negligible() -> None:
    graph = Graph.from_edges(4, [(0, 1), (1, 2), (2, 3)], [1.0, 1e-20, 1.0])
    of = lanczos.Laplacian(graph, laplacian(graph), 2.0)
    idle = lanczos.Way(apply=lambda x: x, image=lambda x: x, accuracy=lambda x: x, steps=1)
    least, disturbance = np.array([0.5, 0.5, -0.5, -0.5]), np.array([0.5, -0.5, 0.5, -0.5])
    for amount, accepted in ((0.0, True), (1e-7, True), (1e-5, False), (1e20, True)):
        assert (lanczos._settled(least + amount * disturbance, of, idle) is not None) == accepted


@pytest.mark.usefixtures("always_sparse")
def test_where_no_way_converges_lapack_takes_over(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(lanczos, "_settled", lambda *_: None)
    assert algebraic_connectivity(cycle(50)) == pytest.approx(4 * math.sin(math.pi / 50) ** 2, abs=1e-13)
    vector = fiedler_vector(cycle(50))
    assert quotient(cycle(50), vector) == pytest.approx(4 * math.sin(math.pi / 50) ** 2, abs=1e-13)


# ---- eigenpairs ----


@pytest.mark.parametrize("seed", range(40))
def test_eigenpairs_are_accurate_to_rounding(seed: int) -> None:
    graph = random_graph(seed, largest=80)
    pairs = eigenpairs(graph)
    parts = int(components(graph).max()) + 1
    assert np.array_equal(pairs.labels, components(graph))
    assert pairs.values.shape == (graph.n - parts,)
    assert (pairs.values > 0).all()
    assert (np.diff(pairs.values) >= 0).all()
    unit = np.finfo(float).eps
    largest = pairs.values.max(initial=0.0)
    residual = dense(graph) @ pairs.vectors - pairs.vectors * pairs.values
    assert np.abs(residual).max(initial=0.0) <= 20 * unit * largest
    assert np.abs(pairs.vectors.T @ pairs.vectors - np.eye(graph.n - parts)).max(initial=0.0) <= 40 * unit
    for label in range(parts):
        inside = pairs.labels == label
        assert np.abs(pairs.vectors[inside].sum(axis=0)).max(initial=0.0) <= 40 * unit


def test_vectors_of_one_component_vanish_on_the_others() -> None:
    pairs = eigenpairs(Graph.from_edges(5, [(0, 2), (1, 3), (3, 4)]))
    for vector in pairs.vectors.T:
        assert len(set(pairs.labels[vector != 0])) == 1


# ---- small, large and bad input ----


def test_graphs_of_few_vertices() -> None:
    assert spectrum(Graph.from_edges(0, [])).tolist() == []
    assert spectrum(Graph.from_edges(1, [])).tolist() == [0.0]
    assert eigenpairs(Graph.from_edges(0, [])).vectors.shape == (0, 0)
    assert eigenpairs(Graph.from_edges(2, [])).vectors.shape == (2, 0)
    assert [algebraic_connectivity(Graph.from_edges(n, [])) for n in range(3)] == [0.0, 0.0, 0.0]
    for n in (0, 1):
        with pytest.raises(ValueError, match="takes two"):
            fiedler_vector(Graph.from_edges(n, []))


def test_edges_of_weight_zero_do_not_count() -> None:
    graph = Graph.from_edges(4, [(0, 1), (1, 2), (2, 3)], [1.0, 0.0, 2.0])
    np.testing.assert_allclose(spectrum(graph), [0, 0, 2, 4], atol=1e-15)
    assert algebraic_connectivity(graph) == 0.0
    assert eigenpairs(graph).vectors.shape == (4, 2)


@pytest.mark.parametrize("scale", [2.0**-1060, 1e-300, 1e-9, 1e9, 1e300])
def test_the_unit_of_weight_does_not_matter(scale: float) -> None:
    graph = cycle(12)
    scaled = Graph.from_edges(12, graph.edges, graph.lengths * scale)
    expected = spectrum(graph)
    np.testing.assert_allclose(spectrum(scaled) / scale, expected, atol=2e-4 if scale < 1e-310 else 1e-14)
    np.testing.assert_allclose(fiedler_vector(scaled), fiedler_vector(graph), atol=1e-12)


def test_a_link_hidden_by_rounding_still_connects() -> None:
    for weak in (1e-30, 1e-300, 5e-324):
        graph = Graph.from_edges(4, [(0, 1), (1, 2), (2, 3)], [1.0, weak, 1.0])
        value = algebraic_connectivity(graph)
        assert 0 < value <= 1e-15
        assert (spectrum(graph)[:2] > 0).tolist() == [False, True]
        assert (eigenpairs(graph).values > 0).all()


def test_weights_whose_sums_overflow_are_refused() -> None:
    graph = Graph.from_edges(2, [(0, 1)], [1e308])
    for function in (spectrum, eigenpairs, algebraic_connectivity, fiedler_vector):
        with pytest.raises(ValueError, match="scale the weights down"):
            function(graph)


# ---- invariants ----


@st.composite
def weighted_graphs(draw: st.DrawFn, most: int = 9) -> Graph:
    n = draw(st.integers(2, most))
    pairs = [(i, j) for i in range(n) for j in range(i)]
    chosen = draw(st.lists(st.sampled_from(pairs), unique=True, min_size=n - 1))
    weights = st.integers(0, 5).map(float) | st.floats(0, 1e3)
    return Graph.from_edges(n, chosen, draw(st.lists(weights, min_size=len(chosen), max_size=len(chosen))))


@given(weighted_graphs(), st.data())
@settings(deadline=None)
def test_adding_an_edge_never_lowers_lambda2(graph: Graph, data: st.DataObject) -> None:
    i, j = sorted(data.draw(st.lists(st.integers(0, graph.n - 1), unique=True, min_size=2, max_size=2)))
    weight = data.draw(st.floats(0, 1e3))
    edges = {(a, b): w for (a, b), w in zip(graph.edges.tolist(), graph.lengths.tolist(), strict=True)}
    edges[i, j] = edges.get((i, j), 0.0) + weight
    more = Graph.from_edges(graph.n, list(edges), list(edges.values()))
    assert algebraic_connectivity(more) >= algebraic_connectivity(graph) - 1e-12 * spectrum(more)[-1]


@given(weighted_graphs(), st.data())
@settings(deadline=None)
def test_relabelling_changes_no_eigenvalue(graph: Graph, data: st.DataObject) -> None:
    order = data.draw(st.permutations(range(graph.n)))
    other = relabelled(graph, np.array(order))
    values = spectrum(graph)
    np.testing.assert_allclose(spectrum(other), values, atol=1e-12 * values[-1])
    assert algebraic_connectivity(other) == pytest.approx(algebraic_connectivity(graph), abs=1e-12 * values[-1])


# ---- Fiedler vectors ----


def symmetric_graphs() -> dict[str, tuple[Graph, Floats]]:
    """Return graphs whose λ2 is repeated, with places of their vertices."""
    turn = 2 * np.pi * np.arange(24) / 24
    around = np.stack([np.cos(turn + 0.3), np.sin(turn + 0.3)], axis=1)
    square, places = lattice(6, 6)
    cube, corners = lattice(4, 4, 4)
    return {
        "cycle": (cycle(24), around),
        "square": (square, places @ [[0.8, 0.6], [-0.6, 0.8]]),
        "complete": (complete(24), around),
        "star": (star(24), around),
        "cube": (cube, corners[:, :2] + 0.1 * corners[:, 2:]),
        "parts": (Graph.from_edges(24, [(0, 3), (5, 7), (7, 9), (20, 21)]), around),
    }


WAYS = pytest.mark.parametrize("way", ["small", "always_sparse"])


@WAYS
@pytest.mark.parametrize("kind", symmetric_graphs())
def test_fiedler_vectors_of_repeated_eigenvalues_are_the_nearest_to_the_first_array(
    kind: str, way: str, request: pytest.FixtureRequest
) -> None:
    if way == "always_sparse":
        request.getfixturevalue(way)
    graph, places = symmetric_graphs()[kind]
    values, vectors = np.linalg.eigh(dense(graph))
    space = vectors[:, np.abs(values - values[1]) <= 1e-12 * values[-1]]
    if kind == "parts":
        space = np.linalg.svd(space - space.mean(axis=0), full_matrices=False)[0][:, : space.shape[1] - 1]
    nearest = space @ (space.T @ places[:, 0])
    found = fiedler_vector(graph, places.T)
    np.testing.assert_allclose(found, nearest / np.linalg.norm(nearest), atol=1e-9)


@WAYS
@pytest.mark.parametrize("kind", symmetric_graphs())
def test_fiedler_vectors_move_with_their_vertices(kind: str, way: str, request: pytest.FixtureRequest) -> None:
    if way == "always_sparse":
        request.getfixturevalue(way)
    graph, places = symmetric_graphs()[kind]
    order = np.random.default_rng(7).permutation(graph.n)
    moved = np.empty_like(places)
    moved[order] = places
    found = fiedler_vector(relabelled(graph, order), moved.T)
    np.testing.assert_allclose(found[order], fiedler_vector(graph, places.T), atol=1e-9)


@given(weighted_graphs())
@settings(max_examples=60, deadline=None)
def test_a_fiedler_vector_is_a_unit_vector_of_lambda2_without_constant(graph: Graph) -> None:
    vector = fiedler_vector(graph)
    largest = spectrum(graph)[-1]
    value = algebraic_connectivity(graph)
    assert np.linalg.norm(vector) == pytest.approx(1.0, abs=1e-14)
    assert vector.sum() == pytest.approx(0.0, abs=1e-13)
    assert np.linalg.norm(dense(graph) @ vector - value * vector) <= 2e-12 * largest


def test_the_first_array_that_is_not_orthogonal_decides() -> None:
    graph, places = lattice(9, 4)  # λ2 is simple: its vector runs along x
    x, y = places.T
    along = fiedler_vector(graph, [x])
    assert along @ x > 0
    np.testing.assert_allclose(fiedler_vector(graph, [y, x]), along, atol=1e-12)
    np.testing.assert_allclose(fiedler_vector(graph, [y, -x]), -along, atol=1e-12)
    np.testing.assert_allclose(fiedler_vector(graph, [np.full(36, 0.1), np.zeros(36), x]), along, atol=1e-12)
    corner = fiedler_vector(graph, [y])
    assert corner[0] > 0  # vertex 0 decides
    np.testing.assert_allclose(fiedler_vector(graph, []), corner, atol=1e-12)
    np.testing.assert_allclose(fiedler_vector(graph), fiedler_vector(graph, [np.arange(36)]), atol=0)


def test_the_first_array_that_is_not_orthogonal_decides_on_large_graphs() -> None:
    graph, places = lattice(60, 20)
    x, y = places.T
    expected = np.cos(np.pi * (x + 0.5) / 60)
    expected /= -np.linalg.norm(expected)
    np.testing.assert_allclose(fiedler_vector(graph, [y, x]), expected, atol=1e-9)
    np.testing.assert_allclose(fiedler_vector(graph, [y, -x]), -expected, atol=1e-9)
    np.testing.assert_allclose(fiedler_vector(graph, [np.full(1200, 0.1), y]), -expected, atol=1e-9)


def test_a_disconnected_graph_has_a_vector_constant_on_its_parts() -> None:
    graph = Graph.from_edges(5, [(0, 1), (2, 3), (3, 4)])
    expected = np.array([-3, -3, 2, 2, 2]) / math.sqrt(30)
    np.testing.assert_allclose(fiedler_vector(graph), expected, atol=1e-15)
    np.testing.assert_allclose(fiedler_vector(graph, [[1, 0, 0, 0, 0]]), -expected, atol=1e-15)


def test_bad_arrays_are_named() -> None:
    with pytest.raises(ValueError, match=r"towards\[0\] has shape \(3, 2\).*positions.T"):
        fiedler_vector(path(3), [np.zeros((3, 2))])
    with pytest.raises(ValueError, match=r"towards\[1\] is not finite at vertex 2"):
        fiedler_vector(path(3), [[0.0, 1.0, 2.0], [0.0, 0.0, math.nan]])


def test_the_same_bits_again() -> None:
    for graph in (random_connected(1), regular(1100, 4), lattice(40, 40)[0]):
        assert algebraic_connectivity(graph) == algebraic_connectivity(graph)
        assert np.array_equal(fiedler_vector(graph), fiedler_vector(graph))
