"""A map with one obstacle more or less equals the map built anew."""

from __future__ import annotations

import math
from dataclasses import replace
from random import Random

import numpy as np
import pytest
import shapely
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.sparse import coo_array
from scipy.sparse.csgraph import connected_components
from scipy.spatial import KDTree

from strategies import scenes
from taut.errors import NoPath, SceneError
from taut.freespace import FreeSpace
from taut.geometry.triangulation import Ints, Triangulation
from taut.roadmap import VisibilityGraph, visibility_graph
from taut.roadmap.changing import Changed, with_obstacle, without_obstacle
from taut.route import shortest_path, shortest_routes
from taut.scene import Circle, Line, Obstacle, Polygon, Rectangle, Robot, Scene
from zoo import ZOO, Entry

HALL = Scene((0, 0, 8, 8))
COARSE = 0.1  # arcs with few corners, so that fresh builds stay quick


def built(scene: Scene, growth: float = 0.0) -> Changed:
    freespace = FreeSpace(scene, growth, COARSE)
    tangents = visibility_graph(freespace)
    return Changed(freespace, tangents, np.arange(tangents.graph.n), True)


def added(state: Changed, obstacle: Obstacle) -> Changed:
    return with_obstacle(state.freespace, state.tangents, obstacle)


def removed(state: Changed, name: str) -> Changed:
    return without_obstacle(state.freespace, state.tangents, name)


def anew(state: Changed) -> Changed:
    return built(state.freespace.scene, state.freespace.growth)


def corner_labels(a: Changed, b: Changed, tol: float) -> tuple[Ints, Ints]:
    """Number the vertices of two meshes alike where they are the same place, to within ``tol`` metres."""
    n = len(a.freespace.mesh.vertices)
    both = np.concatenate([a.freespace.mesh.vertices, b.freespace.mesh.vertices])
    if not len(both):
        return np.empty(0, dtype=np.int64), np.empty(0, dtype=np.int64)
    near = KDTree(both).query_pairs(tol, output_type="ndarray")
    links = coo_array((np.ones(len(near)), (near[:, 0], near[:, 1])), shape=(len(both), len(both)))
    label = connected_components(links, directed=False)[1].astype(np.int64)
    return label[:n], label[n:]


def named(a: Changed, b: Changed, tol: float) -> tuple[Ints, Ints]:
    """Number the vertices of two tangent graphs alike where place and neighbours on the boundary are the same."""
    labels = corner_labels(a, b, tol)
    wedges = [label[s.freespace.mesh.wedges[s.tangents.wedges, :3]] for s, label in zip((a, b), labels, strict=True)]
    name = np.unique(np.concatenate(wedges), axis=0, return_inverse=True)[1].reshape(-1)
    return name[: len(wedges[0])], name[len(wedges[0]) :]


def rows(pairs: Ints) -> list[list[int]]:
    """Pairs in either direction, sorted."""
    pairs = np.sort(pairs, axis=1)
    out: list[list[int]] = pairs[np.lexsort((pairs[:, 1], pairs[:, 0]))].tolist()
    return out


def places(state: Changed) -> list[list[complex]]:
    """The edges of the tangent graph as pairs of places, sorted."""
    at = np.sort((state.tangents.positions @ np.array([1, 1j]))[state.tangents.edges], axis=1)
    out: list[list[complex]] = at[np.lexsort((at[:, 1], at[:, 0]))].tolist()
    return out


def check_equal(state: Changed, fresh: Changed) -> None:
    """All that others read from the two maps is the same; places only to within the tolerance."""
    assert state.freespace.scene == fresh.freespace.scene
    assert state.freespace.scene.tol == fresh.freespace.scene.tol
    assert state.freespace.area == pytest.approx(fresh.freespace.area, rel=1e-12, abs=1e-300)
    assert state.freespace.parts == fresh.freespace.parts
    ours, theirs = named(state, fresh, fresh.freespace.scene.tol)
    assert sorted(ours.tolist()) == sorted(theirs.tolist())
    assert rows(ours[state.tangents.edges]) == rows(theirs[fresh.tangents.edges])
    check_sound(state)


def check_sound(state: Changed) -> None:
    """The tangent graph is, bit for bit, that of the free space, and all tables of the free space agree."""
    mesh, graph = state.freespace.mesh, state.tangents.graph
    seen = visibility_graph(state.freespace)
    assert rows(state.tangents.wedges[state.tangents.edges]) == rows(seen.wedges[seen.edges])
    ends = state.tangents.positions[state.tangents.edges]
    assert (state.tangents.lengths == np.hypot(*(ends[:, 0] - ends[:, 1]).T)).all()
    assert (state.tangents.positions == mesh.vertices[mesh.wedges[state.tangents.wedges, 0]]).all()
    row = np.repeat(np.arange(graph.n), np.diff(graph.indptr))
    assert (np.diff(row * graph.n + graph.indices) > 0).all()
    corners = mesh.vertices[mesh.triangles]
    sides = corners[:, 1:] - corners[:, :1]
    doubled = sides[:, 0, 0] * sides[:, 1, 1] - sides[:, 0, 1] * sides[:, 1, 0]
    assert state.freespace.area == pytest.approx(doubled.sum() / 2, rel=1e-9, abs=1e-300)
    assert shapely.is_valid(state.freespace.region)
    assert (mesh.locate(corners.mean(axis=1)) >= 0).all()


def changed_at_random(
    rng: np.random.Generator, state: Changed, step: int, kind: str, size: float, turn: float = 0.0
) -> Changed:
    obstacles = state.freespace.scene.obstacles
    if len(obstacles) and rng.random() < 0.5:
        return removed(state, obstacles[rng.integers(len(obstacles))].name)
    extent = np.array(state.freespace.scene.workspace).max()
    return added(state, obstacle(rng, kind, extent, size * (5 if rng.random() < 0.03 else 1), f"new-{step}", turn))


def obstacle(
    rng: np.random.Generator, kind: str, extent: float, size: float, name: str = "", turn: float = 0.0
) -> Obstacle:
    """One that touches others often ("grid"), overlaps them at any angle ("stars"), or is round ("shapes")."""
    x, y = rng.uniform(0, extent, 2).tolist()
    which = rng.integers(4)
    if kind == "grid":
        x, y = rng.integers(0, int(extent), 2).tolist()
        w, h = rng.integers(1, int(size) + 1, 2).tolist()
        corners = [(x, y), (x + w, y), (x + w, y + h), (x, y + h)]
        if which == 0:
            corners = corners[:2] + corners[3:]
        if which == 1:
            corners = [*corners[:2], (x + w, y + 1), (x + w + 1, y + h + 1), (x, y + h + 1)]
        c, s = math.cos(turn), math.sin(turn)
        middle = np.array([extent / 2, extent / 2])
        return Polygon((np.array(corners) - middle) @ np.array([[c, s], [-s, c]]) + middle if turn else corners, name)
    if kind == "shapes" and which == 0:
        return Circle((x, y), rng.uniform(0.2, size), name)
    if kind == "shapes" and which == 1:
        width, height = rng.uniform(0.2, 2 * size, 2).tolist()
        return Rectangle(x, y, width, height, rng.uniform(-3, 3), name)
    if kind == "shapes" and which == 2:
        return Line(
            np.cumsum([(x, y), *rng.uniform(-size, size, (2, 2))], axis=0).tolist(), rng.uniform(0.1, 0.4), name
        )
    count = int(rng.integers(3, 9))
    angle = 2 * math.pi * (np.arange(count) + rng.uniform(-0.24, 0.24, count)) / count
    reach = rng.uniform(0.2, 1, count) * size
    return Polygon(np.stack([x + reach * np.cos(angle), y + reach * np.sin(angle)], axis=1), name)


# kind, obstacles, side of the hall, size of an obstacle, growth, edits
CHAINS = [
    ("grid", 20, 16, 3, 0.0, 200),
    ("grid", 60, 30, 3, 0.0, 120),
    ("grid", 40, 30, 3, 0.3, 100),
    ("stars", 20, 20, 2.0, 0.0, 200),
    ("stars", 60, 40, 2.0, 0.0, 70),
    ("stars", 40, 40, 1.5, 0.3, 60),
    ("shapes", 30, 30, 1.5, 0.0, 150),
    ("shapes", 30, 40, 1.0, 0.3, 90),
    ("stars", 300, 90, 1.5, 0.0, 10),
]


@pytest.mark.parametrize(("kind", "count", "extent", "size", "growth", "edits"), CHAINS)
def test_every_edit_equals_a_fresh_build(
    kind: str, count: int, extent: float, size: float, growth: float, edits: int
) -> None:
    rng = np.random.default_rng(count)
    state = built(Scene((0, 0, extent, extent), [obstacle(rng, kind, extent, size) for _ in range(count)]), growth)
    rebuilt = 0
    for step in range(edits):
        state = changed_at_random(rng, state, step, kind, size)
        rebuilt += state.rebuilt
        fresh = anew(state)
        check_equal(state, fresh)
        triangles = len(state.freespace.mesh.triangles)
        assert abs(triangles - len(fresh.freespace.mesh.triangles)) <= 0.05 * triangles
    assert rebuilt <= edits / 20


def test_edits_that_touch_nothing_equal_a_fresh_build_bit_for_bit() -> None:
    rng = np.random.default_rng(4)
    middles = 2.0 + 3.0 * np.stack(np.meshgrid(np.arange(7), np.arange(7)), axis=-1).reshape(-1, 2)
    state = built(Scene((0, 0, 23, 23)))
    standing: dict[str, int] = {}
    for step in range(120):
        place = int(rng.integers(len(middles)))
        name = f"at-{place}"
        if name in standing:
            state = removed(state, name)
            del standing[name]
        else:
            shape = shapely.get_coordinates(shapely.Polygon(rng.uniform(-1, 1, (9, 2))).convex_hull)[:-1]
            state = added(state, Polygon(middles[place] + shape, name))
            standing[name] = step
        fresh = anew(state)
        assert not state.rebuilt
        assert places(state) == places(fresh)
        check_equal(state, fresh)


@pytest.mark.parametrize(
    ("count", "seed", "growth", "edits"), [(20, 0, 0.0, 40), (20, 1, 0.0, 40), (20, 2, 0.5, 30), (40, 11, 0.5, 12)]
)
def test_obstacles_that_touch_up_to_rounding_leave_all_distances_right(
    count: int, seed: int, growth: float, edits: int
) -> None:
    """Turned lattices: a hundred corners lie on others' edges but for rounding, which no two builds do alike.

    In the last of these scenes such a corner moves far from the edit, and two others see each other past it.
    """
    rng, drawn = np.random.default_rng(seed), np.random.default_rng(seed)
    state = built(Scene((0, 0, 16, 16), [obstacle(rng, "grid", 16, 2, turn=0.3) for _ in range(count)]), growth)
    for step in range(edits):
        state = changed_at_random(rng, state, step, "grid", 2, turn=0.3)
        fresh = anew(state)
        check_sound(state)
        assert state.freespace.area == pytest.approx(fresh.freespace.area, rel=1e-11)
        assert state.freespace.parts == fresh.freespace.parts
        ends = drawn.uniform(0, 16, (12, 2))
        ends = ends[fresh.freespace.contains(ends)]
        for a, b in zip(ends[::2], ends[1::2], strict=False):
            assert length(state, a, b) == pytest.approx(length(fresh, a, b), rel=1e-10)


def length(state: Changed, a: np.ndarray, b: np.ndarray) -> float:
    try:
        return shortest_routes(state.freespace, state.tangents, a, b)[0].length
    except NoPath:
        return math.inf


@pytest.mark.parametrize("entry", ZOO, ids=str)
def test_zoo_obstacles_can_go_and_come_back(entry: Entry) -> None:
    scene = entry.scene
    for growth in sorted({scene.growth(robot) for robot in scene.robots} | {scene.clearance}):
        whole = built(scene, growth)
        for gone in scene.obstacles[:3]:
            without = removed(whole, gone.name)
            check_equal(without, anew(without))
            back = added(without, gone)
            check_equal(back, anew(back))


@settings(max_examples=60, deadline=None)
@given(scenes(), st.sampled_from([0.0, 0.3]), st.randoms(use_true_random=False))
def test_generated_scenes_can_be_put_up_and_taken_down(scene: Scene, growth: float, order: Random) -> None:
    state = built(replace(scene, obstacles=()), growth)
    names = [o.name for o in scene.obstacles]
    for shape in scene.obstacles:
        state = added(state, shape)
        check_sound(state)
        check_alike(state, anew(state))
    order.shuffle(names)
    for name in names:
        state = removed(state, name)
        check_sound(state)
        check_alike(state, anew(state))


def check_alike(state: Changed, fresh: Changed) -> None:
    size = np.abs(np.array(fresh.freespace.scene.workspace)).max()
    assert state.freespace.area == pytest.approx(fresh.freespace.area, rel=1e-12, abs=1e-11 * size**2)
    assert state.freespace.parts == fresh.freespace.parts


def test_long_chains_keep_the_triangles_as_good_as_fresh_ones() -> None:
    rng = np.random.default_rng(5)
    state = built(Scene((0, 0, 30, 30), [obstacle(rng, "stars", 30, 2.0) for _ in range(40)]))
    for step in range(150):
        state = changed_at_random(rng, state, step, "stars", 2.0)
    assert not_delaunay(state.freespace.mesh) == 0
    assert len(state.freespace.mesh.triangles) == len(anew(state).freespace.mesh.triangles)
    cells = math.prod(state.freespace.mesh.grid[1].tolist())
    assert len(state.freespace.mesh.triangles) / 4 <= cells <= 4 * len(state.freespace.mesh.triangles)


def not_delaunay(mesh: Triangulation) -> int:
    """How many interior edges have the opposite corner clearly inside the circle about the triangle beside them."""
    t, k = np.nonzero(mesh.neighbours >= 0)
    s = mesh.neighbours[t, k]
    a, b, c = (mesh.vertices[mesh.triangles[t, (k + i) % 3]] for i in range(3))
    three = mesh.triangles[s]
    far = ~((three == mesh.triangles[t, k][:, None]) | (three == mesh.triangles[t, (k + 1) % 3][:, None]))
    d = mesh.vertices[three[far]]
    rows = [np.append(p - d, ((p - d) ** 2).sum(axis=1, keepdims=True), axis=1) for p in (a, b, c)]
    inside = np.linalg.det(np.stack(rows, axis=1))
    return int(np.count_nonzero(inside > 1e-9))


def test_a_passage_closes_and_opens() -> None:
    walls = [Rectangle(0, 3, 3.5, 2, name="left"), Rectangle(4.5, 3, 3.5, 2, name="right")]
    open_ = built(replace(HALL, obstacles=tuple(walls)))
    closed = added(open_, Rectangle(3, 3.5, 2, 1, name="door"))
    assert (open_.freespace.parts, closed.freespace.parts) == (1, 2)
    with pytest.raises(NoPath):
        shortest_path(closed.freespace, (4, 1), (4, 7))
    again = removed(closed, "door")
    assert again.freespace.parts == 1
    assert places(again) == places(open_)
    exact = added(open_, Rectangle(3.5, 3.5, 1, 1, name="door"))  # touches both sides
    assert exact.freespace.parts == 2
    check_equal(exact, anew(exact))
    grazed = added(open_, Polygon([(3.5, 3), (4.5, 5), (4, 4.5)], "door"))  # from corner to corner
    assert grazed.freespace.parts == 2
    check_equal(grazed, anew(grazed))


def test_what_stands_inside_others_or_outside_changes_only_the_scene() -> None:
    block = built(replace(HALL, obstacles=(Rectangle(2, 2, 4, 4, name="block"),)))
    for hidden in (Rectangle(3, 3, 1, 1, name="new"), Circle((20, 20), 1, "new"), Rectangle(2, 2, 4, 4, name="new")):
        for state in (added(block, hidden), removed(added(block, hidden), "new")):
            assert state.freespace.area == block.freespace.area
            assert places(state) == places(block)
            check_equal(state, anew(state))
    assert len(added(block, Circle((3, 3), 0.5)).freespace.scene.obstacles) == 2


def test_what_stood_hidden_comes_to_light() -> None:
    inner = Rectangle(3, 3, 1, 1, name="inner")
    both = built(replace(HALL, obstacles=(inner, Rectangle(2, 2, 4, 4, name="outer"))))
    alone = removed(both, "outer")
    assert alone.freespace.area == 63.0
    check_equal(alone, built(replace(HALL, obstacles=(inner,))))


def test_an_obstacle_over_everything_can_come_and_go() -> None:
    start = built(replace(HALL, obstacles=(Rectangle(2, 2, 1, 1, name="box"),)))
    covered = added(start, Rectangle(-1, -1, 9, 9, name="lid"))
    assert (covered.freespace.area, covered.freespace.parts, covered.tangents.graph.n) == (0.0, 0, 0)
    still = added(covered, Circle((4, 4), 1, "more"))
    assert still.tangents.graph.n == 0
    open_again = removed(removed(still, "lid"), "more")
    check_equal(open_again, anew(open_again))
    assert open_again.freespace.area == start.freespace.area


def test_places_are_found_where_nothing_was_free_before() -> None:
    lid = Rectangle(-1, 3, 9, 5, name="lid")  # over all but the lower side of the hall
    state = removed(built(replace(HALL, obstacles=(Rectangle(1, 1, 1, 1), Rectangle(6, 5, 1, 1), lid))), "lid")
    assert not state.rebuilt
    thrown = np.random.default_rng(8).uniform(-1, 9, (500, 2))
    assert (state.freespace.contains(thrown) == anew(state).freespace.contains(thrown)).all()
    check_equal(state, anew(state))


def test_a_map_filled_from_empty_finds_places_quickly() -> None:
    rng = np.random.default_rng(9)
    state = built(Scene((0, 0, 40, 40)))
    for step in range(60):
        state = added(state, obstacle(rng, "stars", 39, 1.0, f"new-{step}"))
        cells = math.prod(state.freespace.mesh.grid[1].tolist())
        assert cells / 4 <= len(state.freespace.mesh.triangles) <= 4 * cells


def test_starts_and_goals_at_rounded_corners_stay_free() -> None:
    """A disc may touch a corner from any side, though tangents stand for the arc about it."""
    corner, reach = np.array([4.0, 4.0]), 0.5
    start, goal = (corner + reach * np.array([math.cos(a), math.sin(a)]) for a in (0.3, 1.1))
    robot = Robot("R", tuple(start.tolist()), tuple(goal.tolist()), reach)
    state = built(replace(HALL, robots=(robot,)), reach)
    for box in (Rectangle(2, 2, 2, 2, name="alone"), Polygon([(4, 4), (2, 4.5), (1, 3), (3, 2)], "touching")):
        state = added(state, box)
        assert (state.freespace.anchor([start, goal])[1] >= 0).all()
        check_equal(state, anew(state))
    state = removed(state, "alone")
    assert (state.freespace.anchor([start, goal])[1] >= 0).all()
    check_equal(state, anew(state))


def test_a_pocket_filled_and_emptied_is_a_part_again() -> None:
    frame = [(1, 1, 6, 1), (1, 6, 6, 1), (1, 2, 1, 4), (6, 2, 1, 4)]
    state = built(replace(HALL, obstacles=tuple(Rectangle(*box) for box in frame)))
    full = added(state, Rectangle(2, 2, 4, 4, name="filling"))
    assert (state.freespace.parts, full.freespace.parts) == (2, 1)
    assert removed(full, "filling").freespace.parts == 2


def test_vertices_say_which_they_were() -> None:
    rng = np.random.default_rng(6)
    state = built(Scene((0, 0, 30, 30), [obstacle(rng, "stars", 30, 1.5) for _ in range(40)]))
    for step in range(20):
        after = changed_at_random(rng, state, step, "stars", 1.5)
        assert after.before.shape == (after.tangents.graph.n,)
        if after.rebuilt:
            assert (after.before == -1).all()
        stay = after.before >= 0
        assert (np.diff(after.before[stay]) > 0).all()
        assert stay[: np.count_nonzero(stay)].all()
        assert (after.tangents.positions[stay] == state.tangents.positions[after.before[stay]]).all()
        state = after


def test_the_map_before_stays_what_it_was() -> None:
    rng = np.random.default_rng(7)
    state = built(Scene((0, 0, 20, 20), [obstacle(rng, "grid", 20, 3) for _ in range(20)]))
    arrays = [*vars(state.freespace.mesh).values(), *vars(state.tangents.graph).values(), state.tangents.positions]
    copies = [a.copy() for a in arrays if isinstance(a, np.ndarray)]
    added(state, Rectangle(5, 5, 6, 6))
    removed(state, "O3")
    for before, now in zip(copies, (a for a in arrays if isinstance(a, np.ndarray)), strict=True):
        assert (before == now).all()
    assert len(state.freespace.scene.obstacles) == 20


def test_only_a_smaller_tolerance_builds_anew() -> None:
    far = Rectangle(7, 7, 5, 5, name="far")  # it sticks out, and sets the tolerance of the scene
    state = built(replace(HALL, obstacles=(Rectangle(1, 1, 1, 1, name="near"),)))
    wide = added(state, far)
    assert not wide.rebuilt
    assert wide.freespace.scene.tol == 1.5 * state.freespace.scene.tol
    assert not removed(wide, "near").rebuilt
    narrow = removed(wide, "far")
    assert narrow.rebuilt
    check_equal(narrow, state)


def test_a_larger_tolerance_that_closes_a_passage_is_noticed() -> None:
    walls = (Rectangle(0, 3, 4, 2), Rectangle(4 + 1e-11, 3, 4, 2))
    state = built(replace(HALL, obstacles=walls))
    assert state.freespace.parts == 1
    far = added(state, Rectangle(20, 20, 1, 1))
    assert far.freespace.parts == 2
    check_equal(far, anew(far))


def test_names_are_checked_and_given() -> None:
    state = built(replace(HALL, obstacles=(Rectangle(2, 2, 1, 1, name="box"),)))
    with pytest.raises(SceneError, match="named box"):
        added(state, Rectangle(5, 5, 1, 1, name="box"))
    with pytest.raises(SceneError, match="no obstacle crate"):
        removed(state, "crate")
    assert added(state, Rectangle(5, 5, 1, 1)).freespace.scene.obstacles[-1].name == "O2"


def test_obstacles_that_cross_themselves_are_refused() -> None:
    with pytest.raises(SceneError, match="obstacle bow is not a simple polygon"):
        added(built(HALL), Polygon([(1, 1), (3, 3), (3, 1), (1, 3)], "bow"))


def test_tangents_of_something_else_are_refused() -> None:
    state = built(replace(HALL, obstacles=(Rectangle(2, 2, 1, 1, name="box"),)))
    others: list[VisibilityGraph] = [
        visibility_graph(state.freespace, points=[(1, 1)]),
        visibility_graph(state.freespace, "all", points=[(7, 7)]),
        visibility_graph(FreeSpace(HALL)),
    ]
    for other in others:
        with pytest.raises(ValueError, match="tangent graph"):
            with_obstacle(state.freespace, other, Rectangle(5, 5, 1, 1))
        with pytest.raises(ValueError, match="tangent graph"):
            without_obstacle(state.freespace, other, "box")


def test_a_region_stays_valid_where_passages_are_too_narrow() -> None:
    a, b = math.pi / 6, 2 * math.pi / 3
    bars = [
        Rectangle(4.980973816017714, 5.338622510291822, 0.3, 0.3, 0.5235987755982989),
        Rectangle(4.571166194882383, 5.448430131427154, 0.3, 0.3, b),
        Rectangle(4.20155095261175, 4.888622510291823, 0.3, 0.3, a),
        Rectangle(4.511599047328216, 4.331507268021159, 0.15, 0.3, a),
        Rectangle(4.311358573747051, 5.298430131427153, 0.3, 0.3, b),
        Rectangle(4.611358573747084, 4.77881488915649, 0.3, 0.3, a),
    ]
    beside = [
        (4.014055434216757, 6.445901637830583),
        (4.31716432554131, 6.620901637830583),
        (3.9671643255413107, 7.22711942047969),
        (3.664055434216757, 7.05211942047969),
    ]
    square = [
        (5.0640554342167565, 4.627248289883262),
        (5.670273216865864, 4.977248289883262),
        (5.320273216865864, 5.583466072532369),
        (4.714055434216757, 5.233466072532369),
    ]
    state = built(Scene((0, 0, 10, 10), [*bars, Polygon(beside, "P"), Polygon(square)]))
    assert shapely.is_valid(state.freespace.region)
    assert shapely.is_valid(removed(state, "P").freespace.region)


def test_thin_lines_are_as_thick_after_a_change_as_in_a_fresh_map() -> None:
    fence = Line([(1, 4), (4, 4), (4, 7)], 1e-14, "fence")
    pole = Circle((6, 6), 1e-14, "pole")
    state = built(Scene((0, 0, 8, 8), [fence, Rectangle(2, 1, 1, 1)]))
    for step in (pole, Rectangle(4, 5, 1, 1, 0.0, "touching"), Polygon([(20, 0), (21, 0), (20, 1)], "far")):
        state = added(state, step)
        check_equal(state, anew(state))
        fresh, ours = (s.freespace.mesh.vertices for s in (anew(state), state))
        assert np.abs(np.sort(fresh, axis=0) - np.sort(ours, axis=0)).max() < state.freespace.scene.tol / 8
    for name in ("far", "touching", "pole"):
        state = removed(state, name)
        check_equal(state, anew(state))


@pytest.mark.parametrize("thing", [None, "A", Robot("A", (1, 1), (2, 2))])
def test_what_is_no_obstacle_is_refused(thing: Obstacle) -> None:
    with pytest.raises(SceneError, match="an obstacle is a Polygon, Rectangle, Circle or Line"):
        added(built(HALL), thing)


@pytest.mark.parametrize("thing", [Circle((1e308, 0), 1e308), Line([(0, 1e155), (1e155, 0)], 1), Circle((0, 0), 1e-80)])
def test_numbers_beyond_computing_are_refused(thing: Obstacle) -> None:
    with pytest.raises(SceneError, match="nothing can be computed"):
        added(built(HALL), thing)
