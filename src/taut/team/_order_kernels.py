"""Kernels of order search: which motions are too near to which."""

from __future__ import annotations

from math import inf

import numpy as np

from taut.compiling import kernel
from taut.team._conflict_kernels import Floats, edge_conflict, rest_conflict
from taut.team._table_kernels import Table


@kernel
def meeting_times(table: Table, who: int, legs: Floats, apart: float, headway: float, robots: int) -> Floats:
    """When each robot of the table is first on a leg on which it comes too near to these legs of robot ``who``.

    Parameters
    ----------
    legs : (k, 6) x0, y0, t0, x1, y1, t1; t1 is inf where it rests for ever.
    apart, headway : metres between centres less the other's radius, seconds.

    Returns
    -------
    (robots,) seconds, inf for those that keep away.
    """
    first = np.full(robots, inf)
    for a in range(table.robot.shape[0]):
        other = table.robot[a]
        if other < 0 or other == who:
            continue
        d = apart + table.radius[a]
        x0, y0, t0 = table.legs[a, 0], table.legs[a, 1], table.legs[a, 2]
        x1, y1, t1 = table.legs[a, 3], table.legs[a, 4], table.legs[a, 5]
        for k in range(legs.shape[0]):
            ax, ay, begin = legs[k, 0], legs[k, 1], legs[k, 2]
            bx, by, end = legs[k, 3], legs[k, 4], legs[k, 5]
            since = max(begin, t0)
            if since >= first[other] or begin - headway >= t1 or t0 - headway >= end:
                continue
            if max(ax, bx) + d <= min(x0, x1) or max(x0, x1) + d <= min(ax, bx):
                continue
            if max(ay, by) + d <= min(y0, y1) or max(y0, y1) + d <= min(ay, by):
                continue
            if end == inf:
                found, _, until = rest_conflict(ax, ay, x0, y0, t0, x1, y1, t1, d)
                if found and until + headway > begin:
                    first[other] = since
                continue
            found, lo, hi = edge_conflict(ax, ay, bx, by, end - begin, x0, y0, t0, x1, y1, t1, d)
            if found and lo - headway < begin < hi + headway:
                first[other] = since
    return first
