"""Large teams of our own: exact calls of `taut random` and `taut random-warehouse`, and what is aimed at."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

from taut.generate import random_scene, random_warehouse
from taut.scene import Scene


@dataclass(frozen=True)
class Large:
    """Scenes of one kind.

    Parameters
    ----------
    family : its name.
    scene : the scene of each number.
    numbers : those that are planned.
    budget : seconds given to planning.
    command : that makes scene N of them.
    aim : in words.
    """

    family: str
    scene: Callable[[int], Scene]
    numbers: tuple[int, ...]
    budget: float
    command: str
    aim: str


def _hall(robots: int, obstacles: int, size: int) -> Callable[[int], Scene]:
    return lambda seed: random_scene(robots=robots, obstacles=obstacles, size=size, seed=seed)


LARGE = (
    Large(
        "hall-1000",
        _hall(1000, 400, 200),
        (1,),
        30.0,
        "taut random --robots 1000 --obstacles 400 --size 200 --seed N",
        "a certified plan within 8 s, at most 1.3 % above the bound after 30 s",
    ),
    Large(
        "hall-2000",
        _hall(2000, 400, 280),
        (1,),
        1.0,
        "taut random --robots 2000 --obstacles 400 --size 280 --seed N",
        "a certified plan within 25 s",
    ),
    Large(
        "hall-5000",
        _hall(5000, 400, 500),
        (1,),
        1.0,
        "taut random --robots 5000 --obstacles 400 --size 500 --seed N",
        "a certified plan within 4 minutes and 4 GiB",
    ),
    Large(
        "warehouse-300",
        lambda seed: random_warehouse(robots=300, seed=seed),
        tuple(range(1, 11)),
        1.0,
        "taut random-warehouse --robots 300 --seed N",
        "a certified plan within 15 s, ten seeds of ten",
    ),
)
