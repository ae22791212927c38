"""Kernels of meetings: where two motions on a roadmap come too near, and two rules of which everybody keeps one.

A meeting is resolved by a pair of rules, one for each of the two robots. The pair is *sound*: every pair of motions
without conflict keeps at least one of the rules, so no team motion is lost by branching over the two. And it is
*effective*: each rule forbids the motion at hand.

Let robot i depart along an edge at t, and let it then be nearer than d to vertex v from t + s to t + e (an open
interval, found in closed form at t = 0). Let robot j be at v from p to q. Write w = t + e. They conflict iff the
intervals (t + s, w) and [p, q] overlap.

Move and move. Departures a and b along two edges conflict iff lo < a − b < hi. With the departures t and u at hand,
    i not along its edge in [t, u + hi)        or        j not along its edge in [u, t − lo).
If both are broken then a − b < u + hi − u and a − b > t − (t − lo): a conflict.

Move and rest, q < w.
    i not along the edge in [t, q − s)         or        j not at v in [q, w).
If both are broken, i departs at some a, and j is at v at some k with a + s < q ≤ k < w ≤ a + e: a conflict.

Move and rest, w ≤ q < ∞. Choose k < w within the common time.
    i not along the edge in [t, q − s)         or        j not at v throughout [k, q].
If both are broken, then i's interval (a + s, a + e) begins before q and ends at w > k or later: j is there then.
Here the pair "i not in [t, q − s), j not at v in [t + s, w)" of the literature would be unsound: j may leave v, or come
there, while i waits for less than q − t − s.

Move and rest at the goal for good, q = ∞. Choose k < w, after p.
    j not at its goal for good before k        or        j is, before k, and nobody else departs along an edge that
                                                         is near v up to a time ≥ k, or rests near v at a time ≥ k.
One of the two holds for every motion of j, and the second forbids only what conflicts with j.

Rest and rest at near vertices, until q and q', q ≤ q'. Choose k < q within the common time.
    i not at its vertex at k                   or        j not at its vertex at k.
With q' = ∞ as for a move, with q in place of w.
"""

from __future__ import annotations

from math import inf

import numpy as np

from taut.compiling import kernel
from taut.team._conflict_kernels import edge_conflict, rest_conflict
from taut.team._rule_kernels import (
    KEEP_OUT,
    NOT_ALONG,
    NOT_AT,
    NOT_BEFORE,
    NOT_THROUGHOUT,
    Floats,
    Ground,
    Ints,
    Steps,
    Team,
    duration,
)

# A meeting is a row of ``who`` (robot, robot, kind, place, kind, place: one rule for each) and a row of ``when`` (time,
# since, until, since, until). With KEEP_OUT the first rule is for all but the second robot, and the second robot's
# NOT_BEFORE has its counterpart NOT_AFTER on that side.


@kernel
def first_meeting(
    ground: Ground,
    team: Team,
    slack: float,
    steps: Steps,
    i: int,
    first_i: int,
    count_i: int,
    j: int,
    first_j: int,
    count_j: int,
    who: Ints,
    when: Floats,
    row: int,
) -> bool:
    """Find the first meeting of two motions and write it to a row; return whether there is one.

    Parameters
    ----------
    slack : seconds; what overlaps by no more is no conflict.
    first_i, count_i, first_j, count_j : the motions in ``steps``.
    """
    a = b = 0  # pieces of the motions: 2 k is the rest at step k, 2 k + 1 the move from there
    # who leaves has no last rest
    end_a, end_b = 2 * count_i - 1 - team.leaves[i], 2 * count_j - 1 - team.leaves[j]
    while a < end_a and b < end_b:
        k, g = first_i + a // 2, first_j + b // 2
        until_a = steps.when[k, 1] if a % 2 == 0 else steps.when[k + 1, 0]
        until_b = steps.when[g, 1] if b % 2 == 0 else steps.when[g + 1, 0]
        met = False
        if _are_apart(ground.positions, steps.where, k, k + a % 2, g, g + b % 2, team.apart[i, j]):
            pass
        elif a % 2 == 1 and b % 2 == 1:
            met = _move_move(ground, team, slack, steps, i, k, j, g, who, when, row)
        elif a % 2 == 1:
            met = _move_rest(ground, team, slack, steps, i, k, j, g, who, when, row)
        elif b % 2 == 1:
            met = _move_rest(ground, team, slack, steps, j, g, i, k, who, when, row)
        elif until_a <= until_b:
            met = _rest_rest(ground, team, slack, steps, i, k, j, g, who, when, row)
        else:
            met = _rest_rest(ground, team, slack, steps, j, g, i, k, who, when, row)
        if met:
            return True
        if until_a <= until_b:
            a += 1
        if until_b <= until_a:
            b += 1
    return False


@kernel
def _are_apart(positions: Floats, where: Ints, k: int, k_end: int, g: int, g_end: int, d: float) -> bool:
    """Whether the boxes of two pieces, between the vertices of these steps, are d apart in x or in y."""
    u, v, p, q = where[k, 0], where[k_end, 0], where[g, 0], where[g_end, 0]
    for c in range(2):
        a, b, x, y = positions[u, c], positions[v, c], positions[p, c], positions[q, c]
        if min(a, b) - max(x, y) >= d or min(x, y) - max(a, b) >= d:
            return True
    return False


@kernel
def _move_move(
    ground: Ground,
    team: Team,
    slack: float,
    steps: Steps,
    i: int,
    k: int,
    j: int,
    g: int,
    who: Ints,
    when: Floats,
    row: int,
) -> bool:
    e, f = steps.where[k, 1], steps.where[g, 1]
    ax, ay, bx, by = _ends(ground, e)
    cx, cy, dx, dy = _ends(ground, f)
    ours, theirs = duration(ground, team, i, e), duration(ground, team, j, f)
    found, lo, hi = edge_conflict(ax, ay, bx, by, ours, cx, cy, 0.0, dx, dy, theirs, team.apart[i, j])
    t, u = steps.when[k, 1], steps.when[g, 1]
    if not (found and lo + slack < t - u < hi - slack):
        return False
    _write_rule(who, when, row, 0, i, NOT_ALONG, e, t, u + hi)
    _write_rule(who, when, row, 1, j, NOT_ALONG, f, u, t - lo)
    when[row, 0] = max(t, u)
    return True


@kernel
def _move_rest(
    ground: Ground,
    team: Team,
    slack: float,
    steps: Steps,
    i: int,
    k: int,
    j: int,
    g: int,
    who: Ints,
    when: Floats,
    row: int,
) -> bool:
    v, p, q = steps.where[g, 0], steps.when[g, 0], steps.when[g, 1]
    if q <= p:
        return False
    e, t = steps.where[k, 1], steps.when[k, 1]
    ax, ay, bx, by = _ends(ground, e)
    found, s, e0 = rest_conflict(
        ground.positions[v, 0],
        ground.positions[v, 1],
        ax,
        ay,
        0.0,
        bx,
        by,
        duration(ground, team, i, e),
        team.apart[i, j],
    )
    w = t + e0
    if not (found and min(q, w) - max(p, t + s) > slack):
        return False
    when[row, 0] = max(p, t + s)
    if q == inf:
        _write_rule(who, when, row, 0, i, KEEP_OUT, j, w - slack / 2, inf)
        _write_rule(who, when, row, 1, j, NOT_BEFORE, v, w - slack / 2, inf)
        return True
    _write_rule(who, when, row, 0, i, NOT_ALONG, e, t, q - s)
    if q < w - slack / 2:
        _write_rule(who, when, row, 1, j, NOT_AT, v, q, w)
    else:
        _write_rule(who, when, row, 1, j, NOT_THROUGHOUT, v, w - slack / 2, q)
    return True


@kernel
def _rest_rest(
    ground: Ground,
    team: Team,
    slack: float,
    steps: Steps,
    i: int,
    k: int,
    j: int,
    g: int,
    who: Ints,
    when: Floats,
    row: int,
) -> bool:
    """Robot i leaves first."""
    u, v = steps.where[k, 0], steps.where[g, 0]
    begin, until = max(steps.when[k, 0], steps.when[g, 0]), steps.when[k, 1]
    if not until - begin > slack:
        return False
    x, y = ground.positions[u, 0] - ground.positions[v, 0], ground.positions[u, 1] - ground.positions[v, 1]
    if x * x + y * y >= team.apart[i, j] * team.apart[i, j]:
        return False
    when[row, 0] = begin
    instant = until - slack / 2
    if steps.when[g, 1] == inf:
        _write_rule(who, when, row, 0, i, KEEP_OUT, j, instant, inf)
        _write_rule(who, when, row, 1, j, NOT_BEFORE, v, instant, inf)
    else:
        _write_rule(who, when, row, 0, i, NOT_AT, u, instant, np.nextafter(instant, inf))
        _write_rule(who, when, row, 1, j, NOT_AT, v, instant, np.nextafter(instant, inf))
    return True


@kernel
def _ends(ground: Ground, edge: int) -> tuple[float, float, float, float]:
    u, v = ground.tails[edge], ground.heads[edge]
    return ground.positions[u, 0], ground.positions[u, 1], ground.positions[v, 0], ground.positions[v, 1]


@kernel
def _write_rule(
    who: Ints, when: Floats, row: int, side: int, robot: int, kind: int, place: int, since: float, until: float
) -> None:
    who[row, side] = robot
    who[row, 2 + 2 * side], who[row, 3 + 2 * side] = kind, place
    when[row, 1 + 2 * side], when[row, 2 + 2 * side] = since, until
