"""Force laws: attraction from the fields in the layers, by the surface on which the Maxwell stress is evaluated.

The published static formulas are the Maxwell stress of one displacement, evaluated in media of different permittivity,
and differ by factors of 3.4 to 1650. Each is a law with a name. The finger can separate from the plate only in the gap,
so the Maxwell stress in the gap is the physical one; inside a lossy dielectric the Maxwell stress is a convention.
"""

from electrovib.physics.force.base import ForceLaw, gap_field, layer_of, needed_layer, wanted_layer
from electrovib.physics.force.maxwell_stress import (
    SUMS,
    EffectiveMedium,
    MaxwellStressInGap,
    MaxwellStressInInsulator,
    MaxwellStressInStratumCorneum,
    StressOfField,
    equivalent_field,
)

__all__ = [
    "SUMS",
    "EffectiveMedium",
    "ForceLaw",
    "MaxwellStressInGap",
    "MaxwellStressInInsulator",
    "MaxwellStressInStratumCorneum",
    "StressOfField",
    "equivalent_field",
    "gap_field",
    "layer_of",
    "needed_layer",
    "wanted_layer",
]
