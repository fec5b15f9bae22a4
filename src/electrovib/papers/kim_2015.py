"""H. Kim and others, electrovibration of uniform intensity by control of the current, IEEE Trans. Haptics 8(4), 2015.

Claims: a prescribed current, in the place of a prescribed voltage, makes the sensation the same for different
fingers and contact conditions. Does not claim: an equation, a current, a frequency (none was read; the paper is
cited from memory, unverified, and no page of it was found). The consequences of a prescribed current are computed
here: through a gap that does not leak E = I/(w eps0 A), so the mean attraction I_rms^2/(2 eps0 A w^2) depends neither
on the gap nor on the insulator nor on the skin. It does depend on the contact area, as 1/A; and current that passes
beside the gap, through stray capacitance or a leak, does not attract.
"""

from __future__ import annotations

import functools
import math
from typing import Any

import numpy as np

from electrovib.core.citation import Check, derived
from electrovib.core.constants import VACUUM_PERMITTIVITY as eps0
from electrovib.papers import cited_as, not_read, preset_notes
from electrovib.papers.vezzoli_2014 import values
from electrovib.scenario import AIR, Scenario, preset

CITATIONS, CITATION = cited_as(__name__)
STATUS = "unverified"
PRESETS = preset_notes(__name__)
NOT_READ = not_read(__name__)

CURRENT, FREQUENCY = 1e-3, 25e3
"""Root-mean-square current [A] and frequency [Hz] of the preset, a choice."""
AREA, GAP = 1e-4, 2e-6
CHOICE = "not read; a choice"
VEZZOLI = "not read; as in vezzoli_2014, section 3.1"


def gap_field(*, current: float, frequency: float, area: float = AREA) -> float:
    """Return the root-mean-square gap field [V/m] of a current [A, rms] at a frequency [Hz] on an area [m2]."""
    return current / (2 * math.pi * frequency * eps0 * area)


def _finger(title: str, drive: dict[str, Any]) -> Scenario:
    return preset(
        title=f"Kim 2015: {title}",
        unchanged=CHOICE,
        changes={
            "drive": (drive, CHOICE),
            "time.initial_state.model": "PeriodicState",
            "stack": {
                "insulator": (values.FILM, VEZZOLI),
                "gap": {"thickness": (GAP, CHOICE), "material": AIR},
                "stratum_corneum": values.point_layer(VEZZOLI),
            },
        },
    )


def _gap_field(scenario: Scenario) -> float:
    """Return the field of the gap per volt or ampere of the drive [V/m]."""
    from electrovib.solve.stack.expand import phasors

    return float(abs(phasors(scenario, np.array([FREQUENCY]))["gap"].field[0]))


@functools.cache
def scenarios() -> dict[str, Scenario]:
    """Return one finger under a prescribed current, and under a voltage of the same attraction at this gap."""
    title, amplitude = "prescribed voltage of the same attraction", math.sqrt(2) * CURRENT
    current = {"model": "CurrentSine", "amplitude": amplitude, "frequency": FREQUENCY}
    prescribed = _finger("prescribed current, 1 mA rms at 25 kHz", current)
    held = {"model": "Sine", "amplitude": 1.0, "frequency": FREQUENCY}
    voltage = amplitude * _gap_field(prescribed) / _gap_field(_finger(title, held))
    return {"current": prescribed, "voltage": _finger(title, held | {"amplitude": voltage})}


def mean_attraction(name: str, changes: dict[str, Any] | None = None) -> float:
    """Compute the mean attraction of a preset with some parameters changed, at its drive's frequency and peak."""
    from electrovib.solve.electrics.attraction import mean_force
    from electrovib.solve.stack.expand import phasors

    scenario = scenarios()[name].replace(changes or {})
    drive: Any = scenario.drive
    section = phasors(scenario, np.array([drive.frequency]))
    return float(mean_force(scenario, section, amplitude=drive.amplitude)[0])


def _derived(name: str, expect: float, current: float, frequency: float) -> Check:
    changes = {"drive.amplitude": math.sqrt(2) * current, "drive.frequency": frequency}
    return derived(
        name,
        expect=expect,
        rtol=1e-3,
        source="I_rms^2/(2 eps0 A w^2), evaluated independently of this code, four digits",
        compute=lambda: mean_attraction("current", changes),
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
            mean_attraction("current", {"stack.gap.thickness": 100e-6})
            / mean_attraction("current", {"stack.gap.thickness": 0.1e-6})
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
