"""Tables on stdout: side by side where the terminal is wide enough, otherwise so that still nothing is lost."""

from __future__ import annotations

import shutil
import sys
import textwrap
from collections.abc import Iterable, Sequence

from rich.cells import cell_len

from taut.cli.output import printable, say

_BETWEEN = "   "
_READABLE = 40  # columns that the words at the end of a row get beside the row, or they go under it
_INDENT = "    "


def say_table(heads: Sequence[str], rows: Iterable[Sequence[str]], left: Sequence[str]) -> None:
    """Print a table on stdout; nothing is ever cut.

    Where the terminal is too narrow, the last column goes under the rows if it holds words, and if that is not enough
    every row is told line by line.

    Parameters
    ----------
    heads : of the columns; the first names the row.
    rows : one text a column.
    left : heads of the columns of words, set flush left; the others are set flush right.
    """
    cells = [[printable(cell) for cell in row] for row in rows]
    widths = [max(map(cell_len, column)) for column in zip(heads, *cells, strict=True)]
    # Outside a terminal nothing may be wrapped: the next program wants whole lines.
    room = shutil.get_terminal_size().columns if sys.stdout.isatty() else sys.maxsize
    on_left = [head in left for head in heads]
    beside = sum(widths[:-1]) + len(_BETWEEN) * (len(widths) - 1)  # where the last column begins
    if beside + widths[-1] <= room:
        _say_rows(heads, cells, widths, on_left)
    elif on_left[-1] and beside + _READABLE <= room:
        _say_rows(heads, cells, [*widths[:-1], room - beside], on_left)
    elif on_left[-1] and beside - len(_BETWEEN) <= room:
        _say_rows(heads[:-1], [row[:-1] for row in cells], widths[:-1], on_left, [row[-1] for row in cells], room)
    else:
        _say_lists(heads, cells, room)


def _say_rows(
    heads: Sequence[str],
    rows: Sequence[Sequence[str]],
    widths: Sequence[int],
    on_left: Sequence[bool],
    below: Sequence[str] = (),
    room: int = 0,
) -> None:
    """Print rows side by side, the last column wrapped to its width, and under each what belongs `below` it."""
    lines = [[head] for head in heads]
    _say_row(lines, widths, on_left)
    say("─" * (sum(widths) + len(_BETWEEN) * (len(widths) - 1)))
    for k, row in enumerate(rows):
        lines = [[cell] for cell in row[:-1]] + [_wrapped(row[-1], widths[-1])]
        _say_row(lines, widths, on_left)
        if below:
            _say_under(below[k], room)


def _say_row(lines: Sequence[Sequence[str]], widths: Sequence[int], on_left: Sequence[bool]) -> None:
    for k in range(max(map(len, lines))):
        texts = [column[k] if k < len(column) else "" for column in lines]
        say(_BETWEEN.join(map(_padded, texts, widths, on_left)).rstrip())


def _say_lists(heads: Sequence[str], rows: Sequence[Sequence[str]], room: int) -> None:
    """Print each row as its name and a line for each of its facts."""
    for name, *facts in rows:
        say(f"{heads[0]} {name}")
        for head, fact in zip(heads[1:], facts, strict=True):
            if fact:
                _say_under(f"{head}: {fact}", room)


def _say_under(words: str, room: int) -> None:
    for line in _wrapped(words, room - len(_INDENT)) if words else []:
        say(_INDENT + line)


def _wrapped(text: str, width: int) -> list[str]:
    """Return the text in lines of at most that width; words that are longer stay whole."""
    if cell_len(text) <= width:
        return [text]
    return textwrap.wrap(text, max(width, 1), break_long_words=False, break_on_hyphens=False)


def _padded(text: str, width: int, on_left: bool) -> str:
    blank = " " * (width - cell_len(text))
    return text + blank if on_left else blank + text
