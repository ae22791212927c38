"""Rigidity in the plane agrees with counting, with ranks and with taking graphs apart."""

from __future__ import annotations

from itertools import combinations
from typing import Literal

import networkx as nx
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from taut.graph.core import Floats, Graph
from taut.graph.rigidity import (
    generic_globally_rigid,
    generic_minimally_rigid,
    generic_rank,
    generic_redundantly_rigid,
    generic_rigid,
    independent_edges,
    infinitesimal_motions,
    infinitesimally_rigid,
    redundant_edges,
    rigidity_matrix,
    vertex_connected,
)

Pairs = list[tuple[int, int]]

PRISM = [(0, 1), (1, 2), (0, 2), (3, 4), (4, 5), (3, 5), (0, 3), (1, 4), (2, 5)]
UTILITIES = [(i, j) for i in range(3) for j in range(3, 6)]
RANDOM = np.random.default_rng(5)


def cycle(n: int) -> Graph:
    return Graph.from_edges(n, [(i, (i + 1) % n) for i in range(n)])


def complete(n: int) -> Graph:
    return Graph.from_edges(n, list(combinations(range(n), 2)))


def without_edge(graph: Graph, edge: int) -> Graph:
    return Graph.from_edges(graph.n, np.delete(graph.edges, edge, axis=0))


def without_vertices(graph: Graph, gone: tuple[int, ...]) -> nx.Graph:
    out = nx.Graph(graph.edges.tolist())
    out.add_nodes_from(range(graph.n))
    out.remove_nodes_from(gone)
    return out


def rank_at(graph: Graph, positions: Floats) -> int:
    """Rank of the rigidity matrix written out entry by entry."""
    rows = np.zeros((graph.m, 2 * graph.n))
    for row, (i, j) in zip(rows, graph.edges.tolist(), strict=True):
        for k in (0, 1):
            row[2 * i + k] = positions[i, k] - positions[j, k]
            row[2 * j + k] = positions[j, k] - positions[i, k]
    return int(np.linalg.matrix_rank(rows)) if graph.m else 0


def laman_count_holds(n: int, edges: Pairs) -> bool:
    """Whether each k ≥ 2 vertices span at most 2 k − 3 edges."""
    return all(
        sum(i in some and j in some for i, j in edges) <= 2 * k - 3
        for k in range(2, n + 1)
        for some in map(set, combinations(range(n), k))
    )


@st.composite
def graphs(draw: st.DrawFn, most: int = 9) -> Graph:
    """Draw a graph, sparse or dense, with weights that must not matter."""
    n = draw(st.integers(0, most))
    pairs = list(combinations(range(n), 2))
    left_out = set(draw(st.lists(st.sampled_from(pairs), unique=True))) if pairs else set()
    kept = [pair for pair in pairs if pair not in left_out] if draw(st.booleans()) else sorted(left_out)
    return Graph.from_edges(n, kept, draw(st.lists(st.integers(0, 2), min_size=len(kept), max_size=len(kept))))


@st.composite
def henneberg(draw: st.DrawFn, most: int = 12) -> Graph:
    """Draw a graph built by Henneberg's two steps from an edge; each keeps minimal rigidity, and all are so built."""
    edges = {(0, 1)}
    n = draw(st.integers(2, most))
    for new in range(2, n):
        if new > 2 and draw(st.booleans()):  # take an edge out, join its ends and a third vertex with the new one
            i, j = draw(st.sampled_from(sorted(edges)))
            third = draw(st.sampled_from([v for v in range(new) if v not in (i, j)]))
            edges.remove((i, j))
            joined = [i, j, third]
        else:
            joined = draw(st.permutations(range(new)))[:2]
        edges |= {(v, new) for v in joined}
    return Graph.from_edges(n, draw(st.permutations(sorted(edges))))


def test_a_triangle_is_rigid_and_a_square_is_not() -> None:
    assert generic_rigid(cycle(3))
    assert generic_minimally_rigid(cycle(3))
    assert generic_globally_rigid(cycle(3))
    assert not generic_redundantly_rigid(cycle(3))
    assert not generic_rigid(cycle(4))
    assert not generic_minimally_rigid(cycle(4))
    assert generic_rank(cycle(4)) == 4


def test_four_vertices_need_five_edges_to_be_rigid_and_six_to_be_globally_so() -> None:
    diamond = without_edge(complete(4), 2)
    assert generic_minimally_rigid(diamond)
    assert not generic_redundantly_rigid(diamond)
    assert not generic_globally_rigid(diamond)
    assert generic_rigid(complete(4))
    assert not generic_minimally_rigid(complete(4))
    assert generic_redundantly_rigid(complete(4))
    assert generic_globally_rigid(complete(4))
    assert independent_edges(complete(4)).tolist() == [True] * 5 + [False]


@pytest.mark.parametrize(
    ("n", "edges", "rigid", "minimally", "redundantly", "globally"),
    [
        (0, [], True, True, True, True),
        (1, [], True, True, True, True),
        (2, [], False, False, False, False),
        (2, [(0, 1)], True, True, False, True),
        (3, [(0, 1), (1, 2)], False, False, False, False),
        (3, [(0, 1), (1, 2), (0, 2)], True, True, False, True),
        (4, [(0, 1), (1, 2), (0, 2)], False, False, False, False),
    ],
)
def test_small_graphs(n: int, edges: Pairs, rigid: bool, minimally: bool, redundantly: bool, globally: bool) -> None:
    graph = Graph.from_edges(n, edges)
    assert generic_rigid(graph) == rigid
    assert generic_minimally_rigid(graph) == minimally
    assert generic_redundantly_rigid(graph) == redundantly
    assert generic_globally_rigid(graph) == globally
    positions = RANDOM.uniform(-1, 1, (n, 2))
    assert infinitesimally_rigid(graph, positions) == rigid
    assert (infinitesimal_motions(graph, positions).shape[1] == 0) == rigid


def test_edges_of_weight_zero_are_bars() -> None:
    assert generic_globally_rigid(Graph.from_edges(4, list(combinations(range(4), 2)), np.zeros(6)))


def test_redundant_but_not_globally_rigid_without_three_ways() -> None:
    """Two K4 that share two vertices: one may be mirrored in the line through them."""
    hinged = Graph.from_edges(6, [*combinations(range(4), 2), (2, 4), (2, 5), (3, 4), (3, 5), (4, 5)])
    assert generic_redundantly_rigid(hinged)
    assert not vertex_connected(hinged, 3)
    assert not generic_globally_rigid(hinged)


def test_the_utility_graph_is_minimally_rigid_but_flexes_on_a_conic() -> None:
    graph = Graph.from_edges(6, UTILITIES)
    assert generic_minimally_rigid(graph)
    assert not generic_globally_rigid(graph)
    angles = np.array([0.1, 1.3, 2.9, 3.3, 4.4, 5.6])
    circle = np.stack([np.cos(angles), np.sin(angles)], axis=1)
    for conic in (circle, circle * np.array([3, 0.5]) + 7):
        assert not infinitesimally_rigid(graph, conic)
        assert infinitesimal_motions(graph, conic).shape == (12, 1)
    off = circle.copy()
    off[0] *= 1.1
    assert infinitesimally_rigid(graph, off)


def test_the_prism_is_rigid_unless_its_three_bars_meet() -> None:
    graph = Graph.from_edges(6, PRISM)
    assert generic_minimally_rigid(graph)
    inner = np.array([(0, 0), (2, 0), (0, 2)], dtype=np.float64)
    shifted, grown = inner + np.array([1, 5]), 3 * inner - 1
    for special in (shifted, grown):  # the bars are parallel, or meet in a point
        assert not infinitesimally_rigid(graph, np.concatenate([inner, special]))
    turned = np.array([(0, -1), (5, 1), (-1, 4)])
    assert infinitesimally_rigid(graph, np.concatenate([inner, turned]))


def test_all_small_laman_graphs_by_counting() -> None:
    for n, pairs in ((4, list(combinations(range(4), 2))), (5, list(combinations(range(5), 2)))):
        for edges in combinations(pairs, 2 * n - 3):
            assert generic_minimally_rigid(Graph.from_edges(n, edges)) == laman_count_holds(n, list(edges))


@settings(deadline=None, max_examples=60)
@given(graphs(most=7))
def test_kept_edges_are_the_first_that_stay_within_lamans_count(graph: Graph) -> None:
    kept: Pairs = []
    for (i, j), independent in zip(graph.edges.tolist(), independent_edges(graph).tolist(), strict=True):
        assert independent == laman_count_holds(graph.n, [*kept, (i, j)])
        if independent:
            kept.append((i, j))


@settings(deadline=None, max_examples=150)
@given(graphs(), st.integers(0, 2**32 - 1))
def test_generic_rank_is_the_rank_at_random_positions(graph: Graph, seed: int) -> None:
    positions = np.random.default_rng(seed).uniform(-1, 1, (graph.n, 2))
    assert generic_rank(graph) == rank_at(graph, positions)
    assert generic_rigid(graph) == infinitesimally_rigid(graph, positions)


def test_generic_rank_of_large_graphs_is_the_rank_at_random_positions() -> None:
    for n, m in ((60, 110), (60, 125), (80, 200)):
        pairs = np.array(list(combinations(range(n), 2)))
        graph = Graph.from_edges(n, pairs[RANDOM.choice(len(pairs), m, replace=False)])
        assert generic_rank(graph) == rank_at(graph, RANDOM.uniform(-1, 1, (n, 2)))
        assert redundant_edges(graph).tolist() == [
            generic_rank(without_edge(graph, edge)) == generic_rank(graph) for edge in range(m)
        ]


@settings(deadline=None, max_examples=150)
@given(graphs())
def test_redundant_and_global_rigidity_by_taking_edges_and_pairs_away(graph: Graph) -> None:
    spared = [generic_rank(without_edge(graph, edge)) == generic_rank(graph) for edge in range(graph.m)]
    assert redundant_edges(graph).tolist() == spared
    redundantly = generic_rigid(graph) and all(spared)
    assert generic_redundantly_rigid(graph) == redundantly
    if graph.n >= 4:
        held = all(nx.is_connected(without_vertices(graph, pair)) for pair in combinations(range(graph.n), 2))
        assert generic_globally_rigid(graph) == (redundantly and held)


@settings(deadline=None, max_examples=150)
@given(graphs(), st.sampled_from([1, 2, 3]))
def test_vertex_connected_by_taking_vertices_away(graph: Graph, k: Literal[1, 2, 3]) -> None:
    held = graph.n > k and all(
        nx.is_connected(without_vertices(graph, some))
        for fewer in range(k)
        for some in combinations(range(graph.n), fewer)
    )
    assert vertex_connected(graph, k) == held


@settings(deadline=None, max_examples=80)
@given(henneberg())
def test_henneberg_constructions_are_minimally_rigid(graph: Graph) -> None:
    assert generic_minimally_rigid(graph)
    assert not redundant_edges(graph).any()
    for edge in range(graph.m):
        assert not generic_rigid(without_edge(graph, edge))


@settings(deadline=None, max_examples=60)
@given(graphs(most=8), st.data())
def test_relabelling_changes_no_generic_property(graph: Graph, data: st.DataObject) -> None:
    names = np.array(data.draw(st.permutations(range(graph.n))), dtype=np.int64)
    other = Graph.from_edges(graph.n, names[graph.edges])
    for said in (generic_rank, generic_rigid, generic_redundantly_rigid, generic_globally_rigid):
        assert said(graph) == said(other)


@settings(deadline=None, max_examples=60)
@given(graphs(most=7), st.integers(0, 2**32 - 1))
def test_infinitesimal_motions_keep_lengths_and_are_orthogonal_to_motions_of_the_whole(graph: Graph, seed: int) -> None:
    positions = np.random.default_rng(seed).integers(-2, 3, (graph.n, 2)).astype(np.float64)
    motions = infinitesimal_motions(graph, positions)
    assert np.allclose(rigidity_matrix(graph, positions).toarray() @ motions, 0, atol=1e-12)
    assert np.allclose(motions.T @ motions, np.eye(motions.shape[1]), atol=1e-12)
    velocities = motions.T.reshape(motions.shape[1], graph.n, 2)
    assert np.allclose(velocities.sum(axis=1), 0, atol=1e-12)
    spins = velocities[..., 1] * positions[:, 0] - velocities[..., 0] * positions[:, 1]
    assert np.allclose(spins.sum(axis=1), 0, atol=1e-12)
    whole = 0 if graph.n == 0 else 2 if not np.ptp(positions, axis=0).any() else 3
    assert motions.shape[1] == 2 * graph.n - rank_at(graph, positions) - whole
    assert (motions.shape[1] == 0) == infinitesimally_rigid(graph, positions)


@pytest.mark.parametrize("scale", [1e-300, 1e-9, 1.0, 1e9, 1e300])
@pytest.mark.parametrize("place", [0.0, 1.0, 1e4])
def test_size_and_place_do_not_matter(scale: float, place: float) -> None:
    positions = (RANDOM.uniform(-1, 1, (6, 2)) + place) * scale
    for edges in (PRISM, UTILITIES):
        assert infinitesimally_rigid(Graph.from_edges(6, edges), positions)
        assert infinitesimal_motions(Graph.from_edges(6, edges), positions).shape == (12, 0)
    assert not infinitesimally_rigid(cycle(6), positions)


def test_coinciding_and_collinear_vertices_flex() -> None:
    assert not infinitesimally_rigid(complete(3), [(0, 0), (1, 1), (2, 2)])
    assert not infinitesimally_rigid(complete(2), [(1, 1), (1, 1)])
    assert not infinitesimally_rigid(complete(4), np.zeros((4, 2)))
    assert infinitesimal_motions(complete(4), np.zeros((4, 2))).shape == (8, 6)


def test_rows_of_the_rigidity_matrix_are_half_the_rates_of_squared_lengths() -> None:
    graph = Graph.from_edges(6, PRISM)
    positions, velocities = RANDOM.uniform(-5, 5, (2, 6, 2))
    i, j = graph.edges.T
    rates = ((positions[i] - positions[j]) * (velocities[i] - velocities[j])).sum(axis=1)
    matrix = rigidity_matrix(graph, positions)
    assert matrix.shape == (9, 12)
    assert np.allclose(matrix.toarray() @ velocities.ravel(), rates, rtol=1e-13)


def test_wrong_input_is_refused_in_words() -> None:
    for use in (rigidity_matrix, infinitesimally_rigid, infinitesimal_motions):
        with pytest.raises(ValueError, match="3 vertices, got shape"):
            use(cycle(3), [(0, 0), (1, 0)])
        with pytest.raises(ValueError, match="vertex 1 is not finite"):
            use(cycle(3), [(0, 0), (np.nan, 0), (0, 1)])
    with pytest.raises(ValueError, match="not 4"):
        vertex_connected(cycle(3), 4)  # type: ignore[arg-type]
