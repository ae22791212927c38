"""The command travel: a team that follows its leader in formation."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from taut.cli.options import (
    AnimateOption,
    ConnectedOption,
    ContactOption,
    FigureOption,
    JsonOption,
    Lambda2Option,
    SceneArgument,
    SightOption,
    contact_asked,
)
from taut.cli.output import about, complain, progress, require_writable, say, say_json
from taut.cli.pictures import require_pictures, write_pictures
from taut.cli.reports import plan_report, say_plan


def travel(
    scene: SceneArgument,
    output: Annotated[
        Path | None, typer.Option("-o", "--output", metavar="PLAN", help="Write the plan (.json).")
    ] = None,
    leader: Annotated[str | None, typer.Option(metavar="NAME", help="Who leads; the first robot by default.")] = None,
    offset: Annotated[
        list[str] | None,
        typer.Option(
            metavar="NAME=DX,DY", help="Put a robot there beside the leader; without any the starts are the formation."
        ),
    ] = None,
    keep: Annotated[float, typer.Option(metavar="M", help="Metres of detour that a metre in a column is worth.")] = 2.0,
    contact: ContactOption = None,
    sight: SightOption = False,
    connected: ConnectedOption = None,
    lambda2: Lambda2Option = None,
    figure: FigureOption = None,
    animate: AnimateOption = None,
    as_json: JsonOption = False,
) -> None:
    """Lead a team in formation from its starts to its goals; it contracts in narrow places and recovers after them."""
    demand = contact_asked(contact, sight, connected, lambda2)
    never = Path(scene)
    require_writable(output, "a plan", (".json",), never)
    require_pictures(figure, animate, False, never)

    from taut.formation import in_formation
    from taut.formation import travel as lead
    from taut.formats import load_scene, save

    world = load_scene(scene)
    with about(scene), progress(f"planning {len(world.robots)} robots"):
        if offset:
            world = in_formation(world, dict(map(_offset, offset)), leader)
        formed = lead(world, leader, demand, keep)
    report = plan_report(formed.plan, formed.certificate)
    report["narrow"] = [
        {"begin": n.begin, "end": n.end, "scale": n.scale, "order": list(n.order), "place": list(n.place)}
        for n in formed.narrow
    ]
    report["formation_error"] = float(formed.errors.max(initial=0.0))
    report["files"] = []
    if formed.certificate.ok:
        if output is not None:
            save(formed.plan, output)
            report["files"].append(str(output))
        report["files"] += write_pictures(formed.plan, figure, animate, False)
    if as_json:
        say_json(report)
    else:
        for stretch in formed.narrow:
            how = (
                f"in a column ({', '.join(stretch.order)})" if stretch.order else f"at {stretch.scale:.0%} of its size"
            )
            x, y = stretch.place
            say(f"near ({x:.2f}, {y:.2f}) the team goes {how} from t = {stretch.begin:.2f} s to {stretch.end:.2f} s")
        say(f"formation error at most {report['formation_error']:.6g} m")
        say()
        say_plan(report, formed.certificate)
        for name in report["files"]:
            say(f"wrote {name}")
    if not formed.certificate.ok:
        complain("the plan does not hold, see the problems above; nothing was written")


def _offset(text: str) -> tuple[str, tuple[float, float]]:
    name, equals, numbers = text.rpartition("=")
    try:
        dx, dy = (float(part) for part in numbers.split(","))
    except ValueError:
        equals = ""
    if not equals or not name:
        raise typer.BadParameter(f"must be like R2=-1,0.5, got {text!r}", param_hint="--offset")
    return name, (dx, dy)
