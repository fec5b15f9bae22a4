"""Error of a law's amplitudes over frequency due to the Debye sums of materials, and the time since a corner."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

import numpy as np

if TYPE_CHECKING:
    from electrovib.core.arrays import Real
    from electrovib.physics.force import ForceLaw
    from electrovib.solve.stack.section import ModalSection, PhasorSection


def since_corners(corners: Real, times: Real) -> Real:
    """Return the time since the last corner.

    `corners`, `times` (m,) [s]; returns `since` (n,) [s].
    """
    last = np.append(-np.inf, corners)[np.searchsorted(corners, times, side="right")]
    return np.asarray(times - last)


def transfer_error(
    law: ForceLaw, section: ModalSection, exact: PhasorSection, known: tuple[float, float]
) -> float:
    """Return the largest error of a law's amplitudes over frequency, with materials as sums of Debye terms."""
    reduced, declared = law.amplitudes(section), law.amplitudes(exact)
    inside = (exact.frequency >= known[0]) & (exact.frequency <= known[1])
    if not np.any(inside):
        return math.nan
    errors = []
    for name, value in declared.items():
        scale = float(np.max(np.abs(value)))
        difference = reduced[name].at(exact.frequency[inside]) - value[inside]
        errors.append(float(np.max(np.abs(difference))) / (scale or 1.0))
    return max(errors)
