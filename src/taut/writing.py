"""Writing files so that a reader sees the old one or the whole new one, and a failure leaves nothing behind."""

from __future__ import annotations

import contextlib
import os
import secrets
from collections.abc import Iterator
from pathlib import Path

from taut.errors import OutputError


@contextlib.contextmanager
def replacing(path: str | os.PathLike[str]) -> Iterator[Path]:
    """Give a temporary name beside `path` (same ending) to write to; rename it to `path` when the block succeeds.

    A link is followed, so that the file it points to is the one replaced.

    Raises
    ------
    OutputError
        The folder does not exist or cannot be written, `path` is a directory, a device or write-protected.
    """
    shown = os.fspath(path)
    try:
        target = Path(os.path.realpath(path))
        if target.is_dir():
            raise OutputError(f"{shown}: cannot be written: it is a directory")
        if target.exists() and not (target.is_file() and os.access(target, os.W_OK)):
            raise OutputError(f"{shown}: cannot be written: it is write-protected or not a regular file")
        temporary = target.with_name(f".{secrets.token_hex(8)}.tmp{target.suffix}")
        # created here and not by the caller, so that an unwritable folder is told before any work
        os.close(os.open(temporary, os.O_WRONLY | os.O_CREAT | os.O_EXCL, 0o666))
    except (OSError, ValueError) as error:
        raise OutputError(_refusal(shown, error)) from None
    try:
        yield temporary
        os.replace(temporary, target)
    except OSError as error:
        raise OutputError(_refusal(shown, error)) from None
    finally:
        temporary.unlink(missing_ok=True)


def write_text(path: str | os.PathLike[str], text: str) -> None:
    """Write UTF-8 text, wholly or not at all.

    Raises
    ------
    OutputError
        As `replacing`, or the text holds half a surrogate pair.
    """
    try:
        raw = text.encode("utf-8")
    except UnicodeEncodeError:
        raise OutputError(f"{os.fspath(path)}: a name holds a lone surrogate, not a character") from None
    with replacing(path) as temporary, open(temporary, "wb") as stream:
        stream.write(raw)
        stream.flush()
        os.fsync(stream.fileno())


def _refusal(shown: str, error: Exception) -> str:
    return f"{shown}: cannot be written: {getattr(error, 'strerror', None) or error}"
