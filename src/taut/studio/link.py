"""The link to one page: what it asks goes to the crew, what comes of it goes back; each ask is answered once."""

from __future__ import annotations

import asyncio
import contextlib
import json
import os
from collections import deque
from collections.abc import Callable
from dataclasses import dataclass, field
from functools import partial
from importlib.metadata import version
from pathlib import Path

from starlette.websockets import WebSocket, WebSocketDisconnect

from taut.errors import TautError
from taut.formats import scene_abouts
from taut.studio import jobs, messages
from taut.studio.crew import Crew, Job, Said
from taut.studio.messages import Data
from taut.studio.scene_file import Named, SceneFile, named

MOST_JOBS = 100  # of one page at a time; ours has at most one running and one waiting in each of its lanes
_MOST_UNREAD = 64 << 20  # characters that may wait for a page that does not read
TRY_LATER = 1013  # the close code for "try again later"


@dataclass
class Studio:
    """What all links share.

    Parameters
    ----------
    source : the file or ready scene that the user named, "" for none.
    last : what it held when it could last be read.
    crew : does the work.
    saving : held while the file is written.
    """

    source: str
    last: Named
    crew: Crew
    saving: asyncio.Lock = field(default_factory=asyncio.Lock)

    def hello(self) -> Data:
        """Return what a page is told first: what the user named as it is now, and what else there is."""
        notes: list[str] = []
        if self.source:
            try:
                now = named(self.source)
                if now.value is None and self.last.value is not None:
                    notes.append(f"{now.name} was deleted; shown is what it held")
                else:
                    self.last = now
            except TautError as error:
                # the page must not take a file that cannot be read for an empty one, and write over it
                notes.append(f"{error}; shown is what it held before")
        known, file = self.last, self.last.file
        held = {} if known.value is None else jobs.opened(known.value)
        if file is None and self.source and Path(self.source).is_file():
            notes.append(f"{known.name} is only read here; Save as makes a scene file")
        return {
            "version": version("taut"),
            "file": None if file is None else {**_about(file), "stamp": known.stamp},
            "source": known.name or None,
            "scene": None,
            "plan": None,
            **held,
            "notes": notes,
            "ready": [{"name": name, "about": about} for name, about in scene_abouts()],
            "cores": os.cpu_count() or 1,
        }


def _about(file: SceneFile) -> Data:
    return {"name": file.path.name, "path": str(file.path), "text_format": file.format}


class Link:
    """One WebSocket and the jobs of its page.

    Parameters
    ----------
    socket : not yet accepted.
    studio : shared by all links.
    """

    def __init__(self, socket: WebSocket, studio: Studio) -> None:
        self._socket = socket
        self._studio = studio
        self._jobs: dict[int, Job] = {}
        self._out: deque[str] = deque()
        self._unread = 0
        self._something = asyncio.Event()
        self._overfull = asyncio.Event()
        self._stamp = ""
        self._saves: set[asyncio.Task[None]] = set()

    async def run(self) -> None:
        """Serve the page until it goes."""
        await self._socket.accept()
        crew = self._studio.crew
        hello = await asyncio.to_thread(self._studio.hello)
        self._stamp = hello["file"]["stamp"] if hello["file"] else ""
        self._say({"hello": hello})
        self._say({"state": crew.state})
        deafen = crew.listen(lambda state: self._say({"state": state}))
        tasks = [asyncio.create_task(work) for work in (self._write(), self._read(), self._overfull.wait())]
        try:
            done, _ = await asyncio.wait(tasks, return_when=asyncio.FIRST_COMPLETED)
        finally:
            deafen()
            crew.leave(self)
            for task in tasks:
                task.cancel()
            await asyncio.gather(*tasks, *self._saves, return_exceptions=True)
        if self._overfull.is_set():
            with contextlib.suppress(TimeoutError):
                await asyncio.wait_for(self._socket.close(TRY_LATER, "this page does not read its answers"), 1)
        for task in done:
            task.result()  # what went wrong in it is not hidden

    async def _read(self) -> None:
        while True:
            message = await self._socket.receive()
            if message["type"] != "websocket.receive":
                return
            text = message.get("text")
            if text is None:
                self._wrong(None, "this message is binary; send JSON as text")
            else:
                self._take(text)

    async def _write(self) -> None:
        """Send what is to be said as fast as the page reads it."""
        while True:
            while self._out:
                text = self._out.popleft()
                self._unread -= len(text)
                try:
                    await self._socket.send_text(text)
                except (WebSocketDisconnect, RuntimeError):  # it went while this was on its way
                    return
            self._something.clear()
            await self._something.wait()

    def _say(self, said: Data) -> None:
        self._put(json.dumps(said, ensure_ascii=False, allow_nan=False))

    def _put(self, text: str) -> None:
        self._out.append(text)
        self._unread += len(text)
        self._something.set()
        if self._unread > _MOST_UNREAD:
            self._overfull.set()

    def _take(self, text: str) -> None:
        """Do what one message asks."""
        try:
            ask = messages.read(text)
        except messages.Malformed as error:
            self._wrong(error.id, str(error))
            return
        if isinstance(ask, messages.Cancel):
            self._for_job(ask.cancel, self._studio.crew.cancel)
            return
        if isinstance(ask, messages.Finish):
            self._for_job(ask.finish, self._studio.crew.finish)
            return
        if ask.id in self._jobs:
            self._wrong(None, f"id {ask.id} is still at work; take another one")
            return
        if len(self._jobs) >= MOST_JOBS:
            self._wrong(ask.id, f"more than {MOST_JOBS} asks at a time; wait for answers")
            return
        message, hear = text.encode(), partial(self._hear, ask.id)
        if isinstance(ask, messages.Save):
            file = self._studio.last.file
            if file is None:
                self._wrong(ask.id, "no file was named that could be written; use Save as")
                return
            message = messages.Text(id=0, ask="text", scene=ask.scene, format=file.format).model_dump_json().encode()
            hear = partial(self._hear_text, ask, file)
        self._jobs[ask.id] = self._studio.crew.submit(self, ask.lane or ask.ask, message, ask.heavy, hear, ask.limit)

    def _for_job(self, identity: int, act: Callable[[Job], None]) -> None:
        """Do something about a job of this page, if it is still at work."""
        if job := self._jobs.get(identity):
            act(job)

    def _hear(self, identity: int, kind: Said, body: bytes) -> None:
        """Pass on what the crew says of a job, as the JSON that it is."""
        if kind == "progress":
            self._put(f'{{"id": {identity}, "progress": {body.decode()}}}')
            return
        self._jobs.pop(identity, None)
        if kind == "stopped":
            self._say({"id": identity, "stopped": body.decode()})
        else:
            self._put(f'{{"id": {identity}, {body.decode()[1:]}')

    def _hear_text(self, ask: messages.Save, file: SceneFile, kind: Said, body: bytes) -> None:
        """Write the text of the scene to the file, once it is there."""
        outcome = json.loads(body) if kind == "outcome" else {}
        if "ok" not in outcome:
            self._hear(ask.id, kind, body)
            return
        # the worker is done with it: from here on it is not cancelled, a file is written or it is not
        self._jobs.pop(ask.id, None)
        task = asyncio.create_task(self._save(ask, file, outcome["ok"]["text"]))
        self._saves.add(task)
        task.add_done_callback(self._saves.discard)

    async def _save(self, ask: messages.Save, file: SceneFile, text: str) -> None:
        known = self._stamp if ask.stamp is None else ask.stamp
        try:
            async with self._studio.saving:
                stamp = await asyncio.to_thread(file.save, text, known, ask.overwrite_changed, ask.drop_comments)
        except TautError as error:
            self._wrong(ask.id, str(error), getattr(error, "kind", "file"))
        else:
            self._stamp = stamp
            self._say({"id": ask.id, "ok": {"saved": str(file.path), "stamp": stamp}})

    def _wrong(self, identity: int | None, message: str, kind: str = "message") -> None:
        self._say({"id": identity, "wrong": {"message": message, "kind": kind}})
