"""Refinement of a record of largest values, for a solver in closed form."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from electrovib.solve.diagnostics.peaks import REFINEMENTS

if TYPE_CHECKING:
    from collections.abc import Callable

    from electrovib.core.arrays import Real
    from electrovib.solve.diagnostics.peaks import PeakRecord


def refined(record: PeakRecord, look: Callable[[Real], PeakRecord]) -> PeakRecord:
    """Add evaluation times around each largest value that its neighbours do not resolve."""
    for _ in range(REFINEMENTS):
        wanted = np.setdiff1d(record.unclear(), record.times)
        if not len(wanted):
            break
        record = record.joined(look(wanted))
    return record
