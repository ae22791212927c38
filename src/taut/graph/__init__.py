"""Graphs and pure graph theory; knows nothing of maps or robots."""

from taut.graph.core import Graph
from taut.graph.search import astar, astar_between, dijkstra, path_to

__all__ = ["Graph", "astar", "astar_between", "dijkstra", "path_to"]
