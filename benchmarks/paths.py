"""The suite of building and paths: all its measurements in turn, its tables and its picture."""

from __future__ import annotations

from functools import partial
from pathlib import Path

import against
import asking
import building
import editing
import maps
import paths_picture
import targets
from measure import Report
from scattered import free_places, scattered_scene
from taut.freespace import FreeSpace
from taut.roadmap import visibility_graph

SIZES = (30, 100, 300, 1000, 3000, 10_000, 30_000, 100_000)
QUICK = (30, 300, 1000)
SEED = 1
TITLES = (
    building.TITLE,
    asking.TITLE,
    asking.LABELS_TITLE,
    editing.TITLE,
    against.TITLE,
    maps.TITLE,
    targets.TITLE,
)


def suite(quick: bool, folder: Path | None) -> Report:
    """Measure all sizes, and the maps of a folder if one is given; print what each gives at once."""
    longest = 5.0 if quick else 60.0
    _warm_up()
    builds: tuple[building.Build, ...] = ()
    queries: tuple[asking.Queries, ...] = ()
    edits: tuple[editing.Edits, ...] = ()
    others: tuple[against.Compared, ...] = ()
    for corners in QUICK if quick else SIZES:
        scene = scattered_scene(corners, SEED)
        freespace = FreeSpace(scene)
        tangents = visibility_graph(freespace)
        places = free_places(freespace, 2 * asking.PAIRS, SEED)
        build = building.built(scene, freespace, corners, tangents.graph.m, building.memory(corners))
        builds += (build,)
        print(building.in_short(build), flush=True)
        queries += (asking.queries(freespace, corners, places, corners <= asking.MOST_LABELLED),)
        print(asking.in_short(queries[-1]), flush=True)
        edits += (editing.edits(freespace, tangents, corners, build.alone),)
        print(editing.in_short(edits[-1]), flush=True)
        single, batch = queries[-1].direct.single, queries[-1].astar.batch
        fresh = against.compared(scene, freespace, places, build, single, batch, others, longest)
        others += fresh
        print(*map(against.in_short, fresh), sep="\n", flush=True)
    real: tuple[maps.RealMap, ...] = ()
    if folder is not None:
        real = maps.real_maps(folder)
        print(*map(maps.in_short, real), sep="\n", flush=True)
    print(flush=True)
    tables = [building.table(builds), *asking.tables(queries), editing.table(edits), against.table(others)]
    if real:
        tables.append(maps.table(real))
    tables.append(targets.table(targets.targets(builds, queries, edits, others, real)))
    draw = partial(paths_picture.draw, builds=builds, queries=queries, others=others)
    return Report(tuple(tables), draw)


def _warm_up() -> None:
    """Compile, or load from the cache, every kernel that is timed, the others' too."""
    scene = scattered_scene(30, SEED)
    freespace = FreeSpace(scene)
    tangents = visibility_graph(freespace)
    asking.queries(freespace, 30, free_places(freespace, 40, SEED), labelled=True)
    editing.edits(freespace, tangents, 30, 0.0)
    against.warm_up()
