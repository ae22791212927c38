"""The steps that the studio shows are those of the algorithms, and each can be drawn and read."""

from __future__ import annotations

import json
from itertools import pairwise
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings

import taut
from strategies import team_scenes
from taut.errors import NoPath, SceneError, TautError
from taut.freespace import FreeSpace
from taut.graph.tracing import trace
from taut.roadmap import visibility_graph
from taut.route import NoCentralPath, central_path, oca_path
from taut.scene import Rectangle, Robot, Scene
from taut.studio.answers import plan_with
from taut.studio.steps import ALGORITHMS, steps_of
from taut.studio.steps_central import DELTA
from taut.studio.steps_mrppa import lambda2, stage_steps
from taut.team import Result
from taut.team.stages import BridgeStage, FirstPathStage, FullGraphStage, SequenceStage, SplitStage
from taut.team.telling import tell_conflict

READY = ("thesis-1", "thesis-2", "hospital-12")
ROLES = {
    "graph", "faint", "removed", "bridge", "runner-up", "path", "baseline", "hit", "used", "waypoint", "dropped",
    "open", "closed", "current", "tree", "grown", "free", "side-a", "side-b", "fiedler",
}  # fmt: skip


def steps(name: str, kind: str, robot: str | None = None) -> dict[str, Any]:
    """Return steps as the page gets them."""
    told = steps_of(taut.load_scene(name), kind, robot, {})
    return dict(json.loads(json.dumps(told, allow_nan=False)))


def marks_of(step: dict[str, Any], kind: str, role: str) -> list[dict[str, Any]]:
    return [mark for mark in step["stays"] + step["marks"] if (mark["kind"], mark.get("role")) == (kind, role)]


def places(mark: dict[str, Any], shared: list[Any]) -> Any:
    points = np.array(shared[mark["points"]] if isinstance(mark["points"], int) else mark["points"])
    return points[mark["at"]] if "at" in mark else points.reshape(-1, 2)


@pytest.fixture(scope="module")
def planned() -> Result:
    return plan_with(taut.load_scene("hospital-12"), {"method": "mrppa"})


@pytest.mark.parametrize("name", READY)
@pytest.mark.parametrize("kind", ALGORITHMS)
def test_every_step_can_be_drawn_and_read(name: str, kind: str) -> None:
    scene = taut.load_scene(name)
    told = steps(name, kind)
    known = {obstacle.name for obstacle in scene.obstacles}
    robots = {robot.name for robot in scene.robots}
    assert len(told["steps"]) > 2
    for step in told["steps"]:
        assert set(step) == {"title", "story", "numbers", "stays", "marks", "fresh"}
        assert step["title"]
        assert step["story"]
        assert all(isinstance(line, str) and line.endswith((".", "…")) for line in step["story"]), step["story"]
        assert all(isinstance(text, str) for text in step["numbers"].values())
    for mark in [*told["base"], *(mark for step in told["steps"] for mark in step["stays"] + step["marks"])]:
        assert mark["kind"] == "note" or mark["role"] in ROLES
        assert mark.get("robot") in {None, *robots}
        match mark["kind"]:
            case "obstacles":
                assert set(mark["names"]) <= known
            case "area":
                assert all(len(ring) > 2 for ring in mark["rings"])
            case "edges":
                count = len(places(mark, told["points"]))
                assert all(0 <= i < count and 0 <= j < count for i, j in mark["pairs"])
                assert len(mark.get("labels", mark["pairs"])) == len(mark["pairs"])
            case "vertices" | "path":
                found = places(mark, told["points"])
                assert len(mark.get("labels", found)) == len(found)
                assert len(mark.get("values", found)) == len(found)
            case _:
                assert mark["kind"] == "note"


def test_the_steps_of_mrppa_have_the_values_of_its_stages(planned: Result) -> None:
    told = stage_steps(planned)["steps"]
    bridges = [stage for stage in planned.stages if isinstance(stage, BridgeStage)]
    shown = [step for step in told if step["title"].startswith("Bridge for ")]
    assert len(bridges) == len(shown) > 2
    for stage, step in zip(bridges, shown, strict=True):
        assert step["numbers"]["λ2 before"] == lambda2(stage.before)
        assert step["numbers"]["λ2 after"] == lambda2(stage.after)
        assert step["numbers"]["candidates"] == str(stage.candidates)
        *_, bridge = marks_of(step, "edges", "bridge")
        assert bridge["pairs"] == [stage.ground.roadmap.edges[stage.edge].tolist()]
        assert bridge["robot"] == stage.robot
        runners = marks_of(step, "edges", "runner-up")
        assert len(runners) == (stage.runner_up is not None)
    wholes = [stage for stage in planned.stages if isinstance(stage, FullGraphStage)]
    values = [step["numbers"]["λ2"] for step in told if step["title"].startswith("Full visibility graph")]
    assert values == [lambda2(stage.connectivity) for stage in wholes]


def test_sides_and_the_fiedler_vector_agree(planned: Result) -> None:
    told = stage_steps(planned)
    cuts = [stage for stage in planned.stages if isinstance(stage, SplitStage)]
    splits = [step for step in told["steps"] if step["title"].startswith("Split in two")]
    vectors = [step for step in told["steps"] if step["title"].startswith("Fiedler vector")]
    assert len(cuts) == len(splits) == len(vectors)
    for stage, split, vector in zip(cuts, splits, vectors, strict=True):
        (values,) = marks_of(vector, "vertices", "fiedler")
        (a,), (b,) = marks_of(split, "vertices", "side-a"), marks_of(split, "vertices", "side-b")
        assert sorted(a["at"] + b["at"]) == list(range(len(stage.side)))
        assert np.abs(values["values"]).max() == 1.0
        if not stage.moved:
            assert np.mean(np.array(values["values"])[b["at"]] >= -1e-9) > 0.9
        drawn = [mark for role in ("removed", "side-a", "side-b") for mark in marks_of(split, "edges", role)]
        assert sorted(pair for mark in drawn for pair in mark["pairs"]) == sorted(stage.ground.roadmap.edges.tolist())


def test_first_paths_go_through_the_vertices_of_the_stage(planned: Result) -> None:
    told = stage_steps(planned)
    stages = [stage for stage in planned.stages if isinstance(stage, FirstPathStage)]
    shown = [step for step in told["steps"] if step["title"].startswith("First path of ")]
    assert len(shown) == len(stages)
    for stage, step in zip(stages, shown, strict=True):
        (path,) = marks_of(step, "path", "path")
        assert np.array_equal(places(path, told["points"]), stage.ground.roadmap.positions[stage.path])


def test_the_team_is_planned_in_one_step_a_robot_that_tells_what_it_met(planned: Result) -> None:
    stage = planned.stages[-1]
    assert isinstance(stage, SequenceStage)
    steps = stage_steps(planned)["steps"][-len(stage.order) - 1 :]
    for name, step in zip(stage.order, steps[:-1], strict=True):
        assert step["title"].startswith(f"{name} is planned")
        for number, conflict in enumerate(stage.conflicts[name], 1):
            assert f"{number}. {tell_conflict(conflict)}" in step["story"]
        hits = marks_of(step, "vertices", "hit")
        assert [tuple(p) for mark in hits for p in mark["points"]] == [c.place for c in stage.conflicts[name]]
        (way,) = [mark for mark in step["stays"] if mark["kind"] == "path"]
        assert way["robot"] == name
        moved = planned.plan.trajectories[[r.name for r in planned.plan.scene.robots].index(name)].points
        assert (way["points"][0], way["points"][-1]) == (moved[0].tolist(), moved[-1].tolist())
        assert all(a != b for a, b in pairwise(way["points"]))
    assert [step["fresh"] for step in steps] == [True] + [False] * len(stage.order)
    assert steps[-1]["numbers"]["certified"] == "yes"


def test_settings_that_do_not_go_with_mrppa_are_left_out() -> None:
    settings = {"roadmap": "grid", "objective": "makespan", "within": 2.0, "method": "optimal", "order": "given"}
    told = steps_of(taut.load_scene("thesis-2"), "mrppa", None, settings)
    assert next(s["title"] for s in told["steps"] if "planned" in s["title"]).startswith("R1 ")


@pytest.mark.parametrize("method", ["dijkstra", "astar"])
@pytest.mark.parametrize("name", ["thesis-1", "thesis-2"])
def test_a_search_step_by_step_is_the_trace(name: str, method: Any) -> None:
    scene = taut.load_scene(name)
    robot = scene.robots[1]
    space = FreeSpace.of(scene, robot)
    roadmap = visibility_graph(space, points=[robot.start, robot.goal])
    n = roadmap.graph.n
    expected = trace(roadmap.graph, n - 2, n - 1, method, roadmap.positions)
    told = steps(name, method, robot.name)
    assert told["points"] == [roadmap.positions.tolist()]
    stays: list[dict[str, Any]] = []
    for k, step in enumerate(told["steps"][:-1]):
        stays += step["stays"]
        state = expected.state(k)
        closed = [v for mark in stays if mark["role"] == "closed" for v in mark["at"]]
        seen = {v for mark in stays if mark["role"] == "open" for v in mark["at"]}
        tree = {tuple(pair) for mark in stays if mark["role"] == "tree" for pair in mark["pairs"]}
        assert closed == list(state.visited)
        assert seen - set(closed) == {v for v, _ in state.frontier}
        assert tree == {(int(state.before[v]), v) for v in closed if state.before[v] >= 0}
        if k:
            assert marks_of(step, "vertices", "current")[0]["at"] == [closed[-1]]
    (path,) = marks_of(told["steps"][-1], "path", "path")
    assert path["at"] == expected.path
    assert expected.distance == pytest.approx(taut.shortest_path(space, robot.start, robot.goal).length)


@pytest.mark.parametrize("boxes", [[], [Rectangle(1, 1, 1, 1)]], ids=len)
@pytest.mark.parametrize("goal", [(3, 3), (3, 1)])
@pytest.mark.parametrize("radius", [0.0, 0.1])
def test_a_robot_alone_or_already_at_its_goal_has_steps_too(
    boxes: list[Rectangle], goal: tuple[float, float], radius: float
) -> None:
    scene = Scene((0, 0, 4, 4), boxes, [Robot("R1", (3, 3), goal, radius=radius)])
    for kind in ALGORITHMS:
        assert steps_of(scene, kind, "R1", {})["steps"]


@settings(max_examples=10, deadline=None)
@given(team_scenes(max_robots=3, max_obstacles=4))
def test_whatever_the_scene_steps_are_finite_or_the_error_is_a_sentence(scene: Scene) -> None:
    for kind in ALGORITHMS:
        try:
            told = steps_of(scene, kind, None, {"rounds": 2})
        except TautError as error:
            told = {"steps": [str(error)]}
        assert json.dumps(told["steps"], allow_nan=False) != "[]"


@pytest.mark.parametrize("name", READY)
def test_the_steps_of_ca_are_its_parts(name: str) -> None:
    scene = taut.load_scene(name)
    for robot in scene.robots:
        told = {step["title"]: step for step in steps(name, "ca", robot.name)["steps"]}
        if "No way" in told:
            with pytest.raises(NoCentralPath):
                central_path(scene, robot, DELTA)
            continue
        route = central_path(scene, robot, DELTA)
        (path,) = marks_of(told["Path"], "path", "path")
        assert path["points"] == route.points.tolist()
        assert ("hits" in told["Path"]["numbers"]) == bool(route.hits)
        if route.crossed:
            (kept,) = marks_of(told["Waypoints"], "vertices", "waypoint")
            (dropped,) = marks_of(told["Waypoints"], "vertices", "dropped")
            assert [tuple(p) for p in kept["points"]] == [w.place for w in route.waypoints]
            assert [tuple(p) for p in dropped["points"]] == [w.place for w, _ in route.dropped]
            assert dropped.get("labels", []) in ([], [why for _, why in route.dropped])
            (hit,) = marks_of(told["Crossed obstacles"], "obstacles", "hit")
            assert hit["names"] == [crossed.name for crossed in route.crossed]


def test_ca_that_finds_no_way_says_so_as_its_last_step() -> None:
    boxes = [Rectangle(3, 0, 1, 7.5, name="low"), Rectangle(5, 0.5, 1, 7.5, name="high")]
    scene = Scene((0, 0, 9, 8), boxes, [Robot("R1", (1, 4), (8, 4), radius=0.1)])
    with pytest.raises(NoCentralPath):
        central_path(scene, "R1", DELTA)
    told = steps_of(scene, "ca", "R1", {})["steps"]
    assert told[-1]["title"] == "No way"
    assert "not complete" in told[-1]["story"][0]


@pytest.mark.parametrize("name", READY)
def test_the_steps_of_oca_are_its_rounds(name: str) -> None:
    scene = taut.load_scene(name)
    route = oca_path(scene, scene.robots[0])
    told = steps(name, "oca")["steps"]
    rounds = [step for step in told if step["title"].startswith("Round ")]
    known: list[str] = []
    for now, step in zip(route.rounds, rounds, strict=True):
        known += now.added
        (used,) = marks_of(step, "obstacles", "used")
        assert used["names"] == known
        assert marks_of(step, "path", "path")[0]["points"] == now.points.tolist()
        assert [name for mark in marks_of(step, "obstacles", "hit") for name in mark["names"]] == list(now.hit)
    assert marks_of(told[-1], "path", "path")[0]["points"] == route.points.tolist()


def test_what_cannot_be_stepped_through_is_refused_in_a_sentence() -> None:
    scene = taut.load_scene("thesis-2")
    with pytest.raises(SceneError, match="no robots"):
        steps_of(Scene((0, 0, 1, 1)), "ca", None, {})
    with pytest.raises(SceneError, match="has no robot R9"):
        steps_of(scene, "ca", "R9", {})
    with pytest.raises(SceneError, match="there are steps of mrppa, ca"):
        steps_of(scene, "magic", None, {})
    shut = Scene((0, 0, 8, 4), [Rectangle(3, 0, 2, 4)], [Robot("R1", (1, 2), (7, 2), radius=0.1)])
    for kind in ("mrppa", "oca", "dijkstra", "astar"):
        with pytest.raises(NoPath):
            steps_of(shut, kind, "R1", {})
