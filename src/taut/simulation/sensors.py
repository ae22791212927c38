"""What robots sense where they stand, by lidar and radio, with the thesis' settings."""

from __future__ import annotations

import math
from collections.abc import Iterable, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from taut.contact._link_kernels import GROUP, contact_spans
from taut.scene import FloatArray
from taut.simulation._lidar_kernels import blur, cast_rays
from taut.simulation.given import (
    Flags,
    Ints,
    count_of,
    fan_of,
    number_of,
    poses_of,
    positive_of,
    present_of,
    robots_of,
    rows_of,
)
from taut.simulation.surroundings import Surroundings


@dataclass(frozen=True)
class Lidar:
    """A fan of beams that measure how far it is to what they first meet.

    Parameters
    ----------
    beams : number of beams, spread evenly over ``field`` and in order; of a full turn the end is left out.
    field : radians, the beams run from −field / 2 (to the right of the heading) to field / 2; at most a full turn.
    reach : metres, > 0; what is farther gives no echo.
    noise : metres, standard deviation of each echo.
    angles : radians of each beam against the heading; in place of ``beams`` and ``field``.

    Raises
    ------
    ValueError
        A number that makes no sense.

    >>> Lidar(beams=3, field=math.pi, reach=5.0).angles
    (-1.5707963267948966, 0.0, 1.5707963267948966)
    """

    angles: tuple[float, ...]
    reach: float
    noise: float

    def __init__(
        self,
        beams: int = 181,
        field: float = math.pi,
        reach: float = 10.0,
        noise: float = 0.0,
        angles: Iterable[float] | None = None,
    ) -> None:
        given = fan_of(beams, field) if angles is None else tuple(number_of(a, "lidar: every angle") for a in angles)
        if not given:
            raise ValueError("lidar: it needs at least one beam, got no angles")
        object.__setattr__(self, "angles", given)
        object.__setattr__(self, "reach", positive_of(reach, "lidar: reach"))
        object.__setattr__(self, "noise", number_of(noise, "lidar: noise"))
        if self.noise < 0:
            raise ValueError(f"lidar: noise must not be negative, got {self.noise:g}")


THESIS_NEAR_LIDAR = Lidar(beams=9, field=math.pi, reach=3.0)
"""The lidar of the first robot of the thesis: 9 beams over ±90°, 3 m (appendix C, ``sensor1``)."""

THESIS_FAR_LIDAR = Lidar(beams=10, field=math.pi / 2, reach=10.0)
"""The lidar of the third robot of the thesis: 10 beams over ±45°, 10 m (appendix C, ``sensor3``)."""


@dataclass(frozen=True, eq=False)
class Scan:
    """What the beams of some robots' lidars tell.

    Parameters
    ----------
    robots : (k,) numbers of the robots.
    angles : (beams,) radians against the heading.
    ranges : (k, beams) metres to the first echo; where there is none, the lidar's reach. So, but for noise, all is free
        as far as the range says. MATLAB's toolbox gives NaN, which each minimum and comparison has to step round.
    hits : (k, beams) what gave the echo, as a number into ``names`` of the surroundings; −1 where there is none.
    """

    robots: Ints
    angles: FloatArray
    ranges: FloatArray
    hits: Ints

    @property
    def echo(self) -> Flags:
        """(k, beams) whether the beam came back."""
        return np.asarray(self.hits >= 0, dtype=np.bool_)


@dataclass(frozen=True)
class Radio:
    """A radio that links robots whose centres are at most ``reach`` metres apart; with ``sight``, if they are in sight.

    Raises
    ------
    ValueError
        A number that makes no sense.
    """

    reach: float
    sight: bool = False

    def __post_init__(self) -> None:
        object.__setattr__(self, "reach", positive_of(self.reach, "radio: reach"))


def scan(
    lidar: Lidar,
    surroundings: Surroundings,
    poses: ArrayLike,
    *,
    robots: Sequence[int] | Ints | None = None,
    present: ArrayLike | None = None,
    seed: int = 0,
    step: int = 0,
) -> Scan:
    """Look around with the lidars of a team: each beam ends at the first obstacle, wall or disc of another robot.

    Distances are exact to rounding: sides of polygons, circles and rounded walls are met as they are, none as polygons.
    A beam that touches a corner or grazes a circle ends there. What a robot touches to the scene's tolerance gives an
    echo at 0 to the beams that lead into it, and none to those that lead along it or away. A robot deeper within
    something, or outside the workspace, has 0 all around. Robots without radius are not seen.

    Parameters
    ----------
    poses : (n, 3) x, y in metres and θ in radians of all robots; more columns are not looked at.
    robots : numbers of those that look, all if not given.
    present : (n,) whether each robot is there, true if not given; those that are not are not seen.
    seed, step : of the noise; it is the same for the same seed, step, robot and beam, whoever else looks.

    Raises
    ------
    ValueError
        Poses that are none, not finite, or not one for each robot; a negative seed or step.
    IndexError
        A robot that is none.

    >>> from taut.scene import Robot, Scene
    >>> from taut.simulation.surroundings import surroundings_of
    >>> scene = Scene((0, 0, 4, 3), robots=[Robot("R1", (1, 1), (3, 1))])
    >>> scan(Lidar(beams=3, reach=2.5), surroundings_of(scene), [(1, 1, 0)]).ranges
    array([[1. , 2.5, 2. ]])
    """
    placed = poses_of(poses, len(surroundings.radii))
    there = present_of(present, len(placed))
    who = robots_of(robots, len(placed))
    angles = np.array(lidar.angles)
    ranges, pieces = cast_rays(
        surroundings.pieces, placed, surroundings.radii, there, who, angles, lidar.reach, surroundings.tol
    )
    if lidar.noise > 0:
        blur(ranges, pieces, who, lidar.noise, lidar.reach, count_of(seed, "seed"), count_of(step, "step"))
    return Scan(who, angles, ranges, things_of(surroundings, pieces))


def linked(
    radio: Radio, positions: ArrayLike, sides: FloatArray | None = None, present: ArrayLike | None = None
) -> Ints:
    """Return who is in contact now: pairs of robots (l, 2), the smaller number first, in order.

    As `taut.contact` means it, but that the reach has no tolerance: a radio that falls short by a hair falls short.

    Parameters
    ----------
    positions : (n, 2 or more) x, y in metres; more columns, as in poses, are not looked at.
    sides : what breaks sight, ``sight_sides(scene, scene.tol)``; a radio without sight needs none.
    present : (n,) whether each robot is there, true if not given.

    Raises
    ------
    ValueError
        Positions that are none or not finite; a radio with sight, but no sides.

    >>> linked(Radio(2.0), [(0, 0), (2, 0), (4.1, 0)]).tolist()
    [[0, 1]]
    """
    placed = rows_of(positions, 2, "positions")
    there = present_of(present, len(placed))
    i, j = np.triu_indices(len(placed), 1)
    apart = np.hypot(*(placed[i, :2] - placed[j, :2]).T)
    near = (apart <= radio.reach) & there[i] & there[j]
    pairs = np.stack([i[near], j[near]], axis=1).astype(np.int64)
    if not radio.sight:
        return pairs
    if sides is None:
        raise ValueError("a radio with sight needs the sides that break it: pass sight_sides(scene, scene.tol)")
    hiding = np.array(sides, dtype=np.float64)
    rest, for_ever = np.zeros(len(placed)), np.full(len(placed), np.inf)
    x, y = placed[:, :2].T.copy()
    stamps = np.arange(len(placed) + 1, dtype=np.int64)
    seen, _ = contact_spans(rest, x, y, stamps, for_ever, pairs, 2.0 * radio.reach, hiding, _boxes(hiding))
    return pairs[seen]


def _boxes(sides: FloatArray) -> FloatArray:
    """Bounds of each group of sides, as the kernel wants them."""
    groups = [sides[k : k + GROUP].reshape(-1, 2) for k in range(0, len(sides), GROUP)]
    return np.array([[*group.min(axis=0), *group.max(axis=0)] for group in groups]).reshape(-1, 4)


def things_of(surroundings: Surroundings, pieces: Ints) -> Ints:
    """Return to which of the surroundings' names each piece belongs, −1 for none."""
    return np.where(pieces >= 0, surroundings.owner[pieces], -1).astype(np.int64)
