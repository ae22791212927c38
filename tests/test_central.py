"""The Central Algorithm does what the source says, exactly, and says honestly what its path hits."""

from __future__ import annotations

import contextlib
import math
from collections.abc import Sequence
from dataclasses import replace
from itertools import combinations

import networkx as nx
import numpy as np
import pytest
import shapely
from hypothesis import given, settings
from hypothesis import strategies as st

from strategies import scenes
from taut.certificate import certify
from taut.errors import GoalBlocked, SceneError, StartBlocked
from taut.formats import load_scene
from taut.generate import random_scene
from taut.motion import Plan, Trajectory
from taut.route.central import CentralRoute, Crossed, NoCentralPath, central_path
from taut.route.hits import hits_of
from taut.scene import Circle, FloatArray, Line, Obstacle, Point, Polygon, Robot, Scene
from zoo import ZOO, Entry

DELTAS = st.sampled_from([0.0, 0.25, 0.5, 2.0])


def box(x0: float, y0: float, x1: float, y1: float, name: str = "") -> Polygon:
    return Polygon([(x0, y0), (x1, y0), (x1, y1), (x0, y1)], name)


def travel(
    obstacles: Sequence[Obstacle], start: Point, goal: Point, delta: float = 0.5, radius: float = 0.0
) -> CentralRoute:
    scene = Scene((0, 0, 10, 8), obstacles, [Robot("R1", start, goal, radius)])
    return central_path(scene, "R1", delta)


def cross(a: FloatArray, b: FloatArray) -> FloatArray:
    return np.asarray(a[..., 0] * b[..., 1] - a[..., 1] * b[..., 0])


def core_of(obstacle: Obstacle) -> shapely.Geometry:
    core = obstacle.core
    if obstacle.closed:
        return shapely.Polygon(core)
    return shapely.LineString(core) if len(core) > 1 else shapely.Point(core[0])


def depth_of(baseline: shapely.LineString, obstacle: Obstacle, growth: float) -> float:
    """How deep the baseline gets in a grown obstacle, at least; near 0 or below where it only touches or misses."""
    core, reach = core_of(obstacle), obstacle.own_radius + growth
    if not obstacle.closed:
        return reach - float(baseline.distance(core))
    pieces = shapely.get_parts(baseline.intersection(core))
    middles = [piece.interpolate(0.5, normalized=True) for piece in pieces if piece.length > 0]
    inside = [m for m in middles if core.contains(m)]
    return reach + max((core.exterior.distance(m) for m in inside), default=-float(baseline.distance(core)))


def check_crossed(scene: Scene, robot: Robot, crossed: tuple[Crossed, ...]) -> None:
    """The right obstacles, entries and exits on their outline, m the greatest distance of their vertices."""
    growth = scene.growth(robot)
    s, g = np.array(robot.start), np.array(robot.goal)
    baseline = shapely.LineString([s, g])
    names = {c.name for c in crossed}
    for obstacle in scene.obstacles:
        depth = depth_of(baseline, obstacle, growth)
        assert abs(depth) < 1e-9 or (obstacle.name in names) == (depth > 0)
    by_name = {o.name: o for o in scene.obstacles}
    for c in crossed:
        obstacle = by_name[c.name]
        reach = obstacle.own_radius + growth
        off = np.abs(cross(g - s, s - obstacle.core)) / np.hypot(*(g - s))
        assert c.reach == pytest.approx(off.max() + reach, rel=1e-13)
        assert len(c.crossings) % 2 == 0
        outline = core_of(obstacle).boundary if obstacle.closed else core_of(obstacle)
        for u in c.crossings:
            assert shapely.Point(u).distance(baseline) < 1e-12
            at_end = min(math.dist(u, s), math.dist(u, g)) == 0
            assert at_end or abs(outline.distance(shapely.Point(u)) - reach) < 1e-9


def check_waypoints(scene: Scene, robot: Robot, route: CentralRoute) -> None:
    """Two for each crossing, u' − u orthogonal to the baseline and m + δ long, one on either side."""
    s, g = np.array(robot.start), np.array(robot.goal)
    scale = np.abs(scene.workspace).max() ** 2
    crossed = {c.name: c for c in route.crossed}
    given_up = [w for w, _ in route.dropped]
    waypoints = [*route.waypoints, *given_up]
    keys = [(w.obstacle, w.crossing, w.side) for w in waypoints]
    assert len(set(keys)) == len(keys) == 2 * sum(len(c.crossings) for c in route.crossed)
    for w in waypoints:
        c = crossed[w.obstacle]
        step = np.array(w.place) - c.crossings[w.crossing]
        assert abs(step @ (g - s)) <= 1e-12 * scale
        assert cross(g - s, step) * w.side >= 0
    assert (np.array([w.place for w in route.waypoints]).reshape(-1, 2) == route.roadmap.positions[2:]).all()


def check_distances(robot: Robot, route: CentralRoute, delta: float) -> None:
    s, g = np.array(robot.start), np.array(robot.goal)
    crossed = {c.name: c for c in route.crossed}
    for w in [*route.waypoints, *(w for w, _ in route.dropped)]:
        off = abs(cross(g - s, np.array(w.place) - s)) / np.hypot(*(g - s))
        assert off == pytest.approx(crossed[w.obstacle].reach + delta, rel=1e-12, abs=1e-12)


def check_dropped(scene: Scene, robot: Robot, route: CentralRoute) -> None:
    """What was kept is free of the crossed obstacles and the wall, what was dropped is not, for the reason told."""
    growth = scene.growth(robot)
    partial = scene.with_obstacles([o for o in scene.obstacles if o.name in {c.name for c in route.crossed}])
    for w in route.waypoints:
        assert not hits_of(partial, [w.place], growth)
    for w, reason in route.dropped:
        names = {name for hit in hits_of(partial, [w.place], growth) for name in hit.obstacles}
        if "the wall" in names:
            assert reason.startswith(("outside the workspace", "nearer than"))
        else:
            assert names
            assert reason.split(" grown")[0] == "inside " + " and ".join(
                c.name for c in route.crossed if c.name in names
            )


def check_path(scene: Scene, robot: Robot, route: CentralRoute) -> None:
    """The shortest in the graph of all pairs that no crossed obstacle and no wall parts."""
    growth = scene.growth(robot)
    partial = scene.with_obstacles([o for o in scene.obstacles if o.name in {c.name for c in route.crossed}])
    places = route.roadmap.positions
    graph = nx.Graph()
    for i, j in combinations(range(len(places)), 2):
        if all(len(hit.obstacles) > 1 for hit in hits_of(partial, places[[i, j]], growth)):
            graph.add_edge(i, j, weight=math.dist(places[i], places[j]))
    assert {tuple(sorted(e)) for e in graph.edges} == {tuple(e) for e in route.roadmap.edges.tolist()}
    assert route.length == pytest.approx(nx.dijkstra_path_length(graph, 0, 1), rel=1e-12)
    assert tuple(route.points[0]) == robot.start
    assert tuple(route.points[-1]) == robot.goal


def check_honest(scene: Scene, robot: Robot, route: CentralRoute) -> None:
    """The motion along the path is proved exactly when no hit is reported, and its worst problem is among them."""
    length = np.hypot(*np.diff(route.points, axis=0).T)
    times = robot.start_time + np.append(0.0, np.cumsum(length * (1 + 1e-12))) / robot.speed
    stamps = np.column_stack([times, route.points])
    alone = replace(scene, robots=(robot,))
    certificate = certify(Plan(alone, (Trajectory(robot.name, stamps),)))
    assert certificate.ok == route.free, [str(p) for p in certificate.problems]
    named = {name for hit in route.hits for name in hit.obstacles}
    for problem in certificate.problems:
        assert problem.kind in ("clearance", "crossing")
        assert problem.kind == "crossing" or problem.obstacle in named


def check(scene: Scene, robot: Robot, delta: float) -> None:
    try:
        route = central_path(scene, robot, delta)
    except NoCentralPath as error:
        check_crossed(scene, robot, error.crossed)
        return
    if robot.start == robot.goal:
        assert (route.points.tolist(), route.crossed) == ([list(robot.start)], ())
        return
    check_crossed(scene, robot, route.crossed)
    check_waypoints(scene, robot, route)
    check_distances(robot, route, delta)
    check_dropped(scene, robot, route)
    check_path(scene, robot, route)
    check_honest(scene, robot, route)


@pytest.mark.parametrize("seed", range(42))
def test_random_maps(seed: int) -> None:
    """Points and discs among obstacles of all kinds, most of which the baselines miss."""
    radius, delta = ((0.0, 0.5), (0.2, 0.1), (0.3, 0.0))[seed % 3]
    kinds = ("polygon", "rectangle", "circle", "line", "nonconvex")
    scene = random_scene(robots=4, obstacles=12, density=0.25, radius=radius, gap=0.1, shapes=kinds, seed=seed)
    for robot in scene.robots:
        check(scene, robot, delta)


@settings(max_examples=120, deadline=None)
@given(scenes(max_robots=2), DELTAS)
def test_awkward_scenes_for_points(scene: Scene, delta: float) -> None:
    for robot in scene.robots:
        check(scene, robot, delta)


def test_a_way_shorter_than_the_tolerance_passes_nothing() -> None:
    """Not even in the corner of the workspace, where walls are on both sides of it."""
    robot = Robot("R1", (0.0, 0.0), (0.0, 1.4e-45))
    check(Scene((0, 0, 8, 8), robots=[robot], gap=0.1), robot, 0.0)


@settings(max_examples=60, deadline=None)
@given(scenes(max_robots=2, max_radius=0.5), DELTAS)
def test_awkward_scenes_for_discs(scene: Scene, delta: float) -> None:
    for robot in scene.robots:
        check(scene, robot, delta)


@pytest.mark.parametrize("entry", ZOO, ids=str)
def test_zoo_paths_are_proved_or_their_hits_are_named(entry: Entry) -> None:
    for robot in entry.scene.robots:
        with contextlib.suppress(NoCentralPath):
            check_honest(entry.scene, robot, central_path(entry.scene, robot, 0.0))


@pytest.mark.parametrize(
    ("name", "robot", "crossed", "hit"),
    [
        ("thesis-1", "R1", ["O2"], ["O4"]),
        ("thesis-1", "R2", ["O3", "O5"], ["O1", "O4"]),
        ("thesis-1", "R3", ["O3", "O5"], ["O6"]),
        ("thesis-2", "R1", ["O1", "O3"], []),
        ("thesis-2", "R2", ["O3", "O5"], ["O1"]),
        ("thesis-2", "R3", ["O1", "O2"], []),
        ("thesis-3", "R1", [], []),
        ("thesis-3", "R2", [], []),
        ("thesis-3", "R3", [], []),
    ],
)
def test_thesis_scenes(name: str, robot: str, crossed: list[str], hit: list[str]) -> None:
    scene = load_scene(name)
    route = central_path(scene, robot)
    assert [c.name for c in route.crossed] == crossed
    assert [h.obstacles[0] for h in route.hits] == hit
    traveller = next(r for r in scene.robots if r.name == robot)
    check(scene, traveller, 0.5)
    if not crossed:
        assert route.points.tolist() == [list(traveller.start), list(traveller.goal)]
        assert route.length == math.dist(traveller.start, traveller.goal)


def test_a_free_baseline_is_the_path() -> None:
    route = travel([box(4, 0, 6, 3), Circle((5, 6), 1)], (1, 4), (9, 4))
    assert route.points.tolist() == [[1, 4], [9, 4]]
    assert (route.crossed, route.waypoints, route.dropped, route.free) == ((), (), (), True)
    assert route.roadmap.edges.tolist() == [[0, 1]]


def test_waypoints_beside_a_box_are_where_the_formula_says() -> None:
    route = travel([box(4, 3, 6, 4.5, "box")], (1, 4), (9, 4), delta=0.5)
    (crossed,) = route.crossed
    assert (crossed.crossings.tolist(), crossed.reach) == ([[4, 4], [6, 4]], 1.0)
    assert [w.place for w in route.waypoints] == [(4, 5.5), (4, 2.5), (6, 5.5), (6, 2.5)]
    assert route.length == pytest.approx(math.hypot(5, 1.5) + math.hypot(3, 1.5))


def test_discs_keep_their_radius_from_grown_obstacles() -> None:
    route = travel([Circle((5, 4), 1, "pillar")], (1, 4), (9, 4), delta=0.25, radius=0.5)
    (crossed,) = route.crossed
    assert (crossed.crossings.tolist(), crossed.reach) == ([[3.5, 4], [6.5, 4]], 1.5)
    assert route.free


def test_an_obstacle_crossed_three_times_has_six_crossings() -> None:
    comb = Polygon(
        [(2, 5), (2, 3), (3, 3), (3, 4.5), (4, 4.5), (4, 3), (5, 3), (5, 4.5), (6, 4.5), (6, 3), (7, 3), (7, 5)]
    )
    route = travel([comb], (1, 4), (9, 4), delta=0.5)
    (crossed,) = route.crossed
    assert crossed.crossings[:, 0].tolist() == [2, 3, 4, 5, 6, 7]
    assert len(route.waypoints) == 12
    assert route.free


@pytest.mark.parametrize(
    "obstacle",
    [box(4, 4, 6, 6), Polygon([(5, 4), (6, 6), (4, 6)]), box(3, 4, 9, 5), box(1, 4, 3, 5)],
    ids=["edge", "corner", "edge-to-goal", "edge-from-start"],
)
def test_touching_is_not_crossing(obstacle: Obstacle) -> None:
    route = travel([obstacle], (1, 4), (9, 4))
    assert (route.crossed, route.free, len(route.points)) == ((), True, 2)


def test_a_line_along_a_seam_crosses_nothing_and_is_reported() -> None:
    route = travel([box(3, 2, 7, 4, "below"), box(4, 4, 8, 6, "above")], (1, 4), (9, 4))
    assert route.crossed == ()
    assert {hit.obstacles for hit in route.hits} == {("below", "above")}
    assert not route.free


def test_a_line_through_a_touching_point_is_reported_there() -> None:
    route = travel([box(3, 2, 5, 4, "below"), box(5, 4, 7, 6, "above")], (4, 5), (6, 3))
    (hit,) = route.hits
    assert (hit.obstacles, hit.place, hit.leg) == (("below", "above"), (5, 4), 0)


def test_what_the_detour_hits_is_named_with_the_first_place() -> None:
    obstacles = [box(3, 0.25, 5, 1.25, "box"), box(4, 1.6, 4.5, 8, "high"), box(6, 3, 7, 4, "aside")]
    route = travel(obstacles, (1, 0.75), (9, 0.75), delta=0.5)
    assert route.points.tolist() == [[1, 0.75], [5, 1.75], [9, 0.75]]
    (hit,) = route.hits
    assert (hit.obstacles, hit.leg) == (("high",), 0)
    assert hit.place == pytest.approx((4.4, 1.6))


def test_waypoints_outside_and_inside_are_dropped_with_the_reason() -> None:
    route = travel([box(3, 0.25, 5, 1.25, "box")], (1, 0.75), (9, 0.75), delta=0.5)
    assert [(w.crossing, w.side) for w in route.waypoints] == [(0, 1), (1, 1)]
    assert [(w.crossing, w.side, reason) for w, reason in route.dropped] == [
        (0, -1, "outside the workspace"),
        (1, -1, "outside the workspace"),
    ]
    roof = Polygon([(6, 3.5), (7, 3.5), (7, 5.5), (2.5, 5.5), (2.5, 5), (6, 5)], "roof")
    route = travel([box(3, 3.5, 4, 4.5, "box"), roof], (1, 4), (9, 4), delta=0.75)
    assert [(w.place, reason) for w, reason in route.dropped] == [
        ((3, 5.25), "inside roof"),
        ((4, 5.25), "inside roof"),
    ]
    route = travel([box(3, 0.75, 5, 1.25, "box")], (1, 1), (9, 1), delta=0.4, radius=0.25)
    assert {reason for _, reason in route.dropped} == {"nearer than 0.25 m to the wall"}


def test_no_way_is_told_as_what_it_is_with_the_obstacles() -> None:
    with pytest.raises(
        NoCentralPath, match=r"R1: the Central Algorithm finds no way past wall; .*not complete"
    ) as caught:
        travel([box(4, -1, 5, 7, "wall")], (1, 4), (9, 4), delta=2.0)
    assert [c.name for c in caught.value.crossed] == ["wall"]
    ell = Scene([(0, 0), (8, 0), (8, 2), (2, 2), (2, 8), (0, 8)], robots=[Robot("R1", (1, 7), (7, 1))])
    with pytest.raises(NoCentralPath, match="which its straight line leaves") as caught:
        central_path(ell, "R1")
    assert caught.value.crossed == ()


def test_start_is_goal() -> None:
    route = travel([box(4, 3, 6, 5)], (1, 4), (1, 4))
    assert (route.points.tolist(), route.length, route.free) == ([[1, 4]], 0.0, True)


def test_bad_input_is_told_in_one_line() -> None:
    for delta in (-0.1, math.nan, math.inf):
        with pytest.raises(SceneError, match="robot R1: delta must be a number of metres ≥ 0"):
            travel([], (1, 4), (9, 4), delta)
    with pytest.raises(SceneError, match="no robot R7; it has R1"):
        central_path(Scene((0, 0, 1, 1), robots=[Robot("R1", (0, 0), (1, 1))]), "R7")
    with pytest.raises(StartBlocked, match=r"robot R1: start \(1, 4\) lies inside obstacle O1"):
        travel([box(0, 3, 2, 5)], (1, 4), (9, 4))
    with pytest.raises(GoalBlocked, match=r"robot R1: goal \(9.5, 4\) is only 0.5 m from the wall but needs 0.75 m"):
        travel([], (1, 4), (9.5, 4), radius=0.75)


def test_obstacles_that_it_leaves_out_do_not_change_the_path() -> None:
    near = [box(4, 3, 6, 4.5, "box")]
    far: list[Obstacle] = [box(1, 7, 9, 7.5, "far"), Line([(1, 0.5), (9, 0.5)], 0.2, "line")]
    alone, among = travel(near, (1, 4), (9, 4)), travel([*far, *near], (1, 4), (9, 4))
    assert alone.points.tobytes() == among.points.tobytes()
    assert alone.roadmap.edges.tolist() == among.roadmap.edges.tolist()
