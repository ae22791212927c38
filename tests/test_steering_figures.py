"""Pictures of teams that steered themselves: ways, ends, collisions and connectivity are where they were."""

from __future__ import annotations

from itertools import combinations
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from matplotlib.axes import Axes
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.collections import LineCollection, PathCollection
from matplotlib.figure import Figure
from numpy.typing import NDArray

from taut.control import consensus, formation
from taut.errors import OutputError
from taut.figures import animate, draw, draw_steered, png_bytes, save_figure, save_steered
from taut.graph import Graph, contact_graph
from taut.scene import FloatArray, Robot, Scene
from taut.simulation import Steered, fiedler_values, steer

STARTS = ((1.0, 1.0), (7.0, 2.0), (6.0, 7.0), (2.0, 5.0))


def team(n: int = 4, radius: float = 0.2) -> Scene:
    robots = [Robot(f"R{k + 1}", at, at, radius=radius) for k, at in enumerate(STARTS[:n])]
    return Scene((0, 0, 10, 10), robots=robots, name="team", gap=0.1)


def complete(n: int) -> Graph:
    return Graph.from_edges(n, list(combinations(range(n), 2)))


def near(places: FloatArray) -> Graph:
    return contact_graph(places, 6.0)


@pytest.fixture(scope="module")
def gathered() -> Steered:
    """Discs that gather at one point, and collide there."""
    return steer(team(), consensus(complete(4)), seconds=20.0)


def segments(axes: Axes, zorder: float) -> list[NDArray[np.float64]]:
    parts = [part for part in axes.collections if isinstance(part, LineCollection) and part.get_zorder() == zorder]
    return [np.asarray(segment) for part in parts for segment in part.get_segments()]


def places(axes: Axes, zorder: float) -> NDArray[np.float64]:
    parts = [part for part in axes.collections if isinstance(part, PathCollection) and part.get_zorder() == zorder]
    return np.concatenate([np.empty((0, 2)), *(np.asarray(part.get_offsets()) for part in parts)])


def strips_of(axes: Axes) -> list[Axes]:
    figure = axes.get_figure(root=True)
    assert isinstance(figure, Figure)
    return [other for other in figure.axes if other is not axes]


def test_the_ways_drawn_are_those_driven(gathered: Steered) -> None:
    axes = draw_steered(gathered)
    for k, way in enumerate(segments(axes, 6.2)):
        assert way == pytest.approx(gathered.poses[:, k, :2])
    assert len(segments(axes, 6.2)) == 4
    assert places(axes, 6.5) == pytest.approx(np.array(STARTS))
    assert strips_of(axes) == []


def test_robots_look_where_they_looked(gathered: Steered) -> None:
    ends, headings = gathered.poses[-1, :, :2], gathered.poses[-1, :, 2]
    for nose, end, heading in zip(segments(draw_steered(gathered), 8.2), ends, headings, strict=True):
        assert nose == pytest.approx(np.array([end, end + 0.2 * np.array([np.cos(heading), np.sin(heading)])]))


def test_collisions_are_crossed_and_the_first_is_told(gathered: Steered) -> None:
    axes = draw_steered(gathered)
    first = gathered.collisions[0]
    assert places(axes, 9) == pytest.approx(np.array([hit.place for hit in gathered.collisions]))
    told = [text.get_text() for text in axes.texts if "hits" in text.get_text()]
    assert told == [f"{first.robot} hits {first.other}\n{first.time:.1f} s"]
    assert f"{len(gathered.collisions)} collisions" in axes.get_title(loc="right")


def test_links_of_the_end_are_drawn_and_connectivity_runs_on_a_strip() -> None:
    run = steer(team(), formation(complete(4), np.array([(0, 0), (5, 0), (5, 5), (0, 5)])))
    axes = draw_steered(run, near)
    ends = run.poses[-1, :, :2]
    links = segments(axes, 6.0)
    assert len(links) == 4  # the sides: the diagonals are longer than the reach
    assert {tuple(np.round(link.mean(axis=0), 6)) for link in links} == {
        tuple(np.round((ends[i] + ends[j]) / 2, 6)) for i, j in near(ends).edges
    }
    (strip,) = strips_of(axes)
    course = np.asarray(strip.lines[0].get_xydata())
    assert course == pytest.approx(np.column_stack([run.times, fiedler_values(run, near)]))
    assert "settled after" in axes.get_title(loc="right")
    assert "no collision" in axes.get_title(loc="right")


def test_who_has_not_settled_is_said_not_to_have() -> None:
    run = steer(team(), consensus(complete(4)), seconds=1.0)
    assert "not settled in 1.0 s" in draw(run).get_title(loc="right")


def test_draw_save_and_notebooks_take_a_steered_team(gathered: Steered, tmp_path: Path) -> None:
    axes = draw(gathered)
    assert len(segments(axes, 6.2)) == len(segments(axes, 8.2)) == 4
    save_figure(gathered, tmp_path / "a.svg")
    save_steered(gathered, tmp_path / "b.svg")
    assert (tmp_path / "a.svg").read_bytes() == (tmp_path / "b.svg").read_bytes()
    save_steered(gathered, tmp_path / "c.svg", complete(4))
    assert (tmp_path / "a.svg").read_bytes() != (tmp_path / "c.svg").read_bytes()
    assert png_bytes(gathered).startswith(b"\x89PNG")
    with pytest.raises(OutputError, match=r"\.bmp"):
        save_steered(gathered, tmp_path / "a.bmp")


def test_axes_given_get_the_map_alone(gathered: Steered) -> None:
    figure = Figure(figsize=(6, 4))
    FigureCanvasAgg(figure)
    axes = figure.add_subplot()
    assert draw_steered(gathered, complete(4), axes) is axes
    assert draw(gathered, axes) is axes
    assert figure.axes == [axes]


@pytest.mark.parametrize("more", [{"time": 1.0}, {"contact": 2.0}, {"routes": {}}, {"graph": object()}])
def test_what_does_not_go_with_a_steered_team_is_refused(gathered: Steered, more: dict[str, Any]) -> None:
    with pytest.raises(TypeError, match=r"Steered|no graph="):
        draw(gathered, **more)


@pytest.mark.parametrize("n", [0, 1])
def test_small_teams_are_drawn(n: int) -> None:
    run = steer(team(n), consensus(complete(n)))
    assert len(segments(draw_steered(run, near), 6.2)) == n


def test_motions_of_a_steered_team_are_animated(gathered: Steered, tmp_path: Path) -> None:
    animate(gathered.plan, tmp_path / "a.gif", fps=5, seconds=0.4, width=200)
    assert (tmp_path / "a.gif").read_bytes().startswith(b"GIF89a")
