"""The capacitance of the contact over time, as a meter reads it at the frequency of the sine that drives it."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from electrovib.solve.stack.expand import per_volt_of
from electrovib.solve.stack.harmonics import count_harmonics, spectrum

if TYPE_CHECKING:
    from electrovib.core.arrays import Real
    from electrovib.scenario import Scenario


def sine_of(scenario: Scenario) -> Real | None:
    """Return the frequency at which a scenario has a capacitance.

    Returns `frequency` (1,) [Hz].
    """
    if count_harmonics(scenario.drive) is None or scenario.motion.moved_gap or scenario.contact.closing:
        return None
    frequencies, tones = spectrum(scenario.drive, harmonics=1)
    found = frequencies[(frequencies > 0) & (tones != 0)]
    return found if found.size == 1 else None


def capacitance(scenario: Scenario, times: Real) -> dict[str, tuple[tuple[str], Real]]:
    """Compute the capacitance that is in parallel with a conductance in the admittance seen by the drive.

    `times` (n,) [s].
    """
    frequency = sine_of(scenario)
    if frequency is None:
        return {}
    area = scenario.contact.outline(scenario.load.forces(times))
    admittance = area * per_volt_of(scenario, frequency, area=area).current_density
    return {"capacitance": (("time",), admittance.imag / (2 * np.pi * frequency))}
