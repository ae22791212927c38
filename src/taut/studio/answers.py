"""Planning for the page: its settings in, a Result as plain data out."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from typing import Any

from taut.contact import contact_of
from taut.errors import SceneError
from taut.formats import plan_from_dict, plan_to_dict, scene_to_dict
from taut.motion import Plan
from taut.scene import Scene
from taut.team import Result, plan
from taut.team.conflicts import Conflict
from taut.team.methods import Progress
from taut.team.stages import SequenceStage
from taut.team.telling import so_far, tell_conflict

SETTINGS = ("method", "order", "roadmap", "seed", "rounds", "seconds", "objective", "within", "contact")
"""What the page may set; each is a parameter of `taut.plan`, and what is missing or None has its default there."""


def plan_with(scene: Scene, settings: Mapping[str, Any], progress: Callable[[Progress], None] | None = None) -> Result:
    """Plan the team of a scene by the page's settings.

    Parameters
    ----------
    scene : what to plan.
    settings : see `SETTINGS`; ``contact`` is a claim, {"range": metres, "sight", "k", "lambda2"}.
    progress : called now and then; what it raises ends the planning.

    Raises
    ------
    SceneError
        An unknown setting, one that makes no sense, or a scene that cannot be planned as it is.
    NoPath, NoPlanExists, NoPlanFound
        As `taut.plan`.
    """
    unknown = sorted(set(settings) - set(SETTINGS))
    if unknown:
        raise SceneError(f"unknown settings {', '.join(map(repr, unknown))}; known are {', '.join(SETTINGS)}")
    given = {name: value for name, value in settings.items() if value is not None}
    if "contact" in given:
        given["contact"] = contact_of(given["contact"])
    return plan(scene, progress=progress, **given)


def plan_answer(result: Result) -> dict[str, Any]:
    """Return a result as plain data for the page, finite numbers only.

    The plan is what a plan file holds, but without its scene, which the page has.
    """
    done = result.plan
    names = [robot.name for robot in done.scene.robots]
    return {
        "plan": {key: value for key, value in plan_to_dict(done).items() if key != "scene"},
        "certificate": result.certificate.as_dict(),
        "metrics": metrics_of(done),
        "conflicts": [
            conflict_data(conflict)
            for stage in result.stages
            if isinstance(stage, SequenceStage)
            for name in stage.order
            for conflict in stage.conflicts[name]
        ],
        "detours": dict(zip(names, result.detours, strict=True)),
        "shortest": {name: finite(length) for name, length in zip(names, result.shortest.tolist(), strict=True)},
        "notes": list(result.notes),
        "phases": dict(result.phases),
        "history": [[at, finite(cost)] for at, cost in result.history],
    }


def metrics_of(done: Plan) -> dict[str, Any]:
    """Return the metrics of a plan file, and ``above``: by which share the plan is above its lower bound, if known."""
    metrics: dict[str, Any] = {"sum_of_costs": done.sum_of_costs, "makespan": done.makespan, "length": done.length}
    bound = done.lower_bound
    if bound is None:
        return {**metrics, "lower_bound": None, "above": None}
    value = bound.get("value")
    cost = done.makespan if bound.get("of") == "makespan" else done.sum_of_costs
    known = isinstance(value, int | float) and math.isfinite(value) and value > 0
    above = finite(cost / value - 1) if known and isinstance(value, int | float) else None
    return {**metrics, "lower_bound": dict(bound), "above": above}


def conflict_data(conflict: Conflict) -> dict[str, Any]:
    """Return a conflict as plain data, with the sentence that tells it."""
    return {
        "robot": conflict.robot,
        "other": conflict.other,
        "kind": conflict.kind,
        "time": finite(conflict.time),
        "place": list(conflict.place),
        "resolution": conflict.resolution,
        "delay": finite(conflict.delay),
        "sentence": tell_conflict(conflict),
    }


def progress_data(progress: Progress) -> dict[str, Any]:
    """Return how far planning has come as plain data: in words, and the best cost and the bound where known."""
    return {"text": so_far(progress), "cost": finite(progress.cost), "bound": finite(progress.bound) or None}


def plan_of(scene: Scene, data: Mapping[str, Any]) -> Plan:
    """Return the plan that the page holds without its scene; nothing of it is believed.

    Raises
    ------
    PlanError
        It is no plan, or not of this scene.
    """
    return plan_from_dict({**data, "scene": scene_to_dict(scene)})


def finite(number: float) -> float | None:
    """Return a number as JSON can hold it: None for what is not finite."""
    return float(number) if math.isfinite(number) else None
