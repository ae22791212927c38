"""Dijkstra and A* on a robot's visibility graph: one step a vertex settled."""

from __future__ import annotations

import contextlib
import math
from itertools import pairwise
from typing import Any, Literal

import numpy as np

from taut.errors import GoalBlocked, NoPath, StartBlocked
from taut.freespace import FreeSpace
from taut.graph.tracing import Trace, tell, trace
from taut.roadmap import visibility_graph
from taut.scene import Robot, Scene
from taut.studio import marks

FEW = 60
"""Up to so many vertices carry their names."""

# many vertices on every round corner would make thousands of steps that teach nothing
_ARC_ERRORS = (0.1, 0.025, 1e-3)
_NAMES = {"dijkstra": "Dijkstra", "astar": "A*"}
_RULES = {
    "dijkstra": "Dijkstra settles, again and again, the vertex of the frontier that is nearest to the start.",
    "astar": "A* settles, again and again, the vertex of the frontier for which the way so far plus the straight line "
    "to the goal is least.",
}


def search_steps(scene: Scene, robot: Robot, method: Literal["dijkstra", "astar"]) -> dict[str, Any]:
    """Return the steps of a search for a robot's shortest path on the visibility graph of its free space.

    Graph and places are sent once; a step adds what it settles and what it sees.

    Raises
    ------
    StartBlocked, GoalBlocked, NoPath
        The robot cannot stand at its start or goal, or obstacles separate them.
    """
    freespace = _coarse(scene, robot)
    ends = list(dict.fromkeys([robot.start, robot.goal]))
    roadmap = visibility_graph(freespace, points=ends)
    n = len(roadmap.positions)
    source, target = n - len(ends), n - 1
    done = trace(roadmap.graph, source, target, method, roadmap.positions)
    names = [f"v{v + 1}" for v in range(n - len(ends))] + ["S", "G"][: len(ends)]
    told = tell(done, names)
    rounded = ["Round corners are drawn with few vertices here."] if freespace.growth else []
    first = marks.step(
        f"{_NAMES[method]}: the graph",
        [
            _RULES[method],
            f"The visibility graph of {robot.name} has {marks.count(n, 'vertex', 'vertices')} and "
            f"{marks.count(roadmap.graph.m, 'edge')}: those on which a shortest path can run.",
            *rounded,
        ],
        {"vertices": str(n), "edges": str(roadmap.graph.m)},
        stays=[marks.vertices(0, "open", [source])],
    )
    return {
        "base": [
            marks.band(scene, freespace.region),
            marks.edges(0, roadmap.edges, "graph"),
            marks.vertices(0, "graph", **({"labels": names} if n <= FEW else {})),
        ],
        "points": [roadmap.positions.tolist()],
        "steps": [first, *_settled(done, names, told), _found(done, robot, told[-1])],
    }


def _coarse(scene: Scene, robot: Robot) -> FreeSpace:
    """Return the robot's free space with as few vertices round corners as let it through."""
    for arc_error in _ARC_ERRORS[:-1]:
        freespace = FreeSpace.of(scene, robot, arc_error)
        with contextlib.suppress(StartBlocked, GoalBlocked, NoPath):
            freespace.require(robot)
            return freespace
    freespace = FreeSpace.of(scene, robot, _ARC_ERRORS[-1])
    freespace.require(robot)
    return freespace


def _settled(done: Trace, names: list[str], told: list[str]) -> list[marks.Step]:
    """One step for each vertex settled; what is seen or settled stays."""
    out = []
    waiting = {done.source}
    before: dict[int, int] = {}
    for number, (now, story) in enumerate(zip(done.steps, told, strict=False), 1):
        seen = [v for v, old, _ in now.relaxed if math.isinf(old)]
        waiting.discard(now.vertex)
        waiting.update(seen)
        numbers = {"way so far": marks.metres(now.distance)}
        if done.method == "astar":
            straight = float(done.estimates[now.vertex])
            numbers |= {"straight line": marks.metres(straight), "sum": marks.metres(now.distance + straight)}
        numbers |= {"settled": str(number), "frontier": str(len(waiting))}
        stays = [marks.vertices(0, "open", seen)] if seen else []
        if now.edge is not None:
            stays.append(marks.edges(0, [now.edge], "tree"))
        stays.append(marks.vertices(0, "closed", [now.vertex]))
        shown = [marks.vertices(0, "current", [now.vertex])]
        if now.relaxed:
            shown.append(marks.edges(0, [(now.vertex, v) for v, _, _ in now.relaxed], "current"))
        if now.edge is not None:
            before[now.vertex] = now.edge[0]
            shown.append(marks.path(0, "tree", _way_to(now.vertex, before)))
        out.append(
            marks.step(f"Settle {names[now.vertex]}", _lines(done, number, story), numbers, stays=stays, marks=shown)
        )
    return out


def _lines(done: Trace, number: int, story: str) -> list[str]:
    """Why the vertex is settled now, in general and in numbers, and what its neighbours hear."""
    told = story.partition(": ")[2]
    picked, _, heard = told.partition(". ")
    if number == 1:
        return ["The search begins at the start: the way there has no length.", *([heard] if heard else [])]
    if done.method == "astar":
        why = "No vertex of the frontier promises a shorter way to the goal, so the way to this one is final."
    else:
        why = "No vertex of the frontier is nearer to the start, so the way to this one is final."
    return [why, f"{picked[:1].upper()}{picked[1:]}.", heard]


def _way_to(vertex: int, before: dict[int, int]) -> list[int]:
    way = [vertex]
    while way[-1] in before:
        way.append(before[way[-1]])
    return way[::-1]


def _found(done: Trace, robot: Robot, said: str) -> marks.Step:
    way = done.path
    share = len(done.steps) / done.graph.n
    legs = np.array(list(pairwise(way)), dtype=np.int64).reshape(-1, 2)
    return marks.step(
        "Shortest path",
        [said, f"The search settled {len(done.steps)} of {done.graph.n} vertices ({100 * share:.0f} %)."],
        {"length": marks.metres(done.distance), "legs": str(len(legs)), "settled": str(len(done.steps))},
        marks=[marks.path(0, "path", way, robot=robot.name)],
    )
