"""The result of a scenario's fit: estimates, intervals, criteria, and what the data do not determine."""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import TYPE_CHECKING

import numpy as np

from electrovib.recordings.fit.identifiability import UndeterminedCombination
from electrovib.recordings.fit.least_squares import LeastSquaresEstimate, aicc, bic
from electrovib.recordings.fit.misfit import Misfit
from electrovib.recordings.fit.prediction import Residuals, Unknown
from electrovib.recordings.fit.problem import WeightedProblem
from electrovib.recordings.fit.rounding import Rounding
from electrovib.recordings.fit.sessions import BetweenSessions
from electrovib.recordings.interval import MISFIT, Interval, profile_interval
from electrovib.scenario import Scenario
from electrovib.solve.quantities.answer import validity

if TYPE_CHECKING:
    from collections.abc import Sequence

    from electrovib.core.diagnostics import Diagnostic


@dataclass(frozen=True, kw_only=True)
class ScenarioFit:
    """Parameters of a scenario, estimated from recordings.

    - `estimate`: values and covariance of all unknowns, in the order of `unknowns`; zeros of signals among
      them.
    - `scenario`: with the estimated parameters; of one that varies between `sessions`, with the mean.
    - `determined`: how the data determine each unknown if the model describes them: ``"well"``, ``"weakly"``
      or ``"not"``, or ``"bound"`` where the estimate lies on a bound. With a bias above 0.05 standard
      deviations it counts as weakly determined.
    - `traded`: unknown that is not determined because it trades with another one on its bound, to that one.
    - `bias`: bias by the curvature of the model over the standard deviation; absent where it is not
      determined.
    - `undetermined`: combinations that the data do not determine, the worst first.
    - `rounding`: errors of the estimates by the resolution of the recordings; None where rounding errors are
      independent of each other like noise, and are part of it.
    - `misfit`: what of the residuals noise does not explain.
    - `prescribed`: drive, load or motion that was taken from a recording because it differs from the
      scenario's, with both numbers.
    """

    estimate: LeastSquaresEstimate
    unknowns: tuple[Unknown, ...]
    scenario: Scenario
    sessions: Mapping[str, BetweenSessions]
    residuals: tuple[Residuals, ...]
    determined: Mapping[str, str]
    traded: Mapping[str, str]
    bias: Mapping[str, float]
    undetermined: tuple[UndeterminedCombination, ...]
    problem: WeightedProblem = field(repr=False)
    rounding: Rounding | None = None
    misfit: Misfit
    prescribed: tuple[str, ...] = ()

    @property
    def states(self) -> dict[str, str]:
        """Unknown to its state: as `determined`, or ``"misfit"`` for all where the model does not describe the recordings."""
        return dict.fromkeys(self.determined, MISFIT) if self.misfit.reasons else dict(self.determined)

    @property
    def diagnostics(self) -> tuple[Diagnostic, ...]:
        """Diagnostics of the scenario with the estimated parameters."""
        return validity(self.scenario)

    @property
    def noises_estimated(self) -> int:
        """Number of signals whose noise was estimated from their residuals."""
        return sum(each.observed.noise is None for each in self.residuals)

    @property
    def deviance(self) -> float:
        """Minus twice the logarithm of the largest likelihood, up to a constant that depends on the data alone."""
        total = 0.0
        for each in self.residuals:
            count, mean_square = each.observed.x.size * each.observed.parts, each.root_mean_square**2
            if each.observed.noise is not None:
                total += count * mean_square / each.observed.noise**2
            else:
                total += count * math.log(max(mean_square, math.ulp(0.0)))
        return total

    @property
    def aicc(self) -> float:
        """Akaike's criterion with the correction for few data; infinite with as many parameters as data."""
        counted = len(self.estimate.values) + self.noises_estimated
        return aicc(self.deviance, counted=counted, data=self.estimate.count)

    @property
    def bic(self) -> float:
        """Criterion of Schwarz."""
        counted = len(self.estimate.values) + self.noises_estimated
        return bic(self.deviance, counted=counted, data=self.estimate.count)

    def why_no_interval(self, name: str) -> str:
        """Return why an unknown has no interval from its standard deviation; empty where it has one."""
        if self.determined[name] == "bound":
            bound = self.estimate.on_bound[name]
            return f"the estimate lies on the {bound} bound of the parameter"
        for each in self.undetermined:
            if name in each.exponents:
                return each.sentence
        if name in self.traded:
            other = self.traded[name]
            return f"it trades with {other}, which lies on its {self.estimate.on_bound[other]} bound"
        if self.determined[name] == "not":
            lost = dict.fromkeys(other for each in self.undetermined for other in each.exponents)
            return (
                f"a change of it is hidden by changes of {', '.join(lost)}, which the data do not determine"
            )
        return ""

    def _half_width(self, name: str, level: float) -> float:
        """Half the width of the interval of one unknown by noise and rounding."""
        quantile = self.estimate.quantile(level)
        if self.rounding is None or name not in self.rounding.errors:
            return quantile * self.estimate.standard_deviations[name]
        half = self.rounding.half_width(name, level=level, quantile=quantile)
        return half * math.sqrt(self.misfit.inflation)

    def interval(self, name: str, *, level: float = 0.95) -> tuple[float, float]:
        """Interval in SI of one unknown by its standard deviation and by rounding; NaN where the data do not determine it."""
        if self.why_no_interval(name):
            return math.nan, math.nan
        value, free = self.estimate.values[name], self.problem.prediction.free[name]
        half = self._half_width(name, level)
        return max(value - half, free.lower), min(value + half, free.upper)

    def deviation(self, name: str) -> float:
        """Return the standard deviation of one unknown by noise and rounding, in SI; NaN where there is none."""
        if self.rounding is not None and name in self.rounding.errors:
            return self.rounding.deviation(name) * math.sqrt(self.misfit.inflation)
        return self.estimate.standard_deviations[name]

    def profile(self, name: str, *, level: float = 0.95) -> Interval:
        """Interval in SI of one unknown from the profile of the likelihood, which costs about ten fits of the other unknowns.

        The ends are where the sum of squares, minimised over all other unknowns, has risen by the quantile of
        F(1, n - p) times its variance, or by that of chi-squared with one degree of freedom where the noise
        is stated. It holds where the symmetric interval does not. Rounding of the recordings moves both ends
        outwards by what it adds to the variance.
        """
        from scipy.stats import chi2
        from scipy.stats import f as fisher

        estimate, free, own = self.estimate, self.problem.prediction.free, self.problem.prediction.free[name]
        known, value = estimate.noise_is_known, estimate.values[name]
        allowed = chi2.ppf(level, 1) if known else fisher.ppf(level, 1, max(estimate.degrees_of_freedom, 1))
        unit = self.misfit.inflation * (1.0 if known else estimate.variance)

        def rise(at: float) -> float:
            squares = self.problem.rise(name, at, estimate.values, free, variance=unit)
            return (squares - estimate.sum_of_squares) / unit

        deviation = estimate.standard_deviations[name]
        bounds, logarithmic = (own.lower, own.upper), own.logarithmic
        profiled = profile_interval(
            rise, value, deviation=deviation, bounds=bounds, allowed=float(allowed), logarithmic=logarithmic
        )
        if self.rounding is None or name not in self.rounding.errors:
            return profiled
        half = self._half_width(name, level)
        further = math.sqrt(max(half**2 - (estimate.quantile(level) * deviation) ** 2, 0.0))
        return dataclasses.replace(
            profiled,
            lower=max(value - math.hypot(value - profiled.lower, further), own.lower),
            upper=min(value + math.hypot(profiled.upper - value, further), own.upper),
        )

    @property
    def correlation(self) -> Sequence[Sequence[float]]:
        """Correlation of the unknowns; NaN with one that is not determined or lies on a bound."""
        with np.errstate(all="ignore"):
            found = np.array(self.estimate.correlation)
        found[~np.isfinite(found)] = np.nan
        rows: list[list[float]] = found.tolist()
        return rows
