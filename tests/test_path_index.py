"""Many shortest paths at once, by A* and by labels, against one at a time without a graph."""

from __future__ import annotations

from typing import Literal

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import taut
from taut.errors import GoalBlocked, NoPath, StartBlocked, TautError
from taut.freespace import FreeSpace
from taut.route import (
    PathIndex,
    direct_lengths,
    direct_paths,
    distances,
    distances_from,
    paths,
    prepare,
    shortest_path,
    shortest_routes,
    with_obstacle,
)
from taut.scene import FloatArray, Polygon, Rectangle, Scene
from zoo import ZOO, Entry

HALL = Scene((0, 0, 10, 10))
KINDS: tuple[Literal["graph", "labels"], ...] = ("graph", "labels")


def places_in(freespace: FreeSpace, count: int, seed: int) -> FloatArray:
    """Free places, every third one a corner of free space."""
    rng = np.random.default_rng(seed)
    mesh = freespace.mesh
    if not len(mesh.triangles):
        return np.empty((0, 2))
    picked = rng.integers(0, len(mesh.triangles), count)
    shares = rng.dirichlet((1, 1, 1), count)
    shares[::3] = np.eye(3)[rng.integers(0, 3, len(shares[::3]))]
    points = np.einsum("ij,ijk->ik", shares, mesh.vertices[mesh.triangles[picked]])
    return np.asarray(points[freespace.contains(points)])


def check(index: PathIndex, a: FloatArray, b: FloatArray) -> None:
    expected, _ = direct_lengths(index.freespace, a, b)
    found = distances(index, a, b)
    assert (np.isinf(found) == np.isinf(expected)).all()
    there = np.isfinite(expected)
    np.testing.assert_allclose(found[there], expected[there], rtol=1e-12)
    many = paths(index, a[there], b[there])
    np.testing.assert_array_equal(many.lengths, found[there])
    for k, (start, goal) in enumerate(zip(a[there], b[there], strict=True)):
        points = many[k]
        assert (points[0] == start).all()
        assert (points[-1] == goal).all()
        assert np.hypot(*np.diff(points, axis=0).T).sum() == pytest.approx(expected[there][k], rel=1e-12, abs=1e-300)
        if len(points) > 1:
            legs = np.stack([points[:-1], points[1:]], axis=1)
            straight, _ = direct_lengths(index.freespace, legs[:, 0], legs[:, 1])
            np.testing.assert_allclose(straight, np.hypot(*np.diff(points, axis=0).T), rtol=1e-9)


@pytest.mark.parametrize("kind", KINDS)
@pytest.mark.parametrize("entry", ZOO, ids=lambda entry: entry.name)
def test_the_zoo_has_the_same_paths_as_without_an_index(entry: Entry, kind: Literal["graph", "labels"]) -> None:
    scene = entry.scene
    for growth in sorted({scene.growth(robot) for robot in scene.robots} | {0.0}):
        freespace = FreeSpace(scene, growth)
        places = places_in(freespace, 24, 1)
        k = len(places) // 2
        index = prepare(freespace, kind)
        check(index, places[:k], places[k : 2 * k])


@settings(max_examples=40, deadline=None)
@given(st.integers(0, 10_000), st.integers(1, 40), st.sampled_from([0.0, 0.2]))
def test_random_scenes_have_the_same_paths_as_without_an_index(seed: int, obstacles: int, growth: float) -> None:
    freespace = FreeSpace(taut.random_scene(robots=0, obstacles=obstacles, seed=seed), growth)
    places = places_in(freespace, 60, seed)
    k = len(places) // 2
    for kind in KINDS:
        check(prepare(freespace, kind), places[:k], places[k : 2 * k])


@pytest.fixture(scope="module")
def index() -> PathIndex:
    return prepare(FreeSpace(taut.random_scene(robots=0, obstacles=60, seed=4), 0.1))


def test_one_to_many_equals_one_by_one(index: PathIndex) -> None:
    places = places_in(index.freespace, 80, 7)
    expected = distances(index, np.repeat(places[:1], len(places), axis=0), places)
    np.testing.assert_allclose(distances_from(index, places[0], places), expected, rtol=1e-12)


def test_one_to_many_says_infinity_for_what_is_blocked_or_cut_off() -> None:
    scene = Scene((0, 0, 10, 10), [Rectangle(4, 0, 1, 10), Rectangle(1, 1, 1, 1)])
    found = distances_from(prepare(FreeSpace(scene)), (0.5, 0.5), [(3, 3), (8, 8), (1.5, 1.5), (0.5, 0.5)])
    assert np.isinf(found).tolist() == [False, True, True, False]
    assert found[3] == 0


def test_shortest_routes_are_the_same_paths(index: PathIndex) -> None:
    places = places_in(index.freespace, 60, 9)
    k = len(places) // 2
    routes = shortest_routes(index.freespace, index.tangents, places[:k], places[k : 2 * k])
    many = paths(index, places[:k], places[k : 2 * k])
    assert len(many) == k
    for route, one in zip(routes, direct_paths(index.freespace, places[:k], places[k : 2 * k]), strict=True):
        assert route.length == pytest.approx(one.length, rel=1e-12)
    for j, route in enumerate(routes):
        np.testing.assert_array_equal(many[j], route.points)


def test_no_pairs_give_no_paths(index: PathIndex) -> None:
    assert distances(index, [], []).tolist() == []
    assert len(paths(index, [], [])) == 0


def test_a_place_to_itself_is_a_path_of_one_point(index: PathIndex) -> None:
    place = places_in(index.freespace, 3, 2)[:1]
    many = paths(index, place, place)
    assert many.lengths.tolist() == [0.0]
    assert many[0].tolist() == place.tolist()
    with pytest.raises(IndexError, match="path 1 of 1"):
        many[1]


def test_blocked_and_separated_places_are_named() -> None:
    scene = Scene((0, 0, 10, 10), [Rectangle(4, 0, 1, 10)])
    for kind in KINDS:
        index = prepare(FreeSpace(scene), kind)
        with pytest.raises(StartBlocked, match=r"start \(4.5, 5\) is not in free space"):
            distances(index, [(1, 1), (4.5, 5)], [(2, 2), (2, 2)])
        with pytest.raises(GoalBlocked, match=r"goal \(11, 5\)"):
            distances(index, [(1, 1)], [(11, 5)])
        with pytest.raises(NoPath, match=r"no way from \(1, 1\) to \(9, 9\)"):
            paths(index, [(1, 1)], [(9, 9)])
        assert np.isinf(distances(index, [(1, 1)], [(9, 9)])).all()
        with pytest.raises(ValueError, match="every start needs its goal"):
            distances(index, [(1, 1)], [])
        with pytest.raises(StartBlocked):
            distances_from(index, (4.5, 5), [(1, 1)])


def test_labels_report_their_size_and_keep_a_bound() -> None:
    freespace = FreeSpace(taut.random_scene(robots=0, obstacles=30, seed=1))
    index = prepare(freespace, "labels")
    assert index.labels is not None
    assert index.labels.bytes > 0
    assert index.labels.build_seconds > 0
    with pytest.raises(TautError, match="bytes"):
        prepare(freespace, "labels", most_bytes=100)
    with pytest.raises(ValueError, match="graph"):
        prepare(freespace, "tables")  # type: ignore[arg-type]


def test_labels_notice_an_obstacle_that_closes_a_passage_beside_their_path() -> None:
    tips = [Polygon([(x, 0), (x + 1, 5 + 5e-13), (x + 2, 0)]) for x in (2.0, 6.0)]
    low = Polygon([(4.5, 1), (5, 5), (5.5, 1)])
    index = prepare(FreeSpace(Scene((0, 0, 10, 10), [*tips, low])), "labels")
    closed = with_obstacle(index, Polygon([(4.5, 10), (5, 5 + 1e-12), (5.5, 10)]))
    expected, _ = direct_lengths(closed.freespace, [(1.5, 2)], [(8.5, 2)])
    assert expected[0] > 16
    assert distances(index, [(1.5, 2)], [(8.5, 2)])[0] < 11
    assert distances(closed, [(1.5, 2)], [(8.5, 2)])[0] == pytest.approx(expected[0], rel=1e-12)


@pytest.mark.parametrize("kind", KINDS)
def test_an_empty_hall_takes_its_first_obstacle(kind: Literal["graph", "labels"]) -> None:
    index = with_obstacle(prepare(FreeSpace(Scene((0, 0, 10, 10))), kind), Rectangle(4, 4, 2, 2))
    assert distances(index, [(0, 5)], [(10, 5)])[0] == pytest.approx(2 * np.hypot(4, 1) + 2, rel=1e-15)


@pytest.mark.parametrize("kind", KINDS)
def test_lengths_are_measured_from_the_places_given(kind: Literal["graph", "labels"]) -> None:
    scene = Scene((0, 0, 10, 10), [Rectangle(4, 4, 2, 2)])
    space, inside = FreeSpace(scene), scene.tol * 0.9
    index = prepare(space, kind)
    for start, goal in (((4 + inside, 5), (9, 5)), ((4, 4 - inside), (4, -inside)), ((-inside, 1), (10 + inside, 9))):
        (length,) = distances(index, [start], [goal])
        points = paths(index, [start], [goal])[0]
        assert points[0].tolist() == list(start)
        assert points[-1].tolist() == list(goal)
        drawn = np.hypot(*np.diff(points, axis=0).T).sum()
        for found in (length, distances_from(index, start, [goal])[0], shortest_path(space, start, goal).length):
            assert abs(found - drawn) <= 4 * np.spacing(drawn)


@pytest.mark.parametrize("points", [np.zeros((2, 3)), 1.0, None, "ab", [(1, 2), (3,)], [(1j, 1)], [(10**400, 1)]])
def test_what_is_no_list_of_points_is_refused(points: object) -> None:
    index = prepare(FreeSpace(HALL))
    for ask in (
        lambda: distances(index, points, [(1, 1)]),  # type: ignore[arg-type]
        lambda: paths(index, [(1, 1)], points),  # type: ignore[arg-type]
        lambda: distances_from(index, (1, 1), points),  # type: ignore[arg-type]
        lambda: direct_lengths(index.freespace, points, points),  # type: ignore[arg-type]
        lambda: shortest_path(index.freespace, points, (1, 1)),  # type: ignore[arg-type]
    ):
        with pytest.raises(ValueError, match=r"must be points|must be one point"):
            ask()


@pytest.mark.parametrize("which", [slice(0, 1), 0.0, "0", None])
def test_paths_are_taken_by_their_number(which: int) -> None:
    found = paths(prepare(FreeSpace(HALL)), [(1, 1)], [(2, 2)])
    assert found[np.int64(0)].tolist() == found[-1].tolist() == [[1, 1], [2, 2]]  # type: ignore[index]
    with pytest.raises(TypeError, match="by their number"):
        found[which]


@pytest.mark.parametrize("most", [float("nan"), "1", -1])
def test_bounds_on_bytes_that_are_none_are_refused(most: int) -> None:
    with pytest.raises(ValueError, match="give a number of bytes"):
        prepare(FreeSpace(HALL), "labels", most_bytes=most)
