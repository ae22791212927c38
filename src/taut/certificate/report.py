"""What a certificate says: problems, least distances, and the certificate itself. Plain frozen values."""

from __future__ import annotations

import sys
from dataclasses import dataclass
from typing import Any

from taut.contact import Contact
from taut.scene import Point

KINDS = ("scene", "claim", "start", "goal", "start_time", "speed", "separation", "clearance", "crossing", "contact")
WALL = "the wall"


@dataclass(frozen=True)
class Problem:
    """One thing in a plan that must not be; ``str(problem)`` is one sentence.

    Parameters
    ----------
    kind : one of "scene", "claim", "start", "goal", "start_time", "speed", "separation", "clearance", "crossing",
        "contact".
    robots : names of the robots concerned, in the scene's order; empty if it concerns the whole plan.
    amount : by how many metres the rule is broken; 0 where that cannot be told in metres.
    time : seconds at which it is worst, if it has a time.
    place : (x, y) in metres of that moment, if it has a place.
    obstacle : name of the obstacle (two joined by " and "), or "the wall".
    detail : what else is to be said, in words; of contact, all but the time and the place.
    """

    kind: str
    robots: tuple[str, ...] = ()
    amount: float = 0.0
    time: float | None = None
    place: Point | None = None
    obstacle: str | None = None
    detail: str = ""

    def __str__(self) -> str:
        who = " and ".join(self.robots)
        by = f"{self.amount:.6g} m"
        match self.kind:
            case "separation":
                what = f"{who} come {by} nearer to each other than allowed"
            case "clearance":
                what = f"{who} comes {by} nearer to {self.obstacle} than allowed"
            case "crossing" if self.amount > 0:
                what = f"{who} passes {by} deep through {self.obstacle}"
            case "crossing" if self.obstacle is not None and " and " in self.obstacle:
                what = f"{who} squeezes through where {self.obstacle} leave no room"
            case "crossing":
                what = f"{who} passes through {self.obstacle}"
            case "speed":
                what = f"{who} moves {by} farther in one leg than its top speed allows"
            case "start":
                what = f"{who} begins {by} from its start"
            case "goal":
                what = f"{who} ends {by} from its goal"
            case "start_time":
                what = f"{who} moves {by} before its start time"
            case _:
                what = ""
        when = "" if self.time is None else f" at t = {self.time:.9g} s"
        where = "" if self.place is None else f" near ({self.place[0]:.9g}, {self.place[1]:.9g})"
        if self.kind == "contact":
            return f"{self.detail}{when}{where}"
        said = f"{what}{when}{where}"
        return f"{said} ({self.detail})" if said and self.detail else said or self.detail

    def as_dict(self) -> dict[str, Any]:
        """Return JSON-ready plain data, with the sentence as ``text``."""
        return {
            "kind": self.kind,
            "robots": list(self.robots),
            "obstacle": self.obstacle,
            "amount": _finite(self.amount),
            "time": None if self.time is None else _finite(self.time),
            "place": _place(self.place),
            "text": str(self),
        }


@dataclass(frozen=True)
class Separation:
    """Where two robots are nearest: the free room between their discs.

    Parameters
    ----------
    value : metres between the rims of the discs; negative when they overlap.
    robots : the pair.
    time : seconds (of the first robot, if ``other_time`` differs).
    other_time : seconds of the second robot; differs from ``time`` by at most the headway.
    place : middle between the two centres, metres.
    """

    value: float
    robots: tuple[str, str]
    time: float
    other_time: float
    place: Point

    def as_dict(self) -> dict[str, Any]:
        """Return JSON-ready plain data."""
        return {
            "value": _finite(self.value),
            "robots": list(self.robots),
            "time": _finite(self.time),
            "other_time": _finite(self.other_time),
            "place": _place(self.place),
        }


@dataclass(frozen=True)
class Clearance:
    """Where one robot is nearest to an obstacle or the wall.

    Parameters
    ----------
    value : metres between its rim and the obstacle; negative when they overlap (a centre inside counts
        its depth, to a millionth).
    robot : its name.
    obstacle : name of the obstacle, or "the wall".
    time : seconds.
    place : centre of the robot, metres.
    """

    value: float
    robot: str
    obstacle: str
    time: float
    place: Point

    def as_dict(self) -> dict[str, Any]:
        """Return JSON-ready plain data."""
        return {
            "value": _finite(self.value),
            "robot": self.robot,
            "obstacle": self.obstacle,
            "time": _finite(self.time),
            "place": _place(self.place),
        }


@dataclass(frozen=True)
class ContactProof:
    """How well a team keeps in contact, beside what was demanded of it.

    Parameters
    ----------
    demand : what had to be proved.
    lambda2 : least λ2 over time of the robots that are there, links weighing 1, for pieces of time with two or more;
        None if there are none, and for more than 250 robots.
    lambda2_time : seconds, where λ2 is that for the first time: the middle of that piece of time.
    needed_range : metres, the least range with which the team would be connected at every instant, too large by a
        millionth of the range demanded at most; None if the team loses contact or never has two robots.
    needed_time : seconds at which it is needed.
    """

    demand: Contact
    lambda2: float | None = None
    lambda2_time: float | None = None
    needed_range: float | None = None
    needed_time: float | None = None

    def as_dict(self) -> dict[str, Any]:
        """Return JSON-ready plain data."""
        found = {
            "lambda2": self.lambda2,
            "lambda2_time": self.lambda2_time,
            "needed_range": self.needed_range,
            "needed_time": self.needed_time,
        }
        return {"demand": self.demand.claim} | {
            name: None if value is None else _finite(value) for name, value in found.items()
        }


@dataclass(frozen=True)
class Certificate:
    """The proof of a plan, or what is wrong with it.

    Parameters
    ----------
    tol : the tolerance everything was held to, metres (for time: tol / speed).
    separation : the nearest pair of robots over all time; None if no two robots are ever present together.
    clearances : the nearest obstacle of each robot, in the scene's order.
    max_speed_ratio : greatest speed on any leg divided by that robot's top speed; 0 if nothing moves.
    problems : everything found wrong, at most one (the worst) per kind and robot, pair or part of the team.
    contact : what was found of the contact that was demanded or claimed; None if none was.
    """

    tol: float
    separation: Separation | None
    clearances: tuple[Clearance, ...]
    max_speed_ratio: float
    problems: tuple[Problem, ...]
    contact: ContactProof | None = None

    @property
    def ok(self) -> bool:
        """Whether the plan is proved."""
        return not self.problems

    @property
    def min_separation(self) -> float | None:
        """Least free room between two discs over all time, metres; None for fewer than two robots."""
        return None if self.separation is None else self.separation.value

    @property
    def clearance(self) -> Clearance | None:
        """The least of all clearances, and where; None without robots."""
        return min(self.clearances, key=lambda c: c.value, default=None)

    @property
    def min_clearance(self) -> float | None:
        """Least distance between a robot's rim and an obstacle or the wall, metres; None without robots."""
        least = self.clearance
        return None if least is None else least.value

    def as_dict(self) -> dict[str, Any]:
        """Return JSON-ready plain data (finite numbers only), the same for the same plan."""
        proof = {} if self.contact is None else {"contact": self.contact.as_dict()}
        return {
            "ok": self.ok,
            "tol": self.tol,
            "min_separation": None if self.separation is None else _finite(self.separation.value),
            "min_clearance": None if self.clearance is None else _finite(self.clearance.value),
            "max_speed_ratio": _finite(self.max_speed_ratio),
            "separation": None if self.separation is None else self.separation.as_dict(),
            "clearance": None if self.clearance is None else self.clearance.as_dict(),
            **proof,
            "problems": [problem.as_dict() for problem in self.problems],
        }


def _finite(value: float) -> float:
    """Clamp to the largest double: a plan full of absurd numbers must still give a report that can be written."""
    return float(min(max(value, -sys.float_info.max), sys.float_info.max))


def _place(place: Point | None) -> list[float] | None:
    return None if place is None else [_finite(place[0]), _finite(place[1])]
