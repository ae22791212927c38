"""Prepared maps after edits against maps prepared anew."""

from __future__ import annotations

from typing import Literal

import numpy as np
import pytest

import taut
from taut.errors import SceneError
from taut.freespace import FreeSpace
from taut.route import PathIndex, direct_lengths, distances, paths, prepare, with_obstacle, without_obstacle
from taut.scene import Circle, FloatArray, Obstacle, Polygon, Rectangle, Scene

KINDS: tuple[Literal["graph", "labels"], ...] = ("graph", "labels")


def obstacle(rng: np.random.Generator, size: float) -> Obstacle:
    x, y = rng.uniform(0, size, 2)
    match rng.integers(3):
        case 0:
            width, height = rng.uniform(0.3, 3, 2)
            return Rectangle(x, y, width, height, rng.uniform(0, 3))
        case 1:
            return Circle((x, y), rng.uniform(0.2, 1.5))
        case _:
            angle = np.sort(rng.uniform(0, 2 * np.pi, 5))
            radius = rng.uniform(0.3, 2)
            return Polygon([(x + radius * np.cos(a), y + radius * np.sin(a)) for a in angle])


def check(index: PathIndex, places: FloatArray) -> None:
    free = places[index.freespace.contains(places)]
    k = len(free) // 2
    a, b = free[:k], free[k : 2 * k]
    expected, _ = direct_lengths(FreeSpace(index.freespace.scene, index.freespace.growth), a, b)
    np.testing.assert_allclose(distances(index, a, b), expected, rtol=1e-9)
    there = np.isfinite(expected)
    many = paths(index, a[there], b[there])
    for j, length in enumerate(expected[there].tolist()):
        assert np.hypot(*np.diff(many[j], axis=0).T).sum() == pytest.approx(length, rel=1e-9, abs=1e-12)


@pytest.mark.parametrize("kind", KINDS)
@pytest.mark.parametrize(("seed", "growth"), [(0, 0.0), (1, 0.0), (2, 0.25), (3, 0.25)])
def test_random_edits_leave_all_distances_right(seed: int, growth: float, kind: Literal["graph", "labels"]) -> None:
    rng = np.random.default_rng(seed)
    scene = taut.random_scene(robots=0, obstacles=25, seed=seed, size=25.0)
    index = prepare(FreeSpace(scene, growth), kind)
    places = rng.uniform(0, 25, (120, 2))
    for step in range(30):
        names = [o.name for o in index.freespace.scene.obstacles]
        if rng.random() < 0.5 and names:
            index = without_obstacle(index, str(rng.choice(names)))
        else:
            index = with_obstacle(index, obstacle(rng, 25))
        if step % 3 == 2:
            check(index, places)


def test_most_pairs_are_still_answered_by_labels_after_an_edit() -> None:
    from taut.route.index import _by_labels
    from taut.route.states import attach

    scene = taut.random_scene(robots=0, obstacles=60, seed=5, size=60.0)
    index = prepare(FreeSpace(scene), "labels")
    index = with_obstacle(index, Rectangle(29, 29, 1, 1))
    places = np.random.default_rng(0).uniform(0, 60, (400, 2))
    free = places[index.freespace.contains(places)]
    ends = attach(index.freespace, index.tangents, free[: len(free) // 2 * 2])
    assert index.labelled is not None
    *_, sure = _by_labels(index, index.labelled, ends)
    assert sure.mean() > 0.5


def test_what_is_put_and_taken_back_changes_nothing() -> None:
    for kind in KINDS:
        index = prepare(FreeSpace(Scene((0, 0, 10, 10), [Rectangle(4, 4, 2, 2, name="box")])), kind)
        a, b = [(1.0, 5.0)], [(9.0, 5.0)]
        before = distances(index, a, b)
        wall = with_obstacle(index, Rectangle(2, 0, 0.5, 9, name="wall"))
        assert distances(wall, a, b) > before
        assert distances(without_obstacle(wall, "wall"), a, b) == pytest.approx(before, rel=1e-12)
        assert distances(without_obstacle(index, "box"), a, b).tolist() == [8.0]
        closed = with_obstacle(index, Rectangle(2, 0, 0.5, 10, name="wall"))
        assert np.isinf(distances(closed, a, b)).all()
        assert distances(without_obstacle(closed, "wall"), a, b) == pytest.approx(before, rel=1e-12)


def test_names_are_checked() -> None:
    index = prepare(FreeSpace(Scene((0, 0, 10, 10), [Rectangle(4, 4, 2, 2, name="box")])))
    with pytest.raises(SceneError, match="box"):
        with_obstacle(index, Rectangle(1, 1, 1, 1, name="box"))
    with pytest.raises(SceneError, match="crate"):
        without_obstacle(index, "crate")
