"""Files and drafts of the studio: what users open, save, throw and lay under; and that nothing of theirs is lost."""

from __future__ import annotations

import contextlib
import io
import json
from pathlib import Path
from typing import TYPE_CHECKING

import pytest

import taut
from studio_page import running_studio, wait_for, wait_until_ready

if TYPE_CHECKING:
    from collections.abc import Iterator

    from playwright.sync_api import Browser, Page

    from studio_page import RunningStudio

pytest_plugins = ("studio_page",)

YARD = """\
taut: 1
name: yard
bounds: [0, 0, 16, 12]
gap: 0.05
obstacles:
  - {name: O1, polygon: [[6, 6], [8, 7], [6.5, 9]]}
robots:
  - {name: R1, start: [1, 1], goal: [14, 10], radius: 0.25}
"""

ADD = """async (name) => {
  const edits = await import("studio/edits.js");
  const { store, history } = window.studio;
  history.change(`add ${name}`, edits.addObstacle(store.get().scene, { name, circle: [3, 3], radius: 0.5 }));
}"""

SHOWN = "JSON.stringify(window.studio.store.get().scene)"
FILE = "window.studio.store.get().file"
DIRTY = f"{FILE}.dirty"


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Return where the scene file is that the user named."""
    return tmp_path_factory.mktemp("yard")


@pytest.fixture(scope="module")
def studio(folder: Path) -> Iterator[RunningStudio]:
    """Return a server for the file."""
    (folder / "yard.yaml").write_text(YARD)
    with running_studio("yard.yaml", folder=folder) as running:
        yield running


@pytest.fixture(autouse=True)
def _fresh(folder: Path) -> None:
    (folder / "yard.yaml").write_text(YARD)


def add(page: Page, name: str) -> None:
    """Edit the scene: one step."""
    page.evaluate(ADD, name)


def names(page: Page) -> list[str]:
    """Return the names of the obstacles shown."""
    found: list[str] = page.evaluate("window.studio.store.get().scene.obstacles.map(({ name }) => name)")
    return found


def choose(page: Page, name: str, content: str | bytes, mime: str = "text/plain") -> None:
    """Open a file by the button and the browser's own dialog."""
    with page.expect_file_chooser() as chooser:
        page.click("#open")
    data = content.encode() if isinstance(content, str) else content
    chooser.value.set_files({"name": name, "mimeType": mime, "buffer": data})


def press(page: Page, label: str) -> None:
    """Press a button of the open dialog."""
    page.get_by_role("button", name=label, exact=True).click()


def visit(page: Page, studio: RunningStudio) -> Page:
    """Open another tab of the same browser."""
    other = page.context.new_page()
    other.goto(studio.url)
    wait_until_ready(other)
    return other


def stamp_drafts(page: Page) -> None:
    """Have the draft written now."""
    page.evaluate("window.studio.drafts.flush()")


def picture(width: int, height: int) -> bytes:
    """Return a PNG file."""
    from PIL import Image

    file = io.BytesIO()
    Image.effect_noise((width, height), 40).save(file, "PNG")
    return file.getvalue()


def told(page: Page, text: str) -> str:
    """Wait until the page says something at its edge, and return all that it says."""
    message = page.locator("#toasts").get_by_text(text)
    message.wait_for()
    return message.text_content() or ""


def crash(page: Page) -> None:
    """End the process of a page at once."""
    from playwright.sync_api import Error

    with page.expect_event("crash"), contextlib.suppress(Error):
        page.goto("chrome://crash")


def test_scene_files_are_opened_whatever_their_format(page: Page) -> None:
    scene = taut.load_scene("thesis-2")
    choose(page, "thesis.json", json.dumps(taut.formats.scene_to_dict(scene)))
    wait_for(page, f"{FILE}.name === 'thesis.json'")
    assert names(page) == [obstacle.name for obstacle in scene.obstacles]
    assert page.evaluate(FILE) == {"name": "thesis.json", "path": None, "format": "json", "dirty": False}
    assert page.evaluate("window.studio.store.get().history") == {"undo": None, "redo": None}

    choose(page, "floor.map", "type octile\nheight 2\nwidth 3\nmap\n...\n.@.\n")
    wait_for(page, f"{FILE}.name.startsWith('floor')")
    assert page.evaluate("window.studio.store.get().scene.robots") == []

    polygon = {"type": "Polygon", "coordinates": [[[0, 0], [9, 0], [9, 5], [0, 5], [0, 0]]]}
    feature = {"type": "Feature", "properties": {"role": "boundary"}, "geometry": polygon}
    choose(page, "site.geojson", json.dumps({"type": "FeatureCollection", "features": [feature]}))
    wait_for(page, f"{FILE}.name === 'site.yaml'")
    box = page.evaluate("async () => (await import('studio/scene.js')).boxOfScene(window.studio.store.get().scene)")
    assert box == [0, 0, 9, 5]


def test_an_opened_plan_is_shown_as_it_is_in_its_file(page: Page) -> None:
    plan = taut.plan(taut.load_scene("thesis-2"), seed=0).plan
    choose(page, "plan.json", json.dumps(taut.formats.plan_to_dict(plan)))
    wait_for(page, f"{FILE}.name === 'thesis-2.yaml'")
    wait_for(page, "window.studio.store.get().answer?.plan?.robots?.length === 3")
    stamps = page.evaluate("window.studio.store.get().answer.plan.robots[0].stamps")
    assert stamps == [list(map(float, stamp)) for stamp in plan.trajectories[0].stamps.tolist()]


def test_what_cannot_be_opened_is_told_with_its_line_and_changes_nothing(page: Page) -> None:
    before = page.evaluate(SHOWN)
    choose(page, "bad.yaml", YARD.replace("radius: 0.25", "radius: wide"))
    assert told(page, "bad.yaml cannot be opened").startswith("bad.yaml cannot be opened: line 8: ")
    page.evaluate("void studio.files.openFile(new File(['#'.repeat(17e6)], 'big.yaml'))")
    told(page, "big.yaml is too large: it takes 17 MB, the studio opens up to 16 MB.")
    page.evaluate("void studio.files.openFile(new File(['\"'.repeat(9e6)], 'quoted.json'))")
    told(page, "quoted.json is too large: it takes 19 MB, the studio opens up to 16 MB.")
    choose(page, "bad.png", b"no picture", "image/png")
    told(page, "bad.png is no picture that this browser can show.")
    assert page.evaluate(SHOWN) == before
    assert page.evaluate("window.studio.store.get().underlay") is None


def test_files_may_be_dropped_on_the_page(page: Page) -> None:
    page.evaluate(
        """(text) => {
          const dataTransfer = new DataTransfer();
          dataTransfer.items.add(new File([text], "dropped.yaml"));
          const drop = (kind) => document.getElementById("board").dispatchEvent(
            new DragEvent(kind, { dataTransfer, bubbles: true, cancelable: true }));
          drop("dragover");
          window.over = document.getElementById("app").classList.contains("dropping");
          drop("drop");
        }""",
        YARD.replace("O1", "crate"),
    )
    wait_for(page, f"{FILE}.name === 'dropped.yaml'")
    assert page.evaluate("window.over")
    assert page.evaluate("!document.getElementById('app').classList.contains('dropping')")
    assert names(page) == ["crate"]


def test_unsaved_changes_are_asked_about_before_they_go(page: Page, folder: Path) -> None:
    add(page, "O2")
    page.evaluate("void window.studio.files.fresh()")
    press(page, "Cancel")
    assert names(page) == ["O1", "O2"]
    page.evaluate("void window.studio.files.fresh()")
    page.keyboard.press("Escape")
    assert names(page) == ["O1", "O2"]
    page.evaluate("void window.studio.files.fresh()")
    press(page, "Save")
    wait_for(page, f"{FILE}.name === 'untitled.yaml'")
    assert [obstacle.name for obstacle in taut.load_scene(folder / "yard.yaml").obstacles] == ["O1", "O2"]
    add(page, "O3")
    page.evaluate("void window.studio.files.fresh()")
    press(page, "Do not save")
    wait_for(page, "window.studio.store.get().scene.obstacles.length === 0")
    assert page.evaluate(DIRTY) is False


def test_saving_writes_the_named_file_and_undo_knows_what_is_saved(page: Page, folder: Path) -> None:
    add(page, "O2")
    assert page.evaluate(DIRTY)
    page.keyboard.press("Control+s")
    told(page, "Saved yard.yaml")
    saved = taut.load_scene(folder / "yard.yaml")
    assert taut.formats.scene_to_dict(saved) == json.loads(page.evaluate(SHOWN))
    assert page.evaluate(DIRTY) is False
    page.evaluate("window.studio.history.undo()")
    assert page.evaluate(DIRTY)
    page.evaluate("window.studio.history.redo()")
    assert page.evaluate(DIRTY) is False
    add(page, "O3")
    assert page.evaluate("window.studio.files.save()") is True  # its own writing is no change by others


def test_a_file_that_others_changed_is_not_overwritten_without_a_word(page: Page, folder: Path) -> None:
    file = folder / "yard.yaml"
    theirs = YARD.replace("gap: 0.05", "gap: 0.5")
    file.write_text(theirs)
    add(page, "O2")
    page.evaluate("void window.studio.files.save()")
    page.get_by_role("heading", name="yard.yaml was changed meanwhile").wait_for()
    press(page, "Cancel")
    wait_for(page, "!document.querySelector('dialog')")
    assert file.read_text() == theirs
    assert page.evaluate(DIRTY)
    page.evaluate("void window.studio.files.save()")
    press(page, "Overwrite")
    told(page, "Saved yard.yaml")
    assert taut.load_scene(file).gap == 0.05


def test_comments_do_not_go_without_a_word(page: Page, folder: Path, studio: RunningStudio) -> None:
    file = folder / "yard.yaml"
    file.write_text("# measured on Monday\n" + YARD)
    page.reload()
    wait_until_ready(page)
    add(page, "O2")
    page.evaluate("void window.studio.files.save()")
    page.get_by_role("heading", name="Comments in yard.yaml would go").wait_for()
    with page.expect_download() as download:
        press(page, "Download a copy instead")
    assert file.read_text().startswith("# measured")
    assert "O2" in download.value.path().read_text()
    assert page.evaluate(DIRTY), "a copy is not the file"
    page.evaluate("void window.studio.files.save()")
    press(page, "Save without comments")
    told(page, "Saved yard.yaml")
    assert "#" not in file.read_text()


def test_what_is_in_no_named_file_is_saved_as_a_download(page: Page) -> None:
    choose(page, "other.yaml", YARD)
    wait_for(page, f"{FILE}.name === 'other.yaml'")
    add(page, "O2")
    for run, name in (("save()", "other.yaml"), ("saveAs('json')", "other.json")):
        with page.expect_download() as download:
            assert page.evaluate(f"window.studio.files.{run}")
        assert download.value.suggested_filename == name
        text = download.value.path().read_text()
        assert ("\n- " in text or "\n  - " in text) == name.endswith("yaml")
    assert json.loads(text) == json.loads(page.evaluate(SHOWN))
    assert page.evaluate(DIRTY) is False


def test_a_random_scene_says_its_seed_and_the_next_one_is_one_press_away(page: Page) -> None:
    page.evaluate("void window.studio.files.random()")
    for label, value in (("Robots", 3), ("Obstacles", 4), ("Seed", 41)):
        page.get_by_role("dialog").get_by_label(label).fill(str(value))
    press(page, "Make scene")
    told(page, "Random scene of seed 41: 3 robots, 4 obstacles")
    first = json.loads(page.evaluate(SHOWN))
    assert first == taut.formats.scene_to_dict(taut.random_scene(robots=3, obstacles=4, seed=41))
    press(page, "Again, seed 42")
    told(page, "Random scene of seed 42")
    second = json.loads(page.evaluate(SHOWN))
    assert second == taut.formats.scene_to_dict(taut.random_scene(robots=3, obstacles=4, seed=42))


def test_the_ready_scenes_are_shown_and_opened(page: Page) -> None:
    page.evaluate("void window.studio.files.ready()")
    page.locator("[data-scene=corridor-swap]").click()
    wait_for(page, f"{FILE}.name === 'corridor-swap.yaml'")
    assert page.evaluate("window.studio.store.get().scene.name") == "corridor-swap"


def test_an_edit_is_kept_within_a_second_and_a_reload_brings_it_back(page: Page) -> None:
    page.evaluate("studio.store.set({ settings: { method: 'mrppa' } })")
    waited = page.evaluate(
        f"""async () => {{
          const kept = () => Object.keys(localStorage).some((key) => localStorage[key].includes('"O7"'));
          const before = performance.now();
          await ({ADD})("O7");
          while (!kept()) await new Promise((resolve) => setTimeout(resolve, 5));
          return performance.now() - before;
        }}"""
    )
    assert waited < 1000
    shown = page.evaluate(SHOWN)
    page.reload()
    told(page, "Your unsaved work from")
    assert page.evaluate(SHOWN) == shown
    assert page.evaluate(DIRTY)
    assert page.evaluate("window.studio.store.get().settings") == {"method": "mrppa"}
    page.reload()
    told(page, "Your unsaved work from")
    assert page.evaluate(SHOWN) == shown, "also a second time"


def test_a_reload_without_changes_shows_what_the_file_holds_now(page: Page, folder: Path) -> None:
    stamp_drafts(page)
    (folder / "yard.yaml").write_text(YARD.replace("O1", "crate"))
    page.reload()
    wait_until_ready(page)
    wait_for(page, "window.studio.store.get().saved !== undefined")
    assert names(page) == ["crate"]
    assert page.evaluate(DIRTY) is False


def test_the_work_of_a_tab_that_crashed_is_offered(page: Page, studio: RunningStudio) -> None:
    add(page, "O8")
    page.wait_for_timeout(400)
    shown = page.evaluate(SHOWN)
    crash(page)
    other = visit(page, studio)
    other.get_by_role("heading", name="Recover unsaved work from").wait_for()
    press(other, "Recover")
    wait_for(other, "window.studio.store.get().scene.obstacles.length === 2")
    assert other.evaluate(SHOWN) == shown
    assert other.evaluate(DIRTY)


def test_the_work_of_a_closed_tab_is_offered_until_it_is_discarded(page: Page, studio: RunningStudio) -> None:
    first = visit(page, studio)
    add(first, "O8")
    first.close(run_before_unload=False)
    second = visit(page, studio)
    second.get_by_role("heading", name="Recover unsaved work from").wait_for()
    second.keyboard.press("Escape")
    second.close()
    third = visit(page, studio)
    third.get_by_role("heading", name="Recover unsaved work from").wait_for()
    press(third, "Discard")
    assert names(third) == ["O1"]
    fourth = visit(page, studio)
    fourth.wait_for_timeout(500)
    assert fourth.get_by_role("heading", name="Recover unsaved work from").count() == 0


def test_two_tabs_keep_their_own_drafts(page: Page, studio: RunningStudio) -> None:
    other = visit(page, studio)
    add(page, "left")
    add(other, "right")
    page.wait_for_timeout(400)
    for tab, name in ((page, "left"), (other, "right")):
        tab.reload()
        told(tab, "Your unsaved work from")
        assert names(tab) == ["O1", name]
    third = visit(page, studio)
    third.wait_for_timeout(500)
    assert third.get_by_role("heading", name="Recover unsaved work from").count() == 0, "the two others live"


def test_a_copy_of_a_tab_gets_a_draft_of_its_own(page: Page, studio: RunningStudio) -> None:
    stamp_drafts(page)
    tab = page.evaluate("sessionStorage.getItem('taut:tab')")
    other = page.context.new_page()
    other.goto(studio.origin + "/page/icon.svg")
    other.evaluate("(tab) => sessionStorage.setItem('taut:tab', tab)", tab)
    other.goto(studio.url)
    wait_for(other, "Boolean(window.studio?.store?.get().saved)")
    assert other.evaluate("sessionStorage.getItem('taut:tab')") not in (tab, None)


def test_a_full_storage_is_told_and_the_page_goes_on(page: Page) -> None:
    page.evaluate(
        """() => {
          const fill = (size) => {
            try { for (let k = 0; ; k += 1) localStorage.setItem(`other ${size} ${k}`, "x".repeat(size)); } catch {}
          };
          for (const size of [1e6, 1e5, 1e4, 1e3, 100, 10, 1]) fill(size);
        }"""
    )
    page.evaluate("localStorage.removeItem(Object.keys(localStorage).find((key) => key.startsWith('taut:draft')))")
    page.evaluate(
        """() => {
          try { for (let k = 0; ; k += 1) localStorage.setItem(`more ${k}`, "x".repeat(100)); } catch {}
        }"""
    )
    add(page, "O2")
    told(page, "This browser's storage is full")
    assert "storage is full" in page.evaluate("window.studio.store.get().saved.wrong")
    add(page, "O3")
    assert names(page) == ["O1", "O2", "O3"]
    page.evaluate("localStorage.clear()")
    add(page, "O4")
    wait_for(page, "Boolean(window.studio.store.get().saved.time)")


def test_a_picture_is_laid_under_put_to_scale_moved_and_undone(page: Page) -> None:
    choose(page, "floor.png", picture(3000, 1500), "image/png")
    wait_for(page, "window.studio.store.get().underlay !== null")
    underlay = page.evaluate("(({ data, ...rest }) => rest)(window.studio.store.get().underlay)")
    assert underlay == {
        "name": "floor.png",
        "pixels": [2048, 1024],
        "x": 0,
        "y": 2,
        "scale": 0.0078125,
        "opacity": 0.5,
        "locked": False,
    }
    board = page.locator("#board")
    box = board.bounding_box()
    assert box is not None
    page.evaluate("studio.store.set({ tool: 'underlay-scale' })")
    scale = page.evaluate("studio.camera.get().scale")
    board.click(position={"x": 300, "y": 200})
    board.click(position={"x": 300 + 2 * scale, "y": 200})
    page.get_by_label("Distance").fill("4")
    press(page, "Set scale")
    wait_for(page, "window.studio.store.get().underlay.scale > 0.01")
    assert page.evaluate("studio.store.get().underlay.scale") == pytest.approx(2 * 0.0078125, rel=0.02)
    assert page.evaluate("studio.store.get().tool") == "select"

    x = page.evaluate("studio.store.get().underlay.x")
    page.evaluate("studio.store.set({ tool: 'underlay-move' })")
    page.mouse.move(box["x"] + 300, box["y"] + 200)
    page.mouse.down()
    for k in range(1, 6):
        page.mouse.move(box["x"] + 300 + k * scale / 5, box["y"] + 200)
    page.mouse.up()
    assert page.evaluate("studio.store.get().underlay.x") == pytest.approx(x + 1, abs=0.05)
    labels = page.evaluate("studio.history.labels().undo")
    assert labels == ["move the picture", "scale the picture", "lay a picture under"]
    assert page.evaluate(DIRTY) is False, "a picture is no part of the scene's file"

    page.wait_for_timeout(400)
    page.reload()
    wait_until_ready(page)
    wait_for(page, "window.studio.store.get().underlay !== null")
    assert page.evaluate("studio.store.get().underlay.x") == pytest.approx(x + 1, abs=0.05)


def test_a_picture_that_the_storage_cannot_hold_costs_only_itself(page: Page) -> None:
    page.evaluate(
        """() => {
          for (let k = 0; k < 49; k += 1) localStorage.setItem(`other ${k}`, "x".repeat(1e5));
        }"""
    )
    choose(page, "noise.png", picture(2048, 2048), "image/png")
    told(page, "The picture is too large for this browser's storage")
    add(page, "O2")
    page.wait_for_timeout(400)
    page.reload()
    told(page, "Your unsaved work from")
    assert names(page) == ["O1", "O2"]
    assert page.evaluate("studio.store.get().underlay") is None


def test_work_outlives_the_server(browser: Browser, tmp_path: Path) -> None:
    (tmp_path / "yard.yaml").write_text(YARD)
    context = browser.new_context(accept_downloads=True)
    page = context.new_page()
    with running_studio("yard.yaml", folder=tmp_path) as running:
        page.goto(running.url)
        wait_for(page, "Boolean(window.studio?.store?.get().saved)")
        running.process.kill()
        running.process.wait()
    wait_for(page, "!window.studio.link.isUp()")
    add(page, "O5")
    assert page.evaluate("window.studio.files.save()") is False
    with page.expect_download() as download:
        press(page, "Download a copy")
    assert json.loads(download.value.path().read_text()) == json.loads(page.evaluate(SHOWN))
    shown = page.evaluate(SHOWN)
    with running_studio("yard.yaml", folder=tmp_path) as again:
        assert again.origin == running.origin
        wait_for(page, "window.studio.store.get().server.refused === true")
        other = context.new_page()
        other.goto(again.url)
        other.get_by_role("heading", name="Recover unsaved work from").wait_for()
        press(other, "Recover")
        wait_for(other, f"{SHOWN} === {json.dumps(shown)}")
        told(page, "This work goes on in another tab")
    context.close()
