"""The ready scenes are what their names and the thesis say, and can be driven."""

from __future__ import annotations

import math
import re
from collections.abc import Sequence
from importlib import resources
from itertools import pairwise

import numpy as np
import pytest
import shapely

from sound import core, distance, faults, hemmed_in
from taut.certificate import certify
from taut.contact import Contact
from taut.formats import load_scene
from taut.scene import Circle, Line, Point, Polygon, Rectangle, Scene
from taut.team import plan
from taut.validation import validate

NAMES = (
    "thesis-1",
    "thesis-2",
    "thesis-3",
    "appendix-d",
    "corridor-swap",
    "crossing-30",
    "warehouse-50",
    "office-20",
    "hospital-12",
    "mine-rescue-8",
    "search-20",
)
FLOORS = ("warehouse-50", "office-20", "hospital-12", "mine-rescue-8", "search-20")


def text(name: str) -> str:
    return (resources.files("taut.scenes") / f"{name}.yaml").read_text(encoding="utf-8")


def length(points: Sequence[Point]) -> float:
    return sum(math.dist(a, b) for a, b in pairwise(points))


def corner(scene: Scene, obstacle: str, number: int) -> Point:
    shape = next(o for o in scene.obstacles if o.name == obstacle)
    assert isinstance(shape, Polygon)
    return shape.points[number - 1]


@pytest.mark.parametrize("name", NAMES)
def test_a_ready_scene_loads_by_name_and_is_valid(name: str) -> None:
    scene = load_scene(name)
    assert scene.name == name
    validate(scene)


def test_every_file_is_listed_and_says_where_it_comes_from() -> None:
    files = {path.name for path in resources.files("taut.scenes").iterdir() if path.name.endswith(".yaml")}
    assert files == {f"{name}.yaml" for name in NAMES}
    for name in NAMES:
        assert text(name).startswith("# ")
        assert "\n# Source: " in text(name)


@pytest.mark.parametrize("name", NAMES)
def test_files_are_for_people_one_obstacle_or_robot_a_line(name: str) -> None:
    scene, lines = load_scene(name), text(name).splitlines()
    assert sum(line.startswith("  - {name: ") for line in lines) == len(scene.obstacles) + len(scene.robots)
    assert all(len(line) <= 160 for line in lines)


@pytest.mark.parametrize("name", NAMES)
def test_starts_and_goals_are_clear_and_connected(name: str) -> None:
    spare = (1.0, 0.0) if name.startswith(("thesis", "appendix")) else (1.02, 0.01)
    assert faults(load_scene(name), *spare) == []


@pytest.mark.parametrize("name", [*FLOORS, "crossing-30", "thesis-2", "thesis-3", "appendix-d"])
def test_every_robot_has_a_way_past_the_starts_and_goals_of_all_others(name: str) -> None:
    assert hemmed_in(load_scene(name)) == []


@pytest.mark.parametrize(
    ("name", "robots"),
    [
        ("crossing-30", 30),
        ("warehouse-50", 50),
        ("office-20", 20),
        ("hospital-12", 12),
        ("mine-rescue-8", 8),
        ("search-20", 20),
    ],
)
def test_the_team_has_the_size_in_the_name(name: str, robots: int) -> None:
    assert len(load_scene(name).robots) == robots


@pytest.mark.parametrize("name", ["thesis-1", "thesis-2", "thesis-3", "appendix-d"])
def test_robots_of_the_thesis_are_points_that_leave(name: str) -> None:
    scene = load_scene(name)
    assert scene.gap == 0.1
    assert scene.clearance == scene.headway == 0.0
    assert [robot.name for robot in scene.robots] == ["R1", "R2", "R3"]
    assert all(robot.radius == 0.0 and not scene.stays(robot) for robot in scene.robots)
    assert [o.name for o in scene.obstacles] == [f"O{k + 1}" for k in range(len(scene.obstacles))]


# Corners passed (obstacle, number in its list) and lengths: printed in the thesis (figures 5.1 to 5.11), and shortest.
PATHS = [
    ("thesis-1", 0, [("O1", 4), ("O2", 3), ("O4", 2)], 16.3829),
    ("thesis-1", 0, [("O2", 2)], 15.3445),
    ("thesis-1", 1, [("O1", 3), ("O3", 1), ("O5", 4)], 17.3043),
    ("thesis-1", 2, [("O6", 4), ("O3", 3), ("O6", 1), ("O5", 2)], 19.0931),
    ("thesis-1", 2, [("O3", 3), ("O5", 4)], 17.0388),
    ("thesis-2", 0, [("O1", 4), ("O3", 2), ("O6", 4), ("O3", 3), ("O6", 1)], 18.3975),
    ("thesis-2", 0, [("O1", 4), ("O3", 2), ("O3", 3), ("O6", 1)], 15.1336),
    ("thesis-2", 1, [("O5", 4), ("O3", 1), ("O1", 3)], 18.0197),
    ("thesis-2", 1, [("O5", 4), ("O3", 3)], 17.1757),
    ("thesis-2", 2, [("O1", 3), ("O3", 1), ("O4", 2), ("O2", 4)], 14.3277),
    ("thesis-2", 2, [("O1", 3), ("O3", 1), ("O2", 4)], 12.7351),
    ("thesis-3", 0, [], 11.1830),
    ("thesis-3", 1, [], 11.6248),
    ("thesis-3", 2, [], 11.3098),
]


@pytest.mark.parametrize(("name", "robot", "via", "expected"), PATHS)
def test_paths_of_the_thesis_are_free_and_have_their_lengths(
    name: str, robot: int, via: list[tuple[str, int]], expected: float
) -> None:
    scene = load_scene(name)
    points = [scene.robots[robot].start, *(corner(scene, *at) for at in via), scene.robots[robot].goal]
    assert length(points) == pytest.approx(expected, abs=5.1e-5)
    inside = shapely.union_all([core(o) for o in scene.obstacles]).buffer(-1e-9)
    assert not shapely.LineString(points).intersects(inside)


def test_scenes_1_and_2_share_their_obstacles() -> None:
    assert load_scene("thesis-1").obstacles == load_scene("thesis-2").obstacles


def test_the_robots_of_scene_1_share_one_goal() -> None:
    assert {robot.goal for robot in load_scene("thesis-1").robots} == {(5.0, 16.0)}


def test_appendix_d_is_the_scene_of_the_thesis() -> None:
    scene = load_scene("appendix-d")
    *boxes, disc = scene.obstacles
    expected = [(5, 3, 4, 2), (13, 5, 2, 5), (0.9, 3.7, 2, 5), (7.2, 12.7, 5, 2)]
    assert [(b.x, b.y, b.width, b.height) for b in boxes if isinstance(b, Rectangle)] == expected
    assert isinstance(disc, Circle)
    assert (disc.center, disc.radius) == ((2.5, 12), 2)
    assert [r.start for r in scene.robots] == [(3, 2.1), (4.5, 15.5), (10.2, 2.3)]
    assert [r.goal for r in scene.robots] == [(12.7, 12), (11.8, 3), (1.2, 10)]


def test_scene_3_says_that_it_is_reconstructed() -> None:
    assert "damaged list" in text("thesis-3")


def test_in_corridor_swap_robots_change_places_and_only_the_bay_lets_them_pass() -> None:
    scene = load_scene("corridor-swap")
    a, b = scene.robots
    assert (a.start, a.goal) == (b.goal, b.start)
    apart = scene.separation(a, b)

    def may_pass(x: float) -> bool:
        """Tell whether both discs fit side by side across the corridor at x."""
        across = shapely.LineString([(x, -1), (x, 3)]).intersection(shapely.Polygon(scene.workspace))
        return bool(across.length >= apart + a.radius + b.radius)

    xs = np.linspace(0.1, 13.9, 139)
    wide = xs[[may_pass(float(x)) for x in xs]]
    assert wide.max() - wide.min() >= 2 * a.radius + 0.2
    assert len(wide) < 20
    # R2 is out of the way before R1 comes by
    assert abs(b.start[0] - wide.mean()) + 1.5 < abs(a.start[0] - wide.mean()) - apart


def test_in_crossing_30_the_hall_is_empty_and_every_line_passes_the_middle() -> None:
    scene = load_scene("crossing-30")
    assert scene.obstacles == ()
    middle = shapely.Polygon(scene.workspace).centroid
    assert all(shapely.LineString([r.start, r.goal]).distance(middle) < 1.0 for r in scene.robots)


def test_shelves_of_the_warehouse_leave_aisles_for_one_and_for_two_robots() -> None:
    scene = load_scene("warehouse-50")
    shelves = {o.name: o for o in scene.obstacles if o.name.startswith("shelf-")}
    rows = [shelves[f"shelf-{row}1"] for row in "ABCDEFG"]
    widths = [round(float(core(a).distance(core(b))), 6) for a, b in pairwise(rows)]
    one = 2 * scene.growth(scene.robots[0])
    two = one + scene.separation(scene.robots[0], scene.robots[0])
    assert {width >= two for width in widths} == {True, False}
    assert all(width >= one * 1.02 + 0.01 for width in widths)


@pytest.mark.parametrize("name", ["office-20", "hospital-12"])
def test_doors_are_as_wide_as_the_walls_say(name: str) -> None:
    """Gaps between the pieces of the corridor walls are doors of 1 to 1.6 m."""
    walls = [o for o in load_scene(name).obstacles if isinstance(o, Line) and re.match(r"wall-(north|south)", o.name)]
    doors = []
    for a, b in pairwise(walls):
        if a.name.rpartition("-")[0] == b.name.rpartition("-")[0]:
            doors.append(b.points[0][0] - a.points[-1][0] - (a.width + b.width) / 2)
    assert len(doors) >= 8
    assert all(0.999 <= door <= 1.601 for door in doors)


def test_hospital_robots_differ_in_size_speed_and_clearance() -> None:
    robots = load_scene("hospital-12").robots
    assert len({robot.radius for robot in robots}) == 3
    assert len({robot.speed for robot in robots}) == 3
    assert {robot.clearance for robot in robots} == {None, 0.1}


def test_the_mine_has_a_base_that_stays_and_a_chain_in_which_each_sees_the_next() -> None:
    scene = load_scene("mine-rescue-8")
    base = scene.robots[0]
    assert (base.name, base.start) == ("base", base.goal)
    mine = shapely.Polygon(scene.workspace).difference(shapely.union_all([core(o) for o in scene.obstacles]))
    sights = [shapely.LineString([a.goal, b.goal]) for a, b in pairwise(scene.robots)]
    assert all(sight.length <= 12.7 and mine.covers(sight) for sight in sights)
    assert all(mine.covers(shapely.LineString([base.start, robot.start])) for robot in scene.robots[1:])


def test_in_search_20_a_line_of_robots_goes_from_wall_to_wall() -> None:
    scene = load_scene("search-20")
    for a, b in pairwise(scene.robots):
        assert b.start == (a.start[0], a.start[1] + 1.5)
        assert b.goal == (a.goal[0], a.goal[1] + 1.5)
    assert all(robot.start[1] == robot.goal[1] for robot in scene.robots)


@pytest.mark.parametrize(
    ("name", "demand"), [("mine-rescue-8", Contact(14, sight=True)), ("search-20", Contact(4, k=2))]
)
def test_the_contact_that_a_scene_speaks_of_can_be_kept(name: str, demand: Contact) -> None:
    result = plan(load_scene(name), contact=demand)
    assert result.certificate.ok
    assert result.plan.claims == {"contact": demand.claim}


def test_the_rescuer_runs_ahead_unless_contact_is_asked_for() -> None:
    found = certify(plan(load_scene("mine-rescue-8")).plan, contact=14)
    assert [problem.robots for problem in found.problems] == [("rescuer",)]


@pytest.mark.parametrize("name", FLOORS)
def test_things_with_names_do_not_stand_in_each_other(name: str) -> None:
    """Only walls meet; furniture keeps apart."""
    solid = {o.name: core(o).buffer(o.own_radius) for o in load_scene(name).obstacles}
    names = list(solid)
    tree = shapely.STRtree(list(solid.values()))
    pairs = tree.query(list(solid.values()), predicate="intersects").T
    met = {
        (names[a], names[b])
        for a, b in pairs
        if a < b and not (names[a].startswith("wall-") and names[b].startswith("wall-"))
    }
    assert met <= {("desk-106a", "desk-106b")}


def test_the_checks_notice_a_blocked_start_and_a_sealed_robot() -> None:
    scene = load_scene("office-20")
    robot = scene.robots[0]
    pillar = Circle(robot.start, 0.1, "in-the-way")
    blocked = Scene(scene.workspace, (*scene.obstacles, pillar), scene.robots, clearance=0.05, gap=0.05)
    assert distance(robot.start, pillar) < 0
    assert any("in-the-way" in fault for fault in faults(blocked))
    assert hemmed_in(load_scene("corridor-swap")) == ["R1", "R2"]
