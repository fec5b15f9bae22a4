"""What noise does not explain of the residuals of one signal, by their components, of which white noise is one."""

from __future__ import annotations

import functools
from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, Final

import numpy as np

from electrovib.core.signals import SIGNALS
from electrovib.core.units import format_quantity
from electrovib.recordings.fit.identifiability import VANISHES
from electrovib.recordings.fit.rounding import rounded_signal
from electrovib.recordings.running_median import running_median

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from electrovib.core.arrays import Real
    from electrovib.recordings.fit.prediction import Residuals

_RATIOS: Final = np.append(0.0, np.geomspace(0.1, 1e5, 31))
"""Power of the correlated part over that of the white one, where it is largest, among which the likeliest is taken."""
_BANDS: Final = 160
"""Bands of components in which the spectrum is compared with the residuals."""
_WORTH: Final = 4.0
"""Twice the logarithm of the likelihood that two further parameters have to gain, by Akaike's criterion."""
_DOUBTED: Final = 13.8
"""Twice the logarithm of the likelihood by which a correlated part has to surpass noise without it: chi-squared with the two
degrees of freedom of power and knee exceeds it once in 1000."""


@dataclass(frozen=True, kw_only=True)
class NoiseSpectrum:
    """Power of noise by components of a cosine transform, shape (samples,).

    - `power`: variance of each component; `share`: that of the correlated part in it.
    - `is_correlated`: whether noise is not white; `is_unexplained`: nor as the declared sensor makes it.
    """

    power: Real
    share: Real
    is_correlated: bool
    is_unexplained: bool


def spectrum_of(energy: Real, freedom: Real, sensor: Real | None = None) -> NoiseSpectrum:
    """Find the spectrum of residuals from their sums of squares and degrees of freedom by component, the slowest first.

    It is a(1 + c/(1 + (k/knee)^2)), as of noise with a memory, or a(1 + c S) with the power S that a
    `sensor` passes, which is taken unless the former is likelier by far; the likelihood is Whittle's.
    """
    count = energy.size
    starts = np.unique(np.geomspace(1, count + 1, min(count, _BANDS) + 1).astype(int))[:-1] - 1
    widths = np.diff(starts, append=count)
    knees = 2.0 ** np.arange(1, max(np.log2(count), 2))
    shapes = [1 / (1 + (np.arange(count) / knee) ** 2) for knee in knees]
    if sensor is not None:
        shapes = [sensor / np.max(sensor), *shapes]
    free = np.maximum(np.add.reduceat(freedom, starts), 0.0)
    mean = np.array([np.add.reduceat(shape, starts) / widths for shape in shapes])
    rises = 1 + _RATIOS[:, None, None] * mean
    level = np.sum(np.add.reduceat(energy, starts) / rises, axis=2) / max(np.sum(free), 1e-9)
    level = np.maximum(level, 1e-100)
    deviance = np.sum(free * np.log(rises), axis=2) + np.sum(free) * np.log(level)
    best, white = float(np.min(deviance)), float(deviance[0, 0])
    declared = white if sensor is None else float(np.min(deviance[:, 0]))
    is_unexplained = declared - best > _DOUBTED
    among = deviance if sensor is None or is_unexplained else deviance[:, :1]
    ratio, shape = np.unravel_index(int(np.argmin(among)), among.shape)
    if white - among[ratio, shape] < _WORTH:
        ratio, shape = np.intp(0), np.intp(0)
    rise = _RATIOS[ratio] * shapes[shape]
    return NoiseSpectrum(
        power=level[ratio, shape] * (1 + rise),
        share=rise / (1 + rise),
        is_correlated=white - min(best, declared) > _DOUBTED,
        is_unexplained=is_unexplained,
    )


STATED: Final = 1.1
"""Ratio of variances by which noise may exceed the stated one: noise is stated to about 5 %."""
_SMOOTH: Final = 32
"""Slowest components, whose sum shows where in the record a misfit is."""
_FOLLOWED: Final = 16384
"""Slowest components, in which a part that follows the prediction or drifts is looked for."""
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
    of this signal. `sensor` (samples,) is the power that its declared sensor passes.
    """

    of: Residuals
    sloped: Real
    sensor: Real | None = None

    @property
    def is_computed(self) -> bool:
        """Whether the residuals are those of rounding, so that the data were computed by this model."""
        return float(np.max(np.abs(self.of.values))) <= _COMPUTED * float(np.max(np.abs(self.of.observed.y)))

    @functools.cached_property
    def residual(self) -> Real:
        """Residuals over their noise, shape (parts, samples)."""
        return self._weighted(self.left)

    @functools.cached_property
    def left(self) -> NDArray[Any]:
        """Residuals less what stated errors of gain and zero explain of them, each as likely as its uncertainty says."""
        observed, values = self.of.observed, np.asarray(self.of.values)
        if observed.calibration is None:
            return values
        gain, zero = (getattr(observed.calibration, name) for name in ("gain", "zero"))
        rows = np.column_stack([gain * np.asarray(self.of.predicted), np.full(values.size, zero)])
        seen = rows / (observed.scale * self.of.noise)[:, None]
        errors = np.linalg.solve(
            seen.T @ seen + np.eye(2), seen.T @ (values / (observed.scale * self.of.noise))
        )
        return np.asarray(values - rows @ errors)

    @functools.cached_property
    def excess(self) -> Real:
        """Residuals less what rounding that does not average out may add, half a step, over their noise, likewise."""
        if rounded_signal(self.of) is None:
            return self.residual
        values = self.left
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
        return np.asarray(np.sum(_turned(self.residual) ** 2, axis=0))

    @functools.cached_property
    def risen(self) -> Real:
        """Sum of squares of each component of `excess`, likewise."""
        return np.asarray(np.sum(_turned(self.excess) ** 2, axis=0))

    @functools.cached_property
    def slopes(self) -> Real:
        """Components of what the unknowns change, those of all parts below each other, shape (n, unknowns)."""
        rows = self.sloped.reshape(self.of.observed.parts, -1, self.sloped.shape[1])
        return _turned(rows).reshape(self.sloped.shape)

    @functools.cached_property
    def freedom(self) -> Real:
        """Degrees of freedom of each component, shape (samples,)."""
        return self._added(1 - np.sum(self.slopes**2, axis=1))

    def _added(self, row: Real) -> Real:
        return np.asarray(np.sum(row.reshape(self.of.observed.parts, -1), axis=0))

    @functools.cached_property
    def spectrum(self) -> NoiseSpectrum:
        """NoiseSpectrum of the residuals."""
        return spectrum_of(self.risen, self.freedom, self.sensor)

    @functools.cached_property
    def mean_square(self) -> float:
        """Sum of squares of the residuals over their degrees of freedom."""
        return float(np.sum(self.energy) / max(np.sum(self.freedom), 1.0))

    @functools.cached_property
    def correlated(self) -> float:
        """Largest ratio by which the variance of a combination of the estimates exceeds that by independent noise."""
        return self.correlated_by(self.spectrum)

    def correlated_of(self, left: Real) -> float:
        """Return this ratio for the spectrum of other residuals of this signal, over their noise, in the order of `residual`."""
        energy = np.sum(_turned(left.reshape(self.residual.shape)) ** 2, axis=0)
        return self.correlated_by(spectrum_of(energy, self.freedom, self.sensor))

    def correlated_by(self, found: NoiseSpectrum) -> float:
        """Return this ratio for a spectrum; rounding that does not average out has an interval of its own."""
        basis = orthonormal(self.slopes)
        if not found.is_correlated or not basis.size or rounded_signal(self.of) is not None:
            return 1.0
        power = np.tile(found.power / np.mean(found.power), self.of.observed.parts)
        return max(1.0, float(np.linalg.eigvalsh((basis.T * power) @ basis)[-1]))

    def signs(self) -> list[Sign]:
        """Test the sum of squares if the noise is stated, what follows the prediction, and slow, periodic and brief parts."""
        tests = (self._of_sum, self._of_response, self._of_drift, self._of_periodic, self._of_brief)
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

        freedom, power = float(np.sum(self.freedom)), self.spectrum.power
        if self.of.observed.noise is None or freedom < 1:
            return None
        ratio = float(np.sum(self.risen)) / freedom / self.variance
        counted = max(freedom * float(np.mean(power)) ** 2 / float(np.mean(power**2)), 1.0)
        why = f"where the noise is stated as {self._size(self.of.noise)}{self._where()}"
        return self._sign(float(chdtrc(counted, ratio / STATED * counted)), ratio, why)

    def _of_response(self) -> Sign | None:
        """Test what the course of the prediction explains, which noise does not resemble."""
        predicted = np.asarray(self.of.predicted, dtype=complex) + 1e-300  # the logarithm of 0 is not finite
        course = np.log(predicted) if self.of.observed.relative else predicted
        return self._explained(
            (course.real, course.imag),
            "part that follows the prediction, by its powers, its delays or its rate",
        )

    def _of_drift(self) -> Sign | None:
        """Test what a drift or a relaxation from the first sample on explains."""
        return self._explained((np.arange(float(self.energy.size)),) * 2, "slow part")

    def _explained(self, courses: Sequence[Real], what: str) -> Sign | None:
        """Test whether a course for each part explains more than noise with the spectrum of what it leaves."""
        from scipy.linalg import block_diag
        from scipy.special import chdtrc, fdtrc

        parts, size = self.of.observed.parts, min(self.energy.size, _FOLLOWED)
        if size < _SHORTEST:
            return None
        own = self.slopes.reshape(parts, -1, self.slopes.shape[1])[:, :size].reshape(parts * size, -1)
        risen, left = (_turned(each)[:, :size].ravel() for each in (self.excess, self.residual))
        columns = block_diag(*(_turned(_courses(each)[None])[0, :size] for each in courses[:parts]))
        both = orthonormal(np.column_stack([own, columns]))
        freedom = 1 - np.sum(both**2, axis=1)
        squares = _spanned(both, risen) - _spanned(orthonormal(own), risen)
        more, free = both.shape[1] - orthonormal(own).shape[1], left.size - both.shape[1]
        if more < 1 or free < 3:
            return None
        rest = self._added((left - both @ (both.T @ left)) ** 2)
        sensor = None if self.sensor is None else self.sensor[:size]
        noise = spectrum_of(rest, self._added(freedom), sensor)
        weights, share = np.tile(noise.power**-0.5, parts), np.tile(noise.share**2, parts)
        whole, part = (orthonormal(each * weights[:, None]) for each in (both, own))
        above = _spanned(whole, risen * weights) - _spanned(part, risen * weights)
        beside = float(np.sum((left * weights) ** 2)) - _spanned(whole, left * weights)
        # the power of correlated noise is known from the components that hold it, and counts where the course has its own
        there = float(share @ (np.sum(whole**2, axis=1) - np.sum(part**2, axis=1))) / more
        known = 1 / (1 / free + max(there, 0.0) / max(float(share @ freedom), 1e-300))
        chance = float(fdtrc(more, known, above / more / max(beside / free, 1e-300)))
        expected = self.mean_square
        if self.of.observed.noise is not None:
            expected = self.variance
            chance = max(chance, float(chdtrc(more, squares / expected / STATED)))
        elif (
            rounded_signal(self.of) is not None
        ):  # errors of half a step may follow each other, and are no noise
            half = float(
                np.mean((self.of.observed.resolution / 2 / (self.of.observed.scale * self.of.noise)) ** 2)
            )
            chance = max(chance, float(chdtrc(more, squares / half)))
        ratio = squares / more / max(expected, 1e-300)
        why = f"that are no noise: their {what} has {ratio:.2g} times the variance of noise{self._where()}"
        return self._sign(chance, ratio, why)

    def _of_periodic(self) -> Sign | None:
        from scipy.special import fdtrc

        parts, count = self.of.observed.parts, self.energy.size
        if count < 2 * _BESIDE:
            return None
        energy, risen = (each / self.spectrum.power for each in (self.energy, self.risen))
        beside = running_median(energy, 2 * _BESIDE + 1, beyond="symmetric") / _MEDIAN[parts]
        three = np.convolve(risen, np.ones(3), mode="same") / 3 / np.maximum(beside, 1e-300)
        three[: _SMOOTH // 4] = 0.0
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
            float(risen.max()) ** 2 / max(self.mean_square, 1e-300),
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
        from scipy.fft import idct

        found = _turned(self.residual)
        found[:, _SMOOTH:] = 0.0
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


def _courses(course: Real) -> Real:
    """Return the powers, the delayed courses and the rate of a course, shape (samples, k), as a wrong model may leave them."""
    from scipy.fft import irfft, rfft

    count = course.size
    even = (course - course[0]) / (np.ptp(course) or 1.0)
    found, memory, turned = [even, even**2, even**3, np.gradient(even)], count / 3, rfft(even, 2 * count)
    while memory >= 1:
        lag = np.exp(-np.arange(count) / memory)
        found.append(irfft(turned * rfft(lag / np.sum(lag), 2 * count), 2 * count)[:count])
        memory /= 4
    return np.column_stack(found)


def _turned(rows: Real) -> Real:
    """Return the components of rows, shape (rows, samples) or (rows, samples, columns)."""
    from scipy.fft import dct

    return np.asarray(dct(rows, norm="ortho", axis=1))


def orthonormal(columns: Real) -> Real:
    """Return an orthonormal basis of what some columns span, shape (n, rank)."""
    scale = np.linalg.norm(columns, axis=0)
    used = columns[:, scale > 0] / scale[scale > 0]
    if not used.size:
        return np.zeros((len(columns), 0))
    left, singular, _ = np.linalg.svd(used, full_matrices=False)
    return np.asarray(left[:, singular > VANISHES * singular[0]])


def _spanned(basis: Real, row: Real) -> float:
    """Return the sum of squares of the part of a row that an orthonormal basis spans."""
    return float(np.sum((basis.T @ row) ** 2))


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
