"""The family of drives."""

from __future__ import annotations

from abc import abstractmethod

import numpy as np
from numpy.typing import ArrayLike

from electrovib.core.model import Model
from electrovib.physics.drive.parts import Part, Real


class Drive(Model, family=True):
    """A voltage over time, off before time 0 when it starts from rest.

    Notes
    -----
    A drive is a sum of parts in closed form, so that a solver can be exact; `voltage` is their sum.
    """

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
        return np.sum([part.value(times) for part in self.parts()], axis=0)

    def slope(self, time: ArrayLike) -> Real:
        """Rate of change of the voltage just after these times [V/s]; jumps are not in it."""
        times = np.asarray(time, dtype=float)
        return np.sum([part.slope(times) for part in self.parts()], axis=0)
