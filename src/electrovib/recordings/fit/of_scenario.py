"""The fit of a scenario's parameters to recordings of one or several sessions."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Final

import numpy as np

from electrovib.core.errors import ElectrovibError, InputError
from electrovib.recordings.fit.least_squares import least_squares
from electrovib.recordings.fit.measured import MeasuredTrace, Observed
from electrovib.recordings.fit.prediction import Prediction, Unknown
from electrovib.recordings.fit.residuals import Residuals, residuals_of
from electrovib.recordings.fit.sessions import BetweenSessions, between_sessions
from electrovib.scenario import Scenario, Source, read_scenario

if TYPE_CHECKING:
    import xarray

    from electrovib.core.arrays import Real
    from electrovib.recordings.fit.estimate import LeastSquaresEstimate

SEARCHED: Final = 1e-10
"""Relative change at which the search for parameters of a scenario ends: the precision of its derivatives."""
_SETTLED: Final = 1e-3
"""Relative change of an estimated noise from which on it is not estimated anew."""
_MOST_ROUNDS: Final = 20


@dataclass(frozen=True, kw_only=True)
class ScenarioFit:
    """Parameters of a scenario, estimated from recordings.

    Parameters
    ----------
    estimate : LeastSquaresEstimate
        Values and covariance of all unknowns; zeros of signals among them.
    unknowns : tuple of Unknown
        In the order of the estimate.
    scenario : Scenario
        With the estimated parameters; of a parameter that varies between sessions, with the mean of the sessions.
    sessions : mapping of str to BetweenSessions
        By path: the spread of each parameter that varies.
    residuals : tuple of Residuals
        For each signal of each recording.
    """

    estimate: LeastSquaresEstimate
    unknowns: tuple[Unknown, ...]
    scenario: Scenario
    sessions: Mapping[str, BetweenSessions]
    residuals: tuple[Residuals, ...]


def fit(
    scenario: Source,
    recordings: Sequence[MeasuredTrace | xarray.Dataset] | MeasuredTrace | xarray.Dataset,
    *,
    free: Sequence[str],
    varying: Sequence[str] = (),
    signals: Sequence[str] | None = None,
    start: Mapping[str, float] | None = None,
    progress: Callable[[int, float], bool] | None = None,
) -> ScenarioFit:
    """LeastSquaresEstimate parameters of a scenario from recordings.

    Parameters
    ----------
    scenario : str, Path, mapping, Scenario or xarray.Dataset
        The experiment, as for `electrovib.load`; its values of the free parameters are where the search begins.
    recordings : MeasuredTrace or xarray.Dataset, or a sequence of them
        Signals over time or frequency: steps, sweeps and impedance spectra together share parameters.
    free : sequence of str
        Dotted paths of the unknown parameters; their bounds are those that the models declare.
    varying : sequence of str
        Those of them that differ between the sessions of the recordings.
    signals : sequence of str, optional
        Only these signals; by default all that the recordings hold and the scenario predicts.
    start : mapping of str to float, optional
        Initial values by path, in SI.
    progress : callable, optional
        Called with the number of evaluations and the sum of squares; the fit ends with an error when it gives True.

    Returns
    -------
    ScenarioFit
        Estimates with covariance, residuals, and the scenario with these values.

    Raises
    ------
    InputError
        For wrong paths, recordings without a signal to fit, or values that the models refuse at the start.

    Notes
    -----
    Weighted least squares. Noise that is not stated is estimated for each signal of each recording from its residuals, in
    turn with the parameters, until it stands still: the estimate of largest likelihood, with the degrees of freedom that
    the parameters take shared among the signals by their number of data.
    """
    given = [recordings] if not isinstance(recordings, Sequence) else list(recordings)
    measured = [
        each if isinstance(each, MeasuredTrace) else MeasuredTrace(trace=each, name=f"recording {at + 1}")
        for at, each in enumerate(given)
    ]
    if not free:
        raise InputError("free: name at least one parameter, for instance stack.gap.thickness")
    prediction = Prediction(
        read_scenario(scenario), measured, free=free, varying=varying, signals=signals, start=start
    )
    noise, estimate = _weighted(prediction, progress)
    values = estimate.values
    means = {
        path: between_sessions(
            estimate, {each.session: each.name for each in prediction.unknowns if each.path == path}
        )
        for path in varying
    }
    shared = {path: values[path] for path in free if path not in varying}
    return ScenarioFit(
        estimate=estimate,
        unknowns=prediction.unknowns,
        scenario=prediction.prepared[0].scenario(shared | {path: each.mean for path, each in means.items()}),
        sessions=means,
        residuals=tuple(residuals_of(prediction, values, noise)),
    )


def _weighted(
    prediction: Prediction, progress: Callable[[int, float], bool] | None
) -> tuple[list[float], LeastSquaresEstimate]:
    """LeastSquaresEstimate parameters, and in turn with them the noise that is not stated."""
    columns = [each for group in prediction.columns for each in group]
    stated = [each.noise for each in columns]
    alone = len(columns) == 1 and stated[0] is None
    noise = [
        each if each is not None else 1.0 if alone else _first_guess(column)
        for each, column in zip(stated, columns, strict=True)
    ]
    free, evaluations = prediction.free, 0
    for _ in range(_MOST_ROUNDS):
        estimate = _once(prediction, free, noise, progress, known=not alone)
        evaluations += estimate.evaluations
        free = {name: each.starting_at(estimate.values[name]) for name, each in prediction.free.items()}
        sizes = np.array([each.x.size * each.parts for each in columns], dtype=float)
        taken = len(free) / sizes.sum()
        left = [each.root_mean_square for each in residuals_of(prediction, estimate.values, noise)]
        scatter = [float(rms / np.sqrt(max(1 - taken, 1e-3))) for rms in left]
        if alone:
            return scatter, estimate
        after = [
            each if each is not None else max(found, 1e-300)
            for each, found in zip(stated, scatter, strict=True)
        ]
        change = max(abs(new / old - 1) for new, old in zip(after, noise, strict=True))
        noise = after
        if change < _SETTLED:
            break
    return noise, estimate


def _first_guess(column: Observed) -> float:
    """Noise of a signal over its scale from its third differences, in which what is smooth cancels."""
    if column.y.size > 8:
        rough = np.diff(column.y / column.scale, 3)
        found = float(np.median(np.abs(rough)) / 0.6745 / np.sqrt(20 * column.parts))
        if found > 0:
            return found
    return float(np.max(np.abs(column.y / column.scale))) * 1e-3 or 1.0


def _once(
    prediction: Prediction,
    free: Mapping[str, object],
    noise: Sequence[float],
    progress: Callable[[int, float], bool] | None,
    *,
    known: bool,
) -> LeastSquaresEstimate:
    columns = [each for group in prediction.columns for each in group]
    weights = np.concatenate(
        [np.tile(1 / (sigma * each.scale), each.parts) for each, sigma in zip(columns, noise, strict=True)]
    )
    data, first, count = prediction.data, True, 0

    def residual(values: Mapping[str, float]) -> Real:
        nonlocal first, count
        try:
            found: Real = (prediction(values) - data) * weights
        except ElectrovibError:
            if first:
                raise
            return np.full(data.shape, np.nan)
        first, count = False, count + 1
        if progress is not None and progress(count, float(found @ found)):
            raise CancelledError("the fit was cancelled")
        return found

    return least_squares(
        residual,
        free,  # type: ignore[arg-type]
        derivatives=lambda values: prediction.derivatives(values) * weights[:, None],
        final_derivatives=lambda values: prediction.derivatives(values, final=True) * weights[:, None],
        noise_is_known=known,
        converged=SEARCHED,
    )


class CancelledError(ElectrovibError):
    """A fit that was ended by its callback."""
