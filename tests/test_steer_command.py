"""The command steer: it tells what became of the team, draws it, and refuses in one line."""

from __future__ import annotations

import json
from itertools import combinations
from pathlib import Path

import pytest

from commands import Command, command_in, refused
from taut.control import formation
from taut.formats import load_scene
from taut.graph import Graph
from taut.simulation import Disturbances
from taut.simulation import steer as follow

TEAM = """\
taut: 1
name: team
bounds: [0, 0, 12, 9]
gap: 0.1
robots:
  - {name: A, start: [1, 1], goal: [5, 3.5], radius: 0.25}
  - {name: B, start: [4, 1.5], goal: [8, 3.5], radius: 0.25}
  - {name: C, start: [1.5, 4], goal: [5, 6.5], radius: 0.25}
  - {name: D, start: [10.5, 1.5], goal: [8, 6.5], radius: 0.25}
"""


@pytest.fixture
def taut(tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]) -> Command:
    (tmp_path / "team.yaml").write_text(TEAM)
    (tmp_path / "points.yaml").write_text(TEAM.replace(", radius: 0.25", ""))
    return command_in(tmp_path, monkeypatch, capsys)


def test_the_goals_are_the_formation_unless_another_is_given(taut: Command) -> None:
    said = taut("steer", "team.yaml", "--speed-error", "0.2", "--seed", "3", "--json")
    assert said.code == 0, said.err
    scene = load_scene("team.yaml")
    law = formation(Graph.from_edges(4, list(combinations(range(4), 2))), [robot.goal for robot in scene.robots])
    expected = follow(scene, law, seed=3, disturbances=Disturbances(speed_error=0.2))
    assert [robot["pose"] for robot in said.json["robots"]] == expected.poses[-1].tolist()
    assert said.json["settled"] == expected.settled_at
    assert said.json["formation_error"] < 0.01
    assert said.json["lambda2"] == pytest.approx({"start": 4.0, "least": 4.0, "time": 0.0, "end": 4.0})
    words = [part for name, x in zip("ABCD", (-3, -1, 1, 3), strict=True) for part in ("--offset", f"{name}={x},0")]
    row = taut("steer", "team.yaml", "--json", *words).json
    assert row["formation_error"] < 0.01
    assert [robot["pose"][0] - row["robots"][0]["pose"][0] for robot in row["robots"]] == pytest.approx(
        [0, 2, 4, 6], abs=0.02
    )


def test_a_run_is_told_for_people_with_its_pictures(taut: Command, tmp_path: Path) -> None:
    said = taut("steer", "team.yaml", "--reach", "8", "--figure", "team.png", "--animate", "team.gif")
    assert said.code == 0, said.err
    for words in ("settled", "formation", "λ2", "links lost  none", "collisions  none", "wrote team.png"):
        assert words in said.out
    assert (tmp_path / "team.png").stat().st_size > 10_000
    assert (tmp_path / "team.gif").read_bytes().startswith(b"GIF89a")


@pytest.mark.parametrize("vehicle", ["integrator", "unicycle", "differential", "ackermann"])
def test_points_gather_where_the_law_says(taut: Command, vehicle: str) -> None:
    told = taut("steer", "points.yaml", "--law", "consensus", "--vehicle", vehicle, "--json").json
    assert told["spread"] < 0.1
    assert told["formation_error"] is None
    assert told["links_lost"] is None
    led = taut("steer", "points.yaml", "--law", "leader", "--leader", "B", "--vehicle", vehicle, "--json").json
    for robot in led["robots"]:
        assert robot["pose"][:2] == pytest.approx([4, 1.5], abs=0.1)


def test_rendezvous_keeps_the_links_and_says_so(taut: Command) -> None:
    said = taut("steer", "points.yaml", "--law", "rendezvous", "--reach", "7", "--vehicle", "integrator", "--json")
    assert said.code == 0, said.err
    assert said.json["links_lost"] == []
    assert said.json["lambda2"]["least"] > 0


def test_lost_links_are_named_with_their_time(taut: Command) -> None:
    words = [part for name, x in zip("ABCD", (0, 0, -9, 0), strict=True) for part in ("--offset", f"{name}={x},{x}")]
    lost = taut("steer", "points.yaml", "--reach", "4", *words, "--json").json["links_lost"]
    assert {"C"} <= {name for link in lost for name in link["robots"]}
    assert all(link["time"] > 0 for link in lost)


def test_collisions_end_with_code_1(taut: Command) -> None:
    said = taut("steer", "team.yaml", "--law", "consensus")
    assert said.code == 1
    assert "A" in said.out
    assert said.err.startswith("taut: error: team.yaml: ")
    assert "collision" in said.err


def test_a_team_that_has_not_settled_ends_with_code_1(taut: Command) -> None:
    said = taut("steer", "team.yaml", "--seconds", "2")
    assert said.code == 1
    assert "settled     no" in said.out
    assert said.err == "taut: error: team.yaml: not settled after 2 s\n"


def test_of_many_robots_the_worst_are_told(taut: Command, tmp_path: Path) -> None:
    robots = "".join(f"  - {{name: N{k}, start: [{k}, 1], goal: [{k}, 2], radius: 0.1}}\n" for k in range(1, 12))
    (tmp_path / "many.yaml").write_text(TEAM[: TEAM.index("  - ")] + robots)
    assert "the worst 10 of 11" in taut("steer", "many.yaml").out
    assert "worst" not in taut("steer", "many.yaml", "--robots").out


@pytest.mark.parametrize(
    ("words", "said"),
    [
        (["--reach", "0"], "--reach"),
        (["--reach", "nan"], "--reach"),
        (["--law", "rendezvous"], "--reach"),
        (["--law", "dance"], "--law"),
        (["--law", "consensus", "--offset", "A=1,1"], "--offset"),
        (["--offset", "A=1"], "--offset"),
        (["--offset", "A=1,inf"], "--offset"),
        (["--offset", "A=1,1"], "every robot"),
        (["--offset", "Z=1,1"], "Z"),
        (["--leader", "A"], "--leader"),
        (["--law", "leader", "--leader", "Z"], "Z"),
        (["--dies", "A@never"], "--dies"),
        (["--slow", "Z@0.5"], "Z"),
        (["--speed-error", "2"], "speed error"),
        (["--step", "0"], "step"),
        (["--seconds", "-1"], "time"),
        (["--settled", "1"], "settled"),
        (["--figure", "team.yaml"], "figure"),
    ],
)
def test_bad_parameters_are_refused_in_one_line(taut: Command, words: list[str], said: str) -> None:
    assert refused(taut("steer", "team.yaml", *words), said)


@pytest.mark.parametrize("law", [["consensus"], ["formation"], ["leader"], ["rendezvous", "--reach", "1"]])
def test_a_scene_without_robots_has_settled(taut: Command, tmp_path: Path, law: list[str]) -> None:
    (tmp_path / "none.yaml").write_text(TEAM[: TEAM.index("robots")] + "robots: []\n")
    assert taut("steer", "none.yaml", "--law", *law, "--json").json["settled"] == 0


def test_what_json_cannot_say_is_null(taut: Command) -> None:
    told = taut("steer", "team.yaml", "--seconds", "1", "--json").out
    assert json.loads(told)["settled"] is None
