"""Routes of single robots on their map; those of CA and OCA with all that they were made of."""

from __future__ import annotations

from collections.abc import Collection, Mapping, Sequence
from typing import Any, Literal, TypeAlias

import numpy as np
from matplotlib.axes import Axes
from matplotlib.collections import LineCollection, PathCollection
from matplotlib.lines import Line2D

from taut.figures.labels import Label, write
from taut.figures.maps import draw_map, name_obstacles, outlines, polygon_path
from taut.figures.pictures import handle, write_legend, write_title
from taut.figures.plans import draw_arrows, draw_paths, line_width, samples
from taut.figures.style import GOAL, GRAPH, GROWN, INK, OBSTACLE, OBSTACLE_EDGE, START, Colour, mix, robot_colours
from taut.figures.teams import FEW_ROBOTS, draw_ends, end_marks, start_labels
from taut.geometry.growth import grown
from taut.roadmap import Roadmap, visibility_graph
from taut.route import Route
from taut.route.central import CentralRoute
from taut.route.oca import OcaRoute
from taut.scene import FloatArray, Robot, Scene

Step: TypeAlias = Literal["baseline", "waypoints", "graph", "path"]
STEPS: tuple[Step, ...] = ("baseline", "waypoints", "graph", "path")
"""What is drawn of a route, each on top of those before it."""

CROSSING: Colour = "#7d858f"
WAYPOINT: Colour = "#1d57c4"
HIT: Colour = "#b0101f"
UNUSED: Colour = mix(OBSTACLE, "#ffffff", 0.62)

_EDGES = {OBSTACLE: OBSTACLE_EDGE, UNUSED: mix(OBSTACLE_EDGE, "#ffffff", 0.5)}
_LONG, _DOTS, _GAPS = (0, (6, 3)), (0, (1, 2.2)), (0, (3, 2))
_MOST_EDGES = 6000  # beyond, the graph is ink without shape


def draw_routes(axes: Axes, scene: Scene, routes: Mapping[str, Route]) -> None:
    """Draw the map and routes of some of its robots, with title and legend.

    Of CA: the baseline, entries and exits u, waypoints (dropped ones hollow), the partial visibility graph, the path,
    and where it hits an obstacle. Of OCA: obstacles grown, the partial graph, the path. Obstacles that no route
    was made of are pale. Of any other route: the path.

    Parameters
    ----------
    axes : with limits set.
    scene : the world of the routes.
    routes : by the name of the robot.

    Raises
    ------
    ValueError
        A route of a robot that is not there.
    """
    draw_steps(axes, scene, routes, "path")
    write_title(axes, scene.name, *_facts(routes))
    write_legend(axes, handles_of(list(routes.values()), "path"))


def draw_steps(axes: Axes, scene: Scene, routes: Mapping[str, Route], upto: Step) -> None:
    """Draw the map and routes of some of its robots up to a step of their making.

    Parameters
    ----------
    axes : with limits set.
    scene : the world of the routes.
    routes : by the name of the robot.
    upto : the last step to draw.

    Raises
    ------
    ValueError
        A route of a robot that is not there.
    """
    colours = dict(zip((r.name for r in scene.robots), robot_colours(len(scene.robots)), strict=True))
    for name in routes:
        if name not in colours:
            raise ValueError(f"a route of robot {name}, which the scene does not have; it has {', '.join(colours)}")
    robots = {robot.name: robot for robot in scene.robots}
    draw_map(axes, scene)
    _tell_used(axes, scene, [(route, robots[name]) for name, route in routes.items()])
    for name, route in routes.items():
        draw_parts(axes, route, colours[name], upto)
    if upto == "path":
        paths, hues = [route.points for route in routes.values()], [colours[name] for name in routes]
        draw_paths(axes, paths, hues, line_width(len(robots)))
        draw_arrows(axes, paths, hues)
        _draw_hits(axes, list(routes.values()))
    _draw_names(axes, scene, routes, colours, upto)


def draw_route(axes: Axes, route: CentralRoute | OcaRoute) -> None:
    """Draw one route of CA or OCA without the name of its robot, on all of the map that it knows."""
    if isinstance(route, OcaRoute):
        scene = route.freespace.scene
        draw_map(axes, scene)
        draw_bands(axes, scene, {route.growth: set(route.used)}, route.freespace.arc_error)
        name_obstacles(axes, scene)
    else:
        axes.set_facecolor("white")
    colour = robot_colours(1)[0]
    draw_parts(axes, route, colour, "path")
    draw_paths(axes, [route.points], [colour])
    draw_arrows(axes, [route.points], [colour])
    _draw_hits(axes, [route])
    draw_two_ends(axes, route)
    write_title(axes, "", _fact("", route).strip())
    write_legend(axes, handles_of([route], "path"))


def draw_two_ends(axes: Axes, route: Route) -> None:
    """Draw the start (red, round) and the goal (green, a diamond) of a route."""
    for (x, y), hue, marker in ((route.points[-1], GOAL, "D"), (route.points[0], START, "o")):
        axes.scatter([x], [y], s=36, c=hue, marker=marker, edgecolors="white", linewidths=0.8, zorder=6)


def draw_parts(axes: Axes, route: Route, colour: Colour, upto: Step) -> None:
    """Draw what a route of CA or OCA was made of, without its path; nothing of any other route."""
    shown = STEPS[: STEPS.index(upto) + 1]
    if isinstance(route, CentralRoute):
        _line(axes, [route.baseline], START, 1.0, _LONG, 3.1)
        _dots(axes, [u for crossed in route.crossed for u in crossed.crossings], CROSSING, CROSSING, 15)
        if "waypoints" in shown:
            _draw_waypoints(axes, route)
        if "graph" in shown:
            _draw_edges(axes, route.roadmap, colour)
    elif isinstance(route, OcaRoute):
        ends = route.points[[0, -1]]
        _line(axes, [ends], START, 1.0, _LONG, 3.1)
        if "graph" in shown:
            _draw_edges(axes, partial_graph(route), colour)


def tint_obstacles(axes: Axes, tints: Sequence[Colour]) -> None:
    """Give the obstacles of a map just drawn these colours."""
    axes.collections[-1].set(facecolors=tints, edgecolors=[_EDGES.get(tint, mix(tint, INK, 0.4)) for tint in tints])


def name_tinted(axes: Axes, scene: Scene, pale: Collection[str]) -> None:
    """Write the names of few obstacles into them, dark into those that are pale."""
    known = len(axes.texts)
    name_obstacles(axes, scene)
    for text in axes.texts[known:]:
        if text.get_text() in pale:
            text.set_color(OBSTACLE_EDGE)


def draw_bands(axes: Axes, scene: Scene, used: Mapping[float, set[str]], arc_error: float) -> None:
    """Draw obstacles grown by each amount: those used filled, the others as a dashed outline."""
    for growth, names in used.items():
        if growth == 0:
            continue
        for taken, face, edge, width, dashes in (
            (False, "none", GRAPH, 0.6, _GAPS),
            (True, GROWN, OBSTACLE_EDGE, 0.6, "-"),
        ):
            chosen = [o for o in scene.obstacles if (o.name in names) == taken]
            paths = [polygon_path(grown(o, growth, arc_error, tol=scene.tol)) for o in chosen]
            style: dict[str, Any] = {
                "facecolors": face,
                "edgecolors": edge,
                "linewidths": width,
                "linestyles": [dashes],
            }
            band = PathCollection(paths, zorder=1.4 + 0.1 * taken, **style)
            band.set_clip_path(axes.patch)
            axes.add_collection(band, autolim=False)


def partial_graph(route: OcaRoute) -> Roadmap:
    """Return the tangent graph of the obstacles that OCA used, with start and goal as its last vertices."""
    return visibility_graph(route.freespace, points=route.points[[0, -1]])


def handles_of(routes: Sequence[Route], upto: Step) -> list[Line2D]:
    """Return the marks of the legend for such routes."""
    shown = STEPS[: STEPS.index(upto) + 1]
    central = [route for route in routes if isinstance(route, CentralRoute)]
    oca = [route for route in routes if isinstance(route, OcaRoute)]
    out = [handle("start", "o", START, "white"), handle("goal", "D", GOAL, "white")]
    if central or oca:
        out.append(Line2D([], [], color=START, linewidth=1.0, linestyle=_LONG, label="baseline"))
    if any(route.crossed for route in central):
        out.append(handle("entry or exit", "o", CROSSING, "white"))
        if "waypoints" in shown:
            out.append(handle("waypoint", "o", WAYPOINT, "white"))
    if "waypoints" in shown and any(route.dropped for route in central):
        out.append(handle("dropped", "o", "white", WAYPOINT))
    if "graph" in shown and (central or oca):
        out.append(Line2D([], [], color=GRAPH, linewidth=1.0, label="partial graph"))
    if oca:
        out.append(handle("obstacle used", "s", OBSTACLE, OBSTACLE_EDGE))
        if any(route.growth > 0 for route in oca):
            out.append(handle("grown", "s", GROWN, OBSTACLE_EDGE))
    if upto == "path" and any(route.hits for route in central):
        out.append(handle("hits an obstacle", "X", HIT, "white"))
    return out


def _tell_used(axes: Axes, scene: Scene, routes: Sequence[tuple[Route, Robot]]) -> None:
    """Draw obstacles that no route was made of paler, the others in the band by which they grew; name them."""
    used: dict[float, set[str]] = {}
    error = 1e-3
    for route, robot in routes:
        if isinstance(route, CentralRoute):
            used.setdefault(scene.growth(robot), set()).update(crossed.name for crossed in route.crossed)
        elif isinstance(route, OcaRoute):
            error = route.freespace.arc_error
            used.setdefault(route.growth, set()).update(route.used)
    names = set().union(*used.values())
    if used:
        tints = [OBSTACLE if obstacle.name in names else UNUSED for obstacle in scene.obstacles]
        edges = [
            OBSTACLE_EDGE if obstacle.name in names else mix(OBSTACLE_EDGE, "#ffffff", 0.5)
            for obstacle in scene.obstacles
        ]
        axes.collections[-1].set(facecolors=tints, edgecolors=edges)  # the obstacles, drawn last
    draw_bands(axes, scene, used, error)
    known = len(axes.texts)
    name_obstacles(axes, scene)
    for text in axes.texts[known:]:
        if used and text.get_text() not in names:
            text.set_color(OBSTACLE_EDGE)


def _draw_waypoints(axes: Axes, route: CentralRoute) -> None:
    u_of = {crossed.name: crossed.crossings for crossed in route.crossed}
    kept, dropped = list(route.waypoints), [waypoint for waypoint, _ in route.dropped]
    ties = [np.array([u_of[w.obstacle][w.crossing], w.place]) for w in (*kept, *dropped)]
    _line(axes, ties, WAYPOINT, 0.7, _DOTS, 3.3)
    _dots(axes, [np.array(w.place) for w in dropped], "white", WAYPOINT, 22)
    _dots(axes, [np.array(w.place) for w in kept], WAYPOINT, "white", 26)


def _draw_edges(axes: Axes, roadmap: Roadmap, colour: Colour) -> None:
    edges = roadmap.edges
    if len(edges) > _MOST_EDGES:
        return
    # the more edges, the thinner
    width, alpha = (
        float(np.clip(8 * len(edges) ** -0.45, 0.25, 0.9)),
        float(np.clip(7 * len(edges) ** -0.4, 0.35, 0.85)),
    )
    ends = roadmap.positions[edges]
    style: dict[str, Any] = {"colors": mix(colour, "#ffffff", 0.3), "linewidths": width, "alpha": alpha}
    axes.add_collection(LineCollection(list(ends), zorder=2.8, **style), autolim=False)


def _draw_hits(axes: Axes, routes: Sequence[Route]) -> None:
    places = [np.array(hit.place) for route in routes if isinstance(route, CentralRoute) for hit in route.hits]
    if places:
        x, y = np.array(places).T
        axes.scatter(x, y, s=75, c=HIT, marker="X", edgecolors="white", linewidths=0.9, zorder=7.5)


def _draw_names(
    axes: Axes, scene: Scene, routes: Mapping[str, Route], colours: Mapping[str, Colour], upto: Step
) -> None:
    n = len(scene.robots)
    draw_ends(axes, scene, ["#ffffff"] * n)
    if n > FEW_ROBOTS:
        return
    labels: list[Label] = []
    marks = end_marks(axes, scene.robots, n)
    if upto == "path":
        for route in routes.values():
            for hit in route.hits if isinstance(route, CentralRoute) else ():
                labels.append(Label("hits " + ", ".join(hit.obstacles), hit.place, 4.5, HIT, size=7.5))
                marks.append((hit.place, 4.5))
    labels += start_labels(axes, scene, [r.name for r in scene.robots], list(colours.values()))
    lines = [route.points for route in routes.values()] if upto == "path" else []
    lines += [route.points[[0, -1]] for route in routes.values()]
    for route in routes.values():
        if isinstance(route, CentralRoute) and upto != "baseline":
            marks += [(w.place, 2.5) for w in (*route.waypoints, *(w for w, _ in route.dropped))]
    write(axes, labels, marks, samples(axes, [*lines, *outlines(scene)]))


def _facts(routes: Mapping[str, Route]) -> list[str]:
    long = " · ".join(_fact(name, route) for name, route in routes.items())
    middle = long.replace(" obstacles", "")
    short = " · ".join(f"{name} {route.length:.2f} m" for name, route in routes.items())
    total = f"{sum(route.length for route in routes.values()):.2f} m in all"
    return [long, middle, short, total]


def _fact(name: str, route: Route) -> str:
    text = f"{name} {route.length:.2f} m"
    if isinstance(route, CentralRoute):
        hit = dict.fromkeys(obstacle for hit in route.hits for obstacle in hit.obstacles)
        return text + (f", hits {', '.join(hit)}" if hit else "")
    if isinstance(route, OcaRoute):
        return f"{text}, {len(route.used)} of {route.total} obstacles"
    return text


def _line(axes: Axes, lines: Sequence[FloatArray], colour: Colour, width: float, dashes: Any, zorder: float) -> None:
    style: dict[str, Any] = {"colors": colour, "linewidths": width, "linestyles": [dashes], "zorder": zorder}
    axes.add_collection(LineCollection(list(lines), **style), autolim=False)


def _dots(axes: Axes, places: Sequence[FloatArray], face: Colour, edge: Colour, size: float) -> None:
    if places:
        x, y = np.array(places).T
        axes.scatter(x, y, s=size, c=face, edgecolors=edge, linewidths=0.9, zorder=5)
