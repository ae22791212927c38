"""The command steer: a team of real vehicles under a control law, without a plan."""

from __future__ import annotations

import math
from collections.abc import Sequence
from enum import StrEnum
from itertools import combinations
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from taut.cli.options import AnimateOption, FigureOption, JsonOption, SceneArgument
from taut.cli.output import about, complain, progress, say, say_facts, say_json
from taut.cli.pictures import require_pictures
from taut.cli.tables import say_table
from taut.cli.vehicle_options import (
    FEW_ROBOTS,
    MISSING,
    DiesOption,
    HeadingNoiseOption,
    PositionNoiseOption,
    RobotsOption,
    SlipOption,
    SlowOption,
    SpeedErrorOption,
    StepOption,
    StopSecondsOption,
    StopsOption,
    VehicleKind,
    VehicleOption,
    disturbances,
)

if TYPE_CHECKING:
    from taut.control import Field, Links
    from taut.scene import FloatArray, Scene
    from taut.simulation import Steered


class LawName(StrEnum):
    """What the team does."""

    consensus = "consensus"
    rendezvous = "rendezvous"
    formation = "formation"
    leader = "leader"


def steer(
    scene: SceneArgument,
    law: Annotated[
        LawName,
        typer.Option(
            help="Gather (consensus; rendezvous keeps links), take a formation, or gather among leaders that stand."
        ),
    ] = LawName.formation,
    reach: Annotated[
        float | None,
        typer.Option(metavar="R", help="Robots within R metres are linked; without it all are, at any distance."),
    ] = None,
    offset: Annotated[
        list[str] | None,
        typer.Option(metavar="NAME=X,Y", help="Place of every robot in the formation; by default the goals are it."),
    ] = None,
    leader: Annotated[
        list[str] | None, typer.Option(metavar="NAME", help="A robot that stands and leads; by default the first.")
    ] = None,
    vehicle: VehicleOption = VehicleKind.differential,
    seed: Annotated[int, typer.Option(min=0, help="Seed of everything random.")] = 0,
    speed_error: SpeedErrorOption = 0.0,
    stops: StopsOption = 0.0,
    stop_seconds: StopSecondsOption = 2.0,
    slow: SlowOption = None,
    dies: DiesOption = None,
    position_noise: PositionNoiseOption = 0.0,
    heading_noise: HeadingNoiseOption = 0.0,
    slip: SlipOption = 0.0,
    step: StepOption = 0.02,
    seconds: Annotated[float, typer.Option(metavar="S", help="How long the team may take to settle.")] = 60.0,
    settled: Annotated[
        float | None,
        typer.Option(
            metavar="F",
            help="Settled is who is asked for less than F of its speed; 0.01, with trucks 0.05, by default.",
        ),
    ] = None,
    robots: RobotsOption = False,
    figure: FigureOption = None,
    animate: AnimateOption = None,
    as_json: JsonOption = False,
) -> None:
    """Let vehicles steer themselves by a control law until they have settled: no plan, obstacles are not avoided."""
    _check_options(law, reach, offset, leader)
    require_pictures(figure, animate, False, Path(scene))

    from taut.formats import load_scene
    from taut.simulation import steer as follow

    met = disturbances(speed_error, stops, stop_seconds, slow, dies, position_noise, heading_noise, slip)
    world = load_scene(scene)
    places = _places(world, offset)
    field = _law(law, world, reach, places, leader)
    with about(scene), progress(f"steering {len(world.robots)} robots"):
        run = follow(world, field, str(vehicle), seed, met, step, seconds=seconds, settled=settled)
    report = _report(run, law, reach, places if law == LawName.formation else None)
    report["files"] = _pictures(run, reach, figure, animate)
    if as_json:
        say_json(report)
    else:
        _say(report, robots or len(run.names) <= FEW_ROBOTS)
        for name in report["files"]:
            say(f"wrote {name}")
    hits = len(run.collisions)
    if hits or not run.settled:
        wrong = [f"{hits} collision{'s' * (hits != 1)}"] * bool(hits)
        wrong += [f"not settled after {run.seconds:g} s"] * (not run.settled)
        complain(f"{scene}: {' and '.join(wrong)}")


def _check_options(law: LawName, reach: float | None, offset: list[str] | None, leader: list[str] | None) -> None:
    if reach is not None and not (math.isfinite(reach) and reach > 0):
        raise typer.BadParameter("must be a positive number of metres", param_hint="--reach")
    if law == LawName.rendezvous and reach is None:
        raise typer.BadParameter("rendezvous keeps links within a reach: give --reach R too", param_hint="--law")
    if offset and law != LawName.formation:
        raise typer.BadParameter("belongs to --law formation", param_hint="--offset")
    if leader and law != LawName.leader:
        raise typer.BadParameter("belongs to --law leader", param_hint="--leader")


def _places(scene: Scene, offset: Sequence[str] | None) -> list[tuple[float, float]]:
    """Places of the robots in the formation: as given, or the goals."""
    if not offset:
        return [robot.goal for robot in scene.robots]
    given = dict(map(_place, offset))
    for name in given:
        scene.robot(name)
    missing = [robot.name for robot in scene.robots if robot.name not in given]
    if missing:
        more = " and others" if len(missing) > 1 else ""
        raise typer.BadParameter(f"places every robot or none; {missing[0]}{more} have none", param_hint="--offset")
    return [given[robot.name] for robot in scene.robots]


def _place(text: str) -> tuple[str, tuple[float, float]]:
    name, equals, numbers = text.rpartition("=")
    try:
        x, y = (float(part) for part in numbers.split(","))
    except ValueError:
        equals, x, y = "", 0.0, 0.0
    if not (equals and name and math.isfinite(x) and math.isfinite(y)):
        raise typer.BadParameter(f"must be like R2=-1,0.5, got {text!r}", param_hint="--offset")
    return name, (x, y)


def _law(
    law: LawName,
    scene: Scene,
    reach: float | None,
    places: Sequence[tuple[float, float]],
    leader: Sequence[str] | None,
) -> Field:
    import numpy as np

    from taut.control import consensus, formation, leader_follower, rendezvous
    from taut.graph import contact_graph

    if law == LawName.rendezvous:
        assert reach is not None
        # a link as long as its reach has no velocity
        return rendezvous(contact_graph([r.start for r in scene.robots], math.nextafter(reach, 0.0)), reach)
    links = _links(len(scene.robots), reach)
    if law == LawName.consensus:
        return consensus(links)
    if law == LawName.formation:
        return formation(links, np.array(places, dtype=np.float64).reshape(-1, 2))
    names = [robot.name for robot in scene.robots]
    leaders = [scene.robot(name).name for name in leader] if leader else names[:1]
    return leader_follower(links, {names.index(name): _standing for name in leaders})


def _standing(time: float) -> tuple[float, float]:
    return 0.0, 0.0


def _links(n: int, reach: float | None) -> Links:
    """All pairs, or those within reach where the robots are."""
    from taut.graph import Graph, contact_graph

    if reach is None:
        return Graph.from_edges(n, list(combinations(range(n), 2)))
    within = reach

    def near(positions: FloatArray) -> Graph:
        return contact_graph(positions, within)

    return near


def _pictures(run: Steered, reach: float | None, figure: Path | None, animation: Path | None) -> list[str]:
    written = []
    if figure is not None:
        from taut.figures import save_steered

        with progress(f"drawing {figure}"):
            save_steered(run, figure, _links(len(run.names), reach))
        written.append(str(figure))
    if animation is not None:
        from taut.figures import animate

        with progress(f"drawing {animation}"):
            animate(run.plan, animation, contact=reach)
        written.append(str(animation))
    return written


def _report(
    run: Steered, law: LawName, reach: float | None, places: Sequence[tuple[float, float]] | None
) -> dict[str, Any]:
    import numpy as np

    from taut.simulation import fiedler_values, formation_error

    fiedler = fiedler_values(run, _links(len(run.names), reach))
    centres = run.poses[:, :, :2].mean(axis=1) if run.names else np.zeros((len(run.times), 2))
    least = int(fiedler.argmin())
    here = run.poses[-1]
    asked = np.hypot(run.velocities[-1, :, 0], run.velocities[-1, :, 1])
    return {
        "scene": run.scene.name,
        "law": str(law),
        "reach": reach,
        "seed": run.seed,
        "dt": run.dt,
        "disturbances": run.disturbances.as_dict(),
        "seconds": run.seconds,
        "law_seconds": float(run.clock[-1]),
        "settled": run.settled_at,
        "spread": float(np.hypot(*(here[:, :2] - centres[-1]).T).max(initial=0.0)),
        "centroid_moved": math.dist(centres[0], centres[-1]),
        "formation_error": None if places is None else formation_error(here[:, :2], places),
        "lambda2": {
            "start": float(fiedler[0]),
            "least": float(fiedler[least]),
            "time": float(run.times[least]),
            "end": float(fiedler[-1]),
        },
        "links_lost": None if reach is None else _lost(run, reach),
        "collisions": [vars(collision) for collision in run.collisions],
        "robots": [
            {
                "name": name,
                "pose": here[i].tolist(),
                "asked": float(asked[i]),
                "clearance": run.clearances[i].distance,
                "separation": run.separations[i].distance,
                "collisions": sum(name in (c.robot, c.other) for c in run.collisions),
                "distance": float(run.distance[i]),
                "turned": float(run.turned[i]),
                "energy": float(run.work[i]),
            }
            for i, name in enumerate(run.names)
        ],
    }


def _lost(run: Steered, reach: float) -> list[dict[str, Any]]:
    """Links of the start that were longer than the reach at some recorded instant."""
    import numpy as np

    from taut.graph import contact_graph

    edges = contact_graph(run.poses[0, :, :2], reach).edges
    lengths = np.hypot(*np.moveaxis(run.poses[:, edges[:, 0], :2] - run.poses[:, edges[:, 1], :2], 2, 0))
    broken = lengths > reach
    return [
        {"robots": [run.names[i] for i in edges[k]], "time": float(run.times[broken[:, k].argmax()])}
        for k in np.flatnonzero(broken.any(axis=0))
    ]


def _say(report: dict[str, Any], each: bool) -> None:
    told = report["robots"]
    if not each:
        told = sorted(told, key=lambda r: (not r["collisions"], -r["asked"]))[:FEW_ROBOTS]
    rows = [
        [
            robot["name"],
            f"({robot['pose'][0]:.3f}, {robot['pose'][1]:.3f})",
            f"{1000 * robot['asked']:.1f}" if math.isfinite(robot["asked"]) else "no law",
            _shown(robot["clearance"]),
            _shown(robot["separation"]),
            f"{robot['distance']:.2f}",
            f"{math.degrees(robot['turned']):.0f}",
            f"{robot['energy']:.1f}",
        ]
        for robot in told
    ]
    heads = ["robot", "ended at", "asked (mm/s)", "clear (m)", "apart (m)", "way (m)", "turns (°)", "energy (J/kg)"]
    say_table(heads, rows, left=("robot", "ended at"))
    if len(told) < len(report["robots"]):
        say(f"(the worst {len(told)} of {len(report['robots'])}; --robots tells of all)")
    say()
    linked = report["lambda2"]
    facts = [
        ("settled", f"after {report['settled']:.4g} s" if math.isfinite(report["settled"]) else "no"),
        ("spread", f"{report['spread']:.4g} m from the centroid, which moved {report['centroid_moved']:.3g} m"),
    ]
    if report["formation_error"] is not None:
        facts.append(("formation", f"{report['formation_error']:.4g} m off at most"))
    facts.append(
        ("λ2", f"{linked['start']:.4g}, at the end {linked['end']:.4g}, least {linked['least']:.4g}"
               f" at t = {linked['time']:.4g} s")
    )  # fmt: skip
    if report["links_lost"] is not None:
        lost = ", ".join("–".join(link["robots"]) + f" ({link['time']:.4g} s)" for link in report["links_lost"][:5])
        facts.append(("links lost", f"{len(report['links_lost'])}: {lost}" if lost else "none"))
    facts.append(("collisions", str(len(report["collisions"])) if report["collisions"] else "none"))
    say_facts(facts)
    hits = [
        [hit["robot"], hit["other"], f"{hit['time']:.2f}", "({:.3f}, {:.3f})".format(*hit["place"])]
        for hit in report["collisions"]
    ]
    if hits:
        say()
        say_table(["robot", "hit", "at (s)", "near"], hits, left=("robot", "hit", "near"))


def _shown(distance: float) -> str:
    return f"{distance:.3f}" if math.isfinite(distance) else MISSING
