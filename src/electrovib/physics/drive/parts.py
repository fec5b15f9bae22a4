"""The closed forms of which a drive is a sum: tones, formulas, and straight pieces, which may repeat."""

from __future__ import annotations

import functools
import math
from abc import ABC, abstractmethod
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Any, ClassVar, Literal, Self, TypeAlias

import numpy as np

from electrovib.core.arrays import Complex, Indices, Real

if TYPE_CHECKING:
    from collections.abc import Callable


SLACK = 8 * float(np.finfo(float).eps)
"""Relative distance below which a time counts as at a break, because time stamps are rounded."""


@dataclass(frozen=True)
class Linear:
    """Straight pieces between breaks, with a step wherever `before` and `after` differ.

    Parameters
    ----------
    times : ndarray, shape (n,)
        Breaks, strictly increasing, the first at 0 [s].
    before, after : ndarray, shape (n,)
        Voltage just before and just after each break [V]; it is 0 before the first break.
    period : float or None
        Period with which the pieces repeat [s], and then the last break; None for pieces that do not repeat.
    step : float or None
        Time from each break to the next [s] where they are evenly spaced to the rounding of their time stamps.
    """

    times: Real
    before: Real
    after: Real
    period: float | None = None
    step: float | None = None
    start: ClassVar[float] = 0.0
    stop: ClassVar[float] = math.inf
    highest_frequency: ClassVar[float] = 0.0  # nothing oscillates between corners

    @property
    def is_step(self) -> bool:
        """Whether the voltage is switched on at time 0 and then held."""
        return len(self.times) == 1

    @property
    def timing(self) -> tuple[Any, ...]:
        """What pieces that differ in their levels alone have in common."""
        return self.times, self.period

    @property
    def levels(self) -> Real:
        """Numbers to which the voltage is proportional, all of them together, in one row."""
        return np.concatenate([self.before, self.after])

    def with_levels(self, levels: Real) -> Linear:
        """Return pieces of the same timing with other levels."""
        before, after = np.split(levels, 2)
        return replace(self, before=before, after=after)

    def locate(self, time: Real) -> tuple[Indices, Real]:
        """Return the index of the piece at each time [s], the later one at a break, and the time since it began [s]."""
        slack = SLACK * np.abs(time)
        inside = time
        if self.period is not None:
            inside = np.mod(time, self.period)
            inside = np.where(inside > self.period - slack, 0.0, inside)
        index = np.clip(np.searchsorted(self.times, inside + slack, side="right") - 1, 0, len(self.times) - 1)
        elapsed = np.maximum(inside - self.times[index], 0.0)
        return index, elapsed if self.period is None else np.where(elapsed > slack, elapsed, 0.0)

    @functools.cached_property
    def lengths(self) -> Real:
        """Time from each break to the next [s]."""
        return np.diff(self.times)

    @functools.cached_property
    def jumps(self) -> Real:
        """Height of the step at each break [V]."""
        return np.zeros(len(self.times)) if self.before is self.after else self.after - self.before

    def begins_with(self, time: Real) -> bool:
        """Tell whether these times [s] are exactly the first breaks."""
        if self.period is not None or np.ndim(time) != 1 or not 1 < len(time) <= len(self.times):
            return False
        return time is self.times or bool(np.array_equal(self.times[: len(time)], time))

    def value(self, time: Real) -> Real:
        """Return the voltage [V] at these times [s], at a step the later value; NaN gives NaN."""
        if self.begins_with(time):
            return self.after[: len(time)].copy()
        index, elapsed = self.locate(time)
        value = self.after[index] + np.where(np.isnan(time), np.nan, elapsed) * self.slope_of(index)
        return np.where((time < 0) & (self.period is None), 0.0, value)

    def value_before(self, time: Real) -> Real:
        """Return the voltage [V] just before these times [s], > 0; at a step the earlier value."""
        slack = SLACK * np.abs(time)
        inside = time
        if self.period is not None:
            inside = np.mod(time, self.period)
            inside = np.where(inside <= slack, self.period, inside)
        index = np.clip(np.searchsorted(self.times, inside - slack, side="left") - 1, 0, len(self.times) - 1)
        value = self.after[index] + (inside - self.times[index]) * self.slope_of(index)
        following = np.minimum(index + 1, len(self.times) - 1)
        met = (following > index) & (np.abs(self.times[following] - inside) <= slack)
        return np.asarray(np.where(met, self.before[following], value))

    def slope(self, time: Real) -> Real:
        """Return the rate of change just after these times [V/s]."""
        rate = np.where((time < 0) & (self.period is None), 0.0, self.slope_of(self.locate(time)[0]))
        return np.where(np.isnan(time), np.nan, rate)

    def slopes(self) -> Real:
        """Return the rate of change after each break, 0 after the last one [V/s]."""
        return np.append((self.before[1:] - self.after[:-1]) / self.lengths, 0.0)

    def slope_of(self, index: Indices) -> Real:
        """Return the rate of change in some of the pieces, without evaluating the others [V/s]."""
        if np.size(index) >= len(self.times):
            return np.asarray(self.slopes()[index])
        following = np.minimum(index + 1, len(self.times) - 1)
        return np.asarray((self.before[following] - self.after[index]) / self.length_of(index))

    def length_of(self, index: Indices) -> Real:
        """Return the duration of some of the pieces [s]; infinite for the last."""
        following = np.minimum(index + 1, len(self.times) - 1)
        return np.where(following > index, self.times[following] - self.times[index], np.inf)

    def count_periods(self, time: Real) -> Indices:
        """Count the whole periods completed at each time [s], consistently with `locate`; 0 without a period."""
        if self.period is None:
            return np.zeros(np.shape(time), np.intp)
        return np.asarray(np.floor((time + SLACK * np.abs(time)) / self.period), np.intp)

    def _written_out(self, end: float) -> int:
        """Count the periods that are written out up to a time [s]."""
        assert self.period is not None
        return max(1, math.ceil(end / self.period * (1 - SLACK)))

    def count_breaks(self, end: float) -> int:
        """Count the breaks up to a time [s] without writing them out."""
        if self.period is None:
            return len(self.times)
        return self._written_out(end) * (len(self.times) - 1) + 1

    def until(self, end: float) -> Linear:
        """Return the repeated pieces written out up to a time [s]; the same pieces without a period."""
        if self.period is None:
            return self
        count = self._written_out(end)
        starts = np.arange(count) * self.period
        times = (starts[:, None] + self.times[:-1]).ravel()
        before = np.tile(self.before[:-1], count)
        before[:: len(self.times) - 1] = self.before[-1]
        before[0] = 0.0
        after = np.tile(self.after[:-1], count)
        return Linear(
            np.append(times, count * self.period),
            np.append(before, self.before[-1]),
            np.append(after, self.after[0]),
        )

    def corners(self, end: float) -> tuple[Real, Real]:
        """Return the times of kinks and steps up to an end [s], and the height of the step at each [V]."""
        pieces = self.until(end)
        return pieces.times, pieces.jumps

    def shortest_piece(self, end: float) -> float:  # noqa: ARG002 - the pieces repeat
        """Return the duration of the shortest straight piece [s]; infinite for a step."""
        if self.step is not None:
            return self.step
        return float(np.min(self.lengths, initial=np.inf))

    def bound(self) -> float:
        """Return the largest absolute voltage [V]."""
        sides = self.before, self.after
        return max(max(float(np.max(side)), -float(np.min(side))) for side in sides)


CYCLE_SAMPLES = 16
"""Evaluations in each cycle of the fastest oscillation in a search for the largest value."""
MANY_TIMES = 10_000
"""Number of times from which on they are tested for even spacing."""
TOGETHER = 1 << 15
"""Number of times at which tones are evaluated together, so that what is made of them stays in the cache."""
MOST_SAMPLES = 1_000_000
"""Number of evaluations beyond which a largest value is bounded and not searched for."""


def cosine_and_sine(frequency: float, time: Real) -> tuple[Real, Real]:
    """Return cosine and sine of the phase 2 pi frequency time of a tone, shape (n,) as the times [s].

    At many evenly spaced times they are products of those of two coarser grids, to rounding.
    """
    angular, step = 2 * np.pi * frequency, even_step(time)
    if step is None:
        phase = np.asarray(angular * time)
        return np.cos(phase), np.sin(phase)
    width = math.isqrt(len(time))
    inside = angular * step * np.arange(width)
    begins = angular * time[::width, None]
    parts = [np.cos(begins), np.sin(begins), np.cos(inside), np.sin(inside)]
    cosine = parts[0] * parts[2] - parts[1] * parts[3]
    sine = parts[1] * parts[2] + parts[0] * parts[3]
    return cosine.ravel()[: len(time)], sine.ravel()[: len(time)]


def even_step(time: Real, *, fewest: int = MANY_TIMES, largest: float = 0.0) -> float | None:
    """Return the step of many times that are evenly spaced to rounding [s]; else None.

    They are rounded as numbers up to `largest` [s] are, of which they may be differences.
    """
    if len(time) < fewest:
        return None
    step = float(time[-1] - time[0]) / (len(time) - 1)
    off = step * np.arange(len(time))
    off -= time - time[0]
    largest = max(abs(float(time[0])), abs(float(time[-1])), largest)
    return step if max(np.max(off), -np.min(off)) <= SLACK * largest else None


class _Gated(ABC):
    """A part of a drive that is on between two times and zero outside."""

    start: float
    stop: float
    is_step: ClassVar[Literal[False]] = False
    period: ClassVar[None] = None

    @property
    @abstractmethod
    def timing(self) -> tuple[Any, ...]:
        """What parts that differ in their levels alone have in common."""

    @property
    @abstractmethod
    def levels(self) -> Real:
        """Numbers to which the voltage is proportional, all of them together, in one row."""

    @abstractmethod
    def with_levels(self, levels: Real) -> Self:
        """Return a part of the same timing with other levels."""

    def begins_with(self, time: Real) -> bool:  # noqa: ARG002 - no part but straight pieces has breaks
        """Return False: no times are breaks between straight pieces."""
        return False

    @abstractmethod
    def whenever(self, time: Real) -> Real:
        """Return the voltage [V] at these times [s] as if the part were always on."""

    @abstractmethod
    def slope_whenever(self, time: Real) -> Real:
        """Return the rate of change [V/s] at these times [s] as if the part were always on."""

    def slope(self, time: Real) -> Real:
        """Return the rate of change just after these times [V/s]."""
        on = (time >= self.start) & (time < self.stop)
        return np.where(on | np.isnan(time), self.slope_whenever(time), 0.0)

    def value(self, time: Real) -> Real:
        """Return the voltage [V] at these times [s]."""
        on = (time >= self.start) & (time < self.stop)
        return np.where(on | np.isnan(time), self.whenever(time), 0.0)

    def value_before(self, time: Real) -> Real:
        """Return the voltage [V] just before these times [s], > 0."""
        return np.where((time > self.start) & (time <= self.stop), self.whenever(time), 0.0)

    def corners(self, end: float) -> tuple[Real, Real]:
        """Return the times up to an end at which the part is switched [s], and the voltage steps there [V]."""
        gates = np.array([gate for gate in (self.start, self.stop) if -math.inf < gate <= end])
        values = self.whenever(gates)
        return gates, np.where(gates == self.start, values, -values)

    def count_breaks(self, end: float) -> int:
        """Count the times up to an end [s] at which the part is switched."""
        return len(self.corners(end)[0])

    def shortest_piece(self, end: float) -> float:
        """Return how long the part is on up to an end [s]; infinite if it is never on."""
        on = min(self.stop, end) - max(self.start, 0.0)
        return on if on > 0 else np.inf


@dataclass(frozen=True)
class Tones(_Gated):
    """A sum of sines that is on between two times: the real part of sum A exp(j w t).

    `frequencies` (n,) [Hz], 0 for a constant; `amplitudes` (n,) complex peak values [V]; `start` and `stop`
    of switching on and off [s], infinite for a sum that is always on.
    """

    frequencies: Real
    amplitudes: Complex
    start: float = -math.inf
    stop: float = math.inf

    @property
    def timing(self) -> tuple[Any, ...]:
        """Frequencies, and when the sum is on."""
        return self.frequencies, self.start, self.stop

    @property
    def levels(self) -> Real:
        """Real parts of the amplitudes, then the imaginary parts [V]."""
        return np.concatenate([self.amplitudes.real, self.amplitudes.imag])

    def with_levels(self, levels: Real) -> Self:
        """Return sines of the same timing with other amplitudes."""
        real, imaginary = np.split(levels, 2)
        return replace(self, amplitudes=real + 1j * imaginary)

    def whenever(self, time: Real) -> Real:
        """Return the voltage [V] at these times [s] as if the part were always on."""
        return self._sum(time, self.amplitudes)

    def slope_whenever(self, time: Real) -> Real:
        """Return the rate of change [V/s] at these times [s] as if the part were always on."""
        return self._sum(time, 2j * np.pi * self.frequencies * self.amplitudes)

    def _sum(self, time: Real, amplitudes: Complex) -> Real:
        flat = np.ravel(time)
        total = np.zeros(flat.shape)
        for first in range(0, flat.size, TOGETHER):
            some = slice(first, first + TOGETHER)
            for frequency, amplitude in zip(self.frequencies, amplitudes, strict=True):
                cosine, sine = cosine_and_sine(float(frequency), flat[some])
                total[some] += amplitude.real * cosine - amplitude.imag * sine
        return total.reshape(np.shape(time))

    @property
    def highest_frequency(self) -> float:
        """Highest frequency of a tone with an amplitude above 0 [Hz]; 0 without one."""
        return float(np.max(self.frequencies[self.amplitudes != 0], initial=0.0))

    def bound(self) -> float:
        """Return the sum of the amplitudes, which no value exceeds [V]."""
        return float(np.sum(np.abs(self.amplitudes)))


@dataclass(frozen=True)
class Smooth(_Gated):
    """A voltage given by a formula that is smooth while it is on, between two times [s].

    `formula` and `derivative` give voltage [V] and its rate of change [V/s] at times [s]; `highest_frequency`
    of its oscillation [Hz] has to be resolved by a solver.
    """

    formula: Callable[[Real], Real]
    derivative: Callable[[Real], Real]
    start: float
    stop: float
    highest_frequency: float

    @property
    def timing(self) -> tuple[Any, ...]:
        """The formula itself, and when it is on."""
        return self.formula, self.start, self.stop

    @property
    def levels(self) -> Real:
        """The factor 1 of the formula."""
        return np.ones(1)

    def with_levels(self, levels: Real) -> Self:
        """Return a multiple of the formula."""
        factor, formula, derivative = float(levels[0]), self.formula, self.derivative
        return replace(
            self,
            formula=lambda time: factor * formula(time),
            derivative=lambda time: factor * derivative(time),
        )

    def whenever(self, time: Real) -> Real:
        """Return the voltage [V] at these times [s] as if the part were always on."""
        return self.formula(time)

    def slope_whenever(self, time: Real) -> Real:
        """Return the rate of change [V/s] at these times [s] as if the part were always on."""
        return self.derivative(time)

    def bound(self) -> float:
        """Return an upper bound on the absolute value [V], from 16 evaluations a cycle and the curvature between them."""
        samples = math.ceil((self.stop - self.start) * self.highest_frequency * CYCLE_SAMPLES)
        times = np.linspace(self.start, self.stop, min(max(samples, CYCLE_SAMPLES), MOST_SAMPLES) + 1)
        return float(np.max(np.abs(self.whenever(times)))) / (1 - (2 * math.pi / CYCLE_SAMPLES) ** 2 / 8)


@dataclass(frozen=True)
class Chirped(Smooth):
    """A sine whose frequency changes linearly with time: amplitude times sin 2 pi (first t + sweep t^2/2).

    Peak `amplitude` [V], `first` frequency at time 0 [Hz], rate of change `sweep` of the frequency [Hz/s].
    """

    amplitude: float
    first: float
    sweep: float

    @classmethod
    def between(cls, amplitude: float, first: float, last: float, length: float) -> Self:
        """Make a sine whose frequency changes linearly from `first` to `last` [Hz] within `length` [s].

        It begins at time 0 and is off after its duration.
        """
        sweep = (last - first) / length

        def phase(time: Real) -> Real:
            return 2 * np.pi * (first * time + sweep * time**2 / 2)

        def formula(time: Real) -> Real:
            return amplitude * np.sin(phase(time))

        def derivative(time: Real) -> Real:
            return 2 * np.pi * (first + sweep * time) * amplitude * np.cos(phase(time))

        return cls(formula, derivative, 0.0, length, max(first, last), amplitude, first, sweep)

    @property
    def timing(self) -> tuple[Any, ...]:
        """Frequency at time 0, its rate of change, and when the sine is on."""
        return self.first, self.sweep, self.start, self.stop

    @property
    def levels(self) -> Real:
        """The amplitude [V]."""
        return np.array([self.amplitude])

    def with_levels(self, levels: Real) -> Self:
        """Return the sine with another amplitude."""
        last = self.first + self.sweep * self.stop
        return self.between(float(levels[0]), self.first, last, self.stop)

    def phase(self, time: Real) -> Real:
        """Return the phase at these times [s], whose sine the voltage is proportional to [rad]."""
        return 2 * np.pi * (self.first * time + self.sweep * time**2 / 2)

    def bound(self) -> float:
        """Return the amplitude, which no value exceeds [V]."""
        return abs(self.amplitude)


Part: TypeAlias = Linear | Tones | Smooth
