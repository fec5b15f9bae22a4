"""The minimum of a sum of squares over bounded parameters, by lmfit's Levenberg-Marquardt method."""

from __future__ import annotations

import dataclasses
import math
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, Final

import numpy as np

from electrovib.core.errors import InputError
from electrovib.recordings.fit.estimate import Estimate, estimate_at

if TYPE_CHECKING:
    from collections.abc import Callable, Mapping

    from electrovib.core.arrays import Real

CONVERGED: Final = 1e-15
"""Relative change of the sum of squares and of the parameters at which the search ends: the precision of a double."""
FAR_AWAY: Final = 1e100
"""Stands for a residual that is not finite: the step that led there is rejected and shortened."""
MOST_EVALUATIONS: Final = 20_000
"""After which a search ends without having converged."""
_AT_BOUND: Final = 1e-9
"""Share of the range, or of the bound, within which an estimate counts as lying on its bound."""


@dataclass(frozen=True, kw_only=True)
class FreeParameter:
    """One parameter of a fit, with where the search begins and where it may go.

    Parameters
    ----------
    start : float
        Initial value, in the parameter's unit, between the bounds.
    lower, upper : float
        Bounds, in the same unit; infinite by default.
    logarithmic : bool
        Whether the search uses the logarithm of the value, as a positive parameter that may change by decades needs.

    Raises
    ------
    InputError
        If the start is outside the bounds, or not positive where the search is logarithmic.
    """

    start: float
    lower: float = -math.inf
    upper: float = math.inf
    logarithmic: bool = False

    def __post_init__(self) -> None:
        """Check the start against the bounds."""
        if not math.isfinite(self.start) or not self.lower <= self.start <= self.upper:
            raise InputError(
                f"start = {self.start:g}: expected a number from {self.lower:g} to {self.upper:g}"
            )
        if self.logarithmic and self.start <= 0:
            raise InputError(f"start = {self.start:g}: expected a positive number for a logarithmic search")

    def starting_at(self, value: float) -> FreeParameter:
        """Give the same parameter with another initial value, in its unit [1], moved between the bounds if need be."""
        return dataclasses.replace(self, start=min(max(value, self.lower), self.upper))

    def coordinate(self, value: float) -> float:
        """Coordinate of the search at a value: its logarithm, or the value [1]."""
        if not self.logarithmic:
            return value
        return math.log(value) if value > 0 else -math.inf

    def value(self, coordinate: float) -> float:
        """Value at a coordinate of the search, in the parameter's unit [1]."""
        return math.exp(coordinate) if self.logarithmic else coordinate

    def bound_at(self, value: float) -> str:
        """Name the bound on which a value lies, in the parameter's unit [1]; empty between the bounds."""
        for name, bound in (("lower", self.lower), ("upper", self.upper)):
            if math.isfinite(bound) and abs(value - bound) <= _AT_BOUND * max(abs(bound), abs(self.start)):
                return name
        return ""


def least_squares(
    residual: Callable[[Mapping[str, float]], Real],
    free: Mapping[str, FreeParameter],
    *,
    derivatives: Callable[[Mapping[str, float]], Real],
    noise_is_known: bool,
    final_derivatives: Callable[[Mapping[str, float]], Real] | None = None,
    converged: float = CONVERGED,
    most_evaluations: int = MOST_EVALUATIONS,
) -> Estimate:
    """Minimise the sum of squares of a weighted residual.

    Parameters
    ----------
    residual : callable
        Values of the parameters by name, to the residuals over their standard deviation, shape (n,), dimensionless
        where the noise is known.
    free : mapping of str to FreeParameter
        At least one.
    derivatives : callable
        The same values to the derivatives of the residuals after the values, shape (n, parameters).
    noise_is_known : bool
        Whether the residuals are in units of their standard deviation; else the scatter of the residuals is taken for it.
    final_derivatives : callable, optional
        More accurate ones, for the covariance; by default `derivatives`.
    converged : float
        Relative change of the sum of squares and of the parameters at which the search ends.
    most_evaluations : int
        After which it ends without having converged.

    Returns
    -------
    Estimate
        With covariance, or with the reason why there is none.

    Raises
    ------
    InputError
        If there are fewer residuals than parameters, if they are not finite at the start, or if lmfit is not installed.
    """
    lmfit = _lmfit()
    names = tuple(free)
    begin = {name: each.start for name, each in free.items()}
    first = np.asarray(residual(begin), dtype=float)
    if first.size < len(names):
        raise InputError(f"{first.size} data for {len(names)} free parameters: give at least as many")
    if not np.isfinite(first).all():
        raise InputError("the model is not finite at the starting values: begin elsewhere")

    def values_of(parameters: Any) -> dict[str, float]:
        return {name: free[name].value(parameters[f"p{at}"].value) for at, name in enumerate(names)}

    def evaluated(parameters: Any) -> Real:
        with np.errstate(all="ignore"):
            found = np.asarray(residual(values_of(parameters)), dtype=float)
        return np.where(np.isfinite(found), found, FAR_AWAY)

    def sloped(parameters: Any) -> Real:
        values = values_of(parameters)
        with np.errstate(all="ignore"):
            found = np.array(derivatives(values), dtype=float)
        for at, name in enumerate(names):
            if free[name].logarithmic:
                found[:, at] *= values[name]
        return np.where(np.isfinite(found), found, 0.0)

    searched = lmfit.Parameters()
    for at, each in enumerate(free.values()):
        searched.add(
            f"p{at}",
            value=each.coordinate(each.start),
            min=each.coordinate(each.lower),
            max=each.coordinate(each.upper),
        )
    search = lmfit.Minimizer(evaluated, searched, max_nfev=most_evaluations, calc_covar=False)
    bounded = any(math.isfinite(bound) for each in free.values() for bound in (each.lower, each.upper))
    with np.errstate(all="ignore"):
        if bounded:  # by a trust region: lmfit's transformation of bounds loses half of the digits
            tolerances = {"xtol": converged, "ftol": converged, "gtol": None, "x_scale": "jac"}
            found = search.minimize(method="least_squares", jac=sloped, **tolerances)
        else:
            found = search.minimize(method="leastsq", Dfun=sloped, xtol=converged, ftol=converged, gtol=0.0)
    values = values_of(found.params)
    return estimate_at(
        values,
        residual=np.asarray(residual(values), dtype=float),
        derivatives=np.asarray((final_derivatives or derivatives)(values), dtype=float),
        noise_is_known=noise_is_known,
        on_bound={name: bound for name in names if (bound := free[name].bound_at(values[name]))},
        evaluations=int(found.nfev),
        converged=bool(found.success),
    )


def _lmfit() -> Any:
    try:
        import lmfit
    except ImportError:
        raise InputError("a fit needs lmfit: pip install 'electrovib[fit]'") from None
    return lmfit
