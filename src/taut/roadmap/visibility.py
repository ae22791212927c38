"""Visibility graphs of a FreeSpace: every visible pair, or only those that a taut path can use."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

import numpy as np
import shapely
from numpy.typing import ArrayLike, NDArray

from taut.errors import SceneError
from taut.freespace import FreeSpace
from taut.geometry import _seeing_kernels
from taut.geometry.growth import free_region, grown
from taut.geometry.seeing import see_all, see_each_other, see_from
from taut.graph import Graph
from taut.graph.core import Floats, Ints
from taut.roadmap.core import Roadmap
from taut.scene import Scene


@dataclass(frozen=True, eq=False)
class VisibilityGraph(Roadmap):
    """A roadmap of the corners of free space, then the points given.

    Parameters
    ----------
    wedges : (n,) number of each vertex' wedge in ``freespace.mesh``, −1 for given points. Where free space touches
        itself, one place has several wedges, each a vertex of its own: paths may not pass from one to another.
    ends_only : (n,) whether paths may begin or end at a vertex but not pass through it: points given where free space
        touches itself. Such a point belongs to both sides, so its edges lead to both.
    """

    wedges: Ints
    ends_only: NDArray[np.bool_]


def visibility_graph(
    freespace: FreeSpace, edges: Literal["tangent", "all"] = "tangent", points: ArrayLike = ()
) -> VisibilityGraph:
    """Build the visibility graph of a free space.

    "all": vertices are those of the grown obstacles and the reflex corners of the shrunk workspace; an edge joins every
    pair whose segment is an allowed motion, also when it touches corners on its way. "tangent": only corners, only
    edges that are locally shortest at both ends and have no corner strictly between. Shortest lengths are the same.

    Parameters
    ----------
    points : (k, 2) further vertices (starts, goals), appended in this order. A search must pass through none of those
        that lie where free space touches itself, see ``ends_only`` of what comes back.

    Raises
    ------
    SceneError
        A point is not in free space.

    Notes
    -----
    Triangular expansion: time and memory linear in what is seen, from n log n for the triangulation.
    Source: Alwafi's thesis, 4.4, for "all"; tangent graphs: Pocchiola and Vegter 1996.
    """
    if edges not in ("tangent", "all"):
        raise ValueError(f'edges must be "tangent" or "all", got {edges!r}')
    mesh = freespace.mesh
    taut = edges == "tangent"
    wanted = mesh.wedge_turns >= 0 if taut else obstacle_wedges(freespace)
    vertices = np.flatnonzero(wanted)
    number = np.full(len(wanted), -1, dtype=np.int64)
    number[vertices] = np.arange(len(vertices))
    xy, triangles = freespace.anchor(points)
    if (triangles < 0).any():
        i = int(np.flatnonzero(triangles < 0)[0])
        raise SceneError(f"point ({xy[i, 0]:g}, {xy[i, 1]:g}) is not in free space (growth {freespace.growth:g} m)")
    pairs = [number[see_all(mesh, wanted, taut=taut)]]
    start, seen = see_from(mesh, xy, triangles, wanted, taut=taut)
    first = len(vertices)
    pairs.append(np.stack([number[seen], first + np.repeat(np.arange(len(xy)), np.diff(start))], axis=1))
    couples = np.stack(np.triu_indices(len(xy), 1), axis=1).astype(np.int64)
    both = see_each_other(mesh, xy, triangles, couples[:, 0].copy(), couples[:, 1].copy())
    pairs.append(first + couples[both])
    positions = np.concatenate([mesh.vertices[mesh.wedges[vertices, 0]], xy])
    found = np.concatenate(pairs)
    if not taut:
        found = _with_collinear(positions, np.append(mesh.wedge_turns[vertices] >= 0, np.zeros(len(xy), bool)), found)
    lengths = np.hypot(*(positions[found[:, 0]] - positions[found[:, 1]]).T)
    graph = Graph.from_edges(len(positions), found, lengths)
    wedges = np.append(vertices, np.full(len(xy), -1, dtype=np.int64))
    return VisibilityGraph(positions, graph, wedges, np.append(np.zeros(first, dtype=np.bool_), mesh.on_pinch(xy)))


def obstacle_wedges(freespace: FreeSpace) -> NDArray[np.bool_]:
    """Mark the wedges that belong to obstacles, and the corners of the workspace at which shortest paths bend."""
    mesh = freespace.mesh
    wanted = mesh.wedge_turns >= 0
    doubtful = np.flatnonzero(~wanted)
    at = mesh.vertices[mesh.wedges[doubtful, 0]]
    room = free_region(Scene(freespace.scene.workspace), freespace.growth, freespace.arc_error)
    on_wall = shapely.dwithin(shapely.points(at), room.boundary, freespace.scene.tol)
    grown_corners = shapely.get_coordinates(
        [grown(o, freespace.growth, freespace.arc_error, tol=freespace.scene.tol) for o in freespace.scene.obstacles]
    )
    of_obstacle = np.isin(at[:, 0] + 1j * at[:, 1], grown_corners[:, 0] + 1j * grown_corners[:, 1])
    wanted[doubtful] = of_obstacle | ~on_wall
    return wanted


def _with_collinear(positions: Floats, through: NDArray[np.bool_], pairs: Ints) -> Ints:
    graph = Graph.from_edges(len(positions), pairs)
    a, b = _seeing_kernels.extend_collinear(positions, through, graph.indptr, graph.indices)
    return np.unique(np.concatenate([pairs, np.stack([a, b], axis=1)]), axis=0)
