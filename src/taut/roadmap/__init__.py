"""From a FreeSpace to a Roadmap: a graph with positions on which motions are planned."""

from taut.roadmap.core import Roadmap
from taut.roadmap.places import PlacesRoadmap, places_roadmap
from taut.roadmap.visibility import VisibilityGraph, visibility_graph

__all__ = ["PlacesRoadmap", "Roadmap", "VisibilityGraph", "places_roadmap", "visibility_graph"]
