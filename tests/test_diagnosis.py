"""A team that found no plan is told who is in whose way, where, and what may help."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest
import shapely
from hypothesis import given, settings
from hypothesis import strategies as st

from taut.errors import NoPlanExists, NoPlanFound, TautError
from taut.freespace import FreeSpace
from taut.route import shortest_path
from taut.scene import Circle, Obstacle, Point, Polygon, Rectangle, Robot, Scene
from taut.team.diagnosis import Diagnosis, diagnose, narrowest, passage, suspects
from taut.team.prioritized import Round
from taut.team.safe_intervals import Failure
from taut.team.world import World

CORRIDOR = (0.0, 0.0, 14.0, 1.0)


def disc(name: str, start: Point, goal: Point, radius: float = 0.35, **more: object) -> Robot:
    return Robot(name, start, goal, radius, **more)  # type: ignore[arg-type]


def failed(n: int, *failures: Failure) -> Round:
    """A round in which the last robots failed."""
    return Round(tuple(range(n)), 1.0, (None,) * n, failures)


def of(scene: Scene, *failures: Failure) -> Diagnosis:
    return diagnose(World(scene), failed(len(scene.robots), *failures))


SWAP = Scene(CORRIDOR, robots=[disc("A", (1, 0.5), (13, 0.5)), disc("B", (13, 0.5), (1, 0.5))], gap=0.05)
FAILED_SWAP = Failure(1, (8.5, 0.5), 4.5, (0,))


# --- Who is in whose way ----------------------------------------------------------------------------------------------


def test_two_that_meet_head_on_are_told_with_the_room_they_have_and_need() -> None:
    found = of(SWAP, FAILED_SWAP)
    (block,) = found.blocks
    assert (block.robot, block.others, block.place, block.time) == ("B", ("A",), (8.5, 0.5), 4.5)
    assert found.cycles == (("A", "B"),)
    (narrow,) = found.narrow
    assert set(narrow.robots) == {"A", "B"}
    assert narrow.width == pytest.approx(1.0)
    assert narrow.needed == pytest.approx(1.45)
    assert narrow.between == ("the wall", "the wall")
    assert sorted([narrow.begin[0], narrow.end[0]]) == pytest.approx([1, 13], abs=0.4)
    assert any("a bay for" in mend for mend in found.helps)


def test_a_corridor_wide_enough_for_two_is_not_blamed() -> None:
    wide = replace_workspace(SWAP, (0, 0, 14, 1.46))
    assert of(wide, FAILED_SWAP).narrow == ()
    assert len(of(replace_workspace(SWAP, (0, 0, 14, 1.44)), FAILED_SWAP).narrow) == 1


def replace_workspace(scene: Scene, workspace: tuple[float, float, float, float]) -> Scene:
    return Scene(workspace, scene.obstacles, scene.robots, gap=scene.gap)


def test_two_that_go_the_same_way_do_not_meet_head_on() -> None:
    robots = [disc("A", (1, 0.5), (12, 0.5)), disc("B", (2, 0.5), (13, 0.5))]
    assert of(Scene(CORRIDOR, robots=robots), Failure(0, (3, 0.5), 2.0, (1,))).narrow == ()


def test_a_narrow_place_is_told_with_the_names_of_what_makes_it_narrow() -> None:
    walls: list[Obstacle] = [
        Rectangle(4, 0, 4, 4.4, name="shelf"),
        Polygon([(4, 5.6), (8, 5.6), (8, 10), (4, 10)], name="rack"),
    ]
    robots = [disc("A", (1, 5), (11, 5)), disc("B", (11, 5), (1, 5))]
    (narrow,) = of(Scene((0, 0, 12, 10), walls, robots), Failure(1, (8.5, 5), 2.0, (0,))).narrow
    assert sorted(narrow.between) == ["rack", "shelf"]
    assert narrow.width == pytest.approx(1.2)
    assert 4 < narrow.place[0] < 8
    assert all(4 - 0.35 <= x <= 8 + 0.35 for x in (narrow.begin[0], narrow.end[0]))  # discs touch the corners


def test_a_parked_robot_in_the_only_way_is_told() -> None:
    robots = [disc("walker", (1, 0.5), (13, 0.5)), disc("post", (7, 0.5), (7, 0.5))]
    found = of(Scene(CORRIDOR, robots=robots), Failure(0, (6, 0.5), 5.0, (1,)))
    (cut,) = found.cuts
    assert (cut.robot, cut.other, cut.at, cut.parked, cut.place) == ("post", "walker", "goal", True, (7, 0.5))
    assert found.helps == ("another goal for post, or at_goal: leave for it",)
    aside = replace(robots[1], start=(7, 3), goal=(7, 3))
    free = [robots[0], aside]
    assert of(Scene((0, 0, 14, 4), robots=free), Failure(0, (6, 0.5), 5.0, (1,))).cuts == ()


def test_one_that_can_be_gone_round_leaves_a_way() -> None:
    """It stands in one of two doors, on the shortest way; the other door is open."""
    walls = [Rectangle(4, 0, 1, 4.5), Rectangle(4, 5.5, 1, 2), Rectangle(4, 8.5, 1, 1.5)]
    robots = [disc("A", (1, 5), (9, 5)), disc("B", (4.5, 5), (4.5, 5))]
    failure = Failure(0, (3.5, 5), 3.0, (1,))
    assert of(Scene((0, 0, 10, 10), walls, robots), failure).cuts == ()
    closed = [walls[0], Rectangle(4, 5.5, 1, 4.5)]
    assert [c.robot for c in of(Scene((0, 0, 10, 10), closed, robots), failure).cuts] == ["B"]


def test_a_goal_in_the_mouth_of_a_dead_end_has_to_wait_and_a_start_to_be_left() -> None:
    robots = [disc("first", (3, 0.5), (11, 0.5)), disc("second", (1, 0.5), (13, 0.5))]
    found = of(Scene(CORRIDOR, robots=robots), Failure(1, (10, 0.5), 9.0, (0,)))
    assert {(c.robot, c.other, c.at) for c in found.cuts} == {("first", "second", "goal"), ("first", "second", "start")}
    assert found.cycles == ()


def test_a_robot_that_leaves_does_not_hold_its_goal() -> None:
    robots = [disc("first", (3, 0.5), (11, 0.5), at_goal="leave"), disc("second", (1, 0.5), (13, 0.5))]
    found = of(Scene(CORRIDOR, robots=robots), Failure(1, (10, 0.5), 9.0, (0,)))
    assert {c.at for c in found.cuts} == {"start"}


def test_robots_that_wait_in_a_circle_are_one_cycle() -> None:
    robots = [disc(f"R{k}", (2 + 4 * k, 2), (2 + 4 * k, 10)) for k in range(5)]
    waits = [Failure(k, (3, 3), 1.0, ((k + 1) % 3,)) for k in range(3)]
    found = of(Scene((0, 0, 20, 12), robots=robots), *waits, Failure(3, (3, 3), 1.0, (0,)))
    assert found.cycles == (("R0", "R1", "R2"),)


def test_pairs_under_suspicion_are_unordered_and_blockers_come_first() -> None:
    world = World(SWAP)
    assert suspects(world, failed(2, FAILED_SWAP)) == ((1, 0),)
    both = failed(2, FAILED_SWAP, Failure(0, (3, 0.5), 1.0, (1,)))
    assert len(suspects(world, both)) == 1
    assert suspects(world, failed(2)) == ()


# --- In words ---------------------------------------------------------------------------------------------------------


def test_every_sentence_is_one_line_that_ends_and_the_last_one_helps() -> None:
    for found in (of(SWAP, FAILED_SWAP), of(SWAP, replace(FAILED_SWAP, blockers=()))):
        assert len(found.sentences) >= 2
        assert all(line.endswith(".") and line.isprintable() for line in found.sentences)
        assert found.sentences[-1].startswith("What may help: ")
    text = " ".join(of(SWAP, FAILED_SWAP).sentences)
    assert "A and B wait for each other" in text
    assert "between the walls there are 1.00 m, two abreast need 1.45 m" in text


def test_where_nothing_is_known_more_time_is_all_that_may_help() -> None:
    assert of(SWAP, replace(FAILED_SWAP, blockers=())).helps == ("more rounds or seconds, or another seed",)


def test_errors_carry_the_diagnosis_line_by_line() -> None:
    found = NoPlanFound("none", ("A",), 1.0, (0, 0), ["a\nb", "c"])
    assert found.diagnosis == ("a\\nb", "c")
    assert NoPlanFound("none").diagnosis == ()
    exists = NoPlanExists("none exists", ("A", "B"), (1.0, 2.0), ["why"])
    assert (exists.robots, exists.place, exists.diagnosis) == (("A", "B"), (1.0, 2.0), ("why",))
    assert exists.exit_code == found.exit_code == 1
    assert str(exists) == exists.reason == "none exists"
    assert issubclass(NoPlanExists, TautError)


# --- How wide it is ---------------------------------------------------------------------------------------------------


@settings(max_examples=30, deadline=None)
@given(st.floats(0, math.tau), st.floats(0.5, 3), st.sampled_from([0.0, 0.1, 0.2]), st.floats(0.2, 0.8))
def test_a_corridor_is_as_wide_as_it_is_however_it_lies(angle: float, width: float, growth: float, at: float) -> None:
    c, s = math.cos(angle), math.sin(angle)
    corners = [(0.0, 0.0), (10.0, 0.0), (10.0, width), (0.0, width)]
    space = FreeSpace(Scene([(c * x - s * y, s * x + c * y) for x, y in corners]), growth)
    x, y = 4.0, growth + at * (width - 2 * growth)
    found, ends = passage(space, (c * x - s * y, s * x + c * y), (c, s))
    assert found == pytest.approx(width, rel=1e-9)
    assert math.dist(*ends) == pytest.approx(width - 2 * growth, rel=1e-9)


def test_the_narrowest_place_is_where_the_walls_are_nearest() -> None:
    """A funnel: half as wide at its far end."""
    space = FreeSpace(Scene([(0, 0), (10, 0), (10, 1), (0, 2)]))
    route = np.array([[1, 0.4], [9, 0.4]])
    (x, y), width = narrowest(space, route, route, 0.1)
    assert x == pytest.approx(9, abs=0.1)
    assert y == pytest.approx(0.4)
    assert width == pytest.approx(2 - x / 10)
    (x, _), width = narrowest(space, route, np.array([[3.0, 0.4], [3.0, 0.45]]), 0.5)
    assert 2.5 < x < 3.5
    assert width == pytest.approx(2 - x / 10)


@settings(max_examples=15, deadline=None)
@given(st.integers(0, 2**32 - 1))
def test_no_place_of_a_route_is_narrower_than_twice_its_distance_from_the_walls(seed: int) -> None:
    rng = np.random.default_rng(seed)
    obstacles = [Circle((x, y), 0.5) for x, y in rng.uniform(2, 8, (6, 2)).tolist()]
    scene = Scene((0, 0, 10, 10), obstacles)
    space = FreeSpace(scene, 0.1)
    route = shortest_path(space, (0.5, 0.5), (9.5, 9.5)).points
    place, width = narrowest(space, route, route, 1.0)
    away = min(math.dist(place, o.center) - o.radius for o in obstacles)
    away = min(away, *place, *(10 - p for p in place))
    assert shapely.LineString(route).distance(shapely.Point(place)) < 1e-9
    assert width >= 2 * away - 0.01
