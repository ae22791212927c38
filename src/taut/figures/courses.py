"""Courses over time on strips under the map, and on them the course of a team's λ2."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from typing import Any

import numpy as np
from matplotlib.artist import Artist
from matplotlib.axes import Axes
from matplotlib.lines import Line2D
from matplotlib.patheffects import withStroke
from matplotlib.ticker import LogLocator, MaxNLocator, NullLocator, StrMethodFormatter

from taut.contact import Contacts, losses
from taut.contact.core import Flags
from taut.contact.cuts import cut_times
from taut.figures.canvas import size_in_points
from taut.figures.labels import text_size
from taut.figures.plans import in_seconds
from taut.figures.style import APART, BRIDGE, INK, LINK, OUTSIDE, QUIET, Colour, darker, mix, robot_colours
from taut.scene import FloatArray

COURSE, ROW = 0.95, 0.14  # inches: height of the strip of λ2, of the row of one robot
ROOM, FOOT = 0.32, 0.4  # inches above each strip for its title, below the last one for its numbers
MOST_ROWS = 10
TITLE_SIZE, NOTE_SIZE, NAME_SIZE = 8.5, 8.0, 7.0  # points
SAID = 80.0  # points beside the title of λ2 for what an animation says there
LONGEST_NAME = 20  # letters
STEEP = 25.0  # where λ2 varies more than so many times its scale is logarithmic


def add_course(axes: Axes, found: Contacts, until: float, time: float | None = None) -> None:
    """Make the sheet longer, and draw under the map λ2, its least value, and when which robot is a cut vertex.

    Parameters
    ----------
    axes : the map, on a sheet of its own.
    found : the contacts of the team.
    until : seconds at which the axis of time ends.
    time : seconds that a line marks.
    """
    until = until or 1.0
    cuts = _cuts(found, until)
    most = sorted(cuts, key=lambda robot: -float(np.diff(cuts[robot]).sum()))[:MOST_ROWS]
    rows = {robot: cuts[robot] for robot in sorted(most)}
    heights = [COURSE, ROW * len(rows)] if rows else [COURSE]
    strips = add_strips(axes, heights, until, [_shortened(found.names[robot]) for robot in rows])
    _draw_steps(strips[0], found, until)
    if rows:
        _draw_rows(strips[1], found, rows)
        more = f" ({len(rows)} of {len(cuts)})" if len(cuts) > len(rows) else ""
        title_strip(
            strips[1], 0.0, f"cut vertices: robots whose loss would split the team{more}", f"cut vertices{more}"
        )
    _mark_least(strips, found, until)
    if time is not None:
        for strip in strips:
            strip.axvline(min(time, until), color=INK, linewidth=0.9, zorder=6)


def hand_over(axes: Axes, found: Contacts, until: float) -> tuple[Callable[[float, int], None], list[Artist]]:
    """Make the sheet longer, and draw under the map λ2 and a hand over it, for an animation.

    Returns
    -------
    point : moves the hand to a time in seconds, which lies in that piece of the contacts.
    hand : its parts, to be drawn in this order.
    """
    until = until or 1.0
    (strip,) = add_strips(axes, [COURSE], until, [])
    _draw_steps(strip, found, until)
    low = strip.get_ylim()[0]
    values, apart = found.fiedler, _apart(found)
    line = strip.axvline(0.0, color=INK, linewidth=0.9, clip_on=False, zorder=6)
    dot = Line2D([], [], marker="o", markersize=5.5, color=INK, markeredgecolor="white", clip_on=False, zorder=7)
    strip.add_line(dot)
    said = strip.set_title("", loc="right", fontsize=TITLE_SIZE, pad=4)

    def point(time: float, piece: int) -> None:
        line.set_xdata([min(time, until)] * 2)
        dot.set_data([min(time, until)], [max(float(values[piece]), low)])
        said.set_text("not connected" if apart[piece] else f"λ2 = {values[piece]:.3g}")
        said.set_color(BRIDGE if apart[piece] else QUIET)

    hand: list[Artist] = [line, dot, said]
    for artist in hand:
        artist.set_animated(True)
    return point, hand


def lengthen(axes: Axes, extra: float) -> float:
    """Add so many inches to the sheet under the map, which keeps its size; return how high the sheet is now."""
    figure: Any = axes.figure
    wide, high = figure.get_size_inches()
    x0, y0, across, down = axes.get_position(original=True).bounds
    whole = float(high + extra)
    figure.set_size_inches(wide, whole)
    axes.set_position((x0, (y0 * high + extra) / whole, across, down * high / whole))
    return whole


def add_strips(axes: Axes, heights: Sequence[float], until: float, names: Sequence[str]) -> list[Axes]:
    """Make the sheet longer, and add axes from 0 to `until` seconds under the map.

    Parameters
    ----------
    axes : the map, on a sheet of its own.
    heights : of the strips, inches, from the top down.
    until : seconds.
    names : texts that need room on the left of the strips.
    """
    figure: Any = axes.figure
    wide, _ = figure.get_size_inches()
    x0, _, across, _ = axes.get_position(original=True).bounds
    extra = sum(heights) + ROOM * len(heights) + FOOT
    whole = lengthen(axes, extra)
    named = max((text_size(name, NAME_SIZE)[0] for name in names), default=0.0) / 72
    left = max(x0, named / wide)
    out: list[Axes] = []
    top = extra
    for height in heights:
        top -= ROOM + height
        strip: Axes = figure.add_axes((left, top / whole, x0 + across - left, height / whole), xlim=(0.0, until))
        strip.spines[["top", "right"]].set_visible(False)
        for spine in strip.spines.values():
            spine.set(linewidth=0.6, color=QUIET)
        strip.tick_params(length=2.5, width=0.6, color=QUIET, labelcolor=QUIET, labelsize=7.5, pad=2.5)
        strip.tick_params(axis="x", labelbottom=len(out) == len(heights) - 1)
        strip.xaxis.set_major_locator(MaxNLocator(max(2, min(9, int(across * wide * 1.6))), steps=[1, 2, 5, 10]))
        strip.xaxis.set_major_formatter(StrMethodFormatter("{x:.10g}"))
        out.append(strip)
    style: dict[str, Any] = {"ha": "right", "va": "top", "fontsize": 7.5, "color": QUIET}
    out[-1].annotate("seconds", (1, 0), (0, -17.5), xycoords="axes fraction", textcoords="offset points", **style)
    return out


def title_strip(strip: Axes, room: float, *texts: str) -> None:
    """Write over a strip the first of the texts that leaves `room` points of its width free, else the last."""
    wide = size_in_points(strip)[0] - room
    text = next((text for text in texts if text_size(text, TITLE_SIZE)[0] < wide), texts[-1])
    strip.set_title(text, loc="left", fontsize=TITLE_SIZE, fontweight="bold", color=INK, pad=4)


def _draw_steps(strip: Axes, found: Contacts, until: float) -> None:
    """Draw λ2 piece by piece, with red bands where the team is not connected."""
    values = np.where(found.present.sum(axis=1) > 1, found.fiedler, np.nan)
    edges = np.minimum(np.append(found.times, np.inf), until)
    positive = values[values > 0]
    top, least = float(positive.max(initial=0.0)) or 1.0, float(positive.min(initial=np.inf))
    low = least / 1.6 if top > STEEP * least else 0.0
    strip.set_ylim(low, 1.3 * top)
    if low:
        strip.set_yscale("log")
        strip.set_ylim(low, 1.6 * top)
        strip.yaxis.set_major_locator(LogLocator(10, numticks=4))
        strip.yaxis.set_minor_locator(NullLocator())
    else:
        strip.yaxis.set_major_locator(MaxNLocator(3, steps=[1, 2, 5, 10]))
    strip.yaxis.set_major_formatter(StrMethodFormatter("{x:g}"))
    steps = np.maximum(values, low)
    strip.stairs(steps, edges, baseline=low, fill=True, color=mix(LINK, "#ffffff", 0.82), zorder=2)
    strip.stairs(steps, edges, baseline=None, color=LINK, linewidth=1.4, zorder=3)
    for begin, end in np.minimum(losses(found), until).tolist():
        strip.axvspan(begin, end, facecolor=APART, edgecolor=BRIDGE, linewidth=0.8, zorder=2.5)
    within = f"λ2, links within {found.reach:.4g} m"
    title_strip(strip, SAID, f"{within} and in sight" if found.sight else within, within, "λ2")


def _mark_least(strips: Sequence[Axes], found: Contacts, until: float) -> None:
    """Mark where λ2 is least, or the loss of contact in which it is 0, in words where there is most room for them."""
    when, least = found.worst
    x, (low, high) = min(when, until), strips[0].get_ylim()
    for strip in strips:
        strip.axvline(x, color=BRIDGE, linewidth=0.8, linestyle=(0, (3, 2)), zorder=5)
    dot: dict[str, Any] = {"marker": "o", "markersize": 5.5, "markeredgecolor": "white", "clip_on": False, "zorder": 7}
    strips[0].plot(x, max(least, low), color=BRIDGE, **dot)
    begin, end, text, brief = x, x, f"least {least:.3g} at {in_seconds(when)}", f"least {least:.3g}"
    for lost, again in losses(found).tolist():
        if lost <= when <= again:
            begin, end, brief = lost, min(again, until), "not connected"
            text = f"{brief} from {in_seconds(lost)} " + ("on" if again > until else f"to {in_seconds(again)}")
    sides = [(until - end, end, "left", 5), (begin, begin, "right", -5), (end - begin, begin, "left", 5)]
    room, at, align, aside = max(sides, key=lambda side: side[0])
    fits = text_size(text, NOTE_SIZE)[0] < size_in_points(strips[0])[0] * room / until
    strips[0].annotate(
        text if fits else brief,
        (at, high),
        (aside, -2),
        textcoords="offset points",
        ha=align,
        va="top",
        fontsize=NOTE_SIZE,
        fontweight="bold",
        color=darker(BRIDGE),
        path_effects=[withStroke(linewidth=2.2, foreground="white")],
        zorder=8,
    )


def _draw_rows(strip: Axes, found: Contacts, rows: Mapping[int, FloatArray]) -> None:
    """Draw a row a robot: the stretches of time in which it is a cut vertex."""
    colours = robot_colours(len(found.names))
    strip.set(ylim=(len(rows) - 0.5, -0.5), yticks=[])
    for row, (robot, spans) in enumerate(rows.items()):
        strip.axhline(row, color=OUTSIDE, linewidth=0.8, zorder=1)
        bars = np.column_stack([spans[:, 0], np.diff(spans)])
        strip.broken_barh(bars.tolist(), (row - 0.32, 0.64), facecolors=colours[robot], linewidth=0, zorder=2)
        _name_row(strip, row, _shortened(found.names[robot]), darker(colours[robot]))


def _name_row(strip: Axes, row: int, name: str, colour: Colour) -> None:
    strip.annotate(
        name,
        (0, row),
        (-4, 0),
        xycoords=("axes fraction", "data"),
        textcoords="offset points",
        ha="right",
        va="center_baseline",
        fontsize=NAME_SIZE,
        color=colour,
        annotation_clip=False,
        parse_math=False,
    )


def _shortened(name: str) -> str:
    return name if len(name) <= LONGEST_NAME else name[: LONGEST_NAME - 1] + "…"


def _apart(found: Contacts) -> Flags:
    """(m,) whether the team is not connected during each piece."""
    return np.asarray((found.fiedler == 0) & (found.present.sum(axis=1) > 1), dtype=np.bool_)


def _cuts(found: Contacts, until: float) -> dict[int, FloatArray]:
    """Return for each robot that is a cut vertex before that time the stretches of time, (k, 2) seconds."""
    return {k: np.minimum(times, until) for k, times in cut_times(found).items() if times[0, 0] < until}
