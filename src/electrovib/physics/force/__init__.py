"""From fields to attraction: at which plane the finger is cut free.

The published static formulas are one displacement divided by the permittivity of different planes, 3.4 to
1650 times apart. Each is a law with a name. The finger can separate from the plate only in the gap, so the
Maxwell stress in the gap is the physical one; inside a lossy dielectric a Maxwell stress is a convention.
"""

from electrovib.physics.force.base import ForceLaw, gap_field, layer_of, needed_layer, wanted_layer
from electrovib.physics.force.maxwell_stress import (
    EffectiveMedium,
    MaxwellStressInGap,
    MaxwellStressInInsulator,
    MaxwellStressInStratumCorneum,
    equivalent_field,
)

__all__ = [
    "EffectiveMedium",
    "ForceLaw",
    "MaxwellStressInGap",
    "MaxwellStressInInsulator",
    "MaxwellStressInStratumCorneum",
    "equivalent_field",
    "gap_field",
    "layer_of",
    "needed_layer",
    "wanted_layer",
]
