"""Pictures: what is where on the paper, in which colour; files whole or not at all; the same twice."""

from __future__ import annotations

import io
import itertools
import math
import os
import shutil
import subprocess
import sys
import warnings
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest
import shapely
from matplotlib.axes import Axes
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.colors import to_rgb
from matplotlib.figure import Figure
from numpy.typing import NDArray
from PIL import Image

from taut.errors import OutputError
from taut.figures import animate, draw, png_bytes, save_figure, svg_text
from taut.figures.movies import Palette
from taut.figures.style import (
    GOAL,
    GRAPH,
    GROWN,
    OBSTACLE,
    OUTSIDE,
    START,
    WORKSPACE,
    darker,
    robot_colours,
)
from taut.motion import Plan, Trajectory
from taut.scene import Circle, Line, Obstacle, Polygon, Rectangle, Robot, Scene

CORNERS = (
    [(4.5, 2), (7.8, 2), (7.8, 4), (4.5, 4)],
    [(2, 2.5), (3.3, 4.8), (3.3, 7), (2, 8.5)],
    [(5, 6), (7.5, 6), (9, 7.5), (7.5, 9), (5.2, 9)],
    [(1, 10), (3.2, 9.5), (2.5, 13)],
    [(6.2, 12), (10.8, 12.9), (7.2, 14), (4.5, 12.6)],
    [(10, 10), (11.5, 10), (11.5, 5), (10, 5)],
)
THESIS = Scene(
    (0, 0, 16, 16),
    [Polygon(corners) for corners in CORNERS],
    [Robot("R1", (3, 1), (12, 12.7)), Robot("R2", (3.4, 16), (11, 1)), Robot("R3", (8.7, 0.3), (0.5, 9))],
    name="thesis-2",
    gap=0.1,
    at_goal="leave",
)


def walk(name: str, points: list[tuple[float, float]], waits: dict[int, float] | None = None) -> Trajectory:
    """Return the motion at 1 m/s along the points with waits (seconds) at some of them."""
    time, stamps = 0.0, []
    for k, point in enumerate(points):
        time += math.dist(points[k - 1], point) if k else 0.0
        stamps.append((time, *point))
        if waits and k in waits:
            time += waits[k]
            stamps.append((time, *point))
    return Trajectory(name, np.array(stamps))


PLAN = Plan(
    THESIS,
    (
        walk("R1", [(3, 1), (4.5, 4), (7.5, 6), (10, 5), (9, 7.5), (10, 10), (12, 12.7)], {2: 2.3}),
        walk("R2", [(3.4, 16), (4.5, 12.6), (5, 6), (7.8, 4), (11, 1)]),
        walk("R3", [(8.7, 0.3), (7.8, 4), (5, 6), (3.2, 9.5), (2, 8.5), (0.5, 9)], {0: 1.2}),
    ),
)


def one_robot(radius: float = 0.0, at_goal: str = "stay") -> Plan:
    robot = Robot("A", (1, 2), (9, 2), radius=radius)
    scene = Scene((0, 0, 10, 4), [], [robot], at_goal=at_goal)  # type: ignore[arg-type]
    return Plan(scene, (walk("A", [(1, 2), (9, 2)]),))


class Paper:
    """The pixels of drawn axes, found by place in metres."""

    def __init__(self, axes: Axes) -> None:
        figure = axes.get_figure(root=True)
        assert figure is not None
        canvas = FigureCanvasAgg(figure)
        canvas.draw()  # type: ignore[no-untyped-call]
        self.pixels: NDArray[np.uint8] = np.asarray(canvas.buffer_rgba())[..., :3].copy()  # type: ignore[no-untyped-call]
        self.axes = axes

    def pixel(self, x: float, y: float) -> tuple[int, int]:
        """Return row and column of the place."""
        across, up = self.axes.transData.transform((x, y))
        return int(len(self.pixels) - 1 - up), int(across)

    def at(self, x: float, y: float) -> tuple[int, ...]:
        """Return the colour at a place."""
        return tuple(int(v) for v in self.pixels[self.pixel(x, y)])

    def near(self, x: float, y: float, reach: int = 3) -> set[tuple[int, ...]]:
        """Return the colours within `reach` pixels of a place."""
        row, column = self.pixel(x, y)
        patch = self.pixels[row - reach : row + reach + 1, column - reach : column + reach + 1].reshape(-1, 3)
        return {tuple(int(v) for v in pixel) for pixel in patch}


def rgb(colour: str) -> tuple[int, ...]:
    return tuple(round(255 * c) for c in to_rgb(colour))


def texts(axes: Axes) -> list[str]:
    return [text.get_text() for text in axes.texts]


# What is where


def test_obstacles_are_blue_inside_and_the_workspace_is_white_on_grey() -> None:
    paper = Paper(draw(THESIS))
    for x, y in ((5, 3.5), (2.3, 4.5), (8, 7.3), (2.4, 12), (7.2, 13.5), (10.2, 9.5)):
        assert paper.at(x, y) == rgb(OBSTACLE)
    assert paper.at(14, 8) == rgb(WORKSPACE)
    assert paper.at(-0.2, 8) == rgb(OUTSIDE)


def test_each_kind_of_obstacle_has_its_true_shape() -> None:
    wall = Line([(1, 1), (4, 1)], 0.6)
    turned = Rectangle(6, 1, 4, 1, math.pi / 2)
    paper = Paper(draw(Scene((0, 0, 12, 8), [wall, turned, Circle((3, 5), 2)])))
    inside = ((2.5, 1.25), (4.2, 1), (8, 3.3), (8, -0.3), (3 + 1.35, 5 + 1.35), (1.1, 5))
    outside = ((2.5, 1.4), (4.4, 1), (6.5, 1.5), (9.5, 1.5), (3 + 1.5, 5 + 1.5), (4.9, 6.9))
    assert [paper.at(*place) for place in inside if place[1] > 0] == [rgb(OBSTACLE)] * 5
    assert [paper.at(*place) for place in outside] == [rgb(WORKSPACE)] * 6


def test_starts_are_red_and_goals_green() -> None:
    for value in (THESIS, PLAN):
        paper = Paper(draw(value))
        for robot in THESIS.robots:
            assert paper.at(*robot.start) == rgb(START)
            assert paper.at(*robot.goal) == rgb(GOAL)


def test_a_path_has_its_robots_colour_in_the_middle() -> None:
    paper = Paper(draw(PLAN))
    orange, indigo, magenta = (rgb(colour) for colour in robot_colours(3))
    assert orange in paper.near(9.5, 6.25)
    assert indigo in paper.near(4.75, 9.6)
    assert magenta in paper.near(8.25, 2.15)
    assert orange not in paper.near(8.25, 2.15)


def test_a_leg_of_two_robots_shows_both_colours() -> None:
    paper = Paper(draw(PLAN))
    seen: set[tuple[int, ...]] = set()
    for s in np.linspace(0.3, 0.7, 60):
        seen |= paper.near(5 + 2.8 * s, 6 - 2 * s, 1)
    assert {rgb(colour) for colour in robot_colours(3)[1:]} <= seen


def test_an_arrow_points_along_the_path() -> None:
    axes = draw(one_robot())
    heads = [c for c in axes.collections if type(c).__name__ == "PolyCollection"]
    (polygons,) = [collection.get_paths() for collection in heads]
    for polygon in polygons:
        tip, *rest = np.asarray(polygon.vertices, dtype=np.float64)[:4]
        assert tip[0] > max(float(p[0]) for p in rest)
        assert tip[1] == pytest.approx(2)


def test_waits_are_told_in_seconds() -> None:
    written = texts(draw(PLAN))
    assert "2.3 s" in written
    assert "R3, waits 1.2 s" in written
    assert "R1" in written


def test_discs_are_drawn_in_their_true_size() -> None:
    paper = Paper(draw(one_robot(radius=1.0), time=4.0))
    colour = rgb(robot_colours(1)[0])
    assert paper.at(5, 2) == paper.at(5.9, 2) == paper.at(5, 2.9) == colour
    assert colour not in {paper.at(6.1, 2.3), paper.at(5.75, 2.75), paper.at(5, 3.1)}


def test_a_robot_that_has_left_is_not_drawn() -> None:
    colour = rgb(robot_colours(1)[0])
    at_goal = {kind: Paper(draw(one_robot(1.0, kind), time=8.0)).at(9, 2.6) for kind in ("stay", "leave")}
    assert at_goal["stay"] == colour
    assert at_goal["leave"] != colour


def test_names_of_many_robots_are_left_out() -> None:
    def team(n: int) -> Scene:
        return Scene((0, 0, 100, 10), [], [Robot(f"R{k}", (2 * k + 1, 2), (2 * k + 1, 8), 0.3) for k in range(n)])

    assert "R0" in texts(draw(team(25)))
    assert "R0" not in texts(draw(team(26)))


def test_labels_do_not_cover_each_other() -> None:
    axes = draw(PLAN)
    Paper(axes)
    names = [t for t in axes.texts if t.get_text() in {"R1", "R2", "R3, waits 1.2 s", "2.3 s"}]
    boxes = [t.get_window_extent() for t in names]
    assert len(boxes) == 4
    assert not any(a.overlaps(b) for a, b in itertools.combinations(boxes, 2))


def test_the_graph_lies_under_the_robots_on_request() -> None:
    graph = SimpleNamespace(positions=np.array([(13, 2), (13, 14), (3, 1)]), edges=np.array([(0, 1), (1, 2)]))
    assert rgb(GRAPH) in Paper(draw(THESIS, graph=graph)).near(13, 8)
    assert Paper(draw(THESIS, graph=graph)).at(3, 1) == rgb(START)
    assert rgb(GRAPH) not in Paper(draw(THESIS)).near(13, 8)


def test_roadmap_free_space_and_route_are_drawn() -> None:
    road = Paper(draw(SimpleNamespace(positions=np.array([(0, 0), (4, 0), (4, 3)]), edges=np.array([(0, 1), (1, 2)]))))
    assert rgb(GRAPH) in road.near(2, 0)
    scene = Scene((0, 0, 10, 10), [Rectangle(4, 4, 2, 2)])
    region = shapely.box(1, 1, 9, 9) - shapely.box(3, 3, 7, 7)
    free = Paper(draw(SimpleNamespace(region=region, scene=scene)))
    found = [free.at(2, 2), free.at(3.5, 5), free.at(5, 5), free.at(0.5, 5)]
    assert found == [rgb(WORKSPACE), rgb(GROWN), rgb(OBSTACLE), rgb(GROWN)]
    alone = Paper(draw(SimpleNamespace(region=region)))
    assert (alone.at(2, 2), alone.at(5, 5)) == (rgb(WORKSPACE), rgb(OUTSIDE))
    route = Paper(draw(SimpleNamespace(points=np.array([(0, 0), (6, 0), (6, 6)]), length=12.0)))
    assert rgb(robot_colours(1)[0]) in route.near(6, 2)


def test_draw_uses_the_axes_given_with_equal_scale() -> None:
    figure = Figure()
    left, right = figure.subplots(1, 2)
    assert draw(THESIS, left) is left
    assert draw(PLAN, right) is right
    Paper(left)
    for axes in (left, right):
        (x0, y0), (x1, y1) = axes.transData.transform([(0, 0), (1, 1)])
        assert x1 - x0 == pytest.approx(y1 - y0)


def test_a_long_corridor_is_shown_whole() -> None:
    for bounds in ((0, 0, 60, 2), (0, 0, 2, 60), (1e6, 1e6, 1e6 + 9, 1e6 + 3)):
        axes = draw(Scene(bounds))
        (x0, x1), (y0, y1) = axes.get_xlim(), axes.get_ylim()
        assert x0 < bounds[0] < bounds[2] < x1
        assert y0 < bounds[1] < bounds[3] < y1
        figure = axes.figure
        assert min(figure.get_size_inches()) > 1.5  # type: ignore[union-attr]


def test_names_may_hold_any_sign(tmp_path: Path) -> None:
    robots = [Robot("$\\x_$", (1, 1), (3, 3), 0.5), Robot("机器人", (3, 1), (1, 3), 0.1)]
    scene = Scene((0, 0, 4, 4), [Circle((2, 2), 0.9, name="$^$")], robots, name="$a_$")
    plan = Plan(scene, tuple(walk(r.name, [r.start, r.goal]) for r in robots))
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        for value in (scene, plan):
            save_figure(value, tmp_path / "a.png")
        animate(plan, tmp_path / "a.gif", seconds=0.2, width=200)
    assert "$\\x_$" in texts(draw(plan))


def test_draw_says_what_it_cannot_draw() -> None:
    with pytest.raises(TypeError, match="got int"):
        draw(3)
    with pytest.raises(TypeError, match="needs a Plan"):
        draw(THESIS, time=1.0)


@pytest.mark.parametrize("far", [1.7e308, -1.7e308, 1e30, 1e7])
def test_a_trajectory_that_leaves_for_nowhere_is_drawn_with_the_map(far: float, tmp_path: Path) -> None:
    scene = Scene((0, 0, 10, 10), [Circle((5, 5), 1)], [Robot("R1", (1, 1), (9, 9), radius=0.3)])
    stamps = [[0, 1, 1], [1, far, far], [2, far, far], [5, -far, 9], [1e308, 9, 9]]
    plan = Plan(scene, (Trajectory("R1", np.array(stamps)),))
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        axes = draw(plan)
        png_bytes(plan)
        animate(plan, tmp_path / "a.gif", seconds=0.3, fps=5)
    assert -1 < axes.get_xlim()[0] < axes.get_xlim()[1] < 11
    assert "last arrival 1e+308 s" in axes.get_title("right")


def test_a_plan_a_little_off_the_map_is_shown_whole() -> None:
    scene = Scene((0, 0, 10, 10), robots=[Robot("R1", (1, 1), (9, 9))])
    axes = draw(Plan(scene, (Trajectory("R1", np.array([[0, 1, 1], [1, 60, 1], [2, 9, 9.0]])),)))
    assert axes.get_xlim()[1] > 60


@pytest.mark.parametrize(
    "scene",
    [
        Scene((-1.7e308, -1.7e308, 1.7e308, 1.7e308)),
        Scene((0, 0, 1e-300, 1e-300)),
        Scene((1e9, 1e9, 1e9 + 1e-6, 1e9 + 1e-6)),
        Scene((0, 0, 10, 10), [Polygon([(1, 1), (1e300, 2), (3, 1e300)])]),
        Scene((0, 0, 10, 10), robots=[Robot("R1", (1, 1), (2, 2), radius=1e308)]),
    ],
    ids=["huge", "tiny", "far out", "obstacle", "radius"],
)
def test_what_no_picture_can_show_is_refused(scene: Scene) -> None:
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        with pytest.raises(OutputError, match="cannot be drawn"):
            draw(scene)


def test_obstacles_and_discs_far_larger_than_the_map_are_drawn() -> None:
    things: list[Obstacle] = [Polygon([(1, 1), (1e30, 2), (3, 1e30)]), Circle((1e12, 3), 1e12 - 9), Circle((1, 8), 1e8)]
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        png_bytes(Scene((0, 0, 10, 10), things, [Robot("R1", (1, 1), (9, 9), radius=1e20)]))


def test_empty_and_crowded_scenes_are_drawn() -> None:
    assert Paper(draw(Scene((0, 0, 1, 1)))).at(0.5, 0.5) == rgb(WORKSPACE)
    assert Paper(draw(Plan(Scene((0, 0, 1, 1)), ()))).at(0.5, 0.5) == rgb(WORKSPACE)
    places = [(float(x), float(y)) for x in range(40) for y in range(25)]
    robots = [Robot(f"R{k}", p, (p[0] + 0.5, p[1]), 0.1) for k, p in enumerate(places)]
    plan = Plan(Scene((-1, -1, 41, 26), [], robots), tuple(walk(r.name, [r.start, r.goal]) for r in robots))
    axes = draw(plan)
    assert len(axes.collections) < 20  # collections, not an artist a robot
    assert rgb(START) in Paper(axes).near(7, 11)


def test_ten_robots_differ_also_for_the_colour_blind() -> None:
    # Machado et al. (2009), severity 1: protanopia, deuteranopia, tritanopia
    seen_as = (
        np.eye(3),
        [[0.152286, 1.052583, -0.204868], [0.114503, 0.786281, 0.099216], [-0.003882, -0.048116, 1.051998]],
        [[0.367322, 0.860646, -0.227968], [0.280085, 0.672501, 0.047413], [-0.01182, 0.04294, 0.968881]],
        [[1.255528, -0.076749, -0.178779], [-0.078411, 0.930809, 0.147602], [0.004733, 0.691367, 0.3039]],
    )
    colours = np.array([to_rgb(colour) for colour in robot_colours(10)])
    linear = np.where(colours <= 0.04045, colours / 12.92, ((colours + 0.055) / 1.055) ** 2.4)
    to_cone = np.array(
        [[0.41222147, 0.53633254, 0.05144599], [0.2119035, 0.68069955, 0.10739696], [0.08830246, 0.28171884, 0.6299787]]
    )
    to_lab = np.array(
        [
            [0.21045426, 0.79361779, -0.00407205],
            [1.9779985, -2.42859221, 0.45059371],
            [0.02590404, 0.78277177, -0.80867577],
        ]
    )
    for matrix in seen_as:
        lab = np.cbrt(np.clip(linear @ np.transpose(matrix), 0, 1) @ to_cone.T) @ to_lab.T
        apart = np.linalg.norm(lab[:, None] - lab[None], axis=-1)[np.triu_indices(10, 1)]
        assert apart.min() > 0.055
    assert len(set(robot_colours(30))) == 30


def test_small_text_is_dark_enough_on_white() -> None:
    for colour in robot_colours(30):
        channels = np.array(to_rgb(darker(colour)))
        linear = np.where(channels <= 0.04045, channels / 12.92, ((channels + 0.055) / 1.055) ** 2.4)
        assert 1.05 / (linear @ [0.2126, 0.7152, 0.0722] + 0.05) >= 4.5


# Files


@pytest.mark.parametrize(
    ("kind", "magic"), [("png", b"\x89PNG"), ("svg", b"<?xml"), ("pdf", b"%PDF"), ("PNG", b"\x89PNG")]
)
def test_files_are_of_their_kind_and_the_same_twice(tmp_path: Path, kind: str, magic: bytes) -> None:
    first, second = tmp_path / f"a.{kind}", tmp_path / f"b.{kind}"
    save_figure(PLAN, first)
    save_figure(PLAN, second)
    assert first.read_bytes().startswith(magic)
    assert first.read_bytes() == second.read_bytes()
    assert sorted(p.name for p in tmp_path.iterdir()) == [first.name, second.name]


def test_files_tell_no_time_and_no_software(tmp_path: Path) -> None:
    for kind in ("png", "svg", "pdf"):
        save_figure(THESIS, tmp_path / f"a.{kind}")
        data = (tmp_path / f"a.{kind}").read_bytes()
        assert b"Software" not in data
        assert b"CreationDate" not in data
        assert b"<dc:date>" not in data


def test_a_png_has_200_dpi_and_the_shape_of_the_map(tmp_path: Path) -> None:
    save_figure(one_robot(), tmp_path / "a.png")
    with Image.open(tmp_path / "a.png") as picture:
        assert picture.info["dpi"] == pytest.approx((200, 200), abs=0.1)
        assert picture.width == 1600
        assert picture.height < 0.6 * picture.width


def test_unknown_kinds_name_the_known_ones(tmp_path: Path) -> None:
    with pytest.raises(OutputError, match=r"\.png, \.svg or \.pdf, not \.jpg"):
        save_figure(THESIS, tmp_path / "a.jpg")
    with pytest.raises(OutputError, match="without extension"):
        save_figure(THESIS, tmp_path / "picture")
    with pytest.raises(OutputError, match=r"\.gif or \.mp4, not \.avi"):
        animate(PLAN, tmp_path / "a.avi")
    assert list(tmp_path.iterdir()) == []


def test_places_that_cannot_be_written_are_one_line(tmp_path: Path) -> None:
    (tmp_path / "folder.png").mkdir()
    (tmp_path / "file").write_text("")
    for name in ("missing/a.png", "folder.png", "file/a.png"):
        with pytest.raises(OutputError) as caught:
            save_figure(THESIS, tmp_path / name)
        assert str(tmp_path / name) in str(caught.value)
        assert "\n" not in str(caught.value)
    with pytest.raises(OutputError, match="missing"):
        animate(PLAN, tmp_path / "missing" / "a.gif", seconds=0.1)
    assert sorted(p.name for p in tmp_path.iterdir()) == ["file", "folder.png"]


def test_a_failure_leaves_the_old_file(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    for name in ("a.png", "a.gif"):
        (tmp_path / name).write_bytes(b"old")

    def fail(*_: object, **__: object) -> None:
        raise OSError(28, "No space left on device")

    monkeypatch.setattr(Figure, "savefig", fail)
    monkeypatch.setattr(Image.Image, "save", fail)
    with pytest.raises(OutputError, match="No space left"):
        save_figure(THESIS, tmp_path / "a.png")
    with pytest.raises(OutputError, match="No space left"):
        animate(PLAN, tmp_path / "a.gif", seconds=0.1)
    assert {p.name: p.read_bytes() for p in tmp_path.iterdir()} == {"a.png": b"old", "a.gif": b"old"}


def test_pictures_for_notebooks() -> None:
    with Image.open(io.BytesIO(png_bytes(THESIS))) as picture:
        assert picture.format == "PNG"
        assert 600 < picture.width < 1000
    assert svg_text(THESIS).rstrip().endswith("</svg>")
    assert svg_text(THESIS) == svg_text(THESIS)


def test_taut_is_imported_without_matplotlib_and_figures_without_pyplot() -> None:
    code = "import sys, taut; assert 'matplotlib' not in sys.modules; import taut.figures as f; "
    code += "f.draw(taut.Scene((0, 0, 1, 1))); assert 'matplotlib.pyplot' not in sys.modules"
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr


# Animations


def frames_of(path: Path) -> list[Image.Image]:
    with Image.open(path) as film:
        out = []
        for k in range(getattr(film, "n_frames", 1)):
            film.seek(k)
            out.append(film.convert("RGB"))
        return out


def centroid(picture: Image.Image, colour: str) -> float:
    """Return the mean column of the pixels of that very colour."""
    columns = np.flatnonzero((np.asarray(picture) == rgb(colour)).all(axis=2).any(axis=0))
    return float(columns.mean()) if columns.size else math.nan


def test_a_gif_has_the_frames_and_times_asked_for(tmp_path: Path) -> None:
    animate(one_robot(0.5), tmp_path / "a.gif", fps=10, seconds=1.0, width=320)
    with Image.open(tmp_path / "a.gif") as film:
        assert film.format == "GIF"
        assert film.info["loop"] == 0
        assert film.width == 320
        durations = []
        for k in range(film.n_frames):  # type: ignore[attr-defined]
            film.seek(k)
            durations.append(film.info["duration"])
    # 11 frames of motion; those after the arrival show the same and are joined, except for fading trails
    assert len(durations) >= 11
    assert set(durations[:-1]) == {100}
    assert sum(durations) == 100 * (1 + 10 + 6) + 1200


def test_the_robot_of_a_gif_moves_from_start_to_goal_in_its_colour(tmp_path: Path) -> None:
    animate(one_robot(0.5), tmp_path / "a.gif", fps=10, seconds=1.0, width=320)
    frames = frames_of(tmp_path / "a.gif")
    columns = [centroid(frame, robot_colours(1)[0]) for frame in frames[:11]]
    steps = np.diff(columns)
    assert (steps > 0).all()
    assert steps == pytest.approx([steps.mean()] * 10, rel=0.35)
    assert all((np.asarray(frame) == rgb(WORKSPACE)).all(axis=2).mean() > 0.2 for frame in frames)


def test_a_robot_that_leaves_fades_from_the_gif(tmp_path: Path) -> None:
    last = {}
    for kind in ("stay", "leave"):
        animate(one_robot(0.5, kind), tmp_path / f"{kind}.gif", fps=10, seconds=0.5, width=320)
        last[kind] = centroid(frames_of(tmp_path / f"{kind}.gif")[-1], robot_colours(1)[0])
    assert last["stay"] > 200
    assert math.isnan(last["leave"])


def test_a_point_robot_is_seen(tmp_path: Path) -> None:
    animate(one_robot(0.0), tmp_path / "a.gif", fps=4, seconds=1.0, width=320)
    middle = np.asarray(frames_of(tmp_path / "a.gif")[2])
    assert (middle == rgb(robot_colours(1)[0])).all(axis=2).sum() >= 9


def test_a_gif_is_the_same_twice(tmp_path: Path) -> None:
    for name in ("a.gif", "b.gif"):
        animate(PLAN, tmp_path / name, seconds=0.4, width=300)
    assert (tmp_path / "a.gif").read_bytes() == (tmp_path / "b.gif").read_bytes()
    assert len(list(tmp_path.iterdir())) == 2


def test_a_long_plan_takes_at_most_240_frames_or_so(tmp_path: Path) -> None:
    scene = Scene((0, 0, 500, 500), [], [Robot("A", (1, 1), (499, 499))])
    animate(Plan(scene, (walk("A", [(1, 1), (499, 499)]),)), tmp_path / "a.gif", width=160)
    with Image.open(tmp_path / "a.gif") as film:
        assert 200 < film.n_frames <= 250  # type: ignore[attr-defined]


def test_plans_without_motion_are_films_too(tmp_path: Path) -> None:
    still = Plan(Scene((0, 0, 4, 4), [], [Robot("A", (1, 1), (1, 1), 0.5)]), (walk("A", [(1, 1)]),))
    for name, plan in (("still", still), ("empty", Plan(Scene((0, 0, 4, 4)), ()))):
        animate(plan, tmp_path / f"{name}.gif", width=200)
        assert len(frames_of(tmp_path / f"{name}.gif")) == 1


def test_numbers_that_make_no_film_are_refused(tmp_path: Path) -> None:
    for numbers in ({"fps": 0.0}, {"seconds": -1.0}, {"seconds": math.nan}, {"width": 3}):
        with pytest.raises(OutputError, match="needs fps"):
            animate(PLAN, tmp_path / "a.gif", **numbers)
    assert list(tmp_path.iterdir()) == []


def test_palettes_keep_exact_colours_and_find_the_nearest() -> None:
    rng = np.random.default_rng(0)
    frame = rng.integers(0, 256, (40, 50, 4), dtype=np.uint8)
    frame[..., 3] = 255
    palette = Palette([frame], ["#ffffff", "#123456"])
    frame[0, 0, :3], frame[0, 1, :3] = (255, 255, 255), (0x12, 0x34, 0x56)
    shown = np.asarray(palette.image(frame).convert("RGB")).astype(int)
    assert tuple(shown[0, 0]) == (255, 255, 255)
    assert tuple(shown[0, 1]) == (0x12, 0x34, 0x56)
    distances = np.linalg.norm(frame[..., None, :3].astype(int) - palette.table, axis=-1)
    assert np.linalg.norm(shown - frame[..., :3], axis=-1) == pytest.approx(distances.min(axis=-1))


def test_mp4_without_ffmpeg_says_so(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("PATH", str(tmp_path))
    with pytest.raises(OutputError, match=r"needs ffmpeg.*install it or write a \.gif"):
        animate(PLAN, tmp_path / "a.mp4")
    assert list(tmp_path.iterdir()) == []


@pytest.mark.skipif(os.name == "nt", reason="the stand-in for ffmpeg is a shell script")
def test_a_failing_ffmpeg_is_quoted_and_leaves_nothing(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    fake = tmp_path / "ffmpeg"
    fake.write_text("#!/bin/sh\necho 'no such encoder' >&2\nexit 1\n")
    fake.chmod(0o755)
    monkeypatch.setenv("PATH", str(tmp_path))
    with pytest.raises(OutputError, match="no such encoder"):
        animate(PLAN, tmp_path / "a.mp4", seconds=0.5, width=200)
    assert [p.name for p in tmp_path.iterdir()] == ["ffmpeg"]


@pytest.mark.skipif(shutil.which("ffmpeg") is None, reason="needs ffmpeg")
def test_mp4_by_ffmpeg(tmp_path: Path) -> None:
    animate(PLAN, tmp_path / "a.mp4", seconds=0.5, width=301)
    assert (tmp_path / "a.mp4").read_bytes()[4:8] == b"ftyp"
    assert [p.name for p in tmp_path.iterdir()] == ["a.mp4"]


def test_a_way_of_many_small_turns_is_swept_though_rounding_leaves_slivers() -> None:
    way = np.array([
        (4.735154392501973, 3.344298308554498),
        (4.732708574810054, 3.345699562770557),
        (4.7300402579002725, 3.3472277738941143),
        (4.729317835003102, 3.347637356151574),
        (4.7288095952417635, 3.3479081009546774),
        (4.728795878454052, 3.3479151707643005),
    ])  # fmt: skip
    robot = Robot("R", tuple(way[0]), tuple(way[-1]), radius=0.2)
    plan = Plan(Scene((4, 3, 5, 4), robots=[robot]), (Trajectory("R", np.column_stack([np.arange(6.0), way])),))
    (swept,) = [part for part in draw(plan).collections if part.get_zorder() == 3]
    outlines = [shapely.Polygon(ring) for path in swept.get_paths() for ring in path.to_polygons()]
    # the circle about each corner is inscribed in the disc
    assert shapely.covers(shapely.union_all(outlines).buffer(1e-3), shapely.Point(way[0]).buffer(0.2))
    assert sum(outline.area for outline in outlines) == pytest.approx(np.pi * 0.04 + 0.4 * 0.0074, rel=0.01)
