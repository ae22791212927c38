"""The figures of docs/chapter5.md."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
from chapter5_values import ACROSS, CENTRAL, D_S, DELTA, ELSEWHERE, SCENES, Chapter, Printed, sides_of
from matplotlib.axes import Axes
from matplotlib.lines import Line2D

import taut
from taut.comparison import compare
from taut.figures.canvas import sheet
from taut.figures.central import HIT, draw_steps, handles_of
from taut.figures.central_steps import save_central_steps, save_rounds
from taut.figures.comparison import save_comparison
from taut.figures.maps import name_obstacles, scene_view
from taut.figures.pictures import end_handles, handle, write_legend, write_title
from taut.figures.style import GROWN, INK, OBSTACLE, OBSTACLE_EDGE, mix, robot_colours
from taut.route import CentralRoute, Route
from taut.scene import FloatArray, Rectangle, Scene
from taut.team import Replanned


def draw(done: Chapter, folder: Path) -> None:
    """Draw all figures of the page into a folder."""
    second, wide = done.plain["thesis-2"], done.wide["thesis-2"]
    save_central_steps(second, done.central["thesis-2"], folder / "chapter5-steps.png")
    _draw_sides(second, done.central["thesis-2"], folder / "chapter5-two-ways.png")
    taut.save_figure(done.plain["thesis-1"], folder / "chapter5-ca-1.png", routes=done.central["thesis-1"])
    own = _own_ends(done.plain["thesis-3"], CENTRAL)
    routes = {robot.name: taut.central_path(own, robot, DELTA) for robot in own.robots}
    taut.save_figure(own, folder / "chapter5-ca-3.png", routes=routes)
    _draw_against(second, done.central["thesis-2"], done.shortest["thesis-2"], folder / "chapter5-against.png")
    before = {name: route.points for name, route in done.oca["thesis-2"].items()}
    _draw_change(done.elsewhere, ELSEWHERE, before, folder / "chapter5-elsewhere.png")
    _draw_change(done.across, ACROSS, before, folder / "chapter5-across.png")
    _draw_grown(wide, folder / "chapter5-grown.png")
    for number, name in enumerate(SCENES, 1):
        taut.save_figure(done.wide[name], folder / f"chapter5-oca-{number}.png", routes=done.oca[name])
    save_rounds(wide, taut.oca_path(wide, "R2", clearance=0.5), folder / "chapter5-rounds.png")
    rich = taut.random_scene(robots=3, obstacles=200, seed=4, radius=0.0, clearance=0.2, name="200 obstacles")
    taut.save_figure(
        rich, folder / "chapter5-rich.png", routes={robot.name: taut.oca_path(rich, robot) for robot in rich.robots}
    )
    save_comparison(compare(taut.load_scene("office-20")), folder / "chapter5-compare.png")


def _own_ends(scene: Scene, table: Iterable[Printed]) -> Scene:
    """Return the scene with the starts and goals that a table prints."""
    ends = {path.robot: (path.points[0], path.points[-1]) for path in table if path.scene == scene.name}
    robots = tuple(replace(r, start=ends[r.name][0], goal=ends[r.name][1]) for r in scene.robots)
    return replace(scene, robots=robots, name=f"{scene.name}, ends of table 5.9")


def _draw_sides(scene: Scene, routes: Mapping[str, CentralRoute], path: Path) -> None:
    axes = sheet(scene_view(scene))
    draw_steps(axes, scene, routes, "waypoints")
    sides = [sides_of(route) for route in routes.values()]
    for colour, found in zip(robot_colours(len(sides)), sides, strict=True):
        for side, line in ((1, "-"), (-1, "--")):
            if (route := found[side]) is not None:
                axes.plot(*route.points.T, line, color=colour, linewidth=1.8, zorder=4)
    write_title(axes, scene.name, "over waypoints on one side only")
    left = Line2D([], [], color=INK, linewidth=1.8, label="left of the baseline")
    right = Line2D([], [], color=INK, linewidth=1.8, linestyle="--", label="right of it")
    write_legend(axes, [*handles_of(list(routes.values()), "waypoints"), left, right])
    _save(axes, path)


def _draw_against(scene: Scene, solid: Mapping[str, CentralRoute], dashed: Mapping[str, Route], path: Path) -> None:
    axes = taut.draw(scene, routes={name: Route(route.points) for name, route in solid.items()})
    for colour, route in zip(robot_colours(len(dashed)), dashed.values(), strict=True):
        axes.plot(*route.points.T, "--", color=colour, linewidth=1.5, zorder=4.2)
    places = [hit.place for route in solid.values() for hit in route.hits]
    x, y = np.array(places).T
    axes.scatter(x, y, s=75, c=HIT, marker="X", edgecolors="white", linewidths=0.9, zorder=7.5)
    write_title(
        axes,
        scene.name,
        " · ".join(f"{name} {route.length:.2f} m against {dashed[name].length:.2f} m" for name, route in solid.items()),
    )
    central = Line2D([], [], color=INK, linewidth=2.0, label="CA")
    shortest = Line2D([], [], color=INK, linewidth=1.5, linestyle="--", label="VG, shortest")
    hits = [mark for mark in handles_of(list(solid.values()), "path") if mark.get_marker() == "X"]
    write_legend(axes, [*handles_of(list(dashed.values()), "path"), central, shortest, *hits])
    _save(axes, path)


def _draw_change(after: Replanned, new: Sequence[Rectangle], before: Mapping[str, FloatArray], path: Path) -> None:
    axes = taut.draw(after.plan)
    for obstacle in new:
        axes.fill(*obstacle.core.T, facecolor=mix(HIT, "#ffffff", 0.45), edgecolor=HIT, linewidth=0.9, zorder=2.1)
    for colour, (name, points) in zip(robot_colours(len(before)), before.items(), strict=True):
        if name in after.changed:
            axes.plot(*points.T, "--", color=colour, linewidth=1.3, zorder=3.9)
    write_title(axes, after.plan.scene.name, f"{len(after.kept)} kept · {len(after.changed)} planned anew")
    marks = [handle("added", "s", mix(HIT, "#ffffff", 0.45), HIT)]
    if after.changed:
        marks.append(Line2D([], [], color=INK, linewidth=1.3, linestyle="--", label="as it was"))
    write_legend(axes, [*end_handles(after.plan.scene), *marks])
    _save(axes, path)


def _draw_grown(scene: Scene, path: Path) -> None:
    axes = taut.draw(taut.FreeSpace(scene, D_S))
    name_obstacles(axes, scene)
    write_title(axes, scene.name, f"grown by {D_S:g} m")
    write_legend(axes, [handle("obstacle", "s", OBSTACLE, OBSTACLE_EDGE), handle("grown", "s", GROWN, OBSTACLE_EDGE)])
    _save(axes, path)


def _save(axes: Axes, path: Path) -> None:
    figure: Any = axes.figure
    figure.savefig(path, dpi=200, metadata={"Software": None})
