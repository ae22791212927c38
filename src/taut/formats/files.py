"""Loading and saving by file name; scenes that come with the package by their name."""

from __future__ import annotations

import difflib
import os
from importlib import resources
from pathlib import Path
from typing import assert_never

from taut.errors import OutputError, PlanError, SceneError
from taut.formats import geojson, json_text, movingai, yaml_text
from taut.formats._document import Document, read_text
from taut.formats.convert import plan_of, plan_to_dict, scene_of, scene_to_dict
from taut.motion import Plan
from taut.scene import Scene
from taut.writing import write_text

_YAML = (".yaml", ".yml")


def load_scene(path_or_name: str | os.PathLike[str]) -> Scene:
    """Return the scene of a file, or a ready scene by its name.

    Parameters
    ----------
    path_or_name : a .yaml, .yml (at most 8 MB), .json, .geojson or MovingAI .map file (at most 64 MB), or the name of a
        ready scene such as "thesis-2".

    Raises
    ------
    SceneError
        No such file or name, or anything wrong in it: one line, with file and line number where there is one.
    """
    path = Path(path_or_name)
    name = os.fspath(path_or_name)
    if not name:
        raise SceneError("no scene is named; give a file or the name of a ready scene")
    if not os.path.isfile(name) and name in scene_names():
        return scene_of(_ready(name))
    if not os.path.exists(name):
        raise SceneError(_unknown(name), name)
    suffix = path.suffix.lower()
    if suffix in _YAML:
        return scene_of(yaml_text.parse_yaml(read_text(path, yaml_text.LIMIT), name))
    if suffix == ".json":
        return scene_of(json_text.parse_json(read_text(path, json_text.LIMIT), name))
    if suffix == ".geojson":
        return geojson.scene_of_geojson(json_text.parse_json(read_text(path, json_text.LIMIT), name))
    if path.is_dir():
        raise SceneError("is a directory, not a file; name a file in it", name)
    if suffix == ".map":
        return movingai.load_map(path)
    raise SceneError("unknown kind of file; a scene ends in .yaml, .yml, .json, .geojson or .map", name)


def load_plan(path: str | os.PathLike[str]) -> Plan:
    """Return the plan of a .json file.

    Raises
    ------
    PlanError
        No such file, or anything wrong in it or in its scene: one line, with file and line number where there is one.
    """
    name = os.fspath(path)
    try:
        if not os.path.exists(name):
            raise SceneError("does not exist", name)
        if Path(path).suffix.lower() in (*_YAML, ".geojson"):
            raise SceneError("unknown kind of file; a plan is a .json file", name)
        document = json_text.parse_json(read_text(path, json_text.LIMIT), name)
    except SceneError as error:
        raise PlanError(error.message, error.file, error.line) from None
    return plan_of(document)


def load_scene_or_plan(path_or_name: str | os.PathLike[str]) -> Scene | Plan:
    """Return what a file holds: a scene as `load_scene` reads it, or the plan of a .json file that says it is one.

    Raises
    ------
    SceneError
        As `load_scene` and `load_plan`.
    """
    path = Path(path_or_name)
    if path.suffix.lower() == ".json" and path.is_file():
        return value_of_text(read_text(path, json_text.LIMIT), os.fspath(path))
    return load_scene(path_or_name)


def value_of_text(text: str, name: str) -> Scene | Plan:
    """Return the scene or plan that the text of a file means.

    Parameters
    ----------
    text : what the file holds.
    name : of the file; its ending tells the kind, the text itself does where the ending is unknown. Named in errors.

    Raises
    ------
    SceneError
        Anything wrong in it: one line, with the number of the line where there is one.
    """
    if not text.strip():
        raise SceneError("is empty", name)
    suffix = Path(name).suffix.lower()
    if suffix not in (*_YAML, ".json", ".geojson", ".map"):
        begin = text.lstrip()[:4]
        suffix = ".json" if begin[0] == "{" else ".map" if begin == "type" else ".yaml"
    if suffix == ".map":
        return movingai.map_of_text(text, name)
    if suffix in _YAML:
        if len(text) > yaml_text.LIMIT:
            raise SceneError(f"is larger than {yaml_text.LIMIT >> 20} MB, the limit for this kind of file", name)
        return scene_of(yaml_text.parse_yaml(text, name))
    document = json_text.parse_json(text, name)
    if document.data.get("type") == "FeatureCollection" or suffix == ".geojson":
        return geojson.scene_of_geojson(document)
    return plan_of(document) if document.data.get("kind") == "plan" else scene_of(document)


def save(value: Scene | Plan, path: str | os.PathLike[str]) -> None:
    """Write a scene (.yaml, .yml, .json, .geojson) or a plan (.json), wholly or not at all; no digit is lost.

    Raises
    ------
    OutputError
        Another ending, an unwritable path, or a value that a file cannot hold.
    """
    suffix = Path(path).suffix.lower()
    match value:
        case Plan():
            if suffix != ".json":
                raise OutputError(f"{os.fspath(path)}: a plan is written as .json")
            text = json_text.layout(plan_to_dict(value))
        case Scene():
            if suffix in _YAML:
                text = yaml_text.scene_yaml(scene_to_dict(value))
            elif suffix == ".json":
                text = json_text.layout(scene_to_dict(value))
            elif suffix == ".geojson":
                text = json_text.layout(geojson.scene_to_geojson(value))
            else:
                endings = ".yaml, .yml, .json or .geojson"
                raise OutputError(f"{os.fspath(path)}: a scene is written as {endings}")
        case _:
            assert_never(value)
    write_text(path, text)


def scene_names() -> tuple[str, ...]:
    """Return the names of the ready scenes, sorted."""
    folder = resources.files("taut") / "scenes"
    if not folder.is_dir():
        return ()
    return tuple(sorted(entry.name[:-5] for entry in folder.iterdir() if entry.name.endswith(".yaml")))


def scene_abouts() -> tuple[tuple[str, str], ...]:
    """Return name and first sentence of every ready scene; it stands in the comment at the head of its file."""
    listed = []
    for name in scene_names():
        words: list[str] = []
        for line in (resources.files("taut") / "scenes" / f"{name}.yaml").read_text(encoding="utf-8").splitlines():
            if not line.startswith("#") or line.startswith("# Source"):
                break
            words += line.lstrip("# ").split()
        listed.append((name, " ".join(words).partition(". ")[0].rstrip(".")))
    return tuple(listed)


def _ready(name: str) -> Document:
    file = resources.files("taut") / "scenes" / f"{name}.yaml"
    return yaml_text.parse_yaml(file.read_text(encoding="utf-8"), f"{name}.yaml")


def _unknown(name: str) -> str:
    names = scene_names()
    close = difflib.get_close_matches(Path(name).stem[:100].lower(), names, 3, 0.5)
    if close:
        return f"does not exist; did you mean the ready scene {' or '.join(close)}?"
    return f"does not exist; ready scenes are {', '.join(names)}" if names else "does not exist"
