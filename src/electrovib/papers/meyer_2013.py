"""D. J. Meyer, M. A. Peshkin, J. E. Colgate, "Fingertip friction modulation due to electrostatic attraction", 2013.

World Haptics Conference, 43-48.

Claims: friction, and the attraction inferred from it, grows as the square of the voltage, with large differences
between persons; a first-order circuit of skin and coating predicts a cut-off below about 500 Hz; the
measurements are unambiguously at odds with that model. Does not claim: a coating, a voltage, an
area, a load, values of the force (none was read). Here the model is the high-pass of the stratum corneum's voltage,
C_i in series with C_s and R_s, so its cut-off is 1/(2 pi (C_i + C_s) R_s). Vezzoli et al. 2014 interpret the same
data as rising from 100 Hz and then saturating, which is such a high-pass with dispersive skin.
"""

from __future__ import annotations

import math

import numpy as np

from electrovib.core.constants import VACUUM_PERMITTIVITY as eps0
from electrovib.papers import mean_attraction, published
from electrovib.papers.vezzoli_2014 import values
from electrovib.physics.material import Constant, Material

PAPER = published(__name__)
CITATIONS, CITATION, STATUS, NOT_READ, DEFECTS, PRESETS = PAPER.declared
scenarios = PAPER.scenarios


def time_constant(cut_off: float) -> float:
    """Return the time constant [s] of a first-order circuit with this cut-off [Hz]."""
    return 1 / (2 * math.pi * cut_off)


def capacitance_ratio() -> float:
    """Return C_i over C_s for the coating chosen here and the skin of Vezzoli et al. 2014."""
    coating = values.capacitance(
        permittivity=values.COATING_PERMITTIVITY, thickness=values.COATING_THICKNESS, area=values.AREA
    )
    return coating / values.skin_capacitance()


def first_order_skin(*, time_constant: float) -> Constant:
    """Return the skin with which the first-order circuit of the coating has a time constant (C_i + C_s) R_s [s].

    The permittivity is that of Vezzoli et al. 2014; the conductivity follows from the time constant, which is
    circular.
    """
    conductivity = eps0 * values.SKIN_PERMITTIVITY * (1 + capacitance_ratio()) / time_constant
    return Constant(permittivity=values.SKIN_PERMITTIVITY, conductivity=conductivity)


def cut_off(skin: Material) -> float:
    """Compute the cut-off [Hz] that the first-order circuit of the coating predicts for a skin 200 um thick.

    It is the lowest frequency between 0.1 Hz and 1 MHz at which w (C_i + C_s) R_s is 1 with the skin's values
    at that frequency; NaN if there is none, for instance if the skin does not conduct.
    """
    frequency = np.geomspace(0.1, 1e6, 4001)
    permittivity = skin.complex_permittivity(frequency)
    coating = values.COATING_PERMITTIVITY / values.COATING_THICKNESS * values.SKIN_THICKNESS
    turns = np.log((permittivity.real + coating) / -permittivity.imag)
    if turns[0] > 0 or turns.max() < 0:
        return math.nan
    after = int(np.argmax(turns >= 0))
    near = slice(after - 1, after + 1)
    return float(np.exp(np.interp(0.0, turns[near], np.log(frequency[near]))))


def cut_off_of(*, skin: str) -> float:
    """Compute the cut-off [Hz] for a published skin, ``author_year/name``."""
    return cut_off(Material.model_validate(skin))


def share_of_plateau(*, frequency: float) -> float:
    """Return the mean attraction of the first-order scenario at a frequency [Hz], over that at 1 GHz."""
    scenario = scenarios()["first_order"]
    force = mean_attraction(scenario, np.array([frequency, 1e9]), amplitude=100.0)
    return float(force[0] / force[1])


def voltage_exponent() -> float:
    """Return the exponent of the mean attraction as a power of the voltage, between 50 and 100 V."""
    scenario = scenarios()["first_order"]
    force = [float(mean_attraction(scenario, 1000.0, amplitude=voltage)[0]) for voltage in (50.0, 100.0)]
    return math.log2(force[1] / force[0])


CHECKS = PAPER.checks(time_constant, share_of_plateau, cut_off_of, capacitance_ratio, voltage_exponent)
