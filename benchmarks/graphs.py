"""λ2 of large maps, and the best edge among many candidates: time, memory, and networkx beside it."""

from __future__ import annotations

import sys
import tempfile
import time
from dataclasses import dataclass
from functools import partial
from pathlib import Path

import numpy as np

from measure import (
    LEFT_OUT,
    Report,
    Table,
    growth_in_fresh_process,
    in_megabytes,
    in_words,
    median_time,
    peak,
    picture,
)
from scattered import scattered_scene
from taut.freespace import FreeSpace
from taut.graph import Graph, algebraic_connectivity, best_edges, connectivity_with, eigenpairs, fiedler_vector
from taut.roadmap import visibility_graph

SIZES = (300, 1000, 3000, 12500)  # the last has about 80,000 edges
SEED = 1
LONGEST = 60.0
TITLES = ("λ2 of maps", "Which edge raises λ2 most")


@dataclass(frozen=True)
class Connectivity:
    """One map: λ2, seconds for it and for its vector, bytes, and seconds of networkx with what it differs by.

    Parameters
    ----------
    theirs, differs : None where networkx was left out.
    """

    vertices: int
    edges: int
    value: float
    ours: float
    vector: float
    memory: int | None
    theirs: float | None
    differs: float | None


def suite(quick: bool) -> Report:
    """Return the table of λ2 and that of candidates."""
    found = _measured(SIZES[:2] if quick else SIZES)
    return Report((_table(found), _candidates()), partial(_draw, found=found))


def _measured(sizes: tuple[int, ...]) -> tuple[Connectivity, ...]:
    out = []
    expected = 0.0
    for n in sizes:
        graph = unweighted(n)
        value = algebraic_connectivity(graph)
        ours, vector = (median_time(partial(work, graph)) for work in (algebraic_connectivity, fiedler_vector))
        theirs, differs = None, None
        if expected < LONGEST:
            theirs, other = _networkx(graph)
            differs = abs(other - value)
            expected = theirs * 20
        out.append(Connectivity(graph.n, graph.m, value, ours, vector, _memory(graph), theirs, differs))
        print(f"{graph.n:,} vertices: λ2 in {in_words(ours)}", flush=True)
    print(flush=True)
    return tuple(out)


def _table(found: tuple[Connectivity, ...]) -> Table:
    rows = []
    for c in found:
        theirs, agrees = LEFT_OUT, f"left out (over {LONGEST:g} s expected)"
        if c.theirs is not None:
            theirs, agrees = f"{in_words(c.theirs)} ({c.theirs / c.ours:,.0f}×)", f"{c.differs:.1e}"
        ours = (in_words(c.ours), in_words(c.vector), in_megabytes(c.memory))
        rows.append((f"{c.vertices:,}", f"{c.edges:,}", f"{c.value:.6f}", *ours, theirs, agrees))
    return Table(
        TITLES[0],
        ("vertices", "edges", "λ2", "λ2 in", "Fiedler vector in", "memory", "networkx in", "differs by"),
        tuple(rows),
        "Tangent graphs of the scattered polygons above, weight 1; one BLAS thread.",
        (
            "memory: by how much computing λ2 raises the peak of a process that holds the graph.",
            "networkx: `algebraic_connectivity` with its default tolerance of 1e-8 (and all that it needs to convert).",
        ),
        f"![Time to compute λ2 by number of edges](figures/{picture('graphs')})",
    )


def _draw(path: Path, found: tuple[Connectivity, ...]) -> None:
    from matplotlib.backends.backend_agg import FigureCanvasAgg
    from matplotlib.figure import Figure

    figure = Figure(figsize=(6, 4), layout="constrained")
    FigureCanvasAgg(figure)
    ax = figure.subplots()
    theirs = [(c.edges, c.theirs) for c in found if c.theirs is not None]
    if theirs:
        ax.plot(*zip(*theirs, strict=True), "s--", color="#d55e00", label="networkx")
    ax.plot([c.edges for c in found], [c.ours for c in found], "o-", color="#000000", linewidth=2.2, label="taut")
    ax.set(xscale="log", yscale="log", xlabel="edges", ylabel="seconds", title="λ2 of tangent graphs")
    ax.grid(alpha=0.3)
    ax.legend(loc="upper left", fontsize=8, frameon=False)
    figure.savefig(path, dpi=150, metadata={"Software": None})


def _candidates() -> Table:
    graph = unweighted(400)
    rng = np.random.default_rng(SEED)
    pairs = np.stack(np.triu_indices(graph.n, 1), axis=1)
    chosen = pairs[np.sort(rng.permutation(len(pairs))[:10_000])]
    connectivity_with(graph, chosen)
    whole = median_time(lambda: connectivity_with(graph, chosen))
    alone = median_time(lambda: eigenpairs(graph))
    best = median_time(lambda: best_edges(graph, chosen))
    few = chosen[:: len(chosen) // 20]
    anew = median_time(lambda: [_anew(graph, u, v) for u, v in few.tolist()]) / len(few) * len(chosen)
    row = (f"{graph.n:,}", f"{graph.m:,}", f"{len(chosen):,}", *map(in_words, (whole, alone, best, anew)))
    return Table(
        TITLES[1],
        ("vertices", "edges", "candidates", "all valued in", "of that, eigenpairs", "best edge in", "each anew"),
        (row,),
        "Every candidate valued exactly, by the secular equation of a rank-one update.",
        ("each anew: `algebraic_connectivity` of every changed graph, from 21 of them.",),
    )


def unweighted(n: int) -> Graph:
    """Return the tangent graph of about n scattered corners, weight 1."""
    tangents = visibility_graph(FreeSpace(scattered_scene(n, SEED)))
    return Graph.from_edges(tangents.graph.n, tangents.edges)


def _anew(graph: Graph, u: int, v: int) -> float:
    return algebraic_connectivity(Graph.from_edges(graph.n, np.unique([*graph.edges.tolist(), [u, v]], axis=0)))


def _networkx(graph: Graph) -> tuple[float, float]:
    import networkx as nx

    other = nx.Graph(graph.edges.tolist())
    began = time.perf_counter()
    value = nx.algebraic_connectivity(other, tol=1e-8, seed=SEED)
    return time.perf_counter() - began, float(value)


def _memory(graph: Graph) -> int | None:
    """Bytes by which a fresh process grows while it computes λ2."""
    with tempfile.TemporaryDirectory(prefix="taut-bench-") as folder:
        path = Path(folder) / "graph.npz"
        np.savez(path, indptr=graph.indptr, indices=graph.indices, weights=graph.weights)
        return growth_in_fresh_process("graphs", str(path))


def print_growth(path: str) -> None:
    """Print by how many bytes computing λ2 of a stored graph raises the peak of this process."""
    with np.load(path) as stored:
        graph = Graph(stored["indptr"], stored["indices"], stored["weights"])
    algebraic_connectivity(Graph.from_edges(1500, np.stack([np.arange(1499), np.arange(1, 1500)], axis=1)))
    before = peak()
    algebraic_connectivity(graph)
    print(peak() - before)


if __name__ == "__main__":
    for table in suite("--quick" in sys.argv).tables:
        print(f"{table}\n")
