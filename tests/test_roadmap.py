"""Every edge of a roadmap with places is an allowed motion, and there are places where robots need them."""

from __future__ import annotations

import math
from collections.abc import Iterable
from dataclasses import replace
from functools import cache

import numpy as np
import pytest
import shapely
from hypothesis import given, settings

from naive import ExactRegion, Spot
from strategies import team_scenes
from taut.errors import TautError
from taut.formats import load_scene
from taut.freespace import FreeSpace
from taut.graph import Graph, dijkstra
from taut.graph.core import Ints
from taut.roadmap import PlacesRoadmap, SharedRoadmap, places_roadmap
from taut.scene import FloatArray, Polygon, Robot, Scene
from taut.team.own_roadmap import OwnRoadmap, _rings
from taut.team.world import World
from zoo import ZOO, Entry

MOST_VERTICES = 160
COARSE = 0.2  # arcs with few corners, so that the exact reference stays quick
EXACT_EDGES = 40  # of each roadmap, beside those at a pinch


def roadmap_of(scene: Scene, growth: float, separation: float) -> PlacesRoadmap:
    return places_roadmap(FreeSpace(scene, growth, arc_error=COARSE), separation)


def separations(scene: Scene) -> list[float]:
    """A small and a large one for the size of the scene."""
    size = float(np.ptp(np.array(scene.workspace), axis=0).max())
    return [size / 20, size / 6]


def keys(roadmap: PlacesRoadmap) -> list[tuple[float, float, tuple[float, float]]]:
    """The corners as the reference names them."""
    mesh = roadmap.freespace.mesh
    at, first = (mesh.vertices[mesh.wedges[roadmap.tangents.wedges, k]].tolist() for k in (0, 1))
    return [(x, y, (a, b)) for (x, y), (a, b) in zip(at, first, strict=True)]


def corner_spots(roadmap: PlacesRoadmap, exact: ExactRegion) -> list[Spot]:
    """The corners' wedges; where a hairline is closed the reference knows only the place, with all wedges there."""
    known = {spot.vertex: spot for spot in exact.spots()}
    return [known[key] if key in known else exact.free(key[:2]) for key in keys(roadmap)]


def check_allowed(space: FreeSpace, spots: list[Spot], exact: ExactRegion, edges: Ints, xy: FloatArray) -> int:
    """Check all edges with GEOS, and some, with all that come near a pinch, exactly; returns how many of these."""
    if not len(edges):
        return 0
    lines = shapely.linestrings(xy[edges])
    scale = float(np.abs(xy).max())
    wide = space.region.buffer(1e-9 * scale)
    shapely.prepare(wide)
    assert shapely.covers(wide, lines).all()
    pinches = [place for place, wedges in exact.wedges.items() if len(wedges) > 1]
    at = shapely.MultiPoint([(x / exact.scale, y / exact.scale) for x, y in pinches])
    near = np.flatnonzero(shapely.dwithin(lines, at, 1e-9 * scale)) if pinches else np.empty(0, dtype=np.int64)
    rng = np.random.default_rng(0)
    some = rng.choice(len(edges), size=min(EXACT_EDGES, len(edges)), replace=False)
    for i, j in edges[np.union1d(near[:200], some)].tolist():
        assert exact.passed(spots[i], spots[j]) is not None, (xy[i].tolist(), xy[j].tolist())
    return len(near)


def check_roadmap(roadmap: PlacesRoadmap) -> int:
    space = roadmap.freespace
    xy, corners = roadmap.positions, roadmap.first_place
    between = xy[roadmap.edges[:, 0]] - xy[roadmap.edges[:, 1]]
    np.testing.assert_allclose(roadmap.lengths, np.hypot(*between.T), rtol=1e-15)
    assert (roadmap.lengths > 0).all()
    assert (space.mesh.locate(xy[corners:]) >= 0).all()
    if len(shapely.get_coordinates(space.region)) > MOST_VERTICES or space.region.is_empty:
        return 0
    places = [tuple(p) for p in xy[corners:].tolist()]
    exact = ExactRegion(space.region, places)
    spots = [*corner_spots(roadmap, exact), *(exact.free(place) for place in places)]
    assert all(len(spot.wedges) == 1 for spot in spots[corners:])  # a place at a pinch would let robots through
    return check_allowed(space, spots, exact, roadmap.edges, xy)


@pytest.mark.parametrize("entry", ZOO, ids=str)
def test_zoo_edges_are_allowed(entry: Entry) -> None:
    scene = entry.scene
    for growth in sorted({scene.growth(robot) for robot in scene.robots} | {scene.clearance}):
        for separation in separations(scene):
            check_roadmap(roadmap_of(scene, growth, separation))


def test_the_zoo_has_edges_at_pinches() -> None:
    names = ("three-at-a-point", "reflex-pinch", "checkerboard", "ring-touching-in-points")
    scenes = [entry.scene for entry in ZOO if entry.name in names]
    assert len(scenes) == 4
    assert sum(check_roadmap(roadmap_of(scene, 0.0, 0.4)) for scene in scenes) > 3


@settings(max_examples=60, deadline=None)
@given(team_scenes(max_robots=2))
def test_generated_edges_are_allowed(scene: Scene) -> None:
    for growth in sorted({scene.growth(robot) for robot in scene.robots} | {0.0}):
        check_roadmap(roadmap_of(scene, growth, 0.8))


# --- A robot's own part -----------------------------------------------------------------------------------------------


def check_own(world: World, i: int) -> None:
    """Check the edges that one robot has beyond the shared ones; its ends count where they are anchored."""
    shared, own, robot = world.shared(i), world.own(i), world.scene.robots[i]
    assert isinstance(shared, PlacesRoadmap)
    space, n, tol = shared.freespace, len(shared.positions), world.scene.tol
    assert (own.positions[:2] == [robot.start, robot.goal]).all()
    assert ((own.edges >= 0) & (own.edges < n + len(own.positions))).all()
    assert (own.edges.max(axis=1) >= n).all()
    assert len(np.unique(np.sort(own.edges, axis=1), axis=0)) == len(own.edges)
    xy = np.concatenate([shared.positions, own.positions])
    np.testing.assert_allclose(own.lengths, np.hypot(*(xy[own.edges[:, 0]] - xy[own.edges[:, 1]]).T), rtol=1e-15)
    anchored, holders = space.anchor(xy[n:])
    assert (holders >= 0).all()
    assert (np.hypot(*(anchored - xy[n:]).T) <= tol).all()
    xy[n:] = anchored
    if len(shapely.get_coordinates(space.region)) > MOST_VERTICES:
        return
    corners = shared.first_place
    places = [tuple(p) for p in xy[corners:].tolist()]
    exact = ExactRegion(space.region, places)
    spots = [*corner_spots(shared, exact), *(exact.free(place) for place in places)]
    check_allowed(space, spots, exact, own.edges, xy)
    for v in range(n + 2, len(xy)):
        ways = own.edges[(own.edges == v).any(axis=1)].sum(axis=1) - v
        assert any(all(wedge.admits(spots[u].place) for u in ways.tolist()) for wedge in spots[v].wedges), (
            f"a stop at the pinch {places[v - corners]} leads from one side to the other"
        )


def connected(shared: SharedRoadmap, own: OwnRoadmap) -> bool:
    """Whether the own edges and the shared ones lead from the start to the goal."""
    n = len(shared.positions)
    seen, stack = {n}, [n]
    indptr, heads, _ = own.adjacency(n)
    while stack:
        u = stack.pop()
        ways = heads[indptr[u] : indptr[u + 1]].tolist()
        if u < n:
            ways += shared.graph.indices[shared.graph.indptr[u] : shared.graph.indptr[u + 1]].tolist()
        for v in ways:
            if v not in seen:
                seen.add(v)
                stack.append(v)
    return n + 1 in seen


@cache
def world_of(scene: Scene) -> World | None:
    try:
        return World(scene)
    except TautError:
        return None


@pytest.mark.parametrize("entry", [entry for entry in ZOO if entry.scene.robots], ids=str)
def test_zoo_own_edges_are_allowed(entry: Entry) -> None:
    keep = tuple(r for r in entry.scene.robots if entry.reachable.get(r.name, True))
    if not keep:
        return
    world = World(replace(entry.scene, robots=keep))
    for detours in (False, True):
        if detours:
            for i in range(len(world.scene.robots)):
                world.avoid_all_ends(i)
        for i, robot in enumerate(keep):
            if robot.start != robot.goal:
                check_own(world, i)
                assert connected(world.shared(i), world.own(i))


@settings(max_examples=40, deadline=None)
@given(team_scenes(max_robots=3))
def test_generated_own_edges_are_allowed(scene: Scene) -> None:
    world = world_of(scene)
    if world is None:
        return
    for i, robot in enumerate(scene.robots):
        if robot.start != robot.goal:
            check_own(world, i)


def test_the_shortest_route_lies_on_the_roadmap() -> None:
    scene = load_scene("office-20")
    world = World(scene)
    for i in range(len(scene.robots)):
        shared, own = world.shared(i), world.own(i)
        n = len(shared.positions)
        edges = np.concatenate([shared.edges, own.edges])

        graph = Graph.from_edges(n + len(own.positions), edges, np.concatenate([shared.lengths, own.lengths]))
        assert dijkstra(graph, n)[0][n + 1] == pytest.approx(world.routes[i].length, rel=1e-12)


# --- Rings and places -------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("distance", [1e-9, 0.3, 7.0, 1e6])
def test_rings_keep_their_distance(distance: float) -> None:
    centres = np.array([(0.0, 0.0), (3.5, -1.25), (1e3, 1e3)])
    corners = _rings(centres, np.full(3, distance)).reshape(3, -1, 2)
    for centre, ring in zip(centres, corners, strict=True):
        sides = shapely.linestrings(np.stack([ring, np.roll(ring, -1, axis=0)], axis=1))
        away = shapely.distance(sides, shapely.Point(centre))
        rounding = 4 * np.spacing(np.abs(ring).max())
        assert (away >= distance - rounding).all()
        assert np.hypot(*(ring - centre).T).max() <= 1.1 * distance + rounding


def test_a_ring_leads_round_a_robot_in_the_way() -> None:
    """In an empty hall the way round who stands on the straight line keeps the separation, and little more."""
    stander = Robot("S", (10, 10), (10, 10), 0.5)
    scene = Scene((0, 0, 20, 20), robots=[Robot("R", (2, 10), (18, 10), 0.5), stander], gap=0.25)
    world = World(scene)
    shared, own = world.shared(0), world.own(0)
    n = len(shared.positions)
    xy = np.concatenate([shared.positions, own.positions])
    edges = np.concatenate([shared.edges, own.edges])
    lengths = np.concatenate([shared.lengths, own.lengths])
    clear = shapely.distance(shapely.linestrings(xy[edges]), shapely.Point(10, 10)) >= 1.25

    graph = Graph.from_edges(len(xy), edges[clear], lengths[clear])
    way = dijkstra(graph, n)[0][n + 1]
    d, half = 1.25, 8.0
    taut = 2 * (math.sqrt(half**2 - d**2) + d * math.asin(d / half))
    assert taut <= way <= 1.03 * taut


def nearest(roadmap: PlacesRoadmap, points: Iterable[tuple[float, float]]) -> FloatArray:
    away, _ = roadmap.places.query(np.array(list(points), dtype=np.float64).reshape(-1, 2))
    return np.asarray(away)


def test_the_bay_of_a_corridor_has_a_place_to_wait() -> None:
    scene = load_scene("corridor-swap")
    robot = scene.robots[0]
    roadmap = places_roadmap(FreeSpace.of(scene, robot), scene.separation(robot, robot))
    bay = roadmap.positions[roadmap.first_place :]
    # one who waits here keeps the distance to one who passes along the corridor
    assert (bay[:, 1] >= 0.65 + scene.separation(robot, robot) - 0.15 - 1e-9).any()
    assert nearest(roadmap, [(8.75, 1.65), (9.65, 1.65)]).max() < 0.5


@pytest.mark.parametrize("width", [1e-3, 0.1, 0.5])
def test_a_narrow_corridor_has_places(width: float) -> None:
    """However narrow: in its dead ends and in between, though no lattice place falls into it."""
    corridor = Scene([(0, 0), (10, 0), (10, 6), (10 - width, 6), (10 - width, width), (0, width)])
    roadmap = places_roadmap(FreeSpace(corridor), 0.4)
    ends = [(0, width / 2), (10 - width / 2, 6), (10, 0)]
    assert nearest(roadmap, ends).max() <= 0.3 * roadmap.spacing + width
    assert nearest(roadmap, [(5 - width / 2, width / 2), (10 - width / 2, 3)]).max() <= 0.6 * roadmap.spacing + width


def test_every_tooth_of_a_comb_has_places() -> None:
    scene = next(entry.scene for entry in ZOO if entry.name == "comb")
    roadmap = places_roadmap(FreeSpace(scene, 0.25), 0.6)
    teeth = [(15.5 - 2 * k, 5.75) for k in range(8)]
    assert nearest(roadmap, teeth).max() <= 0.3 * roadmap.spacing + 0.25


def test_every_dead_end_and_every_passage_has_a_place_nearby() -> None:
    for entry in ZOO[:20]:
        space = FreeSpace(entry.scene, arc_error=COARSE)
        roadmap = places_roadmap(space, 0.5)
        mesh = space.mesh
        ends = mesh.vertices[mesh.wedges[mesh.wedge_turns < 0, 0]]
        ends = ends[~mesh.on_pinch(ends)]
        t, k = np.nonzero(mesh.neighbours >= 0)
        middles = (mesh.vertices[mesh.triangles[t, k]] + mesh.vertices[mesh.triangles[t, (k + 1) % 3]]) / 2
        middles = middles[mesh.locate(middles) >= 0]
        assert nearest(roadmap, ends.tolist()).max() <= 0.3 * roadmap.spacing
        assert nearest(roadmap, middles.tolist()).max(initial=0) <= 0.6 * roadmap.spacing


def test_a_hall_has_a_lattice_of_sixteen_directions() -> None:
    roadmap = places_roadmap(FreeSpace(Scene((0, 0, 20, 20))), 0.5)
    assert roadmap.spacing == 1.0
    corner = roadmap.first_place
    middle = corner + int(roadmap.places.query((10.0, 10.0))[1])
    around = roadmap.graph.indices[roadmap.graph.indptr[middle] : roadmap.graph.indptr[middle + 1]]
    steps = roadmap.positions[around] - roadmap.positions[middle]
    assert len({round(math.atan2(y, x), 6) for x, y in steps.tolist()}) == 16


def test_large_halls_have_a_bounded_number_of_places() -> None:
    roadmap = places_roadmap(FreeSpace(Scene((0, 0, 1000, 1000))), 0.01)
    assert 7000 < len(roadmap.positions) < 9000


def test_a_single_robot_needs_no_places() -> None:
    space = FreeSpace(Scene((0, 0, 8, 8), [Polygon([(2, 2), (6, 2), (6, 6), (2, 6)])]))
    roadmap = places_roadmap(space, math.inf)
    assert len(roadmap.positions) == roadmap.first_place == 4
    assert roadmap.edges.tolist() == roadmap.tangents.edges.tolist()


@pytest.mark.parametrize("separation", [1.0, math.inf])
def test_where_nothing_is_free_the_roadmap_is_empty(separation: float) -> None:
    roadmap = places_roadmap(FreeSpace(Scene((0, 0, 4, 4)), 10.0), separation)
    assert (roadmap.graph.n, roadmap.graph.m) == (0, 0)


def test_routes_with_detours_avoid_all_other_ends() -> None:
    """After `avoid_all_ends` each robot has, where it can be, a way that nobody's start or goal blocks."""
    team = [
        Robot("A", (2, 10), (18, 10), 0.5),
        Robot("B", (10, 10), (10, 10), 0.5),
        Robot("C", (10, 2), (10, 18), 0.5),
    ]
    world = World(Scene((0, 0, 20, 20), robots=team, gap=0.1))
    for i in range(len(world.scene.robots)):
        world.avoid_all_ends(i)
    for i in (0, 2):
        shared, own = world.shared(i), world.own(i)
        n = len(shared.positions)
        xy = np.concatenate([shared.positions, own.positions])
        edges = own.edges[(own.edges >= n).all(axis=1)]
        others = [p for k, robot in enumerate(team) if k != i for p in (robot.start, robot.goal)]
        clear = (shapely.distance(shapely.linestrings(xy[edges])[:, None], shapely.points(others)) >= 1.1).all(axis=1)

        graph = Graph.from_edges(len(xy), edges[clear])
        assert np.isfinite(dijkstra(graph, n)[0][n + 1])


def test_robots_that_change_places_have_no_way_round_their_ends() -> None:
    """Then they keep the ways they have; it is no error that another's goal is one's own start."""
    team = [Robot("A", (2, 5), (8, 5), 0.5), Robot("B", (8, 5), (2, 5), 0.5)]
    world = World(Scene((0, 0, 10, 10), robots=team))
    for i in range(len(world.scene.robots)):
        world.avoid_all_ends(i)
    assert [len(route.points) for route in world.routes] == [2, 2]
    check_own(world, 0)
