"""Compliance of an elastic half-space under normal pressure, homogeneous or covered by one film.

A pressure p cos(q x) without friction gives the displacement C(q) p cos(q x). Two bodies that touch have the sum of their
compliances: skin with its stratum corneum, a polymer on metal.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from electrovib.core.arrays import Real
from electrovib.core.errors import InputError
from electrovib.core.mistakes import shown
from electrovib.core.units import read_numbers


@dataclass(frozen=True, kw_only=True)
class Elastic:
    """A homogeneous isotropic elastic half-space.

    Parameters
    ----------
    modulus : float
        Young's modulus [Pa], above 0.
    poisson : float
        Poisson's ratio, from 0 to 0.5, the default, which keeps the volume.

    Raises
    ------
    InputError
        If a number is outside its range.

    Examples
    --------
    >>> f"{ev.Elastic(modulus=1e6).compliance(1e4):.3g}"
    '1.5e-10'
    """

    modulus: float
    poisson: float = 0.5

    def __post_init__(self) -> None:
        """Refuse what is no elastic solid."""
        read_numbers(self, modulus="Pa", poisson="1")
        if not 1e-3 <= self.modulus < np.inf:
            raise InputError(
                f"modulus = {self.modulus}: Young's modulus is finite and at least 1e-3 Pa, for instance 1e6 Pa"
            )
        if not 0 <= self.poisson <= 0.5:
            raise InputError(f"poisson = {self.poisson}: Poisson's ratio is from 0 to 0.5, for instance 0.5")

    @property
    def shear(self) -> float:
        """Shear modulus [Pa]."""
        return self.modulus / (2 * (1 + self.poisson))

    def compliance(self, wavenumber: ArrayLike) -> Real:
        """Return the displacement of a pressure wave over the pressure: 2 (1 - nu^2)/(E q).

        Parameters
        ----------
        wavenumber : array_like
            Wave numbers q [1/m], above 0, any shape.

        Returns
        -------
        compliance : ndarray, same shape
            Displacement over pressure [m/Pa].
        """
        found: Real = (1 - self.poisson) / (self.shear * np.asarray(wavenumber, dtype=float))
        return found


@dataclass(frozen=True, kw_only=True)
class Coated:
    """An elastic film that is bonded to an elastic half-space, such as the stratum corneum on the tissue below.

    Parameters
    ----------
    film : Elastic
        Of the film.
    thickness : float
        Of the film [m], 0 or more.
    below : Elastic
        Of the half-space.

    Raises
    ------
    InputError
        If the thickness is outside its range.

    Examples
    --------
    >>> skin = ev.Coated(film=ev.Elastic(modulus=1e8), thickness=20e-6, below=ev.Elastic(modulus=1e5))
    >>> f"{skin.compliance(1e6):.2g}, {skin.compliance(1e2):.2g}"
    '1.5e-14, 1.5e-07'
    """

    film: Elastic
    thickness: float
    below: Elastic

    def __post_init__(self) -> None:
        """Refuse a thickness that is none."""
        read_numbers(self, thickness="m")
        for name in ("film", "below"):
            if not isinstance(getattr(self, name), Elastic):
                raise InputError(
                    f"{name} = {shown(getattr(self, name))}: an Elastic is expected, for instance Elastic(modulus=1e6)"
                )
        if not 0 <= self.thickness < np.inf:
            raise InputError(f"thickness = {self.thickness}: a film is 0 or more thick, for instance 20e-6 m")

    def compliance(self, wavenumber: ArrayLike) -> Real:
        """Return the displacement of a pressure wave over the pressure.

        Parameters
        ----------
        wavenumber : array_like
            Wave numbers q [1/m], above 0, any shape.

        Returns
        -------
        compliance : ndarray, same shape
            Displacement over pressure [m/Pa].

        Notes
        -----
        That of the film alone times (1 + 4 b x e - a b e^2)/(1 - (a + b + 4 b x^2) e + a b e^2), x = q t and e = exp(-2 x), from
        the stresses and displacements that are continuous across the bond: that of the lower half-space for x = 0.
        """
        reach = np.asarray(wavenumber, dtype=float) * self.thickness
        ratio = self.film.shear / self.below.shear
        upper, lower = 3 - 4 * self.film.poisson, 3 - 4 * self.below.poisson
        a = (ratio * lower - upper) / (1 + ratio * lower)
        b = (ratio - 1) / (ratio + upper)
        fade = np.exp(-2 * reach)
        above = 1 + 4 * b * reach * fade - a * b * fade**2
        under = 1 - (a + b + 4 * b * reach**2) * fade + a * b * fade**2
        found: Real = self.film.compliance(wavenumber) * above / under
        return found
