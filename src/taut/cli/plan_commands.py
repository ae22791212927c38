"""The commands about plans: plan, verify, show."""

from __future__ import annotations

import math
import re
import time
from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from taut.cli.options import (
    AnimateOption,
    ConnectedOption,
    ContactOption,
    FigureOption,
    GraphOption,
    JsonOption,
    Lambda2Option,
    Method,
    Objective,
    Order,
    RoadmapName,
    RoadmapOption,
    SceneArgument,
    SightOption,
    WeightName,
    contact_asked,
)
from taut.cli.output import about, complain, progress, require_writable, say, say_facts, say_json
from taut.cli.pictures import require_pictures, write_pictures, write_stages
from taut.cli.reports import (
    certificate_facts,
    cuts_report,
    plan_report,
    say_plan,
    say_problems,
    say_scene,
    say_stages,
    scene_report,
)
from taut.errors import OutputError, SceneError

if TYPE_CHECKING:
    from taut.motion import Plan
    from taut.scene import Scene


def plan(
    scene: SceneArgument,
    output: Annotated[
        Path | None, typer.Option("-o", "--output", metavar="PLAN", help="Write the plan (.json).")
    ] = None,
    method: Annotated[
        Method | None,
        typer.Option(help="How the team is planned; repair with --rounds or --seconds, else prioritized."),
    ] = None,
    order: Annotated[Order, typer.Option(help="Which robots are planned first.")] = Order.shortest,
    roadmap: RoadmapOption = RoadmapName.visibility.value,
    seconds: Annotated[float | None, typer.Option(metavar="S", help="Improve the plan for S seconds.")] = None,
    rounds: Annotated[
        int | None, typer.Option(min=1, max=1_000_000, metavar="N", help="Improve it, or try, for N rounds.")
    ] = None,
    objective: Annotated[Objective, typer.Option(help="What repair and optimal make least.")] = Objective.sum_of_costs,
    within: Annotated[float, typer.Option(metavar="F", help="Optimal: a plan may cost F times the bound.")] = 1.0,
    seed: Annotated[int, typer.Option(min=0, help="Seed of everything random.")] = 0,
    weight: Annotated[
        WeightName | None, typer.Option(help="What an edge weighs in λ2 (with --method mrppa; one if not given).")
    ] = None,
    split: Annotated[
        list[str] | None,
        typer.Option(metavar="NAMES", help='One side of the cut by hand, like "O1,O4,R1 start" (--method mrppa).'),
    ] = None,
    contact: ContactOption = None,
    sight: SightOption = False,
    connected: ConnectedOption = None,
    lambda2: Lambda2Option = None,
    margin: Annotated[
        Path | None,
        typer.Option(metavar="STUDY", help="Leave the room that vehicles need by a study (taut simulate --seeds)."),
    ] = None,
    stages: Annotated[
        Path | None, typer.Option(metavar="DIR", help="Write a figure, a text and a JSON record of every stage.")
    ] = None,
    explain: Annotated[bool, typer.Option("--explain", help="Tell what was done, stage by stage.")] = False,
    figure: FigureOption = None,
    animate: AnimateOption = None,
    with_graph: GraphOption = False,
    as_json: JsonOption = False,
) -> None:
    """Plan the motions of a team, prove them, and print and write them."""
    if seconds is not None and not (math.isfinite(seconds) and seconds > 0):
        raise typer.BadParameter("must be a positive number", param_hint="--seconds")
    for given, option in ((weight, "--weight"), (split, "--split")):
        if given is not None and method is not Method.mrppa:
            raise typer.BadParameter("belongs to --method mrppa", param_hint=option)
    if method is Method.mrppa and roadmap != RoadmapName.visibility:
        raise typer.BadParameter("--method mrppa works on the visibility graph", param_hint="--roadmap")
    demand = contact_asked(contact, sight, connected, lambda2)
    never = Path(scene)
    require_writable(output, "a plan", (".json",), never)
    require_pictures(figure, animate, with_graph, never)
    if stages is not None:
        from taut.figures.album import require_album

        require_album(stages)
        for path in (output, figure, animate):
            if path is not None and path.parent.resolve() == stages.resolve():
                raise typer.BadParameter(
                    f"{path} must not be among the stages; choose another folder", param_hint="--stages"
                )

    from taut.formats import load_roadmap, load_scene, save
    from taut.team import plan as plan_team
    from taut.team.mrppa import split_names
    from taut.team.telling import so_far, stage_data

    began = time.perf_counter()
    world = load_scene(scene)
    room: list[str] = []
    if margin is not None:
        world, room = _with_room(world, margin)
    ground = roadmap if roadmap in list(RoadmapName) else load_roadmap(roadmap)
    with about(scene), progress(f"planning {len(world.robots)} robots") as tell:
        result = plan_team(
            world,
            method=None if method is None else method.value,
            order=order.value,
            roadmap=ground,
            seed=seed,
            rounds=rounds,
            seconds=seconds,
            progress=lambda now: tell(so_far(now)),
            objective=objective.value,
            within=within,
            weight=None if weight is None else weight.value,
            split=None if split is None else _names(split, split_names(world)),
            contact=demand,
        )
    report = plan_report(result.plan, result.certificate, list(result.shortest), list(result.detours))
    report["notes"] = [*result.notes, *room]
    report["elapsed"] = time.perf_counter() - began
    report["files"] = []
    if result.certificate.ok:
        if output is not None:
            save(result.plan, output)
            report["files"].append(str(output))
        report["files"] += write_pictures(result.plan, figure, animate, with_graph)
        if stages is not None:
            report["files"].append(write_stages(result.stages, stages))
    if as_json:
        report["stages"] = [stage_data(stage) for stage in result.stages] if explain else []
        say_json(report)
    else:
        if explain:
            say_stages(result.stages)
        for note in report["notes"]:
            say(f"note: {note}")
        say_plan(report, result.certificate)
        for name in report["files"]:
            say(f"wrote {name}")
    if not result.certificate.ok:
        complain("the plan does not hold, see the problems above; nothing was written")


def _with_room(world: Scene, study: Path) -> tuple[Scene, list[str]]:
    """Grow clearance and gap by the margin of a study; say by how much, and if the study was of something else."""
    from taut.simulation import load_margin, study_doubts, with_margin

    found = load_margin(study)
    roomy = with_margin(world, found.metres)
    wider = roomy.gap - world.gap
    said = (
        f"clearance is {found.metres:.4g} m and the gap {wider:.4g} m more than the scene asks, so that "
        f"vehicles are safe in a run with probability {found.probability:.4g} ({study}, {found.runs} runs)"
    )
    return roomy, [said, *study_doubts(study, world)]


def _names(values: Sequence[str], known: Sequence[str]) -> list[str]:
    """Read names with commas between; a name that has a comma itself may be given in an option of its own."""
    return [
        name.strip() for value in values for name in ([value] if value in known else value.split(",")) if name.strip()
    ]


def verify(
    plan: Annotated[str, typer.Argument(metavar="PLAN", help="A plan file, by whomever it was written.")],
    scene: Annotated[
        str | None, typer.Option(metavar="SCENE", help="Prove it for this scene instead of the one in the plan file.")
    ] = None,
    contact: ContactOption = None,
    sight: SightOption = False,
    connected: ConnectedOption = None,
    lambda2: Lambda2Option = None,
    as_json: JsonOption = False,
) -> None:
    """Prove a plan from the plan file alone, and the contact asked for or claimed; exit code 0 only if it holds."""
    demand = contact_asked(contact, sight, connected, lambda2)

    from taut.certificate import certify
    from taut.formats import load_plan, load_scene
    from taut.validation import validate

    claimed = load_plan(plan)
    world = None if scene is None else load_scene(scene)
    with progress("proving"):
        # A proof is about a scene that means something: in one without room for its robots nothing can hold.
        with about(plan):
            validate(claimed.scene)
        if scene is not None and world is not None:
            with about(scene):
                validate(world)
        certificate = certify(claimed, world, contact=demand)
        cuts = cuts_report(claimed, certificate)
    if as_json:
        say_json({"plan": plan, **certificate.as_dict(), **({} if cuts is None else {"cut_vertices": cuts})})
    else:
        say_facts(certificate_facts(certificate, cuts))
        say_problems(certificate)
    if not certificate.ok:
        complain(f"{plan}: the plan does not hold")


def show(
    source: Annotated[str, typer.Argument(metavar="SCENE|PLAN", help="A scene, a ready scene's name, or a plan file.")],
    figure: Annotated[
        Path | None, typer.Option("-o", "--figure", metavar="FILE", help="Draw a figure (.png, .pdf or .svg).")
    ] = None,
    animate: AnimateOption = None,
    with_graph: GraphOption = False,
    contact: Annotated[
        float | None, typer.Option("--contact", metavar="R", help="Draw the links of a plan within R metres.")
    ] = None,
    sight: SightOption = False,
    as_json: JsonOption = False,
) -> None:
    """Sum up a scene or a plan; with --figure draw it."""
    links = contact_asked(contact, sight)
    never = Path(source)
    require_pictures(figure, animate, with_graph, never)
    if links is not None and figure is None and animate is None:
        raise typer.BadParameter("is drawn: give --figure FILE or --animate FILE too", param_hint="--contact")

    from taut.certificate import certify
    from taut.motion import Plan
    from taut.validation import validate

    value = _load(source)
    if not isinstance(value, Plan):
        if links is not None:
            raise OutputError(f"{source}: a scene has no links; make a plan first: taut plan {source} -o plan.json")
        if animate is not None:
            raise OutputError(f"{animate}: a scene does not move; make a plan first: taut plan {source} -o plan.json")
        report = scene_report(value)
        with about(source):
            report["files"] = write_pictures(value, figure, None, with_graph)
        if as_json:
            say_json(report)
            return
        say_scene(report)
        for name in report["files"]:
            say(f"wrote {name}")
        return
    with about(source):
        validate(value.scene)
    certificate = certify(value)
    report = plan_report(value, certificate)
    # Pictures say whether a plan is certified: by this proof, not by the one that the file claims.
    shown = replace(value, certificate=certificate.as_dict())
    report["files"] = write_pictures(shown, figure, animate, with_graph, links)
    if as_json:
        say_json(report)
    else:
        say_scene(scene_report(value.scene))
        say()
        say_plan(report, certificate)
        for name in report["files"]:
            say(f"wrote {name}")
    if not certificate.ok:
        complain(f"{source}: the plan does not hold")


def _load(source: str) -> Scene | Plan:
    """Load a plan if the file says that it is one, otherwise a scene."""
    from taut.formats import load_plan, load_scene

    path = Path(source)
    if path.suffix.lower() == ".json" and path.is_file():
        try:
            return load_plan(path)
        except SceneError:
            with path.open(encoding="utf-8", errors="replace") as file:
                if re.search(r'"kind"\s*:\s*"plan"', file.read(1_000_000)):
                    raise
    return load_scene(source)
