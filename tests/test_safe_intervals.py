"""The safe-interval search finds the earliest arrival, and the reservation grid forgets no leg."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from itertools import pairwise

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from naive_search import Leg, earliest_arrival, forbidden_departures, legs_of, nearest
from taut.motion import Trajectory
from taut.roadmap.core import Arcs
from taut.scene import AtGoal, Robot, Scene
from taut.team import _asking_kernels, _conflict_kernels
from taut.team._conflict_kernels import Floats, Ints
from taut.team._table_kernels import Table
from taut.team.own_roadmap import OwnRoadmap
from taut.team.reservations import empty_table, roomier
from taut.team.safe_intervals import Bench, Failure, empty_desk, hold_start, plan_robot, take
from taut.team.team_arrays import Ground, team_on

SIDE = 10.0
AT_GOAL: tuple[AtGoal, AtGoal] = ("stay", "leave")
NOTHING: Ints = np.empty(0, dtype=np.int64)


# --- Intervals --------------------------------------------------------------------------------------------------------

whole = st.tuples(st.integers(0, 12), st.integers(1, 5)).map(lambda p: (float(p[0]), float(p[0] + p[1])))


@settings(deadline=None, max_examples=200)
@given(st.lists(whole, max_size=8))
def test_merged_intervals_forbid_the_same_times(intervals: list[tuple[float, float]]) -> None:
    lo, hi = (
        np.array(column, dtype=np.float64) for column in (zip(*intervals, strict=True) if intervals else ([], []))
    )
    count = _asking_kernels.merge(lo, hi, len(intervals))
    merged = list(zip(lo[:count].tolist(), hi[:count].tolist(), strict=True))
    assert merged == sorted(merged)
    assert all(a[1] <= b[0] for a, b in pairwise(merged))
    for time in np.arange(-1, 20, 0.25).tolist():
        assert any(a < time < b for a, b in merged) == any(a < time < b for a, b in intervals)


# --- Reservations -----------------------------------------------------------------------------------------------------


def random_trajectory(rng: np.random.Generator, name: str, places: Floats, speed: float, legs: int) -> Trajectory:
    """Make a robot run between some of the places, with rests."""
    at = int(rng.integers(len(places)))
    stamps = [(0.0, *places[at])]
    for _ in range(legs):
        t = stamps[-1][0]
        if rng.random() < 0.3:
            stamps.append((t + float(rng.uniform(0.1, 6)), *stamps[-1][1:]))
            continue
        to = int(rng.integers(len(places)))
        if to != at:
            stamps.append((t + math.dist(places[at], places[to]) / speed, *places[to]))
            at = to
    return Trajectory(name, np.array(stamps))


def random_team(
    rng: np.random.Generator, robots: int, places: Floats, legs: int, headway: float
) -> tuple[Scene, list[Trajectory]]:
    """Make a scene whose first robot is the one that asks, and the motions of the others, which may collide."""
    team = [Robot("R0", (1, 1), (9, 9), float(rng.uniform(0.1, 0.5)))]
    trajectories = []
    for k in range(1, robots):
        speed = float(rng.choice([0.3, 1.0, 2.5]))
        trajectory = random_trajectory(rng, f"R{k}", places, speed, legs)
        radius = float(rng.uniform(0.05, 0.6))
        at_goal: AtGoal = "stay" if rng.random() < 0.6 else "leave"
        start, goal = (tuple(trajectory.points[i].tolist()) for i in (0, -1))
        team.append(Robot(f"R{k}", start, goal, radius, speed, at_goal=at_goal))
        trajectories.append(trajectory)
    return Scene((0, 0, SIDE, SIDE), robots=team, gap=float(rng.choice([0.0, 0.1])), headway=headway), trajectories


def lonely(scene: Scene, cell: float, horizon: float) -> Bench:
    """Make a bench whose robots have no roadmaps worth the name: for reservations alone."""
    bare = Ground(np.zeros((1, 2)), Arcs(np.zeros(2, dtype=np.int64), *np.empty((3, 0)))._replace(indices=NOTHING))
    own = OwnRoadmap(np.empty((0, 2)), (0, 0), NOTHING.reshape(0, 2), np.empty(0), (False, False))
    team = team_on(scene, [bare], [0] * len(scene.robots), [own] * len(scene.robots))
    table = empty_table(scene, cell, horizon, 4, 64)  # too small at first
    return Bench(scene, team, table, empty_desk(team, 4))


def reserve(scene: Scene, trajectories: list[Trajectory], cell: float, horizon: float) -> Table:
    bench = lonely(scene, cell, horizon)
    for k in range(len(scene.robots)):
        hold_start(bench, k, 5.0)
    for k, trajectory in enumerate(trajectories, 1):
        take(bench, k, trajectory)
    return bench.table


def of_others(table: Table) -> tuple[Floats, Ints, Floats]:
    """Legs reserved by others than the first robot, whose they are, and their radii."""
    which = table.robot > 0
    return table.legs[which], table.robot[which], table.radius[which]


def plain_union(
    lists: list[tuple[bool, float, float]], headway: float, earliest: float, latest: float
) -> tuple[Floats, Floats]:
    widened = [(lo - headway, hi + headway) for found, lo, hi in lists if found]
    kept = [(lo, hi) for lo, hi in widened if hi > earliest and lo < latest]
    lo, hi = np.array([p[0] for p in kept]), np.array([p[1] for p in kept])
    count = _asking_kernels.merge(lo, hi, len(kept))
    return lo[:count], hi[:count]


@pytest.mark.parametrize("seed", range(12))
def test_the_grid_forgets_no_leg(seed: int) -> None:
    """What is looked up in the grid equals what asking every single leg gives, to the last bit."""
    rng = np.random.default_rng(seed)
    places = rng.uniform(0, SIDE, (12, 2))
    if seed % 3 == 0:
        places = np.unique(np.round(places), axis=0)  # along the lines between cells, and in the corners
    scene, trajectories = random_team(rng, 9, places, 7, float(rng.choice([0.0, 0.0, 0.7])))
    cell, horizon = float(rng.choice([0.2, 1.0, 3.0, 50.0])), float(rng.choice([0.01, 1.0, 30.0, 1e4]))
    table = reserve(scene, trajectories, cell, horizon)
    legs, _, radii = of_others(table)
    apart, headway = scene.robots[0].radius + scene.gap, scene.headway
    distances = apart + radii
    stamp = np.full(len(table.robot), -1, dtype=np.int64)
    lo, hi = np.empty(500), np.empty(500)
    late = 0
    for mark in range(150):
        a, b = rng.uniform(0, SIDE, (2, 2))
        if rng.random() < 0.4:
            a, b = places[rng.integers(len(places), size=2)]
        count = _asking_kernels.forbidden_times(
            table, a[0], a[1], 0, apart, headway, 0.0, math.inf, lo, hi, stamp, mark
        )
        resting = [
            _conflict_kernels.rest_conflict(*np.array([*a, *leg, d])) for leg, d in zip(legs, distances, strict=True)
        ]
        for got, want in zip((lo[:count], hi[:count]), plain_union(resting, headway, -np.inf, np.inf), strict=True):
            np.testing.assert_array_equal(got, want)
        # looked up for a stretch of time only, they are the same as far as they reach into it
        begin = float(rng.uniform(0, 30))
        end = begin + float(rng.choice([0.0, 3.0, 40.0]))
        count = _asking_kernels.forbidden_times(
            table, a[0], a[1], 0, apart, headway, begin, end, lo, hi, stamp, 1000 + mark
        )
        want_lo, want_hi = plain_union(resting, headway, -np.inf, np.inf)
        for t in rng.uniform(begin, end, 5):
            assert ((lo[:count] < t) & (t < hi[:count])).any() == ((want_lo < t) & (t < want_hi)).any()

        tau = max(math.dist(a, b), 0.01) / float(rng.choice([0.01, 1.0, 5.0]))
        earliest = float(rng.choice([0.0, rng.uniform(0, 40)]))
        latest = earliest + float(rng.choice([0.0, rng.uniform(0, 3), rng.uniform(0, 60)]))
        moving = [
            _conflict_kernels.edge_conflict(*np.array([*a, *b, tau, *leg, d]))
            for leg, d in zip(legs, distances, strict=True)
        ]
        union = list(zip(*plain_union(moving, headway, -np.inf, np.inf), strict=True))
        first, last = earliest, latest
        for begins, ends in union:
            first = ends if begins < first < ends else first
        for begins, ends in reversed(union):
            last = begins if begins < last < ends else last
        args = table, (*a, *b), tau, earliest, latest, 0, apart, headway
        soonest = _asking_kernels.first_departure(*args)
        assert soonest == pytest.approx(first if first <= latest else math.inf, abs=1e-9)
        final = _asking_kernels.last_departure(*args)
        assert final == pytest.approx(last if last >= earliest else -math.inf, abs=1e-9)
        late += first > earliest
    assert late > 10


@pytest.mark.parametrize("seed", range(4))
def test_the_earliest_departure_is_the_first_that_every_leg_allows(seed: int) -> None:
    rng = np.random.default_rng(100 + seed)
    places = rng.uniform(0, SIDE, (10, 2))
    scene, trajectories = random_team(rng, 8, places, 7, 0.3 * (seed % 2))
    table = reserve(scene, trajectories, 1.0, float(rng.choice([0.5, 5.0, 50.0])))
    apart = scene.robots[0].radius + scene.gap
    theirs = naive_legs(scene, trajectories)
    late = 0
    for _ in range(25):
        a, b = places[rng.choice(len(places), size=2, replace=False)]
        tau, ready = math.dist(a, b) / 1.5, float(rng.uniform(0, 15))
        latest = ready + float(rng.choice([2.0, 20.0, math.inf]))
        got = _asking_kernels.first_departure(table, (*a, *b), tau, ready, latest, 0, apart, scene.headway)
        expected = ready
        for lo, hi in forbidden_departures(tuple(a), tuple(b), tau, theirs, scene.headway):
            if lo < expected < hi:
                expected = hi
        late += expected > ready
        if expected > latest or math.isinf(expected):
            assert got == math.inf
        else:
            assert got == pytest.approx(expected, abs=1e-6)
    assert late > 3


def test_a_taken_motion_replaces_the_hold_on_its_start() -> None:
    team = [Robot("R1", (1, 1), (9, 1), 0.5), Robot("R2", (1, 5), (9, 5), 0.5, at_goal="leave")]
    scene = Scene((0, 0, SIDE, SIDE), robots=team)
    bench = lonely(scene, 1.0, 8.0)
    for k in range(2):
        hold_start(bench, k, 3.0)
    assert rows_of(bench.table) == [[0, 1, 1, 0, 1, 1, 3], [1, 1, 5, 0, 1, 5, 3]]
    take(bench, 0, Trajectory("R1", np.array([[0, 1, 1], [2, 1, 1], [10, 9, 1]])))
    take(bench, 1, Trajectory("R2", np.array([[0, 1, 5], [8, 9, 5], [9, 9, 5]])))
    expected = [
        [0, 1, 1, 0, 1, 1, 2],
        [0, 1, 1, 2, 9, 1, 10],
        [0, 9, 1, 10, 9, 1, math.inf],
        [1, 1, 5, 0, 9, 5, 8],  # gone from its arrival on
    ]
    assert rows_of(bench.table) == expected
    assert rows_of(roomier(bench.table)) == expected
    assert (bench.table.radius[bench.table.robot >= 0] == 0.5).all()


def rows_of(table: Table) -> list[list[float]]:
    """Robot and leg of all that is reserved, sorted."""
    return sorted(np.column_stack([table.robot, table.legs])[table.robot >= 0].tolist())


def test_legs_met_are_those_that_a_motion_meets() -> None:
    rng = np.random.default_rng(7)
    places = rng.uniform(0, SIDE, (8, 2))
    met = 0
    for headway in (0.0, 0.5):
        scene, trajectories = random_team(rng, 7, places, 6, headway)
        table = reserve(scene, trajectories, 1.0, 20.0)
        apart = scene.robots[0].radius + scene.gap
        way = places[:4]
        tau = np.hypot(*np.diff(way, axis=0).T)
        depart = 2.0 + np.append(0.0, np.cumsum(tau)[:-1])
        legs_met = _asking_kernels.legs_met(table, way, tau, depart, 0, apart, headway)
        got = set(zip(*(column.tolist() for column in legs_met), strict=True))
        whom = np.empty(len(scene.robots), dtype=np.int64)
        count = 0
        for k in range(3):
            edge = (*way[k].tolist(), *way[k + 1].tolist())
            count = _asking_kernels.robots_met(
                table, edge, float(tau[k]), float(depart[k]), 0, apart, headway, 0.0, whom, count
            )
            for i in np.flatnonzero(table.robot > 0).tolist():
                leg = Leg(*[*table.legs[i].tolist(), apart + table.radius[i]])
                a, b = tuple(way[k].tolist()), tuple(way[k + 1].tolist())
                off = nearest(a, b, float(depart[k]), float(tau[k]), leg, headway, shifts=201)
                if abs(off) > 0.01:
                    assert ((i, k) in got) == (off > 0)
                    met += off > 0
        assert sorted(whom[:count].tolist()) == sorted({int(table.robot[i]) for i, _ in got})
    assert met > 3


# --- Search -----------------------------------------------------------------------------------------------------------


def naive_legs(scene: Scene, trajectories: list[Trajectory]) -> list[Leg]:
    return [
        leg
        for robot, trajectory in zip(scene.robots[1:], trajectories, strict=True)
        for leg in legs_of(trajectory, scene.stays(robot), scene.separation(scene.robots[0], robot))
    ]


def random_roadmap(rng: np.random.Generator, n: int) -> tuple[Floats, Ints]:
    positions = rng.uniform(0, SIDE, (n, 2))
    pairs = np.stack(np.triu_indices(n, 1), axis=1)
    away = np.hypot(*(positions[pairs[:, 0]] - positions[pairs[:, 1]]).T)
    return positions, pairs[np.argsort(away)[: int(n * rng.uniform(1.4, 2.5))]].astype(np.int64)


def check_motion(
    found: tuple[Ints, Floats, Floats],
    positions: Floats,
    arcs: list[tuple[int, int, float]],
    scene: Scene,
    legs: list[Leg],
    stays: bool,
) -> None:
    """Check a motion plainly: along arcs in their time, and never nearer than allowed."""
    vertices, arrive, depart = found
    seconds = {(u, v): tau for u, v, tau in arcs}
    assert arrive[0] == 0.0
    assert depart[0] >= scene.robots[0].start_time
    assert (depart >= arrive).all()
    at = [tuple(place) for place in positions[vertices].tolist()]
    pieces = []
    for k, (u, v) in enumerate(zip(vertices[:-1].tolist(), vertices[1:].tolist(), strict=True)):
        tau = seconds[u, v]
        assert arrive[k + 1] == pytest.approx(depart[k] + tau, abs=1e-9)
        pieces.append((at[k], at[k + 1], float(depart[k]), tau))
    pieces += [(at[k], at[k], float(arrive[k]), float(depart[k] - arrive[k])) for k in range(len(at) - 1)]
    if stays:
        pieces.append((at[-1], at[-1], float(arrive[-1]), 1e6))
    for a, b, departure, tau in pieces:
        for leg in legs:
            assert nearest(a, b, departure, tau, leg, scene.headway) < 1e-9


@dataclass(frozen=True)
class Roads:
    """Arcs (from, to, seconds) of the first vertices as a shared roadmap, edges of the others both ways."""

    ground: Ground
    own: OwnRoadmap
    arcs: list[tuple[int, int, float]]


def roads(
    rng: np.random.Generator | None,
    positions: Floats,
    edges: Ints,
    shared: int,
    speed: float,
    ends: tuple[int, int],
) -> Roads:
    """Split a roadmap as the planner does; with a generator some shared edges are one-way and some slow."""
    lengths = np.hypot(*(positions[edges[:, 0]] - positions[edges[:, 1]]).T)
    base = (edges < shared).all(axis=1)
    rows = []
    for (u, v), length in zip(edges[base].tolist(), lengths[base].tolist(), strict=True):
        limit, way = (math.inf, 0.5) if rng is None else (float(rng.choice([0.3, 0.8, math.inf])), rng.random())
        rows += [(u, v, length, limit)] if way < 0.8 else []
        rows += [(v, u, length, limit)] if way > 0.2 else []
    rows.sort()
    tails = np.array([row[0] for row in rows], dtype=np.int64)
    arcs = Arcs(
        np.searchsorted(tails, np.arange(shared + 1)).astype(np.int64),
        np.array([row[1] for row in rows], dtype=np.int64),
        np.array([row[2] for row in rows], dtype=np.float64),
        np.array([row[3] for row in rows], dtype=np.float64),
    )
    own = OwnRoadmap(positions[shared:], ends, edges[~base], lengths[~base], (False, False))
    seconds = [(u, v, length / min(speed, limit)) for u, v, length, limit in rows]
    for (u, v), length in zip(edges[~base].tolist(), lengths[~base].tolist(), strict=True):
        seconds += [(u, v, length / speed), (v, u, length / speed)]
    return Roads(Ground(positions[:shared], arcs), own, seconds)


def planned(
    scene: Scene, way: Roads, trajectories: list[Trajectory], most: int = 1 << 60
) -> tuple[Bench, Trajectory | Failure]:
    """Plan the first robot among the motions of the others."""
    robots = len(scene.robots)
    nowhere = OwnRoadmap(np.empty((0, 2)), (0, 0), NOTHING.reshape(0, 2), np.empty(0), (False, False))
    team = team_on(scene, [way.ground], [0] * robots, [way.own] + [nowhere] * (robots - 1))
    table = reserve(scene, trajectories, 1.0, 10.0)
    bench = Bench(scene, team, table, empty_desk(team, len(table.robot), 4, 64, 2))
    blank = [a.copy() for a in (bench.desk.away, bench.desk.row, bench.desk.first)]
    found = plan_robot(bench, 0, most)
    for before, after in zip(blank, (bench.desk.away, bench.desk.row, bench.desk.first), strict=True):
        np.testing.assert_array_equal(before, after)
    return bench, found


@pytest.mark.parametrize("seed", range(60))
def test_the_arrival_is_the_earliest(seed: int) -> None:
    rng = np.random.default_rng(1000 + seed)
    scene, trajectories, positions, edges = trial(rng, seed)
    n = len(positions)
    robot = replace(
        scene.robots[0],
        speed=float(rng.choice([0.5, 1.0, 2.0])),
        start_time=float(rng.choice([0.0, 0.0, 3.0])),
        at_goal=AT_GOAL[rng.integers(2)],
    )
    scene = replace(scene, robots=(robot, *scene.robots[1:]))
    start, goal = (int(v) for v in rng.choice(n, size=2, replace=False))
    legs = naive_legs(scene, trajectories)
    stays = scene.stays(robot)
    shared = int(rng.integers(1, n + 1))
    way = roads(None if seed % 3 else rng, positions, edges, shared, robot.speed, (start, goal))
    expected = earliest_arrival(
        [tuple(p) for p in positions.tolist()],
        way.arcs,
        legs,
        scene.headway,
        robot.start_time,
        stays,
        start,
        goal,
    )
    bench, found = planned(scene, way, trajectories)
    assert isinstance(found, Trajectory) == math.isfinite(expected)
    if isinstance(found, Trajectory):
        assert found.stamps[-1, 0] == pytest.approx(expected, abs=1e-6)
        vertices, arrive, depart = traced(bench)
        assert arrive[-1] == pytest.approx(expected, abs=1e-6)
        assert (vertices[0], vertices[-1]) == (start, goal)
        check_motion((vertices, arrive, depart), positions, way.arcs, scene, legs, stays)
        for k, t in enumerate(found.times.tolist()):
            place = np.interp(t, np.column_stack([arrive, depart]).ravel(), np.repeat(positions[vertices][:, 0], 2))
            assert found.points[k, 0] == pytest.approx(place, abs=1e-6)


def trial(rng: np.random.Generator, seed: int) -> tuple[Scene, list[Trajectory], Floats, Ints]:
    """Make a team and a roadmap; half of the teams run on it, so that they meet the robot head-on and follow it."""
    positions, edges = random_roadmap(rng, int(rng.integers(5, 13)))
    places = positions if seed % 2 else rng.uniform(0, SIDE, (8, 2))
    scene, trajectories = random_team(rng, int(rng.integers(2, 6)), places, 5, 0.4 * (seed % 5 == 0))
    return scene, trajectories, positions, edges


def traced(bench: Bench) -> tuple[Ints, Floats, Floats]:
    """Vertices of the motion found last, arrivals and departures."""
    n = int(bench.desk.counts[4])
    return bench.desk.path[:n], bench.desk.at[:n, 0], bench.desk.at[:n, 1]


def test_the_trials_are_not_all_alike() -> None:
    """Of the random trials some find no way, and most that find one are held up: else they would prove little."""
    held, failed = 0, 0
    for seed in range(60):
        rng = np.random.default_rng(1000 + seed)
        scene, trajectories, positions, edges = trial(rng, seed)
        start, goal = (int(v) for v in rng.choice(len(positions), size=2, replace=False))
        way = roads(None, positions, edges, len(positions), 1.0, (start, goal))
        _, found = planned(scene, way, trajectories)
        _, alone = planned(replace(scene, robots=scene.robots[:1]), way, [])
        if isinstance(alone, Trajectory):
            failed += isinstance(found, Failure)
            held += isinstance(found, Trajectory) and found.arrival > alone.arrival + 1e-6
    assert failed > 3
    assert held > 10


def line_of(n: int, shared: int, ends: tuple[int, int]) -> Roads:
    positions = np.stack([np.arange(n) * 2.0 + 1.0, np.full(n, 1.0)], axis=1)
    edges = np.array([(k, k + 1) for k in range(n - 1)], dtype=np.int64)
    return roads(None, positions, edges, shared, 1.0, ends)


def test_a_robot_waits_until_another_has_passed_its_goal() -> None:
    """With `stay` the goal is good only once nobody passes any more; with `leave` at once."""
    other = Trajectory("R1", np.array([[0, 7, 9], [12, 7, 9], [20, 7, 1], [28, 7, 9]]))
    for at_goal, expected in (("leave", 6.0), ("stay", 20.0 + math.sqrt(2))):
        team = [
            Robot("R0", (1, 1), (7, 1), 0.5, at_goal=at_goal),  # type: ignore[arg-type]
            Robot("R1", (7, 9), (7, 9), 0.5),
        ]
        _, found = planned(Scene((0, 0, SIDE, SIDE), robots=team), line_of(4, 4, (0, 3)), [other])
        assert isinstance(found, Trajectory)
        assert found.arrival == pytest.approx(expected, abs=1e-9)


def test_the_search_says_how_far_it_got() -> None:
    team = [Robot("R0", (1, 1), (7, 1), 0.5), Robot("R1", (5, 1), (5, 1), 0.5)]
    parked = Trajectory("R1", np.array([[0, 5, 1]]))
    scene = Scene((0, 0, SIDE, SIDE), robots=team)
    bench, found = planned(scene, line_of(4, 2, (0, 3)), [parked])
    assert found == Failure(0, (3.0, 1.0), 2.0, (1,))
    assert bench.desk.counts[2] == 2
    # given up before it begins to move
    _, found = planned(scene, line_of(4, 2, (0, 3)), [parked], most=1)
    assert isinstance(found, Failure)
    assert (found.place, found.time) == ((1.0, 1.0), 0.0)


def test_a_start_that_another_crosses_too_soon_is_no_start() -> None:
    team = [Robot("R0", (1, 1), (7, 1), 0.5, start_time=5.0), Robot("R1", (1, 9), (1, 1.5), 0.5)]
    scene, way = Scene((0, 0, SIDE, SIDE), robots=team), line_of(4, 4, (0, 3))
    early = Trajectory("R1", np.array([[0, 1, 9], [4, 1, 1.5]]))
    assert isinstance(planned(scene, way, [early])[1], Failure)
    late = Trajectory("R1", np.array([[0, 1, 9], [7.5, 1, 1.5]]))
    found = planned(scene, way, [late])[1]
    assert isinstance(found, Trajectory)
    assert found.arrival == pytest.approx(11.0)


def test_rests_gather_at_the_start() -> None:
    """Who must let another pass waits where it stands, not on the way."""
    team = [Robot("R0", (1, 1), (9, 1), 0.5), Robot("R1", (7, 9), (7, 1), 0.5, at_goal="leave")]
    crossing = Trajectory("R1", np.array([[0, 7, 9], [6, 7, 1]]))
    bench, found = planned(Scene((0, 0, SIDE, SIDE), robots=team), line_of(5, 5, (0, 4)), [crossing])
    assert isinstance(found, Trajectory)
    vertices, arrive, depart = traced(bench)
    assert vertices.tolist() == [0, 1, 2, 3, 4]
    assert depart[0] >= 1.0 - 1e-9
    np.testing.assert_allclose(arrive[1:], depart[1:], atol=1e-12)


def test_one_way_and_slow_lanes_are_kept_to() -> None:
    """A square whose short side leads the other way, and whose long way round is slow on one side."""
    positions = np.array([(1.0, 1.0), (5.0, 1.0), (5.0, 5.0), (1.0, 5.0)])
    arcs = Arcs(
        np.array([0, 1, 2, 3, 4]),
        np.array([3, 0, 1, 2]),
        np.full(4, 4.0),
        np.array([math.inf, math.inf, 0.5, math.inf]),
    )
    own = OwnRoadmap(np.empty((0, 2)), (0, 1), NOTHING.reshape(0, 2), np.empty(0), (False, False))
    scene = Scene((0, 0, SIDE, SIDE), robots=[Robot("R0", (1, 1), (5, 1), 0.5)])
    team = team_on(scene, [Ground(positions, arcs)], [0], [own])
    table = empty_table(scene, 1.0, 10.0)
    found = plan_robot(Bench(scene, team, table, empty_desk(team, len(table.robot))), 0)
    assert isinstance(found, Trajectory)
    assert found.stamps.tolist() == [[0, 1, 1], [4, 1, 5], [8, 5, 5], [16, 5, 1]]
    assert team.least.tolist() == [16.0]


def test_who_starts_at_its_goal_on_the_shared_roadmap_steps_aside_and_returns() -> None:
    line = line_of(4, 4, (2, 2))
    team = [Robot("R0", (5, 1), (5, 1), 0.5), Robot("R1", (5, 9), (5, 0.5), 0.5, at_goal="leave")]
    scene = Scene((0, 0, SIDE, SIDE), robots=team)
    bench, found = planned(scene, line, [Trajectory("R1", np.array([[0, 5, 9], [8.5, 5, 0.5]]))])
    assert isinstance(found, Trajectory)
    assert (found.points[[0, -1]] == (5, 1)).all()
    assert found.length == pytest.approx(4.0)
    assert bench.team.least[0] == 0.0
    _, found = planned(scene, line, [Trajectory("R1", np.array([[0, 5, 9], [8.5, 9, 9]]))])
    assert isinstance(found, Trajectory)
    assert found.stamps.tolist() == [[0, 5, 1]]
