"""Partners: robots planned before, with some of which the next one has to stay in contact."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from taut.contact.demand import Contact
from taut.motion import Trajectory
from taut.scene import Scene
from taut.team._conflict_kernels import Floats, Ints
from taut.team._contact_kernels import Partners
from taut.team._sight_kernels import Walls
from taut.team.reservations import legs_of

_MOST_CELLS = 64  # in a row or a column of the grid of sides
_DARK = 1 << 10  # stretches out of sight in one question


def walls_of(sides: Floats) -> Walls:
    """Put sides (s, 4), x0, y0, x1, y1 metres, that block the sight into a grid of cells."""
    sides = np.ascontiguousarray(sides, dtype=np.float64).reshape(-1, 4)
    ends = sides.reshape(-1, 2)
    low = ends.min(axis=0) if len(ends) else np.zeros(2)
    extent = float((ends.max(axis=0) - low).max()) if len(ends) else 1.0
    cells = int(min(max(np.sqrt(len(sides)), 1), _MOST_CELLS))
    step = extent * (1 + 1e-9) / cells
    first, last = (np.clip((at - low) // step, 0, cells - 1).astype(np.int64) for at in (sides[:, :2], sides[:, 2:]))
    near: list[list[int]] = [[] for _ in range(cells * cells)]
    for i, (a, b) in enumerate(zip(first.tolist(), last.tolist(), strict=True)):
        for row in range(min(a[1], b[1]), max(a[1], b[1]) + 1):
            for col in range(min(a[0], b[0]), max(a[0], b[0]) + 1):
                near[row * cells + col].append(i)
    return Walls(
        sides=sides,
        frame=np.array([low[0], low[1], step]),
        shape=np.array([cells, cells], dtype=np.int64),
        cell_first=_firsts([len(some) for some in near]),
        cell_side=np.array([i for some in near for i in some], dtype=np.int64),
        seen=np.zeros(len(sides), dtype=np.int64),
        mark=np.zeros(1, dtype=np.int64),
        dark=np.empty((_DARK, 2)),
    )


def partners_of(scene: Scene, motions: Sequence[Trajectory], contact: Contact, walls: Walls, need: int) -> Partners:
    """Put partners' motions into arrays; all of them stay at their goals.

    Parameters
    ----------
    need : with how many of them the robot has to be in contact at every instant.
    """
    legs = [legs_of(motion, True) for motion in motions]
    rows = np.concatenate(legs) if legs else np.empty((0, 6))
    count = 4 * len(rows) + 64
    pace = np.zeros((len(rows), 2))
    moving = np.isfinite(rows[:, 5])
    pace[moving] = (rows[moving, 3:5] - rows[moving, 0:2]) / (rows[moving, 5] - rows[moving, 2])[:, None]
    slowest = min(robot.speed for robot in scene.robots)
    return Partners(
        legs=rows,
        pace=pace,
        first=_firsts([len(some) for some in legs]),
        reach=np.array([contact.reach + scene.tol / 4, contact.reach / slowest * 2.0**-20]),
        need=np.array([need], dtype=np.int64),
        walls=walls,
        since=np.empty(count),
        till=np.empty(count),
        tally=np.zeros(1, dtype=np.int64),
    )


def _firsts(sizes: Sequence[int]) -> Ints:
    return np.concatenate([[0], np.cumsum(np.asarray(sizes, dtype=np.int64))]).astype(np.int64)
