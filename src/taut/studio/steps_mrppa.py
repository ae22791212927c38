"""MRPPA on a scene: the stages before the timing, then the team planned robot by robot."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import Any, TypeAlias

import numpy as np

from taut.freespace import FreeSpace
from taut.graph import beta_index
from taut.route import shortest_path
from taut.scene import FloatArray, Scene
from taut.studio import marks
from taut.studio.answers import plan_with
from taut.team import Result
from taut.team.ground import Ground
from taut.team.stages import (
    BridgeStage,
    FirstPathStage,
    FreeSpaceStage,
    FullGraphStage,
    ObstacleGraphStage,
    SequenceStage,
    SplitStage,
)
from taut.team.telling import tell, tell_conflict, title

GroundStage: TypeAlias = (
    FreeSpaceStage | ObstacleGraphStage | SplitStage | BridgeStage | FirstPathStage | FullGraphStage
)

FEW = 40
"""Up to so many vertices carry numbers or values."""

_KEPT = ("order", "seed", "rounds", "seconds", "contact")
_SIDES = ("side-a", "side-b")


def mrppa_steps(scene: Scene, settings: Mapping[str, Any]) -> dict[str, Any]:
    """Plan a team by MRPPA and return its stages as steps.

    Parameters
    ----------
    settings : of the page; those that do not go with MRPPA (roadmap, objective, within) are left out.

    Raises
    ------
    NoPath, NoPlanExists, NoPlanFound, SceneError
        As `taut.plan`.
    """
    asked = {name: settings[name] for name in _KEPT if settings.get(name) is not None}
    return stage_steps(plan_with(scene, {**asked, "method": "mrppa"}))


def stage_steps(result: Result) -> dict[str, Any]:
    """Return the stages of a result of MRPPA as steps."""
    grounds: list[Ground] = []
    steps: list[marks.Step] = []
    behind: list[marks.Mark] = []
    for stage in result.stages:
        if isinstance(stage, SequenceStage):
            steps += _sequence(result, stage)
            continue
        if stage.ground not in grounds:
            grounds.append(stage.ground)
        number = grounds.index(stage.ground)
        told = list(_of_ground(stage, number))
        if isinstance(stage, BridgeStage | FirstPathStage):
            # what was cut is seen in full once, then faintly behind what is built on it
            told[0]["stays"] = [*behind, *told[0]["stays"]]
            behind = []
        if isinstance(stage, SplitStage):
            behind = _behind(stage, number)
        if len(stage.ground.robots) < len(stage.ground.freespace.scene.robots):
            for one in told:
                one["title"] += f" · growth {stage.ground.freespace.growth:g} m"
        steps += told
    return {"base": [], "points": [ground.roadmap.positions.tolist() for ground in grounds], "steps": steps}


def lambda2(value: float) -> str:
    """Return λ2 for people."""
    return f"{value:.6g}"


def _of_ground(stage: GroundStage, points: int) -> Iterator[marks.Step]:
    match stage:
        case FreeSpaceStage():
            yield _free_space(stage)
        case ObstacleGraphStage():
            yield _obstacle_graph(stage, points)
        case SplitStage():
            if len(stage.values):
                yield _fiedler(stage, points)
            yield _split(stage, points)
        case BridgeStage():
            yield _bridge(stage, points)
        case FirstPathStage():
            yield _first_path(stage, points)
        case FullGraphStage():
            yield _full_graph(stage, points)


def _free_space(stage: FreeSpaceStage) -> marks.Step:
    space = stage.ground.freespace
    story = "Where the centre of a robot may be: obstacles and wall come nearer by radius + clearance."
    return marks.step(
        title(stage),
        [story, *tell(stage)],
        {"growth": f"{space.growth:g} m", "area": f"{space.area:.2f} m²", "parts": str(space.parts)},
        stays=[marks.band(space.scene, space.region)],
        marks=[marks.area(space.region, "free")],
        fresh=True,
    )


def _obstacle_graph(stage: ObstacleGraphStage, points: int) -> marks.Step:
    ground = stage.ground
    n = len(ground.names)
    pairs = ground.roadmap.edges[ground.on_obstacles]
    story = "Starts, goals and corners of obstacles are the vertices; as yet only sides of obstacles join them."
    numbers = {"vertices": str(n), "edges": str(len(pairs)), "components": str(stage.components)}
    if stage.components > 1:
        numbers["λ2"] = "0"
    return marks.step(
        title(stage),
        [story, *tell(stage)],
        numbers,
        marks=[
            marks.edges(points, pairs, "tree"),
            marks.vertices(points, "graph", **({"labels": [str(v + 1) for v in range(n)]} if n <= FEW else {})),
        ],
    )


def _fiedler(stage: SplitStage, points: int) -> marks.Step:
    ground = stage.ground
    of_vertex = stage.values[ground.groups]
    tiny = np.finfo(float).tiny
    largest = np.where(of_vertex < 0, max(-float(of_vertex.min()), tiny), max(float(of_vertex.max()), tiny))
    # each sign by itself, and roots: few vertices have large values, and all others would look like 0
    shares = np.sign(of_vertex) * np.sqrt(np.abs(of_vertex) / largest)
    first = set(np.unique(ground.groups, return_index=True)[1].tolist())
    labels = [f"{value:+.3f}".replace("-", "−") if v in first else "" for v, value in enumerate(of_vertex.tolist())]
    few = {"labels": labels} if len(first) <= FEW else {}
    return marks.step(
        "Fiedler vector",
        [
            "The Fiedler vector gives vertices that hang together closely nearly the same value: where its sign "
            "changes, the graph is easiest to cut.",
            "Each obstacle counts as one vertex here, so that none is cut through.",
            "Colours run from the least value over 0 to the greatest.",
        ],
        {"λ2": lambda2(stage.connectivity), "groups": str(len(stage.values))},
        marks=[
            marks.edges(points, ground.roadmap.edges, "faint"),
            marks.vertices(points, "fiedler", values=shares.tolist(), **few),
        ],
    )


def _split(stage: SplitStage, points: int) -> marks.Step:
    pairs, side = stage.ground.roadmap.edges, stage.side.astype(int)
    shown = [marks.edges(points, pairs[~stage.edges], "removed")] if not stage.edges.all() else []
    for k, role in enumerate(_SIDES):
        shown.append(marks.edges(points, pairs[stage.edges & (side[pairs[:, 0]] == k)], role))
    removed = int((~stage.edges).sum())
    if removed:
        story = "All edges between the two sides are taken out: nothing joins them, so λ2 falls to 0."
    else:
        story = "No edge joins the two sides: nothing is to be taken out."
    how, *more = tell(stage)
    named = [f"Side {word}: {marks.listed(_members(stage, k), 12) or 'nothing'}." for k, word in enumerate("AB")]
    return marks.step(
        title(stage),
        [story, how, *named, *more[-1:]],
        {"removed": str(removed), "left": str(int(stage.edges.sum()))} | ({"λ2": "0"} if removed else {}),
        marks=[*shown, *_sides(stage, points)],
    )


def _members(stage: SplitStage, side: int) -> list[str]:
    """Names of the obstacles, starts and goals on a side."""
    first = np.unique(stage.ground.groups, return_index=True)[1].tolist()
    pairs = zip(first, stage.ground.members, strict=True)
    return [name for vertex, members in pairs if stage.side[vertex] == bool(side) for name in members]


def _sides(stage: SplitStage, points: int) -> list[marks.Mark]:
    """Vertices and obstacles in the hue of their side."""
    known = {obstacle.name for obstacle in stage.ground.freespace.scene.obstacles}
    out = []
    for k, role in enumerate(_SIDES):
        out.append(marks.obstacles([name for name in _members(stage, k) if name in known], role))
        out.append(marks.vertices(points, role, np.flatnonzero(stage.side == bool(k))))
    return out


def _behind(stage: SplitStage, points: int) -> list[marks.Mark]:
    """What is seen of the cut behind bridges and paths."""
    return [marks.edges(points, stage.ground.roadmap.edges[stage.edges], "faint"), *_sides(stage, points)]


def _bridge(stage: BridgeStage, points: int) -> marks.Step:
    pairs = stage.ground.roadmap.edges
    numbers = {
        "λ2 before": lambda2(stage.before),
        "λ2 after": lambda2(stage.after),
        "candidates": str(stage.candidates),
        "serves": stage.robot,
    }
    shown = []
    if stage.runner_up is not None and stage.runner_up_after is not None:
        numbers["λ2 with the runner-up"] = lambda2(stage.runner_up_after)
        label = f"λ2 = {lambda2(stage.runner_up_after)}"
        shown.append(marks.edges(points, pairs[[stage.runner_up]], "runner-up", labels=[label]))
    label = f"λ2 = {lambda2(stage.after)}"
    shown.append(marks.edges(points, pairs[[stage.edge]], "bridge", robot=stage.robot, labels=[label]))
    story = "Of all edges that give a robot a path, or a shorter one, the one that raises λ2 most is put back."
    return marks.step(
        title(stage),
        [story, *tell(stage)],
        numbers,
        stays=[marks.edges(points, pairs[[stage.edge]], "bridge")],
        marks=shown,
    )


def _first_path(stage: FirstPathStage, points: int) -> marks.Step:
    story = f"The shortest path of {stage.robot} in the graph as it is now."
    return marks.step(
        title(stage),
        [story, *tell(stage)],
        {"length": marks.metres(stage.length), "legs": str(len(stage.path) - 1)},
        marks=[marks.path(points, "path", stage.path, robot=stage.robot)],
    )


def _full_graph(stage: FullGraphStage, points: int) -> marks.Step:
    ground, graph = stage.ground, stage.ground.roadmap.graph
    return marks.step(
        title(stage),
        ["All edges are put back: now every robot has its shortest path.", *tell(stage)],
        {
            "vertices": str(graph.n),
            "edges": str(graph.m),
            "λ2": lambda2(stage.connectivity),
            "β": f"{beta_index(graph):.4f}",
        },
        stays=[marks.band(ground.freespace.scene, ground.freespace.region)],
        marks=[marks.edges(points, ground.roadmap.edges, "graph"), marks.vertices(points, "graph")],
        fresh=True,
    )


def _sequence(result: Result, stage: SequenceStage) -> Iterator[marks.Step]:
    """One step a robot in the order of planning, then the whole plan."""
    scene = stage.plan.scene
    motions = {motion.name: motion for motion in stage.plan.trajectories}
    whys = dict(zip((robot.name for robot in scene.robots), result.detours, strict=True))
    spaces: dict[float, FreeSpace] = {}
    for number, name in enumerate(stage.order, 1):
        robot, motion, met = scene.robot(name), motions[name], stage.conflicts[name]
        when = "first: nobody is in its way yet" if number == 1 else "next: it has to get past those planned before it"
        story = [f"{name} is planned {when}. From now on its motion is fixed."]
        story += [f"{k}. {tell_conflict(conflict)}" for k, conflict in enumerate(met, 1)]
        if not met:
            why = whys[name]
            story.append(f"It {why}." if why else "It goes its shortest way unhindered.")
        waiting = sum(until - since for since, until, _, _ in motion.waits)
        numbers = {
            "arrival": f"{motion.arrival:.3f} s",
            "length": marks.metres(motion.length),
            "waiting": f"{waiting:.3f} s",
            "conflicts": str(len(met)),
        }
        shown = []
        if met:
            growth = scene.growth(robot)
            if growth not in spaces:
                spaces[growth] = FreeSpace(scene, growth)
            alone = shortest_path(spaces[growth], robot.start, robot.goal).points
            shown = [
                marks.path(alone, "baseline"),
                marks.vertices([c.place for c in met], "hit", labels=[str(k) for k in range(1, len(met) + 1)]),
            ]
        yield marks.step(
            f"{name} is planned ({number} of {len(stage.order)})",
            story,
            numbers,
            stays=[marks.path(_moves(motion.points), "path", robot=name)],
            marks=shown,
            fresh=number == 1,
        )
    yield _planned(stage)


def _planned(stage: SequenceStage) -> marks.Step:
    plan, met = stage.plan, [conflict for name in stage.order for conflict in stage.conflicts[name]]
    proved = (plan.certificate or {}).get("ok") is True
    story = "The plan is proved from scene and plan alone: nobody collides." if proved else "The plan does not hold."
    return marks.step(
        "The plan",
        [story, tell(stage)[-1]],
        {
            "sum of costs": f"{plan.sum_of_costs:.3f} s",
            "makespan": f"{plan.makespan:.3f} s",
            "conflicts": str(len(met)),
            "certified": "yes" if proved else "NO",
        },
    )


def _moves(points: FloatArray) -> FloatArray:
    """The places of a motion without its rests."""
    moved = np.append(True, (np.diff(points, axis=0) != 0).any(axis=1))
    return np.asarray(points[moved], dtype=np.float64)
