"""From a scene to its tangent graph: seconds of each phase, edges, memory."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

from measure import Table, growth_in_fresh_process, in_megabytes, in_words, median_time, one_thread, peak, picture
from scattered import scattered_scene
from taut.freespace import FreeSpace
from taut.geometry.growth import free_region
from taut.geometry.triangulation import triangulate
from taut.roadmap import VisibilityGraph, visibility_graph
from taut.scene import Scene

SEED = 1
TITLE = "Tangent graphs of scattered polygons"


@dataclass(frozen=True)
class Build:
    """One map: what was built, and the median seconds of each phase and of all together.

    Parameters
    ----------
    corners : of the obstacles, in all.
    together : from the Scene to its tangent graph, measured by itself.
    alone : the same on one thread.
    memory : bytes by which the peak of a fresh process grows; None where it was not measured.
    """

    corners: int
    obstacles: int
    edges: int
    region: float
    mesh: float
    tangents: float
    together: float
    alone: float
    memory: int | None = None


def built(scene: Scene, freespace: FreeSpace, corners: int, edges: int, memory: int | None = None) -> Build:
    """Measure every phase of building the tangent graph of ``freespace``, which has so many corners and edges."""

    def whole() -> VisibilityGraph:
        return visibility_graph(FreeSpace(scene))

    region = _timed(lambda: free_region(scene, 0.0))
    mesh = _timed(lambda: triangulate(freespace.region, scene.tol))
    tangents = _timed(lambda: visibility_graph(freespace))
    together = _timed(whole)
    with one_thread():
        alone = _timed(whole)
    return Build(corners, len(scene.obstacles), edges, region, mesh, tangents, together, alone, memory)


def memory(corners: int) -> int | None:
    """Bytes by which building the scattered scene of so many corners raises the peak of a fresh process."""
    return growth_in_fresh_process("building", str(corners))


def print_growth(corners: str) -> None:
    """Print by how many bytes building raises the peak of this process, the kernels being loaded."""
    visibility_graph(FreeSpace(scattered_scene(30, SEED)))
    scene = scattered_scene(int(corners), SEED)
    before = peak()
    kept = visibility_graph(FreeSpace(scene))
    print(peak() - before if kept.graph.n else 0)


def table(builds: tuple[Build, ...]) -> Table:
    """Return one row a size."""
    return Table(
        TITLE,
        (
            "corners",
            "obstacles",
            "edges",
            "free space",
            "triangulation",
            "tangent graph",
            "together",
            "on one thread",
            "memory",
            "bytes an edge",
        ),
        tuple(
            (
                f"{b.corners:,}",
                f"{b.obstacles:,}",
                f"{b.edges:,}",
                *map(in_words, (b.region, b.mesh, b.tangents, b.together, b.alone)),
                in_megabytes(b.memory),
                "–" if b.memory is None else f"{b.memory / b.edges:,.0f}",
            )
            for b in builds
        ),
        "Random disjoint convex polygons in a hall of 100 m × 100 m that touch nothing and do not grow; from a Scene "
        "in memory; warm, medians.",
        (
            "together: measured by itself, so it need not be the sum. On one thread: the same.",
            "memory: by how much all of it raises the peak of a fresh process whose kernels are loaded and which holds "
            "the scene; below a few megabytes room that was free before hides part of it.",
        ),
        f"![Time to build, time of a query, and memory by number of corners](figures/{picture('paths')})",
    )


def in_short(b: Build) -> str:
    """Say in one line what was measured, to be printed at once."""
    return (
        f"{b.corners:,} corners: built in {in_words(b.together)} ({in_words(b.alone)} on one thread), "
        f"{b.edges:,} edges, {in_megabytes(b.memory)}"
    )


def _timed(work: Callable[[], object]) -> float:
    return median_time(work, most=25, budget=2.0)
