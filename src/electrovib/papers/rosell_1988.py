"""J. Rosell et al., "Skin impedance from 1 Hz to 1 MHz", IEEE Transactions on Biomedical Engineering 35, 649, 1988.

doi:10.1109/10.4599. Resistances of palm and fingertip that other laboratories measured are declared here too, each with its own
group; and how much sliding raises the impedance of a finger on a display.

Claims: the impedance of 1 cm2 of gelled skin at ten sites of thorax, leg and forehead is 10 kohm to 1 Mohm at 1 Hz, 220 ohm at
100 kHz and 120 ohm at 1 MHz, ten people. Does not claim: fingertips, a thickness, the share of the tissue below the skin, which
is most of what is left at 1 MHz.
"""

from __future__ import annotations

from electrovib.papers import published
from electrovib.scenario import Scenario
from electrovib.studies.evidence.quantities import magnitude

PAPER = published(__name__)
CITATIONS, CITATION, STATUS, NOT_READ, DEFECTS, PRESETS = PAPER.declared

AREA = 1e-4
"""Area that the two impedances are for, printed [m2]."""


def sliding_over_rest(scenario: Scenario) -> float:
    """Compute the impedance of a sliding finger over that of the same finger without a gap."""
    layers = {name: layer for name, layer in scenario.stack.layers.items() if name != "gap"}
    return float(magnitude(scenario) / magnitude(scenario.replace({"stack": layers})))


quantities = PAPER.quantities(sliding_over_rest)


def palm_resistivity() -> float:
    """Return the resistivity of palm if 200 um hold all of its resistance [ohm m]."""
    from electrovib.studies.evidence.files import of_publication

    return of_publication("rosell_1988")["palm"].values[0] * AREA / 200e-6


CHECKS = PAPER.checks(palm_resistivity)
