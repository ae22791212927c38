"""Scenes as YAML text: read by the YAML 1.2 core schema, written with one obstacle or robot a line."""

from __future__ import annotations

import re
from collections.abc import Mapping
from typing import Any

import yaml

from taut.errors import SceneError
from taut.formats._document import Document, DocumentBuilder, not_a_mapping, shown

LIMIT = 8 << 20

_LOADER: Any = getattr(yaml, "CSafeLoader", yaml.SafeLoader)
_FORBIDDEN = re.compile("[^\t\n\r\x20-\x7e\x85\xa0-\ud7ff\ue000-\ufffd\U00010000-\U0010ffff]")
_INT = re.compile(r"[-+]?[0-9]+")
_OCTAL = re.compile(r"0o[0-7]+")
_HEX = re.compile(r"0x[0-9a-fA-F]+")
_FLOAT = re.compile(r"[-+]?(\.[0-9]+|[0-9]+(\.[0-9]*)?)([eE][-+]?[0-9]+)?")
_INFINITE = re.compile(r"([-+]?)\.(inf|Inf|INF)")
_WORDS = {
    **dict.fromkeys(("", "~", "null", "Null", "NULL"), None),
    **dict.fromkeys(("true", "True", "TRUE"), True),
    **dict.fromkeys(("false", "False", "FALSE"), False),
    **dict.fromkeys((".nan", ".NaN", ".NAN"), float("nan")),
}
_PLAIN = re.compile(r"[A-Za-z_][A-Za-z0-9_-]*")
# words that a reader of some YAML version takes for something else than text
_QUOTED = {"null", "true", "false", "yes", "no", "on", "off", "y", "n"}


def parse_yaml(text: str, file: str | None = None) -> Document:
    """Return the one document of a YAML text.

    Raises
    ------
    SceneError
        Not YAML, empty, several documents, a key given twice or not text, an anchor, alias or tag, too deep.
    """
    if bad := _FORBIDDEN.search(text):
        raise SceneError(
            f"holds the character U+{ord(bad[0]):04X}, which YAML does not allow; write it as an escape",
            file,
            text.count("\n", 0, bad.start()) + 1,
        )
    try:
        document = _document(text, file)
    except yaml.MarkedYAMLError as error:
        mark = error.problem_mark or error.context_mark
        problem = error.problem or error.context or "cannot be read"
        raise SceneError(f"not valid YAML: {problem}", file, mark.line + 1 if mark else None) from None
    except yaml.YAMLError as error:
        raise SceneError(f"not valid YAML: {error}"[:200], file) from None
    if document is None or document.data is None:
        raise SceneError("is empty", file)
    return document


def _document(text: str, file: str | None) -> Document | None:
    builder = DocumentBuilder(file)
    documents = 0
    begun = False
    for event in yaml.parse(text, Loader=_LOADER):
        line = event.start_mark.line + 1 if event.start_mark else 0
        if isinstance(event, yaml.NodeEvent):
            if event.anchor is not None:
                raise SceneError("anchors and aliases (& and *) are not used here; write the value out", file, line)
            if (tag := getattr(event, "tag", None)) is not None:
                raise SceneError(f"tags are not used here; remove {shown(tag)}", file, line)
            if not begun and not isinstance(event, yaml.MappingStartEvent):
                value = event.value if isinstance(event, yaml.ScalarEvent) else None
                if value == "":
                    raise SceneError("is empty", file)
                # before anything is built from it: it may be very long
                raise SceneError(not_a_mapping("a list" if value is None else shown(value)), file, line)
            begun = True
            if builder.expects_key():
                if not isinstance(event, yaml.ScalarEvent):
                    raise SceneError("a key must be a word, not a list or mapping", file, line)
                builder.key(event.value, line)
            elif isinstance(event, yaml.ScalarEvent):
                builder.scalar(resolve(event.value) if event.style in (None, "") else event.value, line)
            else:
                builder.open({} if isinstance(event, yaml.MappingStartEvent) else [], line)
        elif isinstance(event, yaml.CollectionEndEvent):
            builder.close()
        elif isinstance(event, yaml.DocumentStartEvent):
            documents += 1
            if documents > 1:
                raise SceneError("holds several documents (---); keep one", file, line)
    return builder.document()


def resolve(text: str) -> str | int | float | bool | None:
    """Return what a plain scalar means by the YAML 1.2 core schema.

    >>> resolve("1e-09"), resolve("0o17"), resolve("yes"), resolve("1_000")
    (1e-09, 15, 'yes', '1_000')
    """
    if text in _WORDS:
        return _WORDS[text]
    if _INT.fullmatch(text):
        # no int of more digits than a double can hold: Python is slow with them, and then refuses them
        return int(text) if len(text) < 400 else float(text)
    if _FLOAT.fullmatch(text):
        return float(text)
    if _OCTAL.fullmatch(text):
        return int(text[2:], 8)
    if _HEX.fullmatch(text):
        return int(text[2:], 16)
    if infinite := _INFINITE.fullmatch(text):
        return float(infinite[1] + "inf")
    return text


def scene_yaml(data: Mapping[str, Any]) -> str:
    """Return the YAML text of a scene given as `scene_to_dict` gives it."""
    lines = []
    for key, value in data.items():
        if isinstance(value, list) and value and isinstance(value[0], Mapping):
            lines.append(f"{key}:")
            lines += [f"  - {_flow(item)}" for item in value]
        else:
            lines.append(f"{key}: {_flow(value)}")
    return "\n".join(lines) + "\n"


def _flow(value: Any) -> str:
    if isinstance(value, str):
        return value if _PLAIN.fullmatch(value) and value.lower() not in _QUOTED else _quoted(value)
    if isinstance(value, Mapping):
        return "{" + ", ".join(f"{key}: {_flow(item)}" for key, item in value.items()) + "}"
    if isinstance(value, list):
        return "[" + ", ".join(map(_flow, value)) + "]"
    return repr(value)


def _quoted(text: str) -> str:
    out = []
    for c in text:
        if c in '"\\':
            out.append("\\" + c)
        elif c.isprintable() or 0xD800 <= ord(c) <= 0xDFFF:  # half a pair: refused by the writer, with a message
            out.append(c)
        else:
            out.append(
                f"\\x{ord(c):02x}" if ord(c) < 0x100 else f"\\u{ord(c):04x}" if ord(c) < 0x10000 else f"\\U{ord(c):08x}"
            )
    return '"' + "".join(out) + '"'
