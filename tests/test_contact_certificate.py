"""The certificate proves contact at every instant: planted losses are found, what only touches is accepted."""

from __future__ import annotations

import json
from dataclasses import replace
from typing import Any

import networkx as nx
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import naive_contact as naive
from taut.certificate import Certificate, Problem, certify
from taut.contact import Contact, contacts
from taut.errors import SceneError
from taut.motion import Plan, Trajectory
from taut.scene import AtGoal, FloatArray, Obstacle, Rectangle, Robot, Scene

seeds = st.integers(0, 2**32 - 1)


def plan_of(
    stamps: list[FloatArray], size: float, obstacles: list[Obstacle] | None = None, leave: bool = False
) -> Plan:
    """Small quick robots in a square workspace round the origin."""
    at_goal: AtGoal = "leave" if leave else "stay"
    robots = [
        Robot(f"R{k}", tuple(path[0, 1:].tolist()), tuple(path[-1, 1:].tolist()), 1e-4 * size, 1e4 * size)
        for k, path in enumerate(stamps)
    ]
    scene = Scene((-size, -size, size, size), obstacles or [], robots, at_goal=at_goal)
    return Plan(scene, tuple(Trajectory(f"R{k}", path) for k, path in enumerate(stamps)))


def chain(rng: np.random.Generator, robots: int, reach: float) -> list[FloatArray]:
    """Robots in a straight line, each exactly within reach of the next, moving as one."""
    times = np.r_[0, np.cumsum(rng.uniform(0.5, 2, 6))]
    way = rng.uniform(-2, 2, (7, 2)) * reach
    angle = rng.uniform(0, 2 * np.pi)
    along = reach * np.array([np.cos(angle), np.sin(angle)])
    return [np.column_stack([times, way + k * along]) for k in range(robots)]


def with_push(path: FloatArray, leg: int, share: float, push: FloatArray) -> FloatArray:
    """The same motion with one more stamp on a leg, moved by a vector."""
    stamp = path[leg] + share * (path[leg + 1] - path[leg])
    stamp[1:] += push
    return np.insert(path, leg + 1, stamp, axis=0)


def lost(certificate: Certificate) -> list[Problem]:
    return [problem for problem in certificate.problems if problem.kind == "contact"]


# ---------------------------------------------------------------------------------------------- planted losses


@settings(deadline=None, max_examples=80)
@given(seeds, st.sampled_from([1e-3, 1.0, 1e3, 1e6]))
def test_a_planted_loss_is_found_with_its_robots_and_time(seed: int, reach: float) -> None:
    rng = np.random.default_rng(seed)
    robots = int(rng.integers(2, 8))
    stamps = chain(rng, robots, reach)
    plan = plan_of(stamps, 12 * reach)
    assert certify(plan, contact=reach).ok
    depth = max(1e-6, 1000 * plan.scene.tol)
    parted = int(rng.integers(1, robots))  # from here on they run ahead between two stamps
    leg, share = int(rng.integers(6)), rng.uniform(0.1, 0.9)
    along = stamps[1][0, 1:] - stamps[0][0, 1:]
    push = depth * along / np.hypot(*along)
    pushed = [with_push(path, leg, share, push) if k >= parted else path for k, path in enumerate(stamps)]
    bad = certify(plan_of(pushed, 12 * reach), contact=reach)
    (problem,) = lost(bad)
    behind, ahead = ([f"R{k}" for k in part] for part in (range(parted), range(parted, robots)))
    assert list(problem.robots) in ([behind, ahead] if len(behind) == len(ahead) else [min(behind, ahead, key=len)])
    assert problem.amount == pytest.approx(depth, abs=2 * plan.scene.tol)
    worst = stamps[0][leg, 0] + share * (stamps[0][leg + 1, 0] - stamps[0][leg, 0])
    length = stamps[0][leg + 1, 0] - stamps[0][leg, 0]
    assert problem.time == pytest.approx(worst, abs=1e-2 * length)
    assert bad.contact is not None
    assert bad.contact.lambda2 == 0.0
    assert bad.contact.needed_range is None
    assert problem.place is not None
    middle = (pushed[parted - 1], pushed[parted])
    there = np.mean([Trajectory("R", path).at(problem.time or 0.0) for path in middle], axis=0)
    assert problem.place == pytest.approx(there, abs=1e-6 * reach)


@settings(deadline=None, max_examples=40)
@given(seeds, st.sampled_from([1e-3, 1.0, 1e3, 1e6]))
def test_losses_within_half_the_tolerance_are_accepted(seed: int, reach: float) -> None:
    rng = np.random.default_rng(seed)
    stamps = chain(rng, 5, reach)
    along = stamps[1][0, 1:] - stamps[0][0, 1:]
    push = plan_of(stamps, 12 * reach).scene.tol / 2 * along / np.hypot(*along)
    pushed = [with_push(path, 2, 0.3, push) if k >= 2 else path for k, path in enumerate(stamps)]
    certificate = certify(plan_of(pushed, 12 * reach), contact=reach)
    assert certificate.ok
    assert certificate.contact is not None
    assert certificate.contact.lambda2 == pytest.approx(2 - 2 * np.cos(np.pi / 5))
    assert certificate.contact.needed_range == pytest.approx(reach, rel=2e-6)


@settings(deadline=None, max_examples=30)
@given(seeds, st.sampled_from([1.0, 1e5]))
def test_a_planted_dip_behind_a_corner_is_found(seed: int, size: float) -> None:
    rng = np.random.default_rng(seed)
    box = Rectangle(-0.5 * size, -0.5 * size, size, size, name="pillar")
    # R0 rests on the line of the upper side, R1 slides along it on the far side of the box
    watch = np.array([[0.0, -0.8 * size, 0.5 * size]])
    slide = np.column_stack([[0, 1, 2], np.array([0.55, 0.7, 0.9]) * size, np.full(3, 0.5 * size)])
    reach = 2 * size
    assert certify(plan_of([watch, slide], size, [box]), contact=Contact(reach, sight=True)).contact is not None
    assert not lost(certify(plan_of([watch, slide], size, [box]), contact=Contact(reach, sight=True)))
    tol = plan_of([watch, slide], size, [box]).scene.tol
    share = rng.uniform(0.1, 0.9)
    graze = with_push(slide, 1, share, np.array([0.0, -tol / 2]))
    assert not lost(certify(plan_of([watch, graze], size, [box]), contact=Contact(reach, sight=True)))
    dip = with_push(slide, 1, share, np.array([0.0, -max(1e-6, 1000 * tol) * 3]))
    (problem,) = lost(certify(plan_of([watch, dip], size, [box]), contact=Contact(reach, sight=True)))
    assert problem.amount == 0.0
    assert problem.obstacle == "pillar"
    assert problem.time is not None
    assert 1 < problem.time < 2
    assert "R1 loses contact with the others from t = 1." in str(problem)
    assert "hidden by pillar" in str(problem)


# ---------------------------------------------------------------------------------------------- k and λ2


def random_team(seed: int, robots: int = 7, leave: bool = False) -> Plan:
    rng = np.random.default_rng(seed)
    stamps = [
        np.column_stack([np.r_[0, np.cumsum(rng.uniform(0.5, 2, 3))], rng.uniform(-0.9, 0.9, (4, 2)) * 10])
        for _ in range(robots)
    ]
    return plan_of(stamps, 10.0, leave=leave)


@settings(deadline=None, max_examples=60)
@given(seeds, st.integers(2, 4), st.floats(9, 22), st.booleans())
def test_k_connectedness_agrees_with_networkx(seed: int, k: int, reach: float, leave: bool) -> None:
    plan = random_team(seed, leave=leave)
    problems = lost(certify(plan, contact=Contact(reach, k=k)))

    def strong(time: float) -> bool:
        graph = naive.graph_at(plan, time, reach)
        if len(graph) <= k + 1:
            return len(graph) < 2 or nx.density(graph) == 1
        return bool(nx.node_connectivity(graph) >= k)

    times = contacts(plan, reach).times
    inside = np.append((times[:-1] + times[1:]) / 2, times[-1] + 1).tolist()
    assert (not problems) == all(strong(time) for time in inside)
    for problem in (told for told in problems if told.robots):
        graph = naive.graph_at(plan, problem.time or 0.0, reach)
        if problem.detail.startswith("without"):
            graph = naive.graph_at(plan, min(t for t in inside if t > (problem.time or 0.0)), reach)
            graph.remove_nodes_from([int(name[1:]) for name in problem.robots])
            assert 0 < len(problem.robots) < k
        assert not nx.is_connected(graph)


def test_a_ring_may_lose_one_robot_but_not_two() -> None:
    angle = np.arange(6) * np.pi / 3
    ring = [np.array([[0, np.cos(a), np.sin(a)], [2, np.cos(a) + 1, np.sin(a)]]) for a in angle]
    plan = plan_of(ring, 5.0)
    assert certify(plan, contact=Contact(1.0 + 1e-9, k=2)).ok
    (problem,) = certify(plan, contact=Contact(1.0 + 1e-9, k=3)).problems
    assert problem.robots == ("R0", "R2")
    assert str(problem).startswith(
        "without R0 and R2 the team falls apart from t = 0 s on (contact demanded with any 2"
    )


@settings(deadline=None, max_examples=40)
@given(seeds, st.floats(0.1, 6.0), st.booleans())
def test_the_least_fiedler_value_is_found_and_held_to(seed: int, least: float, leave: bool) -> None:
    plan = random_team(seed, leave=leave)
    certificate = certify(plan, contact=Contact(16.0, lambda2=least))
    assert certificate.contact is not None
    found = contacts(plan, 16.0)
    several = found.present.sum(axis=1) > 1
    value = found.fiedler[several].min()
    assert certificate.contact.lambda2 == pytest.approx(value, abs=1e-11)
    time = certificate.contact.lambda2_time
    assert naive.fiedler(naive.graph_at(plan, time or 0.0, 16.0)) == pytest.approx(value, abs=1e-11)
    loose = [problem for problem in lost(certificate) if "λ2 falls to" in str(problem)]
    weak = found.fiedler[several & (found.fiedler > 0)]
    assert bool(loose) == bool((weak < least * (1 - 1e-9)).any())
    assert bool(lost(certificate)) == (value < least * (1 - 1e-9))


def test_a_fiedler_value_may_be_exactly_as_demanded() -> None:
    stamps = [np.array([[0, x, 0.0]]) for x in range(3)]
    assert certify(plan_of(stamps, 5.0), contact=Contact(1.0, lambda2=1.0)).ok
    assert not certify(plan_of(stamps, 5.0), contact=Contact(1.0, lambda2=1.0 + 1e-8)).ok


# ---------------------------------------------------------------------------------------------- losses as they are told


def test_a_part_that_is_lost_again_and_again_is_told_once() -> None:
    times = np.arange(41.0)
    to_and_fro = np.column_stack([times, np.where(times % 2 == 0, 1.0, 3.0), np.zeros(41)])
    still = [np.array([[0.0, 0, 0]]), np.array([[0.0, 0, 1]])]
    told = lost(certify(plan_of([*still, to_and_fro], 5.0), contact=2.0))
    assert [problem.robots for problem in told] == [("R2",), ()]
    assert told[0].amount == pytest.approx(1.0)
    assert str(told[1]) == "contact is lost 19 more times"


def test_a_team_that_is_never_together_is_told_from_the_start() -> None:
    stamps = [np.array([[0.0, 0, 0]]), np.array([[0.0, 4, 0]]), np.array([[0.0, 4, 1], [1, 4.5, 1]])]
    (problem,) = lost(certify(plan_of(stamps, 5.0), contact=2.0))
    assert str(problem) == (
        "R0 loses contact with the others from t = 0 s on, 2 m beyond the range of 2 m (nearest are R0 and R1, 4 m "
        "apart), at t = 0.5 s near (2, 0)"
    )


def test_who_has_left_is_missed_no_more() -> None:
    stamps = [np.array([[0.0, 0, 0]]), np.array([[0.0, 1, 0]]), np.array([[0.0, 2, 0], [1, 2, 1], [4, 2, 4]])]
    (problem,) = lost(certify(plan_of(stamps, 5.0), contact=2.0))
    assert problem.robots == ("R2",)
    plan = plan_of([*stamps[:2], stamps[2][:2]], 5.0)
    assert not lost(certify(plan, contact=2.0))
    between = replace_robot(plan.scene, 1, goal=(1.5, 0), at_goal="leave")  # it linked the other two
    leaves = Trajectory("R1", np.array([[0.0, 1, 0], [0.25, 1.5, 0]]))
    (problem,) = lost(certify(Plan(between, (plan.trajectories[0], leaves, plan.trajectories[2])), contact=1.9))
    assert problem.robots == ("R2",)
    assert "from t = 0.25 s on" in str(problem)
    gone = replace_robot(between, 2, at_goal="leave")
    (problem,) = lost(certify(Plan(gone, (plan.trajectories[0], leaves, plan.trajectories[2])), contact=1.9))
    assert "from t = 0.25 s to 1 s" in str(problem)


def replace_robot(scene: Scene, number: int, **changes: Any) -> Scene:
    robots = list(scene.robots)
    robots[number] = replace(robots[number], **changes)
    return Scene(scene.workspace, scene.obstacles, robots, at_goal=scene.at_goal)


@pytest.mark.parametrize("robots", [0, 1])
def test_one_robot_is_in_contact(robots: int) -> None:
    stamps = [np.array([[0.0, 0, 0], [1, 1, 1]])][:robots]
    certificate = certify(plan_of(stamps, 5.0), contact=Contact(1.0, sight=True, k=3, lambda2=2.0))
    assert certificate.ok
    assert certificate.contact is not None
    assert certificate.contact.lambda2 is None
    assert certificate.contact.needed_range is None


# ---------------------------------------------------------------------------------------------- claims


def two(claims: dict[str, object]) -> Plan:
    plan = plan_of([np.array([[0.0, 0, 0]]), np.array([[0.0, 2, 0]])], 5.0)
    return replace(plan, claims=claims)


def test_a_claim_is_proved_whatever_else_is_demanded() -> None:
    assert certify(two({"contact": Contact(2.0).claim})).ok
    assert certify(two({})).contact is None
    false = two({"contact": Contact(1.0).claim})
    assert [problem.kind for problem in certify(false).problems] == ["contact"]
    both = certify(false, contact=3.0)
    assert not both.ok
    assert both.contact is not None
    assert both.contact.demand == Contact(3.0)


@pytest.mark.parametrize(
    "value",
    [{"range": -1}, {"range": "x"}, {"sight": True}, {"range": 1, "often": 2}, [1], "near", 3, {"range": 2, "k": True}],
)
def test_a_malformed_claim_is_a_problem(value: object) -> None:
    (problem,) = certify(two({"contact": value})).problems
    assert problem.kind == "claim"
    assert "the plan claims contact = " in str(problem)


@pytest.mark.parametrize("contact", [0, -1.0, float("nan"), True])
def test_a_senseless_demand_is_refused(contact: float) -> None:
    with pytest.raises(SceneError, match="contact: range must be"):
        certify(two({}), contact=contact)


def test_the_report_is_plain_data_and_the_same_each_time() -> None:
    plan = random_team(3)
    one, two_ = (json.dumps(certify(plan, contact=Contact(30.0, k=2)).as_dict(), allow_nan=False) for _ in range(2))
    assert one == two_
    found = json.loads(one)["contact"]
    assert found["demand"] == {"range": 30.0, "sight": False, "k": 2, "lambda2": 0.0}
    assert found["lambda2"] == pytest.approx(7.0)
    assert 0 < found["needed_range"] < 30
    assert "contact" not in certify(plan).as_dict()


def test_contact_in_a_broken_scene_cannot_be_proved() -> None:
    bow: list[Obstacle] = [Rectangle(3, 3, 1, 1)]
    plan = plan_of([np.array([[0.0, 0, 0]]), np.array([[0.0, 2, 0]])], 5.0, bow)
    crossed = Scene([(-5, -5), (5, 5), (5, -5), (-5, 5)], robots=plan.scene.robots)
    told = lost(certify(Plan(crossed, plan.trajectories), contact=Contact(3.0, sight=True)))
    assert [str(problem).startswith("contact cannot be proved: workspace") for problem in told] == [True]
