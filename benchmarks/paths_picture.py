"""The picture of suite paths: time to build, time of a query, and memory, by number of corners."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import Any

from against import Compared
from asking import Queries
from building import Build

# Okabe and Ito's colours, safe for the colour-blind
OURS, ASTAR, DIRECT, LABELS = "#000000", "#009e73", "#56b4e9", "#e69f00"
THEIRS = ("#d55e00", "#cc79a7", "#0072b2")


def draw(path: Path, builds: Sequence[Build], queries: Sequence[Queries], others: Sequence[Compared]) -> None:
    """Draw all three, logarithmic."""
    from matplotlib.backends.backend_agg import FigureCanvasAgg
    from matplotlib.figure import Figure

    figure = Figure(figsize=(13.5, 5), layout="constrained")
    FigureCanvasAgg(figure)
    left, middle, right = figure.subplots(1, 3)
    corners = [b.corners for b in builds]
    _theirs(left, others, "build")
    _line(left, corners, [b.together for b in builds], OURS, "taut, all cores")
    left.plot(corners, [b.alone for b in builds], "o:", color=OURS, linewidth=1.2, label="taut, one thread")
    _finished(left, corners, "seconds", "From a scene to its tangent graph")
    _theirs(middle, others, "query")
    asked = [q.corners for q in queries]
    _line(middle, asked, [q.astar.batch for q in queries], ASTAR, "A*, batch")
    middle.plot(asked, [q.astar.single for q in queries], "o:", color=ASTAR, linewidth=1.2, label="A*, one a call")
    _line(middle, asked, [q.direct.batch for q in queries], DIRECT, "interval search, batch")
    labels = [(q.corners, q.labels) for q in queries if q.labels is not None]
    named = [n for n, _ in labels]
    _line(middle, named, [found.places.batch for _, found in labels], LABELS, "hub labels, batch")
    _finished(middle, corners, "seconds a pair", "Shortest paths between free places")
    told = [(b.corners, b.memory / 1e6) for b in builds if b.memory]
    _line(right, [n for n, _ in told], [size for _, size in told], OURS, "building")
    _line(right, named, [found.size / 1e6 for _, found in labels], LABELS, "hub labels")
    _finished(right, corners, "MB", "Memory")
    figure.savefig(path, dpi=150, metadata={"Software": None})


def _theirs(ax: Any, others: Sequence[Compared], field: str) -> None:
    for colour, name in zip(THEIRS, dict.fromkeys(c.peer for c in others), strict=False):
        points = [(c.corners, getattr(c, field)) for c in others if c.peer == name and getattr(c, field) is not None]
        if points:
            ax.plot(*zip(*points, strict=True), "s--", color=colour, label=name)


def _line(ax: Any, x: Sequence[float], y: Sequence[float], colour: str, label: str) -> None:
    ax.plot(x, y, "o-", color=colour, linewidth=2.2, label=label)


def _finished(ax: Any, corners: Sequence[int], unit: str, title: str) -> None:
    ax.set(xscale="log", yscale="log", xlabel="corners of obstacles", ylabel=unit, title=title)
    ax.set_xticks(corners, [f"{n:,}" for n in corners], rotation=35, ha="right")
    ax.minorticks_off()
    ax.grid(alpha=0.3)
    ax.legend(loc="upper center", bbox_to_anchor=(0.5, -0.22), ncols=3, fontsize=8, frameon=False)
