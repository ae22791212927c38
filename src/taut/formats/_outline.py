"""One simple workspace and simple obstacles from areas with holes, courtyards and rings that touch themselves."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
import shapely

from taut.formats import _rings
from taut.formats._document import Place
from taut.formats._rings import Ring

Entry = tuple[dict[str, Any], Place]


@dataclass(frozen=True)
class Area:
    """Polygons as one feature gives them: of each the outer ring, then the holes; none closed by repetition."""

    name: str
    polygons: list[list[Ring]]
    place: Place


class Unsplittable(Exception):
    """An area that cannot be said in simple rings without moving a corner."""

    def __init__(self, message: str, place: Place) -> None:
        self.place = place
        super().__init__(message)


def outline_and_obstacles(boundaries: Sequence[Area], obstacles: Sequence[Area | Entry]) -> tuple[Ring, list[Entry]]:
    """Return the workspace and the obstacle entries, those of the file first and in its order.

    Raises
    ------
    Unsplittable
        Boundaries that overlap, holes that cross their ring, rings with holes that cross themselves.
    """
    outlines = [(rings, area.place) for area in boundaries for rings in area.polygons]
    if len(outlines) == 1 and _is_as_good_as_simple(outlines[0][0]):
        outline = outlines[0][0][0]
        pockets: list[Ring] = []
        courtyards: list[shapely.Geometry] = []
    else:
        regions = [_region(rings, place) for rings, place in outlines]
        yards = _courtyards(regions, obstacles)
        outline, pockets = _workspace([r for r, yard in zip(regions, yards, strict=True) if not yard], outlines[0][1])
        courtyards = [r for r, yard in zip(regions, yards, strict=True) if yard]
    tree = shapely.STRtree(courtyards)
    entries: list[Entry] = []
    for obstacle in obstacles:
        if not isinstance(obstacle, Area):
            entries.append(obstacle)
            continue
        rings = [ring for polygon in obstacle.polygons for ring in _split(obstacle, polygon, tree)]
        for k, ring in enumerate(rings):
            name = f"{obstacle.name} {k + 1}" if obstacle.name and len(rings) > 1 else obstacle.name
            entry = {"name": name} if name else {}
            entries.append(({**entry, "polygon": [list(corner) for corner in ring]}, obstacle.place))
    entries += [({"polygon": [list(corner) for corner in ring]}, outlines[0][1]) for ring in pockets]
    return outline, entries


def _is_as_good_as_simple(rings: list[Ring]) -> bool:
    """Whether one ring is all there is to say: it is simple, or wrong in a way that validation places and names."""
    return len(rings) == 1 and (_rings.is_simple(rings[0]) or _rings.region_of(rings[0]) is None)


def _region(rings: list[Ring], place: Place) -> shapely.Geometry:
    region = _rings.region_of(rings[0], rings[1:])
    if region is None:
        raise Unsplittable("a boundary whose rings cross themselves or each other, or enclose nothing", place)
    return region


def _courtyards(regions: Sequence[shapely.Geometry], obstacles: Sequence[Area | Entry]) -> list[bool]:
    """Which boundaries lie inside an obstacle that lies inside another boundary."""
    if len(regions) == 1:
        return [False]
    shells = [shapely.union_all([shapely.Polygon(_rings.outline(p)) for p in _rings.polygons(r)]) for r in regions]
    polygons = [rings for area in obstacles if isinstance(area, Area) for rings in area.polygons]
    solid = [filled for rings in polygons if (filled := _rings.region_of(rings[0])) is not None]
    if not solid:
        return [False] * len(regions)
    inner, around = shapely.STRtree(solid).query(np.array(regions, dtype=object), predicate="within")
    held, holder = shapely.STRtree(shells).query(np.array(solid, dtype=object), predicate="within")
    holders: dict[int, set[int]] = {}
    for obstacle, boundary in zip(held.tolist(), holder.tolist(), strict=True):
        holders.setdefault(obstacle, set()).add(boundary)
    out = [False] * len(regions)
    for boundary, obstacle in zip(inner.tolist(), around.tolist(), strict=True):
        out[boundary] |= bool(holders.get(obstacle, set()) - {boundary})
    return out


def _workspace(regions: Sequence[shapely.Geometry], place: Place) -> tuple[Ring, list[Ring]]:
    """Return the outline of the regions and the obstacles that make it exactly the regions."""
    whole = _rings.union(regions) if regions else None
    if whole is None:
        raise Unsplittable("the boundaries overlap or cross; draw them as one", place)
    polygons = _rings.polygons(whole)
    if len(polygons) == 1:
        outline = _rings.outline(polygons[0])
        return outline, [_rings.outline(shapely.Polygon(hole)) for hole in polygons[0].interiors]
    box = shapely.box(*shapely.bounds(whole))
    rest = _rings.without(box, whole)
    pockets = None if rest is None else _rings.simple_rings(rest)
    if pockets is None:
        raise Unsplittable("the boundaries cannot be joined into one map exactly; draw them as one", place)
    return _rings.outline(box), pockets


def _split(area: Area, polygon: list[Ring], courtyards: shapely.STRtree) -> list[Ring]:
    """Return the simple rings of one polygon of an area, less the courtyards in it."""
    simple = len(polygon) == 1 and _rings.is_simple(polygon[0])
    if simple and not len(courtyards):
        return polygon
    region = _rings.region_of(polygon[0], polygon[1:])
    if region is None and len(polygon) == 1:
        return polygon  # it crosses itself: validation says where
    who = f"obstacle {area.name}".strip()
    if region is None:
        raise Unsplittable(f"{who}: its holes cross its ring or each other; draw it as several polygons", area.place)
    inside = courtyards.geometries[courtyards.query(region, predicate="contains")]
    if simple and not len(inside):
        return polygon
    rest: shapely.Geometry | None = region
    for yard in inside:
        rest = None if rest is None else _rings.without(rest, yard)
    rings = None if rest is None else _rings.simple_rings(rest)
    if rings is None:
        raise Unsplittable(f"{who}: its holes cannot be cut open exactly; draw it as several polygons", area.place)
    return rings
