"""Contact on the command line: proved, told, drawn, handed to the planner, and refused in one line."""

from __future__ import annotations

import json
import math
from collections.abc import Mapping
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from PIL import Image

import taut.team
from commands import Command, command_in, refused
from taut.contact import Contact, contact_of
from taut.errors import PlanError
from taut.formats import load_plan, plan_from_dict, plan_to_dict, save
from taut.motion import Plan, Trajectory
from taut.scene import Robot, Scene


@pytest.fixture
def command(tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]) -> Command:
    return command_in(tmp_path, monkeypatch, capsys)


def column(claims: Mapping[str, object] | None = None, speed: float = 1.0) -> Plan:
    """Return three robots abreast, 2 m apart, of which the last waits until it lags by 1 m."""
    robots = [Robot(name, (1, y), (9, y), radius=0.3, speed=speed) for name, y in (("A", 1), ("B", 3), ("C", 5))]
    scene = Scene((0, 0, 10, 6), [], robots, name="column")
    moves = [np.array([[0, *r.start], [8, *r.goal]]) for r in robots[:2]]
    moves.append(np.array([[0, 1, 5], [1, 1, 5], [9, 9, 5]]))
    stamps = zip(robots, moves, strict=True)
    return Plan(scene, tuple(Trajectory(r.name, move / (speed, 1, 1)) for r, move in stamps), claims=claims or {})


@pytest.fixture
def files(tmp_path: Path) -> Path:
    save(column(), tmp_path / "plain.json")
    save(column({"contact": {"range": 2.5}}), tmp_path / "claims.json")
    save(column({"contact": {"range": 2.1}}), tmp_path / "boasts.json")
    save(column().scene, tmp_path / "scene.yaml")
    return tmp_path


# --- verify


@pytest.mark.parametrize("words", [("claims.json",), ("plain.json", "--contact", "2.5")])
def test_contact_is_proved_as_claimed_or_as_asked(command: Command, files: Path, words: tuple[str, ...]) -> None:
    run = command("verify", *words)
    assert run.code == 0
    facts = {line[:18].strip(): line[18:].strip() for line in run.out.splitlines()}
    assert facts["contact"] == "within 2.5 m"
    assert facts["least λ2"].startswith("1 at t = ")
    needed, _, when = facts["range needed"].partition(" m, at t = ")
    assert float(needed) == pytest.approx(math.sqrt(5), rel=2e-6)
    assert 1 <= float(when.removesuffix(" s")) <= 8
    assert facts["cut vertices"] == "B (9 s)"
    assert facts["certified"].startswith("yes")


def test_without_a_claim_or_a_demand_nothing_is_said_of_contact(command: Command, files: Path) -> None:
    run = command("verify", "plain.json")
    assert run.code == 0
    assert "contact" not in run.out
    assert "λ2" not in run.out
    assert "cut_vertices" not in command("verify", "plain.json", "--json").json


@pytest.mark.parametrize("words", [("boasts.json",), ("plain.json", "--contact", "2.1")])
def test_contact_that_is_lost_is_told_and_exit_code_1(command: Command, files: Path, words: tuple[str, ...]) -> None:
    run = command("verify", *words)
    assert run.code == 1
    (problem,) = [line for line in run.out.splitlines() if line.startswith("problem: ")]
    assert "C loses contact" in problem
    assert "0.640312" in problem  # seconds at which it lags by √(2.1² − 2²) m
    assert run.err == f"taut: error: {words[0]}: the plan does not hold\n"
    assert "least λ2" in run.out


def test_a_demand_is_proved_beside_the_claim(command: Command, files: Path) -> None:
    run = command("verify", "boasts.json", "--contact", "2.5")
    assert run.code == 1
    assert "within 2.5 m" in run.out
    assert "range of 2.1 m" in run.out
    assert command("verify", "claims.json", "--contact", "2.1").code == 1
    assert command("verify", "claims.json", "--contact", "4.2").code == 0


def test_stronger_demands_are_proved(command: Command, files: Path) -> None:
    strong = ("verify", "plain.json", "--contact", "4.2", "--connected", "2", "--lambda2", "2.9", "--sight")
    run = command(*strong)
    assert run.code == 0
    assert "within 4.2 m and in sight, 2-connected, λ2 at least 2.9" in run.out
    assert "cut vertices      none" in run.out
    weak = command("verify", "plain.json", "--contact", "2.5", "--connected", "2")
    assert weak.code == 1
    assert "problem: without B" in weak.out
    low = command("verify", "plain.json", "--contact", "2.5", "--lambda2", "1.5")
    assert low.code == 1
    assert "problem: λ2" in low.out


def test_json_carries_the_proof(command: Command, files: Path) -> None:
    proof = command("verify", "plain.json", "--contact", "2.5", "--json").json
    assert proof["ok"] is True
    assert proof["contact"]["demand"] == {"range": 2.5, "sight": False, "k": 1, "lambda2": 0.0}
    assert proof["contact"]["lambda2"] == pytest.approx(1.0)
    assert proof["contact"]["needed_range"] == pytest.approx(math.sqrt(5), rel=2e-6)
    assert proof["cut_vertices"] == {"B": 9.0}
    shown = command("show", "claims.json", "--json").json
    assert shown["certificate"]["contact"] == proof["contact"]
    assert shown["cut_vertices"] == {"B": 9.0}


# --- refusals


@pytest.mark.parametrize("words", [("verify", "plain.json"), ("plan", "scene.yaml"), ("show", "plain.json")])
@pytest.mark.parametrize("value", ["0", "-1", "nan", "inf", "-inf", "near"])
def test_a_range_that_makes_no_sense_is_refused(
    command: Command, files: Path, words: tuple[str, ...], value: str
) -> None:
    assert refused(command(*words, "--contact", value), "--contact")


@pytest.mark.parametrize("words", [("verify", "plain.json"), ("plan", "scene.yaml")])
@pytest.mark.parametrize(
    ("option", "value"),
    [("--connected", "0"), ("--connected", "1.5"), ("--lambda2", "-0.1"), ("--lambda2", "nan"), ("--lambda2", "much")],
)
def test_other_demands_that_make_no_sense_are_refused(
    command: Command, files: Path, words: tuple[str, ...], option: str, value: str
) -> None:
    assert refused(command(*words, "--contact", "3", option, value), option)


@pytest.mark.parametrize("words", [("verify", "claims.json"), ("plan", "scene.yaml")])
@pytest.mark.parametrize("option", [("--sight",), ("--connected", "2"), ("--lambda2", "0.1"), ("--lambda2", "0")])
def test_options_of_contact_need_contact(
    command: Command, files: Path, words: tuple[str, ...], option: tuple[str, ...]
) -> None:
    assert refused(command(*words, *option), option[0], "--contact")


def test_links_are_shown_in_pictures_of_plans_only(command: Command, files: Path) -> None:
    assert refused(command("show", "plain.json", "--contact", "3"), "--figure")
    assert refused(command("show", "plain.json", "--sight", "--figure", "a.png"), "--sight", "--contact")
    assert refused(command("show", "scene.yaml", "--contact", "3", "--figure", "a.png"), "scene.yaml", "taut plan")
    assert not (files / "a.png").exists()


# --- pictures


def test_show_draws_the_links_asked_for_or_claimed(command: Command, files: Path) -> None:
    save(column(speed=20.0), "fast.json")
    save(column({"contact": {"range": 2.5}}, speed=20.0), "fast-claims.json")
    sizes = {}
    for name, words in (
        ("none", ("fast.json",)),
        ("asked", ("fast.json", "--contact", "2.5")),
        ("claimed", ("fast-claims.json",)),
    ):
        run = command("show", *words, "--figure", f"{name}.png", "--animate", f"{name}.gif")
        assert run.code == 0
        with Image.open(files / f"{name}.png") as figure, Image.open(files / f"{name}.gif") as film:
            sizes[name] = (figure.size, film.size)
    assert sizes["asked"] == sizes["claimed"]
    for plain, linked in zip(sizes["none"], sizes["asked"], strict=True):
        assert linked[0] == plain[0]
        assert linked[1] > plain[1] + 100
    assert (files / "asked.gif").read_bytes() == (files / "claimed.gif").read_bytes()


def test_showing_links_demands_nothing(command: Command, files: Path) -> None:
    assert command("show", "plain.json", "--contact", "2.1", "--figure", "a.png").code == 0


# --- plan


@pytest.mark.parametrize(
    ("words", "demand"),
    [
        (("--contact", "5"), Contact(5.0)),
        (
            ("--contact", "5.5", "--sight", "--connected", "2", "--lambda2", "0.3"),
            Contact(5.5, sight=True, k=2, lambda2=0.3),
        ),
        ((), None),
    ],
)
def test_the_planner_gets_the_demand(
    command: Command, files: Path, monkeypatch: pytest.MonkeyPatch, words: tuple[str, ...], demand: Contact | None
) -> None:
    asked = []
    plan_team = taut.team.plan

    def listening(scene: Scene, **options: Any) -> Any:
        asked.append(options.pop("contact"))
        return plan_team(scene, **options)

    monkeypatch.setattr("taut.team.plan", listening)
    assert command("plan", "scene.yaml", *words).code == 0
    assert asked == [demand]


# --- files


@pytest.mark.parametrize(
    "claim",
    [{"range": 3}, {"range": 2.25, "sight": True}, {"range": 0.1 + 0.2, "sight": False, "k": 3, "lambda2": 1e-3}],
)
def test_a_claim_survives_the_file_as_it_is_written(tmp_path: Path, claim: dict[str, object]) -> None:
    plan = column({"contact": claim, "another": [1, "b"]})
    save(plan, tmp_path / "a.json")
    again = load_plan(tmp_path / "a.json")
    assert again.claims == plan.claims
    assert repr(again.claims) == repr(plan.claims)
    save(again, tmp_path / "b.json")
    assert (tmp_path / "b.json").read_bytes() == (tmp_path / "a.json").read_bytes()


def test_a_demand_written_as_a_claim_comes_back(tmp_path: Path) -> None:
    demand = Contact(4.0, sight=True, k=2, lambda2=0.5)
    save(column({"contact": demand.claim}), tmp_path / "a.json")
    claim = load_plan(tmp_path / "a.json").claims["contact"]
    assert isinstance(claim, dict)
    assert contact_of(claim) == demand


@pytest.mark.parametrize(
    ("claim", "words"),
    [
        (5, "claims: contact must be a mapping"),
        ({}, "`range` is missing"),
        ({"range": 0}, "claims: contact: range must be positive, got 0"),
        ({"range": "3"}, "range must be a number, got '3'; remove the quotes"),
        ({"range": 3, "sight": 1}, "sight must be true or false, got 1"),
        ({"range": 3, "k": 0}, "k must be a whole number of at least 1, got 0"),
        ({"range": 3, "k": 1.5}, "k must be a whole number of at least 1, got 1.5"),
        ({"range": 3, "k": True}, "k must be a whole number of at least 1, got true"),
        ({"range": 3, "lambda2": -1}, "lambda2 must not be negative, got -1"),
        ({"range": 3, "lamda2": 1}, "unknown key `lamda2`; did you mean `lambda2`?"),
    ],
)
def test_a_malformed_claim_in_a_file_is_refused_with_its_line(
    command: Command, files: Path, claim: object, words: str
) -> None:
    data = plan_to_dict(column()) | {"claims": {"contact": claim}}
    with pytest.raises(PlanError) as caught:
        plan_from_dict(data)
    assert words in str(caught.value)
    (files / "bad.json").write_text(json.dumps(data, indent=1))
    assert refused(command("verify", "bad.json"), "bad.json:", words)


def test_a_file_may_claim_nothing(tmp_path: Path) -> None:
    for claims in (None, {}, {"contact": None}):
        data = plan_to_dict(column()) | {"claims": claims}
        assert plan_from_dict(data).claims == (claims or {})
    assert plan_from_dict(plan_to_dict(replace(column(), claims={}))).claims == {}
