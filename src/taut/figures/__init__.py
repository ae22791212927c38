"""Pictures and animations with matplotlib, drawn on figures of their own: no backend is chosen, no window opened."""

from taut.figures.album import save_stages
from taut.figures.animation import animate
from taut.figures.graphs import Portrait, draw_portraits, draw_values, save_portraits
from taut.figures.pictures import draw
from taut.figures.saving import png_bytes, save_figure, svg_text
from taut.figures.searches import animate_search, draw_step, save_steps
from taut.figures.simulation import draw_run
from taut.figures.simulation_film import animate_run
from taut.figures.spectra import draw_matrix, draw_sorted, draw_spectrum
from taut.figures.steering import draw_steered, save_steered

__all__ = [
    "Portrait",
    "animate",
    "animate_run",
    "animate_search",
    "draw",
    "draw_matrix",
    "draw_portraits",
    "draw_run",
    "draw_sorted",
    "draw_spectrum",
    "draw_steered",
    "draw_step",
    "draw_values",
    "png_bytes",
    "save_figure",
    "save_portraits",
    "save_stages",
    "save_steered",
    "save_steps",
    "svg_text",
]
