"""What it costs to begin: `import taut`, the first plan after installation, and a plan when everything is compiled."""

from __future__ import annotations

import json
import os
import statistics
import subprocess
import sys
import tempfile
from collections.abc import Callable
from dataclasses import dataclass

from measure import Report, Table, clocked, in_words

HEAVY = ("matplotlib", "numba", "llvmlite", "scipy", "shapely", "pydantic", "numpy")
SCENE = "thesis-2"
TITLES = ("Start",)

_PROBE = f"""
import json, sys, time
wall, cpu = time.perf_counter(), time.process_time()
import taut
wall, own = time.perf_counter() - wall, time.process_time() - cpu
loaded = [name for name in {HEAVY!r} if name in sys.modules]
print(json.dumps([wall, own, time.process_time(), loaded]))
"""


@dataclass(frozen=True)
class Import:
    """`import taut` in a fresh interpreter: seconds of wall time and CPU, CPU of the whole process, heavy modules."""

    wall: float
    cpu: float
    process_cpu: float
    loaded: tuple[str, ...]


@dataclass(frozen=True)
class Spent:
    """Seconds of wall time and of CPU; the CPU of child processes is 0 where the system does not tell it."""

    wall: float
    cpu: float


def importing(runs: int) -> Import:
    """Import taut in ``runs`` fresh interpreters; medians."""
    probes = [json.loads(_python("-c", _PROBE)) for _ in range(runs)]
    wall, cpu, whole = (statistics.median(probe[k] for probe in probes) for k in range(3))
    return Import(wall, cpu, whole, tuple(probes[0][3]))


def cold_and_warm(runs: int) -> tuple[Spent, Spent]:
    """What `taut plan` costs as a command with an empty kernel cache, then medians of ``runs`` with a full one."""
    with tempfile.TemporaryDirectory(prefix="taut-bench-") as cache:

        def plan() -> None:
            _python("-m", "taut", "plan", SCENE, cache=cache)

        cold = _spent(plan)
        warm = [_spent(plan) for _ in range(runs)]
    return cold, Spent(statistics.median(s.wall for s in warm), statistics.median(s.cpu for s in warm))


def suite(quick: bool) -> Report:
    """Measure everything of this page's first table."""
    runs = 3 if quick else 9
    found = importing(runs)
    cold, warm = cold_and_warm(runs)
    rows = (
        ("`import taut`", in_words(found.wall), in_words(found.cpu), "250 ms CPU"),
        ("interpreter and `import taut`", "–", in_words(found.process_cpu), "–"),
        ("first plan, nothing compiled yet", in_words(cold.wall), _cpu(cold), "30 s"),
        ("plan, kernels in the cache", in_words(warm.wall), _cpu(warm), "1.5 s"),
    )
    absent = [name for name in HEAVY if name not in found.loaded]
    start = Table(
        TITLES[0],
        ("", "wall time", "CPU", "target"),
        rows,
        f"Every figure is from fresh processes. The plans are the whole command `taut plan {SCENE}`, from process "
        "start to exit.",
        (
            f"Loaded by `import taut`: {_listed(found.loaded)}; not loaded: {_listed(absent)}. The "
            "public names load what they need when they are first used, so that is part of the plans.",
            f"Medians of {runs} runs; the first plan, with an empty kernel cache, is run once.",
        ),
    )
    return Report((start,))


def _spent(work: Callable[[], object]) -> Spent:
    before = os.times()
    wall = clocked(work)
    after = os.times()
    children = after.children_user + after.children_system - before.children_user - before.children_system
    return Spent(wall, children)


def _cpu(spent: Spent) -> str:
    return in_words(spent.cpu) if spent.cpu > 0 else "–"


def _python(*words: str, cache: str | None = None) -> str:
    environment = dict(os.environ) if cache is None else {**os.environ, "NUMBA_CACHE_DIR": cache}
    done = subprocess.run([sys.executable, *words], env=environment, capture_output=True, encoding="utf-8", check=False)
    if done.returncode:
        raise RuntimeError(f"python {words[0]} {words[1]} ended with {done.returncode}: {done.stderr.strip()}")
    return done.stdout


def _listed(names: tuple[str, ...] | list[str]) -> str:
    return ", ".join(names) or "nothing heavy"
