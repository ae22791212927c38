"""Measure taut and write docs/performance.md: ./dev bench, or python benchmarks/run.py [SUITE …] [--quick] …."""

from __future__ import annotations

import argparse
import sys
from pathlib import Path

import central
import graphs
import page
import paths
import simulate
import startup
import studio
import team
from measure import Report, load, machine

PAGE = Path(__file__).resolve().parents[1] / "docs" / "performance.md"
SUITES = {
    "start": startup.TITLES,
    "paths": paths.TITLES,
    "central": central.TITLES,
    "graphs": graphs.TITLES,
    "plans": team.TITLES,
    "simulate": simulate.TITLES,
    "studio": studio.TITLES,
}
"""The suites and the titles of their sections, in the order of the page."""

BUSY = 1.0  # load above which the page tells of it


def main() -> None:
    """Run the suites asked for, print their tables as they come, and write their sections of the page."""
    parser = argparse.ArgumentParser(description="Measure taut; print tables and write docs/performance.md.")
    parser.add_argument("suites", nargs="*", metavar="SUITE", help=f"{', '.join(SUITES)} (default: all)")
    parser.add_argument(
        "--quick", action="store_true", help="a small part, to try; writes no page unless --page is given"
    )
    parser.add_argument("--maps", type=Path, metavar="FOLDER", help="GeoJSON scenes that suite paths measures, too")
    parser.add_argument("--page", type=Path, metavar="FILE", help="write the page here; its pictures go to figures/")
    words = parser.parse_args()
    unknown = [name for name in words.suites if name not in SUITES]
    if unknown:
        parser.error(f"there is no suite {unknown[0]}; the suites are {', '.join(SUITES)}")
    if words.maps is not None and not words.maps.is_dir():
        parser.error(f"{words.maps} is not a folder")
    if hasattr(sys.stdout, "reconfigure"):
        # a pipe on Windows would refuse ÷ and µ
        sys.stdout.reconfigure(encoding="utf-8")
    where = machine()
    busy = load()
    if busy > BUSY:
        where += f" Other work was going on: load average {busy:.1f} at the beginning."
    print(f"{where}\n", flush=True)

    reports = {}
    for name in SUITES:
        if not words.suites or name in words.suites:
            print(f"suite {name}\n", flush=True)
            reports[name] = _report(name, words.quick, words.maps)
            print("\n\n".join(map(str, reports[name].tables)), "\n", flush=True)
    target = words.page or (None if words.quick else PAGE)
    if target is not None:
        titles = [title for of_suite in SUITES.values() for title in of_suite]
        measured = {name: report for name, report in reports.items() if report.tables}
        page.write(target, measured, where, tuple(SUITES), titles)
        print(f"wrote {target}")


def _report(name: str, quick: bool, maps: Path | None) -> Report:
    match name:
        case "start":
            return startup.suite(quick)
        case "paths":
            return paths.suite(quick, maps)
        case "central":
            return central.suite(quick)
        case "graphs":
            return graphs.suite(quick)
        case "simulate":
            return simulate.suite(quick)
        case "studio":
            return studio.suite(quick)
        case _:
            return team.suite(quick)


if __name__ == "__main__":
    main()
