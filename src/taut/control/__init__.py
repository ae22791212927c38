"""Control laws as vector fields (velocities from time and positions), and their integration to trajectories."""

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

__all__ = [
    "Field",
    "Links",
    "Velocity",
    "consensus",
    "distance_formation",
    "following",
    "formation",
    "integrate",
    "leader_follower",
    "rendezvous",
]
