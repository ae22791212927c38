"""Searches that record every step, to be told, drawn and checked.

Dijkstra, A*, breadth first and depth first are one loop: visit a vertex of the frontier, look at its neighbours, and
again. They differ in which vertex of the frontier comes next (see `_rank`).
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from heapq import heappop, heappush
from itertools import pairwise
from math import inf, isinf
from typing import Literal, TypeAlias, get_args

import numpy as np
from numpy.typing import ArrayLike

from taut.graph.core import Floats, Graph, Ints
from taut.graph.search import check_vertex, path_to

MANY = 3  # so many rivals of the vertex picked are named
LONG = 12  # up to so many legs are added up in words

Method: TypeAlias = Literal["dijkstra", "astar", "breadth-first", "depth-first"]


@dataclass(frozen=True)
class Step:
    """One step of a search: a vertex is visited, and its neighbours hear of the way through it.

    Parameters
    ----------
    vertex : the vertex visited; its distance is permanent from now on.
    distance : its distance from the source along the tree.
    edge : (vertex before, vertex), the edge by which it was reached; None for the source.
    relaxed : (neighbour, old distance, new distance) for each neighbour that is now reached through ``vertex``; the old
        distance of one seen for the first time is inf. Distances fall, but for "depth-first" they may grow: there the
        way of the latest sight counts.
    """

    vertex: int
    distance: float
    edge: tuple[int, int] | None
    relaxed: tuple[tuple[int, float, float], ...]


@dataclass(frozen=True, eq=False)
class State:
    """Where a search stands between two steps.

    Parameters
    ----------
    visited : vertices in the order visited.
    frontier : (vertex, tentative distance) of those seen but not visited; the first is visited next.
    distances : (n,) permanent or tentative, inf for vertices not seen.
    before : (n,) the vertex before each, −1 for the source and vertices not seen.
    """

    visited: tuple[int, ...]
    frontier: tuple[tuple[int, float], ...]
    distances: Floats
    before: Ints


@dataclass(frozen=True, eq=False)
class Trace:
    """A search, step by step; it needs memory for n vertices and m edges, not for n states.

    Distances are sums of weights for "dijkstra" and "astar", numbers of edges for the other two.

    Parameters
    ----------
    graph, source, target, method : what was searched, from where, where to (None: everywhere) and how.
    estimates : (n,) straight-line distance to the target that "astar" adds; 0 for the others.
    steps : in order; the last visits the target if there is one that can be reached.
    """

    graph: Graph
    source: int
    target: int | None
    method: Method
    estimates: Floats
    steps: tuple[Step, ...]

    @property
    def path(self) -> list[int]:
        """Vertices from source to target; empty without a target or a path."""
        last = self.steps[-1].vertex
        return path_to(self.state(len(self.steps)).before, last) if last == self.target else []

    @property
    def distance(self) -> float:
        """Distance of the target; inf without a target or a path."""
        return self.steps[-1].distance if self.steps[-1].vertex == self.target else inf

    def state(self, k: int) -> State:
        """Where the search stands after its first k steps, from 0 (only the source is seen) to ``len(steps)``.

        Raises
        ------
        IndexError
            The search has no such step.
        """
        if not 0 <= k <= len(self.steps):
            raise IndexError(f"step {k} is not one of 0 … {len(self.steps)}")
        distances = np.full(self.graph.n, inf)
        before = np.full(self.graph.n, -1, dtype=np.int64)
        distances[self.source] = 0.0
        ranks = {self.source: 0.0}
        for number, step in enumerate(self.steps[:k]):
            del ranks[step.vertex]
            for v, _, new in step.relaxed:
                distances[v], before[v] = new, step.vertex
                ranks[v] = _rank(self.method, number, new, float(self.estimates[v]))
        order = sorted(ranks, key=lambda v: (ranks[v], v))
        frontier = tuple((v, float(distances[v])) for v in order)
        return State(tuple(step.vertex for step in self.steps[:k]), frontier, distances, before)


def trace(
    graph: Graph,
    source: int,
    target: int | None = None,
    method: Method = "dijkstra",
    positions: ArrayLike | None = None,
) -> Trace:
    """Search and record each step; ties are served by the smaller vertex.

    The results are those of `dijkstra`, `astar`, `breadth_first` and `depth_first`, bit for bit, only slower.

    Parameters
    ----------
    graph : where to search.
    source : vertex to start from.
    target : vertex at which the search ends when it is visited; None visits all that can be reached.
    method : "dijkstra" visits by distance, "astar" by distance plus straight line to the target, "breadth-first" the
        vertex that has waited longest (fewest edges, whatever the weights), "depth-first" the one last seen.
    positions : (n, 2) for "astar", which needs a target too; no weight may be less than the distance of its ends.

    Raises
    ------
    IndexError
        ``source`` or ``target`` is not a vertex.
    ValueError
        Another method; "astar" without target or positions, or with positions that could mislead it.

    References
    ----------
    Alwafi, *Social Graphs and Their Applications to Robotics*, 8.7 and 8.8.

    >>> trace(Graph.from_edges(3, [(0, 1), (1, 2), (0, 2)], [1.0, 1.0, 3.0]), 0, 2).path
    [0, 1, 2]
    """
    if method not in get_args(Method):
        raise ValueError(f"method {method!r} is not one of {', '.join(get_args(Method))}")
    source = check_vertex(graph, source)
    target = None if target is None else check_vertex(graph, target)
    estimates = _estimates(graph, target, positions) if method == "astar" else np.zeros(graph.n)
    return Trace(graph, source, target, method, estimates, tuple(_search(graph, source, target, method, estimates)))


def tell(trace: Trace, names: Sequence[str] | None = None) -> list[str]:
    """Tell a search in words: one line a step, then the path and its length.

    Parameters
    ----------
    trace : what to tell.
    names : (n,) labels of the vertices; v1, v2, … if None.

    Raises
    ------
    ValueError
        Not one name for each vertex.

    >>> tell(trace(Graph.from_edges(2, [(0, 1)], [7.0]), 0, 1))[0]
    'Step 1: start at v1, distance 0. v2 falls from ∞ to 0 + 7 = 7.'
    """
    labels = [f"v{v + 1}" for v in range(trace.graph.n)] if names is None else list(names)
    if len(labels) != trace.graph.n:
        raise ValueError(f"{len(labels)} names for {trace.graph.n} vertices: give one for each")
    lines = []
    frontier: dict[int, float] = {trace.source: 0.0}
    visited: set[int] = set()
    for number, step in enumerate(trace.steps):
        picked = _picked(trace, number, frontier, labels)
        del frontier[step.vertex]
        visited.add(step.vertex)
        happened = _changes(trace, step, frontier, visited, labels)
        frontier.update((v, new) for v, _, new in step.relaxed)
        lines.append(f"Step {number + 1}: {picked} {happened}")
    return [*lines, _result(trace, labels)]


def _search(graph: Graph, source: int, target: int | None, method: Method, estimates: Floats) -> list[Step]:
    distances, before = [inf] * graph.n, [-1] * graph.n
    visited = [False] * graph.n
    distances[source] = 0.0
    heap = [(0.0, source)]
    steps: list[Step] = []
    while heap:
        _, u = heappop(heap)
        if visited[u]:
            continue
        visited[u] = True
        relaxed = []
        for v, weight in _neighbours(graph, u) if u != target else ():
            new = distances[u] + (weight if _weighs(method) else 1.0)
            # the latest sight counts for depth first, the shortest way for all others
            if not visited[v] and (new < distances[v] or method == "depth-first"):
                relaxed.append((v, distances[v], new))
                distances[v], before[v] = new, u
                heappush(heap, (_rank(method, len(steps), new, float(estimates[v])), v))
        edge = None if u == source else (before[u], u)
        steps.append(Step(u, distances[u], edge, tuple(relaxed)))
        if u == target:
            break
    return steps


def _rank(method: Method, number: int, distance: float, estimate: float) -> float:
    """Return what the search picks the least of; ``number`` is that of the step in which the vertex was seen last."""
    match method:
        case "dijkstra":
            return distance
        case "astar":
            return distance + estimate
        case "breadth-first":
            return float(number)
        case "depth-first":
            return -float(number)


def _weighs(method: Method) -> bool:
    return method in ("dijkstra", "astar")


def _neighbours(graph: Graph, vertex: int) -> list[tuple[int, float]]:
    row = slice(graph.indptr[vertex], graph.indptr[vertex + 1])
    return list(zip(graph.indices[row].tolist(), graph.weights[row].tolist(), strict=True))


def _estimates(graph: Graph, target: int | None, positions: ArrayLike | None) -> Floats:
    """Return the straight-line distances to the target, checked to be no more than the ways along edges."""
    if target is None or positions is None:
        raise ValueError("astar needs a target and the positions of the vertices")
    places = np.asarray(positions, dtype=np.float64)
    if places.shape != (graph.n, 2):
        raise ValueError(f"positions of shape {places.shape} for {graph.n} vertices: give ({graph.n}, 2)")
    edges, lengths = graph.edges, graph.lengths
    with np.errstate(over="ignore", invalid="ignore"):
        estimates = _straight(places - places[target])
        apart = _straight(places[edges[:, 0]] - places[edges[:, 1]])
    if not (np.isfinite(estimates).all() and np.isfinite(apart).all()):
        raise ValueError("positions must be finite and their distances below 1e154")
    # lengths rounded otherwise than here are no error: the library's one tolerance
    short = np.flatnonzero(lengths + 2.0**-40 * np.abs(places).max() < apart)
    if short.size:
        (a, b), k = edges[short[0]].tolist(), short[0]
        raise ValueError(
            f"astar would be misled: the edge of vertices {a} and {b} weighs {lengths[k]:.6g}, less than the distance "
            f"{apart[k]:.6g} of its ends; use dijkstra, or weights that are no less than the distances"
        )
    return estimates


def _straight(offsets: Floats) -> Floats:
    # not np.hypot: the kernel's last bit is wanted
    return np.asarray(np.sqrt(offsets[:, 0] * offsets[:, 0] + offsets[:, 1] * offsets[:, 1]), dtype=np.float64)


def _picked(trace: Trace, number: int, frontier: dict[int, float], labels: Sequence[str]) -> str:
    """Say which vertex is visited and why."""
    step = trace.steps[number]
    if step.edge is None:
        return f"start at {labels[step.vertex]}, distance 0."
    name, parent = labels[step.vertex], labels[step.edge[0]]
    match trace.method:
        case "dijkstra":
            return f"pick {name}, {_least(step.vertex, frontier, 'distance ', labels)}."
        case "astar":
            sums = {v: distance + float(trace.estimates[v]) for v, distance in frontier.items()}
            straight = _number(float(trace.estimates[step.vertex]))
            sum_of = f"distance + straight line = {_number(step.distance)} + {straight} = "
            return f"pick {name}, {_least(step.vertex, sums, sum_of, labels)}."
        case "breadth-first":
            why = "which has waited longest" if len(frontier) > 1 else "the only one waiting"
            return f"pick {name}, {why}; it is {_edges(step.distance)} from {labels[trace.source]}."
        case "depth-first":
            if step.edge[0] == trace.steps[number - 1].vertex:
                return f"pick {name}, the first unvisited neighbour of {parent}; it is {_edges(step.distance)} deep."
            return f"go back to {parent} and pick {name}, its next unvisited neighbour, {_edges(step.distance)} deep."


def _least(vertex: int, values: dict[int, float], what: str, labels: Sequence[str]) -> str:
    """Say that the vertex has the least of the values, and which come next."""
    rest = sorted((value, v) for v, value in values.items() if v != vertex)
    if not rest:
        return f"the only one in the frontier, {what}{_number(values[vertex])}"
    next_value = rest[0][0]
    least = _number(values[vertex], next_value)
    if next_value == values[vertex]:
        tied = [labels[v] for value, v in rest if value == next_value]
        return f"least {what}{least} (a tie with {_listed(tied)}: the earlier vertex goes first)"
    others = ", ".join(f"{labels[v]} has {_number(value, values[vertex])}" for value, v in rest[:MANY])
    return f"least {what}{least} ({others}{', …' if len(rest) > MANY else ''})"


def _changes(trace: Trace, step: Step, frontier: dict[int, float], visited: set[int], labels: Sequence[str]) -> str:
    """Say what the visit changes for the neighbours, and what it does not; ``frontier`` is that before it."""
    if step.vertex == trace.target:
        return "It is the target: done."
    neighbours = _neighbours(trace.graph, step.vertex)
    if not neighbours:
        return "It has no neighbours."
    if not _weighs(trace.method):
        seen = [labels[v] for v, old, _ in step.relaxed if isinf(old)]
        return f"Seen for the first time: {_listed(seen)}." if seen else "Nothing new is seen."
    news = {v: new for v, _, new in step.relaxed}
    told = []
    for v, weight in neighbours:
        if v in visited:
            continue
        old, offer = frontier.get(v, inf), step.distance + weight
        way = f"{_number(step.distance)} + {_number(weight)} = {_number(offer, old)}"
        if v in news:
            told.append(f"{labels[v]} falls from {_number(old, offer)} to {way}")
        else:
            told.append(f"{labels[v]} keeps {_number(old, offer)}, as {way} is not less")
    return "; ".join(told) + "." if told else "All its neighbours are visited."


def _result(trace: Trace, labels: Sequence[str]) -> str:
    source, path = labels[trace.source], trace.path
    if trace.target is None:
        missing = trace.graph.n - len(trace.steps)
        left = f"; {missing} cannot be reached" if missing else ""
        return (
            f"All vertices that can be reached from {source} are visited: {len(trace.steps)} of {trace.graph.n}{left}."
        )
    if not path:
        return f"There is no path from {source} to {labels[trace.target]}."
    way = " → ".join(labels[v] for v in path)
    match trace.method:
        case "breadth-first":
            return f"Path with the fewest edges: {way}, {_edges(trace.distance)}."
        case "depth-first":
            return f"Path found: {way}, {_edges(trace.distance)} (a path, not always a short one)."
    legs = [_number(dict(_neighbours(trace.graph, a))[b]) for a, b in pairwise(path)]
    parts = f"{' + '.join(legs)} = " if 1 < len(legs) <= LONG else ""
    return f"Shortest path: {way}, length {parts}{_number(trace.distance)}."


def _listed(texts: Sequence[str]) -> str:
    return " and ".join([*filter(None, [", ".join(texts[:-1])]), texts[-1]])


def _edges(count: float) -> str:
    return f"{count:.0f} {'edge' if count == 1 else 'edges'}"


def _number(value: float, *others: float) -> str:
    """Return the number in six digits, or in all if those of another that differs are the same."""
    text = f"{value:.6g}"
    if any(other != value and f"{other:.6g}" == text for other in others):
        text = repr(value)
    return text.replace("inf", "∞")
