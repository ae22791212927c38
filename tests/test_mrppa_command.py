"""`taut plan --method mrppa`, `--explain` and `--stages`."""

from __future__ import annotations

import json
from pathlib import Path

import pytest

from commands import Command, command_in, refused


@pytest.fixture
def taut(tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]) -> Command:
    return command_in(tmp_path, monkeypatch, capsys, "plan")


def test_the_story_is_told_stage_by_stage(taut: Command) -> None:
    code, out, err = taut("thesis-1", "--method", "mrppa", "--explain")
    assert (code, err) == (0, "")
    heads = [line for line in out.splitlines() if line[:1].isdigit() or line[:2].strip().isdigit()]
    assert [head.split(". ")[1] for head in heads[:4]] == [
        "Free space",
        "Obstacle graph",
        "Split in two",
        "Bridge for R1",
    ]
    assert "10 components, so λ2 = 0." in out
    assert "raises λ2 most, from 0 to" in out
    assert "All 149 edges on 28 vertices" in out
    assert "R1 goes its shortest way unhindered." in out


def test_every_method_explains_what_was_met(taut: Command) -> None:
    code, out, _ = taut("hospital-12", "--explain")
    assert code == 0
    assert out.startswith("1. Planned in sequence\n")
    assert "it takes another way" in out


def test_json_holds_the_stages_when_they_are_asked_for(taut: Command) -> None:
    _, out, _ = taut("thesis-2", "--method", "mrppa", "--json", "--explain")
    stages = json.loads(out)["stages"]
    assert [stage["kind"] for stage in stages[:3]] == ["free space", "obstacle graph", "split"]
    assert stages[-1]["certified"] is True
    _, out, _ = taut("thesis-2", "--method", "mrppa", "--json")
    assert json.loads(out)["stages"] == []


def test_stages_are_written_with_an_index(taut: Command, tmp_path: Path) -> None:
    code, out, _ = taut("corridor-swap", "--method", "mrppa", "--stages", "out")
    assert code == 0
    assert "wrote out/stages.json" in out.replace("\\", "/")
    index = json.loads((tmp_path / "out" / "stages.json").read_text(encoding="utf-8"))
    files = [name for entry in index["stages"] for name in entry["files"]]
    assert sorted(p.name for p in (tmp_path / "out").iterdir()) == sorted([*files, "stages.json"])


def test_a_split_and_a_weight_by_hand(taut: Command) -> None:
    words = ("thesis-1", "--method", "mrppa", "--explain", "--weight", "distance")
    code, out, _ = taut(*words, "--split", "O1, O2,R1 start", "--split", "R2 start")
    assert code == 0
    assert "The split was given by hand." in out
    assert "One side: O1, O2, R1 start, R2 start." in out


def test_names_with_commas_have_an_option_of_their_own(taut: Command, tmp_path: Path) -> None:
    (tmp_path / "odd.yaml").write_text(
        "taut: 1\nname: odd\nbounds: [0, 0, 10, 10]\nobstacles:\n"
        '  - {name: "a,b", rectangle: [2, 2, 1, 1]}\n  - {name: c, rectangle: [6, 6, 1, 1]}\n'
        "robots:\n  - {name: R1, start: [1, 1], goal: [9, 9]}\n"
    )
    code, out, _ = taut("odd.yaml", "--method", "mrppa", "--explain", "--split", "a,b")
    assert code == 0
    assert "One side: a,b, R1 start." in out


@pytest.mark.parametrize(
    ("words", "parts"),
    [
        (("--weight", "distance"), ("--weight", "--method mrppa")),
        (("--split", "O1"), ("--split", "--method mrppa")),
        (("--method", "mrppa", "--split", "O9"), ("thesis-1: split: 'O9' is not in the scene",)),
        (("--method", "mrppa", "--split", ","), ("split: nothing is on the side given",)),
        (("--method", "mrppa", "--weight", "heavy"), ("heavy", "--weight")),
        (("--stages", "a-file"), ("a-file", "not a folder")),
        (("--stages", "full"), ("full", "not stages")),
        (("--stages", "new", "-o", "new/plan.json"), ("new",)),
    ],
)
def test_what_does_not_fit_is_refused_at_once(
    words: tuple[str, ...], parts: tuple[str, ...], taut: Command, tmp_path: Path
) -> None:
    (tmp_path / "a-file").write_text("")
    (tmp_path / "full").mkdir()
    (tmp_path / "full" / "precious.txt").write_text("mine")
    before = sorted(tmp_path.rglob("*"))
    assert refused(taut("thesis-1", *words), *parts)
    assert sorted(tmp_path.rglob("*")) == before


def test_outputs_do_not_mix_with_stages(taut: Command, tmp_path: Path) -> None:
    (tmp_path / "X").mkdir()
    assert refused(taut("thesis-1", "-o", "X/plan.json", "--stages", "X"), "choose another folder")
    assert list((tmp_path / "X").iterdir()) == []


def test_an_unlisted_stage_in_the_folder_is_not_replaced(taut: Command, tmp_path: Path) -> None:
    folder = tmp_path / "D"
    folder.mkdir()
    (folder / "stages.json").write_text('{"taut": 1, "kind": "stages", "stages": []}')
    (folder / "03-split.txt").write_text("precious")
    assert refused(taut("thesis-1", "--stages", "D"), "03-split.txt", "move it away")
    assert (folder / "03-split.txt").read_text() == "precious"
