"""Contact: what is demanded of a team's links, when they hold, and the graphs that they make over time.

The public names below are loaded when they are first used: planning needs few of them.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from taut.contact.connectivity import (
        bridges_at,
        components_at,
        cut_vertices_at,
        graph_at,
        longest_loss,
        longest_silences,
        losses,
        piece_at,
    )
    from taut.contact.core import Contacts
    from taut.contact.demand import Contact, contact_of
    from taut.contact.fading import FadingFiedler, fading_fiedler
    from taut.contact.links import contacts
    from taut.contact.nearness import NeededReach, needed_reach
    from taut.contact.outlines import sight_sides

__all__ = [
    "Contact",
    "Contacts",
    "FadingFiedler",
    "NeededReach",
    "bridges_at",
    "components_at",
    "contact_of",
    "contacts",
    "cut_vertices_at",
    "fading_fiedler",
    "graph_at",
    "longest_loss",
    "longest_silences",
    "losses",
    "needed_reach",
    "piece_at",
    "sight_sides",
]

if not TYPE_CHECKING:
    # Hidden from type checkers: with a module-level __getattr__ they would accept every misspelt name.
    _HOMES = {
        "taut.contact.connectivity": (
            "bridges_at",
            "components_at",
            "cut_vertices_at",
            "graph_at",
            "longest_loss",
            "longest_silences",
            "losses",
            "piece_at",
        ),
        "taut.contact.core": ("Contacts",),
        "taut.contact.demand": ("Contact", "contact_of"),
        "taut.contact.fading": ("FadingFiedler", "fading_fiedler"),
        "taut.contact.links": ("contacts",),
        "taut.contact.nearness": ("NeededReach", "needed_reach"),
        "taut.contact.outlines": ("sight_sides",),
    }
    _HOME_OF = {name: home for home, names in _HOMES.items() for name in names}

    def __getattr__(name: str) -> object:
        import importlib

        if name not in _HOME_OF:
            raise AttributeError(f"module 'taut.contact' has no attribute {name!r}")
        value = getattr(importlib.import_module(_HOME_OF[name]), name)
        globals()[name] = value
        return value

    def __dir__() -> list[str]:
        return sorted({*globals(), *__all__})
