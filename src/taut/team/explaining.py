"""Why a team has no plan, as an error that says who, where and what would help."""

from __future__ import annotations

from taut.errors import NoPlanExists, NoPlanFound
from taut.team.diagnosis import MOST_PAIRS, diagnose, suspects
from taut.team.impossibility import MOST_STATES, Impossible, first_impossible
from taut.team.in_contact import Together, set_out
from taut.team.prioritized import Round
from taut.team.search import Searched
from taut.team.world import World

_FEW_PAIRS, _FEW_STATES = 3, 200_000  # what proofs may take before passes go on: some tenths of a second


def refuse_impossible(world: World, best: Round, pairs: int = _FEW_PAIRS, states: int = _FEW_STATES) -> None:
    """Raise NoPlanExists if two of those who blocked each other in a pass provably cannot both reach their goals."""
    _refuse(first_impossible(world.scene, suspects(world, best)[:pairs], states))


def no_plan(world: World, best: Round, done: int) -> NoPlanFound:
    """Return the error that says who failed in the best pass, where, when and because of whom, and what may help.

    Raises
    ------
    NoPlanExists
        It turns out that there is none.
    """
    refuse_impossible(world, best, MOST_PAIRS, MOST_STATES)
    failure = best.failures[0]
    names = [world.scene.robots[j].name for j in failure.blockers]
    x, y = failure.place
    way = f"; in its way: {_listed(names)}" if names else ""
    others = f" ({len(best.failures)} robots failed in the best round)" if len(best.failures) > 1 else ""
    robot = world.scene.robots[failure.robot].name
    return NoPlanFound(
        f"no plan found in {done} round{'s' if done > 1 else ''}: robot {robot} gets no further than "
        f"({x:.2f}, {y:.2f}) at t = {failure.time:.2f} s{way}{others}",
        (robot, *names),
        failure.time,
        failure.place,
        diagnose(world, best).sentences,
    )


def no_plan_in_contact(world: World, together: Together) -> NoPlanFound:
    """Return the error that says which robot lost contact with whom, where and when.

    Raises
    ------
    NoPlanExists
        It turns out that there is no plan, in contact or not.
    """
    scene = world.scene
    names = [robot.name for robot in scene.robots]
    *before, last = together.stretches
    contact = last.ties.contact
    within = f"{contact.reach:.6g} m" + (" and in sight" if contact.sight else "")
    more = ("a longer range, more room, or goals that lie as the starts do may help",)
    if together.missing:
        place = scene.robots[together.missing[0]].start
        enough = "one" if last.ties.need == 1 else f"{last.ties.need}"
        return NoPlanFound(
            f"no plan found: no order lets each robot start and end within {within} of {enough} planned before it: "
            f"{_listed([names[i] for i in together.missing])} cannot follow, and the team found nowhere to gather on "
            f"its way; {names[together.missing[0]]} is at ({place[0]:.2f}, {place[1]:.2f}) at t = 0 s",
            [names[i] for i in together.missing],
            0.0,
            place,
            more,
        )
    refuse_impossible(world, last.passed)
    failure = last.passed.failures[0]
    since = set_out(world, before)[-1]
    x, y = failure.place
    lost = "" if last.lost is None else f"cannot stay within {within} of {names[last.lost]} or others: it "
    others = [names[j] for j in failure.blockers if j != last.lost]
    way = f"; in its way: {_listed(others)}" if others else ""
    concerned = [names[failure.robot], *([] if last.lost is None else [names[last.lost]]), *others]
    return NoPlanFound(
        f"no plan found in {together.passes} round{'s' if together.passes > 1 else ''}: robot {names[failure.robot]} "
        f"{lost}gets no further than ({x:.2f}, {y:.2f}) at t = {since + failure.time:.2f} s{way}",
        concerned,
        since + failure.time,
        failure.place,
        more,
    )


def no_order(world: World, found: Searched) -> NoPlanFound:
    """Return the error that says which two robots were left when the search for an order ended.

    Raises
    ------
    NoPlanExists
        It turns out that they cannot both reach their goals.
    """
    meeting = found.stuck[0]
    pairs = [(stuck.first, stuck.second) for stuck in found.stuck[:MOST_PAIRS]]
    _refuse(first_impossible(world.scene, pairs, MOST_STATES))
    names = [world.scene.robots[i].name for i in (meeting.first, meeting.second)]
    return NoPlanFound(
        f"no order found in {found.nodes} nodes: {names[0]} and {names[1]} still meet at about t = {meeting.time:.2f} s"
        + (f", and {len(found.stuck) - 1} other pairs" if len(found.stuck) > 1 else ""),
        names,
        meeting.time,
    )


def _refuse(proof: Impossible | None) -> None:
    if proof is not None:
        what, *more = proof.sentences
        raise NoPlanExists(what, proof.robots, proof.place, more)


def _listed(names: list[str], most: int = 5) -> str:
    shown = ", ".join(names[:most])
    return shown if len(names) <= most else f"{shown} and {len(names) - most} more"
