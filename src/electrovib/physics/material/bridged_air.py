"""A gap bridged in places by sweat or by real contact: conduction and attraction act on different areas."""

from __future__ import annotations

from typing import TYPE_CHECKING, Annotated, Any, ClassVar, Self

from electrovib.core.arrays import Complex
from electrovib.core.quantity import Number, Quantity
from electrovib.physics.debye_sum import DebyeSum
from electrovib.physics.material.base import Material
from electrovib.physics.material.relaxations import Constant

if TYPE_CHECKING:
    from collections.abc import Mapping

    from numpy.typing import ArrayLike


class BridgedAir(Material):
    """Air with conducting bridges in parallel: conduction and attraction act on different shares of the area.

    Notes
    -----
    For a layer of thickness g the admittance per area is (1 - phi) s eps0/g + phi G, G = spot_conductivity/g:
    parallel, not in series. The field attracts on the share 1 - phi only. The capacitance of the bridges is neglected, and
    the charge that they conduct spreads along the faces at once. A homogeneous leaky gap, `Constant` with a conductivity,
    is another medium.
    """

    equation: ClassVar[Mapping[str, str]] = {"bound_permittivity": "1 - bridged_share"}
    example: ClassVar[Mapping[str, Any]] = {"bridged_share": 0.01, "spot_conductivity": 1e-6}

    bridged_share: Annotated[Number, Quantity("1", 1e-9, 0.999, "share of the area that bridges cover")]
    spot_conductivity: Annotated[Number, Quantity("S/m", 0, 1e3, "conductivity of a bridge")]

    @property
    def conductivity(self) -> float:
        """Conductivity of the whole layer [S/m]: that of the bridges on their share."""
        return self.bridged_share * self.spot_conductivity

    @property
    def pulling_share(self) -> float:
        """Share of the area without a bridge."""
        return 1 - self.bridged_share

    def conducting(self, conductivity: float) -> Self:
        """Return the same layer with bridges of another conductivity, so that the whole layer has this one [S/m]."""
        return self.model_copy(update={"spot_conductivity": conductivity / self.bridged_share})

    def bound_permittivity(self, frequency: ArrayLike) -> Complex:
        """Relative permittivity of the bound charge alone: that of the air on its share."""
        return Constant(permittivity=1.0).bound_permittivity(frequency) * (1 - self.bridged_share)

    def debye(self) -> DebyeSum:
        """Return the sum without any relaxation."""
        return DebyeSum(1 - self.bridged_share, (), ())
