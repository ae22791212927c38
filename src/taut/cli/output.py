"""Where results go: text or JSON on stdout, progress on stderr, files that are checked before the work starts."""

from __future__ import annotations

import json
import math
import os
import sys
import tempfile
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from pathlib import Path
from typing import NoReturn

import typer

from taut.errors import NoPath, NoPlanExists, NoPlanFound, OutputError, SceneError, one_line


def printable(text: str) -> str:
    """Return the text as one line: characters that would steer the terminal become spaces."""
    return "".join(c if c.isprintable() else " " for c in text)


def say(line: str = "") -> None:
    """Print one line on stdout."""
    print(printable(line))


def say_error(message: str) -> None:
    """Print on stderr, in one line, what went wrong."""
    print(f"taut: error: {printable(message)}", file=sys.stderr)


def say_facts(facts: Iterable[tuple[str, str]]) -> None:
    """Print pairs of a name and a value in two columns."""
    pairs = list(facts)
    width = max((len(name) for name, _ in pairs), default=0)
    for name, value in pairs:
        say(f"{name:<{width}}  {value}")


def say_json(value: Mapping[str, object]) -> None:
    """Print one JSON object on stdout; numbers that JSON cannot express (infinite) become null."""
    print(json.dumps(_finite(value), indent=2, allow_nan=False))


def _finite(value: object) -> object:
    if hasattr(value, "tolist"):  # numpy's, which is too slow to import for this
        value = value.tolist()
    match value:
        case Mapping():
            return {str(key): _finite(item) for key, item in value.items()}
        case str() | bool() | int() | None:
            return value
        case float():
            return float(value) if math.isfinite(value) else None
        case Iterable():
            return [_finite(item) for item in value]
        case _:
            return str(value)


@contextmanager
def progress(what: str) -> Iterator[Callable[[str], None]]:
    """Show on stderr what is being done and for how long, if somebody watches; yields a way to say how far it is."""
    if not sys.stderr.isatty():
        yield lambda _: None
        return
    from rich.console import Console
    from rich.markup import escape
    from rich.progress import Progress, SpinnerColumn, TextColumn, TimeElapsedColumn

    columns = (SpinnerColumn(), TextColumn("{task.description}"), TimeElapsedColumn())
    with Progress(*columns, console=Console(stderr=True), transient=True) as bar:
        task = bar.add_task(escape(printable(what)), total=None)
        yield lambda said: bar.update(task, description=escape(printable(f"{what}: {said}")))


def complain(message: str) -> NoReturn:
    """End the command with exit code 1 after its results were printed, and say on stderr why."""
    say_error(message)
    raise typer.Exit(1)


@contextmanager
def about(source: str) -> Iterator[None]:
    """Name the scene's file, or the ready scene, in errors about the scene that do not say where it came from."""
    try:
        yield
    except SceneError as error:
        if error.file is not None:
            raise
        raise error.at(source) from error
    except (NoPath, NoPlanExists, NoPlanFound) as error:
        error.args = (one_line(f"{source}: {error}"),)
        raise


def require_writable(path: Path | None, what: str, endings: Sequence[str], never: Path | None = None) -> None:
    """Raise now if a file could not be written there later, after minutes of work.

    Parameters
    ----------
    path : the file, or None if it is not wanted.
    what : what it will be, for the message.
    endings : file name endings that it may have, with the dot.
    never : the input file, which the output must not replace.

    Raises
    ------
    OutputError
        Wrong ending, no such directory, no right to write there, or it would replace the input.
    """
    if path is None:
        return
    if path.suffix.lower() not in endings:
        raise OutputError(f"{path}: {what} must end in {_either(endings)}")
    try:
        if path.exists() and not path.is_file():
            raise OutputError(f"{path}: {what} cannot be written there, it is not a file")
        if never is not None and path.exists() and never.exists() and path.samefile(never):
            raise OutputError(f"{path}: {what} would replace the file it is made from; choose another name")
        if not path.parent.is_dir():
            raise OutputError(f"{path}: {what} cannot be written, there is no directory {path.parent}")
        if path.exists() and not os.access(path, os.W_OK):
            raise OutputError(f"{path}: {what} cannot be written, the file is read-only")
        # Only trying tells: rights, read-only mounts and full disks are not all visible in the mode bits.
        with tempfile.TemporaryFile(dir=path.parent) as probe:
            probe.write(b"taut")
    except (OSError, ValueError) as error:
        reason = error.strerror if isinstance(error, OSError) and error.strerror else str(error)
        raise OutputError(f"{path}: {what} cannot be written: {reason}") from None


def _either(words: Sequence[str]) -> str:
    return words[0] if len(words) == 1 else f"{', '.join(words[:-1])} or {words[-1]}"
