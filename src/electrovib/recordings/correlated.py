"""Standard errors of least squares with correlated residuals, as those of a recorded force are."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from electrovib.core.arrays import Real


def autocovariance(residual: Real, *, fitted: int = 0) -> Real:
    """Return the autocovariance of residuals at lags of 0 to n - 1 samples, by an autoregression of second order.

    `residual` is about 0 at even intervals, n >= 4; `fitted` parameters were fitted to these samples. The
    autoregression is found by Burg's recursion (Maximum entropy spectral analysis, Stanford 1975). Its second
    order can represent a relaxation or one oscillation, and it is nearly unbiased in short records: the mean
    of 128 samples of noise, independent or correlated over 2 samples, lies beyond two of its standard errors
    in 6 to 8 % of all records; correlated over 10 samples, in 16 %.
    """
    count = len(residual)
    forward = backward = residual
    filtered, power = np.ones(1), float(residual @ residual) / max(1, count - fitted)
    for _ in range(2):
        forward, backward = forward[1:], backward[:-1]
        both = float(forward @ forward + backward @ backward)
        reflected = -2 * float(forward @ backward) / both if both else 0.0
        longer = np.append(filtered, 0.0)
        filtered = longer + reflected * longer[::-1]
        forward, backward = forward + reflected * backward, backward + reflected * forward
        power *= 1 - reflected**2
    # the spectrum on a grid that is fine enough for correlations that last as long as the record
    spectrum = power / np.abs(np.fft.rfft(filtered, 16 * count)) ** 2 if power else np.zeros(8 * count + 1)
    return np.asarray(np.fft.irfft(spectrum)[:count])


def rough_noise(values: NDArray[Any]) -> float:
    """Return the standard deviation of noise from third differences, in which a smooth course cancels; 0 of 8 values or fewer."""
    if values.size <= 8:
        return 0.0
    parts = 2 if np.iscomplexobj(values) else 1
    return float(np.median(np.abs(np.diff(values, 3))) / 0.6745 / np.sqrt(20 * parts))


def averages(values: Real, count: int) -> Real:
    """Return the means of successive groups of samples; what is left at the end is omitted."""
    return np.asarray(values[: len(values) // count * count].reshape(-1, count).mean(axis=1))


def covariance(*, jacobian: Real, autocovariance: Real) -> Real:
    """Return the covariance of parameters fitted by least squares to samples with noise of known autocovariance.

    (J^T J)^-1 J^T R J (J^T J)^-1 with the `jacobian` J (n, p) and the covariance R of the noise, for a fit
    that was not weighted with R; infinite if the samples do not determine the parameters. `autocovariance` is
    0 beyond the lags that are given.
    """
    from scipy.linalg import matmul_toeplitz

    size = np.linalg.norm(jacobian, axis=0)
    count = jacobian.shape[1]
    if not np.all(size > 0) or np.linalg.cond(jacobian / size) > 1e10:
        return np.full((count, count), np.inf)
    inverse = np.linalg.pinv(jacobian / size) / size[:, None]
    samples = inverse.shape[1]
    lags = np.pad(autocovariance[:samples], (0, max(0, samples - len(autocovariance))))
    return np.asarray(inverse @ matmul_toeplitz(lags, inverse.T))


def line(*, time: Real, values: Real) -> tuple[float, float, float, float]:
    """Fit a straight line: mean, its standard error, slope, its standard error, with the correlation of the samples."""
    jacobian = np.column_stack([np.ones_like(time), time - time.mean()])
    mean, slope = (float(value) for value in np.linalg.lstsq(jacobian, values, rcond=None)[0])
    # about the mean, so that a drift counts as scatter of the mean
    of_mean = covariance(jacobian=jacobian[:, :1], autocovariance=autocovariance(values - mean, fitted=1))
    of_slope = covariance(
        jacobian=jacobian, autocovariance=autocovariance(values - jacobian @ [mean, slope], fitted=2)
    )
    return mean, float(np.sqrt(max(of_mean[0, 0], 0.0))), slope, float(np.sqrt(max(of_slope[1, 1], 0.0)))
