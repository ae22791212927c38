"""The crew of the studio: newest wins, unwanted work ends, dead workers are replaced, with real processes."""

from __future__ import annotations

import asyncio
import contextlib
import json
import os
import signal
import time
from collections.abc import AsyncIterator, Awaitable, Callable
from pathlib import Path
from typing import Any

import pytest

from taut.studio.crew import Crew, Job, Said

PROGRAM = (str(Path(__file__).with_name("odd_worker.py")),)
LONG = 60.0


class Asking:
    """What the crew said of one job."""

    def __init__(
        self, crew: Crew, owner: object, lane: str, heavy: bool, told: dict[str, Any], limit: float | None = None
    ) -> None:
        self.said: list[tuple[Said, bytes]] = []
        self._last = asyncio.Event()
        message = {"id": 1, "ask": "plan" if heavy else "check", "scene": told}
        self.job: Job = crew.submit(owner, lane, json.dumps(message).encode(), heavy, self._hear, limit)

    def _hear(self, kind: Said, body: bytes) -> None:
        assert not self._last.is_set(), "nothing is said after the last word"
        self.said.append((kind, body))
        if kind != "progress":
            self._last.set()

    async def end(self) -> str:
        """Return the last word: "ok", what is wrong, or why it was stopped."""
        await asyncio.wait_for(self._last.wait(), 20)
        kind, body = self.said[-1]
        if kind == "stopped":
            return body.decode()
        outcome = json.loads(body)
        return "ok" if "ok" in outcome else str(outcome["wrong"]["message"])


@contextlib.asynccontextmanager
async def crew_at_work(size: int = 3, warm: int | None = None) -> AsyncIterator[Crew]:
    """Return a crew of which some are warm, all if not said."""
    crew = Crew(size, PROGRAM)
    crew.start()
    try:
        await until(lambda: crew.warm >= (size if warm is None else warm))
        yield crew
    finally:
        await crew.close()


async def until(holds: Callable[[], bool], seconds: float = 20) -> None:
    end = time.monotonic() + seconds
    while not holds():
        assert time.monotonic() < end, "this never came"
        await asyncio.sleep(0.01)


def run(test: Awaitable[None]) -> None:
    async def limited() -> None:
        await asyncio.wait_for(test, 60)

    asyncio.run(limited())


def plan(crew: Crew, owner: object = "tab", lane: str = "plan", **told: Any) -> Asking:
    return Asking(crew, owner, lane, True, told)


def check(crew: Crew, owner: object = "tab", lane: str = "check", **told: Any) -> Asking:
    return Asking(crew, owner, lane, False, told)


def test_of_a_thousand_asks_the_newest_is_answered_and_all_others_are_told() -> None:
    async def test() -> None:
        async with crew_at_work() as crew:
            asks = [plan(crew, number=k) for k in range(1000)]
            ends = [await ask.end() for ask in asks]
            assert ends[-1] == "ok"
            assert json.loads(asks[-1].said[-1][1])["ok"]["number"] == 999
            assert set(ends) <= {"ok", "newer"}
            assert ends[0] == "ok", "the one that was young when it was superseded is let finish"
            assert ends.count("ok") == 2

    run(test())


def test_work_that_is_superseded_when_it_is_old_is_stopped_and_the_newest_begins_at_once() -> None:
    async def test() -> None:
        async with crew_at_work() as crew:
            old = plan(crew, seconds=LONG)
            await asyncio.sleep(0.4)
            pids = set(crew.pids)
            began = time.monotonic()
            new = plan(crew, seconds=0.0)
            assert await old.end() == "newer"
            assert await new.end() == "ok"
            assert time.monotonic() - began < 10
            await until(lambda: crew.idle == 3)
            assert set(crew.pids) == pids, "one that listens is not killed"

    run(test())


def test_work_that_does_not_listen_is_killed_and_its_process_replaced() -> None:
    async def test() -> None:
        async with crew_at_work() as crew:
            before = set(crew.pids)
            deaf = plan(crew, seconds=LONG, deaf=True)
            await asyncio.sleep(0.3)
            crew.cancel(deaf.job)
            assert await deaf.end() == "cancelled"
            after = plan(crew, seconds=0.0)
            assert await after.end() == "ok", "the spare takes over"
            await until(lambda: len(set(crew.pids) & before) == 2)
            await until(lambda: crew.warm == 3)
            assert len(crew.pids) == 3
            assert crew.state == "ready"

    run(test())


def test_work_that_is_to_finish_but_has_nothing_to_show_is_cancelled(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("taut.studio.crew._FINISH", 0.2)

    async def test() -> None:
        async with crew_at_work(2) as crew:
            running = plan(crew, seconds=LONG)
            waiting = plan(crew, "other tab", seconds=LONG)
            for ask in (waiting, running):
                crew.finish(ask.job)
                assert await ask.end() == "cancelled"
            assert await plan(crew).end() == "ok"

    run(test())


def test_quick_asks_do_not_wait_behind_plans() -> None:
    async def test() -> None:
        async with crew_at_work() as crew:
            for owner in range(4):
                plan(crew, owner, seconds=LONG)
            began = time.monotonic()
            assert await check(crew).end() == "ok"
            assert time.monotonic() - began < 10

    run(test())


def test_a_quick_ask_that_is_superseded_is_let_finish_and_of_those_that_wait_the_newest_is_done() -> None:
    async def test() -> None:
        async with crew_at_work() as crew:
            asks = [check(crew, seconds=0.6) for _ in range(3)]
            assert [await ask.end() for ask in asks] == ["ok", "newer", "ok"]

    run(test())


def test_who_has_to_wait_for_others_is_told_so() -> None:
    async def test() -> None:
        async with crew_at_work() as crew:
            asks = [plan(crew, owner, seconds=0.3) for owner in range(3)]
            assert [b"waits" in ask.said[0][1] if ask.said else False for ask in asks] == [False, False, True]
            assert [await ask.end() for ask in asks] == ["ok"] * 3

    run(test())


def test_lanes_and_owners_do_not_stop_each_other() -> None:
    async def test() -> None:
        async with crew_at_work() as crew:
            asks = [plan(crew, owner, lane, seconds=0.4) for owner in "AB" for lane in ("left", "right")]
            assert [await ask.end() for ask in asks] == ["ok"] * 4

    run(test())


def test_who_leaves_takes_the_work_along() -> None:
    async def test() -> None:
        async with crew_at_work() as crew:
            mine = [plan(crew, "A", lane, seconds=LONG) for lane in ("left", "right")]
            mine.append(plan(crew, "A", "waiting", seconds=LONG))
            other = plan(crew, "B", seconds=0.3)
            await asyncio.sleep(0.1)
            crew.leave("A")
            assert await other.end() == "ok"
            await until(lambda: crew.idle == 3)
            assert not any(kind != "progress" for ask in mine for kind, _ in ask.said), "nobody is there to hear it"

    run(test())


@pytest.mark.parametrize("busy", [True, False])
def test_a_worker_that_is_killed_is_replaced_and_its_job_answered(busy: bool) -> None:
    async def test() -> None:
        async with crew_at_work() as crew:
            lost = plan(crew, seconds=LONG) if busy else None
            await asyncio.sleep(0.1)
            victim = crew.pids[0]
            os.kill(victim, signal.SIGKILL)
            if lost is not None:
                assert await lost.end() == "lost"
            await until(lambda: victim not in crew.pids)
            await until(lambda: crew.warm == 3)
            assert await plan(crew).end() == "ok"

    run(test())


def test_work_that_kills_its_worker_each_time_does_not_stop_the_others() -> None:
    async def test() -> None:
        async with crew_at_work() as crew:
            for _ in range(5):
                assert await plan(crew, die=True).end() == "lost"
            assert await plan(crew).end() == "ok"

    run(test())


def test_states_are_told_once_each() -> None:
    async def test() -> None:
        crew = Crew(1, PROGRAM)
        told: list[str] = []
        crew.listen(told.append)
        crew.start()
        early = plan(crew)  # waits until there is somebody to do it
        assert crew.state == "warming"
        assert await early.end() == "ok"
        os.kill(crew.pids[0], signal.SIGKILL)
        await until(lambda: told == ["ready", "restarting", "ready"])
        await crew.close()

    run(test())


def test_workers_that_cannot_start_are_told_in_a_sentence(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("ODD_WORKER_BROKEN", "1")
    monkeypatch.setattr("taut.studio.crew._PAUSES", (0.0, 0.05, 0.05, 0.05))

    async def test() -> None:
        crew = Crew(2, PROGRAM)
        crew.start()
        assert "--debug" in await plan(crew).end()
        monkeypatch.delenv("ODD_WORKER_BROKEN")
        assert await plan(crew).end() == "ok", "it is tried again"
        await crew.close()

    run(test())


def test_faults_of_the_work_are_told_and_the_worker_goes_on() -> None:
    async def test() -> None:
        async with crew_at_work(1) as crew:
            pids = crew.pids
            said = await plan(crew, fail=True).end()
            assert said == r"internal error, please report it: RuntimeError: a fault\nof two lines"
            said = await plan(crew, number="nan").end()
            assert said.startswith("internal error")
            assert await plan(crew).end() == "ok"
            assert crew.pids == pids

    run(test())


def test_closing_leaves_no_process() -> None:
    async def test() -> None:
        async with crew_at_work() as crew:
            plan(crew, seconds=LONG, deaf=True)
            await asyncio.sleep(0.1)
            pids = crew.pids
        assert not any(Path(f"/proc/{pid}").exists() for pid in pids) or not Path("/proc").exists()

    run(test())


def test_work_with_a_limit_is_given_up_and_told_and_its_process_replaced() -> None:
    async def test() -> None:
        async with crew_at_work() as crew:
            before = set(crew.pids)
            hangs = Asking(crew, "tab", "check", False, {"seconds": LONG, "deaf": True}, limit=0.3)
            assert "longer than 0.3 s" in await hangs.end()
            assert await Asking(crew, "tab", "check", False, {}, limit=5.0).end() == "ok"
            await until(lambda: crew.warm == 3)
            assert len(set(crew.pids) & before) == 2

    run(test())


def folders_of(pids: list[int]) -> list[Path]:
    """Return the folders of temporary files of some processes."""
    if not Path("/proc").exists():
        pytest.skip("this system does not tell what processes are started with")
    named = [Path(f"/proc/{pid}/environ").read_bytes().split(b"\0") for pid in pids]
    return [Path(one.removeprefix(b"TMPDIR=").decode()) for words in named for one in words if one[:7] == b"TMPDIR="]


def test_what_a_worker_kept_for_a_while_is_gone_with_it() -> None:
    async def test() -> None:
        async with crew_at_work() as crew:
            folders = folders_of(crew.pids)
            assert len(set(folders)) == 3
            assert all(folder.is_dir() for folder in folders)
            (folders[0] / "frame.png").write_bytes(b"half a picture")
            os.kill(crew.pids[0], signal.SIGKILL)
            await until(lambda: not folders[0].exists())
        assert not any(folder.exists() for folder in folders)

    run(test())
