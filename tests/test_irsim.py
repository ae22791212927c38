"""Worlds for ir-sim: the file holds scene and plan to the last bit, and its vehicles keep to a motion.

ir-sim itself is used where it is installed; what it does with commands is written down again here.
"""

from __future__ import annotations

import math
import sys
from dataclasses import replace
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
import shapely
import yaml
from hypothesis import given, settings
from hypothesis import strategies as st
from numpy.typing import NDArray

from taut.errors import OutputError, SceneError, TautError
from taut.formats import irsim
from taut.formats.irsim import irsim_text, replay_in_irsim, save_irsim
from taut.motion import Plan, Trajectory
from taut.scene import Circle, FloatArray, Line, Obstacle, Polygon, Rectangle, Robot, Scene

OBSTACLES: list[Obstacle] = [
    Polygon([(2, 2), (5, 2), (3, 3), (2, 5)], "notched"),
    Rectangle(6, 1, 2, 0.5, 0.3, "shelf"),
    Circle((8, 6), 0.7, "pillar"),
    Line([(1, 7), (3, 8), (5, 6.5)], 0.2, "wall"),
]


def plan_of(moves: dict[str, list[tuple[float, float, float]]], obstacles: Any = (), **fields: Any) -> Plan:
    """Return robots of radius 0.2 that move along these stamps in a hall of 10 m × 9 m."""
    robots = [Robot(name, stamps[0][1:], stamps[-1][1:], radius=0.2) for name, stamps in moves.items()]
    scene = Scene((-1, -2, 9, 7), obstacles, robots, **fields)
    return Plan(scene, tuple(Trajectory(name, np.array(stamps)) for name, stamps in moves.items()))


ALONE = {"R1": [(0.0, 0.0, 0.0), (2.0, 0.0, 0.0), (6.0, 4.0, 0.0), (9.0, 4.0, 3.0)]}


def read(plan: Plan, *more: Any, **numbers: Any) -> dict[str, Any]:
    """Return the file as ir-sim's own reader, PyYAML, reads it."""
    data = yaml.safe_load(irsim_text(plan, *more, **numbers))
    assert isinstance(data, dict)
    return data


def body(entry: dict[str, Any]) -> Any:
    """Return what an obstacle of the file covers, discs as finely as need be."""
    shape, (x, y, angle) = entry["shape"], entry["state"]
    match shape["name"]:
        case "circle":
            own = shapely.Point(0, 0).buffer(shape["radius"], quad_segs=512)
        case "rectangle":
            a, b = shape["length"] / 2, shape["width"] / 2
            own = shapely.box(-a, -b, a, b)
        case _:
            own = shapely.Polygon(shape["vertices"])
    turned = shapely.affinity.rotate(own, angle, origin=(0, 0), use_radians=True)
    return shapely.affinity.translate(turned, x, y)


def test_the_world_has_the_bounds_of_the_workspace_and_its_wall() -> None:
    corners = [(-1, -2), (9, -2), (9, 4), (4, 7), (-1, 7)]
    plan = plan_of(ALONE)
    data = read(replace(plan, scene=replace(plan.scene, workspace=corners)), step=0.05)  # type: ignore[arg-type]
    assert data["world"] == {"width": 10.0, "height": 9.0, "offset": [-1.0, -2.0], "step_time": 0.05}
    (wall,) = data["obstacle"]
    assert wall["shape"] == {"name": "linestring", "vertices": [list(map(float, c)) for c in [*corners, corners[0]]]}
    assert wall["state"] == [0.0, 0.0, 0.0]


def test_obstacles_cover_what_they_cover_in_the_scene() -> None:
    entries = [entry for entry in read(plan_of(ALONE, OBSTACLES))["obstacle"] if entry["name"] != irsim.WALL]
    for obstacle in OBSTACLES:
        parts = [body(e) for e in entries if e["name"].split("-")[0] == obstacle.name]
        whole = shapely.LineString(obstacle.core) if isinstance(obstacle, Line) else None
        whole = whole or (shapely.Polygon(obstacle.core) if obstacle.closed else shapely.Point(obstacle.core[0]))
        if obstacle.own_radius:
            whole = whole.buffer(obstacle.own_radius, quad_segs=512)
        assert shapely.union_all(parts).symmetric_difference(whole).area < 1e-5 * whole.area
    assert len({entry["name"] for entry in entries}) == len(entries) == 3 + 2 + 3


def test_robots_start_turned_to_where_they_go_and_visit_every_turn() -> None:
    (robot,) = read(plan_of({"R1": [(0.0, 0.0, 0.0), (1.0, 0.0, 0.0), (4.0, 0.0, 3.0), (9.0, 5.0, 3.0)]}))["robot"]
    assert robot["state"] == pytest.approx([0, 0, math.pi / 2])
    assert robot["goal"] == [[0.0, 3.0], [5.0, 3.0]]
    assert robot["shape"] == {"name": "circle", "radius": 0.2}
    assert robot["vel_max"] == [1.5, 4.0]


def test_a_robot_that_stays_has_its_place_as_its_goal() -> None:
    (robot,) = read(plan_of({"R1": [(0.0, 1.0, 2.0)]}))["robot"]
    assert robot["goal"] == [[1.0, 2.0]]


@pytest.mark.parametrize(("kinematics", "state"), [("omni", 3), ("diff", 3), ("acker", 4)])
def test_each_kind_of_vehicle_has_its_state(kinematics: Any, state: int) -> None:
    (robot,) = read(plan_of(ALONE), kinematics, wheelbase=0.3)["robot"]
    assert robot["kinematics"]["name"] == kinematics
    assert len(robot["state"]) == state
    assert (robot["kinematics"].get("wheelbase") == 0.3) == (kinematics == "acker")


NAMES = st.sampled_from(
    ["on", "No", "1", "1e5", "null", "~", "a: b", "- x", "ä λ2", "O1", "O1-2", "#", "the wall", "'"]
)
NUMBERS = st.floats(0.0, 6.5).map(lambda x: x if x > 1e-200 else 1e-9)


@settings(max_examples=60, deadline=None)
@given(st.lists(NAMES, min_size=1, max_size=5, unique=True), st.data())
def test_names_and_stamps_come_back_bit_for_bit(names: list[str], data: st.DataObject) -> None:
    moves = {}
    for name in names:
        places = data.draw(st.lists(st.tuples(NUMBERS, NUMBERS), min_size=1, max_size=4))
        moves[name] = [(k * (1 + 1e-9), *place) for k, place in enumerate(places)]
    obstacles = [Circle((1e-9, 8e-5), 1e-7, "O1"), Circle((1, 2), 0.1, "O2")]
    plan = plan_of(moves, obstacles)
    back = read(plan)
    assert {name: np.array(stamps).tolist() for name, stamps in back["custom"]["taut"].items()} == {
        t.name: t.stamps.tolist() for t in plan.trajectories
    }
    assert [robot["name"] for robot in back["robot"]] == names
    assert back["obstacle"][1]["state"] == [1e-9, 8e-5, 0.0]
    everything = [entry["name"] for entry in [*back["robot"], *back["obstacle"]]]
    assert len(set(everything)) == len(everything)


def test_the_file_is_the_text(tmp_path: Path) -> None:
    save_irsim(plan_of(ALONE, OBSTACLES), tmp_path / "world.yaml", "omni", step=0.1)
    assert (tmp_path / "world.yaml").read_text(encoding="utf-8") == irsim_text(
        plan_of(ALONE, OBSTACLES), "omni", step=0.1
    )
    with pytest.raises(OutputError):
        save_irsim(plan_of(ALONE), tmp_path / "nowhere" / "world.yaml")


def test_a_point_robot_is_refused_with_its_name() -> None:
    scene = Scene((0, 0, 4, 4), robots=[Robot("dot", (1, 1), (1, 1))])
    with pytest.raises(SceneError, match="robot dot: ir-sim needs a radius above 0"):
        irsim_text(Plan(scene, (Trajectory("dot", np.array([[0.0, 1, 1]])),)))


@pytest.mark.parametrize("numbers", [{"step": 0.0}, {"step": math.nan}, {"turning": -1.0}, {"wheelbase": 0.0}])
def test_numbers_that_make_no_sense_are_refused(numbers: dict[str, Any]) -> None:
    with pytest.raises(ValueError, match=f"{next(iter(numbers))} must be a positive number"):
        irsim_text(plan_of(ALONE), **numbers)
    with pytest.raises(ValueError, match="kinematics must be"):
        irsim_text(plan_of(ALONE), "hover")  # type: ignore[arg-type]


# --- replay


class World:
    """ir-sim in short: explicit Euler steps within limits, discs, no obstacles."""

    def __init__(self, path: str, **options: Any) -> None:
        assert options["headless"]
        data = yaml.safe_load(Path(path).read_text(encoding="utf-8"))
        self.world_param = SimpleNamespace(collision_mode="stop")
        self.step_time = data["world"]["step_time"]
        self.robot_list = [vehicle_of(robot) for robot in data["robot"]]

    def step(self, actions: list[list[float]], who: list[int]) -> None:
        """Move all by one step, and find who overlaps whom."""
        assert who == list(range(len(self.robot_list)))
        for vehicle, action in zip(self.robot_list, actions, strict=True):
            if not (vehicle.collision_obj and self.world_param.collision_mode == "stop"):
                vehicle.state = moved(vehicle, np.clip(action, vehicle.least, vehicle.most), self.step_time)
        for a in self.robot_list:
            others = [b for b in self.robot_list if b is not a and not b.unobstructed]
            a.collision_obj = [b for b in others if math.dist(a.state[:2, 0], b.state[:2, 0]) < a.radius + b.radius]


def vehicle_of(robot: dict[str, Any]) -> Any:
    vehicle = SimpleNamespace(
        name=robot["name"],
        model=robot["kinematics"],
        radius=robot["shape"]["radius"],
        least=robot["vel_min"],
        most=robot["vel_max"],
        state=np.array(robot["state"]).reshape(-1, 1),
        collision_obj=[],
        unobstructed=False,
    )

    def set_state(state: list[float], init: bool) -> None:
        assert len(state) == len(vehicle.state)
        vehicle.state = np.array(state, dtype=np.float64).reshape(-1, 1)

    vehicle.set_state = set_state
    return vehicle


def moved(vehicle: Any, action: FloatArray, step: float) -> FloatArray:
    x, y, heading, *steering = vehicle.state[:, 0]
    a, b = action
    if vehicle.model["name"] == "omni":
        return np.array([[x + a * step], [y + b * step], [heading]])
    there = [x + a * math.cos(heading) * step, y + a * math.sin(heading) * step]
    if vehicle.model["name"] == "diff":
        return np.array([*there, heading + b * step]).reshape(-1, 1)
    turn = a * math.tan(steering[0]) / vehicle.model["wheelbase"]
    return np.array([*there, heading + turn * step, b]).reshape(-1, 1)


@pytest.fixture(params=["told again here", "ir-sim"])
def simulator(request: pytest.FixtureRequest, monkeypatch: pytest.MonkeyPatch) -> None:
    if request.param == "ir-sim":
        pytest.importorskip("irsim")
    else:
        monkeypatch.setitem(sys.modules, "irsim", SimpleNamespace(make=World))


def figure_eight(step: float) -> tuple[Plan, FloatArray, FloatArray]:
    """Return a robot that drives two circles of 1 m, one to the left and one to the right, at 1 m/s."""
    times = np.arange(0, 4 * math.pi, step)
    turn = np.where(times < 2 * math.pi, times, 4 * math.pi - times)
    side = np.where(times < 2 * math.pi, 1.0, -1.0)
    places = np.stack([4 + np.sin(turn) * np.where(side > 0, 1, -1), 3 + side * (1 - np.cos(turn))], axis=1)
    places[times >= 2 * math.pi, 0] = 4 + np.sin(times[times >= 2 * math.pi])
    poses = np.column_stack([places, turn])[:, None]
    return plan_of({"R1": [(0.0, 4.0, 3.0), (1.0, 5.0, 3.0)]}), times, poses


@pytest.mark.usefixtures("simulator")
def test_what_moves_in_any_direction_follows_a_plan_to_rounding() -> None:
    plan = plan_of({**ALONE, "R2": [(0.0, 7.0, 6.0), (5.0, 4.0, 5.0), (8.0, 1.0, 5.0)]})
    times = np.arange(0, 10, 0.05)
    places = np.stack([t.at(times) for t in plan.trajectories], axis=1)
    replay = replay_in_irsim(plan, times, np.dstack([places, np.zeros(places.shape[:2])]), "omni")
    assert replay.errors.max() < 1e-12
    assert replay.poses[..., :2] == pytest.approx(places, abs=1e-12)
    assert replay.collisions == ()


@pytest.mark.usefixtures("simulator")
@pytest.mark.parametrize(("kinematics", "within"), [("diff", 0.006), ("acker", 0.03)])
def test_what_steers_follows_a_figure_eight(kinematics: Any, within: float) -> None:
    plan, times, poses = figure_eight(0.02)
    replay = replay_in_irsim(plan, times, poses, kinematics, wheelbase=0.25)
    assert replay.errors.max() < within
    finer = replay_in_irsim(plan, *figure_eight(0.01)[1:], kinematics, wheelbase=0.25)
    assert finer.errors.max() < 0.7 * replay.errors.max()


@pytest.mark.usefixtures("simulator")
def test_who_meets_whom_is_told_once_with_its_time_and_goes_on() -> None:
    plan = plan_of({"A": [(0.0, 0.0, 0.0), (4.0, 4.0, 0.0)], "B": [(0.0, 4.0, 0.0), (4.0, 0.0, 0.0)]})
    times = np.arange(0, 4, 0.02)
    places = np.stack([t.at(times) for t in plan.trajectories], axis=1)
    poses = np.dstack([places, np.broadcast_to([0.0, math.pi], places.shape[:2])])
    replay = replay_in_irsim(plan, times, poses)
    ((time, *pair),) = replay.collisions
    assert pair == ["A", "B"]
    # their centres are 0.4 m apart at 1.8 s
    assert time == pytest.approx(1.8, abs=0.05)
    assert replay.errors.max() < 0.01


@pytest.mark.usefixtures("simulator")
def test_who_has_left_is_in_nobodys_way() -> None:
    moves = {"A": [(0.0, 0.0, 0.0), (2.0, 2.0, 0.0)], "B": [(0.0, 6.0, 0.0), (6.0, 0.0, 0.0)]}
    times = np.arange(0, 7, 0.02)
    replays = {}
    for at_goal in ("stay", "leave"):
        plan = plan_of(moves, at_goal=at_goal)
        places = np.stack([t.at(times) for t in plan.trajectories], axis=1)
        poses = np.dstack([places, np.zeros(places.shape[:2])])
        replays[at_goal] = replay_in_irsim(plan, times, poses, "omni")
    assert [hit[1:] for hit in replays["stay"].collisions] == [("A", "B")]
    assert replays["leave"].collisions == ()
    assert max(replay.errors.max() for replay in replays.values()) < 1e-9


def motion() -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    return np.linspace(0, 0.4, 5), np.zeros((5, 1, 3))


@pytest.mark.parametrize("fault", ["one instant", "shape", "uneven", "backwards", "nan"])
def test_motions_that_make_no_sense_are_refused(fault: str) -> None:
    times, poses = motion()
    if fault == "one instant":
        times, poses = times[:1], poses[:1]
    elif fault == "shape":
        poses = poses[:, :, :2]
    elif fault == "uneven":
        times[2] += 0.01
    elif fault == "backwards":
        times = times[::-1]
    else:
        poses[3] = np.nan
    with pytest.raises(ValueError, match=r"^times"):
        replay_in_irsim(plan_of(ALONE), times, poses)


def test_without_irsim_it_is_said_how_to_get_it(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(sys.modules, "irsim", None)
    with pytest.raises(TautError, match=r"pip install 'taut\[irsim\]'"):
        replay_in_irsim(plan_of(ALONE), *motion())


def test_an_irsim_that_does_not_know_the_file_is_told(monkeypatch: pytest.MonkeyPatch) -> None:
    def refuse(*_: Any, **__: Any) -> None:
        raise KeyError("custom")

    monkeypatch.setitem(sys.modules, "irsim", SimpleNamespace(make=refuse))
    with pytest.raises(TautError, match=r"refuses the file, 2\.12 or later"):
        replay_in_irsim(plan_of(ALONE), *motion())
