"""A polygonal region cut into triangles: arrays, wedges about its vertices, and which triangle holds a point."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, TypeAlias

import numpy as np
import pythoncdt
import shapely
from numpy.typing import NDArray

from taut.geometry import _boundary_kernels, _kernels

Floats = NDArray[np.float64]
Ints = NDArray[np.int64]
Region: TypeAlias = shapely.Polygon | shapely.MultiPolygon


@dataclass(frozen=True, eq=False)
class Triangulation:
    """Constrained Delaunay triangulation of a region; every vertex lies on the region's boundary.

    Two triangles are neighbours only across an edge in the interior of the region. Places where the region merely
    touches itself therefore do not connect, which is the rule of what is allowed.

    Parameters
    ----------
    vertices : (n, 2) metres.
    triangles : (m, 3) vertex numbers, counter-clockwise.
    neighbours : (m, 3) triangle across the edge from corner k to corner k + 1, −1 at the boundary.
    parts : (m,) number of the connected part of each triangle, from 0.
    part_count : how many parts there are.
    wedges : (w, 5) the open sectors of the region about its vertices: vertex, first and last boundary neighbour
        counter-clockwise, first triangle and the vertex' slot in it. Where the region touches itself there are several.
    wedge_of : (m, 3) wedge of each corner of each triangle.
    wedge_turns : (w,) +1 where the sector is wider than π (there shortest paths bend), 0 exactly π, −1 narrower.
    vertex_start, vertex_wedges : CSR of the wedges of each vertex.
    grid : frame, shape, start and items of the point-location grid.
    """

    vertices: Floats
    triangles: Ints
    neighbours: Ints
    parts: Ints
    part_count: int
    wedges: Ints
    wedge_of: Ints
    wedge_turns: Ints
    vertex_start: Ints
    vertex_wedges: Ints
    grid: tuple[Floats, Ints, Ints, Ints]

    def locate(self, points: Floats) -> Ints:
        """Triangle that contains each of (k, 2) points, boundary included and exactly; −1 outside."""
        if len(self.triangles) == 0:
            return np.full(len(points), -1, dtype=np.int64)
        return _kernels.locate(self.vertices, self.triangles, *self.grid, np.ascontiguousarray(points))

    def on_pinch(self, points: Floats) -> NDArray[np.bool_]:
        """Whether each of (k, 2) points is a vertex where the region touches itself."""
        pinches = self.vertices[np.diff(self.vertex_start) > 1]
        return np.isin(points[:, 0] + 1j * points[:, 1], pinches[:, 0] + 1j * pinches[:, 1])


def triangulate(region: Region, narrowest: float = 0.0) -> Triangulation:
    """Cut a valid (multi)polygon into triangles; straight boundary vertices are dropped first.

    Passages narrower than ``narrowest`` metres are closed: obstacles that touch, but for rounding, do touch.

    Raises
    ------
    ValueError
        The rings cross: the region is not valid.
    """
    return meshed(region, narrowest)[1]


def meshed(region: Region, narrowest: float) -> tuple[Region, Triangulation]:
    """Return what is left of a region when passages are closed, and its triangulation; see `triangulate`."""
    vertices, edges = boundary_of(region)
    if len(vertices) == 0:
        return region, tabulated(np.empty((0, 2)), np.empty((0, 3), dtype=np.int64), np.empty((0, 3), dtype=np.int64))
    triangles, neighbours = filled(vertices, edges)
    left, across = triangles, neighbours
    if narrowest > 0:
        left, across = _kernels.close_hairlines(vertices, triangles, neighbours, narrowest)
    mesh = tabulated(vertices, left, across)
    return (region if len(left) == len(triangles) else region_of(mesh)), mesh


def region_of(mesh: Triangulation) -> Region:
    """Region that a triangulation covers, without its straight vertices.

    It is a set of points: where triangles on both sides of an edge are no neighbours, the region does not show it.
    """
    walls = mesh.wedges[:, :2]
    doubtful = np.sort(walls[(np.diff(mesh.vertex_start)[walls] > 1).all(axis=1)], axis=1)
    if len(np.unique(doubtful, axis=0)) < len(doubtful):
        region: Region = shapely.coverage_union_all(shapely.polygons(mesh.vertices[mesh.triangles]))
        return region
    vertex, ring_start, part_start = _boundary_kernels.boundary_rings(
        mesh.vertices, mesh.wedges, mesh.wedge_of, mesh.parts, mesh.part_count
    )
    offsets = ring_start, part_start
    polygons = shapely.from_ragged_array(shapely.GeometryType.POLYGON, mesh.vertices[vertex], offsets)
    return polygons[0] if len(polygons) == 1 else shapely.multipolygons(polygons)


def filled(vertices: Floats, edges: Ints) -> tuple[Ints, Ints]:
    """Triangulate what closed edges (e, 2) enclose, which may be nothing: triangles and their neighbours.

    Raises
    ------
    ValueError
        The edges cross.
    """
    cdt = pythoncdt.Triangulation(
        pythoncdt.VertexInsertionOrder.AUTO, pythoncdt.IntersectingConstraintEdges.NOT_ALLOWED, 0.0
    )
    # arrays are buffers, but only from Python 3.12 on do their types say so
    points: Any = vertices
    sides: Any = edges.astype(np.uint32)
    try:
        cdt.insert_vertices(points)
        cdt.insert_edges(sides)
    except RuntimeError as error:
        raise ValueError(f"the rings of the region cross: {error}") from None
    cdt.erase_outer_triangles_and_holes()
    found = cdt.triangles_array()
    neighbours = found["neighbors"].astype(np.int64)
    neighbours[found["neighbors"] == pythoncdt.NO_NEIGHBOR] = -1
    return found["vertices"].astype(np.int64), neighbours


def tabulated(vertices: Floats, triangles: Ints, neighbours: Ints) -> Triangulation:
    """Complete triangles and their neighbours with all tables."""
    parts, part_count = _kernels.label_parts(neighbours)
    fan, wedge_of = _kernels.wedges(triangles, neighbours)
    order = np.argsort(fan[:, 0], kind="stable").astype(np.int64)
    start = np.searchsorted(fan[order, 0], np.arange(len(vertices) + 1)).astype(np.int64)
    grid = (
        _kernels.location_grid(vertices, triangles)
        if len(triangles)
        else (np.zeros(3), np.zeros(2, dtype=np.int64), np.zeros(1, dtype=np.int64), np.zeros(0, dtype=np.int64))
    )
    turns = _kernels.wedge_turns(vertices, fan)
    return Triangulation(vertices, triangles, neighbours, parts, part_count, fan, wedge_of, turns, start, order, grid)


def boundary_of(region: shapely.Polygon | shapely.MultiPolygon) -> tuple[Floats, Ints]:
    """Distinct vertices of the region's rings and the edges between them, straight vertices left out."""
    rings = shapely.get_rings(shapely.get_parts(region))
    if len(rings) == 0:
        return np.empty((0, 2)), np.empty((0, 2), dtype=np.int64)
    xy, ring = shapely.get_coordinates(rings, return_index=True)
    last = np.flatnonzero(np.append(np.diff(ring) > 0, True))
    xy, ring = np.delete(xy, last, axis=0) + 0.0, np.delete(ring, last)
    vertices, number = _distinct(xy)
    shared = np.bincount(number)[number] > 1
    start = np.searchsorted(ring, np.arange(len(rings) + 1)).astype(np.int64)
    keep = ~_kernels.straight_corners(xy, start, shared)
    if not keep.all():
        xy, ring = xy[keep], ring[keep]
        vertices, number = _distinct(xy)
    start = np.searchsorted(ring, np.arange(len(rings)))
    following = np.arange(1, len(xy) + 1)
    ends = np.append(start[1:], len(xy))
    filled = ends > start
    following[ends[filled] - 1] = start[filled]
    return vertices, np.stack([number, number[following]], axis=1).astype(np.int64)


def _distinct(xy: Floats) -> tuple[Floats, Ints]:
    keys, number = np.unique(xy[:, 0] + 1j * xy[:, 1], return_inverse=True)
    return np.ascontiguousarray(np.stack([keys.real, keys.imag], axis=1)), number.astype(np.int64)
