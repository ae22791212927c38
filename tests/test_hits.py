"""Hits name what a path comes too near to, and agree with the certificate."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from strategies import scenes
from taut.certificate import certify
from taut.errors import GoalBlocked, StartBlocked
from taut.generate import random_scene
from taut.motion import Plan, Trajectory
from taut.route.hits import Hit, hits_of
from taut.scene import Circle, FloatArray, Line, Point, Polygon, Robot, Scene
from taut.validation import validate

PLACES = st.tuples(*[st.integers(0, 16).map(lambda k: k / 2) | st.floats(0, 8).map(lambda x: round(x, 6))] * 2)
GROWTHS = st.sampled_from([0.0, 0.0, 0.125, 0.5]) | st.floats(0.01, 0.6)


def box(x0: float, y0: float, x1: float, y1: float, name: str = "") -> Polygon:
    return Polygon([(x0, y0), (x1, y0), (x1, y1), (x0, y1)], name)


def usable(scene: Scene) -> bool:
    try:
        validate(scene)
    except (StartBlocked, GoalBlocked):
        return False
    return True


def check_against_certificate(scene: Scene, places: FloatArray, growth: float) -> None:
    """A path has no hits exactly when the motion along it is proved; what the proof names is among them."""
    length = np.hypot(*np.diff(places, axis=0).T)
    points = places[np.append(True, length > 0)]
    times = np.append(0.0, np.cumsum(length[length > 0] * (1 + 1e-12)))
    (x0, y0), (x1, y1) = points[[0, -1]].tolist()
    alone = replace(scene, robots=(Robot("R", (x0, y0), (x1, y1), growth),), clearance=0.0)
    if not usable(alone):
        return
    certificate = certify(Plan(alone, (Trajectory("R", np.column_stack([times, points])),)))
    hits = hits_of(scene, points, growth)
    assert certificate.ok == (not hits), (hits, [str(p) for p in certificate.problems])
    named = {name for hit in hits for name in hit.obstacles}
    for problem in certificate.problems:
        assert problem.kind in ("clearance", "crossing")
        assert problem.kind == "crossing" or problem.obstacle in named


@settings(max_examples=300, deadline=None)
@given(scenes(max_robots=0), st.lists(PLACES, min_size=2, max_size=5), GROWTHS)
def test_hits_agree_with_the_certificate(scene: Scene, places: list[Point], growth: float) -> None:
    check_against_certificate(scene, np.array(places, dtype=np.float64), growth)


@pytest.mark.parametrize("seed", range(30))
def test_hits_agree_with_the_certificate_on_random_maps(seed: int) -> None:
    growth = (0.0, 0.1, 0.3)[seed % 3]
    scene = random_scene(robots=6, obstacles=25, radius=growth, gap=0.1, density=0.15, seed=seed)
    rng = np.random.default_rng(seed)
    for robot in scene.robots:
        bend = rng.uniform(1, scene.workspace[2][0] - 1, (1, 2))
        points = np.concatenate([[robot.start], bend, [robot.goal]])
        check_against_certificate(scene, points, growth)


HALL = (0.0, 0.0, 10.0, 8.0)
BESIDE = [box(3, 2, 5, 4, "low"), box(5, 4, 7, 6, "high")]  # they touch at (5, 4)
TWINS = [box(3, 2, 5, 6, "left"), box(5, 2, 7, 6, "right")]  # they share a side at x = 5


@pytest.mark.parametrize(
    ("obstacles", "path", "hit"),
    [
        (BESIDE, [(4, 5), (6, 3)], Hit(("low", "high"), (5, 4), 0)),
        (BESIDE, [(4, 5), (5, 4), (6, 3)], Hit(("low", "high"), (5, 4), 0)),
        (BESIDE, [(4, 5), (5, 4), (5, 4), (6, 3)], Hit(("low", "high"), (5, 4), 0)),
        (BESIDE, [(4, 5), (5, 4), (5, 2)], Hit(("low", "high"), (5, 4), 0)),
        (BESIDE, [(3, 4), (5, 4), (5, 6)], None),
        (BESIDE, [(3, 4), (7, 4)], Hit(("low", "high"), (5, 4), 0)),
        (BESIDE, [(5, 4), (4, 5)], None),
        (TWINS, [(5, 1), (5, 7)], Hit(("left", "right"), (5, 2), 0)),
        (TWINS, [(5, 1), (5, 3), (5, 1)], Hit(("left", "right"), (5, 2), 0)),
        (TWINS, [(5, 1), (5, 2), (4, 1)], None),
        (TWINS, [(5, 3), (5, 5)], Hit(("left", "right"), (5, 4), 0)),
        (TWINS, [(2, 2), (8, 2)], None),
        ([box(3, 0, 5, 2, "box")], [(1, 0), (3, 0), (3, 2), (5, 2), (5, 0), (9, 0)], None),
        ([box(3, 0, 5, 2, "box")], [(1, 0), (9, 0)], Hit(("box", "the wall"), (3, 0), 0)),
        ([Polygon([(4, 0), (6, 3), (2, 3)], "cone")], [(2, 0), (6, 0)], Hit(("cone", "the wall"), (4, 0), 0)),
        ([Circle((4, 2), 1, "disc"), box(3, 3, 5, 4, "lid")], [(1, 3), (9, 3)], Hit(("disc", "lid"), (4, 3), 0)),
        ([Circle((4, 2), 1, "disc")], [(1, 3), (9, 3)], None),
        ([Line([(3, 2), (5, 2)], 2.0, "bar")], [(1, 3), (9, 3)], None),
        ([], [(1, 1), (9, 1), (9, 9)], Hit(("the wall",), (9, 8), 1)),
    ],
    ids=str,
)  # fmt: skip
def test_a_point_may_touch_but_not_pass_between_what_touches(
    obstacles: list[Polygon], path: list[Point], hit: Hit | None
) -> None:
    scene = Scene(HALL, obstacles)
    hits = hits_of(scene, path, 0.0)
    assert hits[:1] == (() if hit is None else (hit,))
    check_against_certificate(scene, np.array(path, dtype=np.float64), 0.0)
    if hits:
        turned = hits_of(scene, path[::-1], 0.0)
        assert {name for h in turned for name in h.obstacles} == {name for h in hits for name in h.obstacles}


def test_hits_come_in_the_order_of_the_path_each_once() -> None:
    pillars = [Circle((x, 4), 0.5, name) for x, name in ((7, "third"), (2, "first"), (4.5, "second"))]
    hits = hits_of(Scene(HALL, pillars), [(0.5, 4), (5, 4), (9.5, 4), (1, 4)], growth=0.25)
    assert hits == (
        Hit(("first",), (1.25, 4), 0),
        Hit(("second",), (3.75, 4), 0),
        Hit(("third",), (6.25, 4), 1),
    )


def test_one_point_is_a_path() -> None:
    scene = Scene(HALL, [Circle((2, 4), 0.5, "pillar")])
    assert hits_of(scene, [(5, 4)], 1.0) == ()
    assert hits_of(scene, [(2.75, 4)], 1.0) == (Hit(("pillar",), (2.75, 4), 0),)
    assert hits_of(scene, [(9.5, 4)], 1.0) == (Hit(("the wall",), (9.5, 4), 0),)


def test_no_path_is_refused() -> None:
    with pytest.raises(ValueError, match="at least one point"):
        hits_of(Scene(HALL), np.empty((0, 2)), 0.0)


@pytest.mark.parametrize("growth", [math.nan, -1.0, math.inf])
def test_a_growth_that_is_none_is_refused(growth: float) -> None:
    scene = Scene((0, 0, 10, 10), [box(4, 3, 6, 7)])
    with pytest.raises(ValueError, match="growth"):
        hits_of(scene, [(1, 5), (9, 5)], growth)
    with pytest.raises(ValueError, match="finite"):
        hits_of(scene, [(math.nan, 1)], 0.1)
