"""Teams under control laws end where theory says, and trajectories stay as near the solutions as promised."""

from __future__ import annotations

from collections.abc import Callable
from itertools import combinations

import numpy as np
import pytest
import shapely
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.integrate import solve_ivp
from scipy.linalg import expm

from taut.control import (
    consensus,
    distance_formation,
    following,
    formation,
    integrate,
    leader_follower,
    rendezvous,
)
from taut.control.curves import SHARES, legs
from taut.errors import TautError
from taut.graph.core import Floats, Graph
from taut.motion import Trajectory

RANDOM = np.random.default_rng(7)
SQUARE = np.array([(0, 0), (1, 0), (1, 1), (0, 1)], dtype=np.float64)
DIAMOND = Graph.from_edges(4, [(0, 1), (0, 2), (0, 3), (1, 2), (2, 3)])


def path(n: int) -> Graph:
    return Graph.from_edges(n, [(i, i + 1) for i in range(n - 1)])


def laplacian(graph: Graph) -> Floats:
    out = np.zeros((graph.n, graph.n))
    for (i, j), weight in zip(graph.edges.tolist(), graph.lengths.tolist(), strict=True):
        out[i, i] += weight
        out[j, j] += weight
        out[i, j] -= weight
        out[j, i] -= weight
    return out


def ends(trajectories: tuple[Trajectory, ...]) -> Floats:
    return np.array([trajectory.points[-1] for trajectory in trajectories])


def at(trajectories: tuple[Trajectory, ...], time: float) -> Floats:
    return np.array([trajectory.at(time) for trajectory in trajectories])


def within(reach: float) -> Callable[[Floats], Graph]:
    """Return the links of all pairs within reach, as a function of the positions."""

    def links(positions: Floats) -> Graph:
        near = [(i, j) for i, j in combinations(range(len(positions)), 2) if distance(positions, i, j) <= reach]
        return Graph.from_edges(len(positions), near)

    return links


def distance(positions: Floats, i: int, j: int) -> float:
    return float(np.hypot(*(positions[i] - positions[j])))


def lengths(graph: Graph, positions: Floats) -> Floats:
    return np.array([distance(positions, i, j) for i, j in graph.edges.tolist()])


@st.composite
def teams(draw: st.DrawFn, most: int = 6) -> tuple[Graph, Floats]:
    """Draw a connected weighted graph and places."""
    n = draw(st.integers(2, most))
    tree = {(draw(st.integers(0, v - 1)), v) for v in range(1, n)}
    more = draw(st.lists(st.sampled_from(list(combinations(range(n), 2))), max_size=n))
    edges = sorted(tree | set(more))
    weights = draw(st.lists(st.floats(0.25, 4), min_size=len(edges), max_size=len(edges)))
    coordinates = st.floats(-10, 10)
    places = draw(st.lists(st.tuples(coordinates, coordinates), min_size=n, max_size=n))
    return Graph.from_edges(n, edges, weights), np.array(places)


@settings(deadline=None, max_examples=25)
@given(teams())
def test_consensus_is_the_matrix_exponential_at_every_instant(team: tuple[Graph, Floats]) -> None:
    graph, start = team
    trajectories = integrate(consensus(graph), start, 2.0, error=1e-4)
    for time in np.linspace(0, 2, 41):
        solution = expm(-laplacian(graph) * time) @ start
        assert np.hypot(*(at(trajectories, time) - solution).T).max() <= 1.05e-4


@settings(deadline=None, max_examples=25)
@given(teams())
def test_consensus_nears_the_centroid_as_fast_as_lambda2(team: tuple[Graph, Floats]) -> None:
    graph, start = team
    centroid = start.mean(axis=0)
    rate = np.linalg.eigvalsh(laplacian(graph))[1]
    trajectories = integrate(consensus(graph), start, 5.0, error=1e-5)
    for time in (0.5, 1.0, 2.5, 5.0):
        spread = np.linalg.norm(at(trajectories, time) - centroid)
        assert spread <= np.linalg.norm(start - centroid) * np.exp(-rate * time) + 1e-4


def test_each_connected_part_gathers_at_its_own_centroid() -> None:
    start = RANDOM.uniform(0, 10, (5, 2))
    graph = Graph.from_edges(5, [(0, 1), (1, 2), (3, 4), (2, 3)], [1, 2, 1, 0])  # an edge of weight 0 joins nothing
    reached = ends(integrate(consensus(graph), start, 40.0, error=1e-6))
    assert np.allclose(reached[:3], start[:3].mean(axis=0), atol=1e-6)
    assert np.allclose(reached[3:], start[3:].mean(axis=0), atol=1e-6)


def test_leaders_at_rest_gather_their_followers_in_their_hull() -> None:
    start = RANDOM.uniform(-20, 20, (8, 2))
    start[:3] = [(0, 0), (4, 0), (0, 3)]
    graph = Graph.from_edges(8, [(0, 3), (3, 4), (4, 1), (4, 5), (5, 6), (6, 2), (6, 7)])
    law = leader_follower(graph, {leader: lambda t: (0, 0) for leader in range(3)})
    reached = ends(integrate(law, start, 200.0, error=1e-6))
    assert (reached[:3] == start[:3]).all()
    hull = shapely.MultiPoint(start[:3]).convex_hull
    assert all(hull.distance(shapely.Point(place)) < 1e-5 for place in reached[3:])
    full = laplacian(graph)
    assert np.allclose(reached[3:], np.linalg.solve(full[3:, 3:], -full[3:, :3] @ start[:3]), atol=1e-5)


def test_one_leader_draws_all_to_its_place() -> None:
    start = RANDOM.uniform(-5, 5, (4, 2))
    reached = ends(integrate(leader_follower(path(4), {1: lambda t: (0, 0)}), start, 80.0, error=1e-6))
    assert np.allclose(reached, start[1], atol=1e-5)


def test_a_leader_that_follows_a_trajectory_keeps_to_it() -> None:
    planned = Trajectory("L", np.array([(0, 0, 0), (50, 0, 0), (51, 3, 4), (80, 3, 4), (80.5, 1, 4)]))
    law = leader_follower(path(3), {0: following(planned)})
    led = integrate(law, [(0, 0), (0, 0), (0, 0)], 200.0, ["L", "A", "B"], jumps=planned.times)
    for time in (0.0, 30.0, 50.0, 50.3, 51.0, 70.0, 80.0, 80.2, 80.5, 200.0):
        assert np.allclose(led[0].at(time), planned.at(time), atol=1e-9)
    assert np.allclose(ends(led), [1, 4], atol=1e-3)
    assert np.ptp(led[1].points[led[1].times <= 50.0]) == 0


def test_formation_reaches_the_offsets_about_the_centroid() -> None:
    start, offsets = RANDOM.uniform(-5, 5, (2, 6, 2))
    reached = ends(integrate(formation(path(6), offsets), start, 120.0, error=1e-6))
    assert np.allclose(reached - start.mean(axis=0), offsets - offsets.mean(axis=0), atol=1e-5)


@pytest.mark.parametrize("size", [0.01, 1.0, 100.0])
def test_distance_formation_reaches_the_lengths_from_near(size: float) -> None:
    wanted = lengths(DIAMOND, SQUARE * size)
    start = (SQUARE + RANDOM.uniform(-0.15, 0.15, (4, 2))) * size
    reached = ends(integrate(distance_formation(DIAMOND, wanted), start, 40.0 / size**2, error=1e-6 * size))
    assert np.allclose(lengths(DIAMOND, reached), wanted, atol=1e-5 * size)
    assert np.allclose(reached.mean(axis=0), start.mean(axis=0), atol=1e-5 * size)
    assert distance(reached, 1, 3) == pytest.approx(2**0.5 * size, abs=1e-4 * size)  # rigid: no edge, yet determined


def test_distance_formation_without_rigidity_takes_another_shape() -> None:
    ring = Graph.from_edges(4, [(0, 1), (1, 2), (2, 3), (0, 3)])
    start = np.array([(0, 0), (1.2, 0), (1.7, 0.9), (0.5, 0.8)])
    reached = ends(integrate(distance_formation(ring, np.ones(4)), start, 40.0, error=1e-6))
    assert np.allclose(lengths(ring, reached), 1, atol=1e-5)
    assert abs(distance(reached, 0, 2) - 2**0.5) > 0.1


@settings(deadline=None, max_examples=25)
@given(teams(), st.floats(0.02, 0.98))
def test_distance_formation_runs_down_its_potential(team: tuple[Graph, Floats], share: float) -> None:
    graph, positions = team
    wanted = share * lengths(graph, positions)

    def potential(places: Floats) -> float:
        return float((graph.lengths * (lengths(graph, places) ** 2 - wanted**2) ** 2).sum() / 4)

    velocities = distance_formation(graph, wanted)(0.0, positions)
    for k in range(positions.size):
        shift = np.zeros(positions.size)
        shift[k] = 1e-5
        aside = shift.reshape(-1, 2)
        slope = (potential(positions + aside) - potential(positions - aside)) / 2e-5
        assert slope == pytest.approx(-velocities.ravel()[k], rel=1e-5, abs=1e-3)


@settings(deadline=None, max_examples=25)
@given(teams(), st.sampled_from([1e-6, 1e-3, 0.1, 1.0]))
def test_rendezvous_keeps_every_link_and_gathers(team: tuple[Graph, Floats], room: float) -> None:
    graph, start = team
    longest = lengths(graph, start).max()
    reach = longest * (1 + room) + 1e-3
    trajectories = integrate(rendezvous(graph, reach), start, 60.0 * reach, error=1e-5)
    for time in np.unique(np.concatenate([t.times for t in trajectories])):
        assert lengths(graph, at(trajectories, time)).max() <= longest + 3e-5
    assert np.allclose(ends(trajectories), start.mean(axis=0), atol=1e-3)


def test_the_pull_of_a_rendezvous_grows_towards_its_reach() -> None:
    field = rendezvous(Graph.from_edges(2, [(0, 1)], [3.0]), 2.0)
    for length in (0.0, 0.5, 1.0, 1.75):
        pull = 3 * (4 - length) / (2 - length) ** 2 * length
        assert field(0.0, np.array([(0, 0), (0, length)])).tolist() == [[0, pull], [0, -pull]]
    assert np.isnan(field(0.0, np.array([(0, 0), (0, 2.0)]))).all()


def test_rendezvous_starts_from_links_almost_as_long_as_its_reach() -> None:
    """Solvers look beyond the reach then, between their steps, too. The links of a line alone know no such place.

    With room r = 1 − d left in a link it pulls with f = (1 + r) (1 − r) / r², and for z = log r the links of a line
    obey z_k' = −(f_(k−1) − 2 f_k + f_(k+1)) / r_k.
    """
    start = np.stack([np.arange(20) * (1 - 1e-6), np.zeros(20)], axis=1)
    reached = ends(integrate(rendezvous(path(20), 1.0), start, 1e-3))

    def slopes(time: float, logs: Floats) -> Floats:
        room = np.exp(logs)
        pulls = np.concatenate([[0.0], (1 + room) * (1 - room) / room**2, [0.0]])
        rates: Floats = -np.diff(pulls, 2) / room
        return rates

    room = np.exp(solve_ivp(slopes, (0, 1e-3), np.log(1 - np.diff(start[:, 0])), "BDF", rtol=1e-8, atol=1e-10).y[:, -1])
    assert np.allclose(1 - np.diff(reached[:, 0]), room, atol=1e-6)
    assert np.allclose(reached.mean(axis=0), start.mean(axis=0), atol=1e-6)


def test_consensus_within_a_range_may_lose_links_that_rendezvous_keeps() -> None:
    """Four robots at one end pull harder than the one link across."""
    start = np.array([(0, 0), (0.05, 0.9), (0.05, -0.9), (-0.9, 0), (0.99, 0), (1.9, 0.1), (1.9, -0.1)])
    links = within(1.0)
    graph = links(start)
    lost = ends(integrate(consensus(links), start, 30.0))
    assert distance(lost, 0, 4) > 1.0
    kept = ends(integrate(rendezvous(graph, 1.0), start, 30.0))
    assert np.allclose(kept, start.mean(axis=0), atol=1e-2)


def test_velocities_of_a_graph_add_up_to_zero() -> None:
    positions = RANDOM.uniform(0, 1, (4, 2)) + 1e3
    for law in (
        consensus(DIAMOND),
        rendezvous(DIAMOND, 5.0),
        formation(DIAMOND, SQUARE),
        distance_formation(DIAMOND, np.ones(5)),
    ):
        velocities = law(0.0, positions)
        assert np.abs(velocities).max() > 1e-3
        assert np.allclose(velocities.sum(axis=0), 0, atol=1e-12)


@pytest.mark.parametrize("error", [1e-1, 1e-3, 1e-6])
def test_legs_stay_within_the_error_of_a_circle_and_need_few_stamps(error: float) -> None:
    (turning,) = integrate(lambda t, p: p[:, ::-1] * [-1, 1], [(3, 0)], 20.0, error=error)
    times = np.linspace(0, 20, 20_001)
    off = turning.at(times) - 3 * np.stack([np.cos(times), np.sin(times)], axis=1)
    assert np.hypot(*off.T).max() <= 1.1 * error
    fewest = 20 / np.sqrt(8 * error / 3)  # a leg of duration h strays 3 h² / 8 from the circle
    assert len(turning.times) <= 2.5 * fewest + 3


def test_resting_and_straight_motions_have_two_stamps() -> None:
    resting, moving = integrate(lambda t, p: np.array([(0, 0), (1, 2)]), [(5, 0.3), (0, 0)], 9.0)
    assert resting.stamps.tolist() == [[0, 5, 0.3], [9, 5, 0.3]]
    assert resting.arrival == 0
    assert np.allclose(moving.stamps, [[0, 0, 0], [9, 9, 18]], rtol=1e-14)


@settings(deadline=None, max_examples=50)
@given(st.lists(st.floats(-5, 5), min_size=48, max_size=48), st.sampled_from([1e-3, 0.1, 1.0, 100.0]))
def test_legs_stay_within_the_error_of_their_curve(numbers: list[float], error: float) -> None:
    """Three pieces that join, evaluated by de Casteljau's scheme."""
    control = np.array(numbers).reshape(3, 8, 2)
    control[1:, 0] = control[:-1, -1]
    times = np.array([0.0, 0.5, 2.0, 2.25])
    stamps = legs(times, control, error)
    assert stamps[[0, -1], 0].tolist() == [0.0, 2.25]
    trajectory = Trajectory("R1", stamps)
    for begin, end, points in zip(times[:-1], times[1:], control, strict=True):
        for share in np.linspace(0, 1, 50):
            between = points
            while len(between) > 1:
                between = (1 - share) * between[:-1] + share * between[1:]
            assert np.hypot(*(trajectory.at(begin + share * (end - begin)) - between[0])) <= error * (1 + 1e-9)


def test_control_points_on_a_line_at_equal_shares_are_one_leg() -> None:
    line = np.stack([SHARES, 2 * SHARES], axis=1)
    assert legs(np.array([0.0, 1.0, 2.0]), np.stack([line, line + line[-1]]), 1e-9).tolist() == [[0, 0, 0], [2, 2, 4]]


def test_stiff_weights_are_integrated_to_the_end() -> None:
    graph = Graph.from_edges(4, [(0, 1), (1, 2), (2, 3)], [1e5, 1.0, 1e4])
    start = RANDOM.uniform(-5, 5, (4, 2))
    trajectories = integrate(consensus(graph), start, 10.0, error=1e-4)
    for time in (1e-6, 1e-4, 0.1, 1.0, 10.0):
        solution = expm(-laplacian(graph) * time) @ start
        assert np.hypot(*(at(trajectories, time) - solution).T).max() <= 1.1e-4


def test_laws_that_cannot_be_followed_are_told_with_the_time() -> None:
    with pytest.raises(TautError, match=r"beyond t = 0\.5 s.*R1 at"):
        integrate(lambda t, p: p * p, [(2, 0), (0, 0)], 5.0)
    with pytest.raises(TautError, match=r"at t = 0 s .* for b, c:"):
        integrate(rendezvous(path(3), 1.0), [(0, 0), (0.5, 0), (1.5, 0)], 5.0, ["a", "b", "c"])
    with pytest.raises(TautError, match=r"beyond t = 1 s"):
        integrate(lambda t, p: np.full_like(p, 1.0 if t < 1 else np.nan), [(0, 0)], 5.0)
    with pytest.raises(TautError, match=r"at t = 1 s .* for R1"):
        integrate(lambda t, p: np.full_like(p, 1.0 if t < 1 else np.nan), [(0, 0)], 5.0, jumps=[1.0])
    with pytest.raises(TautError, match="give an error above"):
        integrate(lambda t, p: 10 * p, [(1, 0)], 5.0)


def test_nobody_and_no_time_are_fine() -> None:
    assert integrate(consensus(Graph.from_edges(0, [])), np.empty((0, 2)), 5.0) == ()
    (still,) = integrate(consensus(Graph.from_edges(1, [])), [(1, 2)], 0.0, ["solo"])
    assert still == Trajectory("solo", np.array([[0.0, 1.0, 2.0]]))


def test_wrong_input_to_laws_is_refused_in_words() -> None:
    for reach in (0.0, -1.0, np.inf, np.nan):
        with pytest.raises(ValueError, match="reach must be positive"):
            rendezvous(path(2), reach)
    with pytest.raises(IndexError, match="leader 2 is not one of the vertices 0 … 1"):
        leader_follower(path(2), {2: lambda t: (0, 0)})
    with pytest.raises(ValueError, match="leader 0: a velocity is"):
        leader_follower(path(2), {0: lambda t: 1.0})(0.0, np.zeros((2, 2)))
    with pytest.raises(ValueError, match="3 offsets for a graph of 2"):
        formation(path(2), np.zeros((3, 2)))
    with pytest.raises(ValueError, match="finite numbers"):
        formation(path(2), [(0, 0), (np.inf, 0)])
    with pytest.raises(ValueError, match="each of 1 edges"):
        distance_formation(path(2), [1, 2])
    with pytest.raises(ValueError, match="not negative"):
        distance_formation(path(2), [-1])
    with pytest.raises(ValueError, match=r"needs positions \(2, 2\), got \(3, 2\)"):
        consensus(path(2))(0.0, np.zeros((3, 2)))


def test_wrong_input_to_the_integrator_is_refused_in_words() -> None:
    law = consensus(path(2))
    start = [(0, 0), (1, 0)]
    with pytest.raises(ValueError, match="rows of two finite"):
        integrate(law, [(0, 0, 0), (1, 1, 1)], 1.0)
    with pytest.raises(ValueError, match="rows of two finite"):
        integrate(law, [(0, 0), (np.nan, 1)], 1.0)
    for seconds in (-1.0, np.inf, np.nan):
        with pytest.raises(ValueError, match="seconds"):
            integrate(law, start, seconds)
    for error in (0.0, -1.0, np.nan, 1e-13):
        with pytest.raises(ValueError, match="error must be"):
            integrate(law, start, 1.0, error=error)
    with pytest.raises(ValueError, match="1 names for 2 robots"):
        integrate(law, start, 1.0, ["a"])
    with pytest.raises(ValueError, match="twice"):
        integrate(law, start, 1.0, ["a", "a"])
    with pytest.raises(ValueError, match=r"velocities \(2, 2\), got shape \(2,\)"):
        integrate(lambda t, p: np.zeros(2), start, 1.0)
