"""The minimum of a sum of squares over bounded parameters, by lmfit's Levenberg-Marquardt method."""

from __future__ import annotations

import dataclasses
import math
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, Final

import numpy as np

from electrovib.core.errors import InputError
from electrovib.recordings.fit.estimate import LeastSquaresEstimate, estimate_at
from electrovib.recordings.fit.stalled import Stall, StalledError

if TYPE_CHECKING:
    from collections.abc import Callable, Mapping

    from electrovib.core.arrays import Real

CONVERGED: Final = 1e-15
"""Relative change of the sum of squares and of the parameters at which the search ends: the precision of a double."""
FAR_AWAY: Final = 1e100
"""Replaces a residual that is not finite, so that the step that led there is rejected and shortened."""
MOST_EVALUATIONS: Final = 20_000
"""After which a search ends without having converged."""
_SMALL_STEP: Final = 1e-8  # a longer step of a rough search may be one along a narrow valley
_AT_BOUND: Final = 1e-9  # relative to the bound or the initial value


@dataclass(frozen=True, kw_only=True)
class FreeParameter:
    """One parameter of a fit, with its bounds; a `logarithmic` search suits one that may change by decades."""

    start: float
    lower: float = -math.inf
    upper: float = math.inf
    logarithmic: bool = False

    def __post_init__(self) -> None:
        if not math.isfinite(self.start) or not self.lower <= self.start <= self.upper:
            raise InputError(
                f"start = {self.start:g}: expected a number from {self.lower:g} to {self.upper:g}"
            )
        if self.logarithmic and self.start <= 0:
            raise InputError(f"start = {self.start:g}: expected a positive number for a logarithmic search")

    def starting_at(self, value: float) -> FreeParameter:
        """Return the same parameter with another initial value, in its unit [1], moved between the bounds if need be."""
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
    judged: bool = True,
    stall: Stall | None = None,
) -> LeastSquaresEstimate:
    """Minimise the sum of squares of a weighted residual.

    `residual` takes values by name and gives shape (n,), in units of the standard deviation if
    `noise_is_known`; `derivatives` gives (n, parameters), and `final_derivatives` those for the covariance,
    which is computed if `judged`. The search ends at the relative change `converged` of the sum of squares
    and of the parameters, after `most_evaluations`, or by `stall`. Fewer residuals than parameters, and
    residuals that are not finite at the start, are refused.
    """
    begin = {name: each.start for name, each in free.items()}
    first = np.asarray(residual(begin), dtype=float)
    if first.size < len(free):
        raise InputError(f"{first.size} data for {len(free)} free parameters: give at least as many")
    if not np.isfinite(first).all():
        raise InputError("the model is not finite at the starting values: begin elsewhere")
    search = _Search(residual, derivatives, free, stall)
    try:
        found = search.minimum(converged, most_evaluations)
        values, evaluations, ended = search.values(found.params), int(found.nfev), bool(found.success)
    except StalledError as stalled:
        values, evaluations, ended = stalled.values, search.evaluations, False
    left = np.asarray(residual(values), dtype=float)
    if not judged:
        return LeastSquaresEstimate(
            values=values,
            covariance=None,
            why_no_covariance="it was not asked for",
            sum_of_squares=float(left @ left),
            count=left.size,
            noise_is_known=noise_is_known,
            on_bound={},
            evaluations=evaluations,
            converged=ended,
            stalled=search.stalled,
        )
    return estimate_at(
        values,
        residual=left,
        derivatives=np.asarray((final_derivatives or derivatives)(values), dtype=float),
        noise_is_known=noise_is_known,
        on_bound={name: bound for name in free if (bound := free[name].bound_at(values[name]))},
        evaluations=evaluations,
        converged=ended,
        stalled=search.stalled,
    )


@dataclass
class _Search:
    """The problem in the coordinates of the search, as lmfit asks for it."""

    residual: Callable[[Mapping[str, float]], Real]
    derivatives: Callable[[Mapping[str, float]], Real]
    free: Mapping[str, FreeParameter]
    stall: Stall | None = None
    evaluations: int = 0
    stalled: bool = False
    _last: tuple[Mapping[str, float], Real] | None = None

    def values(self, parameters: Any) -> dict[str, float]:
        """Values at lmfit's parameters, in their units."""
        return {
            name: each.value(parameters[f"p{at}"].value) for at, (name, each) in enumerate(self.free.items())
        }

    def evaluated(self, parameters: Any) -> Real:
        """Residuals there, shape (n,)."""
        self.evaluations += 1
        values = self.values(parameters)
        with np.errstate(all="ignore"):
            found = np.asarray(self.residual(values), dtype=float)
        self._last = (values, found)
        return np.where(np.isfinite(found), found, FAR_AWAY)

    def sloped(self, parameters: Any) -> Real:
        """Derivatives of the residuals after the coordinates at an accepted step, shape (n, parameters)."""
        values = self.values(parameters)
        with np.errstate(all="ignore"):
            found = np.array(self.derivatives(values), dtype=float)
            if self.stall is not None and self._last is not None and self._last[0] == values:
                self.stalled = self.stall.is_reached(values, self._last[1], found)
                if self.stalled:
                    raise StalledError(values)
        for at, (name, each) in enumerate(self.free.items()):
            if each.logarithmic:
                found[:, at] *= values[name]
        return np.where(np.isfinite(found), found, 0.0)

    def minimum(self, converged: float, most_evaluations: int) -> Any:
        """Search from the starting values, and give lmfit's result."""
        lmfit = require_lmfit()
        searched = lmfit.Parameters()
        for at, each in enumerate(self.free.values()):
            start, low, high = (each.coordinate(value) for value in (each.start, each.lower, each.upper))
            searched.add(f"p{at}", value=start, min=low, max=high)
        search = lmfit.Minimizer(self.evaluated, searched, max_nfev=most_evaluations, calc_covar=False)
        ends = {"xtol": min(converged, _SMALL_STEP), "ftol": converged}
        bounded = any(
            math.isfinite(bound) for each in self.free.values() for bound in (each.lower, each.upper)
        )
        with np.errstate(all="ignore"):
            if bounded:  # by a trust region: lmfit's transformation of bounds loses half of the digits
                return search.minimize(
                    method="least_squares", jac=self.sloped, gtol=None, x_scale="jac", **ends
                )
            return search.minimize(method="leastsq", Dfun=self.sloped, gtol=0.0, **ends)


def require_lmfit() -> Any:
    """Return the module lmfit, or raise an InputError with the line that installs it."""
    try:
        import lmfit
    except ImportError:
        raise InputError("a fit needs lmfit: pip install 'electrovib[fit]'") from None
    return lmfit
