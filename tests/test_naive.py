"""The references are right where the answer is known; the zoo and the strategies are what they say."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Mapping, Sequence
from typing import Any

import numpy as np
import pytest
import shapely
from hypothesis import HealthCheck, assume, given, settings
from hypothesis import strategies as st

from naive import Pair, Vertex, naive_corners, naive_route, naive_shortest, naive_visibility, naive_wedges
from strategies import grid_scenes, legs, scenes, team_scenes, trajectories
from taut.motion import Trajectory
from taut.scene import FloatArray, Point, Polygon, Scene
from zoo import POLYGONS_ONLY, ZOO, Entry, free_region_exact, transformed

BY_NAME = {entry.name: entry for entry in ZOO}
FEW = settings(deadline=None, max_examples=60, suppress_health_check=[HealthCheck.too_slow])


def region_of(name: str) -> Any:
    return free_region_exact(BY_NAME[name].scene)


def ends(scene: Scene) -> list[Point]:
    return [point for robot in scene.robots for point in (robot.start, robot.goal)]


def by_place(pairs: Iterable[Pair]) -> set[frozenset[Point]]:
    return {frozenset((v[0], v[1]) for v in pair) for pair in pairs}


def places(vertices: Iterable[Vertex]) -> set[Point]:
    return {(v[0], v[1]) for v in vertices}


def square_room(*holes: Sequence[Point]) -> Any:
    return shapely.Polygon([(0, 0), (8, 0), (8, 8), (0, 8)], holes)


# ---- seeing


def test_empty_square_has_its_sides_and_diagonals() -> None:
    room = square_room()
    assert len(naive_visibility(room)) == 6
    assert naive_visibility(room, edges="tangent") == set()
    assert set(naive_wedges(room).values()) == {"convex"}


def test_a_square_obstacle_gives_its_sides_only_as_tangents() -> None:
    room = square_room([(2, 2), (2, 6), (6, 6), (6, 2)])
    sides = {frozenset(p) for p in ([(2, 2), (6, 2)], [(6, 2), (6, 6)], [(6, 6), (2, 6)], [(2, 6), (2, 2)])}
    assert by_place(naive_visibility(room, edges="tangent")) == sides
    assert by_place(naive_visibility(room, vertices=naive_corners(room))) == sides
    # All eight vertices: 4 sides, 4 walls, and each wall corner sees three corners of the square.
    assert len(naive_visibility(room)) == 4 + 4 + 4 * 3


def test_two_squares_have_four_common_tangents() -> None:
    room = square_room([(1, 1), (1, 2), (2, 2), (2, 1)], [(5, 3), (5, 4), (6, 4), (6, 3)])
    common = {frozenset(p) for p in ([(2, 1), (6, 3)], [(1, 2), (5, 4)], [(2, 1), (5, 4)], [(1, 2), (6, 3)])}
    tangents = by_place(naive_visibility(room, edges="tangent"))
    assert len(tangents) == 8 + 4
    assert common <= tangents


def test_points_see_along_edges_and_past_corners() -> None:
    room = square_room([(2, 2), (2, 6), (6, 6), (6, 2)])
    a, b = (0.0, 2.0), (8.0, 2.0)
    seen = by_place(naive_visibility(room, [a, b], vertices=naive_corners(room)))
    assert {frozenset((a, b)), frozenset((a, (6.0, 2.0))), frozenset((b, (2.0, 2.0)))} <= seen
    tangents = by_place(naive_visibility(room, [a, b], "tangent"))
    assert frozenset((a, b)) not in tangents
    assert {frozenset((a, (2.0, 2.0))), frozenset((a, (2.0, 6.0))), frozenset((b, (6.0, 2.0)))} <= tangents


def test_a_vertex_is_named_by_where_its_wedge_begins() -> None:
    room = square_room([(2, 2), (2, 6), (6, 6), (6, 2)])
    # Free space is left of the edge from (2, 2) to (2, 6) seen from the vertex, and left of (0, 0) to (8, 0).
    assert naive_wedges(room)[2.0, 2.0, (2.0, 6.0)] == "reflex"
    assert naive_wedges(room)[0.0, 0.0, (8.0, 0.0)] == "convex"


def test_direction_and_first_point_of_rings_do_not_matter() -> None:
    hole = [(2.0, 2.0), (2.0, 6.0), (6.0, 6.0), (6.0, 2.0)]
    reversed_room = shapely.Polygon([(8, 8), (8, 0), (0, 0), (0, 8)], [hole[::-1]])
    assert naive_visibility(square_room(hole)) == naive_visibility(reversed_room)


def test_straight_vertices_are_dropped_unless_something_touches_them() -> None:
    room = square_room([(2, 2), (2, 6), (4, 6), (6, 6), (6, 2)])
    assert (4.0, 6.0) not in places(naive_wedges(room))
    touched = square_room([(2, 2), (2, 6), (4, 6), (6, 6), (6, 2)], [(4, 6), (3, 7), (5, 7)])
    assert [k for v, k in naive_wedges(touched).items() if v[:2] == (4.0, 6.0)] == ["convex", "convex"]


def test_a_ring_may_touch_the_middle_of_an_edge() -> None:
    # The touching point is no vertex of the outer ring, and separates all the same.
    room = square_room([(4, 0), (2, 3), (6, 3)])
    assert naive_wedges(room)[4.0, 0.0, (8.0, 0.0)] == "convex"
    assert naive_shortest(room, (2, 0), (6, 0)) == pytest.approx(2 * 3 + 4, abs=1e-15)
    assert frozenset(((2.0, 0.0), (6.0, 0.0))) not in by_place(naive_visibility(room, [(2, 0), (6, 0)]))


@pytest.mark.parametrize(
    ("name", "kinds"),
    [
        ("touching-corners", ["convex", "convex"]),
        ("three-at-a-point", ["convex", "convex", "convex"]),
        ("reflex-pinch", ["convex", "reflex"]),
        ("straight-pinch", ["convex", "straight"]),
        ("ell-touched", ["convex", "convex"]),
        ("start-on-pinch", ["convex", "convex"]),
    ],
)
def test_a_pinch_point_has_one_vertex_for_each_wedge(name: str, kinds: list[str]) -> None:
    assert sorted(k for v, k in naive_wedges(region_of(name)).items() if v[:2] == (4.0, 4.0)) == kinds


def test_wedges_of_a_pinch_point_see_their_own_side_only() -> None:
    room = region_of("reflex-pinch")
    above, below, pinch = (4.0, 5.0), (4.0, 3.0), (4.0, 4.0)
    pairs = naive_visibility(room, [above, below])
    upper = {v for pair in pairs for v in pair if v[:2] == pinch and (*above, None) in pair}
    lower = {v for pair in pairs for v in pair if v[:2] == pinch and (*below, None) in pair}
    assert upper == {(4.0, 4.0, (7.0, 3.0))}
    assert lower == {(4.0, 4.0, (1.0, 2.0))}
    assert frozenset((above, below)) not in by_place(pairs)


def test_a_straight_wedge_is_slid_along_and_parts_tangents() -> None:
    room = region_of("straight-pinch")
    left, right = (1.0, 4.0), (7.0, 4.0)
    assert frozenset((left, right)) in by_place(naive_visibility(room, [left, right]))
    tangents = by_place(naive_visibility(room, [left, right], "tangent"))
    assert frozenset((left, right)) not in tangents
    assert {frozenset(((2.0, 4.0), (4.0, 4.0))), frozenset(((4.0, 4.0), (6.0, 4.0)))} <= tangents
    assert frozenset(((4.0, 4.0), (4.0, 7.0))) not in by_place(naive_visibility(room, [(4, 7)], "tangent"))


def test_a_point_on_an_edge_sees_its_own_side_only() -> None:
    thin = square_room([(2, 2), (2, 6), (3, 6), (3, 2)])
    pairs = by_place(naive_visibility(thin, [(2, 4), (1, 4), (7, 4), (2, 5)]))
    assert {frozenset(((2.0, 4.0), (1.0, 4.0))), frozenset(((2.0, 4.0), (2.0, 5.0)))} <= pairs
    assert frozenset(((2.0, 4.0), (7.0, 4.0))) not in pairs


def test_a_point_on_a_pinch_sees_both_sides() -> None:
    pairs = by_place(naive_visibility(region_of("start-on-pinch"), [(4, 4), (2, 7), (6, 1)]))
    assert {frozenset(((4.0, 4.0), (2.0, 7.0))), frozenset(((4.0, 4.0), (6.0, 1.0)))} <= pairs


def test_one_rounding_decides() -> None:
    def seen(y: float) -> bool:
        room = square_room([(3, y), (3, 6), (5, 6), (5, y)])
        return frozenset(((1.0, 1.0), (7.0, 1.0))) in by_place(naive_visibility(room, [(1, 1), (7, 1)]))

    assert seen(1.0)
    assert seen(math.nextafter(1.0, 2.0))
    assert not seen(math.nextafter(1.0, 0.0))


@pytest.mark.parametrize(
    ("room", "points", "vertices", "told"),
    [
        (square_room(), [(9, 1)], None, "outside"),
        (square_room([(2, 2), (2, 6), (6, 6), (6, 2)]), [(4, 4)], None, "outside"),
        (square_room(), [], [(1.0, 1.0, (2.0, 2.0))], "no wedge"),
        (shapely.Polygon([(0, 0), (8, 8), (8, 0), (0, 8)]), [], None, "cross"),
        (shapely.MultiPolygon([shapely.box(0, 0, 4, 4), shapely.box(4, 1, 8, 3)]), [], None, "overlap"),
    ],
)
def test_bad_input_is_refused(room: Any, points: list[Point], vertices: list[Vertex] | None, told: str) -> None:
    with pytest.raises(ValueError, match=told):
        naive_visibility(room, points, vertices=vertices)


# ---- shortest paths


@pytest.mark.parametrize(
    ("name", "robot", "length"),
    [
        ("empty", "R1", math.hypot(6, 5)),
        ("one-square", "R1", 2 * math.sqrt(5) + 4),
        ("start-is-goal", "R1", 0.0),
        ("seam", "R1", 2 * math.sqrt(5) + 4),
        ("seam-wall", "R1", math.hypot(3, 2) * 2 + 2),
        ("touching-corners", "R1", 4 + 2 * math.sqrt(2)),
        ("lid-touching-once", "R1", math.sqrt(0.5) + 3 + 1 + math.hypot(2.5, 0.5)),
        ("start-on-edge", "R1", 1 + 4 + 3),
        ("start-on-slanted-edge", "R1", 2 * math.sqrt(5)),
        ("start-on-corner", "R2", 4 * math.sqrt(10)),
        ("straight-pinch", "R1", 6.0),
        ("reflex-pinch", "R2", 2 * math.hypot(2.5, 0.5)),
        ("ell", "R1", 2 * math.hypot(2, 3)),
        ("wall-along-an-edge", "R1", 2 * math.sqrt(10) + 2),
        ("row-of-squares", "R1", 25.5),
        ("one-ulp-gap", "R1", 6.0),
    ],
)
def test_lengths_known_by_hand(name: str, robot: str, length: float) -> None:
    (traveller,) = (r for r in BY_NAME[name].scene.robots if r.name == robot)
    found = naive_shortest(region_of(name), traveller.start, traveller.goal)
    assert found == pytest.approx(length, rel=1e-15, abs=1e-15)


@pytest.mark.parametrize(
    ("name", "lengths", "routes"),
    [
        (
            "thesis-1",
            [15.3445, 17.3043, 17.0388],
            [
                [(2, 1), (3.3, 4.8), (5, 16)],
                [(8.7, 0.3), (7.8, 4), (5, 6), (4.5, 12.6), (5, 16)],
                [(11, 1), (9, 7.5), (4.5, 12.6), (5, 16)],
            ],
        ),
        (
            "thesis-2",
            [15.1336, 17.1757, 12.7351],
            [
                [(3, 1), (4.5, 4), (7.5, 6), (9, 7.5), (10, 10), (12, 12.7)],
                [(3.4, 16), (4.5, 12.6), (9, 7.5), (11, 1)],
                [(8.7, 0.3), (7.8, 4), (5, 6), (2, 8.5), (0.5, 9)],
            ],
        ),
        (
            "thesis-3",
            [11.1830, 11.6248, 11.3098],
            [[(10.6, 4), (1.5, 10.5)], [(9.5, 11.44), (1, 3.51)], [(6.2, 1.38), (11.65, 11.29)]],
        ),
    ],
)
def test_lengths_and_bends_of_the_thesis(name: str, lengths: list[float], routes: list[list[Point]]) -> None:
    room = region_of(name)
    found = [naive_route(room, robot.start, robot.goal) for robot in BY_NAME[name].scene.robots]
    assert [route[0] for route in found if route] == pytest.approx(lengths, abs=5e-5)
    assert [route[1] for route in found if route] == routes


@pytest.mark.parametrize(("name", "decimal", "binary"), [("thesis-1", 150, 149), ("thesis-2", 173, 172)])
def test_edge_counts_of_the_thesis(name: str, decimal: int, binary: int) -> None:
    # (2, 8.5), (3.2, 9.5) and (6.2, 12) are in line as decimals; rounded to floats, the corner between hides the pair.
    scene = BY_NAME[name].scene

    def tenths(points: Iterable[Sequence[float]]) -> list[Point]:
        return [(round(10 * x), round(10 * y)) for x, y in points]

    whole = Scene(tenths(scene.workspace), [Polygon(tenths(o.core)) for o in scene.obstacles])
    room, floats = free_region_exact(whole), free_region_exact(scene)
    assert len(naive_visibility(room, tenths(ends(scene)), vertices=naive_corners(room))) == decimal
    assert len(naive_visibility(floats, ends(scene), vertices=naive_corners(floats))) == binary


# ---- the zoo


@pytest.mark.parametrize("entry", POLYGONS_ONLY, ids=str)
def test_reachable_goals_of_point_robots_in_the_zoo(entry: Entry) -> None:
    room = free_region_exact(entry.scene)
    assert shapely.is_valid(room)
    for robot in entry.scene.robots:
        if entry.scene.growth(robot) == 0:
            length = naive_shortest(room, robot.start, robot.goal)
            assert (length is not None) == entry.reachable[robot.name]
            assert length is None or length >= math.dist(robot.start, robot.goal) * (1 - 1e-15)


@pytest.mark.parametrize("entry", ZOO, ids=str)
def test_robots_of_the_zoo_stand_free_and_apart(entry: Entry) -> None:
    scene = entry.scene
    for k, robot in enumerate(scene.robots):
        growth = scene.growth(robot)
        for end in (robot.start, robot.goal):
            assert shapely.Polygon(scene.workspace).intersects(shapely.Point(end))
            assert shapely.Polygon(scene.workspace).exterior.distance(shapely.Point(end)) >= growth
            for obstacle in scene.obstacles:
                if growth > 0 or not obstacle.closed:
                    assert core_of(obstacle).distance(shapely.Point(end)) >= growth + obstacle.own_radius
        for other in scene.robots[:k]:
            assert math.dist(robot.start, other.start) >= scene.separation(robot, other)
            if scene.stays(robot):
                assert math.dist(robot.goal, other.goal) >= scene.separation(robot, other)


@pytest.mark.parametrize("entry", ZOO, ids=str)
def test_reachable_goals_of_disc_robots_in_the_zoo(entry: Entry) -> None:
    # GEOS' buffers err by less than 1e-4 here, so each claim is tried with a growth that makes it harder to hold,
    # except where a claim hangs on an exact touch.
    for robot in entry.scene.robots:
        growth = entry.scene.growth(robot)
        if growth == 0:
            continue
        harder = 1.0002 if entry.reachable[robot.name] else 0.9998
        factor = 2 - harder if entry.name in ("zero-width", "zero-width-clearance", "start-at-the-limit") else harder
        room = grown_region(entry.scene, growth * factor)
        together = any(
            part.intersects(shapely.Point(robot.start)) and part.intersects(shapely.Point(robot.goal)) for part in room
        )
        assert together == entry.reachable[robot.name]


def test_the_zoo_is_small_and_named_uniquely() -> None:
    assert len({entry.name for entry in ZOO}) == len(ZOO)
    assert max(sum(len(o.core) for o in entry.scene.obstacles) for entry in ZOO) <= 150
    assert all(set(entry.reachable) == {r.name for r in entry.scene.robots} for entry in ZOO)


def core_of(obstacle: Any) -> Any:
    if obstacle.closed:
        return shapely.Polygon(obstacle.core)
    return shapely.Point(obstacle.core[0]) if len(obstacle.core) == 1 else shapely.LineString(obstacle.core)


def grown_region(scene: Scene, growth: float) -> list[Any]:
    grown = [core_of(o).buffer(growth + o.own_radius, quad_segs=64) for o in scene.obstacles]
    room = shapely.Polygon(scene.workspace).buffer(-growth, quad_segs=64).difference(shapely.union_all(grown))
    return list(getattr(room, "geoms", [room]))


# ---- what must hold for any scene


def on_half_grid(room: Any) -> bool:
    doubled = 2 * shapely.get_coordinates(room)
    return not room.is_empty and bool((doubled == np.round(doubled)).all())


@FEW
@given(grid_scenes(max_robots=2))
def test_tangents_are_among_all_and_give_the_same_lengths(scene: Scene) -> None:
    room = free_region_exact(scene)
    assume(not room.is_empty)
    points = ends(scene)
    everything = naive_visibility(room, points)
    tangents = naive_visibility(room, points, "tangent")
    assert tangents <= everything
    for robot in scene.robots:
        expected = naive_shortest(room, robot.start, robot.goal)
        found = dijkstra(tangents, (*robot.start, None), (*robot.goal, None))
        assert (found is None) == (expected is None)
        assert found is None or found == pytest.approx(expected, rel=1e-12, abs=1e-12)


def dijkstra(pairs: set[Pair], start: Vertex, goal: Vertex) -> float | None:
    """Search among pairs by plain relaxation; free points of others are not passed through."""
    length = {start: 0.0}
    usable = [tuple(p) for p in pairs if all(v[2] is not None or v in (start, goal) for v in p)]
    for _ in range(len(usable) + 1):
        changed = False
        for pair in usable:
            for u, v in (pair, pair[::-1]):
                if u in length and length[u] + math.dist(u[:2], v[:2]) < length.get(v, math.inf):
                    length[v] = length[u] + math.dist(u[:2], v[:2])
                    changed = True
        if not changed:
            break
    return length.get(goal)


@FEW
@given(grid_scenes(max_robots=1))
def test_allowed_segments_are_covered_and_covered_ones_without_a_touch_are_allowed(scene: Scene) -> None:
    room = free_region_exact(scene)
    assume(on_half_grid(room))
    wedges = naive_wedges(room)
    here = sorted(places(wedges))
    seen = by_place(naive_visibility(room))
    for k, p in enumerate(here):
        for q in here[:k]:
            segment = shapely.LineString([p, q])
            if frozenset((p, q)) in seen:
                assert room.covers(segment)
            elif room.covers(segment):
                assert any(segment.distance(shapely.Point(v)) == 0 for v in here if v not in (p, q))


@FEW
@given(grid_scenes(max_robots=2))
def test_paths_are_limits_of_paths_that_keep_away(scene: Scene) -> None:
    # Shrinking the region shuts pinch points and seams for good and changes nothing else by much.
    room = free_region_exact(scene)
    inside = [
        r for r in scene.robots if all(room.boundary.distance(shapely.Point(p)) > 0.01 for p in (r.start, r.goal))
    ]
    assume(inside)
    shrunk = room.buffer(-1e-5, join_style="mitre", mitre_limit=1e3)
    for robot in inside:
        length, kept = (naive_shortest(r, robot.start, robot.goal) for r in (room, shrunk))
        assert (length is None) == (kept is None)
        if length is not None and kept is not None:
            assert length <= kept * (1 + 1e-12)
            assert kept == pytest.approx(length, abs=0.05)


TURNS: Mapping[str, Callable[[float, float], Point]] = {
    "quarter turn": lambda x, y: (-y, x),
    "mirror": lambda x, y: (-x, y),
    "shift": lambda x, y: (x + 1000.0, y - 3.0),
    "scale": lambda x, y: (x * 2.0**-30, y * 2.0**-30),
}


@pytest.mark.parametrize("name", TURNS)
@FEW
@given(scene=grid_scenes(max_obstacles=3))
def test_seeing_does_not_depend_on_the_frame(name: str, scene: Scene) -> None:
    room, move = free_region_exact(scene), TURNS[name]
    # Cuts of slanted edges are rounded anew in another frame, so only exact ones can be compared.
    assume(on_half_grid(room))
    moved = shapely.transform(room, lambda c: np.array([move(x, y) for x, y in c]))
    pairs = by_place(naive_visibility(room, ends(scene)))
    assert by_place(naive_visibility(moved, [move(*p) for p in ends(scene)])) == {
        frozenset(move(*p) for p in pair) for pair in pairs
    }


# ---- the strategies


@FEW
@given(scenes(max_radius=0.5))
def test_drawn_robots_are_inside_the_grown_region(scene: Scene) -> None:
    for robot in scene.robots:
        growth = scene.growth(robot)
        for end in (robot.start, robot.goal):
            here = shapely.Point(end)
            assert shapely.Polygon(scene.workspace).intersects(here)
            assert all(core_of(o).distance(here) >= growth + o.own_radius for o in scene.obstacles)


@FEW
@given(team_scenes())
def test_drawn_teams_stand_apart(scene: Scene) -> None:
    assert len(scene.robots) >= 2
    for k, robot in enumerate(scene.robots):
        assert robot.radius > 0
        for other in scene.robots[:k]:
            assert math.dist(robot.start, other.start) >= scene.separation(robot, other)
            assert math.dist(robot.goal, other.goal) >= scene.separation(robot, other)


@FEW
@given(legs())
def test_drawn_legs_take_time_and_stay_in_bounds(leg: FloatArray) -> None:
    assert leg.shape == (2, 3)
    assert 0 < leg[1, 0] - leg[0, 0] <= 10 + 1e-12
    assert np.abs(leg[:, 1:]).max() <= 10


@FEW
@given(trajectories(speed=2.0))
def test_drawn_trajectories_keep_the_speed_given(trajectory: Trajectory) -> None:
    moved = np.hypot(*np.diff(trajectory.points, axis=0).T)
    lasting = np.diff(trajectory.times)
    assert np.all((moved == 0) | (np.abs(moved - 2.0 * lasting) <= 1e-12 * (1 + trajectory.times[1:])))


def test_touching_scenes_are_drawn() -> None:
    # Without pinch points among the drawn scenes the comparison with the reference would prove little.
    kinds: list[bool] = []

    @settings(deadline=None, max_examples=100, database=None, derandomize=True)
    @given(st.shared(grid_scenes()))
    def collect(scene: Scene) -> None:
        here = [v[:2] for v in naive_wedges(free_region_exact(scene))]
        kinds.append(len(set(here)) < len(here))

    collect()
    assert sum(kinds) >= 5


def test_transformed_scenes_scale_everything_but_speed() -> None:
    scene = BY_NAME["zero-width-clearance"].scene
    far = transformed(scene, 2.0, 100.0)
    assert far.workspace[2] == (116.0, 116.0)
    assert far.growth(far.robots[0]) == 2 * scene.growth(scene.robots[0])
    assert far.gap == 2 * scene.gap
    assert far.robots[0].speed == scene.robots[0].speed
