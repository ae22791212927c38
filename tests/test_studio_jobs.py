"""What the studio tells of plans, of all problems of a scene at once, and of why something cannot be done."""

from __future__ import annotations

import json
import time
from collections.abc import Callable
from dataclasses import replace
from functools import reduce
from typing import Any

import numpy as np
import pytest
import shapely
from hypothesis import given, settings
from hypothesis import strategies as st

import taut
from strategies import scenes, team_scenes
from taut.errors import NoPath, NoPlanExists, SceneError, StartBlocked, TautError
from taut.formats import scene_to_dict
from taut.freespace import FreeSpace
from taut.scene import Circle, Polygon, Rectangle, Robot, Scene
from taut.studio.answers import plan_answer, plan_of, plan_with, progress_data
from taut.studio.checking import checked, problems
from taut.studio.reasons import rings_of, why, wrong
from taut.team.methods import Progress
from taut.team.stages import SequenceStage
from taut.team.telling import tell_conflict
from zoo import ZOO, Entry

HALL = Scene(
    (0, 0, 10, 10),
    [Polygon([(4, 3), (6, 3), (6, 7), (4, 7)], name="box"), Circle((2, 8), 0.5, name="pillar")],
    [Robot("R1", (1, 5), (9, 5), radius=0.3), Robot("R2", (9, 2), (1, 2), radius=0.3)],
    name="hall",
    gap=0.05,
)
GATE = Scene(
    (0, 0, 8, 4),
    [Rectangle(3, 0, 2, 1.9, name="low"), Rectangle(3, 2.3, 2, 1.7, name="high"), Circle((1, 1), 0.2, name="pillar")],
    [Robot("R1", (1, 3), (7, 3), radius=0.3), Robot("R2", (1.5, 2), (2.5, 3.5), radius=0.1)],
    gap=0.1,
)


def strictly(value: Any) -> Any:
    """Return a value as the page gets it: through JSON without NaN and Infinity."""
    return json.loads(json.dumps(value, allow_nan=False))


def edited(scene: Scene, edit: Callable[[dict[str, Any]], object]) -> dict[str, Any]:
    data = json.loads(json.dumps(scene_to_dict(scene)))
    edit(data)
    return dict(data)


def area_of(rings: list[list[list[float]]]) -> Any:
    """Return what lies in an odd number of rings."""
    return reduce(lambda some, ring: some.symmetric_difference(shapely.Polygon(ring)), rings, shapely.Polygon())


@settings(max_examples=20, deadline=None)
@given(team_scenes(max_robots=4, max_obstacles=4))
def test_a_plan_that_went_to_the_page_and_came_back_is_the_same_and_holds(scene: Scene) -> None:
    try:
        result = plan_with(scene, {"rounds": 2, "method": "prioritized"})
    except TautError as error:
        told, said = strictly(wrong(error, scene)), str(error)
        assert told["message"] == said
        assert set(told["names"]) <= {robot.name for robot in scene.robots}
        return
    answer = strictly(plan_answer(result))
    back = plan_of(scene, answer["plan"])
    assert back.trajectories == result.plan.trajectories
    assert taut.certify(back).ok
    assert answer["certificate"] == answer["plan"]["certificate"]
    assert answer["metrics"]["sum_of_costs"] == back.sum_of_costs
    assert set(answer["shortest"]) == set(answer["detours"]) == {robot.name for robot in scene.robots}


def test_the_answer_marks_every_conflict_with_its_sentence_in_the_order_of_planning() -> None:
    result = plan_with(taut.load_scene("hospital-12"), {})
    stage = result.stages[-1]
    assert isinstance(stage, SequenceStage)
    expected = [conflict for name in stage.order for conflict in stage.conflicts[name]]
    told = plan_answer(result)["conflicts"]
    assert len(told) == len(expected) > 0
    for data, conflict in zip(told, expected, strict=True):
        assert data["sentence"] == tell_conflict(conflict)
        assert (data["robot"], data["other"], data["time"]) == (conflict.robot, conflict.other, conflict.time)
        assert tuple(data["place"]) == conflict.place


def test_settings_reach_the_planner() -> None:
    asked = {"method": "repair", "order": "longest", "seed": 3, "rounds": 2, "objective": "makespan", "within": None}
    plan = plan_with(HALL, asked).plan
    assert (plan.planner["method"], plan.planner["seed"], plan.planner["objective"]) == ("repair", 3, "makespan")
    demand = {"range": 20, "sight": False, "k": 1, "lambda2": 0}
    assert plan_with(HALL, {"contact": demand}).plan.claims["contact"] == demand
    with pytest.raises(SceneError, match="unknown settings 'sed'"):
        plan_with(HALL, {"sed": 3})


def test_the_share_above_the_bound_is_that_of_the_cost_the_bound_is_of() -> None:
    for objective in ("sum_of_costs", "makespan"):
        result = plan_with(HALL, {"method": "repair", "rounds": 1, "objective": objective})
        metrics = plan_answer(result)["metrics"]
        cost = getattr(result.plan, objective)
        assert metrics["above"] == pytest.approx(cost / metrics["lower_bound"]["value"] - 1)


def test_progress_without_a_plan_has_no_cost() -> None:
    assert progress_data(Progress("passes", 1, 2, float("inf"), 0.0)) == {
        "text": "round 1, 2 robots failed",
        "cost": None,
        "bound": None,
    }
    assert progress_data(Progress("repair", 3, 0, 12.0, 10.0))["bound"] == 10.0


@pytest.mark.parametrize("entry", ZOO, ids=str)
def test_scenes_that_hold_have_no_problems(entry: Entry) -> None:
    assert checked(scene_to_dict(entry.scene)) == {"problems": [], "notes": list(taut.validate(entry.scene))}


def _bow_tie(data: dict[str, Any]) -> None:
    data["obstacles"].append({"name": "tie", "polygon": [[0, 0], [2, 2], [2, 0], [0, 2]]})


def _start_in_box(data: dict[str, Any]) -> None:
    data["robots"][0]["start"] = [5, 5]


def _goal_outside(data: dict[str, Any]) -> None:
    data["robots"][0]["goal"] = [12, 5]


def _same_start(data: dict[str, Any]) -> None:
    data["robots"][1]["start"] = data["robots"][0]["start"]


def _same_goal(data: dict[str, Any]) -> None:
    data["robots"][1]["goal"] = data["robots"][0]["goal"]


def _negative_radius(data: dict[str, Any]) -> None:
    data["robots"][1]["radius"] = -1


def _same_name(data: dict[str, Any]) -> None:
    data["obstacles"].append({**data["obstacles"][0]})


def _no_gap(data: dict[str, Any]) -> None:
    data["gap"] = 0
    for robot in data["robots"]:
        robot["radius"] = 0


def _crossed_workspace(data: dict[str, Any]) -> None:
    del data["bounds"]
    data["workspace"] = [[0, 0], [10, 10], [10, 0], [0, 10]]


@pytest.mark.parametrize(
    ("edit", "kind", "names", "place", "end"),
    [
        (_bow_tie, "obstacle", ["tie"], [1, 1], None),
        (_start_in_box, "robot", ["R1"], [5, 5], "start"),
        (_goal_outside, "robot", ["R1"], [12, 5], "goal"),
        (_same_start, "pair", ["R1", "R2"], [1, 5], "start"),
        (_same_goal, "pair", ["R1", "R2"], [9, 5], "goal"),
        (_negative_radius, "robot", ["R2"], [9, 2], None),
        (_same_name, "obstacle", ["box"], [4, 3], None),
        (_no_gap, "pair", ["R1", "R2"], [5, 3.5], None),
        (_crossed_workspace, "scene", [], None, None),
    ],
)
def test_a_problem_says_what_it_is_about_and_where(
    edit: Callable[[dict[str, Any]], None], kind: str, names: list[str], place: list[float] | None, end: str | None
) -> None:
    data = edited(HALL, edit)
    (told,) = strictly(problems(data))
    with pytest.raises(SceneError) as refused:
        taut.validate(taut.formats.scene_from_dict(data))
    assert told == {"message": refused.value.message, "kind": kind, "names": names, "place": place, "end": end}


def test_all_problems_are_told_at_once() -> None:
    def spoil(data: dict[str, Any]) -> None:
        for edit in (_bow_tie, _start_in_box, _same_goal, _same_name):
            edit(data)
        data["robots"][0]["goal"] = data["robots"][1]["goal"]
        data["robots"].append({"name": "R3", "start": [2, 8], "goal": [20, 20], "radius": 0.1, "speed": 1})
        data["robots"].append({"name": "R4", "start": "here", "goal": [1, 1]})

    told = problems(edited(HALL, spoil))
    found = {(one["kind"], tuple(one["names"]), one["end"]) for one in told}
    assert found == {
        ("obstacle", ("tie",), None),
        ("obstacle", ("box",), None),
        ("robot", ("R1",), "start"),
        ("pair", ("R1", "R2"), "goal"),
        ("robot", ("R3",), "start"),
        ("robot", ("R3",), "goal"),
        ("robot", ("R4",), None),
    }


def test_of_many_robots_on_one_place_each_is_told_once() -> None:
    robots = [Robot(f"R{k}", (5, 5), (1 + k, 1), radius=0.2) for k in range(8)]
    told = problems(scene_to_dict(Scene((0, 0, 10, 10), (), robots)))
    assert [one["names"] for one in told] == [["R0", f"R{k}"] for k in range(1, 8)]


@pytest.mark.parametrize("shape", [{"circle": [5, 5], "radius": 1}, {"polygon": [[4, 4], [6, 4], [5, 6]]}])
def test_heaps_of_thousands_are_looked_at_in_a_moment(shape: dict[str, Any]) -> None:
    obstacles = [{"name": f"O{k}", **shape} for k in range(5000)]
    robots = [{"name": f"R{k}", "start": [5, 5], "goal": [1, 1], "radius": 0.1} for k in range(1000)]
    heap = {"taut": 1, "bounds": [0, 0, 10, 10], "obstacles": obstacles, "robots": []}
    began = time.monotonic()
    told = checked(heap)
    assert told["problems"] == []
    assert "lie on each other" in told["notes"][0]
    told = checked({**heap, "robots": robots})
    assert time.monotonic() - began < 10
    assert told["notes"] == []
    assert sum(one["kind"] == "robot" for one in told["problems"]) == 100
    assert sum("told are the first 100" in one["message"] for one in told["problems"]) >= 1


@pytest.mark.parametrize(
    ("kind", "bad"),
    [
        ("obstacles", {"polygon": [[4, 4], [6, 6], [6, 4], [4, 6]]}),
        ("obstacles", {"circle": [5, 5], "radius": -1}),
        ("robots", {"start": [1, 1], "goal": [2, 2], "radius": -1}),
        ("robots", {"start": [1, 1], "goal": [2, 2], "radius": 1e-80}),
    ],
)
def test_of_thousands_of_problems_the_first_are_told_and_that_there_are_more(kind: str, bad: dict[str, Any]) -> None:
    scene = {"taut": 1, "bounds": [0, 0, 10, 10], "obstacles": [], "robots": []}
    told = problems({**scene, kind: [{"name": f"N{k}", **bad} for k in range(2000)]})
    assert len(told) == 101
    assert f"more {kind}" in told[-1]["message"]
    assert [one["names"] for one in told[:-1]] == [[f"N{k}"] for k in range(100)]


@pytest.mark.parametrize("data", [None, [], "scene", {}, {"taut": 1}, {"obstacles": 3, "robots": []}])
def test_what_is_no_scene_at_all_is_one_problem(data: Any) -> None:
    (told,) = problems(data)
    assert told["kind"] == "scene"
    assert told["message"]


@settings(max_examples=60, deadline=None)
@given(scenes(max_obstacles=4, max_robots=3, max_radius=0.5), st.data())
def test_there_are_problems_just_where_validation_refuses_and_its_own_is_among_them(
    scene: Scene, draw: st.DataObject
) -> None:
    def moved(robot: Robot) -> Robot:
        places = st.tuples(st.integers(-1, 9), st.integers(-1, 9))
        changes: dict[str, Any] = draw.draw(
            st.fixed_dictionaries({}, optional={"start": places, "goal": places, "radius": st.sampled_from([0.0, 1.0])})
        )
        return replace(robot, **changes)

    tried = replace(scene, robots=tuple(map(moved, scene.robots)))
    told = [one["message"] for one in problems(scene_to_dict(tried))]
    first = None
    try:
        taut.validate(tried)
    except SceneError as error:
        first = error.message
    assert told == [] if first is None else first in told


def test_why_there_is_no_path_is_shown_as_areas_and_the_gap() -> None:
    robot = GATE.robot("R1")
    with pytest.raises(NoPath) as refused:
        plan_with(GATE, {})
    told = strictly(wrong(refused.value, GATE))
    assert (told["kind"], told["names"]) == ("no path", ["R1"])
    space = FreeSpace.of(GATE, robot)
    for key, place in (("from", robot.start), ("to", robot.goal)):
        area = area_of(told["why"][key])
        (part,) = space.part_of([place])[0]
        corners = space.mesh.vertices[space.mesh.triangles[space.mesh.parts == part]]
        assert area.covers(shapely.Point(place))
        assert area.area == pytest.approx(sum(shapely.Polygon(three).area for three in corners))
    assert not area_of(told["why"]["from"]).intersects(area_of(told["why"]["to"]))
    gap = told["why"]["gap"]
    assert set(gap["between"]) == {"low", "high"}
    assert gap["room"] == pytest.approx(0.4)
    assert gap["needed"] == pytest.approx(0.6)
    assert told["place"] == gap["place"]
    assert 3 <= gap["place"][0] <= 5
    assert gap["place"][1] == pytest.approx(2.1)
    assert "0.4 m" in told["why"]["sentences"][0]


@pytest.mark.parametrize("entry", [e for e in ZOO if False in e.reachable.values()], ids=str)
def test_areas_hold_start_and_goal_of_every_awkward_scene(entry: Entry) -> None:
    scene = entry.scene
    for name, reachable in entry.reachable.items():
        if reachable:
            continue
        robot = scene.robot(name)
        told = strictly(why(scene, NoPath(name, "")))
        for key, place in (("from", robot.start), ("to", robot.goal)):
            area = area_of(told[key])
            # a start on a pinch point belongs to both sides
            assert area.distance(shapely.Point(place)) <= 16 * scene.tol
        parts = FreeSpace.of(scene, robot).part_of([robot.start, robot.goal])
        assert not parts[0] & parts[1]


def test_rings_of_all_parts_are_the_free_space() -> None:
    space = FreeSpace.of(GATE, GATE.robot("R1"))
    rings = rings_of(space, frozenset(range(space.parts)))
    assert area_of(rings).symmetric_difference(space.region).area == pytest.approx(0.0)


def test_a_roadmap_that_does_not_join_what_free_space_does_is_told_apart() -> None:
    told = why(HALL, NoPath("R1", "the roadmap does not join them"))
    assert told is not None
    assert (told["from"], told["to"], told["gap"]) == ([], [], None)
    assert "roadmap" in told["sentences"][0]


def test_two_that_cannot_pass_each_other_are_named_with_the_place_and_what_would_help() -> None:
    robots = [Robot("R1", (1, 0.5), (7, 0.5), radius=0.3), Robot("R2", (7, 0.5), (1, 0.5), radius=0.3)]
    corridor = Scene((0, 0, 8, 1), (), robots)
    with pytest.raises(NoPlanExists) as refused:
        plan_with(corridor, {})
    told = strictly(wrong(refused.value, corridor))
    assert (told["kind"], told["names"]) == ("no plan exists", ["R1", "R2"])
    assert np.hypot(*np.subtract(told["place"], refused.value.place or (np.nan, np.nan))) == 0
    assert told["why"]["sentences"] == list(refused.value.diagnosis)


def test_a_start_that_is_blocked_is_told_at_its_place_and_a_file_with_its_line() -> None:
    scene = replace(HALL, robots=(replace(HALL.robots[0], start=(5, 5)), HALL.robots[1]))
    with pytest.raises(StartBlocked) as refused:
        plan_with(scene, {})
    told = strictly(wrong(refused.value, scene))
    assert (told["kind"], told["names"], told["place"], told["why"]) == ("robot", ["R1"], [5, 5], None)
    assert wrong(SceneError("is empty", "map.yaml", 3))["line"] == 3
