"""The suite of the studio, measured in a browser: from mouse move to new plan, frames while it works, and its start.

It needs Chromium and Playwright; where they are missing it says so and has no table.
"""

from __future__ import annotations

import math
import statistics
import sys
import tempfile
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING

import pytest

from measure import Report, Table, in_words
from taut.formats import save
from taut.generate import random_scene

sys.path.insert(0, str(Path(__file__).resolve().parents[1] / "tests"))

from studio_page import chromium, running_studio, wait_for, wait_until_ready

if TYPE_CHECKING:
    from playwright.sync_api import Browser, Page

DRAG_TITLE = "Studio: from mouse move to the new plan on the screen"
FRAMES_TITLE = "Studio: frames"
START_TITLE = "Studio: start"
TITLES = (DRAG_TITLE, FRAMES_TITLE, START_TITLE)
"""Of the sections, in the order of the page."""

DRAGGED = {"thesis-1": (200, "–"), "thesis-2": (200, "100 ms"), "appendix-d": (200, "–")}
"""Scenes whose first robot's start is dragged: how many moves of the mouse, and what the median is to be below."""

LATE = 1000 / 30  # milliseconds: a frame that takes longer is not one of 30 a second
PACE = 1 / 60  # seconds between two moves of the mouse
RADIUS = 50  # pixels: the mouse goes in circles

# The time of a move is that of the browser's event; a plan is on the screen when the frame is done that follows it.
# A move whose plan was overtaken by a newer one ends when the newer one is there.
_WATCH_PLANS = """() => {
  const { store } = window.studio;
  const waiting = [];
  let moved = 0;
  window.delays = [];
  window.addEventListener("pointermove", ({ timeStamp }) => { moved = timeStamp; }, true);
  store.on(["revision"], ({ revision }) => waiting.push({ revision, moved }));
  store.on(["answer"], ({ answer }) => {
    if (!answer) return;
    const done = [];
    while (waiting.length && waiting[0].revision <= answer.revision) done.push(waiting.shift());
    requestAnimationFrame(() => {
      const channel = new MessageChannel();
      channel.port1.onmessage = () => window.delays.push(...done.map(({ moved }) => performance.now() - moved));
      channel.port2.postMessage(null);
    });
  });
}"""

_WATCH_FRAMES = """() => {
  window.frames_ = { gaps: [], working: 0 };
  let before = performance.now();
  const watch = (now) => {
    window.frames_.gaps.push(now - before);
    window.frames_.working += window.studio.store.get().planning.running;
    before = now;
    window.watching = requestAnimationFrame(watch);
  };
  window.watching = requestAnimationFrame(watch);
}"""

_SEEN_FRAMES = "() => { cancelAnimationFrame(window.watching); return window.frames_; }"

_CORNERS = """async () => {
  const { outlineOf } = await import("studio/scene.js");
  return window.studio.store.get().scene.obstacles.reduce((sum, obstacle) => sum + outlineOf(obstacle).length, 0);
}"""

_PLACE = """([x, y]) => {
  const { x: cx, y: cy, scale } = window.studio.camera.get();
  const box = document.getElementById("board").getBoundingClientRect();
  return [box.left + box.width / 2 + (x - cx) * scale, box.top + box.height / 2 + (cy - y) * scale];
}"""


def suite(quick: bool) -> Report:
    """Measure all tables."""
    try:
        path = chromium()
    except pytest.skip.Exception as missing:
        print(f"suite studio is left out: {missing}\n")
        return Report(())
    from playwright.sync_api import sync_playwright

    with sync_playwright() as playwright:
        browser = playwright.chromium.launch(executable_path=path, args=["--no-sandbox"])
        tables = drags(browser, quick), frames(browser, 2.0 if quick else 10.0), start(browser, 1 if quick else 5)
        browser.close()
    return Report(tables)


def drags(browser: Browser, quick: bool) -> Table:
    """Drag a robot's start in circles and take the time of every move."""
    rows = []
    for name, (moves, target) in DRAGGED.items():
        with opened(browser, name) as page:
            page.evaluate(_WATCH_PLANS)
            x, y = page.evaluate(_PLACE, page.evaluate("window.studio.store.get().scene.robots[0].start"))
            page.mouse.move(x, y)
            page.mouse.down()
            for k in range(moves // 4 if quick else moves):
                _paced(page, *_circle(x, y, k))
            page.mouse.up()
            _fresh(page)
            page.wait_for_timeout(100)
            delays, own = sorted(page.evaluate("window.delays")), sorted(page.evaluate("window.studio.latencies"))
        rows.append((name, f"{len(delays):,}", *_quantiles(delays), f"{len(own):,}", *_quantiles(own)[:2], target))
    heads = ("scene", "moves", "median", "95 %", "longest", "planned", "median", "95 %", "median below")
    before = (
        "The mouse drags the start of the first robot, 60 moves a second. Each move that changed the scene counts from "
        "the browser's event to the end of the frame that draws the plan of the scene as it was then, or a newer one."
    )
    notes = (
        "planned: moves whose own scene was planned, the others were overtaken; behind it the times of these.",
        "median below: of all moves.",
    )
    return Table(DRAG_TITLE, heads, tuple(rows), before, notes)


def frames(browser: Browser, seconds: float) -> Table:
    """Watch the frames of the page while robots are dragged, plans improved, maps moved and plans played."""
    rows = []
    with opened(browser, "warehouse-50") as page:
        rows.append(_frames(page, "warehouse-50: a robot is dragged", seconds, _dragging(page)))
        page.keyboard.press("Control+z")  # it may have been let go in a shelf
        _fresh(page)
        page.evaluate("window.studio.store.set({ settings: { seconds: 60 } })")
        _fresh(page)
        page.evaluate("void window.studio.planner.improve()")
        rows.append(_frames(page, "warehouse-50: Improve runs, the map is moved", seconds, _panning(page)))
    with tempfile.TemporaryDirectory(prefix="taut-bench-") as folder:
        save(random_scene(robots=200, obstacles=1200, size=240, seed=1), Path(folder) / "large.yaml")
        with opened(browser, "large.yaml", folder=Path(folder)) as page:
            corners = page.evaluate(_CORNERS)
            large = f"{corners:,} corners, 200 robots"
            rows.append(_frames(page, f"{large}: the map is moved", seconds, _panning(page)))
            rows.append(_frames(page, f"{large}: zoom", seconds, _zooming(page)))
            page.click("#play")
            rows.append(_frames(page, f"{large}: playing", seconds, lambda _: page.wait_for_timeout(100)))
    heads = ("what goes on", "frames", "a second", "median", "95 %", "longest", "above 33 ms", "while planning")
    before = (
        f"Times between frames of a page of 1280 × 800 pixels during {seconds:g} s. The browser has no graphics card "
        "here and shares the processor with the planner."
    )
    notes = (
        "target: 30 frames a second.",
        "while planning: share of the frames during which a plan was under way.",
        "The large scene is `taut random --robots 200 --obstacles 1200 --size 240 --seed 1`.",
    )
    return Table(FRAMES_TITLE, heads, tuple(rows), before, notes)


def start(browser: Browser, runs: int) -> Table:
    """Time from the command to the page that can be drawn on, to warm workers, and to the first plan."""
    taken = [_start(browser) for _ in range(runs)]
    what = ("address printed", "page drawn and usable", "workers warm", "first plan on the screen")
    rows = tuple((words, in_words(statistics.median(run[k] for run in taken))) for k, words in enumerate(what))
    before = f"`taut studio thesis-2`, kernels compiled before; medians of {runs} runs, in the order they happen."
    return Table(START_TITLE, ("since the command", "time"), rows, before)


@contextmanager
def opened(browser: Browser, *words: str, folder: Path | None = None) -> Iterator[Page]:
    """Open the studio with some words, as soon as it has planned."""
    with running_studio(*words, folder=folder) as studio:
        context = browser.new_context(viewport={"width": 1280, "height": 800})
        page = context.new_page()
        page.goto(studio.url)
        wait_until_ready(page)
        _fresh(page)
        for seed in range(1, 9):  # the first plans of a worker are slower
            page.evaluate(f"window.studio.store.set({{settings: Object.freeze({{seed: {seed}}})}})")
            page.wait_for_timeout(150)
            _fresh(page)
        yield page
        context.close()


def _start(browser: Browser) -> tuple[float, float, float, float]:
    began = time.perf_counter()
    with running_studio("thesis-2") as studio:
        address = time.perf_counter() - began
        context = browser.new_context()
        page = context.new_page()
        page.goto(studio.url)
        wait_for(page, "(window.studio?.store.get().scene?.robots.length ?? 0) > 0")
        usable = time.perf_counter() - began
        wait_until_ready(page)
        warm = time.perf_counter() - began
        _fresh(page)
        planned = time.perf_counter() - began
        context.close()
    return address, usable, warm, planned


def _frames(page: Page, words: str, seconds: float, move: Callable[[int], object]) -> tuple[str, ...]:
    page.evaluate(_WATCH_FRAMES)
    began, k = time.perf_counter(), 0
    while time.perf_counter() - began < seconds:
        move(k)
        k += 1
    page.mouse.up()
    seen = page.evaluate(_SEEN_FRAMES)
    gaps = sorted(seen["gaps"][1:])
    late = sum(gap > LATE for gap in gaps) / len(gaps)
    return (
        words,
        f"{len(gaps):,}",
        f"{1000 * len(gaps) / sum(gaps):.1f}",
        *_quantiles(gaps),
        f"{late:.1%}",
        f"{seen['working'] / len(seen['gaps']):.0%}",
    )


def _dragging(page: Page) -> Callable[[int], object]:
    """The start of a robot in circles; now and then the hand rests, as it must for large scenes to be planned."""
    x, y = page.evaluate(_PLACE, page.evaluate("window.studio.store.get().scene.robots[0].start"))
    page.mouse.move(x, y)
    page.mouse.down()

    def move(k: int) -> None:
        _paced(page, *_circle(x, y, k))
        if k % 30 == 29:
            page.wait_for_timeout(200)

    return move


def _panning(page: Page) -> Callable[[int], object]:
    def move(k: int) -> None:
        page.mouse.wheel(12 * math.sin(k / 20), 12 * math.cos(k / 20))
        time.sleep(PACE)

    page.mouse.move(*page.evaluate(_PLACE, page.evaluate("(({ x, y }) => [x, y])(window.studio.camera.get())")))
    return move


def _zooming(page: Page) -> Callable[[int], object]:
    def move(k: int) -> None:
        page.evaluate("k => window.studio.commands.zoom(Math.sin(k / 15) > 0 ? 1.05 : 1 / 1.05)", k)
        time.sleep(PACE)

    return move


def _paced(page: Page, x: float, y: float) -> None:
    began = time.perf_counter()
    page.mouse.move(x, y)
    time.sleep(max(0.0, PACE - (time.perf_counter() - began)))


def _circle(x: float, y: float, k: int) -> tuple[float, float]:
    """Place of the mouse after k moves: it sets out from (x, y) and comes round there after 63."""
    return x + RADIUS * math.sin(k / 10), y + RADIUS * (math.cos(k / 10) - 1)


def _fresh(page: Page) -> None:
    """Wait until the plan on show is that of the scene."""
    wait_for(page, "window.studio.store.get().planning.state === 'fresh'", 120_000)


def _quantiles(times: list[float]) -> tuple[str, str, str]:
    """Median, 95 % and greatest of sorted milliseconds."""
    return tuple(f"{times[k]:.0f} ms" for k in (len(times) // 2, int(0.95 * (len(times) - 1)), -1))  # type: ignore[return-value]
