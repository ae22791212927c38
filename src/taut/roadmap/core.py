"""Roadmap: a Graph whose vertices are places in free space and whose edges are allowed straight motions."""

from __future__ import annotations

from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from taut.freespace import FreeSpace
from taut.geometry.seeing import see_each_other
from taut.graph import Graph
from taut.graph.core import Floats, Ints


class Arcs(NamedTuple):
    """Directed edges in compressed sparse rows.

    Parameters
    ----------
    indptr : (n + 1,) where the arcs out of each vertex begin.
    indices : (a,) the vertex to which each leads.
    lengths : (a,) metres.
    limits : (a,) greatest speed on each, metres a second; inf where there is none.
    """

    indptr: Ints
    indices: Ints
    lengths: Floats
    limits: Floats


def both_ways(graph: Graph) -> Arcs:
    """Return the edges of a roadmap's graph as arcs in both directions, without limits."""
    return Arcs(graph.indptr, graph.indices, graph.weights, np.full(len(graph.indices), np.inf))


@dataclass(frozen=True, eq=False)
class Roadmap:
    """A graph drawn in free space; edge weights are lengths in metres.

    Parameters
    ----------
    positions : (n, 2) metres.
    graph : the edges with their lengths, CSR.
    """

    positions: Floats
    graph: Graph

    @property
    def edges(self) -> Ints:
        """(m, 2) pairs i < j."""
        return self.graph.edges

    @property
    def lengths(self) -> Floats:
        """(m,) metres, in the order of `edges`."""
        return self.graph.lengths


@dataclass(frozen=True, eq=False)
class LocatedRoadmap(Roadmap):
    """A roadmap that knows the free space in which it lies.

    Parameters
    ----------
    freespace : all edges are allowed motions there; no vertex lies where it merely touches itself.
    triangles : (n,) a triangle of its mesh that contains each vertex.
    """

    freespace: FreeSpace
    triangles: Ints


def joined(freespace: FreeSpace, positions: Floats, triangles: Ints, pairs: Ints) -> LocatedRoadmap:
    """Return the roadmap of (n, 2) places, held by ``triangles`` (n,), and those of (m, 2) pairs that see each other.

    A pair may be given once only, in either direction. Places that coincide are not joined with each other.
    """
    seen = see_each_other(freespace.mesh, positions, triangles, pairs[:, 0].copy(), pairs[:, 1].copy())
    edges = pairs[seen]
    lengths = np.hypot(*(positions[edges[:, 0]] - positions[edges[:, 1]]).T)
    graph = Graph.from_edges(len(positions), edges[lengths > 0], lengths[lengths > 0])
    return LocatedRoadmap(positions, graph, freespace, triangles)
