"""Every way to a shortest length against exact arithmetic: 2,000 small scenes full of touching and collinear corners.

Coordinates are whole numbers, then moved and scaled to millionths and to tens of millions; the reference takes every
double as the rational number it is.
"""

from __future__ import annotations

import numpy as np
import pytest
import shapely

from naive import naive_shortest
from taut.errors import NoPath
from taut.freespace import FreeSpace
from taut.graph import dijkstra
from taut.roadmap import visibility_graph
from taut.route import distances, prepare, shortest_path
from taut.scene import Polygon, Scene
from zoo import transformed

SCENES = 2000
CHUNKS = 40
SCALES = [(1.0, 0.0), (2.0**-20, 0.0), (1e-6, 0.0), (1e7 / 8, 0.0), (1.0, 1e7), (0.1, 0.3)]


def small_scene(rng: np.random.Generator) -> Scene:
    """Up to five polygons with whole-number corners from 0 to 8; they may touch, overlap and nest."""
    obstacles: list[Polygon] = []
    while len(obstacles) < rng.integers(1, 6):
        kind, at = rng.integers(3), rng.integers(0, 7, 2)
        if kind == 0:
            corners = list(at + rng.integers(1, 4, 2) * np.array([(0, 0), (1, 0), (1, 1), (0, 1)]))
        else:
            corners = list(rng.integers(0, 9, (3 + kind - 1, 2)))
        shape = shapely.Polygon(corners)
        if shape.is_valid and shape.area > 0:
            obstacles.append(Polygon([(float(x), float(y)) for x, y in corners]))
    return Scene((0, 0, 8, 8), obstacles)


@pytest.mark.parametrize("chunk", range(CHUNKS))
def test_all_searches_give_the_exact_length(chunk: int) -> None:
    found = 0
    for seed in range(chunk, SCENES, CHUNKS):
        rng = np.random.default_rng(seed)
        factor, shift = SCALES[seed % len(SCALES)]
        freespace = FreeSpace(transformed(small_scene(rng), factor, shift))
        places = factor * rng.integers(0, 17, (40, 2)) / 2 + shift
        free = places[freespace.contains(places)]
        if len(free) < 2:
            continue
        a, b = free[0], free[1]
        expected = naive_shortest(freespace.region, a.tolist(), b.tolist())
        lengths = [distances(prepare(freespace, kind), [a], [b])[0] for kind in ("graph", "labels")]
        for edges in ("tangent", "all"):
            graph = visibility_graph(freespace, edges, [a, b]).graph
            lengths.append(dijkstra(graph, graph.n - 2)[0][graph.n - 1])
        try:
            lengths.append(shortest_path(freespace, a, b).length)
        except NoPath:
            lengths.append(np.inf)
        if expected is None:
            assert np.isinf(lengths).all()
        else:
            np.testing.assert_allclose(lengths, expected, rtol=1e-12, atol=0)
            found += 1
    assert found >= SCENES / CHUNKS / 2
