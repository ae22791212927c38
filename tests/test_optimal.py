"""Optimal plans: never dearer than any other plan, never in conflict, and the bound is true at every moment."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from functools import cache
from itertools import combinations, pairwise

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from naive_search import Leg, forbidden_departures
from taut.certificate import certify
from taut.motion import Plan, Trajectory
from taut.scene import FloatArray, Point, Robot, Scene
from taut.team._meeting_kernels import first_meeting
from taut.team._rule_kernels import KEEP_OUT, NOT_ALONG, NOT_AT, NOT_THROUGHOUT, Steps
from taut.team.optimal import Objective, OptimalPlan, RoadmapProblem, optimal_plan, prepared

# --- Problems ---------------------------------------------------------------------------------------------------------


def trajectories(problem: RoadmapProblem, plan: OptimalPlan) -> list[Trajectory]:
    """Motions as stamps, without rests and moves of no duration."""
    assert plan.motions is not None
    out = []
    for i, motion in enumerate(plan.motions):
        rows = [(0.0, *problem.positions[motion.vertices[0]].tolist())]
        for v, arrive, depart in zip(motion.vertices, motion.arrive.tolist(), motion.depart.tolist(), strict=True):
            x, y = problem.positions[v].tolist()
            for t in (arrive, depart):
                if rows[-1][0] < t < math.inf:
                    rows.append((t, x, y))
        out.append(Trajectory(f"R{i}", np.array(rows)))
    return out


def scene_of(problem: RoadmapProblem) -> Scene:
    """The same robots in an empty workspace whose tolerance is the problem's."""
    points = problem.positions
    margin = 2 * float(problem.radii.max(initial=0.0)) + 1
    low, high = points.min(axis=0) - margin, points.max(axis=0) + margin
    robots = [
        Robot(
            f"R{i}",
            tuple(points[s].tolist()),
            tuple(points[g].tolist()),
            r,
            v,
            start_time=t,
            at_goal="leave" if leaves(problem, i) else "stay",
        )
        for i, (s, g, r, v, t) in enumerate(
            zip(
                problem.starts.tolist(),
                problem.goals.tolist(),
                problem.radii.tolist(),
                problem.speeds.tolist(),
                problem.start_times.tolist(),
                strict=True,
            )
        )
    ]
    return Scene((*low.tolist(), *high.tolist()), robots=robots, gap=problem.gap)


def check(problem: RoadmapProblem, plan: OptimalPlan, objective: Objective = "sum_of_costs") -> None:
    """The plan holds, by a checker that shares no code with the planner, and costs what it says."""
    motion = Plan(scene_of(problem), tuple(trajectories(problem, plan)))
    found = certify(motion)
    assert found.ok, found.problems
    assert plan.cost == pytest.approx(getattr(motion, objective), abs=1e-7)
    assert plan.lower_bound <= plan.cost


# --- The oracle: all walks, all orders --------------------------------------------------------------------------------
# Each robot takes some walk; for given walks, two pieces of different robots that may conflict say that one difference
# of departures is at most lo or at least hi. Branching over these orders and taking the least times that satisfy the
# chosen ones is exact: least times are least for every robot at once. There are no rules, no safe intervals.

Walk = tuple[int, ...]


@dataclass(frozen=True)
class Piece:
    """A move (from `depart` on) or a rest (from the arrival of the move before, until `until`), by numbers of times."""

    robot: int
    a: Point
    b: Point
    tau: float
    depart: int  # the departure of the move; of a rest: of the move before it, -1 for the start
    until: int  # of a rest: the departure that ends it, -1 for the goal


@cache
def window(
    a: Point, b: Point, tau: float, c: Point, d: Point, theirs: float, apart: float
) -> tuple[float, float] | None:
    """The differences of departures at which two moves conflict."""
    found = forbidden_departures(a, b, tau, [Leg(*c, 0.0, *d, theirs, apart)], 0.0)
    return found[0] if found and found[0][1] - found[0][0] > 1e-9 else None


@cache
def passage(a: Point, b: Point, tau: float, place: Point, apart: float) -> tuple[float, float] | None:
    """The times of a move at which it is too near to a place."""
    found = forbidden_departures(a, b, tau, [Leg(*place, 0.0, *place, 1.0, apart)], 0.0)  # of a rest of one second
    return (1.0 - found[0][1], -found[0][0]) if found and found[0][1] - found[0][0] > 1.0 + 1e-9 else None


class TooMuchWorkError(Exception):
    """The oracle would take too long."""


def seconds_along(problem: RoadmapProblem, i: int) -> dict[tuple[int, int], float]:
    """Durations of the edges for robot i."""
    limits = np.full(len(problem.lengths), math.inf) if problem.limits is None else problem.limits
    tails = np.repeat(np.arange(len(problem.positions)), np.diff(problem.indptr)).tolist()
    taken = (problem.lengths / np.minimum(limits, problem.speeds[i])).tolist()
    return dict(zip(zip(tails, problem.indices.tolist(), strict=True), taken, strict=True))


def leaves(problem: RoadmapProblem, i: int) -> bool:
    return problem.leaves is not None and bool(problem.leaves[i])


def may_use(problem: RoadmapProblem, i: int, v: int) -> bool:
    return problem.owners is None or int(problem.owners[v]) in (-1, i)


def walks(problem: RoadmapProblem, i: int, most: float, left: FloatArray) -> Iterator[tuple[float, Walk]]:
    """All walks of robot i that take at most so many seconds, with their durations."""
    taken, goal = seconds_along(problem, i), int(problem.goals[i])
    stack: list[tuple[float, Walk]] = [(0.0, (int(problem.starts[i]),))]
    while stack:
        spent, walk = stack.pop()
        if walk[-1] == goal:
            yield spent, walk
        for e in range(problem.indptr[walk[-1]], problem.indptr[walk[-1] + 1]):
            v = int(problem.indices[e])
            then = spent + taken[walk[-1], v]
            back = v in walk[-2:-1] and then == spent  # to and fro in no time
            if then + left[v] <= most and not back:
                stack.append((then, (*walk, v)))


class Timing:
    """The least times of a set of walks, one robot added after the other."""

    def __init__(self, problem: RoadmapProblem, most: float, makespan: bool, work: int) -> None:
        self.problem, self.most, self.makespan = problem, most, makespan
        self.points: list[Point] = [tuple(p) for p in problem.positions.tolist()]
        self.seconds = [seconds_along(problem, i) for i in range(len(problem.starts))]
        self.work = work

    def cost(self, chosen: Sequence[Walk], rest: float) -> float:
        """Least cost of these robots, given that the others cost at least `rest`; inf if it is not below `most`."""
        pieces: list[Piece] = []
        chains: list[tuple[int, int, float]] = []  # times[b] ≥ times[a] + c
        first: list[float] = []
        ends: list[tuple[int, int, float]] = []  # robot, last departure, its duration
        for i, walk in enumerate(chosen):
            before, tau = -1, 0.0
            for u, v in pairwise(walk):
                k = len(first)
                a, b = self.points[u], self.points[v]
                first.append(float(self.problem.start_times[i]) if before < 0 else 0.0)
                if before >= 0:
                    chains.append((before, k, tau))
                pieces.append(Piece(i, a, a, tau, before, k))
                tau = self.seconds[i][u, v]
                pieces.append(Piece(i, a, b, tau, k, -2))
                before = k
            goal = self.points[walk[-1]]
            if not leaves(self.problem, i):
                pieces.append(Piece(i, goal, goal, tau, before, -1))
            ends.append((i, before, tau))
        choices = [c for p, q in combinations(pieces, 2) if p.robot != q.robot for c in [self._orders(p, q)] if c]
        return self._best(first, chains, ends, choices, rest)

    def _orders(self, p: Piece, q: Piece) -> tuple[tuple[int, int, float], ...] | None:
        """The two orders of a pair of pieces as differences (a, b, c): times[b] ≥ times[a] + c; None if all is well."""
        if 0.0 in [piece.tau for piece in (p, q) if piece.until == -2]:
            return None  # the rests before and after a move of no duration are where it is
        apart = float(self.problem.radii[p.robot] + self.problem.radii[q.robot]) + self.problem.gap
        if p.until == -2 and q.until == -2:
            found = window(p.a, p.b, p.tau, q.a, q.b, q.tau, apart)
            return found and ((p.depart, q.depart, -found[0]), (q.depart, p.depart, found[1]))
        if p.until == -2:
            near = passage(p.a, p.b, p.tau, q.a, apart)
            # the move is over before the rest begins, or begins to be near after it has ended
            return near and ((p.depart, q.depart, near[1] - q.tau), (q.until, p.depart, -near[0]))
        if q.until == -2:
            return self._orders(q, p)
        if math.dist(p.a, q.a) >= apart:
            return None
        return (p.until, q.depart, -q.tau), (q.until, p.depart, -p.tau)

    def _best(
        self,
        first: list[float],
        chains: list[tuple[int, int, float]],
        ends: list[tuple[int, int, float]],
        choices: list[tuple[tuple[int, int, float], ...]],
        rest: float,
    ) -> float:
        best = self.most
        stack: list[tuple[list[float], list[tuple[int, int, float]]]] = [(first, chains)]
        while stack:
            begin, order = stack.pop()
            self.work -= 1
            if self.work < 0:
                raise TooMuchWorkError
            times = self._least(begin, order, ends, rest, best)
            if times is None:
                continue
            for choice in choices:
                if not any(self._holds(times, *side) for side in choice):
                    # from a rest for ever nothing can follow; before the start nothing can be
                    stack += [(times, [*order, side]) for side in choice if side[0] != -1 and side[1] != -1]
                    break
            else:
                best = self._total(times, ends, rest)
        return best if best < self.most else math.inf

    @staticmethod
    def _holds(times: list[float], a: int, b: int, c: float) -> bool:
        return a != -1 and b != -1 and times[b] >= times[a] + c - 1e-10

    def _total(self, times: list[float], ends: list[tuple[int, int, float]], rest: float) -> float:
        arrivals = [(times[k] + tau if k >= 0 else 0.0, i) for i, k, tau in ends]
        if self.makespan:
            return max([rest, *(t for t, _ in arrivals)])
        return rest + sum(max(0.0, t - float(self.problem.start_times[i])) for t, i in arrivals)

    def _least(
        self,
        begin: list[float],
        order: list[tuple[int, int, float]],
        ends: list[tuple[int, int, float]],
        rest: float,
        best: float,
    ) -> list[float] | None:
        times = list(begin)
        changed = True
        while changed:
            changed = False
            for a, b, c in order:
                if times[a] + c > times[b] + 1e-11:
                    times[b] = times[a] + c
                    changed = True
            if self._total(times, ends, rest) >= best:
                return None  # also ends circles of orders that contradict each other
        return times


def cheaper_plan_exists(
    problem: RoadmapProblem, cost: float, objective: Objective = "sum_of_costs", work: int = 100_000
) -> bool:
    """Whether any plan costs less by more than 1e-6, found with at most so many choices of times."""
    n, robots = len(problem.positions), len(problem.starts)
    left = np.full((robots, n), np.inf)
    for i, goal in enumerate(problem.goals.tolist()):
        left[i, goal] = 0.0
        for _ in range(n):
            for (u, v), tau in seconds_along(problem, i).items():
                if may_use(problem, i, u) and may_use(problem, i, v):
                    left[i, u] = min(left[i, u], tau + left[i, v])
    makespan = objective == "makespan"
    least = [float(left[i, s]) for i, s in enumerate(problem.starts.tolist())]
    begins = problem.start_times.tolist()
    timing = Timing(problem, cost - 1e-6, makespan, work)

    def added(chosen: tuple[Walk, ...], spent: float) -> bool:
        i = len(chosen)
        if i == robots:
            return True
        later = (
            max([0.0, *(least[j] and least[j] + begins[j] for j in range(i + 1, robots))])
            if makespan
            else sum(least[i + 1 :])
        )
        most = cost - begins[i] if makespan else cost - spent - later
        for _, walk in walks(problem, i, most - 1e-6, left[i]):
            now = timing.cost((*chosen, walk), later)
            if now < math.inf and added((*chosen, walk), now - later):
                return True
        return False

    return added((), 0.0)


# --- Tiny teams -------------------------------------------------------------------------------------------------------

PLACES = [(0.0, 0.0), (1.1, 0.2), (2.3, -0.1), (0.1, 1.3), (1.2, 1.0), (2.2, 1.2), (-0.2, 2.2), (0.9, 2.1), (2.1, 2.4)]
NEAR = [(i, j) for i, j in combinations(range(9), 2) if math.dist(PLACES[i], PLACES[j]) < 1.75]


def tiny(seed: int) -> RoadmapProblem | None:
    """Draw 2 to 4 robots on 4 to 7 vertices, of one or two speeds and sizes; None if ends are too near each other."""
    rng = np.random.default_rng(seed)
    robots = int(rng.choice([2, 2, 3, 3, 4]))
    kept = sorted(rng.choice(9, int(rng.integers(max(4, robots + 1), 8)), replace=False).tolist())
    edges = [(kept.index(i), kept.index(j)) for i, j in NEAR if i in kept and j in kept and rng.random() < 0.85]
    radii = rng.choice([0.2, 0.35], robots)
    starts = rng.choice(len(kept), robots, replace=False)
    goals = rng.choice(len(kept), robots, replace=False)
    points = [PLACES[k] for k in kept]
    for i, j in combinations(range(robots), 2):
        for ends in (starts, goals):
            if math.dist(points[ends[i]], points[ends[j]]) < radii[i] + radii[j]:
                return None
    speeds = rng.choice([1.0, 0.5], robots) if rng.random() < 0.4 else np.ones(robots)
    times = rng.choice([0.0, 0.75, 2.0], robots) if rng.random() < 0.3 else np.zeros(robots)
    return RoadmapProblem.from_edges(points, edges, starts, goals, radii=radii, speeds=speeds, start_times=times)


def solved(seeds: range, objective: Objective = "sum_of_costs") -> list[tuple[RoadmapProblem, OptimalPlan]]:
    out = []
    for seed in seeds:
        problem = tiny(seed)
        if problem is None:
            continue
        plan = optimal_plan(problem, objective, nodes=400)
        if plan.motions is not None:
            assert plan.proven or plan.expanded >= 400
        if plan.proven and plan.motions is not None:
            out.append((problem, plan))
    return out


def is_least(problem: RoadmapProblem, plan: OptimalPlan, objective: Objective = "sum_of_costs") -> bool:
    """Whether the oracle has ended; then it must have found nothing cheaper."""
    try:
        assert not cheaper_plan_exists(problem, plan.cost, objective, work=3000)
    except TooMuchWorkError:
        return False
    return True


def test_no_plan_of_a_tiny_team_is_cheaper() -> None:
    teams = solved(range(520))
    proven = delayed = 0
    for problem, plan in teams:
        check(problem, plan)
        assert plan.cost == pytest.approx(plan.lower_bound, abs=1e-9)
        done = is_least(problem, plan)
        proven += done
        delayed += done and plan.expanded > 0
    assert proven >= 300
    assert delayed >= 100  # else they would hardly meet


def test_no_plan_of_a_tiny_team_is_over_sooner() -> None:
    teams = solved(range(1000, 1120), "makespan")
    for problem, plan in teams:
        check(problem, plan, "makespan")
    assert sum(is_least(problem, plan, "makespan") for problem, plan in teams) >= 50


def varied(seed: int) -> RoadmapProblem | None:
    """A tiny team with one-way and slow edges, vertices of one robot alone, robots that leave or need not move."""
    rng = np.random.default_rng(seed)
    tried = tiny(seed)
    if tried is None:
        return None
    n, robots = len(tried.positions), len(tried.starts)
    tails = np.repeat(np.arange(n), np.diff(tried.indptr))
    edges = np.stack([tails, tried.indices], axis=1)
    edges = edges[rng.random(len(edges)) < 0.85]
    limits = rng.choice([math.inf, 0.7, 0.3], len(edges), p=[0.6, 0.2, 0.2])
    owners, positions = np.full(n, -1), [tuple(p) for p in tried.positions.tolist()]
    starts, goals = tried.starts.copy(), tried.goals.copy()
    gone = rng.random(robots) < 0.4
    for i in range(robots):
        if rng.random() < 0.25:
            goals[i] = starts[i]
        if gone[i]:
            into = edges[:, 1] == goals[i]
            edges = np.concatenate([edges, np.stack([edges[into, 0], np.full(into.sum(), len(positions))], axis=1)])
            limits = np.concatenate([limits, limits[into]])
            positions.append(tuple(tried.positions[goals[i]].tolist()))
            starts[i] = len(positions) - 1 if starts[i] == goals[i] else starts[i]
            goals[i] = len(positions) - 1
            owners = np.append(owners, i)
    free = np.setdiff1d(np.arange(n), np.concatenate([starts, goals]))
    if len(free) and rng.random() < 0.3:
        owners[rng.choice(free)] = rng.integers(robots)
    order = np.lexsort((edges[:, 1], edges[:, 0]))
    edges, limits = edges[order], limits[order]
    points = np.array(positions)
    try:
        return replace(
            tried,
            positions=points,
            indptr=np.searchsorted(edges[:, 0], np.arange(len(points) + 1)),
            indices=edges[:, 1].copy(),
            lengths=np.hypot(*(points[edges[:, 0]] - points[edges[:, 1]]).T),
            starts=starts,
            goals=goals,
            limits=limits,
            owners=owners,
            leaves=gone,
        )
    except ValueError:  # ends that are too near each other now
        return None


@pytest.mark.parametrize("objective", ["sum_of_costs", "makespan"])
def test_no_plan_on_one_way_slow_or_owned_edges_or_with_leavers_is_cheaper(objective: Objective) -> None:
    proven = delayed = 0
    for seed in range(5000, 5220):
        problem = varied(seed)
        if problem is None:
            continue
        bounds = [optimal_plan(problem, objective, nodes=nodes).lower_bound for nodes in (0, 1, 3)]
        plan = optimal_plan(problem, objective, nodes=400)
        if plan.motions is None or not plan.proven:
            continue
        check(problem, plan, objective)
        assert max(bounds) <= plan.cost + 1e-9
        done = is_least(problem, plan, objective)
        proven += done
        delayed += done and plan.expanded > 0
    assert proven >= 80
    assert delayed >= 15


def test_the_oracle_finds_cheaper_plans() -> None:
    for problem, plan in solved(range(40)):
        assert cheaper_plan_exists(problem, plan.cost + 0.1)
        assert not cheaper_plan_exists(problem, plan.cost - 0.1)


# --- Published examples -----------------------------------------------------------------------------------------------

RADIUS = math.sqrt(2) / 4


def sidestep() -> RoadmapProblem:
    """Combrink, Roselli and Fabian, arXiv 2508.16410: the second robot rests at its goal and has to make room."""
    points = [(0, 1), (1, 1), (2, 1), (3, 1), (0.5, 0), (2, 0), (3, 0)]
    edges = [(0, 1), (1, 2), (2, 3), (2, 5), (4, 5), (5, 6)]
    return RoadmapProblem.from_edges(points, edges, [4, 5, 1, 0], [6, 5, 3, 1], radii=RADIUS)


def test_waits_that_unsound_branching_removes_are_found() -> None:
    plan = optimal_plan(sidestep())
    check(sidestep(), plan)
    assert plan.proven
    assert plan.cost == pytest.approx(9.0, abs=1e-6)  # with branching on whole waits: 10.707


def test_a_robot_that_is_passed_while_it_waits_is_served_at_the_optimum() -> None:
    """Li, Chen and Harabor, arXiv 2501.07744: constraints on waits would have to be shifted without end."""
    points = [(1, 3), (4, 3), (2.5, 10), (4, 10), (3.7, 9), (2.8, 1.5)]
    edges = [(1, 2), (1, 3), (0, 1), (4, 5)]
    problem = RoadmapProblem.from_edges(points, edges, [0, 1, 4], [3, 1, 5], radii=RADIUS)
    plan = optimal_plan(problem, nodes=5000)
    check(problem, plan)
    assert plan.proven
    assert not cheaper_plan_exists(problem, plan.cost)


# --- Pairs of rules ---------------------------------------------------------------------------------------------------


def motion_on(problem: RoadmapProblem, rng: np.random.Generator) -> tuple[list[int], list[float]]:
    """Edges of a random walk and how long to rest before each."""
    u = int(rng.integers(len(problem.positions)))
    edges: list[int] = []
    for _ in range(int(rng.integers(0, 4))):
        out = range(problem.indptr[u], problem.indptr[u + 1])
        if not len(out):
            break
        edges.append(int(rng.choice(out)))
        u = int(problem.indices[edges[-1]])
    if not edges:
        edges = [-1 - u]
    return edges, rng.choice([0.0, 0.0, 0.3, 1.0, 2.5], len(edges)).tolist()


def rows_of(
    problem: RoadmapProblem, i: int, edges: list[int], rests: list[float]
) -> tuple[list[list[int]], list[list[float]]]:
    """Steps of that motion; at its last vertex it stays."""
    if edges[0] < 0:
        return [[-1 - edges[0], -1]], [[0.0, math.inf]]
    where, when, now = [], [], 0.0
    tails = np.repeat(np.arange(len(problem.positions)), np.diff(problem.indptr))
    for e, rest in zip(edges, rests, strict=True):
        where.append([int(tails[e]), e])
        when.append([now, now + rest])
        now += rest + float(problem.lengths[e] / problem.speeds[i])
    return [*where, [int(problem.indices[edges[-1]]), -1]], [*when, [now, math.inf]]


def keeps(problem: RoadmapProblem, i: int, where: list[list[int]], when: list[list[float]], rule: list[float]) -> bool:
    """Whether a motion of robot i keeps a rule (kind, place, since, until)."""
    kind, place, since, until = int(rule[0]), int(rule[1]), rule[2], rule[3]
    if kind == NOT_ALONG:
        return not any(e == place and since <= t < until for (_, e), (_, t) in zip(where, when, strict=True))
    if kind == NOT_AT:
        return not any(v == place and a < until and d >= since for (v, _), (a, d) in zip(where, when, strict=True))
    if kind == NOT_THROUGHOUT:
        return not any(v == place and a < since and d >= until for (v, _), (a, d) in zip(where, when, strict=True))
    return when[-1][0] >= since  # NOT_BEFORE


def intrudes(
    problem: RoadmapProblem,
    place: Point,
    apart: float,
    since: float,
    i: int,
    where: list[list[int]],
    when: list[list[float]],
) -> bool:
    """Whether robot i is near a place at or up to a time ≥ since."""
    points = [tuple(p) for p in problem.positions.tolist()]
    for (v, e), (_, d) in zip(where, when, strict=True):
        if d >= since and math.dist(points[v], place) < apart:
            return True
        if e >= 0:
            near = passage(
                points[v], points[problem.indices[e]], float(problem.lengths[e] / problem.speeds[i]), place, apart
            )
            if near and d + near[1] >= since:
                return True
    return False


@settings(deadline=None, max_examples=60)
@given(st.integers(0, 10**6))
def test_motions_without_conflict_keep_one_rule_of_every_pair(seed: int) -> None:
    problem = tiny(seed)
    if problem is None:
        return
    rng = np.random.default_rng(seed)
    ground, team, slack = prepared(problem)
    who, when = np.empty((1, 6), dtype=np.int64), np.empty((1, 5))

    def meet(first: tuple[list[int], list[float]], second: tuple[list[int], list[float]]) -> bool:
        rows = [rows_of(problem, i, *motion) for i, motion in enumerate((first, second))]
        steps = Steps(np.array(rows[0][0] + rows[1][0]), np.array(rows[0][1] + rows[1][1]))
        a, b = len(rows[0][0]), len(rows[1][0])
        return first_meeting(ground, team, slack, steps, 0, 0, a, 1, a, b, who, when, 0)

    for _ in range(40):
        motions = [motion_on(problem, rng), motion_on(problem, rng)]
        pairs = [(who[0].tolist(), when[0].tolist())] if meet(*motions) else []
        for names, times in pairs:
            rules = [[names[2 + 2 * s], names[3 + 2 * s], times[1 + 2 * s], times[2 + 2 * s]] for s in (0, 1)]
            for trial in range(12):
                changed = [
                    (edges, [max(0.0, r + (float(rng.normal(0, 0.5)) if trial else 0.0)) for r in rests])
                    for edges, rests in (motions if trial < 8 else (motion_on(problem, rng), motion_on(problem, rng)))
                ]
                kept = []
                for side in (0, 1):
                    i = names[side]
                    rows = rows_of(problem, i, *changed[i])
                    if rules[side][0] == KEEP_OUT:
                        j = names[1]
                        goal = rows_of(problem, j, *changed[j])
                        # the place is where robot j stays, which stands for its goal
                        place, apart = tuple(problem.positions[goal[0][-1][0]].tolist()), float(team.apart[i, j])
                        same = goal[0][-1][0] == names[5]
                        # two ways of reckoning passages agree up to a rounding, which matters to the motion at hand
                        since = rules[0][2] - (1e-9 if trial == 0 else 0.0)
                        kept.append(not same or not intrudes(problem, place, apart, since, i, *rows))
                    else:
                        kept.append(keeps(problem, i, *rows, rules[side]))
                if trial == 0:
                    assert kept == [False, False]  # each rule forbids the motion at hand
                elif not any(kept):
                    assert meet(*changed)


# --- Bounds and limits ------------------------------------------------------------------------------------------------


def crowded(robots: int = 8) -> RoadmapProblem:
    """Robots that change sides on a 4 × 4 grid."""
    points = [(x, y) for y in range(4) for x in range(4)]
    edges = [(i, j) for i, j in combinations(range(16), 2) if math.dist(points[i], points[j]) == 1.0]
    starts = [0, 15, 3, 12, 5, 10, 6, 9][:robots]
    goals = [15, 0, 12, 3, 10, 5, 9, 6][:robots]
    return RoadmapProblem.from_edges(points, edges, starts, goals, radii=0.3)


def jammed() -> RoadmapProblem:
    """Two pairs of robots that swap ends of a corridor with one bay."""
    points = [*((float(x), 0.0) for x in range(8)), (4.0, 1.0)]
    edges = [*((i, i + 1) for i in range(7)), (4, 8)]
    return RoadmapProblem.from_edges(points, edges, [0, 1, 7, 6], [6, 7, 1, 0], radii=0.3)


def test_the_bound_only_rises_and_never_passes_the_optimum() -> None:
    problem = crowded(4)
    optimum = optimal_plan(problem).cost
    bounds: list[float] = []
    plan = optimal_plan(problem, progress=lambda expanded, bound, cost: bounds.append(bound))
    assert bounds == sorted(bounds)
    assert max(bounds) <= plan.cost == optimum
    for nodes in (0, 1, 3, 10):
        cut = optimal_plan(problem, nodes=nodes)
        assert cut.expanded <= nodes
        assert cut.lower_bound <= optimum * (1 + 1e-12)


def test_the_same_number_of_nodes_gives_the_same_result() -> None:
    first, second = (optimal_plan(crowded(), nodes=150) for _ in range(2))
    assert (first.cost, first.lower_bound, first.expanded) == (second.cost, second.lower_bound, second.expanded)
    assert (first.motions is None) == (second.motions is None)
    for a, b in zip(first.motions or (), second.motions or (), strict=True):
        for x, y in zip(a, b, strict=True):
            np.testing.assert_array_equal(x, y)


@pytest.mark.parametrize("within", [1.0, 1.05, 1.5])
def test_a_plan_within_a_factor_costs_no_more_than_that(within: float) -> None:
    problem = crowded(5)
    plan = optimal_plan(problem, within=within, nodes=20000)
    check(problem, plan)
    assert plan.proven
    assert plan.cost <= within * plan.lower_bound * (1 + 1e-12)
    assert plan.lower_bound <= optimal_plan(problem).cost * (1 + 1e-12)


def test_no_seconds_still_prove_a_bound() -> None:
    plan = optimal_plan(jammed(), seconds=0.0)
    assert plan.motions is None
    assert plan.cost == math.inf
    assert plan.lower_bound >= 4 * 6 - 1e-9  # the shortest ways
    assert not plan.proven


def test_an_interrupt_returns_what_is_known() -> None:
    def interrupt(expanded: int, bound: float, cost: float) -> None:
        if expanded > 30:
            raise KeyboardInterrupt

    plan = optimal_plan(jammed(), progress=interrupt)
    assert plan.expanded > 30
    assert 0 < plan.lower_bound < math.inf


def test_a_known_plan_is_beaten_or_proven_to_be_least() -> None:
    problem = crowded(4)
    least = optimal_plan(problem)
    better = optimal_plan(problem, at_most=least.cost + 0.5)
    assert (better.cost, better.proven) == (least.cost, True)
    none = optimal_plan(problem, at_most=least.cost)
    assert none.motions is None
    assert none.proven
    assert none.lower_bound == pytest.approx(least.cost, rel=1e-11)
    assert none.expanded <= least.expanded
    enough = optimal_plan(problem, within=1.5, at_most=1.2 * least.cost)
    assert enough.proven
    assert min(enough.cost, 1.2 * least.cost) <= 1.5 * enough.lower_bound
    with pytest.raises(ValueError, match="at_most"):
        optimal_plan(problem, at_most=math.nan)


def test_the_bound_of_a_robot_that_has_to_make_room_does_not_count_its_start_time() -> None:
    points = [(0.0, 0.0), (1.0, 0.0), (2.0, 0.0), (1.0, 1.0)]
    problem = RoadmapProblem.from_edges(points, [(0, 1), (1, 2), (1, 3)], [0, 1], [2, 1], radii=0.3, start_times=[0, 9])
    plan = optimal_plan(problem)
    check(problem, plan)
    assert not cheaper_plan_exists(problem, plan.cost)
    for nodes in range(8):
        assert optimal_plan(problem, nodes=nodes).lower_bound <= plan.cost * (1 + 1e-12)


def test_of_two_edges_between_the_same_vertices_the_better_one_counts() -> None:
    problem = replace(
        line(2, [0], [1]),
        indptr=np.array([0, 2, 2]),
        indices=np.array([1, 1]),
        lengths=np.array([1.0, 1.5]),
        limits=np.array([0.5, 1.0]),
    )
    assert optimal_plan(problem).cost == pytest.approx(1.5)


# --- Cases ------------------------------------------------------------------------------------------------------------


def line(
    n: int, starts: Sequence[int], goals: Sequence[int], speeds: float = 1.0, start_times: float = 0.0
) -> RoadmapProblem:
    points, edges = [(float(x), 0.0) for x in range(n)], [(i, i + 1) for i in range(n - 1)]
    return RoadmapProblem.from_edges(points, edges, starts, goals, radii=0.3, speeds=speeds, start_times=start_times)


def test_one_robot_takes_its_shortest_way_after_its_start_time() -> None:
    plan = optimal_plan(line(4, [0], [3], start_times=2.0, speeds=0.5))
    assert plan.cost == plan.lower_bound == pytest.approx(6.0)
    assert plan.motions is not None
    assert plan.motions[0].vertices.tolist() == [0, 1, 2, 3]
    assert plan.motions[0].depart.tolist() == [2.0, 4.0, 6.0, math.inf]


def test_nobody_and_robots_at_their_goals_cost_nothing() -> None:
    assert optimal_plan(line(3, [], [])).cost == 0.0
    plan = optimal_plan(line(3, [0, 2], [0, 2]))
    assert plan.proven
    assert plan.cost == 0.0
    assert plan.motions is not None
    assert [m.vertices.tolist() for m in plan.motions] == [[0], [2]]


def test_a_goal_without_a_way_has_no_plan() -> None:
    points = [(0.0, 0.0), (1.0, 0.0), (5.0, 0.0), (6.0, 0.0)]
    plan = optimal_plan(RoadmapProblem.from_edges(points, [(0, 1), (2, 3)], [0], [3], radii=0.1))
    assert plan.motions is None
    assert plan.proven
    assert plan.lower_bound == math.inf


def test_one_way_edges_are_driven_one_way() -> None:
    points = [(0.0, 0.0), (2.0, 0.0), (1.0, 1.0)]
    ring = RoadmapProblem.from_edges(points, [(0, 1), (1, 2), (2, 0)], [1], [0], radii=0.1, directed=True)
    assert optimal_plan(ring).cost == pytest.approx(2 * math.sqrt(2))


def test_edges_of_no_length_and_vertices_at_one_place_are_no_trouble() -> None:
    points = [(0.0, 0.0), (1.0, 0.0), (1.0, 0.0), (2.0, 0.0), (1.0, 1.0)]
    edges = [(0, 1), (1, 2), (2, 3), (1, 4)]
    problem = RoadmapProblem.from_edges(points, edges, [0, 3], [3, 0], radii=0.3)
    plan = optimal_plan(problem)
    check(problem, plan)
    assert plan.proven
    assert not cheaper_plan_exists(problem, plan.cost)


@pytest.mark.parametrize("scale", [1e-6, 1e6])
def test_scale_only_scales_the_cost(scale: float) -> None:
    problem = crowded(4)
    scaled = replace(
        problem,
        positions=problem.positions * scale,
        lengths=problem.lengths * scale,
        radii=problem.radii * scale,
        tol=problem.tol * scale,
    )
    plan = optimal_plan(scaled)
    check(scaled, plan)
    assert plan.cost == pytest.approx(scale * optimal_plan(problem).cost, rel=1e-9)


@settings(deadline=None, max_examples=25)
@given(st.integers(0, 10**6), st.randoms(use_true_random=False))
def test_names_of_robots_and_vertices_do_not_matter(seed: int, random: object) -> None:
    problem = tiny(seed)
    if problem is None:
        return
    plan = optimal_plan(problem, nodes=300)
    if not plan.proven:
        return
    rng = np.random.default_rng(seed)
    n, robots = len(problem.positions), len(problem.starts)
    name, order = rng.permutation(n), rng.permutation(robots)
    edges = [(name[u], name[v]) for u in range(n) for v in problem.indices[problem.indptr[u] : problem.indptr[u + 1]]]
    positions = np.empty((n, 2))
    positions[name] = problem.positions
    renamed = RoadmapProblem.from_edges(
        positions, edges, name[problem.starts[order]], name[problem.goals[order]],
        radii=problem.radii[order], speeds=problem.speeds[order], start_times=problem.start_times[order], directed=True,
    )  # fmt: skip
    again = optimal_plan(renamed, nodes=5000)
    if again.proven:
        assert again.cost == pytest.approx(plan.cost, abs=1e-8)


@pytest.mark.parametrize(
    ("change", "says"),
    [
        ({"starts": np.array([0, 9])}, "outside"),
        ({"radii": np.array([0.3, -1.0])}, "radii"),
        ({"speeds": np.array([1.0, 0.0])}, "speeds"),
        ({"start_times": np.array([0.0, -1.0])}, "start times"),
        ({"start_times": np.array([0.0, 1e300])}, "start times"),
        ({"goals": np.array([1, 1])}, "goals of robots 0 and 1"),
        ({"starts": np.array([2, 2])}, "starts of robots 0 and 1"),
        ({"radii": np.array([0.3])}, "radii"),
        ({"gap": math.nan}, "gap"),
        ({"positions": np.array([[0.0, 0.0]])}, "indptr"),
        ({"radii": np.array([0.0, 0.0])}, "gap"),
    ],
)
def test_what_cannot_be_planned_is_refused_with_a_reason(change: dict[str, object], says: str) -> None:
    with pytest.raises((ValueError, IndexError), match=says):
        replace(line(3, [0, 2], [2, 0]), **change)  # type: ignore[arg-type]


@pytest.mark.parametrize("within", [0.99, math.nan, math.inf])
def test_a_factor_below_one_is_refused(within: float) -> None:
    with pytest.raises(ValueError, match="within"):
        optimal_plan(line(2, [0], [1]), within=within)


def test_an_unknown_objective_is_refused() -> None:
    with pytest.raises(ValueError, match="objective"):
        optimal_plan(line(2, [0], [1]), "length")  # type: ignore[arg-type]
