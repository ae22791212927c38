"""The page docs/performance-teams.md: tables by family and size beside each peer's, and plots."""

from __future__ import annotations

import math
import statistics
from collections import defaultdict
from collections.abc import Iterable, Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING

from matplotlib.axes import Axes
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure

from instances import GRIDS, ROADMAPS, STGCS, Record
from large import LARGE
from measure import Table, in_words

if TYPE_CHECKING:
    from contest import Outcome

HEAD = """# Teams against the peers

`./dev bench teams --data FOLDER` plans these instances, certifies every plan and writes this page and one CSV file per
family beside it; edit `benchmarks/`, not the page. The peers' figures were recorded on the same instances on a machine
of the same kind; ST-GCS' are its authors'. All robots are discs that may touch, stay at their goals and cost their last
arrival. Our discs keep their distance to 2⁻⁴⁰ of the map's size, proved by `certify`.
"""
COLOURS = ("#0072b2", "#d55e00", "#009e73", "#cc79a7", "#e69f00", "#56b4e9", "#000000")
"""Okabe and Ito's, safe for the colour-blind; the first is ours."""


def write(page: Path, known: Mapping[str, Sequence[Outcome]], peers: Sequence[Record], where: str, load: float) -> None:
    """Write the page and its pictures, in the folder figures beside it, from the outcomes by family."""
    figures = page.parent / "figures"
    figures.mkdir(parents=True, exist_ok=True)
    _draw_roadmaps(figures / "performance-teams-roadmaps.png", known, peers)
    _draw_grids(figures / "performance-teams-grids.png", known, peers)
    busy = f" Other work was going on: load average {load:.1f} at the end." if load > 2.5 else ""
    parts = [HEAD, f"Measured on: {where}{busy}", *map(str, tables(known, peers))]
    page.write_text("\n\n".join(part.strip() for part in parts) + "\n", encoding="utf-8")


def tables(known: Mapping[str, Sequence[Outcome]], peers: Sequence[Record]) -> list[Table]:
    """Return a table for each family that was planned."""
    out = []
    for family, rows in known.items():
        beside = [record for record in peers if record.family == family]
        if family in ROADMAPS:
            out.append(_roadmap_table(family, rows, beside))
        elif family in GRIDS or family in STGCS:
            out.append(_anywhere_table(family, rows, beside))
    large = [row for one in LARGE for row in known.get(one.family, ())]
    return [*out, _large_table(large)] if large else out


def _roadmap_table(family: str, rows: Sequence[Outcome], peers: Sequence[Record]) -> Table:
    ours = _by_robots(rows)
    lines = []
    for n, team in ours.items():
        proven = [row for row in team if row.proven]
        rivals = {r.number: r for r in peers if r.robots == n and r.planner == "CCBS"}
        both = [(row, rivals[row.number]) for row in proven if row.number in rivals and rivals[row.number].solved]
        lines.append(
            (
                str(n),
                f"{len(proven)} of {len(team)}",
                f"{sum(r.solved for r in rivals.values())} of {len(rivals)}",
                _median(row.seconds for row in proven),
                _median(r.seconds for r in rivals.values() if r.solved),
                _extremes(row.cost - r.cost for row, r in both),
                _percent(row.cost / row.bound - 1 for row in team if row.solved and not row.proven),
            )
        )
    return Table(
        family,
        (
            "robots",
            "optimal, proven",
            "CCBS solved",
            "seconds",
            "CCBS seconds",
            "cost − CCBS' (s)",
            "gap of the others",
        ),
        tuple(lines),
        '`taut.plan(scene, method="optimal", roadmap=lanes, seconds=30)`; seconds are medians over those solved.',
        (
            "cost − CCBS': the least and the greatest difference over the instances that both solved. CCBS' branching "
            "is not sound, so its costs need not be optimal, and its discs overlap by up to 1.7e-5 m.",
            "gap of the others: mean of cost over proven bound where 30 s were not enough, over the plans found.",
            *_faults(rows),
        ),
        "![Solved within 30 s](figures/performance-teams-roadmaps.png)" if family == ROADMAPS[0] else "",
    )


def _anywhere_table(family: str, rows: Sequence[Outcome], peers: Sequence[Record]) -> Table:
    names = list(dict.fromkeys(record.planner for record in peers))
    lines = []
    for n, team in _by_robots(rows).items():
        solved = {row.number: row for row in team if row.solved}
        cells = [
            str(n),
            f"{len(solved)} of {len(team)}",
            _median(row.first_seconds - row.roadmap_seconds for row in solved.values()),
            _mean(row.first_cost for row in solved.values()),
            _median(row.seconds for row in team),
            _mean(row.cost for row in solved.values()),
            _percent(row.cost / row.bound - 1 for row in solved.values() if row.bound > 0),
        ]
        for name in names:
            theirs = [r for r in peers if r.planner == name and r.robots == n]
            both = [r for r in theirs if r.solved and r.number in solved]
            ratio = _mean((solved[r.number].cost / r.cost for r in both), 3)
            good = sum(r.solved for r in theirs)
            cells.append(
                f"{good} of {len(theirs)}; {_median(r.seconds for r in theirs if r.solved)}; {ratio}" if theirs else "–"
            )
        lines.append(tuple(cells))
    model = next((row.model for row in rows if row.model), "roadmap")
    norms = (
        "Their speed limit is per axis, up to √2 times ours (Euclidean) on a diagonal; their bounds confine centres, "
        "so our workspace is a radius wider; moving discs are left out, which makes simple2d easier for us."
    )
    return Table(
        family,
        ("robots", "solved", "first plan", "its cost", "seconds", "cost", "above bound", *names),
        tuple(lines),
        "Default method with `seconds=` given. Peers: solved; their seconds; our cost over theirs, mean over instances "
        "that both solved."
        if peers
        else "",
        (
            "first plan: median seconds until the first plan, once roadmaps are there; cost: mean sum of costs after "
            f"all seconds; above bound: mean, no plan of the model {model} costs less than the bound.",
            *([norms] if family in STGCS else []),
            *_faults(rows),
        ),
        "![Costs beside the peers'](figures/performance-teams-grids.png)" if family == GRIDS[0] else "",
    )


def _large_table(rows: Sequence[Outcome]) -> Table:
    def line(row: Outcome) -> tuple[str, ...]:
        aim = next(one.aim for one in LARGE if one.family == row.family)
        return (
            f"{row.family} {row.number}",
            str(row.robots),
            _seconds(row.roadmap_seconds),
            _seconds(row.first_seconds),
            in_words(row.seconds),
            _percent([row.first_cost / row.bound - 1]),
            _percent([row.cost / row.bound - 1]),
            f"{row.memory / 2**30:.2f} GiB",
            aim,
        )

    calls = "; ".join(f"{one.family} N is `{one.command}`" for one in LARGE)
    return Table(
        "Large teams",
        ("scene", "robots", "roadmaps", "first plan", "in all", "first above bound", "above bound", "memory", "aim"),
        tuple(line(row) for row in rows),
        f"Scenes: {calls}.",
        (
            "Seconds from the scene in memory, until roadmaps and shortest routes are there, the first plan is, and "
            "the plan is certified. Bound: sum of the shortest travel times of the robots alone (model: plane).",
            "memory: most bytes that the process had held by then, with all scenes before.",
            *_faults(rows),
        ),
    )


def _faults(rows: Sequence[Outcome]) -> tuple[str, ...]:
    """What a reader must know of plans that are missing or do not hold."""
    refused = [row for row in rows if row.solved and not row.certified]
    missing = [row for row in rows if not row.solved]
    out = [f"{len(rows) - len(missing)} plans, {len(rows) - len(missing) - len(refused)} of them certified."]
    if missing:
        out.append("No plan: " + ", ".join(f"{row.number} with {row.robots} robots" for row in missing) + ".")
    return tuple(out)


def _by_robots(rows: Sequence[Outcome]) -> dict[int, list[Outcome]]:
    out: dict[int, list[Outcome]] = defaultdict(list)
    for row in rows:
        out[row.robots].append(row)
    return dict(sorted(out.items()))


def _seconds(value: float) -> str:
    return "–" if math.isnan(value) else in_words(value)


def _median(values: Iterable[float]) -> str:
    known = list(values)
    return in_words(statistics.median(known)) if known else "–"


def _mean(values: Iterable[float], digits: int = 1) -> str:
    known = list(values)
    return f"{statistics.fmean(known):,.{digits}f}" if known else "–"


def _percent(values: Iterable[float]) -> str:
    known = [value for value in values if not math.isnan(value)]
    return f"{100 * statistics.fmean(known) + 0.0:.2f} %" if known else "–"


def _extremes(values: Iterable[float]) -> str:
    known = list(values)
    return f"{min(known):+.1e} … {max(known):+.1e}" if known else "–"


# --- Pictures ---------------------------------------------------------------------------------------------------------


def _draw_roadmaps(path: Path, known: Mapping[str, Sequence[Outcome]], peers: Sequence[Record]) -> None:
    """Share of instances solved within 30 s against the number of robots, ours and CCBS'."""
    families = [family for family in ROADMAPS if family in known]
    if not families:
        return
    figure, axes = _panels(len(families))
    for ax, family in zip(axes, families, strict=True):
        ours = {n: sum(row.proven for row in team) for n, team in _by_robots(known[family]).items()}
        theirs: dict[int, int] = defaultdict(int)
        for record in peers:
            if record.family == family and record.planner == "CCBS":
                theirs[record.robots] += record.solved
        ax.plot(list(ours), list(ours.values()), "o-", color=COLOURS[0], label="taut (proven optimal)")
        ax.plot(sorted(theirs), [theirs[n] for n in sorted(theirs)], "s--", color=COLOURS[1], label="CCBS")
        ax.set(title=family, xlabel="robots", ylim=(-0.3, 10.5))
    axes[0].set_ylabel("instances solved within 30 s, of 10")
    _save(figure, axes, path)


def _draw_grids(path: Path, known: Mapping[str, Sequence[Outcome]], peers: Sequence[Record]) -> None:
    """Mean cost over the sum of straight costs of ours and each peer on the instances that both solved."""
    families = [family for family in GRIDS if family in known]
    if not families:
        return
    figure, axes = _panels(len(families))
    names = list(dict.fromkeys(r.planner for r in peers if r.family in families and not r.planner.startswith("CCBS")))
    for ax, family in zip(axes, families, strict=True):
        ours = {(row.robots, row.number): row for row in known[family] if row.solved}
        for k, name in enumerate(names):
            colour, marker = COLOURS[1:][k % 6], "o" if k < 6 else "s"
            ratios: dict[int, list[float]] = defaultdict(list)
            for r in peers:
                if r.family == family and r.planner == name and r.solved and (r.robots, r.number) in ours:
                    ratios[r.robots].append(r.cost / ours[r.robots, r.number].cost)
            sizes = sorted(ratios)
            if sizes:
                ax.plot(
                    sizes, [statistics.fmean(ratios[n]) for n in sizes], f"{marker}-", color=colour, ms=4, label=name
                )
        ax.axhline(1.0, color=COLOURS[0], lw=2, label="taut")
        ax.set(title=family, xlabel="robots")
    axes[0].set_ylabel("mean cost over ours, same instances")
    _save(figure, axes, path)


def _panels(count: int) -> tuple[Figure, list[Axes]]:
    figure = Figure(figsize=(1 + 3.2 * count, 4), layout="constrained")
    FigureCanvasAgg(figure)
    axes = list(figure.subplots(1, count, squeeze=False)[0])
    for ax in axes:
        ax.spines[["top", "right"]].set_visible(False)
        ax.grid(alpha=0.3)
    return figure, axes


def _save(figure: Figure, axes: Sequence[Axes], path: Path) -> None:
    """Write a figure with one legend for all its panels."""
    once = {label: line for ax in axes for line, label in zip(*ax.get_legend_handles_labels(), strict=True)}
    figure.legend(once.values(), once.keys(), loc="outside lower center", ncols=5, fontsize=8, frameon=False)
    figure.savefig(path, dpi=150, metadata={"Software": None})
