"""Pictures of contact: which links are drawn and how, what the course of λ2 says, and that nothing else changes."""

from __future__ import annotations

import io
import itertools
import math
from collections.abc import Mapping
from dataclasses import replace
from pathlib import Path

import networkx as nx
import numpy as np
import pytest
from matplotlib.axes import Axes
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.collections import LineCollection, PathCollection, PolyCollection
from matplotlib.colors import to_hex, to_rgb
from matplotlib.figure import Figure
from matplotlib.patches import Rectangle, StepPatch
from numpy.typing import NDArray
from PIL import Image

from taut.contact import Contact
from taut.errors import SceneError
from taut.figures import animate, draw, save_figure, svg_text
from taut.figures.contact import SHADES
from taut.figures.pictures import MANY_LINKED
from taut.figures.style import APART, BRIDGE, INK, LINK, OUTSIDE, robot_colours
from taut.motion import Plan, Trajectory
from taut.scene import FloatArray, Robot, Scene

LATE = 1.0  # seconds that the last of three waits
LAG = math.sqrt(2.1**2 - 2.0**2)  # metres by which it may lag behind within a range of 2.1 m


def walk(name: str, points: list[tuple[float, float]], wait: float = 0.0) -> Trajectory:
    """Return the motion at 1 m/s along the points after a wait."""
    time, stamps = 0.0, [(0.0, *points[0])]
    if wait:
        time = wait
        stamps.append((time, *points[0]))
    for a, b in itertools.pairwise(points):
        time += math.dist(a, b)
        stamps.append((time, *b))
    return Trajectory(name, np.array(stamps))


def column(claims: Mapping[str, object] | None = None, at_goal: str = "stay") -> Plan:
    """Return three robots abreast, 2 m apart, of which the last waits a second and arrives that much later."""
    robots = [Robot(name, (1, y), (9, y), radius=0.3) for name, y in (("A", 1), ("B", 3), ("C", 5))]
    scene = Scene((0, 0, 10, 6), [], robots, name="column", at_goal=at_goal)  # type: ignore[arg-type]
    waits = {"C": LATE}
    moves = tuple(walk(r.name, [r.start, r.goal], waits.get(r.name, 0.0)) for r in robots)
    return Plan(scene, moves, claims=claims or {})


def wandering(seed: int, n: int = 7) -> Plan:
    """Return n robots that go through random places."""
    rng = np.random.default_rng(seed)
    places = rng.uniform(0.5, 9.5, (n, 4, 2))
    robots = [Robot(f"R{k}", tuple(p[0]), tuple(p[-1]), radius=0.1) for k, p in enumerate(places)]
    scene = Scene((0, 0, 10, 10), [], robots, gap=0.01)
    return Plan(scene, tuple(walk(r.name, [tuple(q) for q in p]) for r, p in zip(robots, places, strict=True)))


def graph_of(plan: Plan, time: float, reach: float) -> nx.Graph:
    """Return who is in contact at one time, from the places alone."""
    places = plan.at(time)
    graph = nx.Graph()
    graph.add_nodes_from(range(len(places)))
    near = [(i, j) for i in range(len(places)) for j in range(i) if math.dist(places[i], places[j]) <= reach]
    graph.add_edges_from(near)
    return graph


def figure_of(axes: Axes) -> Figure:
    figure = axes.get_figure(root=True)
    assert isinstance(figure, Figure)
    return figure


def strips_of(axes: Axes) -> list[Axes]:
    return [other for other in figure_of(axes).axes if other is not axes]


def links_of(axes: Axes) -> list[tuple[FloatArray, float, str]]:
    """Return the ends, width and colour of every link drawn."""
    (lines,) = [c for c in axes.collections if isinstance(c, LineCollection) and c.get_zorder() == 6.5]
    colours = [to_hex(colour) for colour in np.atleast_2d(lines.get_colors())]
    widths = np.atleast_1d(lines.get_linewidth())
    return [(np.asarray(s), float(w), c) for s, w, c in zip(lines.get_segments(), widths, colours, strict=True)]


def pairs_of(plan: Plan, time: float, links: list[FloatArray]) -> set[tuple[int, int]]:
    """Return between which robots links run, found by their places at that time."""
    places = plan.at(time)
    out = set()
    for ends in links:
        i, j = (int(np.argmin(np.hypot(*(places - end).T))) for end in ends)
        assert places[[i, j]] == pytest.approx(np.asarray(ends))
        out.add((max(i, j), min(i, j)))
    return out


def steps_of(strip: Axes) -> tuple[FloatArray, FloatArray]:
    """Return λ2 of each piece and the edges between them, as drawn."""
    lines = [p for p in strip.patches if isinstance(p, StepPatch) and not p.get_fill()]
    values, edges, _ = lines[0].get_data()
    return np.asarray(values, dtype=np.float64), np.asarray(edges, dtype=np.float64)


def texts(axes: Axes) -> list[str]:
    titles = [axes.get_title(loc=side) for side in ("left", "center", "right")]
    legend = axes.get_legend()
    labels = [] if legend is None else [text.get_text() for text in legend.get_texts()]
    return [*titles, *(text.get_text() for text in axes.texts), *labels]


# --- still pictures


@pytest.mark.parametrize("seed", range(6))
@pytest.mark.parametrize("time", [0.0, 3.7, 9.1])
def test_the_links_drawn_are_those_of_that_time_and_bridges_are_red(seed: int, time: float) -> None:
    plan, reach = wandering(seed), 4.0
    axes = draw(plan, time=time, contact=reach)
    drawn = links_of(axes)
    graph = graph_of(plan, time, reach)
    assert pairs_of(plan, time, [ends for ends, _, _ in drawn]) == {(max(e), min(e)) for e in graph.edges}
    red = pairs_of(plan, time, [ends for ends, _, colour in drawn if colour == BRIDGE])
    assert red == {(max(e), min(e)) for e in nx.bridges(graph)}
    assert {colour for _, _, colour in drawn} <= {BRIDGE, *SHADES}


@pytest.mark.parametrize("seed", range(4))
def test_nearer_robots_have_thicker_and_darker_links(seed: int) -> None:
    links = [link for link in links_of(draw(wandering(seed), time=2.0, contact=6.0)) if link[2] != BRIDGE]
    links.sort(key=lambda link: -math.dist(*link[0]))
    widths = [width for _, width, _ in links]
    greys = [sum(to_rgb(colour)) for _, _, colour in links]
    assert len(links) > 5
    assert widths == sorted(widths)
    assert widths[0] < widths[-1]
    assert greys == sorted(greys, reverse=True)


@pytest.mark.parametrize("seed", range(6))
def test_cut_vertices_are_ringed(seed: int) -> None:
    plan, time, reach = wandering(seed), 1.0, 3.6
    axes = draw(plan, time=time, contact=reach)
    rings = [c for c in axes.collections if isinstance(c, PathCollection) and c.get_zorder() == 8.5]
    (ringed,) = [np.asarray(ring.get_offsets()) for ring in rings]
    cuts = sorted(nx.articulation_points(graph_of(plan, time, reach)))
    assert ringed == pytest.approx(plan.at(time)[cuts])
    assert ("cut vertex" in texts(axes)) == bool(cuts)


def test_a_plan_that_claims_contact_is_drawn_when_least_of_it_is_left() -> None:
    axes = draw(column({"contact": {"range": 2.1}}))
    assert "t = 4.5 s, when λ2 is least · 3 robots" in texts(axes)
    assert pairs_of(column(), 4.5, [ends for ends, _, _ in links_of(axes)]) == {(1, 0)}
    assert len(strips_of(axes)) == 2


@pytest.mark.parametrize("seed", range(3))
def test_the_course_of_lambda2_is_that_of_the_graphs_at_random_times(seed: int) -> None:
    plan, reach = wandering(seed), 4.5
    strip = strips_of(draw(plan, contact=reach))[0]
    values, edges = steps_of(strip)
    assert edges[0] == 0
    assert edges[-1] == plan.makespan
    least = strip.get_ylim()[0]  # 0, or where a logarithmic scale begins
    for time in np.random.default_rng(seed).uniform(0, plan.makespan, 60):
        k = int(np.searchsorted(edges, time, side="right")) - 1
        laplacian = nx.laplacian_matrix(graph_of(plan, time, reach)).toarray()
        expected = float(np.linalg.eigvalsh(laplacian)[1])
        assert values[k] == pytest.approx(max(expected, least), abs=1e-9)


def test_the_time_without_contact_is_a_red_band_and_told() -> None:
    axes = draw(column({"contact": {"range": 2.1}}))
    strip = strips_of(axes)[0]
    bands = [p for p in strip.patches if isinstance(p, Rectangle) and to_hex(p.get_facecolor()) == APART]
    (band,) = bands
    assert band.get_x() == pytest.approx(LAG, abs=1e-9)
    assert band.get_x() + band.get_width() == pytest.approx(8 + LATE - LAG, abs=1e-9)
    assert any("not connected from 0.6 s to 8.4 s" in text for text in texts(strip))
    assert "λ2, links within 2.1 m" in texts(strip)


def test_where_lambda2_is_least_is_told() -> None:
    strip = strips_of(draw(column(), contact=4.05))[0]
    # at first all three are in contact; from the lag of √(4.05² − 4²) = 0.63 m on only neighbours
    assert any("least 1 at 4.5 s" in text for text in texts(strip))
    values, _ = steps_of(strip)
    assert values.tolist() == pytest.approx([3.0, 1.0, 3.0])


def test_rows_say_when_which_robot_is_a_cut_vertex() -> None:
    _, rows = strips_of(draw(column(), contact=4.05))
    assert [text.get_text() for text in rows.texts if text.get_text() != "seconds"] == ["B"]
    (bars,) = [c for c in rows.collections if isinstance(c, PolyCollection)]
    (path,) = bars.get_paths()
    lag = math.sqrt(4.05**2 - 4**2)
    vertices = np.asarray(path.vertices)
    assert (vertices[:, 0].min(), vertices[:, 0].max()) == pytest.approx((lag, 9 - lag))
    assert to_hex(np.atleast_2d(bars.get_facecolor())[0]) == robot_colours(3)[1]


def test_a_team_without_cut_vertices_has_no_rows() -> None:
    assert len(strips_of(draw(column(), contact=9.0))) == 1


def test_lambda2_that_varies_much_is_drawn_on_a_logarithmic_scale() -> None:
    n = 9
    robots = [Robot(f"R{k}", (1 + k / 4, 1), (1.5 + 2 * k, 1)) for k in range(n)]
    moves = tuple(walk(r.name, [r.start, r.goal]) for r in robots)
    plan = Plan(Scene((0, 0, 20, 2), [], robots, gap=0.01), moves)
    assert strips_of(draw(plan, contact=2.2))[0].get_yscale() == "log"
    assert strips_of(draw(column(), contact=2.1))[0].get_yscale() == "linear"


def test_robots_that_have_left_have_no_links_and_one_robot_alone_has_no_lambda2() -> None:
    plan = column(at_goal="leave")  # A and B leave at 8 s, C at 9 s
    values, edges = steps_of(strips_of(draw(plan, contact=2.5))[0])
    assert values[np.searchsorted(edges, 7.9, side="right") - 1] == pytest.approx(1.0)
    assert math.isnan(values[np.searchsorted(edges, 8.5, side="right") - 1])
    assert links_of(draw(plan, contact=2.5, time=8.5)) == []
    assert len(links_of(draw(plan, contact=2.5, time=7.5))) == 2


def test_in_sight_is_said_and_needs_sight() -> None:
    wall = Scene((0, 0, 10, 6), [], column().scene.robots)
    plan = Plan(wall, column().trajectories)
    strip = strips_of(draw(plan, contact=Contact(2.5, sight=True)))[0]
    assert "λ2, links within 2.5 m and in sight" in texts(strip)


def test_axes_given_get_the_links_but_nothing_below() -> None:
    figure = Figure(figsize=(6, 4))
    FigureCanvasAgg(figure)
    axes = figure.add_subplot()
    draw(column(), axes, contact=2.5)
    assert figure.axes == [axes]
    assert tuple(figure.get_size_inches()) == (6, 4)
    assert len(links_of(axes)) == 2


def test_the_sheet_grows_by_the_strips_and_the_map_keeps_its_size() -> None:
    plain, linked = draw(column()), draw(column(), contact=2.1)
    for axes in (plain, linked):
        figure_of(axes).canvas.draw()
    before, after = plain.get_window_extent(), linked.get_window_extent()
    assert (after.width, after.height) == pytest.approx((before.width, before.height))
    tops = [strip.get_window_extent() for strip in strips_of(linked)]
    assert all(strip.y0 > 0 and strip.y1 < after.y0 for strip in tops)
    assert tops[0].y0 > tops[1].y1


@pytest.mark.parametrize(
    "claim",
    [None, {}, 5, "near", [], ["range"], {"range": -1}, {"range": "far"}, {"range": 2.5, "colour": 1}, {"sight": True}],
)
def test_a_claim_that_makes_no_sense_is_drawn_as_none(claim: object) -> None:
    assert svg_text(column({"contact": claim})) == svg_text(column())


def test_what_is_given_goes_before_what_is_claimed() -> None:
    plan = column({"contact": {"range": 2.1}})
    assert svg_text(plan) != svg_text(column())
    assert "λ2, links within 7 m" in texts(strips_of(draw(plan, contact=7))[0])


@pytest.mark.parametrize("n", [0, 1, MANY_LINKED + 1])
def test_one_robot_and_very_many_are_drawn_without(n: int) -> None:
    robots = [Robot(f"R{k}", (k, 1), (k, 1), radius=0.1) for k in range(n)]
    plan = Plan(Scene((-1, 0, n + 1, 2), [], robots), tuple(Trajectory(r.name, [[0, *r.start]]) for r in robots))  # type: ignore[arg-type]
    assert strips_of(draw(plan, contact=3)) == []


def test_still_robots_are_a_picture_too() -> None:
    robots = [Robot("A", (1, 1), (1, 1)), Robot("B", (2, 1), (2, 1))]
    moves = tuple(Trajectory(r.name, np.array([[0.0, *r.start]])) for r in robots)
    axes = draw(Plan(Scene((0, 0, 3, 2), [], robots, gap=0.1), moves), contact=1.0)
    assert len(links_of(axes)) == 1
    assert any("least 2" in text for text in texts(strips_of(axes)[0]))


def test_values_that_make_no_sense_are_refused(tmp_path: Path) -> None:
    with pytest.raises(SceneError, match="range"):
        draw(column(), contact=-1.0)
    with pytest.raises(SceneError, match="range"):
        animate(column(), tmp_path / "a.gif", contact=math.nan)
    with pytest.raises(TypeError, match="contact= needs a Plan"):
        draw(column().scene, contact=2.0)
    assert list(tmp_path.iterdir()) == []


def test_names_too_long_for_their_row_are_shortened() -> None:
    long = "robot with a name that goes on and on"
    plan = column()
    robots = [replace(robot, name=long if robot.name == "B" else robot.name) for robot in plan.scene.robots]
    moves = tuple(Trajectory(r.name, t.stamps) for r, t in zip(robots, plan.trajectories, strict=True))
    axes = draw(Plan(replace(plan.scene, robots=tuple(robots)), moves), contact=2.5)
    rows = strips_of(axes)[1]
    (name,) = [text for text in rows.texts if text.get_text().endswith("…")]
    figure_of(axes).canvas.draw()
    assert long.startswith(name.get_text()[:-1])
    assert name.get_window_extent().x0 > 0


@pytest.mark.parametrize("kind", ["png", "svg", "pdf"])
def test_the_same_plan_gives_the_same_file(tmp_path: Path, kind: str) -> None:
    for name in ("a", "b"):
        save_figure(column({"contact": {"range": 2.1}}), tmp_path / f"{name}.{kind}")
    save_figure(column(), tmp_path / f"c.{kind}", contact=2.1)
    first = (tmp_path / f"a.{kind}").read_bytes()
    assert (tmp_path / f"b.{kind}").read_bytes() == first
    assert (tmp_path / f"c.{kind}").read_bytes() == first


# --- animations


def frames_of(path: Path) -> list[NDArray[np.uint8]]:
    with Image.open(path) as film:
        out = []
        for k in range(getattr(film, "n_frames", 1)):
            film.seek(k)
            out.append(np.asarray(film.convert("RGB")))
        return out


def spots(picture: NDArray[np.uint8], colour: str) -> NDArray[np.bool_]:
    return np.asarray((picture == [round(255 * c) for c in to_rgb(colour)]).all(axis=2))


def test_without_contact_a_film_is_what_it_was(tmp_path: Path) -> None:
    films = {
        "plain": column(),
        "nothing claimed": column({"contact": None}),
        "nonsense claimed": column({"contact": {"range": -3}}),
        "something else claimed": column({"speed": 3}),
        "linked": column({"contact": {"range": 2.1}}),
    }
    for name, plan in films.items():
        animate(plan, tmp_path / f"{name}.gif", seconds=0.4, width=300)
    bytes_of = {name: (tmp_path / f"{name}.gif").read_bytes() for name in films}
    same = [name for name in films if bytes_of[name] == bytes_of["plain"]]
    assert same == [name for name in films if name != "linked"]


def test_the_same_plan_gives_the_same_film_claimed_or_given(tmp_path: Path) -> None:
    claimed = column({"contact": {"range": 2.1}})
    for name, plan, contact in (("a", claimed, None), ("b", claimed, None), ("c", column(), 2.1)):
        animate(plan, tmp_path / f"{name}.gif", seconds=0.4, width=300, contact=contact)
    first = (tmp_path / "a.gif").read_bytes()
    assert [(tmp_path / name).read_bytes() == first for name in ("b.gif", "c.gif")] == [True, True]


def test_links_follow_the_robots_and_turn_red_when_they_are_bridges(tmp_path: Path) -> None:
    animate(column(), tmp_path / "a.gif", fps=10, seconds=0.9, width=500, contact=4.05)
    frames, plain = frames_of(tmp_path / "a.gif"), frames_of_plain(tmp_path)
    red = [spots(frame, BRIDGE)[: len(plain[0])] for frame in frames]
    # starts are red too, and so is the legend
    bridges = [mask & ~spots(bare, BRIDGE) & ~red[0] for mask, bare in zip(red, plain, strict=False)]
    # a frame is a second: nothing is a bridge up to 0.63 s and from 8.37 s on, while all three are in contact
    assert [bool(mask.sum() > 20) for mask in bridges[:10]] == [False, *[True] * 8, False]
    middles = [float(np.flatnonzero(mask.any(axis=0)).mean()) for mask in bridges[1:9]]
    assert (np.diff(middles) > 20).all()


def frames_of_plain(folder: Path) -> list[NDArray[np.uint8]]:
    animate(column(), folder / "plain.gif", fps=10, seconds=0.9, width=500)
    return frames_of(folder / "plain.gif")


def test_the_hand_goes_evenly_over_the_course_and_the_red_band_stays(tmp_path: Path) -> None:
    animate(column(), tmp_path / "a.gif", fps=10, seconds=1.8, width=500, contact=2.1)
    frames = frames_of(tmp_path / "a.gif")[:19]
    high = len(frames_of_plain(tmp_path)[0])
    columns = []
    for frame in frames:
        ink = spots(frame, INK)[high:]
        columns.append(int(np.argmax(ink.sum(axis=0))))
    steps = np.diff(columns)
    assert (steps > 0).all()
    assert steps == pytest.approx([steps.mean()] * 18, abs=1.5)
    bands = [spots(frame, APART)[high:].any(axis=0) for frame in frames]
    assert all(band.sum() > 0.8 * 7.72 / 9 * 400 for band in bands)


def test_a_film_is_as_wide_as_asked_and_longer_by_the_strip(tmp_path: Path) -> None:
    animate(column(), tmp_path / "a.gif", fps=10, seconds=0.9, width=500, contact=2.1)
    linked, plain = frames_of(tmp_path / "a.gif")[0], frames_of_plain(tmp_path)[0]
    assert linked.shape[1] == plain.shape[1]
    assert 100 < linked.shape[0] - plain.shape[0] < 250
    assert spots(linked, OUTSIDE).any()
    assert spots(linked, LINK).any()


def test_pictures_for_notebooks_show_contact() -> None:
    from taut.figures import png_bytes

    with Image.open(io.BytesIO(png_bytes(column({"contact": {"range": 2.1}})))) as picture:
        assert spots(np.asarray(picture.convert("RGB")), APART).any()
