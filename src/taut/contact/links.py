"""From a plan to its contacts: the stretches of time in which each pair of robots is in contact, in closed form."""

from __future__ import annotations

import math

import numpy as np

from taut.chunks import over_chunks
from taut.contact._link_kernels import GROUP, contact_spans
from taut.contact.core import Contacts, Ints
from taut.contact.demand import Contact
from taut.contact.motions import Motions, motions_of, swept_boxes
from taut.contact.outlines import sight_sides
from taut.motion import Plan
from taut.scene import FloatArray

_CHUNK = 2000
"""Pairs that one thread takes at once."""

_SLABS = 16
"""Parts of time in which pairs are looked at to see whether they can be within reach."""

_ROUNDING = 2.0**-44
"""What rounding may do to bounds, in units, and more: a sixteenth of the tolerance at most."""


def contacts(plan: Plan, reach: float, sight: bool = False) -> Contacts:
    """When each pair of robots is in contact, over all time.

    Two robots are in contact while both are there and their centres are at most ``reach`` apart, the scene's tolerance
    included; with ``sight``, only while the line between their centres meets no obstacle and no wall farther in than
    the tolerance (`sight_sides`). Robots do not hide each other.

    Parameters
    ----------
    plan : it need not be a good one.
    reach : metres, > 0.
    sight : whether obstacles break contact.

    Raises
    ------
    SceneError
        ``reach`` is not positive; with ``sight``, a workspace or polygon that crosses itself.

    Notes
    -----
    On each stretch of time in which both robots of a pair move steadily the instants are roots of quadratics, so they
    are exact to rounding where a link breaks at some speed. O(pairs · stamps), times the sides between them.

    >>> from taut.motion import Trajectory
    >>> from taut.scene import Robot, Scene
    >>> scene = Scene((0, 0, 8, 8), robots=[Robot("R1", (1, 1), (7, 1)), Robot("R2", (1, 2), (1, 2))])
    >>> plan = Plan(scene, (Trajectory("R1", [[0, 1, 1], [6, 7, 1]]), Trajectory("R2", [[0, 1, 2]])))
    >>> contacts(plan, 1.25).ends.round(9).tolist()
    [0.75]
    """
    reach = Contact(reach, sight).reach
    scene = plan.scene
    motions = motions_of(plan)
    sides = sight_sides(scene, scene.tol) if sight else np.empty((0, 4))
    pairs, spans = _stretches(motions, (reach + scene.tol) / motions.unit, sides / motions.unit)
    order = np.lexsort((pairs[:, 1], pairs[:, 0], spans[:, 0]))
    begins, ends = spans[order].T.copy()
    changes = np.concatenate([[0.0], begins, ends, motions.gone])
    return Contacts(
        names=tuple(robot.name for robot in scene.robots),
        reach=float(reach),
        sight=sight,
        pairs=pairs[order],
        begins=begins,
        ends=ends,
        gone=motions.gone,
        until=plan.makespan,
        times=np.unique(changes[np.isfinite(changes)]),
    )


def _stretches(motions: Motions, reach: float, sides: FloatArray) -> tuple[Ints, FloatArray]:
    """Pairs (l, 2) and [begin, end] (l, 2) of all stretches; lengths in units."""
    candidates = _candidates(motions, reach)
    boxes = _boxes(sides)
    sides = np.ascontiguousarray(sides)

    def work(first: int, last: int) -> tuple[Ints, FloatArray]:
        chunk = candidates[first:last]
        who, spans = contact_spans(
            motions.t, motions.x, motions.y, motions.first, motions.gone, chunk, reach, sides, boxes
        )
        return chunk[who], spans

    done = over_chunks(work, len(candidates), _CHUNK)
    if not done:
        return np.empty((0, 2), dtype=np.int64), np.empty((0, 2))
    return np.concatenate([pairs for pairs, _ in done]), np.concatenate([spans for _, spans in done])


def _candidates(motions: Motions, reach: float) -> Ints:
    """Pairs i < j whose bounds are within reach in any slab of time."""
    n = len(motions.gone)
    if n < 2:
        return np.empty((0, 2), dtype=np.int64)
    x0, y0, x1, y1 = np.moveaxis(swept_boxes(motions, _SLABS), 2, 0).copy()
    found = []
    for i in range(n - 1):
        apart = np.maximum.reduce([x0[i + 1 :] - x1[i], x0[i] - x1[i + 1 :], y0[i + 1 :] - y1[i], y0[i] - y1[i + 1 :]])
        j = i + 1 + np.flatnonzero(apart.min(axis=1) <= reach + _ROUNDING)
        found.append(np.stack([np.full_like(j, i), j], axis=1))
    return np.concatenate(found).astype(np.int64)


def _boxes(sides: FloatArray) -> FloatArray:
    """Bounds of each group of sides."""
    count = math.ceil(len(sides) / GROUP)
    groups = [sides[k * GROUP : (k + 1) * GROUP] for k in range(count)]
    rows = [(*g.reshape(-1, 2).min(axis=0), *g.reshape(-1, 2).max(axis=0)) for g in groups]
    return np.array(rows, dtype=np.float64).reshape(-1, 4)
