"""The fit of a function of given data, whatever the function is."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any, Final

import numpy as np

from electrovib.core.errors import InputError
from electrovib.recordings.fit.least_squares import CONVERGED, FreeParameter, least_squares

if TYPE_CHECKING:
    from collections.abc import Callable, Mapping

    from numpy.typing import ArrayLike, NDArray

    from electrovib.core.arrays import Real
    from electrovib.recordings.fit.least_squares import LeastSquaresEstimate

IMAGINARY_STEP: Final = 1e-30
"""Relative imaginary step of a derivative: no difference is taken, so that it may be as small as that."""
_REAL_STEP: Final = 1e-3
"""Relative step of a difference of sixth order, where truncation and rounding are both near 1e-13."""


def fit_function(
    function: Callable[..., ArrayLike],
    x: ArrayLike,
    y: ArrayLike,
    *,
    start: Mapping[str, float | FreeParameter],
    noise: ArrayLike | None = None,
    derivatives: Callable[..., ArrayLike] | None = None,
    converged: float = CONVERGED,
) -> LeastSquaresEstimate:
    """Fit the parameters of a function to data by least squares.

    `function(x, **parameters)` is real or complex, shape (n,); `start` holds initial values, or values with
    bounds; `noise` is the standard deviation of the data, of each part where they are complex, without which
    the scatter of the residuals is taken. Without `derivatives`, shape (n, parameters), those by an imaginary
    step h are taken, df/dp = Im f(p + i h)/h, which lose no digit (Squire and Trapp 1998), if the function is
    real, analytic and written with numpy; else differences.
    """
    points, data = np.asarray(x, dtype=float), np.asarray(y)
    deviation = np.broadcast_to(1.0 if noise is None else np.asarray(noise, dtype=float), data.shape)
    _refuse_bad_data(data, deviation)
    free = {
        name: each if isinstance(each, FreeParameter) else FreeParameter(start=float(each))
        for name, each in start.items()
    }
    if not free:
        raise InputError("start: expected at least one parameter")
    first = np.asarray(function(points, **{name: each.start for name, each in free.items()}))
    if first.shape != data.shape:
        raise InputError(f"the function gives shape {first.shape} for data of shape {data.shape}")
    stacked = _stacked if np.iscomplexobj(data) else np.real

    def residual(values: Mapping[str, float]) -> Real:
        return np.asarray(stacked((np.asarray(function(points, **values)) - data) / deviation), dtype=float)

    slopes = _derivatives_of(function, points, free, given=derivatives)

    def sloped(values: Mapping[str, float]) -> Real:
        columns = slopes(values) / deviation[:, None]
        return np.column_stack([stacked(column) for column in columns.T])

    return least_squares(
        residual, free, derivatives=sloped, noise_is_known=noise is not None, converged=converged
    )


def _refuse_bad_data(data: NDArray[Any], deviation: Real) -> None:
    if data.ndim != 1 or not np.isfinite(data).all():
        raise InputError("y: expected one row of finite numbers")
    if not (np.isfinite(deviation).all() and (deviation > 0).all()):
        raise InputError("noise: expected standard deviations above 0")


def _stacked(values: NDArray[Any]) -> Real:
    return np.concatenate([np.real(values), np.imag(values)])


def _derivatives_of(
    function: Callable[..., ArrayLike],
    points: Real,
    free: Mapping[str, FreeParameter],
    *,
    given: Callable[..., ArrayLike] | None,
) -> Callable[[Mapping[str, float]], NDArray[Any]]:
    """Choose how the derivatives of the function are found: as given, by an imaginary step, or by differences."""
    if given is not None:
        return lambda values: np.asarray(given(points, **values))
    if _takes_imaginary_steps(function, points, free):
        return lambda values: _by_imaginary_step(function, points, values)
    return lambda values: _by_differences(function, points, values, free)


def _takes_imaginary_steps(
    function: Callable[..., ArrayLike], points: Real, free: Mapping[str, FreeParameter]
) -> bool:
    """Tell whether the function is real, takes complex parameters, and has the slopes that differences give."""
    start = {name: each.start for name, each in free.items()}
    if np.iscomplexobj(function(points, **start)):
        return False
    try:
        with np.errstate(all="ignore"):
            exact = _by_imaginary_step(function, points, start)
    except (TypeError, ValueError, ArithmeticError):
        return False
    with np.errstate(all="ignore"):
        rough = _by_differences(function, points, start, free)
        scale = np.abs(rough).max(axis=0)
        return bool(np.isfinite(exact).all() and (np.abs(exact - rough).max(axis=0) <= 1e-4 * scale).all())


def _by_imaginary_step(
    function: Callable[..., ArrayLike], points: Real, values: Mapping[str, float]
) -> NDArray[Any]:
    columns = []
    for name, value in values.items():
        step = IMAGINARY_STEP * (abs(value) or 1.0)
        moved: Any = dict(values) | {name: complex(value, step)}
        columns.append(np.imag(np.asarray(function(points, **moved))) / step)
    return np.column_stack(columns)


def _by_differences(
    function: Callable[..., ArrayLike],
    points: Real,
    values: Mapping[str, float],
    free: Mapping[str, FreeParameter],
) -> NDArray[Any]:
    """Central differences of sixth order, one-sided of first order where a bound is nearer than the step."""
    columns = []
    for name, value in values.items():
        step = _REAL_STEP * (abs(value) or 1.0)

        def at(shift: float, name: str = name, value: float = value) -> NDArray[Any]:
            return np.asarray(function(points, **(dict(values) | {name: value + shift})))

        low, high = free[name].lower, free[name].upper
        if low < value - 3 * step and value + 3 * step < high:
            pairs = [(at(k * step) - at(-k * step)) / (2 * k * step) for k in (1, 2, 3)]
            columns.append(1.5 * pairs[0] - 0.6 * pairs[1] + 0.1 * pairs[2])
        else:
            small = 1e-5 * step if value + 1e-5 * step < high else -1e-5 * step
            columns.append((at(small) - at(0.0)) / small)
    return np.column_stack(columns)
