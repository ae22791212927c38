"""The studio's frame in a real browser: live planning, panels, keys, dialogs, the link, light and dark."""

from __future__ import annotations

import json
import re
import time
from pathlib import Path
from typing import TYPE_CHECKING, Any

import pytest

import studio_page
import taut.studio

if TYPE_CHECKING:
    from playwright.sync_api import Browser, Page

pytest_plugins = ("studio_page",)
STUDIO_WORDS = ("thesis-2",)
PAGE = Path(taut.studio.__file__).parent / "page"


FRESH = """(({planning, answer, revision}) => planning.state === "fresh" && answer.revision === revision)
  (window.studio.store.get())"""


def until(page: Page, condition: str, seconds: float = 30) -> None:
    """Wait until an expression of the page is true (the page's own policy forbids Playwright's waiting)."""
    end = time.monotonic() + seconds
    while not page.evaluate(condition):
        assert time.monotonic() < end, f"never: {condition}; planning: {state(page, 'planning')}"
        page.wait_for_timeout(25)


def state(page: Page, key: str) -> Any:
    """Return a part of the page's state."""
    return page.evaluate("key => JSON.parse(JSON.stringify(window.studio.store.get()[key] ?? null))", key)


def planned(page: Page) -> None:
    """Wait until the plan is that of the scene as it is."""
    until(
        page,
        FRESH,
    )


def select(page: Page, *refs: dict[str, Any]) -> None:
    page.evaluate("refs => window.studio.store.set({selection: refs, tab: 'properties'})", list(refs))
    page.wait_for_timeout(60)


def field(page: Page, name: str, nth: int = 0) -> Any:
    return page.locator(f'#panel [data-field="{name}"] input').nth(nth)


def pixel(page: Page, x: float, y: float) -> tuple[float, float]:
    """Return where a place of the map is on the screen."""
    across, down = page.evaluate(
        """([x, y]) => {
          const {x: cx, y: cy, scale} = window.studio.camera.get();
          const box = document.getElementById("board").getBoundingClientRect();
          return [box.left + (x - cx) * scale + box.width / 2, box.top + (cy - y) * scale + box.height / 2];
        }""",
        [x, y],
    )
    return across, down


def test_the_frame_has_what_tests_and_screen_readers_look_for(page: Page) -> None:
    for selector in (
        "#board",
        "#undo",
        "#redo",
        "#open",
        "#save",
        "#out",
        "#theme",
        "#help",
        "#play",
        "#scrub",
        "#speed",
        "#loop",
        "#panel",
        "#objects",
        "#status",
        "#planning",
        '[data-tool="select"]',
        '[data-mode="edit"]',
    ):
        assert page.locator(selector).count() == 1, selector
    nameless = page.evaluate(
        """() => [...document.querySelectorAll("button, input, select, canvas, [role=listbox]")]
          .filter((node) => node.checkVisibility())
              .filter((node) => !node.getAttribute("aria-label") && !node.textContent.trim() && !node.labels?.length)
          .map((node) => node.outerHTML.slice(0, 120))"""
    )
    assert nameless == []
    assert page.evaluate("document.getElementById('board').getAttribute('role')") == "application"


def test_a_drag_plans_live_and_is_one_step(page: Page) -> None:
    planned(page)
    before = state(page, "scene")
    x, y = pixel(page, 7, 7.5)
    page.mouse.move(x, y)
    page.mouse.down()
    for k in range(30):
        page.mouse.move(x + k, y - k / 2)
        page.wait_for_timeout(16)
    page.mouse.up()
    planned(page)
    assert state(page, "scene") != before
    assert state(page, "answer")["scene"] == state(page, "scene")
    until(page, "window.studio.latencies.length > 0")
    assert page.evaluate("performance.getEntriesByName('drag-to-plan').length") > 0
    page.keyboard.press("Control+z")
    assert json.dumps(state(page, "scene")) == json.dumps(before)
    assert state(page, "history")["undo"] is None
    planned(page)


def test_numbers_may_be_sums_and_have_units(page: Page) -> None:
    read = """async ([text, unit]) => (await import("studio/panel_numbers.js")).readNumber(text, unit)"""
    for text, unit, value in (
        ("3.5", "m", 3.5), ("3+0.5", "m", 3.5), ("(16 - 2) / 4", "m", 3.5), ("350 cm", "m", 3.5), ("57 cm", "m", 0.57),
        ("1,5", "m", 1.5), ("−2", "m", -2), ("-2e-3", "m", -0.002), ("1 km + 1 m", "m", 1001), ("2 min", "s", 120),
        ("36 km/h", "m/s", 10), ("90°", "deg", 90), (".5", "", 0.5), ("- (2 - 3)", "", 1), ("1e-9", "m", 1e-9),
    ):  # fmt: skip
        assert page.evaluate(read, [text, unit]).get("value") == pytest.approx(value, rel=1e-15), text
    for text, unit in (
        ("", "m"),
        ("abc", "m"),
        ("3 4", "m"),
        ("3 +", "m"),
        ("(3", "m"),
        ("1/0", "m"),
        ("3 s", "m"),
        ("m", "m"),
        ("3)", ""),
    ):
        wrong = page.evaluate(read, [text, unit]).get("wrong")
        assert wrong, text
        assert wrong.endswith("."), text


def test_a_number_reads_back_as_it_was_written(page: Page) -> None:
    values = [0.1, 1 / 3, -2.5e-9, 1e21, 123456789.123456789, 0.1 + 0.2]
    back = page.evaluate(
        """async (values) => {
          const {readNumber, writeNumber} = await import("studio/panel_numbers.js");
          return values.map((value) => readNumber(writeNumber(value)).value);
        }""",
        values,
    )
    assert back == values


def test_fields_change_the_selection_and_wrong_ones_change_nothing(page: Page) -> None:
    select(page, {"kind": "robot", "name": "R1"})
    radius = field(page, "radius")
    radius.fill("10 cm + 0.05")
    radius.press("Enter")
    assert state(page, "scene")["robots"][0]["radius"] == pytest.approx(0.15)
    before = state(page, "scene")
    for text, part in (("-1", "at least 0"), ("much", "no part of a number"), ("", "number")):
        radius.fill(text)
        radius.press("Enter")
        assert radius.input_value() == text
        assert radius.get_attribute("aria-invalid") == "true"
        assert part in page.locator('#panel [data-field="radius"] .field-wrong').inner_text()
        assert state(page, "scene") == before
    radius.press("Escape")
    assert radius.input_value() == "0.15"
    assert radius.get_attribute("aria-invalid") == "false"


def test_a_name_that_is_taken_is_refused_where_it_is_typed(page: Page) -> None:
    select(page, {"kind": "robot", "name": "R1"})
    name = field(page, "name")
    name.fill("R2")
    name.press("Enter")
    assert "R2" in page.locator('#panel [data-field="name"] .field-wrong').inner_text()
    name.fill("courier")
    name.press("Enter")
    assert [robot["name"] for robot in state(page, "scene")["robots"]] == ["courier", "R2", "R3"]
    assert state(page, "selection") == [{"kind": "robot", "name": "courier"}]


def test_several_robots_have_their_common_fields(page: Page) -> None:
    page.evaluate("""() => {
      const {scene} = window.studio.store.get();
      const robots = scene.robots.map((robot, k) => ({...robot, speed: 1 + k}));
      window.studio.history.change("speeds", {...scene, robots});
    }""")
    select(page, *({"kind": "robot", "name": name} for name in ("R1", "R2", "R3")))
    assert field(page, "speed").input_value() == ""
    assert field(page, "speed").get_attribute("placeholder") == "different"
    assert field(page, "radius").input_value() == "0"
    field(page, "speed").fill("2")
    field(page, "speed").press("Enter")
    assert [robot["speed"] for robot in state(page, "scene")["robots"]] == [2, 2, 2]
    assert state(page, "history")["undo"] == "set speed of 3 objects"


def test_corners_are_a_table(page: Page) -> None:
    select(page, {"kind": "obstacle", "name": "O1"})
    assert page.locator(".corner").count() == 4
    page.get_by_label("Add a corner after corner 1", exact=True).click()
    until(page, "document.querySelectorAll('.corner').length === 5")
    assert state(page, "scene")["obstacles"][0]["polygon"][1] == pytest.approx([6.15, 2])
    page.locator('.corner [data-field="y"] input').nth(1).fill("1.5")
    page.locator('.corner [data-field="y"] input').nth(1).press("Enter")
    assert state(page, "scene")["obstacles"][0]["polygon"][1] == pytest.approx([6.15, 1.5])
    page.get_by_label("Remove corner 2", exact=True).click()
    until(page, "document.querySelectorAll('.corner').length === 4")


def test_the_scene_has_fields_when_nothing_is_selected(page: Page) -> None:
    select(page)
    field(page, "gap").fill("20 cm")
    field(page, "gap").press("Enter")
    field(page, "bounds-2").fill("16 + 4")
    field(page, "bounds-2").press("Enter")
    scene = state(page, "scene")
    assert scene["gap"] == pytest.approx(0.2)
    assert scene["bounds"] == [0, 0, 20, 16]


def test_the_list_of_objects_says_and_rules_everything(page: Page) -> None:
    page.click('[data-tab="objects"]')
    rows = page.locator("#objects [role=option]")
    assert rows.count() == 9
    assert rows.nth(0).get_attribute("aria-label") == "Robot R1, radius 0 metres, from 3, 1 to 12, 12.7"
    assert rows.nth(3).get_attribute("aria-label") == "Obstacle O1, polygon of 4 corners at 6.15, 3"
    page.focus("#objects")
    page.keyboard.press("End")
    assert state(page, "selection") == [{"kind": "obstacle", "name": "O6"}]
    page.keyboard.press("Shift+ArrowUp")
    assert len(state(page, "selection")) == 2
    page.keyboard.press("Delete")
    until(page, "document.querySelectorAll('#objects [role=option]').length === 7")
    listen(page)
    page.keyboard.press("Control+z")
    until(page, "document.querySelectorAll('#objects [role=option]').length === 9")
    heard(page, "Undid: delete 2 objects")
    rows.nth(4).click()
    page.keyboard.press("F2")
    until(page, "document.activeElement.value === 'O2'")


def listen(page: Page) -> None:
    """Keep all that is said to screen readers from now on."""
    page.evaluate(
        """() => {
          window.heard = [];
          const keep = (changes) => window.heard.push(...changes.map(({target}) => target.textContent));
          const observer = new MutationObserver(keep);
          for (const id of ["say", "say-now"]) observer.observe(document.getElementById(id), {childList: true});
        }"""
    )


def heard(page: Page, words: str) -> None:
    """Wait until some words have been said."""
    until(page, f"window.heard.some((said) => said.includes({json.dumps(words)}))")


def test_names_are_text_and_never_markup(page: Page) -> None:
    evil = "<img src=x onerror=window.hurt=1>"
    page.evaluate(
        """(name) => {
      const {scene} = window.studio.store.get();
      const robots = [{...scene.robots[0], name}, ...scene.robots.slice(1)];
      window.studio.history.change(name, {...scene, name, robots});
    }""",
        evil,
    )
    planned(page)
    for tab in ("objects", "plan", "properties"):
        page.click(f'[data-tab="{tab}"]')
        page.wait_for_timeout(60)
    assert page.locator("#objects .object-name").first.text_content() == evil
    assert page.evaluate("window.hurt ?? document.querySelectorAll('img').length") == 0


def test_why_there_is_no_plan_is_told_and_the_last_good_one_stays(page: Page) -> None:
    planned(page)
    good = state(page, "answer")["plan"]
    listen(page)
    page.evaluate("""() => {
      const {scene} = window.studio.store.get();
      const line = [[11, 11.5], [13, 11.5], [13, 14], [11, 14], [11, 11.5]];
      const obstacles = [...scene.obstacles, {name: "W", line, width: 0.2}];
      window.studio.history.change("wall R1's goal in", {...scene, obstacles});
    }""")
    until(page, "window.studio.store.get().planning.state === 'failed'")
    wrong = state(page, "planning")["wrong"]
    assert wrong["kind"] == "no path"
    assert wrong["why"]["from"]
    assert wrong["why"]["to"]
    assert state(page, "answer")["plan"] == good
    page.click('[data-tab="plan"]')
    until(page, "document.querySelector('#verdict.stale') !== null")
    assert "R1" in page.locator(".card.bad").inner_text()
    assert "no plan" in page.locator("#planning").inner_text()
    heard(page, "No plan.")
    page.keyboard.press("Control+z")
    planned(page)
    until(page, "document.querySelector('#verdict.good') !== null")


def test_problems_are_listed_and_lead_to_their_place(page: Page) -> None:
    page.evaluate("""() => {
      const {scene} = window.studio.store.get();
      const robots = [{...scene.robots[0], start: [6, 3]}, ...scene.robots.slice(1)];
      window.studio.history.change("into O1", {...scene, robots});
    }""")
    until(page, "window.studio.store.get().problems.length > 0")
    page.click('[data-tab="plan"]')
    page.locator(".card.bad .spot").first.click()
    assert state(page, "selection") == [{"kind": "robot", "name": "R1"}]
    assert page.locator('[data-tab="plan"].troubled').count() == 1


def test_settings_are_planned_with_and_improving_can_be_stopped(page: Page) -> None:
    planned(page)
    page.click('[data-tab="plan"]')
    page.locator('#body-plan [data-field="method"] select').select_option(label="MRPPA")
    planned(page)
    assert state(page, "answer")["plan"]["planner"]["method"] == "mrppa"
    assert not page.locator('#body-plan [data-field="roadmap"]').is_visible()
    page.locator('#body-plan [data-field="method"] select').select_option(label="Repair")
    planned(page)
    assert state(page, "answer")["plan"]["planner"]["method"] == "prioritized"  # the quick one, while drawing
    page.locator('#body-plan [data-field="rounds"] input').fill("3")
    page.locator('#body-plan [data-field="rounds"] input').press("Enter")
    planned(page)
    page.click("#improve")
    until(page, "window.studio.store.get().answer.improved")
    assert state(page, "answer")["plan"]["planner"]["method"] == "repair"
    page.evaluate("""async () => {
      const {scene} = await window.studio.link.ask("ready", {name: "crossing-30"}).promise;
      window.studio.history.change("crossing", scene);
      window.studio.store.set({settings: Object.freeze({seconds: 600})});
    }""")
    planned(page)
    page.click("#improve")
    improving = "window.studio.store.get().planning.improving"
    until(page, f"{improving} && window.studio.store.get().planning.progress?.cost", 120)
    page.click("#stop")
    until(page, "!window.studio.store.get().planning.running", 20)
    assert state(page, "planning")["state"] == "fresh"
    assert state(page, "answer")["improved"]  # the best plan that it had found
    assert state(page, "answer")["certificate"]["ok"]


def test_the_steps_have_keys(page: Page) -> None:
    planned(page)
    page.focus("#board")
    page.keyboard.press("2")
    until(page, "window.studio.store.get().steps.list?.length > 2")
    page.keyboard.press(".")
    page.keyboard.press(".")
    page.keyboard.press(",")
    assert state(page, "steps")["index"] == 1


def test_a_conflict_leads_to_its_time_and_place(page: Page) -> None:
    planned(page)
    page.click('[data-tab="plan"]')
    page.locator(".spot-link").first.click()
    certificate = state(page, "answer")["certificate"]
    assert state(page, "time")["now"] == pytest.approx(certificate["separation"]["time"])
    assert state(page, "focus")["place"] == certificate["separation"]["place"]


def test_the_sheet_of_keys_is_the_table_of_keys(page: Page) -> None:
    page.focus("#board")
    page.keyboard.press("?")
    sheet = page.locator("dialog[open]").inner_text()
    titles = page.evaluate("""async () => [
      ...(await import("studio/keys.js")).KEYS.map(({title}) => title),
      ...(await import("studio/tools.js")).TOOLS.map(({title}) => title)]""")
    assert len(titles) > 25
    assert [title for title in titles if title not in sheet] == []
    page.keyboard.press("Escape")
    assert page.locator("dialog[open]").count() == 0


def test_no_key_is_given_twice(page: Page) -> None:
    keys = page.evaluate("""async () => [
      ...(await import("studio/keys.js")).KEYS.flatMap(({keys}) => keys),
      ...(await import("studio/tools.js")).TOOLS.flatMap(({key}) => key ? [key.toLowerCase()] : [])]""")
    assert sorted(keys) == sorted(set(keys))


def test_keys_in_a_field_are_the_field_s(page: Page) -> None:
    select(page, {"kind": "obstacle", "name": "O2"})
    name = field(page, "name")
    name.press("End")
    name.press("Backspace")
    name.press("2")
    assert state(page, "mode") == "edit"
    assert name.input_value() == "O2"
    assert len(state(page, "scene")["obstacles"]) == 6
    page.focus("#board")
    page.keyboard.press("Delete")
    assert len(state(page, "scene")["obstacles"]) == 5


def test_what_is_being_typed_is_part_of_what_is_saved(page: Page) -> None:
    select(page)
    field(page, "gap").fill("0.3")
    with page.expect_download() as download:
        field(page, "gap").press("Control+s")
    assert "gap: 0.3" in download.value.path().read_text()
    assert state(page, "scene")["gap"] == 0.3


def test_the_theme_is_kept(page: Page) -> None:
    page.click("#theme")
    page.click("#theme")
    assert page.evaluate("document.documentElement.dataset.theme") == "dark"
    page.reload()
    studio_page.wait_until_ready(page)
    assert state(page, "themeChoice") == "dark"
    assert page.evaluate("document.documentElement.dataset.theme") == "dark"


def test_a_form_that_is_wrong_stays_open_and_gives_the_focus_back(page: Page) -> None:
    page.focus("#help")
    page.evaluate("""() => {
      window.studio.dialogs.form({title: "Numbers", fields: [
        {name: "n", label: "How many", type: "number", value: 3, whole: true, min: 1},
        {name: "kind", label: "Kind", type: "select", value: "b",
          options: [{value: "a", label: "A"}, {value: "b", label: "B"}]},
      ]}).then((answer) => { window.given = answer; });
    }""")
    box = page.locator("dialog[open] input").first
    box.fill("2.5")
    box.press("Enter")
    assert page.locator("dialog[open]").count() == 1
    assert "whole" in page.locator("dialog .field-wrong").first.inner_text()
    box.fill("2 + 2")
    box.press("Enter")
    until(page, "window.given !== undefined")
    assert page.evaluate("window.given.values") == {"n": 4, "kind": "b"}
    assert page.evaluate("document.activeElement.id") == "help"


def test_menus_go_by_keyboard(page: Page) -> None:
    page.focus("#view-menu")
    page.keyboard.press("Enter")
    page.keyboard.press("ArrowDown")
    page.keyboard.press("Enter")
    assert state(page, "show") == {"grid": False}
    assert page.evaluate("document.activeElement.id") == "view-menu"


LINK = """async () => {
  const {createLink, Wrong, Stopped} = await import("studio/link.js");
  const Real = window.WebSocket;
  const sockets = [], log = [];
  window.WebSocket = class {
    constructor(url) { this.url = url; this.sent = []; sockets.push(this); }
    send(frame) { this.sent.push(JSON.parse(frame)); }
    close() { this.onclose({reason: ""}); }
    say(message) { this.onmessage({data: JSON.stringify(message)}); }
  };
  const tick = (ms = 0) => new Promise((resolve) => setTimeout(resolve, ms));
  const told = (promise) => promise.then((ok) => log.push(["ok", ok]), (error) =>
    log.push([error instanceof Wrong ? "wrong" : error instanceof Stopped ? error.reason : "?", error.message]));
  const link = createLink("ws://nowhere");
  let down = null;
  link.on("down", ({refused}) => { down = refused; });
  const first = link.ask("check", {scene: {}}, {lane: "check"});
  told(first.promise);
  log.push(["sent before it is up", sockets[0].sent.length]);
  sockets[0].say({hello: {}});
  log.push(["sent", [...sockets[0].sent]]);
  sockets[0].say({id: first.id, ok: {problems: []}});
  const second = link.ask("plan", {}, {progress: ({text}) => log.push(["progress", text])});
  told(second.promise);
  sockets[0].say({id: second.id, progress: {text: "half"}});
  sockets[0].say({id: second.id, wrong: {message: "No way.", kind: "no path"}});
  sockets[0].say({id: 99, ok: {}});
  const third = link.ask("plan");
  told(third.promise);
  third.cancel();
  log.push(["sent last", sockets[0].sent.at(-1)]);
  sockets[0].say({id: third.id, stopped: "cancelled"});
  told(link.ask("plan").promise);
  sockets[0].close();
  await tick(50);
  told(link.ask("late").promise);
  const never = link.ask("never");
  told(never.promise);
  never.cancel();
  while (sockets.length < 2) await tick(10);
  log.push(["down", down]);
  sockets[1].say({hello: {}});
  log.push(["sent again", sockets[1].sent.map(({ask}) => ask)]);
  window.WebSocket = Real;
  link.close();
  await tick();
  return log;
}"""


def test_the_link_answers_each_ask_once_and_comes_back(page: Page) -> None:
    assert page.evaluate(LINK) == [
        ["sent before it is up", 0],
        ["sent", [{"id": 1, "ask": "check", "lane": "check", "scene": {}}]],
        ["progress", "half"],
        ["sent last", {"cancel": 3}],
        ["ok", {"problems": []}],
        ["wrong", "No way."],
        ["cancelled", "stopped: cancelled"],
        ["lost", "stopped: lost"],
        ["cancelled", "stopped: cancelled"],
        ["down", False],
        ["sent again", ["late"]],
        ["lost", "stopped: lost"],
    ]


LANE = """async ({patience}) => {
  const {newestOnly} = await import("studio/planner_lane.js");
  const {Stopped} = await import("studio/link.js");
  const log = [], asks = [];
  const lane = newestOnly({
    start: () => {
      const ask = {id: asks.length};
      ask.promise = new Promise((resolve, reject) => { ask.resolve = resolve; ask.reject = reject; });
      ask.cancel = () => ask.reject(new Stopped("cancelled"));
      asks.push(ask);
      return ask;
    },
    done: (ok, {id}) => log.push(`done ${id}`),
    failed: (error, {id}) => log.push(`failed ${id}`),
    ended: (reason) => log.push(reason),
  });
  const tick = (ms = 0) => new Promise((resolve) => setTimeout(resolve, ms));
  lane.want(); lane.want(); lane.want();
  log.push(`asked ${asks.length}`);
  asks[0].resolve(); await tick();
  log.push(`asked ${asks.length}`);
  lane.want(); await tick(patience);
  log.push(`asked ${asks.length}`);
  asks[1].reject(new Stopped("newer")); await tick();
  asks[2].reject(new Error("no")); await tick();
  log.push(lane.running());
  lane.want(); lane.want(); lane.cancel(); await tick(patience);
  log.push(`asked ${asks.length}`, lane.running());
  return log;
}"""


def test_a_comparison_leaves_out_what_its_method_does_not_take_and_always_ends(page: Page) -> None:
    compared = """async (settings) => (await import("studio/planner_settings.js")).comparedSettings(settings)"""
    assert page.evaluate(compared, {"method": "search", "order": "longest"}) == {"method": "search"}
    assert page.evaluate(compared, {"method": "optimal"}) == {"method": "optimal", "seconds": 10}
    assert page.evaluate(compared, {"method": "repair", "rounds": 40}) == {"method": "repair", "rounds": 40}
    assert page.evaluate(compared, {"order": "longest"}) == {"order": "longest"}


def test_of_one_kind_of_work_one_is_under_way_and_one_waits(page: Page) -> None:
    assert page.evaluate(LANE, {"patience": 300}) == [
        "asked 1", "done 0", "asked 2", "asked 3", "failed 2", False, "cancelled", "asked 4", False,
    ]  # fmt: skip


SLOW = """async () => {
  const {createPlanner} = await import("studio/planner.js");
  const {createStore} = await import("studio/store.js");
  let plans = 0, dragging = false;
  const link = {on: () => () => {}, ask: (kind) => {
    if (kind === "plan") plans++;
    const answer = {plan: {}, certificate: {ok: true}, metrics: null, phases: {planning: 0.5}, problems: [], notes: []};
    return {id: plans, cancel() {}, promise: new Promise((resolve) => setTimeout(resolve, 50, answer))};
  }};
  const store = createStore({
    scene: null, revision: 0, opened: 0, settings: {}, planning: {state: "idle"}, answer: null, problems: []});
  const planner = createPlanner({store, link, history: {dragging: () => dragging}});
  const edit = () => store.set({scene: {robots: [1]}, revision: store.get().revision + 1});
  const tick = (ms) => new Promise((resolve) => setTimeout(resolve, ms));
  const drag = async (ms) => {
    for (const end = performance.now() + ms; performance.now() < end; await tick(10)) edit();
  };
  edit();
  await tick(200);
  const log = [plans];
  dragging = true;
  await drag(250);
  log.push(plans, store.get().planning.state);
  await tick(400);
  log.push(plans, store.get().planning.state);
  await drag(1500);
  log.push(plans - log[3]);
  planner.destroy();
  return log;
}"""


def test_slow_scenes_are_planned_in_a_drag_when_the_pointer_rests_and_now_and_then(page: Page) -> None:
    first, moving, state_moving, rested, state_rested, later = page.evaluate(SLOW)
    assert (first, moving, state_moving, rested, state_rested) == (1, 1, "stale", 2, "fresh")
    assert 1 <= later <= 3


def test_another_document_forgets_the_plan_before(page: Page) -> None:
    planned(page)
    page.evaluate("""async () => {
      const {store, history, link} = window.studio;
      window.seen = [];
      store.on(["answer"], ({answer}) => window.seen.push(answer === null ? null : answer.scene.name));
      history.change("gap", {...store.get().scene, gap: 0.2});
      const {scene} = await link.ask("ready", {name: "thesis-1"}).promise;
      window.seen = [];
      history.replaceAll({scene, file: {name: "thesis-1", path: null}});
    }""")
    planned(page)
    assert page.evaluate("window.seen.filter((name, k, all) => name !== all[k - 1])") == [None, "thesis-1"]


def test_what_is_too_large_is_told_and_not_sent(page: Page) -> None:
    told = page.evaluate("""() => window.studio.link.ask("check", {scene: {name: "x".repeat(17 << 20)}}).promise
      .then(() => "ok", (error) => error.message)""")
    assert "16 MB" in told
    assert page.evaluate("window.studio.link.isUp()")


def test_colours_can_be_read() -> None:
    css = (PAGE / "studio.css").read_text()
    themes = re.findall(r"^:root(?:\[data-theme=\"dark\"\])? \{(.*?)\n\}", css, re.DOTALL | re.MULTILINE)
    assert len(themes) == 2
    for theme in themes:
        colours = dict(re.findall(r"--([a-z-]+): (#[0-9a-f]{6});", theme))
        grounds = [colours[name] for name in ("paper", "panel")]
        for name in ("ink", "quiet", "accent", "good", "bad", "warn"):
            assert min(contrast(colours[name], ground) for ground in grounds) >= 4.5, name
        for name in ("ink", "quiet"):
            assert min(contrast(colours[name], colours[on]) for on in ("sunken", "hover", "accent-soft")) >= 4.5, name
        assert contrast(colours["accent-ink"], colours["accent"]) >= 4.5
        assert contrast(colours["control"], colours["paper"]) >= 3
        for name in ("bad", "warn"):
            assert contrast(colours["ink"], colours[f"{name}-soft"]) >= 4.5


def contrast(one: str, other: str) -> float:
    """Return the contrast of two colours as WCAG 2 has it."""
    high, low = sorted((luminance(one), luminance(other)), reverse=True)
    return (high + 0.05) / (low + 0.05)


def luminance(colour: str) -> float:
    shares = [int(colour[k : k + 2], 16) / 255 for k in (1, 3, 5)]
    linear = [share / 12.92 if share <= 0.04045 else ((share + 0.055) / 1.055) ** 2.4 for share in shares]
    return sum(weight * share for weight, share in zip((0.2126, 0.7152, 0.0722), linear, strict=True))


def test_a_lost_server_is_told_and_work_goes_on(browser: Browser, tmp_path: Path) -> None:
    with studio_page.running_studio("thesis-2", folder=tmp_path) as running:
        context = browser.new_context(viewport={"width": 1280, "height": 800})
        page = context.new_page()
        page.goto(running.url)
        studio_page.wait_until_ready(page)
        planned(page)
        running.process.kill()
        running.process.wait(10)
        until(page, "document.getElementById('banner').textContent.includes('Server gone')")
        page.evaluate("""() => {
          const {scene} = window.studio.store.get();
          window.studio.history.change("gap", {...scene, gap: 0.2});
        }""")
        assert state(page, "scene")["gap"] == 0.2
    with studio_page.running_studio("thesis-2", folder=tmp_path) as again:
        assert again.origin == running.origin
        until(page, "document.getElementById('banner').textContent.includes('started anew')", 20)
        page.goto(again.url)
        studio_page.wait_until_ready(page)
        until(page, "window.studio.store.get().scene?.gap === 0.2")
        context.close()
