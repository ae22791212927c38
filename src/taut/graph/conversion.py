"""Graphs from and to networkx, and GraphML files; networkx (an extra) is imported only when needed."""

from __future__ import annotations

import io
import numbers
import os
import warnings
from collections.abc import Hashable
from pathlib import Path
from typing import TYPE_CHECKING, Any
from xml.etree.ElementTree import ParseError

import numpy as np
from numpy.typing import ArrayLike

from taut.errors import TautError
from taut.graph.core import Floats, Graph
from taut.writing import write_text

if TYPE_CHECKING:
    import networkx as nx


def to_networkx(graph: Graph, positions: ArrayLike | None = None) -> nx.Graph:
    """Return the graph as a networkx.Graph with vertices 0 … n − 1.

    Edges have the attribute "weight"; vertices have "pos", (x, y), if ``positions`` (n, 2) are given. Both are plain
    floats.

    Raises
    ------
    ValueError
        ``positions`` are not (n, 2) finite numbers.
    TautError
        networkx is not installed.
    """
    out = _networkx().Graph()
    out.add_nodes_from(range(graph.n))
    out.add_weighted_edges_from(
        (u, v, w) for (u, v), w in zip(graph.edges.tolist(), graph.lengths.tolist(), strict=True)
    )
    if positions is not None:
        for v, (x, y) in enumerate(_checked_positions(graph, positions).tolist()):
            out.nodes[v]["pos"] = (x, y)
    return out


def from_networkx(other: nx.Graph, weight: str | None = "weight") -> tuple[Graph, list[Hashable]]:
    """Return a networkx.Graph as a Graph, and its nodes in the order of the vertices.

    Parameters
    ----------
    weight : the edge attribute that holds the weight; edges without it, and all edges for None, have weight 1.

    Raises
    ------
    ValueError
        Directed or parallel edges, loops, or a weight that is not a finite number ≥ 0.
    """
    if other.is_directed():
        raise ValueError("the graph is directed; make it undirected first, as networkx does by to_undirected()")
    if other.is_multigraph():
        raise ValueError(
            "the graph may have parallel edges; join them first, as networkx.Graph(other) does by keeping one"
        )
    nodes = list(other.nodes)
    vertex = {node: v for v, node in enumerate(nodes)}
    pairs, weights = [], []
    for a, b, data in other.edges(data=True):
        if a == b:
            raise ValueError(f"an edge joins {a!r} with itself; remove it first")
        pairs.append((vertex[a], vertex[b]))
        weights.append(_number(1 if weight is None else data.get(weight, 1), f"the weight of edge {a!r}, {b!r}"))
        if weights[-1] < 0:
            raise ValueError(f"the weight of edge {a!r}, {b!r} is {weights[-1]:g}; weights must not be negative")
    return Graph.from_edges(len(nodes), pairs, weights), nodes


def save_graphml(graph: Graph, path: str | os.PathLike[str], positions: ArrayLike | None = None) -> None:
    """Write a GraphML file: edges with "weight", vertices with "x" and "y" if ``positions`` (n, 2) are given.

    The file is written wholly or not at all; no digit is lost.

    Raises
    ------
    ValueError
        ``positions`` are not (n, 2) finite numbers.
    OutputError
        The file cannot be written.
    TautError
        networkx is not installed.
    """
    out = to_networkx(graph)
    if positions is not None:
        for v, (x, y) in enumerate(_checked_positions(graph, positions).tolist()):
            out.nodes[v].update(x=x, y=y)
    write_text(path, "\n".join(_networkx().generate_graphml(out)) + "\n")


def load_graphml(path: str | os.PathLike[str]) -> tuple[Graph, Floats | None]:
    """Return the graph of a GraphML file, vertices in the order of the file, and their positions.

    Edges without a "weight" have weight 1. Positions, (n, 2), are read where every vertex has "x" and "y"; None where
    none has.

    Raises
    ------
    TautError
        The file cannot be read, is not GraphML, or holds what a Graph cannot; or networkx is not installed. One line,
        with the file's name.
    """
    name = os.fspath(path)
    networkx = _networkx()
    try:
        raw = Path(path).read_bytes()
    except (OSError, ValueError) as error:
        raise TautError(f"{name}: cannot be read: {getattr(error, 'strerror', None) or error}") from None
    try:
        with warnings.catch_warnings(action="ignore"):  # of ports and untyped keys, which mean nothing to a Graph
            other = networkx.read_graphml(io.BytesIO(raw))
        return from_networkx(other)[0], _positions_of(other)
    except ParseError as error:
        raise TautError(f"{name}:{error.position[0]}: is not XML, so not GraphML: {error.msg}") from None
    except ValueError as error:
        raise TautError(f"{name}: {error}") from None
    except (networkx.NetworkXException, LookupError, TypeError, AttributeError) as error:  # its reader checks little
        raise TautError(f"{name}: is not a GraphML file that networkx can read: {error}") from None


def _networkx() -> Any:
    try:
        import networkx
    except ImportError:
        raise TautError("networkx is not installed; it comes with: pip install 'taut[networkx]'") from None
    return networkx


def _checked_positions(graph: Graph, positions: ArrayLike) -> Floats:
    places = np.asarray(positions, dtype=np.float64)
    if places.shape != (graph.n, 2):
        raise ValueError(f"positions must be ({graph.n}, 2), one row a vertex; got {places.shape}")
    if not np.isfinite(places).all():
        v = int(np.argmin(np.isfinite(places).all(axis=1)))
        raise ValueError(f"the position of vertex {v} is not finite")
    return places


def _positions_of(other: nx.Graph) -> Floats | None:
    rows = []
    for node, data in other.nodes(data=True):
        if "x" in data and "y" in data:
            rows.append([_number(data[axis], f"{axis} of vertex {node!r}") for axis in "xy"])
        elif rows or "x" in data or "y" in data:
            raise ValueError(f"vertex {node!r} lacks x or y; give both to every vertex or to none")
    if rows and len(rows) < len(other):
        raise ValueError("some vertices have x and y and some have not; give both to every vertex or to none")
    return np.array(rows, dtype=np.float64) if rows else None


def _number(value: object, what: str) -> float:
    if not isinstance(value, numbers.Real) or isinstance(value, bool):
        raise ValueError(f"{what} is {value!r}; it must be a number")
    try:
        number = float(value)
    except OverflowError:
        number = np.inf
    if not np.isfinite(number):
        raise ValueError(f"{what} is {number}; it must be finite")
    return number
