"""Robots on the map: discs, starts, goals and names."""

from __future__ import annotations

from collections.abc import Iterable, Sequence

import numpy as np
from matplotlib.axes import Axes
from matplotlib.collections import EllipseCollection, LineCollection

from taut.figures.canvas import points_per_metre
from taut.figures.labels import Label
from taut.figures.style import GOAL, INK, START, Colour, darker, mix
from taut.scene import FloatArray, Point, Robot, Scene

LARGEST = 100.0  # widths of the axes
FEW_ROBOTS = 25  # up to this many are named


def mark_radius(n: int) -> float:
    """Return the radius of a mark, in points, for a team of n: a disc smaller than that is shown as a mark."""
    return 3.3 if n <= 12 else 2.6 if n <= 60 else 1.9 if n <= 200 else 1.1


def reach(axes: Axes, robot: Robot, n: int) -> float:
    """Return how far the drawing of this robot of n reaches from its centre, in points."""
    return max(robot.radius * points_per_metre(axes), mark_radius(n))


def discs(axes: Axes, centres: FloatArray, radii: FloatArray, zorder: float) -> EllipseCollection:
    """Add true discs in metres, centres (n, 2), radii (n,); colours are for the caller to set."""
    # a disc much larger than the map would take its renderer for ever
    radii = np.minimum(radii, LARGEST * max(np.ptp(axes.get_xlim()), np.ptp(axes.get_ylim())))
    collection = EllipseCollection(
        2 * radii,
        2 * radii,
        np.zeros(len(radii)),
        units="xy",
        offsets=centres.reshape(-1, 2),
        offset_transform=axes.transData,
        zorder=zorder,
    )
    axes.add_collection(collection, autolim=False)
    return collection


def visible_radii(axes: Axes, robots: Sequence[Robot], mark: float) -> FloatArray:
    """Return the radii in metres, none smaller than a mark of that radius in points."""
    least = mark / points_per_metre(axes)
    return np.array([max(robot.radius, least) for robot in robots], dtype=np.float64)


def draw_ends(axes: Axes, scene: Scene, tints: Sequence[Colour]) -> None:
    """Draw starts (red, round) and goals (green, diamonds) with the outlined discs of the robots in their tints."""
    robots = scene.robots
    if not robots:
        return
    mark = mark_radius(len(robots))
    scale = points_per_metre(axes)
    large = [k for k, robot in enumerate(robots) if robot.radius * scale > 1.15 * mark]
    radii = np.array([robots[k].radius for k in large], dtype=np.float64)
    sizes = np.array([4 * _inner_mark(robot.radius * scale, mark) ** 2 for robot in robots])
    ends = (([robot.goal for robot in robots], GOAL, "D", 0.8), ([robot.start for robot in robots], START, "o", 1.0))
    for places, colour, marker, share in ends:
        centres = np.array(places, dtype=np.float64)
        if large:
            collection = discs(axes, centres[large], radii, zorder=5)
            collection.set(facecolors=[tints[k] for k in large], edgecolors=colour, linewidths=0.45 * mark**0.8)
        # a diamond of the same width looks larger than a disc
        axes.scatter(
            centres[:, 0],
            centres[:, 1],
            s=sizes * share**2,
            c=colour,
            marker=marker,
            edgecolors="white",
            linewidths=0.22 * mark,
            zorder=6,
        )


def draw_team(axes: Axes, robots: Sequence[Robot], centres: FloatArray, colours: Sequence[Colour]) -> None:
    """Draw the robots as filled discs at `centres` (n, 2); rows that are NaN are not there."""
    here = np.flatnonzero(np.isfinite(centres).all(axis=1)).tolist()
    if not here:
        return
    collection = discs(
        axes, centres[here], visible_radii(axes, robots, 1.35 * mark_radius(len(robots)))[here], zorder=8
    )
    chosen = [colours[k] for k in here]
    collection.set(facecolors=chosen, edgecolors=[mix(c, "#000000", 0.45) for c in chosen], linewidths=0.7)


def draw_couples(axes: Axes, scene: Scene) -> None:
    """Join each start to its goal by a faint dotted line."""
    pairs = np.array([[robot.start, robot.goal] for robot in scene.robots], dtype=np.float64)
    colour = mix(INK, "#ffffff", 0.55)
    lines = LineCollection(list(pairs), colors=colour, linewidths=0.6, linestyles=(0, (1, 3)), zorder=3)
    axes.add_collection(lines, autolim=False)


def start_labels(axes: Axes, scene: Scene, texts: Sequence[str], colours: Sequence[Colour]) -> list[Label]:
    """Return one label a robot, beside its start and the ring that may be round it."""
    n = len(scene.robots)
    rows = zip(scene.robots, texts, colours, strict=True)
    ring = 0.75 * mark_radius(n)
    return [
        Label(text, robot.start, reach(axes, robot, n) + ring * (text != robot.name), darker(colour))
        for robot, text, colour in rows
    ]


def goal_labels(axes: Axes, scene: Scene) -> list[Label]:
    """Return one label a goal, naming all the robots that go there."""
    n = len(scene.robots)
    parties: dict[Point, list[Robot]] = {}
    for robot in scene.robots:
        parties.setdefault(robot.goal, []).append(robot)
    green = darker(GOAL)
    return [
        Label(", ".join(r.name for r in party), goal, max(reach(axes, r, n) for r in party), green, weight="normal")
        for goal, party in parties.items()
    ]


def end_marks(axes: Axes, robots: Iterable[Robot], n: int) -> list[tuple[Point, float]]:
    """Return places (metres) and reaches (points) of all starts and goals."""
    return [(place, reach(axes, robot, n)) for robot in robots for place in (robot.start, robot.goal)]


def _inner_mark(radius: float, mark: float) -> float:
    """Return the radius of the mark inside a disc of that radius, both in points."""
    return mark if radius <= 1.15 * mark else min(mark, max(0.42 * radius, 0.5 * mark))
