"""From a FreeSpace to a Roadmap: a graph with positions on which motions are planned."""

from taut.roadmap.core import LocatedRoadmap, Roadmap
from taut.roadmap.places import PlacesRoadmap, SharedRoadmap, places_roadmap, shared_roadmap
from taut.roadmap.polylines import polyline_roadmap
from taut.roadmap.visibility import VisibilityGraph, visibility_graph

__all__ = [
    "LocatedRoadmap",
    "PlacesRoadmap",
    "Roadmap",
    "SharedRoadmap",
    "VisibilityGraph",
    "places_roadmap",
    "polyline_roadmap",
    "shared_roadmap",
    "visibility_graph",
]
