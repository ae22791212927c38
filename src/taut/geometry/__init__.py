"""The plane: predicates, growth, triangulation, seeing. Knows nothing of robots."""
