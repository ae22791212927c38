"""The Voronoi roadmap is as far from everything as it says and leads along the widest ways that there are."""

from __future__ import annotations

from itertools import pairwise
from typing import Any

import numpy as np
import pytest
import shapely
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.sparse import coo_array
from scipy.sparse.csgraph import connected_components

from strategies import scenes
from taut.errors import GoalBlocked, NoPath, StartBlocked
from taut.formats import load_scene
from taut.freespace import FreeSpace
from taut.geometry.seeing import see_each_other
from taut.roadmap.voronoi import VoronoiRoadmap, boundary_distances, voronoi_roadmap
from taut.route.widest import widest_routes
from taut.scene import Circle, Obstacle, Polygon, Rectangle, Scene
from zoo import ZOO, Entry, transformed


def spaces(scene: Scene) -> list[FreeSpace]:
    return [FreeSpace(scene, growth) for growth in sorted({scene.growth(r) for r in scene.robots} | {scene.clearance})]


def ends_of(space: FreeSpace) -> list[tuple[Any, Any]]:
    """Starts and goals of the robots of this growth that can reach their goals."""
    robots = [r for r in space.scene.robots if space.scene.growth(r) == space.growth]
    parts = [space.part_of([r.start, r.goal]) for r in robots]
    return [(r.start, r.goal) for r, (a, b) in zip(robots, parts, strict=True) if a & b]


def joined(roadmap: VoronoiRoadmap) -> tuple[int, np.ndarray]:
    """How many parts the graph has, and the part of each vertex."""
    n, edges = roadmap.graph.n, roadmap.edges
    matrix = coo_array((np.ones(len(edges)), (edges[:, 0], edges[:, 1])), shape=(n, n))
    count, label = connected_components(matrix, directed=False)
    return int(count), label


def is_open(space: FreeSpace, start: Any, goal: Any, room: float) -> bool:
    """Whether some way in the plane keeps so much room: free space of discs larger by as much connects the two.

    Rounded corners are drawn outside their arcs, so that where this says open it is.
    """
    grown = FreeSpace(space.scene, space.growth + room, arc_error=1e-4)
    a, b = grown.part_of([start, goal])
    return bool(a & b)


def check(roadmap: VoronoiRoadmap) -> None:
    """All that holds on any roadmap whose cells all have a vertex."""
    space, edges = roadmap.freespace, roadmap.edges
    mesh, boundary, tol = space.mesh, space.region.boundary, space.scene.tol
    assert (mesh.locate(roadmap.positions) >= 0).all()
    assert not mesh.on_pinch(roadmap.positions).any()
    for i, j in ((0, 1), (1, 0)):
        a, b = edges[:, i].copy(), edges[:, j].copy()
        assert see_each_other(mesh, roadmap.positions, roadmap.triangles, a, b).all()
    lines = shapely.linestrings(roadmap.positions[edges])
    assert np.abs(shapely.distance(lines, boundary) - roadmap.clearances).max(initial=0.0) <= tol
    points = shapely.points(roadmap.positions)
    assert np.abs(shapely.distance(points, boundary) - roadmap.vertex_clearances).max(initial=0.0) <= tol
    assert (roadmap.lengths > 0).all()
    assert roadmap.error >= 0.0


def check_connected(roadmap: VoronoiRoadmap) -> None:
    count, label = joined(roadmap)
    part = roadmap.freespace.mesh.parts[roadmap.triangles]
    assert count == roadmap.freespace.parts
    assert len(np.unique(np.stack([label, part]), axis=1).T) == count


def check_widest(roadmap: VoronoiRoadmap, start: Any, goal: Any) -> None:
    (route,) = widest_routes(roadmap, [start], [goal])
    space, tol = roadmap.freespace, roadmap.freespace.scene.tol
    assert tuple(route.points[0]) == tuple(start)
    assert tuple(route.points[-1]) == tuple(goal)
    line = shapely.LineString(route.points) if len(route.points) > 1 else shapely.Point(route.points[0])
    assert line.distance(space.region.boundary) == pytest.approx(route.clearance, abs=2 * tol)
    radius = space.growth + max((o.own_radius for o in space.scene.obstacles), default=0.0)
    arcs = space.arc_error * radius
    assert not is_open(space, start, goal, route.clearance + roadmap.error + arcs + 2 * tol)


@pytest.mark.parametrize("entry", ZOO, ids=str)
def test_every_awkward_scene_has_a_roadmap_of_allowed_edges_with_exact_clearances_that_connects_its_parts(
    entry: Entry,
) -> None:
    for space in spaces(entry.scene):
        roadmap = voronoi_roadmap(space)
        check(roadmap)
        check_connected(roadmap)
        assert roadmap.error <= 0.1 * roadmap.spacing


@pytest.mark.parametrize("entry", ZOO, ids=str)
def test_no_way_in_the_plane_is_wider_than_the_widest_route_by_more_than_the_stated_error(entry: Entry) -> None:
    for space in spaces(entry.scene):
        roadmap = voronoi_roadmap(space)
        for start, goal in ends_of(space):
            check_widest(roadmap, start, goal)


@settings(max_examples=40, deadline=None)
@given(scenes(max_obstacles=6), st.sampled_from([0.0, 0.0, 0.2]), st.sampled_from([None, 1.0, 0.1]))
def test_roadmaps_and_widest_routes_of_generated_scenes_keep_their_promises(
    scene: Scene, growth: float, spacing: float | None
) -> None:
    space = FreeSpace(scene, growth)
    roadmap = voronoi_roadmap(space, spacing)
    check(roadmap)
    places = [p for r in scene.robots for p in (r.start, r.goal)]
    places += [tuple(p) for p in space.mesh.vertices[space.mesh.triangles].mean(axis=1)[:4]]
    parts = space.part_of(places)
    for i in range(len(places) - 1):
        if parts[i] & parts[i + 1]:
            check_widest(roadmap, places[i], places[i + 1])


@settings(max_examples=30, deadline=None)
@given(scenes(max_obstacles=6))
def test_parts_of_generated_scenes_that_are_not_slivers_are_connected_in_themselves(scene: Scene) -> None:
    space = FreeSpace(scene)
    roadmap = voronoi_roadmap(space)
    mesh = space.mesh
    corners = mesh.vertices[mesh.triangles]
    sides = corners[:, 1:] - corners[:, :1]
    areas = np.abs(sides[:, 0, 0] * sides[:, 1, 1] - sides[:, 0, 1] * sides[:, 1, 0]) / 2
    large = np.flatnonzero(np.bincount(mesh.parts, areas, minlength=space.parts) > 1e-6)
    label, part = joined(roadmap)[1], mesh.parts[roadmap.triangles]
    for number in large:
        assert len(np.unique(label[part == number])) == 1


def test_every_vertex_is_as_near_to_two_places_of_the_boundary_within_the_discretisation() -> None:
    roadmap = voronoi_roadmap(FreeSpace(load_scene("thesis-1"), 0.25))
    boundary = roadmap.freespace.region.boundary
    for point, room in zip(shapely.points(roadmap.positions), roadmap.vertex_clearances.tolist(), strict=True):
        nearest = shapely.shortest_line(boundary, point).interpolate(0.0)
        elsewhere = boundary.difference(nearest.buffer(room / 2))
        assert elsewhere.distance(point) <= room + roadmap.error


def test_the_roadmap_rings_every_obstacle() -> None:
    obstacles: list[Obstacle] = [Rectangle(2, 2, 2, 3), Circle((8, 3), 1), Polygon([(3, 8), (9, 8), (6, 10)])]
    scene = Scene((0, 0, 12, 12), obstacles)
    roadmap = voronoi_roadmap(FreeSpace(scene))
    lines = shapely.polygonize(shapely.linestrings(roadmap.positions[roadmap.edges]))
    rings = shapely.get_parts(lines)
    assert len(rings) == 3
    for hole in roadmap.freespace.region.interiors:
        assert sum(shapely.Polygon(hole).within(ring) for ring in rings) == 1


def test_the_room_between_two_corners_a_corner_and_a_wall_and_two_walls_is_found_exactly() -> None:
    walls: list[Obstacle] = [
        Polygon([(4, 0), (5, 0), (4.5, 3)]), Polygon([(4, 10), (5, 10), (4.75, 7)]),
        Polygon([(9, 0), (10, 0), (9.5, 9)]),
        Rectangle(14, 0, 2, 4.3), Rectangle(14.5, 5.7, 1, 4.3),
    ]  # fmt: skip
    roadmap = voronoi_roadmap(FreeSpace(Scene((0, 0, 20, 10), walls)))
    ends = [((2.5, 5), (7, 5)), ((7, 5), (12, 5)), ((12, 5), (18, 5))]
    routes = widest_routes(roadmap, *zip(*ends, strict=True))
    exact = [np.hypot(0.25, 4) / 2, 0.5, 0.7]
    assert [route.clearance for route in routes] == pytest.approx(exact, abs=1e-12)


def test_a_side_of_less_than_a_rounding_does_not_keep_its_neighbours_from_being_sampled() -> None:
    walls: list[Obstacle] = [
        Polygon([(2.0597, 0.1329), (2.069, 2.0048), (-0.154, 2.2164), (-3, 1), (-1, -1), (0.0270, -0.3585)]),
        Polygon([(4, 0.01), (3.9788, 0.1142), (3.5297, 6e-17), (3.7856, -0.4), (5, -2)]),
    ]
    roadmap = voronoi_roadmap(FreeSpace(Scene((0, 0, 8, 8), walls)))
    check(roadmap)
    assert roadmap.error <= 0.1 * roadmap.spacing


def test_a_room_without_obstacles_has_its_own_axis() -> None:
    roadmap = voronoi_roadmap(FreeSpace(Scene((0, 0, 8, 4))))
    assert roadmap.vertex_clearances.max() == pytest.approx(2.0)
    middle = (roadmap.positions[:, 0] > 2.01) & (roadmap.positions[:, 0] < 5.99)
    assert roadmap.positions[middle, 1] == pytest.approx(2.0, abs=1e-12)
    (route,) = widest_routes(roadmap, [(0, 0)], [(8, 4)])
    assert route.clearance == 0.0


def test_among_equally_wide_routes_the_shortest_is_taken() -> None:
    # the start is the narrowest place, so both ways round the block are equally wide
    scene = Scene((0, 0, 20, 12), [Rectangle(6, 4, 8, 3)])
    roadmap = voronoi_roadmap(FreeSpace(scene))
    (route,) = widest_routes(roadmap, [(1, 5)], [(19, 5)])
    assert route.clearance == pytest.approx(1.0)
    assert route.points[:, 1].max() < 5.5
    (wide,) = widest_routes(roadmap, [(3, 5.5)], [(17, 5.5)])
    assert wide.clearance == pytest.approx(2.5, abs=roadmap.error)
    assert wide.points[:, 1].max() > 9


def test_finer_samples_state_smaller_errors() -> None:
    space = FreeSpace(load_scene("thesis-1"))
    errors = [voronoi_roadmap(space, spacing).error for spacing in (1.0, 0.5, 0.25, 0.125)]
    assert all(fine < 0.7 * coarse for coarse, fine in pairwise(errors))
    assert errors[-1] < 0.01


@pytest.mark.parametrize("factor", [1e-9, 1e6])
def test_scale_changes_nothing_but_lengths(factor: float) -> None:
    scene = load_scene("thesis-2")
    one, other = (voronoi_roadmap(FreeSpace(s)) for s in (scene, transformed(scene, factor, 0.0)))
    assert other.spacing == pytest.approx(factor * one.spacing)
    assert other.error == pytest.approx(factor * one.error, rel=0.2)
    start, goal = np.array([(3.0, 1.0)]), np.array([(12.0, 12.7)])
    (small,), (large,) = widest_routes(one, start, goal), widest_routes(other, factor * start, factor * goal)
    assert large.clearance == pytest.approx(factor * small.clearance, rel=1e-9)
    assert large.length == pytest.approx(factor * small.length, rel=1e-3)


def test_distances_from_the_boundary_are_those_of_shapely() -> None:
    space = FreeSpace(load_scene("appendix-d"), 0.1)
    rng = np.random.default_rng(0)
    places = rng.uniform(0, 16, (400, 2))
    triangles = space.mesh.locate(places)
    places, triangles = places[triangles >= 0], triangles[triangles >= 0]
    a, b = np.arange(len(places) - 1), np.arange(1, len(places))
    free = see_each_other(space.mesh, places, triangles, a, b)
    a, b = a[free], b[free]
    assert len(a) > 20
    lines = shapely.linestrings(np.stack([places[a], places[b]], axis=1))
    expected = shapely.distance(lines, space.region.boundary)
    assert boundary_distances(space.mesh, places[a], places[b], triangles[a]) == pytest.approx(expected, abs=1e-12)


def test_what_is_not_free_or_not_connected_is_said() -> None:
    roadmap = voronoi_roadmap(FreeSpace(Scene((0, 0, 10, 4), [Rectangle(4, 0, 1, 4)])))
    with pytest.raises(NoPath, match=r"no way from \(1, 1\) to \(8, 1\): obstacles separate them"):
        widest_routes(roadmap, [(1, 1)], [(8, 1)])
    with pytest.raises(StartBlocked, match=r"start \(4.5, 1\)"):
        widest_routes(roadmap, [(4.5, 1)], [(8, 1)])
    with pytest.raises(GoalBlocked, match=r"goal \(11, 1\)"):
        widest_routes(roadmap, [(1, 1)], [(11, 1)])
    with pytest.raises(ValueError, match="every start needs its goal"):
        widest_routes(roadmap, [(1, 1)], [])
    assert widest_routes(roadmap, [], []) == []


def test_a_start_that_is_the_goal_is_a_route_of_one_point() -> None:
    roadmap = voronoi_roadmap(FreeSpace(Scene((0, 0, 10, 4))))
    (route,) = widest_routes(roadmap, [(3, 1)], [(3, 1)])
    assert (len(route.points), route.clearance) == (1, 1.0)


def test_nothing_free_gives_a_roadmap_without_vertices() -> None:
    roadmap = voronoi_roadmap(FreeSpace(Scene((0, 0, 1, 1)), 2.0))
    assert (roadmap.graph.n, roadmap.graph.m, roadmap.error) == (0, 0, 0.0)
    with pytest.raises(StartBlocked):
        widest_routes(roadmap, [(0.5, 0.5)], [(0.5, 0.5)])


@pytest.mark.parametrize("spacing", [0.0, -1.0, np.nan, np.inf, 1e-9])
def test_a_spacing_that_cannot_be_used_is_refused(spacing: float) -> None:
    with pytest.raises(ValueError, match="spacing"):
        voronoi_roadmap(FreeSpace(Scene((0, 0, 4, 3))), spacing)
