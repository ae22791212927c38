"""Routes of single robots."""

from taut.route.core import Route
from taut.route.shortest import Attached, attach, routes_between, shortest_path, shortest_routes

__all__ = ["Attached", "Route", "attach", "routes_between", "shortest_path", "shortest_routes"]
