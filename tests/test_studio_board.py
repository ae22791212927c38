"""The board of the studio in a real browser: what it draws, and every tool by mouse, touch and keyboard."""

from __future__ import annotations

import json
import math
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import pytest

from studio_page import RunningStudio, wait_for, wait_until_ready
from taut.figures import style

if TYPE_CHECKING:
    from playwright.sync_api import Browser, Page

pytest_plugins = ("studio_page",)

SCENE: dict[str, Any] = {
    "taut": 1,
    "name": "board",
    "bounds": [0, 0, 16, 12],
    "clearance": 0.1,
    "gap": 0.1,
    "headway": 0,
    "at_goal": "stay",
    "obstacles": [
        {"name": "O1", "polygon": [[2, 2], [5, 2], [5, 4], [2, 4]]},
        {"name": "O2", "rectangle": [8, 2, 3, 2]},
        {"name": "O3", "circle": [4, 8], "radius": 1},
        {"name": "O4", "line": [[8, 8], [11, 8], [11, 10]], "width": 0.2},
    ],
    "robots": [
        {"name": "R1", "start": [1, 1], "goal": [14, 10], "radius": 0.3, "speed": 1},
        {"name": "R2", "start": [14, 1], "goal": [1, 10], "radius": 0.3, "speed": 1},
    ],
}

Point = tuple[float, float]


@dataclass(frozen=True)
class Hand:
    """What a user does on the board, in metres of the map."""

    page: Page

    def at(self, x: float, y: float) -> Point:
        """Return the pixel of the page at which a place is."""
        found = self.page.evaluate(
            """([x, y]) => {
              const { camera, width, height } = studio.board.window();
              const { left, top } = document.getElementById("board").getBoundingClientRect();
              return [left + (x - camera.x) * camera.scale + width / 2,
                      top + (camera.y - y) * camera.scale + height / 2];
            }""",
            [x, y],
        )
        return float(found[0]), float(found[1])

    def tool(self, name: str) -> None:
        """Choose a tool of the strip."""
        self.page.click(f'[data-tool="{name}"]')

    def click(self, *place: float) -> None:
        """Click a place."""
        self.page.mouse.click(*self.at(*place))

    def double(self, *place: float) -> None:
        """Double-click a place."""
        self.page.mouse.dblclick(*self.at(*place))

    def press(self, *place: float) -> None:
        """Press on a place and hold."""
        self.page.mouse.move(*self.at(*place))
        self.page.mouse.down()

    def pull(self, *place: float) -> None:
        """Move on to a place, in steps as a hand does."""
        self.page.mouse.move(*self.at(*place), steps=4)

    def drag(self, begin: Point, end: Point) -> None:
        """Press, pull, let go."""
        self.press(*begin)
        self.pull(*end)
        self.page.mouse.up()

    def state(self, expression: str = "") -> Any:
        """Return the state, or a part of it: `.scene.robots`."""
        return self.page.evaluate(f"studio.store.get(){expression}")

    def obstacle(self, name: str) -> dict[str, Any]:
        """Return an obstacle of the scene."""
        found: dict[str, Any] = next(o for o in self.state(".scene.obstacles") if o["name"] == name)
        return found

    def selected(self) -> list[str]:
        """Return what is selected: "O1", "R1 start", "R1 robot", "workspace", "O1 #2"."""
        words = []
        for ref in self.state(".selection"):
            kind = "" if ref["kind"] == "obstacle" else ref["kind"]
            vertex = f"#{ref['vertex']}" if "vertex" in ref else ""
            words.append(" ".join(part for part in (ref.get("name", ""), kind, vertex) if part))
        return words

    def steps(self) -> list[str]:
        """Return what can be undone, newest first."""
        found: list[str] = self.page.evaluate("studio.history.labels().undo")
        return found

    def grip(self, kind: str, index: int) -> Point:
        """Return the pixel of the page of a grip of the selection."""
        found = self.page.evaluate(
            """async ([kind, index]) => {
              const { gripsOf } = await import("studio/hit.js");
              const { scene, selection } = studio.store.get();
              const { left, top } = document.getElementById("board").getBoundingClientRect();
              const grip = gripsOf(studio.board.window(), scene, selection)
                .find((grip) => grip.kind === kind && grip.index === index);
              return [left + grip.pixel[0], top + grip.pixel[1]];
            }""",
            [kind, index],
        )
        return float(found[0]), float(found[1])

    def colour(self, x: float, y: float) -> tuple[int, int, int]:
        """Return the colour drawn at a place, after drawing."""
        found = self.page.evaluate(
            """([px, py]) => {
              studio.board.draw();
              const canvas = document.getElementById("board");
              const { left, top } = canvas.getBoundingClientRect();
              const ratio = canvas.width / canvas.clientWidth;
              return [...canvas.getContext("2d")
                .getImageData(Math.floor((px - left) * ratio), Math.floor((py - top) * ratio), 1, 1).data];
            }""",
            list(self.at(x, y)),
        )
        return int(found[0]), int(found[1]), int(found[2])


@pytest.fixture(scope="module")
def page(browser: Browser, studio: RunningStudio) -> Iterator[Page]:
    """Return one page for all tests: each shows a document of its own."""
    context = browser.new_context(viewport={"width": 1280, "height": 800})
    opened = context.new_page()
    errors: list[str] = []
    opened.on("pageerror", lambda error: errors.append(str(error)))
    opened.goto(studio.url)
    wait_until_ready(opened)
    yield opened
    context.close()
    assert not errors, errors


@pytest.fixture
def hand(page: Page) -> Hand:
    """Return a hand on a board that shows `SCENE`."""
    for key in ("Shift", "Control", "Alt"):
        page.keyboard.up(key)
    page.evaluate("studio.store.set({ tool: 'select', wallWidth: undefined })")
    show(page, SCENE)
    wait_for(page, "studio.store.get().planning.state === 'fresh'")
    wait_for(page, "studio.store.get().timelines !== null")
    page.wait_for_timeout(100)  # they have taken their room, the board its size
    page.evaluate("studio.commands.fit()")
    return Hand(page)


def show(page: Page, scene: dict[str, Any]) -> None:
    """Show a scene whole, as a new document."""
    page.evaluate("scene => { studio.history.replaceAll({ scene }); studio.commands.fit(); }", scene)


def module(page: Page, name: str, expression: str, argument: object = None) -> Any:
    """Evaluate an expression in which `m` is a module of the page and `a` the argument."""
    return page.evaluate(
        f"""async (a) => {{ const m = await import("studio/{name}.js"); return {expression}; }}""", argument
    )


def rgb(colour: str) -> tuple[int, int, int]:
    """Return a #rrggbb colour as numbers."""
    return int(colour[1:3], 16), int(colour[3:5], 16), int(colour[5:7], 16)


# What is drawn


def test_robots_have_the_hues_of_the_figures(page: Page) -> None:
    drawn = module(page, "colours", "Array.from({length: 65}, (_, k) => m.palette(false).robot(k))")
    assert drawn == style.robot_colours(65)


def test_light_colours_are_those_of_the_figures(page: Page) -> None:
    light = module(page, "colours", "({...m.palette(false)})")
    for name in ("OUTSIDE", "WORKSPACE", "WALL", "OBSTACLE", "GROWN", "GRAPH", "START", "GOAL", "LINK", "BRIDGE"):
        assert light[name.lower()] == getattr(style, name), name
    assert light["obstacleEdge"] == style.OBSTACLE_EDGE


@pytest.mark.parametrize("dark", [False, True])
def test_words_and_robots_can_be_read_in_light_and_dark(page: Page, dark: bool) -> None:
    found = module(
        page,
        "colours",
        """(() => { const c = m.palette(a); const on = (x) => m.contrast(x, c.workspace); return {
          words: [c.ink, c.quiet, c.accent, c.bad, c.good, c.warn].map(on),
          outside: [c.ink, c.quiet].map((x) => m.contrast(x, c.outside)),
          names: Array.from({length: 30}, (_, k) => on(c.robotInk(k))),
          discs: Array.from({length: 30}, (_, k) => on(c.robot(k))),
          obstacle: m.contrast(c.obstacleInk, c.obstacle) }; })()""",
        dark,
    )
    assert min(found["words"] + found["outside"] + found["names"]) >= 4.5
    assert found["obstacle"] >= 4.5
    assert min(found["discs"]) > (1.5 if not dark else 2.1)


@pytest.mark.parametrize(
    ("metres", "words"),
    [(0, "0 m"), (2.4, "2.40 m"), (0.35, "35.0 cm"), (0.0042, "4.20 mm"), (1234, "1.23 km"), (5e-6, "5.00 µm")],
)
def test_lengths_are_written_with_a_unit_that_suits_them(page: Page, metres: float, words: str) -> None:
    assert module(page, "grid", "m.lengthText(a)", metres) == words


def test_the_grid_has_round_steps_at_every_scale(page: Page) -> None:
    scales = [10 ** (k / 4) for k in range(-24, 40)]
    for scale, steps in zip(scales, module(page, "grid", "a.map(m.gridSteps)", scales), strict=True):
        assert 64 <= steps["strong"] * scale <= 64 * 2.51
        lead = float(f"{steps['strong']:e}".split("e")[0])
        assert lead in (1, 2, 5)
        assert float(f"{steps['fine']:.6e}".split("e")[0]) in (1, 2, 5)


@pytest.mark.parametrize("size", [1e-6, 1e-3, 1.0, 1e3, 1e6])
def test_a_place_is_found_again_from_its_pixel_and_zoom_keeps_it(page: Page, size: float) -> None:
    error = module(
        page,
        "camera",
        """(() => { const place = [a * 0.317, -a * 0.71]; const [width, height] = [800, 600];
          let window = { camera: m.fitted([-a, -a, a, a], width, height), width, height };
          const pixel = m.toScreen(window, place); let worst = 0;
          for (let k = 0; k < 20; k += 1) {
            window = { ...window, camera: m.zoomedAt(window, pixel, 1.3) };
            const [x, y] = m.toScreen(window, place); const [u, v] = m.toWorld(window, pixel);
            worst = Math.max(worst, Math.abs(x - pixel[0]), Math.abs(y - pixel[1]),
              Math.hypot(u - place[0], v - place[1]) * window.camera.scale);
          }
          return worst; })()""",
        size,
    )
    assert error < 1e-3  # pixels


@pytest.mark.parametrize("size", [1e-6, 1.0, 1e6])
def test_maps_of_any_size_are_drawn_where_they_are(page: Page, size: float) -> None:
    show(page, scaled({**SCENE, "robots": []}, size))
    hand = Hand(page)
    assert hand.colour(3 * size, 2.2 * size) == rgb(style.OBSTACLE)
    assert hand.colour(9.5 * size, 2.2 * size) == rgb(style.OBSTACLE)
    assert hand.colour(4.7 * size, 8 * size) == rgb(style.OBSTACLE)
    assert hand.colour(9.5 * size, 8 * size) == rgb(style.OBSTACLE)
    assert hand.colour(-0.2 * size, 6.2 * size) != rgb(style.WORKSPACE)


@pytest.mark.parametrize(
    ("place", "inward"), [((5, 4), (-1, -1)), ((11, 4), (-1, -1)), ((5, 8), (-1, 0)), ((9.5, 8.1), (0, -1))]
)
def test_corners_stay_sharp_a_hundred_million_times_enlarged(page: Page, place: Point, inward: Point) -> None:
    show(page, {**SCENE, "robots": []})
    hand = Hand(page)
    page.evaluate("([x, y]) => studio.camera.set({ x, y, scale: 4e9 })", list(place))
    pixel = 1 / 4e9
    for k in (4, 40):
        assert hand.colour(place[0] + k * pixel * inward[0], place[1] + k * pixel * inward[1]) == rgb(style.OBSTACLE)
        assert hand.colour(place[0] - k * pixel * inward[0], place[1] - k * pixel * inward[1]) != rgb(style.OBSTACLE)


def test_the_canvas_has_a_pixel_for_each_of_the_screen(browser: Browser, studio: RunningStudio) -> None:
    context = browser.new_context(viewport={"width": 900, "height": 600}, device_scale_factor=2)
    sharp = context.new_page()
    sharp.goto(studio.url)
    wait_for(sharp, "window.studio?.board && document.getElementById('board').width > 300")
    sizes = sharp.evaluate("(c => [c.width, c.clientWidth, c.height, c.clientHeight])(window.board)")
    context.close()
    assert sizes[0] == 2 * sizes[1]
    assert sizes[2] == 2 * sizes[3]


def test_a_picture_that_is_kept_is_the_one_that_was_drawn(hand: Hand) -> None:
    hand.page.evaluate("studio.store.set({ hover: null })")
    pictures = hand.page.evaluate(
        """() => { const canvas = document.getElementById("board"); studio.camera.set({ x: 8, y: 6, scale: 41.3 });
          return [0, 1, 2].map(() => { studio.board.draw(); return canvas.toDataURL(); }); }"""
    )
    assert pictures[0] == pictures[1] == pictures[2]


def test_nothing_is_drawn_while_nothing_changes_and_two_changes_are_one_drawing(hand: Hand) -> None:
    drawn = hand.page.evaluate(
        """async () => { const context = document.getElementById("board").getContext("2d"); let fills = 0;
          const fill = context.fillRect; context.fillRect = (...all) => { fills += 1; fill.apply(context, all); };
          const during = async (change) => { const before = fills; change();
            await new Promise((done) => setTimeout(done, 300)); return fills - before; };
          const least = { still: Infinity, twice: Infinity };
          for (let k = 0; k < 10 && least.still + least.twice > 1; k += 1) { // an answer may come in between
            least.still = Math.min(least.still, await during(() => undefined));
            least.twice = Math.min(least.twice, await during(() => {
              studio.camera.set({ ...studio.camera.get(), x: 7 + k / 10 });
              studio.camera.set({ ...studio.camera.get(), y: 7 + k / 10 }); }));
          }
          delete context.fillRect; return least; }"""
    )
    assert drawn == {"still": 0, "twice": 1}


def test_five_thousand_corners_and_two_hundred_robots_are_drawn_within_a_frame(page: Page) -> None:
    show(page, crowded())
    times = page.evaluate(
        """async () => { const camera = studio.camera.get(); const times = [];
          for (let k = 0; k < 40; k += 1) {
            studio.camera.set({ ...camera, x: camera.x + Math.sin(k / 5), scale: camera.scale * (1 + k / 200) });
            const begin = performance.now(); studio.board.draw(); times.push(performance.now() - begin);
            await new Promise(requestAnimationFrame);
          }
          return times; }"""
    )
    assert min(times) < 16.7  # milliseconds; most are 3 on a quiet machine, on a busy one others run in between


def test_problems_are_pinned_where_they_are_and_said_when_pointed_at(hand: Hand) -> None:
    robots = [{**SCENE["robots"][0], "start": [3, 3]}, {**SCENE["robots"][1], "goal": [9, 3]}]
    show(hand.page, {**SCENE, "robots": robots})
    wait_for(hand.page, "studio.store.get().problems.filter(({ place }) => place).length >= 2")
    place = next(p["place"] for p in hand.state(".problems") if p["place"])
    x, y = hand.at(*place)
    hand.page.mouse.move(x, y - 19)
    index = hand.state(".probe")
    assert index is not None
    assert hand.state(".problems")[index]["place"] == place
    hand.page.mouse.move(x, y - 60)
    assert hand.state(".probe") is None


def test_why_there_is_no_path_is_drawn_until_there_is_one(hand: Hand) -> None:
    fence = {"name": "W", "line": [[12.5, 12], [12.5, 8.5], [16, 8.5]], "width": 0.2}
    show(hand.page, {**SCENE, "obstacles": [*SCENE["obstacles"], fence], "robots": SCENE["robots"][:1]})
    wait_for(hand.page, "studio.store.get().planning.state === 'failed'")
    wrong = hand.state(".planning.wrong")
    assert wrong["names"] == ["R1"]
    assert wrong["why"]["from"]
    assert wrong["why"]["to"]
    before = {place: hand.colour(*place) for place in ((13.13, 11.27), (6.13, 6.77), (0.05, 6.13))}
    hand.page.evaluate("studio.store.set({ planning: { state: 'idle' } })")
    after = {place: hand.colour(*place) for place in before}
    reached, within_reach, too_near = before
    assert before[reached] != after[reached]
    assert before[within_reach] != after[within_reach]
    assert before[too_near] == after[too_near], "no centre of a robot fits there"


def test_starts_are_empty_while_the_plan_runs(hand: Hand) -> None:
    full = hand.colour(1.12, 0.85)
    hand.page.evaluate("studio.player.seek(5)")
    left = hand.colour(1.12, 0.85)
    hand.page.evaluate("studio.player.seek(0)")
    assert full == rgb(style.robot_colours(1)[0])
    assert left != full


# Selecting and dragging


def test_a_click_selects_shift_adds_and_takes_away_and_the_paper_selects_nothing(hand: Hand) -> None:
    hand.click(3, 3)
    assert hand.selected() == ["O1"]
    hand.page.keyboard.down("Shift")
    hand.click(4, 8)
    hand.click(1, 1)
    assert hand.selected() == ["O1", "O3", "R1 start"]
    hand.click(4, 8)
    assert hand.selected() == ["O1", "R1 start"]
    hand.page.keyboard.up("Shift")
    hand.click(7, 6)
    assert hand.selected() == []


def test_a_box_selects_all_that_it_touches(hand: Hand) -> None:
    hand.drag((0.2, 0.2), (8.5, 2.5))
    assert hand.selected() == ["O1", "O2", "R1 start"]
    assert hand.steps() == []


def test_a_drag_is_one_step_and_moves_all_that_is_selected(hand: Hand) -> None:
    before = hand.state(".scene")
    hand.drag((7, 1.5), (11.5, 4.5))
    hand.page.keyboard.down("Shift")
    hand.click(14, 1)
    hand.page.keyboard.up("Shift")
    hand.press(9, 3)
    for k in range(1, 9):
        hand.pull(9 + k / 8, 3 + k / 8)
    hand.page.mouse.up()
    assert hand.obstacle("O2")["rectangle"] == [9, 3, 3, 2]
    assert hand.state(".scene.robots")[1]["start"] == [15, 2]
    assert hand.steps() == ["move 2 objects"]
    hand.page.keyboard.press("Control+z")
    assert hand.state(".scene") == before


def test_escape_gives_a_drag_up(hand: Hand) -> None:
    before = json.dumps(hand.state(".scene"))
    hand.press(3, 3)
    hand.pull(6, 6)
    assert json.dumps(hand.state(".scene")) != before
    hand.page.keyboard.press("Escape")
    hand.pull(7, 7)
    hand.page.mouse.up()
    assert json.dumps(hand.state(".scene")) == before
    assert hand.steps() == []


def test_an_undo_in_the_middle_of_a_drag_leaves_the_drag(hand: Hand) -> None:
    before = hand.state(".scene")
    hand.press(3, 3)
    hand.pull(6, 6)
    hand.page.keyboard.press("Control+z")
    hand.pull(9, 9)
    hand.page.mouse.up()
    assert hand.state(".scene") == before
    assert hand.state(".sketch") is None


def test_a_drag_shows_what_it_snapped_to_and_how_far_it_went(hand: Hand) -> None:
    hand.press(3, 3)
    hand.pull(3.02, 9.03)
    sketch = hand.state(".sketch")
    assert sketch["labels"][0]["text"].endswith(" m")
    assert sketch["guides"], "nothing was said to draw it"
    hand.page.mouse.up()
    assert hand.state(".sketch") is None


def test_control_holds_snapping_off_and_shift_keeps_to_an_axis(hand: Hand) -> None:
    hand.press(3, 3)
    hand.page.keyboard.down("Shift")
    hand.pull(6, 3.4)
    hand.page.mouse.up()
    hand.page.keyboard.up("Shift")
    assert hand.obstacle("O1")["polygon"][0] == [5, 2]
    hand.press(6, 3)
    hand.page.keyboard.down("Control")
    hand.pull(6.13, 3.37)
    hand.page.mouse.up()
    hand.page.keyboard.up("Control")
    x, y = hand.obstacle("O1")["polygon"][0]
    assert abs(x - 5.13) < 0.03
    assert abs(y - 2.37) < 0.03
    assert (x, y) != (5, 2.5)


def test_alt_drags_a_copy(hand: Hand) -> None:
    hand.press(3, 3)
    hand.page.keyboard.down("Alt")
    hand.pull(3, 6)
    hand.page.mouse.up()
    hand.page.keyboard.up("Alt")
    assert hand.obstacle("O1") == SCENE["obstacles"][0]
    assert hand.obstacle("O5")["polygon"][0] == [2, 5]
    assert hand.selected() == ["O5"]
    assert hand.steps() == ["duplicate O1"]


def test_starts_and_goals_are_dragged_by_themselves(hand: Hand) -> None:
    hand.drag((14, 10), (13, 9))
    hand.drag((1, 1), (1, 3))
    assert hand.state(".scene.robots")[0] == {**SCENE["robots"][0], "goal": [13, 9], "start": [1, 3]}


def test_what_is_under_the_pointer_is_shown(hand: Hand) -> None:
    hand.page.mouse.move(*hand.at(9, 3))
    assert hand.state(".hover") == {"kind": "obstacle", "name": "O2"}
    hand.page.mouse.move(*hand.at(6.5, 6))
    assert hand.state(".hover") is None
    assert hand.state(".pointer") == pytest.approx([6.5, 6], abs=0.05)


# Corners, sizes, turning


def test_a_double_click_on_a_side_puts_a_corner_there_that_moves_and_goes(hand: Hand) -> None:
    hand.double(3.5, 4)
    assert hand.obstacle("O1")["polygon"][3] == pytest.approx([3.5, 4], abs=0.03)
    assert hand.selected() == ["O1 #3"]
    x, y = hand.grip("vertex", 3)
    hand.page.mouse.move(x, y)
    hand.page.mouse.down()
    hand.pull(3.5, 5)
    hand.page.mouse.up()
    assert hand.obstacle("O1")["polygon"] == [[2, 2], [5, 2], [5, 4], [3.5, 5], [2, 4]]
    hand.page.keyboard.press("Delete")
    assert hand.obstacle("O1") == SCENE["obstacles"][0]
    assert len(hand.steps()) == 3


def test_several_corners_move_together(hand: Hand) -> None:
    hand.click(3, 3)
    hand.page.mouse.click(*hand.grip("vertex", 2))
    hand.page.keyboard.down("Shift")
    hand.page.mouse.click(*hand.grip("vertex", 3))
    hand.page.keyboard.up("Shift")
    assert hand.selected() == ["O1 #2", "O1 #3"]
    hand.drag((5, 4), (5, 5))
    assert hand.obstacle("O1")["polygon"] == [[2, 2], [5, 2], [5, 5], [2, 5]]


def test_a_rectangle_is_resized_and_turned_and_stays_one(hand: Hand) -> None:
    hand.click(9, 3)
    x, y = hand.grip("size", 2)
    hand.page.mouse.move(x, y)
    hand.page.mouse.down()
    hand.pull(12, 5)
    assert hand.state(".sketch.labels[0].text") == "4.00 × 3.00 m"
    hand.page.mouse.up()
    assert hand.obstacle("O2")["rectangle"] == [8, 2, 4, 3]
    x, y = hand.grip("turn", 0)
    hand.page.mouse.move(x, y)
    hand.page.mouse.down()
    hand.page.keyboard.down("Shift")
    hand.pull(13, 4)
    hand.page.mouse.up()
    hand.page.keyboard.up("Shift")
    turned = hand.obstacle("O2")
    assert turned["rectangle"] == [8, 2, 4, 3]
    assert (turned["angle"] / (math.pi / 12)) % 1 == pytest.approx(0, abs=1e-9)
    assert hand.steps() == ["turn O2", "resize O2"]


def test_the_rim_of_a_circle_sets_its_radius(hand: Hand) -> None:
    hand.click(4, 8)
    x, y = hand.grip("size", 0)
    hand.page.mouse.move(x, y)
    hand.page.mouse.down()
    hand.pull(6, 8)
    hand.page.mouse.up()
    assert hand.obstacle("O3") == {"name": "O3", "circle": [4, 8], "radius": 2}


def test_sides_of_the_workspace_move_and_bounds_stay_bounds(hand: Hand) -> None:
    hand.click(16, 6.3)
    assert hand.selected() == ["workspace"]
    hand.drag((16, 5.3), (18, 5.3))
    assert hand.state(".scene.bounds") == [0, 0, 18, 12]


# Drawing


def test_a_polygon_is_clicked_corner_by_corner_and_closed_by_enter(hand: Hand) -> None:
    hand.tool("polygon")
    for place in ((6, 5), (7, 5), (7, 6), (9, 6)):
        hand.click(*place)
    hand.page.keyboard.press("Backspace")
    hand.pull(6.5, 7)
    assert "·" in hand.state(".sketch.labels[0].text"), "length and angle are shown"
    hand.page.keyboard.press("Enter")
    assert hand.obstacle("O5") == {"name": "O5", "polygon": [[6, 5], [7, 5], [7, 6]]}
    assert hand.selected() == ["O5"]
    assert hand.steps() == ["add O5"]


def test_a_polygon_closes_at_its_first_corner_or_by_a_double_click(hand: Hand) -> None:
    hand.tool("polygon")
    for place in ((6, 5), (7, 5), (7, 6), (6, 5)):
        hand.click(*place)
    assert len(hand.obstacle("O5")["polygon"]) == 3
    for place in ((12, 5), (13, 5)):
        hand.click(*place)
    hand.double(13, 6)
    assert hand.obstacle("O6")["polygon"] == [[12, 5], [13, 5], [13, 6]]


def test_escape_leaves_the_drawing_then_the_tool(hand: Hand) -> None:
    hand.tool("polygon")
    hand.click(6, 5)
    hand.click(7, 5)
    hand.page.keyboard.press("Enter")
    assert "at least 3" in hand.state(".said")
    hand.page.keyboard.press("Escape")
    assert hand.state(".sketch") is None
    assert hand.state(".tool") == "polygon"
    hand.page.keyboard.press("Escape")
    assert hand.state(".tool") == "select"
    assert hand.state(".scene") == SCENE


def test_a_wall_is_a_chain_with_the_width_set(hand: Hand) -> None:
    hand.page.evaluate("studio.store.set({ wallWidth: 0.3 })")
    hand.tool("wall")
    hand.click(6, 5)
    hand.click(7, 5)
    hand.double(7, 7)
    assert hand.obstacle("O5") == {"name": "O5", "line": [[6, 5], [7, 5], [7, 7]], "width": 0.3}


@pytest.mark.parametrize("clicks", [False, True])
@pytest.mark.parametrize(
    ("tool", "begin", "end", "made"),
    [
        ("rectangle", (6, 7), (7.5, 5), {"rectangle": [6, 5, 1.5, 2]}),
        ("circle", (6.5, 6), (7.5, 6), {"circle": [6.5, 6], "radius": 1}),
    ],
)
def test_shapes_are_dragged_or_clicked(
    hand: Hand, clicks: bool, tool: str, begin: Point, end: Point, made: dict[str, Any]
) -> None:
    hand.tool(tool)
    two_places(hand, clicks, begin, end)
    assert hand.obstacle("O5") == {"name": "O5", **made}
    assert hand.selected() == ["O5"]


def test_shift_draws_a_square(hand: Hand) -> None:
    hand.tool("rectangle")
    hand.press(6, 5)
    hand.page.keyboard.down("Shift")
    hand.pull(7.5, 5.5)
    hand.page.mouse.up()
    hand.page.keyboard.up("Shift")
    assert hand.obstacle("O5")["rectangle"] == [6, 5, 1.5, 1.5]


@pytest.mark.parametrize("clicks", [False, True])
def test_a_robot_goes_from_the_first_place_to_the_second(hand: Hand, clicks: bool) -> None:
    hand.tool("robot")
    two_places(hand, clicks, (1, 6), (14, 6))
    robot = {"name": "R3", "start": [1, 6], "goal": [14, 6], "radius": 0.3, "speed": 1}
    assert hand.state(".scene.robots")[2] == robot
    assert hand.selected() == ["R3 robot"]
    assert hand.steps() == ["add R3"]


def test_measuring_tells_the_length_and_changes_nothing(hand: Hand) -> None:
    hand.tool("measure")
    hand.drag((1, 6), (4, 10))
    assert hand.state(".sketch.labels[0].text") == "5.00 m · 53.1°"
    assert hand.state(".scene") == SCENE
    hand.page.keyboard.press("Escape")
    assert hand.state(".sketch") is None


# Moving about


def test_the_wheel_zooms_at_the_pointer(hand: Hand) -> None:
    hand.page.mouse.move(*hand.at(3, 3))
    before = hand.at(3, 3)
    scale = hand.page.evaluate("studio.camera.get().scale")
    hand.page.mouse.wheel(0, -240)
    wait_for(hand.page, f"studio.camera.get().scale > {scale}")
    assert hand.at(3, 3) == pytest.approx(before, abs=1)  # the mouse was within half a pixel of it


def test_a_trackpad_moves_the_map_and_its_pinch_zooms(hand: Hand) -> None:
    hand.page.evaluate(
        """() => { const canvas = document.getElementById("board");
          window.wheel = (more) => canvas.dispatchEvent(new WheelEvent("wheel",
            { clientX: 400, clientY: 300, bubbles: true, cancelable: true, ...more })); }"""
    )
    before = hand.at(3, 3)
    hand.page.evaluate("wheel({ deltaX: 7, deltaY: 3 })")
    assert hand.at(3, 3) == pytest.approx((before[0] - 7, before[1] - 3))
    scale = hand.page.evaluate("studio.camera.get().scale")
    hand.page.evaluate("wheel({ deltaY: -5, ctrlKey: true })")
    assert hand.page.evaluate("studio.camera.get().scale") > scale


@pytest.mark.parametrize("way", ["tool", "middle", "space"])
def test_the_map_is_dragged_by_tool_middle_button_or_space(hand: Hand, way: str) -> None:
    before = hand.at(3, 3)
    hand.page.mouse.move(500, 300)
    if way == "tool":
        hand.tool("pan")
        hand.page.mouse.move(500, 300)
    elif way == "space":
        hand.page.focus("#board")
        hand.page.keyboard.down(" ")
    hand.page.mouse.down(button="middle" if way == "middle" else "left")
    hand.page.mouse.move(540, 330, steps=3)
    hand.page.mouse.up(button="middle" if way == "middle" else "left")
    if way == "space":
        hand.page.keyboard.up(" ")
    assert hand.at(3, 3) == pytest.approx((before[0] + 40, before[1] + 30), abs=1e-6)
    assert hand.state(".scene") == SCENE
    assert not hand.state(".time.playing"), "a space bar that moved the map does not play"


def test_two_fingers_zoom_and_move_and_a_drawing_goes_on_after_them(hand: Hand) -> None:
    hand.tool("polygon")
    hand.click(6, 5)
    hand.click(7, 5)
    touch = toucher(hand.page)
    a, b = hand.at(3, 3), hand.at(11, 3)
    touch("touchStart", [a])
    touch("touchStart", [a, b])
    touch("touchMove", [(a[0] - 40, a[1] + 20), (b[0] + 40, b[1] + 20)])
    touch("touchEnd", [])
    assert hand.at(3, 3) == pytest.approx((a[0] - 40, a[1] + 20), abs=1e-3)
    assert hand.at(11, 3) == pytest.approx((b[0] + 40, b[1] + 20), abs=1e-3)
    assert len(hand.state(".sketch.points")) == 2
    touch("touchStart", [hand.at(7, 6)])
    touch("touchEnd", [])
    hand.page.keyboard.press("Enter")
    assert hand.obstacle("O5")["polygon"] == [[6, 5], [7, 5], [7, 6]]


def test_a_finger_drags_and_a_second_one_gives_the_drag_up(hand: Hand) -> None:
    touch = toucher(hand.page)
    touch("touchStart", [hand.at(3, 3)])
    for k in range(1, 5):
        touch("touchMove", [hand.at(3, 3 + k / 2)])
    touch("touchEnd", [])
    assert hand.obstacle("O1")["polygon"][0] == [2, 4]
    touch("touchStart", [hand.at(3, 5)])
    touch("touchMove", [hand.at(3, 6)])
    touch("touchMove", [hand.at(3, 7)])
    touch("touchStart", [hand.at(3, 7), hand.at(9, 7)])
    touch("touchEnd", [])
    assert hand.obstacle("O1")["polygon"][0] == [2, 4]
    assert hand.steps() == ["move O1"]


# The keyboard


def test_tab_walks_through_everything_and_leaves_at_the_end(hand: Hand) -> None:
    hand.page.focus("#board")
    seen = []
    for _ in range(9):
        hand.page.keyboard.press("Tab")
        seen += hand.selected()
    assert seen == ["O1", "O2", "O3", "O4", "R1 start", "R1 goal", "R2 start", "R2 goal", "workspace"]
    hand.page.keyboard.press("Shift+Tab")
    assert hand.selected() == ["R2 goal"]
    hand.page.keyboard.press("Tab")
    hand.page.keyboard.press("Tab")
    assert hand.page.evaluate("document.activeElement.id") != "board"


def test_escape_twice_lets_tab_leave_the_board_at_once(hand: Hand) -> None:
    hand.page.focus("#board")
    hand.page.keyboard.press("Tab")
    hand.page.keyboard.press("Escape")
    hand.page.keyboard.press("Escape")
    hand.page.keyboard.press("Tab")
    assert hand.page.evaluate("document.activeElement.id") != "board"


def test_arrows_move_by_a_grid_step_shift_by_ten_and_a_held_key_is_one_step(hand: Hand) -> None:
    step = module(hand.page, "grid", "m.gridSteps(studio.camera.get().scale).fine")
    hand.page.focus("#board")
    hand.page.keyboard.press("Tab")
    for _ in range(4):
        hand.page.keyboard.down("ArrowRight")
    hand.page.keyboard.up("ArrowRight")
    assert hand.obstacle("O1")["polygon"][0] == [2 + 4 * step, 2]
    assert hand.steps() == ["move O1"]
    hand.page.keyboard.press("Shift+ArrowUp")
    assert hand.obstacle("O1")["polygon"][0] == [2 + 4 * step, 2 + 10 * step]
    assert len(hand.steps()) == 2


def test_enter_goes_to_the_numbers_of_what_is_selected(hand: Hand) -> None:
    hand.page.focus("#board")
    hand.page.keyboard.press("Tab")
    hand.page.keyboard.press("Enter")
    wait_for(hand.page, "document.activeElement.closest('#panel') !== null")


@pytest.mark.parametrize("tool", ["polygon", "rectangle", "circle", "wall", "robot"])
def test_drawing_needs_no_pointer(hand: Hand, tool: str) -> None:
    hand.page.focus("#board")
    hand.page.evaluate("tool => studio.store.set({ tool })", tool)
    hand.page.keyboard.press("Enter")
    assert hand.selected() == (["R3 robot"] if tool == "robot" else ["O5"])
    assert hand.state(".tool") == "select"
    before = hand.state(".scene")
    hand.page.keyboard.press("ArrowUp")
    assert hand.state(".scene") != before
    assert len(hand.steps()) == 2


# The machine


def test_every_state_that_the_table_leads_to_is_in_it(page: Page) -> None:
    table = module(
        page,
        "tools",
        """({ tools: m.TOOLS.map(({ name }) => name), table: Object.fromEntries(Object.entries(m.TABLE).map(
          ([state, row]) => [state, Object.values(row).flatMap(([, ...targets]) => targets)])) })""",
    )
    assert {target for targets in table["table"].values() for target in targets} <= set(table["table"])
    assert set(table["tools"]) <= set(table["table"])
    reached = set(table["tools"])
    for _ in table["table"]:
        reached |= {target for state in reached for target in table["table"][state]}
    assert reached == set(table["table"])


def test_the_machine_refuses_what_is_not_in_its_table(page: Page) -> None:
    said = module(
        page,
        "tool_machine",
        """(() => { const machine = m.createMachine({ a: { go: [() => ({ name: "b" })] } }, {}, { name: "a" });
          try { machine.send("go"); return ""; } catch (error) { return error.message; } })()""",
    )
    assert said == "a does not lead to b on go"


def two_places(hand: Hand, clicks: bool, begin: Point, end: Point) -> None:
    """Give a tool its two places, by a drag or by two clicks."""
    if clicks:
        hand.click(*begin)
        hand.click(*end)
    else:
        hand.drag(begin, end)


def toucher(page: Page) -> Callable[[str, list[Point]], None]:
    """Return a function that touches the page with fingers at pixels."""
    session = page.context.new_cdp_session(page)

    def touch(kind: str, fingers: list[Point]) -> None:
        points = [{"x": x, "y": y, "id": k} for k, (x, y) in enumerate(fingers)]
        session.send("Input.dispatchTouchEvent", {"type": kind, "touchPoints": points})
        page.evaluate("new Promise(requestAnimationFrame)")  # moves are told with the next frame

    return touch


def scaled(value: Any, factor: float, key: str = "") -> Any:
    """Return a scene with every length multiplied."""
    if isinstance(value, dict):
        return {name: scaled(part, factor, name) for name, part in value.items()}
    if isinstance(value, list):
        return [scaled(part, factor, key) for part in value]
    return value * factor if key not in ("taut", "headway") and isinstance(value, int | float) else value


def crowded() -> dict[str, Any]:
    """Return 500 obstacles of 10 corners and 200 robots with their goals inside, so that nobody plans meanwhile."""
    ring = [(1.5 * math.cos(k * math.pi / 5), 1.5 * math.sin(k * math.pi / 5)) for k in range(10)]
    obstacles = [
        {"name": f"O{k + 1}", "polygon": [[4 * (k % 25) + 2 + x, 4 * (k // 25) + 2 + y] for x, y in ring]}
        for k in range(500)
    ]
    robots = [
        {
            "name": f"R{k + 1}",
            "start": [4 * (k % 25), 4 * (k // 25)],
            "goal": [4 * (k % 25) + 2, 4 * (k // 25) + 2],
            "radius": 0.3,
            "speed": 1,
        }
        for k in range(200)
    ]
    return {**SCENE, "bounds": [0, 0, 100, 80], "obstacles": obstacles, "robots": robots}
