"""Whether a fit describes its data: what noise does not explain, and how parameters differ between recordings or sessions."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Final

import numpy as np

from electrovib.core.paths import quantity_at
from electrovib.core.units import format_quantity
from electrovib.physics.stages import response as through_stages
from electrovib.recordings.fit.components import STATED, Components, Sign, orthonormal
from electrovib.recordings.fit.identifiability import VANISHES, response
from electrovib.recordings.fit.rounding import rounded_signal
from electrovib.recordings.interval import MISFIT, UNCLEAR, EstimatedParameter, Interval, from_noise

if TYPE_CHECKING:
    from electrovib.core.arrays import Real
    from electrovib.core.quantity import Quantity
    from electrovib.recordings.fit.least_squares import LeastSquaresEstimate
    from electrovib.recordings.fit.measured import Observed
    from electrovib.recordings.fit.prediction import Prediction, Residuals
    from electrovib.recordings.fit.problem import WeightedProblem

LEVEL: Final = 0.003
"""Probability that noise makes residuals of the right model count as a misfit, over all tests of a fit."""
_MOST: Final = 3
"""Reasons that are told."""


@dataclass(frozen=True, kw_only=True)
class Misfit:
    """What of the residuals of a fit noise does not explain.

    - `reasons`: why the model does not describe the recordings, the clearest first; empty where it does.
    - `inflation`: variances of the estimates over those by independent noise, 1 or more.
    - `independent`: number of independent residuals that would determine the estimates as well.
    - `is_unclear`: whether residuals are correlated beyond what a declared sensor explains, by noise with a
      memory or by a wrong model.
    - `computed`: whether all residuals are those of rounding, so that the data were computed by this model.
    - `between`: how parameters differ between recordings by more than noise explains.
    """

    reasons: tuple[str, ...]
    inflation: float
    independent: float
    is_unclear: bool
    computed: bool
    between: Mapping[str, BetweenSessions]
    recordings: int

    @property
    def state(self) -> str:
        """State of what the data determine."""
        return MISFIT if self.reasons else UNCLEAR if self.is_unclear else "well"

    @property
    def verdict(self) -> str:
        """State that the model does not describe the recordings; empty where it does."""
        return f"the model does not describe {self._these}" if self.reasons else ""

    @property
    def remark(self) -> str:
        """State why no estimate is shown to be well determined; empty where one may be."""
        doubt = "successive residuals are correlated, by noise with a memory or by a model that is wrong"
        return self.verdict or (doubt if self.is_unclear else "")

    @property
    def sentence(self) -> str:
        """State what the residuals show; empty where nothing is to be said."""
        if self.reasons:
            more = f"; and {len(self.reasons) - _MOST} more" if len(self.reasons) > _MOST else ""
            return f"{self.verdict}: {'; '.join(self.reasons[:_MOST])}{more}"
        if self.computed:
            return (
                "these data were computed by this model: what is left is rounding, and the intervals describe no"
                " measurement"
            )
        if self.is_unclear or self.inflation > 1:
            return (
                f"{self.remark or 'successive residuals are correlated'}; they count as {self.independent:.2g} independent ones,"
                " which the intervals include"
            )
        return ""

    @property
    def _these(self) -> str:
        return "these recordings" if self.recordings > 1 else "this recording"


def misfit_of(
    problem: WeightedProblem, values: Mapping[str, float], residuals: Sequence[Residuals]
) -> Misfit:
    """Test whether the residuals of a fit are noise; the right model has a reason against it in about 3 of 1000 fits.

    The residuals of each signal are decomposed by a discrete cosine transform in the order of its samples.
    Noise, also where it is correlated, does not follow the drive. Tested are what the powers, the delays and
    the rate of the prediction, or a drift, explain of the residuals of a signal (F, for noise of the spectrum
    of what is left), each component against the median of its neighbours, which a misfit under a repeating
    drive exceeds, the means of short spans, which one beside an edge exceeds, and where the noise is stated
    the sum of squares, also of what is explained (chi-squared, for a noise up to 5 % above the stated one). Several recordings
    are tested for parameters that differ between them by the sum of squares that parameters of their own
    would remove (F). The degrees of freedom are less those that the estimates take. Of a signal that is
    rounded more coarsely than its noise only what exceeds half a step counts.
    """
    slopes = problem.derivatives(values)
    pieces = np.split(orthonormal(slopes), np.cumsum([each.observed.size for each in residuals])[:-1])
    sensors = [
        _passed(problem.prediction, values, record, each)
        for record, _, each, _ in problem.prediction.pieces()
    ]
    parts = [
        Components(of=each, sloped=rows, sensor=sensor)
        for each, rows, sensor in zip(residuals, pieces, sensors, strict=True)
    ]
    real = [each for each in parts if not each.is_computed]
    between, scatter = _between(problem, values, slopes, parts) if real else ({}, [])
    tests = [sign for each in real for sign in each.signs()] + scatter
    signs = significant(tests)
    inflation = max([1.0, *(each.ratio for each in signs), *(each.correlated for each in real)])
    first = {each.subject: each for each in reversed(signs)}
    return Misfit(
        reasons=tuple(f"{each.subject}: {each.reason}" for each in signs if each is first[each.subject]),
        inflation=inflation,
        independent=sum(each.residual.size for each in real) / inflation if real else math.inf,
        is_unclear=any(each.spectrum.is_unexplained and rounded_signal(each.of) is None for each in real),
        computed=not real,
        between=between if any(each in signs for each in scatter) else {},
        recordings=len(problem.prediction.measured),
    )


def _passed(
    prediction: Prediction, values: Mapping[str, float], record: int, observed: Observed
) -> Real | None:
    """Return the power that the declared sensor of a signal passes, by components of its samples; None without one."""
    rig = prediction.prepared[record].scenario(prediction.point(record, values)).rig
    if rig is None or not observed.signal.endswith("_force_measured"):
        return None
    stages = rig.normal_stages() if observed.signal.startswith("normal") else rig.lateral_stages()
    rates = np.arange(observed.x.size) / (2 * max(np.ptp(observed.x), 1e-300))
    return np.asarray(np.abs(through_stages(stages, rates)) ** 2)


def significant(tests: Sequence[Sign]) -> list[Sign]:
    """Return what noise does not explain, the clearest first: all tests together find something in noise at `LEVEL`."""
    total = sum(each.weight for each in tests)
    found = [each for each in tests if each.chance / each.weight * total < LEVEL]
    return sorted(found, key=lambda each: each.chance)


def _between(
    problem: WeightedProblem, values: Mapping[str, float], slopes: Real, parts: Sequence[Components]
) -> tuple[dict[str, BetweenSessions], list[Sign]]:
    """Test whether parameters differ between recordings, by the values of each recording alone to first order."""
    from scipy.special import fdtrc

    prediction = problem.prediction
    left = np.concatenate([each.residual.ravel() for each in parts])
    ends = np.cumsum([sum(each.size for each in group) for group in prediction.columns])
    own = list(zip(np.split(slopes, ends[:-1]), np.split(left, ends[:-1]), strict=True))
    removed = [orthonormal(sloped) for sloped, _ in own]
    joint = orthonormal(slopes)
    more = sum(each.shape[1] for each in removed) - joint.shape[1]
    free = left.size - more - joint.shape[1]
    rest = np.concatenate(
        [each - basis @ (basis.T @ each) for basis, (_, each) in zip(removed, own, strict=True)]
    )
    unexplained = float(rest @ rest)
    explained = float(left @ left) - unexplained
    if more < 1 or free < 3 or unexplained <= 0:
        return {}, []
    least = STATED if all(each.of.observed.noise is not None for each in parts) else 0.0
    lefts = np.split(rest, np.cumsum([each.residual.size for each in parts])[:-1])
    larger = max(each.correlated_of(row) for each, row in zip(parts, lefts, strict=True))
    noise = unexplained / free
    gained = (explained - float(np.sum((joint.T @ left) ** 2))) / more
    ratio, noise = gained / max(noise, least), max(noise * larger, least)
    spreads = _spreads(prediction, values, [_step(*each) for each in own], noise)
    chance = float(fdtrc(more, free, gained / noise))
    why = "values of their own for each recording would remove more of the residuals than noise explains"
    if not spreads:
        return {}, [Sign(chance=chance, ratio=ratio, subject="free parameters", reason=why)]
    worst = max(spreads, key=lambda name: spreads[name].between / spreads[name].within)
    unit = quantity_at(prediction.prepared[0].base, worst).unit
    words = f"{spreads[worst].in_words(unit)}; let it vary between them"
    return spreads, [Sign(chance=chance, ratio=ratio, subject=worst, reason=words)]


def _step(sloped: Real, left: Real) -> tuple[Real, Real]:
    """Return by how much the unknowns of one recording alone differ, and their standard deviations for noise of variance 1."""
    scale = np.linalg.norm(sloped, axis=0)
    scale[scale == 0] = np.inf
    _, singular, rows = np.linalg.svd(sloped / scale, full_matrices=False)
    lost = singular <= VANISHES * max(singular[0], 1e-300)
    inverse = response(sloped)
    open_ones = np.isinf(scale) | (np.sum(rows[lost] ** 2, axis=0) > VANISHES)
    return inverse @ left, np.where(open_ones, np.inf, np.linalg.norm(inverse, axis=1))


def _spreads(
    prediction: Prediction, values: Mapping[str, float], steps: Sequence[tuple[Real, Real]], noise: float
) -> dict[str, BetweenSessions]:
    """Summarise how parameters that at least two recordings determine differ between them."""
    found = {}
    for at, unknown in enumerate(prediction.unknowns):
        value = values[unknown.name]
        own = {
            measured.name: (value + float(step[at]), float(deviation[at]) * math.sqrt(noise))
            for measured, (step, deviation) in zip(prediction.measured, steps, strict=True)
            if deviation[at] * math.sqrt(noise) < abs(value)
        }
        if len(own) > 1 and not unknown.is_offset and not unknown.session:
            found[unknown.path] = spread_of(own, group="recording")
    return found


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
