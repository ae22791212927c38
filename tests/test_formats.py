"""Files: nothing is lost, nothing wrong is taken, every refusal is one line that says where."""

from __future__ import annotations

import json
import os
import random
import stat
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import shapely
from hypothesis import given, settings
from hypothesis import strategies as st
from pydantic import ValidationError

from taut.errors import OutputError, PlanError, SceneError
from taut.formats import (
    load_plan,
    load_scene,
    plan_from_dict,
    plan_to_dict,
    save,
    scene_from_dict,
    scene_names,
    scene_schema,
    scene_to_dict,
)
from taut.formats.schema import SceneFile
from taut.formats.yaml_text import parse_yaml, resolve
from taut.motion import Plan, Trajectory
from taut.scene import AtGoal, Circle, Line, Obstacle, Polygon, Rectangle, Robot, Scene

ENDINGS = (".yaml", ".yml", ".json", ".geojson")
SCHEMA_FILE = Path(__file__).parents[1] / "docs" / "scene.schema.json"

EXAMPLE = """\
taut: 1
name: example
workspace: [[0,0],[16,0],[16,16],[0,16]]
clearance: 0.1
gap: 0.05
headway: 0.0
at_goal: stay
obstacles:
  - {name: O1, polygon: [[4.5,2],[7.8,2],[7.8,4],[4.5,4]]}
  - {name: pillar, circle: [2.5,12], radius: 0.35}
  - {name: wall, line: [[0,3],[4,5],[6,3]], width: 0.1}
  - {name: shelf, rectangle: [1,1,4,0.5], angle: 0.3}
robots:
  - {name: R1, start: [3,1], goal: [12,12.7], radius: 0.2, speed: 1.0}
"""
EXAMPLE_SCENE = Scene(
    [(0, 0), (16, 0), (16, 16), (0, 16)],
    [
        Polygon([(4.5, 2), (7.8, 2), (7.8, 4), (4.5, 4)], "O1"),
        Circle((2.5, 12), 0.35, "pillar"),
        Line([(0, 3), (4, 5), (6, 3)], 0.1, "wall"),
        Rectangle(1, 1, 4, 0.5, 0.3, "shelf"),
    ],
    [Robot("R1", (3, 1), (12, 12.7), radius=0.2, speed=1.0)],
    name="example",
    clearance=0.1,
    gap=0.05,
)

finite = st.one_of(
    st.floats(allow_nan=False, allow_infinity=False),
    st.integers(-20, 20).map(float),
    st.sampled_from([1e-9, -0.0, 1e300, 5e-324, 1e15, 1e16, 0.1, -1e22]),
)
positive = st.one_of(st.floats(5e-324, 1e300), st.integers(1, 20).map(float))
not_negative = st.one_of(positive, st.sampled_from([0.0, -0.0]))
points = st.tuples(finite, finite)
texts = st.one_of(
    st.text(st.characters(exclude_categories=["Cs"]), min_size=1, max_size=12),
    st.sampled_from(
        ["yes", "null", "1", "0x1F", "a\nb", '"', "'", "\\", "~", ": #", " x ", "\ufeff", "\u2028", "😀", "\x00"]
    ),
)
obstacles: st.SearchStrategy[Obstacle] = st.one_of(
    st.builds(Circle, points, positive),
    st.builds(Line, st.lists(points, min_size=2, max_size=4), positive),
    st.builds(Rectangle, finite, finite, positive, positive, finite),
    st.builds(
        lambda x, y, w, h: Polygon([(x, y), (x + w, y), (x, y + h)]),
        *(st.integers(-9, 9), st.integers(-9, 9), st.integers(1, 9), st.integers(1, 9)),
    ),
)
ends: st.SearchStrategy[AtGoal] = st.sampled_from(["stay", "leave"])


@st.composite
def any_scenes(draw: st.DrawFn) -> Scene:
    """Draw any scene that Scene takes, valid or not, with numbers of every size and names of every sign."""
    names = draw(st.lists(texts, unique=True, max_size=4))
    robots = [
        Robot(
            name,
            draw(points),
            draw(points),
            radius=draw(not_negative),
            speed=draw(positive),
            clearance=draw(st.none() | not_negative),
            start_time=draw(not_negative),
            at_goal=draw(st.one_of(st.none(), ends)),
        )
        for name in names
    ]
    bounds = st.tuples(finite, finite, finite, finite).filter(lambda b: b[0] < b[2] and b[1] < b[3])
    return Scene(
        draw(st.lists(points, min_size=3, max_size=6) | bounds),
        draw(st.lists(obstacles, max_size=4)),
        robots,
        name=draw(st.one_of(st.just(""), texts)),
        clearance=draw(not_negative),
        gap=draw(not_negative),
        headway=draw(not_negative),
        at_goal=draw(ends),
    )


def write(folder: Path, name: str, text: str | bytes) -> Path:
    path = folder / name
    path.write_bytes(text if isinstance(text, bytes) else text.encode())
    return path


def refusal(path: str | Path) -> SceneError:
    """Load what must be refused, in one line that begins with the file."""
    with pytest.raises(SceneError) as caught:
        load_scene(path)
    text = str(caught.value)
    assert text.isprintable()
    assert len(text) < 500 + len(str(path))
    assert text.startswith(str(path))
    return caught.value


# --- reading what is right


def test_the_example_is_read_as_written(tmp_path: Path) -> None:
    assert load_scene(write(tmp_path, "a.yaml", EXAMPLE)) == EXAMPLE_SCENE


def test_json_is_the_same_format(tmp_path: Path) -> None:
    text = json.dumps(parse_yaml(EXAMPLE).data)
    assert load_scene(write(tmp_path, "a.json", text)) == EXAMPLE_SCENE


def test_bounds_a_byte_order_mark_and_an_empty_team_are_fine(tmp_path: Path) -> None:
    path = write(tmp_path, "a.YAML", "\ufefftaut: 1\nbounds: [0, 0, .5, 1E5]\nrobots: []\n")
    assert load_scene(str(path)) == Scene((0, 0, 0.5, 1e5))


def test_obstacles_without_names_are_named_by_position() -> None:
    data = {"taut": 1, "bounds": [0, 0, 9, 9], "robots": [], "obstacles": [{"circle": [1, 1], "radius": 1}]}
    assert [o.name for o in scene_from_dict(data).obstacles] == ["O1"]


@pytest.mark.parametrize(
    ("text", "value"),
    [
        *(("1e-09", 1e-9), ("1E5", 1e5), (".5", 0.5), ("5.", 5.0), ("-3", -3), ("+2", 2), ("0o17", 15), ("0x1F", 31)),
        *(("yes", "yes"), ("no", "no"), ("on", "on"), ("Off", "Off"), ("1:30", "1:30"), ("1_000", "1_000")),
        *(
            ("017", 17),
            ("0b1", "0b1"),
            ("1.2.3", "1.2.3"),
            ("e5", "e5"),
            ("true", True),
            ("~", None),
            ("-.inf", -np.inf),
        ),
    ],
)
def test_plain_scalars_follow_yaml_1_2(text: str, value: object) -> None:
    assert resolve(text) == value
    assert type(resolve(text)) is type(value) or value == -np.inf


def test_every_ready_scene_loads_by_name() -> None:
    for name in scene_names():
        assert isinstance(load_scene(name), Scene)


def test_a_ready_scene_is_found_beside_a_folder_of_its_name(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    name = scene_names()[0]
    (tmp_path / name).mkdir()
    monkeypatch.chdir(tmp_path)
    assert load_scene(name) == load_scene(name)


# --- round trips


@settings(deadline=None, max_examples=150)
@given(scene=any_scenes(), ending=st.sampled_from(ENDINGS))
def test_a_saved_scene_comes_back_bit_for_bit(
    scene: Scene, ending: str, tmp_path_factory: pytest.TempPathFactory
) -> None:
    path = tmp_path_factory.mktemp("round") / f"a{ending}"
    save(scene, path)
    again = load_scene(path)
    first = path.read_bytes()
    save(again, path)
    if ending == ".geojson" and repr(again.workspace) != repr(scene.workspace):
        # only a ring that touches itself may come back in other words: of the same region
        assert not shapely.Polygon(scene.workspace).is_valid
        return
    assert again == scene
    assert repr(again) == repr(scene)  # also the signs of zeros
    assert path.read_bytes() == first


def test_yaml_is_written_one_obstacle_and_robot_a_line(tmp_path: Path) -> None:
    save(EXAMPLE_SCENE, tmp_path / "a.yaml")
    lines = (tmp_path / "a.yaml").read_text().splitlines()
    assert "bounds: [0, 0, 16, 16]" in lines
    assert "  - {name: pillar, circle: [2.5, 12], radius: 0.35}" in lines
    assert "  - {name: R1, start: [3, 1], goal: [12, 12.7], radius: 0.2, speed: 1}" in lines


def test_scene_dicts_are_plain_json() -> None:
    data = scene_to_dict(EXAMPLE_SCENE)
    assert scene_from_dict(json.loads(json.dumps(data))) == EXAMPLE_SCENE


def a_plan() -> Plan:
    scene = Scene((0, 0, 9, 9), [Circle((5, 5), 1)], [Robot("R1", (1, 1), (2, 1)), Robot("é\n", (3, 3), (3, 3))], gap=1)
    moves = (
        Trajectory("R1", np.array([[0, 1, 1], [0.1 + 0.2, 1.1, 1], [1e9, 2, 1]])),
        Trajectory("é\n", np.array([[0.0, 3, 3]])),
    )
    certificate = {"ok": True, "min_separation": float("inf"), "n": np.int64(3), "worst": (np.float64(0.5), None)}
    bound = {"model": "plane", "value": 1.0}
    return Plan(scene, moves, {"method": "x", "order": ["R1"]}, {"contact": {"range": 3.5}}, bound, certificate)


def test_a_saved_plan_comes_back_bit_for_bit(tmp_path: Path) -> None:
    plan, path = a_plan(), tmp_path / "p.json"
    save(plan, path)
    again = load_plan(path)
    assert again.scene == plan.scene
    assert again.trajectories == plan.trajectories
    assert (again.planner, again.claims, again.lower_bound) == (plan.planner, plan.claims, plan.lower_bound)
    assert again.certificate == {"ok": True, "min_separation": None, "n": 3, "worst": [0.5, None]}
    first = path.read_bytes()
    save(again, path)
    assert path.read_bytes() == first
    assert sum(b'"stamps"' in line for line in first.splitlines()) == 2


def test_a_plan_needs_only_scene_and_motions() -> None:
    full = plan_to_dict(a_plan())
    data = {key: full[key] for key in ("taut", "kind", "scene", "robots")}
    assert plan_from_dict(data).sum_of_costs == a_plan().sum_of_costs


def test_metrics_of_a_file_are_not_believed() -> None:
    data = plan_to_dict(a_plan())
    data["metrics"] = {"sum_of_costs": -1, "makespan": "nonsense"}
    plan = plan_from_dict(data)
    assert plan.sum_of_costs == a_plan().sum_of_costs
    assert plan.lower_bound is None


@settings(deadline=None, max_examples=60)
@given(
    stamps=st.lists(st.tuples(st.floats(1e-300, 1e300), finite, finite), max_size=5, unique_by=lambda s: s[0]),
    first=points,
)
def test_stamps_lose_no_digit(stamps: list[tuple[float, float, float]], first: tuple[float, float]) -> None:
    scene = Scene((0, 0, 9, 9), (), [Robot("R", (1, 1), (2, 1))])
    plan = Plan(scene, (Trajectory("R", np.array([(0.0, *first), *sorted(stamps)])),))
    again = plan_from_dict(json.loads(json.dumps(plan_to_dict(plan))))
    assert again.trajectories[0].stamps.tobytes() == plan.trajectories[0].stamps.tobytes()


# --- refusing what is wrong


def without(line: str) -> str:
    assert line in EXAMPLE
    return EXAMPLE.replace(line, "")


WRONG = {
    "unknown key": ("clearance: 0.1", "clearence: 0.1", 4, "unknown key `clearence`; did you mean `clearance`?"),
    "unknown key of a robot": ("speed: 1.0}", "velocity: 1.0}", 14, "robot R1: unknown key `velocity`; known are"),
    "unknown key of an obstacle": ("width: 0.1", "width: 0.1, hight: 2", 11, "obstacle wall: unknown key `hight`"),
    "missing robots": (EXAMPLE[EXAMPLE.index("robots") :], "", 1, "no robots: add `robots:`"),
    "robots without a value": (
        EXAMPLE[EXAMPLE.index("robots") :],
        "robots:\n",
        13,
        "robots must be a list, got nothing",
    ),
    "missing goal": ("goal: [12,12.7], ", "", 14, "robot R1: `goal` is missing"),
    "missing version": ("taut: 1\n", "", 1, "add `taut: 1`"),
    "another version": ("taut: 1", "taut: 2", 1, "must be 1"),
    "a version that is a truth": ("taut: 1", "taut: true", 1, "must be 1"),
    "missing workspace": ("workspace: [[0,0],[16,0],[16,16],[0,16]]\n", "", 1, "no workspace: add"),
    "two outlines": ("gap: 0.05", "bounds: [0,0,1,1]", 1, "both `workspace` and `bounds`"),
    "duplicate key": ("gap: 0.05", "clearance: 0.05", 5, "key 'clearance' is given twice"),
    "duplicate robots": (
        "robots:",
        "robots:\n  - {name: R1, start: [9,9], goal: [9,8]}",
        15,
        "two robots are named R1",
    ),
    "duplicate obstacles": ("name: wall", "name: pillar", 11, "two obstacles are named pillar"),
    "nan": ("goal: [12,12.7]", "goal: [12,.nan]", 14, "robot R1: goal must be a finite number, got nan"),
    "infinity": ("gap: 0.05", "gap: .inf", 5, "gap must be a finite number, got inf"),
    "overflow": ("gap: 0.05", "gap: 1e999", 5, "gap must be a finite number"),
    "huge integer": ("gap: 0.05", "gap: 1" + "0" * 5000, 5, "gap must be a finite number"),
    "a number as text": ("gap: 0.05", 'gap: "0.05"', 5, "gap must be a number, got '0.05'; remove the quotes"),
    "a truth as number": ("gap: 0.05", "gap: true", 5, "gap must be a number, got true"),
    "a negative number": ("gap: 0.05", "gap: -1", 5, "gap must not be negative, got -1"),
    "speed 0": ("speed: 1.0", "speed: 0", 14, "robot R1: speed must be positive, got 0"),
    "radius 0 of a circle": ("radius: 0.35", "radius: 0", 10, "obstacle pillar: radius must be positive"),
    "a start of three numbers": ("start: [3,1]", "start: [3,1,2]", 14, "robot R1: start must be a point [x, y], got 3"),
    "a start that is text": ("start: [3,1]", "start: here", 14, "robot R1: start must be a point [x, y], got 'here'"),
    "a name that is a number": ("name: R1", "name: 1", 14, "robot number 1: name must be text, got 1; put it in"),
    "an empty name": ("name: R1", 'name: ""', 14, "robot number 1: name must not be empty"),
    "a word for at_goal": ("at_goal: stay", "at_goal: yes", 7, 'at_goal must be "stay" or "leave", got \'yes\''),
    "two corners": (
        "[[4.5,2],[7.8,2],[7.8,4],[4.5,4]]",
        "[[4.5,2],[7.8,2]]",
        9,
        "obstacle O1: polygon must be a list of",
    ),
    "a corner that is none": ("[7.8,4],", "7.8,", 9, "obstacle O1: polygon: corner 3 must be a point [x, y], got 7.8"),
    "no shape": ("circle: [2.5,12], ", "", 10, "obstacle pillar: no shape; give one of"),
    "two shapes": (
        "circle: [2.5,12]",
        "circle: [2.5,12], line: [[1,1]]",
        10,
        "obstacle pillar: has 2 shapes (circle, line)",
    ),
    "a flat rectangle": ("[1,1,4,0.5]", "[1,1,4,0]", 12, "obstacle shelf: width and height must be positive"),
    "robots that are a mapping": ("  - {name: R1", "  {name: R1", 13, "robots must be a list"),
    "an obstacle that is text": (
        "  - {name: O1, polygon: [[4.5,2],[7.8,2],[7.8,4],[4.5,4]]}",
        "  - O1",
        9,
        "must be a mapping",
    ),
    "an anchor": ("gap: 0.05", "gap: &g 0.05", 5, "anchors and aliases"),
    "an alias": ("gap: 0.05", "gap: *g", 5, "anchors and aliases"),
    "a tag": ("gap: 0.05", "gap: !!python/object:os.system 1", 5, "tags are not used here"),
    "a merge key": ("gap: 0.05", "<<: {gap: 1}", 5, "unknown key `<<`"),
    "a key that is a list": ("gap: 0.05", "? [a]\n: 1", 5, "a key must be a word"),
    "two documents": ("gap: 0.05", "---", 5, "several documents"),
    "broken yaml": ("gap: 0.05", "gap: [1", 6, "not valid YAML"),
    "a tab": ("gap: 0.05", "obstacles:\n\t- 1", 6, "not valid YAML"),
    "a control character": ("name: example", "name: a\x07b", 2, "control byte 0x07"),
    "a character YAML has not": ("name: example", "name: a\x7fb", 2, "U+007F"),
    "a plan": ("headway: 0.0", "kind: plan", 6, "this is a plan, not a scene"),
    "a name with a line break": ("name: R1, start: [3,1]", 'name: "R\\n1", start: 3', 14, "robot R\\n1: start must be"),
}


@pytest.mark.parametrize("case", WRONG)
def test_yaml_that_is_wrong_is_refused_with_its_line(case: str, tmp_path: Path) -> None:
    old, new, line, message = WRONG[case]
    assert old in EXAMPLE
    path = write(tmp_path, "a.yaml", EXAMPLE.replace(old, new, 1))
    error = refusal(path)
    assert message in str(error)
    assert (error.file, error.line) == (str(path), line)


PRETTY = json.dumps(parse_yaml(EXAMPLE).data, indent=1)
WRONG_JSON = {
    "unknown key": ('"gap": 0.05', '"gab": 0.05', "unknown key `gab`; did you mean `gap`?"),
    "duplicate key": ('"gap": 0.05', '"clearance": 1', "key 'clearance' is given twice"),
    "an escaped duplicate": ('"gap": 0.05', '"clear\\u0061nce": 1', "key 'clearance' is given twice"),
    "nan": ('"gap": 0.05', '"gap": NaN', "NaN is not a number that JSON allows"),
    "infinity": ('"gap": 0.05', '"gap": -Infinity', "-Infinity is not a number"),
    "overflow": ('"gap": 0.05', '"gap": 1e999', "gap must be a finite number"),
    "huge integer": ('"gap": 0.05', '"gap": 1' + "0" * 5000, "gap must be a finite number"),
    "a duplicate key before what is broken": ('"gap": 0.05', '"a": {"b": 1, "b": 2}, c', "not valid JSON"),
    "broken": ('"gap": 0.05', '"gap": 0.05 0', "not valid JSON"),
    "a comment": ('"gap": 0.05', '"gap": 0.05 // m', "not valid JSON"),
    "half a surrogate pair": ('"name": "R1"', '"name": "\\ud800"', "name must not hold half of a surrogate pair"),
    "speed 0": ('"speed": 1.0', '"speed": 0', "robot R1: speed must be positive"),
}


@pytest.mark.parametrize("case", WRONG_JSON)
def test_json_that_is_wrong_is_refused_with_its_line(case: str, tmp_path: Path) -> None:
    old, new, message = WRONG_JSON[case]
    assert PRETTY.count(old) == 1
    path = write(tmp_path, "a.json", PRETTY.replace(old, new))
    error = refusal(path)
    assert message in str(error)
    assert error.line == PRETTY[: PRETTY.index(old)].count("\n") + 1


@pytest.mark.parametrize("ending", ENDINGS)
@pytest.mark.parametrize(
    ("content", "message"),
    [
        (b"", "is empty"),
        (b" \n\n", "is empty"),
        (b"\x89PNG\r\n\x1a\n\0\0", "is not a text file"),
        (b"name: \xff\xfe", "is not UTF-8 text"),
        ("taut: 1".encode("utf-16"), "is not a text file"),
        (b"[" * 100_000, ""),
        (b'{"a":' * 100_000, ""),
        (b"- " * 100_000, ""),
        (b"[1, 2]", ""),
        (b"nonsense", ""),
        (b'"taut"', ""),
        (b"null", ""),
    ],
    ids=["empty", "blank", "binary", "latin", "utf-16", "lists", "mappings", "block", "list", "word", "text", "null"],
)
def test_garbage_is_refused(content: bytes, message: str, ending: str, tmp_path: Path) -> None:
    assert message in str(refusal(write(tmp_path, f"a{ending}", content)))


@pytest.mark.parametrize("ending", ENDINGS)
@pytest.mark.parametrize("kind", ["random", "letters"])
def test_50_mb_of_garbage_are_refused(ending: str, kind: str, tmp_path: Path) -> None:
    block = random.Random(1).randbytes(1 << 20) if kind == "random" else b"ab cd ef\n" * (1 << 17)
    refusal(write(tmp_path, f"a{ending}", block * (50 if kind == "random" else 45)))


def test_a_file_beyond_the_limit_is_told_so(tmp_path: Path) -> None:
    for name, limit in (("a.json", 64), ("a.yaml", 8)):
        with open(tmp_path / name, "wb") as stream:
            stream.truncate((limit << 20) + 1)
        assert f"larger than {limit} MB" in str(refusal(tmp_path / name))


@pytest.mark.parametrize(("content", "what"), [("[1, 1]", "a list"), ('"taut"', "text"), ("-17", "a number")])
def test_json_of_another_kind_is_refused_before_it_is_built(
    content: str, what: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    def never(*_: object, **__: object) -> None:
        raise AssertionError("built all of it")

    monkeypatch.setattr("taut.formats.json_text.json.loads", never)
    error = refusal(write(tmp_path, "a.json", f"\n {content}"))
    assert str(error).endswith(f"a.json:2: must be a mapping of keys to values, got {what}")


def test_yaml_of_another_kind_is_refused_at_its_first_part(tmp_path: Path) -> None:
    assert "got a list" in str(refusal(write(tmp_path, "a.yaml", "[1, 1, *not-yet")))
    assert "got 'word'" in str(refusal(write(tmp_path, "a.yaml", "word")))


@pytest.mark.parametrize("head", ['{"a": [', '{"taut": 1, "bounds": [0, 0, 1, 1], "robots": ['])
def test_errors_of_50_mb_of_json_are_told_without_a_line(head: str, tmp_path: Path) -> None:
    error = refusal(write(tmp_path, "a.json", head + "1," * 25_000_000 + "1]}"))
    assert error.line is None
    assert "`a`" in str(error) or "robot number 1: must be a mapping" in str(error)


def test_in_long_json_nan_and_doubled_keys_are_told_without_a_line(tmp_path: Path) -> None:
    blank = " " * (9 << 20)
    error = refusal(write(tmp_path, "a.json", '{"taut": 1, "gap": 1, "gap": 2}' + blank))
    assert (error.line, error.message) == (None, "key 'gap' is given twice; keep one")
    error = refusal(write(tmp_path, "a.json", '{"taut": 1, "gap": NaN}' + blank))
    assert (error.line, error.message) == (None, "NaN is not a number that JSON allows")


@pytest.mark.parametrize(
    "wrong",
    [
        {"workspace": [1] * 1000},
        {"robots": [1] * 1000},
        {"obstacles": [1] * 1000},
        {"obstacles": [{"polygon": [[1]] * 1000}]},
        {"obstacles": [{"line": [[1]] * 1000, "width": 1}]},
        {"bounds": ["x"] * 1000},
    ],
    ids=["workspace", "robots", "obstacles", "polygon", "line", "bounds"],
)
def test_a_long_list_of_wrong_things_is_told_by_its_first(wrong: dict[str, Any]) -> None:
    with pytest.raises(ValidationError) as caught:
        SceneFile.model_validate({"taut": 1, "bounds": [0, 0, 1, 1], "robots": [], **wrong})
    assert caught.value.error_count() <= 2


def test_a_mapping_of_too_many_keys_is_refused(tmp_path: Path) -> None:
    keys = range(100_001)
    assert "100000 keys" in str(refusal(write(tmp_path, "a.json", json.dumps({f"k{k}": 1 for k in keys}))))
    assert "100000 keys" in str(refusal(write(tmp_path, "a.yaml", "".join(f"k{k}: 1\n" for k in keys))))


def test_a_yaml_bomb_is_refused_at_its_first_anchor(tmp_path: Path) -> None:
    bomb = "a: &a [x]\n" + "".join(f"b{k}: &b{k} [*a, *a]\n" for k in range(50))
    assert refusal(write(tmp_path, "a.yaml", bomb)).line == 1


def test_what_is_no_file_is_refused(tmp_path: Path) -> None:
    (tmp_path / "folder.yaml").mkdir()
    assert "is a directory" in str(refusal(tmp_path / "folder.yaml"))
    assert "is a directory" in str(refusal(tmp_path))
    assert "does not exist" in str(refusal(tmp_path / "missing.yaml"))
    assert "unknown kind of file" in str(refusal(write(tmp_path, "a.txt", EXAMPLE)))
    for name in ("", "a\0b.yaml", "x" * 5000):
        with pytest.raises(SceneError) as caught:
            load_scene(name)
        assert str(caught.value).isprintable()


def test_a_pipe_is_refused_instead_of_waited_for(tmp_path: Path) -> None:
    os.mkfifo(tmp_path / "a.yaml")
    assert "not a regular file" in str(refusal(tmp_path / "a.yaml"))


@pytest.mark.skipif(os.geteuid() == 0, reason="root reads everything")
def test_an_unreadable_file_is_refused(tmp_path: Path) -> None:
    path = write(tmp_path, "a.yaml", EXAMPLE)
    path.chmod(0)
    assert "cannot be read" in str(refusal(path))


def test_a_wrong_name_lists_near_ready_scenes() -> None:
    with pytest.raises(SceneError, match=r"thesis-2x: does not exist; did you mean the ready scene .*thesis-2"):
        load_scene("thesis-2x")


WRONG_PLANS: dict[str, tuple[Callable[[Any], object], str]] = {
    "no motion": (lambda d: d["robots"].pop(), "robot é\\n has no trajectory"),
    "a motion too many": (
        lambda d: d["robots"].append({"name": "R9", "stamps": [[0, 1, 1]]}),
        "R9 is not in the scene",
    ),
    "a motion twice": (lambda d: d["robots"].append(d["robots"][0]), "R1 has two trajectories"),
    "no stamps": (lambda d: d["robots"][0].update(stamps=[]), "robot R1: stamps must be a list of at least 1 stamp"),
    "a stamp of two": (
        lambda d: d["robots"][0]["stamps"][0].pop(),
        "robot R1: stamps: stamp 1 must be a stamp [t, x, y]",
    ),
    "time runs back": (lambda d: d["robots"][0]["stamps"].reverse(), "robot R1: the first stamp must be at t = 0"),
    "a wrong scene": (lambda d: d["scene"].update(gap="x"), "scene: gap must be a number, got 'x'"),
    "a wrong robot": (lambda d: d["scene"]["robots"][0].update(speed=0), "scene: robot R1: speed must be positive"),
    "no scene": (lambda d: d.pop("scene"), "`scene` is missing"),
    "unknown key": (lambda d: d.update(certificat={}), "unknown key `certificat`; did you mean `certificate`?"),
    "unknown key in the scene": (lambda d: d["scene"].update(gab=1), "scene: unknown key `gab`; did you mean `gap`?"),
    "unknown key of a motion": (
        lambda d: d["robots"][0].update(nam=1),
        "robot R1: unknown key `nam`; did you mean `name`?",
    ),
    "another kind": (lambda d: d.update(kind="route"), 'kind must be "plan"'),
    "a bound that is none": (lambda d: d["metrics"].update(lower_bound=3), "lower_bound must be a mapping"),
    "a bound of nonsense": (
        lambda d: d["metrics"].update(lower_bound={"model": 7, "value": "x"}),
        "lower_bound must be a mapping of model (text) and value (seconds)",
    ),
    "a bound without value": (lambda d: d["metrics"].update(lower_bound={"model": "plane"}), "lower_bound must be"),
    "a bound that is true": (
        lambda d: d["metrics"].update(lower_bound={"model": "plane", "value": True}),
        "lower_bound must be",
    ),
}


@pytest.mark.parametrize("case", WRONG_PLANS)
def test_plans_that_are_wrong_are_refused_with_their_line(case: str, tmp_path: Path) -> None:
    change, message = WRONG_PLANS[case]
    data = plan_to_dict(a_plan())
    change(data)
    path = write(tmp_path, "p.json", json.dumps(data, indent=1))
    with pytest.raises(PlanError) as caught:
        load_plan(path)
    assert message in str(caught.value)
    assert str(caught.value).isprintable()
    assert caught.value.file == str(path)
    assert caught.value.line


def test_a_scene_is_not_a_plan(tmp_path: Path) -> None:
    for path in (
        write(tmp_path, "a.json", PRETTY),
        tmp_path,
        tmp_path / "missing.json",
        write(tmp_path, "a.yaml", EXAMPLE),
    ):
        with pytest.raises(PlanError) as caught:
            load_plan(path)
        assert caught.value.file == str(path)


def mutated(text: str, seed: int) -> str:
    """Return the text with a few random cuts, copies, swaps and insertions."""
    rng = random.Random(seed)
    words = [
        "{",
        "}",
        "[",
        "]",
        ",",
        ":",
        '"',
        "'",
        "-",
        "\n",
        " ",
        "\t",
        "1e999",
        "NaN",
        ".nan",
        "null",
        "true",
        "&a",
        "*a",
        "!!x",
    ]
    words += [
        "name",
        "taut",
        "\\ud800",
        "\\n",
        "\u2028",
        "-0",
        "1" * 400,
        "[[[",
        "polygon",
        "robots",
        "Polygon",
        "Point",
    ]
    for _ in range(rng.randint(1, 4)):
        i, j = sorted(rng.randrange(len(text) + 1) for _ in range(2))
        j = min(j, i + rng.choice([0, 1, 2, 5, 40]))
        middle = rng.choice([rng.choice(words), "", text[i:j] * 2, text[i:j][::-1]])
        text = text[:i] + middle + text[j:]
    return text


@settings(deadline=None, max_examples=500)
@given(seed=st.integers(0, 2**32), ending=st.sampled_from(ENDINGS))
def test_a_mutated_file_gives_a_scene_or_one_line(
    seed: int, ending: str, tmp_path_factory: pytest.TempPathFactory
) -> None:
    path = tmp_path_factory.mktemp("mutated") / f"a{ending}"
    save(EXAMPLE_SCENE, path)
    path.write_text(mutated(path.read_text(), seed), encoding="utf-8")
    outcome = value_or_refusal(lambda: load_scene(path))
    assert isinstance(outcome, Scene) or (outcome.isprintable() and outcome.startswith(str(path)))


def value_or_refusal(load: Callable[[], Any]) -> Any:
    """Return what was loaded, or the text of the refusal; any other exception is a failure."""
    try:
        return load()
    except SceneError as error:
        return str(error)


values = st.recursive(
    st.none() | st.booleans() | st.floats() | st.integers(-(10**400), 10**400) | st.text(max_size=5),
    lambda inner: st.lists(inner, max_size=3) | st.dictionaries(st.text(max_size=5), inner, max_size=3),
    max_leaves=6,
)


@settings(deadline=None, max_examples=300)
@given(value=values, seed=st.integers(0, 2**32))
def test_any_value_anywhere_gives_a_plan_or_one_line(value: Any, seed: int) -> None:
    rng = random.Random(seed)
    data = json.loads(json.dumps(plan_to_dict(a_plan())))
    part: Any = data
    while True:
        keys = list(part) if isinstance(part, dict) else list(range(len(part)))
        key = rng.choice(keys)
        if not isinstance(part[key], dict | list) or not part[key] or rng.random() < 0.2:
            break
        part = part[key]
    part[key] = value
    outcome = value_or_refusal(lambda: plan_from_dict(data))
    assert isinstance(outcome, Plan) or outcome.isprintable()


# --- writing


@pytest.mark.parametrize("name", ["missing/a.yaml", "a.txt", "a", "a\0.yaml", "x" * 300 + ".yaml"])
def test_what_cannot_be_written_is_told_in_one_line(name: str, tmp_path: Path) -> None:
    with pytest.raises(OutputError) as caught:
        save(EXAMPLE_SCENE, tmp_path / name)
    assert str(caught.value).isprintable()
    assert list(tmp_path.iterdir()) == []


def test_folders_devices_and_protected_files_are_left_alone(tmp_path: Path) -> None:
    (tmp_path / "a.yaml").mkdir()
    (tmp_path / "b.yaml").symlink_to("/dev/null")
    for name in ("a.yaml", "b.yaml"):
        with pytest.raises(OutputError, match="cannot be written"):
            save(EXAMPLE_SCENE, tmp_path / name)
    assert stat.S_ISCHR(os.stat("/dev/null").st_mode)
    assert sorted(p.name for p in tmp_path.iterdir()) == ["a.yaml", "b.yaml"]


def test_a_failure_leaves_the_old_file_and_nothing_else(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    path = write(tmp_path, "a.yaml", "old")

    def full(*_: object) -> None:
        raise OSError(28, "No space left on device")

    monkeypatch.setattr(os, "fsync", full)
    with pytest.raises(OutputError, match="No space left on device"):
        save(EXAMPLE_SCENE, path)
    assert [p.name for p in tmp_path.iterdir()] == ["a.yaml"]
    assert path.read_text() == "old"


def test_a_link_stays_a_link(tmp_path: Path) -> None:
    (tmp_path / "link.yaml").symlink_to(write(tmp_path, "real.yaml", "old"))
    save(EXAMPLE_SCENE, tmp_path / "link.yaml")
    assert (tmp_path / "link.yaml").is_symlink()
    assert load_scene(tmp_path / "real.yaml") == EXAMPLE_SCENE


def test_plans_are_json_and_hold_plain_values(tmp_path: Path) -> None:
    with pytest.raises(OutputError, match="a plan is written as"):
        save(a_plan(), tmp_path / "p.yaml")
    plan = Plan(a_plan().scene, a_plan().trajectories, {"method": object()})
    with pytest.raises(OutputError, match=r"planner\.method"):
        save(plan, tmp_path / "p.json")
    assert list(tmp_path.iterdir()) == []


def test_a_name_no_file_can_hold_is_refused(tmp_path: Path) -> None:
    for ending in ENDINGS:
        with pytest.raises(OutputError, match="surrogate"):
            save(Scene((0, 0, 1, 1), name="\ud800"), tmp_path / f"a{ending}")
    assert list(tmp_path.iterdir()) == []


# --- schema


def test_the_published_schema_is_the_one_in_force() -> None:
    assert json.loads(SCHEMA_FILE.read_text(encoding="utf-8")) == scene_schema()


# --- GeoJSON


def collection(*features: tuple[dict[str, Any], str, Any], **more: Any) -> str:
    entries = [
        {"type": "Feature", "properties": properties, "geometry": {"type": kind, "coordinates": coordinates}}
        for properties, kind, coordinates in features
    ]
    return json.dumps({"type": "FeatureCollection", "features": entries, **more}, indent=1)


def ring(*corners: tuple[float, float]) -> list[list[float]]:
    return [list(corner) for corner in (*corners, corners[0])]


def box(x: float, y: float, w: float, h: float) -> list[list[float]]:
    return ring((x, y), (x + w, y), (x + w, y + h), (x, y + h))


def free(scene: Scene) -> shapely.Geometry:
    """Return the free region; all rings must be simple for it to be one."""
    rings = [shapely.Polygon(scene.workspace), *(shapely.Polygon(o.core) for o in scene.obstacles)]
    assert all(r.is_valid for r in rings)
    return rings[0].difference(shapely.union_all(rings[1:]))


BOUNDARY = ({"role": "boundary"}, "Polygon", [box(0, 0, 10, 10)])


def test_geojson_speaks_of_every_shape(tmp_path: Path) -> None:
    text = collection(
        BOUNDARY,
        ({"role": "obstacle", "name": "pond", "fill": "#00f"}, "MultiPolygon", [[box(1, 1, 1, 1)], [box(3, 1, 1, 1)]]),
        ({"role": "obstacle", "radius": 0.5, "width": None}, "Point", [5, 5, 120]),
        ({"role": "obstacle", "width": 0.2}, "LineString", [[6, 6], [7, 7]]),
        ({"role": "robot", "name": "R1", "goal": [9, 9], "radius": 0.1, "at_goal": "leave"}, "Point", [0.5, 0.5]),
        ({"role": "robot", "name": "R2", "speed": 2}, "LineString", [[9, 1], [1, 9]]),
        taut={"version": 1, "gap": 0.25},
    )
    assert load_scene(write(tmp_path, "a.geojson", text)) == Scene(
        [(0, 0), (10, 0), (10, 10), (0, 10)],
        [
            Polygon([(1, 1), (2, 1), (2, 2), (1, 2)], "pond 1"),
            Polygon([(3, 1), (4, 1), (4, 2), (3, 2)], "pond 2"),
            Circle((5, 5), 0.5, "O3"),
            Line([(6, 6), (7, 7)], 0.2, "O4"),
        ],
        [Robot("R1", (0.5, 0.5), (9, 9), radius=0.1, at_goal="leave"), Robot("R2", (9, 1), (1, 9), speed=2)],
        gap=0.25,
    )


@pytest.mark.parametrize(
    ("features", "area"),
    [
        ([({"role": "boundary"}, "Polygon", [box(0, 0, 10, 10), box(2, 2, 3, 3), box(5, 5, 1, 1)])], 90.0),
        ([({"role": "boundary"}, "MultiPolygon", [[box(0, 0, 10, 10)]])], 100.0),
        # a boundary that comes back to one corner, with a pocket inside, and two rooms that meet in a point
        (
            [
                (
                    {"role": "boundary"},
                    "Polygon",
                    [
                        ring((0, 0), (4, 0), (4, 4), (2, 0.5), (4, 4), (0, 4))[:3]
                        + ring((4, 4), (3, 1), (1, 3), (4, 4), (0, 4), (0, 0))[:-1]
                    ],
                )
            ],
            12.0,
        ),
        (
            [({"role": "boundary"}, "Polygon", [ring((0, 0), (2, 0), (2, 2), (4, 2), (4, 4), (2, 4), (2, 2), (0, 2))])],
            8.0,
        ),
        # obstacles: meeting in a corner, with holes, with a hole that touches the ring
        (
            [
                BOUNDARY,
                (
                    {"role": "obstacle"},
                    "Polygon",
                    [ring((1, 1), (2, 1), (2, 2), (3, 2), (3, 3), (2, 3), (2, 2), (1, 2))],
                ),
            ],
            98.0,
        ),
        (
            [
                BOUNDARY,
                ({"role": "obstacle"}, "Polygon", [box(1, 1, 6, 6), box(2, 2, 1, 1), box(5, 5, 1, 1), box(2, 4, 1, 2)]),
            ],
            68.0,
        ),
        ([BOUNDARY, ({"role": "obstacle"}, "Polygon", [box(1, 1, 6, 6), ring((1, 1), (3, 2), (2, 3))])], 65.5),
        # rooms apart, and a courtyard with a kiosk
        ([BOUNDARY, ({"role": "boundary"}, "Polygon", [box(12, 3, 2, 2)])], 104.0),
        (
            [
                BOUNDARY,
                ({"role": "obstacle"}, "Polygon", [box(1, 1, 6, 6)]),
                ({"role": "boundary"}, "Polygon", [box(2, 2, 4, 4)]),
                ({"role": "obstacle"}, "Polygon", [box(3, 3, 1, 1)]),
            ],
            79.0,
        ),
        # an obstacle across two rooms is no courtyard
        (
            [
                BOUNDARY,
                ({"role": "boundary"}, "Polygon", [box(12, 3, 2, 2)]),
                ({"role": "obstacle"}, "Polygon", [box(9, 2, 6, 6)]),
            ],
            94.0,
        ),
    ],
)
def test_geojson_keeps_the_free_area_whatever_the_rings_do(features: list[Any], area: float, tmp_path: Path) -> None:
    scene = load_scene(write(tmp_path, "a.geojson", collection(*features)))
    assert free(scene).area == area
    given = {tuple(c) for _, kind, rings in features for r in (rings if kind == "Polygon" else rings[0]) for c in r}
    used = {p for o in scene.obstacles if isinstance(o, Polygon) for p in o.points}
    sides = np.array(scene.workspace)
    assert used <= given | set(scene.workspace)
    assert sides.min() >= 0


def test_a_hole_is_cut_open_into_few_pieces(tmp_path: Path) -> None:
    holes = [box(2 * k + 1, 2 * j + 1, 1, 1) for k in range(8) for j in range(8)]
    features = (
        ({"role": "boundary"}, "Polygon", [box(0, 0, 20, 20)]),
        ({"role": "obstacle"}, "Polygon", [box(0, 0, 18, 18), *holes]),
    )
    scene = load_scene(write(tmp_path, "a.geojson", collection(*features)))
    assert free(scene).area == 400 - 324 + 64
    assert len(scene.obstacles) <= 65


@pytest.mark.parametrize(
    ("features", "message"),
    [
        ([({"role": "obstacle"}, "Polygon", [box(0, 0, 1, 1)])], "no boundary"),
        (
            [BOUNDARY, ({"role": "lake"}, "Polygon", [box(0, 0, 1, 1)])],
            "feature 2: `role` must be boundary, obstacle or",
        ),
        ([BOUNDARY, ({}, "Polygon", [box(0, 0, 1, 1)])], "`role` must be"),
        ([BOUNDARY, ({"role": "obstacle"}, "Point", [1, 1])], "feature 2: obstacle must be a Polygon"),
        ([BOUNDARY, ({"role": "obstacle", "raduis": 1, "radius": 1}, "Point", [1, 1])], "did you mean `radius`?"),
        ([BOUNDARY, ({"role": "obstacle", "radius": "1"}, "Point", [1, 1])], "radius must be a number, got '1'"),
        ([BOUNDARY, ({"role": "obstacle", "radius": 1}, "Point", [1, "x"])], "a position must be [x, y]"),
        ([BOUNDARY, ({"role": "obstacle"}, "Polygon", [[[0, 0], [1, 1]]])], "a ring needs at least 3 corners"),
        ([BOUNDARY, ({"role": "obstacle"}, "Polygon", [])], "a polygon without a ring"),
        ([BOUNDARY, ({"role": "obstacle"}, "Polygon", 7)], "`coordinates` must be nested lists"),
        (
            [BOUNDARY, ({"role": "obstacle", "name": "A"}, "Polygon", [box(0, 0, 2, 2), box(1, 1, 3, 3)])],
            "obstacle A: its holes",
        ),
        ([BOUNDARY, ({"role": "boundary"}, "Polygon", [box(5, 5, 9, 9)])], "the boundaries overlap"),
        ([BOUNDARY, ({"role": "robot", "name": "R1"}, "Point", [1, 1])], "robot R1: `goal` is missing"),
        ([BOUNDARY, ({"role": "robot", "goal": [1, 1]}, "Point", [1, 1])], "robot number 1: `name` is missing"),
        ([BOUNDARY, ({"role": "robot", "name": "R1"}, "LineString", [[1, 1], [2, 2], [3, 3]])], "start and goal"),
        ([BOUNDARY, ({"role": "robot", "name": "R1"}, "Polygon", [box(0, 0, 1, 1)])], "robot must be a Point"),
        (
            [BOUNDARY, ({"role": "obstacle", "rectangle": [0, 0, 1, 1]}, "Polygon", [box(0, 0, 1, 2)])],
            "remove the property",
        ),
    ],
)
def test_geojson_that_is_wrong_is_refused_with_its_line(features: list[Any], message: str, tmp_path: Path) -> None:
    error = refusal(write(tmp_path, "a.geojson", collection(*features)))
    assert message in str(error)
    assert error.line


def test_a_crossing_ring_is_left_for_validation_to_place(tmp_path: Path) -> None:
    bow = ring((1, 1), (3, 3), (3, 1), (1, 3))
    scene = load_scene(write(tmp_path, "a.geojson", collection(BOUNDARY, ({"role": "obstacle"}, "Polygon", [bow]))))
    assert scene.obstacles == (Polygon([(1, 1), (3, 3), (3, 1), (1, 3)], "O1"),)
