"""Random warehouses: rows of shelves with aisles one robot wide, in which nobody can pass anybody."""

from __future__ import annotations

import math

import numpy as np

from taut.errors import SceneError
from taut.generate.asked import span, whole
from taut.scene import Rectangle, Robot, Scene
from taut.validation import validate

_AISLE = 1.3  # widths of a robot with its clearance: room to drive, none to pass


def random_warehouse(
    robots: int = 20,
    seed: int = 0,
    *,
    shelf: tuple[float, float] = (1.0, 4.0),
    aisle: float | None = None,
    cross: float | None = None,
    radius: float = 0.3,
    speed: float = 1.0,
    clearance: float = 0.0,
    gap: float = 0.05,
    name: str | None = None,
) -> Scene:
    """Make a warehouse: upright shelves in columns and rows, aisles between columns, cross aisles between rows.

    Every start and goal lies between two shelves, at most one in each such stretch of an aisle, and none in a cross
    aisle or beside the wall. So every robot has a way that avoids the starts and goals of all others. Half of the
    stretches hold none; the warehouse is about as wide as it is high.

    Parameters
    ----------
    robots : how many, 1 to 10,000.
    seed : ≥ 0; the same arguments give the same scene.
    shelf : width and height of a shelf, metres.
    aisle, cross : metres between columns, and between rows; None for 1.3 times what a robot with its clearance fills,
        in which no two can pass each other.
    radius, speed : of the robots, metres and metres a second.
    clearance, gap : fields of the scene.
    name : of the scene; None names it after robots and seed.

    Raises
    ------
    SceneError
        A parameter out of its range, an aisle too narrow for a robot, or shelves too short for one between them.

    >>> scene = random_warehouse(robots=3, seed=1)
    >>> len(scene.obstacles), scene.robots[0].name
    (14, 'R1')
    """
    count = whole(robots, "robots", 10_000)
    if count == 0:
        raise SceneError("robots must be at least 1: they say how large the warehouse is")
    rng = np.random.default_rng(whole(seed, "seed"))
    if np.shape(shelf) != (2,):
        raise SceneError(f"shelf must be (width, height), got {shelf!r}")
    width, length = (_number(side, "shelf") for side in shelf)
    radius, speed = _number(radius, "radius"), _number(speed, "speed")
    growth = radius + span(clearance, "clearance")[0]
    apart = 2 * radius + span(gap, "gap")[0]
    between, across = (
        2 * growth * _AISLE if given is None else _number(given, what)
        for given, what in ((aisle, "aisle"), (cross, "cross"))
    )
    for metres, what in ((between, "aisle"), (across, "cross")):
        if metres <= 2 * growth:
            raise SceneError(f"{what} is {metres:g} m wide, a robot with its clearance needs over {2 * growth:g} m")
    # who stands between two shelves leaves the cross aisles before and behind to others
    inset = 1.02 * apart - growth
    if length <= 2 * inset:
        raise SceneError(f"shelves of {length:g} m are too short: give them over {2 * inset:g} m for these robots")
    rows = max(1, round(math.sqrt(4 * count * (width + between) / (length + across))))
    aisles = 2 + math.ceil(4 * count / rows)
    shelves = [
        Rectangle(
            between + column * (width + between),
            across + row * (length + across),
            width,
            length,
            name=f"S{column + 1}-{row + 1}",
        )
        for column in range(aisles - 1)
        for row in range(rows)
    ]
    stretches = rows + rng.permutation((aisles - 2) * rows)[: 2 * count]
    x = between / 2 + stretches // rows * (width + between)
    y = across + stretches % rows * (length + across) + rng.uniform(inset, length - inset, 2 * count)
    ends = np.stack([x, y], axis=1).tolist()
    team = [Robot(f"R{k + 1}", ends[k], ends[count + k], radius=radius, speed=speed) for k in range(count)]
    size = aisles * (width + between) - width, rows * (length + across) + across
    scene = Scene((0, 0, *size), shelves, team, name=name or f"warehouse-{count}-{seed}", clearance=clearance, gap=gap)
    validate(scene)
    return scene


def _number(value: float, what: str) -> float:
    return span(value, what, positive=True)[0]
