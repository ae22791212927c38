"""Forbidden times of the planners: exact promise, known answers, symmetries."""

from __future__ import annotations

from dataclasses import replace
from fractions import Fraction
from math import cos, inf, pi, sin, sqrt

import numpy as np
import pytest
from hypothesis import example, given, settings
from hypothesis import strategies as st

from naive_conflicts import Meeting, bisected, broken_promise, closest, sampled_conflicts
from taut.team._conflict_kernels import edge_conflict, rest_conflict

NONE = (False, inf, -inf)


def random_meeting(rng: np.random.Generator) -> Meeting:
    """Make a pair that passes at about d: scales 1e-9 … 1e6 m, speeds 1e-3 … 1e3 m/s, t0 up to 1e6 s."""
    uniform, choice = rng.uniform, rng.choice
    scale = 10.0 ** uniform(-9, 6)
    edge, leg = scale * 10.0 ** (uniform(-6, 0, 2) if rng.random() < 0.5 else uniform(-1, 0, 2))
    heading = uniform(0, 2 * pi)
    turn = choice([uniform(0, 2 * pi), 0.0, pi, 10.0 ** uniform(-17, -3), pi - 10.0 ** uniform(-17, -3)])
    ex, ey = edge * cos(heading), edge * sin(heading)
    lx, ly = leg * cos(heading + turn), leg * sin(heading + turn)
    speed = 10.0 ** uniform(-3, 3)
    other = choice([speed, speed * 10.0 ** uniform(-1, 1), 10.0 ** uniform(-3, 3)])
    tau, span = edge / speed, leg / other

    d = scale * 10.0 ** uniform(-4, 0)
    f, g = choice([uniform(-0.2, 1.2), 0.0, 1.0], 2)  # where the two are when nearest, roughly
    rx, ry = ex / tau - lx / span, ey / tau - ly / span
    if rng.random() < 0.2 or rx == ry == 0.0:
        rx, ry = rng.normal(size=2)
    distance = d * choice([1.0, 1 + 10.0 ** uniform(-16, -8), 1 - 10.0 ** uniform(-16, -8), uniform(0, 1.5), -1.0])
    zx, zy = -ry / np.hypot(rx, ry) * distance, rx / np.hypot(rx, ry) * distance
    ax, ay = uniform(-scale, scale, 2)
    x0, y0 = ax + f * ex - g * lx - zx, ay + f * ey - g * ly - zy
    t0 = choice([0.0, uniform(0, 1), uniform(0, 1e4), uniform(0, 1e6)])
    m = Meeting(*map(float, (ax, ay, ax + ex, ay + ey, tau, x0, y0, t0, x0 + lx, y0 + ly, t0 + span, d)))

    kind = rng.random()
    if kind < 0.05:
        m = replace(m, bx=m.ax, by=m.ay)
    elif kind < 0.15:
        m = replace(m, x1=m.x0, y1=m.y0, t1=inf if kind < 0.1 else m.t1)
    elif kind < 0.17:
        m = replace(m, bx=m.ax, by=m.ay, x1=m.x0, y1=m.y0)
    elif kind < 0.19:
        m = replace(m, bx=m.ax, by=m.ay, tau=0.0)
    return m if m.t1 > m.t0 else random_meeting(rng)


def random_sliver(rng: np.random.Generator) -> Meeting:
    """Make a pair of nearly parallel moves (1e-13 … 1e-7 rad) that touches where one of them begins or ends.

    The ellipse is a needle, its extreme lies on a side of the rectangle up to rounding, and the side is tangent to it.
    """
    uniform = rng.uniform
    heading = uniform(0, 2 * pi)
    turn = float(rng.choice([-1, 1])) * 10.0 ** uniform(-13, -7) + pi * rng.integers(2)
    edge, leg = uniform(1, 10, 2)
    span = leg / rng.choice([1.0, 10.0 ** uniform(-1, 1), 10.0 ** uniform(-3, 3)])
    ex, ey = edge * cos(heading), edge * sin(heading)
    lx, ly = leg * cos(heading + turn), leg * sin(heading + turn)
    f, g = rng.permutation([uniform(0, 1), float(rng.integers(2))])
    d = 10.0 ** uniform(-2, 0.5)
    rx, ry = ex / edge - lx / span, ey / edge - ly / span
    distance = float(rng.choice([-1, 1])) * d * (1 + uniform(-8, 8) * 10.0 ** uniform(-16, -14)) / np.hypot(rx, ry)
    ax, ay = uniform(-1, 1, 2)
    x0, y0 = ax + f * ex - g * lx + ry * distance, ay + f * ey - g * ly - rx * distance
    return Meeting(*map(float, (ax, ay, ax + ex, ay + ey, edge, x0, y0, 0.0, x0 + lx, y0 + ly, span, d)))


def rest(m: Meeting) -> Meeting:
    """Keep the leg, make the edge an instant at a."""
    return replace(m, bx=m.ax, by=m.ay, tau=0.0)


@pytest.mark.parametrize("seed", range(4))
def test_edge_conflict_keeps_its_promise_exactly(seed: int) -> None:
    rng = np.random.default_rng(seed)
    found = 0
    for _ in range(1000):
        m = random_meeting(rng)
        result = edge_conflict(*m.arguments)
        assert broken_promise(m, *result) is None, (m, result)
        found += result[0]
    assert 200 < found < 800  # both answers are tried


@pytest.mark.deep
@pytest.mark.parametrize("seed", range(100, 110))
def test_conflicts_keep_their_promise_on_ten_thousand_pairs(seed: int) -> None:
    rng = np.random.default_rng(seed)
    for number in range(10_000):
        m = random_sliver(rng) if number % 5 == 0 else random_meeting(rng)
        if number % 5 == 1:
            result = rest_conflict(m.ax, m.ay, *m.arguments[5:])
            m = rest(m)
        else:
            result = edge_conflict(*m.arguments)
        assert broken_promise(m, *result) is None, (m, result)
        if number % 10 == 2:
            assert not unseen(m, result[1], result[2]), m


def test_edge_conflict_keeps_its_promise_for_slivers() -> None:
    rng = np.random.default_rng(5)
    found = 0
    for _ in range(1500):
        m = random_sliver(rng)
        result = edge_conflict(*m.arguments)
        assert broken_promise(m, *result) is None, (m, result)
        found += result[0]
    assert 200 < found < 1300


def test_rest_conflict_keeps_its_promise_exactly() -> None:
    rng = np.random.default_rng(10)
    found = 0
    for _ in range(1000):
        m = random_meeting(rng)
        result = rest_conflict(m.ax, m.ay, *m.arguments[5:])
        assert broken_promise(rest(m), *result) is None, (m, result)
        found += result[0]
    assert 100 < found < 900


def test_the_oracle_notices_wrong_intervals() -> None:
    """A promise that nothing can break would prove nothing."""
    m = Meeting(0, -2, 0, 2, 4, -2, 0, 0, 2, 0, 4, 1)
    found, lo, hi = edge_conflict(*m.arguments)
    assert found
    for wrong in [NONE, (True, lo + 1e-11, hi), (True, lo - 1e-11, hi), (True, lo, hi - 1e-11), (True, lo, hi + 1e-11)]:
        assert broken_promise(m, *wrong) is not None
    assert broken_promise(m, True, lo, inf) is not None
    assert broken_promise(m, True, -9.0, -8.0) is not None
    assert broken_promise(replace(m, d=0.0), True, -0.1, 0.1) is not None


def test_ends_equal_high_precision_bisection() -> None:
    rng = np.random.default_rng(20)
    compared = 0
    while compared < 120:
        ax, ay, bx, by, x0, y0, x1, y1 = rng.uniform(-10, 10, 8)
        m = Meeting(*map(float, (ax, ay, bx, by, rng.uniform(1, 9), x0, y0, 0.0, x1, y1, rng.uniform(1, 9), 1.5)))
        exact = bisected(m)
        result = edge_conflict(*m.arguments)
        assert result[0] == (exact is not None)
        if exact is None:
            continue
        compared += 1
        assert result[1] == pytest.approx(float(exact[0]), rel=0, abs=1e-11)
        assert result[2] == pytest.approx(float(exact[1]), rel=0, abs=1e-11)


def test_dense_sampling_sees_no_conflict_outside() -> None:
    rng = np.random.default_rng(30)
    for _ in range(400):
        m = random_meeting(rng)
        _, lo, hi = edge_conflict(*m.arguments)
        assert not unseen(m, lo, hi), m


def test_dense_sampling_sees_conflicts() -> None:
    rng = np.random.default_rng(30)
    assert sum(unseen(random_meeting(rng), inf, -inf) for _ in range(400)) > 40


def unseen(m: Meeting, lo: float, hi: float) -> bool:
    """Whether dense sampling finds a conflict that is not between the two times."""
    # a sampled time is a rounded time; positions move by that much
    speed = max(
        np.hypot(m.bx - m.ax, m.by - m.ay) / m.tau if m.tau else 0.0,
        np.hypot(m.x1 - m.x0, m.y1 - m.y0) / (m.t1 - m.t0),
    )
    if speed * float(m.time_rounding) > float(m.quarter_tol) / 8:
        return False
    sample = sampled_conflicts(m)
    return bool(((sample <= lo) | (sample >= hi)).any())


@pytest.mark.parametrize("start", [0.0, 100.0])
def test_known_crossings(start: float) -> None:
    up = (0.0, -5.0, 0.0, 5.0, 10.0)
    right = (-5.0, 0.0, start, 5.0, 0.0, start + 10.0)
    # at right angles with equal speeds the distance is |delay| / √2
    assert edge_conflict(*up, *right, 1.0) == pytest.approx((True, start - sqrt(2), start + sqrt(2)))
    # standing beside the crossing: nearer than 1 while |x| < 0.6
    assert rest_conflict(0.0, 0.8, *right, 1.0) == pytest.approx((True, start + 4.4, start + 5.6))
    # past a robot that rests: on the way from s = 4 to s = 6
    assert edge_conflict(*up, 0.0, 0.0, start, 0.0, 0.0, inf, 1.0) == (True, start - 6.0, inf)
    assert edge_conflict(*up, 0.0, 0.0, start, 0.0, 0.0, start + 3.0, 1.0) == (True, start - 6.0, start - 1.0)
    # resting in the way for 2 s: t in (4, 6) less the rest
    assert edge_conflict(0.0, 0.0, 0.0, 0.0, 2.0, *right, 1.0) == (True, start + 2.0, start + 6.0)
    assert edge_conflict(0.0, 0.0, 0.0, 0.0, 0.0, *right, 1.0) == (True, start + 4.0, start + 6.0)


def test_known_collinear_meetings() -> None:
    right = (0.0, 0.0, 0.0, 10.0, 0.0, 10.0)
    # head-on: whenever both are under way at once
    assert edge_conflict(10.0, 0.0, 0.0, 0.0, 10.0, *right, 1.0) == (True, -10.0, 10.0)
    # head-on, but both stop: nearer than 2.5 only if each gets far enough while the other is still under way
    assert edge_conflict(14.0, 0.0, 12.0, 0.0, 2.0, *right, 2.5) == pytest.approx((True, 7.5, 8.5))
    # the same way at the same speed: one must keep d / v behind or before
    assert edge_conflict(0.0, 0.0, 10.0, 0.0, 10.0, *right, 1.0) == (True, -1.0, 1.0)
    # twice as fast: must leave after the other has passed 1 before, and be 1 behind where the other arrives
    assert edge_conflict(0.0, 0.0, 10.0, 0.0, 5.0, *right, 1.0) == pytest.approx((True, -0.5, 5.5))


def test_two_that_rest() -> None:
    both = (0.0, 0.0, 0.0, 0.0, 3.0, 0.5, 0.0, 10.0, 0.5, 0.0)
    assert edge_conflict(*both, 20.0, 1.0) == (True, 7.0, 20.0)
    assert edge_conflict(*both, inf, 1.0) == (True, 7.0, inf)
    assert edge_conflict(*both, 20.0, 0.5) == NONE
    assert rest_conflict(0.0, 0.0, 0.5, 0.0, 10.0, 0.5, 0.0, inf, 1.0) == (True, 10.0, inf)
    assert rest_conflict(0.0, 0.0, 0.5, 0.0, 10.0, 0.5, 0.0, inf, 0.5) == NONE


@pytest.mark.parametrize(
    "leg",
    [
        (-5.0, 1.0, 0.0, 5.0, 1.0, 10.0),  # parallel lane
        (5.0, -1.0, 0.0, -5.0, -1.0, 3.0),  # parallel, opposite, faster
        (0.0, 6.0, 0.0, 0.0, 1.0, 10.0),  # comes up to the lane and stops at the touching point
        (6.0, -3.0, 0.0, 6.0, 3.0, 10.0),  # passes the end of the edge
        (2.0, 1.0, 0.0, 2.0, 1.0, inf),  # rests beside it
        (2.0, 1.0, 0.0, 2.0, 1.0, 4.0),
        (0.0, 0.0, 5.0, 0.0, 0.0, 5.0),  # lasts no time
        (0.0, 0.0, inf, 0.0, 0.0, inf),
    ],
)
def test_touching_is_no_conflict(leg: tuple[float, float, float, float, float, float]) -> None:
    edge = (-5.0, 0.0, 5.0, 0.0, 10.0)
    assert edge_conflict(*edge, *leg, 1.0) == NONE
    assert rest_conflict(2.0, 0.0, *leg, 1.0) == NONE or leg[1] == -3.0
    if leg[2] < leg[5]:
        assert edge_conflict(*edge, *leg, 1.0 + 1e-9)[0]


def test_no_distance_asked_is_no_conflict() -> None:
    for d in (0.0, -1.0):
        assert edge_conflict(0.0, 0.0, 1.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 1.0, d) == NONE
        assert edge_conflict(0.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 0.0, 0.0, 1.0, d) == NONE
        assert rest_conflict(0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 1.0, d) == NONE


def test_successive_legs_leave_no_gap() -> None:
    """One robot's legs meet at a stamp: their intervals must meet too, or a departure would slip between them."""
    rng = np.random.default_rng(40)
    for _ in range(500):
        t0, t1, t2 = np.sort(rng.uniform(0, 1000, 3))
        (px, py), (x0, y0), (x1, y1), (x2, y2) = rng.uniform(-1, 1, (4, 2))
        before, after = (x0, y0, t0, x1, y1, t1), (x1, y1, t1, x2, y2, t2)
        if np.hypot(x1 - px, y1 - py) < 1:
            assert rest_conflict(px, py, *before, 1.0)[2] == t1 == rest_conflict(px, py, *after, 1.0)[1]
            assert edge_conflict(px, py, px, py, 0.0, *before, 1.0)[2] == t1
            assert edge_conflict(px, py, px + 1, py, 2.0, *before, 1.0)[2] == t1
            assert edge_conflict(px, py, px + 1, py, 2.0, *after, 1.0)[1] <= t1


@pytest.mark.parametrize("headway", [0.3, 2.0])
def test_headway_widens_both_ends_exactly(headway: float) -> None:
    """Forbidden with headway means forbidden against the leg shifted by some |s| ≤ headway."""
    rng = np.random.default_rng(50)
    compared = 0
    while compared < 40:
        edge, leg = rng.uniform(-3, 3, 4), rng.uniform(-3, 3, 4)
        m = Meeting(*map(float, (*edge, 4.0, *leg[:2], 7.0, *leg[2:], 12.0, 0.8)))
        found, lo, hi = edge_conflict(*m.arguments)
        if not found:
            continue
        compared += 1
        for delta in (lo - headway + 1e-6, hi + headway - 1e-6, lo - headway - 1e-6, hi + headway + 1e-6):
            shifts = np.linspace(-headway, headway, 9)
            squares = [closest(m, Fraction(float(delta - 7.0 - s))) for s in shifts]
            near = any(square is not None and square < Fraction(m.d) ** 2 for square in squares)
            assert near == (lo - headway < delta < hi + headway)


coordinate = st.floats(-10, 10).map(lambda c: round(c * 64) / 64)
place = st.tuples(coordinate, coordinate)


@settings(deadline=None, max_examples=300)
@given(place, place, place, place, st.integers(1, 80), st.integers(1, 80), st.integers(1, 200))
@example((0.0, 0.0), (8.0, 0.0), (8.0, 0.0), (0.0, 0.0), 8, 8, 64)
def test_mirrored_and_reversed_meetings_agree(
    a: tuple[float, float],
    b: tuple[float, float],
    p: tuple[float, float],
    q: tuple[float, float],
    tau: int,
    span: int,
    sixtyfourths: int,
) -> None:
    """All numbers are short dyadic fractions, so the transformed meetings are exactly the same problem."""
    d = sixtyfourths / 64
    found, lo, hi = edge_conflict(*a, *b, tau, *p, 0.0, *q, span, d)
    assert broken_promise(Meeting(*a, *b, tau, *p, 0.0, *q, span, d), found, lo, hi) is None
    mirrored = edge_conflict(a[1], a[0], b[1], b[0], tau, p[1], p[0], 0.0, q[1], q[0], span, d)
    swapped = edge_conflict(*p, *q, span, *a, 0.0, *b, tau, d)  # δ changes its sign
    backward = edge_conflict(*b, *a, tau, *q, 0.0, *p, span, d)  # δ becomes span − tau − δ
    for other, (low, high) in (
        (mirrored, (lo, hi)),
        (swapped, (-hi, -lo)),
        (backward, (span - tau - hi, span - tau - lo)),
    ):
        if other[0] and found:
            # ends at a tangency move with the square root of an error
            assert other[1:] == pytest.approx((low, high), abs=1e-4)
        elif found or other[0]:
            width = hi - lo if found else other[2] - other[1]
            assert width < 1e-4
