"""The weighted least-squares problem of a scenario's fit, for given noise of each signal."""

from __future__ import annotations

import dataclasses
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Final

import numpy as np

from electrovib.core.errors import ElectrovibError, InputError
from electrovib.recordings.fit.estimate import estimate_at
from electrovib.recordings.fit.least_squares import FreeParameter, least_squares
from electrovib.recordings.fit.newton import newton_step
from electrovib.recordings.fit.prediction import Prediction
from electrovib.recordings.fit.separated import OutsideBoundsError, Separated
from electrovib.recordings.fit.stalled import Stall

if TYPE_CHECKING:
    from electrovib.core.arrays import Real
    from electrovib.recordings.fit.estimate import LeastSquaresEstimate

SEARCHED: Final = 1e-9
"""Relative change at which the search for parameters of a scenario ends: the precision of its derivatives."""
_CLOSE: Final = 0.01
"""Remaining step over the standard deviation up to which a search has ended."""
_MOST_NEAR: Final = 6
"""Gauss-Newton steps from values close to the minimum, before the general search is used."""
_ROUGHLY: Final = 1e-6
"""Relative change at which the search for a point of a profile ends."""
_PRECISION: Final = 1e-7
"""Remaining step over the value that the precision of the derivatives does not resolve."""
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
        columns = [each for group in self.prediction.columns for each in group]
        self.weights: Real = np.concatenate(
            [
                np.tile(1 / (sigma * each.scale), each.parts)
                for each, sigma in zip(columns, self.noise, strict=True)
            ]
        )
        self.data: Real = self.prediction.data

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
        self,
        free: Mapping[str, FreeParameter],
        *,
        known: bool,
        fixed: Mapping[str, float] | None = None,
        converged: float = SEARCHED,
    ) -> LeastSquaresEstimate:
        """Minimise the sum of squares over the free unknowns, without covariance if `converged` is above `SEARCHED`."""
        held, names, judged = dict(fixed or {}), tuple(free), converged <= SEARCHED
        separated = Separated(self, free, held)
        if separated.is_useful:
            try:
                return self._minimum_of_others(separated, free, held, known=known, converged=converged)
            except OutsideBoundsError:
                pass  # the bound is found by the search for all unknowns
        return least_squares(
            lambda values: self.residual(held | dict(values)),
            free,
            derivatives=lambda values: self.derivatives(held | dict(values), names=names),
            noise_is_known=known,
            converged=converged,
            judged=judged,
            stall=self._stall(free, 1.0 if known else None),
        )

    def _stall(self, free: Mapping[str, FreeParameter], variance: float | None) -> Stall:
        zeros = [each.name for each in self.prediction.unknowns if each.is_offset and each.name in free]
        return Stall(variance, zeros)

    def _minimum_of_others(
        self,
        separated: Separated,
        free: Mapping[str, FreeParameter],
        held: Mapping[str, float],
        *,
        known: bool,
        converged: float,
    ) -> LeastSquaresEstimate:
        """Search for the unknowns that are not linear, and judge all of them together."""
        found = least_squares(
            separated.residual,
            separated.others,
            derivatives=separated.derivatives,
            noise_is_known=known,
            converged=converged,
            judged=False,
            stall=self._stall(separated.others, 1.0 if known else None),
        )
        best, _, _ = separated.best(found.values)
        values = {name: found.values[name] if name in found.values else best[name] for name in free}
        if converged > SEARCHED:
            return dataclasses.replace(found, values=values)
        return estimate_at(
            values,
            residual=self.residual(dict(held) | dict(values)),
            derivatives=self.derivatives(dict(held) | dict(values), names=tuple(free)),
            noise_is_known=known,
            on_bound={name: bound for name in free if (bound := free[name].bound_at(values[name]))},
            evaluations=found.evaluations,
            converged=found.converged,
            stalled=found.stalled,
        )

    def minimum_near(self, free: Mapping[str, FreeParameter], *, known: bool) -> LeastSquaresEstimate:
        """Minimise the sum of squares from starting values that are close to the minimum, by Gauss-Newton steps.

        It ends where a further step is less than 1 % of a standard deviation or 1e-7 of the value. Where a
        step leads to a bound or to a larger sum of squares, or `_MOST_NEAR` steps do not suffice, this is the
        result of `minimum`.
        """
        values = {name: each.start for name, each in free.items()}
        left = self.residual(values)
        squares = float(left @ left)
        for count in range(1, _MOST_NEAR + 1):
            step, deviations = newton_step(self.derivatives(values), left)
            now = np.array(list(values.values()))
            if not (np.isfinite(squares) and np.isfinite(step).all()):
                break
            scatter = 1.0 if known else np.sqrt(squares / max(left.size - len(values), 1))
            small = np.maximum(_CLOSE * scatter * deviations, _PRECISION * np.abs(now))
            if (np.abs(step) < small).all():
                return estimate_at(
                    values,
                    residual=left,
                    derivatives=self.derivatives(values),
                    noise_is_known=known,
                    on_bound={},
                    evaluations=count,
                    converged=True,
                )
            moved = dict(zip(values, (now + step).tolist(), strict=True))
            if any(not each.lower < moved[name] < each.upper for name, each in free.items()):
                break
            left = self.residual(moved)
            if not float(left @ left) <= squares * (1 + SEARCHED):
                break
            values, squares = moved, float(left @ left)
        again = {name: each.starting_at(values[name]) for name, each in free.items()}
        return self.minimum(again, known=known)

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
            return least_squares(
                separated.residual,
                separated.others,
                derivatives=separated.derivatives,
                noise_is_known=True,
                converged=_ROUGHLY,
                judged=False,
                stall=self._stall(separated.others, variance),
            ).sum_of_squares
        except InputError:
            return np.inf
