"""The command compare: all ways of finding routes side by side, on one scene, on many like it, or against clearance."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from decimal import Decimal, InvalidOperation
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from taut.cli.options import FigureOption, JsonOption, SceneArgument
from taut.cli.output import about, progress, require_writable, say, say_json
from taut.cli.pictures import FIGURES
from taut.cli.reports import Report
from taut.cli.tables import say_table

if TYPE_CHECKING:
    from taut.comparison import Comparison, Entry, Trial
    from taut.scene import Scene

FEW_ROBOTS = 10  # up to this many have their table without being asked for
MOST_STEPS = 1000  # clearances in one sweep
SWEPT = ("visibility", "oca", "ca")  # the ways of a sweep if none are named: those of the thesis' section 6.6
MISSING = "–"


def compare(
    scene: SceneArgument,
    roadmaps: Annotated[
        str | None,
        typer.Option(
            metavar="NAMES", help="Only these, like visibility,oca,prm; else all, with --clearance visibility,oca,ca."
        ),
    ] = None,
    seed: Annotated[int, typer.Option(min=0, help="Seed of everything random.")] = 0,
    robots: Annotated[
        bool, typer.Option("--robots", help=f"Tell of every robot, also of more than {FEW_ROBOTS}.")
    ] = False,
    random: Annotated[
        int | None,
        typer.Option(min=1, max=100_000, metavar="N", help="Compare on N random scenes like SCENE: their spread."),
    ] = None,
    clearance: Annotated[
        str | None,
        typer.Option(metavar="A:B:STEP", help="Compare with the clearance of all robots set to A, A + STEP, … B m."),
    ] = None,
    figure: FigureOption = None,
    as_json: JsonOption = False,
) -> None:
    """Compare all roadmaps: length, clearance, turns, size and time of each, every route proved."""
    if random is not None and clearance is not None:
        raise typer.BadParameter("does not go with --random: choose one of them", param_hint="--clearance")
    if robots and (random is not None or clearance is not None):
        other = "--random" if random is not None else "--clearance"
        raise typer.BadParameter(f"does not go with {other}, which sums up; --json tells all", param_hint="--robots")
    asked = None if clearance is None else _clearances(clearance)
    require_writable(figure, "a figure", FIGURES, Path(scene))
    ways = _ways(roadmaps, asked is not None)

    from taut.formats import load_scene

    world = load_scene(scene)
    with about(scene):
        if asked is not None:
            report, tell = _swept(world, asked, ways, seed, figure)
        elif random is not None:
            report, tell = _thrown(world, random, ways, seed, figure)
        else:
            report, tell = _once(world, ways, seed, figure, robots or len(world.robots) <= FEW_ROBOTS)
    if as_json:
        say_json(report)
        return
    if not world.robots:
        say("no robots: there are no routes to compare")
        return
    tell()
    for name in report["files"]:
        say(f"wrote {name}")


Told = tuple[Report, Callable[[], None]]
"""What came out as plain data, and how it is told to people."""


def _once(world: Scene, ways: Sequence[str], seed: int, figure: Path | None, each: bool) -> Told:
    from taut.comparison import compare as compare_ways
    from taut.validation import validate

    with progress("comparing") as tell:
        validate(world)
        found = compare_ways(world, ways, seed, tell=tell)
    files = []
    if figure is not None:
        from taut.figures.comparison import save_comparison

        with progress(f"drawing {figure}"):
            save_comparison(found, figure)
        files.append(str(figure))
    return {**_report(found), "files": files}, lambda: _say_comparison(found, each)


def _thrown(world: Scene, count: int, ways: Sequence[str], seed: int, figure: Path | None) -> Told:
    from taut.comparison import compare_random

    with progress("comparing") as tell:
        found = compare_random(world, count, ways, seed, tell=tell)
    files = []
    if figure is not None:
        from taut.figures.comparison import save_distributions

        with progress(f"drawing {figure}"):
            save_distributions(found, figure)
        files.append(str(figure))
    spreads = [_spread_report([c.entries[k] for c in found]) for k in range(len(ways))]
    scenes = [_report(comparison) for comparison in found]
    report = {"scene": world.name, "seed": seed, "count": count, "ways": spreads, "scenes": scenes, "files": files}
    return report, lambda: _say_spreads(spreads, found)


def _swept(world: Scene, asked: Sequence[float], ways: Sequence[str], seed: int, figure: Path | None) -> Told:
    from taut.comparison import compare_clearances

    with progress("comparing") as tell:
        found = compare_clearances(world, asked, ways, seed, tell=tell)
    files = []
    if figure is not None:
        from taut.figures.comparison import save_clearances

        with progress(f"drawing {figure}"):
            save_clearances(found, figure)
        files.append(str(figure))
    steps = [{"clearance": value, **_report(comparison)} for value, comparison in zip(asked, found, strict=True)]
    report = {"scene": world.name, "seed": seed, "clearances": list(asked), "steps": steps, "files": files}
    return report, lambda: _say_sweep(found)


def _ways(names: str | None, sweep: bool) -> tuple[str, ...]:
    from taut.route.ways import WAYS

    if names is None:
        return tuple(name for name in SWEPT if name in WAYS) if sweep else tuple(WAYS)
    chosen = tuple(dict.fromkeys(name.strip() for name in names.split(",") if name.strip()))
    for name in chosen:
        if name not in WAYS:
            raise typer.BadParameter(f"{name!r} is unknown, take from {', '.join(WAYS)}", param_hint="--roadmaps")
    if not chosen:
        raise typer.BadParameter(f"names none, take from {', '.join(WAYS)}", param_hint="--roadmaps")
    return chosen


def _clearances(text: str) -> tuple[float, ...]:
    """Read A:B:STEP; decimal, so that 0:1:0.1 holds 0.3 and 1, not their neighbours."""
    hint = "--clearance"
    try:
        low, high, step = (Decimal(part.strip()) for part in text.split(":"))
    except (InvalidOperation, ValueError):
        raise typer.BadParameter(f"must be three numbers like 0:1:0.1, got {text!r}", param_hint=hint) from None
    if not all(number.is_finite() and abs(number) <= Decimal("1e9") for number in (low, high, step)):
        raise typer.BadParameter(f"must be numbers of metres up to 1e9, got {text!r}", param_hint=hint)
    if low < 0:
        raise typer.BadParameter(f"must not begin below 0 m, got {low} m", param_hint=hint)
    if high < low:
        raise typer.BadParameter(f"must not end at {high} m below its begin, {low} m", param_hint=hint)
    if step <= 0:
        raise typer.BadParameter(f"must go in steps above 0 m, got {step} m", param_hint=hint)
    if (high - low) / step >= MOST_STEPS:
        most = f"has room for {MOST_STEPS:,} clearances, not {(high - low) / step + 1:,.0f}: take larger steps"
        raise typer.BadParameter(most, param_hint=hint)
    return tuple(float(low + k * step) for k in range(int((high - low) / step) + 1))


def _report(found: Comparison) -> Report:
    """Return all of a comparison as plain data."""
    shortest = [None if math.isnan(length) else length for length in found.shortest.tolist()]
    team = [
        {"name": robot.name, "shortest": length} for robot, length in zip(found.scene.robots, shortest, strict=True)
    ]
    return {
        "scene": found.scene.name,
        "seed": found.seed,
        "robots": team,
        "blocked": dict(found.blocked),
        "ways": [_entry_report(entry) for entry in found.entries],
    }


def _entry_report(entry: Entry) -> Report:
    from taut.comparison import summary

    return {**vars(summary(entry)), "trials": [dict(vars(trial)) for trial in entry.trials]}


def _say_comparison(found: Comparison, each: bool) -> None:
    from taut.comparison import summary

    heads = ["way", "solved", "ratio", "worst", "clearance (m)", "least (m)", "turns"]
    sums = [summary(entry) for entry in found.entries]
    rows = [
        [
            s.way,
            f"{s.solved} of {s.robots}",
            _shown(s.mean_ratio, ".4f"),
            _shown(s.worst_ratio, ".4f"),
            _shown(s.mean_clearance, ".4f"),
            _shown(s.least_clearance, ".4f"),
            _shown(s.mean_turns, ".1f"),
        ]
        for s in sums
    ]
    say_table(heads, rows, left=("way",))
    if any(0 < s.solved < s.robots for s in sums):
        say("(of the robots that a way solves)")
    say()
    heads = ["way", "turning (°)", "vertices", "edges", "obstacles", "build (ms)", "query (ms)"]
    rows = [
        [
            s.way,
            _shown(s.mean_turning, ".0f", 180 / math.pi),
            _shown(s.vertices, ".0f"),
            _shown(s.edges, ".0f"),
            _shown(s.obstacles, ".1f"),
            _shown(s.build_seconds, ".2f", 1e3),
            _shown(s.query_seconds, ".3f", 1e3),
        ]
        for s in sums
    ]
    say_table(heads, rows, left=("way",))
    failed = [(entry.way, [trial for trial in entry.trials if not trial.solved]) for entry in found.entries]
    if each and found.scene.robots:
        _say_robots(found)
        lines = [[way, trial.robot, trial.reason] for way, trials in failed for trial in trials]
    else:
        lines = [[way, _and_more(trials), trials[0].reason] for way, trials in failed if trials]
    if lines:
        say()
        say_table(["not solved by", "robot", "why"], lines, left=("not solved by", "robot", "why"))


def _say_robots(found: Comparison) -> None:
    """Print the ratio of every robot and way."""
    rows = [
        [
            robot.name,
            _shown(None if length != length else length, ".4f"),
            *(_shown(entry.trials[k].ratio, ".4f") for entry in found.entries),
        ]
        for k, (robot, length) in enumerate(zip(found.scene.robots, found.shortest.tolist(), strict=True))
    ]
    say()
    say_table(["robot", "shortest (m)", *(entry.way for entry in found.entries)], rows, left=("robot",))


def _and_more(trials: Sequence[Trial]) -> str:
    return trials[0].robot + (f" and {len(trials) - 1} more" if len(trials) > 1 else "")


def _spread_report(entries: Sequence[Entry]) -> Report:
    """Return how what one way found spreads over all robots of all scenes."""
    trials = [trial for entry in entries for trial in entry.trials]
    solved = [trial for trial in trials if trial.solved]
    return {
        "way": entries[0].way,
        "solved": len(solved),
        "robots": len(trials),
        "ratio": _spread([trial.ratio for trial in solved]),
        "clearance": _spread([trial.clearance for trial in solved]),
        "turns": _spread([trial.turns for trial in solved]),
        "build_seconds": _spread([entry.build_seconds for entry in entries]),
        "query_seconds": _spread([trial.seconds for trial in trials]),
    }


def _spread(values: Sequence[float | None]) -> Report | None:
    import numpy as np

    known = [value for value in values if value is not None]
    if not known:
        return None
    names = ("least", "lower", "median", "upper", "greatest")
    return dict(zip(names, np.quantile(known, [0, 0.25, 0.5, 0.75, 1], method="linear").tolist(), strict=True))


def _say_spreads(spreads: Sequence[Report], found: Sequence[Comparison]) -> None:
    robots = sum(len(comparison.scene.robots) for comparison in found)
    say(f"{len(found)} random scenes, {robots} robots in all: median (lower to upper quartile)")
    say()
    rows = [
        [
            spread["way"],
            f"{100 * spread['solved'] / spread['robots']:.3g} %" if spread["robots"] else MISSING,
            _quartiles(spread["ratio"], ".3f"),
            _quartiles(spread["clearance"], ".3f"),
            _quartiles(spread["build_seconds"], ".2f", 1e3),
            _quartiles(spread["query_seconds"], ".3f", 1e3),
        ]
        for spread in spreads
    ]
    say_table(["way", "solved", "ratio", "clearance (m)", "build (ms)", "query (ms)"], rows, left=("way",))


def _say_sweep(found: Sequence[Comparison]) -> None:
    from taut.comparison import summary

    rows = []
    for comparison in found:
        for entry in comparison.entries:
            s = summary(entry)
            rows.append(
                [
                    f"{comparison.scene.clearance:g}",
                    s.way,
                    f"{s.solved} of {s.robots}",
                    _shown(s.length, ".4f"),
                    _shown(s.mean_ratio, ".4f"),
                    _shown(s.least_clearance, ".4f"),
                ]
            )
    say_table(["D_s (m)", "way", "solved", "length (m)", "ratio", "least clearance (m)"], rows, left=("way",))
    blocked: dict[str, list[str]] = {}
    for comparison in found:
        for name, why in comparison.blocked.items():
            blocked.setdefault(name, [name, f"{comparison.scene.clearance:g}", why])
    if blocked:
        say()
        say_table(["no room for", "from D_s (m)", "why"], list(blocked.values()), left=("no room for", "why"))


def _quartiles(spread: Report | None, form: str, unit: float = 1.0) -> str:
    if spread is None:
        return MISSING
    middle, lower, upper = (format(unit * spread[name], form) for name in ("median", "lower", "upper"))
    return f"{middle} ({lower} to {upper})"


def _shown(value: float | None, form: str, unit: float = 1.0) -> str:
    if value is None:
        return MISSING
    text = format(unit * value, form)
    return text.removeprefix("-") if float(text) == 0 else text
