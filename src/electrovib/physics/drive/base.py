"""The family of drives."""

from __future__ import annotations

import math
from abc import abstractmethod
from fractions import Fraction
from math import lcm
from typing import TYPE_CHECKING, ClassVar, Self

import numpy as np
from pydantic import model_validator

from electrovib.core.model import Model

if TYPE_CHECKING:
    from collections.abc import Sequence

    from numpy.typing import ArrayLike

    from electrovib.core.arrays import Real
    from electrovib.physics.drive.parts import Part


_ROUNDED = 16 * float(np.finfo(float).eps)
"""Relative distance in time below which two corners count as one."""
_MOST_CYCLES = 100_000
"""Cycles up to which a common period of two oscillations is searched for; beyond it there is none."""


class Drive(Model, family=True):
    """A voltage or current over time; zero before time 0 when the simulation starts from rest.

    Notes
    -----
    A drive is a sum of parts in closed form, so that a solver can be exact; `voltage` is their sum. Volts stand
    for amperes where `quantity` is ``"current"``.
    """

    quantity: ClassVar[str] = "voltage"

    @model_validator(mode="after")
    def _holds_voltages(self) -> Self:
        for name, value in self:
            inner = value if isinstance(value, tuple) else (value,)
            if any(isinstance(drive, Drive) and drive.quantity == "current" for drive in inner):
                why = (
                    f"{name} of {type(self).__name__} must be a voltage; for a current, put the whole drive"
                    ' into { model = "CurrentAmplifier", command = ... }'
                )
                raise ValueError(why)
        return self

    @abstractmethod
    def parts(self) -> tuple[Part, ...]:
        """Return the closed forms whose sum is the drive."""

    @property
    def period(self) -> float | None:
        """Period of the drive [s]; None for a drive that does not repeat."""
        return None

    @property
    def duration(self) -> float:
        """Default duration of a simulation under this drive [s]: five periods; a drive that does not repeat declares its own."""
        if self.period is None:
            msg = f"{type(self).__name__} does not repeat, so that it has to declare its duration"
            raise NotImplementedError(msg)
        return 5 * self.period

    @property
    def time_stamps(self) -> Real | None:
        """Times at which the drive was measured [s]; None for a formula."""
        return None

    def voltage(self, time: ArrayLike) -> Real:
        """Return the voltage of the drive.

        Parameters
        ----------
        time : array_like
            Time [s], any shape; NaN gives NaN. The declared formulas hold from time 0 on.

        Returns
        -------
        voltage : ndarray
            Voltage [V], or current [A] of a current drive, same shape; at a step the value after it.
        """
        times = np.asarray(time, dtype=float)
        values = [part.value(times) for part in self.parts()]
        total: Real = values[0] if len(values) == 1 else np.sum(values, axis=0)
        return total

    def slope(self, time: ArrayLike) -> Real:
        """Return the rate of change of the voltage just after these times [V/s], without its steps."""
        times = np.asarray(time, dtype=float)
        slopes = [part.slope(times) for part in self.parts()]
        total: Real = slopes[0] if len(slopes) == 1 else np.sum(slopes, axis=0)
        return total

    def extremes(self, start: float = 0.0, end: float | None = None) -> tuple[float, float]:
        """Return the lowest and highest voltage between two times, both sides of every step between them included.

        Parameters
        ----------
        start : float
            s, >= 0; the voltage before it does not count.
        end : float, optional
            s, > `start`; by default the longer of the drive's duration and its period.

        Returns
        -------
        lowest, highest : float
            Extremes of the voltage [V].

        Notes
        -----
        Straight pieces, also with one tone added, are exact. Several tones are bracketed by their largest
        curvature to 1e-12 of the sum of their amplitudes; a formula is searched as if its curvature were at most
        twice that of its highest frequency. Where that would take more than a million evaluations, the bounds of
        the parts are added, which is never less than the largest value.
        """
        from electrovib.physics.drive.extremes import extremes

        last = max(self.duration, self.period or 0.0) if end is None else end
        if self.period is not None:
            last = min(last, start + self.period)
        return extremes(self.parts(), start, last)

    def largest(self, end: float | None = None) -> float:
        """Return the largest absolute voltage from time 0 to an end [V], from `extremes`."""
        lowest, highest = self.extremes(0.0, end)
        return max(-lowest, highest)

    @property
    def highest_frequency(self) -> float:
        """Highest frequency of an oscillation in the drive [Hz]; 0 for straight pieces, however steep."""
        return max((part.highest_frequency for part in self.parts()), default=0.0)

    def shortest_piece(self, end: float) -> float:
        """Return the shortest straight piece or on-time of a tone or formula up to an end [s]; infinite for a step."""
        return min((part.shortest_piece(end) for part in self.parts()), default=math.inf)

    def count_corners(self, end: float) -> int:
        """Estimate the number of kinks, steps and switching times up to an end [s], without writing them out."""
        return sum(part.count_breaks(end) for part in self.parts())

    def corners(self, end: float) -> tuple[Real, Real]:
        """Return the times of kinks, steps and switching, and the height of each step.

        Parameters
        ----------
        end : float
            Last time [s].

        Returns
        -------
        times : ndarray, shape (n,)
            Increasing, after 0 and up to the end [s]; times that differ by rounding count as one.
        heights : ndarray, shape (n,)
            Height of the step at each time [V]; 0 where there is none.
        """
        parts = self.parts()
        found = [part.corners(end * (1 + _ROUNDED)) for part in parts]
        times, heights = (
            column[0] if len(column) == 1 else np.concatenate(column) for column in zip(*found, strict=True)
        )
        if len(found) > 1:
            order = np.argsort(times, kind="stable")
            times, heights = times[order], heights[order]
        inside = slice(*np.searchsorted(times, [0.0, end * (1 + _ROUNDED)], side="right"))
        times, heights = times[inside], heights[inside]
        at_end = slice(int(np.searchsorted(times, end * (1 - _ROUNDED), side="right")), None)
        if np.any(times[at_end] != end):
            times = times.copy()
            times[at_end] = end
        if len(parts) == 1 and parts[0].shortest_piece(end) > 2 * _ROUNDED * end:
            return times, heights
        first = np.diff(times, prepend=-1.0) > _ROUNDED * times
        if np.all(first):
            return times, heights
        return times[first], np.add.reduceat(heights, np.flatnonzero(first))


def common_period(periods: Sequence[float]) -> float | None:
    """Find the shortest common multiple [s] of some periods [s].

    None without periods, or where their ratios are not those of whole numbers up to 100 000.
    """
    if not periods:
        return None
    first = periods[0]
    ratios = [Fraction(period / first).limit_denominator(_MOST_CYCLES) for period in periods]
    # a mismatch adds up over the cycles: it has to stay below 1e-10 of a turn
    if any(
        abs(float(ratio) * first / period - 1) * max(ratio.numerator, ratio.denominator) > 2e-11
        for ratio, period in zip(ratios, periods, strict=True)
    ):
        return None
    common = lcm(*(ratio.denominator for ratio in ratios))
    return first * lcm(*(int(ratio * common) for ratio in ratios)) / common
