"""Places that a caller gives, as arrays; the one check of their shape and kind."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike, NDArray


def points_of(places: ArrayLike, what: str = "points") -> NDArray[np.float64]:
    """The places as an array (k, 2); one place (x, y) gives (1, 2), nothing at all (0, 2).

    Raises
    ------
    ValueError
        They are of another shape, or no real numbers. ``what`` names them in the message.

    >>> points_of([(0, 0), (3, 4)]).shape, points_of((1, 2)).shape, points_of([]).shape
    ((2, 2), (1, 2), (0, 2))
    """
    try:
        given = np.asarray(places)
        if given.dtype.kind not in "biufO":
            raise TypeError
        # a list of numbers too large for any array is an array of objects
        xy = given.astype(np.float64, copy=False)
    except (TypeError, ValueError, OverflowError):
        raise ValueError(f"{what} must be points (x, y) of real numbers, got {_shown(places)}") from None
    if xy.ndim in (1, 2) and xy.size == 0:
        return np.empty((0, 2))
    if xy.ndim == 0:
        raise ValueError(f"{what} must be points (x, y), got {_shown(places)}")
    if xy.ndim > 2 or xy.shape[-1] != 2:
        raise ValueError(f"{what} must be points (x, y) in an array (k, 2), got shape {xy.shape}")
    return xy.reshape(-1, 2)


def _shown(places: object) -> str:
    text = " ".join(repr(places).split())
    return text if len(text) <= 60 else text[:57] + "…"
