"""The table of a fit: one row for each unknown, with its interval or the reason why it has none."""

from __future__ import annotations

import dataclasses
import math
from dataclasses import dataclass
from typing import TYPE_CHECKING, Final

from electrovib.core.paths import quantity_at
from electrovib.core.signals import SIGNALS
from electrovib.core.units import digits_of_interval
from electrovib.recordings.fit.misfit import MISFIT
from electrovib.recordings.fit.systematic import systematic_deviations

if TYPE_CHECKING:
    from electrovib.recordings.fit.prediction import Unknown
    from electrovib.recordings.fit.result import ScenarioFit

LEVEL: Final = 0.95
"""Probability of the intervals of a table."""
NORMAL: Final = 1.959963984540054
"""Standard deviations of a normal distribution that hold 95 % of it on both sides."""


@dataclass(frozen=True, kw_only=True)
class EstimatedParameter:
    """One row of the table of a fit, all numbers in the SI unit `unit`, NaN where there are none, for the reason in `note`.

    - `name`: dotted path, with the session where the parameter varies between sessions.
    - `method`: ``"symmetric"``, ``"profile"`` or ``"sessions"``; empty without an interval.
    - `state`: as in `ScenarioFit.states`.
    - `systematic`: standard deviation by the calibration errors of the signals, in addition to that by noise.
    - `low`: lowest value that the parameter may have, below which no interval reaches.
    """

    name: str
    unit: str
    value: float
    deviation: float
    lower: float
    upper: float
    method: str
    state: str
    note: str
    systematic: float = math.nan
    low: float = -math.inf

    @property
    def systematic_interval(self) -> tuple[float, float]:
        """95 % interval by the calibration errors alone, in SI; NaN where none is stated."""
        half = NORMAL * self.systematic
        return max(self.value - half, self.low), self.value + half

    @property
    def digits(self) -> int:
        """Digits that show the interval."""
        return digits_of_interval(self.value, self.lower, self.upper)


def parameter_table(found: ScenarioFit, *, profiles: bool = True) -> tuple[EstimatedParameter, ...]:
    """Summarise a fit, one row for each unknown, then one for the mean of each parameter that varies between sessions."""
    systematic = systematic_deviations(found)
    rows = [
        dataclasses.replace(
            _row(found, each, profiles=profiles), systematic=systematic.get(each.name, math.nan)
        )
        for each in found.unknowns
    ]
    for path, spread in found.sessions.items():
        lower, upper = spread.interval(level=LEVEL)
        quantity = quantity_at(found.scenario, path)
        rows.append(
            EstimatedParameter(
                name=f"{path} (mean of {len(spread.values)} sessions)",
                unit=quantity.unit,
                value=spread.mean,
                deviation=spread.standard_error,
                lower=max(lower, quantity.low),
                upper=upper,
                method="sessions",
                state=MISFIT if found.misfit.reasons else "well",
                note="; ".join(filter(None, [found.misfit.verdict, spread.in_words(quantity.unit)])),
                systematic=systematic.get(path, math.nan),
                low=quantity.low,
            )
        )
    return tuple(rows)


def _row(found: ScenarioFit, unknown: Unknown, *, profiles: bool) -> EstimatedParameter:
    name, state, note = unknown.name, found.determined[unknown.name], found.why_no_interval(unknown.name)
    lower, upper = found.interval(name, level=LEVEL)
    method, deviation = ("" if note else "symmetric"), found.deviation(name)
    if state != "well" and profiles:
        profiled = found.profile(name, level=LEVEL)
        lower, upper, method = profiled.lower, profiled.upper, "profile"
        ends = [
            word
            for word, is_open in (("below", profiled.open_below), ("above", profiled.open_above))
            if is_open
        ]
        if len(ends) == 2:
            lower, upper, method = math.nan, math.nan, ""
        elif name in found.traded or any(
            name in each.exponents and len(each.exponents) > 1 for each in found.undetermined
        ):
            note = f"{note}; the interval is what the declared ranges of the other parameters allow"
        elif ends:
            note = "; ".join(filter(None, [note, f"the data set no limit {ends[0]}"]))
    if found.rounding is not None and method:
        note = "; ".join(filter(None, [note, found.rounding.note(name)]))
    return EstimatedParameter(
        name=name,
        unit=SIGNALS[unknown.path].unit
        if unknown.is_offset
        else quantity_at(found.scenario, unknown.path).unit,
        value=found.estimate.values[name],
        deviation=deviation if math.isfinite(deviation) and state != "bound" else math.nan,
        lower=lower,
        upper=upper,
        method=method,
        state=found.states[name],
        note="; ".join(filter(None, [found.misfit.verdict, note])),
        low=found.problem.prediction.free[name].lower,
    )
