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
from rich import box
from rich.console import Console
from rich.table import Table
from rich.text import Text

from taut.errors import OutputError


def printable(text: str) -> str:
    """Return the text as one line: characters that would steer the terminal become spaces."""
    return "".join(c if c.isprintable() else " " for c in text)


def say(line: str = "") -> None:
    """Print one line on stdout."""
    print(printable(line))


def say_facts(facts: Iterable[tuple[str, str]]) -> None:
    """Print pairs of a name and a value in two columns."""
    pairs = list(facts)
    width = max((len(name) for name, _ in pairs), default=0)
    for name, value in pairs:
        say(f"{name:<{width}}  {value}")


def say_table(heads: Sequence[str], rows: Iterable[Sequence[str]], left: Sequence[str]) -> None:
    """Print a table on stdout; the columns named in `left` are set flush left and may wrap, the others flush right."""
    table = Table(box=box.SIMPLE_HEAD, show_edge=False, pad_edge=False)
    for head in heads:
        on_left = head in left
        table.add_column(head, justify="left" if on_left else "right", no_wrap=not on_left)
    for row in rows:
        table.add_row(*(Text(printable(cell)) for cell in row))
    # Outside a terminal nothing may be cut or wrapped: the next program wants whole lines.
    width = None if sys.stdout.isatty() else 10_000
    console = Console(file=sys.stdout, width=width, highlight=False, markup=False, emoji=False)
    with console.capture() as captured:
        console.print(table)
    for line in captured.get().splitlines():
        print(line.rstrip())


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
    from rich.markup import escape
    from rich.progress import Progress, SpinnerColumn, TextColumn, TimeElapsedColumn

    columns = (SpinnerColumn(), TextColumn("{task.description}"), TimeElapsedColumn())
    with Progress(*columns, console=Console(stderr=True), transient=True) as bar:
        task = bar.add_task(escape(printable(what)), total=None)
        yield lambda said: bar.update(task, description=escape(printable(f"{what}: {said}")))


def complain(message: str) -> NoReturn:
    """End the command with exit code 1 after its results were printed, and say on stderr why."""
    print(f"taut: error: {printable(message)}", file=sys.stderr)
    raise typer.Exit(1)


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
