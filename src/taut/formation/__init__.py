"""Travel in formation: a team that follows its leader, contracts in narrow places and recovers after them."""

from taut.formation.shape import in_formation
from taut.formation.travelling import Formed, Narrow, travel

__all__ = ["Formed", "Narrow", "in_formation", "travel"]
