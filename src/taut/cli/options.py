"""Options and arguments that several commands share."""

from __future__ import annotations

from enum import StrEnum
from pathlib import Path
from typing import Annotated, TypeAlias

import typer


class Method(StrEnum):
    """How the team is planned."""

    prioritized = "prioritized"
    mrppa = "mrppa"


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


SceneArgument: TypeAlias = Annotated[
    str, typer.Argument(metavar="SCENE", help="A scene file, or the name of a ready scene.")
]
JsonOption: TypeAlias = Annotated[bool, typer.Option("--json", help="Print the results as one JSON object.")]
FigureOption: TypeAlias = Annotated[
    Path | None, typer.Option("--figure", metavar="FILE", help="Draw a figure (.png, .pdf or .svg).")
]
AnimateOption: TypeAlias = Annotated[
    Path | None, typer.Option("--animate", metavar="FILE", help="Make an animation (.gif; .mp4 needs ffmpeg).")
]
GraphOption: TypeAlias = Annotated[bool, typer.Option("--graph", help="Draw the visibility graph under the figure.")]
