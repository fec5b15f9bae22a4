"""Perception of vibration: frequency weighting of the tactile channels, and thresholds.

A displacement is felt by the channel whose weighted level is the highest. Levels are relative to a sine of the same
amplitude at the best frequency, in decibels. They become levels above threshold by a threshold and a compliance: those of
the person at hand, or else published ones, as assumptions with their spread.
Summation over time and area, masking and motion are not modelled.
"""

from electrovib.physics.perception.channels import (
    BEST_FREQUENCIES,
    RYU,
    Channel,
    DetectionThreshold,
    NonPacinian,
    Pacinian,
)
from electrovib.physics.perception.person import (
    COMPLIANCES,
    MOTION,
    UNVERIFIED_CORNER,
    ElasticSkin,
    ElasticViscousSkin,
    Perception,
    SkinCompliance,
    decibels,
    felt_amplitude,
    strongest,
)

__all__ = [
    "BEST_FREQUENCIES",
    "COMPLIANCES",
    "MOTION",
    "RYU",
    "UNVERIFIED_CORNER",
    "Channel",
    "DetectionThreshold",
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
