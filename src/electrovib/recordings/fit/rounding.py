"""Rounding of recordings: its steps, and the errors of estimates where successive samples are rounded alike."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import TYPE_CHECKING, Final

import numpy as np

from electrovib.core.signals import SIGNALS
from electrovib.core.units import format_quantity
from electrovib.recordings.fit.identifiability import WELL, response

if TYPE_CHECKING:
    from collections.abc import Mapping, Sequence

    from electrovib.core.arrays import Real
    from electrovib.recordings.fit.prediction import Residuals


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
