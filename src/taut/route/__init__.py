"""Routes of single robots."""

from taut.route.core import Route
from taut.route.shortest import shortest_path, shortest_routes

__all__ = ["Route", "shortest_path", "shortest_routes"]
