"""The command `taut studio`: what it says, what it refuses at once, and that it ends cleanly."""

from __future__ import annotations

import os
import signal
import socket
import subprocess
import sys
import time
from pathlib import Path
from typing import Any

import pytest

import taut
from studio_page import RunningStudio, running_studio
from taut.cli import main
from taut.formats import load_scene, scene_to_dict
from taut.studio.serving import HOST, listen, own_port, redirection
from test_studio_crew import folders_of
from test_studio_server import PATIENCE, THESIS, Tab, gone, tab, until, workers_of


def refusal(capsys: pytest.CaptureFixture[str], *words: str) -> str:
    """Return the one line with which the command refuses to start."""
    assert main(["studio", "--no-browser", *words]) == 2
    said = capsys.readouterr()
    assert said.out == ""
    assert said.err.startswith("taut: error: ")
    assert said.err.count("\n") == 1
    return said.err


def test_what_cannot_be_opened_is_told_before_anything_starts(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    assert "did you mean the ready scene thesis-2" in refusal(capsys, "thesis2")
    assert "no folder" in refusal(capsys, "nowhere/new.yaml")
    Path("bad.yaml").write_text("taut: 1\nbounds: [0, 0, 1]\nobstacles: []\nrobots: []\n", encoding="utf-8")
    assert "bad.yaml:2" in refusal(capsys, "bad.yaml")
    Path("floor.dwg").write_text("x", encoding="utf-8")
    assert "unknown kind of file" in refusal(capsys, "floor.dwg")
    assert "--port" in refusal(capsys, "--port", "99999")


def test_a_port_that_is_taken_is_told_or_if_it_is_our_own_the_next_one_is_used(
    capsys: pytest.CaptureFixture[str], tmp_path: Path
) -> None:
    source = str(tmp_path / "a.yaml")
    with listen(source, None) as one:
        number = one.getsockname()[1]
        assert str(number) in refusal(capsys, "--port", str(number))
        with listen(source, None) as two:
            assert two.getsockname()[1] != number


def test_the_port_is_the_same_each_time_and_another_one_for_another_scene(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    ports = {own_port(f"{k}.yaml") for k in range(50)}
    assert len(ports) > 45
    assert all(49152 <= port <= 65535 for port in ports)
    assert own_port("1.yaml") == own_port(str(tmp_path / "1.yaml"))
    with listen("", None) as one:
        assert one.getsockname()[0] == HOST


@pytest.mark.parametrize("number", [signal.SIGINT, signal.SIGTERM])
def test_it_ends_cleanly_in_the_middle_of_work(number: signal.Signals) -> None:
    words = [sys.executable, "-m", "taut", "studio", "thesis-2", "--no-browser"]
    process = subprocess.Popen(words, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True)
    assert process.stdout is not None
    running = RunningStudio(process.stdout.readline().split()[1], process)
    with tab(running) as one:
        wait_until_ready(one)
        one.ask("plan", scene=scene_to_dict(load_scene("crossing-30")), settings={"seconds": 600})
        while "progress" not in one.hear():
            pass
        workers = workers_of(process.pid)
        began = time.monotonic()
        process.send_signal(number)
        out, err = process.communicate(timeout=20)
    assert process.returncode == 0
    assert time.monotonic() - began < 10
    assert err == ""
    assert out.endswith("studio: ended\n")
    until(lambda: all(map(gone, workers)))


def wait_until_ready(one: Tab) -> None:
    while one.hear().get("state") != "ready":
        pass


def test_after_a_crash_no_worker_is_left_and_the_address_is_the_same_but_for_the_token(tmp_path: Path) -> None:
    path = tmp_path / "floor.yaml"
    with running_studio(str(path)) as first:
        with tab(first) as one:
            wait_until_ready(one)
            workers = workers_of(first.process.pid)
            folders = folders_of(workers)
            first.process.send_signal(signal.SIGKILL)
            first.process.wait()
        until(lambda: all(map(gone, workers)))
        assert folders
        assert not any(folder.exists() for folder in folders)
        with running_studio(str(path)) as second:
            assert second.origin == first.origin
            assert second.url != first.url


def test_a_new_file_is_made_by_saving_and_changes_of_others_are_not_lost(tmp_path: Path) -> None:
    path = tmp_path / "floor.yaml"
    with running_studio("floor.yaml", folder=tmp_path) as studio, tab(studio) as one, tab(studio) as two:
        assert one.hello["scene"] is None
        assert one.hello["file"] == {"name": "floor.yaml", "path": str(path), "text_format": "yaml", "stamp": ""}
        assert not path.exists()
        saved = one.do("save", scene=THESIS)
        assert saved["saved"] == str(path)
        assert load_scene(path) == load_scene("thesis-2")
        moved = {**THESIS, "name": "moved"}
        assert two.wrong("save", scene=moved)["kind"] == "changed"
        assert two.do("save", scene=moved, overwrite_changed=True)
        assert one.wrong("save", scene=THESIS, stamp=saved["stamp"])["kind"] == "changed"
        path.write_text("# by hand\n" + path.read_text(encoding="utf-8"), encoding="utf-8")
        assert two.wrong("save", scene=THESIS, overwrite_changed=True)["kind"] == "comments"
        assert path.read_text(encoding="utf-8").startswith("# by hand")
        assert two.do("save", scene=THESIS, overwrite_changed=True, drop_comments=True)
        assert two.wrong("save", scene={"taut": 1})["message"]
        path.unlink()
        path.mkdir()
        assert "cannot be" in two.wrong("save", scene=THESIS, overwrite_changed=True)["message"]
        assert os.listdir(tmp_path) == ["floor.yaml"]


def test_a_plan_file_opens_with_its_plan_and_is_not_written(tmp_path: Path) -> None:
    path = tmp_path / "plan.json"
    taut.save(taut.plan(taut.load_scene("thesis-2")).plan, path)
    with running_studio(str(path)) as studio, tab(studio) as one:
        assert one.hello["scene"] == THESIS
        assert one.hello["certificate"]["ok"]
        assert len(one.hello["plan"]["robots"]) == 3
        assert one.hello["file"] is None
        assert "Save as" in one.wrong("save", scene=THESIS)["message"]


def test_without_a_scene_it_opens_empty_and_a_second_one_gets_another_port() -> None:
    with running_studio() as one, running_studio() as two:
        assert one.origin != two.origin
        with tab(two) as page:
            assert page.hello["scene"] is None
            assert page.hello["file"] is None


def test_it_is_not_reached_from_other_machines() -> None:
    with running_studio() as studio:
        port = int(studio.origin.rpartition(":")[2])
        addresses: set[Any] = {entry[4][0] for entry in socket.getaddrinfo(socket.gethostname(), None, socket.AF_INET)}
        for address in addresses - {"127.0.0.1"}:
            if not address.startswith("127."):
                with pytest.raises(OSError, match="refused"):
                    socket.create_connection((address, port), 2).close()


def test_it_ends_when_nobody_can_read_its_address() -> None:
    reading, writing = os.pipe()
    os.close(reading)
    words = [sys.executable, "-m", "taut", "studio", "--no-browser"]
    ended = subprocess.run(words, stdout=writing, stderr=subprocess.PIPE, text=True, timeout=PATIENCE, check=False)
    os.close(writing)
    assert (ended.returncode, ended.stderr) == (141, "")


def test_the_browser_is_started_with_a_file_that_only_its_user_can_read_and_not_with_the_token() -> None:
    with redirection("http://127.0.0.1:50000/?token=secret") as given:
        path = Path(given.removeprefix("file://"))
        assert "secret" not in given
        assert "url=http://127.0.0.1:50000/?token=secret" in path.read_text(encoding="utf-8")
        assert path.stat().st_mode & 0o777 == 0o600
        assert path.parent.stat().st_mode & 0o777 == 0o700
    assert not path.parent.exists()


def test_the_file_for_the_browser_is_removed_at_the_end(tmp_path: Path) -> None:
    browser, seen = tmp_path / "browser", tmp_path / "seen"
    browser.write_text(f'#!/bin/sh\necho "$1" > {seen}.part && mv {seen}.part {seen}\n', encoding="utf-8")
    browser.chmod(0o700)
    words = [sys.executable, "-m", "taut", "studio", "thesis-2"]
    env = {**os.environ, "BROWSER": str(browser), "TMPDIR": str(tmp_path)}
    process = subprocess.Popen(words, stdout=subprocess.PIPE, text=True, env=env)
    try:
        until(seen.exists)
        assert process.stdout is not None
        address = process.stdout.readline().split()[1]
        path = Path(seen.read_text(encoding="utf-8").strip().removeprefix("file://"))
        assert address in path.read_text(encoding="utf-8")
    finally:
        process.send_signal(signal.SIGINT)
        process.communicate(timeout=20)
    assert not path.parent.exists()
    assert not list(tmp_path.glob("taut-studio-*")), "the workers' folders are gone, too"
