"""Growth: obstacles made larger, and the workspace smaller, by the size of a robot; never by less than asked.

The outline of an obstacle is a ring: the boundary of a filled polygon, a polyline walked forth and back, a single
point. Every side of it moves out by the radius R; the arc round a corner becomes tangents of the circle of radius R.
The moved outline winds round a point once more whenever it has passed over it, and never back. So when it does not
cross itself it is the boundary wanted, also for a polygon that is not convex, and no polygons need to be united. Only
outlines that do cross themselves (a courtyard closes, a bay fills up) are cut into one piece a side and one a corner.

Lines and circles are never drawn thinner than the tolerance, so that no rounding can make a way through them.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Any, Literal, NamedTuple, TypeAlias

import numpy as np
import shapely
from numpy.typing import NDArray
from scipy.spatial import KDTree

from taut.errors import SceneError, TautError
from taut.geometry.overlay import FINE, remainder, united
from taut.scene import FloatArray, Obstacle, Scene

Corners: TypeAlias = Literal["round", "mitre"]
IntArray: TypeAlias = NDArray[np.intp]
BoolArray: TypeAlias = NDArray[np.bool_]
Shapes: TypeAlias = NDArray[np.object_]

_MITRE_ERROR = 1.0
"""Mitres are tangents as sparse as can be with no vertex farther than twice the radius from its corner."""


def free_region(
    scene: Scene,
    growth: float,
    arc_error: float = 1e-3,
    corners: Corners = "round",
    keep: FloatArray | None = None,
) -> shapely.Polygon | shapely.MultiPolygon:
    """Return where a point may be that keeps `growth` metres from all obstacles and from the outside of the workspace.

    Parameters
    ----------
    scene : its workspace and obstacles count, its robots do not.
    growth : metres, ≥ 0; obstacles with a radius of their own grow by it beyond that radius.
    arc_error : how much farther than its radius the outline round a corner may be, as a share of the radius; in
        [1e-9, 1].
    corners : "round", or "mitre": the corners of polygons get one vertex, at most twice `growth` away (two where it
        would be farther). Fewer vertices, but narrow passages round corners close.
    keep : (k, 2) metres, positions that must not be lost between an arc and its tangents: one more tangent, square to
        the line from the corner to the position, leaves each of them free if its distance is at least the radius.

    Returns
    -------
    Polygon or MultiPolygon
        The closure of the open set of points farther than `growth` from obstacles and the outside. Parts that touch
        in points only stay apart; a hole may touch its shell in a point. Without free space an empty MultiPolygon.
        Where `growth` is 0 every corner of a polygon keeps its coordinates bit for bit. Lines and circles keep their
        distance or half the scene's tolerance, whichever is more.

    Raises
    ------
    SceneError
        If the workspace or a polygon crosses or touches itself or has no area.
    TautError
        If `growth`, `arc_error`, `corners` or `keep` is out of range.

    >>> from taut.scene import Rectangle
    >>> free_region(Scene((0, 0, 4, 4), [Rectangle(0, 1, 4, 2)]), 0.25).area
    3.5
    """
    plan = _plan(growth, arc_error, corners, keep, scene.tol)
    room, walls = _shrunk(scene, plan)
    pieces, thin = _pieces(scene.obstacles, plan)
    taken = np.concatenate([walls, pieces])
    parts = shapely.get_parts(remainder(room, taken, scene.tol, thin) if taken.size else room)
    # what rounding leaves of a gap without width
    parts = parts[shapely.area(parts) > scene.tol / 2 * shapely.length(parts)]
    return parts[0] if parts.size == 1 else shapely.multipolygons(parts)


def grown(
    obstacle: Obstacle,
    growth: float,
    arc_error: float = 1e-3,
    corners: Corners = "round",
    keep: FloatArray | None = None,
    tol: float | None = None,
) -> shapely.Polygon:
    """Return one obstacle grown by `growth` metres, as one polygon (with holes where it has courtyards).

    Parameters and errors are those of `free_region`; `tol` is the tolerance of its scene in metres, without it that of
    the obstacle alone. A polygon grown by 0 keeps its coordinates bit for bit.

    >>> from taut.scene import Polygon
    >>> grown(Polygon([(0, 0), (2, 0), (2, 1), (0, 1)]), 0.5, corners="mitre").bounds
    (-0.5, -0.5, 2.5, 1.5)
    """
    if tol is None:
        tol = 2.0**-40 * (float(np.abs(obstacle.core).max()) + obstacle.own_radius + growth)
    pieces, thin = _pieces([obstacle], _plan(growth, arc_error, corners, keep, tol))
    if pieces.size == 1:
        return pieces[0]
    return shapely.get_geometry(united(pieces, tol, thin), 0)


class _Plan(NamedTuple):
    """How to grow: metres, widest turns (radians) between tangents at round and sharp corners, positions kept, tol."""

    growth: float
    round_turn: float
    sharp_turn: float
    keep: FloatArray
    tol: float


class _Outlines(NamedTuple):
    """Corners of rings, ring after ring; a ring's outside lies to the right of its sides.

    Attributes
    ----------
    at : (n, 2) metres.
    ring : (n,) number of the ring, ascending.
    before, after : (n,) the neighbours of a corner in its ring.
    radius : (n,) metres by which it grows.
    widest : (n,) the widest turn between two tangents, radians.
    length : (n,) metres, of the side that begins at the corner; 0 if the corner is alone in its ring.
    normal : (n, 2) unit vector out of that side.
    turn : (n,) change of direction at the corner, radians, > 0 where it sticks out; 2π if it is alone.
    """

    at: FloatArray
    ring: IntArray
    before: IntArray
    after: IntArray
    radius: FloatArray
    widest: FloatArray
    length: FloatArray
    normal: FloatArray
    turn: FloatArray


class _Caps(NamedTuple):
    """The vertices of the moved outlines: `at` (k, 2), the corner `owner` (k,) of each, per corner `first`, `last`."""

    at: FloatArray
    owner: IntArray
    first: IntArray
    last: IntArray


def _plan(growth: float, arc_error: float, corners: Corners, keep: FloatArray | None, tol: float) -> _Plan:
    if not (math.isfinite(growth) and growth >= 0):
        raise TautError(f"growth must be a finite number of metres, at least 0; got {growth!r}")
    if not 1e-9 <= arc_error <= 1:
        raise TautError(f"arc_error must be between 1e-9 and 1 (of the arc's radius); got {arc_error!r}")
    if corners not in ("round", "mitre"):
        raise TautError(f'corners must be "round" or "mitre"; got {corners!r}')
    positions = np.zeros((0, 2)) if keep is None else np.asarray(keep, dtype=np.float64)
    if positions.ndim != 2 or positions.shape[1] != 2 or not np.isfinite(positions).all():
        raise TautError(f"keep must be finite positions of shape (k, 2); got shape {positions.shape}")
    round_turn = _widest_turn(arc_error)
    sharp_turn = _widest_turn(_MITRE_ERROR) if corners == "mitre" else round_turn
    return _Plan(growth, round_turn, sharp_turn, np.unique(positions, axis=0), tol)


def _widest_turn(error: float) -> float:
    # = 2 acos(1 / (1 + error)), without its cancellation for small errors
    return 2.0 * math.atan(math.sqrt(error * (2.0 + error)))


def _shrunk(scene: Scene, plan: _Plan) -> tuple[Any, Shapes]:
    """Return a polygon and the pieces to take from it, together the workspace shrunk by the growth."""
    room = _filled([np.array(scene.workspace)], ["workspace"])[0]
    if plan.growth == 0.0:
        return room, np.empty(0, dtype=object)
    # walked clockwise, so that its outside, the right hand, is what obstacles have inside
    ring = shapely.get_coordinates(shapely.orient_polygons(room, exterior_cw=True))[:-1]
    lines = _outlines([ring], np.array([plan.growth]), np.array([plan.sharp_turn]))
    caps = _caps(lines, plan.keep)
    moved, simple = _moved(lines, caps)
    if simple[0] and not shapely.is_ccw(shapely.get_exterior_ring(moved[0])):
        return moved[0], np.empty(0, dtype=object)
    return room, _sides_and_caps(lines, caps, np.ones(len(lines.at), dtype=np.bool_))


def _pieces(obstacles: Sequence[Obstacle], plan: _Plan) -> tuple[Shapes, Shapes]:
    """Return polygons whose union are the grown obstacles, and those of them that may be thin (see `remainder`)."""
    solid = [o for o in obstacles if o.closed]
    lean = [o for o in obstacles if not o.closed]
    filled = _filled([o.core for o in solid], [f"obstacle {o.name}" for o in solid])
    if plan.growth == 0.0:
        solid = []
    rings = [shapely.get_coordinates(p)[:-1] for p in shapely.orient_polygons(filled)] if solid else []
    chains = [o.core for o in lean]
    rings += [np.concatenate([chain, chain[-2:0:-1]]) for chain in chains]
    if not rings:
        return filled, filled
    radius = np.array([o.own_radius + plan.growth for o in (*solid, *lean)])
    radius[len(solid) :] = np.maximum(radius[len(solid) :], plan.tol / 2)
    widest = np.array([plan.sharp_turn] * len(solid) + [plan.round_turn] * len(lean))
    lines = _outlines(rings, radius, widest)
    caps = _caps(lines, plan.keep)
    moved, simple = _moved(lines, caps)
    crossing = ~simple
    whole = filled if not solid else filled[crossing[: len(solid)]]
    fine = radius < FINE * plan.tol
    slim = [moved[simple & fine], _sides_and_caps(lines, caps, (crossing & fine)[lines.ring])]
    stout = [moved[simple & ~fine], _sides_and_caps(lines, caps, (crossing & ~fine)[lines.ring])]
    if plan.growth < FINE * plan.tol:
        slim.append(whole)
    else:
        stout.append(whole)
    return np.concatenate([*slim, *stout]), np.concatenate(slim)


def _filled(rings: Sequence[FloatArray], names: Sequence[str]) -> Shapes:
    if not rings:
        return np.empty(0, dtype=object)
    owner = np.repeat(np.arange(len(rings)), [len(r) for r in rings])
    at = np.concatenate(rings)
    shapes: Shapes = shapely.polygons(shapely.linearrings(at, indices=owner))
    valid = shapely.is_valid(shapes)
    if not valid.all():
        k = int(np.argmin(valid))
        reason = shapely.is_valid_reason(shapes[k])
        raise SceneError(f"{names[k]} is not a simple polygon ({reason}); its sides must not cross or touch each other")
    repeated = (at[1:] == at[:-1]).all(axis=1) & (owner[1:] == owner[:-1])
    distinct: Shapes = shapely.remove_repeated_points(shapes) if repeated.any() else shapes
    return distinct


def _outlines(rings: Sequence[FloatArray], radius: FloatArray, widest: FloatArray) -> _Outlines:
    at = np.concatenate(rings)
    ring = np.repeat(np.arange(len(rings)), [len(r) for r in rings])
    before, after = _neighbours(ring)
    first = np.flatnonzero(np.diff(ring, prepend=-1))
    reach = np.maximum.reduceat(np.abs(at).max(axis=1), first) + radius
    # the same point, or so near to it that squares of the distance may vanish
    new = np.abs(at - at[before]).max(axis=1) > 2.0**-60 * reach[ring]
    new[first[np.bincount(ring, new) == 0]] = True
    at, ring = at[new], ring[new]
    before, after = _neighbours(ring)
    side = at[after] - at
    cross, dot = _products(side[before], side)
    # straight to within rounding: such a vertex would become a false corner
    bent = ~((np.abs(cross) <= 2.0**-50 * dot) & (dot > 0))
    at, ring = at[bent], ring[bent]
    before, after = _neighbours(ring)
    side = at[after] - at
    length = np.hypot(side[:, 0], side[:, 1])
    alone = before == np.arange(len(at))
    normal = np.stack([side[:, 1], -side[:, 0]], axis=1) / np.where(alone, 1.0, length)[:, None]
    normal[alone] = (1.0, 0.0)
    cross, dot = _products(side[before], side)
    turn = np.where((cross == 0) & (dot < 0), math.pi, np.arctan2(cross, dot))
    turn[alone] = 2.0 * math.pi
    return _Outlines(at, ring, before, after, radius[ring], widest[ring], length, normal, turn)


def _neighbours(ring: IntArray) -> tuple[IntArray, IntArray]:
    n = len(ring)
    before, after = np.arange(n) - 1, np.arange(n) + 1
    first = np.flatnonzero(np.diff(ring, prepend=-1))
    last = np.append(first[1:], n) - 1
    before[first], after[last] = last, first
    return before, after


def _products(a: FloatArray, b: FloatArray) -> tuple[FloatArray, FloatArray]:
    return a[:, 0] * b[:, 1] - a[:, 1] * b[:, 0], a[:, 0] * b[:, 0] + a[:, 1] * b[:, 1]


def _caps(lines: _Outlines, keep: FloatArray) -> _Caps:
    count = np.maximum(np.ceil(lines.turn / lines.widest), 1).astype(np.intp)
    alone = lines.length == 0
    # a tangent in each of the four directions of the axes
    count[alone] = -(-count[alone] // 4) * 4
    special = _kept(lines, count, keep)
    for corner, tangents in special.items():
        count[corner] = len(tangents) - 1
    last = np.cumsum(count) - 1
    first = last - count + 1
    owner = np.repeat(np.arange(len(count)), count)
    half = (lines.turn / count / 2)[owner]
    middle = (2 * (np.arange(len(owner)) - first[owner]) + 1) * half
    for corner, tangents in special.items():
        part = slice(first[corner], last[corner] + 1)
        half[part] = np.diff(tangents) / 2
        middle[part] = tangents[:-1] + half[part]
    start = lines.normal[lines.before[owner]]
    c, s = np.cos(middle), np.sin(middle)
    ray = np.stack([c * start[:, 0] - s * start[:, 1], s * start[:, 0] + c * start[:, 1]], axis=1)
    reach = lines.radius[owner] / np.cos(half)
    return _Caps(lines.at[owner] + reach[:, None] * ray, owner, first, last)


def _kept(lines: _Outlines, count: IntArray, keep: FloatArray) -> dict[int, FloatArray]:
    """Return, for corners whose tangents would swallow a position, angles of tangents that do not, from 0 to turn."""
    if not len(keep):
        return {}
    out = np.flatnonzero(lines.turn > 0)
    tree = KDTree(keep)
    reach = lines.radius[out] / np.cos(lines.turn[out] / count[out] / 2)
    near = tree.query_ball_point(lines.at[out], reach, return_length=True) > 0
    special = {}
    for corner, far in zip(out[near].tolist(), reach[near].tolist(), strict=True):
        radius, turn = lines.radius[corner], lines.turn[corner]
        arm = keep[tree.query_ball_point(lines.at[corner], far)] - lines.at[corner]
        distance = np.hypot(arm[:, 0], arm[:, 1])
        angle = np.arctan2(*_products(lines.normal[lines.before[corner]][None], arm)) % (2 * math.pi)
        step = turn / count[corner]
        depth = radius - distance * np.cos(angle - np.round(angle / step) * step)
        rounding = 2.0**-48 * (np.abs(lines.at[corner]).max() + radius)
        # whatever is nearer than half the radius is lost anyhow
        lost = (angle < turn) & (depth > rounding) & (distance > radius / 2)
        if lost.any():
            special[corner] = np.unique(np.append(np.linspace(0.0, turn, count[corner] + 1), angle[lost]))
    return special


def _moved(lines: _Outlines, caps: _Caps) -> tuple[Shapes, BoolArray]:
    """Return every outline moved out as one polygon, and whether it is the boundary wanted."""
    moved: Shapes = shapely.polygons(shapely.linearrings(caps.at, indices=lines.ring[caps.owner]))
    eaten = np.where(lines.turn < 0, lines.radius * np.tan(-lines.turn / 2), 0.0)
    inverted = (lines.length <= eaten + eaten[lines.after]) & (lines.length > 0)
    simple = np.bincount(lines.ring, inverted, minlength=len(moved)) == 0
    simple[simple] = shapely.is_valid(moved[simple])
    return moved, simple


def _sides_and_caps(lines: _Outlines, caps: _Caps, wanted: BoolArray) -> Shapes:
    """Return one convex piece for each wanted side and for each wanted corner with more than one vertex."""
    side = np.flatnonzero(wanted & (lines.length > 0))
    end = lines.after[side]
    eaten = lines.radius * np.tan(np.abs(lines.turn) / 2)
    # a vertex shared by two pieces spares a crossing at a tiny angle; only where both sides are long enough for it
    shared = (lines.turn > 0) | (2 * eaten <= np.minimum(lines.length, lines.length[lines.before]))
    out = lines.radius[side, None] * lines.normal[side]
    leaving = np.where(shared[side, None], caps.at[caps.last[side]], lines.at[side] + out)
    arriving = np.where(shared[end, None], caps.at[caps.first[end]], lines.at[end] + out)
    sides = shapely.polygons(np.stack([lines.at[side], lines.at[end], arriving, leaving], axis=1))

    fan = np.flatnonzero((wanted & (caps.last > caps.first))[caps.owner])
    apex = np.unique(caps.owner[fan])
    owner = np.concatenate([apex, caps.owner[fan]])
    order = np.argsort(owner, kind="stable")
    vertices = np.concatenate([lines.at[apex], caps.at[fan]])[order]
    numbers = np.unique(owner[order], return_inverse=True)[1]
    fans = shapely.polygons(shapely.linearrings(vertices, indices=numbers)) if len(apex) else []

    pieces: Shapes = np.concatenate([sides, np.asarray(fans, dtype=object)])
    flat = ~shapely.is_valid(pieces)
    pieces[flat] = shapely.convex_hull(pieces[flat])
    kept: Shapes = pieces[shapely.area(pieces) > 0]
    return kept
