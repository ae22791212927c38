"""Measure taut and write docs/performance.md: ./dev bench, or python benchmarks/run.py [--quick] [--page FILE]."""

from __future__ import annotations

import argparse
import sys
from pathlib import Path

import geometry
import graphs
import page
import startup
import team
from measure import machine

PAGE = Path(__file__).resolve().parents[1] / "docs" / "performance.md"


def main() -> None:
    """Run all suites, print their tables, and write the page."""
    parser = argparse.ArgumentParser(description="Measure taut; print tables and write docs/performance.md.")
    parser.add_argument(
        "--quick", action="store_true", help="a small part, to try; writes no page unless --page is given"
    )
    parser.add_argument("--page", type=Path, metavar="FILE", help="write the page here; its picture goes to figures/")
    words = parser.parse_args()
    if hasattr(sys.stdout, "reconfigure"):
        # a pipe on Windows would refuse ÷ and µ
        sys.stdout.reconfigure(encoding="utf-8")
    print(f"{machine()}\n", flush=True)

    start = startup.suite(words.quick)
    print(f"{start}\n", flush=True)
    found = geometry.measured(words.quick)
    phases, peers = geometry.tables(found)
    print(f"{phases}\n\n{peers}\n", flush=True)
    spectra, candidates = graphs.suite(words.quick)
    print(f"{spectra}\n\n{candidates}\n", flush=True)
    outcomes = team.measured(words.quick)
    plans = team.table(outcomes)
    print(f"{plans}\n", flush=True)

    target = words.page or (None if words.quick else PAGE)
    if target is not None:
        page.write(target, (start, phases, peers, spectra, candidates, plans), found, outcomes)
        print(f"wrote {target}")


if __name__ == "__main__":
    main()
