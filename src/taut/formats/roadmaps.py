"""Lanes in files: GraphML, JSON (our own, or networkx' node-link data) and NumPy archives."""

from __future__ import annotations

import os
import re
import tokenize
import zipfile
import zlib
from collections.abc import Callable, Hashable, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import TYPE_CHECKING, Any
from xml.parsers import expat
from xml.sax.saxutils import escape, quoteattr

import numpy as np
from numpy.typing import NDArray

from taut.errors import OutputError, SceneError
from taut.formats._document import Document, Place, read_text, shown
from taut.formats.convert import tidy
from taut.formats.json_text import LIMIT, layout, parse_json
from taut.scene import FloatArray
from taut.writing import replacing, write_text

if TYPE_CHECKING:
    from taut.roadmap.lanes import Lanes

ENDINGS = (".json", ".graphml", ".npz")
"""Endings of files that `load_roadmap` reads and `save_roadmap` writes."""

_SPEEDS = ("speed", "speed_limit")
_LARGEST_ARCHIVE = 1 << 30
_NOT_XML = re.compile("[\x00-\x08\x0b\x0c\x0e-\x1f\ufffe\uffff]")
_XMLNS = "http://graphml.graphdrawing.org/xmlns"


def load_roadmap(path: str | os.PathLike[str]) -> Lanes:
    """Return the lanes of a file. Places are metres, speeds metres a second.

    Vertices that lie at one place keep their numbers, but the first of them gets the lanes of all.

    Parameters
    ----------
    path : .json: `vertices`, a list of [x, y] or a mapping of names to them, and `edges`, a list of [from, to] or of
        mappings with `from`, `to` and perhaps `speed`, with `directed` (false if not given); or what
        `networkx.node_link_data` gives. .graphml: nodes have `x` and `y`, or `pos` like "1.5, 2". In both, edges of
        networkx may have `speed` or `speed_limit`. .npz: arrays `vertices` (or `positions`), `edges`, and perhaps
        `limits`, `names` and `directed` (true if not given). At most 64 MB, unpacked 1 GB.

    Raises
    ------
    SceneError
        No such file, or anything wrong in it: one line, with file and line or with the number of the edge, from 0.
    """
    file = os.fspath(path)
    suffix = Path(path).suffix.lower()
    if suffix not in ENDINGS:
        raise SceneError(f"unknown kind of file; a roadmap ends in {', '.join(ENDINGS[:-1])} or {ENDINGS[-1]}", file)
    if suffix == ".npz":
        return _lanes(_read_arrays(path))
    if suffix == ".graphml":
        return _lanes(_read_graphml(read_text(path, LIMIT), file))
    document = parse_json(read_text(path, LIMIT), file)
    return _lanes(_read_node_link(document) if "nodes" in document.data else _read_json(document))


def save_roadmap(lanes: Lanes, path: str | os.PathLike[str]) -> None:
    """Write lanes (.json, .graphml, .npz), wholly or not at all; no digit is lost.

    Raises
    ------
    OutputError
        Another ending, an unwritable path, or a name that such a file cannot hold.
    """
    suffix = Path(path).suffix.lower()
    if suffix == ".json":
        write_text(path, layout(_as_json(lanes)))
    elif suffix == ".graphml":
        write_text(path, _as_graphml(lanes, os.fspath(path)))
    elif suffix == ".npz":
        _write_arrays(lanes, path)
    else:
        raise OutputError(f"{os.fspath(path)}: a roadmap is written as {', '.join(ENDINGS[:-1])} or {ENDINGS[-1]}")


@dataclass(frozen=True)
class _Found:
    """What a file says, not checked yet: edges as pairs of numbers; where vertices and edges stand in the document."""

    document: Document
    keys: Sequence[Hashable]
    positions: FloatArray
    edges: NDArray[np.int64]
    limits: FloatArray
    directed: bool
    vertex_at: Callable[[int], Place]
    edge_at: Callable[[int], Place]


def _lanes(found: _Found) -> Lanes:
    from taut.roadmap.lanes import Lanes, LanesError, united_places  # slow to import, and scenes do not need it

    n, document = len(found.positions), found.document
    numbered = list(found.keys) in (list(range(n)), [str(k) for k in range(n)])
    names = [] if numbered else [key if isinstance(key, str) else str(key) for key in found.keys]
    edges, limits, kept = found.edges, found.limits, np.arange(len(found.edges))
    try:
        if np.isfinite(found.positions).all() and n and (edges >= 0).all() and (edges < n).all():
            edges, kept = united_places(found.positions, edges, found.directed, limits)
        source = os.path.basename(document.file or "lanes")
        return Lanes.from_edges(found.positions, edges, found.directed, limits[kept], names, source)
    except LanesError as error:
        if error.edge is None:
            raise document.error(str(error), found.vertex_at(error.vertex or 0)) from None
        k = int(kept[error.edge])
        a, b = (shown(found.keys[v]) if 0 <= v < n else str(v) for v in found.edges[k].tolist())
        raise document.error(f"edges[{k}] ({a} – {b}) {error.why}", found.edge_at(k)) from None
    except ValueError as error:
        raise document.error(str(error)) from None


def _read_json(document: Document) -> _Found:
    data = document.data
    _known(document, data, ("taut", "kind", "vertices", "edges", "directed"), ())
    if data.get("kind", "roadmap") != "roadmap" or "scene" in data or "robots" in data:
        raise document.error("is no roadmap: give `vertices` and `edges`", ("kind",))
    vertices, edges = data.get("vertices"), data.get("edges")
    if not isinstance(vertices, list | dict):
        raise document.error("`vertices` must be a list of points [x, y], or a mapping of names to them", ("vertices",))
    if not isinstance(edges, list):
        raise document.error("`edges` must be a list of pairs [from, to]", ("edges",))
    keys: list[str | int] = list(vertices) if isinstance(vertices, dict) else list(range(len(vertices)))
    points = list(vertices.values()) if isinstance(vertices, dict) else vertices
    places = [_point(document, point, ("vertices", key)) for key, point in zip(keys, points, strict=True)]
    ends: list[tuple[Any, Any]] = []
    speeds: list[float] = []
    for k, edge in enumerate(edges):
        at: Place = ("edges", k)
        if isinstance(edge, list) and len(edge) == 2:
            ends.append((edge[0], edge[1]))
            speeds.append(np.inf)
        elif isinstance(edge, dict) and "from" in edge and "to" in edge:
            _known(document, edge, ("from", "to", "speed"), at)
            ends.append((edge["from"], edge["to"]))
            speeds.append(_speed(document, edge.get("speed"), k, at))
        else:
            form = "[from, to] or a mapping with `from` and `to`"
            raise document.error(f"edges[{k}] must be {form}, got {shown(edge)}", at)
    return _found(document, keys, places, ends, speeds, lambda k: ("vertices", keys[k]), lambda k: ("edges", k))


def _read_node_link(document: Document) -> _Found:
    data = document.data
    nodes, word = data["nodes"], "links" if "links" in data else "edges"
    if not isinstance(nodes, list) or not isinstance(data.get(word), list):
        raise document.error("node-link data has lists of `nodes` and `links` (or `edges`)", ("nodes",))
    keys, places, ends, speeds = [], [], [], []
    for k, node in enumerate(nodes):
        at: Place = ("nodes", k)
        if not isinstance(node, dict) or "id" not in node:
            raise document.error(f"nodes[{k}] must be a mapping with `id`, got {shown(node)}", at)
        keys.append(_hashable(node["id"]))
        places.append(_place_of(document, node, at))
    for k, link in enumerate(data[word]):
        at = (word, k)
        if not isinstance(link, dict) or "source" not in link or "target" not in link:
            raise document.error(f"{word}[{k}] must be a mapping with `source` and `target`, got {shown(link)}", at)
        ends.append((link["source"], link["target"]))
        speeds.append(_speed(document, next((link[s] for s in _SPEEDS if s in link), None), k, at))
    return _found(document, keys, places, ends, speeds, lambda k: ("nodes", k), lambda k: (word, k))


def _found(
    document: Document,
    keys: Sequence[Hashable],
    places: Sequence[tuple[float, float]],
    ends: Sequence[tuple[Any, Any]],
    speeds: Sequence[float],
    vertex_at: Callable[[int], Place],
    edge_at: Callable[[int], Place],
    directed: object = None,
) -> _Found:
    """Look up the vertices that edges name."""
    directed = document.data.get("directed", False) if directed is None else directed
    if not isinstance(directed, bool):
        raise document.error(f"`directed` must be true or false, got {shown(directed)}", ("directed",))
    number: dict[Hashable, int] = {}
    for k, key in enumerate(keys):
        if key in number:
            raise document.error(f"two vertices are named {shown(key)}; every name must be unique", vertex_at(k))
        number[key] = k
    pairs = np.empty((len(ends), 2), dtype=np.int64)
    for k, (a, b) in enumerate(ends):
        for side, key in enumerate((a, b)):
            there = -1 if isinstance(key, bool) else number.get(_hashable(key), -1)
            if there < 0:
                which = f"numbers are 0 … {len(keys) - 1}" if keys and keys[0] == 0 else "vertices must be listed"
                raise document.error(
                    f"edges[{k}] names the vertex {shown(key)}, which there is not; {which}", edge_at(k)
                )
            pairs[k, side] = there
    positions = np.array(places, dtype=np.float64).reshape(-1, 2)
    return _Found(document, keys, positions, pairs, np.array(speeds, dtype=np.float64), directed, vertex_at, edge_at)


def _hashable(key: Any) -> Hashable:
    """Return a vertex' name as JSON has it, in a form that can be looked up: tuples have become lists there."""
    if isinstance(key, list):
        return tuple(_hashable(part) for part in key)
    return str(key) if isinstance(key, dict) else key


def _known(document: Document, mapping: dict[str, Any], keys: Sequence[str], place: Place) -> None:
    for key in mapping:
        if key not in keys:
            raise document.error(f"unknown key `{shown(key)[1:-1]}`; known are {', '.join(keys)}", (*place, key))


def _point(document: Document, value: Any, place: Place) -> tuple[float, float]:
    if isinstance(value, list) and len(value) == 2 and all(map(_is_number, value)):
        return float(value[0]), float(value[1])
    raise document.error(f"vertex {shown(place[1])} must be a point [x, y], got {shown(value)}", place)


def _place_of(document: Document, node: dict[str, Any], at: Place) -> tuple[float, float]:
    """Return where a node of networkx lies: `x` and `y`, or `pos`, as numbers or as text."""
    given = [node["x"], node["y"]] if "x" in node and "y" in node else node.get("pos")
    if isinstance(given, str):
        given = re.split(r"[\s,]+", given.strip(" ()[]"))
    try:
        if isinstance(given, list) and len(given) == 2 and not any(isinstance(part, bool) for part in given):
            return float(given[0]), float(given[1])
    except (TypeError, ValueError, OverflowError):
        pass
    name = shown(node.get("id"))
    raise document.error(f"vertex {name} has no place; give it numbers `x` and `y`, or `pos` as [x, y]", at)


def _speed(document: Document, value: Any, k: int, at: Place) -> float:
    if value is None:
        return np.inf
    try:
        if not isinstance(value, bool):
            return float(value)
    except (TypeError, ValueError, OverflowError):
        pass
    raise document.error(f"edges[{k}]: speed must be a positive number of metres a second, got {shown(value)}", at)


def _is_number(value: object) -> bool:
    return isinstance(value, int | float) and not isinstance(value, bool) and abs(value) < 1e300


@dataclass
class _Element:
    """A node, an edge or a key of GraphML, with the texts of its data by their key."""

    attributes: dict[str, str]
    line: int
    data: dict[str, str] = field(default_factory=dict)


@dataclass
class _Graphml:
    """What a GraphML text says."""

    nodes: list[_Element] = field(default_factory=list)
    edges: list[_Element] = field(default_factory=list)
    keys: list[_Element] = field(default_factory=list)
    direction: str = ""


def _read_graphml(text: str, file: str) -> _Found:
    graph = _parse_graphml(text, file)
    document = Document({}, lambda place: int(place[0]) if place else None, file)
    names = {key.attributes.get("id", ""): key.attributes.get("attr.name", "") for key in graph.keys}
    usual: dict[str, dict[str, str]] = {"node": {}, "edge": {}}
    for key in graph.keys:
        for kind, values in usual.items():
            if "default" in key.data and key.attributes.get("for", "all") in (kind, "all"):
                values[names[key.attributes.get("id", "")]] = key.data["default"]

    def told(element: _Element, kind: str, *needed: str) -> dict[str, str]:
        for word in needed:
            if word not in element.attributes:
                raise SceneError(f"this {kind} has no `{word}`", file, element.line)
        data = {names.get(key, key): value.strip() for key, value in element.data.items()}
        return {**usual[kind], **data, **{word: element.attributes[word] for word in needed}}

    nodes = [told(node, "node", "id") for node in graph.nodes]
    edges = [told(edge, "edge", "source", "target") for edge in graph.edges]
    for k, edge in enumerate(graph.edges):
        if edge.attributes.get("directed", graph.direction) != graph.direction:
            mend = 'make edgedefault "directed" and give lanes in both directions twice'
            raise SceneError(f"edges[{k}] is directed otherwise than edgedefault says; {mend}", file, edge.line)
    places = [_place_of(document, node, (at.line,)) for node, at in zip(nodes, graph.nodes, strict=True)]
    speeds = [
        _speed(document, next((edge[s] for s in _SPEEDS if s in edge), None), k, (at.line,))
        for k, (edge, at) in enumerate(zip(edges, graph.edges, strict=True))
    ]
    return _found(
        document,
        [node["id"] for node in nodes],
        places,
        [(edge["source"], edge["target"]) for edge in edges],
        speeds,
        lambda k: (graph.nodes[k].line,),
        lambda k: (graph.edges[k].line,),
        graph.direction == "true",
    )


def _parse_graphml(text: str, file: str) -> _Graphml:
    """Read the one graph of a GraphML text; document types, and with them entities, are refused."""
    out = _Graphml()
    parser = expat.ParserCreate("utf-8")
    parser.buffer_text = True
    open_tags: list[str] = []
    texts: list[str] = []
    owner: list[_Element] = []

    def error(message: str) -> SceneError:
        return SceneError(message, file, parser.CurrentLineNumber)

    def begin(name: str, attributes: dict[str, str]) -> None:
        tag = name.rpartition(":")[2]
        if not open_tags and tag != "graphml":
            raise error(f"must begin with <graphml>, got <{shown(tag)[1:-1]}>: this is not GraphML")
        open_tags.append(tag)
        if tag == "graph":
            if out.direction:
                raise error("has a second graph; a roadmap is one graph")
            directions = {"directed": "true", "undirected": "false"}
            if attributes.get("edgedefault") not in directions:
                raise error('<graph> must say edgedefault="directed" or "undirected"')
            out.direction = directions[attributes["edgedefault"]]
        elif tag == "hyperedge":
            raise error("has a hyperedge; lanes join two vertices")
        elif tag in ("node", "edge", "key"):
            owner[:] = [_Element(attributes, parser.CurrentLineNumber)]
            {"node": out.nodes, "edge": out.edges, "key": out.keys}[tag].append(owner[0])
        elif tag in ("data", "default"):
            texts[:] = [attributes.get("key", "") if tag == "data" else "default"]

    def end(name: str) -> None:
        tag = open_tags.pop()
        if tag in ("data", "default") and owner and texts:
            owner[0].data[texts[0]] = "".join(texts[1:])
            texts.clear()
        elif tag in ("node", "edge", "key"):
            owner.clear()

    def take(characters: str) -> None:
        if texts and open_tags[-1] in ("data", "default"):
            texts.append(characters)

    def refuse(*_: object) -> None:
        raise error("has a document type; remove the <!DOCTYPE …>")

    parser.StartElementHandler, parser.EndElementHandler, parser.CharacterDataHandler = begin, end, take
    parser.StartDoctypeDeclHandler = refuse
    try:
        parser.Parse(text.encode(), True)
    except expat.ExpatError as broken:
        raise SceneError(f"not valid XML: {expat.ErrorString(broken.code)}", file, broken.lineno) from None
    if not out.direction:
        raise SceneError("has no <graph>", file)
    return out


def _read_arrays(path: str | os.PathLike[str]) -> _Found:
    file = os.fspath(path)
    known = ("vertices", "positions", "edges", "limits", "names", "directed")
    if not os.path.isfile(path):
        raise SceneError("does not exist or is not a regular file", file)
    try:
        with zipfile.ZipFile(path) as archive:
            if sum(entry.file_size for entry in archive.infolist()) > _LARGEST_ARCHIVE:
                raise SceneError(f"is larger than {_LARGEST_ARCHIVE >> 30} GB when unpacked, the limit", file)
            odd = [entry for entry in archive.namelist() if entry.removesuffix(".npy") not in known]
            if odd:
                name = shown(odd[0].removesuffix(".npy"))
                raise SceneError(f"has an array {name}; known are {', '.join(known)}", file)
        with np.load(path, allow_pickle=False) as archive:
            arrays = {name: archive[name] for name in archive.files}
    except (
        OSError,
        ValueError,
        EOFError,
        KeyError,
        MemoryError,
        OverflowError,
        RuntimeError,
        tokenize.TokenError,
        zipfile.BadZipFile,
        zlib.error,
    ) as error:
        raise SceneError(f"is not an archive of plain NumPy arrays (.npz): {error}", file) from None
    odd = [name for name, array in arrays.items() if not isinstance(array, np.ndarray)]
    if odd:
        raise SceneError(f"holds {odd[0]}, which is no NumPy array", file)
    positions = arrays.get("vertices", arrays.get("positions"))
    if positions is None or "edges" not in arrays or {"vertices", "positions"} <= arrays.keys():
        raise SceneError("must hold the arrays `vertices` (n, 2) and `edges` (m, 2)", file)
    names, directed = arrays.get("names", np.arange(len(np.atleast_1d(positions)))), arrays.get("directed", np.True_)
    for name, array, dimensions, kinds in (
        ("vertices", positions, 2, "iuf"),
        ("edges", arrays["edges"], 2, "iu"),
        ("limits", arrays.get("limits", np.empty(0)), 1, "iuf"),
        ("names", names, 1, "iuU"),
        ("directed", directed, 0, "b"),
    ):
        if array.ndim != dimensions or array.dtype.kind not in kinds or (dimensions == 2 and array.shape[1] != 2):
            raise SceneError(f"the array `{name}` cannot be {array.dtype} of shape {array.shape}", file)
    edges = arrays["edges"].astype(np.int64)
    limits = arrays.get("limits", np.full(len(edges), np.inf)).astype(np.float64)
    if len(limits) != len(edges) or len(names) != len(positions):
        raise SceneError("needs one limit for each edge and one name for each vertex, or none at all", file)
    document = Document({}, lambda place: None, file)
    nowhere: Callable[[int], Place] = lambda k: ()  # noqa: E731
    return _Found(
        document, names.tolist(), positions.astype(np.float64), edges, limits, bool(directed), nowhere, nowhere
    )


def _both_ways(lanes: Lanes) -> bool:
    """Whether every arc has one back with the same limit."""
    back = np.lexsort((lanes.arcs[:, 0], lanes.arcs[:, 1]))
    return np.array_equal(lanes.arcs[back, ::-1], lanes.arcs) and np.array_equal(lanes.limits[back], lanes.limits)


def _edges_of(lanes: Lanes) -> tuple[bool, list[list[int]], list[float]]:
    """Whether the lanes are directed, and each with its limit; those in both directions once."""
    directed = not _both_ways(lanes)
    kept = lanes.arcs[:, 0] < lanes.arcs[:, 1] if not directed else np.ones(len(lanes.arcs), dtype=np.bool_)
    return directed, lanes.arcs[kept].tolist(), lanes.limits[kept].tolist()


def _as_json(lanes: Lanes) -> dict[str, Any]:
    directed, pairs, limits = _edges_of(lanes)
    points = [[tidy(x), tidy(y)] for x, y in lanes.positions.tolist()]
    ends: list[list[Any]] = [[lanes.names[v] for v in pair] for pair in pairs] if lanes.names else list(pairs)
    edges: list[Any] = ends
    if np.isfinite(limits).any():
        speeds = [{"speed": tidy(limit)} if np.isfinite(limit) else {} for limit in limits]
        edges = [{"from": a, "to": b, **speed} for (a, b), speed in zip(ends, speeds, strict=True)]
    vertices = dict(zip(lanes.names, points, strict=True)) if lanes.names else points
    return {"taut": 1, "kind": "roadmap", "directed": directed, "vertices": vertices, "edges": edges}


def _as_graphml(lanes: Lanes, file: str) -> str:
    directed, pairs, limits = _edges_of(lanes)
    names = lanes.names or [str(k) for k in range(len(lanes.positions))]
    if odd := [name for name in names if _NOT_XML.search(name)]:
        raise OutputError(f"{file}: GraphML cannot hold the name {shown(odd[0])}; write the lanes as .json")
    quoted = [quoteattr(name, {"\n": "&#10;", "\r": "&#13;", "\t": "&#9;"}) for name in names]
    lines = ['<?xml version="1.0" encoding="utf-8"?>', f"<graphml xmlns={quoteattr(_XMLNS)}>"]
    for key, kind in (("x", "node"), ("y", "node"), ("speed", "edge")):
        lines.append(f'  <key id="{key}" for="{kind}" attr.name="{key}" attr.type="double"/>')
    lines.append(f'  <graph edgedefault="{"directed" if directed else "undirected"}">')
    for name, (x, y) in zip(quoted, lanes.positions.tolist(), strict=True):
        lines.append(f'    <node id={name}><data key="x">{x!r}</data><data key="y">{y!r}</data></node>')
    for (a, b), limit in zip(pairs, limits, strict=True):
        data = f'<data key="speed">{escape(repr(limit))}</data>' if np.isfinite(limit) else ""
        lines.append(f"    <edge source={quoted[a]} target={quoted[b]}>{data}</edge>")
    return "\n".join([*lines, "  </graph>", "</graphml>", ""])


def _write_arrays(lanes: Lanes, path: str | os.PathLike[str]) -> None:
    arrays: dict[str, Any] = {"vertices": lanes.positions, "edges": lanes.arcs, "limits": lanes.limits}
    if lanes.names:
        arrays["names"] = np.array(lanes.names)
        if arrays["names"].tolist() != list(lanes.names):
            raise OutputError(f"{os.fspath(path)}: a name ends in a zero byte; write the lanes as .json")
    with replacing(path) as temporary, open(temporary, "wb") as stream:
        np.savez_compressed(stream, directed=np.True_, **arrays)
