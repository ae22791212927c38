"""The crew: which worker does what and when; the newest ask of a lane wins, and what nobody wants any more is ended.

A job belongs to an owner (one link to one page) and a lane of it, and a lane runs one job at a time. There are few
workers for all owners: heavy jobs may take all of them but one, so that quick ones, such as checks, never wait behind
plans; that one is also the spare when a worker that does not listen is killed.
"""

from __future__ import annotations

import asyncio
import json
from collections.abc import Callable, Hashable, Iterator
from dataclasses import dataclass, field
from functools import partial
from typing import Literal, TypeAlias

from taut.studio.process import WorkerProcess

State: TypeAlias = Literal["warming", "ready", "restarting"]
Said: TypeAlias = Literal["progress", "outcome", "stopped"]
Hear: TypeAlias = Callable[[Said, bytes], None]

WORKERS = 3
LET_FINISH = 0.25  # seconds: a job that is superseded when it is younger is still of use, as while dragging
_LISTEN = {True: 0.5, False: 5.0}  # seconds that a heavy or quick job has to hear that it should stop
_PATIENCE = 3.0  # seconds more before it is killed though that leaves too few workers: one takes as long to warm up
_PAUSES = (0.0, 0.5, 2.0, 8.0)  # seconds before a worker that never got warm is started again
_FINISH = 5.0  # seconds that a job has to come to an end with the best that it found
_WAITS = json.dumps({"text": "waits until other work is done", "cost": None, "bound": None}).encode()
_CANNOT = "the workers cannot be started; end the studio and start it with --debug to see why"


@dataclass(eq=False)
class Job:
    """One piece of work, see `Crew.submit`.

    ``answered`` says that its last word was said, ``slot`` where it is done, ``began`` and ``stopped`` when that began
    and when it was asked to stop, seconds of the event loop.
    """

    number: int
    owner: Hashable
    lane: str
    message: bytes
    heavy: bool
    hear: Hear
    limit: float | None = None
    answered: bool = False
    slot: _Slot | None = None
    began: float = 0.0
    superseded: bool = False
    stopped: float | None = None

    def answer(self, kind: Said, body: bytes) -> None:
        """Say the last word, unless it was said."""
        if not self.answered:
            self.answered = True
            self.hear(kind, body)


@dataclass(eq=False)
class _Slot:
    """A place for a worker: the process in it now, whether it is warm, what it does."""

    process: WorkerProcess | None = None
    warm: bool = False
    job: Job | None = None
    failures: int = 0


@dataclass
class Crew:
    """Worker processes and the jobs they do; lives in one event loop.

    Parameters
    ----------
    size : how many processes.
    program : what they run, words after the interpreter's name.
    loud : whether what they write on stderr is shown.
    """

    size: int = WORKERS
    program: tuple[str, ...] = ("-m", "taut.studio.worker")
    loud: bool = False
    _slots: list[_Slot] = field(default_factory=list)
    _waiting: list[Job] = field(default_factory=list)
    _listeners: set[Callable[[State], None]] = field(default_factory=set)
    _timers: set[asyncio.TimerHandle] = field(default_factory=set)
    _numbers: int = 0
    _state: State = "warming"
    _closed: bool = False

    @property
    def state(self) -> State:
        """Whether work can be done: "warming" until it first can."""
        return self._state

    @property
    def pids(self) -> list[int]:
        """Numbers of the processes that run."""
        return [slot.process.pid for slot in self._slots if slot.process is not None and slot.process.pid is not None]

    @property
    def warm(self) -> int:
        """How many processes can work."""
        return sum(slot.warm for slot in self._slots)

    @property
    def idle(self) -> int:
        """How many of them have nothing to do."""
        return sum(slot.warm and slot.job is None for slot in self._slots)

    def listen(self, hear: Callable[[State], None]) -> Callable[[], None]:
        """Have changes of the state told; returns a function that ends it."""
        self._listeners.add(hear)
        return lambda: self._listeners.discard(hear)

    def start(self) -> None:
        """Begin to warm up; one worker after the other, because the first one may have to compile."""
        self._slots = [_Slot() for _ in range(self.size)]
        self._start_next()

    async def close(self) -> None:
        """End all processes and wait until they are gone."""
        self._closed = True
        for timer in self._timers:
            timer.cancel()
        processes = [slot.process for slot in self._slots if slot.process is not None]
        for process in processes:
            process.kill()
        await asyncio.gather(*(process.ended() for process in processes))

    def submit(
        self, owner: Hashable, lane: str, message: bytes, heavy: bool, hear: Hear, limit: float | None = None
    ) -> Job:
        """Have a job done, in the place of older ones of the same owner and lane.

        Parameters
        ----------
        message : of the page, as `taut.studio.messages.read` takes it.
        heavy : whether it may take long.
        hear : called with "progress" and JSON now and then, and at last once with "outcome" and JSON, or with "stopped"
            and "newer" or "lost".
        limit : seconds after which the work is ended and that is told as what is wrong; None lets it take any time.
        """
        self._numbers += 1
        job = Job(self._numbers, owner, lane, message, heavy, hear, limit)
        for older in self._of(owner, lane):
            self._supersede(older)
        self._waiting.append(job)
        self._hand_out()
        if job.slot is None and self.warm and not self._is_busy(job):
            job.hear("progress", _WAITS)
        return job

    def cancel(self, job: Job) -> None:
        """End a job that is not wanted any more; it is told so at once."""
        job.answer("stopped", b"cancelled")
        self._end(job)
        self._hand_out()

    def finish(self, job: Job) -> None:
        """Have a job end soon with the best that it found; one that found nothing, or cannot, is cancelled."""
        if job.slot is None or job.slot.process is None:
            self.cancel(job)
            return
        job.slot.process.finish(job.number)
        self._later(self._now() + _FINISH, lambda: self.cancel(job))

    def leave(self, owner: Hashable) -> None:
        """End all jobs of an owner that is gone."""
        for job in self._of(owner, None):
            job.answered = True
            self._end(job)
        self._hand_out()

    def _of(self, owner: Hashable, lane: str | None) -> list[Job]:
        jobs = [*self._waiting, *(slot.job for slot in self._slots if slot.job is not None)]
        return [job for job in jobs if job.owner == owner and lane in (None, job.lane)]

    def _supersede(self, job: Job) -> None:
        if job.slot is None:
            job.answer("stopped", b"newer")
            self._end(job)
        elif job.heavy and not job.superseded:  # a quick one is let finish: it is sooner done than stopped
            job.superseded = True
            self._later(job.began + LET_FINISH, lambda: self._stop_superseded(job))

    def _stop_superseded(self, job: Job) -> None:
        if job.slot is not None:
            job.answer("stopped", b"newer")
            self._end(job)
            self._hand_out()

    def _end(self, job: Job) -> None:
        """Take a job that was answered out of its queue, or ask its worker to stop; kill that if it does not."""
        if job.slot is None:
            if job in self._waiting:
                self._waiting.remove(job)
            return
        if job.stopped is not None or job.slot.process is None:
            return
        job.stopped = self._now()
        job.slot.process.stop(job.number)
        for wait in (0.0, _PATIENCE):
            self._later(job.stopped + _LISTEN[job.heavy] + wait, self._kill_deaf)

    def _kill_deaf(self) -> None:
        """Kill workers that did not hear, while enough others are warm, or at last also when they are not."""
        for slot in self._slots:
            job = slot.job
            if job is None or job.stopped is None or slot.process is None:
                continue
            late = self._now() - job.stopped - _LISTEN[job.heavy]
            others = sum(other.warm for other in self._slots if other is not slot)
            if late >= _PATIENCE or (late >= 0 and others >= min(2, self.size - 1)):
                slot.warm = False
                slot.process.kill()

    def _hand_out(self) -> None:
        """Give waiting jobs to workers that have none."""
        if self._closed:
            return
        for job in list(self._waiting):
            idle = [slot for slot in self._slots if slot.warm and slot.job is None]
            if not idle or self._is_busy(job) or (job.heavy and self._crowded()):
                continue
            # the same workers for the same kinds of jobs: what they remember is of use again
            slot = idle[0] if job.heavy else idle[-1]
            self._waiting.remove(job)
            job.slot, slot.job, job.began = slot, job, self._now()
            assert slot.process is not None
            slot.process.give(job.number, job.message)
            if job.limit is not None:
                self._later(job.began + job.limit, partial(self._give_up, job, job.limit))

    def _give_up(self, job: Job, limit: float) -> None:
        """End a job that took longer than it may; what keeps it so long is not waited for."""
        if job.slot is None or job.slot.process is None:
            return
        message = f"this took longer than {limit:g} s and was given up; the scene is too large or too crowded for it"
        job.answer("outcome", json.dumps({"wrong": {"message": message, "kind": "limit"}}).encode())
        job.slot.warm = False
        job.slot.process.kill()

    def _is_busy(self, job: Job) -> bool:
        """Whether something is still done in the lane of a job."""
        lanes = ((other.owner, other.lane) for other in self._running() if other.stopped is None)
        return (job.owner, job.lane) in lanes

    def _running(self) -> Iterator[Job]:
        return (slot.job for slot in self._slots if slot.job is not None)

    def _crowded(self) -> bool:
        """Whether one more heavy job would leave no worker for quick ones."""
        return sum(job.heavy for job in self._running() if job.slot and job.slot.warm) >= max(1, self.warm - 1)

    def _heard(self, slot: _Slot, kind: bytes, body: bytes) -> None:
        job = slot.job
        match kind:
            case b"R":
                slot.warm, slot.failures = True, 0
                self._start_next()
            case b"P" if job is not None and not job.answered:
                job.hear("progress", body)
                return
            case b"A" | b"H" if job is not None:
                self._release(slot)
                job.answer("outcome" if kind == b"A" else "stopped", body or b"cancelled")
            case b"":
                self._gone(slot)
        self._tell_state()
        self._kill_deaf()
        self._hand_out()

    def _release(self, slot: _Slot) -> None:
        if slot.job is not None:
            slot.job.slot = None
            slot.job = None

    def _gone(self, slot: _Slot) -> None:
        """Put a new process in the place of one that has ended."""
        job = slot.job
        self._release(slot)
        if job is not None:
            job.answer("stopped", b"lost")
        slot.failures = slot.failures + 1 if not slot.warm and job is None else 0
        slot.process, slot.warm = None, False
        if slot.failures >= len(_PAUSES) and not self.warm:
            for waiting in list(self._waiting):
                waiting.answer("outcome", json.dumps({"wrong": {"message": _CANNOT}}).encode())
                self._end(waiting)
        pause = _PAUSES[min(slot.failures, len(_PAUSES) - 1)]
        self._later(self._now() + pause, self._start_next)

    def _start_next(self) -> None:
        """Start one process where one is missing, unless another one is warming up."""
        if self._closed or any(slot.process is not None and not slot.warm for slot in self._slots):
            return
        missing = next((slot for slot in self._slots if slot.process is None), None)
        if missing is not None:
            self._start(missing)

    def _start(self, slot: _Slot) -> None:
        def hear(kind: bytes, body: bytes) -> None:
            if slot.process is process:
                self._heard(slot, kind, body)

        process = WorkerProcess(hear, self.program, self.loud)
        slot.process = process

    def _tell_state(self) -> None:
        state: State = "ready" if self.warm else "warming" if self._state == "warming" else "restarting"
        if state != self._state:
            self._state = state
            for hear in list(self._listeners):
                hear(state)

    def _later(self, when: float, call: Callable[[], None]) -> None:
        loop = asyncio.get_running_loop()

        def run() -> None:
            self._timers.discard(timer)
            if not self._closed:
                call()

        timer = loop.call_at(when, run)
        self._timers.add(timer)

    def _now(self) -> float:
        return asyncio.get_running_loop().time()
