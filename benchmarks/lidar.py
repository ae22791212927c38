"""Measure how fast a team looks around with its lidars on one core: python benchmarks/lidar.py."""

from __future__ import annotations

import numpy as np

from measure import Table, machine, median_time
from taut.formats.files import load_scene
from taut.generate import random_scene
from taut.scene import Scene
from taut.simulation.sensors import Lidar, scan
from taut.simulation.surroundings import surroundings_of


def main() -> None:
    """Print a table: scenes, their sizes, and scans of the whole team a second."""
    scenes = {"warehouse-50": load_scene("warehouse-50"), "50 robots, 300 obstacles": random_scene(50, 300, seed=1)}
    rows = tuple(_row(name, scene, reach) for name, scene in scenes.items() for reach in (10.0, 30.0))
    heads = ("scene", "reach in m", "sides and discs", "scans of the team a second", "ns a beam")
    print(machine(), Table("Lidars of 181 beams", heads, rows), sep="\n\n")


def _row(name: str, scene: Scene, reach: float) -> tuple[str, ...]:
    surroundings = surroundings_of(scene)
    turns = np.random.default_rng(0).uniform(-np.pi, np.pi, len(scene.robots))
    poses = np.column_stack([[robot.start for robot in scene.robots], turns])
    lidar = Lidar(beams=181, reach=reach)
    scan(lidar, surroundings, poses)
    seconds = median_time(lambda: scan(lidar, surroundings, poses))
    pieces = len(surroundings.pieces.sides) + len(surroundings.pieces.discs)
    per_beam = 1e9 * seconds / (181 * len(poses))
    return name, f"{reach:g}", str(pieces), f"{1 / seconds:,.0f}", f"{per_beam:.0f}"


if __name__ == "__main__":
    main()
