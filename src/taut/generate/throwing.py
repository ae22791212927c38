"""Random sequential placement: things are thrown in rounds until each lies apart from all others."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np
from numpy.typing import NDArray

ROUNDS = 400
"""Rounds of throwing before a scene is said not to fit …"""

IDLE = 20
"""… or so many in a row in which nothing found a place."""

JAM = 0.55
"""Discs thrown one after another never cover more than this share of the plane (0.547)."""


def throws(missing: NDArray[np.intp]) -> NDArray[np.intp]:
    """Return who throws in this round: everyone without a place, several times when few are left, (k,)."""
    return np.tile(missing, max(1, 200 // len(missing)))


def accepted(who: NDArray[np.intp], rivals: NDArray[np.intp], done: NDArray[np.bool_]) -> Iterator[int]:
    """Yield the throws that may stand, in order.

    Parameters
    ----------
    who : the thrower of each throw, (k,).
    rivals : pairs of throws that cannot both stand, (p, 2).
    done : who has a place; the caller sets ``done[who[k]]`` when it takes throw k, and may also decline it.
    """
    against: dict[int, list[int]] = {}
    for a, b in rivals.tolist():
        against.setdefault(a, []).append(b)
        against.setdefault(b, []).append(a)
    out: set[int] = set()
    for k, thrower in enumerate(who.tolist()):
        if k in out or done[thrower]:
            continue
        yield k
        if done[thrower]:
            out.update(against.get(k, ()))
