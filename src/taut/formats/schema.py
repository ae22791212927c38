"""The one schema of scene and plan files (pydantic) and its JSON Schema."""

from __future__ import annotations

from typing import Annotated, Any, Literal

from pydantic import BaseModel, BeforeValidator, ConfigDict, Discriminator, Field, Tag, model_validator
from pydantic_core import PydanticCustomError

SHAPES = ("polygon", "circle", "rectangle", "line")


def _version(value: object) -> object:
    if type(value) is not int or value != 1:
        raise PydanticCustomError("version", "must be 1, the version of this format")
    return value


def _count(value: object) -> object:
    if type(value) is not int or value < 1:
        raise PydanticCustomError("count", "must be a whole number of at least 1")
    return value


def _flag(value: object) -> object:
    if type(value) is not bool:
        raise PydanticCustomError("flag", "must be true or false")
    return value


Version = Annotated[Literal[1], BeforeValidator(_version)]
Text = Annotated[str, Field(strict=True)]
Name = Annotated[str, Field(strict=True, min_length=1)]
Number = Annotated[float, Field(strict=True, allow_inf_nan=False)]
Positive = Annotated[float, Field(strict=True, allow_inf_nan=False, gt=0)]
NotNegative = Annotated[float, Field(strict=True, allow_inf_nan=False, ge=0)]
Count = Annotated[int, BeforeValidator(_count)]
Flag = Annotated[bool, BeforeValidator(_flag)]
Point = Annotated[list[Number], Field(fail_fast=True, min_length=2, max_length=2, description="[x, y], metres")]
Stamp = Annotated[
    list[Number], Field(fail_fast=True, min_length=3, max_length=3, description="[t, x, y], seconds and metres")
]
AtGoal = Literal["stay", "leave"]


# Lists fail fast: each wrong item costs a report, and a file may hold millions; the first one tells enough.
class _Strict(BaseModel):
    model_config = ConfigDict(extra="forbid")


class PolygonEntry(_Strict):
    """A simple polygon, corners in either direction, not closed by repetition."""

    name: Name | None = None
    polygon: Annotated[list[Point], Field(min_length=3, fail_fast=True)]


class CircleEntry(_Strict):
    """A disc."""

    name: Name | None = None
    circle: Annotated[Point, Field(description="the centre [x, y], metres")]
    radius: Positive


class RectangleEntry(_Strict):
    """A rectangle, turned about its centre."""

    name: Name | None = None
    rectangle: Annotated[
        list[Number],
        Field(fail_fast=True, min_length=4, max_length=4, description="[x, y, width, height], metres, before turning"),
    ]
    angle: Annotated[Number, Field(description="radians about the centre, counter-clockwise")] = 0.0


class LineEntry(_Strict):
    """A wall: every point within width / 2 of a polyline."""

    name: Name | None = None
    line: Annotated[list[Point], Field(min_length=2, fail_fast=True)]
    width: Positive


def _shape(value: Any) -> str | None:
    given = [shape for shape in SHAPES if shape in value] if isinstance(value, dict) else []
    return given[0] if len(given) == 1 else None


ObstacleEntry = Annotated[
    Annotated[PolygonEntry, Tag("polygon")]
    | Annotated[CircleEntry, Tag("circle")]
    | Annotated[RectangleEntry, Tag("rectangle")]
    | Annotated[LineEntry, Tag("line")],
    Discriminator(_shape),
]


class RobotEntry(_Strict):
    """A closed disc that moves in any direction at its top speed, or rests."""

    name: Name
    start: Point
    goal: Point
    radius: Annotated[NotNegative, Field(description="metres")] = 0.0
    speed: Annotated[Positive, Field(description="metres a second")] = 1.0
    clearance: Annotated[
        NotNegative | None, Field(description="metres kept free from obstacles and wall; default: the scene's")
    ] = None
    start_time: Annotated[NotNegative, Field(description="seconds; it may leave its start from then")] = 0.0
    at_goal: Annotated[AtGoal | None, Field(description="default: the scene's")] = None


class SceneFile(_Strict):
    """A map and a team."""

    model_config = ConfigDict(
        extra="forbid",
        title="taut scene",
        json_schema_extra={"oneOf": [{"required": ["workspace"]}, {"required": ["bounds"]}]},
    )

    taut: Annotated[Version, Field(description="the version of this format")]
    name: Text = ""
    workspace: (
        Annotated[list[Point], Field(min_length=3, fail_fast=True, description="corners of a simple polygon")] | None
    ) = None
    bounds: (
        Annotated[
            list[Number],
            Field(fail_fast=True, min_length=4, max_length=4, description="[xmin, ymin, xmax, ymax], metres"),
        ]
        | None
    ) = None
    clearance: Annotated[
        NotNegative, Field(description="metres kept free between every robot and every obstacle or wall")
    ] = 0.0
    gap: Annotated[NotNegative, Field(description="metres kept free between robots, beyond their radii")] = 0.0
    headway: Annotated[NotNegative, Field(description="seconds by which the separation also holds between times")] = 0.0
    at_goal: AtGoal = "stay"
    obstacles: Annotated[list[ObstacleEntry], Field(fail_fast=True)] = []
    robots: Annotated[list[RobotEntry], Field(fail_fast=True)]

    @model_validator(mode="after")
    def _one_outline(self) -> SceneFile:
        if self.workspace is None and self.bounds is None:
            raise PydanticCustomError("outline", "no workspace: add `workspace:` (corners) or `bounds:`")
        if self.workspace is not None and self.bounds is not None:
            raise PydanticCustomError("outline", "both `workspace` and `bounds` are given; keep one")
        return self


class TrajectoryEntry(_Strict):
    """The motion of one robot."""

    name: Name
    stamps: Annotated[list[Stamp], Field(min_length=1, fail_fast=True)]


class ContactEntry(_Strict):
    """The claim that the team's communication graph is connected at every instant, or more."""

    range: Annotated[Positive, Field(description="metres within which two robots are in contact")]
    sight: Annotated[Flag, Field(description="whether obstacles break contact")] = False
    k: Annotated[Count, Field(description="it stays connected when any k − 1 robots fail")] = 1
    lambda2: Annotated[NotNegative, Field(description="least Fiedler value, links weighing 1")] = 0.0


class ClaimsEntry(BaseModel):
    """What the certificate has to prove beyond the scene; claims that are not known here are for it to refuse."""

    model_config = ConfigDict(extra="allow")

    contact: ContactEntry | None = None


class PlanFile(_Strict):
    """A timed motion for every robot of a scene."""

    taut: Version
    kind: Literal["plan"]
    scene: SceneFile
    planner: dict[str, Any] | None = None
    claims: ClaimsEntry | None = None
    robots: Annotated[list[TrajectoryEntry], Field(fail_fast=True)]
    metrics: dict[str, Any] | None = None
    certificate: dict[str, Any] | None = None


def scene_schema() -> dict[str, Any]:
    """Return the JSON Schema (draft 2020-12) of scene files, YAML and JSON alike."""
    return {"$schema": "https://json-schema.org/draft/2020-12/schema", **SceneFile.model_json_schema()}
