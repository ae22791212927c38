"""The hall of a random scene: its sides, its margin, its decimals."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any

import numpy as np
import shapely
from numpy.typing import NDArray

from taut.scene import FloatArray

DISCS = 0.05
"""Largest share of the free area that robots take in a hall of chosen size."""

THROWN = 0.35
"""Largest share that obstacles, as discs with half a passage around, take in a hall of chosen size."""

TIGHT = 0.35
"""Largest share that obstacles with half a passage around take when a density is asked for."""


@dataclass(frozen=True)
class Hall:
    """A rectangle with one corner at (0, 0); sides in metres."""

    width: float
    height: float

    @property
    def area(self) -> float:
        """Square metres."""
        return self.width * self.height

    @property
    def margin(self) -> float:
        """Metres added to every required distance: a centimetre, less in a toy hall."""
        return min(0.01, 1e-3 * min(self.width, self.height))

    @property
    def digits(self) -> int:
        """Decimals of all coordinates: millimetres, or finer, always far below `margin`."""
        return max(3, 4 - math.floor(math.log10(min(self.width, self.height))))

    @property
    def words(self) -> str:
        """The hall in an error message."""
        return f"a hall of {self.width:g} × {self.height:g} m"

    def shrunk(self, by: float) -> shapely.Polygon:
        """Return what lies at least `by` metres from the wall; empty if nothing does."""
        if min(self.width, self.height) <= 2 * by:
            return shapely.Polygon()
        return shapely.box(by, by, self.width - by, self.height - by)


def roomy(diameters: FloatArray, solids: NDArray[Any], density: float | None, passage: float, needed: float) -> float:
    """Choose the side of a square hall, at least 10 m, for obstacles and robots.

    Parameters
    ----------
    diameters : of the obstacles, metres, (m,).
    solids : the obstacles, (m,) geometries.
    density : share that the obstacles, scaled, shall cover, if it was given.
    passage : kept free between obstacles, metres.
    needed : free area for the robots, square metres.
    """
    area, edge, count = float(shapely.area(solids).sum()), float(shapely.length(solids).sum()), len(solids)
    if density is None:
        discs = math.pi / 4 * float(np.sum((diameters + passage) ** 2))
        return max(math.sqrt(max(needed + area, discs / THROWN)), 1.5 * float(diameters.max(initial=0.0)), 10.0)

    def with_passages(scale: float) -> float:
        """Area of the scaled obstacles with half a passage around them (Steiner's formula), square metres."""
        return area * scale**2 + edge * scale * passage / 2 + count * math.pi * passage**2 / 4

    side = max(math.sqrt(max(area / density, needed / (1 - density))), 10.0)
    # obstacles grow with the hall, passages do not: their share falls towards the density
    while with_passages(math.sqrt(density * side**2 / area)) > max(TIGHT, 1.2 * density) * side**2:
        side *= 1.1
    return side


def square(side: float) -> Hall:
    """Return a square hall of at least this side, two digits long."""
    step = 10.0 ** (math.floor(math.log10(side)) - 1)
    side = math.ceil(round(side / step, 6)) * step
    return Hall(side, side)
