"""Other libraries on the same maps and pairs: how many times as long they take, and whether their lengths agree."""

from __future__ import annotations

import math
import time
from dataclasses import dataclass

import numpy as np

from building import Build
from measure import LEFT_OUT, Table, in_words
from peers import PEERS, Peer
from scattered import SIDE, scattered_scene
from taut.freespace import FreeSpace
from taut.route import distances, prepare
from taut.scene import FloatArray, Scene

SEED = 1
PAIRS = 100
EQUAL = 1e-9  # relative
TITLE = "Against other libraries"


@dataclass(frozen=True)
class Compared:
    """One library on one map: seconds to prepare and for a query, ratios to taut's, and how lengths compare.

    Parameters
    ----------
    build, query : None where it was left out; query also where no pair was answered.
    builds, singles, batches : the other's time in times of taut: building, one pair a call, pairs in a batch.
    remark : "not installed", or why it was left out, or how its lengths compare.
    """

    peer: str
    corners: int
    build: float | None
    query: float | None
    builds: float
    singles: float
    batches: float
    remark: str


def compared(
    scene: Scene,
    freespace: FreeSpace,
    places: FloatArray,
    build: Build,
    single: float,
    batch: float,
    before: tuple[Compared, ...],
    longest: float,
) -> tuple[Compared, ...]:
    """Measure every library expected to build within ``longest`` seconds, judged by ``before``, on smaller maps.

    ``single`` and ``batch`` are taut's seconds for a pair: one a call, and in a batch.
    """
    starts, goals = np.split(places, 2)
    starts, goals = starts[:PAIRS], goals[:PAIRS]
    ours = distances(prepare(freespace), starts, goals)
    out = []
    for peer in PEERS:
        reason = _reason_to_leave_out(peer, build.corners, before, longest)
        if reason:
            out.append(Compared(peer.name, build.corners, None, None, math.nan, math.nan, math.nan, reason))
            continue
        began = time.perf_counter()
        query = peer.prepare(scene)
        taken = time.perf_counter() - began
        until = time.perf_counter() + longest / 4
        lengths: list[float] = []
        began = time.perf_counter()
        for a, b in zip(starts.tolist(), goals.tolist(), strict=True):
            try:
                lengths.append(query((a[0], a[1]), (b[0], b[1])))
            except Exception:
                # whatever a library raises, the pair has no answer; the remark counts it
                lengths.append(math.nan)
            if time.perf_counter() > until:
                break
        each = (time.perf_counter() - began) / len(lengths)
        ratios = taken / build.together, each / single, each / batch
        remark = agreement(np.array(lengths), ours[: len(lengths)])
        out.append(Compared(peer.name, build.corners, taken, each, *ratios, remark))
    return tuple(out)


def agreement(theirs: FloatArray, ours: FloatArray) -> str:
    """Say how many lengths agree, the worst deviation, and how many pairs the other could not answer."""
    answered = np.isfinite(theirs)
    off = theirs[answered] / ours[answered] - 1
    if not len(off):
        return f"none of {len(theirs)} answered"
    said = f"{np.count_nonzero(np.abs(off) <= EQUAL)} of {len(theirs)} equal, worst {np.abs(off).max():.1e}"
    for word, worst in (("longer", off.max()), ("shorter", -off.min())):
        if worst > EQUAL:
            said += f", up to {100 * worst:.2g} % {word}"
    failed = np.count_nonzero(~answered)
    return f"{said}, {failed} not answered" if failed else said


def table(found: tuple[Compared, ...]) -> Table:
    """Return one row for each library and size."""
    return Table(
        TITLE,
        ("", "corners", "build", "÷ taut", "query", "÷ one a call", "÷ batch", "lengths"),
        tuple(_row(c) for c in found),
        "The same maps and pairs, one at a time; ÷ taut: how many times as long as taut takes, for a query both with "
        "one pair a call (interval search, no graph) and in a batch (A* on the graph).",
        (
            "shapely + networkx is the obvious program: every pair of corners tested with `covers`, then Dijkstra.",
            "The others run on one core, extremitypathfinder with its Numba kernels and without checking the ends; "
            "taut builds and answers batches on all.",
            "The extra `bench` installs them, but extremitypathfinder asks for numpy below 2 (it runs with 2): "
            "`pip install --no-deps extremitypathfinder`.",
            f"lengths: how many agree with taut's to {EQUAL:g} relative, and the worst relative deviation.",
        ),
    )


def in_short(c: Compared) -> str:
    """Say in one line what was measured, to be printed at once."""
    if c.build is None:
        return f"{c.corners:,} corners: {c.peer} {c.remark}"
    return f"{c.corners:,} corners: {c.peer} built in {in_words(c.build)} ({c.builds:,.0f} × taut), {c.remark}"


def warm_up() -> None:
    """Compile, or load from the cache, the kernels of the others."""
    scene = scattered_scene(30, SEED)
    for peer in PEERS:
        if not peer.missing:
            peer.prepare(scene)((1.0, 1.0), (SIDE - 1.0, SIDE - 1.0))


def _reason_to_leave_out(peer: Peer, corners: int, before: tuple[Compared, ...], longest: float) -> str:
    if peer.missing:
        return f"not installed ({', '.join(peer.missing)})"
    own = [c for c in before if c.peer == peer.name]
    if not own:
        return ""
    # a guess from below: most grow faster than with the square
    latest = own[-1]
    if latest.build is None or latest.build * (corners / latest.corners) ** 2 > longest:
        return f"left out (over {longest:g} s expected)"
    return ""


def _row(c: Compared) -> tuple[str, ...]:
    if c.build is None or c.query is None:
        return c.peer, f"{c.corners:,}", *[LEFT_OUT] * 5, c.remark
    return (
        c.peer,
        f"{c.corners:,}",
        in_words(c.build),
        f"{c.builds:,.0f}",
        in_words(c.query),
        f"{c.singles:,.0f}",
        f"{c.batches:,.0f}",
        c.remark,
    )
