"""The file that the user named: nothing else is written, and nothing of it is lost unasked."""

from __future__ import annotations

import os
import stat
from pathlib import Path

import pytest

import taut
from taut.errors import OutputError, SceneError
from taut.formats import scene_to_dict, yaml_text
from taut.studio.crew import Crew
from taut.studio.jobs import opened
from taut.studio.link import Studio
from taut.studio.scene_file import NEW, Named, NotSaved, SceneFile, comments, named

TEXT = yaml_text.scene_yaml(scene_to_dict(taut.load_scene("thesis-2")))
OTHER = yaml_text.scene_yaml(scene_to_dict(taut.load_scene("thesis-1")))


@pytest.fixture
def path(tmp_path: Path) -> Path:
    file = tmp_path / "floor.yaml"
    file.write_text(TEXT, encoding="utf-8")
    return file


def file_of(known: Named) -> SceneFile:
    assert known.file is not None
    return known.file


def test_saving_writes_the_text_and_returns_the_stamp_of_what_is_there_then(path: Path) -> None:
    known = named(str(path))
    file = file_of(known)
    stamp = file.save(OTHER, known.stamp, False, False)
    assert path.read_text(encoding="utf-8") == OTHER
    assert stamp == file.stamp() != known.stamp
    file.save(TEXT, stamp, False, False)
    assert os.listdir(path.parent) == ["floor.yaml"], "nothing is left behind"


@pytest.mark.parametrize("change", ["edit", "delete", "same size and time"])
def test_a_file_that_others_changed_is_not_replaced_unasked(path: Path, change: str) -> None:
    known = named(str(path))
    before = path.stat()
    if change == "delete":
        path.unlink()
    elif change == "edit":
        path.write_text(TEXT + "\n", encoding="utf-8")
    else:
        path.write_text(TEXT.replace("thesis-2", "thesis-9"), encoding="utf-8")
        os.utime(path, ns=(before.st_atime_ns, before.st_mtime_ns))
        assert path.stat().st_size == before.st_size
    now = path.read_bytes() if path.exists() else None
    with pytest.raises(NotSaved, match="deleted" if change == "delete" else "changed") as refused:
        file_of(known).save(OTHER, known.stamp, False, False)
    assert refused.value.kind == "changed"
    assert (path.read_bytes() if path.exists() else None) == now
    file_of(known).save(OTHER, known.stamp, True, False)
    assert path.read_text(encoding="utf-8") == OTHER


def test_a_file_that_was_only_touched_is_replaced(path: Path) -> None:
    known = named(str(path))
    os.utime(path, (1, 1))
    file_of(known).save(OTHER, known.stamp, False, False)


def test_comments_do_not_go_unasked(path: Path) -> None:
    path.write_text("# drawn by hand\n" + TEXT + "# the end\n", encoding="utf-8")
    known = named(str(path))
    with pytest.raises(NotSaved, match="2 comments") as refused:
        file_of(known).save(TEXT, known.stamp, True, False)
    assert refused.value.kind == "comments"
    stamp = file_of(known).save(TEXT, known.stamp, False, True)
    file_of(known).save(OTHER, stamp, False, False)


@pytest.mark.parametrize(
    ("text", "lines"),
    [
        ("", []),
        ("a: 1", []),
        ("# é\na: 1  # metres\nb: 'no # comment'\n# an end", [1, 2, 4]),
        ('a: é#x  #é\nb: "#"\n', [1]),
        ("a: [1, 2] # x\nb: # y\n  - {c: 1} #z", [1, 2, 3]),
        ("a: [ # \U0001f916\n  1, # one\n  2]", [1, 2]),
        ("a: {b: 1\n# not closed", [2]),
    ],
)
def test_comments_are_found_and_signs_in_texts_are_none(text: str, lines: list[int]) -> None:
    assert comments(text) == lines


def test_what_the_studio_writes_has_no_comments() -> None:
    robot = taut.Robot("R # 1", (1, 1), (2, 2), radius=0.1)
    scene = taut.Scene((0, 0, 9, 9), [taut.Circle((5, 5), 1, name="# O")], [robot], name="a # b")
    assert comments(yaml_text.scene_yaml(scene_to_dict(scene))) == []


def test_a_name_that_is_no_file_yet_is_a_new_file(tmp_path: Path) -> None:
    known = named(str(tmp_path / "new.yaml"))
    assert known.value is None
    assert known.stamp == NEW
    assert not file_of(known).path.exists()
    file_of(known).save(TEXT, NEW, False, False)
    with pytest.raises(NotSaved, match="changed"):
        file_of(known).save(OTHER, NEW, False, False)
    with pytest.raises(SceneError, match="no folder"):
        named(str(tmp_path / "nowhere" / "new.yaml"))


def test_what_is_no_scene_file_is_only_read(tmp_path: Path) -> None:
    plan = tmp_path / "plan.json"
    taut.save(taut.plan(taut.load_scene("thesis-2")).plan, plan)
    known = named(str(plan))
    assert isinstance(known.value, taut.Plan)
    assert known.file is None
    map_ = tmp_path / "walls.geojson"
    taut.save(taut.load_scene("thesis-2"), map_)
    assert named(str(map_)).file is None
    assert named("thesis-2").file is None
    for wrong in ("thesis-two", str(tmp_path), str(tmp_path / "walls.dwg")):
        with pytest.raises(SceneError):
            named(wrong)


def test_a_plan_brings_its_scene_and_a_proof_of_our_own(tmp_path: Path) -> None:
    plan = taut.plan(taut.load_scene("thesis-2")).plan
    held = opened(plan)
    assert held["scene"] == scene_to_dict(plan.scene)
    assert held["certificate"]["ok"]
    assert "scene" not in held["plan"]


def test_links_are_followed_not_replaced(tmp_path: Path, path: Path) -> None:
    link = tmp_path / "link.yaml"
    link.symlink_to(path)
    known = named(str(link))
    file_of(known).save(OTHER, known.stamp, False, False)
    assert link.is_symlink()
    assert path.read_text(encoding="utf-8") == OTHER


@pytest.mark.skipif(not hasattr(os, "geteuid") or os.geteuid() == 0, reason="root writes everywhere")
def test_a_folder_that_cannot_be_written_is_told(path: Path) -> None:
    known = named(str(path))
    path.parent.chmod(stat.S_IRUSR | stat.S_IXUSR)
    try:
        with pytest.raises(OutputError, match="cannot be written"):
            file_of(known).save(OTHER, known.stamp, False, False)
    finally:
        path.parent.chmod(stat.S_IRWXU)
    assert path.read_text(encoding="utf-8") == TEXT


def test_a_file_whose_folder_is_gone_is_told(tmp_path: Path) -> None:
    folder = tmp_path / "folder"
    folder.mkdir()
    known = named(str(folder / "new.yaml"))
    folder.rmdir()
    with pytest.raises(OutputError, match="cannot be written"):
        file_of(known).save(OTHER, known.stamp, False, False)


def test_hello_brings_the_file_as_it_is_now_and_an_old_state_where_it_cannot_be_read(path: Path) -> None:
    studio = Studio(str(path), named(str(path)), Crew())
    first = studio.hello()
    assert first["scene"]["name"] == "thesis-2"
    path.write_text(OTHER, encoding="utf-8")
    second = studio.hello()
    assert second["scene"]["name"] == "thesis-1"
    assert second["file"]["stamp"] != first["file"]["stamp"]
    for damage in ("robots: 7", None):
        path.unlink() if damage is None else path.write_text(damage, encoding="utf-8")
        hello = studio.hello()
        assert hello["scene"] == second["scene"]
        assert "shown is what it held" in hello["notes"][0]
        with pytest.raises(NotSaved):
            file_of(studio.last).save(OTHER, hello["file"]["stamp"], False, False)
