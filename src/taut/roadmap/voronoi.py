"""The Voronoi roadmap: the lines in the middle between the sides of free space, where there is most room."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import coo_array
from scipy.sparse.csgraph import connected_components

from taut.chunks import over_chunks
from taut.freespace import FreeSpace
from taut.geometry._kernels import close_hairlines
from taut.geometry.seeing import see_each_other
from taut.geometry.triangulation import Floats, Ints, Triangulation, filled, tabulated
from taut.graph import Graph
from taut.roadmap import _voronoi_kernels
from taut.roadmap.core import LocatedRoadmap

_USUAL_SPACINGS = 20_000
_MOST_SPACINGS = 1_000_000
_FINENESS = 0.5
_FINEST = 1 / 32
_CHUNK = 1024


@dataclass(frozen=True, eq=False)
class VoronoiRoadmap(LocatedRoadmap):
    """The medial axis of a free space as a graph: straight edges in the middle between samples of the boundary.

    Parameters
    ----------
    clearances : (m,) metres from the boundary that each edge keeps, exact for the edge; in the order of ``edges``.
    vertex_clearances : (n,) the same of the vertices.
    spacing : metres between samples, at most.
    error : metres by which the widest way along the roadmap may be narrower than the widest way in the plane.
    cells : Delaunay triangulation of the sampled boundary.
    centres : (t,) the vertex that each of its triangles leads to, −1 for triangles too small for one.
    """

    clearances: Floats
    vertex_clearances: Floats
    spacing: float
    error: float
    cells: Triangulation
    centres: Ints


def voronoi_roadmap(freespace: FreeSpace, spacing: float | None = None) -> VoronoiRoadmap:
    """Build the roadmap that keeps as far from obstacles and wall as possible.

    Parameters
    ----------
    spacing : greatest distance in metres between samples of the boundary; None for √(A / (1024 + n)) with the area A of
        the free space and its n corners, or 1/20,000 of its boundary if that is more. Where sides are near each other
        samples are up to 32 times as dense.

    Raises
    ------
    ValueError
        ``spacing`` is not a positive number, or over a million times smaller than the length of the boundary.

    Notes
    -----
    Sides are cut at samples until no circle about a triangle of the Delaunay triangulation is centred beyond the
    boundary. Vertices are these centres, edges join neighbouring triangles: the Voronoi diagram of the samples without
    what crosses the boundary, so each part of free space keeps its connections and each obstacle its ring. Where
    sampling stops earlier, in passages narrower than 1/32 of the spacing, edges lead through the middles of the common
    sides of triangles instead.

    The error is measured, not estimated: every way in the plane passes the same triangles as some path of edges, and
    can keep no more from the boundary than the widest place of each side that it crosses. From any place in a triangle
    the straight line to the centre of its circle comes no nearer to the boundary than its two ends, as no sample lies
    in the circle.

    >>> from taut import FreeSpace, Scene
    >>> roadmap = voronoi_roadmap(FreeSpace(Scene((0, 0, 8, 4))))
    >>> float(roadmap.vertex_clearances.max())
    2.0
    """
    if spacing is not None and not (spacing > 0 and math.isfinite(spacing)):
        raise ValueError(f"spacing must be a positive number of metres, got {spacing!r}")
    mesh, tol = freespace.mesh, freespace.scene.tol
    around = float(freespace.region.length)
    if spacing is None:
        spacing = max(math.sqrt(freespace.area / (1024 + len(mesh.vertices))), around / _USUAL_SPACINGS)
    elif around / spacing > _MOST_SPACINGS:
        raise ValueError(
            f"spacing {spacing:g} m would cut {around:g} m of boundary in over {_MOST_SPACINGS:,}; take more"
        )
    cells, side = _sampled(mesh, spacing, tol)
    axis = _axis(mesh, cells, tol)
    points, edges = axis.points, axis.edges
    graph = Graph.from_edges(len(points), edges, np.hypot(*(points[edges[:, 0]] - points[edges[:, 1]]).T))
    clearances = boundary_distances(mesh, points[edges[:, 0]], points[edges[:, 1]], axis.triangles[edges[:, 0]])
    at_vertices = boundary_distances(mesh, points, points, axis.triangles)
    error = _error(mesh, cells, side, axis, clearances, at_vertices)
    return VoronoiRoadmap(
        points, graph, freespace, axis.triangles, clearances, at_vertices, spacing, error, cells, axis.centres
    )


def boundary_distances(mesh: Triangulation, a: Floats, b: Floats, triangles: Ints) -> Floats:
    """Distances of segments from the boundary of a region in metres, (k,): from (k, 2) points a to (k, 2) points b.

    The segments must be free; ``triangles`` (k,) contain their first ends, see `Triangulation.locate`.

    >>> from taut import FreeSpace, Scene
    >>> mesh = FreeSpace(Scene((0, 0, 8, 4))).mesh
    >>> a, b = np.array([[2.0, 2.0]]), np.array([[7.5, 2.0]])
    >>> boundary_distances(mesh, a, b, mesh.locate(a)).tolist()
    [0.5]
    """
    arrays = mesh.vertices, mesh.triangles, mesh.neighbours

    def chunk(i: int, j: int) -> Floats:
        return _voronoi_kernels.boundary_distances(*arrays, a[i:j], b[i:j], triangles[i:j])

    found = over_chunks(chunk, len(a), _CHUNK)
    return np.concatenate(found) if found else np.empty(0)


def _sampled(mesh: Triangulation, spacing: float, tol: float) -> tuple[Triangulation, Ints]:
    """Delaunay triangulation of the sampled boundary, and the side on which each vertex lies, −1 for corners."""
    narrow = np.zeros(len(mesh.vertices), dtype=np.bool_)
    narrow[mesh.wedges[mesh.wedge_turns < 0, 0]] = True
    fixed = (mesh.wedges, mesh.vertex_start, mesh.vertex_wedges, spacing, _FINENESS, _FINEST * spacing, tol)
    xy, side = mesh.vertices, np.full(len(mesh.vertices), -1, dtype=np.int64)
    edges, more = _outline(mesh), len(mesh.triangles) > 0
    triangles, neighbours = np.empty((0, 3), dtype=np.int64), np.empty((0, 3), dtype=np.int64)
    while more:
        try:
            triangles, neighbours = filled(xy, edges)
        except ValueError:  # rounded samples crossed in a wedge thinner than a rounding: the last samples must do
            break
        edges, points, sides = _voronoi_kernels.refined(xy, triangles, neighbours, side, narrow, *fixed)
        more = len(points) > 0
        xy, side = np.concatenate([xy, points]), np.concatenate([side, sides])
    triangles, neighbours = close_hairlines(xy, triangles, neighbours, tol)
    return tabulated(xy, triangles, neighbours), side


def _outline(mesh: Triangulation) -> Ints:
    """Boundary edges (e, 2), the region on their left; short walls inside the region are none."""
    t, k = np.nonzero(mesh.neighbours < 0)
    edges = np.stack([mesh.triangles[t, k], mesh.triangles[t, (k + 1) % 3]], axis=1)
    there, back = (edges[:, i] * len(mesh.vertices) + edges[:, 1 - i] for i in (0, 1))
    return edges[~np.isin(there, back)]


@dataclass(frozen=True, eq=False)
class _Axis:
    """Places and edges of the roadmap, and what they were made of.

    Parameters
    ----------
    points, triangles, edges : as in the roadmap; edges i < j, sorted.
    centres : (t,) the vertex of each cell, −1 for none.
    is_round : (t,) whether that is the centre of the circle about the cell.
    gates : (g, 2) cell and number of each edge between two cells.
    edges_of : (g, 2) the edges that lead through each gate, −1 for none.
    """

    points: Floats
    triangles: Ints
    edges: Ints
    centres: Ints
    is_round: NDArray[np.bool_]
    gates: Ints
    edges_of: Ints


def _axis(mesh: Triangulation, cells: Triangulation, tol: float) -> _Axis:
    m = len(cells.triangles)
    t, k = np.nonzero(cells.neighbours > np.arange(m)[:, None])
    u = cells.neighbours[t, k]
    middles = (cells.vertices[cells.triangles[t, k]] + cells.vertices[cells.triangles[t, (k + 1) % 3]]) / 2
    circles = _voronoi_kernels.circumcentres(cells.vertices, cells.triangles)
    # three kinds of places: the centre of the circle about a cell, a place within the cell, the middle of a gate
    points = np.concatenate([circles, _inner(cells, t, u, middles), middles])
    triangles = mesh.locate(points)
    triangles[mesh.on_pinch(points)] = -1
    own, gate = _merged(circles, triangles[:m] >= 0, t, u, tol), 2 * m + np.arange(len(t))

    def sees(a: Ints, b: Ints) -> NDArray[np.bool_]:
        out = (triangles[a] >= 0) & (triangles[b] >= 0)
        out[out] = see_each_other(mesh, points, triangles, a[out], b[out])
        return out

    is_round = triangles[own] >= 0
    for cell in (t, u):
        is_round[cell[~sees(own[cell], gate)]] = False
    place = np.where(is_round, own, m + np.arange(m))
    a, b = place[t], place[u]
    direct = is_round[t] & is_round[u] & (a != b) & sees(a, b)
    bent = ~direct & (a != b) & sees(a, gate) & sees(b, gate)
    legs = np.full((len(t), 2, 2), -1, dtype=np.int64)
    legs[direct] = np.stack([a, b], axis=1)[direct, None]
    legs[bent] = np.stack([np.stack([a, gate], axis=1), np.stack([b, gate], axis=1)], axis=1)[bent]
    return _numbered(points, triangles, place, is_round, np.stack([t, k], axis=1), legs)


def _inner(cells: Triangulation, t: Ints, u: Ints, middles: Floats) -> Floats:
    """A place within each cell: amid the middles of its gates, or amid its corners if it has one gate or none.

    Parameters
    ----------
    t, u : (g,) the cells on both sides of each gate.
    middles : (g, 2) the middles of the gates.
    """
    m = len(cells.triangles)
    both = np.concatenate([t, u])
    count = np.bincount(both, minlength=m)
    total = [np.bincount(both, np.tile(middles[:, i], 2), minlength=m) for i in (0, 1)]
    centroid = cells.vertices[cells.triangles].mean(axis=1)
    return np.where(count[:, None] > 1, np.stack(total, axis=1) / np.maximum(count, 1)[:, None], centroid)


def _merged(centres: Floats, usable: NDArray[np.bool_], t: Ints, u: Ints, tol: float) -> Ints:
    """For each cell the first of those that share its circle, as far as neighbours differ by the tolerance at most."""
    near = usable[t] & usable[u]
    near[near] = np.hypot(*(centres[t[near]] - centres[u[near]]).T) <= tol
    m = len(centres)
    joined = coo_array((np.ones(near.sum()), (t[near], u[near])), shape=(m, m))
    label = connected_components(joined, directed=False)[1]
    return np.unique(label, return_index=True)[1][label].astype(np.int64)


def _numbered(
    points: Floats, triangles: Ints, place: Ints, is_round: NDArray[np.bool_], gates: Ints, legs: Ints
) -> _Axis:
    """Number the places in use, equal ones alike, and the edges; ``legs`` (g, 2, 2) are −1 where there is none."""
    used = np.unique(np.concatenate([place[triangles[place] >= 0], legs[legs >= 0]]))
    distinct, first, same = np.unique(points[used], axis=0, return_index=True, return_inverse=True)
    number = np.full(len(points) + 1, -1, dtype=np.int64)
    number[used] = same.reshape(-1)
    pairs = np.sort(number[legs].reshape(-1, 2), axis=1)
    real = pairs[:, 0] != pairs[:, 1]
    edges, which = np.unique(pairs[real], axis=0, return_inverse=True)
    edge_of = np.full(len(pairs), -1, dtype=np.int64)
    edge_of[real] = which.reshape(-1)
    return _Axis(distinct, triangles[used[first]], edges, number[place], is_round, gates, edge_of.reshape(-1, 2))


def _error(
    mesh: Triangulation, cells: Triangulation, side: Ints, axis: _Axis, clearances: Floats, at_vertices: Floats
) -> float:
    """Greatest excess of the room for a way in the plane over that on the roadmap, gate by gate and cell by cell."""
    if len(axis.points) == 0:
        return 0.0
    table = cells.vertices, cells.triangles, cells.neighbours, side, mesh.wedges, mesh.vertex_start, mesh.vertex_wedges
    through, within = _voronoi_kernels.widths(*table)
    own = np.where(axis.centres >= 0, at_vertices[axis.centres], 0.0)
    corner = cells.vertices[cells.triangles[:, 0]]
    radius = np.hypot(*(axis.points[axis.centres] - corner).T)
    in_cell = np.where(axis.is_round, np.minimum(within, radius) - own, within)
    t, k = axis.gates.T
    ends = axis.centres[t], axis.centres[cells.neighbours[t, k]]
    kept = np.append(clearances, np.inf)[axis.edges_of].min(axis=1)
    kept = np.where((axis.edges_of >= 0).any(axis=1), kept, np.where(ends[0] == ends[1], own[t], 0.0))
    return max(0.0, float(in_cell.max()), float((through[t, k] - kept).max(initial=0.0)))
