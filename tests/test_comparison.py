"""Comparisons: every number is true, no way is taken at its word, and the same seed gives the same."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import shapely
from matplotlib.figure import Figure

from taut import comparison as room
from taut.comparison import (
    Comparison,
    Trial,
    compare,
    compare_clearances,
    compare_random,
    summary,
    with_clearance,
)
from taut.errors import NoPath, OutputError, SceneError
from taut.figures.comparison import draw_clearances, draw_comparison, draw_distributions, save_comparison
from taut.formats import load_scene, scene_names
from taut.generate.likeness import scene_like
from taut.geometry.growth import grown
from taut.route.core import Route
from taut.route.ways import WAYS, Answer, Prepared
from taut.scene import Circle, Line, Polygon, Rectangle, Robot, Scene
from taut.validation import validate

BOX = Rectangle(3, 0, 2, 3, name="box")
ROOM = Scene(
    (0, 0, 8, 6),
    [BOX, Polygon([(6, 4), (7, 4), (6.5, 5.5)], name="tri")],
    [Robot("R1", (1, 1), (7, 1)), Robot("R2", (1, 5), (7.5, 2), radius=0.2), Robot("R3", (7, 2), (1, 2), radius=0.2)],
    name="room",
    clearance=0.1,
    gap=0.1,
)
WALLED = Scene(
    (0, 0, 8, 4),
    [Rectangle(3, -1, 2, 6, name="wall")],
    [Robot("R1", (1, 1), (7, 1)), Robot("R2", (1, 3), (2, 2)), Robot("R3", (4, 2), (1, 2))],
    gap=0.1,
)


def trials(found: Comparison) -> Mapping[tuple[str, str], Trial]:
    return {(entry.way, trial.robot): trial for entry in found.entries for trial in entry.trials}


def made_up(monkeypatch: pytest.MonkeyPatch, *routes: list[tuple[float, float]]) -> list[str]:
    """Make "liar" the only way: it gives the robots of the scene these routes; return what it is called for."""
    calls: list[str] = []

    def way(scene: Scene, growth: float, seed: int) -> Prepared:
        calls.append(f"build {growth:g}")

        def ask(robot: Robot) -> Answer:
            calls.append(robot.name)
            if len(scene.robots) != len(routes):  # the small scene for warming up
                raise NoPath(robot.name, "not me")
            return Answer(Route(np.array(routes[scene.robots.index(robot)], dtype=np.float64)), 1, lambda: (3, 2))

        return Prepared(None, ask)

    monkeypatch.setattr(room, "WAYS", {"liar": way})
    return calls


def untimed(found: Comparison) -> list[Any]:
    """All of a comparison but how long it took."""
    return [
        [found.scene, found.seed, found.shortest.tolist(), dict(found.blocked)],
        *(
            {**vars(trial), "seconds": 0, "points": None if trial.points is None else trial.points.tolist()}
            for entry in found.entries
            for trial in entry.trials
        ),
    ]


@pytest.fixture(scope="module")
def everything() -> Comparison:
    return compare(ROOM)


def test_every_way_is_there_with_every_robot(everything: Comparison) -> None:
    assert [entry.way for entry in everything.entries] == list(WAYS)
    for entry in everything.entries:
        assert [trial.robot for trial in entry.trials] == ["R1", "R2", "R3"]


def test_numbers_are_those_of_the_routes(everything: Comparison) -> None:
    bodies = shapely.union_all([shapely.Polygon(obstacle.core) for obstacle in ROOM.obstacles])
    wall = shapely.Polygon(ROOM.workspace).exterior
    found = trials(everything)
    assert sum(trial.solved for trial in found.values()) >= 3 * 5
    for (_, name), trial in found.items():
        if trial.points is None:
            continue
        robot = next(r for r in ROOM.robots if r.name == name)
        route = shapely.LineString(trial.points)
        assert trial.length == pytest.approx(route.length, rel=1e-14)
        if trial.solved:
            room_left = min(route.distance(bodies), route.distance(wall)) - robot.radius
            assert trial.clearance == pytest.approx(room_left, abs=1e-9)
            assert room_left >= 0.1 - 1e-9
            assert tuple(trial.points[0]) == robot.start
            assert tuple(trial.points[-1]) == robot.goal


def test_no_solved_route_is_shorter_than_the_shortest(everything: Comparison) -> None:
    for (way, name), trial in trials(everything).items():
        if not trial.solved:
            assert trial.ratio is None, (way, name)
            continue
        assert trial.ratio is not None
        assert trial.ratio >= 1 - 1e-12, (way, name)
        if way in ("visibility", "oca"):
            assert trial.ratio == pytest.approx(1, abs=1e-12)


def test_length_turns_and_turning_of_a_corner_are_those_of_its_triangle() -> None:
    scene = Scene((0, 0, 8, 6), [BOX], [Robot("R1", (1, 1), (7, 1))])
    trial = trials(compare(scene, ["visibility"]))["visibility", "R1"]
    assert trial.turns == 2
    assert trial.length == pytest.approx(2 + 2 * math.sqrt(8))
    assert trial.turning == pytest.approx(math.pi / 2)
    assert trial.clearance == 0
    assert (trial.vertices, trial.obstacles) == (4, 1)


@pytest.mark.parametrize(
    ("route", "turns", "turning"),
    [
        ([(1, 5), (2, 5), (2, 5), (7, 5)], 0, 0),
        ([(1, 5), (2, 5.1), (3, 5.2), (4, 5.3), (7, 5)], 1, math.atan(0.1) + math.atan(0.1)),
        ([(1, 5), (4, 5), (2, 5), (7, 5)], 2, 2 * math.pi),
        ([(1, 5), (1, 4), (2, 4), (2, 5), (7, 5)], 3, 1.5 * math.pi),
    ],
)
def test_turns_count_bends_and_turning_adds_their_angles(
    monkeypatch: pytest.MonkeyPatch, route: list[tuple[float, float]], turns: int, turning: float
) -> None:
    scene = Scene((0, 0, 8, 6), [BOX], [Robot("R1", (1, 5), (7, 5)), Robot("R2", (1, 5.5), (7, 5.5))], gap=0.1)
    made_up(monkeypatch, route, [(1, 5.5), (7, 5.5)])
    trial = trials(compare(scene))["liar", "R1"]
    assert trial.solved
    assert trial.turns == turns
    assert trial.turning == pytest.approx(turning, abs=1e-12)


def test_no_way_is_taken_at_its_word(monkeypatch: pytest.MonkeyPatch) -> None:
    through, short, near = [(1, 1), (7, 1)], [(1, 5), (2, 5)], [(7, 2), (5.25, 3), (5.0, 3.2), (3.0, 3.2), (1, 2)]
    made_up(monkeypatch, through, short, near)  # type: ignore[arg-type]
    first, second, third = compare(replace(ROOM, clearance=0.0)).entries[0].trials
    assert not first.solved
    assert first.reason == "passes 1 m deep through box at (4, 1)"
    assert first.ratio is None
    assert first.length == 6
    assert not second.solved
    assert "from its goal at (2, 5)" in second.reason
    assert not third.solved
    assert "too near to box at (" in third.reason
    assert summary(compare(replace(ROOM, clearance=0.0)).entries[0]).solved == 0


def test_steps_too_short_for_their_time_are_proved_too(monkeypatch: pytest.MonkeyPatch) -> None:
    tiny = math.nextafter(7.0, 0.0)
    made_up(monkeypatch, [(1, 5), (tiny, 5), (7, 5)], [(1, 5.5), (7, 5.5)])
    robots = [Robot("R1", (1, 5), (7, 5), speed=1e6), Robot("R2", (1, 5.5), (7, 5.5), start_time=3)]
    assert all(trial.solved for trial in compare(Scene((0, 0, 8, 6), [], robots, gap=0.1)).entries[0].trials)


def test_ways_are_built_once_a_growth_and_asked_once_more_than_timed(monkeypatch: pytest.MonkeyPatch) -> None:
    calls = made_up(monkeypatch, *[[(1.0, 1.0)]] * 3)
    compare(ROOM, repeats=3)
    assert calls[-14:] == ["build 0.1", *["R1"] * 4, "build 0.3", *["R2"] * 4, *["R3"] * 4]


def test_unsolvable_robots_are_told_in_words() -> None:
    found = compare(WALLED)
    for (way, name), trial in trials(found).items():
        assert trial.solved == (name == "R2") or way in ("potential", "ca"), (way, name)
        if name == "R1":
            assert not trial.solved
            assert trial.reason
            assert not trial.reason.startswith("R1")
        if name == "R3":
            assert not trial.solved
            assert "wall" in trial.reason
    assert np.isnan(found.shortest).tolist() == [True, False, True]
    assert set(found.blocked) == {"R3"}
    total = summary(found.entries[0])
    assert (total.solved, total.robots) == (1, 3)
    assert total.worst_ratio == pytest.approx(1, abs=1e-12)
    assert total.length == pytest.approx(math.sqrt(2))


def test_summaries_without_anything_solved_hold_none() -> None:
    scene = replace(WALLED, robots=WALLED.robots[:1])
    total = summary(compare(scene, ["visibility"]).entries[0])
    assert (total.solved, total.robots) == (0, 1)
    assert (total.mean_ratio, total.worst_ratio, total.length, total.mean_clearance, total.mean_turns) == (None,) * 5
    assert total.query_seconds is not None


def test_empty_team_and_a_robot_at_its_goal() -> None:
    empty = compare(replace(ROOM, robots=()))
    assert all(entry.trials == () and entry.build_seconds == 0 for entry in empty.entries)
    assert summary(empty.entries[0]).query_seconds is None
    still = trials(compare(replace(ROOM, robots=(Robot("R1", (1, 1), (1, 1)),))))
    assert all(trial.solved and (trial.length, trial.ratio, trial.turns) == (0, 1, 0) for trial in still.values())


def test_the_same_seed_gives_the_same() -> None:
    ways = ["prm", "lazy-prm", "visibility"]
    assert untimed(compare(ROOM, ways, seed=3)) == untimed(compare(ROOM, ways, seed=3))
    assert untimed(compare(ROOM, ways, seed=3)) != untimed(compare(ROOM, ways, seed=4))


def test_random_scenes_follow_the_seed() -> None:
    ways = ["visibility", "prm"]
    found = compare_random(ROOM, 3, ways, seed=5)
    assert [one.scene for one in found] == [scene_like(ROOM, seed) for seed in (5, 6, 7)]
    assert untimed(found[1]) == untimed(compare_random(ROOM, 1, ways, seed=6)[0])
    assert untimed(found[1]) == untimed(compare(found[1].scene, ways, seed=6))
    assert all(entry.roadmaps == {} for one in found for entry in one.entries)
    assert all(trial.solved for one in found for trial in trials(one).values())


@pytest.mark.parametrize("name", scene_names())
def test_random_scenes_are_like_their_model(name: str) -> None:
    model = load_scene(name)
    made = scene_like(model, 1)
    validate(made)
    assert (len(made.robots), len(made.obstacles)) == (len(model.robots), len(model.obstacles))
    assert (made.gap, made.at_goal, made.headway) == (model.gap, model.at_goal, model.headway)
    for what in ("radius", "speed"):
        known = [getattr(robot, what) for robot in model.robots]
        assert all(min(known) <= getattr(robot, what) <= max(known) for robot in made.robots)
    kinds = {type(obstacle) for obstacle in model.obstacles}
    if kinds == {Circle} or kinds == {Line}:
        assert {type(obstacle) for obstacle in made.obstacles} <= kinds
    if made.workspace[2] == model.workspace[2] and model.obstacles:
        share = [shapely.union_all([grown(o, 0.0) for o in scene.obstacles]).area for scene in (model, made)]
        assert share[1] == pytest.approx(share[0], rel=0.25)


def test_length_grows_with_clearance_and_clearance_is_kept() -> None:
    asked = [0.0, 0.2, 0.4, 0.6, 0.8, 1.2]
    found = compare_clearances(ROOM, asked, ["visibility", "oca"])
    assert [one.scene.clearance for one in found] == asked
    for key in trials(found[0]):
        row = [trials(one)[key] for one in found]
        solved = [trial.solved for trial in row]
        assert solved == sorted(solved, reverse=True)
        lengths = [trial.length for trial in row if trial.length is not None]
        assert lengths == sorted(lengths)
        for clearance, trial in zip(asked, row, strict=True):
            assert trial.clearance is None or trial.clearance >= clearance - ROOM.tol
    why = found[-1].blocked["R1"]
    assert "start (1, 1) is only 1 m from the wall but needs 1.2 m" in why
    assert "at most 1 m" in why
    assert trials(found[-1])["visibility", "R1"].reason == why
    assert found[0].blocked == {}


def test_clearance_of_single_robots_is_set_too() -> None:
    scene = replace(ROOM, robots=(replace(ROOM.robots[0], clearance=0.7), *ROOM.robots[1:]))
    assert [with_clearance(scene, 0.25).growth(robot) for robot in with_clearance(scene, 0.25).robots] == [
        0.25,
        0.45,
        0.45,
    ]


@pytest.mark.parametrize(
    ("call", "words"),
    [
        (lambda: compare(ROOM, ["visibility", "teleport"]), "'teleport' is unknown, take from visibility"),
        (lambda: compare(ROOM, []), "must not be empty"),
        (lambda: compare(ROOM, seed=-1), "seed must be a whole number, at least 0, got -1"),
        (lambda: compare(ROOM, repeats=0), "repeats must be a whole number, at least 1"),
        (lambda: compare_random(ROOM, 0), "count must be a whole number, at least 1"),
        (lambda: compare_random(ROOM, 1.5), "count must be"),  # type: ignore[arg-type]
    ],
)
def test_misuse_is_said(call: Any, words: str) -> None:
    with pytest.raises(ValueError, match=words.replace("(", "\\(")):
        call()


def test_bad_scenes_and_clearances_are_refused() -> None:
    crossed = replace(ROOM, obstacles=(Polygon([(1, 1), (3, 3), (3, 1), (1, 3)], name="bow"),))
    for call in (lambda: compare(crossed), lambda: scene_like(crossed, 0), lambda: compare_clearances(crossed, [0])):
        with pytest.raises(SceneError, match="bow"):
            call()
    for bad in (-0.1, math.nan, math.inf):
        with pytest.raises(SceneError, match="clearance"):
            compare_clearances(ROOM, [0.1, bad])


# --- figures ---


def shades(figure: Figure) -> int:
    """How many colours a picture has."""
    figure.set_dpi(50)
    figure.canvas.draw()
    pixels = np.asarray(figure.canvas.buffer_rgba(), dtype=np.int64)  # type: ignore[attr-defined]
    return len(np.unique(pixels @ [1, 256, 256**2, 0]))


def test_maps_are_written_alike_each_time(tmp_path: Path) -> None:
    found = compare(ROOM, ["visibility", "cells"])
    for name in ("a.svg", "b.svg"):
        save_comparison(found, tmp_path / name)
    assert (tmp_path / "a.svg").read_bytes() == (tmp_path / "b.svg").read_bytes()
    with pytest.raises(OutputError, match=r"\.png"):
        save_comparison(found, tmp_path / "a.txt")


def test_every_way_has_its_map(everything: Comparison) -> None:
    figure = draw_comparison(everything)
    assert [axes.get_title(loc="left") for axes in figure.axes] == list(WAYS)
    assert figure.axes[0].get_title(loc="right") == "× 1.000 · 3 of 3 solved"
    assert shades(figure) > 100


def test_routes_that_are_not_allowed_are_drawn() -> None:
    none = compare(replace(WALLED, robots=WALLED.robots[:1]), ["visibility"])
    entry = none.entries[0]
    cut = replace(entry.trials[0], points=np.array([(1.0, 1.0), (7.0, 1.0)]))
    figures = [draw_comparison(found) for found in (none, replace(none, entries=(replace(entry, trials=(cut,)),)))]
    legends = [[text.get_text() for text in figure.legends[0].get_texts()] for figure in figures]
    assert [legend[-1] for legend in legends] == ["no route", "route not allowed"]
    assert shades(figures[0]) != shades(figures[1])


@pytest.mark.parametrize("robots", [0, 3, 6])
def test_spreads_and_sweeps_are_drawn_for_any_team(robots: int) -> None:
    team = [Robot(f"R{k}", (1, 0.5 + 0.9 * k), (7, 5.5 - 0.9 * k), radius=0.1) for k in range(robots)]
    scene = Scene((0, 0, 8, 6), [Circle((4, 3), 0.8)], team, name="team")
    least = 20 if robots else 5
    assert shades(draw_distributions(compare_random(scene, 2, ["visibility", "oca"]))) > least
    sweep = draw_clearances(compare_clearances(scene, [0, 0.3, 3], ["visibility", "oca"]))
    assert len(sweep.axes) == {0: 0, 3: 6, 6: 3}[robots]
    assert shades(sweep) > least
    assert shades(draw_clearances(compare_clearances(scene, [0.1], ["visibility"]))) > least


def test_curves_end_where_nothing_is_solved() -> None:
    asked = [0.0, 0.3, 0.6, 1.2]
    scene = replace(ROOM, robots=ROOM.robots[:1])
    found = compare_clearances(scene, asked, ["visibility"])
    above = draw_clearances(found).axes[0]
    drawn = np.asarray(above.lines[0].get_ydata(), dtype=np.float64)
    np.testing.assert_array_equal(drawn[:3], [one.entries[0].trials[0].length for one in found[:3]])
    assert np.isnan(drawn[3])
    assert len(above.patches) == 1  # and the rest is shaded


@pytest.mark.parametrize("name", ["thesis-1", "thesis-2", "thesis-3", "appendix-d", "hospital-12"])
def test_no_way_keeps_farther_from_everything_than_the_voronoi_roadmap(name: str) -> None:
    found = compare(load_scene(name))
    widest = next(entry for entry in found.entries if entry.way == "voronoi")
    roadmaps: Any = widest.roadmaps
    error = max(roadmap.error for roadmap in roadmaps.values())
    for entry in found.entries:
        for trial, best in zip(entry.trials, widest.trials, strict=True):
            if trial.clearance is not None:
                assert best.clearance is not None
                assert trial.clearance <= best.clearance + error + found.scene.tol
