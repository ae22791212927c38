"""Bounds hold, and are attained where theory says so."""

from __future__ import annotations

import math
from itertools import combinations

import networkx as nx
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from taut.graph import Graph
from taut.graph.bounds import Bound, connectivity_bounds, isoperimetric_bounds


def of_networkx(graph: nx.Graph) -> Graph:
    return Graph.from_edges(graph.number_of_nodes(), list(nx.convert_node_labels_to_integers(graph).edges))


def dense_laplacian(graph: Graph) -> np.ndarray[tuple[int, int], np.dtype[np.float64]]:
    out = np.zeros((graph.n, graph.n))
    out[tuple(graph.edges.T)] = -graph.lengths
    out += out.T
    np.fill_diagonal(out, -out.sum(axis=1))
    return out


def connectivity(graph: Graph) -> float:
    return float(np.linalg.eigvalsh(dense_laplacian(graph))[1])


def isoperimetric_number(graph: Graph) -> float:
    """Least w(∂S) / |S| by trying every S."""
    laplacian, best = dense_laplacian(graph), math.inf
    for size in range(1, graph.n // 2 + 1):
        for chosen in combinations(range(graph.n), size):
            side = np.zeros(graph.n)
            side[list(chosen)] = 1.0
            best = min(best, float(side @ laplacian @ side) / size)
    return best


def exact(graph: Graph) -> dict[str, float]:
    return {bound.name: bound.value for bound in connectivity_bounds(graph) if bound.side == "exact"}


def value_of(graph: Graph, name: str, side: str) -> float | None:
    return next((b.value for b in connectivity_bounds(graph) if (b.name, b.side) == (name, side)), None)


def check(bounds: tuple[Bound, ...], connectivity: float, scale: float) -> None:
    slack = 1e-12 * scale
    for bound in bounds:
        if bound.side in ("lower", "exact"):
            assert bound.value <= connectivity + slack, bound
        if bound.side in ("upper", "exact"):
            assert bound.value >= connectivity - slack, bound


@st.composite
def graphs(draw: st.DrawFn, weight: st.SearchStrategy[float], most: int) -> Graph:
    """Draw a graph, mostly connected, with weights of one kind."""
    n = draw(st.integers(2, most))
    tree = {(draw(st.integers(0, i - 1)), i) for i in range(1, n)} if draw(st.integers(0, 5)) else set()
    more = draw(st.lists(st.sampled_from(list(combinations(range(n), 2))), unique=True, max_size=3 * n))
    edges = sorted(tree | set(more))
    return Graph.from_edges(n, edges, draw(st.lists(weight, min_size=len(edges), max_size=len(edges))))


ONE = st.just(1.0)
MIXED = st.sampled_from([0.0, 1.0, 1.0]) | st.floats(1e-3, 50)


@settings(deadline=None, max_examples=120)
@given(graphs(ONE, 12) | graphs(MIXED, 12))
def test_every_bound_holds(graph: Graph) -> None:
    values = np.linalg.eigvalsh(dense_laplacian(graph))
    check(connectivity_bounds(graph), float(values[1]), float(values[-1]))


@pytest.mark.parametrize("seed", range(3))
def test_every_bound_holds_on_larger_graphs(seed: int) -> None:
    graph = of_networkx(nx.connected_watts_strogatz_graph(150, 6, 0.05, seed=seed))
    weights = 10.0 ** np.random.default_rng(seed).uniform(-2, 2, graph.m)
    for one in (graph, Graph.from_edges(graph.n, graph.edges, weights)):
        values = np.linalg.eigvalsh(dense_laplacian(one))
        bounds = connectivity_bounds(one)
        check(bounds, float(values[1]), float(values[-1]))
        assert {bound.side for bound in bounds} == {"lower", "upper"}


@pytest.mark.parametrize("n", [2, 3, 4, 5, 10, 57, 200])
def test_families_have_their_exact_values(n: int) -> None:
    assert exact(of_networkx(nx.complete_graph(n)))["complete graph"] == n
    assert exact(of_networkx(nx.path_graph(n)))["path"] == pytest.approx(2 * (1 - math.cos(math.pi / n)), rel=1e-11)
    if n > 2:
        cycle = exact(of_networkx(nx.cycle_graph(n)))["cycle"]
        assert cycle == pytest.approx(2 * (1 - math.cos(2 * math.pi / n)), rel=1e-11)
        assert exact(of_networkx(nx.star_graph(n - 1)))["star"] == 1.0


def test_no_other_graph_is_taken_for_one_of_a_family() -> None:
    for graph in (
        nx.petersen_graph(),
        nx.wheel_graph(6),
        nx.complete_bipartite_graph(2, 3),
        nx.lollipop_graph(4, 2),
        nx.balanced_tree(2, 2),
        nx.Graph([(0, 1), (1, 2), (2, 0), (2, 3)]),
    ):
        assert exact(of_networkx(graph)) == {}
    weighted = Graph.from_edges(3, [(0, 1), (1, 2), (0, 2)], [1.0, 1.0, 2.0])
    assert exact(weighted) == {}


def test_bounds_of_the_thesis() -> None:
    petersen = of_networkx(nx.petersen_graph())  # λ2 = 2, degree 3
    assert value_of(petersen, "not complete", "upper") == 8
    assert value_of(petersen, "least degree", "lower") == 2 * 3 - 10 + 2
    assert value_of(petersen, "least degree", "upper") == pytest.approx(10 / 9 * 3)
    heavier = Graph.from_edges(10, petersen.edges, np.full(15, 2.0))
    assert value_of(heavier, "least degree", "upper") == pytest.approx(10 / 9 * 6)
    assert value_of(heavier, "least degree", "lower") is None
    assert value_of(heavier, "not complete", "upper") is None


def test_a_cut_vertex_limits_unit_weights_only() -> None:
    bow_tie = of_networkx(nx.windmill_graph(2, 3))
    assert value_of(bow_tie, "cut vertex", "upper") == 1.0 == pytest.approx(connectivity(bow_tie))
    assert value_of(Graph.from_edges(5, bow_tie.edges, np.full(6, 5.0)), "cut vertex", "upper") is None
    assert value_of(of_networkx(nx.cycle_graph(5)), "cut vertex", "upper") is None


@pytest.mark.parametrize(
    "graph", [nx.path_graph(9), nx.cycle_graph(10), nx.barbell_graph(5, 4), nx.petersen_graph(), nx.grid_2d_graph(4, 7)]
)
def test_the_diameter_is_the_true_one(graph: nx.Graph) -> None:
    ours = of_networkx(graph)
    assert value_of(ours, "diameter", "lower") == pytest.approx(4 / (ours.n * nx.diameter(graph)), rel=1e-15)


@settings(deadline=None, max_examples=40)
@given(graphs(ONE, 12))
def test_the_diameter_is_the_true_one_of_any_graph(graph: Graph) -> None:
    other = nx.Graph(graph.edges.tolist())
    if len(other) == graph.n and nx.is_connected(other):
        assert value_of(graph, "diameter", "lower") == pytest.approx(4 / (graph.n * nx.diameter(other)), rel=1e-15)


def test_resistances_bound_a_complete_graph_exactly_from_above() -> None:
    graph = of_networkx(nx.complete_graph(9))
    assert value_of(graph, "mean resistance", "upper") == pytest.approx(9, rel=1e-14)
    assert value_of(graph, "resistances", "lower") == pytest.approx(9 / 8, rel=1e-14)


def test_a_weak_link_is_found() -> None:
    barbell = of_networkx(nx.barbell_graph(4, 0))
    weights = np.where((barbell.edges == [3, 4]).all(axis=1), 1e-9, 1.0)
    graph = Graph.from_edges(8, barbell.edges, weights)
    assert value_of(graph, "weakest link", "upper") == pytest.approx(8 * 1e-9 / 16, rel=1e-14)
    np.testing.assert_array_equal(isoperimetric_bounds(graph).cut, [0, 1, 2, 3])


def test_disconnected_graphs_have_nothing_to_hold_them() -> None:
    graph = Graph.from_edges(5, [(0, 1), (1, 2), (2, 3), (3, 4)], [1.0, 1.0, 0.0, 1.0])
    assert [(bound.side, bound.value) for bound in connectivity_bounds(graph)] == [("exact", 0.0)]
    bounds = isoperimetric_bounds(graph)
    assert (bounds.lower, bounds.upper, bounds.cheeger, bounds.cut.tolist()) == (0.0, 0.0, 0.0, [3, 4])


@pytest.mark.parametrize("n", [0, 1])
def test_fewer_than_two_vertices(n: int) -> None:
    graph = Graph.from_edges(n, [])
    assert connectivity_bounds(graph) == ()
    with pytest.raises(ValueError, match="at least 2"):
        isoperimetric_bounds(graph)


@settings(deadline=None, max_examples=60)
@given(graphs(ONE, 9) | graphs(MIXED, 9))
def test_isoperimetric_bounds_hold(graph: Graph) -> None:
    check_isoperimetric(graph)


@pytest.mark.parametrize("n", range(2, 13))
def test_isoperimetric_bounds_hold_for_families(n: int) -> None:
    rng = np.random.default_rng(n)
    families = [nx.complete_graph(n), nx.path_graph(n), nx.star_graph(n - 1), nx.cycle_graph(n) if n > 2 else None]
    for family in filter(None, families):
        graph = of_networkx(family)
        check_isoperimetric(graph)
        check_isoperimetric(Graph.from_edges(n, graph.edges, 10.0 ** rng.uniform(-2, 2, graph.m)))


def check_isoperimetric(graph: Graph) -> None:
    bounds, number = isoperimetric_bounds(graph), isoperimetric_number(graph)
    slack = 1e-9 * float(np.abs(dense_laplacian(graph)).max())
    assert bounds.lower <= number + slack
    assert number <= bounds.upper + slack
    assert bounds.upper <= bounds.cheeger + slack
    side = np.zeros(graph.n)
    side[bounds.cut] = 1.0
    assert 1 <= len(bounds.cut) <= graph.n / 2
    assert bounds.upper == pytest.approx(side @ dense_laplacian(graph) @ side / len(bounds.cut), abs=slack)


@pytest.mark.parametrize("n", [4, 7, 12])
def test_sweeps_cut_paths_and_cycles_best(n: int) -> None:
    assert isoperimetric_bounds(of_networkx(nx.path_graph(n))).upper == pytest.approx(1 / (n // 2))
    assert isoperimetric_bounds(of_networkx(nx.cycle_graph(n))).upper == pytest.approx(2 / (n // 2))


def test_the_lower_isoperimetric_bound_is_attained_by_complete_graphs() -> None:
    for n in (2, 3, 8, 11):
        bounds = isoperimetric_bounds(of_networkx(nx.complete_graph(n)))
        assert bounds.lower == pytest.approx((n + 1) // 2, rel=1e-12)
        assert bounds.upper == pytest.approx((n + 1) // 2, rel=1e-12)
