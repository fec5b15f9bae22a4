"""C. D. Shultz, M. A. Peshkin, J. E. Colgate, surface haptics via electroadhesion, World Haptics Conference 2015.

Claims: a coating that leaks, in the place of one that insulates, puts nearly all of a DC voltage across the gap between
finger and coating, the Johnsen-Rahbek effect, so that the attraction eps0 A (V_gap/g)^2/2 persists under DC where that of
an insulating coating decays. Does not claim: values of coating, gap and voltage (none was read; the text is cited from
memory, unverified, and the title is from a list of references). The law is MaxwellStressInGap on layers that conduct. The
final attraction depends on which layer leaks least: the coating has to conduct better than the gap, rho_c T_c < rho_g g.
"""

from __future__ import annotations

import numpy as np

from electrovib.core.constants import VACUUM_PERMITTIVITY as eps0
from electrovib.papers import published

PAPER = published(__name__)
CITATIONS, CITATION, STATUS, NOT_READ, DEFECTS, PRESETS = PAPER.declared
scenarios = PAPER.scenarios


def gap_force(*, voltage: float, gap: float, area: float) -> float:
    """Compute the attraction with the whole voltage across the gap, eps0 A (V/g)^2/2 (cited from memory, unverified)."""
    return eps0 * area * (voltage / gap) ** 2 / 2


def settled_force(name: str) -> float:
    """Return the attraction long after the voltage is switched on [N]."""
    from electrovib.solve.simulate import simulate

    force = simulate(scenarios()[name], time=np.array([0.0, 1e4])).electrostatic_force.values
    return float(force[-1])


CHECKS = PAPER.checks(gap_force, settled_force)
