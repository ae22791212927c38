"""What a robot's camera names: the nearest point seen of each thing in its field of view, in closed form."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from taut.certificate.report import WALL
from taut.scene import FloatArray, Point
from taut.simulation._lidar_kernels import cast_rays
from taut.simulation.given import TURN, Flags, Ints, field_of, poses_of, positive_of, present_of, robots_of, rows_of
from taut.simulation.sensors import things_of
from taut.simulation.surroundings import Surroundings

_SLIVER = 2.0**-46
"""Radians; what seems to be seen in less is rounding."""


@dataclass(frozen=True)
class Detector:
    """A camera that names what it sees, with distance and bearing.

    Parameters
    ----------
    field : radians; seen is what lies within field / 2 on either side of the heading; at most a full turn.
    reach : metres, > 0.

    Raises
    ------
    ValueError
        A number that makes no sense.
    """

    field: float = math.pi / 3
    reach: float = 5.0

    def __post_init__(self) -> None:
        object.__setattr__(self, "field", field_of(self.field, "detector"))
        object.__setattr__(self, "reach", positive_of(self.reach, "detector: reach"))


THESIS_DETECTOR = Detector(field=math.pi / 4, reach=5.0)
"""The detector of the second robot of the thesis: 45° in all (appendix C, ``sensor2``).

Its range is not set there, so it is that of the Mobile Robotics Simulation Toolbox, 5 m.
"""


@dataclass(frozen=True)
class Detection:
    """Something seen: its name, metres to the nearest point seen of it, and radians to there from the heading."""

    name: str
    distance: float
    bearing: float


def detect(
    detector: Detector,
    surroundings: Surroundings,
    poses: ArrayLike,
    robot: int,
    *,
    points: Mapping[str, Point] | None = None,
    present: ArrayLike | None = None,
) -> tuple[Detection, ...]:
    """Name what a robot sees, the nearest first: obstacles, other robots, and points such as goals; not the wall.

    An obstacle or robot is seen if a point of it lies within field and reach and the segment to that point meets
    nothing else first; the rim of what is seen counts as seen. Its distance and bearing are those of the nearest such
    point, and 0 where that is touched. Robots without radius, and ``points``, are seen if the segment to them meets
    nothing first, to the scene's tolerance. Within an obstacle or robot nothing is seen but that.

    Parameters
    ----------
    poses : (n, 3) x, y in metres and θ in radians of all robots.
    robot : number of the one that looks.
    points : other things to look for, by name; they hide nothing.
    present : (n,) whether each robot is there, true if not given.

    Raises
    ------
    ValueError
        Poses or points that are none or not finite, or poses not one for each robot.
    IndexError
        A robot that is none.

    Notes
    -----
    Modelled on the object detector of the Mobile Robotics Simulation Toolbox, which knows points only. Between two
    neighbouring directions to corners, tangents and crossings the same piece is in front: one ray tells which, and its
    nearest point there is found in closed form. O(k) rays for k pieces within reach. Where the disc of a robot overlaps
    something else, the distance is that of a point seen, but maybe not of the nearest.

    >>> from taut.scene import Circle, Robot, Scene
    >>> from taut.simulation.surroundings import surroundings_of
    >>> scene = Scene((0, 0, 9, 4), [Circle((5, 2), 1)], [Robot("R1", (1, 2), (8, 2))])
    >>> detect(Detector(), surroundings_of(scene), [(1, 2, 0)], 0, points={"goal": (8, 2)})
    (Detection(name='O1', distance=3.0, bearing=0.0),)
    """
    placed = poses_of(poses, len(surroundings.radii))
    there = present_of(present, len(placed))
    who = robots_of([robot], len(placed))
    pose = placed[who[0], :3]

    def look(bearings: FloatArray) -> tuple[FloatArray, Ints]:
        ranges, pieces = cast_rays(
            surroundings.pieces, placed, surroundings.radii, there, who, bearings, detector.reach, surroundings.tol
        )
        return ranges[0], pieces[0]

    others = there & (np.arange(len(placed)) != who[0])
    sides, discs = _about(surroundings, placed, others, pose)
    low, high = _gaps(_cuts(sides, discs, _local(surroundings.crossings, pose), detector))
    ranges, pieces = look((low + high) / 2)
    distances, bearings = _nearest(sides, discs, pieces, ranges, low, high)
    things = things_of(surroundings, pieces)
    found = [
        Detection(surroundings.names[thing], float(distances[k]), float(bearings[k]))
        for thing in np.unique(things[things >= 0])
        for k in [np.flatnonzero(things == thing)[np.argmin(distances[things == thing])]]
        if surroundings.names[thing] != WALL
    ]
    bare = np.flatnonzero(others & (surroundings.radii == 0))
    names = [*(surroundings.names[len(surroundings.names) - len(placed) + r] for r in bare), *(points or {})]
    given = rows_of(list((points or {}).values()), 2, "points")
    marks = _local(np.concatenate([placed[bare, :2], given[:, :2]]), pose)
    distances, bearings = np.hypot(marks[:, 0], marks[:, 1]), _bearings(marks)
    free, _ = look(bearings)
    seen = (distances <= np.minimum(free + surroundings.tol, detector.reach)) & (abs(bearings) <= detector.field / 2)
    found += [Detection(names[k], float(distances[k]), float(bearings[k])) for k in np.flatnonzero(seen)]
    return tuple(sorted(found, key=lambda one: one.distance))


def _about(
    surroundings: Surroundings, poses: FloatArray, others: Flags, pose: FloatArray
) -> tuple[FloatArray, FloatArray]:
    """Sides and discs, robots among them, as the robot sees them: it at the origin, its heading along x."""
    sides, discs = surroundings.pieces.sides, surroundings.pieces.discs
    robots = np.column_stack([poses[:, :2], np.where(others, surroundings.radii, 0.0)])
    round_ = np.concatenate([discs, robots])
    return (
        np.hstack([_local(sides[:, :2], pose), _local(sides[:, 2:], pose)]),
        np.hstack([_local(round_[:, :2], pose), round_[:, 2:]]),
    )


def _local(points: FloatArray, pose: FloatArray) -> FloatArray:
    c, s = math.cos(pose[2]), math.sin(pose[2])
    return np.asarray((points - pose[:2]) @ np.array([[c, -s], [s, c]]), dtype=np.float64)


def _cuts(sides: FloatArray, discs: FloatArray, crossings: FloatArray, detector: Detector) -> FloatArray:
    """Bearings within the field, in order, between which what is in front is one piece all along or beyond reach."""
    reach = detector.reach
    a, b = sides[:, :2], sides[:, 2:]
    corners = np.concatenate([a, b, crossings])
    corners = corners[np.hypot(corners[:, 0], corners[:, 1]) <= reach]
    away, radius = np.hypot(discs[:, 0], discs[:, 1]), discs[:, 2]
    with np.errstate(divide="ignore", invalid="ignore"):  # what does not reach so far has no such cut
        tangent = np.arcsin(radius / away)
        leaving = np.arccos((away**2 + reach**2 - radius**2) / (2 * away * reach))
    middle = np.where((radius > 0) & (away - radius <= reach), _bearings(discs[:, :2]), np.nan)
    cuts = [_bearings(corners), _bearings(_on_circle(a, b, reach))]
    cuts += [middle - tangent, middle + tangent, middle - leaving, middle + leaving]
    within = np.concatenate(cuts)
    within = (within[np.isfinite(within)] + math.pi) % TURN - math.pi
    half = detector.field / 2
    return np.unique(np.concatenate([[-half, half], within[abs(within) < half]]))


def _on_circle(a: FloatArray, b: FloatArray, radius: float) -> FloatArray:
    """Where segments cross a circle about the origin."""
    along = b - a
    length = np.hypot(along[:, 0], along[:, 1])
    middle = -(a * along).sum(axis=1) / length
    beside = (a[:, 0] * along[:, 1] - a[:, 1] * along[:, 0]) / length
    half = np.sqrt(np.maximum(radius**2 - beside**2, 0.0))
    s = np.concatenate([middle - half, middle + half]) / np.tile(length, 2)
    met = (s >= 0) & (s <= 1) & np.tile(abs(beside) <= radius, 2)
    return np.asarray((np.tile(a, (2, 1)) + s[:, None] * np.tile(along, (2, 1)))[met], dtype=np.float64)


def _gaps(cuts: FloatArray) -> tuple[FloatArray, FloatArray]:
    wide = np.diff(cuts) > _SLIVER
    return cuts[:-1][wide], cuts[1:][wide]


def _nearest(
    sides: FloatArray, discs: FloatArray, pieces: Ints, ranges: FloatArray, low: FloatArray, high: FloatArray
) -> tuple[FloatArray, FloatArray]:
    """Distance and bearing of the nearest point, between two bearings each, of the piece in front there."""
    straight, rounded = (pieces >= 0) & (pieces < len(sides)), pieces >= len(sides)
    segments, circles = sides[pieces[straight]], discs[pieces[rounded] - len(sides)]
    toward = np.ones((len(pieces), 2))
    toward[straight], toward[rounded] = _feet(segments), circles[:, :2]
    bearings = _bearings(toward)
    bearings = np.clip(bearings + TURN * np.round(((low + high) / 2 - bearings) / TURN), low, high)
    way = np.stack([np.cos(bearings), np.sin(bearings)], axis=1)
    distances = np.full(len(pieces), np.inf)
    with np.errstate(divide="ignore", invalid="ignore"):  # of what is touched, at distance 0 in any case
        distances[straight] = _to_sides(segments, way[straight])
        distances[rounded] = _to_discs(circles, way[rounded])
    touched = (pieces >= 0) & (ranges == 0)
    return np.where(touched, 0.0, distances), np.where(touched, 0.0, bearings)


def _feet(sides: FloatArray) -> FloatArray:
    """Points of the lines through sides that are nearest to the origin."""
    a, along = sides[:, :2], sides[:, 2:] - sides[:, :2]
    return np.asarray(a - ((a * along).sum(axis=1) / (along**2).sum(axis=1))[:, None] * along, dtype=np.float64)


def _to_sides(sides: FloatArray, way: FloatArray) -> FloatArray:
    """Distances from the origin, along unit vectors, to sides in those directions."""
    a, b = sides[:, :2], sides[:, 2:]
    p, q = _cross(way, a), _cross(way, b)
    place = a + np.clip(p / (p - q), 0.0, 1.0)[:, None] * (b - a)
    return np.asarray(np.hypot(place[:, 0], place[:, 1]), dtype=np.float64)


def _to_discs(discs: FloatArray, way: FloatArray) -> FloatArray:
    """Distances from the origin, along unit vectors, to discs in those directions."""
    centre, radius = discs[:, :2], discs[:, 2]
    away = np.hypot(centre[:, 0], centre[:, 1])
    half = np.sqrt(np.maximum(radius**2 - _cross(way, centre) ** 2, 0.0))
    return np.asarray((away - radius) * (away + radius) / ((way * centre).sum(axis=1) + half), dtype=np.float64)


def _bearings(points: FloatArray) -> FloatArray:
    return np.asarray(np.arctan2(points[:, 1], points[:, 0]), dtype=np.float64)


def _cross(a: FloatArray, b: FloatArray) -> FloatArray:
    return np.asarray(a[:, 0] * b[:, 1] - a[:, 1] * b[:, 0], dtype=np.float64)
