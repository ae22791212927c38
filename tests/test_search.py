"""Breadth first and depth first visit what they promise, in the order they promise."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from taut.graph import Graph
from taut.graph.core import Ints
from taut.graph.search import breadth_first, depth_first
from test_graph import all_distances, figure_8_19, graphs


def recursive_depth_first(graph: Graph, source: int) -> tuple[list[int], list[int]]:
    """Textbook recursion."""
    order, before = [source], [-1] * graph.n

    def visit(u: int) -> None:
        for v in graph.indices[graph.indptr[u] : graph.indptr[u + 1]].tolist():
            if v not in order:
                order.append(v)
                before[v] = u
                visit(v)

    visit(source)
    return order, before


def levels(graph: Graph, source: int) -> tuple[list[int], list[int]]:
    """Level by level with lists: each vertex belongs to the neighbour that stands first in the level before."""
    hops, before, level = [-1] * graph.n, [-1] * graph.n, [source]
    hops[source] = 0
    while level:
        found = []
        for u in level:
            for v in sorted({b for a, b in graph.edges.tolist() if a == u} | {a for a, b in graph.edges if b == u}):
                if hops[v] < 0:
                    hops[v], before[v] = hops[u] + 1, u
                    found.append(v)
        level = found
    return hops, before


def path_graph(n: int) -> Graph:
    return Graph.from_edges(n, [(i, i + 1) for i in range(n - 1)])


def test_figure_8_19_breadth_first() -> None:
    hops, before = breadth_first(figure_8_19(), 0)
    assert hops.tolist() == [0, 1, 1, 2, 2, 1]
    assert before.tolist() == [-1, 0, 0, 1, 5, 0]


def test_figure_8_19_depth_first() -> None:
    order, before = depth_first(figure_8_19(), 0)
    assert (order + 1).tolist() == [1, 2, 3, 4, 5, 6]
    assert before.tolist() == [-1, 0, 1, 2, 3, 4]


@settings(deadline=None, max_examples=150)
@given(graphs(), st.data())
def test_breadth_first_equals_levels_and_has_the_fewest_edges(graph: Graph, data: st.DataObject) -> None:
    source = data.draw(st.integers(0, graph.n - 1))
    hops, before = breadth_first(graph, source)
    assert (hops.tolist(), before.tolist()) == levels(graph, source)
    fewest = all_distances(Graph.from_edges(graph.n, graph.edges))[source]
    assert np.where(hops < 0, math.inf, hops).tolist() == fewest.tolist()


@settings(deadline=None, max_examples=150)
@given(graphs(), st.data())
def test_depth_first_equals_the_recursion(graph: Graph, data: st.DataObject) -> None:
    source = data.draw(st.integers(0, graph.n - 1))
    order, before = depth_first(graph, source)
    assert (order.tolist(), before.tolist()) == recursive_depth_first(graph, source)


@settings(deadline=None, max_examples=100)
@given(graphs(), st.data())
def test_depth_first_joins_every_edge_to_an_ancestor(graph: Graph, data: st.DataObject) -> None:
    """The mark of a depth-first tree in an undirected graph: no edge crosses between branches."""
    source = data.draw(st.integers(0, graph.n - 1))
    order, before = depth_first(graph, source)
    place = {v: k for k, v in enumerate(order.tolist())}
    for a, b in graph.edges.tolist():
        if a in place:
            early, late = sorted((a, b), key=place.__getitem__)
            while place[late] > place[early]:
                late = int(before[late])
            assert late == early


def test_a_path_of_200_000_vertices_is_no_deeper_than_memory() -> None:
    graph = path_graph(200_000)
    order, before = depth_first(graph, 0)
    assert (order == np.arange(200_000)).all()
    assert (before == np.arange(-1, 199_999)).all()
    assert breadth_first(graph, 0)[0][-1] == 199_999


def test_isolated_and_single_vertices() -> None:
    for graph, source in ((Graph.from_edges(1, []), 0), (Graph.from_edges(3, [(0, 2)]), 1)):
        hops, seen = breadth_first(graph, source)
        order, before = depth_first(graph, source)
        assert hops.tolist() == [0 if v == source else -1 for v in range(graph.n)]
        assert order.tolist() == [source]
        assert (seen == -1).all()
        assert (before == -1).all()


@pytest.mark.parametrize("search", [breadth_first, depth_first])
@pytest.mark.parametrize("vertex", [-1, 6])
def test_searches_from_no_vertex_are_refused(search: object, vertex: int) -> None:
    assert callable(search)
    with pytest.raises(IndexError, match=f"vertex {vertex} "):
        search(figure_8_19(), vertex)
    with pytest.raises(IndexError, match="without vertices"):
        search(Graph.from_edges(0, []), vertex)


def test_weights_play_no_part() -> None:
    light, heavy = (Graph.from_edges(4, [(0, 1), (1, 2), (2, 3), (0, 3)], w) for w in ([0, 0, 0, 0], [1, 2, 3, 1e300]))
    results: list[list[Ints]] = [[*breadth_first(g, 0), *depth_first(g, 0)] for g in (light, heavy)]
    assert all((a == b).all() for a, b in zip(*results, strict=True))
