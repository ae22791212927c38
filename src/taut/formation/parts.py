"""The motion of a team in formation, part by part: the best way whose columns and moves turn out to be possible.

What a column takes, and whether contact lasts, is known only once it is worked out. So the best way by what is known is
looked for again and again, and what is new in it worked out, until nothing is.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from itertools import groupby

import numpy as np

from taut.contact.demand import Contact
from taut.errors import NoPlanFound
from taut.formation.column import NoColumn, column
from taut.formation.linking import first_loss, moved
from taut.formation.shape import BoolArray, Shape
from taut.formation.ways import Ground, Step, best_way, columns_alike, grounds, pulled, states_along
from taut.route.passage import widest_passage
from taut.scene import FloatArray

_ENOUGH, _MOST = 6, 24  # rounds: after so many any way that is worked out will do; after so many the search ends


@dataclass(frozen=True, eq=False)
class Part:
    """A stretch of the motion.

    Parameters
    ----------
    seconds : (m,) from its begin on.
    places : (m, n, 2) metres, where all robots are then; straight and steady in between.
    scales : (m,) how large the formation is then, 0 within a column.
    order : numbers of the robots in a column, who goes first first.
    middle : (2,) metres, by way of which they go in a column.
    """

    seconds: FloatArray
    places: FloatArray
    scales: FloatArray
    order: tuple[int, ...] = ()
    middle: FloatArray | None = None


def parts_of(shape: Shape, demand: Contact | None, keep: float) -> list[Part]:
    """Return the motion of the team, part by part; none where it starts at its goals.

    Raises
    ------
    NoPlanFound
        The team does not get through; names the narrowest place, its width and what it lies between.
    """
    leader = shape.scene.robots[shape.leader]
    if leader.start == leader.goal:
        return []
    guessed = list(grounds(shape, keep))
    # the same but for the columns, which are open only once they are worked out
    known = [replace(ground, column=np.full_like(ground.column, math.inf)) for ground in guessed]
    done: dict[tuple[int, Step], Part] = {}
    for turn in range(_MOST):
        i, steps = _best(known) if turn >= _ENOUGH else (0, [])
        if not steps:
            i, steps = _best(guessed)
        new = [step for step in steps if (i, step) not in done]
        if not new:
            break
        for step in new:
            part = _worked_out(shape, guessed[i], step, demand)
            if isinstance(part, Part):
                done[i, step] = part
                if step.column:
                    _price(shape, guessed[i], known[i], step, part, keep)
            else:
                _close(shape, guessed[i], known[i], step, part)
    i, steps = _best(known)
    if not steps or any((i, step) not in done for step in steps):
        raise _lost(shape, demand)
    parts: list[Part] = []
    for is_column, group in groupby(steps, key=lambda step: step.column):
        own = list(group)
        parts += [done[i, step] for step in own] if is_column else [_in_size(shape, guessed[i], own, demand, keep)]
    return parts


def _best(known: list[Ground]) -> tuple[int, list[Step]]:
    """The ground with the best way, and its steps; none if there is no way."""
    ways = [best_way(ground) for ground in known]
    i = min(range(len(ways)), key=lambda i: ways[i][0])
    return i, ways[i][1]


def _worked_out(shape: Shape, ground: Ground, step: Step, demand: Contact | None) -> Part | NoColumn:
    """The motion of one step, if there is one that keeps contact."""
    if step.column:
        return _in_column(shape, ground, step, demand)
    part = _timed(shape, states_along(ground, [step]))
    return part if _in_sight(shape, part, demand) else NoColumn("both")


def _in_column(shape: Shape, ground: Ground, step: Step, demand: Contact | None) -> Part | NoColumn:
    """The motion of a step in a column, by way of the place that is farthest from all who stand."""
    ends = np.array([ground.state(step.begin), ground.state(step.end)])
    begin, end = shape.places(ends)
    middles = ground.middles_of(step)
    room = np.hypot(*np.moveaxis(middles[:, None] - np.concatenate([begin, end]), 2, 0)).min(axis=1)
    middle = middles[int(np.argmax(room))]
    found = column(shape, begin, end, middle, demand)
    if isinstance(found, NoColumn):
        return found
    scales = np.zeros(len(found.seconds))
    scales[[0, -1]] = ends[:, 2]
    return Part(found.seconds, found.places, scales, found.order, middle)


def _in_size(shape: Shape, ground: Ground, steps: list[Step], demand: Contact | None, keep: float) -> Part:
    """The motion along steps in formation, pulled taut where that keeps contact."""
    states = states_along(ground, steps)
    part = _timed(shape, pulled(shape, states, keep))
    return part if _in_sight(shape, part, demand) else _timed(shape, states)


def _in_sight(shape: Shape, part: Part, demand: Contact | None) -> bool:
    """Whether contact lasts in formation: within reach robots stay in any size, but in sight they may not."""
    if demand is None or not demand.sight:
        return True
    return first_loss(moved(shape.scene, part.seconds, part.places), demand) is None


def _timed(shape: Shape, states: FloatArray) -> Part:
    seconds = np.append(0.0, np.cumsum(shape.seconds(states[:-1], states[1:])))
    return Part(seconds, shape.places(states), states[:, 2])


def _price(shape: Shape, guessed: Ground, known: Ground, step: Step, part: Part, keep: float) -> None:
    """Note what a column takes, also for others nearly like it, which are then hardly worth looking at."""
    length = float(np.hypot(*np.diff(part.places[:, shape.leader], axis=0).T).sum())
    weighed = part.seconds[-1] + keep * length / shape.speeds.min()
    known.column[step.begin.station, step.begin.level, step.end.station, step.end.level] = weighed
    _guess(guessed, known, columns_alike(shape, guessed, step, "both", shape.spacing / 4), 1.01 * weighed)


def _close(shape: Shape, guessed: Ground, known: Ground, step: Step, why: NoColumn) -> None:
    """Take a step out that is not possible, and columns like it. Both grounds share moves and changes."""
    a, b = step.begin, step.end
    if step.column:
        _guess(guessed, known, columns_alike(shape, guessed, step, why.reason, shape.spacing), math.inf)
    elif a.station == b.station:
        guessed.changing[a.station, min(a.level, b.level)] = math.inf
    else:
        guessed.moving[a.level, a.station, b.station] = math.inf


def _guess(guessed: Ground, known: Ground, columns: BoolArray, weighed: float) -> None:
    guessed.column[columns & np.isinf(known.column)] = weighed
    np.copyto(guessed.column, known.column, where=np.isfinite(known.column))


def _lost(shape: Shape, demand: Contact | None) -> NoPlanFound:
    """Return the error that says where it is narrowest."""
    scene = shape.scene
    leader = scene.robots[shape.leader]
    passage = widest_passage(scene, leader.start, leader.goal)
    x, y = passage.place
    names = tuple(robot.name for robot in scene.robots)
    team = ", ".join(names[:5]) + ", …" * (len(names) > 5)
    within = "" if demand is None else f" in contact within {demand.reach:g} m"
    return NoPlanFound(
        f"no travel in formation{within} found for {team}: the narrowest place on the widest way of the leader "
        f"{leader.name} is near ({x:.2f}, {y:.2f}), {2 * passage.clearance:.4g} m wide between "
        f"{passage.between[0]} and {passage.between[1]}; more room there or about the ends may help",
        names,
        None,
        passage.place,
    )
