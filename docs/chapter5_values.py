"""What docs/chapter5.md tells: the paths that the thesis prints, and all that is computed beside them."""

from __future__ import annotations

import statistics
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np
import shapely

import taut
from taut.comparison import with_clearance
from taut.errors import NoPath
from taut.graph import Graph, dijkstra, path_to
from taut.route import CentralRoute, OcaRoute, Passage, Route
from taut.route.obstacles import obstacles_near
from taut.scene import FloatArray, Point, Rectangle, Robot, Scene
from taut.team import Replanned

SCENES = ("thesis-1", "thesis-2", "thesis-3")
D_S = 0.3  # metres, the safety distance of the tables
DELTA = 0.5  # metres, CA's δ
WIDER = 1.0  # metres by which the workspace is widened where D_s > 0
DISTANCES = (0.0, 0.1, 0.2, 0.3, 0.4, 0.5)
CROWDS = (10, 30, 100, 300)  # obstacles of the random maps
ELSEWHERE = (Rectangle(12.6, 3.0, 2.4, 3.0, name="O7"), Rectangle(0.1, 11.5, 0.7, 2.5, name="O8"))
ACROSS = (Rectangle(8.6, 11.0, 2.2, 0.5, name="O9"), Rectangle(8.3, 1.3, 1.2, 0.8, name="O10"))


@dataclass(frozen=True)
class Printed:
    """A path as the thesis prints it: table, scene, robot, waypoints, and the sum of whole-number weights."""

    table: str
    scene: str
    robot: str
    points: tuple[Point, ...]
    total: int


def _printed(table: str, scene: str, robot: str, points: str, total: int) -> Printed:
    pairs = [word.split(",") for word in points.split()]
    return Printed(table, scene, robot, tuple((float(x), float(y)) for x, y in pairs), total)


MRPPA = (
    _printed("5.1", "thesis-1", "R1", "2,1 4.5,4 3.3,7 3.2,9.5 5,16", 20),
    _printed("5.1", "thesis-1", "R2", "8.7,0.3 7.8,4 5,6 4.5,12.6 5,16", 20),
    _printed("5.1", "thesis-1", "R3", "11,1 10,5 9,7.5 10,10 10.8,12.9 5,16", 20),
    _printed("5.3", "thesis-2", "R1", "3,1 4.5,4 7.5,6 10,5 9,7.5 10,10 12,12.7", 18),
    _printed("5.3", "thesis-2", "R2", "3.4,16 4.5,12.6 5,6 7.8,4 11,1", 20),
    _printed("5.3", "thesis-2", "R3", "8.7,0.3 7.8,4 5,6 3.2,9.5 2,8.5 0.5,9", 15),
    _printed("5.5", "thesis-3", "R1", "10.6,4 7,6.5 4.5,9.5 1.5,10.5", 15),
    _printed("5.5", "thesis-3", "R2", "9.5,11.44 6.8,9.5 5,6.5 1,3.51", 14),
    _printed("5.5", "thesis-3", "R3", "6.2,1.38 10,3.5 7,6.5 10,6.5 11.65,11.29", 15),
)
CENTRAL = (
    _printed("5.7", "thesis-2", "R1", "3.5,1 3.9,5.1 7.3,4.7 8.3,6.8 10,11.5", 10),
    _printed("5.7", "thesis-2", "R2", "3.4,13 4.8,9 4.9,5.9 7.3,4.7 8.6,2.5", 9),
    _printed("5.7", "thesis-2", "R3", "8,0.8 7.3,4.7 4.9,5.9 3.6,7.4 1.9,9.7", 8),
    _printed("5.9", "thesis-3", "R1", "9.4,3.8 9.5,6.8 6.9,7.3 4.6,8.5 3.5,10.5", 9),
    _printed("5.9", "thesis-3", "R2", "8.5,11.44 7.9,9.5 6.3,9 4,6 3,3.51", 7),
    _printed("5.9", "thesis-3", "R3", "7.3,3 7.4,5 9.5,6.8 10.2,7.5 11.65,10.29", 10),
)
OCA = (
    _printed("5.11", "thesis-2", "R1", "3.5,1 3.9,4.7 5.4,9.4 9.6,11.2", 9),
    _printed("5.11", "thesis-2", "R2", "3.66,12.85 6.8,9.5 8.3,7.5 8.6,2.5", 7),
    _printed("5.11", "thesis-2", "R3", "8,0.8 7.3,4.7 4.85,5.98 3.6,7.4 2.3,9.87", 8),
)
EDGES = {"thesis-1": ("108", "–"), "thesis-2": ("99", "70"), "thesis-3": ("85", "67")}
"""Edges in the thesis: of the visibility graph, and by CA."""


@dataclass(frozen=True)
class Crowd:
    """One random map: how many of CA's paths are free, hit something, or are none; what OCA took for the same robots.

    Parameters
    ----------
    longer : length of free CA paths over the shortest, median.
    once : how many shortest paths among only the obstacles that the baseline crosses are free.
    used, rounds : of OCA, mean share of the obstacles and mean number.
    differ : how many of OCA's lengths differ from those of the whole map by more than 10⁻¹² relative.
    """

    obstacles: int
    robots: int
    free: int
    hit: int
    lost: int
    longer: float
    once: int
    used: float
    rounds: float
    differ: int


@dataclass(frozen=True)
class Chapter:
    """All that the page tells.

    Parameters
    ----------
    plain, wide : the scenes as they are, and with D_s in a workspace widened by `WIDER`.
    shortest, central : of point robots in the plain scenes, by scene and robot.
    oca : with D_s in the wide scenes.
    grown_central, once : what the thesis' OCA hits, read as CA on grown obstacles and as the visibility graph of the
        grown obstacles that the baseline crosses; None where there is no path; by distance, one a robot.
    lengths : of OCA, by distance, scene and robot; what is wrong where there is no path.
    passages : the widest way of every robot in the wide scenes.
    all_edges, tight : vertices and edges of the visibility graph of a plain scene; OCA there without D_s.
    elsewhere, across : the plan of scene 2 with D_s after obstacles were added.
    crowds : random maps.
    """

    plain: Mapping[str, Scene]
    wide: Mapping[str, Scene]
    shortest: Mapping[str, Mapping[str, Route]]
    central: Mapping[str, Mapping[str, CentralRoute]]
    oca: Mapping[str, Mapping[str, OcaRoute]]
    grown_central: Mapping[float, Sequence[tuple[str, ...] | None]]
    once: Mapping[float, Sequence[tuple[str, ...] | None]]
    lengths: Mapping[float, Mapping[str, Mapping[str, float | str]]]
    passages: Mapping[str, Mapping[str, Passage]]
    all_edges: Mapping[str, tuple[int, int]]
    tight: Mapping[str, Mapping[str, OcaRoute]]
    elsewhere: Replanned
    across: Replanned
    crowds: Sequence[Crowd]


def chapter() -> Chapter:
    """Compute all that the page tells."""
    plain = {name: taut.load_scene(name) for name in SCENES}
    wide = {name: with_clearance(widened(scene, WIDER), D_S) for name, scene in plain.items()}
    old = taut.plan(wide["thesis-2"], roadmap="oca").plan
    lengths: dict[float, dict[str, dict[str, float | str]]] = {}
    grown: dict[float, list[tuple[str, ...] | None]] = {}
    once: dict[float, list[tuple[str, ...] | None]] = {}
    for distance in DISTANCES:
        scenes = {name: with_clearance(scene, distance) for name, scene in wide.items()}
        lengths[distance] = {
            name: {robot.name: _length(scene, robot) for robot in scene.robots} for name, scene in scenes.items()
        }
        each = [(scene, robot) for scene in scenes.values() for robot in scene.robots]
        grown[distance] = [_hit(scene, robot) for scene, robot in each]
        once[distance] = [_hit_once(scene, robot) for scene, robot in each]
    return Chapter(
        plain,
        wide,
        {name: {r.name: _shortest(scene, r) for r in scene.robots} for name, scene in plain.items()},
        {name: {r.name: taut.central_path(scene, r, DELTA) for r in scene.robots} for name, scene in plain.items()},
        {name: {r.name: taut.oca_path(scene, r) for r in scene.robots} for name, scene in wide.items()},
        grown,
        once,
        lengths,
        {
            name: {r.name: taut.widest_passage(scene, r.start, r.goal) for r in scene.robots}
            for name, scene in wide.items()
        },
        {name: _all_edges(scene) for name, scene in plain.items()},
        {name: {r.name: taut.oca_path(scene, r) for r in scene.robots} for name, scene in plain.items()},
        added(old, ELSEWHERE),
        added(old, ACROSS),
        [crowd(count) for count in CROWDS],
    )


def widened(scene: Scene, by: float) -> Scene:
    """Return the scene in a rectangular workspace that reaches ``by`` metres farther on every side."""
    (x0, y0), (x1, y1) = np.min(scene.workspace, axis=0) - by, np.max(scene.workspace, axis=0) + by
    return replace(scene, workspace=((x0, y0), (x1, y0), (x1, y1), (x0, y1)))


def added(plan: taut.Plan, obstacles: Iterable[Rectangle]) -> Replanned:
    """Return what becomes of a plan when obstacles are added to its map, together."""
    return taut.replan(plan, replace(plan.scene, obstacles=(*plan.scene.obstacles, *obstacles)))


def crowd(count: int) -> Crowd:
    """Ask CA and OCA for the paths of 30 point robots on a random map."""
    scene = taut.random_scene(robots=30, obstacles=count, seed=1, radius=0.0)
    freespace = taut.FreeSpace(scene)
    index = taut.index_obstacles(scene)
    free: list[float] = []
    lost = differ = 0
    routes = []
    for robot in scene.robots:
        route = taut.oca_path(index, robot)
        routes.append(route)
        length = taut.shortest_path(freespace, robot.start, robot.goal).length
        differ += abs(route.length - length) > 1e-12 * length
        try:
            central = taut.central_path(index, robot, DELTA)
        except NoPath:
            lost += 1
        else:
            free += [central.length / length] * central.free
    return Crowd(
        count,
        len(scene.robots),
        len(free),
        len(scene.robots) - len(free) - lost,
        lost,
        statistics.median(free),
        sum(_hit_once(scene, robot) == () for robot in scene.robots),
        statistics.fmean(len(route.used) / count for route in routes),
        statistics.fmean(len(route.rounds) for route in routes),
        differ,
    )


def sides_of(route: CentralRoute) -> dict[int, Route | None]:
    """The shortest paths over waypoints on the left (+1) and on the right (−1) only."""
    out: dict[int, Route | None] = {}
    places, edges = route.roadmap.positions, route.roadmap.edges
    for side in (1, -1):
        on = np.array([True, True, *(waypoint.side == side for waypoint in route.waypoints)])
        kept = on[edges].all(axis=1)
        distance, before = dijkstra(Graph.from_edges(len(places), edges[kept], route.roadmap.lengths[kept]), 0)
        out[side] = Route(places[path_to(before, 1)]) if np.isfinite(distance[1]) else None
    return out


def clearance_of(scene: Scene, points: FloatArray) -> float:
    """Return the least distance of a path from the obstacles, all of them polygons."""
    path = shapely.LineString(points)
    return min(float(path.distance(shapely.Polygon(obstacle.core))) for obstacle in scene.obstacles)


def _shortest(scene: Scene, robot: Robot) -> Route:
    return taut.shortest_path(taut.FreeSpace.of(scene, robot), robot.start, robot.goal)


def _length(scene: Scene, robot: Robot) -> float | str:
    try:
        return taut.oca_path(scene, robot).length
    except (NoPath, taut.SceneError):
        return "none"


def _hit(scene: Scene, robot: Robot) -> tuple[str, ...] | None:
    """Names of what the path of CA hits; None if it finds no path."""
    try:
        route = taut.central_path(scene, robot, DELTA)
    except NoPath:
        return None
    return tuple(name for hit in route.hits for name in hit.obstacles)


def _hit_once(scene: Scene, robot: Robot) -> tuple[str, ...] | None:
    """Names of what the shortest path among only the obstacles that the baseline meets hits; None if there is none."""
    ends, growth = np.array([robot.start, robot.goal]), scene.growth(robot)
    near = obstacles_near(taut.index_obstacles(scene), ends, growth)
    few = scene.with_obstacles([scene.obstacles[k] for k in near])
    try:
        points = taut.shortest_path(taut.FreeSpace(few, growth), robot.start, robot.goal).points
    except NoPath:
        return None
    return tuple(name for hit in taut.hits_of(scene, points, growth) for name in hit.obstacles)


def _all_edges(scene: Scene) -> tuple[int, int]:
    ends = list(dict.fromkeys(place for robot in scene.robots for place in (robot.start, robot.goal)))
    graph = taut.visibility_graph(taut.FreeSpace(scene), edges="all", points=ends).graph
    return graph.n, graph.m
