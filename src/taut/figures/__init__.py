"""Pictures and animations with matplotlib, drawn on figures of their own: no backend is chosen, no window opened."""

from taut.figures.animation import animate
from taut.figures.pictures import draw
from taut.figures.saving import png_bytes, save_figure, svg_text

__all__ = ["animate", "draw", "png_bytes", "save_figure", "svg_text"]
