"""What the studio gives out is what the commands write, proved anew; and its snippets do what the studio did."""

from __future__ import annotations

import base64
import json
import os
import re
import shlex
import subprocess
import sys
from dataclasses import replace
from html.parser import HTMLParser
from pathlib import Path
from typing import TYPE_CHECKING, Any

import pytest

import taut
from taut.cli import main
from taut.errors import OutputError, SceneError
from taut.formats import load_plan, load_scene
from taut.motion import Plan, Trajectory
from taut.studio.answers import plan_answer, plan_of, plan_with
from taut.studio.exports import export, proved, snippets, stem_of
from taut.studio.sending import STYLES, modules_of, page_of
from taut.team import Result

if TYPE_CHECKING:
    from playwright.sync_api import Browser

pytest_plugins = ("studio_page",)


@pytest.fixture(scope="module")
def result() -> Result:
    return plan_with(load_scene("thesis-2"), {"method": "mrppa", "order": "given"})


@pytest.fixture
def from_page(result: Result) -> Plan:
    """Return the plan as it comes back from the page."""
    return plan_of(result.plan.scene, json.loads(json.dumps(plan_answer(result)["plan"])))


class Scripts(HTMLParser):
    """Takes the scripts and the title out of a page as a browser would."""

    def __init__(self, page: str) -> None:
        super().__init__()
        self.scripts: list[tuple[dict[str, str | None], str]] = []
        self.title = ""
        self._inside = ""
        self.feed(page)

    def handle_starttag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        """Begin a script or the title."""
        self._inside = tag
        if tag == "script":
            self.scripts.append((dict(attrs), ""))

    def handle_endtag(self, tag: str) -> None:
        """End it."""
        self._inside = ""

    def handle_data(self, data: str) -> None:
        """Take its text."""
        if self._inside == "script":
            self.scripts[-1] = self.scripts[-1][0], self.scripts[-1][1] + data
        elif self._inside == "title":
            self.title += data

    def script(self, **wanted: str) -> Any:
        """Return the JSON of the one script with these attributes."""
        (text,) = [text for attrs, text in self.scripts if wanted.items() <= attrs.items()]
        return json.loads(text)


def test_a_plan_is_given_out_as_the_command_writes_it(
    tmp_path: Path, result: Result, from_page: Plan, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    assert main(["plan", "thesis-2", "--method", "mrppa", "--order", "given", "-o", "theirs.json"]) == 0
    theirs = (tmp_path / "theirs.json").read_text(encoding="utf-8")
    taut.save(result.plan, "mine.json")
    mine = (tmp_path / "mine.json").read_text(encoding="utf-8")
    file = export(from_page, "plan")
    assert file["text"] == mine
    took = re.compile(r'"seconds": [\d.]+')  # what planning took is no part of the plan
    assert took.sub("", file["text"]) == took.sub("", theirs)
    assert (file["name"], file["type"]) == ("thesis-2-plan.json", "application/json")


@pytest.mark.parametrize(("form", "ending"), [("scene-yaml", ".yaml"), ("scene-json", ".json")])
def test_a_scene_is_given_out_as_it_is_saved(form: Any, ending: str, tmp_path: Path, from_page: Plan) -> None:
    scene = load_scene("hospital-12")
    taut.save(scene, tmp_path / f"scene{ending}")
    file = export(scene, form)
    assert file["text"] == (tmp_path / f"scene{ending}").read_text(encoding="utf-8")
    assert file["name"] == f"hospital-12{ending}"
    assert export(from_page, form)["text"] == export(from_page.scene, form)["text"]


@pytest.mark.parametrize("form", ["png", "svg"])
def test_pictures_are_those_of_the_library(form: Any, tmp_path: Path, from_page: Plan) -> None:
    path = tmp_path / f"picture.{form}"
    for value in (from_page, from_page.scene):
        file = export(value, form)
        taut.save_figure(proved(from_page) if isinstance(value, Plan) else value, path)
        raw = file["text"].encode() if form == "svg" else base64.b64decode(file["base64"])
        assert raw == path.read_bytes()
    assert export(from_page, form, {"reach": 8.0, "sight": True}) != export(from_page, form)


def test_animations_are_those_of_the_library(tmp_path: Path, from_page: Plan) -> None:
    path = tmp_path / "film.gif"
    taut.animate(proved(from_page), path)
    file = export(from_page, "gif")
    assert base64.b64decode(file["base64"]) == path.read_bytes()
    assert (file["name"], file["type"]) == ("thesis-2.gif", "image/gif")


def test_without_ffmpeg_an_mp4_is_refused_before_any_work(from_page: Plan, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("PATH", os.devnull)
    with pytest.raises(OutputError, match=r"^thesis-2.mp4: an .mp4 needs ffmpeg"):
        export(from_page, "mp4")


@pytest.mark.parametrize("form", ["plan", "png", "html"])
def test_a_plan_that_does_not_hold_is_not_given_out(form: Any, from_page: Plan) -> None:
    first, *others = from_page.trajectories
    hurried = Trajectory(first.name, first.stamps * [0.5, 1, 1])
    with pytest.raises(OutputError, match="does not hold and is not given out: R1 moves"):
        export(replace(from_page, trajectories=(hurried, *others)), form)


def test_what_cannot_be_made_is_refused_in_a_sentence(from_page: Plan) -> None:
    for form in ("gif", "html", "plan"):
        with pytest.raises(OutputError, match="plan it first"):
            export(from_page.scene, form)
    with pytest.raises(OutputError, match="unknown options 'size'"):
        export(from_page, "png", {"size": 3})


def test_names_of_files_are_made_of_the_name_of_the_scene() -> None:
    names = [stem_of(name) for name in ("", "a/b\\c", "../../etc/passwd", "Halle Süd", "x" * 90, "...")]
    assert names == ["scene", "a-b-c", "etc-passwd", "Halle-Süd", "x" * 60, "scene"]


def test_a_page_to_send_holds_the_plan_and_nothing_can_break_out_of_it(from_page: Plan) -> None:
    evil = "</script><script>alert(1)</script><!-- \u2028 & \"'"
    scene = replace(from_page.scene, name=evil)
    page = Scripts(export(replace(from_page, scene=scene), "html", {"reach": 8.0, "conflicts": []})["text"])
    assert page.title == evil
    assert len(page.scripts) == 3
    data = page.script(id="data")
    assert data["answer"]["scene"]["name"] == evil
    back = plan_of(taut.formats.scene_from_dict(data["answer"]["scene"]), data["answer"]["plan"])
    assert back.trajectories == from_page.trajectories
    assert data["answer"]["certificate"]["ok"] is True
    assert data["timelines"]["contact"]["times"][0] == 0.0


def test_a_page_holds_all_modules_that_its_own_imports_and_no_others() -> None:
    files = {
        "standalone.js": '// @ts-check\nimport {\n  a,\n  b,\n} from "studio/a.js";\nimport "studio/side.js";\n',
        "a.js": 'export { b } from "studio/b.js";\n/** @type {import("studio/link.js").Link} */\nexport let a;',
        "b.js": 'import { a } from "studio/a.js";\n// import "studio/link.js"\nexport const b = () => a + "é";\n',
        "side.js": "export {};\n",
        **dict.fromkeys(STYLES, "body { color: red; }"),
    }
    assert set(modules_of("standalone.js", files.__getitem__)) == {"standalone.js", "a.js", "b.js", "side.js"}
    page = page_of("<t>", {"n": 1.5}, files.__getitem__)
    imports = Scripts(page).script(type="importmap")["imports"]
    for name, address in imports.items():
        assert base64.b64decode(address.removeprefix("data:text/javascript;base64,")).decode() == files[name[7:]]
    assert "http" not in page.replace("http-equiv", "")


def test_the_package_has_all_modules_of_the_page_to_send() -> None:
    page = Scripts(page_of("t", {}))
    names = set(page.script(type="importmap")["imports"])
    assert "studio/standalone.js" in names
    assert "studio/link.js" not in names


def test_a_page_to_send_plays_in_a_browser_and_asks_nobody(browser: Browser, tmp_path: Path, from_page: Plan) -> None:
    path = tmp_path / "thesis-2.html"
    path.write_text(export(from_page, "html", {"reach": 8.0})["text"], encoding="utf-8")
    context = browser.new_context(viewport={"width": 900, "height": 600})
    page = context.new_page()
    errors: list[str] = []
    asked: list[str] = []
    page.on("pageerror", lambda error: errors.append(str(error)))
    page.on("console", lambda said: errors.append(said.text) if said.type == "error" else None)
    page.on("request", lambda request: None if request.url.startswith("data:") else asked.append(request.url))
    page.goto(path.as_uri())
    page.wait_for_selector("canvas#board")
    before = page.locator("canvas#board").screenshot()
    page.wait_for_timeout(400)
    assert page.title() == "thesis-2"
    assert page.locator("canvas#board").screenshot() != before
    assert asked == [path.as_uri()]
    assert errors == []
    context.close()


SETTINGS: list[dict[str, Any]] = [
    {},
    {"method": "mrppa", "order": "longest", "seed": 3, "roadmap": "visibility", "within": 1.0},
    {"method": "search", "rounds": 50},
    {"method": "repair", "rounds": 3, "objective": "makespan", "order": "given", "roadmap": "voronoi"},
    {"contact": {"range": 18, "sight": False, "k": 1, "lambda2": 0}, "seed": 7},
    {"contact": {"range": 25.5, "sight": False, "k": 2, "lambda2": 0.5}, "method": "prioritized"},
]


@pytest.mark.parametrize("asked", SETTINGS, ids=lambda asked: "-".join(asked) or "defaults")
def test_snippets_plan_what_the_studio_planned(
    asked: dict[str, Any], tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    scene = replace(load_scene("thesis-2"), at_goal="stay")
    taut.save(scene, "my map.yaml")
    plan = plan_with(scene, asked).plan
    told = snippets("my map.yaml", asked)
    taut_word, *words = shlex.split(told["command"])
    assert taut_word == "taut"
    assert main(words) == 0
    target = tmp_path / "my-map-plan.json"
    assert load_plan(target).trajectories == plan.trajectories
    assert load_plan(target).claims == plan.claims
    target.unlink()
    exec(compile(told["python"], "snippet", "exec"), {})
    assert load_plan(target).trajectories == plan.trajectories
    assert load_plan(target).claims == plan.claims


def test_a_snippet_runs_in_a_shell_whatever_the_file_is_called(tmp_path: Path) -> None:
    name = "-it's $HOME; é.yaml"
    taut.save(load_scene("thesis-2"), tmp_path / name)
    told = snippets(name, {})
    command = told["command"].replace("taut ", f"{shlex.quote(sys.executable)} -m taut ", 1)
    done = subprocess.run(["sh", "-c", command], cwd=tmp_path, capture_output=True, text=True, timeout=120)
    assert done.returncode == 0, done.stderr
    written = [path for path in tmp_path.iterdir() if path.suffix == ".json"]
    assert len(written) == 1
    assert written[0].name in told["python"]


def test_snippets_name_only_what_is_not_the_default() -> None:
    assert snippets("thesis-2", {"order": "shortest", "seed": 0, "within": 1, "method": None}) == {
        "command": "taut plan thesis-2 -o thesis-2-plan.json",
        "python": "import taut\n\nscene = taut.load_scene('thesis-2')\nresult = taut.plan(scene)\n"
        "print(result.certificate.ok, result.plan.sum_of_costs)\ntaut.save(result.plan, 'thesis-2-plan.json')\n",
    }
    with pytest.raises(SceneError, match="range must be positive"):
        snippets("thesis-2", {"contact": {"range": -1}})
