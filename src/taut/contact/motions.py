"""The motions of a plan as flat arrays, in a unit of length in which no square overflows."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from taut.contact._link_kernels import distances
from taut.motion import Plan
from taut.scene import FloatArray

# A stamp so many times farther out than the whole scene is far from everybody; farther ones are drawn in to here.
_FAR = 2.0**20


@dataclass(frozen=True, eq=False)
class Motions:
    """Stamps of all robots up to their arrival, one after the other; robot r at first[r]:first[r+1].

    Parameters
    ----------
    t : (S,) seconds.
    x, y : (S,) in units.
    first : (n + 1,).
    gone : (n,) seconds from which a robot is no more there; inf if it stays.
    unit : metres, the power of two above the largest coordinate of the scene.
    """

    t: FloatArray
    x: FloatArray
    y: FloatArray
    first: NDArray[np.int64]
    gone: FloatArray
    unit: float


def motions_of(plan: Plan) -> Motions:
    """Flatten a plan; rests after the arrival are dropped, as robots that stay rest for ever."""
    unit = 2.0 ** math.frexp(plan.scene.tol * 2.0**40)[1]
    arrivals = [path.arrival for path in plan.trajectories]
    own = [
        path.stamps[: int(np.searchsorted(path.times, arrival)) + 1]
        for path, arrival in zip(plan.trajectories, arrivals, strict=True)
    ]
    stamps = np.concatenate(own) if own else np.empty((0, 3))
    first = np.concatenate([[0], np.cumsum([len(s) for s in own])]).astype(np.int64)
    stays = [plan.scene.stays(robot) for robot in plan.scene.robots]
    gone = np.where(np.array(stays, dtype=np.bool_), np.inf, np.array(arrivals, dtype=np.float64))
    with np.errstate(over="ignore"):
        x, y = np.clip(stamps[:, 1:].T / unit, -_FAR, _FAR)
    t, x, y = (np.ascontiguousarray(a) for a in (stamps[:, 0], x, y))
    return Motions(t, x, y, first, gone, unit)


def distance_bounds(
    motions: Motions, pairs: NDArray[np.int64], begin: float, end: float
) -> tuple[FloatArray, FloatArray]:
    """Return the least and the greatest distance of each pair in a stretch of time, (p,) metres each."""
    arguments = motions.t, motions.x, motions.y, motions.first, np.ascontiguousarray(pairs)
    least, greatest = distances(*arguments, begin, end)
    return least * motions.unit, greatest * motions.unit


def place_at(motions: Motions, robot: int, time: float) -> FloatArray:
    """Return where a robot is at a time, (2,) metres; where it left, once it has."""
    own = slice(motions.first[robot], motions.first[robot + 1])
    return np.array([np.interp(time, motions.t[own], c[own]) for c in (motions.x, motions.y)]) * motions.unit


def swept_boxes(motions: Motions, slabs: int) -> FloatArray:
    """Bounds xmin, ymin, xmax, ymax of each robot in each of some slabs of time, (n, slabs, 4) in units, to rounding.

    The slabs hold about as many stamps each, and the last also all time after.
    """
    borders = np.quantile(motions.t, np.linspace(0.0, 1.0, slabs + 1))
    out = np.empty((len(motions.gone), slabs, 4))
    for r, own in enumerate(out):
        part = slice(motions.first[r], motions.first[r + 1])
        times = np.sort(np.concatenate([motions.t[part], borders]))
        begin = np.searchsorted(times, borders)
        for k, coordinates in enumerate((motions.x[part], motions.y[part])):
            c = np.interp(times, motions.t[part], coordinates)
            own[:, k] = np.minimum(np.minimum.reduceat(c, begin[:-1]), c[begin[1:]])
            own[:, k + 2] = np.maximum(np.maximum.reduceat(c, begin[:-1]), c[begin[1:]])
    return out
