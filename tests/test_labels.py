"""Hub labels give the distances and paths that searches give, from labels as small as their order allows."""

from __future__ import annotations

import math
import os
from itertools import pairwise

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from strategies import scenes
from taut.errors import TautError
from taut.freespace import FreeSpace
from taut.generate import random_scene
from taut.graph import Graph, astar_between
from taut.graph.core import Floats
from taut.graph.labels import (
    HubLabels,
    hub_labels,
    hub_order,
    label_distances,
    label_distances_between,
    label_path,
    label_paths,
)
from taut.roadmap import visibility_graph
from taut.route import attach
from taut.scene import Scene
from test_graph import all_distances, graphs, length_of

ARRAYS = ("order", "start", "hubs", "distances", "following")


def every_pair(labels: HubLabels) -> Floats:
    """Ask for all pairs in one batch, (n, n)."""
    a, b = np.divmod(np.arange(labels.n**2), max(labels.n, 1))
    return label_distances(labels, a, b).reshape(labels.n, labels.n)


def assert_same(found: Floats, expected: Floats) -> None:
    np.testing.assert_allclose(found, expected, rtol=1e-12, atol=0)


def assert_shortest(graph: Graph, labels: HubLabels, a: int, b: int, expected: float) -> None:
    path = label_path(labels, a, b)
    if math.isinf(expected):
        assert path == []
        return
    assert (path[0], path[-1]) == (a, b)
    assert len(set(path)) == len(path)
    edges = set(map(tuple, graph.edges.tolist()))
    assert all((min(i, j), max(i, j)) in edges for i, j in pairwise(path))
    assert length_of(graph, path) == pytest.approx(expected, rel=1e-12, abs=0)


def path_graph(n: int, weight: float = 1.0) -> Graph:
    return Graph.from_edges(n, [(i, i + 1) for i in range(n - 1)], [weight] * (n - 1))


def star_graph(n: int) -> Graph:
    return Graph.from_edges(n, [(n - 1, i) for i in range(n - 1)])


def complete_graph(n: int) -> Graph:
    return Graph.from_edges(n, [(i, j) for i in range(n) for j in range(i)])


def grid_graph(side: int, weights: float | Floats = 1.0) -> Graph:
    at = np.arange(side * side).reshape(side, side)
    edges = np.concatenate(
        [
            np.stack([at[:, :-1].ravel(), at[:, 1:].ravel()], axis=1),
            np.stack([at[:-1].ravel(), at[1:].ravel()], axis=1),
        ]
    )
    return Graph.from_edges(side * side, edges, np.broadcast_to(weights, len(edges)))


@st.composite
def ordered_graphs(draw: st.DrawFn) -> tuple[Graph, list[int]]:
    """Draw a graph and any order of its vertices."""
    graph = draw(graphs())
    return graph, draw(st.permutations(range(graph.n)))


@settings(deadline=None, max_examples=200)
@given(ordered_graphs())
def test_distances_are_those_of_floyd_and_warshall_whatever_the_order(drawn: tuple[Graph, list[int]]) -> None:
    graph, order = drawn
    expected = all_distances(graph)
    assert_same(every_pair(hub_labels(graph)), expected)
    assert_same(every_pair(hub_labels(graph, order)), expected)


@settings(deadline=None, max_examples=150)
@given(ordered_graphs())
def test_paths_are_simple_and_as_long_as_their_labels_say(drawn: tuple[Graph, list[int]]) -> None:
    graph, order = drawn
    labels, expected = hub_labels(graph, order), all_distances(graph)
    for a in range(graph.n):
        for b in range(graph.n):
            assert_shortest(graph, labels, a, b, expected[a, b])


@settings(deadline=None, max_examples=150)
@given(ordered_graphs())
def test_a_vertex_is_a_hub_exactly_where_no_higher_vertex_is_on_a_shortest_path(
    drawn: tuple[Graph, list[int]],
) -> None:
    graph, order = drawn
    graph = Graph.from_edges(graph.n, graph.edges, np.floor(graph.lengths) % 4 + 1)  # whole numbers: sums are exact
    labels, far = hub_labels(graph, order), all_distances(graph)
    for v in range(graph.n):
        rows = slice(labels.start[v], labels.start[v + 1])
        expected = [
            rank
            for rank, hub in enumerate(order)
            if np.isfinite(far[v, hub]) and not any(far[v, u] + far[u, hub] == far[v, hub] for u in order[:rank])
        ]
        assert labels.hubs[rows].tolist() == expected
        assert labels.distances[rows].tolist() == [far[v, order[rank]] for rank in expected]


@settings(deadline=None, max_examples=60)
@given(st.integers(2, 9), st.data())
def test_paths_over_edges_of_no_length_do_not_turn_back(n: int, data: st.DataObject) -> None:
    pairs = [(i, j) for i in range(n) for j in range(i)]
    chosen = data.draw(st.lists(st.sampled_from(pairs), unique=True))
    weights = data.draw(st.lists(st.sampled_from([0.0, 0.0, 1e-30, 1.0]), min_size=len(chosen), max_size=len(chosen)))
    graph = Graph.from_edges(n, chosen, weights)
    labels = hub_labels(graph, data.draw(st.permutations(range(n))))
    for a, b in pairs:
        path = label_path(labels, a, b)
        assert len(set(path)) == len(path)
        assert bool(path) == math.isfinite(all_distances(graph)[a, b])


def test_paths_stars_grids_and_complete_graphs_have_their_closed_forms() -> None:
    i, j = np.indices((300, 300))
    np.testing.assert_array_equal(every_pair(hub_labels(path_graph(300))), abs(i - j))
    np.testing.assert_array_equal(every_pair(hub_labels(complete_graph(40))), 1.0 - np.eye(40))
    star = 2.0 * (1 - np.eye(90))
    star[-1, :-1] = star[:-1, -1] = 1.0
    labels = hub_labels(star_graph(90))
    np.testing.assert_array_equal(every_pair(labels), star)
    assert labels.mean_size == (2 * 90 - 1) / 90
    x, y = np.divmod(np.arange(400), 20)
    expected = abs(x[:, None] - x) + abs(y[:, None] - y)
    np.testing.assert_array_equal(every_pair(hub_labels(grid_graph(20))), expected)


def test_entries_hold_what_their_names_say_in_graphs_of_many_chunks() -> None:
    graph = grid_graph(16, np.random.default_rng(3).uniform(1, 2, 480))
    labels, far = hub_labels(graph), all_distances(graph)
    weight = {(i, j): w for (i, j), w in zip(graph.edges.tolist(), graph.lengths.tolist(), strict=True)}
    vertex = np.repeat(np.arange(256), np.diff(labels.start))
    hub = labels.order[labels.hubs]
    assert (np.diff(labels.hubs)[np.diff(vertex) == 0] > 0).all()
    assert_same(labels.distances, far[vertex, hub])
    np.testing.assert_array_equal(labels.following == -1, vertex == hub)
    for v, u, h in zip(vertex.tolist(), labels.following.tolist(), hub.tolist(), strict=True):
        if u >= 0:
            assert weight[min(u, v), max(u, v)] + far[u, h] == pytest.approx(far[v, h], rel=1e-12)


def test_labels_of_a_path_are_logarithmic() -> None:
    assert hub_labels(path_graph(1023)).mean_size < math.log2(1024)


def test_rounded_ties_cost_no_exactness() -> None:
    labels = hub_labels(grid_graph(12, 0.1))
    x, y = np.divmod(np.arange(144), 12)
    assert_same(every_pair(labels), 0.1 * (abs(x[:, None] - x) + abs(y[:, None] - y)))


@pytest.mark.parametrize("scale", [1e-300, 1e-9, 1e9, 1e300])
def test_weights_may_be_tiny_and_huge(scale: float) -> None:
    graph = path_graph(6, scale)
    assert_same(every_pair(hub_labels(graph)), all_distances(graph))


def test_weights_that_vanish_beside_others_still_connect() -> None:
    graph = Graph.from_edges(4, [(0, 1), (1, 2), (2, 3)], [1.0, 1e-300, 1e200])
    for order in ([0, 1, 2, 3], [3, 2, 1, 0], [1, 3, 0, 2]):
        labels = hub_labels(graph, order)
        assert_same(every_pair(labels), all_distances(graph))
        assert label_path(labels, 0, 3) == [0, 1, 2, 3]


def test_empty_single_and_unjoined_graphs() -> None:
    empty = hub_labels(Graph.from_edges(0, []))
    assert (empty.n, empty.mean_size, len(label_distances(empty, [], []))) == (0, 0.0, 0)
    single = hub_labels(Graph.from_edges(1, []))
    assert label_distances(single, [0], [0]).tolist() == [0.0]
    assert label_path(single, 0, 0) == [0]
    apart = hub_labels(Graph.from_edges(3, []))
    np.testing.assert_array_equal(every_pair(apart), np.where(np.eye(3) == 1, 0.0, np.inf))
    assert label_path(apart, 0, 2) == []


def test_a_batch_of_paths_is_the_paths_one_by_one() -> None:
    graph = Graph.from_edges(8, [(0, 1), (1, 2), (2, 3), (0, 3), (4, 5), (5, 6)])
    labels = hub_labels(graph)
    a, b = np.divmod(np.arange(64), 8)
    start, vertices = label_paths(labels, a, b)
    assert [vertices[i:j].tolist() for i, j in pairwise(start.tolist())] == [
        label_path(labels, i, j) for i, j in zip(a.tolist(), b.tolist(), strict=True)
    ]
    assert label_paths(labels, [], [])[0].tolist() == [0]


def test_pairs_in_a_batch_do_not_touch_each_other() -> None:
    labels = hub_labels(grid_graph(9))
    a, b = np.random.default_rng(4).integers(0, 81, (2, 300))
    a[100:140] = 7
    alone = [label_distances(labels, [i], [j])[0] for i, j in zip(a, b, strict=True)]
    assert label_distances(labels, a, b).tolist() == alone


@settings(deadline=None, max_examples=25)
@given(scenes(), st.integers(0, 2**32 - 1))
def test_tangent_graphs_of_drawn_scenes_have_the_same_distances(scene: Scene, seed: int) -> None:
    graph = visibility_graph(FreeSpace(scene)).graph
    order = np.random.default_rng(seed).permutation(graph.n)
    expected = all_distances(graph)
    assert_same(every_pair(hub_labels(graph)), expected)
    assert_same(every_pair(hub_labels(graph, order)), expected)


@pytest.mark.parametrize("seed", [1, 2, 3])
def test_places_in_random_scenes_are_as_far_apart_as_a_star_says(seed: int) -> None:
    freespace = FreeSpace(random_scene(robots=1, obstacles=25, seed=seed))
    tangents = visibility_graph(freespace)
    labels = hub_labels(tangents.graph)
    low, high = tangents.positions.min(axis=0), tangents.positions.max(axis=0)
    ends = attach(freespace, tangents, np.random.default_rng(seed).uniform(low, high, (60, 2)))
    owner = np.repeat(np.arange(60), np.diff(ends.first))
    offsets = np.hypot(*(ends.points[owner] - tangents.positions[ends.corners]).T)
    rows = ends.first, ends.corners, offsets
    a, b = np.divmod(np.arange(3600), 60)
    found, passed = label_distances_between(labels, tangents.positions, ends.points, *rows, a, b)
    blind = label_distances_between(labels, 0 * tangents.positions, 0 * ends.points, *rows, a, b)[0]
    expected = [
        astar_between(
            tangents.graph, tangents.positions, ends.points[i], ends.corners_of(i), ends.points[j], ends.corners_of(j)
        )[0]
        for i, j in zip(a.tolist(), b.tolist(), strict=True)
    ]
    assert np.isfinite(expected).sum() > 500
    assert_same(found, np.array(expected))
    assert_same(blind, np.array(expected))
    reached = np.isfinite(found)
    assert (passed[~reached] == -1).all()
    way = label_distances(labels, *passed[reached].T)
    joins = [
        np.hypot(*(ends.points[side[reached]] - tangents.positions[passed[reached, k]]).T)
        for k, side in enumerate((a, b))
    ]
    assert_same(joins[0] + way + joins[1], found[reached])


@settings(deadline=None, max_examples=120)
@given(graphs(), st.data())
def test_places_joined_with_any_vertices_are_as_far_apart_as_trying_all_pairs_says(
    graph: Graph, data: st.DataObject
) -> None:
    count = data.draw(st.integers(1, 4))
    sets = [data.draw(st.lists(st.integers(0, graph.n - 1), unique=True, max_size=5)) for _ in range(count)]
    corners = [v for row in sets for v in row]
    offsets = data.draw(
        st.lists(st.integers(0, 3).map(float) | st.floats(0, 9), min_size=len(corners), max_size=len(corners))
    )
    first = np.cumsum([0, *map(len, sets)])
    a, b = np.divmod(np.arange(count * count), count)
    labels, far = hub_labels(graph), all_distances(graph)
    zeros = np.zeros((graph.n, 2)), np.zeros((count, 2))
    found, passed = label_distances_between(labels, *zeros, first, corners, offsets, a, b)
    for i, j, length, (enter, leave) in zip(a, b, found, passed.tolist(), strict=True):
        ends = [range(first[k], first[k + 1]) for k in (i, j)]
        ways = {
            (corners[p], corners[q]): offsets[p] + far[corners[p], corners[q]] + offsets[q]
            for p in ends[0]
            for q in ends[1]
        }
        least = min(ways.values(), default=math.inf)
        assert length == pytest.approx(least, rel=1e-12, abs=0)
        if math.isfinite(least):
            assert ways[enter, leave] == pytest.approx(least, rel=1e-12, abs=0)
        else:
            assert (enter, leave) == (-1, -1)


def test_places_in_a_row_are_measured_along_it() -> None:
    """Straight estimates equal the lengths here, so that a bound that cuts too much would show."""
    at = np.stack([np.arange(30) * 0.1, np.zeros(30)], axis=1)
    labels = hub_labels(Graph.from_edges(30, [(i, i + 1) for i in range(29)], np.diff(at[:, 0])))
    points = [(-0.3, 0), (3.7, 0), (1.23, 0)]
    corners = [*range(30)] * 3
    offsets = np.concatenate([abs(at[:, 0] - x) for x, _ in points])
    found, _ = label_distances_between(labels, at, points, [0, 30, 60, 90], corners, offsets, [0, 0, 1], [1, 2, 2])
    assert_same(found, np.array([4.0, 1.53, 2.47]))


def test_a_place_that_is_joined_with_nothing_is_reached_from_nowhere() -> None:
    labels = hub_labels(path_graph(2))
    found, passed = label_distances_between(labels, np.zeros((2, 2)), np.zeros((2, 2)), [0, 0, 1], [1], [0.5], [0], [1])
    assert (found.tolist(), passed.tolist()) == ([math.inf], [[-1, -1]])
    nothing = label_distances_between(labels, np.zeros((2, 2)), [], [0], [], [], [], [])
    assert (nothing[0].shape, nothing[1].shape) == ((0,), (0, 2))


def test_coordinates_far_out_do_not_overflow() -> None:
    at = np.array([[0.0, 0.0], [1e200, 0.0]])
    labels = hub_labels(path_graph(2, 1e200))
    found, _ = label_distances_between(labels, at, at, [0, 1, 2], [0, 1], [0.0, 0.0], [0], [1])
    assert found.tolist() == [1e200]


def test_the_memory_bound_is_kept_to_the_byte() -> None:
    graph = grid_graph(16)
    labels = hub_labels(graph)
    assert labels.bytes == sum(getattr(labels, name).nbytes for name in ARRAYS)
    assert hub_labels(graph, most_bytes=labels.bytes).bytes == labels.bytes
    with pytest.raises(TautError, match=rf"{labels.bytes - 1:,} bytes allowed: {labels.bytes:,} bytes with 256 of 256"):
        hub_labels(graph, most_bytes=labels.bytes - 1)


@pytest.mark.parametrize("spare", [0, 5_000])
def test_the_memory_error_says_how_far_it_came(spare: int) -> None:
    graph = grid_graph(16)
    labels = hub_labels(graph)
    bound = 16 * 256 + 8 + spare
    needed = 16 * 256 + 8 + 16 * np.cumsum(np.bincount(labels.hubs, minlength=256))
    done = int(np.argmax(needed > bound)) + 1
    with pytest.raises(TautError, match=rf"{needed[done - 1]:,} bytes with {done} of 256 vertices"):
        hub_labels(graph, most_bytes=bound)
    with pytest.raises(TautError, match="with 0 of 256"):
        hub_labels(graph, most_bytes=0)


def test_labels_do_not_depend_on_the_run_or_the_number_of_threads(monkeypatch: pytest.MonkeyPatch) -> None:
    graph = visibility_graph(FreeSpace(random_scene(robots=1, obstacles=40, seed=5))).graph
    assert graph.n > 100
    first = hub_labels(graph)
    for threads in (1, 5):
        monkeypatch.setattr(os, "cpu_count", lambda threads=threads: threads)
        again = hub_labels(graph)
        for name in ARRAYS:
            np.testing.assert_array_equal(getattr(again, name), getattr(first, name))


def test_orders_hold_every_vertex_once_and_begin_where_paths_meet() -> None:
    assert hub_order(star_graph(50))[0] == 49
    assert hub_order(path_graph(301))[0] == 150
    many = Graph.from_edges(200_000, np.arange(200_000).reshape(-1, 2))
    np.testing.assert_array_equal(np.sort(hub_order(many)), np.arange(200_000))


def test_a_good_order_makes_smaller_labels_than_a_random_one() -> None:
    rng = np.random.default_rng(0)
    graph, random = grid_graph(20, rng.uniform(1, 2, 760)), rng.permutation(400)
    assert hub_labels(graph).mean_size < 0.7 * hub_labels(graph, random).mean_size


@pytest.mark.parametrize("order", [[0, 1], [0, 1, 1], [0, 1, 3], [-1, 0, 1], [0.0, 1.0, 2.0]])
def test_orders_that_are_none_are_refused(order: list[float]) -> None:
    with pytest.raises(ValueError, match="order must"):
        hub_labels(path_graph(3), order)


def test_a_negative_bound_is_refused() -> None:
    with pytest.raises(ValueError, match="most_bytes is -1"):
        hub_labels(path_graph(3), most_bytes=-1)


def test_vertices_that_are_none_are_refused() -> None:
    labels = hub_labels(path_graph(3))
    for wrong in (-1, 3):
        with pytest.raises(IndexError, match=f"vertex {wrong} is not one of the 3"):
            label_distances(labels, [0, wrong], [0, 0])
        with pytest.raises(IndexError, match=f"vertex {wrong} "):
            label_path(labels, 0, wrong)
    with pytest.raises(IndexError, match="vertex 0 "):
        label_path(hub_labels(Graph.from_edges(0, [])), 0, 0)
    with pytest.raises(ValueError, match="whole numbers"):
        label_distances(labels, [0.5], [1])
    with pytest.raises(ValueError, match="in pairs"):
        label_distances(labels, [0, 1], [1])


@pytest.mark.parametrize(
    ("change", "error", "said"),
    [
        ({"positions": [(0, 0)]}, ValueError, "2 vertices but 1 positions"),
        ({"points": [(0, math.nan)] * 2}, ValueError, "points must be finite"),
        ({"first": [0, 2]}, ValueError, "first must rise"),
        ({"first": [0, 3, 2]}, ValueError, "first must rise"),
        ({"first": [1, 1, 2]}, ValueError, "first must rise"),
        ({"corners": [0, 2]}, IndexError, "vertex 2 "),
        ({"offsets": [1.0]}, ValueError, "offsets are"),
        ({"offsets": [1.0, -1.0]}, ValueError, "offsets are"),
        ({"offsets": [1.0, math.inf]}, ValueError, "offsets are"),
        ({"a": [2]}, IndexError, "place 2 "),
    ],
)
def test_places_that_make_no_sense_are_refused(change: dict[str, object], error: type[Exception], said: str) -> None:
    good: dict[str, object] = {
        "positions": [(0, 0), (1, 0)],
        "points": [(0, 0), (1, 0)],
        "first": [0, 1, 2],
        "corners": [0, 1],
        "offsets": [0.0, 0.0],
        "a": [0],
        "b": [1],
    }
    labels = hub_labels(path_graph(2))
    assert label_distances_between(labels, **good)[0].tolist() == [1.0]  # type: ignore[arg-type]
    with pytest.raises(error, match=said):
        label_distances_between(labels, **{**good, **change})  # type: ignore[arg-type]
