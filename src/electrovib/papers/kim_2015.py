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

from electrovib.core.citation import Check, derived
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


def _derived(name: str, expect: float, current: float, frequency: float) -> Check:
    changes = {"drive.amplitude": math.sqrt(2) * current, "drive.frequency": frequency}
    return derived(
        name,
        expect=expect,
        rtol=1e-3,
        source="I_rms^2/(2 eps0 A w^2), evaluated independently of this code, four digits",
        compute=lambda: attraction("current", changes),
    )


CHECKS = (
    _derived("mean attraction, 1 mA rms, 25 kHz, 1 cm2", 22.89e-3, 1e-3, 25e3),
    _derived("mean attraction, 0.1 mA rms, 1 kHz, 1 cm2", 143.0e-3, 1e-4, 1e3),
    _derived("mean attraction, 1 mA rms, 5 kHz, 1 cm2", 572.2e-3, 1e-3, 5e3),
    derived(
        "attraction at a gap of 100 um over that at 0.1 um, prescribed current",
        expect=1.0,
        rtol=1e-9,
        source="identity: under a prescribed current the gap's field does not depend on any other layer",
        compute=lambda: (
            attraction("current", {"stack.gap.thickness": 100e-6})
            / attraction("current", {"stack.gap.thickness": 0.1e-6})
        ),
    ),
    derived(
        "root-mean-square gap field, 1 mA rms, 25 kHz, 1 cm2",
        expect=7.19e6,
        rtol=1e-3,
        source="I_rms/(w eps0 A), evaluated independently of this code, three digits",
        compute=lambda: gap_field(current=1e-3, frequency=25e3),
    ),
)
