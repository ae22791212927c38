"""The command graph: the visibility graph of each size of robot and what graph theory says of it."""

from __future__ import annotations

import math
from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from taut.cli.graph_report import WHOLE, Survey, say_counts, say_survey, survey_report
from taut.cli.options import EdgeKind, FigureOption, JsonOption, SceneArgument, WeightName
from taut.cli.output import about, progress, require_writable, say, say_json
from taut.cli.pictures import FIGURES
from taut.cli.reports import reach_report
from taut.cli.tables import say_table

if TYPE_CHECKING:
    from taut.figures.graphs import Portrait
    from taut.graph.core import Floats
    from taut.scene import Point, Robot, Scene

ROWS = 12  # sizes of robot in one figure


def graph(
    scene: SceneArgument,
    edges: Annotated[
        EdgeKind, typer.Option(help="Every visible pair, or only the edges that shortest paths can use.")
    ] = EdgeKind.all,
    weight: Annotated[WeightName, typer.Option(help="What an edge weighs in λ2.")] = WeightName.one,
    growth: Annotated[
        float | None,
        typer.Option(metavar="METRES", help="Only robots of this radius + clearance; without any, corners only."),
    ] = None,
    figure: FigureOption = None,
    graphml: Annotated[
        Path | None, typer.Option(metavar="FILE", help="Write the graph (.graphml; needs networkx).")
    ] = None,
    as_json: JsonOption = False,
) -> None:
    """Tell all about the visibility graph: vertices, edges, matrices, eigenvalues, λ2 and its bounds."""
    if growth is not None and not (math.isfinite(growth) and growth >= 0):
        raise typer.BadParameter("must be a number of metres, 0 or more", param_hint="--growth")
    never = Path(scene)
    require_writable(figure, "a figure", FIGURES, never)
    _require_graphml(graphml, never)

    from taut.formats import load_scene
    from taut.validation import validate

    world = load_scene(scene)
    with about(scene), progress("building the visibility graph") as tell:
        validate(world)
        growths = _growths(world, growth)
        _require_few(growths, figure, graphml)
        surveys = []
        for size in growths:
            tell(f"{size:g} m")
            surveys.append(survey(world, size, edges, weight))
        team = [robot for robot in world.robots if world.growth(robot) in growths]
        robots = reach_report(world, team)
    files = _write(world, surveys, figure, graphml)
    if as_json:
        sizes = [survey_report(found) for found in surveys]
        say_json({"scene": world.name, "sizes": sizes, "robots": robots, "files": files})
        return
    say_counts(surveys)
    if robots:
        say()
        lengths = [[r["name"], "no path" if r["shortest"] is None else f"{r['shortest']:.4f}"] for r in robots]
        say_table(["robot", "shortest (m)"], lengths, left=("robot",))
    for found in surveys:
        say()
        say_survey(found)
    for name in files:
        say(f"wrote {name}")


def survey(world: Scene, growth: float, edges: EdgeKind, weight: WeightName) -> Survey:
    """Build the visibility graph of the robots of one growth (metres), and compute what is told of it."""
    from taut.freespace import FreeSpace
    from taut.graph.bounds import connectivity_bounds, isoperimetric_bounds
    from taut.graph.connectedness import components
    from taut.graph.resistance import kirchhoff_index
    from taut.graph.spectral import algebraic_connectivity, fiedler_vector, spectrum
    from taut.graph.weights import WEIGHTS, weighted
    from taut.roadmap import visibility_graph

    freespace = FreeSpace(world, growth)
    team = [robot for robot in world.robots if world.growth(robot) == growth]
    tenants = _tenants(team)
    every, tangent = (visibility_graph(freespace, edges=kind, points=list(tenants)) for kind in ("all", "tangent"))
    roadmap = every if edges is EdgeKind.all else tangent
    graph = weighted(roadmap.graph, roadmap.positions, WEIGHTS[weight])
    corners = graph.n - len(tenants)
    number = {place: corners + k for k, place in enumerate(tenants)}
    small = graph.n <= WHOLE
    eigenvalues = spectrum(graph) if small else None
    return Survey(
        freespace=freespace,
        robots=len(team),
        every=every.graph,
        tangent=tangent.graph,
        kind=edges.value,
        weight=weight.value,
        graph=graph,
        positions=roadmap.positions,
        names=("corner",) * corners + tuple(", ".join(words) for words in tenants.values()),
        starts=tuple(sorted({number[robot.start] for robot in team})),
        goals=tuple(sorted({number[robot.goal] for robot in team})),
        components=components(graph),
        connectivity=algebraic_connectivity(graph) if eigenvalues is None else _second(eigenvalues),
        fiedler=fiedler_vector(graph, towards=roadmap.positions.T) if graph.n >= 2 else None,
        eigenvalues=eigenvalues,
        bounds=connectivity_bounds(graph) if small else None,
        isoperimetric=isoperimetric_bounds(graph) if small and graph.n >= 2 else None,
        kirchhoff=kirchhoff_index(graph) if small else None,
    )


def _growths(world: Scene, wanted: float | None) -> list[float]:
    """Return the sizes of robot to tell of, ascending: those of the team, or the one wanted."""
    known = sorted({world.growth(robot) for robot in world.robots}) or [world.clearance]
    if wanted is None:
        return known
    xs, ys = zip(*world.workspace, strict=True)
    size = max(max(xs) - min(xs), max(ys) - min(ys))
    if wanted > size:
        raise typer.BadParameter(f"no disc of {wanted:g} m fits a workspace of {size:g} m", param_hint="--growth")
    # Who types 0.4 means the robots of 0.3 + 0.1, which is not the same float.
    return [next((growth for growth in known if abs(growth - wanted) <= world.tol), wanted)]


def _tenants(team: Sequence[Robot]) -> dict[Point, list[str]]:
    """List starts and goals, each place once with all who start or end there: shared places are one vertex."""
    out: dict[Point, list[str]] = {}
    for robot in team:
        for place, word in ((robot.start, "start"), (robot.goal, "goal")):
            out.setdefault(place, []).append(f"{robot.name} {word}")
    return out


def _second(eigenvalues: Floats) -> float:
    return float(eigenvalues[1]) if len(eigenvalues) >= 2 else 0.0


def _require_graphml(path: Path | None, never: Path) -> None:
    """Raise now if a GraphML file could not be written later."""
    require_writable(path, "a graph", (".graphml",), never)
    if path is not None:
        from taut.graph import Graph
        from taut.graph.conversion import to_networkx

        to_networkx(Graph.from_edges(0, []))  # tells what to install


def _require_few(growths: Sequence[float], figure: Path | None, graphml: Path | None) -> None:
    """Raise if there are more sizes of robot than the files can hold."""
    some = ", ".join(f"{growth:.10g}" for growth in growths[:8]) + (", …" if len(growths) > 8 else "")
    if graphml is not None and len(growths) > 1:
        raise typer.BadParameter(f"holds one graph: choose one with --growth ({some})", param_hint="--graphml")
    if figure is not None and len(growths) > ROWS:
        raise typer.BadParameter(
            f"has room for {ROWS} sizes of robot, not {len(growths)}: choose one with --growth ({some})",
            param_hint="--figure",
        )


def _write(world: Scene, surveys: Sequence[Survey], figure: Path | None, graphml: Path | None) -> list[str]:
    """Write what is wanted; return the names of the files."""
    written = []
    if figure is not None:
        from taut.figures.graphs import save_portraits

        with progress(f"drawing {figure}"):
            save_portraits([_portrait(world, found) for found in surveys], figure)
        written.append(str(figure))
    if graphml is not None:
        from taut.graph.conversion import save_graphml

        save_graphml(surveys[0].graph, graphml, positions=surveys[0].positions)
        written.append(str(graphml))
    return written


def _portrait(world: Scene, found: Survey) -> Portrait:
    import numpy as np

    from taut.figures.graphs import Portrait
    from taut.figures.pictures import count

    graph, growth = found.graph, found.freespace.growth
    parts = int(found.components.max(initial=-1)) + 1
    facts = [count(graph.n, "vertex", "vertices"), count(graph.m, "edge"), f"λ2 = {found.connectivity:.5g}"]
    if parts > 1:
        facts.append(count(parts, "component"))
    if found.weight != WeightName.one:
        facts.append("weighted by length")
    return Portrait(
        graph=graph,
        positions=found.positions,
        fiedler=np.zeros(graph.n) if found.fiedler is None else found.fiedler,
        spectrum=np.empty(0) if found.eigenvalues is None else found.eigenvalues,
        title=", ".join([*([world.name] if world.name else []), f"{growth:g} m"]),
        facts=" · ".join(facts),
        starts=found.starts,
        goals=found.goals,
        freespace=found.freespace,
    )
