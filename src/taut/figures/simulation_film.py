"""Runs in motion: vehicles on their way, what their sensors see, and crosses from the instants of collisions on."""

from __future__ import annotations

import math
import os
from collections.abc import Callable
from pathlib import Path
from typing import TYPE_CHECKING, Any, TypeAlias

import numpy as np
from matplotlib.artist import Artist
from matplotlib.axes import Axes
from matplotlib.collections import LineCollection, PolyCollection
from matplotlib.colors import to_rgba
from matplotlib.text import Text

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
from taut.figures.canvas import sheet
from taut.figures.courses import lengthen
from taut.figures.maps import scene_view
from taut.figures.saving import any_letters
from taut.figures.simulation import COLLISION, mark_collisions, run_handles
from taut.figures.style import darker, robot_colours
from taut.scene import FloatArray

if TYPE_CHECKING:  # a picture of something else does not load the compiled code that simulates
    from taut.simulation.detector import Detector
    from taut.simulation.running import Run, Scans

Layer: TypeAlias = tuple[Callable[[int], None], list[Artist]]
"""What sets frame k of something that moves, and its artists in drawing order."""

RAYS = 240  # about so many lidar rays in a frame
LONGEST_NAME = 7  # letters of a robot's name beside its pose
POSE_SIZE, POSE_ROW, POSE_WIDE = 7.5, 0.17, 2.05  # points; inches a row, inches a column


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
        draw_backdrop(axes, run.plan, run_handles(run))
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
    marks = mark_collisions(axes, places, len(run.names))

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
