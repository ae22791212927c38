"""Changing a triangulated region where some of its boundary changes, instead of triangulating it anew.

The triangles that come near a changed edge are cut out. What is to be triangulated in their place is bounded by the
edges that an odd number of three lists hold: the rim of the cavity, the old boundary, the new boundary. Flips then
make the whole Delaunay again, so that long chains of changes do not spoil it.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import shapely
from numpy.typing import NDArray

from taut.geometry import _boundary_kernels, _kernels, _patch_kernels
from taut.geometry.triangulation import Floats, Ints, Triangulation, boundary_of, filled, tabulated


@dataclass(frozen=True, eq=False)
class Patch:
    """A changed triangulation, and what of it is unchanged.

    Parameters
    ----------
    mesh : the triangulation after the change.
    before : (w,) number of each wedge in the old triangulation, −1 where it is new or has another neighbour now.
    changed : (k, 4) metres, the boundary edges that came or went.
    corners : (c, 2) metres, the boundary vertices that came or went.
    """

    mesh: Triangulation
    before: Ints
    changed: Floats
    corners: Floats


class Unsafe(Exception):
    """The change cannot be made locally; the region has to be triangulated anew."""


def unchanged(mesh: Triangulation) -> Patch:
    """Return the patch that changes nothing."""
    return Patch(mesh, np.arange(len(mesh.wedges)), np.empty((0, 4)), np.empty((0, 2)))


def outline(region: shapely.Polygon | shapely.MultiPolygon) -> Floats:
    """Edges of a region's rings between vertices that are not straight: (k, 4) metres."""
    vertices, edges = boundary_of(region)
    return vertices[edges].reshape(-1, 4)


def walls_near(mesh: Triangulation, shape: shapely.Geometry, margin: float) -> Ints:
    """Wedges whose boundary edge, from the vertex to the first neighbour, is within ``margin`` metres of a shape."""
    x0, y0, x1, y1 = shape.bounds
    box = x0 - margin, y0 - margin, x1 + margin, y1 + margin
    found = _boundary_kernels.walls_in_box(mesh.vertices, mesh.wedges, *box)
    edges = shapely.linestrings(mesh.vertices[mesh.wedges[found, :2]])
    near: Ints = found[shapely.dwithin(edges, shape, margin)]
    return near


def walls_about(mesh: Triangulation, cores: NDArray[np.object_], reach: Floats) -> Ints:
    """Wedges whose boundary edge lies on a closed walk that comes within ``reach`` (k,) metres of a core (k,)."""
    box = shapely.bounds(cores) + reach[:, None] * [-1, -1, 1, 1]
    bounds = (*box[:, :2].min(axis=0), *box[:, 2:].max(axis=0))
    near = _boundary_kernels.walls_in_box(mesh.vertices, mesh.wedges, *bounds)
    at = shapely.points(mesh.vertices[mesh.wedges[near, 0]])
    seeds = near[np.unique(shapely.STRtree(at).query(cores, "dwithin", reach)[1])]
    return _boundary_kernels.loops_through(mesh.wedges, mesh.wedge_of, seeds)


def patched(mesh: Triangulation, walls: Ints, edges: Floats, narrowest: float, margin: float) -> Patch:
    """Exchange closed walks of the boundary for other closed ones.

    Parameters
    ----------
    mesh : the region before.
    walls : wedges whose boundary edge, to the first neighbour, goes.
    edges : (k, 4) metres, the edges that come; those that go and come again stay.
    narrowest : passages narrower than this are closed, as in `triangulate`.
    margin : metres; triangles so near to an edge that comes or goes are cut out.

    Raises
    ------
    Unsafe
        The edges that come cross others, or the rim of the cavity is lost.
    """
    vertices, old, new = _numbered(mesh, walls, edges)
    changed = _odd(np.concatenate([old, new]))
    if len(changed) == 0:
        return unchanged(mesh)
    cavity = _patch_kernels.triangles_near(vertices, mesh.triangles, *mesh.grid, changed, margin)
    rim, beyond = _patch_kernels.rim(mesh.triangles, mesh.neighbours, cavity)
    triangles, neighbours = _filled(vertices, _odd(np.concatenate([rim, old, new])))
    outside = _across(len(vertices), triangles, neighbours, rim, beyond)
    vertex_number, triangle_number, tri, nbr = _patch_kernels.splice(
        len(vertices), mesh.triangles, mesh.neighbours, cavity, triangles, neighbours, outside
    )
    xy = np.ascontiguousarray(vertices[vertex_number >= 0])
    moved = _patch_kernels.flip_to_delaunay(xy, tri, nbr, len(tri) - len(triangles))
    if not _fits(mesh, xy[tri[moved]], len(tri)) or _patch_kernels.any_hairline(xy, tri, nbr, moved, narrowest):
        after = tabulated(xy, *_kernels.close_hairlines(xy, tri, nbr, narrowest))
    else:
        after = _tables(mesh, xy, tri, nbr, vertex_number, triangle_number, moved)
    before = _patch_kernels.same_wedges(
        mesh.wedges, after.wedges, vertex_number, after.vertex_start, after.vertex_wedges
    )
    return Patch(after, before, vertices[changed].reshape(-1, 4), vertices[np.setxor1d(old, new)])


def _numbered(mesh: Triangulation, walls: Ints, edges: Floats) -> tuple[Floats, Ints, Ints]:
    """Vertices of the mesh and behind them new ones; the edges that go and that come, (k, 2) rows of them."""
    old: Ints = mesh.wedges[walls, :2]
    known = np.unique(old)
    at = np.concatenate([mesh.vertices[known], edges.reshape(-1, 2)])
    places, row = np.unique(at[:, 0] + 1j * at[:, 1], return_inverse=True)
    number = np.full(len(places), -1, dtype=np.int64)
    number[row[: len(known)]] = known
    fresh = np.flatnonzero(number < 0)
    number[fresh] = len(mesh.vertices) + np.arange(len(fresh))
    vertices = np.concatenate([mesh.vertices, np.stack([places[fresh].real, places[fresh].imag], axis=1)])
    return vertices, old, number[row[len(known) :]].reshape(-1, 2)


def _odd(edges: Ints) -> Ints:
    """Edges, in either direction, that are given an odd number of times."""
    low, high = edges.min(axis=1), edges.max(axis=1)
    order = np.lexsort((high, low))
    low, high = low[order], high[order]
    first = np.flatnonzero(np.append(True, (np.diff(low) != 0) | (np.diff(high) != 0))[: len(low)])
    chosen = first[np.diff(np.append(first, len(low))) % 2 == 1]
    return np.stack([low[chosen], high[chosen]], axis=1)


def _filled(vertices: Floats, edges: Ints) -> tuple[Ints, Ints]:
    """Triangulate what closed edges enclose: triangles as rows of ``vertices``, and their neighbours."""
    if len(edges) == 0:
        return np.empty((0, 3), dtype=np.int64), np.empty((0, 3), dtype=np.int64)
    used, rows = np.unique(edges, return_inverse=True)
    try:
        triangles, neighbours = filled(vertices[used], rows.reshape(-1, 2))
    except ValueError:
        raise Unsafe from None
    return used[triangles], neighbours


def _across(n: int, triangles: Ints, neighbours: Ints, rim: Ints, beyond: Ints) -> Ints:
    """For each edge of the new triangles the old triangle across it, −1 at the boundary; n vertices."""
    out = np.full(triangles.shape, -1, dtype=np.int64)
    portals = beyond >= 0
    if portals.any():
        keys = rim[portals, 0] * n + rim[portals, 1]
        order = np.argsort(keys)
        ours = triangles * n + np.roll(triangles, -1, axis=1)
        place = order[np.minimum(np.searchsorted(keys[order], ours), len(keys) - 1)]
        match = (keys[place] == ours) & (neighbours < 0)
        out[match] = beyond[portals][place[match]]
    if np.count_nonzero(out >= 0) != np.count_nonzero(portals):
        raise Unsafe
    return out


def _fits(mesh: Triangulation, changed: Floats, count: int) -> bool:
    """Whether the location grid of the mesh is good for changed triangles, (k, 3, 2) metres, ``count`` in all."""
    frame, shape = mesh.grid[:2]
    cells = int(shape[0] * shape[1])
    if not 0.5 * cells <= count <= 2 * cells:
        return False
    corners = changed.reshape(-1, 2)
    return bool((corners >= frame[:2]).all() and (corners <= frame[:2] + frame[2] * shape).all())


def _tables(
    mesh: Triangulation, xy: Floats, tri: Ints, nbr: Ints, vertex_number: Ints, triangle_number: Ints, moved: Ints
) -> Triangulation:
    """Complete a changed mesh with tables, taken from the old one where they are the same."""
    frame, shape, start, items = mesh.grid
    fan, wedge_of = _patch_kernels.patched_wedges(
        tri, nbr, mesh.wedges, mesh.wedge_of, vertex_number, triangle_number, moved
    )
    grid = (frame, shape, *_patch_kernels.patched_grid(xy, tri, frame, shape, start, items, triangle_number, moved))
    parts, part_count = _kernels.label_parts(nbr)
    turns = _kernels.wedge_turns(xy, fan)
    by_vertex = _patch_kernels.wedges_of_vertices(fan, len(xy))
    return Triangulation(xy, tri, nbr, parts, part_count, fan, wedge_of, turns, *by_vertex, grid)
