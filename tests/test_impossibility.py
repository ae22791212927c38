"""What is called impossible is impossible, and what plainly is impossible is proved to be."""

from __future__ import annotations

import math
from dataclasses import replace
from itertools import combinations
from typing import Any

import numpy as np
import pytest
import shapely
from hypothesis import example, given, settings
from hypothesis import strategies as st
from numpy.typing import NDArray

from strategies import team_scenes
from taut.certificate import certify
from taut.errors import NoPath, NoPlanExists, NoPlanFound
from taut.formats import load_scene, scene_names
from taut.freespace import FreeSpace
from taut.motion import Plan, Trajectory
from taut.scene import Circle, Line, Point, Polygon, Rectangle, Robot, Scene
from taut.team import _impossibility_kernels as kernels
from taut.team import plan
from taut.team.impossibility import Impossible, first_impossible, impossible_pair, outer_space
from taut.validation import validate

Floats = NDArray[np.float64]

CORRIDOR = (0.0, 0.0, 14.0, 1.0)


def disc(name: str, start: Point, goal: Point, radius: float = 0.35, **more: object) -> Robot:
    return Robot(name, start, goal, radius, **more)  # type: ignore[arg-type]


def swap(workspace: Any = CORRIDOR, radius: float = 0.35, obstacles: Any = (), **more: Any) -> Scene:
    """Two robots that change ends of a corridor along the x axis."""
    ends = (1.0, 0.5), (13.0, 0.5)
    return Scene(workspace, obstacles, [disc("A", *ends, radius), disc("B", *ends[::-1], radius)], **more)


def bay(depth: float, width: float = 1.0) -> list[Point]:
    """A corridor 14 m long and 1 m wide with a bay on its upper side, up to a height."""
    return [(0, 0), (14, 0), (14, 1), (7 + width, 1), (7 + width, depth), (7, depth), (7, 1), (0, 1)]


def proved(scene: Scene) -> Impossible:
    found = impossible_pair(scene, 0, 1)
    assert found is not None
    return found


# --- What cannot be ---------------------------------------------------------------------------------------------------


def turned(scene: Scene, angle: float) -> Scene:
    """The same world turned about the origin."""
    c, s = math.cos(angle), math.sin(angle)

    def turn(p: Point) -> Point:
        return c * p[0] - s * p[1], s * p[0] + c * p[1]

    robots = [replace(r, start=turn(r.start), goal=turn(r.goal)) for r in scene.robots]
    return Scene([turn(p) for p in scene.workspace], robots=robots, gap=scene.gap, at_goal=scene.at_goal)


@pytest.mark.parametrize("angle", [0.0, 0.3, math.pi / 2, 2.5])
@pytest.mark.parametrize("at_goal", ["stay", "leave"])
def test_two_do_not_change_ends_of_a_narrow_corridor(angle: float, at_goal: Any) -> None:
    found = proved(turned(swap(gap=0.05, at_goal=at_goal), angle))
    assert found.kind == "cannot pass"
    assert set(found.robots) == {"A", "B"}
    assert found.width == pytest.approx(1.0, abs=1e-6)
    assert found.needed == pytest.approx(1.45)


SHAPES: dict[str, list[Point]] = {
    "ell": [(0, 0), (9, 0), (9, 9), (8, 9), (8, 1), (0, 1)],
    "zigzag": [(0, 0), (4, 0), (4, 3), (9, 3), (9, 9), (8, 9), (8, 4), (3, 4), (3, 1), (0, 1)],
    "wedge": [(0, 0), (9, 4), (9, 9), (8, 9), (8, 5), (0, 1.1)],
}


@pytest.mark.parametrize("name", SHAPES)
def test_two_do_not_change_ends_of_a_bent_corridor(name: str) -> None:
    ends = (0.8, 0.92) if name == "wedge" else (0.5, 0.5), (8.5, 8.5)
    scene = Scene(SHAPES[name], robots=[disc("A", *ends, 0.42), disc("B", *ends[::-1], 0.42)])
    validate(scene)
    found = proved(scene)
    assert found.kind == "cannot pass"


def test_two_do_not_pass_between_round_obstacles() -> None:
    pillars = [Circle((0.8 * k - 1, y), 1.5) for k in range(21) for y in (-1.3, 2.3)]
    assert proved(swap((-1, -0.5, 15, 1.5), 0.2, pillars, clearance=0.01)).kind == "cannot pass"


def test_two_do_not_pass_between_thick_lines() -> None:
    walls = [Line([(-2, y), (16, y)], 0.2) for y in (-0.1, 1.1)]
    assert proved(swap((-1, -0.3, 15, 1.3), obstacles=walls)).kind == "cannot pass"


def test_one_that_stands_in_a_corridor_and_cannot_leave_it_is_in_the_way() -> None:
    robots = [disc("walker", (1, 0.5), (13, 0.5)), disc("post", (7, 0.5), (7, 0.5))]
    found = proved(Scene(CORRIDOR, robots=robots))
    assert found.robots == ("walker", "post")
    assert (found.kind, found.parked) == ("in the way", True)
    assert proved(Scene(CORRIDOR, robots=robots[::-1])).robots == ("walker", "post")
    assert "at_goal: leave for post" in found.sentences[1]
    assert impossible_pair(Scene(CORRIDOR, robots=[robots[0], replace(robots[1], at_goal="leave")]), 0, 1) is None


def test_one_in_the_only_door_that_has_no_room_to_move_holds_it_for_ever() -> None:
    """The large robot fits into a niche that it cannot leave; the small one would have to go through it."""
    walls = [Rectangle(4, 0, 2, 4.4, name="S"), Rectangle(4, 5.6, 2, 4.4, name="N")]
    posts = [Circle((3.6, 5.0), 0.05), Circle((6.4, 5.0), 0.05)]
    big = disc("big", (5, 5), (5, 5), 0.58)
    small = disc("small", (1, 5), (9, 5), 0.2)
    found = proved(Scene((0, 0, 10, 10), [*walls, *posts], [small, big]))
    assert found.robots == ("small", "big")
    assert found.kind == "in the way"


def test_nobody_gets_past_a_goal_in_a_dead_end() -> None:
    robots = [disc("first", (3, 0.5), (11, 0.5)), disc("second", (1, 0.5), (13, 0.5))]
    found = proved(Scene(CORRIDOR, robots=robots))
    assert found.robots == ("second", "first")
    assert (found.kind, found.parked) == ("in the way", False)
    assert impossible_pair(Scene(CORRIDOR, robots=[replace(robots[0], at_goal="leave"), robots[1]]), 0, 1) is None


def test_goals_that_are_too_near_cannot_both_be_kept() -> None:
    robots = [disc("A", (1, 0.5), (7, 0.5)), disc("B", (13, 0.5), (7.5, 0.5))]
    assert proved(Scene(CORRIDOR, robots=robots)).kind == "goals too near"


def test_a_hall_somewhere_else_does_not_hide_what_is_impossible() -> None:
    """A dead end off a large hall with pillars: the order in it cannot be changed but by way of the hall."""
    walls = [Rectangle(20, 0, 10, 9.5), Rectangle(20, 10.5, 10, 9.5)]
    pillars = [Circle((2.0 + 3 * x, 2.0 + 3 * y), 0.6) for x in range(6) for y in range(6)]
    deep = disc("deep", (29, 10), (24, 10))
    mouth = disc("mouth", (27, 10), (29, 10))
    scene = Scene((0, 0, 30, 20), [*walls, *pillars], [deep, mouth])
    assert impossible_pair(scene, 0, 1) is None  # both may go out into the hall
    gate = Rectangle(19.9, 9, 0.2, 1.4)
    found = proved(Scene((0, 0, 30, 20), [*walls, *pillars, gate], [deep, mouth]))
    assert found.robots == ("mouth", "deep")
    assert found.kind == "in the way"


# --- What can be ------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("radius", [0.3, 0.35, 0.45])
def test_a_bay_just_deep_enough_is_never_called_too_shallow(radius: float) -> None:
    """One waits at the bay's end, at depth − radius; the other goes by on the lower wall, at radius."""
    enough = 4 * radius
    assert impossible_pair(swap(bay(enough), radius), 0, 1, 200_000) is None
    assert proved(swap(bay(max(1.0, 0.97 * enough) + 1e-3), radius)) is not None


@pytest.mark.parametrize("gap", [0.0, 0.05])
def test_a_corridor_just_wide_enough_for_two_is_never_called_too_narrow(gap: float) -> None:
    width = 4 * 0.35 + gap
    assert impossible_pair(swap((0, 0, 14, width), gap=gap), 0, 1, 200_000) is None
    assert proved(swap((0, 0, 14, 0.96 * width), gap=gap)) is not None


@pytest.mark.parametrize("name", scene_names())
def test_ready_scenes_are_not_called_impossible(name: str) -> None:
    scene = load_scene(name)
    pairs = list(combinations(range(min(len(scene.robots), 8)), 2))
    assert first_impossible(scene, pairs, 200_000) is None


def test_a_robot_that_is_never_there_is_in_nobodys_way() -> None:
    robots = [disc("A", (1, 0.5), (13, 0.5)), disc("ghost", (7, 0.5), (7, 0.5), at_goal="leave")]
    assert impossible_pair(Scene(CORRIDOR, robots=robots), 0, 1) is None


@settings(max_examples=25, deadline=None)
@given(team_scenes(max_robots=4))
def test_what_has_a_certified_plan_is_not_called_impossible(scene: Scene) -> None:
    try:
        found = plan(scene)
    except (NoPlanExists, NoPlanFound, NoPath):
        return
    assert found.certificate.ok
    assert first_impossible(scene, combinations(range(len(scene.robots)), 2), 100_000) is None


def tree(rng: np.random.Generator, side: int) -> list[Point]:
    """A maze of corridors 1 m wide, without loops, some of its corners widened to small rooms."""
    seen, edges = {(0, 0)}, []
    while len(seen) < side * side:
        x, y = list(seen)[rng.integers(len(seen))]
        dx, dy = [(1, 0), (-1, 0), (0, 1), (0, -1)][rng.integers(4)]
        there = x + dx, y + dy
        if 0 <= there[0] < side and 0 <= there[1] < side and there not in seen:
            seen.add(there)
            edges.append(((x, y), there))
    halls = [shapely.box(2 * min(a[0], b[0]), 2 * min(a[1], b[1]), 2 * max(a[0], b[0]) + 1, 2 * max(a[1], b[1]) + 1)
             for a, b in edges]  # fmt: skip
    rooms = [
        shapely.box(2 * x - g, 2 * y - g, 2 * x + 1 + g, 2 * y + 1 + g) for x, y in seen for g in [rng.uniform(0, 0.4)]
    ]
    return [(float(x), float(y)) for x, y in shapely.union_all(halls + rooms).normalize().exterior.coords[:-1]]


def joint_motions(workspace: list[Point], radii: tuple[float, float], rng: np.random.Generator) -> list[Floats]:
    """Motions of two discs found by sampling both at once: (k, 4) places, joined by straight simultaneous moves."""
    least = sum(radii)
    rooms = [shapely.Polygon(workspace).buffer(-r - 1e-4, quad_segs=64) for r in radii]
    for room in rooms:
        shapely.prepare(room)
    x0, y0, x1, y1 = shapely.bounds(rooms[0])
    drawn = rng.uniform([x0, y0, x0, y0], [x1, y1, x1, y1], (40000, 4))
    free = shapely.contains_xy(rooms[0], drawn[:, :2]) & shapely.contains_xy(rooms[1], drawn[:, 2:])
    drawn = drawn[free & (np.hypot(*(drawn[:, :2] - drawn[:, 2:]).T) >= least)][:900]
    tail, head = np.nonzero(np.linalg.norm(drawn[:, None] - drawn[None], axis=2) < 1.6)
    tail, head = tail[tail < head], head[tail < head]
    a, b = drawn[tail], drawn[head]
    apart, step = a[:, :2] - a[:, 2:], (b - a)[:, :2] - (b - a)[:, 2:]
    share = np.clip(-(apart * step).sum(axis=1) / np.maximum((step**2).sum(axis=1), 1e-12), 0, 1)
    good = np.hypot(*(apart + share[:, None] * step).T) >= least
    for k, room in enumerate(rooms):
        lines = shapely.linestrings(np.stack([a[:, 2 * k : 2 * k + 2], b[:, 2 * k : 2 * k + 2]], axis=1))
        good &= shapely.covers(room, lines)
    links: dict[int, list[int]] = {}
    for u, v in zip(tail[good].tolist(), head[good].tolist(), strict=True):
        links.setdefault(u, []).append(v)
        links.setdefault(v, []).append(u)
    out = []
    for source in rng.permutation(list(links))[:3].tolist():
        before, queue = {source: -1}, [source]
        for u in queue:
            for v in links[u]:
                if v not in before:
                    before[v] = u
                    queue.append(v)
        state, way = queue[-1], []
        while state >= 0:
            way.append(drawn[state])
            state = before[state]
        out.append(np.array(way[::-1]))
    return out


@settings(max_examples=10, deadline=None)
@given(st.integers(0, 2**32 - 1), st.floats(0.15, 0.45), st.floats(0.15, 0.45), st.booleans())
@example(4, 0.3, 0.3, True)
def test_what_two_discs_do_is_not_called_impossible(seed: int, first: float, second: float, stay: bool) -> None:
    """Also in mazes that hardly have room for what they do."""
    rng = np.random.default_rng(seed)
    workspace = tree(rng, 3)
    for way in joint_motions(workspace, (first, second), rng):
        a, b = way[:, :2], way[:, 2:]
        robots = [
            disc("A", tuple(a[0].tolist()), tuple(a[-1].tolist()), first, speed=10.0),
            disc("B", tuple(b[0].tolist()), tuple(b[-1].tolist()), second, speed=10.0),
        ]
        scene = Scene(workspace, robots=robots, at_goal="stay" if stay else "leave")
        times = np.arange(len(way), dtype=np.float64)[:, None]
        motions = [Trajectory(r.name, np.hstack([times, p])) for r, p in zip(robots, (a, b), strict=True)]
        assert certify(Plan(replace(scene, at_goal="stay"), tuple(motions))).ok
        assert impossible_pair(scene, 0, 1, 300_000) is None


@settings(max_examples=25, deadline=None)
@given(st.integers(0, 2**32 - 1), st.just(0.0) | st.floats(1e-6, 0.5))
def test_the_outer_space_holds_every_place_that_keeps_the_distance(seed: int, growth: float) -> None:
    rng = np.random.default_rng(seed)
    x, y = rng.uniform(1, 9, (2, 6)).tolist()
    circle = Circle((x[0], y[0]), 0.8)
    line = Line([(x[1], y[1]), (x[2], y[2]), (x[3], y[3])], 0.3)
    polygon = Polygon([(x[4], y[4]), (x[4] + 1, y[4]), (x[4], y[4] + 1.5)])
    scene = Scene((0, 0, 10, 10), [circle, line, polygon])
    cores = [shapely.Point(x[0], y[0]), shapely.LineString(line.core), shapely.Polygon(polygon.core)]
    radii = np.array([circle.radius, line.width / 2, 0.0])
    angle = rng.uniform(0, math.tau, 400)
    round_it = np.stack([np.cos(angle), np.sin(angle)], axis=1)
    corners = np.concatenate([circle.core, line.core, polygon.core])
    which = rng.integers(len(corners), size=400)
    places = corners[which] + (radii[[0, 1, 1, 1, 2, 2, 2]][which] + growth)[:, None] * round_it
    away = shapely.distance(np.array(cores)[:, None], shapely.points(places)) - radii[:, None]
    inside = ((places >= growth) & (places <= 10 - growth)).all(axis=1)
    free = inside & (away >= growth - scene.tol / 2).all(axis=0)
    free &= ~shapely.contains_properly(cores[2], shapely.points(places))
    assert outer_space(scene, growth).contains(places[free]).all()


@settings(max_examples=25, deadline=None)
@given(st.integers(0, 2**32 - 1), st.integers(1, 6))
def test_halving_loses_no_place_and_no_door(seed: int, rounds: int) -> None:
    """A door lost would make a false proof."""
    rng = np.random.default_rng(seed)
    holes = [Circle((x, y), 0.6) for x, y in rng.uniform(1, 9, (4, 2)).tolist()]
    mesh = FreeSpace(Scene((0, 0, 10, 10), holes), 0.1, 0.1).mesh
    vertices, triangles = mesh.vertices, mesh.triangles
    # the wall on the left becomes the side of an open place
    left = vertices[:, 0].min() + 1e-9
    at_left = (vertices[triangles][..., 0] < left) & (np.roll(vertices[triangles], -1, axis=1)[..., 0] < left)
    neighbours = np.where((mesh.neighbours < 0) & at_left, -5, mesh.neighbours)
    assert (neighbours == -5).any()
    area = shapely.area(shapely.polygons(vertices[triangles])).sum()
    for _ in range(rounds):
        marked = rng.random(len(triangles)) < 0.3
        before = len(triangles)
        vertices, triangles, neighbours, count = kernels.halved(vertices, triangles, neighbours, marked, 100_000)
        assert count == len(triangles) >= before + marked.sum()
    shapes = shapely.polygons(vertices[triangles])
    assert shapely.area(shapes).min() > 0
    assert shapely.area(shapes).sum() == pytest.approx(area, rel=1e-12)
    assert all(shapely.is_ccw(shapely.get_exterior_ring(shapes)))
    of_side: dict[tuple[int, int], int] = {}
    for t, corners in enumerate(triangles.tolist()):
        for k in range(3):
            of_side[corners[k], corners[(k + 1) % 3]] = t
    for (a, b), t in of_side.items():
        k = triangles[t].tolist().index(a)
        outside = -5 if max(vertices[a, 0], vertices[b, 0]) < left else -1
        assert neighbours[t, k] == of_side.get((b, a), outside)


# --- Input ------------------------------------------------------------------------------------------------------------


def test_few_states_allowed_prove_nothing() -> None:
    assert impossible_pair(swap(gap=0.05), 0, 1, most_states=10) is None


@pytest.mark.parametrize("pair", [(0, 0), (0, 2), (-1, 0)])
def test_pairs_are_of_two_robots_of_the_scene(pair: tuple[int, int]) -> None:
    with pytest.raises(IndexError, match="two robots"):
        impossible_pair(swap(), *pair)


def test_every_proof_tells_who_and_where_and_what_would_help() -> None:
    for scene in (
        swap(gap=0.05),
        Scene(CORRIDOR, robots=[disc("A", (1, 0.5), (13, 0.5)), disc("B", (7, 0.5), (7, 0.5))]),
    ):
        why, mend = proved(scene).sentences
        assert why.startswith("No plan exists: ")
        assert "A" in why
        assert "B" in why
        assert "1.00 m wide" in why
        assert "would help" in mend


@pytest.mark.parametrize("size", [1e-9, 1e-3, 1e6])
def test_size_does_not_matter(size: float) -> None:
    def scaled(p: Point) -> Point:
        return p[0] * size, p[1] * size

    scene = swap(bay(1.0))
    robots = [replace(r, start=scaled(r.start), goal=scaled(r.goal), radius=r.radius * size) for r in scene.robots]
    assert proved(Scene([scaled(p) for p in scene.workspace], robots=robots)).kind == "cannot pass"


def test_point_robots_keep_the_gap() -> None:
    assert proved(swap((0, 0.45, 14, 0.55), 0.0, gap=0.2)).kind == "cannot pass"
    assert impossible_pair(swap((0, 0.3, 14, 0.7), 0.0, gap=0.2), 0, 1) is None
