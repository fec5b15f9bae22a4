"""The weighted least-squares problem of a scenario's fit: its linear unknowns, its search, and the noise of each signal."""

from __future__ import annotations

import dataclasses
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any, Final

import numpy as np

from electrovib.core.errors import ElectrovibError, InputError
from electrovib.recordings.fit.identifiability import Stall
from electrovib.recordings.fit.least_squares import FreeParameter, LeastSquaresEstimate, least_squares
from electrovib.recordings.fit.prediction import Prediction, residuals_of
from electrovib.recordings.interval import rough_noise

if TYPE_CHECKING:
    from electrovib.core.arrays import Real
    from electrovib.recordings.fit.measured import Observed

SEARCHED: Final = 1e-9
"""Relative change at which the search for parameters of a scenario ends: the precision of its derivatives."""
_ROUGHLY: Final = 1e-6
"""Relative change at which the search for a point of a profile ends."""
Callback = Callable[[int, float], bool | None]


class CancelledError(ElectrovibError):
    """A fit that was ended by its callback."""


@dataclass
class WeightedProblem:
    """Weighted residuals of a prediction and their derivatives.

    `noise` is the standard deviation of each signal of each recording, over the scale of its data. A true
    value of `progress` ends the fit.
    """

    prediction: Prediction
    noise: Sequence[float]
    progress: Callback | None = None
    count: int = field(default=0, init=False)

    def __post_init__(self) -> None:
        pieces = zip(self.prediction.pieces(), self.noise, strict=True)
        self.weights: Real = np.concatenate(
            [np.tile(1 / (sigma * each.scale), each.parts) for (_, _, each, _), sigma in pieces]
        )
        self.data: Real = self.prediction.data

    def __getstate__(self) -> dict[str, Any]:
        """Return what is pickled or copied: all but whom it tells."""
        return vars(self) | {"progress": None}

    def residual(self, values: Mapping[str, float]) -> Real:
        """Return the weighted residuals, shape (n,), dimensionless; NaN where the models refuse the values."""
        try:
            found: Real = (self.prediction(values) - self.data) * self.weights
        except ElectrovibError:
            if not self.count:
                raise
            return np.full(self.data.shape, np.nan)
        self.count += 1
        if self.progress is not None and self.progress(self.count, float(found @ found)):
            raise CancelledError("the fit was cancelled")
        return found

    def derivatives(self, values: Mapping[str, float], *, names: Sequence[str] | None = None) -> Real:
        """Return the derivatives of the residuals after the unknowns, shape (n, unknowns), in 1 over the unit of each."""
        return self.prediction.derivatives(values, names=names) * self.weights[:, None]

    def minimum(
        self, free: Mapping[str, FreeParameter], *, known: bool, converged: float = SEARCHED
    ) -> LeastSquaresEstimate:
        """Minimise the sum of squares over the free unknowns, without covariance if `converged` is above `SEARCHED`."""
        whole, separated = Separated(self, free, {}, separate=False), Separated(self, free, {})
        variance = 1.0 if known else None
        try:
            separated = separated if separated.is_useful else whole
            found = self._searched(separated, variance, converged)
        except OutsideBoundsError:  # the bound is found by the search for all unknowns
            separated = whole
            found = self._searched(separated, variance, converged)
        best = dict(found.values) | (separated.best(found.values)[0] if separated.linear else {})
        values = {name: best[name] for name in free}
        found = dataclasses.replace(found, values=values)
        if converged > SEARCHED:
            return found
        return found.judged(self.residual(values), self.derivatives(values, names=tuple(free)), free)

    def _searched(
        self, separated: Separated, variance: float | None, converged: float
    ) -> LeastSquaresEstimate:
        """Search for the unknowns that are not separated; `variance` is that of the residuals where it is known."""
        zeros = [
            each.name for each in self.prediction.unknowns if each.is_offset and each.name in separated.others
        ]
        return least_squares(
            separated.residual,
            separated.others,
            derivatives=separated.derivatives,
            noise_is_known=variance is not None,
            converged=converged,
            judged=False,
            stall=Stall(variance, zeros),
        )

    def rise(
        self,
        name: str,
        value: float,
        at: Mapping[str, float],
        free: Mapping[str, FreeParameter],
        *,
        variance: float = 1.0,
    ) -> float:
        """Smallest sum of squares with one unknown held at a value; infinite where the models refuse the value."""
        others = {each: free[each].starting_at(at[each]) for each in free if each != name}
        separated = Separated(self, others, {name: value}, within_bounds=True)
        try:
            if not separated.others:
                left = separated.residual({})
                return float(left @ left) if np.isfinite(left).all() else np.inf
            return self._searched(separated, variance, _ROUGHLY).sum_of_squares
        except InputError:
            return np.inf


class OutsideBoundsError(ElectrovibError):
    """A linear unknown whose best value is not between its bounds."""


class Separated:
    """A weighted problem as a function of the unknowns that are not linear in it, with the best values of the others.

    `fixed` values are in SI; without `separate` no unknown counts as linear. Linear unknowns are kept
    `within_bounds`; else a best value outside them is an error. For given values of the other unknowns the
    best values of the linear ones solve a linear least-squares problem with the columns G. The derivatives of
    the remaining residual are those of the predictions at these values, less their projection on G (Golub and
    Pereyra 1973, in the form of Kaufman 1975); columns of unknowns on a bound are omitted from G. The minimum
    is that of all unknowns together.
    """

    def __init__(
        self,
        problem: WeightedProblem,
        free: Mapping[str, FreeParameter],
        fixed: Mapping[str, float],
        *,
        within_bounds: bool = False,
        separate: bool = True,
    ) -> None:
        self._problem, self._fixed, self._within_bounds = problem, dict(fixed), within_bounds
        prediction = problem.prediction
        by_name = {each.name: each for each in prediction.unknowns}
        rows = {name: prediction.linear_rows(by_name[name]) for name in free}
        found = {name: row for name, row in rows.items() if row is not None and separate}
        self._factors = {name: row for name, row in found.items() if not by_name[name].is_offset}
        overlapping = sum(
            (row.astype(int) for row in self._factors.values()), np.zeros(problem.data.size, int)
        )
        if np.any(overlapping > 1) or any(free[name].start <= 0 for name in self._factors):
            found = {name: row for name, row in found.items() if name not in self._factors}
            self._factors = {}
        self._rows = found
        self.linear: tuple[str, ...] = tuple(found)
        self.others = {name: each for name, each in free.items() if name not in found}
        self._free = dict(free)
        self._reference = {name: free[name].start if name in self._factors else 0.0 for name in self.linear}

    @property
    def is_useful(self) -> bool:
        """Whether there are linear unknowns and others beside them."""
        return bool(self.linear) and bool(self.others)

    def best(self, values: Mapping[str, float]) -> tuple[dict[str, float], Real, Real]:
        """Return the best values of the linear unknowns, orthonormal columns of those inside their bounds, and the residual.

        The columns, shape (n, inside), span the weighted derivatives; the residual is NaN where the models
        refuse the values.
        """
        problem = self._problem
        left = problem.residual(self._fixed | dict(values) | self._reference)
        if not self.linear:
            return {}, np.zeros((left.size, 0)), left
        whole = left + problem.data * problem.weights
        columns = np.stack([self._column(name, whole) for name in self.linear], axis=1)
        rest = whole.copy()
        for rows in self._factors.values():
            rest[rows] = 0.0
        wanted = problem.data * problem.weights - rest
        if not np.isfinite(whole).all():
            return dict(self._reference), columns, np.full(whole.shape, np.nan)
        orthonormal, triangle = np.linalg.qr(columns)
        share = orthonormal.T @ wanted
        found = np.linalg.solve(triangle, share)
        linear = dict(zip(self.linear, found.tolist(), strict=True))
        for name, value in linear.items():
            if not self._free[name].lower < value < self._free[name].upper:
                if self._within_bounds:
                    return self._best_within_bounds(columns, wanted)
                raise OutsideBoundsError(f"{name} = {value:g} is outside its bounds")
        return linear, orthonormal, orthonormal @ share - wanted

    def _best_within_bounds(self, columns: Real, wanted: Real) -> tuple[dict[str, float], Real, Real]:
        """Compute the same for unknowns of which at least one is on a bound."""
        from scipy.optimize import lsq_linear

        size = np.linalg.norm(columns, axis=0)
        ends = np.array([(self._free[name].lower, self._free[name].upper) for name in self.linear])
        solved = lsq_linear(columns / size, wanted, bounds=(ends * size[:, None]).T, method="bvls")
        orthonormal = np.linalg.qr(columns[:, solved.active_mask == 0])[0]
        linear = dict(zip(self.linear, (solved.x / size).tolist(), strict=True))
        return linear, orthonormal, columns @ (solved.x / size) - wanted

    def _column(self, name: str, whole: Real) -> Real:
        rows = self._rows[name]
        column = np.zeros(whole.size)
        column[rows] = (
            whole[rows] / self._reference[name] if name in self._factors else self._problem.weights[rows]
        )
        return column

    def residual(self, values: Mapping[str, float]) -> Real:
        """Return the weighted residual with the best linear unknowns, shape (n,), dimensionless."""
        return self.best(values)[2]

    def derivatives(self, values: Mapping[str, float]) -> Real:
        """Return its derivatives after the other unknowns, shape (n, others), in 1 over the unit of each."""
        at = self._fixed | dict(values) | self._reference
        slopes = self._problem.derivatives(at, names=tuple(self.others))
        if not self.linear:
            return slopes
        linear, orthonormal, _ = self.best(values)
        for name, rows in self._factors.items():
            slopes[rows] *= linear[name] / self._reference[name]
        return np.asarray(slopes - orthonormal @ (orthonormal.T @ slopes))


_SETTLED: Final = 1e-3
"""Relative change of an estimated noise, or of a scale, from which on the parameters are not estimated again."""
_MOST_ROUNDS: Final = 20
_LEAST_NOISE: Final = 1e-9
"""Noise relative to the largest value that is always assumed: the accuracy of a prediction."""


def weighted(
    prediction: Prediction, begin: Mapping[str, FreeParameter], progress: Callback | None
) -> tuple[list[float], LeastSquaresEstimate, WeightedProblem]:
    """Estimate parameters, and in turn with them the noise, over the scale of its data, that is not stated."""
    columns = [each for group in prediction.columns for each in group]
    stated = [each.noise for each in columns]
    alone = len(columns) == 1 and stated[0] is None
    noise = [
        each if each is not None else 1.0 if alone else first_noise(column)
        for each, column in zip(stated, columns, strict=True)
    ]
    free, evaluations = begin, 0
    for _ in range(_MOST_ROUNDS):
        problem = WeightedProblem(prediction, noise, progress)
        estimate = problem.minimum(free, known=None not in stated)
        evaluations += estimate.evaluations
        free = {name: each.starting_at(estimate.values[name]) for name, each in prediction.free.items()}
        moved = prediction.rescale(estimate.values)
        taken = len(free) / prediction.data.size
        left = [each.root_mean_square for each in residuals_of(prediction, estimate.values, noise)]
        scatter = [float(rms / np.sqrt(max(1 - taken, 1e-3))) for rms in left]
        after = [
            max(found, least_noise(column)) if each is None else each
            for each, found, column in zip(stated, scatter, columns, strict=True)
        ]
        if alone or None not in stated:
            if moved < _SETTLED:
                noise = after
                break
            continue
        change = max(abs(new / old - 1) for new, old in zip(after, noise, strict=True))
        if max(change, moved) < _SETTLED:
            break
        noise = after
    return noise, dataclasses.replace(estimate, evaluations=evaluations), problem


def first_noise(column: Observed) -> float:
    """Return the noise of a signal over its scale [1], stated or from its third differences, in which a smooth course cancels."""
    if column.noise is not None:
        return column.noise
    least, found = least_noise(column), rough_noise(column.y / column.scale)
    return found if found > least else 1e6 * least


def least_noise(column: Observed) -> float:
    """Noise over the scale of a signal below which its residuals are those of rounding."""
    return _LEAST_NOISE * float(np.max(np.abs(column.y / column.scale))) or 1.0
