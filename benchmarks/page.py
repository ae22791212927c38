"""The page docs/performance.md and its picture."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import Any

import geometry
import team
from measure import Table, in_words, machine

FIGURE = "performance.png"

# Okabe and Ito's colours, safe for the colour-blind
OURS, REGION, MESH, TANGENTS = "#000000", "#56b4e9", "#e69f00", "#009e73"
THEIRS = ("#d55e00", "#cc79a7", "#0072b2")
SHARES = {"world": "#56b4e9", "planning": "#e69f00", "certificate": "#009e73"}


def text(tables: Sequence[Table]) -> str:
    """Return the page as Markdown."""
    head = (
        "# Performance\n\n"
        "`./dev bench` measures these figures and writes this page; edit `benchmarks/`, not the page. "
        "`python benchmarks/success.py` tells how many random teams are solved.\n\n"
        f"Measured on {machine()}\n\n"
        f"![Time to build a tangent graph by number of vertices, and where planning spends its time](figures/{FIGURE})"
    )
    return "\n\n".join([head, *(str(table) for table in tables)]) + "\n"


def write(page: Path, tables: Sequence[Table], found: geometry.Measured, outcomes: Sequence[team.Outcome]) -> None:
    """Write the page, and its picture into the folder figures beside it."""
    picture = page.parent / "figures" / FIGURE
    picture.parent.mkdir(parents=True, exist_ok=True)
    draw(picture, found, outcomes)
    page.write_text(text(tables), encoding="utf-8")


def draw(path: Path, found: geometry.Measured, outcomes: Sequence[team.Outcome]) -> None:
    """Draw build times by size, and the shares of planning's phases by scene."""
    from matplotlib.backends.backend_agg import FigureCanvasAgg
    from matplotlib.figure import Figure

    figure = Figure(figsize=(11, 5), layout="constrained")
    FigureCanvasAgg(figure)
    left, right = figure.subplots(1, 2)
    _draw_builds(left, found)
    _draw_shares(right, outcomes)
    figure.savefig(path, dpi=150, metadata={"Software": None})


def _draw_builds(ax: Any, found: geometry.Measured) -> None:
    sizes = [b.n for b in found.builds]
    for k, name in enumerate(dict.fromkeys(c.peer for c in found.compared)):
        points = [(c.n, c.build) for c in found.compared if c.peer == name and c.build is not None]
        if points:
            ax.plot(*zip(*points, strict=True), "s--", color=THEIRS[k], label=name)
    ax.plot(sizes, [b.total for b in found.builds], "o-", color=OURS, linewidth=2.5, label="taut, together")
    for phase, colour, label in (
        ("tangents", TANGENTS, "taut: tangent graph"),
        ("region", REGION, "taut: free space"),
        ("mesh", MESH, "taut: triangulation"),
    ):
        ax.plot(sizes, [getattr(b, phase) for b in found.builds], ".-", color=colour, linewidth=1, label=label)
    ax.set(xscale="log", yscale="log", xlabel="obstacle vertices", ylabel="seconds", title="Building the graph")
    ax.set_xticks(sizes, [f"{n:,}" for n in sizes])
    ax.minorticks_off()
    ax.grid(alpha=0.3)
    ax.legend(loc="upper center", bbox_to_anchor=(0.5, -0.13), ncols=3, fontsize=8, frameon=False)


def _draw_shares(ax: Any, outcomes: Sequence[team.Outcome]) -> None:
    solved = [o for o in outcomes if o.runs][::-1]
    names = [o.case.name for o in solved]
    done = [0.0] * len(solved)
    for phase, colour in SHARES.items():
        shares = [100 * o.phase(phase) / o.total for o in solved]
        ax.barh(names, shares, left=done, color=colour, label=phase)
        done = [a + b for a, b in zip(done, shares, strict=True)]
    ax.barh(names, [max(0.0, 100 - d) for d in done], left=done, color="#bbbbbb", label="checks and reasons")
    for k, outcome in enumerate(solved):
        ax.text(102, k, in_words(outcome.total), va="center", fontsize=9)
    ax.set(xlim=(0, 100), xlabel="share of the time to a certified plan, %", title="Planning a team")
    ax.spines[["top", "right"]].set_visible(False)
    ax.legend(loc="upper center", bbox_to_anchor=(0.5, -0.13), ncols=4, fontsize=8, frameon=False)
