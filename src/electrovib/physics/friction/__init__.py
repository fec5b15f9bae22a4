"""From normal force to lateral force."""

from electrovib.physics.friction.base import FollowingFriction, Friction, Load, SteadyFriction
from electrovib.physics.friction.bristle import BristleFriction, Bristles, Dahl, LuGre
from electrovib.physics.friction.steady import AdhesiveShear, Coulomb, Creep, FirstOrderLag, PowerLaw

__all__ = [
    "AdhesiveShear",
    "BristleFriction",
    "Bristles",
    "Coulomb",
    "Creep",
    "Dahl",
    "FirstOrderLag",
    "FollowingFriction",
    "Friction",
    "Load",
    "LuGre",
    "PowerLaw",
    "SteadyFriction",
]
