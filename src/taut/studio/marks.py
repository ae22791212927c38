"""Marks and steps as plain data: what the page paints at a step, and what it tells of it."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any, TypeAlias

import numpy as np
import shapely
from numpy.typing import ArrayLike

from taut.errors import one_line
from taut.geometry.growth import grown
from taut.scene import Obstacle, Scene
from taut.studio.reasons import rings_in

Mark: TypeAlias = dict[str, Any]
Step: TypeAlias = dict[str, Any]
Points: TypeAlias = ArrayLike | int
"""Places (n, 2) in metres, or the number of a list of places that all steps share."""


def step(
    title: str,
    story: Sequence[str],
    numbers: Mapping[str, str] | None = None,
    *,
    stays: Sequence[Mark] = (),
    marks: Sequence[Mark] = (),
    fresh: bool = False,
) -> Step:
    """Return a step.

    Parameters
    ----------
    title : what it is about, in a few words.
    story : sentences that explain it; the first alone must do.
    numbers : what is to be read off, by its label.
    stays : marks to be seen from this step on.
    marks : marks to be seen at this step only.
    fresh : whether marks that stayed from the steps before are gone.
    """
    return {
        "title": one_line(title),
        "story": [one_line(sentence) for sentence in story],
        "numbers": dict(numbers or {}),
        "stays": list(stays),
        "marks": list(marks),
        "fresh": fresh,
    }


def edges(points: Points, pairs: ArrayLike, role: str, **more: Any) -> Mark:
    """Return straight lines between pairs (m, 2) of places."""
    return {"kind": "edges", "points": _plain(points), "pairs": np.asarray(pairs).tolist(), "role": role, **more}


def vertices(points: Points, role: str, at: ArrayLike | None = None, **more: Any) -> Mark:
    """Return dots at places; ``at`` (k,) picks some of them."""
    return {"kind": "vertices", "points": _plain(points), "role": role, **_picked(at), **more}


def path(points: Points, role: str, at: ArrayLike | None = None, **more: Any) -> Mark:
    """Return a polyline through places; ``at`` (k,) picks and orders them."""
    return {"kind": "path", "points": _plain(points), "role": role, **_picked(at), **more}


def area(region: shapely.Geometry, role: str) -> Mark:
    """Return the area of polygons."""
    return {"kind": "area", "rings": rings_in(region), "role": role}


def obstacles(names: Sequence[str], role: str) -> Mark:
    """Return obstacles of the scene, by name."""
    return {"kind": "obstacles", "names": list(names), "role": role}


def note(at: Sequence[float], text: str) -> Mark:
    """Return a few words at a place."""
    return {"kind": "note", "at": [float(c) for c in at], "text": one_line(text)}


def band(scene: Scene, region: shapely.Geometry) -> Mark:
    """Return what the workspace has beyond a free region: where the centre of a robot may not be."""
    return area(shapely.difference(shapely.Polygon(scene.workspace), region), "grown")


def grown_obstacles(scene: Scene, some: Sequence[Obstacle], growth: float, arc_error: float = 1e-3) -> Mark:
    """Return obstacles grown by some metres, each by itself."""
    return area(shapely.union_all([grown(one, growth, arc_error, tol=scene.tol) for one in some]), "grown")


def metres(length: float) -> str:
    """Return a length for people."""
    return f"{length:.3f} m"


def count(n: int, one: str, many: str = "") -> str:
    """Return a number of things in words."""
    return f"{n} {one if n == 1 else many or one + 's'}"


def listed(names: Sequence[str], most: int = 8) -> str:
    """Return names in a sentence, and how many more there are."""
    shown = ", ".join(names[:most])
    return shown if len(names) <= most else f"{shown} and {len(names) - most} more"


def _plain(points: Points) -> Any:
    return points if isinstance(points, int) else np.asarray(points, dtype=np.float64).reshape(-1, 2).tolist()


def _picked(at: ArrayLike | None) -> dict[str, Any]:
    return {} if at is None else {"at": np.asarray(at, dtype=np.int64).tolist()}
