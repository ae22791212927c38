"""What leaves the studio: files, pictures, animations, a page to send, and how to do the same without the studio."""

from __future__ import annotations

import base64
import re
import shlex
import tempfile
from collections.abc import Mapping
from dataclasses import replace
from pathlib import Path, PurePath
from typing import Any, Literal, TypeAlias

from taut.certificate import certify
from taut.contact import Contact, contact_of
from taut.errors import OutputError
from taut.formats import json_text, plan_to_dict, scene_to_dict, yaml_text
from taut.motion import Plan
from taut.scene import Scene
from taut.studio.answers import SETTINGS, metrics_of
from taut.studio.sending import page_of
from taut.studio.timelines import timelines_of
from taut.validation import validate

Form: TypeAlias = Literal["plan", "scene-yaml", "scene-json", "png", "svg", "gif", "mp4", "html"]

OPTIONS = ("reach", "sight", "conflicts")
"""What an export may be told: contact to show within metres, whether obstacles break it, conflicts to mark (html)."""

_TYPES = {
    "png": "image/png",
    "svg": "image/svg+xml",
    "gif": "image/gif",
    "mp4": "video/mp4",
}
_DEFAULTS: Mapping[str, object] = {
    "method": None,
    "order": "shortest",
    "roadmap": "visibility",
    "seed": 0,
    "rounds": None,
    "seconds": None,
    "objective": "sum_of_costs",
    "within": 1.0,
}


def export(value: Scene | Plan, form: Form, options: Mapping[str, Any] | None = None) -> dict[str, str]:
    """Return a file to take away: {"name", "type", and "text" or "base64"}.

    Parameters
    ----------
    value : a plan, proved anew before anything is made of it; or a scene, of which there are files and pictures only.
    form : what to make.
    options : see `OPTIONS`.

    Raises
    ------
    OutputError
        The plan does not hold, there is none but one is needed, or there is no ffmpeg for an .mp4.
    """
    told = dict(options or {})
    unknown = sorted(set(told) - set(OPTIONS))
    if unknown:
        raise OutputError(f"unknown options {', '.join(map(repr, unknown))}; known are {', '.join(OPTIONS)}")
    scene = value.scene if isinstance(value, Plan) else value
    stem = stem_of(scene.name)
    if form in ("scene-yaml", "scene-json"):
        return _scene_file(scene, form, stem)
    if isinstance(value, Plan):
        value = proved(value)
    elif form not in ("png", "svg"):
        raise OutputError("a scene does not move: plan it first")
    if form == "plan":
        assert isinstance(value, Plan)
        return {"name": f"{stem}-plan.json", "type": "application/json", "text": json_text.layout(plan_to_dict(value))}
    if form == "html":
        assert isinstance(value, Plan)
        return {"name": f"{stem}.html", "type": "text/html", "text": _page(value, told)}
    return _picture(value, form, stem, _contact(told))


def proved(plan: Plan) -> Plan:
    """Return a plan with the certificate of a proof made now.

    Raises
    ------
    OutputError
        It does not hold.
    SceneError
        Its scene means nothing.
    """
    validate(plan.scene)
    certificate = certify(plan)
    if not certificate.ok:
        raise OutputError(f"the plan does not hold and is not given out: {certificate.problems[0]}")
    return replace(plan, certificate=certificate.as_dict())


def stem_of(name: str) -> str:
    """Return the name of a scene as the beginning of a file's name.

    >>> stem_of("Office 20 / west"), stem_of("")
    ('Office-20-west', 'scene')
    """
    return re.sub(r"[^\w.-]+", "-", name).strip("-.")[:60] or "scene"


def snippets(name: str, settings: Mapping[str, Any]) -> dict[str, str]:
    """Return {"command", "python"}: what plans the scene of a file as the page does, and writes the plan.

    Parameters
    ----------
    name : a file, or a ready scene's name.
    settings : of the page, see `taut.studio.answers.plan_with`; those that are defaults are left out.

    Raises
    ------
    SceneError
        A demand on contact that makes no sense.

    >>> snippets("my map.yaml", {"seed": 3})["command"]
    "taut plan 'my map.yaml' -o my-map-plan.json --seed 3"
    """
    given = {key: settings[key] for key in SETTINGS if settings.get(key) is not None}
    contact = contact_of(given.pop("contact")) if "contact" in given else None
    given = {key: value for key, value in given.items() if value != _DEFAULTS[key]}
    target = f"{stem_of(PurePath(name).stem)}-plan.json"
    return {"command": _command(name, target, given, contact), "python": _python(name, target, given, contact)}


def _command(name: str, target: str, given: Mapping[str, Any], contact: Contact | None) -> str:
    words = ["taut", "plan", f"./{name}" if name.startswith("-") else name, "-o", target]
    for key, value in given.items():
        words += [f"--{key}", str(value)]
    if contact is not None:
        words += ["--contact", _number(contact.reach)]
        words += ["--sight"] if contact.sight else []
        words += ["--connected", str(contact.k)] if contact.k > 1 else []
        words += ["--lambda2", _number(contact.lambda2)] if contact.lambda2 else []
    return shlex.join(words)


def _python(name: str, target: str, given: Mapping[str, Any], contact: Contact | None) -> str:
    asked = [f"{key}={value!r}" for key, value in given.items()]
    if contact is not None:
        more = [_number(contact.reach)]
        more += ["sight=True"] if contact.sight else []
        more += [f"k={contact.k}"] if contact.k > 1 else []
        more += [f"lambda2={_number(contact.lambda2)}"] if contact.lambda2 else []
        asked.append(f"contact=taut.Contact({', '.join(more)})")
    return (
        "import taut\n\n"
        f"scene = taut.load_scene({name!r})\n"
        f"result = taut.plan({', '.join(['scene', *asked])})\n"
        "print(result.certificate.ok, result.plan.sum_of_costs)\n"
        f"taut.save(result.plan, {target!r})\n"
    )


def _number(value: float) -> str:
    return repr(int(value)) if value.is_integer() and abs(value) < 1e15 else repr(value)


def _scene_file(scene: Scene, form: Form, stem: str) -> dict[str, str]:
    data = scene_to_dict(scene)
    if form == "scene-yaml":
        return {"name": f"{stem}.yaml", "type": "application/yaml", "text": yaml_text.scene_yaml(data)}
    return {"name": f"{stem}.json", "type": "application/json", "text": json_text.layout(data)}


def _contact(told: Mapping[str, Any]) -> Contact | None:
    reach = told.get("reach")
    return None if reach is None else Contact(reach, bool(told.get("sight", False)))


def _picture(value: Scene | Plan, form: Form, stem: str, contact: Contact | None) -> dict[str, str]:
    """Draw into a file of a folder that is gone afterwards: pictures are made by what writes them for the commands."""
    from taut.figures import animate, save_figure
    from taut.figures.movies import find_encoder

    name = f"{stem}.{form}"
    if form == "mp4":
        find_encoder(Path(name))
    with tempfile.TemporaryDirectory(prefix="taut-studio-") as folder:
        path = Path(folder) / f"picture.{form}"
        if form in ("gif", "mp4"):
            assert isinstance(value, Plan)
            animate(value, path, contact=contact)
        else:
            save_figure(value, path, contact=contact if isinstance(value, Plan) else None)
        raw = path.read_bytes()
    if form == "svg":
        return {"name": name, "type": _TYPES[form], "text": raw.decode()}
    return {"name": name, "type": _TYPES[form], "base64": base64.b64encode(raw).decode()}


def _page(plan: Plan, told: Mapping[str, Any]) -> str:
    contact = _contact(told)
    data = plan_to_dict(plan)
    answer = {
        "scene": data.pop("scene"),
        "plan": data,
        "metrics": metrics_of(plan),
        "certificate": data["certificate"],
        "conflicts": list(told.get("conflicts") or ()),
    }
    reach, sight = (None, False) if contact is None else (contact.reach, contact.sight)
    title = plan.scene.name or f"{len(plan.scene.robots)} robots"
    return page_of(title, {"title": title, "answer": answer, "timelines": timelines_of(plan, reach, sight)})
