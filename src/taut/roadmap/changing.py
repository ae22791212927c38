"""Adding and removing one obstacle at the cost of what it touches, instead of building the whole map anew.

Obstacles that touch, directly or through others, are a cluster; so may the wall be part of one. The boundary of free
space about the cluster of the obstacle is computed from the obstacles again, with the functions that build a free
space, and exchanged in the triangulation (`taut.geometry.patching`). In the tangent graph only the corners at changed
boundary look about anew, and the others past the obstacle that is gone.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from itertools import chain
from typing import NamedTuple

import numpy as np
import shapely
from numpy.typing import NDArray

from taut.chunks import over_chunks
from taut.errors import SceneError
from taut.freespace import FreeSpace
from taut.geometry import _patch_kernels
from taut.geometry.growth import free_region, grown
from taut.geometry.patching import Patch, Unsafe, outline, patched, unchanged, walls_about, walls_near
from taut.geometry.triangulation import Triangulation, region_of
from taut.graph import Graph
from taut.graph.core import Floats, Ints
from taut.roadmap import _changing_kernels
from taut.roadmap.visibility import VisibilityGraph, visibility_graph
from taut.scene import Line, Obstacle, Polygon, Scene
from taut.validation import check_numbers

Bools = NDArray[np.bool_]

_CHUNK = 2048
_NEAR = 16.0
"""Things within so many tolerances of each other are looked at together; it selects work and changes no result."""


@dataclass(frozen=True, eq=False)
class Changed:
    """A free space and its tangent graph after one obstacle was added or removed.

    Parameters
    ----------
    freespace : as ``FreeSpace`` of the changed scene would be, but for the order of its vertices.
    tangents : as ``visibility_graph(freespace)`` would be, but for the order of its vertices: those that were there
        before come first, in their old order.
    before : (n,) number of each vertex in the old tangent graph, −1 where it is new or has another neighbour on the
        boundary now.
    rebuilt : whether everything was built anew, because the change could not be made locally.
    """

    freespace: FreeSpace
    tangents: VisibilityGraph
    before: Ints
    rebuilt: bool


def with_obstacle(freespace: FreeSpace, tangents: VisibilityGraph, obstacle: Obstacle) -> Changed:
    """Add an obstacle to a map.

    Parameters
    ----------
    freespace : that of a scene, with nothing else taken from it.
    tangents : its tangent graph without further points.
    obstacle : without a name it gets the first free name O1, O2, … of its position.

    Raises
    ------
    SceneError
        Its name is taken, or the obstacle crosses or touches itself.
    ValueError
        ``tangents`` is not the tangent graph of ``freespace``.

    Notes
    -----
    What is copied is copied in whole, some milliseconds for a million edges; what is computed is in proportion to the
    clusters that the obstacle touches and to what can be seen from it.

    >>> from taut.scene import Rectangle
    >>> hall = FreeSpace(Scene((0, 0, 8, 8), [Rectangle(2, 2, 1, 1)]))
    >>> changed = with_obstacle(hall, visibility_graph(hall), Rectangle(5, 5, 1, 1))
    >>> changed.freespace.area, changed.tangents.graph.n
    (62.0, 8)
    """
    _check(freespace, tangents)
    if not isinstance(obstacle, Obstacle):
        raise SceneError(f"an obstacle is a Polygon, Rectangle, Circle or Line, got {obstacle!r}")
    scene = replace(freespace.scene, obstacles=(*freespace.scene.obstacles, obstacle))
    added = scene.obstacles[-1]
    tol = max(freespace.scene.tol, _own_tol(added))
    vars(scene)["tol"] = tol  # which the scene would look for among all its obstacles
    check_numbers(replace(scene.with_obstacles([added]), robots=()))
    if tol > freespace.scene.tol and (_thickens(freespace, tol) or _closes(freespace.mesh, tol)):
        return _rebuilt(freespace, scene)
    shape = grown(added, freespace.growth, freespace.arc_error, keep=freespace.kept, tol=tol)
    margin = _NEAR * tol
    mesh = freespace.mesh
    try:
        if len(walls_near(mesh, shape, margin)):
            cluster = _cluster(freespace, scene.obstacles, len(scene.obstacles) - 1, margin)
            patch = _recomputed(freespace, cluster, [scene.obstacles[k] for k in cluster.members], tol)
        elif mesh.locate(shapely.get_coordinates(shape)[:1])[0] >= 0:
            patch = patched(mesh, np.empty(0, dtype=np.int64), outline(shape), tol, margin)
        else:
            patch = unchanged(mesh)
    except Unsafe:
        return _rebuilt(freespace, scene)
    return _changed(freespace, tangents, scene, patch, _strays(patch, shape, margin))


def without_obstacle(freespace: FreeSpace, tangents: VisibilityGraph, name: str) -> Changed:
    """Remove the obstacle of this name from a map.

    Parameters and errors are those of `with_obstacle`; an unknown name is a SceneError.

    >>> from taut.scene import Rectangle
    >>> hall = FreeSpace(Scene((0, 0, 8, 8), [Rectangle(2, 2, 1, 1, name="A"), Rectangle(5, 5, 1, 1)]))
    >>> without_obstacle(hall, visibility_graph(hall), "A").freespace.area
    63.0
    """
    _check(freespace, tangents)
    old = freespace.scene
    place = next((k for k, o in enumerate(old.obstacles) if o.name == name), None)
    if place is None:
        raise SceneError(f"there is no obstacle {name}; name one of the scene")
    gone = old.obstacles[place]
    scene = replace(old, obstacles=old.obstacles[:place] + old.obstacles[place + 1 :])
    if _own_tol(gone) < old.tol:
        vars(scene)["tol"] = old.tol
    elif scene.tol < old.tol:
        return _rebuilt(freespace, scene)
    margin = _NEAR * old.tol
    cluster = _cluster(freespace, old.obstacles, place, margin)
    try:
        patch = _recomputed(freespace, cluster, [old.obstacles[k] for k in cluster.members if k != place], old.tol)
    except Unsafe:
        return _rebuilt(freespace, scene)
    shape = grown(gone, freespace.growth, freespace.arc_error, keep=freespace.kept, tol=old.tol)
    corners = shapely.get_coordinates(shapely.oriented_envelope(shape))
    return _changed(freespace, tangents, scene, patch, np.append(corners, _strays(patch, shape, margin), axis=0))


class _Cluster(NamedTuple):
    """Obstacles that hang together: their numbers, shapes without growth and (k,) metres by which they grow at most.

    Where the wall is one of them, its ring is the last of the shapes.
    """

    members: list[int]
    cores: NDArray[np.object_]
    reach: Floats
    walled: bool


def _check(freespace: FreeSpace, tangents: VisibilityGraph) -> None:
    turns = freespace.mesh.wedge_turns
    corners = np.count_nonzero(turns >= 0)
    if len(tangents.wedges) != corners or (
        corners and (tangents.wedges.min() < 0 or tangents.wedges.max() >= len(turns))
    ):
        raise ValueError(
            "tangents is not the tangent graph of this free space without further points; "
            "build it by visibility_graph(freespace)"
        )


def _own_tol(obstacle: Obstacle) -> float:
    return 2.0**-40 * (float(np.abs(obstacle.core).max()) + obstacle.own_radius)


def _thickens(freespace: FreeSpace, tol: float) -> bool:
    """Whether some line or circle is so thin that a larger tolerance makes it thicker."""
    return any(not o.closed and o.own_radius + freespace.growth < tol / 2 for o in freespace.scene.obstacles)


def _closes(mesh: Triangulation, tol: float) -> bool:
    """Whether a larger tolerance closes passages that were open."""
    everything = np.arange(len(mesh.triangles))
    return _patch_kernels.any_hairline(mesh.vertices, mesh.triangles, mesh.neighbours, everything, tol)


def _rebuilt(freespace: FreeSpace, scene: Scene) -> Changed:
    built = FreeSpace(scene, freespace.growth, freespace.arc_error)
    tangents = visibility_graph(built)
    return Changed(built, tangents, np.full(tangents.graph.n, -1, dtype=np.int64), True)


def _cluster(freespace: FreeSpace, obstacles: tuple[Obstacle, ...], first: int, margin: float) -> _Cluster:
    """Find what hangs together with one obstacle, touching to within ``margin`` metres; a little more is no harm."""
    boxes, reach = _bounds(obstacles, freespace)
    boxes += reach[:, None] * [-1, -1, 1, 1]
    wall = shapely.LinearRing(freespace.scene.workspace)
    wall_reach = freespace.growth * (1 + freespace.arc_error)
    members, cores = [first], {first: _core(obstacles[first])}
    walled = False
    for k in members:  # grows meanwhile
        low, high = boxes[k, :2] - margin, boxes[k, 2:] + margin
        near = np.flatnonzero((boxes[:, :2] <= high).all(axis=1) & (boxes[:, 2:] >= low).all(axis=1))
        fresh = [j for j in near.tolist() if j not in cores]
        for j in fresh:
            core = _core(obstacles[j])
            if shapely.dwithin(core, cores[k], reach[j] + reach[k] + margin):
                cores[j] = core
                members.append(j)
        if not walled and shapely.dwithin(wall, cores[k], wall_reach + reach[k] + margin):
            walled = True
            close = shapely.dwithin(shapely.box(*boxes.T), wall, wall_reach + margin)
            for j in np.flatnonzero(close).tolist():
                core = _core(obstacles[j])
                if j not in cores and shapely.dwithin(wall, core, wall_reach + reach[j] + margin):
                    cores[j] = core
                    members.append(j)
    shapes = [cores[k] for k in members]
    reaches = reach[members]
    if walled:
        shapes.append(wall)
        reaches = np.append(reaches, wall_reach)
    return _Cluster(members, np.array(shapes, dtype=object), reaches, walled)


def _bounds(obstacles: tuple[Obstacle, ...], freespace: FreeSpace) -> tuple[Floats, Floats]:
    """Boxes (n, 4) round the obstacles without growth, and the metres (n,) by which they grow at most."""
    rows = [o.points if isinstance(o, Polygon | Line) else o.core.tolist() for o in obstacles]
    flat = np.fromiter(chain.from_iterable(chain.from_iterable(rows)), dtype=np.float64).reshape(-1, 2)
    first = np.append(0, np.cumsum([len(row) for row in rows])[:-1])
    boxes = np.concatenate([np.minimum.reduceat(flat, first), np.maximum.reduceat(flat, first)], axis=1)
    own = np.array([o.own_radius for o in obstacles])
    reach: Floats = (own + freespace.growth) * (1 + freespace.arc_error)
    return boxes, reach


def _core(obstacle: Obstacle) -> shapely.Geometry:
    """The shape of an obstacle without its own radius."""
    core = obstacle.core
    if obstacle.closed:
        return shapely.Polygon(core)
    return shapely.LineString(core) if len(core) > 1 else shapely.Point(core[0])


def _recomputed(freespace: FreeSpace, cluster: _Cluster, after: list[Obstacle], tol: float) -> Patch:
    """Exchange the boundary of free space about a cluster; ``after`` are its obstacles from now on."""
    margin = _NEAR * tol
    walls = walls_about(freespace.mesh, cluster.cores, cluster.reach + margin / 2)
    low, high = shapely.total_bounds(cluster.cores).reshape(2, 2)
    low, high = low - cluster.reach.max() - margin, high + cluster.reach.max() + margin
    # far enough about the cluster that the frame, shrunk, does not touch it
    away = 3 * freespace.growth + (high - low).max()
    frame = freespace.scene.workspace if cluster.walled else (*(low - away), *(high + away))
    edges = np.empty((0, 4))
    outside = not cluster.walled and not shapely.Polygon(freespace.scene.workspace).intersects(cluster.cores[0])
    if (after or cluster.walled) and not outside:
        local = Scene(frame, after)
        vars(local)["tol"] = tol
        edges = outline(free_region(local, freespace.growth, freespace.arc_error, keep=freespace.kept))
    if not cluster.walled:
        inside = (edges >= np.tile(low, 2)).all(axis=1) & (edges <= np.tile(high, 2)).all(axis=1)
        edges = edges[inside]
    return patched(freespace.mesh, walls, edges, tol, margin)


def _strays(patch: Patch, shape: shapely.Geometry, margin: float) -> Floats:
    """Corners of the cluster away from the obstacle that came out another by rounding, (k, 2)."""
    away: Bools = ~shapely.dwithin(shapely.points(patch.corners), shape, margin)
    return patch.corners[away]


def _changed(freespace: FreeSpace, tangents: VisibilityGraph, scene: Scene, patch: Patch, past: Floats) -> Changed:
    """Put together the changed map; what is gone lies within the convex hull of the points ``past`` (h, 2)."""
    if patch.mesh is freespace.mesh:
        same = FreeSpace.with_mesh(scene, freespace.growth, freespace.arc_error, freespace.region, patch.mesh)
        return Changed(same, tangents, np.arange(tangents.graph.n), False)
    region = region_of(patch.mesh)
    space = FreeSpace.with_mesh(scene, freespace.growth, freespace.arc_error, region, patch.mesh)
    return _seen(space, tangents, patch, past)


def _seen(space: FreeSpace, tangents: VisibilityGraph, patch: Patch, past: Floats) -> Changed:
    """Find the tangent graph of the changed free space from the old one."""
    mesh, graph = patch.mesh, tangents.graph
    wanted = mesh.wedge_turns >= 0
    wedges, before, number = _renumbered(tangents, patch, wanted)
    kept = int(np.count_nonzero(before >= 0))
    # an edge that touches changed boundary without crossing it is in doubt: it is dropped and looked for again
    a, b, crosses = _changing_kernels.meeting(
        tangents.positions, graph.indptr, graph.indices, patch.changed, _NEAR * space.scene.tol
    )
    doubtful = number[a[~crosses]]
    roots = np.concatenate([wedges[kept:], wedges[np.unique(doubtful[doubtful >= 0])]])
    arrays = (mesh.triangles, mesh.neighbours, mesh.wedges, mesh.wedge_of, wanted)
    found = [_changing_kernels.see_past(mesh.vertices, *arrays, roots, np.empty(0, dtype=np.int64))]
    if len(past):
        around = _hull(past, _NEAR * space.scene.tol)
        hull = len(mesh.vertices) + np.arange(len(around))
        extended = np.concatenate([mesh.vertices, around])
        found += over_chunks(
            lambda first, last: _changing_kernels.see_past(extended, *arrays, wedges[first:last], hull), kept, _CHUNK
        )
    vertex = np.full(len(wanted), -1, dtype=np.int64)
    vertex[wedges] = np.arange(len(wedges))
    v, w = (vertex[np.concatenate(column)] for column in zip(*found, strict=True))
    keys = np.unique(np.concatenate([v * len(wedges) + w, w * len(wedges) + v]))
    pairs = np.stack([keys // max(len(wedges), 1), keys % max(len(wedges), 1)], axis=1)
    positions = mesh.vertices[mesh.wedges[wedges, 0]]
    lengths = np.hypot(*(positions[pairs[:, 0]] - positions[pairs[:, 1]]).T)
    rows = _changing_kernels.patched_rows(
        graph.indptr, graph.indices, graph.weights, number, len(wedges), np.stack([a, b], axis=1), pairs, lengths
    )
    return Changed(
        space, VisibilityGraph(positions, Graph(*rows), wedges, np.zeros(len(wedges), dtype=np.bool_)), before, False
    )


def _hull(points: Floats, margin: float) -> Floats:
    """Convex polygon that holds the points and ``margin`` metres about them, counter-clockwise, (h, 2)."""
    square = margin * np.array([(-1, -1), (1, -1), (1, 1), (-1, 1)])
    hull = shapely.convex_hull(shapely.multipoints((points[:, None] + square).reshape(-1, 2)))
    corners: Floats = shapely.get_coordinates(shapely.orient_polygons(hull))[:-1]
    return corners


def _renumbered(tangents: VisibilityGraph, patch: Patch, wanted: Bools) -> tuple[Ints, Ints, Ints]:
    """Wedge and old number of each new vertex, old ones first in their order; the new number of each old one or −1."""
    old = np.full(max(int(tangents.wedges.max(initial=-1)), int(patch.before.max(initial=-1))) + 2, -1, dtype=np.int64)
    old[tangents.wedges] = np.arange(len(tangents.wedges))
    corners = np.flatnonzero(wanted)
    was = old[patch.before[corners]]
    wedge = np.full(len(tangents.wedges), -1, dtype=np.int64)
    wedge[was[was >= 0]] = corners[was >= 0]
    stays = np.flatnonzero(wedge >= 0)
    fresh = corners[was < 0]
    number = np.full(len(wedge), -1, dtype=np.int64)
    number[stays] = np.arange(len(stays))
    before = np.append(stays, np.full(len(fresh), -1, dtype=np.int64))
    return np.append(wedge[stays], fresh), before, number
