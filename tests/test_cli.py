"""The command: what it prints, what it writes, and how it refuses."""

from __future__ import annotations

import json
import os
import subprocess
import sys
import warnings
from pathlib import Path
from typing import Any

import pytest
from rich.cells import cell_len

from commands import Command, command_in, refused
from taut.cli.tables import say_table
from taut.errors import NoPlanFound, SceneError

HALL = """\
taut: 1
name: hall
bounds: [0, 0, 10, 10]
gap: 0.05
obstacles:
  - {name: box, polygon: [[4, 3], [6, 3], [6, 7], [4, 7]]}
robots:
  - {name: R1, start: [1, 5], goal: [9, 5], speed: 4, radius: 0.3}
  - {name: R2, start: [9, 8], goal: [1, 8], radius: 0.3, speed: 5}
"""


@pytest.fixture
def taut(tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]) -> Command:
    return command_in(tmp_path, monkeypatch, capsys)


@pytest.fixture
def hall(tmp_path: Path) -> Path:
    path = tmp_path / "hall.yaml"
    path.write_text(HALL)
    return path


@pytest.fixture
def plan(taut: Command, hall: Path) -> Path:
    assert taut("plan", hall, "-o", "plan.json").code == 0
    return hall.with_name("plan.json")


# --- bad input ---

BAD_SCENES: dict[str, tuple[str, str, tuple[str, ...]]] = {
    "unknown key": ("gap: 0.05", "gap: 0.05\nhaedway: 1", ("haedway", ":5")),
    "unknown key of a robot": ("speed: 5", "sped: 5", ("sped", ":9")),
    "duplicate key": ("gap: 0.05", "gap: 0.05\ngap: 0.1", ("gap",)),
    "no robots": (HALL[HALL.index("robots:") :], "", ("robots",)),
    "NaN": ("goal: [9, 5]", "goal: [.nan, 5]", ("R1",)),
    "self-crossing polygon": ("[6, 3], [6, 7]", "[6, 7], [6, 3]", ("box", "5, 5")),
    "zero area": ("[[4, 3], [6, 3], [6, 7], [4, 7]]", "[[4, 3], [6, 3], [5, 3]]", ("box", "area")),
    "start inside": ("start: [1, 5]", "start: [4.5, 5]", ("R1", "box", "0.5 m")),
    "start too close": ("start: [1, 5]", "start: [3.8, 5]", ("R1", "box", "0.2 m", "0.3 m")),
    "goal inside": ("goal: [9, 5]", "goal: [5.5, 5]", ("R1", "box", "goal")),
    "goal outside": ("goal: [9, 5]", "goal: [19, 5]", ("R1", "goal")),
    "starts on each other": ("start: [9, 8]", "start: [1, 5.2]", ("R1", "R2")),
    "duplicate names": ("name: R2", "name: R1", ("R1",)),
    "speed 0": ("speed: 5", "speed: 0", ("R2", "speed")),
    "negative radius": ("radius: 0.3, speed", "radius: -0.3, speed", ("R2", "radius")),
    "bad word": ("gap: 0.05", "at_goal: vanish", ("at_goal",)),
    "not YAML": ("bounds: [", "bounds: ]", ("hall.yaml",)),
    "other version": ("taut: 1", "taut: 7", ("7",)),
}


@pytest.mark.parametrize("case", BAD_SCENES)
@pytest.mark.parametrize("command", ["plan", "check"])
def test_a_bad_scene_is_refused_in_one_line_and_nothing_is_written(
    taut: Command, hall: Path, case: str, command: str
) -> None:
    old, new, words = BAD_SCENES[case]
    assert old in HALL
    hall.write_text(HALL.replace(old, new, 1))
    run = taut("plan", hall, "-o", "plan.json", "--figure", "plan.png") if command == "plan" else taut("check", hall)
    assert refused(run, *words)
    assert run.out == ""
    assert os.listdir(hall.parent) == ["hall.yaml"]


def test_point_robots_need_a_gap(taut: Command, hall: Path) -> None:
    hall.write_text(HALL.replace("gap: 0.05\n", "").replace("radius: 0.3", "radius: 0"))
    assert refused(taut("plan", hall), "gap")


GARBAGE: dict[str, bytes] = {
    "empty": b"",
    "only a comment": b"# nothing\n",
    "a list": b"- 1\n- 2\n",
    "binary": bytes(range(256)) * 8,
    "zeros": b"\0" * 4096,
    "50 MB": b"\x93 garbage { [ : \n" * 3_000_000,
    "50 MB of one line": b"a" * 50_000_000,
    "nested": b"[" * 100_000,
}


@pytest.mark.parametrize("name", ["scene.yaml", "scene.json", "scene.geojson"])
@pytest.mark.parametrize("case", GARBAGE)
def test_garbage_is_refused_in_one_line(taut: Command, tmp_path: Path, case: str, name: str) -> None:
    (tmp_path / name).write_bytes(GARBAGE[case])
    assert refused(taut("plan", name, "-o", "plan.json"), name)
    assert refused(taut("show", name), name)
    assert os.listdir(tmp_path) == [name]


@pytest.mark.parametrize("case", GARBAGE)
def test_a_garbage_plan_is_refused_in_one_line(taut: Command, tmp_path: Path, case: str) -> None:
    (tmp_path / "plan.json").write_bytes(GARBAGE[case])
    assert refused(taut("verify", "plan.json"), "plan.json")


@pytest.mark.parametrize("command", ["plan", "check", "show", "graph", "verify"])
def test_a_missing_file_and_a_directory_are_refused(taut: Command, tmp_path: Path, command: str) -> None:
    (tmp_path / "dir.yaml").mkdir()
    (tmp_path / "dir.json").mkdir()
    assert refused(taut(command, "nowhere.yaml"), "nowhere.yaml")
    assert refused(taut(command, "dir.yaml"), "dir.yaml")
    assert refused(taut(command, "dir.json"), "dir.json")
    assert refused(taut(command, tmp_path))


def test_a_misspelt_ready_scene_is_refused(taut: Command) -> None:
    assert refused(taut("plan", "thesis-9"), "thesis-9")


def test_a_cut_off_goal_is_exit_code_1_with_the_reason(taut: Command, hall: Path) -> None:
    wall = "obstacles:\n  - {name: wall, line: [[7, 0], [7, 10]], width: 0.2}"
    hall.write_text(HALL.replace("obstacles:", wall))
    assert refused(taut("plan", hall, "-o", "plan.json"), "R1", code=1)
    assert os.listdir(hall.parent) == ["hall.yaml"]
    run = taut("check", hall)
    assert refused(run, "2 of 2", "R1", code=1)
    assert "no way" in run.out


# --- outputs are checked before the work ---


@pytest.mark.parametrize(
    ("option", "name", "word"),
    [
        ("-o", "plan.txt", ".json"),
        ("-o", "plan", ".json"),
        ("-o", "missing/plan.json", "directory"),
        ("-o", "hall.yaml/plan.json", "directory"),
        ("-o", "folder.json", "not a file"),
        ("-o", "input.json", "replace"),
        ("-o", "/proc/plan.json", "cannot be written"),
        ("-o", "a\0b.json", "null"),
        ("-o", "x" * 5000 + ".json", "written"),
        ("--figure", "plan.docx", ".png"),
        ("--figure", "missing/plan.png", "directory"),
        ("--animate", "plan.png", ".gif"),
        ("--animate", "missing/plan.gif", "directory"),
    ],
)
def test_an_output_that_cannot_be_written_is_refused_before_planning(
    taut: Command, hall: Path, monkeypatch: pytest.MonkeyPatch, option: str, name: str, word: str
) -> None:
    def never(*_: object, **__: object) -> None:
        raise AssertionError("planned although the output cannot be written")

    if name.startswith("/proc") and not Path("/proc/self").exists():
        name = "missing/plan.json"
        word = "directory"
    monkeypatch.setattr("taut.team.plan", never)
    (hall.parent / "folder.json").mkdir()
    hall.with_name("input.json").write_text("{}")
    source = "input.json" if name == "input.json" else "hall.yaml"
    before = sorted(os.listdir(hall.parent))
    assert refused(taut("plan", source, option, name), word)
    assert sorted(os.listdir(hall.parent)) == before


def test_a_film_without_ffmpeg_is_refused(taut: Command, hall: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("PATH", str(hall.parent))
    assert refused(taut("plan", hall, "--animate", "plan.mp4"), "ffmpeg", ".gif")


def test_wrong_command_lines_are_refused_in_one_line(taut: Command, hall: Path) -> None:
    assert refused(taut("plna", hall), "plna", "--help")
    assert refused(taut("plan"), "SCENE")
    assert refused(taut("plan", hall, "--colour", "red"), "--colour")
    assert refused(taut("plan", hall, "--order", "alphabetical"), "shortest")
    assert refused(taut("plan", hall, "--method", "magic"), "prioritized")
    assert refused(taut("plan", hall, "--seconds", "nan"), "--seconds")
    assert refused(taut("plan", hall, "--seconds", "-1"), "--seconds")
    assert refused(taut("plan", hall, "--rounds", "0"), "--rounds")
    assert refused(taut("plan", hall, "--rounds", "99999999999999999999"), "--rounds", "1000000")
    assert refused(taut("plan", hall, "--seed", "1.5"), "--seed")
    assert refused(taut("plan", hall, "--graph"), "--figure")
    assert refused(taut("random", "--robots", "-1"), "--robots")
    assert refused(taut("random", "--radius", "thin"), "--radius")
    assert refused(taut("random", "--radius", "1,2,3"), "--radius")
    assert refused(taut("random", "--size", "1", "--robots", "50"), "larger size")
    assert refused(taut("random", "--size", "1e300"), "size", "1e+07 m")
    assert refused(taut("random", "-o", "scene.txt"), ".yaml")


def test_help_and_version(taut: Command) -> None:
    import taut as package

    bare = taut()
    assert bare.code == 2
    assert "warmup" in bare.out
    assert taut("--help").code == 0
    assert "--order" in taut("plan", "--help").out
    assert taut("--version").out == f"taut {package.__version__}\n"


# --- failures inside ---


def broken(monkeypatch: pytest.MonkeyPatch, error: BaseException) -> None:
    def fail(*_: object, **__: object) -> None:
        raise error

    monkeypatch.setattr("taut.formats.load_scene", fail)


def test_an_error_inside_is_one_line_unless_debug(taut: Command, monkeypatch: pytest.MonkeyPatch) -> None:
    broken(monkeypatch, ZeroDivisionError("by zero\nand more"))
    assert refused(taut("check", "x"), "internal error", "report", "--debug", "ZeroDivisionError", code=70)
    for words in (("--debug", "check", "x"), ("check", "x", "--debug")):
        run = taut(*words)
        assert run.code == 70
        assert "Traceback" in run.err


def test_an_interrupt_is_exit_code_130(taut: Command, monkeypatch: pytest.MonkeyPatch) -> None:
    broken(monkeypatch, KeyboardInterrupt())
    assert refused(taut("check", "x"), "interrupted", code=130)


def test_an_interrupt_inside_compiled_code_is_exit_code_130(taut: Command, monkeypatch: pytest.MonkeyPatch) -> None:
    wrapped = SystemError("<built-in function search> returned a result with an exception set")
    wrapped.__cause__ = KeyboardInterrupt()
    broken(monkeypatch, wrapped)
    assert refused(taut("check", "x"), "interrupted", code=130)
    buried = RuntimeError("cannot clean up")
    buried.__context__ = wrapped
    broken(monkeypatch, buried)
    assert refused(taut("check", "x"), "interrupted", code=130)


def test_an_interrupt_while_the_libraries_load_is_exit_code_130(taut: Command, monkeypatch: pytest.MonkeyPatch) -> None:
    class Interrupting:
        @staticmethod
        def find_spec(name: str, *_: object) -> None:
            if name == "taut.cli.application":
                raise KeyboardInterrupt

    monkeypatch.delitem(sys.modules, "taut.cli.application", raising=False)
    monkeypatch.setattr(sys, "meta_path", [Interrupting, *sys.meta_path])
    assert refused(taut("scenes"), "interrupted", code=130)


def test_remarks_of_libraries_are_not_shown(taut: Command, monkeypatch: pytest.MonkeyPatch) -> None:
    def remark(*_: object, **__: object) -> None:
        warnings.warn("overflow encountered in multiply", RuntimeWarning, stacklevel=1)
        raise SceneError("is empty")

    monkeypatch.setattr("taut.formats.load_scene", remark)
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        assert refused(taut("check", "x"), "is empty")


def test_an_error_of_the_system_is_one_line(taut: Command, monkeypatch: pytest.MonkeyPatch) -> None:
    broken(monkeypatch, PermissionError(13, "Permission denied", "x"))
    assert refused(taut("check", "x"), "x: Permission denied")


def test_a_closed_pipe_is_quiet(hall: Path) -> None:
    command = [sys.executable, "-m", "taut", "random", "--robots", "2", "--obstacles", "400"]
    with subprocess.Popen(command, stdout=subprocess.PIPE, stderr=subprocess.PIPE) as process:
        assert process.stdout is not None
        assert process.stderr is not None
        process.stdout.close()
        said = process.stderr.read()
    assert said == b""
    assert process.returncode == 141


def in_a_shell(words: str) -> subprocess.CompletedProcess[str]:
    command = f'exec "{sys.executable}" -m taut {words}'
    return subprocess.run(["sh", "-c", command], capture_output=True, text=True, check=False)


@pytest.mark.skipif(os.name == "nt", reason="needs a POSIX shell")
def test_closed_streams_change_no_exit_code(hall: Path) -> None:
    assert in_a_shell("scenes >&-").returncode == 0
    assert in_a_shell("scenes 2>&-").returncode == 0
    assert in_a_shell("check nowhere.yaml 2>&-").returncode == 2
    done = in_a_shell("check nowhere.yaml >&-")
    assert (done.returncode, done.stderr.count("\n")) == (2, 1)
    assert "nowhere.yaml" in done.stderr
    assert in_a_shell("check nowhere.yaml >&- 2>&-").returncode == 2
    done = in_a_shell(f"check '{hall}' >&-")
    assert (done.returncode, done.stderr) == (0, "")


@pytest.mark.skipif(not Path("/dev/full").exists(), reason="needs /dev/full")
@pytest.mark.parametrize("words", ["scenes", "--help", "random --obstacles 400", "--version"])
@pytest.mark.parametrize("unbuffered", ["", "1"])
def test_a_full_disk_under_stdout_is_said(monkeypatch: pytest.MonkeyPatch, words: str, unbuffered: str) -> None:
    monkeypatch.setenv("PYTHONUNBUFFERED", unbuffered)
    done = in_a_shell(f"{words} >/dev/full")
    assert done.stderr == "taut: error: cannot write to stdout: No space left on device\n"
    assert done.returncode == 2
    assert in_a_shell("check nowhere.yaml 2>/dev/full").returncode == 2


def test_an_old_code_page_does_not_crash(hall: Path) -> None:
    hall.write_text(HALL.replace("name: R1", "name: Žofie→"), encoding="utf-8")
    done = subprocess.run(
        [sys.executable, "-m", "taut", "check", str(hall)],
        env={**os.environ, "PYTHONIOENCODING": "cp1252", "PYTHONUTF8": "0"},
        capture_output=True,
        check=False,
    )
    assert (done.returncode, done.stderr) == (0, b"")
    assert "Žofie?" in done.stdout.decode("cp1252")


# --- planning ---


def test_plan_prints_a_table_and_writes_what_is_asked(taut: Command, hall: Path) -> None:
    run = taut("plan", hall, "-o", "plan.json", "--figure", "plan.png", "--animate", "plan.gif", "--graph")
    assert (run.code, run.err) == (0, "")
    assert sorted(os.listdir(hall.parent)) == ["hall.yaml", "plan.gif", "plan.json", "plan.png"]
    for word in ("robot", "length", "arrival", "shortest", "waits", "R1", "R2", "sum of costs", "gap", "makespan"):
        assert word in run.out
    assert "certified" in run.out
    assert hall.with_name("plan.png").read_bytes().startswith(b"\x89PNG")
    assert hall.with_name("plan.gif").read_bytes().startswith(b"GIF8")
    written = json.loads(hall.with_name("plan.json").read_text())
    assert written["kind"] == "plan"
    assert written["certificate"]["ok"] is True


def test_plan_in_json_tells_the_same(taut: Command, hall: Path) -> None:
    run = taut("plan", hall, "--json", "-o", "plan.json")
    told = run.json
    assert told["ok"] is True
    assert told["files"] == ["plan.json"]
    assert [robot["name"] for robot in told["robots"]] == ["R1", "R2"]
    assert told["sum_of_costs"] >= told["lower_bound"]["value"] - 1e-9
    for robot in told["robots"]:
        assert robot["length"] >= robot["shortest"] - 1e-9
    written = json.loads(hall.with_name("plan.json").read_text())
    assert written["metrics"]["sum_of_costs"] == told["sum_of_costs"]
    assert written["certificate"]["min_separation"] == told["certificate"]["min_separation"]


def test_the_same_seed_gives_the_same_file(taut: Command, hall: Path) -> None:
    contents = []
    for name in ("a.json", "b.json"):
        assert taut("plan", hall, "-o", name, "--seed", "3").code == 0
        file = json.loads(hall.with_name(name).read_text())
        contents.append(file["robots"])
    assert contents[0] == contents[1]


@pytest.mark.parametrize("order", ["given", "shortest", "longest"])
def test_every_order_plans(taut: Command, hall: Path, order: str) -> None:
    told = taut("plan", hall, "--order", order, "--json").json
    assert told["ok"] is True
    assert sorted(told["planner"]["order"]) == ["R1", "R2"]


def test_an_uncertified_plan_is_not_written_and_said_to_be_so(
    taut: Command, hall: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    from dataclasses import replace

    from taut import team
    from taut.certificate import certify
    from taut.motion import Trajectory

    def teleporting(*words: Any, **options: Any) -> Any:
        result = original(*words, **options)
        robots = result.plan.scene.robots
        jump = [Trajectory(r.name, [[0, *r.start], [1e-3, *r.goal]]) for r in robots]  # type: ignore[arg-type]
        plan = replace(result.plan, trajectories=tuple(jump))
        return replace(result, plan=plan, certificate=certify(plan))

    original = team.plan
    monkeypatch.setattr(team, "plan", teleporting)
    run = taut("plan", hall, "-o", "plan.json", "--figure", "plan.png")
    assert refused(run, "does not hold", "nothing was written", code=1)
    assert "problem: R1" in run.out
    assert os.listdir(hall.parent) == ["hall.yaml"]
    run = taut("plan", hall, "-o", "plan.json", "--json")
    assert run.code == 1
    assert run.json["ok"] is False
    assert run.json["files"] == []


def test_names_cannot_steer_the_terminal(taut: Command, hall: Path) -> None:
    hall.write_text(HALL.replace("name: R1", r'name: "[bold]\e[31mR1"'))
    run = taut("check", hall)
    assert run.code == 0
    assert "[bold]" in run.out
    assert "\x1b" not in run.out


def test_nothing_is_cut_in_a_pipe(taut: Command, hall: Path) -> None:
    name = "R" * 200
    hall.write_text(HALL.replace("name: R1", f"name: {name}"))
    assert name in taut("plan", hall).out


@pytest.mark.parametrize("columns", [1, 20, 40, 60, 80, 120])
def test_nothing_is_cut_in_a_narrow_terminal(
    capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch, columns: int
) -> None:
    monkeypatch.setenv("COLUMNS", str(columns))
    monkeypatch.setattr(sys.stdout, "isatty", lambda: True)
    why = "+12.3456 m: goes round robot-17, who stands at its goal on the shortest way from t = 12.3 s on"
    heads = ["robot", "length (m)", "arrival (s)", "shortest (m)", "waits", "why longer"]
    rows = [["robot-number-1", "15.1336", "17.1757", "14.2000", "2 (1.25 s)", why], ["長い名前", "1", "2", "3", "", ""]]
    say_table(heads, rows, left=("robot", "waits", "why longer"))
    out = capsys.readouterr().out
    for cell in rows[0][:5] + rows[1][:1]:
        assert cell in (out if columns >= 40 else " ".join(out.split()))
    assert " ".join(why.split()) in " ".join(out.split()) or columns >= 120
    if columns >= 40:
        assert max(cell_len(line) for line in out.splitlines()) <= columns
    if columns >= 80:  # the words get room of their own
        assert max(len(line.split()) for line in out.splitlines() if "goes round" in line) >= 5


# --- verifying ---


def test_a_written_plan_verifies(taut: Command, plan: Path) -> None:
    run = taut("verify", plan)
    assert (run.code, run.err) == (0, "")
    assert "least separation" in run.out
    assert taut("verify", plan, "--scene", "hall.yaml").code == 0
    assert taut("verify", plan, "--json").json["ok"] is True


def test_a_plan_for_another_scene_does_not_verify(taut: Command, plan: Path) -> None:
    assert refused(taut("verify", plan, "--scene", "thesis-2"), "does not hold", code=1)


@pytest.mark.parametrize("amount", [1e-6, 1.0])
def test_a_damaged_plan_does_not_verify(taut: Command, plan: Path, amount: float) -> None:
    content = json.loads(plan.read_text())
    content["robots"][0]["stamps"][0][1] += amount
    plan.write_text(json.dumps(content))
    run = taut("verify", plan)
    assert refused(run, "does not hold", code=1)
    assert "problem: R1" in run.out
    run = taut("verify", plan, "--json")
    assert run.code == 1
    assert run.json["problems"][0]["robots"] == ["R1"]


def test_a_plan_of_a_scene_that_cannot_be_used_is_never_certified(taut: Command, plan: Path, hall: Path) -> None:
    crossing = HALL.replace("[6, 3], [6, 7]", "[6, 7], [6, 3]")
    hall.write_text(crossing)
    assert refused(taut("verify", plan, "--scene", hall), str(hall), "box", "crosses itself")
    content = json.loads(plan.read_text())
    content["scene"]["obstacles"][0]["polygon"] = [[4, 3], [6, 7], [6, 3], [4, 7]]
    plan.write_text(json.dumps(content))
    for command in ("verify", "show"):
        run = taut(command, plan)
        assert refused(run, str(plan), "box", "crosses itself")
        assert run.out == ""


def test_a_picture_does_not_believe_the_certificate_of_the_file(
    taut: Command, plan: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    drawn: list[Any] = []
    monkeypatch.setattr("taut.figures.save_figure", lambda value, *_, **__: drawn.append(value))
    content = json.loads(plan.read_text())
    assert content["certificate"]["ok"] is True
    content["robots"][0]["stamps"][-1][2] += 0.5
    plan.write_text(json.dumps(content))
    assert taut("show", plan, "--figure", "plan.png").code == 1
    assert drawn[0].certificate["ok"] is False


# --- the other commands ---


def test_check_tells_counts_notes_and_lengths(taut: Command, hall: Path) -> None:
    hall.write_text(HALL.replace("obstacles:", "obstacles:\n  - {name: lid, rectangle: [3, 7, 4, 0.5]}"))
    run = taut("check", hall)
    assert (run.code, run.err) == (0, "")
    assert "2 (1 polygon, 1 rectangle)" in run.out
    assert "note: " in run.out
    told = taut("check", hall, "--json").json
    assert told["ok"] is True
    assert told["reach"][1]["shortest"] == pytest.approx(8.0, abs=1.0)
    assert any("lid" in note for note in told["notes"])


def test_show_sums_up_and_draws(taut: Command, plan: Path) -> None:
    run = taut("show", "hall.yaml", "-o", "scene.svg", "--graph")
    assert (run.code, run.err) == (0, "")
    assert "hall" in run.out
    assert "<svg" in plan.with_name("scene.svg").read_text()
    run = taut("show", plan, "--figure", "plan.pdf", "--animate", "plan.gif")
    assert (run.code, run.err) == (0, "")
    assert "sum of costs" in run.out
    assert plan.with_name("plan.pdf").read_bytes().startswith(b"%PDF")
    assert plan.with_name("plan.gif").stat().st_size > 0
    assert refused(taut("show", "hall.yaml", "--animate", "scene.gif"), "does not move")


def test_show_says_that_a_plan_does_not_hold(taut: Command, plan: Path) -> None:
    content = json.loads(plan.read_text())
    content["robots"][0]["stamps"][-1][2] += 0.5
    plan.write_text(json.dumps(content))
    assert refused(taut("show", plan), "does not hold", code=1)


@pytest.mark.parametrize("command", ["plan", "check", "graph"])
def test_errors_after_loading_name_the_file(taut: Command, hall: Path, command: str) -> None:
    hall.write_text(HALL.replace("start: [1, 5]", "start: [4.5, 5]"))
    assert refused(taut(command, hall), f"taut: error: {hall}: robot R1")
    wall = "obstacles:\n  - {name: wall, line: [[7, 0], [7, 10]], width: 0.2}"
    hall.write_text(HALL.replace("obstacles:", wall))
    if command != "graph":
        assert refused(taut(command, hall), f"taut: error: {hall}: ", "R1", code=1)


def test_errors_about_a_ready_scene_name_it(taut: Command, monkeypatch: pytest.MonkeyPatch) -> None:
    def never(*_: object, **__: object) -> None:
        raise NoPlanFound("no plan was found")

    monkeypatch.setattr("taut.team.plan", never)
    assert refused(taut("plan", "thesis-2"), "taut: error: thesis-2: no plan was found", code=1)


@pytest.mark.parametrize("size", ["1.7e308", "-1.7e308", "1e30"])
def test_absurd_places_are_one_line_and_no_warnings(plan: Path, size: str) -> None:
    content = json.loads(plan.read_text())
    content["robots"][0]["stamps"][-2][1] = float(size)
    plan.write_text(json.dumps(content))
    picture = plan.with_name("plan.png")
    done = in_a_shell(f"show '{plan}' --figure '{picture}'")
    assert (done.returncode, done.stderr.count("\n")) == (1, 1), done.stderr
    assert "does not hold" in done.stderr
    assert picture.read_bytes().startswith(b"\x89PNG")
    scene = plan.with_name("scene.json")
    scene.write_text('{"taut": 1, "bounds": [-1.7e308, -1.7e308, 1.7e308, 1.7e308], "robots": []}')
    done = in_a_shell(f"show '{scene}' --figure '{picture}'")
    assert (done.returncode, done.stderr.count("\n")) == (2, 1), done.stderr
    assert "cannot be drawn" in done.stderr


def test_graph_counts(taut: Command, hall: Path) -> None:
    told = taut("graph", "thesis-1", "--json").json
    assert [size["growth"] for size in told["sizes"]] == [0.0]
    # 24 corners of obstacles, 3 starts, one shared goal. With the coordinates taken as decimals there are 150 visible
    # pairs; as doubles the corner (3.2, 9.5) reaches 1e-16 m across the line from (2, 8.5) to (6.2, 12).
    assert (told["sizes"][0]["vertices"], told["sizes"][0]["edges"]) == (28, 149)
    assert told["sizes"][0]["tangent_edges"] < 149
    assert [round(robot["shortest"], 4) for robot in told["robots"]] == [15.3445, 17.3043, 17.0388]
    hall.write_text(HALL.replace("radius: 0.3, speed", "radius: 0.5, speed"))
    run = taut("graph", hall)
    assert (run.code, run.err) == (0, "")
    assert "0.3" in run.out
    assert "0.5" in run.out


def test_random_writes_and_prints_the_same_scene(taut: Command, tmp_path: Path) -> None:
    from taut.formats import load_scene

    words = ["random", "--robots", "4", "--obstacles", "6", "--seed", "5", "--radius", "0.2,0.4", "--leave"]
    assert taut(*words, "-o", "a.yaml").code == 0
    assert taut(*words, "-o", "a.json").code == 0
    (tmp_path / "b.yaml").write_text(taut(*words).out)
    (tmp_path / "b.json").write_text(taut(*words, "--json").out)
    first = load_scene(tmp_path / "a.yaml")
    assert len(first.robots) == 4
    assert len(first.obstacles) == 6
    assert first.at_goal == "leave"
    for name in ("a.json", "b.yaml", "b.json"):
        assert load_scene(tmp_path / name) == first
    assert taut("random", "--robots", "3", "--size", "30,20", "--well-formed", "--json").json["robots"]


def test_scenes_are_listed_with_a_line_each(taut: Command) -> None:
    from taut.formats import load_scene

    told = taut("scenes", "--json").json["scenes"]
    assert {"thesis-1", "thesis-2", "thesis-3", "appendix-d", "corridor-swap", "crossing-30"} <= {
        scene["name"] for scene in told
    }
    for scene in told:
        assert load_scene(scene["name"]).name == scene["name"]
        assert len(scene["about"]) > 10
    assert len(taut("scenes").out.splitlines()) == len(told)


def test_warmup_plans_and_certifies(taut: Command) -> None:
    run = taut("warmup", "--json")
    assert run.code == 0
    assert run.json["ok"] is True


def test_after_warmup_simulating_compiles_nothing(taut: Command, tmp_path: Path) -> None:
    """Whatever kernel the first simulation calls, warmup has called with arrays of the same types."""
    plan = tmp_path / "plan.json"
    assert taut("plan", "thesis-2", "-o", plan).code == 0
    after = tmp_path / "now.yaml"
    once = [plan, "--lidar", "--dies", "R1@2", "--vehicle", "ackermann", "--after", after]
    before, more = compiled_by(["simulate", *once], ["simulate", plan, "--seeds", "2", "--stops", "0.1"])
    assert any(kernel.startswith("run_steps") for kernel in before)
    assert more == []
    assert after.exists()


def test_after_warmup_steering_compiles_nothing(tmp_path: Path) -> None:
    figure = tmp_path / "team.png"
    alone = ["steer", "thesis-2", "--vehicle", "ackermann", "--stops", "0.1", "--seconds", "2"]
    linked = ["steer", "thesis-2", "--law", "rendezvous", "--reach", "20", "--seconds", "2", "--figure", figure]
    before, more = compiled_by(alone, linked)
    assert any(kernel.startswith("steer_step") for kernel in before)
    assert more == []
    assert figure.exists()


def compiled_by(*commands: list[Any]) -> tuple[list[str], list[str]]:
    """Return what kernels, with what types, a new process has after warmup, and those that the commands add."""
    lines = [list(map(str, command)) for command in commands]
    code = f"""
import contextlib, gc, io, json
from numba.core.dispatcher import Dispatcher
from taut.cli import main

def ready():
    kernels = [each for each in gc.get_objects() if isinstance(each, Dispatcher)]
    return {{f"{{each.py_func.__qualname__}}{{types}}" for each in kernels for types in each.signatures}}

with contextlib.redirect_stdout(io.StringIO()):
    assert main(["warmup"]) == 0
    before = ready()
    for line in {lines!r}:
        main(line)
print(json.dumps([sorted(before), sorted(ready() - before)]))
"""
    before, more = in_a_new_process(code)
    return before, more


# --- the package ---


def in_a_new_process(code: str) -> Any:
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    return json.loads(done.stdout)


def test_importing_taut_loads_nothing_heavy() -> None:
    code = "import sys, json, taut, taut.cli; print(json.dumps(sorted(sys.modules)))"
    loaded = {name.partition(".")[0] for name in in_a_new_process(code)}
    assert not loaded & {"typer", "rich", "matplotlib", "numba", "scipy", "shapely", "pydantic", "PIL"}


def test_every_public_name_is_there_and_loaded_once() -> None:
    import taut

    for name in taut.__all__:
        assert getattr(taut, name) is getattr(taut, name)
        assert name in dir(taut)
    assert taut.Scene is sys.modules["taut.scene"].Scene
    with pytest.raises(AttributeError, match="plam"):
        taut.plam  # type: ignore[attr-defined]  # noqa: B018


def test_planning_loads_no_pictures() -> None:
    code = (
        "import sys, json, taut\n"
        "s = taut.Scene((0, 0, 4, 3), robots=[taut.Robot('R', (1, 1), (3, 1), radius=0.1)])\n"
        "assert taut.plan(s).certificate.ok\n"
        "print(json.dumps('matplotlib' in sys.modules))"
    )
    assert in_a_new_process(code) is False


def test_costs_stand_beside_the_bound_on_the_same_objective(taut: Command) -> None:
    run = taut("plan", "crossing-30", "--rounds", "2", "--objective", "makespan")
    lines = [line for line in run.out.splitlines() if "at least" in line]
    assert len(lines) == 1
    assert lines[0].startswith("makespan ")
    report = taut("plan", "crossing-30", "--rounds", "2", "--objective", "makespan", "--json").json
    assert report["lower_bound"]["of"] == "makespan"
    assert report["gap"] == pytest.approx(report["makespan"] / report["lower_bound"]["value"] - 1)


def test_a_proven_optimum_is_called_proven(taut: Command) -> None:
    assert "gap 0.00 %, proven" in taut("plan", "thesis-2", "--method", "optimal").out


def test_a_plan_made_on_lanes_is_made_again_on_the_file_given(taut: Command, tmp_path: Path) -> None:
    lanes = {"vertices": [[1, 5], [1, 8], [9, 8], [9, 5]], "edges": [[0, 1], [1, 2], [2, 3]]}
    (tmp_path / "lanes.json").write_text(json.dumps(lanes))
    (tmp_path / "one.yaml").write_text(
        HALL.replace("  - {name: R2, start: [9, 8], goal: [1, 8], radius: 0.3, speed: 5}\n", "")
    )
    assert taut("plan", "one.yaml", "--roadmap", "lanes.json", "-o", "a.json").code == 0
    assert refused(taut("replan", "a.json", "one.yaml"), "lanes.json", "roadmap")
    again = taut("replan", "a.json", "one.yaml", "--roadmap", "lanes.json")
    assert again.code == 0
    assert "1 of 1 robots keep their motions" in again.out


def test_why_nothing_can_be_planned_stands_below_the_error(taut: Command, tmp_path: Path) -> None:
    (tmp_path / "c.yaml").write_text(
        "taut: 1\nbounds: [0, 0, 10, 1]\nrobots:\n"
        "  - {name: A, start: [1, 0.5], goal: [9, 0.5], radius: 0.4}\n"
        "  - {name: B, start: [9, 0.5], goal: [1, 0.5], radius: 0.4}\n"
    )
    run = taut("plan", "c.yaml")
    assert run.code == 1
    first, *more = run.err.splitlines()
    assert "No plan exists: " in first
    assert more
    assert all(line.startswith("  ") for line in more)
