"""The tracking margin: how much free space a plan must leave so that vehicles which stray still meet nobody."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import ArrayLike
from scipy.special import bdtr

from taut.errors import SceneError
from taut.scene import Scene

SLACK = 0.05
"""Part of the gap that coordination gives up: robots that pass each other as near as they may, in a ring and all at one
instant, can then be late by different times. So in a run, margins aside, they keep the rest of it."""


@dataclass(frozen=True)
class Margin:
    """How far no robot of a run strays, with a stated probability.

    Parameters
    ----------
    metres : the margin.
    probability : that a new run of the same kind keeps within it, at least.
    confidence : with which the probability is stated; the study's runs might have been lucky.
    runs : of the study.
    """

    metres: float
    probability: float
    confidence: float
    runs: int

    def __post_init__(self) -> None:
        if not (math.isfinite(self.metres) and self.metres >= 0):
            raise SceneError(f"a margin must be a finite number of metres of at least 0, got {self.metres:g}")
        for name in ("probability", "confidence"):
            if not 0 < getattr(self, name) < 1:
                raise SceneError(f"the {name} of a margin must be above 0 and below 1, got {getattr(self, name):g}")
        if self.runs < 1:
            raise SceneError(f"a margin needs at least one run, got {self.runs}")


def tracking_margin(strays: ArrayLike, probability: float = 0.999, confidence: float = 0.95) -> Margin:
    """Find the margin within which a new run keeps with a probability, whatever the distribution.

    Parameters
    ----------
    strays : (N,) metres, the greatest of each run; the runs independent, by seed.
    probability, confidence : in (0, 1). Where the runs are too few for the probability, the greatest stray is returned
        with the probability that it can be stated for; `runs_needed` tells how many would do.

    Raises
    ------
    SceneError
        No runs, a stray that is negative or not finite, a probability or confidence outside (0, 1).

    Notes
    -----
    One-sided tolerance bound by order statistics (Wilks, "Determination of sample sizes for setting tolerance limits",
    Annals of Mathematical Statistics 12, 1941). The k-th smallest of N strays is at least the p-quantile of their
    distribution with confidence P(B ≤ k − 1), B binomial with N trials of probability p; the smallest k is taken for
    which this reaches the confidence asked. The greatest of N has confidence 1 − pᴺ.

    >>> tracking_margin([0.01, 0.03, 0.02], probability=0.3)
    Margin(metres=0.03, probability=0.3, confidence=0.95, runs=3)
    """
    try:
        values = np.sort(np.asarray(strays, dtype=np.float64).ravel())
    except (TypeError, ValueError):
        raise SceneError("strays must be finite numbers of metres of at least 0") from None
    if not values.size:
        raise SceneError("a margin needs at least one run")
    if not (np.isfinite(values).all() and values[0] >= 0):
        raise SceneError("strays must be finite numbers of metres of at least 0")
    _check_shares(probability, confidence)
    runs = values.size
    reached = np.flatnonzero(bdtr(np.arange(runs), runs, probability) >= confidence)
    if reached.size:
        return Margin(float(values[reached[0]]), probability, confidence, runs)
    return Margin(float(values[-1]), (1.0 - confidence) ** (1.0 / runs), confidence, runs)


def runs_needed(probability: float = 0.999, confidence: float = 0.95) -> int:
    """Return how many runs a study needs at least to state a probability with some confidence.

    Raises
    ------
    SceneError
        A probability or confidence outside (0, 1).

    >>> runs_needed(0.999)
    2995
    """
    _check_shares(probability, confidence)
    return math.ceil(math.log1p(-confidence) / math.log(probability))


def with_margin(scene: Scene, metres: float) -> Scene:
    """Return the scene with room for vehicles that stray: clearance grown by the margin, the gap by twice it and more.

    In a plan for it, followed with coordination, robots that keep within the margin of their paths keep the clearance
    and the gap of the scene given: each is at most that far from a place that is clear of obstacles by it, and two of
    them from places apart by twice it. As coordination gives up a part `SLACK` of the gap g that a plan keeps, that is
    (g + 2 metres) / (1 − SLACK).

    Raises
    ------
    SceneError
        The margin is negative or not finite.

    >>> round(with_margin(Scene((0, 0, 4, 3), gap=0.09), 0.05).gap, 9)
    0.2
    """
    if not (math.isfinite(metres) and metres >= 0):
        raise SceneError(f"a margin must be a finite number of metres of at least 0, got {metres:g}")
    robots = tuple(
        robot if robot.clearance is None else replace(robot, clearance=robot.clearance + metres)
        for robot in scene.robots
    )
    return replace(scene, robots=robots, clearance=scene.clearance + metres, gap=(scene.gap + 2 * metres) / (1 - SLACK))


def _check_shares(probability: float, confidence: float) -> None:
    for name, value in (("probability", probability), ("confidence", confidence)):
        if not 0 < value < 1:
            raise SceneError(f"the {name} must be above 0 and below 1, got {value:g}")
