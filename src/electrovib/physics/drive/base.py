"""The family of drives."""

from __future__ import annotations

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

    from electrovib.physics.drive.parts import Part, Real


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
        total: Real = np.sum([part.value(times) for part in self.parts()], axis=0)
        return total

    def slope(self, time: ArrayLike) -> Real:
        """Rate of change of the voltage just after these times [V/s]; jumps are not in it."""
        times = np.asarray(time, dtype=float)
        total: Real = np.sum([part.slope(times) for part in self.parts()], axis=0)
        return total


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
