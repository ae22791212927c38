"""The command replan: a plan for a map that has changed."""

from __future__ import annotations

import math
from pathlib import Path
from typing import Annotated

import typer

from taut.cli.options import AnimateOption, FigureOption, JsonOption, RoadmapName, SceneArgument, roadmap_source
from taut.cli.output import about, complain, progress, require_writable, say, say_json
from taut.cli.pictures import require_pictures, write_pictures
from taut.cli.reports import plan_report, say_plan
from taut.cli.tables import say_table


def replan(
    plan: Annotated[str, typer.Argument(metavar="PLAN", help="The older plan, a file.")],
    scene: SceneArgument,
    output: Annotated[
        Path | None, typer.Option("-o", "--output", metavar="PLAN", help="Write the new plan (.json).")
    ] = None,
    seconds: Annotated[float | None, typer.Option(metavar="S", help="Stop trying after S seconds.")] = None,
    rounds: Annotated[
        int | None, typer.Option(min=1, max=1_000_000, metavar="N", help="Stop trying after N rounds.")
    ] = None,
    seed: Annotated[int, typer.Option(min=0, help="Seed of everything random.")] = 0,
    roadmap: Annotated[
        str | None,
        typer.Option(metavar="NAME|FILE", help="On what the robots move; that of the older plan if it was no file."),
    ] = None,
    figure: FigureOption = None,
    animate: AnimateOption = None,
    as_json: JsonOption = False,
) -> None:
    """Keep of a plan what still holds in a changed scene, plan the other robots anew, and say who and why."""
    if seconds is not None and not (math.isfinite(seconds) and seconds > 0):
        raise typer.BadParameter("must be a positive number", param_hint="--seconds")
    never = Path(scene)
    require_writable(output, "a plan", (".json",), never)
    require_pictures(figure, animate, False, never)

    from taut.formats import load_plan, load_roadmap, load_scene, save
    from taut.team import replan as replan_team

    older = load_plan(plan)
    world = load_scene(scene)
    ground = roadmap if roadmap is None or roadmap in list(RoadmapName) else load_roadmap(roadmap_source(roadmap))
    with about(scene), progress(f"planning {len(world.robots)} robots"):
        result = replan_team(older, world, seed=seed, rounds=rounds, seconds=seconds, roadmap=ground)
    report = plan_report(result.plan, result.certificate)
    report["kept"] = list(result.kept)
    report["changed"] = dict(result.changed)
    report["notes"] = list(result.notes)
    report["files"] = []
    if result.certificate.ok:
        if output is not None:
            save(result.plan, output)
            report["files"].append(str(output))
        report["files"] += write_pictures(result.plan, figure, animate, False)
    if as_json:
        say_json(report)
    else:
        for note in report["notes"]:
            say(f"note: {note}")
        say(f"{len(result.kept)} of {len(world.robots)} robots keep their motions")
        if result.changed:
            say_table(["changed", "why"], [list(row) for row in result.changed.items()], left=("changed", "why"))
        say()
        say_plan(report, result.certificate)
        for name in report["files"]:
            say(f"wrote {name}")
    if not result.certificate.ok:
        complain("the plan does not hold, see the problems above; nothing was written")
