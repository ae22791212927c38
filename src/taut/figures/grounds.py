"""The graph of a stage on its map: sides in their hues, edges, vertices, robots, and what is written beside them."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import replace
from typing import Literal, TypeAlias

import numpy as np
import shapely
from matplotlib.axes import Axes
from matplotlib.collections import LineCollection
from matplotlib.lines import Line2D
from matplotlib.patheffects import withStroke

from taut.figures.canvas import points_per_metre
from taut.figures.labels import Label, text_size, write
from taut.figures.maps import FEW_OBSTACLES, draw_free_space, draw_map, name_obstacles, obstacle_path, outlines
from taut.figures.plans import samples
from taut.figures.style import GRAPH, INK, START, Colour, darker, mix, robot_colours
from taut.figures.teams import FEW_ROBOTS, draw_ends, end_marks, goal_labels, reach, start_labels
from taut.graph.core import Floats, Ints
from taut.scene import Obstacle, Point, Scene
from taut.team.ground import Bools, Ground
from taut.team.stages import SplitStage

#: Hues of the two sides, ochre and blue, told apart with every kind of colour blindness; side True is blue.
SIDES: tuple[Colour, Colour] = ("#b8720a", "#2f5e9e")
CASING: Colour = "#ffffff"
FAINT = 0.55  # how far towards white the sides are behind bridges and paths
FEW_VERTICES = 40  # up to this many are numbered

Dashes: TypeAlias = Literal["-", "--", ":"] | tuple[float, tuple[float, ...]]


def team_of(ground: Ground) -> Scene:
    """Return the scene with the robots of this size only."""
    scene = ground.freespace.scene
    return replace(scene, robots=tuple(robot for robot in scene.robots if robot.name in ground.robots))


def colour_of(ground: Ground, robot: str) -> Colour:
    """Return the colour that the robot has in all pictures of its scene."""
    names = [r.name for r in ground.freespace.scene.robots]
    return robot_colours(len(names))[names.index(robot)]


def banded(ground: Ground) -> bool:
    """Return whether obstacles are drawn in a band: they are grown, or their round sides are made straight."""
    space = ground.freespace
    return space.growth > 0 or any(obstacle.own_radius > 0 for obstacle in space.scene.obstacles)


def draw_ground(axes: Axes, ground: Ground) -> None:
    """Draw the map, and the band round obstacles that the centre of a robot of this size cannot use."""
    space = ground.freespace
    if banded(ground):
        draw_free_space(axes, space.region, space.scene)
    else:
        draw_map(axes, space.scene)


def draw_graph_so_far(axes: Axes, split: SplitStage, edges: Bools, bridge: str) -> list[Line2D]:
    """Draw map and graph faintly, every bridge clearly; return what the legend says of them."""
    ground = split.ground
    places, pairs = ground.roadmap.positions, ground.roadmap.edges
    bridges = edges & ~split.edges
    draw_sides(axes, split, FAINT)
    name_on_tints(axes, ground.freespace.scene)
    draw_edges(axes, places[pairs[bridges]], INK, width=1.3, zorder=3.5)
    legend = [line_handle(bridge, INK, 1.3)] if bridges.any() else []
    for name, side in (("one side", 1), ("other side", 0)):
        legend.append(line_handle(name, mix(SIDES[side], "#ffffff", FAINT), 1.5))
    return legend


def draw_sides(axes: Axes, split: SplitStage, faint: float = 0.0) -> None:
    """Draw map and split graph in the hues of the sides, ``faint`` (0 … 1) of the way to white."""
    ground, scene = split.ground, split.ground.freespace.scene
    draw_ground(axes, ground)
    first = np.unique(ground.groups, return_index=True)[1]
    hue_of = {
        name: SIDES[side]
        for vertex, members in zip(first.tolist(), ground.members, strict=True)
        for side in [int(split.side[vertex])]
        for name in members
        if vertex < ground.first_end
    }
    hues = [hue_of.get(obstacle.name, GRAPH) for obstacle in scene.obstacles]
    axes.collections[-1].set(  # the obstacles, drawn last
        facecolors=[mix(hue, "#ffffff", 0.5 + 0.25 * faint) for hue in hues],
        edgecolors=[mix(hue, "#ffffff", 0.6 * faint) for hue in hues],
    )
    pairs, places = ground.roadmap.edges, ground.roadmap.positions
    for side, hue in enumerate(SIDES):
        own = split.edges & (split.side[pairs[:, 0]] == side)
        draw_edges(axes, places[pairs[own]], mix(hue, "#ffffff", faint), width=0.8, alpha=opacity(len(pairs)))
    draw_vertices(axes, places, [mix(SIDES[side], "#ffffff", faint) for side in split.side.astype(int).tolist()])


def name_on_tints(axes: Axes, scene: Scene) -> None:
    """Write the names of few obstacles into them, dark."""
    known = len(axes.texts)
    name_obstacles(axes, scene)
    for text in axes.texts[known:]:
        text.set_color(INK)


def draw_edges(
    axes: Axes,
    segments: Floats,
    colour: Colour,
    width: float,
    alpha: float = 1.0,
    dashes: Dashes = "-",
    zorder: float = 2.6,
) -> None:
    """Draw straight lines (k, 2, 2)."""
    lines = LineCollection(
        list(segments), colors=colour, linewidths=width, alpha=alpha, linestyles=[dashes], zorder=zorder
    )
    lines.set_capstyle("round" if dashes == "-" else "butt")
    axes.add_collection(lines, autolim=False)


def bold(colour: Colour) -> list[tuple[Colour, float]]:
    """Return hues and widths (points) of the strokes, lowest first, that make a line stand out from any graph."""
    return [(CASING, 6.4), (mix(colour, "#000000", 0.45), 4.4), (colour, 3.2)]


def draw_vertices(axes: Axes, places: Floats, colours: Sequence[Colour]) -> None:
    """Draw dots, smaller where they are many."""
    size = float(np.clip(11 - 0.02 * len(places), 1.5, 11.0))
    axes.scatter(places[:, 0], places[:, 1], s=size, c=colours, linewidths=0, zorder=3.4)


def opacity(edges: int) -> float:
    """Return how opaque an edge is among so many, so that bundles are darker than single ones."""
    return float(np.clip(150.0 * max(edges, 1) ** -0.85, 0.035, 0.9))


def draw_robots(
    axes: Axes,
    team: Scene,
    labels: Sequence[Label],
    taken: Sequence[tuple[Point, float]] = (),
    over: Floats | None = None,
) -> None:
    """Draw starts and goals, and write the labels.

    Parameters
    ----------
    labels : what to write.
    taken : places and reaches (points) of other marks that they should not cover.
    over : (k, 2) points in metres that they should not cover; by default along the outlines.
    """
    draw_ends(axes, team, ["#ffffff"] * len(team.robots))
    marks = [*end_marks(axes, team.robots, len(team.robots)), *taken]
    write(axes, labels, marks, samples(axes, outlines(team)) if over is None else over)


def insides(axes: Axes, scene: Scene) -> Floats:
    """Return points (k, 2) in metres all over the obstacles, about 4 typographic points apart."""
    step = 4.0 / points_per_metre(axes)
    (x0, x1), (y0, y1) = axes.get_xlim(), axes.get_ylim()
    grid = np.stack(np.meshgrid(np.arange(x0, x1, step), np.arange(y0, y1, step)), axis=-1).reshape(-1, 2)
    covered = np.zeros(len(grid), dtype=np.bool_)
    for obstacle in scene.obstacles:
        covered |= obstacle_path(obstacle).contains_points(grid)
    return grid[covered]


def draw_served(
    axes: Axes, ground: Ground, robot: str, labels: Sequence[Label], vertices: Ints, segments: Floats
) -> None:
    """Draw all starts and goals, those of one robot ringed and named, and number the vertices that it is about."""
    team, colour = team_of(ground), colour_of(ground, robot)
    n = len(team.robots)
    draw_ends(axes, team, ["#ffffff"] * n)
    chosen = next(r for r in team.robots if r.name == robot)
    ring = reach(axes, chosen, n) + 3.2
    x, y = np.array([chosen.start, chosen.goal]).T
    for hue, width in bold(colour):
        axes.scatter(x, y, s=4 * ring**2, facecolors="none", edgecolors=hue, linewidths=width / 2, zorder=6.5)
    named = [Label(robot, place, ring + 2.5, darker(colour)) for place in dict.fromkeys((chosen.start, chosen.goal))]
    ends = [place for place, _ in end_marks(axes, [chosen], n)]
    numbered = [v for v in vertices.tolist() if tuple(ground.roadmap.positions[v].tolist()) not in ends]
    marks = [*end_marks(axes, team.robots, n), *((place, ring) for place in ends)]
    write(axes, [*named, *labels, *number_labels(ground, numbered)], marks, samples(axes, list(segments)))


def name_labels(axes: Axes, team: Scene) -> list[Label]:
    """Return labels with the names of few robots at their starts and goals."""
    if len(team.robots) > FEW_ROBOTS:
        return []
    names = [robot.name for robot in team.robots]
    return [*start_labels(axes, team, names, [START] * len(names)), *goal_labels(axes, team)]


def number_labels(ground: Ground, vertices: Iterable[int]) -> list[Label]:
    """Return labels v1, v2, … for these vertices, in a graph with few."""
    if len(ground.names) > FEW_VERTICES:
        return []
    places = ground.roadmap.positions
    return [Label(f"v{v + 1}", _point(places[v]), 2.2, INK, size=6.5, weight="normal") for v in vertices]


def value_labels(axes: Axes, split: SplitStage) -> tuple[list[Label], list[tuple[Point, float]]]:
    """Write the values of the Fiedler vector into the obstacles, with their names if they are few.

    Returns labels for starts, goals and corners of the workspace, and places and reaches (points) of what was written.
    """
    scene, ground = split.ground.freespace.scene, split.ground
    obstacles = {obstacle.name: obstacle for obstacle in scene.obstacles}
    named = len(obstacles) <= FEW_OBSTACLES
    first = np.unique(ground.groups, return_index=True)[1].tolist()
    labels: list[Label] = []
    taken: list[tuple[Point, float]] = []
    for vertex, members, value in zip(first, ground.members, split.values.tolist(), strict=True):
        text = _signed(value)
        hue = darker(SIDES[int(split.side[vertex])])
        inside = members if vertex < ground.first_end else ()
        if not inside:
            whose = ", ".join(dict.fromkeys(member.rpartition(" ")[0] for member in members))
            place = _point(ground.roadmap.positions[vertex])
            labels.append(Label(f"{whose} {text}".strip(), place, 3.3, hue, size=7.0))
            continue
        largest = max(inside, key=lambda name: _area(obstacles[name]))
        for name in inside if named else [largest]:
            rows = [name] * named + [text] * (name == largest)
            place = _middle(obstacles[name])
            _write_at(axes, "\n".join(rows), place, hue)
            taken.append((place, max(text_size("\n".join(rows), 7.0)) / 2))
    return labels, taken


def label_on(route: Floats, text: str, colour: Colour) -> Label:
    """Return a label beside the middle of a polyline (k, 2)."""
    middle = shapely.LineString(np.vstack([route, route[-1:]])).interpolate(0.5, normalized=True)
    return Label(text, (middle.x, middle.y), 3.0, darker(colour))


def line_handle(label: str, colour: Colour, width: float, dashes: Dashes = "-") -> Line2D:
    """Return a line for the legend."""
    return Line2D([], [], color=colour, linewidth=width, linestyle=dashes, label=label)


def _signed(value: float) -> str:
    text = f"{value:+.2f}" if abs(value) >= 0.005 else f"{value:+.1g}" if abs(value) > 1e-9 else "0"
    return text.replace("-", "−")


def _write_at(axes: Axes, text: str, place: Point, colour: Colour) -> None:
    axes.text(
        *place,
        text,
        ha="center",
        va="center",
        fontsize=7.0,
        fontweight="bold",
        color=colour,
        linespacing=1.05,
        path_effects=[withStroke(linewidth=2.0, foreground="white")],
        parse_math=False,
        clip_on=True,
        zorder=8.5,
    )


def _middle(obstacle: Obstacle) -> Point:
    """Return a place inside the obstacle, as central as can be."""
    core = obstacle.core
    if len(core) == 1:
        return _point(core[0])
    if not obstacle.closed:
        middle = shapely.LineString(core).interpolate(0.5, normalized=True)
    else:
        body = shapely.make_valid(shapely.Polygon(core))
        middle = body.centroid if body.contains(body.centroid) else body.representative_point()
    return float(middle.x), float(middle.y)


def _area(obstacle: Obstacle) -> float:
    core = obstacle.core
    shape = (
        shapely.Polygon(core) if obstacle.closed else shapely.LineString(core) if len(core) > 1 else shapely.Point(core)
    )
    return float(shape.buffer(obstacle.own_radius).area)


def _point(place: Floats) -> Point:
    return float(place[0]), float(place[1])
