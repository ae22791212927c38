"""Roadmap: a Graph whose vertices are places in free space and whose edges are allowed straight motions."""

from __future__ import annotations

from dataclasses import dataclass

from taut.freespace import FreeSpace
from taut.graph import Graph
from taut.graph.core import Floats, Ints


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
