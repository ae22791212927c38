"""Maps of tens of thousands of corners, and shapes that break fixed buffers and rounded predicates."""

from __future__ import annotations

import math

import numpy as np
import pytest
import shapely

from taut.freespace import FreeSpace
from taut.geometry.seeing import see_from
from taut.roadmap import visibility_graph
from taut.route import distances, paths, prepare, shortest_path
from taut.scene import FloatArray, Polygon, Rectangle, Scene


def star(points: int, inner: float = 1.0, outer: float = 2.0) -> FloatArray:
    angle = math.pi * np.arange(2 * points) / points
    radius = np.where(np.arange(2 * points) % 2, outer, inner)
    return np.stack([radius * np.cos(angle), radius * np.sin(angle)], axis=1)


def test_the_middle_of_a_star_courtyard_sees_fifty_thousand_corners() -> None:
    mesh = FreeSpace(Scene([tuple(p) for p in star(25_000).tolist()])).mesh
    middle = np.zeros((1, 2))
    _, seen = see_from(mesh, middle, mesh.locate(middle), np.ones(len(mesh.wedges), dtype=bool), taut=False)
    assert len(seen) == len(np.unique(seen)) == len(mesh.vertices) == 50_000


def test_a_corner_that_sees_thousands_has_thousands_of_edges() -> None:
    """A pin in the middle of a ring of 1,200 triangles that point at it: it sees the two far corners of each."""
    count = 1200
    angle = 2 * math.pi * (np.arange(count) + 0.5) / count
    out = np.stack([np.cos(angle), np.sin(angle)], axis=1)
    across = np.stack([-out[:, 1], out[:, 0]], axis=1) * 0.4 * math.pi / count
    teeth = [
        Polygon([tuple(9 * o), tuple(9.5 * o + 9 * a), tuple(9.5 * o - 9 * a)])
        for o, a in zip(out, across, strict=True)
    ]
    graph = visibility_graph(FreeSpace(Scene((-10, -10, 10, 10), teeth)), points=[(0, 0)]).graph
    assert graph.indptr[-1] - graph.indptr[-2] == 2 * count


def test_thousands_of_collinear_corners_are_joined_one_by_one() -> None:
    squares = [Rectangle(2 * k, 1, 1, 1) for k in range(1500)]
    space = FreeSpace(Scene((-1, 0, 3001, 3), squares))
    tangents = visibility_graph(space)
    flat = (tangents.positions[tangents.edges][:, :, 1] == 1).all(axis=1)
    assert flat.sum() == 2 * 1500 - 1
    assert shortest_path(space, (0, 1), (2999, 1)).length == 2999
    assert distances(prepare(space), [(0, 1)], [(2999, 1)]).tolist() == [2999]


@pytest.mark.parametrize("arms", [10, 1000])
def test_a_comb_is_walked_round_every_tooth(arms: int) -> None:
    teeth = [Rectangle(2 * k, 0 if k % 2 else 1, 1, 9) for k in range(arms)]
    space = FreeSpace(Scene((-1, 0, 2 * arms, 10), teeth))
    route = shortest_path(space, (-0.5, 5), (2 * arms - 0.5, 5))
    expected = 2 * math.hypot(0.5, 4) + arms * 1 + (arms - 1) * math.hypot(1, 8)
    assert route.length == pytest.approx(expected, rel=1e-12)
    assert distances(prepare(space), [(-0.5, 5)], [(2 * arms - 0.5, 5)])[0] == pytest.approx(expected, rel=1e-12)


def test_a_spiral_has_one_way_in() -> None:
    turns = 60
    line = [(0.0, 0.0)]
    for k in range(1, 4 * turns):
        x, y = line[-1]
        dx, dy = [(1, 0), (0, 1), (-1, 0), (0, -1)][k % 4]
        line.append((x + dx * (k // 2 + 1), y + dy * (k // 2 + 1)))
    wall = shapely.LineString(line).buffer(0.1, cap_style="flat", join_style="mitre")
    corners = shapely.get_coordinates(wall.exterior)[:-1].tolist()
    x0, y0, x1, y1 = wall.bounds
    space = FreeSpace(Scene((x0 - 1, y0 - 1, x1 + 1, y1 + 1), [Polygon([tuple(p) for p in corners])]))
    inside, outside = (0.5, -0.5), (x0 - 0.5, y0 - 0.5)
    route = shortest_path(space, inside, outside)
    many = paths(prepare(space), [inside], [outside])
    assert route.length == pytest.approx(many.lengths[0], rel=1e-12)
    assert route.length > 3.9 * turns * turns
    np.testing.assert_array_equal(route.points, many[0])


@pytest.mark.parametrize("factor", [1e-6, 1e7])
def test_a_scaled_map_has_scaled_lengths(factor: float) -> None:
    rng = np.random.default_rng(3)
    boxes = [(x, y, *rng.uniform(0.2, 0.9, 2)) for x in range(20) for y in range(20)]
    places = rng.uniform(0, 20, (200, 2))
    lengths = []
    for scale in (1.0, factor):
        scene = Scene((0, 0, 20 * scale, 20 * scale), [Rectangle(*(scale * v for v in box)) for box in boxes])
        space = FreeSpace(scene)
        if scale == 1.0:
            places = places[space.contains(places)]
            k = len(places) // 2
        lengths.append(distances(prepare(space), scale * places[:k], scale * places[k : 2 * k]))
    np.testing.assert_allclose(lengths[1], factor * lengths[0], rtol=1e-9)


def test_nested_islands_are_separate_rooms() -> None:
    obstacles = []
    for k in range(12):
        a, b = 1.0 + 3 * k, 2.0 + 3 * k
        obstacles += [
            Rectangle(-b, -b, 2 * b, b - a),
            Rectangle(-b, a, 2 * b, b - a),
            Rectangle(-b, -a, b - a, 2 * a),
            Rectangle(a, -a, b - a, 2 * a),
        ]
    space = FreeSpace(Scene((-40, -40, 40, 40), obstacles))
    assert space.parts == 13
    starts = [(0.0, 0.0), *((0.0, 2.5 + 3 * k) for k in range(12))]
    index = prepare(space)
    goals = [(0.3, 0.4), *((0.0, -2.5 - 3 * k) for k in range(12))]
    found = distances(index, starts, goals)
    assert found[0] == pytest.approx(0.5)
    for k in range(12):
        side = 2.0 + 3 * k
        assert found[k + 1] == pytest.approx(2 * math.hypot(side, 0.5) + 2 * side)
    assert np.isinf(distances(index, starts[:-1], starts[1:])).all()
