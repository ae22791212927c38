"""Command lines run in a folder of their own: what they printed, and how they refused."""

from __future__ import annotations

import json
from collections.abc import Callable
from pathlib import Path
from typing import Any, NamedTuple, TypeAlias

import pytest

from taut.cli import main


class Run(NamedTuple):
    """What one command line did."""

    code: int
    out: str
    err: str

    @property
    def json(self) -> Any:
        """The one object on stdout."""
        return json.loads(self.out)


Command: TypeAlias = Callable[..., Run]


def command_in(
    folder: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str], *first: str
) -> Command:
    """Return what runs `taut`, or `taut FIRST`, with the words it is given, in that folder."""
    monkeypatch.chdir(folder)

    def run(*words: str | Path) -> Run:
        code = main([*first, *map(str, words)])
        return Run(code, *capsys.readouterr())

    return run


def on_scenes(command: Command) -> Command:
    """Return the command with the name of a ready scene, or the text of one of its own, as its first word."""

    def run(scene: str, *words: str | Path) -> Run:
        if "\n" in scene:
            Path("scene.yaml").write_text(scene, encoding="utf-8")
            scene = "scene.yaml"
        return command(scene, *words)

    return run


def refused(run: Run, *words: str, code: int = 2) -> bool:
    """Assert that the command refused in one line that holds the words."""
    assert run.code == code, (run.out, run.err)
    assert run.err.startswith("taut: error: ")
    assert run.err.count("\n") == 1, run.err
    assert "Traceback" not in run.err
    for word in words:
        assert word in run.err, run.err
    if code == 2:
        assert run.out == ""
    return True
