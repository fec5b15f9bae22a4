"""Dielectrics: relative permittivity over frequency, with conduction declared separately."""

from electrovib.physics.material.base import Material
from electrovib.physics.material.relaxations import (
    ColeCole,
    ColeColeTerm,
    Constant,
    ConstantPhase,
    Debye,
    DebyeTerm,
    HavriliakNegami,
    Prony,
)

__all__ = [
    "ColeCole",
    "ColeColeTerm",
    "Constant",
    "ConstantPhase",
    "Debye",
    "DebyeTerm",
    "HavriliakNegami",
    "Material",
    "Prony",
]
