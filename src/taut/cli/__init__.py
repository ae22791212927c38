"""The command ``taut``: thin, every command is a few calls of the library and a report of what came out."""

from __future__ import annotations

import os
import sys
from collections.abc import Sequence

__all__ = ["main"]

INTERRUPTED = 130


def main(argv: Sequence[str] | None = None) -> int:
    """Run one command line.

    Parameters
    ----------
    argv : the words after ``taut``; None takes those of the process.

    Returns
    -------
    The exit code: 0 done, 1 no plan exists, none was found or one does not hold, 2 bad input, 70 an error inside taut,
    130 interrupted, 141 nobody reads the output any more.
    """
    for name in ("stdout", "stderr"):
        # Python leaves out streams that were closed before it began.
        if getattr(sys, name) is None:
            setattr(sys, name, open(os.devnull, "w", encoding="utf-8"))  # noqa: SIM115  # lives until the process ends
    try:
        # Imported only now: who presses Ctrl-C while the libraries load must not see where they were.
        from taut.cli.application import run

        return run(sys.argv[1:] if argv is None else argv)
    except KeyboardInterrupt:
        print("taut: error: interrupted", file=sys.stderr)
        return INTERRUPTED
