"""Whether motions keep the contact demanded, judged by the exact analysis of plans."""

from __future__ import annotations

import numpy as np

from taut.contact.connectivity import failing_pieces, k_connected
from taut.contact.demand import Contact
from taut.contact.links import contacts
from taut.motion import Plan, Trajectory
from taut.scene import FloatArray, Scene


def first_loss(plan: Plan, demand: Contact) -> float | None:
    """Seconds at which a plan first lacks the contact demanded; None if it never does."""
    found = contacts(plan, demand.reach, demand.sight)
    failing = failing_pieces(found, lambda n, pairs: k_connected(n, pairs, demand.k))
    if demand.lambda2 > 0 and len(plan.trajectories) > 1:
        failing = np.union1d(failing, np.flatnonzero(found.fiedler < demand.lambda2))
    return float(found.times[failing[0]]) if len(failing) else None


def moved(scene: Scene, seconds: FloatArray, places: FloatArray) -> Plan:
    """Return the plan in which all robots are at places (m, n, 2) at seconds (m,), steady in between."""
    stamps = [np.column_stack([seconds, places[:, i]]) for i in range(len(scene.robots))]
    return Plan(scene, tuple(Trajectory(r.name, own) for r, own in zip(scene.robots, stamps, strict=True)))
