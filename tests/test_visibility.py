"""The visibility graph and the shortest routes equal the exact references on the zoo and on generated scenes."""

from __future__ import annotations

import math
from itertools import pairwise
from typing import Literal

import numpy as np
import pytest
import shapely
from hypothesis import given, settings
from hypothesis import strategies as st

from naive import Pair, Vertex, naive_shortest, naive_visibility
from strategies import scenes
from taut.errors import NoPath
from taut.freespace import FreeSpace
from taut.geometry.triangulation import triangulate
from taut.graph import Graph, components
from taut.roadmap import VisibilityGraph, visibility_graph
from taut.route import shortest_path
from taut.scene import Polygon, Rectangle, Scene
from zoo import ZOO, Entry

MOST_VERTICES = 160
COARSE = 0.2  # arcs with few corners, so that the cubic references stay quick


def growths(scene: Scene) -> list[float]:
    return sorted({scene.growth(robot) for robot in scene.robots} | {scene.clearance})


def free_spaces(scene: Scene) -> list[FreeSpace]:
    """The free space of every growth of the scene that is not too large for the references.

    The references know no tolerance, so passages narrower than it are left open here.
    """
    spaces = [FreeSpace(scene, growth, arc_error=COARSE) for growth in growths(scene)]
    small = [space for space in spaces if len(shapely.get_coordinates(space.region)) <= MOST_VERTICES]
    for space in small:
        object.__setattr__(space, "mesh", triangulate(space.region))
    return small


def ends(space: FreeSpace) -> np.ndarray:
    """Distinct starts and goals of the robots of this growth, as the roadmap places them."""
    places = [p for r in space.scene.robots if space.scene.growth(r) == space.growth for p in (r.start, r.goal)]
    xy, triangles = space.anchor(list(dict.fromkeys(places)))
    return np.unique(xy[triangles >= 0], axis=0)


def named(graph: VisibilityGraph, space: FreeSpace) -> list[Vertex]:
    """The graph's vertices as the references name them."""
    mesh = space.mesh
    out: list[Vertex] = []
    for (x, y), wedge in zip(graph.positions.tolist(), graph.wedges.tolist(), strict=True):
        key = None if wedge < 0 else tuple(mesh.vertices[mesh.wedges[wedge, 1]].tolist())
        out.append((x, y, key))
    return out


def pairs(graph: VisibilityGraph, names: list[Vertex]) -> set[Pair]:
    return {frozenset((names[i], names[j])) for i, j in graph.edges.tolist()}


def check_edges(space: FreeSpace) -> None:
    points = ends(space)
    tangent = visibility_graph(space, "tangent", points)
    names = named(tangent, space)
    assert pairs(tangent, names) == naive_visibility(space.region, points.tolist(), "tangent")
    every = visibility_graph(space, "all", points)
    names = named(every, space)
    corners = [name for name in names if name[2] is not None]
    assert pairs(every, names) == naive_visibility(space.region, points.tolist(), "all", corners)
    for graph in (tangent, every):
        between = graph.positions[graph.edges[:, 0]] - graph.positions[graph.edges[:, 1]]
        np.testing.assert_allclose(graph.lengths, np.hypot(*between.T), rtol=1e-15)


def check_routes(space: FreeSpace) -> None:
    points = ends(space)
    if len(points) < 2:
        return
    for a, b in pairwise(points):
        expected = naive_shortest(space.region, a.tolist(), b.tolist())
        if expected is None:
            with pytest.raises(NoPath):
                shortest_path(space, a, b)
            continue
        route = shortest_path(space, a, b)
        assert math.isclose(route.length, expected, rel_tol=1e-12)
        assert (route.points[[0, -1]] == [a, b]).all()
        steps = np.hypot(*np.diff(route.points, axis=0).T)
        assert math.isclose(steps.sum(), expected, rel_tol=1e-12)


@pytest.mark.parametrize("entry", ZOO, ids=str)
def test_zoo_edges_equal_the_reference(entry: Entry) -> None:
    for space in free_spaces(entry.scene):
        check_edges(space)


@pytest.mark.parametrize("entry", ZOO, ids=str)
def test_zoo_routes_equal_the_reference(entry: Entry) -> None:
    for space in free_spaces(entry.scene):
        check_routes(space)


@pytest.mark.parametrize("entry", ZOO, ids=str)
def test_zoo_reachability_is_known_at_once(entry: Entry) -> None:
    for robot in entry.scene.robots:
        if robot.name not in entry.reachable:
            continue
        space = FreeSpace.of(entry.scene, robot)
        if entry.reachable[robot.name]:
            space.require(robot)
        else:
            with pytest.raises(NoPath):
                space.require(robot)


@settings(max_examples=500, deadline=None)
@given(scenes())
def test_generated_edges_equal_the_reference(scene: Scene) -> None:
    for space in free_spaces(scene):
        check_edges(space)


@settings(max_examples=150, deadline=None)
@given(scenes())
def test_generated_routes_equal_the_reference(scene: Scene) -> None:
    for space in free_spaces(scene):
        check_routes(space)


@settings(max_examples=60, deadline=None)
@given(scenes(), st.sampled_from(["all", "tangent"]))
def test_all_and_tangent_edges_give_the_same_lengths(scene: Scene, edges: str) -> None:
    from taut.graph import dijkstra

    for space in free_spaces(scene):
        points = ends(space)
        if not len(points):
            continue
        few, many = visibility_graph(space, "tangent", points), visibility_graph(space, "all", points)
        k = len(points)
        for source in range(k):
            short, _ = dijkstra(few.graph, few.graph.n - k + source)
            long, _ = dijkstra(many.graph, many.graph.n - k + source)
            np.testing.assert_allclose(short[-k:], long[-k:], rtol=1e-12)


@pytest.mark.parametrize("gap", [0.0, 1e-16, 1e-13])
@pytest.mark.parametrize("angle", [0.0, 0.3, 1.1])
def test_a_wall_of_rectangles_end_to_end_has_no_hairline_gaps(angle: float, gap: float) -> None:
    along = np.array([math.cos(angle), math.sin(angle)])
    middles = [np.array([10.0, 10.0]) + (2 + gap) * (k - 2) * along for k in range(5)]
    wall = [Rectangle(x - 1, y - 0.25, 2, 0.5, angle) for x, y in middles]
    space = FreeSpace(Scene((0, 0, 20, 20), wall))
    across = np.array([-along[1], along[0]])
    route = shortest_path(space, middles[2] - 3 * across, middles[2] + 3 * across)
    round_the_end = 2 * math.hypot(5, 2.75) + 0.5
    assert math.isclose(route.length, round_the_end, rel_tol=1e-9)


def test_corners_that_touch_up_to_rounding_do_not_let_through() -> None:
    third = 1.0 / 3.0
    left = Polygon([(0, 0), (3 * third - 1e-16, 2), (0, 4)])
    right = Polygon([(4, 0), (4, 4), (0.1 + 0.2 + 0.7, 2)])
    space = FreeSpace(Scene((0, 0, 4, 4), [left, right]))
    with pytest.raises(NoPath):
        shortest_path(space, (1, 0), (1, 4))


def test_a_gap_wider_than_the_tolerance_stays_open() -> None:
    scene = Scene((0, 0, 4, 4), [Rectangle(0, 1, 2, 1), Rectangle(2 + 1e-9, 1, 1.9, 1)])
    assert shortest_path(FreeSpace(scene), (2, 0), (2, 4)).length < 4 + 1e-8


@pytest.mark.parametrize("edges", ["tangent", "all"])
def test_a_point_where_free_space_touches_itself_is_an_end_only(edges: Literal["tangent", "all"]) -> None:
    space = FreeSpace(Scene((0, 0, 4, 4), [Rectangle(0, 2, 2, 2), Rectangle(2, 0, 2, 2)]))
    graph = visibility_graph(space, edges, [(1, 1), (2, 2), (3, 3)])
    first = graph.graph.n - 3
    assert np.flatnonzero(graph.ends_only).tolist() == [first + 1]
    found = set(map(tuple, graph.edges.tolist()))
    assert {(first, first + 1), (first + 1, first + 2)} <= found  # it belongs to both sides
    through = ~graph.ends_only[graph.edges].any(axis=1)
    links = Graph.from_edges(graph.graph.n, graph.edges[through])
    assert components(links)[first] != components(links)[first + 2]
