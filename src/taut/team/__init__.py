"""Planning for many robots: who is in whose way and when, safe intervals, orders."""

from taut.team.planning import Result, plan

__all__ = ["Result", "plan"]
