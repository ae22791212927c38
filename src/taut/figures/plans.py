"""Paths of a plan: lines, directions, waits."""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Sequence
from dataclasses import replace
from itertools import pairwise
from typing import Any

import numpy as np
import shapely
from matplotlib.axes import Axes
from matplotlib.collections import LineCollection, PathCollection, PolyCollection
from matplotlib.path import Path

from taut.figures.canvas import View, points_per_metre
from taut.figures.labels import Label
from taut.figures.maps import polygon_path
from taut.figures.style import Colour, darker, mix
from taut.figures.teams import mark_radius, reach
from taut.motion import Plan, Trajectory
from taut.scene import FloatArray, Point

FARTHEST = 1000.0  # views: lines to places farther out would overflow the pixels
DASH = 7.0  # points: stretch of one robot on a leg that several robots use
BRIEF = 0.05  # seconds: shorter waits are not marked
FEW_WAITS = 24  # up to this many are told in seconds
FEW_PATHS = 40  # up to this many, legs used by several robots are striped, and every path gets several arrows
MANY_PATHS = 300  # from here on no arrows

CLOCK = Path.make_compound_path(Path.circle((0, 0), 1.0), Path([(0, 0.62), (0, 0), (0.45, 0)]))


def line_width(n: int) -> float:
    """Return the width of a path in points for a team of n."""
    return 2.0 if n <= 12 else 1.5 if n <= FEW_PATHS else 0.9 if n <= 200 else 0.5


def route_of(trajectory: Trajectory) -> FloatArray:
    """Return the path without the rests, (k ≥ 1, 2)."""
    points = trajectory.points
    return np.asarray(points[np.concatenate([[True], (np.diff(points, axis=0) != 0).any(axis=1)])], dtype=np.float64)


def within_reach(plan: Plan, view: View) -> Plan:
    """Return the plan with all places that lie absurdly far outside the view drawn in towards it."""
    centre = np.array([view.x0 + view.width / 2, view.y0 + view.height / 2])
    reach = FARTHEST * max(view.width, view.height)
    low, high = centre - reach, centre + reach
    if all(((low <= t.points) & (t.points <= high)).all() for t in plan.trajectories):
        return plan
    near = [Trajectory(t.name, np.column_stack([t.times, np.clip(t.points, low, high)])) for t in plan.trajectories]
    return replace(plan, trajectories=tuple(near))


def draw_sweeps(axes: Axes, plan: Plan, colours: Sequence[Colour]) -> None:
    """Tint what each disc passes over."""
    paths: list[Path] = []
    faces: list[Colour] = []
    for trajectory, robot, colour in zip(plan.trajectories, plan.scene.robots, colours, strict=True):
        route = route_of(trajectory)
        if robot.radius > 0 and len(route) > 1:
            swept = shapely.LineString(route).buffer(robot.radius, quad_segs=16)
            # on a way with many small turns rounding may leave slivers beside the one area
            parts = shapely.get_parts(swept)
            paths += map(polygon_path, parts)
            faces += [colour] * len(parts)
    axes.add_collection(PathCollection(paths, facecolors=faces, edgecolors="none", alpha=0.13, zorder=3), autolim=False)


def draw_paths(axes: Axes, routes: Sequence[FloatArray], colours: Sequence[Colour], width: float | None = None) -> None:
    """Draw the paths `width` points wide; a leg that several robots use is striped in all their colours."""
    width = line_width(len(routes)) if width is None else width
    alpha = 1.0 if len(routes) <= FEW_PATHS else 0.75 if len(routes) <= 200 else 0.45
    owners = _owners(routes) if len(routes) <= FEW_PATHS else {}
    runs: list[FloatArray] = []
    run_colours: list[Colour] = []
    stripes: list[tuple[FloatArray, Colour, float, int]] = []
    for k, route in enumerate(routes):
        run = [0]
        for j in range(1, len(route)):
            a, b = sorted((tuple(route[j - 1]), tuple(route[j])))
            sharing = owners.get((a, b), (k,))
            if len(sharing) == 1:
                run.append(j)
                continue
            stripes.append((np.array([a, b]), colours[k], DASH / width * sharing.index(k), len(sharing)))
            runs, run_colours = [*runs, route[run]], [*run_colours, colours[k]]
            run = [j]
        runs.append(route[run])
        run_colours.append(colours[k])
    style: dict[str, Any] = {"linewidths": width, "alpha": alpha, "zorder": 4}
    solid = [(run, colour) for run, colour in zip(runs, run_colours, strict=True) if len(run) > 1]
    lines = LineCollection([s[0] for s in solid], colors=[s[1] for s in solid], **style)
    lines.set(capstyle="round", joinstyle="round")
    axes.add_collection(lines, autolim=False)
    if stripes:
        on = DASH / width
        dashes = [(on * n - shift, (on, on * (n - 1))) for _, _, shift, n in stripes]
        lines = LineCollection([s[0] for s in stripes], colors=[s[1] for s in stripes], linestyles=dashes, **style)
        lines.set_capstyle("butt")
        axes.add_collection(lines, autolim=False)


def draw_arrows(axes: Axes, routes: Sequence[FloatArray], colours: Sequence[Colour]) -> None:
    """Draw arrow heads along the paths, about every inch and a half, at least one on a path long enough."""
    n = len(routes)
    scale = points_per_metre(axes)
    if n > MANY_PATHS:
        return
    spacing = 90.0 if n <= 12 else 140.0 if n <= FEW_PATHS else np.inf
    places, directions, faces = [], [], []
    for k, (route, colour) in enumerate(zip(routes, colours, strict=True)):
        lengths = np.hypot(*np.diff(route, axis=0).T) * scale
        total = float(lengths.sum())
        head = 3.2 * mark_radius(n)
        if total < 3 * head:
            continue
        count = max(1, round(total / spacing))
        # robots on one street have their arrows at different places of it
        phase = (k * 0.382) % 1.0 * 0.5 + 0.25 if n > 1 else 0.5
        ends = np.concatenate([[0.0], np.cumsum(lengths)])
        for s in np.clip((np.arange(count) + phase) / count * total, 1.5 * head, total - 1.5 * head):
            j = int(min(np.searchsorted(ends, s, side="right") - 1, len(lengths) - 1))
            if lengths[j] > head:
                s = float(np.clip(s, ends[j] + head, max(ends[j] + head, ends[j + 1] - 0.5 * head)))
            along = (s - ends[j]) / lengths[j]
            places.append(route[j] + along * (route[j + 1] - route[j]))
            directions.append((route[j + 1] - route[j]) * scale / lengths[j])
            faces.append(colour)
    if not places:
        return
    heads = _heads(np.array(places), np.array(directions), 2.6 * mark_radius(n) / scale)
    collection = PolyCollection(list(heads), facecolors=faces, edgecolors="white", zorder=4.5)
    collection.set_linewidth(0.5 if n <= FEW_PATHS else 0.25)
    axes.add_collection(collection, autolim=False)


def draw_waits(axes: Axes, plan: Plan, colours: Sequence[Colour]) -> list[Label]:
    """Mark the waits: clocks on the way, rings round starts. Return labels with the seconds if there are few."""
    n = len(plan.trajectories)
    ring = 1.45 * mark_radius(n)
    found: dict[Point, list[tuple[int, float]]] = defaultdict(list)
    starts: list[int] = []
    for k, trajectory in enumerate(plan.trajectories):
        for t0, t1, x, y in trajectory.waits:
            if t1 - t0 < BRIEF:
                continue
            if t0 == 0:
                starts.append(k)
            else:
                found[x, y].append((k, t1 - t0))
    if starts:
        robots = [plan.scene.robots[k] for k in starts]
        sizes = [4 * (reach(axes, robot, n) + 0.75 * mark_radius(n)) ** 2 for robot in robots]
        rings: dict[str, Any] = {"facecolors": "none", "linewidths": 0.35 * mark_radius(n) ** 0.8, "zorder": 5.5}
        axes.scatter(
            [r.start[0] for r in robots],
            [r.start[1] for r in robots],
            s=sizes,
            edgecolors=[colours[k] for k in starts],
            **rings,
        )
    if found:
        places = np.array(list(found), dtype=np.float64)
        edges = [colours[stays[0][0]] for stays in found.values()]
        axes.scatter(
            places[:, 0],
            places[:, 1],
            s=4 * ring**2,
            marker=CLOCK if n <= MANY_PATHS else "o",
            facecolors="white",
            edgecolors=edges,
            linewidths=0.36 * mark_radius(n) ** 0.8,
            zorder=7,
        )
    if sum(len(stays) for stays in found.values()) > FEW_WAITS:
        return []
    names = [robot.name for robot in plan.scene.robots]
    return [
        Label(
            "\n".join((f"{names[k]} " if len(stays) > 1 else "") + in_seconds(wait) for k, wait in stays),
            place,
            ring,
            darker(colours[stays[0][0]]),
            size=7.0,
            weight="normal",
        )
        for place, stays in found.items()
    ]


def in_seconds(amount: float) -> str:
    """Return a time in words, short also if it is absurd.

    >>> in_seconds(12.34), in_seconds(1e300)
    ('12.3 s', '1e+300 s')
    """
    if amount < 10000:
        return f"{amount:.1f} s"
    return f"{amount:,.0f} s".replace(",", "\u202f") if amount < 1e9 else f"{amount:.3g} s"


def first_wait(trajectory: Trajectory) -> float:
    """Return for how many seconds the robot rests at its start before it leaves, 0 if it leaves at once."""
    return next((t1 - t0 for t0, t1, _, _ in trajectory.waits if t0 == 0 and t1 - t0 >= BRIEF), 0.0)


def samples(axes: Axes, routes: Sequence[FloatArray]) -> FloatArray:
    """Return points (k, 2) in metres about every 3 typographic points along the paths."""
    step = 3.0 / points_per_metre(axes)
    out = [np.empty((0, 2))]
    for route in routes:
        for a, b in pairwise(route):
            count = int(np.hypot(*(b - a)) / step) + 2
            out.append(a + np.linspace(0, 1, min(count, 2000))[:, None] * (b - a))
    return np.vstack(out)


def pale(colours: Sequence[Colour]) -> list[Colour]:
    """Return light tints of the colours, for discs under marks."""
    return [mix(colour, "#ffffff", 0.72) for colour in colours]


def _heads(places: FloatArray, directions: FloatArray, size: float) -> FloatArray:
    """Return notched arrow heads of that length in metres, (n, 4, 2)."""
    shape = np.array([(0.55, 0.0), (-0.45, 0.42), (-0.22, 0.0), (-0.45, -0.42)]) * size
    across = directions[:, ::-1] * (-1, 1)
    return places[:, None] + shape[:, :1] * directions[:, None] + shape[:, 1:] * across[:, None]


def _owners(routes: Sequence[FloatArray]) -> dict[tuple[Point, Point], tuple[int, ...]]:
    """Return, for each leg (its two ends in order), the robots that use it."""
    users: dict[tuple[Point, Point], list[int]] = defaultdict(list)
    for k, route in enumerate(routes):
        for p, q in pairwise(route):
            a, b = sorted((tuple(p), tuple(q)))
            if k not in users[a, b]:
                users[a, b].append(k)
    return {leg: tuple(ks) for leg, ks in users.items()}
