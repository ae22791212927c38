"""Teams that steer themselves in pictures: where vehicles have gone under a law, and how λ2 ran meanwhile."""

from __future__ import annotations

import os
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np
from matplotlib.axes import Axes
from matplotlib.collections import LineCollection
from matplotlib.ticker import MaxNLocator, StrMethodFormatter

from taut.figures.canvas import sheet, show
from taut.figures.courses import COURSE, add_strips, title_strip
from taut.figures.labels import Label, write
from taut.figures.maps import draw_map, name_obstacles, outlines, scene_view
from taut.figures.pictures import handle, line_handle, write_legend, write_title
from taut.figures.plans import in_seconds, line_width, samples
from taut.figures.saving import NO_STAMPS, check_kind, picture_bytes
from taut.figures.simulation import collision_handles, collisions_told, draw_collision_times, draw_collisions
from taut.figures.style import INK, LINK, START, robot_colours
from taut.figures.teams import FEW_ROBOTS, draw_team, mark_radius, start_labels
from taut.graph import Graph
from taut.scene import FloatArray
from taut.writing import replacing

if TYPE_CHECKING:  # a picture of something else does not load the compiled code that simulates
    from taut.control.laws import Links
    from taut.simulation.steering import Steered


def draw_steered(run: Steered, links: Links | None = None, ax: Axes | None = None) -> Axes:
    """Draw a team that steered itself: the ways from the starts, the robots where they ended, and collisions.

    Parameters
    ----------
    run : what `steer` gives.
    links : of the team, as for `taut.control.consensus`: drawn where it ended, and λ2 over time on a strip underneath.
    ax : matplotlib Axes to draw the map on; a new figure with the strip if None.

    Returns
    -------
    matplotlib.axes.Axes
        Of the map.
    """
    view = scene_view(run.scene)
    if ax is None:
        axes = sheet(view)
        _draw_map(axes, run, links)
        if links is not None:
            _draw_connectivity(axes, run, links)
        return axes
    show(ax, view)
    _draw_map(ax, run, links)
    return ax


def save_steered(run: Steered, path: str | os.PathLike[str], links: Links | None = None) -> None:
    """Draw a team that steered itself, see `draw_steered`, into a .png (200 dpi), .svg or .pdf file.

    Raises
    ------
    OutputError
        Another extension, or a place that cannot be written.
    """
    target = Path(path)
    kind = check_kind(target, tuple(NO_STAMPS), "pictures are written as")
    with replacing(target) as scratch:
        scratch.write_bytes(picture_bytes(draw_steered(run, links), kind, 200))


def _draw_map(axes: Axes, run: Steered, links: Links | None) -> None:
    scene, n = run.scene, len(run.names)
    colours = robot_colours(n)
    ends = run.poses[-1, :, :2]
    draw_map(axes, scene)
    name_obstacles(axes, scene)
    if links is not None and n:
        _draw_links(axes, links, ends)
    ways = [run.poses[:, k, :2] for k in range(n)]
    lines = LineCollection(ways, colors=colours, linewidths=0.75 * line_width(n), zorder=6.2)
    lines.set(capstyle="round", joinstyle="round")
    axes.add_collection(lines, autolim=False)
    starts, size = run.poses[0, :, :2], 4 * mark_radius(n) ** 2
    axes.scatter(starts[:, 0], starts[:, 1], s=size, c=START, edgecolors="white", linewidths=0.6, zorder=6.5)
    draw_team(axes, scene.robots, ends, colours)
    _draw_noses(axes, run)
    labels = _labels(axes, run)
    write(axes, labels, [(label.at, label.reach) for label in labels], samples(axes, [*ways, *outlines(scene)]))
    marks = [handle("start", "o", START, "white"), line_handle("driven", INK)]
    write_legend(axes, [*marks, *collision_handles(run.collisions)])
    lasted = in_seconds(run.settled_at if run.settled else run.seconds)
    state = f"settled after {lasted}" if run.settled else f"not settled in {lasted}"
    write_title(axes, scene.name, f"{state} · {collisions_told(run.collisions)}", state)


def _draw_links(axes: Axes, links: Links, places: FloatArray) -> None:
    graph = links if isinstance(links, Graph) else links(places)
    joined = LineCollection(list(places[graph.edges]), colors=LINK, linewidths=0.8, alpha=0.6, zorder=6.0)
    axes.add_collection(joined, autolim=False)


def _draw_noses(axes: Axes, run: Steered) -> None:
    """Draw where each robot looks in the end, from its centre to its rim."""
    ends, headings = run.poses[-1, :, :2], run.poses[-1, :, 2]
    radii = np.array([robot.radius for robot in run.scene.robots], dtype=np.float64)
    ahead = radii[:, None] * np.stack([np.cos(headings), np.sin(headings)], axis=1)
    noses = LineCollection(list(np.stack([ends, ends + ahead], axis=1)), colors="white", linewidths=1.2, zorder=8.2)
    axes.add_collection(noses, autolim=False)


def _labels(axes: Axes, run: Steered) -> list[Label]:
    n = len(run.names)
    # who gathers collides in one place: the names of all would overlap
    labels = draw_collisions(axes, run.collisions, n)[:1]
    if n <= FEW_ROBOTS:
        labels += start_labels(axes, run.scene, list(run.names), robot_colours(n))
    return labels


def _draw_connectivity(axes: Axes, run: Steered, links: Links) -> None:
    from taut.simulation.steering import fiedler_values

    (strip,) = add_strips(axes, [COURSE], run.seconds or 1.0, [])
    values = fiedler_values(run, links)
    strip.set_ylim(0.0, 1.3 * float(values.max(initial=0.0)) or 1.0)
    strip.yaxis.set_major_locator(MaxNLocator(3, steps=[1, 2, 5, 10]))
    strip.yaxis.set_major_formatter(StrMethodFormatter("{x:g}"))
    strip.step(run.times, values, where="post", color=LINK, linewidth=1.4, zorder=3)
    draw_collision_times(strip, run.collisions)
    title_strip(strip, 0.0, "λ2: how well the team holds together", "λ2")
