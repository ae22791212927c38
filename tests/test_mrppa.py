"""MRPPA stage by stage, each step recomputed by other means."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

import numpy as np
import pytest
import scipy.linalg
from scipy.sparse import csgraph, csr_array
from threadpoolctl import threadpool_limits

import taut
from taut.errors import NoPath, SceneError
from taut.formats import scene_names
from taut.graph import WEIGHTS, Graph, dijkstra, spectrum
from taut.graph.core import Floats
from taut.scene import Polygon, Rectangle, Robot, Scene
from taut.team import Result
from taut.team.ground import Bools, Ground, ground_of
from taut.team.stages import (
    BridgeStage,
    FirstPathStage,
    FreeSpaceStage,
    FullGraphStage,
    ObstacleGraphStage,
    SequenceStage,
    SplitStage,
    Stage,
)
from taut.team.telling import stage_data, tell, title

READY = scene_names()


@pytest.fixture(scope="module")
def planned() -> dict[str, Result]:
    return {}


def result_of(name: str, planned: dict[str, Result]) -> Result:
    if name not in planned:
        planned[name] = taut.plan(taut.load_scene(name), method="mrppa")
    return planned[name]


def by_ground(result: Result) -> Iterator[list[Stage]]:
    """The stages of each size of robot."""
    group: list[Stage] = []
    for stage in result.stages[:-1]:
        if isinstance(stage, FreeSpaceStage) and group:
            yield group
            group = []
        group.append(stage)
    yield group


def dense(graph: Graph) -> Floats:
    matrix = np.zeros((graph.n, graph.n))
    (u, v), w = graph.edges.T, graph.lengths
    matrix[u, v] = matrix[v, u] = -w
    matrix[np.diag_indices(graph.n)] = -matrix.sum(axis=1)
    return matrix


def parts(ground: Ground, edges: Bools) -> tuple[int, np.ndarray]:
    pairs = ground.roadmap.edges[edges]
    n = len(ground.names)
    return csgraph.connected_components(csr_array((np.ones(len(pairs)), pairs.T), shape=(n, n)), directed=False)


def lengths_from(ground: Ground, edges: Bools, source: np.int64) -> Floats:
    pairs = ground.roadmap.edges[edges]
    n = len(ground.names)
    matrix = csr_array((ground.roadmap.lengths[edges], pairs.T), shape=(n, n))
    search: Any = csgraph.dijkstra
    return np.asarray(search(matrix, directed=False, indices=int(source)))


@pytest.mark.parametrize("name", READY)
def test_the_split_is_two_components_with_each_obstacle_whole(name: str, planned: dict[str, Result]) -> None:
    for stages in by_ground(result_of(name, planned)):
        cut = next(stage for stage in stages if isinstance(stage, SplitStage))
        assert cut.by == "Fiedler vector"
        ground = cut.ground
        for group in range(len(ground.members)):
            assert len(np.unique(cut.side[ground.groups == group])) == 1
        count, labels = parts(ground, cut.edges)
        assert count == 2
        assert len(np.unique(labels[cut.side])) == len(np.unique(labels[~cut.side])) == 1
        ends = cut.side[ground.roadmap.edges]
        assert (cut.edges == (ends[:, 0] == ends[:, 1])).all()


@pytest.mark.parametrize("name", READY)
def test_every_bridge_is_the_best_of_its_candidates(name: str, planned: dict[str, Result]) -> None:
    for stages in by_ground(result_of(name, planned)):
        cut = next(stage for stage in stages if isinstance(stage, SplitStage))
        waiting = [robot for robot in _order(result_of(name, planned)) if robot in cut.ground.robots]
        edges = cut.edges
        for stage in stages:
            if isinstance(stage, BridgeStage):
                with threadpool_limits(1):
                    _check_bridge(stage, edges, waiting)
                edges = stage.edges
            elif isinstance(stage, FirstPathStage):
                waiting.remove(stage.robot)
        assert waiting == []


def _order(result: Result) -> list[str]:
    """Shortest first, as planning begins."""
    robots = result.plan.scene.robots
    seconds = [length / robot.speed for length, robot in zip(result.shortest, robots, strict=True)]
    return [robots[i].name for i in np.argsort(seconds, kind="stable")]


def _check_bridge(stage: BridgeStage, before: Bools, waiting: list[str]) -> None:
    ground = stage.ground
    away = np.flatnonzero(~before)
    pairs, lengths = ground.roadmap.edges[away], ground.roadmap.lengths[away]
    helped = []
    for robot in waiting:
        start, goal = ground.ends[ground.robots.index(robot)]
        ahead, behind = lengths_from(ground, before, start), lengths_from(ground, before, goal)
        through = np.minimum(ahead[pairs[:, 0]] + behind[pairs[:, 1]], ahead[pairs[:, 1]] + behind[pairs[:, 0]])
        helped.append(through + lengths < ahead[goal] - ground.freespace.scene.tol)
    candidates = np.flatnonzero(np.any(helped, axis=0))
    assert stage.candidates == len(candidates)
    chosen = np.flatnonzero(away == stage.edge)[0]
    assert chosen in candidates
    assert stage.robot == next(robot for robot, helps in zip(waiting, helped, strict=True) if helps[chosen])

    matrix = dense(ground.graph(before))
    values = np.linalg.eigvalsh(matrix)
    assert stage.before == pytest.approx(max(values[1], 0.0), abs=1e-12 * values[-1])
    slack = 1e-12 * (values[-1] + 2)
    # the least eigenvalue on a few vectors is never below the true one: only what it leaves open is computed whole
    _, vectors = np.linalg.eigh(matrix + 4 * values[-1] / len(matrix))
    few = vectors[:, : min(40, len(matrix) - 1)]
    levels = np.einsum("ik,ij,jk->k", few, matrix, few)
    z = few[pairs[candidates, 0]] - few[pairs[candidates, 1]]
    weights = ground.weights[away[candidates]]
    small = np.diag(levels)[None] + weights[:, None, None] * z[:, :, None] * z[:, None, :]
    above = np.linalg.eigvalsh(small)[:, 0]
    assert chosen in candidates[above > stage.after - slack]
    most = candidates[np.argsort(-above, kind="stable")[:4]]
    for candidate in {*most.tolist(), int(chosen)}:
        u, v = pairs[candidate]
        changed = matrix.copy()
        w = ground.weights[away[candidate]]
        changed[[u, v, u, v], [u, v, v, u]] += [w, w, -w, -w]
        exact = np.linalg.eigvalsh(changed)[1]
        assert exact <= stage.after + slack
        if candidate == chosen:
            assert exact == pytest.approx(stage.after, abs=slack)


@pytest.mark.parametrize("name", READY)
def test_every_robot_gets_a_shortest_path_of_its_graph_and_the_plan_holds(
    name: str, planned: dict[str, Result]
) -> None:
    result = result_of(name, planned)
    assert result.certificate.ok
    served = []
    for stage in result.stages:
        if isinstance(stage, FirstPathStage):
            start, goal = stage.ground.ends[stage.ground.robots.index(stage.robot)]
            assert (stage.path[0], stage.path[-1]) == (start, goal)
            assert stage.length == pytest.approx(lengths_from(stage.ground, stage.edges, start)[goal], rel=1e-12)
            served.append(stage.robot)
    assert sorted(served) == sorted(robot.name for robot in result.plan.scene.robots)


@pytest.mark.parametrize("name", ["thesis-1", "thesis-2", "thesis-3", "hospital-12"])
def test_mrppa_and_prioritized_give_the_same_motions(name: str, planned: dict[str, Result]) -> None:
    plain = taut.plan(taut.load_scene(name))
    assert plain.plan.trajectories == result_of(name, planned).plan.trajectories
    assert len(plain.stages) == 1
    assert isinstance(plain.stages[0], SequenceStage)


def test_the_obstacle_graph_of_the_first_thesis_scene_is_the_printed_one(planned: dict[str, Result]) -> None:
    """Figure 5.2: 28 vertices, 24 edges of obstacles, ten components, four isolated vertices."""
    stage = result_of("thesis-1", planned).stages[1]
    assert isinstance(stage, ObstacleGraphStage)
    ground = stage.ground
    assert (len(ground.names), int(ground.on_obstacles.sum()), stage.components) == (28, 24, 10)
    degree = np.bincount(ground.roadmap.edges[ground.on_obstacles].ravel(), minlength=28)
    assert degree.tolist() == [2] * 24 + [0] * 4


@pytest.mark.parametrize(("name", "edges", "connectivity"), [("thesis-1", 149, 2.9573), ("thesis-2", 172, 3.4226)])
def test_the_full_graph_has_the_known_connectivity(
    name: str, edges: int, connectivity: float, planned: dict[str, Result]
) -> None:
    stage = result_of(name, planned).stages[-2]
    assert isinstance(stage, FullGraphStage)
    assert stage.ground.roadmap.graph.m == edges
    assert stage.connectivity == pytest.approx(connectivity, abs=5e-5)
    assert stage.connectivity == spectrum(stage.ground.graph(np.ones(edges, dtype=bool)))[1] or stage.connectivity == (
        pytest.approx(spectrum(stage.ground.graph(np.ones(edges, dtype=bool)))[1], abs=1e-12)
    )


def story(result: Result) -> list[list[str]]:
    return [tell(stage) for stage in result.stages[:-1]]


@pytest.mark.parametrize("name", ["thesis-1", "thesis-2", "appendix-d", "crossing-30", "corridor-swap"])
def test_the_stages_do_not_depend_on_the_eigenvectors_that_lapack_happens_to_give(
    name: str, planned: dict[str, Result], monkeypatch: pytest.MonkeyPatch
) -> None:
    genuine: Any = scipy.linalg.eigh
    rng = np.random.default_rng(3)

    def another(matrix: Floats, *args: object, **options: object) -> object:
        found = genuine(matrix, *args, **options)
        if not isinstance(found, tuple):
            return found
        values, vectors = found
        scale = max(abs(values).max(), 1e-300)
        turned = vectors * rng.choice([-1.0, 1.0], vectors.shape[1])
        first = 0
        for last in range(1, len(values) + 1):
            if last == len(values) or values[last] - values[last - 1] > 1e-12 * scale:
                turn, _ = np.linalg.qr(rng.normal(size=(last - first, last - first)))
                turned[:, first:last] = turned[:, first:last] @ turn
                first = last
        return values + 1e-15 * scale * rng.uniform(-1, 1, len(values)), turned

    expected = story(result_of(name, planned))
    monkeypatch.setattr(scipy.linalg, "eigh", another)
    assert story(taut.plan(taut.load_scene(name), method="mrppa")) == expected


@pytest.mark.parametrize("name", ["thesis-1", "thesis-2", "thesis-3", "appendix-d"])
def test_the_stages_do_not_depend_on_the_order_of_obstacles_and_their_corners(
    name: str, planned: dict[str, Result]
) -> None:
    scene = taut.load_scene(name)
    obstacles = [
        Polygon(o.points[2:] + o.points[:2], o.name) if isinstance(o, Polygon) else o for o in scene.obstacles[::-1]
    ]
    other = Scene(
        scene.workspace,
        obstacles,
        scene.robots,
        clearance=scene.clearance,
        gap=scene.gap,
        at_goal=scene.at_goal,
        name=scene.name,
    )
    first, second = result_of(name, planned), taut.plan(other, method="mrppa")
    for a, b in zip(first.stages[:-1], second.stages[:-1], strict=True):
        assert type(a) is type(b)
        if isinstance(a, BridgeStage) and isinstance(b, BridgeStage):
            assert a.robot == b.robot
            assert a.after == pytest.approx(b.after, abs=1e-11)
            places = [
                {tuple(p) for p in s.ground.roadmap.positions[s.ground.roadmap.edges[s.edge]].tolist()} for s in (a, b)
            ]
            assert places[0] == places[1]
        if isinstance(a, SplitStage) and isinstance(b, SplitStage):
            sides = [{tuple(p) for p in s.ground.roadmap.positions[s.side].tolist()} for s in (a, b)]
            assert sides[0] == sides[1]


def small(obstacles: list[Rectangle], robots: list[Robot], **options: object) -> Result:
    scene = Scene((0, 0, 10, 10), obstacles, robots, gap=0.05, at_goal="leave", name="small")
    return taut.plan(scene, method="mrppa", **options)  # type: ignore[arg-type]


def test_one_obstacle_or_none_or_one_robot_still_make_sense() -> None:
    robots = [Robot("R1", (1, 5), (9, 5)), Robot("R2", (5, 1), (5, 9))]
    for obstacles in ([], [Rectangle(4, 4, 2, 2)]):
        for team in (robots, robots[:1]):
            result = small(obstacles, team)
            assert result.certificate.ok
            assert [s.robot for s in result.stages if isinstance(s, FirstPathStage)] != []
            for stage in result.stages:
                assert title(stage)
                assert tell(stage)
                assert stage_data(stage)["kind"]


def test_a_robot_at_its_goal_in_an_empty_hall_leaves_nothing_to_split() -> None:
    result = small([], [Robot("R1", (5, 5), (5, 5))])
    cut = next(stage for stage in result.stages if isinstance(stage, SplitStage))
    assert tell(cut) == ["There is only one vertex: nothing to split."]


def test_a_goal_in_a_closed_room_is_said_at_once() -> None:
    walls = [Rectangle(6, 6, 3, 0.2), Rectangle(6, 8.8, 3, 0.2), Rectangle(6, 6, 0.2, 3), Rectangle(8.8, 6, 0.2, 3)]
    with pytest.raises(NoPath, match="R1: no way from"):
        small(walls, [Robot("R1", (1, 1), (7.5, 7.5))])


def test_rooms_without_robots_are_left_out_and_said() -> None:
    walls = [Rectangle(6, 6, 3, 0.2), Rectangle(6, 8.8, 3, 0.2), Rectangle(6, 6, 0.2, 3), Rectangle(8.8, 6, 0.2, 3)]
    pillar = Rectangle(7, 7, 0.5, 0.5)
    result = small([*walls, pillar], [Robot("R1", (1, 1), (9.5, 9.5))])
    first = result.stages[0]
    assert isinstance(first, FreeSpaceStage)
    assert first.ground.left_out == 4 + 4
    assert "left out" in tell(first)[1]


def test_two_rooms_with_robots_are_gathered_into_two_sides() -> None:
    wall = Rectangle(4.9, 0, 0.2, 10)
    result = small([wall], [Robot("R1", (1, 1), (3, 9)), Robot("R2", (6, 1), (9, 9))])
    cut = next(stage for stage in result.stages if isinstance(stage, SplitStage))
    assert cut.by == "components"
    assert "several components" in tell(cut)[0]
    assert not any(isinstance(stage, BridgeStage) for stage in result.stages)
    full = result.stages[-2]
    assert isinstance(full, FullGraphStage)
    assert full.connectivity == 0


def test_a_split_by_hand_is_taken_and_wrong_names_are_refused() -> None:
    scene = taut.load_scene("thesis-1")
    result = taut.plan(scene, method="mrppa", split=["O1", "O2", "R1 start", "R2 start", "R3 start"])
    cut = next(stage for stage in result.stages if isinstance(stage, SplitStage))
    assert cut.by == "hand"
    chosen = {name for g in np.unique(cut.ground.groups[cut.side]) for name in cut.ground.members[g]}
    assert chosen == {"O1", "O2", "R1 start", "R2 start", "R3 start"}
    with pytest.raises(SceneError, match="'O9' is not in the scene"):
        taut.plan(scene, method="mrppa", split=["O9"])
    with pytest.raises(SceneError, match="mrppa"):
        taut.plan(scene, split=["O1"])
    for names, said in (([], "nothing is on"), ("O1", r"give a list of names, like \['O1'\]")):
        with pytest.raises(SceneError, match=said):
            taut.plan(scene, method="mrppa", split=names)


def test_weights_other_than_one_change_the_choice_and_bad_ones_are_refused() -> None:
    scene = taut.load_scene("thesis-1")
    far = taut.plan(scene, method="mrppa", weight="distance")
    first = next(stage for stage in far.stages if isinstance(stage, BridgeStage))
    assert first.ground.weights[first.edge] == first.ground.roadmap.lengths[first.edge]
    assert first.ground.roadmap.lengths[first.edge] > 10
    with pytest.raises(SceneError, match="'heavy' is not one of"):
        taut.plan(scene, method="mrppa", weight="heavy")
    with pytest.raises(ValueError, match="positive weight"):
        taut.plan(scene, method="mrppa", weight=lambda d: d * 0)
    with pytest.raises(SceneError, match="mrppa"):
        taut.plan(scene, weight="one")


def test_nobody_passes_through_the_start_of_another_where_free_space_merely_touches_itself() -> None:
    rooms = [Rectangle(0, 2, 2, 2), Rectangle(2, 0, 2, 2)]
    robots = [Robot("A", (2, 2), (1, 1)), Robot("B", (0.5, 1), (1, 0.5)), Robot("C", (3, 3), (3.5, 3.5))]
    ground = ground_of(Scene((0, 0, 4, 4), rooms, robots, gap=0.1), 0.0, WEIGHTS["one"])
    everything = np.ones(len(ground.roadmap.edges), dtype=np.bool_)
    start = {name: int(ends[0]) for name, ends in zip(ground.robots, ground.ends, strict=True)}
    reached = {name: dijkstra(ground.distances(everything, name), start[name])[0][start["C"]] for name in "AB"}
    assert reached == {"A": pytest.approx(2**0.5), "B": np.inf}
