"""Root-mean-square voltage and currents of a run."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Final

import numpy as np

from electrovib.solve.choice import chosen
from electrovib.solve.quantities.answer import numbers
from electrovib.solve.quantities.names import Named

if TYPE_CHECKING:
    from collections.abc import Collection

    from electrovib.core.arrays import Real
    from electrovib.solve.diagnostics.peaks import PeakRecord
    from electrovib.solve.expanded import Expanded

NAMES: Final = ("voltage", "current", "body_current")
"""Quantities of a `PeakRecord` whose root mean square is computed."""
_MANY: Final = 2_000
"""Samples of a measured drive above which root-mean-square values are those of straight lines, as with time stepping."""


def root_mean_squares(
    expanded: Expanded, peaks: PeakRecord, names: Collection[str] = NAMES
) -> dict[str, float]:
    """Return root-mean-square values from time 0 to the last output time, or over one period of a periodic state.

    Parameters
    ----------
    expanded : Expanded
        Prepared scenario.
    peaks : PeakRecord
        Quantities with limits over the whole run.
    names : collection of str
        Some of `NAMES`.

    Returns
    -------
    values : dict of str to float
        Root mean square by name [V or A].
    """
    scenario = expanded.scenario
    amplified = scenario.circuit.amplifier is not None
    voltage = "plate_voltage" if amplified else "drive_voltage"
    signals = {
        "voltage": voltage if scenario.drive.quantity == "voltage" else "stack_voltage",
        "current": "amplifier_current" if amplified else "current",
        "body_current": "current",
    }
    stamps = scenario.drive.time_stamps
    if (stamps is not None and len(stamps) > _MANY) or chosen(scenario).method.is_marched:
        whole = peaks.whole or peaks
        return {name: rms_of_lines(whole.times, whole.rows[name]) for name in names}
    named = {name: Named("rms", signals[name]) for name in names}
    values = numbers(expanded, list(dict.fromkeys(named.values())), alone=True)[0] if named else {}
    return {name: values[each.name] for name, each in named.items()}


def rms_of_lines(times: Real, values: Real) -> float:
    """Compute the root mean square of straight lines between samples.

    Parameters
    ----------
    times, values : ndarray, shape (n,)
        Increasing times [s], and values in any unit.

    Returns
    -------
    rms : float
        In the unit of the values; NaN without two times.
    """
    lengths = np.diff(times)
    first, last = values[:-1], values[1:]
    span = float(np.sum(lengths))
    if span <= 0:
        return math.nan
    return math.sqrt(float(np.sum(lengths * (first**2 + first * last + last**2))) / 3 / span)
