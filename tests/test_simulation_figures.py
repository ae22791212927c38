"""Pictures of simulated runs: driven ways, collisions and errors are where they were, still and in motion."""

from __future__ import annotations

import math
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from matplotlib.axes import Axes
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.collections import LineCollection, PathCollection
from matplotlib.colors import to_hex, to_rgb
from matplotlib.figure import Figure
from numpy.typing import NDArray
from PIL import Image

from taut.errors import OutputError
from taut.figures import animate_run, draw, draw_run, save_figure
from taut.figures.simulation import COLLISION, COLUMNS, lateness, nearest_of
from taut.figures.style import robot_colours
from taut.motion import Plan, Trajectory
from taut.scene import Circle, FloatArray, Robot, Scene
from taut.simulation.detector import Detector
from taut.simulation.disturbances import Disturbances
from taut.simulation.running import Collision, Nearest, Run, Scans

FAINT = 60  # of 255: each film has a palette of its own
NOTHING = Nearest(math.inf, 0.0, (0.0, 0.0), "")


def run_of(n: int = 3, rows: int = 101, at_goal: Any = "stay", **fields: Any) -> Run:
    """Return robots abreast that drive 8 m at 1 m/s, 5 % too slow and robot k by k centimetres beside their way."""
    robots = [Robot(f"R{k}", (1, 1 + k), (9, 1 + k), radius=0.3) for k in range(n)]
    scene = Scene((0, 0, 10, n + 1), [], robots, name="abreast", at_goal=at_goal)
    moves = tuple(Trajectory(r.name, np.array([(0.0, *r.start), (8.0, *r.goal)])) for r in robots)
    times = np.linspace(0.0, 10.0, rows)
    progress = np.repeat(np.minimum(times / 1.05, 8.0)[:, None], n, axis=1)
    beside = 0.01 * np.arange(n) * np.sin(progress / 8 * math.pi)
    places = np.stack([1 + progress, 1 + np.arange(n) + beside], axis=-1)
    run = Run(
        plan=Plan(scene, moves),
        vehicles=(),
        seed=0,
        dt=0.02,
        disturbances=Disturbances(),
        coordinated=True,
        times=times,
        poses=np.dstack([places, np.zeros(progress.shape)]),
        progress=progress,
        strays=np.abs(beside),
        arrivals=np.full(n, 8.4),
        greatest_stray=np.abs(beside).max(axis=0),
        mean_stray=np.zeros(n),
        strayed_at=times[np.abs(beside).argmax(axis=0)],
        clearances=(NOTHING,) * n,
        separations=(NOTHING,) * n,
        collisions=(),
        waits=(),
        distance=np.full(n, 8.0),
        turned=np.zeros(n),
        work=np.zeros(n),
    )
    return replace(run, **fields)


CRASH = Collision(5.0, (5.0, 2.5), "R1", "R2", 0.01)
NEAR = Nearest(0.12, 3.0, (4.0, 1.5), "R1")


def texts(axes: Axes) -> list[str]:
    titles = [axes.get_title(loc=side) for side in ("left", "center", "right")]
    legend = axes.get_legend()
    labels = [] if legend is None else [text.get_text() for text in legend.get_texts()]
    return [*titles, *(text.get_text() for text in axes.texts), *labels]


def strips_of(axes: Axes) -> list[Axes]:
    figure = axes.get_figure(root=True)
    assert isinstance(figure, Figure)
    return [other for other in figure.axes if other is not axes]


def lines_of(axes: Axes, zorder: float) -> list[LineCollection]:
    return [c for c in axes.collections if isinstance(c, LineCollection) and c.get_zorder() == zorder]


def crosses_of(axes: Axes) -> FloatArray:
    marks = [c for c in axes.collections if isinstance(c, PathCollection) and c.get_zorder() == 9]
    return np.concatenate([np.empty((0, 2)), *(np.asarray(mark.get_offsets()) for mark in marks)])


# --- still pictures


def test_the_ways_drawn_are_those_driven() -> None:
    run = run_of()
    (lines,) = lines_of(draw_run(run), 6.2)
    assert [to_hex(c) for c in np.atleast_2d(lines.get_colors())] == robot_colours(3)
    for k, way in enumerate(lines.get_segments()):
        assert np.asarray(way) == pytest.approx(run.poses[:, k, :2])


def test_collisions_are_crossed_where_they_were_and_told() -> None:
    axes = draw_run(run_of(collisions=(CRASH,)))
    assert crosses_of(axes) == pytest.approx(np.array([CRASH.place]))
    assert "R1 hits R2\n5.0 s" in texts(axes)
    assert "collision" in texts(axes)
    for strip in strips_of(axes):
        red = [line for line in strip.lines if to_hex(line.get_color()) == COLLISION]
        assert [np.asarray(line.get_xdata()).tolist() for line in red] == [[5.0, 5.0]]


def test_many_collisions_are_crossed_but_not_told_one_by_one() -> None:
    axes = draw_run(run_of(collisions=tuple(replace(CRASH, time=k / 10) for k in range(30))))
    assert len(crosses_of(axes)) == 30
    assert not any("hits" in text for text in texts(axes))
    assert any("30 collisions" in text for text in texts(axes))


def test_the_nearest_encounter_is_told_where_nobody_collided() -> None:
    near = run_of(separations=(NEAR, NOTHING, NOTHING), clearances=(replace(NEAR, distance=0.2), NOTHING, NOTHING))
    assert nearest_of(near) == ("R0", NEAR)
    told = "R0–R1\n0.12 m, 3.0 s"
    assert told in texts(draw_run(near))
    assert told not in texts(draw_run(replace(near, collisions=(CRASH,))))
    assert nearest_of(run_of()) is None


def test_the_title_says_who_arrived_and_when() -> None:
    assert "last arrival 8.4 s, planned 8.0 s · no collision" in texts(draw_run(run_of()))
    late = run_of(arrivals=np.array([8.4, math.nan, 8.4]))
    assert "2 of 3 arrived · no collision" in texts(draw_run(late))


def test_who_did_not_arrive_is_shown_where_it_stands() -> None:
    run = run_of(arrivals=np.array([8.4, math.nan, math.nan]), disturbances=Disturbances(dies={"R1": 4.0}))
    axes = draw_run(run)
    assert {"R1 died at 4 s", "R2 did not come to its goal"} <= set(texts(axes))
    bodies = [c for c in axes.collections if c.get_zorder() == 8]
    (places,) = [np.asarray(body.get_offsets()) for body in bodies]
    assert places == pytest.approx(run.poses[-1, 1:, :2])
    assert not any("did not" in text for text in texts(draw_run(run_of())))


def test_the_strips_hold_both_errors_of_every_robot() -> None:
    run = run_of()
    strays, late = strips_of(draw_run(run))
    for strip, values in ((strays, run.strays), (late, lateness(run))):
        (lines,) = lines_of(strip, 3)
        for k, course in enumerate(lines.get_segments()):
            known = np.isfinite(values[:, k])
            assert np.asarray(course) == pytest.approx(np.column_stack([run.times, values[:, k]])[known])
    assert "R2: 0.02 m" in texts(strays)
    assert "R0: 0.395 s" in texts(late)  # at the last recorded instant before its arrival


def test_who_has_arrived_is_not_late_any_more() -> None:
    run = run_of(arrivals=np.array([8.4, math.nan, 8.4]))
    late = lateness(run)
    moving = run.times < 8.35
    assert late[moving, 0] == pytest.approx(run.times[moving] - run.times[moving] / 1.05)
    assert np.isnan(late[run.times >= 8.4][:, [0, 2]]).all()
    assert late[-1, 1] == pytest.approx(2.0)


def test_long_courses_are_thinned_and_keep_their_worst() -> None:
    run = run_of(rows=5 * COLUMNS)
    run.strays[2 * COLUMNS + 3, 1] = run.greatest_stray[1] = 1.0
    strays, _ = strips_of(draw_run(run))
    (lines,) = lines_of(strays, 3)
    courses = [np.asarray(course) for course in lines.get_segments()]
    assert [len(course) for course in courses] == [COLUMNS] * 3
    assert courses[1][:, 1].max() == 1.0
    assert courses[1][courses[1][:, 1].argmax(), 0] == pytest.approx(run.times[2 * COLUMNS + 3], abs=0.01)
    assert "R1: 1 m" in texts(strays)


def test_axes_given_get_the_map_alone() -> None:
    figure = Figure(figsize=(6, 4))
    FigureCanvasAgg(figure)
    axes = figure.add_subplot()
    assert draw(run_of(), axes) is axes
    assert figure.axes == [axes]
    assert len(lines_of(axes, 6.2)) == 1


@pytest.mark.parametrize("n", [0, 1, 30, 70])
def test_teams_of_any_size_are_drawn(n: int) -> None:
    axes = draw_run(run_of(n, rows=11))
    assert len(strips_of(axes)) == 2


def test_a_run_over_at_once_is_a_picture_too(tmp_path: Path) -> None:
    robot = Robot("R0", (1, 1), (1, 1), radius=0.3)
    plan = Plan(Scene((0, 0, 3, 2), [], [robot]), (Trajectory("R0", np.array([[0.0, 1, 1]])),))
    run = run_of(1, rows=1, plan=plan, arrivals=np.zeros(1))
    assert "last arrival 0.0 s, planned 0.0 s · no collision" in texts(draw_run(run))
    animate_run(run, tmp_path / "a.gif", width=200)
    assert len(frames_of(tmp_path / "a.gif")) == 1


def test_draw_and_save_take_a_run(tmp_path: Path) -> None:
    run = run_of(collisions=(CRASH,))
    assert crosses_of(draw(run)) == pytest.approx(crosses_of(draw_run(run)))
    for name in ("a.png", "b.png"):
        save_figure(run, tmp_path / name)
    assert (tmp_path / "a.png").read_bytes() == (tmp_path / "b.png").read_bytes()


@pytest.mark.parametrize("more", [{"time": 1.0}, {"contact": 2.0}, {"routes": {}}, {"graph": object()}])
def test_what_does_not_go_with_a_run_is_refused(more: dict[str, Any]) -> None:
    with pytest.raises(TypeError, match=r"Run|no graph="):
        draw(run_of(), **more)


# --- animations


def frames_of(path: Path) -> list[NDArray[np.uint8]]:
    with Image.open(path) as film:
        out = []
        for k in range(getattr(film, "n_frames", 1)):
            film.seek(k)
            out.append(np.asarray(film.convert("RGB")))
        return out


def reds(frame: NDArray[np.uint8]) -> int:
    return int((frame == [round(255 * c) for c in to_rgb(COLLISION)]).all(axis=2).sum())


def changed(one: NDArray[np.uint8], other: NDArray[np.uint8]) -> FloatArray:
    """Return where two frames differ strongly, as shares of the width and height from the lower left, (k, 2)."""
    rows, columns = np.nonzero(np.abs(one.astype(int) - other).max(axis=2) > FAINT)
    return np.column_stack([columns / one.shape[1], 1 - rows / one.shape[0]])


def test_crosses_appear_when_robots_collide(tmp_path: Path) -> None:
    animate_run(run_of(collisions=(CRASH,)), tmp_path / "a.gif", fps=10, seconds=1.0, width=400)
    red = [reds(frame) for frame in frames_of(tmp_path / "a.gif")[:11]]
    # a frame a second
    before, after = red[:5], red[5:]
    assert min(after) > max(before) + 10


def test_the_same_run_gives_the_same_film(tmp_path: Path) -> None:
    for name in ("a.gif", "b.gif"):
        animate_run(run_of(), tmp_path / name, seconds=0.3, width=300)
    assert (tmp_path / "a.gif").read_bytes() == (tmp_path / "b.gif").read_bytes()


def test_poses_are_written_for_few_robots_only(tmp_path: Path) -> None:
    heights = {}
    for n in (12, 13):
        run = run_of(n, rows=11)
        run = replace(run, plan=Plan(replace(run.plan.scene, workspace=(0, 0, 20, 20)), run.plan.trajectories))  # type: ignore[arg-type]
        animate_run(run, tmp_path / f"{n}.gif", fps=5, seconds=0.2, width=500)
        heights[n] = frames_of(tmp_path / f"{n}.gif")[0].shape[0]
    assert heights[12] > heights[13] + 30


def test_lidars_are_seen_where_they_look(tmp_path: Path) -> None:
    run = run_of(1, rows=11, arrivals=np.array([math.nan]))
    poses = np.zeros((11, 1, 3))
    poses[:, 0] = (5.0, 1.0, math.pi / 2)
    angles = np.linspace(-0.3, 0.3, 31)
    scans = Scans(run.times, angles, np.full((11, 1, 31), 0.8), 2.0)
    for name, shown in (("bare", None), ("seen", scans)):
        animate_run(replace(run, poses=poses, scans=shown), tmp_path / f"{name}.gif", fps=5, seconds=0.2, width=500)
    bare, seen = (frames_of(tmp_path / f"{name}.gif")[1] for name in ("bare", "seen"))
    spots = changed(bare, seen)
    assert len(spots) > 20
    # ahead of the robot, which looks up from the middle, and nowhere else
    assert abs(spots[:, 0] - 0.53).max() < 0.04
    assert np.ptp(spots[:, 0]) > 0.03
    assert spots[:, 1].min() > 0.6


def test_what_is_detected_is_pointed_at(tmp_path: Path) -> None:
    run = run_of(1, rows=11, arrivals=np.array([math.nan]))
    scene = replace(run.plan.scene, workspace=(0, 0, 10, 5), obstacles=(Circle((5, 4), 0.5, "pillar"),))  # type: ignore[arg-type]
    poses = np.zeros((11, 1, 3))
    poses[:, 0] = (5.0, 1.0, math.pi / 2)
    run = replace(run, plan=Plan(scene, run.plan.trajectories), poses=poses)
    for name, detector in (("bare", None), ("seen", Detector(reach=4.0)), ("short", Detector(reach=1.0))):
        animate_run(run, tmp_path / f"{name}.gif", fps=5, seconds=0.2, width=500, detector=detector)
    bare, seen, short = (frames_of(tmp_path / f"{name}.gif")[1] for name in ("bare", "seen", "short"))
    spots = changed(bare, seen)
    assert len(spots) > 10
    assert np.ptp(spots[:, 0]) < 0.05
    assert np.ptp(spots[:, 1]) > 0.25
    assert len(changed(bare, short)) == 0


def test_who_leaves_fades(tmp_path: Path) -> None:
    animate_run(run_of(1, at_goal="leave"), tmp_path / "a.gif", fps=10, seconds=1.0, width=400)
    animate_run(run_of(1), tmp_path / "b.gif", fps=10, seconds=1.0, width=400)
    gone, stays = (frames_of(tmp_path / f"{name}.gif") for name in "ab")
    assert len(changed(gone[7], stays[7])) == 0
    assert len(changed(gone[-1], stays[-1])) > 30


@pytest.mark.parametrize(
    ("name", "more"),
    [
        ("a.avi", {}),
        ("a.gif", {"fps": 0.0}),
        ("a.gif", {"width": 10}),
        ("a.gif", {"seconds": math.nan}),
        ("no/a.gif", {}),
    ],
)
def test_films_that_cannot_be_made_are_refused(tmp_path: Path, name: str, more: dict[str, Any]) -> None:
    with pytest.raises(OutputError):
        animate_run(run_of(1, rows=3), tmp_path / name, **more)
    assert list(tmp_path.iterdir()) == []
