"""Compliance of an elastic half-space under normal pressure, homogeneous or covered by one film.

A pressure p cos(q x) without friction gives the displacement C(q) p cos(q x). Two bodies that touch have the sum of their
compliances: skin with its stratum corneum, a polymer on metal.
"""

from __future__ import annotations

from abc import abstractmethod
from collections.abc import Mapping
from typing import Annotated, Any, ClassVar

import numpy as np
from numpy.typing import ArrayLike

from electrovib.core.arrays import Real
from electrovib.core.model import Model
from electrovib.core.quantity import Number, Quantity


class ElasticBody(Model, family=True):
    """An elastic body that is bent where it is pressed, larger than the waves of its roughness."""

    @abstractmethod
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
        """


class Elastic(ElasticBody):
    """A homogeneous isotropic elastic half-space.

    Examples
    --------
    >>> f"{ev.Elastic(modulus=1e6).compliance(1e4):.3g}"
    '1.5e-10'
    """

    equation: ClassVar[Mapping[str, str]] = {"compliance": "2*(1 - poisson**2)/(modulus*wavenumber)"}
    example: ClassVar[Mapping[str, Any]] = {"modulus": 1e6}

    modulus: Annotated[Number, Quantity("Pa", 1e-3, 1e18, "Young's modulus")]
    poisson: Annotated[
        Number,
        Quantity(
            "1", 0, 0.5, "Poisson's ratio; 0.5 keeps the volume", "skin and rubber are nearly incompressible"
        ),
    ] = 0.5

    @property
    def shear(self) -> float:
        """Shear modulus [Pa]."""
        return self.modulus / (2 * (1 + self.poisson))

    def compliance(self, wavenumber: ArrayLike) -> Real:
        """Return the displacement of a pressure wave over the pressure [m/Pa], at wave numbers [1/m]."""
        found: Real = (1 - self.poisson) / (self.shear * np.asarray(wavenumber, dtype=float))
        return found


class Coated(ElasticBody):
    """An elastic film that is bonded to an elastic half-space, such as the stratum corneum on the tissue below.

    Notes
    -----
    The compliance is that of the film alone times (1 + 4 b x e - a b e^2)/(1 - (a + b + 4 b x^2) e + a b e^2), x = q t and
    e = exp(-2 x), from the stresses and displacements that are continuous across the bond: that of the lower half-space for
    x = 0.

    Examples
    --------
    >>> skin = ev.Coated(film=ev.Elastic(modulus=1e8), thickness=20e-6, below=ev.Elastic(modulus=1e5))
    >>> f"{skin.compliance(1e6):.2g}, {skin.compliance(1e2):.2g}"
    '1.5e-14, 1.5e-07'
    """

    example: ClassVar[Mapping[str, Any]] = {
        "film": {"modulus": 1e8},
        "thickness": 2e-5,
        "below": {"modulus": 1e5},
    }

    film: Elastic
    thickness: Annotated[Number, Quantity("m", 0, 1e3, "thickness of the film")]
    below: Elastic

    def compliance(self, wavenumber: ArrayLike) -> Real:
        """Return the displacement of a pressure wave over the pressure [m/Pa], at wave numbers [1/m]."""
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
