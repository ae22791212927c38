"""Random scenes: seeded, always valid, starts and goals well apart."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Any, TypeAlias

import numpy as np
import shapely

from taut.errors import SceneError
from taut.generate.asked import finite, span, whole, within
from taut.generate.ends import free_part, place_ends
from taut.generate.hall import DISCS, Hall, roomy, square
from taut.generate.obstacles import DRAW, Form, draw_forms, place_obstacles
from taut.generate.warehouse import random_warehouse
from taut.scene import AtGoal, FloatArray, Obstacle, Robot, Scene
from taut.validation import validate

__all__ = ["random_scene", "random_warehouse"]

Range: TypeAlias = float | tuple[float, float]

_MOST = 1_000_000  # robots or obstacles
_SIZES = (1e-6, 1e7)  # metres: beside smaller halls the margins, beside larger ones the robots are lost in rounding
_SPARSEST = 1e-6
_LARGER = 6  # halls of chosen size that are tried, each 15 % wider


def random_scene(
    robots: int = 10,
    obstacles: int = 20,
    seed: int = 0,
    *,
    size: Range | None = None,
    density: float | None = None,
    obstacle_size: Range = (1.0, 4.0),
    radius: Range = 0.3,
    speed: Range = 1.0,
    clearance: float = 0.0,
    gap: float = 0.05,
    headway: float = 0.0,
    at_goal: AtGoal = "stay",
    shapes: Sequence[str] = ("polygon", "rectangle", "circle", "line", "nonconvex"),
    well_formed: bool = False,
    name: str | None = None,
) -> Scene:
    """Make a random scene: a rectangular hall, disjoint obstacles, robots that can reach their goals.

    The largest robot can pass between any two obstacles and between obstacles and wall. All starts and goals lie in
    one connected part of the free space of the largest robot, apart from each other by more than r_i + r_j + gap.

    Parameters
    ----------
    robots, obstacles : how many, ≥ 0.
    seed : ≥ 0; the same arguments give the same scene.
    size : side of the square hall or (width, height), 1e-6 to 1e7 metres; None chooses a hall in which the robots'
        discs take at most 5 % of the free area, at least 10 m wide.
    density : share of the hall that obstacles cover, from 1e-6 to below 1; it scales ``obstacle_size``.
    obstacle_size : diameter of the obstacles, metres, or range of it.
    radius : of the robots, metres, or range of it.
    speed : of the robots, metres a second, or range of it.
    clearance, gap, headway, at_goal : fields of the scene. Like all other numbers they are 0 or from 1e-9 to 1e7.
    shapes : drawn with equal chances from "polygon" (convex), "rectangle", "circle", "line" (zigzag wall) and
        "nonconvex" (L, U and stars).
    well_formed : every robot also has a path past the starts and goals of all others.
    name : of the scene; None names it after robots, obstacles and seed.

    Returns
    -------
    Scene with obstacles O1, O2, … from large to small and robots R1, R2, …

    Raises
    ------
    SceneError
        A parameter out of its range, or a scene that does not fit: the text says what and the mend.

    >>> scene = random_scene(robots=3, obstacles=5, seed=1)
    >>> [robot.name for robot in scene.robots]
    ['R1', 'R2', 'R3']
    >>> scene == random_scene(robots=3, obstacles=5, seed=1)
    True
    """
    n, m, seed = whole(robots, "robots", _MOST), whole(obstacles, "obstacles", _MOST), whole(seed, "seed")
    radii_range, speeds_range = span(radius, "radius"), span(speed, "speed", positive=True)
    sizes_range = span(obstacle_size, "obstacle_size", positive=True)
    share = _density(density, m)
    for value, what in ((clearance, "clearance"), (gap, "gap"), (headway, "headway")):
        span(value, what)
    given = Scene(
        (0, 0, 1, 1),
        name=f"random-{n}-{m}-{seed}" if name is None else name,
        clearance=clearance,
        gap=gap,
        headway=headway,
        at_goal=at_goal,
    )
    if n > 1 and radii_range[0] == 0.0 and given.gap == 0.0:
        raise SceneError("gap: two robots of radius 0 need a gap above 0")

    rng = np.random.default_rng(seed)
    radii = _drawn(rng, radii_range, n)
    speeds = _drawn(rng, speeds_range, n)
    forms = draw_forms(rng, m, _kinds(shapes), sizes_range)
    widest = float(radii.max(initial=0.0))
    growth = widest + given.clearance
    solids = np.array([form.solid for form in forms], dtype=object)
    if size is None:
        needed = max(
            math.pi * float(np.sum(radii**2)) / DISCS, (24 if well_formed else 12) * n * (2 * widest + given.gap) ** 2
        )
        diameters = np.array([form.diameter for form in forms], dtype=np.float64)
        side = roomy(diameters, solids, share, 2.04 * growth, max(needed, (12 * growth) ** 2))
        if not side <= _SIZES[1]:
            raise SceneError(f"robots and obstacles need a hall of {side:.3g} m, wider than {_SIZES[1]:g} m")
        halls = [square(side * 1.15**k) for k in range(_LARGER)]
    else:
        halls = [_given_hall(size)]
    for hall in halls:
        try:
            placed = _furnished(rng, hall, forms, share, growth)
            ends = _peopled(rng, hall, placed, radii, growth, given.gap, well_formed)
            break
        except SceneError:
            if hall is halls[-1]:
                raise
    team = [
        Robot(f"R{k + 1}", ends[k].tolist(), ends[n + k].tolist(), radius=float(radii[k]), speed=float(speeds[k]))
        for k in range(n)
    ]
    scene = Scene(
        (0, 0, hall.width, hall.height),
        placed,
        team,
        name=given.name,
        clearance=given.clearance,
        gap=given.gap,
        headway=given.headway,
        at_goal=given.at_goal,
    )
    try:
        validate(scene)
    except SceneError as error:  # what is a billion times smaller than the hall is lost in rounding
        raise SceneError(f"sizes are too far apart for one hall: {error.message}") from error
    return scene


def _furnished(
    rng: np.random.Generator, hall: Hall, forms: Sequence[Form], share: float | None, growth: float
) -> list[Obstacle]:
    """Place the obstacles, scaled to cover the share asked for."""
    if share is not None:
        scale = math.sqrt(share * hall.area / float(shapely.area([form.solid for form in forms]).sum()))
        forms = [form.scaled(scale) for form in forms]
    return place_obstacles(rng, hall, forms, passage=2.04 * growth + 4 * hall.margin)


def _peopled(
    rng: np.random.Generator,
    hall: Hall,
    placed: Sequence[Obstacle],
    radii: FloatArray,
    growth: float,
    gap: float,
    well_formed: bool,
) -> FloatArray:
    """Place starts (first n) and goals (last n), (2n, 2)."""
    if not len(radii):
        return np.zeros((0, 2))
    # whoever has to get round all others may be the widest: then everyone keeps the widest's distance
    kept = np.full(len(radii), radii.max()) if well_formed else radii
    return place_ends(rng, hall, free_part(hall, placed, 1.02 * growth + hall.margin), kept, gap, well_formed)


def _drawn(rng: np.random.Generator, span: tuple[float, float], count: int) -> FloatArray:
    """Draw numbers between the ends of `span`, to three digits; exactly its value when both ends are one."""
    low, high = span
    values = rng.uniform(low, high, count)
    if low == high:
        return np.full(count, low)
    return np.clip(np.round(values, 3 - math.floor(math.log10(high))), low, high)


def _density(value: float | None, obstacles: int) -> float | None:
    if value is None:
        return None
    number = finite(value, "density")
    if not 0 < number < 1:
        raise SceneError(f"density must be between 0 and 1, got {number:g}")
    if number < _SPARSEST:
        raise SceneError(f"density must be at least {_SPARSEST:g}, got {number:g}")
    if obstacles == 0:
        raise SceneError("density needs at least one obstacle")
    return number


def _kinds(shapes: Sequence[str]) -> tuple[str, ...]:
    kinds = (shapes,) if isinstance(shapes, str) else tuple(shapes)
    for kind in kinds:
        if kind not in DRAW:
            raise SceneError(f"shapes: {kind!r} is unknown, take from {', '.join(DRAW)}")
    if not kinds:
        raise SceneError(f"shapes must not be empty, take from {', '.join(DRAW)}")
    return kinds


def _given_hall(size: Any) -> Hall:
    sides = (size, size) if np.ndim(size) == 0 else tuple(size)
    if len(sides) != 2:
        raise SceneError(f"size must be a length in metres or (width, height), got {size!r}")
    width, height = (finite(side, "size") for side in sides)
    if width <= 0 or height <= 0:
        raise SceneError(f"size must be above 0 m, got {width:g} × {height:g}")
    for side in (width, height):
        within(side, _SIZES, "size", " m")
    return Hall(width, height)
