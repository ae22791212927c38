"""Teams that look around with their lidars: scans a second on one core, and the same rays with Shapely."""

from __future__ import annotations

import numpy as np
import shapely
from numpy.typing import NDArray

from measure import Table, in_words, median_time
from taut.formats.files import load_scene
from taut.generate import random_scene
from taut.scene import FloatArray, Scene
from taut.simulation.sensors import Lidar, Scan, scan
from taut.simulation.surroundings import surroundings_of

Flags = NDArray[np.bool_]

BEAMS = 181
TITLE = "Simulation: lidars"


def looking(quick: bool) -> Table:
    """Return one row a scene and reach."""
    scenes = {"warehouse-50": load_scene("warehouse-50")}
    if not quick:
        scenes["50 robots, 300 obstacles"] = random_scene(50, 300, seed=1)
    rows = tuple(_row(name, scene, reach) for name, scene in scenes.items() for reach in (10.0, 30.0))
    heads = (
        "scene",
        "reach",
        "sides and discs",
        "scans a second",
        "ns a beam",
        "with Shapely",
        "÷ taut's",
        "differs by",
    )
    return Table(
        TITLE,
        heads,
        rows,
        f"Scans of the whole team, {BEAMS} beams over 180° for each robot; on one core.",
        (
            "with Shapely: one scan; the beams as lines, an STRtree over the outlines of obstacles, robots "
            "and wall, the nearest point of all cuts.",
            "differs by: at most, metres, of beams that end at polygons; Shapely takes round ones for polygons.",
        ),
    )


def _row(name: str, scene: Scene, reach: float) -> tuple[str, ...]:
    surroundings = surroundings_of(scene)
    turns = np.random.default_rng(0).uniform(-np.pi, np.pi, len(scene.robots))
    poses = np.column_stack([[robot.start for robot in scene.robots], turns])
    lidar = Lidar(beams=BEAMS, reach=reach)
    found = scan(lidar, surroundings, poses)
    spent = median_time(lambda: scan(lidar, surroundings, poses))
    outlines = _outlines(scene)
    others = _scan_with_shapely(lidar, outlines, poses)
    other_spent = median_time(lambda: _scan_with_shapely(lidar, outlines, poses), most=3)
    straight = _ends_at_a_side(found, scene)
    pieces = len(surroundings.pieces.sides) + len(surroundings.pieces.discs)
    return (
        name,
        f"{reach:g} m",
        str(pieces),
        f"{1 / spent:,.0f}",
        f"{1e9 * spent / (BEAMS * len(poses)):.0f}",
        in_words(other_spent),
        f"{other_spent / spent:,.0f} ×",
        f"{np.abs(found.ranges - others)[straight].max():.1e}",
    )


def _outlines(scene: Scene) -> shapely.STRtree:
    """Outlines of obstacles, of the wall and of the robots' discs, the robots last."""
    solid = [shapely.polygons(o.core) for o in scene.obstacles if o.closed]
    for obstacle in scene.obstacles:
        if not obstacle.closed:
            core = obstacle.core
            spine = shapely.linestrings(core) if len(core) > 1 else shapely.points(core[0])
            solid.append(shapely.buffer(spine, obstacle.own_radius))
    discs = [shapely.buffer(shapely.Point(robot.start), robot.radius) for robot in scene.robots]
    return shapely.STRtree(shapely.boundary([*solid, shapely.polygons(np.array(scene.workspace)), *discs]))


def _scan_with_shapely(lidar: Lidar, outlines: shapely.STRtree, poses: FloatArray) -> FloatArray:
    """Ranges (n, beams)."""
    n, beams = len(poses), len(lidar.angles)
    angles = poses[:, 2, None] + np.array(lidar.angles)
    eyes = np.repeat(poses[:, :2], beams, axis=0)
    ends = eyes + lidar.reach * np.column_stack([np.cos(angles).ravel(), np.sin(angles).ravel()])
    lines = shapely.linestrings(np.stack([eyes, ends], axis=1))
    line, outline = outlines.query(lines, predicate="intersects")
    foreign = outline - (len(outlines) - n) != line // beams
    line, outline = line[foreign], outline[foreign]
    cuts = shapely.intersection(lines[line], outlines.geometries[outline])
    ranges = np.full(n * beams, lidar.reach)
    np.minimum.at(ranges, line, shapely.distance(shapely.points(eyes[line]), cuts))
    return ranges.reshape(n, beams)


def _ends_at_a_side(found: Scan, scene: Scene) -> Flags:
    """Tell of every beam (k, beams) whether it ends at a polygon or the wall."""
    closed = [obstacle.closed for obstacle in scene.obstacles]
    straight = np.array([*closed, True, *[False] * len(scene.robots)])
    return np.asarray(found.echo & straight[found.hits])
