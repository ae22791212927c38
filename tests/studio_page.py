"""The studio in a real browser: a server as users start it, Chromium, and a page of it; fixtures for browser tests.

A test module says `pytest_plugins = ("studio_page",)` and takes the fixtures `page`, `browser` and `studio`. One
browser and one server serve a module; each test has a page of its own with nothing kept from others. The module may
name what the server is started with: `STUDIO_WORDS = ("thesis-2",)`.
"""

from __future__ import annotations

import contextlib
import os
import shutil
import signal
import subprocess
import sys
import time
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

import pytest

if TYPE_CHECKING:
    from playwright.sync_api import Browser, Page

WAIT = 30_000  # milliseconds for what takes no time on an idle machine
WARM = 300_000  # milliseconds until kernels are compiled, on a machine where they never were
_NAMES = ("chromium", "chromium-browser", "google-chrome", "google-chrome-stable", "chrome")


@dataclass(frozen=True)
class RunningStudio:
    """A server under test: its address with the token, and its process."""

    url: str
    process: subprocess.Popen[str]

    @property
    def origin(self) -> str:
        """Return the address without path and token."""
        return self.url.partition("/?")[0]


@contextlib.contextmanager
def running_studio(*words: str, folder: Path | None = None) -> Iterator[RunningStudio]:
    """Start `taut studio` with some words in a folder; end it as Ctrl-C does."""
    command = [sys.executable, "-m", "taut", "studio", *words, "--no-browser"]
    process = subprocess.Popen(command, stdout=subprocess.PIPE, text=True, cwd=folder)
    try:
        assert process.stdout is not None
        first = process.stdout.readline()
        assert first.startswith("studio: http"), f"the studio did not start: {first!r}"
        yield RunningStudio(first.split()[1], process)
    finally:
        if process.poll() is None:
            process.send_signal(signal.SIGINT)
        try:
            process.wait(20)
        except subprocess.TimeoutExpired:
            process.kill()
            raise


def chromium() -> str:
    """Return where Chromium is; skip the test where it is not, or where Playwright is not."""
    pytest.importorskip("playwright.sync_api", reason="browser tests need Playwright (pip install playwright)")
    found = next((path for name in _NAMES if (path := shutil.which(name))), None)
    if found is None:
        pytest.skip("browser tests need Chromium: install the package chromium, or put it into the PATH")
    return found


@pytest.fixture(scope="module")
def studio(request: pytest.FixtureRequest) -> Iterator[RunningStudio]:
    """Return a running server."""
    chromium()
    with running_studio(*getattr(request.module, "STUDIO_WORDS", ())) as running:
        yield running


@pytest.fixture(scope="module")
def browser() -> Iterator[Browser]:
    """Return Chromium without a window."""
    path = chromium()
    from playwright.sync_api import sync_playwright

    # Chromium's sandbox refuses to work for root, as in containers
    words = ["--no-sandbox"] if hasattr(os, "geteuid") and os.geteuid() == 0 else []
    with sync_playwright() as playwright:
        launched = playwright.chromium.launch(executable_path=path, args=words)
        yield launched
        launched.close()


@pytest.fixture
def page(browser: Browser, studio: RunningStudio) -> Iterator[Page]:
    """Return the studio's page when it can plan; errors in its console fail the test."""
    context = browser.new_context(viewport={"width": 1280, "height": 800}, accept_downloads=True)
    opened = context.new_page()
    opened.set_default_timeout(WAIT)
    errors: list[str] = []
    opened.on("pageerror", lambda error: errors.append(str(error)))
    opened.on("console", lambda said: errors.append(said.text) if said.type == "error" else None)
    opened.goto(studio.url)
    try:
        wait_until_ready(opened)
        yield opened
    finally:
        context.close()
        assert not errors, errors  # they are what a test that failed is about


def wait_until_ready(page: Page) -> None:
    """Wait until a page's server has warm workers."""
    wait_for(page, "window.studio?.store?.get().server?.state === 'ready'", WARM)


def wait_for(page: Page, expression: str, patience: float = WAIT) -> None:
    """Wait until an expression is true in the page; asked from outside, because the page may not evaluate texts."""
    end = time.monotonic() + patience / 1000
    while not page.evaluate(expression):
        assert time.monotonic() < end, f"this never came: {expression}"
        page.wait_for_timeout(20)
