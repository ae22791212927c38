"""A text file read as plain data whose parts still know their lines."""

from __future__ import annotations

import os
import re
import reprlib
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import Any, TypeAlias

from taut.errors import SceneError, one_line

Place: TypeAlias = tuple[str | int, ...]
Mark: TypeAlias = "int | _Marks"

MAX_DEPTH = 64
MAX_KEYS = 100_000  # of one mapping: no scene or plan has nearly as many, and each wrong one costs a report
CROWDED = f"a mapping of more than {MAX_KEYS} keys: this is not a scene or plan"
_CONTROL = re.compile(rb"[\x00-\x08\x0b\x0c\x0e-\x1f]")
_SHORT = reprlib.Repr()
_SHORT.maxstring = _SHORT.maxother = 60
_SHORT.maxlong = 40


@dataclass(frozen=True)
class Document:
    """What a file says.

    Parameters
    ----------
    data : nested dicts, lists, strings, numbers, booleans and None.
    line_of : 1-based line of the part at a place (keys and indices from the top), or None if unknown. A place that
        does not exist gives the line of the innermost part that does.
    file : the file's name, None for data that came from no file.
    """

    data: Any
    line_of: Callable[[Place], int | None]
    file: str | None = None

    def error(self, message: str, place: Place = ()) -> SceneError:
        """Return a SceneError that points at a place of this file."""
        return SceneError(message, self.file, self.line_of(place))


@dataclass(slots=True)
class _Marks:
    """Lines of a container and of its parts."""

    line: int
    parts: dict[str | int, Mark]


class DocumentBuilder:
    """Builds data and lines from a stream of parser events; refuses duplicate keys and deep nesting at once."""

    def __init__(self, file: str | None) -> None:
        self._file = file
        self._stack: list[tuple[Any, _Marks]] = []
        self._key: str | None = None
        self._key_line = 0
        self._root: tuple[Any, Mark] | None = None

    def expects_key(self) -> bool:
        """Whether the next value is a key of a mapping."""
        return bool(self._stack) and self._key is None and isinstance(self._stack[-1][0], dict)

    def key(self, text: str, line: int) -> None:
        """Take the key of the next value."""
        mapping = self._stack[-1][0]
        if text in mapping:
            raise SceneError(doubled(text), self._file, line)
        if len(mapping) >= MAX_KEYS:
            raise SceneError(CROWDED, self._file, line)
        self._key, self._key_line = text, line

    def scalar(self, value: object, line: int) -> None:
        """Take a value without parts."""
        self._put(value, line)

    def open(self, container: dict[str, Any] | list[Any], line: int) -> None:
        """Begin a mapping or list."""
        if len(self._stack) >= MAX_DEPTH:
            raise SceneError(f"nested more than {MAX_DEPTH} deep: this is not a scene or plan", self._file, line)
        marks = _Marks(line if self._key is None else self._key_line, {})
        self._put(container, marks)
        self._stack.append((container, marks))

    def close(self) -> None:
        """End the innermost mapping or list."""
        self._stack.pop()

    def document(self) -> Document | None:
        """Return what was built, None if nothing came."""
        if self._root is None:
            return None
        data, marks = self._root

        def line_of(place: Place) -> int | None:
            mark = marks
            for step in place:
                if isinstance(mark, int) or step not in mark.parts:
                    break
                mark = mark.parts[step]
            return mark if isinstance(mark, int) else mark.line

        return Document(data, line_of, self._file)

    def _put(self, value: object, mark: Mark) -> None:
        if not self._stack:
            self._root = value, mark
            return
        container, marks = self._stack[-1]
        if isinstance(container, list):
            marks.parts[len(container)] = mark
            container.append(value)
        else:
            assert self._key is not None
            marks.parts[self._key] = self._key_line if isinstance(mark, int) else mark
            container[self._key] = value
            self._key = None


def read_text(path: str | os.PathLike[str], limit: int) -> str:
    """Return the text of a UTF-8 file of at most `limit` bytes.

    Raises
    ------
    SceneError
        A directory, unreadable, larger than the limit, empty, binary or not UTF-8.
    """
    file = os.fspath(path)
    try:
        if Path(path).is_dir():
            raise SceneError("is a directory, not a file; name a file in it", file)
        if not Path(path).is_file():
            raise SceneError("does not exist or is not a regular file", file)
        with open(path, "rb") as stream:
            raw = stream.read(limit + 1)
    except (OSError, ValueError) as error:
        raise SceneError(f"cannot be read: {getattr(error, 'strerror', None) or error}", file) from None
    if len(raw) > limit:
        raise SceneError(f"is larger than {limit >> 20} MB, the limit for this kind of file", file)
    if not raw.strip():
        raise SceneError("is empty", file)
    if control := _CONTROL.search(raw):
        line = raw.count(b"\n", 0, control.start()) + 1
        raise SceneError(f"holds the control byte 0x{control[0][0]:02x}: this is not a text file", file, line)
    try:
        return raw.decode("utf-8-sig")
    except UnicodeDecodeError as error:
        line = raw.count(b"\n", 0, error.start) + 1
        raise SceneError(f"is not UTF-8 text (byte 0x{raw[error.start]:02x}); save it as UTF-8", file, line) from None


def doubled(key: str) -> str:
    """Return the message for a key that is given twice."""
    return f"key {shown(key)} is given twice; keep one"


def not_a_mapping(what: str) -> str:
    """Return the message for a file that holds something else, a list or a word, instead of keys and values."""
    return f"must be a mapping of keys to values, got {what}"


def shown(value: object) -> str:
    """Return a value as it may stand in a message: short and on one line."""
    if value is None:
        return "nothing"
    if isinstance(value, bool):
        return str(value).lower()
    try:
        return one_line(_SHORT.repr(value))
    except ValueError:  # an int with more digits than Python is willing to print
        return "a number with thousands of digits"
