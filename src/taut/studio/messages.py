"""What a page may ask, checked strictly; what is wrong with a message is told in one sentence."""

from __future__ import annotations

from typing import Annotated, Any, ClassVar, Literal, TypeAlias

import pydantic_core
from pydantic import BaseModel, ConfigDict, Field, TypeAdapter, ValidationError

from taut.errors import one_line

LONGEST = 16 << 20  # bytes of one message
_NAME_LENGTH = 200

Data: TypeAlias = dict[str, Any]
Short = Annotated[str, Field(max_length=_NAME_LENGTH)]
Identity = Annotated[int, Field(ge=0, lt=1 << 53)]
Whole = Annotated[int, Field(ge=0, lt=1 << 53)]
Count = Annotated[int, Field(ge=1, le=1_000_000)]
Metres = Annotated[float, Field(gt=0)]


class _Strict(BaseModel):
    model_config = ConfigDict(strict=True, extra="forbid", allow_inf_nan=False, frozen=True)


class ContactSettings(_Strict):
    """The contact that the team must keep, as plans claim it."""

    range: Metres
    sight: bool = False
    k: Count = 1
    lambda2: Annotated[float, Field(ge=0)] = 0.0


class Settings(_Strict):
    """Parameters of `taut.plan`; None has its default there. What they may be together, planning says."""

    method: Short | None = None
    order: Short | None = None
    roadmap: Short | None = None
    seed: Whole | None = None
    rounds: Count | None = None
    seconds: Annotated[float, Field(gt=0)] | None = None
    objective: Short | None = None
    within: Annotated[float, Field(ge=1)] | None = None
    contact: ContactSettings | None = None

    def given(self) -> Data:
        """Return what is set, as plain data."""
        return self.model_dump(exclude_none=True)


class Ask(_Strict):
    """Something to be done; what is asked later in the same lane takes its place.

    ``heavy`` kinds may take long: of them fewer run at a time than there are workers. ``limit`` is how many seconds
    one may take at most, None for any number.
    """

    heavy: ClassVar[bool] = False
    limit: ClassVar[float | None] = None

    id: Identity
    lane: Annotated[str, Field(min_length=1, max_length=_NAME_LENGTH)] | None = None


class Check(Ask):
    """Ask for all problems of a scene."""

    limit: ClassVar[float | None] = 20.0

    ask: Literal["check"]
    scene: Data


class AboutScene(Ask):
    """An ask about a scene that must be one, if not one that can be planned in."""

    scene: Data


class Plan(AboutScene):
    """Ask for a plan."""

    heavy: ClassVar[bool] = True

    ask: Literal["plan"]
    settings: Settings = Settings()


class Steps(AboutScene):
    """Ask how a method comes to its result."""

    heavy: ClassVar[bool] = True

    ask: Literal["steps"]
    of: Literal["mrppa", "ca", "oca", "dijkstra", "astar"]
    robot: Short | None = None
    settings: Settings = Settings()


class Timelines(AboutScene):
    """Ask what goes on in a plan over time."""

    heavy: ClassVar[bool] = True

    ask: Literal["timelines"]
    plan: Data
    reach: Metres | None = None
    sight: bool = False


class Random(Ask):
    """Ask for a random scene."""

    heavy: ClassVar[bool] = True

    ask: Literal["random"]
    robots: Annotated[int, Field(ge=0, le=1_000)] = 10
    obstacles: Annotated[int, Field(ge=0, le=5_000)] = 20
    seed: Whole = 0
    kind: Literal["open", "warehouse"] = "open"
    size: Metres | None = None


class Ready(Ask):
    """Ask for a ready scene."""

    ask: Literal["ready"]
    name: Short


class Open(Ask):
    """Ask what the text of a file means."""

    ask: Literal["open"]
    text: str
    name: Short = ""


class Text(AboutScene):
    """Ask for a scene as text."""

    ask: Literal["text"]
    format: Literal["yaml", "json"] = "yaml"


class Save(AboutScene):
    """Ask that the file the user named be written.

    ``stamp`` says which state of the file the page knows; None stands for the one that this link was told last.
    """

    ask: Literal["save"]
    stamp: Short | None = None
    overwrite_changed: bool = False
    drop_comments: bool = False


class ExportOptions(_Strict):
    """What an export shows beside the motions: contact within metres, if not broken by obstacles; conflicts (html)."""

    reach: Metres | None = None
    sight: bool = False
    conflicts: list[Data] = Field(default_factory=list)


class Export(AboutScene):
    """Ask for a scene or plan as a file to take away."""

    heavy: ClassVar[bool] = True

    ask: Literal["export"]
    plan: Data | None = None
    form: Literal["plan", "scene-yaml", "scene-json", "png", "svg", "gif", "mp4", "html"]
    options: ExportOptions = ExportOptions()


class Snippet(Ask):
    """Ask for the command line and the Python lines that do the same."""

    ask: Literal["snippet"]
    settings: Settings = Settings()
    name: Short


class Cancel(_Strict):
    """Say that an answer is no longer wanted."""

    cancel: Identity


class Finish(_Strict):
    """Say that the best that was found so far is wanted now."""

    finish: Identity


Asked: TypeAlias = Check | Plan | Steps | Timelines | Random | Ready | Open | Text | Save | Export | Snippet
KINDS = tuple(kind.model_fields["ask"].annotation.__args__[0] for kind in Asked.__args__)

_WORDS: dict[str, type[Cancel | Finish]] = {"cancel": Cancel, "finish": Finish}
_ASKED: TypeAdapter[Asked] = TypeAdapter(Annotated[Asked, Field(discriminator="ask")])


class Malformed(Exception):
    """A message that cannot be understood; ``id`` is that of the ask, if it could be read."""

    def __init__(self, sentence: str, identity: int | None = None) -> None:
        super().__init__(one_line(sentence))
        self.id = identity


def read(text: str | bytes) -> Asked | Cancel | Finish:
    """Return what a message asks.

    Raises
    ------
    Malformed
        It is not JSON, not of a known kind, or a field is missing, unknown or wrong.
    """
    try:
        data = pydantic_core.from_json(text, allow_inf_nan=False)
    except (ValueError, TypeError) as error:  # a TypeError for text with half a surrogate pair
        raise Malformed(f"this message is not JSON: {error}") from None
    if not isinstance(data, dict):
        raise Malformed("a message must be an object with `ask`, `cancel` or `finish`")
    given = data.get("id")
    identity = given if type(given) is int and 0 <= given < 1 << 53 else None
    try:
        for word, kind in _WORDS.items():
            if word in data:
                return kind.model_validate(data)
        return _ASKED.validate_python(data)
    except ValidationError as error:
        raise Malformed(_sentence(error), identity) from None


def _sentence(error: ValidationError) -> str:
    """Say what is wrong in the first place that is."""
    first = error.errors(include_url=False, include_context=True, include_input=False)[0]
    kind = first["type"]
    if kind in ("union_tag_invalid", "union_tag_not_found"):
        asked = first.get("ctx", {}).get("tag")
        got = "a message must say what it asks" if asked is None else f"ask {asked[:40]!r} is unknown"
        return f"{got}; known are {', '.join(KINDS)}"
    place = [str(part)[:40] for part in first["loc"]]
    if place and place[0] in KINDS:
        del place[0]
    where = ".".join(place)
    if kind == "missing":
        return f"`{where}` is missing"
    if kind == "extra_forbidden":
        return f"`{where}` is unknown"
    said = first["msg"]
    verb, _, rest = said.partition(" should ")
    return f"`{where}` must {rest}" if rest else f"`{where}`: {verb}"
