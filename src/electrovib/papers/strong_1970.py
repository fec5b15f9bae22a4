"""R. M. Strong, D. E. Troxel, "An electrotactile display", IEEE Transactions on Man-Machine Systems 11(1), 1970.

Claims: exploring the display gives a sensation of texture whose intensity is set primarily by the peak applied
voltage, not by the current density. Does not claim: an equation, a thickness, a permittivity, a
threshold in volts (none was read). The law of one dielectric between two plates, eps0 eps A V^2/(2 d^2), is cited from
memory, unverified; it is the Maxwell stress in the insulator with the whole voltage on the insulator, smaller than the
Maxwell stress in the gap by the factor eps.
"""

from __future__ import annotations

import numpy as np

from electrovib.papers import mean_attraction, published
from electrovib.papers.vezzoli_2014 import values

PAPER = published(__name__)
CITATIONS, CITATION, STATUS, NOT_READ, DEFECTS, PRESETS = PAPER.declared
scenarios = PAPER.scenarios

VOLTAGE = 1000.0
"""Peak voltage of the preset, a choice [V]."""


def static_force(*, thickness: float, permittivity: float, area: float, voltage: float) -> float:
    """Compute the attraction [N] of a capacitor of one dielectric: eps0 eps A V^2/(2 d^2), cited from memory, unverified."""
    return (
        values.capacitance(permittivity=permittivity, thickness=thickness, area=area)
        * voltage**2
        / (2 * thickness)
    )


def attraction(law: str, *, voltage: float) -> float:
    """Compute the attraction [N] of the display under a constant voltage [V] by the force law of a name."""
    from electrovib.solve.simulate import simulate

    held = scenarios()["display"].replace({"force.model": law, "drive": {"model": "Step", "level": voltage}})
    return float(simulate(held, time=np.array([0.0, 1e-3])).electrostatic_force[-1])


def against_frequency(*, low: float, high: float) -> tuple[float, float]:
    """Compare two frequencies [Hz] at one peak voltage: ratios, high over low, of mean attraction and current density."""
    from electrovib.solve.stack.expand import phasors

    display = scenarios()["display"]
    section = phasors(display, np.array([low, high]))
    force = mean_attraction(display, np.array([low, high]), amplitude=VOLTAGE)
    current = np.abs(section.current_density)
    return float(force[1] / force[0]), float(current[1] / current[0])


def gap_over_insulator(*, voltage: float) -> float:
    """Return the Maxwell stress in the gap over this law."""
    gap, insulator = (
        attraction(f"MaxwellStressIn{place}", voltage=voltage) for place in ("Gap", "Insulator")
    )
    return gap / insulator


CHECKS = PAPER.checks(attraction, gap_over_insulator, against_frequency)
