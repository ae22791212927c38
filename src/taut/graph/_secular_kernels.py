"""Kernels of rank-one updates: the first root of the secular equation of a Laplacian that gains or loses an edge.

With eigenpairs (λ_k, q_k) and z_k = q_k[u] − q_k[v], an edge u-v of weight w makes the eigenvalues the roots of
f(μ) = 1 + w Σ z_k² / (λ_k − μ). Between its two smallest poles a and a + g, F(x) = x (g − x) f(a + x) has no poles, and
the least eigenvalue is its root. Poles of residue 0 and coinciding poles need no care: the bracket [a, a + g] closes.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from taut.compiling import kernel

Floats = NDArray[np.float64]
Ints = NDArray[np.int64]

_MOST_STEPS = 200


@kernel
def gains(values: Floats, vectors: Floats, pairs: Ints, weights: Floats) -> Floats:
    """Least eigenvalue after adding each of the edges alone: (p,) values, (n, p) vectors, (m, 2) pairs."""
    out = np.empty(pairs.shape[0])
    squares = np.empty(values.shape[0])
    width = values[-1] * 2.0**-51
    for i in range(pairs.shape[0]):
        _square_differences(vectors, pairs[i, 0], pairs[i, 1], squares)
        out[i] = _gained(values, squares, weights[i], width)
    return out


@kernel
def losses(values: Floats, vectors: Floats, pairs: Ints, weights: Floats) -> Floats:
    """Least eigenvalue after removing each of the edges alone."""
    out = np.empty(pairs.shape[0])
    squares = np.empty(values.shape[0])
    width = values[-1] * 2.0**-51
    for i in range(pairs.shape[0]):
        _square_differences(vectors, pairs[i, 0], pairs[i, 1], squares)
        out[i] = _lost(values, squares, weights[i], width)
    return out


@kernel
def _square_differences(vectors: Floats, u: int, v: int, out: Floats) -> None:
    """Write z_k² of the pair u, v."""
    for k in range(out.shape[0]):
        z = vectors[u, k] - vectors[v, k]
        out[k] = z * z


@kernel
def _gained(values: Floats, squares: Floats, weight: float, width: float) -> float:
    """Least eigenvalue after adding: ascending ``values``, ``squares`` z_k²; stops at steps of ``width``."""
    first = float(values[0])
    if weight * squares[0] == 0.0:
        return first
    total = 0.0
    for k in range(values.shape[0]):
        total += squares[k]
    most = first + weight * total
    if values.shape[0] == 1:
        return float(most)
    g = values[1] - first
    s0, s1 = weight * squares[0], weight * squares[1]
    low, high = 0.0, min(g, most - first)
    x = min(s0 * g / (s0 + s1 + g), 0.5 * high)
    for _ in range(_MOST_STEPS):
        if high - low <= width:
            break
        rest, slope = 1.0, 0.0
        for k in range(2, values.shape[0]):
            away = values[k] - first - x
            share = weight * squares[k] / away
            rest += share
            slope += share / away
        value = s1 * x - s0 * (g - x) + rest * x * (g - x)
        rise = s0 + s1 + rest * (g - 2.0 * x) + slope * x * (g - x)
        before = x
        x, low, high = _stepped(x, value, rise, low, high)
        if abs(x - before) <= width:
            break
    return float(first + x)


@kernel
def _lost(values: Floats, squares: Floats, weight: float, width: float) -> float:
    """Least eigenvalue after removing; arguments as above."""
    first = float(values[0])
    s0 = weight * squares[0]
    low, high = 0.0, first
    x = s0 if 0.0 < s0 < 0.5 * high else 0.5 * high
    for _ in range(_MOST_STEPS):
        if high - low <= width:
            break
        rest, slope = 1.0, 0.0
        for k in range(1, values.shape[0]):
            away = values[k] - first + x
            share = weight * squares[k] / away
            rest -= share
            slope += share / away
        value = rest * x - s0
        rise = rest + slope * x
        before = x
        x, low, high = _stepped(x, value, rise, low, high)
        if abs(x - before) <= width:
            break
    return float(first - x)


@kernel
def _stepped(x: float, value: float, rise: float, low: float, high: float) -> tuple[float, float, float]:
    """Take a step of Newton's from x, or bisect where it leaves the bracket: the next x, and the bracket, narrowed."""
    if value < 0.0:
        low = x
    else:
        high = x
    following = x - value / rise if rise > 0.0 else low
    if not low < following < high:
        following = 0.5 * (low + high)
    return following, low, high
