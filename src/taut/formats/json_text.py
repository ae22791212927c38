"""Scenes and plans as JSON text: strict reading, lines looked up only when there is an error to place."""

from __future__ import annotations

import json
import re
from bisect import bisect_right
from collections import Counter
from collections.abc import Mapping
from functools import cache
from typing import Any

from taut.errors import SceneError
from taut.formats._document import CROWDED, MAX_KEYS, Document, DocumentBuilder, Place, doubled, not_a_mapping

LIMIT = 64 << 20
_LOCATED = 8 << 20  # characters up to which lines are looked up; beyond that it would take half a minute
_OTHERS = {"[": "a list", '"': "text", **dict.fromkeys("-0123456789", "a number")}

_BLANK = re.compile(r"[ \t\r\n]*")
_TOKEN = re.compile(r'"(?:[^"\\]|\\.)*"|[{}\[\],:]|[^\s{}\[\],:"]+', re.DOTALL)


class _NeedsLine(Exception):
    """Something strict JSON forbids was met where the fast parser knows no line."""


def parse_json(text: str, file: str | None = None) -> Document:
    """Return the document of a JSON text.

    Raises
    ------
    SceneError
        Not a mapping, not strict JSON (NaN and Infinity are not), a key given twice, too deep.
    """
    start = _BLANK.match(text)
    at = start.end() if start else 0
    if other := _OTHERS.get(text[at : at + 1]):  # before anything is built from it: it may be very long
        raise SceneError(not_a_mapping(other), file, text.count("\n", 0, at) + 1)
    try:
        data = _strict(text, file)
    except json.JSONDecodeError as error:
        raise SceneError(f"not valid JSON: {error.msg}", file, error.lineno) from None
    except RecursionError:
        raise SceneError("nested too deep: this is not a scene or plan", file) from None

    @cache
    def located() -> Document | None:
        return _located(text, file) if len(text) <= _LOCATED else None

    def line_of(place: Place) -> int | None:
        document = located()
        return None if document is None else document.line_of(place)

    return Document(data, line_of, file)


def _strict(text: str, file: str | None) -> Any:
    try:
        return json.loads(text, object_pairs_hook=_unique, parse_constant=_constant, parse_int=_int)
    except _NeedsLine as error:
        if len(text) <= _LOCATED:
            json.loads(text, parse_int=_int)  # JSON that breaks off further on is told as such
            _located(text, file)
        raise SceneError(str(error), file) from None


def _located(text: str, file: str | None) -> Document | None:
    """Read valid JSON again for its lines only; raise where a key is doubled or a number is none."""
    newlines = [match.start() for match in re.finditer("\n", text)]
    builder = DocumentBuilder(file)
    for token in _TOKEN.finditer(text):
        word, line = token[0], bisect_right(newlines, token.start()) + 1
        if word in "{[":
            builder.open({} if word == "{" else [], line)
        elif word in "}]":
            builder.close()
        elif word in ",:":
            continue
        elif builder.expects_key():
            builder.key(json.loads(word), line)
        elif word in ("NaN", "Infinity", "-Infinity"):
            raise SceneError(f"{word} is not a number that JSON allows; give a finite number", file, line)
        else:
            builder.scalar(None, line)
    return builder.document()


def _unique(pairs: list[tuple[str, Any]]) -> dict[str, Any]:
    if len(pairs) > MAX_KEYS:
        raise _NeedsLine(CROWDED)
    out = dict(pairs)
    if len(out) < len(pairs):
        times = Counter(key for key, _ in pairs)
        raise _NeedsLine(doubled(next(key for key, count in times.items() if count > 1)))
    return out


def _constant(word: str) -> Any:
    raise _NeedsLine(f"{word} is not a number that JSON allows")


def _int(digits: str) -> int | float:
    # no int of more digits than a double can hold: Python is slow with them, and then refuses them
    return int(digits) if len(digits) < 400 else float(digits)


def layout(data: Mapping[str, Any]) -> str:
    """Return JSON text with one key, obstacle, robot or feature a line.

    Raises
    ------
    ValueError
        A number that is not finite.
    """
    return _object(data, "") + "\n"


def _object(data: Mapping[str, Any], indent: str) -> str:
    items = []
    for key, value in data.items():
        if key == "scene" and isinstance(value, Mapping):
            text = _object(value, indent + "  ")
        elif isinstance(value, list) and value and isinstance(value[0], Mapping):
            inner = ",\n".join(f"{indent}    {_dump(item)}" for item in value)
            text = f"[\n{inner}\n{indent}  ]"
        else:
            text = _dump(value)
        items.append(f"{indent}  {_dump(key)}: {text}")
    return "{\n" + ",\n".join(items) + f"\n{indent}}}"


def _dump(value: Any) -> str:
    return json.dumps(value, ensure_ascii=False, allow_nan=False)
