"""Control: laws as vector fields and their integration; pursuit and tracking of plans, and who waits for whom."""

from taut.control.coordination import Dependencies, allowed, dependencies, stopped_by
from taut.control.integration import integrate
from taut.control.laws import (
    Field,
    Links,
    Velocity,
    consensus,
    distance_formation,
    following,
    formation,
    leader_follower,
    rendezvous,
)
from taut.control.pursuit import PurePursuit, Pursuit, pursue
from taut.control.tracking import Tracking, progress_rate, tuning

__all__ = [
    "Dependencies",
    "Field",
    "Links",
    "PurePursuit",
    "Pursuit",
    "Tracking",
    "Velocity",
    "allowed",
    "consensus",
    "dependencies",
    "distance_formation",
    "following",
    "formation",
    "integrate",
    "leader_follower",
    "progress_rate",
    "pursue",
    "rendezvous",
    "stopped_by",
    "tuning",
]
