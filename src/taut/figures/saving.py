"""Pictures as files and as bytes."""

from __future__ import annotations

import io
import os
import warnings
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING, Any

import matplotlib as mpl
from matplotlib.axes import Axes

from taut.errors import OutputError
from taut.figures.pictures import draw
from taut.writing import replacing

if TYPE_CHECKING:
    from taut.contact import Contact

#: What each picture format must not contain, so that the same picture is the same file.
NO_STAMPS: dict[str, dict[str, None]] = {
    "png": {"Software": None},
    "svg": {"Date": None},
    "pdf": {"CreationDate": None, "Creator": None, "Producer": None},
}


def save_figure(
    value: Any,
    path: str | os.PathLike[str],
    *,
    graph: Any = None,
    routes: Mapping[str, Any] | None = None,
    contact: Contact | float | None = None,
) -> None:
    """Draw a value (see `draw`) into a .png (200 dpi), .svg or .pdf file.

    The same value gives the same bytes. The file is written beside its place and then renamed.

    Raises
    ------
    OutputError
        Another extension, or a place that cannot be written.
    """
    target = Path(path)
    kind = check_kind(target, tuple(NO_STAMPS), "pictures are written as")
    with replacing(target) as scratch:
        scratch.write_bytes(picture_bytes(draw(value, graph=graph, routes=routes, contact=contact), kind, 200))


def png_bytes(value: Any) -> bytes:
    """Return the picture of a value (see `draw`) as a PNG of the size of a notebook."""
    return picture_bytes(draw(value), "png", 110)


def svg_text(value: Any) -> str:
    """Return the picture of a value (see `draw`) as SVG."""
    return picture_bytes(draw(value), "svg", 72).decode("utf-8")


def picture_bytes(axes: Axes, kind: str, dpi: int) -> bytes:
    """Return the figure of these axes as a file of a kind of `NO_STAMPS`; the same figure is the same bytes."""
    buffer = io.BytesIO()
    figure = axes.get_figure(root=True)
    assert figure is not None
    with any_letters(), mpl.rc_context({"svg.hashsalt": "taut", "svg.fonttype": "path", "pdf.fonttype": 42}):
        figure.savefig(buffer, format=kind, dpi=dpi, metadata=NO_STAMPS[kind])
    return buffer.getvalue()


def check_kind(path: Path, kinds: tuple[str, ...], what: str) -> str:
    """Return the lower-case extension of the path without its dot.

    Raises
    ------
    OutputError
        It is not one of `kinds`.
    """
    kind = path.suffix.lower().removeprefix(".")
    if kind not in kinds:
        names = ", ".join("." + k for k in kinds[:-1]) + f" or .{kinds[-1]}"
        raise OutputError(f"{path}: {what} {names}, not {path.suffix or 'a file without extension'}")
    return kind


@contextmanager
def any_letters() -> Iterator[None]:
    """Let names hold letters that the font lacks: they are drawn as boxes, without a warning for each."""
    with warnings.catch_warnings():
        warnings.filterwarnings("ignore", message="Glyph .* missing from")
        yield
