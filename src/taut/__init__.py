"""taut: certified motion plans for robot teams on 2D maps."""
