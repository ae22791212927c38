"""A robot's own addition to the shared roadmap: its ends, stops along its shortest route, ways round others' ends."""

from __future__ import annotations

import math
from dataclasses import dataclass
from itertools import pairwise

import numpy as np
from scipy.spatial import KDTree

from taut.geometry.seeing import see_each_other
from taut.roadmap import SharedRoadmap
from taut.route import Route
from taut.scene import FloatArray, Robot
from taut.team._conflict_kernels import Floats, Ints

# 20 neighbours made the search a third slower and the plans of halls and warehouses less than 0.2 % shorter
_NEIGHBOURS = 8
# own vertices are dense along the route: this share of the reach joins each with the next few
_OWN_REACH = 0.7
_RING = 8


@dataclass(frozen=True, eq=False)
class OwnRoadmap:
    """Vertices and edges that one robot has beyond the shared roadmap.

    Parameters
    ----------
    positions : (k, 2) metres.
    ends : vertices that are its start and its goal, of the shared ones or of these.
    edges : (e, 2) over the shared vertices 0 … n − 1 and these, n … n + k − 1.
    lengths : (e,) metres.
    pinched : whether free space touches itself at the start, and at the goal.
    """

    positions: Floats
    ends: tuple[int, int]
    edges: Ints
    lengths: Floats
    pinched: tuple[bool, bool]

    def adjacency(self, shared: int) -> tuple[Ints, Ints, Floats]:
        """CSR over ``shared`` + k vertices."""
        n = shared + len(self.positions)
        tail = np.concatenate([self.edges[:, 0], self.edges[:, 1]])
        head = np.concatenate([self.edges[:, 1], self.edges[:, 0]])
        order = np.argsort(tail, kind="stable")
        indptr = np.zeros(n + 1, dtype=np.int64)
        np.cumsum(np.bincount(tail, minlength=n), out=indptr[1:])
        return indptr, head[order], np.concatenate([self.lengths, self.lengths])[order]


def own_roadmap(
    shared: SharedRoadmap,
    robot: Robot,
    joined: tuple[Ints, Ints],
    routes: list[Route],
    around: Floats,
    distances: Floats,
    stations: Floats,
) -> OwnRoadmap:
    """Extend the shared roadmap for the robot that has the given routes.

    Parameters
    ----------
    joined : shared vertices with which its start is joined in any case, and those of its goal.
    routes : ways from its start to its goal, the shortest first; it may rest anywhere along them, a spacing apart.
    around : (j, 2) places of others that it may have to go round.
    distances : (j,) metres that it keeps from each.
    stations : (s, 2) free places besides; straight ways lead between all of them, and its ends, that see each other.
    """
    mesh = shared.freespace.mesh
    n = len(shared.positions)
    ends = np.array([robot.start, robot.goal])
    points: list[FloatArray] = [ends]
    chains: list[list[int]] = []
    count = 2
    for route in routes:
        stops = _stops(route, shared.spacing)
        points.append(stops)
        chains.append([0, *range(count, count + len(stops)), 1])
        count += len(stops)
    first_station = count
    points.append(stations)
    count += len(stations)
    points.append(_rings(around, distances))
    xy, triangles = shared.freespace.anchor(np.concatenate(points[:-1]))
    ring_triangles = mesh.locate(points[-1])
    free = ring_triangles >= 0
    xy = np.concatenate([xy, points[-1][free]])
    triangles = np.concatenate([triangles, ring_triangles[free]])

    pairs = [np.array([(a + n, b + n) for chain in chains for a, b in pairwise(chain)])]
    pairs += [np.stack([vertices, np.full_like(vertices, n + k)], axis=1) for k, vertices in enumerate(joined)]
    pairs.append(_near(shared, xy, triangles))
    pairs.append(n + _in_sight(shared, xy, triangles, np.arange(first_station, count)))
    edges = np.sort(np.concatenate(pairs), axis=1)
    total = n + len(xy)
    keys = np.unique(edges[:, 0] * total + edges[:, 1])
    edges = np.stack([keys // total, keys % total], axis=1).astype(np.int64)
    xy[:2] = ends
    everything = np.concatenate([shared.positions, xy])
    lengths = np.hypot(*(everything[edges[:, 0]] - everything[edges[:, 1]]).T)
    at_start, at_goal = mesh.on_pinch(xy[:2]).tolist()
    return OwnRoadmap(xy, (n, n + 1), edges[lengths > 0], lengths[lengths > 0], (at_start, at_goal))


def _stops(route: Route, spacing: float) -> FloatArray:
    """The bends of a route, and places in between at most ``spacing`` apart; without its ends."""
    out = []
    for a, b in zip(route.points[:-1], route.points[1:], strict=True):
        length = math.hypot(*(b - a))
        pieces = max(1, math.ceil(length / spacing)) if math.isfinite(spacing) else 1
        out.append(a + (b - a) * (np.arange(pieces) / pieces)[:, None])
    return np.concatenate(out)[1:] if out else np.empty((0, 2))


def _rings(centres: Floats, distances: Floats) -> Floats:
    """Corners of an octagon about each centre whose sides keep the distance."""
    angle = 2 * math.pi * (np.arange(_RING) + 0.5) / _RING
    unit = np.stack([np.cos(angle), np.sin(angle)], axis=1) * ((1 + 1e-9) / math.cos(math.pi / _RING))
    return (centres[:, None] + distances[:, None, None] * unit).reshape(-1, 2)


def _in_sight(shared: SharedRoadmap, xy: Floats, triangles: Ints, stations: Ints) -> Ints:
    """Pairs of own vertices that see each other, of the ends and the stations; none where free space touches itself."""
    mesh = shared.freespace.mesh
    chosen = np.concatenate([[0, 1], stations]) if len(stations) else stations
    chosen = chosen[~mesh.on_pinch(xy[chosen])].astype(np.int64)
    a, b = (chosen[k] for k in np.triu_indices(len(chosen), 1))
    seen = see_each_other(mesh, xy, triangles, a, b)
    return np.stack([a[seen], b[seen]], axis=1)


def _near(shared: SharedRoadmap, xy: Floats, triangles: Ints) -> Ints:
    """Pairs of own vertices with places nearby that they see, and with each other."""
    if not math.isfinite(shared.spacing):
        return np.empty((0, 2), dtype=np.int64)
    n, mesh = len(shared.positions), shared.freespace.mesh
    reach = shared.reach
    nearest = shared.places.query(xy, k=_NEIGHBOURS, distance_upper_bound=reach)
    away, place = (np.asarray(x) for x in nearest)
    # a bend where free space touches itself belongs to its route alone: other edges would let the robot through
    own, column = np.nonzero(np.isfinite(away) & ~mesh.on_pinch(xy)[:, None])
    pairs = [np.stack([place[own, column] + shared.first_place, n + own], axis=1).astype(np.int64)]
    each_other = KDTree(xy).query_pairs(_OWN_REACH * reach, output_type="ndarray").astype(np.int64)
    pairs.append(n + each_other[~mesh.on_pinch(xy)[each_other].any(axis=1)])
    candidates = np.concatenate(pairs)
    everything = np.concatenate([shared.positions, xy])
    holders = np.concatenate([shared.triangles, triangles])
    # seen from the robot's own vertex, which may stand on a boundary
    a, b = np.ascontiguousarray(candidates[:, 1]), np.ascontiguousarray(candidates[:, 0])
    return candidates[see_each_other(mesh, everything, holders, a, b)]
