"""Write docs/chapter5.md and its figures: python docs/make_chapter5.py."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import replace
from pathlib import Path

import numpy as np
import shapely
from chapter5_claims import claims
from chapter5_figures import draw
from chapter5_values import (
    ACROSS,
    CENTRAL,
    D_S,
    DELTA,
    DISTANCES,
    EDGES,
    ELSEWHERE,
    MRPPA,
    OCA,
    SCENES,
    WIDER,
    Chapter,
    Printed,
    chapter,
    clearance_of,
    sides_of,
)

import taut
from taut.errors import GoalBlocked
from taut.route import Hit, OcaRoute, Route, oca_between
from taut.scene import Point, Rectangle, Robot, Scene

DOCS = Path(__file__).resolve().parent


def page(done: Chapter) -> str:
    """Return the text of the page."""
    return (
        "\n\n".join(
            part.strip()
            for part in (
                _head(done),
                _steps(done),
                _tables(done),
                _central_tables(done),
                _added(done),
                _safety(done),
                _oca(done),
                _crowds(done),
                "## What is true of the claims\n\n"
                + _table(("the thesis says", "true?", "as found here"), claims(done)),
                _which(),
            )
        )
        + "\n"
    )


def _head(done: Chapter) -> str:
    central = [route for routes in done.central.values() for route in routes.values()]
    hit = sum(not route.free for route in central)
    as_ca, as_vg = _hits(done.grown_central[D_S]), _hits(done.once[D_S])
    return f"""# CA and OCA: chapter 5 of the thesis, repeated

*Made by `./dev docs` from the planners themselves; edit `docs/make_chapter5.py`.*

The second contribution of the [thesis](thesis.md) is to plan with only the obstacles that matter. Its **Central
Algorithm** (CA, 5.5) looks at those that the straight line from start to goal crosses, its **Optimisation Central
Algorithm** (OCA, 5.7) does so after all obstacles have been grown by a safety distance D_s. This page runs both on the
thesis' three scenes, beside the visibility graph (VG), and says what is true of the thesis' claims. In short:

- **CA** is here as it was written, and tells what its path hits. It is neither shortest nor complete, and of its
  {len(central)} paths on the thesis' scenes {hit} pass through an obstacle that the line does not cross.
- **OCA as it was written** does not mend that: on obstacles grown by D_s = {D_S:g} m {as_ca} of {len(central)} paths
  still hit one ({as_vg} of {len(central)} if the visibility graph of the crossed obstacles is searched instead).
- **OCA as it is here** repeats: it takes in what the path hits and searches again, until the path hits nothing. Then it
  is proved shortest, whatever was left out. On a map of 100,000 corners that takes milliseconds between near places
  ([measured](performance.md#one-path-on-a-map-rich-in-obstacles-time)).

```python
import taut

scene = taut.load_scene("thesis-2")
route = taut.central_path(scene, "R2")
print(route.length, [obstacle.name for obstacle in route.crossed], route.free, route.hits)

route = taut.oca_path(scene, "R1", clearance=0.3)  # clearance: the thesis' D_s
print(route.length, route.used, len(route.rounds), route.optimal)

routes = {{robot.name: taut.central_path(scene, robot) for robot in scene.robots}}
taut.save_figure(scene, "central.png", routes=routes)
```

```sh
taut compare thesis-2 --roadmaps visibility,oca,ca
```

## What can be compared

The lengths that the thesis prints (10, 9, 8, …) are sums of whole-number weights written on drawings by hand. They are
no metres and are shown here only to be recognised. Waypoints are coordinates, so the length of the path through them
is a fact; it stands beside ours. Tables 5.7, 5.9 and 5.11 start and end elsewhere than the figures that they belong to
(R1 of scene 2 at (3.5, 1), in figure 5.11 at (3, 1)): they seem to be read off pictures. There our paths are between
the ends that the table prints, so that like is compared with like. Scene 3 was reconstructed from a damaged list of
coordinates, in which all three straight lines are free. The thesis gives no δ and no D_s in numbers; here δ is
{DELTA:g} m (the default) and D_s {D_S:g} m. With D_s the workspace is widened by {WIDER:g} m on every side, since some
starts and goals lie on the wall."""


def _steps(done: Chapter) -> str:
    rows = []
    for name in ("thesis-1", "thesis-2"):
        for robot, route in done.central[name].items():
            sides = sides_of(route)
            left, right = ("–" if side is None else f"{side.length:.4f}" for side in (sides[1], sides[-1]))
            rows.append(
                (
                    f"{name[-1]}, {robot}",
                    ", ".join(f"{c.name} (m = {c.reach:.4f})" for c in route.crossed),
                    f"{len(route.waypoints)}" + (f" ({len(route.dropped)} dropped)" if route.dropped else ""),
                    f"{route.roadmap.graph.m}",
                    left,
                    right,
                    f"{route.length:.4f}",
                    _named(route.hits),
                )
            )
    heads = ("scene, robot", "crossed", "waypoints", "edges", "left only", "right only", "path", "hits")
    return f"""## CA, step by step (5.5, figures 5.20 to 5.26)

1. The **central baseline** CB is the segment from start to goal; obstacles that it crosses are the only ones used.
2. Where CB enters or leaves one, at **u**, two waypoints u′ = u ± (m + δ) n are set, n the unit normal of CB and m the
   greatest distance from CB of any vertex of that obstacle. Those outside the workspace or inside a crossed obstacle
   are dropped.
3. The **partial visibility graph** joins start, goal and waypoints by all segments that pass through no crossed
   obstacle.
4. Dijkstra's algorithm finds the shortest path in it.

![Steps of CA on scene 2](figures/chapter5-steps.png)

The thesis counts two possible paths a robot, one on each side of its baseline (figure 5.22). They are the columns "left
only" and "right only" below; the shortest path may change sides. As m is the same on both sides, the two are mirror
images and equally long unless something cuts one of them off, even if the obstacle reaches less far on one side:

![Two ways for every robot](figures/chapter5-two-ways.png)

{_table(heads, rows)}

In scene 1 all three paths hit something:

![CA on scene 1](figures/chapter5-ca-1.png)"""


def _tables(done: Chapter) -> str:
    rows = []
    allowed = shortest = 0
    for printed in MRPPA:
        route = done.shortest[printed.scene][printed.robot]
        rows.append(
            (
                f"{printed.table}: {printed.robot}",
                _way(printed.points),
                f"{printed.total}",
                f"{_along(printed.points):.4f}",
                _way(route.points),
                f"{route.length:.4f}",
            )
        )
        allowed += not taut.hits_of(done.plain[printed.scene], printed.points, 0.0)
        shortest += _along(printed.points) <= route.length * (1 + 1e-9)
    heads = ("table, robot", "waypoints in the thesis", "printed", "metres", "shortest (VG)", "metres")
    own = []
    for number, name in enumerate(SCENES, 1):
        scene, wide = done.plain[name], done.wide[name]
        for robot in scene.robots:
            direct, central = done.shortest[name][robot.name], done.central[name][robot.name]
            oca = done.oca[name][robot.name]
            room = f"{clearance_of(scene, central.points):.4f}" if central.free else f"hits {_named(central.hits)}"
            own.append(
                (
                    f"{number}, {robot.name}",
                    f"{direct.length:.4f}",
                    f"{clearance_of(scene, direct.points):.4f}",
                    f"{central.length:.4f}",
                    room,
                    f"{oca.length:.4f}",
                    f"{clearance_of(wide, oca.points):.4f}",
                    ", ".join(_round_corners(wide, oca)) or "straight",
                )
            )
    ways = (
        "scene, robot",
        "VG",
        "clearance",
        "CA",
        "clearance",
        f"OCA, D_s = {D_S:g}",
        "clearance",
        "OCA bends round the corners",
    )
    return f"""## Paths on the visibility graph (tables 5.1 to 5.6)

{_table(heads, rows)}

Of these {len(MRPPA)} paths of the thesis {allowed} are allowed, and {shortest} is shortest: its graphs lack edges.

## The three side by side (figures 5.26, 5.30, 5.32, 5.39)

Between the starts and goals of figures 5.6, 5.11 and 5.15; metres; clearance is the least distance from an obstacle.

{_table(ways, own)}

![CA (solid) against VG (dashed) on scene 2](figures/chapter5-against.png)"""


def _central_tables(done: Chapter) -> str:
    rows = []
    second = passing = 0
    for printed in (*CENTRAL, *OCA):
        scene = done.plain[printed.scene]
        points = np.array(printed.points)
        through = [
            f"{o.name} for {depth:.2f} m"
            for o in scene.obstacles
            if (depth := shapely.LineString(points).intersection(shapely.Polygon(o.core)).length) > 0
        ]
        if printed.scene == "thesis-2":
            second, passing = second + 1, passing + bool(through)
        rows.append(
            (
                f"{printed.table}: {printed.robot}",
                _way(printed.points),
                f"{printed.total}",
                f"{_along(printed.points):.4f}",
                ", ".join(through) or "nothing",
                *_between(scene, done.wide[printed.scene], printed),
            )
        )
    heads = (
        "table, robot",
        "waypoints in the thesis",
        "printed",
        "metres",
        "passes through",
        "shortest",
        "CA",
        f"OCA, D_s = {D_S:g}",
    )
    return f"""## The thesis' own paths by CA and OCA (tables 5.7 to 5.12)

Between the ends that these tables print:

{_table(heads, rows)}

On the coordinates that the thesis gives for scene 2, {passing} of {second} printed paths pass through an obstacle, and
table 5.11 ends R3 inside O4. The waypoints were read off a picture, or the map of these figures was drawn anew with
other coordinates; either way they do not show that "the paths planned generated by OCA are the shortest paths" and
safer.

Scene 3 with the ends of table 5.9 (figures 5.28 to 5.31): only R2's baseline crosses an obstacle.

![CA on scene 3 with the ends of table 5.9](figures/chapter5-ca-3.png)"""


def _added(done: Chapter) -> str:
    kept = ", ".join(done.elsewhere.kept)
    told = "\n".join(f"- {reason.partition(' at t')[0]}." for reason in done.across.changed.values())
    before = sum(route.length for route in done.oca["thesis-2"].values())
    return f"""## An obstacle more (figures 5.33 and 5.34)

"The paths of robots will not change unless the added obstacle interferes with those paths": true of plans, too, and
proved in each case. `taut.with_obstacle(plan, obstacle)` keeps every motion that `certify` still proves, plans the
other robots round those, and says who and why (`taut.replan` for several changes). Scene 2 with D_s = {D_S:g} m,
{before:.4f} m in all; two obstacles elsewhere, {_obstacles(ELSEWHERE)}: {kept} keep their motions, bit for bit.

![Obstacles added elsewhere](figures/chapter5-elsewhere.png)

Two obstacles across, {_obstacles(ACROSS)}: {", ".join(done.across.kept) or "nobody"} keeps his motion, and

{told}

Afterwards the paths are {done.across.plan.length:.4f} m in all (dashed: as they were).

![Obstacles added across](figures/chapter5-across.png)

The thesis' other sentence, that with a safety distance "even if we add other obstacle, the paths of robots will not
change", is not true: no distance makes a path immune to what is put on it."""


def _safety(done: Chapter) -> str:
    rows = []
    for distance in DISTANCES:
        cells = [done.lengths[distance][name][robot] for name in SCENES for robot in done.lengths[distance][name]]
        rows.append((f"{distance:g}", *(cell if isinstance(cell, str) else f"{cell:.4f}" for cell in cells)))
    robots = [f"{name[-1]}, {robot}" for name in SCENES for robot in done.lengths[0.0][name]]
    widest = (
        "widest",
        *(f"{done.passages[name][robot].clearance:.4f}" for name in SCENES for robot in done.passages[name]),
    )
    between = (
        "between",
        *(" and ".join(done.passages[name][robot].between) for name in SCENES for robot in done.passages[name]),
    )
    return f"""## The safety distance (5.7.1, figures 5.35 to 5.37)

The thesis' formula for D_s writes the distance of two points in polar coordinates,
D_s = r = √((r cos θ)² + (r sin θ)²): an identity, which fixes no D_s. It is a parameter: `clearance` of a scene or a
robot, in metres beyond the radius. Sides move out by exactly D_s; round corners are drawn by tangents outside the arc,
so no path is nearer than D_s.

![Obstacles of scene 2 grown by D_s](figures/chapter5-grown.png)

What D_s costs: the length of the shortest path in metres, by D_s, and the **widest** D_s for which there is one at all
(`taut.widest_passage`) with what is narrowest there:

{_table(("D_s", *robots), [*rows, widest, between])}

A D_s that swallows a start or goal is an error that says whose and how much would fit; where D_s only closes the way,
`taut.oca_path_or_widest` takes the widest passage and says so. `taut compare thesis-2 --clearance 0:0.5:0.1` draws such
curves for any map."""


def _oca(done: Chapter) -> str:
    rows = []
    for number, name in enumerate(SCENES, 1):
        vertices, edges = done.all_edges[name]
        central, tight, oca = done.central[name].values(), done.tight[name].values(), done.oca[name].values()
        rows.append(
            (
                f"{number}",
                f"{vertices}, {edges}",
                EDGES[name][0],
                _each(len(route.crossed) for route in central),
                _each(route.roadmap.graph.m for route in central),
                EDGES[name][1],
                _each(len(route.used) for route in tight),
                _each(_tangents(route) for route in tight),
                _each(len(route.used) for route in oca),
                _each(len(route.rounds) for route in oca),
            )
        )
    heads = (
        "scene",
        "VG: vertices, edges",
        "edges in the thesis",
        "CA: obstacles",
        "edges",
        "edges in the thesis",
        "OCA: obstacles",
        "edges",
        f"D_s = {D_S:g}: obstacles",
        "rounds",
    )
    grown = []
    for distance in DISTANCES:
        cells = [f"{distance:g}"]
        for found in (done.grown_central[distance], done.once[distance]):
            cells += [f"{sum(hits == () for hits in found)}", f"{_hits(found)}", f"{sum(h is None for h in found)}"]
        grown.append(cells)
    graph = "crossed obstacles' VG"
    readings = ("D_s", "CA: free", "hit another", "no way", f"{graph}: free", "hit another", "no way")
    return f"""## OCA (5.7.2, figures 5.38 to 5.40)

The thesis grows all obstacles and then looks at those that the baseline crosses. That is no cure: what else the path
meets is still not looked at. Read as CA on obstacles grown by D_s, and read as the visibility graph of the grown
obstacles that the baseline crosses, the paths of the nine robots of the three scenes are

{_table(readings, grown)}

So OCA is made exact:

1. Take the obstacles that, grown by D_s, the baseline meets. Find the shortest path among them only.
2. Look up which others this path comes nearer to than D_s. If there are any, take them in, and some beside them, and
   search again.
3. If there is none, the path is allowed among all. Leaving obstacles out only adds paths, so no path of the whole map
   is shorter: `optimal`. If there is no path among a few, there is none among all: OCA is complete.

Only obstacles that were taken in are ever grown. Where two of them leave no room, as O3 and O6 of scene 2 at
D_s = 0.5 m, the rounds go like this (coarse arcs are only used to find obstacles; exact rounds decide):

![Rounds of OCA](figures/chapter5-rounds.png)

The paths with D_s = {D_S:g} m, with the graph among the obstacles used; the others are outlined:

![OCA on scene 1](figures/chapter5-oca-1.png)

![OCA on scene 2](figures/chapter5-oca-2.png)

![OCA on scene 3](figures/chapter5-oca-3.png)

What is looked at, for each robot in turn. VG is the graph of all obstacles, starts and goals with every visible pair;
OCA's edges are those of the tangent graph of the obstacles it used, start and goal included, without D_s:

{_table(heads, rows)}"""


def _crowds(done: Chapter) -> str:
    rows = [
        (
            f"{c.obstacles}",
            f"{c.free} of {c.robots}",
            f"{c.hit}",
            f"{c.lost}",
            f"{c.longer:.4f}",
            f"{c.once}",
            f"{100 * c.used:.1f} %",
            f"{c.rounds:.1f}",
            "none" if not c.differ else f"{c.differ}",
        )
        for c in done.crowds
    ]
    heads = (
        "obstacles",
        "CA: free",
        "hit an obstacle",
        "no way found",
        "free ÷ shortest",
        "crossed obstacles' VG: free",
        "OCA: obstacles used",
        "rounds",
        "lengths that differ",
    )
    return f"""## Maps rich in obstacles

`taut.random_scene(robots=30, obstacles=…, seed=1, radius=0)`, point robots, no D_s, the hall larger the more obstacles:

{_table(heads, rows)}

Lengths that differ: of OCA from the shortest path on the whole map, by more than 10⁻¹² of it. The more obstacles, the
surer CA is to hit one, and the smaller the part that OCA looks at:

![OCA among 200 obstacles](figures/chapter5-rich.png)

`./dev bench central` measures both on maps of up to 100,000 corners, near and far, with and without D_s:
[time](performance.md#one-path-on-a-map-rich-in-obstacles-time) and
[what is looked at and found](performance.md#one-path-on-a-map-rich-in-obstacles-what-is-looked-at-and-found)."""


def _which() -> str:
    return """## Which one when

- **One path on a large map, or a map that changes all the time**: `oca_path`. Only a spatial index is prepared.
- **Many paths on one map**: `prepare`, then `paths` ([Shortest paths](paths.md)); one graph pays for all.
- **A team**: `plan`, on the visibility graph unless there is a reason.
- **The most room**: Voronoi; or D_s, which costs less length. `widest_passage` says how much fits.
- **Something simple to show or to port**: grid, PRM, cells ([Roadmaps](roadmaps.md)).
- **CA**: to follow the thesis, and as a quick guess that says whether it holds.

`taut compare SCENE` shows them on your map, every route proved:

```sh
taut compare thesis-2 --figure compare.png
taut compare thesis-2 --clearance 0:0.5:0.1 --figure clearance.png
```

![All ways on the ready scene office-20](figures/chapter5-compare.png)"""


def _tangents(route: OcaRoute) -> int:
    return taut.visibility_graph(route.freespace, points=route.points[[0, -1]]).graph.m


def _between(scene: Scene, wide: Scene, printed: Printed) -> tuple[str, str, str]:
    """Lengths between the ends of a printed path: shortest, by CA, by OCA with D_s."""
    a, b = printed.points[0], printed.points[-1]
    try:
        shortest = oca_between(scene, a, b).length
    except GoalBlocked:
        return "goal in an obstacle", "–", "–"
    lone = replace(scene, robots=(Robot("R", a, b),))
    central = taut.central_path(lone, "R", DELTA)
    hits = f", hits {_named(central.hits)}" if central.hits else ""
    try:
        safe = f"{oca_between(wide, a, b, D_S).length:.4f}"
    except GoalBlocked:
        safe = "goal too near"
    return f"{shortest:.4f}", f"{central.length:.4f}{hits}", safe


def _round_corners(scene: Scene, route: Route) -> list[str]:
    """The corners of obstacles round which a path bends, in turn."""
    corners = np.vstack([obstacle.core for obstacle in scene.obstacles])
    nearest = [corners[np.argmin(np.hypot(*(corners - p).T))] for p in route.points[1:-1]]
    return list(dict.fromkeys(_place(corner) for corner in nearest))


def _table(heads: Sequence[str], rows: Sequence[Sequence[str]]) -> str:
    lines = [heads, ["---"] * len(heads), *rows]
    return "\n".join(f"| {' | '.join(line)} |" for line in lines)


def _place(point: Iterable[float]) -> str:
    x, y = point
    return f"({x:.4g}, {y:.4g})"


def _way(points: Iterable[Iterable[float]]) -> str:
    return " ".join(map(_place, points))


def _along(points: Sequence[Point]) -> float:
    return Route(np.array(points)).length


def _named(hits: Iterable[Hit]) -> str:
    return ", ".join(dict.fromkeys(name for hit in hits for name in hit.obstacles)) or "nothing"


def _each(numbers: Iterable[int]) -> str:
    return ", ".join(map(str, numbers))


def _obstacles(added: Iterable[Rectangle]) -> str:
    return " and ".join(f"{o.name} at {_place((o.x, o.y))}" for o in added)


def _hits(found: Iterable[tuple[str, ...] | None]) -> int:
    return sum(bool(hits) for hits in found)


def main() -> None:
    """Compute everything, write the page and its figures."""
    done = chapter()
    (DOCS / "chapter5.md").write_text(page(done), encoding="utf-8")
    draw(done, DOCS / "figures")
    print(DOCS / "chapter5.md")


if __name__ == "__main__":
    main()
