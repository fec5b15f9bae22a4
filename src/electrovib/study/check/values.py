"""Largest and root-mean-square values of a drive in a scenario."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import TYPE_CHECKING, Final

import numpy as np

from electrovib.physics.drive.pieces import Linear
from electrovib.physics.limits import SWITCH_ON, WORDS
from electrovib.solve.choice import chosen
from electrovib.solve.diagnostics import running_currents
from electrovib.solve.diagnostics.judge import largest_values, stack_diagnostics
from electrovib.solve.expanded import OF_ELECTRICS, Expanded
from electrovib.solve.quantities.answer import numbers
from electrovib.solve.quantities.names import Named

if TYPE_CHECKING:
    from electrovib.core.arrays import Real
    from electrovib.core.diagnostics import Diagnostic
    from electrovib.physics.drive.base import Drive
    from electrovib.scenario import Scenario
    from electrovib.solve.diagnostics.peaks import PeakRecord

_BREAKDOWN: Final = ("film strength", "Paschen", "field emission")
"""Beginnings of the names of the diagnostics of breakdown."""
_MANY: Final = 2_000
"""Samples of a measured drive above which root-mean-square values are those of straight lines, as with time stepping."""


@dataclass(frozen=True)
class CheckedValues:
    """Values of a run that limits are compared with.

    Parameters
    ----------
    largest : dict of str to float
        Largest absolute value by the name of its limit, at switch-on too; NaN where it is not known, infinite where it has
        no bound.
    rms : dict of str to float
        Root-mean-square of ``voltage``, ``current`` and ``body_current`` over the run, NaN where it is not known.
    breakdown : list of Diagnostic
        Of each layer with a known strength, and of air.
    slew : float
        Largest rate of change of the drive [V/s, or A/s of a current drive]; infinite at a discontinuity.
    end : float
        Last time of the run [s].
    """

    largest: dict[str, float]
    rms: dict[str, float]
    breakdown: list[Diagnostic]
    slew: float
    end: float


def checked_values(scenario: Scenario) -> CheckedValues:
    """Solve a scenario for the values that limits are compared with.

    Parameters
    ----------
    scenario : Scenario
        Experiment with the drive.

    Returns
    -------
    CheckedValues
        From time 0 to the last output time, or over one period of a periodic state.

    Raises
    ------
    InputError
        If models cannot be combined.
    BudgetError
        If the run would take more time or memory than is allowed.
    """
    expanded = Expanded(scenario, mechanics=False)
    record = expanded.at(expanded.times, closely=True, wanted=OF_ELECTRICS)
    assert record.peaks is not None
    peaks = record.peaks.without_overshoot()
    reached = largest_values(scenario, peaks, running_currents(scenario, expanded.section, peaks))
    largest = {
        name: max(reached[name], reached.get(name + SWITCH_ON, 0.0)) if name in reached else math.nan
        for name in WORDS
    }
    end = float(expanded.times[-1])
    found = stack_diagnostics(scenario, peaks)
    return CheckedValues(
        largest=largest,
        rms=_rms(scenario, expanded, peaks, largest),
        breakdown=[each for each in found if each.name.startswith(_BREAKDOWN)],
        slew=slew_of(scenario.drive, end),
        end=end,
    )


def slew_of(drive: Drive, end: float) -> float:
    """Return the largest absolute rate of change of a drive.

    Parameters
    ----------
    drive : Drive
        From 0 before time 0.
    end : float
        Last time [s].

    Returns
    -------
    slew : float
        V/s, or A/s of a current drive; infinite where the drive is discontinuous. Exact for straight pieces; of tones and
        formulas the bound 2 pi f times the amplitude is used.
    """
    parts = drive.parts()
    scale = sum(part.bound() for part in parts)
    heights = drive.corners(end)[1]
    if abs(float(drive.voltage(0.0))) > 1e-9 * scale or np.any(np.abs(heights) > 1e-9 * scale):
        return math.inf
    total = 0.0
    for part in parts:
        if isinstance(part, Linear):
            inside = part.times[:-1] < end
            total += float(np.max(np.abs(part.slopes()[:-1][inside]), initial=0.0))
        else:
            total += 2 * math.pi * part.highest_frequency * part.bound()
    return total


def _rms(
    scenario: Scenario, expanded: Expanded, peaks: PeakRecord, largest: dict[str, float]
) -> dict[str, float]:
    """Return root-mean-square values; infinite or unknown peaks give NaN for the current."""
    amplified = scenario.circuit.amplifier is not None
    signals = {
        "voltage": "plate_voltage" if amplified else "drive_voltage",
        "current": "amplifier_current" if amplified else "current",
        "body_current": "current",
    }
    if scenario.drive.quantity == "current":
        signals["voltage"] = "stack_voltage"
    found = dict.fromkeys(signals, math.nan)
    known = {name: signal for name, signal in signals.items() if math.isfinite(largest[name])}
    stamps = scenario.drive.time_stamps
    if (stamps is not None and len(stamps) > _MANY) or chosen(scenario).method.is_marched:
        whole = peaks.whole or peaks
        return found | {name: rms_of_lines(whole.times, whole.rows[name]) for name in known}
    names = {name: Named("rms", signal) for name, signal in known.items()}
    values = numbers(expanded, list(dict.fromkeys(names.values())), alone=True)[0]
    return found | {name: values[each.name] for name, each in names.items()}


def rms_of_lines(times: Real, values: Real) -> float:
    """Compute the root-mean-square of straight lines between samples.

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
