"""A number with its 95 % interval, rows of such numbers, how they are written, and standard errors with correlated residuals."""

from __future__ import annotations

import math
from dataclasses import dataclass, field, replace
from typing import TYPE_CHECKING, Any, Final

import numpy as np

from electrovib.core.answer import Table
from electrovib.core.units import KINDS, digits_of_interval, format_quantity
from electrovib.data.atomic import csv_text

if TYPE_CHECKING:
    from collections.abc import Callable, Mapping, Sequence

    from numpy.typing import NDArray

    from electrovib.core.arrays import Real


NORMAL: Final = 1.959963984540054
"""Standard deviations of a normal distribution that hold 95 % of it on both sides."""
MISFIT: Final = "misfit"
"""State of every parameter of a model that does not describe the recordings."""
UNCLEAR: Final = "unclear"
"""State of a parameter where correlated noise is not told from a model that does not describe the recordings."""
_UPPER: Final = 0.975
_FURTHEST: Final = 1e6
"""Factor between an estimate and a value, or distance in estimates, beyond which an interval counts as open."""
_ACCURACY: Final = 1e-3
"""Accuracy of the end of an interval, relative to its distance from the estimate."""


@dataclass(frozen=True, kw_only=True)
class Interval:
    """A number with its 95 % interval; what there is none of is NaN.

    - `method`: what the interval is from, or why there is none.
    - `scatter`: standard deviation between the `count` edges, impacts, ... of which the number is the mean.
    - `choices`: the number for every choice of what is not determined, such as the zero of a sensor.
    - `open_below`, `open_above`: the data exclude no value on that side, and the end is where the number itself ends.
    """

    value: float
    lower: float = math.nan
    upper: float = math.nan
    standard_error: float = math.nan
    scatter: float = math.nan
    count: int = 1
    method: str = ""
    choices: Mapping[str, float] = field(default_factory=dict)
    open_below: bool = False
    open_above: bool = False

    @property
    def ends(self) -> tuple[float, float]:
        """Both ends of the interval."""
        return self.lower, self.upper

    @property
    def choice_ends(self) -> tuple[float, float]:
        """Lowest and highest number over the choices."""
        return min(self.choices.values()), max(self.choices.values())

    def above(self, least: float) -> Interval:
        """Return it without what is below the least value that is possible."""
        if not self.lower < least:
            return self
        return replace(self, lower=least, method=f"{self.method}, cut at {least:g}")

    @property
    def is_bound(self) -> bool:
        """Whether it states a lower bound alone, as `more_than` makes it."""
        return math.isnan(self.value) and math.isfinite(self.lower)

    @property
    def digits(self) -> int:
        """Digits that show the interval."""
        return digits_of_interval(self.value, self.lower, self.upper)

    def texts(
        self, unit: str, *, digits: int | None = None, write: Callable[..., str] | None = None
    ) -> tuple[str, str]:
        """Write the number, and both ends of its interval or nothing."""
        if self.is_bound:
            return f"more than {(write or _shown)(self.lower, unit, digits=3)}", ""
        shown = self.digits if digits is None else digits
        value, *ends = (
            (write or _shown)(each, unit, digits=shown) for each in (self.value, self.lower, self.upper)
        )
        return value, "" if math.isnan(self.upper) else " to ".join(ends)

    def in_words(self, unit: str, *, why: str = "") -> str:
        """Write the number with its interval and the method, or why there is none."""
        value, ends = self.texts(unit)
        if not ends:
            return f"{value}{':' if self.is_bound else ', no interval:'} {why or self.method}"
        method = f" ({self.method})" if self.method else ""
        scatter = f", scatter {_shown(self.scatter, unit)}" if math.isfinite(self.scatter) else ""
        return f"{value}, 95 % interval {ends}{method}{scatter}"


def student(freedom: float) -> float:
    """Return half the width of a 95 % interval over the standard error, by Student's t."""
    from scipy.special import stdtrit

    return float(stdtrit(min(freedom, 1e9), _UPPER))


def from_noise(value: float, standard_error: float, *, freedom: float = math.inf) -> Interval:
    """Make the interval of a number of one edge by Student's t; without ends if the standard error is not finite."""
    if not math.isfinite(standard_error):
        return Interval(value=value, method="the samples do not determine it")
    half = student(freedom) * standard_error
    return Interval(
        value=value, lower=value - half, upper=value + half, standard_error=standard_error,
        method="noise of one edge",
    )  # fmt: skip


def more_than(value: float, why: str, *, count: int = 1) -> Interval:
    """Make a number of which a lower bound is known alone."""
    return Interval(value=math.nan, lower=value, upper=math.inf, method=why, count=count, open_above=True)


def mean_of(each: Sequence[Interval], *, of: str = "edge") -> Interval:
    """Compute the mean of a number over edges, by Student's t over the edges; one edge keeps its own interval."""
    if len(each) == 1:
        return each[0]
    values = np.array([one.value for one in each])
    mean, scatter = float(values.mean()), float(values.std(ddof=1))
    error = scatter / math.sqrt(len(each))
    half = student(len(each) - 1) * error
    return Interval(
        value=mean, lower=mean - half, upper=mean + half, standard_error=error, scatter=scatter, count=len(each),
        method=f"Student's t over {len(each)} {of}s",
    )  # fmt: skip


def profile_interval(
    rise: Callable[[float], float],
    best: float,
    *,
    deviation: float,
    bounds: tuple[float, float],
    allowed: float,
    logarithmic: bool = False,
) -> Interval:
    """Find where the smallest sum of squares at a fixed value of one parameter has risen by an allowed amount.

    `rise` maps a value to the rise above the minimum over the variance of the residuals, infinite where no
    prediction exists; `allowed` is the quantile of chi-squared, or of F, for one parameter. The search begins
    with `deviation`, not finite or 0 where none is known, and goes outwards by factors if `logarithmic`.
    """
    from scipy.optimize import brentq

    known = math.isfinite(deviation) and deviation > 0
    step = min(2 * deviation / abs(best), 1.0) if known and best else 0.1
    by_factor = logarithmic and best > 0

    def end(side: int, bound: float) -> tuple[float, bool]:
        """Go outwards until the profile is above the allowed rise, then divide the last step."""

        def moved(units: float) -> float:
            shifted = best + side * units * step * (abs(best) or 1)
            value = best * math.exp(side * step * units) if by_factor else shifted
            return max(value, bound) if side < 0 else min(value, bound)

        def height(units: float) -> float:
            value = moved(units)
            risen = 0.0 if value == best else max(rise(value), 0.0)
            return math.sqrt(risen) - math.sqrt(allowed)

        inner, outer = 0.0, 1.0
        while (reached := height(outer)) <= 0:
            if moved(outer) == bound or outer * step > (math.log(_FURTHEST) if by_factor else _FURTHEST):
                return bound, True
            inner, outer = outer, 1.6 * outer
        if not math.isfinite(reached):
            return moved(inner), True
        return moved(float(brentq(height, inner, outer, xtol=_ACCURACY * outer))), False

    (lower, open_below), (upper, open_above) = end(-1, bounds[0]), end(1, bounds[1])
    return Interval(
        value=best, lower=lower, upper=upper, method="profile", open_below=open_below, open_above=open_above
    )  # fmt: skip


@dataclass(frozen=True, kw_only=True)
class EstimatedParameter(Interval):
    """One parameter of a fit with its interval, in the SI unit `unit`; NaN where there is none, for the reason in `note`.

    - `name`: dotted path, with the session where the parameter varies between sessions.
    - `method`: ``"symmetric"``, ``"profile"``, ``"sessions"`` or ``"recordings"``; empty without an interval.
    - `state`: how the data determine it, as in `ScenarioFit.states`.
    - `systematic`: standard deviation by the calibration errors of the signals, in addition to that by noise.
    - `low`: lowest value that the parameter may have, below which no interval reaches.
    """

    name: str
    unit: str
    state: str = "well"
    note: str = ""
    systematic: float = math.nan
    low: float = -math.inf

    @property
    def systematic_ends(self) -> tuple[float, float]:
        """95 % interval by the calibration errors alone, in SI; NaN where none is stated."""
        half = NORMAL * self.systematic
        return max(self.value - half, self.low), self.value + half


@dataclass(frozen=True, kw_only=True)
class NumberRow:
    """One number of a measurement as a row of a table, in its SI unit, and why it may be wrong."""

    group: str
    name: str
    unit: str
    number: Interval
    note: str = ""


def with_ends(number: Interval, unit: str) -> str:
    """Write a number with its interval, or that it has none."""
    value, ends = number.texts(unit)
    return f"{value} ({ends})" if ends else f"{value}{' (no interval)' * (not number.is_bound)}"


_NOTHING: Final = {"", "none"}
"""What a column holds that no row fills."""


def numbers_table(title: str, rows: Sequence[NumberRow], *, first: str = "") -> Table:
    """Write rows as a table without the columns that none fills, `first` being the heading of the groups."""
    shown = []
    for row in rows:
        number = row.number
        value, ends = number.texts(row.unit)
        known = math.isfinite(number.value) or number.is_bound
        scatter = _shown(number.scatter, row.unit) if math.isfinite(number.scatter) else "none"
        cells = (value if known else "none", ends or "none", scatter, number.method, row.note)
        shown.append((row.group, row.name, *cells))
    headings = (first, "Quantity", "Value", "95 % interval", "Scatter", "Interval from", "Note")
    filled = [at for at in range(len(headings)) if not {row[at] for row in shown} <= _NOTHING]
    lines = [tuple(row[at] for at in filled) for row in (headings, *shown)]
    return Table(title, lines[0], tuple(lines[1:]))


def numbers_csv(rows: Sequence[NumberRow]) -> str:
    """Write rows as CSV, in SI units, with full precision."""
    names = ("value", "lower", "upper", "standard_error", "scatter", "count", "method")
    cells = [
        (row.group, row.name, row.unit, *(getattr(row.number, name) for name in names), row.note)
        for row in rows
    ]
    return csv_text(("group", "name", "unit", *names, "note"), cells)


def _shown(value: float, unit: str, *, digits: int = 4) -> str:
    return format_quantity(value, unit, digits=digits) if unit in KINDS else f"{value:.{digits}g} {unit}"


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


_STUCK: Final = 20
"""Equal readings in a row that noise does not give."""


def stuck(reading: Real) -> NDArray[np.bool_]:
    """Find the samples of 20 or more equal readings in a row; none in a signal without noise, as a computed one."""
    same, change = np.diff(reading) == 0, np.abs(np.diff(reading))
    noisy = (
        np.median(np.abs(np.diff(reading, 2))[~same[1:]]) > np.median(change[~same]) / 2
        if not same.all()
        else False
    )
    if not noisy or np.mean(same) > 0.5:
        return np.zeros(reading.size, bool)
    ends = np.flatnonzero(np.diff(np.concatenate([[False], same, [False]])))
    found = np.zeros(reading.size, bool)
    for first, last in zip(ends[::2], ends[1::2], strict=True):
        found[first : last + 1] = last - first + 1 >= _STUCK
    return found


def averages(values: Real, count: int) -> Real:
    """Return the means of successive groups of samples; what is left at the end is omitted."""
    return np.asarray(values[: len(values) // count * count].reshape(-1, count).mean(axis=1))


def covariance(*, jacobian: Real, autocovariance: Real) -> Real:
    """Return the covariance of parameters fitted by least squares to samples with noise of known autocovariance.

    (J^T J)^-1 J^T R J (J^T J)^-1 with the `jacobian` J (n, p) and the covariance R of the noise, for a fit
    that was not weighted with R; infinite if the samples do not determine the parameters. `autocovariance` is
    0 beyond the lags that are given.
    """
    size = np.linalg.norm(jacobian, axis=0)
    count = jacobian.shape[1]
    if not np.all(size > 0) or np.linalg.cond(jacobian / size) > 1e10:
        return np.full((count, count), np.inf)
    inverse = np.linalg.pinv(jacobian / size) / size[:, None]
    return through(inverse, autocovariance)


def through(weights: Real, autocovariance: Real) -> Real:
    """Return the covariance of weighted sums of samples, `weights` (sums, n), with noise of an autocovariance."""
    from scipy.linalg import matmul_toeplitz

    samples = weights.shape[-1]
    lags = np.pad(autocovariance[:samples], (0, max(0, samples - len(autocovariance))))
    return np.asarray(weights @ matmul_toeplitz(lags, weights.T))


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
