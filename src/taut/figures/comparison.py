"""Ways of finding routes side by side: their roadmaps and routes on one map, their spread, their price of clearance."""

from __future__ import annotations

import math
import os
from collections import Counter
from collections.abc import Callable, Iterator, Sequence
from pathlib import Path
from typing import Any

import matplotlib as mpl
import numpy as np
import shapely
from matplotlib.axes import Axes
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.collections import LineCollection
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.patches import Patch
from matplotlib.ticker import FuncFormatter, MaxNLocator

from taut.comparison import Comparison, Entry, Trial, summary
from taut.figures.canvas import View
from taut.figures.maps import draw_map, scene_view
from taut.figures.pictures import count, end_handles
from taut.figures.plans import draw_paths, line_width
from taut.figures.saving import NO_STAMPS, any_letters, check_kind
from taut.figures.style import GOAL, GRAPH, INK, OUTSIDE, QUIET, START, Colour, darker, mix, robot_colours
from taut.figures.teams import mark_radius
from taut.route.ways import WAYS
from taut.scene import FloatArray, Scene
from taut.writing import replacing

WIDTH = 13.0  # inches of every figure
SHAPE = 1.7  # width / height that suits a slide
HEAD, FOOT, TITLE, BETWEEN, SIDE = 0.5, 0.42, 0.3, 0.14, 0.16  # inches
SHARE = 0.62  # marks of starts and goals are so much smaller than on a picture of one plan
FEW_ROBOTS = 4  # up to this many have curves of their own
MOST_DOTS = 400  # of a spread, a way
FEW_STEPS = 40  # up to this many points of a curve are marked
UNSOLVED: Colour = mix(OUTSIDE, "#ffffff", 0.35)
DASHED, DOTTED = (0, (2.5, 1.8)), (0, (1.0, 2.6))


def draw_comparison(comparison: Comparison) -> Figure:
    """Draw small multiples: for each way the map, the roadmap it built (light) and its routes in the robots' colours.

    Routes that are not allowed, or end elsewhere, are dashed. Of several roadmaps the one that serves most robots is
    shown.

    Raises
    ------
    OutputError
        Coordinates with which no picture can be made.
    """
    scene, entries = comparison.scene, comparison.entries
    view = scene_view(scene)
    columns, across, down = _grid(len(entries), view)
    rows = -(-len(entries) // columns)
    wide = 2 * SIDE + columns * across + (columns - 1) * BETWEEN
    high = HEAD + rows * (TITLE + down) + (rows - 1) * BETWEEN + FOOT
    figure = _figure(wide, high)
    robots, obstacles = count(len(scene.robots), "robot"), count(len(scene.obstacles), "obstacle")
    _head(figure, scene.name, f"{robots} · {obstacles} · × is length over that of the shortest route")
    for k, entry in enumerate(entries):
        row, column = divmod(k, columns)
        left = SIDE + column * (across + BETWEEN)
        bottom = high - HEAD - (row + 1) * (TITLE + down) - row * BETWEEN
        axes = figure.add_axes((left / wide, bottom / high, across / wide, down / high))
        _draw_entry(axes, scene, view, entry)
    _foot(figure, _map_handles(comparison))
    return figure


def draw_distributions(comparisons: Sequence[Comparison]) -> Figure:
    """Draw how length, clearance, build and query time of each way spread over all robots of all scenes.

    A dot is a robot (of times to build: a scene), a box reaches from quartile to quartile with the median in it, its
    whiskers from the 5th to the 95th hundredth. Lengths and clearances are those of solved robots.
    """
    ways = [entry.way for entry in comparisons[0].entries] if comparisons else []
    high = HEAD + 0.42 * max(len(ways), 2) + 0.95
    figure = _figure(WIDTH, high)
    robots = sum(len(comparison.scene.robots) for comparison in comparisons)
    _head(figure, "Ways compared", f"{count(len(comparisons), 'random scene')} · {count(robots, 'robot')} in all")
    of_way = [[entry for c in comparisons for entry in c.entries if entry.way == way] for way in ways]
    panels: list[tuple[str, list[FloatArray], Callable[[Axes], None]]] = [
        ("length over the shortest", _solved(of_way, lambda t: t.ratio), _ratio_scale),
        ("least clearance (m)", _solved(of_way, lambda t: t.clearance), _plain_scale),
        ("build (ms a scene)", [np.array([1e3 * e.build_seconds for e in es]) for es in of_way], _time_scale),
        (
            "query (ms a robot)",
            [np.array([1e3 * t.seconds for e in es for t in e.trials]) for es in of_way],
            _time_scale,
        ),
    ]
    left, right, gap = 1.75, 0.25, 0.3
    across = (WIDTH - left - right - gap * (len(panels) - 1)) / len(panels)
    for k, (title, values, scale) in enumerate(panels):
        box = ((left + k * (across + gap)) / WIDTH, 0.62 / high, across / WIDTH, (high - HEAD - 0.95) / high)
        axes = figure.add_axes(box)
        _plain(axes)
        axes.set_title(title, loc="left", fontsize=9, fontweight="bold", color=INK, pad=6)
        if any((sample > 0).any() for sample in values):
            scale(axes)
        for y, (way, sample) in enumerate(zip(ways, values, strict=True)):
            _draw_spread(axes, y, sample, _colour(way))
        axes.set_ylim(len(ways) - 0.5, -0.5)
        axes.set_yticks([])
        axes.grid(axis="x", color=OUTSIDE, linewidth=0.8)
        if k == 0:
            _name_rows(axes, ways, of_way)
    note = "box: quartiles and median · whiskers: 5 % to 95 % · dots: single robots, or scenes"
    figure.text(left / WIDTH, 0.16 / high, note, fontsize=8, color=QUIET)
    return figure


def draw_clearances(comparisons: Sequence[Comparison]) -> Figure:
    """Draw length and least clearance of each way against the clearance asked for, D_s, one comparison a clearance.

    Up to four robots have a column each. Of more, the means over those that a way solves are drawn, lengths over the
    shortest of the same robot at the least D_s it can be solved at, and a third row counts them. Curves have gaps where
    nothing is solved.
    """
    first = comparisons[0]
    team = first.scene.robots
    asked = np.array([comparison.scene.clearance for comparison in comparisons])
    columns = _robot_columns(comparisons) if len(team) <= FEW_ROBOTS else _team_columns(comparisons)
    rows = max(len(column[1]) for column in columns) if columns else 1
    high = HEAD + rows * 2.35 + 0.62
    figure = _figure(WIDTH if len(columns) > 1 else 0.72 * WIDTH, high)
    wide = figure.get_figwidth()
    _head(figure, first.scene.name, "length and least clearance against the safety distance")
    left, gap = 0.85, 0.75
    across = (wide - left - 0.25 - gap * (len(columns) - 1)) / max(len(columns), 1)
    for c, (name, panels) in enumerate(columns):
        for r, (label, curves) in enumerate(panels):
            bottom = high - HEAD - 0.25 - (r + 1) * 2.35 + 0.4
            place = ((left + c * (across + gap)) / wide, bottom / high, across / wide, 1.9 / high)
            axes = figure.add_axes(place)
            _plain(axes)
            axes.grid(color=OUTSIDE, linewidth=0.8)
            axes.set_axisbelow(True)
            _draw_curves(axes, asked, curves)
            axes.set_ylabel(label if c == 0 else "", fontsize=8.5, color=QUIET)
            _shade(axes, asked, curves)
            if "clearance" in label:
                _draw_bound(axes, asked)
            if r == 0:
                axes.set_title(name, loc="left", fontsize=9.5, fontweight="bold", color=INK, pad=5, parse_math=False)
            if r == len(panels) - 1:
                axes.set_xlabel("$D_s$ (m)", fontsize=8.5, color=QUIET)
            else:
                axes.tick_params(labelbottom=False)
    handles = [Line2D([], [], color=_colour(e.way), label=e.way, **_stroke(k)) for k, e in enumerate(first.entries)]
    bound = Line2D([], [], color=QUIET, linewidth=0.8, linestyle=(0, (4, 3)), label="clearance = $D_s$")
    _foot(figure, [*handles, bound, Patch(facecolor=UNSOLVED, label="no way solves it")])
    return figure


def save_comparison(comparison: Comparison, path: str | os.PathLike[str]) -> None:
    """Draw as `draw_comparison` into a .png (200 dpi), .svg or .pdf file; the same values give the same bytes.

    Raises
    ------
    OutputError
        Another extension, a place that cannot be written, coordinates with which no picture can be made.
    """
    _save(lambda: draw_comparison(comparison), path)


def save_distributions(comparisons: Sequence[Comparison], path: str | os.PathLike[str]) -> None:
    """Draw as `draw_distributions` into a file, else as `save_comparison`."""
    _save(lambda: draw_distributions(comparisons), path)


def save_clearances(comparisons: Sequence[Comparison], path: str | os.PathLike[str]) -> None:
    """Draw as `draw_clearances` into a file, else as `save_comparison`."""
    _save(lambda: draw_clearances(comparisons), path)


def _save(drawn: Callable[[], Figure], path: str | os.PathLike[str]) -> None:
    target = Path(path)
    kind = check_kind(target, tuple(NO_STAMPS), "pictures are written as")
    fonts: Any = {"svg.hashsalt": "taut", "svg.fonttype": "path", "pdf.fonttype": 42}
    with replacing(target) as scratch, any_letters(), mpl.rc_context(fonts):
        drawn().savefig(scratch, format=kind, dpi=200, metadata=NO_STAMPS[kind])


def _figure(wide: float, high: float) -> Figure:
    figure = Figure(figsize=(wide, high), facecolor="white")
    FigureCanvasAgg(figure)
    return figure


def _head(figure: Figure, name: str, facts: str) -> None:
    wide, high = figure.get_size_inches()
    up = 1 - 0.3 / high
    figure.text(SIDE / wide, up, name, fontsize=12.5, fontweight="bold", color=INK, parse_math=False)
    figure.text(1 - SIDE / wide, up, facts, fontsize=9.5, color=QUIET, ha="right", parse_math=False)


def _foot(figure: Figure, handles: Sequence[Line2D | Patch]) -> None:
    if not handles:
        return
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


def _grid(n: int, view: View) -> tuple[int, float, float]:
    """Return columns, and width and height of a map in inches, for n maps on a slide."""
    best: tuple[float, int, float, float] | None = None
    aspect = float(np.clip(view.width / view.height, 0.25, 4.0))
    for columns in range(1, max(n, 1) + 1):
        rows = -(-n // columns)
        across = min((WIDTH - 2 * SIDE - (columns - 1) * BETWEEN) / columns, 8.0, 7.0 * aspect)
        down = across / aspect
        high = HEAD + FOOT + rows * (down + TITLE)
        cost = abs(math.log(WIDTH / high / SHAPE)) + 0.15 * (rows * columns - n)
        if best is None or cost < best[0]:
            best = cost, columns, across, down
    assert best is not None
    return best[1:]


def _draw_entry(axes: Axes, scene: Scene, view: View, entry: Entry) -> None:
    axes.set(xlim=(view.x0, view.x1), ylim=(view.y0, view.y1), xticks=[], yticks=[], facecolor=OUTSIDE)
    axes.set_aspect("equal")
    axes.apply_aspect()
    for spine in axes.spines.values():
        spine.set(linewidth=0.6, color=QUIET)
    draw_map(axes, scene)
    if entry.roadmaps:
        _draw_edges(axes, scene, entry)
    n = len(scene.robots)
    colours = robot_colours(n)
    width = 0.8 * line_width(n)
    routes = [(t.points, c, t.solved) for t, c in zip(entry.trials, colours, strict=True) if t.points is not None]
    good = [(points, colour) for points, colour, solved in routes if solved]
    bad = [(points, colour) for points, colour, solved in routes if not solved]
    draw_paths(axes, [points for points, _ in good], [colour for _, colour in good], width)
    dashed: dict[str, Any] = {"linewidths": width, "linestyles": DASHED, "zorder": 4}
    axes.add_collection(LineCollection([p for p, _ in bad], colors=[c for _, c in bad], **dashed), autolim=False)
    lost = [(r.start, r.goal) for r, t in zip(scene.robots, entry.trials, strict=True) if t.points is None]
    dotted: dict[str, Any] = {"linewidths": 0.7, "linestyles": DOTTED, "zorder": 3}
    axes.add_collection(LineCollection(lost, colors=mix(INK, "#ffffff", 0.45), **dotted), autolim=False)
    _draw_ends(axes, scene)
    axes.set_title(entry.way, loc="left", fontsize=10, fontweight="bold", color=INK, pad=4)
    axes.set_title(_facts(entry), loc="right", fontsize=8.5, color=QUIET, pad=4)


def _draw_edges(axes: Axes, scene: Scene, entry: Entry) -> None:
    growths = Counter(scene.growth(robot) for robot in scene.robots)
    roadmap = entry.roadmaps[max(entry.roadmaps, key=lambda growth: growths[growth])]
    ends = roadmap.positions[roadmap.graph.edges]
    # the more ink, the thinner: a fine grid stays a tint
    ink = np.hypot(*(ends[:, 1] - ends[:, 0]).T).sum() / math.sqrt(shapely.Polygon(scene.workspace).area)
    width, alpha = float(np.clip(40 / (ink + 1), 0.12, 0.6)), float(np.clip(100 / (ink + 1), 0.3, 1.0))
    style: dict[str, Any] = {"colors": GRAPH, "linewidths": width, "alpha": alpha, "zorder": 2.5}
    axes.add_collection(LineCollection(list(ends), **style), autolim=False)


def _draw_ends(axes: Axes, scene: Scene) -> None:
    area = (2 * SHARE * mark_radius(len(scene.robots))) ** 2
    for places, colour, marker, share in (
        ([robot.goal for robot in scene.robots], GOAL, "D", 0.8),
        ([robot.start for robot in scene.robots], START, "o", 1.0),
    ):
        at = np.array(places, dtype=np.float64).reshape(-1, 2)
        axes.scatter(
            at[:, 0], at[:, 1], s=area * share, c=colour, marker=marker, edgecolors="white", linewidths=0.3, zorder=6
        )


def _facts(entry: Entry) -> str:
    found = summary(entry)
    ratio = [] if found.mean_ratio is None else [f"× {found.mean_ratio:.3f}"]
    return " · ".join([*ratio, f"{found.solved} of {found.robots} solved"])


def _map_handles(comparison: Comparison) -> list[Line2D]:
    handles = end_handles(comparison.scene)
    if any(entry.roadmaps for entry in comparison.entries):
        handles.append(Line2D([], [], color=GRAPH, linewidth=1.0, label="roadmap"))
    trials = [trial for entry in comparison.entries for trial in entry.trials]
    if any(not trial.solved and trial.points is not None for trial in trials):
        handles.append(Line2D([], [], color=INK, linewidth=1.4, linestyle=DASHED, label="route not allowed"))
    if any(trial.points is None for trial in trials):
        handles.append(Line2D([], [], color=QUIET, linewidth=1.0, linestyle=DOTTED, label="no route"))
    return handles


def _colour(way: str) -> Colour:
    return robot_colours(len(WAYS))[list(WAYS).index(way)]


def _plain(axes: Axes) -> None:
    axes.spines[["top", "right"]].set_visible(False)
    for spine in axes.spines.values():
        spine.set(linewidth=0.6, color=QUIET)
    axes.tick_params(which="both", length=2.5, width=0.6, color=QUIET, labelcolor=QUIET, labelsize=8)


def _solved(of_way: Sequence[Sequence[Entry]], value: Callable[[Trial], float | None]) -> list[FloatArray]:
    def known(entries: Sequence[Entry]) -> Iterator[float]:
        for entry in entries:
            for trial in entry.trials:
                amount = value(trial)
                if trial.solved and amount is not None and math.isfinite(amount):
                    yield amount

    return [np.array(list(known(entries)), dtype=np.float64) for entries in of_way]


def _ratio_scale(axes: Axes) -> None:
    axes.set_xscale("log")
    axes.xaxis.set_major_locator(MaxNLocator(5, steps=[1, 2, 5, 10]))
    axes.xaxis.set_minor_locator(mpl.ticker.NullLocator())
    axes.xaxis.set_major_formatter(FuncFormatter(lambda x, _: f"{x:g}"))


def _plain_scale(axes: Axes) -> None:
    axes.xaxis.set_major_locator(MaxNLocator(5))


def _time_scale(axes: Axes) -> None:
    axes.set_xscale("log")
    axes.xaxis.set_major_formatter(FuncFormatter(lambda x, _: f"{x:g}"))


def _draw_spread(axes: Axes, y: float, sample: FloatArray, colour: Colour) -> None:
    """Draw dots above the line y, a box below it."""
    if not len(sample):
        return
    dots = np.sort(sample)[:: -(-len(sample) // MOST_DOTS)]
    # golden steps spread the dots as evenly as chance would not
    shift = (np.arange(len(dots)) * 0.618034) % 1.0
    axes.scatter(dots, y - 0.05 - 0.3 * shift, s=3.5, color=mix(colour, "#ffffff", 0.35), linewidths=0, zorder=2)
    low, lower, middle, upper, high = np.quantile(sample, [0.05, 0.25, 0.5, 0.75, 0.95])
    at = y + 0.14
    axes.plot([low, high], [at, at], color=colour, linewidth=1.0, solid_capstyle="butt", zorder=3)
    axes.plot([lower, upper], [at, at], color=colour, linewidth=6.5, solid_capstyle="butt", zorder=3)
    axes.plot([middle, middle], [at - 0.12, at + 0.12], color="white", linewidth=3.0, zorder=4)
    axes.plot([middle, middle], [at - 0.12, at + 0.12], color=darker(colour), linewidth=1.4, zorder=5)


def _name_rows(axes: Axes, ways: Sequence[str], of_way: Sequence[Sequence[Entry]]) -> None:
    for y, (way, entries) in enumerate(zip(ways, of_way, strict=True)):
        trials = [trial for entry in entries for trial in entry.trials]
        share = sum(trial.solved for trial in trials) / len(trials) if trials else math.nan
        place: dict[str, Any] = {"xycoords": axes.get_yaxis_transform(), "textcoords": "offset points", "ha": "right"}
        axes.annotate(way, (0, y), (-8, 1), va="bottom", fontsize=9.5, fontweight="bold", color=INK, **place)
        said = "no robots" if math.isnan(share) else f"{100 * share:.3g} % solved"
        axes.annotate(said, (0, y), (-8, -1), va="top", fontsize=8, color=QUIET, **place)


Curves = list[tuple[str, FloatArray]]
"""Of each way: its name and a value for each clearance, nan where there is none."""


def _robot_columns(comparisons: Sequence[Comparison]) -> list[tuple[str, list[tuple[str, Curves]]]]:
    """Name and panels of each robot's column; a panel is its label and its curves."""
    ways = [entry.way for entry in comparisons[0].entries]
    lengths, clearances = _table(comparisons, lambda t: t.length), _table(comparisons, lambda t: t.clearance)
    return [
        (
            robot.name,
            [
                ("length (m)", [(way, lengths[:, w, r]) for w, way in enumerate(ways)]),
                ("least clearance (m)", [(way, clearances[:, w, r]) for w, way in enumerate(ways)]),
            ],
        )
        for r, robot in enumerate(comparisons[0].scene.robots)
    ]


def _team_columns(comparisons: Sequence[Comparison]) -> list[tuple[str, list[tuple[str, Curves]]]]:
    """Name and panels of the one column of a larger team."""
    ways = [entry.way for entry in comparisons[0].entries]
    shortest = np.array([comparison.shortest for comparison in comparisons])
    known = np.isfinite(shortest)
    base = np.where(known.any(axis=0), shortest[known.argmax(axis=0), np.arange(shortest.shape[1])], np.nan)
    lengths, clearances = _table(comparisons, lambda t: t.length), _table(comparisons, lambda t: t.clearance)
    here = np.isfinite(lengths)
    longer = lengths / np.where(base > 0, base, np.nan)
    panels = [
        ("mean length over the shortest", [(way, _means(longer[:, w])) for w, way in enumerate(ways)]),
        ("mean least clearance (m)", [(way, _means(clearances[:, w])) for w, way in enumerate(ways)]),
        ("robots solved", [(way, here[:, w].sum(axis=1).astype(np.float64)) for w, way in enumerate(ways)]),
    ]
    return [(f"{shortest.shape[1]} robots, means over those solved", panels)]


def _table(comparisons: Sequence[Comparison], value: Callable[[Trial], float | None]) -> FloatArray:
    """Return values of solved robots, nan else: (clearances, ways, robots)."""
    rows = [
        [[math.nan if not t.solved or value(t) is None else value(t) for t in e.trials] for e in c.entries]
        for c in comparisons
    ]
    return np.array(rows, dtype=np.float64)


def _means(values: FloatArray) -> FloatArray:
    """Means of the rows of (k, n) over what is known, nan where nothing is: (k,)."""
    known = np.isfinite(values)
    sums, counts = np.where(known, values, 0.0).sum(axis=1), known.sum(axis=1)
    return np.where(counts > 0, sums / np.maximum(counts, 1), np.nan)


def _stroke(k: int) -> dict[str, Any]:
    """Return how the k-th curve is drawn: ways that agree must both be seen, so the first are the widest."""
    widths = (5.0, 2.2, 1.4)
    return {"linewidth": widths[min(k, 2)], "alpha": 0.4 if k == 0 else 1.0}


def _draw_curves(axes: Axes, asked: FloatArray, curves: Curves) -> None:
    for k, (way, values) in enumerate(curves):
        marker: dict[str, Any] = {"marker": "o", "markersize": 3.4 if k else 6.5} if len(asked) <= FEW_STEPS else {}
        axes.plot(asked, values, color=_colour(way), zorder=3 + 0.1 * k, **_stroke(k), **marker)
    pad = 0.03 * (float(np.ptp(asked)) or 1.0)
    axes.set_xlim(asked.min() - pad, asked.max() + pad)


def _shade(axes: Axes, asked: FloatArray, curves: Curves) -> None:
    """Shade where no curve has a value."""
    empty = ~np.isfinite([values for _, values in curves]).any(axis=0)
    between = (asked[1:] + asked[:-1]) / 2
    edges = np.concatenate([axes.get_xlim()[:1], between, axes.get_xlim()[1:]])
    for k in np.flatnonzero(empty).tolist():
        axes.axvspan(edges[k], edges[k + 1], facecolor=UNSOLVED, linewidth=0, zorder=0)


def _draw_bound(axes: Axes, asked: FloatArray) -> None:
    """Draw the line below which no clearance may be."""
    ends = [asked.min(), asked.max()]
    axes.plot(ends, ends, color=QUIET, linewidth=0.8, linestyle=(0, (4, 3)), zorder=2, scalex=False)
