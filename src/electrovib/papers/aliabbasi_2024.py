"""E. AliAbbasi and others: gap and force from impedances, Advanced Intelligent Systems 2024.

"Experimental estimation of gap thickness and electrostatic forces between contacting surfaces under
electroadhesion".

Claims: the impedance that remains of finger on touchscreen after skin and screen are subtracted is that of the
air gap, which gives its thickness and the force; at low frequency an electrode polarisation impedance lies in
parallel with the gap and leaks its charge. Does not claim: a gap in micrometres, the form and values of
the polarisation impedance (none was read). Here the leak is an ohmic resistivity of the gap, a choice. On an
insulator that blocks, the gap field then has a lower corner at f_c = 1/(2 pi R_g (C_g + C_i)), set by the leak and
the coating; the skin shifts it only where its impedance is not small compared with theirs.
"""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from electrovib.core.constants import VACUUM_PERMITTIVITY as eps0
from electrovib.papers import mean_attraction, published
from electrovib.papers.vezzoli_2014 import values
from electrovib.physics.material import Material
from electrovib.scenario import Scenario

PAPER = published(__name__)
CITATIONS, CITATION, STATUS, NOT_READ, DEFECTS, PRESETS = PAPER.declared
scenarios = PAPER.scenarios


_BAND = np.geomspace(1e-2, 2e6, 6001)


def chain(
    *, gap_resistivity: float, skin: Material | str | None = None, resistance: float = 1500.0
) -> Scenario:
    """Return coating, leaky gap [ohm m] and skin in series; without a skin the finger is a conductor."""
    base = scenarios()["chain"]
    layers = base.stack.to_dict()
    layers["gap"]["material"]["conductivity"] = 1 / gap_resistivity
    finger = layers.pop("stratum_corneum")
    if skin is not None:
        layers["stratum_corneum"] = finger | {"material": skin}
    return base.replace({"stack": layers, "circuit.return_path.resistance": resistance})


def corner(*, gap: float, gap_resistivity: float) -> float:
    """Compute the lower corner frequency of the gap field on the coating: 1/(2 pi R_g (C_g + C_i)) [Hz].

    There the field is 1/sqrt(2) of its plateau (-3 dB) and the mean force half of its.
    """
    coating = values.COATING_PERMITTIVITY / values.COATING_THICKNESS
    return 1 / (2 * math.pi * eps0 * gap_resistivity * gap * (1 / gap + coating))


def rises_to(scenario: Scenario, *, share: float) -> float:
    """Return the lowest frequency [Hz] at which the mean attraction has a share of its largest value; 0.5 is -3 dB."""
    force = mean_attraction(scenario, _BAND, amplitude=100.0)
    after = int(np.argmax(force >= share * force.max()))
    if after == 0:
        return float(_BAND[0])
    near = slice(after - 1, after + 1)
    return float(np.exp(np.interp(share, force[near] / force.max(), np.log(_BAND[near]))))


def remaining_impedance(scenario: Scenario, frequency: NDArray[np.float64]) -> NDArray[np.complex128]:
    """Compute the impedance of the gap [ohm] as the paper measures it: the total less skin, screen and body."""
    from electrovib.solve.stack.expand import phasors

    area = scenario.contact_area
    total = 1 / (phasors(scenario, frequency).current_density * area)
    known = [
        scenario.stack.layers[name].impedance(frequency) / area for name in ("insulator", "stratum_corneum")
    ]
    left: NDArray[np.complex128] = total - sum(known) - scenario.circuit.element().impedance(frequency)
    return left


def estimate(scenario: Scenario, *, frequency: float, voltage: float) -> tuple[float, float]:
    """Compute gap [m] and force [N] from the remaining impedance Z at a frequency [Hz] and peak voltage [V].

    The gap is eps0 A w/Im(1/Z), which a leak in parallel does not change; the mean attraction is eps0 A
    |V_g/g|^2/4, where V_g is the voltage of the remaining impedance.
    """
    from electrovib.solve.stack.expand import phasors

    area, at = scenario.contact_area, np.array([frequency])
    left = complex(remaining_impedance(scenario, at)[0])
    gap = eps0 * area * 2 * math.pi * frequency / (1 / left).imag
    current = complex(phasors(scenario, at).current_density[0]) * area * voltage
    return gap, eps0 * area * abs(current * left / gap) ** 2 / 4


def half_force(*, gap_resistivity: float) -> float:
    """Return the frequency [Hz] of half of the largest force, on a finger that conducts, for a leak of the gap [ohm m]."""
    return rises_to(chain(gap_resistivity=gap_resistivity, resistance=0.0), share=0.5)


def estimated_gap(*, frequency: float) -> float:
    """Return the gap from the impedances at a frequency [Hz], in m."""
    return estimate(scenarios()["chain"], frequency=frequency, voltage=100.0)[0]


def estimate_against_law(*, frequency: float) -> float:
    """Return the force from the impedances over that of the law, at a frequency [Hz]."""
    scenario = scenarios()["chain"]
    law = mean_attraction(scenario, frequency, amplitude=100.0)
    return estimate(scenario, frequency=frequency, voltage=100.0)[1] / float(law[0])


CHECKS = PAPER.checks(half_force, estimated_gap, estimate_against_law)
