"""How CA and OCA come to their routes, as small multiples: the steps of the one, the rounds of the other."""

from __future__ import annotations

import math
import os
from collections.abc import Callable, Mapping, Sequence
from pathlib import Path
from typing import Any

import matplotlib as mpl
import numpy as np
from matplotlib.axes import Axes
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.patches import Patch

from taut.figures.canvas import View
from taut.figures.central import (
    HIT,
    STEPS,
    UNUSED,
    Step,
    draw_bands,
    draw_steps,
    draw_two_ends,
    handles_of,
    name_tinted,
    tint_obstacles,
)
from taut.figures.maps import draw_map, scene_view
from taut.figures.pictures import count
from taut.figures.plans import draw_arrows, draw_paths
from taut.figures.saving import NO_STAMPS, any_letters, check_kind
from taut.figures.style import (
    GROWN,
    INK,
    OBSTACLE,
    OBSTACLE_EDGE,
    OUTSIDE,
    QUIET,
    START,
    mix,
    robot_colours,
)
from taut.route.central import CentralRoute
from taut.route.oca import OcaRoute
from taut.scene import Scene
from taut.writing import replacing

WIDTH = 12.5  # inches of a figure with two columns or more
HEAD, FOOT, TITLE, BETWEEN, SIDE = 0.48, 0.42, 0.3, 0.16, 0.14  # inches

_TITLES: Mapping[Step, str] = {
    "baseline": "Baselines, and where they enter and leave",
    "waypoints": "Waypoints beside them",
    "graph": "Partial visibility graphs",
    "path": "Shortest paths in them",
}


def draw_central_steps(scene: Scene, routes: Mapping[str, CentralRoute]) -> Figure:
    """Draw the four steps of CA: baselines, waypoints, partial visibility graphs, paths.

    Parameters
    ----------
    scene : the world.
    routes : by the name of the robot.

    Raises
    ------
    OutputError
        Coordinates with which no picture can be made.
    """
    crossed = {obstacle.name for route in routes.values() for obstacle in route.crossed}
    waypoints = sum(len(route.waypoints) for route in routes.values())
    dropped = sum(len(route.dropped) for route in routes.values())
    hit = [name for name, route in routes.items() if not route.free]
    facts: Mapping[Step, str] = {
        "baseline": f"{len(crossed)} of {count(len(scene.obstacles), 'obstacle')} crossed",
        "waypoints": count(waypoints, "waypoint") + (f", {dropped} dropped" if dropped else ""),
        "graph": count(sum(route.roadmap.graph.m for route in routes.values()), "edge"),
        "path": f"{', '.join(hit)} {'hit' if len(hit) > 1 else 'hits'} an obstacle" if hit else "all free",
    }
    figure, panels = _panels(scene_view(scene), len(STEPS), "The Central Algorithm", scene.name)
    for number, (step, axes) in enumerate(zip(STEPS, panels, strict=True), 1):
        draw_steps(axes, scene, routes, step)
        _caption(axes, f"{number}. {_TITLES[step]}", facts[step])
    _foot(figure, handles_of(list(routes.values()), "path"))
    return figure


def draw_rounds(scene: Scene, route: OcaRoute) -> Figure:
    """Draw the rounds in which OCA finds one route: obstacles known, the route among them, and those that it hits.

    Raises
    ------
    OutputError
        Coordinates with which no picture can be made.
    """
    known: set[str] = set()
    facts = f"{len(route.used)} of {count(route.total, 'obstacle')} used"
    figure, panels = _panels(scene_view(scene), len(route.rounds), "The rounds of OCA", f"{scene.name} · {facts}")
    for number, (step, axes) in enumerate(zip(route.rounds, panels, strict=True), 1):
        known |= set(step.added)
        draw_map(axes, scene)
        tint_obstacles(axes, [_tint(o.name, known, step.hit) for o in scene.obstacles])
        fine = step.arc_error == route.freespace.arc_error
        # arcs drawn coarsely reach no farther than those drawn finely
        reach = route.growth if fine else route.growth / (1 + step.arc_error)
        draw_bands(axes, scene, {reach: known}, step.arc_error)
        name_tinted(axes, scene, {o.name for o in scene.obstacles} - known - set(step.hit))
        baseline = route.points[[0, -1]]
        axes.plot(*baseline.T, color=START, linewidth=1.0, linestyle=(0, (6, 3)), zorder=3.1)
        draw_paths(axes, [step.points], [robot_colours(1)[0]], 1.8)
        draw_arrows(axes, [step.points], [robot_colours(1)[0]])
        draw_two_ends(axes, route)
        length = float(np.hypot(*np.diff(step.points, axis=0).T).sum())
        told = f"hits {_listed(step.hit)}" if step.hit else "hits nothing"
        _caption(
            axes,
            f"{number}. {count(len(known), 'obstacle')}{'' if fine else ', coarse arcs'}",
            f"{length:.2f} m, {told}",
        )
    handles: list[Line2D | Patch] = [
        Line2D([], [], color=START, linewidth=1.0, linestyle=(0, (6, 3)), label="baseline"),
        Patch(facecolor=OBSTACLE, edgecolor=OBSTACLE_EDGE, label="obstacle known"),
        Patch(facecolor=mix(HIT, "#ffffff", 0.45), label="hit, so taken in next"),
        Patch(facecolor=UNUSED, label="left out"),
    ]
    if route.growth > 0:
        handles.append(Patch(facecolor=GROWN, edgecolor=OBSTACLE_EDGE, label=f"grown by {route.growth:g} m"))
    _foot(figure, handles)
    return figure


def save_central_steps(scene: Scene, routes: Mapping[str, CentralRoute], path: str | os.PathLike[str]) -> None:
    """Draw as `draw_central_steps` into a .png (200 dpi), .svg or .pdf file; the same routes give the same bytes.

    Raises
    ------
    OutputError
        Another extension, a place that cannot be written, coordinates with which no picture can be made.
    """
    _save(lambda: draw_central_steps(scene, routes), path)


def save_rounds(scene: Scene, route: OcaRoute, path: str | os.PathLike[str]) -> None:
    """Draw as `draw_rounds` into a file, else as `save_central_steps`."""
    _save(lambda: draw_rounds(scene, route), path)


def _save(drawn: Callable[[], Figure], path: str | os.PathLike[str]) -> None:
    target = Path(path)
    kind = check_kind(target, tuple(NO_STAMPS), "pictures are written as")
    fonts: Any = {"svg.hashsalt": "taut", "svg.fonttype": "path", "pdf.fonttype": 42}
    with replacing(target) as scratch, any_letters(), mpl.rc_context(fonts):
        drawn().savefig(scratch, format=kind, dpi=200, metadata=NO_STAMPS[kind])


def _tint(name: str, known: set[str], hit: Sequence[str]) -> str:
    return OBSTACLE if name in known else mix(HIT, "#ffffff", 0.45) if name in hit else UNUSED


def _listed(names: Sequence[str]) -> str:
    return ", ".join(names) if len(names) <= 3 else count(len(names), "obstacle")


def _panels(view: View, n: int, name: str, facts: str) -> tuple[Figure, list[Axes]]:
    """Return a figure with its heading and n empty maps, as many columns as suit a slide."""
    aspect = float(np.clip(view.width / view.height, 0.25, 4.0))
    columns = n if n <= 3 else math.ceil(n / 2) if n <= 6 else math.ceil(math.sqrt(1.6 * n))
    rows = math.ceil(n / columns)
    across = min((WIDTH - 2 * SIDE - (columns - 1) * BETWEEN) / columns, 6.5 * aspect)
    down = across / aspect
    wide = 2 * SIDE + columns * across + (columns - 1) * BETWEEN
    high = HEAD + rows * (TITLE + down) + (rows - 1) * BETWEEN + FOOT
    figure = Figure(figsize=(wide, high), facecolor="white")
    FigureCanvasAgg(figure)
    up = 1 - 0.28 / high
    figure.text(SIDE / wide, up, name, fontsize=12.5, fontweight="bold", color=INK, parse_math=False)
    figure.text(1 - SIDE / wide, up, facts, fontsize=9.5, color=QUIET, ha="right", parse_math=False)
    panels = []
    for k in range(n):
        row, column = divmod(k, columns)
        bottom = high - HEAD - (row + 1) * (TITLE + down) - row * BETWEEN
        left = SIDE + column * (across + BETWEEN)
        axes = figure.add_axes((left / wide, bottom / high, across / wide, down / high))
        axes.set(xlim=(view.x0, view.x1), ylim=(view.y0, view.y1), xticks=[], yticks=[], facecolor=OUTSIDE)
        axes.set_aspect("equal")
        axes.apply_aspect()
        for spine in axes.spines.values():
            spine.set(linewidth=0.6, color=QUIET)
        panels.append(axes)
    return figure, panels


def _caption(axes: Axes, text: str, facts: str) -> None:
    axes.set_title(text, loc="left", fontsize=9.5, fontweight="bold", color=INK, pad=4)
    axes.set_title(facts, loc="right", fontsize=8.5, color=QUIET, pad=4, parse_math=False)


def _foot(figure: Figure, handles: Sequence[Line2D | Patch]) -> None:
    figure.legend(
        handles=list(handles),
        loc="lower center",
        bbox_to_anchor=(0.5, 0.03 / figure.get_figheight()),
        ncols=len(handles),
        frameon=False,
        fontsize=9,
        handletextpad=0.5,
        columnspacing=1.8,
        labelcolor=INK,
    )
