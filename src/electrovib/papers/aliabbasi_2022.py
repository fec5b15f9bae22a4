"""E. AliAbbasi, M. R. A. Sormoli, C. Basdogan: electrostatic force of a finger over frequency, 2022.

"Frequency-dependent behavior of electrostatic forces between human finger and touch screen under electroadhesion",
IEEE Transactions on Haptics 15, 416, 2022 (first sentence of the abstract); E. AliAbbasi, thesis, arXiv:2409.18725 (abstract).

Claims: circuits with lumped parameters do not have the observed force over frequency (first sentence of the abstract); the
force rises and falls with frequency, with a maximum near 250 Hz (cited from memory, unverified); below
250 Hz it changes by leakage of charge from the stratum corneum, above by the electrical properties of the stratum corneum
(abstract of the thesis). Does not claim: a gap, a leak, curves (none was read). In the chain of aliabbasi_2024 the
rise is the corner of the leaking gap and the fall the dispersion of the skin (for skin without dispersion, the
resistance of the body). The frequency of the maximum is therefore about inversely proportional to the resistivity of
the gap, and 250 Hz is a fit of the leak, not a constant of fingers. The maximum is flat and its frequency
ill-conditioned; the corner is well-conditioned. Conducting skin without dispersion also has a shallow maximum if the gap
leaks more slowly than the skin relaxes.
"""

from __future__ import annotations

import math

import numpy as np

from electrovib.papers import aliabbasi_2024, mean_attraction, published
from electrovib.physics.material import Material
from electrovib.scenario import Scenario

PAPER = published(__name__)
CITATIONS, CITATION, STATUS, NOT_READ, DEFECTS, PRESETS = PAPER.declared
scenarios = PAPER.scenarios

_LOWEST, _HIGHEST = 1e-2, 2e6
_SAMPLES = 6001


def maximum(scenario: Scenario) -> float | None:
    """Return the frequency of the largest mean attraction [Hz]; None without a maximum between 0.01 Hz and 2 MHz."""
    frequency = np.geomspace(_LOWEST, _HIGHEST, _SAMPLES)
    force = mean_attraction(scenario, frequency, amplitude=100.0)
    top = int(np.argmax(force))
    if top in (0, _SAMPLES - 1):
        return None
    before, at, after = np.log(force[top - 1 : top + 2])
    shift = (before - after) / (2 * (before - 2 * at + after))  # apex of the parabola through three points
    return float(frequency[top] * (frequency[1] / frequency[0]) ** shift)


def maximum_of(*, gap_resistivity: float, skin: Material | str, resistance: float = 0.0) -> float:
    """Return the frequency of the largest mean attraction of the chain [Hz]; NaN without one, as for `maximum`."""
    scenario = aliabbasi_2024.chain(gap_resistivity=gap_resistivity, skin=skin, resistance=resistance)
    found = maximum(scenario)
    return math.nan if found is None else found


CHECKS = PAPER.checks(maximum_of)
