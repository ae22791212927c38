"""The studio as users use it: from the empty floor to the page for a colleague, by mouse, by keyboard, in crashes."""

from __future__ import annotations

import json
import os
import signal
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING, Any

import pytest

import taut
from studio_page import running_studio, wait_for, wait_until_ready
from taut.formats import scene_to_dict

if TYPE_CHECKING:
    from playwright.sync_api import Browser, BrowserContext, Dialog, Page

    from studio_page import RunningStudio

pytest_plugins = ("studio_page",)

Point = tuple[float, float]
STATE = "window.studio.store.get()"
SHOWN = f"JSON.stringify({STATE}.scene)"
FRESH = f"{STATE}.planning.state === 'fresh' && {STATE}.answer.revision === {STATE}.revision"
SETTLED = f"['fresh', 'failed', 'idle'].includes({STATE}.planning.state) && !{STATE}.planning.running"


@contextmanager
def visited(browser: Browser, running: RunningStudio, context: BrowserContext | None = None) -> Iterator[Page]:
    """Open a page of a server; errors in it fail the test."""
    mine = context or browser.new_context(viewport={"width": 1280, "height": 800}, accept_downloads=True)
    page = mine.new_page()
    errors: list[str] = []
    page.on("pageerror", lambda error: errors.append(str(error)))
    page.goto(running.url)
    wait_until_ready(page)
    yield page
    if context is None:
        mine.close()
    assert not errors, errors


def state(page: Page, keys: str) -> Any:
    """Return a part of the page's state: `scene.robots`."""
    return page.evaluate(f"JSON.parse(JSON.stringify({STATE}.{keys} ?? null))")


def at(page: Page, x: float, y: float) -> Point:
    """Return the pixel of the page at which a place of the map is."""
    across, down = page.evaluate(
        """([x, y]) => {
          const { camera, width, height } = window.studio.board.window();
          const { left, top } = document.getElementById("board").getBoundingClientRect();
          return [left + width / 2 + (x - camera.x) * camera.scale, top + height / 2 + (camera.y - y) * camera.scale];
        }""",
        [x, y],
    )
    return across, down


def click(page: Page, *places: Point) -> None:
    """Click places of the map in turn."""
    for place in places:
        page.mouse.click(*at(page, *place))


def press(page: Page, begin: Point, end: Point) -> None:
    """Press at one place of the map, go to another one, and hold."""
    page.mouse.move(*at(page, *begin))
    page.mouse.down()
    page.mouse.move(*at(page, *end), steps=5)


def drag(page: Page, begin: Point, end: Point) -> None:
    """Press at one place of the map and let go at another one."""
    press(page, begin, end)
    page.mouse.up()


def draw(page: Page, tool: str, *places: Point) -> None:
    """Draw with a tool of the strip: chains by clicks and Enter, all else by a drag."""
    page.click(f'[data-tool="{tool}"]')
    if tool in ("polygon", "wall"):
        click(page, *places)
        page.keyboard.press("Enter")
    else:
        drag(page, *places)


def steps_back(page: Page) -> int:
    """Return how many steps can be undone."""
    count: int = page.evaluate("window.studio.history.labels().undo.length")
    return count


def test_a_floor_is_drawn_planned_changed_and_saved(browser: Browser, tmp_path: Path) -> None:
    with running_studio("floor.yaml", folder=tmp_path) as running, visited(browser, running) as page:
        assert page.get_by_role("heading", name="An empty floor").is_visible()
        empty = page.evaluate(SHOWN)
        width, height = state(page, "scene.bounds")[2:]

        def part(x: float, y: float) -> Point:
            return x * width, y * height

        draw(page, "polygon", part(0.3, 0.5), part(0.4, 0.5), part(0.4, 0.75), part(0.3, 0.7))
        draw(page, "rectangle", part(0.55, 0.2), part(0.7, 0.5))
        draw(page, "circle", part(0.2, 0.25), part(0.25, 0.25))
        draw(page, "wall", part(0.55, 0.7), part(0.7, 0.7), part(0.7, 0.8))
        draw(page, "robot", part(0.1, 0.1), part(0.9, 0.9))
        draw(page, "robot", part(0.9, 0.1), part(0.1, 0.9))
        wait_for(page, FRESH)
        kinds = [obstacle.keys() - {"name", "radius", "width"} for obstacle in state(page, "scene.obstacles")]
        assert kinds == [{"polygon"}, {"rectangle"}, {"circle"}, {"line"}]
        assert state(page, "answer.certificate.ok") is True

        # changed with the mouse: moved, a corner more, turned
        page.keyboard.press("Escape")
        page.keyboard.press("v")
        polygon, costs = state(page, "scene.obstacles")[0]["polygon"], state(page, "answer.metrics.sum_of_costs")
        drag(page, part(0.35, 0.6), part(0.5, 0.5))
        wait_for(page, FRESH)
        assert state(page, "scene.obstacles")[0]["polygon"] != polygon
        assert state(page, "answer.metrics.sum_of_costs") != costs
        corners = state(page, "scene.obstacles")[0]["polygon"]
        page.mouse.dblclick(*at(page, *((a + b) / 2 for a, b in zip(corners[0], corners[1], strict=True))))
        assert len(state(page, "scene.obstacles")[0]["polygon"]) == 5
        click(page, part(0.62, 0.35))
        page.locator('#panel [data-field="angle"] input').fill("30")
        page.keyboard.press("Enter")
        assert state(page, "scene.obstacles")[1]["angle"] == pytest.approx(0.5236, abs=1e-4)
        wait_for(page, SETTLED)

        drawn, steps = page.evaluate(SHOWN), steps_back(page)
        assert steps == 9
        for _ in range(steps):
            page.click("#undo")
        assert page.evaluate(SHOWN) == empty
        for _ in range(steps):
            page.click("#redo")
        assert page.evaluate(SHOWN) == drawn

        page.click("#save")
        wait_for(page, f"{STATE}.file.dirty === false")
        assert json.dumps(scene_to_dict(taut.load_scene(tmp_path / "floor.yaml"))["robots"]) == json.dumps(
            state(page, "scene.robots")
        )
        page.reload()
        wait_until_ready(page)
        wait_for(page, FRESH)
        assert state(page, "scene.obstacles") == json.loads(drawn)["obstacles"]
        assert sorted(path.name for path in tmp_path.iterdir()) == ["floor.yaml"]


def test_the_keyboard_alone_is_enough(browser: Browser, tmp_path: Path) -> None:
    with running_studio(folder=tmp_path) as running, visited(browser, running) as page:
        page.locator("#file-menu").focus()
        page.keyboard.press("Enter")
        for _ in range(2):
            page.keyboard.press("ArrowDown")
        page.keyboard.press("Enter")
        page.get_by_role("dialog").wait_for()
        page.get_by_role("button", name="thesis-2").focus()
        page.keyboard.press("Enter")
        wait_for(page, FRESH)
        scene = page.evaluate(SHOWN)

        page.locator("#board").focus()
        page.keyboard.press("Tab")
        assert len(state(page, "selection")) == 1
        page.keyboard.press("ArrowRight")
        wait_for(page, SETTLED)
        assert page.evaluate(SHOWN) != scene
        page.keyboard.press("Control+z")
        assert page.evaluate(SHOWN) == scene
        page.keyboard.press("Enter")
        wait_for(page, "document.activeElement.closest('#panel [data-field]') !== null", 5000)
        page.keyboard.press("Escape")

        page.locator("#board").focus()
        page.keyboard.press("2")
        wait_for(page, f"{STATE}.steps.list !== null")
        page.keyboard.press(".")
        assert state(page, "steps.index") == 1
        page.keyboard.press("3")
        wait_for(page, "document.querySelectorAll('.measures td').length > 10", 60_000)
        page.keyboard.press("1")
        page.keyboard.press("Space")
        wait_for(page, f"{STATE}.time.now > 0.2")
        page.keyboard.press("Space")
        page.keyboard.press("Control+e")
        page.get_by_role("dialog").wait_for()
        page.locator('[data-form="plan"]').focus()
        with page.expect_download() as made:
            page.keyboard.press("Enter")
        made.value.save_as(tmp_path / "plan.json")
        assert taut.certify(taut.load_plan(tmp_path / "plan.json")).ok


def test_a_server_killed_in_the_middle_of_a_drag_costs_nothing(browser: Browser, tmp_path: Path) -> None:
    taut.save(taut.load_scene("thesis-2"), tmp_path / "mine.yaml")
    context = browser.new_context(viewport={"width": 1280, "height": 800})
    with running_studio("mine.yaml", folder=tmp_path) as running, visited(browser, running, context) as page:
        wait_for(page, FRESH)
        drag(page, (5, 3), (5.5, 3))
        press(page, (7, 7.5), (8, 8))
        running.process.kill()
        running.process.wait()
        page.mouse.move(*at(page, 7.5, 8), steps=5)
        page.mouse.up()
        wait_for(page, f"{STATE}.server.state === 'gone'")
        assert steps_back(page) == 2
        page.locator("#banner").get_by_text("Server gone: your work is kept in this browser").wait_for()
        page.keyboard.press("Control+z")  # editing goes on without the server
        page.keyboard.press("Control+Shift+z")
        dragged = page.evaluate(SHOWN)
        page.wait_for_timeout(400)
        page.close(run_before_unload=False)
    with running_studio("mine.yaml", folder=tmp_path) as again, visited(browser, again, context) as page:
        page.get_by_role("button", name="Recover", exact=True).click()
        wait_for(page, f"{SHOWN} === {json.dumps(dragged)}")
        wait_for(page, FRESH)
    context.close()


def test_workers_killed_while_they_plan_are_replaced(browser: Browser) -> None:
    with running_studio("warehouse-50") as running, visited(browser, running) as page:
        wait_for(page, FRESH, 60_000)
        page.click("[role=tab]:has-text('Plan')")
        page.get_by_role("button", name="Improve", exact=True).click()
        wait_for(page, f"{STATE}.planning.running")
        for worker in children(running.process.pid):
            os.kill(worker, signal.SIGKILL)
        wait_for(page, f"!{STATE}.planning.running", 60_000)
        wait_until_ready(page)
        start = state(page, "scene.robots")[0]["start"]
        page.keyboard.press("v")
        drag(page, tuple(start), (start[0], start[1] + 0.2))
        wait_for(page, FRESH, 60_000)


def test_two_servers_on_one_scene_do_not_mix_their_drafts(browser: Browser, tmp_path: Path) -> None:
    taut.save(taut.load_scene("thesis-2"), tmp_path / "mine.yaml")
    context = browser.new_context()
    with (
        running_studio("mine.yaml", folder=tmp_path) as one,
        running_studio("mine.yaml", folder=tmp_path) as two,
        visited(browser, one, context) as left,
        visited(browser, two, context) as right,
    ):
        assert one.origin != two.origin
        for page, x in ((left, 5.5), (right, 6)):
            page.bring_to_front()
            wait_for(page, FRESH)
            drag(page, (5, 3), (x, 3))
        left.bring_to_front()
        left.click("#save")
        wait_for(left, f"{STATE}.file.dirty === false")
        right.bring_to_front()
        right.click("#save")
        right.get_by_role("heading", name="mine.yaml was changed meanwhile").wait_for()
        right.get_by_role("button", name="Cancel").click()
        saved = taut.load_scene(tmp_path / "mine.yaml")
        assert scene_to_dict(saved)["obstacles"] == state(left, "scene.obstacles") != state(right, "scene.obstacles")
    context.close()


HOSTILE = {
    "taut": 1,
    "name": "</title><script>document.title = 'broken out'</script>",
    "bounds": [0, 0, 10, 10],
    "gap": 0.1,
    "obstacles": [
        {"name": "<img src=x onerror=alert(1)>", "circle": [5, 5], "radius": 0.5},
        {"name": "a\"b'c\nnew\tline", "circle": [3, 7], "radius": 0.5},
        {"name": "\u202eעברית", "circle": [7, 3], "radius": 0.5},
        {"name": "L" * 10_000, "rectangle": [5, 8, 1, 1]},
    ],
    "robots": [
        {"name": "__proto__", "start": [1, 1], "goal": [9, 9], "radius": 0.2, "speed": 1},
        {"name": "constructor", "start": [9, 1], "goal": [1, 9], "radius": 0.2, "speed": 1},
        {"name": "</script><b>", "start": [5, 1], "goal": [5, 9.5], "radius": 0.2, "speed": 1},
    ],
}
TINY = {
    **HOSTILE,
    "bounds": [0, 0, 1e-8, 1e-8],
    "gap": 1e-10,
    "obstacles": [{"name": "O1", "circle": [5e-9, 5e-9], "radius": 1e-9}],
    "robots": [{"name": "R1", "start": [1e-9, 1e-9], "goal": [9e-9, 9e-9], "radius": 1e-10, "speed": 1e-9}],
}
VAST = {
    **HOSTILE,
    "bounds": [-1e6, -1e6, 1e6, 1e6],
    "obstacles": [{"name": "O1", "circle": [0, 0], "radius": 1e5}],
    "robots": [{"name": "R1", "start": [-9e5, -9e5], "goal": [9e5, 9e5], "radius": 10, "speed": 100}],
}


@pytest.mark.parametrize("scene", [HOSTILE, TINY, VAST], ids=["hostile names", "tiny", "vast"])
def test_odd_scenes_are_shown_planned_stepped_through_and_sent(
    page: Page, tmp_path: Path, scene: dict[str, Any]
) -> None:
    said: list[str] = []

    def refuse(dialog: Dialog) -> None:
        said.append(dialog.message)
        dialog.dismiss()

    page.on("dialog", refuse)
    with page.expect_file_chooser() as chooser:
        page.click("#open")
    chooser.value.set_files({"name": "odd.json", "mimeType": "application/json", "buffer": json.dumps(scene).encode()})
    wait_for(page, f"{STATE}.scene.robots.length === {len(scene['robots'])} && {FRESH}")
    assert state(page, "scene") == {**state(page, "scene"), **scene}
    for tab in ("Objects", "Plan", "Properties"):
        page.get_by_role("tab", name=tab).click()
    page.click("[data-mode=steps]")
    wait_for(page, f"{STATE}.steps.list !== null")
    page.click("#step-next")
    page.click("[data-mode=compare]")
    wait_for(page, "document.querySelectorAll('.measures tbody td').length > 10", 60_000)
    page.click("[data-mode=edit]")
    page.click("#out")
    with page.expect_download() as made:
        page.click('[data-form="html"]')
    made.value.save_as(tmp_path / "sent.html")
    alone = page.context.new_page()
    alone.on("dialog", refuse)
    alone.goto((tmp_path / "sent.html").as_uri())
    alone.wait_for_selector("#scrub:not([disabled])")
    assert "broken out" not in (page.title(), alone.title())
    assert said == []
    assert page.locator("b b, img").count() == 0


@pytest.mark.parametrize("turn", ["undo", "delete", "mode"])
def test_a_drag_that_is_overtaken_leaves_a_scene_that_undo_gives_back(page: Page, turn: str) -> None:
    open_ready(page, "thesis-2")
    scene = page.evaluate(SHOWN)
    press(page, (7, 7.5), (8, 8))
    page.keyboard.press({"undo": "Control+z", "delete": "Delete", "mode": "2"}[turn])
    page.mouse.move(*at(page, 8.5, 8.5), steps=3)
    page.mouse.up()
    page.keyboard.press("1")
    assert page.evaluate("window.studio.history.dragging()") is False
    while steps_back(page):
        page.click("#undo")
    assert page.evaluate(SHOWN) == scene
    wait_for(page, FRESH)


def test_changing_modes_quickly_ends_in_the_last_one(page: Page) -> None:
    open_ready(page, "thesis-2")
    for k in range(40):
        page.keyboard.press("123"[k % 3])
    page.keyboard.press("1")
    assert state(page, "mode") == "edit"
    assert page.locator("#compare").is_hidden()
    drag(page, (5, 3), (5.5, 3))
    wait_for(page, FRESH)


@pytest.mark.parametrize(("width", "height"), [(400, 700), (640, 400)], ids=["400 px wide", "zoomed to 200 %"])
def test_a_small_window_keeps_everything_in_reach(page: Page, width: int, height: int) -> None:
    open_ready(page, "thesis-2")
    page.set_viewport_size({"width": width, "height": height})
    page.wait_for_timeout(200)
    board = page.locator("#board").bounding_box()
    assert board is not None
    assert min(board["width"], board["height"]) >= 120
    for selector in ("#undo", "#open", "#out", "#help", '[data-mode="steps"]', '[data-tool="robot"]', "#play"):
        part = page.locator(selector)
        part.scroll_into_view_if_needed()
        box = part.bounding_box()
        assert box is not None, selector
        assert -1 <= box["x"] <= width - box["width"] + 1, selector
        assert -1 <= box["y"] <= height - box["height"] + 1, selector


def open_ready(page: Page, name: str) -> None:
    """Open a ready scene by the file menu."""
    page.click("#file-menu")
    page.click("#ready-scenes")
    page.get_by_role("button", name=name).click()
    wait_for(page, f"{STATE}.scene.name === '{name}' && {FRESH}")


def children(process: int) -> list[int]:
    """Return the processes that a process started."""
    found = []
    for path in Path("/proc").glob("[0-9]*/stat"):
        try:
            fields = path.read_text().rpartition(")")[2].split()
        except OSError:  # it has ended
            continue
        if int(fields[1]) == process:
            found.append(int(path.parent.name))
    assert found
    return found
