"""Whole teams get certified plans or the right refusal; the same input gives the same plan."""

from __future__ import annotations

import json
import math
import subprocess
import sys
from collections.abc import Sequence
from dataclasses import replace
from hashlib import sha256
from itertools import combinations, islice, pairwise

import numpy as np
import pytest
from hypothesis import assume, example, given, settings

from strategies import team_scenes
from taut.certificate import certify
from taut.errors import NoPath, NoPlanExists, NoPlanFound, SceneError, TautError
from taut.formats import load_scene, plan_from_dict, plan_to_dict, scene_names
from taut.freespace import FreeSpace
from taut.motion import Plan
from taut.route import shortest_path
from taut.scene import Circle, Line, Obstacle, Point, Polygon, Rectangle, Robot, Scene
from taut.team import Result, plan
from taut.team.methods import METHODS
from taut.team.prioritized import MOST_ROUNDS, rounds
from taut.team.world import World
from zoo import ZOO, Entry

CORRIDOR = (0.0, 0.0, 14.0, 1.0)

THESIS: dict[str, list[tuple[float, list[Point]]]] = {
    "thesis-1": [
        (15.3445, [(2, 1), (3.3, 4.8), (5, 16)]),
        (17.3043, [(8.7, 0.3), (7.8, 4), (5, 6), (4.5, 12.6), (5, 16)]),
        (17.0388, [(11, 1), (9, 7.5), (4.5, 12.6), (5, 16)]),
    ],
    "thesis-2": [
        (15.1336, [(3, 1), (4.5, 4), (7.5, 6), (9, 7.5), (10, 10), (12, 12.7)]),
        (17.1757, [(3.4, 16), (4.5, 12.6), (9, 7.5), (11, 1)]),
        (12.7351, [(8.7, 0.3), (7.8, 4), (5, 6), (2, 8.5), (0.5, 9)]),
    ],
    "thesis-3": [
        (11.1830, [(10.6, 4), (1.5, 10.5)]),
        (11.6248, [(9.5, 11.44), (1, 3.51)]),
        (11.3098, [(6.2, 1.38), (11.65, 11.29)]),
    ],
}


def length(points: Sequence[Point]) -> float:
    return math.fsum(math.dist(a, b) for a, b in pairwise(points))


def check(result: Result) -> Plan:
    """Check what every plan promises, and return it."""
    found = result.plan
    scene = found.scene
    assert result.certificate.ok, result.certificate.problems
    assert certify(found, scene).ok
    assert found.certificate == result.certificate.as_dict()
    for robot, trajectory, shortest in zip(scene.robots, found.trajectories, result.shortest, strict=True):
        slack = scene.tol * 4
        assert math.dist(robot.start, robot.goal) <= shortest + slack
        if robot.start != robot.goal:
            assert trajectory.arrival >= robot.start_time + (shortest - slack) / robot.speed
        assert trajectory.length >= shortest - slack
        assert (trajectory.points[0] == robot.start).all()
        assert math.dist(trajectory.points[-1], robot.goal) <= scene.tol
    assert found.lower_bound is not None
    assert found.lower_bound["model"] == "plane"
    bound = sum(s / r.speed for s, r in zip(result.shortest, scene.robots, strict=True))
    assert found.lower_bound["value"] == pytest.approx(bound, rel=1e-12)
    assert found.sum_of_costs >= bound * (1 - 1e-9)
    return found


def digest(found: Plan) -> str:
    """Every bit of the stamps, the order and the rounds."""
    parts = [t.stamps.tobytes() for t in found.trajectories]
    return sha256(b"|".join([*parts, repr((found.planner["order"], found.planner["rounds"])).encode()])).hexdigest()


def disc(name: str, start: Point, goal: Point, radius: float = 0.35, **more: object) -> Robot:
    return Robot(name, start, goal, radius, **more)  # type: ignore[arg-type]


def hall(*robots: Robot, **more: object) -> Scene:
    return Scene((0, 0, 20, 20), robots=robots, **more)  # type: ignore[arg-type]


# --- The thesis and the ready scenes ----------------------------------------------------------------------------------


@pytest.mark.parametrize("name", THESIS)
def test_thesis_scenes_have_the_shortest_ways_worked_out_by_hand(name: str) -> None:
    scene = load_scene(name)
    result = plan(scene)
    check(result)
    for robot, shortest, (printed, corners) in zip(scene.robots, result.shortest, THESIS[name], strict=True):
        assert (robot.start, robot.goal) == (corners[0], corners[-1])
        assert shortest == pytest.approx(length(corners), abs=1e-9)
        assert shortest == pytest.approx(printed, abs=1e-4)
        route = shortest_path(FreeSpace.of(scene, robot), robot.start, robot.goal)
        assert [tuple(p) for p in route.points.tolist()] == corners


@pytest.mark.parametrize("name", scene_names())
def test_ready_scenes_plan_and_certify(name: str) -> None:
    scene = load_scene(name)
    found = check(plan(scene))
    assert [t.name for t in found.trajectories] == [r.name for r in scene.robots]
    assert found.scene == scene


def test_two_change_ends_of_a_corridor_by_way_of_its_bay() -> None:
    """Nobody can pass in the corridor, so at some time one robot is in the bay."""
    result = plan(load_scene("corridor-swap"))
    found = check(result)
    high = {t.name: float(t.points[:, 1].max()) for t in found.trajectories}
    assert max(high.values()) > 1.0
    assert found.sum_of_costs < 32
    assert sum(bool(why) for why in result.detours) >= 1


# --- The zoo ----------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("entry", ZOO, ids=str)
def test_zoo_scenes_plan_or_are_refused_for_the_right_reason(entry: Entry) -> None:
    scene = entry.scene
    if not scene.robots:
        with pytest.raises(SceneError, match="no robots"):
            plan(scene)
        return
    cut_off = [name for name, way in entry.reachable.items() if not way]
    if cut_off:
        with pytest.raises(NoPath) as caught:
            plan(scene)
        assert caught.value.robot in cut_off
    else:
        check(plan(scene))


@pytest.mark.parametrize("entry", [e for e in ZOO if not all(e.reachable.values())], ids=str)
def test_zoo_robots_with_a_way_plan_without_the_others(entry: Entry) -> None:
    keep = tuple(r for r in entry.scene.robots if entry.reachable[r.name])
    if keep:
        check(plan(replace(entry.scene, robots=keep)))


# --- The same input gives the same plan -------------------------------------------------------------------------------

DEAD_END = Scene(
    CORRIDOR, robots=[disc("R1", (1, 0.5), (13, 0.5)), disc("R2", (13, 0.5), (1, 0.5))], gap=0.05, name="dead end"
)

# they cannot pass here either, but by so little that no proof is found
TIGHT = Scene((0, 0, 14, 1.4495), robots=DEAD_END.robots, gap=0.05, name="tight")

CROWD = Scene(
    (0, 0, 4, 4),
    robots=[
        Robot(f"R{k}", (0.5 + k % 4, 0.5 + k // 4), (3.5 - k % 4, 3.5 - k // 4), 0.25) for k in range(12)
    ],
    gap=0.02,
)  # fmt: skip


def outcome(scene: Scene) -> str:
    try:
        return digest(plan(scene, "repair", rounds=3).plan)
    except (NoPlanExists, NoPlanFound) as error:
        return f"{error.robots} {error.place}"


REPEATED = {"crossing-30": None, "office-20": None, "crowd": CROWD}


def repeated(name: str) -> Scene:
    return REPEATED[name] or load_scene(name)


@pytest.mark.parametrize("name", REPEATED)
def test_the_same_input_gives_the_same_plan(name: str, monkeypatch: pytest.MonkeyPatch) -> None:
    """Twice here, with another number of threads, and in a process of its own."""
    scene = repeated(name)
    first = outcome(scene)
    assert outcome(scene) == first
    monkeypatch.setattr("os.cpu_count", lambda: 5)
    assert outcome(scene) == first
    code = f"import sys; sys.path[:0] = {sys.path!r}; import test_team as t; print(t.outcome(t.repeated({name!r})))"
    fresh = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert fresh.stdout.strip() == first


def tried_orders(seed: int) -> list[tuple[int, ...]]:
    """Orders tried, in turn, for four robots of which two can never pass each other."""
    team = [*DEAD_END.robots, disc("C", (5, 0.5), (7, 0.5)), disc("D", (9, 0.5), (3, 0.5))]
    world = World(replace(DEAD_END, robots=tuple(team)))
    return [r.order for r in islice(rounds(world, range(4), np.random.default_rng(seed)), 60)]


def test_a_cycle_of_orders_is_broken_by_shuffles_that_depend_on_the_seed_alone() -> None:
    orders = tried_orders(0)
    assert orders == tried_orders(0)
    assert orders != tried_orders(1)
    assert all(sorted(order) == [0, 1, 2, 3] for order in orders)
    assert len(set(orders)) > 4


def test_repeating_the_rounds_that_a_plan_records_repeats_the_plan() -> None:
    scene = load_scene("hospital-12")
    found = plan(scene, seconds=1.0).plan
    done = found.planner["rounds"]
    assert isinstance(done, int)
    assert digest(plan(scene, rounds=done).plan) == digest(found)


# --- Options ----------------------------------------------------------------------------------------------------------

FOUR = hall(
    disc("far", (1, 1), (19, 19)),
    disc("near", (5, 10), (8, 10)),
    disc("slow", (1, 15), (9, 15), speed=0.25),
    disc("mid", (1, 5), (11, 5)),
)


@pytest.mark.parametrize(
    ("order", "expected"),
    [
        ("given", ["far", "near", "slow", "mid"]),
        ("shortest", ["near", "mid", "far", "slow"]),  # by time, not by length
        ("longest", ["slow", "far", "mid", "near"]),
    ],
)
def test_orders(order: str, expected: list[str]) -> None:
    found = check(plan(FOUR, order=order))  # type: ignore[arg-type]
    assert found.planner["order"] == expected
    assert (found.planner["method"], found.planner["rounds"], found.planner["seed"]) == ("prioritized", 1, 0)


def test_who_is_first_in_order_is_not_held_up() -> None:
    crossing = hall(disc("A", (2, 10), (18, 10)), disc("B", (10, 1.5), (10, 18.5)))
    for order, first in (("given", 0), ("shortest", 0), ("longest", 1)):
        result = plan(crossing, order=order)  # type: ignore[arg-type]
        found = check(result)
        late = [t.arrival - s > 1e-9 for t, s in zip(found.trajectories, result.shortest, strict=True)]
        assert late == [first == 1, first == 0]
        assert [bool(why) for why in result.detours] == late
        assert f"gives way to {crossing.robots[first].name} near (" in result.detours[1 - first]


@pytest.mark.parametrize(
    ("options", "said"),
    [
        ({"method": "magic"}, "method 'magic' is not one of prioritized"),
        ({"order": "tallest"}, "order 'tallest' is not one of shortest, longest, given"),
        ({"rounds": 0, "method": "prioritized"}, "rounds must be at least 1, got 0"),
        ({"rounds": -3}, "rounds must be at least 0, got -3"),
        ({"seconds": 0}, "seconds must be positive, got 0"),
        ({"seconds": -1.0}, "seconds must be positive"),
        ({"seconds": math.nan}, "seconds must be positive"),
        ({"seed": -1}, "seed"),
        ({"rounds": 2.5}, "rounds"),
    ],
)
def test_unknown_options_are_refused(options: dict[str, object], said: str) -> None:
    with pytest.raises(SceneError, match=said):
        plan(FOUR, **options)  # type: ignore[arg-type]


def test_no_robots_are_refused() -> None:
    with pytest.raises(SceneError, match="no robots"):
        plan(hall())


# --- When there is no plan --------------------------------------------------------------------------------------------


def test_two_that_provably_cannot_pass_are_named_with_the_place_and_its_width() -> None:
    for method in METHODS:
        with pytest.raises(NoPlanExists, match=r"R\d and R\d cannot pass each other") as caught:
            plan(DEAD_END, method)
        assert set(caught.value.robots) == {"R1", "R2"}
        assert "1.00 m wide, two abreast need 1.45 m" in str(caught.value)


@pytest.mark.parametrize("most", [1, 5, None])
def test_two_that_do_not_pass_are_named_with_time_and_place(most: int | None) -> None:
    with pytest.raises(NoPlanFound) as caught:
        plan(TIGHT, "prioritized", rounds=most)
    error = caught.value
    assert sorted(error.robots) == ["R1", "R2"]
    assert error.place is not None
    assert error.time is not None
    assert 0 <= error.time < 60
    assert 0 <= error.place[0] <= 14
    assert 0 <= error.place[1] <= 1.45
    assert any("head-on" in line or "wait for each other" in line for line in error.diagnosis)
    for word in (f"robot {error.robots[0]}", f"in its way: {error.robots[1]}", f"t = {error.time:.2f} s"):
        assert word in str(error)
    assert f"({error.place[0]:.2f}, {error.place[1]:.2f})" in str(error)
    assert f"{most or MOST_ROUNDS} round{'' if most == 1 else 's'}" in str(error)


def test_who_parks_in_the_way_for_ever_is_named() -> None:
    team = [disc("walker", (1, 0.5), (13, 0.5)), disc("parked", (6, 0.5), (6, 0.5))]
    with pytest.raises(NoPlanExists) as caught:
        plan(Scene(CORRIDOR, robots=team))
    assert caught.value.robots == ("walker", "parked")
    assert caught.value.place is not None
    check(plan(Scene(CORRIDOR, robots=[team[0], replace(team[1], at_goal="leave")])))


def test_a_time_limit_ends_the_search() -> None:
    with pytest.raises(NoPlanFound, match="in 1 round:"):
        plan(TIGHT, seconds=1e-9)


def test_progress_is_told_after_each_round() -> None:
    told: list[tuple[str, int, int]] = []
    with pytest.raises(NoPlanFound):
        plan(TIGHT, "prioritized", rounds=3, progress=lambda now: told.append((now.doing, now.done, now.failed)))
    assert told == [("passes", 1, 1), ("passes", 2, 1), ("passes", 3, 1)]


def test_an_enclosed_goal_is_refused_before_any_round() -> None:
    box = [Polygon([(8, 8), (12, 8), (12, 9), (8, 9)]), Polygon([(8, 11), (12, 11), (12, 12), (8, 12)])]
    box += [Polygon([(8, 9), (9, 9), (9, 11), (8, 11)]), Polygon([(11, 9), (12, 9), (12, 11), (11, 11)])]
    scene = hall(disc("free", (1, 1), (19, 1)), disc("shut", (1, 5), (10, 10)), obstacles=box)
    told: list[int] = []
    with pytest.raises(NoPath, match="shut: no way from") as caught:
        plan(scene, progress=lambda _: told.append(1))
    assert caught.value.robot == "shut"
    assert told == []


# --- What a robot may be ----------------------------------------------------------------------------------------------


@pytest.mark.parametrize("radius", [0.0, 0.35])
def test_a_robot_alone_goes_straight(radius: float) -> None:
    found = check(plan(hall(disc("R1", (1, 1), (13, 6), radius, speed=2.0))))
    assert found.trajectories[0].stamps.tolist() == [[0, 1, 1], [6.5, 13, 6]]


@pytest.mark.parametrize("at_goal", ["stay", "leave"])
def test_a_robot_at_its_goal_has_one_stamp(at_goal: str) -> None:
    still = disc("still", (5, 10), (5, 10), start_time=7.0)
    scene = hall(still, disc("other", (1, 10), (9, 10)), at_goal=at_goal)
    found = check(plan(scene))
    assert found.trajectories[0].stamps.tolist() == [[0, 5, 10]]
    assert found.costs[0] == 0.0
    # who stays is driven round, who leaves is gone at once
    assert (found.trajectories[1].length > 8.01) == (at_goal == "stay")


def test_nobody_leaves_before_its_start_time() -> None:
    team = [disc("A", (2, 10), (18, 10), start_time=5.0), disc("B", (10, 2), (10, 18), start_time=2.5)]
    result = plan(hall(*team))
    found = check(result)
    for robot, trajectory in zip(team, found.trajectories, strict=True):
        assert (trajectory.at(np.linspace(0, robot.start_time, 9)) == robot.start).all()
    assert found.costs == pytest.approx(result.shortest, abs=1e-9)  # neither meets the other


def test_a_late_start_blocks_the_corridor_until_then() -> None:
    team = [disc("A", (1, 0.5), (10, 0.5)), disc("B", (6, 0.5), (13, 0.5), start_time=20.0)]
    found = check(
        plan(Scene(CORRIDOR, robots=team), order="given", method="prioritized", rounds=1)
    )  # known before B is planned
    assert found.trajectories[0].arrival > 20.0
    assert found.trajectories[1].arrival == pytest.approx(27.0)


def test_robots_that_leave_may_share_a_goal() -> None:
    team = [disc(f"R{k}", (2.0 + 3 * k, 2), (10, 18)) for k in range(6)]
    result = plan(hall(*team, gap=0.1, at_goal="leave"))
    found = check(result)
    arrivals = np.sort([t.arrival for t in found.trajectories])
    assert (np.diff(arrivals) > 0).all()
    with pytest.raises(SceneError, match="goal"):
        plan(hall(*team, gap=0.1, at_goal="stay"))


def test_stay_and_leave_may_be_mixed() -> None:
    """The first leaves, so the second may pass over its goal; were it to stay, nobody could."""
    team = [disc("A", (5, 0.5), (9, 0.5), at_goal="leave"), disc("B", (1, 0.5), (13, 0.5))]
    check(plan(Scene(CORRIDOR, robots=team)))
    with pytest.raises(NoPlanExists):
        plan(Scene(CORRIDOR, robots=[replace(team[0], at_goal="stay"), team[1]]))


@pytest.mark.parametrize("headway", [0.5, 3.0])
def test_headway_is_kept_between_shifted_times(headway: float) -> None:
    team = [disc("A", (2, 10), (18, 10)), disc("B", (10, 2.2), (10, 18)), disc("C", (18, 3), (2, 14))]
    found = check(plan(hall(*team, headway=headway, at_goal="leave")))
    times = np.linspace(0, found.makespan, 400)
    for a, b in combinations(range(3), 2):
        here, there = found.trajectories[a], found.trajectories[b]
        for shift in np.linspace(-headway, headway, 7):
            shifted = times + shift
            both = (times < here.arrival) & (shifted >= 0) & (shifted < there.arrival)
            away = np.hypot(*(here.at(times[both]) - there.at(shifted[both])).T)
            assert away.min() >= 0.7 - 1e-9
    without = check(plan(hall(*team, at_goal="leave")))
    assert found.sum_of_costs > without.sum_of_costs


def test_every_robot_has_its_own_size_speed_and_clearance() -> None:
    """A wide robot takes the wide gate; the narrow gate serves the small one and not one that keeps more clearance."""
    wall = [Polygon([(9, 0), (11, 0), (11, 4), (9, 4)]), Polygon([(9, 5), (11, 5), (11, 14), (9, 14)])]
    wall += [Polygon([(9, 18), (11, 18), (11, 20), (9, 20)])]
    team = [
        disc("small", (2, 4), (18, 4), 0.3, speed=2.0),
        disc("wide", (2, 8), (18, 8), 1.5, speed=0.5),
        disc("shy", (2, 2), (18, 2), 0.3, clearance=0.3),
    ]
    found = check(plan(hall(*team, obstacles=wall, clearance=0.05, gap=0.1)))
    crossings = [float(np.interp(10, t.points[:, 0], t.points[:, 1])) for t in found.trajectories]
    assert 4 < crossings[0] < 5
    assert 14 < crossings[1] < 18
    assert 14 < crossings[2] < 18
    for robot, trajectory in zip(team, found.trajectories, strict=True):
        moves = np.diff(trajectory.stamps, axis=0)
        speeds = np.hypot(moves[:, 1], moves[:, 2]) / moves[:, 0]
        assert speeds.max() == pytest.approx(robot.speed)


def test_a_robot_on_a_pinch_does_not_pass_from_one_side_to_the_other() -> None:
    """It starts on both sides; once it has left on one of them it may not come back and go on to the other."""
    blocks = [
        Polygon([(0, 2), (4, 2), (4, 4), (0, 4)]),
        Polygon([(4, 4), (8, 4), (8, 6), (4, 6)]),
        Polygon([(4.2, 1), (8, 1), (8, 4), (4.2, 4)]),
    ]
    team = [Robot("B", (3.5, 1), (4.1, 3.9)), Robot("A", (4, 4), (7, 0.5))]
    scene = Scene((0, 0, 8, 8), blocks, team, gap=0.3, at_goal="leave")
    for order in ("given", "longest"):
        try:
            result = plan(scene, order=order)
        except NoPlanFound:
            continue
        check(result)


# --- Generated teams --------------------------------------------------------------------------------------------------


@settings(max_examples=45, deadline=None)
@given(team_scenes())
def test_generated_teams_plan_or_are_refused_for_a_reason(scene: Scene) -> None:
    check_generated(scene)


@settings(max_examples=30, deadline=None)
@given(team_scenes(max_robots=9, grid=5, max_obstacles=3))
@example(DEAD_END)
def test_generated_crowds_plan_or_are_refused_for_a_reason(scene: Scene) -> None:
    check_generated(scene)


def check_refusal(scene: Scene, error: NoPlanFound) -> None:
    """Check that it names robots that are in each other's way, and a place where the first of them can be."""
    by_name = {robot.name: robot for robot in scene.robots}
    assert len(error.robots) >= 2
    assert len(set(error.robots)) == len(error.robots)
    assert set(error.robots) <= set(by_name)
    assert error.time is not None
    assert error.time >= 0
    assert error.place is not None
    assert FreeSpace.of(scene, by_name[error.robots[0]]).anchor([error.place])[1][0] >= 0


def check_proof(scene: Scene, error: NoPlanExists) -> None:
    """Check that it names two robots and what would help."""
    assert len(set(error.robots) & {robot.name for robot in scene.robots}) == 2
    assert len(error.diagnosis) >= 1


def check_generated(scene: Scene) -> None:
    names = [robot.name for robot in scene.robots]
    try:
        result = plan(scene)
    except NoPath as error:
        robot = scene.robots[names.index(error.robot)]
        with pytest.raises(NoPath):
            shortest_path(FreeSpace.of(scene, robot), robot.start, robot.goal)
        return
    except NoPlanFound as error:
        check_refusal(scene, error)
        return
    except NoPlanExists as error:
        check_proof(scene, error)
        return
    found = check(result)
    again = plan_from_dict(json.loads(json.dumps(plan_to_dict(found))))
    assert again.scene == scene
    assert again.trajectories == found.trajectories
    assert [t.stamps.tobytes() for t in again.trajectories] == [t.stamps.tobytes() for t in found.trajectories]
    assert (again.planner, again.lower_bound) == (found.planner, found.lower_bound)
    assert certify(again).as_dict() == found.certificate


# --- Metamorphic ------------------------------------------------------------------------------------------------------


def planned(scene: Scene) -> Result:
    """Plan, or give the example up where there is no plan."""
    try:
        return plan(scene)
    except TautError:
        assume(False)
        raise


@settings(max_examples=15, deadline=None)
@given(team_scenes())
def test_names_do_not_matter(scene: Scene) -> None:
    first = planned(scene)
    renamed = tuple(replace(r, name=f"Z{99 - k}") for k, r in enumerate(scene.robots))
    second = plan(replace(scene, robots=renamed))
    for a, b in zip(first.plan.trajectories, second.plan.trajectories, strict=True):
        assert a.stamps.tobytes() == b.stamps.tobytes()
    assert (first.shortest == second.shortest).all()


def moved(scene: Scene, dx: float, dy: float) -> Scene:
    """The scene shifted; a turned rectangle as its corners."""

    def at(points: Sequence[Sequence[float]]) -> list[Point]:
        return [(x + dx, y + dy) for x, y in points]

    def shape(obstacle: Obstacle) -> Obstacle:
        match obstacle:
            case Circle():
                return Circle(at([obstacle.center])[0], obstacle.radius, obstacle.name)
            case Line():
                return Line(at(obstacle.points), obstacle.width, obstacle.name)
            case Rectangle() | Polygon():
                return Polygon(at(obstacle.core.tolist()), obstacle.name)

    robots = [replace(r, start=at([r.start])[0], goal=at([r.goal])[0]) for r in scene.robots]
    return replace(
        scene, workspace=tuple(at(scene.workspace)), obstacles=tuple(map(shape, scene.obstacles)), robots=tuple(robots)
    )


@settings(max_examples=15, deadline=None)
@given(team_scenes())
def test_where_the_map_lies_does_not_matter(scene: Scene) -> None:
    first = planned(scene)
    for dx, dy in ((64.0, -32.0), (-1024.0, 4096.0)):
        try:
            second = plan(moved(scene, dx, dy))
        except NoPlanFound:
            continue  # with other rounding the search may take another turn
        check(second)
        # touching, or not, may be a matter of rounding: then a way opens or closes
        np.testing.assert_allclose(first.shortest, second.shortest, rtol=1e-8)


def reversed_rings(scene: Scene) -> Scene:
    def shape(obstacle: Obstacle) -> Obstacle:
        match obstacle:
            case Polygon():
                return Polygon(obstacle.points[::-1], obstacle.name)
            case Line():
                return Line(obstacle.points[::-1], obstacle.width, obstacle.name)
        return obstacle

    return replace(scene, workspace=scene.workspace[::-1], obstacles=tuple(map(shape, scene.obstacles)))


@settings(max_examples=15, deadline=None)
@given(team_scenes())
def test_the_direction_of_rings_does_not_matter(scene: Scene) -> None:
    first = planned(scene)
    try:
        second = plan(reversed_rings(scene))
    except NoPlanFound:
        return
    check(second)
    np.testing.assert_allclose(first.shortest, second.shortest, rtol=1e-10)


@pytest.mark.parametrize("order", ["given", "shortest", "longest"])
def test_a_robot_that_meets_nobody_changes_nothing_for_the_others(order: str) -> None:
    """It drives in a room of its own, behind a wall."""
    wall = Polygon([(20, -1), (21, -1), (21, 21), (20, 21)])
    team = [disc(f"R{k}", (2 + 3.0 * k, 2), (17 - 3.0 * k, 18), 0.4) for k in range(6)]
    alone = Robot("alone", (25, 3), (25, 3 + 10), 0.4)
    without, along = (
        plan(Scene((0, 0, 30, 20), [wall], robots, gap=0.1), order=order)  # type: ignore[arg-type]
        for robots in (team, [*team[:3], alone, *team[3:]])
    )
    assert without.plan.planner["rounds"] == along.plan.planner["rounds"] == 1
    others = {t.name: t for t in check(along).trajectories}
    for trajectory in check(without).trajectories:
        assert trajectory.stamps.tobytes() == others[trajectory.name].stamps.tobytes()
    assert others["alone"].arrival == pytest.approx(10.0)


def test_more_time_between_starts_never_costs_who_meets_nobody() -> None:
    """Robots that start when all others are done arrive as if alone."""
    team = [disc(f"R{k}", (2, 2 + 2.0 * k), (18, 18 - 2.0 * k), start_time=40.0 * k) for k in range(4)]
    result = plan(hall(*team, at_goal="leave"), order="given")
    found = check(result)
    late = found.costs - result.shortest
    assert late[3] == pytest.approx(0.0, abs=1e-9)


def test_a_robot_parked_at_its_goal_steps_aside_and_returns() -> None:
    walls = [Polygon([(0, 1), (4, 1), (4, 3), (0, 3)]), Polygon([(6, 1), (10, 1), (10, 3), (6, 3)])]
    team = [Robot("parked", (5, 0.5), (5, 0.5), 0.4), Robot("passing", (0.5, 0.5), (9.5, 0.5), 0.4)]
    found = check(plan(Scene((0, 0, 10, 3), walls, team, gap=0.05)))
    parked = found.trajectories[0]
    assert parked.length > 2
    assert (parked.points[[0, -1]] == (5, 0.5)).all()


@pytest.mark.parametrize("start_time", [1e3, 1e4])
def test_a_late_robot_is_never_faster_than_it_can_be(start_time: float) -> None:
    """Late times are rounded coarsely; an arrival is rounded up."""
    robot = Robot("late", (1, 1), (8.3, 7.7), speed=0.7, start_time=start_time)
    trajectory = check(plan(Scene((0, 0, 10, 10), [Polygon([(4, 3), (6, 3), (5, 7)])], [robot]))).trajectories[0]
    moved = np.hypot(*np.diff(trajectory.points, axis=0).T)
    assert (moved <= robot.speed * np.diff(trajectory.times)).all()
