"""Routes of single robots."""

from taut.route.along import Joined, attached, routes_along
from taut.route.core import Route
from taut.route.direct import DirectRoute, direct_lengths, direct_paths, shortest_path
from taut.route.editing import with_obstacle, without_obstacle
from taut.route.index import PathIndex, Paths, distances, distances_from, paths, prepare
from taut.route.lazy import LazyRoute, lazy_route
from taut.route.potential import PotentialRoute, potential_at, potential_path
from taut.route.shortest import routes_between, shortest_routes
from taut.route.smoothing import smoothed
from taut.route.states import Attached, attach

__all__ = [
    "Attached",
    "DirectRoute",
    "Joined",
    "LazyRoute",
    "PathIndex",
    "Paths",
    "PotentialRoute",
    "Route",
    "attach",
    "attached",
    "direct_lengths",
    "direct_paths",
    "distances",
    "distances_from",
    "lazy_route",
    "paths",
    "potential_at",
    "potential_path",
    "prepare",
    "routes_along",
    "routes_between",
    "shortest_path",
    "shortest_routes",
    "smoothed",
    "with_obstacle",
    "without_obstacle",
]
