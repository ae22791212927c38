"""The command compare: it tells what the library found, all of it in JSON, and refuses in one line."""

from __future__ import annotations

import re
from pathlib import Path
from typing import Any

import pytest

from commands import Command, command_in, on_scenes, refused
from taut.comparison import compare as compare_ways
from taut.comparison import compare_random, summary
from taut.formats import load_scene
from taut.route.ways import WAYS

ROOM = """\
taut: 1
name: room
bounds: [0, 0, 8, 6]
gap: 0.1
obstacles:
  - {name: box, polygon: [[3, 0], [5, 0], [5, 3], [3, 3]]}
robots:
  - {name: R1, start: [1, 1], goal: [7, 1]}
  - {name: R2, start: [1, 5.5], goal: [7, 2], radius: 0.2}
"""
WALLED = """\
taut: 1
gap: 0.1
bounds: [0, 0, 4, 3]
obstacles: [{name: wall, polygon: [[1.5, -1], [2, -1], [2, 4], [1.5, 4]]}]
robots:
  - {name: R1, start: [1, 1], goal: [2.3, 1]}
  - {name: R2, start: [0.5, 2], goal: [0.5, 1]}
"""
TRIAL = {
    "robot", "solved", "reason", "points", "length", "ratio", "clearance", "turns", "turning", "vertices", "edges",
    "obstacles", "seconds",
}  # fmt: skip
SUMMARY = {
    "way", "solved", "robots", "mean_ratio", "worst_ratio", "length", "mean_clearance", "least_clearance", "mean_turns",
    "mean_turning", "vertices", "edges", "obstacles", "build_seconds", "query_seconds", "trials",
}  # fmt: skip


@pytest.fixture
def compare(tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]) -> Command:
    return on_scenes(command_in(tmp_path, monkeypatch, capsys, "compare"))


def rows(text: str, head: str) -> list[list[str]]:
    """Return the cells of the table whose heads begin so, row by row."""
    lines = iter(text.splitlines())
    next(line for line in lines if line.startswith(head))
    next(lines)
    out = []
    for line in lines:
        if not line or line.startswith(("wrote", "(")):
            break
        out.append(re.split(r" {3,}", line.strip()))
    return out


def test_tables_hold_what_the_library_finds(compare: Command) -> None:
    run = compare(ROOM)
    assert run.code == 0, run.err
    assert run.err == ""
    found = compare_ways(load_scene("scene.yaml"))
    quality, effort = rows(run.out, "way"), rows(run.out, "robot")
    assert [row[0] for row in quality] == list(WAYS)
    for row, entry in zip(quality, found.entries, strict=True):
        total = summary(entry)
        assert row[1] == f"{total.solved} of 2"
        assert row[2] == ("–" if total.mean_ratio is None else f"{total.mean_ratio:.4f}")
        assert row[3] == ("–" if total.worst_ratio is None else f"{total.worst_ratio:.4f}")
        assert row[5] == ("–" if total.least_clearance is None else f"{abs(total.least_clearance):.4f}")
    assert [row[:2] for row in effort] == [["R1", "7.6569"], ["R2", f"{found.shortest[1]:.4f}"]]
    assert [row[2] for row in effort] == ["1.0000", "1.0000"]


def test_json_holds_everything(compare: Command) -> None:
    report = compare(ROOM, "--json", "--seed", "4").json
    assert set(report) == {"scene", "seed", "robots", "blocked", "ways", "files"}
    assert (report["scene"], report["seed"], report["files"], report["blocked"]) == ("room", 4, [], {})
    assert [way["way"] for way in report["ways"]] == list(WAYS)
    found = compare_ways(load_scene("scene.yaml"), seed=4)
    for way, entry in zip(report["ways"], found.entries, strict=True):
        assert set(way) == SUMMARY
        for told, trial in zip(way["trials"], entry.trials, strict=True):
            assert set(told) == TRIAL
            assert told["points"] == (None if trial.points is None else trial.points.tolist())
            for key in ("solved", "reason", "length", "ratio", "clearance", "turns", "turning", "vertices", "edges"):
                assert told[key] == getattr(trial, key), key


def test_roadmaps_choose_the_ways_in_their_order(compare: Command) -> None:
    report = compare(ROOM, "--roadmaps", "grid, visibility,grid", "--json").json
    assert [way["way"] for way in report["ways"]] == ["grid", "visibility"]


def test_robots_nobody_solves_are_no_failure_of_the_command(compare: Command) -> None:
    run = compare(WALLED, "--roadmaps", "visibility,grid")
    assert run.code == 0
    assert [row[1] for row in rows(run.out, "way")] == ["1 of 2", "1 of 2"]
    failed = rows(run.out, "not solved by")
    assert [row[:2] for row in failed] == [["visibility", "R1"], ["grid", "R1"]]
    assert all("separate" in row[2] for row in failed)
    report = compare(WALLED, "--roadmaps", "visibility", "--json").json
    assert report["robots"][0] == {"name": "R1", "shortest": None}


def test_many_robots_are_told_one_by_one_only_when_asked(compare: Command) -> None:
    words = ("hospital-12", "--roadmaps", "visibility")
    assert "shortest (m)" not in compare(*words).out
    assert len(rows(compare(*words, "--robots").out, "robot")) == 12


def test_random_scenes_are_summed_up_by_their_quartiles(compare: Command) -> None:
    words = (ROOM, "--random", "4", "--seed", "7", "--roadmaps", "visibility,prm")
    report = compare(*words, "--json").json
    assert set(report) == {"scene", "seed", "count", "ways", "scenes", "files"}
    assert (report["count"], len(report["scenes"])) == (4, 4)
    found = compare_random(load_scene("scene.yaml"), 4, ["visibility", "prm"], seed=7)
    assert [one["scene"] for one in report["scenes"]] == [one.scene.name for one in found]
    for k, way in enumerate(report["ways"]):
        ratios = sorted(trial.ratio or 0 for one in found for trial in one.entries[k].trials)
        assert (way["solved"], way["robots"]) == (8, 8)
        assert way["ratio"]["least"] == ratios[0]
        assert way["ratio"]["greatest"] == ratios[-1]
        assert way["ratio"]["median"] == pytest.approx((ratios[3] + ratios[4]) / 2)
    told = rows(compare(*words).out, "way")
    assert [row[:2] for row in told] == [["visibility", "100 %"], ["prm", "100 %"]]
    assert told[1][2].startswith(f"{report['ways'][1]['ratio']['median']:.3f} (")


def test_clearances_are_swept_and_who_is_swallowed_is_told(compare: Command) -> None:
    run = compare(ROOM, "--clearance", "0:1.2:0.3")
    assert run.code == 0, run.err
    table = rows(run.out, "D_s (m)")
    assert sorted({row[0] for row in table}) == ["0", "0.3", "0.6", "0.9", "1.2"]
    ways = [row[1] for row in table]
    assert ways[:2] == ["visibility", "oca"]
    assert [row[2] for row in table if row[1] == "visibility"] == ["2 of 2", "2 of 2", "1 of 2", "1 of 2", "0 of 2"]
    swallowed = {row[0]: row for row in rows(run.out, "no room for")}
    assert swallowed["R2"][1] == "0.6"
    assert "start (1, 5.5) is only 0.5 m from the wall" in swallowed["R2"][2]
    assert "at most 0.3 m" in swallowed["R2"][2]
    assert swallowed["R1"][1] == "1.2"
    report = compare(ROOM, "--clearance", "0:1.2:0.3", "--json", "--roadmaps", "oca").json
    assert report["clearances"] == [0, 0.3, 0.6, 0.9, 1.2]
    lengths: list[Any] = [step["ways"][0]["trials"][0]["length"] for step in report["steps"]]
    assert lengths[-1] is None
    assert lengths[:-1] == sorted(lengths[:-1])
    assert set(report["steps"][-1]["blocked"]) == {"R1", "R2"}


def test_a_clearance_in_the_scene_that_swallows_a_start_does_not_stop_a_sweep(compare: Command) -> None:
    scene = ROOM.replace("gap: 0.1", "gap: 0.1\nclearance: 0.6")
    assert refused(compare(scene), "R2", "start")
    assert compare(scene, "--clearance", "0:0.2:0.1").code == 0


@pytest.mark.parametrize("words", [(), ("--random", "2"), ("--clearance", "0:0.4:0.2")])
@pytest.mark.parametrize("kind", ["png", "svg", "pdf"])
def test_figures_are_written(compare: Command, words: tuple[str, ...], kind: str) -> None:
    run = compare(ROOM, *words, "--roadmaps", "visibility,cells", "--figure", f"out.{kind}")
    assert run.code == 0, run.err
    assert run.out.endswith(f"wrote out.{kind}\n")
    assert Path(f"out.{kind}").stat().st_size > 5000


@pytest.mark.parametrize(
    ("words", "said"),
    [
        (("--clearance", "0:1"), ("--clearance", "three numbers like 0:1:0.1")),
        (("--clearance", "0:1:x"), ("three numbers", "0:1:x")),
        (("--clearance", "0:1:0"), ("steps above 0 m",)),
        (("--clearance", "0:1:-0.1"), ("steps above 0 m",)),
        (("--clearance=-1:1:0.1",), ("begin below 0 m",)),
        (("--clearance", "1:0:0.1"), ("must not end at 0 m below its begin, 1 m",)),
        (("--clearance", "0:1:0.0001"), ("1,000 clearances, not 10,001",)),
        (("--clearance", "0:inf:1"), ("up to 1e9",)),
        (("--clearance", "nan:1:1"), ("up to 1e9",)),
        (("--clearance", "0:1e999999:1"), ("up to 1e9",)),
        (("--clearance", "0:1:0.5", "--random", "3"), ("--clearance", "--random", "choose one")),
        (("--clearance", "0:1:0.5", "--robots"), ("--robots", "--clearance")),
        (("--random", "3", "--robots"), ("--robots", "--random")),
        (("--random", "0"), ("--random",)),
        (("--random", "many"), ("--random", "integer")),
        (("--seed", "-1"), ("--seed",)),
        (("--roadmaps", "visibility,teleport"), ("--roadmaps", "'teleport' is unknown", "visibility")),
        (("--roadmaps", ","), ("--roadmaps", "names none")),
        (("--figure", "out.txt"), ("out.txt", ".png")),
        (("--figure", "nowhere/out.png"), ("nowhere",)),
    ],
)
def test_bad_options_are_refused_in_one_line(compare: Command, words: tuple[str, ...], said: tuple[str, ...]) -> None:
    assert refused(compare(ROOM, *words), *said)


def test_bad_scenes_are_refused_in_one_line(compare: Command) -> None:
    assert refused(compare("no-such-scene"), "no-such-scene")
    inside = ROOM.replace("start: [1, 1]", "start: [4, 1]")
    assert refused(compare(inside), "scene.yaml", "R1", "box")
    crossed = ROOM.replace("[5, 0], [5, 3]", "[5, 3], [5, 0]")
    for words in ((), ("--random", "2"), ("--clearance", "0:1:0.5")):
        assert refused(compare(crossed, *words), "box")
