"""The minimum of a sum of squares over bounded parameters, by a trust region, and what the estimates are worth."""

from __future__ import annotations

import dataclasses
import importlib
import math
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any, Final

import numpy as np

from electrovib.core.errors import InputError
from electrovib.recordings.interval import Interval, from_noise

if TYPE_CHECKING:
    from collections.abc import Callable, Mapping

    from electrovib.core.arrays import Real
    from electrovib.recordings.fit.identifiability import Stall

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
        """Return the same parameter with another initial value, in its unit [1], moved between the bounds if need be.

        A logarithmic search that has ended at 0, by underflow, begins where this one began.
        """
        if self.logarithmic and value <= 0:
            return self
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
    converged: float = CONVERGED,
    most_evaluations: int = MOST_EVALUATIONS,
    judged: bool = True,
    stall: Stall | None = None,
) -> LeastSquaresEstimate:
    """Minimise the sum of squares of a weighted residual.

    `residual` takes values by name and gives shape (n,), in units of the standard deviation if
    `noise_is_known`; `derivatives` gives (n, parameters). The covariance is computed if `judged`. The search
    ends at the relative change `converged` of the sum of squares and of the parameters, after
    `most_evaluations`, or by `stall`. Fewer residuals than parameters, and residuals that are not finite at
    the start, are refused.
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
        values, evaluations, ended = search.values(found.x), int(found.nfev), bool(found.success)
    except StalledError as stalled:
        values, evaluations, ended = stalled.values, search.evaluations, False
    left = np.asarray(residual(values), dtype=float)
    estimate = LeastSquaresEstimate(
        values=values,
        sum_of_squares=float(left @ left),
        count=left.size,
        noise_is_known=noise_is_known,
        evaluations=evaluations,
        converged=ended,
        stalled=search.stalled,
    )
    return estimate.judged(left, np.asarray(derivatives(values), dtype=float), free) if judged else estimate


@dataclass
class _Search:
    """The problem in the coordinates of the search, shape (parameters,)."""

    residual: Callable[[Mapping[str, float]], Real]
    derivatives: Callable[[Mapping[str, float]], Real]
    free: Mapping[str, FreeParameter]
    stall: Stall | None = None
    evaluations: int = 0
    stalled: bool = False
    _last: tuple[Mapping[str, float], Real] | None = None

    def values(self, place: Real) -> dict[str, float]:
        """Values at a place, in their units."""
        return {
            name: each.value(at) for (name, each), at in zip(self.free.items(), place.tolist(), strict=True)
        }

    def evaluated(self, place: Real) -> Real:
        """Residuals there, shape (n,)."""
        self.evaluations += 1
        values = self.values(place)
        found = np.asarray(self.residual(values), dtype=float)
        self._last = (values, found)
        return np.where(np.isfinite(found), found, FAR_AWAY)

    def sloped(self, place: Real) -> Real:
        """Derivatives of the residuals after the coordinates at an accepted step, shape (n, parameters)."""
        values = self.values(place)
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
        """Search from the starting values by a trust region, and give the result of scipy."""
        from scipy.optimize import least_squares

        places = [
            [each.coordinate(value) for value in (each.start, each.lower, each.upper)]
            for each in self.free.values()
        ]
        start, low, high = np.transpose(places)
        with np.errstate(all="ignore"):
            return least_squares(
                self.evaluated, start, self.sloped, (low, high), x_scale="jac", gtol=None, ftol=converged,
                xtol=min(converged, _SMALL_STEP), max_nfev=most_evaluations,
            )  # fmt: skip


def required(package: str, what: str) -> Any:
    """Return a package of the extra ``fit``, or refuse what needs it."""
    try:
        return importlib.import_module(package)
    except ImportError:
        raise InputError(f"{what} needs {package}: pip install 'electrovib[fit]'") from None


LEAST_DETERMINED: Final = 1e-13
"""Smallest over largest singular value of the scaled derivatives that is above their rounding."""


def aicc(deviance: float, *, counted: int, data: int) -> float:
    """Compute Akaike's criterion with the correction for few data; infinite where `data` is at most `counted` + 1.

    `deviance` is minus twice the logarithm of the largest likelihood; `counted` parameters include the
    noises.
    """
    left = data - counted - 1
    return deviance + 2 * counted + 2 * counted * (counted + 1) / left if left > 0 else math.inf


def bic(deviance: float, *, counted: int, data: int) -> float:
    """Compute the criterion of Schwarz from the deviance, the number of estimated parameters and that of the data."""
    return deviance + counted * math.log(data)


@dataclass(frozen=True, kw_only=True)
class LeastSquaresEstimate:
    """Parameters at the least sum of squares.

    - `covariance`: in the order of `values`, in their units; None where the data do not determine them, with
      the reason in `why_no_covariance`.
    - `sum_of_squares`: dimensionless where the noise is known.
    - `noise_is_known`: whether the covariance follows from a stated noise; else from the scatter of the
      `count` residuals.
    - `on_bound`: parameters that ended on a bound, and on which.
    - `converged`: whether the search ended by itself; `stalled` whether it was ended because further steps
      along a combination that the data do not determine had no effect.
    """

    values: Mapping[str, float]
    covariance: Real | None = None
    why_no_covariance: str = "it was not asked for"
    sum_of_squares: float
    count: int
    noise_is_known: bool
    on_bound: Mapping[str, str] = field(default_factory=dict)
    evaluations: int
    converged: bool
    stalled: bool = False

    def judged(
        self, residual: Real, derivatives: Real, free: Mapping[str, FreeParameter]
    ) -> LeastSquaresEstimate:
        """Judge the parameters by residuals (n,) and their derivatives (n, parameters); those on a bound have variance 0."""
        names = tuple(self.values)
        on_bound = {name: on for name in free if (on := free[name].bound_at(self.values[name]))}
        inside = [at for at, name in enumerate(names) if name not in on_bound]
        found = dataclasses.replace(
            self, sum_of_squares=float(residual @ residual), count=residual.size, on_bound=on_bound
        )
        covariance, why = np.zeros((len(names), len(names))), ""
        if inside:
            inner, why = _inverse(derivatives[:, inside], tuple(names[at] for at in inside))
            if not why and found.degrees_of_freedom <= 0 and not self.noise_is_known:
                why = "as many parameters as data leave no scatter to judge by: state the noise"
            if not why:
                covariance[np.ix_(inside, inside)] = inner * (1.0 if self.noise_is_known else found.variance)
        return dataclasses.replace(found, covariance=None if why else covariance, why_no_covariance=why)

    @property
    def degrees_of_freedom(self) -> int:
        """Residuals less parameters."""
        return self.count - len(self.values)

    @property
    def variance(self) -> float:
        """Sum of squares over the degrees of freedom, the variance of a residual; NaN without any left."""
        return self.sum_of_squares / self.degrees_of_freedom if self.degrees_of_freedom > 0 else math.nan

    @property
    def variance_of_noise(self) -> float:
        """The variance that intervals count with: 1 if the noise is stated, that of rounding for exact data."""
        if self.noise_is_known or not self.variance <= 0:
            return 1.0 if self.noise_is_known else self.variance
        return math.ulp(1.0) ** 2

    @property
    def standard_deviations(self) -> dict[str, float]:
        """Of each parameter, in its unit; NaN where there is none."""
        count = len(self.values)
        found = np.full(count, np.nan) if self.covariance is None else np.sqrt(np.diag(self.covariance))
        return {name: float(each) for name, each in zip(self.values, found, strict=True)}

    @property
    def correlation(self) -> Real:
        """Correlation of the parameters, shape (parameters, parameters); NaN where there is none."""
        if self.covariance is None:
            return np.full((len(self.values), len(self.values)), np.nan)
        with np.errstate(all="ignore"):
            scale = np.sqrt(np.diag(self.covariance))
            found = self.covariance / np.outer(scale, scale)
        return np.where(np.isfinite(found), found, np.nan)

    @property
    def _deviance(self) -> float:
        """Minus twice the logarithm of the largest likelihood, up to a constant of the data."""
        if self.noise_is_known:
            return self.sum_of_squares
        return self.count * math.log(max(self.sum_of_squares / self.count, math.ulp(0.0)))

    @property
    def _counted(self) -> int:  # the noise among them where it is not known
        return len(self.values) + (not self.noise_is_known)

    @property
    def aicc(self) -> float:
        """Akaike's criterion with the correction for few data; infinite with as many parameters as data."""
        return aicc(self._deviance, counted=self._counted, data=self.count)

    @property
    def bic(self) -> float:
        """Criterion of Schwarz."""
        return bic(self._deviance, counted=self._counted, data=self.count)

    def parameter(self, name: str) -> Interval:
        """Interval of one parameter by the noise; none on a bound."""
        if name in self.on_bound:
            return Interval(value=math.nan, method=f"on its {self.on_bound[name]} bound")
        return self.derived(self.values[name], {name: 1.0})

    def derived(self, value: float, slopes: Mapping[str, float]) -> Interval:
        """Interval of a number that depends on parameters, to first order by its derivatives after them."""
        if self.covariance is None:
            return from_noise(value, math.nan)
        row = np.array([slopes.get(name, 0.0) for name in self.values])
        error = math.sqrt(max(float(row @ self.covariance @ row), 0.0))
        return from_noise(value, error, freedom=self.degrees_of_freedom)

    def quantile(self, level: float) -> float:
        """Return half the width of an interval of this probability [1] over the standard deviation, by Student's t."""
        from scipy.special import stdtrit

        freedom = 1e9 if self.noise_is_known else max(self.degrees_of_freedom, 1)
        return float(stdtrit(freedom, 0.5 + level / 2))

    def interval(self, name: str, *, level: float = 0.95) -> tuple[float, float]:
        """Interval of one parameter from its standard deviation and Student's t; NaN where there is no standard deviation."""
        half = self.quantile(level) * self.standard_deviations[name]
        return self.values[name] - half, self.values[name] + half


def _inverse(derivatives: Real, names: tuple[str, ...]) -> tuple[Real, str]:
    """Invert the normal matrix by singular values of the scaled derivatives; name the combination that is not determined."""
    scale = np.linalg.norm(derivatives, axis=0)
    if flat := [name for name, each in zip(names, scale, strict=True) if each == 0 or not np.isfinite(each)]:
        return derivatives[:0], f"the data do not depend on {', '.join(flat)}"
    _, singular, rows = np.linalg.svd(derivatives / scale, full_matrices=False)
    if singular[-1] < LEAST_DETERMINED * singular[0]:
        share = np.abs(rows[-1])
        part = [name for name, each in zip(names, share, strict=True) if each > 0.1 * share.max()]
        return derivatives[:0], f"the data determine only combinations of {' and '.join(part)}"
    unscaled = rows.T / singular / scale[:, None]
    return np.asarray(unscaled @ unscaled.T), ""


class StalledError(Exception):
    """Carries the values at which a search has stalled through the library that searches."""

    def __init__(self, values: Mapping[str, float]) -> None:
        super().__init__("the search has stalled")
        self.values = dict(values)
