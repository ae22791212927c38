"""From a scene to its tangent graph, and queries on it: per phase and size, and against other libraries."""

from __future__ import annotations

import time
from dataclasses import dataclass

from measure import Table, in_words, median_time
from peers import PEERS, Peer
from scattered import SIDE, free_places, scattered_scene
from taut.freespace import FreeSpace
from taut.geometry.growth import free_region
from taut.geometry.triangulation import triangulate
from taut.roadmap import VisibilityGraph, visibility_graph
from taut.route import shortest_routes
from taut.scene import FloatArray, Scene

SIZES = (300, 1000, 3000, 10000)
SEED = 1
PAIRS = 100


@dataclass(frozen=True)
class Build:
    """One size: what was built and the median seconds of each phase; queries in seconds each.

    Parameters
    ----------
    query : all pairs in one call, divided by their number.
    single : one pair in one call, mean.
    """

    n: int
    obstacles: int
    edges: int
    region: float
    mesh: float
    tangents: float
    query: float
    single: float

    @property
    def total(self) -> float:
        """Seconds from the scene to its tangent graph."""
        return self.region + self.mesh + self.tangents


@dataclass(frozen=True)
class Compared:
    """One other library at one size: seconds to prepare and for one query, and the lengths against ours.

    Parameters
    ----------
    build, query : None where it was left out.
    remark : "not installed", or why it was left out, or how its lengths compare.
    """

    peer: str
    n: int
    build: float | None
    query: float | None
    remark: str


@dataclass(frozen=True)
class Measured:
    """All that this suite measures."""

    builds: tuple[Build, ...]
    compared: tuple[Compared, ...]


def measured(quick: bool) -> Measured:
    """Build all sizes with taut, and those with the peers that do not take too long."""
    sizes = SIZES[:2] if quick else SIZES
    longest = 5.0 if quick else 60.0
    _warm_up()
    builds, compared = [], []
    latest: dict[str, Compared] = {}
    for n in sizes:
        scene = scattered_scene(n, SEED)
        freespace = FreeSpace(scene)
        tangents = visibility_graph(freespace)
        places = free_places(freespace, 2 * PAIRS, SEED)
        builds.append(_built(n, scene, freespace, tangents, places))
        for peer in PEERS:
            latest[peer.name] = _compared(peer, n, scene, freespace, tangents, places, latest.get(peer.name), longest)
            compared.append(latest[peer.name])
    return Measured(tuple(builds), tuple(compared))


def tables(found: Measured) -> tuple[Table, Table]:
    """Return the table of phases and the table of peers."""
    ours = {build.n: build for build in found.builds}
    phases = Table(
        "Visibility graphs and shortest routes",
        (
            "vertices",
            "obstacles",
            "edges",
            "free space",
            "triangulation",
            "tangent graph",
            "together",
            "query",
            "query alone",
        ),
        tuple(
            (
                f"{b.n:,}",
                f"{b.obstacles:,}",
                f"{b.edges:,}",
                *(in_words(t) for t in (b.region, b.mesh, b.tangents, b.total, b.query, b.single)),
            )
            for b in found.builds
        ),
        "Random disjoint convex polygons in a hall of 100 m × 100 m that touch nothing and do not grow; warm, medians.",
        (
            f"query: `shortest_routes` on the finished graph, mean over {PAIRS} random pairs given in one call.",
            "query alone: the same with one pair a call, which pays the fixed costs of a call each time.",
        ),
    )
    peers = Table(
        "Against other libraries",
        ("", "vertices", "build", "÷ taut", "query", "÷ taut", "lengths"),
        tuple(_peer_row(c, ours[c.n]) for c in found.compared),
        "The same scenes and the same pairs, one at a time; ÷ taut: how many times as long as taut (together, query "
        "alone).",
        (
            "shapely + networkx is the obvious program: every pair of vertices tested with `covers`, then Dijkstra.",
            "The others run on one core, extremitypathfinder with its Numba kernels and without checking the ends.",
            "The extra `bench` installs them, but extremitypathfinder asks for numpy below 2 (it runs with 2): "
            "`pip install --no-deps extremitypathfinder`.",
            "lengths: of the pairs both answered, how many agree to 1e-9 relative, and the worst deviations.",
        ),
    )
    return phases, peers


def _built(n: int, scene: Scene, freespace: FreeSpace, tangents: VisibilityGraph, places: FloatArray) -> Build:
    starts, goals = list(places[:PAIRS]), list(places[PAIRS:])
    few = PAIRS // 4

    def one_by_one() -> None:
        for a, b in zip(starts[:few], goals[:few], strict=True):
            shortest_routes(freespace, tangents, [a], [b])

    return Build(
        n,
        len(scene.obstacles),
        tangents.graph.m,
        median_time(lambda: free_region(scene, 0.0)),
        median_time(lambda: triangulate(freespace.region)),
        median_time(lambda: visibility_graph(freespace)),
        median_time(lambda: shortest_routes(freespace, tangents, starts, goals)) / PAIRS,
        median_time(one_by_one) / few,
    )


def _compared(
    peer: Peer,
    n: int,
    scene: Scene,
    freespace: FreeSpace,
    tangents: VisibilityGraph,
    places: FloatArray,
    before: Compared | None,
    longest: float,
) -> Compared:
    if peer.missing:
        return Compared(peer.name, n, None, None, f"not installed ({', '.join(peer.missing)})")
    if before is not None:
        # a guess from below: most grow faster than with the square
        expected = 0.0 if before.build is None else before.build * (n / before.n) ** 2
        if before.build is None or expected > longest:
            return Compared(peer.name, n, None, None, f"left out (over {longest:g} s expected)")
    began = time.perf_counter()
    query = peer.prepare(scene)
    build = time.perf_counter() - began
    until = time.perf_counter() + longest / 4
    lengths: list[float] = []
    began = time.perf_counter()
    for a, b in zip(places[:PAIRS], places[PAIRS:], strict=True):
        lengths.append(query((float(a[0]), float(a[1])), (float(b[0]), float(b[1]))))
        if time.perf_counter() > until:
            break
    each = (time.perf_counter() - began) / len(lengths)
    k = len(lengths)
    ours = [r.length for r in shortest_routes(freespace, tangents, list(places[:k]), list(places[PAIRS : PAIRS + k]))]
    return Compared(peer.name, n, build, each, _agreement(lengths, ours))


def _agreement(theirs: list[float], ours: list[float]) -> str:
    off = [t / o - 1.0 for t, o in zip(theirs, ours, strict=True)]
    equal = sum(abs(d) <= 1e-9 for d in off)
    said = f"{equal} of {len(off)} equal"
    if max(off) > 1e-9:
        said += f", up to {100 * max(off):.2g} % longer"
    if min(off) < -1e-9:
        said += f", up to {-100 * min(off):.2g} % shorter"
    return said


def _peer_row(c: Compared, ours: Build) -> tuple[str, ...]:
    if c.build is None or c.query is None:
        return c.peer, f"{c.n:,}", "–", "–", "–", "–", c.remark
    return (
        c.peer,
        f"{c.n:,}",
        in_words(c.build),
        f"{c.build / ours.total:,.0f}",
        in_words(c.query),
        f"{c.query / ours.single:,.0f}",
        c.remark,
    )


def _warm_up() -> None:
    """Compile, or load from the cache, every kernel that is timed, the peers' too."""
    scene = scattered_scene(30, SEED)
    freespace = FreeSpace(scene)
    places = list(free_places(freespace, 40, SEED))
    shortest_routes(freespace, visibility_graph(freespace), places[:20], places[20:])
    for peer in PEERS:
        if not peer.missing:
            peer.prepare(scene)((1.0, 1.0), (SIDE - 1.0, SIDE - 1.0))
