"""The page docs/performance-contact.md: tables by team size and reach, costs beside plan and witness, and a plot."""

from __future__ import annotations

import math
import statistics
from collections.abc import Callable, Iterable, Sequence
from pathlib import Path
from typing import TYPE_CHECKING

from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure

from contact_instances import REACHES, TEAMS
from contest_page import COLOURS
from measure import LEFT_OUT, Table, in_words

if TYPE_CHECKING:
    from contact import Outcome

HEAD = """# Teams in contact

`./dev bench contact` plans the 200 teams of `benchmarks/contact/` so that they stay in contact, certifies every plan
and writes this page and a CSV file beside it; edit `benchmarks/`, not the page. All of them can be planned: each comes
with a witness, the motion it was made from, in which a team drifts through a hall with obstacles, through doors or
round a corner without ever losing contact (`taut.random_team_in_contact`). Robots have diameters of 0.5 m (0.4 to 0.6 m
and speeds of 0.8 to 1.2 m/s where mixed); the reach is told in units of 0.5 m.
"""
PICTURE = "performance-contact.png"
_COSTS = ("over no contact", "where lost", "most", "over the witness", "most", "above the bound")


def write(page: Path, rows: Sequence[Outcome], where: str, load: float) -> None:
    """Write the page and its picture, in the folder figures beside it."""
    figures = page.parent / "figures"
    figures.mkdir(parents=True, exist_ok=True)
    _draw(figures / PICTURE, rows)
    busy = f" Other work was going on: load average {load:.1f} at the end." if load > 1.5 else ""
    parts = [HEAD, f"Measured on: {where}{busy}", *map(str, tables(rows))]
    page.write_text("\n\n".join(part.strip() for part in parts) + "\n", encoding="utf-8")


def tables(rows: Sequence[Outcome]) -> list[Table]:
    """Return all tables of the page."""
    return [_success(rows), _costs(rows), _kinds(rows)]


def _success(rows: Sequence[Outcome]) -> Table:
    lines = []
    for robots, team in _by(rows, lambda row: row.robots, TEAMS):
        by_reach = dict(_by(team, lambda row: row.reach, REACHES))
        solved = [row for row in team if row.solved]
        lines.append(
            (
                str(robots),
                *(_share(by_reach.get(reach, ())) for reach in REACHES),
                f"{_share(team)} ({100 * len(solved) / len(team):.0f} %)",
                in_words(statistics.median(row.seconds for row in team)),
                in_words(max(row.seconds for row in team)),
                in_words(statistics.median(row.free_seconds for row in team)),
                f"{sum(row.free_kept for row in team)} of {sum(row.free_cost > 0 for row in team)}",
            )
        )
    solved = [row for row in rows if row.solved]
    proven = sum(row.certified for row in solved)
    notes = [
        f"{len(solved)} plans in contact, {proven} of them proved by `certify` to hold and to keep it at every instant."
    ]
    missing = [row for row in rows if not row.solved]
    if missing:
        telling = sum(row.names == "robots, place, time" for row in missing)
        notes.append(f"{len(missing)} without a plan; the error names robots, place and time in {telling} of them:")
        notes += [f"{row.name}: {row.reason}" for row in missing]
    return Table(
        "Solved",
        ("robots", *(f"reach {reach}" for reach in REACHES), "all", "seconds", "longest", "without", "kept anyway"),
        tuple(lines),
        '`taut.plan(scene, method="prioritized", contact=…, seconds=50)`: the default method, but for the limit of '
        "time; it is ended after 60 s in any case. Seconds, from the scene to the certified plan or the error: the "
        "median and the longest; without: the median of planning the same without contact; kept anyway: how many of "
        "the plans without happen to keep it.",
        tuple(notes),
        f"![Solved, and extra cost, by team size](figures/{PICTURE})",
    )


def _costs(rows: Sequence[Outcome]) -> Table:
    lines = [(str(robots), *_cost_cells(team)) for robots, team in _by(rows, lambda row: row.robots, TEAMS)]
    lines += [(f"reach {reach}", *_cost_cells(team)) for reach, team in _by(rows, lambda row: row.reach, REACHES)]
    lines.append(("all", *_cost_cells(rows)))
    return Table(
        "What contact costs",
        ("robots", "plans", *_COSTS),
        tuple(lines),
        "Sum of costs of the plan in contact over that of the plan without; the same on those instances only whose "
        "plan without loses contact; over that of the witness; and over the sum of the shortest travel times of the "
        "robots alone: medians, and the greatest.",
        ("The witness shows that there is a plan, not a short one: robots drift, hesitate and queue in it.",),
    )


def _cost_cells(rows: Sequence[Outcome]) -> tuple[str, ...]:
    free = _ratios(row.cost / row.free_cost for row in rows if row.free_cost)
    bought = _ratios(row.cost / row.free_cost for row in rows if row.free_cost and not row.free_kept)
    shown = _ratios(row.cost / row.witness_cost for row in rows if row.witness_cost)
    bound = _ratios(row.cost / row.bound for row in rows if row.bound)
    return (
        str(sum(row.solved for row in rows)),
        _extra(free, statistics.median),
        _extra(bought, statistics.median),
        _extra(free, max),
        _extra(shown, statistics.median),
        _extra(shown, max),
        _extra(bound, statistics.median),
    )


def _kinds(rows: Sequence[Outcome]) -> Table:
    kinds = [(ground, formation) for ground in ("hall", "rooms", "corner") for formation in ("swarm", "chain")]
    groups = [(f"{a}, {b}", [row for row in rows if (row.ground, row.formation) == (a, b)]) for a, b in kinds]
    groups.append(("in sight", [row for row in rows if row.sight]))
    groups.append(("mixed robots", [row for row in rows if row.mixed]))
    lines = tuple(
        (
            name,
            _share(some),
            in_words(statistics.median(row.seconds for row in some)),
            *_cost_cells(some)[1:],
        )
        for name, some in groups
        if some
    )
    return Table(
        "By kind",
        ("kind", "solved", "seconds", *_COSTS),
        lines,
    )


def _by(
    rows: Iterable[Outcome], key: Callable[[Outcome], int], values: Sequence[int]
) -> list[tuple[int, list[Outcome]]]:
    """Return the rows of each value that has any."""
    every = list(rows)
    groups = [(value, [row for row in every if key(row) == value]) for value in values]
    return [(value, some) for value, some in groups if some]


def _share(rows: Sequence[Outcome]) -> str:
    return f"{sum(row.solved for row in rows)} of {len(rows)}" if rows else LEFT_OUT


def _ratios(values: Iterable[float]) -> list[float]:
    return [value for value in values if not math.isnan(value)]


def _extra(ratios: Sequence[float], of: Callable[[Sequence[float]], float]) -> str:
    return f"{100 * (of(ratios) - 1):+.1f} %" if ratios else LEFT_OUT


def _draw(path: Path, rows: Sequence[Outcome]) -> None:
    """Draw the share solved, and the median extra cost over no contact, against team size, a line for each reach."""
    figure = Figure(figsize=(8, 3.8), layout="constrained")
    FigureCanvasAgg(figure)
    left, right = figure.subplots(1, 2)
    for colour, reach in zip(COLOURS, REACHES, strict=False):
        teams = _by([row for row in rows if row.reach == reach], lambda row: row.robots, TEAMS)
        left.plot(
            [robots for robots, _ in teams],
            [100 * sum(row.solved for row in team) / len(team) for _, team in teams],
            "o-",
            color=colour,
            label=f"reach {reach} diameters",
        )
        extra = [(robots, _ratios(row.cost / row.free_cost for row in team if row.free_cost)) for robots, team in teams]
        right.plot(
            [robots for robots, ratios in extra if ratios],
            [100 * (statistics.median(ratios) - 1) for _, ratios in extra if ratios],
            "o-",
            color=colour,
        )
    left.set(xlabel="robots", ylabel="solved within 60 s (%)", ylim=(-3, 103))
    right.set(xlabel="robots", ylabel="extra cost of contact (median, %)")
    for ax in (left, right):
        ax.spines[["top", "right"]].set_visible(False)
        ax.grid(alpha=0.3)
    figure.legend(loc="outside lower center", ncols=4, fontsize=8, frameon=False)
    figure.savefig(path, dpi=150, metadata={"Software": None})
