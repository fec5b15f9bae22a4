"""H. Kim and others, electrovibration of uniform intensity by control of the current, IEEE Trans. Haptics 8(4), 2015.

Claims: a prescribed current, in the place of a prescribed voltage, makes the sensation the same for different
fingers and contact conditions. Does not claim: an equation, a current, a frequency (none was read; the paper is
cited from memory, unverified, and no page of it was found). The consequences of a prescribed current are computed
here: through a gap that does not leak E = I/(w eps0 A), so the mean attraction I_rms^2/(2 eps0 A w^2) depends neither
on the gap nor on the insulator nor on the skin. It does depend on the contact area, as 1/A; and current that passes
beside the gap, through stray capacitance or a leak, does not attract.
"""

from __future__ import annotations

import math
from typing import Any

from electrovib.core.constants import VACUUM_PERMITTIVITY as eps0
from electrovib.papers import mean_attraction, published

PAPER = published(__name__)
CITATIONS, CITATION, STATUS, NOT_READ, DEFECTS, PRESETS = PAPER.declared
scenarios = PAPER.scenarios


def gap_field(*, current: float, frequency: float, area: float = 1e-4) -> float:
    """Return the root-mean-square gap field [V/m] of a current [A, rms] at a frequency [Hz] on an area [m2]."""
    return current / (2 * math.pi * frequency * eps0 * area)


def attraction(name: str, changes: dict[str, Any] | None = None) -> float:
    """Compute the mean attraction of a preset with some parameters changed, at its drive's frequency and peak."""
    scenario = scenarios()[name].replace(changes or {})
    drive: Any = scenario.drive
    return float(mean_attraction(scenario, drive.frequency, amplitude=drive.amplitude)[0])


def attraction_of(*, current: float, frequency: float) -> float:
    """Compute the mean attraction [N] of a prescribed current [A, rms] at a frequency [Hz]."""
    changes = {"drive.amplitude": math.sqrt(2) * current, "drive.frequency": frequency}
    return attraction("current", changes)


def attraction_over_gaps() -> float:
    """Compute the attraction of a prescribed current at a gap of 100 um over that at 0.1 um."""
    wide, narrow = (attraction("current", {"stack.gap.thickness": gap}) for gap in (100e-6, 0.1e-6))
    return wide / narrow


CHECKS = PAPER.checks(attraction_of, attraction_over_gaps, gap_field)
