"""Options and arguments that several commands share."""

from __future__ import annotations

import math
from collections.abc import Sequence
from enum import StrEnum
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, TypeAlias

import typer

if TYPE_CHECKING:
    from taut.contact import Contact

ROADMAP_ENDINGS = (".json", ".graphml", ".npz")
"""Of files with lanes; said here again because `taut.formats` is slow to import."""


class Method(StrEnum):
    """How the team is planned."""

    prioritized = "prioritized"
    mrppa = "mrppa"
    search = "search"
    repair = "repair"
    optimal = "optimal"


class Objective(StrEnum):
    """What is to become least."""

    sum_of_costs = "sum_of_costs"
    makespan = "makespan"


class RoadmapName(StrEnum):
    """On what the robots move."""

    visibility = "visibility"
    voronoi = "voronoi"
    grid = "grid"
    prm = "prm"
    lazy_prm = "lazy-prm"
    cells = "cells"
    potential = "potential"
    ca = "ca"
    oca = "oca"


class WeightName(StrEnum):
    """How λ2 weighs an edge."""

    one = "one"
    distance = "distance"


class EdgeKind(StrEnum):
    """Which edges a visibility graph has."""

    all = "all"
    tangent = "tangent"


class Order(StrEnum):
    """Who is planned first."""

    given = "given"
    shortest = "shortest"
    longest = "longest"


def roadmap_source(value: str) -> str:
    """Return the name of a roadmap or of a file that can hold one.

    Raises
    ------
    typer.BadParameter
        It is neither.
    """
    path = Path(value)
    if value in list(RoadmapName) or (path.suffix.lower() in ROADMAP_ENDINGS and path.is_file()):
        return value
    names, endings = ", ".join(RoadmapName), ", ".join(ROADMAP_ENDINGS)
    wrong = "does not exist" if path.suffix.lower() in ROADMAP_ENDINGS else "is no roadmap"
    raise typer.BadParameter(f"{value!r} {wrong}; give one of {names}, or a file ({endings})")


def contact_asked(
    reach: float | None, sight: bool, connected: int | None = None, lambda2: float | None = None
) -> Contact | None:
    """Return the demand that the options of contact make together; None if none of them is given.

    Raises
    ------
    typer.BadParameter
        A number that makes no sense, or an option that needs --contact without it.
    """
    needing = {"--sight": sight, "--connected": connected is not None, "--lambda2": lambda2 is not None}
    for option, given in needing.items():
        if given and reach is None:
            raise typer.BadParameter("belongs to --contact R", param_hint=option)
    if reach is None:
        return None
    if not (math.isfinite(reach) and reach > 0):
        raise typer.BadParameter("must be a positive number of metres", param_hint="--contact")
    if lambda2 is not None and not (math.isfinite(lambda2) and lambda2 >= 0):
        raise typer.BadParameter("must be a number of at least 0", param_hint="--lambda2")
    from taut.contact import Contact

    return Contact(reach, sight, connected or 1, lambda2 or 0.0)


def named_numbers(given: Sequence[str] | None, option: str) -> dict[str, float]:
    """Return the numbers of an option that is given as NAME@NUMBER, by name; a name may hold an @ itself.

    Raises
    ------
    typer.BadParameter
        One that is not of that form.
    """
    out: dict[str, float] = {}
    for text in given or ():
        name, at, number = text.rpartition("@")
        try:
            value = float(number)
        except ValueError:
            value = math.nan
        if not (at and name and math.isfinite(value)):
            raise typer.BadParameter(f"must be a name, @ and a number, like R2@10; got {text!r}", param_hint=option)
        out[name] = value
    return out


SceneArgument: TypeAlias = Annotated[
    str, typer.Argument(metavar="SCENE", help="A scene file, or the name of a ready scene.")
]
RoadmapOption: TypeAlias = Annotated[
    str,
    typer.Option(
        metavar="NAME|FILE",
        callback=roadmap_source,
        help=f"On what the robots move: {', '.join(RoadmapName)}, or a file of lanes ({', '.join(ROADMAP_ENDINGS)}).",
    ),
]
JsonOption: TypeAlias = Annotated[bool, typer.Option("--json", help="Print the results as one JSON object.")]
FigureOption: TypeAlias = Annotated[
    Path | None, typer.Option("--figure", metavar="FILE", help="Draw a figure (.png, .pdf or .svg).")
]
AnimateOption: TypeAlias = Annotated[
    Path | None, typer.Option("--animate", metavar="FILE", help="Make an animation (.gif; .mp4 needs ffmpeg).")
]
GraphOption: TypeAlias = Annotated[bool, typer.Option("--graph", help="Draw the visibility graph under the figure.")]
ContactOption: TypeAlias = Annotated[
    float | None,
    typer.Option("--contact", metavar="R", help="The team stays connected by links between robots within R metres."),
]
SightOption: TypeAlias = Annotated[
    bool, typer.Option("--sight", help="With --contact: obstacles and walls break a link.")
]
ConnectedOption: TypeAlias = Annotated[
    int | None,
    typer.Option(
        "--connected", min=1, max=1_000_000, metavar="K", help="With --contact: also when any K - 1 robots fail."
    ),
]
Lambda2Option: TypeAlias = Annotated[
    float | None, typer.Option("--lambda2", metavar="V", help="With --contact: the Fiedler value λ2 is at least V.")
]
