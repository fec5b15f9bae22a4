"""Quantities of a solution as numbers, with their diagnostics, and the validity of a scenario without a Trace."""

from __future__ import annotations

import functools
import math
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, Final

import numpy as np

from electrovib.core.diagnostics import Diagnostic
from electrovib.core.errors import ElectrovibError, InputError, nearest
from electrovib.physics.limits import MEAN_SQUARES
from electrovib.solve.choice import chosen
from electrovib.solve.diagnostics.judge import largest_of, largest_values
from electrovib.solve.expanded import Expanded
from electrovib.solve.mechanics.mechanical import READINGS
from electrovib.solve.quantities.names import Named
from electrovib.solve.quantities.resolve import (
    Resolved,
    of_extremes,
    resolve,
    taken_from,
    values_of,
    window,
)

if TYPE_CHECKING:
    from collections.abc import Sequence

    from electrovib.core.arrays import Real
    from electrovib.scenario import Scenario
    from electrovib.solve.diagnostics.peaks import PeakRecord
    from electrovib.solve.expanded import Record

MEAN_SQUARED: Final = ("voltage", "current", "body_current")
"""Quantities of a `PeakRecord` whose root mean square is computed."""
_MANY: Final = 2_000
"""Samples of a measured drive above which root-mean-square values are those of straight lines, as with time stepping."""
UNRESOLVED: Final = 1e-6
"""Error of the mean over the signal's largest value [1] above which a warning is returned."""


@dataclass(frozen=True)
class QuantityNumbers:
    """Quantities of one scenario.

    Parameters
    ----------
    values : dict of str to float
        By the name of the quantity, in the unit of its signal; NaN where the signal is unknown during part of the time.
    errors : dict of str to float
        Error of the polynomials of each signal, over its largest value [1].
    how : dict
        Solver, reason for its choice, events, and the errors of solver and reduction.
    diagnostics : list of Diagnostic
        Diagnostics of the solution.
    """

    values: dict[str, float]
    errors: dict[str, float]
    how: dict[str, Any]
    diagnostics: list[Diagnostic]


def answer(expanded: Expanded, names: Sequence[Named]) -> QuantityNumbers:
    """Compute quantities of a scenario, with their diagnostics.

    Between the corners of drive, load and motion each signal is a polynomial of degree 15 on pieces that are
    halved until its last coefficients are below 1e-10 of the signal's largest value; mean, square and
    extremes are those of the polynomial, so that they are independent of the output grid. The error of a
    time-stepping solver remains, and is stated.
    """
    values, found, held = numbers(expanded, names)
    errors = {each.name: found.error(each.key) for each in names if each not in held}
    return judged(expanded, found.record, values, errors)


def judged(
    expanded: Expanded, record: Record, values: dict[str, float], errors: dict[str, float]
) -> QuantityNumbers:
    """Return quantities with the diagnostics of the record that they were taken from."""
    found, stated = expanded.judge(record, declared_mean_squares)
    return QuantityNumbers(
        values, errors, record.how | stated, [*found, *_unknown(values), *_unresolved(errors)]
    )


def numbers(
    expanded: Expanded, names: Sequence[Named], *, alone: bool = False
) -> tuple[dict[str, float], Resolved, list[Named]]:
    """Compute quantities of a scenario, without diagnostics."""
    rig = expanded.scenario.rig
    held = [each for each in names if each.signal in READINGS and rig is not None and rig.digitiser]
    try:
        found = resolve(expanded, [each.key for each in names if each not in held], alone=alone)
        values = _readings(expanded, held)
    except KeyError as error:
        signal, have = str(error.args[0]), expanded.at(np.zeros(1)).signals
        raise InputError(
            f"quantity: this scenario has no signal '{signal}'.{nearest(signal, have)}"
        ) from None
    values |= {
        each.name: float(taken_from(each.taken, found.mesh, found.series[each.key]))
        for each in names
        if each not in held
    }
    return {each.name: values[each.name] for each in names}, found, held


def _readings(expanded: Expanded, held: Sequence[Named]) -> dict[str, float]:
    """Return quantities from the readings of a digitiser."""
    rig = expanded.scenario.rig
    if not held or rig is None or rig.digitiser is None:
        return {}
    end, rate = window(expanded.scenario)[0], rig.digitiser.sampling_rate
    times = np.arange(int(end * rate * (1 + 1e-12)) + 1) / rate
    record = expanded.at(times)
    return {each.name: of_record(each.taken, times, values_of(record, expanded, each.key)) for each in held}


def of_record(taken: str, times: Real, values: Real) -> float:
    """Return a quantity of a sampled signal, with linear interpolation between its samples.

    `times` (n,) [s], `values` (n,).
    """
    if not np.all(np.isfinite(values)):
        return math.nan
    if taken == "final" or len(times) == 1:
        return float({"peak": abs(values[-1]), "rms": abs(values[-1]), "swing": 0.0}.get(taken, values[-1]))
    first, last, steps = values[:-1], values[1:], np.diff(times)
    span = float(times[-1] - times[0])
    if taken == "mean":
        return float(steps @ (first + last)) / (2 * span)
    if taken == "rms":
        return math.sqrt(float(steps @ (first**2 + first * last + last**2)) / (3 * span))
    return float(of_extremes(taken, np.min(values), np.max(values)))


def root_mean_squares(
    expanded: Expanded, peaks: PeakRecord, names: Sequence[str] = MEAN_SQUARED
) -> dict[str, float]:
    """Return root-mean-square values from time 0 to the last output time, or over one period of a periodic state."""
    scenario = expanded.scenario
    amplified = scenario.circuit.amplifier is not None
    signals = {
        "voltage": "plate_voltage" if amplified else "drive_voltage",
        "current": "amplifier_current" if amplified else "current",
        "body_current": "current",
    }
    stamps = scenario.drive.time_stamps
    if (stamps is not None and len(stamps) > _MANY) or chosen(scenario).method.is_marched:
        whole = peaks.whole or peaks
        return {name: of_record("rms", whole.times, whole.rows[name]) for name in names}
    named = {name: Named("rms", signals[name]) for name in names}
    values = numbers(expanded, list(dict.fromkeys(named.values())), alone=True)[0] if named else {}
    return {name: values[each.name] for name, each in named.items()}


def declared_mean_squares(expanded: Expanded, peaks: PeakRecord) -> dict[str, float]:
    """Return the root mean squares whose limit is declared, by its name [V or A]; NaN of a current without a bound."""
    declared = [name for name in MEAN_SQUARES if getattr(expanded.scenario.limits, name) is not None]
    if not declared:
        return {}
    scenario = expanded.scenario
    reached = largest_values(scenario, expanded.section, peaks)
    names = [name.removeprefix("rms_") for name in declared]
    bounded = [name for name in names if math.isfinite(largest_of(reached, name))]
    found = dict.fromkeys(names, math.nan) | root_mean_squares(expanded, peaks, bounded)
    return {f"rms_{name}": value for name, value in found.items()}


def _unknown(values: dict[str, float]) -> list[Diagnostic]:
    """Return which quantities are unknown because their signal is."""
    lost = [name for name, value in values.items() if math.isnan(value)]
    text = f"{', '.join(lost)}: not known, because the signal is not known during part of the time"
    return [Diagnostic("quantities", "unknown", text)] if lost else []


def _unresolved(errors: dict[str, float]) -> list[Diagnostic]:
    """Return a warning where a signal varies faster than it could be resolved."""
    missed = {name: error for name, error in errors.items() if error > UNRESOLVED}
    if not missed:
        return []
    worst = max(missed, key=lambda name: missed[name])
    text = (
        f"{', '.join(missed)}: the signal varies too often to be resolved; the error of its mean may be about"
        f" {missed[worst]:.1g} of its largest value. A shorter time.duration resolves it better"
    )
    return [Diagnostic("resolution", "warning", text, missed[worst], UNRESOLVED, "1")]


@functools.lru_cache(maxsize=8)
def validity(scenario: Scenario) -> tuple[Diagnostic, ...]:
    """Judge a scenario, for every result that is no Trace of it."""
    try:
        expanded = Expanded(scenario)
        record = expanded.at(expanded.times, closely=True)
        return tuple(expanded.judge(record, declared_mean_squares)[0])
    except ElectrovibError as error:
        text = (
            f"the validity of this scenario is not known, because it cannot be simulated: {error.problems[0]}"
        )
        return (Diagnostic("validity", "unknown", text),)
