"""MRPPA up to the timing: the visibility graph cut in two, bridged by λ2 robot for robot, and made whole again.

Source: Alwafi, Social Graphs and Their Applications to Robotics, 4.8 and 5.2, made definite. It is done once for each
size of robot, and takes O(n³) for each bridge in a graph of n vertices.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from typing import TypeAlias

import numpy as np

from taut.errors import SceneError
from taut.graph import (
    Weight,
    algebraic_connectivity,
    best_edges,
    components,
    contracted,
    dijkstra,
    fiedler_vector,
    gathered,
    in_one_piece,
    path_to,
    split,
)
from taut.graph.core import Floats
from taut.scene import Scene
from taut.team.ground import Bools, Ground, ground_of
from taut.team.stages import (
    BridgeStage,
    FirstPathStage,
    FreeSpaceStage,
    FullGraphStage,
    ObstacleGraphStage,
    SplitStage,
)

GraphStage: TypeAlias = FreeSpaceStage | ObstacleGraphStage | SplitStage | BridgeStage | FirstPathStage | FullGraphStage


def mrppa_stages(
    scene: Scene, order: Sequence[int], weight: Weight, by_hand: Sequence[str] | None = None
) -> tuple[GraphStage, ...]:
    """Go through the stages before the timing, for each size of robot from the smallest.

    Parameters
    ----------
    order : numbers of the robots in the sequence of planning.
    weight : of an edge in λ2, from its length in metres.
    by_hand : names on one side of the split ("O1", "R1 start", "R2 goal"); all else is on the other side.

    Raises
    ------
    ValueError
        ``weight`` gives an edge a weight that is not finite and positive.
    SceneError
        ``by_hand`` names something that is not in the scene.
    StartBlocked, GoalBlocked, NoPath
        A robot cannot stand at its start or goal, or obstacles separate them.
    """
    growths = [scene.growth(robot) for robot in scene.robots]
    grounds = [ground_of(scene, growth, weight) for growth in sorted(set(growths))]
    if by_hand is not None:
        _require_known(scene, by_hand)
    stages: list[GraphStage] = []
    for ground in grounds:
        team = [scene.robots[i].name for i in order if scene.robots[i].name in ground.robots]
        stages += _stages_on(ground, team, by_hand)
    return tuple(stages)


def split_names(scene: Scene) -> list[str]:
    """Names that a split by hand may put on a side: of obstacles, and of starts and goals."""
    ends = [f"{robot.name} {word}" for robot in scene.robots for word in ("start", "goal")]
    return [obstacle.name for obstacle in scene.obstacles] + ends


def _require_known(scene: Scene, names: Sequence[str]) -> None:
    known = split_names(scene)
    if isinstance(names, str):
        raise SceneError(f"split: give a list of names, like [{names!r}]")
    for name in names:
        if name not in known:
            raise SceneError(f"split: {name!r} is not in the scene; name obstacles (O1) and ends of robots (R1 start)")
        if known.count(name) > 1:
            raise SceneError(f"split: {name!r} is both an obstacle and an end of a robot; rename the obstacle")
    if set(names) in (set(), set(known)):
        raise SceneError(f"split: {'nothing' if not names else 'everything'} is on the side given; name a part")


def _stages_on(ground: Ground, order: Sequence[str], by_hand: Sequence[str] | None) -> Iterator[GraphStage]:
    yield FreeSpaceStage(ground)
    yield ObstacleGraphStage(ground, int(components(ground.graph(ground.on_obstacles)).max()) + 1)
    cut = _cut(ground, by_hand)
    yield cut
    edges = cut.edges
    waiting: list[str] = []
    for robot in order:
        path = _first_path(cut, edges, robot)
        if path is None:
            waiting.append(robot)
        else:
            yield path
    while waiting:
        bridge = _bridge(cut, edges, waiting)
        if bridge is None:
            break
        yield bridge
        edges = bridge.edges
        waiting.remove(bridge.robot)
        yield from _paths(cut, edges, [bridge.robot])
    yield from _paths(cut, edges, waiting)
    whole = np.ones(len(edges), dtype=np.bool_)
    yield FullGraphStage(ground, algebraic_connectivity(ground.graph(whole)), _lengths(ground, whole, ground.robots))


def _cut(ground: Ground, by_hand: Sequence[str] | None) -> SplitStage:
    """Cut the graph of the groups in two, so that each obstacle is whole on one side.

    Rooms without a way between them are sides already, also of the obstacles that separate them.
    """
    graph = ground.graph(np.ones(len(ground.weights), dtype=np.bool_))
    groups = contracted(graph, ground.groups)
    values: Floats = np.empty(0)
    moved: tuple[str, ...] = ()
    rooms = components(graph)
    if by_hand is not None:
        given, by = np.array([not set(members).isdisjoint(by_hand) for members in ground.members]), "hand"
        side = in_one_piece(groups, given) if rooms.max() == 0 else given
        moved = tuple(", ".join(ground.members[g]) for g in np.flatnonzero(side != given).tolist())
        sides = side[ground.groups]
    elif rooms.max() > 0:
        sides, by = gathered(rooms), "components"
    else:
        towards = [_means(ground, ground.roadmap.positions[:, k]) for k in (0, 1)]
        sides, by = split(groups, towards)[ground.groups], "Fiedler vector"
        values = fiedler_vector(groups, towards) if groups.n > 1 else values
    pairs = ground.roadmap.edges
    kept = sides[pairs[:, 0]] == sides[pairs[:, 1]]
    return SplitStage(ground, sides, kept, values, by, algebraic_connectivity(groups), moved)


def _means(ground: Ground, values: Floats) -> Floats:
    """Mean of one coordinate over each group."""
    sizes = np.bincount(ground.groups)
    return np.asarray(np.bincount(ground.groups, weights=values) / sizes)


def _bridge(cut: SplitStage, edges: Bools, waiting: Sequence[str]) -> BridgeStage | None:
    """Choose the best edge among those that give, or shorten, the path of a robot; None if there is none."""
    ground = cut.ground
    away = np.flatnonzero(~edges)
    pairs, lengths = ground.roadmap.edges[away], ground.roadmap.lengths[away]
    tol = ground.freespace.scene.tol
    helps = np.zeros((len(waiting), len(away)), dtype=np.bool_)
    for k, robot in enumerate(waiting):
        start, goal = ground.ends[ground.robots.index(robot)].tolist()
        graph = ground.distances(edges, robot)
        ahead, behind = dijkstra(graph, start)[0], dijkstra(graph, goal)[0]
        through = np.minimum(ahead[pairs[:, 0]] + behind[pairs[:, 1]], ahead[pairs[:, 1]] + behind[pairs[:, 0]])
        helps[k] = through + lengths < ahead[goal] - tol
    candidates = np.flatnonzero(helps.any(axis=0))
    if len(candidates) == 0:
        return None
    chosen = best_edges(ground.graph(edges), pairs[candidates], ground.weights[away[candidates]])[0]
    served = waiting[int(np.argmax(helps[:, candidates[chosen.candidate]]))]
    now = edges.copy()
    now[away[candidates[chosen.candidate]]] = True
    second = chosen.runner_up
    return BridgeStage(
        ground,
        cut,
        now,
        int(away[candidates[chosen.candidate]]),
        served,
        len(candidates),
        chosen.before,
        chosen.after,
        None if second is None else int(away[candidates[second]]),
        chosen.runner_up_after,
    )


def _paths(cut: SplitStage, edges: Bools, robots: Sequence[str]) -> Iterator[FirstPathStage]:
    for robot in robots:
        path = _first_path(cut, edges, robot)
        if path is not None:
            yield path


def _first_path(cut: SplitStage, edges: Bools, robot: str) -> FirstPathStage | None:
    ground = cut.ground
    start, goal = ground.ends[ground.robots.index(robot)].tolist()
    distance, before = dijkstra(ground.distances(edges, robot), start)
    if not np.isfinite(distance[goal]):
        return None
    return FirstPathStage(ground, cut, edges, robot, np.array(path_to(before, goal)), float(distance[goal]))


def _lengths(ground: Ground, edges: Bools, robots: Sequence[str]) -> Floats:
    """Metres of each robot's shortest path."""
    ends = [ground.ends[ground.robots.index(robot)].tolist() for robot in robots]
    found = [
        dijkstra(ground.distances(edges, robot), start)[0][goal]
        for robot, (start, goal) in zip(robots, ends, strict=True)
    ]
    return np.array(found, dtype=np.float64)
