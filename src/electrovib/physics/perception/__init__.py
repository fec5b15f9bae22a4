"""How the channels of touch weigh a displacement of the skin, and what a threshold is.

A displacement is felt by the channel whose weighted level is the highest. Levels are relative: how many decibels
below (or above) a sine of the same size at the best frequency. They become levels above threshold only with a
threshold that the user has measured. What is not in it: summation over time and area, masking, motion.
"""

from electrovib.physics.perception.channels import BEST_FREQUENCIES, RYU, Channel, NonPacinian, Pacinian
from electrovib.physics.perception.compliance import (
    UNVERIFIED_CORNER,
    ElasticSkin,
    ElasticViscousSkin,
    SkinCompliance,
)
from electrovib.physics.perception.person import MOTION, Perception, decibels, felt_amplitude, strongest

__all__ = [
    "BEST_FREQUENCIES",
    "MOTION",
    "RYU",
    "UNVERIFIED_CORNER",
    "Channel",
    "ElasticSkin",
    "ElasticViscousSkin",
    "NonPacinian",
    "Pacinian",
    "Perception",
    "SkinCompliance",
    "decibels",
    "felt_amplitude",
    "strongest",
]
