"""Whether a scene can be used: rings that bound something, starts and goals in reach of nothing they may not touch."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
import shapely
from numpy.typing import NDArray
from scipy.sparse import coo_array
from scipy.sparse.csgraph import connected_components

from taut.errors import GoalBlocked, SceneError, StartBlocked, rounded_down
from taut.scene import Circle, FloatArray, Line, Obstacle, Rectangle, Robot, Scene

IntArray = NDArray[np.int64]

# products of four coordinates must neither overflow nor vanish in the exact predicates
_LARGEST = 1e70
_BOUNDS = f"beyond {_LARGEST:g} and below {1 / _LARGEST:g} nothing can be computed, use other units"
_SIZES: dict[type, tuple[str, ...]] = {Circle: ("radius",), Line: ("width",), Rectangle: ("width", "height")}
_NAMED = 5
# so many of the largest obstacles that might hold another are tried; more matters only in heaps of thousands
_HOLDERS = 16


def validate(scene: Scene) -> tuple[str, ...]:
    """Check a scene and return what a person should know about it.

    Rings must bound an area and neither cross nor touch themselves (a corner given twice in a row and a closing repeat
    of the first are tolerated). Starts and goals must keep radius + clearance from the workspace's wall and from every
    obstacle, less the scene's tolerance, and must not be shut in between obstacles or walls that leave a gap of zero
    width. Robots that stand must be separate: all at their starts, those that stay at their goals. A scene without
    robots is fine.

    Returns
    -------
    tuple of str
        Notes: which obstacles overlap or touch and count as one, leave the workspace, lie outside it or in another.

    Raises
    ------
    StartBlocked, GoalBlocked
        Names the robot, the obstacle, the place and the metres.
    SceneError
        A ring that is none, two robots too close, two point robots without gap, a number beyond 1e±70.
    """
    with np.errstate(all="ignore"):  # shapely warns of tiny numbers in an otherwise common scene
        return _validated(scene, scene.tol)


def check_form(scene: Scene) -> None:
    """Check what does not depend on where the robots stand, and without which nothing can be proved of their motions.

    Raises
    ------
    SceneError
        Numbers too large or too small, a ring that is none, two point robots without gap.
    """
    check_numbers(scene)
    _check_rings(scene)
    _check_point_robots(scene)


def check_numbers(scene: Scene) -> None:
    """Refuse numbers with which the formulas would overflow or vanish; zero is none of them.

    Raises
    ------
    SceneError
        The largest coordinate, or a size, is beyond 1e±70.
    """
    largest = 2.0**40 * scene.tol
    if not 1 / _LARGEST < largest < _LARGEST:
        raise SceneError(f"the scene's largest coordinate is {largest:.3g} m; {_BOUNDS}")
    numbers: list[tuple[Scene | Robot | Obstacle, str]] = [(scene, what) for what in ("clearance", "gap", "headway")]
    for robot in scene.robots:
        numbers += [(robot, what) for what in ("radius", "speed", "start_time", "clearance")]
    for obstacle in scene.obstacles:
        numbers += [(obstacle, what) for what in _SIZES.get(type(obstacle), ())]
    for thing, what in numbers:
        value = getattr(thing, what)
        if value and not 1 / _LARGEST < value < _LARGEST:
            kind = "robot" if isinstance(thing, Robot) else "obstacle"
            who = "the scene" if isinstance(thing, Scene) else f"{kind} {_name(thing)}"
            raise SceneError(f"{who}: {what} is {value:.3g}; {_BOUNDS}")


def _validated(scene: Scene, tol: float) -> tuple[str, ...]:
    check_form(scene)
    ground = _Ground.of(scene)
    robots = scene.robots
    growths = np.array([scene.growth(robot) for robot in robots], dtype=np.float64)
    starts = np.array([robot.start for robot in robots], dtype=np.float64).reshape(-1, 2)
    goals = np.array([robot.goal for robot in robots], dtype=np.float64).reshape(-1, 2)
    _check_places(scene, ground, starts, growths, "start", tol)
    _check_places(scene, ground, goals, growths, "goal", tol)
    stays = np.array([scene.stays(robot) for robot in robots], dtype=bool)
    # a robot that leaves from its goal and starts there is present on [0, 0): never
    present = stays | (starts != goals).any(axis=1)
    _check_pairs(scene, starts, np.flatnonzero(present), "start", tol)
    _check_pairs(scene, goals, np.flatnonzero(stays), "goal", tol)
    return _notes(scene, ground, tol)


@dataclass(frozen=True)
class _Ground:
    """The workspace and the obstacles as shapely geometries."""

    workspace: shapely.Polygon
    wall: shapely.LinearRing
    wall_sides: shapely.STRtree  # its edges one by one
    cores: NDArray[Any]
    radii: FloatArray
    tree: shapely.STRtree  # boxes round the whole obstacles, their own radius included

    @classmethod
    def of(cls, scene: Scene) -> _Ground:
        workspace = shapely.Polygon(_without_repeats(np.array(scene.workspace)))
        wall = workspace.exterior
        cores = np.array([_core(obstacle) for obstacle in scene.obstacles], dtype=object)
        radii = np.array([obstacle.own_radius for obstacle in scene.obstacles], dtype=np.float64)
        boxes = shapely.bounds(cores).reshape(-1, 4)
        grown = shapely.box(*(boxes + radii[:, None] * [-1, -1, 1, 1]).T)
        shapely.prepare([workspace, wall])
        shapely.prepare(cores)
        corners = shapely.get_coordinates(wall)
        wall_sides = shapely.STRtree(shapely.linestrings(np.stack([corners[:-1], corners[1:]], axis=1)))
        return cls(workspace, wall, wall_sides, cores, radii, shapely.STRtree(grown))


def _core(obstacle: Obstacle) -> shapely.Geometry:
    core = obstacle.core
    if obstacle.closed:
        return shapely.Polygon(_without_repeats(core))
    return shapely.LineString(core) if len(core) > 1 else shapely.Point(core[0])


def _check_rings(scene: Scene) -> None:
    rings = [("the workspace", np.array(scene.workspace, dtype=np.float64))]
    rings += [(f"obstacle {_name(o)}", o.core) for o in scene.obstacles if o.closed]
    corners = [_without_repeats(ring) for _, ring in rings]
    for (who, ring), kept in zip(rings, corners, strict=True):
        if len(kept) < 3:
            raise SceneError(f"{who} has zero area: only {len(kept) or 1} of its {len(ring)} corners are different")
    lengths = [len(kept) for kept in corners]
    closed = shapely.linearrings(np.concatenate(corners), indices=np.repeat(np.arange(len(corners)), lengths))
    bad = np.flatnonzero(~shapely.is_valid(shapely.polygons(closed)))
    if bad.size:
        raise SceneError(f"{rings[bad[0]][0]} {_ring_fault(corners[bad[0]])}")


def _without_repeats(ring: FloatArray) -> FloatArray:
    """Drop corners equal to the one before; the first counts as following the last."""
    return np.asarray(ring[(ring != np.roll(ring, 1, axis=0)).any(axis=1)], dtype=np.float64)


def _ring_fault(ring: FloatArray) -> str:
    """Say what is wrong with a ring that is not simple, and where."""
    if shapely.convex_hull(shapely.MultiPoint(ring)).geom_type != "Polygon":
        return (
            f"has zero area: all its corners lie on one line, from {_at(ring.min(axis=0))} to {_at(ring.max(axis=0))}"
        )
    n = len(ring)
    edges = shapely.linestrings(np.stack([ring, np.roll(ring, -1, axis=0)], axis=1))
    i, j = shapely.STRtree(edges).query(edges, predicate="intersects")
    i, j = i[i < j], j[i < j]
    met = shapely.intersection(edges[i], edges[j])
    along = shapely.length(met) > 0
    crossing = shapely.crosses(edges[i], edges[j])
    neighbours = (j - i == 1) | (j - i == n - 1)
    order = np.lexsort((j, i))
    for k in order[crossing[order] & ~neighbours[order]]:
        place = _at(shapely.get_coordinates(met[k])[0])
        return f"crosses itself at {place} (its edges {i[k] + 1} and {j[k] + 1}); reorder or move its corners"
    for k in order[along[order]]:
        corner = ring[j[k] if j[k] - i[k] == 1 else i[k]]
        if neighbours[k]:
            return f"has a spike of zero width at {_at(corner)}; remove that corner"
        place = _at(shapely.get_coordinates(met[k])[0])
        return f"runs back over itself at {place} (its edges {i[k] + 1} and {j[k] + 1}); move its corners apart"
    for k in order[~neighbours[order]]:
        place = _at(shapely.get_coordinates(met[k])[0])
        return f"touches itself at {place}; split it there into simple polygons or move the corner"
    return "crosses or touches itself; draw it as a simple polygon"


def _check_places(
    scene: Scene, ground: _Ground, points: FloatArray, growths: FloatArray, what: str, tol: float
) -> None:
    """Refuse the first robot whose start (or goal) is too near to a wall or obstacle."""
    geometries = shapely.points(points)
    to_wall = _distance_to_wall(ground, geometries)
    boxes = shapely.box(*np.concatenate([points - growths[:, None], points + growths[:, None]], axis=1).T)
    robot, obstacle = ground.tree.query(boxes)
    room = _distance_to_core(ground, obstacle, geometries[robot]) - ground.radii[obstacle]
    short_of_wall = np.flatnonzero(to_wall < growths - tol)
    short = np.flatnonzero(room < growths[robot] - tol)
    for k in sorted({*short_of_wall.tolist(), *robot[short].tolist()}):
        if to_wall[k] < growths[k] - tol and to_wall[k] < 0:
            raise _blocked(scene, k, what, f"lies outside the workspace by {_metres(-to_wall[k])} m; move it inside")
        near = short[robot[short] == k]
        worst = near[np.argmin(room[near])] if near.size else None
        if worst is None or to_wall[k] < room[worst]:
            raise _blocked(scene, k, what, _too_near(scene, k, to_wall[k], "the wall of the workspace"))
        raise _blocked(scene, k, what, _too_near(scene, k, room[worst], f"obstacle {_name_of(scene, obstacle[worst])}"))
    touching = robot[room <= growths[robot] + tol]
    for k in np.unique(np.concatenate([touching, np.flatnonzero(to_wall <= growths + tol)])):
        near = obstacle[(robot == k) & (room <= growths[robot] + tol)]
        if _shut_in(ground, near, points[k], growths[k], tol):
            names = _list(
                [f"obstacle {_name_of(scene, o)}" for o in near] + ["the wall"] * bool(to_wall[k] <= growths[k] + tol)
            )
            raise _blocked(scene, k, what, f"is shut in: no room but a gap of zero width beside {names}; move it")


def _distance_to_wall(ground: _Ground, points: NDArray[Any]) -> FloatArray:
    """Return the distance of each point to the wall of the workspace, negative outside."""
    (index, _), distance = ground.wall_sides.query_nearest(points, return_distance=True, all_matches=False)
    out = np.empty(len(points))
    out[index] = distance
    return np.where(shapely.covers(ground.workspace, points), out, -out)


def _distance_to_core(ground: _Ground, obstacle: IntArray, points: NDArray[Any]) -> FloatArray:
    """Return the distance of each point to the core of its obstacle, negative inside."""
    cores = ground.cores[obstacle]
    distance = shapely.distance(cores, points)
    inside = np.flatnonzero((shapely.get_type_id(cores) == 3) & (distance == 0))
    distance[inside] = -shapely.distance(shapely.get_exterior_ring(cores[inside]), points[inside])
    return np.asarray(distance, dtype=np.float64)


def _shut_in(ground: _Ground, near: IntArray, point: FloatArray, growth: float, tol: float) -> bool:
    """Whether nothing near the point is free but what is narrower than the tolerance: a seam.

    All is cut to a small window round the point. Sides are grown exactly, corners and circles are left as they are, so
    that what is called shut in is shut in. A free piece counts when it reaches the point and is not thinner than tol
    across the whole window.
    """
    half = 2.0**20 * tol
    window = shapely.box(*(point - half), *(point + half))
    around = shapely.box(*(point - half - growth), *(point + half + growth))
    blocks = _strips(ground.wall_sides.geometries[ground.wall_sides.query(around)], growth)
    for k in near:
        core, reach = ground.cores[k], growth + ground.radii[k]
        corners = shapely.get_coordinates(core)
        if len(corners) > 1:
            sides = shapely.linestrings(np.stack([corners[:-1], corners[1:]], axis=1))
            blocks += _strips(sides[shapely.dwithin(sides, shapely.Point(point), 2 * half + reach)], reach)
        if core.geom_type == "Polygon":
            blocks.append(core)
    taken = shapely.union_all(shapely.intersection(np.array(blocks, dtype=object), window))
    free = shapely.difference(shapely.intersection(ground.workspace, window), taken)
    pieces = shapely.get_parts(shapely.get_parts(free))
    reaches = shapely.distance(pieces, shapely.Point(point)) <= 2 * tol
    return not bool((reaches & (shapely.area(pieces) > tol * half)).any())


def _strips(sides: NDArray[Any], reach: float) -> list[shapely.Geometry]:
    """Return the rectangles of half-width `reach` along straight sides."""
    ends = shapely.get_coordinates(sides).reshape(-1, 2, 2)
    a, b = ends[(ends[:, 0] != ends[:, 1]).any(axis=1)].transpose(1, 0, 2)
    if reach == 0 or not len(a):
        return []
    along = (b - a) / np.hypot(*(b - a).T)[:, None]
    across = reach * np.stack([-along[:, 1], along[:, 0]], axis=1)
    return list(shapely.polygons(np.stack([a - across, b - across, b + across, a + across], axis=1)))


def _blocked(scene: Scene, k: int, what: str, why: str) -> SceneError:
    robot = scene.robots[k]
    place = robot.start if what == "start" else robot.goal
    error = StartBlocked if what == "start" else GoalBlocked
    return error(f"robot {_name(robot)}: {what} {_at(place)} {why}")


def _too_near(scene: Scene, k: int, room: float, what: str) -> str:
    robot = scene.robots[k]
    growth = scene.growth(robot)
    needs = f"needs {growth:.6g} m (radius {robot.radius:.6g} + clearance {growth - robot.radius:.6g})"
    if room < 0:
        return f"lies inside {what} by {_metres(-room)} m" + (f" and {needs} from it" if growth else "") + "; move it"
    fits = f" or keep a clearance of at most {rounded_down(room - robot.radius)} m" if room > robot.radius else ""
    return f"is only {_metres(room, growth)} m from {what} but {needs}; move it{fits}"


def _check_point_robots(scene: Scene) -> None:
    points = [robot for robot in scene.robots if robot.radius == 0]
    if scene.gap == 0 and len(points) > 1:
        names = f"{_name(points[0])} and {_name(points[1])}"
        raise SceneError(f"two point robots need gap > 0: {names} have radius 0; set `gap` or give them a radius")


def _check_pairs(scene: Scene, points: FloatArray, members: IntArray, what: str, tol: float) -> None:
    """Refuse the first two robots that are too close while they stand."""
    points = points[members]
    radii = np.array([scene.robots[k].radius for k in members], dtype=np.float64)
    half = (radii + scene.gap / 2)[:, None]
    boxes = shapely.box(*np.concatenate([points - half, points + half], axis=1).T)
    i, j = shapely.STRtree(boxes).query(boxes)
    i, j = i[i < j], j[i < j]
    needed = radii[i] + radii[j] + scene.gap
    apart = np.hypot(*(points[i] - points[j]).T)
    bad = np.flatnonzero(apart < needed - tol)
    if not bad.size:
        return
    k = bad[np.lexsort((j[bad], i[bad]))[0]]
    a, b = (scene.robots[members[m]] for m in (i[k], j[k]))
    sizes = f"radius {a.radius:.6g} + radius {b.radius:.6g} + gap {scene.gap:.6g}"
    who = f"robots {_name(a)} and {_name(b)}"
    mend = "move one" if what == "start" else "move one or let them leave (at_goal: leave)"
    verb = "start" if what == "start" else "stay at goals"
    if apart[k] == 0:
        raise SceneError(f"{who} {verb} on each other at {_at(points[i[k]])}, need {needed[k]:.6g} m ({sizes}); {mend}")
    raise SceneError(
        f"{who} {verb} only {_metres(apart[k], needed[k])} m apart, at {_at(points[i[k]])} and {_at(points[j[k]])}, "
        f"but need {needed[k]:.6g} m ({sizes}); {mend}"
    )


def _notes(scene: Scene, ground: _Ground, tol: float) -> tuple[str, ...]:
    if not scene.obstacles:
        return ()
    names = [_name(obstacle) for obstacle in scene.obstacles]
    outside, over = _beyond_workspace(ground)
    notes = []
    labels, inside = _united(ground, tol)
    sizes = np.bincount(labels)
    groups = [np.flatnonzero(labels == label) for label in np.flatnonzero(sizes > 1)[:_NAMED]]
    if groups:
        count, into = int(sizes[sizes > 1].sum()), int((sizes > 1).sum())
        which = _list(["+".join(names[k] for k in g[:_NAMED]) + "+…" * (len(g) > _NAMED) for g in groups], into)
        notes.append(f"{count} obstacles overlap or touch and count as {into}: {which}")
    where = ("inside another", "partly outside the workspace", "outside the workspace")
    for members, text in zip((inside, over, outside), where, strict=True):
        if members.any():
            count = int(members.sum())
            which = _list([names[k] for k in np.flatnonzero(members)[:_NAMED]], count)
            notes.append(f"{count} obstacle{'s lie' if count > 1 else ' lies'} {text}: {which}")
    return tuple(notes)


def _beyond_workspace(ground: _Ground) -> tuple[NDArray[np.bool_], NDArray[np.bool_]]:
    """Return which obstacles lie outside the workspace, and which partly."""
    within = shapely.covers(ground.workspace, ground.cores)
    meets = shapely.intersects(ground.workspace, ground.cores)
    reaches_wall = (ground.radii > 0) & shapely.dwithin(ground.wall, ground.cores, ground.radii)
    near = np.flatnonzero(reaches_wall)  # dwithin takes touching for reaching, and is fast
    reaches_wall[near] = shapely.distance(ground.wall, ground.cores[near]) < ground.radii[near]
    crossing = np.flatnonzero((ground.radii == 0) & meets & ~within)
    meets[crossing] = ~shapely.touches(ground.workspace, ground.cores[crossing])
    outside = ~meets & ~reaches_wall
    return outside, ~outside & ~(within & ~reaches_wall)


def _united(ground: _Ground, tol: float) -> tuple[IntArray, NDArray[np.bool_]]:
    """Return a label for each obstacle, equal for those that overlap or touch, and which lie inside another.

    Pairs whose answer is known already are left out: where thousands lie on one heap, that is nearly all of them.
    """
    n = len(ground.cores)
    labels, inside = np.arange(n), np.zeros(n, dtype=bool)
    first, size = 0, 16
    while first < n:
        a, b = ground.tree.query(ground.tree.geometries[first : first + size])
        a = a + first
        fresh = labels[a] != labels[b]
        joined = np.flatnonzero(fresh)[_touch(ground, a[fresh], b[fresh], tol)]
        graph = coo_array((np.ones(joined.size), (labels[a[joined]], labels[b[joined]])), shape=(n, n))
        labels = connected_components(graph, directed=False)[1].astype(np.int64)[labels]
        inside |= _held(ground, b, a)
        first, size = first + size, min(2 * size, 512)
    return labels, inside


def _touch(ground: _Ground, a: IntArray, b: IntArray, tol: float) -> NDArray[np.bool_]:
    """Whether obstacles overlap or touch: exactly for polygons, within the tolerance for round ones."""
    reach = ground.radii[a] + ground.radii[b]
    reach[reach > 0] += tol
    out = shapely.intersects(ground.cores[a], ground.cores[b])
    rest = ~out & (reach > 0)
    out[rest] = shapely.dwithin(ground.cores[a[rest]], ground.cores[b[rest]], reach[rest])
    return np.asarray(out, dtype=bool)


def _held(ground: _Ground, outer: IntArray, inner: IntArray) -> NDArray[np.bool_]:
    """Return which obstacles of `inner` lie wholly inside their polygon or circle; of two that are equal the later."""
    low, high = np.split(shapely.bounds(ground.tree.geometries), 2, axis=1)
    size = (high - low).sum(axis=1)
    boxed = (low[outer] <= low[inner]).all(axis=1) & (high[inner] <= high[outer]).all(axis=1) & (outer != inner)
    outer, inner = outer[boxed], inner[boxed]
    order = np.lexsort((-size[outer], inner))  # the largest first: in a heap nearly all lie in it
    outer, inner = outer[order], inner[order]
    held = np.zeros(len(size), dtype=bool)
    for _ in range(_HOLDERS):
        _, turn = np.unique(inner, return_index=True)
        big, small = outer[turn], inner[turn]
        holds = _holds(ground, big, small)
        later = holds & (big > small)
        holds[later] = ~_holds(ground, small[later], big[later])
        held[small[holds]] = True
        rest = ~held[inner]
        rest[turn] = False
        outer, inner = outer[rest], inner[rest]
    return held


def _holds(ground: _Ground, outer: IntArray, inner: IntArray) -> NDArray[np.bool_]:
    """Whether polygons and circles hold the other obstacle of their pair; lines are taken to hold none."""
    big, small = ground.cores[outer], ground.cores[inner]
    kind = shapely.get_type_id(big)
    out = np.zeros(len(outer), dtype=bool)
    polygon, circle = np.flatnonzero(kind == 3), np.flatnonzero(kind == 0)
    to_wall = shapely.distance(shapely.get_exterior_ring(big[polygon]), small[polygon])
    out[polygon] = shapely.covers(big[polygon], small[polygon]) & (to_wall >= ground.radii[inner[polygon]])
    farthest = shapely.hausdorff_distance(small[circle], big[circle])
    out[circle] = farthest + ground.radii[inner[circle]] <= ground.radii[outer[circle]]
    return out


def _name(thing: Robot | Obstacle) -> str:
    name = thing.name if len(thing.name) <= 60 else thing.name[:57] + "…"
    return "".join(c if c.isprintable() else repr(c)[1:-1] for c in name)


def _name_of(scene: Scene, k: int) -> str:
    return _name(scene.obstacles[k])


def _list(items: Sequence[str], count: int | None = None) -> str:
    """Return a few items in words, and how many more there are."""
    more = (len(items) if count is None else count) - min(len(items), _NAMED)
    return ", ".join(items[:_NAMED]) + (f" and {more} more" if more > 0 else "")


def _at(place: Sequence[float] | FloatArray) -> str:
    return f"({place[0]:.9g}, {place[1]:.9g})"


def _metres(amount: float, other: float | None = None) -> str:
    """Return an amount in as few digits as tell it from the other one."""
    return next(
        (f"{amount:.{d}g}" for d in (3, 6, 9, 12) if f"{amount:.{d}g}" != f"{other or 0.0:.{d}g}"), repr(amount)
    )
