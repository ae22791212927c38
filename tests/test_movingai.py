"""MovingAI maps and scenarios: which cells become obstacles where, and what is refused with its line."""

from __future__ import annotations

import math
from pathlib import Path

import numpy as np
import pytest
import shapely
from hypothesis import given, settings
from hypothesis import strategies as st

from taut import FreeSpace, SceneError, load_map, load_scen, plan, validate
from taut.formats import free_cells
from taut.roadmap import grid_lanes

HEAD = "type octile\nheight 3\nwidth 4\nmap\n"
# row 0 stands at the top
SMALL = HEAD + "....\n.@T.\nG..S\n"
SCEN = "version 1\n0\tsmall.map\t4\t3\t0\t0\t3\t2\t5.0\n1\tsmall.map\t4\t3\t3\t0\t0\t2\t5.0\n"


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return tmp_path_factory.mktemp("maps")


def written(folder: Path, text: str, name: str = "small.map") -> Path:
    (folder / name).write_text(text)
    return folder / name


def test_row_0_is_at_the_top(folder: Path) -> None:
    scene = load_map(written(folder, HEAD + "@...\n....\n...@\n"))
    assert scene.workspace == ((-0.5, -0.5), (3.5, -0.5), (3.5, 2.5), (-0.5, 2.5))
    assert scene.name == "small"
    boxes = sorted(shapely.Polygon(o.core).bounds for o in scene.obstacles)
    assert boxes == [(-0.5, 1.5, 0.5, 2.5), (2.5, -0.5, 3.5, 0.5)]
    cells = free_cells(folder / "small.map")
    assert np.argwhere(~cells).tolist() == [[0, 3], [2, 0]]


def test_blocked_cells_side_by_side_are_one_obstacle_without_straight_corners(folder: Path) -> None:
    scene = load_map(written(folder, SMALL))
    assert [len(o.core) for o in scene.obstacles] == [4]
    assert validate(scene) == ()


@settings(max_examples=60, deadline=None)
@given(
    st.integers(1, 7).flatmap(lambda w: st.lists(st.text("..@TOWGS", min_size=w, max_size=w), min_size=1, max_size=7))
)
def test_obstacles_cover_exactly_the_blocked_cells(folder: Path, rows: list[str]) -> None:
    head = f"type octile\nheight {len(rows)}\nwidth {len(rows[0])}\nmap\n"
    scene = load_map(written(folder, head + "\n".join(rows), "random.map"))
    shapes = [shapely.Polygon(o.core) for o in scene.obstacles]
    assert all(shape.is_valid for shape in shapes)
    blocked = [
        shapely.box(c - 0.5, y - 0.5, c + 0.5, y + 0.5)
        for y, row in enumerate(reversed(rows))
        for c, cell in enumerate(row)
        if cell in "@TOW"
    ]
    assert shapely.equals(shapely.union_all(shapes), shapely.union_all(blocked))
    assert sum(shape.area for shape in shapes) == pytest.approx(len(blocked))
    validate(scene)
    free = free_cells(folder / "random.map")
    space = FreeSpace(scene, 0.25)
    np.testing.assert_array_equal(space.contains(grid_lanes(free).positions), np.ones(free.sum(), dtype=bool))


def test_a_wall_round_the_map_and_courtyards_keep_their_insides_free(folder: Path) -> None:
    rows = ["@@@@@@@", "@.....@", "@.@@@.@", "@.@.@.@", "@.@@@.@", "@.....@", "@@@@@@@"]
    scene = load_map(written(folder, "type octile\nheight 7\nwidth 7\nmap\n" + "\n".join(rows), "court.map"))
    free = FreeSpace(scene)
    assert free.area == pytest.approx(17)
    assert free.parts == 2


def test_cells_that_meet_in_a_corner_leave_no_way(folder: Path) -> None:
    scene = load_map(written(folder, "type octile\nheight 2\nwidth 2\nmap\n.@\n@.\n", "corner.map"))
    assert FreeSpace(scene).parts == 2


def test_robots_of_a_scenario_stand_where_it_says(folder: Path) -> None:
    scene = load_map(written(folder, SMALL))
    team = load_scen(written(folder, SCEN, "small.scen"), scene, robots=2, radius=0.25, speed=2)
    assert [(r.name, r.start, r.goal, r.radius, r.speed) for r in team.robots] == [
        ("R1", (0, 2), (3, 0), 0.25, 2),
        ("R2", (3, 2), (0, 0), 0.25, 2),
    ]
    assert team.obstacles == scene.obstacles
    assert len(load_scen(folder / "small.scen", scene).robots) == 2
    assert load_scen(folder / "small.scen", scene, robots=1).robots[0].radius == pytest.approx(math.sqrt(2) / 4)


def test_a_scenario_is_planned_on_the_lanes_of_its_map(folder: Path) -> None:
    scene = load_map(written(folder, SMALL))
    team = load_scen(written(folder, SCEN, "small.scen"), scene)
    found = plan(team, roadmap=grid_lanes(free_cells(folder / "small.map"), directions=8))
    assert found.certificate.ok
    # round the two blocked cells no diagonal step is left for discs of this size
    assert [motion.length for motion in found.plan.trajectories] == pytest.approx([5, 5])


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("", "is empty"),
        ("hello\n", "bad.map:1: expected type, height, width or map"),
        ("type octile\nheight 3\n", "has no line `map`"),
        ("type octile\nheight 3\nmap\n...\n", "bad.map:3: must tell height and width"),
        ("type octile\nheight x\nwidth 3\nmap\n", "bad.map:2: height must be a whole number, at least 1, got 'x'"),
        ("type octile\nheight 0\nwidth 3\nmap\n", "bad.map:2: height must be a whole number, at least 1"),
        (HEAD + "....\n....\n", "has 2 rows after the line `map`, but says height 3"),
        (HEAD + "....\n...\n....\n", "bad.map:6: this row has 3 cells, but the file says width 4"),
        (HEAD + "....\n..x.\n....\n", r"bad.map:6: unknown cell 'x'; known are \. G S"),
    ],
)
def test_what_is_wrong_in_a_map_is_told_with_its_line(folder: Path, text: str, message: str) -> None:
    with pytest.raises(SceneError, match=message) as caught:
        load_map(written(folder, text, "bad.map"))
    assert "\n" not in str(caught.value)


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("hello\n", "bad.scen:1: does not begin with `version 1`"),
        ("version 1\n1 2 3\n", "bad.scen:2: expected 9 words"),
        (SCEN.replace("\t4\t3\t3", "\t8\t6\t3"), "bad.scen:3: is for a map of 8 × 6 cells, this one has 4 × 3"),
        (SCEN.replace("3\t0\t0\t2", "4\t0\t0\t2"), "bad.scen:3: start x must be below 4, got 4"),
        (SCEN.replace("3\t0\t0\t2", "-1\t0\t0\t2"), "bad.scen:3: start x must be a whole number"),
    ],
)
def test_what_is_wrong_in_a_scenario_is_told_with_its_line(folder: Path, text: str, message: str) -> None:
    scene = load_map(written(folder, SMALL))
    with pytest.raises(SceneError, match=message):
        load_scen(written(folder, text, "bad.scen"), scene)


def test_more_robots_than_there_are_is_told(folder: Path) -> None:
    scene = load_map(written(folder, SMALL))
    path = written(folder, SCEN, "small.scen")
    with pytest.raises(SceneError, match="has 2 robots, not 3; ask for fewer"):
        load_scen(path, scene, robots=3)
    with pytest.raises(SceneError, match="must not be negative"):
        load_scen(path, scene, robots=-1)
    with pytest.raises(SceneError, match="does not exist"):
        load_map(folder / "none.map")


def test_a_scenario_of_nothing_but_line_ends_is_refused(folder: Path) -> None:
    scene = load_map(written(folder, HEAD + "....\n....\n....\n"))
    with pytest.raises(SceneError, match="does not begin with `version 1`"):
        load_scen(written(folder, "\u2028", "odd.scen"), scene)
