"""Options and arguments that several commands share."""

from __future__ import annotations

from enum import StrEnum
from pathlib import Path
from typing import Annotated, TypeAlias

import typer

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
