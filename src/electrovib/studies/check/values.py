"""Largest and root-mean-square values of a drive in a scenario."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import TYPE_CHECKING

from electrovib.physics.limits import MEAN_SQUARES, WORDS
from electrovib.solve.diagnostics.judge import (
    largest_of,
    largest_values,
    slew_rate,
    stack_diagnostics,
)
from electrovib.solve.expanded import OF_ELECTRICS, Expanded
from electrovib.solve.quantities.answer import MEAN_SQUARED, root_mean_squares
from electrovib.studies.check.result import BREAKDOWN

if TYPE_CHECKING:
    from electrovib.core.diagnostics import Diagnostic
    from electrovib.scenario import Scenario


@dataclass(frozen=True)
class CheckedValues:
    """Values of a run by the name of their limit; NaN where not known, infinite where they have no bound."""

    largest: dict[str, float]
    rms: dict[str, float]
    breakdown: list[Diagnostic]
    end: float


def checked_values(scenario: Scenario, *, mean_squares: bool = True) -> CheckedValues:
    """Solve a scenario for the values of limits; root mean squares, which take most of the time, can be left out."""
    expanded = Expanded(scenario, mechanics=False)
    record = expanded.at(expanded.times, closely=True, wanted=OF_ELECTRICS)
    assert record.peaks is not None
    peaks, end = record.peaks, float(expanded.times[-1])
    reached = largest_values(scenario, expanded.section, peaks)
    reached["slew_rate"] = slew_rate(scenario, end)
    largest = {name: largest_of(reached, name) for name in WORDS}
    known = [name for name in MEAN_SQUARED if mean_squares and math.isfinite(largest[name])]
    rms = dict.fromkeys(MEAN_SQUARED, math.nan) | root_mean_squares(expanded, peaks, known)
    found = stack_diagnostics(scenario, peaks)
    return CheckedValues(
        largest=largest | {name: rms[name.removeprefix("rms_")] for name in MEAN_SQUARES},
        rms=rms,
        breakdown=[each for each in found if each.name.startswith(BREAKDOWN)],
        end=end,
    )
