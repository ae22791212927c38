"""The command graph: all that it tells is true, and it tells no more than is sensible."""

from __future__ import annotations

import re
import sys
from importlib import import_module
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from commands import Command, Run, command_in, on_scenes, refused
from taut.formats import load_scene
from taut.graph.conversion import load_graphml

EMPTY = "taut: 1\nbounds: [0, 0, 4, 3]\nrobots: []\n"
ROOM = """\
taut: 1
name: room
bounds: [0, 0, 10, 8]
gap: 0.05
obstacles:
  - {name: box, polygon: [[4, 3], [6, 3], [6, 6], [4, 5]]}
  - {name: tri, polygon: [[7, 1], [8, 1], [8, 2]]}
robots:
  - {name: R1, start: [1, 5], goal: [9, 5]}
  - {name: R2, start: [9, 7], goal: [1, 2]}
"""
ONE = "taut: 1\nbounds: [0, 0, 4, 3]\nrobots:\n  - {name: R1, start: [1, 1], goal: [1, 1]}\n"
WALLED = """\
taut: 1
gap: 0.1
bounds: [0, 0, 4, 3]
obstacles: [{name: wall, polygon: [[1.5, -1], [2, -1], [2, 4], [1.5, 4]]}]
robots:
  - {name: R1, start: [1, 1], goal: [2.3, 1]}
  - {name: R2, start: [1, 2], goal: [2.3, 2]}
"""


@pytest.fixture
def graph(tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]) -> Command:
    return on_scenes(command_in(tmp_path, monkeypatch, capsys, "graph"))


def only(run: Run) -> Any:
    """Return the report of the only size of robot."""
    (size,) = run.json["sizes"]
    return size


def laplacian(size: Any) -> Any:
    """Return the Laplacian that the edges of a report make, (n, n)."""
    out = np.zeros((size["graph"]["vertices"], size["graph"]["vertices"]))
    for (a, b), weight in zip(size["graph"]["edges"], size["graph"]["weights"], strict=True):
        out[[a, b], [a, b]] += weight
        out[[a, b], [b, a]] -= weight
    return out


@pytest.mark.parametrize("weight", ["one", "distance"])
@pytest.mark.parametrize("edges", ["all", "tangent"])
@pytest.mark.parametrize("scene", ["thesis-1", "thesis-3", "appendix-d", ROOM])
def test_every_number_follows_from_the_edges(graph: Command, scene: str, edges: str, weight: str) -> None:
    size = only(graph(scene, "--edges", edges, "--weight", weight, "--json"))
    found, matrix = size["graph"], laplacian(size)
    values = np.linalg.eigvalsh(matrix)
    slack = 1e-12 * values[-1]
    places, ends = np.array(found["positions"]), np.array(found["edges"])
    np.testing.assert_allclose(found["lengths"], np.linalg.norm(places[ends[:, 0]] - places[ends[:, 1]], axis=1))
    assert found["weights"] == (found["lengths"] if weight == "distance" else [1.0] * len(ends))
    assert found["degrees"] == np.bincount(ends.ravel(), minlength=len(places)).tolist()
    np.testing.assert_allclose(found["weighted_degrees"], np.diag(matrix))
    np.testing.assert_allclose(size["eigenvalues"], values, rtol=0, atol=10 * slack)
    assert size["lambda2"] == size["eigenvalues"][1] > 0
    fiedler = np.array(size["fiedler_vector"])
    np.testing.assert_allclose(matrix @ fiedler, size["lambda2"] * fiedler, atol=100 * slack)
    assert size["beta"] == len(ends) / len(places)
    assert size["components"] == 1
    np.testing.assert_allclose(size["kirchhoff_index"], len(places) * (1 / values[1:]).sum())
    for bound in size["bounds"]:
        assert bound["side"] != "upper" or size["lambda2"] <= bound["value"] + slack, bound
        assert bound["side"] != "lower" or size["lambda2"] >= bound["value"] - slack, bound
    cut = size["isoperimetric"]
    inside = np.isin(np.arange(len(places)), cut["cut"])
    crossed = inside[ends[:, 0]] != inside[ends[:, 1]]
    np.testing.assert_allclose(cut["upper"], np.array(found["weights"])[crossed].sum() / inside.sum())
    assert cut["lower"] <= cut["upper"] <= cut["cheeger"] + slack


def test_kinds_of_edges_and_counts_are_those_of_the_two_visibility_graphs(graph: Command) -> None:
    every, tangent = (only(graph("thesis-3", "--edges", kind, "--json")) for kind in ("all", "tangent"))
    for key in ("vertices", "edges", "corners", "tangent_edges"):
        assert every[key] == tangent[key]
    assert (every["graph"]["vertices"], len(every["graph"]["edges"])) == (every["vertices"], every["edges"])
    assert tangent["graph"]["vertices"] == tangent["corners"] + 6
    assert len(tangent["graph"]["edges"]) == tangent["tangent_edges"] < every["edges"]


def test_vertices_are_named(graph: Command) -> None:
    size = only(graph("thesis-1", "--json"))
    ends = ["R1 start", "R1 goal, R2 goal, R3 goal", "R2 start", "R3 start"]
    assert size["graph"]["names"] == ["corner"] * 24 + ends
    assert size["graph"]["positions"][24:] == [[2, 1], [5, 16], [8.7, 0.3], [11, 1]]
    told = graph("thesis-1").out
    assert told.count("corner\n") == 24
    assert all(name in told for name in ends)


def rows(text: str, head: str) -> list[list[str]]:
    """Return the cells under the table whose first head is this, row by row, without the first column."""
    lines = iter(text.splitlines())
    next(line for line in lines if line.split()[:1] == [head])
    next(lines)
    out = []
    for line in lines:
        if not line:
            break
        out.append(line.split()[1:])
    return out


@pytest.mark.parametrize("weight", ["one", "distance"])
def test_small_graphs_are_printed_in_full(graph: Command, weight: str) -> None:
    run, size = graph(ROOM, "--weight", weight), only(graph(ROOM, "--weight", weight, "--json"))
    n = 11
    printed = {
        letter: np.array([[0.0 if cell == "·" else float(cell) for cell in row] for row in rows(run.out, letter)])
        for letter in "ADL"
    }
    matrix = laplacian(size)
    np.testing.assert_allclose(printed["L"], matrix, atol=5e-5)
    np.testing.assert_allclose(printed["D"], np.diag(np.diag(matrix)), atol=5e-5)
    np.testing.assert_allclose(printed["A"], printed["D"] - printed["L"], atol=2e-4)
    assert {name: np.array(rows).tolist() for name, rows in size["matrices"].items()}["laplacian"] == matrix.tolist()
    assert [row[0:2] for row in rows(run.out, "edge")] == [
        [f"v{a + 1}", f"v{b + 1}"] for a, b in size["graph"]["edges"]
    ]
    np.testing.assert_allclose(
        [[float(x) for x in row[:2]] for row in rows(run.out, "vertex")], size["graph"]["positions"]
    )
    said = run.out.partition("eigenvalues of L\n")[2].split()
    np.testing.assert_allclose([float(word) for word in said if "λ" not in word], size["eigenvalues"], atol=5e-5)
    assert len(size["eigenvalues"]) == n


def test_bounds_are_printed_as_a_ladder_round_lambda2(graph: Command) -> None:
    table = graph("thesis-2").out.partition("formula")[2].partition("\n\n")[0].splitlines()[2:]
    sides = [re.match(r"(at least|is|at most) +(\S+)", line) for line in table]
    found = [(side[1], float(side[2])) for side in sides if side is not None]
    assert len(found) == len(table) >= 6
    assert [value for _, value in found] == sorted(value for _, value in found)
    assert [side for side, _ in found] == sorted((side for side, _ in found), key=["at least", "is", "at most"].index)
    assert ("is", 3.4226) in found


def test_of_more_vertices_less_is_printed(graph: Command) -> None:
    run = graph("appendix-d")  # 94 vertices
    assert "the least 5 and the greatest 3 of 94" in run.out
    assert "λ92" in run.out
    assert "corner\n" not in run.out
    assert "d_min" in run.out  # the bounds are still there
    size = only(graph("appendix-d", "--json"))
    assert size["matrices"] is None
    assert len(size["eigenvalues"]) == 94


def test_of_large_graphs_only_lambda2_is_computed(graph: Command, monkeypatch: pytest.MonkeyPatch) -> None:
    def never(*_: object) -> None:
        raise AssertionError("too much work")

    for room, name in (
        ("spectral", "spectrum"),
        ("bounds", "connectivity_bounds"),
        ("bounds", "isoperimetric_bounds"),
        ("resistance", "kirchhoff_index"),
    ):
        monkeypatch.setattr(import_module(f"taut.graph.{room}"), name, never)
    words = ("warehouse-50", "--growth", "0.6", "--edges", "tangent")
    size = only(graph(*words, "--json"))
    assert size["graph"]["vertices"] > 3000
    assert [size[key] for key in ("eigenvalues", "bounds", "isoperimetric", "kirchhoff_index")] == [None] * 4
    ends, fiedler = np.array(size["graph"]["edges"]), np.array(size["fiedler_vector"])
    np.testing.assert_allclose(size["lambda2"], ((fiedler[ends[:, 0]] - fiedler[ends[:, 1]]) ** 2).sum(), rtol=1e-6)
    assert size["lambda2"] > 0
    run = graph(*words)
    assert run.code == 0
    assert "left out" in run.out
    assert "1,000 vertices" in run.out


def test_growth_chooses_a_size_of_robot(graph: Command) -> None:
    known = load_scene("warehouse-50")
    growths = sorted({known.growth(robot) for robot in known.robots})
    assert growths[0] != 0.4  # 0.3 + 0.1 in floats
    told = graph("warehouse-50", "--growth", "0.4", "--edges", "tangent", "--json").json
    assert [size["growth"] for size in told["sizes"]] == growths[:1]
    assert len(told["robots"]) == told["sizes"][0]["robots"] == 42


def test_a_growth_of_no_robot_leaves_the_corners(graph: Command) -> None:
    told = graph(ROOM, "--growth", "0.25", "--json").json
    assert told["robots"] == []
    assert told["sizes"][0]["robots"] == 0
    assert set(told["sizes"][0]["graph"]["names"]) == {"corner"}
    run = graph(ROOM, "--growth", "4.5")
    assert (run.code, run.err) == (0, "")
    assert "no free space" in run.out


@pytest.mark.parametrize(
    ("scene", "vertices", "edges", "components", "connectivity"),
    [(EMPTY, 0, 0, 0, 0.0), (ONE, 1, 0, 1, 0.0), (WALLED, 4, 2, 2, 0.0), (ROOM, 11, 35, 1, None)],
    ids=["no vertex", "one vertex", "disconnected", "room"],
)
def test_scenes_of_few_vertices(
    graph: Command, scene: str, vertices: int, edges: int, components: int, connectivity: float | None
) -> None:
    run = graph(scene, "--figure", "a.png", "--graphml", "a.graphml")
    assert (run.code, run.err) == (0, "")
    assert Path("a.png").read_bytes().startswith(b"\x89PNG")
    told = graph(scene, "--json")
    size = only(told)
    assert (size["graph"]["vertices"], len(size["graph"]["edges"]), size["components"]) == (vertices, edges, components)
    assert connectivity is None or size["lambda2"] == connectivity
    if components > 1:
        assert "infinite" in run.out
        assert size["kirchhoff_index"] is None
        assert [robot["shortest"] for robot in told.json["robots"]] == [None, None]


def test_each_size_of_robot_gets_its_part(graph: Command) -> None:
    scene = ROOM.replace("goal: [9, 5]", "goal: [9, 5], radius: 0.3").replace(
        "goal: [1, 2]", "goal: [1, 2], radius: 0.4"
    )
    told = graph(scene, "--json", "--figure", "a.svg").json
    assert [size["growth"] for size in told["sizes"]] == [0.3, 0.4]
    assert told["files"] == ["a.svg"]
    run = graph(scene)
    assert run.out.count("an edge weighs 1") == 2
    assert refused(graph(scene, "--graphml", "a.graphml"), "--graphml", "--growth (0.3, 0.4)")
    assert graph(scene, "--graphml", "a.graphml", "--growth", "0.3").code == 0


def test_a_graphml_file_holds_the_graph(graph: Command) -> None:
    size = only(graph(ROOM, "--weight", "distance", "--graphml", "room.graphml", "--json"))
    read, positions = load_graphml("room.graphml")
    assert read.edges.tolist() == size["graph"]["edges"]
    assert read.lengths.tolist() == size["graph"]["weights"]
    assert positions is not None
    assert positions.tolist() == size["graph"]["positions"]


def test_what_does_not_fit_is_refused_before_the_work(graph: Command, monkeypatch: pytest.MonkeyPatch) -> None:
    def never(*_: object, **__: object) -> None:
        raise AssertionError("built although the command line is wrong")

    monkeypatch.setattr("taut.roadmap.visibility_graph", never)
    assert refused(graph(ROOM, "--growth", "-1"), "--growth", "0 or more")
    assert refused(graph(ROOM, "--growth", "nan"), "--growth")
    assert refused(graph(ROOM, "--growth", "inf"), "--growth")
    assert refused(graph(ROOM, "--growth", "1e300"), "--growth", "10 m")
    assert refused(graph(ROOM, "--growth", "wide"), "--growth")
    assert refused(graph(ROOM, "--weight", "heavy"), "--weight", "distance")
    assert refused(graph(ROOM, "--edges", "few"), "--edges", "tangent")
    assert refused(graph(ROOM, "--figure", "a.docx"), ".png")
    assert refused(graph(ROOM, "--figure", "missing/a.png"), "directory")
    assert refused(graph(ROOM, "--graphml", "a.xml"), ".graphml")
    assert refused(graph(ROOM, "--graphml", "missing/a.graphml"), "directory")
    team = "".join(
        f"  - {{name: P{k}, start: [{1 + 2 * k}, 1], goal: [{1 + 2 * k}, 1], radius: 0.{k + 10}}}\n" for k in range(13)
    )
    crowd = f"taut: 1\nbounds: [0, 0, 30, 2]\nrobots:\n{team}"
    assert refused(graph(crowd, "--figure", "a.png"), "--figure", "12", "13", "--growth")
    monkeypatch.setitem(sys.modules, "networkx", None)
    assert refused(graph(ROOM, "--graphml", "a.graphml"), "networkx")
    assert sorted(path.name for path in Path().iterdir()) == ["scene.yaml"]
