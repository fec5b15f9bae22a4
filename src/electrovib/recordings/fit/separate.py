"""Several fits: recordings that are fitted one by one, and models compared by information criteria."""

from __future__ import annotations

import math
import statistics
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Final

from electrovib.core.diagnostics import Diagnostic
from electrovib.core.errors import InputError
from electrovib.core.paths import quantity_at
from electrovib.recordings.fit.result import ScenarioFit
from electrovib.recordings.fit.sessions import BetweenSessions, spread_of
from electrovib.recordings.interval import EstimatedParameter
from electrovib.scenario import Scenario

FAILED = "failed"
"""Status of the parameters of a recording that could not be fitted."""


@dataclass(frozen=True, kw_only=True)
class RecordedFit:
    """The fit of one recording; None in `found`, and rows with the status ``"failed"``, if there is none."""

    record: str
    found: ScenarioFit | None
    rows: tuple[EstimatedParameter, ...]

    @property
    def reduced_chi_square(self) -> float:
        """Weighted sum of squares over the degrees of freedom, dimensionless; NaN unless the noise of all signals is stated."""
        if self.found is None or not self.found.estimate.noise_is_known:
            return math.nan
        return self.found.estimate.variance

    @property
    def problem(self) -> str:
        """Why there is no fit; empty where there is one."""
        return "" if self.found is not None or not self.rows else self.rows[0].note


@dataclass(frozen=True, kw_only=True)
class SeparateFits:
    """Parameters of a scenario estimated from each of several recordings alone, and their spread between these."""

    scenario: Scenario
    free: tuple[str, ...]
    fits: tuple[RecordedFit, ...]
    spreads: Mapping[str, BetweenSessions]

    @property
    def diagnostics(self) -> tuple[Diagnostic, ...]:
        """Diagnostics of the scenario with the parameters estimated from each recording."""
        return tuple(
            dict.fromkeys(
                told for each in self.fits if each.found is not None for told in each.found.diagnostics
            )
        )

    @property
    def failures(self) -> dict[str, str]:
        """Name of each recording that could not be fitted, and why."""
        return {each.record: each.problem for each in self.fits if each.found is None}

    @property
    def misfits(self) -> dict[str, str]:
        """Name of each recording that the model does not describe, and what its residuals show."""
        found = {each.record: each.found.misfit for each in self.fits if each.found is not None}
        return {record: each.sentence for record, each in found.items() if each.reasons}

    @property
    def means(self) -> tuple[EstimatedParameter, ...]:
        """Mean of each parameter over the recordings that determine it, with its interval by Student's t.

        Its systematic error is the mean of theirs: the sensors are the same, and their error does not average
        out.
        """
        found = []
        for path, spread in self.spreads.items():
            missed = [record for record in self.misfits if record in spread.values]
            counted = f"{len(missed)} of the {len(spread.values)} recordings"
            why = f"the model does not describe {counted}" if missed else ""
            errors = [
                row.systematic
                for each in self.fits
                for row in each.rows
                if row.name == path and each.record in spread.values
            ]
            mean = spread.estimated(path, quantity_at(self.scenario, path), why)
            found.append(replace(mean, systematic=statistics.fmean(errors)))
        return tuple(found)


def failed_rows(paths: Mapping[str, str], why: str) -> tuple[EstimatedParameter, ...]:
    """Make the rows of a recording that could not be fitted."""
    return tuple(
        EstimatedParameter(name=path, unit=unit, value=math.nan, state=FAILED, note=why)
        for path, unit in paths.items()
    )


def spreads_of(free: Sequence[str], fits: Sequence[RecordedFit]) -> dict[str, BetweenSessions]:
    """Summarise how parameters differ between the recordings that determine them, at least two, which count alike."""
    found = {}
    for path in free:
        own = {
            each.record: row
            for each in fits
            for row in each.rows
            if row.name == path
            and each.found is not None
            and each.found.determined[path] in {"well", "weakly"}
            and math.isfinite(row.standard_error)
        }
        if len(own) > 1:
            values = {record: row.value for record, row in own.items()}
            found[path] = spread_of(values, [row.standard_error for row in own.values()], group="recording")
    return found


CLEAR: Final = 10.0
"""Difference of AICc from which on the worse model has essentially no support (Burnham and Anderson 2002)."""
_SOME: Final = 2.0


@dataclass(frozen=True, kw_only=True)
class FitComparison:
    """Fits of several models to the same data, the best first; `aicc` and `bic` are above those of the best by AICc."""

    names: tuple[str, ...]
    aicc: tuple[float, ...]
    bic: tuple[float, ...]
    sentence: str


def compare_fits(fits: Mapping[str, ScenarioFit]) -> FitComparison:
    """Compare models that were fitted to the same data.

    A difference of AICc below 2 does not distinguish two models, one above 10 leaves the worse one without
    support (Burnham and Anderson 2002). The criteria compare models with each other; none of them may be
    adequate.
    """
    sizes = {name: each.estimate.count for name, each in fits.items()}
    if len(set(sizes.values())) > 1:
        told = ", ".join(f"{name} {size}" for name, size in sizes.items())
        raise InputError(
            f"models are compared on the same data, but these were fitted to different numbers: {told}"
        )
    names = sorted(fits, key=lambda name: fits[name].aicc)
    best = fits[names[0]]
    aicc = tuple(fits[name].aicc - best.aicc if math.isfinite(best.aicc) else math.nan for name in names)
    bic = tuple(fits[name].bic - best.bic for name in names)
    return FitComparison(names=tuple(names), aicc=aicc, bic=bic, sentence=_sentence(names, aicc, bic))


def _sentence(names: list[str], aicc: tuple[float, ...], bic: tuple[float, ...]) -> str:
    if len(names) == 1:
        return ""
    first, second, apart = names[0], names[1], aicc[1]
    if not math.isfinite(apart):
        return f"there are too few data to compare {first} with {second} by AICc"
    if apart < _SOME:
        text = f"the data do not distinguish {first} from {second} (AICc differs by {apart:.2g})"
    elif apart < CLEAR:
        text = f"the data favour {first} over {second}, but not clearly (AICc lower by {apart:.2g})"
    else:
        text = f"the data support {first}; {second} has an AICc higher by {apart:.3g}, which leaves it no support"
    if min(bic) < 0:
        text += f"; BIC prefers {names[bic.index(min(bic))]}, which has fewer parameters"
    return text
