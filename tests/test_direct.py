"""Direct routes are as short as those on the tangent graph and as the exact reference, and allowed."""

from __future__ import annotations

import math
from itertools import pairwise

import numpy as np
import pytest
import shapely
from hypothesis import given, settings
from hypothesis import strategies as st

from naive import ExactRegion, Spot, naive_shortest
from strategies import scenes
from taut.errors import GoalBlocked, NoPath, StartBlocked
from taut.freespace import FreeSpace
from taut.generate import random_scene
from taut.geometry.triangulation import triangulate
from taut.roadmap import VisibilityGraph, visibility_graph
from taut.route import shortest_routes
from taut.route.direct import DirectRoute, direct_lengths, direct_paths, shortest_path
from taut.scene import FloatArray, Point, Polygon, Scene
from zoo import ZOO, Entry, transformed

COARSE = 0.2  # arcs with few corners, so that the exact reference stays quick
MOST_VERTICES = 160
MANY = 12  # places a scene


def growths(scene: Scene) -> list[float]:
    return sorted({scene.growth(robot) for robot in scene.robots} | {scene.clearance})


def robots_places(space: FreeSpace) -> list[Point]:
    return [p for r in space.scene.robots if space.scene.growth(r) == space.growth for p in (r.start, r.goal)]


def awkward_places(space: FreeSpace, seed: int = 0) -> FloatArray:
    """Starts and goals, corners, places on edges inside and on the boundary, and in triangles: at most `MANY`."""
    mesh = space.mesh
    rng = np.random.default_rng(seed)
    corners = mesh.vertices[mesh.triangles]
    places = np.concatenate([mesh.vertices, ((corners + np.roll(corners, 1, axis=1)) / 2).reshape(-1, 2)])
    places = np.concatenate([places, np.einsum("tkx,k->tx", corners, [0.5, 0.25, 0.25])])
    places = rng.permutation(np.unique(places, axis=0))
    pinches = places[mesh.on_pinch(places)][:4]
    own = np.array(robots_places(space), dtype=np.float64).reshape(-1, 2)
    places = np.concatenate([own, pinches, places])[:MANY]
    return places[space.anchor(places)[1] >= 0]


def length_on_graph(space: FreeSpace, tangents: VisibilityGraph, a: FloatArray, b: FloatArray) -> float:
    try:
        return shortest_routes(space, tangents, a, b)[0].length
    except NoPath:
        return math.inf


def check_lengths(space: FreeSpace, places: FloatArray) -> None:
    """Each place to the next and to itself: the same lengths as on the tangent graph, and as many ways."""
    if not len(places):
        return
    tangents = visibility_graph(space)
    following = np.roll(places, -1, axis=0)
    starts, goals = np.concatenate([places, following, places[:1]]), np.concatenate([following, places, places[:1]])
    lengths, expanded = direct_lengths(space, starts, goals)
    expected = [length_on_graph(space, tangents, a, b) for a, b in zip(starts, goals, strict=True)]
    np.testing.assert_allclose(lengths, expected, rtol=1e-12)
    assert (expanded >= 0).all()
    joined = np.isfinite(lengths)
    for a, b in zip(starts[~joined], goals[~joined], strict=True):
        with pytest.raises(NoPath):
            shortest_path(space, a, b)
    routes = direct_paths(space, starts[joined], goals[joined])
    for a, b, length, route in zip(starts[joined], goals[joined], lengths[joined], routes, strict=True):
        assert (route.points[[0, -1]] == [a, b]).all()
        assert math.isclose(route.length, length, rel_tol=1e-14)


def check_allowed(exact: ExactRegion, route: DirectRoute) -> None:
    """Every leg is free, and at every bend some wedge holds both the leg that comes and the one that goes."""
    if len(route.points) == 1:
        return
    points = [tuple(p) for p in route.points.tolist()]
    wedges: dict[Point, list[Spot]] = {}
    for spot in exact.spots():
        wedges.setdefault(spot.vertex[:2], []).append(spot)
    for before, bend, after in zip(points, points[1:], points[2:], strict=False):
        assert bend in wedges
        assert bend not in (before, after)
    reached = [exact.free(points[0])]
    for point in points[1:-1]:
        reached = [spot for spot in wedges[point] if any(exact.passed(r, spot) is not None for r in reached)]
        assert reached, f"no wedge at {point} is reached"
    assert any(exact.passed(r, exact.free(points[-1])) is not None for r in reached)


def check_exactly(space: FreeSpace, places: FloatArray) -> None:
    """Each place to the next: the length of the exact reference, by an allowed path."""
    if len(shapely.get_coordinates(space.region)) > MOST_VERTICES:
        return
    # the reference knows no tolerance, so passages narrower than it are left open here
    object.__setattr__(space, "mesh", triangulate(space.region))
    places, triangles = space.anchor(places)
    places = places[triangles >= 0]
    exact = ExactRegion(space.region, [(x, y) for x, y in places.tolist()])
    for a, b in pairwise(places):
        expected = naive_shortest(space.region, a.tolist(), b.tolist())
        if expected is None:
            with pytest.raises(NoPath):
                shortest_path(space, a, b)
        else:
            route = shortest_path(space, a, b)
            assert math.isclose(route.length, expected, rel_tol=1e-12)
            check_allowed(exact, route)


@pytest.mark.parametrize("entry", ZOO, ids=str)
def test_zoo_lengths_equal_those_on_the_tangent_graph(entry: Entry) -> None:
    for growth in growths(entry.scene):
        space = FreeSpace(entry.scene, growth)
        check_lengths(space, awkward_places(space))


@pytest.mark.parametrize("entry", ZOO, ids=str)
def test_zoo_routes_are_allowed_and_exactly_shortest(entry: Entry) -> None:
    for growth in growths(entry.scene):
        space = FreeSpace(entry.scene, growth, arc_error=COARSE)
        check_exactly(space, awkward_places(space)[:6])


@settings(max_examples=400, deadline=None)
@given(scenes(), st.integers(0, 9))
def test_generated_lengths_equal_those_on_the_tangent_graph(scene: Scene, seed: int) -> None:
    space = FreeSpace(scene, arc_error=COARSE)
    check_lengths(space, awkward_places(space, seed)[:8])


@settings(max_examples=60, deadline=None)
@given(scenes(), st.integers(0, 9))
def test_generated_routes_are_allowed_and_exactly_shortest(scene: Scene, seed: int) -> None:
    space = FreeSpace(scene, arc_error=COARSE)
    check_exactly(space, awkward_places(space, seed)[:5])


@pytest.mark.parametrize("factor", [1e-6, 1.0, 1e7])
@pytest.mark.parametrize("seed", range(10))
def test_random_lengths_equal_those_on_the_tangent_graph_at_every_scale(seed: int, factor: float) -> None:
    scene = transformed(random_scene(robots=3, obstacles=15, seed=seed, clearance=0.1 * (seed % 3)), factor, 0.0)
    for growth in growths(scene):
        space = FreeSpace(scene, growth)
        check_lengths(space, awkward_places(space, seed))


@pytest.mark.parametrize("seed", range(10))
def test_random_lengths_equal_those_on_the_tangent_graph_far_from_the_origin(seed: int) -> None:
    scene = transformed(random_scene(robots=2, obstacles=15, seed=seed), 1.0, 1e7)
    space = FreeSpace(scene)
    check_lengths(space, awkward_places(space, seed))


def ring(centre: Point, radii: tuple[float, ...], count: int) -> list[Point]:
    turns = [(radii[k % len(radii)], math.tau * k / count) for k in range(count)]
    return [(centre[0] + r * math.cos(a), centre[1] + r * math.sin(a)) for r, a in turns]


def comb(teeth: int) -> Scene:
    """A hall with alternating walls from below and above, each of which leaves 1 m."""
    walls = [
        Polygon([(2 * k + 1, y), (2 * k + 2, y), (2 * k + 2, y + 9), (2 * k + 1, y + 9)])
        for k in range(teeth)
        for y in [0.0 if k % 2 == 0 else 1.0]
    ]
    return Scene((0, 0, 2 * teeth + 1, 10), walls)


def spiral(turns: int) -> Scene:
    """A wall 0.25 m thick that winds inwards, 1 m from turn to turn."""
    side = 4.0 * turns
    x, y, step, heading = 0.0, 0.0, side, 0
    points = [(x, y)]
    while step > 1:
        x, y = x + step * (1, 0, -1, 0)[heading % 4], y + step * (0, 1, 0, -1)[heading % 4]
        points.append((x, y))
        heading += 1
        step -= 1.0 if heading % 2 == 0 else 0.0
    walls = [
        Polygon([(a - 0.125, b - 0.125), (c + 0.125, b - 0.125), (c + 0.125, d + 0.125), (a - 0.125, d + 0.125)])
        for p, q in pairwise(points)
        for (a, c), (b, d) in [(sorted((p[0], q[0])), sorted((p[1], q[1])))]
    ]
    return Scene((-3, -3, side + 3, side + 3), walls)


def star(points: int) -> Scene:
    """A courtyard of many rays with a star in its middle."""
    return Scene(ring((0, 0), (10, 3), 2 * points), [Polygon(ring((0, 0), (2.5, 1), 2 * points))])


@pytest.mark.parametrize("scene", [comb(40), spiral(6), star(48)], ids=["comb", "spiral", "star"])
def test_lengths_in_mazes_equal_those_on_the_tangent_graph(scene: Scene) -> None:
    space = FreeSpace(scene)
    check_lengths(space, awkward_places(space))


def test_a_way_through_a_comb_has_the_length_of_its_turns() -> None:
    teeth = 40
    route = shortest_path(FreeSpace(comb(teeth)), (0, 0), (2 * teeth + 1, 0))
    length = math.hypot(1, 9) + (teeth - 1) * (1 + math.hypot(1, 8)) + math.hypot(2, 1)
    assert math.isclose(route.length, length, rel_tol=1e-12)


def test_collinear_corners_on_both_sides_of_the_line_are_passed_straight() -> None:
    boxes = [Polygon([(x, y), (x + 1, y), (x + 1, y + 3), (x, y + 3)]) for x, y in ((2, 1), (5, 4), (8, 1), (11, 4))]
    space = FreeSpace(Scene((0, 0, 14, 8), boxes))
    assert shortest_path(space, (0, 4), (14, 4)).length == 14.0
    check_lengths(space, np.array([(0, 4), (14, 4), (0, 7.5), (14, 7.5), (0, 0.5), (5.5, 7.5), (8.5, 0.5)]))


def test_a_start_on_a_pinch_leaves_to_both_sides_but_nothing_passes_it() -> None:
    boxes = [Polygon([(0, 0), (4, 0), (4, 4), (0, 4)]), Polygon([(4, 4), (8, 4), (8, 8), (4, 8)])]
    space = FreeSpace(Scene((0, 0, 8, 8), boxes))
    assert shortest_path(space, (4, 4), (6, 2)).length == math.hypot(2, 2)
    assert shortest_path(space, (2, 6), (4, 4)).length == math.hypot(2, 2)
    with pytest.raises(NoPath):
        shortest_path(space, (2, 6), (6, 2))


def test_start_and_goal_at_one_place_give_one_point_and_no_work() -> None:
    space = FreeSpace(Scene((0, 0, 8, 8), [Polygon([(2, 2), (6, 2), (6, 6), (2, 6)])]))
    for place in ((1, 1), (2, 2), (4, 2), (0, 0)):
        route = shortest_path(space, place, place)
        assert (route.length, len(route.points), route.expanded) == (0.0, 1, 0)


@pytest.mark.parametrize("seed", range(5))
def test_for_a_visible_goal_no_more_is_looked_through_than_lies_on_the_way(seed: int) -> None:
    space = FreeSpace(random_scene(robots=2, obstacles=40, seed=seed))
    mesh = space.mesh
    triangles = shapely.polygons(mesh.vertices[mesh.triangles])
    rng = np.random.default_rng(seed)
    low, high = mesh.vertices.min(axis=0), mesh.vertices.max(axis=0)
    ends = rng.uniform(low, high, (400, 2, 2))
    ends = ends[space.contains(ends[:, 0]) & space.contains(ends[:, 1])]
    lengths, expanded = direct_lengths(space, ends[:, 0], ends[:, 1])
    straight = np.isclose(lengths, np.hypot(*(ends[:, 1] - ends[:, 0]).T), rtol=1e-15)
    assert straight.sum() > 5
    for line, count in zip(shapely.linestrings(ends[straight]), expanded[straight], strict=True):
        assert count < shapely.intersects(line, triangles).sum()


def test_batches_of_any_size_give_the_same_routes_bit_for_bit() -> None:
    space = FreeSpace(random_scene(robots=2, obstacles=60, seed=3))
    low, high = space.mesh.vertices.min(axis=0), space.mesh.vertices.max(axis=0)
    places = np.random.default_rng(3).uniform(low, high, (1400, 2))
    places = places[space.contains(places)][:1000]
    starts, goals = places[::2], places[1::2]
    lengths, expanded = direct_lengths(space, starts, goals)
    routes = direct_paths(space, starts, goals)
    assert len(routes) == len(starts) > 256
    np.testing.assert_allclose([r.length for r in routes], lengths, rtol=1e-14)
    for k in range(0, len(starts), 29):
        alone = shortest_path(space, starts[k], goals[k])
        assert (alone.points == routes[k].points).all()
        assert alone.expanded == routes[k].expanded == expanded[k]


def test_long_searches_find_room_for_all_that_they_must_remember() -> None:
    rng = np.random.default_rng(1)
    pillars = [
        Polygon(ring((x + dx, y + dy), (0.3,), 5))
        for x in range(1, 30)
        for y in range(1, 30)
        for dx, dy in [rng.uniform(-0.15, 0.15, 2)]
    ]
    # the goal is walled in but for a door on the far side, so nearly all is searched
    walls = [
        Polygon(c) for c in ([(30, 13), (40, 13), (40, 13.5), (30, 13.5)], [(30, 16), (40, 16), (40, 16.5), (30, 16.5)])
    ]
    walls.append(Polygon([(30, 13.5), (30.5, 13.5), (30.5, 16), (30, 16)]))
    space = FreeSpace(Scene((0, 0, 42, 30), [*pillars, *walls]))
    route = shortest_path(space, (0.2, 14.9), (31, 15))
    expected = shortest_routes(space, visibility_graph(space), (0.2, 14.9), (31, 15))[0]
    assert route.expanded > 5000
    assert math.isclose(route.length, expected.length, rel_tol=1e-12)


@pytest.mark.parametrize(
    ("a", "b", "error"),
    [((4, 4), (1, 1), StartBlocked), ((1, 1), (9, 1), GoalBlocked), ((math.nan, 1), (1, 1), StartBlocked)],
)
def test_blocked_ends_are_told_as_on_the_tangent_graph(a: Point, b: Point, error: type[Exception]) -> None:
    space = FreeSpace(Scene((0, 0, 8, 8), [Polygon([(2, 2), (6, 2), (6, 6), (2, 6)])]), growth=0.5)
    with pytest.raises(error) as expected:
        shortest_routes(space, visibility_graph(space), a, b)
    for search in (shortest_path, direct_paths, direct_lengths):
        with pytest.raises(error) as found:
            search(space, a, b)
        assert str(found.value) == str(expected.value)


def test_separated_ends_are_told_as_on_the_tangent_graph() -> None:
    space = FreeSpace(Scene((0, 0, 8, 8), [Polygon([(-1, 3), (9, 3), (9, 5), (-1, 5)])]), growth=0.25)
    starts, goals = [(1, 1), (1, 1)], [(2, 2), (1, 7)]
    with pytest.raises(NoPath) as expected:
        shortest_routes(space, visibility_graph(space), starts, goals)
    with pytest.raises(NoPath) as found:
        direct_paths(space, starts, goals)
    assert str(found.value) == str(expected.value)
    assert direct_lengths(space, starts, goals)[0].tolist() == [math.hypot(1, 1), math.inf]


def test_nothing_asked_is_nothing_found() -> None:
    space = FreeSpace(Scene((0, 0, 8, 8)))
    assert direct_paths(space, [], []) == []
    assert [len(column) for column in direct_lengths(space, [], [])] == [0, 0]


def test_a_map_without_room_blocks_every_start() -> None:
    space = FreeSpace(Scene((0, 0, 4, 4), [Polygon([(-1, -1), (5, -1), (5, 5), (-1, 5)])]))
    with pytest.raises(StartBlocked):
        shortest_path(space, (1, 1), (2, 2))


@pytest.mark.parametrize(
    ("starts", "goals"), [([(1, 1), (2, 2)], [(1, 1)]), ([(1, 1, 1)], [(1, 1)]), (np.zeros((2, 2, 2)), [(1, 1)])]
)
def test_arrays_that_are_no_pairs_of_points_are_refused(starts: FloatArray, goals: FloatArray) -> None:
    with pytest.raises(ValueError, match=r"starts"):
        direct_lengths(FreeSpace(Scene((0, 0, 8, 8))), starts, goals)


def test_one_pair_means_one_pair() -> None:
    with pytest.raises(ValueError, match="a must be one point"):
        shortest_path(FreeSpace(Scene((0, 0, 8, 8))), [(1, 1), (2, 2)], (3, 3))
