"""Repair never makes a plan worse or unsound; its table and search agree with the slower ones they stand for."""

from __future__ import annotations

import math
from itertools import permutations

import networkx as nx
import numpy as np
import pytest
from hypothesis import assume, given, settings
from hypothesis import strategies as st

from strategies import team_scenes
from taut.certificate import certify
from taut.errors import GoalBlocked, NoPath, StartBlocked
from taut.generate import random_scene
from taut.motion import Plan, Trajectory
from taut.scene import AtGoal, Rectangle, Robot, Scene
from taut.team import _search_kernels, _table_kernels, repair
from taut.team._table_kernels import Table
from taut.team.methods import first_order
from taut.team.prioritized import Round, plan_in_order, plan_rounds
from taut.team.repair import Objective, Repaired, repaired
from taut.team.reservations import empty_table, legs_of
from taut.team.safe_intervals import Bench, Failure, bench_of, empty_desk, plan_robot, take
from taut.team.team_arrays import team_of, with_distances
from taut.team.world import World

SIDE = 10.0


def first_plan(world: World) -> Round:
    """Plan the robots with the longest way first: there is something to improve."""
    order = first_order(world.scene, world.shortest, "longest")
    found, _ = plan_rounds(world, order, np.random.default_rng(0), 24, math.inf)
    return found


def world_of(scene: Scene) -> World:
    """Return the world of a scene in which each robot has a way; others are discarded."""
    try:
        return World(scene)
    except (NoPath, StartBlocked, GoalBlocked):
        assume(False)
        raise


def crowd(robots: int, seed: int, **options: object) -> World:
    """Make a small hall full of robots."""
    return World(random_scene(robots, 4, seed, size=12.0, radius=0.35, **options))  # type: ignore[arg-type]


def checked(world: World, first: Round, done: Repaired, objective: Objective) -> Plan:
    """Check what every repaired plan promises, and return it."""
    plan = Plan(world.scene, done.trajectories)
    certificate = certify(plan)
    assert certificate.ok, certificate.problems
    before = Plan(world.scene, tuple(motion for motion in first.trajectories if motion is not None))
    assert len(done.history) == done.rounds + 1
    assert (np.diff(done.history) <= 0).all()
    assert done.history[-1] == done.cost
    assert done.history[0] == pytest.approx(getattr(before, objective), rel=1e-12, abs=1e-12)
    assert done.cost == pytest.approx(getattr(plan, objective), rel=1e-12, abs=1e-12)
    return plan


def stamps_of(done: Repaired) -> list[bytes]:
    return [motion.stamps.tobytes() for motion in done.trajectories]


# --- Plans ------------------------------------------------------------------------------------------------------------


@settings(deadline=None, max_examples=40)
@given(team_scenes(max_robots=6), st.sampled_from(["sum_of_costs", "makespan"]), st.integers(0, 3))
def test_a_repaired_plan_holds_and_costs_no_more(scene: Scene, objective: Objective, seed: int) -> None:
    world = world_of(scene)
    first = first_plan(world)
    assume(not first.failures)
    done = repaired(world, first, seed, rounds=2, objective=objective)
    checked(world, first, done, objective)


@pytest.mark.parametrize("objective", ["sum_of_costs", "makespan"])
@pytest.mark.parametrize(
    ("seed", "options"),
    [
        (0, {}),
        (1, {"headway": 0.3}),
        (2, {"at_goal": "leave", "speed": (0.5, 2.0)}),
        (8, {"gap": 0.0, "clearance": 0.05}),
    ],
)
def test_crowds_gain_much(seed: int, options: dict[str, object], objective: Objective) -> None:
    world = crowd(14, seed, **options)
    first = first_plan(world)
    assert not first.failures
    done = repaired(world, first, rounds=4, objective=objective)
    checked(world, first, done, objective)
    assert done.cost < done.history[0] - 0.01


def test_start_times_and_robots_that_only_make_way_are_kept_in_mind() -> None:
    robots = [
        Robot("late", (1, 3), (9, 3), 0.4, start_time=3.0),
        Robot("slow", (9, 3.2), (1, 3.2), 0.3, 0.5),
        Robot("aside", (5, 3), (5, 3), 0.4),
        Robot("gone", (1, 5), (9, 5), 0.4, at_goal="leave"),
    ]
    world = World(Scene((0, 0, 10, 6), [Rectangle(3, 0, 4, 2.2), Rectangle(3, 4, 4, 2)], robots=robots, gap=0.05))
    first = first_plan(world)
    assert not first.failures
    plan = checked(world, first, repaired(world, first, rounds=3), "sum_of_costs")
    assert plan.trajectories[0].at(2.9).tolist() == [1.0, 3.0]


@pytest.mark.parametrize("seed", range(4))
def test_few_robots_get_as_good_a_plan_as_the_best_of_all_orders(seed: int) -> None:
    scene = random_scene(4, 2, seed, size=5.0, radius=0.45, gap=0.02, obstacle_size=(0.8, 1.2))
    world = World(scene)
    passes = [plan_in_order(world, order, 0.0) for order in permutations(range(4))]
    costs = {
        math.fsum(Plan(scene, done.trajectories).costs): done  # type: ignore[arg-type]
        for done in passes
        if done is not None and not done.failures
    }
    assert costs
    worst = costs[max(costs)]
    done = repaired(world, worst, rounds=4)
    checked(world, worst, done, "sum_of_costs")
    assert done.cost <= min(costs) * (1 + 1e-8)


def test_who_is_not_hindered_keeps_the_very_motion() -> None:
    scene = Scene((0, 0, 8, 8), robots=[Robot("R1", (1, 1), (7, 1), 0.3), Robot("R2", (1, 5), (7, 6), 0.3)])
    world = World(scene)
    first = first_plan(world)
    done = repaired(world, first, rounds=5)
    assert done.rounds == 0
    assert all(a is b for a, b in zip(done.trajectories, first.trajectories, strict=True))
    assert repaired(World(Scene((0, 0, 1, 1))), Round((), 0.0, (), ()), rounds=3).trajectories == ()


# --- Repetition -------------------------------------------------------------------------------------------------------


def test_one_thread_and_two_make_the_same_plan(monkeypatch: pytest.MonkeyPatch) -> None:
    world = crowd(14, 5)
    first = first_plan(world)
    found = []
    for threads in (1, 2, 2):
        monkeypatch.setattr("taut.chunks.os.cpu_count", lambda threads=threads: threads)
        found.append(repaired(world, first, 7, rounds=5))
    assert stamps_of(found[0]) == stamps_of(found[1]) == stamps_of(found[2])
    assert repaired(world, first, 8, rounds=5).history.tolist() != found[0].history.tolist()


def test_fewer_rounds_are_the_beginning_of_more() -> None:
    world = crowd(14, 6)
    first = first_plan(world)
    told: list[tuple[int, float]] = []
    long = repaired(world, first, rounds=5, progress=lambda k, cost: told.append((k, cost)))
    short = repaired(world, first, rounds=2)
    assert short.history.tolist() == long.history[:3].tolist()
    assert told == list(enumerate(long.history.tolist()))[1:]
    # a clock that has run out cuts off everything
    assert repaired(world, first, until=0.0).rounds == 0


def test_tables_grow_without_a_trace(monkeypatch: pytest.MonkeyPatch) -> None:
    world = crowd(14, 5)
    first = first_plan(world)
    plain = repaired(world, first, 7, rounds=3)
    rounds = repair._next_round
    grown = []

    def without_room(team: object, strands: list[repair._Strand], aim: int) -> list[repair._Strand]:
        strands[0].table.free[2] = 0
        after = rounds(team, strands, aim)  # type: ignore[arg-type]
        grown.append(len(after[0].table.robot) > len(strands[0].table.robot))
        return after

    monkeypatch.setattr(repair, "_next_round", without_room)
    done = repaired(world, first, 7, rounds=3)
    assert all(grown)
    checked(world, first, done, "sum_of_costs")
    assert done.cost < plain.history[0]


# --- Refusals ---------------------------------------------------------------------------------------------------------


def test_what_makes_no_sense_is_refused() -> None:
    world = crowd(2, 0)
    first = first_plan(world)
    with pytest.raises(ValueError, match="bound"):
        repaired(world, first)
    with pytest.raises(ValueError, match="rounds"):
        repaired(world, first, rounds=-1)
    with pytest.raises(ValueError, match="seed"):
        repaired(world, first, -1, rounds=1)
    with pytest.raises(ValueError, match="objective"):
        repaired(world, first, rounds=1, objective="length")  # type: ignore[arg-type]
    failed = Round((0, 1), 0.0, (None, first.trajectories[1]), (Failure(0, (0.0, 0.0), 0.0, ()),))
    with pytest.raises(ValueError, match="failures"):
        repaired(world, failed, rounds=1)


# --- The table --------------------------------------------------------------------------------------------------------


def random_motion(rng: np.random.Generator, name: str) -> Trajectory:
    places = rng.uniform(0, SIDE, (6, 2))
    stamps = [(0.0, *places[0])]
    for k in range(1, 6):
        t, x, y = stamps[-1]
        if rng.random() < 0.3:
            stamps.append((t + float(rng.uniform(0.1, 6)), x, y))
        else:
            stamps.append((t + math.dist((x, y), places[k]) / float(rng.choice([0.5, 1.0, 3.0])), *places[k]))
    return Trajectory(name, np.array(stamps))


def random_team(rng: np.random.Generator, headway: float) -> Scene:
    at_goal: tuple[AtGoal, AtGoal] = ("stay", "leave")
    robots = [
        Robot(f"R{k}", (1, 1), (9, 9), float(rng.uniform(0.1, 0.6)), at_goal=at_goal[int(rng.integers(2))])
        for k in range(8)
    ]
    return Scene((0, 0, SIDE, SIDE), robots=robots, gap=0.1, headway=headway)


def links(table: Table) -> list[list[int]]:
    """Legs in each list of the grid, after walking it both ways."""
    out = []
    for first in table.head.ravel():
        entries = []
        before, e = -1, int(first)
        while e >= 0:
            assert table.previous[e] == before
            entries.append(int(table.entry[e]))
            before, e = e, int(table.following[e])
        out.append(sorted(entries))
    return out


@pytest.mark.parametrize("seed", range(6))
def test_a_table_that_was_edited_answers_like_a_fresh_one(seed: int) -> None:
    rng = np.random.default_rng(seed)
    scene = random_team(rng, 0.4 * (seed % 2))
    cell, horizon = float(rng.choice([0.3, 1.0, 4.0])), float(rng.choice([2.0, 20.0, 200.0]))
    table = empty_table(scene, cell, horizon, 200, 200_000)
    legs, motions = np.empty((50, 6)), {}
    for _ in range(60):
        k = int(rng.integers(1, 8))
        first = int(table.first_leg[k])
        _table_kernels.take_out(table, first)
        if k in motions and rng.random() < 0.3:
            _table_kernels.put_back(table, first)
            continue
        _table_kernels.give_up(table, first)
        motions[k] = random_motion(rng, f"R{k}")
        rows = legs_of(motions[k], scene.stays(scene.robots[k]))
        assert _table_kernels.enter_motion(table, k, scene.robots[k].radius, rows, len(rows))
        assert _table_kernels.copied_legs(table, int(table.first_leg[k]), legs) == len(rows)
        np.testing.assert_array_equal(legs[: len(rows)], rows)
    assert sum(map(len, links(table))) == len(table.entry) - table.free[3]
    assert (table.robot >= 0).sum() == len(table.robot) - table.free[2]
    fresh = empty_table(scene, cell, horizon, 200, 200_000)
    for k, motion in motions.items():
        rows = legs_of(motion, scene.stays(scene.robots[k]))
        assert _table_kernels.enter_motion(fresh, k, scene.robots[k].radius, rows, len(rows))
    assert contents(table) == contents(fresh)


def contents(table: Table) -> list[list[tuple[int, list[float]]]]:
    """Robots and legs in each list of the grid."""
    return [sorted((int(table.robot[i]), table.legs[i].tolist()) for i in row) for row in links(table)]


def test_a_full_table_takes_nothing_and_stays_as_it_is() -> None:
    rng = np.random.default_rng(1)
    scene = random_team(rng, 0.0)
    for legs, entries in ((5, 100_000), (100, 20)):
        table = empty_table(scene, 1.0, 20.0, legs, entries)
        few = np.array([[1.0, 1.0, 0.0, 1.0, 1.0, math.inf]])
        assert not _table_kernels.enter_motion(table, 1, 0.2, np.repeat(few, 6, axis=0), 6)
        assert table.free[2:].tolist() == [legs, entries]
        assert table.first_leg[1] == -1
        assert not any(links(table))


# --- The search -------------------------------------------------------------------------------------------------------


def arrival_within(bench: Bench, i: int, limit: float) -> float:
    """Earliest arrival no later than the limit, inf if there is none."""
    team, table, desk = bench.team, bench.table, bench.desk
    count = _search_kernels.soonest_arrival(team, i, table, None, desk, limit, 1 << 20, _search_kernels.EXACT)
    return float(desk.stamps[count - 1, 0]) if count > 0 else math.inf


@settings(deadline=None, max_examples=30)
@given(team_scenes(max_robots=5))
def test_a_limit_keeps_what_is_soon_enough(scene: Scene) -> None:
    bench = bench_of(world_of(scene))
    bench.desk = empty_desk(bench.team, 1 << 12)
    for i in range(len(scene.robots)):
        found = plan_robot(bench, i)
        if isinstance(found, Failure):
            assert arrival_within(bench, i, 1e6) == math.inf
            continue
        arrival = float(found.stamps[-1, 0])
        assert arrival_within(bench, i, 1e6) == pytest.approx(arrival, rel=1e-8)
        if arrival > 0:
            assert arrival_within(bench, i, arrival * (1 - 1e-6)) == math.inf
            assert arrival_within(bench, i, arrival * (1 + 1e-6)) == pytest.approx(arrival, rel=1e-8)
        take(bench, i, found)


@pytest.mark.parametrize("seed", range(3))
def test_distances_are_exact_near_the_way_and_never_too_long_beyond(seed: int) -> None:
    world = crowd(5, seed)
    team = with_distances(team_of(world), np.full(5, 5.0 * seed))
    for i in range(5):
        shared, own = world.shared(i), world.own(i)
        n, total = len(shared.positions), len(shared.positions) + len(own.positions)
        graph = nx.Graph()
        graph.add_nodes_from(range(total))
        for roadmap in (shared, own):
            graph.add_weighted_edges_from(zip(*roadmap.edges.T.tolist(), roadmap.lengths.tolist(), strict=True))
        reached = nx.single_source_dijkstra_path_length(graph, n + 1)
        exact = np.array([reached.get(v, math.inf) for v in range(total)])
        rows = slice(team.near_first[i], team.near_first[i + 1])
        near, away = team.near[rows], team.away[rows]
        speed = world.scene.robots[i].speed
        np.testing.assert_allclose(away * speed, exact[near], rtol=1e-12, atol=1e-12)
        assert team.least[i] * speed == pytest.approx(exact[n], rel=1e-12)
        positions = np.concatenate([shared.positions, own.positions])
        for v in np.setdiff1d(np.arange(total), near):
            left = _search_kernels._left(
                int(v), positions, math.inf, float(team.beyond[i]), speed, *positions[n], *positions[n + 1]
            )
            assert left * speed <= exact[v] * (1 + 1e-12)
