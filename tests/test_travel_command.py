"""The command travel leads a formation, says where it was narrow, and refuses in one line."""

from __future__ import annotations

import json
from pathlib import Path

import pytest

from taut import Rectangle, Robot, Scene, certify, load_plan, save
from taut.cli import main


@pytest.fixture
def door(tmp_path: Path) -> Path:
    """A wedge of three in front of a door that is a robot and a half wide."""
    starts = {"leader": (5.0, 5.0), "left": (3.5, 6.5), "right": (3.5, 3.5)}
    robots = [Robot(name, (x, y), (x + 14, y), 0.3) for name, (x, y) in starts.items()]
    walls = [Rectangle(11, -1, 1, 5.5, name="W1"), Rectangle(11, 5.5, 1, 6, name="W2")]
    path = tmp_path / "door.yaml"
    save(Scene((0, 0, 24, 10), walls, robots), path)
    return path


def test_a_formation_goes_through_a_door(door: Path, capsys: pytest.CaptureFixture[str]) -> None:
    target = door.with_name("plan.json")
    assert main(["travel", str(door), "--contact", "4", "-o", str(target)]) == 0
    said = capsys.readouterr().out
    assert "near (1" in said
    assert "formation error at most" in said
    plan = load_plan(target)
    assert plan.planner["method"] == "formation"
    assert certify(plan).ok
    assert main(["verify", str(target), "--contact", "4"]) == 0


def test_offsets_place_the_followers(door: Path, capsys: pytest.CaptureFixture[str]) -> None:
    words = ["travel", str(door), "--offset", "left=-1,0.8", "--offset", "right=-1,-0.8", "--json"]
    assert main(words) == 0
    report = json.loads(capsys.readouterr().out)
    assert report["certificate"]["ok"] if "certificate" in report else report["ok"]
    assert report["narrow"]
    assert report["formation_error"] > 0


@pytest.mark.parametrize(
    ("words", "said"),
    [
        (["--offset", "left"], "must be like R2=-1,0.5"),
        (["--leader", "nobody"], "nobody"),
        (["--keep", "-1"], "keep must be"),
        (["--sight"], "--contact"),
        (["--contact", "0.5"], "contact"),
    ],
)
def test_bad_words_are_refused_in_one_line(
    door: Path, words: list[str], said: str, capsys: pytest.CaptureFixture[str]
) -> None:
    assert main(["travel", str(door), *words]) == 2
    error = capsys.readouterr().err
    assert said in error
    assert len(error.strip().splitlines()) == 1
