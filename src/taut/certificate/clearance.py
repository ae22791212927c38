"""Robots from obstacles and the wall: the least distance of each path to the raw shapes."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from taut.certificate._kernels import FILLED, OPEN, OUTSIDE, least_clearances, signed_distances
from taut.certificate.report import WALL, Clearance, Problem
from taut.certificate.tracks import Tracks
from taut.scene import FloatArray, Scene


@dataclass(frozen=True, eq=False)
class Shapes:
    """Obstacles and, last, the wall as sides: a point is one side of length 0.

    Parameters
    ----------
    names : of the obstacles, then "the wall".
    edges : (E, 4) sides x0, y0, x1, y1; shape o has edges[first[o]:first[o+1]].
    owner : (E,) shape of each side.
    radius : (m,) metres by which the shape reaches beyond its sides.
    kind : (m,) OPEN, FILLED or OUTSIDE (see the kernel).
    """

    names: tuple[str, ...]
    edges: FloatArray
    first: NDArray[np.int64]
    radius: FloatArray
    kind: NDArray[np.int64]

    @property
    def owner(self) -> NDArray[np.int64]:
        """Shape that each side belongs to, (E,)."""
        return np.repeat(np.arange(len(self.names)), np.diff(self.first))

    @property
    def boxes(self) -> FloatArray:
        """Bounds xmin, ymin, xmax, ymax of the sides of each shape, (m, 4)."""
        low = np.minimum.reduceat(np.minimum(self.edges[:, :2], self.edges[:, 2:]), self.first[:-1])
        high = np.maximum.reduceat(np.maximum(self.edges[:, :2], self.edges[:, 2:]), self.first[:-1])
        return np.hstack([low, high])

    def near(self, x: float, y: float, within: float) -> str:
        """Names of the shapes that contain (x, y) or come within some metres of it (else the nearest), joined."""
        distance = signed_distances(x, y, self.edges, self.first, self.radius, self.kind)
        close = np.flatnonzero(distance <= max(within, distance.min()))
        return " and ".join(self.names[o] for o in close)


def shapes_of(scene: Scene) -> Shapes:
    """Flatten the obstacles of a scene and its workspace."""
    sides, kind = [], []
    for obstacle in scene.obstacles:
        core = obstacle.core
        sides.append(_ring(core) if obstacle.closed else _chain(core))
        kind.append(FILLED if obstacle.closed else OPEN)
    sides.append(_ring(np.array(scene.workspace)))
    kind.append(OUTSIDE)
    return Shapes(
        (*(obstacle.name for obstacle in scene.obstacles), WALL),
        np.concatenate(sides),
        np.concatenate([[0], np.cumsum([len(s) for s in sides])]).astype(np.int64),
        np.array([*(obstacle.own_radius for obstacle in scene.obstacles), 0.0]),
        np.array(kind, dtype=np.int64),
    )


def check_clearance(scene: Scene, tracks: Tracks, shapes: Shapes) -> tuple[tuple[Clearance, ...], list[Problem]]:
    """Return the nearest obstacle of each robot, and a problem for each robot nearer than its growth - tol.

    Distances are those of the raw shapes, to rounding; time O(legs · obstacles), most of them by bounding boxes.
    """
    tol = scene.tol
    value, shape, stamp, where = least_clearances(
        tracks.x, tracks.y, tracks.first, shapes.edges, shapes.first, shapes.boxes, shapes.radius, shapes.kind,
        tol,
    )  # fmt: skip
    clearances, problems = [], []
    for r, robot in enumerate(scene.robots):
        distance = float(value[r])
        time, place = tracks.on_leg(int(stamp[r]), float(where[r]))
        name = shapes.names[shape[r]]
        clearances.append(Clearance(distance - robot.radius, robot.name, name, time, place))
        needed = scene.growth(robot)
        if not distance >= needed - tol:
            detail = f"its centre is {distance:.6g} m away, {needed:.6g} m needed"
            if distance < 0:
                detail = f"its centre is {-distance:.6g} m " + ("outside" if name == WALL else "inside")
            problems.append(Problem("clearance", (robot.name,), needed - distance, time, place, name, detail))
    return tuple(clearances), problems


def _chain(core: FloatArray) -> FloatArray:
    ends = core if len(core) > 1 else np.repeat(core, 2, axis=0)
    return np.hstack([ends[:-1], ends[1:]])


def _ring(core: FloatArray) -> FloatArray:
    return np.hstack([core, np.roll(core, -1, axis=0)])
