"""Spanning trees are lightest, heaviest and counted right."""

from __future__ import annotations

import math
from itertools import combinations

import networkx as nx
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from taut.graph import Graph
from taut.graph.trees import log_spanning_tree_count, maximum_spanning_tree, spanning_tree, spanning_tree_count


def of_networkx(graph: nx.Graph) -> Graph:
    return Graph.from_edges(graph.number_of_nodes(), list(nx.convert_node_labels_to_integers(graph).edges))


@st.composite
def graphs(draw: st.DrawFn) -> Graph:
    """Draw a graph of at most 7 vertices with many equal weights, some of 0."""
    n = draw(st.integers(1, 7))
    pairs = list(combinations(range(n), 2))
    chosen = draw(st.lists(st.sampled_from(pairs), unique=True, max_size=11)) if pairs else []
    weight = st.integers(0, 3).map(float)
    return Graph.from_edges(n, chosen, draw(st.lists(weight, min_size=len(chosen), max_size=len(chosen))))


def forests(graph: Graph) -> list[tuple[int, ...]]:
    """Every choice of edges that is a spanning forest, by trying them all, in lexicographic order."""
    joined = nx.Graph(graph.edges.tolist())
    joined.add_nodes_from(range(graph.n))
    size = graph.n - nx.number_connected_components(joined)
    edges = graph.edges.tolist()
    out = []
    for chosen in combinations(range(graph.m), size):
        tree = nx.Graph([edges[e] for e in chosen])
        if size == 0 or nx.is_forest(tree):
            out.append(chosen)
    return out


@settings(deadline=None, max_examples=80)
@given(graphs())
def test_trees_are_the_first_of_the_lightest_and_of_the_heaviest(graph: Graph) -> None:
    weights, every = graph.lengths, forests(graph)
    for sign, tree in ((1, spanning_tree(graph)), (-1, maximum_spanning_tree(graph))):
        best = min(every, key=lambda chosen: (sign * weights[list(chosen)].sum(), chosen))
        assert tree.n == graph.n
        assert tree.edges.tolist() == graph.edges[list(best)].tolist()
        assert tree.lengths.tolist() == weights[list(best)].tolist()


@settings(deadline=None, max_examples=80)
@given(graphs())
def test_count_equals_trying_all(graph: Graph) -> None:
    kept = graph.lengths > 0
    links = Graph.from_edges(graph.n, graph.edges[kept])
    expected = sum(len(chosen) == graph.n - 1 for chosen in forests(links))
    assert spanning_tree_count(graph) == expected
    assert log_spanning_tree_count(graph) == pytest.approx(math.log(expected) if expected else -math.inf, abs=1e-14)


@pytest.mark.parametrize("n", [1, 2, 3, 4, 10, 60])
def test_cayley(n: int) -> None:
    count = spanning_tree_count(of_networkx(nx.complete_graph(n)))
    assert count == (n ** (n - 2) if n > 1 else 1)
    assert isinstance(count, int)


@pytest.mark.parametrize(("a", "b"), [(1, 1), (1, 6), (2, 3), (5, 8), (20, 31)])
def test_complete_bipartite_graphs(a: int, b: int) -> None:
    assert spanning_tree_count(of_networkx(nx.complete_bipartite_graph(a, b))) == a ** (b - 1) * b ** (a - 1)


@pytest.mark.parametrize("n", [4, 5, 12, 80])
def test_wheels_cycles_paths_and_stars(n: int) -> None:
    before, lucas = 2, 1
    for _ in range(2 * (n - 1) - 1):
        before, lucas = lucas, before + lucas
    assert spanning_tree_count(of_networkx(nx.wheel_graph(n))) == lucas - 2
    assert spanning_tree_count(of_networkx(nx.cycle_graph(n))) == n
    assert spanning_tree_count(of_networkx(nx.path_graph(n))) == 1
    assert spanning_tree_count(of_networkx(nx.star_graph(n - 1))) == 1


def test_count_and_its_logarithm_agree_on_large_graphs() -> None:
    grid = of_networkx(nx.grid_2d_graph(15, 20))
    assert log_spanning_tree_count(grid) == pytest.approx(math.log(spanning_tree_count(grid)), rel=1e-14)
    # 4 G / π, G Catalan’s constant: the growth of the number of spanning trees of the square lattice (Wu 1977)
    assert log_spanning_tree_count(of_networkx(nx.grid_2d_graph(100, 100))) / 1e4 == pytest.approx(1.1662, rel=0.02)


def test_the_count_of_a_grid_equals_its_product_formula() -> None:
    rows, columns = 4, 6
    product = math.prod(
        4 - 2 * math.cos(math.pi * i / rows) - 2 * math.cos(math.pi * j / columns)
        for i in range(rows)
        for j in range(columns)
        if i or j
    )
    assert spanning_tree_count(of_networkx(nx.grid_2d_graph(rows, columns))) == round(product / (rows * columns))


def test_weights_do_not_change_the_count_but_0_does_not_connect() -> None:
    edges = [(0, 1), (1, 2), (0, 2)]
    assert spanning_tree_count(Graph.from_edges(3, edges, [0.1, 7.0, 1e300])) == 3
    assert spanning_tree_count(Graph.from_edges(3, edges, [1.0, 7.0, 0.0])) == 1
    assert spanning_tree_count(Graph.from_edges(3, edges, [1.0, 0.0, 0.0])) == 0


def test_an_edge_of_length_0_is_an_edge_of_a_tree() -> None:
    graph = Graph.from_edges(3, [(0, 1), (1, 2), (0, 2)], [0.0, 0.0, 1.0])
    assert spanning_tree(graph).edges.tolist() == [[0, 1], [1, 2]]
    assert spanning_tree(graph).lengths.tolist() == [0.0, 0.0]
    assert maximum_spanning_tree(graph).edges.tolist() == [[0, 1], [0, 2]]


def test_graphs_without_edges() -> None:
    assert spanning_tree_count(Graph.from_edges(0, [])) == 0
    assert spanning_tree_count(Graph.from_edges(1, [])) == 1
    assert spanning_tree_count(Graph.from_edges(2, [])) == 0
    assert log_spanning_tree_count(Graph.from_edges(0, [])) == -math.inf
    assert log_spanning_tree_count(Graph.from_edges(1, [])) == 0.0
    for n in (0, 1, 3):
        assert (spanning_tree(Graph.from_edges(n, [])).n, maximum_spanning_tree(Graph.from_edges(n, [])).m) == (n, 0)


def test_trees_of_larger_graphs_weigh_what_networkx_finds() -> None:
    rng = np.random.default_rng(1)
    graph = nx.gnm_random_graph(300, 2000, seed=2)
    weights = rng.random(2000).round(1)
    nx.set_edge_attributes(graph, dict(zip(graph.edges, weights.tolist(), strict=True)), "weight")
    ours = Graph.from_edges(300, list(graph.edges), weights)
    for tree, other in (
        (spanning_tree(ours), nx.minimum_spanning_tree(graph)),
        (maximum_spanning_tree(ours), nx.maximum_spanning_tree(graph)),
    ):
        assert tree.lengths.sum() == pytest.approx(other.size("weight"), abs=1e-9)
        assert tree.m == 299
