"""Kernels for pictures of graphs."""

from __future__ import annotations

import numpy as np

from taut.compiling import kernel
from taut.graph.core import Floats, Ints


@kernel
def crossings(ends: Floats, wide: int, high: int) -> Ints:
    """How many of the segments, (m, 4) x, y, x, y in pixels, pass each pixel, (high, wide); what lies beyond is cut."""
    counts = np.zeros((high, wide), dtype=np.int64)
    for e in range(ends.shape[0]):
        x, y = ends[e, 0], ends[e, 1]
        across, up = ends[e, 2] - x, ends[e, 3] - y
        steps = max(1, int(max(abs(across), abs(up))))
        for k in range(steps):
            share = (k + 0.5) / steps
            column, row = int(np.floor(x + share * across)), int(np.floor(y + share * up))
            if 0 <= column < wide and 0 <= row < high:
                counts[row, column] += 1
    return counts
