"""Vehicles that follow: pure pursuit as in the textbook, and a tracker that keeps to the plan and to its timing."""

from __future__ import annotations

import math
from dataclasses import replace
from typing import Any

import numpy as np
import pytest
import shapely
from hypothesis import given, settings
from hypothesis import strategies as st
from numpy.typing import NDArray

from taut import Robot
from taut.control import PurePursuit, Tracking, progress_rate, pursue, tuning
from taut.control._course_kernels import COLUMNS, TO_X, TO_Y, lay_courses
from taut.control._following_kernels import advance, command
from taut.errors import SceneError
from taut.simulation._vehicle_kernels import move
from taut.simulation.vehicles import KINDS, Ackermann, Unicycle, Vehicle, tables, tracking_for, vehicle_for

Floats = NDArray[np.float64]

ROBOT = Robot("R1", (0, 0), (1, 0), radius=0.15, speed=1.0)
DT = 0.02
eighths = st.integers(-16, 40).map(lambda k: k / 8)
COURSES = {
    "line": [(0, 0, 0), (5, 5, 0)],
    "corner": [(0, 0, 0), (3, 3, 0), (6, 3, 3)],
    "slight bend": [(0, 0, 0), (3, 3, 0), (6, 6, 0.6)],
    "there and back": [(0, 0, 0), (2, 2, 0), (4, 0, 0)],
    "rest at a corner": [(0, 0, 0), (2, 2, 0), (5, 2, 0), (7, 2, 2)],
    "rest at the start": [(0, 0, 0), (3, 0, 0), (5, 0, 2)],
    "staircase": [(0, 0, 0)] + [(k + 1, (k + 2) // 2, (k + 1) // 2) for k in range(6)],
    "slow leg": [(0, 0, 0), (4, 1, 0), (5, 2, 0)],
    "many short legs": [(t, math.cos(t), math.sin(t)) for t in np.linspace(0, 3, 61).tolist()],
}


class Run:
    """A vehicle on its own that follows stamps; rows of (time, x, y, θ, v, ω, φ, σ, pace)."""

    def __init__(
        self,
        stamps: Any,
        vehicle: Vehicle,
        tracking: Tracking | None = None,
        slip: tuple[float, float] = (1, 1),
        start: tuple[float, float, float] | None = None,
        dt: float = DT,
    ) -> None:
        self.stamps = np.array(stamps, dtype=np.float64)
        self.tracking = tracking or tracking_for(ROBOT, vehicle, dt)
        self.kinds, self.params = tables([vehicle])
        self.tuning = tuning([self.tracking])
        self.first = np.array([0, len(self.stamps)])
        self.course = np.zeros((len(self.stamps), COLUMNS))
        lay_courses(self.stamps, self.first, self.kinds, self.params, self.tuning, self.course)
        self.state = np.zeros((1, 6))
        heading = math.atan2(self.course[0, TO_Y], self.course[0, TO_X])
        self.state[0, :3] = (*self.stamps[0, 1:], heading) if start is None else start
        self.leg, self.pace, self.trim, self.progress = self.first[:-1].copy(), np.zeros(1), np.zeros(1), np.zeros(1)
        self.out, self.slip, self.dt, self.time = np.zeros((1, 2)), np.array([slip], dtype=np.float64), dt, 0.0
        self.rows: list[list[float]] = []

    def go(self, seconds: float, bound: float = math.inf, dead: bool = False) -> Floats:
        """Drive on, and return all rows so far."""
        for _ in range(round(seconds / self.dt)):
            self.time += self.dt
            advance(
                0, self.kinds, self.params, self.tuning, self.state, self.course, self.first, self.leg, self.pace,
                self.progress, bound, self.time, self.dt,
            )  # fmt: skip
            command(
                0, self.kinds, self.params, self.tuning, self.state, self.course, self.first, self.leg, self.pace,
                self.trim, self.progress, self.dt, self.out,
            )  # fmt: skip
            if dead:
                self.out[:] = 0.0
            move(0, self.kinds, self.params, self.state, self.out, self.slip, self.dt)
            self.rows.append([self.time, *self.state[0], self.progress[0], self.pace[0]])
        return self.table

    @property
    def table(self) -> Floats:
        """All rows so far."""
        return np.array(self.rows)

    @property
    def stray(self) -> float:
        """Greatest distance from the path, metres."""
        path = shapely.LineString(self.stamps[:, 1:]) if len(self.stamps) > 1 else shapely.Point(self.stamps[0, 1:])
        return float(shapely.distance(path, shapely.points(self.table[:, 1:3])).max())

    @property
    def lag(self) -> Floats:
        """Distance from the reference at every instant, metres."""
        times, x, y = self.stamps.T
        rows = self.table
        to_x, to_y = np.interp(rows[:, 7], times, x), np.interp(rows[:, 7], times, y)
        deviations: Floats = np.hypot(to_x - rows[:, 1], to_y - rows[:, 2])
        return deviations

    @property
    def miss(self) -> float:
        """Distance from the goal now, metres."""
        return math.dist(self.state[0, :2], self.stamps[-1, 1:])


# Pure pursuit


@settings(deadline=None)
@given(radius=st.floats(0.8, 50), angle=st.floats(0, 6), side=st.sampled_from([-1, 1]))
def test_pure_pursuit_on_a_circle_has_the_circles_curvature(radius: float, angle: float, side: int) -> None:
    # the place one look-ahead on along the circle is a corner of the path, so the chord is exact
    turn = side * 2 * math.asin(0.5 / radius)
    path = [(radius * math.cos(angle + k * turn), radius * math.sin(angle + k * turn)) for k in range(4)]
    heading = angle + side * math.pi / 2
    found = pursue(PurePursuit(1.0, 0.7, 10.0), path, (*path[0], heading))
    assert found.target == pytest.approx(path[1], abs=1e-9)
    assert found.turn_rate == pytest.approx(side * 0.7 / radius, rel=1e-9)


@settings(deadline=None)
@given(
    pose=st.tuples(st.floats(-3, 8), st.floats(-3, 3), st.floats(-3.2, 3.2)),
    path=st.lists(st.tuples(eighths, eighths), min_size=2, max_size=6),
)
def test_pure_pursuit_drives_the_arc_through_its_target(
    pose: tuple[float, float, float], path: list[tuple[float, float]]
) -> None:
    found = pursue(PurePursuit(1.0, 1.0, 100.0), path, pose)
    away = math.dist(found.target, pose[:2])
    assert shapely.distance(shapely.LineString(path), shapely.Point(found.target)) < 1e-9
    bearing = math.atan2(found.target[1] - pose[1], found.target[0] - pose[0]) - pose[2]
    if away > 1e-6 and math.cos(bearing) > 1e-6:
        assert found.turn_rate == pytest.approx(2 * math.sin(bearing) / max(away, 1.0), abs=1e-6)
    if away < 1 - 1e-9:
        assert found.target == pytest.approx(path[-1], abs=1e-12), "only the end of the path is nearer"


def test_a_pure_pursuit_returns_to_a_line_as_the_linear_equation_says() -> None:
    settings_, y0, dt = PurePursuit(0.5, 1.0, 100.0), 1e-3, 1e-3
    kinds, params = tables([Unicycle(10.0, 100.0)])
    state, out, slip = np.array([[0.0, y0, 0, 0, 0, 0]]), np.zeros((1, 2)), np.ones((1, 2))
    rate = 1.0 / 0.5  # both the damping and the frequency of y'' = −2 r y' − 2 r² y
    for k in range(2000):
        t = k * dt
        wanted = y0 * math.exp(-rate * t) * (math.cos(rate * t) + math.sin(rate * t))
        assert state[0, 1] == pytest.approx(wanted, abs=5e-3 * y0)
        found = pursue(settings_, [(-1, 0), (9, 0)], state[0, :3])
        out[0] = found.speed, found.turn_rate
        move(0, kinds, params, state, out, slip, dt)


def test_a_pursuit_follows_a_path_that_crosses_itself_in_order() -> None:
    path = [(0, 0), (4, 0), (4, 3), (2, 3), (2, -3)]
    kinds, params = tables([Unicycle(1.0, 4.0)])
    state, slip, leg, visited = np.zeros((1, 6)), np.ones((1, 2)), 0, []
    for _ in range(1200):
        found = pursue(PurePursuit(0.4, 1.0, 4.0), path, state[0, :3], leg)
        leg = found.leg
        visited.append(leg)
        move(0, kinds, params, state, np.array([[found.speed, found.turn_rate]]), slip, 0.01)
    assert sorted(set(visited)) == [0, 1, 2, 3]
    assert visited == sorted(visited)
    assert visited.index(1) > 300, "the crossing at (2, 0) is not where the third leg begins"


def test_the_look_ahead_grows_with_speed() -> None:
    found = pursue(PurePursuit(0.5, 1.0, lookahead_time=0.75), [(0, 0), (9, 0)], (0, 0, 0), moving=2.0)
    assert found.target == pytest.approx((2.0, 0.0))
    assert pursue(PurePursuit(0.5, 1.0, lookahead_time=0.75), [(0, 0), (9, 0)], (0, 0, 0)).target[0] == 1.25


def test_a_pursuit_turns_at_its_limit_and_towards_what_lies_behind() -> None:
    limited = PurePursuit(1.0, 1.0, 0.5)
    assert pursue(limited, [(0, 0), (9, 0)], (0, 0.9, 0)).turn_rate == -0.5
    assert pursue(limited, [(-9, 0.1), (-0.9, 0.1)], (0, 0, 0)).turn_rate == 0.5
    assert pursue(limited, [(1, 1), (1, 1)], (1, 1, 0)).turn_rate == 0.0


@pytest.mark.parametrize(
    ("wrong", "error", "words"),
    [
        (lambda: PurePursuit(lookahead=0), SceneError, "lookahead must be positive"),
        (lambda: PurePursuit(top_turn_rate=0), SceneError, "top turn rate must be positive"),
        (lambda: PurePursuit(speed=math.nan), SceneError, "speed must be positive"),
        (lambda: PurePursuit(lookahead_time=-1), SceneError, "lookahead time must be positive"),
        (lambda: pursue(PurePursuit(), [(0, 0)], (0, 0, 0)), ValueError, "at least two rows"),
        (lambda: pursue(PurePursuit(), [(0, 0), (1, 0)], (0, 0)), ValueError, "three finite numbers"),
        (lambda: pursue(PurePursuit(), [(0, 0), (1, 0)], (0, 0, 0), 1), IndexError, "leg 1"),
        (lambda: pursue(PurePursuit(), [(0, 0), (1, 0)], (0, 0, 0), 0, math.inf), ValueError, "must be finite"),
        (lambda: Tracking(gain=0), SceneError, "gain must be positive"),
        (lambda: Tracking(slack=0.2, leash=0.1), SceneError, "leash must be longer"),
        (lambda: Tracking(hurry=0.9), SceneError, "hurry must be at least 1"),
        (lambda: progress_rate(-1.0, Tracking()), ValueError, "not negative"),
        (lambda: progress_rate(math.nan, Tracking()), ValueError, "not negative"),
    ],
)
def test_bad_settings_are_refused_in_one_line(wrong: Any, error: type[Exception], words: str) -> None:
    with pytest.raises(error, match=words) as caught:
        wrong()
    assert "\n" not in str(caught.value)


# The tracker


@pytest.mark.parametrize("speed", [0.1, 1.0, 3.0])
def test_the_tracker_returns_to_a_straight_leg_critically_damped_at_every_speed(speed: float) -> None:
    gain, y0, seconds = 2.0, 1e-4, 4.0
    vehicle = Unicycle(2 * speed, 100.0)
    tracking = replace(Tracking(), gain=gain, leash=10.0, slack=9.0, tolerance=1e-3, aligned=1.0)
    run = Run([(0, 0, 0), (100, 100 * speed, 0)], vehicle, tracking, start=(0, y0, 0), dt=1e-3)
    rows = run.go(seconds)
    t = rows[:, 0]
    wanted = y0 * (1 + 2 * gain * t) * np.exp(-2 * gain * t)
    np.testing.assert_allclose(rows[:, 2], wanted, atol=0.02 * y0)
    np.testing.assert_allclose(rows[-1, 1], speed * seconds, atol=1e-3 * speed * seconds)


@pytest.mark.parametrize("slip", [(1.0, 1.0), (0.8, 0.8), (1.2, 1.2), (0.97, 1.03)])
@pytest.mark.parametrize("name", COURSES)
@pytest.mark.parametrize("kind", ["integrator", "unicycle", "differential"])
def test_vehicles_that_turn_on_the_spot_keep_near_the_path_and_reach_the_goal(
    kind: str, name: str, slip: tuple[float, float]
) -> None:
    run = Run(COURSES[name], vehicle_for(ROBOT, kind), slip=slip)
    run.go(2.5 * run.stamps[-1, 0] + 8)
    assert run.progress[0] == run.stamps[-1, 0]
    assert run.miss <= run.tracking.tolerance
    assert abs(run.state[0, 3]) < 1e-6, "it stands"
    assert run.stray <= (0.012 if slip == (1.0, 1.0) else 0.04)
    assert run.lag.max() <= run.tracking.leash


@pytest.mark.parametrize("kind", ["unicycle", "differential"])
def test_sharp_corners_are_turned_on_the_spot(kind: str) -> None:
    run = Run(COURSES["corner"], vehicle_for(ROBOT, kind))
    run.go(10)
    rows = run.table
    turning = (rows[:, 3] > 0.1) & (rows[:, 3] < math.pi / 2 - 0.1)
    assert turning.any()
    assert np.hypot(rows[turning, 1] - 3, rows[turning, 2]).max() <= run.tracking.tolerance
    assert run.stray <= 0.003


@pytest.mark.parametrize("slip", [(1.0, 1.0), (0.8, 0.8), (1.2, 1.2)])
@pytest.mark.parametrize(("radius", "bend", "count"), [(0.11, 1.3, 12), (0.3, 3.1, 20), (1.5, 3.1, 60)])
@pytest.mark.parametrize("kind", ["integrator", "unicycle", "differential"])
def test_arcs_of_many_short_legs_are_taken_as_one_turn(
    kind: str, radius: float, bend: float, count: int, slip: tuple[float, float]
) -> None:
    stamps, heading = [(0.0, 0.0, 0.0), (2.0, 2.0, 0.0)], 0.0
    for length in [radius * bend / count] * count + [2.0]:
        heading += bend / count
        t, x, y = stamps[-1]
        stamps.append((t + length, x + length * math.cos(heading), y + length * math.sin(heading)))
    run = Run(stamps, vehicle_for(ROBOT, kind), slip=slip)
    run.go(2 * stamps[-1][0] + 6)
    assert run.miss <= run.tracking.tolerance
    assert run.stray <= 0.03


@pytest.mark.parametrize("kind", KINDS)
def test_a_robot_without_trouble_keeps_the_clock_but_for_its_accelerations(kind: str) -> None:
    run = Run(COURSES["line"], vehicle_for(ROBOT, kind))
    rows = run.go(8)
    cruising = (rows[:, 0] > 3.0) & (rows[:, 0] < 4.0)
    assert np.abs(rows[cruising, 7] - rows[cruising, 0]).max() < 5e-3, "it has made up for the start"
    assert run.lag[cruising].max() < 2e-3
    arrived = rows[np.flatnonzero(run.lag + 5.0 - np.minimum(rows[:, 7], 5.0) > 0.005)[-1] + 1, 0]
    assert 5.0 < arrived < 5.5


@settings(deadline=None, max_examples=30)
@given(data=st.data())
def test_progress_never_goes_back_nor_too_fast_nor_beyond_the_clock_and_the_bound(data: st.DataObject) -> None:
    legs = data.draw(
        st.lists(st.tuples(st.floats(0.2, 2), st.floats(-3.1, 3.1), st.booleans()), min_size=1, max_size=6)
    )
    stamps = [(0.0, 0.0, 0.0)]
    for length, heading, rests in legs:
        t, x, y = stamps[-1]
        if rests:
            stamps.append((t + length, x, y))
        else:
            stamps.append((t + length, x + length * math.cos(heading), y + length * math.sin(heading)))
    kind = data.draw(st.sampled_from(KINDS))
    slip = data.draw(st.sampled_from([(1.0, 1.0), (0.8, 0.8), (1.2, 1.2)]))
    bounds = data.draw(st.lists(st.floats(0, stamps[-1][0]), max_size=3))
    run = Run(stamps, vehicle_for(ROBOT, kind), slip=slip)
    for bound in sorted(bounds):
        rows = run.go(2.0, bound)
        assert rows[-1, 7] <= bound
    rows = run.go(2.5 * stamps[-1][0] + 4 * len(stamps) + 6)
    steps = np.diff(rows[:, 7], prepend=0.0)
    assert (steps >= 0).all()
    assert steps.max() <= run.tracking.hurry * DT * (1 + 1e-9)
    assert (rows[:, 7] <= rows[:, 0]).all()
    assert rows[-1, 7] == stamps[-1][0], "it arrives"
    if kind != "ackermann":
        assert run.miss <= run.tracking.tolerance
        assert run.stray <= 0.06


@pytest.mark.parametrize("kind", KINDS)
def test_a_robot_that_is_held_stops_there_and_goes_on_when_it_may(kind: str) -> None:
    run = Run(COURSES["line"], vehicle_for(ROBOT, kind))
    rows = run.go(6.0, bound=2.0)
    assert rows[-1, 7] <= 2.0
    assert rows[-1, 7] > 1.99
    assert rows[:, 1].max() <= 2.0 + run.tracking.tolerance, "it brakes in time"
    assert abs(rows[-1, 4]) < 1e-6
    run.go(10.0)
    assert run.progress[0] == 5.0
    assert run.miss <= run.tracking.tolerance


@pytest.mark.parametrize("kind", KINDS)
def test_the_reference_of_a_dead_robot_stays_within_the_leash_for_ever(kind: str) -> None:
    run = Run([(0, 0, 0), (50, 50, 0)], vehicle_for(ROBOT, kind))
    run.go(3.0)
    run.go(20.0, dead=True)
    stands = run.progress[0]
    assert run.lag[-1] <= run.tracking.leash
    run.go(20.0, dead=True)
    assert run.progress[0] - stands < 1e-6
    run.go(60.0)
    assert run.miss <= run.tracking.tolerance, "and it goes on if it lives again"


@given(lag=st.floats(0, 1))
def test_the_pace_is_a_pure_function_of_the_lag(lag: float) -> None:
    tracking = Tracking(slack=0.1, leash=0.5)
    assert progress_rate(lag, tracking) == pytest.approx(np.interp(lag, [0.1, 0.5], [1.0, 0.0]), abs=1e-12)


@pytest.mark.parametrize("kind", KINDS)
@pytest.mark.parametrize("stamps", [[(0, 1, 2)], [(0, 1, 2), (5, 1, 2)]])
def test_who_never_moves_stands(kind: str, stamps: list[tuple[float, float, float]]) -> None:
    run = Run(stamps, vehicle_for(ROBOT, kind))
    rows = run.go(6.0)
    assert np.array_equal(rows[:, 1:7], np.tile([1.0, 2.0, 0, 0, 0, 0], (len(rows), 1)))


@pytest.mark.parametrize("kind", ["unicycle", "differential"])
def test_who_looks_the_wrong_way_turns_first(kind: str) -> None:
    run = Run(COURSES["line"], vehicle_for(ROBOT, kind), start=(0.0, 0.0, 3.0))
    rows = run.go(12.0)
    assert run.miss <= run.tracking.tolerance
    assert rows[:, 1].min() > -0.005
    assert run.stray < 0.005


def test_a_truck_rounds_corners_and_stops_level_with_its_goal() -> None:
    truck = vehicle_for(ROBOT, "ackermann")
    assert isinstance(truck, Ackermann)
    for name in ("line", "corner", "slight bend", "rest at a corner", "staircase", "many short legs"):
        run = Run(COURSES[name], truck)
        rows = run.go(2.5 * run.stamps[-1, 0] + 8)
        assert run.progress[0] == run.stamps[-1, 0]
        assert run.miss <= 0.25 * truck.turning_radius
        assert run.stray <= 0.6 * truck.turning_radius
        assert (rows[:, 4] >= -1e-12).all(), "it drives forward only"
        assert (np.abs(rows[:, 5]) <= np.abs(rows[:, 4]) / truck.turning_radius + 1e-9).all()


def test_a_truck_turns_back_in_a_loop() -> None:
    truck = vehicle_for(ROBOT, "ackermann")
    assert isinstance(truck, Ackermann)
    run = Run(COURSES["there and back"], truck)
    run.go(20)
    assert run.progress[0] == 4.0
    assert run.miss <= 0.4 * truck.turning_radius
    assert abs(math.cos(run.state[0, 2]) + 1) < 0.05


@pytest.mark.parametrize("kind", KINDS)
def test_vehicles_without_inertia_are_followed_as_well(kind: str) -> None:
    vehicle = replace(vehicle_for(ROBOT, kind), acceleration=math.inf)
    for name in ("corner", "rest at a corner"):
        run = Run(COURSES[name], vehicle)
        run.go(2.5 * run.stamps[-1, 0] + 8)
        assert run.progress[0] == run.stamps[-1, 0]
        assert np.isfinite(run.table).all()
        assert run.stray <= (0.13 if kind == "ackermann" else 0.04)


@pytest.mark.parametrize("scale", [1e-3, 1e3])
def test_large_and_small_worlds_are_followed_alike(scale: float) -> None:
    robot = replace(ROBOT, radius=0.15 * scale, speed=scale)
    stamps = np.array(COURSES["corner"]) * (1, scale, scale)
    vehicle = vehicle_for(robot, "differential")
    run = Run(stamps, vehicle, tracking_for(robot, vehicle, DT))
    run.go(12)
    assert run.miss <= run.tracking.tolerance
    assert run.stray <= 0.012 * scale
