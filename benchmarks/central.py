"""The suite of single paths on maps rich in obstacles: visibility graph, interval search, CA and OCA, near and far."""

from __future__ import annotations

import math
import statistics
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np

from measure import LEFT_OUT, Report, Table, clocked, in_words, picture
from scattered import SIDE, free_places, scattered_scene
from taut.errors import NoPath
from taut.freespace import FreeSpace
from taut.roadmap import VisibilityGraph, visibility_graph
from taut.route import shortest_path, shortest_routes
from taut.route.central import CentralRoute, central_path
from taut.route.obstacles import ObstacleIndex, index_obstacles
from taut.route.oca import oca_path
from taut.scene import FloatArray, Robot, Scene

SIZES = (100, 1000, 10_000, 100_000)
QUICK = (100, 1000)
SEED = 1
NEAR, FAR = 0.05, 0.6
PAIRS = {"near": 100, "far": 30}
SLOW = 5
"""How many questions are put to what is prepared anew for each."""
CLEARANCE = 0.05
TITLE = "One path on a map rich in obstacles: time"
FOUND_TITLE = "One path on a map rich in obstacles: what is looked at and found"
TITLES = (TITLE, FOUND_TITLE)

# Okabe and Ito's colours, safe for the colour-blind
WHOLE, DIRECT, OCA, CA = "#000000", "#56b4e9", "#d55e00", "#009e73"


@dataclass(frozen=True)
class Central:
    """One map, one clearance and one kind of pair; seconds are medians of one path.

    Parameters
    ----------
    corners, obstacles : of the map.
    clearance : metres, D_s.
    pairs : "near" or "far".
    whole : scene to visibility graph and the path in it, for one path.
    direct : scene to triangulation and interval search in it, for one path.
    index : of the obstacles, which OCA and CA need once.
    oca, slowest : one path by OCA, median and most.
    used, most_used : share of the obstacles that OCA takes in, mean and most.
    rounds, most_rounds : of OCA, median and most.
    differ : greatest relative difference between lengths by OCA and by the visibility graph.
    ca : one path by CA.
    free, hits, lost : shares of its questions that CA answers by a path that is free, by one that hits an obstacle, not
        at all.
    longer : length of free CA paths over the shortest, median; None without any.
    """

    corners: int
    obstacles: int
    clearance: float
    pairs: str
    whole: float
    direct: float
    index: float
    oca: float
    slowest: float
    used: float
    most_used: float
    rounds: float
    most_rounds: int
    differ: float
    ca: float
    free: float
    hits: float
    lost: float
    longer: float | None


def suite(quick: bool) -> Report:
    """Measure all maps; print what each gives at once."""
    _measured(scattered_scene(100, SEED), 100, 0.0)
    found: list[Central] = []
    for corners in QUICK if quick else SIZES:
        scene = scattered_scene(corners, SEED)
        for share in (0.0, CLEARANCE):
            found += _measured(scene, corners, share * _spacing(scene))
            print(*map(in_short, found[-len(PAIRS) :]), sep="\n", flush=True)
    print(flush=True)
    return Report((_times(found), _looks(found)), partial(draw, found=found))


def in_short(c: Central) -> str:
    """Say in one line what was measured, to be printed at once."""
    return (
        f"{_name(c)}: visibility graph {in_words(c.whole)}, interval search {in_words(c.direct)}, OCA "
        f"{in_words(c.oca)} with {100 * c.used:.1f} % of the obstacles, CA {in_words(c.ca)}, free {100 * c.free:.0f} %"
    )


def draw(path: Path, found: Sequence[Central]) -> None:
    """Draw time, share of the obstacles taken in, and what becomes of CA's paths, by the size of the map."""
    from matplotlib.backends.backend_agg import FigureCanvasAgg
    from matplotlib.figure import Figure

    figure = Figure(figsize=(13.5, 5), layout="constrained")
    FigureCanvasAgg(figure)
    left, middle, right = figure.subplots(1, 3)
    grown = [c for c in found if c.clearance > 0]
    near, far = ([c for c in grown if c.pairs == pairs] for pairs in ("near", "far"))
    _line(left, far, lambda c: c.whole, WHOLE, "visibility graph and path", "o-")
    _line(left, far, lambda c: c.direct, DIRECT, "triangulation and interval search", "o-")
    for ask, line in ((far, "o-"), (near, "s:")):
        _line(left, ask, lambda c: c.oca, OCA, f"OCA, {ask[0].pairs}", line)
        _line(left, ask, lambda c: c.ca, CA, f"CA, {ask[0].pairs}", line)
        # none at all has no place on a logarithmic scale
        _line(middle, [c for c in ask if c.used > 0], lambda c: 100 * c.used, OCA, f"{ask[0].pairs}, mean", line)
        _line(right, ask, lambda c: 100 * c.free, CA, f"{ask[0].pairs}", line)
    _finished(left, grown, "seconds", "One path with safety distance")
    left.set_yscale("log")
    _finished(middle, grown, "% of the obstacles", "Obstacles that OCA takes in")
    middle.set_yscale("log")
    _finished(right, grown, "% of the paths", "Paths of CA that are free")
    right.set_ylim(-3, 103)
    figure.savefig(path, dpi=150, metadata={"Software": None})


def _measured(scene: Scene, corners: int, clearance: float) -> list[Central]:
    """Near and far pairs on one map with one clearance."""
    freespace = FreeSpace(scene, clearance)
    graphs: list[VisibilityGraph] = []
    build = _least(lambda: graphs.append(visibility_graph(FreeSpace(scene, clearance))))
    triangulate = _least(lambda: FreeSpace(scene, clearance).mesh)
    return [_of_pairs(scene, freespace, graphs[-1], corners, kind, build, triangulate) for kind in PAIRS]


def _of_pairs(
    scene: Scene, freespace: FreeSpace, graph: VisibilityGraph, corners: int, kind: str, build: float, mesh: float
) -> Central:
    clearance = freespace.growth
    starts, goals = _pairs(freespace, kind)
    team = tuple(
        Robot(f"R{k}", tuple(a), tuple(b), clearance=clearance)
        for k, (a, b) in enumerate(zip(starts.tolist(), goals.tolist(), strict=True))
    )
    world = replace(scene, robots=team)
    assert world.tol == scene.tol  # worked out once, not within what is timed
    few = [(starts[k : k + 1], goals[k : k + 1]) for k in range(SLOW)]
    query = statistics.median(clocked(partial(shortest_routes, freespace, graph, a, b)) for a, b in few)
    direct = statistics.median(clocked(partial(shortest_path, freespace, a[0], b[0])) for a, b in few)
    lengths = [route.length for route in shortest_routes(freespace, graph, starts, goals)]
    index = index_obstacles(world)
    indexing = _least(lambda: index_obstacles(world))
    asked = [_timed(partial(oca_path, index, robot)) for robot in team]
    oca = [route for _, route in asked]
    assert all(route.optimal for route in oca)
    central = [_timed(partial(_central, index, robot, CLEARANCE * _spacing(scene))) for robot in team]
    free = [(k, route) for k, (_, route) in enumerate(central) if route is not None and route.free]
    used = [len(route.used) / len(scene.obstacles) for route in oca]
    lost = sum(route is None for _, route in central)
    return Central(
        corners=corners,
        obstacles=len(scene.obstacles),
        clearance=clearance,
        pairs=kind,
        whole=build + query,
        direct=mesh + direct,
        index=indexing,
        oca=statistics.median(seconds for seconds, _ in asked),
        slowest=max(seconds for seconds, _ in asked),
        used=statistics.fmean(used),
        most_used=max(used),
        rounds=statistics.median(len(route.rounds) for route in oca),
        most_rounds=max(len(route.rounds) for route in oca),
        differ=max(abs(route.length / length - 1) for route, length in zip(oca, lengths, strict=True)),
        ca=statistics.median(seconds for seconds, _ in central),
        free=len(free) / len(team),
        hits=1 - (len(free) + lost) / len(team),
        lost=lost / len(team),
        longer=statistics.median(route.length / lengths[k] for k, route in free) if free else None,
    )


def _pairs(freespace: FreeSpace, kind: str) -> tuple[FloatArray, FloatArray]:
    """Starts and goals, (k, 2) each, in free space: near ones 5 % of the width apart, far ones at least 60 %."""
    count = PAIRS[kind]
    rng = np.random.default_rng(SEED)
    starts, goals = np.empty((0, 2)), np.empty((0, 2))
    mesh = freespace.mesh
    seed = SEED
    while len(starts) < count:
        a, b = free_places(freespace, 4 * count, seed), free_places(freespace, 4 * count, seed + 1)
        seed += 2
        if kind == "near":
            turn = rng.uniform(0, 2 * math.pi, len(a))
            b = a + NEAR * SIDE * np.column_stack([np.cos(turn), np.sin(turn)])
            at, to = mesh.locate(a), mesh.locate(b)
            good = (to >= 0) & (mesh.parts[to] == mesh.parts[at])
        else:
            good = np.hypot(*(b - a).T) >= FAR * SIDE
        starts, goals = np.vstack([starts, a[good]]), np.vstack([goals, b[good]])
    return starts[:count], goals[:count]


def _spacing(scene: Scene) -> float:
    """Metres between obstacles, on the mean."""
    return SIDE / math.sqrt(len(scene.obstacles))


def _central(index: ObstacleIndex, robot: Robot, delta: float) -> CentralRoute | None:
    try:
        return central_path(index, robot, delta)
    except NoPath:
        return None


def _timed(work: Callable[[], Any]) -> tuple[float, Any]:
    """Seconds of one run, and what it gives."""
    out: list[Any] = []
    seconds = clocked(lambda: out.append(work()))
    return seconds, out[0]


def _least(work: Callable[[], object]) -> float:
    """Seconds of the shorter of two runs."""
    return min(clocked(work), clocked(work))


def _name(c: Central) -> str:
    return f"{c.corners:,} {c.pairs}" + (f", D_s {c.clearance:.3g} m" if c.clearance else "")


def _times(found: Sequence[Central]) -> Table:
    return Table(
        TITLE,
        ("corners, pairs", "visibility graph", "interval search", "index", "OCA", "OCA, slowest", "÷ OCA", "CA"),
        tuple(
            (
                _name(c),
                in_words(c.whole),
                in_words(c.direct),
                in_words(c.index),
                in_words(c.oca),
                in_words(c.slowest),
                f"{c.whole / c.oca:,.0f}",
                in_words(c.ca),
            )
            for c in found
        ),
        "The scattered polygons of above, without clearance and with D_s = "
        f"{100 * CLEARANCE:g} % of the obstacles' mean spacing; for one path, from a Scene in memory; "
        f"warm, medians. Near: {PAIRS['near']} pairs {100 * NEAR:g} % of the width apart. Far: {PAIRS['far']} pairs at "
        f"least {100 * FAR:g} %.",
        (
            "Visibility graph: free space, triangulation, tangent graph and one path by A*. Interval search: free "
            "space, triangulation and one path. Both are prepared once for many paths; this is what the first costs.",
            "Index: what OCA and CA need once for all paths, of robots of all sizes; not in their times. ÷ OCA: how "
            "many times as long the visibility graph takes.",
        ),
        f"![Time, obstacles taken in and free paths by number of corners](figures/{picture('central')})",
    )


def _looks(found: Sequence[Central]) -> Table:
    return Table(
        FOUND_TITLE,
        (
            "corners, pairs",
            "obstacles",
            "OCA takes in",
            "most",
            "rounds",
            "most",
            "CA: free",
            "hits",
            "no way",
            "free CA path ÷ shortest",
        ),
        tuple(
            (
                _name(c),
                f"{c.obstacles:,}",
                f"{100 * c.used:.2f} %",
                f"{100 * c.most_used:.2f} %",
                f"{c.rounds:g}",
                f"{c.most_rounds}",
                f"{100 * c.free:.0f} %",
                f"{100 * c.hits:.0f} %",
                f"{100 * c.lost:.0f} %",
                LEFT_OUT if c.longer is None else f"{c.longer:.3f}",
            )
            for c in found
        ),
        "The same paths. Every OCA path is proved shortest; its length differs from that in the visibility graph of "
        f"the whole map by {max(c.differ for c in found):.1e} relative at most.",
        (
            "takes in: share of the obstacles that OCA ever grows, mean and most. Rounds: median and most.",
            "CA: shares of its paths that are free, that hit an obstacle which its baseline does not cross, and of "
            f"questions that it does not answer though there is a way. δ is {100 * CLEARANCE:g} % of the spacing, too.",
        ),
    )


def _line(
    ax: Any, found: Sequence[Central], value: Callable[[Central], float], colour: str, label: str, line: str
) -> None:
    ax.plot([c.corners for c in found], [value(c) for c in found], line, color=colour, linewidth=2.0, label=label)


def _finished(ax: Any, found: Sequence[Central], unit: str, title: str) -> None:
    corners = sorted({c.corners for c in found})
    ax.set(xscale="log", xlabel="corners of obstacles", ylabel=unit, title=title)
    ax.set_xticks(corners, [f"{n:,}" for n in corners])
    ax.minorticks_off()
    ax.grid(alpha=0.3)
    ax.legend(loc="upper center", bbox_to_anchor=(0.5, -0.16), ncols=2, fontsize=8.5, frameon=False)
