"""In a notebook values are shown as pictures, and figures are not loaded before."""

from __future__ import annotations

from collections.abc import Callable
from types import SimpleNamespace
from typing import Any

from taut.notebook import SHOWN, show_values_as_pictures
from taut.scene import Scene


class Formatter:
    """What taut needs of an IPython formatter."""

    def __init__(self) -> None:
        self.known: dict[tuple[str, str], Callable[[Any], bytes]] = {}

    def for_type_by_name(self, module: str, name: str, function: Callable[[Any], bytes]) -> None:
        """Remember how to draw a type."""
        self.known[module, name] = function


def test_a_shell_learns_to_draw_scenes() -> None:
    formatter = Formatter()
    show_values_as_pictures(SimpleNamespace(display_formatter=SimpleNamespace(formatters={"image/png": formatter})))
    picture = formatter.known["taut.scene", "Scene"](Scene((0, 0, 4, 3)))
    assert picture.startswith(b"\x89PNG")


def test_every_named_type_exists() -> None:
    for module, name in SHOWN:
        assert isinstance(getattr(__import__(module, fromlist=[name]), name), type)
