"""Spectra and matrices of graphs: eigenvalues as stems, entries of vectors and matrices as colours."""

from __future__ import annotations

from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.collections import LineCollection
from matplotlib.colors import LinearSegmentedColormap, to_hex
from matplotlib.ticker import MaxNLocator
from numpy.typing import ArrayLike
from scipy import sparse

from taut.figures.canvas import size_in_points
from taut.figures.style import GRAPH, INK, QUIET, Colour, darker, mix
from taut.graph.core import Floats

LOW: Colour = "#332288"  # indigo: negative
HIGH: Colour = "#e08e00"  # orange: positive
#: Indigo below zero, white at zero, orange above; an odd number of colours, so that zero is exactly white.
DIVERGING = LinearSegmentedColormap.from_list("taut-diverging", [LOW, "#ffffff", HIGH], N=257)
DENSITY = LinearSegmentedColormap.from_list("taut-density", ["#ffffff", LOW])

FEW_CELLS = 16  # matrices up to this size show their numbers
MANY_CELLS = 400  # larger matrices are shown as a density
BINS = 200  # pixels along a side of that density


def draw_spectrum(axes: Axes, values: ArrayLike) -> None:
    """Draw eigenvalues (n,), ascending, as stems; λ2, the second, is marked and written out."""
    known = np.asarray(values, dtype=np.float64).reshape(-1)
    n = len(known)
    _plain(axes, "k", "λk")
    number = np.arange(1, n + 1)
    stems = np.stack([np.stack([number, np.zeros(n)], axis=1), np.stack([number, known], axis=1)], axis=1)
    width = float(np.clip(60 / max(n, 1), 0.4, 1.4))
    axes.add_collection(LineCollection(list(stems), colors=mix(LOW, "#ffffff", 0.5), linewidths=width), autolim=False)
    axes.scatter(number, known, s=float(np.clip(500 / max(n, 1), 1.5, 16)), color=LOW, linewidths=0, zorder=3)
    top = float(known.max(initial=0.0)) or 1.0
    axes.set(xlim=(1 - 0.03 * max(n, 8), max(n, 2) + 0.03 * max(n, 8)), ylim=(-0.03 * top, 1.2 * top))
    axes.xaxis.set_major_locator(MaxNLocator(6, integer=True))
    if n >= 2:
        axes.add_collection(LineCollection([stems[1]], colors=HIGH, linewidths=max(2 * width, 1.6), zorder=4))
        axes.scatter(number[1:2], known[1:2], s=30, color=HIGH, edgecolors="white", linewidths=0.8, zorder=5)
        _point_out(axes, (2.0, float(known[1])), f"λ2 = {short(known[1])}")


def draw_matrix(axes: Axes, matrix: Any) -> None:
    """Draw a square matrix, dense or sparse: entries below zero indigo, above orange; of many, only how dense they lie.

    Up to 16 rows the numbers stand in the cells; beyond 400 a pixel stands for many cells and is the darker the more
    of them are not zero.
    """
    entries = sparse.csr_array(matrix)
    n = entries.shape[0]
    axes.set_aspect("equal")
    axes.tick_params(length=0, labelsize=7, labelcolor=QUIET, pad=2)
    for spine in axes.spines.values():
        spine.set(linewidth=0.6, color=QUIET)
    if n == 0:
        axes.set(xticks=[], yticks=[])
        return
    extent = (0.5, n + 0.5, n + 0.5, 0.5)
    if n > MANY_CELLS:
        axes.imshow(_density(entries), cmap=DENSITY, vmin=0, vmax=1, extent=extent, interpolation="nearest")
    else:
        cells = entries.toarray()
        # no entry is so small beside the diagonal that it fades away
        shades = np.sign(cells) * (0.25 + 0.75 * np.sqrt(np.abs(cells) / (np.abs(cells).max() or 1.0)))
        axes.imshow(shades, cmap=DIVERGING, vmin=-1, vmax=1, extent=extent, interpolation="nearest")
        if n <= FEW_CELLS:
            _write_cells(axes, cells, shades)
    for axis in (axes.xaxis, axes.yaxis):
        if n <= FEW_CELLS:
            axis.set_ticks(range(1, n + 1))
        else:
            axis.set_major_locator(MaxNLocator(4, integer=True, steps=[1, 2, 5, 10]))


def draw_sorted(axes: Axes, values: ArrayLike) -> None:
    """Draw the entries of a vector (n,) in ascending order, coloured as `draw_values` colours vertices."""
    ordered = np.sort(np.asarray(values, dtype=np.float64).reshape(-1))
    n = len(ordered)
    _plain(axes, "vertices, in ascending order", "entry of the Fiedler vector")
    axes.axhline(0, color=GRAPH, linewidth=0.8, zorder=1)
    axes.scatter(np.arange(1, n + 1), ordered, s=22, c=tints(ordered), edgecolors="none", zorder=2)
    axes.plot(np.arange(1, n + 1), ordered, color=INK, linewidth=0.9, zorder=3)
    axes.set_xlim(1 - 0.02 * n, 1.02 * n)
    axes.xaxis.set_major_locator(MaxNLocator(5, integer=True))


def tints(values: Floats) -> list[Colour]:
    """Return the colours of values, white at zero."""
    largest = float(np.abs(values).max(initial=0.0)) or 1.0
    return [to_hex(colour) for colour in DIVERGING(0.5 + values / (2 * largest))]


def short(value: float) -> str:
    """Return a number in four digits."""
    return f"{value:.4g}"


def _write_cells(axes: Axes, cells: Floats, shades: Floats) -> None:
    size = size_in_points(axes)[0] / len(cells)
    texts = {cell: f"{value:.3g}".replace("-", "−") for cell, value in np.ndenumerate(cells) if value}
    font = min(0.45 * size, 1.4 * size / max(map(len, texts.values()), default=1), 9.0)
    for (i, j), text in texts.items():
        ink = "#ffffff" if shades[i, j] < -0.75 else INK
        axes.text(j + 1, i + 1, text, fontsize=font, color=ink, ha="center", va="center_baseline")


def _density(entries: Any) -> Floats:
    """Return how many cells of each block are not zero, (BINS, BINS), as a root of the share of the fullest block."""
    n = entries.shape[0]
    spots = entries.tocoo()
    block = (spots.row.astype(np.int64) * BINS // n) * BINS + spots.col.astype(np.int64) * BINS // n
    counts = np.bincount(block, minlength=BINS * BINS).reshape(BINS, BINS)
    return np.asarray((counts / max(counts.max(), 1)) ** 0.4, dtype=np.float64)


def _plain(axes: Axes, below: str, beside: str) -> None:
    """Make axes of two thin lines with their labels."""
    axes.spines[["top", "right"]].set_visible(False)
    for spine in axes.spines.values():
        spine.set(linewidth=0.6, color=QUIET)
    axes.tick_params(length=2.5, width=0.6, color=QUIET, labelcolor=QUIET, labelsize=7.5)
    axes.set_xlabel(below, fontsize=8, color=QUIET)
    axes.set_ylabel(beside, fontsize=8, color=QUIET)


def _point_out(axes: Axes, at: tuple[float, float], text: str) -> None:
    """Write a text over a point near the left, where the values, which ascend, leave room."""
    high = axes.get_ylim()[1]
    axes.vlines(at[0], at[1], 0.94 * high, colors=HIGH, linewidths=0.7, linestyles=(0, (2, 2)), zorder=2)
    place: dict[str, Any] = {"textcoords": "offset points", "ha": "left", "va": "center", "zorder": 6}
    axes.annotate(text, (at[0], 0.95 * high), (5, 0), fontsize=9, fontweight="bold", color=darker(HIGH), **place)
