"""Contact in pictures: the links between the robots of a plan, on the map and in motion."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Any

import numpy as np
from matplotlib.artist import Artist
from matplotlib.axes import Axes
from matplotlib.collections import LineCollection
from matplotlib.lines import Line2D

from taut.contact import (
    Contact,
    Contacts,
    bridges_at,
    contact_of,
    contacts,
    cut_vertices_at,
    graph_at,
    piece_at,
)
from taut.contact.core import Ints
from taut.errors import SceneError
from taut.figures.canvas import points_per_metre
from taut.figures.courses import hand_over
from taut.figures.labels import Label, write
from taut.figures.maps import draw_graph, draw_map, name_obstacles, outlines
from taut.figures.pictures import count, end_handles, line_handle, present_at, write_legend, write_title
from taut.figures.plans import draw_arrows, draw_paths, in_seconds, pale, route_of, samples
from taut.figures.style import BRIDGE, LINK, darker, mix, robot_colours
from taut.figures.teams import FEW_ROBOTS, draw_ends, draw_team, end_marks, mark_radius, visible_radii
from taut.motion import Plan
from taut.scene import FloatArray

THIN, THICK = 0.8, 3.6  # points: links as long as the range, links of no length
PALEST = 0.55  # share of the colour of links that is left to one as long as the range
SHADES = [mix("#ffffff", LINK, share) for share in np.linspace(PALEST, 1.0, 9)]
LEAST_BRIDGE = 1.6  # points
MANY_LINKS = 30  # more are drawn thinner
RING = 1.6  # points


def contacts_shown(plan: Plan, contact: Contact | float | None) -> Contacts | None:
    """Return the contacts that a picture of the plan shows: as given, else as the plan claims.

    None where the claim makes no sense: to say so is the certificate's part.

    Raises
    ------
    SceneError
        A range given that makes no sense, or a scene without a clear line of sight.
    """
    if contact is not None:
        demand = contact if isinstance(contact, Contact) else Contact(contact)
        return contacts(plan, demand.reach, demand.sight)
    claim = plan.claims.get("contact")
    try:
        demand = contact_of(claim if isinstance(claim, Mapping) else {})
        return contacts(plan, demand.reach, demand.sight)
    except SceneError:
        return None


def draw_linked(axes: Axes, plan: Plan, found: Contacts, graph: Any = None, time: float | None = None) -> None:
    """Draw map and paths of a plan, and over them its robots and their links at one time.

    Links are the thicker the nearer their robots. Bridges, whose loss would split the team, are red; robots whose loss
    would do so (cut vertices) have a red ring.

    Parameters
    ----------
    axes : where to draw.
    plan : what to draw.
    found : its contacts.
    graph : drawn under the paths, see `draw`.
    time : seconds; by default when λ2 is least.
    """
    moment = found.worst[0] if time is None else time
    piece = piece_at(found, max(moment, 0.0))
    places = present_at(plan, moment)
    cuts = cut_vertices_at(found, piece)
    _draw_ground(axes, plan, graph)
    _set_links(_new_links(axes), found, piece, places)
    draw_team(axes, plan.scene.robots, places, robot_colours(len(places)))
    _draw_cuts(axes, plan, places, cuts)
    _write_names(axes, plan, found, piece, places, cuts)
    when = f"t = {in_seconds(moment)}" + (", when λ2 is least" if time is None else "")
    proved = plan.certificate is not None and plan.certificate.get("ok") is True
    facts = [when, count(len(places), "robot"), *(["certified"] if proved else [])]
    write_title(axes, plan.scene.name, " · ".join(facts), when)
    handles = [*end_handles(plan.scene), line_handle("link", LINK)]
    if len(bridges_at(found, piece)):
        handles.append(line_handle("bridge", BRIDGE))
    if len(cuts):
        handles.append(_ring_handle("cut vertex"))
    write_legend(axes, handles)


def cast_contact(
    axes: Axes, plan: Plan, found: Contacts
) -> tuple[Callable[[float, FloatArray], None], list[Artist], list[Artist]]:
    """Create what moves in an animation: the links on the map, and a hand over the course of λ2 under it.

    Returns
    -------
    update : sets them for a time in seconds and the places of the robots then, (n, 2) metres.
    under, over : the artists to be drawn before and after the robots.
    """
    links = _new_links(axes)
    links.set_animated(True)
    point, hand = hand_over(axes, found, plan.makespan)

    def update(time: float, places: FloatArray) -> None:
        piece = piece_at(found, time)
        _set_links(links, found, piece, places)
        point(time, piece)

    return update, [links], hand


def _draw_ground(axes: Axes, plan: Plan, graph: Any) -> None:
    scene, n = plan.scene, len(plan.trajectories)
    colours = robot_colours(n)
    draw_map(axes, scene)
    name_obstacles(axes, scene)
    if graph is not None:
        draw_graph(axes, graph)
    routes, faint = [route_of(t) for t in plan.trajectories], [mix(colour, "#ffffff", 0.55) for colour in colours]
    draw_paths(axes, routes, faint)
    draw_arrows(axes, routes, faint)
    draw_ends(axes, scene, pale(colours))


def _new_links(axes: Axes) -> LineCollection:
    lines = LineCollection([], zorder=6.5)
    lines.set_capstyle("round")
    axes.add_collection(lines, autolim=False)
    return lines


def _set_links(lines: LineCollection, found: Contacts, piece: int, places: FloatArray) -> None:
    """Set the links of a piece between robots at these places; strong ones lie over weak ones, bridges over all."""
    edges = graph_at(found, piece).edges
    ends = places[edges]
    code = np.array([len(places), 1])
    bridges = np.isin(edges @ code, bridges_at(found, piece) @ code)
    strength = np.clip(1 - np.hypot(*(ends[:, 0] - ends[:, 1]).T) / found.reach, 0, 1)
    widths = (THIN + (THICK - THIN) * strength) * min(1.0, (MANY_LINKS / max(len(edges), 1)) ** 0.5)
    widths[bridges] = np.maximum(widths[bridges], LEAST_BRIDGE)
    shades = np.rint(strength * (len(SHADES) - 1)).astype(np.int64)
    order = np.lexsort((strength, bridges))
    lines.set_segments(list(ends[order]))
    lines.set_linewidth(widths[order])
    lines.set_colors([BRIDGE if bridges[k] else SHADES[shades[k]] for k in order])


def _outer_radii(axes: Axes, plan: Plan) -> FloatArray:
    """Return the radii of the rings round the robots, in points."""
    mark = mark_radius(len(plan.trajectories))
    return visible_radii(axes, plan.scene.robots, 1.35 * mark) * points_per_metre(axes) + 0.8 * mark


def _draw_cuts(axes: Axes, plan: Plan, places: FloatArray, cuts: Ints) -> None:
    sizes = 4 * _outer_radii(axes, plan)[cuts] ** 2
    rings: dict[str, Any] = {"facecolors": "none", "edgecolors": BRIDGE, "linewidths": RING, "zorder": 8.5}
    axes.scatter(places[cuts, 0], places[cuts, 1], s=sizes, **rings)


def _write_names(axes: Axes, plan: Plan, found: Contacts, piece: int, places: FloatArray, cuts: Ints) -> None:
    """Name the robots where they are; of many only the cut vertices."""
    n = len(places)
    here = np.flatnonzero(np.isfinite(places).all(axis=1))
    named = here if n <= FEW_ROBOTS else cuts[:FEW_ROBOTS]
    names, radii, colours = found.names, _outer_radii(axes, plan), robot_colours(n)
    spots = places.tolist()
    labels = [Label(names[k], (spots[k][0], spots[k][1]), radii[k], darker(colours[k])) for k in named]
    marks = [*(((spots[k][0], spots[k][1]), radii[k]) for k in here), *end_marks(axes, plan.scene.robots, n)]
    lines = [places[edge] for edge in graph_at(found, piece).edges]
    write(axes, labels, marks, samples(axes, [*lines, *outlines(plan.scene)]))


def _ring_handle(label: str) -> Line2D:
    ring: dict[str, Any] = {"marker": "o", "markersize": 7.5, "markerfacecolor": "none", "markeredgewidth": RING}
    return Line2D([], [], linestyle="none", color=BRIDGE, label=label, **ring)
