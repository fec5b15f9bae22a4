"""Transfer functions of many fingers from the drive to a linear quantity, with real poles."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Any

import numpy as np

from electrovib.solve.population.together.arrays import Column, flat
from electrovib.solve.population.together.refusal import NotTogetherError

if TYPE_CHECKING:
    from electrovib.core.arrays import Complex, Real


@dataclass(frozen=True, eq=False, kw_only=True)
class Transfers:
    """H(s) = slope s + direct + sum residue/(s + rate), and a free part sum free exp(-rate t), of each finger.

    Parameters
    ----------
    rates : ndarray, shape (modes, fingers)
        Minus the poles, >= 0 [1/s].
    residues : ndarray, shape (modes, fingers)
        In the unit of the quantity per volt and second.
    direct, slope : float or ndarray, shape (fingers,)
        Response at infinite frequency, and to the rate of change of the drive.
    free : ndarray, shape (modes, fingers), or None
        Amplitudes at time 0 of the response to initial charge; None without charge.
    base, share : Transfers and float or ndarray, shape (fingers,)
        Quantity of which this one is a multiple, and the factor; None and 1 for no other.

    Notes
    -----
    Only operations on each finger by itself are used, so that a row does not depend on the others, to the last bit.
    """

    __array_ufunc__ = None  # a column times a transfer function is a transfer function

    rates: Real
    residues: Real
    direct: Any = 0.0
    slope: Any = 0.0
    free: Real | None = None
    base: Transfers | None = None
    share: Any = 1.0

    def __add__(self, other: Transfers) -> Transfers:
        """Return the sum; transfer functions of one stack have common modes."""
        self._refuse_other_modes(other)
        free = self.free
        if other.free is not None:
            free = other.free if free is None else free + other.free
        return Transfers(
            rates=self.rates,
            residues=self.residues + other.residues,
            direct=self.direct + other.direct,
            slope=self.slope + other.slope,
            free=free,
        )

    def __sub__(self, other: Transfers) -> Transfers:
        """Return the difference."""
        return self + other.times(-1.0)

    def times(self, factor: Column) -> Transfers:
        """Return the product with a number, or with a column of one number for each finger [any unit]."""
        if isinstance(factor, Transfers):
            raise NotTogetherError("the force law multiplies two responses with relaxations")
        share = flat(factor) if isinstance(factor, np.ndarray) else float(factor)
        return Transfers(
            rates=self.rates,
            residues=self.residues * share,
            direct=self.direct * share,
            slope=self.slope * share,
            free=None if self.free is None else self.free * share,
            base=self if self.base is None else self.base,
            share=self.share * share,
        )

    def __mul__(self, factor: Column) -> Transfers:
        """Return the product with a number, or with a column of one number for each finger."""
        return self.times(factor)

    __rmul__ = __mul__

    def under(self, factor: Column) -> Transfers:
        """Return the response to a drive times a factor, 1 or shape (fingers, 1); that to charge stays the same."""
        return replace(self.without_charge().times(factor), free=self.free)

    def without_charge(self) -> Transfers:
        """Return the response to the drive alone."""
        return replace(self, free=None)

    def __truediv__(self, divisor: Column) -> Transfers:
        """Return the quotient by a number or a column."""
        return self.times(1 / divisor)

    def __neg__(self) -> Transfers:
        """Return the opposite."""
        return self.times(-1.0)

    def at(self, frequency: float) -> Complex:
        """Return the forced part at one frequency [Hz], shape (fingers,)."""
        angular = 2 * np.pi * frequency
        real = np.zeros(self.residues.shape[1:]) + self.direct
        imaginary = np.zeros(self.residues.shape[1:]) + angular * self.slope
        for rates, residues in zip(self.rates, self.residues, strict=True):
            size = rates * rates + angular * angular
            share = residues / np.where(size > 0, size, 1.0)  # the drive does not excite trapped charge
            real = real + share * rates
            imaginary = imaginary - share * angular
        return np.asarray(real + 1j * imaginary)

    def _refuse_other_modes(self, other: Transfers) -> None:
        if self.rates is not other.rates:
            raise NotTogetherError("the force law adds responses with different relaxations")
