"""The studio's server: who may come in, what is answered to what, and that nothing brings it down."""

from __future__ import annotations

import asyncio
import base64
import contextlib
import hashlib
import http.client
import json
import os
import re
import signal
import time
from collections.abc import Iterator
from pathlib import Path
from typing import Any, cast
from urllib.parse import urlsplit

import pytest
from starlette.websockets import WebSocket
from websockets.exceptions import ConnectionClosed, InvalidStatus
from websockets.sync.client import ClientConnection, connect

import taut
from studio_page import RunningStudio, running_studio
from taut.formats import scene_to_dict
from taut.studio import messages
from taut.studio.application import MOST_LINKS
from taut.studio.crew import Crew
from taut.studio.link import Link, Studio
from taut.studio.scene_file import Named

PATIENCE = 120.0  # seconds for what may have to wait until kernels are compiled
THESIS = scene_to_dict(taut.load_scene("thesis-2"))
LONG: dict[str, Any] = {"scene": scene_to_dict(taut.load_scene("crossing-30")), "settings": {"seconds": 600.0}}


@pytest.fixture(scope="module")
def studio() -> Iterator[RunningStudio]:
    with running_studio("thesis-2") as running:
        yield running


class Tab:
    """One page's link to the server."""

    def __init__(self, socket: ClientConnection) -> None:
        self.socket = socket
        self.hello = self.hear()["hello"]
        self.id = 0

    def hear(self) -> dict[str, Any]:
        """Return the next message."""
        heard: dict[str, Any] = json.loads(self.socket.recv(timeout=PATIENCE))
        return heard

    def ask(self, kind: str, /, **fields: Any) -> int:
        """Ask, and return the id."""
        self.id += 1
        self.socket.send(json.dumps({"id": self.id, "ask": kind, **fields}))
        return self.id

    def end_of(self, identity: int | None) -> dict[str, Any]:
        """Return the last word on an ask; what else is heard before it is left out."""
        while True:
            heard = self.hear()
            if heard.get("id", "") == identity and "progress" not in heard:
                return heard

    def do(self, kind: str, /, **fields: Any) -> Any:
        """Ask and return what is ok."""
        return self.end_of(self.ask(kind, **fields))["ok"]

    def wrong(self, kind: str, /, **fields: Any) -> Any:
        """Ask and return what is wrong."""
        return self.end_of(self.ask(kind, **fields))["wrong"]


@contextlib.contextmanager
def tab(studio: RunningStudio, **how: Any) -> Iterator[Tab]:
    url = how.pop("url", studio.url).replace("http:", "ws:").replace("/?", "/link?")
    with connect(url, **{"origin": studio.origin, **how}) as socket:
        yield Tab(socket)


def fetch(studio: RunningStudio, path: str, method: str = "GET", **headers: str) -> tuple[int, dict[str, str], bytes]:
    """Ask for a path exactly as it is written."""
    connection = http.client.HTTPConnection(urlsplit(studio.url).netloc, timeout=PATIENCE)
    try:
        connection.request(method, path, headers=headers)
        response = connection.getresponse()
        return response.status, {key.lower(): value for key, value in response.getheaders()}, response.read()
    finally:
        connection.close()


def upgrade(studio: RunningStudio, host: str, origin: str) -> int:
    """Return the status of a WebSocket's handshake."""
    key = base64.b64encode(bytes(16)).decode()
    words = {"Connection": "Upgrade", "Upgrade": "websocket", "Sec-WebSocket-Version": "13", "Sec-WebSocket-Key": key}
    return fetch(studio, "/link" + index(studio)[1:], Host=host, Origin=origin, **words)[0]


def index(studio: RunningStudio) -> str:
    return studio.url.removeprefix(studio.origin)


def workers_of(process: int) -> list[int]:
    """Return the numbers of the child processes."""
    children = Path(f"/proc/{process}/task/{process}/children")
    if not children.exists():
        pytest.skip("this system does not list child processes under /proc")
    return [int(word) for word in children.read_text().split()]


def gone(process: int) -> bool:
    try:
        return Path(f"/proc/{process}/stat").read_text().rpartition(")")[2].split()[0] == "Z"
    except OSError:
        return True


def until(holds: Any, seconds: float = 20.0) -> None:
    end = time.monotonic() + seconds
    while not holds():
        assert time.monotonic() < end, "this never came"
        time.sleep(0.02)


# Who may come in


def test_the_page_is_served_to_who_has_the_token_and_may_run_only_its_own_scripts(studio: RunningStudio) -> None:
    status, headers, body = fetch(studio, index(studio))
    assert status == 200
    assert headers["content-type"] == "text/html; charset=utf-8"
    policy = dict(part.split(" ", 1) for part in headers["content-security-policy"].split("; "))
    assert policy["default-src"] == policy["frame-ancestors"] == policy["base-uri"] == "'none'"
    inline = re.findall(rb"<script[^>]*>(.+?)</script>", body, re.DOTALL)
    hashes = [f"'sha256-{base64.b64encode(hashlib.sha256(one).digest()).decode()}'" for one in inline]
    assert policy["script-src"].split() == ["'self'", *hashes]
    assert policy["connect-src"].split() == ["'self'", studio.origin.replace("http", "ws")]
    assert headers["referrer-policy"] == "no-referrer"
    assert headers["x-content-type-options"] == "nosniff"
    assert headers["cache-control"] == "no-store"
    assert headers["cross-origin-resource-policy"] == "same-origin"
    assert "server" not in headers
    assert fetch(studio, index(studio), "HEAD")[0] == 200


@pytest.mark.parametrize("query", ["", "?token=", "?token=wrong", "?token=%ff%00%ed%a0%80", "?key=1"])
def test_without_the_token_a_page_says_what_to_do(studio: RunningStudio, query: str) -> None:
    status, headers, body = fetch(studio, f"/{query}")
    assert status == 403
    assert b"taut studio" in body
    assert b"terminal" in body
    assert "content-security-policy" in headers
    assert fetch(studio, f"/{query}", "HEAD")[0] == 403


@pytest.mark.parametrize(
    ("url", "how"),
    [
        ("{origin}/link", {}),
        ("{origin}/link?token=wrong", {}),
        ("{url}", {"origin": "http://example.org"}),
        ("{url}", {"origin": "http://127.0.0.1:1"}),
        ("{url}", {"origin": "null"}),
        ("{url}", {"origin": None}),
    ],
)
def test_links_of_strangers_are_refused(studio: RunningStudio, url: str, how: dict[str, Any]) -> None:
    address = url.format(url=studio.url, origin=studio.origin)
    with pytest.raises(InvalidStatus) as refused, tab(studio, url=address, **how):
        pass
    assert refused.value.response.status_code == 403


@pytest.mark.parametrize("host", ["evil.example", "127.0.0.1.evil.example", "localhost.evil", "", "127.0.0.1:80@evil"])
def test_names_of_other_sites_are_not_answered(studio: RunningStudio, host: str) -> None:
    status, _, body = fetch(studio, index(studio), Host=host)
    assert status == 403
    assert b"<script" not in body


def test_the_server_also_answers_to_localhost_and_through_a_tunnel(studio: RunningStudio) -> None:
    for host in ("localhost:9000", "LOCALHOST", "[::1]:9000"):
        assert fetch(studio, index(studio), Host=host)[0] == 200
    assert upgrade(studio, "localhost:9000", "http://localhost:9000") == 101
    assert upgrade(studio, "localhost:9000", "http://localhost:9001") == 403
    assert upgrade(studio, "evil.example", "http://evil.example") == 403


@pytest.mark.parametrize(
    "path",
    [
        "/page/../application.py",
        "/page/%2e%2e/application.py",
        "/page/..%2fapplication.py",
        "/page/..\\application.py",
        "/page//etc/passwd",
        "/page/%2fetc%2fpasswd",
        "/page/./main.js",
        "/page/main.js%00",
        "/page/",
        "/page",
        "/etc/passwd",
        "/page/index.html",
    ],
)
def test_nothing_but_the_files_of_the_page_is_served(studio: RunningStudio, path: str) -> None:
    assert fetch(studio, path)[0] == 404


def test_modules_and_styles_are_served_as_what_they_are(studio: RunningStudio) -> None:
    for name, kind in (("main.js", "text/javascript"), ("studio.css", "text/css"), ("icon.svg", "image/svg+xml")):
        status, headers, body = fetch(studio, f"/page/{name}")
        assert status == 200
        assert headers["content-type"].startswith(kind)
        assert body


def test_uploads_and_other_methods_are_refused(studio: RunningStudio) -> None:
    assert fetch(studio, index(studio), "POST")[0] == 405
    assert fetch(studio, index(studio), "POST", **{"Content-Length": "100000000000"})[0] == 413
    assert fetch(studio, index(studio), "GET", **{"Transfer-Encoding": "chunked"})[0] == 413


# What is answered


def test_hello_brings_the_scene_and_what_there_is(studio: RunningStudio) -> None:
    with tab(studio) as one:
        assert one.hello["version"] == taut.__version__
        assert one.hello["scene"] == THESIS
        assert one.hello["file"] is None
        assert one.hello["source"] == "thesis-2"
        names = {entry["name"]: entry["about"] for entry in one.hello["ready"]}
        assert names["warehouse-50"]
        assert one.hello["cores"] >= 1
        assert one.hear()["state"] in ("warming", "ready")


def test_plans_are_those_of_the_library(studio: RunningStudio) -> None:
    with tab(studio) as one:
        answer = one.do("plan", scene=THESIS, settings={"seed": 3})
    ours = taut.plan(taut.load_scene("thesis-2"), seed=3)
    assert answer["certificate"]["ok"]
    assert answer["metrics"]["sum_of_costs"] == ours.plan.sum_of_costs
    stamps = [trajectory.stamps.tolist() for trajectory in ours.plan.trajectories]
    assert [robot["stamps"] for robot in answer["plan"]["robots"]] == stamps


def test_every_kind_of_ask_is_answered(studio: RunningStudio) -> None:
    with tab(studio) as one:
        assert one.do("check", scene=THESIS) == {"problems": [], "notes": []}
        plan = one.do("plan", scene=THESIS)["plan"]
        assert one.do("timelines", scene=THESIS, plan=plan, reach=20, sight=False)["until"] > 0
        for of in ("mrppa", "ca", "oca", "dijkstra", "astar"):
            assert one.do("steps", scene=THESIS, of=of, robot="R1")["steps"]
        assert one.do("ready", name="thesis-1")["scene"]["name"] == "thesis-1"
        scene = one.do("random", robots=2, obstacles=3, seed=5, kind="open", size=12)["scene"]
        assert scene == scene_to_dict(taut.random_scene(2, 3, 5, size=12))
        assert one.do("random", robots=2, seed=5, kind="warehouse")["scene"]["robots"]
        text = one.do("text", scene=THESIS, format="yaml")["text"]
        assert one.do("open", text=text, name="a.yaml") == {"scene": THESIS}
        whole = {**plan, "scene": THESIS}
        opened = one.do("open", text=json.dumps(whole), name="plan.json")
        assert opened["scene"] == THESIS
        assert opened["plan"]["robots"] == plan["robots"]
        assert opened["certificate"]["ok"]
        assert one.do("export", scene=THESIS, plan=plan, form="plan", options={})["text"]
        assert "taut plan" in one.do("snippet", settings={"seed": 1}, name="thesis-2")["command"]


def test_a_plan_that_is_opened_is_proved_anew(studio: RunningStudio) -> None:
    with tab(studio) as one:
        plan = one.do("plan", scene=THESIS)["plan"]
        x, y = plan["robots"][0]["stamps"][-1][1:]
        plan["robots"][0]["stamps"].append([1e3, x + 0.5, y])
        opened = one.do("open", text=json.dumps({**plan, "scene": THESIS}), name="plan.json")
    assert plan["certificate"]["ok"]
    assert not opened["certificate"]["ok"]
    assert not opened["plan"]["certificate"]["ok"]


def test_what_is_wrong_comes_with_its_place(studio: RunningStudio) -> None:
    walled = {**THESIS, "obstacles": [*THESIS["obstacles"], {"name": "W", "line": [[0, 8], [16, 8]], "width": 0.1}]}
    with tab(studio) as one:
        said = one.wrong("plan", scene=walled)
        assert said["names"]
        assert said["why"]["from"]
        assert said["why"]["to"]
        said = one.wrong("open", text="taut: 1\nbounds: [0, 0, 1, 1]\nrobots: []\ngap: wide\n", name="a.yaml")
        assert said["line"] == 4
        assert "a.yaml:4" in said["message"]
        assert "no ready scene" in one.wrong("ready", name="../../etc/passwd")["message"]
        assert (
            "read" in one.wrong("save", scene=THESIS)["message"]
            or "named" in one.wrong("save", scene=THESIS)["message"]
        )


def test_long_work_tells_how_far_it_is_and_can_be_cancelled(studio: RunningStudio) -> None:
    with tab(studio) as one:
        identity = one.ask("plan", **LONG)
        while True:
            heard = one.hear()
            if "progress" in heard:
                break
        assert heard["id"] == identity
        assert heard["progress"]["text"]
        began = time.monotonic()
        one.socket.send(json.dumps({"cancel": identity}))
        assert one.end_of(identity) == {"id": identity, "stopped": "cancelled"}
        assert time.monotonic() - began < 5
        one.socket.send(json.dumps({"cancel": identity}))  # once more does nothing
        assert one.do("check", scene=THESIS) == {"problems": [], "notes": []}


def test_improving_can_be_ended_with_the_best_plan_so_far(studio: RunningStudio) -> None:
    with tab(studio) as one:
        identity = one.ask("plan", **LONG)
        costs: list[float] = []
        while len(costs) < 5:
            progress = one.hear().get("progress")
            if progress and progress["cost"]:
                costs.append(progress["cost"])
        one.socket.send(json.dumps({"finish": identity}))
        ended = one.end_of(identity)["ok"]
        assert ended["certificate"]["ok"]
        assert ended["metrics"]["sum_of_costs"] <= costs[-1] * (1 + 1e-9)
        one.socket.send(json.dumps({"finish": identity}))  # once more does nothing
        assert one.do("check", scene=THESIS) == {"problems": [], "notes": []}


# What cannot bring it down

MALFORMED: dict[str, str] = {
    "": "JSON",
    "no": "JSON",
    "[" * 100_000: "JSON",
    "[]": "object",
    "3": "object",
    "{}": "known are check",
    '{"id": 5}': "known are check",
    '{"id": 5, "ask": "fly"}': "'fly'",
    '{"id": 5, "ask": 7}': "known are check",
    '{"id": 5, "ask": "check"}': "`scene` is missing",
    '{"id": 5, "ask": "check", "scene": 3}': "`scene` must be",
    '{"id": 5, "ask": "check", "scene": {}, "more": 1}': "`more` is unknown",
    '{"id": 5, "ask": "plan", "scene": {}, "settings": {"seeed": 1}}': "`settings.seeed` is unknown",
    '{"id": 5, "ask": "plan", "scene": {}, "settings": {"seed": "1"}}': "`settings.seed` must be",
    '{"id": 5, "ask": "plan", "scene": {}, "settings": {"seconds": 1e999}}': "`settings.seconds` must be",
    '{"id": 5, "ask": "check", "scene": {"gap": NaN}}': "JSON",
    '{"id": 5, "ask": "steps", "scene": {}, "of": "magic"}': "`of` must be",
    '{"id": 5, "ask": "export", "scene": {}, "form": "html", "options": {"conflicts": 3}}': "`options.conflicts` must",
    '{"id": 5, "ask": "export", "scene": {}, "form": "png", "options": {"reach": "far"}}': "`options.reach` must be",
    '{"id": 5, "ask": "check", "scene": {}, "lane": ""}': "`lane` must",
    '{"id": -5, "ask": "check", "scene": {}}': "`id` must be",
    '{"id": true, "ask": "check", "scene": {}}': "`id` must be",
    '{"id": 1e3, "ask": "check", "scene": {}}': "`id` must be",
    '{"cancel": "all"}': "`cancel` must be",
    '{"finish": 1, "cancel": 2}': "is unknown",
    '{"id": 5, "ask": "check", "scene": {"a": ' + "7" * 5000 + "}}": "JSON",
    '{"id": 5, "ask": "open", "text": "\\ud800", "name": "a"}': "JSON",
}


@pytest.mark.parametrize("message", MALFORMED, ids=range(len(MALFORMED)))
def test_malformed_messages_are_answered_in_a_sentence(message: str) -> None:
    with pytest.raises(messages.Malformed) as wrong:
        messages.read(message)
    assert MALFORMED[message] in str(wrong.value)
    assert "\n" not in str(wrong.value)
    assert len(str(wrong.value)) < 300
    assert wrong.value.id == (5 if '"id": 5' in message and "JSON" not in str(wrong.value) else None)


def test_malformed_messages_leave_the_link_open(studio: RunningStudio) -> None:
    with tab(studio) as one:
        for message in MALFORMED:
            one.socket.send(message)
        one.socket.send(b"\x00\xff")
        ends = [one.hear() for _ in range(len(MALFORMED) + 2)]
        assert sum("wrong" in end and bool(end["wrong"]["message"]) for end in ends) == len(MALFORMED) + 1
        assert one.do("check", scene=THESIS) == {"problems": [], "notes": []}


@pytest.mark.parametrize(
    "scene",
    [
        {},
        {"taut": 1},
        {"taut": 1, "bounds": [0, 0, 1e308, 1e308], "obstacles": [], "robots": []},
        {"taut": 1, "bounds": "wide", "obstacles": 3, "robots": None},
        {**THESIS, "robots": [{"name": "R"}]},
        {**THESIS, "robots": THESIS["robots"] * 2},
        {**THESIS, "obstacles": [{"name": "é\u0000\u2028", "circle": [1, 1], "radius": -1}]},
    ],
    ids=range(7),
)
def test_scenes_that_are_none_are_told_as_such(studio: RunningStudio, scene: dict[str, Any]) -> None:
    with tab(studio) as one:
        assert all(problem["message"] for problem in one.do("check", scene=scene)["problems"])
        said = one.wrong("plan", scene=scene)
        assert said["message"]
        assert "internal" not in said["message"]


def test_huge_messages_close_the_link_and_only_that(studio: RunningStudio) -> None:
    with tab(studio) as other, tab(studio) as one:
        with contextlib.suppress(ConnectionClosed):
            one.ask("open", name="a", text="x" * messages.LONGEST)
            while True:
                one.hear()
        # "too big"; or no code, where the connection ended while the rest of the message was still on its way
        assert one.socket.close_code in (1009, 1006)
        assert other.do("check", scene=THESIS) == {"problems": [], "notes": []}
    with tab(studio) as again:
        assert again.do("check", scene=THESIS) == {"problems": [], "notes": []}


def test_large_messages_are_taken(studio: RunningStudio) -> None:
    with tab(studio) as one:
        text = "# " + "x" * (messages.LONGEST - 1000) + "\ntaut: 1\nbounds: [0, 0, 1, 1]\nobstacles: []\nrobots: []\n"
        assert "larger than 8 MB" in one.wrong("open", text=text, name="a.yaml")["message"]


def test_tabs_do_not_disturb_each_other(studio: RunningStudio) -> None:
    with tab(studio) as one, tab(studio) as two:
        long = one.ask("plan", **LONG)
        assert two.ask("plan", scene=THESIS) == long
        assert "ok" in two.end_of(long)
        two.socket.send(json.dumps({"cancel": long}))
        assert two.do("plan", scene=THESIS)["certificate"]["ok"]
        newer = one.ask("plan", scene=THESIS)
        assert one.end_of(long) == {"id": long, "stopped": "newer"}
        assert one.end_of(newer)["ok"]["certificate"]["ok"]


def test_links_that_close_in_the_middle_of_planning_take_their_work_along(studio: RunningStudio) -> None:
    for k in range(5):  # more than there are workers
        with tab(studio) as one:
            one.ask("plan", **LONG)
            while "progress" not in one.hear():
                pass
            if k % 2:  # as when a page crashes: without a word
                one.socket.socket.shutdown(2)
    with tab(studio) as after:
        began = time.monotonic()
        assert after.do("plan", scene=THESIS)["certificate"]["ok"]
        assert time.monotonic() - began < 30


def test_of_a_thousand_plans_the_newest_is_answered_and_all_others_are_told(studio: RunningStudio) -> None:
    with tab(studio) as one:
        ids = [one.ask("plan", scene=THESIS, settings={"seed": k}) for k in range(1000)]
        left = set(ids)
        while left:
            heard = one.hear()
            if "state" in heard or "progress" in heard:
                continue
            left.remove(heard["id"])
            assert "ok" in heard or heard == {"id": heard["id"], "stopped": "newer"}
            if heard["id"] == ids[-1]:
                assert heard["ok"]["plan"]["planner"]["seed"] == 999


def test_too_many_asks_at_a_time_are_refused_not_kept(studio: RunningStudio) -> None:
    with tab(studio) as one:
        ids = [one.ask("plan", lane=f"lane {k}", **LONG) for k in range(120)]
        assert "asks at a time" in one.end_of(ids[110])["wrong"]["message"]
        one.socket.send(json.dumps({"id": ids[0], "ask": "check", "scene": THESIS}))
        assert f"id {ids[0]}" in one.end_of(None)["wrong"]["message"]


def test_a_worker_that_is_killed_is_replaced_and_the_page_told(studio: RunningStudio) -> None:
    with tab(studio) as one:
        until(lambda: len(workers_of(studio.process.pid)) == 3, PATIENCE)
        assert one.do("plan", scene=THESIS)["certificate"]["ok"]
        identity = one.ask("plan", **LONG)
        while "progress" not in one.hear():
            pass
        before = workers_of(studio.process.pid)
        for worker in before:
            os.kill(worker, signal.SIGKILL)
        assert one.end_of(identity) == {"id": identity, "stopped": "lost"}
        states: list[str] = []
        while states != ["restarting", "ready"]:
            if state := one.hear().get("state"):
                states.append(state)
        assert one.do("plan", scene=THESIS)["certificate"]["ok"]
        until(lambda: len(workers_of(studio.process.pid)) == 3, PATIENCE)
        assert not set(before) & set(workers_of(studio.process.pid))


def test_a_page_that_does_not_read_is_closed_before_its_answers_fill_the_memory(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    monkeypatch.setattr("taut.studio.link._MOST_UNREAD", 100_000)

    class Deaf:
        """A socket whose page asks again and again, and reads nothing."""

        closed: int | None = None

        async def accept(self) -> None:
            pass

        async def receive(self) -> dict[str, str]:
            await asyncio.sleep(0)
            return {"type": "websocket.receive", "text": "no"}

        async def send_text(self, text: str) -> None:
            await asyncio.Event().wait()

        async def close(self, code: int, reason: str) -> None:
            self.closed = code

    async def test() -> None:
        socket = Deaf()
        link = Link(cast("WebSocket", socket), Studio("", Named(""), Crew()))
        await asyncio.wait_for(link.run(), 20)
        assert socket.closed == 1013

    asyncio.run(test())


def test_one_tab_too_many_is_told_why_it_is_closed(studio: RunningStudio) -> None:
    with contextlib.ExitStack() as tabs:
        for _ in range(MOST_LINKS):
            tabs.enter_context(tab(studio))
        with pytest.raises(ConnectionClosed) as closed:
            tabs.enter_context(tab(studio))
        assert closed.value.rcvd is not None
        assert closed.value.rcvd.code == 1013
        assert closed.value.rcvd.reason == f"the studio is open in {MOST_LINKS} tabs already; close one of them"


def test_timelines_and_random_scenes_leave_a_worker_to_checks() -> None:
    assert messages.Timelines.heavy
    assert messages.Random.heavy
    assert not messages.Check.heavy
    assert messages.Check.limit
