"""A worker of the studio whose jobs do what a test tells them: sleep, listen or not, die. Run as a program."""

from __future__ import annotations

import os
import time

from taut.studio import messages, worker
from taut.studio.jobs import Tell
from taut.studio.messages import Data


def do(ask: messages.Asked, tell: Tell) -> Data:
    assert isinstance(ask, messages.Plan | messages.Check)
    told = ask.scene
    if told.get("die"):
        os._exit(7)
    until = time.monotonic() + told.get("seconds", 0)
    while time.monotonic() < until:
        time.sleep(0.01)
        if not told.get("deaf"):
            tell({"text": "at work"})
    if told.get("fail"):
        raise RuntimeError("a fault\nof two lines")
    return {"ok": {"number": float(told["number"]) if "number" in told else None, "pid": os.getpid()}}


def warm_up() -> None:
    if "ODD_WORKER_BROKEN" in os.environ:
        raise RuntimeError("cannot warm up")


if __name__ == "__main__":
    worker.main(do, warm_up)
