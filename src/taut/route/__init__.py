"""Routes of single robots."""

from taut.route.along import Joined, attached, routes_along
from taut.route.central import CentralRoute, NoCentralPath, central_path
from taut.route.core import Route
from taut.route.direct import DirectRoute, direct_lengths, direct_paths, shortest_path
from taut.route.editing import with_obstacle, without_obstacle
from taut.route.hits import Hit, hits_of
from taut.route.index import PathIndex, Paths, distances, distances_from, paths, prepare
from taut.route.lazy import LazyRoute, lazy_route
from taut.route.obstacles import ObstacleIndex, index_obstacles
from taut.route.oca import OcaRound, OcaRoute, oca_between, oca_path, oca_path_or_widest
from taut.route.passage import Passage, widest_passage
from taut.route.potential import PotentialRoute, potential_at, potential_path
from taut.route.shortest import routes_between, shortest_routes
from taut.route.smoothing import smoothed
from taut.route.states import Attached, attach
from taut.route.ways import WAYS, Answer, Prepared, Way
from taut.route.widest import WidestRoute, widest_routes

__all__ = [
    "WAYS",
    "Answer",
    "Attached",
    "CentralRoute",
    "DirectRoute",
    "Hit",
    "Joined",
    "LazyRoute",
    "NoCentralPath",
    "ObstacleIndex",
    "OcaRound",
    "OcaRoute",
    "Passage",
    "PathIndex",
    "Paths",
    "PotentialRoute",
    "Prepared",
    "Route",
    "Way",
    "WidestRoute",
    "attach",
    "attached",
    "central_path",
    "direct_lengths",
    "direct_paths",
    "distances",
    "distances_from",
    "hits_of",
    "index_obstacles",
    "lazy_route",
    "oca_between",
    "oca_path",
    "oca_path_or_widest",
    "paths",
    "potential_at",
    "potential_path",
    "prepare",
    "routes_along",
    "routes_between",
    "shortest_path",
    "shortest_routes",
    "smoothed",
    "widest_passage",
    "widest_routes",
    "with_obstacle",
    "without_obstacle",
]
