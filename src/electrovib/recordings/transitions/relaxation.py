"""Fits of several forms of relaxation to one edge, compared by a criterion, with the time between levels of each."""

from __future__ import annotations

import itertools
import math
from dataclasses import dataclass
from typing import TYPE_CHECKING, Final

import numpy as np

from electrovib.recordings.transitions.estimate import Interval, from_noise, none
from electrovib.recordings.transitions.forms import EXPONENTIAL, INSTANTANEOUS, RelaxationForm
from electrovib.recordings.transitions.problem import EdgeProblem, starts
from electrovib.recordings.transitions.profile import profile_of_time
from electrovib.recordings.transitions.separable import Whitening

if TYPE_CHECKING:
    from collections.abc import Sequence

    from electrovib.core.arrays import Real
    from electrovib.recordings.fit.estimate import LeastSquaresEstimate
    from electrovib.recordings.transitions.edges import EdgeRecord
    from electrovib.recordings.transitions.sensor import Sensor

_APART: Final = 1.2
"""Smallest ratio of two time constants that are counted as two."""


@dataclass(frozen=True, kw_only=True)
class FittedForm:
    """One form of relaxation fitted to one edge.

    - `estimate`: ``start`` [s], time constants [s], ``stretching``, sensor if it was estimated, and
      amplitudes.
    - `sensor`: natural frequency [Hz] and quality factor through which it was seen.
    - `aicc`: on residuals whose correlation was filtered out; infinite if the form was rejected.
    - `between`: time between the levels of the force, the sensor taken out.
    - `misfit`: rms of the residual after the start over the standard deviation of the noise before the edge.
    """

    form: RelaxationForm
    estimate: LeastSquaresEstimate
    sensor: tuple[float, float] | None
    aicc: float
    rejected: str
    between: Interval
    reading: Real
    misfit: float


def fit_forms(
    edge: EdgeRecord,
    *,
    forms: Sequence[RelaxationForm],
    fractions: tuple[float, float],
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
    problem = EdgeProblem(edge=edge, fractions=fractions, sensor=sensor, estimated=estimated)
    before = edge.fit_time < min(0.0, edge.passages.first - edge.passages.time)
    white = Whitening.of(edge.fit_values[before])
    found: dict[str, LeastSquaresEstimate] = {}
    fewer = forms[0]
    for form in forms:
        if form.exponentials > 2 and _rejected(fewer, found[fewer.name]):
            continue  # more terms than are found already in a sum of fewer
        found[form.name] = problem.separable(form).solve(starts(problem, form, found))
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
    between = _between(problem, form, estimate) if not rejected else none(math.nan, rejected)
    filtered = problem.separable(form).solve([values], whitening=white)
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
    value = form.time_between(estimate.values, problem.fractions)
    if form is INSTANTANEOUS:
        return none(0.0, "an instantaneous change has no time to be estimated")
    if estimate.covariance is None:
        return none(value, estimate.why_no_covariance)
    slopes = []
    for name, at in estimate.values.items():
        step = 1e-5 * (abs(at) or 1.0)
        if name == "start" or name in {"frequency", "quality", "after"}:
            slopes.append(0.0)
            continue
        more, less = (
            form.time_between({**estimate.values, name: at + sign * step}, problem.fractions)
            for sign in (1, -1)
        )
        slopes.append((more - less) / (2 * step))
    error = math.sqrt(max(float(np.array(slopes) @ estimate.covariance @ np.array(slopes)), 0.0))
    if form is EXPONENTIAL and (error > 0.2 * value or "time_constant" in estimate.on_bound):
        return profile_of_time(problem, estimate, error)
    return from_noise(value, error, freedom=estimate.degrees_of_freedom)
