"""Free spaces hold the places that are free, exactly, and say which of them hang together."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest
import shapely
from hypothesis import given, settings
from hypothesis import strategies as st

from naive import ExactRegion
from sound import distance
from strategies import scenes
from taut.errors import GoalBlocked, NoPath, SceneError, StartBlocked
from taut.freespace import FreeSpace, without_discs
from taut.scene import Circle, FloatArray, Line, Obstacle, Point, Polygon, Rectangle, Robot, Scene
from zoo import POLYGONS_ONLY, ZOO, Entry, free_region_exact

HALL = Scene((0, 0, 8, 8))
BLOCK = Polygon([(2, 2), (6, 2), (6, 6), (2, 6)])


def spaces(scene: Scene) -> list[FreeSpace]:
    return [FreeSpace(scene, growth) for growth in sorted({scene.growth(r) for r in scene.robots} | {scene.clearance})]


def samples(scene: Scene, count: int, seed: int = 0) -> FloatArray:
    """Points in and about the workspace, some of them on its corners and on those of obstacles."""
    corners = np.concatenate([np.array(scene.workspace), *(o.core for o in scene.obstacles)])
    low, high = np.array(scene.workspace).min(axis=0), np.array(scene.workspace).max(axis=0)
    size = high - low
    return np.concatenate([np.random.default_rng(seed).uniform(low - size / 8, high + size / 8, (count, 2)), corners])


def room(scene: Scene, point: tuple[float, float]) -> float:
    """How far a point is from the nearest obstacle and the wall, negative outside the workspace."""
    wall, here = shapely.Polygon(scene.workspace), shapely.Point(point)
    to_wall = wall.exterior.distance(here) * (1 if wall.covers(here) else -1)
    return min([float(to_wall), *(distance(point, o) for o in scene.obstacles)])


def check_places(space: FreeSpace, points: FloatArray) -> None:
    """Free means room for the disc; not free means less room than the disc and the excess at rounded corners need."""
    scene, tol = space.scene, space.scene.tol
    excess = space.arc_error * (space.growth + max((o.own_radius for o in scene.obstacles), default=0.0))
    for point, free in zip(points.tolist(), space.contains(points).tolist(), strict=True):
        has = room(scene, tuple(point))
        if free:
            assert has >= space.growth - tol
        else:
            assert has <= space.growth + excess + tol


@pytest.mark.parametrize("entry", ZOO, ids=str)
def test_zoo_places_are_free_where_a_disc_has_room(entry: Entry) -> None:
    for space in spaces(entry.scene):
        check_places(space, samples(entry.scene, 150))


@settings(max_examples=60, deadline=None)
@given(scenes(max_radius=0.5), st.sampled_from([0.0, 0.25, 0.5]))
def test_generated_places_are_free_where_a_disc_has_room(scene: Scene, growth: float) -> None:
    check_places(FreeSpace(scene, growth), samples(scene, 60))


@pytest.mark.parametrize("entry", POLYGONS_ONLY, ids=str)
def test_area_and_parts_of_plain_polygons(entry: Entry) -> None:
    expected = free_region_exact(entry.scene)
    space = FreeSpace(entry.scene)
    assert space.area == pytest.approx(expected.area, rel=1e-12)
    assert space.parts == len(shapely.get_parts(expected))


@pytest.mark.parametrize("width", [0.0, 2**-51, 2**-44])
def test_a_seam_but_for_rounding_is_a_seam(width: float) -> None:
    """Squares nearer to each other than the tolerance touch: nobody passes, and nobody stands between them."""
    halves = Polygon([(2, 2), (4, 2), (4, 6), (2, 6)]), Polygon([(4 + width, 2), (6, 2), (6, 6), (4 + width, 6)])
    space = FreeSpace(replace(HALL, obstacles=halves))
    assert space.parts == 1
    assert not space.contains([(4, 4)]).any()


@pytest.mark.parametrize("entry", ZOO, ids=str)
def test_the_exact_reference_agrees_who_is_inside(entry: Entry) -> None:
    for space in spaces(entry.scene):
        if space.region.is_empty or len(shapely.get_coordinates(space.region)) > 400:
            continue
        xy = shapely.get_coordinates(space.region)
        middles = (xy[1:] + xy[:-1]) / 2  # on or within an ulp of the boundary
        points = np.concatenate([middles[:60], samples(entry.scene, 40)])
        exact = ExactRegion(space.region, [tuple(p) for p in points.tolist()])
        for point, free in zip(points.tolist(), space.contains(points).tolist(), strict=True):
            try:
                exact.free(tuple(point))
                inside = True
            except ValueError:
                inside = False
            if free != inside:  # only in a passage that is closed for being narrower than the tolerance
                wide = space.region.buffer(-2 * entry.scene.tol)
                assert inside
                assert wide.distance(shapely.Point(point)) > 4 * entry.scene.tol


def test_area_of_a_grown_block() -> None:
    space = FreeSpace(replace(HALL, obstacles=(BLOCK,)), 0.5)
    exact = 7 * 7 - (4 * 4 + 4 * 4 * 0.5 + math.pi * 0.5**2)
    assert exact - 2e-3 < space.area <= exact
    assert space.parts == 1
    coarse = FreeSpace(replace(HALL, obstacles=(BLOCK,)), 0.5, arc_error=0.2)
    assert coarse.area < space.area


def test_nothing_left_is_an_empty_free_space() -> None:
    for space in (FreeSpace(HALL, 4.5), FreeSpace(replace(HALL, obstacles=(Circle((4, 4), 9),)))):
        assert (space.area, space.parts) == (0.0, 0)
        assert not space.contains([(4, 4)]).any()
        assert space.part_of([(4, 4)]) == [frozenset()]
        assert space.anchor([(4, 4)])[1].tolist() == [-1]


def test_points_are_asked_in_any_number() -> None:
    space = FreeSpace(replace(HALL, obstacles=(BLOCK,)))
    assert space.contains(np.empty((0, 2))).shape == (0,)
    assert space.contains([(2, 2), (4, 4), (8, 8), (8.0, math.nextafter(8, 9))]).tolist() == [True, False, True, False]
    assert space.contains((1, 1)).tolist() == [True]


def test_a_place_that_is_no_place_is_not_free() -> None:
    space = FreeSpace(HALL)
    nowhere = [(math.nan, 1), (1, math.nan), (math.inf, 1), (1, -math.inf), (1e300, 1e300)]
    assert space.contains(nowhere).tolist() == [False] * 5


@pytest.mark.parametrize("growth", [-0.1, math.nan, math.inf])
def test_growths_that_are_none_are_refused(growth: float) -> None:
    with pytest.raises(SceneError, match="growth"):
        FreeSpace(HALL, growth)


@pytest.mark.parametrize("arc_error", [0.0, 1.0, -1.0, math.nan])
def test_arc_errors_that_are_none_are_refused(arc_error: float) -> None:
    with pytest.raises(SceneError, match="arc_error"):
        FreeSpace(HALL, 0.1, arc_error)


def test_of_a_robot_takes_its_own_clearance() -> None:
    scene = replace(HALL, clearance=0.5)
    assert FreeSpace.of(scene, Robot("R", (1, 1), (2, 2), 0.25)).growth == 0.75
    assert FreeSpace.of(scene, Robot("R", (1, 1), (2, 2), 0.25, clearance=0.0)).growth == 0.25


def test_parts_that_only_touch_are_apart() -> None:
    entry = next(e for e in ZOO if e.name == "checkerboard")
    space = FreeSpace(entry.scene)
    assert space.parts == 8
    (inside,), (pinch,) = space.part_of([(0.5, 1.5)]), space.part_of([(2, 2)])
    assert len(inside) == 1
    assert len(pinch) == 2
    assert space.part_of([(0.5, 0.5)]) == [frozenset()]


def test_parts_hang_together_as_the_region_does() -> None:
    entry = next(e for e in ZOO if e.name == "enclosed-goal")
    space = FreeSpace(entry.scene)
    one, other, goal = space.part_of([(1, 1), (7, 7), (4, 4)])
    assert one == other
    assert not one & goal


@pytest.mark.parametrize("entry", ZOO, ids=str)
def test_required_robots_of_the_zoo(entry: Entry) -> None:
    for robot in entry.scene.robots:
        space = FreeSpace.of(entry.scene, robot)
        if entry.reachable.get(robot.name, True):
            space.require(robot)
        else:
            with pytest.raises(NoPath, match=robot.name):
                space.require(robot)


def test_blocked_ends_are_named() -> None:
    scene = replace(HALL, obstacles=(BLOCK,))
    space = FreeSpace(scene, 0.5)
    with pytest.raises(StartBlocked, match=r"robot R: start \(4, 4\)"):
        space.require(Robot("R", (4, 4), (1, 1), 0.5))
    with pytest.raises(GoalBlocked, match=r"robot R: goal \(1\.75, 4\)"):
        space.require(Robot("R", (1, 1), (1.75, 4), 0.5))


@pytest.mark.parametrize("scale", [1.0, 1e-6, 1e6, 3.3])
@pytest.mark.parametrize("angle", [0.0, 0.3, 1.234567])
def test_a_disc_that_touches_may_start(scale: float, angle: float) -> None:
    """Touching is allowed, though coordinates of grown obstacles are rounded."""
    c, s = math.cos(angle), math.sin(angle)

    def turned(x: float, y: float) -> tuple[float, float]:
        return scale * (20 + c * x - s * y), scale * (20 + s * x + c * y)

    block = Polygon([turned(2, 2), turned(6, 2), turned(6, 6), turned(2, 6)])
    walls = [turned(0, 0), turned(8, 0), turned(8, 8), turned(0, 8)]
    places = [turned(4, 1.3), turned(6.7, 3), turned(0.7, 5), turned(2.5, 7.3)]
    robots = [Robot("A", places[0], places[1], 0.7 * scale), Robot("B", places[2], places[3], 0.7 * scale)]
    scene = Scene(walls, [block], robots)
    space = FreeSpace(scene, 0.7 * scale)
    for robot in robots:
        space.require(robot)
    xy, triangles = space.anchor(places)
    assert (triangles >= 0).all()
    assert (np.hypot(*(xy - places).T) <= scene.tol).all()


@settings(max_examples=80, deadline=None)
@given(scenes(max_radius=0.5, max_robots=3))
def test_anchored_places_are_free_and_near(scene: Scene) -> None:
    for robot in scene.robots:
        space = FreeSpace.of(scene, robot)
        points = np.array([robot.start, robot.goal])
        xy, triangles = space.anchor(points)
        assert (triangles >= 0).all()
        assert space.contains(xy).all()
        assert (np.hypot(*(xy - points).T) <= scene.tol).all()
        free = space.contains(points)
        assert (xy[free] == points[free]).all()


def test_anchoring_moves_by_no_more_than_the_tolerance() -> None:
    space = FreeSpace(replace(HALL, obstacles=(BLOCK,)))
    tol = space.scene.tol
    outside = np.array([(8 + 0.5 * tol, 3), (8 + 3 * tol, 3), (4, 4), (2 + 0.5 * tol, 3), (2 + 3 * tol, 3)])
    xy, triangles = space.anchor(outside)
    assert (triangles >= 0).tolist() == [True, False, False, True, False]
    moved = np.hypot(*(xy - outside).T)
    assert (moved <= tol).all()
    assert (moved[[1, 2, 4]] == 0).all()
    assert space.contains(xy).tolist() == [True, False, False, True, False]


@settings(max_examples=60, deadline=None)
@given(scenes(), st.data())
def test_discs_taken_out_are_taken_out(scene: Scene, data: st.DataObject) -> None:
    place = st.tuples(st.floats(-1, 9), st.floats(-1, 9))
    discs = data.draw(st.lists(st.tuples(place, st.floats(0.0, 2.0)), max_size=4))
    centres = np.array([c for c, _ in discs], dtype=np.float64).reshape(-1, 2)
    radii = np.array([r for _, r in discs], dtype=np.float64)
    space = FreeSpace(scene)
    rest = without_discs(space, centres, radii)
    assert rest.growth == space.growth
    assert rest.area <= space.area + 1e-9
    points = np.concatenate([samples(scene, 60), centres])
    before, after = space.contains(points), rest.contains(points)
    if len(discs):
        away = np.hypot(*(points[:, None] - centres[None]).transpose(2, 0, 1))
        inside = (away < radii - 1e-9).any(axis=1)
        beside = ((away > radii * (1 + space.arc_error) + 1e-9) | (radii == 0)).all(axis=1)
    else:
        inside, beside = np.zeros(len(points), bool), np.ones(len(points), bool)
    assert not (after & inside).any()
    bulk = ~np.isin(points[:, 0] + 1j * points[:, 1], samples(scene, 0) @ [1, 1j])  # corners may be rounded away
    assert (after[beside & bulk] == before[beside & bulk]).all()


def test_a_disc_is_taken_out_up_to_its_rim_and_hardly_beyond() -> None:
    space = FreeSpace(HALL)
    rest = without_discs(space, np.array([[4.0, 4.0]]), np.array([2.0]))
    angle = np.linspace(0, 2 * math.pi, 1000)
    around = np.stack([np.cos(angle), np.sin(angle)], axis=1)
    assert not rest.contains(4 + 2 * (1 - 1e-9) * around).any()
    assert rest.contains(4 + 2 * (1 + space.arc_error + 1e-9) * around).all()


def test_a_disc_across_parts_the_hall() -> None:
    corridor = Scene((0, 0, 8, 1))
    space = without_discs(FreeSpace(corridor), np.array([[4.0, 0.5]]), np.array([0.6]))
    assert space.parts == 2
    with pytest.raises(NoPath):
        space.require(Robot("R", (1, 0.5), (7, 0.5)))
    touching = without_discs(FreeSpace(corridor), np.array([[4.0, 0.5]]), np.array([0.0]))
    assert touching.area == FreeSpace(corridor).area


ACROSS = ("line", "bent line", "needle", "band", "spike", "notch")


def hall_halved(kind: str, at: Point, turn: float, thickness: float, corner: Point) -> Scene:
    """A hall of 10 m with a wall from bottom to top, and squares in the way that touch each other but for rounding."""
    x0, y0 = corner
    (bottom, top), c, s = at, math.cos(turn), math.sin(turn)

    def placed(points: list[Point]) -> list[Point]:
        return [(x0 + x, y0 + y) for x, y in points]

    def turned(points: list[Point]) -> list[Point]:
        return placed([(5 + c * x - s * y, 5 + s * x + c * y) for x, y in points])

    lower, upper = (bottom, -1.0), (top, 11.0)
    beside, above = (bottom + thickness, -1.0), (top + thickness, 11.0)
    room = [(0.0, 0.0), (10.0, 0.0), (10.0, 10.0), (0.0, 10.0)]
    wall: list[Obstacle] = []
    match kind:
        case "line":
            wall = [Line(placed([lower, upper]), thickness)]
        case "bent line":
            wall = [Line(placed([lower, (5, 5.5), upper]), thickness)]
        case "needle":
            wall = [Polygon(placed([lower, upper, above]))]
        case "band":
            wall = [Polygon(placed([lower, upper, above, beside]))]
        case "spike":
            wall = [Polygon(placed([lower, upper, beside, (bottom + 1, -1), (bottom + 1, -2), (bottom, -2)]))]
        case _:
            room[1:1] = [(bottom, 0.0), (top, 9.5), (bottom + thickness, 0.0)]
            wall = [Line(placed([(top, 9.5), upper]), thickness)]
    blocks = [
        Polygon(turned([(-1, -1), (0, -1), (0, 0), (-1, 0)])),
        Polygon(turned([(-1.5, 0), (-0.5, 0), (-0.5, 1), (-1.5, 1)])),
        Polygon(turned([(-0.5, 0), (0.7, 0), (0.7, 0.4), (-0.5, 0.4)])),
    ]
    return Scene(placed(room), [*blocks, *wall])


@settings(deadline=None, max_examples=150)
@given(
    st.sampled_from(ACROSS),
    st.tuples(st.floats(3.5, 5.5), st.floats(3.5, 5.5)),
    st.floats(0, 1.5),
    st.floats(-3, 1),
    st.sampled_from([(0.0, 0.0), (500.0, 500.0), (500000.0, 5400000.0)]),
)
def test_no_wall_is_too_thin_to_stop_anybody_whatever_touches_beside_it(
    kind: str, at: Point, turn: float, thin: float, corner: Point
) -> None:
    least = 4 * np.spacing(max(corner) + 10)  # or rounding leaves nothing between the sides
    scene = hall_halved(kind, at, turn, max(10**thin * 2.0**-40 * (max(corner) + 10), least), corner)
    left, right = ((corner[0] + x, corner[1] + 9.9) for x in (0.1, 9.9))
    space = FreeSpace(scene)
    (one,), (other,) = space.part_of([left, right])
    assert one != other
    assert shapely.is_valid(space.region)


def test_a_thin_wall_stays_where_two_squares_touch_but_for_rounding() -> None:
    c, s = math.cos(0.3), math.sin(0.3)

    def turned(*points: Point) -> Polygon:
        return Polygon([(5 + c * x - s * y, 5 + s * x + c * y) for x, y in points])

    squares = [turned((0, 0), (1, 0), (1, 1), (0, 1)), turned((-0.5, 1), (0.5, 1), (0.5, 2), (-0.5, 2))]
    assert FreeSpace(Scene((0, 0, 10, 10), [*squares, Line([(5.1, -1), (5.2, 11)], 1e-13)])).parts == 2


def test_starts_on_a_thin_wall_are_still_free() -> None:
    scene = Scene((0, 0, 10, 10), [Line([(5, 0), (5, 8)], 1e-13)])
    xy, triangles = FreeSpace(scene).anchor([(5, 4), (5, 8)])
    assert (triangles >= 0).all()
    assert np.abs(xy - [(5, 4), (5, 8)]).max() <= scene.tol


def test_places_far_beyond_the_map_are_not_free() -> None:
    big = 1e308
    assert not FreeSpace(HALL).contains([(big, big), (-big, big), (big, 4), (4, -big), (math.inf, 4), (1e30, 4)]).any()


def test_the_region_of_a_gap_too_narrow_to_pass_is_closed_as_the_free_space_is() -> None:
    tol = HALL.tol
    space = FreeSpace(Scene((0, 0, 8, 8), [Rectangle(2, 2, 2, 2), Rectangle(4 + tol / 2, 2, 2, 2)]))
    inside = (4 + tol / 4, 3)
    assert not space.contains([inside])[0]
    assert not space.region.covers(shapely.Point(inside))
    assert space.area == pytest.approx(64 - 8 - tol, abs=1e-14)
    assert space.mesh.part_count == space.parts == 1


def test_the_region_is_valid_where_only_an_edge_is_closed() -> None:
    tips = [Polygon([(3, 0), (5, 0), (4, 4)]), Polygon([(3, 8), (4, 4 + HALL.tol / 2), (5, 8)])]
    space = FreeSpace(Scene((0, 0, 8, 8), tips))
    assert space.parts == 2
    assert shapely.is_valid(space.region)
    assert space.area == pytest.approx(64 - 8, abs=1e-9)


@pytest.mark.parametrize(
    "points",
    [np.zeros((2, 3)), np.zeros((1, 2, 2)), 1.0, None, "ab", [(1,)], [(1, 2), (3,)], [(1j, 1)], [(10**400, 1)]],
)
def test_what_is_no_list_of_points_is_refused(points: object) -> None:
    space = FreeSpace(HALL)
    for ask in (space.contains, space.anchor, space.part_of):
        with pytest.raises(ValueError, match="points must be points"):
            ask(points)  # type: ignore[arg-type]


def test_one_point_and_no_point_are_points() -> None:
    assert FreeSpace(HALL).contains((1, 1)).tolist() == [True]
    assert FreeSpace(HALL).contains([]).tolist() == []


@pytest.mark.parametrize("obstacle", [
    Circle((1e308, 0), 1e308), Line([(0, 1e155), (1e155, 0)], 1), Circle((1e200, 0), 1), Rectangle(0, 0, 1, 1e-80, 0.5),
])  # fmt: skip
def test_numbers_beyond_computing_are_refused(obstacle: Obstacle) -> None:
    with pytest.raises(SceneError, match="nothing can be computed"):
        FreeSpace(Scene((0, 0, 8, 8), [obstacle]))


@pytest.mark.parametrize("growth", [1e300, 1e-80, math.nan, "1", None])
def test_growth_that_is_no_length_is_refused(growth: float) -> None:
    with pytest.raises(SceneError, match="growth must be a number"):
        FreeSpace(HALL, growth)


def test_what_is_no_scene_or_no_share_is_refused() -> None:
    with pytest.raises(SceneError, match="made from a Scene"):
        FreeSpace(None)  # type: ignore[arg-type]
    with pytest.raises(SceneError, match="arc_error must lie"):
        FreeSpace(HALL, 0.0, "x")  # type: ignore[arg-type]
