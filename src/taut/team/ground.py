"""Ground: the visibility graph of one size of robot, obstacle by obstacle, on which MRPPA cuts and bridges."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import TypeAlias

import numpy as np
import shapely
from numpy.typing import NDArray

from taut.errors import GoalBlocked, NoPath, StartBlocked
from taut.freespace import FreeSpace
from taut.geometry.growth import grown
from taut.graph import Graph, Weight, components
from taut.graph.core import Floats, Ints
from taut.roadmap import Roadmap, VisibilityGraph, visibility_graph
from taut.scene import Point, Robot, Scene

Bools: TypeAlias = NDArray[np.bool_]

# λ2 counts vertices: many on every round corner would drown the obstacles. Finer only where robots need it.
_COARSEST, _FINEST = 0.1, 1e-3


@dataclass(frozen=True, eq=False)
class Ground:
    """What all stages of one size of robot stand on.

    Parameters
    ----------
    freespace : of their radius + clearance, its round corners drawn with few vertices.
    roadmap : every visible pair; starts and goals are the last vertices, each place once.
    weights : (m,) weight in λ2 of each edge of the roadmap, > 0.
    names : (n,) what to call each vertex.
    groups : (n,) the obstacle (those that touch are one) that each vertex belongs to; starts, goals and corners of the
        workspace are alone in theirs. 0 … k − 1.
    members : (k,) names of the obstacles, or of the starts and goals, in each group.
    on_obstacles : (m,) whether an edge is part of an obstacle's outline.
    robots : names, in the order of the scene.
    ends : (r, 2) vertices of each robot's start and goal.
    left_out : how many vertices are not in the roadmap, because their room holds no robot of this size.
    ends_only : (n,) starts and goals where free space touches itself: nobody else may pass through them.
    """

    freespace: FreeSpace
    roadmap: Roadmap
    weights: Floats
    names: tuple[str, ...]
    groups: Ints
    members: tuple[tuple[str, ...], ...]
    on_obstacles: Bools
    robots: tuple[str, ...]
    ends: Ints
    left_out: int
    ends_only: Bools

    @property
    def first_end(self) -> int:
        """The first vertex that is a start or goal; all after it are, too."""
        return int(self.ends.min())

    def graph(self, edges: Bools) -> Graph:
        """Return the graph of these edges (m,) with the weights of λ2."""
        return Graph.from_edges(len(self.names), self.roadmap.edges[edges], self.weights[edges])

    def distances(self, edges: Bools, robot: str) -> Graph:
        """Return the graph of these edges (m,) with their lengths, less those that this robot may not use."""
        barred = self.ends_only.copy()
        barred[self.ends[self.robots.index(robot)]] = False
        allowed = edges & ~barred[self.roadmap.edges].any(axis=1)
        return Graph.from_edges(len(self.names), self.roadmap.edges[allowed], self.roadmap.lengths[allowed])


def ground_of(scene: Scene, growth: float, weight: Weight) -> Ground:
    """Build the ground of the robots of one growth (metres).

    Raises
    ------
    ValueError
        ``weight`` gives an edge a weight that is not finite and positive.
    StartBlocked, GoalBlocked, NoPath
        A robot cannot stand at its start or goal, or obstacles separate them.
    """
    robots = [robot for robot in scene.robots if scene.growth(robot) == growth]
    freespace = _coarse_freespace(scene, growth, robots)
    tenants = _tenants(robots)
    whole = visibility_graph(freespace, edges="all", points=list(tenants))
    weights = np.asarray(weight(whole.lengths), dtype=np.float64)
    if weights.shape != whole.lengths.shape or not (weights > 0).all() or not np.isfinite(weights.sum()):
        raise ValueError("weight must give every edge a positive weight, and their sum must be finite")
    n = len(whole.positions)
    number = {place: n - len(tenants) + k for k, place in enumerate(tenants)}
    ends = np.array([(number[robot.start], number[robot.goal]) for robot in robots], dtype=np.int64)

    shapes = [grown(obstacle, growth, freespace.arc_error) for obstacle in scene.obstacles]
    owner = _owners(whole, shapes, scene.tol)
    outline = _outline(freespace, whole, shapes, scene.tol)

    rooms = components(whole.graph)
    kept = np.isin(rooms, rooms[ends])
    renumbered = np.cumsum(kept) - 1
    inside = kept[whole.edges[:, 0]]
    positions = whole.positions[kept]
    roadmap = Roadmap(
        positions, Graph.from_edges(len(positions), renumbered[whole.edges[inside]], whole.lengths[inside])
    )
    group_of, members = _groups(owner[kept], _clusters(shapes, scene.tol), scene, tenants)
    names = _names(owner[kept], positions, scene, tenants)
    return Ground(
        freespace,
        roadmap,
        weights[inside],
        names,
        group_of,
        members,
        outline[inside],
        tuple(robot.name for robot in robots),
        renumbered[ends],
        int((~kept).sum()),
        whole.ends_only[kept],
    )


def _coarse_freespace(scene: Scene, growth: float, robots: Sequence[Robot]) -> FreeSpace:
    """Return the free space with as few vertices round corners as let every robot of this size through."""
    arc_error = _COARSEST
    while True:
        freespace = FreeSpace(scene, growth, arc_error)
        try:
            for robot in robots:
                freespace.require(robot)
        except (StartBlocked, GoalBlocked, NoPath):
            if arc_error <= _FINEST:
                raise
            arc_error = max(arc_error / 4, _FINEST)
        else:
            return freespace


def _tenants(robots: Sequence[Robot]) -> dict[Point, tuple[str, ...]]:
    """Places of starts and goals, in the order of the robots, and who starts or ends there."""
    out: dict[Point, tuple[str, ...]] = {}
    for robot in robots:
        for place, word in ((robot.start, "start"), (robot.goal, "goal")):
            out[place] = (*out.get(place, ()), f"{robot.name} {word}")
    return out


def _clusters(shapes: Sequence[shapely.Geometry], tol: float) -> Ints:
    """Number the obstacles so that those that touch have the same number, (k,)."""
    pairs = np.empty((0, 2), dtype=np.int64)
    if shapes:
        a, b = shapely.STRtree(shapes).query(shapes, predicate="dwithin", distance=tol)
        pairs = np.stack([a[a < b], b[a < b]], axis=1)
    return components(Graph.from_edges(len(shapes), pairs))


def _owners(whole: VisibilityGraph, shapes: Sequence[shapely.Geometry], tol: float) -> Ints:
    """The first obstacle that each vertex touches, (n,); −1 for starts, goals and corners of the workspace."""
    corners = np.flatnonzero(whole.wedges >= 0)
    out = np.full(len(whole.positions), len(shapes), dtype=np.int64)
    if shapes:
        points = shapely.points(whole.positions[corners])
        vertex, shape = shapely.STRtree(shapes).query(points, predicate="dwithin", distance=tol)
        np.minimum.at(out, corners[vertex], shape)
    out[out == len(shapes)] = -1
    return out


def _outline(freespace: FreeSpace, whole: VisibilityGraph, shapes: Sequence[shapely.Geometry], tol: float) -> Bools:
    """Whether each edge lies along the boundary of free space and on an obstacle, (m,)."""
    mesh, edges = freespace.mesh, whole.edges
    triangle, side = np.nonzero(mesh.neighbours < 0)
    walls = np.sort(
        np.stack([mesh.triangles[triangle, side], mesh.triangles[triangle, (side + 1) % 3]], axis=1), axis=1
    )
    size = len(mesh.vertices) + 1
    place = np.where(whole.wedges >= 0, mesh.wedges[whole.wedges, 0] if len(mesh.wedges) else -1, -1)
    ends = np.sort(place[edges], axis=1)
    out = (ends[:, 0] >= 0) & np.isin(ends[:, 0] * size + ends[:, 1], walls[:, 0] * size + walls[:, 1])
    along = np.flatnonzero(out)
    middles = shapely.points(whole.positions[edges[along]].mean(axis=1))
    touched = (
        shapely.STRtree(shapes).query(middles, predicate="dwithin", distance=tol)[0] if shapes else np.empty(0, int)
    )
    out[np.delete(along, touched)] = False
    return np.asarray(out)


def _groups(
    owner: Ints, clusters: Ints, scene: Scene, tenants: dict[Point, tuple[str, ...]]
) -> tuple[Ints, tuple[tuple[str, ...], ...]]:
    alone = owner < 0
    key = np.where(alone, len(clusters) + np.arange(len(owner)), clusters[owner] if len(clusters) else -1)
    _, first, group = np.unique(key, return_index=True, return_inverse=True)
    of_cluster: dict[int, list[str]] = {}
    for obstacle, cluster in zip(scene.obstacles, clusters.tolist(), strict=True):
        of_cluster.setdefault(cluster, []).append(obstacle.name)
    named = list(tenants.values())
    members = []
    for v in first.tolist():
        if alone[v]:
            k = v - (len(owner) - len(named))
            members.append(named[k] if k >= 0 else ())
        else:
            members.append(tuple(of_cluster[int(clusters[owner[v]])]))
    return np.asarray(group, dtype=np.int64), tuple(members)


def _names(owner: Ints, positions: Floats, scene: Scene, tenants: dict[Point, tuple[str, ...]]) -> tuple[str, ...]:
    named = list(tenants.values())
    out = []
    for v, (obstacle, (x, y)) in enumerate(zip(owner.tolist(), positions.tolist(), strict=True)):
        k = v - (len(owner) - len(named))
        if k >= 0:
            out.append(", ".join(named[k]))
        else:
            where = scene.obstacles[obstacle].name if obstacle >= 0 else "corner"
            out.append(f"{where} ({x:g}, {y:g})")
    return tuple(out)
