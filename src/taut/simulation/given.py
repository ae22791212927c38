"""Numbers and arrays that callers give to sensors, checked once, with errors for people."""

from __future__ import annotations

import contextlib
import math
from collections.abc import Sequence
from numbers import Integral, Real

import numpy as np
from numpy.typing import ArrayLike, NDArray

from taut.scene import FloatArray

Ints = NDArray[np.int64]
Flags = NDArray[np.bool_]

TURN = 2.0 * math.pi
"""Radians."""


def fan_of(beams: int, field: float) -> tuple[float, ...]:
    """Return angles spread evenly over a field, in order; a full turn lacks its end, which is its beginning."""
    if isinstance(beams, bool) or not isinstance(beams, Integral) or beams < 1:
        raise ValueError(f"lidar: beams must be a whole number of at least 1, got {beams!r}")
    width = field_of(field, "lidar")
    if beams == 1:
        return (0.0,)
    return tuple(np.linspace(-width / 2, width / 2, int(beams), endpoint=width < TURN).tolist())


def field_of(value: float, what: str) -> float:
    """Check a field of view: radians, > 0, at most a full turn."""
    field = positive_of(value, f"{what}: field")
    if field > TURN:
        raise ValueError(f"{what}: field must be at most a full turn, 2π radians, got {field:g}")
    return field


def positive_of(value: float, what: str) -> float:
    """Check a finite number > 0."""
    number = number_of(value, what)
    if number <= 0:
        raise ValueError(f"{what} must be positive, got {number:g}")
    return number


def number_of(value: float, what: str) -> float:
    """Check a finite number."""
    number = math.nan
    if isinstance(value, Real) and not isinstance(value, bool):
        with contextlib.suppress(OverflowError):
            number = float(value)
    if not math.isfinite(number):
        raise ValueError(f"{what} must be a finite number, got {value!r}")
    return number


def count_of(value: int, what: str) -> int:
    """Check a whole number ≥ 0."""
    if isinstance(value, bool) or not isinstance(value, Integral) or not 0 <= value < 2**63:
        raise ValueError(f"{what} must be a whole number from 0 to 2⁶³ − 1, got {value!r}")
    return int(value)


def poses_of(poses: ArrayLike, count: int) -> FloatArray:
    """Check poses: (n, 3 or more) finite numbers, one row for each robot."""
    rows = rows_of(poses, 3, "poses")
    if len(rows) != count:
        raise ValueError(f"there must be a pose for each of the {count} robots, got {len(rows)}")
    return rows


def rows_of(values: ArrayLike, least: int, what: str) -> FloatArray:
    """Check rows of so many finite numbers or more."""
    try:
        rows = np.array(values, dtype=np.float64, order="C")
    except (TypeError, ValueError):
        raise ValueError(f"{what} must be rows of {least} or more numbers") from None
    if rows.size == 0:
        return np.empty((0, least))
    if rows.ndim != 2 or rows.shape[1] < least:
        raise ValueError(f"{what} must be an array (n, {least}), or with more columns; got shape {rows.shape}")
    bad = np.flatnonzero(~np.isfinite(rows[:, :least]).all(axis=1))
    if bad.size:
        raise ValueError(f"{what}: row {bad[0]} is not finite")
    return rows


def present_of(present: ArrayLike | None, count: int) -> Flags:
    """Check flags, one for each robot; all are there if not given."""
    if present is None:
        return np.ones(count, dtype=np.bool_)
    flags = np.array(present)
    if flags.shape != (count,) or (count and flags.dtype != np.bool_):
        raise ValueError(f"present must be {count} booleans, one for each robot")
    return flags.astype(np.bool_)


def robots_of(robots: Sequence[int] | Ints | None, count: int) -> Ints:
    """Check numbers of robots; all if not given."""
    if robots is None:
        return np.arange(count, dtype=np.int64)
    who = np.array(robots)
    if who.ndim != 1 or (who.size and who.dtype.kind not in "iu"):
        raise ValueError("robots must be a list of whole numbers")
    bad = np.flatnonzero((who < 0) | (who >= count))
    if bad.size:
        raise IndexError(f"there is no robot {who[bad[0]]}; the {count} robots are numbered from 0")
    return who.astype(np.int64)
