"""How near a team keeps together: the least range with which it would be connected at every instant."""

from __future__ import annotations

import heapq
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from taut.contact._strength_kernels import longest_needed
from taut.contact.blocks import Block, epochs
from taut.contact.connectivity import connected, failing_pieces
from taut.contact.core import Contacts, Ints
from taut.contact.motions import Motions, distance_bounds, motions_of
from taut.motion import Plan
from taut.scene import FloatArray

_CLOSE = 1e-6
"""Share of the range to which the bounds are brought together …"""

_MOST = 10_000
"""… unless that takes more halvings than this."""


@dataclass(frozen=True)
class NeededReach:
    """The least range with which a team is connected at every instant, between two bounds.

    Parameters
    ----------
    lower : metres; the team needs as much at ``time``.
    upper : metres; so much suffices at every instant.
    time : seconds.
    """

    lower: float
    upper: float
    time: float


def needed_reach(plan: Plan, contacts: Contacts) -> NeededReach | None:
    """Return the least range with which the team would be connected at every instant.

    Parameters
    ----------
    contacts : those of the plan with a range that keeps it connected; they also say whether sight is needed.

    Returns
    -------
    NeededReach or None
        The bounds are at most a millionth of the given range apart (more, if 10,000 halvings do not do it). None if
        the contacts do not keep the team connected, or if there are never two robots.

    Notes
    -----
    It is the greatest value over time of the longest link of a minimum spanning tree. On a stretch of time the tree of
    the greatest distances of lasting links bounds it from above, trees at single instants from below; the stretch with
    the greatest upper bound is halved until the greatest lower bound meets it.
    """
    if len(failing_pieces(contacts, connected)):
        return None
    motions = motions_of(plan)
    enough = contacts.reach + plan.scene.tol
    borders = np.append(contacts.times, max(contacts.until, contacts.times[-1]))  # nothing moves after
    lower, time = 0.0, -1.0
    heap: list[tuple[float, float, _Window]] = []
    todo = [_Window(borders[b.first], borders[b.last], b) for b in epochs(contacts) if b.n > 1]
    for _ in range(_MOST):
        for window in todo:
            for instant in _instants(window):
                needed = _needed(motions, window.block, _first_links(window.block), instant, instant)
                if needed > lower:
                    lower, time = needed, float(instant)
            upper = _needed(motions, window.block, window.block.throughout, window.begin, window.end)
            heapq.heappush(heap, (-upper, window.begin, window))
        if not heap:
            return None
        if -heap[0][0] - lower <= _CLOSE * enough:
            break
        todo = _halves(heapq.heappop(heap)[2], borders)
    upper = max(min(-heap[0][0], enough), lower)
    return NeededReach(lower, upper, time)


class _Window(NamedTuple):
    """A stretch of time: some pieces, or a part of one."""

    begin: float
    end: float
    block: Block


def _instants(window: _Window) -> list[float]:
    """Where to look: all of them have the links of the window's first piece."""
    return [window.begin] if window.block.last - window.block.first > 1 else [window.begin, window.end]


def _first_links(block: Block) -> Ints:
    return np.asarray(block.pairs[block.spans[:, 0] <= block.first])


def _needed(motions: Motions, block: Block, links: Ints, begin: float, end: float) -> float:
    """Longest link of the minimum spanning tree of these links and their greatest distances."""
    greatest = distance_bounds(motions, block.robots[links], begin, end)[1]
    return float(longest_needed(block.n, links, greatest, np.argsort(greatest)))


def _halves(window: _Window, borders: FloatArray) -> list[_Window]:
    block = window.block
    if block.last - block.first > 1:
        return [_Window(borders[half.first], borders[half.last], half) for half in block.halves]
    middle = (window.begin + window.end) / 2
    return [window._replace(end=middle), window._replace(begin=middle)]
