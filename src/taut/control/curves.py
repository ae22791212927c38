"""Smooth motions in polynomial pieces, and the straight legs that stay near them."""

from __future__ import annotations

from math import comb
from typing import TypeAlias

import numpy as np
from numpy.typing import NDArray

Floats: TypeAlias = NDArray[np.float64]

DEGREE = 7
"""Greatest degree of a piece; that of the solvers' interpolation."""

SHARES = np.linspace(0.0, 1.0, DEGREE + 1)
"""Where in a piece, as shares of its time, the control points stand."""


def legs(times: Floats, control: Floats, error: float) -> Floats:
    """Stamps of t, x, y whose straight legs are within ``error`` metres of a curve at every instant, (k, 3).

    Parameters
    ----------
    times : (s + 1,) seconds, strictly increasing: where the pieces of the curve begin and end.
    control : (s, 8, 2) metres, the control points of each piece (Bernstein coefficients over its time); the first and
        last are its ends.
    error : metres, > 0.

    Notes
    -----
    A leg, too, has control points: the places on it at equal shares of a piece's time. A polynomial lies in the convex
    hull of its control points, so the curve is nowhere farther from the leg than the farthest pair of them. Where that
    is too far, the pieces are shared between two legs; a piece alone is halved until its parts are straight enough, or
    no double is left between their ends.
    """
    stamps = [np.array([[times[0], *control[0, 0]]])]
    todo = [(0, len(control))]
    while todo:
        a, b = todo.pop()
        shares = (times[a:b, None] + np.diff(times[a : b + 1])[:, None] * SHARES - times[a]) / (times[b] - times[a])
        start, end = control[a, 0], control[b - 1, -1]
        if _lengths(control[a:b] - start - shares[..., None] * (end - start)).max() <= error:
            stamps.append(np.array([[times[b], *end]]))
        elif b - a > 1:
            middle = (a + b) // 2
            todo += [(middle, b), (a, middle)]
        else:
            stamps.append(_legs_of_piece(times[a], times[b], control[a], error))
    return np.concatenate(stamps)


def _legs_of_piece(begin: float, end: float, control: Floats, error: float) -> Floats:
    """Stamps at the ends of the parts of one piece, (k, 3); all parts that are too bent are halved at once."""
    ends, parts = np.array([begin, end]), control[None]
    while True:
        chords = parts[:, :1] + SHARES[:, None] * (parts[:, -1:] - parts[:, :1])
        middles = (ends[:-1] + ends[1:]) / 2
        bent = _lengths(parts - chords).max(axis=1) > error
        bent &= (ends[:-1] < middles) & (middles < ends[1:])
        if not bent.any():
            return np.column_stack([ends[1:], parts[:, -1]])
        halves = np.repeat(parts, 1 + bent, axis=0)
        second = np.cumsum(1 + bent)[bent] - 1
        halves[second - 1], halves[second] = _FIRST_HALF @ parts[bent], _SECOND_HALF @ parts[bent]
        ends, parts = np.insert(ends, np.flatnonzero(bent) + 1, middles[bent]), halves


def _lengths(vectors: Floats) -> Floats:
    lengths: Floats = np.hypot(vectors[..., 0], vectors[..., 1])
    return lengths


# de Casteljau's subdivision in the middle, as matrices on the control points
_FIRST_HALF = np.array([[comb(k, j) / 2**k for j in range(DEGREE + 1)] for k in range(DEGREE + 1)])
_SECOND_HALF = _FIRST_HALF[::-1, ::-1]
