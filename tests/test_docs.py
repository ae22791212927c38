"""The examples of the README and the documentation run, and what they link to is there."""

from __future__ import annotations

import importlib.util
import re
import shlex
from dataclasses import dataclass
from pathlib import Path
from types import ModuleType

import pytest

import taut
from taut.cli import main

ROOT = Path(__file__).resolve().parents[1]
PAGES = sorted([ROOT / "README.md", *(ROOT / "docs").glob("*.md")])
WITH_COMMANDS = {
    "README.md",
    "start.md",
    "files.md",
    "graphs.md",
    "mrppa.md",
    "roadmaps.md",
    "chapter5.md",
    "teams.md",
    "simulation.md",
    "contact.md",
}
WITH_PYTHON = WITH_COMMANDS | {"meanings.md", "thesis.md", "paths.md"}


@dataclass(frozen=True)
class Block:
    """A fenced block: its language, the file name after it, its text and its first line in the page."""

    language: str
    name: str
    text: str
    line: int


def blocks(page: Path) -> list[Block]:
    """Return the fenced blocks of a page, in order."""
    text = page.read_text(encoding="utf-8")
    found = re.finditer(r"^```(\w+)[ ]*(\S*)\n(.*?)^```$", text, re.MULTILINE | re.DOTALL)
    return [Block(m[1], m[2], m[3], text.count("\n", 0, m.start(3)) + 1) for m in found]


@pytest.mark.parametrize("page", PAGES, ids=lambda page: page.name)
def test_the_examples_run(
    page: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.chdir(tmp_path)
    names: dict[str, object] = {"__name__": "example"}
    commands = scripts = 0
    for block in blocks(page):
        if block.name:
            (tmp_path / block.name).write_text(block.text, encoding="utf-8")
        elif block.language == "python":
            # The empty lines make errors name the line of the page.
            exec(compile("\n" * (block.line - 1) + block.text, str(page), "exec"), names)
            scripts += 1
        elif block.language == "sh":
            for line in block.text.splitlines():
                if line.startswith("taut "):
                    code = main(shlex.split(line, comments=True)[1:])
                    assert code == 0, f"{page.name}: {line}: {capsys.readouterr().err}"
                    commands += 1
    assert (commands > 0) == (page.name in WITH_COMMANDS)
    assert (scripts > 0) == (page.name in WITH_PYTHON)


@pytest.mark.parametrize("page", PAGES, ids=lambda page: page.name)
def test_links_lead_somewhere(page: Path) -> None:
    for target in re.findall(r"\]\(([^)#:\s]+)(?:#[^)]*)?\)", page.read_text(encoding="utf-8")):
        assert (page.parent / target).exists(), f"{page.name} links to {target}"


def test_every_page_is_reached_from_the_readme() -> None:
    text = (ROOT / "README.md").read_text(encoding="utf-8")
    for page in (ROOT / "docs").glob("*.md"):
        assert f"(docs/{page.name})" in text


def maker(name: str) -> ModuleType:
    """Return the script of the folder docs that makes a page."""
    place = importlib.util.spec_from_file_location(name, ROOT / "docs" / f"{name}.py")
    assert place is not None
    assert place.loader is not None
    module = importlib.util.module_from_spec(place)
    place.loader.exec_module(module)
    return module


def test_the_page_on_mrppa_tells_what_planning_tells_now() -> None:
    made = maker("make_mrppa")
    results = {name: taut.plan(taut.load_scene(name), method="mrppa") for name in made.SCENES}
    assert made.page(results) == (ROOT / "docs" / "mrppa.md").read_text(encoding="utf-8")


def test_the_page_on_chapter_5_tells_what_the_planners_find_now(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.syspath_prepend(ROOT / "docs")
    made = maker("make_chapter5")
    assert made.page(made.chapter()) == (ROOT / "docs" / "chapter5.md").read_text(encoding="utf-8")


def test_every_command_is_documented() -> None:
    from taut.cli.application import app

    text = "".join(page.read_text(encoding="utf-8") for page in PAGES)
    for command in app.registered_commands:
        assert f"taut {command.name}" in text
