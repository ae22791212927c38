"""Runs in pictures: what vehicles have made of a plan, and their errors over time."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.collections import LineCollection
from matplotlib.lines import Line2D
from matplotlib.patheffects import withStroke
from matplotlib.ticker import MaxNLocator, StrMethodFormatter

from taut.figures.animation import FEW_NAMES, draw_backdrop
from taut.figures.canvas import sheet, show, size_in_points
from taut.figures.courses import COURSE, NOTE_SIZE, add_strips, title_strip
from taut.figures.labels import Label, text_size, write
from taut.figures.maps import outlines, scene_view
from taut.figures.pictures import count, handle, line_handle, write_title
from taut.figures.plans import in_seconds, line_width, samples
from taut.figures.style import BRIDGE, INK, Colour, darker, mix, robot_colours
from taut.figures.teams import FEW_ROBOTS, draw_team, end_marks, mark_radius, start_labels
from taut.scene import FloatArray

if TYPE_CHECKING:  # a picture of something else does not load the compiled code that simulates
    from taut.simulation.running import Collision, Nearest, Run

COLLISION: Colour = BRIDGE
FEW_COLLISIONS = 12  # up to this many are told with their times
MANY_TIMES = 200  # over the courses no more are drawn
COLUMNS = 1200  # points of a course over time: of more instants the worst of a few is shown


def draw_run(run: Run, ax: Axes | None = None) -> Axes:
    """Draw what became of a plan: planned ways pale, driven ways in full, collisions, and the errors over time.

    A cross stands where two discs, or a disc and an obstacle, began to overlap; a ring where robots came nearest to
    each other or to an obstacle, if nobody collided. Robots that have not arrived are shown where they stand,
    with the reason. On strips under the map: how far each robot strayed from its way, and how late it was.

    Parameters
    ----------
    run : what `simulate` gives.
    ax : matplotlib Axes to draw the map on; a new figure with the strips if None.

    Returns
    -------
    matplotlib.axes.Axes
        Of the map.
    """
    view = scene_view(run.plan.scene)
    if ax is None:
        axes = sheet(view)
        _draw_map(axes, run)
        _draw_errors(axes, run)
        return axes
    show(ax, view)
    _draw_map(ax, run)
    return ax


def nearest_of(run: Run) -> tuple[str, Nearest] | None:
    """Return which robot came nearest to another or to an obstacle, and how; None if nobody came near anything."""
    both = [*zip(run.names, run.clearances, strict=True), *zip(run.names, run.separations, strict=True)]
    near = [(name, nearest) for name, nearest in both if math.isfinite(nearest.distance)]
    return min(near, key=lambda pair: pair[1].distance, default=None)


def collisions_told(collisions: Sequence[Collision]) -> str:
    """Return in words how many there were."""
    return count(len(collisions), "collision") if collisions else "no collision"


def run_handles(run: Run) -> list[Line2D]:
    """Return what the legend of a run holds."""
    ways = [line_handle("planned", mix(INK, "#ffffff", 0.6)), line_handle("driven", INK)]
    return [*ways, *collision_handles(run.collisions)]


def collision_handles(collisions: Sequence[Collision]) -> list[Line2D]:
    """Return the mark of collisions for the legend, if there were any."""
    return [handle("collision", "X", COLLISION, "white")] if collisions else []


def mark_collisions(axes: Axes, places: FloatArray, n: int) -> Any:
    """Cross places (k, 2), in the size for a team of n; return the crosses."""
    size = 4 * (1.6 * mark_radius(n)) ** 2
    return axes.scatter(
        places[:, 0], places[:, 1], s=size, c=COLLISION, marker="X", edgecolors="white", linewidths=0.7, zorder=9
    )


def draw_collisions(axes: Axes, collisions: Sequence[Collision], n: int) -> list[Label]:
    """Cross the places where robots of a team of n collided; return labels with who and when if there are few."""
    if not collisions:
        return []
    mark_collisions(axes, np.array([hit.place for hit in collisions]), n)
    if len(collisions) > FEW_COLLISIONS:
        return []
    reach = 1.6 * mark_radius(n)
    return [
        Label(f"{hit.robot} hits {hit.other}\n{in_seconds(hit.time)}", hit.place, reach, darker(COLLISION), 7.0)
        for hit in collisions
    ]


def draw_collision_times(strip: Axes, collisions: Sequence[Collision]) -> None:
    """Draw a line over a course at the time of each collision, of very many at the first times."""
    for time in sorted({hit.time for hit in collisions})[:MANY_TIMES]:
        strip.axvline(time, color=COLLISION, linewidth=0.7, zorder=2)


# --- the map


def _draw_map(axes: Axes, run: Run) -> None:
    scene, n = run.plan.scene, len(run.names)
    colours = robot_colours(n)
    draw_backdrop(axes, run.plan, run_handles(run))
    ways = [run.poses[:, k, :2] for k in range(n)]
    lines = LineCollection(ways, colors=colours, linewidths=0.75 * line_width(n), zorder=6.2)
    lines.set(capstyle="round", joinstyle="round")
    axes.add_collection(lines, autolim=False)
    standing = np.where(np.isnan(run.arrivals)[:, None], run.poses[-1, :, :2], np.nan)
    draw_team(axes, scene.robots, standing, colours)
    labels = [*draw_collisions(axes, run.collisions, n), *_nearest_label(axes, run), *_standing_labels(run, standing)]
    if n <= FEW_ROBOTS:
        labels += start_labels(axes, scene, list(run.names), colours)
    marks = [*end_marks(axes, scene.robots, n), *((label.at, label.reach) for label in labels)]
    write(axes, labels, marks, samples(axes, [*ways, *outlines(scene)]))
    write_title(axes, scene.name, *_facts(run))


def _facts(run: Run) -> list[str]:
    """Return what the title says: most in the first text, least in the last."""
    there, n = int(np.isfinite(run.arrivals).sum()), len(run.names)
    planned = in_seconds(run.plan.makespan)
    last = f"last arrival {in_seconds(run.makespan)}, planned {planned}" if run.arrived else f"{there} of {n} arrived"
    crashed = collisions_told(run.collisions)
    found = nearest_of(run)
    least = [] if found is None or run.collisions else [f"nearest {found[1].distance:.3g} m"]
    return [" · ".join([last, crashed, *least]), f"{last} · {crashed}", crashed]


def _nearest_label(axes: Axes, run: Run) -> list[Label]:
    found = nearest_of(run)
    if found is None or run.collisions:
        return []
    name, nearest = found
    ring: dict[str, Any] = {"facecolors": "none", "edgecolors": INK, "linewidths": 1.1, "zorder": 8.5}
    reach = 2.2 * mark_radius(len(run.names))
    axes.scatter(*nearest.place, s=4 * reach**2, **ring)
    text = f"{name}–{nearest.other}\n{nearest.distance:.3g} m, {in_seconds(nearest.time)}"
    return [Label(text, nearest.place, reach, INK, size=7.0, weight="normal")]


def _standing_labels(run: Run, standing: FloatArray) -> list[Label]:
    """Say of robots that have not arrived why not."""
    here = np.flatnonzero(np.isfinite(standing).all(axis=1)).tolist()
    if not here or len(here) > FEW_ROBOTS:
        return []
    from taut.simulation.report import stopped

    reach, why = 2 * mark_radius(len(run.names)), stopped(run)
    places = standing.tolist()
    return [
        Label(f"{run.names[k]} {why[run.names[k]]}", (places[k][0], places[k][1]), reach, darker(COLLISION), 7.0)
        for k in here
    ]


# --- courses over time


def _draw_errors(axes: Axes, run: Run) -> None:
    until = run.seconds or 1.0
    strays, late = add_strips(axes, [COURSE, COURSE], until, [])
    _draw_courses(strays, run, run.strays, "m", _farthest(run))
    title_strip(strays, 0.0, "cross-track error: metres beside the planned way", "cross-track error, m")
    lost = lateness(run)
    _draw_courses(late, run, lost, "s", _greatest(run.times, np.nan_to_num(lost)))
    title_strip(late, 0.0, "timing error: seconds behind the plan", "timing error, s")


def lateness(run: Run) -> FloatArray:
    """Return the seconds that each robot is behind the plan at the recorded instants, (k, n), nan after its arrival."""
    under_way = run.times[:, None] < np.nan_to_num(run.arrivals, nan=np.inf)
    return np.where(under_way, np.maximum(run.times[:, None] - run.progress, 0.0), np.nan)


def _farthest(run: Run) -> tuple[float, float, int] | None:
    """When, how far and who strayed most, of all steps, also those that are not recorded."""
    if not run.greatest_stray.max(initial=0.0) > 0:
        return None
    robot = int(run.greatest_stray.argmax())
    return float(run.strayed_at[robot]), float(run.greatest_stray[robot]), robot


def _greatest(times: FloatArray, values: FloatArray) -> tuple[float, float, int] | None:
    """When, how much and who had the greatest value of all, if there is one above 0."""
    if not values.max(initial=0.0) > 0:
        return None
    row, robot = np.unravel_index(int(values.argmax()), values.shape)
    return float(times[row]), float(values[row, robot]), int(robot)


def _draw_courses(strip: Axes, run: Run, values: FloatArray, unit: str, worst: tuple[float, float, int] | None) -> None:
    """Draw a course a robot, of many robots thin and with the worst of all in ink, and mark the worst."""
    n = len(run.names)
    times, courses = _thinned(run.times, values)
    top = 0.0 if worst is None else worst[1]
    strip.set_ylim(0.0, 1.3 * top or 1.0)
    strip.yaxis.set_major_locator(MaxNLocator(3, steps=[1, 2, 5, 10]))
    strip.yaxis.set_major_formatter(StrMethodFormatter("{x:g}"))
    lines = [np.column_stack([times, courses[:, k]]) for k in range(n)]
    width, alpha = (1.2, 1.0) if n <= FEW_NAMES else (0.7, 0.7) if n <= 60 else (0.4, 0.35)
    strip.add_collection(LineCollection(lines, colors=robot_colours(n), linewidths=width, alpha=alpha, zorder=3))
    if n > FEW_NAMES:
        strip.plot(times, np.fmax.reduce(courses, axis=1), color=INK, linewidth=0.9, zorder=4)
    draw_collision_times(strip, run.collisions)
    if worst is not None:
        _mark_worst(strip, worst[0], top, f"{run.names[worst[2]]}: {top:.3g} {unit}")


def _thinned(times: FloatArray, values: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Return at most `COLUMNS` instants (k,), and of the values (k, n) the greatest since the instant before."""
    few = -(-len(times) // COLUMNS)
    if few <= 1:
        return times, values
    starts = np.arange(0, len(times), few)
    return times[starts], np.fmax.reduceat(values, starts, axis=0)


def _mark_worst(strip: Axes, time: float, value: float, text: str) -> None:
    strip.plot(time, value, color=INK, marker="o", markersize=4, markeredgecolor="white", clip_on=False, zorder=7)
    wide = size_in_points(strip)[0]
    left = time / strip.get_xlim()[1] * wide + text_size(text, NOTE_SIZE)[0] + 6 < wide
    strip.annotate(
        text,
        (time, value),
        (5 if left else -5, 1),
        textcoords="offset points",
        ha="left" if left else "right",
        va="bottom",
        fontsize=NOTE_SIZE,
        color=INK,
        parse_math=False,
        path_effects=[withStroke(linewidth=2.2, foreground="white")],
        zorder=8,
    )
