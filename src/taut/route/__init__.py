"""Routes of single robots."""

from taut.route.core import Route
from taut.route.direct import DirectRoute, direct_lengths, direct_paths, shortest_path
from taut.route.editing import with_obstacle, without_obstacle
from taut.route.index import PathIndex, Paths, distances, distances_from, paths, prepare
from taut.route.shortest import routes_between, shortest_routes
from taut.route.states import Attached, attach

__all__ = [
    "Attached",
    "DirectRoute",
    "PathIndex",
    "Paths",
    "Route",
    "attach",
    "direct_lengths",
    "direct_paths",
    "distances",
    "distances_from",
    "paths",
    "prepare",
    "routes_between",
    "shortest_path",
    "shortest_routes",
    "with_obstacle",
    "without_obstacle",
]
