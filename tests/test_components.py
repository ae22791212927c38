"""Components, cut edges and cut vertices are what removing edges and vertices shows."""

from __future__ import annotations

import networkx as nx
import numpy as np
from hypothesis import given, settings
from hypothesis import strategies as st

from taut.graph import Graph, components, connected, cut_edges, cut_vertices
from thesis_graphs import figure_4_2


@st.composite
def sparse_graphs(draw: st.DrawFn, most: int = 14) -> Graph:
    """Draw a graph with about as many edges as vertices, some of weight zero."""
    n = draw(st.integers(0, most))
    pairs = [(i, j) for i in range(n) for j in range(i)]
    chosen = draw(st.lists(st.sampled_from(pairs), unique=True, max_size=n + 3)) if pairs else []
    weights = st.sampled_from([0.0, 1.0, 1.0, 1.0, 5e-324, 1e300])
    return Graph.from_edges(n, chosen, draw(st.lists(weights, min_size=len(chosen), max_size=len(chosen))))


def oracle(graph: Graph) -> nx.Graph:
    out = nx.Graph()
    out.add_nodes_from(range(graph.n))
    out.add_edges_from(graph.edges[graph.lengths > 0].tolist())
    return out


def count(graph: nx.Graph) -> int:
    return int(nx.number_connected_components(graph))


@given(sparse_graphs())
@settings(deadline=None)
def test_components_share_a_label_exactly_where_a_path_of_positive_weight_joins(graph: Graph) -> None:
    labels = components(graph)
    assert labels.dtype == np.int64
    found = {frozenset(np.flatnonzero(labels == k).tolist()) for k in range(labels.max(initial=-1) + 1)}
    assert found == {frozenset(part) for part in nx.connected_components(oracle(graph))}
    assert connected(graph) == (len(found) <= 1)


@given(sparse_graphs())
@settings(deadline=None)
def test_labels_count_up_in_the_order_of_first_vertices(graph: Graph) -> None:
    labels = components(graph).tolist()
    assert list(dict.fromkeys(labels)) == list(range(len(set(labels))))


@given(sparse_graphs())
@settings(max_examples=300, deadline=None)
def test_a_cut_edge_is_one_whose_removal_makes_more_components(graph: Graph) -> None:
    whole = oracle(graph)
    expected = []
    for i, j in sorted(map(sorted, whole.edges)):
        without = whole.copy()
        without.remove_edge(i, j)
        if count(without) > count(whole):
            expected.append([i, j])
    assert cut_edges(graph).tolist() == expected


@given(sparse_graphs())
@settings(max_examples=300, deadline=None)
def test_a_cut_vertex_is_one_whose_removal_parts_its_neighbours(graph: Graph) -> None:
    whole = oracle(graph)
    expected = []
    for v in range(graph.n):
        without = whole.copy()
        without.remove_node(v)
        if count(without) > count(whole):
            expected.append(v)
    assert cut_vertices(graph).tolist() == expected


def test_an_edge_of_weight_zero_does_not_connect() -> None:
    graph = Graph.from_edges(3, [(0, 1), (1, 2)], [1.0, 0.0])
    assert components(graph).tolist() == [0, 0, 1]
    assert cut_edges(graph).tolist() == [[0, 1]]
    assert cut_vertices(graph).tolist() == []


def test_graphs_of_one_vertex_and_of_none_are_connected() -> None:
    for n in (0, 1):
        graph = Graph.from_edges(n, [])
        assert connected(graph)
        assert components(graph).tolist() == [0] * n
        assert cut_edges(graph).shape == (0, 2)
        assert cut_vertices(graph).shape == (0,)


def test_a_path_longer_than_any_recursion_is_all_cuts() -> None:
    n = 100_000
    path = Graph.from_edges(n, np.stack([np.arange(n - 1), np.arange(1, n)], axis=1))
    assert len(cut_edges(path)) == n - 1
    assert len(cut_vertices(path)) == n - 2


def test_the_graph_of_figure_4_2_hangs_by_one_edge_after_four_are_gone() -> None:
    four = ("e41", "e44", "e46", "e49")
    assert len(cut_edges(figure_4_2())) == 0
    assert cut_edges(figure_4_2(four)).tolist() == [[13, 15]]
    assert not connected(figure_4_2((*four, "e48")))
