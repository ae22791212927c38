"""Stages in words and as plain data: for the terminal, for text files beside the figures, and for JSON."""

from __future__ import annotations

import math
from collections.abc import Iterable, Sequence

import numpy as np

from taut.errors import one_line
from taut.graph import beta_index
from taut.team.conflicts import Conflict
from taut.team.ground import Ground
from taut.team.methods import Progress
from taut.team.stages import (
    BridgeStage,
    FirstPathStage,
    FreeSpaceStage,
    FullGraphStage,
    ObstacleGraphStage,
    SequenceStage,
    SplitStage,
    Stage,
)

_MANY = 12


def title(stage: Stage) -> str:
    """Return what a stage is about, in a few words."""
    return one_line(_title(stage))


def _title(stage: Stage) -> str:
    match stage:
        case FreeSpaceStage():
            return "Free space"
        case ObstacleGraphStage():
            return "Obstacle graph"
        case SplitStage():
            return "Split in two"
        case BridgeStage():
            return f"Bridge for {stage.robot}"
        case FirstPathStage():
            return f"First path of {stage.robot}"
        case FullGraphStage():
            return "Full visibility graph"
        case SequenceStage():
            return "Planned in sequence"


def tell(stage: Stage) -> list[str]:
    """Return what was found, as sentences for people, one line each."""
    return [one_line(line) for line in _story(stage)]


def _story(stage: Stage) -> list[str]:
    match stage:
        case FreeSpaceStage():
            return _tell_free_space(stage)
        case ObstacleGraphStage():
            return _tell_obstacle_graph(stage)
        case SplitStage():
            return _tell_split(stage)
        case BridgeStage():
            return _tell_bridge(stage)
        case FirstPathStage():
            way = " – ".join(stage.ground.names[v] for v in stage.path.tolist())
            return [f"{stage.robot} has a path of {stage.length:.4f} m: {way}."]
        case FullGraphStage():
            return _tell_full_graph(stage)
        case SequenceStage():
            return _tell_sequence(stage)


def so_far(progress: Progress) -> str:
    """Return how far planning has come, in a few words."""
    doing = {"passes": "round", "search": "node", "repair": "repair", "proof": "node"}[progress.doing]
    words = [f"{doing} {progress.done}"]
    if progress.failed:
        words.append(f"{progress.failed} robots failed")
    if progress.cost < math.inf:
        words.append(f"cost {progress.cost:.2f} s")
    if 0 < progress.bound < math.inf:
        above = f" ({100 * (progress.cost / progress.bound - 1):.2f} % above)" if progress.cost < math.inf else ""
        words.append(f"bound {progress.bound:.2f} s{above}")
    return ", ".join(words)


def stage_data(stage: Stage) -> dict[str, object]:
    """Return a stage as plain data for JSON; vertices by number, with their names and places where they are many."""
    data: dict[str, object] = {"kind": _kind(stage), "title": title(stage), "story": tell(stage)}
    if not isinstance(stage, SequenceStage):
        data["growth"] = stage.ground.freespace.growth
    return data | _facts(stage)


def tell_conflict(conflict: Conflict) -> str:
    """Return one conflict and its resolution as a sentence."""
    x, y = conflict.place
    where = f"near ({x:.2f}, {y:.2f}) at {conflict.time:.2f} s"
    meets = {
        "crossroads": f"would meet {conflict.other} at crossroads {where}",
        "head-on": f"would meet {conflict.other} head-on {where}",
        "catching up": f"would run into {conflict.other} ahead of it {where}",
        "crossing in the open": f"would cross the way of {conflict.other} in the open {where}",
        "standing": f"would run into {conflict.other} standing {where}",
        "passed over": f"would stand in the way of {conflict.other} {where}",
        "held start": f"would pass {conflict.other}, which has not left its start, {where}",
    }[conflict.kind]
    did = f"it waits and {'comes' if conflict.kind == 'passed over' else 'passes'} there {conflict.delay:.2f} s later"
    if conflict.resolution == "another way":
        did = "it takes another way"
    return f"{conflict.robot} {meets}: {did}."


def _kind(stage: Stage) -> str:
    match stage:
        case FreeSpaceStage():
            return "free space"
        case ObstacleGraphStage():
            return "obstacle graph"
        case SplitStage():
            return "split"
        case BridgeStage():
            return "bridge"
        case FirstPathStage():
            return "first path"
        case FullGraphStage():
            return "full graph"
        case SequenceStage():
            return "sequence"


def _facts(stage: Stage) -> dict[str, object]:
    match stage:
        case FreeSpaceStage(ground):
            return {
                "robots": list(ground.robots),
                "area": ground.freespace.area,
                "parts": ground.freespace.parts,
                "arc_error": ground.freespace.arc_error,
            }
        case ObstacleGraphStage(ground):
            return {
                "vertices": [
                    {"name": name, "at": at, "group": group}
                    for name, at, group in zip(
                        ground.names, ground.roadmap.positions.tolist(), ground.groups.tolist(), strict=True
                    )
                ],
                "edges": ground.roadmap.edges[ground.on_obstacles].tolist(),
                "components": stage.components,
                "lambda2": 0.0 if stage.components > 1 else None,
                "left_out": ground.left_out,
            }
        case SplitStage(ground):
            groups = [list(members) for members in ground.members]
            return {
                "by": stage.by,
                "groups": groups,
                "fiedler_vector": stage.values.tolist(),
                "lambda2_of_groups": stage.connectivity,
                "side": stage.side.tolist(),
                "moved": list(stage.moved),
                "edges": int(stage.edges.sum()),
                "edges_removed": int((~stage.edges).sum()),
                "lambda2": _connectivity_after(stage),
            }
        case BridgeStage(ground):
            return {
                "robot": stage.robot,
                "edge": _edge_data(ground, stage.edge),
                "candidates": stage.candidates,
                "lambda2_before": stage.before,
                "lambda2": stage.after,
                "runner_up": None if stage.runner_up is None else _edge_data(ground, stage.runner_up),
                "lambda2_with_runner_up": stage.runner_up_after,
            }
        case FirstPathStage(ground):
            return {
                "robot": stage.robot,
                "path": stage.path.tolist(),
                "points": ground.roadmap.positions[stage.path].tolist(),
                "length": stage.length,
            }
        case FullGraphStage(ground):
            return {
                "vertices": ground.roadmap.graph.n,
                "edges": ground.roadmap.graph.m,
                "lambda2": stage.connectivity,
                "lengths": dict(zip(ground.robots, stage.lengths.tolist(), strict=True)),
            }
        case SequenceStage():
            return {
                "order": list(stage.order),
                "conflicts": {
                    name: [_conflict_data(conflict) for conflict in conflicts]
                    for name, conflicts in stage.conflicts.items()
                },
                "sum_of_costs": stage.plan.sum_of_costs,
                "makespan": stage.plan.makespan,
                "certified": (stage.plan.certificate or {}).get("ok") is True,
            }


def _edge_data(ground: Ground, edge: int) -> dict[str, object]:
    pair = ground.roadmap.edges[edge].tolist()
    return {
        "vertices": pair,
        "names": [ground.names[v] for v in pair],
        "length": float(ground.roadmap.lengths[edge]),
        "weight": float(ground.weights[edge]),
    }


def _conflict_data(conflict: Conflict) -> dict[str, object]:
    return {
        "other": conflict.other,
        "kind": conflict.kind,
        "time": conflict.time,
        "place": list(conflict.place),
        "resolution": conflict.resolution,
        "delay": conflict.delay,
    }


def _connectivity_after(stage: SplitStage) -> float | None:
    """λ2 once the sides are apart: 0, unless nothing was cut."""
    return 0.0 if np.ptp(stage.side.astype(int)) or stage.by == "components" else None


def _tell_free_space(stage: FreeSpaceStage) -> list[str]:
    ground = stage.ground
    space = ground.freespace
    robots = _listed(ground.robots)
    lines = [
        f"Robots of radius + clearance {space.growth:g} m ({robots}) may use {space.area:.4f} m² "
        f"in {_count(space.parts, 'part')}."
    ]
    if ground.left_out:
        lines.append(
            f"Rooms without any of these robots are left out: {_count(ground.left_out, 'vertex', 'vertices')}."
        )
    return lines


def _tell_obstacle_graph(stage: ObstacleGraphStage) -> list[str]:
    ground = stage.ground
    outline = int(ground.on_obstacles.sum())
    return [
        f"{_count(len(ground.names), 'vertex', 'vertices')} (starts, goals and corners of obstacles) and "
        f"{_count(outline, 'edge')} of obstacles: {_count(stage.components, 'component')}"
        + (", so λ2 = 0." if stage.components > 1 else ".")
    ]


def _tell_split(stage: SplitStage) -> list[str]:
    ground = stage.ground
    cut = int((~stage.edges).sum())
    names = [", ".join(members) or "a corner of the workspace" for members in ground.members]
    sides = [_listed([names[g] for g in np.unique(ground.groups[stage.side == s]).tolist()]) for s in (True, False)]
    if stage.by == "components":
        how = "The graph is in several components already; they are gathered into two sides."
    elif stage.by == "hand":
        how = "The split was given by hand."
    elif len(stage.values) == 0:
        return ["There is only one vertex: nothing to split."]
    else:
        how = f"With each obstacle as one vertex λ2 is {stage.connectivity:.4f}; its Fiedler vector's signs cut it."
    lines = [how, f"One side: {sides[0] or 'nothing'}.", f"Other side: {sides[1] or 'nothing'}."]
    if stage.moved:
        lines.append(f"Cut off from the rest of their side, these went over to the other: {_listed(stage.moved)}.")
    left = f"{_count(cut, 'edge')} between the sides removed, {stage.edges.sum()} left"
    lines.append(f"{left}: λ2 = 0." if _connectivity_after(stage) == 0 else f"{left}.")
    return lines


def _tell_bridge(stage: BridgeStage) -> list[str]:
    ground = stage.ground
    lines = [
        f"{_count(stage.candidates, 'edge')} would give or shorten a path. "
        f"{_edge_name(ground, stage.edge)} raises λ2 most, from {_value(stage.before)} to {_value(stage.after)}; "
        f"it serves {stage.robot}."
    ]
    if stage.runner_up is not None and stage.runner_up_after is not None:
        lines.append(f"Next best: {_edge_name(ground, stage.runner_up)} with λ2 = {_value(stage.runner_up_after)}.")
    return lines


def _tell_full_graph(stage: FullGraphStage) -> list[str]:
    graph = stage.ground.roadmap.graph
    lines = [
        f"All {_count(graph.m, 'edge')} on {_count(graph.n, 'vertex', 'vertices')} (β = {beta_index(graph):.4f}): "
        f"λ2 = {_value(stage.connectivity)}."
    ]
    pairs = zip(stage.ground.robots, stage.lengths.tolist(), strict=True)
    if len(stage.lengths) <= _MANY:
        lines.append("Shortest paths in it: " + ", ".join(f"{name} {length:.4f} m" for name, length in pairs) + ".")
    return lines


def _tell_sequence(stage: SequenceStage) -> list[str]:
    plan = stage.plan
    lines = []
    told = 0
    for name in stage.order:
        met = stage.conflicts[name]
        if not met:
            lines.append(f"{name} goes its shortest way unhindered.")
        lines += [f"{told + k}. {tell_conflict(conflict)}" for k, conflict in enumerate(met, 1)]
        told += len(met)
    proved = "certified" if (plan.certificate or {}).get("ok") is True else "NOT certified"
    lines.append(f"Sum of costs {plan.sum_of_costs:.4f} s, makespan {plan.makespan:.4f} s, {proved}.")
    return lines


def _edge_name(ground: Ground, edge: int) -> str:
    a, b = (ground.names[v] for v in ground.roadmap.edges[edge].tolist())
    return f"{a} – {b}"


def _value(connectivity: float) -> str:
    return "0" if connectivity == 0 else f"{connectivity:.4f}" if connectivity >= 5e-4 else f"{connectivity:.3g}"


def _count(n: int, one: str, many: str = "") -> str:
    return f"{n} {one if n == 1 else many or one + 's'}"


def _listed(names: Iterable[str]) -> str:
    every: Sequence[str] = list(names)
    shown = ", ".join(every[:_MANY])
    return shown if len(every) <= _MANY else f"{shown} and {len(every) - _MANY} more"
