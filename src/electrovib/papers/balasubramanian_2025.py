"""J. K. Balasubramanian, D. M. Pool, Y. Vardar: friction under electrovibration at sliding speeds, 2025.

"Sliding speed influences electrovibration-induced finger friction dynamics on touchscreens".

Claims: friction follows the attraction as a first-order system and the skin is mass, damper and spring; for each
mm/s of sliding speed the cut-off rises by 13.8 Hz, the moving mass by 3.23e-5 kg, the stiffness by 4.04 N/m (ten
persons, 20 to 100 mm/s, 0.2 to 0.6 N); stiffness changes the cut-off more than mass. Does not claim: the cut-off,
mass or stiffness at any one speed (not read). The values at one speed have to be given before a scenario can be computed.

Computed here: with a cut-off at one speed, `FirstOrderLag` with a renewal length of 72.5 um is the paper's friction;
with mass and stiffness at one speed, `MassSpringDamper` with its `growth` is the paper's skin.
"""

from __future__ import annotations

from electrovib.papers import published
from electrovib.physics.finger import GrowthWithSpeed

PAPER = published(__name__)
CITATIONS, CITATION, STATUS, NOT_READ, DEFECTS, PRESETS = PAPER.declared

CUT_OFF_SLOPE = 13.8e3
"""Rise of the cut-off of the friction response with sliding speed, abstract [Hz per m/s]."""
MASS_SLOPE: float = GrowthWithSpeed.model_fields["mass_slope"].default
"""Rise of the finger's moving mass with sliding speed, abstract [kg per m/s]."""
STIFFNESS_SLOPE: float = GrowthWithSpeed.model_fields["stiffness_slope"].default
"""Rise of the finger's stiffness with sliding speed, abstract [N/m per m/s]."""
SPEEDS = (0.02, 0.1)
"""Lowest and highest sliding speed of the experiment, abstract [m/s]."""
SLOPES = {"cut_off": CUT_OFF_SLOPE, "mass": MASS_SLOPE, "stiffness": STIFFNESS_SLOPE}


def at_speed(*, speed: float, slope: float, known_at: float, known: float) -> float:
    """Extrapolate along one of the three straight lines from a speed at which the user knows the value.

    `speed` was 0.02 to 0.1 m/s in the experiment; `slope` is one of CUT_OFF_SLOPE, MASS_SLOPE,
    STIFFNESS_SLOPE. The value `known` at the speed `known_at` is not in the abstract.
    """
    return known + slope * (speed - known_at)


def change(*, of: str) -> float:
    """Return the change of a quantity of `SLOPES` from the lowest to the highest speed of the experiment."""
    low, high = SPEEDS
    return at_speed(speed=high, slope=SLOPES[of], known_at=low, known=0.0)


CHECKS = PAPER.checks(change)
