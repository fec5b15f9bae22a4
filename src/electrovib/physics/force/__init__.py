"""Force laws: attraction from the fields in the layers, by the surface on which the Maxwell stress is evaluated.

The published static formulas are the Maxwell stress of one displacement, evaluated in media of different permittivity,
and differ by factors of 3.4 to 1650. Each is a law with a name. The finger can separate from the plate only in the gap,
so the Maxwell stress in the gap is the physical one; inside a lossy dielectric the Maxwell stress is a convention.
"""

from electrovib.physics.force.base import ForceLaw as ForceLaw
from electrovib.physics.force.base import gap_field as gap_field
from electrovib.physics.force.base import layer_of as layer_of
from electrovib.physics.force.base import needed_layer as needed_layer
from electrovib.physics.force.base import wanted_layer as wanted_layer
from electrovib.physics.force.maxwell_stress import SUMS as SUMS
from electrovib.physics.force.maxwell_stress import EffectiveMedium as EffectiveMedium
from electrovib.physics.force.maxwell_stress import MaxwellStressInGap as MaxwellStressInGap
from electrovib.physics.force.maxwell_stress import MaxwellStressInInsulator as MaxwellStressInInsulator
from electrovib.physics.force.maxwell_stress import (
    MaxwellStressInStratumCorneum as MaxwellStressInStratumCorneum,
)
from electrovib.physics.force.maxwell_stress import StressOfField as StressOfField
from electrovib.physics.force.maxwell_stress import equivalent_field as equivalent_field
from electrovib.physics.force.tabulated import TabulatedAttraction as TabulatedAttraction
