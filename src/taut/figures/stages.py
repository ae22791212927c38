"""Stages of planning as pictures, one small function a kind of stage."""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
from matplotlib.axes import Axes
from matplotlib.lines import Line2D

from taut.figures.canvas import show
from taut.figures.grounds import (
    CASING,
    FEW_VERTICES,
    SIDES,
    banded,
    bold,
    colour_of,
    draw_edges,
    draw_graph_so_far,
    draw_ground,
    draw_robots,
    draw_served,
    draw_sides,
    draw_vertices,
    insides,
    label_on,
    line_handle,
    name_labels,
    name_on_tints,
    number_labels,
    opacity,
    team_of,
    value_labels,
)
from taut.figures.labels import Label
from taut.figures.maps import name_obstacles, outlines, scene_view
from taut.figures.pictures import count, draw_motions, end_handles, handle, write_legend, write_title
from taut.figures.plans import draw_arrows, draw_paths, in_seconds, samples
from taut.figures.style import GRAPH, GROWN, INK, OBSTACLE_EDGE, QUIET, darker, robot_colours
from taut.figures.teams import mark_radius
from taut.team.conflicts import Kind
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
from taut.team.telling import title

FEW_EDGES = 40  # up to this many outline edges carry their lengths
FEW_GROUPS = 25  # up to this many carry their values of the Fiedler vector
FEW_REMOVED = 400  # up to this many edges between the sides are hinted at
FEW_CONFLICTS = 25  # up to this many are numbered

#: The mark of each kind of conflict, and how large it is beside the others.
KINDS: dict[Kind, tuple[str, float]] = {
    "crossroads": ("P", 1.0),
    "head-on": ("X", 1.0),
    "catching up": (">", 1.0),
    "crossing in the open": ("*", 1.3),
    "standing": ("s", 0.8),
    "passed over": ("v", 1.0),
    "held start": ("p", 1.0),
}


class _Caption(NamedTuple):
    """What is told above a picture, the most important fact first, and below it."""

    facts: Sequence[str]
    legend: Sequence[Line2D]


def draw_stage(axes: Axes, stage: Stage, number: int | None = None) -> None:
    """Draw a stage in metres.

    Parameters
    ----------
    axes : where to draw; axes that already show something keep their view.
    stage : what to draw.
    number : of the stage, for the title.

    Raises
    ------
    OutputError
        Coordinates with which no picture can be made.
    """
    scene = stage.plan.scene if isinstance(stage, SequenceStage) else stage.ground.freespace.scene
    if axes.get_autoscale_on():
        show(axes, scene_view(scene))
    heading = title(stage) if number is None else f"Stage {number} · {title(stage)}"
    if not isinstance(stage, SequenceStage) and len(stage.ground.robots) < len(scene.robots):
        heading += f" · growth {stage.ground.freespace.growth:g} m"
    caption = _draw(axes, stage)
    facts = caption.facts
    write_title(axes, heading, *(" · ".join(facts[:k]) for k in range(len(facts), 0, -1)))
    write_legend(axes, list(caption.legend))


def _draw(axes: Axes, stage: Stage) -> _Caption:
    match stage:
        case FreeSpaceStage():
            return _draw_free_space(axes, stage)
        case ObstacleGraphStage():
            return _draw_obstacle_graph(axes, stage)
        case SplitStage():
            return _draw_split(axes, stage)
        case BridgeStage():
            return _draw_bridge(axes, stage)
        case FirstPathStage():
            return _draw_first_path(axes, stage)
        case FullGraphStage():
            return _draw_full_graph(axes, stage)
        case SequenceStage():
            return _draw_sequence(axes, stage)


def _draw_free_space(axes: Axes, stage: FreeSpaceStage) -> _Caption:
    space, team = stage.ground.freespace, team_of(stage.ground)
    draw_ground(axes, stage.ground)
    name_obstacles(axes, space.scene)
    draw_robots(axes, team, name_labels(axes, team))
    facts = [f"radius + clearance {space.growth:g} m", f"{space.area:.2f} m² in {count(space.parts, 'part')}"]
    grown = [handle("too near for the robot's centre", "s", GROWN, OBSTACLE_EDGE)] if banded(stage.ground) else []
    return _Caption(facts, [*end_handles(team), *grown])


def _draw_obstacle_graph(axes: Axes, stage: ObstacleGraphStage) -> _Caption:
    ground, team = stage.ground, team_of(stage.ground)
    places, n = ground.roadmap.positions, len(ground.names)
    pairs, lengths = ground.roadmap.edges[ground.on_obstacles], ground.roadmap.lengths[ground.on_obstacles]
    draw_ground(axes, ground)
    name_obstacles(axes, team)
    draw_edges(axes, places[pairs], INK, width=1.6 if n <= 100 else 1.0)
    draw_vertices(axes, places, [INK] * n)
    labels = [*name_labels(axes, team), *number_labels(ground, range(n))]
    taken, over = [], None
    if n <= FEW_VERTICES:
        taken = [((x, y), 2.0) for x, y in places.tolist()]
        over = np.vstack([samples(axes, outlines(team)), insides(axes, team)])
    measured = 0 < len(pairs) <= FEW_EDGES
    if measured:
        middles = places[pairs].mean(axis=1).tolist()
        labels += [
            Label(f"{length:.3g}", (x, y), 2.5, OBSTACLE_EDGE, size=6.0, weight="normal")
            for length, (x, y) in zip(lengths.tolist(), middles, strict=True)
        ]
    draw_robots(axes, team, labels, taken, over)
    facts = [
        f"{count(n, 'vertex', 'vertices')} · {count(len(pairs), 'edge')}",
        count(stage.components, "component") + (", λ2 = 0" if stage.components > 1 else ""),
    ]
    outline = line_handle("edge of an obstacle" + (", length in metres" if measured else ""), INK, 1.6)
    return _Caption(facts, [*end_handles(team), *([outline] if len(pairs) else [])])


def _draw_split(axes: Axes, stage: SplitStage) -> _Caption:
    ground, team = stage.ground, team_of(stage.ground)
    draw_sides(axes, stage)
    removed, left = int((~stage.edges).sum()), int(stage.edges.sum())
    hinted = 0 < removed <= FEW_REMOVED
    if hinted:
        gone = ground.roadmap.positions[ground.roadmap.edges[~stage.edges]]
        draw_edges(axes, gone, GRAPH, width=0.6, alpha=0.75, dashes=(0, (1, 3)), zorder=2.5)
    valued = 0 < len(stage.values) <= FEW_GROUPS
    if valued:
        draw_robots(axes, team, *value_labels(axes, stage))
    else:
        name_on_tints(axes, team)
        draw_robots(axes, team, name_labels(axes, team))
    facts = ["λ2 = 0"] if removed or stage.by == "components" else []
    facts.append(f"{count(removed, 'edge')} removed, {count(left, 'edge')} left" if removed else "nothing to remove")
    if valued:
        facts.append("values of the Fiedler vector")
    sizes = [count(int((stage.side == k).sum()), "vertex", "vertices") for k in (0, 1)]
    legend = [line_handle(f"{name}, {sizes[k]}", SIDES[k], 2.0) for name, k in (("one side", 1), ("other side", 0))]
    if hinted:
        legend.append(line_handle("removed", GRAPH, 1.2, ":"))
    return _Caption(facts, [*end_handles(team), *legend])


def _draw_bridge(axes: Axes, stage: BridgeStage) -> _Caption:
    ground, colour = stage.ground, colour_of(stage.ground, stage.robot)
    segments = ground.roadmap.positions[ground.roadmap.edges]
    before = stage.edges.copy()
    before[stage.edge] = False
    legend = draw_graph_so_far(axes, stage.cut, before, "earlier bridge")
    shown = [stage.edge]
    labels = [label_on(segments[stage.edge], f"λ2 = {_value(stage.after)}", colour)]
    if stage.runner_up is not None and stage.runner_up_after is not None:
        shown.append(stage.runner_up)
        labels.append(label_on(segments[stage.runner_up], f"λ2 = {_value(stage.runner_up_after)}", INK))
        draw_edges(axes, segments[[stage.runner_up]], INK, width=1.5, dashes=(0, (4, 2)), zorder=4.1)
        legend.insert(0, line_handle("runner-up", INK, 1.5, "--"))
    for hue, width in bold(colour):
        draw_edges(axes, segments[[stage.edge]], hue, width, zorder=4 if hue == CASING else 4.2)
    legend.insert(0, line_handle("new bridge", colour, 3.2))
    draw_served(axes, ground, stage.robot, labels, ground.roadmap.edges[stage.edge], segments[shown])
    facts = [f"λ2 {_value(stage.before)} → {_value(stage.after)}", count(stage.candidates, "candidate")]
    return _Caption(facts, [*end_handles(team_of(ground)), *legend])


def _draw_first_path(axes: Axes, stage: FirstPathStage) -> _Caption:
    ground, colour = stage.ground, colour_of(stage.ground, stage.robot)
    route = ground.roadmap.positions[stage.path]
    legend = draw_graph_so_far(axes, stage.cut, stage.edges, "bridge")
    for hue, width in bold(colour):
        draw_paths(axes, [route], [hue], width)
    draw_arrows(axes, [route], [colour])
    labels = [label_on(route, f"{stage.length:.4f} m", colour)]
    draw_served(axes, ground, stage.robot, labels, stage.path, np.stack([route[:-1], route[1:]], axis=1))
    facts = [f"{stage.length:.4f} m", count(len(stage.path) - 1, "edge")]
    path = line_handle(f"first path of {stage.robot}", colour, 3.2)
    return _Caption(facts, [*end_handles(team_of(ground)), path, *legend])


def _draw_full_graph(axes: Axes, stage: FullGraphStage) -> _Caption:
    ground, team = stage.ground, team_of(stage.ground)
    places, pairs = ground.roadmap.positions, ground.roadmap.edges
    draw_ground(axes, ground)
    name_obstacles(axes, team)
    draw_edges(axes, places[pairs], INK, width=0.6, alpha=opacity(len(pairs)))
    draw_vertices(axes, places, [INK] * len(places))
    draw_robots(axes, team, name_labels(axes, team))
    facts = [
        f"λ2 = {_value(stage.connectivity)}",
        f"{count(len(places), 'vertex', 'vertices')} · {count(len(pairs), 'edge')}",
    ]
    return _Caption(facts, [*end_handles(team), line_handle("two that see each other", INK, 0.8)])


def _draw_sequence(axes: Axes, stage: SequenceStage) -> _Caption:
    plan, n = stage.plan, len(stage.plan.scene.robots)
    colours = dict(zip((robot.name for robot in plan.scene.robots), robot_colours(n), strict=True))
    met = [conflict for name in stage.order for conflict in stage.conflicts.get(name, ())]
    radius = 1.5 * mark_radius(n)
    labels = []
    if len(met) <= FEW_CONFLICTS:
        labels = [Label(f"{k}", c.place, radius, darker(colours[c.robot]), size=7.0) for k, c in enumerate(met, 1)]
    legend = draw_motions(axes, plan, labels)
    for kind, (marker, scale) in KINDS.items():
        here = [conflict for conflict in met if conflict.kind == kind]
        if not here:
            continue
        x, y = np.array([conflict.place for conflict in here]).T
        faces = [colours[conflict.robot] for conflict in here]
        axes.scatter(
            x, y, s=(2 * radius * scale) ** 2, c=faces, marker=marker, edgecolors="white", linewidths=0.7, zorder=7.5
        )
        mark = handle(kind, marker, QUIET, "white")
        mark.set_markersize(7.5 * scale)
        legend.append(mark)
    if met:
        told = ", numbered as told" if labels else ""
        legend.append(line_handle(f"conflicts in the colour of who gives way{told}", "none", 0.0))
    facts = [
        count(len(met), "conflict"),
        f"last arrival {in_seconds(plan.makespan)}",
        f"sum of costs {in_seconds(plan.sum_of_costs)}",
    ]
    if (plan.certificate or {}).get("ok") is True:
        facts.append("certified")
    return _Caption(facts, legend)


def _value(connectivity: float) -> str:
    return "0" if connectivity == 0 else f"{connectivity:.4f}" if connectivity >= 5e-4 else f"{connectivity:.3g}"
