"""What `taut graph` tells: one record a size of robot, printed as JSON or as the tables of the thesis' appendix."""

from __future__ import annotations

import math
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

from taut.cli.output import say, say_facts
from taut.cli.reports import Report
from taut.cli.tables import say_table

if TYPE_CHECKING:
    from taut.freespace import FreeSpace
    from taut.graph import Graph
    from taut.graph.bounds import Bound, IsoperimetricBounds
    from taut.graph.core import Floats, Ints

WHOLE = 1000  # vertices: of larger graphs only λ2 and the Fiedler vector are computed, in memory linear in the edges
FEW_VERTICES = 60  # up to this many are listed
FEW_EDGES = 40  # up to this many are listed
FEW_CELLS = 16  # vertices up to which matrices are printed
FEW_EIGENVALUES = 64  # up to this many are printed
ENDS = (5, 3)  # of more, so many from below and from above
IN_A_ROW = 6  # eigenvalues


@dataclass(frozen=True, eq=False)
class Survey:
    """The visibility graph of one size of robot and what was computed of it.

    Parameters
    ----------
    freespace : of that size.
    robots : how many there are.
    every, tangent : both visibility graphs, of all visible pairs and of tangent edges.
    kind, weight : which of them the rest is about, "all" or "tangent", and the name of its weights.
    graph, positions : that graph with its weights, (n, 2) metres.
    names : (n,) what each vertex is.
    starts, goals : vertices.
    components : (n,) component of each vertex.
    connectivity : λ2.
    fiedler : (n,) Fiedler vector; None with fewer than two vertices.
    eigenvalues : (n,) ascending; like the rest None where there are too many vertices.
    """

    freespace: FreeSpace
    robots: int
    every: Graph
    tangent: Graph
    kind: str
    weight: str
    graph: Graph
    positions: Floats
    names: tuple[str, ...]
    starts: tuple[int, ...]
    goals: tuple[int, ...]
    components: Ints
    connectivity: float
    fiedler: Floats | None
    eigenvalues: Floats | None
    bounds: Sequence[Bound] | None
    isoperimetric: IsoperimetricBounds | None
    kirchhoff: float | None


def survey_report(found: Survey) -> Report:
    """Return all of a survey as plain data; vertices count from 0, and lists without words go by vertex or by edge."""
    import numpy as np

    from taut.graph.matrices import degrees

    graph, cut = found.graph, found.isoperimetric
    return {
        **_counts(found),
        "graph": {
            "kind": found.kind,
            "weight": found.weight,
            "vertices": graph.n,
            "positions": found.positions,
            "names": found.names,
            "edges": graph.edges,
            "lengths": _lengths(found),
            "weights": graph.lengths,
            "degrees": np.diff(graph.indptr),
            "weighted_degrees": degrees(graph),
        },
        "beta": graph.m / graph.n if graph.n else None,
        "components": int(found.components.max(initial=-1)) + 1,
        "component": found.components,
        "lambda2": found.connectivity,
        "fiedler_vector": found.fiedler,
        "eigenvalues": found.eigenvalues,
        "bounds": None if found.bounds is None else [vars(bound) for bound in found.bounds],
        "isoperimetric": None if cut is None else vars(cut),
        "kirchhoff_index": found.kirchhoff,
        "matrices": _matrices(found) if graph.n <= FEW_CELLS else None,
        "left_out": _left_out(found),
    }


def say_counts(surveys: Iterable[Survey]) -> None:
    """Print the counts of all sizes of robot in one table."""
    heads = ["growth (m)", "robots", "vertices", "edges", "corners", "tangent edges", "parts", "free area (m²)"]
    keys = ["robots", "vertices", "edges", "corners", "tangent_edges", "parts"]
    counts = [_counts(found) for found in surveys]
    rows = [[f"{c['growth']:g}", *(str(c[key]) for key in keys), f"{c['area']:.4f}"] for c in counts]
    say_table(heads, rows, left=())


def say_survey(found: Survey) -> None:
    """Print the graph of one size of robot: vertices, edges, λ2 and its bounds, matrices, eigenvalues."""
    graph = found.graph
    which = {"all": "every visible pair", "tangent": "tangent edges"}[found.kind]
    weighs = {"one": "an edge weighs 1", "distance": "an edge weighs its length in metres"}[found.weight]
    say(f"growth {found.freespace.growth:g} m: {which}; {weighs}")
    say()
    if graph.n == 0:
        say("no vertices: " + ("nothing bends paths here" if found.freespace.area else "there is no free space"))
        return
    say_facts(_facts(found))
    if found.bounds is not None:
        _say_bounds(found, found.bounds)
    if graph.n <= FEW_VERTICES:
        _say_vertices(found)
    if 0 < graph.m <= FEW_EDGES:
        _say_edges(found)
    if graph.n <= FEW_CELLS:
        for name, matrix in _matrices(found).items():
            _say_matrix(name, matrix)
    if found.eigenvalues is not None:
        _say_eigenvalues(found.eigenvalues.tolist())
    if _left_out(found):
        say()
        say(f"note: {_left_out(found)}")


def _counts(found: Survey) -> Report:
    ends = len({*found.starts, *found.goals})
    return {
        "growth": found.freespace.growth,
        "robots": found.robots,
        "vertices": found.every.n,
        "edges": found.every.m,
        "corners": found.tangent.n - ends,
        "tangent_edges": found.tangent.m,
        "parts": found.freespace.parts,
        "area": found.freespace.area,
    }


def _left_out(found: Survey) -> str:
    """Say what was not computed and why; nothing if all was."""
    if found.graph.n <= WHOLE:
        return ""
    what = "eigenvalues other than λ2, bounds, isoperimetric and Kirchhoff numbers"
    return f"{what} are left out: they are computed up to {WHOLE:,} vertices, this graph has {found.graph.n:,}"


def _lengths(found: Survey) -> Floats:
    import numpy as np

    steps = np.diff(found.positions[found.graph.edges], axis=1)[:, 0]
    return np.asarray(np.hypot(steps[:, 0], steps[:, 1]), dtype=np.float64)


def _matrices(found: Survey) -> dict[str, Floats]:
    from taut.graph.matrices import adjacency, degree, laplacian

    makers = {"adjacency": adjacency, "degree": degree, "laplacian": laplacian}
    return {name: make(found.graph).toarray() for name, make in makers.items()}


def _facts(found: Survey) -> list[tuple[str, str]]:
    import numpy as np

    from taut.graph.matrices import degrees

    graph = found.graph
    parts = int(found.components.max(initial=-1)) + 1
    facts = [
        ("vertices", str(graph.n)),
        ("edges", f"{graph.m}, β = m / n = {_number(graph.m / graph.n)}"),
        ("degree", _spread(np.diff(graph.indptr))),
    ]
    if found.weight != "one":
        facts.append(("weighted degree", _spread(degrees(graph))))
    facts.append(("components", str(parts)))
    if graph.n >= 2:
        facts.append(("λ2", _number(found.connectivity) + (", for it is not connected" if parts > 1 else "")))
    if found.kirchhoff is not None:
        facts.append(("Kirchhoff index", "infinite" if parts > 1 else _number(found.kirchhoff)))
    return facts


def _spread(values: Floats | Ints) -> str:
    return f"least {_number(values.min())}, mean {_number(values.mean())}, greatest {_number(values.max())}"


def _say_bounds(found: Survey, bounds: Sequence[Bound]) -> None:
    """Print the bounds as a ladder, from the lowest lower bound over the value to the highest upper bound."""
    if found.graph.n < 2:
        return
    side = {side: sorted((b for b in bounds if b.side == side), key=lambda b: b.value) for side in ("lower", "upper")}
    rows = [["at least", _number(b.value), b.formula, b.name] for b in side["lower"]]
    rows += [["is", _number(found.connectivity), "", "the second smallest eigenvalue"]]
    rows += [["is", _number(b.value), b.formula, b.name] for b in bounds if b.side == "exact"]
    rows += [["at most", _number(b.value), b.formula, b.name] for b in side["upper"]]
    say()
    say_table(["λ2", "value", "formula", "from"], rows, left=("λ2", "formula", "from"))
    cut = found.isoperimetric
    if cut is None:
        return
    inside = " ".join(f"v{v + 1}" for v in cut.cut.tolist()) if len(cut.cut) <= 8 else f"{len(cut.cut)} vertices"
    rows = [
        ["at least", _number(cut.lower), "λ2 ⌈n/2⌉ / n"],
        ["at most", _number(cut.upper), f"w(∂S) / |S|, S = {inside}"],
        ["at most", _number(cut.cheeger), "√(ρ (2Δ − ρ)), ρ = min(λ2, Δ), Δ the greatest degree"],
    ]
    say()
    say_table(["isoperimetric number", "value", "formula"], rows, left=("isoperimetric number", "formula"))


def _say_vertices(found: Survey) -> None:
    import numpy as np

    from taut.graph.matrices import degrees

    heads = ["vertex", "x (m)", "y (m)", "degree", "weighted", "Fiedler", "what"]
    sums, count = degrees(found.graph).tolist(), np.diff(found.graph.indptr).tolist()
    fiedler = [0.0] * found.graph.n if found.fiedler is None else found.fiedler.tolist()
    rows = [
        [
            f"v{v + 1}",
            f"{x:.4f}",
            f"{y:.4f}",
            str(count[v]),
            _number(sums[v]),
            f"{round(fiedler[v], 4) + 0.0:.4f}",
            found.names[v],
        ]
        for v, (x, y) in enumerate(found.positions.tolist())
    ]
    if found.weight == "one":
        heads, rows = heads[:4] + heads[5:], [row[:4] + row[5:] for row in rows]
    say()
    say_table(heads, rows, left=("vertex", "what"))


def _say_edges(found: Survey) -> None:
    ends, lengths = found.graph.edges.tolist(), _lengths(found).tolist()
    rows = [
        [f"e{k + 1}", f"v{a + 1} v{b + 1}", _number(length)]
        for k, ((a, b), length) in enumerate(zip(ends, lengths, strict=True))
    ]
    say()
    say_table(["edge", "joins", "length (m)"], rows, left=("edge", "joins"))


def _say_matrix(name: str, matrix: Floats) -> None:
    letter = {"adjacency": "A", "degree": "D", "laplacian": "L"}[name]
    numbers = [f"v{k + 1}" for k in range(len(matrix))]
    rows = [
        [number, *(_number(value) if value else "·" for value in row)]
        for number, row in zip(numbers, matrix.tolist(), strict=True)
    ]
    say()
    say_table([letter, *numbers], rows, left=(letter,))


def _say_eigenvalues(values: Sequence[float]) -> None:
    say()
    if len(values) <= FEW_EIGENVALUES:
        say("eigenvalues of L")
        _say_numbered(values, 1)
        return
    below, above = ENDS
    say(f"eigenvalues of L, the least {below} and the greatest {above} of {len(values)}")
    _say_numbered(values[:below], 1)
    _say_numbered(values[-above:], len(values) - above + 1)


def _say_numbered(values: Sequence[float], first: int) -> None:
    """Print numbers in rows, with the number of the first of each row before it."""
    texts = [_number(value) for value in values]
    width = max(map(len, texts))
    label = len(f"λ{first + len(values)}")
    for k in range(0, len(values), IN_A_ROW):
        row = "   ".join(f"{text:>{width}}" for text in texts[k : k + IN_A_ROW])
        say(f"{f'λ{first + k}':<{label}}   {row}")


def _number(value: float) -> str:
    """Return a number with four decimals, or four digits where these would hide or flood it."""
    if not math.isfinite(value):
        return "infinite"
    if value == int(value) and abs(value) < 1e9:
        return str(int(value))
    return f"{value:.4f}" if 0.01 <= abs(value) < 1e7 else f"{value:.4g}"
