"""Planning for many robots: who is in whose way and when, safe intervals, orders."""

from taut.team.planning import Result, plan
from taut.team.replanning import Replanned, replan

__all__ = ["Replanned", "Result", "plan", "replan"]
