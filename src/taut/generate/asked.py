"""What is asked of a generator: whole numbers, numbers and spans of numbers, checked."""

from __future__ import annotations

import math
from typing import Any

import numpy as np

from taut.errors import SceneError

_NUMBERS = (1e-9, 1e7)  # every length, speed and time that is not zero


def whole(value: Any, what: str, most: float = math.inf) -> int:
    """Return a whole number from 0 to ``most``."""
    if isinstance(value, bool) or not isinstance(value, int | np.integer) or value < 0:
        raise SceneError(f"{what} must be a whole number, 0 or more, got {value!r}")
    if value > most:
        raise SceneError(f"{what} must be at most {most}, got {value}")
    return int(value)


def finite(value: Any, what: str) -> float:
    """Return a finite number."""
    try:
        number = float(value)
    except (TypeError, ValueError, OverflowError):
        raise SceneError(f"{what} must be a number, got {value!r}") from None
    if not math.isfinite(number):
        raise SceneError(f"{what} must be a finite number, got {value!r}")
    return number


def span(value: Any, what: str, positive: bool = False) -> tuple[float, float]:
    """Return a number, or a lowest and a highest, as a pair; zero or from 1e-9 to 1e7."""
    ends = (value, value) if np.ndim(value) == 0 else tuple(value)
    if len(ends) != 2:
        raise SceneError(f"{what} must be a number or (lowest, highest), got {value!r}")
    low, high = (finite(end, what) for end in ends)
    if low > high or low < 0 or (positive and low == 0):
        raise SceneError(f"{what} must be {'above 0' if positive else '0 or more'}, lowest first, got {value!r}")
    for end in (low, high):
        if end:
            within(end, _NUMBERS, what, "")
    return low, high


def within(value: float, ends: tuple[float, float], what: str, unit: str) -> None:
    """Refuse a number outside a span."""
    if not ends[0] <= value <= ends[1]:
        raise SceneError(f"{what} must be between {ends[0]:g} and {ends[1]:g}{unit}, got {value:g}")
