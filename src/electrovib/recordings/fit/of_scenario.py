"""The fit of a scenario's parameters to recordings of one or several sessions."""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Collection, Mapping, Sequence
from typing import TYPE_CHECKING, Final

import numpy as np

from electrovib.core.errors import ElectrovibError, InputError
from electrovib.core.paths import value_at
from electrovib.recordings.fit.identifiability import identifiability, rounding_of, trades
from electrovib.recordings.fit.measured import MeasuredTrace, as_recorded
from electrovib.recordings.fit.misfit import misfit_of
from electrovib.recordings.fit.prediction import Prediction, residuals_of
from electrovib.recordings.fit.problem import Callback, CancelledError, WeightedProblem, first_noise, weighted
from electrovib.recordings.fit.result import ScenarioFit
from electrovib.recordings.fit.sessions import BetweenSessions, between_sessions
from electrovib.scenario import Scenario, Source, read_scenario

if TYPE_CHECKING:
    import xarray

    from electrovib.core.arrays import Real
    from electrovib.recordings.fit.least_squares import FreeParameter, LeastSquaresEstimate

_FEW: Final = 400
"""Samples of each recording with which a search begins; the last steps take all of them."""
_ROUGH: Final = 1e-3


def fit_scenario(
    scenario: Source,
    recordings: Sequence[MeasuredTrace | xarray.Dataset] | MeasuredTrace | xarray.Dataset,
    *,
    free: Sequence[str],
    varying: Sequence[str] = (),
    signals: Sequence[str] | None = None,
    start: Mapping[str, float] | None = None,
    keep: Sequence[str] = (),
    progress: Callback | None = None,
) -> ScenarioFit:
    """Estimate parameters of a scenario from recordings.

    Weighted least squares. The search begins at the values of the scenario, or at `start`, in SI; the bounds
    of the `free` parameters are those that the models declare, and `varying` ones differ between the sessions
    of the recordings. `keep` names the parts (``"drive"``, ``"load"``, ``"motion"``) that are taken from the
    scenario although a recording holds them. Noise that is not stated is estimated for each signal of each
    recording from its residuals, in turn with the parameters, until it changes by less than 0.1 %: the
    estimate of largest likelihood, with the degrees of freedom that the parameters take shared among the
    signals by their number of data. Combinations that the data do not determine are named, and their
    parameters have no interval: see `identifiability`.
    """
    measured = _measured(recordings)
    if not free:
        raise InputError("free: name at least one parameter, for instance stack.gap.thickness")
    base = read_scenario(scenario)
    measured, said = as_recorded(base, measured, free, keep)
    prediction = Prediction(base, measured, free=free, varying=varying, signals=signals, start=start)
    few = _with_few(base, measured, prediction, (free, varying, signals))
    begin = _roughly(few, prediction, progress)
    noise, estimate, problem = weighted(prediction, begin, progress, near=begin is not prediction.free)
    found = _judged(
        problem, WeightedProblem(few or prediction, noise), estimate, noise, free=free, varying=varying
    )
    if not said:
        return found
    own = {path: value_at(found.scenario, path) for path in free}
    return dataclasses.replace(found, scenario=base.replace(own), prescribed=tuple(said))


def _measured(
    recordings: Sequence[MeasuredTrace | xarray.Dataset] | MeasuredTrace | xarray.Dataset,
) -> list[MeasuredTrace]:
    given = [recordings] if not isinstance(recordings, Sequence) else list(recordings)
    return [
        each if isinstance(each, MeasuredTrace) else MeasuredTrace(trace=each, name=f"recording {at + 1}")
        for at, each in enumerate(given)
    ]


def _judged(
    problem: WeightedProblem,
    few: WeightedProblem,
    estimate: LeastSquaresEstimate,
    noise: Sequence[float],
    *,
    free: Sequence[str],
    varying: Sequence[str],
) -> ScenarioFit:
    """Judge what the data determine, and collect the result."""
    prediction, values = problem.prediction, estimate.values
    inside = [name for name in values if name not in estimate.on_bound]
    rows = [list(values).index(name) for name in inside]
    zeros = [each.name for each in prediction.unknowns if each.is_offset]
    residuals = tuple(residuals_of(prediction, values, noise))
    misfit = misfit_of(problem, values, residuals)
    variance = misfit.inflation * (1.0 if estimate.noise_is_known else max(estimate.variance, 0.0))
    judged = identifiability(
        problem.derivatives(values)[:, rows] / np.sqrt(variance or 1.0),
        {name: values[name] for name in inside},
        zeros=zeros,
    )
    traded = _traded(problem.derivatives(values), list(values), estimate.on_bound)
    estimate = dataclasses.replace(
        estimate,
        covariance=_whole(judged.covariance, list(values), rows, traded),
        why_no_covariance="; ".join(each.sentence for each in judged.undetermined),
    )
    kept = [name for name in inside if judged.states[name] != "not" and name not in traded]
    at = [inside.index(name) for name in kept]
    bias = curvature_bias(few, values, kept, judged.covariance[np.ix_(at, at)]) if kept else {}
    rounding = rounding_of(residuals, problem.derivatives(values)[:, rows], problem.weights, inside)
    states = {
        name: "weakly"
        if state == "well"
        and name not in traded
        and (abs(bias[name]) > BIASED or (rounding is not None and rounding.is_coarse(name, values[name])))
        else state
        for name, state in judged.states.items()
    }
    means = _means(estimate, prediction, varying)
    shared = {path: values[path] for path in free if path not in varying}
    return ScenarioFit(
        estimate=estimate,
        unknowns=prediction.unknowns,
        scenario=prediction.prepared[0].scenario(shared | {path: each.mean for path, each in means.items()}),
        sessions=means,
        residuals=residuals,
        determined=states | dict.fromkeys(traded, "not") | dict.fromkeys(estimate.on_bound, "bound"),
        traded=traded,
        bias=bias,
        undetermined=judged.undetermined,
        problem=problem,
        rounding=rounding,
        misfit=misfit,
    )


def _means(
    estimate: LeastSquaresEstimate, prediction: Prediction, varying: Sequence[str]
) -> dict[str, BetweenSessions]:
    return {
        path: between_sessions(
            estimate, {each.session: each.name for each in prediction.unknowns if each.path == path}
        )
        for path in varying
    }


def _whole(covariance: Real, names: Sequence[str], rows: Sequence[int], traded: Collection[str]) -> Real:
    """Return the covariance of all unknowns: 0 of those on a bound, infinite of those that trade with one."""
    found = np.zeros((len(names), len(names)))
    found[np.ix_(rows, rows)] = covariance
    for at in map(names.index, traded):
        found[at, :] = found[:, at] = np.nan
        found[at, at] = np.inf
    return found


def _traded(slopes: Real, names: Sequence[str], on_bound: Mapping[str, str]) -> dict[str, str]:
    """Return the unknowns that trade with one on its bound, each with that one."""
    return {
        name: other
        for at, name in enumerate(names)
        for other in on_bound
        if name not in on_bound and trades(slopes, at, names.index(other))
    }


def _with_few(
    base: Scenario,
    measured: Sequence[MeasuredTrace],
    whole: Prediction,
    asked: tuple[Sequence[str], Sequence[str], Sequence[str] | None],
) -> Prediction | None:
    """Make the prediction for a few samples of each recording; None where no recording is long."""
    thinned = [dataclasses.replace(each, trace=_thinned(each.trace)) for each in measured]
    if all(after.trace is before.trace for after, before in zip(thinned, measured, strict=True)):
        return None
    free, varying, signals = asked
    few = Prediction(base, thinned, free=free, varying=varying, signals=signals)
    few.free = whole.free
    return few


def _roughly(
    few: Prediction | None, whole: Prediction, progress: Callback | None
) -> dict[str, FreeParameter]:
    """Search with few samples of long recordings, and return where the search with all of them begins."""
    if few is None:
        return whole.free
    noise = [first_noise(each) for group in few.columns for each in group]
    try:
        found = WeightedProblem(few, noise, progress).minimum(whole.free, known=True, converged=_ROUGH)
    except CancelledError:
        raise
    except ElectrovibError:
        return whole.free
    return {name: each.starting_at(found.values[name]) for name, each in whole.free.items()}


def _thinned(trace: xarray.Dataset) -> xarray.Dataset:
    steps = {name: size // _FEW for name, size in trace.sizes.items() if name in {"time", "frequency"}}
    wide = {name: slice(None, None, step) for name, step in steps.items() if step > 1}
    return trace.isel(wide) if wide else trace


BIASED: Final = 0.05
"""Bias over standard deviation above which a parameter does not count as well determined."""


def curvature_bias(
    problem: WeightedProblem, values: Mapping[str, float], names: Sequence[str], covariance: Real
) -> dict[str, float]:
    """Compute the bias over standard deviation of estimates from the curvature of the predictions.

    To second order the bias is the solution b of J b = -d/2 by least squares, with J the derivatives and d
    the sum of the second differences of the predictions along the columns of the Cholesky factor of the
    covariance (Box 1971). It is infinite where the models refuse values one standard deviation away. A
    representative part of the samples suffices.
    """
    deviations = np.sqrt(np.diag(covariance))
    scaled = covariance / np.outer(deviations, deviations)
    try:
        factor = np.linalg.cholesky(scaled) * deviations[:, None]
        base = problem.prediction(values)
        second = np.zeros(base.size)
        for column in factor.T:
            for side in (1, -1):
                moved = {name: values[name] + side * each for name, each in zip(names, column, strict=True)}
                second += problem.prediction(dict(values) | moved) - base
    except (ElectrovibError, np.linalg.LinAlgError):
        return dict.fromkeys(names, math.inf)
    slopes = problem.derivatives(values, names=names) * deviations
    found, *_ = np.linalg.lstsq(slopes, -0.5 * second * problem.weights)
    return {name: float(each) for name, each in zip(names, found, strict=True)}
