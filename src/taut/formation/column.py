"""Through a narrow place in a column: robots leave one formation in turn and take their places in another.

Each robot gets a way of its own past those that have not left yet and those that have already arrived. So they get
through at least one after the other, and are then timed as close behind each other as their sizes allow: all take
steps of equal duration, and each robot in turn finds the earliest way to rest and go between those timed before.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from itertools import pairwise
from typing import Literal

import numpy as np
import shapely

from taut.contact.demand import Contact
from taut.errors import NoPath, SceneError
from taut.formation import _timing_kernels
from taut.formation.linking import first_loss, moved
from taut.formation.shape import Shape
from taut.freespace import FreeSpace
from taut.geometry.overlay import remainder
from taut.geometry.triangulation import meshed
from taut.route.core import Route
from taut.route.direct import direct_lengths, direct_paths
from taut.route.smoothing import smoothed
from taut.scene import FloatArray

_STEPS = 4  # in which a robot moves at most as far as two keep apart
_LONGEST = 400  # steps of one way, about
_PACES = (1.0, 0.5, 0.25)  # of the first, where the others have to keep up


@dataclass(frozen=True, eq=False)
class Column:
    """How a team gets from one formation to another, one behind the other.

    Parameters
    ----------
    order : numbers of the robots, who goes first first.
    seconds : (m,) from the begin on, in equal steps.
    places : (m, n, 2) metres, where all robots are then; straight and steady in between.
    """

    order: tuple[int, ...]
    seconds: FloatArray
    places: FloatArray


@dataclass(frozen=True)
class NoColumn:
    """That none was found, and at which end of the narrow place those who stand seem to be in the way.

    Where neither end stands out, as where contact would be lost, it is "both".
    """

    reason: Literal["begin", "end", "both"]


def column(
    shape: Shape, begin: FloatArray, end: FloatArray, middle: FloatArray, demand: Contact | None
) -> Column | NoColumn:
    """Find a way for all robots from ``begin`` (n, 2) to ``end`` (n, 2) by way of one place (2,) that keeps contact."""
    reason: Literal["begin", "end", "both"] = "begin"
    for order in _orders(shape, begin, end, middle):
        ways = _ways(shape, order, begin, end, middle)
        if isinstance(ways, NoColumn):
            reason = ways.reason if reason == "begin" else reason
            continue
        reason = "both"
        for pace in (1.0,) if demand is None else _PACES:
            found = _timed(shape, order, ways, pace, math.inf if demand is None else demand.reach)
            if found is not None and (demand is None or _keeps(shape, found, demand)):
                return found
    return NoColumn(reason)


def _keeps(shape: Shape, found: Column, demand: Contact) -> bool:
    return first_loss(moved(shape.scene, found.seconds, found.places), demand) is None


def _orders(shape: Shape, begin: FloatArray, end: FloatArray, middle: FloatArray) -> list[tuple[int, ...]]:
    """Orders worth trying: by who is nearest to the narrow place and who goes farthest beyond it, both and each."""
    try:
        to = np.array([direct_lengths(s, a, middle)[0][0] for s, a in zip(shape.spaces, begin, strict=True)])
        on = np.array([direct_lengths(s, middle, b)[0][0] for s, b in zip(shape.spaces, end, strict=True)])
    except SceneError:  # the place has no room for one of them
        return []
    if not (np.isfinite(to) & np.isfinite(on)).all():
        return []
    return list(dict.fromkeys(tuple(np.argsort(key, kind="stable").tolist()) for key in (to - on, to, -on)))


def _ways(
    shape: Shape, order: tuple[int, ...], begin: FloatArray, end: FloatArray, middle: FloatArray
) -> list[FloatArray] | NoColumn:
    """The way of each robot in turn, past those behind it at their begin and those before it at their end."""
    out, late = [], False
    for k, i in enumerate(order):
        ahead, behind = list(order[:k]), list(order[k + 1 :])
        discs = np.concatenate([begin[behind], end[ahead]])
        facing = np.repeat([begin[i], end[i]], [len(behind), len(ahead)], axis=0)
        space = _without(shape.spaces[i], discs, shape.needed[i, behind + ahead], facing)
        halves = []
        for a, b in ((begin[i], middle), (middle, end[i])):
            try:
                halves += direct_paths(space, a, b)
            except (NoPath, SceneError):
                if not halves:
                    return NoColumn("begin")
                late = True
        if not late:
            points = np.concatenate([halves[0].points, halves[1].points[1:]])
            out.append(smoothed(space, Route(points)).points if len(points) > 1 else points)
    return NoColumn("end") if late else out


def _without(space: FreeSpace, centres: FloatArray, radii: FloatArray, facing: FloatArray) -> FreeSpace:
    """A free space without discs about (k, 2) centres, drawn outside their arcs but not towards the points faced."""
    if not len(centres):
        return space
    sides = math.ceil(math.pi / math.acos(1.0 / (1.0 + space.arc_error)))
    towards = np.arctan2(*(facing - centres).T[::-1])
    angle = towards[:, None] + 2 * math.pi * (np.arange(sides) + 0.5) / sides
    unit = np.stack([np.cos(angle), np.sin(angle)], axis=-1) / math.cos(math.pi / sides)
    discs = shapely.polygons(centres[:, None] + radii[:, None, None] * unit)
    parts = shapely.get_parts(remainder(space.region, discs, space.scene.tol))
    left = shapely.multipolygons(parts[shapely.get_type_id(parts) == shapely.GeometryType.POLYGON])
    return FreeSpace.with_mesh(space.scene, space.growth, space.arc_error, *meshed(left, space.scene.tol))


def _timed(shape: Shape, order: tuple[int, ...], ways: list[FloatArray], pace: float, reach: float) -> Column | None:
    """Time the robots in turn, each as early as those before allow; None if a robot would lose contact.

    Parameters
    ----------
    pace : at what part of its speed the first one goes.
    reach : metres within which every robot keeps of one that goes before it; may be inf.
    """
    step = shape.spacing / _STEPS / float(shape.speeds.max())
    lengths = [float(np.hypot(*np.diff(way, axis=0).T).sum()) for way in ways]
    step = max(step, max(length / shape.speeds[i] for i, length in zip(order, lengths, strict=True)) / _LONGEST)
    done: list[FloatArray] = []
    for k, i in enumerate(order):
        stops = _stops(ways[k], shape.speeds[i] * step * (1.0 if k else pace))
        horizon = max((len(path) for path in done), default=1) + len(stops)
        others = np.array([_resting(path, horizon) for path in done]).reshape(k, horizon, 2)
        needed = shape.needed[i, list(order[:k])] - shape.scene.tol / 2
        times = _timing_kernels.earliest(stops, others, needed, reach + shape.scene.tol / 2)
        if not len(times):
            return None
        done.append(stops[times])
    last = max(len(path) for path in done)
    places = np.empty((last, len(order), 2))
    for i, path in zip(order, done, strict=True):
        places[:, i] = _resting(path, last)
    return Column(order, step * np.arange(last, dtype=np.float64), places)


def _stops(way: FloatArray, longest: float) -> FloatArray:
    """Bends of a way and stops between them, at most so many metres apart."""
    out = [way[:1]]
    for a, b in pairwise(way):
        count = max(1, math.ceil(float(np.hypot(*(b - a))) / longest * (1.0 - 1e-12)))
        share = np.arange(1, count + 1)[:, None] / count
        out.append(np.where(share == 1, b, a + share * (b - a)))
    return np.concatenate(out)


def _resting(path: FloatArray, length: int) -> FloatArray:
    """The path (m, 2), then its last place until there are so many."""
    return np.concatenate([path, np.repeat(path[-1:], length - len(path), axis=0)]) if len(path) < length else path
