"""Parameters of a form of relaxation fitted to one edge, with their intervals."""

from __future__ import annotations

import math
from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np

from electrovib.recordings.transitions.estimate import Interval, from_noise, none
from electrovib.recordings.transitions.forms import EXPONENTIAL

if TYPE_CHECKING:
    from collections.abc import Sequence

    from electrovib.recordings.fit.estimate import LeastSquaresEstimate
    from electrovib.recordings.transitions.relaxation import FittedForm
    from electrovib.recordings.transitions.result import EdgeTimes


def parameters_of(edge: EdgeTimes, form: str, *, driven: bool, estimated: bool) -> dict[str, Interval]:
    """Return the parameters of a form fitted to one edge, each with its interval, by the names of `DirectionTimes`."""
    fitted = edge.fitted[form]
    estimate, errors = fitted.estimate, fitted.estimate.standard_deviations
    freedom = estimate.degrees_of_freedom
    found = {}
    if driven:
        error = math.hypot(errors["start"], edge.record.reference_error)
        found["delay"] = from_noise(estimate.values["start"], error, freedom=freedom)
    ordered = sorted(fitted.form.time_constants, key=lambda name: estimate.values[name])
    for place, name in enumerate(ordered, start=1):
        own = "time_constant" if len(ordered) == 1 else f"time_constant_{place}"
        found[own] = _from_profile(fitted, estimate.values[name]) or _plain(estimate, name)
        if len(ordered) > 1:
            share, error = _share(
                estimate, fitted.form.amplitudes[:-1], name.replace("time_constant", "change")
            )
            found[f"share_{place}"] = from_noise(share, error, freedom=freedom)
    for name in ("stretching", *(("frequency", "quality") if estimated else ())):
        if name in estimate.values:
            found[name] = _plain(estimate, name)
    return found


def _plain(estimate: LeastSquaresEstimate, name: str) -> Interval:
    """Return a parameter of a fit with its interval, or none on a bound."""
    if name in estimate.on_bound:
        return none(math.nan, f"on its {estimate.on_bound[name]} bound")
    error = estimate.standard_deviations[name]
    return from_noise(estimate.values[name], error, freedom=estimate.degrees_of_freedom)


def _share(estimate: LeastSquaresEstimate, changes: Sequence[str], own: str) -> tuple[float, float]:
    """Return the share of one term in the whole change, and its standard error."""
    whole = sum(estimate.values[name] for name in changes)
    share = estimate.values[own] / whole
    if estimate.covariance is None:
        return share, math.nan
    names = list(estimate.values)
    at = [names.index(name) for name in changes]
    slopes = np.array([((name == own) - share) / whole for name in changes])
    return share, math.sqrt(max(float(slopes @ estimate.covariance[np.ix_(at, at)] @ slopes), 0.0))


def _from_profile(fitted: FittedForm, value: float) -> Interval | None:
    """Return the interval of the time constant of an exponential whose time between levels has a profile."""
    if fitted.form is not EXPONENTIAL or not fitted.between.method.startswith("profile"):
        return None
    factor = value / fitted.between.value
    ends = {
        name: getattr(fitted.between, name) * factor for name in ("value", "lower", "upper", "standard_error")
    }
    return replace(fitted.between, **ends)
