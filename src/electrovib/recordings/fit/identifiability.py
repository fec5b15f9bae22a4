"""What the data of a fit determine: each parameter well, weakly or only combined with others, and the error by rounding."""

from __future__ import annotations

import math
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Final

import numpy as np

from electrovib.core.signals import SIGNALS
from electrovib.core.units import format_quantity

if TYPE_CHECKING:
    from collections.abc import Mapping, Sequence

    from electrovib.core.arrays import Real
    from electrovib.recordings.fit.prediction import Residuals


WELL: Final = 0.1
"""Largest standard deviation of the logarithm of a parameter that counts as well determined. The bias that curvature gives an
estimate is of the order of this number times its standard deviation, and symmetric intervals hold up to there."""
NOT: Final = 1.0
"""Standard deviation of the logarithm from which on a parameter or a combination counts as not determined: a factor of e."""
_MEMBER: Final = 0.1
"""Smallest exponent, relative to the largest, with which a parameter counts as a member of a combination."""
_SLIGHT: Final = 0.01
"""The same where the data do not depend on the combination: nothing limits how far it moves each of its members."""
VANISHES: Final = 1e-6
"""Singular value over the largest one that cannot be told from the error of derivatives taken by differences."""

_INFLATED: Final = 10.0
"""Factor by which undetermined parameters increase the standard deviation of a zero that they leave undetermined."""
_TRADES: Final = 1.25
"""Factor by which a parameter on its bound, if it were free, would increase the standard deviation of one that trades with it."""


@dataclass(frozen=True, kw_only=True)
class UndeterminedCombination:
    """A product of powers of parameters that the data do not determine.

    The largest of the `exponents` is 1. `deviation` is the standard deviation of the logarithm of the
    product; infinite where the data do not depend on it.
    """

    exponents: Mapping[str, float]
    deviation: float

    @property
    def sentence(self) -> str:
        """Statement of what the data do not determine, and what they determine instead."""
        names = list(self.exponents)
        if len(names) == 1:
            return f"the data do not determine {names[0]}: {self._how}"
        product = " * ".join(_power(name, value) for name, value in self.exponents.items())
        words = f"the data do not determine {product}: {self._how}"
        if len(names) == 2:
            first, second = self.exponents.values()
            kept = {names[0]: abs(second), names[1]: -abs(first) * math.copysign(1, first * second)}
            largest = max(abs(value) for value in kept.values())
            kept = {name: value / largest for name, value in kept.items()}
            determined = " * ".join(_power(name, value) for name, value in kept.items())
            return f"{words}; of {names[0]} and {names[1]} they determine {determined} only"
        return f"{words}; fix one of {', '.join(names)} at a value known from elsewhere"

    @property
    def _how(self) -> str:
        if not math.isfinite(self.deviation) or self.deviation > 1e3:
            return "changing it at constant other combinations changes no prediction within the noise"
        return f"its logarithm has the standard deviation {self.deviation:.2g}, and {NOT:g} or more counts as not determined"


@dataclass(frozen=True, kw_only=True)
class Identifiability:
    """How well the data determine each parameter: ``"well"``, ``"weakly"`` or ``"not"``.

    `undetermined` begins with the worst combination. `covariance` is in the units of the parameters, with
    infinite variance and NaN covariances for those that are not determined.
    """

    states: Mapping[str, str]
    undetermined: tuple[UndeterminedCombination, ...]
    covariance: Real


def identifiability(
    derivatives: Real, values: Mapping[str, float], *, zeros: Sequence[str] = ()
) -> Identifiability:
    """Judge which parameters the data determine.

    `derivatives` (n, parameters) are those of the residuals over their standard deviation; `zeros` are
    parameters without a natural scale. With the derivatives J after the logarithms of the parameters, J = U S
    V', each column v of V is a combination sum(v_i ln p_i) with the standard deviation 1/s. A combination
    with 1/s above 1 is not determined. A parameter is not determined if it is a member of such a combination;
    else it is well determined if the standard deviation of its logarithm is at most 0.1, and weakly
    determined otherwise. A parameter estimated as 0 has no logarithm and is judged by the standard deviation
    alone. A zero is not determined where the parameters that are not determined make its standard deviation
    more than ten times larger than if they were known.
    """
    names = list(values)
    judged = [at for at, name in enumerate(names) if name not in zeros]
    other = [at for at in range(len(names)) if at not in judged]
    scale = np.array([abs(values[name]) or 1.0 for name in names])
    sloped = np.asarray(derivatives, dtype=float) * scale
    basis = np.linalg.qr(sloped[:, other])[0] if other else np.zeros((len(sloped), 0))
    own = sloped[:, judged] - basis @ (basis.T @ sloped[:, judged])
    _, singular, rows = np.linalg.svd(own, full_matrices=False)
    deviations = [
        math.inf if each <= VANISHES * singular[0] or each == 0 else 1 / float(each) for each in singular
    ]
    bad = [at for at, deviation in enumerate(deviations) if deviation > NOT]
    found = [_combination([names[j] for j in judged], rows[at], deviations[at]) for at in reversed(bad)]
    lost = {name for each in found for name in each.exponents}
    lost |= {names[at] for at in other if _is_lost(sloped, at, [names.index(name) for name in lost])}
    kept = [at for at in range(len(names)) if names[at] not in lost]
    covariance = np.full((len(names), len(names)), np.nan)
    if kept:
        moved = response(sloped)[kept] * scale[kept, None]
        covariance[np.ix_(kept, kept)] = moved @ moved.T
    for at, name in enumerate(names):
        if name in lost:
            covariance[at, at] = math.inf
    return Identifiability(
        states={
            name: "not"
            if name in lost
            else "well"
            if name in zeros or math.sqrt(covariance[at, at]) <= WELL * scale[at]
            else "weakly"
            for at, name in enumerate(names)
        },
        undetermined=tuple(found),
        covariance=covariance,
    )


def trades(derivatives: Real, at: int, bound: int) -> bool:
    """State whether a parameter would have a standard deviation more than a quarter larger if one on its bound were free."""
    norms = np.linalg.norm(derivatives, axis=0)
    return bool(norms[bound]) and _is_lost(
        derivatives / np.where(norms, norms, 1.0), at, [bound], factor=_TRADES
    )


def _is_lost(sloped: Real, at: int, lost: Sequence[int], *, factor: float = _INFLATED) -> bool:
    """Return whether some parameters would increase the standard deviation of another by more than a factor."""
    own, others = sloped[:, at], [each for each in range(sloped.shape[1]) if each != at]
    known = [each for each in others if each not in lost]
    alone, beside = (
        np.linalg.norm(own - sloped[:, each] @ np.linalg.lstsq(sloped[:, each], own, rcond=VANISHES)[0])
        for each in (known, others)
    )
    return bool(beside * factor < alone)


def response(derivatives: Real) -> Real:
    """Return the change of estimates, shape (unknowns, n), by that of weighted data: (J'J)^-1 J', without what has no effect."""
    scale = np.linalg.norm(derivatives, axis=0)
    scale[scale == 0] = 1.0
    return np.asarray(np.linalg.pinv(derivatives / scale, rcond=VANISHES) / scale[:, None])


def _combination(names: Sequence[str], row: Real, deviation: float) -> UndeterminedCombination:
    largest = int(np.argmax(np.abs(row)))
    exponents = row / row[largest]
    least = _MEMBER if math.isfinite(deviation) else _SLIGHT
    return UndeterminedCombination(
        exponents={
            name: float(value) for name, value in zip(names, exponents, strict=True) if abs(value) >= least
        },
        deviation=deviation,
    )


def _power(name: str, exponent: float) -> str:
    rounded = round(exponent, 1) or float(f"{exponent:.1g}")
    return name if rounded == 1 else f"{name}^{rounded:g}"


STEPS: Final = 50
"""Successive accepted steps whose common gain is judged; searches that converge take fewer."""
GAIN: Final = 0.01
"""Decrease of the sum of squares over these steps, in variances of a residual, below which it is none: the estimate that the
search would reach is no more likely than the present one by a factor of exp(0.005)."""


@dataclass
class Stall:
    """Judgement, at each accepted step of a search, whether further steps can change the result.

    `variance` is that of the weighted residuals; None takes their scatter at the present step.
    """

    variance: float | None
    zeros: Sequence[str] = ()
    _squares: list[float] = field(default_factory=list, init=False)

    def is_reached(self, values: Mapping[str, float], residual: Real, derivatives: Real) -> bool:
        """Record an accepted step, and state whether the search has stalled there.

        It has where the last steps together have decreased the sum of squares by less than `GAIN` variances
        while a combination of the unknowns is not determined.
        """
        squares = float(residual @ residual)
        self._squares.append(squares)
        variance = squares / max(residual.size - len(values), 1) if self.variance is None else self.variance
        if len(self._squares) <= STEPS or not np.isfinite(derivatives).all():
            return False
        if not 0 <= self._squares[-1 - STEPS] - squares < GAIN * variance:
            return False
        return bool(identifiability(derivatives / np.sqrt(variance), values, zeros=self.zeros).undetermined)


_NEGLIGIBLE: Final = 1e-3
"""Amplitude of the mean rounding error, over the resolution, below which noise makes successive rounding errors independent."""
_PHASES: Final = 512
_GROUPS: Final = 16
_MATTERS: Final = 0.1
"""Standard deviation by correlated rounding errors over that by noise from which on an interval includes them."""


@dataclass(frozen=True, kw_only=True)
class RoundedSignal:
    """A signal of which successive samples have rounding errors that are alike, with the least noise before rounding."""

    signal: str
    recording: str
    resolution: float
    noise: float

    @property
    def sentence(self) -> str:
        """Statement of the resolution and of the noise."""
        unit = SIGNALS[self.signal].unit
        step = format_quantity(self.resolution, unit, digits=3)
        if not self.noise:
            return f"{self.signal} of {self.recording} is rounded to steps of {step}, and shows no noise beside the rounding"
        noise = format_quantity(self.noise, unit, digits=2)
        times = f"{self.resolution / self.noise:.2g} times its noise of {noise}"
        return f"{self.signal} of {self.recording} is rounded to steps of {step}, {times}"


@dataclass(frozen=True, kw_only=True)
class Rounding:
    """Errors of the estimates by correlated rounding errors, for all positions of the steps relative to the signals.

    `errors` maps an unknown on which rounding has an effect to its error in SI for equally probable positions
    of the steps, shape (positions,); `deviations` maps it to its standard deviation by errors that are
    independent from sample to sample.
    """

    signals: tuple[RoundedSignal, ...]
    errors: Mapping[str, Real]
    deviations: Mapping[str, float]

    def deviation(self, name: str) -> float:
        """Return the standard deviation of an unknown by both kinds of errors, in SI."""
        return math.hypot(self.deviations[name], float(np.sqrt(np.mean(self.errors[name] ** 2))))

    def half_width(self, name: str, *, level: float, quantile: float) -> float:
        """Compute half the width of the interval of an unknown, if all positions of the steps are equally probable."""
        from scipy.optimize import brentq
        from scipy.special import ndtr, ndtri

        errors = np.abs(self.errors[name])
        sigma = self.deviations[name] * quantile / float(ndtri(0.5 + level / 2))
        if not sigma > 1e-9 * np.max(errors):
            return float(np.quantile(errors, level))

        def excess(half: float) -> float:
            inside = ndtr((half - errors) / sigma) - ndtr((-half - errors) / sigma)
            return float(np.mean(inside)) - level

        return float(brentq(excess, 0.0, float(np.max(errors)) + 10 * quantile * sigma, xtol=1e-6 * sigma))

    def is_coarse(self, name: str, value: float) -> bool:
        """State whether rounding gives an unknown a standard deviation above a tenth of its estimate."""
        return name in self.errors and self.deviation(name) > WELL * abs(value) > 0

    def note(self, name: str) -> str:
        """Return how much of the variance of an unknown is that of correlated rounding errors; empty where it has no effect."""
        if name not in self.errors:
            return ""
        share = 1 - (self.deviations[name] / self.deviation(name)) ** 2
        signals = "; ".join(each.sentence for each in self.signals)
        return f"{share:.0%} of the variance is that of rounding errors, which do not average out: {signals}"

    @property
    def sentence(self) -> str:
        """Statement of the resolution of the recordings, and of what the intervals include."""
        signals = "; ".join(each.sentence for each in self.signals)
        affected = ", ".join(self.errors)
        return (
            f"{signals}; rounding errors of successive samples are alike and do not average out: the intervals of {affected}"
            " include them, for all positions of the steps relative to the signal"
        )


def rounding_of(
    residuals: Sequence[Residuals], derivatives: Real, weights: Real, names: Sequence[str]
) -> Rounding | None:
    """Compute the effect of correlated rounding errors on the estimates; None where none is affected.

    `derivatives` (n, unknowns) are those of the weighted residuals; of `weights` (n,) only the ratios count.
    The estimates err by H b with H = (J'WJ)^-1 J'W and the mean rounding error b of each datum, a function of
    its prediction with the period of one step: `rounding_amplitudes`. How the steps lie relative to the
    levels of the signal is not known to a fraction of one step, so that all positions are equally probable,
    independently for levels that differ by a step or more. The variance of the independent part is that of
    the residuals less that of b, as far as b is visible in the residuals: the share 1 less its coherence.
    """
    inverse = response(derivatives) * weights
    errors, variance = np.zeros((len(names), _PHASES)), np.zeros(len(names))
    signals: list[RoundedSignal] = []
    start = 0
    for each in residuals:
        observed, rounded, independent = each.observed, rounded_signal(each), 1.0
        own = inverse[:, start : start + observed.size]
        start += own.shape[1]
        if rounded is not None:
            amplitudes = rounding_amplitudes(rounded.noise, rounded.resolution)
            steps = np.asarray(each.predicted.real) / rounded.resolution
            group = _groups(steps)
            for number in np.unique(group):
                there = group == number
                rng = np.random.default_rng(len(signals) * _GROUPS + int(number))
                positions = rng.permutation(2 * np.pi * (np.arange(_PHASES) + 0.5) / _PHASES)
                errors += _errors(own[:, there], steps[there], amplitudes, positions)
            visible = (1 - coherence_of(steps)) * float(np.sum(amplitudes**2)) / 2
            independent = max(1 - visible / each.noise**2, 0.0)
            signals.append(rounded)
        deviation = each.noise * np.tile(observed.scale, observed.parts)
        variance += independent * np.sum((own * deviation) ** 2, axis=1)
    spread, deviations = np.sqrt(np.mean(errors**2, axis=1)), np.sqrt(variance)
    affected = [at for at in range(len(names)) if spread[at] > _MATTERS * deviations[at]]
    if not affected:
        return None
    return Rounding(
        signals=tuple(signals),
        errors={names[at]: errors[at] for at in affected},
        deviations={names[at]: float(deviations[at]) for at in affected},
    )


def rounded_signal(residuals: Residuals) -> RoundedSignal | None:
    """Return how a signal is rounded; None where its rounding errors are independent of each other, or it is not rounded."""
    observed = residuals.observed
    if not observed.resolution:
        return None
    noise = observed.noise_alone
    if noise is None:
        coherence = coherence_of(np.asarray(residuals.predicted.real) / observed.resolution)
        noise = observed.resolution * least_noise(residuals.noise / observed.resolution, coherence)
    if np.abs(rounding_amplitudes(noise, observed.resolution)[0]) < _NEGLIGIBLE * observed.resolution:
        return None
    return RoundedSignal(
        signal=observed.signal, recording=residuals.recording, resolution=observed.resolution, noise=noise
    )


def _groups(steps: Real) -> Real:
    """Number the samples whose predictions are within one step of each other, shape (n,), the first 16 steps alone.

    Between groups the rounding errors count as independent, because the estimates of the levels err by parts of a step
    themselves. The steps begin where the fewest predictions are, so that a level is in one group.
    """
    counts, edges = np.histogram(steps % 1.0, bins=_GROUPS, range=(0.0, 1.0))
    return np.asarray(np.floor(steps - edges[int(np.argmin(counts))] - 0.5 / _GROUPS) % _GROUPS)


def _errors(shifts: Real, steps: Real, amplitudes: Real, phases: Real) -> Real:
    """Return the errors, shape (unknowns, positions), by a mean rounding error at these places in steps."""
    turn = np.exp(2j * np.pi * steps)
    power, found = np.ones_like(turn), np.zeros((len(shifts), len(phases)))
    for order, amplitude in enumerate(amplitudes, start=1):
        if abs(amplitude) < _NEGLIGIBLE * abs(amplitudes[0]):
            break
        power = power * turn
        found += amplitude * np.imag(np.outer(shifts @ power, np.exp(1j * order * phases)))
    return found


_FEWEST: Final = 20
"""Fewest samples from which a resolution is found."""
_FIT: Final = 1e-3
"""Departure of the distances between recorded values from whole multiples of the resolution, over the resolution."""
_HARMONICS: Final = 64


def resolution_of(values: Real) -> float:
    """Return the smallest step between distinct values of a signal if all their distances are whole multiples of it, else 0.

    It is 0 too for fewer than 20 samples, or more than half as many distinct values as samples.
    """
    distinct = np.unique(values)
    if values.size < _FEWEST or not 1 < distinct.size <= values.size / 2:
        return 0.0
    precision = 16 * np.spacing(np.max(np.abs(distinct)))
    steps = np.diff(distinct)
    steps = steps[steps > precision]
    if not steps.size:
        return 0.0
    smallest = float(np.min(steps))
    # from the widest distance, because the smallest one has the largest relative error
    whole = np.round((distinct - distinct[0]) / smallest)
    finest = float((distinct[-1] - distinct[0]) / whole[-1])
    off = np.abs(distinct - distinct[0] - whole * finest)
    return finest if np.all(off <= _FIT * finest + precision) else 0.0


def rounding_amplitudes(noise: float, resolution: float) -> Real:
    """Compute the amplitudes of the mean rounding error as a function of the value that is rounded, harmonics 1 to k.

    (q/(pi k)) (-1)^k exp(-2 (pi k sigma/q)^2) with the resolution q and the noise sigma before rounding: the
    Fourier series of the sawtooth, averaged over the noise (Widrow and Kollar, Quantization Noise, 2008).
    From sigma = q/2 on it vanishes, and rounding adds an independent error of the variance q^2/12.
    """
    order = np.arange(1, _HARMONICS + 1)
    damped = np.exp(-2 * (np.pi * order * noise / resolution) ** 2)
    return np.asarray(resolution / np.pi * (-1.0) ** order / order * damped)


def least_noise(scatter: float, coherence: float) -> float:
    """Return the noise before rounding, over the step, that the scatter of residuals over the step implies at least.

    At all positions between two steps alike the variance of rounded values is that of the noise plus 1/12;
    halfway between two steps it is largest, and 1/4 without noise. The share `coherence` of the samples is
    assumed to be there.
    """
    from scipy.optimize import brentq

    def variance(noise: float) -> float:
        return (1 - coherence) * (noise**2 + 1 / 12) + coherence * _variance_halfway(noise)

    if variance(0.0) >= scatter**2:
        return 0.0
    return float(brentq(lambda noise: variance(noise) - scatter**2, 0.0, scatter))


def _variance_halfway(noise: float) -> float:
    """Return the variance of rounded values about halfway between two steps, over the square of the step [1]."""
    from scipy.special import ndtr

    if noise > 1:
        return noise**2 + 1 / 12
    if noise == 0:
        return 0.25
    edges = np.arange(12.0)
    return float(np.sum(2 * np.diff(ndtr(edges / noise)) * (edges[1:] - 0.5) ** 2))


def coherence_of(steps: Real) -> float:
    """Return how much the rounding errors of a signal are alike: from 0, spread over many steps evenly, to 1, constant.

    It is the mean of the cosine of 2 pi times the distance in steps, over all pairs of samples, or the share
    of pairs in the same half of a step if that is larger. `steps` is the prediction over the step between
    recorded values.
    """
    _, counts = np.unique(np.floor(2 * steps), return_counts=True)
    alike = float(np.abs(np.mean(np.exp(2j * np.pi * steps))) ** 2)
    return min(1.0, max(alike, float(np.sum((counts / steps.size) ** 2))))
