"""Contacts: who is in contact with whom, when, and the graphs between the instants at which that changes."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from taut.contact.spectra import fiedler_values
from taut.scene import FloatArray

Ints = NDArray[np.int64]
Flags = NDArray[np.bool_]


@dataclass(frozen=True, eq=False)
class Contacts:
    """The contacts of a team over all time; see `contacts`.

    Stretches of contact are closed. Between two neighbouring ``times`` the graph does not change: that is a piece. At
    the instant between two pieces it has the links of both, and links that last for that instant only are not listed.

    Parameters
    ----------
    names : of the n robots, in the scene's order.
    reach : metres.
    sight : whether obstacles break contact.
    pairs : (l, 2) robots i < j of each stretch, sorted by its begin, then the pair.
    begins, ends : (l,) seconds of each stretch; ends at inf if it lasts for ever.
    gone : (n,) seconds from which a robot is no more there; inf if it stays.
    until : seconds; nothing changes after.
    times : (m,) begin of each piece, from 0 on; a piece ends where the next begins, and the last lasts for ever.
    """

    names: tuple[str, ...]
    reach: float
    sight: bool
    pairs: Ints
    begins: FloatArray
    ends: FloatArray
    gone: FloatArray
    until: float
    times: FloatArray

    @property
    def present(self) -> Flags:
        """(m, n) whether each robot is there during each piece: those that leave are gone from their arrival on."""
        return np.asarray(self.gone > self.times[:, None], dtype=np.bool_)

    @property
    def spans(self) -> Ints:
        """(l, 2) the pieces of each stretch: the first, and the one after the last."""
        return np.stack(
            [np.searchsorted(self.times, self.begins), np.searchsorted(self.times, self.ends)], axis=1
        ).astype(np.int64)

    @cached_property
    def fiedler(self) -> FloatArray:
        """(m,) λ2 of the robots present during each piece, links weighing 1; 0 for fewer than two robots.

        Exactly 0 where they are not connected. Takes O(n³) for each graph that differs from the others.
        """
        return fiedler_values(self.present, self.pairs, self.spans)

    @property
    def worst(self) -> tuple[float, float]:
        """Time at which λ2 is least for the first time, in the middle of its piece, and λ2 there.

        Pieces with fewer than two robots do not count; with no others it is (0.0, 0.0).
        """
        counted = np.flatnonzero(self.present.sum(axis=1) > 1)
        if not counted.size:
            return 0.0, 0.0
        piece = int(counted[np.argmin(self.fiedler[counted])])
        return self.middle(piece), float(self.fiedler[piece])

    def middle(self, piece: int) -> float:
        """Middle of a piece, seconds; of the last, which has none, the end of all motion or a second from its begin."""
        if piece + 1 < len(self.times):
            return float((self.times[piece] + self.times[piece + 1]) / 2)
        begin = float(self.times[piece])
        return self.until if self.until > begin else begin + 1.0
