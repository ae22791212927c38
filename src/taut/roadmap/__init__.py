"""From a FreeSpace to a Roadmap: a graph with positions on which motions are planned."""

from taut.roadmap.cells import cells_roadmap
from taut.roadmap.core import LocatedRoadmap, Roadmap
from taut.roadmap.grid import grid_roadmap
from taut.roadmap.lanes import Lanes, LanesError, LanesRoadmap, closed_lanes, grid_lanes, lanes_roadmap
from taut.roadmap.places import PlacesRoadmap, SharedRoadmap, places_roadmap, shared_roadmap
from taut.roadmap.polylines import polyline_roadmap
from taut.roadmap.sampled import sampled_roadmap
from taut.roadmap.visibility import VisibilityGraph, visibility_graph
from taut.roadmap.voronoi import VoronoiRoadmap, voronoi_roadmap

__all__ = [
    "Lanes",
    "LanesError",
    "LanesRoadmap",
    "LocatedRoadmap",
    "PlacesRoadmap",
    "Roadmap",
    "SharedRoadmap",
    "VisibilityGraph",
    "VoronoiRoadmap",
    "cells_roadmap",
    "closed_lanes",
    "grid_lanes",
    "grid_roadmap",
    "lanes_roadmap",
    "places_roadmap",
    "polyline_roadmap",
    "sampled_roadmap",
    "shared_roadmap",
    "visibility_graph",
    "voronoi_roadmap",
]
