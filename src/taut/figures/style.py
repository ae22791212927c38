"""Colours and weights of every figure, in one place."""

from __future__ import annotations

from typing import TypeAlias

import numpy as np
from matplotlib.colors import to_hex, to_rgb

from taut.scene import FloatArray

Colour: TypeAlias = str

INK: Colour = "#26292e"
QUIET: Colour = "#69717b"
OUTSIDE: Colour = "#e9ebee"
WORKSPACE: Colour = "#ffffff"
WALL: Colour = "#4d555f"
OBSTACLE: Colour = "#7ea6d8"
OBSTACLE_EDGE: Colour = "#2f5e9e"
GROWN: Colour = "#dfe9f6"
GRAPH: Colour = "#a3abb5"
START: Colour = "#d7263d"
GOAL: Colour = "#17913f"
LINK: Colour = "#64748b"  # slate: no robot has it
BRIDGE: Colour = "#d7263d"
APART: Colour = "#f4c2c8"

#: One hue a robot, told apart also by people with protanopia, deuteranopia or tritanopia.
HUES: tuple[Colour, ...] = (
    "#e08e00",  # orange
    "#332288",  # indigo
    "#c2188b",  # magenta
    "#009e73",  # bluish green
    "#222222",  # black
    "#3ba3d8",  # sky
    "#5a3215",  # chocolate
    "#cc79a7",  # pink
    "#5f7a1f",  # moss
    "#0072b2",  # blue
)

#: After the ten hues come the same hues lighter and darker: (towards, share).
STEPS: tuple[tuple[Colour, float], ...] = (("#ffffff", 0.0), ("#ffffff", 0.38), ("#000000", 0.38))


def mix(colour: Colour, other: Colour, share: float) -> Colour:
    """Return `colour` with `share` (0 to 1) of `other` in it, as #rrggbb.

    >>> mix("#000000", "#ffffff", 0.2)
    '#333333'
    """
    a, b = np.array(to_rgb(colour)), np.array(to_rgb(other))
    return to_hex(a + (b - a) * share)


def robot_colours(n: int) -> list[Colour]:
    """Return one colour a robot, n of them: ten hues, then lightness steps, then again from the first.

    >>> robot_colours(2)
    ['#e08e00', '#332288']
    """
    cycle = [mix(hue, towards, share) for towards, share in STEPS for hue in HUES]
    return [cycle[k % len(cycle)] for k in range(n)]


def darker(colour: Colour) -> Colour:
    """Return the colour dark enough to be read as small text on white.

    >>> darker("#222222")
    '#222222'
    """
    shade = colour
    while _contrast_with_white(shade) < 4.5:
        shade = mix(shade, "#000000", 0.1)
    return shade


def _contrast_with_white(colour: Colour) -> float:
    channels: FloatArray = np.array(to_rgb(colour))
    linear = np.where(channels <= 0.04045, channels / 12.92, ((channels + 0.055) / 1.055) ** 2.4)
    return 1.05 / (float(linear @ [0.2126, 0.7152, 0.0722]) + 0.05)
