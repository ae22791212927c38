"""Pictures of stages show what they must; albums are whole, and touch only their own files."""

from __future__ import annotations

import json
import os
from collections.abc import Callable
from dataclasses import replace
from itertools import pairwise
from pathlib import Path
from typing import Any, TypeVar, get_args

import numpy as np
import pytest
from matplotlib.axes import Axes
from matplotlib.collections import LineCollection, PathCollection
from matplotlib.colors import to_hex
from PIL import Image

import taut
from taut.errors import OutputError
from taut.figures import draw, save_stages
from taut.figures.album import INDEX, require_album
from taut.figures.canvas import sheet
from taut.figures.grounds import FAINT, SIDES, opacity
from taut.figures.maps import scene_view
from taut.figures.stages import FEW_CONFLICTS, KINDS, draw_stage
from taut.figures.style import GRAPH, INK, mix, robot_colours
from taut.team.conflicts import Conflict, Kind
from taut.team.stages import (
    BridgeStage,
    FirstPathStage,
    FreeSpaceStage,
    FullGraphStage,
    ObstacleGraphStage,
    SequenceStage,
    SplitStage,
    Stage,
)
from taut.team.telling import title

READY = ("thesis-1", "hospital-12")
SomeStage = TypeVar("SomeStage", bound=Stage)
Segments = set[tuple[tuple[float, float], ...]]


@pytest.fixture(scope="module")
def stages_of() -> Callable[[str], tuple[Stage, ...]]:
    known: dict[str, tuple[Stage, ...]] = {}

    def get(name: str) -> tuple[Stage, ...]:
        if name not in known:
            known[name] = taut.plan(taut.load_scene(name), method="mrppa").stages
        return known[name]

    return get


@pytest.fixture(params=READY)
def stages(request: pytest.FixtureRequest, stages_of: Callable[[str], tuple[Stage, ...]]) -> tuple[Stage, ...]:
    return stages_of(request.param)


@pytest.fixture
def thesis(stages_of: Callable[[str], tuple[Stage, ...]]) -> tuple[Stage, ...]:
    return stages_of("thesis-1")


@pytest.fixture
def hospital(stages_of: Callable[[str], tuple[Stage, ...]]) -> tuple[Stage, ...]:
    return stages_of("hospital-12")


def of_kind(stages: tuple[Stage, ...], kind: type[SomeStage]) -> list[SomeStage]:
    return [stage for stage in stages if isinstance(stage, kind)]


def told_by(stage: SequenceStage) -> list[Conflict]:
    return [conflict for name in stage.order for conflict in stage.conflicts[name]]


def picture(stage: Stage, number: int | None = None) -> Axes:
    scene = stage.plan.scene if isinstance(stage, SequenceStage) else stage.ground.freespace.scene
    axes = sheet(scene_view(scene))
    draw_stage(axes, stage, number)
    return axes


def render(axes: Axes) -> None:
    canvas: Any = axes.figure.canvas
    canvas.draw()


def texts(axes: Axes) -> list[str]:
    return [text.get_text() for text in axes.texts]


def legend(axes: Axes) -> list[str]:
    found = axes.get_legend()
    return [] if found is None else [text.get_text() for text in found.get_texts()]


def facts(axes: Axes) -> str:
    return axes.get_title("right")


def segments(axes: Axes, colour: str, style: str = "solid") -> Segments:
    """Return the straight pieces drawn in that colour, ends in order; style "solid" or "broken"."""
    found: Segments = set()
    for lines in axes.collections:
        if not isinstance(lines, LineCollection) or to_hex(lines.get_color()[0]) != colour:  # type: ignore[arg-type]
            continue
        if (lines.get_linestyle()[0][1] is None) == (style == "solid"):  # type: ignore[index]
            for piece in lines.get_segments():
                corners = [(float(x), float(y)) for x, y in piece]
                found |= {tuple(sorted(pair)) for pair in pairwise(corners)}
    return found


def edges_of(stage: Any, which: Any) -> Segments:
    ground = stage.ground
    ends = ground.roadmap.positions[ground.roadmap.edges[which]]
    return {tuple(sorted((float(x), float(y)) for x, y in pair)) for pair in ends}


# What each kind of stage shows


def test_every_stage_is_drawn_with_its_number_and_title(stages: tuple[Stage, ...]) -> None:
    one_of_each = {type(stage): (number, stage) for number, stage in enumerate(stages, 1)}
    assert set(one_of_each) == set(get_args(Stage))
    for number, stage in one_of_each.values():
        axes = picture(stage, number)
        render(axes)
        assert axes.get_title("left").startswith(f"Stage {number} · {title(stage)}")
        assert facts(axes)
        assert {"start", "goal"} <= set(legend(axes))


def test_without_a_number_the_title_stands_alone(thesis: tuple[Stage, ...]) -> None:
    assert picture(thesis[0]).get_title("left") == "Free space"


def test_teams_of_several_sizes_have_the_size_in_the_title(hospital: tuple[Stage, ...]) -> None:
    for stage in of_kind(hospital, FullGraphStage):
        assert picture(stage, 1).get_title("left").endswith(f"growth {stage.ground.freespace.growth:g} m")


def test_free_space_names_the_robots_of_its_size_and_tells_of_the_band(hospital: tuple[Stage, ...]) -> None:
    for stage in of_kind(hospital, FreeSpaceStage):
        axes = picture(stage)
        everyone = {robot.name for robot in stage.ground.freespace.scene.robots}
        assert everyone & set(texts(axes)) == set(stage.ground.robots)
        assert "too near for the robot's centre" in legend(axes)
        assert f"radius + clearance {stage.ground.freespace.growth:g} m" in facts(axes)


def test_point_robots_have_no_band(thesis: tuple[Stage, ...]) -> None:
    assert legend(picture(of_kind(thesis, FreeSpaceStage)[0])) == ["start", "goal"]


def test_obstacle_graph_draws_the_outlines_only(stages: tuple[Stage, ...]) -> None:
    for stage in of_kind(stages, ObstacleGraphStage):
        axes = picture(stage)
        assert segments(axes, INK) == edges_of(stage, stage.ground.on_obstacles)
        assert "λ2 = 0" in facts(axes)


def test_few_vertices_are_numbered_and_few_edges_measured(
    thesis: tuple[Stage, ...], hospital: tuple[Stage, ...]
) -> None:
    stage = of_kind(thesis, ObstacleGraphStage)[0]
    written = texts(picture(stage))
    assert {f"v{k}" for k in range(1, 29)} <= set(written)
    lengths = stage.ground.roadmap.lengths[stage.ground.on_obstacles]
    assert sorted(t for t in written if t[0].isdigit()) == sorted(f"{length:.3g}" for length in lengths)
    assert not [t for t in texts(picture(of_kind(hospital, ObstacleGraphStage)[0])) if t.startswith("v")]


def test_split_draws_each_side_in_its_hue_and_no_edge_between_them(stages: tuple[Stage, ...]) -> None:
    for stage in of_kind(stages, SplitStage):
        axes = picture(stage)
        ends = stage.side[stage.ground.roadmap.edges]
        for side in (0, 1):
            assert segments(axes, SIDES[side]) == edges_of(stage, stage.edges & (ends == side).all(axis=1))
            n = int((stage.side == side).sum())
            assert f"{('other side', 'one side')[side]}, {n} {'vertex' if n == 1 else 'vertices'}" in legend(axes)
        assert segments(axes, GRAPH, "broken") == edges_of(stage, ~stage.edges)
        assert facts(axes).startswith("λ2 = 0")


def test_split_tints_each_obstacle_by_its_side(thesis: tuple[Stage, ...]) -> None:
    stage = of_kind(thesis, SplitStage)[0]
    scene = stage.ground.freespace.scene
    axes = picture(stage)
    marks = [c for c in axes.collections if isinstance(c, PathCollection)]
    drawn = next(mark for mark in marks if len(mark.get_paths()) == len(scene.obstacles))
    faces = [to_hex(face) for face in np.asarray(drawn.get_facecolor())]
    for obstacle, face in zip(scene.obstacles, faces, strict=True):
        group = next(g for g, members in enumerate(stage.ground.members) if obstacle.name in members)
        side = int(stage.side[stage.ground.groups == group][0])
        assert face == mix(SIDES[side], "#ffffff", 0.5)


def test_split_of_few_groups_writes_the_fiedler_vector(thesis: tuple[Stage, ...], hospital: tuple[Stage, ...]) -> None:
    stage = of_kind(thesis, SplitStage)[0]
    written = "\n".join(texts(picture(stage)))
    for value, members in zip(stage.values.tolist(), stage.ground.members, strict=True):
        number = f"{value:+.2f}".replace("-", "−")
        names = ", ".join(member.rpartition(" ")[0] for member in members)
        assert f"{members[0]}\n{number}" in written or f"{names} {number}" in written
    assert "Fiedler" in facts(picture(stage))
    assert "Fiedler" not in facts(picture(of_kind(hospital, SplitStage)[0]))


def test_nothing_to_split_is_said(thesis: tuple[Stage, ...]) -> None:
    stage = of_kind(thesis, SplitStage)[0]
    whole = replace(stage, side=np.ones_like(stage.side), edges=np.ones_like(stage.edges))
    assert facts(picture(whole)).startswith("nothing to remove")


def test_bridge_is_bold_its_rival_dashed_and_earlier_ones_stay_visible(stages: tuple[Stage, ...]) -> None:
    for stage in of_kind(stages, BridgeStage):
        split = stage.cut
        axes = picture(stage)
        robots = stage.ground.freespace.scene.robots
        colour = robot_colours(len(robots))[[robot.name for robot in robots].index(stage.robot)]
        assert segments(axes, colour) == edges_of(stage, [stage.edge])
        assert stage.runner_up is not None
        assert segments(axes, INK, "broken") == edges_of(stage, [stage.runner_up])
        earlier = stage.edges & ~split.edges
        earlier[stage.edge] = False
        assert segments(axes, INK) == edges_of(stage, earlier)
        assert ("earlier bridge" in legend(axes)) == bool(earlier.any())
        assert texts(axes).count(stage.robot) == 2
        assert f"λ2 = {stage.after:.4f}" in texts(axes)
        assert facts(axes).startswith("λ2 ")
        assert f"→ {stage.after:.4f}" in facts(axes)


def test_bridge_without_a_rival_has_none_in_its_legend(thesis: tuple[Stage, ...]) -> None:
    stage = replace(of_kind(thesis, BridgeStage)[0], runner_up=None, runner_up_after=None)
    assert "runner-up" not in legend(picture(stage))


def test_first_path_is_drawn_with_its_length_over_the_faint_sides(stages: tuple[Stage, ...]) -> None:
    for stage in of_kind(stages, FirstPathStage):
        split = stage.cut
        axes = picture(stage)
        robots = stage.ground.freespace.scene.robots
        colour = robot_colours(len(robots))[[robot.name for robot in robots].index(stage.robot)]
        places = [tuple(place) for place in stage.ground.roadmap.positions[stage.path].tolist()]
        assert segments(axes, colour) == {tuple(sorted(pair)) for pair in pairwise(places)}
        assert f"{stage.length:.4f} m" in texts(axes)
        own = split.edges & (split.side[stage.ground.roadmap.edges] == 1).all(axis=1)
        assert segments(axes, mix(SIDES[1], "#ffffff", FAINT)) == edges_of(stage, own)


def test_a_robot_at_its_goal_has_a_first_path_of_one_vertex(thesis: tuple[Stage, ...]) -> None:
    stage = of_kind(thesis, FirstPathStage)[0]
    assert facts(picture(replace(stage, path=stage.path[:1], length=0.0))) == "0.0000 m · 0 edges"


def test_full_graph_draws_every_edge(stages: tuple[Stage, ...]) -> None:
    for stage in of_kind(stages, FullGraphStage):
        axes = picture(stage)
        assert segments(axes, INK) == edges_of(stage, slice(None))
        assert f"λ2 = {stage.connectivity:.4f}" in facts(axes)


def test_edges_are_paler_the_more_there_are_and_never_invisible() -> None:
    values = [opacity(m) for m in (0, 1, 100, 1000, 15_000, 10**7)]
    assert values == sorted(values, reverse=True)
    assert values[0] <= 1
    assert values[-1] > 8 / 255


def conflict_marks(axes: Axes) -> int:
    """Return how many marks the kinds of conflict in the legend have on the map."""
    marks = [c for c in axes.collections if isinstance(c, PathCollection) and c.get_zorder() == 7.5]
    return sum(len(np.asarray(mark.get_offsets())) for mark in marks)


def test_sequence_marks_every_conflict_and_numbers_few(hospital: tuple[Stage, ...]) -> None:
    stage = of_kind(hospital, SequenceStage)[0]
    met = told_by(stage)
    assert 0 < len(met) <= FEW_CONFLICTS
    axes = picture(stage)
    assert conflict_marks(axes) == len(met)
    assert {str(k) for k in range(1, len(met) + 1)} <= set(texts(axes))
    assert set(KINDS) & set(legend(axes)) == {conflict.kind for conflict in met}
    assert facts(axes).startswith(f"{len(met)} conflicts")


def test_sequence_marks_many_conflicts_without_numbers(hospital: tuple[Stage, ...]) -> None:
    stage = of_kind(hospital, SequenceStage)[0]
    name = next(name for name in stage.order if stage.conflicts[name])
    many = replace(stage, conflicts={name: stage.conflicts[name][:1] * (FEW_CONFLICTS + 1)})
    axes = picture(many)
    assert conflict_marks(axes) == FEW_CONFLICTS + 1
    assert not {"1", str(FEW_CONFLICTS + 1)} & set(texts(axes))


def test_sequence_without_conflicts_has_none_in_its_legend(thesis: tuple[Stage, ...]) -> None:
    stage = of_kind(thesis, SequenceStage)[0]
    none = replace(stage, conflicts=dict.fromkeys(stage.order, ()))
    assert legend(picture(none)) == ["start", "goal"]


def test_every_kind_of_conflict_has_its_own_mark() -> None:
    assert set(KINDS) == set(get_args(Kind))
    assert len({marker for marker, _ in KINDS.values()}) == len(KINDS)


def test_texts_do_not_lie_on_each_other(thesis: tuple[Stage, ...]) -> None:
    for stage in thesis:
        axes = picture(stage, 1)
        render(axes)
        boxes = [text.get_window_extent() for text in axes.texts if text.get_text()]
        for k, box in enumerate(boxes):
            assert not any(box.overlaps(other) for other in boxes[:k])


def test_stages_fit_on_axes_of_ones_own(thesis: tuple[Stage, ...]) -> None:
    from matplotlib.figure import Figure

    axes = Figure(figsize=(4, 4)).add_subplot()
    draw_stage(axes, thesis[1])
    assert axes.get_xlim()[0] < 0
    assert axes.get_xlim()[1] > 16


# The one entry to pictures


def test_draw_takes_every_stage(thesis: tuple[Stage, ...]) -> None:
    for stage in thesis:
        assert draw(stage).get_title("left") == title(stage)


def test_draw_refuses_a_graph_or_a_time_with_a_stage(thesis: tuple[Stage, ...]) -> None:
    with pytest.raises(TypeError, match="graph="):
        draw(thesis[0], graph=of_kind(thesis, FullGraphStage)[0].ground.roadmap)
    with pytest.raises(TypeError, match="time="):
        draw(thesis[-1], time=1.0)


# Albums


@pytest.fixture
def unpainted(monkeypatch: pytest.MonkeyPatch) -> None:
    """Leave the pictures of albums empty, where only files matter."""
    monkeypatch.setattr("taut.figures.album._write_picture", lambda _, path: path.write_bytes(b""))


def test_an_album_has_three_files_a_stage_and_an_index(thesis: tuple[Stage, ...], tmp_path: Path) -> None:
    home = tmp_path / "new" / "album"
    require_album(home)
    assert not home.exists()
    written = save_stages(thesis, home)
    assert written[-1] == home / INDEX
    assert sorted(written) == sorted(home.iterdir())
    index = json.loads(written[-1].read_text(encoding="utf-8"))
    assert (index["taut"], index["kind"], len(index["stages"])) == (1, "stages", len(thesis))
    assert index["stages"][0]["files"] == ["01-free-space.png", "01-free-space.txt", "01-free-space.json"]
    for number, (stage, entry) in enumerate(zip(thesis, index["stages"], strict=True), 1):
        picture, text, data = (home / name for name in entry["files"])
        assert (entry["number"], entry["title"]) == (number, title(stage))
        with Image.open(picture) as image:
            assert image.format == "PNG"
        assert text.read_text(encoding="utf-8").startswith(f"Stage {number} · {title(stage)}\n\n")
        assert json.loads(data.read_text(encoding="utf-8"))["kind"] == entry["kind"]


@pytest.mark.usefixtures("unpainted")
def test_the_text_numbers_the_conflicts_as_the_picture_does(hospital: tuple[Stage, ...], tmp_path: Path) -> None:
    stage = of_kind(hospital, SequenceStage)[0]
    save_stages([stage], tmp_path)
    lines = (tmp_path / "01-sequence.txt").read_text(encoding="utf-8").splitlines()
    for number, conflict in enumerate(told_by(stage), 1):
        assert any(line.startswith(f"{number}. {conflict.robot} ") and conflict.other in line for line in lines)


def test_numbers_have_as_many_digits_as_the_last(thesis: tuple[Stage, ...], tmp_path: Path) -> None:
    from taut.figures.album import _entries

    assert _entries([thesis[0]] * 100)[0]["files"][0] == "001-free-space.png"


@pytest.mark.usefixtures("unpainted")
def test_an_album_is_written_anew_and_removes_only_its_own_files(thesis: tuple[Stage, ...], tmp_path: Path) -> None:
    first = save_stages(thesis[:4], tmp_path)
    (tmp_path / "notes.md").write_text("mine")
    require_album(tmp_path)
    second = save_stages(thesis[:2], tmp_path)
    assert set(second) < set(first)
    assert {path.name for path in tmp_path.iterdir()} == {"notes.md", *(path.name for path in second)}


def test_an_album_drawn_twice_is_the_same_byte_for_byte(thesis: tuple[Stage, ...], tmp_path: Path) -> None:
    one, two = (save_stages(thesis[1:3], tmp_path / name) for name in ("one", "two"))
    assert [path.read_bytes() for path in one] == [path.read_bytes() for path in two]


@pytest.mark.usefixtures("unpainted")
@pytest.mark.parametrize(
    "name", ["../outside.txt", "sub/inside.txt", "..", ".", "", "sub", "a\\b", "a\0b", "{absolute}"]
)
def test_names_in_an_index_that_are_not_plain_files_are_left_alone(
    name: str, thesis: tuple[Stage, ...], tmp_path: Path
) -> None:
    home = tmp_path / "album"
    (home / "sub").mkdir(parents=True)
    others = [tmp_path / "outside.txt", home / "sub" / "inside.txt", home / "a\\b"]
    for other in others:
        other.write_text("mine")
    listed = name.replace("{absolute}", str(others[0]))
    (home / INDEX).write_text(json.dumps({"taut": 1, "kind": "stages", "stages": [{"files": [listed, "old.png"]}]}))
    (home / "old.png").write_text("album")
    save_stages(thesis[:1], home)
    assert all(other.read_text() == "mine" for other in others)
    assert not (home / "old.png").exists()


def test_an_album_broken_off_can_be_written_again(
    thesis: tuple[Stage, ...], tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    def interrupted(_: Axes, path: Path) -> None:
        path.write_bytes(b"")
        if path.name.startswith("02"):
            raise KeyboardInterrupt

    monkeypatch.setattr("taut.figures.album._write_picture", interrupted)
    with pytest.raises(KeyboardInterrupt):
        save_stages(thesis[3:6], tmp_path)
    assert (tmp_path / "01-bridge.png").exists()
    require_album(tmp_path)
    written = save_stages(thesis[:1], tmp_path)
    assert sorted(written) == sorted(tmp_path.iterdir())


def refused(folder: Path, stages: tuple[Stage, ...]) -> str:
    """Return the one line with which both the check before and the writing refuse that folder."""
    told = []
    for attempt in (lambda: require_album(folder), lambda: save_stages(stages[:1], folder)):
        with pytest.raises(OutputError) as caught:
            attempt()
        told.append(str(caught.value))
    assert len(told[0].splitlines()) == 1
    assert str(folder) in told[0]
    return told[0]


def test_a_folder_with_other_files_is_refused_and_left_as_it_is(thesis: tuple[Stage, ...], tmp_path: Path) -> None:
    (tmp_path / "thesis.tex").write_text("mine")
    assert "files that are not stages" in refused(tmp_path, thesis)
    assert [path.name for path in tmp_path.iterdir()] == ["thesis.tex"]


@pytest.mark.parametrize(
    "text",
    [
        "",
        "[]",
        "{",
        '{"taut": 1, "kind": "plan", "stages": []}',
        '{"taut": 2, "kind": "stages", "stages": []}',
        '{"taut": 1, "kind": "stages"}',
        '{"taut": 1, "kind": "stages", "stages": [1]}',
        '{"taut": 1, "kind": "stages", "stages": [{"files": [1]}]}',
        '{"taut": 1, "kind": "stages", "stages": 3}',
        "[" * 100_000,
        "\ud800",
    ],
)
def test_an_index_that_is_not_ours_is_refused(text: str, thesis: tuple[Stage, ...], tmp_path: Path) -> None:
    (tmp_path / INDEX).write_bytes(text.encode("utf-8", "surrogatepass"))
    assert "not an index of stages" in refused(tmp_path, thesis)


def test_a_place_that_is_no_folder_is_refused(thesis: tuple[Stage, ...], tmp_path: Path) -> None:
    (tmp_path / "file").write_text("mine")
    assert "not a folder" in refused(tmp_path / "file", thesis)
    assert "cannot be written" in refused(tmp_path / "file" / "album", thesis)


@pytest.mark.skipif(not Path("/proc/self").exists(), reason="needs a file system that nobody can write")
def test_a_folder_that_nobody_can_write_is_refused(thesis: tuple[Stage, ...]) -> None:
    assert "cannot be written" in refused(Path("/proc/album"), thesis)


@pytest.mark.skipif(os.geteuid() == 0, reason="root writes everywhere")
def test_a_folder_without_the_right_to_write_is_refused(thesis: tuple[Stage, ...], tmp_path: Path) -> None:
    tmp_path.chmod(0o500)
    assert "cannot be written" in refused(tmp_path, thesis)
