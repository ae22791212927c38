"""The command travel leads a formation, says where it was narrow, and refuses in one line."""

from __future__ import annotations

from pathlib import Path

import pytest

from commands import Command, command_in, refused
from taut import Rectangle, Robot, Scene, certify, load_plan, save


@pytest.fixture
def door(tmp_path: Path) -> Path:
    """A wedge of three in front of a door that is a robot and a half wide."""
    starts = {"leader": (5.0, 5.0), "left": (3.5, 6.5), "right": (3.5, 3.5)}
    robots = [Robot(name, (x, y), (x + 14, y), 0.3) for name, (x, y) in starts.items()]
    walls = [Rectangle(11, -1, 1, 5.5, name="W1"), Rectangle(11, 5.5, 1, 6, name="W2")]
    path = tmp_path / "door.yaml"
    save(Scene((0, 0, 24, 10), walls, robots), path)
    return path


@pytest.fixture
def taut(tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]) -> Command:
    return command_in(tmp_path, monkeypatch, capsys)


def test_a_formation_goes_through_a_door(taut: Command, door: Path) -> None:
    target = door.with_name("plan.json")
    said = taut("travel", door, "--contact", "4", "-o", target)
    assert said.code == 0
    assert "near (1" in said.out
    assert "formation error at most" in said.out
    plan = load_plan(target)
    assert plan.planner["method"] == "formation"
    assert certify(plan).ok
    assert taut("verify", target, "--contact", "4").code == 0


def test_offsets_place_the_followers(taut: Command, door: Path) -> None:
    said = taut("travel", door, "--offset", "left=-1,0.8", "--offset", "right=-1,-0.8", "--json")
    assert said.code == 0
    report = said.json
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
def test_bad_words_are_refused_in_one_line(taut: Command, door: Path, words: list[str], said: str) -> None:
    assert refused(taut("travel", door, *words), said)
