"""Places to wait and to dodge: a tangent graph enriched so that robots can let each other pass.

A tangent roadmap alone has vertices only at corners; an empty hall has none. Here it is joined with a square lattice
over the free space (16 directions), the middles of narrow passages, the dead ends of bays, and a second lane round the
corners, on which a robot passes another one that is pulled taut round them.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.spatial import KDTree

from taut.freespace import FreeSpace
from taut.geometry.seeing import see_each_other, see_from
from taut.geometry.triangulation import Floats, Ints, Triangulation
from taut.graph import Graph
from taut.roadmap.core import Arcs, LocatedRoadmap, both_ways
from taut.roadmap.grid import lattice
from taut.roadmap.visibility import VisibilityGraph, visibility_graph

# a square lattice has 16 directions when neighbours up to (2, 1) are joined; a little more reaches places off it too
_REACH = 2.3
_MOST_LATTICE_PLACES = 8000


@dataclass(frozen=True, eq=False)
class SharedRoadmap(LocatedRoadmap):
    """A roadmap for many robots that wait and let each other pass at its places, which are its last vertices.

    Parameters
    ----------
    spacing : metres between neighbouring places, about.
    places : nearest-neighbour index of the places alone.
    arcs : on what they move: the edges of the graph, in both directions unless the roadmap has one-way lanes.
    """

    spacing: float
    places: KDTree
    arcs: Arcs

    @property
    def first_place(self) -> int:
        """Number of the first vertex that is a place; all after it are."""
        return len(self.positions) - int(self.places.n)

    @property
    def reach(self) -> float:
        """Greatest length in metres of edges that join a robot's own places with these."""
        return _REACH * self.spacing


@dataclass(frozen=True, eq=False)
class PlacesRoadmap(SharedRoadmap):
    """Corners of a free space, then places; all tangent edges, and short edges between places and corners.

    Parameters
    ----------
    tangents : the tangent graph of its corners alone.
    """

    tangents: VisibilityGraph


def spacing_for(freespace: FreeSpace, separation: float) -> float:
    """Metres between places for robots that keep their centres ``separation`` metres apart.

    Two separations, or more where that would make more than 8,000 places.
    """
    return max(2.0 * separation, math.sqrt(freespace.area / _MOST_LATTICE_PLACES))


def shared_roadmap(roadmap: LocatedRoadmap, separation: float) -> SharedRoadmap:
    """Return a roadmap on which robots may wait at every vertex."""
    spacing = spacing_for(roadmap.freespace, separation)
    tree = KDTree(roadmap.positions)
    arcs = both_ways(roadmap.graph)
    return SharedRoadmap(roadmap.positions, roadmap.graph, roadmap.freespace, roadmap.triangles, spacing, tree, arcs)


def places_roadmap(freespace: FreeSpace, separation: float) -> PlacesRoadmap:
    """Build the roadmap for robots that must keep their centres ``separation`` metres apart.

    With an infinite separation there are no places.
    """
    mesh = freespace.mesh
    tangents = visibility_graph(freespace)
    corners, wedges = tangents.positions, tangents.wedges
    spacing = spacing_for(freespace, separation)
    places, triangles = np.empty((0, 2)), np.empty(0, dtype=np.int64)
    if math.isfinite(spacing) and len(mesh.triangles):
        places, triangles = _places(mesh, spacing, separation)
    positions = np.concatenate([corners, places])
    holders = np.concatenate([mesh.wedges[wedges, 3], triangles])
    pairs = [
        tangents.edges,
        _corner_place_pairs(mesh, wedges, places, triangles, _REACH * spacing),
        len(wedges) + _place_pairs(mesh, places, triangles, _REACH * spacing),
    ]
    edges = np.concatenate(pairs)
    lengths = np.hypot(*(positions[edges[:, 0]] - positions[edges[:, 1]]).T)
    graph = Graph.from_edges(len(positions), edges[lengths > 0], lengths[lengths > 0])
    return PlacesRoadmap(positions, graph, freespace, holders, spacing, KDTree(places), both_ways(graph), tangents)


def _places(mesh: Triangulation, spacing: float, separation: float) -> tuple[Floats, Ints]:
    """Lattice places; dead ends, middles of passages and triangles that no place nearby sees yet; the second lane."""
    candidates = lattice(mesh, spacing).reshape(-1, 2)
    triangles = mesh.locate(candidates)
    places, triangles = candidates[triangles >= 0], triangles[triangles >= 0]
    # dead ends may lie close together, as each may be the one bay in which a robot can wait
    for candidates, near in (
        (_dead_ends(mesh), 0.3),
        (_passages(mesh), 0.6),
        (mesh.vertices[mesh.triangles].mean(axis=1), 0.6),
    ):
        places, triangles = _add_unseen(mesh, places, triangles, candidates, near * spacing)
    lane, holders = _second_lane(mesh, separation)
    places, triangles = np.concatenate([places, lane]), np.concatenate([triangles, holders])
    # a place where free space touches itself would let robots through
    passable = ~mesh.on_pinch(places)
    return places[passable], triangles[passable]


def _passages(mesh: Triangulation) -> Floats:
    """Middles of the edges inside free space."""
    t, k = np.nonzero(mesh.neighbours >= 0)
    half = t < mesh.neighbours[t, k]
    a, b = mesh.triangles[t[half], k[half]], mesh.triangles[t[half], (k[half] + 1) % 3]
    return np.asarray((mesh.vertices[a] + mesh.vertices[b]) / 2)


def _dead_ends(mesh: Triangulation) -> Floats:
    """Vertices at which the free space narrows to a point: the deepest places of bays."""
    narrow = mesh.wedges[mesh.wedge_turns < 0, 0]
    return np.asarray(mesh.vertices[narrow])


def _second_lane(mesh: Triangulation, separation: float) -> tuple[Floats, Ints]:
    """Free places ``separation`` metres off the corners, away from the obstacle, at least as far from each other."""
    wedges = mesh.wedges[mesh.wedge_turns > 0, :3]
    corner, before, after = (mesh.vertices[wedges[:, k]] for k in range(3))
    inward = _unit(before - corner) + _unit(after - corner)
    sharp = np.hypot(*inward.T) > 1e-9
    candidates = corner[sharp] - (1 + 1e-9) * separation * _unit(inward[sharp])
    holders = mesh.locate(candidates)
    candidates, holders = candidates[holders >= 0], holders[holders >= 0]
    kept = _thinned(len(candidates), _pairs_within(candidates, separation))
    return candidates[kept], holders[kept]


def _unit(vectors: Floats) -> Floats:
    return np.asarray(vectors / np.hypot(*vectors.T)[:, None])


def _thinned(n: int, pairs: Ints) -> NDArray[np.bool_]:
    """Whether each of n is kept where of each pair the later one goes, unless the earlier is gone."""
    kept = np.ones(n, dtype=np.bool_)
    for earlier, later in pairs.tolist():
        if kept[earlier]:
            kept[later] = False
    return kept


def _add_unseen(
    mesh: Triangulation, places: Floats, triangles: Ints, candidates: Floats, near: float
) -> tuple[Floats, Ints]:
    """Append the candidates whose nearest place is not both within ``near`` metres and in sight, thinned alike."""
    holders = mesh.locate(candidates)
    alone = holders >= 0
    if len(places) and len(candidates):
        away, nearest = (np.asarray(x) for x in KDTree(places).query(candidates, distance_upper_bound=near))
        doubtful = np.flatnonzero(alone & np.isfinite(away))
        everything, holding = np.concatenate([places, candidates]), np.concatenate([triangles, holders])
        seen = see_each_other(mesh, everything, holding, len(places) + doubtful, nearest[doubtful].astype(np.int64))
        alone[doubtful[seen]] = False
    candidates, holders = candidates[alone], holders[alone]
    pairs = _pairs_within(candidates, near)
    pairs = pairs[see_each_other(mesh, candidates, holders, pairs[:, 0].copy(), pairs[:, 1].copy())]
    kept = _thinned(len(candidates), pairs)
    return np.concatenate([places, candidates[kept]]), np.concatenate([triangles, holders[kept]])


def _pairs_within(points: Floats, reach: float) -> Ints:
    """Pairs i < j of points at most ``reach`` metres apart, ordered by j, then i."""
    if len(points) < 2:
        return np.empty((0, 2), dtype=np.int64)
    pairs = KDTree(points).query_pairs(reach, output_type="ndarray").astype(np.int64)
    return pairs[np.lexsort((pairs[:, 0], pairs[:, 1]))]


def _corner_place_pairs(mesh: Triangulation, wedges: Ints, places: Floats, triangles: Ints, reach: float) -> Ints:
    number = np.full(len(mesh.wedges), -1, dtype=np.int64)
    number[wedges] = np.arange(len(wedges))
    start, seen = see_from(mesh, places, triangles, mesh.wedge_turns >= 0, taut=True, reach=reach)
    place = np.repeat(np.arange(len(places)), np.diff(start))
    away = np.hypot(*(mesh.vertices[mesh.wedges[seen, 0]] - places[place]).T)
    close = away <= reach
    return np.stack([number[seen[close]], len(wedges) + place[close]], axis=1)


def _place_pairs(mesh: Triangulation, places: Floats, triangles: Ints, reach: float) -> Ints:
    pairs = _pairs_within(places, reach)
    return pairs[see_each_other(mesh, places, triangles, pairs[:, 0].copy(), pairs[:, 1].copy())]
