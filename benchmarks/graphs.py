"""λ2 of large maps, and the best edge among many candidates: time, memory, and networkx beside it."""

from __future__ import annotations

import subprocess
import sys
import tempfile
import time
from functools import partial
from pathlib import Path

import numpy as np

from measure import Table, in_words, median_time
from scattered import scattered_scene
from taut.freespace import FreeSpace
from taut.graph import Graph, algebraic_connectivity, best_edges, connectivity_with, eigenpairs, fiedler_vector
from taut.roadmap import visibility_graph

SIZES = (300, 1000, 3000, 12500)  # the last has about 80,000 edges
SEED = 1
LONGEST = 60.0


def suite(quick: bool) -> tuple[Table, Table]:
    """Return the table of λ2 and that of candidates."""
    return _spectra(SIZES[:2] if quick else SIZES), _candidates()


def _spectra(sizes: tuple[int, ...]) -> Table:
    rows = []
    expected = 0.0
    for n in sizes:
        graph = unweighted(n)
        value = algebraic_connectivity(graph)
        ours, vector = (median_time(partial(work, graph)) for work in (algebraic_connectivity, fiedler_vector))
        theirs, agrees = "–", "left out (over 60 s expected)"
        if expected < LONGEST:
            taken, other = _networkx(graph)
            theirs = f"{in_words(taken)} ({taken / ours:,.0f}×)"
            agrees = f"{abs(other - value):.1e}"
            expected = taken * 20
        ours_in_words = (in_words(ours), in_words(vector), _memory(graph))
        rows.append((f"{graph.n:,}", f"{graph.m:,}", f"{value:.6f}", *ours_in_words, theirs, agrees))
    return Table(
        "λ2 of maps",
        ("vertices", "edges", "λ2", "λ2 in", "Fiedler vector in", "memory", "networkx in", "differs by"),
        tuple(rows),
        "Tangent graphs of the scattered polygons above, weight 1; one BLAS thread.",
        (
            "memory: by how much computing λ2 raises the peak of a process that holds the graph.",
            "networkx: `algebraic_connectivity` with its default tolerance of 1e-8 (and all that it needs to convert).",
        ),
    )


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
        "Which edge raises λ2 most",
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


def _memory(graph: Graph) -> str:
    """Growth of a fresh process while it computes λ2, in words."""
    if not Path("/proc/self/status").exists():
        return "–"
    with tempfile.TemporaryDirectory(prefix="taut-bench-") as folder:
        path = Path(folder) / "graph.npz"
        np.savez(path, indptr=graph.indptr, indices=graph.indices, weights=graph.weights)
        code = f"import graphs; graphs.print_growth({str(path)!r})"
        here = Path(__file__).resolve().parent
        out = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True, cwd=here)
    return f"{float(out.stdout) / 1e6:.0f} MB"


def print_growth(path: str) -> None:
    """Print by how many bytes computing λ2 of a stored graph raises the peak of this process."""
    with np.load(path) as stored:
        graph = Graph(stored["indptr"], stored["indices"], stored["weights"])
    algebraic_connectivity(Graph.from_edges(1500, np.stack([np.arange(1499), np.arange(1, 1500)], axis=1)))
    before = _peak()
    algebraic_connectivity(graph)
    print(_peak() - before)


def _peak() -> int:
    """Most bytes this process has held, as Linux tells it (what `resource` tells counts the parent's, too)."""
    lines = Path("/proc/self/status").read_text(encoding="ascii").splitlines()
    return 1024 * next(int(line.split()[1]) for line in lines if line.startswith("VmHWM"))


if __name__ == "__main__":
    for table in suite("--quick" in sys.argv):
        print(f"{table}\n")
