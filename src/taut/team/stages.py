"""Stages of planning a team: what each step of MRPPA found, as plain values to draw, print and step through."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import TypeAlias

from taut.graph.core import Floats, Ints
from taut.motion import Plan
from taut.team.conflicts import Conflict
from taut.team.ground import Bools, Ground


@dataclass(frozen=True, eq=False)
class FreeSpaceStage:
    """The free space of one size of robot."""

    ground: Ground


@dataclass(frozen=True, eq=False)
class ObstacleGraphStage:
    """Starts, goals and obstacle vertices, joined by the edges of the obstacles only.

    Parameters
    ----------
    components : how many parts that graph has.
    """

    ground: Ground
    components: int


@dataclass(frozen=True, eq=False)
class SplitStage:
    """The visibility graph cut in two: edges between the sides are gone.

    Parameters
    ----------
    side : (n,) which side each vertex is on.
    edges : (m,) the edges that are left.
    values : (g,) the Fiedler vector of the graph of the groups; empty if another rule decided.
    by : "Fiedler vector", "components" (the graph was in several parts already) or "hand".
    connectivity : λ2 of the graph of the groups before the cut.
    moved : groups that a split by hand left cut off from the rest of their side, and that went over to the other.
    """

    ground: Ground
    side: Bools
    edges: Bools
    values: Floats
    by: str
    connectivity: float
    moved: tuple[str, ...] = ()


@dataclass(frozen=True, eq=False)
class BridgeStage:
    """One edge between the sides put back.

    Parameters
    ----------
    cut : the split before it.
    edges : (m,) the edges there are now.
    edge : number of the new one.
    robot : the robot that it serves.
    candidates : how many edges gave or shortened a path of a robot not yet served.
    before, after : λ2 without and with the edge.
    runner_up : number of the next best candidate, None if there was no other.
    runner_up_after : λ2 if that had been chosen.
    """

    ground: Ground
    cut: SplitStage
    edges: Bools
    edge: int
    robot: str
    candidates: int
    before: float
    after: float
    runner_up: int | None
    runner_up_after: float | None


@dataclass(frozen=True, eq=False)
class FirstPathStage:
    """A robot's first path: the shortest one in the graph as it is.

    Parameters
    ----------
    cut : the split before it.
    edges : (m,) the edges there are.
    robot : its name.
    path : (k,) vertices from its start to its goal.
    length : metres.
    """

    ground: Ground
    cut: SplitStage
    edges: Bools
    robot: str
    path: Ints
    length: float


@dataclass(frozen=True, eq=False)
class FullGraphStage:
    """All edges put back: the full visibility graph.

    Parameters
    ----------
    connectivity : λ2.
    lengths : (r,) metres of each robot's shortest path in it.
    """

    ground: Ground
    connectivity: float
    lengths: Floats


@dataclass(frozen=True, eq=False)
class SequenceStage:
    """The team planned one after another.

    Parameters
    ----------
    plan : the outcome.
    order : names in the sequence of planning.
    conflicts : per robot what it met on its shortest way and how it gave way, see `Conflict`.
    """

    plan: Plan
    order: tuple[str, ...]
    conflicts: Mapping[str, tuple[Conflict, ...]]


Stage: TypeAlias = (
    FreeSpaceStage | ObstacleGraphStage | SplitStage | BridgeStage | FirstPathStage | FullGraphStage | SequenceStage
)
