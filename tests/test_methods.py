"""The methods of planning side by side: certified, no cost below a bound, better with more work, repeatable."""

from __future__ import annotations

import _thread
import math
import threading
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from taut import Lanes, NoPlanExists, NoPlanFound, Robot, Scene, SceneError, load_scene, plan, random_scene
from taut.interrupts import held_back
from taut.motion import Plan
from taut.team import Result
from taut.team.methods import METHODS, Progress


def bound_of(found: Plan) -> float:
    assert found.lower_bound is not None
    return float(str(found.lower_bound["value"]))


def stamps(result: Result) -> list[bytes]:
    return [motion.stamps.tobytes() for motion in result.plan.trajectories]


@settings(max_examples=12, deadline=None)
@given(
    robots=st.integers(1, 5),
    seed=st.integers(0, 1000),
    leave=st.booleans(),
    late=st.booleans(),
    objective=st.sampled_from(["sum_of_costs", "makespan"]),
)
def test_optimal_beats_repair_beats_passes_and_nothing_its_bound(
    robots: int, seed: int, leave: bool, late: bool, objective: str
) -> None:
    scene = random_scene(
        robots, 1, seed, size=7, obstacle_size=(0.5, 1.5), at_goal="leave" if leave else "stay", speed=(0.5, 2.0)
    )
    if late:
        team = [replace(robot, start_time=1.5 * k) for k, robot in enumerate(scene.robots)]
        scene = replace(scene, robots=tuple(team))
    try:
        first = plan(scene)
    except (NoPlanExists, NoPlanFound):
        return

    def cost(result: Result) -> float:
        return result.plan.makespan if objective == "makespan" else result.plan.sum_of_costs

    repaired = plan(scene, "repair", rounds=2, objective=objective)  # type: ignore[arg-type]
    least = plan(scene, "optimal", rounds=200, objective=objective)  # type: ignore[arg-type]
    assert cost(repaired) <= cost(first) * (1 + 1e-12)
    assert cost(least) <= cost(first) * (1 + 1e-9)
    for result in (first, repaired, least):
        assert result.certificate.ok
        if objective == "sum_of_costs" or result is not first:
            assert bound_of(result.plan) <= cost(result) * (1 + 1e-9)
    if least.plan.planner["proven"]:
        assert cost(least) == pytest.approx(max(bound_of(least.plan), cost(least)))


@pytest.mark.parametrize("name", ["crossing-30", "hospital-12"])
def test_more_rounds_of_repair_never_cost_more_and_roadmaps_grow_on_the_way(name: str) -> None:
    scene = load_scene(name)
    few, many = (plan(scene, rounds=rounds) for rounds in (2, 20))
    assert few.certificate.ok
    assert many.certificate.ok
    assert many.plan.sum_of_costs <= few.plan.sum_of_costs
    costs = [cost for _, cost in many.history]
    assert costs == sorted(costs, reverse=True)
    assert costs[-1] == pytest.approx(many.plan.sum_of_costs)
    assert many.plan.planner["rounds"] == 20


def test_the_rounds_that_a_plan_records_repeat_it_with_any_number_of_threads(monkeypatch: pytest.MonkeyPatch) -> None:
    scene = load_scene("crossing-30")
    timed = plan(scene, seconds=1.0, seed=3)
    done = timed.plan.planner["rounds"]
    assert isinstance(done, int)
    assert done > 0
    monkeypatch.setattr("os.cpu_count", lambda: 1)
    assert stamps(plan(scene, rounds=done, seed=3)) == stamps(timed)


def test_a_plan_without_time_for_repair_is_repeated_by_no_rounds() -> None:
    scene = load_scene("thesis-2")
    timed = plan(scene, seconds=1e-9)
    assert timed.plan.planner["rounds"] == 0
    assert stamps(plan(scene, rounds=0)) == stamps(timed)


def test_ctrl_c_during_repair_gives_the_best_plan_so_far() -> None:
    scene = random_scene(60, 4, 1, size=17)
    began: list[Progress] = []

    def tell(now: Progress) -> None:
        began.append(now)
        if now.doing == "repair" and now.done == 3:
            _thread.interrupt_main()

    result = plan(scene, rounds=1000, progress=tell)
    assert result.certificate.ok
    assert result.plan.planner["rounds"] in (3, 4)
    assert all(math.isfinite(now.bound) for now in began)


def test_ctrl_c_is_held_back_in_the_main_thread_only_and_comes_back_after() -> None:
    with held_back() as came:
        _thread.interrupt_main()
        assert came()
    with pytest.raises(KeyboardInterrupt):
        _thread.interrupt_main()
    told: list[bool] = []

    def elsewhere() -> None:
        with held_back() as came:
            told.append(came())

    thread = threading.Thread(target=elsewhere)
    thread.start()
    thread.join()
    assert told == [False]


def test_the_makespan_is_made_less_and_bounded() -> None:
    scene = random_scene(12, 2, 2, size=9)
    usual = plan(scene, rounds=10)
    hasty = plan(scene, rounds=10, objective="makespan")
    assert hasty.plan.makespan <= usual.plan.makespan
    assert hasty.plan.lower_bound is not None
    assert hasty.plan.lower_bound["of"] == "makespan"
    assert bound_of(hasty.plan) <= hasty.plan.makespan * (1 + 1e-12)


def test_within_a_factor_of_the_bound_is_cheaper_to_prove() -> None:
    scene = random_scene(6, 2, 5, size=10)
    exact, near = (plan(scene, "optimal", rounds=3000, within=within) for within in (1.0, 1.1))
    assert near.plan.planner["proven"]
    assert near.plan.sum_of_costs <= 1.1 * bound_of(near.plan) * (1 + 1e-9)
    assert int(str(near.plan.planner["rounds"])) <= int(str(exact.plan.planner["rounds"]))


@pytest.mark.parametrize(
    ("asked", "message"),
    [
        ({"method": "best"}, "method 'best' is not one of prioritized, mrppa, search, repair, optimal"),
        ({"objective": "fuel"}, "objective 'fuel' is not one of sum_of_costs, makespan"),
        ({"objective": "makespan"}, "belongs to the methods"),
        ({"within": 1.2}, 'within belongs to the method "optimal"'),
        ({"method": "optimal", "within": 0.9}, "within must be a factor of at least 1"),
        ({"method": "search", "rounds": 0}, "rounds must be at least 1, got 0"),
        ({"rounds": -1}, "rounds must be at least 0"),
        ({"rounds": 2.5}, "rounds must be at least 0"),
        ({"seconds": 0}, "seconds must be positive"),
        ({"seed": -1}, "seed must be at least 0"),
        ({"roadmap": "motorway"}, "roadmap 'motorway' is not one of"),
        ({"method": "mrppa", "roadmap": "voronoi"}, "works on the visibility graph"),
    ],
)
def test_options_that_make_no_sense_are_refused(asked: dict[str, object], message: str) -> None:
    with pytest.raises(SceneError, match=message):
        plan(load_scene("thesis-2"), **asked)  # type: ignore[arg-type]


def test_all_methods_plan_on_lanes_and_keep_to_them() -> None:
    lanes = Lanes.from_edges([(1, 1), (9, 1), (9, 5), (1, 5)], [(0, 1), (1, 2), (2, 3), (3, 0)], directed=True)
    team = [Robot("A", (1, 1), (9, 5), 0.3), Robot("B", (9, 1), (1, 5), 0.3), Robot("C", (9, 5), (1, 1), 0.3)]
    scene = Scene((0, 0, 10, 6), robots=team, gap=0.1)
    for method in (name for name in METHODS if name != "mrppa"):
        found = plan(scene, method, roadmap=lanes)
        assert found.certificate.ok
        lower = found.plan.lower_bound
        assert lower is not None
        assert lower["model"] == "roadmap"
        # round the ring: 12, 12 and 12 metres
        assert bound_of(found.plan) == pytest.approx(36.0)
        assert np.isclose(found.plan.length, 36.0)


def test_ctrl_c_before_a_proof_has_begun_keeps_the_plan_that_is_known(monkeypatch: pytest.MonkeyPatch) -> None:
    def interrupted(*_: object) -> None:
        raise KeyboardInterrupt

    monkeypatch.setattr("taut.team.methods.optimal_round", interrupted)
    found = plan(load_scene("crossing-30"), "optimal")
    assert found.certificate.ok
    assert found.plan.planner["proven"] is False
    with pytest.raises(KeyboardInterrupt):  # there is none to keep
        plan(Scene((0, 0, 10, 1.195), robots=FACING, gap=0.0), "optimal")


def test_ctrl_c_between_two_stages_of_repair_keeps_the_plan(monkeypatch: pytest.MonkeyPatch) -> None:
    def grown(world: object, done: object) -> None:
        _thread.interrupt_main()

    monkeypatch.setattr("taut.team.methods._enrich", grown)
    found = plan(random_scene(60, 4, 1, size=17), rounds=1000)
    assert found.certificate.ok
    assert int(str(found.plan.planner["rounds"])) < 1000


def test_where_numbers_are_too_far_apart_for_a_proof_it_says_so() -> None:
    scene = load_scene("thesis-2")
    late = replace(scene, robots=tuple(replace(robot, start_time=1e5) for robot in scene.robots))
    with pytest.raises(SceneError, match=r"no optimal plan can be sought: .*; choose another method"):
        plan(late, "optimal")


FACING = (Robot("A", (1, 0.5), (9, 0.5), 0.3), Robot("B", (9, 0.5), (1, 0.5), 0.3))


def test_what_is_known_without_a_plan_is_told() -> None:
    with pytest.raises(NoPlanFound, match="any on this roadmap costs at least") as caught:
        plan(Scene((0, 0, 10, 1.195), robots=FACING), "optimal", rounds=50)
    assert caught.value.diagnosis
    with pytest.raises(SceneError, match="leave order out"):
        plan(load_scene("thesis-2"), "search", order="longest")
