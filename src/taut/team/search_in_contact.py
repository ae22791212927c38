"""Order search in contact: precedences between robots, added where one fails, until all get through."""

from __future__ import annotations

import math
import time
from collections.abc import Callable

import numpy as np

from taut.team.in_contact import Stretch, Together, pass_in_contact, without_order
from taut.team.safe_intervals import bench_of
from taut.team.ties import Ties, linked_order
from taut.team.world import World

_HOLDS = 4  # how long starts are held: twice as long in each tree, then from the beginning
_PATIENCE = 2  # nodes per robot in a tree


def searched_in_contact(
    world: World,
    ties: Ties,
    seed: int = 0,
    nodes: float = 10_000,
    until: float = math.inf,
    tell: Callable[[int, Stretch], None] | None = None,
) -> Together:
    """Search for an order in which each robot stays in contact with some before it, for one stretch.

    Depth first: a node is a set of precedences and the order that obeys them, the robots with the shortest ways first.
    Where a robot fails, each child lets it precede one of those that it lost or that were in its way. Where a tree
    takes long it is begun anew, with the robots in a random order.

    Parameters
    ----------
    seed : of the random orders; same seed and nodes, same result.
    nodes : how many are made at most.
    until : no node but the first is made after this time of the monotonic clock, seconds.
    tell : called after each node with how many there are and what its order led to.
    """
    rng = np.random.default_rng(seed)
    bench = bench_of(world)
    preference = np.argsort(bench.team.least, kind="stable").tolist()
    linked = linked_order(ties, preference)
    if len(linked) < len(preference):
        return without_order(world, ties, linked, 0)
    best: Stretch | None = None
    made = 0
    tree = 0
    while made < nodes:
        hold = world.moment * 2.0 ** (tree % _HOLDS)
        stack: list[frozenset[tuple[int, int]]] = [frozenset()]
        patience = math.ceil(_PATIENCE * len(preference) * 1.5**tree) + 8
        while stack and patience > 0 and made < nodes:
            if best is not None and time.monotonic() > until:
                return Together((best,), made)
            before = stack.pop()
            order = linked_order(ties, preference, sorted(before))
            if len(order) < len(preference):
                continue
            done = pass_in_contact(world, ties, bench, order, hold, {})
            made, patience = made + 1, patience - 1
            if tell is not None:
                tell(made, done)
            if best is None or done.reached > best.reached:
                best = done
            if not done.passed.failures:
                return Together((done,), made)
            failed = done.passed.failures[0].robot
            stack += [before | {(failed, j)} for j in done.ahead if (j, failed) not in before]
        preference = [int(i) for i in rng.permutation(preference)]
        tree += 1
    assert best is not None
    return Together((best,), made)
