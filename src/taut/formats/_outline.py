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
    """A polygon as a file gives it: the outer ring, then the holes; none closed by repetition."""

    name: str
    rings: list[Ring]
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
    if len(boundaries) == 1 and _is_as_good_as_simple(boundaries[0]):
        outline = boundaries[0].rings[0]
        pockets: list[Ring] = []
        courtyards: list[shapely.Geometry] = []
    else:
        regions = [_region(area, "boundary") for area in boundaries]
        yards = _courtyards(regions, obstacles)
        outline, pockets = _workspace([r for r, yard in zip(regions, yards, strict=True) if not yard], boundaries[0])
        courtyards = [r for r, yard in zip(regions, yards, strict=True) if yard]
    tree = shapely.STRtree(courtyards)
    entries: list[Entry] = []
    for obstacle in obstacles:
        if not isinstance(obstacle, Area):
            entries.append(obstacle)
            continue
        rings = _split(obstacle, tree)
        for k, ring in enumerate(rings):
            name = f"{obstacle.name} {k + 1}" if obstacle.name and len(rings) > 1 else obstacle.name
            entry = {"name": name} if name else {}
            entries.append(({**entry, "polygon": [list(corner) for corner in ring]}, obstacle.place))
    entries += [({"polygon": [list(corner) for corner in ring]}, boundaries[0].place) for ring in pockets]
    return outline, entries


def _is_as_good_as_simple(area: Area) -> bool:
    """Whether one ring is all there is to say: it is simple, or wrong in a way that validation places and names."""
    if len(area.rings) > 1:
        return False
    return _rings.is_simple(area.rings[0]) or _rings.region_of(area.rings[0]) is None


def _region(area: Area, what: str) -> shapely.Geometry:
    region = _rings.region_of(area.rings[0], area.rings[1:])
    if region is None:
        who = f"{what} {area.name}".strip()
        raise Unsplittable(f"{who}: its rings cross themselves or each other, or enclose nothing", area.place)
    return region


def _courtyards(regions: Sequence[shapely.Geometry], obstacles: Sequence[Area | Entry]) -> list[bool]:
    """Which boundaries lie inside an obstacle that lies inside another boundary."""
    if len(regions) == 1:
        return [False]
    shells = [shapely.union_all([shapely.Polygon(_rings.outline(p)) for p in _rings.polygons(r)]) for r in regions]
    areas = [_filled(area) for area in obstacles if isinstance(area, Area)]
    solid = [area for area in areas if area is not None]
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


def _filled(area: Area) -> shapely.Geometry | None:
    return _rings.region_of(area.rings[0])


def _workspace(regions: Sequence[shapely.Geometry], first: Area) -> tuple[Ring, list[Ring]]:
    """Return the outline of the regions and the obstacles that make it exactly the regions."""
    whole = _rings.union(regions) if regions else None
    if whole is None:
        raise Unsplittable("the boundaries overlap or cross; draw them as one", first.place)
    polygons = _rings.polygons(whole)
    if len(polygons) == 1:
        outline = _rings.outline(polygons[0])
        return outline, [ring for hole in polygons[0].interiors for ring in _hole(hole)]
    box = shapely.box(*shapely.bounds(whole))
    rest = _rings.without(box, whole)
    pockets = None if rest is None else _rings.simple_rings(rest)
    if pockets is None:
        raise Unsplittable("the boundaries cannot be joined into one map exactly; draw them as one", first.place)
    return _rings.outline(box), pockets


def _hole(hole: shapely.LinearRing) -> list[Ring]:
    return [_rings.outline(shapely.Polygon(hole))]


def _split(area: Area, courtyards: shapely.STRtree) -> list[Ring]:
    simple = len(area.rings) == 1 and _rings.is_simple(area.rings[0])
    if simple and not len(courtyards):
        return area.rings
    region = _rings.region_of(area.rings[0], area.rings[1:])
    if region is None and len(area.rings) == 1:
        return area.rings  # it crosses itself: validation says where
    who = f"obstacle {area.name}".strip()
    if region is None:
        raise Unsplittable(f"{who}: its holes cross its ring or each other; draw it as several polygons", area.place)
    inside = courtyards.geometries[courtyards.query(region, predicate="contains")]
    if simple and not len(inside):
        return area.rings
    rest: shapely.Geometry | None = region
    for yard in inside:
        rest = None if rest is None else _rings.without(rest, yard)
    rings = None if rest is None else _rings.simple_rings(rest)
    if rings is None:
        raise Unsplittable(f"{who}: its holes cannot be cut open exactly; draw it as several polygons", area.place)
    return rings
