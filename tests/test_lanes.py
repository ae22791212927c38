"""Lanes given by the user: what is refused, what is laid into free space, who moves where, and files of them."""

from __future__ import annotations

import io
import json
import math
import zipfile
from collections.abc import Sequence
from itertools import combinations, pairwise
from pathlib import Path
from typing import Any

import networkx as nx
import numpy as np
import pytest
import shapely
from hypothesis import assume, given, settings
from hypothesis import strategies as st
from numpy.typing import NDArray
from scipy.sparse import csr_array
from scipy.sparse.csgraph import dijkstra

from strategies import scenes
from taut import (
    Lanes,
    NoPath,
    NoPlanExists,
    NoPlanFound,
    Rectangle,
    Robot,
    Scene,
    SceneError,
    load_roadmap,
    plan,
    save_roadmap,
)
from taut.cli import main
from taut.errors import OutputError
from taut.formats.files import save
from taut.freespace import FreeSpace
from taut.roadmap import closed_lanes, grid_lanes, lanes_roadmap
from taut.roadmap.lanes import united_places
from taut.scene import FloatArray
from taut.team.world import World

SQUARE = [(0, 0), (4, 0), (4, 4), (0, 4)]


def same(a: Lanes, b: Lanes) -> bool:
    """Whether two Lanes are equal bit for bit, but for where they come from."""
    arrays = ("positions", "arcs", "limits")
    return a.names == b.names and all(getattr(a, x).tobytes() == getattr(b, x).tobytes() for x in arrays)


@st.composite
def lanes(draw: st.DrawFn, grid: int = 6, most: int = 10, directed: bool | None = None) -> Lanes:
    """Draw lanes between different integer places; some with limits."""
    places = draw(st.lists(st.tuples(*[st.integers(0, grid)] * 2), min_size=2, max_size=most, unique=True))
    pairs = list(combinations(range(len(places)), 2))
    edges = draw(st.lists(st.sampled_from(pairs), max_size=2 * most, unique=True))
    flips = draw(st.lists(st.booleans(), min_size=len(edges), max_size=len(edges)))
    limits = draw(st.lists(st.sampled_from([0.25, 0.5, 2.0, math.inf]), min_size=len(edges), max_size=len(edges)))
    one_way = draw(st.booleans()) if directed is None else directed
    turned = [(b, a) if flip else (a, b) for (a, b), flip in zip(edges, flips, strict=True)]
    return Lanes.from_edges(places, turned, one_way, limits)


# --- Lanes ------------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("positions", "edges", "more", "message"),
    [
        (SQUARE, [(0, 1), (1, 4)], {}, r"edges\[1\] \(1 – 4\) names a vertex that does not exist; there are 0 … 3"),
        (SQUARE, [(0, -1)], {}, r"edges\[0\] \(0 – -1\) names a vertex that does not exist"),
        ([], [(0, 1)], {}, "there are no vertices"),
        (SQUARE, [(2, 2)], {}, r"edges\[0\] \(2 – 2\) joins a vertex with itself"),
        (SQUARE, [(0, 1), (2, 3), (1, 0)], {}, r"edges\[2\] \(1 – 0\) is given twice; keep one, as it leads both ways"),
        (SQUARE, [(0, 1), (0, 1)], {"directed": True}, r"edges\[1\] \(0 – 1\) is given twice; keep one"),
        ([(0, 0), (1, 1), (1, 1)], [(0, 1), (1, 2)], {}, r"edges\[1\] \(1 – 2\) has no length"),
        ([(0, 0), (1, 1), (1, 1)], [(0, 1), (0, 2)], {}, r"vertex 2 lies at \(1, 1\) like vertex 1; make them one"),
        ([(0, 0), (math.nan, 1)], [], {}, "vertex 1 is not at a finite place"),
        ([(-1e308, 0), (1e308, 0)], [(0, 1)], {}, "too long for any number"),
        (SQUARE, [(0, 1)], {"limits": [0]}, r"edges\[0\] \(0 – 1\) has the speed limit 0; it must be positive"),
        (SQUARE, [(0, 1), (1, 2)], {"limits": [1, -1]}, r"edges\[1\] \(1 – 2\) has the speed limit -1"),
        (SQUARE, [(0, 1)], {"limits": [math.nan]}, "speed limit nan"),
        (SQUARE, [(0, 1)], {"limits": [1, 1]}, "1 edges but 2 limits"),
        (SQUARE, [(0, 1)], {"names": ["A"]}, "4 vertices but 1 names"),
        (SQUARE, [(0, 1)], {"names": ["A", "B", "C", "A"]}, "vertex 3 is named A, as another is"),
        (SQUARE, [(0, 1)], {"names": ["A", "", "C", "D"]}, "vertex 1 must be named by text"),
        (SQUARE, [(0, 0.5)], {}, "whole numbers"),
        (SQUARE, [(0, 1, 2)], {}, "pairs of vertices"),
        ([(0, 0, 0)], [], {}, r"array \(k, 2\)"),
    ],
)
def test_what_are_no_lanes_is_refused_with_its_number(
    positions: Any, edges: Any, more: dict[str, Any], message: str
) -> None:
    with pytest.raises(ValueError, match=message):
        Lanes.from_edges(positions, edges, **more)


def test_arcs_are_ascending_and_lanes_lead_both_ways_unless_directed() -> None:
    both = Lanes.from_edges(SQUARE, [(2, 1), (0, 1)], limits=[3, math.inf])
    assert both.arcs.tolist() == [[0, 1], [1, 0], [1, 2], [2, 1]]
    assert both.limits.tolist() == [math.inf, math.inf, 3, 3]
    assert both.lengths.tolist() == [4, 4, 4, 4]
    assert Lanes.from_edges(SQUARE, [(2, 1), (0, 1)], directed=True).arcs.tolist() == [[0, 1], [2, 1]]
    assert len(Lanes.from_edges([], []).positions) == 0


def test_vertices_without_lanes_may_coincide() -> None:
    assert len(Lanes.from_edges([(0, 0), (1, 0), (1, 0)], [(0, 1)]).positions) == 3


@given(lanes(directed=True), st.integers(0, 4))
def test_uniting_twins_changes_no_distance(given_lanes: Lanes, copies: int) -> None:
    """Vertices are doubled, their lanes are shared out among the doubles, which are joined by lanes without length."""
    n = len(given_lanes.positions)
    doubles = list(range(min(copies, n)))
    positions = np.concatenate([given_lanes.positions, given_lanes.positions[doubles]])
    edges = given_lanes.arcs.copy()
    for k, v in enumerate(doubles):
        edges[1::2][edges[1::2] == v] = n + k
    links = np.array([(v, n + k) for k, v in enumerate(doubles)], dtype=np.int64).reshape(-1, 2)
    edges = np.concatenate([edges, links, links[:, ::-1]])
    moved, kept = united_places(positions, edges, True, np.full(len(edges), np.inf))
    united = Lanes.from_edges(positions, moved, directed=True)
    assert (moved < n).all()
    assert len(kept) == len(given_lanes.arcs)
    np.testing.assert_array_equal(united.arcs, given_lanes.arcs)


# --- Grids ------------------------------------------------------------------------------------------------------------


@settings(max_examples=40)
@given(
    st.integers(1, 6).flatmap(
        lambda c: st.lists(st.lists(st.booleans(), min_size=c, max_size=c), min_size=1, max_size=6)
    ),
    st.sampled_from([4, 8, 16, 32]),
)
def test_a_grid_joins_free_cells_that_no_blocked_cell_lies_between(cells: list[list[bool]], directions: int) -> None:
    free = np.array(cells)
    found = grid_lanes(free, directions, spacing=2.0, origin=(1.0, -1.0))
    centres = [(c, r) for r, c in np.argwhere(free).tolist()]
    np.testing.assert_array_equal(found.positions, np.array(centres, dtype=float).reshape(-1, 2) * 2 + (1, -1))
    blocked = [shapely.box(c - 0.5, r - 0.5, c + 0.5, r + 0.5) for r, c in np.argwhere(~free).tolist()]
    steps = sorted(
        {(a, b) for a in range(-3, 4) for b in range(-3, 4) if math.gcd(a, b) == 1}, key=lambda s: s[0] ** 2 + s[1] ** 2
    )[:directions]
    number = {centre: k for k, centre in enumerate(centres)}
    expected = []
    for (x, y), k in number.items():
        for a, b in steps:
            line = shapely.LineString([(x, y), (x + a, y + b)])
            # the inside of a cell is met if the line has some length in it; it runs along no side
            if (x + a, y + b) in number and all(shapely.intersection(line, cell).length < 1e-9 for cell in blocked):
                expected.append([k, number[x + a, y + b]])
    assert found.arcs.tolist() == sorted(expected)


def test_wrong_grids_are_refused() -> None:
    for wrong, message in (
        ({"directions": 6}, "directions must be 4, 8, 16 or 32, got 6"),
        ({"spacing": 0}, "spacing must be a positive number"),
        ({"free": [True]}, "truth values"),
        ({"free": [[1, 0]]}, "truth values"),
    ):
        with pytest.raises(ValueError, match=message):
            grid_lanes(**{"free": [[True]], **wrong})  # type: ignore[arg-type]


# --- In free space ----------------------------------------------------------------------------------------------------


@settings(max_examples=80, deadline=None)
@given(scenes(max_robots=0), lanes(grid=8, directed=True), st.sampled_from([0.0, 0.25, 0.5]))
def test_exactly_the_lanes_that_free_space_covers_are_left(scene: Scene, given_lanes: Lanes, growth: float) -> None:
    """What merely touches itself is the exception: no lane leads through such a place."""
    free = FreeSpace(scene, growth)
    laid = lanes_roadmap(given_lanes, free, 1.0)
    n, ends = len(given_lanes.positions), given_lanes.positions[given_lanes.arcs]
    tails = np.repeat(np.arange(n), np.diff(laid.arcs.indptr))
    left = {
        (a, b): (x, y) for a, b, x, y in zip(tails, laid.arcs.indices, laid.arcs.lengths, laid.arcs.limits, strict=True)
    }
    assert (laid.positions == given_lanes.positions).all()
    exact = growth == 0.0 and scene_is_of_halves(scene)
    pinches = free.mesh.vertices[np.diff(free.mesh.vertex_start) > 1]
    pinched = shapely.multipoints(pinches) if len(pinches) else shapely.Point()
    for (a, b), segment, limit in zip(given_lanes.arcs.tolist(), ends, given_lanes.limits, strict=True):
        line = shapely.LineString(segment)
        if (a, b) in left:
            assert shapely.covers(shapely.buffer(free.region, 4 * scene.tol), line)
            assert left[a, b] == (pytest.approx(math.dist(*segment), rel=1e-15), limit)
        elif not shapely.intersects(pinched, line):
            assert not shapely.covers(shapely.buffer(free.region, -1e-9), line)
            assert not (exact and shapely.covers(free.region, line))
    assert {frozenset(pair) for pair in left} == {frozenset(pair) for pair in laid.edges.tolist()}
    lost = {tuple(sorted(pair)) for pair in given_lanes.arcs.tolist()} - {tuple(sorted(pair)) for pair in left}
    assert sorted(lost) == [tuple(pair) for pair in laid.closed.tolist()]
    assert laid.count == len({frozenset(pair) for pair in given_lanes.arcs.tolist()})


def scene_is_of_halves(scene: Scene) -> bool:
    """Whether all corners are so simple that no rounding decides whether a lane touches them."""
    corners = np.concatenate([np.array(scene.workspace), *(o.core for o in scene.obstacles)])
    plain = all(o.own_radius == 0 and getattr(o, "angle", 0.0) == 0 for o in scene.obstacles)
    return plain and bool((2 * corners == np.round(2 * corners)).all())


def test_lanes_slide_along_walls_and_corners() -> None:
    shelves = Scene((0, 0, 10, 5), [Rectangle(2, 1.5, 2, 0.5), Rectangle(6, 1.5, 2, 0.5)])
    places = [(0.5, 1), (9.5, 1), (9.5, 2.5), (0.5, 2.5)]
    along = Lanes.from_edges(places, [(0, 1), (1, 2), (2, 3), (3, 0), (3, 1)])
    laid = lanes_roadmap(along, FreeSpace(shelves, 0.5), 1.0)
    assert laid.closed.tolist() == [[1, 3]]
    assert closed_lanes(along, laid) == (
        "1 of 5 lanes are too narrow or blocked for radius + clearance 0.5 m (first: 1 at (9.5, 1) – 3 at (0.5, 2.5))"
    )


def test_no_lane_leads_through_a_point_where_obstacles_touch() -> None:
    corner = Scene((0, 0, 4, 4), [Rectangle(0, 2, 2, 2), Rectangle(2, 0, 2, 2)])
    across = Lanes.from_edges([(1, 1), (3, 3), (2, 2)], [(0, 1), (0, 2), (2, 1)])
    assert len(lanes_roadmap(across, FreeSpace(corner), 0.1).closed) == 3


# --- Fastest ways -----------------------------------------------------------------------------------------------------


@settings(max_examples=60, deadline=None)
@given(lanes(), st.data())
def test_ways_are_the_fastest_that_the_lanes_lead(given_lanes: Lanes, data: st.DataObject) -> None:
    n = len(given_lanes.positions)
    vertices = st.integers(0, n - 1).filter(lambda v: bool((given_lanes.arcs == v).any()))
    assume(len(given_lanes.arcs))
    start, goal = data.draw(vertices), data.draw(vertices)
    speed = data.draw(st.sampled_from([0.2, 0.5, 1.0, 3.0]))
    times = given_lanes.lengths / np.minimum(speed, given_lanes.limits)
    table = csr_array((times, (given_lanes.arcs[:, 0], given_lanes.arcs[:, 1])), shape=(n, n))
    expected = float(dijkstra(table)[start, goal])
    places = [(float(x), float(y)) for x, y in given_lanes.positions]
    scene = Scene((-1, -1, 7, 7), robots=[Robot("R1", places[start], places[goal], 0.1, speed)])
    if math.isinf(expected):
        with pytest.raises(NoPath, match=r"^R1: the lanes do not lead from .*"):
            World(scene, given_lanes)
        return
    world = World(scene, given_lanes)
    assert world.own(0).ends == (start, goal)
    assert len(world.own(0).positions) == len(world.own(0).edges) == 0
    assert world.horizon == pytest.approx(expected or 1.0, rel=1e-12)
    assert seconds_along(given_lanes, world.routes[0].points, speed) == pytest.approx(expected, rel=1e-12)


def seconds_along(given_lanes: Lanes, points: FloatArray, speed: float) -> float:
    """Least time for a polyline whose bends are vertices, by way of arcs in their directions; inf if there is none."""
    number = {tuple(place): v for v, place in enumerate(given_lanes.positions.tolist())}
    arcs = {
        (a, b): length / min(speed, limit)
        for (a, b), length, limit in zip(
            given_lanes.arcs.tolist(), given_lanes.lengths.tolist(), given_lanes.limits.tolist(), strict=True
        )
    }
    path = [number[tuple(place)] for place in points.tolist()]
    return math.fsum(arcs.get(pair, math.inf) for pair in pairwise(path))


def test_an_end_off_the_lanes_is_joined_with_the_nearest_vertices_that_it_sees() -> None:
    wall = Scene((0, 0, 10, 6), [Rectangle(4, 0, 1, 3)], [Robot("R1", (3, 1), (9, 5), 0.2)])
    given_lanes = Lanes.from_edges([(2, 4), (6, 1), (9, 4), (6, 4), (1, 1)], [(0, 3), (3, 2), (2, 1), (4, 0)])
    own = World(wall, given_lanes).own(0)
    assert own.ends == (5, 6)
    assert own.positions.tolist() == [[3, 1], [9, 5]]
    assert own.edges[own.edges[:, 1] == 5].tolist() == [[4, 5], [0, 5]]
    assert own.edges[own.edges[:, 1] == 6, 0].tolist() == [2, 3, 1, 0]
    np.testing.assert_allclose(own.lengths[:2], [2, math.hypot(1, 3)])
    assert own.pinched == (False, False)


def test_a_robot_that_stands_needs_no_lanes() -> None:
    on, off = Robot("R1", (0, 0), (0, 0), 0.2), Robot("R2", (2, 2), (2, 2), 0.2)
    scene = Scene((-1, -1, 5, 5), robots=[on, off])
    world = World(scene, Lanes.from_edges(SQUARE, [(0, 1)]))
    assert world.own(0).ends == (0, 0)
    assert world.own(1).ends == (4, 4)
    assert plan(scene, roadmap=Lanes.from_edges(SQUARE, [])).certificate.ok


def test_where_lanes_do_not_lead_is_told() -> None:
    robot = Robot("R1", (0, 0), (4, 4), 0.2)
    crossed = Scene((-1, -1, 5, 5), [Rectangle(1.5, -1, 1, 2)], [robot])
    named = Lanes.from_edges(SQUARE, [(0, 1), (1, 2)], names=["A", "B", "C", "D"])
    with pytest.raises(NoPath, match=r"R1: the lanes do not lead from \(0, 0\) to \(4, 4\); 1 of 2 .*first: A – B"):
        plan(crossed, roadmap=named)
    backwards = Lanes.from_edges(SQUARE, [(1, 0), (2, 1)], directed=True)
    with pytest.raises(NoPath, match=r"R1: the lanes do not lead .* only against the direction of one-way lanes"):
        plan(Scene((-1, -1, 5, 5), robots=[robot]), roadmap=backwards)
    with pytest.raises(NoPath, match=r"R1: its start \(0, 0\) is on no vertex of the lanes and sees none"):
        plan(Scene((-1, -1, 5, 5), robots=[robot]), roadmap=Lanes.from_edges(SQUARE, []))


# --- Plans ------------------------------------------------------------------------------------------------------------

CLOISTER = Lanes.from_edges(
    [(x, y) for y in range(5) for x in range(5)],
    [(5 * y + x, 5 * y + x + 1) for y in range(5) for x in range(4)]
    + [(5 * y + x, 5 * y + x + 5) for y in range(4) for x in range(5)],
)


@st.composite
def teams(draw: st.DrawFn, n: int = 4) -> list[Robot]:
    """Draw robots between different vertices of the cloister."""
    vertices = draw(st.lists(st.integers(0, 24), min_size=2 * n, max_size=2 * n, unique=True))
    places = [(float(v % 5), float(v // 5)) for v in vertices]
    speeds = draw(st.lists(st.sampled_from([0.5, 1.0]), min_size=n, max_size=n))
    return [Robot(f"R{k}", places[2 * k], places[2 * k + 1], 0.3, speeds[k]) for k in range(n)]


@settings(max_examples=15, deadline=None)
@given(teams())
def test_teams_on_lanes_are_certified_and_keep_to_them(robots: list[Robot]) -> None:
    scene = Scene((-1, -1, 5, 5), robots=robots)
    try:
        found = plan(scene, roadmap=CLOISTER)
    except (NoPlanExists, NoPlanFound):
        assume(False)
    assert found.certificate.ok
    assert found.plan.planner["roadmap"] == "lanes"
    for motion in found.plan.trajectories:
        bends = motion.points
        assert (bends == np.round(bends)).all()
        assert (np.abs(np.diff(bends, axis=0)).min(axis=1) == 0).all()


@settings(max_examples=25, deadline=None)
@given(teams(3), st.data())
def test_nobody_goes_against_a_lane_or_faster_than_it_allows(robots: list[Robot], data: st.DataObject) -> None:
    both = CLOISTER.arcs[CLOISTER.arcs[:, 0] < CLOISTER.arcs[:, 1]]
    sides = data.draw(st.lists(st.sampled_from([0, 0, 0, 1, 2]), min_size=len(both), max_size=len(both)))
    limits = data.draw(st.lists(st.sampled_from([0.3, 0.7, math.inf]), min_size=len(both), max_size=len(both)))
    arcs = [(a, b, v) for (a, b), side, v in zip(both.tolist(), sides, limits, strict=True) if side != 1]
    arcs += [(b, a, v) for (a, b), side, v in zip(both.tolist(), sides, limits, strict=True) if side != 2]
    one_way = Lanes.from_edges(CLOISTER.positions, [arc[:2] for arc in arcs], True, [arc[2] for arc in arcs])
    try:
        found = plan(Scene((-1, -1, 5, 5), robots=robots), roadmap=one_way)
    except (NoPath, NoPlanExists, NoPlanFound):
        assume(False)
    assert found.certificate.ok
    allowed = {(a, b): v for a, b, v in arcs}
    for motion in found.plan.trajectories:
        for (t, ax, ay), (u, bx, by) in pairwise(motion.stamps.tolist()):
            cells = max(abs(bx - ax), abs(by - ay))
            passed = (
                [(ax + (bx - ax) * k / cells, ay + (by - ay) * k / cells) for k in range(int(cells) + 1)]
                if cells
                else []
            )
            for (px, py), (qx, qy) in pairwise(passed):
                limit = allowed[int(px + 5 * py), int(qx + 5 * qy)]
                assert cells <= limit * (u - t) * (1 + 1e-9)


def test_a_plan_names_its_lanes_and_those_that_are_too_narrow() -> None:
    scene = Scene((-1, -1, 5, 5), [Rectangle(1, 2, 2, 1)], [Robot("R1", (0, 0), (4, 4), 0.5)])
    ring = Lanes.from_edges(SQUARE, [(0, 1), (1, 2), (2, 3), (3, 0), (0, 2)], source="ring.json")
    found = plan(scene, roadmap=ring)
    assert found.plan.planner["roadmap"] == "ring.json"
    assert found.notes[-1].startswith("1 of 5 lanes are too narrow or blocked for radius + clearance 0.5 m")
    with pytest.raises(SceneError, match="mrppa"):
        plan(scene, roadmap=ring, method="mrppa")
    with pytest.raises(SceneError, match=r"roadmap 'ring.json' is not one of visibility.*nor Lanes"):
        plan(scene, roadmap="ring.json")


# --- Files ------------------------------------------------------------------------------------------------------------


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return tmp_path_factory.mktemp("lanes")


COORDINATES = st.floats(-1e70, 1e70, allow_nan=False)
NAMES = st.text(st.characters(exclude_categories=("Cs", "Cc")), min_size=1)


@settings(max_examples=40, deadline=None)
@given(
    lanes(),
    st.lists(COORDINATES, min_size=20, max_size=20),
    st.sampled_from([".json", ".graphml", ".npz"]),
    st.none() | st.lists(NAMES, min_size=10, max_size=10, unique=True),
)
def test_lanes_survive_a_round_trip_bit_for_bit(
    folder: Path, drawn: Lanes, numbers: list[float], ending: str, names: list[str] | None
) -> None:
    n = len(drawn.positions)
    positions = np.array(numbers).reshape(-1, 2)[:n]
    assume(len(np.unique(positions, axis=0)) == n)
    called = None if names is None or names[:n] == [str(k) for k in range(n)] else names[:n]
    before = Lanes.from_edges(positions, drawn.arcs, True, drawn.limits, called)
    save_roadmap(before, folder / f"lanes{ending}")
    after = load_roadmap(folder / f"lanes{ending}")
    assert same(before, after)
    assert after.source == f"lanes{ending}"


def test_names_with_line_breaks_survive_graphml(tmp_path: Path) -> None:
    odd = Lanes.from_edges(SQUARE, [(0, 1)], names=["a\nb", "\tc", "<&>\"'", "é–λ"])
    save_roadmap(odd, tmp_path / "odd.graphml")
    assert same(load_roadmap(tmp_path / "odd.graphml"), odd)
    with pytest.raises(OutputError, match="GraphML cannot hold the name"):
        save_roadmap(Lanes.from_edges(SQUARE, [], names=["a\x01", "b", "c", "d"]), tmp_path / "odd.graphml")
    with pytest.raises(OutputError, match=r"a roadmap is written as \.json, \.graphml or \.npz"):
        save_roadmap(odd, tmp_path / "odd.yaml")


def test_files_of_networkx_are_read(tmp_path: Path) -> None:
    graph = nx.DiGraph()
    graph.add_node("dock", x=0.0, y=0.5, colour="red")
    graph.add_node("bay", pos="4, 0.5")
    graph.add_node("gate", pos=str((4.0, 3.0)))
    graph.add_edge("dock", "bay", speed=0.5)
    graph.add_edge("bay", "gate", speed_limit=2.0, weight=7.0)
    graph.add_edge("gate", "dock")
    expected = Lanes.from_edges(
        [(0, 0.5), (4, 0.5), (4, 3)], [(0, 1), (1, 2), (2, 0)], True, [0.5, 2, np.inf], ["dock", "bay", "gate"]
    )
    nx.write_graphml(graph, tmp_path / "site.graphml")
    assert same(load_roadmap(tmp_path / "site.graphml"), expected)
    for word in ("links", "edges"):
        (tmp_path / "site.json").write_text(json.dumps(nx.node_link_data(graph, edges=word)))
        assert same(load_roadmap(tmp_path / "site.json"), expected)
    grid = nx.grid_2d_graph(2, 3)
    nx.set_node_attributes(grid, {node: list(node) for node in grid}, "pos")
    (tmp_path / "grid.json").write_text(json.dumps(nx.node_link_data(grid, edges="edges")))
    found = load_roadmap(tmp_path / "grid.json")
    assert found.names[1] == "(0, 1)"
    assert len(found.arcs) == 2 * grid.number_of_edges()


def test_archives_hold_arcs_and_vertices_at_one_place_are_one(tmp_path: Path) -> None:
    positions = np.array([(0, 0), (4, 0), (4, 0), (4, 4)], dtype=np.float64)
    edges = np.array([(0, 1), (1, 0), (1, 2), (2, 1), (2, 3), (3, 2)], dtype=np.int32)
    for word in ("vertices", "positions"):
        (tmp_path / "a.npz").write_bytes(archive(edges=edges, **{word: positions}))
        found = load_roadmap(tmp_path / "a.npz")
        assert found.arcs.tolist() == [[0, 1], [1, 0], [1, 3], [3, 1]]
        assert len(found.positions) == 4
    np.savez(tmp_path / "a.npz", vertices=positions, edges=edges[::2], directed=False, limits=np.array([1.0, 2, 3]))
    found = load_roadmap(tmp_path / "a.npz")
    assert found.limits.tolist() == [1, 1, 3, 3]


VERTICES = '"vertices": [[0, 0], [4, 0]]'


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("[1]", "x.json:1: must be a mapping"),
        ("{\n" + VERTICES + "\n}", r"x.json:1: `edges` must be a list"),
        ('{"edges": []}', "`vertices` must be a list of points"),
        ("{" + VERTICES + ',\n"edges": [[0, 1],\n[0, 2]]}', r"x.json:3: edges\[1\] names the vertex 2, .* 0 … 1"),
        ("{" + VERTICES + ',\n"edges": [[0, true]]}', r"x.json:2: edges\[0\] names the vertex true"),
        ("{" + VERTICES + ',\n"edges": [\n[0, 0]]}', r"x.json:3: edges\[0\] \(0 – 0\) joins a vertex with itself"),
        ("{" + VERTICES + ', "edges": [[0]]}', r"edges\[0\] must be \[from, to\] or a mapping with `from` and `to`"),
        ("{" + VERTICES + ', "edges": [{"from": 0, "to": 1, "limit": 3}]}', "known are from, to, speed"),
        ("{" + VERTICES + ', "edges": [{"from": 0, "to": 1, "speed": -3}]}', r"\(0 – 1\) has the speed limit -3"),
        ("{" + VERTICES + ', "edges": [{"from": 0, "to": 1, "speed": "fast"}]}', "speed must be a positive number"),
        ("{" + VERTICES + ', "edges": [], "directed": 1}', "`directed` must be true or false"),
        ("{" + VERTICES + ', "edges": [], "lanes": 1}', "unknown key `lanes`"),
        ('{"kind": "plan", "vertices": [], "edges": []}', "is no roadmap"),
        ('{"vertices": [[0, 0],\n[1, "2"]], "edges": []}', r"x.json:2: vertex 1 must be a point \[x, y\]"),
        ('{"vertices": [[0, 1e999]], "edges": []}', r"vertex 0 must be a point \[x, y\]"),
        ('{"vertices": {"A": [0, 0],\n"B": [0, 1]}, "edges": [["A", "C"]]}', "names the vertex 'C', .*must be listed"),
        ('{"nodes": [{"id": 1}], "links": []}', "vertex 1 has no place; give it numbers `x` and `y`"),
        ('{"nodes": [{"id": 1, "pos": "1"}], "links": []}', "vertex 1 has no place"),
        ('{"nodes": [3], "links": []}', r"nodes\[0\] must be a mapping with `id`"),
        ('{"nodes": []}', "lists of `nodes` and `links`"),
    ],
)  # fmt: skip
def test_what_is_wrong_in_json_is_told_with_its_line(tmp_path: Path, text: str, message: str) -> None:
    refused(tmp_path / "x.json", text.encode(), message)


NODES = '<node id="a"><data key="p">0,0</data></node>\n<node id="b"><data key="p">1,0</data></node>\n'
KEYS = '<graphml><key id="p" for="node" attr.name="pos"/><key id="s" for="edge" attr.name="speed"/>\n'
DIRECTED = KEYS + '<graph edgedefault="directed">\n'


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("<html/>", "x.graphml:1: must begin with <graphml>"),
        ("<graphml>\n<graph", "x.graphml:2: not valid XML"),
        ("<graphml></graphml>", "has no <graph>"),
        ("<graphml><graph/></graphml>", "edgedefault"),
        ('<!DOCTYPE g [<!ENTITY a "b">]>\n<graphml/>', "x.graphml:1: has a document type; remove"),
        ('<!DOCTYPE g SYSTEM "file:///etc/passwd"><graphml/>', "has a document type"),
        (KEYS + '<graph edgedefault="directed"><node id="a"/></graph></graphml>', "x.graphml:2: vertex 'a' has"),
        (DIRECTED + f'{NODES}<edge source="a" target="c"/></graph></graphml>',
         r"x.graphml:5: edges\[0\] names the vertex 'c'"),
        (DIRECTED + f'{NODES}<edge source="a"/></graph></graphml>',
         "x.graphml:5: this edge has no `target`"),
        (DIRECTED + f'{NODES}<edge source="a" target="b"><data key="s">0</data></edge></graph></graphml>',
         r"x.graphml:5: edges\[0\] \('a' – 'b'\) has the speed limit 0"),
        (DIRECTED + f'{NODES}<edge source="a" target="b" directed="false"/></graph></graphml>',
         "x.graphml:5: .*otherwise than edgedefault"),
        (DIRECTED + f'{NODES}{NODES}</graph></graphml>', "x.graphml:5: two vertices"),
        (DIRECTED + f'{NODES}<hyperedge/></graph></graphml>', "hyperedge"),
        (KEYS + '<graph edgedefault="directed"/><graph edgedefault="directed"/></graphml>', "second graph"),
    ],
)  # fmt: skip
def test_what_is_wrong_in_graphml_is_told_with_its_line(tmp_path: Path, text: str, message: str) -> None:
    refused(tmp_path / "x.graphml", text.encode(), message)


def test_defaults_of_graphml_keys_count(tmp_path: Path) -> None:
    keys = KEYS.replace('attr.name="speed"/>', 'attr.name="speed"><default>0.5</default></key>')
    edge = '<edge source="a" target="b"/>'
    (tmp_path / "x.graphml").write_text(f'{keys}<graph edgedefault="directed">{NODES}{edge}</graph></graphml>')
    assert load_roadmap(tmp_path / "x.graphml").limits.tolist() == [0.5]


def archive(**arrays: Any) -> bytes:
    stream = io.BytesIO()
    np.savez(stream, **arrays)
    return stream.getvalue()


TWO: NDArray[np.float64] = np.array([(0.0, 0.0), (1.0, 0.0)])


@pytest.mark.parametrize(
    ("raw", "message"),
    [
        (b"nothing of the kind", "is not an archive of plain NumPy arrays"),
        (archive(vertices=TWO), "must hold the arrays"),
        (archive(vertices=TWO, edges=np.array([{}, {}])), "is not an archive of plain NumPy arrays"),
        (archive(vertices=TWO, edges=np.array([[0, 1]]), lengths=np.ones(1)), "has an array 'lengths'; known"),
        (archive(vertices=TWO, edges=np.array([[0.0, 1.0]])), r"the array `edges` cannot be float64"),
        (archive(vertices=TWO[:, :1], edges=np.array([[0, 1]])), r"`vertices` cannot be float64 of shape \(2, 1\)"),
        (archive(vertices=TWO, edges=np.array([[0, 2]])), r"edges\[0\] \(0 – 2\) names a vertex that does not exist"),
        (archive(vertices=TWO, edges=np.array([[0, 1]]), limits=np.ones(2)), "needs one limit for each edge"),
        (archive(vertices=TWO, edges=np.array([[0, 1]]), limits=np.zeros(1)), "has the speed limit 0"),
        (archive(vertices=TWO * np.nan, edges=np.array([[0, 1]])), "vertex 0 is not at a finite place"),
        (archive(vertices=TWO, edges=np.array([[0, 1]]))[:-60], "is not an archive of plain NumPy arrays"),
    ],
)  # fmt: skip
def test_what_is_wrong_in_an_archive_is_told(tmp_path: Path, raw: bytes, message: str) -> None:
    refused(tmp_path / "x.npz", raw, message)


def test_an_archive_that_unpacks_to_too_much_is_refused(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("taut.formats.roadmaps._LARGEST_ARCHIVE", 1 << 10)
    with zipfile.ZipFile(tmp_path / "x.npz", "w", zipfile.ZIP_DEFLATED) as large:
        large.writestr("vertices.npy", bytes(1 << 16))
    with pytest.raises(SceneError, match="larger than"):
        load_roadmap(tmp_path / "x.npz")


def header(text: str) -> bytes:
    """An archive in which the header of the array `vertices` is this."""
    array = text.encode().ljust(117) + b"\n"
    raw = io.BytesIO()
    with zipfile.ZipFile(raw, "w") as out:
        out.writestr("vertices.npy", b"\x93NUMPY\x01\x00" + len(array).to_bytes(2, "little") + array)
    return raw.getvalue()


@pytest.mark.parametrize("text", ["((((((", "{'descr': '<f8', 'fortran_order': False, 'shape': (" + "9" * 40 + ", 2)}"])
def test_archives_with_damaged_headers_are_refused(tmp_path: Path, text: str) -> None:
    refused(tmp_path / "x.npz", header(text), "is not an archive of plain NumPy arrays")


def test_archives_that_hold_other_files_are_refused(tmp_path: Path) -> None:
    raw = io.BytesIO()
    with zipfile.ZipFile(raw, "w") as out:
        out.writestr("vertices", b"abc")
        out.writestr("edges", b"abc")
    refused(tmp_path / "x.npz", raw.getvalue(), "holds vertices, which is no NumPy array")


def test_a_roadmap_without_vertices_leads_nowhere() -> None:
    with pytest.raises(NoPath, match="R1: the roadmap has no vertices"):
        plan(Scene((0, 0, 9, 9), robots=[Robot("R1", (1, 1), (8, 8))]), roadmap=Lanes.from_edges([], []))


def test_speed_limits_are_no_reason_to_be_called_late() -> None:
    """R1 would meet R2 at top speed, but not at the limit of its lane."""
    places = [(0, 0), (4, 0), (8, 0), (4, -4), (4, 4)]
    lanes = Lanes.from_edges(places, [(0, 1), (1, 2), (3, 1), (1, 4)], limits=[0.25, np.inf, np.inf, np.inf])
    team = [Robot("R2", (4, -4), (4, 4), 0.3), Robot("R1", (0, 0), (8, 0), 0.3)]
    found = plan(Scene((-2, -6, 10, 6), robots=team, gap=0.1), roadmap=lanes)
    assert found.plan.sum_of_costs == pytest.approx(28.0)
    assert found.detours == ("", "")


def refused(path: Path, raw: bytes, message: str) -> None:
    path.write_bytes(raw)
    with pytest.raises(SceneError, match=message) as caught:
        load_roadmap(path)
    assert str(caught.value).startswith(str(path))
    assert "\n" not in str(caught.value)


@pytest.mark.parametrize("name", ["lanes.txt", "lanes.json", "lanes.npz", "lanes.graphml"])
def test_a_file_that_is_not_there_or_of_no_known_kind_is_told(tmp_path: Path, name: str) -> None:
    with pytest.raises(SceneError, match=r"unknown kind of file|does not exist"):
        load_roadmap(tmp_path / name)


# --- The command ------------------------------------------------------------------------------------------------------


def test_the_command_plans_on_a_file_of_lanes(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    save(Scene((-1, -1, 5, 5), robots=[Robot("R1", (0, 0), (4, 4), 0.2)]), tmp_path / "hall.yaml")
    save_roadmap(Lanes.from_edges(SQUARE, [(0, 1), (1, 2)]), tmp_path / "lanes.json")
    command = ["plan", str(tmp_path / "hall.yaml"), "--json", "--roadmap"]
    assert run([*command, str(tmp_path / "lanes.json")]) == 0
    assert json.loads(capsys.readouterr().out)["robots"][0]["length"] == pytest.approx(8.0)
    for wrong, message in (
        ("magic", "'magic' is no roadmap; give one of visibility, voronoi"),
        (str(tmp_path / "none.json"), "does not exist; give one of visibility"),
    ):
        assert run([*command, wrong]) == 2
        assert message in capsys.readouterr().err
    assert run([*command, str(tmp_path / "lanes.json"), "--method", "mrppa"]) == 2
    assert "works on the visibility graph" in capsys.readouterr().err
    (tmp_path / "lanes.json").write_text('{"vertices": []}')
    assert run([*command, str(tmp_path / "lanes.json")]) == 2
    assert "lanes.json:1: `edges` must be a list" in capsys.readouterr().err


def run(arguments: Sequence[str]) -> int:
    return main(list(arguments))
