"""The one entry to still pictures: which parts a value is drawn from, and its title and legend."""

from __future__ import annotations

from typing import Any

import numpy as np
import shapely
from matplotlib.axes import Axes
from matplotlib.lines import Line2D
from matplotlib.transforms import ScaledTranslation

from taut.figures.canvas import View, sheet, show, size_in_points, view_of
from taut.figures.labels import text_size, write
from taut.figures.maps import draw_free_space, draw_graph, draw_map, name_obstacles, outlines, scene_view
from taut.figures.plans import (
    CLOCK,
    draw_arrows,
    draw_paths,
    draw_sweeps,
    draw_waits,
    first_wait,
    in_seconds,
    pale,
    route_of,
    samples,
    within_reach,
)
from taut.figures.style import GOAL, GRAPH, INK, QUIET, START, robot_colours
from taut.figures.teams import (
    FEW_ROBOTS,
    draw_couples,
    draw_ends,
    draw_team,
    end_marks,
    goal_labels,
    start_labels,
)
from taut.motion import Plan
from taut.scene import FloatArray, Scene

STRAYING = 20.0  # maps: up to this far off the map, faulty plans are shown whole
SOME_ROBOTS = 60  # up to this many are joined to their goals in the picture of a scene


def draw(value: Any, ax: Axes | None = None, *, graph: Any = None, time: float | None = None) -> Axes:
    """Draw a scene, plan, roadmap, free space or route in metres.

    Parameters
    ----------
    value : Scene, Plan, a result with a `plan`, Roadmap (`positions` (n, 2) and `edges` (m, 2)), FreeSpace (`region`,
        a shapely geometry) or Route (`points` (k, 2)).
    ax : matplotlib Axes to draw on; a new figure of fitting size if None (it does not touch pyplot).
    graph : anything with `positions` and `edges`, drawn thin and grey under robots and paths.
    time : seconds; shows the robots of a plan as solid discs where they are then.

    Returns
    -------
    matplotlib.axes.Axes

    Raises
    ------
    TypeError
        A value of another kind, or `time` with anything but a plan.
    OutputError
        Coordinates with which no picture can be made.
    """
    value = getattr(value, "plan", value)
    if time is not None and not isinstance(value, Plan):
        raise TypeError(f"time= needs a Plan, got {type(value).__name__}")
    view = _view(value)
    if ax is None:
        ax = sheet(view)
    else:
        show(ax, view)
    if isinstance(value, Plan):
        _draw_plan(ax, within_reach(value, view), graph, time)
    elif isinstance(value, Scene):
        _draw_scene(ax, value, graph)
    else:
        _draw_part(ax, value, graph)
    return ax


def _view(value: Any) -> View:
    if isinstance(value, Plan):
        box = scene_view(value.scene)
        points = np.vstack([np.empty((0, 2)), *(t.points for t in value.trajectories)])
        low, high = (box.x0, box.y0), (box.x1, box.y1)
        if ((low <= points) & (points <= high)).all():
            return box
        # a faulty plan is shown whole, unless there would be nothing of the map to see
        far = STRAYING * max(box.width, box.height)
        near = np.clip(points, np.subtract(low, far), np.add(high, far))
        return view_of(np.vstack([near, np.array(value.scene.workspace)])) if (near == points).all() else box
    if isinstance(value, Scene):
        return scene_view(value)
    scene = getattr(value, "scene", None)
    if isinstance(scene, Scene):
        return scene_view(scene)
    if hasattr(value, "region"):
        return view_of(shapely.get_coordinates(value.region))
    for field in ("positions", "points"):
        if hasattr(value, field):
            return view_of(np.asarray(getattr(value, field), dtype=np.float64).reshape(-1, 2))
    raise TypeError(f"draw() takes a Scene, Plan, Roadmap, FreeSpace or Route, got {type(value).__name__}")


def _draw_scene(axes: Axes, scene: Scene, graph: Any) -> None:
    n = len(scene.robots)
    draw_map(axes, scene)
    name_obstacles(axes, scene)
    if graph is not None:
        draw_graph(axes, graph)
    if n <= SOME_ROBOTS:
        draw_couples(axes, scene)
    draw_ends(axes, scene, ["#ffffff"] * n)
    if n <= FEW_ROBOTS:
        names = start_labels(axes, scene, [r.name for r in scene.robots], [START] * n)
        lines = samples(axes, [*(np.array([r.start, r.goal]) for r in scene.robots), *outlines(scene)])
        write(axes, [*names, *goal_labels(axes, scene)], end_marks(axes, scene.robots, n), lines)
    _title(axes, scene.name, _count(n, "robot") + " · " + _count(len(scene.obstacles), "obstacle"))
    _legend(axes, [*_end_handles(scene), *_graph_handles(graph)])


def _draw_plan(axes: Axes, plan: Plan, graph: Any, time: float | None) -> None:
    scene, n = plan.scene, len(plan.trajectories)
    colours = robot_colours(n)
    routes = [route_of(t) for t in plan.trajectories]
    draw_map(axes, scene)
    name_obstacles(axes, scene)
    if graph is not None:
        draw_graph(axes, graph)
    if n <= FEW_ROBOTS:
        draw_sweeps(axes, plan, colours)
    draw_paths(axes, routes, colours)
    draw_arrows(axes, routes, colours)
    draw_ends(axes, scene, pale(colours))
    waits = draw_waits(axes, plan, colours)
    if n <= FEW_ROBOTS:
        texts = [_name(r.name, first_wait(t)) for r, t in zip(scene.robots, plan.trajectories, strict=True)]
        labels = [*start_labels(axes, scene, texts, colours), *waits]
        marks = [*end_marks(axes, scene.robots, n), *((label.at, label.reach) for label in waits)]
        write(axes, labels, marks, samples(axes, [*routes, *outlines(scene)]))
    if time is not None:
        draw_team(axes, scene.robots, present_at(plan, time), colours)
    facts = [
        _count(n, "robot"),
        f"last arrival {in_seconds(plan.makespan)}",
        f"sum of costs {in_seconds(plan.sum_of_costs)}",
    ]
    if plan.certificate is not None and plan.certificate.get("ok") is True:
        facts.append("certified")
    if time is not None:
        facts = [f"t = {in_seconds(time)}", *facts]
    _title(axes, scene.name, " · ".join(facts), " · ".join(facts[:2]))
    on_the_way = any(t0 > 0 for t in plan.trajectories for t0, *_ in t.waits)
    clock = [_handle("wait", CLOCK, "white", INK)] if on_the_way else []
    _legend(axes, [*_end_handles(scene), *clock, *_graph_handles(graph)])


def _draw_part(axes: Axes, value: Any, graph: Any) -> None:
    """Draw a free space, roadmap or route, over its scene if it knows it."""
    scene = getattr(value, "scene", None)
    if hasattr(value, "region"):
        draw_free_space(axes, value.region, scene if isinstance(scene, Scene) else None)
    elif isinstance(scene, Scene):
        draw_map(axes, scene)
    else:
        axes.set_facecolor("white")
    if graph is not None:
        draw_graph(axes, graph)
    if hasattr(value, "edges") and hasattr(value, "positions"):
        draw_graph(axes, value)
        vertices, edges = len(value.positions), len(value.edges)
        _title(axes, "", f"{_count(vertices, 'vertex', 'vertices')} · {_count(edges, 'edge')}")
    elif hasattr(value, "points") and not hasattr(value, "region"):
        route = np.asarray(value.points, dtype=np.float64).reshape(-1, 2)
        colours = robot_colours(1)
        draw_paths(axes, [route], colours)
        draw_arrows(axes, [route], colours)
        for place, colour, marker in ((route[-1], GOAL, "D"), (route[0], START, "o")):
            axes.scatter(
                [place[0]], [place[1]], s=40, c=colour, marker=marker, edgecolors="white", linewidths=0.8, zorder=6
            )
        _title(axes, "", f"length {np.hypot(*np.diff(route, axis=0).T).sum():.4f} m")


def present_at(plan: Plan, time: float) -> FloatArray:
    """Return where the robots are at that time, (n, 2) metres; NaN for those that have left."""
    centres = plan.at(time)
    for k, (robot, trajectory) in enumerate(zip(plan.scene.robots, plan.trajectories, strict=True)):
        if time >= trajectory.arrival and not plan.scene.stays(robot):
            centres[k] = np.nan
    return centres


def _name(name: str, wait: float) -> str:
    return f"{name}, waits {in_seconds(wait)}" if wait else name


def _count(n: int, one: str, many: str = "") -> str:
    return f"{n:,} {one if n == 1 else many or one + 's'}".replace(",", "\u202f")


def _title(axes: Axes, name: str, facts: str, fewer: str = "") -> None:
    """Write the name bold on the left and as many facts as there is room for on the right."""
    room = size_in_points(axes)[0] - text_size(name, 10.5)[0]
    axes.set_title(name, loc="left", fontsize=10.5, fontweight="bold", color=INK, pad=7, parse_math=False)
    fits = next((text for text in (facts, fewer) if text_size(text, 8.5)[0] * 0.85 < room), "")
    axes.set_title(fits, loc="right", fontsize=8.5, color=QUIET, pad=7)


def _handle(label: str, marker: Any, face: str, edge: str) -> Line2D:
    style: dict[str, Any] = {
        "markersize": 6.5,
        "markerfacecolor": face,
        "markeredgecolor": edge,
        "markeredgewidth": 0.8,
    }
    return Line2D([], [], linestyle="none", marker=marker, label=label, **style)


def _end_handles(scene: Scene) -> list[Line2D]:
    if not scene.robots:
        return []
    return [_handle("start", "o", START, "white"), _handle("goal", "D", GOAL, "white")]


def end_legend(axes: Axes, scene: Scene) -> None:
    """Put the legend for starts and goals under the axes."""
    _legend(axes, _end_handles(scene))


def _graph_handles(graph: Any) -> list[Line2D]:
    if graph is None:
        return []
    return [Line2D([], [], color=GRAPH, linewidth=1.0, label=f"graph, {_count(len(graph.edges), 'edge')}")]


def _legend(axes: Axes, handles: list[Line2D]) -> None:
    """Put a one-line legend under the axes."""
    if not handles:
        return
    below = axes.transAxes + ScaledTranslation(0, -16 / 72, axes.figure.dpi_scale_trans)
    legend = axes.legend(
        handles=handles,
        loc="upper center",
        bbox_to_anchor=(0.5, 0),
        bbox_transform=below,
        ncols=len(handles),
        frameon=False,
        fontsize=8,
        handlelength=1.5,
        handletextpad=0.45,
        columnspacing=1.4,
        borderaxespad=0,
        labelcolor=INK,
    )
    legend.set_zorder(10)
