"""Time in the studio, in a real browser: playing, timelines, steps, comparison, and what can be taken away."""

from __future__ import annotations

import json
import subprocess
import sys
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
import pytest

import taut
from studio_page import WARM, wait_for

if TYPE_CHECKING:
    from playwright.sync_api import Browser, Page

pytest_plugins = ("studio_page",)
STUDIO_WORDS = ("thesis-2",)

STATE = "window.studio.store.get()"
FRESH = f"{STATE}.planning.state === 'fresh' && {STATE}.answer !== null"


def state(page: Page, path: str) -> Any:
    return page.evaluate(f"JSON.parse(JSON.stringify({STATE}.{path} ?? null))")


@pytest.fixture
def planned(page: Page) -> Page:
    wait_for(page, FRESH)
    return page


def seek(page: Page, time: float) -> None:
    page.evaluate(
        """time => {
          const scrub = document.getElementById("scrub");
          scrub.value = time;
          scrub.dispatchEvent(new Event("input"));
        }""",
        time,
    )


def test_robots_are_where_the_plan_has_them_at_any_time(planned: Page) -> None:
    plan = taut.plan(taut.load_scene("thesis-2")).plan
    stamps = np.unique(np.concatenate([path.times for path in plan.trajectories]))
    times = [*stamps.tolist(), *np.linspace(0, plan.makespan + 1, 101).tolist()]
    shown = planned.evaluate(
        """async times => {
          const { motionsOf, poseAt } = await import("studio/motion.js");
          const motions = motionsOf(window.studio.store.get().answer);
          return times.map(t => motions.map(motion => { const {x, y} = poseAt(motion, t); return [x, y]; }));
        }""",
        times,
    )
    wanted = [plan.at(time).tolist() for time in times]
    assert np.abs(np.array(shown) - np.array(wanted)).max() < 1e-12


def test_moves_and_waits_are_those_of_the_plan(planned: Page) -> None:
    stamps = [[0, 0, 0], [1, 1, 0], [2, 1, 0], [3, 1, 0], [4, 1, 1], [9, 1, 1]]
    found = planned.evaluate(
        """async stamps => {
          const { motionsOf, poseAt, stretchesOf } = await import("studio/motion.js");
          const scene = {at_goal: "leave", robots: [{name: "R", start: [0, 0], goal: [1, 1], radius: 0.2}]};
          const [motion] = motionsOf({scene, plan: {robots: [{name: "R", stamps}]}});
          return {stretches: stretchesOf(motion), arrival: motion.arrival, headings: [0.5, 2.5, 3.5].map(
            t => poseAt(motion, t).heading), present: [3.999, 4].map(t => poseAt(motion, t).present)};
        }""",
        stamps,
    )
    assert found["arrival"] == 4  # it rests at its goal from then on
    assert found["stretches"] == [
        {"begin": 0, "end": 1, "moves": True},
        {"begin": 1, "end": 3, "moves": False},
        {"begin": 3, "end": 4, "moves": True},
    ]
    assert found["headings"] == pytest.approx([0, 0, np.pi / 2])
    assert found["present"] == [True, False]


def test_the_clock_plays_pauses_seeks_and_loops(planned: Page) -> None:
    end = planned.evaluate("window.studio.player.until()")
    assert end == pytest.approx(taut.plan(taut.load_scene("thesis-2")).plan.makespan)
    planned.select_option("#speed", "25")
    planned.click("#play")
    wait_for(planned, f"{STATE}.time.now > 1")
    planned.click("#play")
    held = state(planned, "time")["now"]
    planned.wait_for_timeout(150)
    assert state(planned, "time")["now"] == held
    seek(planned, end - 0.5)
    planned.click("#play")
    wait_for(planned, f"!{STATE}.time.playing")
    assert state(planned, "time")["now"] == pytest.approx(end)
    planned.click("#loop")
    seek(planned, end - 0.5)
    planned.click("#play")
    wait_for(planned, f"{STATE}.time.now < 2")  # it has begun anew
    assert state(planned, "time")["playing"]
    planned.click("#play")


def test_timelines_tell_of_separation_and_contact_and_lead_to_a_time(planned: Page) -> None:
    wait_for(planned, f"{STATE}.timelines !== null")
    certificate = taut.certify(taut.plan(taut.load_scene("thesis-2")).plan)
    least = state(planned, "timelines.separation.least")["value"]
    assert least == pytest.approx(certificate.min_separation)
    assert state(planned, "timelines.contact") is None
    planned.evaluate("window.studio.store.set({reach: 9})")
    wait_for(planned, f"{STATE}.timelines?.contact != null")
    wanted = taut.contacts(taut.plan(taut.load_scene("thesis-2")).plan, 9.0)
    assert state(planned, "timelines.contact.lambda2") == pytest.approx(wanted.fiedler.tolist())
    labels = [chart.get_attribute("aria-label") or "" for chart in planned.locator("#timelines .charts canvas").all()]
    assert any(label.startswith("λ2") for label in labels)
    box = planned.locator("#timelines").bounding_box()
    assert box is not None
    planned.mouse.click(box["x"] + box["width"] / 2, box["y"] + 20)
    end = planned.evaluate("window.studio.player.until()")
    assert 0.4 * end < state(planned, "time")["now"] < 0.6 * end


def test_a_row_of_the_timelines_points_out_its_robot(planned: Page) -> None:
    rows = planned.locator("#timelines .timeline-rows canvas")
    box = rows.bounding_box()
    assert box is not None
    planned.mouse.move(box["x"] + 300, box["y"] + 16 + 8)
    assert state(planned, "hover") == {"kind": "robot", "name": "R2"}


METHODS = {"mrppa": "Free space", "ca": "Grown", "oca": "", "dijkstra": "Dijkstra", "astar": "A*"}


@pytest.mark.parametrize("of", METHODS)
def test_every_method_can_be_stepped_through(planned: Page, of: str) -> None:
    planned.click("[data-mode=steps]")
    planned.click(f"[data-of={of}]")
    wait_for(planned, f"{STATE}.steps.list !== null && {STATE}.steps.of === '{of}' && !{STATE}.steps.running")
    steps = state(planned, "steps.list")
    assert len(steps) > 3
    assert METHODS[of] in steps[0]["title"]
    for k in range(len(steps)):
        assert planned.inner_text("#step-title") == steps[k]["title"]
        assert planned.locator(".story p").count() == len(steps[k]["story"]) > 0
        planned.evaluate("window.studio.board.draw()")  # an error in painting fails the test
        planned.click("#step-next")
    planned.click("#step-back")
    assert state(planned, "steps.index") == len(steps) - 2


def test_steps_follow_the_scene_and_say_why_there_are_none(planned: Page) -> None:
    planned.click("[data-mode=steps]")
    wait_for(planned, f"{STATE}.steps.list !== null")
    planned.evaluate(
        """async () => {
          const { removed } = await import("studio/edits.js");
          const { scene } = window.studio.store.get();
          const refs = scene.robots.map(({ name }) => ({ kind: "robot", name }));
          window.studio.history.change("Delete robots", removed(scene, refs));
        }"""
    )
    wait_for(planned, f"{STATE}.steps.wrong !== null")
    assert "no robots" in planned.inner_text(".story")
    assert planned.locator("#step-next").is_disabled()


def test_two_settings_are_compared_side_by_side(planned: Page) -> None:
    planned.click("[data-mode=compare]")
    planned.evaluate(
        """window.studio.store.set({compare: Object.freeze({left: {method: "prioritized", order: "longest"},
           right: {method: "optimal"}})})"""
    )
    scene = taut.load_scene("thesis-2")
    left, right = (taut.plan(scene, order="longest").plan, taut.plan(scene, "optimal").plan)
    for row, plan in ((1, left), (2, right)):
        cell = f"document.querySelector('.measures tbody tr:nth-child({row}) td').textContent"
        # a method may have to be compiled first
        wait_for(planned, f"Math.abs({cell} - {plan.sum_of_costs}) < 1e-3", WARM)
    until = planned.evaluate("window.studio.player.until()")
    assert until == pytest.approx(max(left.makespan, right.makespan))
    assert planned.locator(".side canvas").count() == 2


def downloaded(page: Page, form: str, folder: Path) -> Path:
    if not page.locator("[data-form]").count():
        page.click("#out")
    with page.expect_download(timeout=60_000) as coming:
        page.click(f"[data-form={form}]")
    target = folder / coming.value.suggested_filename
    coming.value.save_as(target)
    return target


def test_what_is_exported_is_what_the_command_writes(planned: Page, tmp_path: Path) -> None:
    scene = taut.load_scene("thesis-2")
    assert taut.load_scene(downloaded(planned, "scene-yaml", tmp_path)) == scene
    assert taut.load_scene(downloaded(planned, "scene-json", tmp_path)) == scene
    plan = taut.load_plan(downloaded(planned, "plan", tmp_path))
    assert taut.certify(plan).ok
    assert plan.trajectories == taut.plan(scene).plan.trajectories
    assert downloaded(planned, "png", tmp_path).read_bytes()[:8] == b"\x89PNG\r\n\x1a\n"
    assert b"<svg" in downloaded(planned, "svg", tmp_path).read_bytes()


def test_the_commands_offered_make_this_plan(planned: Page, tmp_path: Path) -> None:
    planned.click("#out")
    wait_for(planned, "document.getElementById('snippet-python').textContent !== ''")
    code = planned.inner_text("#snippet-python")
    assert planned.inner_text("#snippet-command").startswith("taut plan thesis-2 ")
    subprocess.run([sys.executable, "-c", code], cwd=tmp_path, check=True, capture_output=True)
    (made,) = tmp_path.glob("*.json")
    assert taut.load_plan(made).trajectories == taut.plan(taut.load_scene("thesis-2")).plan.trajectories


def test_a_page_sent_as_a_file_plays_without_a_server(planned: Page, browser: Browser, tmp_path: Path) -> None:
    sent = downloaded(planned, "html", tmp_path)
    context = browser.new_context(viewport={"width": 1000, "height": 700}, offline=True)
    alone = context.new_page()
    errors: list[str] = []
    alone.on("pageerror", lambda error: errors.append(str(error)))
    alone.goto(sent.as_uri())
    alone.wait_for_selector("#scrub:not([disabled])")
    first = float(alone.input_value("#scrub"))
    alone.wait_for_timeout(400)
    assert float(alone.input_value("#scrub")) > first  # it plays by itself
    alone.click("#play")
    picture = alone.locator("#board").screenshot()
    alone.mouse.move(500, 300)
    alone.mouse.wheel(0, -400)
    alone.wait_for_timeout(100)
    assert alone.locator("#board").screenshot() != picture
    assert not errors
    assert json.loads(alone.inner_text("#data") or alone.evaluate("document.getElementById('data').textContent"))[
        "title"
    ]
    context.close()


def test_the_slider_stands_over_the_axis_of_the_timelines(planned: Page) -> None:
    wait_for(planned, f"{STATE}.timelines !== null")
    planned.evaluate("window.studio.player.seek(0.3 * window.studio.player.until())")
    scrub, head = (planned.locator(selector).bounding_box() for selector in ("#scrub", ".playhead"))
    assert scrub is not None
    assert head is not None
    thumb = 14  # pixels; its middle runs from half of it behind the left end to half of it before the right one
    assert head["x"] == pytest.approx(scrub["x"] + thumb / 2 + 0.3 * (scrub["width"] - thumb), abs=1)


def test_timelines_fold_and_the_map_stays_where_it_is(planned: Page) -> None:
    where = """() => {
      const { left, top, width, height } = document.getElementById("board").getBoundingClientRect();
      const { x, y, scale } = window.studio.camera.get();
      return [left + width / 2 - x * scale, top + height / 2 + y * scale, scale];
    }"""
    planned.evaluate(
        """() => {
          const { history, store } = window.studio;
          const { scene } = store.get();
          const far = { ...scene.robots[0], name: "R9", start: [1, 1], goal: [1, 1] };
          history.change("add R9", Object.freeze({ ...scene, robots: [...scene.robots, far] }));
        }"""
    )
    before, high = planned.evaluate(where), planned.locator("#board").bounding_box()
    assert high is not None
    wait_for(planned, f"!{STATE}.planning.running")
    assert planned.locator("#board").bounding_box() == high  # another row needs no other room
    planned.click("#fold")
    assert planned.locator("#timelines").is_hidden()
    assert planned.locator("#board").bounding_box() != high
    assert planned.evaluate(where) == pytest.approx(before)
    planned.click("#fold")
    assert planned.locator("#board").bounding_box() == high
    planned.set_viewport_size({"width": 1000, "height": 750})
    planned.wait_for_timeout(100)
    assert planned.evaluate(where) == pytest.approx(before)


def test_a_mark_of_a_conflict_says_its_sentence(planned: Page) -> None:
    planned.evaluate(
        """async () => {
          const { scene } = await window.studio.link.ask("ready", { name: "crossing-30" }).promise;
          window.studio.history.replaceAll({ scene });
        }"""
    )
    wait_for(planned, f"{FRESH} && {STATE}.answer.conflicts.length > 0", 60_000)
    pixel = planned.evaluate(
        """async () => {
          const { toScreen } = await import("studio/camera.js");
          const { board, store } = window.studio;
          const { left, top } = board.canvas.getBoundingClientRect();
          const [x, y] = toScreen(board.window(), store.get().answer.conflicts.at(-1).place);
          return [left + x, top + y];
        }"""
    )
    planned.mouse.move(*pixel)
    assert state(planned, "encounter")["sentence"] == state(planned, "answer")["conflicts"][-1]["sentence"]
    planned.mouse.move(2, 2)
    assert state(planned, "encounter") is None
