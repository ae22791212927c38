"""Rings that touch themselves, and polygons with holes, as simple rings; no corner is moved or invented."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TypeAlias

import numpy as np
import shapely

Corner: TypeAlias = tuple[float, float]
Ring: TypeAlias = list[Corner]
Edge: TypeAlias = tuple[Corner, Corner]


def region_of(ring: Ring, holes: Sequence[Ring] = ()) -> shapely.Geometry | None:
    """Return the region of a ring that may touch itself but not cross itself, as valid polygons.

    None if a ring crosses or runs back over itself or encloses nothing, or a hole is not inside the ring.
    """
    region = _untangled(ring)
    for hole in holes:
        inner = _untangled(hole)
        if region is None or inner is None or not shapely.covers(region, inner):
            return None
        region = without(region, inner)
    return region


def without(region: shapely.Geometry, other: shapely.Geometry) -> shapely.Geometry | None:
    """Return region − other, None if that is empty or has a corner which neither has."""
    try:
        return _with_corners_of(shapely.difference(region, other), (region, other))
    except shapely.GEOSException:
        return None


def union(regions: Sequence[shapely.Geometry]) -> shapely.Geometry | None:
    """Return the union of regions that do not overlap, None if they do."""
    try:
        whole = shapely.union_all(np.array(regions, dtype=object))
    except shapely.GEOSException:
        return None
    if not np.isclose(sum(region.area for region in regions), whole.area, rtol=1e-9, atol=0.0):
        return None
    return _with_corners_of(whole, regions)


def simple_rings(region: shapely.Geometry) -> list[Ring] | None:
    """Return simple rings whose union is the region; None if its holes cannot be cut open exactly."""
    rings: list[Ring] = []
    for polygon in polygons(region):
        pieces = _cut_open(polygon) if polygon.interiors else [outline(polygon)]
        if pieces is None:
            return None
        rings += pieces
    return rings


def polygons(region: shapely.Geometry) -> list[shapely.Polygon]:
    """Return the polygons of a region."""
    parts = shapely.get_parts(shapely.get_parts(region))
    return [part for part in parts if isinstance(part, shapely.Polygon) and not part.is_empty]


def outline(polygon: shapely.Polygon) -> Ring:
    """Return the outer ring, not closed by repetition."""
    return _corners(polygon.exterior)


def is_simple(ring: Ring) -> bool:
    """Whether the ring neither crosses nor touches itself and encloses something."""
    return len(ring) >= 3 and bool(shapely.Polygon(ring).is_valid)


def _untangled(ring: Ring) -> shapely.Geometry | None:
    polygon = shapely.Polygon(ring)
    if polygon.is_valid:
        return polygon
    try:
        region = shapely.make_valid(polygon)
    except shapely.GEOSException:
        return None
    # what a ring winds round twice, or once each way, is made valid too, but with another area
    if not np.isclose(_enclosed(ring), region.area, rtol=1e-9, atol=0.0):
        return None
    if any(not isinstance(part, shapely.Polygon) for part in shapely.get_parts(shapely.get_parts(region))):
        return None  # it runs back over itself
    return _with_corners_of(region, (polygon,))


def _with_corners_of(region: shapely.Geometry, sources: Sequence[shapely.Geometry]) -> shapely.Geometry | None:
    known = {tuple(corner) for source in sources for corner in shapely.get_coordinates(source).tolist()}
    found = {tuple(corner) for corner in shapely.get_coordinates(region).tolist()}
    return region if found <= known and region.area > 0.0 else None


def _enclosed(ring: Ring) -> float:
    x, y = (np.array(ring) - ring[0]).T
    with np.errstate(over="ignore", invalid="ignore"):
        return abs(float((x * np.roll(y, -1) - np.roll(x, -1) * y).sum())) / 2


def _corners(ring: shapely.LinearRing) -> Ring:
    return [(x, y) for x, y in shapely.get_coordinates(ring)[:-1].tolist()]


def _cut_open(polygon: shapely.Polygon) -> list[Ring] | None:
    """Triangulate, and merge triangles into discs for as long as they stay discs: few pieces with exact seams."""
    polygon = shapely.remove_repeated_points(polygon)
    try:
        geometries = shapely.get_parts(shapely.constrained_delaunay_triangles(polygon))
    except shapely.GEOSException:
        return None
    triangles = [_counter_clockwise(outline(geometry)) for geometry in geometries]
    owner = {edge: k for k, triangle in enumerate(triangles) for edge in _edges(triangle)}
    if not _tile(triangles, owner, polygon):
        return None
    taken = [False] * len(triangles)
    return [_grown(seed, triangles, owner, taken) for seed in range(len(triangles)) if not taken[seed]]


def _tile(triangles: Sequence[Ring], owner: dict[Edge, int], polygon: shapely.Polygon) -> bool:
    """Whether the triangles cover the polygon once: what no two of them share is exactly its boundary."""
    if len(owner) != 3 * len(triangles):
        return False
    border = {frozenset(edge) for edge in owner if edge[::-1] not in owner}
    rings = (polygon.exterior, *polygon.interiors)
    return border == {frozenset(edge) for ring in rings for edge in _edges(_corners(ring))}


def _grown(seed: int, triangles: Sequence[Ring], owner: dict[Edge, int], taken: list[bool]) -> Ring:
    """Return the ring round a disc of triangles, grown from one; marks them as taken."""
    taken[seed] = True
    after = dict(_edges(triangles[seed]))  # corner of the ring → the next
    waiting = list(after.items())
    while waiting:
        a, b = waiting.pop()
        k = owner.get((b, a))
        if after.get(a) != b or k is None or taken[k]:
            continue
        c = next(corner for corner in triangles[k] if corner not in (a, b))
        if c not in after:
            after[a], after[c] = c, b
            waiting += [(a, c), (c, b)]
        elif after[b] == c:  # the triangle fills the notch at b
            after[a] = c
            del after[b]
            waiting.append((a, c))
        elif after[c] == a:  # the triangle fills the notch at a
            after[c] = b
            del after[a]
            waiting.append((c, b))
        else:
            continue  # the ring would touch itself at c
        taken[k] = True
    first = next(iter(after))
    ring = [first]
    while (corner := after[ring[-1]]) != first:
        ring.append(corner)
    return ring


def _counter_clockwise(triangle: Ring) -> Ring:
    return triangle if shapely.is_ccw(shapely.LinearRing(triangle)) else triangle[::-1]


def _edges(ring: Ring) -> list[Edge]:
    return list(zip(ring, [*ring[1:], ring[0]], strict=True))
