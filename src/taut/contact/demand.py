"""What is demanded of a team's contact: within which range, in sight or not, and how much of it may fail."""

from __future__ import annotations

import contextlib
import math
from collections.abc import Mapping
from dataclasses import dataclass
from numbers import Integral, Real

from taut.errors import SceneError


@dataclass(frozen=True)
class Contact:
    """A demand on a team at every instant: its communication graph is connected, or more.

    Two robots are in contact while their centres are at most ``reach`` apart and, with ``sight``, no obstacle and no
    wall lies between them.

    Parameters
    ----------
    reach : metres, > 0.
    sight : whether the segment between two centres must be free of obstacles.
    k : the graph stays connected when any k − 1 robots fail (k-vertex-connected; a complete graph of k + 1 or fewer
        robots counts).
    lambda2 : least Fiedler value, links weighing 1.

    Raises
    ------
    SceneError
        A value that makes no sense.

    >>> Contact(5.0, k=2).claim
    {'range': 5.0, 'sight': False, 'k': 2, 'lambda2': 0.0}
    """

    reach: float
    sight: bool = False
    k: int = 1
    lambda2: float = 0.0

    def __post_init__(self) -> None:
        for field, name in (("reach", "range"), ("lambda2", "lambda2")):
            object.__setattr__(self, field, _number(name, getattr(self, field)))
        if not self.reach > 0:
            raise SceneError(f"contact: range must be positive, got {self.reach:g}")
        if not isinstance(self.sight, bool):
            raise SceneError(f"contact: sight must be true or false, got {self.sight!r}")
        if isinstance(self.k, bool) or not isinstance(self.k, Integral) or self.k < 1:
            raise SceneError(f"contact: k must be a whole number of at least 1, got {self.k!r}")
        object.__setattr__(self, "k", int(self.k))
        if self.lambda2 < 0:
            raise SceneError(f"contact: lambda2 must be at least 0, got {self.lambda2:g}")

    @property
    def claim(self) -> dict[str, object]:
        """The demand as a plan's claim, plain data."""
        return {"range": self.reach, "sight": self.sight, "k": self.k, "lambda2": self.lambda2}


def contact_of(claim: Mapping[str, object]) -> Contact:
    """Return the demand that a plan's claim states; what it leaves out has its default.

    Raises
    ------
    SceneError
        An unknown name, no range, or a value that makes no sense.
    """
    unknown = sorted(set(claim) - {"range", "sight", "k", "lambda2"})
    if unknown:
        raise SceneError(f"contact: unknown {', '.join(map(repr, unknown))}; known are range, sight, k and lambda2")
    if "range" not in claim:
        raise SceneError("contact: range is missing")
    named = {"reach" if name == "range" else name: value for name, value in claim.items()}
    return Contact(**named)  # type: ignore[arg-type]  # its constructor checks each value


def _number(name: str, value: object) -> float:
    number = math.nan
    if isinstance(value, Real) and not isinstance(value, bool):
        with contextlib.suppress(OverflowError):
            number = float(value)
    if not math.isfinite(number):
        raise SceneError(f"contact: {name} must be a finite number, got {value!r}")
    return number
