"""The still part of a figure: workspace, obstacles, free space, graph."""

from __future__ import annotations

from collections.abc import Iterable
from typing import Any

import numpy as np
import shapely
from matplotlib.axes import Axes
from matplotlib.collections import LineCollection, PathCollection
from matplotlib.path import Path

from taut.errors import OutputError
from taut.figures.canvas import FARTHEST, View, points_per_metre, size_in_points, to_points, view_of
from taut.figures.labels import text_size
from taut.figures.style import GRAPH, GROWN, OBSTACLE, OBSTACLE_EDGE, WALL, WORKSPACE
from taut.scene import Circle, FloatArray, Line, Obstacle, Scene

OVERFLOW = 1e4  # widths of the axes
FEW_OBSTACLES = 25  # up to this many are named


def scene_view(scene: Scene) -> View:
    """Return the view that shows the workspace and every start and goal.

    Raises
    ------
    OutputError
        Numbers in the scene with which no picture can be made.
    """
    sizes = [robot.radius for robot in scene.robots] + [obstacle.own_radius for obstacle in scene.obstacles]
    largest = max([*sizes, *(float(np.abs(obstacle.core).max()) for obstacle in scene.obstacles)], default=0.0)
    if not largest < FARTHEST:
        raise OutputError(f"cannot be drawn: a length or coordinate of {largest:.3g} m")
    ends = [place for robot in scene.robots for place in (robot.start, robot.goal)]
    return view_of(np.array([*scene.workspace, *ends], dtype=np.float64))


def draw_map(axes: Axes, scene: Scene) -> None:
    """Draw workspace and obstacles."""
    _fill(axes, [_ring(np.array(scene.workspace))], WORKSPACE, WALL, 1.0, zorder=1)
    _fill(axes, [obstacle_path(o) for o in scene.obstacles], OBSTACLE, OBSTACLE_EDGE, 0.8, zorder=2)


def name_obstacles(axes: Axes, scene: Scene) -> None:
    """Write the names of up to `FEW_OBSTACLES` obstacles into them, where they fit."""
    if len(scene.obstacles) > FEW_OBSTACLES:
        return
    for obstacle in scene.obstacles:
        place = _room_inside(axes, obstacle, *text_size(obstacle.name, 7.5))
        if place is not None:
            style: dict[str, Any] = {
                "fontsize": 7.5,
                "color": "white",
                "fontweight": "bold",
                "zorder": 3.2,
                "parse_math": False,
            }
            axes.text(*place, obstacle.name, ha="center", va="center_baseline", clip_on=True, **style)


def draw_graph(axes: Axes, roadmap: Any) -> None:
    """Draw the edges (thin, grey) and vertices of anything with `positions` (n, 2) and `edges` (m, 2)."""
    positions = np.asarray(roadmap.positions, dtype=np.float64).reshape(-1, 2)
    edges = np.asarray(roadmap.edges, dtype=np.int64).reshape(-1, 2)
    crowd = len(edges) / max(1.0, points_per_metre(axes) * float(np.ptp(positions, axis=0).max(initial=0.0)))
    width = float(np.clip(0.8 / (0.5 + crowd), 0.12, 0.75))
    axes.add_collection(
        LineCollection(list(positions[edges]), colors=GRAPH, linewidths=width, zorder=2.5), autolim=False
    )
    size = float(np.clip(9 - 0.01 * len(positions), 1.0, 9.0))
    axes.scatter(positions[:, 0], positions[:, 1], s=size, color=GRAPH, linewidths=0, zorder=2.5)


def draw_free_space(axes: Axes, region: Any, scene: Scene | None) -> None:
    """Draw what the centre of a disc may use (white), the grown band (light blue) and, if known, the obstacles."""
    if scene is not None:
        _fill(axes, [_ring(np.array(scene.workspace))], GROWN, WALL, 1.0, zorder=1)
    parts = [part for part in shapely.get_parts(region) if part.geom_type == "Polygon"]
    _fill(axes, [polygon_path(part) for part in parts], WORKSPACE, OBSTACLE_EDGE, 0.5, zorder=1.5)
    if scene is not None:
        _fill(axes, [obstacle_path(o) for o in scene.obstacles], OBSTACLE, OBSTACLE_EDGE, 0.8, zorder=2)


def _near(axes: Axes, path: Path) -> Path:
    """Return the path with corners that would overflow the pixels drawn in towards the axes."""
    (x0, x1), (y0, y1) = axes.get_xlim(), axes.get_ylim()
    reach = OVERFLOW * max(abs(x1 - x0), abs(y1 - y0))
    low, high = (min(x0, x1) - reach, min(y0, y1) - reach), (max(x0, x1) + reach, max(y0, y1) + reach)
    corners = np.asarray(path.vertices, dtype=np.float64)
    if ((low <= corners) & (corners <= high)).all():
        return path
    return Path(np.clip(corners, low, high), path.codes)


def outlines(scene: Scene) -> list[FloatArray]:
    """Return the closed outlines of workspace and obstacles, each (k, 2)."""
    paths = [_ring(np.array(scene.workspace)), *(_straight(o) for o in scene.obstacles)]
    return [np.asarray(ring, dtype=np.float64) for path in paths for ring in path.to_polygons(closed_only=False)]


def obstacle_path(obstacle: Obstacle) -> Path:
    """Return the outline of the whole obstacle in metres, holes included."""
    match obstacle:
        case Circle():
            return Path.circle(obstacle.center, obstacle.radius)
        case Line():
            return polygon_path(shapely.LineString(obstacle.core).buffer(obstacle.own_radius, quad_segs=16))
        case _:
            return _ring(obstacle.core)


def _straight(obstacle: Obstacle) -> Path:
    """Return the outline in straight pieces; of curves Path itself makes as many as a circle has metres."""
    if isinstance(obstacle, Circle):
        return polygon_path(shapely.Point(obstacle.center).buffer(obstacle.radius, quad_segs=16))
    return obstacle_path(obstacle)


def _fill(axes: Axes, paths: Iterable[Path], face: str, edge: str, width: float, zorder: float) -> None:
    collection = PathCollection(
        [_near(axes, path) for path in paths], facecolors=face, edgecolors=edge, linewidths=width, zorder=zorder
    )
    collection.set_joinstyle("round")
    axes.add_collection(collection, autolim=False)


def _ring(points: FloatArray) -> Path:
    return Path(np.vstack([points, points[:1]]), closed=True)


def polygon_path(polygon: Any) -> Path:
    """Return a shapely polygon as a path, holes included."""
    rings = [polygon.exterior, *polygon.interiors]
    return Path.make_compound_path(*(Path(shapely.get_coordinates(ring), closed=True) for ring in rings))


def _room_inside(axes: Axes, obstacle: Obstacle, width: float, height: float) -> tuple[float, float] | None:
    """Return where text of that size (points) fits inside the obstacle, or None."""
    rings = _near(axes, _straight(obstacle)).to_polygons()
    if not rings:
        return None
    corners = to_points(axes, np.asarray(rings[0], dtype=np.float64))
    seen = shapely.box(0, 0, *size_in_points(axes))
    body = shapely.intersection(shapely.make_valid(shapely.Polygon(corners)), seen)
    if body.is_empty:
        return None
    centre = body.centroid
    for spot in (centre, body.representative_point(), *_steps(body)):
        if body.contains(shapely.box(spot.x - width / 2, spot.y - height / 2, spot.x + width / 2, spot.y + height / 2)):
            back = np.array([spot.x, spot.y]) / points_per_metre(axes)
            return float(back[0] + axes.get_xlim()[0]), float(back[1] + axes.get_ylim()[0])
    return None


def _steps(body: Any) -> list[Any]:
    """Return a coarse grid of points over the body."""
    x0, y0, x1, y1 = body.bounds
    grid = np.stack(np.meshgrid(np.linspace(x0, x1, 9)[1:-1], np.linspace(y0, y1, 9)[1:-1]), axis=-1)
    return list(shapely.points(grid.reshape(-1, 2)))
