"""R. M. Strong, D. E. Troxel, "An electrotactile display", IEEE Transactions on Man-Machine Systems 11(1), 1970.

Claims: exploring the display gives a sensation of texture whose intensity is set primarily by the peak applied
voltage, not by the current density. Does not claim: an equation, a thickness, a permittivity, a
threshold in volts (none was read). The law of one dielectric between two plates, eps0 eps A V^2/(2 d^2), is cited from
memory, unverified; it is the Maxwell stress in the insulator with the whole voltage on the insulator, smaller than the
Maxwell stress in the gap by the factor eps.
"""

from __future__ import annotations

import numpy as np

from electrovib.core.citation import Check, derived
from electrovib.papers import mean_attraction, published
from electrovib.papers.vezzoli_2014 import values

PAPER = published(__name__)
CITATIONS, CITATION, STATUS, NOT_READ, DEFECTS, PRESETS = PAPER.declared
scenarios = PAPER.scenarios

VOLTAGE = 1000.0
"""Peak voltage of the preset, a choice [V]."""


def static_force(*, thickness: float, permittivity: float, area: float, voltage: float) -> float:
    """Compute the attraction [N] of a capacitor with one dielectric: eps0 eps A V^2/(2 d^2).

    The form is cited from memory, unverified.
    """
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


CHECKS = (
    derived(
        "static force of one dielectric layer at 1000 V",
        expect=0.183096,
        rtol=1e-5,
        source="stress D E/2 in a plate capacitor, film of vezzoli_2014, computed by hand",
        compute=lambda: attraction("MaxwellStressInInsulator", voltage=VOLTAGE),
    ),
    derived(
        "Maxwell stress in the gap over this law",
        expect=3.35,
        rtol=1e-9,
        source="identity: one displacement, permittivity of the insulator against that of air",
        compute=lambda: (
            attraction("MaxwellStressInGap", voltage=VOLTAGE)
            / attraction("MaxwellStressInInsulator", voltage=VOLTAGE)
        ),
    ),
    Check(
        "attraction at 10 kHz over 100 Hz, one peak voltage",
        expect=1.0,
        rtol=1e-4,
        source="abstract: peak voltage sets the sensation, not current density; 1 kohm of body takes 4e-6",
        compute=lambda: against_frequency(low=100.0, high=1e4)[0],
        status="abstract",
    ),
    derived(
        "current density at 10 kHz over 100 Hz, one peak voltage",
        expect=100.0,
        rtol=1e-4,
        source="the current of a capacitor is proportional to the frequency while the attraction above is constant",
        compute=lambda: against_frequency(low=100.0, high=1e4)[1],
    ),
)
