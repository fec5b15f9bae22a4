"""The weighted least-squares problem of a scenario's fit, for given noise of each signal."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Final

import numpy as np

from electrovib.core.errors import ElectrovibError, InputError
from electrovib.recordings.fit.least_squares import FreeParameter, least_squares
from electrovib.recordings.fit.prediction import Prediction

if TYPE_CHECKING:
    from electrovib.core.arrays import Real
    from electrovib.recordings.fit.estimate import LeastSquaresEstimate

SEARCHED: Final = 1e-9
"""Relative change at which the search for parameters of a scenario ends: the precision of its derivatives."""
_CLOSE: Final = 0.01
"""Remaining step over the standard deviation up to which a search has ended."""
_MOST_NEAR: Final = 20
"""Evaluations with the same derivatives after which the search goes on with new ones."""
_PRECISION: Final = 1e-7
"""Remaining step over the value that the precision of the derivatives does not resolve."""
Callback = Callable[[int, float], bool | None]


class CancelledError(ElectrovibError):
    """A fit that was ended by its callback."""


@dataclass
class WeightedProblem:
    """Weighted residuals of a prediction and their derivatives.

    Parameters
    ----------
    prediction : Prediction
        Data and models.
    noise : sequence of float
        Standard deviation of each signal of each recording, over the scale of its data.
    progress : callable, optional
        Called with the number of evaluations and the sum of squares; a true value ends the fit.
    """

    prediction: Prediction
    noise: Sequence[float]
    progress: Callback | None = None
    count: int = field(default=0, init=False)

    def __post_init__(self) -> None:
        """Compute the weights of the data."""
        columns = [each for group in self.prediction.columns for each in group]
        self.weights: Real = np.concatenate(
            [
                np.tile(1 / (sigma * each.scale), each.parts)
                for each, sigma in zip(columns, self.noise, strict=True)
            ]
        )
        self.data: Real = self.prediction.data

    def residual(self, values: Mapping[str, float]) -> Real:
        """Return the weighted residuals, shape (n,), dimensionless; NaN where the models refuse the values.

        Raises
        ------
        ElectrovibError
            At the first evaluation, if the models refuse the values.
        CancelledError
            If the callback ends the fit.
        """
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
        """Minimise the sum of squares.

        Parameters
        ----------
        free : mapping of str to FreeParameter
            Unknowns that are searched, with their initial values.
        known : bool
            Whether the noise is known.
        fixed : mapping of str to float, optional
            Values of all other unknowns, in SI.
        converged : float
            Relative change at which the search ends.

        Returns
        -------
        estimate : LeastSquaresEstimate
            Of the free unknowns.
        """
        held, names = dict(fixed or {}), tuple(free)
        return least_squares(
            lambda values: self.residual(held | dict(values)),
            free,
            derivatives=lambda values: self.derivatives(held | dict(values), names=names),
            noise_is_known=known,
            converged=converged,
        )

    def minimum_near(self, free: Mapping[str, FreeParameter], *, known: bool) -> LeastSquaresEstimate:
        """Minimise the sum of squares from starting values that are close to the minimum, with derivatives taken only there.

        Parameters
        ----------
        free : mapping of str to FreeParameter
            All unknowns, with their initial values.
        known : bool
            Whether the noise is known.

        Returns
        -------
        estimate : LeastSquaresEstimate
            Judged with derivatives at the minimum. Where these ask for a further step of more than 1 % of a standard
            deviation and 1e-7 of the value, the search goes on with derivatives at each of its points.
        """
        begin = {name: each.start for name, each in free.items()}
        slopes = self.derivatives(begin)
        found = least_squares(
            self.residual,
            free,
            derivatives=lambda _: slopes,
            final_derivatives=self.derivatives,
            noise_is_known=known,
            converged=SEARCHED,
            most_evaluations=_MOST_NEAR,
        )
        inside = [at for at, name in enumerate(free) if name not in found.on_bound]
        step, *_ = np.linalg.lstsq(self.derivatives(found.values)[:, inside], self.residual(found.values))
        deviations = np.array(list(found.standard_deviations.values()))[inside]
        values = np.array(list(found.values.values()))[inside]
        small = np.maximum(_CLOSE * deviations, _PRECISION * np.abs(values))
        if found.converged and (np.abs(step) < small).all():
            return found
        again = {name: each.starting_at(found.values[name]) for name, each in free.items()}
        return self.minimum(again, known=known)

    def rise(
        self, name: str, value: float, at: Mapping[str, float], free: Mapping[str, FreeParameter]
    ) -> float:
        """Smallest sum of squares with one unknown held at a value.

        Parameters
        ----------
        name : str
            The unknown that is held.
        value : float
            Its value, in SI.
        at : mapping of str to float
            Estimates of all unknowns, with which the search begins.
        free : mapping of str to FreeParameter
            All unknowns.

        Returns
        -------
        squares : float
            Dimensionless; infinite where the models refuse the value.
        """
        others = {each: free[each].starting_at(at[each]) for each in free if each != name}
        try:
            if not others:
                left = self.residual({name: value})
                return float(left @ left) if np.isfinite(left).all() else np.inf
            return self.minimum(others, known=True, fixed={name: value}, converged=1e-6).sum_of_squares
        except InputError:
            return np.inf
