"""Small text beside places on the map, put where it covers neither paths nor other text."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from matplotlib.axes import Axes
from matplotlib.patheffects import withStroke

from taut.figures.canvas import size_in_points, to_points
from taut.figures.style import Colour
from taut.scene import FloatArray, Point

SIDES = np.array([45, 0, 90, 135, -45, 180, -90, -135, 22, 68, 112, 158, -22, -68, -112, -158]) * np.pi / 180
ASIDE = (1.0, 6.0, 13.0)  # points between the mark and its text, nearest first
TEXT, MARK, PATH, OUTSIDE = 400.0, 150.0, 3.0, 800.0  # what it costs to cover one of these, against ≈ 1 a position


@dataclass(frozen=True)
class Label:
    """A text that belongs to the place `at` (metres), whose mark reaches `reach` points round it."""

    text: str
    at: Point
    reach: float
    colour: Colour
    size: float = 8.0
    weight: str = "bold"


def write(axes: Axes, labels: Sequence[Label], marks: Sequence[tuple[Point, float]], paths: FloatArray) -> None:
    """Write the labels, each at the cheapest of 48 positions round its place, in the order given.

    Parameters
    ----------
    labels : what to write; earlier ones choose first.
    marks : places (metres) and reaches (points) of the marks that text should not cover.
    paths : (k, 2) points in metres, close together, along the lines that text should not cover.
    """
    if not labels:
        return
    outline = [withStroke(linewidth=2.2, foreground="white")]
    spots = to_points(axes, np.array([m[0] for m in marks], dtype=np.float64))
    discs = np.column_stack([spots, [m[1] for m in marks]])
    lines = to_points(axes, paths)
    size = size_in_points(axes)
    taken: list[FloatArray] = []
    for label in labels:
        anchor = to_points(axes, np.array(label.at))[0]
        offset, box = _cheapest(label, anchor, discs, lines, taken, size)
        taken.append(box)
        axes.annotate(
            label.text,
            label.at,
            (float(offset[0]), float(offset[1])),
            textcoords="offset points",
            ha="center",
            va="center_baseline",
            fontsize=label.size,
            fontweight=label.weight,
            color=label.colour,
            path_effects=outline,
            linespacing=1.05,
            parse_math=False,  # a name may hold dollar signs
            zorder=9,
        )


def text_size(text: str, size: float) -> tuple[float, float]:
    """Return about how wide and high the text is, in points."""
    rows = text.split("\n")
    return 0.66 * size * max(len(row) for row in rows), 1.1 * size * len(rows)


def _cheapest(
    label: Label,
    anchor: FloatArray,
    discs: FloatArray,
    lines: FloatArray,
    taken: Sequence[FloatArray],
    size: tuple[float, float],
) -> tuple[FloatArray, FloatArray]:
    half = np.array(text_size(label.text, label.size)) / 2
    near = lines[(np.abs(lines - anchor) < label.reach + ASIDE[-1] + 2 * half + 2).all(axis=1)]
    others = np.array(taken).reshape(-1, 4)
    best, best_cost = (np.zeros(2), np.zeros(4)), np.inf
    for far, aside in enumerate(ASIDE):
        for rank, angle in enumerate(SIDES):
            direction = np.array([np.cos(angle), np.sin(angle)])
            # the box touches the circle of the mark: its far side moves out by its own half size
            offset = direction * (label.reach + aside) + half * np.clip(direction * 1.6, -1, 1)
            low, high = anchor + offset - half, anchor + offset + half
            cost = 0.12 * rank + 5.0 * far
            cost += PATH * float(((near > low - 1) & (near < high + 1)).all(axis=1).sum()) ** 0.5
            cost += OUTSIDE * float((low < 0).any() or (high > size).any())
            overlap = (others[:, :2] < high).all(axis=1) & (others[:, 2:] > low).all(axis=1)
            cost += TEXT * float(overlap.sum())
            gaps = np.maximum(np.maximum(low - discs[:, :2], discs[:, :2] - high), 0)
            cost += MARK * float((np.hypot(*gaps.T) < discs[:, 2]).sum())
            if cost < best_cost:
                best, best_cost = (offset, np.concatenate([low, high])), cost
    return best
