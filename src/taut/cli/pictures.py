"""Figures and animations that commands write beside their results."""

from __future__ import annotations

import shutil
from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING

import typer

from taut.cli.output import progress, require_writable
from taut.errors import OutputError

if TYPE_CHECKING:
    from taut.contact import Contact
    from taut.motion import Plan
    from taut.roadmap import Roadmap
    from taut.scene import Scene
    from taut.team.stages import Stage

FIGURES = (".png", ".pdf", ".svg")
ANIMATIONS = (".gif", ".mp4")


def require_pictures(figure: Path | None, animation: Path | None, with_graph: bool, never: Path) -> None:
    """Raise now if a picture could not be written later.

    Raises
    ------
    OutputError
        See `require_writable`; or an .mp4 is wanted and ffmpeg is not there.
    """
    require_writable(figure, "a figure", FIGURES, never)
    require_writable(animation, "an animation", ANIMATIONS, never)
    if animation is not None and animation.suffix.lower() == ".mp4" and shutil.which("ffmpeg") is None:
        raise OutputError(f"{animation}: .mp4 needs ffmpeg, which was not found; install it or write a .gif")
    if with_graph and figure is None:
        raise typer.BadParameter("draws under a figure: give --figure FILE too", param_hint="--graph")


def write_pictures(
    value: Scene | Plan,
    figure: Path | None,
    animation: Path | None,
    with_graph: bool,
    contact: Contact | None = None,
) -> list[str]:
    """Draw what is wanted; return the names of the files written."""
    from taut.motion import Plan

    written = []
    if figure is not None:
        from taut.figures import save_figure

        scene = value.scene if isinstance(value, Plan) else value
        with progress(f"drawing {figure}"):
            save_figure(value, figure, graph=_roadmap_under(scene) if with_graph else None, contact=contact)
        written.append(str(figure))
    if animation is not None and isinstance(value, Plan):
        from taut.figures import animate

        with progress(f"drawing {animation}"):
            animate(value, animation, contact=contact)
        written.append(str(animation))
    return written


def write_stages(stages: Sequence[Stage], folder: Path) -> str:
    """Draw and write every stage into a folder; return the name of the index of what was written."""
    from taut.figures import save_stages

    with progress(f"drawing {len(stages)} stages"):
        return str(save_stages(stages, folder)[-1])


def _roadmap_under(scene: Scene) -> Roadmap:
    """Build the visibility graph of the thinnest robots, with the starts and goals of all: they are free for it too."""
    from taut.freespace import FreeSpace
    from taut.roadmap import visibility_graph

    growth = min((scene.growth(robot) for robot in scene.robots), default=scene.clearance)
    ends = dict.fromkeys(point for robot in scene.robots for point in (robot.start, robot.goal))
    return visibility_graph(FreeSpace(scene, growth), points=list(ends))
