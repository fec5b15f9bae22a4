"""Whether a fit describes its data: the slow, periodic and brief components of residuals that noise does not explain."""

from __future__ import annotations

import functools
import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, Final

import numpy as np

from electrovib.core.paths import quantity_at
from electrovib.core.signals import SIGNALS
from electrovib.core.units import format_quantity
from electrovib.recordings.fit.identifiability import response, rounded_signal
from electrovib.recordings.fit.sessions import BetweenSessions, spread_of

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from electrovib.core.arrays import Real
    from electrovib.recordings.fit.prediction import Prediction, Residuals
    from electrovib.recordings.fit.problem import WeightedProblem

LEVEL: Final = 0.003
"""Probability that noise makes residuals of the right model count as a misfit, over all tests of a fit."""
_MOST: Final = 3
"""Reasons that are told."""
_VANISHES: Final = 1e-6


@dataclass(frozen=True, kw_only=True)
class Misfit:
    """What of the residuals of a fit noise does not explain.

    - `reasons`: why the model does not describe the recordings, the clearest first; empty where it does.
    - `inflation`: variances of the estimates over those by independent noise, 1 or more.
    - `independent`: number of independent residuals to which the slow components of all residuals correspond.
    - `computed`: whether all residuals are those of rounding, so that the data were computed by this model.
    - `between`: how parameters differ between recordings by more than noise explains.
    """

    reasons: tuple[str, ...]
    inflation: float
    independent: float
    computed: bool
    between: Mapping[str, BetweenSessions]
    recordings: int

    @property
    def verdict(self) -> str:
        """State that the model does not describe the recordings; empty where it does."""
        return f"the model does not describe {self._these}" if self.reasons else ""

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
        if self.inflation > 1:
            return (
                f"successive residuals are correlated and count as {self.independent:.2g} independent ones; the intervals include"
                " that"
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
    Noise, also where it is correlated over up to about a hundredth of the record, gives neighbouring
    components the same variance. Tested are the slowest 8 components against the following 24 (F), each
    component against the median of its neighbours, which a misfit under a repeating drive exceeds, the means
    of short spans, which one beside an edge exceeds, and where the noise is stated the sum of squares and
    that of the slow components (chi-squared, for a noise up to 5 % above the stated one). Several recordings
    are tested for parameters that differ between them by the sum of squares that parameters of their own
    would remove (F). The degrees of freedom are less those that the estimates take. Of a signal that is
    rounded more coarsely than its noise only what exceeds half a step counts.
    """
    slopes = problem.derivatives(values)
    pieces = np.split(_basis(slopes), np.cumsum([each.observed.size for each in residuals])[:-1])
    parts = [Components(of=each, sloped=rows) for each, rows in zip(residuals, pieces, strict=True)]
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
        computed=not real,
        between=between if any(each in signs for each in scatter) else {},
        recordings=len(problem.prediction.measured),
    )


def significant(tests: Sequence[Sign]) -> list[Sign]:
    """Return what noise does not explain, the clearest first: all tests together find something in noise at `LEVEL`."""
    total = sum(each.weight for each in tests)
    found = [each for each in tests if each.chance / each.weight * total < LEVEL]
    return sorted(found, key=lambda each: each.chance)


def _basis(columns: Real) -> Real:
    """Return an orthonormal basis of what some columns span, shape (n, rank)."""
    scale = np.linalg.norm(columns, axis=0)
    used = columns[:, scale > 0] / scale[scale > 0]
    if not used.size:
        return np.zeros((len(columns), 0))
    left, singular, _ = np.linalg.svd(used, full_matrices=False)
    return np.asarray(left[:, singular > _VANISHES * singular[0]])


def _between(
    problem: WeightedProblem, values: Mapping[str, float], slopes: Real, parts: Sequence[Components]
) -> tuple[dict[str, BetweenSessions], list[Sign]]:
    """Test whether parameters differ between recordings, by the values of each recording alone to first order."""
    from scipy.special import fdtrc

    prediction = problem.prediction
    left = np.concatenate([each.residual.ravel() for each in parts])
    ends = np.cumsum([sum(each.size for each in group) for group in prediction.columns])
    own = list(zip(np.split(slopes, ends[:-1]), np.split(left, ends[:-1]), strict=True))
    removed = [_basis(sloped) for sloped, _ in own]
    joint = _basis(slopes)
    more = sum(each.shape[1] for each in removed) - joint.shape[1]
    free = left.size - more - joint.shape[1]
    explained = sum(float(np.sum((each.T @ rest) ** 2)) for each, (_, rest) in zip(removed, own, strict=True))
    unexplained = float(left @ left) - explained
    if more < 1 or free < 3 or unexplained <= 0:
        return {}, []
    noise = unexplained / free * max(each.correlated for each in parts)
    if all(each.of.observed.noise is not None for each in parts):
        noise = max(noise, STATED)
    ratio = (explained - float(np.sum((joint.T @ left) ** 2))) / more / noise
    spreads = _spreads(prediction, values, [_step(*each) for each in own], noise)
    chance = float(fdtrc(more, free, ratio))
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
    lost = singular <= _VANISHES * max(singular[0], 1e-300)
    inverse = response(sloped)
    open_ones = np.isinf(scale) | (np.sum(rows[lost] ** 2, axis=0) > _VANISHES)
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


STATED: Final = 1.1
"""Ratio of variances by which noise may exceed the stated one: noise is stated to about 5 %."""
_CORRELATED: Final = 1e-3
"""Probability below which successive residuals count as correlated."""
_SLOW: Final = 8
"""Slowest components of residuals, in which a wrong model shows and correlated noise differs little from faster ones."""
_BESIDE: Final = 32
"""Components on each side of a periodic one with which it is compared."""
_SHORTEST: Final = 4
"""Samples of the shortest span in which a brief misfit is looked for: of fewer, one value far out would count."""
_FEWEST: Final = 15
"""Spans of one length from whose median the size of noise in a span is known."""
_BRIEF: Final = 0.1
"""Weight of the test of short spans: what it is for is far beyond noise, and the other tests keep their power."""
_NORMAL: Final = 0.6744898
"""Median of the magnitude of a normal variable over its standard deviation."""
_EFFICIENCY: Final = 0.37
"""Information on a standard deviation in a median of magnitudes, over that in a root mean square."""
_COMPUTED: Final = 1e-6
"""Residual over the largest value below which data were computed: no instrument is that accurate, every solver is."""
_STRETCHES: Final = 24
_MEDIAN: Final = {1: 0.454936, 2: 1.386294}
"""Median of chi-squared by degrees of freedom."""


@dataclass(frozen=True, kw_only=True)
class Sign:
    """What one test found, with the probability `chance` and the ratio of the variance to that by noise alone.

    `weight` is its share of the probability that a test of noise finds something, over that of other tests.
    """

    chance: float
    ratio: float
    subject: str
    reason: str
    weight: float = 1.0


@dataclass(frozen=True, kw_only=True)
class Components:
    """Residuals of one signal over their noise, by components of a discrete cosine transform.

    `sloped` (n, unknowns) is an orthonormal basis of what the unknowns change, over all data; only the rows
    of this signal.
    """

    of: Residuals
    sloped: Real

    @property
    def is_computed(self) -> bool:
        """Whether the residuals are those of rounding, so that the data were computed by this model."""
        return float(np.max(np.abs(self.of.values))) <= _COMPUTED * float(np.max(np.abs(self.of.observed.y)))

    @functools.cached_property
    def residual(self) -> Real:
        """Residuals over their noise, shape (parts, samples)."""
        return self._weighted(np.asarray(self.of.values))

    @functools.cached_property
    def excess(self) -> Real:
        """Residuals less what rounding that does not average out may add, half a step, over their noise, likewise."""
        if rounded_signal(self.of) is None:
            return self.residual
        values = np.asarray(self.of.values)
        left = np.maximum(np.abs(values) - self.of.observed.resolution / 2, 0.0)
        return self._weighted(np.sign(values) * left)

    def _weighted(self, values: NDArray[Any]) -> Real:
        rows = np.stack([values.real, values.imag][: self.of.observed.parts])
        return np.asarray(rows / (self.of.observed.scale * self.of.noise))

    @functools.cached_property
    def variance(self) -> float:
        """Variance of the residuals [1]: 1 of the noise, and that of rounding finer than a stated noise."""
        observed = self.of.observed
        fine = observed.noise_alone is not None and observed.resolution <= observed.noise_alone
        return 1 + (observed.resolution / self.of.noise) ** 2 / 12 if fine else 1.0

    @functools.cached_property
    def energy(self) -> Real:
        """Sum of squares of each component of the residuals, the slowest first, shape (samples,)."""
        return _energy(self.residual)

    @functools.cached_property
    def risen(self) -> Real:
        """Sum of squares of each component of `excess`, likewise."""
        return self.energy if self.excess is self.residual else _energy(self.excess)

    @functools.cached_property
    def freedom(self) -> Real:
        """Degrees of freedom of each component, shape (samples,)."""
        from scipy.fft import dct

        rows = self.sloped.reshape(self.of.observed.parts, -1, self.sloped.shape[1])
        return np.asarray(len(rows) - np.sum(dct(rows, norm="ortho", axis=1) ** 2, axis=(0, 2)))

    @property
    def slow(self) -> int:
        """Number of slow components."""
        return min(_SLOW, self.energy.size // 4)

    def _mean(self, energy: Real, low: int, high: int | None = None) -> tuple[float, float]:
        """Return the variance of the components from one to another [1], and their degrees of freedom."""
        freedom = float(np.sum(self.freedom[low:high]))
        return (float(np.sum(energy[low:high])) / freedom if freedom > 0 else 0.0), freedom

    @property
    def correlated(self) -> float:
        """Ratio by which slow components exceed the mean of all, 1 where that may be chance: of noise that is correlated."""
        from scipy.special import fdtrc

        end = 4 * self.slow
        (slow, taken), (fast, left) = self._mean(self.risen, 0, end), self._mean(self.energy, end)
        if min(taken, left) < 1 or not fast or fdtrc(taken, left, slow / fast) > _CORRELATED:
            return 1.0
        return max(1.0, slow / self._mean(self.energy, 0)[0])

    def signs(self) -> list[Sign]:
        """Test the sum of squares where the noise is stated, the slow components, the periodic and the brief ones."""
        tests = (self._of_sum, self._of_slow, self._of_periodic, self._of_brief)
        return [sign for test in tests if (sign := test()) is not None]

    def _sign(self, chance: float, ratio: float, why: str, *, weight: float = 1.0) -> Sign:
        observed, size = self.of.observed, self._size(self.of.root_mean_square)
        return Sign(
            chance=chance,
            ratio=ratio,
            subject=f"{observed.signal} of {self.of.recording}",
            reason=f"residuals of {size} rms {why}",
            weight=weight,
        )

    def _of_sum(self) -> Sign | None:
        from scipy.special import chdtrc

        mean, freedom = self._mean(self.risen, 0)
        if self.of.observed.noise is None or freedom < 1:
            return None
        ratio, counted = mean / self.variance, max(freedom / self.correlated, 1.0)
        why = f"where the noise is stated as {self._size(self.of.noise)}{self._where()}"
        return self._sign(float(chdtrc(counted, ratio / STATED * counted)), ratio, why)

    def _of_slow(self) -> Sign | None:
        from scipy.special import chdtrc, fdtrc

        slow, taken = self._mean(self.risen, 0, self.slow)
        beside, left = self._mean(self.energy, self.slow, 4 * self.slow)
        if taken < 1 or left < 3:
            return None
        above = slow / beside if beside else np.inf
        chance, noise = float(fdtrc(taken, left, above)), self._mean(self.energy, 0)[0]
        if self.of.observed.noise is not None:
            noise = self.variance
            chance = max(chance, float(chdtrc(taken, slow / noise / STATED * taken)))
        why = f"that are no noise: their slow part has {above:.2g} times the variance of noise{self._where()}"
        return self._sign(chance, slow / noise, why)

    def _of_periodic(self) -> Sign | None:
        from scipy.ndimage import median_filter
        from scipy.special import fdtrc

        parts, count = self.of.observed.parts, self.energy.size
        if count < 2 * _BESIDE:
            return None
        beside = median_filter(self.energy, size=2 * _BESIDE + 1, mode="reflect") / _MEDIAN[parts]
        three = np.convolve(self.risen, np.ones(3), mode="same") / 3 / np.maximum(beside, 1e-300)
        three[: self.slow] = 0.0
        at = int(np.argmax(three))
        chance = count * float(fdtrc(3 * parts, _BESIDE * parts, three[at]))
        return self._sign(chance, 1.0, f"that are no noise: they repeat{self._rate(at)}")

    def _of_brief(self) -> Sign | None:
        """Test the means of short spans of samples against the median of their magnitudes, as Student's t.

        A misfit beside an edge fills few samples, which neither the slow nor the periodic components show.
        The median is that of noise as it is, also where it is correlated, as long as most spans hold noise alone.
        """
        from scipy.special import stdtr

        found, length = [], _SHORTEST
        while self.residual.shape[1] // length >= _FEWEST:
            for first in (0, length // 2):
                means = np.abs(_means(self.residual, first, length))
                risen = np.abs(_means(self.excess, first, length)).max(axis=0)
                noise = float(np.median(means)) / _NORMAL or np.inf
                if self.of.observed.noise is not None:
                    noise = max(noise, (self.variance * STATED) ** 0.5)
                chance = float(stdtr(_EFFICIENCY * means.size, -risen.max() / noise))
                found.append((chance, first, length, risen, means.size))
            length *= 2
        if not found:
            return None
        chance, first, length, risen, _ = min(found, key=lambda each: each[0])
        begin, end = _around(risen)
        x = self.of.observed.x[first + begin * length : first + (end + 1) * length]
        return self._sign(
            min(2 * chance * sum(each[-1] for each in found), 1.0),
            float(risen.max()) ** 2 / max(self._mean(self.energy, 0)[0], 1e-300),
            f"that are no noise{self._span(x)}",
            weight=_BRIEF,
        )

    def _rate(self, order: int) -> str:
        """Return the frequency of a component where the samples are even in time."""
        observed = self.of.observed
        steps = np.diff(observed.x)
        if observed.axis != "time" or np.ptp(steps) > 1e-3 * np.mean(steps):
            return ""
        rate = order / (2 * float(np.mean(steps)) * observed.x.size)
        return f" at {format_quantity(rate, 'Hz', digits=3)}"

    def _where(self) -> str:
        """Return the part of the record in which the slow components of the residuals are largest."""
        from scipy.fft import dct, idct

        found = dct(self.residual, norm="ortho", axis=1)
        found[:, 4 * self.slow :] = 0.0
        smooth = np.sum(idct(found, norm="ortho", axis=1) ** 2, axis=0)
        stretches = np.array_split(np.arange(smooth.size), min(_STRETCHES, smooth.size))
        height = np.array([float(np.mean(smooth[each])) for each in stretches])
        first, last = _around(height)
        return self._span(self.of.observed.x[stretches[first][0] : stretches[last][-1] + 1])

    def _span(self, x: Real) -> str:
        """State the part of the record that has these values of the axis."""
        unit = SIGNALS[self.of.observed.axis].unit
        ends = (format_quantity(float(end), unit, digits=3) for end in x[[0, -1]])
        return ", largest from {} to {}".format(*ends)

    def _size(self, value: float) -> str:
        observed = self.of.observed
        if observed.relative:
            return f"{100 * value:.3g} %"
        return format_quantity(value, SIGNALS[observed.signal].unit, digits=3)


def _energy(rows: Real) -> Real:
    """Return the sum of squares of each component over the parts of a signal."""
    from scipy.fft import dct

    return np.asarray(np.sum(dct(rows, norm="ortho", axis=1) ** 2, axis=0))


def _means(rows: Real, first: int, length: int) -> Real:
    """Return the means of successive spans of samples over the standard deviation for noise of variance 1."""
    count = (rows.shape[1] - first) // length
    spans = rows[:, first : first + count * length].reshape(len(rows), count, length)
    return np.asarray(spans.sum(axis=2) / length**0.5)


def _around(height: Real) -> tuple[int, int]:
    """Return the first and last index around the largest height at which it is more than half of that."""
    first = last = int(np.argmax(height))
    while first > 0 and height[first - 1] > height.max() / 2:
        first -= 1
    while last + 1 < height.size and height[last + 1] > height.max() / 2:
        last += 1
    return first, last
