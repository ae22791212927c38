"""Sensors tell what is there: rays agree with Shapely and closed forms, detections with a dense look around."""

from __future__ import annotations

import math
from dataclasses import replace
from typing import Any

import numpy as np
import pytest
import shapely
from hypothesis import assume, given, settings
from hypothesis import strategies as st
from numpy.typing import NDArray

from strategies import scenes
from taut.contact import contacts, sight_sides
from taut.errors import SceneError
from taut.motion import Plan, Trajectory
from taut.scene import Circle, FloatArray, Line, Polygon, Rectangle, Robot, Scene
from taut.simulation.detector import THESIS_DETECTOR, Detection, Detector, detect
from taut.simulation.sensors import THESIS_FAR_LIDAR, THESIS_NEAR_LIDAR, Lidar, Radio, Scan, linked, scan
from taut.simulation.surroundings import surroundings_of

Flags = NDArray[np.bool_]

FLAT = Scene(
    (0, 0, 16, 12),
    [
        Polygon([(2, 2), (5, 2), (5, 3), (3, 3), (3, 5), (2, 5)], "L"),
        Rectangle(7, 5, 3, 2, 0.3, "R"),
        Polygon([(9, 6), (13, 6), (11, 9)][::-1], "T"),
        Polygon([(15, 10), (18, 10), (18, 13), (15, 13)], "out"),
        Rectangle(6, 9, 1, 1, name="A"),
        Rectangle(7, 9, 1, 1, name="B"),
    ],
)
ROUND = Scene(
    [(0, 0), (16, 0), (16, 12), (8, 9), (0, 12)],
    [
        Circle((4, 4), 1.5, "C"),
        Circle((5, 5.5), 1, "D"),
        Line([(8, 2), (12, 3), (10, 6)], 0.8, "W"),
        Circle((14, 8), 0.5, "E"),
    ],
)


def solid(scene: Scene) -> shapely.Geometry:
    """What the polygons of a scene and the outside of its workspace cover."""
    room = shapely.polygons(np.array(scene.workspace))
    outside = shapely.difference(shapely.buffer(shapely.envelope(room), 100, cap_style="square"), room)
    return shapely.union_all([outside, *(shapely.polygons(o.core) for o in scene.obstacles)])


def free_places(scene: Scene, count: int, seed: int) -> FloatArray:
    """Places in no obstacle, (count, 2)."""
    rng = np.random.default_rng(seed)
    low, high = np.min(scene.workspace, axis=0), np.max(scene.workspace, axis=0)
    places = rng.uniform(low, high, (4 * count, 2))
    return np.asarray(places[depths(scene, places) > 1e-3][:count], dtype=np.float64)


def depths(scene: Scene, places: FloatArray) -> FloatArray:
    """Distance of places from what is solid, negative within circles and bars."""
    points = shapely.points(places)
    room = shapely.polygons(np.array(scene.workspace))
    cores = [shapely.polygons(o.core) if o.closed else _open(o.core) for o in scene.obstacles]
    apart = [shapely.distance(points, c) - o.own_radius for c, o in zip(cores, scene.obstacles, strict=True)]
    apart.append(np.where(shapely.covers(room, points), shapely.distance(points, shapely.boundary(room)), 0.0))
    return np.asarray(np.min(apart, axis=0), dtype=np.float64)


def _open(core: FloatArray) -> shapely.Geometry:
    return shapely.points(core[0]) if len(core) == 1 else shapely.linestrings(core)


def team(scene: Scene, count: int, radius: float = 0.0) -> Scene:
    return Scene(
        scene.workspace, scene.obstacles, [Robot(f"R{k}", (0, 0), (1, 1), radius) for k in range(count)], gap=1
    )


def look(scene: Scene, poses: FloatArray, lidar: Lidar) -> FloatArray:
    return scan(lidar, surroundings_of(team(scene, len(poses))), poses).ranges


def steady(scene: Scene, poses: FloatArray, lidar: Lidar) -> Flags:
    """Which beams measure nearly the same when turned a little: those that graze a corner do not."""
    turn = np.array([0, 0, 1e-9])
    return np.asarray(
        np.abs(look(scene, poses + turn, lidar) - look(scene, poses - turn, lidar)) < 1e-6, dtype=np.bool_
    )


def ends(poses: FloatArray, angles: FloatArray, reach: float) -> FloatArray:
    """Ends of beams, (n, beams, 2)."""
    way = poses[:, 2, None] + angles
    return poses[:, None, :2] + reach * np.stack([np.cos(way), np.sin(way)], axis=-1)


def test_ten_thousand_rays_among_polygons_agree_with_shapely() -> None:
    places = free_places(FLAT, 100, 1)
    poses = np.column_stack([places, np.random.default_rng(2).uniform(-4, 4, len(places))])
    lidar = Lidar(beams=100, field=2 * math.pi, reach=7.0)
    got = look(FLAT, poses, lidar)
    assert got.size == 10_000
    to = ends(poses, np.array(lidar.angles), lidar.reach)
    rays = shapely.linestrings(np.stack([np.broadcast_to(poses[:, None, :2], to.shape), to], axis=2))
    far = shapely.distance(shapely.points(poses[:, None, :2]), shapely.intersection(rays, solid(FLAT)))
    want = np.where(np.isnan(far), lidar.reach, far)
    assert np.abs(got - want).max() < 1e-9
    assert 0.1 < (got == lidar.reach).mean() < 0.9


def test_rays_among_circles_and_rounded_walls_agree_with_distances_of_shapely() -> None:
    """Where the nearest thing is d away a ray is free for d: steps of that length lead to the first echo."""
    places = free_places(ROUND, 100, 3)
    poses = np.column_stack([places, np.random.default_rng(4).uniform(-4, 4, len(places))])
    lidar = Lidar(beams=100, field=2 * math.pi, reach=6.0)
    got = look(ROUND, poses, lidar).ravel()
    start = np.repeat(poses[:, :2], 100, axis=0)
    way = (ends(poses, np.array(lidar.angles), 1.0) - poses[:, None, :2]).reshape(-1, 2)
    s, active = np.zeros(len(got)), np.arange(len(got))
    for _ in range(3000):
        step = depths(ROUND, start[active] + s[active, None] * way[active])
        s[active] += step
        active = active[(step > 1e-13) & (s[active] < lidar.reach)]
    want = np.minimum(s, lidar.reach)
    settled = np.ones(len(got), dtype=bool)
    settled[active] = False
    assert settled.mean() > 0.999
    assert np.abs(got - want)[settled].max() < 1e-9


@settings(max_examples=60, deadline=None)
@given(scenes(max_obstacles=5), st.integers(0, 2**32), st.floats(-4, 4))
def test_rays_agree_with_shapely_among_obstacles_that_touch_and_overlap(scene: Scene, seed: int, turn: float) -> None:
    flat = Scene(scene.workspace, [o for o in scene.obstacles if o.closed])
    places = free_places(flat, 5, seed)
    assume(len(places))
    poses = np.column_stack([places, np.full(len(places), turn)])
    lidar = Lidar(beams=24, field=2 * math.pi, reach=20.0)
    got = look(flat, poses, lidar)
    to = ends(poses, np.array(lidar.angles), lidar.reach)
    rays = shapely.linestrings(np.stack([np.broadcast_to(poses[:, None, :2], to.shape), to], axis=2))
    want = shapely.distance(shapely.points(poses[:, None, :2]), shapely.intersection(rays, solid(flat)))
    clear = steady(flat, poses, lidar)
    assert clear.mean() > 0.5
    assert np.abs(got - want)[clear].max() < 1e-9


@settings(max_examples=40, deadline=None)
@given(scenes(max_obstacles=5), st.integers(0, 2**32), st.floats(-4, 4), st.floats(-3, 3))
def test_what_is_turned_and_moved_as_a_whole_looks_the_same(scene: Scene, seed: int, turn: float, far: float) -> None:
    places = free_places(scene, 3, seed)
    assume(len(places))
    poses = np.column_stack([places, np.zeros(len(places))])
    c, s = math.cos(turn), math.sin(turn)

    def moved(points: Any) -> FloatArray:
        return np.asarray(np.asarray(points) @ np.array([[c, s], [-s, c]]) + far, dtype=np.float64)

    def other(o: Any) -> Any:
        if isinstance(o, Circle):
            return Circle(tuple(moved(o.center)), o.radius)
        return Line(moved(o.points), o.width) if isinstance(o, Line) else Polygon(moved(o.core))

    whole = Scene(moved(scene.workspace), [other(o) for o in scene.obstacles])
    lidar = Lidar(beams=24, field=6.0, reach=20.0)
    before = look(scene, poses, lidar)
    after = look(whole, np.column_stack([moved(places), np.full(len(places), turn)]), lidar)
    assert np.abs(before - after)[steady(scene, poses, lidar)].max(initial=0.0) < 1e-8


@pytest.mark.parametrize("scene", [FLAT, ROUND], ids=["flat", "round"])
def test_the_grid_changes_no_bit(scene: Scene) -> None:
    places = free_places(scene, 200, 6)
    poses = np.column_stack([places, np.arange(len(places))])
    world = surroundings_of(team(scene, len(places)))
    pieces = world.pieces
    count = len(pieces.sides) + len(pieces.discs)
    one_cell = pieces._replace(
        frame=pieces.frame * (1, 1, 1000),
        shape=np.array([1, 1]),
        start=np.array([0, count]),
        items=np.arange(count),
    )
    lidar = Lidar(beams=360, field=2 * math.pi)
    with_grid, without = (scan(lidar, w, poses) for w in (world, replace(world, pieces=one_cell)))
    assert np.array_equal(with_grid.ranges, without.ranges)
    assert (pieces.shape > 3).all()


@pytest.mark.parametrize("scale", [2.0**-30, 2.0**20])
def test_a_world_scaled_by_a_power_of_two_gives_the_same_bits(scale: float) -> None:
    def scaled(o: Any) -> Any:
        if isinstance(o, Circle):
            return Circle((o.center[0] * scale, o.center[1] * scale), o.radius * scale)
        points = o.core * scale
        return Line(points, o.width * scale) if isinstance(o, Line) else Polygon(points)

    for scene in (FLAT, ROUND):
        whole = Scene(np.array(scene.workspace) * scale, [scaled(o) for o in scene.obstacles])
        poses = np.column_stack([free_places(scene, 50, 7), np.arange(50)])
        got = scan(Lidar(reach=7 * scale), surroundings_of(team(whole, 50)), poses * (scale, scale, 1)).ranges
        assert np.array_equal(got, scan(Lidar(reach=7), surroundings_of(team(scene, 50)), poses).ranges * scale)


def one_look(obstacles: list[Any], pose: tuple[float, float, float], *angles: float, reach: float = 20.0) -> Scan:
    scene = Scene((0, 0, 10, 10), obstacles, [Robot("R1", (1, 1), (2, 2))])
    return scan(Lidar(angles=angles, reach=reach), surroundings_of(scene), [pose])


ROBOT = Robot("R1", (1, 1), (2, 2))
SQUARE = Rectangle(4, 4, 2, 2, name="S")
DIAGONALS = [k * math.pi / 4 for k in range(8)]


def test_a_ray_through_a_corner_ends_there() -> None:
    assert one_look([SQUARE], (2, 2, 0), math.pi / 4).ranges[0, 0] == pytest.approx(math.sqrt(8), abs=1e-12)
    grazing = one_look([Polygon([(4, 4), (3, 2), (5, 2)])], (2, 4, 0), 0.0)
    assert grazing.ranges[0, 0] == 2.0


def test_a_ray_along_a_side_ends_at_its_first_corner() -> None:
    assert one_look([SQUARE], (1, 4, 0), 0.0).ranges[0, 0] == 3.0
    assert one_look([SQUARE], (1, 6, 0), 0.0).ranges[0, 0] == 3.0


def test_a_ray_that_is_tangent_to_a_circle_ends_there_and_one_beside_it_does_not() -> None:
    assert one_look([Circle((5, 5), 2)], (1, 3, 0), 0.0).ranges[0, 0] == pytest.approx(4.0, abs=1e-12)
    assert one_look([Circle((5, 5), 2)], (1, math.nextafter(3, 0), 0), 0.0).ranges[0, 0] == pytest.approx(
        9.0, abs=1e-12
    )


def test_the_side_of_a_rounded_wall_and_its_ends_are_met_where_they_are() -> None:
    wall = Line([(4, 4), (8, 4)], 1.0)
    assert one_look([wall], (6, 1, math.pi / 2), 0.0).ranges[0, 0] == pytest.approx(2.5, abs=1e-12)
    assert one_look([wall], (1, 4, 0), 0.0).ranges[0, 0] == pytest.approx(2.5, abs=1e-12)
    off = one_look([wall], (1, 4.3, 0), 0.0).ranges[0, 0]
    assert off == pytest.approx(3 - math.sqrt(0.25 - 0.09), abs=1e-12)


@pytest.mark.parametrize(
    ("place", "into"),
    [
        ((4, 4), [1]),
        ((5, 4), [1, 2, 3]),
        ((6, 6), [5]),
        ((0, 0), [3, 4, 5, 6, 7]),
        ((0, 5), [3, 4, 5]),
        ((8, 1), [0, 1, 7]),
        ((2, 7.5), [1, 2, 3]),
    ],
)
def test_whoever_touches_something_sees_along_it_and_away_but_not_into_it(
    place: tuple[float, float], into: list[int]
) -> None:
    things = [SQUARE, Circle((9, 1), 1), Line([(1, 8), (3, 8)], 1)]
    for nudge in (0.0, 3e-12, -3e-12):
        got = one_look(things, (place[0] + nudge, place[1] + nudge, 0), *DIAGONALS)
        assert np.flatnonzero(got.ranges[0] < 1e-9).tolist() == into


@pytest.mark.parametrize("nudge", [0.0, 3e-12, -3e-12])
def test_a_ray_along_what_is_touched_ends_where_the_next_side_rises(nudge: float) -> None:
    arm = Polygon([(2, 4), (8, 4), (8, 6), (6, 6), (6, 5), (2, 5)])
    assert one_look([arm], (3, 5 + nudge, 0), 0.0).ranges[0, 0] == pytest.approx(3.0, abs=1e-9)
    assert one_look([], (3, nudge, 0), 0.0).ranges[0, 0] == pytest.approx(7.0, abs=1e-9)


def test_between_two_obstacles_that_touch_in_a_point_both_are_seen() -> None:
    pinch = [Rectangle(2, 2, 2, 2), Rectangle(4, 4, 2, 2)]
    got = one_look(pinch, (4, 4, 0), *[k * math.pi / 4 for k in range(8)])
    assert np.flatnonzero(got.ranges[0] == 0).tolist() == [1, 5]
    assert got.hits[0, [1, 5]].tolist() == [1, 0]


def test_at_a_reflex_corner_only_the_open_quarter_is_seen() -> None:
    corner = Polygon([(4, 4), (8, 4), (8, 5), (5, 5), (5, 8), (4, 8)])
    got = one_look([corner], (5, 5, 0), *[k * math.pi / 4 for k in range(8)])
    assert np.flatnonzero(got.ranges[0] > 0).tolist() == [0, 1, 2]


@pytest.mark.parametrize(
    ("pose", "name"), [((5, 5, 1), "S"), ((-1, 5, 1), "the wall"), ((9, 1, 1), "C"), ((2, 8, 1), "L"), ((8, 8, 0), "P")]
)
def test_whoever_is_within_something_has_0_all_around(pose: tuple[float, float, float], name: str) -> None:
    things: list[Any] = [SQUARE, Circle((9, 1), 0.5, "C"), Line([(1, 8), (3, 8)], 1, "L")]
    world = surroundings_of(
        Scene((0, 0, 10, 10), things, [Robot("R", (1, 1), (2, 2)), Robot("P", (8, 8), (8, 8), 0.5)])
    )
    got = scan(Lidar(), world, [pose, (8.1, 8, 0)], robots=[0])
    assert (got.ranges == 0).all()
    assert {world.names[k] for k in got.hits.ravel()} == {name}


def test_the_nearest_of_many_discs_is_met_as_the_quadratic_says_and_the_own_one_never() -> None:
    rng = np.random.default_rng(5)
    n = 60
    poses = np.column_stack([rng.uniform(1, 99, (n, 2)), rng.uniform(-9, 9, n)])
    radii = rng.uniform(0, 0.8, n)
    radii[::7] = 0.0
    robots = [Robot(f"R{k}", (0, 0), (1, 1), r) for k, r in enumerate(radii)]
    world = surroundings_of(Scene((0, 0, 100, 100), robots=robots, gap=1))
    present = rng.uniform(size=n) < 0.9
    lidar = Lidar(beams=60, field=2 * math.pi, reach=40.0)
    got = scan(lidar, world, poses, present=present)
    way = ends(poses, np.array(lidar.angles), 1.0) - poses[:, None, :2]
    to = poses[None, :, :2] - poses[:, None, :2]
    along = np.einsum("ibc,ijc->ibj", way, to)
    beside = way[:, :, None, 0] * to[:, None, :, 1] - way[:, :, None, 1] * to[:, None, :, 0]
    with np.errstate(invalid="ignore"):
        s = along - np.sqrt(radii**2 - beside**2)
    s[np.isnan(s) | (along < 0)] = np.inf
    s[:, :, ~present | (radii == 0)] = np.inf
    s[np.arange(n), :, np.arange(n)] = np.inf
    with np.errstate(divide="ignore"):
        walls = np.maximum((100 - poses[:, None, :2]) / way, (0 - poses[:, None, :2]) / way).min(axis=2)
    within = np.logical_and(np.hypot(to[..., 0], to[..., 1]) < radii, present & ~np.eye(n, dtype=np.bool_))
    apart: Flags = np.logical_not(within.any(axis=1))
    want = np.minimum(np.minimum(s.min(axis=2), walls), lidar.reach)
    assert np.abs(got.ranges - want)[apart].max() < 1e-9
    robot_hit = (s.min(axis=2) < np.minimum(walls, lidar.reach)) & apart[:, None]
    assert (got.hits[robot_hit] == 1 + s.argmin(axis=2)[robot_hit]).all()
    assert robot_hit.mean() > 0.05


def test_without_echo_the_range_is_the_reach_and_nothing_is_named() -> None:
    got = one_look([SQUARE], (1, 5, 0), 0.0, math.pi / 2, reach=4.0)
    assert got.ranges.tolist() == [[3.0, 4.0]]
    assert got.hits.tolist() == [[0, -1]]
    assert got.echo.tolist() == [[True, False]]


def test_an_echo_at_the_reach_exactly_is_one() -> None:
    got = one_look([SQUARE], (1, 5, 0), 0.0, reach=3.0)
    assert got.ranges.tolist() == [[3.0]]
    assert got.hits.tolist() == [[0]]


def test_noise_is_normal_within_0_and_reach_and_only_on_echoes() -> None:
    world = surroundings_of(Scene((0, 0, 100, 100), robots=[Robot("R", (1, 1), (2, 2))]))
    angles = np.linspace(-0.5, 0.5, 20_001)
    clear, noisy = (scan(Lidar(angles=angles, reach=55.0, noise=n), world, [(50, 50, 0)], seed=3) for n in (0.0, 0.25))
    error = (noisy.ranges - clear.ranges)[clear.ranges < 54]
    assert abs(error.mean()) < 0.01
    assert error.std() == pytest.approx(0.25, rel=0.02)
    assert np.quantile(error, [0.1587, 0.8413]) == pytest.approx([-0.25, 0.25], abs=0.01)
    assert abs(np.corrcoef(error[1:], error[:-1])[0, 1]) < 0.03
    assert noisy.ranges.max() <= 55
    assert not clear.echo.all()
    assert (noisy.ranges[~clear.echo] == 55).all()
    near = scan(Lidar(angles=angles, reach=55.0, noise=5.0), world, [(99.9, 50, 0)], seed=3).ranges
    assert near.min() == 0.0


def test_noise_depends_on_seed_step_and_robot_and_not_on_who_else_looks() -> None:
    poses = [(1, 3, 0), (6, 3, 1), (12, 4, 2)]
    world = surroundings_of(team(FLAT, 3))
    lidar = Lidar(noise=0.1)
    all_look = scan(lidar, world, poses, seed=7, step=4).ranges
    assert np.array_equal(scan(lidar, world, poses, robots=[2, 1], seed=7, step=4).ranges, all_look[[2, 1]])
    others = [scan(lidar, world, poses, seed=a, step=b).ranges for a, b in [(8, 4), (7, 5), (4, 7)]]
    assert not any((other == all_look)[all_look < 10].any() for other in others)
    same = scan(lidar, world, [poses[0]] * 3, seed=7, step=4).ranges
    assert not np.array_equal(same[0], same[1])


def test_beams_are_spread_over_the_field_and_a_full_turn_has_no_beam_twice() -> None:
    assert Lidar().angles[0] == -math.pi / 2
    assert Lidar().angles[90] == pytest.approx(0.0, abs=1e-15)
    assert Lidar(beams=1, field=1.0).angles == (0.0,)
    assert Lidar(beams=4, field=2 * math.pi).angles == pytest.approx([-math.pi, -math.pi / 2, 0, math.pi / 2])


def test_presets_are_the_settings_of_the_thesis() -> None:
    assert Lidar(angles=np.linspace(-math.pi / 2, math.pi / 2, 9), reach=3.0) == THESIS_NEAR_LIDAR
    assert Lidar(angles=np.linspace(-math.pi / 4, math.pi / 4, 10), reach=10.0) == THESIS_FAR_LIDAR
    assert Detector(math.pi / 4, 5.0) == THESIS_DETECTOR


def sees(scene: Scene, detector: Detector, *poses: tuple[float, float, float], **more: Any) -> dict[str, Detection]:
    return {one.name: one for one in detect(detector, surroundings_of(scene), poses, 0, **more)}


def test_what_is_detected_agrees_with_a_dense_look_around() -> None:
    rng = np.random.default_rng(11)
    compared = 0
    for _ in range(120):
        things: list[Any] = []
        for _ in range(rng.integers(1, 9)):
            x, y, w, h, a = rng.uniform((0, 0, 0.2, 0.2, 0), (16, 12, 4, 3, 6))
            shapes = [Circle((x, y), w / 2), Rectangle(x, y, w, h, a), Line([(x, y), (x + h, y), (x, y + w)], w / 5)]
            things.append(shapes[rng.integers(3)])
        scene = Scene((0, 0, 16, 12), things, [Robot("R0", (0, 0), (1, 1)), Robot("R1", (0, 0), (1, 1), 0.4)])
        spots = free_places(scene, 40, int(rng.integers(1000)))
        spots = spots[depths(scene, spots) > 0.41]
        if len(spots) < 2 or math.dist(spots[0], spots[1]) < 0.5:
            continue
        detector = Detector(rng.choice([0.8, 2.0, 2 * math.pi]), rng.uniform(3, 9))
        poses = [(*spots[0], rng.uniform(-9, 9)), (*spots[1], 0.0)]
        world = surroundings_of(scene)
        got = {one.name: one for one in detect(detector, world, poses, 0)}
        dense = scan(Lidar(beams=40_001, field=detector.field, reach=detector.reach), world, poses, robots=[0])
        for k in set(dense.hits[dense.hits >= 0].tolist()) - {len(things)}:
            sampled = dense.ranges[dense.hits == k].min()
            assert got[world.names[k]].distance <= sampled + 1e-9
            compared += 1
        for one in got.values():
            about = [one.bearing - 1e-8, one.bearing, one.bearing + 1e-8]
            beams = scan(Lidar(angles=about, reach=20.0), world, poses, robots=[0])
            mine = beams.hits == world.names.index(one.name)
            assert mine.any()
            assert np.abs(beams.ranges[mine] - one.distance).min() < 1e-4
            assert one.distance <= detector.reach + 1e-9
            assert abs(one.bearing) <= detector.field / 2 + 1e-12
    assert compared > 100


def test_the_nearest_point_of_an_obstacle_counts_where_it_is_seen() -> None:
    scene = Scene((0, 0, 10, 10), [Rectangle(6, 1, 1, 8, name="far"), Rectangle(3, 4, 1, 2, name="near")], [ROBOT])
    got = sees(scene, Detector(math.pi, 9.0), (1, 5, 0))
    assert got["near"] == Detection("near", 2.0, 0.0)
    behind = math.atan2(1, 2)
    assert abs(got["far"].bearing) == pytest.approx(behind, abs=1e-12)
    assert got["far"].distance == pytest.approx(5 / math.cos(behind), abs=1e-12)


def test_an_obstacle_out_of_field_reach_or_sight_is_not_seen() -> None:
    scene = Scene((0, 0, 10, 10), [Circle((5, 5), 1, "C"), Circle((8, 5), 1, "hidden")], [ROBOT])
    assert list(sees(scene, Detector(0.5, 9.0), (1, 5, 0))) == ["C"]
    assert list(sees(scene, Detector(0.5, 3.001), (1, 5, 0))) == ["C"]
    assert not sees(scene, Detector(0.5, 2.999), (1, 5, 0))
    assert not sees(scene, Detector(0.5, 9.0), (1, 5, math.pi))
    edge = math.asin(1 / 4) + 0.25
    assert list(sees(scene, Detector(0.5, 9.0), (1, 5, edge - 1e-9))) == ["C"]
    assert not sees(scene, Detector(0.5, 9.0), (1, 5, edge + 1e-9))


def test_a_bearing_behind_the_robot_goes_round() -> None:
    scene = Scene((0, 0, 10, 10), [Circle((2, 5), 1, "C")], [ROBOT])
    got = sees(scene, Detector(2 * math.pi, 9.0), (6, 5, 0.0))
    assert got["C"].distance == pytest.approx(3.0, abs=1e-12)
    assert abs(got["C"].bearing) == pytest.approx(math.pi, abs=1e-12)


def test_robots_without_radius_and_points_are_seen_unless_something_is_between() -> None:
    robots = [ROBOT, Robot("R2", (1, 1), (2, 2)), Robot("R3", (1, 1), (2, 2))]
    scene = Scene((0, 0, 10, 10), [Circle((5, 5), 1, "C")], robots, gap=0.1)
    poses = [(1, 5, 0), (3, 5.5, 0), (8, 5, 0)]
    points = {"goal": (3, 5), "rim": (4, 5), "hidden": (6.5, 5), "back": (0, 5)}
    got = sees(scene, Detector(2.0, 9.0), *poses, points=points)
    assert list(got) == ["goal", "R2", "C", "rim"]
    assert got["goal"] == Detection("goal", 2.0, 0.0)
    assert got["R2"].distance == pytest.approx(math.hypot(2, 0.5), abs=1e-12)
    assert "R2" not in sees(scene, Detector(2.0, 9.0), *poses, present=[True, False, True])


def test_within_an_obstacle_nothing_but_that_is_seen() -> None:
    scene = Scene((0, 0, 10, 10), [SQUARE, Circle((8, 8), 1)], [ROBOT])
    assert sees(scene, Detector(), (5, 5, 0)) == {"S": Detection("S", 0.0, 0.0)}


def test_an_empty_room_shows_nothing() -> None:
    assert not sees(Scene((0, 0, 10, 10), robots=[ROBOT]), Detector(), (5, 5, 0))


@pytest.mark.parametrize("sight", [False, True])
def test_the_radio_links_whom_contacts_calls_in_contact(sight: bool) -> None:
    scene = team(FLAT, 40)
    places = free_places(FLAT, 40, 8)
    resting = [Trajectory(r.name, np.array([[0, *p]])) for r, p in zip(scene.robots, places, strict=True)]
    want = contacts(Plan(scene, tuple(resting)), 5.0, sight).pairs
    got = linked(Radio(5.0, sight), places, sight_sides(scene, scene.tol))
    assert np.array_equal(got, want)
    assert 0 < len(got) < len(places) * (len(places) - 1) // 2


def test_the_radio_reaches_exactly_so_far_and_only_those_that_are_there() -> None:
    places = [(0, 0), (2, 0), (4, 0)]
    assert linked(Radio(2.0), places).tolist() == [[0, 1], [1, 2]]
    assert linked(Radio(math.nextafter(2, 0)), places).tolist() == []
    assert linked(Radio(2.0), places, present=[True, True, False]).tolist() == [[0, 1]]
    assert linked(Radio(2.0), []).shape == (0, 2)
    assert linked(Radio(2.0, sight=True), places, np.empty((0, 4))).tolist() == [[0, 1], [1, 2]]


def test_a_team_of_nobody_scans_nothing() -> None:
    assert scan(Lidar(), surroundings_of(Scene((0, 0, 1, 1))), np.empty((0, 3))).ranges.shape == (0, 181)


WORLD = surroundings_of(Scene((0, 0, 4, 4), robots=[ROBOT]))


@pytest.mark.parametrize(
    ("call", "message"),
    [
        (lambda: Lidar(beams=0), "beams must be a whole number of at least 1, got 0"),
        (lambda: Lidar(beams=2.5), "beams must be a whole number"),  # type: ignore[arg-type]
        (lambda: Lidar(field=7.0), "field must be at most a full turn"),
        (lambda: Lidar(field=0.0), "field must be positive"),
        (lambda: Lidar(reach=0.0), "reach must be positive"),
        (lambda: Lidar(reach=math.inf), "reach must be a finite number"),
        (lambda: Lidar(noise=-1.0), "noise must not be negative"),
        (lambda: Lidar(angles=[]), "at least one beam"),
        (lambda: Lidar(angles=[math.nan]), "every angle must be a finite number"),
        (lambda: Detector(field=-1.0), "detector: field must be positive"),
        (lambda: Detector(reach=0.0), "detector: reach must be positive"),
        (lambda: Radio(0.0), "radio: reach must be positive"),
        (lambda: scan(Lidar(), WORLD, [(1, 1)]), r"poses must be an array \(n, 3\)"),
        (lambda: scan(Lidar(), WORLD, [(1, 1, 0), (2, 2, 0)]), "a pose for each of the 1 robots, got 2"),
        (lambda: scan(Lidar(), WORLD, [(1, math.nan, 0)]), "poses: row 0 is not finite"),
        (lambda: scan(Lidar(), WORLD, "here"), "poses must be rows"),
        (lambda: scan(Lidar(), WORLD, [(1, 1, 0)], present=[1]), "present must be 1 booleans"),
        (lambda: scan(Lidar(noise=1), WORLD, [(1, 1, 0)], seed=-1), "seed must be a whole number"),
        (lambda: scan(Lidar(), WORLD, [(1, 1, 0)], robots=[0.5]), "whole numbers"),  # type: ignore[list-item]
        (lambda: linked(Radio(1.0, sight=True), [(1, 1)]), "needs the sides"),
        (lambda: detect(Detector(), WORLD, [(1, 1, 0)], 0, points={"P": (1, math.nan)}), "points"),
    ],
)
def test_what_makes_no_sense_is_told_in_a_line(call: Any, message: str) -> None:
    with pytest.raises(ValueError, match=message) as told:
        call()
    assert "\n" not in str(told.value)


def test_a_robot_that_is_none_and_a_room_that_is_none_are_refused() -> None:
    with pytest.raises(IndexError, match="there is no robot 1"):
        scan(Lidar(), WORLD, [(1, 1, 0)], robots=[1])
    with pytest.raises(SceneError, match="workspace"):
        surroundings_of(Scene([(0, 0), (2, 2), (2, 0), (0, 2)]))
