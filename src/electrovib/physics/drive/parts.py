"""The three forms of a voltage for which a solver knows what to do."""

from __future__ import annotations

import functools
import math
from abc import ABC, abstractmethod
from dataclasses import dataclass
from typing import TYPE_CHECKING, TypeAlias

import numpy as np

from electrovib.core.arrays import Complex, Indices, Real

if TYPE_CHECKING:
    from collections.abc import Callable


_SLACK = 8 * float(np.finfo(float).eps)
"""A time this close to a break, relative, counts as at it: time stamps are rounded."""
LOOKS = 16
"""Looks at each cycle of the fastest oscillation, when a largest value is searched for."""
MANY_TIMES = 10_000
"""From which on it is worth to see whether they are even."""
MOST_LOOKS = 1_000_000
"""Beyond which a largest value is bounded and not searched for."""


@dataclass(frozen=True)
class Linear:
    """Straight pieces between breaks, with a jump wherever `before` and `after` differ.

    Parameters
    ----------
    times : ndarray, shape (n,)
        Breaks, strictly increasing, the first at 0 [s].
    before, after : ndarray, shape (n,)
        Voltage just before and just after each break [V]; before the first the drive is off.
    period : float or None
        If given, the pieces repeat with it and the last break is the end of the first period.
    step : float or None
        Time from each break to the next, where they are even but for the rounding of their stamps [s].
    """

    times: Real
    before: Real
    after: Real
    period: float | None = None
    step: float | None = None

    @property
    def is_step(self) -> bool:
        """Tell whether it is switched on at time 0 and then held for ever."""
        return len(self.times) == 1

    def locate(self, time: Real) -> tuple[Indices, Real]:
        """Give the piece in which each time [s] lies, the later one at a break, and the time since it began [s]."""
        slack = _SLACK * np.abs(time)
        inside = time
        if self.period is not None:
            inside = np.mod(time, self.period)
            inside = np.where(inside > self.period - slack, 0.0, inside)
        index = np.clip(np.searchsorted(self.times, inside + slack, side="right") - 1, 0, len(self.times) - 1)
        elapsed = np.maximum(inside - self.times[index], 0.0)
        return index, elapsed if self.period is None else np.where(elapsed > slack, elapsed, 0.0)

    @functools.cached_property
    def jumps(self) -> Real:
        """By how much it jumps at each break [V]."""
        return self.after - self.before

    def begins_with(self, time: Real) -> bool:
        """Tell whether these times [s] are its first breaks and nothing else."""
        if self.period is not None or np.ndim(time) != 1 or not 1 < len(time) <= len(self.times):
            return False
        return time is self.times or bool(np.array_equal(self.times[: len(time)], time))

    def value(self, time: Real) -> Real:
        """Voltage [V] at these times [s]; at a jump the later value; NaN passes."""
        if self.begins_with(time):
            return self.after[: len(time)].copy()
        index, elapsed = self.locate(time)
        value = self.after[index] + np.where(np.isnan(time), np.nan, elapsed) * self.slope_of(index)
        return np.where((time < 0) & (self.period is None), 0.0, value)

    def value_before(self, time: Real) -> Real:
        """Voltage [V] just before these times [s], > 0; at a jump the earlier value."""
        slack = _SLACK * np.abs(time)
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
        """Rate of change just after these times [V/s]."""
        rate = np.where((time < 0) & (self.period is None), 0.0, self.slope_of(self.locate(time)[0]))
        return np.where(np.isnan(time), np.nan, rate)

    def slopes(self) -> Real:
        """Rate of change after each break, 0 after the last one [V/s]."""
        return np.append((self.before[1:] - self.after[:-1]) / np.diff(self.times), 0.0)

    def slope_of(self, index: Indices) -> Real:
        """Give the rate of change in some of the pieces, without looking at the others [V/s]."""
        if np.size(index) >= len(self.times):
            return np.asarray(self.slopes()[index])
        following = np.minimum(index + 1, len(self.times) - 1)
        return np.asarray((self.before[following] - self.after[index]) / self.length_of(index))

    def length_of(self, index: Indices) -> Real:
        """Give how long some of the pieces last [s]; infinite for the last."""
        following = np.minimum(index + 1, len(self.times) - 1)
        return np.where(following > index, self.times[following] - self.times[index], np.inf)

    def count_periods(self, time: Real) -> Indices:
        """Count the whole periods that are over at each time [s], as `locate` has it; 0 without a period."""
        if self.period is None:
            return np.zeros(np.shape(time), np.intp)
        return np.asarray(np.floor((time + _SLACK * np.abs(time)) / self.period), np.intp)

    def _written_out(self, end: float) -> int:
        """Count the periods that are written out up to a time [s]."""
        assert self.period is not None
        return max(1, math.ceil(end / self.period * (1 - _SLACK)))

    def count_breaks(self, end: float) -> int:
        """Count the breaks up to a time [s] without writing them out."""
        if self.period is None:
            return len(self.times)
        return self._written_out(end) * (len(self.times) - 1) + 1

    def until(self, end: float) -> Linear:
        """Write the repeated pieces out up to a time [s]; without a period, the same pieces."""
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

    @property
    def highest_frequency(self) -> float:
        """Nothing oscillates between corners [Hz]."""
        return 0.0

    def corners(self, end: float) -> tuple[Real, Real]:
        """Times up to an end at which it bends or jumps [s], and by how much it jumps there [V]."""
        pieces = self.until(end)
        return pieces.times, pieces.jumps

    def shortest_piece(self, end: float) -> float:  # noqa: ARG002 - the pieces repeat
        """Length of the shortest straight piece [s]; infinite for a step."""
        if self.step is not None:
            return self.step
        return float(np.min(np.diff(self.times), initial=np.inf))

    def bound(self) -> float:
        """Largest absolute value it ever has [V]."""
        sides = self.before, self.after
        return max(max(float(np.max(side)), -float(np.min(side))) for side in sides)


def circling(frequency: float, time: Real) -> tuple[Real, Real]:
    """Give cosine and sine of the phase of a tone.

    Parameters
    ----------
    frequency : float
        Hz.
    time : ndarray, shape (n,)
        s.

    Returns
    -------
    cosine, sine : ndarray, shape (n,)
        Of 2 pi frequency time. At many even times from products of those of two coarser grids, to rounding.
    """
    angular, step = 2 * np.pi * frequency, _even_step(time)
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


def _even_step(time: Real) -> float | None:
    """Give the step of many times that are even but for rounding [s]."""
    if len(time) < MANY_TIMES:
        return None
    step = float(time[-1] - time[0]) / (len(time) - 1)
    off = np.max(np.abs(time - time[0] - step * np.arange(len(time))))
    return step if off <= _SLACK * max(abs(float(time[0])), abs(float(time[-1]))) else None


class _Gated(ABC):
    """What is on between two times: when it is switched, and by how much."""

    start: float
    stop: float

    @abstractmethod
    def whenever(self, time: Real) -> Real:
        """Voltage [V] at these times [s] as if it were always on."""

    def value(self, time: Real) -> Real:
        """Voltage [V] at these times [s]."""
        on = (time >= self.start) & (time < self.stop)
        return np.where(on | np.isnan(time), self.whenever(time), 0.0)

    def value_before(self, time: Real) -> Real:
        """Voltage [V] just before these times [s], > 0."""
        return np.where((time > self.start) & (time <= self.stop), self.whenever(time), 0.0)

    def corners(self, end: float) -> tuple[Real, Real]:
        """Times up to an end at which it is switched [s], and by how much the voltage jumps there [V]."""
        gates = np.array([gate for gate in (self.start, self.stop) if -math.inf < gate <= end])
        values = self.whenever(gates)
        return gates, np.where(gates == self.start, values, -values)

    def count_breaks(self, end: float) -> int:
        """Count the times up to an end [s] at which it is switched."""
        return len(self.corners(end)[0])

    def shortest_piece(self, end: float) -> float:
        """For how long it is on up to an end [s]; infinite if never."""
        on = min(self.stop, end) - max(self.start, 0.0)
        return on if on > 0 else np.inf


@dataclass(frozen=True)
class Tones(_Gated):
    """A sum of sines, on between two times: the real part of sum A exp(j w t).

    Parameters
    ----------
    frequencies : ndarray, shape (n,)
        Hz; 0 for a constant.
    amplitudes : ndarray of complex, shape (n,)
        Peak values [V] with phase.
    start, stop : float
        When it is switched on and off [s]; always on when infinite.
    """

    frequencies: Real
    amplitudes: Complex
    start: float = -math.inf
    stop: float = math.inf

    def whenever(self, time: Real) -> Real:
        """Voltage [V] at these times [s] as if it were always on."""
        return self._sum(time, self.amplitudes)

    def slope(self, time: Real) -> Real:
        """Rate of change just after these times [V/s]."""
        on = (time >= self.start) & (time < self.stop)
        rate = self._sum(time, 2j * np.pi * self.frequencies * self.amplitudes)
        return np.where(on | np.isnan(time), rate, 0.0)

    def _sum(self, time: Real, amplitudes: Complex) -> Real:
        flat = np.ravel(time)
        total = np.zeros(flat.shape)
        for frequency, amplitude in zip(self.frequencies, amplitudes, strict=True):
            cosine, sine = circling(float(frequency), flat)
            total += amplitude.real * cosine - amplitude.imag * sine
        return total.reshape(np.shape(time))

    @property
    def highest_frequency(self) -> float:
        """Of the tones that have an amplitude [Hz]."""
        return float(np.max(self.frequencies[self.amplitudes != 0], initial=0.0))

    def bound(self) -> float:
        """Sum of the amplitudes, which no value exceeds [V]."""
        return float(np.sum(np.abs(self.amplitudes)))


@dataclass(frozen=True)
class Smooth(_Gated):
    """A voltage given by a formula, smooth while it is on.

    Parameters
    ----------
    formula, derivative : callable
        Voltage [V] and its rate [V/s] at times [s].
    start, stop : float
        When it is on [s].
    highest_frequency : float
        Fastest oscillation in it [Hz]: how finely a solver has to look.
    """

    formula: Callable[[Real], Real]
    derivative: Callable[[Real], Real]
    start: float
    stop: float
    highest_frequency: float

    def whenever(self, time: Real) -> Real:
        """Voltage [V] at these times [s] as if it were always on."""
        return self.formula(time)

    def slope(self, time: Real) -> Real:
        """Rate of change just after these times [V/s]."""
        on = (time >= self.start) & (time < self.stop)
        return np.where(on | np.isnan(time), self.derivative(time), 0.0)

    def bound(self) -> float:
        """Hardly more than its largest absolute value [V]: that at 16 looks a cycle, and what lies between them."""
        looks = math.ceil((self.stop - self.start) * self.highest_frequency * LOOKS)
        times = np.linspace(self.start, self.stop, min(max(looks, LOOKS), MOST_LOOKS) + 1)
        return float(np.max(np.abs(self.whenever(times)))) / (1 - (2 * math.pi / LOOKS) ** 2 / 8)


@dataclass(frozen=True)
class Chirped(Smooth):
    """A sine whose frequency runs evenly: amplitude times sin 2 pi (first t + sweep t^2/2).

    Parameters
    ----------
    amplitude : float
        V.
    first : float
        Frequency at time 0 [Hz].
    sweep : float
        Rate of change of the frequency [Hz/s].
    """

    amplitude: float
    first: float
    sweep: float

    @classmethod
    def between(cls, amplitude: float, first: float, last: float, length: float) -> Chirped:
        """Let the frequency run from one value to another, from time 0 on.

        Parameters
        ----------
        amplitude : float
            V.
        first, last : float
            Hz, >= 0.
        length : float
            Time that takes [s].

        Returns
        -------
        Chirped
            Off afterwards.
        """
        sweep = (last - first) / length

        def phase(time: Real) -> Real:
            return 2 * np.pi * (first * time + sweep * time**2 / 2)

        def formula(time: Real) -> Real:
            return amplitude * np.sin(phase(time))

        def derivative(time: Real) -> Real:
            return 2 * np.pi * (first + sweep * time) * amplitude * np.cos(phase(time))

        return cls(formula, derivative, 0.0, length, max(first, last), amplitude, first, sweep)

    def phase(self, time: Real) -> Real:
        """Phase at these times [s], of which the voltage is the sine [rad]."""
        return 2 * np.pi * (self.first * time + self.sweep * time**2 / 2)

    def bound(self) -> float:
        """Amplitude, which no value exceeds [V]."""
        return abs(self.amplitude)


Part: TypeAlias = Linear | Tones | Smooth
