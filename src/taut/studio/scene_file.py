"""The one file that the user named: read, and written only if nobody else changed it and no comment would go."""

from __future__ import annotations

import hashlib
import re
from bisect import bisect_right
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Literal, TypeAlias

import yaml

from taut.errors import OutputError, SceneError, TautError
from taut.formats import load_scene_or_plan
from taut.motion import Plan
from taut.scene import Scene
from taut.writing import write_text

Format: TypeAlias = Literal["yaml", "json"]

_FORMATS: dict[str, Format] = {".yaml": "yaml", ".yml": "yaml", ".json": "json"}
_LOADER: Any = getattr(yaml, "CSafeLoader", yaml.SafeLoader)
NEW = ""  # the stamp of a file that does not exist


class NotSaved(TautError):
    """The file was left as it is; ``kind`` is "changed" or "comments": the page asks the user and may insist."""

    def __init__(self, message: str, kind: Literal["changed", "comments"]) -> None:
        self.kind = kind
        super().__init__(message)


@dataclass(frozen=True)
class SceneFile:
    """A scene file that may be written.

    Parameters
    ----------
    path : of the file, absolute; it need not exist yet.
    format : of its text.
    """

    path: Path
    format: Format

    def stamp(self) -> str:
        """Return what tells one state of the file from another: a hash of its bytes, "" where there is no file."""
        try:
            return hashlib.sha256(self.path.read_bytes()).hexdigest()
        except FileNotFoundError:
            return NEW
        except OSError as error:
            raise OutputError(f"{self.path}: cannot be read: {error.strerror or error}") from None

    def save(self, text: str, stamp: str, overwrite_changed: bool, drop_comments: bool) -> str:
        """Write the file, wholly or not at all, and return its new stamp.

        Parameters
        ----------
        text : of the scene.
        stamp : of the state that is to be replaced.
        overwrite_changed : replace whatever is there now.
        drop_comments : replace it though it has comments.

        Raises
        ------
        NotSaved
            The file is in another state, or has comments.
        OutputError
            It cannot be written.
        """
        now = self.stamp()
        if now != stamp and not overwrite_changed:
            what = "was deleted" if now == NEW else "was changed by another program or tab"
            raise NotSaved(f"{self.path.name} {what} since it was opened here", "changed")
        if self.format == "yaml" and not drop_comments and now != NEW:
            count = len(comments(self.path.read_text(encoding="utf-8", errors="replace")))
            if count:
                lines = "a comment" if count == 1 else f"{count} comments"
                raise NotSaved(
                    f"{self.path.name} holds {lines}, which would go: a scene has no place for them", "comments"
                )
        write_text(self.path, text)
        return hashlib.sha256(text.encode("utf-8")).hexdigest()


@dataclass(frozen=True)
class Named:
    """What the user named.

    Parameters
    ----------
    name : to be shown.
    value : what it holds, None for a file that is yet to be made.
    file : where it may be saved, None for what is only read: ready scenes, plans, maps of other kinds.
    stamp : of the file's state when it was read.
    """

    name: str
    value: Scene | Plan | None = None
    file: SceneFile | None = None
    stamp: str = NEW


def named(source: str) -> Named:
    """Return what a file or ready scene holds; a name that ends like a scene file but is none yet is a new file.

    Raises
    ------
    SceneError
        There is no such thing and it cannot be made, or anything is wrong in it.
    """
    path = Path(source)
    form = _FORMATS.get(path.suffix.lower())
    file = None if form is None else SceneFile(path.resolve(), form)
    if file is not None and not path.exists():
        if not path.parent.is_dir():
            raise SceneError(f"there is no folder {path.parent} to make it in", source)
        return Named(path.name, file=file)
    # taken first: what is changed between the two is then seen as changed, not overwritten
    stamp = NEW if file is None else file.stamp()
    value = load_scene_or_plan(source)
    if isinstance(value, Plan):
        return Named(path.name, value)  # a scene saved in its place would destroy the plan
    return Named(path.name, value, file, stamp)


def comments(text: str) -> list[int]:
    r"""Return the lines, from 1, of the comments of a YAML text; of one that is no YAML, all lines with a #.

    >>> comments("a: 1  # metres\nb: 'no # comment'\n# an end")
    [1, 3]
    """
    hashes = [match.start() for match in re.finditer("#", text)]
    if not hashes:
        return []
    try:
        tokens = [(token.start_mark.index, token.end_mark.index) for token in yaml.scan(text, Loader=_LOADER)]
    except yaml.YAMLError:
        tokens = []
    starts = [start for start, _ in tokens]

    def said(at: int) -> bool:
        k = bisect_right(starts, at) - 1
        return k >= 0 and at < tokens[k][1]

    lines = [text.count("\n", 0, at) + 1 for at in hashes if not said(at)]
    return list(dict.fromkeys(lines))
