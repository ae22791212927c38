"""Room for the search for optimal plans: pools that are filled from the front and doubled when they are half full."""

from __future__ import annotations

from typing import TypeVar

import numpy as np
from numpy.typing import NDArray

from taut.team import _tree_kernels as pools
from taut.team._rule_kernels import MARKS, Desk, Ground, Ints, Rules, Steps, Team
from taut.team._tree_kernels import Now, Search, Tree

_Number = TypeVar("_Number", np.int64, np.float64)


def planted(ground: Ground, team: Team, slack: float, makespan: bool) -> Search:
    """Room for a small tree; every pool holds what several visits may add."""
    n, m, robots = len(ground.positions), len(ground.heads), len(team.starts)
    pairs = robots * robots
    nodes, met, changes = 1024, 4 * pairs + 4096, 8 * robots + 4096
    tree = Tree(
        node=_ints(nodes, 7),
        value=np.empty((nodes, 2)),
        change=_ints(changes, 3),
        motion=_ints(changes, 2),
        arrival=np.empty(changes),
        who=_ints(met, 6),
        when=np.empty((met, 5)),
        price=np.empty((met, 2)),
        open_key=np.empty(4 * nodes),
        open_node=_ints(4 * nodes),
        focal_key=np.empty(4 * nodes),
        focal_node=_ints(4 * nodes),
        later_key=np.empty(4 * nodes),
        later_node=_ints(4 * nodes),
    )
    now = Now(
        motion=_ints(robots),
        rule=_ints(robots),
        seen=_ints(robots),
        group=_ints(robots),
        meeting=_ints(pairs),
        delay=np.empty(robots + pairs + 1),
        stack=_ints(3 * pairs + 2),
    )
    rules = Rules(_ints(changes, 4), np.empty((changes, 2)))
    steps = Steps(_ints(65536 + 4 * n, 2), np.empty((65536 + 4 * n, 2)))
    size = np.zeros(pools.COUNTS, dtype=np.int64)
    return Search(ground, team, rules, steps, tree, size, _desk(n, m, 256), now, slack, makespan)


def _desk(n: int, m: int, rules: int) -> Desk:
    """Room for the search of one robot under so many rules."""
    layers = MARKS + 1
    states = layers * (n + 2 * rules) + 2 * rules + 16
    return Desk(
        first_state=np.full(layers * n, -1, dtype=np.int64),
        how_many=np.zeros(layers * n, dtype=np.int64),
        vertex_rule=np.full(n, -1, dtype=np.int64),
        edge_rule=np.full(m, -1, dtype=np.int64),
        link=_ints(rules, 2),
        keep_out=np.empty((rules, 4)),
        mark=_ints(MARKS, 3),
        mark_time=np.empty((MARKS, 3)),
        opens=np.empty(states),
        closes=np.empty(states),
        arrive=np.empty(states),
        leave=np.empty(states),
        key=np.empty(states),
        state=_ints(states, 5),
        heap=_ints(states),
    )


def grown(search: Search) -> Search:
    """Double what is at least half full."""
    rules, steps, tree, desk, size = search.rules, search.steps, search.tree, search.desk, search.size
    nodes, changes, motions, met = (int(size[k]) for k in (pools.NODES, pools.CHANGES, pools.MOTIONS, pools.MEETINGS))
    opened, later = int(size[pools.OPEN]), int(size[pools.LATER])
    focal = int(size[pools.FOCAL]) + later  # all of the later ones may move there
    deepest = int(rules.what[: size[pools.RULES], 3].max(initial=0))
    if 2 * deepest >= len(desk.link):
        desk = _desk(len(search.ground.positions), len(search.ground.heads), 2 * len(desk.link))
    many = int(size[pools.RULES])
    return search._replace(
        rules=Rules(_doubled(rules.what, many), _doubled(rules.when, many)),
        steps=Steps(_doubled(steps.where, int(size[pools.STEPS])), _doubled(steps.when, int(size[pools.STEPS]))),
        tree=Tree(
            node=_doubled(tree.node, nodes),
            value=_doubled(tree.value, nodes),
            change=_doubled(tree.change, changes),
            motion=_doubled(tree.motion, motions),
            arrival=_doubled(tree.arrival, motions),
            who=_doubled(tree.who, met),
            when=_doubled(tree.when, met),
            price=_doubled(tree.price, met),
            open_key=_doubled(tree.open_key, opened),
            open_node=_doubled(tree.open_node, opened),
            focal_key=_doubled(tree.focal_key, focal),
            focal_node=_doubled(tree.focal_node, focal),
            later_key=_doubled(tree.later_key, later),
            later_node=_doubled(tree.later_node, later),
        ),
        desk=desk,
    )


def _doubled(pool: NDArray[_Number], used: int) -> NDArray[_Number]:
    if 2 * used < len(pool):
        return pool
    out = np.empty((2 * len(pool), *pool.shape[1:]), dtype=pool.dtype)
    out[: len(pool)] = pool
    return out


def _ints(*shape: int) -> Ints:
    return np.empty(shape, dtype=np.int64)
