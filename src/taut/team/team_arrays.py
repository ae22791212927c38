"""The team in arrays, as kernels want it: all robots' roadmaps one after another, and seconds to their goals."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from taut.chunks import over_chunks
from taut.roadmap.core import Arcs
from taut.scene import Scene
from taut.team import _team_kernels
from taut.team._conflict_kernels import Floats, Ints
from taut.team._team_kernels import Team
from taut.team.own_roadmap import OwnRoadmap
from taut.team.world import World


@dataclass(frozen=True, eq=False)
class Ground:
    """A roadmap that robots of one growth share: positions (n, 2) metres, and arcs."""

    positions: Floats
    arcs: Arcs


def team_of(world: World) -> Team:
    """Put the robots of a world and their roadmaps into arrays."""
    robots = range(len(world.scene.robots))
    shared = [world.shared(i) for i in robots]
    number = {id(roadmap): g for g, roadmap in enumerate({id(roadmap): roadmap for roadmap in shared}.values())}
    grounds = {number[id(roadmap)]: Ground(roadmap.positions, roadmap.arcs) for roadmap in shared}
    which = [number[id(roadmap)] for roadmap in shared]
    return team_on(world.scene, list(grounds.values()), which, [world.own(i) for i in robots])


def team_on(scene: Scene, grounds: Sequence[Ground], which: Sequence[int], owns: Sequence[OwnRoadmap]) -> Team:
    """Put robots into arrays that have the given roadmaps.

    Parameters
    ----------
    which : the shared roadmap of each robot.
    owns : what each has beyond it.
    """
    robots, gap = scene.robots, scene.gap - scene.tol / 2
    sizes = np.array([len(ground.positions) for ground in grounds], dtype=np.int64)
    most_own = max(len(own.positions) for own in owns)
    xy = np.zeros((int((sizes + most_own).sum()), 2))
    place = _firsts(sizes + most_own)[:-1]
    for ground, first in zip(grounds, place.tolist(), strict=True):
        xy[first : first + len(ground.positions)] = ground.positions
    out = _joined([ground.arcs for ground in grounds])
    into = _joined([_reversed(ground.arcs) for ground in grounds])
    tails, firsts, heads, lengths = zip(
        *(_rows(own.edges, own.lengths) for own in owns),
        strict=True,
    )
    own_edges = _firsts([len(head) for head in heads])
    team = Team(
        body=np.array([(robot.radius + gap, scene.headway, robot.radius) for robot in robots]),
        motion=np.array([(robot.speed, robot.start_time, scene.tol) for robot in robots]),
        rules=np.array([(scene.stays(r), *own.pinched) for r, own in zip(robots, owns, strict=True)], dtype=np.int64),
        ends=np.array([own.ends for own in owns], dtype=np.int64),
        shared=np.array(which, dtype=np.int64),
        size=sizes,
        place=place,
        xy=xy,
        row=_firsts(sizes + 1)[:-1],
        out=out.indptr,
        heads=out.indices,
        lengths=out.lengths,
        limits=out.limits,
        into=into.indptr,
        tails=into.indices,
        lengths_into=into.lengths,
        limits_into=into.limits,
        own_first=_firsts([len(own.positions) for own in owns]),
        own_xy=np.concatenate([own.positions.reshape(-1, 2) for own in owns]),
        tail_first=_firsts([len(tail) for tail in tails]),
        tail=np.concatenate(tails),
        edge_first=np.concatenate(
            [*(first[:-1] + k for first, k in zip(firsts, own_edges[:-1], strict=True)), own_edges[-1:]]
        ),
        edge_to=np.concatenate(heads),
        edge_length=np.concatenate(lengths),
        near_first=np.zeros(len(robots) + 1, dtype=np.int64),
        near=np.empty(0, dtype=np.int64),
        away=np.empty(0),
        beyond=np.zeros(len(robots)),
        least=np.zeros(len(robots)),
    )
    return with_distances(team, np.zeros(len(robots)))


def with_distances(team: Team, costs: Floats) -> Team:
    """Return the team with the seconds to each robot's goal, as far from its way as this cost (r,) could take it.

    What it knows that far already is kept.
    """

    def of(first: int, last: int) -> list[tuple[Ints, Floats, float, float]]:
        return [_distances(team, i, float(costs[i])) for i in range(first, last)]

    found = [entry for chunk in over_chunks(of, len(costs), 16) for entry in chunk]
    ends = [[_team_kernels.position(team, i, v) for v in pair] for i, pair in enumerate(team.ends.tolist())]
    near, away, beyond, whole = zip(*found, strict=True)
    return team._replace(
        near_first=_firsts([len(vertices) for vertices in near]),
        near=np.concatenate(near),
        away=np.concatenate(away),
        beyond=np.array(beyond),
        least=np.where([start == goal for start, goal in ends], 0.0, np.array(whole)),
    )


def _distances(team: Team, i: int, cost: float) -> tuple[Ints, Floats, float, float]:
    rows = slice(team.near_first[i], team.near_first[i + 1])
    if rows.start == rows.stop or cost > team.beyond[i]:
        return _team_kernels.distances(team, i, cost)
    return team.near[rows], team.away[rows], float(team.beyond[i]), float(team.least[i])


def _firsts(sizes: Sequence[int] | Ints) -> Ints:
    return np.concatenate([[0], np.cumsum(np.asarray(sizes, dtype=np.int64))]).astype(np.int64)


def _joined(arcs: Sequence[Arcs]) -> Arcs:
    """One CSR after another; the first entries of each count on from those before."""
    before = _firsts([len(a.indices) for a in arcs])
    return Arcs(
        np.concatenate([a.indptr + k for a, k in zip(arcs, before[:-1], strict=True)]).astype(np.int64),
        np.concatenate([a.indices for a in arcs]).astype(np.int64),
        np.concatenate([a.lengths for a in arcs]),
        np.concatenate([a.limits for a in arcs]),
    )


def _reversed(arcs: Arcs) -> Arcs:
    n = len(arcs.indptr) - 1
    tails = np.repeat(np.arange(n), np.diff(arcs.indptr))
    order = np.argsort(arcs.indices, kind="stable")
    counts = np.bincount(arcs.indices, minlength=n)
    return Arcs(_firsts(counts), tails[order], arcs.lengths[order], arcs.limits[order])


def _rows(edges: Ints, lengths: Floats) -> tuple[Ints, Ints, Ints, Floats]:
    """Vertices that have edges of a robot's own, and for each the first of them; the edges' heads and lengths."""
    tail = np.concatenate([edges[:, 0], edges[:, 1]])
    head = np.concatenate([edges[:, 1], edges[:, 0]])
    order = np.argsort(tail, kind="stable")
    vertices, counts = np.unique(tail, return_counts=True)
    return vertices, _firsts(counts), head[order], np.concatenate([lengths, lengths])[order]
