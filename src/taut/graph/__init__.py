"""Graphs and pure graph theory; knows nothing of maps or robots.

The public names below are loaded when they are first used: planning needs few of them.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from taut.graph.bounds import Bound, IsoperimetricBounds, connectivity_bounds, isoperimetric_bounds
    from taut.graph.bridging import Addition, best_edges, connectivity_with, connectivity_without, with_edge
    from taut.graph.connectedness import components, connected, cut_edges, cut_vertices
    from taut.graph.conversion import from_networkx, load_graphml, save_graphml, to_networkx
    from taut.graph.core import Graph
    from taut.graph.labels import (
        HubLabels,
        hub_labels,
        label_distances,
        label_distances_between,
        label_path,
        label_paths,
    )
    from taut.graph.matrices import adjacency, beta_index, degree, degrees, incidence, laplacian, normalised_laplacian
    from taut.graph.resistance import effective_resistance, kirchhoff_index, resistance_matrix
    from taut.graph.rigidity import (
        generic_globally_rigid,
        generic_minimally_rigid,
        generic_rank,
        generic_redundantly_rigid,
        generic_rigid,
        independent_edges,
        infinitesimal_motions,
        infinitesimally_rigid,
        redundant_edges,
        rigidity_matrix,
        vertex_connected,
    )
    from taut.graph.search import astar, astar_between, astar_many, breadth_first, depth_first, dijkstra, path_to
    from taut.graph.spectral import Eigenpairs, algebraic_connectivity, eigenpairs, fiedler_vector, spectrum
    from taut.graph.splitting import contracted, gathered, in_one_piece, split
    from taut.graph.tracing import State, Step, Trace, tell, trace
    from taut.graph.trees import log_spanning_tree_count, maximum_spanning_tree, spanning_tree, spanning_tree_count
    from taut.graph.weights import WEIGHTS, Weight, contact_graph, distance, exponential, fading, one, weighted

__all__ = [
    "WEIGHTS",
    "Addition",
    "Bound",
    "Eigenpairs",
    "Graph",
    "HubLabels",
    "IsoperimetricBounds",
    "State",
    "Step",
    "Trace",
    "Weight",
    "adjacency",
    "algebraic_connectivity",
    "astar",
    "astar_between",
    "astar_many",
    "best_edges",
    "beta_index",
    "breadth_first",
    "components",
    "connected",
    "connectivity_bounds",
    "connectivity_with",
    "connectivity_without",
    "contact_graph",
    "contracted",
    "cut_edges",
    "cut_vertices",
    "degree",
    "degrees",
    "depth_first",
    "dijkstra",
    "distance",
    "effective_resistance",
    "eigenpairs",
    "exponential",
    "fading",
    "fiedler_vector",
    "from_networkx",
    "gathered",
    "generic_globally_rigid",
    "generic_minimally_rigid",
    "generic_rank",
    "generic_redundantly_rigid",
    "generic_rigid",
    "hub_labels",
    "in_one_piece",
    "incidence",
    "independent_edges",
    "infinitesimal_motions",
    "infinitesimally_rigid",
    "isoperimetric_bounds",
    "kirchhoff_index",
    "label_distances",
    "label_distances_between",
    "label_path",
    "label_paths",
    "laplacian",
    "load_graphml",
    "log_spanning_tree_count",
    "maximum_spanning_tree",
    "normalised_laplacian",
    "one",
    "path_to",
    "redundant_edges",
    "resistance_matrix",
    "rigidity_matrix",
    "save_graphml",
    "spanning_tree",
    "spanning_tree_count",
    "spectrum",
    "split",
    "tell",
    "to_networkx",
    "trace",
    "vertex_connected",
    "weighted",
    "with_edge",
]

if not TYPE_CHECKING:
    # Hidden from type checkers: with a module-level __getattr__ they would accept every misspelt name.
    _HOMES = {
        "taut.graph.bounds": ("Bound", "IsoperimetricBounds", "connectivity_bounds", "isoperimetric_bounds"),
        "taut.graph.bridging": ("Addition", "best_edges", "connectivity_with", "connectivity_without", "with_edge"),
        "taut.graph.connectedness": ("components", "connected", "cut_edges", "cut_vertices"),
        "taut.graph.conversion": ("from_networkx", "load_graphml", "save_graphml", "to_networkx"),
        "taut.graph.core": ("Graph",),
        "taut.graph.labels": (
            "HubLabels",
            "hub_labels",
            "label_distances",
            "label_distances_between",
            "label_path",
            "label_paths",
        ),
        "taut.graph.matrices": (
            "adjacency",
            "beta_index",
            "degree",
            "degrees",
            "incidence",
            "laplacian",
            "normalised_laplacian",
        ),
        "taut.graph.resistance": ("effective_resistance", "kirchhoff_index", "resistance_matrix"),
        "taut.graph.rigidity": (
            "generic_globally_rigid",
            "generic_minimally_rigid",
            "generic_rank",
            "generic_redundantly_rigid",
            "generic_rigid",
            "independent_edges",
            "infinitesimal_motions",
            "infinitesimally_rigid",
            "redundant_edges",
            "rigidity_matrix",
            "vertex_connected",
        ),
        "taut.graph.search": (
            "astar",
            "astar_between",
            "astar_many",
            "breadth_first",
            "depth_first",
            "dijkstra",
            "path_to",
        ),
        "taut.graph.spectral": ("Eigenpairs", "algebraic_connectivity", "eigenpairs", "fiedler_vector", "spectrum"),
        "taut.graph.splitting": ("contracted", "gathered", "in_one_piece", "split"),
        "taut.graph.tracing": ("State", "Step", "Trace", "tell", "trace"),
        "taut.graph.trees": (
            "log_spanning_tree_count",
            "maximum_spanning_tree",
            "spanning_tree",
            "spanning_tree_count",
        ),
        "taut.graph.weights": (
            "WEIGHTS",
            "Weight",
            "contact_graph",
            "distance",
            "exponential",
            "fading",
            "one",
            "weighted",
        ),
    }
    _HOME_OF = {name: home for home, names in _HOMES.items() for name in names}

    def __getattr__(name: str) -> object:
        import importlib

        if name not in _HOME_OF:
            raise AttributeError(f"module 'taut.graph' has no attribute {name!r}")
        value = getattr(importlib.import_module(_HOME_OF[name]), name)
        globals()[name] = value
        return value

    def __dir__() -> list[str]:
        return sorted({*globals(), *__all__})
