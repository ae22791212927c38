"""Figures of graphs: colours, numbers and stems say what the graph is; nothing covers anything else."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from matplotlib.axes import Axes
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.collections import LineCollection, PathCollection
from matplotlib.colors import to_hex
from matplotlib.figure import Figure

from taut.errors import OutputError
from taut.figures._graph_kernels import crossings
from taut.figures.graphs import Portrait, draw_portraits, draw_values, save_portraits
from taut.figures.spectra import HIGH, LOW, draw_matrix, draw_sorted, draw_spectrum
from taut.figures.style import GOAL, START
from taut.formats import load_scene
from taut.freespace import FreeSpace
from taut.graph import Graph
from taut.graph.matrices import laplacian
from taut.graph.spectral import fiedler_vector, spectrum
from taut.roadmap import visibility_graph


def blank() -> Axes:
    figure = Figure(figsize=(6, 6))
    FigureCanvasAgg(figure)
    axes: Axes = figure.add_axes((0.1, 0.1, 0.8, 0.8))
    return axes


def ring(n: int, weights: list[float] | None = None) -> tuple[Graph, Any]:
    """Return a cycle and its places on a circle."""
    angles = 2 * np.pi * np.arange(n) / n
    graph = Graph.from_edges(n, [(k, (k + 1) % n) for k in range(n)], weights)
    return graph, 5 * np.stack([np.cos(angles), np.sin(angles)], axis=1)


def texts(axes: Axes) -> list[str]:
    return [text.get_text() for text in axes.texts if text.get_text() != "metres"]


def dots(axes: Axes, count: int) -> PathCollection:
    """Return the marks of that many places, the topmost if there are several."""
    found = [c for c in axes.collections if isinstance(c, PathCollection) and len(np.asarray(c.get_offsets())) == count]
    return max(found, key=lambda c: c.get_zorder())


def test_vertices_are_indigo_below_zero_white_at_zero_orange_above() -> None:
    graph, places = ring(6)
    values = [-2.0, -1.0, 0.0, 1.0, 2.0, 0.0]
    axes = blank()
    draw_values(axes, graph, places, values)
    marks = dots(axes, 6)
    faces = np.asarray(marks.get_facecolor()).tolist()
    colours = {
        tuple(np.round(place, 9)): to_hex(face)
        for place, face in zip(np.asarray(marks.get_offsets()), faces, strict=True)
    }
    in_order = [colours[tuple(np.round(place, 9))] for place in places]
    assert (in_order[0], in_order[2], in_order[4], in_order[5]) == (LOW, "#ffffff", HIGH, "#ffffff")
    assert in_order[1] not in (LOW, "#ffffff")


@pytest.mark.parametrize(("n", "numbered"), [(1, True), (40, True), (41, False)])
def test_up_to_40_vertices_are_numbered(n: int, numbered: bool) -> None:
    places = np.stack(np.divmod(np.arange(n), 7), axis=1).astype(float)
    axes = blank()
    draw_values(axes, Graph.from_edges(n, []), places, np.zeros(n))
    assert sorted(texts(axes)) == sorted(f"v{k + 1}" for k in range(n) if numbered)


def test_crowded_vertices_are_not_numbered() -> None:
    places = np.stack([np.linspace(0, 0.1, 10), np.zeros(10)], axis=1)
    places[-1] = 50, 50
    axes = blank()
    draw_values(axes, Graph.from_edges(10, []), places, np.zeros(10))
    assert texts(axes) == []


def test_edges_carry_their_weights_where_they_differ() -> None:
    graph, places = ring(8, [1.25, 2, 3, 4, 5, 6, 7, 8])
    axes = blank()
    draw_values(axes, graph, places, np.zeros(8))
    assert sorted(t for t in texts(axes) if not t.startswith("v")) == ["1.25", *map(str, range(2, 9))]
    for weights, n in (([1.0] * 8, 8), ([float(k) for k in range(61)], 61)):
        graph, places = ring(n, weights)
        axes = blank()
        draw_values(axes, graph, places, np.zeros(n))
        assert [t for t in texts(axes) if not t.startswith("v")] == []


@settings(max_examples=15, deadline=None)
@given(st.integers(3, 11), st.integers(0, 10**6))
def test_weights_cover_neither_each_other_nor_vertices(n: int, seed: int) -> None:
    random = np.random.default_rng(seed)
    pairs = np.stack(np.triu_indices(n, 1), axis=1)
    axes = blank()
    draw_values(
        axes, Graph.from_edges(n, pairs, random.random(len(pairs)) + 0.1), random.random((n, 2)) * 10, np.zeros(n)
    )
    figure: Any = axes.figure
    labels = [t for t in axes.texts if t.get_text() not in {"metres", *(f"v{k + 1}" for k in range(n))}]
    boxes = [np.array(t.get_window_extent(figure.canvas.get_renderer()).get_points()).mean(axis=0) for t in labels]
    gaps = [np.hypot(*(a - b)) for k, a in enumerate(boxes) for b in boxes[:k]]
    assert min(gaps, default=99.0) / figure.dpi * 72 >= 12.5


def test_starts_and_goals_have_rims() -> None:
    graph, places = ring(5)
    axes = blank()
    draw_values(axes, graph, places, np.zeros(5), starts=[0, 1, 2], goals=[4])
    rims = {
        to_hex(np.asarray(c.get_facecolor()).tolist()[0]): np.asarray(c.get_offsets()) for c in axes.collections[1:]
    }
    np.testing.assert_array_equal(rims[START], places[:3])
    np.testing.assert_array_equal(rims[GOAL], places[4:])


def test_many_edges_become_a_density() -> None:
    random = np.random.default_rng(1)
    n = 200
    pairs = np.stack(np.triu_indices(n, 1), axis=1)
    axes = blank()
    draw_values(axes, Graph.from_edges(n, pairs), random.random((n, 2)), np.zeros(n))
    assert not [c for c in axes.collections if isinstance(c, LineCollection)]
    (picture,) = axes.images
    assert np.asarray(picture.get_array())[..., 3].max() > 0.5


@settings(max_examples=40, deadline=None)
@given(st.lists(st.tuples(*[st.floats(-30, 60)] * 4), max_size=6))
def test_the_density_counts_the_pixels_under_each_edge(segments: list[tuple[float, float, float, float]]) -> None:
    wide, high = 30, 20
    counts = crossings(np.array(segments, dtype=np.float64).reshape(-1, 4), wide, high)
    expected = np.zeros((high, wide), dtype=np.int64)
    for x0, y0, x1, y1 in segments:
        steps = max(1, int(max(abs(x1 - x0), abs(y1 - y0))))
        for share in (np.arange(steps) + 0.5) / steps:
            column, row = int(np.floor(x0 + share * (x1 - x0))), int(np.floor(y0 + share * (y1 - y0)))
            if 0 <= column < wide and 0 <= row < high:
                expected[row, column] += 1
    np.testing.assert_array_equal(counts, expected)


@pytest.mark.parametrize("n", [2, 9, 300])
def test_stems_are_the_eigenvalues_and_lambda2_is_written_out(n: int) -> None:
    graph, _ = ring(n) if n > 2 else (Graph.from_edges(2, [(0, 1)]), None)
    values = spectrum(graph)
    axes = blank()
    draw_spectrum(axes, values)
    stems = next(c for c in axes.collections if isinstance(c, LineCollection))
    np.testing.assert_array_equal([stem[1] for stem in stems.get_segments()], np.stack([np.arange(n) + 1, values], 1))
    assert texts(axes) == [f"λ2 = {values[1]:.4g}"]
    low, high = axes.get_ylim()
    assert low < 0 < values[-1] < high


@pytest.mark.parametrize("values", [[], [0.0]])
def test_without_a_second_eigenvalue_none_is_marked(values: list[float]) -> None:
    axes = blank()
    draw_spectrum(axes, values)
    assert texts(axes) == []


def test_small_matrices_show_their_numbers() -> None:
    graph, _ = ring(5, [1.5, 2, 3, 4, 5])
    matrix = laplacian(graph)
    for given_as in (matrix, matrix.toarray()):
        axes = blank()
        draw_matrix(axes, given_as)
        written = {tuple(int(c) for c in t.get_position()): t.get_text().replace("−", "-") for t in axes.texts}
        rows, columns = np.nonzero(matrix.toarray())
        assert written == {
            (j + 1, i + 1): f"{matrix[i, j]:.3g}" for i, j in zip(rows.tolist(), columns.tolist(), strict=True)
        }


@pytest.mark.parametrize(("n", "side"), [(17, 17), (400, 400), (401, 200)])
def test_larger_matrices_are_pictures_and_then_densities(n: int, side: int) -> None:
    graph, _ = ring(n)
    axes = blank()
    draw_matrix(axes, laplacian(graph))
    picture = np.asarray(axes.images[0].get_array())
    assert picture.shape == (side, side)
    assert texts(axes) == []
    assert (np.diag(picture) > 0).all()
    np.testing.assert_array_equal(picture, picture.T)
    assert picture[0, side // 2] == 0


def test_matrices_without_entries_are_drawn() -> None:
    for n in (0, 1, 3, 500):
        axes = blank()
        draw_matrix(axes, np.zeros((n, n)))
        axes.figure.canvas.draw()


def test_sorted_entries_ascend() -> None:
    axes = blank()
    draw_sorted(axes, [0.5, -0.5, 0.1])
    np.testing.assert_array_equal(axes.lines[-1].get_xydata(), [(1, -0.5), (2, 0.1), (3, 0.5)])


def portrait(name: str, known: bool = True) -> Portrait:
    scene = load_scene(name)
    free = FreeSpace(scene, scene.growth(scene.robots[0]))
    ends = [scene.robots[0].start, scene.robots[0].goal]
    found = visibility_graph(free, points=ends)
    unit = Graph.from_edges(found.graph.n, found.edges)
    values = spectrum(unit) if known else np.empty(0)
    fiedler = fiedler_vector(unit, towards=found.positions.T)
    n = unit.n
    return Portrait(unit, found.positions, fiedler, values, scene.name, "facts", (n - 2,), (n - 1,), free)


def test_a_figure_has_a_row_a_graph_and_nothing_overlaps() -> None:
    plain, places = ring(6)
    bare = Portrait(plain, places, fiedler_vector(plain), spectrum(plain), "ring")
    empty = Portrait(Graph.from_edges(0, []), np.empty((0, 2)), np.empty(0), np.empty(0), "nothing")
    figure = draw_portraits([portrait("thesis-1"), portrait("corridor-swap", known=False), bare, empty])
    figure.canvas.draw()
    boxes = [axes.get_position() for axes in figure.axes]
    assert len(boxes) == 4 * 3 + 3  # and a colour bar for each graph with a Fiedler vector
    for k, box in enumerate(boxes):
        assert 0 <= box.x0 < box.x1 <= 1
        assert 0 <= box.y0 < box.y1 <= 1
        assert not any(box.overlaps(other) for other in boxes[:k])
    heads = [axes.get_title(loc="left") for axes in figure.axes]
    assert heads.count("Eigenvalues of the Laplacian") == 2
    assert heads.count("Fiedler vector, sorted") == 1
    assert [text.get_text() for text in figure.texts] == [
        "thesis-1",
        "facts",
        "corridor-swap",
        "facts",
        "ring",
        "",
        "nothing",
        "",
    ]


@pytest.mark.parametrize("kind", ["png", "svg", "pdf"])
def test_the_same_graph_gives_the_same_bytes(tmp_path: Path, kind: str) -> None:
    for name in "ab":
        save_portraits([portrait("thesis-2")], tmp_path / f"{name}.{kind}")
    assert (tmp_path / f"a.{kind}").read_bytes() == (tmp_path / f"b.{kind}").read_bytes()


def test_bad_input_is_refused(tmp_path: Path) -> None:
    graph, places = ring(4)
    with pytest.raises(ValueError, match="positions"):
        draw_values(blank(), graph, places[:3], np.zeros(4))
    with pytest.raises(ValueError, match="values"):
        draw_values(blank(), graph, places, [0, 0, 0, np.nan])
    with pytest.raises(OutputError, match=r"\.png"):
        save_portraits([], tmp_path / "a.docx")
    with pytest.raises(OutputError, match="cannot be drawn"):
        draw_portraits([Portrait(graph, places * 1e90, np.zeros(4), np.zeros(4))])
    assert list(tmp_path.iterdir()) == []
