"""Slow, obvious, exact references for seeing and for shortest paths; they share no code with the package.

Every float is taken as the rational number it is and scaled by one power of two to a Python int, so no test here
rounds. Every pair of vertices is tried against every edge and every vertex of the boundary.

A *wedge* is one open sector of free space at a boundary vertex; a pinch point has several. Graph vertices are
``(x, y, key)``: `key` is the place of the boundary neighbour at which the wedge begins, counter-clockwise (free space
lies to the left of the edge towards it). Points added by the caller have key None and belong to every wedge there.
"""

from __future__ import annotations

import heapq
from collections import Counter
from collections.abc import Collection, Iterable, Iterator, Sequence
from dataclasses import dataclass
from decimal import Context, Decimal
from itertools import combinations, pairwise
from typing import Any, Literal, TypeAlias

Point: TypeAlias = tuple[float, float]
Vertex: TypeAlias = tuple[float, float, Point | None]
Pair: TypeAlias = frozenset[Vertex]
Kind: TypeAlias = Literal["reflex", "straight", "convex"]
Place: TypeAlias = tuple[int, int]

_DIGITS = Context(prec=60)


def naive_wedges(region: Any) -> dict[Vertex, Kind]:
    """Return all wedges of a region with their kind: angle above, exactly or below π.

    Parameters
    ----------
    region : shapely Polygon or MultiPolygon, valid in the OGC sense; rings may touch in points.

    Raises
    ------
    ValueError
        If boundary edges cross or overlap when taken exactly.
    """
    exact = ExactRegion(region)
    return {spot.vertex: spot.wedges[0].kind for spot in exact.spots()}


def naive_corners(region: Any) -> set[Vertex]:
    """Return the wedges at which a path may bend or that it may touch: those with angle ≥ π."""
    return {vertex for vertex, kind in naive_wedges(region).items() if kind != "convex"}


def naive_visibility(
    region: Any,
    points: Iterable[Sequence[float]] = (),
    edges: Literal["all", "tangent"] = "all",
    vertices: Collection[Vertex] | None = None,
) -> set[Pair]:
    """Return the visible pairs, in a form that does not depend on any numbering.

    Parameters
    ----------
    region : shapely Polygon or MultiPolygon, as for `naive_wedges`.
    points : starts and goals, in the closed region.
    edges : "all": every pair whose segment is allowed. "tangent": corners and points only, no corner strictly between,
        locally shortest at both ends.
    vertices : wedges to consider, default all of the region.

    Returns
    -------
    Set of frozensets of two vertices at different places (a pair at one place is never listed).

    Raises
    ------
    ValueError
        A point outside the region, a vertex that is no wedge of the region, a region that is not valid.
    """
    places = [(float(x), float(y)) for x, y in points]
    exact = ExactRegion(region, places)
    spots = exact.spots() if vertices is None else exact.chosen(vertices)
    if edges == "tangent":
        spots = [spot for spot in spots if spot.wedges[0].kind != "convex"]
    spots += [exact.free(point) for point in dict.fromkeys(places)]
    seen = set()
    for s, t in combinations(spots, 2):
        passed = exact.passed(s, t)
        if passed is None or (edges == "tangent" and (passed or s.bends_in(t.place) or t.bends_in(s.place))):
            continue
        seen.add(frozenset((s.vertex, t.vertex)))
    return seen


def naive_shortest(region: Any, a: Sequence[float], b: Sequence[float]) -> float | None:
    """Return the length of a shortest allowed path, metres, correctly rounded; None if there is no path."""
    route = naive_route(region, a, b)
    return None if route is None else route[0]


def naive_route(region: Any, a: Sequence[float], b: Sequence[float]) -> tuple[float, list[Point]] | None:
    """Return length and bends (a and b included) of a shortest allowed path, None if there is none.

    Raises
    ------
    ValueError
        If a or b is outside the closed region.
    """
    start, goal = (float(a[0]), float(a[1])), (float(b[0]), float(b[1]))
    exact = ExactRegion(region, [start, goal])
    spots = [exact.free(start), exact.free(goal), *exact.spots()]
    if start == goal:
        return 0.0, [start]
    best = {0: Decimal(0)}
    before: dict[int, int] = {}
    done: set[int] = set()
    queue = [(Decimal(0), 0)]
    while queue:
        reached, k = heapq.heappop(queue)
        if k in done:
            continue
        if k == 1:
            return _metres(reached, exact.scale), _bends(spots, before)
        done.add(k)
        for j, spot in enumerate(spots):
            if j in done:
                continue
            # The bound comes first because seeing is the slow part.
            length = _DIGITS.add(reached, _distance(spots[k].place, spot.place))
            if (j in best and length >= best[j]) or exact.passed(spots[k], spot) is None:
                continue
            best[j], before[j] = length, k
            heapq.heappush(queue, (length, j))
    return None


@dataclass(frozen=True)
class Wedge:
    """The free directions at a place: counter-clockwise from `first` to `last` (neighbours), None for all."""

    place: Place
    first: Place | None
    last: Place | None

    @property
    def kind(self) -> Kind:
        """Whether the angle is above, exactly or below π."""
        if self.first is None or self.last is None:
            return "reflex"
        turn = orient(self.place, self.first, self.last)
        return "convex" if turn > 0 else "reflex" if turn < 0 else "straight"

    def admits(self, place: Place) -> bool:
        """Whether one may leave towards `place`, along its bounding edges included."""
        if self.first is None or self.last is None:
            return True
        after_first = orient(self.place, self.first, place)
        before_last = orient(self.place, place, self.last)
        match self.kind:
            case "convex":
                return after_first >= 0 and before_last >= 0
            case "straight":
                return after_first >= 0
            case "reflex":
                return after_first >= 0 or before_last >= 0


@dataclass(frozen=True)
class Spot:
    """A graph vertex: its name for the caller, its exact place and the wedges it belongs to."""

    vertex: Vertex
    place: Place
    wedges: tuple[Wedge, ...]

    def bends_in(self, other: Place) -> bool:
        """Whether a path that comes from `other` could be cut short here: the edges lie on both sides of its line."""
        if self.vertex[2] is None:
            return False
        wedge = self.wedges[0]
        assert wedge.first is not None
        assert wedge.last is not None
        return orient(other, self.place, wedge.first) * orient(other, self.place, wedge.last) < 0


class ExactRegion:
    """A region in exact integers: directed boundary edges with free space on their left, and wedges at vertices."""

    def __init__(self, region: Any, points: Iterable[Point] = ()) -> None:
        rings = [_ring(ring.coords) for polygon in _polygons(region) for ring in (polygon.exterior, *polygon.interiors)]
        outer = [hole == 0 for polygon in _polygons(region) for hole in range(1 + len(polygon.interiors))]
        numbers = [c for ring in (*rings, list(points)) for point in ring for c in point]
        self.scale = max((c.as_integer_ratio()[1] for c in numbers), default=1)
        exact = [[self.exact(point) for point in ring] for ring in rings]
        turned = [
            r if (_doubled_area(r) > 0) == is_outer else r[::-1] for r, is_outer in zip(exact, outer, strict=True)
        ]
        cleaned = _without_straight(_split_where_touched(turned))
        self._floats = {self.exact(point): point for ring in rings for point in ring}
        self.edges = [edge for ring in cleaned for edge in pairwise([*ring, ring[0]])]
        _check(self.edges)
        self.wedges = _wedges(self.edges)

    def exact(self, point: Point) -> Place:
        """Return the place of a point in units of 1 / scale metres."""
        (nx, dx), (ny, dy) = point[0].as_integer_ratio(), point[1].as_integer_ratio()
        return nx * (self.scale // dx), ny * (self.scale // dy)

    def spots(self) -> list[Spot]:
        """Return a spot for every wedge."""
        return [
            Spot((*self._floats[place], self._floats[wedge.first]), place, (wedge,))
            for place, wedges in self.wedges.items()
            for wedge in wedges
            if wedge.first is not None
        ]

    def chosen(self, vertices: Collection[Vertex]) -> list[Spot]:
        """Return the spots of some wedges; ValueError if one of them is no wedge of this region."""
        known = {spot.vertex: spot for spot in self.spots()}
        for vertex in vertices:
            if vertex not in known:
                raise ValueError(f"{vertex} is no wedge of the region")
        return [known[vertex] for vertex in dict.fromkeys(vertices)]

    def free(self, point: Point) -> Spot:
        """Return the spot of a point of the closed region; ValueError if it is outside."""
        place = self.exact(point)
        wedges = self.wedges.get(place)
        if wedges is None:
            wedges = [Wedge(place, w, u) for u, w in self.edges if _strictly_between(u, w, place)]
        if not wedges:
            if not self._surrounds(place):
                raise ValueError(f"{point} is outside the region")
            wedges = [Wedge(place, None, None)]
        return Spot((*point, None), place, tuple(wedges))

    def passed(self, s: Spot, t: Spot) -> list[Place] | None:
        """Return the boundary vertices strictly between two spots, None if the segment is not allowed."""
        p, q = s.place, t.place
        if p == q or not any(w.admits(q) for w in s.wedges) or not any(w.admits(p) for w in t.wedges):
            return None
        side = {v: orient(p, q, v) for v in self.wedges}
        for u, w in self.edges:
            if _opposite(side[u], side[w]) and _opposite(orient(u, w, p), orient(u, w, q)):
                return None
        between = [v for v, turn in side.items() if turn == 0 and _strictly_between(p, q, v)]
        for v in between:
            if not any(w.admits(p) and w.admits(q) for w in self.wedges[v]):
                return None
        return between

    def _surrounds(self, place: Place) -> bool:
        crossings = 0
        for u, w in self.edges:
            if (u[1] > place[1]) != (w[1] > place[1]):
                crossings += (orient(u, w, place) > 0) == (w[1] > u[1])
        return crossings % 2 == 1


def orient(a: Place, b: Place, c: Place) -> int:
    """Return twice the signed area of a triangle: positive if c is to the left of the line from a to b."""
    return (b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0])


def _opposite(a: int, b: int) -> bool:
    return (a < 0 < b) or (b < 0 < a)


def _strictly_between(a: Place, b: Place, p: Place) -> bool:
    inside = (a[0] - p[0]) * (b[0] - p[0]) + (a[1] - p[1]) * (b[1] - p[1]) < 0
    return inside and orient(a, b, p) == 0


def _polygons(region: Any) -> list[Any]:
    return [part for part in getattr(region, "geoms", [region]) if not part.is_empty]


def _ring(coordinates: Iterable[Sequence[float]]) -> list[Point]:
    points = [(float(c[0]), float(c[1])) for c in coordinates]
    return [p for p, q in pairwise(points) if p != q]


def _doubled_area(ring: list[Place]) -> int:
    return sum(p[0] * q[1] - p[1] * q[0] for p, q in pairwise([*ring, ring[0]]))


def _split_where_touched(rings: list[list[Place]]) -> list[list[Place]]:
    """Make a vertex wherever a ring touches an edge between its ends, which a valid region may do."""
    places = {p for ring in rings for p in ring}

    def split(ring: list[Place]) -> Iterator[Place]:
        for p, q in pairwise([*ring, ring[0]]):
            yield p
            inside = [v for v in places if _strictly_between(p, q, v)]
            yield from sorted(inside, key=lambda v: abs(v[0] - p[0]) + abs(v[1] - p[1]))

    return [list(split(ring)) for ring in rings]


def _without_straight(rings: list[list[Place]]) -> list[list[Place]]:
    """Drop vertices without a bend at which no ring touches; a touched one parts the free space, so it stays."""
    visits = Counter(p for ring in rings for p in ring)
    return [
        [
            q
            for p, q, r in zip([ring[-1], *ring[:-1]], ring, [*ring[1:], ring[0]], strict=True)
            if visits[q] > 1 or orient(p, q, r) != 0
        ]
        for ring in rings
    ]


def _check(edges: list[tuple[Place, Place]]) -> None:
    if len({frozenset(edge) for edge in edges}) < len(edges):
        raise ValueError("the region is not valid: boundary edges overlap")
    for (a, b), (c, d) in combinations(edges, 2):
        if _opposite(orient(a, b, c), orient(a, b, d)) and _opposite(orient(c, d, a), orient(c, d, b)):
            raise ValueError("the region is not valid: boundary edges cross when taken exactly")


def _wedges(edges: list[tuple[Place, Place]]) -> dict[Place, list[Wedge]]:
    leaving: dict[Place, list[Place]] = {}
    arriving: dict[Place, list[Place]] = {}
    for u, w in edges:
        leaving.setdefault(u, []).append(w)
        arriving.setdefault(w, []).append(u)
    return {
        place: [Wedge(place, first, _next_counter_clockwise(place, first, arriving[place])) for first in firsts]
        for place, firsts in leaving.items()
    }


def _next_counter_clockwise(place: Place, first: Place, candidates: list[Place]) -> Place:
    """Return the candidate with the smallest counter-clockwise angle from `first`, found without angles."""
    best = candidates[0]
    for other in candidates[1:]:
        if Wedge(place, first, best).admits(other):
            best = other
    return best


def _distance(a: Place, b: Place) -> Decimal:
    return _DIGITS.sqrt(Decimal((a[0] - b[0]) ** 2 + (a[1] - b[1]) ** 2))


def _metres(length: Decimal, scale: int) -> float:
    return float(_DIGITS.divide(length, Decimal(scale)))


def _bends(spots: list[Spot], before: dict[int, int]) -> list[Point]:
    chain = [1]
    while chain[-1] != 0:
        chain.append(before[chain[-1]])
    chain.reverse()
    kept = [chain[0]]
    for k, after in pairwise(chain[1:]):
        if orient(spots[kept[-1]].place, spots[k].place, spots[after].place) != 0:
            kept.append(k)
    return [spots[k].vertex[:2] for k in (*kept, chain[-1])]
