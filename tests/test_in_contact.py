"""Planning in contact: whoever is planned later stays within reach, and in sight, of some planned before, always."""

from __future__ import annotations

import math
from dataclasses import replace
from typing import Any

import numpy as np
import pytest
import shapely
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.optimize import linear_sum_assignment

from taut.certificate import certify
from taut.contact import Contact, sight_sides
from taut.errors import NoPlanFound, SceneError
from taut.generate import random_scene
from taut.motion import Trajectory
from taut.roadmap import grid_lanes
from taut.scene import Polygon, Rectangle, Robot, Scene
from taut.team import plan
from taut.team._conflict_kernels import Floats
from taut.team._contact_kernels import Partners, _first_gap, in_contact, lonely_times, next_chance
from taut.team.contact_methods import IN_CONTACT
from taut.team.partners import partners_of, walls_of
from taut.team.ties import linked_order, ties_of

SIDE = 10.0
NOWHERE: Floats = np.empty((0, 4))

# --- Questions of the search ------------------------------------------------------------------------------------------


def wanderers(rng: np.random.Generator, count: int, legs: int) -> list[Trajectory]:
    """Robots that go from place to place, or rest, for about ten seconds."""
    out = []
    for k in range(count):
        stamps = [(0.0, *rng.uniform(0, SIDE, 2))]
        for _ in range(int(rng.integers(legs + 1))):
            t, x, y = stamps[-1]
            rests = rng.random() < 0.3
            stamps.append((t + float(rng.uniform(0.2, 4)), x, y) if rests else (t + 2.0, *rng.uniform(0, SIDE, 2)))
        out.append(Trajectory(f"R{k}", np.array(stamps)))
    return out


def company(motions: list[Trajectory], reach: float, need: int, walls: Floats = NOWHERE) -> Partners:
    scene = Scene((0, 0, SIDE, SIDE), robots=[Robot(m.name, (1, 1), (2, 2)) for m in motions], gap=0.1)
    return partners_of(scene, motions, Contact(reach), walls_of(walls), need)


def partners_at(
    motions: list[Trajectory], times: Floats, places: Floats, reach: float, walls: Floats = NOWHERE
) -> np.ndarray:
    """How many robots are within reach, and in sight, of a place at each time."""
    count = np.zeros(len(times), dtype=np.int64)
    sides = shapely.linestrings(walls.reshape(-1, 2, 2))
    for motion in motions:
        there = motion.at(times)
        near = np.hypot(*(there - places).T) <= reach
        if len(walls):
            lines = shapely.linestrings(np.stack([there, places], axis=1))
            near &= ~shapely.intersects(lines[:, None], sides[None]).any(axis=1)
        count += near
    return count


def sides_of(rng: np.random.Generator, count: int) -> Floats:
    blocks = []
    for _ in range(count):
        x, y = rng.uniform(1, SIDE - 2, 2).tolist()
        blocks.append(Rectangle(x, y, *rng.uniform(0.3, (1.5, 1.5, 3)).tolist()))
    return sight_sides(Scene((0, 0, SIDE, SIDE), blocks), 0.0) if count else NOWHERE


cases = st.tuples(st.integers(0, 10**6), st.integers(1, 4), st.integers(1, 2), st.floats(1.0, 6.0), st.integers(0, 3))


@settings(deadline=None, max_examples=150)
@given(cases)
def test_times_without_contact_are_those_of_samples(case: tuple[int, int, int, float, int]) -> None:
    seed, count, need, reach, blocks = case
    rng = np.random.default_rng(seed)
    motions, walls = wanderers(rng, count, 6), sides_of(rng, blocks)
    x, y = rng.uniform(0, SIDE, 2).tolist()
    lo, hi = np.empty(200), np.empty(200)
    found = lonely_times(company(motions, reach, need, walls), x, y, 0.0, math.inf, lo, hi, 0)
    times = np.sort(rng.uniform(0, 20, 600))
    alone = ((times[:, None] > lo[:found]) & (times[:, None] < hi[:found])).any(axis=1)
    near = partners_at(motions, times, np.tile((x, y), (len(times), 1)), reach, walls)
    sure = np.ones(len(times), dtype=bool)
    if found:
        ends = np.concatenate([lo[:found], hi[:found]])
        sure = np.abs(times[:, None] - ends).min(axis=1) > 1e-7
    assert (alone == (near < need))[sure].all()


@settings(deadline=None, max_examples=200)
@given(cases, st.floats(0, 8), st.floats(0.2, 6))
def test_a_departure_in_contact_keeps_it_and_no_earlier_one_does(
    case: tuple[int, int, int, float, int], earliest: float, tau: float
) -> None:
    seed, count, need, reach, blocks = case
    rng = np.random.default_rng(seed)
    motions, walls = wanderers(rng, count, 6), sides_of(rng, blocks)
    a, b = rng.uniform(0, SIDE, (2, 2))
    edge = (*a.tolist(), *b.tolist())
    partners = company(motions, reach, need, walls)
    depart, latest = earliest, earliest + 6.0
    for _ in range(256):
        chance = next_chance(partners, edge, tau, depart, latest)
        if chance == depart or not chance <= latest:
            depart = chance
            break
        assert chance > depart
        depart = chance
    along = np.linspace(0, 1, 400)
    places = a + along[:, None] * (b - a)
    if depart <= latest:
        assert in_contact(partners, edge, tau, depart)
        near = partners_at(motions, depart + along * tau, places, reach + 1e-6, walls if not blocks else NOWHERE)
        assert (near >= need).all()
        if blocks:  # away from the instants at which sight begins or ends
            seen = partners_at(motions, depart + along * tau, places, reach + 1e-6, walls)
            assert (seen < need).mean() <= 0.01
    until = min(depart, latest)
    for earlier in np.linspace(earliest, until, 40, endpoint=False):
        if until - earlier > 1e-4:
            gap, back = _first_gap(partners, edge, tau, earlier)
            assert gap < min(back, tau)
            share = 0.5 * (gap + min(back, tau)) / tau
            where, when = (a + share * (b - a))[None], np.array([earlier + share * tau])
            if min(back, tau) - gap > 1e-7:  # else samples cannot tell
                assert partners_at(motions, when, where, reach, walls)[0] < need


def test_a_robot_may_follow_at_exactly_the_range() -> None:
    leader = Trajectory("R0", np.array([[0.0, 3.0, 5.0], [5.0, 8.0, 5.0]]))
    partners = company([leader], 2.0, 1)
    edge = (1.0, 5.0, 6.0, 5.0)
    assert in_contact(partners, edge, 5.0, 0.0)
    assert not in_contact(partners, edge, 5.0, 0.01)
    assert in_contact(partners, edge, 2.5, 0.0)
    assert not in_contact(company([leader], 2.0 - 1e-9, 1), edge, 5.0, 0.0)


def test_partners_may_change_on_the_way() -> None:
    """Neither of two resting robots reaches over the whole edge; together they do, and a hole of 1e-6 m is seen."""
    rest = [Trajectory(f"R{k}", np.array([[0.0, x, 5.0]])) for k, x in enumerate((2.0, 6.0))]
    edge = (0.5, 5.0, 7.5, 5.0)
    assert in_contact(company(rest, 2.0, 1), edge, 7.0, 0.0)
    assert not in_contact(company(rest, 2.0 - 5e-7, 1), edge, 7.0, 0.0)
    assert not in_contact(company(rest, 2.0, 2), edge, 7.0, 0.0)


# --- Orders -----------------------------------------------------------------------------------------------------------


@settings(deadline=None, max_examples=60)
@given(st.integers(0, 10**6), st.integers(2, 9), st.integers(1, 3))
def test_an_order_is_found_whenever_there_is_one(seed: int, count: int, need: int) -> None:
    """Against all orders that can be grown, robot by robot."""
    rng = np.random.default_rng(seed)
    scene = Scene(
        (0, 0, 9, 9),
        robots=[Robot(f"R{i}", tuple(rng.uniform(0, 9, 2)), tuple(rng.uniform(0, 9, 2))) for i in range(count)],
        gap=0.01,
    )
    try:
        ties = ties_of(scene, Contact(4.0, k=need))
    except SceneError:
        return
    found = linked_order(ties, range(count))
    for k, i in enumerate(found):
        for links in (ties.starts, ties.goals):
            assert links[i][found[:k]].sum() >= min(k, need, count - 1)

    def grown(order: list[int]) -> int:
        able = [
            i
            for i in range(count)
            if i not in order
            and all(links[i][order].sum() >= min(len(order), need, count - 1) for links in (ties.starts, ties.goals))
        ]
        return max((grown([*order, i]) for i in able[:2]), default=len(order))

    if count <= 6:
        assert len(found) == max(grown([i]) for i in range(count))


# --- Plans ------------------------------------------------------------------------------------------------------------


def swarm(count: int, seed: int, noise: float = 0.5, blocks: int = 8, box: float = 30.0, radius: float = 0.2) -> Scene:
    """A swarm that crosses a hall with blocks; the more noise, the more its robots change places."""
    rng = np.random.default_rng(seed)
    side = math.ceil(math.sqrt(count))
    grid = 0.9 * np.array([(k % side, k // side) for k in range(count)], dtype=np.float64)
    goals = grid + rng.normal(0, noise, grid.shape)
    seats = 0.9 * np.array([(k % side, k // side) for k in range(count)], dtype=np.float64)
    chosen = linear_sum_assignment(((goals[:, None] - seats[None]) ** 2).sum(axis=-1))[1]
    robots = [
        Robot(f"R{k}", tuple(grid[k] + (1, 5)), tuple(seats[chosen[k]] + (box - 1 - 0.9 * side, 5)), radius)
        for k in range(count)
    ]
    obstacles = []
    for k in range(blocks):
        x, y = rng.uniform((8, 2), (box - 10, 14)).tolist()
        width, height, angle = rng.uniform(0.5, (2, 2, 3)).tolist()
        obstacles.append(Rectangle(x, y, width, height, angle, f"B{k}"))
    return Scene((0, 0, box, 18), obstacles, robots)


@settings(deadline=None, max_examples=20)
@given(
    st.integers(0, 10**6),
    st.integers(2, 12),
    st.sampled_from([0.3, 5.0]),
    st.floats(1.3, 4),
    st.booleans(),
    st.integers(1, 3),
    st.sampled_from(sorted(IN_CONTACT)),
)
def test_plans_are_certified_with_what_they_claim(
    seed: int, count: int, noise: float, reach: float, sight: bool, k: int, method: str
) -> None:
    demand = Contact(reach, sight, k)
    failed: NoPlanFound | SceneError | None = None
    try:
        result = plan(swarm(count, seed, noise), method, contact=demand, rounds=8)
    except (NoPlanFound, SceneError) as error:
        failed = error
    if isinstance(failed, NoPlanFound):
        assert failed.robots
        assert failed.time is not None
        assert failed.place is not None
    if failed is not None:
        return
    assert result.plan.claims == {"contact": demand.claim}
    assert result.certificate.ok, [str(problem) for problem in result.certificate.problems]
    assert certify(result.plan, contact=demand).ok


def test_robots_that_change_places_gather_on_the_way() -> None:
    """In a chain whose goals are shuffled no order stands by itself at both ends."""
    places = np.random.default_rng(8).permutation(8)
    robots = [Robot(f"R{i}", (1.5 + 0.9 * i, 2), (25 + 0.9 * places[i], 8), 0.2) for i in range(8)]
    result = plan(Scene((0, 0, 40, 10), robots=robots), contact=1.0)
    assert result.certificate.ok
    assert result.plan.planner["gathered"] == 1
    assert any("gathers" in note for note in result.notes)


def test_a_base_station_stays_where_it_is() -> None:
    robots = [Robot("base", (1, 5), (1, 5), 0.2)] + [
        Robot(f"R{k}", (2, 4.1 + k * 0.6), (1 + 2.5 * (k + 1), 5), 0.2) for k in range(4)
    ]
    result = plan(Scene((0, 0, 16, 10), robots=robots), contact=2.6, order="longest")
    assert result.certificate.ok
    assert len(result.plan.trajectories[0].stamps) == 1


def test_through_a_door_one_by_one() -> None:
    scene = swarm(12, 3, blocks=0)
    walls = [Rectangle(14, -1, 1, 7.8, name="W1"), Rectangle(14, 7.4, 1, 12, name="W2")]
    for sight in (False, True):
        assert plan(replace(scene, obstacles=tuple(walls)), contact=Contact(2.5, sight)).certificate.ok


def test_the_same_seed_and_rounds_give_the_same_plan() -> None:
    scene = swarm(10, 5, 5.0)
    for method in sorted(IN_CONTACT):
        one, two = (plan(scene, method, contact=2.0, rounds=6, seed=3).plan for _ in range(2))
        assert one.trajectories == two.trajectories


def test_repair_never_makes_it_worse_and_keeps_contact() -> None:
    scene = swarm(14, 2, 5.0)
    first = plan(scene, contact=2.0).plan
    better = plan(scene, contact=2.0, rounds=20)
    assert better.certificate.ok
    assert better.plan.sum_of_costs <= first.sum_of_costs
    costs = [cost for _, cost in better.history]
    assert costs == sorted(costs, reverse=True)
    assert plan(scene, contact=2.0, rounds=5, objective="makespan").plan.makespan <= first.makespan


def test_k_connected_teams_survive_failures() -> None:
    result = plan(swarm(9, 4), contact=Contact(3.0, k=3))
    assert result.certificate.ok
    motions = result.plan.trajectories
    for t in np.linspace(0, result.plan.makespan, 50):
        places = np.array([motion.at(t) for motion in motions])
        near = np.hypot(*(places[:, None] - places[None]).transpose(2, 0, 1)) <= 3.0 + 1e-9
        assert (near.sum(axis=1) - 1 >= 3).all()


def test_lanes_are_kept_in_contact() -> None:
    lanes = grid_lanes(np.ones((5, 11), dtype=bool), 8)
    robots = [Robot("R1", (1, 1), (8, 1), 0.2), Robot("R2", (0, 1), (7, 1), 0.2)]
    assert plan(Scene((-1, -1, 11, 5), robots=robots), roadmap=lanes, contact=1.5).certificate.ok


def test_without_contact_nothing_is_claimed() -> None:
    assert plan(random_scene(4, 3, 1)).plan.claims == {}


# --- What cannot be ---------------------------------------------------------------------------------------------------

PAIR = Scene((0, 0, 20, 10), robots=[Robot("R1", (1, 1), (9, 1), 0.3), Robot("R2", (3, 1), (11, 1), 0.3)], gap=0.1)


BOW_TIE = Scene(
    (0, 0, 20, 10),
    robots=[
        Robot(f"R{k}", (x, y), (x + 10, y), 0.1) for k, (x, y) in enumerate([(2, 2), (2, 3), (3, 2.5), (4, 2), (4, 3)])
    ],
)


@pytest.mark.parametrize(
    ("scene", "contact", "words"),
    [
        (PAIR, 1.5, "the starts are not connected within 1.5 m: R1 is cut off; R1 is 2 m from R2"),
        (PAIR, 0.6, "can come no nearer than 0.7 m"),
        (PAIR, Contact(3.0, k=1, lambda2=3.0), "λ2 is 2 at the starts"),
        (replace(PAIR, at_goal="leave"), 5.0, "robot R1 leaves at its goal"),
        (
            replace(PAIR, obstacles=(Polygon([(1.9, 0), (2.1, 0), (2.1, 5), (1.9, 5)]),)),
            Contact(5.0, sight=True),
            "in sight",
        ),
        (replace(PAIR, robots=(PAIR.robots[0], replace(PAIR.robots[1], goal=(19, 9)))), 3.0, "the goals are not"),
        (PAIR, -1.0, "range must be positive"),
        (PAIR, math.nan, "range must be a finite number"),
        (PAIR, "5", "range must be a finite number, got '5'"),
        (PAIR, 10**400, "range must be a finite number"),
        (BOW_TIE, Contact(1.3, k=2), "the starts are not 2-connected within 1.3 m: a robot may fail"),
    ],
)
def test_impossible_demands_are_refused_at_once(scene: Scene, contact: Any, words: str) -> None:
    with pytest.raises(SceneError, match="contact") as caught:
        plan(scene, contact=contact)
    assert words in str(caught.value)
    assert "\n" not in str(caught.value)


def test_numbers_of_numpy_are_numbers() -> None:
    assert plan(PAIR, contact=np.float32(3)).plan.claims["contact"] == Contact(3, k=np.int64(1)).claim  # type: ignore[arg-type]


def test_optimal_has_no_contact() -> None:
    with pytest.raises(SceneError, match="contact belongs to the methods"):
        plan(PAIR, "optimal", contact=3.0)


def test_a_team_that_gets_no_plan_is_told_who_where_and_when() -> None:
    """R1 has to go round a long wall, out of reach of R2, which is where it is to be."""
    walls = [Rectangle(0, 3, 18, 0.5, name="wall")]
    robots = [Robot("R1", (1, 2), (1, 4.5), 0.3), Robot("R2", (2, 2), (2, 2), 0.3)]
    with pytest.raises(NoPlanFound) as caught:
        plan(Scene((0, 0, 20, 8), walls, robots), contact=2.8, rounds=4)
    assert set(caught.value.robots) == {"R1", "R2"}
    assert caught.value.place is not None
    assert caught.value.time is not None
    assert "R1 cannot stay within 2.8 m of R2" in str(caught.value)


def test_rounds_bound_the_passes() -> None:
    """Also those on the stretches between places to gather."""
    places = np.random.default_rng(8).permutation(8)
    robots = [Robot(f"R{i}", (1.5 + 0.9 * i, 2), (25 + 0.9 * places[i], 8), 0.2) for i in range(8)]
    scene = Scene((0, 0, 40, 10), robots=robots)
    for method in ("prioritized", "search"):
        with pytest.raises(NoPlanFound):
            plan(scene, method, contact=1.0, rounds=1)
        assert int(str(plan(scene, method, contact=1.0, rounds=9).plan.planner["rounds"])) <= 9


def test_seconds_are_repeated_by_the_rounds_they_took() -> None:
    scene = swarm(12, 2, 5.0)
    short = plan(scene, contact=2.0, seconds=0.7)
    again = plan(scene, contact=2.0, rounds=max(int(str(short.plan.planner["rounds"])), 1))
    if short.plan.planner["rounds"]:
        assert again.plan.trajectories == short.plan.trajectories
