"""Route: the path of one robot, without time."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from taut.scene import FloatArray


@dataclass(frozen=True, eq=False)
class Route:
    """A polyline through free space.

    Parameters
    ----------
    points : (k, 2) metres, from start to goal; one row if they are the same place.
    """

    points: FloatArray

    @property
    def length(self) -> float:
        """Metres."""
        return float(np.hypot(*np.diff(self.points, axis=0).T).sum())
