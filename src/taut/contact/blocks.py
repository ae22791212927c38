"""Blocks of pieces, to decide on all pieces at once what is asked of each.

A graph that has only the links that last throughout a block is part of every graph of it. Where that suffices, the
block needs no closer look; else its halves do.
"""

from __future__ import annotations

from collections.abc import Iterator
from itertools import pairwise
from typing import NamedTuple

import numpy as np

from taut.contact.core import Contacts, Ints


class Block(NamedTuple):
    """Pieces first … last − 1, all of the same robots, and the links that any of them has.

    Attributes
    ----------
    robots : (n,) those that are there.
    pairs : (l, 2) links, by the places of robots in ``robots``; a pair may come several times.
    spans : (l, 2) the pieces that have the link: the first, and the one after the last.
    """

    first: int
    last: int
    robots: Ints
    pairs: Ints
    spans: Ints

    @property
    def n(self) -> int:
        """Number of robots."""
        return len(self.robots)

    @property
    def throughout(self) -> Ints:
        """(k, 2) the links that all of the pieces have."""
        lasting = (self.spans[:, 0] <= self.first) & (self.spans[:, 1] >= self.last)
        return np.asarray(self.pairs[lasting])

    @property
    def halves(self) -> list[Block]:
        """The earlier and the later half of the pieces."""
        middle = (self.first + self.last) // 2
        return [_part(self, self.first, middle), _part(self, middle, self.last)]


def epochs(contacts: Contacts) -> Iterator[Block]:
    """Yield the blocks between the instants at which robots leave."""
    left = np.searchsorted(contacts.times, contacts.gone[np.isfinite(contacts.gone)])
    borders = np.unique(np.concatenate([[0], left, [len(contacts.times)]])).astype(np.int64)
    whole = Block(0, len(contacts.times), np.arange(len(contacts.names)), contacts.pairs, contacts.spans)
    for first, last in pairwise(borders.tolist()):
        there = contacts.gone > contacts.times[first]
        number = np.cumsum(there) - 1
        part = _part(whole, first, last)
        yield part._replace(robots=np.flatnonzero(there), pairs=number[part.pairs])


def _part(block: Block, first: int, last: int) -> Block:
    here = (block.spans[:, 0] < last) & (block.spans[:, 1] > first)
    return Block(first, last, block.robots, block.pairs[here], block.spans[here])
