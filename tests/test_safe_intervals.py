"""The safe-interval search finds the earliest arrival, and the reservation grid forgets no leg."""

from __future__ import annotations

import math
from dataclasses import replace
from itertools import pairwise

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from naive_search import Leg, earliest_arrival, forbidden_departures, legs_of, nearest
from taut.graph import Graph
from taut.motion import Trajectory
from taut.scene import AtGoal, Robot, Scene
from taut.team import _conflict_kernels, _reservation_kernels, _search_kernels
from taut.team._conflict_kernels import Floats, Ints
from taut.team._search_kernels import Adjacency
from taut.team.reservations import NOBODY, Reservations

SIDE = 10.0
AT_GOAL: tuple[AtGoal, AtGoal] = ("stay", "leave")


# --- Intervals --------------------------------------------------------------------------------------------------------

whole = st.tuples(st.integers(0, 12), st.integers(1, 5)).map(lambda p: (float(p[0]), float(p[0] + p[1])))


@settings(deadline=None, max_examples=200)
@given(st.lists(whole, max_size=8), st.integers(-2, 40).map(lambda k: k / 2))
def test_merged_intervals_forbid_the_same_times(intervals: list[tuple[float, float]], t: float) -> None:
    lo, hi = (
        np.array(column, dtype=np.float64) for column in (zip(*intervals, strict=True) if intervals else ([], []))
    )
    count = _reservation_kernels._merge(lo, hi, len(intervals))
    merged = list(zip(lo[:count].tolist(), hi[:count].tolist(), strict=True))
    assert merged == sorted(merged)
    assert all(a[1] <= b[0] for a, b in pairwise(merged))
    for time in np.arange(-1, 20, 0.25).tolist():
        assert any(a < time < b for a, b in merged) == any(a < time < b for a, b in intervals)

    allowed = [x for x in np.arange(-3, 22, 0.5).tolist() if not any(a < x < b for a, b in intervals)]
    assert _reservation_kernels.first_free(lo, hi, count, t) == min(x for x in allowed if x >= t)
    assert _reservation_kernels.last_free(lo, hi, count, t) == max(x for x in allowed if x <= t)


def test_a_forbidden_time_without_end_leaves_nothing_free() -> None:
    lo, hi = np.array([1.0, 3.0]), np.array([2.0, math.inf])
    assert _reservation_kernels.first_free(lo, hi, 2, 1.5) == 2.0
    assert _reservation_kernels.first_free(lo, hi, 2, 3.0) == 3.0  # ends are free
    assert _reservation_kernels.first_free(lo, hi, 2, 3.5) == math.inf
    assert _reservation_kernels.last_free(lo, hi, 2, 1e9) == 3.0


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


def reserve(scene: Scene, trajectories: list[Trajectory], cell: float, horizon: float) -> Reservations:
    reservations = Reservations(scene, cell, horizon)
    for k in range(len(scene.robots)):
        reservations.hold_start(k, 5.0)
    for k, trajectory in enumerate(trajectories, 1):
        reservations.take(k, trajectory)
    return reservations


def body(scene: Scene) -> Floats:
    return np.array([scene.robots[0].radius, scene.gap, scene.headway])


def plain_union(
    lists: list[tuple[bool, float, float]], headway: float, earliest: float, latest: float
) -> tuple[Floats, Floats]:
    widened = [(lo - headway, hi + headway) for found, lo, hi in lists if found]
    kept = [(lo, hi) for lo, hi in widened if hi > earliest and lo < latest]
    lo, hi = np.array([p[0] for p in kept]), np.array([p[1] for p in kept])
    count = _reservation_kernels._merge(lo, hi, len(kept))
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
    arrays = reserve(scene, trajectories, cell, horizon).arrays
    legs, robots, radii = arrays[:3]
    mine, others = body(scene), np.flatnonzero((robots != 0) & (robots != NOBODY))
    distances = mine[0] + radii + mine[1]
    stamp = np.full(len(legs), -1, dtype=np.int64)
    mark = seen = 0
    for _ in range(150):
        a, b = rng.uniform(0, SIDE, (2, 2))
        if rng.random() < 0.4:
            a, b = places[rng.integers(len(places), size=2)]
        lo, hi, count = _reservation_kernels.place_conflicts(
            a[0], a[1], arrays, 0, mine, np.empty(1), np.empty(1), stamp, mark
        )
        mark += 1
        expected = [_conflict_kernels.rest_conflict(*np.array([*a, *legs[i], distances[i]])) for i in others]
        for got, want in zip((lo[:count], hi[:count]), plain_union(expected, mine[2], -np.inf, np.inf), strict=True):
            np.testing.assert_array_equal(got, want)

        tau = max(math.dist(a, b), 0.01) / float(rng.choice([0.01, 1.0, 5.0]))
        earliest = float(rng.choice([0.0, rng.uniform(0, 40)]))
        latest = earliest + float(rng.choice([0.0, rng.uniform(0, 3), rng.uniform(0, 60), math.inf]))
        lo, hi, count = _reservation_kernels.edge_conflicts(
            (*a, *b), tau, earliest, latest, arrays, 0, mine, np.empty(1), np.empty(1), stamp, mark
        )
        mark += 1
        expected = [_conflict_kernels.edge_conflict(*np.array([*a, *b, tau, *legs[i], distances[i]])) for i in others]
        found = plain_union(expected, mine[2], earliest, latest)
        for got, want in zip((lo[:count], hi[:count]), found, strict=True):
            np.testing.assert_array_equal(got, want)
        seen += count
    assert seen > 20


@pytest.mark.parametrize("seed", range(4))
def test_the_earliest_departure_is_the_first_that_every_leg_allows(seed: int) -> None:
    rng = np.random.default_rng(100 + seed)
    places = rng.uniform(0, SIDE, (10, 2))
    scene, trajectories = random_team(rng, 8, places, 7, 0.3 * (seed % 2))
    arrays = reserve(scene, trajectories, 1.0, float(rng.choice([0.5, 5.0, 50.0]))).arrays
    mine = body(scene)
    theirs = naive_legs(scene, trajectories)
    stamp = np.full(len(arrays[0]), -1, dtype=np.int64)
    mark = late = 0
    for _ in range(25):
        a, b = places[rng.choice(len(places), size=2, replace=False)]
        tau, ready = math.dist(a, b) / 1.5, float(rng.uniform(0, 15))
        latest = ready + float(rng.choice([2.0, 20.0, math.inf]))
        got, *_, mark = _reservation_kernels.earliest_departure(
            (*a, *b), tau, ready, latest, arrays, 0, mine, np.empty(4), np.empty(4), stamp, mark
        )
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
    reservations = Reservations(scene, 1.0, 8.0)
    for k in range(2):
        reservations.hold_start(k, 3.0)
    assert reservations.arrays[0].tolist() == [[1, 1, 0, 1, 1, 3], [1, 5, 0, 1, 5, 3]]
    reservations.take(0, Trajectory("R1", np.array([[0, 1, 1], [2, 1, 1], [10, 9, 1]])))
    reservations.take(1, Trajectory("R2", np.array([[0, 1, 5], [8, 9, 5], [9, 9, 5]])))
    legs, robots, radii, *_ = reservations.arrays
    kept = robots != NOBODY
    assert legs[kept].tolist() == [
        [1, 1, 0, 1, 1, 2],
        [1, 1, 2, 9, 1, 10],
        [9, 1, 10, 9, 1, math.inf],
        [1, 5, 0, 9, 5, 8],  # gone from its arrival on
    ]
    assert robots[kept].tolist() == [0, 0, 0, 1]
    assert (radii == 0.5).all()
    stamp = np.full(len(legs), -1, dtype=np.int64)
    _, _, count = _reservation_kernels.place_conflicts(
        1.0, 5.0, reservations.arrays, 2, np.array([0.5, 0.0, 0.0]), np.empty(4), np.empty(4), stamp, 0
    )
    assert count == 1


def test_blockers_are_the_legs_that_a_motion_meets() -> None:
    rng = np.random.default_rng(7)
    places = rng.uniform(0, SIDE, (8, 2))
    met = 0
    for headway in (0.0, 0.5):
        scene, trajectories = random_team(rng, 7, places, 6, headway)
        arrays = reserve(scene, trajectories, 1.0, 20.0).arrays
        legs, robots, radii = arrays[:3]
        way = places[:4]
        tau = np.hypot(*np.diff(way, axis=0).T)
        depart = 2.0 + np.append(0.0, np.cumsum(tau)[:-1])
        got = set(
            zip(
                *(
                    column.tolist()
                    for column in _reservation_kernels.blockers(way, tau, depart, arrays, 0, body(scene))
                ),
                strict=True,
            )
        )
        for k in range(3):
            for i in np.flatnonzero((robots != 0) & (robots != NOBODY)).tolist():
                leg = Leg(*[*legs[i].tolist(), scene.robots[0].radius + radii[i] + scene.gap])
                a, b = tuple(way[k].tolist()), tuple(way[k + 1].tolist())
                off = nearest(a, b, float(depart[k]), float(tau[k]), leg, headway, shifts=201)
                if abs(off) > 0.01:
                    assert ((i, k) in got) == (off > 0)
                    met += off > 0
    assert met > 3


# --- Search -----------------------------------------------------------------------------------------------------------


def naive_legs(scene: Scene, trajectories: list[Trajectory]) -> list[Leg]:
    return [
        leg
        for robot, trajectory in zip(scene.robots[1:], trajectories, strict=True)
        for leg in legs_of(trajectory, scene.stays(robot), scene.separation(scene.robots[0], robot))
    ]


def layers(positions: Floats, edges: Ints, shared: int) -> tuple[Adjacency, Adjacency]:
    """Split a roadmap as the planner does: edges among the first vertices, and all others."""
    lengths = np.hypot(*(positions[edges[:, 0]] - positions[edges[:, 1]]).T)
    base = (edges < shared).all(axis=1)
    out = []
    for n, which in ((shared, base), (len(positions), ~base)):
        graph = Graph.from_edges(n, edges[which], lengths[which])
        out.append((graph.indptr, graph.indices, graph.weights))
    return out[0], out[1]


def random_roadmap(rng: np.random.Generator, n: int) -> tuple[Floats, Ints]:
    positions = rng.uniform(0, SIDE, (n, 2))
    pairs = np.stack(np.triu_indices(n, 1), axis=1)
    away = np.hypot(*(positions[pairs[:, 0]] - positions[pairs[:, 1]]).T)
    return positions, pairs[np.argsort(away)[: int(n * rng.uniform(1.4, 2.5))]].astype(np.int64)


def check_motion(
    found: tuple[Ints, Floats, Floats], positions: Floats, edges: Ints, scene: Scene, legs: list[Leg], stays: bool
) -> None:
    """Check a motion plainly: along edges at top speed, in time, and never nearer than allowed."""
    vertices, arrive, depart = found
    robot = scene.robots[0]
    joined = {frozenset(edge) for edge in edges.tolist()}
    assert arrive[0] == 0.0
    assert depart[0] >= robot.start_time
    assert (depart >= arrive).all()
    at = [tuple(place) for place in positions[vertices].tolist()]
    pieces = []
    for k, (u, v) in enumerate(zip(vertices[:-1].tolist(), vertices[1:].tolist(), strict=True)):
        assert frozenset((u, v)) in joined
        tau = math.dist(at[k], at[k + 1]) / robot.speed
        assert arrive[k + 1] == pytest.approx(depart[k] + tau, abs=1e-9)
        pieces.append((at[k], at[k + 1], float(depart[k]), tau))
    pieces += [(at[k], at[k], float(arrive[k]), float(depart[k] - arrive[k])) for k in range(len(at) - 1)]
    if stays:
        pieces.append((at[-1], at[-1], float(arrive[-1]), 1e6))
    for a, b, departure, tau in pieces:
        for leg in legs:
            assert nearest(a, b, departure, tau, leg, scene.headway) < 1e-9


def search(
    positions: Floats, edges: Ints, shared: int, scene: Scene, trajectories: list[Trajectory], start: int, goal: int
) -> tuple[bool, Ints, Floats, Floats, int, float, int]:
    base, over = layers(positions, edges, shared)
    robot = scene.robots[0]
    arrays = reserve(scene, trajectories, 1.0, 10.0).arrays
    stays, ends, pinched = scene.stays(robot), (start, goal), (False, False)
    return _search_kernels.safe_interval_search(
        base, over, positions, arrays, 0, body(scene), robot.speed, robot.start_time, stays, *ends, pinched
    )


@pytest.mark.parametrize("seed", range(60))
def test_the_arrival_is_the_earliest(seed: int) -> None:
    rng = np.random.default_rng(1000 + seed)
    n = int(rng.integers(5, 13))
    positions, edges = random_roadmap(rng, n)
    # half of the others run on the roadmap itself, so that they meet the robot head-on and follow it
    places = positions if seed % 2 else rng.uniform(0, SIDE, (8, 2))
    scene, trajectories = random_team(rng, int(rng.integers(2, 6)), places, 5, 0.4 * (seed % 5 == 0))
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
    expected = earliest_arrival(
        [tuple(p) for p in positions.tolist()],
        edges.tolist(),
        robot.speed,
        legs,
        scene.headway,
        robot.start_time,
        stays,
        start,
        goal,
    )
    found, vertices, arrive, depart, _, when, _ = search(
        positions, edges, int(rng.integers(0, n + 1)), scene, trajectories, start, goal
    )
    assert found == math.isfinite(expected)
    if found:
        assert when == pytest.approx(expected, abs=1e-6)
        assert arrive[-1] == pytest.approx(expected, abs=1e-6)
        assert (vertices[0], vertices[-1]) == (start, goal)
        check_motion((vertices, arrive, depart), positions, edges, scene, legs, stays)


def test_the_trials_are_not_all_alike() -> None:
    """Of the random trials some find no way, and most that find one are held up: else they would prove little."""
    held, failed = 0, 0
    for seed in range(60):
        rng = np.random.default_rng(1000 + seed)
        n = int(rng.integers(5, 13))
        positions, edges = random_roadmap(rng, n)
        places = positions if seed % 2 else rng.uniform(0, SIDE, (8, 2))
        scene, trajectories = random_team(rng, int(rng.integers(2, 6)), places, 5, 0.4 * (seed % 5 == 0))
        start, goal = (int(v) for v in rng.choice(n, size=2, replace=False))
        found, *_, when, _ = search(positions, edges, n, scene, trajectories, start, goal)
        alone, *_, soonest, _ = search(positions, edges, n, replace(scene, robots=scene.robots[:1]), [], start, goal)
        failed += alone and not found
        held += alone and found and when > soonest + 1e-6
    assert failed > 3
    assert held > 10


def line_of(n: int) -> tuple[Floats, Ints]:
    positions = np.stack([np.arange(n) * 2.0 + 1.0, np.full(n, 1.0)], axis=1)
    return positions, np.array([(k, k + 1) for k in range(n - 1)], dtype=np.int64)


def test_a_robot_waits_until_another_has_passed_its_goal() -> None:
    """With `stay` the goal is good only once nobody passes any more; with `leave` at once."""
    positions, edges = line_of(4)
    other = Trajectory("R1", np.array([[0, 7, 9], [12, 7, 9], [20, 7, 1], [28, 7, 9]]))
    for at_goal, expected in (("leave", 6.0), ("stay", 20.0 + math.sqrt(2))):
        team = [
            Robot("R0", (1, 1), (7, 1), 0.5, at_goal=at_goal),  # type: ignore[arg-type]
            Robot("R1", (7, 9), (7, 9), 0.5),
        ]
        found, *_, when, _ = search(positions, edges, 4, Scene((0, 0, SIDE, SIDE), robots=team), [other], 0, 3)
        assert found
        assert when == pytest.approx(expected, abs=1e-9)


def test_the_search_says_how_far_it_got() -> None:
    positions, edges = line_of(4)
    team = [Robot("R0", (1, 1), (7, 1), 0.5), Robot("R1", (5, 1), (5, 1), 0.5)]
    parked = Trajectory("R1", np.array([[0, 5, 1]]))
    found, vertices, arrive, depart, stuck, when, pops = search(
        positions, edges, 2, Scene((0, 0, SIDE, SIDE), robots=team), [parked], 0, 3
    )
    assert not found
    assert len(vertices) == len(arrive) == len(depart) == 0
    assert (stuck, when, pops) == (1, 2.0, 2)


def test_a_start_that_another_crosses_too_soon_is_no_start() -> None:
    positions, edges = line_of(4)
    team = [Robot("R0", (1, 1), (7, 1), 0.5, start_time=5.0), Robot("R1", (1, 9), (1, 1.5), 0.5)]
    scene = Scene((0, 0, SIDE, SIDE), robots=team)
    early = Trajectory("R1", np.array([[0, 1, 9], [4, 1, 1.5]]))
    assert not search(positions, edges, 4, scene, [early], 0, 3)[0]
    late = Trajectory("R1", np.array([[0, 1, 9], [7.5, 1, 1.5]]))
    assert search(positions, edges, 4, scene, [late], 0, 3)[5] == pytest.approx(11.0)


def test_rests_gather_at_the_start() -> None:
    """Who must let another pass waits where it stands, not on the way."""
    positions, edges = line_of(5)
    team = [Robot("R0", (1, 1), (9, 1), 0.5), Robot("R1", (7, 9), (7, 1), 0.5, at_goal="leave")]
    crossing = Trajectory("R1", np.array([[0, 7, 9], [6, 7, 1]]))
    found, vertices, arrive, depart, *_ = search(
        positions, edges, 5, Scene((0, 0, SIDE, SIDE), robots=team), [crossing], 0, 4
    )
    assert found
    assert vertices.tolist() == [0, 1, 2, 3, 4]
    assert depart[0] >= 1.0
    np.testing.assert_allclose(arrive[1:], depart[1:], atol=1e-12)
