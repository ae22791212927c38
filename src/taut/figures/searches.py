"""Searches step by step: a picture of one step, a file for each, an animation."""

from __future__ import annotations

import os
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from itertools import pairwise
from pathlib import Path
from typing import Any

import numpy as np
from matplotlib.artist import Artist
from matplotlib.axes import Axes
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.collections import LineCollection
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.patheffects import withStroke
from numpy.typing import ArrayLike
from scipy.spatial import cKDTree

from taut.errors import OutputError
from taut.figures.canvas import View, points_per_metre, size_in_points, to_points, view_of
from taut.figures.labels import text_size
from taut.figures.movies import Frame, Palette, find_encoder, write_gif, write_mp4
from taut.figures.pictures import handle, write_legend
from taut.figures.saving import NO_STAMPS, any_letters, check_kind
from taut.figures.style import GOAL, GRAPH, INK, QUIET, START, Colour, darker, mix
from taut.graph.core import Floats, Graph
from taut.graph.tracing import State, Trace
from taut.writing import replacing

VISITED: Colour = "#332288"  # indigo
ACTIVE: Colour = "#e08e00"  # orange: the frontier, and edges in progress
NAMES = {"dijkstra": "Dijkstra", "astar": "A*", "breadth-first": "Breadth first", "depth-first": "Depth first"}
FEW = 40  # up to this many vertices carry names and distances
SPARSE = 30  # up to this many edges carry weights, and ∞ is written too
LARGEST, SMALLEST = 12.0, 8.5  # points: radius of a vertex that holds its name
HALO = 1.5  # radii of a vertex
ALONG = (0.5, 0.42, 0.58, 0.34, 0.66, 0.27, 0.73)  # where on its edge a weight may stand, best first
FRAMES = 400  # longer searches are shown with some steps left out
LONGEST = 20.0  # seconds of animation, by default
HOLD = 2.5  # seconds that the last frame stays
DPI = 100


def draw_step(axes: Axes, graph: Graph, positions: ArrayLike, trace: Trace, k: int) -> None:
    """Draw a search after its first k steps.

    Visited vertices are filled, those of the frontier orange; the vertex just visited has a halo, and the edges relaxed
    from it are orange. Once the target is visited the path is green. Up to 40 vertices carry names and distances, and
    up to 30 edges weights, if there is room.

    Parameters
    ----------
    axes : where to draw; axes that already show something, a map for instance, keep their view.
    graph, positions : what was searched, and the places (n, 2) of its vertices.
    trace : the search.
    k : how many steps are done, 0 … ``len(trace.steps)``.

    Raises
    ------
    IndexError
        The search has no such step.
    ValueError
        The trace is of another graph, or the positions are not (n, 2) finite numbers.
    OutputError
        Coordinates with which no picture can be made.
    """
    look = _look(axes, graph, _places(graph, positions, trace), trace)
    state = trace.state(k)
    _draw_ground(axes, look)
    _draw_state(axes, look, state)


def save_steps(graph: Graph, positions: ArrayLike, trace: Trace, folder: str | os.PathLike[str]) -> list[Path]:
    """Write one picture a step, ``step-1.png`` and so on, and return their paths.

    Numbers have leading zeros where others are longer. The folder is made if need be. The same search gives the same
    bytes.

    Raises
    ------
    ValueError
        As `draw_step`.
    OutputError
        A folder that cannot be written, or coordinates with which no picture can be made.
    """
    places = _places(graph, positions, trace)
    home = Path(folder)
    try:
        home.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise OutputError(f"{home}: cannot be written: {error.strerror}") from None
    count = len(trace.steps)
    paths = [home / f"step-{k:0{len(str(count))}d}.png" for k in range(1, count + 1)]
    for k, path in enumerate(paths, start=1):
        axes = _sheet(places, 8.0)
        draw_step(axes, graph, places, trace, k)
        figure: Any = axes.figure
        with replacing(path) as scratch:
            figure.savefig(scratch, format="png", dpi=150, metadata=NO_STAMPS["png"])
    return paths


def animate_search(
    graph: Graph,
    positions: ArrayLike,
    trace: Trace,
    path: str | os.PathLike[str],
    *,
    fps: float | None = None,
    width: int = 720,
) -> None:
    """Show a search step by step as a .gif, or as an .mp4 if ffmpeg is installed.

    Parameters
    ----------
    graph, positions, trace : as for `draw_step`.
    path : file to write, .gif or .mp4.
    fps : steps a second; by default 1, or as many more as end the search in 20 s. Of more than 400 steps some are left
        out.
    width : of the picture in pixels.

    Raises
    ------
    ValueError
        As `draw_step`.
    OutputError
        Another extension, no ffmpeg, a place that cannot be written, numbers that make no film or no picture.
    """
    places = _places(graph, positions, trace)
    target = Path(path)
    kind = check_kind(target, ("gif", "mp4"), "animations are written as")
    last = len(trace.steps)
    shown = np.unique(np.linspace(0, last, min(last + 1, FRAMES)).round().astype(np.int64)).tolist()
    if fps is None:
        fps = max(1.0, len(shown) / LONGEST)
    if not (0 < fps <= 100 and width >= 160):
        raise OutputError("an animation needs fps in (0, 100] and width ≥ 160 pixels")
    encoder = find_encoder(target) if kind == "mp4" else ""
    axes = _sheet(places, width / DPI)
    look = _look(axes, graph, places, trace)
    with any_letters(), replacing(target) as scratch:
        render = _stage(axes, look)
        frames = (render(k) for k in shown)
        if encoder:
            write_mp4(scratch, frames, fps, HOLD, encoder)
        else:
            some = [render(shown[j]) for j in sorted({0, len(shown) // 2, len(shown) - 1})]
            exact = [VISITED, ACTIVE, GRAPH, START, GOAL, INK, QUIET, "#ffffff"]
            write_gif(scratch, frames, len(shown), fps, HOLD, Palette(some, exact))


@dataclass(frozen=True)
class _Look:
    """What is the same in all pictures of one search on one sheet."""

    graph: Graph
    places: Floats  # (n, 2)
    trace: Trace
    radius: float  # of a vertex, points
    labelled: bool  # room for names and numbers
    asides: Floats  # (n, 2) unit vectors towards the number beside each vertex


def _places(graph: Graph, positions: ArrayLike, trace: Trace) -> Floats:
    places = np.asarray(positions, dtype=np.float64)
    if places.shape != (graph.n, 2) or not np.isfinite(places).all():
        raise ValueError(f"positions must be {graph.n} pairs of finite numbers, got an array of shape {places.shape}")
    if not (np.array_equal(graph.indptr, trace.graph.indptr) and np.array_equal(graph.indices, trace.graph.indices)):
        raise ValueError("the trace is of another graph: draw it with the graph that was searched")
    return places


def _sheet(places: Floats, width: float) -> Axes:
    """Return empty axes without a frame on a new figure that many inches wide; pyplot is not touched."""
    view = _view(places)
    high = float(np.clip(width * view.height / view.width, 0.35 * width, 0.85 * width))
    whole = high + 0.85
    figure = Figure(figsize=(width, whole), dpi=DPI, facecolor="white")
    FigureCanvasAgg(figure)
    axes: Axes = figure.add_axes((0.1 / width, 0.48 / whole, 1 - 0.2 / width, high / whole))
    return axes


def _look(axes: Axes, graph: Graph, places: Floats, trace: Trace) -> _Look:
    if axes.get_autoscale_on():
        _show(axes, _view(places))
    room = np.inf
    if graph.n > 1:
        room = float(np.quantile(_nearest(places), 0.1)) * points_per_metre(axes)
    radius = min(LARGEST, 0.36 * room)
    labelled = graph.n <= FEW and radius >= SMALLEST
    if not labelled:
        radius = float(np.clip(0.36 * room, 1.2, 4.5 if graph.n <= 400 else 3.0))
    return _Look(graph, places, trace, radius, labelled, _asides(graph, places))


def _view(places: Floats) -> View:
    """Return the view that shows all places with room for marks and numbers."""
    view = view_of(places)
    pad = (0.09 if len(places) <= FEW else 0.04) * max(view.width, view.height)
    return View(view.x0 - pad, view.y0 - pad, view.x1 + pad, view.y1 + pad)


def _show(axes: Axes, view: View) -> None:
    """Set limits and an equal scale, and hide the frame: the places of a graph need not be in metres."""
    box = axes.get_window_extent()
    half = max(view.width / box.width, view.height / box.height) / 2
    x, y = (view.x0 + view.x1) / 2, (view.y0 + view.y1) / 2
    axes.set(xlim=(x - half * box.width, x + half * box.width), ylim=(y - half * box.height, y + half * box.height))
    axes.set_aspect("equal")
    axes.set_axis_off()


def _nearest(places: Floats) -> Floats:
    distances: Any = cKDTree(places).query(places, 2)[0]
    return np.asarray(distances[:, 1], dtype=np.float64)


def _asides(graph: Graph, places: Floats) -> Floats:
    """Return for each vertex the direction in which its edges leave most room, (n, 2); the same in every step."""
    out = np.tile([0.0, 1.0], (graph.n, 1))
    for v in range(graph.n):
        ways = places[graph.indices[graph.indptr[v] : graph.indptr[v + 1]]] - places[v]
        if len(ways):
            angles = np.sort(np.arctan2(ways[:, 1], ways[:, 0]))
            gaps = np.diff(angles, append=angles[0] + 2 * np.pi)
            middle = angles[gaps.argmax()] + gaps.max() / 2
            out[v] = np.cos(middle), np.sin(middle)
    return out


def _draw_ground(axes: Axes, look: _Look) -> None:
    """Draw what lies under every step: edges, and the legend."""
    crowd = look.graph.m / max(look.graph.n, 1)
    width = 1.1 if look.labelled else float(np.clip(2.4 / max(crowd, 1), 0.25, 0.8))
    _lines(axes, look, look.graph.edges.tolist(), GRAPH, width, 2.5)
    _legend(axes, look)


def _draw_state(axes: Axes, look: _Look, state: State) -> list[Artist]:
    """Draw a step over the ground; return what was drawn from the lowest to the highest, the titles last."""
    trace, k = look.trace, len(state.visited)
    step = trace.steps[k - 1] if k else None
    path = trace.path if k == len(trace.steps) else []
    tree = [(int(state.before[v]), v) for v in state.visited if state.before[v] >= 0]
    frontier = [v for v, _ in state.frontier]
    waiting = [(int(state.before[v]), v) for v in frontier if state.before[v] >= 0]
    relaxed = [(step.vertex, v) for v, _, _ in step.relaxed] if step else []
    thick = 1.0 if look.labelled else 0.6
    artists: list[Artist] = [
        _lines(axes, look, waiting, mix(ACTIVE, "#ffffff", 0.45), 1.6 * thick, 3),
        _lines(axes, look, tree, VISITED, 2.2 * thick, 3.2),
        _lines(axes, look, relaxed, ACTIVE, 3.4 * thick, 3.4),
        _lines(axes, look, list(pairwise(path)), GOAL, 5.0 * thick, 3.6),
    ]
    if look.labelled and look.graph.m <= SPARSE:
        artists += _write_weights(axes, look)
    if step:
        halo = HALO if look.labelled else 2.2
        artists.append(_dots(axes, look, [step.vertex], mix(ACTIVE, "#ffffff", 0.35), "none", halo, 4))
    unseen = np.flatnonzero(np.isinf(state.distances)).tolist()
    artists += [
        _dots(axes, look, unseen, "white", GRAPH, 1.0 if look.labelled else 0.8, 5),
        _dots(axes, look, frontier, mix(ACTIVE, "#ffffff", 0.72) if look.labelled else ACTIVE, ACTIVE, 1.0, 5.1),
        _dots(axes, look, [v for v in state.visited if v not in path], VISITED, VISITED, 1.0, 5.2),
        _dots(axes, look, path, darker(GOAL), darker(GOAL), 1.0, 5.3),
        *_ends(axes, look, set(state.visited)),
    ]
    if look.labelled:
        artists += _write_names(axes, look, state)
        artists += _write_distances(axes, look, state)
    return [*artists, *_title(axes, look, state, path)]


def _lines(
    axes: Axes, look: _Look, edges: Sequence[Sequence[int]], colour: Colour, width: float, zorder: float
) -> LineCollection:
    pairs = look.places[np.array(edges, dtype=np.int64).reshape(-1, 2)]
    lines = LineCollection(list(pairs), colors=colour, linewidths=width, zorder=zorder)
    lines.set_capstyle("round")
    axes.add_collection(lines, autolim=False)
    return lines


def _dots(
    axes: Axes, look: _Look, vertices: Sequence[int], face: Colour, edge: Colour, size: float, zorder: float
) -> Artist:
    places = look.places[np.array(vertices, dtype=np.int64)]
    area = 4 * (size * look.radius) ** 2
    width = 1.4 if look.labelled else 0.6
    return axes.scatter(
        places[:, 0], places[:, 1], s=area, facecolors=face, edgecolors=edge, linewidths=width, zorder=zorder
    )


def _ends(axes: Axes, look: _Look, visited: set[int]) -> list[Artist]:
    """Mark source and target: rings round vertices with names, else marks as on maps."""
    ends = [(look.trace.source, START, "o")]
    if look.trace.target is not None:
        ends.append((look.trace.target, GOAL, "D"))
    out: list[Artist] = []
    for v, colour, marker in ends:
        x, y = look.places[v].tolist()
        if look.labelled:
            ring = 4 * (look.radius + 2.2) ** 2
            out.append(axes.scatter(x, y, s=ring, facecolors="none", edgecolors=colour, linewidths=1.8, zorder=6))
        else:
            out.append(axes.scatter(x, y, s=40, c=colour, marker=marker, edgecolors="white", linewidths=0.7, zorder=6))
    return out


def _write_names(axes: Axes, look: _Look, state: State) -> list[Artist]:
    visited = set(state.visited)
    font: dict[str, Any] = {
        "fontsize": 0.74 * look.radius,
        "fontweight": "bold",
        "ha": "center",
        "va": "center_baseline",
    }
    return [
        axes.text(x, y, f"v{v + 1}", color="white" if v in visited else INK, zorder=7, **font)
        for v, (x, y) in enumerate(look.places.tolist())
    ]


def _write_distances(axes: Axes, look: _Look, state: State) -> list[Artist]:
    """Write each vertex' distance beside it; one that has just changed with what it was."""
    fresh: dict[int, float] = {}
    if state.visited:
        fresh = {v: old for v, old, _ in look.trace.steps[len(state.visited) - 1].relaxed}
    visited, out = set(state.visited), []
    for v, distance in enumerate(state.distances.tolist()):
        if np.isinf(distance) and look.graph.m > SPARSE:
            continue
        text = _short(distance)
        if v in fresh:
            text = f"{_short(fresh[v])} → {text}"
        colour = VISITED if v in visited else darker(ACTIVE) if np.isfinite(distance) else QUIET
        out.append(_note(axes, look, v, text, colour))
    return out


def _note(axes: Axes, look: _Look, vertex: int, text: str, colour: Colour) -> Artist:
    half = np.array(text_size(text, 9.0)) / 2
    way = look.asides[vertex]
    # the box touches the halo that the vertex may have: its far side moves out by its own half size
    offset = way * (HALO * look.radius + 1.0) + half * np.clip(way * 1.6, -1, 1)
    return axes.annotate(
        text,
        tuple(look.places[vertex]),
        tuple(offset),
        textcoords="offset points",
        ha="center",
        va="center_baseline",
        fontsize=9.0,
        fontweight="bold",
        color=colour,
        path_effects=[withStroke(linewidth=2.4, foreground="white")],
        zorder=8,
    )


def _write_weights(axes: Axes, look: _Look) -> list[Artist]:
    """Write each weight on its edge where it covers fewest vertices, distances and other weights."""
    spots = to_points(axes, look.places)
    taken = [(spot, look.radius + 8) for spot in spots]
    taken += [(spot, 13.0) for spot in spots + look.asides * (HALO * look.radius + 6)]
    out: list[Artist] = []
    for (a, b), weight in zip(look.graph.edges.tolist(), look.graph.lengths.tolist(), strict=True):
        places = [spots[a] + t * (spots[b] - spots[a]) for t in ALONG]
        clashes = [sum(bool(np.hypot(*(p - q)) < reach) for q, reach in taken) for p in places]
        best = int(np.argmin(clashes))
        taken.append((places[best], 13.0))
        x, y = look.places[a] + ALONG[best] * (look.places[b] - look.places[a])
        box = {"boxstyle": "round,pad=0.12", "facecolor": "white", "edgecolor": "none"}
        text = axes.text(x, y, _short(weight), fontsize=8.0, color=INK, bbox=box, zorder=3.8)
        text.set(ha="center", va="center_baseline")
        out.append(text)
    return out


def _title(axes: Axes, look: _Look, state: State, path: Sequence[int]) -> list[Artist]:
    trace, k = look.trace, len(state.visited)
    left = f"{NAMES[trace.method]}, step {k} of {len(trace.steps)}" if k else f"{NAMES[trace.method]}, at the start"
    facts = [f"{k} visited · {len(state.frontier)} in the frontier"]
    if k:
        step = trace.steps[k - 1]
        facts.insert(0, f"v{step.vertex + 1} is visited, {_measure(trace, 'distance', step.distance)} · {facts[0]}")
    if path:
        size = _measure(trace, "length", trace.distance)
        facts = [f"{' → '.join(f'v{v + 1}' for v in path)} · {size}", f"path of {len(path)} vertices · {size}"]
    elif k == len(trace.steps) and trace.target is not None:
        facts = [f"no path from v{trace.source + 1} to v{trace.target + 1}"]
    room = size_in_points(axes)[0] - text_size(left, 10.5)[0]
    fits = next((text for text in facts if text_size(text, 8.5)[0] * 0.85 < room), "")
    return [
        axes.set_title(left, loc="left", fontsize=10.5, fontweight="bold", color=INK, pad=7, parse_math=False),
        axes.set_title(fits, loc="right", fontsize=8.5, color=QUIET, pad=7),
    ]


def _legend(axes: Axes, look: _Look) -> None:
    """Put a one-line legend under the axes."""
    pale = mix(ACTIVE, "#ffffff", 0.72) if look.labelled else ACTIVE
    handles = [handle("start", "o", *(("white", START) if look.labelled else (START, "white")))]
    lines = [("relaxed", ACTIVE, 3.0), ("tree", VISITED, 2.0)]
    if look.trace.target is not None:
        ring = ("o", "white", GOAL) if look.labelled else ("D", GOAL, "white")
        handles.append(handle("target", *ring))
        lines.append(("path", GOAL, 4.0))
    handles += [
        handle("visited", "o", VISITED, VISITED),
        handle("just now", "o", VISITED, mix(ACTIVE, "#ffffff", 0.35)),
    ]
    handles[-1].set_markeredgewidth(2.5)
    handles.append(handle("frontier", "o", pale, ACTIVE))
    handles += [Line2D([], [], color=colour, linewidth=width, label=label) for label, colour, width in lines]
    write_legend(axes, handles)


def _stage(axes: Axes, look: _Look) -> Callable[[int], Frame]:
    """Draw the background once and return the function that renders step k over it."""
    _draw_ground(axes, look)
    canvas: Any = axes.figure.canvas  # the stubs leave its methods without types
    canvas.draw()
    background = canvas.copy_from_bbox(axes.figure.bbox)

    def render(k: int) -> Frame:
        canvas.restore_region(background)
        artists = _draw_state(axes, look, look.trace.state(k))
        for artist in artists:
            axes.draw_artist(artist)
        for artist in artists[:-2]:  # the two titles belong to the axes
            artist.remove()
        picture = np.asarray(canvas.buffer_rgba())
        # video wants even sides
        return picture[: picture.shape[0] // 2 * 2, : picture.shape[1] // 2 * 2].copy()

    return render


def _measure(trace: Trace, word: str, value: float) -> str:
    """Return a distance in the unit of the method."""
    if trace.method in ("dijkstra", "astar"):
        return f"{word} {_short(value)}"
    return f"{value:.0f} {'edge' if value == 1 else 'edges'} from the start"


def _short(value: float) -> str:
    return "∞" if np.isinf(value) else f"{value:.4g}"
