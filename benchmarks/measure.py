"""What all benchmarks share: medians of repeated runs, tables, and a description of the machine."""

from __future__ import annotations

import os
import platform
import statistics
import time
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from importlib.metadata import version
from typing import TypeVar

T = TypeVar("T")

LIBRARIES = ("taut", "numpy", "numba", "scipy", "shapely")


@dataclass(frozen=True)
class Table:
    """A titled table with a sentence or two before and notes after it; the first column is text, the rest numbers."""

    title: str
    heads: tuple[str, ...]
    rows: tuple[tuple[str, ...], ...]
    before: str = ""
    notes: tuple[str, ...] = ()

    def __str__(self) -> str:
        """Return the table as aligned Markdown."""
        widths = [max(len(row[k]) for row in (self.heads, *self.rows)) for k in range(len(self.heads))]
        rule = [":" + "-" * (widths[0] - 1), *("-" * (w - 1) + ":" for w in widths[1:])]
        grid = "\n".join(_line(row, widths) for row in (self.heads, rule, *self.rows))
        parts = [f"## {self.title}", self.before, grid, "\n".join(f"- {note}" for note in self.notes)]
        return "\n\n".join(part for part in parts if part)


def clocked(work: Callable[[], object]) -> float:
    """Wall time of one run, seconds."""
    began = time.perf_counter()
    work()
    return time.perf_counter() - began


def median_time(work: Callable[[], object], most: int = 7, budget: float = 3.0) -> float:
    """Median wall time in seconds of at most ``most`` runs; no new run begins after ``budget`` seconds."""
    return statistics.median(repeated(work, clocked, most, budget))


def repeated(
    work: Callable[[], object], measure: Callable[[Callable[[], object]], T], most: int, budget: float
) -> list[T]:
    """Measure ``work`` at least once and at most ``most`` times; no new run begins after ``budget`` seconds."""
    until = time.perf_counter() + budget
    out = [measure(work)]
    while len(out) < most and time.perf_counter() < until:
        out.append(measure(work))
    return out


def in_words(seconds: float) -> str:
    """Three digits with a unit: 1.23 s, 45.6 ms, 789 µs."""
    # from 0.9995 of a unit on, three digits say 1.00 of it
    unit, size = next((u, s) for u, s in (("s", 1.0), ("ms", 1e-3), ("µs", 0.0)) if seconds >= 0.9995 * s)
    value = seconds / (size or 1e-6)
    return f"{value:.{max(0, 2 - len(str(int(value))) + 1)}f} {unit}"


def machine() -> str:
    """Processor cores, system and versions, in one sentence."""
    cores = len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count()
    libraries = ", ".join(f"{name} {version(name)}" for name in LIBRARIES)
    return (
        f"{cores} cores ({platform.machine()}, {platform.system()}), Python {platform.python_version()}, {libraries}."
    )


def _line(cells: Sequence[str], widths: Sequence[int]) -> str:
    first, *rest = (
        cell.ljust(w) if k == 0 else cell.rjust(w) for k, (cell, w) in enumerate(zip(cells, widths, strict=True))
    )
    return f"| {' | '.join([first, *rest])} |"
