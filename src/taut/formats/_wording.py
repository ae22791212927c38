"""What pydantic found wrong, said in one line about a robot or obstacle."""

from __future__ import annotations

import difflib
from typing import Any

from pydantic import BaseModel, ValidationError

from taut.errors import SceneError, one_line
from taut.formats import schema
from taut.formats._document import Document, Place, shown

_ENTRIES: dict[str, type[BaseModel]] = {
    "polygon": schema.PolygonEntry,
    "circle": schema.CircleEntry,
    "rectangle": schema.RectangleEntry,
    "line": schema.LineEntry,
}
_LENGTHS = {
    "bounds": "four numbers [xmin, ymin, xmax, ymax]",
    "rectangle": "four numbers [x, y, width, height]",
    "start": "a point [x, y]",
    "goal": "a point [x, y]",
    "circle": "a point [x, y]",
}
_LISTS = {"workspace": "corner", "polygon": "corner", "line": "point", "stamps": "stamp"}


def fault(document: Document, error: ValidationError) -> SceneError:
    """Return the SceneError for the fault a person should mend first: unknown keys, then by line."""
    found = error.errors(include_url=False)
    typing_errors = [e for e in found if e["type"] == "extra_forbidden"]
    ranked = [(_place(e["loc"]), e) for e in (typing_errors or found)[:100]]
    place, first = min(ranked, key=lambda entry: document.line_of(entry[0]) or 0)
    return document.error(_message(document.data, place, first, error.title), place)


def subject(data: Any, place: Place) -> tuple[str, Place]:
    """Return what a place belongs to ("robot R1: ", "obstacle number 3: ", "") and the rest of the place."""
    before = ""
    if place[:1] == ("scene",) and len(place) > 1 and isinstance(data, dict):
        before, data, place = "scene: ", data.get("scene"), place[1:]
    if len(place) < 2 or place[0] not in ("robots", "obstacles") or not isinstance(place[1], int):
        return before, place
    word = str(place[0])[:-1]
    try:
        name = data[place[0]][place[1]]["name"]
    except (KeyError, IndexError, TypeError):
        name = None
    known = isinstance(name, str) and name
    return f"{before}{word} {shorten(name) if known else f'number {place[1] + 1}'}: ", place[2:]


def shorten(name: str) -> str:
    """Return a name fit for a one-line message."""
    return one_line(name if len(name) <= 60 else name[:57] + "…")


def _place(loc: tuple[int | str, ...]) -> Place:
    """Drop the tags of the obstacle shapes, which pydantic puts into the place."""
    out: list[int | str] = []
    for k, step in enumerate(loc):
        tag = k >= 2 and isinstance(loc[k - 1], int) and loc[k - 2] == "obstacles" and step in schema.SHAPES
        if not tag:
            out.append(step)
    return tuple(out)


def _message(data: Any, place: Place, error: Any, title: str) -> str:
    who, rest = subject(data, place)
    kind, value, context = error["type"], error["input"], error.get("ctx", {})
    field = str(rest[-1]) if rest else ""
    if kind in ("extra_forbidden", "invalid_key"):
        return f"{who}unknown key `{shown(field)[1:-1]}`{_meant(data, place, title)}"
    if kind == "missing":
        return who + _missing(field, rest)
    if kind == "union_tag_not_found":
        return who + _shapeless(value)
    if kind == "outline":
        return who + str(error["msg"])
    where = f"{_where(rest)} " if rest else ""
    return f"{who}{where}{_expected(kind, field, rest, value, context, error['msg'])}"


def _missing(field: str, rest: Place) -> str:
    if rest == ("robots",):
        return "no robots: add `robots:` (`robots: []` for a map without any)"
    if rest == ("taut",):
        return "no version: add `taut: 1`"
    return f"`{field}` is missing; add it"


def _shapeless(value: Any) -> str:
    if not isinstance(value, dict):
        return f"must be a mapping such as {{name: O1, circle: [1, 2], radius: 0.5}}, got {shown(value)}"
    given = [shape for shape in schema.SHAPES if shape in value]
    if given:
        return f"has {len(given)} shapes ({', '.join(given)}); keep one"
    return f"no shape; give one of {', '.join(schema.SHAPES)}"


def _where(rest: Place) -> str:
    """Return the field in words: "polygon: corner 2", "start"."""
    words = []
    for k, step in enumerate(rest):
        if isinstance(step, str):
            words.append(step)
        elif k and (item := _LISTS.get(str(rest[k - 1]))):
            words.append(f"{item} {step + 1}")
    return ": ".join(words)


def _expected(kind: str, field: str, rest: Place, value: Any, context: Any, message: str) -> str:
    got = f"got {shown(value)}"
    if kind == "float_type":
        if isinstance(value, int) and not isinstance(value, bool):
            return f"must be a finite number, {got}"
        mend = "; remove the quotes" if isinstance(value, str) and _is_number(value) else ""
        return f"must be a number, {got}{mend}"
    if kind == "finite_number":
        return f"must be a finite number, {got}"
    if kind == "greater_than":
        return f"must be positive, {got}"
    if kind == "greater_than_equal":
        return f"must not be negative, {got}"
    if kind == "literal_error":
        return f"must be {context['expected'].replace(chr(39), chr(34))}, {got}"
    if kind == "string_type":
        return f"must be text, {got}" + ("; put it in quotes" if isinstance(value, int | float) else "")
    if kind == "string_unicode":
        return "must not hold half of a surrogate pair; it is no character"
    if kind == "string_too_short":
        return "must not be empty"
    if kind in ("too_short", "too_long"):
        return f"must be {_length(field, rest, context)}, got {context['actual_length']} of them"
    if kind == "list_type":
        return f"must be {'a list' if field in _LISTS else _LENGTHS.get(field) or _item(rest)}, {got}"
    if kind in ("model_type", "dict_type", "model_attributes_type"):
        return f"must be a mapping of keys to values, {got}"
    return f"{message[:1].lower()}{message[1:]}, {got}"


def _length(field: str, rest: Place, context: Any) -> str:
    if field in _LISTS:
        return f"a list of at least {context['min_length']} {_LISTS[field]}{'s' if context['min_length'] > 1 else ''}"
    return _LENGTHS.get(field) or _item(rest)


def _item(rest: Place) -> str:
    if len(rest) > 1 and rest[-2] == "stamps":
        return "a stamp [t, x, y]"
    if len(rest) > 1 and rest[-2] in _LISTS:
        return "a point [x, y]"
    return "a list"


def _is_number(text: str) -> bool:
    try:
        float(text)
    except ValueError:
        return False
    return True


def _meant(data: Any, place: Place, title: str) -> str:
    known = list(_model(data, place, title).model_fields)
    close = difflib.get_close_matches(str(place[-1])[:100], known, 1)
    return f"; did you mean `{close[0]}`?" if close else f"; known are {', '.join(known)}"


def _model(data: Any, place: Place, title: str) -> type[BaseModel]:
    inner = place[:1] == ("scene",)
    steps = place[1:] if inner else place
    is_plan = title == schema.PlanFile.__name__ and not inner
    if steps[0] == "obstacles" and len(steps) > 2:
        entry = (data["scene"] if inner else data)["obstacles"][steps[1]]
        return next(model for shape, model in _ENTRIES.items() if shape in entry)
    if steps[:2] == ("claims", "contact") and len(steps) > 2:
        return schema.ContactEntry
    if steps[0] == "robots" and len(steps) > 2:
        return schema.TrajectoryEntry if is_plan else schema.RobotEntry
    return schema.PlanFile if is_plan else schema.SceneFile
