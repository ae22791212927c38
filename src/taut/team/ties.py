"""Ties: which robots are in contact at their starts and goals, and the orders of planning that this leaves."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np
import shapely
from numpy.typing import NDArray

from taut.contact import Contact, sight_sides
from taut.contact.connectivity import k_connected
from taut.errors import SceneError
from taut.graph import Graph, algebraic_connectivity, components
from taut.scene import Scene
from taut.team._conflict_kernels import Floats, Ints
from taut.team._sight_kernels import Walls
from taut.team.partners import walls_of

Links = NDArray[np.bool_]


@dataclass(frozen=True, eq=False)
class Ties:
    """What is demanded of contact, and who is in contact where all robots start and where they end.

    Parameters
    ----------
    contact : the demand.
    need : with how many robots planned before it each is in contact at every instant; the first ones with all before.
    walls : what blocks the sight.
    resting : (n,) whether a robot is at its goal already: a base station, or one that has to make way at most.
    starts, goals : (n, n) whether two robots are in contact there; no robot with itself.
    """

    contact: Contact
    need: int
    walls: Walls
    resting: Links
    starts: Links
    goals: Links


def ties_of(scene: Scene, contact: Contact) -> Ties:
    """Return the ties of a team that is to stay in contact.

    For a Fiedler value λ2 every robot needs at least λ2 others, as λ2 is at most the connectivity of a graph that lacks
    an edge (Fiedler 1973).

    Raises
    ------
    SceneError
        No motion at all can keep contact: robots leave at their goals, or cannot be near enough to any other, or starts
        or goals are not connected as demanded. Says which robots.
    """
    leaving = [robot.name for robot in scene.robots if not scene.stays(robot)]
    if leaving:
        raise SceneError(
            f"contact: robot {leaving[0]} leaves at its goal and would be out of contact then; use at_goal: stay"
        )
    _require_room(scene, contact)
    walls = walls_of(sight_sides(scene, scene.tol / 2) if contact.sight else np.empty((0, 4)))
    need = max(contact.k, math.ceil(contact.lambda2 - 1e-9))
    return tied(scene, contact, need, walls, _refused)


def tied(
    scene: Scene, contact: Contact, need: int, walls: Walls, refuse: Callable[[str], Exception] | None = None
) -> Ties:
    """Return the ties of a team between its starts and goals; ``refuse`` gives what is raised where they do not do."""
    ends = [np.array([getattr(robot, which) for robot in scene.robots]).reshape(-1, 2) for which in ("start", "goal")]
    links = [_links(scene, places, contact, walls) for places in ends]
    if refuse is not None:
        for which, places, linked in zip(("starts", "goals"), ends, links, strict=True):
            said = _too_loose(scene, which, places, linked, contact, need)
            if said:
                raise refuse(said)
    resting = np.array([robot.start == robot.goal for robot in scene.robots], dtype=np.bool_)
    return Ties(contact, need, walls, resting, links[0], links[1])


def linked_order(ties: Ties, preference: Sequence[int], before: Sequence[tuple[int, int]] = ()) -> list[int]:
    """Return an order in which each robot starts and ends in contact with enough before it; the preferred ones first.

    Robots that are at their goals already come before all others, so that a base station stays where it is. Whoever may
    come next may come later, too, so who is preferred does not matter for how far an order gets, only who is the first.
    The longest order found is returned: whoever is missing cannot follow.

    Parameters
    ----------
    preference : all robots.
    before : pairs of robots (a, b) of which a has to come before b.
    """
    n = len(preference)
    need = min(ties.need, n - 1)
    preference = sorted(preference, key=lambda i: not ties.resting[i])
    longest: list[int] = []
    required: dict[int, set[int]] = {}
    for a, b in before:
        required.setdefault(b, set()).add(a)
    for first in preference:
        if required.get(first):
            continue
        order = [first]
        starts, goals = ties.starts[first].astype(int), ties.goals[first].astype(int)
        left = [i for i in preference if i != first]
        while left:
            enough = min(len(order), need)
            able = (
                i for i in left if starts[i] >= enough and goals[i] >= enough and required.get(i, set()) <= {*order}
            )
            following = next(able, None)
            if following is None:
                break
            order.append(following)
            left.remove(following)
            starts += ties.starts[following]
            goals += ties.goals[following]
        if len(order) > len(longest):
            longest = order
        if not left:
            break
    return longest


def _refused(said: str) -> SceneError:
    return SceneError(said)


def _links(scene: Scene, places: Floats, contact: Contact, walls: Walls) -> Links:
    across = places[:, None] - places[None]
    near = np.hypot(across[..., 0], across[..., 1]) <= contact.reach + scene.tol / 4
    np.fill_diagonal(near, False)
    if contact.sight and near.any():
        i, j = np.nonzero(np.triu(near))
        sights = shapely.linestrings(np.stack([places[i], places[j]], axis=1))
        sides = shapely.STRtree(shapely.linestrings(walls.sides.reshape(-1, 2, 2)))
        hidden = np.unique(sides.query(sights, predicate="intersects")[0])
        near[i[hidden], j[hidden]] = near[j[hidden], i[hidden]] = False
    return np.asarray(near, dtype=np.bool_)


def _require_room(scene: Scene, contact: Contact) -> None:
    """Refuse a range within which two discs cannot be."""
    robots = scene.robots
    if len(robots) < 2:
        return
    radii = np.array([robot.radius for robot in robots])
    # the nearest that another robot's centre can come
    nearest = radii + np.where(np.arange(len(radii)) == np.argmin(radii), np.partition(radii, 1)[1], radii.min())
    apart = nearest + scene.gap
    alone = np.flatnonzero(apart > contact.reach + scene.tol)
    if alone.size:
        i = int(alone[np.argmax(apart[alone])])
        raise SceneError(
            f"contact: robot {robots[i].name} can come no nearer than {apart[i]:.6g} m to any other (radii and gap), "
            f"beyond the range of {contact.reach:.6g} m"
        )


def _too_loose(scene: Scene, which: str, places: Floats, linked: Links, contact: Contact, need: int) -> str:
    """Why these places do not hold together as demanded; "" if they do."""
    n = len(places)
    if n < 2:
        return ""
    names = [robot.name for robot in scene.robots]
    graph = Graph.from_edges(n, np.argwhere(np.triu(linked)))
    part = components(graph)
    if part.any():
        sizes = np.bincount(part)
        lost = np.flatnonzero(part == np.argmin(sizes))
        others = np.flatnonzero(part != np.argmin(sizes))
        apart = np.hypot(*(places[lost][:, None] - places[others][None]).transpose(2, 0, 1))
        i, j = np.unravel_index(np.argmin(apart), apart.shape)
        seen = ", in sight" if contact.sight else ""
        return (
            f"contact: the {which} are not connected within {contact.reach:.6g} m{seen}: {_listed(names, lost)} "
            f"{'is' if len(lost) == 1 else 'are'} cut off; {names[lost[i]]} is {apart[i, j]:.6g} m from "
            f"{names[others[j]]}"
        )
    degrees = linked.sum(axis=1)
    weak = int(np.argmin(degrees))
    if degrees[weak] < min(need, n - 1):
        what = f"k = {contact.k}" if need == contact.k else f"lambda2 = {contact.lambda2:.6g}"
        return (
            f"contact: {what} needs every robot in contact with {min(need, n - 1)} others, but at the {which} "
            f"{names[weak]} has {degrees[weak]} within {contact.reach:.6g} m"
        )
    if not k_connected(n, graph.edges, contact.k):
        some = "a robot" if contact.k == 2 else f"some {contact.k - 1} robots"
        return (
            f"contact: the {which} are not {contact.k}-connected within {contact.reach:.6g} m: "
            f"{some} may fail and leave the others without contact"
        )
    value = algebraic_connectivity(graph)
    if value < contact.lambda2 * (1 - 1e-9):
        return f"contact: λ2 is {value:.6g} at the {which}, less than the {contact.lambda2:.6g} demanded"
    return ""


def _listed(names: Sequence[str], chosen: Ints, most: int = 5) -> str:
    shown = ", ".join(names[i] for i in chosen[:most])
    return shown if len(chosen) <= most else f"{shown} and {len(chosen) - most} more"
