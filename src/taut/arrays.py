"""Arrays that kernels fill without knowing how much will come: longer, higher, cut to what was filled.

Loops, because assignment to slices compiles ten times as long.
"""

from __future__ import annotations

from typing import TypeVar

import numpy as np
from numpy.typing import NDArray

from taut.compiling import kernel

Floats = NDArray[np.float64]
Ints = NDArray[np.int64]
_Array = TypeVar("_Array", Ints, Floats)


@kernel
def longer(a: _Array) -> _Array:
    """Copy to twice the length."""
    out = np.empty(2 * a.shape[0], dtype=a.dtype)
    for i in range(a.shape[0]):
        out[i] = a[i]
    return out


@kernel
def higher(rows: _Array) -> _Array:
    """Copy to twice as many rows."""
    out = np.empty((2 * rows.shape[0], rows.shape[1]), dtype=rows.dtype)
    for i in range(rows.shape[0]):
        for k in range(rows.shape[1]):
            out[i, k] = rows[i, k]
    return out


@kernel
def head(a: Ints, n: int) -> Ints:
    """Copy of the first n entries."""
    out = np.empty(n, dtype=np.int64)
    for i in range(n):
        out[i] = a[i]
    return out
