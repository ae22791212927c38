"""How the Central Algorithm and OCA come to a robot's route: baseline, obstacles crossed, waypoints, graphs, rounds."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np

from taut.errors import NoPath
from taut.roadmap import visibility_graph
from taut.route import CentralRoute, NoCentralPath, OcaRoute, central_path, oca_path
from taut.route.central import Crossed
from taut.route.oca import OcaRound
from taut.scene import Robot, Scene
from taut.studio import marks

DELTA = 0.5
"""Metres by which waypoints are farther from the baseline than any point of their obstacle."""

FEW = 8
"""Up to so many waypoints that were dropped are told why on the map."""


def central_steps(scene: Scene, robot: Robot) -> dict[str, Any]:
    """Return the steps of the Central Algorithm for a robot.

    Where its waypoints offer no way the last step says so: it is not complete.

    Raises
    ------
    StartBlocked, GoalBlocked
        The robot cannot stand at its start or goal.
    """
    growth = scene.growth(robot)
    try:
        route = central_path(scene, robot, DELTA)
    except NoCentralPath as error:
        none = marks.step("No way", [f"{error}."], marks=[_names_of(error.crossed, "hit")])
        return _told([*_until_crossed(scene, robot, error.crossed), none])
    steps = _until_crossed(scene, robot, route.crossed)
    if route.crossed:
        steps += [_waypoints(route, growth), _partial_graph(route)]
    return _told([*steps, _central_end(scene, robot, route)])


def oca_steps(scene: Scene, robot: Robot) -> dict[str, Any]:
    """Return the steps of OCA for a robot: the baseline, each round, the route with its proof.

    Raises
    ------
    StartBlocked, GoalBlocked, NoPath
        As `taut.oca_path`.
    """
    route = oca_path(scene, robot)
    first = route.rounds[0]
    near = (
        f"It touches {marks.count(len(first.added), 'obstacle')}: only they are taken in at first."
        if first.added
        else "It touches no obstacle."
    )
    steps = [
        marks.step(
            "Baseline",
            [f"The straight line from start to goal of {robot.name} shows which obstacles matter first. {near}"],
            {"length": marks.metres(_length([robot.start, robot.goal])), "obstacles": str(route.total)},
            stays=[marks.path([robot.start, robot.goal], "baseline")],
            marks=[marks.obstacles(first.added, "hit")],
        )
    ]
    known: list[str] = []
    for number, now in enumerate(route.rounds, 1):
        known += now.added
        steps.append(_round(scene, robot, route, now, number, known))
    roadmap = visibility_graph(route.freespace, points=list(dict.fromkeys([robot.start, robot.goal])))
    steps.append(
        marks.step(
            "Partial graph",
            [
                "The visibility graph of the obstacles taken in: a small part of that of the whole map.",
                f"{marks.count(len(roadmap.positions), 'vertex', 'vertices')} and "
                f"{marks.count(roadmap.graph.m, 'edge')}.",
            ],
            {"vertices": str(len(roadmap.positions)), "edges": str(roadmap.graph.m)},
            marks=[
                marks.edges(roadmap.positions, roadmap.edges, "graph"),
                marks.path(route.points, "path", robot=robot.name),
            ],
        )
    )
    steps.append(
        marks.step(
            "Shortest route",
            [
                f"The route hits nothing that was left out, so it is the shortest on the whole map: leaving obstacles "
                f"out could only have made it shorter. {len(route.used)} of {route.total} obstacles were enough.",
            ],
            {"length": marks.metres(route.length), "obstacles": f"{len(route.used)} of {route.total}"},
            marks=[marks.path(route.points, "path", robot=robot.name)],
        )
    )
    return _told(steps)


def _told(steps: Sequence[marks.Step]) -> dict[str, Any]:
    return {"base": [], "points": [], "steps": list(steps)}


def _until_crossed(scene: Scene, robot: Robot, crossed: Sequence[Crossed]) -> list[marks.Step]:
    """Obstacles grown, the baseline, and the obstacles that it crosses."""
    growth = scene.growth(robot)
    line = [robot.start, robot.goal]
    met = marks.listed([one.name for one in crossed])
    steps = [
        marks.step(
            "Grown obstacles",
            [
                f"Obstacles grow by radius + clearance of {robot.name}, {growth:g} m: then the robot is a point."
                if growth
                else f"{robot.name} is a point without clearance: obstacles are as they are.",
            ],
            {"growth": f"{growth:g} m"},
            stays=[marks.grown_obstacles(scene, scene.obstacles, growth)] if scene.obstacles and growth else [],
        ),
        marks.step(
            "Baseline",
            [f"The straight line from start to goal: if {robot.name} could go along it, nothing would be shorter."],
            {"length": marks.metres(_length(line))},
            stays=[marks.path(line, "baseline")],
        ),
    ]
    if not crossed:
        free = "It crosses no obstacle: nothing is in the way."
        return [*steps, marks.step("Crossed obstacles", [free], {"crossed": "0"})]
    places = np.concatenate([one.crossings for one in crossed])
    told = [
        f"The baseline crosses {met}; no other obstacle will be looked at.",
        "Where it enters or leaves one there is a point u. "
        + " ".join(f"{one.name} reaches m = {one.reach:.3f} m from the line." for one in crossed[:4]),
    ]
    numbers = {"crossed": f"{len(crossed)} of {len(scene.obstacles)}", "points u": str(len(places))}
    shown = [_names_of(crossed, "hit"), marks.vertices(places, "hit")]
    return [*steps, marks.step("Crossed obstacles", told, numbers, stays=shown)]


def _names_of(crossed: Sequence[Crossed], role: str) -> marks.Mark:
    return marks.obstacles([one.name for one in crossed], role)


def _waypoints(route: CentralRoute, growth: float) -> marks.Step:
    every = [*route.waypoints, *(waypoint for waypoint, _ in route.dropped)]
    crossings = {one.name: one.crossings for one in route.crossed}
    ties = np.array([(crossings[w.obstacle][w.crossing], w.place) for w in every]).reshape(-1, 2)
    pairs = np.arange(len(ties)).reshape(-1, 2)
    story = [
        "From every u a waypoint u′ = u ± (m + δ) n is set on either side, far enough out to pass the obstacle: "
        f"n is across the line, and δ = {DELTA:g} m."
    ]
    reasons = [f"near ({w.place[0]:.2f}, {w.place[1]:.2f}): {why}" for w, why in route.dropped]
    if reasons:
        story.append(f"Dropped: {marks.listed(reasons, 4)}.")
    stays = [marks.vertices([w.place for w in route.waypoints], "waypoint")]
    few = {"labels": [why for _, why in route.dropped]} if len(route.dropped) <= FEW else {}
    dropped = marks.vertices([w.place for w, _ in route.dropped], "dropped", **few)
    return marks.step(
        "Waypoints",
        story,
        {"waypoints": str(len(route.waypoints)), "dropped": str(len(route.dropped)), "grown by": f"{growth:g} m"},
        stays=stays,
        marks=[marks.edges(ties, pairs, "faint"), dropped],
    )


def _partial_graph(route: CentralRoute) -> marks.Step:
    graph = route.roadmap.graph
    return marks.step(
        "Partial visibility graph",
        ["Start, goal and waypoints are joined by every straight way that passes no crossed obstacle."],
        {"vertices": str(graph.n), "edges": str(graph.m)},
        stays=[marks.edges(route.roadmap.positions, route.roadmap.edges, "graph")],
    )


def _central_end(scene: Scene, robot: Robot, route: CentralRoute) -> marks.Step:
    """The path, what it hits, and how much longer it is than it need be."""
    numbers = {"length": marks.metres(route.length)}
    story = ["Dijkstra's algorithm finds the shortest path in this small graph."]
    try:
        shortest = oca_path(scene, robot).length
    except NoPath:
        story.append("On the whole map there is no way at all.")
    else:
        numbers["shortest"] = marks.metres(shortest)
        if not route.hits and shortest > 0:
            numbers["longer by"] = f"{100 * (route.length / shortest - 1):.1f} %"
    shown = [marks.path(route.points, "path", robot=robot.name)]
    if route.hits:
        names = list(dict.fromkeys(name for hit in route.hits for name in hit.obstacles))
        story.append(f"It hits {marks.listed(names)}, which the baseline did not cross: CA has not looked at them.")
        numbers["hits"] = str(len(names))
        shown.append(marks.obstacles([name for name in names if name in {o.name for o in scene.obstacles}], "hit"))
        shown.append(marks.vertices([hit.place for hit in route.hits], "hit"))
        shown += [marks.note(hit.place, "hits " + " and ".join(hit.obstacles)) for hit in route.hits]
    else:
        story.append("It is free on the whole map, though it need not be the shortest.")
    return marks.step("Path", story, numbers, marks=shown)


def _round(scene: Scene, robot: Robot, route: OcaRoute, now: OcaRound, number: int, known: Sequence[str]) -> marks.Step:
    taken = [obstacle for obstacle in scene.obstacles if obstacle.name in set(known)]
    coarse = now.arc_error != route.freespace.arc_error
    # arcs drawn coarsely reach no farther than those drawn finely
    reach = route.growth / (1 + now.arc_error) if coarse else route.growth
    story = [
        f"The shortest route among {marks.count(len(known), 'obstacle')}"
        + (f" hits {marks.listed(now.hit)}: taken in next." if now.hit else " hits nothing that was left out.")
    ]
    if coarse:
        story.append(
            "Round corners are drawn coarsely as yet, to find obstacles fast; the last rounds draw them finely."
        )
    stays = [marks.path([robot.start, robot.goal], "baseline"), marks.obstacles(known, "used")]
    if taken and reach > 0:
        stays.append(marks.grown_obstacles(scene, taken, reach, now.arc_error))
    shown = [marks.path(now.points, "path", robot=robot.name)]
    if now.hit:
        shown.append(marks.obstacles(now.hit, "hit"))
    return marks.step(
        f"Round {number}",
        story,
        {
            "obstacles": f"{len(known)} of {route.total}",
            "length": marks.metres(_length(now.points)),
            "hit": str(len(now.hit)),
            "triangles searched": str(now.expanded),
        },
        stays=stays,
        marks=shown,
        fresh=True,
    )


def _length(points: Any) -> float:
    return float(np.hypot(*np.diff(np.asarray(points, dtype=np.float64), axis=0).T).sum())
