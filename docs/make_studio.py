"""Take the pictures of the page on the studio again: python docs/make_studio.py (needs Playwright and Chromium)."""

from __future__ import annotations

import sys
import tempfile
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING

import pytest

sys.path.insert(0, str(Path(__file__).resolve().parents[1] / "tests"))

from studio_page import chromium, running_studio, wait_for, wait_until_ready

if TYPE_CHECKING:
    from playwright.sync_api import Browser, Page

FIGURES = Path(__file__).resolve().parent / "figures"
SIZE = {"width": 1280, "height": 800}
STATE = "window.studio.store.get()"
FRESH = f"{STATE}.planning.state === 'fresh'"
COMPARED = """(() => {
  const cells = [...document.querySelectorAll(".measures tbody td")];
  return cells.length > 0 && cells.every(({ textContent }) => textContent !== "–");
})()"""
SHUT = """\
taut: 1
name: depot
bounds: [0, 0, 20, 12]
clearance: 0.1
gap: 0.1
obstacles:
  - {name: rack-1, rectangle: [3, 2.5, 1.2, 7]}
  - {name: wall-1, line: [[9, 0], [9, 5.4]], width: 0.3}
  - {name: wall-2, line: [[9, 6.2], [9, 12]], width: 0.3}
  - {name: rack-2, rectangle: [12, 1.5, 5, 1]}
  - {name: rack-3, rectangle: [12, 4.5, 5, 1]}
  - {name: rack-4, rectangle: [12, 7.5, 5, 1]}
robots:
  - {name: R1, start: [1.5, 2], goal: [18.5, 10], radius: 0.3}
  - {name: R2, start: [1.5, 10], goal: [7, 2], radius: 0.3}
"""


def main() -> None:
    """Drive the studio to each view and take its picture."""
    try:
        path = chromium()
    except pytest.skip.Exception as missing:
        print(f"the pictures of the studio stay as they are: {missing}")
        return
    from playwright.sync_api import sync_playwright

    with sync_playwright() as playwright, tempfile.TemporaryDirectory() as folder:
        browser = playwright.chromium.launch(executable_path=path, args=["--no-sandbox"])
        (Path(folder) / "depot.yaml").write_text(SHUT, encoding="utf-8")
        with opened(browser, "thesis-2") as page:
            page.get_by_role("tab", name="Plan").click()
            seek(page, 6.0)
            take(page, "studio")
            page.click("[data-mode=steps]")
            wait_for(page, f"{STATE}.steps.list !== null")
            page.get_by_role("button", name="Bridge for R1").click()
            take(page, "studio-steps")
            page.click("[data-mode=edit]")
        with opened(browser, "warehouse-50", dark=True) as page:
            page.get_by_role("tab", name="Plan").click()
            seek(page, 9.0)
            take(page, "studio-dark")
            page.click("[data-mode=compare]")
            wait_for(page, COMPARED, 120_000)
            seek(page, 9.0)
            take(page, "studio-compare")
        with opened(browser, "depot.yaml", folder=Path(folder), until=f"{STATE}.planning.state === 'failed'") as page:
            page.get_by_role("tab", name="Plan").click()
            take(page, "studio-why")
        browser.close()


@contextmanager
def opened(
    browser: Browser, *words: str, folder: Path | None = None, dark: bool = False, until: str = FRESH
) -> Iterator[Page]:
    """Open the studio with some words, and wait until something is true."""
    with running_studio(*words, folder=folder) as running:
        context = browser.new_context(viewport=SIZE, color_scheme="dark" if dark else "light")
        page = context.new_page()
        page.goto(running.url)
        wait_until_ready(page)
        wait_for(page, until)
        yield page
        context.close()


def seek(page: Page, seconds: float) -> None:
    """Show the team at a time."""
    page.evaluate("seconds => window.studio.player.seek(seconds)", seconds)


def take(page: Page, name: str) -> None:
    """Take a picture when nothing moves any more."""
    page.mouse.move(640, 20)
    page.wait_for_timeout(800)
    path = FIGURES / f"{name}.png"
    page.screenshot(path=path)
    print(path)


if __name__ == "__main__":
    main()
