"""Forms of relaxation, seen by a sensor with a resonance or not, fitted to one edge and compared by a criterion."""

from __future__ import annotations

import functools
import itertools
import math
import re
from dataclasses import dataclass
from typing import TYPE_CHECKING, Final

import numpy as np

from electrovib.core.errors import InputError, refuse
from electrovib.core.units import parse_quantity
from electrovib.physics.relaxation import (
    release_seen_by_sensor,
    stretched_exponential,
    stretched_seen_by_sensor,
    time_of_progress,
)
from electrovib.recordings.fit.least_squares import FreeParameter
from electrovib.recordings.interval import Interval, autocovariance, profile_interval, student
from electrovib.recordings.transitions.modes import (
    Separable,
    Whitening,
    central_differences,
    resonance_parameters,
)

if TYPE_CHECKING:
    from collections.abc import Mapping, Sequence

    from electrovib.core.arrays import Real
    from electrovib.recordings.fit.least_squares import LeastSquaresEstimate
    from electrovib.recordings.transitions.edges import EdgeRecord


INSTANT: Final = 1e-6
"""Fall time over the period of the sensor that stands for an instantaneous change; its effect is of this order."""
_TEXT: Final = re.compile(r"\s*(.+?)\s*[:,]\s*(?:Q\s*=?\s*)?([0-9.eE+-]+)\s*")


@dataclass(frozen=True, kw_only=True)
class Sensor:
    """A force sensor with one resonance, with all that it carries.

    Parameters
    ----------
    frequency : float
        Natural frequency [Hz], above 0.
    quality : float
        Quality factor, dimensionless, above 1/2.
    frequency_error, quality_error : float
        Standard uncertainties [Hz] and dimensionless; 0 for values taken as exact.

    Raises
    ------
    InputError
        If a number is outside these limits.
    """

    frequency: float
    quality: float
    frequency_error: float = 0.0
    quality_error: float = 0.0

    def __post_init__(self) -> None:
        problems = []
        if not 0 < self.frequency < math.inf:
            problems.append(f"sensor.frequency = {self.frequency:g}: expected a positive frequency in Hz")
        if not 0.5 < self.quality < math.inf:
            problems.append(
                f"sensor.quality = {self.quality:g}: expected a quality factor above 0.5; a sensor without a resonance is"
                " not taken out"
            )
        problems += [
            f"sensor.{name} = {getattr(self, name):g}: expected a standard uncertainty of at least 0"
            for name in ("frequency_error", "quality_error")
            if not 0 <= getattr(self, name) < math.inf
        ]
        refuse(problems)

    def shortest_time(self, levels: tuple[float, float] = (0.1, 0.9)) -> float:
        """Compute the time between two levels of the reading after an instantaneous change of the force.

        Parameters
        ----------
        levels : tuple of float
            Fractions of the change, between 0 and 1, increasing.

        Returns
        -------
        time : float
            First passage through the upper level less first passage through the lower level [s].

        Notes
        -----
        The reading after a step is 1 - e^(-w t/(2 Q)) [cos(w_d t) + sin(w_d t) w/(2 Q w_d)], w_d = w sqrt(1 - 1/(4 Q^2)); it
        rises monotonically to its first maximum at pi/w_d, which lies above every level below 1.
        """
        from scipy.optimize import brentq

        first_maximum = 0.5 / (self.frequency * math.sqrt(1 - 1 / (4 * self.quality**2)))

        def progress(time: float) -> float:
            return 1.0 - float(self.release(np.array([time]), fall_time=0.0)[0])

        def passage(level: float) -> float:
            return float(
                brentq(lambda time: progress(time) - level, 0.0, first_maximum, xtol=1e-12 * first_maximum)
            )

        return passage(levels[1]) - passage(levels[0])

    def release(self, time: np.ndarray, *, fall_time: float, start: float = 0.0) -> np.ndarray:
        """Compute the reading of a force of 1 that decays exponentially from `start` on.

        Parameters
        ----------
        time : ndarray, shape (n,)
            Times [s].
        fall_time : float
            Time constant of the decay [s]; 0 for an instantaneous release.
        start : float
            Time at which the force begins to decay [s].

        Returns
        -------
        reading : ndarray, shape (n,)
            Over the constant force, dimensionless.
        """
        return release_seen_by_sensor(
            time,
            start=start,
            fall_time=max(fall_time, INSTANT / self.frequency),
            frequency=self.frequency,
            quality=self.quality,
        )


def read_sensor(text: str) -> Sensor:
    """Read a sensor written as ``FREQUENCY:QUALITY``, such as ``380 Hz:3``."""
    match = _TEXT.fullmatch(text)
    if match is None:
        raise InputError(f"sensor = {text}: expected FREQUENCY:QUALITY, such as '380 Hz:3', or 'estimate'")
    try:
        number = match[1]
        frequency = float(number) if re.fullmatch(r"[0-9.eE+-]+", number) else parse_quantity(number, "Hz")
        quality = float(match[2])
    except ValueError as error:
        raise InputError(f"sensor = {text}: {error}") from None
    return Sensor(frequency=frequency, quality=quality)


_APART: Final = 1.2
"""Smallest ratio of two time constants that are counted as two."""


@dataclass(frozen=True, kw_only=True)
class FittedForm:
    """One form of relaxation fitted to one edge.

    - `estimate`: ``start`` [s], time constants [s], ``stretching``, sensor if it was estimated, and
      amplitudes.
    - `sensor`: through which it was seen.
    - `aicc`: on residuals whose correlation was filtered out; infinite if the form was rejected.
    - `between`: time between the levels of the force, the sensor taken out.
    - `misfit`: rms of the residual after the start over the standard deviation of the noise before the edge.
    """

    form: RelaxationForm
    estimate: LeastSquaresEstimate
    sensor: Sensor | None
    aicc: float
    rejected: str
    between: Interval
    reading: Real
    misfit: float


def fit_forms(
    edge: EdgeRecord,
    *,
    forms: Sequence[RelaxationForm],
    sensor: Sensor | None = None,
    estimated: bool = False,
) -> dict[str, FittedForm]:
    """Fit forms of relaxation to one edge, with the correlation of the residuals.

    The estimates are those of ordinary least squares, which do not depend on a model of the noise; their
    covariance contains the correlation of the residuals. The criterion is that of the same forms fitted to
    samples that are filtered with a second-order autoregression of the noise before the edge, so that
    correlated samples count for what they are worth. Sums of more exponentials than one that is rejected are
    not fitted.
    """
    problem = EdgeProblem(edge=edge, sensor=sensor, estimated=estimated)
    before = edge.fit_time < min(0.0, edge.passages.first - edge.passages.time)
    white = Whitening.of(edge.fit_values[before])
    found: dict[str, LeastSquaresEstimate] = {}
    fewer = forms[0]
    for form in forms:
        if form.exponentials > 2 and _rejected(fewer, found[fewer.name]):
            continue  # more terms than are found already in a sum of fewer
        found[form.name] = problem.separable(form).solve(starts(problem, form, found), whitening=Whitening())
        fewer = form
    return {
        form.name: _fitted(problem, form, found[form.name], white) for form in forms if form.name in found
    }


def _fitted(
    problem: EdgeProblem, form: RelaxationForm, estimate: LeastSquaresEstimate, white: Whitening
) -> FittedForm:
    values = estimate.values
    reading = problem.separable(form).predicted(values)
    left = problem.edge.fit_values - reading
    since = (problem.edge.fit_time > values["start"]) & (
        problem.edge.fit_time < problem.edge.passages.last + 5 * problem.rough
    )
    rms = float(np.sqrt(np.mean(left[since] ** 2))) if since.any() else math.nan
    rejected = _rejected(form, estimate)
    between = _between(problem, form, estimate) if not rejected else Interval(value=math.nan, method=rejected)
    filtered = problem.separable(form).minimum([values], whitening=white)
    return FittedForm(
        form=form,
        estimate=estimate,
        sensor=problem.seen_by(values),
        aicc=math.inf if rejected else filtered.aicc,
        rejected=rejected,
        between=between,
        reading=reading,
        misfit=rms / problem.edge.fit_noise if problem.edge.fit_noise else math.inf,
    )


def _rejected(form: RelaxationForm, estimate: LeastSquaresEstimate) -> str:
    """State why a fit of several terms, or a stretched one, is no relaxation of its form."""
    if form.stretched and "stretching" in estimate.on_bound:
        return f"its stretching lies on its {estimate.on_bound['stretching']} bound"
    if form.exponentials < 2:
        return ""
    changes = [estimate.values[name] for name in form.amplitudes[:-1]]
    if min(changes) < 0 < max(changes):
        return "its terms have opposite signs"
    if any(name in estimate.on_bound for name in form.time_constants):
        return "one of its time constants lies on a bound"
    falls = sorted(estimate.values[name] for name in form.time_constants)
    if any(longer < _APART * shorter for shorter, longer in itertools.pairwise(falls)):
        return "two of its time constants coincide"
    return ""


def _between(problem: EdgeProblem, form: RelaxationForm, estimate: LeastSquaresEstimate) -> Interval:
    """Compute the time between the levels with its interval: to first order, or from a profile where it may be 0."""
    value = form.time_between(estimate.values, problem.edge.fractions)
    if form.endless:
        return Interval(value=math.nan, method="it never settles")
    if form is INSTANTANEOUS:
        return Interval(value=0.0, method="an instantaneous change has no time to be estimated")
    if estimate.covariance is None:
        return Interval(value=value, method=estimate.why_no_covariance)
    names = (*form.time_constants, *form.amplitudes[:-1], *(["stretching"] if form.stretched else []))
    steps = {name: 1e-5 * (abs(estimate.values[name]) or 1.0) for name in names}
    between = functools.partial(form.time_between, fractions=problem.edge.fractions)
    found = estimate.derived(value, central_differences(between, estimate.values, steps))
    if form is EXPONENTIAL and (found.standard_error > 0.2 * value or "time_constant" in estimate.on_bound):
        return _profile_of_time(problem, estimate, found.standard_error)
    return found


@dataclass(frozen=True)
class RelaxationForm:
    """One form of a relaxation after a delay: its number of time constants, 0 for an instantaneous change."""

    name: str
    exponentials: int
    stretched: bool = False
    endless: bool = False

    @property
    def time_constants(self) -> tuple[str, ...]:
        """Names of the time constants."""
        if self.exponentials == 1:
            return ("time_constant",)
        return tuple(f"time_constant_{number}" for number in range(1, self.exponentials + 1))

    @property
    def amplitudes(self) -> tuple[str, ...]:
        """Names of the amplitudes of the columns: those of the relaxations, and the level after them."""
        count = max(self.exponentials, 1)
        changes = ("change",) if count == 1 else tuple(f"change_{number}" for number in range(1, count + 1))
        return (*changes, "after")

    def columns(self, time: Real, values: Mapping[str, float], sensor: Sensor | None) -> Real:
        """Compute what the amplitudes multiply, shape (n, k): relaxations from 1 to 0, and a column of ones."""
        since = time - values["start"]
        if self.endless:
            found = [-np.log1p(np.maximum(since, 0.0) / values["time_constant"])]
        elif self.stretched:
            shape = {name: values[name] for name in ("time_constant", "stretching")}
            if sensor is None:
                found = [stretched_exponential(since, **shape)]
            else:
                seen = {"frequency": sensor.frequency, "quality": sensor.quality}
                found = [stretched_seen_by_sensor(since, **seen, **shape)]
        else:
            falls = [values[name] for name in self.time_constants] or [0.0]
            found = [
                _exponential(since, fall) if sensor is None else sensor.release(since, fall_time=fall)
                for fall in falls
            ]
        return np.column_stack([*found, np.ones_like(time)])

    def time_between(self, values: Mapping[str, float], fractions: tuple[float, float]) -> float:
        """Compute the time between two fractions of the change of the force."""
        if not self.exponentials or self.endless:
            return math.inf if self.endless else 0.0
        if self.exponentials == 1:
            shape = {"time_constant": values["time_constant"], "stretching": values.get("stretching", 1.0)}
            return time_of_progress(fractions[1], **shape) - time_of_progress(fractions[0], **shape)
        falls = np.array([values[name] for name in self.time_constants])
        shares = np.array([values[name] for name in self.amplitudes[:-1]])
        shares = shares / shares.sum()
        return _passage(fractions[1], shares, falls) - _passage(fractions[0], shares, falls)


INSTANTANEOUS: Final = RelaxationForm("instantaneous", 0)
EXPONENTIAL: Final = RelaxationForm("exponential", 1)
STRETCHED: Final = RelaxationForm("stretched exponential", 1, stretched=True)
LOGARITHMIC: Final = RelaxationForm("logarithm of time", 1, endless=True)
"""Never settles; a record that does not exclude it has no time between levels."""


def forms(most: int, *, sensor: bool) -> tuple[RelaxationForm, ...]:
    """List the forms that are compared, by their number of parameters; an instantaneous change has one through a sensor alone."""
    sums = tuple(RelaxationForm(f"{count} exponentials", count) for count in range(2, most + 1))
    return (INSTANTANEOUS if sensor else LOGARITHMIC, EXPONENTIAL, STRETCHED, *sums)


def _exponential(since: Real, fall: float) -> Real:
    return np.exp(-np.maximum(since, 0.0) / fall) if fall else np.asarray(since < 0, dtype=float)


def _passage(progress: float, shares: Real, falls: Real) -> float:
    """Return the time at which a sum of exponentials has made a fraction of its change; NaN if it has not one such time."""
    from scipy.optimize import brentq

    if (shares < 0).any():
        return math.nan
    longest = float(falls.max()) * -math.log1p(-progress)
    if longest == 0:
        return 0.0
    return float(brentq(lambda at: shares @ np.exp(-at / falls) - (1 - progress), 0.0, longest * (1 + 1e-12)))


_STRETCHINGS: Final = (0.3, 1.5)
"""Bounds of the exponent of a stretched exponential, where its reading through a sensor is accurate."""
_BEST_STARTS: Final = 2
_COARSE: Final = 400
"""Samples on which the starts of a search are compared."""


@dataclass(frozen=True, kw_only=True)
class EdgeProblem:
    """What the fits of all forms to one edge share."""

    edge: EdgeRecord
    sensor: Sensor | None
    estimated: bool

    @property
    def rough(self) -> float:
        """Time between the levels as recorded [s]."""
        return self.edge.passages.time

    @property
    def step(self) -> float:
        """Time between samples [s]."""
        return float(np.median(np.diff(self.edge.fit_time)))

    @property
    def window(self) -> float:
        """Time after the reference up to which there are samples [s]."""
        return float(self.edge.fit_time[-1])

    def free(self, form: RelaxationForm) -> dict[str, FreeParameter]:
        """Return the nonlinear parameters with their bounds."""
        passages = self.edge.passages
        low = max(float(self.edge.fit_time[2]), passages.first - 3 * self.rough - 2 * self.step)
        found = {"start": FreeParameter(start=passages.first, lower=low, upper=passages.last)}
        least = self.step / (1e6 if form.endless else 10)
        fall = FreeParameter(start=self.rough, lower=least, upper=2 * self.window, logarithmic=True)
        found |= {name: fall.starting_at(self.rough) for name in form.time_constants}
        if form.stretched:
            low, high = _STRETCHINGS
            found["stretching"] = FreeParameter(start=1.0, lower=low, upper=high, logarithmic=True)
        if self.estimated:
            found |= resonance_parameters(self.window, self.step)
        return found

    def separable(self, form: RelaxationForm, *, coarse: bool = False) -> Separable:
        """Return the problem of one form, on few samples to compare starts."""
        every = max(1, len(self.edge.fit_time) // _COARSE) if coarse else 1
        time, values = self.edge.fit_time[::every], self.edge.fit_values[::every]
        return Separable(
            columns=lambda at: form.columns(time, at, self.seen_by(at)),
            data=values,
            free=self.free(form),
            names=form.amplitudes,
            ranges={"start": self.rough},
        )

    def seen_by(self, values: Mapping[str, float]) -> Sensor | None:
        """Return the sensor at some parameters."""
        if self.estimated:
            return Sensor(frequency=values["frequency"], quality=values["quality"])
        return self.sensor


def starts(
    problem: EdgeProblem, form: RelaxationForm, found: Mapping[str, LeastSquaresEstimate]
) -> list[Mapping[str, float]]:
    """Compare many starts of a search on few samples, and return the best of them."""
    passages, rough = problem.edge.passages, problem.rough
    coarse = problem.separable(form, coarse=True)
    known = found.get(EXPONENTIAL.name)
    sensors: list[dict[str, float]] = [{}]
    if problem.estimated and known is not None:
        sensors = [{name: known.values[name] for name in ("frequency", "quality")}]
    elif problem.estimated:
        band = coarse.free["frequency"]
        sensors = [
            {"frequency": float(frequency), "quality": quality}
            for frequency in np.geomspace(
                max(1.2 * band.lower, 0.02 / rough), min(band.upper / 1.2, 0.5 / rough), 14
            )
            for quality in (1.0, 3.0, 10.0)
        ]
    shift = 0.0 if problem.seen_by(sensors[0]) is None else 0.7 * rough
    begins = [passages.first - shift - part * rough for part in (0.0, 0.1, 0.4)]
    if known is not None:
        begins.append(known.values["start"])
    centre = known.values["time_constant"] if known is not None else rough / 2.2
    if form.exponentials > 1:
        ratios = list(itertools.combinations((0.05, 0.15, 0.4, 1.0, 2.0, 5.0, 12.0), form.exponentials))
        begins = begins[-2:]
    else:
        first = (1e-7, 1e-5, 1e-3, 1e-2, 0.1, 1.0) if form.endless else (0.03, 0.2, 0.6, 1.0)
        ratios = [(ratio,) for ratio in first] if form.exponentials else [()]
    grid = [
        {
            "start": begin,
            **sensor,
            **extra,
            **dict(zip(form.time_constants, (centre * each for each in ratio), strict=True)),
        }
        for begin in begins
        for sensor in sensors
        for ratio in ratios
        for extra in ([{"stretching": 0.6}, {"stretching": 1.0}] if form.stretched else [{}])
    ]
    return coarse.best_starts(grid, _BEST_STARTS)


def _profile_of_time(problem: EdgeProblem, estimate: LeastSquaresEstimate, error: float) -> Interval:
    """Find the times between levels with which an exponential fits as well; from 0 where an instantaneous change does."""
    separable, values = problem.separable(EXPONENTIAL), estimate.values
    factor = EXPONENTIAL.time_between({"time_constant": 1.0}, problem.edge.fractions)
    best, free = values["time_constant"], separable.free["time_constant"]
    left = separable.predicted(values) - separable.data
    alike = autocovariance(left, fitted=len(values) - len(estimate.on_bound))
    unit = estimate.variance * separable.inflation(values, "start", alike, estimate.on_bound)

    def rise(fall: float) -> float:
        # a longer fall starts earlier by about as much
        start = {**values, "start": values["start"] + best - fall}
        found = separable.holding(time_constant=fall).minimum([start, values], whitening=Whitening())
        return (found.sum_of_squares - estimate.sum_of_squares) / unit

    found = profile_interval(
        rise,
        best,
        deviation=error / factor,
        bounds=(free.lower, free.upper),
        allowed=student(estimate.degrees_of_freedom) ** 2,
        logarithmic=True,
    )
    if found.open_above:
        return Interval(value=best * factor, method="any time constant fits as well")
    return Interval(
        value=best * factor, lower=0.0 if found.open_below else found.lower * factor, upper=found.upper * factor,
        standard_error=error, method="profile of the time constant in one edge",
    )  # fmt: skip
