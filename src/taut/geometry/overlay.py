"""Union and difference of many polygons that neither lose faces nor move vertices without a word.

GEOS' plain floating-point overlay is fast and keeps the coordinates of its input, but where edges nearly coincide it
may fail: with an exception, by moving vertices a little more than our tolerance, or by dropping whole faces in
silence. All three are looked for here, and answered by snap rounding (20 to 40 times slower) on a grid finer than the
tolerance. What is thinner than the grid would vanish there, and a wall with it; so it is made half a tolerance thick.
"""

from __future__ import annotations

import math
from typing import Any, TypeAlias

import numpy as np
import shapely
from numpy.typing import NDArray
from scipy.sparse import coo_array
from scipy.sparse.csgraph import connected_components

FloatArray: TypeAlias = NDArray[np.float64]
IntArray: TypeAlias = NDArray[np.intp]
BoolArray: TypeAlias = NDArray[np.bool_]
Shapes: TypeAlias = NDArray[np.object_]

FINE = 2.0**14
"""Tolerances: GEOS may move vertices by so many, and what is not thinner it cannot lose."""

_SHARP = 0.2
"""Radians: at a sharper corner, rounding to the grid may lose a tip longer than the tolerance."""

# GEOS works with numbers near underflow and leaves the flags that NumPy would warn about
_quiet = np.errstate(divide="ignore", invalid="ignore", over="ignore", under="ignore")


@_quiet
def remainder(room: Any, taken: Shapes, tol: float, thin: Shapes | None = None) -> Any:
    """Return a polygon without the pieces taken from it.

    Parameters
    ----------
    room : a valid polygon.
    taken : (n,) valid polygons; they may overlap and touch each other and the room in any way.
    tol : metres; what is returned differs from the exact remainder by less.
    thin : those of the pieces that may be thinner than `FINE` tolerances, and are lost nowhere all the same.

    Returns
    -------
    Polygon or MultiPolygon
        Valid; vertices of the input keep their coordinates bit for bit unless plain overlay fails.
    """
    alone = _alone(room, taken, tol)
    rest = _without(room, taken[~alone], tol, taken[:0] if thin is None else thin) if not alone.all() else room
    return _with_holes(rest, taken[alone]) if alone.any() else rest


def _alone(room: Any, taken: Shapes, tol: float) -> BoolArray:
    """Mark the pieces without holes that lie in the room, farther than ``tol`` from all else: holes as they are.

    Edges that cross by less than rounding may be told not to intersect.
    """
    i = shapely.STRtree(taken).query(taken, predicate="dwithin", distance=tol)[0]
    alone: BoolArray = (np.bincount(i, minlength=len(taken)) == 1) & (shapely.get_num_interior_rings(taken) == 0)
    shapely.prepare(room)
    alone[alone] = shapely.contains_properly(room, taken[alone])
    alone[alone] = ~shapely.dwithin(shapely.boundary(room), taken[alone], tol)
    return alone


def _with_holes(rest: Any, pieces: Shapes) -> Any:
    """Return (multi)polygons with further holes, each in the interior of one of them and apart from all else."""
    parts = shapely.get_parts(rest)
    rings = shapely.get_exterior_ring(pieces)
    home = np.zeros(len(pieces), dtype=np.intp)
    if len(parts) > 1:
        within = shapely.get_point(rings, 0)
        piece, home_of = shapely.STRtree(parts).query(within, predicate="intersects")
        home[piece] = home_of
    out = []
    for k, part in enumerate(parts):
        own = rings[home == k]
        holes = np.append(shapely.get_rings(part)[1:], own)
        out.append(shapely.polygons(shapely.get_exterior_ring(part), holes) if len(own) else part)
    return out[0] if len(out) == 1 else shapely.multipolygons(out)


def _without(room: Any, taken: Shapes, tol: float, thin: Shapes) -> Any:
    """Return a polygon without pieces that meet each other or its boundary, by overlay; `thin` as in `remainder`."""
    grid = _grid(tol)
    narrow = np.append(thin, shapely.get_parts(room))
    union, rounded = _joined_clusters(taken, tol)
    if not rounded:
        try:
            rest = shapely.difference(room, union)
            balance = shapely.area(room) - shapely.area(rest) - shapely.area(shapely.intersection(room, union))
            balanced = abs(balance) <= tol / 256 * (shapely.length(room) + shapely.length(union))
            sound = balanced and _drawn_from(rest, taken, room, tol) and not _reached(rest, taken, tol).any()
            if sound and not _passes(rest, narrow, tol):
                return rest
        except shapely.GEOSException:
            pass
    if not (rounded and shapely.is_valid(union)):
        union = shapely.union_all(taken, grid_size=grid)
    strips = _thickened(narrow, tol)
    if strips.size:
        union = shapely.union_all(np.append(strips, union), grid_size=grid)
    # one edge on the grid and its neighbour off it would open a seam between them: now everything goes on the grid
    return shapely.difference(room, union, grid_size=grid)


@_quiet
def united(pieces: Shapes, tol: float, thin: Shapes | None = None) -> Any:
    """Return the union of (n,) valid polygons, n ≥ 1, as a MultiPolygon.

    Coordinates are kept as in `remainder`, and of the pieces ``thin`` nothing is lost either.
    """
    narrow = pieces[:0] if thin is None else thin
    union, rounded = _joined_clusters(pieces, tol)
    if not rounded and _drawn_from(union, pieces, None, tol):
        outside = shapely.distance(union, shapely.point_on_surface(pieces)) > tol / 64
        if not outside.any() and not _passes(union, narrow, tol):
            return union
    strips = _thickened(narrow, tol)
    return _multipolygon(shapely.union_all(np.append(pieces, strips), grid_size=_grid(tol)))


def _joined_clusters(pieces: Shapes, tol: float) -> tuple[Any, bool]:
    """Return the union of pieces, and whether a part of it had to be rounded to a grid.

    Clusters of pieces that meet are joined two by two, neighbours first, all clusters at once.
    """
    i, j = shapely.STRtree(pieces).query(pieces, predicate="intersects")
    links = coo_array((np.ones(len(i), dtype=np.bool_), (i, j)), shape=(len(pieces), len(pieces)))
    group = connected_components(links, directed=False)[1].astype(np.intp)
    order = np.lexsort((_along_a_curve(pieces), group))
    joined, cluster = pieces[order], group[order]
    failed = np.zeros(len(pieces), dtype=np.bool_)
    while len(second := np.flatnonzero(_rank(cluster) % 2)):
        joined[second - 1], wrong = _joined(joined[second - 1], joined[second], tol)
        failed[cluster[second[wrong]]] = True
        going = ~failed[cluster]
        going[second] = False
        joined, cluster = joined[going], cluster[going]
    rounded = [shapely.union_all(pieces[group == k], grid_size=_grid(tol)) for k in np.flatnonzero(failed)]
    return _multipolygon(np.append(joined, np.array(rounded, dtype=object))), len(rounded) > 0


def _joined(a: Shapes, b: Shapes, tol: float) -> tuple[Shapes, BoolArray]:
    """Return the union of each pair, and which of them are wrong.

    Where edges nearly coincide GEOS may lose whole faces without a word. Whichever label of a face is wrong, the areas
    of union and intersection no longer add up to those of the two.
    """
    try:
        union, common = shapely.union(a, b), shapely.intersection(a, b)
    except shapely.GEOSException:
        return a, np.ones(len(a), dtype=np.bool_)
    balance = shapely.area(a) + shapely.area(b) - shapely.area(union) - shapely.area(common)
    sound = np.abs(balance) <= tol / 256 * (shapely.length(a) + shapely.length(b))
    return union, ~(sound & np.isin(shapely.get_type_id(union), (3, 6)))


def _thickened(polygons: Shapes, tol: float) -> Shapes:
    """Return strips, tol / 2 wide, along the sides of polygons that are nearer than that to another side."""
    a, b = _slender(polygons, tol / 2)
    along = tol / 4 * (b - a) / np.hypot(*(b - a).T)[:, None]
    across = np.stack([-along[:, 1], along[:, 0]], axis=1)
    corners = [a - along - across, b + along - across, b + along + across, a - along + across]
    strips: Shapes = shapely.polygons(np.stack(corners, axis=1))
    return strips


def _slender(polygons: Shapes, width: float) -> tuple[FloatArray, FloatArray]:
    """Return starts and ends of the sides so near to another side of their polygon, or at a sharp corner of it."""
    start, end, owner = _edges(polygons)
    chosen = np.zeros(len(start), dtype=np.bool_)
    doubtful = np.flatnonzero((shapely.minimum_clearance(polygons) <= width)[owner])
    if len(doubtful):
        sides = shapely.linestrings(np.stack([start[doubtful], end[doubtful]], axis=1))
        i, j = doubtful[shapely.STRtree(sides).query(sides, "dwithin", width)]
        apart = (start[i] != end[j]).any(axis=1) & (end[i] != start[j]).any(axis=1)
        chosen[i[apart & (i != j) & (owner[i] == owner[j])]] = True
    last = np.cumsum(shapely.get_num_coordinates(shapely.get_rings(polygons)) - 1) - 1
    following = np.arange(1, len(start) + 1)
    following[last] = np.append(0, last[:-1] + 1)
    way = end - start
    way /= np.hypot(way[:, 0], way[:, 1])[:, None]
    sharp = np.flatnonzero((way * way[following]).sum(axis=1) < -math.cos(_SHARP))
    chosen[sharp] = chosen[following[sharp]] = True
    return start[chosen], end[chosen]


def _passes(result: Any, polygons: Shapes, tol: float) -> bool:
    """Whether an edge of the result passes a thin part of a polygon, which then must have been lost there."""
    starts, ends = _slender(polygons, FINE * tol)
    if not len(starts):
        return False
    a, b, _ = _edges(shapely.get_parts(result))
    edges = shapely.linestrings(np.stack([a, b], axis=1))
    sides = shapely.linestrings(np.stack([starts, ends], axis=1))
    i, j = shapely.STRtree(sides).query(edges, "intersects")
    away = np.ones(len(i), dtype=np.bool_)
    for at, line in ((a[i], sides[j]), (b[i], sides[j]), (starts[j], edges[i]), (ends[j], edges[i])):
        away &= shapely.distance(shapely.points(at), line) > tol / 64
    return bool(away.any())


def _multipolygon(shapes: Shapes) -> Any:
    parts = shapely.get_parts(shapes)
    return shapely.multipolygons(parts[shapely.get_type_id(parts) == shapely.GeometryType.POLYGON])


def _rank(cluster: IntArray) -> IntArray:
    """Return the place of each entry among the equal entries before and after it; `cluster` is ascending."""
    first = np.flatnonzero(np.diff(cluster, prepend=-1))
    return np.arange(len(cluster)) - np.repeat(first, np.diff(first, append=len(cluster)))


def _along_a_curve(pieces: Shapes) -> NDArray[np.uint64]:
    """Return numbers that are close for pieces that are close: the bits of their centres' coordinates, interleaved."""
    low, high = np.hsplit(shapely.bounds(pieces), 2)
    centre = (low + high) / 2
    centre -= centre.min(axis=0)
    bits = (centre / max(centre.max(), np.finfo(float).tiny) * 65535).astype(np.uint64)
    for shift, mask in ((8, 0x00FF00FF), (4, 0x0F0F0F0F), (2, 0x33333333), (1, 0x55555555)):
        bits = (bits | (bits << np.uint64(shift))) & np.uint64(mask)
    code: NDArray[np.uint64] = bits[:, 0] | (bits[:, 1] << np.uint64(1))
    return code


def _grid(tol: float) -> float:
    return float(2.0 ** math.floor(math.log2(tol / 8)))


def _drawn_from(result: Any, pieces: Shapes, room: Any, tol: float) -> bool:
    """Whether a result is valid, its edges run along the boundaries of pieces or room, and none through a piece.

    Where plain overlay fails, GEOS silently moves vertices by up to 1e-8 of the coordinates. A piece that has an edge
    of the result inside it was cut in two wrongly; one without is inside the result or outside of it as a whole.
    """
    if not shapely.is_valid(result):
        return False
    sources = pieces if room is None else np.append(pieces, room)
    start, end, _ = _edges(shapely.get_parts(result))
    *known, owner = _edges(sources)
    known_keys, keys = _keys(*known), _keys(start, end)
    order = np.argsort(known_keys)
    place = order[np.searchsorted(known_keys[order[:-1]], keys)]
    cut = known_keys[place] != keys
    middle = (start + end) / 2

    if cut.any():
        probes = shapely.points(np.concatenate([start[cut], end[cut], middle[cut]]))
        probe, source = shapely.STRtree(shapely.boundary(sources)).query(probes, "dwithin", tol / 64)
        edge = probe % np.count_nonzero(cut)
        pair, hits = np.unique(edge * len(sources) + source, return_counts=True)
        if len(np.unique(pair[hits == 3] // len(sources))) < np.count_nonzero(cut):
            return False

    edge, piece = shapely.STRtree(pieces).query(shapely.points(middle))
    other = cut[edge] | (owner[place[edge]] != piece)
    edge, piece = edge[other], piece[other]
    inside = shapely.contains_xy(pieces[piece], middle[edge])
    depth = shapely.distance(shapely.points(middle[edge[inside]]), shapely.boundary(pieces[piece[inside]]))
    return not (depth > tol / 64).any()


def _reached(region: Any, pieces: Shapes, tol: float) -> BoolArray:
    """Return, for pieces without an edge of the region inside them, whether the region covers them."""
    shapely.prepare(region)
    within = shapely.point_on_surface(pieces)
    covered: BoolArray = shapely.contains(region, within)
    covered[covered] = shapely.distance(shapely.boundary(region), within[covered]) > tol / 64
    return covered


def _edges(polygons: Shapes) -> tuple[FloatArray, FloatArray, IntArray]:
    """Return the starts and ends of all edges, and the number of the polygon that each belongs to."""
    rings, polygon = shapely.get_rings(polygons, return_index=True)
    at, ring = shapely.get_coordinates(rings, return_index=True)
    inside = ring[1:] == ring[:-1]
    return at[:-1][inside], at[1:][inside], polygon[ring[1:][inside]]


def _keys(start: FloatArray, end: FloatArray) -> NDArray[np.uint64]:
    """Return 64-bit numbers that are equal for equal edges in either direction."""

    def mixed(at: FloatArray) -> NDArray[np.uint64]:
        x, y = ((at[:, k] + 0.0).view(np.uint64) for k in (0, 1))
        key = x * np.uint64(0x9E3779B97F4A7C15) + y * np.uint64(0xC2B2AE3D27D4EB4F)
        key ^= key >> np.uint64(29)
        key *= np.uint64(0xBF58476D1CE4E5B9)
        key ^= key >> np.uint64(32)
        return key

    return mixed(start) + mixed(end)
