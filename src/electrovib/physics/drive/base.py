"""The family of drives."""

from __future__ import annotations

import math
from abc import abstractmethod
from fractions import Fraction
from math import lcm
from typing import TYPE_CHECKING, ClassVar, Self

import numpy as np
from pydantic import model_validator
from pydantic_core import PydanticCustomError

from electrovib.core.model import Model

if TYPE_CHECKING:
    from collections.abc import Sequence

    from numpy.typing import ArrayLike

    from electrovib.core.arrays import Real
    from electrovib.physics.drive.parts import Part


_ROUNDED = 16 * float(np.finfo(float).eps)
"""Corners nearer to each other than this against the time are one."""
_MOST_CYCLES = 100_000
"""Of one oscillation in as many of another: beyond it two periods count as having nothing in common."""


class Drive(Model, family=True):
    """A voltage, or a current, over time; off before time 0 when it starts from rest.

    Notes
    -----
    A drive is a sum of parts in closed form, so that a solver can be exact; `voltage` is their sum. What is
    said of volts holds for amperes where `quantity` is ``"current"``.
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
                raise PydanticCustomError("drive", "{why}", {"why": why})
        return self

    @abstractmethod
    def parts(self) -> tuple[Part, ...]:
        """Give the closed forms whose sum is the drive."""

    @property
    @abstractmethod
    def period(self) -> float | None:
        """Time after which the drive repeats for ever [s]; None when it does not."""

    @property
    @abstractmethod
    def duration(self) -> float:
        """How long one looks at it by default [s]."""

    @property
    def time_stamps(self) -> Real | None:
        """Times at which the drive was measured [s]; None for a formula."""
        return None

    def voltage(self, time: ArrayLike) -> Real:
        """Voltage of the drive.

        Parameters
        ----------
        time : array_like
            s, any shape; NaN gives NaN.

        Returns
        -------
        ndarray
            V, same shape; at a jump the value after it.
        """
        times = np.asarray(time, dtype=float)
        values = [part.value(times) for part in self.parts()]
        total: Real = values[0] if len(values) == 1 else np.sum(values, axis=0)
        return total

    def slope(self, time: ArrayLike) -> Real:
        """Rate of change of the voltage just after these times [V/s]; jumps are not in it."""
        times = np.asarray(time, dtype=float)
        slopes = [part.slope(times) for part in self.parts()]
        total: Real = slopes[0] if len(slopes) == 1 else np.sum(slopes, axis=0)
        return total

    def extremes(self, start: float = 0.0, end: float | None = None) -> tuple[float, float]:
        """Lowest and highest voltage between two times, both sides of every jump between them included.

        Parameters
        ----------
        start : float
            s, >= 0; the voltage before it does not count.
        end : float, optional
            s, > `start`; by default when the drive has shown all it does: its duration, or its period where that
            is longer.

        Returns
        -------
        lowest, highest : float
            V.

        Notes
        -----
        Straight pieces and one tone beside them are exact. Several tones are bracketed by their largest
        curvature to 1e-12 of the sum of their amplitudes; a formula is searched as if its curvature were at most
        twice that of its highest frequency. Where that would take more than a million looks, the parts' own
        bounds are added: never less than the largest value there is.
        """
        from electrovib.physics.drive.extremes import extremes

        last = max(self.duration, self.period or 0.0) if end is None else end
        if self.period is not None:
            last = min(last, start + self.period)
        return extremes(self.parts(), start, last)

    def largest(self, end: float | None = None) -> float:
        """Largest absolute voltage from time 0 to an end [V]; as `extremes` has it."""
        lowest, highest = self.extremes(0.0, end)
        return max(-lowest, highest)

    @property
    def highest_frequency(self) -> float:
        """Fastest oscillation in the drive [Hz]; 0 for straight pieces, however steep."""
        return max((part.highest_frequency for part in self.parts()), default=0.0)

    def shortest_piece(self, end: float) -> float:
        """Shortest straight piece, or time for which a tone or formula is on up to an end [s]; infinite for a step."""
        return min((part.shortest_piece(end) for part in self.parts()), default=math.inf)

    def count_corners(self, end: float) -> int:
        """Count about how often the drive bends, jumps or is switched up to an end [s], without writing it out."""
        return sum(part.count_breaks(end) for part in self.parts())

    def corners(self, end: float) -> tuple[Real, Real]:
        """Times at which the drive bends, jumps or is switched, and by how much it jumps.

        Parameters
        ----------
        end : float
            Up to when [s].

        Returns
        -------
        times, heights : ndarray, shape (n,)
            Increasing, after 0 and up to the end [s]; V, 0 where it does not jump. Corners that differ by rounding
            are one.
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
        if len(parts) == 1 and (getattr(parts[0], "step", None) or 0.0) > 2 * _ROUNDED * end:
            return times, heights
        first = np.diff(times, prepend=-1.0) > _ROUNDED * times
        if np.all(first):
            return times, heights
        return times[first], np.add.reduceat(heights, np.flatnonzero(first))


def common_period(periods: Sequence[float]) -> float | None:
    """Find the shortest time that holds a whole number of each of some periods.

    Parameters
    ----------
    periods : sequence of float
        s, > 0.

    Returns
    -------
    float or None
        s; None for no periods, or for periods whose ratio is not one of whole numbers up to 100 000.
    """
    if not periods:
        return None
    first = periods[0]
    ratios = [Fraction(period / first).limit_denominator(_MOST_CYCLES) for period in periods]
    # a mismatch counts as many times as there are cycles: together less than 1e-10 of a turn
    if any(
        abs(float(ratio) * first / period - 1) * max(ratio.numerator, ratio.denominator) > 2e-11
        for ratio, period in zip(ratios, periods, strict=True)
    ):
        return None
    common = lcm(*(ratio.denominator for ratio in ratios))
    return first * lcm(*(int(ratio * common) for ratio in ratios)) / common
