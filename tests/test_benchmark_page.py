"""The performance page: a suite renews its own sections and leaves those of the others."""

from __future__ import annotations

import sys
from pathlib import Path

import pytest

sys.path.insert(0, str(Path(__file__).resolve().parents[1] / "benchmarks"))

import page
import run
from measure import Report, Table, picture

SUITES = ("start", "paths", "teams")
TITLES = ("Start", "Building", "Real maps", "Plans")


def report(*titles: str, cell: str = "1 ms") -> Report:
    return Report(tuple(Table(title, ("what", "time"), (("all", cell),)) for title in titles))


@pytest.fixture
def whole(tmp_path: Path) -> Path:
    """Return a page that all suites have written on an old machine."""
    file = tmp_path / "performance.md"
    reports = {"start": report("Start"), "paths": report("Building", "Real maps"), "teams": report("Plans")}
    page.write(file, reports, "an old machine.", SUITES, TITLES)
    return file


def titles_of(file: Path) -> list[str]:
    return [title for title, _ in page.split(file.read_text(encoding="utf-8"))[1]]


def text_of(file: Path, title: str) -> str:
    return dict(page.split(file.read_text(encoding="utf-8"))[1])[title].strip()


def test_a_page_is_made_where_there_is_none(whole: Path) -> None:
    assert whole.read_text(encoding="utf-8").startswith("# Performance\n")
    assert titles_of(whole) == list(TITLES)


def test_a_suite_replaces_its_own_sections_and_no_others(whole: Path) -> None:
    before = {title: text_of(whole, title) for title in TITLES}
    page.write(whole, {"paths": report("Building", "Real maps", cell="2 ms")}, "a new one.", SUITES, TITLES)
    assert titles_of(whole) == list(TITLES)
    for title in ("Start", "Plans"):
        assert text_of(whole, title) == before[title]
    for title in ("Building", "Real maps"):
        assert text_of(whole, title) == before[title].replace("1 ms", "2 ms")


def test_a_section_that_the_suite_did_not_measure_this_time_stays(whole: Path) -> None:
    before = text_of(whole, "Real maps")
    page.write(whole, {"paths": report("Building", cell="2 ms")}, "a new one.", SUITES, TITLES)
    assert text_of(whole, "Real maps") == before
    assert "2 ms" in text_of(whole, "Building")


def test_a_section_written_by_hand_stays_behind_the_others(whole: Path) -> None:
    with whole.open("a", encoding="utf-8") as file:
        file.write("\n## Remarks\n\nNot measured: ## is no title here.\n")
    page.write(whole, {"start": report("Start", cell="2 ms")}, "a new one.", SUITES, TITLES)
    assert titles_of(whole) == [*TITLES, "Remarks"]
    assert text_of(whole, "Remarks") == "## Remarks\n\nNot measured: ## is no title here."


def test_a_new_section_gets_its_place_in_the_order(tmp_path: Path) -> None:
    file = tmp_path / "performance.md"
    page.write(file, {"teams": report("Plans")}, "a machine.", SUITES, TITLES)
    page.write(file, {"start": report("Start")}, "a machine.", SUITES, TITLES)
    page.write(file, {"paths": report("Real maps", "Building")}, "a machine.", SUITES, TITLES)
    assert titles_of(file) == list(TITLES)


def test_the_head_tells_of_each_suite_on_what_it_was_measured(whole: Path) -> None:
    page.write(whole, {"paths": report("Building")}, "a new one.", SUITES, TITLES)
    head, _ = page.split(whole.read_text(encoding="utf-8"))
    lines = [line for line in head.splitlines() if line.startswith("- ")]
    assert lines == ["- start: an old machine.", "- paths: a new one.", "- teams: an old machine."]


def test_old_text_of_the_head_does_not_stay(whole: Path) -> None:
    old = whole.read_text(encoding="utf-8")
    whole.write_text(old.replace("# Performance\n", "# Performance\n\nStale.\n", 1), encoding="utf-8")
    page.write(whole, {"start": report("Start")}, "an old machine.", SUITES, TITLES)
    assert whole.read_text(encoding="utf-8") == old


def test_writing_the_same_again_changes_nothing(whole: Path) -> None:
    old = whole.read_bytes()
    page.write(whole, {"teams": report("Plans")}, "an old machine.", SUITES, TITLES)
    assert whole.read_bytes() == old


def test_every_section_of_the_published_page_is_that_of_a_suite_in_order() -> None:
    titles = [title for of_suite in run.SUITES.values() for title in of_suite]
    assert len(set(titles)) == len(titles)
    published = titles_of(Path(__file__).resolve().parents[1] / "docs" / "performance.md")
    assert published == [title for title in titles if title in published]


def test_pictures_are_drawn_where_the_page_looks_for_them(tmp_path: Path) -> None:
    table = Table("Plans", ("what",), (("all",),), picture=f"![Shares](figures/{picture('teams')})")

    def draw(path: Path) -> None:
        path.write_bytes(b"drawn")

    drawn = Report((table,), draw)
    page.write(tmp_path / "performance.md", {"teams": drawn}, "a machine.", SUITES, TITLES)
    assert "(figures/performance-teams.png)" in (tmp_path / "performance.md").read_text(encoding="utf-8")
    assert (tmp_path / "figures" / "performance-teams.png").read_bytes() == b"drawn"
