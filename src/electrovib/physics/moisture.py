"""Moisture of the finger: one number that sets the conduction of skin and gap and the friction."""

from __future__ import annotations

from typing import Annotated, Any, ClassVar

from electrovib.core.model import Model
from electrovib.core.quantity import Number, Quantity

_CONDUCTANCE = Quantity("S/m2", 1e-9, 1e6, "conductance of the skin per area")
_RESISTIVITY = Quantity("ohm m", 1e-3, 1e18, "resistivity of the medium in the gap")
_COEFFICIENT = Quantity("1", 0, 100, "coefficient of friction")


class Moisture(Model):
    """Moisture of a finger, from dry to wet.

    Notes
    -----
    The conductance of the skin goes from 2 to 20 uS/cm2, the skin conductance levels of palmar skin as quoted by another
    source. For the resistivity of the gap and for friction no source of dry and wet values could be read: they have to be
    given. Conductance and resistivity are interpolated geometrically, the coefficient of friction linearly. Occlusion over
    time, menisci and their attraction are not modelled.
    """

    equation: ClassVar[dict[str, str]] = {
        "skin_conductivity": "thickness*dry_skin_conductance**(1 - level)*wet_skin_conductance**level",
        "gap_resistivity": "dry_gap_resistivity**(1 - level)*wet_gap_resistivity**level",
        "coefficient": "dry_coefficient*(1 - level) + wet_coefficient*level",
    }
    example: ClassVar[dict[str, Any]] = {
        "level": 0.5,
        "dry_gap_resistivity": 1e12,
        "wet_gap_resistivity": 1e6,
        "dry_coefficient": 0.4,
        "wet_coefficient": 0.8,
    }

    level: Annotated[Number, Quantity("1", 0, 1, "moisture of the finger, 0 for dry and 1 for wet")]
    dry_gap_resistivity: Annotated[Number, _RESISTIVITY]
    wet_gap_resistivity: Annotated[Number, _RESISTIVITY]
    dry_coefficient: Annotated[Number, _COEFFICIENT]
    wet_coefficient: Annotated[Number, _COEFFICIENT]
    dry_skin_conductance: Annotated[Number, _CONDUCTANCE] = 0.02
    wet_skin_conductance: Annotated[Number, _CONDUCTANCE] = 0.2

    def skin_conductivity(self, thickness: float) -> float:
        """Return the conductivity of the stratum corneum.

        Parameters
        ----------
        thickness : float
            Thickness of the stratum corneum [m].

        Returns
        -------
        conductivity : float
            Conductivity of the stratum corneum [S/m].
        """
        between: float = self.dry_skin_conductance ** (1 - self.level) * self.wet_skin_conductance**self.level
        return thickness * between

    def gap_resistivity(self) -> float:
        """Resistivity of the medium in the gap [ohm m]."""
        between: float = self.dry_gap_resistivity ** (1 - self.level) * self.wet_gap_resistivity**self.level
        return between

    def coefficient(self) -> float:
        """Coefficient of friction, dimensionless."""
        return self.dry_coefficient * (1 - self.level) + self.wet_coefficient * self.level
