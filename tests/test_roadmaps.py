"""Grids, samples and cells: allowed edges, right lengths, and routes along them that are as good as promised."""

from __future__ import annotations

import math
from collections.abc import Callable
from itertools import pairwise
from typing import Any

import networkx as nx
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from naive import ExactRegion
from strategies import grid_scenes
from taut.errors import GoalBlocked, NoPath, StartBlocked
from taut.freespace import FreeSpace
from taut.generate import random_scene
from taut.graph import components
from taut.roadmap.cells import cells_roadmap
from taut.roadmap.core import LocatedRoadmap
from taut.roadmap.grid import grid_roadmap
from taut.roadmap.sampled import draw_samples, sampled_roadmap
from taut.route import direct_paths, shortest_path
from taut.route.along import attached, routes_along
from taut.route.core import Route
from taut.route.lazy import lazy_route
from taut.route.smoothing import smoothed
from taut.scene import Circle, FloatArray, Polygon, Rectangle, Scene
from zoo import ZOO, Entry, transformed

COARSE = 0.2  # arcs with few corners, so that the exact reference stays quick
SCALES = [(1.0, 0.0), (1e-9, 0.0), (1e6, 0.0), (0.1, 0.3)]


def coarse_grid(space: FreeSpace, directions: int) -> LocatedRoadmap:
    return grid_roadmap(space, math.sqrt(space.area / 150) if space.area else None, directions)


MAKERS: dict[str, Callable[[FreeSpace], LocatedRoadmap]] = {
    "grid-4": lambda space: coarse_grid(space, 4),
    "grid-8": lambda space: coarse_grid(space, 8),
    "grid-16": lambda space: coarse_grid(space, 16),
    "sampled": lambda space: sampled_roadmap(space, samples=60, seed=1),
    "cells": cells_roadmap,
}
# the other grids have no edges that the finest has not
VARIED = {name: MAKERS[name] for name in ("grid-16", "sampled", "cells")}


def spaces_of(scene: Scene, arc_error: float = 1e-3) -> list[FreeSpace]:
    growths = sorted({scene.growth(robot) for robot in scene.robots} | {scene.clearance})
    return [FreeSpace(scene, growth, arc_error) for growth in growths]


def places_in(space: FreeSpace, count: int = 6) -> FloatArray:
    """Starts and goals of the scene, vertices of the mesh, pinches first, and middles of its sides: all free."""
    mesh = space.mesh
    own = np.array([p for r in space.scene.robots for p in (r.start, r.goal)], dtype=np.float64).reshape(-1, 2)
    corners = mesh.vertices[mesh.triangles]
    others = np.concatenate([mesh.vertices, ((corners + np.roll(corners, 1, axis=1)) / 2).reshape(-1, 2)])
    others = np.random.default_rng(0).permutation(np.unique(others, axis=0))
    places = np.concatenate([own, others[mesh.on_pinch(others)][:3], others])
    places = places[space.anchor(places)[1] >= 0]
    return places[:count]


def check_legs(space: FreeSpace, legs: FloatArray) -> None:
    """Each of (k, 2, 2) legs is an allowed motion, exactly."""
    exact = ExactRegion(space.region, [(x, y) for x, y in legs.reshape(-1, 2).tolist()])
    for (a, b), (c, d) in legs.tolist():
        assert exact.passed(exact.free((a, b)), exact.free((c, d))) is not None, f"({a}, {b}) to ({c}, {d})"


def check_route(space: FreeSpace, points: FloatArray) -> None:
    """All legs are allowed, and no place inside the route is one where free space touches itself."""
    assert (np.diff(points, axis=0) != 0).any(axis=1).all()
    assert not space.mesh.on_pinch(points[1:-1]).any()
    check_legs(space, np.stack([points[:-1], points[1:]], axis=1))


def hall(*obstacles: Any) -> FreeSpace:
    return FreeSpace(Scene((0, 0, 10, 10), obstacles))


def crowded(seed: int = 2, obstacles: int = 12) -> tuple[FreeSpace, FloatArray, FloatArray]:
    """A random free space with starts and goals in it."""
    scene = random_scene(robots=12, obstacles=obstacles, seed=seed)
    starts, goals = (np.array([getattr(r, end) for r in scene.robots]) for end in ("start", "goal"))
    return FreeSpace.of(scene, scene.robots[0]), starts, goals


# ---------------------------------------------------------------------------------------------------------------------
# Roadmaps


@pytest.mark.parametrize("make", VARIED.values(), ids=VARIED)
@pytest.mark.parametrize("entry", ZOO, ids=str)
def test_zoo_edges_are_allowed_motions_of_their_lengths(entry: Entry, make: Callable[[FreeSpace], Any]) -> None:
    for space in spaces_of(entry.scene, COARSE):
        roadmap = make(space)
        ends = roadmap.positions[roadmap.edges]
        np.testing.assert_allclose(roadmap.lengths, np.hypot(*(ends[:, 0] - ends[:, 1]).T), rtol=1e-14)
        assert (roadmap.lengths > 0).all()
        assert not space.mesh.on_pinch(roadmap.positions).any()
        for k in range(3):
            a = space.mesh.vertices[space.mesh.triangles[roadmap.triangles, k]]
            b = space.mesh.vertices[space.mesh.triangles[roadmap.triangles, (k + 1) % 3]]
            (ux, uy), (vx, vy) = (b - a).T, (roadmap.positions - a).T
            assert (ux * vy - uy * vx >= -1e-12 * (np.abs(ux * vy) + np.abs(uy * vx))).all()
        if len(ends) and len(space.mesh.vertices) < 100:
            check_legs(space, np.random.default_rng(0).permutation(ends)[:10])


@pytest.mark.parametrize("make", VARIED.values(), ids=VARIED)
@pytest.mark.parametrize(("factor", "shift"), [(1e-9, 0.0), (1e6, 0.0), (1.0, 1e7)])
def test_edges_are_allowed_at_every_scale(factor: float, shift: float, make: Callable[[FreeSpace], Any]) -> None:
    for seed in range(3):
        scene = transformed(random_scene(robots=2, obstacles=12, seed=seed), factor, shift)
        space = FreeSpace(scene, scene.growth(scene.robots[0]), COARSE)
        roadmap = make(space)
        assert roadmap.graph.m > 20
        check_legs(space, np.random.default_rng(0).permutation(roadmap.positions[roadmap.edges])[:40])


@pytest.mark.parametrize("make", MAKERS.values(), ids=MAKERS)
def test_an_empty_free_space_has_an_empty_roadmap(make: Callable[[FreeSpace], LocatedRoadmap]) -> None:
    roadmap = make(FreeSpace(Scene((0, 0, 1, 1)), growth=1.0))
    assert roadmap.positions.shape == (0, 2)
    assert roadmap.graph.n == roadmap.graph.m == 0
    with pytest.raises(StartBlocked):
        routes_along(roadmap, [(0.5, 0.5)], [(0.5, 0.5)])


@pytest.mark.parametrize(("directions", "neighbours"), [(4, 4), (8, 8), (16, 16)])
def test_grid_joins_all_its_directions_in_the_open(directions: int, neighbours: int) -> None:
    roadmap = grid_roadmap(FreeSpace(Scene((0, 0, 10, 8))), spacing=1, directions=directions)
    assert len(roadmap.positions) == 11 * 9
    centre = int(np.flatnonzero((roadmap.positions == (5, 4)).all(axis=1))[0])
    around = roadmap.graph.indices[roadmap.graph.indptr[centre] : roadmap.graph.indptr[centre + 1]]
    assert len(around) == neighbours
    steps = np.abs(roadmap.positions[around] - (5, 4))
    assert (np.sort(steps, axis=1) <= (1, 2 if directions == 16 else 1)).all()


@pytest.mark.parametrize("directions", [4, 8, 16])
def test_grid_joins_exactly_the_neighbours_that_see_each_other(directions: int) -> None:
    space = hall(Rectangle(2.3, 1.1, 3.1, 4.3, angle=0.4), Circle((7.1, 6.2), 1.7))
    roadmap = grid_roadmap(space, 0.9, directions)
    exact = ExactRegion(space.region, [(x, y) for x, y in roadmap.positions.tolist()])
    spots = [exact.free((x, y)) for x, y in roadmap.positions.tolist()]
    least, most = {4: (1, 1), 8: (1, 2), 16: (1, 5)}[directions]
    expected = set()
    for i in range(len(spots)):
        across = np.rint((roadmap.positions - roadmap.positions[i]) / 0.9).astype(int)
        squares = (across**2).sum(axis=1)
        for j in np.flatnonzero((squares >= least) & (squares <= most) & (squares != 4)).tolist():
            if i < j and exact.passed(spots[i], spots[j]) is not None:
                expected.add((i, j))
    assert set(map(tuple, roadmap.edges.tolist())) == expected


@pytest.mark.parametrize(("directions", "excess"), [(4, math.sqrt(2)), (8, 1.0824), (16, 1.0275)])
def test_grid_lengths_in_the_open_stay_within_the_bound_of_their_directions(directions: int, excess: float) -> None:
    roadmap = grid_roadmap(FreeSpace(Scene((0, 0, 60, 60))), spacing=1, directions=directions)
    graph = nx.Graph()
    graph.add_weighted_edges_from(zip(*roadmap.edges.T.tolist(), roadmap.lengths.tolist(), strict=True))
    known = nx.single_source_dijkstra_path_length(graph, 0)
    away = np.hypot(*(roadmap.positions - roadmap.positions[0]).T)
    ratios = np.array([known[v] / away[v] for v in range(1, len(away))])
    assert ratios.max() <= excess + 1e-4
    assert ratios.max() >= excess - 5e-3


def test_grid_usually_has_a_few_thousand_places_at_every_scale() -> None:
    space, _, _ = crowded()
    counts = {grid_roadmap(FreeSpace(transformed(space.scene, factor, 0.0), factor * space.growth)).graph.n
              for factor in (1.0, 2.0**-20, 2.0**20)}  # fmt: skip
    assert len(counts) == 1
    assert 3500 < counts.pop() < 4500


def test_samples_are_spread_evenly() -> None:
    space = hall(Rectangle(0, 0, 5, 5), Rectangle(6, 6, 2, 2))
    found = draw_samples(space, 20_000, seed=3).positions
    assert len(found) == 20_000
    for box in ((0, 5, 5, 10), (5, 0, 10, 2), (8, 6, 10, 8), (5.5, 5.5, 6, 9)):
        share = (box[2] - box[0]) * (box[3] - box[1]) / space.area
        inside = ((found >= box[:2]) & (found <= box[2:])).all(axis=1).sum()
        assert abs(inside - 20_000 * share) < 5 * math.sqrt(20_000 * share)


def test_samples_try_their_nearest() -> None:
    space = hall(Circle((5, 5), 2))
    drawn = draw_samples(space, 50, seed=4, neighbours=3)
    away = np.hypot(*(drawn.positions[:, None] - drawn.positions[None]).transpose(2, 0, 1))
    expected = {(min(i, j), max(i, j)) for i in range(50) for j in np.argsort(away[i])[1:4].tolist()}
    assert set(map(tuple, drawn.pairs.tolist())) == expected


def test_the_usual_number_of_neighbours_is_that_of_prm_star() -> None:
    space = hall()
    usual = draw_samples(space, 200)
    asked = draw_samples(space, 200, neighbours=math.ceil(2 * math.e * math.log(200)))
    np.testing.assert_array_equal(usual.pairs, asked.pairs)


def test_the_same_seed_gives_the_same_samples_and_another_seed_others() -> None:
    space, _, _ = crowded()
    one, same, other = (sampled_roadmap(space, 100, seed) for seed in (5, 5, 6))
    np.testing.assert_array_equal(one.positions, same.positions)
    np.testing.assert_array_equal(one.edges, same.edges)
    assert not (one.positions == other.positions).any()


@pytest.mark.parametrize("count", [1, 2, 3])
def test_few_samples_suffice_for_a_roadmap(count: int) -> None:
    roadmap = sampled_roadmap(hall(), count)
    assert roadmap.graph.n == count
    assert roadmap.graph.m == count * (count - 1) // 2


@pytest.mark.parametrize("entry", ZOO, ids=str)
def test_cells_connect_what_the_free_space_connects(entry: Entry) -> None:
    for factor, shift in SCALES:
        for space in spaces_of(transformed(entry.scene, factor, shift)):
            roadmap = cells_roadmap(space)
            found = components(roadmap.graph)
            parts = space.mesh.parts[roadmap.triangles]
            assert len(set(zip(found.tolist(), parts.tolist(), strict=True))) == len(set(found.tolist())) == space.parts


@pytest.mark.parametrize("entry", ZOO, ids=str)
def test_cells_are_complete(entry: Entry) -> None:
    for factor, shift in SCALES:
        for space in spaces_of(transformed(entry.scene, factor, shift)):
            places = places_in(space)
            parts = space.part_of(places)
            roadmap = cells_roadmap(space)
            pairs = [(i, j) for i in range(len(places)) for j in range(len(places))]
            joined = [(i, j) for i, j in pairs if parts[i] & parts[j]]
            if joined:
                routes = routes_along(roadmap, *places[np.array(joined).T])
                for (i, j), route in zip(joined, routes, strict=True):
                    assert (route.points[[0, -1]] == places[[i, j]]).all()
            for i, j in set(pairs) - set(joined):
                with pytest.raises(NoPath, match="separate them"):
                    routes_along(roadmap, places[i], places[j])


BAD: list[tuple[Callable[[FreeSpace], object], str]] = [
    (lambda s: grid_roadmap(s, 0), "spacing"),
    (lambda s: grid_roadmap(s, -1.0), "spacing"),
    (lambda s: grid_roadmap(s, math.nan), "spacing"),
    (lambda s: grid_roadmap(s, math.inf), "spacing"),
    (lambda s: grid_roadmap(s, 1e-9), "take more"),
    (lambda s: grid_roadmap(s, 1.0, 5), "4, 8 or 16"),
    (lambda s: sampled_roadmap(s, 0), "samples"),
    (lambda s: sampled_roadmap(s, -1), "samples"),
    (lambda s: sampled_roadmap(s, 1.5), "samples"),  # type: ignore[arg-type]
    (lambda s: sampled_roadmap(s, 10**12), "take fewer"),
    (lambda s: sampled_roadmap(s, 10, seed=-1), "seed"),
    (lambda s: sampled_roadmap(s, 10, neighbours=0), "neighbours"),
    (lambda s: lazy_route(s, (1, 1), (2, 2), samples=0), "samples"),
    (lambda s: lazy_route(s, [(1, 1), (2, 2)], [(2, 2), (3, 3)]), "one point"),
    (lambda s: attached(cells_roadmap(s), [(1, 1)], nearest=0), "nearest"),
    (lambda s: routes_along(cells_roadmap(s), [(1, 1)], [(2, 2), (3, 3)]), "every start needs its goal"),
    (lambda s: smoothed(s, Route(np.array([(0, 0), (50.0, 0), (1, 1)]))), "not in free space"),
]


@pytest.mark.parametrize(("call", "said"), BAD)
def test_bad_parameters_are_named(call: Callable[[FreeSpace], object], said: str) -> None:
    with pytest.raises(ValueError, match=said):
        call(hall())


# ---------------------------------------------------------------------------------------------------------------------
# Routes along them


@pytest.mark.parametrize("make", VARIED.values(), ids=VARIED)
@pytest.mark.parametrize("entry", ZOO, ids=str)
def test_zoo_routes_are_allowed_and_smoothing_keeps_them_so(entry: Entry, make: Callable[[FreeSpace], Any]) -> None:
    for space in spaces_of(entry.scene, COARSE):
        if len(space.mesh.vertices) > 60:
            continue
        roadmap = make(space)
        for a, b in pairwise(places_in(space, 4)):
            try:
                route = routes_along(roadmap, a, b)[0]
            except NoPath:
                continue
            short = smoothed(space, route)
            least = shortest_path(space, a, b).length
            assert least * (1 - 1e-14) <= short.length <= route.length
            for found in (route, short):
                assert (found.points[[0, -1]] == [a, b]).all()
                check_route(space, found.points)


@settings(max_examples=60, deadline=None)
@given(grid_scenes(), st.sampled_from(sorted(MAKERS)))
def test_generated_routes_are_allowed_and_never_too_short(scene: Scene, kind: str) -> None:
    space = FreeSpace(scene)
    roadmap = MAKERS[kind](space)
    for robot in scene.robots:
        try:
            route = routes_along(roadmap, robot.start, robot.goal)[0]
        except (NoPath, StartBlocked, GoalBlocked):
            continue
        check_route(space, route.points)
        short = smoothed(space, route)
        check_route(space, short.points)
        least = shortest_path(space, robot.start, robot.goal).length
        assert least * (1 - 1e-14) <= short.length <= route.length


@pytest.mark.parametrize("make", MAKERS.values(), ids=MAKERS)
def test_routes_are_the_shortest_of_the_joined_graph(make: Callable[[FreeSpace], LocatedRoadmap]) -> None:
    space, starts, goals = crowded()
    roadmap = make(space)
    graph = nx.Graph()
    graph.add_weighted_edges_from(zip(*roadmap.edges.T.tolist(), roadmap.lengths.tolist(), strict=True))
    compared = 0
    for a, b in zip(starts, goals, strict=True):
        ends = attached(roadmap, [a, b])
        own = [(-1 - i, v, length) for (i, v), length in zip(ends.pairs.tolist(), ends.lengths.tolist(), strict=True)]
        graph.add_weighted_edges_from(own)
        try:
            length = routes_along(roadmap, a, b)[0].length
        except NoPath:
            assert not nx.has_path(graph, -1, -2)
        else:
            if length > math.dist(a, b) * (1 + 1e-12) and nx.has_path(graph, -1, -2):
                expected = nx.shortest_path_length(graph, -1, -2, weight="weight")
                assert math.isclose(length, expected, rel_tol=1e-12)
                compared += 1
        graph.remove_nodes_from([-1, -2])
    assert compared > 3


def test_many_routes_at_once_are_those_asked_for_one_by_one() -> None:
    space, starts, goals = crowded()
    roadmap = grid_roadmap(space)
    together = routes_along(roadmap, starts, goals)
    for a, b, route in zip(starts, goals, together, strict=True):
        np.testing.assert_array_equal(routes_along(roadmap, a, b)[0].points, route.points)


def test_no_ends_have_no_routes() -> None:
    assert routes_along(cells_roadmap(hall()), [], []) == []


def test_a_route_to_where_it_starts_is_one_point() -> None:
    assert routes_along(cells_roadmap(hall()), (1, 1), (1, 1))[0].points.tolist() == [[1.0, 1.0]]


def test_places_are_attached_to_the_nearest_that_they_see() -> None:
    space = hall(Rectangle(4, 0, 1, 9))
    roadmap = grid_roadmap(space, 1.0)
    ends = attached(roadmap, [(3.4, 2.2), (4.5, 5), (11, 11)], nearest=5)
    assert (ends.triangles >= 0).tolist() == [True, False, False]
    assert (ends.pairs[:, 0] == 0).all()
    near = roadmap.positions[ends.vertices]
    assert near.tolist() == [[3, 2], [4, 2], [3, 3], [4, 3], [3, 1]]
    np.testing.assert_allclose(ends.lengths, np.hypot(*(near - (3.4, 2.2)).T))
    assert (np.diff(ends.lengths) >= 0).all()


def test_places_are_attached_however_far_what_they_see_is() -> None:
    # behind the thin wall stand hundreds of vertices that are nearer than the only one in sight
    space = hall(Rectangle(1, 0, 0.01, 9.9))
    whole = grid_roadmap(space, 0.5)
    kept = (whole.positions[:, 0] > 1) | (whole.positions[:, 1] > 9.6)
    roadmap = LocatedRoadmap(
        whole.positions[kept], sampled_roadmap(hall(), int(kept.sum())).graph, space, whole.triangles[kept]
    )
    ends = attached(roadmap, [(0.5, 0.2)], nearest=4)
    assert len(ends.vertices) > 0
    assert (roadmap.positions[ends.vertices, 0] <= 1).all()


def test_ends_are_joined_farther_off_where_the_nearest_lead_nowhere() -> None:
    space = hall(Rectangle(4, 2, 1, 7))
    far, crowd = np.array([(2.0, 9.5), (8, 9.5)]), np.random.default_rng(0).uniform((1, 3), (3, 4), (80, 2))
    positions = np.concatenate([far, crowd])
    graph = sampled_roadmap(hall(), len(positions)).graph.from_edges(len(positions), [(0, 1)], [6.0])
    roadmap = LocatedRoadmap(positions, graph, space, space.mesh.locate(positions))
    route = routes_along(roadmap, (2, 3.5), (8, 3.5))[0]
    assert route.points.tolist() == [[2, 3.5], [2, 9.5], [8, 9.5], [8, 3.5]]


def test_no_path_tells_a_roadmap_too_coarse_from_obstacles_in_the_way() -> None:
    gap = hall(Rectangle(4, 0, 1, 4.9), Rectangle(4, 5.03, 1, 4.97))
    wall = hall(Rectangle(4, 0, 1, 10))
    with pytest.raises(NoPath, match="this roadmap does not connect them"):
        routes_along(grid_roadmap(gap, 2.0), (1, 1), (9, 1))
    with pytest.raises(NoPath, match="obstacles separate them"):
        routes_along(grid_roadmap(wall, 2.0), (1, 1), (9, 1))
    with pytest.raises(NoPath, match="this roadmap does not connect them"):
        lazy_route(gap, (1, 1), (9, 1), samples=20)
    with pytest.raises(NoPath, match="obstacles separate them"):
        lazy_route(wall, (1, 1), (9, 1), samples=20)
    assert routes_along(grid_roadmap(gap, 0.05), (1, 1), (9, 1))[0].length > 8
    with pytest.raises(GoalBlocked):
        routes_along(grid_roadmap(wall, 2.0), (1, 1), (4.5, 1))
    with pytest.raises(StartBlocked):
        lazy_route(wall, (4.5, 1), (1, 1))


def test_sampled_lengths_converge_to_the_shortest() -> None:
    space, starts, goals = crowded(seed=7, obstacles=8)
    least = np.array([route.length for route in direct_paths(space, starts, goals)])
    ratios = []
    for count in (100, 400, 1600, 6400):
        found = []
        for seed in range(3):
            routes = routes_along(sampled_roadmap(space, count, seed), starts, goals)
            found.append(np.array([route.length for route in routes]) / least)
        assert np.min(found) >= 1 - 1e-12
        ratios.append(np.mean(found))
    assert (np.diff(ratios) < 0).all()
    assert ratios[-1] < 1.02


# ---------------------------------------------------------------------------------------------------------------------
# Lazy roadmaps


@pytest.mark.parametrize("seed", range(5))
def test_lazy_routes_are_as_long_as_those_along_the_whole_roadmap(seed: int) -> None:
    space, starts, goals = crowded(seed)
    roadmap = sampled_roadmap(space, 300, seed)
    whole = set(map(tuple, roadmap.edges.tolist()))
    for a, b in zip(starts, goals, strict=True):
        try:
            expected = routes_along(roadmap, a, b)[0].length
        except NoPath:
            with pytest.raises(NoPath):
                lazy_route(space, a, b, 300, seed)
            continue
        route = lazy_route(space, a, b, 300, seed)
        assert math.isclose(route.length, expected, rel_tol=1e-12)
        assert (route.tested | ~route.blocked).all()
        for edge, blocked in zip(route.candidates[route.tested], route.blocked[route.tested], strict=True):
            assert (tuple(edge.tolist()) in whole) != blocked
        assert route.tested.mean() < 0.5
        used = {tuple(p) for p in route.points[1:-1].tolist()}
        assert used <= {tuple(p) for p in route.positions.tolist()}


# ---------------------------------------------------------------------------------------------------------------------
# Smoothing


def test_smoothing_a_route_past_a_touching_point_does_not_pass_it() -> None:
    space = FreeSpace(Scene((0, 0, 8, 8), [Polygon([(4, 4), (1, 3), (1, 2)]), Polygon([(4, 4), (7, 2), (7, 3)])]))
    points = np.array([(4, 3), (4, 1), (0.5, 1), (0.5, 3.5), (4, 4), (7.5, 3.5)], dtype=np.float64)
    short = smoothed(space, Route(points))
    assert short.length < Route(points).length
    at = short.points.tolist().index([4.0, 4.0])
    assert short.points[at - 1, 0] < 4
    assert short.points[at - 1, 1] > 3
    check_legs(space, np.stack([short.points[:-1], short.points[1:]], axis=1))


@pytest.mark.parametrize("entry", ZOO, ids=str)
def test_shortest_routes_are_smooth(entry: Entry) -> None:
    for space in spaces_of(entry.scene):
        for a, b in pairwise(places_in(space)):
            try:
                route = shortest_path(space, a, b)
            except NoPath:
                continue
            assert math.isclose(smoothed(space, route).length, route.length, rel_tol=1e-12)


def test_long_routes_are_smoothed_throughout() -> None:
    space = FreeSpace(Scene((0, 0, 1000, 3)))
    x = np.linspace(0, 1000, 3000)
    route = Route(np.stack([x, 1.5 + np.sin(x)], axis=1))
    assert math.isclose(smoothed(space, route).length, math.dist(route.points[0], route.points[-1]), rel_tol=1e-9)


def test_a_smoothed_route_stays_as_it_is() -> None:
    space, starts, goals = crowded()
    for route in routes_along(grid_roadmap(space), starts, goals):
        once = smoothed(space, route)
        np.testing.assert_array_equal(smoothed(space, once).points, once.points)


@pytest.mark.parametrize("points", [[(1.0, 1.0)], [(1.0, 1.0), (2.0, 2.0)]])
def test_points_and_legs_are_smooth(points: list[tuple[float, float]]) -> None:
    route = Route(np.array(points))
    assert smoothed(hall(), route) is route
