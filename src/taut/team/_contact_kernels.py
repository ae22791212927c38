"""Kernels of contact: when a robot at rest, or one that departs now, has enough partners within reach and in sight."""

from __future__ import annotations

from math import inf, sqrt
from typing import NamedTuple

from taut.team._conflict_kernels import Floats, Ints
from taut.team._lean import lean_kernel
from taut.team._sight_kernels import Walls, out_of_sight


class Partners(NamedTuple):
    """Robots with some of which another one has to stay in contact at every instant.

    Parameters
    ----------
    legs : (k, 6) x0, y0, t0, x1, y1, t1 of all partners, one after another; each partner's reach from 0 to inf.
    pace : (k, 2) velocity on each leg, metres a second.
    first : (m + 1,) first leg of each partner.
    reach : (2,) metres within which robots are in contact; seconds that make no difference.
    need : (1,) how many partners at every instant.
    walls : what blocks the sight.
    since, till : stretches in contact that the present question has found; then sorted, each for itself.
    tally : (1,) how many there are.
    """

    legs: Floats
    pace: Floats
    first: Ints
    reach: Floats
    need: Ints
    walls: Walls
    since: Floats
    till: Floats
    tally: Ints


# --- Questions of the search ------------------------------------------------------------------------------------------


@lean_kernel
def lonely_times(
    partners: Partners, x: float, y: float, begin: float, end: float, lo: Floats, hi: Floats, count: int
) -> int:
    """Add to forbidden times of a place those between ``begin`` and ``end`` without contact; −1 if there is no room.

    What is out of contact at ``end`` counts as if for ever.
    """
    _meet(partners, x, y, 0.0, 0.0, begin, begin, end)
    _sort(partners)
    at = begin
    while at < end:
        gap, back = _gap(partners, at, end)
        if gap == inf:
            break
        if count == lo.shape[0]:
            return -1
        # an instant of contact at which the gap begins is no part of it
        lo[count] = gap if gap > begin or _enough(partners, begin) else begin - 1.0
        hi[count] = back
        count += 1
        if not back > at:
            back = at + partners.reach[1]
        at = back
    return count


@lean_kernel
def in_contact(partners: Partners, edge: tuple[float, float, float, float], tau: float, depart: float) -> bool:
    """Whether a robot that departs then is in contact at every instant until it arrives."""
    gap, _ = _first_gap(partners, edge, tau, depart)
    return gap == inf


@lean_kernel
def next_chance(
    partners: Partners, edge: tuple[float, float, float, float], tau: float, depart: float, latest: float
) -> float:
    """Return the departure itself if contact holds all along, else a later one before which it surely does not hold.

    In the plane of the way along the edge and of time, a departure is a diagonal; where it leaves contact, the hole
    reaches from there to its end in time (the robot at the same place, later), and to its end along the edge at that
    time. Every departure whose diagonal meets either in between fails. So no departure is passed over that could be
    had, but those that hold for less than the seconds that make no difference.
    """
    gap, back = _first_gap(partners, edge, tau, depart)
    if gap == inf:
        return depart
    ax, ay, bx, by = edge
    ux, uy = (bx - ax) / tau, (by - ay) / tau
    middle = 0.5 * (gap + min(back, tau))
    chance: float = depart + partners.reach[1]
    for k in range(3):
        s = middle
        if k == 1:
            if gap > 0.0:
                continue
            s = 0.0
        elif k == 2:
            if back <= tau:
                continue
            s = tau
        when = _next_meeting(partners, ax + s * ux, ay + s * uy, depart + s, latest + s)
        chance = max(chance, when - s)
        if not chance <= latest:
            return inf
    # at that instant it could be nearer to the tail of the edge
    instant: float = depart + middle
    till = partners.till
    _meet_at(partners, ax, ay, ux, uy, instant, middle)
    _sort(partners)
    back_to = -inf
    for k in range(partners.tally[0]):
        if back_to < till[k] <= middle and _enough(partners, till[k]):
            back_to = till[k]
    return max(chance, instant - max(back_to, 0.0))


@lean_kernel
def _first_gap(
    partners: Partners, edge: tuple[float, float, float, float], tau: float, depart: float
) -> tuple[float, float]:
    """Where along an edge, in seconds, contact is first lost, and where it is found again; inf if that never is."""
    ax, ay, bx, by = edge
    ux, uy = (bx - ax) / tau, (by - ay) / tau
    _meet(partners, ax, ay, ux, uy, depart, depart, depart + tau)
    for k in range(partners.tally[0]):
        partners.since[k] -= depart
        partners.till[k] = inf if partners.till[k] >= depart + tau else partners.till[k] - depart
    _sort(partners)
    return _gap(partners, 0.0, tau)


@lean_kernel
def _next_meeting(partners: Partners, x: float, y: float, begin: float, end: float) -> float:
    """First time between two at which a robot that rests there is in contact; inf if there is none.

    It is mostly soon: so a short while is looked at first, then one twice as long, and so on.
    """
    ahead = partners.reach[1] * 2.0**20
    settled = 0.0  # from when on all partners rest
    for m in range(partners.first.shape[0] - 1):
        settled = max(settled, partners.legs[partners.first[m + 1] - 1, 2])
    while begin <= end:
        until = end if begin >= settled else min(end, begin + ahead)
        _meet(partners, x, y, 0.0, 0.0, begin, begin, until)
        _sort(partners)
        if _enough(partners, begin):
            return begin
        for k in range(partners.tally[0]):
            if partners.since[k] >= begin and _enough(partners, partners.since[k]):
                when: float = partners.since[k]
                return when
        if until == end:
            break
        begin = until
        ahead *= 2.0
    return inf


# --- Stretches in contact ---------------------------------------------------------------------------------------------


@lean_kernel
def _enough(partners: Partners, at: float) -> bool:
    """Whether there are enough partners at a time; ``since`` and ``till`` are sorted."""
    n = partners.tally[0]
    holding: bool = _not_after(partners.since, n, at) - _before(partners.till, n, at) >= partners.need[0]
    return holding


@lean_kernel
def _gap(partners: Partners, begin: float, end: float) -> tuple[float, float]:
    """First stretch between two times in which there are not enough partners; inf, inf if there is none."""
    n, need = partners.tally[0], partners.need[0]
    since, till = partners.since, partners.till
    i = _not_after(since, n, begin)
    j = _before(till, n, begin)
    gap = begin
    if i - j >= need:
        while True:
            if j == n or till[j] >= end:
                return inf, inf
            gap = till[j]
            j += 1
            while i < n and since[i] <= gap:
                i += 1
            if i - j < need:
                break
    while i < n:
        back = since[i]
        while j < n and till[j] < back:
            j += 1
        i += 1
        while i < n and since[i] == back:
            i += 1
        if i - j >= need:
            return gap, back
    return gap, inf


@lean_kernel
def _not_after(times: Floats, n: int, at: float) -> int:
    """How many of the first n sorted times are at most ``at``."""
    lo, hi = 0, n
    while lo < hi:
        mid = (lo + hi) >> 1
        if times[mid] <= at:
            lo = mid + 1
        else:
            hi = mid
    return lo


@lean_kernel
def _before(times: Floats, n: int, at: float) -> int:
    """How many of the first n sorted times are less than ``at``."""
    lo, hi = 0, n
    while lo < hi:
        mid = (lo + hi) >> 1
        if times[mid] < at:
            lo = mid + 1
        else:
            hi = mid
    return lo


@lean_kernel
def _sort(partners: Partners) -> None:
    """Sort the beginnings and the ends, each for themselves: whoever counts needs no more. Shell's method."""
    n = partners.tally[0]
    for times in (partners.since, partners.till):
        step = 1
        while 3 * step + 1 < n:
            step = 3 * step + 1
        while step > 0:
            for i in range(step, n):
                value = times[i]
                j = i - step
                while j >= 0 and times[j] > value:
                    times[j + step] = times[j]
                    j -= step
                times[j + step] = value
            step //= 3


@lean_kernel
def _meet(
    partners: Partners, x: float, y: float, ux: float, uy: float, origin: float, begin: float, end: float
) -> None:
    """Find all stretches between two times in which a robot at (x, y) + (t − origin) u is in contact."""
    partners.tally[0] = 0
    for m in range(partners.first.shape[0] - 1):
        _meet_one(partners, m, x, y, ux, uy, origin, begin, end)


@lean_kernel
def _meet_one(
    partners: Partners, m: int, x: float, y: float, ux: float, uy: float, origin: float, begin: float, end: float
) -> None:
    """Add the stretches in contact with one partner."""
    legs = partners.legs
    lo, last = partners.first[m], partners.first[m + 1]
    hi = last
    while hi - lo > 1:  # the leg on which the partner is at the beginning
        mid = (lo + hi) >> 1
        if legs[mid, 2] <= begin:
            lo = mid
        else:
            hi = mid
    for i in range(lo, last):
        if legs[i, 2] > end:
            break
        t0, t1 = max(begin, legs[i, 2]), min(end, legs[i, 5])
        if t1 < t0:
            continue
        vx, vy = partners.pace[i, 0], partners.pace[i, 1]
        qx, qy = legs[i, 0] + (t0 - legs[i, 2]) * vx, legs[i, 1] + (t0 - legs[i, 2]) * vy
        px, py = x + (t0 - origin) * ux, y + (t0 - origin) * uy
        found, a, b = _within(px - qx, py - qy, ux - vx, uy - vy, t1 - t0, partners.reach[0])
        if found:
            # pieces that follow each other meet exactly
            a = t0 if a == 0.0 else t0 + a
            b = t1 if t0 + b >= t1 or b >= t1 - t0 else t0 + b
            _add(partners, px, py, ux, uy, qx, qy, vx, vy, t0, a, b)


@lean_kernel
def _meet_at(partners: Partners, ax: float, ay: float, ux: float, uy: float, when: float, s: float) -> None:
    """Find, for one instant, the stretches of an edge up to s seconds along it that are in contact."""
    partners.tally[0] = 0
    legs = partners.legs
    for m in range(partners.first.shape[0] - 1):
        lo, hi = partners.first[m], partners.first[m + 1]
        while hi - lo > 1:
            mid = (lo + hi) >> 1
            if legs[mid, 2] <= when:
                lo = mid
            else:
                hi = mid
        since = when - legs[lo, 2]
        qx, qy = legs[lo, 0] + since * partners.pace[lo, 0], legs[lo, 1] + since * partners.pace[lo, 1]
        found, a, b = _within(ax - qx, ay - qy, ux, uy, s, partners.reach[0])
        if found:
            _add(partners, ax, ay, ux, uy, qx, qy, 0.0, 0.0, 0.0, a, b)


@lean_kernel
def _within(x: float, y: float, vx: float, vy: float, span: float, reach: float) -> tuple[bool, float, float]:
    """First and last s in [0, span] with |(x, y) + s v| at most ``reach``; the distance is convex, so all between."""
    square = vx * vx + vy * vy
    if span == inf or square == 0.0:
        return x * x + y * y <= reach * reach, 0.0, span
    ex, ey = x + span * vx, y + span * vy
    a_in, b_in = x * x + y * y <= reach * reach, ex * ex + ey * ey <= reach * reach
    if a_in and b_in:
        return True, 0.0, span
    speed = sqrt(square)
    side = abs(x * vy - y * vx) / speed
    if side > reach:
        return (True, 0.0, 0.0) if a_in else (b_in, span, span)
    half = sqrt((reach - side) * (reach + side)) / speed
    nearest = -(x * vx + y * vy) / square
    a = 0.0 if a_in else max(nearest - half, 0.0)
    b = span if b_in else min(nearest + half, span)
    if a > b:
        return (True, 0.0, 0.0) if a_in else (b_in, span, span)
    return True, a, b


@lean_kernel
def _add(
    partners: Partners,
    px: float,
    py: float,
    ux: float,
    uy: float,
    qx: float,
    qy: float,
    vx: float,
    vy: float,
    t0: float,
    a: float,
    b: float,
) -> None:
    """Note the stretch from a to b, without what is out of sight; p + (t − t0) u and q + (t − t0) v move steadily.

    Where there is no room the rest is left out, as if there were no contact.
    """
    dark = 0
    if partners.walls.sides.shape[0] > 0:
        until = a if b == inf else b
        dark = out_of_sight(
            partners.walls,
            px + (a - t0) * ux,
            py + (a - t0) * uy,
            ux,
            uy,
            qx + (a - t0) * vx,
            qy + (a - t0) * vy,
            vx,
            vy,
            until - a,
        )
        if dark < 0 or (dark > 0 and until == a):
            return
    at = a
    for k in range(dark):
        if a + partners.walls.dark[k, 0] > at:
            _note(partners, at, a + partners.walls.dark[k, 0])
        at = a + partners.walls.dark[k, 1]
    if dark == 0 or partners.walls.dark[dark - 1, 1] < b - a:
        _note(partners, at, b)


@lean_kernel
def _note(partners: Partners, a: float, b: float) -> None:
    n = partners.tally[0]
    if n < partners.since.shape[0] and a <= b:
        partners.since[n], partners.till[n] = a, b
        partners.tally[0] = n + 1
