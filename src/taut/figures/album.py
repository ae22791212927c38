"""Albums: a folder with a picture, a text and the data of every stage of planning, and an index of them."""

from __future__ import annotations

import json
import os
import re
import tempfile
from collections.abc import Iterable, Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

from taut.errors import OutputError
from taut.figures.canvas import sheet
from taut.figures.maps import scene_view
from taut.figures.saving import NO_STAMPS, any_letters
from taut.writing import replacing, write_text

if TYPE_CHECKING:  # the planner is imported when there are stages: `require_album` is called before
    from matplotlib.axes import Axes

    from taut.team.stages import Stage

INDEX = "stages.json"
DPI = 200
_STAGE_FILE = re.compile(r"\d+-[a-z-]+\.(png|txt|json)")


def require_album(folder: str | os.PathLike[str]) -> None:
    """Raise now if stages could not be saved there later, after minutes of work.

    Raises
    ------
    OutputError
        It is no folder, or holds files but no album, or cannot be written.
    """
    home = Path(folder)
    _known(home)
    try:
        near = home
        while not near.exists() and near != near.parent:
            near = near.parent
        # only trying tells: rights, read-only mounts and full disks are not all visible in the mode bits
        with tempfile.TemporaryFile(dir=near) as probe:
            probe.write(b"taut")
    except (OSError, ValueError) as error:
        raise _refusal(home, error) from None


def save_stages(stages: Iterable[Stage], folder: str | os.PathLike[str]) -> list[Path]:
    """Write each stage into a folder: ``01-free-space.png``, ``.txt`` and ``.json``, and at last ``stages.json``.

    The index lists the files of every stage. The folder is made if need be. One that holds an album already is written
    anew: files that its index lists and that are not written again are removed, and nothing else is.

    Parameters
    ----------
    stages : what to draw and tell, in this order.
    folder : missing, empty, or with an album.

    Returns
    -------
    list of Path
        The files written, the index last.

    Raises
    ------
    OutputError
        The folder holds other files, or cannot be written.
    """
    home = Path(folder)
    stages = list(stages)
    new = _entries(stages)
    old = _known(home)
    try:
        home.mkdir(parents=True, exist_ok=True)
    except (OSError, ValueError) as error:
        raise _refusal(home, error) from None
    # the index knows every file before it is there, so that an album broken off is one still
    _write_index(home, [*old, *new])
    for stage, entry in zip(stages, new, strict=True):
        _write_stage(home, entry, stage)
    kept = _files(new)
    for name in _files(old):
        if name not in kept:
            _remove(home / name)
    return [*(home / name for name in kept), _write_index(home, new)]


def _known(home: Path) -> list[Mapping[str, Any]]:
    """Return what the index of the folder lists, nothing of a folder that is missing or empty."""
    try:
        if home.is_symlink() and not home.exists():
            raise OutputError(f"{home}: stages cannot be written there, it is a link to nothing")
        if not home.exists():
            return []
        if not home.is_dir():
            raise OutputError(f"{home}: stages cannot be written there, it is not a folder")
        index = home / INDEX
        if not index.is_file():
            if any(home.iterdir()):
                raise OutputError(f"{home}: holds files that are not stages; give a new or empty folder")
            return []
        text = index.read_text(encoding="utf-8")
    except UnicodeDecodeError:
        text = ""
    except (OSError, ValueError) as error:
        raise _refusal(home, error) from None
    entries = _listed(home, text)
    known = _files(entries)
    for path in sorted(home.iterdir()):
        if not _STAGE_FILE.fullmatch(path.name):
            continue
        if not path.is_file():
            raise OutputError(f"{path}: a stage cannot be written there, it is not a file")
        if path.name not in known:
            raise OutputError(f"{path}: is not of the stages that {INDEX} lists, and would be replaced; move it away")
    return entries


def _listed(home: Path, text: str) -> list[Mapping[str, Any]]:
    try:
        data = json.loads(text)
        if (data["taut"], data["kind"]) != (1, "stages"):
            raise ValueError
        entries = list(data["stages"])
        if not all(isinstance(name, str) for entry in entries for name in entry["files"]):
            raise ValueError
    except (ValueError, TypeError, KeyError, RecursionError):
        raise OutputError(f"{home}: its {INDEX} is not an index of stages; give a new or empty folder") from None
    return entries


def _files(entries: Sequence[Mapping[str, Any]]) -> dict[str, None]:
    """Return the names listed that are plain names of files other than the index, in order."""
    names = (name for entry in entries for name in entry["files"])
    plain = (name for name in names if name == os.path.basename(name) and name not in ("", ".", "..", INDEX))
    return dict.fromkeys(name for name in plain if "\\" not in name and "\0" not in name)


def _entries(stages: Sequence[Stage]) -> list[Mapping[str, Any]]:
    from taut.team.telling import stage_data

    digits = max(2, len(str(len(stages))))
    out: list[Mapping[str, Any]] = []
    for number, stage in enumerate(stages, 1):
        data = stage_data(stage)
        stem = f"{number:0{digits}d}-{str(data['kind']).replace(' ', '-')}"
        files = [f"{stem}.{ending}" for ending in ("png", "txt", "json")]
        out.append({"number": number, "kind": data["kind"], "title": data["title"], "files": files})
    return out


def _write_stage(home: Path, entry: Mapping[str, Any], stage: Stage) -> None:
    from taut.figures.stages import draw_stage
    from taut.team.stages import SequenceStage
    from taut.team.telling import stage_data, tell

    picture, text, data = (home / name for name in entry["files"])
    scene = stage.plan.scene if isinstance(stage, SequenceStage) else stage.ground.freespace.scene
    axes = sheet(scene_view(scene))
    draw_stage(axes, stage, entry["number"])
    _write_picture(axes, picture)
    write_text(text, "\n".join([f"Stage {entry['number']} · {entry['title']}", "", *tell(stage), ""]))
    write_text(data, _json(stage_data(stage)))


def _write_picture(axes: Axes, path: Path) -> None:
    figure: Any = axes.figure
    with any_letters(), replacing(path) as scratch:
        figure.savefig(scratch, format="png", dpi=DPI, metadata=NO_STAMPS["png"])


def _write_index(home: Path, entries: Sequence[Mapping[str, Any]]) -> Path:
    path = home / INDEX
    write_text(path, _json({"taut": 1, "kind": "stages", "stages": list(entries)}))
    return path


def _json(data: Mapping[str, Any]) -> str:
    return json.dumps(data, ensure_ascii=False, allow_nan=False, indent=1) + "\n"


def _remove(path: Path) -> None:
    try:
        if path.is_file() or path.is_symlink():
            path.unlink()
    except OSError as error:
        raise OutputError(f"{path}: cannot be removed: {error.strerror}") from None


def _refusal(home: Path, error: Exception) -> OutputError:
    return OutputError(f"{home}: stages cannot be written there: {getattr(error, 'strerror', None) or error}")
