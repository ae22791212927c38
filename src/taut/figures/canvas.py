"""Sheets of paper: figures of the right size for a piece of the plane, and the scale they are drawn at."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from matplotlib.axes import Axes
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure
from matplotlib.ticker import MaxNLocator, StrMethodFormatter

from taut.errors import OutputError
from taut.figures.style import OUTSIDE, QUIET
from taut.scene import FloatArray

MARGIN = 0.025  # of the larger side of what is shown
RIGHT, BOTTOM, TOP = 0.18, 0.5, 0.36  # inches round the map; on the left as the numbers need
SMALLEST = 2.6  # inches: a corridor still gets a map this wide and 0.4 of it high
FARTHEST = 1e70  # metres
SHARPEST = 1e-11  # width of a picture as a share of its coordinates: below that, doubles have no room for ticks


@dataclass(frozen=True)
class View:
    """The rectangle of the plane that is shown: metres, x0 < x1 and y0 < y1."""

    x0: float
    y0: float
    x1: float
    y1: float

    @property
    def width(self) -> float:
        """Metres from left to right."""
        return self.x1 - self.x0

    @property
    def height(self) -> float:
        """Metres from bottom to top."""
        return self.y1 - self.y0


def view_of(points: FloatArray) -> View:
    """Return the view that shows all points (n, 2) with a small margin.

    Raises
    ------
    OutputError
        They reach so far, or lie so close together so far out, that no picture can show them.
    """
    if len(points) == 0:
        return View(0.0, 0.0, 1.0, 1.0)
    low, high = points.min(axis=0), points.max(axis=0)
    largest = float(np.abs(points).max())
    if not largest < FARTHEST:
        raise OutputError(f"cannot be drawn: coordinates reach {largest:.3g} m")
    size = float((high - low).max())
    if 0 < size < max(SHARPEST * largest, 1 / FARTHEST):
        raise OutputError(f"cannot be drawn: {size:.3g} m across at coordinates of {largest:.3g} m")
    pad = size * MARGIN if size > 0 else max(1.0, float(np.abs(low).max()) * 1e-3)
    return View(*(float(v) for v in (*(low - pad), *(high + pad))))


def sheet(view: View, width: float = 8.0, height: float = 7.0) -> Axes:
    """Return axes for `view` on a new figure at most `width` inches wide with a map at most `height` inches high.

    The figure has an Agg canvas of its own; pyplot and its backends are not touched.
    """
    left = 0.3 + 0.08 * max(len(f"{y:.10g}") for y in MaxNLocator(9).tick_values(view.y0, view.y1)[1:-1])
    across = width - left - RIGHT
    down = across * view.height / view.width
    if down > height:
        across, down = max(height * view.width / view.height, min(SMALLEST, across)), height
    down = max(down, 0.4 * min(SMALLEST, across))
    whole, high = across + left + RIGHT, down + BOTTOM + TOP
    figure = Figure(figsize=(whole, high), facecolor="white")
    FigureCanvasAgg(figure)
    axes: Axes = figure.add_axes((left / whole, BOTTOM / high, across / whole, down / high))
    show(axes, _widened(view, across / down, across / down))
    return axes


def show(axes: Axes, view: View) -> None:
    """Set the limits, equal scale, metres and the thin frame."""
    box = axes.get_window_extent()
    # grey beside a long corridor reads better than a sliver of a map
    view = _widened(view, min(0.25, box.width / box.height), max(4.0, box.width / box.height))
    axes.set_xlim(view.x0, view.x1)
    axes.set_ylim(view.y0, view.y1)
    axes.set_aspect("equal", adjustable="box")
    axes.apply_aspect()
    box = axes.get_window_extent()
    axes.set_facecolor(OUTSIDE)
    axes.set_axisbelow(True)
    inches = (box.width / axes.figure.dpi, box.height / axes.figure.dpi)
    for axis, length in zip((axes.xaxis, axes.yaxis), inches, strict=True):
        axis.set_major_locator(MaxNLocator(max(2, min(9, int(length * 1.6))), steps=[1, 2, 5, 10]))
        axis.set_major_formatter(StrMethodFormatter("{x:.10g}"))
    axes.tick_params(length=2.5, width=0.6, color=QUIET, labelcolor=QUIET, labelsize=7.5, pad=2.5)
    for spine in axes.spines.values():
        spine.set_linewidth(0.6)
        spine.set_color(QUIET)
    axes.annotate(
        "metres",
        (1, 0),
        (0, -17.5),
        xycoords="axes fraction",
        textcoords="offset points",
        ha="right",
        va="top",
        fontsize=7.5,
        color=QUIET,
    )


def points_per_metre(axes: Axes) -> float:
    """Return the scale of the axes as they are now: typographic points (1/72 inch) per metre."""
    x0, x1 = axes.get_xlim()
    return float(axes.get_window_extent().width / axes.figure.dpi * 72 / abs(x1 - x0))


def to_points(axes: Axes, places: FloatArray) -> FloatArray:
    """Return metres (n, 2) as typographic points from the lower left corner of the axes."""
    x0, y0 = min(axes.get_xlim()), min(axes.get_ylim())
    return np.asarray((places.reshape(-1, 2) - (x0, y0)) * points_per_metre(axes), dtype=np.float64)


def size_in_points(axes: Axes) -> tuple[float, float]:
    """Return width and height of the axes in typographic points."""
    box = axes.get_window_extent()
    return float(box.width / axes.figure.dpi * 72), float(box.height / axes.figure.dpi * 72)


def _widened(view: View, least: float, most: float) -> View:
    """Return the view with as much added on two sides as makes its width / height at least and at most that."""
    wide = max(view.width, view.height * least) - view.width
    high = max(view.height, view.width / most) - view.height
    return View(view.x0 - wide / 2, view.y0 - high / 2, view.x1 + wide / 2, view.y1 + high / 2)
