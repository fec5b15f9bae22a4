"""A voltage of straight pieces, which may repeat."""

from __future__ import annotations

import functools
import math
from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from electrovib.core.arrays import Indices, Real

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
        return self.after - self.before

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
