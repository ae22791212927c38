"""How a team holds together over time: its graph on each piece, when it falls apart, how much of it may fail."""

from __future__ import annotations

import heapq
from collections.abc import Callable
from typing import TypeAlias

import numpy as np

from taut.contact._strength_kernels import parts, strongly_connected
from taut.contact.blocks import Block, epochs
from taut.contact.core import Contacts, Ints
from taut.contact.spectra import fiedler_of_each, one_thread
from taut.graph import Graph, cut_edges, cut_vertices
from taut.scene import FloatArray

Holds: TypeAlias = Callable[[int, Ints], bool]
"""Says of a number of robots and their links (m, 2) whether they hold together; more links never make it untrue."""


def piece_at(contacts: Contacts, time: float) -> int:
    """Piece in which a time lies; of two that meet there, the later.

    Raises
    ------
    ValueError
        The time is negative or not a number.
    """
    if not time >= 0:
        raise ValueError(f"a plan begins at 0 s; there is nothing at {time} s")
    return int(np.searchsorted(contacts.times, time, side="right")) - 1


def graph_at(contacts: Contacts, piece: int) -> Graph:
    """Communication graph during a piece: vertex r is robot r, weights are 1; robots that have left have no links.

    Raises
    ------
    IndexError
        There is no such piece.
    """
    count = len(contacts.times)
    if not 0 <= piece < count:
        raise IndexError(f"there is no piece {piece}; the pieces are 0 … {count - 1}")
    time = contacts.times[piece]
    return Graph.from_edges(len(contacts.names), contacts.pairs[(contacts.begins <= time) & (time < contacts.ends)])


def robots_at(contacts: Contacts, piece: int) -> Ints:
    """(k,) the robots, ascending, that are there during a piece."""
    return np.flatnonzero(contacts.gone > contacts.times[piece])


def components_at(contacts: Contacts, piece: int) -> Ints:
    """(n,) the part of the team that each robot belongs to, from 0 in the order of the first robots; −1: it has left.

    Raises
    ------
    IndexError
        There is no such piece.
    """
    pairs = graph_at(contacts, piece).edges
    there = robots_at(contacts, piece)
    out = np.full(len(contacts.names), -1, dtype=np.int64)
    out[there] = parts(len(there), np.searchsorted(there, pairs))
    return out


def cut_vertices_at(contacts: Contacts, piece: int) -> Ints:
    """(c,) the robots, ascending, each of which alone holds parts of the team together during a piece.

    Raises
    ------
    IndexError
        There is no such piece.
    """
    return cut_vertices(graph_at(contacts, piece))


def bridges_at(contacts: Contacts, piece: int) -> Ints:
    """(b, 2) the links i < j, sorted, each of which alone holds parts of the team together during a piece.

    Raises
    ------
    IndexError
        There is no such piece.
    """
    return cut_edges(graph_at(contacts, piece))


def losses(contacts: Contacts) -> FloatArray:
    """(q, 2) the stretches of time in which the team is not connected, as [from, until] in seconds; until may be inf.

    Open at their ends, where the team is connected, except at 0 and where a robot leaves.
    """
    return stretches(contacts, failing_pieces(contacts, connected))


def longest_loss(contacts: Contacts) -> tuple[float, float] | None:
    """Return the longest stretch of time in which the team is not connected; the first of equals, None if none."""
    lost = losses(contacts)
    if not len(lost):
        return None
    begin, end = lost[np.argmax(lost[:, 1] - lost[:, 0])].tolist()
    return begin, end


def longest_silences(contacts: Contacts) -> FloatArray:
    """(n,) the longest time that each robot has no link while it is there, seconds; inf for a robot alone for ever."""
    n = len(contacts.names)
    robot = np.concatenate([contacts.pairs[:, 0], contacts.pairs[:, 1], np.arange(n)])
    begins = np.concatenate([contacts.begins, contacts.begins, contacts.gone])
    ends = np.concatenate([contacts.ends, contacts.ends, contacts.gone])
    out = np.zeros(n)
    order = np.lexsort((begins, robot))
    for own in np.split(order, np.cumsum(np.bincount(robot, minlength=n))[:-1]) if n else []:
        heard = np.maximum.accumulate(np.concatenate([[0.0], ends[own]]))
        with np.errstate(invalid="ignore"):  # inf − inf: in touch for ever
            silent = begins[own] - heard[:-1]
        out[robot[own[0]]] = max(float(np.nan_to_num(silent, nan=0.0, posinf=np.inf).max()), 0.0)
    return out


def connected(n: int, pairs: Ints) -> bool:
    """Whether n robots with these links (m, 2) are connected; one or none is.

    >>> connected(3, np.array([[0, 1], [1, 2]]))
    True
    """
    return not parts(n, np.ascontiguousarray(pairs)).any()


def k_connected(n: int, pairs: Ints, k: int) -> bool:
    """Whether n robots with these links (m, 2) stay connected when any k − 1 of them fail.

    Where there are k + 1 robots or fewer they must all be linked with each other. A link may be given twice.

    >>> k_connected(4, np.array([[0, 1], [1, 2], [2, 3], [0, 3]]), 2)
    True
    """
    if k == 1:
        return connected(n, pairs)
    links = np.unique(np.sort(pairs, axis=1), axis=0)
    if n <= k + 1:
        return len(links) == n * (n - 1) // 2
    graph = Graph.from_edges(n, links)
    if k == 2:
        return connected(n, links) and not len(cut_vertices(graph))
    return bool(np.diff(graph.indptr).min() >= k) and strongly_connected(graph.indptr, graph.indices, k)


def fiedler_at_least(n: int, pairs: Ints, least: float) -> bool:
    """Whether λ2 of n robots with these links (m, 2), weighing 1, is at least so much; one or none is always enough.

    A link may be given twice. To be called with `one_thread`, as it is often called many times.

    >>> fiedler_at_least(3, np.array([[0, 1], [1, 2]]), 0.9)
    True
    """
    return n < 2 or bool(fiedler_of_each(n, [np.unique(np.sort(pairs, axis=1), axis=0)])[0] >= least)


def fiedler_at(contacts: Contacts, piece: int) -> float:
    """λ2 of the robots that are there during a piece, links weighing 1; 0 for fewer than two.

    Raises
    ------
    IndexError
        There is no such piece.
    """
    pairs = graph_at(contacts, piece).edges
    there = robots_at(contacts, piece)
    with one_thread():
        return float(fiedler_of_each(len(there), [np.searchsorted(there, pairs)])[0])


def failing_pieces(contacts: Contacts, holds: Holds) -> Ints:
    """(f,) the pieces, ascending, in which the robots that are there do not hold together as asked."""
    failing: list[int] = []
    todo = list(epochs(contacts))[::-1]
    while todo:
        block = todo.pop()
        if holds(block.n, block.throughout):
            continue
        if block.last - block.first == 1:
            failing.append(block.first)
        elif not holds(block.n, block.pairs):
            failing.extend(range(block.first, block.last))
        else:
            todo.extend(block.halves[::-1])
    return np.array(failing, dtype=np.int64)


def least_fiedler(contacts: Contacts) -> tuple[int, float]:
    """Piece in which λ2 is least, the first of equals, and λ2 there; pieces of fewer than two robots do not count.

    (0, 0.0) if no others are there. λ2 never falls when links come; so a block's lasting links bound it from below, and
    the block with the least bound is halved until it is one piece.
    """
    heap: list[tuple[float, int, Block]] = []

    def push(blocks: list[Block]) -> None:
        for block in blocks:
            if block.n > 1:
                value = 0.0
                if connected(block.n, block.throughout):
                    value = float(fiedler_of_each(block.n, [block.throughout])[0])
                heapq.heappush(heap, (value, block.first, block))

    with one_thread():
        push(list(epochs(contacts)))
        while heap:
            value, first, block = heapq.heappop(heap)
            if block.last - first == 1:
                return first, value
            push(block.halves)
    return 0, 0.0


def stretches(contacts: Contacts, pieces: Ints) -> FloatArray:
    """(q, 2) the stretches of time, [from, until] in seconds, that some pieces (ascending) make; until may be inf."""
    borders = np.append(contacts.times, np.inf)
    new = np.flatnonzero(np.diff(pieces, prepend=-2) > 1)
    last = np.append(new[1:], len(pieces))[: len(new)] - 1
    return np.stack([borders[pieces[new]], borders[pieces[last] + 1]], axis=1)
