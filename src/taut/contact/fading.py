"""λ2 over time when links weigh less the longer they are: guaranteed bounds on pieces of time."""

from __future__ import annotations

from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from taut.contact.blocks import epochs
from taut.contact.core import Contacts, Ints
from taut.contact.links import contacts
from taut.contact.motions import Motions, distance_bounds, motions_of
from taut.contact.spectra import fiedler_of_each, one_thread
from taut.errors import SceneError
from taut.graph import Weight
from taut.motion import Plan
from taut.scene import FloatArray

_SHORTEST = 2.0**-40
"""Share of the plan's time below which a piece is not cut any more."""


@dataclass(frozen=True, eq=False)
class FadingFiedler:
    """Bounds on λ2 over time.

    Parameters
    ----------
    times : (m,) begin of each piece, seconds; a piece ends where the next begins, and the last lasts for ever.
    lower, upper : (m,) λ2 is between them at every instant of the piece.
    values : (m,) λ2 at the begin of each piece, with the links of the piece.
    """

    times: FloatArray
    lower: FloatArray
    upper: FloatArray
    values: FloatArray

    @property
    def worst(self) -> tuple[float, float, float]:
        """Bounds of the least λ2 over all time, and the begin of the piece that has the least lower one."""
        piece = int(np.argmin(self.lower))
        return float(self.lower[piece]), float(min(self.upper.min(), self.values.min())), float(self.times[piece])


def fading_fiedler(plan: Plan, reach: float, weight: Weight, sight: bool = False, width: float = 1e-3) -> FadingFiedler:
    """Bound λ2 over all time for links whose weight does not increase with their length (thesis (8.13)).

    Parameters
    ----------
    reach : metres; robots farther apart have no link. See `contacts`.
    weight : from lengths to weights ≥ 0, such as `taut.graph.fading`.
    width : pieces are halved until their bounds are at most width · max(1, upper) apart; so they are at every instant
        where the weight is continuous. Only pieces of 2⁻⁴⁰ of the plan's time stay wider.

    Raises
    ------
    SceneError
        As `contacts`; ``width`` is not positive.
    ValueError
        A weight that is negative, not finite, not one number a link, or increases with the length.

    Notes
    -----
    λ2 grows with every weight. So on a piece with the same links throughout, their least distances bound it from
    above and their greatest from below; both are closed forms. Bounds and values are exact to the rounding of
    eigenvalues, about 1e-12 of the greatest.

    >>> from taut.graph import fading
    >>> from taut.motion import Trajectory
    >>> from taut.scene import Robot, Scene
    >>> scene = Scene((0, 0, 8, 8), robots=[Robot("R1", (1, 1), (4, 1)), Robot("R2", (1, 1), (1, 1))])
    >>> plan = Plan(scene, (Trajectory("R1", [[0, 1, 1], [3, 4, 1]]), Trajectory("R2", [[0, 1, 1]])))
    >>> found = fading_fiedler(plan, 6.0, fading(lambda d: 1 - d / 6, 6.0), width=0.25)
    >>> found.times.tolist(), found.values.tolist()
    ([0.0, 1.5, 2.25, 3.0], [2.0, 1.5, 1.25, 1.0])
    """
    if not width > 0:
        raise SceneError(f"contact: width must be positive, got {width}")
    found = contacts(plan, reach, sight)
    motions = motions_of(plan)
    shortest = _SHORTEST * found.until
    done: list[tuple[float, float, float, float]] = []
    todo = _pieces(found)
    while todo:
        lower, upper, values = _bounds(motions, weight, reach, todo)
        wide = upper - lower > width * np.maximum(1.0, upper)
        halves = []
        for k, piece in enumerate(todo):
            middle = (piece.begin + piece.end) / 2
            if wide[k] and piece.end - piece.begin > shortest and piece.begin < middle < piece.end:
                halves += [piece._replace(end=middle), piece._replace(begin=middle)]
            else:
                done.append((piece.begin, float(lower[k]), float(upper[k]), float(values[k])))
        todo = halves
    done.sort()
    return FadingFiedler(*np.array(done, dtype=np.float64).reshape(-1, 4).T.copy())


class _Piece(NamedTuple):
    """A stretch of time in which n robots are there, with their links by number among them and in the plan."""

    begin: float
    end: float
    n: int
    links: Ints
    robots: Ints


def _pieces(found: Contacts) -> list[_Piece]:
    """Return all pieces of the contacts, and at last the instant from which on nothing moves."""
    ends = np.append(found.times[1:], max(found.until, found.times[-1])).tolist()
    out = []
    for block in epochs(found):
        first, last = block.spans.T
        for piece in range(block.first, block.last):
            links = block.pairs[(first <= piece) & (piece < last)]
            out.append(_Piece(float(found.times[piece]), ends[piece], block.n, links, block.robots[links]))
    if out[-1].begin < out[-1].end:
        out.append(out[-1]._replace(begin=out[-1].end))
    return out


def _bounds(
    motions: Motions, weight: Weight, reach: float, pieces: list[_Piece]
) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Lower and upper bound of each piece, and the value at its begin."""
    weights: list[list[FloatArray]] = [[], [], []]
    for piece in pieces:
        least, greatest = distance_bounds(motions, piece.robots, piece.begin, piece.end)
        now = distance_bounds(motions, piece.robots, piece.begin, piece.begin)[0]
        for k, lengths in enumerate((greatest, least, now)):
            # what is within reach by the tolerance only counts as within reach
            given = np.asarray(weight(np.minimum(lengths, reach)), dtype=np.float64)
            if given.shape != lengths.shape:
                raise ValueError(f"the weight of {len(lengths)} links has shape {given.shape}: give one value a link")
            weights[k].append(given)
        _check(weights[0][-1], weights[1][-1])
    out = np.zeros((3, len(pieces)))
    sizes = np.array([piece.n for piece in pieces])
    with one_thread():
        for n in np.unique(sizes):
            own = np.flatnonzero(sizes == n)
            links = [pieces[k].links for k in own]
            for row, each in zip(out, weights, strict=True):
                row[own] = fiedler_of_each(int(n), links, [each[k] for k in own])
    return out[0], out[1], out[2]


def _check(farthest: FloatArray, nearest: FloatArray) -> None:
    if not (np.isfinite(nearest).all() and (farthest >= 0).all()):
        raise ValueError("the weight of a link must be finite and not negative")
    if (farthest > nearest).any():
        raise ValueError("the weight of a link must not increase with its length")
