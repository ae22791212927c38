"""Lanes: a roadmap given by the user, one-way or not, with speed limits; and how it is laid into a free space."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
import shapely
from numpy.typing import ArrayLike, NDArray
from scipy.spatial import KDTree

from taut.freespace import FreeSpace
from taut.geometry.points import points_of
from taut.geometry.seeing import see_each_other
from taut.geometry.triangulation import Triangulation
from taut.graph import Graph
from taut.graph.core import Floats, Ints, vertex_pairs
from taut.roadmap.core import Arcs
from taut.roadmap.places import SharedRoadmap, spacing_for

# squared length in cells of the longest step to a neighbour in each number of directions
_FARTHEST = {4: 1, 8: 2, 16: 5, 32: 13}


class LanesError(ValueError):
    """Lanes that are none; ``why`` says what is wrong with the ``vertex`` or ``edge`` of that number, from 0."""

    def __init__(self, what: str, why: str, vertex: int | None = None, edge: int | None = None) -> None:
        self.why = why
        self.vertex = vertex
        self.edge = edge
        super().__init__(f"{what} {why}")


@dataclass(frozen=True, eq=False)
class Lanes:
    """Straight lanes between vertices, known by their arcs; make them with `from_edges`, `grid_lanes` or from a file.

    Parameters
    ----------
    positions : (n, 2) metres.
    arcs : (a, 2) vertices from → to, ascending; a lane in both directions is two arcs.
    limits : (a,) greatest speed on each, metres a second; inf where there is none.
    names : (n,) of the vertices; empty where they are only numbered.
    source : what a plan says that it was made on: the name of the file, if they come from one.
    """

    positions: Floats
    arcs: Ints
    limits: Floats
    names: tuple[str, ...] = ()
    source: str = "lanes"

    @classmethod
    def from_edges(
        cls,
        positions: ArrayLike,
        edges: ArrayLike,
        directed: bool = False,
        limits: ArrayLike | None = None,
        names: tuple[str, ...] | list[str] | None = None,
        source: str = "lanes",
    ) -> Lanes:
        """Build from (n, 2) vertices and (m, 2) lanes between them, in any order.

        Parameters
        ----------
        directed : whether each lane leads from its first vertex to its second only.
        limits : (m,) greatest speed on each, metres a second; inf, or None for all, where there is none.
        names : (n,) unique names of the vertices.

        Raises
        ------
        LanesError
            A ValueError that names the vertex or edge: a vertex out of range, a loop, a lane given twice or without
            length, two vertices with lanes at one place, a position that is not finite, a limit that is not positive,
            a name that is empty or given twice.
        ValueError
            Arrays of the wrong shape, kind or count.

        >>> Lanes.from_edges([(0, 0), (4, 0), (4, 3)], [(0, 1), (1, 2)]).arcs.tolist()
        [[0, 1], [1, 0], [1, 2], [2, 1]]
        """
        xy = np.array(points_of(positions, "positions"), order="C")
        pairs = vertex_pairs(edges, "edges")
        most = np.full(len(pairs), np.inf) if limits is None else np.asarray(limits, dtype=np.float64).reshape(-1)
        called = tuple(names or ())
        _check_vertices(xy, called)
        _check_edges(xy, pairs, most, directed)
        if not directed:
            pairs, most = np.concatenate([pairs, pairs[:, ::-1]]), np.concatenate([most, most])
        order = np.lexsort((pairs[:, 1], pairs[:, 0]))
        return cls(xy, pairs[order], most[order], called, source)

    @property
    def lengths(self) -> Floats:
        """(a,) metres, of the arcs."""
        return _lengths(self.positions, self.arcs)

    def label(self, vertex: int) -> str:
        """Return what to call a vertex in a message."""
        x, y = self.positions[vertex]
        return self.names[vertex] if self.names else f"{vertex} at ({x:g}, {y:g})"


@dataclass(frozen=True, eq=False)
class LanesRoadmap(SharedRoadmap):
    """Lanes laid into a free space, of which those are left that are allowed motions there.

    Vertices keep their numbers; those that are not free, or where free space merely touches itself, have no arcs, and
    their triangle is −1.

    Parameters
    ----------
    closed : (k, 2) vertices i < j of the lanes that are left out, ascending.
    count : how many lanes there were; one in both directions is one.
    """

    closed: Ints
    count: int


def lanes_roadmap(lanes: Lanes, freespace: FreeSpace, separation: float) -> LanesRoadmap:
    """Lay lanes into a free space for robots that keep their centres ``separation`` metres apart.

    A lane may slide along walls and corners. O(n + a) sightings.

    >>> from taut import FreeSpace, Rectangle, Scene
    >>> free = FreeSpace(Scene((0, 0, 6, 4), [Rectangle(2, 1, 1, 1)]), growth=0.5)
    >>> lanes_roadmap(Lanes.from_edges([(1, 1), (5, 1), (1, 3)], [(0, 1), (0, 2)]), free, 1.0).closed.tolist()
    [[0, 1]]
    """
    positions, n = lanes.positions, len(lanes.positions)
    xy, triangles = _located(freespace, positions)
    ends = np.sort(lanes.arcs, axis=1)
    keys, lane = np.unique(ends[:, 0] * n + ends[:, 1], return_inverse=True)
    pairs = np.stack([keys // max(n, 1), keys % max(n, 1)], axis=1).astype(np.int64)
    opened: NDArray[np.bool_] = np.all(triangles[pairs] >= 0, axis=1)
    opened[opened] = _allowed(freespace.mesh, xy, triangles, pairs[opened])
    left = opened[lane]
    arcs, limits = lanes.arcs[left], lanes.limits[left]
    order = np.lexsort((arcs[:, 1], arcs[:, 0]))
    tails, heads = arcs[order].T
    indptr = np.searchsorted(tails, np.arange(n + 1)).astype(np.int64)
    directed = Arcs(indptr, heads.copy(), _lengths(positions, arcs[order]), limits[order])
    skeleton = Graph.from_edges(n, pairs[opened], _lengths(positions, pairs[opened]))
    spacing = spacing_for(freespace, separation)
    return LanesRoadmap(
        positions, skeleton, freespace, triangles, spacing, KDTree(positions), directed, pairs[~opened], len(pairs)
    )


def closed_lanes(lanes: Lanes, roadmap: LanesRoadmap) -> str:
    """Say how many lanes robots of this roadmap's size cannot use; "" if they can use all."""
    if not len(roadmap.closed):
        return ""
    first = " – ".join(lanes.label(v) for v in roadmap.closed[0].tolist())
    return (
        f"{len(roadmap.closed)} of {roadmap.count} lanes are too narrow or blocked for radius + clearance "
        f"{roadmap.freespace.growth:g} m (first: {first})"
    )


def grid_lanes(
    free: ArrayLike, directions: int = 16, spacing: float = 1.0, origin: tuple[float, float] = (0.0, 0.0)
) -> Lanes:
    """Join the centres of free cells of a square grid with their neighbours.

    Steps that pass through the inside of a cell that is not free are left out. Which of the others a disc can use,
    `lanes_roadmap` tells.

    Parameters
    ----------
    free : (rows, columns) whether each cell is free, the lowest row first; vertices are numbered row by row.
    directions : 4, 8, 16 or 32 to which a cell in the open is joined.
    spacing : side of a cell, metres.
    origin : centre of the first cell of the first row, metres.

    Raises
    ------
    ValueError
        Another number of directions, a spacing that is not a positive number, or no table of truth values.

    >>> grid_lanes([[True, True], [False, True]], directions=8).arcs.tolist()
    [[0, 1], [0, 2], [1, 0], [1, 2], [2, 0], [2, 1]]
    """
    if directions not in _FARTHEST:
        raise ValueError(f"directions must be 4, 8, 16 or 32, got {directions!r}")
    if not (spacing > 0 and math.isfinite(spacing)):
        raise ValueError(f"spacing must be a positive number of metres, got {spacing!r}")
    cells = np.asarray(free)
    if cells.ndim != 2 or cells.dtype != np.bool_:
        raise ValueError(f"free must be truth values in an array (rows, columns), got {cells.dtype} {cells.shape}")
    number = np.where(cells, np.cumsum(cells).reshape(cells.shape) - 1, -1)
    rows, columns = np.nonzero(cells)
    positions = np.array(origin, dtype=np.float64) + spacing * np.stack([columns, rows], axis=1)
    pairs = [_step_pairs(number, across, up) for across, up in _steps(directions)]
    return Lanes.from_edges(positions, np.concatenate(pairs))


def united_places(positions: Floats, edges: Ints, directed: bool, limits: Floats) -> tuple[Ints, Ints]:
    """Give the lanes of vertices that lie at one place to the first of them.

    Robots at one place are at one place, whatever it is called: ways stay as long as they were. Lanes between such
    vertices vanish, and of those that become one the fastest is kept.

    Returns
    -------
    edges : (k, 2) what is left of (m, 2).
    kept : (k,) their numbers among those given, ascending.
    """
    n = len(positions)
    _, first, place = np.unique(positions, axis=0, return_index=True, return_inverse=True)
    if len(first) == n:
        return edges, np.arange(len(edges))
    moved = first[place.reshape(-1)][edges]
    ends = moved if directed else np.sort(moved, axis=1)
    fastest_first = np.argsort(-limits, kind="stable")
    _, kept = np.unique((ends[:, 0] * n + ends[:, 1])[fastest_first], return_index=True)
    kept = np.sort(fastest_first[kept])
    kept = kept[(moved[kept, 0] != moved[kept, 1]) | (edges[kept, 0] == edges[kept, 1])]
    return moved[kept].astype(np.int64), kept.astype(np.int64)


def _lengths(positions: Floats, pairs: Ints) -> Floats:
    return np.asarray(np.hypot(*(positions[pairs[:, 0]] - positions[pairs[:, 1]]).T))


def _check_vertices(xy: Floats, names: tuple[str, ...]) -> None:
    bad = np.flatnonzero(~np.isfinite(xy).all(axis=1))
    if len(bad):
        k = int(bad[0])
        raise LanesError(f"vertex {k}", "is not at a finite place; give it two numbers in metres", vertex=k)
    if names and len(names) != len(xy):
        raise ValueError(f"{len(xy)} vertices but {len(names)} names; give each one, or none any")
    seen: set[str] = set()
    for k, name in enumerate(names):
        if not isinstance(name, str) or not name:
            raise LanesError(f"vertex {k}", f"must be named by text that is not empty, got {name!r}", vertex=k)
        if name in seen:
            raise LanesError(f"vertex {k}", f"is named {name}, as another is; every name must be unique", vertex=k)
        seen.add(name)


def _check_edges(xy: Floats, pairs: Ints, limits: Floats, directed: bool) -> None:
    """Raise at the first lane that is none, of each kind of fault in turn."""
    n = len(xy)
    if len(limits) != len(pairs):
        raise ValueError(f"{len(pairs)} edges but {len(limits)} limits; give each one, inf for none")

    def refuse(wrong: NDArray[np.bool_], why: str) -> None:
        if wrong.any():
            k = int(np.argmax(wrong))
            raise LanesError(f"edges[{k}] ({pairs[k, 0]} – {pairs[k, 1]})", why, edge=k)

    inside = f"0 … {n - 1}" if n else "no vertices"
    refuse(
        (pairs.min(axis=1, initial=0) < 0) | (pairs.max(axis=1, initial=-1) >= n),
        f"names a vertex that does not exist; there are {inside}",
    )
    refuse(pairs[:, 0] == pairs[:, 1], "joins a vertex with itself; leave it out")
    with np.errstate(over="ignore"):
        lengths = _lengths(xy, pairs)
    refuse(lengths == 0, "has no length: both vertices lie at one place; make them one")
    refuse(~np.isfinite(lengths), "is too long for any number; use other units")
    bad = np.flatnonzero(~(limits > 0))
    if len(bad):
        refuse(~(limits > 0), f"has the speed limit {limits[bad[0]]:g}; it must be positive (inf for none)")
    ends = pairs if directed else np.sort(pairs, axis=1)
    keys, first, which = np.unique(ends[:, 0] * n + ends[:, 1], return_index=True, return_inverse=True)
    if len(keys) < len(ends):
        again = first[which] != np.arange(len(ends))
        mend = "keep one" if directed else "keep one, as it leads both ways"
        refuse(again, f"is given twice; {mend}")
    used = np.unique(pairs)
    _, first, which = np.unique(xy[used], axis=0, return_index=True, return_inverse=True)
    again = first[which.reshape(-1)] != np.arange(len(used))
    if again.any():
        k = int(np.argmax(again))
        a, b = int(used[first[which.reshape(-1)[k]]]), int(used[k])
        x, y = xy[b]
        raise LanesError(f"vertex {b}", f"lies at ({x:g}, {y:g}) like vertex {a}; make them one", vertex=b)


def _located(freespace: FreeSpace, positions: Floats) -> tuple[Floats, Ints]:
    """The positions, moved into free space where rounding left them outside, and their triangles; −1 for the others."""
    xy, mesh = positions.copy(), freespace.mesh
    triangles = mesh.locate(xy)
    outside = np.flatnonzero(triangles < 0)
    if len(outside) and len(mesh.triangles):
        shapely.prepare(freespace.region)
        # few lie on the very edge, and only these are worth the search for a place inside
        near = outside[shapely.dwithin(freespace.region, shapely.points(xy[outside]), freespace.scene.tol)]
        xy[near], triangles[near] = freespace.anchor(xy[near])
    triangles[mesh.on_pinch(xy)] = -1
    return xy, triangles


def _allowed(mesh: Triangulation, xy: Floats, triangles: Ints, pairs: Ints) -> NDArray[np.bool_]:
    """Whether each of (m, 2) pairs of free places is joined by an allowed straight motion, touching corners or not."""
    out = see_each_other(mesh, xy, triangles, pairs[:, 0].copy(), pairs[:, 1].copy())
    doubtful = np.flatnonzero(~out)
    if not len(doubtful):
        return out
    lines = shapely.linestrings(xy[pairs[doubtful]])
    which, vertex = shapely.STRtree(shapely.points(mesh.vertices)).query(lines, predicate="intersects")
    a, b, at = xy[pairs[doubtful[which], 0]], xy[pairs[doubtful[which], 1]], mesh.vertices[vertex]
    between = (at != a).any(axis=1) & (at != b).any(axis=1)
    which, vertex = which[between], vertex[between]
    along = ((at - a) * (b - a)).sum(axis=1)[between]
    touching = np.unique(which)
    # each line from its first place by way of the corners that it touches to its last: no corner lies inside a leg
    n = len(xy)
    line = np.concatenate([touching, which, touching])
    stop = np.concatenate([pairs[doubtful[touching], 0], n + vertex, pairs[doubtful[touching], 1]])
    place = np.concatenate([np.full(len(touching), -np.inf), along, np.full(len(touching), np.inf)])
    order = np.lexsort((place, line))
    line, stop = line[order], stop[order].astype(np.int64)
    legs = np.flatnonzero(line[1:] == line[:-1])
    holders = mesh.wedges[mesh.vertex_wedges[mesh.vertex_start[:-1]], 3]
    points, holding = np.concatenate([xy, mesh.vertices]), np.concatenate([triangles, holders])
    free = see_each_other(mesh, points, holding, stop[legs], stop[legs + 1])
    # where free space touches itself a line may leave on the other side than it came
    pinched = np.flatnonzero(np.diff(mesh.vertex_start) > 1)
    blocked = np.concatenate([line[legs[~free]], which[np.isin(vertex, pinched)]])
    out[doubtful[np.setdiff1d(touching, blocked)]] = True
    return out


def _steps(directions: int) -> list[tuple[int, int]]:
    """Columns and rows of the steps in a number of directions, of each pair of opposite ones the first."""
    reach = range(-3, 4)
    return [
        (across, up)
        for up in reach
        for across in reach
        if across**2 + up**2 <= _FARTHEST[directions] and math.gcd(across, up) == 1 and (up, across) > (0, 0)
    ]


def _step_pairs(number: Ints, across: int, up: int) -> Ints:
    """Pairs of cells a step apart of which all that the step passes through are numbered; −1 is no free cell."""
    rows, columns = number.shape
    left, right = max(-across, 0), columns - max(across, 0)
    if right <= left or rows <= up:
        return np.empty((0, 2), dtype=np.int64)

    def cells(c: int, r: int) -> Ints:
        return number[r : r + rows - up, left + c : right + c]

    between = [
        cells(c, r) >= 0
        for r in range(up + 1)
        for c in range(min(across, 0), max(across, 0) + 1)
        # whether the step has a point in common with the inside of that cell
        if 2 * abs(across * r - up * c) < abs(across) + up
    ]
    free = np.all(between, axis=0)
    return np.stack([cells(0, 0)[free], cells(across, up)[free]], axis=1)
