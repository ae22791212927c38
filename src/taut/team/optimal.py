"""Optimal plans on a roadmap: conflict-based search in continuous time, with a lower bound proven at any moment."""

from __future__ import annotations

import math
import time
from collections.abc import Callable
from dataclasses import dataclass
from typing import Literal, NamedTuple, TypeAlias

import numpy as np
from numpy.typing import ArrayLike, NDArray
from scipy.sparse import csr_array
from scipy.sparse.csgraph import dijkstra

from taut.graph.core import vertex_pairs
from taut.team import _optimal_kernels as kernels
from taut.team import _tree_kernels as pools
from taut.team._optimal_pools import grown, planted
from taut.team._rule_kernels import Floats, Ground, Ints, Team
from taut.team._tree_kernels import Search

Objective: TypeAlias = Literal["sum_of_costs", "makespan"]
Progress: TypeAlias = Callable[[int, float, float], None]

_VISITS = 32  # of nodes, between two looks at the clock
_LESS = 1.0 - 1e-12  # what costs more than this share of a known cost is no cheaper: costs are sums, rounded


@dataclass(frozen=True, eq=False)
class RoadmapProblem:
    """Robots on a roadmap: they move along its edges at top speed or rest at its vertices.

    Parameters
    ----------
    positions : (n, 2) metres.
    indptr, indices, lengths : the directed edges as CSR; lengths in metres, no shorter than the straight line. An edge
        longer than that is driven straight, evenly, and in the time that its length takes.
    starts, goals : (k,) vertices.
    radii, speeds, start_times : (k,) metres, metres a second, and seconds before which a robot may not leave.
    gap : metres kept free between robots.
    tol : metres; the robots' distances are at least r_i + r_j + gap − tol, and every plan that keeps to
        r_i + r_j + gap is admitted.
    limits : (m,) metres a second on each edge at most, inf where there is no limit; None: nowhere.
    owners : (n,) the robot that alone may use each vertex, −1 where anybody may; None: everywhere.
    leaves : (k,) whether a robot is gone from the instant of its arrival, present in [0, arrival), else it stays at its
        goal; None: all stay. No edges lead on from where robots leave.

    Raises
    ------
    IndexError
        A vertex is out of range.
    ValueError
        Arrays that do not fit together, values that are not finite or have the wrong sign, an edge shorter than the
        straight line, start times so late that they drown tol, two starts or two goals too near each other, an end
        that another robot owns, edges on from where a robot leaves, or point robots without a gap.
    """

    positions: Floats
    indptr: Ints
    indices: Ints
    lengths: Floats
    starts: Ints
    goals: Ints
    radii: Floats
    speeds: Floats
    start_times: Floats
    gap: float
    tol: float
    limits: Floats | None = None
    owners: Ints | None = None
    leaves: NDArray[np.bool_] | None = None

    def __post_init__(self) -> None:
        _check_roadmap(self)
        _check_robots(self)
        _check_choices(self)
        _check_ends(self)

    @classmethod
    def from_edges(
        cls,
        positions: ArrayLike,
        edges: ArrayLike,
        starts: ArrayLike,
        goals: ArrayLike,
        *,
        radii: ArrayLike,
        speeds: ArrayLike = 1.0,
        start_times: ArrayLike = 0.0,
        gap: float = 0.0,
        directed: bool = False,
    ) -> RoadmapProblem:
        """Build from (m, 2) pairs of vertices, each driven both ways unless directed, with straight lengths.

        Radii, speeds and start times may be one number for all robots. The tolerance is that of a scene in which
        nothing is farther out than the vertices.

        >>> cross = [(0, 1), (2, 0), (0, -1), (-2, 0), (0, 0)]
        >>> team = RoadmapProblem.from_edges(cross, [(4, k) for k in range(4)], [0, 1], [2, 3], radii=0.5)
        >>> round(optimal_plan(team).cost, 6)  # on their own they take 2 s and 4 s; the first goes before the other
        6.414214
        """
        points = np.array(positions, dtype=np.float64).reshape(-1, 2)
        pairs = vertex_pairs(edges, "edges")
        if pairs.size and (pairs.min() < 0 or pairs.max() >= len(points)):
            raise IndexError(f"edges name vertices outside 0 … {len(points) - 1}")
        if not directed:
            pairs = np.concatenate([pairs, pairs[:, ::-1]])
        pairs = np.unique(pairs, axis=0)
        degrees = np.bincount(pairs[:, 0], minlength=len(points))
        first, last = (np.array(given, dtype=np.int64).reshape(-1) for given in (starts, goals))
        radius, speed, begin = (
            np.array(np.broadcast_to(given, first.shape), dtype=np.float64) for given in (radii, speeds, start_times)
        )
        return cls(
            points,
            np.concatenate([[0], np.cumsum(degrees)]).astype(np.int64),
            np.ascontiguousarray(pairs[:, 1]),
            np.hypot(*(points[pairs[:, 0]] - points[pairs[:, 1]]).T),
            first,
            last,
            radius,
            speed,
            begin,
            float(gap),
            2.0**-40 * float(np.abs(points).max(initial=0.0)),
        )


class Motion(NamedTuple):
    """A robot is at vertices[k] from arrive[k] to depart[k], (s,) each; the last departure is inf even if it leaves."""

    vertices: Ints
    arrive: Floats
    depart: Floats


@dataclass(frozen=True, eq=False)
class OptimalPlan:
    """What the search knows when it ends.

    Parameters
    ----------
    motions : one for each robot; None if no plan was found, or none cheaper than the one known before.
    cost : seconds, of the objective asked for; inf without motions.
    lower_bound : no plan on this roadmap, at top speed or at rest on its vertices, costs less. inf: there is none.
    expanded : nodes of the search tree that were expanded.
    proven : whether the cost, or without motions that of the plan known before, is at most ``within`` times the bound,
        or it is proven that there is no plan.
    """

    motions: tuple[Motion, ...] | None
    cost: float
    lower_bound: float
    expanded: int
    proven: bool


def optimal_plan(
    problem: RoadmapProblem,
    objective: Objective = "sum_of_costs",
    within: float = 1.0,
    seconds: float | None = None,
    nodes: int | None = None,
    at_most: float = math.inf,
    progress: Progress | None = None,
) -> OptimalPlan:
    """Plan motions of least cost, or cost within a factor of the least, and prove it.

    Parameters
    ----------
    problem : roadmap and robots.
    objective : sum over the robots of arrival − start time (0 for a robot that never moves), or the last arrival.
    within : the plan may cost up to so many times the bound; 1 asks for an optimum.
    seconds, nodes : limits; the search ends soon after the seconds, exactly at the nodes. With neither it goes on until
        it has a proof; it need not end for teams that have no plan at all.
    at_most : cost of a plan on this roadmap that is known already: only cheaper ones are looked for.
    progress : called now and then with the nodes expanded, the bound and the cost of the best plan yet (inf: none).
        If it, or Ctrl-C, raises KeyboardInterrupt, the search returns what it knows.

    Returns
    -------
    OptimalPlan
        The same input and nodes give the same result, bit for bit.

    Raises
    ------
    ValueError
        An unknown objective, a factor below 1 or not finite, a known cost that is negative or nan, or ways so long that
        their seconds drown tol.

    Notes
    -----
    Conflict-based search: a node of the tree gives every robot its own earliest motion under the node's rules. A
    meeting of two motions is resolved by a pair of rules such that any two motions without conflict keep one of them
    (proofs in `taut.team._meeting_kernels`), one child for each. So every plan is below some open node, whose robots'
    earliest arrivals it cannot beat: the least bound of the open nodes is a lower bound at any moment. The pair is
    split disjointly where possible: in one child a robot keeps its rule, in the other it *must* break it (a landmark),
    which is sound since rule-breakers are then all there, and spares the tree plans that keep both.

    A node's bound is the least sum of delays that meets all its meetings, since in each at least one of two robots is
    delayed by a known time. Among nodes within the factor of the least bound, those with the fewest meetings come
    first.

    Sources: Andreychuk, Yakovlev, Surynek, Atzmon and Stern, Multi-agent pathfinding with continuous time, AIJ 2022;
    Andreychuk et al., Improving continuous-time conflict based search, AAAI 2021 (disjoint splitting, prioritized
    conflicts, heuristics); Li et al., Pairwise symmetry reasoning, AIJ 2021 (splitting over arrivals at goals);
    Barer et al., Suboptimal variants of conflict-based search, SoCS 2014. The rules are others: those of the first lose
    plans (Combrink, Roselli and Fabian, arXiv 2508.16410; Li, Chen and Harabor, arXiv 2501.07744).
    """
    if objective not in ("sum_of_costs", "makespan"):
        raise ValueError(f"objective is 'sum_of_costs' or 'makespan', not {objective!r}")
    if not 1.0 <= within < math.inf:
        raise ValueError(f"within is a factor of at least 1, not {within!r}")
    if not at_most >= 0.0:
        raise ValueError(f"at_most is the cost of a plan, at least 0, not {at_most!r}")
    search = planted(*prepared(problem), objective == "makespan")
    begun = time.perf_counter()
    status = kernels.plant(search)
    while status == kernels.ROOM:
        search = grown(search)
        status = kernels.plant(search)
    if status == kernels.EXHAUSTED:
        return OptimalPlan(None, math.inf, math.inf, 0, True)
    bound = float(search.tree.value[0, 1])
    try:
        while status in (kernels.MORE, kernels.ROOM):
            visits = _VISITS if nodes is None else min(_VISITS, nodes - int(search.size[pools.EXPANDED]))
            if visits <= 0:
                break
            status, least = kernels.search(search, within, at_most * _LESS, visits)
            bound = max(bound, least)
            if status == kernels.ROOM:
                search = grown(search)
            if progress is not None:
                progress(int(search.size[pools.EXPANDED]), bound, _best_cost(search))
            if seconds is not None and time.perf_counter() - begun >= seconds:
                break
    except KeyboardInterrupt:
        pass
    expanded, cost = int(search.size[pools.EXPANDED]), _best_cost(search)
    proven = status in (kernels.SOLVED, kernels.EXHAUSTED)
    if cost >= at_most * _LESS:
        return OptimalPlan(None, math.inf, min(bound, at_most), expanded, proven)
    return OptimalPlan(_motions(search), cost, min(bound, cost), expanded, proven)


def prepared(problem: RoadmapProblem) -> tuple[Ground, Team, float]:
    """Return a problem as the kernels want it, and by how many seconds motions may overlap.

    Raises
    ------
    ValueError
        Ways so long that their seconds drown tol.
    """
    n, robots = len(problem.positions), len(problem.starts)
    tails = np.repeat(np.arange(n, dtype=np.int64), np.diff(problem.indptr))
    limits = np.full(len(tails), np.inf) if problem.limits is None else problem.limits
    leaves = np.zeros(robots, dtype=np.int64) if problem.leaves is None else problem.leaves.astype(np.int64)
    ground = Ground(problem.positions, problem.indptr, problem.indices, tails, problem.lengths, limits)
    apart = problem.radii[:, None] + problem.radii[None, :] + problem.gap - problem.tol / 2
    remaining = _remaining(problem, tails, limits)
    alone = problem.start_times + remaining[np.arange(robots), problem.starts]
    latest = float(alone[np.isfinite(alone)].max(initial=0.0))
    if math.ulp(latest) > _slack(problem) and latest > 0.0:
        raise ValueError(f"ways of up to {latest:g} s are too long for a tolerance of {problem.tol:g} m")
    team = Team(problem.starts, problem.goals, problem.speeds, problem.start_times, apart, remaining, leaves)
    return ground, team, _slack(problem)


def _remaining(problem: RoadmapProblem, tails: Ints, limits: Floats) -> Floats:
    """Least seconds from each vertex to each robot's goal, (k, n); inf where it cannot or may not go."""
    n, robots = len(problem.positions), len(problem.goals)
    owners = np.full(n, -1) if problem.owners is None else problem.owners
    remaining = np.empty((robots, n))
    order = np.lexsort((tails, problem.indices))
    heads = np.searchsorted(problem.indices[order], np.arange(n + 1))
    for i in range(robots):
        barred = (owners >= 0) & (owners != i)
        # no edge of no duration for SciPy, to which that is no edge
        seconds = np.maximum(problem.lengths / np.minimum(problem.speeds[i], limits), 1e-300)
        seconds[barred[tails] | barred[problem.indices]] = np.inf
        backwards = csr_array((seconds[order], tails[order], heads), shape=(n, n))
        remaining[i] = dijkstra(backwards, indices=problem.goals[i])
    return remaining


def _slack(problem: RoadmapProblem) -> float:
    """Seconds in which two robots come nearer by at most tol / 4; planners aim at tol / 2 less than allowed."""
    return problem.tol / 8 / float(problem.speeds.max(initial=1.0))


def _check_roadmap(problem: RoadmapProblem) -> None:
    n, m = len(problem.positions), len(problem.indices)
    if problem.positions.shape != (n, 2) or not np.isfinite(problem.positions).all():
        raise ValueError("positions must be finite, (n, 2)")
    ascending = bool((np.diff(problem.indptr) >= 0).all())
    if problem.indptr.shape != (n + 1,) or problem.indptr[0] != 0 or problem.indptr[-1] != m or not ascending:
        raise ValueError(f"indptr must rise from 0 to the number of edges, {m}, in {n + 1} entries")
    if m and (problem.indices.min() < 0 or problem.indices.max() >= n):
        raise IndexError(f"edges name vertices outside 0 … {n - 1}")
    if problem.lengths.shape != (m,) or not np.isfinite(problem.lengths).all():
        raise ValueError(f"lengths must be finite, one for each of {m} edges")
    tails = np.repeat(np.arange(n), np.diff(problem.indptr))
    straight = np.hypot(*(problem.positions[tails] - problem.positions[problem.indices]).T)
    short = np.flatnonzero(problem.lengths < straight - problem.tol)
    if short.size:
        u, v = tails[short[0]], problem.indices[short[0]]
        raise ValueError(f"the edge {u} → {v} is {problem.lengths[short[0]]:g} m long, less than the straight line")
    if not (math.isfinite(problem.gap) and problem.gap >= 0 and math.isfinite(problem.tol) and problem.tol >= 0):
        raise ValueError(f"gap and tol must be finite and not negative, not {problem.gap!r} and {problem.tol!r}")


def _check_robots(problem: RoadmapProblem) -> None:
    robots = len(problem.starts)
    for name, ends in (("starts", problem.starts), ("goals", problem.goals)):
        if ends.shape != (robots,):
            raise ValueError(f"{name} must name one vertex for each of {robots} robots")
        if robots and (ends.min() < 0 or ends.max() >= len(problem.positions)):
            raise IndexError(f"{name} name vertices outside 0 … {len(problem.positions) - 1}")
    for name, values, least in (
        ("radii", problem.radii, 0.0),
        ("speeds", problem.speeds, math.nextafter(0.0, 1.0)),
        ("start times", problem.start_times, 0.0),
    ):
        if values.shape != (robots,) or not (np.isfinite(values).all() and (values >= least).all()):
            sign = "positive" if least else "not negative"
            raise ValueError(f"{name} must be finite and {sign}, one for each of {robots} robots")
    latest = float(problem.start_times.max(initial=0.0))
    if math.ulp(latest) > _slack(problem) and latest > 0.0:
        raise ValueError(f"start times up to {latest:g} s are too late for a tolerance of {problem.tol:g} m")
    if robots > 1 and float(np.sort(problem.radii)[:2].sum()) + problem.gap <= problem.tol:
        raise ValueError("point robots need a gap: give one, or radii")


def _check_choices(problem: RoadmapProblem) -> None:
    """Limits, owners and leaves, where they are given."""
    n, m, robots = len(problem.positions), len(problem.indices), len(problem.starts)
    if problem.limits is not None and (problem.limits.shape != (m,) or not (problem.limits > 0).all()):
        raise ValueError(f"limits must be positive, one for each of {m} edges")
    if problem.owners is not None:
        if problem.owners.shape != (n,) or not ((problem.owners >= -1) & (problem.owners < robots)).all():
            raise ValueError(f"owners must name one of {robots} robots, or -1, for each of {n} vertices")
        for name, ends in (("start", problem.starts), ("goal", problem.goals)):
            owner = problem.owners[ends]
            lost = np.flatnonzero((owner >= 0) & (owner != np.arange(robots)))
            if lost.size:
                raise ValueError(f"the {name} of robot {lost[0]} belongs to robot {owner[lost[0]]}")
    if problem.leaves is not None:
        if problem.leaves.shape != (robots,):
            raise ValueError(f"leaves must be told of each of {robots} robots")
        onward = np.flatnonzero(problem.leaves & (np.diff(problem.indptr)[problem.goals] > 0))
        if onward.size:
            raise ValueError(
                f"edges lead on from where robot {onward[0]} leaves: give it a vertex of its own at that place"
            )


def _check_ends(problem: RoadmapProblem) -> None:
    """Two robots can stand at their starts, and at their goals, at the same time."""
    never = np.zeros(len(problem.starts), dtype=bool)
    leaves = never if problem.leaves is None else problem.leaves
    at_once = leaves & (problem.starts == problem.goals)
    for name, ends, gone in (("starts", problem.starts, at_once), ("goals", problem.goals, leaves)):
        places = problem.positions[ends]
        away = np.hypot(*(places[:, None] - places[None, :]).transpose(2, 0, 1))
        needed = problem.radii[:, None] + problem.radii[None, :] + problem.gap
        both = ~(gone[:, None] | gone[None, :])
        near = np.argwhere(np.triu(both & (away < needed - problem.tol / 2), 1))
        if len(near):
            i, j = near[0].tolist()
            raise ValueError(
                f"the {name} of robots {i} and {j} are {away[i, j]:g} m apart, they need {needed[i, j]:g} m"
            )


def _best_cost(search: Search) -> float:
    best = int(search.size[pools.BEST])
    return math.inf if best < 0 else float(search.tree.value[best, 0])


def _motions(search: Search) -> tuple[Motion, ...]:
    steps, tree = search.steps, search.tree
    pools.unroll(tree, int(search.size[pools.BEST]), search.now)
    spans = [slice(first, first + count) for first, count in tree.motion[search.now.motion].tolist()]
    return tuple(Motion(steps.where[k, 0].copy(), steps.when[k, 0].copy(), steps.when[k, 1].copy()) for k in spans)
