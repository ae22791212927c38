"""What all benchmarks share: medians of repeated runs, memory, tables, and a description of the machine."""

from __future__ import annotations

import os
import platform
import statistics
import subprocess
import sys
import time
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from importlib.metadata import version
from pathlib import Path
from typing import TypeVar
from unittest import mock

T = TypeVar("T")

LIBRARIES = ("taut", "numpy", "numba", "scipy", "shapely")
LEFT_OUT = "–"
_STATUS = Path("/proc/self/status")


@dataclass(frozen=True)
class Table:
    """A titled table with a sentence or two before and notes after it; the first column is text, the rest numbers.

    Parameters
    ----------
    picture : Markdown of a picture to stand behind the sentences, see `picture`.
    """

    title: str
    heads: tuple[str, ...]
    rows: tuple[tuple[str, ...], ...]
    before: str = ""
    notes: tuple[str, ...] = ()
    picture: str = ""

    def __str__(self) -> str:
        """Return the table as aligned Markdown."""
        widths = [max(len(row[k]) for row in (self.heads, *self.rows)) for k in range(len(self.heads))]
        rule = [":" + "-" * (widths[0] - 1), *("-" * (w - 1) + ":" for w in widths[1:])]
        grid = "\n".join(_line(row, widths) for row in (self.heads, rule, *self.rows))
        parts = [f"## {self.title}", self.before, self.picture, grid, "\n".join(f"- {note}" for note in self.notes)]
        return "\n\n".join(part for part in parts if part)


@dataclass(frozen=True)
class Report:
    """What a suite has measured: its tables, and how to draw its picture into a file, if it has one."""

    tables: tuple[Table, ...]
    draw: Callable[[Path], None] | None = None


def picture(suite: str) -> str:
    """File name of a suite's picture, in the folder figures beside the page."""
    return f"performance-{suite}.png"


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


@contextmanager
def one_thread() -> Iterator[None]:
    """While open, taut works in the calling thread alone: it starts as many as Python says there are cores."""
    with mock.patch.object(os, "cpu_count", return_value=1):
        yield


def growth_in_fresh_process(module: str, word: str) -> int | None:
    """Bytes that ``print_growth(word)`` of a module of this folder tells in a fresh process; None if the system cannot.

    It is to print ``peak()`` after its work less ``peak()`` before.
    """
    if not _STATUS.exists():
        return None
    code = f"import {module}; {module}.print_growth({word!r})"
    here = Path(__file__).resolve().parent
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True, cwd=here)
    return int(done.stdout)


def peak() -> int:
    """Most bytes this process has held, as Linux tells it (what `resource` tells counts the parent's, too)."""
    lines = _STATUS.read_text(encoding="ascii").splitlines()
    return 1024 * next(int(line.split()[1]) for line in lines if line.startswith("VmHWM"))


def in_words(seconds: float) -> str:
    """Three digits with a unit: 1.23 s, 45.6 ms, 789 µs."""
    # from 0.9995 of a unit on, three digits say 1.00 of it
    unit, size = next((u, s) for u, s in (("s", 1.0), ("ms", 1e-3), ("µs", 0.0)) if seconds >= 0.9995 * s)
    value = seconds / (size or 1e-6)
    return f"{value:.{max(0, 2 - len(str(int(value))) + 1)}f} {unit}"


def in_megabytes(size: int | None) -> str:
    """Three digits: 0.123 MB, 45.6 MB, 1,234 MB; a dash for None."""
    if size is None:
        return LEFT_OUT
    megabytes = size / 1e6
    digits = max(0, 3 - len(str(int(megabytes)))) if megabytes >= 1 else 3
    return f"{megabytes:,.{digits}f} MB"


def machine() -> str:
    """Processor cores, system and versions, in one sentence."""
    cores = len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count()
    libraries = ", ".join(f"{name} {version(name)}" for name in LIBRARIES)
    return (
        f"{cores} cores ({platform.machine()}, {platform.system()}), Python {platform.python_version()}, {libraries}."
    )


def load() -> float:
    """How many processes ran or waited on average in the last minute; 0 where the system does not tell."""
    return os.getloadavg()[0] if hasattr(os, "getloadavg") else 0.0


def _line(cells: Sequence[str], widths: Sequence[int]) -> str:
    first, *rest = (
        cell.ljust(w) if k == 0 else cell.rjust(w) for k, (cell, w) in enumerate(zip(cells, widths, strict=True))
    )
    return f"| {' | '.join([first, *rest])} |"
