"""The one entry to still pictures: which parts a value is drawn from, and its title and legend."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Any

import numpy as np
import shapely
from matplotlib.axes import Axes
from matplotlib.lines import Line2D
from matplotlib.transforms import ScaledTranslation

from taut.figures.canvas import View, sheet, show, size_in_points, view_of
from taut.figures.labels import Label, text_size, write
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
from taut.figures.style import GOAL, GRAPH, INK, QUIET, START, Colour, robot_colours
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

if TYPE_CHECKING:  # only pictures of contact load the compiled code that finds it
    from taut.contact import Contact, Contacts

STRAYING = 20.0  # maps: up to this far off the map, faulty plans are shown whole
MANY_LINKED = 150  # of more robots contact is not shown: λ2 over time would take minutes
SOME_ROBOTS = 60  # up to this many are joined to their goals in the picture of a scene


def draw(
    value: Any,
    ax: Axes | None = None,
    *,
    graph: Any = None,
    time: float | None = None,
    routes: Mapping[str, Any] | None = None,
    contact: Contact | float | None = None,
) -> Axes:
    """Draw a scene, plan, roadmap, free space, route, simulated run or steered team in metres.

    A plan that claims contact, or is drawn with `contact`, is shown at the instant at which the team's λ2 is least: the
    links between its robots, the bridges and cut vertices of that graph in red, and, on a figure of its own, how λ2
    runs; of up to 150 robots.

    Parameters
    ----------
    value : Scene, Plan, a result with a `plan`, a stage of planning, Roadmap (`positions` (n, 2) and `edges` (m, 2)),
        FreeSpace (`region`, a shapely geometry), Route (`points` (k, 2)), Run (see `draw_run`) or Steered (see
        `draw_steered`).
    ax : matplotlib Axes to draw on; a new figure of fitting size if None (it does not touch pyplot).
    graph : anything with `positions` and `edges`, drawn thin and grey under robots and paths.
    time : seconds; shows the robots of a plan as solid discs where they are then.
    routes : of robots of a scene, by name; those of CA and OCA are shown with all that they were made of.
    contact : links of a plan to show: a range in metres or a `Contact`; by default those that the plan claims.

    Returns
    -------
    matplotlib.axes.Axes

    Raises
    ------
    TypeError
        A value of another kind, `time` or `contact` with anything but a plan, `routes` with anything but a scene,
        `graph` with a stage, a run or with routes.
    ValueError
        A route of a robot that the scene does not have.
    OutputError
        Coordinates with which no picture can be made.
    """
    stage, run, steered = _is_stage(value), _is_run(value), _is_steered(value)
    if not (stage or run or steered):
        value = getattr(value, "plan", value)
    if time is not None and not isinstance(value, Plan):
        raise TypeError(f"time= needs a Plan, got {type(value).__name__}")
    if contact is not None and not isinstance(value, Plan):
        raise TypeError(f"contact= needs a Plan, got {type(value).__name__}")
    if routes is not None and not (isinstance(value, Scene) and graph is None):
        raise TypeError(f"routes= needs a Scene and no graph=, got {type(value).__name__}")
    if graph is not None and (stage or run or steered):
        raise TypeError(f"graph= does not go with a {type(value).__name__}" + ", which shows its own graph" * stage)
    if run:
        from taut.figures.simulation import draw_run

        return draw_run(value, ax)
    if steered:
        from taut.figures.steering import draw_steered

        return draw_steered(value, ax=ax)
    view = _view(value)
    own = ax is None
    if ax is None:
        ax = sheet(view)
    else:
        show(ax, view)
    found = shown_contacts(value, contact) if isinstance(value, Plan) else None
    if stage:
        from taut.figures.stages import draw_stage

        draw_stage(ax, value)
    elif routes is not None:
        from taut.figures.central import draw_routes

        draw_routes(ax, value, routes)
    elif _is_central(value):
        from taut.figures.central import draw_route

        draw_route(ax, value)
    elif found is not None:
        from taut.figures.contact import draw_linked
        from taut.figures.courses import add_course

        draw_linked(ax, within_reach(value, view), found, graph, time)
        if own:
            add_course(ax, found, value.makespan, time)
    elif isinstance(value, Plan):
        _draw_plan(ax, within_reach(value, view), graph, time)
    elif isinstance(value, Scene):
        _draw_scene(ax, value, graph)
    else:
        _draw_part(ax, value, graph)
    return ax


def shown_contacts(plan: Plan, contact: Contact | float | None) -> Contacts | None:
    """Return the contacts that a picture shows, as given or else as the plan claims; None for one robot, or many."""
    if not 2 <= len(plan.trajectories) <= MANY_LINKED or (contact is None and not plan.claims.get("contact")):
        return None
    from taut.figures.contact import contacts_shown

    return contacts_shown(plan, contact)


def _is_stage(value: Any) -> bool:
    # by where it comes from: importing the planner to draw a map would cost a second
    return type(value).__module__ == "taut.team.stages"


def _is_run(value: Any) -> bool:
    return type(value).__module__ == "taut.simulation.running" and hasattr(value, "plan")


def _is_steered(value: Any) -> bool:
    return type(value).__module__ == "taut.simulation.steering" and hasattr(value, "plan")


def _is_central(value: Any) -> bool:
    return type(value).__module__ in ("taut.route.central", "taut.route.oca") and hasattr(value, "points")


def _view(value: Any) -> View:
    if _is_stage(value):
        return _view(value.ground.freespace if hasattr(value, "ground") else value.plan)
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
    if _is_central(value):
        if hasattr(value, "freespace"):
            return scene_view(value.freespace.scene)
        return view_of(np.vstack([value.roadmap.positions, *(waypoint.place for waypoint, _ in value.dropped)]))
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
    write_title(axes, scene.name, count(n, "robot") + " · " + count(len(scene.obstacles), "obstacle"))
    write_legend(axes, [*end_handles(scene), *_graph_handles(graph)])


def _draw_plan(axes: Axes, plan: Plan, graph: Any, time: float | None) -> None:
    scene, n = plan.scene, len(plan.trajectories)
    if graph is not None:
        draw_graph(axes, graph)
    handles = draw_motions(axes, plan)
    if time is not None:
        draw_team(axes, scene.robots, present_at(plan, time), robot_colours(n))
    facts = [
        count(n, "robot"),
        f"last arrival {in_seconds(plan.makespan)}",
        f"sum of costs {in_seconds(plan.sum_of_costs)}",
    ]
    if plan.certificate is not None and plan.certificate.get("ok") is True:
        facts.append("certified")
    if time is not None:
        facts = [f"t = {in_seconds(time)}", *facts]
    write_title(axes, scene.name, " · ".join(facts), " · ".join(facts[:2]))
    write_legend(axes, [*handles, *_graph_handles(graph)])


def draw_motions(axes: Axes, plan: Plan, labels: Sequence[Label] = ()) -> list[Line2D]:
    """Draw map, paths, ends and waits of a plan, with these labels beside its own; return what its legend holds."""
    scene, n = plan.scene, len(plan.trajectories)
    colours = robot_colours(n)
    routes = [route_of(t) for t in plan.trajectories]
    draw_map(axes, scene)
    name_obstacles(axes, scene)
    if n <= FEW_ROBOTS:
        draw_sweeps(axes, plan, colours)
    draw_paths(axes, routes, colours)
    draw_arrows(axes, routes, colours)
    draw_ends(axes, scene, pale(colours))
    waits = draw_waits(axes, plan, colours)
    own: list[Label] = []
    if n <= FEW_ROBOTS:
        texts = [_name(r.name, first_wait(t)) for r, t in zip(scene.robots, plan.trajectories, strict=True)]
        own = [*start_labels(axes, scene, texts, colours), *waits]
    marks = [*end_marks(axes, scene.robots, n), *((label.at, label.reach) for label in (*waits, *labels))]
    write(axes, [*labels, *own], marks, samples(axes, [*routes, *outlines(scene)]))
    on_the_way = any(t0 > 0 for t in plan.trajectories for t0, *_ in t.waits)
    clock = [handle("wait", CLOCK, "white", INK)] if on_the_way else []
    return [*end_handles(scene), *clock]


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
        write_title(axes, "", f"{count(vertices, 'vertex', 'vertices')} · {count(edges, 'edge')}")
    elif hasattr(value, "points") and not hasattr(value, "region"):
        route = np.asarray(value.points, dtype=np.float64).reshape(-1, 2)
        colours = robot_colours(1)
        draw_paths(axes, [route], colours)
        draw_arrows(axes, [route], colours)
        for place, colour, marker in ((route[-1], GOAL, "D"), (route[0], START, "o")):
            axes.scatter(
                [place[0]], [place[1]], s=40, c=colour, marker=marker, edgecolors="white", linewidths=0.8, zorder=6
            )
        write_title(axes, "", f"length {np.hypot(*np.diff(route, axis=0).T).sum():.4f} m")


def present_at(plan: Plan, time: float) -> FloatArray:
    """Return where the robots are at that time, (n, 2) metres; NaN for those that have left."""
    centres = plan.at(time)
    for k, (robot, trajectory) in enumerate(zip(plan.scene.robots, plan.trajectories, strict=True)):
        if time >= trajectory.arrival and not plan.scene.stays(robot):
            centres[k] = np.nan
    return centres


def _name(name: str, wait: float) -> str:
    return f"{name}, waits {in_seconds(wait)}" if wait else name


def count(n: int, one: str, many: str = "") -> str:
    """Return the number with its noun in singular or plural."""
    return f"{n:,} {one if n == 1 else many or one + 's'}".replace(",", "\u202f")


def write_title(axes: Axes, name: str, *facts: str) -> None:
    """Write the name bold on the left, and on the right the first of the facts that there is room for."""
    room = size_in_points(axes)[0] - text_size(name, 10.5)[0]
    axes.set_title(name, loc="left", fontsize=10.5, fontweight="bold", color=INK, pad=7, parse_math=False)
    fits = next((text for text in facts if text_size(text, 8.5)[0] * 0.85 < room), "")
    axes.set_title(fits, loc="right", fontsize=8.5, color=QUIET, pad=7)


def handle(label: str, marker: Any, face: str, edge: str) -> Line2D:
    """Return a mark for the legend."""
    style: dict[str, Any] = {
        "markersize": 6.5,
        "markerfacecolor": face,
        "markeredgecolor": edge,
        "markeredgewidth": 0.8,
    }
    return Line2D([], [], linestyle="none", marker=marker, label=label, **style)


def end_handles(scene: Scene) -> list[Line2D]:
    """Return the marks of starts and goals for the legend, if there are robots."""
    if not scene.robots:
        return []
    return [handle("start", "o", START, "white"), handle("goal", "D", GOAL, "white")]


def line_handle(label: str, colour: Colour) -> Line2D:
    """Return a piece of line for the legend."""
    return Line2D([], [], color=colour, linewidth=2.2, label=label)


def _graph_handles(graph: Any) -> list[Line2D]:
    if graph is None:
        return []
    return [Line2D([], [], color=GRAPH, linewidth=1.0, label=f"graph, {count(len(graph.edges), 'edge')}")]


def write_legend(axes: Axes, handles: list[Line2D]) -> None:
    """Put a legend under the axes: one line, or two smaller ones where that would be too wide."""
    if not handles:
        return
    needed = sum(27.0 + 0.85 * text_size(str(mark.get_label()), 8)[0] for mark in handles)
    room = size_in_points(axes)[0] - 2 * 34.0  # "metres" stands at the right end
    wraps = needed > room and len(handles) > 2
    below = axes.transAxes + ScaledTranslation(0, (-14 if wraps else -16) / 72, axes.figure.dpi_scale_trans)
    legend = axes.legend(
        handles=handles,
        loc="upper center",
        bbox_to_anchor=(0.5, 0),
        bbox_transform=below,
        ncols=-(-len(handles) // 2) if wraps else len(handles),
        frameon=False,
        fontsize=7 if wraps else 8,
        handlelength=1.5,
        handletextpad=0.45,
        columnspacing=1.4,
        labelspacing=0.25,
        borderaxespad=0,
        labelcolor=INK,
    )
    legend.set_zorder(10)
