"""C. D. Shultz, M. A. Peshkin, J. E. Colgate: electrical impedance of sliding fingertips, Haptics Symposium 2018.

"On the electrical characterization of electroadhesive displays and the prominent interfacial gap impedance
associated with sliding fingertips".

Claims: skin, body, coating, electrode and an interfacial gap are impedances in series; sliding raises the total
by 100 to 1000 %, only the gap explains the rise, and it vanishes when the finger stops; linear only at high
frequency or small current. Does not claim: values of the elements, a gap, a force (none was read). With
capacitors alone a gap g multiplies the impedance by r = 1 + g/K, K the electrical thickness without gap, and the
same r divides the gap field at fixed voltage: the attraction by the Maxwell stress in the gap is that of contact over r^2.
"""

from __future__ import annotations

import numpy as np

from electrovib.papers import mean_attraction, published

PAPER = published(__name__)
CITATIONS, CITATION, STATUS, NOT_READ, DEFECTS, PRESETS = PAPER.declared
scenarios = PAPER.scenarios


_CARRIER = 1e5
"""Frequency at which the skin's conduction is negligible, the linear regime of the abstract [Hz]."""


def sliding_over_rest(*, gap: float) -> tuple[float, float]:
    """Compare a sliding finger with a resting one at 100 kHz, without body and electrode.

    Ratios, sliding over rest: magnitude of the impedance, and mean attraction in the gap.
    """
    from electrovib.solve.stack.expand import phasors

    at = np.array([_CARRIER])
    found = []
    for name, changes in (("sliding", {"stack.gap.thickness": gap}), ("at_rest", {})):
        scenario = scenarios()[name].replace({**changes, "circuit.return_path.resistance": 0.0})
        section = phasors(scenario, at)
        found.append(
            (
                1 / abs(section.current_density[0]),
                float(mean_attraction(scenario, _CARRIER, amplitude=100.0)[0]),
            )
        )
    (impedance, force), (impedance_at_rest, force_at_rest) = found
    return float(impedance / impedance_at_rest), force / force_at_rest


def force_at_rest_over(*, gap: float) -> float:
    """Return the inverse of the second: the attraction of a resting finger over that of a sliding one."""
    return 1 / sliding_over_rest(gap=gap)[1]


CHECKS = PAPER.checks(sliding_over_rest, force_at_rest_over)
