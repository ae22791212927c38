"""The page docs/performance.md: a head, then sections; a suite renews its own and leaves those of the others."""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence
from pathlib import Path

from measure import Report

HEAD = (
    "# Performance\n\n"
    "`./dev bench` measures these figures and writes this page; edit `benchmarks/`, not the page. "
    "`./dev bench SUITE …` measures some suites and leaves the sections of the others as they are. "
    "`python benchmarks/success.py` tells how many random teams are solved.\n\n"
    "Measured on, by suite:\n\n"
)

_MACHINE = re.compile(r"^- (\w+): (.+)$", re.MULTILINE)


def write(
    page: Path, reports: Mapping[str, Report], machine: str, suites: Sequence[str], titles: Sequence[str]
) -> None:
    """Write the sections and pictures of some suites into the page; pictures into the folder figures beside it.

    Parameters
    ----------
    reports : of the suites measured now.
    machine : on what they were measured.
    suites, titles : all there are, in the order of the page.
    """
    pictures = page.parent / "figures"
    pictures.mkdir(parents=True, exist_ok=True)
    for name, report in reports.items():
        if report.draw is not None:
            report.draw(pictures / f"performance-{name}.png")
    old = page.read_text(encoding="utf-8") if page.exists() else ""
    new = {table.title: str(table) for report in reports.values() for table in report.tables}
    page.write_text(renewed(old, new, dict.fromkeys(reports, machine), suites, titles), encoding="utf-8")


def renewed(
    old: str, sections: Mapping[str, str], machines: Mapping[str, str], suites: Sequence[str], titles: Sequence[str]
) -> str:
    """Return the page with some sections written anew, in the order of ``titles``; unknown ones follow as they were.

    Parameters
    ----------
    old : the page so far, or "".
    sections : new text by title, beginning with its line ``## title``.
    machines : by suite, where the new sections were measured; the head keeps what it said of the others.
    """
    head, kept = split(old)
    every = [(title, text) for title, text in kept if title not in sections] + list(sections.items())
    place = {title: k for k, title in enumerate(titles)}
    every.sort(key=lambda section: place.get(section[0], len(titles)))
    known = {**dict(_MACHINE.findall(head)), **machines}
    lines = [f"- {name}: {known[name]}" for name in suites if name in known]
    return "\n\n".join([HEAD + "\n".join(lines), *(text.strip() for _, text in every)]) + "\n"


def split(page: str) -> tuple[str, list[tuple[str, str]]]:
    """Return what stands before the first section, and the title and text of every section in turn."""
    head, *texts = re.split(r"^(?=## )", page, flags=re.MULTILINE)
    return head, [(text.partition("\n")[0].removeprefix("## ").strip(), text) for text in texts]
