"""Graphs and pure graph theory; knows nothing of maps or robots."""

from taut.graph.bridging import Addition, best_edges, connectivity_with, connectivity_without, with_edge
from taut.graph.components import components, connected, cut_edges, cut_vertices
from taut.graph.core import Graph
from taut.graph.matrices import adjacency, beta_index, degree, degrees, incidence, laplacian, normalised_laplacian
from taut.graph.search import astar, astar_between, dijkstra, path_to
from taut.graph.spectrum import Eigenpairs, algebraic_connectivity, eigenpairs, fiedler_vector, spectrum
from taut.graph.splitting import contracted, gathered, in_one_piece, split
from taut.graph.weights import WEIGHTS, Weight, contact_graph, distance, exponential, fading, one, weighted

__all__ = [
    "WEIGHTS",
    "Addition",
    "Eigenpairs",
    "Graph",
    "Weight",
    "adjacency",
    "algebraic_connectivity",
    "astar",
    "astar_between",
    "best_edges",
    "beta_index",
    "components",
    "connected",
    "connectivity_with",
    "connectivity_without",
    "contact_graph",
    "contracted",
    "cut_edges",
    "cut_vertices",
    "degree",
    "degrees",
    "dijkstra",
    "distance",
    "eigenpairs",
    "exponential",
    "fading",
    "fiedler_vector",
    "gathered",
    "in_one_piece",
    "incidence",
    "laplacian",
    "normalised_laplacian",
    "one",
    "path_to",
    "spectrum",
    "split",
    "weighted",
    "with_edge",
]
