"""The result of a scenario's fit, its table with intervals and systematic errors, and its estimates as a space of parameters."""

from __future__ import annotations

import dataclasses
import math
from collections import Counter
from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Final

import numpy as np

from electrovib.core.diagnostics import STATES, Diagnostic
from electrovib.core.paths import quantity_at
from electrovib.core.signals import SIGNALS
from electrovib.recordings.fit.identifiability import UndeterminedCombination, response
from electrovib.recordings.fit.least_squares import LeastSquaresEstimate, aicc, bic
from electrovib.recordings.fit.misfit import BetweenSessions, Misfit, spread_of
from electrovib.recordings.fit.prediction import Residuals, Unknown
from electrovib.recordings.fit.problem import WeightedProblem
from electrovib.recordings.fit.rounding import Rounding
from electrovib.recordings.interval import (
    MISFIT,
    NORMAL,
    UNCLEAR,
    EstimatedParameter,
    Interval,
    profile_interval,
)
from electrovib.scenario import Scenario
from electrovib.solve.quantities.answer import validity

if TYPE_CHECKING:
    from collections.abc import Collection, Iterable, Sequence

    from electrovib.core.arrays import Real
    from electrovib.recordings.recording import CalibrationError


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
        """Unknown to its state: as `determined`, or ``"misfit"`` for all where the model does not describe the recordings.

        What is determined is ``"unclear"`` where that cannot be told from correlated noise.
        """
        state = self.misfit.state
        return {
            name: state if state == MISFIT or (state == UNCLEAR and each in {"well", "weakly"}) else each
            for name, each in self.determined.items()
        }

    @property
    def diagnostics(self) -> tuple[Diagnostic, ...]:
        """Of each diagnostic of the scenario with the estimated parameters, the worst in the settings of the recordings."""
        worst: dict[tuple[str, int], Diagnostic] = {}
        stated = []
        for each in self.problem.prediction.measured:
            if each.changes in stated:
                continue
            stated.append(each.changes)
            seen = Counter[str]()
            for one in validity(self.scenario.replace(each.changes)):
                seen[one.name] += 1
                place = one.name, seen[one.name]
                worst[place] = max(
                    worst.get(place, one), one, key=lambda d: (STATES.index(d.state), d.value or 0.0)
                )
        return tuple(worst.values())

    @property
    def _counted(self) -> int:
        """Number of estimated numbers, the noises of signals among them."""
        return len(self.estimate.values) + sum(each.observed.noise is None for each in self.residuals)

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
        return aicc(self.deviance, counted=self._counted, data=self.estimate.count)

    @property
    def bic(self) -> float:
        """Criterion of Schwarz."""
        return bic(self.deviance, counted=self._counted, data=self.estimate.count)

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
        from scipy.special import chdtri, fdtri

        estimate, free, own = self.estimate, self.problem.prediction.free, self.problem.prediction.free[name]
        known, value = estimate.noise_is_known, estimate.values[name]
        allowed = chdtri(1, 1 - level) if known else fdtri(1, max(estimate.degrees_of_freedom, 1), level)
        unit = self.misfit.inflation * estimate.variance_of_noise

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


def parameter_table(found: ScenarioFit) -> tuple[EstimatedParameter, ...]:
    """Summarise a fit, one row for each unknown, then one for the mean of each parameter that varies between sessions."""
    systematic = systematic_deviations(found)
    rows = [_row(found, each, systematic.get(each.name, math.nan)) for each in found.unknowns]
    for path, spread in found.sessions.items():
        mean = spread.estimated(
            path, quantity_at(found.scenario, path), found.misfit.remark, found.misfit.state
        )
        name = f"{path} (mean of {len(spread.values)} sessions)"
        rows.append(dataclasses.replace(mean, name=name, systematic=systematic.get(path, math.nan)))
    return tuple(rows)


def _row(found: ScenarioFit, unknown: Unknown, systematic: float) -> EstimatedParameter:
    name, state, note = unknown.name, found.determined[unknown.name], found.why_no_interval(unknown.name)
    ends, method, deviation = found.interval(name), "" if note else "symmetric", found.deviation(name)
    if state != "well":
        profiled = found.profile(name)
        ends, method = profiled.ends, "profile"
        if profiled.open_below and profiled.open_above:
            ends, method = (math.nan, math.nan), ""
        elif name in found.traded or any(
            name in each.exponents and len(each.exponents) > 1 for each in found.undetermined
        ):
            note = f"{note}; the interval is what the declared ranges of the other parameters allow"
        elif profiled.open_below or profiled.open_above:
            side = "below" if profiled.open_below else "above"
            note = "; ".join(filter(None, [note, f"the data set no limit {side}"]))
    if found.rounding is not None and method:
        note = "; ".join(filter(None, [note, found.rounding.note(name)]))
    quantity = SIGNALS[unknown.path] if unknown.is_offset else quantity_at(found.scenario, unknown.path)
    return EstimatedParameter(
        name=name,
        unit=quantity.unit,
        value=found.estimate.values[name],
        standard_error=deviation if math.isfinite(deviation) and state != "bound" else math.nan,
        lower=ends[0],
        upper=ends[1],
        method=method,
        state=found.states[name],
        note="; ".join(filter(None, [found.misfit.remark, note])),
        systematic=systematic,
        low=found.problem.prediction.free[name].lower,
    )


def systematic_deviations(found: ScenarioFit) -> dict[str, float]:
    """Compute the standard deviation of each estimate by the calibration errors of the signals; empty where none is stated.

    By the derivative of the estimate after gain and zero of each signal, dp = (J'J)^-1 J' W dy with dy = gain
    y + zero, J the weighted derivatives and W the weights. Recordings of a signal with the same stated error
    were made with the same sensor: their error is common to all. The zero of a signal whose offset is fitted
    has no effect. The error does not average out over samples, recordings or sessions. NaN of an unknown that
    is not determined or lies on a bound.
    """
    sources = _sources(found)
    if not sources:
        return {}
    values, problem = found.estimate.values, found.problem
    inside = [name for name in values if name not in found.estimate.on_bound]
    rows = [list(values).index(name) for name in inside]
    inverse = response(problem.derivatives(values)[:, rows]) * problem.weights
    shifts = [(error, inverse @ np.transpose(changes)) for (_, error), changes in sources.items()]
    deviations = {
        name: _combined(shifts, [at]) if found.determined[name] != "not" else math.nan
        for at, name in enumerate(inside)
    }
    for path in found.sessions:
        own = [each.name for each in found.unknowns if each.path == path and each.name in inside]
        deviations[path] = _combined(shifts, [inside.index(name) for name in own])
    return dict.fromkeys(values, math.nan) | deviations


def _combined(shifts: list[tuple[CalibrationError, Real]], rows: list[int]) -> float:
    """Root of the variance of the mean of estimates by independent sources, each with the changes by errors of 1."""
    variance = 0.0
    for error, shift in shifts:
        gain, zero = shift[rows].mean(axis=0).tolist()
        variance += (error.gain * gain) ** 2 + (error.zero * zero) ** 2 + 2 * error.covariance * gain * zero
    return math.sqrt(max(variance, 0.0))


_Source = tuple[str, "CalibrationError"]


def _sources(found: ScenarioFit) -> dict[_Source, tuple[Real, Real]]:
    """Changes of all data by a gain error and by a zero error of 1, for each sensor."""
    prediction = found.problem.prediction
    size = prediction.data.size
    sources: dict[_Source, tuple[Real, Real]] = {}
    for record, _, column, rows in prediction.pieces():
        error = prediction.measured[record].calibration_of(column.signal)
        if error is not None:
            gain, zero = sources.setdefault((column.signal, error), (np.zeros(size), np.zeros(size)))
            gain[rows] = prediction.data[rows]
            zero[rows.start : rows.start + column.x.size] = 1.0
    return sources


def space_tables(
    rows: Iterable[EstimatedParameter],
    paths: Mapping[str, str],
    *,
    between: Mapping[str, float] | None = None,
) -> dict[str, dict[str, object]]:
    """Write estimates as tables of distributions, as `electrovib.scenario.space.read_space` reads them.

    `paths` maps the name of a row to the path of its parameter, other rows are omitted; `between` is the
    standard deviation of a parameter between sessions, added to that of its mean. A symmetric interval gives
    a normal distribution; one from a profile with two ends above 0 a log-normal one, with the median at the
    estimate and the same 95 % interval. Parameters that the data do not determine, or of a model that does
    not describe them, are omitted.
    """
    found: dict[str, dict[str, object]] = {}
    for row in rows:
        if row.name not in paths or not row.method or row.state in {"not", MISFIT}:
            continue
        if row.method == "profile":
            if 0 < row.lower < row.value < row.upper < math.inf:
                factor = math.exp((math.log(row.upper) - math.log(row.lower)) / (2 * NORMAL))
                found[paths[row.name]] = {"model": "LogNormal", "median": row.value, "factor": factor}
            continue
        deviation = math.hypot(row.standard_error, (between or {}).get(paths[row.name], 0.0))
        table: dict[str, object] = {"model": "Normal", "mean": row.value, "deviation": deviation}
        if row.value > 0:
            table["low"] = 0.0
        found[paths[row.name]] = table
    return found


def omitted_from_space(
    rows: Iterable[EstimatedParameter], paths: Mapping[str, str], tables: Collection[str]
) -> dict[str, str]:
    """State why parameters of a fit have no distribution in its space."""
    return {
        paths[row.name]: row.note or f"its interval ({row.method or 'none'}) has no two ends above 0"
        for row in rows
        if row.name in paths and paths[row.name] not in tables
    }


def space_correlations(found: ScenarioFit, tables: Collection[str]) -> dict[tuple[str, str], float]:
    """Return the correlation coefficients of the estimates in a space, pair by pair in the order of the unknowns.

    To first order they hold for the logarithms too. A parameter that varies between sessions, is not
    determined or lies on a bound has none.
    """
    names = list(found.estimate.values)
    matrix = found.estimate.correlation.tolist()
    shared = [
        (names.index(each.name), each.path)
        for each in found.unknowns
        if not each.is_offset and not each.session and each.path in tables
    ]
    pairs = {
        (first, second): min(max(matrix[at][other], -1.0), 1.0)
        for number, (at, first) in enumerate(shared)
        for other, second in shared[number + 1 :]
    }
    return {pair: value for pair, value in pairs.items() if math.isfinite(value)}


FAILED: Final = "failed"
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
            each.record: (row.value, row.standard_error)
            for each in fits
            for row in each.rows
            if row.name == path
            and each.found is not None
            and each.found.determined[path] in {"well", "weakly"}
            and math.isfinite(row.standard_error)
        }
        if len(own) > 1:
            found[path] = spread_of(own, group="recording")
    return found
