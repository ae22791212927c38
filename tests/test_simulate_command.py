"""The command simulate: it tells what the library found, writes studies, and refuses in one line."""

from __future__ import annotations

import json
import os
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest

from commands import Command, command_in, refused
from taut.formats import load_plan, load_scene
from taut.simulation import Disturbances, run_data
from taut.simulation import simulate as follow

CROSSING = """\
taut: 1
name: crossing
bounds: [0, 0, 8, 8]
gap: 0.1
robots:
  - {name: A, start: [1, 4], goal: [7, 4], radius: 0.3}
  - {name: B, start: [4, 1], goal: [4, 7], radius: 0.3}
"""


@pytest.fixture
def taut(tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]) -> Command:
    (tmp_path / "scene.yaml").write_text(CROSSING)
    command = command_in(tmp_path, monkeypatch, capsys)
    assert command("plan", "scene.yaml", "-o", "plan.json").code == 0
    return command


def test_a_run_is_told_for_people_and_in_json(taut: Command) -> None:
    said = taut("simulate", "plan.json", "--speed-error", "0.2", "--seed", "3")
    assert said.code == 0, said.err
    assert "arrived" in said.out
    assert "2 of 2" in said.out
    told = taut("simulate", "plan.json", "--speed-error", "0.2", "--seed", "3", "--json").json
    expected = run_data(follow(load_plan("plan.json"), seed=3, disturbances=Disturbances(speed_error=0.2)))
    assert told.pop("files") == []
    assert told == json.loads(json.dumps(expected))


def test_pictures_are_written(taut: Command, tmp_path: Path) -> None:
    said = taut("simulate", "plan.json", "--figure", "run.png", "--lidar")
    assert said.code == 0, said.err
    assert (tmp_path / "run.png").stat().st_size > 10_000
    assert "wrote run.png" in said.out


def test_who_does_not_arrive_is_named_and_the_scene_written_to_plan_on_from(taut: Command) -> None:
    plan = load_plan("plan.json")
    first = min(plan.trajectories, key=lambda path: path.arrival).name
    said = taut("simulate", "plan.json", "--dies", f"{first}@1", "--after", "after.yaml")
    assert said.code == 1
    assert f"{first}" in said.out
    assert "died at 1 s" in said.out
    assert "did not arrive" in said.err
    assert f"note: dead, so an obstacle in after.yaml: {first}" in said.out
    after = load_scene("after.yaml")
    assert [obstacle.name for obstacle in after.obstacles] == [first]
    assert [robot.name for robot in after.robots] == ["B" if first == "A" else "A"]
    assert taut("plan", "after.yaml").code == 0


def test_without_coordination_late_robots_collide_and_the_exit_code_says_so(taut: Command) -> None:
    plan = load_plan("plan.json")
    first = min(plan.trajectories, key=lambda path: path.arrival).name
    said = taut("simulate", "plan.json", "--slow", f"{first}@0.5", "--no-coordination")
    with_care = taut("simulate", "plan.json", "--slow", f"{first}@0.5")
    assert with_care.code == 0, with_care.err
    assert said.code == 1
    assert "1 collision" in said.err


def test_a_study_is_written_and_its_margin_leaves_room_in_a_plan(taut: Command) -> None:
    words = ("simulate", "plan.json", "--seeds", "20", "--speed-error", "0.2", "--stops", "0.1")
    said = taut(*words, "-o", "study.json")
    assert said.code == 0, said.err
    assert "too few for 0.999" in said.out
    study = json.loads(Path("study.json").read_text())
    assert len(study["runs"]) == study["count"] == 20
    lines = [json.loads(line) for line in taut(*words, "--json").out.splitlines()]
    assert lines[:-1] == study["runs"]
    planned = taut("plan", "scene.yaml", "--margin", "study.json", "-o", "roomy.json")
    assert planned.code == 0, planned.err
    assert "note: clearance is" in planned.out
    metres = study["margin"]["metres"]
    assert load_plan("roomy.json").scene.gap == pytest.approx((0.1 + 2 * metres) / 0.95)
    assert load_plan("roomy.json").scene.clearance == pytest.approx(metres)


@pytest.mark.parametrize(
    ("words", "told"),
    [
        (["--dies", "A"], "--dies"),
        (["--dies", "A@soon"], "like R2@10"),
        (["--dies", "Z@3"], "no robot Z"),
        (["--slow", "A@0"], "above 0"),
        (["--speed-error", "2"], "speed error"),
        (["--stops", "-1"], "stops"),
        (["--step", "0"], "step"),
        (["--step", "1e-310"], "step"),
        (["--step", "100"], "step"),
        (["--stops", "1e300", "--stop-seconds", "1e-300"], "stops"),
        (["-o", "study.json"], "--seeds"),
        (["--seeds", "3", "--lidar"], "single run"),
        (["--seeds", "3", "--probability", "1"], "probability"),
        (["--seeds", "3", "-o", "study.txt"], ".json"),
        (["--after", "here.txt"], ".yaml"),
        (["--vehicle", "boat"], "boat"),
    ],
)
def test_bad_options_are_refused_in_one_line(taut: Command, words: list[str], told: str) -> None:
    assert refused(taut("simulate", "plan.json", *words), told)


def test_plans_that_do_not_hold_or_are_none_are_refused(taut: Command) -> None:
    assert refused(taut("simulate", "none.json"), "none.json")
    plan = json.loads(Path("plan.json").read_text())
    for robot in plan["robots"]:
        robot["stamps"] = [[t / 2, x, y] for t, x, y in robot["stamps"]]
    Path("fast.json").write_text(json.dumps(plan))
    assert refused(taut("simulate", "fast.json"), "fast.json", "only plans that hold")


def test_margins_of_files_that_are_no_studies_are_refused(taut: Command) -> None:
    assert refused(taut("plan", "scene.yaml", "--margin", "plan.json"), "is no study")
    assert refused(taut("plan", "scene.yaml", "--margin", f"nowhere{os.sep}study.json"), "cannot be read")


def test_a_study_of_collisions_says_so_and_is_no_failure(taut: Command) -> None:
    said = taut("simulate", "plan.json", "--slow", f"{first_of('plan.json')}@0.5", "--no-coordination", "--seeds", "3")
    assert said.code == 0, said.err
    assert "note: collisions in 3 of 3 runs" in said.out
    assert "kept apart by no margin" in said.out


def test_the_margin_of_runs_that_never_ended_is_refused(taut: Command) -> None:
    words = ("simulate", "plan.json", "--dies", f"{first_of('plan.json')}@1", "--seeds", "3", "-o", "study.json")
    said = taut(*words)
    assert said.code == 0
    assert "note: in 3 of 3 runs not all robots arrived" in said.out
    assert refused(taut("plan", "scene.yaml", "--margin", "study.json"), "not all robots arrived")
    taut("simulate", "plan.json", "--no-coordination", "--seeds", "3", "-o", "alone.json")
    assert refused(taut("plan", "scene.yaml", "--margin", "alone.json"), "without coordination")


def test_the_margin_of_another_scene_is_taken_with_a_warning(taut: Command) -> None:
    taut("simulate", "plan.json", "--seeds", "3", "-o", "study.json")
    Path("other.yaml").write_text(
        Path("scene.yaml").read_text().replace("crossing", "elsewhere").replace("name: B", "name: C")
    )
    said = taut("plan", "other.yaml", "--margin", "study.json")
    assert said.code == 0, said.err
    assert "note: the study study.json is of the scene 'crossing', not of 'elsewhere'" in said.out
    assert "note: the study study.json was made with other robots" in said.out
    assert "was made with" not in taut("plan", "scene.yaml", "--margin", "study.json").out


def test_an_interrupted_study_writes_what_it_has(taut: Command, monkeypatch: pytest.MonkeyPatch) -> None:
    from taut.simulation import studies

    whole = studies.study

    def interrupted(*given: Any, tell: Callable[[int], None], **more: Any) -> Any:
        def stop(done: int) -> None:
            tell(done)
            if done == 100:
                raise KeyboardInterrupt

        return whole(*given, **{**more, "tell": stop})

    monkeypatch.setattr("taut.simulation.study", interrupted)
    said = taut("simulate", "plan.json", "--seeds", "1000", "-o", "study.json")
    assert said.code == 130
    made = json.loads(Path("study.json").read_text())["count"]
    assert 1 <= made <= 101 + (os.cpu_count() or 1)
    assert f"interrupted: {made} of 1000 runs were made" in said.err


def first_of(plan: str) -> str:
    """Name of the robot that arrives first."""
    return min(load_plan(plan).trajectories, key=lambda path: path.arrival).name
