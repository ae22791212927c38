"""The kinds of work: what a page asks, done by the module that knows how; runs in the workers."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import replace
from types import MappingProxyType
from typing import TYPE_CHECKING, Any, TypeAlias

from taut.errors import SceneError, TautError
from taut.studio import messages
from taut.studio.messages import Data

if TYPE_CHECKING:
    from taut.motion import Plan
    from taut.scene import Scene

Tell: TypeAlias = Callable[[Data], None]
Job: TypeAlias = Callable[[Any, Any, Tell], Data]


def outcome(ask: messages.Asked, tell: Tell) -> Data:
    """Do what is asked and return {"ok": …}, or {"wrong": …} where that cannot be done.

    Parameters
    ----------
    ask : what a page asks.
    tell : takes how far it has come, as plain data; what it raises ends the work.
    """
    from taut.formats import scene_from_dict
    from taut.studio import reasons

    scene = None
    try:
        if isinstance(ask, messages.AboutScene):
            scene = scene_from_dict(ask.scene)
        return {"ok": JOBS[ask.ask](ask, scene, tell)}
    except TautError as error:
        return {"wrong": reasons.wrong(error, scene)}


def opened(value: Scene | Plan) -> Data:
    """Return what a file held as the page takes it: the scene and, of a plan, the plan, certified anew."""
    from taut.formats import plan_to_dict, scene_to_dict
    from taut.motion import Plan

    if not isinstance(value, Plan):
        return {"scene": scene_to_dict(value)}
    from taut.certificate import certify
    from taut.validation import validate

    try:
        validate(value.scene)
    except SceneError:  # nothing can be proved in a scene without room for its robots; the page shows what is wrong
        return {"scene": scene_to_dict(value.scene)}
    from taut.studio import answers

    proved = replace(value, certificate=certify(value).as_dict())
    plan = plan_to_dict(proved)
    scene = plan.pop("scene")
    return {"scene": scene, "plan": plan, "certificate": plan["certificate"], "metrics": answers.metrics_of(proved)}


def warm_up() -> None:
    """Load, and where need be compile, what nearly every job uses."""
    from taut.formats import scene_to_dict
    from taut.scene import Polygon, Robot, Scene

    wall = Polygon([(4, 3), (6, 3), (6, 7), (4, 7)], "O1")
    robots = [Robot("R1", (1, 5), (9, 5), radius=0.3), Robot("R2", (9, 5.5), (1, 4.5))]
    scene = scene_to_dict(Scene((0, 0, 10, 10), [wall], robots, gap=0.05))
    for ask in (
        messages.Check(id=0, ask="check", scene=scene),
        messages.Plan(id=0, ask="plan", scene=scene, settings=messages.Settings(rounds=1)),
    ):
        outcome(ask, lambda said: None)


def _check(ask: messages.Check, scene: None, tell: Tell) -> Data:
    from taut.studio import checking

    return checking.checked(ask.scene)


def _plan(ask: messages.Plan, scene: Scene, tell: Tell) -> Data:
    from taut.studio import answers

    result = answers.plan_with(scene, ask.settings.given(), lambda progress: tell(answers.progress_data(progress)))
    return answers.plan_answer(result)


def _steps(ask: messages.Steps, scene: Scene, tell: Tell) -> Data:
    from taut.studio import steps

    return steps.steps_of(scene, ask.of, ask.robot, ask.settings.given())


def _timelines(ask: messages.Timelines, scene: Scene, tell: Tell) -> Data:
    from taut.studio import answers, timelines

    return timelines.timelines_of(answers.plan_of(scene, ask.plan), ask.reach, ask.sight)


def _random(ask: messages.Random, scene: None, tell: Tell) -> Data:
    from taut.formats import scene_to_dict
    from taut.generate import random_scene, random_warehouse

    if ask.kind == "warehouse":
        return {"scene": scene_to_dict(random_warehouse(ask.robots, ask.seed))}
    return {"scene": scene_to_dict(random_scene(ask.robots, ask.obstacles, ask.seed, size=ask.size))}


def _ready(ask: messages.Ready, scene: None, tell: Tell) -> Data:
    from taut.formats import load_scene, scene_names, scene_to_dict

    if ask.name not in scene_names():  # nothing that could be the name of a file is looked up
        raise SceneError(f"there is no ready scene {ask.name!r}; there are {', '.join(scene_names())}")
    return {"scene": scene_to_dict(load_scene(ask.name))}


def _open(ask: messages.Open, scene: None, tell: Tell) -> Data:
    from taut.formats import value_of_text

    return opened(value_of_text(ask.text, ask.name or "the file"))


def _text(ask: messages.Text, scene: Scene, tell: Tell) -> Data:
    from taut.formats import json_text, scene_to_dict, yaml_text

    return {"text": (yaml_text.scene_yaml if ask.format == "yaml" else json_text.layout)(scene_to_dict(scene))}


def _export(ask: messages.Export, scene: Scene, tell: Tell) -> Data:
    from taut.studio import answers, exports

    value = scene if ask.plan is None else answers.plan_of(scene, ask.plan)
    return exports.export(value, ask.form, ask.options.model_dump())


def _snippet(ask: messages.Snippet, scene: None, tell: Tell) -> Data:
    from taut.studio import exports

    return exports.snippets(ask.name, ask.settings.given())


JOBS: Mapping[str, Job] = MappingProxyType(
    {
        "check": _check,
        "plan": _plan,
        "steps": _steps,
        "timelines": _timelines,
        "random": _random,
        "ready": _ready,
        "open": _open,
        "text": _text,
        "export": _export,
        "snippet": _snippet,
    }
)
