"""Random scenes are repeatable, valid, as asked for, and refused in one line when they cannot be met."""

from __future__ import annotations

import json
import math
from dataclasses import replace
from itertools import combinations
from typing import Any

import numpy as np
import pytest
import shapely
from hypothesis import given, settings
from hypothesis import strategies as st

from sound import core, faults, hemmed_in
from taut.errors import SceneError
from taut.freespace import FreeSpace
from taut.generate import random_scene, random_warehouse
from taut.route import shortest_path
from taut.scene import Circle, Line, Polygon, Rectangle, Scene
from taut.validation import validate


def numbers(scene: Scene) -> str:
    """All numbers of the scene, bit for bit."""
    obstacles = [[o.name, type(o).__name__, o.core.tolist(), o.own_radius] for o in scene.obstacles]
    robots = [[r.name, r.start, r.goal, r.radius, r.speed] for r in scene.robots]
    return json.dumps([scene.workspace, obstacles, robots])


def share_covered(scene: Scene) -> float:
    solids = [core(o).buffer(o.own_radius, quad_segs=32) for o in scene.obstacles]
    return float(shapely.area(solids).sum()) / float(shapely.Polygon(scene.workspace).area)


def test_the_same_arguments_give_the_same_scene_bit_for_bit() -> None:
    asked: dict[str, Any] = {"robots": 12, "obstacles": 25, "radius": (0.1, 0.4), "speed": (0.5, 2.0)}
    first = random_scene(seed=7, **asked)
    assert numbers(random_scene(seed=7, **asked)) == numbers(first)
    assert random_scene(seed=7, **asked) == first
    assert numbers(random_scene(seed=8, **asked)) != numbers(first)


def test_the_global_generator_of_numpy_is_neither_used_nor_moved() -> None:
    np.random.seed(1)  # noqa: NPY002
    before = np.random.get_state()[1].tolist()  # type: ignore[index]  # noqa: NPY002
    random_scene(seed=3)
    assert np.random.get_state()[1].tolist() == before  # type: ignore[index]  # noqa: NPY002


def test_coordinates_are_whole_millimetres() -> None:
    scene = random_scene(seed=5)
    values = [c for r in scene.robots for c in (*r.start, *r.goal)]
    values += [c for o in scene.obstacles if isinstance(o, Polygon | Line) for p in o.points for c in p]
    assert all(value == round(value, 3) for value in values)


@settings(deadline=None, max_examples=25)
@given(
    seed=st.integers(0, 2**32),
    robots=st.integers(0, 10),
    obstacles=st.integers(0, 25),
    radius=st.sampled_from([0.0, 0.05, 0.3, (0.1, 0.8), (0.0, 0.5)]),
    clearance=st.sampled_from([0.0, 0.1]),
    gap=st.sampled_from([0.01, 0.05, 0.5]),
    well_formed=st.booleans(),
)
def test_a_random_scene_is_valid(
    seed: int,
    robots: int,
    obstacles: int,
    radius: float | tuple[float, float],
    clearance: float,
    gap: float,
    well_formed: bool,
) -> None:
    scene = random_scene(robots, obstacles, seed, radius=radius, clearance=clearance, gap=gap, well_formed=well_formed)
    assert len(scene.robots) == robots
    assert len(scene.obstacles) == obstacles
    assert faults(scene, 1.02, 0.005) == []
    if well_formed:
        assert hemmed_in(scene) == []


@pytest.mark.parametrize("seed", range(5))
def test_validation_has_nothing_to_remark(seed: int) -> None:
    scene = random_scene(10, 25, seed, radius=(0.0, 0.5), clearance=0.1)
    assert validate(scene) == ()


@pytest.mark.parametrize("seed", range(4))
def test_the_widest_robot_passes_between_obstacles_and_along_the_wall(seed: int) -> None:
    scene = random_scene(4, 30, seed, radius=(0.2, 0.6), clearance=0.1, density=0.15)
    needed = 2 * max(scene.growth(robot) for robot in scene.robots)
    wall = shapely.Polygon(scene.workspace).exterior
    for o in scene.obstacles:
        assert core(o).distance(wall) - o.own_radius > needed
        assert shapely.Polygon(scene.workspace).contains(core(o))
    for a, b in combinations(scene.obstacles, 2):
        assert core(a).distance(core(b)) - a.own_radius - b.own_radius > needed


@pytest.mark.parametrize("seed", range(3))
def test_starts_keep_away_from_goals_too(seed: int) -> None:
    scene = random_scene(40, 10, seed, gap=0.1)
    for a, b in combinations(scene.robots, 2):
        assert math.dist(a.start, b.goal) > 1.1 * scene.separation(a, b)
        assert math.dist(a.goal, b.start) > 1.1 * scene.separation(a, b)
    assert min(math.dist(r.start, r.goal) for r in scene.robots) > 0.2 * scene.workspace[2][0]


@pytest.mark.parametrize("seed", range(3))
def test_in_a_full_hall_well_formed_scenes_leave_everyone_a_way(seed: int) -> None:
    scene = random_scene(30, 12, seed, size=16, density=0.1, radius=(0.15, 0.3), well_formed=True)
    assert hemmed_in(scene) == []


def test_well_formed_is_not_for_nothing() -> None:
    """The same halls without the promise do hem robots in: the check can fail."""
    scenes = [random_scene(30, 6, seed, size=14, density=0.1, radius=0.35) for seed in range(6)]
    assert any(hemmed_in(scene) for scene in scenes)


@pytest.mark.parametrize("robots", [10, 200])
def test_a_chosen_hall_is_roomy(robots: int) -> None:
    scene = random_scene(robots, 20, 2)
    hall = float(shapely.Polygon(scene.workspace).area)
    discs = sum(math.pi * r.radius**2 for r in scene.robots)
    assert discs <= 0.05 * hall * (1 - share_covered(scene))


@pytest.mark.parametrize(("size", "expected"), [(25, (25, 25)), ((30, 12.5), (30, 12.5))])
def test_a_given_hall_is_kept(size: Any, expected: tuple[float, float]) -> None:
    assert random_scene(5, 5, size=size).workspace[2] == expected


@pytest.mark.parametrize("size", [None, 40])
@pytest.mark.parametrize("density", [0.05, 0.2])
def test_obstacles_cover_the_share_asked_for(density: float, size: float | None) -> None:
    assert share_covered(random_scene(5, 40, 1, density=density, size=size)) == pytest.approx(density, rel=0.01)


@pytest.mark.parametrize(
    ("shape", "kind"), [("polygon", Polygon), ("rectangle", Rectangle), ("circle", Circle), ("line", Line)]
)
def test_only_shapes_asked_for_are_drawn(shape: str, kind: type) -> None:
    scene = random_scene(2, 12, 1, shapes=(shape,), obstacle_size=(0.5, 2.0))
    assert all(isinstance(o, kind) for o in scene.obstacles)
    spans = [shapely.minimum_bounding_radius(core(o)) * 2 + 2 * o.own_radius for o in scene.obstacles]
    assert max(spans) <= 2.0 * 1.2
    if kind is Polygon:
        assert all(core(o).area == pytest.approx(core(o).convex_hull.area, rel=1e-2) for o in scene.obstacles)


def test_nonconvex_obstacles_are_simple_and_not_convex() -> None:
    for o in random_scene(2, 20, 1, shapes=("nonconvex",)).obstacles:
        assert core(o).is_valid
        assert core(o).area < 0.95 * core(o).convex_hull.area


def test_ranges_bound_radii_and_speeds() -> None:
    robots = random_scene(50, 0, 1, radius=(0.1, 0.5), speed=(0.5, 2.0)).robots
    assert all(0.1 <= r.radius <= 0.5 and 0.5 <= r.speed <= 2.0 for r in robots)
    assert len({r.radius for r in robots}) > 40
    assert len({r.speed for r in robots}) > 40


def test_one_value_is_given_to_all_exactly() -> None:
    assert {(r.radius, r.speed) for r in random_scene(5, 3, radius=1 / 3, speed=0.7).robots} == {(1 / 3, 0.7)}


def test_the_fields_of_the_scene_are_passed_on() -> None:
    scene = random_scene(2, 2, 4, clearance=0.2, gap=0.3, headway=0.5, at_goal="leave", name="mine")
    assert (scene.clearance, scene.gap, scene.headway, scene.at_goal, scene.name) == (0.2, 0.3, 0.5, "leave", "mine")
    assert random_scene(2, 3, 4).name == "random-2-3-4"


def test_toy_halls_work_too() -> None:
    scene = random_scene(3, 5, 0, size=0.1, radius=0.002, obstacle_size=0.01, gap=0.0002)
    assert faults(scene) == []


def test_a_sliver_of_a_hall_is_refused_in_one_line() -> None:
    sliver: dict[str, Any] = {"size": (1e-6, 1e7), "obstacle_size": 1e-9, "radius": 1e-9, "clearance": 1e-9, "gap": 0}
    for seed in range(3):
        with pytest.raises(SceneError):
            random_scene(3, 1, seed, **sliver)


def test_large_scenes_are_made() -> None:
    scene = random_scene(robots=1000, obstacles=400, size=200, seed=1)
    starts = shapely.points([r.start for r in scene.robots])
    goals = shapely.points([r.goal for r in scene.robots])
    tree = shapely.STRtree([core(o).buffer(o.own_radius) for o in scene.obstacles])
    for ends in (starts, goals):
        assert tree.query(ends, predicate="dwithin", distance=0.3).size == 0
        assert shapely.STRtree(ends).query(ends, predicate="dwithin", distance=0.65).shape[1] == len(ends)


@pytest.mark.parametrize(
    ("asked", "word"),
    [
        ({"robots": -1}, "robots"),
        ({"robots": 2.5}, "robots"),
        ({"robots": 10**9}, "robots must be at most"),
        ({"obstacles": True}, "obstacles"),
        ({"seed": -1}, "seed"),
        ({"radius": -0.1}, "radius"),
        ({"radius": (0.5, 0.1)}, "radius"),
        ({"radius": (0.1, 0.2, 0.3)}, "radius"),
        ({"radius": "wide"}, "radius"),
        ({"radius": 0.0, "gap": 0.0}, "gap"),
        ({"speed": 0}, "speed"),
        ({"speed": math.inf}, "speed"),
        ({"clearance": -1}, "clearance"),
        ({"gap": math.nan}, "gap"),
        ({"headway": -1}, "headway"),
        ({"at_goal": "vanish"}, "at_goal"),
        ({"obstacle_size": 0}, "obstacle_size"),
        ({"size": 0}, "size"),
        ({"size": (1, 2, 3)}, "size"),
        ({"size": math.nan}, "size"),
        ({"size": 1e300}, r"size must be between 1e-06 and 1e\+07 m, got 1e\+300"),
        ({"size": (10, 1e-7)}, "size must be between"),
        ({"radius": 1e300}, "radius must be between"),
        ({"radius": (0, 1e8)}, "radius must be between"),
        ({"speed": 1e-320}, "speed must be between"),
        ({"gap": 1e300}, "gap must be between"),
        ({"clearance": 1e300}, "clearance must be between"),
        ({"clearance": math.inf}, "clearance"),
        ({"headway": 1e300}, "headway must be between"),
        ({"obstacle_size": 1e-300}, "obstacle_size must be between"),
        ({"density": 1e-300}, "density must be at least"),
        ({"radius": 1e7, "robots": 1000}, "need a hall of"),
        ({"size": 1e7, "obstacle_size": 1e-9, "seed": 1}, "too far apart"),
        ({"density": 0}, "density"),
        ({"density": 1.0}, "density"),
        ({"density": 0.1, "obstacles": 0}, "density"),
        ({"shapes": ("blob",)}, "blob"),
        ({"shapes": ()}, "shapes"),
    ],
)
def test_parameters_out_of_range_are_refused(asked: dict[str, Any], word: str) -> None:
    with pytest.raises(SceneError, match=word) as caught:
        random_scene(**asked)
    assert "\n" not in str(caught.value)


@pytest.mark.parametrize(
    ("asked", "words"),
    [
        ({"robots": 60, "obstacles": 0, "size": 6}, r"robots fit into a hall of 6 × 6 m"),
        ({"robots": 100_000, "obstacles": 0, "size": 10}, r"robots fit into a hall of 10 × 10 m"),
        ({"robots": 2, "obstacles": 0, "size": 3, "radius": 1.6}, r"does not fit into a hall of 3 × 3 m"),
        ({"robots": 1, "obstacles": 60, "size": 15}, r"obstacles (do not )?fit into a hall of 15 × 15 m"),
        ({"robots": 1, "obstacles": 2000, "size": 10}, r"2000 obstacles do not fit into a hall of 10 × 10 m"),
        ({"robots": 5, "obstacles": 20, "density": 0.8}, r"obstacles"),
        ({"robots": 70, "obstacles": 0, "size": 11.5, "well_formed": True}, r"70 robots do not fit|robots fit"),
    ],
)
def test_what_does_not_fit_is_said_in_one_line(asked: dict[str, Any], words: str) -> None:
    with pytest.raises(SceneError, match=words) as caught:
        random_scene(**asked)
    assert "\n" not in str(caught.value)
    assert "take a larger size" in str(caught.value)


@pytest.mark.parametrize(("robots", "seed"), [(1, 0), (2, 3), (7, 1), (60, 2)])
def test_in_a_warehouse_nobody_can_pass_and_everybody_has_a_way_past_all_ends(robots: int, seed: int) -> None:
    scene = random_warehouse(robots, seed)
    assert validate(scene) == ()
    assert scene == random_warehouse(robots, seed)
    first = scene.obstacles[0]
    assert isinstance(first, Rectangle)
    assert first.x < 4 * scene.robots[0].radius  # so wide is an aisle
    discs = [
        Circle(r.start if k == 0 else r.goal, 2 * r.radius + scene.gap - r.radius, name=f"{r.name} {k}")
        for r in scene.robots
        for k in range(2)
    ]
    for robot in scene.robots[:7]:
        kept = [disc for disc in discs if not disc.name.startswith(f"{robot.name} ")]
        apart = FreeSpace.of(replace(scene, obstacles=(*scene.obstacles, *kept)), robot)
        assert shortest_path(apart, robot.start, robot.goal).length > 0


@pytest.mark.parametrize(
    ("asked", "message"),
    [
        ({"robots": 0}, "robots must be at least 1"),
        ({"robots": 2.5}, "robots must be a whole number"),
        ({"aisle": 0.6}, "aisle is 0.6 m wide, a robot with its clearance needs over 0.6 m"),
        ({"cross": 0.1}, "cross is 0.1 m wide"),
        ({"shelf": (1, 0.5)}, "shelves of 0.5 m are too short"),
        ({"shelf": 3}, "shelf must be"),
        ({"radius": 0}, "radius must be above 0"),
        ({"gap": -1}, "gap must be 0 or more"),
    ],
)
def test_a_warehouse_that_cannot_be_is_refused(asked: dict[str, Any], message: str) -> None:
    with pytest.raises(SceneError, match=message):
        random_warehouse(**asked)
