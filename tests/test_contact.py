"""Contacts are exact in time, the graphs between them are the right ones, and bounds on λ2 and range hold."""

from __future__ import annotations

import math
from collections.abc import Sequence
from functools import partial
from typing import Any

import networkx as nx
import numpy as np
import pytest
import shapely
from hypothesis import given, settings
from hypothesis import strategies as st
from numpy.typing import NDArray

import naive_contact as naive
from taut.contact import (
    Contact,
    bridges_at,
    components_at,
    contact_of,
    contacts,
    cut_vertices_at,
    fading_fiedler,
    graph_at,
    longest_loss,
    longest_silences,
    losses,
    needed_reach,
    piece_at,
    sight_sides,
)
from taut.contact.connectivity import (
    connected,
    failing_pieces,
    fiedler_at,
    fiedler_at_least,
    k_connected,
    least_fiedler,
)
from taut.errors import SceneError
from taut.graph import fading
from taut.motion import Plan, Trajectory
from taut.scene import AtGoal, Circle, Line, Obstacle, Polygon, Rectangle, Robot, Scene

seeds = st.integers(0, 2**32 - 1)


def plan_of(
    stamps: Sequence[Any],
    obstacles: list[Obstacle] | None = None,
    size: float = 10.0,
    at_goal: list[AtGoal] | None = None,
) -> Plan:
    """A plan of point robots in a square workspace round the origin."""
    tracks = [np.asarray(path, dtype=float) for path in stamps]
    leaving: list[AtGoal] = at_goal or ["stay"] * len(tracks)
    robots = [
        Robot(f"R{k}", path[0, 1:], path[-1, 1:], at_goal=leaving[k])  # type: ignore[arg-type]
        for k, path in enumerate(tracks)
    ]
    scene = Scene((-size, -size, size, size), obstacles or [], robots)
    return Plan(scene, tuple(Trajectory(f"R{k}", path) for k, path in enumerate(tracks)))


def random_plan(seed: int, robots: int, legs: int, size: float = 10.0, obstacles: int = 0, leave: bool = False) -> Plan:
    """Random motions with rests in a square of side 2 · size, small obstacles among them."""
    rng = np.random.default_rng(seed)
    stamps = []
    for _ in range(robots):
        points = rng.uniform(-1, 1, (legs + 1, 2)) * size
        rests = np.flatnonzero(rng.random(legs) < 0.2)
        points[rests + 1] = points[rests]
        stamps.append(np.column_stack([np.r_[0, np.cumsum(rng.uniform(0.3, 3, legs))], points]))
    solid: list[Obstacle] = []
    for _ in range(obstacles):
        x, y, width, height = (rng.uniform((-0.9, -0.9, 0.02, 0.02), (0.8, 0.8, 0.15, 0.15)) * size).tolist()
        solid.append(Rectangle(x, y, width, height, rng.uniform(0, 3)))
    at_goal: list[AtGoal] = ["leave" if leave and rng.random() < 0.5 else "stay" for _ in range(robots)]
    return plan_of(stamps, solid, size, at_goal)


def steady(seed: int, robots: int, scale: float, centre: float) -> Plan:
    """One leg a robot, all of the kinds that are awkward in pairs: parallel, resting, meeting, of the same velocity."""
    rng = np.random.default_rng(seed)
    start = rng.uniform(-1, 1, (robots, 2))
    velocity = rng.uniform(-1, 1, (robots, 2))
    velocity[: robots // 4] = rng.choice(np.array([[0, 0], [1, 0], [0, 1], [-1, 0], [0.5, 0.5]]), robots // 4)
    start[: robots // 8] = np.round(start[: robots // 8] * 4) / 4
    time = rng.uniform(0.5, 2, robots)
    time[::5] = 1.0
    ends = start + velocity * time[:, None]
    return plan_of(
        [np.column_stack([[0, time[k]], np.stack([start[k], ends[k]]) * scale + centre]) for k in range(robots)],
        size=4 * scale + abs(centre),
    )


def all_pairs(n: int) -> NDArray[np.int64]:
    return np.stack(np.triu_indices(n, 1), axis=1)


# ---------------------------------------------------------------------------------------------- instants


@pytest.mark.parametrize(("scale", "centre"), [(1.0, 0.0), (1e-9, 0.0), (1e6, 0.0), (1.0, 1e6)])
def test_range_instants_agree_with_bisection(scale: float, centre: float) -> None:
    plan = steady(1, 202, scale, centre)
    reach = 0.5 * scale
    limit = reach + plan.scene.tol
    found = contacts(plan, reach)
    pairs = all_pairs(202)
    assert len(pairs) > 20_000
    exact, nearest, who = naive.range_crossings(plan, pairs, limit)
    # at a tangency the instant itself is ill-conditioned
    clear = nearest < limit * (1 - 1e-4)
    assert clear.mean() > 0.99
    number = np.zeros((202, 202), dtype=np.int64)
    number[tuple(pairs.T)] = np.arange(len(pairs))
    inner = np.concatenate([found.begins[found.begins > 0], found.ends[np.isfinite(found.ends)]])
    owner = number[tuple(np.concatenate([found.pairs[found.begins > 0], found.pairs[np.isfinite(found.ends)]]).T)]
    graze = np.isin(owner, who[~clear]) | np.isin(owner, np.setdiff1d(owner, who))
    assert graze.mean() < 0.02
    mine, own = inner[~graze], owner[~graze]
    theirs, whose = exact[~np.isin(who, owner[graze])], who[~np.isin(who, owner[graze])]
    mine, theirs = mine[np.lexsort((mine, own))], theirs[np.lexsort((theirs, whose))]
    assert len(mine) == len(theirs) > 5_000
    assert np.abs(mine - theirs).max() < 1e-9


@pytest.mark.parametrize(("scale", "centre", "count"), [(1.0, 0.0, 20_000), (1e6, 0.0, 2_000), (1.0, 1e5, 2_000)])
def test_sight_instants_agree_with_bisection(scale: float, centre: float, count: int) -> None:
    rng = np.random.default_rng(3)
    motions = steady(2, 230, scale, centre)
    solid: list[Obstacle] = [
        Rectangle(x, y, 0.1 * scale, 0.3 * scale, rng.uniform(0, 3))
        for x, y in (rng.uniform(-1, 1, (6, 2)) * scale + centre).tolist()
    ]
    solid.append(Polygon(rng.uniform(-1, 1, (3, 2)) * scale + centre))
    scene = Scene(motions.scene.workspace, solid, motions.scene.robots)
    plan = Plan(scene, motions.trajectories)
    found = contacts(plan, 100 * scale + abs(centre), sight=True)  # everybody is within reach: only sight changes
    ends = np.concatenate([found.begins[found.begins > 0], found.ends[np.isfinite(found.ends)]])
    pairs = np.concatenate([found.pairs[found.begins > 0], found.pairs[np.isfinite(found.ends)]])
    order = np.lexsort((ends, pairs[:, 1], pairs[:, 0]))
    ends, pairs = ends[order], pairs[order]
    # alone within a window on either side, or bisection may find the other
    same = (np.diff(pairs, axis=0) == 0).all(axis=1)
    gap = np.where(same, np.diff(ends), np.inf)
    room = np.minimum(np.r_[np.inf, gap], np.r_[gap, np.inf]) > 2e-5
    assert room.mean() > 0.98
    ends, pairs = ends[room][:count], pairs[room][:count]
    assert len(ends) == count
    changed, exact = naive.flips(plan, pairs, np.maximum(ends - 1e-5, 0.0), ends + 1e-5)
    assert changed.mean() > 0.999  # the others graze a corner for less than 1e-5 s, or begin with the plan
    assert np.abs(ends - exact)[changed].max() < 1e-9


@pytest.mark.parametrize("seed", range(4))
def test_sight_agrees_with_shapely_at_random_times(seed: int) -> None:
    rng = np.random.default_rng(seed)
    plan = random_plan(seed, 10, 6, obstacles=12)
    reach = 9.0
    found = contacts(plan, reach, sight=True)
    walls = shapely.linestrings(sight_sides(plan.scene, plan.scene.tol).reshape(-1, 2, 2))
    tree = shapely.STRtree(walls)
    pairs = all_pairs(10)
    for time in rng.uniform(0, found.until * 1.1, 300):
        place = plan.at(time)
        near = np.hypot(*(place[pairs[:, 0]] - place[pairs[:, 1]]).T) <= reach
        lines = shapely.linestrings(np.stack([place[pairs[:, 0]], place[pairs[:, 1]]], axis=1))
        near[tree.query(lines, predicate="intersects")[0]] = False
        assert graph_at(found, piece_at(found, time)).edges.tolist() == pairs[near].tolist()


@settings(deadline=None, max_examples=40)
@given(seeds, st.booleans())
def test_a_plan_run_backwards_has_the_same_contacts_backwards(seed: int, sight: bool) -> None:
    plan = random_plan(seed, 6, 4, obstacles=4)
    end = max(path.times[-1] for path in plan.trajectories)
    tracks = []
    for path in plan.trajectories:
        stamps = path.stamps if path.times[-1] == end else np.vstack([path.stamps, [end, *path.points[-1]]])
        tracks.append(np.column_stack([end - stamps[::-1, 0], stamps[::-1, 1:]]))
    back = plan_of(tracks, list(plan.scene.obstacles))
    one, two = contacts(plan, 8.0, sight), contacts(back, 8.0, sight)
    mirrored = sorted(
        (i, j, max(end - e, 0.0), np.inf if b == 0 else end - b)
        for (i, j), b, e in zip(one.pairs.tolist(), one.begins, one.ends, strict=True)
        if b < end
    )
    found = sorted((i, j, b, e) for (i, j), b, e in zip(two.pairs.tolist(), two.begins, two.ends, strict=True))
    assert [row[:2] for row in mirrored] == [row[:2] for row in found]
    assert np.allclose(np.array(mirrored)[:, 2:], np.array(found)[:, 2:], rtol=0, atol=1e-8) if found else True


def test_contact_holds_at_exactly_the_range_and_the_tolerance_beyond() -> None:
    def pair(apart: float) -> Plan:
        return plan_of([[[0, 0, 0], [8, 8, 0]], [[0, 0, apart], [8, 8, apart]]])

    tol = pair(1.0).scene.tol
    for apart in (1.0, 1.0 + tol / 2):
        found = contacts(pair(apart), 1.0)
        assert found.begins.tolist() == [0.0]
        assert found.ends.tolist() == [np.inf]
    assert not len(contacts(pair(1.0 + 2 * tol), 1.0).pairs)


def test_a_visit_of_the_shortest_kind_is_found() -> None:
    # past each other at 2 m/s, 1 mm deep in range in the middle of a long leg
    plan = plan_of([[[0, -8, 0], [8, 8, 0]], [[0, 0, 0.999], [1, 0, 0.999]]])
    found = contacts(plan, 1.0)
    half = np.sqrt((1.0 + plan.scene.tol) ** 2 - 0.999**2) / 2
    assert found.begins == pytest.approx([4 - half], abs=1e-12)
    assert found.ends == pytest.approx([4 + half], abs=1e-12)


def test_sight_slides_along_walls_and_grazes_corners() -> None:
    box = Rectangle(-1, -1, 2, 2)
    along = plan_of([[[0, -3, 1]], [[0, -3, 1], [6, 3, 1]]], [box])
    assert contacts(along, 20.0, sight=True).ends.tolist() == [np.inf]
    corner = plan_of([[[0, -3, -1]], [[0, 1, 3]]], [box])
    assert len(contacts(corner, 20.0, sight=True).pairs) == 1
    deeper = plan_of([[[0, -3, 1 - 1e-9]], [[0, 3, 1 - 1e-9]]], [box])
    assert not len(contacts(deeper, 20.0, sight=True).pairs)


def test_sight_passes_where_two_corners_touch_but_not_a_seam() -> None:
    touching: list[Obstacle] = [Rectangle(-2, -2, 2, 2), Rectangle(0, 0, 2, 2)]
    seam: list[Obstacle] = [Rectangle(-2, -1, 2, 2), Rectangle(0, -1, 2, 2)]
    assert len(contacts(plan_of([[[0, -3, 3]], [[0, 3, -3]]], touching), 20.0, sight=True).pairs) == 1
    assert not len(contacts(plan_of([[[0, 0, 1]], [[0, 0, -1]]], seam), 20.0, sight=True).pairs)


def test_a_wall_thinner_than_the_tolerance_hides() -> None:
    wall = Line([(-4, 0), (4, 0)], 1e-300)
    assert not len(contacts(plan_of([[[0, 0, 1]], [[0, 1, -1]]], [wall]), 20.0, sight=True).pairs)
    assert len(contacts(plan_of([[[0, 5, 1]], [[0, 5, -1]]], [wall]), 20.0, sight=True).pairs) == 1


def test_absurd_numbers_do_no_harm() -> None:
    far = plan_of([[[0, 0, 0], [1, 1e300, 0], [2, 0, 0]], [[0, 0, 1]], [[0, 1, 1], [1e-300, 1, 2], [1e300, 2, 2]]])
    assert contacts(far, 1e-300).begins.size == 0
    everybody = contacts(far, 1e308)
    assert everybody.pairs.tolist() == [[0, 1], [0, 2], [1, 2]]
    assert np.isinf(everybody.ends).all()
    tiny = plan_of([[[0, 1e-200, 0]], [[0, 0, 1e-200]]], size=2e-200)
    assert len(contacts(tiny, 1.5e-200).pairs) == 1
    assert not len(contacts(tiny, 1e-200).pairs)


@pytest.mark.parametrize("robots", [0, 1])
def test_teams_without_pairs_have_no_contacts(robots: int) -> None:
    found = contacts(plan_of([[[0, 0, 0], [1, 1, 0]]][:robots]), 1.0, sight=True)
    assert found.times.tolist() == [0.0]
    assert found.fiedler.tolist() == [0.0]
    assert found.worst == (0.0, 0.0)
    assert longest_loss(found) is None
    assert longest_silences(found).tolist() == [np.inf] * robots
    assert least_fiedler(found) == (0, 0.0)


@pytest.mark.parametrize(
    ("reach", "words"),
    [(0.0, "positive"), (-1.0, "positive"), (math.nan, "a finite number"), ("5", "a finite number, got '5'")],
)
def test_a_range_must_be_a_positive_number(reach: Any, words: str) -> None:
    with pytest.raises(SceneError, match=f"range must be {words}"):
        contacts(plan_of([[[0, 0, 0]]]), reach)


# ---------------------------------------------------------------------------------------------- what hides


def test_corners_move_into_the_obstacle_by_the_depth() -> None:
    sides = sight_sides(Scene((0, 0, 9, 9), [Polygon([(3, 3), (6, 3), (6, 6), (5, 6), (5, 4), (3, 4)])]), 0.25)
    corners = {tuple(corner) for corner in sides[:, :2].tolist()}
    assert corners >= {(3.25, 3.25), (5.75, 3.25), (5.75, 5.75), (5.25, 5.75), (5.25, 3.75), (3.25, 3.75)}
    assert corners >= {(-0.25, -0.25), (9.25, 9.25)}


def test_needles_move_by_eight_depths_at_most() -> None:
    needle = Polygon([(3, 5), (6, 5 - 1e-6), (6, 5 + 1e-6)])
    sides = sight_sides(Scene((0, 0, 9, 9), [needle]), 1e-9)
    tip = sides[np.argmin(np.abs(sides[:, :2] - [3, 5]).sum(axis=1)), :2]
    assert tip - [3, 5] == pytest.approx([8e-9, 0], abs=1e-12)


@settings(deadline=None, max_examples=30)
@given(seeds)
def test_round_obstacles_hide_a_thousandth_more_at_most(seed: int) -> None:
    rng = np.random.default_rng(seed)
    x, y, radius = rng.uniform((-4, -4, 0.1), (4, 4, 3)).tolist()
    centre = np.array([x, y])
    scene = Scene((-9, -9, 9, 9), [Circle((x, y), radius)])
    sides = sight_sides(scene, scene.tol)
    ring = sides[np.hypot(*(sides[:, :2] - centre).T) < 4]
    outside = shapely.distance(shapely.points(centre), shapely.linestrings(ring.reshape(-1, 2, 2)))
    assert outside.min() >= radius - 2 * scene.tol
    assert np.hypot(*(ring[:, :2] - centre).T).max() <= 1.001 * radius


# ---------------------------------------------------------------------------------------------- graphs over time


@pytest.mark.parametrize(
    ("seed", "sight", "leave"), [(0, False, False), (1, True, False), (2, False, True), (3, True, True)]
)
def test_graphs_agree_with_networkx_at_any_time(seed: int, sight: bool, leave: bool) -> None:
    plan = random_plan(seed, 9, 5, obstacles=8 if sight else 0, leave=leave)
    reach = 11.0
    found = contacts(plan, reach, sight)
    rng = np.random.default_rng(seed)
    for time in rng.uniform(0, found.until * 1.05, 150).tolist():
        piece = piece_at(found, time)
        graph = naive.graph_at(plan, time, reach, sight)
        assert graph_at(found, piece).edges.tolist() == sorted(sorted(edge) for edge in graph.edges)
        assert np.flatnonzero(found.present[piece]).tolist() == sorted(graph)
        assert found.fiedler[piece] == pytest.approx(naive.fiedler(graph), abs=1e-12 * 18)
        assert fiedler_at(found, piece) == pytest.approx(naive.fiedler(graph), abs=1e-12 * 18)
        assert (found.fiedler[piece] > 0) == (len(graph) > 1 and nx.is_connected(graph))
        assert cut_vertices_at(found, piece).tolist() == sorted(nx.articulation_points(graph))
        assert bridges_at(found, piece).tolist() == sorted(sorted(edge) for edge in nx.bridges(graph))
        labels = components_at(found, piece)
        parts = [set(np.flatnonzero(labels == k).tolist()) for k in range(labels.max(initial=-1) + 1)]
        assert parts == sorted(nx.connected_components(graph), key=min)
    value = found.fiedler[found.present.sum(axis=1) > 1].min()
    assert found.worst[1] == value
    assert least_fiedler(found)[1] == pytest.approx(value, abs=1e-12 * 18)
    assert naive.fiedler(naive.graph_at(plan, found.worst[0], reach, sight)) == pytest.approx(value, abs=1e-11)


@settings(deadline=None, max_examples=20)
@given(seeds, st.booleans(), st.integers(1, 4))
def test_failing_pieces_are_those_that_fail_one_by_one(seed: int, leave: bool, k: int) -> None:
    plan = random_plan(seed, 7, 4, leave=leave)
    found = contacts(plan, 12.0)
    for holds in (connected, partial(k_connected, k=k), partial(fiedler_at_least, least=0.71 * k)):
        one_by_one = []
        for piece, there in enumerate(found.present):
            number = np.cumsum(there) - 1
            if not holds(int(there.sum()), number[graph_at(found, piece).edges]):
                one_by_one.append(piece)
        assert failing_pieces(found, holds).tolist() == one_by_one


@settings(deadline=None, max_examples=200)
@given(seeds)
def test_k_connected_agrees_with_networkx(seed: int) -> None:
    rng = np.random.default_rng(seed)
    n, k = int(rng.integers(1, 12)), int(rng.integers(1, 6))
    pairs = all_pairs(n)
    pairs = pairs[rng.random(len(pairs)) < rng.random()]
    graph = nx.Graph()
    graph.add_nodes_from(range(n))
    graph.add_edges_from(pairs.tolist())
    expected = nx.density(graph) == 1 or n == 1 if n <= k + 1 else nx.node_connectivity(graph) >= k
    assert k_connected(n, pairs, k) == expected
    assert k_connected(n, np.concatenate([pairs, pairs[:, ::-1]]), k) == expected


def test_losses_and_silences_of_a_robot_that_comes_and_goes() -> None:
    still = [[0, 0, 0]]
    away = [[0, 1, 0], [4, 5, 0], [8, 1, 0], [12, 5, 0], [14, 5, 0]]
    found = contacts(plan_of([still, [[0, 0, 1]], away]), 3.0)
    assert losses(found) == pytest.approx(np.array([[2.0, 6.0], [10.0, np.inf]]), abs=0.2)
    assert longest_loss(found) == pytest.approx((10.0, np.inf), abs=0.2)
    finite = contacts(plan_of([still, [[0, 0, 1]], away[:3]]), 3.0)
    begin, end = losses(finite)[0]
    assert longest_loss(finite) == (begin, end)
    assert longest_silences(finite) == pytest.approx([0, 0, end - begin])
    assert longest_silences(found)[2] == np.inf


def test_robots_that_leave_are_missed_no_more() -> None:
    plan = plan_of([[[0, 0, 0]], [[0, 1, 0], [2, 1.5, 0]], [[0, 2, 0], [5, 9, 0]]], at_goal=["stay", "leave", "leave"])
    found = contacts(plan, 1.0 + 1e-6)
    assert found.gone.tolist() == [np.inf, 2.0, 5.0]
    assert found.present.sum(axis=1).tolist()[-1] == 1
    assert longest_loss(found) == pytest.approx((0.0, 5.0), abs=1e-5)
    assert components_at(found, len(found.times) - 1).tolist() == [0, -1, -1]


def test_pieces_and_times_out_of_range_are_refused() -> None:
    found = contacts(plan_of([[[0, 0, 0]], [[0, 1, 0]]]), 2.0)
    with pytest.raises(IndexError, match="the pieces are 0 … 0"):
        graph_at(found, 1)
    with pytest.raises(ValueError, match="begins at 0 s"):
        piece_at(found, -1.0)


# ---------------------------------------------------------------------------------------------- range, fading weights


@settings(deadline=None, max_examples=25)
@given(seeds, st.booleans())
def test_the_needed_range_is_needed_and_suffices(seed: int, sight: bool) -> None:
    plan = random_plan(seed, 7, 4, obstacles=2 if sight else 0, leave=seed % 3 == 0)
    generous = contacts(plan, 30.0, sight)
    needed = needed_reach(plan, generous)
    if needed is None:
        assert longest_loss(generous) is not None
        return
    assert needed.upper - needed.lower <= 1e-6 * 30.0
    assert longest_loss(contacts(plan, needed.upper, sight)) is None
    below = contacts(plan, needed.lower * (1 - 1e-9), sight)
    begin, end = min(losses(below).tolist(), key=lambda loss: max(loss[0] - needed.time, needed.time - loss[1]))
    assert begin - 1e-6 <= needed.time <= end + 1e-6


@settings(deadline=None, max_examples=15)
@given(seeds, st.booleans())
def test_bounds_of_fading_weights_hold_at_sampled_times(seed: int, leave: bool) -> None:
    plan = random_plan(seed, 6, 3, leave=leave)
    reach, width = 14.0, 0.02
    found = fading_fiedler(plan, reach, fading(lambda d: (1 - d / 14.0) ** 2, reach), width=width)
    assert (found.upper - found.lower <= width * np.maximum(1, found.upper)).all()
    assert (found.lower <= found.values + 1e-12).all()
    assert (found.values <= found.upper + 1e-12).all()
    rng = np.random.default_rng(seed)
    for time in rng.uniform(0, plan.makespan * 1.1, 60).tolist():
        graph = naive.graph_at(plan, time, reach)
        place = plan.at(time)
        for i, j in graph.edges:
            graph.edges[i, j]["w"] = (1 - min(np.hypot(*(place[i] - place[j])) / 14.0, 1.0)) ** 2
        piece = int(np.searchsorted(found.times, time, side="right")) - 1
        exact = naive.fiedler(graph, "w")
        assert found.lower[piece] - 1e-11 <= exact <= found.upper[piece] + 1e-11
    lower, upper, time = found.worst
    assert lower == found.lower.min()
    assert lower <= upper + 1e-12
    assert time in found.times


def test_fading_weights_of_ones_are_the_plain_links() -> None:
    plan = random_plan(5, 8, 4)
    plain = contacts(plan, 9.0)
    found = fading_fiedler(plan, 9.0, np.ones_like)
    assert np.array_equal(found.lower, found.upper)
    own = plain.fiedler[np.searchsorted(plain.times, found.times, side="right") - 1]
    assert found.values == pytest.approx(own, abs=1e-11)


def test_weights_that_jump_end_in_short_pieces() -> None:
    plan = plan_of([[[0, 0, 0]], [[0, 0, 0], [4, 4, 0]]])
    found = fading_fiedler(plan, 5.0, lambda d: np.where(d < 1.7, 1.0, 0.5))
    jump = int(np.argmax(found.upper - found.lower))
    assert found.times[jump] <= 1.7 <= found.times[jump + 1]
    assert found.times[jump + 1] - found.times[jump] < 1e-10
    assert len(found.times) < 100


def test_weights_that_grow_or_make_no_sense_are_refused() -> None:
    plan = plan_of([[[0, 0, 0]], [[0, 0, 0], [4, 4, 0]]])
    with pytest.raises(ValueError, match="not increase"):
        fading_fiedler(plan, 5.0, lambda d: d)
    with pytest.raises(ValueError, match="finite and not negative"):
        fading_fiedler(plan, 5.0, lambda d: -d)
    with pytest.raises(SceneError, match="width must be positive"):
        fading_fiedler(plan, 5.0, np.ones_like, width=0.0)


# ---------------------------------------------------------------------------------------------- demands


@pytest.mark.parametrize(
    ("claim", "word"),
    [
        ({}, "range is missing"),
        ({"range": 0}, "positive"),
        ({"range": True}, "number"),
        ({"range": "3"}, "number"),
        ({"range": 1, "k": 0}, "at least 1"),
        ({"range": 1, "k": 1.5}, "whole number"),
        ({"range": 1, "sight": 1}, "true or false"),
        ({"range": 1, "lambda2": -1}, "at least 0"),
        ({"range": 1, "lambda2": float("inf")}, "number"),
        ({"range": 1, "width": 1}, "unknown 'width'"),
    ],
)
def test_demands_that_make_no_sense_are_refused(claim: dict[str, object], word: str) -> None:
    with pytest.raises(SceneError, match=word):
        contact_of(claim)


def test_a_demand_survives_as_a_claim() -> None:
    demand = Contact(3, sight=True, k=2, lambda2=0.5)
    assert contact_of(demand.claim) == demand
    assert contact_of({"range": 3}) == Contact(3.0)
    assert all(isinstance(value, float) for value in (demand.reach, demand.lambda2))
