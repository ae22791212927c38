"""What a plan does over time: the least room between robots, λ2 of the team's contacts, and its links."""

from __future__ import annotations

import math
from dataclasses import replace
from typing import Any

import numpy as np

from taut.certificate.separation import check_separation
from taut.certificate.tracks import tracks_of
from taut.contact import components_at, contacts, losses
from taut.contact.core import Contacts
from taut.contact.spectra import fiedler_values
from taut.graph.core import Ints
from taut.motion import Plan
from taut.scene import FloatArray

EVENLY = 800
"""So many samples lie at equal distances; at most half as many more lie where robots are nearest."""

MANY = 250
"""Of more robots λ2 is not computed: each of its values takes the cube of their number."""

FEWEST = 64
"""So many pieces of time are told of, however long their λ2 takes."""

_CUBES = 400_000_000  # as many pieces as this holds cubes of the number of robots: half a second's work

_AT_ONCE = 1_000_000  # distances held in memory
_LEAVING = 350  # of so many robots the instants at which they leave are sampled on both sides


def timelines_of(plan: Plan, reach: float | None = None, sight: bool = False) -> dict[str, Any]:
    """Return the course of a plan over time.

    Parameters
    ----------
    plan : the motions.
    reach : metres within which robots are in contact; None leaves contact out.
    sight : whether obstacles break contact.

    Returns
    -------
    dict
        "until": seconds of the last arrival. "separation": {"times", "values": metres between the nearest two discs,
        None where fewer than two robots are there, "least": {"value", "time", "robots"} | None}, at most 2,000 samples,
        the least of which is exact. "contact": {"times": begins of pieces of time, the last for ever, "lambda2": one a
        piece, 0 for fewer than two robots; None of more than 250, "parts": into how many the team falls in each,
        "exact": whether links change nowhere within a piece} | None; where they change very often some pieces are left
        out, but none in which contact is lost or won. "links": [{"pair": numbers of robots, "begin", "end": None if for
        ever}].
    """
    answer: dict[str, Any] = {"until": plan.makespan, "separation": separation_of(plan), "contact": None, "links": []}
    if reach is None:
        return answer
    found = contacts(plan, reach, sight)
    return {**answer, "contact": _contact(found), "links": _links(found)}


def separation_of(plan: Plan) -> dict[str, Any]:
    """Return the least room between any two discs over time; see `timelines_of`."""
    at_once = replace(plan.scene, headway=0.0)  # the curve is that of one and the same instant
    nearest = check_separation(at_once, tracks_of(plan))[0]
    if nearest is None:
        return {"times": [], "values": [], "least": None}
    times = np.linspace(0.0, plan.makespan, EVENLY) if plan.makespan > 0 else np.zeros(1)
    values, pairs = _rooms(plan, times)
    further = [*_dips(plan, times, values, pairs), *_departures(plan), nearest.time]
    more = np.setdiff1d(np.array(further), times)
    order = np.argsort(np.concatenate([times, more]))
    times = np.concatenate([times, more])[order]
    values = np.concatenate([values, _rooms(plan, more)[0]])[order]
    values[np.searchsorted(times, nearest.time)] = nearest.value
    return {
        "times": times.tolist(),
        "values": [value if math.isfinite(value) else None for value in values.tolist()],
        "least": {"value": nearest.value, "time": nearest.time, "robots": list(nearest.robots)},
    }


def _rooms(plan: Plan, times: FloatArray) -> tuple[FloatArray, Ints]:
    """Least room (k,) between any two robots that are there at each time, inf if none are, and the pair (k, 2)."""
    robots = plan.scene.robots
    at = np.stack([motion.at(times) for motion in plan.trajectories], axis=1)
    radii = np.array([robot.radius for robot in robots])
    gone = np.array([_gone(plan, k) for k in range(len(robots))])
    first, second = np.triu_indices(len(robots), 1)
    touch = radii[first] + radii[second]
    left = np.minimum(gone[first], gone[second])
    values = np.full(len(times), np.inf)
    pairs = np.zeros((len(times), 2), dtype=np.int64)
    size = max(1, _AT_ONCE // len(first))
    for begin in range(0, len(times), size):
        some = slice(begin, begin + size)
        apart = at[some][:, first] - at[some][:, second]
        rooms = np.where(left <= times[some, None], np.inf, np.hypot(apart[..., 0], apart[..., 1]) - touch)
        best = rooms.argmin(axis=1)
        values[some] = np.take_along_axis(rooms, best[:, None], axis=1)[:, 0]
        pairs[some] = np.stack([first[best], second[best]], axis=1)
    return values, pairs


def _gone(plan: Plan, k: int) -> float:
    """From when a robot is no more there, seconds."""
    return math.inf if plan.scene.stays(plan.scene.robots[k]) else plan.trajectories[k].arrival


def _dips(plan: Plan, times: FloatArray, values: FloatArray, pairs: Ints) -> list[float]:
    """When the pair that is nearest at a sample lower than its neighbours is nearest between these."""
    if len(times) < 2:
        return []
    padded = np.concatenate([[np.inf], values, [np.inf]])
    low = np.isfinite(values) & (values <= padded[:-2]) & (values <= padded[2:])
    low &= (values < padded[:-2]) | (values < padded[2:])
    out = []
    for k in np.flatnonzero(low).tolist():
        a, b = times[max(k - 1, 0)], times[min(k + 1, len(times) - 1)]
        one, other = (plan.trajectories[j] for j in pairs[k].tolist())
        knots = np.unique(np.concatenate([[a, b], one.times, other.times]))
        knots = knots[(knots >= a) & (knots <= b)]
        apart = one.at(knots) - other.at(knots)
        way = np.diff(apart, axis=0)
        square = (way**2).sum(axis=1)
        with np.errstate(divide="ignore", invalid="ignore"):
            share = np.clip(np.where(square > 0, -(apart[:-1] * way).sum(axis=1) / square, 0.0), 0.0, 1.0)
        nearest = np.hypot(*(apart[:-1] + share[:, None] * way).T)
        best = int(np.argmin(nearest))
        out.append(float(knots[best] + share[best] * (knots[best + 1] - knots[best])))
    return out


def _departures(plan: Plan) -> list[float]:
    """When robots leave, and just before; of a few hundred only, as each of very many is no more to be seen."""
    gone = [time for time in (_gone(plan, k) for k in range(len(plan.scene.robots))) if 0 < time < math.inf]
    return [t for time in gone for t in (time, time * (1 - 1e-12))] if len(gone) <= _LEAVING else []


def _contact(found: Contacts) -> dict[str, Any]:
    shown = _shown(found)
    few = len(found.names) <= MANY
    values = fiedler_values(found.present[shown], found.pairs, np.searchsorted(shown, found.spans)) if few else None
    return {
        "times": found.times[shown].tolist(),
        "lambda2": None if values is None else values.tolist(),
        "parts": [int(components_at(found, piece).max(initial=-1)) + 1 for piece in shown.tolist()],
        "exact": len(shown) == len(found.times),
    }


def _shown(found: Contacts) -> Ints:
    """Which pieces are told of: all, or where that would take long some, and all at which contact is lost or won."""
    pieces = len(found.times)
    most = max(FEWEST, _CUBES // max(len(found.names), 1) ** 3)
    if pieces <= most:
        return np.arange(pieces)
    changes = losses(found).ravel()
    times = np.concatenate([np.linspace(0.0, found.until, most), changes[np.isfinite(changes)]])
    return np.unique(np.searchsorted(found.times, times, side="right") - 1)


def _links(found: Contacts) -> list[dict[str, Any]]:
    rows = zip(found.pairs.tolist(), found.begins.tolist(), found.ends.tolist(), strict=True)
    return [{"pair": pair, "begin": begin, "end": end if math.isfinite(end) else None} for pair, begin, end in rows]
