"""A worker: a process that does one job after another, told by its parent over pipes, and ends with it.

Frames in both directions are four bytes of length and so many bytes. To the worker: a byte "J", four bytes of the
job's number, and the message of the page; "S" and a number: stop this job; "F" and a number: be content with the best
found so far. From it: "R" when it is warm; of the job it does "P" and progress, and at last "A" and the outcome, or "H"
where it heard that it should stop; all as JSON.
"""

from __future__ import annotations

import json
import os
import queue
import shutil
import signal
import struct
import sys
import threading
import time
import traceback
from collections.abc import Callable
from typing import BinaryIO, NoReturn, TypeAlias

from taut.errors import one_line
from taut.studio import jobs, messages
from taut.studio.messages import Data

Do: TypeAlias = Callable[[messages.Asked, jobs.Tell], Data]

HEAD = struct.Struct("!I")
FOLDER = "TAUT_STUDIO_FOLDER"  # the variable that names a folder to be removed by who ends last
_NICE = 3  # the page and the server come first
_OFTEN = 0.1  # seconds between two words of progress


class _Stopped(Exception):
    """The job is not wanted any more."""


class _Bench:
    """Where the worker's main thread finds its jobs, and hears of those to be stopped, from the thread that reads."""

    def __init__(self, source: BinaryIO, sink: BinaryIO, do: Do) -> None:
        self._source = source
        self._sink = sink
        self._do = do
        self._jobs: queue.SimpleQueue[tuple[int, bytes]] = queue.SimpleQueue()
        self._stopped = -1
        self._finished = -1

    def read(self) -> None:
        """Take frames until the parent is gone, then end the process, whatever it is doing."""
        try:
            while head := self._source.read(HEAD.size):
                frame = self._source.read(*HEAD.unpack(head))
                kind, (number,), rest = frame[:1], HEAD.unpack(frame[1:5]), frame[5:]
                match kind:  # jobs come one by one: no earlier one than the one named is running
                    case b"S":
                        self._stopped = number
                    case b"F":
                        self._finished = number
                    case _:
                        self._jobs.put((number, rest))
        finally:
            _end()

    def say(self, kind: bytes, said: Data | None = None) -> None:
        """Send a frame; a parent that is gone ends the process."""
        body = b"" if said is None else json.dumps(said, ensure_ascii=False, allow_nan=False).encode("utf-8", "replace")
        try:
            self._sink.write(HEAD.pack(1 + len(body)) + kind + body)
            self._sink.flush()
        except OSError:
            _end()

    def work(self) -> None:
        """Do jobs for ever."""
        while True:
            number, message = self._jobs.get()
            try:
                ask = messages.read(message)
                assert isinstance(ask, messages.Ask)
                outcome = self._do(ask, self._teller(number))
            except _Stopped:
                self.say(b"H")
                continue
            except MemoryError:
                outcome = {"wrong": {"message": "out of memory"}}
            except Exception as error:
                traceback.print_exc()
                what = one_line(f"{type(error).__name__}: {error}")
                outcome = {"wrong": {"message": f"internal error, please report it: {what}", "kind": "internal"}}
            self._answer(outcome)

    def _answer(self, outcome: Data) -> None:
        try:
            self.say(b"A", outcome)
        except ValueError as error:  # a number that JSON has no word for
            traceback.print_exc()
            message = f"internal error, please report it: {one_line(str(error))}"
            self.say(b"A", {"wrong": {"message": message, "kind": "internal"}})

    def _teller(self, number: int) -> jobs.Tell:
        last = time.monotonic()

        def tell(said: Data) -> None:
            nonlocal last
            if self._stopped == number:
                raise _Stopped
            if self._finished == number:
                # the planners that have a plan take it for Ctrl-C and return that; the others do not hear it
                signal.raise_signal(signal.SIGINT)
            now = time.monotonic()
            if now - last >= _OFTEN:
                last = now
                self.say(b"P", said)

        return tell


def _end() -> NoReturn:
    """End at once; the parent is gone, and so nobody else removes the folder."""
    if folder := os.environ.get(FOLDER):
        shutil.rmtree(folder, ignore_errors=True)
    os._exit(0)


def main(do: Do = jobs.outcome, warm_up: Callable[[], None] = jobs.warm_up) -> None:
    """Warm up and work until the parent is gone.

    Parameters
    ----------
    do : does what is asked, see `taut.studio.jobs.outcome`.
    warm_up : is called before the first job.
    """
    # Ctrl-C goes to all processes of a terminal; it is the server that ends its workers
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    # what libraries print must not come between the frames
    sink = os.fdopen(os.dup(1), "wb")
    os.dup2(2, 1)
    if hasattr(os, "nice"):
        os.nice(_NICE)
    bench = _Bench(sys.stdin.buffer, sink, do)
    threading.Thread(target=bench.read, daemon=True).start()
    warm_up()
    bench.say(b"R")
    bench.work()


if __name__ == "__main__":
    main()
