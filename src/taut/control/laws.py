"""Control laws of teams on graphs: consensus, rendezvous, leaders and followers, formations.

A law is a vector field: from the time in seconds and the positions (n, 2) in metres it gives velocities (n, 2) in
metres a second. Vertex i of the graph is robot i, and w_ij is the weight of its edge to j; an edge of weight 0 does
not pull. Robots are points here, free to move through each other.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import TypeAlias

import numpy as np
from numpy.typing import ArrayLike, NDArray

from taut.graph import Graph
from taut.motion import Trajectory

Floats: TypeAlias = NDArray[np.float64]
Ints: TypeAlias = NDArray[np.int64]
Field: TypeAlias = Callable[[float, Floats], Floats]
Links: TypeAlias = Graph | Callable[[Floats], Graph]
Velocity: TypeAlias = Callable[[float], ArrayLike]


def consensus(links: Links) -> Field:
    """Everybody moves towards their neighbours: u_i = Σ_j w_ij (p_j − p_i).

    Parameters
    ----------
    links : the graph, or a function from positions (n, 2) to the graph there, for links that come and go.

    Notes
    -----
    On a fixed graph p' = −L p: the centroid rests, and each connected part gathers at its own. On a connected graph
    the distance from the centroid falls at least as fast as e^(−λ2 t). With links that come and go a team that was
    connected may fall apart, see `rendezvous`; and the field jumps where a link does, which costs `integrate` many
    short steps: weights that fade to 0 at the range avoid that. The thesis prints p_i − p_j in (4.3), which
    drives robots apart.

    >>> field = consensus(Graph.from_edges(2, [(0, 1)]))
    >>> field(0.0, np.array([[0.0, 0.0], [4.0, 2.0]]))
    array([[ 4.,  2.],
           [-4., -2.]])
    """
    linked = _links_at(links)

    def field(time: float, positions: Floats) -> Floats:
        edges, weights = linked(positions)
        return _pull(edges, weights, positions)

    return field


def rendezvous(graph: Graph, reach: float) -> Field:
    """Consensus that never loses a link: the pull grows without bound as a link grows towards its reach.

    Link (i, j) of length d pulls with w_ij (2 R − d) / (R − d)² per metre, R = ``reach`` in metres.

    Raises
    ------
    ValueError
        ``reach`` is not positive and finite.

    Notes
    -----
    Promise: the field runs down Σ w_ij d_ij² / (R − d_ij), which is infinite at d = R. So if every link of positive
    weight is shorter than R at the start, it stays so for ever; and each connected part gathers at its centroid.
    The promise is one of exact motions of points that can see all links of the graph. A link as long as R or longer
    has no velocity: the field gives nan for both its ends. Ji and Egerstedt, "Distributed coordination control of
    multiagent systems while preserving connectedness", IEEE Transactions on Robotics 23, 2007.
    """
    if not (np.isfinite(reach) and reach > 0):
        raise ValueError(f"the reach must be positive and finite, got {reach:g}")
    linked = _links_at(graph)

    def field(time: float, positions: Floats) -> Floats:
        edges, weights = linked(positions)
        pulling = weights > 0
        edges, weights = edges[pulling], weights[pulling]
        distance = _lengths(edges, positions)
        room = np.where(distance < reach, reach - distance, np.nan)
        return _pull(edges, weights * ((reach + room) / room / room), positions)

    return field


def leader_follower(links: Links, leaders: Mapping[int, Velocity]) -> Field:
    """Leaders move as they are told, followers do `consensus` with all their neighbours.

    Parameters
    ----------
    links : as for `consensus`.
    leaders : for each vertex that leads, its velocity (2,) in metres a second as a function of time in seconds;
        ``lambda t: (0, 0)`` rests, ``following(trajectory)`` moves as planned.

    Raises
    ------
    IndexError
        A leader is not a vertex of the graph.

    Notes
    -----
    When the leaders rest, every follower that is connected with one ends in the convex hull of the leaders, at the
    weighted mean of its neighbours; with one leader, at its place. Ji, Ferrari-Trecate, Egerstedt and Buffa,
    "Containment control in mobile networks", IEEE Transactions on Automatic Control 53, 2008.
    """
    if isinstance(links, Graph):
        _check_leaders(leaders, links.n)
    follow = consensus(links)

    def field(time: float, positions: Floats) -> Floats:
        _check_leaders(leaders, len(positions))
        velocities = follow(time, positions)
        for vertex, velocity in leaders.items():
            told = np.asarray(velocity(time), dtype=np.float64)
            if told.shape != (2,):
                raise ValueError(f"leader {vertex}: a velocity is (x, y), got shape {told.shape}")
            velocities[vertex] = told
        return velocities

    return field


def following(trajectory: Trajectory) -> Velocity:
    """Velocity of a trajectory as a function of time, for `leader_follower`; from each stamp on that of the next leg.

    It jumps at the stamps: give ``trajectory.times`` to `integrate` as ``jumps``.
    """
    times = trajectory.times
    legs = np.diff(trajectory.points, axis=0) / np.diff(times)[:, None]
    velocities = np.concatenate([np.zeros((1, 2)), legs, np.zeros((1, 2))])

    def velocity(time: float) -> Floats:
        now: Floats = velocities[np.searchsorted(times, time, side="right")]
        return now

    return velocity


def formation(links: Links, offsets: ArrayLike) -> Field:
    """Everybody moves to stand by their neighbours as the offsets do: u_i = Σ_j w_ij ((p_j − p_i) − (o_j − o_i)).

    Parameters
    ----------
    links : as for `consensus`.
    offsets : (n, 2) metres, the formation anywhere in the plane; robots share its directions of x and y.

    Raises
    ------
    ValueError
        Offsets that are not (n, 2) finite numbers.

    Notes
    -----
    It is consensus of p − o: on a fixed connected graph the team takes its formation about its own centroid, at least
    as fast as e^(−λ2 t).
    """
    places = np.array(offsets, dtype=np.float64)
    if places.ndim != 2 or places.shape[1] != 2 or not np.isfinite(places).all():
        raise ValueError("offsets must be rows of two finite numbers [x, y]")
    if isinstance(links, Graph) and len(places) != links.n:
        raise ValueError(f"{len(places)} offsets for a graph of {links.n} vertices")
    linked = _links_at(links)

    def field(time: float, positions: Floats) -> Floats:
        edges, weights = linked(positions)
        if len(places) != len(positions):
            raise ValueError(f"{len(places)} offsets for {len(positions)} robots")
        return _pull(edges, weights, positions - places)

    return field


def distance_formation(graph: Graph, lengths: ArrayLike) -> Field:
    """Everybody moves to set the lengths of their links: u_i = −Σ_j w_ij (d_ij² − l_ij²) (p_i − p_j).

    Parameters
    ----------
    graph : the links.
    lengths : (m,) the length wanted of each edge, metres, in the order of ``graph.edges``.

    Raises
    ------
    ValueError
        Lengths that are not (m,) finite numbers ≥ 0.

    Notes
    -----
    The field runs down ¼ Σ w_ij (d_ij² − l_ij²)²; no common directions are needed, and the centroid rests. Lengths
    alone make a shape only where the framework is rigid: from near an infinitesimally rigid one
    (`taut.graph.rigidity`) the team reaches it, up to translation and rotation; a flexible one ends in any of its
    shapes. From afar the team may stop elsewhere: a graph that is not globally rigid has several shapes of the same
    lengths, and robots that start on one line, or at one place, stay there. Krick, Broucke and Francis, "Stabilisation
    of infinitesimally rigid formations of multi-robot networks", International Journal of Control 82, 2009.
    """
    wanted = np.array(lengths, dtype=np.float64)
    if wanted.shape != (graph.m,):
        raise ValueError(f"lengths must be one for each of {graph.m} edges, got shape {wanted.shape}")
    if not (np.isfinite(wanted).all() and (wanted >= 0).all()):
        raise ValueError("lengths must be finite and not negative")
    linked = _links_at(graph)

    def field(time: float, positions: Floats) -> Floats:
        edges, weights = linked(positions)
        distance = _lengths(edges, positions)
        return _pull(edges, weights * ((distance - wanted) * (distance + wanted)), positions)

    return field


def _links_at(links: Links) -> Callable[[Floats], tuple[Ints, Floats]]:
    """Return the function from positions to the edges there and their weights."""
    if isinstance(links, Graph):
        graph, edges, weights = links, links.edges, links.lengths

        def fixed(positions: Floats) -> tuple[Ints, Floats]:
            _check_shape(graph, positions)
            return edges, weights

        return fixed

    def current(positions: Floats) -> tuple[Ints, Floats]:
        graph = links(positions)
        _check_shape(graph, positions)
        return graph.edges, graph.lengths

    return current


def _check_shape(graph: Graph, positions: Floats) -> None:
    if np.shape(positions) != (graph.n, 2):
        raise ValueError(f"a graph of {graph.n} vertices needs positions ({graph.n}, 2), got {np.shape(positions)}")


def _check_leaders(leaders: Mapping[int, Velocity], n: int) -> None:
    for vertex in leaders:
        if not 0 <= vertex < n:
            raise IndexError(f"leader {vertex} is not one of the vertices 0 … {n - 1}")


def _lengths(edges: Ints, points: Floats) -> Floats:
    distance: Floats = np.hypot(*(points[edges[:, 1]] - points[edges[:, 0]]).T)
    return distance


def _pull(edges: Ints, strengths: Floats, points: Floats) -> Floats:
    """Σ_j s_ij (points_j − points_i) for each i, (n, 2); differences first, so that far from the origin is as exact."""
    tail, head = edges.T
    pulls = strengths[:, None] * (points[head] - points[tail])
    n = len(points)
    return np.stack([np.bincount(tail, x, n) - np.bincount(head, x, n) for x in pulls.T], axis=1)
