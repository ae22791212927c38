"""Growth keeps every promise of distance, on awkward shapes and at every scale."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest
import shapely
from hypothesis import assume, given, settings
from hypothesis import strategies as st

from taut.errors import SceneError, TautError
from taut.geometry import overlay
from taut.geometry.growth import free_region, grown
from taut.scene import Circle, FloatArray, Line, Obstacle, Polygon, Rectangle, Scene

SQUARE = ((0.0, 0.0), (10.0, 0.0), (10.0, 10.0), (0.0, 10.0))
L_ROOM = ((0.0, 0.0), (10.0, 0.0), (10.0, 4.0), (4.0, 4.0), (4.0, 10.0), (0.0, 10.0))
COMB = ((0, 0), (10, 0), (10, 9), (8, 9), (8, 2), (6, 2), (6, 9), (4, 9), (4, 2), (2, 2), (2, 9), (0, 9))
U_SHAPE = ((2, 2), (8, 2), (8, 8), (6, 8), (6, 4), (4, 4), (4, 8), (2, 8))
COURTYARD = ((2, 2), (8, 2), (8, 8), (5.2, 8), (5.2, 7), (7, 7), (7, 3), (3, 3), (3, 7), (4.8, 7), (4.8, 8), (2, 8))
SPIRAL = ((1, 1), (9, 1), (9, 9), (3, 9), (3, 5), (6, 5), (6, 6), (4, 6), (4, 8), (8, 8), (8, 2), (1, 2))

AWKWARD: dict[str, Scene] = {
    "empty": Scene(SQUARE),
    "clockwise room": Scene(SQUARE[::-1]),
    "L room": Scene(L_ROOM),
    "comb room": Scene(COMB),
    "U-shaped room": Scene(U_SHAPE),
    "room that pinches off": Scene(
        ((0, 0), (4, 0), (4, 1.6), (6, 1.6), (6, 0), (10, 0), (10, 4), (6, 4), (6, 2.2), (4, 4))
    ),
    "touching sides": Scene(SQUARE, [Rectangle(2, 2, 2, 2), Rectangle(4, 2, 2, 3)]),
    "touching corners": Scene(SQUARE, [Rectangle(2, 2, 2, 2), Rectangle(4, 4, 2, 2)]),
    "same twice": Scene(SQUARE, [Rectangle(2, 2, 2, 2), Rectangle(2, 2, 2, 2)]),
    "overlapping": Scene(SQUARE, [Rectangle(2, 2, 3, 2), Rectangle(4, 3, 3, 3), Circle((5, 5), 1)]),
    "nested": Scene(SQUARE, [Rectangle(2, 2, 6, 6), Rectangle(4, 4, 1, 1)]),
    "corridor of no width once grown": Scene(SQUARE, [Rectangle(1, 2, 3, 5), Rectangle(5, 2, 3, 5)]),
    "sticking out": Scene(SQUARE, [Rectangle(-1, 4, 3, 1), Circle((10, 10), 2), Line([(5, -3), (5, 3)], 0.4)]),
    "outside": Scene(SQUARE, [Rectangle(11, 1, 2, 2)]),
    "on the wall": Scene(SQUARE, [Rectangle(0, 3, 2, 2), Rectangle(4, 0, 1, 10)]),
    "bay": Scene(SQUARE, [Polygon(U_SHAPE)]),
    "bay clockwise": Scene(SQUARE, [Polygon(U_SHAPE[::-1])]),
    "courtyard": Scene(SQUARE, [Polygon(COURTYARD), Circle((5, 5), 0.3)]),
    "spiral": Scene(SQUARE, [Polygon(SPIRAL)]),
    "doubled and straight corners": Scene(
        SQUARE, [Polygon([(2, 2), (2, 2), (4, 2), (6, 2), (6, 2), (6, 5), (6, 6), (2, 6), (2, 4), (2, 2)])]
    ),
    "nearly straight": Scene(SQUARE, [Polygon([(2, 2), (4, 2 - 1e-13), (6, 2), (6, 6), (4, 6 - 1e-9), (2, 6)])]),
    "needle": Scene(SQUARE, [Polygon([(2, 2), (8, 2.0001), (2, 2.0002)])]),
    "zigzag": Scene(SQUARE, [Line([(1, 1), (5, 9), (5.5, 1), (9, 9)], 0.2)]),
    "forth and back": Scene(SQUARE, [Line([(2, 5), (8, 5), (4, 5), (4, 5)], 0.2)]),
    "closed line": Scene(SQUARE, [Line([(2, 2), (8, 2), (8, 8), (2, 8), (2, 2)], 0.2)]),
    "dot of a line": Scene(SQUARE, [Line([(5, 5), (5, 5)], 0.5)]),
    "almost the same corner": Scene(
        SQUARE, [Line([(0, 0), (0, 1e-200), (3, 1)], 0.2), Polygon([(5, 5), (6, 9), (9, 5), (9, 5 - 1e-15)])]
    ),
    "islands": Scene(SQUARE, [Circle((3, 3), 0.5), Circle((7, 3), 1e-3), Rectangle(4, 6, 2, 1, 0.3)]),
}


def scaled(scene: Scene, factor: float) -> Scene:
    def shape(o: Obstacle) -> Obstacle:
        match o:
            case Polygon():
                return Polygon(o.core * factor)
            case Rectangle():
                return Rectangle(o.x * factor, o.y * factor, o.width * factor, o.height * factor, o.angle)
            case Circle():
                return Circle((o.center[0] * factor, o.center[1] * factor), o.radius * factor)
            case Line():
                return Line(o.core * factor, o.width * factor)

    return Scene(np.array(scene.workspace) * factor, [shape(o) for o in scene.obstacles])


def distances(points: FloatArray, core: FloatArray, *, ring: bool, filled: bool) -> tuple[FloatArray, FloatArray]:
    """Distances (k,) of points from a ring, chain or point, 0 inside a filled ring, and from its nearest corner."""
    a = core
    b = np.roll(core, -1, axis=0) if ring else np.concatenate([core[1:], core[-1:]])
    arm = points[:, None] - a
    side = b - a
    square = np.maximum((side**2).sum(-1), 1e-300)
    t = np.clip((arm * side).sum(-1) / square, 0, 1)
    gap = arm - t[..., None] * side
    least = np.hypot(gap[..., 0], gap[..., 1]).min(1)
    if filled:
        inside = shapely.contains_xy(shapely.Polygon(core), points)
        least = np.where(inside, 0.0, least)
    return least, np.hypot(arm[..., 0], arm[..., 1]).min(1)


def excesses(scene: Scene, growth: float, points: FloatArray) -> tuple[FloatArray, FloatArray, FloatArray]:
    """For each obstacle and the wall, (m, k): distance beyond the required one, the required one, to a corner."""
    rows = []
    for o in scene.obstacles:
        d, corner = distances(points, o.core, ring=o.closed, filled=o.closed)
        radius = o.own_radius + growth
        rows.append((d - radius, np.full(len(points), radius), corner))
    wall = np.array(scene.workspace)
    d, corner = distances(points, wall, ring=True, filled=False)
    d = np.where(shapely.intersects_xy(shapely.Polygon(wall), points) | (d < scene.tol), d, -d)
    rows.append((d - growth, np.full(len(points), growth), corner))
    beyond, required, corner = np.array(rows).transpose(1, 0, 2)
    return beyond, required, corner


def boundary_samples(region: Any) -> FloatArray:
    points = [np.zeros((0, 2))]
    for ring in shapely.get_rings(region):
        at = shapely.get_coordinates(ring)
        points += [at[:-1] + f * (at[1:] - at[:-1]) for f in (0.0, 0.29, 0.5, 0.83)]
    return np.concatenate(points)


def check(scene: Scene, growth: float, arc_error: float = 1e-3, **more: Any) -> Any:
    """Check everything that a free region promises; return it."""
    region = free_region(scene, growth, arc_error, **more)
    tol = scene.tol
    error = 1.0 if more.get("corners") == "mitre" else arc_error
    assert region.geom_type in ("Polygon", "MultiPolygon")
    assert region.is_valid
    assert all(p.area > 0 for p in shapely.get_parts(region))

    beyond, required, corner = excesses(scene, growth, boundary_samples(region))
    assert (beyond >= -tol).all(), f"too near by {-beyond.min()}"
    near = beyond <= error * required + tol
    assert near.any(axis=0).all(), "a boundary that belongs to nothing"
    # on the side of exactly one thing: exactly the distance asked for
    lonely = near & (near.sum(axis=0) == 1) & (corner > (1 + error) * required + tol)
    assert (np.abs(beyond[lonely]) <= tol).all()

    low, high = np.min(scene.workspace, axis=0), np.max(scene.workspace, axis=0)
    grid = low + np.random.default_rng(1).uniform(-0.05, 1.05, (1500, 2)) * (high - low)
    beyond, required, _ = excesses(scene, growth, grid)
    inside = shapely.intersects_xy(region, grid)
    assert inside[(beyond > error * required + tol).all(axis=0)].all(), "free places are missing"
    assert not inside[(beyond < -tol).any(axis=0)].any(), "places too near are in it"
    return region


@pytest.mark.parametrize("name", AWKWARD)
@pytest.mark.parametrize("growth", [0.0, 0.05, 0.3, 0.5, 0.95])
def test_awkward_scenes_keep_every_promise(name: str, growth: float) -> None:
    check(AWKWARD[name], growth)


@pytest.mark.parametrize("name", AWKWARD)
@pytest.mark.parametrize("factor", [1e-9, 1e-3, 1e6])
def test_every_scale_keeps_every_promise(name: str, factor: float) -> None:
    check(scaled(AWKWARD[name], factor), 0.3 * factor)


@pytest.mark.parametrize("name", AWKWARD)
def test_mitres_are_capped_at_twice_the_growth(name: str) -> None:
    check(AWKWARD[name], 0.3, corners="mitre")


@pytest.mark.parametrize("name", AWKWARD)
def test_rounded_grid_keeps_every_promise(name: str, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(overlay, "_drawn_from", lambda *_: False)
    check(AWKWARD[name], 0.3)


@pytest.mark.parametrize("name", AWKWARD)
def test_area_lies_between_exact_offsets(name: str) -> None:
    scene, growth, arc_error = AWKWARD[name], 0.3, 1e-3

    def area(factor: float, fine: int) -> float:
        cores = [
            (shapely.Polygon(o.core) if o.closed else shapely.LineString(o.core) if len(o.core) > 1 else
             shapely.Point(o.core[0])).buffer(factor * (o.own_radius + growth), quad_segs=fine)
            for o in scene.obstacles
        ]  # fmt: skip
        wall = shapely.Polygon(scene.workspace).exterior.buffer(factor * growth, quad_segs=fine)
        return float((shapely.Polygon(scene.workspace) - shapely.union_all([wall, *cores])).area)

    exact = free_region(scene, growth, arc_error).area
    assert area(1 + 1.1 * arc_error, 256) - 1e-9 <= exact <= area(1.0, 256) + 2e-4


def stars(scale: float, tight: bool, noise: float = 0.0) -> st.SearchStrategy[Obstacle]:
    def number(low: float, high: float) -> st.SearchStrategy[float]:
        if tight:  # a coarse lattice, where everything meets everything, exactly or nearly
            place = st.integers(math.ceil(low), math.floor(high))
            return st.builds(lambda k, j: (k + j * noise) * scale, place, st.integers(-3, 3))
        return st.floats(low, high).map(lambda v: v * scale)

    point = st.tuples(number(-1, 11), number(-1, 11))
    size = st.sampled_from([0.5 * scale, scale, 1.5 * scale])
    ring = st.lists(point, min_size=3, max_size=7).filter(lambda p: bool(shapely.Polygon(p).is_valid))
    return st.one_of(
        ring.map(Polygon),
        ring.map(lambda p: Polygon(p[::-1])),
        st.builds(Rectangle, number(0, 9), number(0, 9), size, size, st.sampled_from([0.0, 0.0, 0.7])),
        st.builds(Circle, point, size),
        st.builds(Line, st.lists(point, min_size=2, max_size=5), size),
    )


@settings(deadline=None, max_examples=60)
@given(st.data(), st.sampled_from([1e-9, 1.0, 1e6]), st.booleans(), st.sampled_from([0.0, 0.01, 0.25, 0.5, 1.0]))
def test_random_scenes_keep_every_promise(data: st.DataObject, scale: float, tight: bool, growth: float) -> None:
    noise = data.draw(st.sampled_from([0.0, 1e-16, 1e-15, 1e-14, 1e-13, 1e-12, 1e-11, 1e-10]))
    obstacles = data.draw(st.lists(stars(scale, tight, noise), max_size=7))
    walls = data.draw(st.sampled_from([SQUARE, L_ROOM, L_ROOM[::-1], COMB]))
    arc_error = data.draw(st.sampled_from([1e-3, 1e-2, 1e-4]))
    check(Scene(np.array(walls) * scale, obstacles), growth * scale, arc_error)


@settings(deadline=None, max_examples=60)
@given(stars(1.0, False), st.floats(0.0, 3.0), st.sampled_from(["round", "mitre"]))
def test_one_obstacle_grows_as_it_does_in_a_scene(obstacle: Obstacle, growth: float, corners: Any) -> None:
    alone = grown(obstacle, growth, corners=corners)
    assert alone.geom_type == "Polygon"
    assert alone.is_valid
    scene = Scene((-100, -100, 100, 100), [obstacle])
    assert free_region(scene, growth, corners=corners).area == pytest.approx(
        (200 - 2 * growth) ** 2 - alone.area, abs=1e-8
    )


@settings(deadline=None, max_examples=80)
@given(st.floats(0.05, 0.95), st.floats(0.0, 0.01), st.floats(-5.0, 5.0), st.sampled_from([1e-9, 1.0, 1e6]))
def test_positions_beside_an_arc_stay_free(share: float, more: float, turned: float, scale: float) -> None:
    radius = 0.7 * scale
    c, s = math.cos(turned), math.sin(turned)
    rotation = np.array([[c, s], [-s, c]])
    corners = np.array([(0, 0), (-2, 1), (-2, -1)]) @ rotation * scale
    middle = math.pi - math.atan2(1, 2)  # half of the corner's outer arc
    angle = turned + (2 * share - 1) * 0.98 * (middle - math.pi / 2)
    position = radius * (1 + more) * np.array([[math.cos(angle), math.sin(angle)]])
    walls = [(-9 * scale, -9 * scale), (9 * scale, -9 * scale), (9 * scale, 9 * scale), (-9 * scale, 9 * scale)]
    scene = Scene(walls, [Polygon(corners)])
    region = check(scene, radius, 1e-2, keep=position)
    assert region.distance(shapely.Point(position[0])) <= scene.tol / 100
    mitred = check(scene, radius, corners="mitre", keep=position)
    assert mitred.distance(shapely.Point(position[0])) <= scene.tol / 100


@pytest.mark.parametrize(
    "obstacle",
    [Circle((0, 0), 0.5), Line([(0, 0), (-3, 0)], 1.0), Polygon([(0, 0), (-3, 1), (-3, -1)]), Polygon(
        [(0, 0), (-5, 5), (-5, 1), (-4, 0), (-5, -1), (-5, -5)]
    )],
)  # fmt: skip
def test_without_keep_the_same_positions_are_lost(obstacle: Obstacle) -> None:
    radius = obstacle.own_radius + 0.5
    outline = shapely.get_coordinates(grown(obstacle, 0.5, 0.05))
    vertex = outline[outline[:, 0].argmax()]
    position = vertex * radius / np.hypot(*vertex)
    lost = shapely.Point(position)
    scene = Scene((-6, -6, 6, 6), [obstacle])
    assert free_region(scene, 0.5, 0.05).distance(lost) > 0.01
    assert check(scene, 0.5, 0.05, keep=np.array([position, position, (3, 3)])).distance(lost) <= scene.tol / 100


def test_positions_at_corners_of_the_workspace_stay_free() -> None:
    corner = np.array([4.0, 4.0])
    step = 2 * math.acos(1 / 1.05)
    angle = math.pi + math.pi / 2 / math.ceil(math.pi / 2 / step) / 2
    position = corner + 0.5 * np.array([math.cos(angle), math.sin(angle)])
    scene = Scene(L_ROOM)
    assert free_region(scene, 0.5, 0.05).distance(shapely.Point(position)) > 1e-3
    region = check(scene, 0.5, 0.05, keep=position[None])
    assert region.distance(shapely.Point(position)) <= scene.tol / 100


def test_no_growth_keeps_coordinates_bit_for_bit() -> None:
    third = 1 / 3
    workspace = ((-0.1, -third), (16 * third, 0.1), (5.7, 9.3), (0.3, 7.1))
    ring = ((1.1, 1 + third), (2.3, 1.7), (1.9, 2.2), (1.2, 3.1))
    scene = Scene(workspace, [Polygon(ring), Polygon([(3.1, 3.3), (3.7, third + 3), (3.2, 4.1)])])
    region = free_region(scene, 0.0)
    given_points = {*workspace, *ring, (3.1, 3.3), (3.7, third + 3), (3.2, 4.1)}
    assert {tuple(p) for p in shapely.get_coordinates(region).tolist()} == given_points
    assert tuple(map(tuple, shapely.get_coordinates(grown(Polygon(ring), 0.0)).tolist())) == (*ring, ring[0])
    assert free_region(Scene(workspace), 0.0).exterior.coords[:-1] == list(workspace)


def test_no_growth_keeps_corners_of_overlapping_obstacles_bit_for_bit() -> None:
    scene = Scene(
        SQUARE, [Polygon([(1.1, 1.3), (4.7, 2.1), (3.3, 5.9)]), Polygon([(2.9, 1.2), (6.1, 3.7), (2.3, 4.9)])]
    )
    got = {tuple(p) for p in shapely.get_coordinates(free_region(scene, 0.0)).tolist()}
    assert {(1.1, 1.3), (4.7, 2.1), (3.3, 5.9), (6.1, 3.7)} <= got


def test_vertices_are_as_many_as_the_arc_error_asks() -> None:
    square = Polygon([(0, 0), (1, 0), (1, 1), (0, 1)])
    for arc_error in (1e-4, 1e-3, 1e-2):
        n = math.ceil(math.pi / 2 / (2 * math.acos(1 / (1 + arc_error))))
        outline = np.array(grown(square, 0.5, arc_error).exterior.coords[:-1])
        assert len(outline) == 4 * n
        reach = np.hypot(*(outline - np.clip(outline, 0, 1)).T)
        assert reach == pytest.approx(np.full(4 * n, 0.5 / math.cos(math.pi / 4 / n)), rel=1e-14)
    assert len(grown(square, 0.5, corners="mitre").exterior.coords) == 5


def test_straight_corners_leave_no_vertex() -> None:
    plain = grown(Polygon([(0, 0), (3, 1), (2, 4)]), 0.5)
    dotted = grown(Polygon([(0, 0), (1.5, 0.5), (3, 1), (3, 1), (2.5, 2.5), (2, 4), (1, 2)]), 0.5)
    assert len(dotted.exterior.coords) == len(plain.exterior.coords)
    assert dotted.symmetric_difference(plain).area < 1e-12


def test_circles_touch_their_four_tangents_along_the_axes() -> None:
    assert grown(Circle((2, 3), 0.5), 0.25).bounds == pytest.approx((1.25, 2.25, 2.75, 3.75), abs=1e-15)


def test_parts_that_touch_in_a_point_stay_apart() -> None:
    scene = Scene((0, 0, 2, 2), [Rectangle(0, 0, 1, 1), Rectangle(1, 1, 1, 1)])
    assert len(shapely.get_parts(free_region(scene, 0.0))) == 2


def test_seams_between_touching_obstacles_are_closed() -> None:
    halves = Scene(SQUARE, [Rectangle(2, 2, 3, 6), Rectangle(5, 2, 3, 6)])
    whole = Scene(SQUARE, [Rectangle(2, 2, 6, 6)])
    for growth in (0.0, 0.25):
        assert free_region(halves, growth).symmetric_difference(free_region(whole, growth)).area < 1e-12
        assert len(shapely.get_rings(free_region(halves, growth))) == 2


def test_courtyards_are_parts_of_their_own_until_they_close() -> None:
    closed = Scene(SQUARE, [Line([(2, 2), (8, 2), (8, 8), (2, 8), (2, 2)], 0.2)])
    parts = shapely.get_parts(free_region(closed, 0.5))
    assert sorted(shapely.area(parts)) == pytest.approx([4.8**2, 81 - 7.2**2 + (4 - math.pi) * 0.36], rel=1e-3)
    assert len(shapely.get_parts(free_region(closed, 2.95))) == 0


@pytest.mark.parametrize(
    ("scene", "growth"),
    [
        (Scene(SQUARE), 5.0),
        (Scene(SQUARE), 50.0),
        (Scene(L_ROOM), 3.0),
        (Scene(SQUARE, [Rectangle(-1, -1, 12, 12)]), 0.0),
        (Scene(SQUARE, [Rectangle(0, 0, 10, 10)]), 0.0),
        (Scene(SQUARE, [Circle((5, 5), 8)]), 0.1),
        (Scene(SQUARE, [Rectangle(0, 0, 5, 10), Rectangle(5, 0, 5, 10)]), 0.0),
    ],
)
def test_no_free_space_is_an_empty_multipolygon(scene: Scene, growth: float) -> None:
    region = free_region(scene, growth)
    assert region.geom_type == "MultiPolygon"
    assert region.is_empty


def test_a_wall_thinner_than_rounding_still_stands() -> None:
    scene = Scene(SQUARE, [Line([(5, -1), (5, 11)], 1e-20)])
    assert len(shapely.get_parts(free_region(scene, 0.0))) == 2


@pytest.mark.parametrize("off", [0.0, 5e-179, 1e-30, 1e-17, 1e-16, 1e-14])
def test_corners_next_to_a_wall_do_not_open_it(off: float) -> None:
    kite = Polygon([(0, 0), (0, -1), (1, 0), (1, 1), (off, 6), (-1, 0)])
    assert free_region(Scene(COMB, [kite]), 2.0).is_empty
    check(Scene(COMB, [kite]), 0.9)


@pytest.mark.parametrize("off", [0.0, 1e-200, 1e-30, 1e-16, 1e-13])
def test_faces_are_not_lost_where_edges_nearly_coincide(off: float) -> None:
    check(Scene(COMB, [Line([(0, 0), (4, 0), (0, 6), (0, 10), (off, 2)], 0.5)]), 1.0)


# two valid polygons whose edges nearly coincide along x = 0; plain union loses 5 of their 67 square metres
PART = (
    "POLYGON ((1.25 10.334936490538903, 1.2499999999999998 1.6650635094610964, 0.9999999999999998 "
    "1.232050807568877, 0.9999999999999998 1, 0 0, 0 0.7500000000000001, -0.3349364905389035 0.7500000000000002, "
    "-0.9150635094610965 1.0849364905389036, -1.25 1.6650635094610966, 0 2, 0 6, -1.25 5.621530452835007, "
    "-1.2499999999999998 10.334936490538905, 0 10, 1.25 10.334936490538903), (1.25e-17 9, 0 10, 0 9, 1.25e-17 9))"
)
REST = (
    "MULTIPOLYGON (((5 8, 5 1.7320508075688774, 5 1.7320508075688772, 4.732050807568877 1.2679491924311228, "
    "4.267949192431122 1, 4 1, 4 0.9999999999999999, 9 0.9999999999999998, 10 0, 5.251459648558181 0, "
    "5.265236067367413 -0.2849872613784868, 4.938950429552447 -0.894657552451574, 4.3457456367264315 -1.25, 4 0, "
    "2.9599371320776955 -0.6933752452815365, 2.497686968556671 0, 0 0, -0.3349364905389037 -1.2499999999999998, "
    "-0.9150635094610966 -0.9150635094610965, -1.25 -0.3349364905389032, -1.2499999999999998 0.3349364905389036, "
    "-0.9150635094610965 0.9150635094610966, -0.3349364905389033 1.25, 1.2990381056766582 1.25, "
    "1.2679491924311228 1.2679491924311228, 1 1.7320508075688774, 1 2.2465304528350067, 7.816836933956241e-17 "
    "3.7465304528350067, 1e-16 2, -1.25 1.6650635094610966, -1.25 5.621530452835007, -1.25 10, 0 10, 1.25 10, "
    "1.25 8.25, 2 9, 2 3, 2.6666666666666665 2, 4 2, 4 9, 6 9, 5 8), (1.0000000000000002 6.302775637731995, 5e-17 "
    "6, 1 4.5, 1.0000000000000002 6.302775637731995)), ((5.732050807568877 1.0000000000000002, 5.267949192431122 "
    "1.2679491924311228, 5 1.7320508075688774, 6 2, 8 2, 8 9, 9 8, 9 1.7320508075688772, 8.732050807568877 "
    "1.2679491924311228, 8.267949192431123 1, 5.732050807568877 1.0000000000000002)))"
)


def test_faces_lost_by_plain_union_are_noticed() -> None:
    pieces = shapely.from_wkt(np.array([PART, REST], dtype=object))
    true_area = shapely.union_all(pieces.tolist(), grid_size=2.0**-30).area
    assert overlay.united(pieces, 1e-11).area == pytest.approx(true_area, abs=1e-6)
    around = shapely.box(-2, -2, 12, 12)
    assert overlay.remainder(around, pieces, 1e-11).area == pytest.approx(196 - true_area, abs=1e-6)


def test_moved_vertices_are_noticed() -> None:
    sources = np.array([shapely.box(0, 0, 4, 4) - shapely.box(1, 1, 2, 2)])
    good = shapely.Polygon([(0, 0), (4, 0), (4, 4), (0, 4)], [[(1, 1), (2, 1), (2, 1.5), (2, 2), (1, 2)]])
    bad = shapely.Polygon([(0, 0), (4, 0), (4, 4), (0, 4)], [[(1, 1), (2, 1), (2 + 1e-9, 1.5), (2, 2), (1, 2)]])
    assert overlay._drawn_from(good, sources, None, 1e-11)
    assert not overlay._drawn_from(bad, sources, None, 1e-11)


def test_regions_inside_a_piece_are_noticed() -> None:
    room, pieces = shapely.box(0, 0, 4, 4), np.array([shapely.box(1, 1, 3, 3), shapely.box(2, 1, 3, 4)])
    right = overlay.remainder(room, pieces, 1e-11)
    assert overlay._drawn_from(right, pieces, room, 1e-11)
    assert not overlay._reached(right, pieces, 1e-11).any()
    assert not overlay._drawn_from(shapely.union(right, shapely.box(2, 1, 3, 3)), pieces, room, 1e-11)
    assert overlay._reached(room, pieces, 1e-11).tolist() == [True, True]


def test_order_and_direction_of_input_do_not_matter() -> None:
    obstacles: list[Obstacle] = [Polygon(COURTYARD), Circle((5, 5), 0.3), Line([(1, 1), (9, 1)], 0.1)]
    one = free_region(Scene(L_ROOM, obstacles), 0.2)
    other = free_region(Scene(L_ROOM[::-1], [*obstacles[:0:-1], Polygon(COURTYARD[::-1])]), 0.2)
    assert one.symmetric_difference(other).area < 1e-12


@settings(deadline=None, max_examples=40)
@given(stars(1.0, False), st.floats(0.0, 2.0), st.floats(0.0, 1.0))
def test_more_growth_leaves_less(obstacle: Obstacle, growth: float, more: float) -> None:
    assume(more > 0.01)
    scene = Scene(COMB, [obstacle])
    assert free_region(scene, growth + more).difference(free_region(scene, growth * 0.998)).area < 1e-9


@pytest.mark.parametrize(
    "points", [[(1, 1), (3, 3), (3, 1), (1, 3)], [(1, 1), (2, 2), (3, 3)], [(1, 1), (3, 1), (3, 3), (2, 1), (1, 3)]]
)
def test_polygons_that_are_not_simple_are_named(points: list[tuple[float, float]]) -> None:
    with pytest.raises(SceneError, match="obstacle bow is not a simple polygon"):
        free_region(Scene(SQUARE, [Polygon(points, "bow")]), 0.2)
    with pytest.raises(SceneError, match="workspace is not a simple polygon"):
        free_region(Scene(points), 0.2)


def test_arguments_out_of_range_are_refused() -> None:
    scene = Scene(SQUARE)
    for growth in (-1.0, math.nan, math.inf):
        with pytest.raises(TautError, match="growth must be"):
            free_region(scene, growth)
    for arc_error in (0.0, -1e-3, 2.0, math.nan):
        with pytest.raises(TautError, match="arc_error must be"):
            free_region(scene, 0.1, arc_error)
    with pytest.raises(TautError, match="corners must be"):
        free_region(scene, 0.1, corners="bevel")  # type: ignore[arg-type]
    with pytest.raises(TautError, match="keep must be"):
        free_region(scene, 0.1, keep=np.zeros(3))


def test_edges_that_cross_by_less_than_rounding_are_still_united() -> None:
    corners = [
        (
            (6.384847228410128, 6.453623097551715),
            (7.340183717535734, 6.749143304213055),
            (7.044663510874394, 7.704479793338661),
            (6.0893270217487885, 7.408959586677321),
        ),
        (
            (9.182080826645358, 4.178654043497576),
            (10.137417315770964, 4.4741742501589155),
            (9.841897109109624, 5.429510739284522),
            (10.206193184912552, 7.635703924197073),
            (8.29552020666134, 7.044663510874394),
        ),
        (
            (7.931224130858412, 4.8384703259618425),
            (8.886560619984019, 5.133990532623182),
            (8.591040413322679, 6.0893270217487885),
            (7.635703924197073, 5.793806815087448),
        ),
    ]
    scene = Scene((0, 0, 16, 16), [Polygon(points) for points in corners])
    for arc_error in (0.1, 1e-3):
        assert shapely.is_valid(free_region(scene, 0.5, arc_error))
