"""Runs in pictures: what vehicles have made of a plan or a law, still with courses over time, and in motion."""

from __future__ import annotations

import math
import os
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any, TypeAlias

import numpy as np
from matplotlib.artist import Artist
from matplotlib.axes import Axes
from matplotlib.collections import LineCollection, PolyCollection
from matplotlib.colors import to_rgba
from matplotlib.patheffects import withStroke
from matplotlib.text import Text
from matplotlib.ticker import MaxNLocator, StrMethodFormatter

from taut.figures.animation import (
    DPI,
    FADE,
    FEW_NAMES,
    MANY,
    Film,
    cast,
    draw_backdrop,
    frame_times,
    frames_a_second,
    renderer,
    write_film,
)
from taut.figures.canvas import sheet, show, size_in_points
from taut.figures.courses import COURSE, NOTE_SIZE, add_strips, lengthen, title_strip
from taut.figures.labels import Label, text_size, write
from taut.figures.maps import draw_map, name_obstacles, outlines, scene_view
from taut.figures.pictures import handle, line_handle, write_legend, write_title
from taut.figures.plans import in_seconds, line_width, samples
from taut.figures.saving import NO_STAMPS, _bytes, any_letters, check_kind
from taut.figures.style import BRIDGE, INK, LINK, START, Colour, darker, mix, robot_colours
from taut.figures.teams import FEW_ROBOTS, draw_team, end_marks, mark_radius, start_labels
from taut.graph import Graph
from taut.scene import FloatArray
from taut.writing import replacing

if TYPE_CHECKING:  # a picture of something else does not load the compiled code that simulates
    from taut.control.laws import Links
    from taut.simulation.detector import Detector
    from taut.simulation.running import Collision, Nearest, Run, Scans
    from taut.simulation.steering import Steered

Layer: TypeAlias = tuple[Callable[[int], None], list[Artist]]
"""What sets frame k of something that moves, and its artists in drawing order."""

COLLISION: Colour = BRIDGE
FEW_COLLISIONS = 12  # up to this many are told with their times
COLUMNS = 1200  # points of a course over time: of more instants the worst of a few is shown
RAYS = 240  # about so many lidar rays in a frame
LONGEST_NAME = 7  # letters of a robot's name beside its pose
POSE_SIZE, POSE_ROW, POSE_WIDE = 7.5, 0.17, 2.05  # points; inches a row, inches a column


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


def animate_run(
    run: Run,
    path: str | os.PathLike[str],
    *,
    fps: float | None = None,
    seconds: float | None = None,
    width: int = 720,
    detector: Detector | None = None,
) -> None:
    """Show a run in motion as a .gif, or as an .mp4 if ffmpeg is installed.

    Behind each robot the way it has driven, over the pale one planned; what its lidar sees, with a dot at each echo; a
    dashed line to the nearest point of all that its detector names; crosses from the instants of collisions on; of up
    to 12 robots the poses [x y θ] in metres and degrees.

    Parameters
    ----------
    run : what `simulate` gives; with lidars if they are to be seen.
    path : file to write, .gif or .mp4.
    fps : frames a second; by default 20, for more than 200 robots 12.
    seconds : how long the run takes in the animation; by default as long as it did, at most 11.5 s.
    width : of the picture in pixels, at most.
    detector : that every robot carries, see `taut.simulation.detect`.

    Raises
    ------
    OutputError
        Another extension, no ffmpeg, a place that cannot be written, numbers that make no film.
    """
    target = Path(path)
    fps = frames_a_second(target, len(run.names), fps, seconds, width)
    film, turns = _film(run, fps, seconds)
    axes = sheet(scene_view(run.plan.scene), width / DPI, 1.15 * width / DPI)
    with any_letters():
        draw_backdrop(axes, run.plan, _handles(run))
        layers = [_rays(axes, run, film)] if run.scans is not None else []
        if detector is not None:
            layers.append(_detected(axes, run, film, turns, detector))
        layers += [_driven(axes, film), cast(axes, run.plan.scene, film), _crosses(axes, run, film)]
        if len(run.names) <= FEW_NAMES:
            layers.append(_poses(axes, run, film, turns))
        updates = [update for update, _ in layers]
        artists = [artist for _, some in layers for artist in some]
        for artist in artists:
            artist.set_animated(True)

        def update(k: int) -> None:
            for each in updates:
                each(k)

        write_film(target, renderer(axes, update, artists), film, [COLLISION])


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
    axes = sheet(view) if ax is None else ax
    if ax is not None:
        show(ax, view)
    _draw_steered(axes, run, links)
    if ax is None and links is not None:
        _draw_connectivity(axes, run, links)
    return axes


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
        scratch.write_bytes(_bytes(draw_steered(run, links), kind, 200))


def nearest_of(run: Run) -> tuple[str, Nearest] | None:
    """Return which robot came nearest to another or to an obstacle, and how; None if nobody came near anything."""
    both = [*zip(run.names, run.clearances, strict=True), *zip(run.names, run.separations, strict=True)]
    near = [(name, nearest) for name, nearest in both if math.isfinite(nearest.distance)]
    return min(near, key=lambda pair: pair[1].distance, default=None)


# --- still pictures


def _draw_map(axes: Axes, run: Run) -> None:
    scene, n = run.plan.scene, len(run.names)
    colours = robot_colours(n)
    draw_backdrop(axes, run.plan, _handles(run))
    ways = [run.poses[:, k, :2] for k in range(n)]
    lines = LineCollection(ways, colors=colours, linewidths=0.75 * line_width(n), zorder=6.2)
    lines.set(capstyle="round", joinstyle="round")
    axes.add_collection(lines, autolim=False)
    standing = np.where(np.isnan(run.arrivals)[:, None], run.poses[-1, :, :2], np.nan)
    draw_team(axes, scene.robots, standing, colours)
    labels = [*_collision_labels(axes, run), *_nearest_label(axes, run), *_standing_labels(run, standing)]
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
    hits = len(run.collisions)
    crashed = f"{hits} collision{'s' * (hits != 1)}" if hits else "no collision"
    found = nearest_of(run)
    least = [] if found is None or hits else [f"nearest {found[1].distance:.3g} m"]
    return [" · ".join([last, crashed, *least]), f"{last} · {crashed}", crashed]


def _handles(run: Run) -> list[Any]:
    out = [line_handle("planned", mix(INK, "#ffffff", 0.6)), line_handle("driven", INK)]
    return [*out, handle("collision", "X", COLLISION, "white")] if run.collisions else out


def _collision_labels(axes: Axes, run: Run) -> list[Label]:
    return _labels_of(axes, run.collisions, len(run.names))


def _labels_of(axes: Axes, collisions: Sequence[Collision], n: int) -> list[Label]:
    if not collisions:
        return []
    _mark_collisions(axes, np.array([hit.place for hit in collisions]), n)
    if len(collisions) > FEW_COLLISIONS:
        return []
    reach = 1.6 * mark_radius(n)
    return [
        Label(f"{hit.robot} hits {hit.other}\n{in_seconds(hit.time)}", hit.place, reach, darker(COLLISION), 7.0)
        for hit in collisions
    ]


def _mark_collisions(axes: Axes, places: FloatArray, n: int) -> Any:
    size = 4 * (1.6 * mark_radius(n)) ** 2
    return axes.scatter(
        places[:, 0], places[:, 1], s=size, c=COLLISION, marker="X", edgecolors="white", linewidths=0.7, zorder=9
    )


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


def _draw_steered(axes: Axes, run: Steered, links: Links | None) -> None:
    scene, n = run.scene, len(run.names)
    colours = robot_colours(n)
    draw_map(axes, scene)
    name_obstacles(axes, scene)
    ends, headings = run.poses[-1, :, :2], run.poses[-1, :, 2]
    if links is not None and n:
        graph = links if isinstance(links, Graph) else links(ends)
        joined = LineCollection(list(ends[graph.edges]), colors=LINK, linewidths=0.8, alpha=0.6, zorder=6.0)
        axes.add_collection(joined, autolim=False)
    ways = [run.poses[:, k, :2] for k in range(n)]
    axes.add_collection(
        LineCollection(ways, colors=colours, linewidths=0.75 * line_width(n), zorder=6.2), autolim=False
    )
    starts = np.array([robot.start for robot in scene.robots], dtype=np.float64).reshape(n, 2)
    axes.scatter(
        starts[:, 0], starts[:, 1], s=4 * mark_radius(n) ** 2, c=START, edgecolors="white", linewidths=0.6, zorder=6.5
    )
    draw_team(axes, scene.robots, ends, colours)
    ahead = np.array([robot.radius for robot in scene.robots])[:, None] * np.stack(
        [np.cos(headings), np.sin(headings)], axis=1
    )
    noses = LineCollection(list(np.stack([ends, ends + ahead], axis=1)), colors="white", linewidths=1.2, zorder=8.2)
    axes.add_collection(noses, autolim=False)
    labels = _labels_of(axes, run.collisions, n)[
        :1
    ]  # who gathers collides in one place: the names of all would overlap
    if n <= FEW_ROBOTS:
        labels += start_labels(axes, scene, list(run.names), colours)
    write(axes, labels, [(label.at, label.reach) for label in labels], samples(axes, [*ways, *outlines(scene)]))
    marks = [handle("start", "o", START, "white"), line_handle("driven", INK)]
    write_legend(axes, [*marks, handle("collision", "X", COLLISION, "white")] if run.collisions else marks)
    state = (
        f"settled after {in_seconds(run.settled_at)}" if run.settled else f"not settled in {in_seconds(run.seconds)}"
    )
    hits = len(run.collisions)
    crashed = f"{hits} collision{'s' * (hits != 1)}" if hits else "no collision"
    write_title(axes, scene.name, f"{state} · {crashed}", state)


# --- courses over time


def _draw_connectivity(axes: Axes, run: Steered, links: Links) -> None:
    from taut.simulation.steering import fiedler_values

    (strip,) = add_strips(axes, [COURSE], run.seconds or 1.0, [])
    values = fiedler_values(run, links)
    strip.set_ylim(0.0, 1.3 * float(values.max(initial=0.0)) or 1.0)
    strip.yaxis.set_major_locator(MaxNLocator(3, steps=[1, 2, 5, 10]))
    strip.yaxis.set_major_formatter(StrMethodFormatter("{x:g}"))
    strip.step(run.times, values, where="post", color=LINK, linewidth=1.4, zorder=3)
    for time in sorted({hit.time for hit in run.collisions})[:200]:
        strip.axvline(time, color=COLLISION, linewidth=0.7, zorder=2)
    title_strip(strip, 0.0, "λ2: how well the team holds together", "λ2")


def _draw_errors(axes: Axes, run: Run) -> None:
    until = run.seconds or 1.0
    strays, late = add_strips(axes, [COURSE, COURSE], until, [])
    _draw_courses(strays, run, run.strays, "m")
    title_strip(strays, 0.0, "cross-track error: metres beside the planned way", "cross-track error, m")
    _draw_courses(late, run, lateness(run), "s")
    title_strip(late, 0.0, "timing error: seconds behind the plan", "timing error, s")


def lateness(run: Run) -> FloatArray:
    """Return the seconds that each robot is behind the plan at the recorded instants, (k, n), nan after its arrival."""
    under_way = run.times[:, None] < np.nan_to_num(run.arrivals, nan=np.inf)
    return np.where(under_way, np.maximum(run.times[:, None] - run.progress, 0.0), np.nan)


def _draw_courses(strip: Axes, run: Run, values: FloatArray, unit: str) -> None:
    """Draw a course a robot, of many robots thin and with the worst of all in ink, and mark the worst."""
    n = len(run.names)
    times, courses = _thinned(run.times, values)
    known = np.nan_to_num(values)
    top = float(known.max(initial=0.0))
    strip.set_ylim(0.0, 1.3 * top or 1.0)
    strip.yaxis.set_major_locator(MaxNLocator(3, steps=[1, 2, 5, 10]))
    strip.yaxis.set_major_formatter(StrMethodFormatter("{x:g}"))
    lines = [np.column_stack([times, courses[:, k]]) for k in range(n)]
    width, alpha = (1.2, 1.0) if n <= FEW_NAMES else (0.7, 0.7) if n <= 60 else (0.4, 0.35)
    strip.add_collection(LineCollection(lines, colors=robot_colours(n), linewidths=width, alpha=alpha, zorder=3))
    if n > FEW_NAMES:
        strip.plot(times, np.fmax.reduce(courses, axis=1), color=INK, linewidth=0.9, zorder=4)
    for time in sorted({hit.time for hit in run.collisions})[:200]:
        strip.axvline(time, color=COLLISION, linewidth=0.7, zorder=2)
    if top > 0:
        row, robot = np.unravel_index(int(known.argmax()), known.shape)
        _mark_worst(strip, float(run.times[row]), top, f"{run.names[robot]}: {top:.3g} {unit}")


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


# --- in motion


def _film(run: Run, fps: float, seconds: float | None) -> tuple[Film, FloatArray]:
    """Return what moves, and the headings in radians, (n, F)."""
    times, pace = frame_times(run.seconds, fps, seconds)
    n = len(run.names)
    moved = np.array([[np.interp(times, run.times, run.poses[:, k, j]) for j in range(3)] for k in range(n)])
    moved = moved.reshape(n, 3, len(times))
    turns = moved[:, 2]
    presence = np.ones((n, len(times)))
    for k, robot in enumerate(run.plan.scene.robots):
        if not run.plan.scene.stays(robot) and np.isfinite(run.arrivals[k]):
            presence[k] = np.clip(1 - (times - run.arrivals[k]) / (FADE * pace), 0, 1)
    headings = np.stack([np.cos(turns), np.sin(turns)], axis=-1)
    places = np.ascontiguousarray(np.moveaxis(moved[:, :2], 1, 2))
    return Film(times, places, headings, presence, fps, pace, run.seconds), turns


def _driven(axes: Axes, film: Film) -> Layer:
    n = len(film.places)
    width = 1.4 if n <= FEW_NAMES else 0.9 if n <= 60 else 0.5
    lines = LineCollection([], colors=robot_colours(n), linewidths=width, zorder=6.2)
    axes.add_collection(lines, autolim=False)

    def update(k: int) -> None:
        if n <= MANY:
            lines.set_segments(list(film.places[:, : k + 1]))

    return update, [lines]


def _crosses(axes: Axes, run: Run, film: Film) -> Layer:
    places = np.array([hit.place for hit in run.collisions], dtype=np.float64).reshape(-1, 2)
    begun = np.array([hit.time for hit in run.collisions], dtype=np.float64)
    marks = _mark_collisions(axes, places, len(run.names))

    def update(k: int) -> None:
        marks.set_offsets(places[begun <= film.times[k]])

    return update, [marks]


def _rays(axes: Axes, run: Run, film: Film) -> Layer:
    """Show the last scan of each lidar: the part of the plane it saw, some of its rays, a dot at each echo."""
    scans = run.scans
    assert scans is not None
    ends, origins = _scanned(run, scans)
    n, beams = ends.shape[1:3]
    colours = robot_colours(n)
    some = max(1, -(-n * beams // RAYS))
    echoes = np.isfinite(scans.ranges) & (scans.ranges < scans.reach)
    seen = PolyCollection([], facecolors=[to_rgba(c, 0.10) for c in colours], edgecolors="none", zorder=5.6)
    rays = LineCollection([], colors=[to_rgba(c, 0.35) for c in np.repeat(colours, len(range(0, beams, some)))])
    rays.set(linewidths=0.35, zorder=5.7)
    axes.add_collection(seen, autolim=False)
    axes.add_collection(rays, autolim=False)
    dots: Any = axes.scatter([], [], s=3.0 if n <= FEW_NAMES else 1.2, linewidths=0, zorder=5.8)
    shades = np.array([to_rgba(c) for c in colours])

    def update(k: int) -> None:
        j = max(int(np.searchsorted(scans.times, film.times[k], side="right")) - 1, 0)
        here = film.presence[:, k] > 0
        fans = np.concatenate([origins[j][:, None], ends[j]], axis=1)
        seen.set_verts([fan if there else np.empty((0, 2)) for fan, there in zip(fans, here, strict=True)])
        starts = np.broadcast_to(origins[j][:, None], ends[j].shape)
        pieces = np.stack([starts, ends[j]], axis=2)[:, ::some]
        pieces = np.where(here[:, None, None, None], pieces, np.nan)
        rays.set_segments(list(pieces.reshape(-1, 2, 2)))
        hit = echoes[j] & here[:, None]
        dots.set_offsets(ends[j][hit])
        dots.set_facecolor(shades[np.nonzero(hit)[0]])

    return update, [seen, rays, dots]


def _scanned(run: Run, scans: Scans) -> tuple[FloatArray, FloatArray]:
    """Return where the rays of all scans end, (k, n, b, 2) metres, and begin, (k, n, 2)."""
    n = len(run.names)
    poses = np.array([[np.interp(scans.times, run.times, run.poses[:, k, j]) for j in range(3)] for k in range(n)])
    poses = np.moveaxis(poses.reshape(n, 3, len(scans.times)), 2, 0)
    angles = poses[:, :, 2, None] + scans.angles
    far = np.where(np.isfinite(scans.ranges), scans.ranges, scans.reach)
    origins = poses[:, :, :2]
    return origins[:, :, None] + far[..., None] * np.stack([np.cos(angles), np.sin(angles)], axis=-1), origins


def _detected(axes: Axes, run: Run, film: Film, turns: FloatArray, detector: Detector) -> Layer:
    """Join each robot to the nearest point of everything it detects."""
    from taut.simulation.detector import detect
    from taut.simulation.surroundings import surroundings_of

    n = len(run.names)
    around = surroundings_of(run.plan.scene)
    colours = robot_colours(n)
    lines = LineCollection([], linewidths=0.9, linestyles=(0, (3, 2)), zorder=7.6)
    axes.add_collection(lines, autolim=False)
    style_of: dict[str, Any] = {"facecolors": "none", "linewidths": 1.1, "zorder": 7.7}
    squares: Any = axes.scatter([], [], s=16.0 if n <= FEW_NAMES else 7.0, marker="s", **style_of)

    def update(k: int) -> None:
        here = film.presence[:, k] > 0
        poses = np.column_stack([film.places[:, k], turns[:, k]])
        ends, shades = [], []
        for robot in np.flatnonzero(here).tolist():
            x, y, heading = poses[robot].tolist()
            for seen in detect(detector, around, poses, robot, present=here):
                angle = heading + seen.bearing
                ends.append([(x, y), (x + seen.distance * math.cos(angle), y + seen.distance * math.sin(angle))])
                shades.append(colours[robot])
        lines.set_segments(ends)
        lines.set_color(shades)
        squares.set_offsets(np.array([end for _, end in ends]).reshape(-1, 2))
        squares.set_edgecolor(shades)

    return update, [lines, squares]


def _poses(axes: Axes, run: Run, film: Film, turns: FloatArray) -> Layer:
    """Write the pose [x y θ] of each robot under the map, in columns."""
    n = len(run.names)
    figure: Any = axes.figure
    wide = float(figure.get_size_inches()[0])
    columns = max(1, min(n, int((wide - 0.3) / POSE_WIDE)))
    rows = -(-n // columns)
    whole = lengthen(axes, POSE_ROW * rows + 0.1)
    names = [name[:LONGEST_NAME] for name in run.names]
    longest = max(map(len, names), default=0)
    texts: list[Text] = []
    for k, colour in enumerate(robot_colours(n)):
        x, y = 0.3 + (k // rows) * POSE_WIDE, 0.1 + POSE_ROW * (rows - 1 - k % rows)
        place = (x / wide, y / whole)
        style_of: dict[str, Any] = {"family": "monospace", "fontsize": POSE_SIZE, "color": darker(colour)}
        texts.append(figure.text(*place, "", parse_math=False, **style_of))

    def update(k: int) -> None:
        degrees = np.degrees(np.arctan2(np.sin(turns[:, k]), np.cos(turns[:, k])))
        for robot, text in enumerate(texts):
            x, y = film.places[robot, k]
            text.set_text(f"{names[robot]:<{longest}} [{x:6.2f} {y:6.2f} {degrees[robot]:4.0f}°]".replace("-", "−"))
            text.set_alpha(float(film.presence[robot, k]))

    return update, list(texts)
