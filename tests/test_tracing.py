"""Searches with a trace end where the kernels end, step by step as theory says, and can be told and shown."""

from __future__ import annotations

import itertools
import math
from pathlib import Path
from typing import Any, get_args

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from matplotlib.axes import Axes
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.collections import LineCollection
from matplotlib.colors import to_rgba_array
from matplotlib.figure import Figure
from PIL import Image

from taut.errors import OutputError
from taut.figures import searches
from taut.figures.searches import ACTIVE, VISITED, animate_search, draw_step, save_steps
from taut.figures.style import GOAL
from taut.graph import Graph, astar, dijkstra, path_to
from taut.graph.core import Floats
from taut.graph.search import breadth_first, depth_first
from taut.graph.tracing import Method, Trace, tell, trace
from test_graph import drawn_graphs, figure_8_19, graphs

METHODS: tuple[Method, ...] = get_args(Method)
PLACES = np.array([(0, 0), (3, -2.6), (3.6, 1), (8, -2.4), (8.6, 2.2), (3, 3.8)])  # figure 8.19, about as printed


@st.composite
def lattice_graphs(draw: st.DrawFn) -> tuple[Graph, Floats]:
    """Draw a graph on different lattice points with whole weights no less than the distances: sums are exact."""
    points = draw(st.lists(st.tuples(st.integers(0, 5), st.integers(0, 5)), min_size=2, max_size=12, unique=True))
    positions = np.array(points, dtype=np.float64)
    pairs = list(itertools.combinations(range(len(points)), 2))
    chosen = draw(st.lists(st.sampled_from(pairs), unique=True, max_size=30))
    more = draw(st.lists(st.integers(0, 2), min_size=len(chosen), max_size=len(chosen)))
    weights = [math.ceil(math.dist(points[a], points[b])) + w for (a, b), w in zip(chosen, more, strict=True)]
    return Graph.from_edges(len(points), chosen, weights), positions


@st.composite
def traces(draw: st.DrawFn) -> Trace:
    """Draw a search of any kind, with and without a target."""
    method = draw(st.sampled_from(METHODS))
    graph, positions = draw(drawn_graphs()) if method == "astar" else (draw(graphs()), None)
    vertex = st.integers(0, graph.n - 1)
    target = draw(vertex if method == "astar" else vertex | st.none())
    return trace(graph, draw(vertex), target, method, positions)


def visits(steps: Trace) -> list[int]:
    return [step.vertex for step in steps.steps]


def test_figure_8_19() -> None:
    steps = trace(figure_8_19(), 0, 4)
    # 4 and 5 are both 20 away: the smaller goes first
    assert [v + 1 for v in visits(steps)] == [1, 2, 3, 6, 4, 5]
    assert [step.distance for step in steps.steps] == [0, 7, 9, 11, 20, 20]
    assert [v + 1 for v in steps.path] == [1, 3, 6, 5]
    assert steps.distance == 20
    inf = math.inf
    assert [step.relaxed for step in steps.steps] == [
        ((1, inf, 7.0), (2, inf, 9.0), (5, inf, 14.0)),
        ((3, inf, 22.0),),
        ((3, 22.0, 20.0), (5, 14.0, 11.0)),
        ((4, inf, 20.0),),
        (),
        (),
    ]
    assert [step.edge for step in steps.steps] == [None, (0, 1), (0, 2), (2, 5), (2, 3), (5, 4)]


def test_figure_8_19_in_words() -> None:
    assert tell(trace(figure_8_19(), 0, 4)) == [
        "Step 1: start at v1, distance 0. v2 falls from ∞ to 0 + 7 = 7; v3 falls from ∞ to 0 + 9 = 9; "
        "v6 falls from ∞ to 0 + 14 = 14.",
        "Step 2: pick v2, least distance 7 (v3 has 9, v6 has 14). v3 keeps 9, as 7 + 10 = 17 is not less; "
        "v4 falls from ∞ to 7 + 15 = 22.",
        "Step 3: pick v3, least distance 9 (v6 has 14, v4 has 22). v4 falls from 22 to 9 + 11 = 20; "
        "v6 falls from 14 to 9 + 2 = 11.",
        "Step 4: pick v6, least distance 11 (v4 has 20). v5 falls from ∞ to 11 + 9 = 20.",
        "Step 5: pick v4, least distance 20 (a tie with v5: the earlier vertex goes first). "
        "v5 keeps 20, as 20 + 6 = 26 is not less.",
        "Step 6: pick v5, the only one in the frontier, distance 20. It is the target: done.",
        "Shortest path: v1 → v3 → v6 → v5, length 9 + 2 + 9 = 20.",
    ]


@settings(deadline=None, max_examples=200)
@given(graphs(), st.data())
def test_dijkstra_equals_the_kernel_to_the_last_bit(graph: Graph, data: st.DataObject) -> None:
    source, target = data.draw(st.integers(0, graph.n - 1)), data.draw(st.integers(0, graph.n - 1))
    distance, before = dijkstra(graph, source)
    whole = trace(graph, source)
    end = whole.state(len(whole.steps))
    assert (end.distances.tolist(), end.before.tolist()) == (distance.tolist(), before.tolist())
    keys = [(step.distance, step.vertex) for step in whole.steps]
    assert [d for d, _ in keys] == sorted(d for d, _ in keys)
    # over an edge that adds nothing a smaller vertex may be seen when a larger one as far away is visited already
    if (graph.weights > 1e-6).all():
        assert keys == sorted((d, v) for v, d in enumerate(distance.tolist()) if math.isfinite(d))
    short = trace(graph, source, target)
    if math.isinf(distance[target]):
        assert (short.path, short.distance, visits(short)) == ([], math.inf, visits(whole))
    else:
        assert (short.path, short.distance) == (path_to(before, target), distance[target])
        assert visits(short) == visits(whole)[: visits(whole).index(target) + 1]


@settings(deadline=None, max_examples=200)
@given(drawn_graphs(), st.data())
def test_astar_equals_the_kernel_to_the_last_bit(drawn: tuple[Graph, Floats], data: st.DataObject) -> None:
    graph, positions = drawn
    source, target = data.draw(st.integers(0, graph.n - 1)), data.draw(st.integers(0, graph.n - 1))
    length, path = astar(graph, positions, source, target)
    steps = trace(graph, source, target, "astar", positions)
    assert (steps.distance, steps.path) == (length, path.tolist())


@settings(deadline=None, max_examples=200)
@given(graphs(), st.data())
def test_breadth_and_depth_first_equal_the_kernels(graph: Graph, data: st.DataObject) -> None:
    source = data.draw(st.integers(0, graph.n - 1))
    hops, before = breadth_first(graph, source)
    wide = trace(graph, source, method="breadth-first")
    end = wide.state(len(wide.steps))
    assert end.before.tolist() == before.tolist()
    assert end.distances.tolist() == np.where(hops < 0, math.inf, hops).tolist()
    order, before = depth_first(graph, source)
    deep = trace(graph, source, method="depth-first")
    assert visits(deep) == order.tolist()
    assert deep.state(len(deep.steps)).before.tolist() == before.tolist()


@settings(deadline=None, max_examples=200)
@given(lattice_graphs(), st.data())
def test_astar_visits_nothing_that_dijkstra_does_not(drawn: tuple[Graph, Floats], data: st.DataObject) -> None:
    graph, positions = drawn
    source, target = data.draw(st.integers(0, graph.n - 1)), data.draw(st.integers(0, graph.n - 1))
    led, blind = trace(graph, source, target, "astar", positions), trace(graph, source, target)
    assert set(visits(led)) <= set(visits(blind))
    assert led.distance == blind.distance


def test_astar_visits_only_the_way_where_dijkstra_visits_all() -> None:
    positions = np.array([(x, 0.0) for x in range(-5, 6)])
    graph = Graph.from_edges(11, [(i, i + 1) for i in range(10)])
    assert len(trace(graph, 5, 10, "astar", positions).steps) == 6
    assert len(trace(graph, 5, 10).steps) == 11


@settings(deadline=None, max_examples=200)
@given(traces())
def test_states_follow_from_the_steps(steps: Trace) -> None:
    graph, last = steps.graph, len(steps.steps)
    weight = {tuple(e): w for e, w in zip(graph.edges.tolist(), graph.lengths.tolist(), strict=True)}
    for k in range(last + 1):
        state = steps.state(k)
        assert list(state.visited) == visits(steps)[:k]
        waiting = [v for v, _ in state.frontier]
        assert not set(waiting) & set(state.visited)
        assert {*waiting, *state.visited} == set(np.flatnonzero(np.isfinite(state.distances)).tolist())
        assert all(state.distances[v] == d for v, d in state.frontier)
        for v in {*waiting, *state.visited} - {steps.source}:
            u = int(state.before[v])
            assert u in state.visited
            leg = weight[min(u, v), max(u, v)] if steps.method in ("dijkstra", "astar") else 1.0
            assert state.distances[v] == state.distances[u] + leg
        if k < last:
            step = steps.steps[k]
            if steps.method in ("dijkstra", "astar"):
                keys = [(d + float(steps.estimates[v]), v) for v, d in state.frontier]
                assert min(keys)[1] == step.vertex
            assert (step.vertex, step.distance) == state.frontier[0]
            u = int(state.before[step.vertex])
            assert step.edge == (None if step.vertex == steps.source else (u, step.vertex))
            after = steps.state(k + 1)
            changed = {
                v
                for v in range(graph.n)
                if (state.distances[v], state.before[v]) != (after.distances[v], after.before[v])
            }
            assert changed == {v for v, _, _ in step.relaxed}
            for v, old, new in step.relaxed:
                assert (state.distances[v], after.distances[v], after.before[v]) == (old, new, step.vertex)
                assert new < old or steps.method == "depth-first"
        else:
            assert not waiting or steps.target in state.visited


@settings(deadline=None, max_examples=100)
@given(traces())
def test_every_search_can_be_told(steps: Trace) -> None:
    lines = tell(steps)
    assert len(lines) == len(steps.steps) + 1
    for number, (line, step) in enumerate(zip(lines, steps.steps, strict=False), start=1):
        assert line.startswith(f"Step {number}: ")
        assert f"v{step.vertex + 1}" in line
    if steps.path:
        assert " → ".join(f"v{v + 1}" for v in steps.path) in lines[-1]
    elif steps.target is not None:
        assert lines[-1] == f"There is no path from v{steps.source + 1} to v{steps.target + 1}."


@pytest.mark.parametrize("method", METHODS)
def test_source_is_target(method: Method) -> None:
    steps = trace(figure_8_19(), 2, 2, method, PLACES / 4)
    assert (visits(steps), steps.path, steps.distance) == ([2], [2], 0.0)
    assert tell(steps)[0] == "Step 1: start at v3, distance 0. It is the target: done."


@pytest.mark.parametrize("method", METHODS)
def test_unreachable_and_isolated(method: Method) -> None:
    graph = Graph.from_edges(4, [(0, 2)])
    positions = np.zeros((4, 2))
    lonely = trace(graph, 1, 0, method, positions)
    assert (visits(lonely), lonely.path, lonely.distance) == ([1], [], math.inf)
    assert lonely.state(1).frontier == ()
    assert tell(lonely) == [
        "Step 1: start at v2, distance 0. It has no neighbours.",
        "There is no path from v2 to v1.",
    ]
    cut = trace(graph, 0, 3, method, positions)
    assert (visits(cut), cut.path, cut.distance) == ([0, 2], [], math.inf)


def test_without_a_target_there_is_no_path_but_a_tree() -> None:
    steps = trace(Graph.from_edges(3, [(0, 1)]), 0)
    assert (steps.path, steps.distance) == ([], math.inf)
    assert tell(steps)[-1] == "All vertices that can be reached from v1 are visited: 2 of 3; 1 cannot be reached."


def test_depth_first_goes_back_and_breadth_first_waits() -> None:
    tree = Graph.from_edges(5, [(0, 1), (0, 3), (1, 2), (3, 4)])
    names = ["root", "left", "leaf", "right", "twig"]
    deep = trace(tree, 0, 4, "depth-first")
    assert visits(deep) == [0, 1, 2, 3, 4]
    assert tell(deep, names)[3] == (
        "Step 4: go back to root and pick right, its next unvisited neighbour, 1 edge deep. "
        "Seen for the first time: twig."
    )
    wide = trace(tree, 0, 4, "breadth-first")
    assert visits(wide) == [0, 1, 3, 2, 4]
    assert tell(wide, names)[-1] == "Path with the fewest edges: root → right → twig, 2 edges."


def test_words_tell_numbers_apart_that_differ_in_the_last_digit() -> None:
    ways = [0.1, 0.2, 0.3]
    assert ways[0] + ways[1] > ways[2]
    lines = tell(trace(Graph.from_edges(3, [(0, 1), (1, 2), (0, 2)], ways), 0, 2))
    assert "v3 keeps 0.3, as 0.1 + 0.2 = 0.30000000000000004 is not less" in lines[1]


def test_sums_beyond_the_largest_number_are_no_path() -> None:
    graph = Graph.from_edges(3, [(0, 1), (1, 2)], [1.5e308, 1.5e308])
    steps = trace(graph, 0, 2)
    assert steps.state(len(steps.steps)).distances.tolist() == dijkstra(graph, 0)[0].tolist()
    assert (steps.path, steps.distance) == ([], math.inf)
    assert "v3 keeps ∞" in tell(steps)[1]


def test_tiny_weights_are_counted() -> None:
    assert trace(Graph.from_edges(3, [(0, 1), (1, 2)], [5e-324, 5e-324]), 0, 2).distance == 1e-323


@pytest.mark.parametrize(
    ("arguments", "error", "said"),
    [
        ({"source": 6}, IndexError, "vertex 6 "),
        ({"target": -1}, IndexError, "vertex -1 "),
        ({"method": "greedy"}, ValueError, "'greedy' is not one of dijkstra, astar"),
        ({"method": "astar"}, ValueError, "needs a target"),
        ({"method": "astar", "target": 4}, ValueError, "needs a target and the positions"),
        ({"method": "astar", "target": 4, "positions": PLACES[:5]}, ValueError, r"\(5, 2\) for 6 vertices"),
        ({"method": "astar", "target": 4, "positions": PLACES * math.nan}, ValueError, "finite"),
        ({"method": "astar", "target": 4, "positions": PLACES * 1e200}, ValueError, "finite"),
        (
            {"method": "astar", "target": 4, "positions": PLACES * 10},
            ValueError,
            "vertices 0 and 1 weighs 7, less than",
        ),
    ],
)
def test_wrong_searches_are_refused(arguments: dict[str, object], error: type[Exception], said: str) -> None:
    with pytest.raises(error, match=said):
        trace(figure_8_19(), **{"source": 0, **arguments})  # type: ignore[arg-type]


def test_wrong_questions_are_refused() -> None:
    steps = trace(figure_8_19(), 0, 4)
    for k in (-1, 7):
        with pytest.raises(IndexError, match="not one of 0 … 6"):
            steps.state(k)
    with pytest.raises(ValueError, match="2 names for 6 vertices"):
        tell(steps, ["a", "b"])
    with pytest.raises(IndexError, match="without vertices"):
        trace(Graph.from_edges(0, []), 0)


# pictures


def paper() -> Axes:
    figure = Figure(figsize=(8, 6))
    FigureCanvasAgg(figure)
    return figure.add_subplot()


def texts(axes: Axes) -> set[str]:
    return {text.get_text() for text in axes.texts}


def edges_in(axes: Axes, colour: str) -> set[frozenset[tuple[float, ...]]]:
    """Return the ends of all lines of that colour."""
    return {
        frozenset(tuple(place) for place in segment.tolist())
        for lines in axes.collections
        if isinstance(lines, LineCollection) and np.array_equal(to_rgba_array(lines.get_color()), to_rgba_array(colour))
        for segment in lines.get_segments()
    }


def ends(*pairs: tuple[int, int]) -> set[frozenset[tuple[float, ...]]]:
    return {frozenset((tuple(PLACES[a - 1].tolist()), tuple(PLACES[b - 1].tolist()))) for a, b in pairs}


def test_a_step_shows_what_changes() -> None:
    axes = paper()
    draw_step(axes, figure_8_19(), PLACES, trace(figure_8_19(), 0, 4), 3)
    assert {"22 → 20", "14 → 11", "0", "7", "9", "∞", "v1", "v6"} <= texts(axes)
    assert edges_in(axes, ACTIVE) == ends((3, 4), (3, 6))
    assert edges_in(axes, VISITED) == ends((1, 2), (1, 3))
    assert edges_in(axes, GOAL) == set()
    assert "step 3 of 6" in axes.get_title(loc="left")


def test_the_last_step_shows_the_path_and_every_weight() -> None:
    axes = paper()
    draw_step(axes, figure_8_19(), PLACES, trace(figure_8_19(), 0, 4), 6)
    assert edges_in(axes, GOAL) == ends((1, 3), (3, 6), (6, 5))
    canvas: Any = axes.figure.canvas
    canvas.draw()
    pixels = np.asarray(canvas.buffer_rgba())
    for a, b in ((0, 2), (5, 4)):
        across, up = axes.transData.transform(PLACES[a] + 0.7 * (PLACES[b] - PLACES[a]))
        assert (pixels[len(pixels) - 1 - int(up), int(across)] == np.round(255 * to_rgba_array(GOAL)[0])).all()
    assert {"7", "9", "14", "10", "15", "11", "2", "6"} <= texts(axes)
    assert axes.get_title(loc="right") == "v1 → v3 → v6 → v5 · length 20"


def test_a_large_graph_is_drawn_without_words() -> None:
    places = np.random.default_rng(3).random((200, 2))
    order = np.argsort(places[:, 0])
    graph = Graph.from_edges(200, np.stack([order[:-1], order[1:]], axis=1))
    axes = paper()
    draw_step(axes, graph, places, trace(graph, int(order[0]), method="breadth-first"), 90)
    assert texts(axes) == set()
    assert len(edges_in(axes, VISITED)) == 89


def test_a_map_keeps_its_view() -> None:
    axes = paper()
    axes.set(xlim=(-20, 40), ylim=(-30, 30))
    draw_step(axes, figure_8_19(), PLACES, trace(figure_8_19(), 0), 2)
    assert (axes.get_xlim(), axes.get_ylim()) == ((-20, 40), (-30, 30))


@pytest.mark.parametrize(
    ("n", "places"),
    [(1, [(0, 0)]), (3, [(0, 0), (0, 0), (0, 0)]), (3, [(0, 0), (1e6, 0), (2e6, 0)]), (2, [(0, 0), (0, 1e-9)])],
)
def test_odd_places_make_pictures_too(n: int, places: list[tuple[float, float]], tmp_path: Path) -> None:
    graph = Graph.from_edges(n, [(0, 1)] if n > 1 else [])
    paths = save_steps(graph, places, trace(graph, 0, n - 1), tmp_path / "new" / "folder")
    assert len(paths) == len(trace(graph, 0, n - 1).steps)
    for path in paths:
        with Image.open(path) as picture:
            assert len(set(picture.convert("L").resize((60, 40)).tobytes())) > 5  # not one plain colour


def test_pictures_are_numbered_so_that_they_sort(tmp_path: Path) -> None:
    graph = Graph.from_edges(10, [(i, i + 1) for i in range(9)])
    paths = save_steps(graph, [(i, i % 2) for i in range(10)], trace(graph, 0), tmp_path)
    assert [path.name for path in paths] == [f"step-{k:02d}.png" for k in range(1, 11)]
    assert sorted(tmp_path.iterdir()) == paths
    assert len({path.read_bytes() for path in paths}) == 10


def test_the_same_search_gives_the_same_bytes(tmp_path: Path) -> None:
    graph = Graph.from_edges(2, [(0, 1)])
    twice = [save_steps(graph, [(0, 0), (1, 1)], trace(graph, 0, 1), tmp_path / name) for name in ("a", "b")]
    assert [path.read_bytes() for path in twice[0]] == [path.read_bytes() for path in twice[1]]


def test_an_animation_has_a_frame_for_each_step_and_the_beginning(tmp_path: Path) -> None:
    path = tmp_path / "search.gif"
    animate_search(figure_8_19(), PLACES, trace(figure_8_19(), 0, 4), path, width=400)
    with Image.open(path) as film:
        assert film.n_frames == 7  # type: ignore[attr-defined]
        frames = []
        for k in range(7):
            film.seek(k)
            frames.append(film.convert("RGB").tobytes())
    assert len(set(frames)) == 7


@pytest.mark.parametrize("k", range(7))
def test_frames_show_what_the_still_pictures_show(k: int) -> None:
    graph, steps = figure_8_19(), trace(figure_8_19(), 0, 4)
    still, film = searches._sheet(PLACES, 7.0), searches._sheet(PLACES, 7.0)
    render = searches._stage(film, searches._look(film, graph, PLACES, steps))
    render(6 - k)  # what was shown before leaves no mark
    frame = render(k)
    draw_step(still, graph, PLACES, steps, k)
    canvas: Any = still.figure.canvas
    canvas.draw()
    assert (frame == np.asarray(canvas.buffer_rgba())[: frame.shape[0], : frame.shape[1]]).all()


def test_wrong_pictures_are_refused(tmp_path: Path) -> None:
    graph, steps = figure_8_19(), trace(figure_8_19(), 0)
    with pytest.raises(IndexError, match="step 7 "):
        draw_step(paper(), graph, PLACES, steps, 7)
    with pytest.raises(ValueError, match="6 pairs of finite numbers"):
        draw_step(paper(), graph, PLACES[:4], steps, 1)
    with pytest.raises(ValueError, match="another graph"):
        draw_step(paper(), Graph.from_edges(6, [(0, 1)]), PLACES, steps, 1)
    with pytest.raises(OutputError, match=r"\.gif or \.mp4"):
        animate_search(graph, PLACES, steps, tmp_path / "film.avi")
    with pytest.raises(OutputError, match="fps"):
        animate_search(graph, PLACES, steps, tmp_path / "film.gif", fps=0)
    (tmp_path / "file").write_text("")
    with pytest.raises(OutputError, match="cannot be written"):
        save_steps(graph, PLACES, steps, tmp_path / "file")
