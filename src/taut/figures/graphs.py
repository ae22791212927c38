"""Graphs on their maps, vertices coloured by the Fiedler vector, beside their spectra and Laplacians."""

from __future__ import annotations

import os
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import matplotlib as mpl
import numpy as np
from matplotlib.axes import Axes
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.cm import ScalarMappable
from matplotlib.collections import LineCollection
from matplotlib.colors import Normalize, to_rgb
from matplotlib.figure import Figure
from matplotlib.ticker import MaxNLocator
from numpy.typing import ArrayLike
from scipy.spatial import cKDTree

from taut.figures._graph_kernels import crossings
from taut.figures.canvas import View, points_per_metre, show, size_in_points, to_points, view_of
from taut.figures.labels import Label, text_size, write
from taut.figures.maps import draw_free_space, scene_view
from taut.figures.pictures import handle
from taut.figures.saving import NO_STAMPS, any_letters, check_kind
from taut.figures.spectra import BINS, DIVERGING, MANY_CELLS, draw_matrix, draw_sorted, draw_spectrum, short, tints
from taut.figures.style import GOAL, INK, QUIET, START, Colour
from taut.freespace import FreeSpace
from taut.graph.core import Floats, Graph
from taut.graph.matrices import laplacian
from taut.scene import Point
from taut.writing import replacing

FEW_VERTICES = 40  # up to this many are numbered
FEW_EDGES = 60  # up to this many carry their weights
MANY_EDGES = 4000  # more are drawn as a density
PIXELS = 1.8  # of that density, a point
FARTHEST = 20.0  # widths of the picture
DARKEST = 0.75  # its opacity where most edges pass
LARGEST, SMALLEST = 11.0, 8.0  # points: radius of a vertex that holds its number
LEAST_END = 3.0  # points: radius of a start or goal
ASIDE = 16.0  # points between vertices from which on numbers find room beside them
ALONG = (0.5, 0.42, 0.58, 0.34, 0.66, 0.27, 0.73)  # where on its edge a weight may stand, best first

WIDTH = 11.4  # inches of the whole figure
BELOW = 0.85  # inches under a map: ticks, colour bar
ABOVE = 0.42  # inches over a map: title
PANEL = 3.0  # inches: side of the matrix
WIDE = 1.5  # maps wider than so many heights have their panels below, not beside


@dataclass(frozen=True, eq=False)
class Portrait:
    """A graph on its map and what is known of its spectrum: one row of a figure.

    Parameters
    ----------
    graph : weights as in λ2.
    positions : (n, 2) metres.
    fiedler : (n,) Fiedler vector, or zeros where there is none.
    spectrum : (n,) all eigenvalues, ascending; empty if they are not known.
    title, facts : over the map, left and right.
    starts, goals : vertices of starts and goals.
    freespace : drawn under the graph; None for a graph without a map.
    """

    graph: Graph
    positions: Floats
    fiedler: Floats
    spectrum: Floats
    title: str = ""
    facts: str = ""
    starts: tuple[int, ...] = ()
    goals: tuple[int, ...] = ()
    freespace: FreeSpace | None = None


def draw_portraits(portraits: Sequence[Portrait]) -> Figure:
    """Draw graphs, one a row: the graph on its map, its spectrum and its Laplacian.

    Where the spectrum is not known the entries of the Fiedler vector stand in its place, in ascending order.

    Raises
    ------
    OutputError
        Coordinates with which no picture can be made.
    """
    views = [_view(portrait) for portrait in portraits]
    plans = [_row_plan(view) for view in views]
    whole = sum(plan.height for plan in plans)
    figure = Figure(figsize=(WIDTH, max(whole, 1.0)), facecolor="white")
    FigureCanvasAgg(figure)
    top = whole
    for portrait, view, plan in zip(portraits, views, plans, strict=True):
        top -= plan.height
        boxes = [(x / WIDTH, (top + y) / whole, w / WIDTH, h / whole) for x, y, w, h in plan.boxes]
        _draw_row(figure, portrait, view, boxes)
    return figure


def save_portraits(portraits: Sequence[Portrait], path: str | os.PathLike[str]) -> None:
    """Draw graphs (see `draw_portraits`) into a .png (200 dpi), .svg or .pdf file; the same graphs give the same bytes.

    Raises
    ------
    OutputError
        Another extension, a place that cannot be written, coordinates with which no picture can be made.
    """
    target = Path(path)
    kind = check_kind(target, tuple(NO_STAMPS), "pictures are written as")
    fonts: Any = {"svg.hashsalt": "taut", "svg.fonttype": "path", "pdf.fonttype": 42}
    with replacing(target) as scratch, any_letters(), mpl.rc_context(fonts):
        draw_portraits(portraits).savefig(scratch, format=kind, dpi=200, metadata=NO_STAMPS[kind])


def draw_values(
    axes: Axes,
    graph: Graph,
    positions: ArrayLike,
    values: ArrayLike,
    starts: Sequence[int] = (),
    goals: Sequence[int] = (),
) -> None:
    """Draw a graph with its vertices coloured by their values: indigo negative, white zero, orange positive.

    Up to 40 vertices are numbered, and up to 60 edges carry their weights unless all are equal.

    Parameters
    ----------
    axes : where to draw; axes that already show something, a map for instance, keep their view.
    positions : (n, 2) metres.
    values : (n,) such as a Fiedler vector.
    starts, goals : vertices that get a red or green rim.

    Raises
    ------
    ValueError
        Positions or values of another shape, or not finite.
    OutputError
        Coordinates with which no picture can be made.
    """
    places = _checked(positions, (graph.n, 2), "positions")
    shades = _checked(values, (graph.n,), "values")
    if axes.get_autoscale_on():
        show(axes, view_of(places))
        axes.set_facecolor("white")
    radius = _radius(axes, places)
    _draw_edges(axes, graph, places)
    _draw_vertices(axes, places, shades, radius, starts, goals)
    weights = graph.lengths
    if 0 < graph.m <= FEW_EDGES and np.ptp(weights) > 0:
        _write_weights(axes, graph, places, radius)


@dataclass(frozen=True)
class _RowPlan:
    """Where things stand in a row, in inches: (left, bottom, width, height) of map, spectrum and matrix."""

    height: float
    boxes: tuple[tuple[float, float, float, float], ...]


def _view(portrait: Portrait) -> View:
    if portrait.freespace is not None:
        return scene_view(portrait.freespace.scene)
    return view_of(portrait.positions)


def _row_plan(view: View) -> _RowPlan:
    """Place the panels beside the map, or below it if it is wide."""
    left = 0.35 + 0.08 * max(len(f"{y:.10g}") for y in MaxNLocator(9).tick_values(view.y0, view.y1)[1:-1])
    wide = view.width > WIDE * view.height
    across = WIDTH - left - 0.3 - (0 if wide else PANEL + 1.0)
    down = float(np.clip(across * view.height / view.width, 2.2, 7.4 if wide else 6.4))
    if wide:
        under = PANEL + 0.95
        spectrum = (left + 0.25, 0.5, across - PANEL - 1.0, PANEL)
        matrix = (left + across - PANEL, 0.5, PANEL, PANEL)
        return _RowPlan(ABOVE + down + BELOW + under, ((left, under + BELOW, across, down), spectrum, matrix))
    inner = max(down, 5.0)
    x = WIDTH - 0.3 - PANEL
    stems = inner + BELOW - 0.5 - PANEL - 0.8
    spectrum = (x, 0.5 + PANEL + 0.8, PANEL, stems)
    boxes = ((left, BELOW + inner - down, across, down), spectrum, (x, 0.5, PANEL, PANEL))
    return _RowPlan(ABOVE + inner + BELOW, boxes)


def _draw_row(
    figure: Figure, portrait: Portrait, view: View, boxes: Sequence[tuple[float, float, float, float]]
) -> None:
    graph = portrait.graph
    axes, beside, below = (figure.add_axes(box) for box in boxes)
    axes.set_anchor("NW")
    show(axes, view)
    if portrait.freespace is None:
        axes.set_facecolor("white")
    else:
        draw_free_space(axes, portrait.freespace.region, portrait.freespace.scene)
    draw_values(axes, graph, portrait.positions, portrait.fiedler, portrait.starts, portrait.goals)
    left, bottom, wide, high = boxes[0]
    _title(figure, (left, bottom + high), left + wide, portrait.title, portrait.facts)
    _colour_bar(figure, (left, bottom), portrait.fiedler)
    _legend(axes, figure, (left + wide, bottom), portrait)
    if graph.n == 0:
        beside.set_axis_off()
        below.set_axis_off()
        return
    if len(portrait.spectrum) == graph.n:
        draw_spectrum(beside, portrait.spectrum)
        _head(beside, "Eigenvalues of the Laplacian")
    else:
        draw_sorted(beside, portrait.fiedler)
        _head(beside, "Fiedler vector, sorted")
    draw_matrix(below, laplacian(graph))
    dense = graph.n > MANY_CELLS
    _head(below, f"Laplacian, {BINS} × {BINS} blocks by density" if dense else "Laplacian")


def _checked(values: ArrayLike, shape: tuple[int, ...], name: str) -> Floats:
    given = np.asarray(values, dtype=np.float64)
    if given.size == 0:
        given = given.reshape((0, *shape[1:]))
    if given.shape != shape or not np.isfinite(given).all():
        raise ValueError(f"{name} must be finite numbers of shape {shape}, got an array of shape {given.shape}")
    return given


def _radius(axes: Axes, places: Floats) -> float:
    """Return how large vertices are drawn, in points: with room for a number if they are few and lie far apart."""
    room = 0.4 * _spacing(axes, places)
    if len(places) <= FEW_VERTICES and room >= SMALLEST:
        return min(LARGEST, room)
    few = len(places) <= 2 * FEW_VERTICES
    return float(np.clip(room, 2.6 if few else 1.1, 5.0 if few else 2.2))


def _spacing(axes: Axes, places: Floats) -> float:
    """Return how far apart vertices mostly are, in points."""
    if len(places) < 2:
        return np.inf
    nearest: Any = cKDTree(places).query(places, 2)[0]
    return float(np.quantile(nearest[:, 1], 0.1)) * points_per_metre(axes)


def _draw_edges(axes: Axes, graph: Graph, places: Floats) -> None:
    ends = places[graph.edges]
    if graph.m > MANY_EDGES:
        _draw_density(axes, ends)
        return
    width = float(np.clip(14 / np.sqrt(graph.m + 1), 0.25, 1.1))
    alpha = float(np.clip(22 / np.sqrt(graph.m + 1), 0.2, 0.75))
    lines = LineCollection(list(ends), colors=QUIET, linewidths=width, alpha=alpha, zorder=3)
    axes.add_collection(lines, autolim=False)


def _draw_density(axes: Axes, ends: Floats) -> None:
    """Draw segments, (m, 2, 2) metres, as a picture that is the darker the more of them pass: lines would be a blot."""
    (x0, x1), (y0, y1) = axes.get_xlim(), axes.get_ylim()
    wide, high = (int(np.ceil(points * PIXELS)) for points in size_in_points(axes))
    pixels = (ends - (x0, y0)) * (wide / (x1 - x0), high / (y1 - y0))
    # a place far outside the picture would take its edges for ever
    near = np.clip(pixels, -FARTHEST * wide, FARTHEST * wide).reshape(-1, 4)
    counts = crossings(np.ascontiguousarray(near), wide, high)
    passing = np.log1p(counts)
    fog = np.empty((high, wide, 4))
    fog[..., :3] = to_rgb(QUIET)
    fog[..., 3] = DARKEST * passing / max(passing.max(), 1.0)
    axes.imshow(fog, extent=(x0, x1, y0, y1), origin="lower", interpolation="nearest", aspect="equal", zorder=3)


def _draw_vertices(
    axes: Axes, places: Floats, values: Floats, radius: float, starts: Sequence[int], goals: Sequence[int]
) -> None:
    numbered, many = radius >= SMALLEST, len(places) > 2 * FEW_VERTICES
    faces, strengths = tints(values), np.abs(values)
    # in a crowd the vertices that stand out are drawn larger, and over the others
    radii = radius * (1 + many * strengths / (strengths.max(initial=0.0) or 1.0))
    ends = [*starts, *goals]
    radii[ends] = np.maximum(radii[ends], LEAST_END)
    for vertices, marker, colour in ((list(goals), "D", GOAL), (list(starts), "o", START)):
        at, area = places[vertices], (2 * (radii[vertices] + 2.0)) ** 2
        axes.scatter(at[:, 0], at[:, 1], s=area, marker=marker, color=colour, linewidths=0, zorder=4.8, clip_on=False)
    order = np.argsort(strengths, kind="stable")
    rim: dict[str, Any] = {"edgecolors": INK, "linewidths": 1.0 if numbered else 0.6}
    if many:
        rim = {"edgecolors": QUIET, "linewidths": 0.15 * min(radius, 2.0)}
    colours, at, area = [faces[v] for v in order.tolist()], places[order], (2 * radii[order]) ** 2
    axes.scatter(at[:, 0], at[:, 1], s=area, c=colours, zorder=5, clip_on=False, **rim)
    if numbered:
        for v, (x, y) in enumerate(places.tolist()):
            font: dict[str, Any] = {"fontsize": 0.7 * radius, "fontweight": "bold", "ha": "center"}
            axes.text(x, y, f"v{v + 1}", color=_readable_on(faces[v]), va="center_baseline", zorder=7, **font)
    elif 0 < len(places) <= FEW_VERTICES and _spacing(axes, places) >= ASIDE:
        marks = [((float(x), float(y)), radius) for x, y in places]
        labels = [Label(f"v{v + 1}", at, radius + 1, INK, size=6.5, weight="normal") for v, (at, _) in enumerate(marks)]
        write(axes, labels, marks, np.empty((0, 2)))


def _readable_on(face: Colour) -> Colour:
    red, green, blue = (int(face[k : k + 2], 16) for k in (1, 3, 5))
    return "#ffffff" if 0.3 * red + 0.59 * green + 0.11 * blue < 125 else INK


def _write_weights(axes: Axes, graph: Graph, places: Floats, radius: float) -> None:
    """Write each weight on its edge, if there is a place where it covers no vertex and no other weight."""
    spots = to_points(axes, places)
    taken = [(spot, radius + 7.0) for spot in spots]
    for (a, b), weight in zip(graph.edges.tolist(), graph.lengths.tolist(), strict=True):
        choices = [spots[a] + t * (spots[b] - spots[a]) for t in ALONG]
        free = [k for k, p in enumerate(choices) if all(np.hypot(*(p - q)) >= reach for q, reach in taken)]
        if not free:
            continue
        taken.append((choices[free[0]], 13.0))
        axes.annotate(
            short(weight),
            tuple(places[a] + ALONG[free[0]] * (places[b] - places[a])),
            ha="center",
            va="center_baseline",
            fontsize=7.0,
            color=INK,
            bbox={"boxstyle": "round,pad=0.12", "facecolor": "white", "edgecolor": "none", "alpha": 0.85},
            zorder=4.5,
        )


def _title(figure: Figure, corner: Point, right: float, name: str, facts: str) -> None:
    up = corner[1] + 0.1 / figure.get_figheight()
    figure.text(corner[0], up, name, fontsize=10.5, fontweight="bold", color=INK, parse_math=False)
    room = (right - corner[0]) * figure.get_figwidth() * 72
    if text_size(name, 10.5)[0] + 0.85 * text_size(facts, 8.5)[0] < room:
        figure.text(right, up, facts, fontsize=8.5, color=QUIET, ha="right", parse_math=False)


def _head(axes: Axes, text: str) -> None:
    axes.set_title(text, loc="left", fontsize=9, fontweight="bold", color=INK, pad=6)


def _colour_bar(figure: Figure, corner: Point, values: Floats) -> None:
    """Put the scale of the colours under the map, on the left."""
    largest = float(np.abs(values).max(initial=0.0))
    if largest == 0:
        return
    wide, high = figure.get_size_inches()
    bar = figure.add_axes((corner[0], corner[1] - 0.55 / high, 1.9 / wide, 0.1 / high))
    scale = ScalarMappable(Normalize(-largest, largest), DIVERGING)
    made = figure.colorbar(scale, cax=bar, orientation="horizontal", ticks=[-largest, 0, largest])
    made.ax.set_xticklabels([f"−{largest:.2g}", "0", f"{largest:.2g}"])
    made.ax.tick_params(length=2, width=0.6, color=QUIET, labelcolor=QUIET, labelsize=7, pad=1.5)
    made.ax.spines["outline"].set(linewidth=0.6, edgecolor=QUIET)
    place: dict[str, Any] = {"xycoords": "axes fraction", "textcoords": "offset points", "fontsize": 8, "color": INK}
    bar.annotate("Fiedler vector", (1, 0.5), (7, 0), va="center", ha="left", **place)


def _legend(axes: Axes, figure: Figure, corner: Point, portrait: Portrait) -> None:
    """Put what the rims mean under the map, on the right."""
    handles = []
    for vertices, marker, colour, label in (
        (portrait.starts, "o", START, "start"),
        (portrait.goals, "D", GOAL, "goal"),
    ):
        if len(vertices):
            handles.append(handle(label, marker, "white", colour))
            handles[-1].set_markeredgewidth(1.8)
    if handles:
        axes.legend(
            handles=handles,
            loc="upper right",
            bbox_to_anchor=(corner[0], corner[1] - 0.4 / figure.get_figheight()),
            bbox_transform=figure.transFigure,
            ncols=2,
            frameon=False,
            fontsize=8,
            handletextpad=0.2,
            columnspacing=1.2,
            borderaxespad=0,
            labelcolor=INK,
        )
