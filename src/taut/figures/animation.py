"""Plans in motion: discs with headings and fading trails over a still background."""

from __future__ import annotations

import os
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from matplotlib.artist import Artist
from matplotlib.axes import Axes
from matplotlib.collections import LineCollection
from matplotlib.colors import to_rgba_array
from matplotlib.lines import Line2D
from matplotlib.patheffects import withStroke
from matplotlib.text import Text

from taut.errors import OutputError
from taut.figures import style
from taut.figures.canvas import points_per_metre, sheet
from taut.figures.labels import text_size
from taut.figures.maps import draw_map, name_obstacles, scene_view
from taut.figures.movies import Frame, Palette, find_encoder, write_gif, write_mp4
from taut.figures.pictures import end_handles, line_handle, shown_contacts, write_legend
from taut.figures.plans import draw_paths, in_seconds, pale, route_of, within_reach
from taut.figures.saving import any_letters, check_kind
from taut.figures.style import INK, QUIET, Colour, darker, mix, robot_colours
from taut.figures.teams import discs, draw_ends, mark_radius, visible_radii
from taut.motion import Plan, Trajectory
from taut.scene import FloatArray, Robot, Scene
from taut.writing import replacing

if TYPE_CHECKING:
    from taut.contact import Contact, Contacts

LONGEST = 11.5  # seconds of motion shown, by default
HOLD = 1.2  # seconds that the last frame stays
FADE = 0.5  # seconds of animation in which a robot that has left fades
TRAIL = 1.4  # seconds of animation that trails reach back
TRAIL_PIECES = 6000  # at most so many pieces of trail in a frame
MANY = 200  # more robots than that are shown without ends, noses and much of a trail
FEW_NAMES = 12  # up to this many robots carry their names
DPI = 100


def animate(
    plan: Plan,
    path: str | os.PathLike[str],
    *,
    fps: float | None = None,
    seconds: float | None = None,
    width: int = 720,
    contact: Contact | float | None = None,
) -> None:
    """Show a plan in motion as a .gif, or as an .mp4 if ffmpeg is installed.

    A plan that claims contact, or is shown with `contact`, has links between its robots, the thicker the nearer they
    are and red where the loss of one would split the team, and under the map the course of λ2; of up to 150 robots.

    Robots that leave fade at their arrival; robots too small to be seen are drawn as small marks. The same plan
    gives the same .gif, byte for byte. The file is written beside its place and then renamed.

    Parameters
    ----------
    plan : what to show.
    path : file to write, .gif or .mp4.
    fps : frames a second; by default 20, for more than 200 robots 12.
    seconds : how long the motion from 0 to the last arrival takes in the animation; by default as long as it really
        does, at most 11.5 s.
    width : of the picture in pixels, at most.
    contact : links to show: a range in metres or a `Contact`; by default those that the plan claims.

    Raises
    ------
    OutputError
        Another extension, no ffmpeg, a place that cannot be written, numbers that make no film.
    """
    target = Path(path)
    fps = frames_a_second(target, len(plan.trajectories), fps, seconds, width)
    view = scene_view(plan.scene)
    found = shown_contacts(plan, contact)
    plan = within_reach(plan, view)
    film = _film(plan, fps, seconds)
    axes = sheet(view, width / DPI, 1.15 * width / DPI)
    links = [] if found is None else [style.LINK, style.BRIDGE, style.APART]
    with any_letters():
        render = _stage(axes, plan, film, found)
        write_film(target, render, film, links)


@dataclass(frozen=True)
class Film:
    """Everything that moves, for all frames: F frames, n robots."""

    times: FloatArray  # (F,) seconds of the motion, may go beyond its end
    places: FloatArray  # (n, F, 2) metres
    headings: FloatArray  # (n, F, 2) unit vectors, zero for a robot that never moves
    presence: FloatArray  # (n, F) 1 there, 0 gone, between while it fades
    fps: float
    pace: float  # seconds of the motion in one second of animation
    until: float  # seconds at which the motion ends


def frames_a_second(target: Path, n: int, fps: float | None, seconds: float | None, width: int) -> float:
    """Return the frames a second of a film of n robots, as asked for or else as suits them.

    Raises
    ------
    OutputError
        Another extension, no ffmpeg, numbers that make no film.
    """
    kind = check_kind(target, ("gif", "mp4"), "animations are written as")
    if fps is None:
        fps = 20.0 if n <= MANY else 12.0
    if not (0 < fps <= 100 and width >= 160 and (seconds is None or 0 < seconds <= 3600)):
        raise OutputError("an animation needs fps in (0, 100], seconds in (0, 3600] and width ≥ 160 pixels")
    if kind == "mp4":
        find_encoder(target)
    return fps


def frame_times(until: float, fps: float, seconds: float | None) -> tuple[FloatArray, float]:
    """Return the times of the frames of a motion that ends at `until` seconds, and how many of them pass a second."""
    length = seconds if seconds is not None else min(until, LONGEST)
    pace = until / length if length > 0 and until > 0 else 1.0
    moving = max(1, round(length * fps)) if until > 0 else 0
    fading = round(FADE * fps) + 1 if until > 0 else 0
    times = np.linspace(0.0, until, moving + 1) if moving else np.zeros(1)
    return np.concatenate([times, until + pace / fps * np.arange(1, fading + 1)]), pace


def write_film(target: Path, render: Callable[[int], Frame], film: Film, colours: Sequence[Colour]) -> None:
    """Write the frames, beside their place and then renamed; these colours a .gif has exactly, with the usual ones."""
    count = len(film.times)
    with replacing(target) as scratch:
        if target.suffix.lower() == ".mp4":
            write_mp4(scratch, _rendered(render, count), film.fps, HOLD, find_encoder(target))
        else:
            some = [render(k) for k in sorted({0, count // 4, count // 2, 3 * count // 4, count - 1})]
            palette = Palette(some, [*_plain_colours(len(film.places)), *colours])
            write_gif(scratch, _rendered(render, count), count, film.fps, HOLD, palette)


def _film(plan: Plan, fps: float, seconds: float | None) -> Film:
    times, pace = frame_times(plan.makespan, fps, seconds)
    n = len(plan.trajectories)
    places = np.array([t.at(times) for t in plan.trajectories]).reshape(n, len(times), 2)
    headings = np.array([_headings(t, times) for t in plan.trajectories]).reshape(n, len(times), 2)
    presence = np.ones((n, len(times)))
    for k, (robot, trajectory) in enumerate(zip(plan.scene.robots, plan.trajectories, strict=True)):
        if not plan.scene.stays(robot):
            presence[k] = np.clip(1 - (times - trajectory.arrival) / (FADE * pace), 0, 1)
    return Film(times, places, headings, presence, fps, pace, plan.makespan)


def _headings(trajectory: Trajectory, times: FloatArray) -> FloatArray:
    """Return the direction of travel at the times; a robot at rest looks where it came from, at first where it goes."""
    steps = np.diff(trajectory.points, axis=0)
    lengths = np.hypot(*steps.T)
    moves = np.flatnonzero(lengths > 0)
    if moves.size == 0:
        return np.zeros((len(times), 2))
    units = steps[moves] / lengths[moves, None]
    last = np.searchsorted(trajectory.times[moves], times, side="right") - 1
    return np.asarray(units[np.maximum(last, 0)], dtype=np.float64)


def _stage(axes: Axes, plan: Plan, film: Film, found: Contacts | None) -> Callable[[int], Frame]:
    """Draw the background once and return the function that renders frame k over it."""
    draw_backdrop(axes, plan, _link_handles(found))
    update, artists = cast(axes, plan.scene, film)
    if found is not None:
        update, artists = _with_links(axes, plan, film, found, update, artists)
    return renderer(axes, update, artists)


def draw_backdrop(axes: Axes, plan: Plan, handles: Sequence[Line2D]) -> None:
    """Draw what does not move: the map, the planned paths pale, starts and goals; the handles end the legend."""
    scene, n = plan.scene, len(plan.trajectories)
    colours = robot_colours(n)
    draw_map(axes, scene)
    name_obstacles(axes, scene)
    faint = [mix(colour, "#ffffff", 0.6) for colour in colours]
    routes = [route_of(t) for t in plan.trajectories]
    draw_paths(axes, routes, faint, width=1.1 if n <= FEW_NAMES else 0.7 if n <= 60 else 0.4)
    if n <= MANY:
        draw_ends(axes, scene, pale(colours))
        write_legend(axes, [*end_handles(scene), *handles])
    axes.set_title(scene.name, loc="left", fontsize=10.5, fontweight="bold", color=INK, pad=7, parse_math=False)


def renderer(axes: Axes, update: Callable[[int], None], artists: Sequence[Artist]) -> Callable[[int], Frame]:
    """Return the function that renders frame k: what is drawn so far, and over it the artists as `update` sets them."""
    canvas: Any = axes.figure.canvas  # the stubs leave its methods without types
    canvas.draw()
    background = canvas.copy_from_bbox(axes.figure.bbox)

    def render(k: int) -> Frame:
        canvas.restore_region(background)
        update(k)
        for artist in artists:
            axes.draw_artist(artist)
        picture = np.asarray(canvas.buffer_rgba())
        # video wants even sides
        return picture[: picture.shape[0] // 2 * 2, : picture.shape[1] // 2 * 2].copy()

    return render


def cast(axes: Axes, scene: Scene, film: Film) -> tuple[Callable[[int], None], list[Artist]]:
    """Create the artists that move; return the function that sets them for frame k, and them in drawing order."""
    robots, n = scene.robots, len(scene.robots)
    scale = points_per_metre(axes)
    colours = robot_colours(n)
    rgba = to_rgba_array(colours).reshape(n, 4)
    rims = to_rgba_array([mix(c, "#000000", 0.45) for c in colours]).reshape(n, 4)
    mark = max(mark_radius(n), 1.7)
    radii = visible_radii(axes, robots, mark)
    real = np.array([robot.radius * scale > mark for robot in robots], dtype=bool)
    reach = int(np.clip(round(TRAIL * film.fps), 1, max(2, TRAIL_PIECES // max(n, 1))))

    trail = LineCollection([], linewidths=2.4 if n <= FEW_NAMES else 1.6 if n <= 60 else 1.0, zorder=7)
    trail.set_capstyle("butt")
    axes.add_collection(trail, autolim=False)
    bodies = discs(axes, film.places[:, 0], radii, zorder=8)
    bodies.set_linewidth(0.7 if n <= 60 else 0.4)
    noses = LineCollection([], linewidths=1.3 if n <= 60 else 0.7, zorder=8.5)
    axes.add_collection(noses, autolim=False)
    names = _names(axes, robots, radii * scale) if n <= FEW_NAMES else []
    inside = np.array([inside for _, inside, _ in names] or [False] * n, dtype=bool)
    clock = axes.set_title("", loc="right", fontsize=9, color=QUIET, pad=7)
    pace = "" if abs(film.pace - 1) < 0.005 else f"    {film.pace:.3g}× speed"

    # a nose within a true disc is white from its centre; beyond a mark or name it has the robot's colour
    within = real & ~inside
    tail = np.where(within, 0.15, 1.0)[:, None] * radii[:, None]
    tip = np.where(within, 0.95, np.where(real, 1.3, 2.1))[:, None] * radii[:, None]
    nose_colours = np.where(within[:, None], (1.0, 1.0, 1.0, 1.0), rims)

    def update(k: int) -> None:
        here, ahead, there = film.places[:, k], film.headings[:, k], film.presence[:, k]
        first = max(0, k - reach)
        pieces = np.stack([film.places[:, first:k], film.places[:, first + 1 : k + 1]], axis=2)
        strength = np.linspace(1 - (k - first) / reach, 1, k - first, endpoint=False) + 1 / reach
        shades = np.repeat(rgba[:, None], k - first, axis=1)
        shades[..., 3] = 0.75 * strength * there[:, None]
        moved = (pieces[:, :, 0] != pieces[:, :, 1]).any(axis=-1) & (shades[..., 3] > 0)
        trail.set_segments(list(pieces[moved]))
        trail.set_color(list(shades[moved]))
        bodies.set_offsets(here)
        bodies.set(facecolors=_with_alpha(rgba, there), edgecolors=_with_alpha(rims, there))
        if n <= MANY:
            noses.set_segments(list(np.stack([here + tail * ahead, here + tip * ahead], axis=1)))
            noses.set_color(list(_with_alpha(nose_colours, there * ahead.any(axis=1))))
        for (text, _, aside), place, alpha in zip(names, here, there, strict=False):
            text.set_position((place[0] + aside, place[1] + aside))
            text.set_alpha(float(alpha))
        clock.set_text(f"t = {in_seconds(min(film.times[k], film.until))}{pace}")

    moving: list[Artist] = [trail, bodies, noses, *(text for text, _, _ in names), clock]
    for artist in moving:
        artist.set_animated(True)
    return update, moving


def _with_links(
    axes: Axes,
    plan: Plan,
    film: Film,
    found: Contacts,
    update: Callable[[int], None],
    artists: list[Artist],
) -> tuple[Callable[[int], None], list[Artist]]:
    """Put the links of the team under what moves, and a hand over the course of λ2 below the map."""
    from taut.figures.contact import cast_contact

    link, under, over = cast_contact(axes, plan, found)

    def update_all(k: int) -> None:
        update(k)
        link(min(float(film.times[k]), plan.makespan), film.places[:, k])

    return update_all, [*under, *artists, *over]


def _link_handles(found: Contacts | None) -> list[Line2D]:
    if found is None:
        return []
    return [line_handle("link", style.LINK), line_handle("bridge: its loss splits the team", style.BRIDGE)]


def _names(axes: Axes, robots: Sequence[Robot], radii: FloatArray) -> list[tuple[Text, bool, float]]:
    """Return for each robot its text, whether that stands in the disc, and the metres by which it stands aside."""
    out: list[tuple[Text, bool, float]] = []
    scale = points_per_metre(axes)
    colours = robot_colours(len(radii))
    for robot, radius, colour in zip(robots, radii, colours, strict=True):
        size = 7.0
        inside = float(np.hypot(*text_size(robot.name, size))) / 2 < 0.95 * radius
        text = axes.text(0, 0, robot.name, fontsize=size, fontweight="bold", zorder=9, clip_on=True, parse_math=False)
        if inside:
            text.set(ha="center", va="center_baseline", color="white")
        else:
            text.set(ha="left", va="bottom", color=darker(colour))
            text.set_path_effects([withStroke(linewidth=2.0, foreground="white")])
        out.append((text, inside, 0.0 if inside else (0.72 * radius + 1.0) / scale))
    return out


def _with_alpha(rgba: FloatArray, alpha: FloatArray) -> FloatArray:
    out = rgba.copy()
    out[:, 3] *= alpha
    return out


def _rendered(render: Callable[[int], Frame], count: int) -> Iterator[Frame]:
    return (render(k) for k in range(count))


def _plain_colours(n: int) -> Sequence[str]:
    fixed = [style.WORKSPACE, style.OUTSIDE, style.OBSTACLE, style.OBSTACLE_EDGE, style.START, style.GOAL, style.INK]
    return [*fixed, *dict.fromkeys(robot_colours(min(n, 30)))]
