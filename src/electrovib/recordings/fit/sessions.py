"""Several fits: parameters between sessions, and between recordings that are fitted one by one."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Final

import numpy as np

from electrovib.core.units import format_quantity
from electrovib.recordings.interval import EstimatedParameter, Interval, from_noise

if TYPE_CHECKING:
    from collections.abc import Sequence

    from electrovib.core.arrays import Real
    from electrovib.core.quantity import Quantity
    from electrovib.recordings.fit.least_squares import LeastSquaresEstimate
    from electrovib.recordings.fit.result import ScenarioFit


@dataclass(frozen=True, kw_only=True)
class BetweenSessions:
    """One parameter over several sessions, or over recordings that were fitted separately, as `group` says.

    - `within`: standard deviation of the estimate of one session by its own noise, root mean square over the
      sessions.
    - `between`: standard deviation between sessions, beyond what the noise of each explains; 0 if that
      explains it. Its 95 % interval is NaN where the noise of fewer than two sessions is known.
    - `standard_error`: of the mean, from the scatter of the sessions.
    """

    values: Mapping[str, float]
    mean: float
    within: float
    between: float
    between_lower: float
    between_upper: float
    standard_error: float
    group: str = "session"

    def estimated(
        self, name: str, quantity: Quantity, remark: str = "", state: str = "well"
    ) -> EstimatedParameter:
        """Return the mean with its interval, by Student's t with one degree of freedom less than groups.

        `remark` says why it has another `state` than well determined.
        """
        mean = from_noise(self.mean, self.standard_error, freedom=len(self.values) - 1)
        return EstimatedParameter(
            name=name,
            unit=quantity.unit,
            value=self.mean,
            standard_error=self.standard_error,
            lower=max(mean.lower, quantity.low),
            upper=mean.upper,
            method=f"{self.group}s",
            state=state,
            note="; ".join(filter(None, [remark, self.in_words(quantity.unit)])),
            low=quantity.low,
        )

    def in_words(self, unit: str) -> str:
        """State both scatters with their unit, and which of them limits the mean."""
        ratio = self.between / self.within if self.within else math.inf
        within, between, lower, upper = (
            format_quantity(each, unit, digits=3)
            for each in (self.within, self.between, self.between_lower, self.between_upper)
        )
        one = self.group
        interval = f" (95 % interval {lower} to {upper})" if math.isfinite(self.between_upper) else ""
        narrow = f": {ratio:.2g} times as much, so that an interval from one {one} would be too narrow"
        words = f"scatter within a {one} {within}, between {one}s {between}{interval}"
        return words + (narrow if ratio > 1 else "")


def between_sessions(estimate: LeastSquaresEstimate, names: Mapping[str, str]) -> BetweenSessions:
    """Summarise the estimates of one parameter in several sessions.

    In the mean the sessions count alike: their scatter has the variance between them plus that within,
    whatever the sizes, so that Student's t holds for the mean when the sessions are alike in size.
    """
    deviations = estimate.standard_deviations
    return spread_of({session: (estimate.values[name], deviations[name]) for session, name in names.items()})


def spread_of(own: Mapping[str, tuple[float, float]], *, group: str = "session") -> BetweenSessions:
    """Summarise at least two estimates of one parameter with their deviations, with the spread of `random_effects`."""
    found, deviations = np.transpose(list(own.values()))
    scatter = float(np.var(found, ddof=1))
    within = float(np.sqrt(np.mean(np.square(deviations))))
    known = np.isfinite(deviations)
    spread = Interval(value=math.sqrt(scatter))
    if np.count_nonzero(known) > 1:
        spread = random_effects(found[known], deviations[known]).between
    return BetweenSessions(
        values=dict(zip(own, found.tolist(), strict=True)), mean=float(np.mean(found)), within=within, between=spread.value,
        between_lower=spread.lower, between_upper=spread.upper, standard_error=math.sqrt(scatter / found.size), group=group,
    )  # fmt: skip


_ENDS: Final = (0.025, 0.975)
"""Quantiles at both ends of an interval."""
_DRAWS: Final = 2000
_HALVINGS: Final = 45
_ROUNDING: Final = 1e-12
"""Smallest standard error of a group, relative to its value."""


@dataclass(frozen=True, kw_only=True)
class RandomEffects:
    """Values of several groups as a common mean, a deviation of each group, and the noise of each group.

    - `mean`: of the population of groups, weighted by the spread and the noise together.
    - `between`: standard deviation between groups beyond their noise, by the estimate of Paule and Mandel,
      with its 95 % interval, whose lower end is 0 where noise alone explains the differences.
    - `chi_squared`: sum of the squared deviations from the mean weighted by the noise alone, over the
      variances; its expectation without spread is the number of groups less 1.
    """

    mean: Interval
    between: Interval
    chi_squared: float


def random_effects(
    values: Sequence[float], deviations: Sequence[float], *, freedom: Sequence[float] | None = None
) -> RandomEffects:
    """Estimate the spread between groups, and their mean; without `freedom` the errors `deviations` are known.

    The spread fulfils Q(spread) = groups - 1 with Q = sum (value - mean)^2 / (spread^2 + error^2), Paule and
    Mandel, J. Res. NBS 87 (1982) 377. Q has the distribution of chi squared with groups - 1 degrees of
    freedom, so its quantiles give the interval (Q profile: Viechtbauer, Stat. Med. 26 (2007) 37). An error
    that is itself estimated from few points has a distribution too: the interval is that of the solutions
    over draws of all errors and of Q, and that of the mean over the same draws (generalized intervals: Iyer,
    Wang and Mathew, J. Am. Stat. Assoc. 99 (2004) 1060). The draws are stratified and always the same.
    """
    found, errors = np.asarray(values, dtype=float), np.asarray(deviations, dtype=float)
    variances = np.maximum(errors, _ROUNDING * float(np.abs(found).max()) or _ROUNDING)[None, :] ** 2
    squares, drawn = _draws(variances, freedom)
    spreads = _spread(found, drawn, squares)
    least, most = np.sqrt(np.quantile(spreads, _ENDS)).tolist()
    between = _spread(found, variances, np.array([found.size - 1.0]))
    (mean,), (error,) = _mean(found, variances + between[:, None])
    lower, upper = (_quantile(*_mean(found, drawn + spreads[:, None]), share) for share in _ENDS)
    return RandomEffects(
        mean=Interval(value=float(mean), lower=lower, upper=upper, standard_error=float(error)),
        between=Interval(value=math.sqrt(between[0]), lower=least, upper=most),
        chi_squared=float(_squares(found, variances)[0]),
    )


def _draws(variances: Real, freedom: Sequence[float] | None) -> tuple[Real, Real]:
    """Draw the sum of squares of the deviations, and the variance of each group by its own noise."""
    from scipy.special import gammaincinv

    groups, rng = variances.size, np.random.default_rng(0)
    even = (np.arange(_DRAWS) + 0.5) / _DRAWS
    squares = 2 * gammaincinv((groups - 1) / 2, rng.permutation(even))
    if freedom is None:
        return squares, np.repeat(variances, _DRAWS, axis=0)
    half = np.asarray(freedom, dtype=float) / 2
    shares = gammaincinv(half, np.column_stack([rng.permutation(even) for _ in range(groups)])) / half
    return squares, variances / shares


def _mean(values: Real, variances: Real) -> tuple[Real, Real]:
    """Weighted mean and its standard error, for each row of variances."""
    weights = 1 / variances
    total = weights.sum(axis=1)
    return (weights * values).sum(axis=1) / total, 1 / np.sqrt(total)


def _squares(values: Real, variances: Real) -> Real:
    """Sum of the weighted squares about the weighted mean, for each row of variances."""
    centre = _mean(values, variances)[0]
    return np.asarray(((values - centre[:, None]) ** 2 / variances).sum(axis=1))


def _spread(values: Real, variances: Real, wanted: Real) -> Real:
    """Variance between groups with which the sum of squares is the wanted one; 0 where it is smaller without any."""
    low = np.zeros(wanted.size)
    high = float(((values - values.mean()) ** 2).sum()) / wanted  # the sum of squares is smaller there
    for _ in range(_HALVINGS):
        middle = (low + high) / 2
        above = _squares(values, variances + middle[:, None]) > wanted
        low, high = np.where(above, middle, low), np.where(above, high, middle)
    return np.where(_squares(values, variances) > wanted, (low + high) / 2, 0.0)


def _quantile(means: Real, errors: Real, share: float) -> float:
    from scipy.optimize import brentq
    from scipy.special import ndtr

    def excess(at: float) -> float:
        return float(np.mean(ndtr((at - means) / errors))) - share

    reach = 10 * errors.max()
    return float(brentq(excess, means.min() - reach, means.max() + reach, xtol=_ROUNDING * reach))


FAILED = "failed"
"""Status of the parameters of a recording that could not be fitted."""


@dataclass(frozen=True, kw_only=True)
class RecordedFit:
    """The fit of one recording; None in `found`, and rows with the status ``"failed"``, if there is none."""

    record: str
    found: ScenarioFit | None
    rows: tuple[EstimatedParameter, ...]

    @property
    def reduced_chi_square(self) -> float:
        """Weighted sum of squares over the degrees of freedom, dimensionless; NaN unless the noise of all signals is stated."""
        if self.found is None or not self.found.estimate.noise_is_known:
            return math.nan
        return self.found.estimate.variance

    @property
    def problem(self) -> str:
        """Why there is no fit; empty where there is one."""
        return "" if self.found is not None or not self.rows else self.rows[0].note


def failed_rows(paths: Mapping[str, str], why: str) -> tuple[EstimatedParameter, ...]:
    """Make the rows of a recording that could not be fitted."""
    return tuple(
        EstimatedParameter(name=path, unit=unit, value=math.nan, state=FAILED, note=why)
        for path, unit in paths.items()
    )


def spreads_of(free: Sequence[str], fits: Sequence[RecordedFit]) -> dict[str, BetweenSessions]:
    """Summarise how parameters differ between the recordings that determine them, at least two, which count alike."""
    found = {}
    for path in free:
        own = {
            each.record: (row.value, row.standard_error)
            for each in fits
            for row in each.rows
            if row.name == path
            and each.found is not None
            and each.found.determined[path] in {"well", "weakly"}
            and math.isfinite(row.standard_error)
        }
        if len(own) > 1:
            found[path] = spread_of(own, group="recording")
    return found
