"""The command simulate: real vehicles follow a plan, once with all there is to tell, or many times as a study."""

from __future__ import annotations

import json
import math
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from taut.cli import INTERRUPTED
from taut.cli.options import AnimateOption, FigureOption
from taut.cli.output import about, complain, progress, require_writable, say, say_error, say_facts, say_json
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
    from taut.motion import Plan
    from taut.simulation import Disturbances, Lidar, Run, Study


def simulate(
    plan: Annotated[str, typer.Argument(metavar="PLAN", help="A plan file.")],
    vehicle: VehicleOption = VehicleKind.differential,
    seed: Annotated[int, typer.Option(min=0, help="Seed of everything random; of a study the first.")] = 0,
    no_coordination: Annotated[
        bool, typer.Option("--no-coordination", help="Robots keep to the clock, whoever is late.")
    ] = False,
    speed_error: SpeedErrorOption = 0.0,
    stops: StopsOption = 0.0,
    stop_seconds: StopSecondsOption = 2.0,
    slow: SlowOption = None,
    dies: DiesOption = None,
    position_noise: PositionNoiseOption = 0.0,
    heading_noise: HeadingNoiseOption = 0.0,
    slip: SlipOption = 0.0,
    lidar: Annotated[bool, typer.Option("--lidar", help="Robots look around with 181 beams over 180°, 10 m.")] = False,
    step: StepOption = 0.02,
    robots: RobotsOption = False,
    after: Annotated[
        Path | None, typer.Option(metavar="SCENE", help="Write the scene as it stands at the end, to plan on from.")
    ] = None,
    seeds: Annotated[
        int | None, typer.Option(min=1, max=10_000_000, metavar="N", help="A study: N runs on all cores.")
    ] = None,
    probability: Annotated[
        float, typer.Option(metavar="P", help="Of a study: the margin is kept in a run with probability P.")
    ] = 0.999,
    output: Annotated[
        Path | None, typer.Option("-o", "--output", metavar="STUDY", help="Write the study (.json, .jsonl).")
    ] = None,
    figure: FigureOption = None,
    animate: AnimateOption = None,
    as_json: Annotated[
        bool, typer.Option("--json", help="Print one JSON object; with --seeds a line a run and the summary.")
    ] = False,
) -> None:
    """Let vehicles follow a plan in a closed loop: errors, collisions, delays; or many times: the margin they need."""
    never = Path(plan)
    _check_options(seeds, output, {"--lidar": lidar, "--after": after, "--figure": figure, "--animate": animate})
    require_writable(output, "a study", (".json", ".jsonl"), never)
    require_writable(after, "a scene", (".yaml", ".yml", ".json"), never)
    require_pictures(figure, animate, False, never)

    from taut.formats import load_plan
    from taut.simulation import Lidar

    met = disturbances(speed_error, stops, stop_seconds, slow, dies, position_noise, heading_noise, slip)
    followed = load_plan(plan)
    if seeds is not None:
        _study(plan, followed, vehicle, seed, seeds, met, not no_coordination, step, probability, output, as_json)
        return
    looking = Lidar() if lidar else None
    _once(
        plan, followed, vehicle, seed, met, not no_coordination, looking, step, robots, after, figure, animate, as_json
    )


def _check_options(seeds: int | None, output: Path | None, single: dict[str, object]) -> None:
    if seeds is None and output is not None:
        raise typer.BadParameter("writes a study: give --seeds N too", param_hint="-o")
    if seeds is not None:
        for option, given in single.items():
            if given:
                raise typer.BadParameter("belongs to a single run, not to --seeds", param_hint=option)


def _once(
    source: str,
    plan: Plan,
    vehicle: str,
    seed: int,
    met: Disturbances,
    coordination: bool,
    lidar: Lidar | None,
    step: float,
    each: bool,
    after: Path | None,
    figure: Path | None,
    animate: Path | None,
    as_json: bool,
) -> None:
    from taut.formats import save
    from taut.simulation import run_data, scene_from
    from taut.simulation import simulate as follow

    with about(source), progress(f"simulating {len(plan.trajectories)} robots"):
        run = follow(plan, str(vehicle), seed, met, coordination, lidar, step)
    report = {**run_data(run), "files": _pictures(run, figure, animate)}
    if after is not None:
        save(scene_from(run), after)
        report["files"].append(str(after))
    if as_json:
        say_json(report)
    else:
        _say_run(run, report, each or len(run.names) <= FEW_ROBOTS)
        if after is not None and report["dead"]:
            say(f"note: dead, so an obstacle in {after}: {', '.join(report['dead'])}")
        for name in report["files"]:
            say(f"wrote {name}")
    hits, missing = len(run.collisions), len(report["stopped"])
    if hits or missing:
        wrong = [f"{hits} collision{'s' * (hits != 1)}"] * bool(hits)
        wrong += [f"{missing} robot{'s' * (missing != 1)} did not arrive"] * bool(missing)
        more = "; --after SCENE writes the scene to plan on from" if missing and after is None else ""
        complain(f"{source}: {' and '.join(wrong)}{more}")


def _pictures(run: Run, figure: Path | None, animate: Path | None) -> list[str]:
    written = []
    if figure is not None:
        from taut.figures import save_figure

        with progress(f"drawing {figure}"):
            save_figure(run, figure)
        written.append(str(figure))
    if animate is not None:
        from taut.figures import animate_run

        with progress(f"drawing {animate}"):
            animate_run(run, animate)
        written.append(str(animate))
    return written


def _say_run(run: Run, report: dict[str, Any], each: bool) -> None:
    told = report["robots"]
    if not each:
        told = sorted(told, key=lambda r: (not r["collisions"], r["stopped"] is None, -r["cross_track"]))[:FEW_ROBOTS]
    rows = [
        [
            robot["name"],
            _shown(robot["arrival"], ".2f"),
            _shown(robot["late"], ".2f"),
            f"{1000 * robot['cross_track']:.1f}",
            f"{1000 * robot['cross_track_rms']:.1f}",
            _shown(_distance(robot["clearance"]), ".3f"),
            _shown(_distance(robot["separation"]), ".3f"),
            f"{robot['distance']:.2f}",
            f"{math.degrees(robot['turned']):.0f}",
            f"{robot['energy']:.1f}",
            _waited(robot),
        ]
        for robot in told
    ]
    heads = [
        "robot", "arrival (s)", "late (s)", "off (mm)", "rms (mm)", "clear (m)", "apart (m)", "way (m)", "turns (°)",
        "energy (J/kg)", "waited for",
    ]  # fmt: skip
    say_table(heads, rows, left=("robot", "waited for"))
    if len(told) < len(run.names):
        say(f"(the worst {len(told)} of {len(run.names)}; --robots tells of all)")
    say()
    link = report["contact"]
    last = MISSING if report["makespan"] is None else f"{report['makespan']:.6g} s"
    facts = [
        ("arrived", f"{report['arrived']} of {len(run.names)}"),
        ("makespan", f"{last}, planned {report['planned']:.6g} s"),
        ("off the path", f"{1000 * max((r['cross_track'] for r in report['robots']), default=0.0):.1f} mm at most"),
        ("waiting", f"{report['lost']:.4g} s lost by all robots together"),
        ("collisions", str(len(run.collisions)) if run.collisions else "none"),
    ]
    if link is not None:
        lost = f"lost {len(link['lost'])} times" if link["lost"] else "kept throughout"
        facts.append(("contact", f"{lost}, least λ2 {link['least']:.6g} at t = {link['time']:.6g} s"))
    say_facts(facts)
    hits = [
        [
            hit.robot,
            hit.other,
            f"{hit.time:.2f}",
            f"({hit.place[0]:.3f}, {hit.place[1]:.3f})",
            f"{1000 * hit.depth:.1f}",
        ]
        for hit in run.collisions
    ]
    if hits:
        say()
        say_table(["robot", "hit", "at (s)", "near", "depth (mm)"], hits, left=("robot", "hit", "near"))
    if report["stopped"]:
        say()
        say_table(["stopped", "why"], [list(row) for row in report["stopped"].items()], left=("stopped", "why"))


def _study(
    source: str,
    plan: Plan,
    vehicle: str,
    first: int,
    count: int,
    met: Disturbances,
    coordination: bool,
    step: float,
    probability: float,
    output: Path | None,
    as_json: bool,
) -> None:
    from taut.simulation import StudyInterrupted, save_study, study, study_summary

    interrupted = False
    with about(source), progress("simulating") as tell:
        try:
            found = study(
                plan,
                range(first, first + count),
                str(vehicle),
                met,
                coordination,
                step,
                probability,
                tell=lambda done: tell(f"{done} of {count} runs"),
            )
        except StudyInterrupted as stopped:
            found, interrupted = stopped.study, True
    if output is not None:
        save_study(found, output)
    if as_json:
        for trial in found.trials:
            print(json.dumps(vars(trial), allow_nan=False))
        print(json.dumps(study_summary(found), allow_nan=False))
    else:
        _say_study(found, probability)
        if output is not None:
            say(f"wrote {output}")
    if interrupted:
        say_error(f"interrupted: {len(found.trials)} of {count} runs were made")
        raise typer.Exit(INTERRUPTED)


def _say_study(found: Study, probability: float) -> None:
    from taut.simulation import runs_needed

    least, median, greatest = found.makespans
    count, margin = len(found.trials), found.margin
    near = [trial.separation for trial in found.trials if trial.separation is not None]
    close = [trial.clearance for trial in found.trials if trial.clearance is not None]
    say_facts(
        [
            ("runs", f"{count}, all robots arrived in {found.complete}, collisions in {found.collided}"),
            ("makespan", f"{median:.4g} s ({least:.4g} to {greatest:.4g}), planned {found.planned:.4g} s"),
            ("least clearance", f"{min(close):.4g} m" if close else MISSING),
            ("least separation", f"{min(near):.4g} m" if near else MISSING),
            (
                "margin",
                f"{margin.metres:.4g} m, kept in a run with probability {margin.probability:.4g} "
                f"(confidence {margin.confidence:g}, order statistics)",
            ),
        ]
    )
    if found.complete < count:
        say(
            f"note: in {count - found.complete} of {count} runs not all robots arrived; the margin leaves out what "
            "they did not drive, and taut plan does not take it"
        )
    if found.collided:
        say(f"note: collisions in {found.collided} of {count} runs; the margin says how much room they need")
    if not found.coordinated:
        say("note: robots that do not wait for each other are kept apart by no margin; taut plan does not take it")
    if margin.probability < probability:
        needed = runs_needed(probability, margin.confidence)
        say(f"note: {count} runs are too few for {probability:g}; it takes {needed:,}")


def _waited(robot: dict[str, Any]) -> str:
    if robot["stopped"]:
        return str(robot["stopped"])
    longest = sorted(robot["waited_for"].items(), key=lambda pair: -pair[1])
    told = [f"{name} ({lost:.1f} s)" for name, lost in longest[:2]]
    return ", ".join(told) + (f" and {len(longest) - 2} more" if len(longest) > 2 else "")


def _distance(nearest: dict[str, Any] | None) -> float | None:
    return None if nearest is None else nearest["distance"]


def _shown(value: float | None, form: str) -> str:
    return MISSING if value is None else format(value, form)
