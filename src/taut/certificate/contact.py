"""Contact: whether the team is connected at every instant, as strongly as demanded; if not, who lost whom."""

from __future__ import annotations

import heapq
from dataclasses import replace
from functools import partial
from itertools import combinations

import numpy as np
import shapely
from numpy.typing import NDArray

from taut.certificate.clearance import Shapes
from taut.certificate.report import ContactProof, Problem
from taut.contact import Contact, Contacts, components_at, contacts, graph_at, needed_reach, piece_at, sight_sides
from taut.contact.connectivity import (
    connected,
    failing_pieces,
    fiedler_at,
    fiedler_at_least,
    k_connected,
    least_fiedler,
    robots_at,
    stretches,
)
from taut.contact.motions import Motions, distance_bounds, motions_of, place_at
from taut.contact.spectra import one_thread
from taut.errors import SceneError
from taut.motion import Plan
from taut.scene import FloatArray, Scene

Ints = NDArray[np.int64]

_MANY = 250
"""Robots up to which the least λ2 is found."""

_TOLD = 10
"""Losses of contact that are told one by one, the longest."""

_LOOKS = 64
"""Pieces in which the worst instant is looked for, the longest."""

_HALVINGS = 200
"""Times that a piece is halved at most to find its worst instant."""

_TRIES = 10_000
"""Sets of robots that are left out at most to find those that hold a team together."""

_RELATIVE = 1e-9
"""Share by which λ2 may be smaller than demanded."""


def check_contact(plan: Plan, demand: Contact, shapes: Shapes) -> tuple[ContactProof, list[Problem]]:
    """Return what is known of a team's contact, and a problem for each part of it that is lost.

    Links reach as far as demanded plus the tolerance. A team that falls apart is told of once for each part; that it
    is less than k-connected, or λ2 too small while it is connected, once in all. λ2 may be 1e-9 of itself too small.
    """
    try:
        found = contacts(plan, demand.reach, demand.sight)
    except SceneError as error:
        return ContactProof(demand), [Problem("contact", detail=f"contact cannot be proved: {error.message}")]
    lost = failing_pieces(found, connected)
    weakest = None
    if len(robots_at(found, 0)) > 1 and len(found.names) <= _MANY:
        weakest = least_fiedler(found)
    problems = _losses(plan, found, stretches(found, lost), shapes)
    if demand.k > 1:
        problems += _weak(plan, found, demand.k, lost)
    if demand.lambda2 > 0:
        problems += _loose(found, demand.lambda2, lost, weakest)
    proof = ContactProof(demand)
    if weakest is not None:
        proof = replace(proof, lambda2=weakest[1], lambda2_time=found.middle(weakest[0]))
    needed = needed_reach(plan, found)
    if needed is not None:
        proof = replace(proof, needed_range=needed.upper, needed_time=needed.time)
    return proof, problems


# ---------------------------------------------------------------------------------------------- falling apart


def _losses(plan: Plan, found: Contacts, lost: FloatArray, shapes: Shapes) -> list[Problem]:
    """One problem for each part that is lost, for its longest time, and how often contact is lost besides."""
    longest = lost[np.argsort(lost[:, 0] - lost[:, 1], kind="stable")]
    told: dict[tuple[str, ...], Problem] = {}
    for begin, end in longest[:_TOLD].tolist():
        problem = _loss(plan, found, begin, end, shapes)
        told.setdefault(problem.robots, problem)
    problems = sorted(told.values(), key=lambda problem: -1.0 if problem.time is None else problem.time)
    more = len(lost) - len(told)
    if more:
        problems.append(Problem("contact", detail=f"contact is lost {more} more time{'s' if more > 1 else ''}"))
    return problems


def _loss(plan: Plan, found: Contacts, begin: float, end: float, shapes: Shapes) -> Problem:
    """Who is cut off between two times, and the instant at which they are farthest from all others."""
    scene = plan.scene
    motions = motions_of(plan)
    part, others, distance, time, parts = _worst(motions, found, begin, end, scene.tol)
    across = _across(part, others)
    i, j = across[np.argmin(distance_bounds(motions, across, time, time)[0])].tolist()
    near, far = place_at(motions, i, time), place_at(motions, j, time)
    robots = tuple(scene.robots[r].name for r in part)
    lose = "loses" if len(robots) == 1 else "lose"
    nearest = f"nearest are {scene.robots[i].name} and {scene.robots[j].name}, {distance:.9g} m apart"
    said = f"{_few(robots)} {lose} contact with the others {_while(begin, end)}"
    if parts > 2:
        said += f", when the team is in {parts} parts"
    if distance > found.reach + scene.tol:
        beyond = distance - found.reach
        x, y = ((near + far) / 2).tolist()
        detail = f"{said}, {beyond:.6g} m beyond the range of {found.reach:.9g} m ({nearest}),"
        return Problem("contact", robots, beyond, time, (x, y), detail=detail)
    x, y = _hit(scene, near, far)
    obstacle = shapes.near(x, y, 16 * scene.tol)
    detail = f"{said}, hidden by {obstacle} ({nearest}),"
    return Problem("contact", robots, 0.0, time, (x, y), obstacle, detail)


def _worst(
    motions: Motions, found: Contacts, begin: float, end: float, tol: float
) -> tuple[Ints, Ints, float, float, int]:
    """The smallest part, the others, their least distance when that is greatest, the instant, and how many parts."""
    borders = np.append(found.times, max(found.until, found.times[-1]))
    pieces = np.arange(piece_at(found, begin), len(found.times) if end == np.inf else piece_at(found, end))
    worst: tuple[Ints, Ints, float, float, int] | None = None
    for piece in _longest(found, pieces):
        labels = components_at(found, piece)
        sizes = np.bincount(labels[labels >= 0])
        smallest = len(sizes) - 1 - int(np.argmin(sizes[::-1]))
        part, others = np.flatnonzero(labels == smallest), np.flatnonzero((labels >= 0) & (labels != smallest))
        floor = -1.0 if worst is None else worst[2]
        distance, time = _farthest(motions, _across(part, others), borders[piece], borders[piece + 1], floor, tol)
        if worst is None or distance > floor:
            worst = part, others, distance, time, len(sizes)
    assert worst is not None  # a stretch has a piece
    return worst


def _across(part: Ints, others: Ints) -> Ints:
    """All pairs (p, 2) of one from each."""
    return np.stack(np.meshgrid(part, others, indexing="ij"), axis=-1).reshape(-1, 2).astype(np.int64)


def _farthest(motions: Motions, pairs: Ints, begin: float, end: float, floor: float, tol: float) -> tuple[float, float]:
    """Greatest value over time, and when, of the least distance of pairs; −1 where it is below the floor.

    On a stretch of time it is at most the least of the pairs' greatest distances. The stretch with the greatest such
    bound is halved until a value at an instant meets it.
    """
    best, when = -1.0, begin
    heap: list[tuple[float, float, float]] = []
    todo = [(begin, end)]
    for _ in range(_HALVINGS):
        for first, last in todo:
            # inside: at its ends a piece may have links that it lacks
            for share in (0.5, 2.0**-20, 1 - 2.0**-20):
                time = first + share * (last - first)
                now = float(distance_bounds(motions, pairs, time, time)[0].min())
                if now > best:
                    best, when = now, time
            heapq.heappush(heap, (-float(distance_bounds(motions, pairs, first, last)[1].min()), first, last))
        upper, first, last = heapq.heappop(heap)
        if -upper <= max(best + tol, floor):
            break
        todo = [(first, (first + last) / 2), ((first + last) / 2, last)]
    return best, float(when)


def _hit(scene: Scene, a: FloatArray, b: FloatArray) -> tuple[float, float]:
    """Where the line of sight from a to b first meets what hides b."""
    sides = shapely.linestrings(sight_sides(scene, scene.tol).reshape(-1, 2, 2))
    met = shapely.get_coordinates(shapely.intersection(shapely.linestrings([a, b]), sides))
    if not len(met):
        met = np.array([(a + b) / 2])
    x, y = met[np.argmin(np.hypot(*(met - a).T))].tolist()
    return x, y


# ---------------------------------------------------------------------------------------------- too weak


def _weak(plan: Plan, found: Contacts, k: int, lost: Ints) -> list[Problem]:
    """Where the team is connected, but not when some k − 1 robots fail."""
    weak = np.setdiff1d(failing_pieces(found, partial(k_connected, k=k)), lost)
    if not len(weak):
        return []
    times = stretches(found, weak)
    begin, end = times[np.argmax(times[:, 1] - times[:, 0])].tolist()
    piece = piece_at(found, begin)
    there = robots_at(found, piece)
    held = there[_separator(len(there), np.searchsorted(there, graph_at(found, piece).edges), k)]
    robots = tuple(plan.scene.robots[r].name for r in held)
    who = f"without {_few(robots)} the team falls apart" if robots else "the team is too weakly connected"
    more = "" if len(times) == 1 else f", and {len(times) - 1} more times for no longer"
    detail = f"{who} {_while(begin, end)}{more} (contact demanded with any {k - 1} failing),"
    motions = motions_of(plan)
    x, y = np.mean([place_at(motions, r, begin) for r in (held if len(held) else there)], axis=0).tolist()
    return [Problem("contact", robots, 0.0, begin, (x, y), detail=detail)]


def _separator(n: int, pairs: Ints, k: int) -> Ints:
    """Fewer than k of n connected robots that hold the others together; the first of fewest, none after many tries."""
    tries = 0
    for size in range(1, k):
        for held in combinations(range(n), size):
            kept = np.setdiff1d(np.arange(n), held)
            left = pairs[~np.isin(pairs, held).any(axis=1)]
            if not connected(len(kept), np.searchsorted(kept, left)):
                return np.array(held, dtype=np.int64)
            tries += 1
            if tries == _TRIES:
                return np.empty(0, dtype=np.int64)
    return np.empty(0, dtype=np.int64)


def _loose(found: Contacts, least: float, lost: Ints, weakest: tuple[int, float] | None) -> list[Problem]:
    """Where the team is connected, but λ2 is less than demanded."""
    enough = partial(fiedler_at_least, least=least * (1 - _RELATIVE))
    with one_thread():
        loose = np.setdiff1d(failing_pieces(found, enough), lost)
    if not len(loose):
        return []
    if weakest is None or len(lost):
        piece = min(_longest(found, loose), key=lambda piece: fiedler_at(found, piece))
        weakest = piece, fiedler_at(found, piece)
    piece, value = weakest
    begin, end = next((b, e) for b, e in stretches(found, loose).tolist() if b <= found.times[piece] < e)
    detail = f"λ2 falls to {value:.9g}, {least:.9g} demanded, too small {_while(begin, end)},"
    return [Problem("contact", (), 0.0, found.middle(piece), detail=detail)]


def _longest(found: Contacts, pieces: Ints) -> list[int]:
    """The longest of some pieces, in the order of time."""
    lengths = np.diff(found.times, append=np.inf)[pieces]
    return sorted(pieces[np.argsort(-lengths, kind="stable")[:_LOOKS]].tolist())


def _while(begin: float, end: float) -> str:
    return f"from t = {begin:.9g} s on" if end == np.inf else f"from t = {begin:.9g} s to {end:.9g} s"


def _few(names: tuple[str, ...]) -> str:
    """Up to four names, and how many others."""
    if len(names) <= 4:
        return ", ".join(names[:-1]) + (" and " if len(names) > 1 else "") + names[-1]
    return ", ".join(names[:3]) + f" and {len(names) - 3} others"
