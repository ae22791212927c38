"""Travel in formation: certified, exact where there is room, contracted and recovered where there is not."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import assume, given, settings
from hypothesis import strategies as st
from scipy.sparse.csgraph import minimum_spanning_tree

from taut.certificate import certify
from taut.contact import Contact, contacts, losses
from taut.errors import NoPath, NoPlanFound, SceneError, StartBlocked
from taut.formation import Formed, in_formation, travel
from taut.formation._timing_kernels import earliest
from taut.formation.shape import shape_of, space_at
from taut.freespace import FreeSpace
from taut.route import shortest_path
from taut.scene import Circle, FloatArray, Obstacle, Point, Rectangle, Robot, Scene

HALL = (0.0, 0.0, 16.0, 8.0)
WEDGE = {"B": (-0.6, 0.6), "C": (-0.6, -0.6)}
BLOCK = {name: (-0.6 * (k // 3), 0.6 * (k % 3) - 0.6) for k, name in enumerate("BCDEFGHIJ", start=3)}


def scene_of(
    offsets: dict[str, Point],
    start: Point = (3, 4),
    goal: Point = (13, 4),
    obstacles: Sequence[Obstacle] = (),
    workspace: Sequence[float] = HALL,
    radius: float = 0.2,
    clearance: float = 0.0,
    gap: float = 0.0,
    headway: float = 0.0,
) -> Scene:
    """A team of the leader A and those who have offsets."""
    robots = [Robot(name, start, goal, radius=radius) for name in ("A", *offsets)]
    return in_formation(Scene(workspace, obstacles, robots, clearance=clearance, gap=gap, headway=headway), offsets)


def wall(x: float, low: float, high: float, thickness: float = 0.2) -> list[Rectangle]:
    """A wall across the hall with a door from low to high."""
    return [Rectangle(x, 0, thickness, low), Rectangle(x, high, thickness, HALL[3] - high)]


def error_at(formed: Formed, time: float) -> float:
    """Greatest distance of a robot from the leader plus its offset."""
    scene = formed.plan.scene
    where = formed.plan.at(time)
    names = [robot.name for robot in scene.robots]
    lead = names.index(formed.leader)
    starts = np.array([robot.start for robot in scene.robots])
    return float(np.hypot(*((where - where[lead]) - (starts - starts[lead])).T).max())


def check(formed: Formed) -> None:
    """Certified, in formation at both ends, and what is told is what happens."""
    assert certify(formed.plan).ok
    assert formed.plan.certificate == formed.certificate.as_dict()
    tol = formed.plan.scene.tol
    assert formed.errors[[0, -1]].max() <= tol
    assert formed.times[[0, -1]].tolist() == [0, formed.plan.makespan]
    for time, error in zip(formed.times, formed.errors, strict=True):
        assert abs(error_at(formed, time) - error) <= 4 * tol
    middles = (formed.times[1:] + formed.times[:-1]) / 2
    for time, before, after in zip(middles, formed.errors, formed.errors[1:], strict=False):
        assert error_at(formed, time) <= max(before, after) + 4 * tol
    for narrow in formed.narrow:
        assert 0 <= narrow.begin < narrow.end <= formed.plan.makespan
    inside = np.zeros(len(formed.times), dtype=bool)
    for narrow in formed.narrow:
        inside |= (formed.times >= narrow.begin) & (formed.times <= narrow.end)
    assert (formed.errors[~inside] <= 4 * tol).all()
    assert (formed.scales[~inside] == 1).all()


def test_in_open_space_the_formation_is_exact_and_as_fast_as_its_slowest_robot() -> None:
    scene = scene_of(WEDGE, (3, 2), (13, 5))
    slow = replace(scene, robots=(*scene.robots[:2], replace(scene.robots[2], speed=0.5)))
    formed = travel(slow)
    check(formed)
    assert formed.errors.max() <= scene.tol
    assert formed.narrow == ()
    assert formed.plan.makespan == pytest.approx(math.hypot(10, 3) / 0.5, rel=1e-12)
    assert [len(t.stamps) for t in formed.plan.trajectories] == [2, 2, 2]


@pytest.mark.parametrize("count", [3, 6, 10])
def test_a_door_of_little_more_than_one_disc_is_passed_in_a_column_and_the_formation_recovers(count: int) -> None:
    offsets = {name: offset for name, offset in ({**WEDGE, **BLOCK}).items() if name in "BCDEFGHIJ"[: count - 1]}
    formed = travel(scene_of(offsets, obstacles=wall(8, 3.76, 4.24)))
    check(formed)
    columns = [narrow for narrow in formed.narrow if narrow.order]
    assert len(columns) == 1
    assert sorted(columns[0].order) == sorted("ABCDEFGHIJ"[:count])
    assert columns[0].scale == 0
    assert math.dist(columns[0].place, (8.1, 4)) < 1
    # the formation is whole well before and after
    assert 1 < columns[0].begin < columns[0].end < formed.plan.makespan - 1
    crossing = [float(np.interp(8.1, t.points[:, 0], t.times)) for t in formed.plan.trajectories]
    names = [robot.name for robot in formed.plan.scene.robots]
    assert tuple(names[i] for i in np.argsort(crossing)) == columns[0].order


def test_where_a_smaller_formation_fits_it_is_scaled_down_and_not_left() -> None:
    offsets: dict[str, Point] = {"B": (0, 0.9), "C": (0, -0.9), "D": (-0.9, 0.9), "E": (-0.9, -0.9)}
    formed = travel(scene_of(offsets, obstacles=wall(6, 3.2, 4.8, 4.0)))
    check(formed)
    assert [narrow.order for narrow in formed.narrow] == [()]
    least = formed.scales.min()
    # 1.6 m of corridor hold two discs of radius 0.2 at most 1.2 m apart; the discs' distance is 0.9 m at least
    assert 0.4 / 0.9 <= least <= 1.2 / 1.8 + 1e-9
    assert formed.errors.max() == pytest.approx((1 - least) * math.hypot(0.9, 0.9))
    where = formed.plan.at(float(formed.times[np.argmin(formed.scales)]))
    assert where[1] - where[0] == pytest.approx([0, 0.9 * least])


def test_what_robots_can_straddle_does_not_stop_the_formation() -> None:
    offsets: dict[str, Point] = {"B": (0, 2), "C": (0, -2)}
    formed = travel(scene_of(offsets, obstacles=[Circle((8, 5), 0.7), Circle((8, 3), 0.7)]))
    check(formed)
    assert formed.errors.max() <= formed.plan.scene.tol
    assert formed.plan.makespan == pytest.approx(10)


def test_keep_weighs_detour_against_contraction() -> None:
    gaps = [Rectangle(8, 1.9, 0.2, 1.8), Rectangle(8, 4.3, 0.2, 3.7)]
    formed = travel(scene_of(WEDGE, obstacles=gaps), keep=50)
    check(formed)
    assert formed.narrow == ()
    fast = travel(scene_of(WEDGE, (3, 4), (13, 4), obstacles=wall(8, 3.25, 4.75)), keep=0)
    check(fast)
    assert fast.plan.makespan < 10.5


def test_a_winding_corridor_is_followed() -> None:
    formed = travel(
        scene_of(WEDGE, (2.5, 4), (12.5, 4), obstacles=[Rectangle(5, 0, 1, 7.4), Rectangle(6.6, 0.6, 1, 7.4)])
    )
    check(formed)
    assert any(narrow.order for narrow in formed.narrow)


def test_a_formation_that_has_to_turn_back_finds_its_order() -> None:
    formed = travel(scene_of(WEDGE, (3, 2), (3, 6), obstacles=[Rectangle(0, 3.9, 15.5, 0.2)]))
    check(formed)
    assert formed.plan.makespan > 20


@pytest.mark.parametrize("leader", ["A", "B", "C"])
def test_anybody_may_lead(leader: str) -> None:
    scene = scene_of({"B": (-0.6, 0), "C": (-1.2, 0.1)}, obstacles=wall(8, 3.76, 4.24))
    formed = travel(scene, leader)
    check(formed)
    assert formed.leader == leader
    assert formed.plan.planner["leader"] == leader
    head = scene.robot(leader).start
    offsets = {r.name: [r.start[0] - head[0], r.start[1] - head[1]] for r in scene.robots}
    assert formed.plan.planner["offsets"] == offsets


def test_a_robot_alone_takes_its_shortest_path() -> None:
    scene = scene_of({}, (3, 2), (13, 2), [Rectangle(6, 0, 2, 5)])
    formed = travel(scene)
    check(formed)
    shortest = shortest_path(FreeSpace.of(scene, scene.robots[0]), (3, 2), (13, 2)).length
    assert formed.plan.length == pytest.approx(shortest, rel=1e-12)


def test_a_team_at_its_goals_stays_there() -> None:
    formed = travel(scene_of(WEDGE, (3, 4), (3, 4)))
    assert formed.certificate.ok
    assert [len(t.stamps) for t in formed.plan.trajectories] == [1, 1, 1]
    assert formed.plan.makespan == 0


def test_nobody_sets_out_before_the_last_start_time() -> None:
    scene = scene_of(WEDGE)
    late = replace(scene, robots=(scene.robots[0], replace(scene.robots[1], start_time=2.5), scene.robots[2]))
    formed = travel(late)
    check(formed)
    assert formed.plan.makespan == pytest.approx(12.5)
    assert formed.errors.max() <= scene.tol


def test_robots_that_differ_in_size_and_speed_get_through() -> None:
    scene = scene_of({**WEDGE, "D": (-1.4, 0)}, obstacles=wall(8, 3.6, 4.4), gap=0.02, clearance=0.03)
    sizes = zip(scene.robots, (0.1, 0.3, 0.2, 0.25), (1.0, 2.0, 0.7, 1.3), strict=True)
    mixed = replace(scene, robots=tuple(replace(r, radius=size, speed=speed) for r, size, speed in sizes))
    check(travel(mixed))


def test_headway_is_kept() -> None:
    scene = scene_of(WEDGE, obstacles=wall(8, 3.76, 4.24), headway=0.2)
    check(travel(scene))
    assert not certify(travel(replace(scene, headway=0.0)).plan, replace(scene, headway=2.0)).ok
    with pytest.raises(SceneError, match=r"A and B are 0\.848.* headway of 2 s"):
        travel(replace(scene, headway=2.0))


@pytest.mark.parametrize("reach", [1.0, 1.5, Contact(1.5, sight=True), Contact(2.0, k=2), Contact(2.0, lambda2=0.5)])
def test_contact_demanded_is_kept(reach: float | Contact) -> None:
    formed = travel(scene_of({**WEDGE, "D": (-1.2, 0)}, obstacles=wall(8, 3.7, 4.3)), contact=reach)
    check(formed)
    demand = reach if isinstance(reach, Contact) else Contact(reach)
    assert formed.plan.claims == {"contact": demand.claim}
    assert not len(losses(contacts(formed.plan, demand.reach, demand.sight)))


def test_contact_that_the_formation_has_not_is_refused() -> None:
    scene = scene_of(WEDGE)
    with pytest.raises(SceneError, match="formation itself"):
        travel(scene, contact=0.8)
    with pytest.raises(SceneError, match="formation itself"):
        travel(scene_of({"B": (0, 2)}, obstacles=[Rectangle(2.5, 5, 1, 0.2)]), contact=Contact(3, sight=True))
    with pytest.raises(SceneError, match="A leaves from its goal"):
        travel(replace(scene, at_goal="leave"), contact=2.0)


@pytest.mark.parametrize("factor", [1e-6, 1e6])
def test_size_does_not_matter(factor: float) -> None:
    scene = scene_of(WEDGE, obstacles=wall(8, 3.76, 4.24))
    sized = Scene(
        np.array(scene.workspace) * factor,
        [Rectangle(o.x * factor, o.y * factor, o.width * factor, o.height * factor) for o in wall(8, 3.76, 4.24)],
        [
            replace(
                r,
                start=tuple(np.multiply(r.start, factor)),
                goal=tuple(np.multiply(r.goal, factor)),
                radius=r.radius * factor,
                speed=factor,
            )
            for r in scene.robots
        ],
    )
    formed = travel(sized)
    check(formed)
    assert formed.plan.makespan == pytest.approx(travel(scene).plan.makespan, rel=1e-3)


def test_robots_that_leave_travel_as_well() -> None:
    formed = travel(replace(scene_of(WEDGE, obstacles=wall(8, 3.76, 4.24)), at_goal="leave"))
    assert formed.certificate.ok


def test_followers_are_put_at_the_offsets() -> None:
    scene = scene_of(WEDGE, (3, 4), (13, 5))
    assert scene.robot("B").start == (2.4, 4.6)
    assert scene.robot("C").goal == (12.4, 4.4)
    assert scene.robot("A").start == (3, 4)


def test_a_follower_without_room_is_named() -> None:
    with pytest.raises(StartBlocked, match=r"robot B: start \(2\.4, 4\.6\)"):
        scene_of(WEDGE, obstacles=[Circle((2.4, 4.6), 0.3)])
    with pytest.raises(SceneError, match="robots A and B start only"):
        scene_of({"B": (0.1, 0)})


@pytest.mark.parametrize(
    ("offsets", "message"),
    [
        ({"B": (1, 0)}, "robot C has none"),
        ({"B": (1, 0), "C": (2, 0), "X": (0, 0)}, "no robot X"),
        ({"B": (1, 0), "C": (2, 0, 0)}, "robot C needs"),
        ({"A": (1, 0), "B": (1, 0), "C": (2, 0)}, "its own must be"),
    ],
)
def test_offsets_that_make_no_sense_are_refused(offsets: dict[str, Point], message: str) -> None:
    with pytest.raises(SceneError, match=message):
        in_formation(scene_of(WEDGE), offsets)


def test_what_cannot_be_asked_is_refused() -> None:
    scene = scene_of(WEDGE)
    moved = replace(scene, robots=(*scene.robots[:2], replace(scene.robots[2], goal=(12.4, 3.1))))
    with pytest.raises(SceneError, match=r"robot C: goal .* is 0\.3 m from its place .* \(12\.4, 3\.4\)"):
        travel(moved)
    with pytest.raises(SceneError, match="no robot X"):
        travel(scene, "X")
    with pytest.raises(SceneError, match="no robots"):
        travel(Scene(HALL))
    for keep in (-1.0, math.nan, math.inf, True):
        with pytest.raises(SceneError, match="keep"):
            travel(scene, keep=keep)


def test_a_robot_too_large_for_every_way_is_named() -> None:
    scene = scene_of(WEDGE, obstacles=wall(8, 3.75, 4.25))
    large = replace(scene, robots=(*scene.robots[:2], replace(scene.robots[2], radius=0.3)))
    with pytest.raises(NoPath, match=r"^C: "):
        travel(large)


def test_where_no_order_gets_through_the_narrow_place_is_named() -> None:
    # a lane that turns back: who is ahead on the way out is behind at the goal
    lane = [Rectangle(0, 0.5, 7.5, 1), Rectangle(0, 2, 8, 6), Rectangle(8, 0, 8, 8)]
    scene = scene_of({"B": (-0.6, 0)}, (4, 0.25), (4, 1.75), lane)
    with pytest.raises(NoPlanFound, match=r"found for A, B: .* 0\.5 m wide between") as caught:
        travel(scene)
    assert caught.value.robots == ("A", "B")
    assert caught.value.place is not None


@st.composite
def halls(draw: st.DrawFn) -> Scene:
    """A team of 1 to 5 in a hall with a wall and a door through which everybody fits, or posts."""
    radius = draw(st.sampled_from([0.1, 0.2, 0.3]))
    cells = draw(st.lists(st.tuples(st.integers(-3, 1), st.integers(-2, 2)), max_size=4, unique=True))
    pitch = 2 * radius * draw(st.sampled_from([1.0, 1.25, 2.0]))
    offsets: dict[str, Point] = {
        name: (i * pitch, j * pitch) for name, (i, j) in zip("BCDE", cells, strict=False) if (i, j) != (0, 0)
    }
    y0, y1 = draw(st.floats(3, 5)), draw(st.floats(3, 5))
    if draw(st.booleans()):
        width, middle = 2 * radius * draw(st.floats(1.05, 4)), draw(st.floats(2, 6))
        return scene_of(offsets, (4.5, y0), (13, y1), wall(8, middle - width / 2, middle + width / 2), radius=radius)
    posts = st.tuples(st.floats(7.2, 7.9), st.floats(0, 8), st.floats(0.1, 0.9))
    obstacles = [Circle((x, y), size) for x, y, size in draw(st.lists(posts, max_size=4))]
    return scene_of(offsets, (4.5, y0), (13, y1), obstacles, radius=radius)


@settings(max_examples=25, deadline=None)
@given(halls())
def test_in_halls_with_doors_and_posts_every_plan_is_certified(scene: Scene) -> None:
    try:
        formed = travel(scene)
    except NoPath:
        assume(False)
    check(formed)
    assert travel(scene).plan.trajectories == formed.plan.trajectories


@settings(max_examples=12, deadline=None)
@given(halls(), st.floats(1.1, 3))
def test_plans_with_contact_keep_it(scene: Scene, factor: float) -> None:
    places = np.array([robot.start for robot in scene.robots])
    assume(len(places) > 1)
    apart = np.hypot(*np.moveaxis(places[:, None] - places, 2, 0))
    reach = factor * float(minimum_spanning_tree(apart).max())
    try:
        formed = travel(scene, contact=reach)
    except (NoPath, NoPlanFound):
        assume(False)
    check(formed)
    assert certify(formed.plan, contact=reach).ok


@settings(max_examples=25, deadline=None)
@given(halls(), st.floats(0.3, 1), st.integers(0, 2**32))
def test_the_space_at_a_scale_is_where_all_robots_fit(scene: Scene, scale: float, seed: int) -> None:
    shape = shape_of(scene, None)
    points = np.random.default_rng(seed).uniform((0, 0), (16, 8), (200, 2))
    alone = [space.contains(points + scale * offset) for space, offset in zip(shape.spaces, shape.offsets, strict=True)]
    assert (space_at(shape, scale).contains(points) == np.all(alone, axis=0)).all()


def naive_arrival(stops: FloatArray, others: FloatArray, needed: FloatArray, reach: float) -> int:
    """Time at which the last stop is reached for good, by sets of stops and sampled distances; −1 for never."""
    share = np.linspace(0, 1, 2001)[:, None]

    def allowed(t: int, a: int, b: int) -> bool:
        linked = not len(others)
        for other, least in zip(others, needed, strict=True):
            gap = stops[a] - other[t] + share * (stops[b] - other[t + 1] - stops[a] + other[t])
            if np.hypot(*gap.T).min() < least:
                return False
            linked |= math.dist(stops[a], other[t]) <= reach and math.dist(stops[b], other[t + 1]) <= reach
        return linked

    last, horizon = len(stops) - 1, others.shape[1]
    reached, arrivals = {0}, []
    for t in range(horizon):
        if last in reached and all(allowed(u, last, last) for u in range(t, horizon - 1)):
            arrivals.append(t)
        if t < horizon - 1:
            stay = {s for s in reached if allowed(t, s, s)}
            reached = stay | {s + 1 for s in reached if s < last and allowed(t, s, s + 1)}
    return arrivals[0] if arrivals else -1


@settings(max_examples=60, deadline=None)
@given(st.integers(0, 2**32), st.integers(0, 3), st.booleans())
def test_each_robot_is_timed_as_early_as_the_others_allow(seed: int, count: int, bound: bool) -> None:
    rng = np.random.default_rng(seed)
    stops = rng.uniform(0, 4, (int(rng.integers(2, 6)), 2))
    others = np.cumsum(rng.uniform(-0.8, 0.8, (count, 9, 2)), axis=1) + rng.uniform(0, 4, (count, 1, 2))
    needed = rng.uniform(0.3, 1.0, count)
    reach = 2.5 if bound else math.inf
    times = earliest(stops, others, needed, reach)
    assert len(times) - 1 == naive_arrival(stops, others, needed, reach)
    if len(times):
        assert times[[0, -1]].tolist() == [0, len(stops) - 1]
        assert set(np.diff(times)) <= {0, 1}
