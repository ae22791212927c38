"""Coordination: whatever the delays nobody meets and all arrive; the dead stop those that must pass after them."""

from __future__ import annotations

from functools import cache
from itertools import combinations

import numpy as np
import pytest
from hypothesis import assume, given, settings
from hypothesis import strategies as st

from taut import NoPlanFound, Plan, PlanError, Robot, Scene, Trajectory, load_scene, plan, random_scene
from taut.control import _coordination_kernels
from taut.control.coordination import Dependencies, allowed, dependencies, pending, stopped_by
from taut.scene import AtGoal, FloatArray, Point

ROUNDING = 1 + 2.0**-8  # of tol: distances are computed to about a thousandth of it


@cache
def crowd(seed: int) -> Plan:
    """Ten robots in a tight hall; every third seed they leave at their goals, and with odd seeds they may touch."""
    for k in range(seed, seed + 100, 6):
        scene = random_scene(
            robots=10, obstacles=6, seed=k, size=9.0, obstacle_size=(0.8, 2.0), gap=0.0 if k % 2 else 0.05,
            at_goal="stay" if k % 3 else "leave", speed=(0.5, 1.5), radius=(0.2, 0.3),
        )  # fmt: skip
        try:
            return plan(scene).plan
        except NoPlanFound:
            continue
    raise AssertionError("none of these crowds has a plan")


def least_room(plan: Plan, progress: FloatArray) -> float:
    """Metres between discs beyond the gap, the least over rows of progress (k, n) and robots that are there."""
    scene, paths = plan.scene, plan.trajectories
    places = np.stack([path.at(progress[:, i]) for i, path in enumerate(paths)])
    gone = np.array([not scene.stays(robot) for robot in scene.robots]) & (progress >= [p.arrival for p in paths])
    least = np.inf
    for i, j in combinations(range(len(paths)), 2):
        room = np.hypot(*(places[i] - places[j]).T) - scene.separation(scene.robots[i], scene.robots[j])
        least = min(least, float(np.where(gone[:, i] | gone[:, j], np.inf, room).min()))
    return least


def delayed(
    plan: Plan, rules: Dependencies, rng: np.random.Generator, dead: dict[int, float], steps: int = 2000
) -> tuple[FloatArray, float]:
    """Let robots drive, slow down, stop and die at random within their bounds; return where they end, and least room.

    Room is also measured in between, each robot somewhere on the way of its step.
    """
    n, dt = len(rules.names), 0.1
    progress, bounds, held_by = np.zeros(n), np.empty(n), np.empty(n, dtype=np.int64)
    waiting = pending(rules)
    end = rules.arrivals.copy()
    for robot, where in dead.items():
        end[robot] = where
    rates = rng.uniform(0, 1.25, n)
    seen = [progress]
    for _ in range(steps):
        changed = rng.random(n) < 0.1
        rates = np.where(changed, rng.uniform(0, 1.25, n) * (rng.random(n) < 0.7), rates)
        _coordination_kernels.bounds(rules.waits, waiting, progress, bounds, held_by)
        then = np.maximum(progress, np.minimum(np.minimum(progress + rates * dt, bounds), end))
        seen += [progress + rng.random(n) * (then - progress), then]
        progress = then
        if (progress >= end).all():
            break
    return progress, least_room(plan, np.array(seen))


@settings(max_examples=40, deadline=None)
@given(st.integers(0, 5), st.integers(0, 2**32))
def test_nobody_meets_and_all_arrive_whatever_the_delays(which: int, seed: int) -> None:
    team = crowd(which)
    rules = dependencies(team)
    progress, least = delayed(team, rules, np.random.default_rng(seed), {})
    assert least >= -team.scene.tol * ROUNDING
    assert (progress == rules.arrivals).all()


@pytest.mark.parametrize("which", range(6))
def test_the_same_delays_make_robots_meet_that_wait_for_nobody(which: int) -> None:
    team = crowd(which)
    rules = dependencies(team)
    free = Dependencies(rules.names, rules.arrivals, rules.waits._replace(start=np.zeros_like(rules.waits.start)))
    assert min(delayed(team, free, np.random.default_rng(seed), {})[1] for seed in range(3)) < -0.05


@settings(max_examples=40, deadline=None)
@given(st.integers(0, 5), st.integers(0, 2**32))
def test_the_dead_stop_those_alone_that_must_pass_after_them(which: int, seed: int) -> None:
    team = crowd(which)
    rules = dependencies(team)
    rng = np.random.default_rng(seed)
    victims = rng.choice(len(rules.names), rng.integers(1, 3), replace=False).tolist()
    dead = {i: float(rng.uniform(0, rules.arrivals[i])) for i in victims}
    stopped = stopped_by(rules, {rules.names[i]: where for i, where in dead.items()})
    progress, least = delayed(team, rules, rng, dead)
    assert least >= -team.scene.tol * ROUNDING
    for i, name in enumerate(rules.names):
        if name in stopped:
            assert progress[i] < rules.arrivals[i]
            # robots that follow closely draw near their limit step by step
            assert stopped[name] - 0.2 <= progress[i] <= stopped[name] + 1e-12
        elif i in dead:
            assert progress[i] <= dead[i]
        else:
            assert progress[i] == rules.arrivals[i]


def test_whom_the_dead_hold_are_exactly_at_their_bounds() -> None:
    for which in range(6):
        rules = dependencies(crowd(which))
        dead = {rules.names[0]: rules.arrivals[0] / 3}
        stopped = stopped_by(rules, dead)
        limits = np.array([(stopped | dead).get(n, a) for n, a in zip(rules.names, rules.arrivals, strict=True)])
        bounds, held_by = allowed(rules, limits)
        for i, name in enumerate(rules.names):
            if name in stopped:
                assert bounds[i] == limits[i]
                assert rules.names[held_by[i]] in stopped | dead


@pytest.mark.parametrize("which", range(6))
def test_bounds_are_those_of_densely_sampled_motions(which: int) -> None:
    team = crowd(which)
    rules, scene, h = dependencies(team), team.scene, 0.02
    rng = np.random.default_rng(which)
    for i, j in combinations(range(6), 2):
        apart = scene.separation(scene.robots[i], scene.robots[j]) - scene.tol
        blur = (scene.robots[i].speed + scene.robots[j].speed) * h / 2
        for one, other in ((i, j), (j, i)):
            a, b = team.trajectories[one], team.trajectories[other]
            times_a, times_b = np.arange(0.0, a.arrival, h), np.arange(0.0, b.arrival, h)
            distance = np.hypot(*(a.at(times_a)[:, None] - b.at(times_b)[None]).transpose(2, 0, 1))
            alone = only(rules, waits_of=other, holder=one)
            for s in rng.uniform(0, a.arrival, 6).tolist():
                progress = np.zeros(len(rules.names))
                progress[one] = s
                bound = allowed(alone, progress)[0][other]
                assert bound <= sampled_bound(distance, times_a, times_b, apart - 1e-9, s)
                assert bound >= sampled_bound(distance, times_a, times_b, apart + blur, s - h) - h


@st.composite
def walks(draw: st.DrawFn, name: str) -> Trajectory:
    """Moves and rests between places of a small lattice: robots of radius 0.5 touch all the time."""
    stamps = [[0.0, *draw(lattice)]]
    for _ in range(draw(st.integers(1, 5))):
        stamps.append([stamps[-1][0] + draw(st.sampled_from([0.5, 1.0, 2.0])), *draw(lattice)])
    return path(name, stamps)


lattice = st.tuples(st.integers(0, 5).map(float), st.integers(0, 3).map(float))


@settings(max_examples=80, deadline=None)
@given(walks("A"), walks("B"), st.sampled_from(["stay", "leave"]), st.data())
def test_bounds_are_right_where_robots_touch_rest_and_follow(
    one: Trajectory, other: Trajectory, at_goal: AtGoal, data: st.DataObject
) -> None:
    rules = None
    for lag in (0.0, 0.5, 1.0, 2.0, 3.0, 5.0, 8.0):
        later = [[0.0, *other.points[0]], *(other.stamps + np.array([lag, 0.0, 0.0])).tolist()][lag == 0.0 :]
        pair = (one, path("B", later))
        robots = [Robot(p.name, tuple(p.points[0]), tuple(p.points[-1]), 0.5, at_goal=at_goal) for p in pair]
        try:
            rules = dependencies(Plan(Scene((-1, -1, 6, 4), robots=robots), pair))
        except PlanError:
            continue
        break
    assume(rules is not None)
    assert rules is not None
    one, other = pair
    h = 1 / 32
    times_a, times_b = np.arange(0.0, one.arrival, h), np.arange(0.0, other.arrival, h)
    distance = np.hypot(*(one.at(times_a)[:, None] - other.at(times_b)[None]).transpose(2, 0, 1))
    blur = h * max(speed(one), speed(other))
    for s in data.draw(st.lists(st.integers(0, 40).map(lambda k: k / 4), min_size=3, max_size=3)):
        bound = allowed(rules, [s, 0.0])[0][1]
        assert bound <= sampled_bound(distance, times_a, times_b, 1 - 1e-9, s)
        assert bound >= min(other.arrival, sampled_bound(distance, times_a, times_b, 1 + blur, s - h)) - h


def speed(path: Trajectory) -> float:
    return float((np.hypot(*np.diff(path.points, axis=0).T) / np.diff(path.times)).max())


def only(rules: Dependencies, waits_of: int, holder: int) -> Dependencies:
    """The waits of one robot for another one."""
    waits, n = rules.waits, len(rules.names)
    kept = np.flatnonzero(waits.holder == holder)
    kept = kept[(waits.start[waits_of] <= kept) & (kept < waits.start[waits_of + 1])]
    columns = {name: getattr(waits, name)[kept] for name in ("holder", "leg", "own", "since", "until", "over", "apart")}
    start = np.where(np.arange(n + 1) > waits_of, kept.size, 0)
    return Dependencies(rules.names, rules.arrivals, waits._replace(start=start, **columns))


def sampled_bound(distance: FloatArray, times_a: FloatArray, times_b: FloatArray, d: float, since: float) -> float:
    """Least t of the samples (s, t) nearer than d with t > s ≥ ``since``; rows are s."""
    near = (distance < d) & (times_b[None] > times_a[:, None]) & (times_a[:, None] >= since)
    return float(times_b[near.any(axis=0)][0]) if near.any() else np.inf


def path(name: str, stamps: list[list[float]]) -> Trajectory:
    return Trajectory(name, np.array(stamps, dtype=np.float64))


def crossing(lag: float = 3.0) -> Plan:
    robots = [Robot("A", (0, 5), (10, 5), 0.5), Robot("B", (5, 0), (5, 10), 0.5, start_time=lag)]
    b = [[0.0, 5, 0], [lag, 5, 0], [lag + 10, 5, 10]]
    return Plan(Scene((-1, -1, 11, 11), robots=robots), (path("A", [[0, 0, 5], [10, 10, 5]]), path("B", b)))


def test_at_a_crossing_the_bound_is_the_circle_s() -> None:
    rules = dependencies(crossing())
    assert rules.pairs == [("B", "A")]
    for s, bound in ((0.0, 7.0), (5.0, 7.0), (5.5, 8 - 0.75**0.5), (5.8, 7.4), (6.0, np.inf), (10.0, np.inf)):
        bounds, held_by = allowed(rules, [s, 0.0])
        assert bounds[0] == np.inf
        assert bounds[1] == pytest.approx(bound, abs=1e-9) or s == 6.0
        assert held_by.tolist() == [-1, 0 if s < 6.0 - 1e-9 else held_by[1]]
    assert stopped_by(rules, {"A": 5.5}) == {"B": pytest.approx(8 - 0.75**0.5, abs=1e-9)}
    assert stopped_by(rules, {"A": 6.0}) == {}
    assert stopped_by(rules, {"B": 0.0}) == {}


def train(cars: int, apart: float) -> Plan:
    """Cars one behind the other through a bent corridor, each with stamps of its own."""
    corners = np.array([[0.0, 0.0], [30.0, 0.0], [60.0, 30.0]])
    length = np.concatenate([[0.0], np.cumsum(np.hypot(*np.diff(corners, axis=0).T))])
    paths, robots = [], []
    for k in range(cars):
        begin = (cars - k) * apart
        cuts = np.sort(np.random.default_rng(k).uniform(begin, begin + 40, 7))
        at = np.unique(np.concatenate([[begin], cuts, length[(begin < length) & (length < begin + 40)], [begin + 40]]))
        points = np.stack([np.interp(at, length, corners[:, c]) for c in (0, 1)], axis=1)
        paths.append(Trajectory(f"C{k}", np.column_stack([at - begin, points])))
        robots.append(Robot(f"C{k}", tuple(points[0]), tuple(points[-1]), 0.5))
    return Plan(Scene((-1, -1, 61, 31), robots=robots), tuple(paths))


def test_trains_follow_closely_whatever_their_legs() -> None:
    team = train(5, 1.5)
    rules = dependencies(team)
    for s in np.linspace(0, 35, 200).tolist():
        bounds, _ = allowed(rules, np.full(5, s))
        # 0.5 m between discs at speed 1; through the corner of 45° the way round is longer than straight across
        assert (bounds[1:] >= s + 0.3).all()
        assert (bounds[1:] <= s + 0.5 + 1e-9).all()
    assert np.isinf(bounds[0])
    assert set(stopped_by(rules, {"C2": 10.0})) == {"C3", "C4"}


def test_a_touching_train_moves_off_car_by_car() -> None:
    corners = [[0.0, 10.0 + k, 0.0] for k in range(4)]
    paths = tuple(path(f"C{k}", [start, [10, start[1] + 10, 0]]) for k, start in enumerate(corners))
    robots = [Robot(p.name, tuple(p.points[0]), tuple(p.points[-1]), 0.5) for p in paths]
    rules = dependencies(Plan(Scene((0, -5, 30, 5), robots=robots), paths))
    waiting, progress = pending(rules), np.zeros(4)
    bounds, held_by = np.empty(4), np.empty(4, dtype=np.int64)
    for _ in range(53):
        _coordination_kernels.bounds(rules.waits, waiting, progress, bounds, held_by)
        progress = np.maximum(progress, np.minimum(np.minimum(progress + 0.2, bounds), rules.arrivals))
    assert progress == pytest.approx([10.0] * 4, abs=1e-6)
    assert held_by.tolist()[:3] == [-1, -1, -1]


def test_kernel_that_forgets_waits_finds_the_same_bounds() -> None:
    team = plan(load_scene("crossing-30")).plan
    rules = dependencies(team)
    n = len(rules.names)
    rng, waiting, progress = np.random.default_rng(0), pending(rules), np.zeros(n)
    bounds, held_by = np.empty(n), np.empty(n, dtype=np.int64)
    for _ in range(300):
        _coordination_kernels.bounds(rules.waits, waiting, progress, bounds, held_by)
        afresh = allowed(rules, progress)
        assert np.array_equal(bounds, afresh[0])
        assert np.array_equal(held_by, afresh[1])
        assert (bounds >= progress).all()
        progress = np.maximum(progress, np.minimum(progress + rng.uniform(0, 0.2, n), bounds))
    assert (waiting.head >= 0).sum() < n


def reversal() -> Plan:
    """Two as near as they may be go right together, then left together: neither can turn before the other."""
    paths = (
        path("A", [[0, 1, 1], [2, 3, 1], [4, 1, 1]]),
        path("B", [[0, 2.1, 1], [2, 4.1, 1], [4, 2.1, 1]]),
    )
    robots = [Robot(p.name, tuple(p.points[0]), tuple(p.points[-1]), 0.5) for p in paths]
    return Plan(Scene((0, 0, 6, 2), robots=robots, gap=0.1), paths)


@pytest.mark.parametrize("seed", range(5))
def test_two_that_turn_round_together_get_past_that_instant(seed: int) -> None:
    team = reversal()
    rules = dependencies(team)
    progress, least = delayed(team, rules, np.random.default_rng(seed), {}, steps=400)
    assert (progress == rules.arrivals).all()
    assert least >= -team.scene.tol * ROUNDING


def test_giving_up_some_of_the_gap_lets_robots_be_unlike_late() -> None:
    team = reversal()
    rules = dependencies(team, margin=-0.1)
    for s in np.linspace(0, 3.8, 50).tolist():
        bounds, _ = allowed(rules, [s, s])
        assert (bounds >= s + 0.1 - 1e-9).all()
    progress, least = delayed(team, rules, np.random.default_rng(0), {})
    assert (progress == rules.arrivals).all()
    assert -0.1 - team.scene.tol * ROUNDING <= least < -0.01


@settings(max_examples=40, deadline=None)
@given(st.sampled_from([0, 2, 4]), st.integers(0, 2**32), st.floats(0.1, 5.0))
def test_the_team_is_no_later_than_it_was_delayed(which: int, seed: int, delay: float) -> None:
    team = crowd(which)
    rules, rng = dependencies(team, margin=-0.05), np.random.default_rng(seed)
    n, dt = len(rules.names), 0.05 / 1.5
    progress, bounds, held_by = np.zeros(n), np.empty(n), np.empty(n, dtype=np.int64)
    waiting, time = pending(rules), 0.0
    begin = rng.uniform(0, team.makespan)
    stopped = rng.random(n) < 0.5
    while time < team.makespan + delay + 2 * dt:
        _coordination_kernels.bounds(rules.waits, waiting, progress, bounds, held_by)
        rates = np.where(stopped & (begin <= time < begin + delay), 0.0, 1.0)
        progress = np.maximum(progress, np.minimum(np.minimum(progress + rates * dt, bounds), rules.arrivals))
        time += dt
    assert (progress == rules.arrivals).all()


@settings(max_examples=50, deadline=None)
@given(st.integers(0, 5), st.integers(0, 2**32))
def test_bounds_never_fall_and_are_never_below_the_least_progress(which: int, seed: int) -> None:
    rules, rng = dependencies(crowd(which)), np.random.default_rng(seed)
    progress = rng.uniform(0, rules.arrivals)
    bounds = allowed(rules, progress)[0]
    assert (bounds >= min(progress[progress < rules.arrivals], default=0.0)).all()
    further = np.minimum(progress + rng.exponential(rng.uniform(0, 1), progress.size), rules.arrivals)
    assert (allowed(rules, further)[0] >= bounds - 1e-12 * rules.arrivals.max()).all()


def times(point: Point, scale: float) -> Point:
    return point[0] * scale, point[1] * scale


@pytest.mark.parametrize("scale", [2.0**-30, 2.0**30])
def test_tiny_and_huge_maps_give_the_same_bounds(scale: float) -> None:
    def scaled(team: Plan) -> Plan:
        robots = [
            Robot(r.name, times(r.start, scale), times(r.goal, scale), r.radius * scale, r.speed * scale)
            for r in team.scene.robots
        ]
        paths = [Trajectory(p.name, np.column_stack([p.times, p.points * scale])) for p in team.trajectories]
        return Plan(Scene([times(corner, scale) for corner in team.scene.workspace], robots=robots), tuple(paths))

    for team in (crossing(), train(5, 1.5)):
        rules, other = dependencies(team), dependencies(scaled(team))
        for s in np.linspace(0, 12, 40).tolist():
            progress = np.full(len(rules.names), s)
            assert np.array_equal(allowed(rules, progress)[0], allowed(other, progress)[0])


def test_who_leaves_holds_nobody_any_more() -> None:
    robots = [Robot("A", (0, 1), (5, 1), 0.5, at_goal="leave"), Robot("B", (0, 3), (5, 1), 0.5, at_goal="leave")]
    paths = (path("A", [[0, 0, 1], [5, 5, 1]]), path("B", [[0, 0, 3], [6, 0, 3], [12, 5, 1]]))
    rules = dependencies(Plan(Scene((-1, 0, 6, 4), robots=robots), paths))
    assert rules.pairs == [("B", "A")]
    assert allowed(rules, [4.999, 0.0])[0][1] < 12
    assert np.isinf(allowed(rules, [5.0, 0.0])[0][1])


def test_teams_of_none_of_one_and_of_robots_that_never_move_wait_for_nobody() -> None:
    hall = (0, 0, 9, 9)
    for robots in ([], [Robot("A", (1, 1), (1, 1), 0.5)], [Robot(f"R{k}", (k, 1), (k, 1), 0.5) for k in (1, 2, 4)]):
        paths = tuple(path(r.name, [[0, *r.start]]) for r in robots)
        rules = dependencies(Plan(Scene(hall, robots=robots), paths))
        bounds, held_by = allowed(rules, np.zeros(len(robots)))
        assert np.isinf(bounds).all()
        assert (held_by == -1).all()
        assert rules.pairs == []
        assert stopped_by(rules, {r.name: 0.0 for r in robots}) == {}


def test_what_makes_no_sense_is_refused_in_one_line() -> None:
    team = crossing()
    with pytest.raises(PlanError, match=r"come within 1.12132 m of each other at t = 6.5 s, 2 m are to be kept"):
        dependencies(team, margin=2.0)
    with pytest.raises(PlanError, match="lets A and B come within"):
        dependencies(crossing(0.5))
    with pytest.raises(ValueError, match="margin must be a finite number"):
        dependencies(team, margin=np.nan)
    with pytest.raises(ValueError, match=r"margin of -0\.1 m gives up more than the gap of 0 m"):
        dependencies(team, margin=-0.1)
    rules = dependencies(team)
    with pytest.raises(ValueError, match="progress must be 2 numbers"):
        allowed(rules, [1.0])
    with pytest.raises(ValueError, match="no robot X"):
        stopped_by(rules, {"X": 1.0})
    with pytest.raises(ValueError, match="plan time ≥ 0"):
        stopped_by(rules, {"A": np.nan})
