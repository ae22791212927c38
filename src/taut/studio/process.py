"""One worker process as the server sees it: started, given a job, stopped, killed."""

from __future__ import annotations

import asyncio
import contextlib
import os
import shutil
import signal
import sys
import tempfile
from asyncio.subprocess import DEVNULL, PIPE, Process
from collections.abc import Callable, Sequence

from taut.studio.worker import FOLDER, HEAD

Hear = Callable[[bytes, bytes], None]

_BUFFER = 1 << 20  # bytes of an answer that are read ahead


class WorkerProcess:
    """A process that works for one job at a time; see `taut.studio.worker` for the frames.

    Parameters
    ----------
    hear : called with the kind and body of each frame, and with b"" twice when the process has ended.
    program : words after the interpreter's name.
    loud : whether what it writes on stderr is shown.
    """

    def __init__(self, hear: Hear, program: Sequence[str], loud: bool) -> None:
        self._hear = hear
        self._program = program
        self._loud = loud
        self._process: Process | None = None
        self._task = asyncio.create_task(self._run())
        self._killed = False

    @property
    def pid(self) -> int | None:
        """Number of the process once it runs."""
        return None if self._process is None else self._process.pid

    def give(self, number: int, message: bytes) -> None:
        """Give it a job, only when it is warm and has none."""
        self._send(b"J", number, message)

    def stop(self, number: int) -> None:
        """Ask it to stop a job; it hears at the next step."""
        self._send(b"S", number, b"")

    def finish(self, number: int) -> None:
        """Ask it to be content with the best it found so far."""
        self._send(b"F", number, b"")

    def kill(self) -> None:
        """End it at once."""
        self._killed = True
        if self._process is None or self._process.returncode is not None:
            return
        with contextlib.suppress(ProcessLookupError):
            if sys.platform == "win32":
                self._process.kill()
            else:  # without looking first whether it has ended, which would take its end from who waits for it
                os.kill(self._process.pid, signal.SIGKILL)

    async def ended(self) -> None:
        """Wait until the process is gone."""
        await self._task

    def _send(self, kind: bytes, number: int, body: bytes) -> None:
        if self._process is None or self._process.stdin is None or self._process.stdin.is_closing():
            return  # it has ended, and `hear` is told so
        self._process.stdin.write(HEAD.pack(5 + len(body)) + kind + HEAD.pack(number) + body)

    async def _run(self) -> None:
        # -P: a folder with a file numpy.py in it is a fine place to start the studio from
        words = (sys.executable, "-P", *self._program)
        folder = ""
        try:
            # a process that is killed cannot tidy up: what it keeps for a while is in a folder of its own
            folder = tempfile.mkdtemp(prefix="taut-studio-")
            places = dict.fromkeys(("TMPDIR", "TEMP", "TMP", FOLDER), folder)
            process = await asyncio.create_subprocess_exec(
                *words,
                stdin=PIPE,
                stdout=PIPE,
                stderr=None if self._loud else DEVNULL,
                limit=_BUFFER,
                env={**os.environ, **places},
            )
            self._process = process
            if self._killed:
                self.kill()
            assert process.stdout is not None
            with contextlib.suppress(asyncio.IncompleteReadError, ConnectionError):
                while True:
                    (length,) = HEAD.unpack(await process.stdout.readexactly(HEAD.size))
                    frame = await process.stdout.readexactly(length)
                    self._hear(frame[:1], frame[1:])
            self.kill()  # one that only closed its pipe is of no use
            await process.wait()
        except OSError:
            pass  # it could not even be started, which is told like an end
        finally:
            if folder:
                shutil.rmtree(folder, ignore_errors=True)
        self._hear(b"", b"")
