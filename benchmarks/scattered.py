"""Random scenes with an exact number of obstacle vertices, and random places in their free space."""

from __future__ import annotations

import math

import numpy as np

from taut.freespace import FreeSpace
from taut.scene import FloatArray, Polygon, Scene

SIDE = 100.0
COVERED = 0.35  # share of the hall that the circles round the polygons cover; thrown circles jam at 0.547


def scattered_scene(vertices: int, seed: int) -> Scene:
    """Return a hall of 100 m × 100 m with disjoint convex polygons that have ``vertices`` (≥ 3) corners in all."""
    rng = np.random.default_rng(seed)
    corners = _corner_counts(rng, vertices)
    spread = rng.uniform(0.5, 1.5, len(corners))
    radii = np.sort(spread * SIDE * math.sqrt(COVERED / (math.pi * float((spread**2).sum()))))[::-1]
    radii = np.minimum(radii, 0.2 * SIDE)
    centres = _thrown(rng, radii)
    return Scene(
        (0, 0, SIDE, SIDE),
        [Polygon(_convex(rng, int(k)) * r + c) for k, r, c in zip(corners, radii, centres, strict=True)],
    )


def free_places(freespace: FreeSpace, count: int, seed: int) -> FloatArray:
    """Return places drawn evenly from the largest connected part of free space, (count, 2) metres."""
    rng = np.random.default_rng(seed)
    mesh = freespace.mesh
    x0, y0, x1, y1 = freespace.region.bounds
    largest = int(np.argmax(np.bincount(mesh.parts)))
    found = np.empty((0, 2))
    while len(found) < count:
        thrown = rng.uniform((x0, y0), (x1, y1), (4 * count, 2))
        triangles = mesh.locate(thrown)
        found = np.concatenate([found, thrown[(triangles >= 0) & (mesh.parts[triangles] == largest)]])
    return found[:count]


def _corner_counts(rng: np.random.Generator, total: int) -> list[int]:
    """Return numbers from 3 to 8 that sum to ``total``."""
    out: list[int] = []
    left = total
    while left > 8:
        # what remains must again be divisible into polygons, so at least 3 corners stay
        out.append(int(rng.integers(3, min(8, left - 3) + 1)))
        left -= out[-1]
    return [*out, left]


def _convex(rng: np.random.Generator, corners: int) -> FloatArray:
    """Return points on the unit circle, counter-clockwise, (corners, 2)."""
    angle = 2 * math.pi * (np.arange(corners) + rng.uniform(-0.3, 0.3, corners) + rng.uniform()) / corners
    return np.stack([np.cos(angle), np.sin(angle)], axis=1)


def _thrown(rng: np.random.Generator, radii: FloatArray) -> FloatArray:
    """Centres of disjoint circles inside the hall, thrown one after another, (k, 2)."""
    centres = np.empty((len(radii), 2))
    for k, r in enumerate(radii):
        while True:
            centres[k] = rng.uniform(r, SIDE - r, 2)
            away = centres[:k] - centres[k]
            if ((away**2).sum(axis=1) > (radii[:k] + r) ** 2).all():
                break
    return centres
