"""Graphs go to networkx and GraphML and come back bit for bit; what cannot come is refused in words."""

from __future__ import annotations

import math
import sys
from itertools import combinations
from pathlib import Path

import networkx as nx
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from taut.errors import OutputError, TautError
from taut.graph import Graph
from taut.graph.conversion import from_networkx, load_graphml, save_graphml, to_networkx
from taut.graph.core import Floats

FINITE = st.floats(allow_nan=False, allow_infinity=False)


@st.composite
def graphs(draw: st.DrawFn) -> tuple[Graph, Floats]:
    """Draw a graph with any weights there are, and positions."""
    n = draw(st.integers(1, 8))
    pairs = list(combinations(range(n), 2))
    chosen = draw(st.lists(st.sampled_from(pairs), unique=True)) if pairs else []
    weight = st.floats(0, sys.float_info.max)
    weights = draw(st.lists(weight, min_size=len(chosen), max_size=len(chosen)))
    places = draw(st.lists(st.tuples(FINITE, FINITE), min_size=n, max_size=n))
    return Graph.from_edges(n, chosen, weights), np.array(places)


def assert_same(a: Graph, b: Graph) -> None:
    assert a.n == b.n
    assert a.edges.tolist() == b.edges.tolist()
    assert a.lengths.tobytes() == b.lengths.tobytes()


@settings(deadline=None, max_examples=60)
@given(graphs())
def test_networkx_round_trip(drawn: tuple[Graph, Floats]) -> None:
    graph, positions = drawn
    other = to_networkx(graph, positions)
    back, nodes = from_networkx(other)
    assert_same(graph, back)
    assert nodes == list(range(graph.n))
    assert np.array([other.nodes[v]["pos"] for v in nodes]).tobytes() == positions.tobytes()
    assert all(type(w) is float for *_, w in other.edges(data="weight"))


@settings(deadline=None, max_examples=60)
@given(graphs())
def test_graphml_round_trip(tmp_path_factory: pytest.TempPathFactory, drawn: tuple[Graph, Floats]) -> None:
    graph, positions = drawn
    path = tmp_path_factory.mktemp("graphs") / "graph.graphml"
    save_graphml(graph, path, positions)
    back, places = load_graphml(path)
    assert_same(graph, back)
    assert places is not None
    assert places.tobytes() == positions.tobytes()
    save_graphml(graph, path)
    back, places = load_graphml(path)
    assert_same(graph, back)
    assert places is None


def test_networkx_reads_the_files(tmp_path: Path) -> None:
    graph = Graph.from_edges(3, [(0, 1), (1, 2)], [0.1, 2.0])
    save_graphml(graph, tmp_path / "graph.graphml", [(0, 0), (1.5, -2), (3, 4)])
    other = nx.read_graphml(tmp_path / "graph.graphml")
    assert dict(other.nodes(data=True))["1"] == {"x": 1.5, "y": -2.0}
    assert {(a, b): w for a, b, w in other.edges(data="weight")} == {("0", "1"): 0.1, ("1", "2"): 2.0}
    assert len(list(tmp_path.iterdir())) == 1


def test_files_of_other_programs_are_read(tmp_path: Path) -> None:
    other = nx.Graph([("b", "a", {"weight": 3, "colour": "red"}), ("a", "c", {})])
    nx.write_graphml(other, tmp_path / "graph.graphml")
    graph, positions = load_graphml(tmp_path / "graph.graphml")
    assert positions is None
    assert graph.edges.tolist() == [[0, 1], [1, 2]]  # b, a, c
    assert graph.lengths.tolist() == [3.0, 1.0]


def test_nodes_of_any_kind_keep_their_order_and_results_agree_with_networkx() -> None:
    other = nx.Graph()
    other.add_weighted_edges_from([("x", (1, 2), 2), ((1, 2), 7, np.float64(0.5)), ("x", 7, 1.0)])
    graph, nodes = from_networkx(other)
    assert nodes == ["x", (1, 2), 7]
    np.testing.assert_array_equal(nx.to_numpy_array(other, nodes)[tuple(graph.edges.T)], graph.lengths)


def test_the_attribute_of_the_weight_may_be_chosen() -> None:
    other = nx.Graph([(0, 1, {"weight": 3.0, "length": 0.5}), (1, 2, {"weight": 4.0})])
    assert from_networkx(other)[0].lengths.tolist() == [3.0, 4.0]
    assert from_networkx(other, "length")[0].lengths.tolist() == [0.5, 1.0]
    assert from_networkx(other, None)[0].lengths.tolist() == [1.0, 1.0]


def test_empty_graphs(tmp_path: Path) -> None:
    empty = Graph.from_edges(0, [])
    assert from_networkx(nx.Graph())[0].n == 0
    assert to_networkx(empty).number_of_nodes() == 0
    save_graphml(empty, tmp_path / "empty.graphml")
    assert load_graphml(tmp_path / "empty.graphml")[0].n == 0


@pytest.mark.parametrize(
    ("other", "words"),
    [
        (nx.DiGraph([(0, 1)]), "directed.*to_undirected"),
        (nx.MultiGraph([(0, 1), (0, 1)]), "parallel edges.*join them"),
        (nx.Graph([(0, 1), (1, 1)]), "joins 1 with itself; remove"),
        (nx.Graph([("a", "b", {"weight": -1})]), "edge 'a', 'b' is -1; weights must not be negative"),
        (nx.Graph([(0, 1, {"weight": math.nan})]), "must be finite"),
        (nx.Graph([(0, 1, {"weight": math.inf})]), "must be finite"),
        (nx.Graph([(0, 1, {"weight": 10**400})]), "must be finite"),
        (nx.Graph([(0, 1, {"weight": "heavy"})]), "edge 0, 1 is 'heavy'; it must be a number"),
        (nx.Graph([(0, 1, {"weight": None})]), "must be a number"),
    ],
)
def test_what_a_graph_cannot_hold_is_refused(other: nx.Graph, words: str) -> None:
    with pytest.raises(ValueError, match=words):
        from_networkx(other)


def test_positions_are_checked(tmp_path: Path) -> None:
    graph = Graph.from_edges(2, [(0, 1)])
    for positions, words in (([(0, 0)], r"\(2, 2\)"), ([0, 1], r"\(2, 2\)"), ([(0, 0), (1, np.nan)], "vertex 1 ")):
        with pytest.raises(ValueError, match=words):
            to_networkx(graph, positions)
        with pytest.raises(ValueError, match=words):
            save_graphml(graph, tmp_path / "graph.graphml", positions)
    assert list(tmp_path.iterdir()) == []


HEAD = '<?xml version="1.0"?>\n<graphml xmlns="http://graphml.graphdrawing.org/xmlns">\n'
KEYS = (
    '<key id="w" for="edge" attr.name="weight" attr.type="double"/>'
    '<key id="x" for="node" attr.name="x" attr.type="double"/>'
    '<key id="y" for="node" attr.name="y" attr.type="double"/>\n'
)


def graphml(body: str, edgedefault: str = "undirected") -> str:
    return f'{HEAD}{KEYS}<graph edgedefault="{edgedefault}">{body}</graph></graphml>'


EDGE = '<node id="a"/><node id="b"/><edge source="a" target="b">{}</edge>'


@pytest.mark.parametrize(
    ("text", "words"),
    [
        ("", "1: is not XML"),
        (HEAD + "<graph>", "3: is not XML"),
        ("not xml", "1: is not XML"),
        (graphml(EDGE.format(""), "directed"), "is directed"),
        (graphml(EDGE.format("") + '<edge source="b" target="a"/>'), "parallel"),
        (graphml('<node id="a"/><edge source="a" target="a"/>'), "itself"),
        (graphml(EDGE.format('<data key="w">-2</data>')), "negative"),
        (graphml(EDGE.format('<data key="w">two</data>')), "two"),
        (graphml(EDGE.format('<data key="w">nan</data>')), "finite"),
        (graphml(EDGE.format('<data key="none">1</data>')), "no key none"),
        (graphml('<node id="a"><data key="x">1</data></node>'), "'a' lacks x or y"),
        (graphml('<node id="a"><data key="x">1</data><data key="y">1</data></node><node id="b"/>'), "'b' lacks x or y"),
        (graphml('<node id="a"/><node id="b"><data key="x">1</data><data key="y">1</data></node>'), "x and y"),
        (graphml("<hyperedge/>"), "hyperedges"),
        (HEAD + "</graphml>", "not a GraphML file|not successfully read"),
        ("<html></html>", "not a GraphML file|not successfully read"),
    ],
)
def test_a_bad_file_is_one_line_with_its_name(tmp_path: Path, text: str, words: str) -> None:
    path = tmp_path / "bad.graphml"
    path.write_text(text)
    with pytest.raises(TautError, match=words) as caught:
        load_graphml(path)
    assert str(caught.value).startswith(str(path))
    assert "\n" not in str(caught.value)


def test_files_that_are_not_there(tmp_path: Path) -> None:
    for path in (tmp_path, tmp_path / "none.graphml"):
        with pytest.raises(TautError, match="cannot be read"):
            load_graphml(path)
    with pytest.raises(OutputError, match="cannot be written"):
        save_graphml(Graph.from_edges(1, []), tmp_path / "none" / "graph.graphml")


def test_without_networkx_the_error_names_the_extra(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    graph = Graph.from_edges(2, [(0, 1)])
    path = tmp_path / "graph.graphml"
    save_graphml(graph, path)
    monkeypatch.setitem(sys.modules, "networkx", None)
    with pytest.raises(TautError, match=r"pip install 'taut\[networkx\]'"):
        to_networkx(graph)
    with pytest.raises(TautError, match=r"pip install 'taut\[networkx\]'"):
        save_graphml(graph, path)
    with pytest.raises(TautError, match=r"pip install 'taut\[networkx\]'"):
        load_graphml(path)


def test_importing_the_module_does_not_import_networkx() -> None:
    import subprocess

    code = "import sys, taut.graph.conversion; sys.exit('networkx' in sys.modules)"
    assert subprocess.run([sys.executable, "-c", code], check=False).returncode == 0
