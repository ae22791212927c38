"""Point robots at what is thin: nobody changes sides of a wall, however thin, or slips through a seam or a point.

Depth cannot tell: a path that is nowhere deeper than tol in anything may still come out on the other side of what is
thinner than that. So the way is followed. Each leg has a corridor some tolerances wide; the outlines of all shapes,
drawn as strips, cut it into pieces, of which some are free. From piece to piece that share a place the path must be
able to go on; where it cannot, it has crossed something.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from typing import TypeAlias

import numpy as np
import shapely
from numpy.typing import NDArray
from scipy.sparse import csr_array

from taut.certificate._kernels import signed_distances
from taut.certificate.clearance import Shapes
from taut.certificate.tracks import Tracks
from taut.scene import FloatArray, Point

IntArray: TypeAlias = NDArray[np.int64]
BoolArray: TypeAlias = NDArray[np.bool_]
Pieces: TypeAlias = NDArray[np.object_]

# All in tolerances. Half the width of a corridor, and of the square round a stamp, which the corridors of both its legs
# hold. A path may be 1 deep in a shape, so free places about it lie well within both.
_CORRIDOR, _SQUARE = 4.0, 2.8
# Half the width of the strips that stand for outlines: a room below twice that counts as none.
_STRIP = 2.0**-5
# Grid of the pieces' coordinates: 16 to a strip, and at least 16 ulps.
_GRID = 2.0**-8
# Chords to half of what a corridor shows of a circle; none is farther from it than 1 / 100.
_CHORDS = 32
# Radians: where two sides of a ring meet at less, path and corner may be so far apart that the path crosses.
_SHARP = 0.5


def crossings(shapes: Shapes, tracks: Tracks, robots: IntArray, tol: float) -> Iterator[tuple[int, float, Point]]:
    """Yield those of the robots whose path crosses something thin, and the time and place where each does so first."""
    thin = _thin_pairs(shapes, tol)
    stamp, owner = _legs(tracks, robots)
    if not len(thin) or not len(stamp):
        return
    legs = np.stack([tracks.x[stamp], tracks.y[stamp], tracks.x[stamp + 1], tracks.y[stamp + 1]], axis=1) / tol
    doubtful = _beside(thin, legs.reshape(-1, 2, 2), shapes, tol)
    outlines = _outlines(shapes, tol)
    for r in np.unique(owner[doubtful]).tolist():
        own = np.flatnonzero(owner == r)
        found = _followed(outlines, legs[own].reshape(-1, 2, 2), doubtful[own])
        if found is not None:
            yield r, *tracks.on_leg(int(stamp[own[found[0]]]), found[1])


@dataclass(frozen=True, eq=False)
class _Outlines:
    """What bounds the shapes: sides (E, 2, 2) and radius (E,) in tolerances, and a tree of the boxes round them."""

    shapes: Shapes
    tol: float
    sides: FloatArray
    radius: FloatArray
    tree: shapely.STRtree


def _outlines(shapes: Shapes, tol: float) -> _Outlines:
    radius = shapes.radius[shapes.owner] / tol
    boxes = _boxes(shapes.edges / tol, radius + _CORRIDOR)
    return _Outlines(shapes, tol, shapes.edges.reshape(-1, 2, 2) / tol, radius, shapely.STRtree(boxes))


def _boxes(edges: FloatArray, reach: FloatArray) -> Pieces:
    low = np.minimum(edges[:, :2], edges[:, 2:]) - reach[:, None]
    high = np.maximum(edges[:, :2], edges[:, 2:]) + reach[:, None]
    boxes: Pieces = shapely.box(*low.T, *high.T)
    return boxes


def _thin_pairs(shapes: Shapes, tol: float) -> IntArray:
    """Pairs of sides, (k, 2), between which there is nearly no room, or a wall so thin; a thin round side with itself.

    Sides that follow each other on a ring are one only at a sharp corner.
    """
    width = 2 * _CORRIDOR * tol
    owner = shapes.owner
    radius = shapes.radius[owner]
    boxes = _boxes(shapes.edges, radius + width / 2)
    a, b = shapely.STRtree(boxes).query(boxes)
    a, b = a[a < b], b[a < b]
    sides = shapely.linestrings(shapes.edges.reshape(-1, 2, 2))
    room = shapely.distance(sides[a], sides[b]) - radius[a] - radius[b]
    straight = (radius[a] == 0) & (radius[b] == 0)
    meet, sharp = _corners(shapes.edges[a], shapes.edges[b])
    follow = meet & (owner[a] == owner[b])
    near: BoolArray = (room <= width) & (straight | (room >= -width))
    near &= np.where(follow, straight & sharp, ~(straight & _cross_plainly(shapes.edges[a], shapes.edges[b], width)))
    lean = np.flatnonzero((radius > 0) & (radius <= width))
    return np.concatenate([np.stack([a[near], b[near]], axis=1), np.stack([lean, lean], axis=1)])


def _corners(a: FloatArray, b: FloatArray) -> tuple[BoolArray, BoolArray]:
    """Whether sides (k, 4) have an end in common, and whether they enclose a sharp angle there."""
    meet, sharp = np.zeros(len(a), dtype=np.bool_), np.zeros(len(a), dtype=np.bool_)
    for p in (0, 2):
        for q in (0, 2):
            same = (a[:, p : p + 2] == b[:, q : q + 2]).all(axis=1)
            u, v = (1 - p) * (a[:, 2:] - a[:, :2]), (1 - q) * (b[:, 2:] - b[:, :2])
            lengths = np.hypot(*u.T) * np.hypot(*v.T)
            meet |= same
            sharp |= same & ((u * v).sum(axis=1) > np.cos(_SHARP) * lengths)
    return meet, sharp


def _cross_plainly(a: FloatArray, b: FloatArray, width: float) -> BoolArray:
    """Whether sides (k, 4) cross at no small angle and farther than some widths from their ends."""

    def beside(side: FloatArray, other: FloatArray) -> BoolArray:
        way = side[:, 2:] - side[:, :2]
        with np.errstate(divide="ignore", invalid="ignore"):
            across = np.stack([-way[:, 1], way[:, 0]], axis=1) / np.hypot(*way.T)[:, None]
        one, two = (((other[:, at : at + 2] - side[:, :2]) * across).sum(axis=1) for at in (0, 2))
        reach = np.hypot(*(other[:, 2:] - other[:, :2]).T)
        apart = np.minimum(np.abs(one), np.abs(two)) > 2 * width
        crossed: BoolArray = (one * two < 0) & apart & (np.abs(one - two) > np.sin(_SHARP) * reach)
        return crossed

    return beside(a, b) & beside(b, a)


def _legs(tracks: Tracks, robots: IntArray) -> tuple[IntArray, IntArray]:
    """First stamp and robot of every leg of the chosen robots that leads anywhere."""
    count = np.diff(tracks.first)[robots] - 1
    owner = np.repeat(robots, count)
    stamp = tracks.first[owner] + np.arange(count.sum()) - np.repeat(np.cumsum(count) - count, count)
    moves = (tracks.x[stamp] != tracks.x[stamp + 1]) | (tracks.y[stamp] != tracks.y[stamp + 1])
    return stamp[moves], owner[moves]


def _beside(thin: IntArray, legs: FloatArray, shapes: Shapes, tol: float) -> BoolArray:
    """Whether each leg, (n, 2, 2) in tolerances, comes near both sides of a thin pair."""
    known = np.unique(thin)
    reach = shapes.radius[shapes.owner[known]] / tol + _CORRIDOR
    ends = shapes.edges[known].reshape(-1, 2, 2) / tol
    # a line without length is near to nothing
    sides = np.where((ends[:, 0] == ends[:, 1]).all(axis=1), shapely.points(ends[:, 0]), shapely.linestrings(ends))
    side, leg = shapely.STRtree(shapely.linestrings(legs)).query(sides, "dwithin", reach)
    near = csr_array((np.ones(len(side), dtype=np.bool_), (side, leg)), shape=(len(known), len(legs)))
    first, second = np.searchsorted(known, thin).T
    out = np.zeros(len(legs), dtype=np.bool_)
    out[near[first].multiply(near[second]).nonzero()[1]] = True
    return out


def _followed(outlines: _Outlines, legs: FloatArray, doubtful: BoolArray) -> tuple[int, float] | None:
    """Follow a path; return the leg, and where on it (0 … 1), after which it is where it cannot have come to."""
    side: Pieces = np.empty(0, dtype=object)
    for n, (a, b) in enumerate(legs):
        if not doubtful[n]:
            side = side[:0]
            continue
        for free in (_at(outlines, a), _free_pieces(outlines, _cell(a, b, _CORRIDOR)), _at(outlines, b)):
            reached = _meeting(free, side) if len(side) else free
            if len(free) and not len(reached):
                return n, _farthest(side, a, b)
            # where all is thinner than a strip nothing tells the sides apart: on from where it was
            side = reached if len(free) else side
    return None


def _at(outlines: _Outlines, place: FloatArray) -> Pieces:
    """Free pieces of the square about a place that are within tol of it."""
    free = _free_pieces(outlines, _cell(place, place, _SQUARE))
    near: Pieces = free[shapely.dwithin(free, shapely.Point(place), 1.0 + 2.0 * _STRIP)]
    return near


def _cell(a: FloatArray, b: FloatArray, half: float) -> shapely.Polygon:
    """Rectangle of this half-width about a leg, as far beyond its ends; a square about a point."""
    length = np.hypot(*(b - a))
    along = half * ((b - a) / length if length > 0 else np.array([1.0, 0.0]))
    across = np.array([-along[1], along[0]])
    return shapely.Polygon([a - along - across, b + along - across, b + along + across, a - along + across])


def _free_pieces(outlines: _Outlines, cell: shapely.Polygon) -> Pieces:
    """Pieces of a cell, in tolerances, that are in the workspace and in no obstacle."""
    shapes, tol = outlines.shapes, outlines.tol
    near = np.sort(outlines.tree.query(cell, "intersects"))
    left = cell
    if len(near):
        strips = _strips(np.concatenate(list(_bounds(outlines, near, cell))))
        left = shapely.difference(cell, shapely.union_all(strips, grid_size=_GRID), grid_size=_GRID)
    pieces = shapely.get_parts(left)
    pieces = pieces[shapely.get_type_id(pieces) == shapely.GeometryType.POLYGON]
    within = shapely.get_coordinates(shapely.point_on_surface(pieces)) * tol
    room = [signed_distances(x, y, shapes.edges, shapes.first, shapes.radius, shapes.kind).min() for x, y in within]
    free: Pieces = pieces[np.array(room) > 0] if len(room) else pieces
    return free


def _bounds(outlines: _Outlines, near: IntArray, cell: shapely.Polygon) -> Iterator[FloatArray]:
    """Yield what bounds the shapes with these sides as segments, (k, 2, 2); arcs only as far as a cell shows them."""
    sides, radius = outlines.sides[near], outlines.radius[near]
    yield sides[radius == 0]
    a, b, _, d = shapely.get_coordinates(cell)[:4]
    along = (b - a) / np.hypot(*(b - a))
    across = np.array([-along[1], along[0]])
    low, high = a @ across - 1.0, d @ across + 1.0
    for (start, end), r in zip(sides[radius > 0], radius[radius > 0], strict=True):
        length = np.hypot(*(end - start))
        if length > 0:
            out = r * np.array([-(end - start)[1], (end - start)[0]]) / length
            yield np.array([[start + out, end + out], [start - out, end - out]])
        for centre in (start, end)[: 1 + (length > 0)]:
            yield from _arcs(centre, r, along, across, low, high)


def _arcs(
    centre: FloatArray, r: float, along: FloatArray, across: FloatArray, low: float, high: float
) -> Iterator[FloatArray]:
    """Yield chords of a circle, (k, 2, 2), where the product of a point with ``across`` is between two numbers."""
    lowest, highest = np.clip((np.array([low, high]) - centre @ across) / r, -1.0, 1.0)
    if lowest == highest:
        return
    angle = np.linspace(np.arcsin(lowest), np.arcsin(highest), _CHORDS + 1)
    for half in (1.0, -1.0):
        at = centre + r * (half * np.cos(angle)[:, None] * along + np.sin(angle)[:, None] * across)
        yield np.stack([at[:-1], at[1:]], axis=1)


def _strips(segments: FloatArray) -> Pieces:
    a, b = segments[:, 0], segments[:, 1]
    a, b = a[(a != b).any(axis=1)], b[(a != b).any(axis=1)]
    along = _STRIP * (b - a) / np.hypot(*(b - a).T)[:, None]
    across = np.stack([-along[:, 1], along[:, 0]], axis=1)
    corners = [a - along - across, b + along - across, b + along + across, a - along + across]
    strips: Pieces = shapely.polygons(np.stack(corners, axis=1))
    return strips


def _meeting(pieces: Pieces, others: Pieces) -> Pieces:
    """Those of the pieces that share an area with another one."""
    common = shapely.intersection(pieces[:, None], others[None, :], grid_size=_GRID)
    met: Pieces = pieces[(shapely.area(common) > 0).any(axis=1)]
    return met


def _farthest(pieces: Pieces, a: FloatArray, b: FloatArray) -> float:
    """How far on a leg (0 … 1) the pieces reach."""
    ahead = (shapely.get_coordinates(pieces) - a) @ (b - a) / ((b - a) @ (b - a))
    return float(np.clip(ahead.max(), 0.0, 1.0))
