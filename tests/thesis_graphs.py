"""The graphs that the thesis draws and prints numbers of, as plain data; vertices are counted from 0.

``EDGES_*`` maps pairs of vertices to weights.
"""

from __future__ import annotations

from taut.graph import Graph

_TABLE_4_1 = {
    1: {2: 8, 3: 7, 4: 3, 5: 9, 6: 6, 7: 8},
    2: {3: 7, 4: 9, 5: 7, 7: 2},
    3: {4: 8, 5: 9, 6: 1},
    4: {5: 5, 6: 8, 7: 6, 8: 7, 11: 4},
    5: {7: 6, 9: 7},
    6: {8: 8, 10: 9, 12: 6},
    7: {8: 4, 9: 8, 11: 8, 13: 3},
    8: {9: 9, 10: 4, 11: 8, 12: 7, 15: 6},
    9: {11: 3, 13: 8},
    10: {11: 3, 12: 5, 14: 7},
    11: {12: 4, 13: 8, 15: 6, 16: 3},
    12: {14: 5, 15: 7, 16: 3},
    13: {15: 8, 16: 5},
    14: {15: 9, 16: 7},
    15: {16: 6},
}

EDGES_4_2 = {(i - 1, j - 1): float(w) for i, row in _TABLE_4_1.items() for j, w in row.items()}
"""Figure 4.2: the 49 edges of table 4.1, in its order, with the weights of matrix (4.5).

Matrix (4.5) also has a 5 between vertices 7 and 10, an edge that table 4.1 does not list.
"""

NAMES_4_2 = {f"e{k}": edge for k, edge in enumerate(EDGES_4_2, start=1)}
"""Edges of figure 4.2 by their names e1 … e49 (the table names e12 e10)."""

SPECTRUM_4_2 = (
    0.0, 7.6143, 17.9264, 21.3275, 32.4816, 35.0564, 36.3646, 38.8115,
    41.8012, 43.7309, 44.2198, 50.8069, 53.2039, 58.0177, 61.1491, 65.4882,
)  # fmt: skip
"""Table 4.2."""

EDGES_8_1 = {
    (0, 1): 1.0, (0, 2): 1.0, (0, 4): 1.0, (1, 2): 1.0, (1, 4): 1.0, (2, 4): 1.0, (3, 4): 1.0,
}  # fmt: skip
"""Figure 8.1: A to E are 0 to 4."""

EDGES_8_17_SMALLEST = {(0, 1): 1.0, (1, 2): 1.0, (2, 3): 1.0, (3, 4): 1.0}
"""Figure 8.17 (1): four edges on five vertices; the text gives their number only, here they are a path."""

EDGES_8_17_LARGEST = {(i, j): 1.0 for i in range(5) for j in range(i + 1, 5)}
"""Figure 8.17 (6): all ten edges on five vertices."""

EDGES_8_19 = {
    (0, 1): 7.0, (0, 2): 9.0, (0, 5): 14.0, (1, 2): 10.0, (1, 3): 15.0,
    (2, 3): 11.0, (2, 5): 2.0, (3, 4): 6.0, (4, 5): 9.0,
}  # fmt: skip
"""Figure 8.19."""


def graph_of(edges: dict[tuple[int, int], float]) -> Graph:
    """Build the graph of one of the dicts above."""
    return Graph.from_edges(1 + max(max(edge) for edge in edges), list(edges), list(edges.values()))


def figure_4_2(without: tuple[str, ...] = ()) -> Graph:
    """Build the graph of figure 4.2, some edges left out by name."""
    gone = {NAMES_4_2[name] for name in without}
    kept = {edge: weight for edge, weight in EDGES_4_2.items() if edge not in gone}
    return Graph.from_edges(16, list(kept), list(kept.values()))
