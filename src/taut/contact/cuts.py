"""Robots whose loss would split the team, and when."""

from __future__ import annotations

import numpy as np

from taut.contact.connectivity import stretches
from taut.contact.core import Contacts
from taut.graph import Graph, cut_vertices
from taut.scene import FloatArray


def cut_times(contacts: Contacts) -> dict[int, FloatArray]:
    """Return for each robot that ever is a cut vertex, in ascending order, when: (q, 2) as [from, until] in seconds.

    The last may reach to inf. O(n + links) for each piece.

    >>> from taut.contact import contacts
    >>> from taut.motion import Plan, Trajectory
    >>> from taut.scene import Robot, Scene
    >>> robots = [Robot(f"R{k}", (k, 1), (k, 1)) for k in (1, 2, 3)]
    >>> plan = Plan(Scene((0, 0, 4, 4), robots=robots), tuple(Trajectory(r.name, [[0, *r.start]]) for r in robots))
    >>> cut_times(contacts(plan, 1.5))[1].tolist()
    [[0.0, inf]]
    """
    n = len(contacts.names)
    first, last = contacts.spans.T
    alone = np.zeros((len(contacts.times), n), dtype=np.bool_)
    for piece in range(len(alone)):
        links = contacts.pairs[(first <= piece) & (piece < last)]
        alone[piece, cut_vertices(Graph.from_edges(n, links))] = True
    return {int(k): stretches(contacts, np.flatnonzero(alone[:, k])) for k in np.flatnonzero(alone.any(axis=0))}
