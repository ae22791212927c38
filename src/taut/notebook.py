"""Values shown as pictures in notebooks; figures are loaded when the first one is shown."""

from __future__ import annotations

from typing import Any

SHOWN = (
    ("taut.scene", "Scene"),
    ("taut.motion", "Plan"),
    ("taut.freespace", "FreeSpace"),
    ("taut.roadmap.core", "Roadmap"),
    ("taut.roadmap.visibility", "VisibilityGraph"),
    ("taut.roadmap.places", "PlacesRoadmap"),
    ("taut.route.core", "Route"),
    ("taut.route.central", "CentralRoute"),
    ("taut.route.oca", "OcaRoute"),
    ("taut.simulation.running", "Run"),
    ("taut.simulation.steering", "Steered"),
    ("taut.team.stages", "FreeSpaceStage"),
    ("taut.team.stages", "ObstacleGraphStage"),
    ("taut.team.stages", "SplitStage"),
    ("taut.team.stages", "BridgeStage"),
    ("taut.team.stages", "FirstPathStage"),
    ("taut.team.stages", "FullGraphStage"),
    ("taut.team.stages", "SequenceStage"),
)


def show_values_as_pictures(shell: Any) -> None:
    """Tell an IPython shell how to draw taut's values."""
    pictures = shell.display_formatter.formatters["image/png"]
    for module, name in SHOWN:
        pictures.for_type_by_name(module, name, _png)


def _png(value: Any) -> bytes:
    from taut.figures import png_bytes

    return png_bytes(value)
