"""From a Scene to a certified plan of a team: seconds per phase, rounds, and how far from the lower bound."""

from __future__ import annotations

import statistics
import time
from collections.abc import Callable
from dataclasses import dataclass
from functools import partial
from pathlib import Path

from measure import Report, Table, in_words, picture, repeated
from taut.errors import TautError
from taut.formats import load_scene
from taut.formats.files import scene_names
from taut.generate import random_scene
from taut.motion import Plan
from taut.scene import Scene
from taut.team import Result, plan
from taut.team.world import places_on

PHASES = ("roadmaps", "planning", "certificate")

TITLES = ("Plans of teams",)
COLOURS = {"roadmaps": "#56b4e9", "planning": "#e69f00", "certificate": "#009e73"}
"""Okabe and Ito's, safe for the colour-blind."""


@dataclass(frozen=True)
class Case:
    """A scene to plan, and the time its plan should take, seconds."""

    name: str
    make: Callable[[], Scene]
    target: float | None = None


@dataclass(frozen=True)
class Run:
    """One run: the plan, seconds in all and in each phase."""

    plan: Plan
    certified: bool
    total: float
    phases: dict[str, float]


@dataclass(frozen=True)
class Outcome:
    """What planning a case gave: its runs, or why there is none."""

    case: Case
    scene: Scene
    runs: tuple[Run, ...]
    reason: str = ""

    @property
    def total(self) -> float:
        """Median seconds from the Scene to the certified plan."""
        return statistics.median(run.total for run in self.runs)

    def phase(self, name: str) -> float:
        """Median seconds of one phase."""
        return statistics.median(run.phases[name] for run in self.runs)


def suite(quick: bool) -> Report:
    """Measure every case; return its table and how to draw it."""
    outcomes = measured(quick)
    return Report((table(outcomes),), partial(draw, outcomes=outcomes))


def cases(quick: bool) -> tuple[Case, ...]:
    """Return all ready scenes and two large random ones; quick: the thesis' scenes alone."""
    ready = [Case(name, partial(load_scene, name)) for name in scene_names()]
    if quick:
        return tuple(case for case in ready if case.name.startswith("thesis"))
    hundred = partial(random_scene, robots=100, obstacles=300, seed=1)
    thousand = partial(random_scene, robots=1000, obstacles=400, size=200, seed=1)
    return (*ready, Case("random 100, 300", hundred, 3.0), Case("random 1000, 400", thousand, 20.0))


def measured(quick: bool) -> tuple[Outcome, ...]:
    """Plan every case, warm; several times where that is quick."""
    plan(load_scene("thesis-2"))
    return tuple(_outcome(case) for case in cases(quick))


def table(outcomes: tuple[Outcome, ...]) -> Table:
    """Return one row for each case."""
    same = all(run.plan.trajectories == o.runs[0].plan.trajectories for o in outcomes for run in o.runs)
    return Table(
        TITLES[0],
        ("scene", "robots", "obstacles", *PHASES, "together", "target", "rounds", "above bound", "certified"),
        tuple(_row(outcome) for outcome in outcomes),
        "`taut.plan` from a Scene in memory to the certified plan; warm, medians of up to 5 runs.",
        (
            "roadmaps: free spaces, roadmaps, shortest routes. planning: all rounds, with the tangents round other "
            "robots' starts and goals. together: also checks of the scene and the reasons for detours.",
            "random 100, 300 is `taut random --robots 100 --obstacles 300 --seed 1`; random 1000, 400 is `taut random "
            "--robots 1000 --obstacles 400 --size 200 --seed 1`.",
            "above bound: sum of costs over the sum of shortest travel times of the robots alone (model: plane), which "
            "no plan can beat.",
            f"Repeated runs gave {'the same plan, bit for bit' if same else 'DIFFERENT plans: a defect'}.",
        ),
        f"![Where planning spends its time](figures/{picture('plans')})",
    )


def draw(path: Path, outcomes: tuple[Outcome, ...]) -> None:
    """Draw the shares of planning's phases by scene."""
    from matplotlib.backends.backend_agg import FigureCanvasAgg
    from matplotlib.figure import Figure

    solved = [o for o in outcomes if o.runs][::-1]
    figure = Figure(figsize=(8, 1.5 + 0.35 * len(solved)), layout="constrained")
    FigureCanvasAgg(figure)
    ax = figure.subplots()
    names = [o.case.name for o in solved]
    done = [0.0] * len(solved)
    for phase, colour in COLOURS.items():
        shares = [100 * o.phase(phase) / o.total for o in solved]
        ax.barh(names, shares, left=done, color=colour, label=phase)
        done = [a + b for a, b in zip(done, shares, strict=True)]
    ax.barh(names, [max(0.0, 100 - d) for d in done], left=done, color="#bbbbbb", label="checks and reasons")
    for k, outcome in enumerate(solved):
        ax.text(102, k, in_words(outcome.total), va="center", fontsize=9)
    ax.set(xlim=(0, 100), xlabel="share of the time to a certified plan, %", title="Planning a team")
    ax.spines[["top", "right"]].set_visible(False)
    figure.legend(*ax.get_legend_handles_labels(), loc="outside lower center", ncols=4, fontsize=8, frameon=False)
    figure.savefig(path, dpi=150, metadata={"Software": None})


def _outcome(case: Case) -> Outcome:
    scene = case.make()
    try:
        runs = repeated(lambda: plan(scene), _run, most=5, budget=8.0)
    except TautError as error:
        return Outcome(case, scene, (), str(error))
    return Outcome(case, scene, tuple(runs))


def _run(work: Callable[[], object]) -> Run:
    places_on.cache_clear()  # each run is a first plan on its map
    began = time.perf_counter()
    result = work()
    assert isinstance(result, Result)
    total = time.perf_counter() - began
    return Run(result.plan, result.certificate.ok, total, {name: result.phases[name] for name in PHASES})


def _row(outcome: Outcome) -> tuple[str, ...]:
    case, scene = outcome.case, outcome.scene
    target = "–" if case.target is None else in_words(case.target)
    head = (case.name, f"{len(scene.robots):,}", f"{len(scene.obstacles):,}")
    if not outcome.runs:
        return (*head, *("–" for _ in PHASES), "–", target, "–", "–", outcome.reason)
    plan = outcome.runs[0].plan
    return (
        *head,
        *(in_words(outcome.phase(name)) for name in PHASES),
        in_words(outcome.total),
        target,
        str(plan.planner["rounds"]),
        _above(plan),
        "yes" if all(run.certified for run in outcome.runs) else "NO",
    )


def _above(plan: Plan) -> str:
    bound = float(str(plan.lower_bound["value"])) if plan.lower_bound else 0.0
    # adding 0 turns the −0 of a sum that rounding made smaller than its bound into 0
    return f"{round(100 * (plan.sum_of_costs / bound - 1), 2) + 0.0:.2f} %" if bound > 0 else "–"
