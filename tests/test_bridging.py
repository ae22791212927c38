"""λ2 after one change, from one decomposition, against decomposing each changed graph."""

from __future__ import annotations

import itertools
import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from taut.graph import (
    Graph,
    algebraic_connectivity,
    best_edges,
    components,
    connectivity_with,
    connectivity_without,
    contracted,
    cut_edges,
    in_one_piece,
    split,
    with_edge,
)
from taut.graph.core import Floats, Ints


def dense(graph: Graph) -> Floats:
    matrix = np.zeros((graph.n, graph.n))
    for (u, v), w in zip(graph.edges.tolist(), graph.lengths.tolist(), strict=True):
        matrix[u, u] += w
        matrix[v, v] += w
        matrix[u, v] -= w
        matrix[v, u] -= w
    return matrix


def naive_connectivity(graph: Graph) -> tuple[float, float]:
    """λ2 and λ_max by decomposing the dense matrix."""
    values = np.linalg.eigvalsh(dense(graph))
    return float(values[1]), float(values[-1])


def all_pairs(n: int) -> Ints:
    return np.array(list(itertools.combinations(range(n), 2)), dtype=np.int64).reshape(-1, 2)


def zoo() -> list[Graph]:
    """200 graphs: random ones of all densities and weights, regular, symmetric, complete, in two and more pieces."""
    out: list[Graph] = []
    rng = np.random.default_rng(5)
    for k in range(120):
        n = int(rng.integers(2, 26))
        pairs = all_pairs(n)
        chosen = pairs[rng.random(len(pairs)) < rng.random() ** 1.5]
        weights = np.ones(len(chosen)) if k % 3 == 0 else 10.0 ** rng.uniform(-3, 3, len(chosen))
        out.append(Graph.from_edges(n, chosen, weights))
    for n in range(2, 22):
        ring = [(i, (i + 1) % n) for i in range(n)] if n > 2 else [(0, 1)]
        out.append(Graph.from_edges(n, all_pairs(n)))
        out.append(Graph.from_edges(n, ring))
        out.append(Graph.from_edges(n, [(0, i) for i in range(1, n)]))
        two = [*itertools.combinations(range(n), 2), *((n + a, n + b) for a, b in itertools.combinations(range(n), 2))]
        out.append(Graph.from_edges(2 * n, two))
    return out


GRAPHS = zoo()


def test_there_are_two_hundred_graphs_of_every_kind() -> None:
    pieces = [int(components(graph).max()) + 1 for graph in GRAPHS]
    assert len(GRAPHS) == 200
    assert min(pieces.count(1), pieces.count(2)) >= 20
    assert sum(count > 2 for count in pieces) >= 10


@pytest.mark.parametrize("start", range(0, 200, 20))
def test_every_candidate_gives_what_decomposing_anew_gives(start: int) -> None:
    rng = np.random.default_rng(start)
    for graph in GRAPHS[start : start + 20]:
        candidates = all_pairs(graph.n)
        candidates = candidates[rng.permutation(len(candidates))[:120]]
        weights = np.ones(len(candidates)) if start % 40 else 10.0 ** rng.uniform(-3, 3, len(candidates))
        found = connectivity_with(graph, candidates, weights)
        for pair, weight, value in zip(candidates.tolist(), weights.tolist(), found.tolist(), strict=True):
            changed = with_edge(graph, (pair[0], pair[1]), weight)
            expected, largest = naive_connectivity(changed)
            assert abs(value - expected) <= 1e-12 * largest
            assert (value == 0) == bool(components(changed).max() > 0)


@pytest.mark.parametrize("start", range(0, 200, 40))
def test_every_removal_gives_what_decomposing_anew_gives(start: int) -> None:
    for graph in GRAPHS[start : start + 40]:
        edges, weights = graph.edges, graph.lengths
        for k, value in enumerate(connectivity_without(graph).tolist()):
            rest = Graph.from_edges(graph.n, np.delete(edges, k, axis=0), np.delete(weights, k))
            expected, _ = naive_connectivity(rest)
            assert abs(value - expected) <= 1e-12 * naive_connectivity(graph)[1]
            assert (value == 0) == bool(components(rest).max() > 0)


def test_the_path_with_a_leaf_gains_up_to_the_repeated_eigenvalue() -> None:
    path = Graph.from_edges(5, [(3, 1), (1, 0), (0, 2), (1, 4)])
    assert connectivity_with(path, [(1, 2)], [3.0])[0] == pytest.approx(1.0, abs=1e-14)


def test_removing_an_edge_that_holds_the_graph_together_gives_exactly_zero() -> None:
    graph = Graph.from_edges(7, [(0, 1), (1, 2), (0, 2), (2, 3), (3, 4), (4, 5), (3, 5), (5, 6)])
    zero = {
        tuple(edge) for edge, value in zip(graph.edges.tolist(), connectivity_without(graph), strict=True) if value == 0
    }
    assert zero == {tuple(edge) for edge in cut_edges(graph).tolist()} == {(2, 3), (5, 6)}


def test_an_edge_given_as_candidate_again_becomes_stronger() -> None:
    triangle = Graph.from_edges(3, [(0, 1), (1, 2), (0, 2)])
    assert connectivity_with(triangle, [(1, 0)], [2.0])[0] == pytest.approx(3.0, abs=1e-13)
    assert with_edge(triangle, (1, 0), 2.0).lengths.tolist() == [3.0, 1.0, 1.0]


def test_greedy_choice_is_the_best_of_each_step() -> None:
    rng = np.random.default_rng(9)
    for graph in [GRAPHS[k] for k in rng.permutation(200)[:25]]:
        if graph.n < 4:
            continue
        candidates = all_pairs(graph.n)
        additions = best_edges(graph, candidates, count=3)
        assert len(additions) == 3
        for addition in additions:
            values = [naive_connectivity(with_edge(graph, (u, v), 1.0)) for u, v in candidates.tolist()]
            slack = 2e-12 * max(largest for _, largest in values)
            assert addition.after >= max(value for value, _ in values) - slack
            assert addition.before == algebraic_connectivity(graph)
            graph = with_edge(graph, addition.edge, addition.weight)
            candidates = candidates[(candidates != addition.edge).any(axis=1)]


def test_equal_candidates_are_decided_by_the_smaller_vertices() -> None:
    ring = Graph.from_edges(6, [(i, (i + 1) % 6) for i in range(6)])
    opposite = [(2, 5), (1, 4), (3, 0)]
    chosen = best_edges(ring, opposite)[0]
    assert (chosen.edge, chosen.candidate, chosen.runner_up) == ((0, 3), 2, 1)
    assert chosen.after == pytest.approx(float(chosen.runner_up_after or 0), abs=1e-12)


def test_edges_that_join_components_come_first_where_no_single_edge_helps() -> None:
    islands = Graph.from_edges(7, [(0, 1), (1, 2), (3, 4), (5, 6)])
    additions = best_edges(islands, [(0, 2), (2, 3), (4, 5), (0, 6)], count=3)
    assert [a.after > 0 for a in additions] == [False, True, True]
    assert additions[0].edge == (0, 6)


def test_fewer_additions_come_back_when_candidates_run_out() -> None:
    path = Graph.from_edges(3, [(0, 1), (1, 2)])
    only = best_edges(path, [(0, 2)], count=5)
    assert len(only) == 1
    assert only[0].runner_up is None
    assert best_edges(path, [], count=2) == ()


@pytest.mark.parametrize(
    ("candidates", "weights", "said"),
    [
        ([(0, 3)], None, "outside 0 … 2"),
        ([(1, 1)], None, "with itself"),
        ([(0, 2)], [0.0], "positive"),
        ([(0, 2)], [np.nan], "positive"),
        ([(0, 2)], [1.0, 2.0], "1 candidates but 2 weights"),
        ([(0.5, 2)], None, "whole numbers"),
        ([(0, 1, 2, 0)], None, "pairs"),
    ],
)
def test_bad_candidates_are_refused(
    candidates: list[tuple[float, ...]], weights: list[float] | None, said: str
) -> None:
    with pytest.raises(ValueError, match=said):
        connectivity_with(Graph.from_edges(3, [(0, 1)]), candidates, weights)


@pytest.mark.parametrize("unit", [1e-300, 1e-200, 1e-160, 1.0, 1e155, 1e200, 1e300])
def test_units_of_weight_do_not_matter(unit: float) -> None:
    path = Graph.from_edges(4, [(0, 1), (1, 2), (2, 3)], [unit] * 3)
    assert connectivity_with(path, [(0, 3)], [unit])[0] / unit == pytest.approx(2.0, rel=1e-12)
    assert best_edges(path, [(0, 2), (0, 3), (1, 3)], [unit] * 3)[0].edge == (0, 3)
    apart = Graph.from_edges(4, [(0, 1), (2, 3)], [unit] * 2)
    joined = connectivity_with(apart, [(0, 3)], [unit])[0]
    assert joined / unit == pytest.approx(2 - math.sqrt(2), rel=1e-12)
    ring = Graph.from_edges(3, [(0, 1), (1, 2), (0, 2)], [unit] * 3)
    np.testing.assert_allclose(connectivity_without(ring) / unit, 1.0, rtol=1e-12)


@settings(max_examples=60, deadline=None)
@given(st.integers(2, 30), st.integers(0, 10_000))
def test_adding_an_edge_never_lowers_and_removing_never_raises(n: int, seed: int) -> None:
    rng = np.random.default_rng(seed)
    pairs = all_pairs(n)
    chosen = pairs[rng.random(len(pairs)) < rng.random()]
    graph = Graph.from_edges(n, chosen, 10.0 ** rng.uniform(-6, 6, len(chosen)))
    now = algebraic_connectivity(graph)
    slack = 1e-12 * max(1.0, float(graph.lengths.sum()))
    assert (connectivity_with(graph, pairs) >= now - slack).all()
    assert (connectivity_without(graph) <= now + slack).all()


def test_contraction_sums_parallel_edges_and_drops_inner_ones() -> None:
    graph = Graph.from_edges(6, all_pairs(6), np.arange(1.0, 16.0))
    small = contracted(graph, [0, 0, 1, 1, 2, 2])
    assert small.n == 3
    inner = sum(w for (u, v), w in zip(graph.edges.tolist(), graph.lengths.tolist(), strict=True) if u // 2 == v // 2)
    assert small.lengths.sum() == pytest.approx(graph.lengths.sum() - inner)
    with pytest.raises(ValueError, match="each of the 6 vertices"):
        contracted(graph, [0, 1])


@settings(max_examples=60, deadline=None)
@given(st.integers(2, 40), st.integers(0, 10_000))
def test_both_sides_of_a_split_are_connected(n: int, seed: int) -> None:
    rng = np.random.default_rng(seed)
    tree = [(int(rng.integers(0, i)), i) for i in range(1, n)]
    more = {tuple(sorted(p)) for p in rng.integers(0, n, (n // 2, 2)).tolist() if p[0] != p[1]} - set(tree)
    graph = Graph.from_edges(n, np.array([*tree, *more]))
    for side in (split(graph, [rng.random(n), rng.random(n)]), in_one_piece(graph, rng.random(n) < 0.5)):
        for value in (True, False):
            members = np.flatnonzero(side == value)
            number = np.full(n, -1)
            number[members] = np.arange(len(members))
            inner = graph.edges[(number[graph.edges] >= 0).all(axis=1)]
            parts = components(Graph.from_edges(len(members), number[inner]))
            assert len(parts) == 0 or parts.max() == 0


def test_a_split_follows_the_coordinates_where_symmetry_leaves_it_open() -> None:
    square = Graph.from_edges(4, [(0, 1), (1, 2), (2, 3), (3, 0)])
    x, y = np.array([0.0, 1.0, 1.0, 0.0]), np.array([0.0, 0.0, 1.0, 1.0])
    assert split(square, [x, y]).tolist() == [False, True, True, False]
    assert split(square, [y, x]).tolist() == [False, False, True, True]


def test_a_graph_in_pieces_is_gathered_and_not_cut() -> None:
    graph = Graph.from_edges(7, [(0, 1), (1, 2), (3, 4), (5, 6)])
    side = split(graph)
    assert side.tolist() == [True, True, True, False, False, False, False]
